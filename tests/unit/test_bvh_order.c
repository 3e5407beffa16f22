/* What a BVH's nodes hold, and in which order: walls that lie apart, and slots as any hits want them. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <math.h>

#include "support/generate.h"

static rt_context *context(uint32_t workers)
{
    rt_context_desc d = rt_context_desc_default();
    rt_context *ctx;
    d.workers = workers;
    assert_int_equal(rt_context_create(&d, &ctx), RT_OK);
    return ctx;
}

static void add_wall(test_mesh *m, float x, float side)
{
    const float a[3] = {x, -side, -side}, b[3] = {x, side, -side}, c[3] = {x, side, side}, d[3] = {x, -side, side};
    test_mesh_add(m, a, b, c);
    test_mesh_add(m, a, c, d);
}

/* In which slot of its node primitive `prim` is a leaf with one other; RTK_BVH_WIDTH: nowhere. */
static uint32_t slot_of_pair(const rtk_tree *t, uint32_t nodes, uint32_t prim)
{
    for (uint32_t n = 0; n < nodes; n++) {
        const rtk_bvhnode *node = &t->bvh[n];
        for (uint32_t i = 0; i < RTK_BVH_WIDTH; i++) {
            const uint32_t first = node->child[i];
            if (node->count[i] == 2 && (t->refs[first] == prim || t->refs[first + 1] == prim))
                return i;
        }
    }
    return RTK_BVH_WIDTH;
}

/* A room's walls that face each other are leaves of their own, not one that every ray meets, and rays that ask for any hit come
 * to them before they come to what is fine, whose boxes are larger. */
static void test_walls(void **state)
{
    rt_context *ctx = context(1);
    test_mesh m = {0};
    void *chunk;
    size_t size;
    (void)state;
    test_mesh_globe(&m, 60);
    const uint32_t first = m.count;
    add_wall(&m, -1.5f, 0.7f);
    add_wall(&m, 1.5f, 0.7f);
    const rti_build_input in = test_input(&m);
    assert_int_equal(rti_tree_build(ctx, &in, &(rti_build_settings){.builder = RTI_BUILD_BVH}, NULL, &chunk, &size), RT_OK);
    const rtk_tree t = rti_tree_view(chunk);
    for (uint32_t i = 0; i < 2; i++)
        assert_int_equal(slot_of_pair(&t, ((rtk_tree_header *)chunk)->node_count, first + 2 * i), 0);
    rti_free(ctx, chunk, size);
    test_mesh_free(&m);
    rt_context_destroy(ctx);
}

typedef struct below {
    double surface, cost;
} below;

/* What is below a node, found here in doubles; its slots must stand in the order of surface by cost. */
static below check_order(const rtk_tree *t, const rtk_tri *tris, uint32_t at)
{
    const rtk_bvhnode *n = &t->bvh[at];
    below all = {0.0, 0.0};
    double last = 1e300;
    for (uint32_t i = 0; i < RTK_BVH_WIDTH && n->child[i] + n->count[i] > 0; i++) {
        double d[3];
        for (int a = 0; a < 3; a++)
            d[a] = (double)n->box[a][1][i] - n->box[a][0][i];
        const double area = d[0] * d[1] + d[1] * d[2] + d[2] * d[0];
        below b = {0.0, area * ((n->count[i] + 3) / 4)};
        if (n->count[i] == 0) {
            b = check_order(t, tris, n->child[i]);
            b.cost += area;
        }
        for (uint32_t k = 0; k < n->count[i]; k++) {
            const rtk_tri *tri = &tris[t->refs[n->child[i] + k]];
            double e[3], f[3];
            for (int a = 0; a < 3; a++) {
                e[a] = (double)tri->v1[a] - tri->v0[a];
                f[a] = (double)tri->v2[a] - tri->v0[a];
            }
            const double x = e[1] * f[2] - e[2] * f[1], y = e[2] * f[0] - e[0] * f[2], z = e[0] * f[1] - e[1] * f[0];
            b.surface += 0.5 * sqrt(x * x + y * y + z * z);
        }
        assert_true(b.surface / b.cost <= last * (1.0 + 1e-3) + 1e-9);
        last = b.surface / b.cost;
        all.surface += b.surface;
        all.cost += b.cost;
    }
    return all;
}

static void test_order(void **state)
{
    static const uint32_t kinds[] = {RTI_BUILD_BVH, RTI_BUILD_BVH_SPATIAL};
    rt_context *ctx = context(2);
    test_mesh m = {0};
    (void)state;
    test_mesh_globe(&m, 60);
    test_mesh_soup(&m, 3000, 0.3f, 8);
    test_mesh_slivers(&m, 500);
    add_wall(&m, -1.5f, 0.7f);
    const rti_build_input in = test_input(&m);
    for (uint32_t i = 0; i < 2; i++) {
        void *chunk;
        size_t size;
        assert_int_equal(rti_tree_build(ctx, &in, &(rti_build_settings){.builder = kinds[i]}, NULL, &chunk, &size), RT_OK);
        const rtk_tree t = rti_tree_view(chunk);
        check_order(&t, m.tris, 0);
        rti_free(ctx, chunk, size);
    }
    test_mesh_free(&m);
    rt_context_destroy(ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_walls), cmocka_unit_test(test_order)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
