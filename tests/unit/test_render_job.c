/* Jobs: the same picture however it is made, tiles, cancelling, the caller's buffer, memory. */
#include <float.h>
#include <stdatomic.h>
#include <unistd.h>

#include "render_scenes.h"

#include "base/base.h"
#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

static rt_context *ctx;
static rt_scene *scene;

static int setup(void **state)
{
    (void)state;
    ctx = make_context(2);
    OK(rt_scene_create(ctx, &scene));
    add_everything(scene);
    OK(rt_scene_commit(scene, NULL));
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
    return 0;
}

static void hash_of(const rt_render_desc *d, char text[33])
{
    rt_image *image = render(scene, d);
    rt_image_hash(image, text);
    rt_image_destroy(image);
}

/* ---- the same picture ---- */

/* step 3: a third of them, in which each two of workers, tile and tracer still meet. */
static void same_for_every_arrangement(const char *integrator, uint32_t samples, size_t step)
{
    static const uint32_t workers[] = {1, 2, 3, 8}, tiles[] = {8, 16, 64};
    static const char *const tracers[] = {"brute", "kdtree", "octree"};
    rt_render_desc d = settings(70, 50, samples, integrator);
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

/* ---- jobs ---- */

typedef struct seen {
    uint8_t pixels[100 * 80];
    uint32_t tiles;
    int stop_at;
} seen;

static int on_tile(void *user, const rt_tile *t, const rt_image *image)
{
    seen *s = user;
    assert_non_null(image);
    for (uint32_t y = t->y; y < t->y + t->height; y++) {
        for (uint32_t x = t->x; x < t->x + t->width; x++) {
            s->pixels[100 * y + x]++;
            assert_true(pixel(image, x, y)[0] + pixel(image, x, y)[3] > 0.0f); /* sky shines, bodies cover */
        }
    }
    return (int)++s->tiles == s->stop_at;
}

static void every_tile_once(uint32_t workers, rt_schedule schedule)
{
    rt_render_desc d = settings(100, 80, 1, "whitted");
    static seen s;
    rt_render_stats stats;
    rt_worker_stats per[8];
    rt_job *job;
    float progress;
    rt_image *image;
    uint64_t rays = 0;
    uint32_t tiles = 0;
    memset(&s, 0, sizeof s);
    d.workers = workers;
    d.tile = 16;
    d.schedule = schedule;
    OK(rt_job_start(scene, &d, &job));
    rt_job_on_tile(job, on_tile, &s);
    assert_int_equal(rt_job_wait(job, -1), RT_JOB_DONE);
    for (int i = 0; i < 8000; i++)
        assert_int_equal(s.pixels[i], 1);
    assert_int_equal(rt_job_poll(job, &progress), RT_JOB_DONE);
    assert_true(progress == 1.0f);
    rt_job_stats(job, &stats);
    assert_int_equal(stats.tiles, 35);
    assert_int_equal(stats.tiles_done, 35);
    assert_int_equal(stats.rays_camera, 8000);
    assert_true(stats.rays_shadow > 8000 && stats.rays_reflect > 100 && stats.rays_refract > 100);
    assert_int_equal(stats.rays_diffuse + stats.rays_ao + stats.clamped + stats.dropped, 0);
    assert_int_equal(rt_job_worker_stats(job, per, 8), workers);
    for (uint32_t i = 0; i < workers; i++) {
        rays += per[i].rays;
        tiles += per[i].tiles;
        assert_true(per[i].busy_seconds >= 0 && per[i].cpu_seconds >= 0);
        if (schedule == RT_SCHEDULE_STATIC)
            assert_int_equal(per[i].tiles, 35 / workers + (i < 35 % workers));
    }
    assert_int_equal(rays, stats.rays_camera + stats.rays_shadow + stats.rays_reflect + stats.rays_refract);
    assert_int_equal(tiles, 35);
    image = rt_job_take_image(job);
    assert_non_null(image);
    assert_null(rt_job_take_image(job));
    rt_job_destroy(job);
    rt_image_destroy(image);
}

static void test_every_tile_once(void **state)
{
    (void)state;
    every_tile_once(1, RT_SCHEDULE_DYNAMIC);
    every_tile_once(2, RT_SCHEDULE_DYNAMIC);
    every_tile_once(3, RT_SCHEDULE_STATIC);
    every_tile_once(1, RT_SCHEDULE_STATIC);
}

static void test_polling(void **state)
{
    rt_render_desc d = settings(100, 80, 4, "path");
    rt_job *job;
    rt_tile t;
    uint32_t pixels = 0;
    float before = 0, now;
    (void)state;
    for (uint32_t workers = 1; workers <= 2; workers++) {
        d.workers = workers;
        OK(rt_job_start(scene, &d, &job));
        while (rt_job_poll(job, &now) == RT_JOB_RUNNING) {
            assert_true(now >= before);
            before = now;
            while (rt_job_next_tile(job, &t))
                pixels += t.width * t.height;
        }
        while (rt_job_next_tile(job, &t))
            pixels += t.width * t.height;
        assert_int_equal(pixels, 8000 * workers);
        assert_int_equal(rt_job_status(job), RT_OK);
        rt_job_destroy(job);
        before = 0;
    }
}

static void test_wait_with_a_limit(void **state)
{
    rt_render_desc d = settings(400, 300, 64, "path");
    rt_job *job;
    (void)state;
    for (uint32_t workers = 1; workers <= 2; workers++) {
        double start = rti_now();
        d.workers = workers;
        OK(rt_job_start(scene, &d, &job));
        assert_int_equal(rt_job_wait(job, 0.05), RT_JOB_RUNNING);
        assert_true(rti_now() - start < 2.0);
        assert_null(rt_job_take_image(job));
        assert_non_null(rt_job_image(job));
        rt_job_destroy(job);
    }
}

static void test_cancel(void **state)
{
    rt_render_desc d = settings(2000, 2000, 1000, "path");
    double worst = 0;
    (void)state;
    for (uint32_t workers = 1; workers <= 2; workers++) {
        rt_job *job;
        double start;
        rt_image *image;
        d.workers = workers;
        OK(rt_job_start(scene, &d, &job));
        rt_job_wait(job, 0.05);
        start = rti_now();
        rt_job_cancel(job);
        assert_int_equal(rt_job_wait(job, -1), RT_JOB_CANCELLED);
        worst = rti_now() - start > worst ? rti_now() - start : worst;
        assert_int_equal(rt_job_status(job), RT_ERROR_CANCELLED);
        image = rt_job_take_image(job);
        assert_non_null(image); /* what was finished */
        rt_image_destroy(image);
        rt_job_destroy(job);
    }
    print_message("cancelled after at most %.1f ms\n", 1e3 * worst);
    assert_true(worst < 1.0); /* 0.1 is promised; other programs may hold the CPUs */
}

static double cancel_latency(rt_scene *s, const rt_render_desc *d, double after)
{
    rt_job *job;
    double start;
    OK(rt_job_start(s, d, &job));
    rti_sleep(after);
    start = rti_now();
    rt_job_cancel(job);
    assert_int_equal(rt_job_wait(job, -1), RT_JOB_CANCELLED);
    start = rti_now() - start;
    rt_job_destroy(job);
    return start;
}

/* A job whose tracer wants a tree that is not there builds it first; that can be cancelled too. So can steps with ten thousand
 * lights. */
static void test_cancel_while_busy(void **state)
{
    enum { N = 400000 };
    rt_render_desc d = settings(500, 500, 64, "whitted");
    rt_commit_desc c = rt_commit_desc_default();
    rt_mesh_desc m = rt_mesh_desc_default();
    float *p = malloc(9 * N * sizeof *p);
    uint32_t *index = malloc(3 * N * sizeof *index);
    rt_scene *s;
    double building, shining;
    (void)state;
    for (uint32_t i = 0; i < 9 * N; i++)
        p[i] = (float)(i * 2654435761u >> 8) / 16777216.0f + (float)(i / 9 % 97);
    for (uint32_t i = 0; i < 3 * N; i++)
        index[i] = i;
    OK(rt_scene_create(ctx, &s));
    m.positions = p;
    m.indices = index;
    m.vertex_count = 3 * N;
    m.triangle_count = N;
    OK(rt_scene_add_mesh(s, &m, NULL));
    c.accel = "brute";
    OK(rt_scene_commit(s, &c));
    free(p);
    free(index);
    d.workers = 2;
    d.tracer = "kdtree";
    building = cancel_latency(s, &d, 0.05);
    rt_scene_destroy(s);
    OK(rt_scene_create(ctx, &s));
    add_everything(s);
    for (int i = 0; i < 10000; i++)
        add_light(s, light(RT_LIGHT_DIRECTIONAL, v3(0, -1, 0), v3(1e-4f, 2e-4f, 1e-4f), RT_FALLOFF_NONE));
    OK(rt_scene_commit(s, NULL));
    d.tracer = "auto";
    shining = cancel_latency(s, &d, 0.05);
    rt_scene_destroy(s);
    print_message("cancelled while building after %.1f ms, amid ten thousand lights after %.1f ms\n", 1e3 * building,
                  1e3 * shining);
    assert_true(building < 1.0 && shining < 1.0); /* 0.1 is promised; other programs may hold the CPUs */
}

static void test_cancel_by_callback(void **state)
{
    rt_render_desc d = settings(100, 80, 16, "path");
    static seen s;
    rt_job *job;
    (void)state;
    for (uint32_t workers = 1; workers <= 2; workers++) {
        memset(&s, 0, sizeof s);
        s.stop_at = 1;
        d.tile = 8;
        d.workers = workers;
        OK(rt_job_start(scene, &d, &job));
        rt_job_on_tile(job, on_tile, &s);
        assert_int_equal(rt_job_wait(job, -1), RT_JOB_CANCELLED);
        rt_job_destroy(job);
    }
}

/* A job keeps what it began with. */
static void test_scene_may_change_beside_a_job(void **state)
{
    rt_render_desc d = settings(60, 40, 8, "path");
    rt_job *job;
    rt_image *image;
    char want[33], got[33];
    (void)state;
    hash_of(&d, want);
    d.workers = 2;
    OK(rt_job_start(scene, &d, &job));
    set_world(scene, v3(9, 9, 9), v3(9, 9, 9));
    OK(rt_scene_commit(scene, NULL));
    assert_int_equal(rt_job_wait(job, -1), RT_JOB_DONE);
    image = rt_job_take_image(job);
    rt_image_hash(image, got);
    assert_string_equal(want, got);
    rt_job_destroy(job);
    rt_image_destroy(image);
}

static atomic_uint host_calls;

static void host_parallel(void *user, uint32_t count, void (*task)(void *data, uint32_t index), void *data)
{
    (void)user;
    atomic_fetch_add(&host_calls, 1);
    for (uint32_t i = count; i-- > 0;)
        task(data, i);
}

static void test_host_tasks(void **state)
{
    rt_context_desc cd = rt_context_desc_default();
    rt_context *other;
    rt_scene *s;
    rt_render_desc d = settings(60, 40, 2, "whitted");
    rt_image *a, *b;
    (void)state;
    cd.parallel = host_parallel;
    cd.workers = 4;
    OK(rt_context_create(&cd, &other));
    OK(rt_scene_create(other, &s));
    add_everything(s);
    OK(rt_scene_commit(s, NULL));
    a = render(scene, &d);
    atomic_store(&host_calls, 0);
    d.workers = 4;
    b = render(s, &d);
    assert_true(atomic_load(&host_calls) > 0);
    assert_memory_equal(pixel(a, 0, 0), pixel(b, 0, 0), 60 * 40 * 16);
    rt_image_destroy(a);
    rt_image_destroy(b);
    rt_scene_destroy(s);
    rt_context_destroy(other);
}

/* ---- refusals ---- */

static void refused(const rt_render_desc *d, rt_status status, const char *word)
{
    rt_image *image = (rt_image *)8;
    char text[512] = "";
    assert_int_equal(rt_render(scene, d, &image), status);
    assert_null(image);
    rt_context_error(ctx, text, sizeof text);
    if (!strstr(text, word))
        fail_msg("\"%s\" does not name \"%s\"", text, word);
    assert_int_equal(rt_render_memory(scene, d) == 0, status != RT_ERROR_MEMORY_LIMIT);
}

static void test_refusals(void **state)
{
    rt_render_desc d, good = settings(16, 16, 1, "whitted");
    (void)state;
#define REFUSED(change, status, word)                                                                                            \
    do {                                                                                                                         \
        d = good;                                                                                                                \
        change;                                                                                                                  \
        refused(&d, status, word);                                                                                               \
    } while (0)
    REFUSED(d.width = 0, RT_ERROR_ARGUMENT, "0 x 16");
    REFUSED(d.height = 0, RT_ERROR_ARGUMENT, "16 x 0");
    REFUSED(d.width = d.height = 100000, RT_ERROR_ARGUMENT, "10000000000");
    REFUSED(d.width = 2000000, RT_ERROR_ARGUMENT, "2000000");
    REFUSED(d.samples = 0, RT_ERROR_ARGUMENT, "samples is 0");
    REFUSED(d.samples = 65537, RT_ERROR_ARGUMENT, "65537");
    REFUSED(d.tile = 0, RT_ERROR_ARGUMENT, "tile is 0");
    REFUSED(d.tile = 4097, RT_ERROR_ARGUMENT, "4097");
    REFUSED(d.workers = 1025, RT_ERROR_ARGUMENT, "1025");
    REFUSED(d.max_depth = 65, RT_ERROR_ARGUMENT, "max_depth is 65");
    REFUSED(d.integrator = "witted", RT_ERROR_ARGUMENT, "witted");
    REFUSED(d.integrator = NULL, RT_ERROR_ARGUMENT, "integrator");
    REFUSED(d.tracer = "bsp", RT_ERROR_ARGUMENT, "octree");
    REFUSED(d.filter = (rt_filter)9, RT_ERROR_ARGUMENT, "filter is 9");
    REFUSED(d.schedule = (rt_schedule)9, RT_ERROR_ARGUMENT, "schedule is 9");
    REFUSED(d.filter_width = NAN, RT_ERROR_ARGUMENT, "filter_width");
    REFUSED(d.filter_width = -1, RT_ERROR_ARGUMENT, "-1");
    REFUSED(d.ao_distance = NAN, RT_ERROR_ARGUMENT, "ao_distance");
    REFUSED((d.crop.width = 8, d.crop.x = 9, d.crop.height = 1), RT_ERROR_ARGUMENT, "(9, 0)");
    REFUSED((d.crop.width = 8, d.crop.height = UINT32_MAX), RT_ERROR_ARGUMENT, "4294967295");
    REFUSED(d.struct_size = 0, RT_ERROR_ARGUMENT, "struct_size");
    REFUSED(d.memory_limit = 1000, RT_ERROR_MEMORY_LIMIT, "memory_limit is 1000");
    REFUSED((d.width = 65535, d.height = 65536), RT_ERROR_MEMORY_LIMIT, "bytes");
#undef REFUSED
}

static void test_never_committed(void **state)
{
    rt_scene *empty;
    rt_render_desc d = settings(4, 4, 1, "whitted");
    rt_image *image;
    rt_job *job;
    (void)state;
    OK(rt_scene_create(ctx, &empty));
    assert_int_equal(rt_render(empty, &d, &image), RT_ERROR_STATE);
    assert_int_equal(rt_job_start(empty, &d, &job), RT_ERROR_STATE);
    assert_null(job);
    rt_scene_destroy(empty);
}

/* Glass and mirror at once, 64 deep, many samples: more than the film can add up. With fewer samples the unit grows coarser. */
static void test_overflow_guard(void **state)
{
    rt_scene *s;
    rt_render_desc d = settings(2, 2, 65536, "whitted");
    rt_material both;
    rt_image *image;
    char text[512];
    (void)state;
    OK(rt_scene_create(ctx, &s));
    both = add_material(s, v3(1, 1, 1), 0, 1, 1, 1.5f);
    add_sphere(s, v3(0, 0, 0), 1, both);
    for (int i = 0; i < 3; i++)
        add_light(s, light(RT_LIGHT_POINT, v3(4, 5, 4), v3(1, 1, 1), RT_FALLOFF_NONE));
    set_world(s, v3(1, 1, 1), v3(1, 1, 1));
    OK(rt_scene_commit(s, NULL));
    d.max_depth = 64;
    assert_int_equal(rt_render(s, &d, &image), RT_ERROR_ARGUMENT);
    rt_context_error(ctx, text, sizeof text);
    assert_non_null(strstr(text, "max_depth"));
    d.samples = 4;
    d.max_depth = 14;
    d.crop.width = d.crop.height = 1;
    OK(rt_render(s, &d, &image));
    assert_true(pixel(image, 0, 0)[0] > 0);
    rt_image_destroy(image);
    rt_scene_destroy(s);
}

/* ---- memory ---- */

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
    rt_context_drop_kept(other); /* else a refused allocation lets it go and is tried again */
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
    rt_context_memory(ctx, &before, NULL);
    OK(rt_job_start(scene, &d, &job));
    rt_context_memory(ctx, &now, NULL);
    assert_true(now - before <= estimate + 2048 /* alignment of blocks */ && now - before > estimate * 9 / 10);
    rt_job_destroy(job);
    d.memory_limit = estimate;
    rt_image_destroy(render(scene, &d));
}

/* ---- bands ---- */

static int count_pixels(void *user, uint64_t done, uint64_t total)
{
    uint64_t *last = user;
    assert_true(done >= *last && done <= total);
    *last = done;
    return 0;
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
    uint64_t last = 0;
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
    OK(rt_render_to_file(scene, &d, path, &save, 50 * 16 * 20, count_pixels, &last));
    assert_int_equal(last, 3500);
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

static void test_tables(void **state)
{
    static const char *const integrators[] = {"whitted", "path", "ao", "normal", "uv", "id", "depth", "cost", "steps"};
    rt_render_desc d = settings(8, 8, 1, "whitted");
    const char *help = NULL;
    (void)state;
    for (uint32_t i = 0; i < 9; i++) {
        assert_string_equal(rt_integrator_at(i, &help), integrators[i]);
        assert_true(strlen(help) > 10);
        d.integrator = integrators[i];
        rt_image_destroy(render(scene, &d));
    }
    assert_null(rt_integrator_at(9, NULL));
    assert_string_equal(rt_tracer_at(0, &help), "auto");
    for (uint32_t i = 0; rt_tracer_at(i, &help); i++) {
        d.tracer = rt_tracer_at(i, NULL);
        rt_image_destroy(render(scene, &d));
    }
}

#define T(name) cmocka_unit_test_setup_teardown(name, setup, teardown)
int main(void)
{
    const struct CMUnitTest tests[] = {
        T(test_same_whitted),
        T(test_same_whitted_many_samples),
        T(test_same_path),
        T(test_same_ao),
        T(test_seed_and_samples_matter),
        T(test_callers_float_modes),
        T(test_crop_is_a_part_of_the_whole),
        T(test_callers_buffer),
        T(test_every_tile_once),
        T(test_polling),
        T(test_wait_with_a_limit),
        T(test_cancel),
        T(test_cancel_while_busy),
        T(test_cancel_by_callback),
        T(test_scene_may_change_beside_a_job),
        T(test_host_tasks),
        T(test_refusals),
        T(test_never_committed),
        T(test_overflow_guard),
        T(test_each_allocation_fails),
        T(test_memory_estimate),
        T(test_bands),
        T(test_bands_beyond_the_memory),
        T(test_tables),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
