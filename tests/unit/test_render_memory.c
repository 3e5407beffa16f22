/* Memory of a render: allocations that fail, the estimate, images larger than the memory, in bands. */
#include <stdatomic.h>
#include <unistd.h>

#include "../support/many.h"
#include "render_stage.h"

typedef struct meter {
    atomic_ulong calls, fail_at;
} meter;

static void *metered(void *user, void *ptr, size_t old_size, size_t new_size)
{
    meter *m = user;
    (void)old_size;
    if (new_size == 0) {
        free(ptr);
        return NULL;
    }
    if (atomic_fetch_add(&m->calls, 1) + 1 == atomic_load(&m->fail_at))
        return NULL;
    return realloc(ptr, new_size);
}

/* Every allocation of a render fails once; nothing leaks and the next one works. */
static void test_each_allocation_fails(void **state)
{
    static meter m;
    rt_context_desc cd = rt_context_desc_default();
    rt_context *other;
    rt_scene *s;
    rt_render_desc d = settings(40, 30, 1, "path");
    uint64_t before, after;
    unsigned long n = 0;
    rt_status status = RT_ERROR_MEMORY;
    (void)state;
    cd.allocate = metered;
    cd.allocate_user = &m;
    cd.workers = 2;
    OK(rt_context_create(&cd, &other));
    OK(rt_scene_create(other, &s));
    add_everything(s);
    OK(rt_scene_commit(s, NULL));
    rt_context_drop_kept(other);
    for (int workers = 1; workers <= 2; workers++) {
        d.workers = (uint32_t)workers;
        status = RT_ERROR_MEMORY;
        for (n = 1; status != RT_OK; n++) {
            rt_image *image = NULL;
            rt_context_memory(other, &before, NULL);
            atomic_store(&m.calls, 0);
            atomic_store(&m.fail_at, n);
            status = rt_render(s, &d, &image);
            atomic_store(&m.fail_at, 0);
            rt_image_destroy(image);
            rt_context_drop_kept(other); /* else the next render asks for less, and a refused request is tried again without it */
            rt_context_memory(other, &after, NULL);
            assert_int_equal(before, after);
            assert_true(status == RT_OK || status == RT_ERROR_MEMORY);
            assert_true(status == RT_OK || !image);
        }
        assert_true(n > 5);
    }
    rt_scene_destroy(s);
    rt_context_destroy(other);
}

/* The estimate is what a job holds. */
static void test_memory_estimate(void **state)
{
    rt_render_desc d = settings(300, 200, 1, "whitted");
    uint64_t before, now, estimate;
    rt_job *job;
    (void)state;
    estimate = rt_render_memory(scene, &d);
    rt_context_drop_kept(ctx);
    rt_context_memory(ctx, &before, NULL);
    OK(rt_job_start(scene, &d, &job));
    rt_context_memory(ctx, &now, NULL);
    assert_true(now - before <= estimate + 2048 /* alignment of blocks */ && now - before > estimate * 9 / 10);
    rt_job_destroy(job);
    d.memory_limit = estimate;
    rt_image_destroy(render(scene, &d));
}

/* Rays that scatter go in long queues, and where memory is limited in short ones: the picture is the same. */
static void test_short_queues(void **state)
{
    rt_render_desc d = settings(300, 200, 1, "path");
    uint64_t most = rt_render_memory(scene, &d), least;
    rt_image *a = render(scene, &d), *b;
    (void)state;
    d.memory_limit = most - 1;
    least = rt_render_memory(scene, &d);
    assert_true(least + (1 << 20) < most);
    b = render(scene, &d);
    assert_memory_equal(rt_image_pixels(a), rt_image_pixels(b), 300 * 200 * 4 * sizeof(float));
    rt_image_destroy(a);
    rt_image_destroy(b);
    d.memory_limit = least;
    rt_image_destroy(render(scene, &d));
    d.memory_limit = least - 1;
    assert_int_equal(rt_render(scene, &d, &a), RT_ERROR_MEMORY_LIMIT);
}

/* ---- bands ---- */

typedef struct progress {
    uint64_t done;
    uint32_t tiles, again; /* calls with more than before, with the same */
} progress;

/* Tiles of 8 x 8, told one by one. */
static int count_pixels(void *user, uint64_t done, uint64_t total)
{
    progress *p = user;
    assert_int_equal(total, 3500);
    assert_true(done >= p->done && done - p->done <= 64 && done <= total);
    if (done > p->done)
        p->tiles++;
    else
        p->again++;
    p->done = done;
    return 0;
}

/* Nothing is finished yet, and that is told twice. */
static int stop_when_asked_again(void *user, uint64_t done, uint64_t total)
{
    progress *p = user;
    assert_int_equal(done, 0);
    assert_int_equal(total, 4096);
    return ++p->again == 2;
}

static int stop_at_once(void *user, uint64_t done, uint64_t total)
{
    (void)user;
    (void)done;
    (void)total;
    return 1;
}

static void test_bands(void **state)
{
    rt_render_desc d = settings(50, 70, 2, "whitted");
    char path[] = "/tmp/librt_bands_XXXXXX", text[512];
    rt_image *whole = render(scene, &d), *a, *b;
    rt_image_difference diff;
    progress told = {0};
    int file = mkstemp(path);
    rt_save_desc save = rt_save_desc_default();
    (void)state;
    assert_true(file >= 0);
    close(file);
    save.format = "bmp";
    OK(rt_image_save(whole, path, &save));
    OK(rt_image_load(ctx, path, &a));
    d.tile = 8;
    d.workers = 2;
    OK(rt_render_to_file(scene, &d, path, &save, 50 * 16 * 20, count_pixels, &told));
    assert_int_equal(told.done, 3500);
    assert_int_equal(told.tiles, 4 * 2 * 7 + 7); /* in four bands of 16 rows and one of 6 */
    OK(rt_image_load(ctx, path, &b));
    OK(rt_image_compare(a, b, &diff, NULL));
    assert_int_equal(diff.differing_pixels, 0);
    rt_image_destroy(b);
    assert_int_equal(rt_render_to_file(scene, &d, path, &save, 1, stop_at_once, NULL), RT_ERROR_CANCELLED);
    OK(rt_image_load(ctx, path, &b)); /* the old file stands */
    rt_image_destroy(b);
    d.pixels = rt_image_pixels(whole);
    assert_int_equal(rt_render_to_file(scene, &d, path, &save, 0, NULL, NULL), RT_ERROR_ARGUMENT);
    rt_context_error(ctx, text, sizeof text);
    assert_non_null(strstr(text, "pixels"));
    rt_image_destroy(a);
    rt_image_destroy(whole);
    unlink(path);
}

/* A tile that takes minutes is asked for every 50 ms. */
static void test_progress_within_a_tile(void **state)
{
    rt_render_desc d = settings(64, 64, 65536, "path");
    char path[] = "/tmp/librt_bands_XXXXXX", text[512];
    rt_save_desc save = rt_save_desc_default();
    int file = mkstemp(path);
    (void)state;
    assert_true(file >= 0);
    close(file);
    save.format = "bmp";
    d.tile = 64;
    for (uint32_t workers = 1; workers <= 2; workers++) {
        progress told = {0};
        d.workers = workers;
        assert_int_equal(rt_render_to_file(scene, &d, path, &save, 0, stop_when_asked_again, &told), RT_ERROR_CANCELLED);
        assert_int_equal(told.again, 2);
        rt_context_error(ctx, text, sizeof text);
        assert_non_null(strstr(text, "after 0 of 4096 pixels"));
    }
    unlink(path);
}

/* Larger than the memory: 64 MiB of pixels under a limit of 32 MiB. */
static void test_bands_beyond_the_memory(void **state)
{
    rt_context_desc cd = rt_context_desc_default();
    rt_context *small;
    rt_scene *s;
    rt_render_desc d = settings(8192, 512, 1, "depth");
    char path[] = "/tmp/librt_bands_XXXXXX";
    rt_save_desc save = rt_save_desc_default();
    rt_image *image;
    uint64_t peak;
    int file = mkstemp(path);
    (void)state;
    assert_true(file >= 0);
    close(file);
    cd.memory_limit = 32u << 20;
    cd.workers = 1;
    OK(rt_context_create(&cd, &small));
    OK(rt_scene_create(small, &s));
    OK(rt_scene_commit(s, NULL));
    assert_int_equal(rt_render(s, &d, &image), RT_ERROR_MEMORY_LIMIT);
    save.format = "bmp";
    OK(rt_render_to_file(s, &d, path, &save, 8u << 20, NULL, NULL));
    rt_context_memory(small, NULL, &peak);
    assert_true(peak < 24u << 20);
    assert_int_equal(rt_render_to_file(s, &d, path, &save, 64u << 20, NULL, NULL), RT_ERROR_MEMORY_LIMIT);
    rt_scene_destroy(s);
    rt_context_destroy(small);
    unlink(path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_ROOM(test_each_allocation_fails),  IN_ROOM(test_memory_estimate),
        IN_ROOM(test_short_queues),           IN_ROOM(test_bands),
        IN_ROOM(test_progress_within_a_tile), IN_ROOM(test_bands_beyond_the_memory),
    };
#if TEST_RACES
    cmocka_set_skip_filter("test_bands_beyond_the_memory"); /* work of one thread */
#endif
    return cmocka_run_group_tests(tests, NULL, NULL);
}
