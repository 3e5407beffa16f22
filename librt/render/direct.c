/* Light that comes straight from the scene's lights to the lit points. */
#include "direct.h"
#include "lanes.h"

/* Below this the whole queue waits for more rays before it is answered: small batches cost a tracer as much as half-full ones. */
#define FLUSH_PART 2u

static void forget(rti_worker *worker)
{
    worker->lit_count = 0;
    worker->lit_shiny = worker->lit_smooth = false;
}

void rti_light_all(rti_worker *worker)
{
    for (uint32_t i = 0; i < worker->frame->scene->light_count && !rti_cancelled(worker->frame->cancel); i++) {
        worker->frame->lanes->shine(worker, i);
        if (worker->frame->scene->light_count > 1 && worker->shadows.count >= worker->shadows.capacity / FLUSH_PART)
            rti_shadow_flush(worker);
    }
    forget(worker);
}

void rti_light_one(rti_worker *worker)
{
    worker->frame->lanes->one(worker);
    forget(worker);
}

void rti_light_around(rti_worker *worker)
{
    worker->frame->lanes->around(worker);
    forget(worker);
}
