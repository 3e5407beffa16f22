/* What is made of the leaves of trees of cells, kd-trees and octrees. Private to accel/. */
#ifndef RTI_CELL_BUILD_H
#define RTI_CELL_BUILD_H

#include "bvh_build.h"

#define RTI_CELL_SWEPT 64u /* references of a leaf that are parted at any place; more are parted by a BVH's bins */

/* cell_piece.c */
typedef struct rti_cell_piece_kernels {
    /* The references of triangles in a leaf's box. */
    void (*refs)(const rti_build_input *in, const float lo[3], const float hi[3], const uint32_t *prims, uint32_t count,
                 rti_ref *refs);
    /* Puts 3 to RTI_CELL_SWEPT references in the order in which the first of them, as many as is returned, are the cheapest left
     * part. area: of the box around them. 0: they are no more than a block, and cheaper together. */
    uint32_t (*part)(const rti_bvh *t, const rti_ref *refs, uint32_t count, float area, rti_ref *sorted);
    rti_bvh_box (*around)(const rti_ref *refs, uint32_t count);
} rti_cell_piece_kernels;
const rti_cell_piece_kernels *rti_cell_piece_kernels_at(rti_isa isa);

#endif
