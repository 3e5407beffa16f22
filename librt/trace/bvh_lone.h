/* One ray by itself through eight-wide nodes, where all there is to ask are triangles in blocks and shapes, of which each hit
 * counts, for hot files: its hits in leaves of triangles (of shapes: bvh_lone_ball.h). The walk is bvh_lone_walk.h, how
 * a caller's ray and an instance's come to it bvh_lone_one.h. What a tree's walk is, bvh_lanes.inl and kernel/bvh.h tell; here
 *
 * boxes are met at plane * inv - org * inv, as in streams and with their proof (bvh_stream.h), children wait in the order in
 * which they are entered, triangles are met a block or two at a time (bvh_lone_step.inl);
 *
 * a hit for certain of which the leaf test's first half doubts where it is, is put aside: beside large triangles, a floor on
 * which the eye stands, that is so of most rays, and the second half takes as long as six nodes. It is decided at the end, in
 * doubles (tri_double.h), or before, when what comes next lies between its bounds;
 *
 * what counts is how many instructions a ray takes: a walk of a dozen nodes and two leaves is some 1500. So the ray stands in
 * memory, from where instructions take what they need, its axes are sorted by tables, and what is rare has functions of its own.
 */
#ifndef RTI_BVH_LONE_H
#define RTI_BVH_LONE_H

#include "bvh_lanes.h"
#include "packet.h"

/* A ray on its way, and its best hit: where late is not RTK_INVALID, that of the triangle at this place; else `best`. far: no hit
 * is looked for behind this. Of a hit that was put aside, t is less than that: its least. Where the origin was moved, all of
 * these are sums with the shift, as the leaf test gives them (kernel/ray.h), and then with what the top level moved it by, outer;
 * t0 and t1, of boxes, are not. */
typedef struct lone {
    /* For leaves. */
    _Alignas(16) float less[4]; /* less the origin, in the order of axes x, y, z of the leaf test; and tmin */
    float dir[4];               /* the direction, likewise; and tmax */
    float sx, sy, scale, shift, outer;
    float low, high; /* where outer is not 0: the given range, of sums with it, too; the ray's own is unbounded */
    float far, t, u, v;
    rtk_u32 late;
    _Alignas(16) rtk_u32 row[4]; /* of a block's vertices: the byte at which the axes' rows begin */
    const rtk_tree *tree;
    const rtk_group *group;
    struct lone_met { /* by the lanes of some blocks */
        float t[NODE_N], u[NODE_N], v[NODE_N], off[NODE_N];
        rtk_u32 certain;
    } met;
    /* For spheres (lone_ball_ready). */
    struct lone_ball {
        _Alignas(16) float org[4], dir[4], unit[4];
        float dd, len, margin;
    } ball;
    /* For nodes: as prepared. */
    _Alignas(16) float inv[4], start[4];
    float t0, t1;
    rtk_u32 back;   /* bits of the axes along which the ray goes down */
    rtk_u32 places; /* of triangles in blocks: leaves that begin behind them hold others */
    /* For what is rare, and the end. */
    const rtk_part *part; /* NULL: q and r are given */
    const rtk_scene *scene;
    const rti_ray *ray; /* of a part, in the group's space: whom the leaf test itself is asked for is made of it when needed */
    rtk_query *q;
    const rtk_pray *r;
    float time;   /* of a ray through the top level */
    rtk_u32 inst; /* of hits here */
    _Alignas(16) rtk_hit best;
    rtk_u32 behind[2];
} lone;

/* Sets `best`, by stores as wide as the loads of who copies it: others would wait until all of it stands in memory. */
RTI_VEC void lone_keep(lone *l, float t, float u, float v, rtk_u32 prim, rtk_u32 geom)
{
    rti_f4_store(&l->best.t, (rti_f4){t, u, v, rtk_float(prim)});
    rti_f4_store((float *)(void *)&l->best.geom, (rti_f4){rtk_float(geom), rtk_float(l->inst), 0.0f, 0.0f});
}
_Static_assert(sizeof(rtk_hit) == 24 && offsetof(rtk_hit, prim) == 12 && offsetof(rtk_hit, geom) == 16 &&
                   offsetof(rtk_hit, inst) == 20 && offsetof(lone, behind) == offsetof(lone, best) + 24,
               "a hit and what stands behind it are two vectors");

RTI_VEC rtk_ray lone_ray(const rti_ray *r)
{
    return (rtk_ray){rtk_v3(r->org[0], r->org[1], r->org[2]), rtk_v3(r->dir[0], r->dir[1], r->dir[2]), r->tmin, r->tmax, r->mask};
}

/* A reference, by the leaf test itself; late is RTK_INVALID. */
RTI_APART int lone_ask_plain(lone *l, rtk_u32 mode, rtk_u32 ref)
{
    rtk_query own;
    rtk_pray prepared;
    rtk_query *q = l->q;
    const rtk_pray *r = l->r;
    int end;
    if (l->part) {
        const rtk_part *part = l->part;
        const rtk_ray ray = lone_ray(l->ray);
        q = &own;
        r = &prepared;
        rtk_query_init(q, l->scene, ray);
        q->group = l->group;
        q->inst = l->inst;
        q->outer = l->outer;
        if (l->outer != 0.0f) {
            q->ray.tmin = l->low;
            q->ray.tmax = l->high;
        }
        if (!rtk_ray_prepare(ray, part->lo, part->hi, part->scale, &prepared))
            return 0; /* never: lone_part and lone_mesh ask the same */
    }
    if (mode & RTK_MODE_ANY) /* of which none is the best */
        return rtk_query_prim(q, mode, r, ref);
    q->best = l->best;
    end = rtk_query_prim(q, mode, r, ref);
    l->best = q->best;
    l->t = q->best.t;
    l->far = rtk_min(l->far, l->t);
    return end;
}

/* The corners of the triangle at a place, in the ray's order of axes. */
RTI_VEC void lone_corners(const lone *l, rtk_u32 place, float v0[3], float v1[3], float v2[3])
{
    const rtk_bvhblock *b = &l->tree->blocks[place / 4u];
    for (rtk_u32 k = 0u; k < 3u; k++) {
        const rtk_u32 axis = l->row[k] / (rtk_u32)sizeof b->v0[0], j = place % 4u;
        v0[k] = b->v0[axis][j];
        v1[k] = b->v1[axis][j];
        v2[k] = b->v2[axis][j];
    }
}

/* The ray up to `end`, for one triangle. */
RTI_VEC rti_tri_pair lone_pair(const lone *l, float end)
{
    return (rti_tri_pair){-l->less[0], -l->less[1], -l->less[2], l->sx, l->sy, l->dir[2], l->shift, l->scale, l->less[3], end};
}

/* A hit that was put aside, in doubles; 0: it is to be asked. */
RTI_APART int lone_decide(lone *l, rtk_u32 place)
{
    const rti_tri_pair pair = lone_pair(l, l->dir[3]);
    float c0[3], c1[3], c2[3], hit[3];
    lone_corners(l, place, c0, c1, c2);
    if (!tri_double_one(&pair, l->dir[0], l->dir[1], c0, c1, c2, hit))
        return 0;
    l->t = hit[0];
    l->u = hit[1];
    l->v = hit[2];
    return 1;
}

/* The best hit is `best`. */
RTI_VEC void lone_settle(lone *l)
{
    const rtk_u32 place = l->late;
    if (place == RTK_INVALID)
        return;
    const rtk_u32 ref = l->tree->refs[place];
    l->late = RTK_INVALID;
    if (l->t < l->far) { /* put aside; nothing is in front of it */
        if (!lone_decide(l, place)) {
            lone_ask_plain(l, 0u, ref);
            return;
        }
        l->far = rtk_min(l->far, l->t);
    }
    if (l->group->geom_count == 1u) { /* a mesh's triangles stand in their order: its record need not be fetched */
        lone_keep(l, l->t, l->u, l->v, ref, 0u);
    } else {
        const rtk_u32 tris = l->group->tri_count;
        if (ref < tris)
            lone_keep(l, l->t, l->u, l->v, l->group->tris[ref].prim, l->group->tris[ref].geom);
        else
            lone_keep(l, l->t, l->u, l->v, l->group->shapes[ref - tris].prim, l->group->shapes[ref - tris].geom);
    }
}

RTI_APART int lone_ask(lone *l, rtk_u32 mode, rtk_u32 ref)
{
    if (!(mode & RTK_MODE_ANY))
        lone_settle(l);
    return lone_ask_plain(l, mode, ref);
}

/* What lone_settle will read of a place. */
RTI_VEC void lone_expect(const lone *l, rtk_u32 place)
{
    const rtk_u32 *ref = &l->tree->refs[place];
    if (l->group->geom_count == 1u)
        __builtin_prefetch(ref);
    else if (*ref < l->group->tri_count)
        __builtin_prefetch(&l->group->tris[*ref].geom);
    else
        __builtin_prefetch(&l->group->shapes[*ref - l->group->tri_count].geom);
}

/* A hit for certain. Returns 1 when the walk may end. */
RTI_VEC int lone_take(lone *l, rtk_u32 mode, rtk_u32 place, float t, float u, float v)
{
    int better = t < l->t;
    if (mode & RTK_MODE_ANY)
        return 1;
    if (t == l->t && !(l->t < l->far) && l->late < RTK_BVH_BLOCK * l->tree->block_count) /* triangles stand in the order of hits */
        better = l->tree->refs[place] < l->tree->refs[l->late];
    else if (!better && (t <= l->far || t == l->t)) /* between the bounds, or as near: the order of hits decides */
        return lone_ask(l, mode, l->tree->refs[place]);
    if (better) {
        l->t = t;
        l->u = u;
        l->v = v;
        l->late = place;
        l->far = rtk_min(l->far, t);
        lone_expect(l, place);
    }
    return 0;
}

/* The triangle at a place, which the leaf test's first half doubts. certain: it is a hit, no farther than `off` from t. */
RTI_APART int lone_doubt(lone *l, rtk_u32 mode, rtk_u32 place, rtk_u32 certain, float t, float off)
{
    const float end = mode & RTK_MODE_ANY ? l->dir[3] : rtk_min(l->dir[3], l->far);
    float within[2] = {t - off, t + off};
    int sure = 1;
    if (!certain) {
        const rti_tri_pair pair = lone_pair(l, end);
        float c0[3], c1[3], c2[3];
        lone_corners(l, place, c0, c1, c2);
        sure = rti_tri_settle(&pair, c0, c1, c2, within);
    }
    if (sure < 0 || (certain && within[0] > end))
        return 0;
    if (sure > 0 && (mode & RTK_MODE_ANY))
        return 1;
    if (l->late != RTK_INVALID && l->tree->refs[place] == l->tree->refs[l->late]) /* met in another leaf */
        return 0;
    if (sure == 0 || within[1] >= l->t || !(within[0] < within[1]) || !(within[0] < l->far))
        return lone_ask(l, mode, l->tree->refs[place]);
    l->t = within[0];
    l->late = place;
    l->far = rtk_min(l->far, within[1]);
    return 0;
}

/* What lanes of the blocks from place `at` on have met (l->met), one by one. */
RTI_APART int lone_meet(lone *l, rtk_u32 mode, rtk_u32 at, rtk_u32 sure, rtk_u32 doubt)
{
    const struct lone_met *m = &l->met;
    for (; sure != 0u; sure &= sure - 1u) {
        const rtk_u32 i = (rtk_u32)__builtin_ctz(sure);
        if (lone_take(l, mode, at + i, m->t[i], m->u[i], m->v[i]))
            return 1;
    }
    for (; doubt != 0u; doubt &= doubt - 1u) {
        const rtk_u32 i = (rtk_u32)__builtin_ctz(doubt);
        if (lone_doubt(l, mode, at + i, m->certain >> i & 1u, m->t[i], m->off[i]))
            return 1;
    }
    return 0;
}

/* Here a compiler forgets what it knows of a pointer: what is read by it behind this is read there, not long before, where few
 * need it; and what it was made of is not taken apart again to save a register. */
#define LONE_AGAIN(p) __asm__("" : "+r"(p))

#define LONE_N 4
#include "bvh_lone_step.inl"
#undef LONE_N
#if NODE_N > 4
#define LONE_N 8
#include "bvh_lone_step.inl"
#undef LONE_N
#endif

/* Triangles of one block, as most leaves are, or two: as many lanes, for there are processors whose wide instructions take twice as
 * long (one ray a call is .90 to .97 of the time on a Zen 1). */
RTI_VEC int lone_step(lone *l, rtk_u32 mode, rtk_u32 at, rtk_u32 count)
{
#if NODE_N > 4
    if (at % 4u + count > 4u)
        return lone_step8(l, mode, at, count);
#endif
    return lone_step4(l, mode, at, count);
}

/* Triangles of as many blocks as there are lanes, where t is a sum with outer: as rtk_query_tri. */
RTI_VEC int lone_step_outer(lone *l, rtk_u32 mode, rtk_u32 at, rtk_u32 count)
{
    bvh_pairs_hit hit;
    float t[NODE_N], u[NODE_N], v[NODE_N];
    rtk_u32 bits = LANES_TYPE(lone_test, NODE_N)(l, at, count, &hit);
    at -= at % 4u;
    NODE(store)(t, hit.t);
    NODE(store)(u, hit.u);
    NODE(store)(v, hit.v);
    for (; bits != 0u; bits &= bits - 1u) {
        const rtk_u32 i = (rtk_u32)__builtin_ctz(bits);
        const float sum = l->outer + t[i];
        if (hit.doubt >> i & 1u) {
            if (lone_ask(l, mode, l->tree->refs[at + i]))
                return 1;
        } else if (sum > l->low && sum < l->high) {
            if (mode & RTK_MODE_ANY)
                return 1;
            if (sum == l->t)
                lone_ask(l, mode, l->tree->refs[at + i]);
            if (!(sum < l->t))
                continue;
            l->t = sum;
            l->u = u[i];
            l->v = v[i];
            l->late = at + i;
            l->far = rtk_min(l->far, sum);
        }
    }
    return 0;
}

#endif
