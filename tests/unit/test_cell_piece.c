/* Pieces of a kd-tree's leaves, at each instruction set: boxes of triangles' parts against a clip in doubles, and where they are
 * parted. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "accel/cell_build.h"
#include "support/generate.h"

enum { SOME = 64, ROUNDS = 400 };

/* A box about a triangle: around a point of it, of any size; sometimes with a face at a vertex. */
static rti_cell box_about(test_rng *r, const rtk_tri *tri, float extent)
{
    const float u = test_unit(r), v = test_unit(r), by[3] = {test_unit(r), test_unit(r), test_unit(r)};
    rti_cell c;
    for (int a = 0; a < 3; a++) {
        const float at = tri->v0[a] + u * (tri->v1[a] - tri->v0[a]) + v * (tri->v2[a] - tri->v0[a]);
        const float size = extent * exp2f(-12.0f * by[a]);
        c.lo[a] = at - size * test_unit(r);
        c.hi[a] = at + size * test_unit(r);
        if (test_u32(r) % 4 == 0)
            c.lo[a] = tri->v1[a];
        if (test_u32(r) % 4 == 0)
            c.hi[a] = tri->v2[a];
        if (!(c.lo[a] < c.hi[a]))
            c.hi[a] = c.lo[a] + 0.01f * extent;
    }
    return c;
}

/* Holds what is in a box's part of a triangle, and not much more. Returns by how much more, in the part's sides. */
static double check_ref(const rti_build *b, const rti_cell *cell, uint32_t prim, const rti_ref *got)
{
    const rtk_tri *tri = &b->in->tris[prim];
    rti_ref part;
    double more = 0.0, sides = 0.0;
    assert_int_equal(got->prim, prim);
    if (!rti_ref_clip(b, cell, prim, &part))
        return 0.0;
    for (int a = 0; a < 3; a++) {
        const float low = rtk_min(rtk_min(tri->v0[a], tri->v1[a]), tri->v2[a]) - 1.26f * b->in->grow;
        const float high = rtk_max(rtk_max(tri->v0[a], tri->v1[a]), tri->v2[a]) + 1.26f * b->in->grow;
        assert_true(got->lo[a] <= part.lo[a] && got->hi[a] >= part.hi[a]);
        assert_true(got->lo[a] >= rtk_max(low, cell->lo[a]) && got->hi[a] <= rtk_min(high, cell->hi[a]));
        more += ((double)got->hi[a] - got->lo[a]) - ((double)part.hi[a] - part.lo[a]);
        sides += (double)part.hi[a] - part.lo[a];
    }
    return more / sides;
}

static void test_refs(void **state)
{
    (void)state;
    for (int k = 0; k < 6; k++) {
        static const float scales[6] = {1.0f, 1.0f, 1.0f, 1.0f, 1.0e-5f, 1.0e8f};
        test_mesh m = {0};
        test_rng r = {(uint64_t)k};
        double more = 0.0;
        if (k == 1)
            test_mesh_slivers(&m, 2000);
        else if (k == 2)
            test_mesh_lattice(&m, 12);
        else
            test_mesh_soup(&m, 2000, k == 3 ? 0.02f : 0.7f, 5);
        test_mesh_place(&m, scales[k], k % 2 == 1 ? 3.0f * scales[k] : 0.0f);
        const rti_build_input in = test_input(&m);
        const rti_build b = {.in = &in};
        for (int round = 0; round < ROUNDS; round++) {
            uint32_t prims[SOME];
            const uint32_t count = 1 + test_u32(&r) % SOME, near = test_u32(&r) % m.count;
            const rti_cell cell = box_about(&r, &m.tris[near], scales[k]);
            rti_ref first[SOME], refs[SOME];
            for (uint32_t i = 0; i < count; i++)
                prims[i] = i % 3 == 0 ? near : test_u32(&r) % m.count;
            for (int isa = 0; isa < RTI_ISA_COUNT; isa++) {
                if (!rti_isa_runs((rti_isa)isa))
                    continue;
                memset(refs, 0, sizeof refs);
                rti_cell_piece_kernels_at((rti_isa)isa)->refs(&in, cell.lo, cell.hi, prims, count, refs);
                if (isa == RTI_ISA_GENERIC)
                    memcpy(first, refs, sizeof refs);
                assert_memory_equal(first, refs, sizeof refs);
            }
            more += check_ref(&b, &cell, near, &first[0]);
            for (uint32_t i = 1; i < count; i++)
                check_ref(&b, &cell, prims[i], &first[i]);
        }
        print_message("%d: %g\n", k, more / ROUNDS);
        assert_true(more / ROUNDS < 0.06);
        test_mesh_free(&m);
    }
}

/* many: what so many triangles cost, not blocks. */
static double cost_of(const rti_bvh *t, const rti_ref *refs, uint32_t count, bool many)
{
    double d[3], area;
    const rti_bvh_box box = rti_cell_piece_kernels_at(RTI_ISA_GENERIC)->around(refs, count);
    for (int a = 0; a < 3; a++)
        d[a] = (double)box.hi[a] - box.lo[a];
    area = d[0] * d[1] + d[1] * d[2] + d[2] * d[0];
    return area * (many ? 0.25 * count * t->leaf_cost : (double)rti_bvh_leaf_cost(t, count));
}

static int by_axis;

static int compare(const void *a, const void *b)
{
    const rti_ref *p = a, *q = b;
    const float x = p->lo[by_axis] + p->hi[by_axis], y = q->lo[by_axis] + q->hi[by_axis];
    return (x > y) - (x < y);
}

/* The cheapest way to part some references in two, or not to. */
static double best_of_few(const rti_bvh *t, const rti_ref *refs, uint32_t count)
{
    double best = cost_of(t, refs, count, false);
    for (uint32_t chosen = 1; chosen + 1 < 1u << count; chosen++) {
        rti_ref side[2][4];
        uint32_t n[2] = {0, 0};
        for (uint32_t i = 0; i < count; i++) {
            const uint32_t k = chosen >> i & 1u;
            side[k][n[k]++] = refs[i];
        }
        best = fmin(best, cost_of(t, side[0], n[0], false) + cost_of(t, side[1], n[1], false));
    }
    return best;
}

/* No place along any axis is cheaper; of few references, no way at all is. */
static void test_part(void **state)
{
    const rti_bvh t = {.together = 2, .leaf_cost = 1.0f, .unit = 1.0f, .grow2 = {0}, .many_area = 1.0f};
    test_rng r = {9};
    uint32_t wholes = 0;
    (void)state;
    for (int round = 0; round < ROUNDS; round++) {
        rti_ref refs[SOME], first[SOME], sorted[SOME], other[SOME];
        const uint32_t count = round % 4 == 1 ? 3 + test_u32(&r) % 2 : 3 + test_u32(&r) % (SOME - 2);
        const bool many = round / 8 % 2 == 1; /* as large as is met by many rays; a block is one in any case */
        const float area = many ? 2.0f : 0.5f;
        uint32_t left = 0, seen = 0;
        double best = INFINITY;
        for (uint32_t i = 0; i < count; i++) {
            refs[i] = (rti_ref){.prim = i};
            for (int a = 0; a < 3; a++) {
                const float wide = round % 8 == 1 ? 0.1f : 1.0f; /* few that lie in each other */
                refs[i].lo[a] = round % 8 == 0 ? 0.25f : test_range(&r, -wide, wide);
                refs[i].hi[a] = refs[i].lo[a] + (wide < 1.0f ? 1.0f : test_unit(&r));
            }
        }
        for (int isa = 0; isa < RTI_ISA_COUNT; isa++) {
            if (!rti_isa_runs((rti_isa)isa))
                continue;
            const uint32_t at = rti_cell_piece_kernels_at((rti_isa)isa)->part(&t, refs, count, area, sorted);
            if (isa == RTI_ISA_GENERIC) {
                left = at;
                memcpy(first, sorted, sizeof sorted);
            }
            assert_int_equal(at, left);
            assert_true(left == 0 || memcmp(first, sorted, count * sizeof *sorted) == 0);
        }
        wholes += left == 0;
        if (left == 0) {
            assert_true(count <= RTK_BVH_BLOCK && cost_of(&t, refs, count, false) <= best_of_few(&t, refs, count) * 1.000001);
            continue;
        }
        assert_true(left < count);
        for (uint32_t i = 0; i < count; i++) {
            assert_memory_equal(&first[i], &refs[first[i].prim], sizeof *refs);
            seen += first[i].prim;
        }
        assert_int_equal(seen, count * (count - 1) / 2);
        if (count <= RTK_BVH_BLOCK)
            best = best_of_few(&t, refs, count);
        for (by_axis = 0; by_axis < 3 && count > RTK_BVH_BLOCK; by_axis++) {
            memcpy(other, refs, sizeof other);
            qsort(other, count, sizeof *other, compare);
            for (uint32_t k = 1; k < count; k++)
                best = fmin(best, cost_of(&t, other, k, many) + cost_of(&t, other + k, count - k, many));
        }
        if (round % 8 != 0) /* there an order among equal ones would count */
            assert_true(cost_of(&t, first, left, count > RTK_BVH_BLOCK && many) +
                            cost_of(&t, first + left, count - left, count > RTK_BVH_BLOCK && many) <=
                        best * 1.000001);
    }
    assert_in_range(wholes, ROUNDS / 20, ROUNDS / 4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_refs), cmocka_unit_test(test_part)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
