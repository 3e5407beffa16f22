/* Shapes in leaves, and rays of a stream (bvh_stream.h): as many rays at a time as vectors have lanes and one shape after the
 * other, or of few rays each by itself and shapes side by side. Tori are asked one by one. */
#ifndef RTI_BVH_STREAM_BALL_H
#define RTI_BVH_STREAM_BALL_H

#include "bvh_stream.h"

#define STREAM_BALL_FEW 4u /* rays of a leaf that go by themselves */

/* The balls of a leaf for one ray. size: of the tree's, a constant where this is called. */
RTI_VEC void stream_balls_one(const streams *a, stream *s, rtk_u32 mode, rtk_u32 l, rtk_u32 at, rtk_u32 count, rtk_u32 size)
{
    const stream_ball *o = &s->ball[l];
    const bvh_vec org[3] = {NODE(set)(o->ox), NODE(set)(o->oy), NODE(set)(o->oz)};
    const bvh_vec dir[3] = {NODE(set)(o->dx), NODE(set)(o->dy), NODE(set)(o->dz)};
    ball_ray r;
    ball_meets(&r, org, dir, NODE(set)(o->tmin), NODE(set)(o->tmax), NODE(set)(stream_shift(s, mode, l)),
               NODE(set)(RTK_BALL_MARGIN * a->part->scale));
    const float *by = s->ray[l].inv;
    const bvh_vec inv[3] = {NODE(set)(by[0]), NODE(set)(by[1]), NODE(set)(by[2])};
    ball_one_ready(&r);
    for (rtk_u32 k = 0u; k < count; k += NODE_N) {
        const float far = mode & RTK_MODE_ANY ? RTK_INF : rtk_max(s->hit[l].t, stream_far(s, mode, l));
        bvh_vec t;
        float each[NODE_N];
        rtk_u32 ask, hit = shape_leaf(&r, inv, bvh_ball(&a->tree, at + k), size, count - k, NODE(set)(far), &t, &ask);
        if ((mode & RTK_MODE_ANY) && hit != 0u) {
            stream_done(a, s, l);
            return;
        }
        if (hit != 0u)
            NODE(store)(each, t);
        for (; hit != 0u; hit &= hit - 1u) {
            const rtk_u32 i = (rtk_u32)__builtin_ctz(hit);
            stream_take(a, s, l, mode, at + k + i, each[i], 0.0f, 0.0f);
        }
        for (; ask != 0u && s->ray[l].t1 != -RTK_INF; ask &= ask - 1u)
            stream_ask(a, s, l, mode, a->tree.refs[at + k + (rtk_u32)__builtin_ctz(ask)]);
    }
}

/* RTI_SIMD rays as spheres meet them. */
RTI_VEC ball_rays stream_balls_rays(const streams *a, const stream *s, rtk_u32 mode, const uint16_t lane[RTI_SIMD])
{
    vec o[8];
#ifdef RTI_PACK8
    const vec shift = mode & STREAM_MOVED ? V(column)(s->shift, 1u, lane) : V(set)(0.0f);
    V(records)(&s->ball[0].ox, lane, o);
#else
    float x[9][RTI_SIMD];
    for (rtk_u32 i = 0u; i < RTI_SIMD; i++) {
        const stream_ball *b = &s->ball[lane[i]];
        const float of[9] = {b->ox, b->oy, b->oz, b->dx, b->dy, b->dz, b->tmin, b->tmax, stream_shift(s, mode, lane[i])};
        for (rtk_u32 m = 0u; m < 9u; m++)
            x[m][i] = of[m];
    }
    for (rtk_u32 k = 0u; k < 8u; k++)
        o[k] = V(load)(x[k]);
    const vec shift = V(load)(x[8]);
#endif
    ball_rays r;
    balls_meet(&r, o, o + 3, o[6], o[7], shift, V(set)(RTK_BALL_MARGIN * a->part->scale));
    ball_ready(&r);
    return r;
}

/* Behind which of these rays' best hits spheres need not be told. */
RTI_VEC vec stream_balls_far(const stream *s, rtk_u32 mode, const uint16_t lane[RTI_SIMD])
{
    if (mode & RTK_MODE_ANY)
        return V(set)(RTK_INF);
#ifdef RTI_PACK8
    return V(max)(V(column)(&s->hit[0].t, 4u, lane), stream_fars(s, mode, lane));
#else
    float far[RTI_SIMD];
    for (rtk_u32 i = 0u; i < RTI_SIMD; i++)
        far[i] = rtk_max(s->hit[lane[i]].t, stream_far(s, mode, lane[i]));
    return V(load)(far);
#endif
}

/* rtk_inverse of these rays' directions. */
RTI_VEC void stream_balls_inv(const stream *s, const uint16_t lane[RTI_SIMD], vec inv[3])
{
#ifdef RTI_PACK8
    for (rtk_u32 k = 0u; k < 3u; k++)
        inv[k] = V(column)(&s->ray[0].inv[k], 8u, lane);
#else
    float x[3][RTI_SIMD];
    for (rtk_u32 i = 0u; i < RTI_SIMD; i++)
        for (rtk_u32 k = 0u; k < 3u; k++)
            x[k][i] = s->ray[lane[i]].inv[k];
    for (rtk_u32 k = 0u; k < 3u; k++)
        inv[k] = V(load)(x[k]);
#endif
}

/* The shapes of a leaf for the rays of a list. */
RTI_VEC void stream_balls_of(const streams *a, stream *s, rtk_u32 mode, const uint16_t *ids, rtk_u32 n, rtk_u32 at, rtk_u32 count,
                             rtk_u32 size)
{
    for (rtk_u32 i = 0u; i < n && n < STREAM_BALL_FEW; i++)
        stream_balls_one(a, s, mode, ids[i], at, count, size);
    for (rtk_u32 i = 0u; i < n && n >= STREAM_BALL_FEW; i += RTI_SIMD) {
        const rtk_u32 some = rtk_umin(n - i, RTI_SIMD);
        rtk_u32 live = some < RTI_SIMD ? (1u << some) - 1u : LANES_ALL;
        uint16_t lane[RTI_SIMD];
        for (rtk_u32 k = 0u; k < RTI_SIMD; k++)
            lane[k] = ids[i + (k < some ? k : 0u)];
        const ball_rays r = stream_balls_rays(a, s, mode, lane);
        const vec far = stream_balls_far(s, mode, lane);
        vec inv[3];
        stream_balls_inv(s, lane, inv);
        for (rtk_u32 k = 0u; k < count && live != 0u; k++) {
            float each[RTI_SIMD];
            vec t;
            rtk_u32 ask, hit = shape_hits(&r, inv, bvh_ball(&a->tree, at + k), size, far, live, &t, &ask);
            if ((hit | ask) == 0u)
                continue;
            V(store)(each, t);
            for (rtk_u32 both = hit | ask; both != 0u; both &= both - 1u) {
                const rtk_u32 m = (rtk_u32)__builtin_ctz(both), l = lane[m];
                if (ask >> m & 1u)
                    stream_ask(a, s, l, mode, a->tree.refs[at + k]);
                else
                    stream_take(a, s, l, mode, at + k, each[m], 0.0f, 0.0f);
                if ((mode & RTK_MODE_ANY) && s->ray[l].t1 == -RTK_INF)
                    live &= ~(1u << m);
            }
        }
    }
}

/* A tree of nothing but spheres needs no forms, nor what they take. */
RTI_APART void stream_spheres(const streams *a, stream *s, rtk_u32 mode, const uint16_t *ids, rtk_u32 n, rtk_u32 at, rtk_u32 count)
{
    stream_balls_of(a, s, mode, ids, n, at, count, RTK_BALL);
}
RTI_APART void stream_forms(const streams *a, stream *s, rtk_u32 mode, const uint16_t *ids, rtk_u32 n, rtk_u32 at, rtk_u32 count)
{
    stream_balls_of(a, s, mode, ids, n, at, count, RTK_FORM);
}
RTI_VEC void stream_balls(const streams *a, stream *s, rtk_u32 mode, const uint16_t *ids, rtk_u32 n, rtk_u32 at, rtk_u32 count)
{
    if (a->tree.ball_size == RTK_FORM)
        stream_forms(a, s, mode, ids, n, at, count);
    else
        stream_spheres(a, s, mode, ids, n, at, count);
}

#endif
