/* The queues hold what they promise: the bound of the stack under every kind of branching, every ray shaded once, every tile
 * ended once. The scene is made up: each ray's key says how many children it has. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "render/image.h"
#include "render/wavefront.h"
#include "wave_push.h"

typedef struct bed {
    rti_frame frame;
    rtk_world world;
    rtk_scene scene;
    rti_cancel cancel;
    rt_context *ctx;
    rti_worker worker;
    void *memory;
    uint32_t next, ended, deepest;
    uint8_t *tiles;
    uint32_t most_waiting;
    uint64_t shaded;
} bed;

static bed *current;

static void all_miss(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits, uint32_t count, uint32_t flags,
                     rti_scratch *scratch)
{
    (void)scene, (void)rays, (void)hits, (void)flags;
    scratch->stats.rays += count;
}

static void none_occluded(const rtk_scene *scene, const rtk_trace_block *rays, uint16_t *occluded, uint32_t count, uint32_t flags,
                          rti_scratch *scratch)
{
    (void)scene, (void)rays, (void)flags, (void)scratch;
    memset(occluded, 0, (count + 15) / 16 * sizeof *occluded);
}

/* How many rays the ray with this key becomes: told by the depth's digit of a script. */
static uint32_t always_two(uint32_t key, uint32_t depth)
{
    return (void)key, (void)depth, 2;
}
static uint32_t one_and_two(uint32_t key, uint32_t depth)
{
    return (void)depth, 1 + (key & 1);
}
static uint32_t wild(uint32_t key, uint32_t depth)
{
    return (key >> 3) % 16 < 7 + depth % 3 ? 2 : (key & 1);
}
static uint32_t late(uint32_t key, uint32_t depth)
{
    return depth < 3 ? (key % 5 == 0) : 2;
}

static uint32_t (*children)(uint32_t key, uint32_t depth);

static void branch(rti_worker *w, uint32_t first, uint32_t count)
{
    uint32_t before = 0;
    for (uint32_t i = first; i < first + count; i++) {
        rti_ray_state s = rti_batch_state(w, i);
        rtk_key key = {s.key_lo, s.key_hi};
        uint32_t n = s.depth < w->frame->set.desc.max_depth ? children(rtk_hash3(s.pixel, s.sample, s.key_lo), s.depth) : 0;
        assert_true(s.depth >= before); /* a batch is shaded in the order of its depths */
        before = s.depth;
        current->deepest = s.depth > current->deepest ? s.depth : current->deepest;
        current->shaded++;
        rti_add(w, s.home, rtk_v3(1.0f, (float)s.depth, 0.0f));
        for (uint32_t k = 0; k < n; k++) {
            rti_ray_state c = s;
            rtk_key child = rtk_key_child(key, k);
            c.key_lo = child.lo;
            c.key_hi = child.hi;
            c.depth++;
            c.kind = RTK_KIND_REFLECT;
            assert_true(w->stack.count < w->stack.capacity);
            push(w, rtk_v3(0, 0, 0), rtk_v3(0, 0, 1), 1, &c);
        }
    }
    if (w->stack.count > current->most_waiting)
        current->most_waiting = w->stack.count;
}

static const rti_tracer tracer = {"none", "", RTK_TREE_NONE, 1, all_miss, none_occluded, NULL};
static const rti_integrator brancher = {"branch", "", 0, 2, branch, NULL};

static uint32_t next_tile(void *owner)
{
    bed *b = owner;
    return b->next < b->frame.tile_count ? b->next++ : RTK_INVALID;
}

static void tile_done(void *owner, uint32_t index)
{
    bed *b = owner;
    b->ended++;
    assert_int_equal(b->tiles[index]++, 0);
}

/* Rays that the key's tree has, counted plainly. */
static uint64_t count_tree(uint32_t pixel, uint32_t sample, rtk_key key, uint32_t depth, uint32_t max_depth)
{
    uint64_t n = 1;
    uint32_t c = depth < max_depth ? children(rtk_hash3(pixel, sample, key.lo), depth) : 0;
    for (uint32_t k = 0; k < c; k++)
        n += count_tree(pixel, sample, rtk_key_child(key, k), depth + 1, max_depth);
    return n;
}

static void run(uint32_t width, uint32_t height, uint32_t tile, uint32_t samples, uint32_t depth,
                uint32_t (*rule)(uint32_t key, uint32_t depth))
{
    bed b = {0};
    uint64_t want = 0, got = 0;
    current = &b;
    children = rule;
    assert_int_equal(rt_context_create(NULL, &b.ctx), RT_OK);
    b.world.camera.half_height = 1;
    b.world.camera.front[2] = -1;
    b.world.camera.up[1] = 1;
    b.world.camera.right[0] = 1;
    b.scene.world = &b.world;
    b.frame.set.desc = rt_render_desc_default();
    b.frame.set.desc.width = b.frame.set.desc.crop.width = width;
    b.frame.set.desc.height = b.frame.set.desc.crop.height = height;
    b.frame.set.desc.tile = tile;
    b.frame.set.desc.max_depth = depth;
    b.frame.set.desc.filter_width = 1;
    b.frame.set.samples = samples;
    b.frame.set.integrator = &brancher;
    b.frame.set.tracer = &tracer;
    b.frame.cancel = &b.cancel;
    assert_int_equal(rti_frame_plan(b.ctx, "test", &b.frame, &b.scene), RT_OK);
    assert_int_equal(rt_image_create(b.ctx, width, height, &b.frame.image), RT_OK);
    b.memory = aligned_alloc(64, rti_worker_size(&b.frame));
    b.tiles = calloc(b.frame.tile_count, 1);
    rti_worker_init(&b.worker, &b.frame, b.memory);
    b.worker.next_tile = next_tile;
    b.worker.tile_done = tile_done;
    b.worker.owner = &b;
    while (rti_worker_step(&b.worker))
        assert_true(b.worker.stack.count <= (b.frame.batch + RTK_BLOCK) * (depth + 1));
    assert_int_equal(b.ended, b.frame.tile_count);
    for (uint32_t p = 0; p < width * height; p++) {
        uint64_t in_pixel = 0;
        for (uint32_t s = 0; s < samples; s++)
            in_pixel += count_tree(p, s, rtk_key_root(), 0, depth);
        got += (uint64_t)((double)rti_image_row(b.frame.image, p / width)[4 * (p % width)] * samples + 0.5);
        want += in_pixel;
        if ((uint64_t)((double)rti_image_row(b.frame.image, p / width)[4 * (p % width)] * samples + 0.5) != in_pixel)
            fail_msg("pixel %u", p);
    }
    assert_true(b.shaded == want && got == want);
    assert_true(b.worker.scratch.stats.rays == want);
    assert_true(b.deepest <= depth);
    free(b.memory);
    free(b.tiles);
    rt_image_destroy(b.frame.image);
    rt_context_destroy(b.ctx);
}

static void test_worst_branching_fills_the_bound(void **state)
{
    (void)state;
    run(64, 64, 32, 1, 8, always_two);
    run(100, 50, 16, 2, 5, always_two);
}

static void test_uneven_branching(void **state)
{
    (void)state;
    run(64, 64, 8, 3, 7, one_and_two);
    run(70, 45, 13, 2, 12, wild);
    run(70, 45, 13, 2, 12, late);
}

static void test_small_shapes(void **state)
{
    (void)state;
    run(1, 1, 32, 1, 0, always_two);
    run(1, 1, 1, 5, 10, always_two);
    run(37, 3, 1, 1, 3, wild);
    run(3, 37, 4096, 7, 2, one_and_two);
    run(17, 17, 5, 1, 0, always_two);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_worst_branching_fills_the_bound),
        cmocka_unit_test(test_uneven_branching),
        cmocka_unit_test(test_small_shapes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
