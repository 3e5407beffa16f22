/* One ray by itself through eight-wide nodes (bvh_lone.h): its walk, and how it is made ready. */
#ifndef RTI_BVH_LONE_WALK_H
#define RTI_BVH_LONE_WALK_H

#include "bvh_lone_ball.h"

/* Blocks of a tree, in bytes, from which on one ray asks ahead for all that it enters: below, to ask for what it will not look
 * at, as something nearer is hit, costs more than it saves. (Without, on a Zen 1 with 8 MiB for both of its cores: staircase and
 * breakfast, some 10 MiB, .88 to .98 of the time; a million triangles camera rays .96, ones from all over 1.14.) */
#define LONE_LARGE ((size_t)24 << 20)

/* What waits: where a slot is entered, its child, its count, each so far behind the other that a place is one pointer. (A leaf
 * that is none at the bottom, so that nobody asks whether anything waits: .92 to .98 of the rate of rays without order.) */
#define LONE_STACK (RTK_BVH_STACK + RTK_BVH_WIDTH)
typedef union lone_word {
    float t;
    rtk_u32 n;
} lone_word;
typedef struct lone_stack {
    lone_word words[3 * LONE_STACK];
} lone_stack;

RTI_VEC void lone_push(lone_word **top, const rtk_bvhnode *n, size_t slot, float t)
{
    lone_word *p = (*top)++;
    p[0].t = t;
    p[LONE_STACK].n = n->child[slot];
    p[2 * LONE_STACK].n = n->count[slot];
}

/* Of the slots in bits, of which there is one, the one that is entered first; the others wait, the nearest on top. */
RTI_VEC size_t lone_choose(lone_word **top, const rtk_bvhnode *n, rtk_u32 bits, const float t[RTK_BVH_WIDTH])
{
    const size_t first = (size_t)__builtin_ctz(bits);
    const rtk_u32 rest = bits & (bits - 1u);
    if (rest == 0u)
        return first;
    const size_t second = (size_t)__builtin_ctz(rest);
    if ((rest & (rest - 1u)) == 0u) {
        const size_t far = t[second] < t[first] ? first : second;
        lone_push(top, n, far, t[far]);
        return first ^ second ^ far;
    }
#ifdef RTI_PACK8
    lone_word *p = *top;
    *top = p + __builtin_popcount(bits) - 1;
    return rti_f8_queue(&p->t, &p[LONE_STACK].n, &p[2 * LONE_STACK].n, bits, rti_f8_load(t), n->child, n->count);
#else
    rtk_u32 slots[RTK_BVH_WIDTH], count = 0u;
    for (; bits != 0u; bits &= bits - 1u) {
        const rtk_u32 i = (rtk_u32)__builtin_ctz(bits);
        rtk_u32 to = count++;
        for (; to > 0u && t[slots[to - 1u]] < t[i]; to--)
            slots[to] = slots[to - 1u];
        slots[to] = i;
    }
    for (rtk_u32 k = 0u; k + 1u < count; k++)
        lone_push(top, n, slots[k], t[slots[k]]);
    return slots[count - 1u];
#endif
}

/* What stands in a leaf. Returns 1 when the walk may end. */
typedef int lone_leaf(lone *l, rtk_u32 at, rtk_u32 count);

/* Leaves have registers of their own. Few are of more than one step. */
#define LONE_LEAF(name, many, mode, step)                                                                                        \
    RTI_APART int many(lone *l, rtk_u32 at, rtk_u32 count);                                                                      \
    RTI_APART int name(lone *l, rtk_u32 at, rtk_u32 count)                                                                       \
    {                                                                                                                            \
        return __builtin_expect(at % 4u + count > NODE_N, 0) ? many(l, at, count) : step(l, mode, at, count);               \
    }                                                                                                                            \
    RTI_APART int many(lone *l, rtk_u32 at, rtk_u32 count)                                                                       \
    {                                                                                                                            \
        for (rtk_u32 n = NODE_N - at % 4u; count > n; at += n, count -= n, n = NODE_N)                                           \
            if (name(l, at, n))                                                                                                  \
                return 1;                                                                                                        \
        return name(l, at, count);                                                                                               \
    }
LONE_LEAF(lone_leaf_closest, lone_leaf_closest_many, 0u, lone_step)
LONE_LEAF(lone_leaf_any, lone_leaf_any_many, RTK_MODE_ANY, lone_step)
LONE_LEAF(lone_leaf_closest_outer, lone_leaf_closest_outer_many, 0u, lone_step_outer)
LONE_LEAF(lone_leaf_any_outer, lone_leaf_any_outer_many, RTK_MODE_ANY, lone_step_outer)
#undef LONE_LEAF

/* References that stand in no blocks; and those of them that have forms. */
#define LONE_REFS(name, forms, mode)                                                                                             \
    RTI_APART int forms(lone *l, rtk_u32 at, rtk_u32 count)                                                                      \
    {                                                                                                                            \
        return lone_balls(l, mode, at, count, RTK_FORM);                                                                         \
    }                                                                                                                            \
    RTI_APART int name(lone *l, rtk_u32 at, rtk_u32 count)                                                                       \
    {                                                                                                                            \
        if (l->tree->ball_count != 0u && l->outer == 0.0f)                                                                       \
            return l->tree->ball_size == RTK_FORM ? forms(l, at, count) : lone_balls(l, mode, at, count, RTK_BALL);              \
        for (rtk_u32 k = 0u; k < count; k++)                                                                                     \
            if (lone_ask(l, mode, l->tree->refs[at + k]))                                                                        \
                return 1;                                                                                                        \
        return 0;                                                                                                                \
    }
LONE_REFS(lone_refs_closest, lone_forms_closest, 0u)
LONE_REFS(lone_refs_any, lone_forms_any, RTK_MODE_ANY)
#undef LONE_REFS

/* Bytes at which rows of a node's boxes begin, the ones by which a ray comes in first, by the bits of the axes along which it
 * goes down. */
typedef struct lone_rows {
    rtk_u32 in[3], out[3];
} lone_rows;
#define LO(axis) (2u * (axis) * sizeof(float[RTK_BVH_WIDTH]))
#define HI(axis) (LO(axis) + sizeof(float[RTK_BVH_WIDTH]))
#define ROWS(x, y, z)                                                                                                            \
    {                                                                                                                            \
        {x(0), y(1), z(2)},                                                                                                      \
        {                                                                                                                        \
            x##_(0), y##_(1), z##_(2)                                                                                            \
        }                                                                                                                        \
    }
#define LO_ HI
#define HI_ LO
static const lone_rows lone_sides[8] = {ROWS(LO, LO, LO), ROWS(HI, LO, LO), ROWS(LO, HI, LO), ROWS(HI, HI, LO),
                                        ROWS(LO, LO, HI), ROWS(HI, LO, HI), ROWS(LO, HI, HI), ROWS(HI, HI, HI)};
#undef LO
#undef HI
#undef ROWS
#undef LO_
#undef HI_

/* Where the rows of a tree's first node stand: from a child's number to its boxes there is but a shift then. */
typedef struct lone_way {
    const char *nodes, *in[3], *out[3];
} lone_way;
RTI_VEC const char *lone_row(const char *nodes, rtk_u32 row)
{
    nodes += row;
    LONE_AGAIN(nodes);
    return nodes;
}
RTI_VEC lone_way lone_way_of(const lone *l)
{
    const lone_rows *rows = &lone_sides[l->back];
    const char *const n = (const char *)l->tree->bvh;
    return (lone_way){n,
                      {lone_row(n, rows->in[0]), lone_row(n, rows->in[1]), lone_row(n, rows->in[2])},
                      {lone_row(n, rows->out[0]), lone_row(n, rows->out[1]), lone_row(n, rows->out[2])}};
}

/* A ray as nodes are asked of it: in registers, which leaves have for themselves. */
typedef struct lone_sight {
    bvh_vec inv[3], start[3], t0, far, first;
} lone_sight;
/* Where it enters the tree, a number. */
RTI_VEC float lone_first(const lone *l)
{
    return rtk_max(l->t0, -3.402823466e38f);
}
RTI_VEC lone_sight lone_sight_of(const lone *l, float end)
{
    return (lone_sight){{NODE(set)(l->inv[0]), NODE(set)(l->inv[1]), NODE(set)(l->inv[2])},
                        {NODE(set)(l->start[0]), NODE(set)(l->start[1]), NODE(set)(l->start[2])},
                        NODE(set)(l->t0),
                        NODE(set)(end),
                        NODE(set)(lone_first(l))};
}
/* Behind this no box is entered. Of sums, what three roundings can be off is added (bvh_reach). */
RTI_VEC float lone_end(const lone *l, int moved)
{
    const float far = l->far;
    if (!moved)
        return far;
    return rtk_min(((far - l->outer) - l->shift) + 9.5367432e-07f * (rtk_fabs(far) + rtk_fabs(l->outer) + rtk_fabs(l->shift)),
                   l->t1);
}
RTI_VEC size_t lone_offset(rtk_u32 node)
{
    return (size_t)node * sizeof(rtk_bvhnode);
}
RTI_VEC const rtk_bvhnode *lone_node(const lone_way *w, size_t offset)
{
    const char *n = w->nodes + offset;
    LONE_AGAIN(n);
    return (const rtk_bvhnode *)(const void *)n;
}
/* What a slot holds. */
RTI_VEC void lone_enter(const rtk_bvhnode *n, size_t slot, rtk_u32 *at, rtk_u32 *count)
{
    const rtk_u32 *child = n->child;
    LONE_AGAIN(child);
    *at = child[slot];
    *count = child[RTK_BVH_WIDTH + slot];
}
_Static_assert(offsetof(rtk_bvhnode, count) == offsetof(rtk_bvhnode, child) + RTK_BVH_WIDTH * sizeof(rtk_u32),
               "counts stand behind children");

/* The slots that the ray enters of the node that begins at `offset`, and where; ahead: measured from where it enters the tree, for
 * where its origin was moved that may be in front of it, and slots wait in the order of sizes (rti_f8_queue). */
RTI_VEC rtk_u32 lone_open(const lone_way *w, const lone_sight *v, size_t offset, int ahead, float t[RTK_BVH_WIDTH])
{
    rtk_u32 bits = 0u;
    for (rtk_u32 h = 0u; h < RTK_BVH_WIDTH; h += NODE_N) {
#define PLANE(side, k) NODE(msub)(NODE(load)((const float *)(const void *)(w->side[k] + offset) + h), v->inv[k], v->start[k])
        const bvh_vec t0 = NODE(max)(NODE(max)(PLANE(in, 0), PLANE(in, 1)), NODE(max)(PLANE(in, 2), v->t0));
        const bvh_vec t1 = NODE(min)(NODE(min)(PLANE(out, 0), PLANE(out, 1)), NODE(min)(PLANE(out, 2), v->far));
#undef PLANE
        if (ahead)
            NODE(store)(t + h, t0 - v->first);
        else
            NODE(store)(t + h, t0);
        bits |= node_bits(NODE(le)(t0, t1)) << h;
    }
    return bits;
}

/* Asks for what the slots hold, of a large tree. */
RTI_VEC void lone_expect_slots(const lone *l, const rtk_bvhnode *n, rtk_u32 bits, int large)
{
    for (rtk_u32 w = large ? bits : 0u; w != 0u; w &= w - 1u)
        bvh_expect(l->tree, n->child[__builtin_ctz(w)], n->count[__builtin_ctz(w)]);
}

/* Children and counts of a node's slots, those in bits, side by side. Returns the place behind them. */
RTI_VEC rtk_u32 *lone_wait(rtk_u32 *top, rtk_u32 bits, const rtk_bvhnode *n)
{
#ifdef RTI_PACK
    rti_u8_pairs(top, bits, n->child, n->count);
    top += 2u * (rtk_u32)__builtin_popcount(bits);
#else
    for (; bits != 0u; bits &= bits - 1u) {
        *top++ = n->child[__builtin_ctz(bits)];
        *top++ = n->count[__builtin_ctz(bits)];
    }
#endif
    return top;
}

/* The way to the closest hit. leaf, refs: who is asked of leaves that stand in blocks, and of others. */
RTI_VEC int lone_closest(lone *l, int large, int moved, lone_leaf leaf, lone_leaf refs)
{
    const lone_way w = lone_way_of(l);
    lone_stack s;
    lone_word *top = s.words + 1;
    s.words[0].t = -RTK_INF;
    s.words[LONE_STACK].n = 0u;
    s.words[2 * LONE_STACK].n = 0u;
    for (;;) { /* once a leaf */
        const float end = lone_end(l, moved), last = moved ? end - lone_first(l) : end;
        const lone_sight v = lone_sight_of(l, end);
        rtk_u32 at, count;
        do {
            do {
                if (top == s.words) {
                    lone_settle(l);
                    return 0;
                }
                top--;
            } while (top[0].t > last);
            at = top[LONE_STACK].n;
            count = top[2 * LONE_STACK].n;
            while (count == 0u) {
                float t[RTK_BVH_WIDTH];
                const size_t offset = lone_offset(at);
                const rtk_bvhnode *const n = lone_node(&w, offset);
                const rtk_u32 bits = lone_open(&w, &v, offset, moved, t);
                if (bits == 0u)
                    break;
                lone_expect_slots(l, n, bits, large);
                lone_enter(n, lone_choose(&top, n, bits, t), &at, &count);
            }
        } while (count == 0u);
        if (at < l->places) {
            if (leaf(l, at, count))
                return 1;
        } else if (refs(l, at, count)) {
            return 1;
        }
    }
}

/* The way to any hit, which asks for no order but that of slots (accel/bvh_order.c): what waits are pairs of a child
 * and a count. */
RTI_VEC int lone_any(lone *l, int large, int moved, lone_leaf leaf, lone_leaf refs)
{
    const lone_way w = lone_way_of(l);
    rtk_u32 stack[2u * LONE_STACK], *top = stack, at = 0u, count = 0u;
    for (;;) { /* once a leaf */
        const lone_sight v = lone_sight_of(l, lone_end(l, moved));
        while (count == 0u) {
            float t[RTK_BVH_WIDTH];
            const size_t offset = lone_offset(at);
            const rtk_bvhnode *const n = lone_node(&w, offset);
            const rtk_u32 bits = lone_open(&w, &v, offset, 0, t);
            if (bits == 0u) {
                if (top == stack)
                    return 0;
                top -= 2;
                at = top[0];
                count = top[1];
                continue;
            }
            lone_expect_slots(l, n, bits, large);
            const rtk_u32 rest = bits & (bits - 1u), more = rest & (rest - 1u);
            if (more != 0u)
                top = lone_wait(top, more, n);
            if (rest != 0u) { /* most often the only one, and soon asked for */
                *top++ = n->child[__builtin_ctz(rest)];
                *top++ = n->count[__builtin_ctz(rest)];
            }
            lone_enter(n, (rtk_u32)__builtin_ctz(bits), &at, &count);
        }
        if (at < l->places) {
            if (leaf(l, at, count))
                return 1;
        } else if (refs(l, at, count)) {
            return 1;
        }
        if (top == stack)
            return 0;
        top -= 2;
        at = top[0];
        count = top[1];
    }
}

#define LONE_WALK(name, kind, large, moved, outer)                                                                               \
    RTI_APART int lone_walk_##name(lone *l)                                                                                      \
    {                                                                                                                            \
        return lone_##kind(l, large, moved, lone_leaf_##kind##outer, lone_refs_##kind);                                          \
    }
LONE_WALK(closest, closest, 0, 0, )
LONE_WALK(closest_large, closest, 1, 0, )
LONE_WALK(closest_moved, closest, bvh_larger(l->tree, LONE_LARGE), 1, )
LONE_WALK(closest_outer, closest, bvh_larger(l->tree, LONE_LARGE), 1, _outer)
LONE_WALK(any, any, 0, 0, )
LONE_WALK(any_large, any, 1, 0, )
LONE_WALK(any_moved, any, bvh_larger(l->tree, LONE_LARGE), 1, )
LONE_WALK(any_outer, any, bvh_larger(l->tree, LONE_LARGE), 1, _outer)
#undef LONE_WALK

/* The walk, from *l on. Returns 1 when any hit was asked for, and there is one. */
RTI_VEC int lone_walk(lone *l, rtk_u32 mode)
{
    if (l->outer != 0.0f)
        return mode & RTK_MODE_ANY ? lone_walk_any_outer(l) : lone_walk_closest_outer(l);
    if (l->shift != 0.0f)
        return mode & RTK_MODE_ANY ? lone_walk_any_moved(l) : lone_walk_closest_moved(l);
    if (bvh_larger(l->tree, LONE_LARGE))
        return mode & RTK_MODE_ANY ? lone_walk_any_large(l) : lone_walk_closest_large(l);
    return mode & RTK_MODE_ANY ? lone_walk_any(l) : lone_walk_closest(l);
}

/* Does a tree hold anything that leaves ask in vectors? */
RTI_VEC int lone_tree(const rtk_tree *tree)
{
    return (tree->block_count | tree->ball_count) != 0u;
}

/* Do the three lanes that count? */
RTI_VEC int lone_all(rti_m4 m)
{
    return (rti_m4_bits(m) & 7u) == 7u;
}

/* What both kinds of rays share: inv as rtk_inverse has it, org in the caller's order of axes, of four lanes three count. */
RTI_VEC void lone_turn_to(lone *l, const rtk_tree *tree, float scale, rti_f4 org, rti_f4 inv)
{
    rti_f4_store(l->inv, inv);
    rti_f4_store(l->start, org * inv);
    l->back = rti_m4_bits(rti_f4_lt(inv, rti_f4_set(0.0f))) & 7u;
    l->tree = tree;
    l->places = RTK_BVH_BLOCK * tree->block_count;
    l->scale = scale;
    l->late = RTK_INVALID;
}

/* As that, and ready for spheres, too. 0: it is too near to the ends of the floats' range to meet boxes by plane * inv - start. */
RTI_VEC int lone_ready(lone *l, const rtk_tree *tree, float scale, rti_f4 org, rti_f4 dir, rti_f4 inv)
{
    lone_turn_to(l, tree, scale, org, inv);
    if (tree->ball_count != 0u)
        lone_ball_ready(l, org, dir);
    if (__builtin_expect(rtk_scale_ordinary(scale), 1))
        return 1;
    return lone_all(rti_m4_and(rti_f4_le(rti_f4_abs(org * inv), rti_f4_set(BVH_START_MOST)),
                               rti_f4_le(rti_f4_set(BVH_START_LEAST), rti_f4_abs(inv) * rti_f4_set(scale))));
}

/* A prepared ray through a tree whose hits all count; 0: this is not for it. end: as lone_walk returns. */
RTI_VEC int lone_group(rtk_query *q, rtk_u32 mode, const rtk_tree *tree, const rtk_pray *r, int *end)
{
    const float dir[3] = {r->dir.x, r->dir.y, r->dir.z};
    const rtk_u32 row = sizeof(float[RTK_BVH_BLOCK]);
    lone l;
    if (!lone_ready(&l, tree, r->scale, (rti_f4){r->org.x, r->org.y, r->org.z, 0.0f}, (rti_f4){dir[0], dir[1], dir[2], 0.0f},
                    (rti_f4){r->inv.x, r->inv.y, r->inv.z, 1.0f}))
        return 0;
    rti_f4_store(l.less, (rti_f4){-r->korg.x, -r->korg.y, -r->korg.z, r->tmin});
    rti_f4_store(l.dir, (rti_f4){dir[r->kx], dir[r->ky], r->kdz, r->tmax});
    l.sx = r->sx;
    l.sy = r->sy;
    l.row[0] = r->kx * row;
    l.row[1] = r->ky * row;
    l.row[2] = r->kz * row;
    l.group = q->group;
    l.part = NULL;
    l.q = q;
    l.r = r;
    l.inst = q->inst;
    l.best = q->best;
    l.t = q->best.t;
    l.t0 = r->t0;
    l.t1 = r->t1;
    l.shift = r->tshift;
    l.outer = 0.0f;
    l.far = l.shift != 0.0f ? rtk_min(r->tmax, l.t) : rtk_min(r->t1, l.t);
    *end = l.t0 <= lone_end(&l, l.shift != 0.0f) && lone_walk(&l, mode);
    q->best = l.best;
    return 1;
}

#endif
