/* Splits of the BVH's builder by bins: where bins stand, and what is compiled for each instruction set (bvh_bins.c). */
#include "bvh_build.h"

RTI_ISA_TABLES(rti_bvh_kernels, rti_bvh_kernels_at)

void rti_bvh_split_begin(const rti_bvh_range *range, rti_bvh_split *s)
{
    float lo[4], hi[4], scale[4] = {0};
    s->bins = range->count < 32 ? 8 : RTI_BVH_BINS;
    rti_f4_store(lo, range->mid.lo);
    rti_f4_store(hi, range->mid.hi);
    for (int a = 0; a < 3; a++) {
        float by = 0.9999f * (float)s->bins / (hi[a] - lo[a]);
        scale[a] = hi[a] > lo[a] && by <= 1.0e36f ? by : 0.0f;
    }
    s->base = rti_f4_xyz(range->mid.lo);
    s->scale = rti_f4_load(scale);
    s->cost = RTK_INF;
    s->axis = 3;
    s->spatial = s->wants_space = false;
    s->left = s->right = rti_bvh_nothing();
}

void rti_bvh_split_refs(const rti_bvh *t, const rti_ref *refs, uint32_t count, rti_bvh_split *split)
{
    rti_bvh_range range = {.mid = rti_bvh_nothing(), .count = count};
    rti_bvh_bins bins;
    for (uint32_t i = 0; i < count; i++) {
        const rti_f4 mid = rti_bvh_mid(rti_bvh_ref_box(&refs[i]));
        rti_bvh_extend(&range.mid, (rti_bvh_box){mid, mid});
    }
    rti_bvh_split_begin(&range, split);
    t->kernels->bin(split, refs, count, &bins);
    t->kernels->find(t, &bins, split);
}

uint32_t rti_bvh_split_left(const rti_bvh_split *split, const rti_bvh_bins *bins)
{
    uint32_t n = 0;
    for (uint32_t k = 0; k < split->bin; k++)
        n += bins->count[split->axis][k];
    return n;
}
