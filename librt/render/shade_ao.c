/* Ambient occlusion: the share of a cosine-weighted hemisphere of radius ao_distance that is free. */
#include "shade.h"

static void note(rti_worker *w, rti_sheaf *c)
{
    const rtk_vec3 none = {0.0f, 0.0f, 0.0f};
    for (uint32_t k = 0; k < c->count; k++) {
        rti_point p = rti_sheaf_point(w, c, k);
        rti_lit_add(w, c->ray[k], &p.s, rtk_neg(p.ray.dir), p.state.tp, none, 0.0f, 0.0f);
    }
}

void rti_shade_ao(struct rti_worker *worker, uint32_t first, uint32_t count)
{
    rti_sheaves(worker, first, count, note);
}
