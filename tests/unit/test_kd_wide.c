/* The nodes of eight that a kd-tree is folded into. What they are for, test_lists of test_tree.c and test_tracers.c hold. */
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

/* The leaves below a tree's root that are not empty; kind: KD, or BVH for what the cells were folded into. */
static uint32_t leaves_of(const rtk_tree *tree, uint32_t kind, leaf *out)
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
        memcpy(out[n].lo, spot.lo, sizeof spot.lo);
        memcpy(out[n].hi, spot.hi, sizeof spot.hi);
        out[n].first = kind == RTK_TREE_KD ? tree->kd[spot.node].a : spot.node;
        out[n++].count = refs;
    }
    return n;
}

static int by_first(const void *a, const void *b)
{
    const leaf *x = a, *y = b;
    return (x->first > y->first) - (x->first < y->first);
}

/* A kd-tree's nodes of eight hold its leaves, each once, in boxes inside their cells; those over triangles alone in blocks. */
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
    for (int i = 0; i < BOXES; i++)
        for (int a = 0; a < 3; a++) {
            boxes[i][a] = test_range(&r, -1, 1);
            boxes[i][3 + a] = boxes[i][a] + 0.1f;
        }
    for (int k = 0; k < 5; k++) { /* of triangles by each builder, with boxes, of these alone, of one triangle */
        rti_build_input in = k < 3 ? test_input(&m) : test_input_boxes(&m, (const float(*)[6])boxes, BOXES);
        rti_build_settings s = k == 2 ? rti_build_preset_find("paper")->settings
                                      : (rti_build_settings){.builder = k == 1 ? RTI_BUILD_KD_BINNED : RTI_BUILD_KD_EXACT};
        void *chunk;
        size_t size;
        if (k == 4)
            in.tri_count = 1;
        in.box_count = k == 4 ? 0 : in.box_count;
        assert_int_equal(rti_tree_build(ctx, &in, &s, NULL, &chunk, &size), RT_OK);
        const rtk_tree_header *h = chunk;
        rtk_tree tree = rti_tree_view(chunk);
        leaf *kd = malloc(h->leaf_count * sizeof *kd), *wide = malloc(h->leaf_count * sizeof *wide);
        uint32_t n = leaves_of(&tree, RTK_TREE_KD, kd), plain = 0;
        assert_int_equal(n, h->leaf_count - h->empty_leaf_count);
        assert_int_equal(n, leaves_of(&tree, RTK_TREE_BVH, wide));
        qsort(kd, n, sizeof *kd, by_first);
        qsort(wide, n, sizeof *wide, by_first);
        for (uint32_t i = 0; i < n; i++) {
            bool other = false;
            assert_true(kd[i].first == wide[i].first && kd[i].count == wide[i].count);
            for (int a = 0; a < 3; a++)
                assert_true(kd[i].lo[a] <= wide[i].lo[a] && wide[i].lo[a] <= wide[i].hi[a] && wide[i].hi[a] <= kd[i].hi[a]);
            for (uint32_t j = 0; j < kd[i].count; j++)
                other |= tree.refs[kd[i].first + j] >= in.tri_count;
            assert_int_equal(other, kd[i].first >= RTK_BVH_BLOCK * tree.block_count);
            plain += other;
        }
        assert_int_equal(plain > 0, k == 3);
        free(kd);
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
