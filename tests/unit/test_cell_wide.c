/* The nodes of eight that a kd-tree or an octree is folded into. What they are for, test_lists of test_tree.c and test_tracers.c
 * hold. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/generate.h"
#include "support/many.h"

typedef struct leaf {
    float lo[3], hi[3];
    uint32_t first, count;
} leaf;

/* A primitive and a leaf that lists it. */
typedef struct entry {
    uint32_t prim, leaf;
} entry;

/* The leaves below a tree's root that are not empty, at most `room`; kind: the tree's, or BVH for what its cells were folded
 * into. */
static uint32_t leaves_of(const rtk_tree *tree, uint32_t kind, leaf *out, uint32_t room)
{
    static rti_tree_spot stack[RTI_TREE_WALK];
    uint32_t top = 1, n = 0;
    stack[0] = rti_tree_root(tree);
    while (top > 0) {
        rti_tree_spot spot = stack[--top];
        uint32_t refs = 0, opened = rti_tree_kind_of(kind)->open(tree, &spot, stack + top, &refs);
        top += opened;
        if (opened > 0 || refs == 0)
            continue;
        assert_true(n < room);
        memcpy(out[n].lo, spot.lo, sizeof spot.lo);
        memcpy(out[n].hi, spot.hi, sizeof spot.hi);
        out[n].first =
            kind == RTK_TREE_KD ? tree->kd[spot.node].a : (kind == RTK_TREE_BVH ? spot.node : tree->oct[spot.node].first);
        out[n++].count = refs;
    }
    return n;
}

static int by_prim(const void *a, const void *b)
{
    const entry *x = a, *y = b;
    return (x->prim > y->prim) - (x->prim < y->prim);
}

static bool overlap(const leaf *a, const leaf *b)
{
    for (int k = 0; k < 3; k++)
        if (a->lo[k] > b->hi[k] || b->lo[k] > a->hi[k])
            return false;
    return true;
}

/* Leaves in blocks hold triangles alone, no two of them the same, and few; returns what all of them list, by primitives. */
static entry *look_at(const rtk_tree *tree, uint32_t refs, const leaf *wide, uint32_t n, uint32_t tri_count, bool mixed,
                      uint32_t *count)
{
    entry *all = malloc(refs * sizeof *all);
    uint32_t others = 0;
    *count = 0;
    for (uint32_t i = 0; i < n; i++) {
        const bool plain = wide[i].first >= RTK_BVH_BLOCK * tree->block_count;
        bool other = false, tri = false;
        for (uint32_t j = 0; j < wide[i].count; j++) {
            const uint32_t prim = tree->refs[wide[i].first + j];
            other |= prim >= tri_count;
            tri |= prim < tri_count;
            for (uint32_t k = 0; k < j; k++)
                assert_int_not_equal(tree->refs[wide[i].first + k], prim);
            all[(*count)++] = (entry){prim, i};
        }
        assert_int_equal(other, plain);
        assert_int_equal(tri, !plain);
        assert_true(plain || wide[i].count <= 16);
        others += plain;
    }
    assert_int_equal(others > 0, mixed);
    qsort(all, *count, sizeof *all, by_prim);
    return all;
}

/* All that a cell lists is listed by the nodes of eight, too, where they reach into its cell; and they no more often. A
 * box is inside the cells that list what it holds. */
static void compare(const rtk_tree *tree, const leaf *own, uint32_t own_count, const leaf *wide, uint32_t wide_count,
                    const entry *all, uint32_t count)
{
    leaf *cells = malloc(wide_count * sizeof *cells); /* around them */
    uint32_t listed = 0;
    for (uint32_t i = 0; i < wide_count; i++)
        cells[i] = (leaf){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}, 0, 0};
    for (uint32_t i = 0; i < own_count; i++) {
        listed += own[i].count;
        for (uint32_t j = 0; j < own[i].count; j++) {
            const uint32_t prim = tree->refs[own[i].first + j];
            uint32_t low = 0, high = count;
            bool found = false;
            while (low < high) {
                const uint32_t middle = low + (high - low) / 2;
                if (all[middle].prim < prim)
                    low = middle + 1;
                else
                    high = middle;
            }
            for (; low < count && all[low].prim == prim; low++) {
                leaf *around = &cells[all[low].leaf];
                if (!overlap(&wide[all[low].leaf], &own[i]))
                    continue;
                found = true;
                for (int a = 0; a < 3; a++) {
                    around->lo[a] = fminf(around->lo[a], own[i].lo[a]);
                    around->hi[a] = fmaxf(around->hi[a], own[i].hi[a]);
                }
            }
            assert_true(found);
        }
    }
    assert_true(count <= listed);
    for (uint32_t i = 0; i < wide_count; i++)
        for (int a = 0; a < 3; a++)
            assert_true(cells[i].lo[a] <= wide[i].lo[a] && wide[i].lo[a] <= wide[i].hi[a] && wide[i].hi[a] <= cells[i].hi[a]);
    free(cells);
}

/* Of triangles by each builder, with boxes, of one triangle, in small cells. */
static const struct {
    rti_build_settings s;
    enum { ALL, PAPER, BOXES_TOO, ONE, SMALL } of;
} ways[] = {
    {{.builder = RTI_BUILD_KD_EXACT}, ALL},   {{.builder = RTI_BUILD_KD_BINNED}, ALL},
    {{.builder = RTI_BUILD_KD_EXACT}, PAPER}, {{.builder = RTI_BUILD_KD_EXACT}, BOXES_TOO},
    {{.builder = RTI_BUILD_KD_EXACT}, ONE},   {{.builder = RTI_BUILD_KD_EXACT, .cost_intersect = 0.0625f}, SMALL},
    {{.builder = RTI_BUILD_OCTREE}, ALL},     {{.builder = RTI_BUILD_OCTREE}, BOXES_TOO},
    {{.builder = RTI_BUILD_OCTREE}, ONE},     {{.builder = RTI_BUILD_OCTREE, .leaf_size = 8}, SMALL},
};

/* The nodes of eight hold what the cells do: triangles alone in blocks, of a large leaf in pieces. */
static void test_wide(void **state)
{
    rt_context_desc d = rt_context_desc_default();
    rt_context *ctx;
    test_mesh m = {0};
    enum { BOXES = 300 };
    static float boxes[BOXES][6];
    test_rng r = {5};
    (void)state;
    d.workers = 2;
    assert_int_equal(rt_context_create(&d, &ctx), RT_OK);
    test_mesh_soup(&m, TEST_MANY(20000), 0.05f, 42);
    test_mesh_soup(&m, 50, 2.0f, 42);
    for (int i = 0; i < 500; i++) /* more than go onto three axes, at one place */
        test_mesh_add(&m, m.tris[0].v0, m.tris[0].v1, m.tris[0].v2);
    for (int i = 0; i < BOXES; i++)
        for (int a = 0; a < 3; a++) {
            boxes[i][a] = test_range(&r, -1, 1);
            boxes[i][3 + a] = boxes[i][a] + 0.1f;
        }
    for (size_t k = 0; k < RTI_COUNT(ways); k++) {
        const bool mixed = ways[k].of == BOXES_TOO;
        rti_build_input in = test_input_boxes(&m, (const float(*)[6])boxes, mixed ? BOXES : 0);
        const rti_build_settings s = ways[k].of == PAPER ? rti_build_preset_find("paper")->settings : ways[k].s;
        void *chunk;
        size_t size;
        if (ways[k].of == ONE)
            in.tri_count = 1;
        assert_int_equal(rti_tree_build(ctx, &in, &s, NULL, &chunk, &size), RT_OK);
        const rtk_tree_header *h = chunk;
        rtk_tree tree = rti_tree_view(chunk);
        leaf *own = malloc(h->leaf_count * sizeof *own), *wide = malloc(h->ref_count * sizeof *wide);
        uint32_t n = leaves_of(&tree, h->kind, own, h->leaf_count), count;
        const uint32_t many = leaves_of(&tree, RTK_TREE_BVH, wide, h->ref_count);
        entry *all = look_at(&tree, h->ref_count, wide, many, in.tri_count, mixed, &count);
        assert_int_equal(n, h->leaf_count - h->empty_leaf_count);
        assert_true(ways[k].of != ALL || h->largest_leaf >= 500);
        compare(&tree, own, n, wide, many, all, count);
        free(all);
        free(own);
        free(wide);
        rti_free(ctx, chunk, size);
    }
    test_mesh_free(&m);
    rt_context_destroy(ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_wide)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
