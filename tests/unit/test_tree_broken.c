/* Chunks of trees with flipped bits: refused, or harmless to every way of every tracer. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/generate.h"
#include "support/rays.h"

/* Rays through a tree that the check let pass, each way that the tracer has: nothing may be read outside it (address sanitizer).
 */
static void walk(const rtk_scene *s, const test_targets *t, const char *tracer)
{
    static rtk_trace_block rays[4];
    static rtk_hit_block hits[4];
    test_rng rng = {1};
    const rti_tracer *tr = rti_tracer_find(test_isa(), tracer);
    uint16_t occluded[4];
    for (uint32_t i = 0; i < 64; i++) {
        rtk_ray r = test_ray(t, &rng, (int)(i % TEST_RAY_KINDS));
        uint32_t b = i / 16, k = i % 16;
        rays[b].ox[k] = r.org.x;
        rays[b].oy[k] = r.org.y;
        rays[b].oz[k] = r.org.z;
        rays[b].dx[k] = r.dir.x;
        rays[b].dy[k] = r.dir.y;
        rays[b].dz[k] = r.dir.z;
        rays[b].tmin[k] = 0.0f;
        rays[b].tmax[k] = INFINITY;
        rays[b].mask[k] = 0xffffffffu;
    }
    for (int way = 0; way < 3; way++) {
        rti_scratch scratch = {.room = test_room(), .turns = way == 1};
        tr->intersect(s, rays, hits, 64, way == 2 ? RTI_TRACE_COHERENT : 0, &scratch);
        tr->occluded(s, rays, occluded, 64, way == 2 ? RTI_TRACE_COHERENT : 0, &scratch);
    }
    tr->intersect(s, rays, hits, 64, RTI_TRACE_STEPS, &(rti_scratch){0});
}

static void test_broken(void **state)
{
    rt_context_desc d = rt_context_desc_default();
    rt_context *ctx;
    test_mesh m = {0};
    test_world w;
    test_targets t;
    test_rng rng = {123};
    (void)state;
    d.workers = 1;
    assert_int_equal(rt_context_create(&d, &ctx), RT_OK);
    test_mesh_soup(&m, 200, 0.2f, 42);
    test_world_init(&w, ctx);
    test_world_mesh(&w, 0, &m, 0xffffffffu); /* of each hit that counts: what the quickest ways are for */
    assert_int_equal(test_world_commit(&w, NULL), RT_OK);
    test_targets_init(&t, &w);
    for (int which = 0; which < TEST_TREES; which++) {
        size_t size = w.parts[0].sizes[which], refused = 0;
        unsigned char *copy = aligned_alloc(64, (size + 63) / 64 * 64);
        assert_false(rti_tree_valid(w.parts[0].chunks[which], 10, m.count));
        assert_false(rti_tree_valid(w.parts[0].chunks[which], size - 1, m.count));
        assert_false(rti_tree_valid(w.parts[0].chunks[which], size, m.count - 1));
        for (int k = 0; k < 20000; k++) {
            memcpy(copy, w.parts[0].chunks[which], size);
            for (uint32_t flips = 1 + test_u32(&rng) % 3; flips > 0; flips--)
                copy[test_u32(&rng) % (k % 4 == 0 ? sizeof(rtk_tree_header) : size)] ^= (unsigned char)(1u << test_u32(&rng) % 8);
            if (!rti_tree_valid(copy, size, m.count)) {
                refused++;
                continue;
            }
            rtk_tree view = rti_tree_view(copy);
            if (k % 16 != 0 && k % 16 != 3)
                continue;
            rtk_part *g = &w.groups[0].parts[0];
            rtk_tree *slot = view.kind == RTK_TREE_KD ? &g->kdtree : (view.kind == RTK_TREE_BVH ? &g->bvh : &g->octree);
            rtk_tree keep = *slot;
            *slot = view;
            test_world_changed(&w);
            walk(&w.scene, &t, rti_tree_kind_of(view.kind)->name);
            *slot = keep;
        }
        assert_true(refused > 1000);
        free(copy);
    }
    test_targets_free(&t);
    test_world_free(&w);
    test_mesh_free(&m);
    rt_context_destroy(ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_broken)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
