/* Checkpoints: a render that is ended anywhere, in any way, goes on to the same bits and the same counts of rays. */
#include <signal.h>
#include <stdio.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "../support/many.h"
#include "render_scenes.h"

#include "base/base.h"
#include "render/checkpoint.h"
#include "render/job.h"

enum {
    WIDTH = 90,
    HEIGHT = TEST_SANITIZED ? 20 : 70,
    SAMPLES = TEST_SANITIZED ? 16 : 64,
    BAND_SAMPLES = TEST_SANITIZED ? 24 : 64
};

static rt_context *ctx;
static rt_scene *scene;
static char folder[] = "/tmp/librt_checkpoint_XXXXXX";
static char path[128];

static rt_scene *make_scene(rt_context *c, float radius)
{
    rt_scene *s;
    OK(rt_scene_create(c, &s));
    add_everything(s);
    add_sphere(s, v3(0, 0, 0), radius, (rt_material){0});
    OK(rt_scene_commit(s, NULL));
    return s;
}

static int setup(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/librt_checkpoint_XXXXXX");
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/state", folder);
    ctx = make_context(2);
    scene = make_scene(ctx, 0.1f);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    unlink(path);
    assert_int_equal(rmdir(folder), 0); /* nothing else is left */
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
    return 0;
}

typedef struct outcome {
    char hash[33];
    rt_render_stats stats;
} outcome;

static void finish(rt_job *job, outcome *out)
{
    assert_int_equal(rt_job_wait(job, -1), RT_JOB_DONE);
    rt_image_hash(rt_job_image(job), out->hash);
    rt_job_stats(job, &out->stats);
    rt_job_destroy(job);
}

static bool hard; /* some job was too slow to work its rays down: what is lost is counted twice */

static void end(rt_job *job)
{
    hard = hard || rti_cancelled(&job->cancel);
    rt_job_destroy(job);
}

static outcome undisturbed(rt_render_desc d)
{
    outcome out;
    rt_job *job;
    d.checkpoint = NULL;
    hard = false;
    OK(rt_job_start(scene, &d, &job));
    finish(job, &out);
    return out;
}

static void same(const outcome *a, const outcome *b)
{
    assert_string_equal(a->hash, b->hash);
    assert_int_equal(a->stats.tiles_done, b->stats.tiles_done);
    if (hard)
        return;
    assert_int_equal(a->stats.rays_camera, b->stats.rays_camera);
    assert_int_equal(a->stats.rays_shadow, b->stats.rays_shadow);
    assert_int_equal(a->stats.rays_reflect, b->stats.rays_reflect);
    assert_int_equal(a->stats.rays_refract, b->stats.rays_refract);
    assert_int_equal(a->stats.rays_diffuse, b->stats.rays_diffuse);
    assert_int_equal(a->stats.rays_ao, b->stats.rays_ao);
    assert_int_equal(a->stats.tests, b->stats.tests);
}

/* Runs the render in pieces of about `seconds`, each ended by a cancel. Returns the number of runs. */
static uint32_t in_pieces(rt_render_desc d, double seconds, outcome *out, uint32_t *begun)
{
    uint32_t runs = 0;
    d.checkpoint = path;
    *begun = 0;
    for (;;) {
        rt_checkpoint_stats c;
        rt_job *job;
        d.workers = 1 + runs % 3;
        d.schedule = runs % 2 ? RT_SCHEDULE_STATIC : RT_SCHEDULE_DYNAMIC;
        OK(rt_job_start(scene, &d, &job));
        runs++;
        rt_job_checkpoint_stats(job, &c);
        *begun += c.tiles_begun;
        /* the first, of one worker, makes some steps; the later ones end under a sanitizer too */
        rt_job_wait(job, runs == 1 ? 0.0005 : seconds * (1 + runs / 50));
        if (rt_job_poll(job, NULL) == RT_JOB_DONE) {
            finish(job, out);
            return runs;
        }
        rt_job_cancel(job);
        rt_job_wait(job, -1);
        end(job);
    }
}

static void test_pieces(void **state)
{
    static const char *const integrators[] = {"whitted", "path", "ao", "normal", "cost"};
    (void)state;
    for (size_t i = 0; i < RTI_COUNT(integrators); i++) {
        /* more than one worker does in the 20 ms that it is given at a time; normals are made of first hits alone, in no time */
        const uint32_t samples = strcmp(integrators[i], "normal") == 0 ? 512 : 64;
        rt_render_desc d = settings(WIDTH, HEIGHT, TEST_SANITIZED ? samples : 4 * samples, integrators[i]);
        uint32_t runs, begun, tries = 0;
        outcome want, got;
        d.tile = 16;
        d.ao_samples = 2;
        d.tracer = "kdtree";
        want = undisturbed(d);
        do { /* a machine that puts this thread off for the whole of the first run shows nothing: once more */
            runs = in_pieces(d, want.stats.seconds / 6, &got, &begun);
            same(&want, &got);
        } while (runs == 1 && want.stats.rays_camera >= 10000 && ++tries < 100);
        assert_true(runs > 1 || want.stats.rays_camera < 10000);
        assert_int_not_equal(access(path, F_OK), 0); /* it is removed when the picture is whole */
    }
}

/* One tile, so every file holds an unfinished one. The seconds of all runs count. */
static void test_within_a_tile(void **state)
{
    rt_render_desc d = settings(60, 50, TEST_SANITIZED ? 30 : 100, "path");
    uint32_t runs, begun;
    outcome want, got;
    (void)state;
    d.tile = 64;
    want = undisturbed(d);
    runs = in_pieces(d, want.stats.seconds / 5, &got, &begun);
    same(&want, &got);
    assert_true(runs > 1);
    assert_true(begun >= 1 && begun <= runs - 1);
}

/* Written every few milliseconds while it runs, by 1 to 4 workers. */
static void test_while_running(void **state)
{
    rt_render_desc d = settings(WIDTH, HEIGHT, SAMPLES, "path");
    outcome want, got;
    (void)state;
    d.tile = 16;
    want = undisturbed(d);
    d.checkpoint = path;
    d.checkpoint_every = 1e-4;
    for (d.workers = 1; d.workers <= 4; d.workers++) {
        rt_checkpoint_stats c;
        rt_job *job;
        OK(rt_job_start(scene, &d, &job));
        assert_int_equal(rt_job_wait(job, -1), RT_JOB_DONE);
        rt_job_checkpoint_stats(job, &c);
        assert_true(c.written >= 2 && c.failed == 0 && c.tiles_resumed == 0);
        finish(job, &got);
        same(&want, &got);
    }
}

#if !TEST_RACES
/* kill -9 at any moment: a child renders, is killed, the next goes on. */
static void test_killed(void **state)
{
    rt_render_desc d = settings(WIDTH, HEIGHT, 64, "path");
    outcome want, got;
    uint32_t kills = 0, random = 12345, resumed = 0;
    double part = 1.0; /* of the times below: a machine that was busier before lets the first child come to its end */
    (void)state;
    d.tile = 32;
    want = undisturbed(d);
    d.checkpoint = path;
    d.checkpoint_every = 0.002;
    rt_scene_destroy(scene);
    rt_context_destroy(ctx); /* no threads beside fork */
    scene = NULL;
    ctx = NULL;
    for (;; kills++) {
        int status;
        pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            rt_context *own = make_context(2);
            rt_scene *s = make_scene(own, 0.1f);
            rt_job *job;
            d.checkpoint_keep = 1;
            d.workers = 1 + kills % 2;
            if (rt_job_start(s, &d, &job) != RT_OK)
                _exit(3);
            status = rt_job_wait(job, -1) == RT_JOB_DONE ? 0 : 4;
            rt_job_destroy(job);
            rt_scene_destroy(s);
            rt_context_destroy(own);
            _exit(status);
        }
        random = random * 1103515245u + 12345u;
        rti_sleep(part * want.stats.seconds * (0.05 + 0.3 * (random >> 16 & 255) / 256) * (1 + kills / 20));
        kill(child, SIGKILL);
        assert_int_equal(waitpid(child, &status, 0), child);
        if (WIFEXITED(status)) {
            assert_int_equal(WEXITSTATUS(status), 0);
            if (kills > 0 || part < 0.01)
                break;
            part *= 0.5;
            kills--; /* none yet */
            unlink(path);
        }
    }
    ctx = make_context(2);
    scene = make_scene(ctx, 0.1f);
    rt_job *job;
    rt_checkpoint_stats c;
    OK(rt_job_start(scene, &d, &job)); /* the kept file holds the whole picture */
    rt_job_checkpoint_stats(job, &c);
    resumed = c.tiles_resumed;
    finish(job, &got);
    same(&want, &got);
    assert_int_equal(resumed, got.stats.tiles);
    assert_true(kills >= 1);
    char line[300]; /* what a kill between writing aside and renaming leaves */
    snprintf(line, sizeof line, "rm -f %s/.rtray-*.part", folder);
    assert_int_equal(system(line), 0);
}
#endif

/* A file in the middle of a render. */
static void interrupted_at(rt_render_desc *d)
{
    rt_job *job;
    rt_tile tile;
    d->checkpoint = path;
    d->workers = 1;
    OK(rt_job_start(scene, d, &job));
    while (!rt_job_next_tile(job, &tile))
        rt_job_poll(job, NULL);
    rt_job_cancel(job);
    assert_int_equal(rt_job_wait(job, -1), RT_JOB_CANCELLED);
    rt_job_destroy(job);
}

static void refused(rt_scene *s, const rt_render_desc *d, rt_status status, const char *words)
{
    rt_job *job = (rt_job *)8;
    assert_int_equal(rt_job_start(s, d, &job), status);
    assert_null(job);
    kit_says(ctx, words);
    kit_says(ctx, path);
}

static void test_refused(void **state)
{
    rt_render_desc d = settings(WIDTH, HEIGHT, 512, "path"), other;
    rt_scene *changed = make_scene(ctx, 0.2f);
    (void)state;
    d.tile = 16;
    interrupted_at(&d);
    refused(changed, &d, RT_ERROR_STATE, "another scene");
    other = d, other.samples = 65;
    refused(scene, &other, RT_ERROR_STATE, "samples is 512 there and 65 here");
    other = d, other.seed = 7;
    refused(scene, &other, RT_ERROR_STATE, "seed is 0 there and 7 here");
    other = d, other.integrator = "whitted";
    refused(scene, &other, RT_ERROR_STATE, "integrator 'path', this render of 'whitted'");
    other = d, other.filter_width = 1.5f;
    refused(scene, &other, RT_ERROR_STATE, "filter_width is 1 there and 1.5 here");
    other = d, other.crop = (rt_tile){1, 0, 20, 20};
    refused(scene, &other, RT_ERROR_STATE, "crop.x is 0 there and 1 here");
    other = d, other.max_depth = 3;
    refused(scene, &other, RT_ERROR_STATE, "max_depth");
    other = d, other.checkpoint_every = -1;
    assert_int_equal(rt_job_start(scene, &other, &(rt_job *){0}), RT_ERROR_ARGUMENT);
    kit_says(ctx, "checkpoint_every");
    other = d, other.checkpoint = "";
    assert_int_equal(rt_job_start(scene, &other, &(rt_job *){0}), RT_ERROR_ARGUMENT);
    other = d, other.checkpoint = folder;
    assert_int_equal(rt_job_start(scene, &other, &(rt_job *){0}), RT_ERROR_IO);
    other = d, other.checkpoint = "/no/such/folder/state";
    assert_int_equal(rt_job_start(scene, &other, &(rt_job *){0}), RT_ERROR_IO);
    kit_says(ctx, "no such file or folder");
    other = d, other.tile = 64, other.tracer = "octree"; /* of no matter */
    rt_job *job;
    OK(rt_job_start(scene, &other, &job));
    rt_job_cancel(job);
    rt_job_destroy(job);
    rt_scene_destroy(changed);
}

static unsigned char *slurp(long *size)
{
    FILE *f = fopen(path, "rb");
    assert_non_null(f);
    fseek(f, 0, SEEK_END);
    *size = ftell(f);
    rewind(f);
    unsigned char *bytes = malloc((size_t)*size);
    assert_int_equal(fread(bytes, 1, (size_t)*size, f), *size);
    fclose(f);
    return bytes;
}

static void spill(const unsigned char *bytes, long size)
{
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(bytes, 1, (size_t)size, f), size);
    fclose(f);
}

/* A changed byte anywhere, a cut anywhere, a byte more: refused, and the file stays as it is. */
static void test_damaged(void **state)
{
    rt_render_desc d = settings(40, 30, TEST_SANITIZED ? 256 : 4096, "whitted"); /* not done while its first tile is waited for */
    long size;
    (void)state;
    d.tile = 8;
    interrupted_at(&d);
    unsigned char *bytes = slurp(&size);
    for (long i = 0; i < size; i += i < 400 ? 1 : 97) {
        bytes[i] ^= 16;
        spill(bytes, size);
        rt_job *job = NULL;
        rt_status status = rt_job_start(scene, &d, &job);
        assert_true(status == RT_ERROR_FORMAT || status == RT_ERROR_STATE);
        assert_null(job);
        bytes[i] ^= 16;
    }
    for (long cut = 0; cut < size; cut += 61) {
        spill(bytes, cut);
        refused(scene, &d, RT_ERROR_FORMAT, "checkpoint");
    }
    bytes = realloc(bytes, (size_t)size + 1);
    bytes[size] = 0;
    spill(bytes, size + 1);
    refused(scene, &d, RT_ERROR_FORMAT, "longer than it says");
    spill((const unsigned char *)"hello", 5);
    refused(scene, &d, RT_ERROR_FORMAT, "no checkpoint of a render");
    free(bytes);
}

/* A disk that is full later: the render goes on and is whole, what stands there stays. */
static void test_disk_full(void **state)
{
    rt_render_desc d = settings(WIDTH, HEIGHT, SAMPLES, "path");
    struct rlimit before, small;
    rt_checkpoint_stats c;
    outcome want, got;
    rt_job *job;
    (void)state;
    d.tile = 16;
    want = undisturbed(d);
    d.checkpoint = path;
    d.checkpoint_every = 1e-4;
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    small = before;
    small.rlim_cur = 2000;
    OK(rt_job_start(scene, &d, &job));
    setrlimit(RLIMIT_FSIZE, &small);
    assert_int_equal(rt_job_wait(job, -1), RT_JOB_DONE);
    setrlimit(RLIMIT_FSIZE, &before);
    rt_job_checkpoint_stats(job, &c);
    assert_true(c.failed > 0);
    finish(job, &got);
    same(&want, &got);
    signal(SIGXFSZ, SIG_DFL);
}

/* Driven by polls of 20 ms, and from a callback. */
static int cancel_at(void *user, const rt_tile *tile, const rt_image *image)
{
    uint32_t *left = user;
    (void)tile;
    (void)image;
    return --*left == 0;
}

static void test_callback(void **state)
{
    rt_render_desc d = settings(WIDTH, HEIGHT, TEST_SANITIZED ? 64 : 256, "whitted");
    outcome want, got;
    (void)state;
    d.tile = 16;
    want = undisturbed(d);
    d.checkpoint = path;
    for (uint32_t run = 0; run < 4; run++) {
        rt_job *job;
        uint32_t left = 5 + 5 * run;
        d.workers = run % 2 + 1;
        OK(rt_job_start(scene, &d, &job));
        rt_job_on_tile(job, cancel_at, &left); /* hears of the tiles from the file too */
        rt_job_wait(job, -1);
        end(job);
    }
    rt_job *job;
    OK(rt_job_start(scene, &d, &job));
    finish(job, &got);
    same(&want, &got);
}

/* ---- bands ---- */

typedef struct stopper {
    uint64_t first, stop_at;
} stopper;

static int stop_at(void *user, uint64_t done, uint64_t total)
{
    stopper *s = user;
    (void)total;
    if (!s->first)
        s->first = done;
    return done >= s->stop_at;
}

static void hash_of_file(const char *name, char hash[33])
{
    rt_image *image;
    OK(rt_image_load(ctx, name, &image));
    rt_image_hash(image, hash);
    rt_image_destroy(image);
}

static void test_bands(void **state)
{
    rt_render_desc d = settings(50, 96, BAND_SAMPLES, "whitted");
    stopper s0;
    char image[200], want[33], got[33], inner[160];
    uint64_t total = 50 * 96;
    (void)state;
    snprintf(image, sizeof image, "%s/x.bmp", folder);
    snprintf(inner, sizeof inner, "%s.band", path);
    d.tile = 8;
    OK(rt_render_to_file(scene, &d, image, NULL, 50 * 16 * 16, NULL, NULL)); /* bands of 16 rows */
    hash_of_file(image, want);
    d.checkpoint = path;
    for (uint64_t at = 900; at < total; at += 900) {
        stopper s = {0, at};
        d.workers = 1 + at / 900 % 2;
        rt_status status = rt_render_to_file(scene, &d, image, NULL, 50 * 16 * (at / 900 % 2 ? 16 : 24), stop_at, &s);
        if (status == RT_OK && at > 900)
            break; /* the workers were faster than the callback */
        assert_int_equal(status, RT_ERROR_CANCELLED);
        assert_true(s.first + 50 * 24 > at - 900); /* finished bands are not made again */
        assert_int_equal(access(path, F_OK), 0);
    }
    unlink(path);
    unlink(inner);
    s0 = (stopper){0, 2900}; /* three bands are finished */
    assert_int_equal(rt_render_to_file(scene, &d, image, NULL, 50 * 16 * 16, stop_at, &s0), RT_ERROR_CANCELLED);
    d.samples = BAND_SAMPLES + 1;
    assert_int_equal(rt_render_to_file(scene, &d, image, NULL, 0, NULL, NULL), RT_ERROR_STATE);
    kit_says(ctx, TEST_SANITIZED ? "samples is 24 there and 25 here" : "samples is 64 there and 65 here");
    d.samples = BAND_SAMPLES;
    long size;
    unsigned char *bytes = slurp(&size); /* a band that was being written is made again */
    assert_int_equal(truncate(path, size - 1), 0);
    unlink(inner);
    bytes[2000] ^= 1;
    stopper s = {0, total + 1};
    OK(rt_render_to_file(scene, &d, image, NULL, 50 * 16 * 16, stop_at, &s));
    hash_of_file(image, got);
    assert_string_equal(want, got);
    assert_int_not_equal(access(path, F_OK), 0);
    assert_int_not_equal(access(inner, F_OK), 0);
    spill(bytes, size);
    assert_int_equal(rt_render_to_file(scene, &d, image, NULL, 0, NULL, NULL), RT_ERROR_FORMAT);
    kit_says(ctx, "damaged");
    free(bytes);
    unlink(image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_pieces, setup, teardown),
        cmocka_unit_test_setup_teardown(test_within_a_tile, setup, teardown),
        cmocka_unit_test_setup_teardown(test_while_running, setup, teardown),
#if !TEST_RACES /* a process's death is none */
        cmocka_unit_test_setup_teardown(test_killed, setup, teardown),
#endif
        cmocka_unit_test_setup_teardown(test_refused, setup, teardown),
        cmocka_unit_test_setup_teardown(test_damaged, setup, teardown),
        cmocka_unit_test_setup_teardown(test_disk_full, setup, teardown),
        cmocka_unit_test_setup_teardown(test_callback, setup, teardown),
        cmocka_unit_test_setup_teardown(test_bands, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
