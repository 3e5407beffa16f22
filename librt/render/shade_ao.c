/* Ambient occlusion: the share of a cosine-weighted hemisphere of radius ao_distance that is free. */
#include "shade.h"

void rti_shade_ao(struct rti_worker *worker, uint32_t first, uint32_t count)
{
    rti_sheaves(worker, first, count, worker->frame->lanes->ao);
}
