/* Classic ray tracing (paper 000; Whitted 1980): every hit asks all lights and sends a mirror ray and a refracted ray on. The
 * rays of what is transparent; the rest stands in lanes_whitted.c. */
#include "lanes.h"
#include "shade.h"

void rti_send_classic(rti_worker *w, const rti_point *p)
{
    const rtk_material *m = p->material;
    rtk_vec3 tp = p->state.tp, bent = {0.0f, 0.0f, 0.0f};
    float mirror = m->reflectiveness;
    bool crosses = m->transparency > 0.0f && rti_bend(p, &bent);
    if (m->transparency > 0.0f && !crosses)
        mirror += m->transparency;
    rti_push_mirror(w, p, rtk_scale(tp, mirror));
    if (crosses)
        rti_push_refracted(w, p, bent, rtk_mul(tp, rtk_crossing(m, p->color)));
}

void rti_shade_whitted(struct rti_worker *worker, uint32_t first, uint32_t count)
{
    rti_sheaves(worker, first, count, worker->frame->lanes->whitted);
}
