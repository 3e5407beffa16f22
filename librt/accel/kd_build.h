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

#endif
