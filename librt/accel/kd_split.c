/* The choice of a kd split by the surface area heuristic.
 *
 * The cost of a plane is linear between two bounds of references, so the cheapest one stands at a bound. Both builders count
 * bounds into bins first. The counts give, for each bin, a lower bound of the cost of every plane in it, and at the bins' edges
 * an upper bound of the best. The exact builder sorts and sweeps the bounds of every bin that may still hold the best: it finds
 * the same plane as a sweep over all sorted bounds (Wald & Havran 2006), in O(N) a node without keeping events sorted. The binned
 * builder looks into the most promising bin and those beside the cheapest edge only.
 */
#include <string.h>

#include "build.h"

#define MAX_BINS   64u
#define DIRECT_MAX 16u /* up to this many references every bound is tried with a count of its own */

/* The numbers that turn counts at a plane into a cost. cap: area of the split's face, rim: perimeter of it, both over the cell's
 * area. */
typedef struct measure {
    float lo, hi, inner_lo, inner_hi; /* of the axis; planes lie strictly between the inner ones */
    float cap, rim;
    float traverse, intersect, keep;
} measure;

static void measure_cell(const rti_build *b, const rti_cell *cell, measure m[3])
{
    float d[3], top = 0.0f, area, unit;
    for (int a = 0; a < 3; a++) {
        d[a] = cell->hi[a] - cell->lo[a];
        top = d[a] > top ? d[a] : top;
    }
    /* Relative to the longest side: areas of scenes of any size neither overflow nor vanish. */
    unit = 1.0f / rtk_max(top, 1.0e-37f);
    for (int a = 0; a < 3; a++)
        d[a] *= unit;
    area = 1.0f / rtk_max(d[0] * d[1] + d[1] * d[2] + d[2] * d[0], 1.0e-37f);
    for (int a = 0; a < 3; a++) {
        float p = d[(a + 1) % 3], q = d[(a + 2) % 3];
        m[a].lo = cell->lo[a];
        m[a].hi = cell->hi[a];
        m[a].inner_lo = cell->lo[a] + b->min_size;
        m[a].inner_hi = cell->hi[a] - b->min_size;
        m[a].cap = p * q * area;
        m[a].rim = (p + q) * area * unit;
        m[a].traverse = b->cost_traverse;
        m[a].intersect = b->cost_intersect;
        m[a].keep = 1.0f - b->empty_bonus;
    }
}

static float plane_cost(const measure *m, float left, float right, float left_width, float right_width)
{
    float c = left * (m->cap + m->rim * left_width) + right * (m->cap + m->rim * right_width);
    if (left == 0.0f || right == 0.0f)
        c *= m->keep;
    return m->traverse + m->intersect * c;
}

static void merge(float *restrict out, const float *a, uint32_t na, const float *b, uint32_t nb)
{
    uint32_t i = 0, j = 0, k = 0;
    while (i < na && j < nb) {
        if (b[j] < a[i])
            out[k++] = b[j++];
        else
            out[k++] = a[i++];
    }
    memcpy(out + k, a + i, (na - i) * sizeof *out);
    k += na - i;
    memcpy(out + k, b + j, (nb - j) * sizeof *out);
}

/* Merge sort over runs sorted by insertion: O(n log n) whatever the input. temp: n floats. */
static void sort_floats(float *v, uint32_t n, float *temp)
{
    enum { RUN = 24 };
    for (uint32_t base = 0; base < n; base += RUN) {
        uint32_t end = base + RUN < n ? base + RUN : n;
        for (uint32_t i = base + 1; i < end; i++) {
            float x = v[i];
            uint32_t j = i;
            for (; j > base && v[j - 1] > x; j--)
                v[j] = v[j - 1];
            v[j] = x;
        }
    }
    float *from = v, *to = temp;
    for (uint32_t width = RUN; width < n; width *= 2) {
        for (uint32_t base = 0; base < n; base += 2 * width) {
            uint32_t na = width < n - base ? width : n - base;
            uint32_t nb = width < n - base - na ? width : n - base - na;
            merge(to + base, from + base, na, from + base + na, nb);
        }
        float *swap = from;
        from = to;
        to = swap;
    }
    if (from != v)
        memcpy(v, from, n * sizeof *v);
}

static void consider(const measure *m, uint32_t axis, float pos, uint32_t left, uint32_t right, rti_kd_split *best)
{
    float c = plane_cost(m, (float)left, (float)right, pos - m->lo, m->hi - pos);
    if (c < best->cost) {
        best->cost = c;
        best->pos = pos;
        best->axis = axis;
        best->left_count = left;
        best->right_count = right;
    }
}

/* Sweeps sorted bounds; left0, gone0: low and high bounds in front of them. count: references of the node. */
static void sweep(const measure *m, uint32_t axis, const float *los, uint32_t lo_count, const float *his, uint32_t hi_count,
                  uint32_t left0, uint32_t gone0, uint32_t count, rti_kd_split *best)
{
    uint32_t i = 0, j = 0;
    while (i < lo_count || j < hi_count) {
        float pos = i < lo_count && (j == hi_count || los[i] < his[j]) ? los[i] : his[j];
        while (j < hi_count && his[j] <= pos)
            j++;
        if (pos > m->inner_lo && pos < m->inner_hi)
            consider(m, axis, pos, left0 + i, count - gone0 - j, best);
        while (i < lo_count && los[i] <= pos)
            i++;
    }
}

/* Few references: counting for each bound anew, in vectors, beats sorting. */
static void split_direct(const measure m[3], const rti_ref *refs, uint32_t count, rti_kd_split *best)
{
    for (uint32_t axis = 0; axis < 3; axis++) {
        float los[DIRECT_MAX], his[DIRECT_MAX], tries[2 * DIRECT_MAX];
        uint32_t try_count = 0, padded = (count + 3) & ~3u;
        for (uint32_t i = 0; i < count; i++) {
            los[i] = refs[i].lo[axis];
            his[i] = refs[i].hi[axis];
            tries[try_count] = los[i];
            try_count += los[i] > m[axis].inner_lo && los[i] < m[axis].inner_hi;
            tries[try_count] = his[i];
            try_count += his[i] > m[axis].inner_lo && his[i] < m[axis].inner_hi;
        }
        for (uint32_t i = count; i < padded; i++) {
            los[i] = m[axis].hi;
            his[i] = m[axis].lo;
        }
        for (uint32_t k = 0; k < try_count; k++) {
            uint32_t left = 0, right = 0;
            float pos = tries[k];
            for (uint32_t i = 0; i < padded; i++) {
                left += los[i] < pos;
                right += his[i] > pos;
            }
            consider(&m[axis], axis, pos, left, right, best);
        }
    }
}

typedef struct bins {
    uint32_t lo[3][MAX_BINS], hi[3][MAX_BINS]; /* low and high bounds a bin */
    float scale[3], last;                      /* last: the highest bin's index */
    uint32_t count;
} bins;

/* Monotone in x, which is all that the counts need to be exact. x lies in the cell, so the product is not negative. */
static inline uint32_t bin_of(float x, float lo, float scale, float last)
{
    float f = (x - lo) * scale;
    return (uint32_t)(int32_t)(f < last ? f : last);
}

/* false: cancelled, the counts are not complete. */
static bool fill_bins(const rti_build *b, const measure m[3], const rti_ref *refs, uint32_t count, bins *n)
{
    n->count = count < 64 ? 16 : (count < 1024 ? 32 : MAX_BINS);
    n->last = (float)(n->count - 1);
    for (int a = 0; a < 3; a++) {
        memset(n->lo[a], 0, n->count * sizeof(uint32_t));
        memset(n->hi[a], 0, n->count * sizeof(uint32_t));
        n->scale[a] = rtk_min((float)n->count / (m[a].hi - m[a].lo), 3.0e38f);
    }
    for (uint32_t i = 0; i < count; i++) {
        for (int a = 0; a < 3; a++) {
            n->lo[a][bin_of(refs[i].lo[a], m[a].lo, n->scale[a], n->last)]++;
            n->hi[a][bin_of(refs[i].hi[a], m[a].lo, n->scale[a], n->last)]++;
        }
        if (i % 65536 == 65535 && rti_cancelled(b->cancel))
            return false;
    }
    return true;
}

/* What the counts alone say: a lower bound of every bin's cost, the cheapest edge between bins and the bin before it. */
typedef struct bounds {
    float cost[3][MAX_BINS];
    float edge;
    uint32_t edge_axis, edge_bin;
} bounds;

static void bound_bins(const measure m[3], const bins *n, uint32_t count, bounds *out)
{
    out->edge = 3.0e38f;
    out->edge_axis = out->edge_bin = 0;
    for (uint32_t a = 0; a < 3; a++) {
        float width = (m[a].hi - m[a].lo) / (float)n->count;
        uint32_t left = 0, right = count;
        bool usable = m[a].inner_lo < m[a].inner_hi;
        for (uint32_t j = 0; j < n->count; j++) {
            uint32_t right_after = right - n->hi[a][j];
            float w0 = (float)j * width, w1 = (float)(n->count - 1 - j) * width;
            out->cost[a][j] = 3.0e38f;
            if (usable && n->lo[a][j] + n->hi[a][j] != 0)
                out->cost[a][j] = 0.9999f * plane_cost(&m[a], (float)left, (float)right_after, w0, w1);
            left += n->lo[a][j];
            right = right_after;
            if (usable && j + 1 < n->count) {
                float c = plane_cost(&m[a], (float)left, (float)right, w0 + width, w1);
                if (c < out->edge) {
                    out->edge = c;
                    out->edge_axis = a;
                    out->edge_bin = j;
                }
            }
        }
    }
}

/* Sorts and sweeps the bounds in the bins of one axis that `wanted` marks. */
static void refine_axis(const measure *m, uint32_t axis, const rti_ref *refs, uint32_t count, const bins *n,
                        const bool wanted[MAX_BINS], float *scratch, rti_kd_split *best)
{
    float *los = scratch, *his = scratch + count, *temp = his + count;
    uint32_t lo_count = 0, hi_count = 0, lo_done = 0, hi_done = 0, left = 0, gone = 0;
    for (uint32_t i = 0; i < count; i++) {
        los[lo_count] = refs[i].lo[axis];
        lo_count += wanted[bin_of(refs[i].lo[axis], m->lo, n->scale[axis], n->last)];
        his[hi_count] = refs[i].hi[axis];
        hi_count += wanted[bin_of(refs[i].hi[axis], m->lo, n->scale[axis], n->last)];
    }
    sort_floats(los, lo_count, temp);
    sort_floats(his, hi_count, temp);
    for (uint32_t j = 0; j < n->count; j++) {
        if (wanted[j]) {
            sweep(m, axis, los + lo_done, n->lo[axis][j], his + hi_done, n->hi[axis][j], left, gone, count, best);
            lo_done += n->lo[axis][j];
            hi_done += n->hi[axis][j];
        }
        left += n->lo[axis][j];
        gone += n->hi[axis][j];
    }
}

/* Bins to look into: all that may hold the best plane, or (binned) the one with the least bound and those beside the cheapest
 * edge. */
static void choose_bins(const rti_build *b, const bins *n, const bounds *s, float leaf_cost, bool wanted[3][MAX_BINS])
{
    bool exact = b->builder == RTI_BUILD_KD_EXACT;
    float limit = s->edge * 1.0001f < leaf_cost ? s->edge * 1.0001f : leaf_cost, least = limit;
    for (uint32_t a = 0; a < 3; a++)
        for (uint32_t j = 0; j < n->count; j++)
            least = s->cost[a][j] < least ? s->cost[a][j] : least;
    for (uint32_t a = 0; a < 3; a++)
        for (uint32_t j = 0; j < n->count; j++) {
            bool near = a == s->edge_axis && (j == s->edge_bin || j == s->edge_bin + 1);
            wanted[a][j] = s->cost[a][j] < limit && (exact || near || s->cost[a][j] <= least);
        }
}

static void split_binned(const rti_build *b, const measure m[3], const rti_ref *refs, uint32_t count, float *scratch,
                         rti_kd_split *best)
{
    bins n;
    bounds s;
    bool wanted[3][MAX_BINS];
    if (!fill_bins(b, m, refs, count, &n))
        return; /* a leaf, in a tree that nobody will see */
    bound_bins(m, &n, count, &s);
    choose_bins(b, &n, &s, best->cost, wanted);
    for (uint32_t a = 0; a < 3; a++) {
        bool any = false;
        for (uint32_t j = 0; j < n.count; j++)
            any |= wanted[a][j];
        if (any)
            refine_axis(&m[a], a, refs, count, &n, wanted[a], scratch, best);
    }
}

rti_kd_split rti_kd_find_split(const rti_build *b, const rti_cell *cell, const rti_ref *refs, uint32_t count, float *scratch)
{
    rti_kd_split best = {b->cost_intersect * (float)count, 0.0f, 3, 0, 0}; /* a leaf's cost: what is dearer is no split */
    measure m[3];
    measure_cell(b, cell, m);
    if (count <= DIRECT_MAX)
        split_direct(m, refs, count, &best);
    else
        split_binned(b, m, refs, count, scratch, &best);
    return best;
}
