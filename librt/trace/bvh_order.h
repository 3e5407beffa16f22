/* An order for rays of a batch that is not coherent, for hot files: rays that start near each other and point the same way come
 * to stand side by side, and so walk together for longer (bvh_mixed.h). What each ray hits does not depend on it.
 *
 * Rays of a batch mostly start beside those before and behind them, as bounces of one tile do: then runs of ORDER_RUN are ordered,
 * each for itself, by direction alone. That pays where rays go far, as in a room; where most leave the scene, as they do from
 * a statue, nothing is worth more than a common start. So a run is ordered when of the one before it enough have hit. Rays that
 * start all over the part are ordered by the cell that they start in and by direction, a chunk at a time, when a first run of them
 * takes its time, or did in the part of the batch before this one. Both are counting sorts; with what comes of them an ordered ray
 * costs some thirty cycles more. (Garanzha, Loop 2010.)
 */
#ifndef RTI_BVH_ORDER_H
#define RTI_BVH_ORDER_H

#include "bvh_mixed.h"

#define ORDER_MOST   4096u /* rays of a chunk */
#define ORDER_RUN    256u
#define ORDER_HITS   3u    /* a run is ordered when of the one before it one ray in so many has hit, or more */
#define ORDER_TURNS  4u    /* and when of its first rays one in so many, or more, is of another class than the one before it */
#define ORDER_STEPS  6u    /* of a first run so many steps (packet) for sixteen rays, or more */
#define ORDER_WAYS   96u   /* classes of directions: octant, dominant axis, whether the other two are above half of it */
#define ORDER_CELLS  512u  /* 8 x 8 x 8, in Morton order */
#define ORDER_SPREAD 0.25f /* of the part's size: packets that start over more of it start all over it */

/* Any hits are too quick to be brought in order, and others do not walk together (bvh_mixed.h). */
#define ORDER_PAYS(mode) (MIXED_PAYS(mode) && !((mode) & RTK_MODE_ANY))

typedef struct order {
    uint16_t ray[ORDER_MOST]; /* the order: numbers in the chunk */
    uint16_t between[ORDER_MOST], cell[ORDER_MOST], way[ORDER_MOST];
} order;

RTI_VEC void order_put(uint16_t *to, vec_whole a)
{
    const vec_short x = __builtin_convertvector(a, vec_short);
    memcpy(to, &x, sizeof x);
}

/* The classes of RTI_SIMD directions. */
RTI_VEC void order_ways(uint16_t *way, const rtk_trace_block *b, rtk_u32 lane)
{
    const vec zero = V(set)(0.0f), half = V(set)(0.5f), one = V(set)(1.0f);
    const vec d[3] = {V(load)(b->dx + lane), V(load)(b->dy + lane), V(load)(b->dz + lane)};
    const vec x = V(abs)(d[0]), y = V(abs)(d[1]), z = V(abs)(d[2]), most = V(max)(V(max)(x, y), z) * half;
    const lone_axes axes = {V(lt)(V(max)(y, z), x), V(lt)(z, y)};
    vec w = V(select)(V(lt)(d[0], zero), V(set)(48.0f), zero) + V(select)(V(lt)(d[1], zero), V(set)(24.0f), zero);
    w = w + V(select)(V(lt)(d[2], zero), V(set)(12.0f), zero) + lone_turned(&axes, zero, V(set)(4.0f), V(set)(8.0f));
    w = w + V(select)(V(lt)(most, lone_turned(&axes, y, z, x)), V(set)(2.0f), zero);
    w = w + V(select)(V(lt)(most, lone_turned(&axes, z, x, y)), one, zero);
    order_put(way, __builtin_convertvector(w, vec_whole));
}

/* The bounds of where the rays of some blocks start. */
RTI_VEC void order_bounds(const rtk_trace_block *rays, rtk_u32 n, float lo[3], float hi[3])
{
    const vec inf = V(set)(RTK_INF);
    vec l[3] = {inf, inf, inf}, h[3] = {-inf, -inf, -inf};
    for (rtk_u32 at = 0u; at + RTI_SIMD <= n; at += RTI_SIMD) {
        const rtk_trace_block *b = &rays[at / RTK_BLOCK];
        const float *const org[3] = {b->ox, b->oy, b->oz};
        for (rtk_u32 k = 0u; k < 3u; k++) {
            const vec o = V(load)(org[k] + at % RTK_BLOCK);
            l[k] = V(min)(o, l[k]);
            h[k] = V(max)(o, h[k]);
        }
    }
    for (rtk_u32 k = 0u; k < 3u; k++) {
        lo[k] = packet_low(l[k]);
        hi[k] = packet_high(h[k]);
    }
}

/* Whether most packets of n rays start all over the part; every fourth is asked. A few rays count as such. */
RTI_VEC int order_is_spread(const rtk_trace_block *rays, rtk_u32 n, const rtk_part *part)
{
    const rtk_vec3 size = rtk_sub(part->hi, part->lo);
    rtk_u32 asked = 0u, wide = 0u;
    for (rtk_u32 at = 0u; at < n; at += 4u * PACKET, asked++) {
        float lo[3], hi[3];
        order_bounds(rays + at / RTK_BLOCK, rtk_umin(n - at, PACKET), lo, hi);
        wide += (hi[0] - lo[0]) + (hi[1] - lo[1]) + (hi[2] - lo[2]) > ORDER_SPREAD * (size.x + size.y + size.z);
    }
    return n < RTI_SIMD || 2u * wide > asked;
}

/* The cells that RTI_SIMD rays start in. */
RTI_VEC void order_cells(uint16_t *cell, const rtk_trace_block *b, rtk_u32 lane, const float lo[3], const float by[3])
{
    const float *const org[3] = {b->ox + lane, b->oy + lane, b->oz + lane};
    const vec zero = V(set)(0.0f), last = V(set)(7.0f);
    vec_whole all = {0};
    for (rtk_u32 k = 0u; k < 3u; k++) { /* the bits of the three numbers by turns */
        const vec x = V(min)(V(max)((V(load)(org[k]) - V(set)(lo[k])) * V(set)(by[k]), zero), last); /* of a NaN 0 */
        const vec_whole i = __builtin_convertvector(x, vec_whole);
        all |= ((i & 1) | (i & 2) << 2 | (i & 4) << 4) << (int)k;
    }
    order_put(cell, all);
}

/* Puts n numbers, `in` or 0, 1, 2 ... (NULL), into the order of their keys, which are below `keys`. */
RTI_VEC void order_count(const uint16_t *in, rtk_u32 n, const uint16_t *key, rtk_u32 keys, uint16_t *out)
{
    uint16_t at[ORDER_CELLS + 1u];
    memset(at, 0, (keys + 1u) * sizeof *at);
    for (rtk_u32 i = 0u; i < n; i++)
        at[key[i] + 1u]++;
    for (rtk_u32 i = 1u; i < keys; i++)
        at[i] = (uint16_t)(at[i] + at[i - 1u]);
    for (rtk_u32 i = 0u; i < n; i++) {
        const uint16_t number = in ? in[i] : (uint16_t)i;
        out[at[key[number]]++] = number;
    }
}

/* The order of a run: n rays from `at` on; 0: they stand in one. Rays behind n in the last block are looked at and not used. */
static int order_run(order *o, const rtk_trace_block *rays, rtk_u32 at, rtk_u32 n)
{
    const rtk_u32 some = rtk_umin(n, PACKET);
    rtk_u32 turns = 0u;
    for (rtk_u32 i = at; i < at + some; i += RTI_SIMD)
        order_ways(o->way + i, &rays[i / RTK_BLOCK], i % RTK_BLOCK);
    for (rtk_u32 i = at + 1u; i < at + some; i++)
        turns += o->way[i] != o->way[i - 1u];
    if (turns < some / ORDER_TURNS)
        return 0;
    for (rtk_u32 i = at + some; i < at + n; i += RTI_SIMD)
        order_ways(o->way + i, &rays[i / RTK_BLOCK], i % RTK_BLOCK);
    order_count(NULL, n, o->way + at, ORDER_WAYS, o->ray + at);
    return 1;
}

/* The order of n rays that start all over the part, likewise. */
static void order_spread(order *o, const rtk_trace_block *rays, rtk_u32 n, const rtk_part *part)
{
    const float lo[3] = {part->lo.x, part->lo.y, part->lo.z}, hi[3] = {part->hi.x, part->hi.y, part->hi.z};
    float by[3];
    for (rtk_u32 k = 0u; k < 3u; k++)
        by[k] = hi[k] > lo[k] ? 8.0f / (hi[k] - lo[k]) : 0.0f;
    for (rtk_u32 at = 0u; at < n; at += RTI_SIMD) {
        order_ways(o->way + at, &rays[at / RTK_BLOCK], at % RTK_BLOCK);
        order_cells(o->cell + at, &rays[at / RTK_BLOCK], at % RTK_BLOCK, lo, by);
    }
    order_count(NULL, n, o->way, ORDER_WAYS, o->between);
    order_count(o->between, n, o->cell, ORDER_CELLS, o->ray);
}

#endif
