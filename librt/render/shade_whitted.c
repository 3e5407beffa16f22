/* Classic ray tracing (paper 000; Whitted 1980): every hit asks all lights and sends a mirror ray and a refracted ray on. */
#include "shade.h"

static void shade_classic(rti_worker *w, uint32_t i, const rti_point *p)
{
    const rtk_material *m = p->material;
    const rtk_world *world = w->frame->scene->world;
    rtk_vec3 tp = p->state.tp, tinted = rtk_mul(tp, p->color), bent = {0.0f, 0.0f, 0.0f};
    float mirror = m->reflectiveness;
    bool crosses;
    if (m->ambient > 0.0f)
        rti_add(w, p->state.home,
                rtk_mul(rtk_scale(tinted, m->ambient), rtk_v3(world->ambient[0], world->ambient[1], world->ambient[2])));
    rti_lit_add(w, i, &p->s, rtk_neg(p->ray.dir), rtk_scale(tinted, m->diffusion), rtk_scale(tp, m->specular), m->shininess,
                0.0f);
    if (p->state.depth >= w->frame->set.desc.max_depth)
        return;
    crosses = m->transparency > 0.0f && rti_bend(p, &bent);
    if (m->transparency > 0.0f && !crosses)
        mirror += m->transparency;
    rti_push_mirror(w, p, rtk_scale(tp, mirror));
    if (crosses)
        rti_push_refracted(w, p, bent, rtk_mul(tp, rtk_crossing(m, p->color)));
}

void rti_shade_whitted(struct rti_worker *worker, uint32_t first, uint32_t count)
{
    for (uint32_t i = first; i < first + count; i++) {
        rti_point p;
        if (!rti_point_at(worker, i, &p))
            continue;
        if (p.material->type == RTK_MATERIAL_EMISSIVE)
            rti_add(worker, p.state.home, rtk_mul(p.state.tp, rti_emission(p.material)));
        else
            shade_classic(worker, i, &p);
    }
}
