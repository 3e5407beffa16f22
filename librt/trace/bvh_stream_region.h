/* Where a stream's rays are at all (bvh_stream.h), for any hit: in the box around where each enters and leaves the part, or ends.
 * Rays of a stream start near each other and point into one octant, so slots behind them, and, where they are short, slots far
 * ahead are entered by none: of ambient occlusion three to five of eight are in the box, in rooms three. Sixteen rays at a time,
 * or eight with AVX2 where no more than STREAM_THERE are left, meet a slot, and those slots alone. (Closest hits are asked of long
 * rays: six of eight are in their box.)
 *
 * The box's planes err by some ten roundings of a coordinate of size scale (an origin is at most RTK_FAR scale away), and are
 * moved apart by RTK_GROW scale, 128 of them.
 */
#ifndef RTI_BVH_STREAM_REGION_H
#define RTI_BVH_STREAM_REGION_H

#include "bvh_stream.h"

/* Of a node's boxes, along an axis, slots from h on, the middles, and how far their planes are from those, and RTK_GROW / 4 more:
 * 32 roundings of a coordinate of size scale, where those of middle and half, of their products and of the sums come to 13 more
 * than what is lost where rays meet planes as they stand. So where a ray enters and leaves a box is told without asking which of
 * its planes it meets first, by sums, which many processors make beside products and comparisons. Boxes of nothing get NaN. */
RTI_VEC void stream_middles(const rtk_bvhnode *n, rtk_u32 k, rtk_u32 h, float scale, bvh_vec *middle, bvh_vec *half)
{
    const bvh_vec low = NODE(load)(n->box[k][0] + h), high = NODE(load)(n->box[k][1] + h);
    *middle = NODE(set)(0.5f) * (low + high);
    *half = NODE(set)(0.5f) * (high - low) + NODE(set)(0.25f * RTK_GROW * scale);
}

#ifdef RTI_PACK8
/* Mixed rays, `lanes`, join a stream, from t0 to end; first: there are none yet. */
RTI_VEC void stream_region_more(stream *s, const vec org[3], const vec dir[3], vec t0, vec end, rtk_u32 lanes, int first)
{
    const vmask in = VM(of)(lanes);
    for (rtk_u32 k = 0u; k < 3u; k++) {
        const vec enter = org[k] + dir[k] * t0, leave = org[k] + dir[k] * end;
        const vec low = first ? V(set)(RTK_INF) : V(load)(s->lows[k]), high = first ? V(set)(-RTK_INF) : V(load)(s->highs[k]);
        V(store)(s->lows[k], V(select)(in, V(min)(low, V(min)(enter, leave)), low));
        V(store)(s->highs[k], V(select)(in, V(max)(high, V(max)(enter, leave)), high));
    }
}

/* The box around a stream's rays by octants: its list has them all, or they lie in its blocks of sixteen. */
RTI_VEC void stream_region_octant(const stream *s, vec low[3], vec high[3])
{
    for (rtk_u32 k = 0u; k < 3u; k++) {
        low[k] = V(set)(RTK_INF);
        high[k] = V(set)(-RTK_INF);
    }
    for (rtk_u32 i = 0u; i < s->n; i += RTI_SIMD) {
        vec r[8];
#ifdef RTI_PACK
        const vmask in = VM(of)(s->n - i < RTI_SIMD ? (1u << (s->n - i)) - 1u : LANES_ALL); /* lanes behind hold anything */
        for (rtk_u32 k = 0u; k < 8u; k++)
            r[k] = V(load)(s->wide[i / 16u][k]);
#define IN(new, old) V(select)(in, new, old)
#else
        uint16_t ids[RTI_SIMD];
        rti_u16_last(ids, s->list + i, rtk_umin(s->n - i, RTI_SIMD));
        V(records)(s->ray[0].inv, ids, r);
#define IN(new, old) new
#endif
        for (rtk_u32 k = 0u; k < 3u; k++) {
            const vec by = V(set)(1.0f) / r[k], enter = (r[3u + k] + r[6]) * by, leave = (r[3u + k] + r[7]) * by;
            low[k] = IN(V(min)(low[k], V(min)(enter, leave)), low[k]);
            high[k] = IN(V(max)(high[k], V(max)(enter, leave)), high[k]);
        }
#undef IN
    }
}

/* The box around all of a stream's rays. */
RTI_VEC void stream_region(const streams *a, stream *s)
{
    const float grow = RTK_GROW * a->part->scale;
    vec low[3], high[3];
    if (!a->mixed)
        stream_region_octant(s, low, high);
    for (rtk_u32 k = 0u; k < 3u; k++) {
        float lows[RTI_SIMD], highs[RTI_SIMD];
        V(store)(lows, a->mixed ? V(load)(s->lows[k]) : low[k]);
        V(store)(highs, a->mixed ? V(load)(s->highs[k]) : high[k]);
        for (rtk_u32 i = 1u; i < RTI_SIMD; i++) {
            lows[0] = rtk_min(lows[0], lows[i]);
            highs[0] = rtk_max(highs[0], highs[i]);
        }
        s->low[k] = lows[0] - grow;
        s->high[k] = highs[0] + grow;
    }
}

/* The slots of a node that are in the box; empty ones are inside out, and not. */
RTI_VEC rtk_u32 stream_slots_there(const stream *s, const rtk_bvhnode *n)
{
    rti_m8 there = rti_m8_of(255u);
    for (rtk_u32 k = 0u; k < 3u; k++) {
        there = rti_m8_and(there, rti_f8_le(rti_f8_load(n->box[k][0]), rti_f8_set(s->high[k])));
        there = rti_m8_and(there, rti_f8_le(rti_f8_set(s->low[k]), rti_f8_load(n->box[k][1])));
    }
    return rti_m8_bits(there);
}

#endif

#if defined RTI_PACK8 && !defined RTI_PACK
#define STREAM_REGION 32u /* rays of a list from which on it is asked for, */
#define STREAM_THERE  6   /* and slots up to which eight rays at a time meet one */

/* The slots `there`: which of a list's rays enter each, to a->slots; behind the last ray's eight a word's other half is as it was.
 * Returns which are entered. */
RTI_VEC rtk_u32 stream_open_some(streams *a, const stream *s, const rtk_bvhnode *n, rtk_u32 there, const uint16_t *ids,
                                 rtk_u32 size)
{
    float middle[3][RTK_BVH_WIDTH], half[3][RTK_BVH_WIDTH];
    rtk_u32 slot[STREAM_THERE], count = 0u, entered = 0u;
    for (rtk_u32 k = 0u; k < 3u; k++) {
        rti_f8 m, h;
        stream_middles(n, k, 0u, a->part->scale, &m, &h);
        rti_f8_store(middle[k], m);
        rti_f8_store(half[k], h);
    }
    for (rtk_u32 left = there; left != 0u; left &= left - 1u)
        slot[count++] = (rtk_u32)__builtin_ctz(left);
    for (rtk_u32 at = 0u; at < size; at += 8u) {
        const uint16_t *some = ids + at;
        rtk_u32 of = 255u;
        uint16_t last[8];
        rti_f8 r[8];
        if (size - at < 8u) { /* and one of them again */
            rti_u16_last(last, ids + at, size - at);
            some = last;
            of = (1u << (size - at)) - 1u;
        }
        rti_f8_records(s->ray[0].inv, some, r);
        const rti_f8 by[3] = {rti_f8_abs(r[0]), rti_f8_abs(r[1]), rti_f8_abs(r[2])};
#pragma GCC unroll 1
        for (rtk_u32 c = 0u; c < count; c++) {
            const rtk_u32 i = slot[c];
            rti_f8 in = r[6], out = r[7]; /* one axis after the other: registers are few */
            for (rtk_u32 k = 0u; k < 3u; k++) {
                const rti_f8 m = rti_f8_msub(rti_f8_set(middle[k][i]), r[k], r[3u + k]), off = rti_f8_set(half[k][i]) * by[k];
                in = rti_f8_max(in, m - off);
                out = rti_f8_min(out, m + off);
            }
            const rtk_u32 bits = of & rti_m8_bits(rti_f8_le(in, out));
            ((uint8_t *)a->slots[i])[at / 8u] = (uint8_t)bits;
            entered |= bits != 0u ? 1u << i : 0u;
        }
    }
    return entered;
}
#endif

#endif
