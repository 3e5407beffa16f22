/* The lens and the moving camera: closed forms, sums of many still images, and what is refused. */
#include "../support/many.h"
#include "render_stage.h"

#include <stdio.h>

#include "kernel/camera.h"

enum { N = 1 << 16 };

static rtk_uv stratified(uint32_t i)
{
    return rtk_random2(rtk_vertex_seed(1, 2, rtk_key_root()), i, RTK_DIM_LENS_U);
}

/* The sum of (x + iy)^k over all points, divided by their number. */
typedef struct moments {
    double m[9][2], r2, most;
} moments;

static void add_point(moments *s, double x, double y, double weight)
{
    double re = 1, im = 0;
    for (int k = 0; k < 9; k++) {
        double next = re * x - im * y;
        s->m[k][0] += weight * re;
        s->m[k][1] += weight * im;
        im = re * y + im * x;
        re = next;
    }
    s->r2 += weight * (x * x + y * y);
    s->most = fmax(s->most, sqrt(x * x + y * y));
}

static double moment(const moments *s, int k)
{
    return sqrt(s->m[k][0] * s->m[k][0] + s->m[k][1] * s->m[k][1]) / s->m[0][0];
}

/* Of all harmonics of a uniform n-gon only those of multiples of n are not zero; its mean square radius is (2 + cos(2 pi / n))
 * / 6. */
static void lens_shapes(void **state)
{
    (void)state;
    for (uint32_t n = 0; n <= 8; n = n ? n + 1 : 3) {
        moments s = {0};
        double apothem = n ? cos(3.14159265358979 / n) : 1.0, want = n ? (2 + cos(2 * 3.14159265358979 / n)) / 6 : 0.5;
        for (uint32_t i = 0; i < N; i++) {
            rtk_uv u = stratified(i), p = n ? rtk_polygon(u, n, 0.0f) : rtk_concentric(u);
            add_point(&s, p.x, p.y, 1);
            for (uint32_t e = 0; e < n; e++) { /* inside every edge */
                double a = 1.57079632679 + (2 * e + 1) * 3.14159265358979 / n;
                assert_true(p.x * cos(a) + p.y * sin(a) < apothem + 1e-6);
            }
        }
        assert_true(s.most < 1.000001 && s.most > 0.99);
        assert_true(fabs(s.r2 / N - want) < 2e-4);
        for (int k = 1; k <= 8; k++)
            assert_true((n && k % (int)n == 0) ? moment(&s, k) > 0.02 : moment(&s, k) < 1e-3);
        if (n) /* a corner points up: the n-th power of it is i^n */
            assert_true(s.m[n][0] * cos(n * 1.57079632679) + s.m[n][1] * sin(n * 1.57079632679) > 0.0);
    }
    rtk_uv corners[] = {{0, 0}, {0.99999994f, 0.99999994f}, {0.5f, 0.5f}, {0, 0.99999994f}};
    for (int i = 0; i < 4; i++)
        for (uint32_t n = 3; n <= 64; n++) {
            rtk_uv p = rtk_polygon(corners[i], n, 1.0f), q = rtk_concentric(corners[i]);
            assert_true(p.x * p.x + p.y * p.y < 1.00001f && q.x * q.x + q.y * q.y < 1.00001f);
        }
}

/* ---- circle of confusion ---- */

/* A shining ball of radius `ball` at distance d, seen by a lens of radius r sharp at distance f. */
static moments blur_of(rt_camera_type type, float ball, float d, float f, float r, uint32_t blades)
{
    enum { SIZE = 96 };
    rt_scene *s;
    rt_camera_desc c = rt_camera_desc_default();
    rt_material_desc m = rt_material_desc_default();
    rt_material lamp;
    rt_render_desc rd = settings(SIZE, SIZE, 128, "whitted");
    rt_image *image;
    moments sums = {0};
    OK(rt_scene_create(ctx, &s));
    m.type = RT_MATERIAL_EMISSIVE;
    m.emission = v3(1, 1, 1);
    OK(rt_scene_add_material(s, &m, &lamp));
    add_sphere(s, v3(0, 0, -d), ball, lamp);
    set_world(s, v3(0, 0, 0), v3(0, 0, 0));
    c.type = type;
    c.eye = v3(0, 0, 0);
    c.look_at = v3(0, 0, -1);
    c.fov_deg = 90;
    c.height = 2;
    c.aperture = r;
    c.focus_distance = f;
    c.blades = blades;
    OK(rt_scene_set_camera(s, &c));
    OK(rt_scene_commit(s, NULL));
    image = render(s, &rd);
    for (uint32_t y = 0; y < SIZE; y++)
        for (uint32_t x = 0; x < SIZE; x++) {
            float light = pixel(image, x, y)[0];
            double px = (x + 0.5) * 2 / SIZE - 1, py = 1 - (y + 0.5) * 2 / SIZE;
            if (light > 0)
                add_point(&sums, px, py, light);
        }
    rt_image_destroy(image);
    rt_scene_destroy(s);
    return sums;
}

/* A point at distance d covers a disc of radius r |1/f - 1/d| of the window at distance 1 (parallel rays: r |1 - d/f|). A uniform
 * disc's mean square radius is half its radius squared; the ball's own disc and the pixel add theirs. */
static void circle_of_confusion(void **state)
{
    static const float at[][3] = {{2, 4, 0.8f}, {4, 2, 1.2f}, {3, 3, 1}, {10, 2, 0.5f}};
    (void)state;
    for (int i = 0; i < 4; i++)
        for (int ortho = 0; ortho < 2; ortho++) {
            double d = at[i][0], f = at[i][1], r = ortho ? 0.4 * at[i][2] : at[i][2];
            double disc = ortho ? r * fabs(1 - d / f) : r * fabs(1 / f - 1 / d), ball = ortho ? 0.15 : 0.05, edge = 2.0 / 96;
            double want;
            moments s;
            if (disc > 0.9)
                continue;
            s = blur_of(ortho ? RT_CAMERA_ORTHOGRAPHIC : RT_CAMERA_PINHOLE, (float)(ortho ? 0.15 : 0.05 * d), (float)d, (float)f,
                        (float)r, 0);
            want = 0.5 * disc * disc + 0.5 * ball * ball + edge * edge / 6;
            assert_true(s.m[0][0] > 0);
            print_message("d %g f %g r %g %s: mean square %g, closed form %g, reach %g of %g\n", d, f, r, ortho ? "parallel" : "",
                          s.r2 / s.m[0][0], want, s.most, disc + ball);
            assert_true(fabs(s.r2 / s.m[0][0] / want - 1) < 0.05);
            assert_true(s.most < disc + ball + 1.5 * edge && s.most > disc - edge);
        }
}

/* The blur has the lens's corners: upside down behind what is sharp. */
static void blades(void **state)
{
    (void)state;
    for (uint32_t n = 3; n <= 6; n++) {
        moments s = blur_of(RT_CAMERA_PINHOLE, 0.3f, 3, 1, 0.8f, n);
        double radius = 0.8 * (1 - 1.0 / 3), scale = 1;
        for (int k = 1; k <= 6; k++) {
            scale *= radius;
            assert_true(k % (int)n == 0 ? moment(&s, k) / scale > 0.03 : moment(&s, k) / scale < 0.012);
        }
        assert_true(s.m[n][0] * cos(n * 1.57079632679) + s.m[n][1] * sin(n * 1.57079632679) > 0.0);
    }
}

/* ---- sums of still images ---- */

static int setup_balls(void **state)
{
    rt_material red, white;
    (void)state;
    stage(1);
    red = add_material(scene, v3(0.9f, 0.2f, 0.1f), 1, 0, 0, 1);
    white = add_material(scene, v3(0.8f, 0.8f, 0.8f), 0.9f, 0.1f, 0, 1);
    add_plane(scene, v3(0, -1, 0), v3(0, 1, 0), white);
    add_sphere(scene, v3(-0.8f, 0, -5), 1, red);
    add_sphere(scene, v3(0.9f, -0.4f, -2.6f), 0.5f, white);
    add_box(scene, v3(0.6f, -1, -9), v3(2, 1.5f, -8), red);
    set_world(scene, v3(0.3f, 0.4f, 0.5f), v3(0.7f, 0.8f, 0.9f));
    add_light(scene, light(RT_LIGHT_DIRECTIONAL, v3(-1, -2, -1), v3(0.8f, 0.8f, 0.8f), RT_FALLOFF_NONE));
    return 0;
}

typedef struct sum {
    uint32_t width, height;
    double *value, weight;
} sum;

static void sum_add(sum *s, const rt_image *image)
{
    const float *p = rt_image_pixels_const(image);
    if (!s->value) {
        s->width = rt_image_width(image);
        s->height = rt_image_height(image);
        s->value = calloc((size_t)s->width * s->height * 3, sizeof *s->value);
        assert_non_null(s->value);
    }
    for (size_t i = 0; i < (size_t)s->width * s->height; i++)
        for (int k = 0; k < 3; k++)
            s->value[3 * i + k] += p[4 * i + k];
    s->weight += 1;
}

/* Root mean square and mean of the difference of an image from the mean of the sum. */
static void compare(const sum *s, const rt_image *image, const char *what, double rms_limit, double mean_limit)
{
    const float *p = rt_image_pixels_const(image);
    size_t n = (size_t)s->width * s->height;
    double square = 0, mean = 0;
    for (size_t i = 0; i < n; i++)
        for (int k = 0; k < 3; k++) {
            double d = p[4 * i + k] - s->value[3 * i + k] / s->weight;
            square += d * d;
            mean += d;
        }
    square = sqrt(square / (double)(3 * n));
    mean /= (double)(3 * n);
    print_message("%s: root mean square %g, mean %g\n", what, square, mean);
    assert_true(square < rms_limit && fabs(mean) < mean_limit);
}

/* A square lens as wide as 13 pixels of shift: from the lens's point (i, j) the sharp plane is seen by a pinhole there, its
 * window moved by i and j pixels, which crop does. */
static void lens_is_a_sum_of_pinholes(void **state)
{
    enum { W = 48, H = 36, REACH = 6, M = 8 };
    rt_camera_desc c = rt_camera_desc_default();
    rt_render_desc rd = settings(W + 2 * M, H + 2 * M, 4, "whitted");
    rt_image *image, *pinhole;
    double focus = 4, pixel = 2 * tan(0.5 * 50 * 0.017453292519943295) / H;
    sum total = {0}, plain = {0};
    (void)state;
    c.look_at = v3(0, 0, -1);
    c.eye = v3(0, 0, 0);
    c.fov_deg = (float)(2 / 0.017453292519943295 * atan(0.5 * pixel * (H + 2 * M)));
    for (int j = -REACH; j <= REACH; j++)
        for (int i = -REACH; i <= REACH; i++) {
            c.eye = v3((float)(i * pixel * focus), (float)(j * pixel * focus), 0);
            c.look_at = v3(c.eye.x, c.eye.y, -1);
            OK(rt_scene_set_camera(scene, &c));
            OK(rt_scene_commit(scene, NULL));
            rd.crop = (rt_tile){(uint32_t)(M - i), (uint32_t)(M + j), W, H};
            image = render(scene, &rd);
            sum_add(&total, image);
            rt_image_destroy(image);
        }
    c = rt_camera_desc_default();
    c.look_at = v3(0, 0, -1);
    c.eye = v3(0, 0, 0);
    rd = settings(W, H, 256, "whitted");
    OK(rt_scene_set_camera(scene, &c));
    OK(rt_scene_commit(scene, NULL));
    pinhole = render(scene, &rd);
    sum_add(&plain, pinhole);
    c.aperture = (float)((REACH + 0.5) * pixel * focus * sqrt(2));
    c.focus_distance = (float)focus;
    c.blades = 4;
    c.blade_rotation_deg = 45;
    OK(rt_scene_set_camera(scene, &c));
    OK(rt_scene_commit(scene, NULL));
    image = render(scene, &rd);
    compare(&total, image, "a lens against 169 pinholes", 0.006, 0.001);
    sum_add(&plain, pinhole);
    assert_true(rt_image_width(image) == W);
    { /* and it is another image than the pinhole's */
        double most = 0;
        for (size_t i = 0; i < (size_t)4 * W * H; i++)
            most = fmax(most, fabs(rt_image_pixels_const(image)[i] - rt_image_pixels_const(pinhole)[i]));
        assert_true(most > 0.2);
    }
    free(total.value);
    free(plain.value);
    rt_image_destroy(image);
    rt_image_destroy(pinhole);
}

static rt_camera_desc camera_at(double t, rt_camera_type type)
{
    rt_camera_desc c = rt_camera_desc_default();
    double half = tan(0.5 * 40 * 0.017453292519943295) * (1 - t) + tan(0.5 * 60 * 0.017453292519943295) * t;
    c.type = type;
    c.eye = v3((float)(-0.4 + t), (float)(0.5 * t), (float)(1 - 0.3 * t));
    c.look_at = v3((float)(0.2 - 0.3 * t), (float)(-0.2 * t), -4);
    c.up = v3((float)(0.4 * t), 1, 0);
    c.fov_deg = (float)(2 / 0.017453292519943295 * atan(half));
    c.height = (float)(4 + t);
    return c;
}

static void moving_camera_is_a_sum_of_stills(void **state)
{
    enum { W = 48, H = 36, STILLS = 48 };
    static const float shutter[2][2] = {{0, 1}, {0.5f, 0.75f}};
    (void)state;
    for (int k = 0; k < 4; k += TEST_SANITIZED ? 3 : 1) {
        rt_camera_type type = k & 2 ? RT_CAMERA_ORTHOGRAPHIC : RT_CAMERA_PINHOLE;
        const float *open = shutter[k & 1];
        rt_render_desc rd = settings(W, H, 4, "whitted");
        rt_camera_desc c;
        rt_image *image;
        sum total = {0};
        for (int i = 0; i < STILLS; i++) {
            c = camera_at(open[0] + (i + 0.5) / STILLS * (open[1] - open[0]), type);
            OK(rt_scene_set_camera(scene, &c));
            OK(rt_scene_commit(scene, NULL));
            image = render(scene, &rd);
            sum_add(&total, image);
            rt_image_destroy(image);
        }
        c = camera_at(0, type);
        c.shutter_open = open[0];
        c.shutter_close = open[1];
        OK(rt_scene_set_camera(scene, &c));
        c = camera_at(1, type);
        OK(rt_scene_set_camera_motion(scene, &c));
        OK(rt_scene_commit(scene, NULL));
        rd.samples = 192;
        image = render(scene, &rd);
        compare(&total, image, "a moving camera against 48 stills", 0.012, 0.001);
        free(total.value);
        rt_image_destroy(image);
    }
}

static void commit_and_hash(const char *integrator, char hash[33])
{
    rt_render_desc rd = settings(40, 30, 4, integrator);
    OK(rt_scene_commit(scene, NULL));
    hash_of(&rd, hash);
}

/* Without an aperture the other numbers of a lens change no bit; nor do they change views of values, which show the middle. */
static void no_lens_is_a_pinhole(void **state)
{
    rt_camera_desc c = camera_at(0, RT_CAMERA_PINHOLE), back;
    char plain[33], other[33], depth[33];
    (void)state;
    OK(rt_scene_set_camera(scene, &c));
    commit_and_hash("whitted", plain);
    commit_and_hash("depth", depth);
    c.focus_distance = 3;
    c.blades = 6;
    c.blade_rotation_deg = 20;
    c.shutter_open = 0.25f;
    OK(rt_scene_set_camera(scene, &c));
    commit_and_hash("whitted", other);
    assert_string_equal(plain, other);
    c.aperture = 0.1f;
    OK(rt_scene_set_camera(scene, &c));
    commit_and_hash("whitted", other);
    assert_string_not_equal(plain, other);
    commit_and_hash("depth", other);
    assert_string_equal(depth, other);
    back = rt_camera_desc_default();
    OK(rt_scene_get_camera(scene, &back));
    assert_memory_equal(&back, &c, sizeof c);
    OK(rt_scene_get_camera_motion(scene, &back));
    assert_memory_equal(&back, &c, sizeof c);
    back.struct_size = 0xdeadbeef; /* whoever never set it gets what version 0.1.0 had */
    back.aperture = -7;
    OK(rt_scene_get_camera(scene, &back));
    assert_true(back.struct_size == offsetof(rt_camera_desc, aperture) && back.aperture == -7);
}

/* ---- what is refused ---- */

static void refusals(void **state)
{
    rt_camera_desc good = camera_at(0, RT_CAMERA_PINHOLE), c = good;
    char before[33], after[33];
    (void)state;
    OK(rt_scene_set_camera(scene, &good));
    OK(rt_scene_commit(scene, NULL));
    OK(rt_scene_hash(scene, before));
#define WITH(field, value, words)                                                                                                \
    c = good;                                                                                                                    \
    c.field = (value);                                                                                                           \
    KIT_REFUSED(ctx, rt_scene_set_camera(scene, &c), words)
    WITH(aperture, NAN, "aperture is nan");
    WITH(aperture, -1, "aperture is -1");
    WITH(aperture, INFINITY, "aperture is inf");
    WITH(focus_distance, -2, "focus_distance is -2");
    WITH(focus_distance, NAN, "focus_distance is nan");
    WITH(blades, 2, "blades is 2; it must be from 3 to 64");
    WITH(blades, 65, "blades is 65");
    WITH(blade_rotation_deg, INFINITY, "blade_rotation_deg is inf");
    WITH(shutter_close, -0.5f, "the shutter opens at 0 and closes at -0.5");
    WITH(shutter_close, 1.5f, "closes at 1.5");
    WITH(shutter_open, NAN, "opens at nan");
    c = good;
    c.shutter_open = 0.5f;
    c.shutter_close = 0.25f;
    KIT_REFUSED(ctx, rt_scene_set_camera(scene, &c),
                "opens at 0.5 and closes at 0.25; they must be times from 0 to 1, in this order");
    c = good;
    c.type = RT_CAMERA_ORTHOGRAPHIC;
    KIT_REFUSED(ctx, rt_scene_set_camera_motion(scene, &c), "type is not the camera's");
    c = good; /* looks back: half-way it looks nowhere */
    c.look_at = v3(2 * c.eye.x - c.look_at.x, 2 * c.eye.y - c.look_at.y, 2 * c.eye.z - c.look_at.z);
    KIT_REFUSED(ctx, rt_scene_set_camera_motion(scene, &c), "eye and look_at meet");
    c = good; /* stands on its head: half-way it has no up */
    c.up = v3(0, -1, 0);
    KIT_REFUSED(ctx, rt_scene_set_camera_motion(scene, &c), "it looks along its up");
    c = good;
    c.eye.x = NAN;
    KIT_REFUSED(ctx, rt_scene_set_camera_motion(scene, &c), "eye is (nan");
    OK(rt_scene_commit(scene, NULL));
    OK(rt_scene_hash(scene, after));
    assert_string_equal(before, after);
    c = camera_at(1, RT_CAMERA_PINHOLE);
    OK(rt_scene_set_camera_motion(scene, &c));
    OK(rt_scene_commit(scene, NULL));
    OK(rt_scene_hash(scene, after));
    assert_string_not_equal(before, after);
    OK(rt_scene_set_camera_motion(scene, NULL));
    OK(rt_scene_commit(scene, NULL));
    OK(rt_scene_hash(scene, after));
    assert_string_equal(before, after);
}

/* A saved camera renders the same bits and describes itself. */
static void saved(void **state)
{
    rt_scene *again;
    rt_camera_desc c = camera_at(0, RT_CAMERA_PINHOLE), d = camera_at(1, RT_CAMERA_PINHOLE), got = c;
    char here[33], there[33], path[] = "test_camera.rts";
    rt_render_desc rd = settings(40, 30, 4, "whitted");
    rt_image *image;
    (void)state;
    c.aperture = 0.2f;
    d.aperture = 0.1f;
    c.blades = 5;
    c.shutter_close = 0.75f;
    OK(rt_scene_set_camera(scene, &c));
    OK(rt_scene_set_camera_motion(scene, &d));
    commit_and_hash("whitted", here);
    OK(rt_scene_save(scene, path));
    OK(rt_scene_load(ctx, path, &again));
    image = render(again, &rd);
    rt_image_hash(image, there);
    assert_string_equal(here, there);
    OK(rt_scene_get_camera(again, &got));
    assert_true(got.aperture == 0.2f && got.blades == 5 && got.shutter_close == 0.75f && got.eye.x == c.eye.x);
    got = c;
    OK(rt_scene_get_camera_motion(again, &got));
    assert_true(got.aperture == 0.1f && got.eye.x == d.eye.x && fabsf(got.look_at.z - d.look_at.z) < 1e-6f);
    remove(path);
    rt_image_destroy(image);
    rt_scene_destroy(again);
}

/* A still one, far from the middle: from what a loaded scene tells of it, another comes to look the same way. */
static void saved_far_away(void **state)
{
    rt_scene *again;
    rt_camera_desc c = rt_camera_desc_default(), got = c;
    char path[] = "test_camera_far.rts";
    (void)state;
    c.eye = (rt_vec3){1.0e6f, -3.0e6f, 2.0e5f};
    c.look_at = (rt_vec3){1.0e6f + 800.0f, -3.0e6f + 300.0f, 2.0e5f - 500.0f};
    OK(rt_scene_set_camera(scene, &c));
    OK(rt_scene_commit(scene, NULL));
    OK(rt_scene_save(scene, path));
    OK(rt_scene_load(ctx, path, &again));
    OK(rt_scene_get_camera(again, &got));
    const double x = got.look_at.x - (double)got.eye.x, y = got.look_at.y - (double)got.eye.y,
                 z = got.look_at.z - (double)got.eye.z;
    assert_true(x > 0.0 && fabs(y / x - 0.375) < 1e-6 && fabs(z / x + 0.625) < 1e-6);
    remove(path);
    rt_scene_destroy(again);
}

static int setup_empty(void **state)
{
    (void)state;
    return stage(1);
}

#define T(name, setup) cmocka_unit_test_setup_teardown(name, setup, teardown)
int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lens_shapes),
        T(circle_of_confusion, setup_empty),
        T(blades, setup_empty),
        T(lens_is_a_sum_of_pinholes, setup_balls),
        T(moving_camera_is_a_sum_of_stills, setup_balls),
        T(no_lens_is_a_pinhole, setup_balls),
        T(refusals, setup_empty),
        T(saved, setup_balls),
        T(saved_far_away, setup_empty),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
