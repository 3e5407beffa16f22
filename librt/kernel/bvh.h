/* What walks of the eight-wide bounding volume hierarchy need beside their loop.
 *
 * A ray enters a slot's box at the farthest of its near planes, leaves it at the nearest of its far planes, both cut to the
 * prepared ray's [t0, t1]; every distance is (plane - org) * inv. Near and far are told by the sign of inv, box[axis][back] and
 * box[axis][1 - back]: then an empty slot's inverted box is never entered (with min and max of the two it would be, everywhere).
 * Enter a box when enter <= exit and not best.t < outer + (tshift + enter), never with a margin of your own (ray.h, theory points
 * 3 and 4).
 *
 * The order of slots is made for any hit (accel/bvh_order.c); a closest hit wants them by the distance of entry.
 * Equal distances may be taken in any order: the order of hits decides, not that of visits.
 */
#ifndef RTK_BVH_H
#define RTK_BVH_H

#include "snapshot.h"

#define RTK_BVH_DEPTH 48u /* trees are no deeper (checked where they come in) */
#define RTK_BVH_STACK                                                                                                            \
    ((RTK_BVH_WIDTH - 1u) * RTK_BVH_DEPTH + 1u + RTK_BVH_WIDTH) /* a level leaves at most seven slots waiting                    \
                                                                 */

/* A group of so many times more triangles than shapes is built and walked as a mesh. */
#define RTK_BVH_MESH 8u

/* The slots of a node that a ray enters, with where; order is that of slots. Returns how many. back: 1 for each axis the ray runs
 * down. */
typedef struct rtk_bvhslot {
    rtk_u32 child, count; /* as in the node */
    float t0, t1;
} rtk_bvhslot;

RTK_FN rtk_u32 rtk_bvh_open(RT_GLOBAL const rtk_bvhnode *n, const rtk_pray *r, const rtk_u32 back[3],
                            rtk_bvhslot out[RTK_BVH_WIDTH])
{
    float t0[RTK_BVH_WIDTH], t1[RTK_BVH_WIDTH];
    rtk_u32 i, count = 0u;
    for (i = 0u; i < RTK_BVH_WIDTH; i++) {
        t0[i] = rtk_max(rtk_max((n->box[0][back[0]][i] - r->org.x) * r->inv.x, (n->box[1][back[1]][i] - r->org.y) * r->inv.y),
                        rtk_max((n->box[2][back[2]][i] - r->org.z) * r->inv.z, r->t0));
        t1[i] = rtk_min(
            rtk_min((n->box[0][1u - back[0]][i] - r->org.x) * r->inv.x, (n->box[1][1u - back[1]][i] - r->org.y) * r->inv.y),
            rtk_min((n->box[2][1u - back[2]][i] - r->org.z) * r->inv.z, r->t1));
    }
    for (i = 0u; i < RTK_BVH_WIDTH; i++) {
        if (t0[i] <= t1[i]) {
            out[count].child = n->child[i];
            out[count].count = n->count[i];
            out[count].t0 = t0[i];
            out[count].t1 = t1[i];
            count++;
        }
    }
    return count;
}

#endif
