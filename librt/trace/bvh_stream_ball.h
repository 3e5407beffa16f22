/* Spheres in leaves, and rays of a stream (bvh_stream.h): as many rays at a time as vectors have lanes and one sphere after the
 * other, or of few rays each by itself and spheres side by side. */
#ifndef RTI_BVH_STREAM_BALL_H
#define RTI_BVH_STREAM_BALL_H

#include "bvh_stream.h"

#define STREAM_BALL_FEW 4u /* rays of a leaf that go by themselves */

RTI_VEC const float *stream_ball_at(const streams *a, rtk_u32 place)
{
    return a->tree.balls + (size_t)(place - RTK_BVH_BLOCK * a->tree.block_count) * RTK_BALL;
}

/* The balls of a leaf for one ray. */
RTI_VEC void stream_balls_one(const streams *a, stream *s, rtk_u32 mode, rtk_u32 l, rtk_u32 at, rtk_u32 count)
{
    const stream_ball *o = &s->ball[l];
    ball_ray r = {{NODE(set)(o->ox), NODE(set)(o->oy), NODE(set)(o->oz)},
                  {NODE(set)(o->dx), NODE(set)(o->dy), NODE(set)(o->dz)},
                  .tmin = NODE(set)(o->tmin),
                  .tmax = NODE(set)(o->tmax),
                  .tshift = NODE(set)(stream_shift(s, mode, l)),
                  .margin = NODE(set)(RTK_BALL_MARGIN * a->part->scale)};
    ball_one_ready(&r);
    for (rtk_u32 k = 0u; k < count; k += NODE_N) {
        const rtk_u32 want = (1u << rtk_umin(count - k, NODE_N)) - 1u;
        const float far = mode & RTK_MODE_ANY ? RTK_INF : rtk_max(s->hit[l].t, stream_far(s, mode, l));
        bvh_vec of[4], t;
        float each[NODE_N];
        lone_ball_load(stream_ball_at(a, at + k), of);
        rtk_u32 ask = want & node_bits(NODE(lt)(of[3], NODE(set)(0.0f)));
        rtk_u32 hit = ball_test(&r, of, of[3], NODE(set)(far), want & ~ask, &t);
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
    ball_rays r = {{o[0], o[1], o[2]}, {o[3], o[4], o[5]}, .tmin = o[6], .tmax = o[7], .tshift = shift,
                        .margin = V(set)(RTK_BALL_MARGIN * a->part->scale)};
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

/* The balls of a leaf for the rays of a list. */
static void stream_balls(const streams *a, stream *s, rtk_u32 mode, const uint16_t *ids, rtk_u32 n, rtk_u32 at, rtk_u32 count)
{
    for (rtk_u32 i = 0u; i < n && n < STREAM_BALL_FEW; i++)
        stream_balls_one(a, s, mode, ids[i], at, count);
    for (rtk_u32 i = 0u; i < n && n >= STREAM_BALL_FEW; i += RTI_SIMD) {
        const rtk_u32 some = rtk_umin(n - i, RTI_SIMD);
        rtk_u32 live = some < RTI_SIMD ? (1u << some) - 1u : LANES_ALL;
        uint16_t lane[RTI_SIMD];
        for (rtk_u32 k = 0u; k < RTI_SIMD; k++)
            lane[k] = ids[i + (k < some ? k : 0u)];
        const ball_rays r = stream_balls_rays(a, s, mode, lane);
        const vec far = stream_balls_far(s, mode, lane);
        for (rtk_u32 k = 0u; k < count && live != 0u; k++) {
            const float *ball = stream_ball_at(a, at + k);
            const vec middle[3] = {V(set)(ball[0]), V(set)(ball[1]), V(set)(ball[2])};
            const rtk_u32 other = ball[3] < 0.0f;
            vec t = far;
            float each[RTI_SIMD];
            rtk_u32 hit = other ? live : ball_many(&r, middle, V(set)(ball[3]), far, live, &t);
            if (hit == 0u)
                continue;
            V(store)(each, t);
            for (; hit != 0u; hit &= hit - 1u) {
                const rtk_u32 m = (rtk_u32)__builtin_ctz(hit), l = lane[m];
                if (other)
                    stream_ask(a, s, l, mode, a->tree.refs[at + k]);
                else
                    stream_take(a, s, l, mode, at + k, each[m], 0.0f, 0.0f);
                if ((mode & RTK_MODE_ANY) && s->ray[l].t1 == -RTK_INF)
                    live &= ~(1u << m);
            }
        }
    }
}

#endif
