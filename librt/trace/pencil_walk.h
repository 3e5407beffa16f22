/* The walk of a pencil through eight-wide nodes, for hot files; what it is, and what its bounds rest on, pencil.h tells. */
#ifndef RTI_PENCIL_WALK_H
#define RTI_PENCIL_WALK_H

#include "pencil_shape.h"

#define PENCIL_NODES   8u            /* nodes a ray that a pencil may open before it has come apart, */
#define PENCIL_LEAVES  2u            /* and leaves a ray that it may look through, */
#define PENCIL_AT_ALL  (PENCIL_RAYS / 2u) /* beside so many, and one for every four rays that come to leaves */
#define PENCIL_BUNDLED (PENCIL / 4u) /* bundles at a leaf up to which their rays are told from one another at once */
#define PENCIL_PAIRS   2u /* pairs of a bundle and a triangle, for each bundle, above which rays are told from one another */
/* PENCIL_LONE: rays at a leaf for which its triangles are not looked at before. PENCIL_PRICE: what FOUR_RAYS rays by four
 * triangles cost, in pairs of a bundle and a triangle. */
#if defined RTI_PACK8
#define PENCIL_LONE(mode)  ((mode)&RTK_MODE_ANY ? 40u : 24u)
#define PENCIL_PRICE(mode) (RTI_SIMD == 8 && ((mode)&RTK_MODE_ANY) ? 1u : 2u)
#else
#define PENCIL_LONE(mode) 8u
#endif

/* The slots of a node that the rectangle around all rays meets, with a bound of the depth where. */
RTI_APART rtk_u32 pencil_open(const pencil *p, const rtk_bvhnode *n, float t[RTK_BVH_WIDTH])
{
    rtk_u32 bits = 0u;
    for (rtk_u32 i = 0u; i < RTK_BVH_WIDTH; i += NODE_N) {
        const rtk_u32 axis[2] = {p->kx, p->ky};
        const bvh_vec zl = NODE(load)(n->box[p->kz][0] + i), zh = NODE(load)(n->box[p->kz][1] + i);
        bvh_vec in = zl - NODE(set)(p->high[2]), out = zh - NODE(set)(p->low[2]);
        if (p->turn < 0.0f) {
            in = NODE(set)(p->low[2]) - zh;
            out = NODE(set)(p->high[2]) - zl;
        }
        bvh_vec t0 = NODE(max)(in, NODE(set)(0.0f)), t1 = NODE(min)(out, NODE(set)(p->deepest));
        for (rtk_u32 k = 0u; k < 2u; k++) {
            const bvh_vec lo = NODE(load)(n->box[axis[k]][0] + i) - NODE(set)(p->high[k]);
            const bvh_vec hi = NODE(load)(n->box[axis[k]][1] + i) - NODE(set)(p->low[k]);
            const pencil_ways *w = &p->all[k];
            t0 = NODE(max)(lo * NODE(set)(w->in[0][0]), t0);
            t0 = NODE(max)(hi * NODE(set)(w->in[1][0]), t0);
            t1 = NODE(min)(NODE(madd)(lo, NODE(set)(w->out[0][0]), NODE(set)(w->more[0][0])), t1);
            t1 = NODE(min)(NODE(madd)(hi, NODE(set)(w->out[1][0]), NODE(set)(w->more[1][0])), t1);
        }
        if (p->away)
            NODE(store)(t + i, t0);
        else
            NODE(store)(t + i, NODE(set)(p->deepest) - t1);
        bits |= node_bits(NODE(le)(t0, t1)) << i;
    }
    return bits;
}

/* The bundles whose rectangles meet a slot's box. vectors: those that may, as pencil_vectors has them. */
RTI_APART pencil_bits pencil_enter(const pencil *p, const rtk_bvhnode *n, rtk_u32 slot, rtk_u32 vectors)
{
    const rtk_u32 axis[2] = {p->kx, p->ky};
    const float zl = n->box[p->kz][0][slot], zh = n->box[p->kz][1][slot];
    const float in = p->turn > 0.0f ? zl - p->high[2] : p->low[2] - zh, out = p->turn > 0.0f ? zh - p->low[2] : p->high[2] - zl;
    pencil_bits bundles = 0u;
    for (; vectors != 0u; vectors &= vectors - 1u) {
        const rtk_u32 h = (rtk_u32)__builtin_ctz(vectors) * RTI_SIMD;
        vec t0 = V(max)(V(set)(in), V(load)(p->from + h)), t1 = V(min)(V(set)(out), V(load)(p->reach + h));
        for (rtk_u32 k = 0u; k < 2u; k++) {
            const vec lo = V(set)(n->box[axis[k]][0][slot] - p->high[k]), hi = V(set)(n->box[axis[k]][1][slot] - p->low[k]);
            const pencil_ways *w = &p->ways[k];
            t0 = V(max)(lo * V(load)(w->in[0] + h), t0);
            t0 = V(max)(hi * V(load)(w->in[1] + h), t0);
            t1 = V(min)(V(madd)(lo, V(load)(w->out[0] + h), V(load)(w->more[0] + h)), t1);
            t1 = V(min)(V(madd)(hi, V(load)(w->out[1] + h), V(load)(w->more[1] + h)), t1);
        }
        bundles |= (pencil_bits)VM(bits)(V(le)(t0, t1)) << h;
    }
    return bundles & p->bundles;
}

/* Whether a ray of some bundles meets a slot's box. */
RTI_APART int pencil_any(const pencil *p, const rtk_bvhnode *n, rtk_u32 slot, pencil_bits bundles)
{
    const pencil_box box = pencil_box_of(p, n, slot);
    for (; bundles != 0u; bundles &= bundles - 1u)
        if (pencil_near_rays(p, &box, PENCIL_FIRST(bundles)) != 0u)
            return 1;
    return 0;
}

/* The rays at a leaf: bundles, and when they are known which of their rays meet its box, how many, and them listed. */
typedef struct pencil_at {
    pencil_bits bundles;
    rtk_u32 known, count, listed;
    uint16_t rays[BUNDLES];
#ifdef RTI_PACK8
    uint16_t list[PENCIL_RAYS + RTK_BLOCK];
#endif
} pencil_at;

RTI_VEC void pencil_tell(pencil *p, const rtk_bvhnode *n, rtk_u32 slot, pencil_at *a)
{
    if (a->known)
        return;
    a->known = 1u;
    a->count = 0u;
    a->bundles = pencil_near(p, n, slot, a->bundles, a->rays);
    for (pencil_bits l = a->bundles; l != 0u; l &= l - 1u)
        a->count += (rtk_u32)__builtin_popcount(a->rays[PENCIL_FIRST(l)]);
}

/* Of the four places from `at` on those of a leaf, a bit each. */
RTI_VEC rtk_u32 pencil_places(rtk_u32 at, rtk_u32 begin, rtk_u32 end)
{
    const rtk_u32 from = at < begin ? 15u << (begin - at) & 15u : 15u;
    return end - at < 4u ? from & ((1u << (end - at)) - 1u) : from;
}

/* The triangles `keep` of a block, four places from `at` on, for all rays that meet the leaf, which are known. */
RTI_VEC void pencil_all(pencil *p, rtk_u32 mode, rtk_u32 at, rtk_u32 keep, pencil_at *a, int one)
{
    const rtk_tree *tree = &p->part->bvh;
#ifdef RTI_PACK8
    if (!a->listed)
        a->count = pencil_list(p, a->bundles, a->rays, a->list);
    a->listed = 1u;
    pencil_fours(p, mode, &tree->blocks[at / 4u], tree->refs + at, keep, a->list, a->count, one);
#else
    for (; keep != 0u; keep &= keep - 1u) {
        const rtk_u32 j = (rtk_u32)__builtin_ctz(keep);
        pencil_triangle(p, mode, &tree->blocks[at / 4u], j, tree->refs[at + j], a->bundles & p->bundles, a->rays, one, NULL);
    }
#endif
}

/* The pencil has met nothing yet. */
RTI_VEC void pencil_mail_open(pencil *p)
{
    for (rtk_u32 i = 0u; i < PENCIL_MAIL; i++)
        p->mail[i].ref = RTK_INVALID;
}

/* Of bundles that may meet a triangle those that have not met it in another leaf. */
RTI_VEC pencil_bits pencil_mail_new(const pencil *p, rtk_u32 ref, pencil_bits bundles)
{
    const rtk_u32 at = ref % PENCIL_MAIL;
    return p->mail[at].ref == ref ? bundles & ~p->mail[at].bundles : bundles;
}

/* All that is left of some bundles meets a triangle. */
RTI_VEC void pencil_mail_met(pencil *p, rtk_u32 ref, pencil_bits bundles)
{
    const rtk_u32 at = ref % PENCIL_MAIL;
    p->mail[at].bundles = bundles | (p->mail[at].ref == ref ? p->mail[at].bundles : 0u);
    p->mail[at].ref = ref;
}

/* A leaf for the rays of some bundles. one: as the pencil's. */
RTI_APART void pencil_leaf(pencil *p, rtk_u32 mode, const rtk_bvhnode *n, rtk_u32 slot, pencil_bits bundles, int one)
{
    const rtk_u32 repeats = one ? p->repeats : 0u;
    const rtk_tree *tree = &p->part->bvh;
    const rtk_u32 begin = n->child[slot], end = begin + n->count[slot];
    pencil_at a;
    a.bundles = bundles;
    a.known = a.listed = 0u;
    if (begin >= 4u * tree->block_count) {
        pencil_refs(p, mode, n, slot, bundles);
        return;
    }
    p->leaves++;
    if (!one || PENCIL_COUNT(bundles) <= PENCIL_BUNDLED) {
        pencil_tell(p, n, slot, &a);
        p->told += a.count;
        if (a.count == 0u)
            return;
    } else {
        p->told += RTK_BLOCK * PENCIL_COUNT(bundles); /* they are many */
    }
    if (a.known && a.count <= PENCIL_LONE(mode)) {
        for (rtk_u32 at = begin / 4u * 4u; at < end; at += 4u)
            pencil_all(p, mode, at, pencil_places(at, begin, end), &a, one);
        return;
    }
    for (rtk_u32 at = begin / 4u * 4u; at < end && (a.bundles &= p->bundles) != 0u; at += 4u) {
        const rtk_bvhblock *b = &tree->blocks[at / 4u];
        pencil_four f;
        const rtk_u32 vectors = pencil_vectors(a.bundles);
        pencil_bits some[RTK_BVH_BLOCK];
        rtk_u32 keep = pencil_see(p, b, &f) & pencil_places(at, begin, end), pairs = 0u;
        for (rtk_u32 l = keep; l != 0u; l &= l - 1u) {
            const rtk_u32 j = (rtk_u32)__builtin_ctz(l);
            some[j] = a.bundles & pencil_meet(p, &f, j, vectors);
            if (repeats && !a.known)
                some[j] = pencil_mail_new(p, tree->refs[at + j], some[j]);
            pairs += PENCIL_COUNT(some[j]);
        }
        if (pairs > PENCIL_PAIRS * PENCIL_COUNT(a.bundles)) {
            pencil_tell(p, n, slot, &a);
#ifdef RTI_PACK8
            if ((a.count + FOUR_RAYS - 1u) / FOUR_RAYS * PENCIL_PRICE(mode) < pairs) {
                pencil_all(p, mode, at, keep, &a, one);
                continue;
            }
#endif
        }
        for (; keep != 0u; keep &= keep - 1u) {
            const rtk_u32 j = (rtk_u32)__builtin_ctz(keep);
            some[j] &= a.bundles & p->bundles;
            pencil_triangle(p, mode, b, j, tree->refs[at + j], some[j], a.known ? a.rays : NULL, one, &f);
            if (repeats && !a.known)
                pencil_mail_met(p, tree->refs[at + j], some[j]);
        }
    }
}

/* Depths behind which bundles look for nothing more, after hits. */
RTI_APART void pencil_reach(pencil *p, rtk_u32 mode)
{
    for (; p->changed != 0u; p->changed &= p->changed - 1u) {
        const rtk_u32 i = PENCIL_FIRST(p->changed);
        p->reach[i] = pencil_end(p, mode, i);
    }
    p->deepest = pencil_high(p->reach, p->end);
}

/* As bvh_expect, and for what a leaf's triangles are called. */
RTI_VEC void pencil_expect_slot(const rtk_tree *tree, const rtk_bvhnode *n, rtk_u32 slot)
{
    bvh_expect(tree, n->child[slot], n->count[slot]);
    __builtin_prefetch((const void *)((uintptr_t)tree->refs + n->child[slot] * sizeof *tree->refs));
}

/* The leaf that waits while what it holds is on its way from farther caches. */
typedef struct pencil_wait {
    const rtk_bvhnode *node; /* NULL: none */
    rtk_u32 slot;
    pencil_bits bundles;
} pencil_wait;

/* Looks through the leaf that waits. */
RTI_VEC void pencil_next(pencil *p, rtk_u32 mode, pencil_wait *w)
{
    const rtk_bvhnode *n = w->node;
    w->node = NULL;
    if (!n || (w->bundles &= p->bundles) == 0u)
        return;
    p->met = 0u;
    if (p->one)
        pencil_leaf(p, mode, n, w->slot, w->bundles, 1);
    else
        pencil_leaf(p, mode, n, w->slot, w->bundles, 0);
    if (p->changed != 0u)
        pencil_reach(p, mode);
    if ((mode & RTK_MODE_ANY) && p->met) {
        p->blocker[p->which].node = n;
        p->blocker[p->which].slot = w->slot;
    }
}

/* The rays of a pencil through its part's tree; returns 0, or 1 when it came apart: then live has those that are not done. */
RTI_APART int pencil_walk(pencil *p, rtk_u32 mode, rtk_u32 count)
{
    const rtk_bvhnode *nodes = p->part->bvh.bvh;
    packet_stack stack;
    pencil_wait wait = {NULL, 0u, 0u};
    rtk_u32 at = 0u, vectors = pencil_vectors(p->bundles), budget = PENCIL_NODES * count + 8u;
    const rtk_u32 leaves = p->leaves + PENCIL_LEAVES * count + PENCIL_AT_ALL, told = p->told;
    stack.top = 0u;
    p->changed = 0u;
    p->repeats = p->part->bvh.kind != RTK_TREE_BVH;
    if (p->one && p->repeats)
        pencil_mail_open(p);
    if ((mode & RTK_MODE_ANY) && p->blocker[p->which].node) {
        const rtk_bvhnode *n = p->blocker[p->which].node;
        const rtk_u32 slot = p->blocker[p->which].slot;
        wait = (pencil_wait){n, slot, pencil_enter(p, n, slot, vectors)};
        pencil_next(p, mode, &wait);
        if (p->bundles == 0u)
            return 0;
    }
    for (;;) {
        float t[RTK_BVH_WIDTH];
        if (budget-- == 0u || p->leaves > leaves + (p->told - told) / 4u)
            return 1;
        const rtk_u32 bits = pencil_open(p, &nodes[at], t);
        packet_push(&stack, at, bits, t, vectors);
        if (p->asked < p->walks_ask)
            pencil_expect(p, mode);
        for (rtk_u32 l = bits; l != 0u; l &= l - 1u)
            pencil_expect_slot(&p->part->bvh, &nodes[at], (rtk_u32)__builtin_ctz(l));
        for (;;) {
            if (stack.top == 0u) {
                pencil_next(p, mode, &wait);
                return 0;
            }
            const rtk_u32 top = --stack.top;
            if (p->away && stack.t[top] > p->deepest)
                continue;
            const rtk_bvhnode *n = &nodes[stack.node[top]];
            const rtk_u32 slot = stack.slot[top];
            const pencil_bits bundles = pencil_enter(p, n, slot, stack.lane[top]);
            if (bundles == 0u)
                continue;
            if (n->count[slot] == 0u) {
                if (!p->one && !pencil_any(p, n, slot, bundles))
                    continue;
                vectors = pencil_vectors(bundles);
                at = n->child[slot];
                break;
            }
            pencil_next(p, mode, &wait);
            if ((mode & RTK_MODE_ANY) && p->bundles == 0u)
                return 0;
            wait = (pencil_wait){n, slot, bundles};
        }
    }
}

#endif
