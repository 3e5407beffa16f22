/* Rays that have nothing in common through a large tree of eight-wide nodes, for hot files.
 *
 * A node that is in none of the processor's nearer caches costs some hundred cycles of waiting and thirty of work. So WEAVE rays
 * are on their way by turns, one node or leaf each: what a ray needs next is asked for when its turn ends and is there when the
 * next one begins. A turn at a node has no branch that depends on what the ray meets: the nearest slot comes from the node, or
 * from the stack when there is none; and what lies behind a hit leaves the stack at once when the hit is found. Neighbouring rays
 * of a picture do better one by one: they find what the ray before them has read, and the processor foresees the way that it
 * took.
 */
#ifndef RTI_BVH_WEAVE_H
#define RTI_BVH_WEAVE_H

#include "bvh_mixed.h"

#define WEAVE       8u
#define WEAVE_BYTES ((size_t)16 << 20) /* of a tree that is large */

/* Asks for what the next turn reads. */
RTI_VEC void weave_fetch(const lone *w, const rtk_tree *tree)
{
    const char *p = w->count == 0u ? (const char *)&tree->bvh[w->at] : (const char *)&tree->blocks[w->at / 4u];
    __builtin_prefetch(p);
    __builtin_prefetch(p + 64);
    __builtin_prefetch(p + 128);
    __builtin_prefetch(p + 192);
}

/* An inner node: where the ray goes on. */
RTI_VEC void weave_node(lone *w, const rtk_tree *tree)
{
    const rtk_bvhnode *n = &tree->bvh[w->at];
    const lone_slabs v = lone_slabs_of(w);
    float t[RTK_BVH_WIDTH];
    rtk_u32 bits = lone_open(n, &v, NODE(set)(w->reach), t), none, top = w->top, i;
    const rtk_u32 *child, *count;
    none = bits == 0u;
#ifdef RTI_PACK
    i = bvh_choose(n, bits, t, w->stack_t, w->stack_child, w->stack_count, &top);
#else
    i = none ? 0u : bvh_choose(n, bits, t, w->stack_t, w->stack_child, w->stack_count, &top);
#endif
    top -= none;
    child = none ? w->stack_child + top : n->child + i;
    count = none ? w->stack_count + top : n->count + i;
    w->at = *child;
    w->count = *count;
    w->top = top;
    weave_fetch(w, tree);
}

/* Takes from the stack what the ray enters behind its reach. */
RTI_VEC void weave_shorten(lone *w)
{
    rtk_u32 top = 1u, at;
#ifdef RTI_PACK
    const rti_f8 reach = rti_f8_set(w->reach);
    for (at = 1u; at < w->top; at += 8u) {
        const rti_f8 t = rti_f8_load(w->stack_t + at);
        const rtk_u32 left = w->top - at, bits = rti_m8_bits(rti_f8_le(t, reach)) & (left < 8u ? (1u << left) - 1u : 255u);
        rti_f8_pack(w->stack_t + top, bits, t);
        rti_u8_pack(w->stack_child + top, bits, w->stack_child + at);
        rti_u8_pack(w->stack_count + top, bits, w->stack_count + at);
        top += (rtk_u32)__builtin_popcount(bits);
    }
#else
    for (at = 1u; at < w->top; at++) {
        w->stack_t[top] = w->stack_t[at];
        w->stack_child[top] = w->stack_child[at];
        w->stack_count[top] = w->stack_count[at];
        top += w->stack_t[at] <= w->reach;
    }
#endif
    w->top = top;
}

/* A turn: 0, there is more to do. */
RTI_VEC int weave_turn(lone_all *a, lone *w, rtk_u32 mode)
{
    float reach;
    if (__builtin_expect(w->count == 0u, 1)) {
        weave_node(w, &a->tree);
        return 0;
    }
    if (w->count == LONE_END || lone_leaf(a, w, mode))
        return 1;
    reach = rtk_min(w->reach, a->p->t[w->lane]);
    if (!(mode & RTK_MODE_ANY) && reach < w->reach) {
        w->reach = reach;
        weave_shorten(w);
    }
    w->top--;
    w->at = w->stack_child[w->top];
    w->count = w->stack_count[w->top];
    weave_fetch(w, &a->tree);
    return 0;
}

/* So large that rays which start all over it wait for memory. */
RTI_VEC int weave_large(const rtk_tree *tree)
{
    return tree->block_count > WEAVE_BYTES / sizeof *tree->blocks;
}

/* Whether the rays are to go by turns. */
RTI_VEC int weaves(const lone_all *a)
{
    return a->p->scratch->turns || (a->p->spread && weave_large(&a->tree));
}

static void weave_walk(lone_all *a, rtk_u32 mode, uint64_t rays)
{
    lone all[WEAVE], *line[WEAVE];
    rtk_u32 live = 0u;
    for (; rays != 0u && live < WEAVE; rays &= rays - 1u) {
        line[live] = &all[live];
        lone_start(a, line[live++], mode, (rtk_u32)__builtin_ctzll(rays));
    }
    while (live > 0u) {
        for (rtk_u32 i = 0u; i < live; i++) {
            if (__builtin_expect(!weave_turn(a, line[i], mode), 1))
                continue;
            if (rays != 0u) {
                lone_start(a, line[i], mode, (rtk_u32)__builtin_ctzll(rays));
                rays &= rays - 1u;
            } else {
                line[i--] = line[--live];
            }
        }
    }
}

/* `rays` of a packet, prepared for the part, each for itself through its tree; returns those that must go another way. */
RTI_VEC uint64_t lone_rays(packet *p, rtk_u32 mode, const rtk_part *part, uint64_t rays)
{
    lone_all a;
    uint64_t other, all;
    a.p = p;
    a.part = part;
    a.tree = part->RTK_TREE;
    for (uint64_t l = p->masked || p->common == 0u ? rays : 0u; l != 0u; l &= l - 1u)
        if (p->mask[__builtin_ctzll(l)] == 0u)
            rays &= ~(l & (0u - l));
    if (rays == 0u)
        return 0u;
    other = lone_prepare(&a, rays);
    rays &= ~other;
    all = rays;
    memset(p->late, 0xff, sizeof p->late);
    memcpy(p->low, p->t, sizeof p->low);
    if (weaves(&a)) {
        weave_walk(&a, mode, rays);
        rays = 0u;
    }
    for (rtk_u32 at = 0u; rays != 0u && mixes(&a, mode) && at < PACKET; at += RTI_SIMD) {
        const rtk_u32 lanes = packet_bits(rays, at);
        if (__builtin_popcount(lanes) <= MIXED_FEW)
            continue;
        mixed_walk(&a, mode, at, lanes);
        rays &= ~((uint64_t)lanes << at);
    }
    for (; rays != 0u; rays &= rays - 1u) {
        lone l;
        lone_start(&a, &l, mode, (rtk_u32)__builtin_ctzll(rays));
        lone_walk(&a, &l, mode);
    }
    if (!(mode & RTK_MODE_ANY))
        lone_end(&a, all);
    return other;
}

#endif
