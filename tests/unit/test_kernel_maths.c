/* The kernel's elementary functions and doubled floats against long double; the bounds are those stated in maths.h, twofloat.h.
 */
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <float.h>
#include <setjmp.h>
#include <cmocka.h>

#include "kernel/maths.h"
#include "kernel_random.h"

typedef long double real;

/* Distance in units of the last place of the true value (of the smallest normal below it). */
static real ulps(float got, real want)
{
    if (fabsl(want) > FLT_MAX)
        return got == (want > 0 ? RTK_INF : -RTK_INF) || fabsl(want) < FLT_MAX * 1.0000001L ? 0 : 1e9L;
    if (!(fabsf(got) <= FLT_MAX))
        return 1e9L;
    int e = want == 0 ? -126 : ilogbl(want);
    return fabsl((real)got - want) / ldexpl(1, (e < -126 ? -126 : e) - 23);
}

typedef struct function {
    const char *name;
    float (*f)(float);
    real (*judge)(real);
    real bound;
    float lo, hi; /* dense, evenly */
    int all;      /* also every 1009th float of [-max, max] */
} function;

static float f_sin(float x)
{
    return rtk_sin(x);
}
static float f_cos(float x)
{
    return rtk_cos(x);
}
static float f_tan(float x)
{
    return rtk_tan(x);
}
static float f_asin(float x)
{
    return rtk_asin(x);
}
static float f_acos(float x)
{
    return rtk_acos(x);
}
static float f_atan(float x)
{
    return rtk_atan(x);
}
static float f_exp2(float x)
{
    return rtk_exp2(x);
}
static float f_exp(float x)
{
    return rtk_exp(x);
}
static float f_log2(float x)
{
    return rtk_log2(x);
}
static float f_log(float x)
{
    return rtk_log(x);
}

static void one_argument(void **state)
{
    (void)state;
    static const function list[] = {
        {"sin", f_sin, sinl, 1.5L, -7.0f, 7.0f, 1},        {"sin", f_sin, sinl, 1.5L, -5000.0f, 5000.0f, 0},
        {"cos", f_cos, cosl, 1.5L, -7.0f, 7.0f, 1},        {"cos", f_cos, cosl, 1.5L, -5000.0f, 5000.0f, 0},
        {"tan", f_tan, tanl, 4.0L, -7.0f, 7.0f, 1},        {"asin", f_asin, asinl, 2.5L, -1.0f, 1.0f, 0},
        {"acos", f_acos, acosl, 2.5L, -1.0f, 1.0f, 0},     {"atan", f_atan, atanl, 2.0L, -5.0f, 5.0f, 1},
        {"exp2", f_exp2, exp2l, 1.5L, -150.0f, 129.0f, 1}, {"exp", f_exp, expl, 1.5L, -105.0f, 90.0f, 1},
        {"log2", f_log2, log2l, 1.0L, 1e-6f, 4.0f, 1},     {"log", f_log, logl, 1.0L, 1e-6f, 4.0f, 1},
    };
    for (size_t i = 0; i < sizeof list / sizeof *list; i++) {
        const function *t = &list[i];
        real worst = 0;
        float at = 0;
        const int n = 300000;
        for (int k = 0; k <= n; k++) {
            float x = t->lo + (t->hi - t->lo) * ((float)k / (float)n);
            real e = ulps(t->f(x), t->judge(x));
            if (e > worst)
                worst = e, at = x;
        }
        for (uint64_t b = 0; t->all && b < 0x100000000u; b += 10007) {
            float x = rtk_float((rtk_u32)b);
            if (!(fabsf(x) <= FLT_MAX) || (x <= 0 && (t->judge == log2l || t->judge == logl)))
                continue;
            real e = ulps(t->f(x), t->judge(x));
            if (e > worst)
                worst = e, at = x;
        }
        print_message("%-5s [%g, %g]%s worst %.2Lf ulp at %.9g\n", t->name, (double)t->lo, (double)t->hi,
                      t->all ? " and all over" : "", worst, (double)at);
        assert_true(worst <= t->bound);
    }
}

static void two_arguments(void **state)
{
    (void)state;
    rng g = {31};
    real worst_atan = 0, worst_pow = 0;
    for (int i = 0; i < 1500000; i++) {
        float y = rtk_float(rng_u32(&g)), x = rtk_float(rng_u32(&g));
        if (i % 2)
            y = rng_pm(&g), x = rng_pm(&g);
        if (fabsf(x) <= FLT_MAX && fabsf(y) <= FLT_MAX && (x != 0 || y != 0)) {
            real e = ulps(rtk_atan2(y, x), atan2l(y, x));
            worst_atan = e > worst_atan ? e : worst_atan;
        }
        x = fabsf(x);
        if (i % 4 == 0)
            x = 1.0f + 1e-3f * rng_pm(&g), y *= 1e4f;
        else if (i % 4 == 1)
            x = 1e3f * fabsf(x), y *= 10.0f;
        if (x > 0 && x <= FLT_MAX && fabsf(y) <= FLT_MAX) {
            real e = ulps(rtk_pow(x, y), powl(x, y));
            worst_pow = e > worst_pow ? e : worst_pow;
        }
    }
    print_message("atan2 worst %.2Lf ulp, pow worst %.2Lf ulp\n", worst_atan, worst_pow);
    assert_true(worst_atan <= 3.0L);
    assert_true(worst_pow <= 2.0L);
}

static void odd_arguments(void **state)
{
    (void)state;
    const float inf = RTK_INF, nan = RTK_NAN;
    float (*const all[])(float) = {f_sin, f_cos, f_tan, f_asin, f_acos, f_atan, f_exp2, f_exp, f_log2, f_log};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        assert_true(isnan(all[i](nan)));
    assert_true(isnan(rtk_sin(inf)) && isnan(rtk_cos(-inf)) && isnan(rtk_tan(inf)));
    assert_true(rtk_asin(1.5f) == rtk_asin(1.0f) && rtk_acos(-1.0001f) == rtk_acos(-1.0f) && rtk_acos(2.0f) == 0.0f);
    assert_true(rtk_exp2(128.0f) == inf && rtk_exp2(inf) == inf && rtk_exp2(-inf) == 0.0f && rtk_exp2(-149.0f) > 0.0f);
    assert_true(rtk_exp(1e30f) == inf && rtk_exp(-1e30f) == 0.0f && rtk_exp(0.0f) == 1.0f && rtk_exp2(3.0f) == 8.0f);
    assert_true(rtk_log(0.0f) == -inf && rtk_log(inf) == inf && isnan(rtk_log(-1.0f)) && rtk_log2(8.0f) == 3.0f &&
                rtk_log(1.0f) == 0.0f);
    assert_true(rtk_pow(0.0f, 2.0f) == 0.0f && rtk_pow(0.0f, -1.0f) == inf && rtk_pow(nan, 0.0f) == 1.0f &&
                rtk_pow(1.0f, nan) == 1.0f);
    assert_true(isnan(rtk_pow(-2.0f, 2.0f)) && isnan(rtk_pow(2.0f, nan)) && rtk_pow(inf, 0.5f) == inf &&
                rtk_pow(inf, -1.0f) == 0.0f);
    assert_true(rtk_pow(2.0f, inf) == inf && rtk_pow(0.5f, inf) == 0.0f && rtk_pow(3.0f, 2.0f) == 9.0f);
    assert_true(rtk_atan2(0.0f, 0.0f) == 0.0f && isnan(rtk_atan2(nan, 1.0f)) && isnan(rtk_atan2(1.0f, nan)));
    assert_true(ulps(rtk_atan2(inf, inf), atan2l(INFINITY, INFINITY)) < 2 &&
                ulps(rtk_atan2(-inf, -inf), atan2l(-INFINITY, -INFINITY)) < 2);
    assert_true(ulps(rtk_atan2(0.0f, -1.0f), acosl(-1)) < 1 && rtk_atan2(1.0f, inf) == 0.0f);
    assert_true(signbit(rtk_atan2(-0.0f, 1.0f)) && rtk_atan2(-0.0f, 1.0f) == 0.0f);
}

/* ---- doubled floats: the exact ones are exact, the others as good as they say ---- */

static void doubled_floats(void **state)
{
    (void)state;
    rng g = {8};
    const real u2 = ldexpl(1, -48);
    real worst = 0;
    for (int i = 0; i < 1000000; i++) {
        float a = rng_pm(&g), b = rng_pm(&g), c = rng_pm(&g) * (i % 3 ? 1.0f : 1e-5f), d = rng_pm(&g);
        if (i % 2) { /* almost all cancels: c d within a few ulp of a b */
            c = a * b / d;
            d += ldexpf((float)(int)(rng_u32(&g) % 5) - 2.0f, -24) * d;
        }
        rtk_ff s = rtk_two_sum(a, b), m = rtk_two_diff(a, c), p = rtk_two_prod(a, b), x = rtk_ff_diff_products(a, b, c, d);
        assert_true((real)s.hi + s.lo == (real)a + b);
        assert_true((real)m.hi + m.lo == (real)a - c);
        assert_true((real)p.hi + p.lo == (real)a * b);
        /* 48-bit products: their difference needs up to 50 + bits of exponent difference, long double's 64 hold it here */
        real want = (real)a * b - (real)c * d, e = want == 0 ? 0 : fabsl((real)x.hi + x.lo - want) / fabsl(want);
        assert_true((want == 0) == (x.hi == 0.0f));
        worst = e > worst ? e : worst;
        assert_int_equal(rtk_compare_products(a, b, c, d), (want > 0) - (want < 0));
        rtk_ff y = rtk_ff_mul(s, p), z = rtk_ff_add(p, m);
        real sv = (real)s.hi + s.lo, pv = (real)p.hi + p.lo, mv = (real)m.hi + m.lo;
        assert_true(fabsl((real)y.hi + y.lo - sv * pv) <= 8 * u2 * fabsl(sv * pv));
        assert_true(fabsl((real)z.hi + z.lo - (pv + mv)) <= 4 * u2 * (fabsl(pv) + fabsl(mv)));
        if (sv != 0)
            assert_true(fabsl(rtk_ff_quotient(p, s) - pv / sv) <= 1.01L * ldexpl(1, -24) * fabsl(pv / sv));
    }
    print_message("a b - c d: worst relative error %.2Lf u^2\n", worst / u2);
    assert_true(worst <= 16 * u2);
}

static void compare_products_everywhere(void **state)
{
    (void)state;
    rng g = {9};
    for (int i = 0; i < 1000000; i++) {
        float f[4];
        for (int k = 0; k < 4; k++)
            do
                f[k] = rtk_float(rng_u32(&g));
            while (!(fabsf(f[k]) <= FLT_MAX));
        if (i % 4 == 1) /* equal products written differently, denormals among them */
            f[2] = f[0] * 0.5f, f[3] = f[1] * 2.0f;
        if (i % 4 == 2)
            f[2] = f[1], f[3] = f[0];
        if (i % 4 == 3)
            f[0] = f[2] * 0.0f;
        if (!(fabsf(f[3]) <= FLT_MAX))
            continue;
        real want = (real)f[0] * f[1] - (real)f[2] * f[3]; /* long double's exponents hold every product exactly */
        assert_int_equal(rtk_compare_products(f[0], f[1], f[2], f[3]), (want > 0) - (want < 0));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_argument),
        cmocka_unit_test(two_arguments),
        cmocka_unit_test(odd_arguments),
        cmocka_unit_test(doubled_floats),
        cmocka_unit_test(compare_products_everywhere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
