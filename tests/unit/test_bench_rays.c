/* The ray benchmark: its files, its sets, its command line, and one run from end to end. */
#include <math.h>
#include <unistd.h>

#include "scene_kit.h"

#include "rays.h"

/* ---- files of rays ---- */

static bench_rays some_rays(size_t count)
{
    bench_rays r = {.set = "ao", .scene = "a-scene_1.x", .count = count, .width = 7, .height = 5, .any = true, .hints = 1};
    r.rays = calloc(count, sizeof *r.rays);
    for (size_t i = 0; i < count; i++)
        r.rays[i] = (rt_ray){{(float)i, 0.1f, -3e-40f}, 0.5f, {1, -0.0f, (float)i}, i % 2 ? INFINITY : 2.5f, RT_MASK_ALL};
    return r;
}

static size_t file_of(const bench_rays *rays, unsigned char *out, size_t room)
{
    char path[64];
    snprintf(path, sizeof path, "bench_rays_%ld.rays", (long)getpid());
    assert_int_equal(bench_rays_write(path, rays), BENCH_OK);
    FILE *f = fopen(path, "rb");
    assert_non_null(f);
    size_t size = fread(out, 1, room, f);
    fclose(f);
    bench_rays back;
    assert_int_equal(bench_rays_read(path, &back), BENCH_OK);
    assert_int_equal(back.count, rays->count);
    bench_rays_free(&back);
    remove(path);
    return size;
}

static void files_of_rays_come_back(void **state)
{
    unsigned char data[4096];
    char why[200];
    bench_rays rays = some_rays(5), back;
    size_t size = file_of(&rays, data, sizeof data);
    (void)state;
    assert_int_equal(size, 128 + 5 * 32);
    assert_true(bench_rays_parse(data, size, &back, why, sizeof why));
    assert_memory_equal(back.rays, rays.rays, 5 * sizeof(rt_ray));
    assert_string_equal(back.set, "ao");
    assert_string_equal(back.scene, "a-scene_1.x");
    assert_true(back.any && back.hints == 1 && back.width == 7 && back.height == 5);
    bench_rays_free(&back);
    bench_rays_free(&rays);
}

static void refused(const unsigned char *good, size_t size, size_t at, unsigned char byte, const char *part)
{
    unsigned char data[4096];
    char why[200] = "";
    bench_rays back;
    memcpy(data, good, size);
    if (at < size)
        data[at] = byte;
    if (at >= 128)
        for (int i = 0; i < 8; i++)
            data[40 + i] = (unsigned char)(bench_rays_hash(data + 128, size - 128) >> (8 * i));
    assert_false(bench_rays_parse(data, size, &back, why, sizeof why));
    if (!strstr(why, part))
        fail_msg("expected \"%s\", got \"%s\"", part, why);
}

static void broken_files_are_refused(void **state)
{
    unsigned char data[4096];
    bench_rays rays = some_rays(3);
    size_t size = file_of(&rays, data, sizeof data);
    (void)state;
    refused(data, 127, 127, 0, "shorter");
    refused(data, 0, 0, 0, "shorter");
    refused(data, size, 0, 'X', "no file of rays");
    refused(data, size, 8, 2, "version");
    refused(data, size, 12, 2, "kind");
    refused(data, size, 16, 4, "hints");
    refused(data, size, 28, 1, "28");
    refused(data, size, 32, 0, "counts no rays");
    refused(data, size, 32, 4, "size");
    refused(data, size, 39, 0x80, "counts no rays");
    refused(data, size - 1, size, 0, "size");
    refused(data, size, 48, '/', "name");
    refused(data, size, 48 + 5, 'x', "name"); /* behind a NUL */
    refused(data, size, 40, (unsigned char)(data[40] ^ 1), "damaged");
    refused(data, size, 128 + 7, 0x7f, "ray 0");       /* org.y is no number then */
    refused(data, size, 128 + 32 + 15, 0xbf, "ray 1"); /* tmin below 0 */
    bench_rays_free(&rays);
}

/* ---- cameras ---- */

static int camera(const char *text, const char *name, bench_view *view, char *why)
{
    why[0] = '\0';
    return bench_camera_parse(text, strlen(text), name, view, why, 200);
}

static void cameras_are_read(void **state)
{
    static const char good[] = "{\"x\": {\"a\": [1, {\"b\": \"}]\\\"\"}]},\n \"room\": {\"eye\": [1, -2.5, 3e1], \"at\": "
                               "[0,0,0],\n \"vfov\": 60, \"note\": null}}";
    bench_view v;
    char why[200];
    (void)state;
    assert_int_equal(camera(good, "room", &v, why), 1);
    assert_true(v.eye[0] == 1 && v.eye[1] == -2.5 && v.eye[2] == 30 && v.up[1] == 1 && v.vfov == 60);
    assert_int_equal(camera(good, "other", &v, why), 0);
    assert_int_equal(camera("{}", "room", &v, why), 0);
    assert_int_equal(camera("{\"room\": {\"eye\": [1, 2], \"at\": [0,0,0], \"vfov\": 60}}", "room", &v, why), -1);
    assert_int_equal(camera("{\"room\": {\"eye\": [1, 2, 3],\n\"vfov\": 60}}", "room", &v, why), -1);
    assert_non_null(strstr(why, "line 2"));
    assert_int_equal(camera("{\"room\": {\"eye\": [1, 2, 3], \"at\": [0,0,0], \"vfov\": 180}}", "room", &v, why), -1);
    assert_int_equal(camera("{\"room\": {\"eye\": [1, 2, nan], \"at\": [0,0,0], \"vfov\": 18}}", "room", &v, why), -1);
    assert_int_equal(camera("{\"room\": ", "room", &v, why), -1);
    assert_int_equal(camera("", "room", &v, why), -1);
    assert_int_equal(camera("{\"x\": [[[[", "room", &v, why), -1);
}

/* ---- numbers ---- */

static void sines_are_right(void **state)
{
    (void)state;
    for (int i = -4000; i <= 4000; i++) {
        double x = 0.0123 * i;
        assert_true(fabs(bench_sin(x) - sin(x)) < 1e-14);
    }
    assert_true(bench_sin(0) == 0);
}

/* ---- the command line ---- */

static int parse(bench_options *o, const char *line)
{
    char copy[400], *argv[32];
    int argc = 1;
    strcpy(copy, line);
    argv[0] = NULL;
    for (char *word = strtok(copy, " "); word; word = strtok(NULL, " "))
        argv[argc++] = word;
    int status = bench_options_parse(argc, argv, o);
    bench_options_free(o);
    return status;
}

static void command_lines_are_read(void **state)
{
    static const char *const bad[] = {
        "",
        "--sets primary",
        "x --sets wrong",
        "x --sets primary,,ao",
        "x --size 640",
        "x --size 0x480",
        "x --size 640x480x3",
        "x --threads 0",
        "x --threads 1,2,",
        "x --grab 100",
        "x --repeats -1",
        "x --repeats 99999999999999999999",
        "x --light 1,2",
        "x --light 1,2,nan",
        "x --against tachyon",
        "x --clock sun",
        "x --unknown",
        "x --ceiling=1",
        "x --output",
        "x --eye 1,2,3",
        "x --preset all",
        "x --tolerance 2",
        "x --tracers abcdefghijklmnopqrstuvwxyzabcdefghijklmnop",
    };
    bench_options o;
    (void)state;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        if (parse(&o, bad[i]) != BENCH_USAGE)
            fail_msg("\"%s\" was taken", bad[i]);
    assert_int_equal(parse(&o, "a --sets=ao,random -o f.csv --threads 1,2,16 --light -1,2e3,.5 b -- --c"), BENCH_OK);
    assert_true(o.scene_count == 3 && o.sets.count == 2 && o.thread_count == 3 && o.threads[2] == 16 && o.light[1] == 2000 &&
                o.has_light);
    assert_int_equal(parse(&o, "--preset embree"), BENCH_OK);
    assert_true(o.scene_count == 7 && o.embree);
    assert_int_equal(parse(&o, "one --preset embree-1080"), BENCH_OK);
    assert_true(o.scene_count == 1 && o.width == 1920 && o.sets.count == 2);
}

/* ---- the sets ---- */

static void open_source(bench_options *o, bench_world *w, bench_source *s, rt_tracer **t, const char *size)
{
    static char argument[64];
    char *argv[] = {NULL, argument, "sphere"};
    snprintf(argument, sizeof argument, "--size=%s", size);
    assert_int_equal(bench_options_parse(3, argv, o), BENCH_OK);
    memset(w, 0, sizeof *w);
    rt_context *ctx = kit_context(NULL, 1);
    w->ctx = ctx;
    w->scene = kit_scene(ctx);
    strcpy(w->name, "square");
    kit_square(w->scene, 1, 0);
    kit_ok(ctx, rt_scene_commit(w->scene, NULL));
    w->view = (bench_view){{0, 0, 2}, {0, 0, 0}, {0, 1, 0}, 60};
    w->low = (rt_vec3){-1, -1, 0};
    w->high = (rt_vec3){1, 1, 0};
    kit_ok(ctx, rt_tracer_create(w->scene, "brute", t));
    assert_int_equal(bench_source_open(s, o, w, *t), BENCH_OK);
}

static float length(rt_vec3 v)
{
    return sqrtf(v.x * v.x + v.y * v.y + v.z * v.z);
}

static void sets_are_as_defined(void **state)
{
    bench_options o;
    bench_world w;
    bench_source s;
    bench_rays primary, shadow, diffuse, ao, random, again;
    rt_tracer *t;
    size_t hits = 0;
    double up = 0;
    (void)state;
    open_source(&o, &w, &s, &t, "20x12");
    assert_int_equal(bench_set_make(&s, BENCH_PRIMARY, &primary), BENCH_OK);
    assert_int_equal(bench_set_make(&s, BENCH_SHADOW, &shadow), BENCH_OK);
    assert_int_equal(bench_set_make(&s, BENCH_DIFFUSE, &diffuse), BENCH_OK);
    assert_int_equal(bench_set_make(&s, BENCH_AO, &ao), BENCH_OK);
    assert_int_equal(bench_set_make(&s, BENCH_RANDOM, &random), BENCH_OK);
    assert_int_equal(bench_set_make(&s, BENCH_AO, &again), BENCH_OK);
    assert_memory_equal(ao.rays, again.rays, ao.count * sizeof(rt_ray));
    assert_true(primary.count == 240 && random.count == 240 && !primary.any && shadow.any && !diffuse.any && ao.any &&
                !random.any);
    assert_true(primary.hints == (RT_RAYS_COHERENT | RT_RAYS_COMMON_ORIGIN) && shadow.hints == RT_RAYS_COHERENT && ao.hints == 0);
    /* tiles of 8 x 8, cut at the right (4 wide) and below (4 high): ray 64 is pixel (8, 0), ray 128 (16, 0), ray 160 (0, 8) */
    double h = tan(30 * 3.14159265358979323846 / 180);
    static const int at[][3] = {{0, 0, 0},    {1, 1, 0},    {8, 0, 1},   {64, 8, 0},
                                {128, 16, 0}, {132, 16, 1}, {160, 0, 8}, {239, 19, 11}};
    for (size_t i = 0; i < sizeof at / sizeof *at; i++) {
        double x = h * 20 / 12 * (2 * (at[i][1] + 0.5) / 20 - 1), y = h * (1 - 2 * (at[i][2] + 0.5) / 12),
               l = sqrt(x * x + y * y + 1);
        const rt_ray *r = &primary.rays[at[i][0]];
        assert_true(fabs(r->dir.x - x / l) < 1e-7 && fabs(r->dir.y - y / l) < 1e-7 && fabs(r->dir.z + 1 / l) < 1e-7);
        assert_true(r->org.z == 2 && r->tmin == 0 && isinf(r->tmax));
    }
    for (size_t i = 0; i < primary.count; i++)
        hits += s.hits[i].prim_id != RT_INVALID_ID;
    assert_true(hits > 50 && hits < 240 && shadow.count == hits && diffuse.count == hits && ao.count == 4 * hits);
    /* the ray f meets (0, 0, 0), so the middle is (0, 0, 1), and nothing is above it: half a diagonal, sqrt(8) / 2 */
    assert_true(s.light.x == 0 && s.light.z == 1 && fabsf(s.light.y - 1.41421356f) < 1e-6f);
    for (size_t i = 0; i < hits; i++) {
        const rt_ray *r = &shadow.rays[i];
        assert_true(fabsf(r->org.x + r->dir.x - s.light.x) < 1e-6f && fabsf(r->org.z + r->dir.z - s.light.z) < 1e-6f &&
                    r->tmax == 1);
        assert_true(r->org.z > 0 && r->org.z < 1e-3f); /* off the surface, on the eye's side */
        r = &diffuse.rays[i];
        assert_true(fabsf(length(r->dir) - 1) < 1e-6f && r->dir.z >= 0 && isinf(r->tmax));
        up += (double)r->dir.z / (double)hits;
        assert_true(ao.rays[4 * i].org.x == ao.rays[4 * i + 3].org.x && ao.rays[4 * i].dir.x != ao.rays[4 * i + 3].dir.x);
        assert_true(ao.rays[4 * i].tmax == s.reach);
    }
    assert_true(fabs(up - 2.0 / 3) < 0.1);          /* the mean cosine of a cosine-weighted hemisphere */
    assert_true(s.reach > 0.5f && s.reach < 0.62f); /* a quarter of distances from 2 on */
    for (size_t i = 0; i < random.count; i++)
        assert_true(fabsf(random.rays[i].org.x) <= 1 && random.rays[i].org.z == 0 &&
                    fabsf(length(random.rays[i].dir) - 1) < 1e-6f);
    bench_rays *all[] = {&primary, &shadow, &diffuse, &ao, &random, &again};
    for (size_t i = 0; i < 6; i++)
        bench_rays_free(all[i]);
    rt_tracer_destroy(t);
    bench_source_close(&s);
    bench_world_close(&w);
    bench_options_free(&o);
}

/* ---- from end to end ---- */

static const char mesh[] =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 2\n"
    "property list uchar int vertex_indices\nend_header\n-1 -1 0\n1 -1 0\n1 1 0\n-1 1 0.5\n3 0 1 2\n3 0 2 3\n";

static void put_file(const char *path, const char *text)
{
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(text, 1, strlen(text), f), strlen(text));
    assert_int_equal(fclose(f), 0);
}

static void a_run_measures_every_tracer(void **state)
{
    char ply[64], csv[64], line[2000];
    int rows = 0, columns = -1;
    (void)state;
    snprintf(ply, sizeof ply, "bench_%ld.ply", (long)getpid());
    snprintf(csv, sizeof csv, "bench_%ld.csv", (long)getpid());
    put_file(ply, mesh);
    char *argv[] = {NULL,
                    ply,
                    "--size=24x16",
                    "--repeats=2",
                    "--least=0",
                    "--builds=1",
                    "--threads=1,2",
                    "--grab=64",
                    "--inputs=blocks,single,array,scene",
                    "--ceiling",
                    "--quiet",
                    "--check=4294967295",
                    "--output",
                    csv};
    assert_int_equal(bench_rays_main(sizeof argv / sizeof *argv, argv, NULL), BENCH_OK);
    FILE *f = fopen(csv, "rb");
    assert_non_null(f);
    while (fgets(line, sizeof line, f)) {
        int commas = 0;
        for (const char *p = line; *p; p++)
            commas += *p == ',';
        if (columns < 0)
            columns = commas;
        assert_int_equal(commas, columns);
        rows++;
    }
    fclose(f);
    remove(csv);
    remove(ply);
    int tracers = 0;
    while (rt_tracer_at((uint32_t)tracers, NULL))
        tracers++;
    assert_int_equal(
        rows,
        1 + 5 * 2 *
                (3 * tracers + 1)); /* sets, threads, blocks, with and without hints, and arrays of all, and the scene itself */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(files_of_rays_come_back),
        cmocka_unit_test(broken_files_are_refused),
        cmocka_unit_test(cameras_are_read),
        cmocka_unit_test(sines_are_right),
        cmocka_unit_test(command_lines_are_read),
        cmocka_unit_test(sets_are_as_defined),
        cmocka_unit_test(a_run_measures_every_tracer),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
