/* Bins of the BVH's builder and what is found by them: surface area heuristic over bins (Wald 2007), on three axes at once. What
 * differs: costs count blocks of triangles, so leaves come out full. A hot file (base/isa.h): the same splits at each level.
 */
#include "hull.h"

/* ---- into bins ----------------------------------------------------------------------------------------------------------- */

#define SETS  4u  /* of bins, in turn: neighbours fall into one bin, and would wait for each other */
#define BATCH 64u /* references whose bins are found before they are put there */

static void bins_clear(const rti_bvh_split *s, rti_bvh_bins *bins)
{
    for (uint32_t a = 0; a < 3; a++)
        for (uint32_t k = 0; k < s->bins; k += 8) /* their number is a multiple of it */
            for (uint32_t i = 0; i < 8; i++) {
                hull_store(&bins->box[a][k + i], hull_nothing());
                bins->count[a][k + i] = 0;
            }
}

static void bins_add(const rti_bvh_split *s, rti_bvh_bins *to, const rti_bvh_bins *from)
{
    for (uint32_t a = 0; a < 3; a++)
        for (uint32_t k = 0; k < s->bins; k++) {
            hull_store(&to->box[a][k], hull_around(hull_load(&to->box[a][k]), hull_load(&from->box[a][k])));
            to->count[a][k] += from->count[a][k];
        }
}

/* The bins of references on each axis; the fourth is anything. */
static inline void bins_of(const rti_bvh_split *s, const rti_ref *refs, uint32_t count, int32_t k[BATCH][4])
{
    const float last = (float)(s->bins - 1);
    uint32_t i = 0;
#if RTI_SIMD >= 8
    const rti_f8 base = rti_f8_both(s->base, s->base), scale = rti_f8_both(s->scale, s->scale), nought = rti_f8_set(0.0f);
    for (; i + 2 <= count; i += 2) {
        const rti_f8 sum = rti_f8_two(refs[i].lo, refs[i + 1].lo) + rti_f8_two(refs[i].hi, refs[i + 1].hi);
        const rti_f8 at = ((rti_f8)((i8)sum & (i8){-1, -1, -1, 0, -1, -1, -1, 0}) - base) * scale;
        const i8 bin = __builtin_convertvector(rti_f8_min(rti_f8_max(at, nought), rti_f8_set(last)), i8);
        memcpy(k + i, &bin, sizeof bin);
    }
#endif
    for (; i < count; i++)
        rti_bvh_bins_of((rti_bvh_mid(rti_bvh_ref_box(&refs[i])) - s->base) * s->scale, last, k[i]);
}

static inline void bins_put(const rti_ref *ref, const int32_t k[4], rti_bvh_bins *restrict bins)
{
    const hull box = hull_ref(ref);
    for (uint32_t a = 0; a < 3; a++) {
        rti_bvh_box *bin = &bins->box[a][k[a]];
        hull_store(bin, hull_around(hull_load(bin), box));
        bins->count[a][k[a]]++;
    }
}

static void bin(const rti_bvh_split *s, const rti_ref *refs, uint32_t count, rti_bvh_bins *bins)
{
    const uint32_t sets = count < 128 ? 1 : (count < 1024 ? 2 : SETS);
    rti_bvh_bins others[SETS - 1], *set[SETS];
    int32_t k[BATCH][4];
    for (uint32_t i = 0; i < SETS; i++)
        set[i] = i % sets == 0 ? bins : &others[i % sets - 1];
    for (uint32_t i = 0; i < sets; i++)
        bins_clear(s, set[i]);
    for (uint32_t from = 0; from < count; from += BATCH) {
        const uint32_t n = rtk_umin(count - from, BATCH);
        bins_of(s, refs + from, n, k);
        for (uint32_t i = 0; i < n; i++)
            bins_put(&refs[from + i], k[i], set[i % SETS]);
    }
    for (uint32_t i = 1; i < sets; i++)
        bins_add(s, bins, set[i]);
}

/* ---- the cheapest split -------------------------------------------------------------------------------------------------- */

/* The bins below a plane, and the others. */
typedef struct sides {
    _Alignas(32) rti_bvh_box left[RTI_BVH_BINS], right[RTI_BVH_BINS]; /* plane k is below bin k; as bins */
    uint32_t left_count[RTI_BVH_BINS], right_count[RTI_BVH_BINS];
} sides;

/* What leaves of so many cost, an area. */
static inline rti_f4 leaf_costs(const rti_bvh *t, const uint32_t count[4])
{
    rti_i4 blocks;
    memcpy(&blocks, count, sizeof blocks);
    blocks = (blocks + rti_i4_set((1 << t->together) - 1)) >> (int)t->together;
    return rti_f4_set(t->leaf_cost) * rti_i4_floats(blocks);
}

/* rti_bvh_area times rti_bvh_leaf_cost of both sides, of the planes from k on. */
#if RTI_SIMD >= 8
static inline rti_f4 costs_of(const rti_bvh *t, const sides *all, uint32_t k)
{
    const rti_f8 grow = rti_f8_both(t->grow2, t->grow2);
    rti_f8 side[4], by[4];
    for (uint32_t i = 0; i < 4; i++) {
        const rti_f8 l = hull_load(&all->left[k + i]), r = hull_load(&all->right[k + i]);
        side[i] = grow - (rti_f8_highs(l, r) + rti_f8_lows(l, r));
    }
    rti_f8_turn(side, by);
    for (uint32_t a = 0; a < 3; a++)
        by[a] = by[a] * rti_f8_set(t->unit);
    const rti_f8 area = (by[0] * by[1] + by[1] * by[2]) + by[2] * by[0];
    const rti_f8 cost = area * rti_f8_both(leaf_costs(t, &all->left_count[k]), leaf_costs(t, &all->right_count[k]));
    return rti_f8_low(cost) + rti_f8_high(cost);
}
#else
static inline rti_f4 cost_of(const rti_bvh *t, const rti_bvh_box box[4], const uint32_t count[4])
{
    rti_f4 side[4], by[4];
    for (uint32_t i = 0; i < 4; i++)
        side[i] = rti_bvh_sides(t, box[i]);
    rti_f4_turn(side, by);
    return ((by[0] * by[1] + by[1] * by[2]) + by[2] * by[0]) * leaf_costs(t, count);
}

static inline rti_f4 costs_of(const rti_bvh *t, const sides *all, uint32_t k)
{
    return cost_of(t, &all->left[k], &all->left_count[k]) + cost_of(t, &all->right[k], &all->right_count[k]);
}
#endif

static void sides_of(const rti_bvh_bins *bins, uint32_t a, uint32_t n, sides *all)
{
    hull box = hull_nothing();
    uint32_t count = 0;
    for (uint32_t k = 0; k < n; k++) {
        hull_store(&all->left[k], box);
        all->left_count[k] = count;
        box = hull_around(box, hull_load(&bins->box[a][k]));
        count += bins->count[a][k];
    }
    box = hull_nothing();
    count = 0;
    for (uint32_t k = n; k-- > 0;) {
        box = hull_around(box, hull_load(&bins->box[a][k]));
        count += bins->count[a][k];
        hull_store(&all->right[k], box);
        all->right_count[k] = count;
    }
}

/* The least of four lanes, and of equal ones the first place. */
static inline void best_of(rti_f4 costs, rti_i4 places, float *cost, uint32_t *place)
{
    *cost = costs[0];
    *place = (uint32_t)places[0];
    for (uint32_t i = 1; i < 4; i++) {
        const uint32_t at = (uint32_t)places[i];
        const bool better = (costs[i] < *cost) | ((costs[i] == *cost) & (at < *place));
        *place = better ? at : *place;
        *cost = better ? costs[i] : *cost;
    }
}

static void find(const rti_bvh *t, const rti_bvh_bins *bins, rti_bvh_split *s)
{
    const rti_i4 nought = rti_i4_set(0);
    rti_f4 least = rti_f4_set(s->cost);
    rti_i4 where = rti_i4_set(-1); /* plane + RTI_BVH_BINS times axis */
    float scale[4];
    uint32_t place;
    sides all[3];
    rti_f4_store(scale, s->scale);
    for (uint32_t a = 0; a < 3; a++) {
        if (!(scale[a] > 0.0f))
            continue;
        sides_of(bins, a, s->bins, &all[a]);
        for (uint32_t k = 0; k < s->bins; k += 4) {
            rti_i4 left, right, less;
            const rti_f4 cost = costs_of(t, &all[a], k);
            memcpy(&left, &all[a].left_count[k], sizeof left);
            memcpy(&right, &all[a].right_count[k], sizeof right);
            less = (rti_i4)(cost < least) & (left > nought) & (right > nought);
            least = rti_f4_pick(less, cost, least);
            where = rti_i4_pick(less, (rti_i4){0, 1, 2, 3} + rti_i4_set((int32_t)(a * RTI_BVH_BINS + k)), where);
        }
    }
    best_of(least, where, &s->cost, &place);
    if (place == UINT32_MAX)
        return;
    s->axis = place / RTI_BVH_BINS;
    s->bin = place % RTI_BVH_BINS;
    s->left = hull_box(hull_load(&all[s->axis].left[s->bin]));
    s->right = hull_box(hull_load(&all[s->axis].right[s->bin]));
    s->left_count = all[s->axis].left_count[s->bin];
    s->right_count = all[s->axis].right_count[s->bin];
}

/* ---- carried out --------------------------------------------------------------------------------------------------------- */

static void scatter(const rti_bvh_split *s, const rti_ref *refs, uint32_t count, rti_ref *left, rti_ref *right,
                    rti_bvh_box mids[2])
{
    hull l = hull_of(mids[0]), r = hull_of(mids[1]);
    float base[4], scale[4], at_base, at_scale;
    const float edge = (float)s->bin; /* what is cut to 0 ... bins - 1 and rounded down is below it where the uncut is */
    rti_f4_store(base, s->base);
    rti_f4_store(scale, s->scale);
    at_base = base[s->axis];
    at_scale = scale[s->axis];
    for (uint32_t i = 0; i < count; i++) {
        const rti_f4 mid = rti_bvh_mid(rti_bvh_ref_box(&refs[i]));
        const float at = (refs[i].lo[s->axis] + refs[i].hi[s->axis] - at_base) * at_scale;
        const ptrdiff_t goes_left = !(at >= edge); /* so a NaN, as 0 */
        rti_ref *to = right - 1;
        to += (left - to) & -goes_left; /* a branch could not be foreseen */
        *to = refs[i];
        left += goes_left;
        right -= 1 - goes_left;
        l = hull_around(hull_point(mid, -(int32_t)goes_left), l);
        r = hull_around(hull_point(mid, (int32_t)goes_left - 1), r);
    }
    mids[0] = hull_box(l);
    mids[1] = hull_box(r);
}

const rti_bvh_kernels RTI_ISA_FN(rti_bvh_kernels) = {bin, bins_add, find, scatter};
