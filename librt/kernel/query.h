/* One ray's question to a scene while it is answered: what was asked, where the walk is, the best answer so far; and what a leaf
 * does with a primitive. Shared by all tracers, so that they differ in nothing but the order in which they meet primitives.
 *
 * mode is a constant of the code that is instantiated (scene_trace.inl): no loop tests what a whole batch has in common.
 */
#ifndef RTK_QUERY_H
#define RTK_QUERY_H

#include "alpha.h"
#include "motion.h"
#include "shapes.h"
#include "triangle.h"

#define RTK_MODE_ANY   1u /* any hit will do */
#define RTK_MODE_AFTER 2u /* the first hit behind `after` in the order of hits */
#define RTK_MODE_STEPS 4u /* count nodes, leaves and primitive tests */

typedef struct rtk_query {
    const rtk_scene *scene;
    rtk_ray ray; /* world space, as given */
    float time;  /* of the ray, 0 to 1 */
    rtk_hit best;
    rtk_hit after; /* MODE_AFTER */
    /* Where the walk is. */
    RT_GLOBAL const rtk_group *group;
    rtk_u32 inst;     /* instance id of hits */
    rtk_u32 material; /* the instance's; RTK_INVALID: each geometry's own */
    rtk_u32 mask;     /* of ray and instance */
    float outer;      /* t of a hit = outer + (t that the leaf test gives): the top level's tshift */
    rtk_vec3 top_org; /* origin that instances' rays start from */
    rtk_u32 nodes, leaves, tests;
    rtk_u32 bare; /* the surface parameters of shapes are not asked for */
} rtk_query;

RTK_FN void rtk_query_init(rtk_query *q, const rtk_scene *scene, rtk_ray ray)
{
    q->scene = scene;
    q->ray = ray;
    q->time = 0.0f;
    q->best = rtk_hit_none(ray.tmax);
    q->after = rtk_hit_none(-RTK_INF);
    q->group = scene->groups;
    q->inst = RTK_INVALID;
    q->material = RTK_INVALID;
    q->mask = ray.mask;
    q->outer = 0.0f;
    q->top_org = ray.org;
    q->nodes = 0u;
    q->leaves = 0u;
    q->tests = 0u;
    q->bare = 0u;
}

/* Could a hit at t become the answer? Cheap, before masks and alpha maps are asked. */
RTK_FN int rtk_query_wants(const rtk_query *q, rtk_u32 mode, float t, rtk_u32 geom, rtk_u32 prim)
{
    if (mode & RTK_MODE_ANY)
        return 1;
    if (!rtk_hit_less(t, q->inst, geom, prim, q->best.t, q->best.inst, q->best.geom, q->best.prim))
        return 0;
    return !(mode & RTK_MODE_AFTER) ||
           rtk_hit_less(q->after.t, q->after.inst, q->after.geom, q->after.prim, t, q->inst, geom, prim);
}

/* Is it there for this ray at all? */
RTK_FN int rtk_query_sees(const rtk_query *q, rtk_u32 geom, rtk_u32 prim, rtk_vec3 p, float u, float v)
{
    RT_GLOBAL const rtk_geom *g = &q->group->geoms[geom];
    if (!(g->mask & q->mask))
        return 0;
    return !(g->flags & RTK_GEOM_ALPHA) || rtk_alpha_solid(q->scene, q->group, geom, prim, q->material, p, u, v);
}

RTK_FN void rtk_query_take(rtk_query *q, float t, float u, float v, rtk_u32 geom, rtk_u32 prim)
{
    q->best.t = t;
    q->best.u = u;
    q->best.v = v;
    q->best.prim = prim;
    q->best.geom = geom;
    q->best.inst = q->inst;
}

/* The leaf test of primitive `ref` of the group. Returns 1 when the walk may end: any hit was asked for, and this is one. */
RTK_FN int rtk_query_tri(rtk_query *q, rtk_u32 mode, const rtk_pray *r, RT_GLOBAL const rtk_tri *tri)
{
    float t, u, v;
    if (!rtk_tri_intersect(r, tri, &t, &u, &v))
        return 0;
    if (q->outer != 0.0f) {
        t = q->outer + t;
        if (!(t > q->ray.tmin && t < q->ray.tmax))
            return 0;
    }
    if (!rtk_query_wants(q, mode, t, tri->geom, tri->prim) || !rtk_query_sees(q, tri->geom, tri->prim, r->org, u, v))
        return 0;
    rtk_query_take(q, t, u, v, tri->geom, tri->prim);
    return (mode & RTK_MODE_ANY) != 0u;
}

RTK_COLD int rtk_query_shape(rtk_query *q, rtk_u32 mode, const rtk_pray *r, RT_GLOBAL const rtk_shape *shape)
{
    float roots[4];
    int i, n = rtk_shape_roots(r, shape, roots);
    for (i = 0; i < n; i++) {
        float t = q->outer + roots[i], u = 0.0f, v = 0.0f;
        rtk_vec3 p;
        if (!(t > q->ray.tmin && t < q->ray.tmax) || !rtk_query_wants(q, mode, t, shape->geom, shape->prim))
            continue;
        p = rtk_madd(r->org, roots[i] - r->tshift, r->dir);
        if (q->group->geoms[shape->geom].flags & RTK_GEOM_ALPHA)
            rtk_shape_uv(shape, p, &u, &v);
        if (!rtk_query_sees(q, shape->geom, shape->prim, p, u, v))
            continue;
        rtk_query_take(q, t, u, v, shape->geom, shape->prim);
        return (mode & RTK_MODE_ANY) != 0u; /* roots ascend: the next is farther */
    }
    return 0;
}

/* What an answer still lacks: the surface parameters of a shape, which candidates do not need. They are those of the ray as given,
 * in the shape's space. */
RTK_FN void rtk_query_finish(rtk_query *q)
{
    rtk_hit *h = &q->best;
    rtk_u32 placed = h->inst != RTK_INVALID;
    RT_GLOBAL const rtk_instance *inst = placed ? &q->scene->instances[h->inst] : q->scene->instances; /* NULL where there are none */
    RT_GLOBAL const rtk_group *group = &q->scene->groups[placed ? inst->group : 0u];
    rtk_ray ray = q->ray;
    if (q->bare || h->prim == RTK_INVALID || group->geoms[h->geom].type != RTK_GEOM_SHAPES)
        return;
    if (placed)
        rtk_instance_ray(q->scene->motions, inst, q->time, &ray.org, &ray.dir);
    rtk_shape_uv(&group->shapes[group->geoms[h->geom].first + h->prim], rtk_madd(ray.org, h->t, ray.dir), &h->u, &h->v);
}

/* Spheres that a leaf need not test: the best hit's own, met again in another cell, and those out of the way. Where an origin was moved, the
 * sum that makes t rounds hits together that lie apart here, and all are asked for their order. */
RTK_FN int rtk_query_skips(const rtk_query *q, rtk_u32 mode, const rtk_pray *r, RT_GLOBAL const rtk_shape *shape)
{
    if (shape->type != RTK_SHAPE_SPHERE || q->outer != 0.0f || r->tshift != 0.0f)
        return 0;
    if (!(mode & (RTK_MODE_ANY | RTK_MODE_AFTER)) && shape->prim == q->best.prim && shape->geom == q->best.geom &&
        q->inst == q->best.inst)
        return 1;
    return rtk_sphere_passed(r, shape, q->ray.tmin, q->best.t);
}

RTK_FN int rtk_query_prim(rtk_query *q, rtk_u32 mode, const rtk_pray *r, rtk_u32 ref)
{
    RT_GLOBAL const rtk_shape *shape;
    if (mode & RTK_MODE_STEPS)
        q->tests++;
    if (ref < q->group->tri_count)
        return rtk_query_tri(q, mode, r, &q->group->tris[ref]);
    shape = &q->group->shapes[ref - q->group->tri_count];
    return rtk_query_skips(q, mode, r, shape) ? 0 : rtk_query_shape(q, mode, r, shape);
}

/* The group's planes, against the ray in the group's space as given. */
RTK_FN int rtk_query_planes(rtk_query *q, rtk_u32 mode, rtk_ray ray)
{
    rtk_u32 i;
    for (i = 0u; i < q->group->plane_count; i++) {
        RT_GLOBAL const rtk_shape *plane = &q->group->planes[i];
        float t, u, v;
        if (mode & RTK_MODE_STEPS)
            q->tests++;
        if (!rtk_plane_intersect(ray, plane, &t, &u, &v) || !rtk_query_wants(q, mode, t, plane->geom, plane->prim) ||
            !rtk_query_sees(q, plane->geom, plane->prim, rtk_madd(ray.org, t, ray.dir), u, v))
            continue;
        rtk_query_take(q, t, u, v, plane->geom, plane->prim);
        if (mode & RTK_MODE_ANY)
            return 1;
    }
    return 0;
}

/* May the walk leave out what lies at t0 and beyond along the prepared ray? (ray.h, theory point 4) */
RTK_FN int rtk_query_done(const rtk_query *q, rtk_u32 mode, const rtk_pray *r, float outer, float t0)
{
    return !(mode & RTK_MODE_ANY) && q->best.t < outer + (r->tshift + t0);
}

/* Are all hits up to t1 too near to be the answer? */
RTK_FN int rtk_query_before(const rtk_query *q, rtk_u32 mode, const rtk_pray *r, float outer, float t1)
{
    return (mode & RTK_MODE_AFTER) != 0u && outer + (r->tshift + t1) < q->after.t;
}

#endif
