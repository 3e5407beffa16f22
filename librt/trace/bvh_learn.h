/* Whether coherent rays had better go as others do, in streams, for hot files: told by what pencils and packets before have met.
 *
 * Rays of a picture of few pixels, or of very small triangles, come to leaves of their own each: what is told for all of a pencil,
 * or of a packet, is told for few of its rays. How that is held against what streams cost is measured (AVX2 on a Zen 1, AVX-512 on
 * a Zen 5), by counts alone, so it is the same in each run. It is kept from batch to batch and from call to call (rti_learned).
 */
#ifndef RTI_BVH_LEARN_H
#define RTI_BVH_LEARN_H

#include "pencil_begin.h"

/* A pencil of any hits does worse than streams had where it looks through a leaf for so few of its rays, and so few rays come to
 * one. */
#define PENCIL_RAYS_OF_LEAVES (RTI_SIMD >= 16 ? 8 : 4)
#define PENCIL_RAYS_A_LEAF    (RTI_SIMD >= 16 ? 12 : (RTI_SIMD >= 8 ? 6 : 4))
/* What streams cost of closest hits, in sixteenths of a leaf looked through: a ray in a tree that no cache holds, in others, and
 * where it meets a leaf's box. */
#define PENCIL_FAR_RAY (RTI_SIMD >= 16 ? 16 : 8)
#define PENCIL_RAY     (RTI_SIMD >= 16 ? 2 : 4)
#define PENCIL_MEETS   (RTI_SIMD >= 16 ? 1 : 2)
/* Rays in streams behind one, or behind packets. */
#define PENCIL_APART(mode) (RTI_SIMD >= 16 || (mode)&RTK_MODE_ANY ? PENCIL_RAYS : PENCIL_RAYS / 2u)
#define PACKET_APART(mode) ((mode)&RTK_MODE_ANY ? PENCIL_RAYS : 64u)
/* Rays a leaf, above which a pencil that did well says nothing of others. */
#define PENCIL_TELLS (RTI_SIMD >= 16 ? 512u : 16u)
/* What pencils before told is worth so many of them. With AVX-512 pencils are 2 to 4 times as fast as streams at 640x480 and more,
 * and one in a hundred that does worse must not send thousands of rays elsewhere behind it: told by the last one alone
 * staircase's closest hits took 1.3 times as long. With AVX2 both are closer, and the last one tells best. */
#define LEARN_PENCILS (RTI_SIMD >= 16 ? 2 : 0)
/* So many times as many rays in streams behind the next that does worse, and no more than so many, for places differ. */
#define LEARN_AGAIN (RTI_SIMD >= 16 ? 4u : 2u)
#define LEARN_MOST  (1u << 14)

RTI_VEC int64_t learn_within(int64_t x, int64_t most)
{
    return x > most ? most : (x < -most ? -most : x);
}

/* How many of the coherent rays to come go as others. `count` rays have gone together; more: what that cost beyond streams, worth
 * so many rays, below 0 where it cost less. `least` go after the first time, for a single one tells little, more each time after
 * that, a quarter when those at hand did well between. tells: that they did well says something of others. */
RTI_VEC void learn_apart(rti_learned *l, rtk_u32 mode, rtk_u32 least, int64_t more, rtk_u32 count, int tells)
{
    const rtk_u32 any = (mode & RTK_MODE_ANY) != 0u;
    const int64_t one = (int64_t)count, all = LEARN_PENCILS * one, sum = learn_within(more, one) + l->balance[any];
    l->left[any] = 0u;
    if (more <= 0 && !tells)
        return;
    l->balance[any] = learn_within(sum, all);
    if (sum > 0 && more > 0)
        l->left[any] = l->apart[any] = l->apart[any] == 0u ? least : rtk_umin(LEARN_AGAIN * l->apart[any], LEARN_MOST);
    else if (sum <= 0)
        l->apart[any] = l->apart[any] < 4u * least ? 0u : l->apart[any] / 4u;
}

/* Behind a pencil of `count` rays. Where triangles are so small, or the picture is, that it finds few rays in each leaf, it tells
 * that for all of its bundles again and again. (Shadow rays of 75,000 points of a million triangles: streams are 1.5 times as fast,
 * at three rays a leaf; where sixteen come to one, pencils are 1.7 times as fast. Of an eye, which rays pass a leaf is told for
 * bundles, and what streams cost beside that grows with the leaves that rays come to. With AVX2 they are even at .25 to .95 of a
 * leaf looked through a ray, in rooms where a ray comes to three to five, .7 to .95, .65 in a tree that no cache holds; with
 * AVX-512 at .13 to .4, where it comes to .6 to 3.3, .5 in such a tree, and of any hits at eight to twenty rays a leaf; at 64x48
 * pixels pencils take 1.5 to 7 times as long.) */
RTI_VEC void pencil_learn(pencil *p, rtk_u32 mode, rtk_u32 count)
{
    const int64_t rays = (int64_t)count, leaves = (int64_t)p->leaves, told = (int64_t)p->told;
    int64_t more;
    if (mode & RTK_MODE_ANY) {
        const int64_t of_leaves = PENCIL_RAYS_OF_LEAVES * leaves - rays, a_leaf = PENCIL_RAYS_A_LEAF * leaves - told;
        more = of_leaves < a_leaf ? of_leaves : a_leaf;
    } else {
        const int64_t ray = bvh_large(&p->scene->groups->parts->bvh) ? PENCIL_FAR_RAY : PENCIL_RAY;
        more = 8 * leaves - (ray * rays + PENCIL_MEETS * told) / 2;
    }
    if (p->apart && more < rays)
        more = rays;
    learn_apart(&p->scratch->learned, mode, PENCIL_APART(mode), more, count, (uint64_t)PENCIL_TELLS * p->leaves >= count);
    p->leaves = p->told = 0u;
}

/* Behind a batch that went as packets. Of sixty-four rays streams are as fast at .35 to .95 of a step a ray (a node opened, a leaf
 * looked through), of thirty-two at .5 to 1.4: at 64x48 pixels packets take 1.4 to 10 times as long. */
RTI_VEC void packet_learn(const packet *p, rti_scratch *scratch, rtk_u32 mode)
{
    const int64_t more = 5 * (int64_t)p->steps - 128 * (int64_t)p->walks - 2 * (int64_t)p->walked;
    learn_apart(&scratch->learned, mode, PACKET_APART(mode), more, p->walked, (uint64_t)PENCIL_TELLS * p->steps >= p->walked);
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
