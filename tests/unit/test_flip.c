/* FLIP against closed forms and against the paper's formulas written out: filters of two dimensions, summed pixel by pixel with
 * the C library's functions. */
#include "../support/fixture.h"

#include <math.h>
#include <string.h>

#include "librt/draw.h"
#include "librt/image.h"
#include "render/power.h"
#include "scene/import/srgb.h"

/* ---- the paper, by hand ---- */

#define PI 3.14159265358979323846

typedef struct picture {
    int width, height;
    const float *p; /* [height][width][4] linear */
} picture;

static const double matrix[3][3] = {
    {0.412386564, 0.357591491, 0.180450487}, {0.212636822, 0.715182981, 0.072180196}, {0.019330620, 0.119197164, 0.950372587}};
/* The matrix's inverse, to nine digits, as the literature prints it. */
static const double inverse[3][3] = {{3.241003275, -1.537398934, -0.498615861},
                                     {-0.969224334, 1.875930071, 0.041554224},
                                     {0.055639423, -0.204011202, 1.057148933}};
static const double white[3] = {0.950428545, 1.0, 1.088900371};

static void xyz(const double c[3], double to[3])
{
    for (int i = 0; i < 3; i++)
        to[i] = matrix[i][0] * c[0] + matrix[i][1] * c[1] + matrix[i][2] * c[2];
}

static void ycc(const picture *p, int x, int y, double to[3])
{
    x = x < 0 ? 0 : x >= p->width ? p->width - 1 : x;
    y = y < 0 ? 0 : y >= p->height ? p->height - 1 : y;
    const float *f = p->p + 4 * ((size_t)y * (size_t)p->width + (size_t)x);
    double c[3] = {fmin(fmax((double)f[0], 0), 1), fmin(fmax((double)f[1], 0), 1), fmin(fmax((double)f[2], 0), 1)}, v[3];
    xyz(c, v);
    to[0] = 116 * v[1] / white[1] - 16;
    to[1] = 500 * (v[0] / white[0] - v[1] / white[1]);
    to[2] = 200 * (v[1] / white[1] - v[2] / white[2]);
}

static double curve(double x)
{
    return x > 216.0 / 24389.0 ? cbrt(x) : x * 841.0 / 108.0 + 4.0 / 29.0;
}

static void hunt(const double c[3], double lab[3])
{
    double v[3];
    xyz(c, v);
    for (int i = 0; i < 3; i++)
        v[i] = curve(v[i] / white[i]);
    lab[0] = 116 * v[1] - 16;
    lab[1] = 0.01 * lab[0] * 500 * (v[0] - v[1]);
    lab[2] = 0.01 * lab[0] * 200 * (v[1] - v[2]);
}

static double csf(int channel, double x2)
{
    static const double a[3][2] = {{1, 0}, {1, 0}, {34.1, 13.5}}, b[3][2] = {{0.0047, 1e-5}, {0.0053, 1e-5}, {0.04, 0.025}};
    double sum = 0;
    for (int i = 0; i < 2; i++)
        sum += a[channel][i] * sqrt(PI / b[channel][i]) * exp(-PI * PI * x2 / b[channel][i]);
    return sum;
}

static void seen(const picture *p, int x, int y, double ppd, double lab[3])
{
    int r = (int)ceil(3 * sqrt(0.04 / (2 * PI * PI)) * ppd);
    double sum[3] = {0}, total[3] = {0}, v[3], c[3];
    for (int j = -r; j <= r; j++) {
        for (int i = -r; i <= r; i++) {
            double here[3];
            ycc(p, x + i, y + j, here);
            for (int k = 0; k < 3; k++) {
                double w = csf(k, (i * i + j * j) / (ppd * ppd));
                sum[k] += w * here[k];
                total[k] += w;
            }
        }
    }
    for (int k = 0; k < 3; k++)
        sum[k] /= total[k];
    v[1] = (sum[0] + 16) / 116 * white[1];
    v[0] = ((sum[0] + 16) / 116 + sum[1] / 500) * white[0];
    v[2] = ((sum[0] + 16) / 116 - sum[2] / 200) * white[2];
    for (int i = 0; i < 3; i++)
        c[i] = fmin(fmax(inverse[i][0] * v[0] + inverse[i][1] * v[1] + inverse[i][2] * v[2], 0), 1);
    hunt(c, lab);
}

/* kind 1: first derivative, 2: second */
static double strength(const picture *p, int x, int y, double ppd, int kind)
{
    double sd = 0.5 * 0.082 * ppd, plus = 0, minus = 0, sum[2] = {0};
    int r = (int)ceil(3 * sd);
    for (int pass = 0; pass < 2; pass++) {
        for (int j = -r; j <= r; j++) {
            for (int i = -r; i <= r; i++) {
                double g = exp(-(i * i + j * j) / (2 * sd * sd)), here[3];
                double wx = kind == 1 ? -i * g : (i * i / (sd * sd) - 1) * g;
                double wy = kind == 1 ? -j * g : (j * j / (sd * sd) - 1) * g;
                if (pass == 0) {
                    plus += wx > 0 ? wx : 0;
                    minus -= wx < 0 ? wx : 0;
                    continue;
                }
                ycc(p, x + i, y + j, here);
                sum[0] += (here[0] + 16) / 116 * wx / (wx > 0 ? plus : minus);
                sum[1] += (here[0] + 16) / 116 * wy / (wy > 0 ? plus : minus);
            }
        }
    }
    return hypot(sum[0], sum[1]);
}

static double by_hand(const picture *a, const picture *b, int x, int y, double ppd)
{
    const double green[3] = {0, 1, 0}, blue[3] = {0, 0, 1};
    double la[3], lb[3], g[3], h[3], most, d, edge, point, f;
    hunt(green, g);
    hunt(blue, h);
    most = pow(fabs(g[0] - h[0]) + hypot(g[1] - h[1], g[2] - h[2]), 0.7);
    seen(a, x, y, ppd, la);
    seen(b, x, y, ppd, lb);
    d = pow(fabs(la[0] - lb[0]) + hypot(la[1] - lb[1], la[2] - lb[2]), 0.7);
    d = d < 0.4 * most ? 0.95 / (0.4 * most) * d : 0.95 + (d - 0.4 * most) / (0.6 * most) * 0.05;
    edge = fabs(strength(a, x, y, ppd, 1) - strength(b, x, y, ppd, 1));
    point = fabs(strength(a, x, y, ppd, 2) - strength(b, x, y, ppd, 2));
    f = sqrt(fmax(edge, point) / sqrt(2));
    return pow(d, 1 - f);
}

/* ---- pictures ---- */

typedef void (*color_fn)(uint32_t x, uint32_t y, double rgb[3]);

static rt_image *make(uint32_t width, uint32_t height, color_fn color)
{
    rt_image *image;
    assert_int_equal(rt_image_create(test.ctx, width, height, &image), RT_OK);
    float *p = rt_image_pixels(image);
    for (uint32_t i = 0; i < width * height; i++, p += 4) {
        double c[3];
        color(i % width, i / width, c);
        for (int k = 0; k < 3; k++)
            p[k] = (float)c[k];
    }
    return image;
}

static double hash(uint32_t x, uint32_t y, uint32_t k)
{
    uint32_t h = x * 73856093u ^ y * 19349663u ^ k * 83492791u;
    h = (h ^ h >> 15) * 2246822519u;
    return (double)((h ^ h >> 13) & 0xffffu) / 65535.0;
}

static void noise(uint32_t x, uint32_t y, double c[3])
{
    for (uint32_t k = 0; k < 3; k++)
        c[k] = hash(x, y, k);
}

static void waves(uint32_t x, uint32_t y, double c[3])
{
    c[0] = 0.5 + 0.6 * sin(0.7 * x) * cos(0.4 * y); /* beyond 0 ... 1, too */
    c[1] = x > 8 ? 0.8 : 0.1;
    c[2] = 0.3 + 0.2 * sin(0.9 * y);
}

static void black(uint32_t x, uint32_t y, double c[3])
{
    (void)x;
    (void)y;
    c[0] = c[1] = c[2] = 0;
}

static void all_white(uint32_t x, uint32_t y, double c[3])
{
    (void)x;
    (void)y;
    c[0] = c[1] = c[2] = 1;
}

static void green(uint32_t x, uint32_t y, double c[3])
{
    black(x, y, c);
    c[1] = 1;
}

static void blue(uint32_t x, uint32_t y, double c[3])
{
    black(x, y, c);
    c[2] = 1;
}

static double amount; /* of what is added to the waves */

static void noisy(uint32_t x, uint32_t y, double c[3])
{
    waves(x, y, c);
    for (uint32_t k = 0; k < 3; k++)
        c[k] += amount * (hash(x, y, k) - 0.5);
}

static double flip_of(const rt_image *a, const rt_image *b)
{
    double d = NAN;
    assert_int_equal(rt_image_flip(a, b, 0, &d, NULL), RT_OK);
    return d;
}

/* ---- tests ---- */

static void test_powers(void **state)
{
    (void)state;
    for (double x = -690; x < 690; x += 0.73)
        assert_true(fabs(rti_math_exp(x) / exp(x) - 1) < 3e-15);
    for (double x = 1e-12; x < 1e12; x *= 1.37) {
        assert_true(fabs(rti_math_log(x) - log(x)) <= 1e-15 * (1 + fabs(log(x))));
        assert_true(fabs(rti_math_pow(x, 0.7) / pow(x, 0.7) - 1) < 2e-14);
    }
    assert_true(rti_math_pow(0, 0.7) == 0 && rti_math_exp(0) == 1 && rti_math_log(1) == 0 && rti_math_exp(-800) == 0);
}

static void test_closed_forms(void **state)
{
    rt_image *n = make(40, 30, noise), *w = make(40, 30, waves), *b = make(40, 30, black), *l = make(40, 30, all_white);
    rt_image *g = make(40, 30, green), *u = make(40, 30, blue), *map;
    double d, most = 41.2760, before = 0;
    (void)state;
    assert_true(flip_of(n, n) == 0 && flip_of(w, w) == 0);
    assert_true(fabs(flip_of(g, u) - 1) < 1e-9); /* by its definition the largest difference of colours */
    /* Even pictures have no edges: lightness 100 against 0, by the paper's curve. */
    assert_true(fabs(flip_of(b, l) - (0.95 + (pow(100, 0.7) - 0.4 * most) / (0.6 * most) * 0.05)) < 1e-4);
    assert_true(flip_of(n, w) == flip_of(w, n));
    for (amount = 0.01; amount < 1; amount *= 2) {
        rt_image *v = make(40, 30, noisy);
        d = flip_of(w, v);
        assert_true(d > before && d < 1);
        before = d;
        rt_image_destroy(v);
    }
    assert_int_equal(rt_image_flip(n, w, 0, &d, &map), RT_OK); /* the mean is the map's */
    const float *p = rt_image_pixels(map);
    double sum = 0;
    for (uint32_t i = 0; i < 40 * 30; i++) {
        assert_true(p[4 * i] >= 0 && p[4 * i] <= 1 && p[4 * i + 1] == p[4 * i] && p[4 * i + 3] == 1);
        sum += (double)p[4 * i];
    }
    assert_true(fabs(sum / 1200 - d) < 1e-7);
    rt_image_destroy(map);
    rt_image_destroy(n);
    rt_image_destroy(w);
    rt_image_destroy(b);
    rt_image_destroy(l);
    rt_image_destroy(g);
    rt_image_destroy(u);
}

static void against_hand(uint32_t width, uint32_t height, color_fn f, color_fn g, double ppd)
{
    rt_image *a = make(width, height, f), *b = make(width, height, g), *map;
    picture pa = {(int)width, (int)height, rt_image_pixels(a)}, pb = {(int)width, (int)height, rt_image_pixels(b)};
    double got;
    assert_int_equal(rt_image_flip(a, b, ppd, &got, &map), RT_OK);
    for (uint32_t y = 0; y < height; y++) {
        for (uint32_t x = 0; x < width; x++) {
            double want = by_hand(&pa, &pb, (int)x, (int)y, ppd), is = (double)rt_image_pixels(map)[4 * (y * width + x)];
            if (!(fabs(is - want) < 2e-5))
                fail_msg("%u x %u, %g pixels a degree, at %u, %u: %g, not %g", width, height, ppd, x, y, is, want);
        }
    }
    rt_image_destroy(a);
    rt_image_destroy(b);
    rt_image_destroy(map);
}

static void test_against_hand(void **state)
{
    (void)state;
    amount = 0.2;
    against_hand(19, 14, waves, noisy, 67.0206432765823);
    against_hand(24, 17, noise, waves, 20);
    against_hand(9, 30, waves, noise, 33.3);
    against_hand(3, 2, noise, noisy, 50);
    against_hand(1, 1, noise, waves, 67);
    against_hand(12, 9, waves, noisy, 1);
}

static void test_odd_values(void **state)
{
    rt_image *a = make(6, 5, waves), *b = make(6, 5, waves);
    (void)state;
    rt_image_pixels(a)[40] = NAN;
    rt_image_pixels(b)[40] = 0;
    rt_image_pixels(a)[44] = INFINITY;
    rt_image_pixels(b)[44] = 1;
    assert_true(flip_of(a, b) == 0);
    rt_image_destroy(a);
    rt_image_destroy(b);
}

static void test_refused(void **state)
{
    rt_image *a = make(3, 2, noise), *b = make(2, 3, noise), *map = a;
    double d;
    (void)state;
    assert_int_equal(rt_image_flip(a, b, 0, &d, &map), RT_ERROR_ARGUMENT);
    assert_null(map);
    test_says(&test, "3 x 2 and 2 x 3");
    for (int i = 0; i < 4; i++) {
        assert_int_equal(rt_image_flip(a, a, (double[]){-1, 0.5, 1001, NAN}[i], &d, &map), RT_ERROR_ARGUMENT);
        test_says(&test, "1 ... 1000");
    }
    for (test.fail_at = 1; test.fail_at < 10; test.fail_at++) { /* image and its pixels, seven buffers */
        test.calls = 0;
        assert_int_equal(rt_image_flip(a, a, 0, &d, &map), RT_ERROR_MEMORY);
        assert_null(map);
    }
    test.fail_at = 0;
    rt_image_destroy(a);
    rt_image_destroy(b);
}

/* The quarters of the maps as their authors' tables of five colours have them. */
static void test_color_maps(void **state)
{
    static const int viridis[5][3] = {{68, 1, 84}, {59, 82, 139}, {33, 144, 140}, {93, 200, 99}, {253, 231, 37}};
    static const int magma[5][3] = {{0, 0, 4}, {81, 18, 124}, {182, 54, 121}, {251, 136, 97}, {252, 253, 191}};
    double light[3] = {-1, -1, -1};
    rt_image *n = make(8, 8, noise), *map;
    (void)state;
    for (int i = 0; i < 5; i++) {
        rt_vec3 v = rt_color_map_at(RT_COLOR_MAP_VIRIDIS, (float)i / 4), m = rt_color_map_at(RT_COLOR_MAP_MAGMA, (float)i / 4);
        const float got[2][3] = {{v.x, v.y, v.z}, {m.x, m.y, m.z}};
        for (int k = 0; k < 3; k++) {
            assert_true(fabs(255 * rti_srgb_encode((double)got[0][k]) - viridis[i][k]) < 4);
            assert_true(fabs(255 * rti_srgb_encode((double)got[1][k]) - magma[i][k]) < 4);
        }
    }
    for (int i = 0; i <= 1000; i++) {
        for (int m = 0; m < 3; m++) { /* lightness rises */
            rt_vec3 c = rt_color_map_at((rt_color_map)m, (float)i / 1000);
            double y = 0.2126 * (double)c.x + 0.7152 * (double)c.y + 0.0722 * (double)c.z;
            assert_true(y > light[m] - 1e-9);
            light[m] = y;
        }
    }
    rt_vec3 nan = rt_color_map_at(RT_COLOR_MAP_MAGMA, NAN), zero = rt_color_map_at(RT_COLOR_MAP_MAGMA, -3);
    assert_memory_equal(&nan, &zero, sizeof nan);
    assert_int_equal(rt_image_color_map(n, RT_COLOR_MAP_VIRIDIS, 0.25f, 0.75f, &map), RT_OK);
    const float *p = rt_image_pixels(n), *q = rt_image_pixels(map);
    for (int i = 0; i < 64; i++, p += 4, q += 4) {
        rt_vec3 c = rt_color_map_at(RT_COLOR_MAP_VIRIDIS, (fmaxf(p[0], fmaxf(p[1], p[2])) - 0.25f) / 0.5f);
        assert_true(q[0] == c.x && q[1] == c.y && q[2] == c.z && q[3] == p[3]);
    }
    rt_image_destroy(map);
    assert_int_equal(rt_image_color_map(n, RT_COLOR_MAP_VIRIDIS, 1, 1, &map), RT_ERROR_ARGUMENT);
    test_says(&test, "low must be below high");
    assert_null(map);
    rt_image_destroy(n);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_powers, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_closed_forms, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_against_hand, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_odd_values, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_refused, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_color_maps, test_setup, test_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
