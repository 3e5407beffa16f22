/* Batches of rays that start far away from a group, for hot files.
 *
 * Such rays' origins are moved (rtk_ray_approach), and t of a hit is the sum of the shift and of what the leaf test gives from
 * there, rounded. Streams of closest hits know such sums (bvh_stream.h), and the walk of one ray. For any hits, among other
 * shapes and through the top level of several instances a batch is copied with its origins moved, and with ranges of exactly
 * those t whose sums lie in the given ones; so any tracer of batches finds what there is in it, and the nearest from the new
 * origin is the nearest of all. What that leaves open are others whose sums are equal to its own: they lie between it and the
 * least t whose sum is greater, and any hit of the rays there is asked for, by the same means. Rays that have one, which are
 * rare, go by themselves. */
#ifndef RTI_BVH_MOVED_H
#define RTI_BVH_MOVED_H

#include "bvh_approach.h"
#include "bvh_stream.h"

#define MOVED          16384u  /* rays at a time */
#define MOVED_LOOKS    32u     /* rays of a batch that are looked at, */
#define MOVED_FEW      8u      /* or of coherent ones, who else would wait for memory most of all here */
#define MOVED_LEAST    64u     /* rays that are worth it */
#define MOVED_SHIFT    1.0e30f /* the greatest shift: sums stay in the floats' range */
#define MOVED_MOST     4.0e6f  /* sizes of the part away: farther, sums are so coarse that many are equal */

typedef struct moved {
    _Alignas(64) rtk_trace_block own[MOVED / RTK_BLOCK];
    float shift[MOVED / RTK_BLOCK][RTK_BLOCK];
    uint16_t tied[MOVED / RTK_BLOCK]; /* that have another hit beside the best; of any hits, that planes are met by */
    uint16_t lanes[MOVED / RTK_BLOCK], alone[MOVED / RTK_BLOCK]; /* whose origins were moved; that go by themselves */
    rtk_group group;                                             /* the scene's own, without planes */
} moved;

/* Likewise through the top level, and what is found of them. */
typedef struct moved_top {
    moved moved;
    rtk_hit_block found[MOVED / RTK_BLOCK];
} moved_top;

_Static_assert(sizeof(moved) <= RTI_TRACE_MOVED && sizeof(moved_top) <= RTI_TRACE_TOP, "they fit into a room");
_Static_assert(MOVED % RTK_BLOCK == 0u, "whole blocks");

/* Floats next to others. Of infinities, anything. */
RTI_VEC float moved_above(float t)
{
    const rtk_u32 b = rtk_bits(t), up = t > 0.0f ? b + 1u : b - 1u;
    return rtk_float(t == 0.0f ? 1u : up);
}
RTI_VEC float moved_below(float t)
{
    return -moved_above(-t);
}

/* The least t with shift + t, rounded, not below x; *sure is 0 where it was not found. The middle between x and the float below
 * it, from the shift, is that but for what two roundings take away. */
RTI_VEC float moved_least(float shift, float x, rtk_u32 *sure)
{
    const float half = 0.5f * (x - moved_below(x));
    float t = moved_below((x - shift) - half);
    for (rtk_u32 i = 0u; i < 3u; i++)
        t = shift + t >= x ? t : moved_above(t);
    *sure = (rtk_u32)((shift + t >= x) & !(shift + moved_below(t) >= x));
    return t;
}

/* Rays that are looked at: those that start near a part, and those that start far away and do not pass it for certain. */
typedef struct moved_seen {
    rtk_u32 near, far, all;
} moved_seen;

RTI_VEC void moved_look(moved_seen *s, const rtk_trace_block *rays, rtk_u32 count, rtk_u32 looks, rtk_vec3 lo, rtk_vec3 hi,
                        float scale)
{
    const rtk_u32 step = rtk_umax(RTK_BLOCK, count / looks / RTK_BLOCK * RTK_BLOCK);
    for (rtk_u32 i = 0u; i < count; i += step) {
        const rtk_trace_block *b = &rays[i / RTK_BLOCK];
        __builtin_prefetch(b->ox);
        __builtin_prefetch(b->oy);
        __builtin_prefetch(b->oz);
    }
    for (rtk_u32 i = 0u; i < count; i += step, s->all++) {
        const rtk_trace_block *b = &rays[i / RTK_BLOCK];
        rtk_ray r;
        r.org = rtk_v3(b->ox[0], b->oy[0], b->oz[0]);
        if (!(rtk_maxabs(r.org) > RTK_FAR * scale && rtk_maxabs(r.org) < MOVED_MOST * scale)) {
            s->near++;
            continue;
        }
        r.dir = rtk_v3(b->dx[0], b->dy[0], b->dz[0]);
        r.tmin = b->tmin[0];
        s->far += !rtk_ray_passes(r, rtk_v3(rtk_inverse(r.dir.x), rtk_inverse(r.dir.y), rtk_inverse(r.dir.z)), lo, hi, scale);
    }
}

/* Are there many rays that start far away from a part and do not pass it for certain? A few tell whether any start there, then more
 * how many these are: such a ray by itself costs what many in a stream do, those that pass cost little either way, and what counts
 * is those that start near, which had better stay together. (Told by eight, of all: a bunny from afar took 1.2 times as long.) */
RTI_VEC int moved_many(const rtk_trace_block *rays, rtk_u32 count, rtk_vec3 lo, rtk_vec3 hi, float scale, int coherent)
{
    moved_seen s = {0u, 0u, 0u};
    if (count < MOVED_LEAST)
        return 0;
    moved_look(&s, rays, count, coherent ? MOVED_FEW : MOVED_LOOKS, lo, hi, scale);
    if (s.near == s.all)
        return 0;
    if (coherent)
        moved_look(&s, rays, count, MOVED_LOOKS, lo, hi, scale);
    return s.far != 0u && 4u * s.far >= s.far + s.near;
}

/* Do rays through one group go this way? */
RTI_VEC int moved_fits(const rtk_scene *scene, const rtk_trace_block *rays, rtk_u32 count, const rti_scratch *scratch,
                       int coherent)
{
    const rtk_group *g = scene->groups;
    if (!scratch->room || g->part_count != 1u || !(g->flags & RTK_GROUP_PLAIN) ||
        (g->shape_count == 0u && !stream_fits(g, g->parts)))
        return 0;
    return moved_many(rays, count, g->parts->lo, g->parts->hi, g->parts->scale, coherent);
}

/* Of a block's `lanes`, moved by `shift`, the ranges; returns those whose were not found. The t above which sums are above tmin
 * is the one below the least that has such a sum; of 0 it is -shift. */
RTI_VEC rtk_u32 moved_ranges(rtk_trace_block *b, const float *shift, rtk_u32 lanes)
{
    rtk_u32 sure[RTK_BLOCK], odd = 0u, ends = 0u;
    float low[RTK_BLOCK], high[RTK_BLOCK];
    for (rtk_u32 k = 0u; k < RTK_BLOCK; k++) {
        sure[k] = b->tmin[k] == 0.0f;
        low[k] = -shift[k];
        high[k] = b->tmax[k];
        odd |= (rtk_u32)!sure[k];
        ends |= (rtk_u32)(b->tmax[k] < RTK_INF);
    }
    for (rtk_u32 k = 0u; k < RTK_BLOCK && odd != 0u; k++) {
        low[k] = moved_below(moved_least(shift[k], moved_above(b->tmin[k]), &sure[k]));
        if (b->tmin[k] == -RTK_INF) {
            low[k] = -RTK_INF;
            sure[k] = 1u;
        }
    }
    if (ends != 0u) {
        for (rtk_u32 k = 0u; k < RTK_BLOCK; k++) {
            rtk_u32 found;
            const float least = moved_least(shift[k], b->tmax[k], &found);
            const int end = b->tmax[k] < RTK_INF;
            high[k] = end ? least : b->tmax[k];
            sure[k] &= found | (rtk_u32)!end;
        }
    }
    odd = 0u;
    for (rtk_u32 k = 0u; k < RTK_BLOCK; k++) {
        const int moves = (int)(lanes >> k & 1u);
        b->tmin[k] = moves ? low[k] : b->tmin[k];
        b->tmax[k] = moves ? high[k] : b->tmax[k];
        odd |= (sure[k] ^ 1u) << k;
    }
    return odd & lanes;
}

/* These lanes hit nothing then. */
RTI_VEC void moved_away(rtk_trace_block *b, rtk_u32 lanes)
{
    for (; lanes != 0u; lanes &= lanes - 1u) {
        const rtk_u32 k = (rtk_u32)__builtin_ctz(lanes);
        b->tmin[k] = 0.0f;
        b->tmax[k] = -1.0f;
    }
}

/* Block i of the copies, of whose rays n count. Those that pass for certain, or whose origins cannot be moved, stay: they miss
 * whoever is asked. */
RTI_VEC void moved_block(moved *a, rtk_u32 i, rtk_u32 n, const rtk_trace_block *rays, const rtk_part *part)
{
    rtk_trace_block *b = &a->own[i];
    rtk_u32 lanes = 0u, wide = 0u;
    *b = *rays;
    for (rtk_u32 at = 0u; at < RTK_BLOCK; at += RTI_SIMD) {
        packet_rays r;
        vec org[3], shift, t0, t1;
        rtk_u32 far;
        packet_rays_load(&r, b, at);
        packet_rays_enter(r.org, r.inv, r.tmin, r.tmax, r.valid, part, &t0, &t1, &far);
        V(store)(a->shift[i] + at, V(set)(0.0f));
        if (far == 0u)
            continue;
        far &= ~rays_approach(&r, part, far, org, &shift);
        wide |= (far & VM(bits)(V(lt)(V(set)(MOVED_SHIFT), V(abs)(shift)))) << at;
        lanes |= far << at;
        const vmask go = VM(of)(far);
        V(store)(b->ox + at, V(select)(go, org[0], r.org[0]));
        V(store)(b->oy + at, V(select)(go, org[1], r.org[1]));
        V(store)(b->oz + at, V(select)(go, org[2], r.org[2]));
        V(store)(a->shift[i] + at, V(select)(go, shift, V(set)(0.0f)));
    }
    if (n < RTK_BLOCK)
        lanes &= (1u << n) - 1u;
    a->alone[i] = (uint16_t)(lanes != 0u ? moved_ranges(b, a->shift[i], lanes) | (wide & lanes) : 0u);
    a->lanes[i] = (uint16_t)(lanes & ~a->alone[i]);
    moved_away(b, a->alone[i]);
}

/* What was found of block i, n of whose rays count, as the given rays have it; then the block asks for ties. Returns whether it
 * does. */
RTI_VEC int moved_found(moved *a, rtk_u32 i, rtk_u32 n, const rtk_trace_block *rays, rtk_hit_block *h)
{
    rtk_trace_block *b = &a->own[i];
    rtk_u32 sure[RTK_BLOCK], hits = 0u, odd = 0u;
    float low[RTK_BLOCK], high[RTK_BLOCK];
    for (rtk_u32 k = 0u; k < n; k++) {
        const int hit = h->prim[k] != RTK_INVALID;
        hits |= (rtk_u32)hit << k;
        h->t[k] = hit ? h->t[k] : rays->tmax[k];
    }
    hits &= a->lanes[i];
    for (rtk_u32 k = 0u; k < RTK_BLOCK; k++) {
        const float t = a->shift[i][k] + h->t[k];
        low[k] = h->t[k];
        high[k] = moved_least(a->shift[i][k], moved_above(t), &sure[k]);
        h->t[k] = hits >> k & 1u ? t : h->t[k];
    }
    for (rtk_u32 k = 0u; k < RTK_BLOCK; k++)
        odd |= (sure[k] ^ 1u) << k;
    a->alone[i] |= (uint16_t)(odd & hits);
    hits &= ~odd;
    for (rtk_u32 k = 0u; k < RTK_BLOCK; k++) {
        const int asks = (int)(hits >> k & 1u);
        b->tmin[k] = asks ? low[k] : 0.0f;
        b->tmax[k] = asks ? high[k] : -1.0f;
    }
    return hits != 0u;
}

#endif
