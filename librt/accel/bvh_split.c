/* Where a range of the BVH's builder is split: surface area heuristic over bins (Wald 2007), on three axes at once. What differs:
 * costs count blocks of triangles, so leaves come out full. */
#include "bvh_build.h"

#define APART 256u /* references that are binned by turns into two sets of bins */

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

static void bins_clear(const rti_bvh_split *s, rti_bvh_bins *bins)
{
    memset(bins->count, 0, sizeof bins->count);
    for (uint32_t a = 0; a < 3; a++)
        for (uint32_t k = 0; k < s->bins; k += 8) /* their number is a multiple of it */
            for (uint32_t i = 0; i < 8; i++)
                bins->box[a][k + i] = rti_bvh_nothing();
}

static inline void bins_put(const rti_bvh_split *s, const rti_ref *ref, float last, rti_bvh_bins *bins)
{
    rti_bvh_box box = rti_bvh_ref_box(ref);
    int32_t k[4];
    rti_bvh_bins_of((rti_bvh_mid(box) - s->base) * s->scale, last, k);
    for (uint32_t a = 0; a < 3; a++) {
        rti_bvh_extend(&bins->box[a][k[a]], box);
        bins->count[a][k[a]]++;
    }
}

void rti_bvh_bin(const rti_bvh_split *s, const rti_ref *refs, uint32_t count, rti_bvh_bins *bins)
{
    const float last = (float)(s->bins - 1);
    rti_bvh_bins odd;
    uint32_t i = 0;
    bins_clear(s, bins);
    if (count >= APART) { /* neighbours fall into one bin, and would wait for each other */
        bins_clear(s, &odd);
        for (; i + 2 <= count; i += 2) {
            bins_put(s, &refs[i], last, bins);
            bins_put(s, &refs[i + 1], last, &odd);
        }
        rti_bvh_bins_add(s, bins, &odd);
    }
    for (; i < count; i++)
        bins_put(s, &refs[i], last, bins);
}

void rti_bvh_bins_add(const rti_bvh_split *s, rti_bvh_bins *to, const rti_bvh_bins *from)
{
    for (uint32_t a = 0; a < 3; a++)
        for (uint32_t k = 0; k < s->bins; k++) {
            rti_bvh_extend(&to->box[a][k], from->box[a][k]);
            to->count[a][k] += from->count[a][k];
        }
}

/* rti_bvh_area times rti_bvh_leaf_cost, of four. */
static inline rti_f4 costs_of(const rti_bvh *t, const rti_bvh_box box[4], const uint32_t count[4])
{
    const int32_t together = 1 << t->together;
    rti_f4 p[4], by[4];
    rti_i4 blocks;
    for (uint32_t i = 0; i < 4; i++) {
        const rti_f4 side = rti_bvh_sides(t, box[i]);
        p[i] = side * (rti_f4){side[1], side[2], side[0], side[3]};
    }
    rti_f4_turn(p, by);
    memcpy(&blocks, count, sizeof blocks);
    blocks = (blocks + rti_i4_set(together - 1)) >> (int)t->together;
    return ((by[0] + by[1]) + by[2]) * (rti_f4_set(t->leaf_cost) * rti_i4_floats(blocks));
}

/* The bins below a plane, and the others. */
typedef struct sides {
    rti_bvh_box left[RTI_BVH_BINS], right[RTI_BVH_BINS]; /* plane k is below bin k */
    uint32_t left_count[RTI_BVH_BINS], right_count[RTI_BVH_BINS];
} sides;

static void find_on_axis(const rti_bvh *t, const rti_bvh_bins *bins, uint32_t a, rti_bvh_split *s)
{
    sides all;
    rti_bvh_box box = rti_bvh_nothing();
    uint32_t count = 0;
    for (uint32_t k = 0; k < s->bins; k++) {
        all.left[k] = box;
        all.left_count[k] = count;
        rti_bvh_extend(&box, bins->box[a][k]);
        count += bins->count[a][k];
    }
    box = rti_bvh_nothing();
    count = 0;
    for (uint32_t k = s->bins; k-- > 0;) {
        rti_bvh_extend(&box, bins->box[a][k]);
        count += bins->count[a][k];
        all.right[k] = box;
        all.right_count[k] = count;
    }
    for (uint32_t k = 0; k < s->bins; k += 4) {
        const rti_f4 cost = costs_of(t, &all.left[k], &all.left_count[k]) + costs_of(t, &all.right[k], &all.right_count[k]);
        for (uint32_t less = rti_m4_bits(rti_f4_lt(cost, rti_f4_set(s->cost))); less != 0; less &= less - 1) {
            const uint32_t i = (uint32_t)__builtin_ctz(less), plane = k + i;
            if (!(cost[i] < s->cost) || all.left_count[plane] == 0 || all.right_count[plane] == 0)
                continue;
            s->cost = cost[i];
            s->axis = a;
            s->bin = plane;
            s->left = all.left[plane];
            s->right = all.right[plane];
            s->left_count = all.left_count[plane];
            s->right_count = all.right_count[plane];
        }
    }
}

void rti_bvh_split_find(const rti_bvh *t, const rti_bvh_bins *bins, rti_bvh_split *s)
{
    float scale[4];
    rti_f4_store(scale, s->scale);
    for (uint32_t a = 0; a < 3; a++)
        if (scale[a] > 0.0f)
            find_on_axis(t, bins, a, s);
}

uint32_t rti_bvh_split_left(const rti_bvh_split *s, const rti_bvh_bins *bins)
{
    uint32_t n = 0;
    for (uint32_t k = 0; k < s->bin; k++)
        n += bins->count[s->axis][k];
    return n;
}

void rti_bvh_scatter(const rti_bvh_split *s, const rti_ref *refs, uint32_t count, rti_ref *left, rti_ref *right,
                     rti_bvh_box mids[2])
{
    rti_bvh_box l = mids[0], r = mids[1];
    float base[4], scale[4], at_base, at_scale;
    const float edge = (float)s->bin; /* what is cut to 0 ... bins - 1 and rounded down is below it where the uncut is */
    rti_f4_store(base, s->base);
    rti_f4_store(scale, s->scale);
    at_base = base[s->axis];
    at_scale = scale[s->axis];
    for (uint32_t i = 0; i < count; i++) {
        const rti_bvh_box box = rti_bvh_ref_box(&refs[i]);
        const rti_i4 mid = (rti_i4)rti_bvh_mid(box);
        const float at = (refs[i].lo[s->axis] + refs[i].hi[s->axis] - at_base) * at_scale;
        const ptrdiff_t goes_left = !(at >= edge); /* so a NaN, as 0 */
        const rti_i4 lefts = rti_i4_set(-(int32_t)goes_left);
        rti_ref *to = right - 1;
        to += (left - to) & -goes_left; /* a branch could not be foreseen */
        *to = refs[i];
        left += goes_left;
        right -= 1 - goes_left;
        /* What is no number changes nothing. */
        l.lo = rti_f4_min((rti_f4)(mid | ~lefts), l.lo);
        l.hi = rti_f4_max((rti_f4)(mid | ~lefts), l.hi);
        r.lo = rti_f4_min((rti_f4)(mid | lefts), r.lo);
        r.hi = rti_f4_max((rti_f4)(mid | lefts), r.hi);
    }
    mids[0] = l;
    mids[1] = r;
}
