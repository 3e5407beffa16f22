/* What the integrators that show light share: the surface at a hit, made ready for shading. */
#ifndef RTI_SHADE_H
#define RTI_SHADE_H

#include "../kernel/classic.h"
#include "../kernel/integrate.h"
#include "direct.h"
#include "lanes.h"
#include "shade_limits.h"

typedef struct rti_point {
    rtk_ray ray;
    rti_ray_state state;
    rtk_surface s; /* turned to the ray; its point, normals, error and material */
    const rtk_material *material;
    rtk_vec3 color;
    float footprint; /* width of the ray's cone here */
    bool outside;    /* the ray comes from where the geometric normal points */
} rti_point;

/* Lane k of a sheaf. */
static inline rti_point rti_sheaf_point(const rti_worker *w, const rti_sheaf *c, uint32_t k)
{
    rti_point p;
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

static inline rtk_vec3 rti_emission(const rtk_material *m)
{
    return rtk_v3(m->emission[0], m->emission[1], m->emission[2]);
}

/* The state of a ray of this kind that goes on from p; no two of one point are of one kind. */
static inline rti_ray_state rti_child(const rti_point *p, uint32_t kind, rtk_vec3 tp, float pdf)
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
static inline void rti_push_mirror(rti_worker *w, const rti_point *p, rtk_vec3 tp)
{
    rti_ray_state child;
    rtk_vec3 dir;
    if (!(rtk_maxabs(tp) >= RTI_THROUGHPUT_MIN))
        return;
    child = rti_child(p, RTK_KIND_REFLECT, tp, -1.0f);
    dir = rtk_mirror(p->ray.dir, p->s.ns, p->s.ng);
    rti_push(w, rtk_surface_leave(p->s, dir), dir, RT_MASK_REFLECTION, &child);
}

static inline void rti_push_refracted(rti_worker *w, const rti_point *p, rtk_vec3 dir, rtk_vec3 tp)
{
    rti_ray_state child;
    if (!(rtk_maxabs(tp) >= RTI_THROUGHPUT_MIN))
        return;
    child = rti_child(p, RTK_KIND_REFRACT, tp, -1.0f);
    child.eta = p->outside ? rtk_index_of(p->material) : 1.0f;
    rti_push(w, rtk_surface_leave(p->s, dir), dir, RT_MASK_REFRACTION, &child);
}

/* Refracted direction of p; false: total internal reflection. A direction that the shading normal bends back above the surface is
 * bent by the geometric one. */
static inline bool rti_bend(const rti_point *p, rtk_vec3 *dir)
{
    float index = rtk_index_of(p->material), ratio = p->outside ? 1.0f / index : index;
    if (!rtk_refract(p->ray.dir, p->s.ns, ratio, dir))
        return false;
    return rtk_dot3(*dir, p->s.ng) < 0.0f || rtk_refract(p->ray.dir, p->s.ng, ratio, dir);
}

/* shade_whitted.c: the mirror ray and the refracted ray of the classic material. */
void rti_send_classic(rti_worker *worker, const rti_point *p);

/* shade_path.c: lane k of a sheaf of the classic material; of what shines. */
void rti_path_classic(rti_worker *worker, const rti_sheaf *sheaf, uint32_t k);
void rti_path_meet(rti_worker *worker, const rti_sheaf *sheaf, uint32_t k);

#endif
