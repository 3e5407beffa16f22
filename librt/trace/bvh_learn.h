/* Whether coherent rays had better go as others do, in streams, for hot files: told by what pencils and packets before have met.
 *
 * Rays of a picture of few pixels, or of very small triangles, come to leaves of their own each: what is told for all of a pencil,
 * or of a packet, is told for few of its rays. How that is held against what streams cost is measured (AVX2 on a Zen 1, AVX-512 on
 * a Zen 5), by counts alone, so it is the same in each run. It is kept from batch to batch and from call to call (rti_learned).
 */
#ifndef RTI_BVH_LEARN_H
#define RTI_BVH_LEARN_H

#include "pencil_begin.h"

/* A pencil of any hits does well where, of leaves, it looks through one for at least so many of its rays, or so many rays come to
 * one. */
#define PENCIL_RAYS_OF_LEAVES 4u
#define PENCIL_RAYS_A_LEAF    (RTI_SIMD >= 16 ? 12u : (RTI_SIMD >= 8 ? 6u : 4u))
/* Rays in streams behind one, or behind packets, and how many times as many behind the next. */
#define PENCIL_ANY_APART   (RTI_SIMD >= 16 ? 2u * PENCIL_RAYS : PENCIL_RAYS)
#define PENCIL_APART(mode) ((mode)&RTK_MODE_ANY ? PENCIL_ANY_APART : PENCIL_RAYS / 2u)
#define PACKET_APART(mode) ((mode)&RTK_MODE_ANY ? PENCIL_ANY_APART : 64u)
#define PENCIL_APART_AGAIN (RTI_SIMD >= 16 ? 16u : 2u)
#define PENCIL_TELLS       16u /* rays a leaf, above which a pencil says nothing of others */

/* How many of the coherent rays to come go as others. spread: those at hand had better. `least` after the first time, for a single
 * one tells little; many times as many each time after that, a quarter when those at hand did well between. tells: they say
 * something at all. */
RTI_VEC void learn_apart(rti_learned *l, rtk_u32 mode, rtk_u32 least, int spread, int tells)
{
    const rtk_u32 any = (mode & RTK_MODE_ANY) != 0u;
    l->left[any] = 0u;
    if (spread)
        l->left[any] = l->apart[any] = l->apart[any] == 0u ? least : rtk_umin(PENCIL_APART_AGAIN * l->apart[any], 1u << 16);
    else if (tells)
        l->apart[any] = l->apart[any] < 4u * least ? 0u : l->apart[any] / 4u;
}

/* Did a pencil of `count` rays do worse than streams had? Where triangles are so small, or the picture is, that it finds few rays
 * in each leaf, it tells that for all of its bundles again and again. (Shadow rays of 75,000 points of a million triangles: streams
 * are 1.5 times as fast, at three rays a leaf; where sixteen come to one, pencils are 1.7 times as fast. Of an eye, which rays pass
 * a leaf is told for bundles, and what streams cost beside that grows with the leaves that rays come to. With AVX2 they are even at
 * .25 to .95 of a leaf looked through a ray, in rooms where a ray comes to three to five, .7 to .95, .65 in a tree that no cache
 * holds; at 64x48 pixels pencils take 1.5 to 7 times as long.) */
RTI_VEC int pencil_spread(const pencil *p, rtk_u32 mode, rtk_u32 count)
{
    if (mode & RTK_MODE_ANY)
        return PENCIL_RAYS_OF_LEAVES * p->leaves > count && p->told < PENCIL_RAYS_A_LEAF * p->leaves;
    return p->apart || 8u * p->leaves > (bvh_large(&p->scene->groups->parts->bvh) ? 4u : 2u) * count + p->told;
}

/* Behind a pencil of `count` rays. */
RTI_VEC void pencil_learn(pencil *p, rtk_u32 mode, rtk_u32 count)
{
    learn_apart(&p->scratch->learned, mode, PENCIL_APART(mode), pencil_spread(p, mode, count),
                PENCIL_TELLS * p->leaves >= count);
    p->leaves = p->told = 0u;
}

/* Behind a batch that went as packets. Of sixty-four rays streams are as fast at .35 to .95 of a step a ray (a node opened, a leaf
 * looked through), of thirty-two at .5 to 1.4: at 64x48 pixels packets take 1.4 to 10 times as long. */
RTI_VEC void packet_learn(const packet *p, rti_scratch *scratch, rtk_u32 mode)
{
    learn_apart(&scratch->learned, mode, PACKET_APART(mode), 5u * p->steps > 128u * p->walks + 2u * p->walked,
                PENCIL_TELLS * p->steps >= p->walked);
}

/* Of so many coherent rays those that are to go as others: whole blocks, or all of them. */
RTI_VEC rtk_u32 learned_left(rti_learned *l, rtk_u32 mode, rtk_u32 count)
{
    rtk_u32 *left = &l->left[(mode & RTK_MODE_ANY) != 0u];
    const rtk_u32 n = rtk_umin(*left, count);
    *left = (*left - n) / RTK_BLOCK * RTK_BLOCK;
    return n;
}

/* Do the `count` coherent rays that a batch has yet all go as others, as most of them had better? Where a scene has several parts,
 * for rays go one way through all of them; and a batch that begins so of closest hits, for mixed ones are met together, or of rays
 * that are no pencil's. */
RTI_VEC int learned_ends(rti_learned *l, rtk_u32 mode, rtk_u32 parts, rtk_u32 count, int begins)
{
    const rtk_u32 any = (mode & RTK_MODE_ANY) != 0u;
    const int may = parts > 1u || (begins && (!any || count < PENCIL_BATCH));
    return may && l->left[any] != 0u && 4u * l->left[any] >= count && learned_left(l, mode, count) != 0u;
}

#endif
