/* Dense lists of a stream's rays (bvh_stream.h): blocks of sixteen rays that lie side by side, and behind those which of each
 * block's rays. So a node meets the rays as they lie, none is looked up, and lists are made of masks. Near the root most lists
 * are dense, of ambient occlusion four rays of five are then; where blocks become half empty they go on as plain lists.
 */
#ifndef RTI_BVH_STREAM_DENSE_H
#define RTI_BVH_STREAM_DENSE_H

#include "bvh_stream_node.h"

#ifdef RTI_PACK
#define STREAM_DENSE       0x80000000u /* beside a list: it is dense; its size counts blocks */
#define STREAM_DENSE_RAYS  10u         /* of a block, on average, from which on a list is dense, */
#define STREAM_DENSE_LEAST 33u         /* and of all */

/* All of a stream's rays are at the root. */
RTI_VEC void stream_start_dense(stream *s)
{
    const rtk_u32 blocks = (s->n + 15u) / 16u;
    for (rtk_u32 b = 0u; b < blocks; b++) {
        uint16_t ids[16];
        vec r[8];
        for (rtk_u32 i = 0u; i < 16u; i++)
            ids[i] = (uint16_t)(16u * b + i);
        rti_f16_records(s->ray[0].inv, ids, r);
        for (rtk_u32 k = 0u; k < 8u; k++)
            V(store)(s->wide[b][k], r[k]);
        s->list[b] = (uint16_t)b;
        s->list[blocks + b] = (uint16_t)(s->n - 16u * b < 16u ? (1u << (s->n - 16u * b)) - 1u : 0xffffu);
    }
    s->lists[0] = STREAM_DENSE | blocks << 16;
}

/* The rays of a dense list that have found no hit before `enter` since, to a->now. Returns how many. */
RTI_VEC rtk_u32 stream_still_dense(streams *a, const stream *s, const uint16_t *list, rtk_u32 size, float enter)
{
    const vec from = V(set)(enter);
    rtk_u32 n = 0u;
    for (rtk_u32 i = 0u; i < size; i++)
        n += rti_u16_count(a->now + n, 16u * list[i], list[size + i] & VM(bits)(V(le)(from, V(load)(s->wide[list[i]][7]))));
    return n;
}

/* Which of a dense list's rays enter which slots of a node, of those `there`: a->slots. least: where the first of them enters
 * each. */
RTI_VEC void stream_open_dense(streams *a, const stream *s, rtk_u32 mode, rtk_u32 octant, const rtk_bvhnode *n, rtk_u32 there,
                               const uint16_t *list, rtk_u32 size, float least[RTK_BVH_WIDTH])
{
    const stream_planes planes = stream_planes_of(n, mode, octant);
    vec low[RTK_BVH_WIDTH];
    stream_lows_begin(mode, low);
    for (rtk_u32 k = 0u; k < size; k++) {
        const float(*f)[16] = (const float(*)[16])s->wide[list[k]];
        const rtk_u32 of = list[size + k];
        const vec r[8] = {V(load)(f[0]), V(load)(f[1]), V(load)(f[2]), V(load)(f[3]),
                          V(load)(f[4]), V(load)(f[5]), V(load)(f[6]), V(load)(f[7])};
        stream_open_sixteen(mode, &planes, there, r, of, &a->slots[0][k], low);
    }
    stream_lows_end(mode, low, least);
}

/* The list of a slot that a dense list's node has given a->slots, as a dense or a plain one, to s->list from `used` on. Returns
 * where it ends. */
RTI_VEC rtk_u32 stream_deal_dense(const streams *a, stream *s, const uint16_t *list, rtk_u32 size, rtk_u32 slot, rtk_u32 rays,
                                  rtk_u32 used)
{
    uint16_t which[STREAM / 16u + 32u], masks[STREAM / 16u + 32u], *to = s->list + used;
    rtk_u32 blocks = 0u;
    for (rtk_u32 at = 0u; at < size; at += 32u)
        blocks += rti_u16_some(which + blocks, masks + blocks, list + at, a->slots[slot] + at, size - at);
    if (rays >= rtk_umax(STREAM_DENSE_RAYS * blocks, STREAM_DENSE_LEAST)) {
        memcpy(to, which, blocks * sizeof *to);
        memcpy(to + blocks, masks, blocks * sizeof *to);
        s->lists[s->top++] = STREAM_DENSE | used | blocks << 16;
        return used + 2u * blocks;
    }
    for (rtk_u32 b = 0u; b < blocks; b++)
        to += rti_u16_count(to, 16u * which[b], masks[b]);
    s->lists[s->top++] = used | rays << 16;
    return used + rays;
}

/* A step of a dense list through a node. Returns as stream_step. */
RTI_VEC rtk_u32 stream_step_dense(streams *a, stream *s, rtk_u32 mode, rtk_u32 octant, const rtk_bvhnode *n, rtk_u32 begin,
                                  rtk_u32 size)
{
    rtk_u32 rays[RTK_BVH_WIDTH], slots[RTK_BVH_WIDTH], used = begin + 2u * size, most = used;
    float least[RTK_BVH_WIDTH];
    const uint16_t *list = s->list + begin; /* it is read yet */
    const rtk_u32 there = stream_open_there(s, mode, n);
    stream_open_dense(a, s, mode, octant, n, there, list, size, least);
    const rtk_u32 all = stream_entered(a, n, there, size, rays), count = (rtk_u32)__builtin_popcount(all);
    if (all == 0u)
        return 0u;
    for (rtk_u32 i = 0u; i < RTK_BVH_WIDTH; i++)
        most += rtk_umax(rays[i], 2u * size);
    if (most > a->most) {
        rtk_u32 left = 0u;
        for (rtk_u32 i = 0u; i < size; i++)
            left += rti_u16_count(a->now + left, 16u * list[i], list[size + i]);
        return left;
    }
    stream_slots(s, mode, n, all, least, slots);
    for (rtk_u32 i = 0u; STREAM_TELLS(mode) && i < RTK_BVH_WIDTH; i++)
        a->entered += rays[i];
    for (rtk_u32 k = 0u; k < count; k++)
        used = stream_deal_dense(a, s, list, size, slots[k], rays[slots[k]], used);
    return 0u;
}
#endif

#endif
