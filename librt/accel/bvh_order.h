/* The order of a BVH node's slots (bvh_order.c). */
#ifndef RTI_BVH_ORDER_H
#define RTI_BVH_ORDER_H

#include "../kernel/bvh.h"

/* What brings a box' longest side to 1. */
static inline float rti_bvh_unit(const float lo[3], const float hi[3])
{
    float longest = 0.0f;
    for (int a = 0; a < 3; a++)
        longest = rtk_max(longest, hi[a] - lo[a]);
    return longest > 1.0e-37f && longest <= 3.0e38f ? 1.0f / longest : 1.0f;
}

/* What is below a node: the surface of its triangles, and what it costs to look through them, in areas. */
typedef struct rti_bvh_below {
    float surface, cost;
} rti_bvh_below;

/* Nodes whose slots are put in order. unit: rti_bvh_unit of the tree's box; below: of each node; leaves (may be NULL): of each node
 * what rti_bvh_order_leaves says, as who has many workers asks them before. */
typedef struct rti_bvh_order {
    rtk_bvhnode *nodes;
    const rtk_bvhblock *blocks;
    uint32_t block_count;
    float unit;
    rti_bvh_below *below;
    float (*leaves)[RTK_BVH_WIDTH];
} rti_bvh_order;

/* The surface of the triangles in each slot of a node that is a leaf. */
void rti_bvh_order_leaves(const rti_bvh_order *o, uint32_t at, float surfaces[RTK_BVH_WIDTH]);
/* Puts a node's slots in order and tells what is below it. What is below its inner slots is told already. */
void rti_bvh_order_node(const rti_bvh_order *o, uint32_t at);

#endif
