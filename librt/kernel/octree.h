/* What an octree walk needs beside its loop. */
#ifndef RTK_OCTREE_H
#define RTK_OCTREE_H

#include "snapshot.h"

#define RTK_OCT_DEPTH 32u                       /* trees are no deeper (checked where they come in) */
#define RTK_OCT_STACK (3u * RTK_OCT_DEPTH + 4u) /* a level leaves at most three pieces waiting */

/* A cell that is to be walked from t0 to t1 of the ray. */
typedef struct rtk_octcell {
    rtk_vec3 lo, hi;
    float t0, t1;
    rtk_u32 child, first, count; /* its node */
} rtk_octcell;

RTK_FN rtk_octcell rtk_oct_root(rtk_tree tree, float t0, float t1)
{
    rtk_octcell c;
    c.lo = tree.lo;
    c.hi = tree.hi;
    c.t0 = t0;
    c.t1 = t1;
    c.child = tree.oct[0].child;
    c.first = tree.oct[0].first;
    c.count = tree.oct[0].count;
    return c;
}

/* Adds the part of `c` in an octant unless it is an empty leaf. */
RTK_FN rtk_u32 rtk_oct_piece(rtk_tree tree, const rtk_octcell *c, rtk_vec3 mid, rtk_u32 octant, float t0, float t1,
                             rtk_octcell *out)
{
    rtk_octnode n = tree.oct[c->child + octant];
    if (n.child == 0u && n.count == 0u)
        return 0u;
    out->lo.x = octant & 1u ? mid.x : c->lo.x;
    out->hi.x = octant & 1u ? c->hi.x : mid.x;
    out->lo.y = octant & 2u ? mid.y : c->lo.y;
    out->hi.y = octant & 2u ? c->hi.y : mid.y;
    out->lo.z = octant & 4u ? mid.z : c->lo.z;
    out->hi.z = octant & 4u ? c->hi.z : mid.z;
    out->child = n.child;
    out->first = n.first;
    out->count = n.count;
    out->t0 = t0;
    out->t1 = t1;
    return 1u;
}

/* The children that the ray goes through in the inner cell `c`, in order, without empty leaves. back: bit a is set when the ray
 * runs down axis a. */
RTK_FN rtk_u32 rtk_oct_pieces(rtk_tree tree, const rtk_octcell *c, const rtk_pray *r, rtk_u32 back, rtk_octcell piece[4])
{
    rtk_vec3 mid = rtk_v3(0.5f * (c->lo.x + c->hi.x), 0.5f * (c->lo.y + c->hi.y), 0.5f * (c->lo.z + c->hi.z));
    float tx = (mid.x - r->org.x) * r->inv.x, ty = (mid.y - r->org.y) * r->inv.y, tz = (mid.z - r->org.z) * r->inv.z;
    float t0 = c->t0;
    rtk_u32 octant = back, count = 0u;
    /* Planes already behind are crossed; of the others those before t1 will be, and the rest never. */
    rtk_u32 ahead = (tx < c->t1 ? 1u : 0u) | (ty < c->t1 ? 2u : 0u) | (tz < c->t1 ? 4u : 0u);
    rtk_u32 behind = ((tx <= t0 ? 1u : 0u) | (ty <= t0 ? 2u : 0u) | (tz <= t0 ? 4u : 0u)) & ahead;
    octant ^= behind;
    ahead ^= behind;
    while (ahead != 0u) {
        rtk_u32 bit = ahead & 1u ? 1u : (ahead & 2u ? 2u : 4u);
        float t = bit == 1u ? tx : (bit == 2u ? ty : tz);
        if ((ahead & 2u) && ty < t) {
            bit = 2u;
            t = ty;
        }
        if ((ahead & 4u) && tz < t) {
            bit = 4u;
            t = tz;
        }
        if (t0 < t)
            count += rtk_oct_piece(tree, c, mid, octant, t0, t, &piece[count]);
        t0 = t;
        octant ^= bit;
        ahead ^= bit;
    }
    return count + rtk_oct_piece(tree, c, mid, octant, t0, c->t1, &piece[count]);
}

#endif
