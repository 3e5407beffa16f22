/* Where a range of the BVH's builder is split: surface area heuristic over bins (Wald 2007), on three axes at once. What differs:
 * costs count blocks of triangles, so leaves come out full. */
#include "bvh_build.h"

float rti_bvh_leaf_cost(const rti_bvh *t, uint32_t count)
{
    const uint32_t blocks = (count + t->together - 1) / t->together;
    return t->b->cost_intersect * (float)blocks;
}

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

void rti_bvh_bin(const rti_bvh_split *s, const rti_ref *refs, uint32_t count, rti_bvh_bins *bins)
{
    float last = (float)(s->bins - 1);
    for (uint32_t a = 0; a < 3; a++)
        for (uint32_t k = 0; k < s->bins; k++) {
            bins->box[a][k] = rti_bvh_nothing();
            bins->count[a][k] = 0;
        }
    for (uint32_t i = 0; i < count; i++) {
        rti_bvh_box box = rti_bvh_ref_box(&refs[i]);
        int32_t k[4];
        rti_bvh_bins_of((rti_bvh_mid(box) - s->base) * s->scale, last, k);
        for (uint32_t a = 0; a < 3; a++) {
            rti_bvh_extend(&bins->box[a][k[a]], box);
            bins->count[a][k[a]]++;
        }
    }
}

void rti_bvh_bins_add(const rti_bvh_split *s, rti_bvh_bins *to, const rti_bvh_bins *from)
{
    for (uint32_t a = 0; a < 3; a++)
        for (uint32_t k = 0; k < s->bins; k++) {
            rti_bvh_extend(&to->box[a][k], from->box[a][k]);
            to->count[a][k] += from->count[a][k];
        }
}

void rti_bvh_split_find(const rti_bvh *t, const rti_bvh_bins *bins, rti_bvh_split *s)
{
    float scale[4];
    rti_f4_store(scale, s->scale);
    for (uint32_t a = 0; a < 3; a++) {
        rti_bvh_box right[RTI_BVH_BINS + 1], left = rti_bvh_nothing();
        uint32_t right_count[RTI_BVH_BINS + 1], left_count = 0;
        float right_cost[RTI_BVH_BINS + 1];
        if (!(scale[a] > 0.0f))
            continue;
        right[s->bins] = rti_bvh_nothing();
        right_count[s->bins] = 0;
        for (uint32_t k = s->bins; k-- > 1;) {
            right[k] = right[k + 1];
            rti_bvh_extend(&right[k], bins->box[a][k]);
            right_count[k] = right_count[k + 1] + bins->count[a][k];
            right_cost[k] = rti_bvh_area(t, right[k]) * rti_bvh_leaf_cost(t, right_count[k]);
        }
        for (uint32_t k = 1; k < s->bins; k++) {
            float cost;
            rti_bvh_extend(&left, bins->box[a][k - 1]);
            left_count += bins->count[a][k - 1];
            if (left_count == 0 || right_count[k] == 0)
                continue;
            cost = rti_bvh_area(t, left) * rti_bvh_leaf_cost(t, left_count) + right_cost[k];
            if (cost < s->cost) {
                s->cost = cost;
                s->axis = a;
                s->bin = k;
                s->left = left;
                s->right = right[k];
                s->left_count = left_count;
                s->right_count = right_count[k];
            }
        }
    }
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
    rti_bvh_box none = rti_bvh_nothing(), l = mids[0], r = mids[1];
    float base[4], scale[4], at_base, at_scale, last = (float)(s->bins - 1);
    rti_f4_store(base, s->base);
    rti_f4_store(scale, s->scale);
    at_base = base[s->axis];
    at_scale = scale[s->axis];
    for (uint32_t i = 0; i < count; i++) {
        rti_f4 mid = rti_bvh_mid(rti_bvh_ref_box(&refs[i]));
        float at = (refs[i].lo[s->axis] + refs[i].hi[s->axis] - at_base) * at_scale;
        int goes_left = (int32_t)rtk_min(rtk_max(at, 0.0f), last) < (int32_t)s->bin;
        rti_i4 lefts = rti_i4_set(-goes_left);
        rti_ref *to = goes_left ? left : right - 1;
        *to = refs[i];
        left += goes_left;
        right -= !goes_left;
        l.lo = rti_f4_min(l.lo, rti_f4_pick(lefts, mid, none.lo));
        l.hi = rti_f4_max(l.hi, rti_f4_pick(lefts, mid, none.hi));
        r.lo = rti_f4_min(r.lo, rti_f4_pick(lefts, none.lo, mid));
        r.hi = rti_f4_max(r.hi, rti_f4_pick(lefts, none.hi, mid));
    }
    mids[0] = l;
    mids[1] = r;
}
