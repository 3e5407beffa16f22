/* Where a stream's rays are at all (bvh_stream.h), for any hit: in the box around where each enters and leaves the part, or ends.
 * Rays of a stream start near each other and point into one octant, so slots behind them, and, where they are short, slots far
 * ahead are entered by none: of ambient occlusion three to five of eight are in the box, in rooms three. With AVX-512 sixteen rays
 * at a time meet a slot, and those slots alone; with AVX2, where no more than four are left, two rays meet them at a time. (Closest
 * hits are asked of long rays: six of eight are in their box.)
 *
 * The box's planes err by some ten roundings of a coordinate of size scale (an origin is at most RTK_FAR scale away), and are
 * moved apart by RTK_GROW scale, 128 of them.
 */
#ifndef RTI_BVH_STREAM_REGION_H
#define RTI_BVH_STREAM_REGION_H

#include "bvh_stream.h"

#ifdef RTI_PACK8
/* The box around all of a stream's rays: its list has them all, or they lie in its blocks of sixteen. */
RTI_VEC void stream_region(const streams *a, stream *s)
{
    const float grow = RTK_GROW * a->part->scale;
    vec low[3], high[3];
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
    for (rtk_u32 k = 0u; k < 3u; k++) {
        float lows[RTI_SIMD], highs[RTI_SIMD];
        V(store)(lows, low[k]);
        V(store)(highs, high[k]);
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
#define STREAM_REGION 32u /* rays of a list from which on it is asked for */

/* stream_open for the slots `there`, no more than four: which rays enter the first of them is bit 0, and so on. */
RTI_VEC rtk_u32 stream_open_four(streams *a, const stream *s, const rtk_bvhnode *n, rtk_u32 there, const uint16_t *ids,
                                 rtk_u32 size)
{
    rti_f8 low[3], high[3];
    rtk_u32 lanes[8] = {0u}, count = 0u, all = 0u, entered = 0u;
    for (rtk_u32 left = there; left != 0u; left &= left - 1u) {
        lanes[count] = lanes[4u + count] = (rtk_u32)__builtin_ctz(left);
        count++;
    }
    for (rtk_u32 k = 0u; k < 3u; k++) {
        low[k] = rti_f8_take(n->box[k][0], lanes);
        high[k] = rti_f8_take(n->box[k][1], lanes);
    }
    for (rtk_u32 i = 0u; i < size; i += 2u) {
        const rtk_u32 at[2] = {8u * ids[i], 8u * ids[i + 1u < size ? i + 1u : i]}; /* the last may meet them twice */
        rti_f8 r[8], in[3], out[3];
        rti_f8_fields(s->ray[0].inv, at, r);
        for (rtk_u32 k = 0u; k < 3u; k++) {
            const rti_f8 x = rti_f8_msub(low[k], r[k], r[3u + k]), y = rti_f8_msub(high[k], r[k], r[3u + k]);
            in[k] = rti_f8_min(x, y);
            out[k] = rti_f8_max(x, y);
        }
        const rti_f8 t0 = rti_f8_max(rti_f8_max(in[0], in[1]), rti_f8_max(in[2], r[6]));
        const rti_f8 t1 = rti_f8_min(rti_f8_min(out[0], out[1]), rti_f8_min(out[2], r[7]));
        const rtk_u32 bits = rti_m8_bits(rti_f8_le(t0, t1));
        a->bits[i] = (uint8_t)bits; /* bits above those of `there` are not read */
        a->bits[i + 1u] = (uint8_t)(bits >> 4);
        all |= bits;
    }
    all |= all >> 4;
    for (rtk_u32 k = 0u; k < count; k++)
        entered |= (all >> k & 1u) << lanes[k];
    return entered;
}
#endif

#endif
