/* One ray by itself (bvh_lone.h) and spheres of a leaf, as many at a time as a node's vectors have lanes. Their order along the ray
 * is that of their t; where one is as near as what is no sphere, or lies between the bounds of a triangle's hit that was put aside,
 * it is asked. */
#ifndef RTI_BVH_LONE_BALL_H
#define RTI_BVH_LONE_BALL_H

#include "ball_lanes.h"
#include "bvh_lone.h"

#if NODE_N > 4
#define ball_test      rti_ball8
#define ball_one_ready rti_ball_ready8
typedef rti_ball_ray8 ball_ray;
#else
#define ball_test      rti_ball4
#define ball_one_ready rti_ball_ready4
typedef rti_ball_ray4 ball_ray;
#endif

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

/* Eight balls, or four, from p on: their fields. */
RTI_VEC void lone_ball_load(const float *p, bvh_vec to[4])
{
    bvh_vec rows[4];
    for (rtk_u32 i = 0u; i < 4u; i++)
#if NODE_N > 4
        rows[i] = rti_f8_two(p + i * RTK_BALL, p + (4u + i) * RTK_BALL);
#else
        rows[i] = rti_f4_load(p + i * RTK_BALL);
#endif
    NODE(turn)(rows, to);
}

/* Hits of the balls from place `at` on, a bit each, with their t in l->met. ask: those that are no spheres. */
RTI_VEC rtk_u32 lone_ball_test(lone *l, rtk_u32 at, rtk_u32 count, rtk_u32 *ask)
{
    const struct lone_ball *b = &l->ball;
    const rtk_u32 want = (1u << count) - 1u;
    bvh_vec of[4], t;
    lone_ball_load(l->tree->balls + (size_t)(at - RTK_BVH_BLOCK * l->tree->block_count) * RTK_BALL, of);
    const ball_ray r = {{NODE(set)(b->org[0]), NODE(set)(b->org[1]), NODE(set)(b->org[2])},
                        {NODE(set)(b->dir[0]), NODE(set)(b->dir[1]), NODE(set)(b->dir[2])},
                        NODE(set)(l->org[3]),
                        NODE(set)(l->dir[3]),
                        NODE(set)(l->shift),
                        NODE(set)(b->margin),
                        {NODE(set)(b->unit[0]), NODE(set)(b->unit[1]), NODE(set)(b->unit[2])},
                        NODE(set)(b->dd),
                        NODE(set)(b->len)};
    *ask = want & node_bits(NODE(lt)(of[3], NODE(set)(0.0f)));
    const rtk_u32 hit = ball_test(&r, of, of[3], NODE(set)(rtk_max(l->far, l->t)), want & ~*ask, &t);
    if (hit != 0u)
        NODE(store)(l->met.t, t);
    return hit;
}

/* The references from place `at` on, of a leaf with balls. Returns 1 when the walk may end. */
RTI_VEC int lone_balls(lone *l, rtk_u32 mode, rtk_u32 at, rtk_u32 count)
{
    while (count != 0u) {
        const rtk_u32 n = rtk_umin(count, NODE_N);
        rtk_u32 ask, hit = lone_ball_test(l, at, n, &ask);
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
                       l->late >= RTK_BVH_BLOCK * l->tree->block_count) { /* spheres stand in the order of hits */
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
