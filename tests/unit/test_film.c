/* The film's integers: rounding, limits, and sums that do not know their order. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <math.h>
#include <cmocka.h>

#include "kernel/film.h"
#include "kernel/rng.h"

#define SCALE 268435456.0f /* 2^28 */

static void test_rounds_to_nearest_even(void **state)
{
    const float unit = 1.0f / SCALE;
    (void)state;
    assert_true(rtk_film_fixed(unit, SCALE) == 1);
    assert_true(rtk_film_fixed(0.5f * unit, SCALE) == 0);
    assert_true(rtk_film_fixed(1.5f * unit, SCALE) == 2);
    assert_true(rtk_film_fixed(2.5f * unit, SCALE) == 2);
    assert_true(rtk_film_fixed(-2.5f * unit, SCALE) == -2);
    assert_true(rtk_film_fixed(1.0f, SCALE) == 268435456);
    assert_true(rtk_film_fixed(8192.0f, SCALE) == (int64_t)1 << 41);
    assert_true(rtk_film_fixed(1e-40f, SCALE) == 0);
}

static void test_limits_and_drops(void **state)
{
    uint64_t sum[4] = {0};
    (void)state;
    assert_int_equal(rtk_film_add(sum, rtk_v3(8192.0f, 0, 0), SCALE), RTK_FILM_ADDED);
    assert_int_equal(rtk_film_add(sum, rtk_v3(6000.0f, 6000.0f, 6000.0f), SCALE), RTK_FILM_ADDED);
    assert_int_equal(rtk_film_add(sum, rtk_v3(0, -9000.0f, 0), SCALE), RTK_FILM_CLAMPED);
    assert_true((int64_t)sum[1] == ((int64_t)6000 << 28) - ((int64_t)8192 << 28));
    assert_true(sum[2] == (uint64_t)6000 << 28);
    assert_int_equal(rtk_film_add(sum, rtk_v3(1, NAN, 1), SCALE), RTK_FILM_DROPPED);
    assert_int_equal(rtk_film_add(sum, rtk_v3(INFINITY, 1, 1), SCALE), RTK_FILM_DROPPED);
    assert_int_equal(rtk_film_add(sum, rtk_v3(1, 1, -INFINITY), SCALE), RTK_FILM_DROPPED);
    assert_true(sum[0] == (uint64_t)14192 << 28 && sum[2] == (uint64_t)6000 << 28 && sum[3] == 0);
}

/* The same contributions forwards and backwards; in floats they differ. */
static void test_order_does_not_matter(void **state)
{
    uint64_t a[4] = {0}, b[4] = {0};
    float fa = 0, fb = 0;
    enum { N = 4096 };
    (void)state;
    for (uint32_t i = 0; i < N; i++) {
        uint32_t j = N - 1 - i;
        float x = rtk_unit_float(rtk_mix(i)) * (float)(1u << i % 13), y = rtk_unit_float(rtk_mix(j)) * (float)(1u << j % 13);
        rtk_film_add(a, rtk_v3(x, -x, x), SCALE);
        rtk_film_add(b, rtk_v3(y, -y, y), SCALE);
        fa += x;
        fb += y;
    }
    assert_true(fa != fb);
    assert_memory_equal(a, b, sizeof a);
}

/* Partial sums beyond 63 bits do no harm while the whole fits. */
static void test_partial_sums_may_wrap(void **state)
{
    uint64_t sum[4] = {(uint64_t)INT64_MAX - 5, 0, 0, 0};
    (void)state;
    rtk_film_add(sum, rtk_v3(8192.0f, 0, 0), SCALE);
    rtk_film_add(sum, rtk_v3(-8192.0f, 0, 0), SCALE);
    assert_true(sum[0] == (uint64_t)INT64_MAX - 5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rounds_to_nearest_even),
        cmocka_unit_test(test_limits_and_drops),
        cmocka_unit_test(test_order_does_not_matter),
        cmocka_unit_test(test_partial_sums_may_wrap),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
