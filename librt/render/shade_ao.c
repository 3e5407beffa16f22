/* Ambient occlusion: the share of a cosine-weighted hemisphere of radius ao_distance that is free. */
#include "shade.h"

void rti_shade_ao(struct rti_worker *worker, uint32_t first, uint32_t count)
{
    const rtk_vec3 none = {0.0f, 0.0f, 0.0f};
    for (uint32_t i = first; i < first + count; i++) {
        rti_point p;
        if (rti_point_at(worker, i, &p))
            rti_lit_add(worker, i, &p.s, rtk_neg(p.ray.dir), p.state.tp, none, 0.0f, 0.0f);
    }
}
