/* Jobs: every tile once, polling, waiting, cancelling, scenes that change beside them, the host's tasks and signals. */
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <time.h>
#include <unistd.h>

#include "../support/many.h"
#include "render_stage.h"

#include "base/base.h"

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

/* Jobs of one worker: in the background they end by themselves, side by side; otherwise nothing is done until they are waited
 * for. */
static void test_background(void **state)
{
    rt_render_desc d = settings(100, 80, 4, "path");
    rt_job *jobs[3];
    rt_render_stats s;
    char image[3][33];
    (void)state;
    d.workers = 1;
    OK(rt_job_start(scene, &d, &jobs[0]));
    d.background = 1;
    OK(rt_job_start(scene, &d, &jobs[1]));
    OK(rt_job_start(scene, &d, &jobs[2]));
    for (int i = 1; i < 3; i++) {
        do {
            struct timespec pause = {0, 1000000};
            nanosleep(&pause, NULL);
            rt_job_stats(jobs[i], &s);
        } while (s.tiles_done < s.tiles);
        assert_int_equal(s.workers, 1);
    }
    rt_job_stats(jobs[0], &s);
    assert_int_equal(s.tiles_done, 0);
    for (int i = 0; i < 3; i++) {
        assert_int_equal(rt_job_wait(jobs[i], -1), RT_JOB_DONE);
        rt_image_hash(rt_job_image(jobs[i]), image[i]);
        rt_job_destroy(jobs[i]);
    }
    assert_string_equal(image[0], image[1]);
    assert_string_equal(image[0], image[2]);
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
    rt_render_desc d = settings(100, 80, 512, "path"); /* 130 tiles, not done before one is heard of */
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

static volatile sig_atomic_t signals_seen;
static pthread_t seen_by;

static void on_signal(int signo)
{
    (void)signo;
    seen_by = pthread_self();
    signals_seen = 1;
}

/* The one thread of the host holds the signal back: so nobody handles it until that lets it come. */
static void one_signal(rt_job *job)
{
    const struct timespec pause = {0, 50000000};
    sigset_t set, before;
    signals_seen = 0;
    sigemptyset(&set);
    sigaddset(&set, SIGUSR1);
    pthread_sigmask(SIG_BLOCK, &set, &before);
    kill(getpid(), SIGUSR1);
    nanosleep(&pause, NULL);
    if (job)
        assert_int_equal(rt_job_wait(job, -1), RT_JOB_DONE);
    assert_int_equal(signals_seen, 0);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    assert_int_equal(signals_seen, 1);
    assert_true(pthread_equal(seen_by, pthread_self()));
}

static void test_signals_are_the_hosts(void **state)
{
    rt_context_desc cd = rt_context_desc_default();
    rt_context *other;
    rt_scene *s;
    rt_render_desc d = settings(400, 300, TEST_SANITIZED ? 1 : 4, "whitted");
    rt_job *job;
    struct sigaction action, old;
    sigset_t now;
    (void)state;
    memset(&action, 0, sizeof action);
    action.sa_handler = on_signal;
    sigaction(SIGUSR1, &action, &old);
    cd.workers = 4;
    OK(rt_context_create(&cd, &other));
    assert_int_equal(rti_pool_start(other), RT_OK);
    one_signal(NULL);
    OK(rt_scene_create(other, &s));
    add_everything(s);
    OK(rt_scene_commit(s, NULL));
    d.workers = 6;
    OK(rt_job_start(s, &d, &job));
    one_signal(job);
    rt_job_destroy(job);
    pthread_sigmask(SIG_SETMASK, NULL, &now); /* the host's own mask is as it was */
    assert_int_equal(sigismember(&now, SIGTERM), 0);
    rt_scene_destroy(s);
    rt_context_destroy(other);
    sigaction(SIGUSR1, &old, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_ROOM(test_every_tile_once),
        IN_ROOM(test_polling),
        IN_ROOM(test_background),
        IN_ROOM(test_wait_with_a_limit),
        IN_ROOM(test_cancel),
        IN_ROOM(test_cancel_while_busy),
        IN_ROOM(test_cancel_by_callback),
        IN_ROOM(test_scene_may_change_beside_a_job),
        IN_ROOM(test_host_tasks),
        IN_ROOM(test_signals_are_the_hosts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
