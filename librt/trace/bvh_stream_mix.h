/* Whether a batch's rays go through a tree in streams by octants, or mixed (bvh_stream.h).
 *
 * By octants a node's slots are looked at in the order in which all of a list's rays come to them, and which of a box's sides they
 * meet first is known. Mixed, boxes cost more (half as much again with AVX-512, a seventh by their middles), but lists are longer:
 * rays that start near each other meet the same boxes wherever they point, and the rays of a small batch are not dealt to eight
 * streams of a few. For any hits there is no order to lose. Mixed rays, to those by octants, with AVX-512: occlusion of batches of
 * 16384 1.07 to 1.18 times as many a second in rooms, 1.45 of a million triangles; bounces 1.25, and 1.38, where triangles are
 * small, .93 to 1.03 in rooms; rays from anywhere to anywhere 1.06 to 1.13, but in a tree that no cache holds half as many;
 * batches of 64: 1.2 to 1.5, and 1.4 to 1.8 times. (Coherent rays point one way anyhow.)
 *
 * A large tree's streams go by turns, so that what one waits for comes while others have theirs: of mixed ones each takes rays that
 * stand in the batch side by side.
 */
#ifndef RTI_BVH_STREAM_MIX_H
#define RTI_BVH_STREAM_MIX_H

#include "bvh_stream_region.h"

#if RTI_SIMD >= 8
#define MIX_COUNT 0xffffffffu
#else
#define MIX_COUNT 128u /* rays of a batch: narrow vectors save little by long lists */
#endif
#define MIX_SCALE  1.0e6f              /* of a part, times RTK_INV_MAX: far from the end of the floats' range */
#define MIX_LARGE  ((size_t)64 << 20) /* bytes of a tree from which on mixed streams go by turns, */
#define MIX_SPREAD ((size_t)16 << 20) /* and where rays start all over it; closest hits go by octants then: */
#define MIX_FAR    2.0f               /* so far from each other (stream_look) */
#define MIX_MOVED  1024u              /* rays: of more that start far away, and from each other, closest hits go by octants */
#define MIX_SLOTS  14u                /* a ray enters of closest hits from which on, of many rays, octants are better, */
#define MIX_AGAIN  15u                /* for so many batches */

/* What some of a batch's rays tell of all. far: how far they start from each other, the sum of what the box of where they start
 * takes of a part's sides; of many spread evenly over it 2.6. one_way: they point into one octant. */
typedef struct stream_look {
    float far;
    int one_way;
} stream_look;

RTI_VEC stream_look stream_look_at(const rtk_trace_block *rays, rtk_u32 count, const rtk_part *part)
{
    enum { LOOKS = 16 };
    const float low[3] = {part->lo.x, part->lo.y, part->lo.z}, high[3] = {part->hi.x, part->hi.y, part->hi.z};
    stream_look look = {0.0f, 1};
    for (rtk_u32 a = 0u; a < 3u; a++) {
        float lo = RTK_INF, hi = -RTK_INF;
        rtk_u32 down = 0u;
        for (rtk_u32 k = 0u; k < LOOKS; k++) {
            const size_t i = (size_t)k * count / LOOKS;
            const rtk_trace_block *b = &rays[i / RTK_BLOCK];
            const float x = (a == 0u ? b->ox : (a == 1u ? b->oy : b->oz))[i % RTK_BLOCK];
            lo = rtk_min(lo, x);
            hi = rtk_max(hi, x);
            down += rtk_bits((a == 0u ? b->dx : (a == 1u ? b->dy : b->dz))[i % RTK_BLOCK]) >> 31;
        }
        look.far += (hi - lo) / (high[a] - low[a]);
        look.one_way &= down == 0u || down == LOOKS;
    }
    return look;
}

/* Do few rays start far from each other? Then hardly two of them meet anything in common, and one by one they are faster (32 random
 * rays of sponza 2.3 times). */
#define STREAM_SCATTER 256u
RTI_VEC int stream_scattered(const rtk_trace_block *rays, rtk_u32 count, const rtk_part *part)
{
    return count <= STREAM_SCATTER && stream_look_at(rays, count, part).far > 1.0f;
}

/* The slots of the root as rays are asked whether they enter one. */
RTI_VEC void streams_root(streams *a)
{
    const rtk_bvhnode *n = a->tree.bvh;
    for (rtk_u32 k = 0u; k < 3u; k++)
        for (rtk_u32 h = 0u; h < RTK_BVH_WIDTH; h += NODE_N) {
            bvh_vec middle, half;
            stream_middles(n, k, h, a->part->scale, &middle, &half);
            NODE(store)(a->middle[k] + h, middle);
            NODE(store)(a->half[k] + h, half);
        }
    for (a->roots = 0u; a->roots < RTK_BVH_WIDTH && n->child[a->roots] + n->count[a->roots] != 0u;)
        a->roots++;
}

/* A part and its tree, for a batch's rays, and how they go: mixed, but for those that point one way, and closest hits where the
 * order in which boxes are looked at saves more. Mixed ones have longer lists, so they need no turns as soon. */
RTI_VEC void streams_part(streams *a, rtk_u32 mode, const rtk_part *part, const rtk_tree *tree, const rtk_trace_block *rays,
                          rtk_u32 count, int coherent)
{
    size_t large = BVH_LARGE; /* from so many bytes on by turns */
    a->part = part;
    a->tree = *tree;
    a->looked = a->missed = 0u;
    a->middles = part->scale <= MIX_SCALE;
    streams_root(a);
    a->mixed = !coherent && count <= MIX_COUNT && a->middles;
    if (a->mixed) {
        const stream_look look = stream_look_at(rays, count, part);
        const int spread = look.far > MIX_FAR, ordered = !(mode & RTK_MODE_ANY);
        a->mixed = !look.one_way;
        if (ordered && spread && (bvh_larger(tree, MIX_SPREAD) || (mode & STREAM_MOVED && count > MIX_MOVED)))
            a->mixed = 0u;
        if (a->mixed && ordered && count > STREAM && a->scratch->learned.octants != 0u) {
            a->scratch->learned.octants--;
            a->mixed = 0u;
        }
        if (a->mixed)
            large = spread ? MIX_SPREAD : MIX_LARGE;
    }
    a->turns = a->scratch->turns || bvh_larger(tree, large);
    a->shift = 31u;
    for (rtk_u32 n = 6u; a->turns && a->shift == 31u; n++) /* two such make a stream, or eight the batch */
        a->shift = 2u << n >= a->length || 8u << n >= count ? n : 31u;
    a->ran = a->entered = 0u;
}

/* Behind a batch of closest hits: rays that enter many slots find them a little sooner where those that point into one octant go
 * together, if they are many. (Bounces in sponza and sibenik: 16 slots a ray, 1.06 times; random rays there, 11 slots, .9.) */
RTI_VEC void streams_over(const streams *a, rtk_u32 count)
{
    if (a->mixed && !a->turns && count > STREAM && a->entered > MIX_SLOTS * a->ran)
        a->scratch->learned.octants = MIX_AGAIN;
}

#endif
