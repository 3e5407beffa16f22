/* One ray by itself (bvh_lone.h) and shapes of a leaf, as many at a time as a node's vectors have lanes; tori are asked one by
 * one. Their order along the ray is that of their t; where one is as near as what is no shape, or lies between the bounds of a
 * triangle's hit that was put aside, it is asked. */
#ifndef RTI_BVH_LONE_BALL_H
#define RTI_BVH_LONE_BALL_H

#include "bvh_lone.h"
#include "shape_leaf.h"

/* The ray as spheres meet it: org and dir of the space that they are in, of four lanes three count. */
RTI_VEC void lone_ball_ready(lone *l, rti_f4 org, rti_f4 dir)
{
    const rti_f4 square = dir * dir;
    l->ball.dd = square[0] + square[1] + square[2];
    l->ball.len = rtk_sqrt(l->ball.dd);
    l->ball.margin = RTK_BALL_MARGIN * l->scale;
    rti_f4_store(l->ball.org, org);
    rti_f4_store(l->ball.dir, dir);
    rti_f4_store(l->ball.unit, dir / rti_f4_set(l->ball.len));
}

/* Hits of the shapes from place `at` on, a bit each, with their t in l->met. ask: those that are to be asked one by one. */
RTI_VEC rtk_u32 lone_ball_test(lone *l, rtk_u32 at, rtk_u32 count, rtk_u32 size, rtk_u32 *ask)
{
    const struct lone_ball *b = &l->ball;
    const bvh_vec inv[3] = {NODE(set)(l->inv[0]), NODE(set)(l->inv[1]), NODE(set)(l->inv[2])};
    bvh_vec t;
    const ball_ray r = {{NODE(set)(b->org[0]), NODE(set)(b->org[1]), NODE(set)(b->org[2])},
                        {NODE(set)(b->dir[0]), NODE(set)(b->dir[1]), NODE(set)(b->dir[2])},
                        NODE(set)(l->less[3]),
                        NODE(set)(l->dir[3]),
                        NODE(set)(l->shift),
                        NODE(set)(b->margin),
                        {NODE(set)(b->unit[0]), NODE(set)(b->unit[1]), NODE(set)(b->unit[2])},
                        NODE(set)(b->dd),
                        NODE(set)(b->len)};
    const rtk_u32 hit =
        shape_leaf(&r, inv, bvh_ball(l->tree, at), size, count, NODE(set)(rtk_max(l->far, l->t)), &t, ask);
    if (hit != 0u)
        NODE(store)(l->met.t, t);
    return hit;
}

/* The shapes from place `at` on, the tree's balls being of `size`. Returns 1 when the walk may end. */
RTI_VEC int lone_balls(lone *l, rtk_u32 mode, rtk_u32 at, rtk_u32 count, rtk_u32 size)
{
    while (count != 0u) {
        const rtk_u32 n = rtk_umin(count, NODE_N);
        rtk_u32 ask, hit = lone_ball_test(l, at, n, size, &ask);
        if ((mode & RTK_MODE_ANY) && hit != 0u)
            return 1;
        for (; hit != 0u; hit &= hit - 1u) {
            const rtk_u32 i = (rtk_u32)__builtin_ctz(hit);
            const float t = l->met.t[i];
            if (t < l->t) {
                l->t = t;
                l->u = l->v = 0.0f;
                l->late = at + i;
                l->far = rtk_min(l->far, t);
                lone_expect(l, at + i);
            } else if (t == l->t && !(l->t < l->far) && l->late != RTK_INVALID &&
                       l->late >= RTK_BVH_BLOCK * l->tree->block_count) { /* shapes stand in the order of hits */
                l->late = l->tree->refs[at + i] < l->tree->refs[l->late] ? at + i : l->late;
            } else if (t <= l->far || t == l->t) {
                ask |= 1u << i;
            }
        }
        for (; ask != 0u; ask &= ask - 1u)
            if (lone_ask(l, mode, l->tree->refs[at + (rtk_u32)__builtin_ctz(ask)]))
                return 1;
        at += n;
        count -= n;
    }
    return 0;
}

#endif
