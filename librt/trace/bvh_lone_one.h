/* One ray by itself (bvh_lone.h) as a caller gives it: through the scene's own triangles, into instances and through what is in
 * them. */
#ifndef RTI_BVH_LONE_ONE_H
#define RTI_BVH_LONE_ONE_H

#include "bvh_lone_walk.h"

/* Are a group's parts, where there are shapes, met in vectors? */
RTI_VEC int lone_shapes_fit(const rtk_group *g)
{
    for (rtk_u32 k = 0u; k < g->part_count && g->shape_count != 0u; k++)
        if (!lone_tree(&g->parts[k].bvh))
            return 0;
    return 1;
}

/* Does a scene hold nothing but triangles and shapes of its own, and instances that have bounds? */
RTI_VEC int lone_fits(const rtk_scene *scene)
{
    const rtk_group *g = scene->groups;
    return scene->unbounded_count == 0u && g->plane_count == 0u && lone_shapes_fit(g) && (g->flags & RTK_GROUP_PLAIN);
}

/* A ray as it comes: of four lanes three count. */
typedef struct lone_given {
    rti_f4 org, inv;
    float most; /* the component of the direction that is the greatest, by size */
} lone_given;

/* Order of axes by which components of |dir| are greater than others: x than y, x than z, y than z, a bit each (rtk_ray_prepare);
 * and where a block's rows of them begin. */
typedef struct lone_order {
    int32_t axes[4];
    rtk_u32 row[4];
} lone_order;
#define ORDER(x, y, z)                                                                                                           \
    {                                                                                                                            \
        {x, y, z, 3},                                                                                                            \
        {                                                                                                                        \
            (x) * sizeof(float[RTK_BVH_BLOCK]), (y) * sizeof(float[RTK_BVH_BLOCK]), (z) * sizeof(float[RTK_BVH_BLOCK]), 0u       \
        }                                                                                                                        \
    }
#define X ORDER(1, 2, 0)
#define Y ORDER(2, 0, 1)
#define Z ORDER(0, 1, 2)
static const lone_order lone_orders[8] = {Z, Z, Z, X, Y, Y, Y, X};
static const int32_t lone_left[4] = {0, 0, 1, 3}, lone_right[4] = {1, 2, 2, 3};
#undef ORDER
#undef X
#undef Y
#undef Z

/* Three lanes less than nothing by as much. */
RTI_VEC rti_f4 lone_less(rti_f4 a)
{
    const rti_f4 all = -a;
    return (rti_f4){all[0], all[1], all[2], a[3]};
}

/* What is asked of a ray whatever it meets, but for `most`. Returns the lanes in which its direction is not too great. */
RTI_VEC rti_m4 lone_receive(lone *l, const rtk_scene *scene, const rti_ray *ray, lone_given *g)
{
    const rti_f4 dir = rti_f4_load(ray->dir), top = rti_f4_set(RTK_INV_MAX);
    g->org = rti_f4_load(ray->org);
    g->inv = rti_f4_min(rti_f4_max(rti_f4_set(1.0f) / dir, -top), top); /* rtk_inverse: what it calls zero is clamped here */
    l->scene = scene;
    l->ray = ray;
    l->outer = 0.0f;
    return rti_f4_le(rti_f4_abs(dir), rti_f4_set(RTK_DIR_MAX));
}

/* A ray made ready, but for what a group and its parts bring. Returns as that. */
RTI_VEC rti_m4 lone_start(lone *l, const rtk_scene *scene, const rti_ray *ray, lone_given *g)
{
    const rti_f4 left = rti_f4_abs(rti_f4_take(ray->dir, lone_left)), right = rti_f4_abs(rti_f4_take(ray->dir, lone_right));
    const lone_order *order = &lone_orders[rti_m4_bits(rti_f4_lt(right, left)) & 7u];
    const rti_f4 along = rti_f4_take(ray->dir, order->axes), shear = along / rti_f4_set(along[2]);
    rti_f4_store(l->less, lone_less(rti_f4_take(ray->org, order->axes)));
    rti_f4_store(l->dir, along);
    memcpy(l->row, order->row, sizeof l->row);
    l->sx = shear[0];
    l->sy = shear[1];
    g->most = along[2];
    return lone_receive(l, scene, ray, g);
}

/* But for that, is it one that may hit anything? */
RTI_VEC int lone_ranged(const rti_ray *ray, const lone_given *g)
{
    return rtk_fabs(g->most) >= RTK_DIR_MIN && ray->tmin < ray->tmax;
}

/* 0: its direction or range is not valid. (An origin that is not is far away from every part.) */
RTI_VEC int lone_begin(lone *l, const rtk_scene *scene, const rti_ray *ray, lone_given *g)
{
    return lone_all(lone_start(l, scene, ray, g)) && lone_ranged(ray, g);
}

/* As that, of a ray that meets no triangles before the top level: for it the order of axes is not found. */
RTI_VEC int lone_begin_top(lone *l, const rtk_scene *scene, const rti_ray *ray, lone_given *g)
{
    const rti_f4 dir = rti_f4_load(ray->dir), size = rti_f4_abs(dir);
    g->most = rtk_max(rtk_max(size[0], size[1]), size[2]);
    rti_f4_store(l->less, rti_f4_load(ray->org)); /* the range alone is asked for, */
    rti_f4_store(l->dir, dir);                    /* likewise */
    return lone_all(lone_receive(l, scene, ray, g)) && lone_ranged(ray, g);
}

_Static_assert(offsetof(rtk_part, lo) == 0 && offsetof(rtk_part, hi) == 12 && offsetof(rtk_part, scale) == 24,
               "a part's corners can be loaded with what stands behind them");

RTI_VEC void lone_slab(const lone_given *g, rti_f4 lo, rti_f4 hi, float *t0, float *t1) /* rtk_slab */
{
    const rti_f4 a = (lo - g->org) * g->inv, b = (hi - g->org) * g->inv, in = rti_f4_min(a, b), out = rti_f4_max(a, b);
    *t0 = rtk_max(rtk_max(in[0], in[1]), in[2]);
    *t1 = rtk_min(rtk_min(out[0], out[1]), out[2]);
}

/* The lanes in which a ray starts near a box; if it does in all, its origin stays. far: |org|. */
RTI_VEC rti_m4 lone_near(rti_f4 far, float scale)
{
    return rti_f4_le(far, rti_f4_set(RTK_FAR * scale));
}

/* rtk_ray_approach, the fourth lanes of which do not count. */
RTI_VEC int lone_approach(rti_f4 dir, rti_f4 lo, rti_f4 hi, float scale, rti_f4 *org, float *shift)
{
    const rti_f4 size = rti_f4_abs(dir), mid = rti_f4_set(0.5f) * (lo + hi), split = rti_f4_set(4097.0f);
    const float m = rtk_max(rtk_max(size[0], size[1]), size[2]);
    const rti_f4 d = dir / rti_f4_set(m), square = d * d, cd = split * dir, dh = cd - (cd - dir), dl = dir - dh;
    const float dd = square[0] + square[1] + square[2];
    for (rtk_u32 k = 0u; k < 6u && !lone_all(lone_near(rti_f4_abs(*org), scale)); k++) {
        const rti_f4 f = (mid - *org) * d;
        const float step = (f[0] + f[1] + f[2]) / dd / m;
        const rti_f4 t = rti_f4_set(step), p = t * dir, ct = split * t, th = ct - (ct - t), tl = t - th; /* rtk_ff_along */
        const rti_f4 e = ((th * dh - p) + th * dl + tl * dh) + tl * dl, s = *org + p, b = s - *org;
        *org = s + (((*org - (s - b)) + (p - b)) + e);
        *shift += step;
    }
    return rtk_finite((*org)[0] + (*org)[1] + (*org)[2]) && rtk_finite(*shift) && lone_all(lone_near(rti_f4_abs(*org), scale));
}

/* Its way through a part from which it starts far away (rtk_ray_prepare): as lone_part. */
RTI_APART int lone_part_moved(lone *l, rtk_u32 mode, const lone_given *g, const rtk_part *part, const rtk_tree *tree)
{
    const float *box = (const float *)(const void *)part, tmin = l->less[3], tmax = l->dir[3];
    const rti_f4 lo = rti_f4_load(box), hi = rti_f4_load(box + 3), given = rti_f4_load(l->less);
    lone_given moved = *g;
    float org[4], t0, t1, shift = 0.0f;
    int end;
    if (!lone_approach(rti_f4_load(l->ray->dir), lo, hi, part->scale, &moved.org, &shift))
        return 0;
    lone_slab(&moved, lo, hi, &t0, &t1);
    if (!(t0 <= t1) || shift + t1 < tmin || shift + t0 > tmax)
        return 0;
    if (shift == 0.0f || !lone_ready(l, tree, part->scale, moved.org, rti_f4_load(l->ray->dir), g->inv))
        return -1;
    rti_f4_store(org, moved.org);
    for (rtk_u32 k = 0u; k < 3u; k++)
        l->less[k] = -org[l->row[k] / (rtk_u32)sizeof(float[RTK_BVH_BLOCK])];
    l->part = part;
    l->shift = shift;
    l->t = l->best.t;
    l->far = rtk_min(tmax, l->t);
    l->t0 = t0;
    l->t1 = t1;
    end = t0 <= lone_end(l, 1) && lone_walk(l, mode);
    rti_f4_store(l->less, given);
    return end;
}

/* Does a ray that starts far away from a box pass it for certain (rtk_ray_passes)? far: |org|. */
RTI_VEC int lone_passes(const lone *l, const lone_given *g, rti_f4 far, rti_f4 lo, rti_f4 hi, float scale)
{
    const rti_f4 grow = rti_f4_set(RTK_PASSES * (rtk_max(rtk_max(far[0], far[1]), far[2]) + scale));
    float t0, t1;
    lone_slab(g, lo - grow, hi + grow, &t0, &t1);
    return t1 < t0 || (t1 < 0.0f && l->less[3] >= 0.0f);
}

/* Its way through a part: 1 or 0 as lone_walk, or -1: it must go another way. */
RTI_VEC int lone_part(lone *l, rtk_u32 mode, const lone_given *g, const rtk_part *part, const rtk_tree *tree)
{
    const float *box = (const float *)(const void *)part;
    const rti_f4 far = rti_f4_abs(g->org), lo = rti_f4_load(box), hi = rti_f4_load(box + 3);
    const float tmin = l->less[3], tmax = l->dir[3];
    float t0, t1;
    if (!lone_tree(tree))
        return -1;
    if (__builtin_expect(!lone_all(lone_near(far, part->scale)), 0))
        return lone_passes(l, g, far, lo, hi, part->scale) ? 0 : lone_part_moved(l, mode, g, part, tree);
    lone_slab(g, lo, hi, &t0, &t1);
    if (!(t0 <= t1) || t1 < tmin || t0 > tmax)
        return 0;
    if (!lone_ready(l, tree, part->scale, g->org, rti_f4_load(l->ray->dir), g->inv))
        return -1;
    l->part = part;
    l->t = l->best.t;
    l->far = rtk_min(rtk_min(t1, tmax), l->t);
    l->t0 = rtk_max(t0, tmin);
    l->shift = 0.0f;
    if (l->outer != 0.0f) { /* there is no range of the ray's own */
        l->far = l->t;
        l->t1 = t1;
        return t0 <= lone_end(l, 1) && lone_walk(l, mode);
    }
    return l->t0 <= l->far && lone_walk(l, mode);
}

/* A ray through a scene that is one mesh (RTK_SCENE_MESH), as lone_part, up to where it walks: 1; 0: it meets nothing; -1: it must go
 * another way. What seldom is so is asked at once. */
RTI_VEC int lone_mesh(lone *l, rtk_u32 mode, const rtk_scene *scene, const rti_ray *ray)
{
    const rtk_group *group = scene->groups;
    const rtk_part *part = group->parts;
    const float *box = (const float *)(const void *)part, tmin = ray->tmin, tmax = ray->tmax;
    float t0, t1;
    lone_given g;
    rti_m4 fit = lone_start(l, scene, ray, &g);
    fit = rti_m4_and(fit, lone_near(rti_f4_abs(g.org), part->scale));
    lone_turn_to(l, &part->bvh, part->scale, g.org, g.inv); /* it fits: the part's scale is ordinary */
    if (__builtin_expect(!lone_all(fit) || !(rtk_fabs(g.most) >= RTK_DIR_MIN) || ray->mask == 0u || l->places == 0u, 0))
        return -1;
    lone_slab(&g, rti_f4_load(box), rti_f4_load(box + 3), &t0, &t1);
    l->inst = RTK_INVALID;
    if (!(mode & RTK_MODE_ANY))
        lone_keep(l, tmax, 0.0f, 0.0f, RTK_INVALID, RTK_INVALID);
    t0 = rtk_max(t0, tmin); /* NaN where tmin is, as t1 where tmax is; and where tmin = tmax no t lies between */
    t1 = rtk_min(t1, tmax);
    if (!(t0 <= t1))
        return 0;
    l->group = group;
    l->part = part;
    l->t = tmax;
    l->far = t1;
    l->t0 = t0;
    l->shift = 0.0f;
    return 1;
}

/* Its way through a group whose parts are of one builder, from its best hit on: as lone_part. */
RTI_VEC int lone_parts(lone *l, rtk_u32 mode, const lone_given *given, const rtk_group *g)
{
    int end = 0;
    l->group = g;
    if (g->part_count == 1u) /* nothing is kept for another */
        return lone_part(l, mode, given, g->parts, &g->parts->bvh);
    for (rtk_u32 k = 0u; k < g->part_count && end == 0; k++)
        end = lone_part(l, mode, given, &g->parts[k], &g->parts[k].bvh);
    return end;
}

/* ---- instances ---- */

/* rtk_instance_ray; the ray's mask is the instance's, too. */
RTI_VEC void lone_turn(rti_ray *to, const rti_ray *from, const rtk_scene *scene, const rtk_instance *inst, float time)
{
    const float *m = inst->to_object.m;
    if (inst->flags & RTK_INST_MOVING) {
        rtk_vec3 org = rtk_v3(from->org[0], from->org[1], from->org[2]), dir = rtk_v3(from->dir[0], from->dir[1], from->dir[2]);
        rtk_motion_ray(scene->motions, inst, time, &org, &dir);
        rti_f4_store(to->org, (rti_f4){org.x, org.y, org.z, from->tmin});
        rti_f4_store(to->dir, (rti_f4){dir.x, dir.y, dir.z, from->tmax});
    } else {
        const rti_f4 rows[4] = {rti_f4_load(m), rti_f4_load(m + 4), rti_f4_load(m + 8), rti_f4_set(0.0f)};
        rti_f4 by[4];
        rti_f4_turn(rows, by);
        rti_f4 org = by[0] * rti_f4_set(from->org[0]) + by[1] * rti_f4_set(from->org[1]) + by[2] * rti_f4_set(from->org[2]) + by[3];
        rti_f4 dir = by[0] * rti_f4_set(from->dir[0]) + by[1] * rti_f4_set(from->dir[1]) + by[2] * rti_f4_set(from->dir[2]);
        org[3] = from->tmin; /* each is stored as it will be loaded */
        dir[3] = from->tmax;
        rti_f4_store(to->org, org);
        rti_f4_store(to->dir, dir);
    }
    to->mask = from->mask & inst->mask;
}

/* A ray through an instance which it sees: as lone_part. *best is its best hit, before and behind; outer: what the top level moved
 * its origin by. */
RTI_VEC int lone_instance(const rtk_scene *scene, rtk_u32 mode, const rti_ray *ray, float time, const rtk_instance *inst,
                          float outer, rtk_hit *best)
{
    const rtk_group *g = &scene->groups[inst->group];
    lone_given given;
    rti_ray own;
    lone l;
    int end;
    if (!(g->flags & RTK_GROUP_PLAIN) || (inst->flags & RTK_INST_UNBOUNDED))
        return -1;
    lone_turn(&own, ray, scene, inst, time);
    if (outer != 0.0f) {
        own.tmin = -RTK_INF;
        own.tmax = RTK_INF;
    }
    if (!lone_begin(&l, scene, &own, &given))
        return 0;
    l.inst = inst->id;
    l.outer = outer;
    l.low = ray->tmin;
    l.high = ray->tmax;
    if (mode & RTK_MODE_ANY)
        l.best.t = ray->tmax;
    else
        l.best = *best;
    end = lone_parts(&l, mode, &given, g);
    if (!(mode & RTK_MODE_ANY) && end == 0)
        *best = l.best;
    return end;
}

/* Ready for the top level, or 0: the ray misses it, or -1: it must go another way. Where it starts far away, *moved becomes the ray
 * that instances meet. */
RTI_VEC int lone_top_ready(lone *l, const lone_given *g, const rtk_scene *s, const rtk_tree *tree, rti_ray *moved)
{
    const rti_f4 lo = {s->top_lo.x, s->top_lo.y, s->top_lo.z}, hi = {s->top_hi.x, s->top_hi.y, s->top_hi.z};
    const rti_f4 far = rti_f4_abs(g->org);
    const float tmin = l->less[3], tmax = l->dir[3];
    lone_given at = *g;
    float t0, t1, shift = 0.0f;
    if (!(s->top_lo.x <= s->top_hi.x))
        return 0;
    if (!lone_all(lone_near(far, s->top_scale))) {
        if (lone_passes(l, g, far, lo, hi, s->top_scale) ||
            !lone_approach(rti_f4_load(l->ray->dir), lo, hi, s->top_scale, &at.org, &shift))
            return 0;
        if (shift == 0.0f)
            return -1;
    }
    lone_slab(&at, lo, hi, &t0, &t1);
    if (!(t0 <= t1) || shift + t1 < tmin || shift + t0 > tmax)
        return 0;
    if (!lone_ready(l, tree, s->top_scale, at.org, rti_f4_load(l->ray->dir), g->inv))
        return -1;
    l->t = l->best.t;
    l->far = l->t;
    l->t0 = t0;
    l->t1 = t1;
    l->shift = shift;
    if (shift == 0.0f) {
        l->far = rtk_min(rtk_min(t1, tmax), l->t);
        l->t0 = rtk_max(t0, tmin);
        return l->t0 <= l->far;
    }
    at.org[3] = tmin;
    rti_f4_store(moved->org, at.org);
    rti_f4_store(moved->dir, rti_f4_load(l->ray->dir));
    moved->mask = l->ray->mask;
    l->ray = moved;
    return t0 <= lone_end(l, 1);
}

#endif
