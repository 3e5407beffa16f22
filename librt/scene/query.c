/* Ray queries of a scene, and what is at a hit. */
#include <string.h>

#include "../kernel/surface.h"
#include "../kernel/texture.h"
#include "../trace/trace.h"
#include "../trace/turn.h"
#include "arrays.h"
#include "parts.h"

uint32_t rti_snapshot_tree(const rti_snapshot *snapshot)
{
    return snapshot->tracer->tree;
}

void rti_rays_gather(const rt_context *ctx, const rt_ray *rays, uint32_t count, rtk_trace_block *out)
{
    rti_turn_at(rti_context_isa(ctx))->rays(rti_ray_at(rays), count, out);
}

static rt_hit hit_at(const rtk_hit_block *b, uint32_t k)
{
    return (rt_hit){b->t[k], b->u[k], b->v[k], b->prim[k], b->geom[k], b->inst[k]};
}

static void put_hit(rtk_hit_block *b, uint32_t k, const rt_hit *h)
{
    b->t[k] = h->t;
    b->u[k] = h->u;
    b->v[k] = h->v;
    b->prim[k] = h->prim_id;
    b->geom[k] = h->geom_id;
    b->inst[k] = h->inst_id;
}

/* The snapshot for a call of so many rays: held, or for a few of them as long as the call stays. */
typedef struct visit {
    rti_snapshot *snapshot;
    uint32_t token;
    bool few;
} visit;

static visit visit_begin(const rt_scene *scene, size_t count)
{
    visit v = {NULL, 0, count < RTI_ARRAYS_ALONE};
    if (v.few)
        v.token = rti_cell_enter((rti_cell *)(uintptr_t)&scene->cell,
                                 &v.snapshot); /* counting readers is not what const promises against */
    else
        v.snapshot = rti_scene_snapshot(scene);
    return v;
}

static void visit_end(const rt_scene *scene, visit v)
{
    if (v.few)
        rti_cell_leave((rti_cell *)(uintptr_t)&scene->cell, v.token);
    else
        rti_snapshot_release(v.snapshot);
}

void rt_scene_intersect_at(const rt_scene *scene, const rt_ray *rays, const float *times, rt_hit *hits, size_t count)
{
    const visit v = visit_begin(scene, count);
    const rti_snapshot *s = v.snapshot;
    if (s)
        rti_arrays_intersect(s, s->tracer, rays, times, hits, count, RTI_ARRAYS_GUESS);
    for (size_t i = 0; !s && i < count; i++)
        hits[i] = (rt_hit){rays[i].tmax, 0.0f, 0.0f, RT_INVALID_ID, RT_INVALID_ID, RT_INVALID_ID};
    visit_end(scene, v);
}

void rt_scene_intersect(const rt_scene *scene, const rt_ray *rays, rt_hit *hits, size_t count)
{
    rt_scene_intersect_at(scene, rays, NULL, hits, count);
}

void rt_scene_occluded_at(const rt_scene *scene, const rt_ray *rays, const float *times, uint8_t *occluded, size_t count)
{
    const visit v = visit_begin(scene, count);
    const rti_snapshot *s = v.snapshot;
    if (s)
        rti_arrays_occluded(s, s->tracer, rays, times, occluded, count, RTI_ARRAYS_GUESS);
    else if (count > 0)
        memset(occluded, 0, count);
    visit_end(scene, v);
}

void rt_scene_occluded(const rt_scene *scene, const rt_ray *rays, uint8_t *occluded, size_t count)
{
    rt_scene_occluded_at(scene, rays, NULL, occluded, count);
}

size_t rt_scene_intersect_all_at(const rt_scene *scene, const rt_ray *ray, float time, rt_hit *hits, size_t capacity)
{
    rti_snapshot *s = rti_scene_snapshot(scene);
    rti_fpenv env = rti_fp_enter();
    rti_scratch scratch = {.times = &time};
    rt_hit last = {ray->tmin, 0.0f, 0.0f, RT_INVALID_ID, RT_INVALID_ID, RT_INVALID_ID};
    size_t n = 0;
    _Alignas(64) rtk_trace_block in;
    _Alignas(64) rtk_hit_block out;
    rti_rays_gather(scene->ctx, ray, 1, &in);
    while (s && n < capacity) {
        put_hit(&out, 0, &last);
        s->tracer->intersect(&s->view, &in, &out, 1, RTI_TRACE_AFTER, &scratch);
        last = hit_at(&out, 0);
        if (last.prim_id == RT_INVALID_ID)
            break;
        hits[n++] = last;
    }
    rti_fp_leave(env);
    rti_snapshot_release(s);
    return n;
}

size_t rt_scene_intersect_all(const rt_scene *scene, const rt_ray *ray, rt_hit *hits, size_t capacity)
{
    return rt_scene_intersect_all_at(scene, ray, 0.0f, hits, capacity);
}

/* ---- surface ---- */

/* A hit may be the caller's own invention, or of another snapshot: every id is held against this one. */
static bool hit_exists(const rtk_scene *v, const rt_hit *h)
{
    const rtk_group *group = &v->groups[0];
    if (h->prim_id == RT_INVALID_ID)
        return false;
    if (h->inst_id != RT_INVALID_ID) {
        if (h->inst_id >= v->instance_count)
            return false;
        group = &v->groups[v->instances[h->inst_id].group];
    }
    return h->geom_id < group->geom_count && h->prim_id < group->geoms[h->geom_id].prim_count;
}

static rt_vec3 public_vec(rtk_vec3 a)
{
    return (rt_vec3){a.x, a.y, a.z};
}

/* 0, or 1 + index of the child's group whose material it is. */
static uint32_t material_scene(const rti_snapshot *s, uint32_t material)
{
    uint32_t k = s->group_count - 1;
    while (k > 0 && material < s->groups[k].material_base)
        k--;
    return k;
}

static rt_vec3 surface_color(const rtk_scene *v, const rtk_surface *at)
{
    const rtk_material *m = &v->materials[at->material];
    float rgba[4] = {1.0f, 1.0f, 1.0f, 1.0f};
    if (m->color_tex != RTK_INVALID)
        rtk_texture_sample(v->textures[m->color_tex], at->u, at->v, 0.0f, rgba);
    return (rt_vec3){m->color[0] * rgba[0] * at->tint.x, m->color[1] * rgba[1] * at->tint.y, m->color[2] * rgba[2] * at->tint.z};
}

void rti_snapshot_surface(const rti_snapshot *s, const rt_ray *ray, float time, const rt_hit *hit, rt_surface *out)
{
    rtk_ray r = {rti_vec(ray->org), rti_vec(ray->dir), ray->tmin, ray->tmax, ray->mask};
    rtk_hit h = {hit->t, hit->u, hit->v, hit->prim_id, hit->geom_id, hit->inst_id};
    rtk_surface at;
    memset(out, 0, sizeof *out);
    out->material.id = RT_INVALID_ID;
    if (!hit_exists(&s->view, hit))
        return;
    at = rtk_surface_at(&s->view, r, h, time);
    out->position = public_vec(at.p);
    out->ng = public_vec(at.ng);
    out->ns = public_vec(at.ns);
    out->u = at.u;
    out->v = at.v;
    out->material_scene = material_scene(s, at.material);
    out->material.id = at.material - (out->material_scene ? s->groups[out->material_scene].material_base : 0u);
    out->face_id = at.face;
    out->user_id = at.user_id;
    out->inst_user_id = at.inst_user_id;
    out->color = surface_color(&s->view, &at);
    out->position_error = at.error;
}

void rt_scene_surface_at(const rt_scene *scene, const rt_ray *ray, float time, const rt_hit *hit, rt_surface *surface)
{
    rti_snapshot *s = rti_scene_snapshot(scene);
    rti_fpenv env = rti_fp_enter();
    memset(surface, 0, sizeof *surface);
    surface->material.id = RT_INVALID_ID;
    if (s)
        rti_snapshot_surface(s, ray, time, hit, surface);
    rti_fp_leave(env);
    rti_snapshot_release(s);
}

void rt_scene_surface(const rt_scene *scene, const rt_ray *ray, const rt_hit *hit, rt_surface *surface)
{
    rt_scene_surface_at(scene, ray, 0.0f, hit, surface);
}
