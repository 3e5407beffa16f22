/* A ray's way through a scene, the same for every tracer: the scene's own planes and geometry, instances without bounds, then the
 * top level's tree over the other instances with a walk of the group inside each.
 *
 * Template. The including file defines
 *   RTK_MODE       constant of RTK_MODE_* bits
 *   RTK_NAME(x)    name of this instance's functions
 *   RTK_WALK_INL   file of the walk; RTK_TREE, RTK_TOP_TREE: members of part and scene that hold its trees
 * and gets RTK_NAME(trace)(query). Returns 1 when a walk ended early (any-hit: occluded); else query->best is the answer.
 */
#define RTK_WALK RTK_NAME(group_walk)
#define RTK_PRIM rtk_query_prim
#include RTK_WALK_INL
#undef RTK_WALK
#undef RTK_PRIM

/* The group of an instance, or the scene's own: `ray` is in its space, and its t begins at q->outer. */
RTK_FN int RTK_NAME(group)(rtk_query *q, rtk_ray ray)
{
    RT_GLOBAL const rtk_group *g = q->group;
    rtk_u32 i, n = g->part_count;
    rtk_pray r;
    for (i = 0u; i < n; i++) {
        RT_GLOBAL const rtk_part *p = &g->parts[i];
        if (rtk_ray_prepare_here(ray, p->lo, p->hi, p->scale, &r) && RTK_NAME(group_walk)(q, p->RTK_TREE, p->count, &r, q->outer))
            return 1;
    }
    return 0;
}

/* The origin is the given one, or where the top level moved it (then t begins at outer, and the range is checked behind the leaf
 * test). */
RTK_FN int RTK_NAME(instance)(rtk_query *q, rtk_u32 index, rtk_vec3 org, float outer)
{
    RT_GLOBAL const rtk_instance *inst = &q->scene->instances[index];
    rtk_ray ray = q->ray;
    q->mask = ray.mask & inst->mask;
    q->inst = inst->id;
    q->material = inst->material;
    q->group = &q->scene->groups[inst->group];
    q->outer = outer;
    if (q->mask == 0u)
        return 0;
    ray.org = org;
    rtk_instance_ray(q->scene->motions, inst, q->time, &ray.org, &ray.dir);
    if (outer != 0.0f) {
        ray.tmin = -RTK_INF;
        ray.tmax = RTK_INF;
    }
    if (!rtk_ray_valid(ray))
        return 0;
    if ((inst->flags & RTK_INST_UNBOUNDED) && rtk_query_planes(q, RTK_MODE, ray))
        return 1;
    return RTK_NAME(group)(q, ray);
}

/* A reference of the top level; r is the ray as prepared for it. */
RTK_FN int RTK_NAME(top_ref)(rtk_query *q, rtk_u32 mode, const rtk_pray *r, rtk_u32 ref)
{
    (void)mode;
    if (q->scene->instances[ref].flags & RTK_INST_UNBOUNDED)
        return 0;
    return RTK_NAME(instance)(q, ref, r->org, r->tshift);
}

#define RTK_WALK RTK_NAME(top_walk)
#define RTK_PRIM RTK_NAME(top_ref)
#include RTK_WALK_INL
#undef RTK_WALK
#undef RTK_PRIM

/* All instances. */
RTK_FN int RTK_NAME(instances)(rtk_query *q)
{
    const rtk_scene *s = q->scene;
    rtk_pray top;
    rtk_u32 i;
    for (i = 0u; i < s->unbounded_count; i++)
        if (RTK_NAME(instance)(q, s->unbounded[i], q->ray.org, 0.0f))
            return 1;
    if (!(s->top_lo.x <= s->top_hi.x) || !rtk_ray_prepare(q->ray, s->top_lo, s->top_hi, s->top_scale, &top))
        return 0;
    return RTK_NAME(top_walk)(q, s->RTK_TOP_TREE, s->instance_count, &top, 0.0f);
}

RTK_FN int RTK_NAME(trace)(rtk_query *q)
{
    if (!rtk_ray_valid(q->ray))
        return 0;
    return rtk_query_planes(q, RTK_MODE, q->ray) || RTK_NAME(group)(q, q->ray) || RTK_NAME(instances)(q);
}
