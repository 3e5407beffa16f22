/* The same picture however it is made: workers, tiles, tracers, schedules, the caller's rounding and buffer, parts of it. */
#include "../support/many.h"
#include "render_stage.h"

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

/* step 3: a third of them, in which each two of workers, tile and tracer still meet. */
static void same_for_every_arrangement(const char *integrator, uint32_t samples, size_t step)
{
    static const uint32_t workers[] = {1, 2, 3, 8}, tiles[] = {8, 16, 64};
    static const char *const tracers[] = {"brute", "kdtree", "octree"};
    rt_render_desc d = settings(TEST_SANITIZED ? 35 : 70, TEST_SANITIZED ? 25 : 50, samples, integrator);
    char want[33], got[33];
    hash_of(&d, want);
    for (size_t w = 0; w < 4; w++) {
        for (size_t t = 0; t < 3; t++) {
            for (size_t k = (w + t) % step; k < 3; k += step) {
                d.workers = workers[w];
                d.tile = tiles[t];
                d.tracer = tracers[k];
                d.schedule = (w + t + k) % 2 ? RT_SCHEDULE_STATIC : RT_SCHEDULE_DYNAMIC;
                hash_of(&d, got);
                if (strcmp(want, got) != 0)
                    fail_msg("%s: %u workers, tile %u, %s: %s, not %s", integrator, d.workers, d.tile, d.tracer, got, want);
            }
        }
    }
}

static void test_same_whitted(void **state)
{
    (void)state;
    same_for_every_arrangement("whitted", 1, 1);
}

static void test_same_whitted_many_samples(void **state)
{
    (void)state;
    same_for_every_arrangement("whitted", 5, 3);
}

static void test_same_path(void **state)
{
    (void)state;
    same_for_every_arrangement("path", 4, 3);
}

static void test_same_ao(void **state)
{
    (void)state;
    same_for_every_arrangement("ao", 1, 3);
}

static void test_seed_and_samples_matter(void **state)
{
    rt_render_desc d = settings(40, 30, 2, "whitted");
    char a[33], b[33];
    (void)state;
    hash_of(&d, a);
    d.seed = (uint64_t)1 << 40;
    hash_of(&d, b);
    assert_string_not_equal(a, b);
    d.seed = 0;
    d.samples = 3;
    hash_of(&d, b);
    assert_string_not_equal(a, b);
}

/* A caller with strange rounding and flushed denormals gets the same picture, and its own modes back. */
static void test_callers_float_modes(void **state)
{
#if defined(__SSE2__)
    rt_render_desc d = settings(40, 30, 2, "path");
    unsigned before = _mm_getcsr();
    char a[33], b[33];
    rt_image *image;
    (void)state;
    hash_of(&d, a);
    _mm_setcsr(0xffc0u); /* flush, denormals are zero, towards zero, all masked */
    image = NULL;
    rt_render(scene, &d, &image);
    assert_int_equal(_mm_getcsr() & 0xffc0u, 0xffc0u);
    _mm_setcsr(before);
    assert_non_null(image);
    rt_image_hash(image, b);
    assert_string_equal(a, b);
    rt_image_destroy(image);
#else
    (void)state;
    skip();
#endif
}

static void test_crop_is_a_part_of_the_whole(void **state)
{
    rt_render_desc d = settings(61, 47, 3, "whitted");
    rt_image *whole = render(scene, &d), *part;
    (void)state;
    d.crop.x = 13;
    d.crop.y = 22;
    d.crop.width = 31;
    d.crop.height = 25;
    d.workers = 2;
    d.tile = 8;
    part = render(scene, &d);
    assert_int_equal(rt_image_width(part), 31);
    for (uint32_t y = 0; y < 25; y++)
        assert_memory_equal(pixel(part, 0, y), pixel(whole, 13, 22 + y), 31 * 16);
    rt_image_destroy(whole);
    rt_image_destroy(part);
}

static void test_callers_buffer(void **state)
{
    rt_render_desc d = settings(20, 10, 1, "whitted");
    rt_image *own = render(scene, &d), *lent;
    static float buffer[10 * 100];
    (void)state;
    for (int i = 0; i < 1000; i++)
        buffer[i] = -1.0f;
    d.pixels = buffer;
    d.pixels_stride = 100 * sizeof(float);
    lent = render(scene, &d);
    for (uint32_t y = 0; y < 10; y++) {
        assert_memory_equal(buffer + 100 * y, pixel(own, 0, y), 20 * 16);
        for (int i = 80; i < 100; i++)
            assert_true(buffer[100 * y + (uint32_t)i] == -1.0f);
    }
    assert_ptr_equal(rt_image_pixels(lent), buffer);
    rt_image_destroy(lent);
    d.pixels_stride = 79 * sizeof(float);
    assert_int_equal(rt_render(scene, &d, &lent), RT_ERROR_ARGUMENT);
    rt_image_destroy(own);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_ROOM(test_same_whitted),
        IN_ROOM(test_same_whitted_many_samples),
        IN_ROOM(test_same_path),
        IN_ROOM(test_same_ao),
        IN_ROOM(test_seed_and_samples_matter),
        IN_ROOM(test_callers_float_modes),
        IN_ROOM(test_crop_is_a_part_of_the_whole),
        IN_ROOM(test_callers_buffer),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
