/* What an octree walk needs beside its loop. */
#ifndef RTK_OCTREE_H
#define RTK_OCTREE_H

#include "snapshot.h"

#define RTK_OCT_DEPTH 32u                       /* trees are no deeper (checked where they come in) */
#define RTK_OCT_STACK (3u * RTK_OCT_DEPTH + 4u) /* a level leaves at most three pieces waiting */

/* A cell that is to be walked, up to t1 of the ray. */
typedef struct rtk_octcell {
    rtk_vec3 lo, hi;
    float t1;
    rtk_u32 node;
} rtk_octcell;

RTK_FN void rtk_oct_piece(const rtk_octcell *c, rtk_vec3 mid, rtk_u32 child, rtk_u32 octant, float t1, rtk_octcell *out)
{
    out->lo.x = octant & 1u ? mid.x : c->lo.x;
    out->hi.x = octant & 1u ? c->hi.x : mid.x;
    out->lo.y = octant & 2u ? mid.y : c->lo.y;
    out->hi.y = octant & 2u ? c->hi.y : mid.y;
    out->lo.z = octant & 4u ? mid.z : c->lo.z;
    out->hi.z = octant & 4u ? c->hi.z : mid.z;
    out->node = child + octant;
    out->t1 = t1;
}

/* The children that the ray's interval [t0, c->t1] goes through, in order. back: bit a is set when the ray runs down axis a. */
RTK_FN rtk_u32 rtk_oct_pieces(const rtk_octcell *c, rtk_u32 child, const rtk_pray *r, float t0, rtk_u32 back,
                              rtk_octcell piece[4])
{
    rtk_vec3 mid = rtk_v3(0.5f * (c->lo.x + c->hi.x), 0.5f * (c->lo.y + c->hi.y), 0.5f * (c->lo.z + c->hi.z));
    float tx = (mid.x - r->org.x) * r->inv.x, ty = (mid.y - r->org.y) * r->inv.y, tz = (mid.z - r->org.z) * r->inv.z;
    rtk_u32 octant = back, count = 0u;
    /* Planes already behind are crossed; of the others those before t1 will be, and the rest never. */
    rtk_u32 ahead = (tx < c->t1 ? 1u : 0u) | (ty < c->t1 ? 2u : 0u) | (tz < c->t1 ? 4u : 0u);
    rtk_u32 behind = ((tx <= t0 ? 1u : 0u) | (ty <= t0 ? 2u : 0u) | (tz <= t0 ? 4u : 0u)) & ahead;
    octant ^= behind;
    ahead ^= behind;
    while (ahead != 0u) {
        rtk_u32 axis = ahead & 1u ? 0u : (ahead & 2u ? 1u : 2u);
        float t = axis == 0u ? tx : (axis == 1u ? ty : tz);
        if ((ahead & 2u) && ty < t) {
            axis = 1u;
            t = ty;
        }
        if ((ahead & 4u) && tz < t) {
            axis = 2u;
            t = tz;
        }
        if (count == 0u || piece[count - 1u].t1 < t)
            rtk_oct_piece(c, mid, child, octant, t, &piece[count++]);
        octant ^= 1u << axis;
        ahead ^= 1u << axis;
    }
    rtk_oct_piece(c, mid, child, octant, c->t1, &piece[count++]);
    return count;
}

#endif
