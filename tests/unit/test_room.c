/* The memory that calls of many rays work in: had once and kept, given back when asked for or at the end, done without where
 * there is none, and never at the cost of what else a context keeps. */
#include "../support/many.h"
#include "scene_kit.h"

#include <pthread.h>

#include "librt/render.h"
#include "librt/trace.h"
#include "base/base.h"

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
    for (int i = 0; i < (TEST_SANITIZED ? 60 : 200); i++) {
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

static rt_image *picture(rt_context *ctx, uint32_t width)
{
    rt_image *image = NULL;
    kit_ok(ctx, rt_image_create(ctx, width, 256, &image));
    for (uint32_t i = 0; i < width * 256 * 4; i++)
        assert_true(rt_image_pixels(image)[i] == 0.0f);
    memset(rt_image_pixels(image), 0xff, (size_t)width * 256 * 16);
    return image;
}

/* Pixels of one picture are kept, and cleared for the next one of that size; of another size, or small, they are not. */
static void test_pictures(void **state)
{
    kit_memory memory = {0};
    rt_context *ctx = kit_context(&memory, 4);
    rt_image *a = picture(ctx, 1000), *b = picture(ctx, 1000);
    const float *pixels = rt_image_pixels(a);
    uint64_t none, kept, now;
    (void)state;
    rt_image_destroy(a);
    rt_image_destroy(b);
    rt_context_memory(ctx, &kept, NULL);
    a = picture(ctx, 1000);
    assert_ptr_equal(rt_image_pixels(a), pixels);
    b = picture(ctx, 100);
    rt_image_destroy(b); /* less than a megabyte */
    rt_image_destroy(a);
    rt_context_memory(ctx, &now, NULL);
    assert_int_equal(now, kept);
    rt_image_destroy(picture(ctx, 1001));
    rt_context_memory(ctx, &now, NULL);
    assert_int_equal(now, kept + 256 * 16);
    rt_context_drop_kept(ctx);
    rt_context_memory(ctx, &none, NULL);
    assert_true(none + 1000 * 256 * 16 < kept);
    rt_context_destroy(ctx);
    assert_int_equal(memory.bytes, 0);
}

static rt_context *on_machine;
static uint64_t machine;
static uint64_t machine_free(void)
{
    uint64_t now;
    rt_context_memory(on_machine, &now, NULL);
    return machine - now;
}

/* Where the machine has little memory free, what is kept is given up before anything is refused. */
static void test_machine(void **state)
{
    const uint64_t mib = (uint64_t)1 << 20;
    rt_context *ctx = on_machine = kit_context(NULL, 1);
    uint64_t kept, now;
    (void)state;
    rt_image_destroy(picture(ctx, 1000)); /* 3.9 MiB */
    rt_context_memory(ctx, &kept, NULL);
    machine = kept + mib;
    assert_int_equal(rti_context_spare(ctx, mib, machine_free), mib);
    rt_context_memory(ctx, &now, NULL);
    assert_int_equal(now, kept);
    assert_true(rti_context_spare(ctx, 4 * mib, machine_free) >= 4 * mib);
    rt_context_memory(ctx, &now, NULL);
    assert_true(now + 3 * mib < kept);
    assert_int_equal(rti_context_spare(ctx, 6 * mib, machine_free), machine - now);
    rt_context_destroy(ctx);
}

/* Workers' memory is kept for the next render with as many rays: that of as many workers as the context has. */
static void test_workers(void **state)
{
    kit_memory memory = {0};
    rt_context *ctx = kit_context(&memory, 3);
    rt_scene *scene = scatter(ctx, 5);
    rt_render_desc d = rt_render_desc_default();
    rt_image *image, *first = NULL;
    uint64_t before, one, three, now;
    (void)state;
    d.width = d.height = 64;
    d.workers = 3;
    kit_ok(ctx, rt_render(scene, &d, &first)); /* makes the context's threads, too */
    rt_context_memory(ctx, &three, NULL);
    for (uint32_t workers = 1; workers <= 17; workers += 4) {
        d.workers = workers;
        kit_ok(ctx, rt_render(scene, &d, &image));
        assert_memory_equal(rt_image_pixels(first), rt_image_pixels(image), 64 * 64 * 16);
        rt_image_destroy(image);
        rt_context_memory(ctx, &now, NULL);
        assert_int_equal(now, three);
    }
    rt_context_drop_kept(ctx);
    rt_context_memory(ctx, &before, NULL);
    d.workers = 1;
    kit_ok(ctx, rt_render(scene, &d, &image));
    rt_image_destroy(image);
    rt_context_memory(ctx, &one, NULL);
    assert_true(one > before);
    assert_int_equal(three - before, 3 * (one - before));
    rt_image_destroy(first);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
    assert_int_equal(memory.bytes, 0);
}

/* A context that may take `limit` bytes renders, lets go of its scene, and makes a picture of `bytes`. What it holds before that;
 * *again: trees it then need not build again for the same scene. */
static uint64_t pressed(uint64_t limit, uint32_t bytes, uint64_t *again)
{
    rt_context_desc cd = rt_context_desc_default();
    rt_render_desc d = rt_render_desc_default();
    rt_context *ctx = NULL;
    rt_image *image = NULL;
    uint64_t held;
    cd.workers = 1;
    cd.memory_limit = limit;
    assert_int_equal(rt_context_create(&cd, &ctx), RT_OK);
    rt_scene *scene = scatter(ctx, 6);
    d.width = d.height = 64;
    kit_ok(ctx, rt_render(scene, &d, &image));
    rt_image_destroy(image);
    rt_scene_destroy(scene);
    rt_context_memory(ctx, &held, NULL);
    kit_ok(ctx, rt_image_create(ctx, bytes / 16, 1, &image));
    rt_image_destroy(image);
    scene = scatter(ctx, 6);
    *again = rt_context_work(ctx).trees_kept;
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
    return held;
}

/* Where memory is short, that of workers goes first, and a tree that would have to be built again only when that is not enough.
 */
static void test_order(void **state)
{
    uint64_t again, held;
    (void)state;
    held = pressed(0, 16, &again);
    assert_int_equal(again, 1);
    assert_int_equal(pressed(held + (256 << 10), 512 << 10, &again), held);
    assert_int_equal(again, 1);
    pressed(held + (256 << 10), (uint32_t)held + (248 << 10), &again);
    assert_int_equal(again, 0);
}

static uint64_t memory_behind(rt_scene *scene, const rt_render_desc *d)
{
    rt_context *ctx = rt_scene_context(scene);
    rt_image *image = NULL;
    uint64_t now;
    kit_ok(ctx, rt_render(scene, d, &image));
    rt_image_destroy(image);
    rt_context_memory(ctx, &now, NULL);
    return now;
}

/* What a render's workers leave serves one that takes less, unless memory is limited. */
static void test_smaller(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = scatter(ctx, 3);
    rt_render_desc d = rt_render_desc_default();
    uint64_t large, small;
    (void)state;
    d.width = 300;
    d.height = 200;
    d.samples = d.workers = 1;
    d.tile = 16;
    d.integrator = "whitted";
    small = memory_behind(scene, &d);
    d.integrator = "path";
    large = memory_behind(scene, &d);
    assert_true(large > small + (1 << 20));
    d.integrator = "whitted";
    assert_int_equal(memory_behind(scene, &d), large);
    d.tile = 8;
    assert_int_equal(memory_behind(scene, &d), large);
    d.memory_limit = rt_render_memory(scene, &d);
    assert_true(memory_behind(scene, &d) + (1 << 20) < large);
    d.memory_limit = 0;
    d.tile = 16;
    d.integrator = "path";
    assert_int_equal(memory_behind(scene, &d), large);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_smaller),  cmocka_unit_test(test_without),
                                       cmocka_unit_test(test_kept),     cmocka_unit_test(test_dropped),
                                       cmocka_unit_test(test_pictures), cmocka_unit_test(test_workers),
                                       cmocka_unit_test(test_machine),  cmocka_unit_test(test_order)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
