/* Both integrators of the classic material for one hit, as their formulas are read, with branches: what lanes are held against.
 */
#ifndef SHADE_ALONE_H
#define SHADE_ALONE_H

#include "kernel/sampling.h"
#include "kernel_alone.h"
#include "render/shade.h"
#include "wave_push.h"

static uint32_t lamps_met; /* hits of what shines */

/* What the random numbers of a ray share. */
static uint32_t vertex_seed(const rti_frame *frame, const rti_ray_state *state)
{
    rtk_key key = {state->key_lo, state->key_hi};
    return rtk_vertex_seed(frame->seed, state->pixel, key);
}

typedef struct point {
    rtk_ray ray;
    rti_ray_state state;
    rtk_surface s; /* turned to the ray; its point, normals, error and material */
    const rtk_material *material;
    rtk_vec3 color;
    float footprint; /* width of the ray's cone here */
    bool outside;    /* the ray comes from where the geometric normal points */
} point;

/* Lane k of a sheaf. */
static point point_of(const rti_worker *w, const rti_sheaf *c, uint32_t k)
{
    point p;
    p.ray = rti_batch_ray(w, c->ray[k]);
    p.state = rti_batch_state(w, c->ray[k]);
    memset(&p.s, 0, sizeof p.s);
    p.s.p = rtk_v3(c->px[k], c->py[k], c->pz[k]);
    p.s.ng = rtk_v3(c->gx[k], c->gy[k], c->gz[k]);
    p.s.ns = rtk_v3(c->nx[k], c->ny[k], c->nz[k]);
    p.s.error = c->error[k];
    p.s.material = c->material[k];
    p.material = &w->frame->scene->materials[c->material[k]];
    p.color = rtk_v3(c->cr[k], c->cg[k], c->cb[k]);
    p.footprint = c->footprint[k];
    p.outside = c->outside[k] != 0;
    return p;
}

static void put_row3(rti_worker *w, uint32_t row, uint32_t i, rtk_vec3 x)
{
    float *to = w->lit + (size_t)row * w->lit_stride + i;
    to[0] = x.x;
    to[w->lit_stride] = x.y;
    to[2 * (size_t)w->lit_stride] = x.z;
}

static void lit_add(rti_worker *worker, uint32_t ray, const rtk_surface *s, rtk_vec3 view, rtk_vec3 k, rtk_vec3 specular,
                    float shininess, float diffuse_pdf)
{
    uint32_t i = worker->lit_count;
    if (rtk_maxabs(k) == 0.0f && rtk_maxabs(specular) == 0.0f)
        return;
    worker->lit_count = i + 1;
    put_row3(worker, RTI_LIT_PX, i, s->p);
    put_row3(worker, RTI_LIT_NX, i, s->ns);
    put_row3(worker, RTI_LIT_GX, i, s->ng);
    put_row3(worker, RTI_LIT_VX, i, view);
    put_row3(worker, RTI_LIT_KR, i, k);
    put_row3(worker, RTI_LIT_SR, i, specular);
    worker->lit[(size_t)RTI_LIT_ERROR * worker->lit_stride + i] = s->error;
    worker->lit[(size_t)RTI_LIT_SHININESS * worker->lit_stride + i] = shininess;
    worker->lit[(size_t)RTI_LIT_DIFFUSE_PDF * worker->lit_stride + i] = diffuse_pdf;
    worker->lit_ray[i] = ray;
    worker->lit_home[i] = worker->batch.home[ray / RTK_BLOCK].home[ray % RTK_BLOCK];
}

/* The state of a ray of this kind that goes on from p; no two of one point are of one kind. */
static rti_ray_state child_of(const point *p, uint32_t kind, rtk_vec3 tp, float pdf)
{
    rti_ray_state s = p->state;
    rtk_key parent = {s.key_lo, s.key_hi}, key = rtk_key_child(parent, kind);
    s.key_lo = key.lo;
    s.key_hi = key.hi;
    s.tp = tp;
    s.kind = kind;
    s.depth = p->state.depth + 1;
    s.width = p->footprint;
    s.pdf = pdf;
    return s;
}

/* Sends the mirror ray and the refracted ray of p on; either throughput may be too small to be followed. */
static void push_mirror(rti_worker *w, const point *p, rtk_vec3 tp)
{
    rti_ray_state child;
    rtk_vec3 dir;
    if (!(rtk_maxabs(tp) >= RTI_THROUGHPUT_MIN))
        return;
    child = child_of(p, RTK_KIND_REFLECT, tp, -1.0f);
    dir = rtk_mirror(p->ray.dir, p->s.ns, p->s.ng);
    push(w, rtk_surface_leave(p->s, dir), dir, RT_MASK_REFLECTION, &child);
}

static void push_refracted(rti_worker *w, const point *p, rtk_vec3 dir, rtk_vec3 tp, float pdf)
{
    rti_ray_state child;
    if (!(rtk_maxabs(tp) >= RTI_THROUGHPUT_MIN))
        return;
    child = child_of(p, RTK_KIND_REFRACT, tp, pdf);
    child.eta = p->outside ? rtk_index_of(p->material) : 1.0f;
    push(w, rtk_surface_leave(p->s, dir), dir, RT_MASK_REFRACTION, &child);
}

/* Unit direction d through a surface whose unit normal n looks against it. false: total internal reflection. */
static bool refract(rtk_vec3 d, rtk_vec3 n, float ratio, rtk_vec3 *out)
{
    float c = -rtk_dot3(d, n), k = 1.0f - ratio * ratio * rtk_max(0.0f, 1.0f - c * c);
    if (k < 0.0f)
        return false;
    *out = rtk_unit(rtk_madd(rtk_scale(d, ratio), ratio * c - rtk_sqrt(k), n));
    return true;
}

/* Refracted direction of p; false: total internal reflection. A direction that the shading normal bends back above the surface is
 * bent by the geometric one. */
static bool bend(const point *p, rtk_vec3 *dir)
{
    float index = rtk_index_of(p->material), ratio = p->outside ? 1.0f / index : index;
    if (!refract(p->ray.dir, p->s.ns, ratio, dir))
        return false;
    return rtk_dot3(*dir, p->s.ng) < 0.0f || refract(p->ray.dir, p->s.ng, ratio, dir);
}

/* Weights of the lobes at a point; total is their sum. */
typedef struct lobes {
    rtk_vec3 diffuse, crossing;
    float mirror;
    float diffuse_share, mirror_share, crossing_share, total;
    rtk_vec3 bent; /* direction of the crossing */
} lobes;

static lobes lobes_at(const point *p)
{
    const rtk_material *m = p->material;
    lobes l;
    l.diffuse = rtk_scale(p->color, m->diffusion);
    l.mirror = m->reflectiveness;
    l.crossing = rtk_v3(0.0f, 0.0f, 0.0f);
    l.bent = l.crossing;
    if (m->transparency > 0.0f) {
        if (bend(p, &l.bent))
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
    const uint32_t light = f->light_of_geom && hit.inst == RTK_INVALID ? f->light_of_geom[hit.geom] : RTK_INVALID;
    if (light == RTK_INVALID || pdf < 0.0f)
        return 1.0f;
    return pdf == 0.0f ? 0.0f : rtk_light_meeting(&f->scene->lights[light], org, pdf);
}

/* Of a refracted ray: what meets a light that was asked for straight through the body counts no second time. */
static float bent_pdf(const rti_frame *f, const point *p)
{
    const bool stops = f->set.desc.shadows && p->material->flags & RTK_MAT_OPAQUE_SHADOW;
    return f->asks_through && !(p->state.pdf < 0.0f) && !stops ? 0.0f : -1.0f;
}

/* The chosen lobe's ray. of_vertex, place: of the vertex' random numbers; pick: which lobe; survive: the probability of going on,
 * which is made up for. */
static void go_on(rti_worker *w, const point *p, const lobes *l, uint32_t of_vertex, uint32_t place, float pick, float survive)
{
    rtk_vec3 tp = rtk_scale(p->state.tp, 1.0f / survive), dir;
    float at = pick * l->total;
    if (at < l->diffuse_share) {
        rtk_uv u = rtk_random2_at(of_vertex, place, RTK_DIM_BSDF_U);
        float probability = l->diffuse_share / l->total, cosine;
        rti_ray_state child;
        dir = rtk_cosine_direction(p->s.ns, u);
        cosine = rtk_dot3(dir, p->s.ns);
        if (!(cosine > 0.0f) || !(rtk_dot3(dir, p->s.ng) > 0.0f))
            return;
        tp = rtk_mul(tp, rtk_scale(l->diffuse, 1.0f / probability));
        child = child_of(p, RTK_KIND_DIFFUSE, tp, w->frame->asks_through ? 0.0f : probability * rtk_cosine_pdf(cosine));
        child.spread = rtk_max(child.spread, RTK_DIFFUSE_SPREAD);
        push(w, rtk_surface_leave(p->s, dir), dir, RT_MASK_DIFFUSE, &child);
    } else if (at < l->diffuse_share + l->mirror_share) {
        push_mirror(w, p, rtk_scale(tp, l->mirror * l->total / l->mirror_share));
    } else {
        push_refracted(w, p, l->bent, rtk_mul(tp, rtk_scale(l->crossing, l->total / l->crossing_share)), bent_pdf(w->frame, p));
    }
}

static void path_classic(rti_worker *w, uint32_t i, const point *p)
{
    const rti_frame *f = w->frame;
    const rtk_material *m = p->material;
    lobes l = lobes_at(p);
    bool ends = p->state.depth >= f->set.desc.max_depth || !(l.total > 0.0f), alone = ends || f->asks_through;
    float survive = 1.0f;
    float pick = 0.0f;
    lit_add(w, i, &p->s, rtk_neg(p->ray.dir), rtk_mul(p->state.tp, l.diffuse), rtk_scale(p->state.tp, m->specular), m->shininess,
            alone ? 0.0f : l.diffuse_share / l.total);
    if (ends)
        return;
    const uint32_t of_vertex = vertex_seed(f, &p->state), place = rtk_shuffled(of_vertex, p->state.sample, RTK_DIM_LOBE);
    if (p->state.depth + 1 >= f->set.roulette_from) { /* numbers of one group with RTK_DIM_BSDF_U */
        survive = rtk_clamp(rtk_maxabs(p->state.tp) * l.total, RTI_SURVIVE_MIN, RTI_SURVIVE_MAX);
        if (!(rtk_unit_float(rtk_scrambled(of_vertex, place, RTK_DIM_ROULETTE)) < survive))
            return;
    }
    if (l.diffuse_share < l.total)
        pick = rtk_unit_float(rtk_scrambled(of_vertex, place, RTK_DIM_LOBE));
    go_on(w, p, &l, of_vertex, place, pick, survive);
}

static void paths_alone(rti_worker *w, rti_sheaf *c)
{
    for (uint32_t k = 0; k < c->count; k++) {
        point p = point_of(w, c, k);
        if (p.material->type == RTK_MATERIAL_EMISSIVE) {
            lamps_met++;
            float weight = meeting_weight(w->frame, rti_hit_at(w->hits, c->ray[k]), p.ray.org, p.state.pdf);
            rti_add(w, p.state.home, rtk_mul(p.state.tp, rtk_scale(rti_emission(p.material), weight)));
        } else {
            path_classic(w, c->ray[k], &p);
        }
    }
}

static void send_classic(rti_worker *w, const point *p)
{
    const rtk_material *m = p->material;
    rtk_vec3 tp = p->state.tp, bent = {0.0f, 0.0f, 0.0f};
    float mirror = m->reflectiveness;
    bool crosses = m->transparency > 0.0f && bend(p, &bent);
    if (m->transparency > 0.0f && !crosses)
        mirror += m->transparency;
    push_mirror(w, p, rtk_scale(tp, mirror));
    if (crosses)
        push_refracted(w, p, bent, rtk_mul(tp, rtk_crossing(m, p->color)), -1.0f);
}

/* Whitted's: what the ambient light shows, a point for the lights, and what is sent on. */
static void whitted_alone(rti_worker *w, rti_sheaf *c)
{
    const rtk_world *world = w->frame->scene->world;
    for (uint32_t k = 0; k < c->count; k++) {
        point p = point_of(w, c, k);
        const rtk_material *m = p.material;
        if (m->type == RTK_MATERIAL_EMISSIVE) {
            lamps_met++;
            rti_add(w, p.state.home, rtk_mul(p.state.tp, rti_emission(m)));
            continue;
        }
        const rtk_vec3 tinted = rtk_mul(p.state.tp, p.color);
        rti_add(w, p.state.home,
                rtk_mul(rtk_scale(tinted, m->ambient), rtk_v3(world->ambient[0], world->ambient[1], world->ambient[2])));
        lit_add(w, c->ray[k], &p.s, rtk_neg(p.ray.dir), rtk_scale(tinted, m->diffusion), rtk_scale(p.state.tp, m->specular),
                m->shininess, 0.0f);
        if (p.state.depth < w->frame->set.desc.max_depth)
            send_classic(w, &p);
    }
}

#endif
