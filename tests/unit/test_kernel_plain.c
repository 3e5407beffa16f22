/* What loops over lanes call instead of functions with branches: the same bits, or they say that they are not the ones. And they
 * do so seldom. */
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <setjmp.h>
#include <cmocka.h>

#include "kernel/classic.h"
#include "kernel/lights.h"
#include "kernel_random.h"

enum { N = 1000000 };

static int same(float a, float b)
{
    return rtk_bits(a) == rtk_bits(b) || (a != a && b != b);
}
static int same3(rtk_vec3 a, rtk_vec3 b)
{
    return same(a.x, b.x) && same(a.y, b.y) && same(a.z, b.z);
}

static float any(rng *g)
{
    return rtk_float(rng_u32(g));
}

static void powers(void **state)
{
    const float edges[] = {
        0.0f,   -0.0f,   1.0f,  0.99999994f, 1.0000001f, 1e10f,      1.0000001e10f, 1.4e-45f,   1.17549435e-38f, 1.17549421e-38f,
        3e38f,  RTK_INF, -1.0f, 1e-30f,      126.0f,     127.99999f, 128.0f,        128.00002f, 149.0f,          150.5f,
        152.0f, 2.0f,    0.5f,  RTK_NAN,     41.0f};
    enum { EDGES = sizeof edges / sizeof *edges };
    rng g = {1};
    uint32_t other = 0;
    (void)state;
    for (uint32_t i = 0; i < 3 * N; i++) {
        float x, y, plain;
        if (i < EDGES * EDGES)
            x = edges[i / EDGES], y = edges[i % EDGES];
        else if (i % 3 == 0) /* what highlights ask */
            x = i % 2 ? rng_unit(&g) : 1.0f + 6e-7f * (rng_unit(&g) - 0.5f), y = rng_unit(&g) * (i % 5 ? 300.0f : 1e6f);
        else if (i % 3 == 1)
            x = any(&g), y = any(&g);
        else
            x = rtk_fabs(any(&g)), y = rng_unit(&g) * 100.0f;
        if (rtk_pow_plain(x, y, &plain)) {
            if (!same(rtk_pow(x, y), plain))
                fail_msg("%.9g ^ %.9g is %.9g, plainly %.9g", x, y, rtk_pow(x, y), plain);
        } else {
            other += i % 3 == 0 && i >= EDGES * EDGES;
        }
    }
    assert_true(other < N / 100);
}

static void highlights(void **state)
{
    rng g = {2};
    uint32_t other = 0;
    (void)state;
    for (uint32_t i = 0; i < N; i++) {
        const rtk_vec3 n = rng_dir(&g), l = rng_dir(&g), aside = rng_vec(&g, i % 5 ? 1.0f : 1e-6f);
        const rtk_vec3 v = i % 7 == 0 ? rtk_neg(l) : i % 7 == 1 ? l : rtk_unit(rtk_add(rtk_reflect(rtk_neg(l), n), aside));
        const float shininess = i % 11 == 0 ? 0.0f : i % 3 ? 400.0f * rng_unit(&g) : rtk_fabs(any(&g));
        float plain;
        if (rtk_highlight_plain(shininess, n, l, v, &plain))
            assert_true(same(rtk_highlight(shininess, n, l, v), plain));
        else
            other += i % 3 != 0 && i % 7 != 0;
    }
    assert_true(other < N / 1000);
}

/* Shading normals up to a right angle and beyond from the geometric one, glass from both sides, total reflection. */
static void bends(void **state)
{
    rng g = {3};
    uint32_t other = 0, count[2] = {0};
    (void)state;
    for (uint32_t i = 0; i < N; i++) {
        const rtk_vec3 ng = rng_dir(&g), aside = rng_vec(&g, i % 4 ? 0.5f : 3.0f);
        const rtk_vec3 ns = i % 3 ? rtk_unit(rtk_add(ng, aside)) : ng, d = i % 17 ? rng_dir(&g) : rtk_neg(ng);
        const float ratio = i % 19 == 0 ? 1.0f : i % 2 ? 0.4f + 0.6f * rng_unit(&g) : 1.0f + 1.5f * rng_unit(&g);
        rtk_vec3 a = {0, 0, 0}, b;
        int through;
        if (rtk_bend_plain(d, ns, ng, ratio, &b, &through)) {
            assert_int_equal(rtk_bend(d, ns, ng, ratio, &a), through);
            assert_true(!through || same3(a, b));
            count[through]++;
        } else {
            other++;
        }
    }
    assert_true(other < N / 1000 && count[0] > N / 100 && count[1] > N / 10);
}

static void spheres(void **state)
{
    rng g = {4};
    uint32_t other = 0;
    (void)state;
    for (uint32_t i = 0; i < N; i++) {
        rtk_light l = {.type = RTK_LIGHT_SPHERE, .radius = i % 5 ? rng_unit(&g) : 1e-6f, .falloff = i % 2 ? 2.0f : 0.0f};
        const rtk_vec3 at = rng_vec(&g, 1.0f), off = rng_vec(&g, i % 4 ? 3.0f : i % 8 ? 0.01f : 0.0f), p = rtk_add(at, off);
        const float u = i % 31 ? rng_unit(&g) : 0.0f, v = i % 29 ? rng_unit(&g) : 0.0f;
        rtk_light_sample a, b;
        l.at[0] = at.x;
        l.at[1] = at.y;
        l.at[2] = at.z;
        l.color[0] = l.color[1] = l.color[2] = rng_unit(&g);
        if (rtk_light_sphere_plain(&l, p, u, v, &b)) {
            a = rtk_light_sphere(&l, p, u, v);
            assert_true(same3(a.dir, b.dir) && same3(a.e, b.e) && same(a.distance, b.distance) && same(a.pdf, b.pdf));
        } else {
            other += i % 8 != 0;
        }
    }
    assert_true(other < N / 100);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(powers), cmocka_unit_test(highlights), cmocka_unit_test(bends),
                                       cmocka_unit_test(spheres)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
