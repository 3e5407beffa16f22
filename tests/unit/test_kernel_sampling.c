/* Sampled directions and filters: means against closed forms, densities against counts. */
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <setjmp.h>
#include <cmocka.h>

#include "kernel/filter.h"
#include "kernel/lights.h"
#include "kernel/sampling.h"
#include "kernel_random.h"
#include "kernel_alone.h"

enum { N = 1 << 16 };

/* Stratified, so that means are good to about 1 / N. */
static rtk_uv pair(uint32_t i)
{
    return rtk_random2(rtk_vertex_seed(1, 2, rtk_key_root()), i, RTK_DIM_BSDF_U);
}

static void bases_are_orthonormal(void **state)
{
    (void)state;
    rng g = {1};
    for (int i = 0; i < 100000; i++) {
        rtk_vec3 n = rng_dir(&g), x, y;
        if (i % 3 == 0) /* close to the poles, where the textbook formula breaks */
            n = rtk_unit(rtk_v3(n.x * 1e-6f, n.y * 1e-6f, i % 2 ? 1.0f : -1.0f));
        if (i % 300 == 0)
            n = rtk_v3(0, i % 600 ? 0.0f : -0.0f, i % 900 ? 1.0f : -1.0f);
        rtk_basis(n, &x, &y);
        assert_true(fabsf(rtk_len(x) - 1) < 5e-7f && fabsf(rtk_len(y) - 1) < 5e-7f);
        assert_true(fabsf(rtk_dot3(x, y)) < 5e-7f && fabsf(rtk_dot3(x, n)) < 5e-7f && fabsf(rtk_dot3(y, n)) < 5e-7f);
        assert_true(rtk_dot3(rtk_cross3(x, y), n) > 0.999f); /* right-handed */
    }
}

static void cosine_directions(void **state)
{
    (void)state;
    rng g = {2};
    for (int k = 0; k < 8; k++) {
        rtk_vec3 n = rng_dir(&g), x, y;
        double c1 = 0, c2 = 0, sx = 0, sy = 0, inverse = 0;
        rtk_basis(n, &x, &y);
        for (uint32_t i = 0; i < N; i++) {
            rtk_vec3 d = rtk_cosine_direction(n, pair(i));
            float c = rtk_dot3(d, n);
            assert_true(c > -1e-6f && fabsf(rtk_len(d) - 1) < 5e-7f);
            c1 += c;
            c2 += (double)c * c;
            sx += rtk_dot3(d, x);
            sy += rtk_dot3(d, y);
            if (c > 0.2f) /* a region's solid angle: the mean of 1 / pdf over it is 2 pi (1 - 0.2) */
                inverse += 1 / (double)rtk_cosine_pdf(c);
        }
        assert_true(fabs(c1 / N - 2.0 / 3) < 1e-4 && fabs(c2 / N - 0.5) < 1e-4);
        assert_true(fabs(sx / N) < 1e-3 && fabs(sy / N) < 1e-3);
        assert_true(fabs(inverse / N / (2 * 3.14159265358979 * 0.8) - 1) < 1e-3);
    }
    assert_true(rtk_cosine_pdf(-0.5f) == 0.0f);
}

/* The way without branches: the same bits, or it says that it is not one; which it does where a quadrant begins, and seldom else.
 */
static void plain_directions_are_the_same(void **state)
{
    (void)state;
    rng g = {4};
    int others = 0;
    for (uint32_t i = 0; i < 8 * N; i++) {
        rtk_vec3 n = rng_dir(&g), d, plain;
        rtk_uv u = pair(i % N);
        if (i % 5 == 0) /* about a quadrant's beginning */
            u.y = rtk_clamp(0.25f * (float)(i % 4) + 1e-4f * (rng_unit(&g) - 0.5f), 0.0f, 0.99999994f);
        if (i % 7 == 0)
            n = i % 2 ? rtk_v3(0, 0, -1) : rtk_v3(-0.0f, 1, -0.0f);
        if (!rtk_cosine_direction_plain(n, u, &plain)) {
            others++;
            assert_true(fabs(4.0 * (double)u.y - floor(4.0 * (double)u.y + 0.5)) < 1e-3);
            continue;
        }
        d = rtk_cosine_direction(n, u);
        assert_true(rtk_bits(d.x) == rtk_bits(plain.x) && rtk_bits(d.y) == rtk_bits(plain.y) &&
                    rtk_bits(d.z) == rtk_bits(plain.z));
    }
    assert_true(others > 1000);
    for (uint32_t i = 0; i < 8 * N; i++) { /* all up to 4096 */
        float x = rng_unit(&g) * (i % 2 ? 7.0f : 4096.0f), s, c, sine, cosine;
        rtk_sincos(x, &s, &c);
        if (rtk_sincos_plain(x, &sine, &cosine))
            assert_true(rtk_bits(s) == rtk_bits(sine) && rtk_bits(c) == rtk_bits(cosine));
    }
}

static void cones_are_uniform(void **state)
{
    (void)state;
    static const float sine2[] = {1e-10f, 1e-4f, 0.25f, 0.99f, 1.0f};
    rng g = {3};
    for (int k = 0; k < 6; k++) {
        rtk_vec3 w = rng_dir(&g);
        float height = k < 5 ? rtk_cone_height(sine2[k]) : 2.0f;
        long double want = k < 5 ? 1 - sqrtl(1 - (long double)sine2[k]) : 2;
        double sum = 0, sine = 0;
        if (k < 5)
            assert_true(fabsl(height - want) <= 3e-7L * want + 1e-7L * (k == 4));
        for (uint32_t i = 0; i < N; i++) {
            rtk_uv u = pair(i);
            rtk_vec3 d = rtk_cone_direction(w, u.x * height, u.y), c = rtk_cross3(d, w);
            double s2 = rtk_dot3(c, c);
            sum += rtk_dot3(d, w);
            sine += s2;
            assert_true(k >= 3 || sqrt(s2) <= sqrt(sine2[k]) + 3e-7);
        }
        /* uniform in height: mean cos = 1 - h / 2, mean sin^2 = h - h^2 / 3 */
        assert_true(fabs(sum / N - (1 - height / 2)) < 1e-4);
        assert_true(fabs(sine / N - (height - height * height / 3)) < 1e-3 * height);
        assert_true(fabs(rtk_cone_pdf(height) * 2 * 3.14159265358979 * height - 1) < 1e-6);
    }
}

/* Directions towards a spherical light end on its near side, where the distance says; from inside, on its far side. */
static void sphere_lights_are_touched(void **state)
{
    (void)state;
    rng g = {4};
    for (int i = 0; i < 100000; i++) {
        rtk_light l = {0};
        rtk_vec3 p = rng_vec(&g, i % 4 == 0 ? 0.3f : 100.0f);
        l.type = RTK_LIGHT_SPHERE;
        l.radius = 0.6f;
        l.falloff = 2.0f;
        l.color[0] = 1.0f;
        rtk_light_sample s = rtk_light_toward(&l, p, rng_unit(&g), rng_unit(&g));
        long double q[3] = {p.x + (long double)s.distance * s.dir.x, p.y + (long double)s.distance * s.dir.y,
                            p.z + (long double)s.distance * s.dir.z};
        long double r = sqrtl(q[0] * q[0] + q[1] * q[1] + q[2] * q[2]), d = rtk_len(p);
        assert_true(fabsl(r - l.radius) < 1e-5L * (1 + d));
        assert_true(s.distance <= sqrtl(d * d + 0.36L) * 1.00001L || d < 0.6L);
        /* the weight that a uniform cone gives: radiance * solid angle / pi = 1 * (1 / pdf) / pi */
        assert_true(fabsf(s.e.x * s.pdf * RTK_PI - 1) < 1e-5f);
        assert_true(s.pdf == rtk_light_pdf(&l, p));
    }
}

static void lights_are_chosen_by_power(void **state)
{
    (void)state;
    static rtk_light lights[5];
    const float share[5] = {0.1f, 0.0f, 0.4f, 0.3f, 0.2f};
    int count[5] = {0};
    float sum = 0;
    for (int i = 0; i < 5; i++) {
        sum += share[i];
        lights[i].select_cdf = i == 4 ? 1.0f : sum;
    }
    for (uint32_t i = 0; i < N; i++)
        count[rtk_light_choose(lights, 5, pair(i).x)]++;
    for (int i = 0; i < 5; i++)
        assert_true(fabs((double)count[i] / N - share[i]) < 1e-4);
    assert_int_equal(count[1], 0);
}

static void filters_have_their_moments(void **state)
{
    (void)state;
    const double width = 1.5, sigma = width / 4;
    double box = 0, gauss = 0, far = 0, mean = 0;
    for (uint32_t i = 0; i < N; i++) {
        rtk_uv b = rtk_filter_box(pair(i), 2.0f), o = rtk_filter_gaussian(pair(i), (float)width);
        double r2 = (double)o.x * o.x + (double)o.y * o.y;
        assert_true(b.x >= -1 && b.x < 1 && b.y >= -1 && b.y < 1);
        box += (double)b.x * b.x;
        gauss += r2;
        mean += o.x + o.y;
        far = r2 > far ? r2 : far;
    }
    assert_true(fabs(box / N - 4.0 / 12) < 1e-4);
    assert_true(sqrt(far) <= width);
    /* r^2 / (2 sigma^2) is exponential, cut at 8 */
    assert_true(fabs(gauss / N / (2 * sigma * sigma) - (1 - 8 * exp(-8) / (1 - exp(-8)))) < 1e-3);
    assert_true(fabs(mean / N) < 1e-3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bases_are_orthonormal),         cmocka_unit_test(cosine_directions),
        cmocka_unit_test(plain_directions_are_the_same), cmocka_unit_test(cones_are_uniform),
        cmocka_unit_test(sphere_lights_are_touched),     cmocka_unit_test(lights_are_chosen_by_power),
        cmocka_unit_test(filters_have_their_moments),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
