/* The memory that calls of many rays work in: had once and kept, given back when asked for or at the end, done without where
 * there is none, and never at the cost of what else a context keeps. */
#include "scene_kit.h"

#include <pthread.h>

#include "librt/trace.h"

enum { TRIANGLES = 600, RAYS = 500 };

/* A scene of triangles anywhere, committed. */
static rt_scene *scatter(rt_context *ctx, uint32_t seed)
{
    rt_scene *scene = NULL;
    rt_mesh_desc m = rt_mesh_desc_default();
    rt_geometry g;
    float p[9 * TRIANGLES];
    uint32_t index[3 * TRIANGLES];
    kit_ok(ctx, rt_scene_create(ctx, &scene));
    for (int i = 0; i < 9 * TRIANGLES; i++) {
        seed = seed * 1664525u + 1013904223u;
        p[i] = (float)(seed >> 8) * 0x1p-24f * (i % 9 < 3 ? 1.0f : 0.2f) + (i % 9 < 3 ? 0.0f : p[i - i % 9 + i % 3]);
    }
    for (uint32_t i = 0; i < 3 * TRIANGLES; i++)
        index[i] = i;
    m.positions = p;
    m.vertex_count = 3 * TRIANGLES;
    m.indices = index;
    m.triangle_count = TRIANGLES;
    kit_ok(ctx, rt_scene_add_mesh(scene, &m, &g));
    kit_commit(scene);
    return scene;
}

static void aim(rt_ray rays[RAYS])
{
    uint32_t seed = 7;
    for (int i = 0; i < RAYS; i++) {
        float x[6];
        for (int k = 0; k < 6; k++) {
            seed = seed * 1664525u + 1013904223u;
            x[k] = (float)(seed >> 8) * 0x1p-24f;
        }
        rays[i] = (rt_ray){.org = {x[0], x[1], x[2]}, .dir = {x[3] - 0.5f, x[4] - 0.5f, x[5] - 0.5f}, .tmax = 1e30f, .mask = 1u};
    }
}

static void test_without(void **state)
{
    kit_memory memory = {0};
    rt_context *ctx = kit_context(&memory, 1);
    rt_scene *kept = scatter(ctx, 1), *scene;
    rt_ray rays[RAYS];
    rt_hit one[RAYS], all[RAYS];
    uint8_t dark[RAYS];
    uint64_t before, after;
    int hits = 0;
    (void)state;
    rt_scene_destroy(kept); /* its tree is kept */
    scene = scatter(ctx, 2);
    aim(rays);
    for (int i = 0; i < RAYS; i++) {
        rt_scene_intersect(scene, &rays[i], &one[i], 1);
        hits += one[i].prim_id != RT_INVALID_ID;
    }
    assert_in_range(hits, RAYS / 10, RAYS);
    rt_context_memory(ctx, &before, NULL);
    for (int turn = 0; turn < 2; turn++) {
        atomic_store(&memory.fail_at, turn == 0 ? atomic_load(&memory.requests) + 1 : 0);
        memset(all, 0x55, sizeof all);
        rt_scene_intersect(scene, rays, all, RAYS);
        rt_scene_occluded(scene, rays, dark, RAYS);
        assert_memory_equal(one, all, sizeof all);
        for (int i = 0; i < RAYS; i++)
            assert_int_equal(dark[i], one[i].prim_id != RT_INVALID_ID);
        rt_context_memory(ctx, &after, NULL);
        if (turn == 0)
            assert_int_equal(after, before);
        else
            assert_true(after > before);
    }
    const uint64_t found = rt_context_work(ctx).trees_kept;
    kept = scatter(ctx, 1);
    assert_int_equal(rt_context_work(ctx).trees_kept, found + 1);
    rt_scene_destroy(kept);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
    assert_int_equal(memory.bytes, 0);
    assert_int_equal(memory.blocks, 0);
}

static void test_kept(void **state)
{
    kit_memory memory = {0};
    rt_context *ctx = kit_context(&memory, 1);
    rt_scene *scene = scatter(ctx, 3);
    rt_ray rays[RAYS];
    rt_hit hits[RAYS];
    (void)state;
    aim(rays);
    const long requests = memory.requests, bytes = memory.bytes;
    rt_scene_intersect(scene, rays, hits, 8); /* few rays take none */
    assert_int_equal(memory.requests, requests);
    for (int i = 0; i < 3; i++) {
        rt_scene_intersect(scene, rays, hits, RAYS);
        assert_int_equal(memory.requests, requests + 1);
    }
    assert_true(memory.bytes > bytes);
    rt_context_drop_kept(ctx);
    assert_true(memory.bytes <= bytes);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
    assert_int_equal(memory.bytes, 0);
}

static void *drop_often(void *context)
{
    for (int i = 0; i < 50; i++)
        rt_context_drop_kept(context);
    return NULL;
}

/* A context's first room is given back while another thread lets go of what is kept: the allocator is told sizes as they are. */
static void test_dropped(void **state)
{
    rt_ray rays[RAYS];
    (void)state;
    aim(rays);
    for (int i = 0; i < 200; i++) {
        kit_memory memory = {0};
        rt_context *ctx = kit_context(&memory, 1);
        rt_scene *scene = scatter(ctx, 4);
        rt_hit hits[RAYS];
        pthread_t thread;
        uint64_t before, after;
        rt_context_memory(ctx, &before, NULL);
        const uint64_t uncounted = (uint64_t)memory.bytes - before; /* the context itself */
        assert_int_equal(pthread_create(&thread, NULL, drop_often, ctx), 0);
        for (int k = 0; k < 4; k++)
            rt_scene_intersect(scene, rays, hits, 40);
        pthread_join(thread, NULL);
        rt_context_drop_kept(ctx);
        rt_context_memory(ctx, &after, NULL);
        assert_int_equal(after + uncounted, memory.bytes);
        rt_scene_destroy(scene);
        rt_context_destroy(ctx);
        assert_int_equal(memory.bytes, 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_without), cmocka_unit_test(test_kept),
                                       cmocka_unit_test(test_dropped)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
