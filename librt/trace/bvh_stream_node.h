/* What lists of a stream's rays meet in nodes (bvh_stream.h). */
#ifndef RTI_BVH_STREAM_NODE_H
#define RTI_BVH_STREAM_NODE_H

#include "bvh_stream_leaf.h"
#include "bvh_stream_region.h"

/* The slots of a node that hold something; others are inside out. */
RTI_VEC rtk_u32 stream_full(const rtk_bvhnode *n)
{
    rtk_u32 full = 0u;
    for (rtk_u32 h = 0u; h < RTK_BVH_WIDTH; h += NODE_N)
        full |= node_bits(NODE(le)(NODE(load)(n->box[0][0] + h), NODE(load)(n->box[0][1] + h))) << h;
    return full;
}

#ifdef RTI_PACK
/* The rows of a node's planes that an octant's rays meet first, and last, along each axis; of mixed rays its low and its high
 * ones. */
typedef struct stream_planes {
    const float *near[3], *far[3];
} stream_planes;

RTI_VEC stream_planes stream_planes_of(const rtk_bvhnode *n, rtk_u32 mode, rtk_u32 octant)
{
    if (mode & STREAM_MIXED)
        return (stream_planes){{n->box[0][0], n->box[1][0], n->box[2][0]}, {n->box[0][1], n->box[1][1], n->box[2][1]}};
    const rtk_u32 x = octant & 1u, y = octant >> 1 & 1u, z = octant >> 2 & 1u;
    return (stream_planes){{n->box[0][x], n->box[1][y], n->box[2][z]}, {n->box[0][1u - x], n->box[1][1u - y], n->box[2][1u - z]}};
}

/* Where the first of a list's rays enters each slot, in lanes: before one is looked at; and the least of all lanes at the end.
 * Any hit needs no order. */
RTI_VEC void stream_lows_begin(rtk_u32 mode, vec low[RTK_BVH_WIDTH])
{
    for (rtk_u32 i = 0u; i < RTK_BVH_WIDTH; i++)
        low[i] = V(set)(mode & RTK_MODE_ANY ? STREAM_FRONT : RTK_INF);
}
RTI_VEC void stream_lows_end(rtk_u32 mode, const vec low[RTK_BVH_WIDTH], float least[RTK_BVH_WIDTH])
{
    rti_f8_store(least, mode & RTK_MODE_ANY ? rti_f8_set(STREAM_FRONT) : rti_f16_lows8(low));
}

/* Sixteen rays, fields of stream_ray, against slot i of a node: those that enter it, and where each does. */
RTI_VEC rtk_u32 stream_open_slot(rtk_u32 mode, const stream_planes *planes, rtk_u32 i, const vec r[8], vec *t0)
{
    vec in[3], out[3];
    for (rtk_u32 k = 0u; k < 3u; k++) {
        const vec x = V(msub)(V(set)(planes->near[k][i]), r[k], r[3u + k]), y = V(msub)(V(set)(planes->far[k][i]), r[k], r[3u + k]);
        in[k] = mode & STREAM_MIXED ? V(min)(x, y) : x;
        out[k] = mode & STREAM_MIXED ? V(max)(x, y) : y;
    }
    *t0 = V(max)(V(max)(in[0], in[1]), V(max)(in[2], r[6]));
    return VM(bits)(V(le)(*t0, V(min)(V(min)(out[0], out[1]), V(min)(out[2], r[7]))));
}

/* Against the slots `there`, of closest hits against all: those of `of` that enter slot i to to[i], and where the first of each
 * lane does to low[i]. */
RTI_VEC void stream_open_sixteen(rtk_u32 mode, const stream_planes *planes, rtk_u32 there, const vec r[8], rtk_u32 of,
                                 uint16_t *to, vec low[RTK_BVH_WIDTH])
{
    vec t0;
    if (mode & RTK_MODE_ANY) {
        for (; there != 0u; there &= there - 1u) {
            const rtk_u32 i = (rtk_u32)__builtin_ctz(there);
            to[i * STREAM_SLOTS] = (uint16_t)(stream_open_slot(mode, planes, i, r, &t0) & of);
        }
        return;
    }
#pragma GCC unroll 8
    for (rtk_u32 i = 0u; i < RTK_BVH_WIDTH; i++) {
        const rtk_u32 bits = stream_open_slot(mode, planes, i, r, &t0) & of;
        to[i * STREAM_SLOTS] = (uint16_t)bits;
        low[i] = V(min)(low[i], V(select)(VM(of)(bits), t0, low[i]));
    }
}

/* The slots that an any hit need look at (bvh_stream_region.h). */
RTI_VEC rtk_u32 stream_open_there(const stream *s, rtk_u32 mode, const rtk_bvhnode *n)
{
    return mode & RTK_MODE_ANY ? stream_slots_there(s, n) : 255u;
}

/* The slots of a node, of those `there`, that some of its `size` masks each have; rays: how many bits those have. */
RTI_VEC rtk_u32 stream_entered(const streams *a, const rtk_bvhnode *n, rtk_u32 there, rtk_u32 size, rtk_u32 rays[RTK_BVH_WIDTH])
{
    rtk_u32 all = 0u;
    there &= stream_full(n);
    for (rtk_u32 i = 0u; i < RTK_BVH_WIDTH; i++) {
        rays[i] = 0u;
        if (!(there >> i & 1u))
            continue;
        for (rtk_u32 k = 0u; k < size; k += 4u) {
            uint64_t four;
            memcpy(&four, a->slots[i] + k, sizeof four);
            if (size - k < 4u)
                four &= ((uint64_t)1u << 16u * (size - k)) - 1u;
            rays[i] += (rtk_u32)__builtin_popcountll(four);
        }
        all |= (rtk_u32)(rays[i] != 0u) << i;
    }
    return all;
}

/* stream_open for many rays. */
RTI_VEC rtk_u32 stream_open_many(streams *a, const stream *s, rtk_u32 mode, rtk_u32 octant, const rtk_bvhnode *n,
                                 const uint16_t *ids, rtk_u32 size, float least[RTK_BVH_WIDTH])
{
    const stream_planes planes = stream_planes_of(n, mode, octant);
    const rtk_u32 there = stream_open_there(s, mode, n);
    rtk_u32 rays[RTK_BVH_WIDTH];
    vec low[RTK_BVH_WIDTH];
    stream_lows_begin(mode, low);
    for (rtk_u32 at = 0u; at < size; at += 16u) {
        uint16_t last[16];
        const uint16_t *some = ids + at;
        rtk_u32 of = 0xffffu;
        vec r[8];
        if (size - at < 16u) { /* and one of them again */
            rti_u16_last(last, ids + at, size - at);
            some = last;
            of = (1u << (size - at)) - 1u;
        }
        rti_f16_records(s->ray[0].inv, some, r);
        stream_open_sixteen(mode, &planes, there, r, of, &a->slots[0][at / 16u], low);
    }
    stream_lows_end(mode, low, least);
    return stream_entered(a, n, there, (size + 15u) / 16u, rays);
}
#endif

/* A node's planes as an octant's rays meet them, or of mixed ones its boxes' middles and halves. */
typedef struct stream_boxes {
    bvh_vec near[3][RTK_BVH_WIDTH / NODE_N], far[3][RTK_BVH_WIDTH / NODE_N];
} stream_boxes;

RTI_VEC void stream_boxes_of(const rtk_bvhnode *n, rtk_u32 mode, rtk_u32 octant, float scale, stream_boxes *box)
{
    for (rtk_u32 k = 0u; k < 3u; k++) {
        const rtk_u32 back = octant >> k & 1u;
        for (rtk_u32 h = 0u; h < RTK_BVH_WIDTH / NODE_N; h++) {
            box->near[k][h] = NODE(load)(n->box[k][back] + h * NODE_N);
            box->far[k][h] = NODE(load)(n->box[k][1u - back] + h * NODE_N);
            if (mode & STREAM_MIXED)
                stream_middles(n, k, h * NODE_N, scale, &box->near[k][h], &box->far[k][h]);
        }
    }
}

/* Which of a list's rays enter which slots; least: where the first of them enters each. turned: a->slots tells, of each slot's rays
 * sixteen by sixteen, else a->bits, of each ray's slots. Returns which of a node's slots are entered. */
RTI_VEC rtk_u32 stream_open(streams *a, const stream *s, rtk_u32 mode, rtk_u32 octant, const rtk_bvhnode *n, const uint16_t *ids,
                            rtk_u32 size, float least[RTK_BVH_WIDTH], int *turned)
{
    *turned = 0;
#ifdef RTI_PACK
    if (size >= STREAM_TURNED) {
        *turned = 1;
        return stream_open_many(a, s, mode, octant, n, ids, size, least);
    }
#elif defined RTI_PACK8
    if ((mode & RTK_MODE_ANY) && size >= STREAM_REGION && a->middles) {
        const rtk_u32 some = stream_slots_there(s, n);
        if (__builtin_popcount(some) <= STREAM_THERE) {
            *turned = 1;
            rti_f8_store(least, rti_f8_set(STREAM_FRONT));
            return stream_open_some(a, s, n, some, ids, size);
        }
    }
#endif
    enum { HALVES = RTK_BVH_WIDTH / NODE_N };
    stream_boxes box;
    bvh_vec low[HALVES];
    rtk_u32 all = 0u;
    stream_boxes_of(n, mode, octant, a->part->scale, &box);
    for (rtk_u32 h = 0u; h < HALVES; h++)
        low[h] = NODE(set)(mode & RTK_MODE_ANY ? STREAM_FRONT : RTK_INF); /* any hit needs no order */
    for (rtk_u32 i = 0u; i < size; i++) {
        const stream_ray *r = &s->ray[ids[i]];
        rtk_u32 miss = 0u;
        for (rtk_u32 h = 0u; h < HALVES; h++) {
            bvh_vec in[3], out[3];
            for (rtk_u32 k = 0u; k < 3u; k++) {
                const bvh_vec inv = NODE(set)(r->inv[k]), start = NODE(set)(r->start[k]);
                in[k] = NODE(msub)(box.near[k][h], inv, start);
                if (mode & STREAM_MIXED) {
                    const bvh_vec middle = in[k], off = box.far[k][h] * NODE(abs)(inv);
                    in[k] = middle - off;
                    out[k] = middle + off;
                } else {
                    out[k] = NODE(msub)(box.far[k][h], inv, start);
                }
            }
            const bvh_vec t0 = NODE(max)(NODE(max)(in[0], in[1]), NODE(max)(in[2], NODE(set)(r->t0)));
            const bvh_vec t1 = NODE(min)(NODE(min)(out[0], out[1]), NODE(min)(out[2], NODE(set)(r->t1)));
            const bvh_mask past = NODE(lt)(t1, t0);
            if (!(mode & RTK_MODE_ANY))
                low[h] = NODE(min)(NODE(unless)(past, t0), low[h]);
            miss |= node_bits(past) << h * NODE_N;
        }
        a->bits[i] = (uint8_t)~miss;
        all |= ~miss;
    }
    for (rtk_u32 h = 0u; h < HALVES; h++)
        NODE(store)(least + h * NODE_N, low[h]);
    return all & (mode & STREAM_MIXED ? stream_full(n) : 255u);
}

/* The numbers in the list of a slot: of `size` of ids those with its bit. turned: as stream_open says. Returns how many. */
RTI_VEC rtk_u32 stream_deal(const streams *a, uint16_t *to, const uint16_t *ids, rtk_u32 size, rtk_u32 slot, int turned)
{
    rtk_u32 end = 0u;
    (void)turned;
#ifdef RTI_PACK
    if (!turned)
        return rti_u16_deal(to, ids, rti_b16_load(a->bits), slot, size);
    for (rtk_u32 from = 0u; from < size; from += 32u) {
        rtk_u32 b;
        memcpy(&b, &a->slots[slot][from / 16u], sizeof b);
        end += rti_u16_put32(to + end, ids + from, size - from < 32u ? b & ((1u << (size - from)) - 1u) : b);
    }
#elif defined RTI_PACK8
    for (rtk_u32 from = 0u; turned && from < size; from += 16u) {
        const rtk_u32 b = a->slots[slot][from / 16u]; /* behind the last eight rays stands anything */
        end += rti_u16_put(to + end, ids + from, size - from < 16u ? b & ((1u << (size - from)) - 1u) : b);
    }
    for (rtk_u32 from = 0u; !turned && from < size; from += 16u)
        end += rti_u16_deal(to + end, ids + from, rti_b16_load(a->bits + from), slot, size - from);
#else
    for (rtk_u32 from = 0u; from < size; from++) {
        to[end] = ids[from];
        end += a->bits[from] >> slot & 1u;
    }
#endif
    return end;
}

/* The slots `all` of a node onto the stack, the nearest on top, without their lists: s->top stays. slots: which they are, in that
 * order. */
RTI_VEC void stream_slots(stream *s, rtk_u32 mode, const rtk_bvhnode *n, rtk_u32 all, const float least[RTK_BVH_WIDTH],
                          rtk_u32 slots[RTK_BVH_WIDTH])
{
#ifdef RTI_PACK8
    static const float in_order[RTK_BVH_WIDTH] = {0.0f, 1.0f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f, 7.0f};
    if (mode & RTK_MODE_ANY) { /* slots in their order (accel/bvh_order.c) */
        rti_f8_sorted(s->enter + s->top, slots, all, rti_f8_load(in_order));
        rti_f8_store(s->enter + s->top, rti_f8_load(least));
    } else {
        rti_f8_sorted(s->enter + s->top, slots, all, rti_f8_load(least));
    }
    rti_u8_take(s->child + s->top, n->child, slots);
    rti_u8_take(s->count + s->top, n->count, slots);
#else
    rtk_u32 count = 0u;
    for (; all != 0u; all &= all - 1u) {
        const rtk_u32 i = (rtk_u32)__builtin_ctz(all);
        rtk_u32 to = count++;
        for (; to > 0u && (mode & RTK_MODE_ANY || least[slots[to - 1u]] < least[i]); to--)
            slots[to] = slots[to - 1u];
        slots[to] = i;
    }
    for (rtk_u32 k = 0u; k < count; k++) {
        s->child[s->top + k] = n->child[slots[k]];
        s->count[s->top + k] = n->count[slots[k]];
        s->enter[s->top + k] = least[slots[k]];
    }
#endif
}

/* The slots `all` of a node onto the stack, with the lists of those of `size` rays that enter them, from `used` on. turned: as
 * stream_open says. */
RTI_VEC void stream_push(streams *a, stream *s, rtk_u32 mode, const rtk_bvhnode *n, rtk_u32 all,
                         const float least[RTK_BVH_WIDTH], int turned, const uint16_t *ids, rtk_u32 size, rtk_u32 used)
{
    rtk_u32 slots[RTK_BVH_WIDTH];
    const rtk_u32 count = (rtk_u32)__builtin_popcount(all);
    const rtk_u32 begin = used;
    stream_slots(s, mode, n, all, least, slots);
    for (rtk_u32 k = 0u; k < count; k++) {
        const rtk_u32 some = stream_deal(a, s->list + used, ids, size, slots[k], turned);
        s->lists[s->top++] = used | some << 16;
        used += some;
    }
    if (STREAM_TELLS(mode))
        a->entered += used - begin;
}

/* A ray that is alone in its list, from a node on: it goes into the nearest of its slots at once, the others wait. */
RTI_VEC void stream_one(streams *a, stream *s, rtk_u32 mode, rtk_u32 octant, rtk_u32 list, rtk_u32 at)
{
    const rtk_u32 l = s->list[list & 0xffffu];
    const stream_ray *r = &s->ray[l];
    if (mode & STREAM_MIXED)
        octant = rtk_bits(r->inv[0]) >> 31 | rtk_bits(r->inv[1]) >> 31 << 1 | rtk_bits(r->inv[2]) >> 31 << 2;
    for (;;) {
        const rtk_bvhnode *n = &a->tree.bvh[at];
        float t[RTK_BVH_WIDTH];
        rtk_u32 bits = 0u, i, count, top = s->top;
        for (rtk_u32 h = 0u; h < RTK_BVH_WIDTH; h += NODE_N) {
            const bvh_vec ix = NODE(set)(r->inv[0]), iy = NODE(set)(r->inv[1]), iz = NODE(set)(r->inv[2]);
            const bvh_vec sx = NODE(set)(r->start[0]), sy = NODE(set)(r->start[1]), sz = NODE(set)(r->start[2]);
            const rtk_u32 x = octant & 1u, y = octant >> 1 & 1u, z = octant >> 2 & 1u;
#define ROW(axis, side) NODE(load)(n->box[axis][side] + h)
            const bvh_vec t0 = NODE(max)(NODE(max)(NODE(msub)(ROW(0, x), ix, sx), NODE(msub)(ROW(1, y), iy, sy)),
                                         NODE(max)(NODE(msub)(ROW(2, z), iz, sz), NODE(set)(r->t0)));
            const bvh_vec t1 = NODE(min)(NODE(min)(NODE(msub)(ROW(0, 1u - x), ix, sx), NODE(msub)(ROW(1, 1u - y), iy, sy)),
                                         NODE(min)(NODE(msub)(ROW(2, 1u - z), iz, sz), NODE(set)(r->t1)));
#undef ROW
            NODE(store)(t + h, t0);
            bits |= node_bits(NODE(le)(t0, t1)) << h;
        }
        if (bits == 0u)
            return;
        i = bvh_choose(n, bits, t, s->enter, s->child, s->count, &s->top);
        for (; top < s->top; top++)
            s->lists[top] = list;
        at = n->child[i];
        count = n->count[i];
        if (a->turns) { /* while others have theirs, what comes next is on its way */
            s->child[s->top] = at;
            s->count[s->top] = count;
            s->enter[s->top] = t[i];
            s->lists[s->top++] = list;
            return;
        }
        if (count != 0u) {
            if (at < 4u * a->tree.block_count)
                stream_leaf_one(a, s, mode, l, at, count);
            else
                stream_leaf(a, s, mode, stream_still(a, s, s->list + (list & 0xffffu), 1u, t[i]), at, count);
            return;
        }
    }
}

#endif
