/* What the kd-tree's builder asks of each instruction set. Private to accel/. */
#ifndef RTI_KD_BUILD_H
#define RTI_KD_BUILD_H

#include "bvh_build.h"

#define RTI_KD_BINS 64u

/* Bounds a bin, by axis; the fourth lane is nobody's. */
typedef struct rti_kd_bins {
    uint32_t lo[RTI_KD_BINS][4], hi[RTI_KD_BINS][4];
    rti_f4 base, scale; /* bin = (x - base) * scale, cut to `last`; scale[3] is 0 */
    float last;         /* the highest bin's index */
    uint32_t count;
} rti_kd_bins;

/* kd_bins.c */
typedef struct rti_kd_bin_kernels {
    /* Counts the bounds of `count` references, every stride-th, which lie in the cell; adds to what is there. */
    void (*add)(rti_kd_bins *bins, const rti_ref *refs, size_t count, size_t stride);
} rti_kd_bin_kernels;
const rti_kd_bin_kernels *rti_kd_bin_kernels_at(rti_isa isa);

#define RTI_KD_SHARE 8192u /* references a task, where workers split a node together */

/* Puts n floats, none of which is NaN, in order. temp: n more. */
void rti_kd_sort(float *v, uint32_t n, float *temp);

#define RTI_KD_SWEPT 64u /* references of a leaf that are parted at any place; more are parted by a BVH's bins */

/* kd_piece.c */
typedef struct rti_kd_piece_kernels {
    /* The references of triangles in a leaf's box. */
    void (*refs)(const rti_build_input *in, const float lo[3], const float hi[3], const uint32_t *prims, uint32_t count,
                 rti_ref *refs);
    /* Puts 3 to RTI_KD_SWEPT references in the order in which the first of them, as many as is returned, are the cheapest left
     * part. area: of the box around them. 0: they are no more than a block, and cheaper together. */
    uint32_t (*part)(const rti_bvh *t, const rti_ref *refs, uint32_t count, float area, rti_ref *sorted);
    rti_bvh_box (*around)(const rti_ref *refs, uint32_t count);
} rti_kd_piece_kernels;
const rti_kd_piece_kernels *rti_kd_piece_kernels_at(rti_isa isa);

#endif
