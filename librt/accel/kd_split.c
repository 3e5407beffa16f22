/* The choice of a kd split by the surface area heuristic.
 *
 * The cost of a plane is linear between two bounds of references, so the cheapest one stands at a bound. Both builders count
 * bounds into bins first. The counts give, for each bin, a lower bound of the cost of every plane in it, and at the bins' edges
 * an upper bound of the best. The exact builder sorts and sweeps the bounds of every bin that may still hold the best: it finds
 * the same plane as a sweep over all sorted bounds (Wald & Havran 2006), in O(N) a node without keeping events sorted. The binned
 * builder asks a sample of a very large node's references, takes the cheapest edge in large nodes, and looks into the most
 * promising bin and those beside that edge in smaller ones.
 */
#include <string.h>

#include "kd_build.h"

#define SAMPLE     2048u /* references that speak for a large node */
#define EDGE_ABOVE 40u   /* the binned builder takes edges between bins as they are in nodes of more references */
#define DIRECT_MAX 16u   /* up to this many references every bound is tried with a count of its own */

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
        m[a].intersect = b->cost_sought;
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

/* ---- few references: every bound is tried ------------------------------------------------------------------------------- */

RTI_ISA_TABLES(rti_kd_bin_kernels, rti_kd_bin_kernels_at)

enum { LANES = 4 };

/* The cheapest of the planes seen so far, a lane each. at: 64 * axis + index of the plane. */
typedef struct lanes {
    rti_f4 cost;
    rti_i4 at;
} lanes;

/* Counts for each bound of one axis anew, four planes at a time: below DIRECT_MAX that beats sorting. los, his: `count` of
 * them; tries: both, one behind the other. */
static inline void try_axis(const measure *m, int axis, const float *los, const float *his, const float *tries, uint32_t count,
                            lanes *best)
{
    rti_i4 at = (rti_i4){0, 1, 2, 3} + 64 * axis;
    for (uint32_t k = 0; k < 2 * count; k += LANES, at += LANES) {
        rti_f4 pos, l, r, c;
        rti_i4 left = {0}, right = {0}, take;
        memcpy(&pos, tries + k, sizeof pos);
        for (uint32_t i = 0; i < count; i++) {
            left -= los[i] < pos;
            right -= his[i] > pos;
        }
        l = rti_i4_floats(left);
        r = rti_i4_floats(right);
        c = l * (m->cap + m->rim * (pos - m->lo)) + r * (m->cap + m->rim * (m->hi - pos));
        c = m->traverse + m->intersect * rti_f4_pick((left == 0) | (right == 0), c * m->keep, c);
        take = (pos > m->inner_lo) & (pos < m->inner_hi) & (c < best->cost);
        best->cost = rti_f4_pick(take, c, best->cost);
        best->at = rti_i4_pick(take, at, best->at);
    }
}

/* Index of the cheapest lane, of equal ones the least; -1: none is cheaper than what was there. */
static inline int least_of(const lanes *b, float *cost)
{
    float c[LANES], low;
    int at[LANES], first = 1 << 20;
    memcpy(c, &b->cost, sizeof c);
    memcpy(at, &b->at, sizeof at);
    for (int n = LANES / 2; n > 0; n /= 2)
        for (int i = 0; i < n; i++)
            c[i] = c[i] < c[i + n] ? c[i] : c[i + n];
    low = c[0];
    memcpy(c, &b->cost, sizeof c);
    for (int i = 0; i < LANES; i++) {
        int mine = c[i] == low && at[i] >= 0 ? at[i] : 1 << 20;
        first = mine < first ? mine : first;
    }
    *cost = low;
    return first < 1 << 20 ? first : -1;
}

static void split_direct(const measure m[3], const rti_ref *refs, uint32_t count, rti_kd_split *best)
{
    float tries[3][2 * DIRECT_MAX], los[3][DIRECT_MAX], his[3][DIRECT_MAX];
    lanes b = {rti_f4_set(best->cost), rti_i4_set(-1)};
    int at;
    for (uint32_t i = 0; i < count; i++)
        for (int a = 0; a < 3; a++) {
            tries[a][i] = los[a][i] = refs[i].lo[a];
            tries[a][count + i] = his[a][i] = refs[i].hi[a];
        }
    for (int a = 0; a < 3; a++) {
        for (uint32_t i = 2 * count; i % LANES; i++)
            tries[a][i] = m[a].lo; /* no plane may stand there */
        if (m[a].inner_lo < m[a].inner_hi)
            try_axis(&m[a], a, los[a], his[a], tries[a], count, &b);
    }
    at = least_of(&b, &best->cost);
    if (at < 0)
        return;
    best->axis = (uint32_t)at / 64;
    best->pos = tries[best->axis][at % 64];
    for (uint32_t i = 0; i < count; i++) {
        best->left_count += los[best->axis][i] < best->pos;
        best->right_count += his[best->axis][i] > best->pos;
    }
}

/* ---- many: bins ----------------------------------------------------------------------------------------------------------- */

/* Monotone in x, which is all that the counts need to be exact. x lies in the cell, so the product is not negative. */
static inline uint32_t bin_of(float x, float lo, float scale, float last)
{
    float f = (x - lo) * scale;
    return (uint32_t)(int32_t)(f < last ? f : last);
}

/* References of a node, every stride-th of them, `count` in all. ctx: NULL, or whose workers look at them, RTI_KD_SHARE a task.
 */
typedef struct slice {
    rt_context *ctx;
    const rti_build *b;
    const rti_ref *refs;
    uint32_t count, stride;
} slice;

static uint32_t shares(const slice *s)
{
    return s->ctx ? (s->count + RTI_KD_SHARE - 1) / RTI_KD_SHARE : 1;
}

static slice share_of(const slice *s, uint32_t index)
{
    slice part = *s;
    part.ctx = NULL;
    part.refs += (size_t)index * RTI_KD_SHARE * s->stride;
    part.count = rtk_umin(s->count - index * RTI_KD_SHARE, RTI_KD_SHARE);
    return part;
}

/* false: cancelled, the counts are not complete. */
static bool add_bins(const slice *s, rti_kd_bins *n)
{
    const rti_kd_bin_kernels *kernels = rti_kd_bin_kernels_at(s->b->isa);
    for (uint32_t i = 0; i < s->count; i += 65536) {
        if (i > 0 && rti_cancelled(s->b->cancel))
            return false;
        kernels->add(n, s->refs + (size_t)i * s->stride, rtk_umin(s->count - i, 65536), s->stride);
    }
    return true;
}

typedef struct bin_job {
    const slice *all;
    rti_kd_bins *bins; /* [shares], empty */
} bin_job;

static void bin_task(void *data, uint32_t index)
{
    const bin_job *job = data;
    const slice part = share_of(job->all, index);
    if (!rti_cancelled(part.b->cancel))
        add_bins(&part, &job->bins[index]);
}

/* As add_bins, to empty ones, by all workers. Without memory for it, by the caller. */
static bool add_bins_together(const slice *s, rti_kd_bins *n)
{
    const uint32_t tasks = shares(s);
    bin_job job = {s, tasks > 1 ? rti_alloc_array(s->ctx, tasks, sizeof *job.bins) : NULL};
    if (!job.bins)
        return add_bins(s, n);
    for (uint32_t i = 0; i < tasks; i++)
        job.bins[i] = *n;
    rti_parallel(s->ctx, tasks, bin_task, &job);
    for (uint32_t i = 0; i < tasks; i++)
        for (uint32_t k = 0; k < n->count; k++)
            for (uint32_t a = 0; a < 4; a++) {
                n->lo[k][a] += job.bins[i].lo[k][a];
                n->hi[k][a] += job.bins[i].hi[k][a];
            }
    rti_free(s->ctx, job.bins, tasks * sizeof *job.bins);
    return !rti_cancelled(s->b->cancel);
}

/* false: cancelled. */
static bool fill_bins(const slice *s, const measure m[3], rti_kd_bins *n)
{
    const uint32_t count = s->count;
    n->count = count < 64 ? 16 : (count < 1024 ? 32 : RTI_KD_BINS);
    n->last = (float)(n->count - 1);
    n->base = (rti_f4){m[0].lo, m[1].lo, m[2].lo, 0.0f};
    n->scale = rti_f4_set(0.0f);
    memset(n->lo, 0, n->count * sizeof n->lo[0]);
    memset(n->hi, 0, n->count * sizeof n->hi[0]);
    for (int a = 0; a < 3; a++)
        n->scale[a] = rtk_min((float)n->count / (m[a].hi - m[a].lo), 3.0e38f);
    return add_bins_together(s, n);
}

/* What the counts alone say, by axis: a lower bound of every bin's cost, the cheapest edge between bins and the bin before it. */
typedef struct bounds {
    rti_f4 cost[RTI_KD_BINS];
    float edge;
    uint32_t edge_axis, edge_bin;
} bounds;

#define ALL3(m, field) ((rti_f4){(m)[0].field, (m)[1].field, (m)[2].field, 0.0f})

static rti_f4 plane_costs(const measure *m, rti_f4 cap, rti_f4 rim, rti_i4 left, rti_i4 right, rti_f4 w0, rti_f4 w1)
{
    rti_f4 c = rti_i4_floats(left) * (cap + rim * w0);
    c += rti_i4_floats(right) * (cap + rim * w1);
    return m->traverse + m->intersect * rti_f4_pick((left == 0) | (right == 0), c * m->keep, c);
}

static void bound_bins(const measure m[3], const rti_kd_bins *n, uint32_t count, bounds *out)
{
    rti_f4 cap = ALL3(m, cap), rim = ALL3(m, rim), none = rti_f4_set(3.0e38f), edge = none;
    rti_f4 width = (ALL3(m, hi) - ALL3(m, lo)) * (1.0f / (float)n->count);
    rti_i4 left = {0}, right = rti_i4_set((int)count), usable = ALL3(m, inner_lo) < ALL3(m, inner_hi), edge_bin = {0};
    usable &= (rti_i4){-1, -1, -1, 0};
    for (uint32_t j = 0; j < n->count; j++) {
        rti_i4 lo, hi, take;
        rti_f4 w0 = (float)j * width, w1 = (float)(n->count - 1 - j) * width, c;
        memcpy(&lo, n->lo[j], sizeof lo);
        memcpy(&hi, n->hi[j], sizeof hi);
        c = 0.9999f * plane_costs(m, cap, rim, left, right - hi, w0, w1);
        out->cost[j] = rti_f4_pick(usable & ((lo | hi) != 0), c, none);
        left += lo;
        right -= hi;
        if (j + 1 == n->count)
            break;
        c = plane_costs(m, cap, rim, left, right, w0 + width, w1);
        take = usable & (c < edge);
        edge = rti_f4_pick(take, c, edge);
        edge_bin = rti_i4_pick(take, rti_i4_set((int)j), edge_bin);
    }
    out->edge_axis = 0;
    for (uint32_t a = 1; a < 3; a++)
        if (edge[a] < edge[out->edge_axis])
            out->edge_axis = a;
    out->edge = edge[out->edge_axis];
    out->edge_bin = (uint32_t)edge_bin[out->edge_axis];
}

/* Where the best plane of each axis is looked for: in its bins that `wanted` marks. scratch: 3 * count floats an axis, or all in
 * one where they come one by one. */
typedef struct refine_job {
    const slice *all;
    const measure *m;
    const rti_kd_bins *n;
    const uint64_t *wanted;
    float *scratch;
    rti_kd_split *best; /* [3] */
} refine_job;

/* Bounds in wanted bins of one axis: how many there are of each share. */
typedef struct gather_job {
    const refine_job *of;
    uint32_t axis;
    float *los, *his; /* a share's from its first reference's number on */
    uint32_t tasks, (*counts)[2];
} gather_job;

static void gather_task(void *data, uint32_t index)
{
    const gather_job *job = data;
    const refine_job *r = job->of;
    const slice part = job->tasks > 1 ? share_of(r->all, index) : *r->all;
    const uint64_t wanted = r->wanted[job->axis];
    const float base = r->m[job->axis].lo, scale = r->n->scale[job->axis], last = r->n->last;
    float *los = job->los + (size_t)index * RTI_KD_SHARE, *his = job->his + (size_t)index * RTI_KD_SHARE;
    uint32_t lo_count = 0, hi_count = 0;
    for (uint32_t i = 0; i < part.count; i++) {
        const rti_ref *ref = part.refs + (size_t)i * part.stride;
        los[lo_count] = ref->lo[job->axis];
        lo_count += wanted >> bin_of(ref->lo[job->axis], base, scale, last) & 1u;
        his[hi_count] = ref->hi[job->axis];
        hi_count += wanted >> bin_of(ref->hi[job->axis], base, scale, last) & 1u;
    }
    job->counts[index][0] = lo_count;
    job->counts[index][1] = hi_count;
}

/* All of them side by side, in the references' order. Without memory for it, by the caller. */
static void gather(const refine_job *r, uint32_t axis, float *los, float *his, uint32_t *lo_count, uint32_t *hi_count)
{
    const uint32_t tasks = shares(r->all);
    uint32_t one[1][2], (*many)[2] = tasks > 1 ? rti_alloc_array(r->all->ctx, tasks, sizeof *many) : NULL;
    gather_job job = {r, axis, los, his, many ? tasks : 1, many ? many : one};
    *lo_count = *hi_count = 0;
    if (many)
        rti_parallel(r->all->ctx, tasks, gather_task, &job);
    else
        gather_task(&job, 0);
    for (uint32_t i = 0; i < job.tasks; i++) {
        memmove(los + *lo_count, los + (size_t)i * RTI_KD_SHARE, job.counts[i][0] * sizeof *los);
        memmove(his + *hi_count, his + (size_t)i * RTI_KD_SHARE, job.counts[i][1] * sizeof *his);
        *lo_count += job.counts[i][0];
        *hi_count += job.counts[i][1];
    }
    rti_free(r->all->ctx, many, tasks * sizeof *many);
}

/* Sorts and sweeps the bounds of one axis. */
static void refine_task(void *data, uint32_t axis)
{
    const refine_job *r = data;
    const rti_kd_bins *n = r->n;
    const uint64_t wanted = r->wanted[axis];
    const uint32_t count = r->all->count;
    float *los = r->scratch + (r->all->ctx ? 3 * (size_t)axis * count : 0), *his = los + count, *temp = his + count;
    uint32_t lo_count, hi_count, lo_done = 0, hi_done = 0, left = 0, gone = 0;
    if (!wanted)
        return;
    gather(r, axis, los, his, &lo_count, &hi_count);
    rti_kd_sort(los, lo_count, temp);
    rti_kd_sort(his, hi_count, temp);
    for (uint32_t j = 0; j < n->count && wanted >> j; j++) {
        if (wanted >> j & 1u) {
            sweep(&r->m[axis], axis, los + lo_done, n->lo[j][axis], his + hi_done, n->hi[j][axis], left, gone, count,
                  &r->best[axis]);
            lo_done += n->lo[j][axis];
            hi_done += n->hi[j][axis];
        }
        left += n->lo[j][axis];
        gone += n->hi[j][axis];
    }
}

/* The cheapest of the axes, of equal ones the first. */
static void refine(const slice *s, const measure m[3], const rti_kd_bins *n, const uint64_t wanted[3], float *scratch,
                   rti_kd_split *best)
{
    rti_kd_split of[3] = {*best, *best, *best};
    refine_job job = {s, m, n, wanted, scratch, of};
    if (s->ctx)
        rti_parallel(s->ctx, 3, refine_task, &job);
    for (uint32_t a = 0; a < 3; a++) {
        if (!s->ctx)
            refine_task(&job, a);
        if (of[a].cost < best->cost)
            *best = of[a];
    }
}

/* Bins to look into, a bit each: all that may hold the best plane, or (binned) the one with the least bound and those beside the
 * cheapest edge. */
static void choose_bins(const rti_build *b, const rti_kd_bins *n, const bounds *s, float leaf_cost, uint64_t wanted[3])
{
    bool exact = b->builder == RTI_BUILD_KD_EXACT;
    float limit = s->edge * 1.0001f < leaf_cost ? s->edge * 1.0001f : leaf_cost, least = limit;
    rti_f4 low = rti_f4_set(limit);
    for (uint32_t j = 0; j < n->count; j++)
        low = rti_f4_min(s->cost[j], low);
    for (int a = 0; a < 3; a++)
        least = low[a] < least ? low[a] : least;
    for (uint32_t a = 0; a < 3; a++) {
        wanted[a] = 0;
        for (uint32_t j = 0; j < n->count && low[a] < limit; j++) {
            bool near = a == s->edge_axis && (j == s->edge_bin || j == s->edge_bin + 1);
            wanted[a] |= (uint64_t)(s->cost[j][a] < limit && (exact || near || s->cost[j][a] <= least)) << j;
        }
    }
}

/* The plane at the cheapest edge. Counts are the bins', which may differ by those that lie on the plane but for rounding. */
static void take_edge(const measure m[3], const rti_kd_bins *n, const bounds *s, uint32_t count, rti_kd_split *best)
{
    uint32_t axis = s->edge_axis, left = 0, right = count;
    float pos = m[axis].lo + (m[axis].hi - m[axis].lo) * ((float)(s->edge_bin + 1) / (float)n->count);
    for (uint32_t j = 0; j <= s->edge_bin; j++) {
        left += n->lo[j][axis];
        right -= n->hi[j][axis];
    }
    if (pos > m[axis].inner_lo && pos < m[axis].inner_hi)
        *best = (rti_kd_split){s->edge, pos, axis, left, right};
}

static void split_binned(const slice *all, const measure m[3], float *scratch, rti_kd_split *best)
{
    const rti_build *b = all->b;
    rti_kd_bins n;
    bounds s;
    uint64_t wanted[3];
    if (!fill_bins(all, m, &n))
        return; /* a leaf, in a tree that nobody will see */
    bound_bins(m, &n, all->count, &s);
    if (b->builder == RTI_BUILD_KD_BINNED && all->count > EDGE_ABOVE && s.edge < best->cost) {
        take_edge(m, &n, &s, all->count, best);
        return;
    }
    choose_bins(b, &n, &s, best->cost, wanted);
    refine(all, m, &n, wanted, scratch, best);
}

/* ---- very many: a sample -------------------------------------------------------------------------------------------------- */

/* How many references are on each side of a plane. */
typedef struct side_job {
    const slice *all;
    const rti_kd_split *plane;
    atomic_uint left, right;
} side_job;

static void count_sides(const slice *s, side_job *job)
{
    const uint32_t axis = job->plane->axis;
    const float pos = job->plane->pos;
    uint32_t left = 0, right = 0;
    for (uint32_t i = 0; i < s->count; i++) {
        left += s->refs[i].lo[axis] < pos;
        right += s->refs[i].hi[axis] > pos;
    }
    atomic_fetch_add_explicit(&job->left, left, memory_order_relaxed);
    atomic_fetch_add_explicit(&job->right, right, memory_order_relaxed);
}

static void side_task(void *data, uint32_t index)
{
    side_job *job = data;
    const slice part = share_of(job->all, index);
    count_sides(&part, job);
}

/* The plane that is cheapest for every stride-th reference, with the counts and the cost of all. false: what the sample says is
 * no split that pays. (Hunt, Mark, Stoll 2006 choose from samples of the cost; a sample of the primitives is as good for large
 * nodes, and one pass over the memory is saved a level.) */
static bool split_sampled(const slice *all, const measure m[3], float *scratch, rti_kd_split *best)
{
    const uint32_t stride = all->count / SAMPLE;
    const slice sample = {NULL, all->b, all->refs, all->count / stride, stride};
    rti_kd_split s = {all->b->cost_sought * (float)sample.count, 0.0f, 3, 0, 0};
    side_job job = {all, &s, 0, 0};
    split_binned(&sample, m, scratch, &s);
    if (s.axis == 3)
        return false;
    if (shares(all) > 1)
        rti_parallel(all->ctx, shares(all), side_task, &job);
    else
        count_sides(all, &job);
    consider(&m[s.axis], s.axis, s.pos, job.left, job.right, best);
    return best->axis < 3;
}

rti_kd_split rti_kd_find_split(rt_context *ctx, const rti_build *b, const rti_cell *cell, const rti_ref *refs, uint32_t count,
                               float *scratch)
{
    const slice all = {count > RTI_KD_SHARE ? ctx : NULL, b, refs, count, 1};
    rti_kd_split best = {b->cost_sought * (float)count, 0.0f, 3, 0, 0}; /* a leaf's cost: what is dearer is no split */
    measure m[3];
    measure_cell(b, cell, m);
    if (count <= DIRECT_MAX)
        split_direct(m, refs, count, &best);
    else if (b->builder == RTI_BUILD_KD_EXACT || count < 2 * SAMPLE || !split_sampled(&all, m, scratch, &best))
        split_binned(&all, m, scratch, &best);
    return best;
}
