/* Path tracing. Each hit asks one light, chosen by power, and goes on by one lobe of the classic material: diffuse, mirror or
 * refraction, chosen by the largest component of what each would keep. Against `whitted`: the ambient term is left out, for the
 * light between surfaces that it stands for is computed; the highlight is light from the lights alone, as there.
 *
 * A spherical light whose body is visible can be met by a diffuse ray too. With inverse-square falloff both ways are weighed by
 * the balance heuristic (Veach, Guibas 1995); without falloff such a light has no radiance of its own, and only asking counts.
 *
 * Russian roulette draws from the path's own key, so a path's end does not depend on when it is looked at.
 *
 * Here is a point by itself: lanes_path.c does the same for sheaves in which nothing is transparent. */
#include "../kernel/lights.h"
#include "shade.h"

/* Weights of the lobes at a point; total is their sum. */
typedef struct lobes {
    rtk_vec3 diffuse, crossing;
    float mirror;
    float diffuse_share, mirror_share, crossing_share, total;
    rtk_vec3 bent; /* direction of the crossing */
} lobes;

static lobes lobes_at(const rti_point *p)
{
    const rtk_material *m = p->material;
    lobes l;
    l.diffuse = rtk_scale(p->color, m->diffusion);
    l.mirror = m->reflectiveness;
    l.crossing = rtk_v3(0.0f, 0.0f, 0.0f);
    l.bent = l.crossing;
    if (m->transparency > 0.0f) {
        if (rti_bend(p, &l.bent))
            l.crossing = rtk_crossing(m, p->color);
        else
            l.mirror += m->transparency;
    }
    l.diffuse_share = rtk_maxabs(l.diffuse);
    l.mirror_share = l.mirror;
    l.crossing_share = rtk_maxabs(l.crossing);
    l.total = l.diffuse_share + l.mirror_share + l.crossing_share;
    return l;
}

/* Weight of meeting a light's body by chance: as a diffuse ray of that pdf which started at org. */
static float meeting_weight(const rti_frame *f, rtk_hit hit, rtk_vec3 org, float pdf)
{
    const rtk_light *l;
    uint32_t light = f->light_of_geom && hit.inst == RTK_INVALID ? f->light_of_geom[hit.geom] : RTK_INVALID;
    if (light == RTK_INVALID || pdf < 0.0f)
        return 1.0f;
    l = &f->scene->lights[light];
    if (!(l->falloff > 0.0f))
        return 0.0f;
    return pdf / (pdf + l->select_pdf * rtk_light_pdf(l, org));
}

/* The chosen lobe's ray. seed, place: of the vertex' random numbers; pick: which lobe; survive: the probability of going on,
 * which is made up for. */
static void go_on(rti_worker *w, const rti_point *p, const lobes *l, uint32_t seed, uint32_t place, float pick, float survive)
{
    rtk_vec3 tp = rtk_scale(p->state.tp, 1.0f / survive), dir;
    float at = pick * l->total;
    if (at < l->diffuse_share) {
        rtk_uv u = rtk_random2_at(seed, place, RTK_DIM_BSDF_U);
        float probability = l->diffuse_share / l->total, cosine;
        rti_ray_state child;
        dir = rtk_cosine_direction(p->s.ns, u);
        cosine = rtk_dot3(dir, p->s.ns);
        if (!(cosine > 0.0f) || !(rtk_dot3(dir, p->s.ng) > 0.0f))
            return;
        tp = rtk_mul(tp, rtk_scale(l->diffuse, 1.0f / probability));
        child = rti_child(p, RTK_KIND_DIFFUSE, tp, probability * rtk_cosine_pdf(cosine));
        child.spread = rtk_max(child.spread, RTI_DIFFUSE_SPREAD);
        rti_push(w, rtk_surface_leave(p->s, dir), dir, RT_MASK_DIFFUSE, &child);
    } else if (at < l->diffuse_share + l->mirror_share) {
        rti_push_mirror(w, p, rtk_scale(tp, l->mirror * l->total / l->mirror_share));
    } else {
        rti_push_refracted(w, p, l->bent, rtk_mul(tp, rtk_scale(l->crossing, l->total / l->crossing_share)));
    }
}

static void shade_classic(rti_worker *w, uint32_t i, const rti_point *p)
{
    const rti_frame *f = w->frame;
    const rtk_material *m = p->material;
    lobes l = lobes_at(p);
    bool ends = p->state.depth >= f->set.desc.max_depth || !(l.total > 0.0f);
    float survive = 1.0f;
    float pick = 0.0f;
    rti_lit_add(w, i, &p->s, rtk_neg(p->ray.dir), rtk_mul(p->state.tp, l.diffuse), rtk_scale(p->state.tp, m->specular),
                m->shininess, ends ? 0.0f : l.diffuse_share / l.total);
    if (ends)
        return;
    const uint32_t seed = rti_vertex_seed(f, &p->state), place = rtk_shuffled(seed, p->state.sample, RTK_DIM_LOBE);
    if (p->state.depth + 1 >= f->set.roulette_from) { /* numbers of one group with RTK_DIM_BSDF_U */
        survive = rtk_clamp(rtk_maxabs(p->state.tp) * l.total, RTI_SURVIVE_MIN, RTI_SURVIVE_MAX);
        if (!(rtk_unit_float(rtk_scrambled(seed, place, RTK_DIM_ROULETTE)) < survive))
            return;
    }
    if (l.diffuse_share < l.total)
        pick = rtk_unit_float(rtk_scrambled(seed, place, RTK_DIM_LOBE));
    go_on(w, p, &l, seed, place, pick, survive);
}

void rti_path_classic(rti_worker *w, const rti_sheaf *c, uint32_t k)
{
    const rti_point p = rti_sheaf_point(w, c, k);
    shade_classic(w, c->ray[k], &p);
}

void rti_path_meet(rti_worker *w, const rti_sheaf *c, uint32_t k)
{
    const rti_point p = rti_sheaf_point(w, c, k);
    const float weight = meeting_weight(w->frame, rti_hit_at(w->hits, c->ray[k]), p.ray.org, p.state.pdf);
    rti_add(w, p.state.home, rtk_mul(p.state.tp, rtk_scale(rti_emission(p.material), weight)));
}

void rti_shade_path(struct rti_worker *worker, uint32_t first, uint32_t count)
{
    rti_sheaves(worker, first, count, worker->frame->lanes->path);
}
