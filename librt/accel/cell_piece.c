/* Pieces of large leaves of cells (cell_leaf.c): boxes of triangles' parts in a leaf's box, and where a range of them is parted.
 * A hot file (base/isa.h): the same pieces at each level.
 *
 * A triangle's part in a box is bounded from several sides, many at a time: by what it reaches to on the other two axes between
 * the box's planes across one (and between what is known of the part), and by its own plane. That is as much as a clip gives, to
 * a hundredth of the sides (test_cell_piece.c). All planes and bounds have ROOM times the growth: a quarter of it, 2^-19 of the
 * scale, covers that all is in floats. Where an edge meets a plane is as if the plane stood 2^-22 (|plane| + |vertex|) elsewhere,
 * and its other coordinates are 2^-22 of the scale off at most.
 */
#include "cell_build.h"
#include "corners.h"
#include "hull.h"

#define ROOM 1.25f

/* Triangles by lanes: vertices, and bounds of what counts. */
typedef struct parts {
    lanes v[3][3], low[3], high[3];
} parts;

/* Narrows the bounds on the two axes after `a` to what lies between two planes across it. */
RTI_VEC void narrow(parts *p, uint32_t a, lanes from, lanes to)
{
    const uint32_t axis[2] = {(a + 1) % 3, (a + 2) % 3};
    const lanes most = V(set)(RTK_INF), least = V(set)(-RTK_INF);
    lanes low[2] = {most, most}, high[2] = {least, least};
    for (uint32_t i = 0; i < 3; i++) {
        const uint32_t j = i == 2 ? 0 : i + 1;
        const lanes x = p->v[i][a], y = p->v[j][a], d = y - x;
        const yes in = M(and)(V(le)(from, x), V(le)(x, to));
        for (uint32_t k = 0; k < 2; k++) {
            low[k] = V(min)(V(select)(in, p->v[i][axis[k]], most), low[k]);
            high[k] = V(max)(V(select)(in, p->v[i][axis[k]], least), high[k]);
        }
        for (uint32_t side = 0; side < 2; side++) {
            const lanes plane = side == 0 ? from : to, t = (plane - x) / d;
            const yes below = V(lt)(x, plane), above = V(lt)(y, plane);
            const yes met = M(or)(M(andnot)(below, above), M(andnot)(above, below));
            for (uint32_t k = 0; k < 2; k++) {
                const lanes w = p->v[i][axis[k]], at = w + t * (p->v[j][axis[k]] - w);
                low[k] = V(min)(V(select)(met, at, most), low[k]);
                high[k] = V(max)(V(select)(met, at, least), high[k]);
            }
        }
    }
    for (uint32_t k = 0; k < 2; k++) {
        p->low[axis[k]] = V(max)(low[k], p->low[axis[k]]);
        p->high[axis[k]] = V(min)(high[k], p->high[axis[k]]);
    }
}

/* Narrows all of them by the triangle's own plane: n (x - v0) is 0, but for what the floats' roundings, 2^-20 of what is summed,
 * and products that are denormal make of it. */
RTI_VEC void narrow_by_plane(parts *p, float spare)
{
    lanes least[3], most[3], n[3], off = V(set)(1.0e-42f);
    for (uint32_t a = 0; a < 3; a++) {
        const uint32_t b = (a + 1) % 3, g = (a + 2) % 3;
        const lanes x = (p->v[1][b] - p->v[0][b]) * (p->v[2][g] - p->v[0][g]),
                    y = (p->v[1][g] - p->v[0][g]) * (p->v[2][b] - p->v[0][b]);
        const lanes low = (p->low[a] - V(set)(spare)) - p->v[0][a], high = (p->high[a] + V(set)(spare)) - p->v[0][a];
        n[a] = x - y;
        least[a] = V(min)(n[a] * low, n[a] * high);
        most[a] = V(max)(n[a] * low, n[a] * high);
        off = off + (V(abs)(x) + V(abs)(y)) * V(set)(9.5367432e-07f) * V(max)(V(abs)(low), V(abs)(high));
    }
    for (uint32_t a = 0; a < 3; a++) {
        const uint32_t b = (a + 1) % 3, g = (a + 2) % 3;
        const lanes one = (-(most[b] + most[g]) - off) / n[a], other = (off - (least[b] + least[g])) / n[a];
        const yes some = V(lt)(V(set)(0.0f), V(abs)(n[a]));
        const lanes low = p->v[0][a] + V(min)(one, other), high = p->v[0][a] + V(max)(one, other);
        p->low[a] = V(select)(some, V(max)(low, p->low[a]), p->low[a]);
        p->high[a] = V(select)(some, V(min)(high, p->high[a]), p->high[a]);
    }
}

/* Narrows them by the box's planes across `a`, where a triangle passes one. */
RTI_VEC void narrow_across(parts *p, uint32_t a, float lo, float hi, float grow, lanes least, lanes most)
{
    const lanes spare = V(set)((ROOM - 1.0f) * grow), low = V(set)(lo - ROOM * grow), high = V(set)(hi + ROOM * grow);
    const lanes from = V(max)(p->low[a] - spare, low), to = V(min)(p->high[a] + spare, high);
    p->low[a] = V(max)(p->low[a], low);
    p->high[a] = V(min)(p->high[a], high);
    if (M(bits)(M(or)(V(lt)(least, from), V(lt)(to, most))) != 0u)
        narrow(p, a, from, to);
}

static inline void refs_of(const rti_build_input *in, const float lo[3], const float hi[3], const rtk_tri *const tris[LANES],
                           lanes low[4], lanes high[4])
{
    const float grow = in->grow;
    lanes least[3], most[3], outer = V(set)(0.0f);
    parts p;
    yes fine;
    corners_of(tris, p.v);
    for (uint32_t a = 0; a < 3; a++) {
        least[a] = p.low[a] = V(min)(V(min)(p.v[0][a], p.v[1][a]), p.v[2][a]);
        most[a] = p.high[a] = V(max)(V(max)(p.v[0][a], p.v[1][a]), p.v[2][a]);
        outer = V(max)(V(max)(V(set)(lo[a]) - least[a], most[a] - V(set)(hi[a])), outer);
    }
    if (M(bits)(V(lt)(V(set)(0.0f), outer)) != 0u)
        for (uint32_t round = 0; round < 2; round++) {
            if (round > 0)
                narrow_by_plane(&p, (ROOM - 1.0f) * grow);
            narrow_across(&p, 0, lo[0], hi[0], grow, least[0], most[0]);
            narrow_across(&p, 1, lo[1], hi[1], grow, least[1], most[1]);
            narrow_across(&p, 2, lo[2], hi[2], grow, least[2], most[2]);
        }
    fine = M(of)(~0u);
    for (uint32_t a = 0; a < 3; a++) {
        low[a] = V(max)(p.low[a] - V(set)(ROOM * grow), V(set)(lo[a]));
        high[a] = V(min)(p.high[a] + V(set)(ROOM * grow), V(set)(hi[a]));
        fine = M(and)(fine, V(lt)(low[a], high[a]));
    }
    for (uint32_t a = 0; a < 3; a++) { /* where nothing is left: the builder cuts boxes alone where references are few */
        low[a] = V(select)(fine, low[a], V(max)(least[a] - V(set)(grow), V(set)(lo[a])));
        high[a] = V(select)(fine, high[a], V(min)(most[a] + V(set)(grow), V(set)(hi[a])));
    }
    low[3] = high[3] = V(set)(0.0f);
}

static inline void store_row(float *to, const lanes rows[4], uint32_t i)
{
#if RTI_SIMD >= 8
    rti_f4_store(to, i < 4 ? rti_f8_low(rows[i]) : rti_f8_high(rows[i - 4]));
#else
    rti_f4_store(to, rows[i]);
#endif
}

static void refs(const rti_build_input *in, const float lo[3], const float hi[3], const uint32_t *prims, uint32_t count,
                 rti_ref *to)
{
    for (uint32_t i = 0; i < count; i++)
        rti_tri_expect(&in->tris[prims[i]]);
    for (uint32_t first = 0; first < count; first += LANES) {
        const uint32_t n = rtk_umin(count - first, LANES);
        const rtk_tri *some[LANES];
        lanes low[4], high[4], low_rows[4], high_rows[4];
        for (uint32_t i = 0; i < LANES; i++)
            some[i] = &in->tris[prims[first + rtk_umin(i, n - 1)]];
        refs_of(in, lo, hi, some, low, high);
        V(turn)(low, low_rows);
        V(turn)(high, high_rows);
        for (uint32_t i = 0; i < n; i++) {
            store_row(to[first + i].lo, low_rows, i);
            store_row(to[first + i].hi, high_rows, i);
            to[first + i].prim = prims[first + i];
        }
    }
}

/* ---- where to part ------------------------------------------------------------------------------------------------------- */

typedef int32_t ints __attribute__((vector_size(4 * LANES)));

_Static_assert((RTI_CELL_SWEPT & (RTI_CELL_SWEPT - 1u)) == 0u && RTI_CELL_SWEPT % LANES == 0u,
               "an index takes the lowest bits of a number");

/* Numbers in the order of references along each axis: lo + hi as good as 17 bits of mantissa tell, then the index. Behind them,
 * up to a full vector, what is none. */
static inline void numbers(const rti_ref *refs, uint32_t count, int32_t low[3][RTI_CELL_SWEPT])
{
    for (uint32_t i = 0; i < count; i += 4) {
        rti_f4 sum[4], by[4];
        for (uint32_t k = 0; k < 4; k++) {
            const rti_ref *ref = &refs[rtk_umin(i + k, count - 1)];
            sum[k] = rti_f4_load(ref->lo) + rti_f4_load(ref->hi);
        }
        rti_f4_turn(sum, by);
        for (uint32_t a = 0; a < 3; a++) {
            rti_i4 bits = (rti_i4)by[a];
            bits ^= bits >> 31 & INT32_MAX;
            bits = (bits & ~(int32_t)(RTI_CELL_SWEPT - 1u)) | ((rti_i4){0, 1, 2, 3} + (int32_t)i);
            memcpy(low[a] + i, &bits, sizeof bits);
        }
    }
    for (uint32_t a = 0; a < 3; a++)
        for (uint32_t i = count; i % LANES != 0; i++)
            low[a][i] = INT32_MAX;
}

/* Their order: each one's place is how many are below it, so nothing has to be foreseen. */
static inline void rank(const int32_t low[RTI_CELL_SWEPT], uint32_t count, uint8_t order[RTI_CELL_SWEPT])
{
    for (uint32_t i = 0; i < count; i += LANES) {
        ints own, below = {0};
        memcpy(&own, low + i, sizeof own);
        for (uint32_t k = 0; k < count; k++)
            below -= low[k] < own;
        for (uint32_t k = 0; k < LANES && i + k < count; k++)
            order[below[k]] = (uint8_t)(i + k);
    }
}

/* Areas of four boxes of references, which are grown already. */
RTI_VEC rti_f4 areas_of(const rti_bvh *t, const hull all[4])
{
    const rti_f4 unit = rti_f4_set(t->unit);
    rti_f4 sides[4], by[4];
    for (uint32_t i = 0; i < 4; i++)
        sides[i] = hull_negative_sides(all[i]);
    rti_f4_turn(sides, by);
    const rti_f4 x = by[0] * unit, y = by[1] * unit, z = by[2] * unit;
    return x * y + y * z + z * x;
}

#define SPARE 4u /* what vectors write in front of a row or behind it */

/* Leaves of pieces stand in blocks: sums here are rti_bvh_leaf_cost's, and three or four cost what one does. */
_Static_assert(RTK_BVH_BLOCK == 4u, "what a leaf costs");

/* Blocks of so many triangles. many: where many rays meet them (rti_bvh_leaf_total) one costs a part of a block; by whole blocks,
 * a wall's two triangles and another's would be as well with two of the ceiling's. */
static inline rti_f4 blocks_of(rti_i4 count, bool many)
{
    if (many)
        return rti_i4_floats(count) * rti_f4_set(0.25f);
    return rti_i4_floats((count + 3) >> 2);
}

/* The cheapest place to part sorted references at; *cost: what it costs. many: as of blocks_of. */
static inline uint32_t sweep(const rti_bvh *t, const hull boxes[RTI_CELL_SWEPT], const uint8_t order[RTI_CELL_SWEPT],
                             uint32_t count, bool many, float *cost)
{
    float left[RTI_CELL_SWEPT + SPARE];      /* areas of the first k + 1, */
    float right[RTI_CELL_SWEPT + 2 * SPARE]; /* and of those from k - SPARE on */
    const rti_f4 own = rti_f4_set(t->leaf_cost);
    hull lefts = hull_nothing(), rights = lefts;
    rti_f4 best = rti_f4_set(RTK_INF);
    rti_i4 which = rti_i4_set(0), fewest = which, at = (rti_i4){1, 2, 3, 4}; /* fewest: blocks, where as cheap */
    for (uint32_t k = 0; k + 1 < count; k += 4) {
        hull from[4], to[4];
        for (uint32_t i = 0; i < 4; i++) { /* beyond the last but one, of which no more is asked, the last again */
            const uint32_t n = rtk_umin(k + i, count - 1);
            /* NOLINTBEGIN(clang-analyzer-core.uninitialized.ArraySubscript): rank() set all of them; its places are vectors */
            from[i] = lefts = hull_around(lefts, boxes[order[n]]);
            to[3 - i] = rights = hull_around(rights, boxes[order[count - 1 - n]]);
            /* NOLINTEND(clang-analyzer-core.uninitialized.ArraySubscript) */
        }
        rti_f4_store(left + k, areas_of(t, from));
        rti_f4_store(right + SPARE + count - 4 - k, areas_of(t, to));
    }
    for (uint32_t k = 1; k < count; k += 4, at += 4) {
        const rti_i4 rest = (int32_t)count - at;
        const rti_f4 sum = rti_f4_load(left + k - 1) * (own * blocks_of(at, many)) +
                           rti_f4_load(right + SPARE + k) * (own * blocks_of(rest, many));
        const rti_i4 blocks = ((at + 3) >> 2) + ((rest + 3) >> 2);
        const rti_i4 take = ((sum < best) | ((sum == best) & (blocks < fewest))) & (rest > 0);
        best = rti_f4_pick(take, sum, best);
        fewest = rti_i4_pick(take, blocks, fewest);
        which = rti_i4_pick(take, at, which);
    }
    uint32_t lane = 0;
    for (uint32_t i = 1; i < 4; i++) {
        const bool fewer = fewest[i] < fewest[lane] || (fewest[i] == fewest[lane] && which[i] < which[lane]);
        if (best[i] < best[lane] || (best[i] == best[lane] && fewer))
            lane = i;
    }
    *cost = best[lane];
    return rtk_umax((uint32_t)which[lane], 1);
}

/* Three or four references, of which all ways are tried: each by itself or, of four, with another one; 0 where none is cheaper
 * than all together. */
static inline uint32_t part_few(const rti_bvh *t, const rti_ref *refs, uint32_t count, rti_ref *sorted)
{
    static const uint8_t orders[7][4] = {{0, 1, 2, 3}, {1, 0, 2, 3}, {2, 0, 1, 3}, {3, 0, 1, 2},
                                         {0, 1, 2, 3}, {0, 2, 1, 3}, {0, 3, 1, 2}};
    const hull a = hull_ref(&refs[0]), b = hull_ref(&refs[1]), c = hull_ref(&refs[2]);
    const hull d = count > 3 ? hull_ref(&refs[3]) : hull_nothing(); /* that by itself costs what is infinite */
    const hull ab = hull_around(a, b), ac = hull_around(a, c), ad = hull_around(a, d);
    const hull cd = hull_around(c, d), bd = hull_around(b, d), bc = hull_around(b, c);
    const hull one[4] = {a, b, c, d},
               others[4] = {hull_around(b, cd), hull_around(a, cd), hull_around(d, ab), hull_around(c, ab)};
    const hull two[4] = {ab, ac, ad, hull_around(ab, cd)}, rest[4] = {cd, bd, bc, bc};
    const rti_f4 halves = areas_of(t, two);
    float cost[8];
    uint32_t best = 0;
    rti_f4_store(cost, areas_of(t, one) + areas_of(t, others));
    rti_f4_store(cost + 4, halves + areas_of(t, rest));
    for (uint32_t k = 1; k < (count > 3 ? 7u : 3u); k++)
        best = cost[k] < cost[best] ? k : best;
    if (!(cost[best] < halves[3]))
        return 0;
    for (uint32_t i = 0, n = 0; i < 4; i++)
        if (orders[best][i] < count)
            sorted[n++] = refs[orders[best][i]];
    return best < 4 ? 1 : 2;
}

static uint32_t part(const rti_bvh *t, const rti_ref *refs, uint32_t count, float area, rti_ref *sorted)
{
    uint8_t order[3][RTI_CELL_SWEPT];
    int32_t low[3][RTI_CELL_SWEPT];
    hull boxes[RTI_CELL_SWEPT];
    uint32_t at = 0, by = 0;
    float least = RTK_INF;
    if (count == 3 || count == 4)
        return part_few(t, refs, count, sorted);
    for (uint32_t i = 0; i < count; i++)
        boxes[i] = hull_ref(&refs[i]);
    numbers(refs, count, low);
    for (uint32_t axis = 0; axis < 3; axis++) {
        float cost;
        rank(low[axis], count, order[axis]);
        const uint32_t place = sweep(t, boxes, order[axis], count, area > t->many_area, &cost);
        if (axis > 0 && !(cost < least))
            continue;
        by = axis;
        least = cost;
        at = place;
    }
    for (uint32_t i = 0; i < count; i++)
        sorted[i] = refs[order[by][i]]; /* NOLINT(clang-analyzer-core.uninitialized.ArraySubscript): likewise */
    return at;
}

static rti_bvh_box around(const rti_ref *refs, uint32_t count)
{
    hull all = hull_nothing();
    for (uint32_t i = 0; i < count; i++)
        all = hull_around(all, hull_ref(&refs[i]));
    return hull_box(all);
}

const rti_cell_piece_kernels RTI_ISA_FN(rti_cell_piece_kernels) = {refs, part, around};
