/* Bounds put in order for a kd split: as qsort puts them, bit for bit but for the signs of zeros. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#include "accel/kd_build.h"
#include "support/mesh.h"

#define MOST 20000u

static int compare(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* kind 0: any bits of finite floats; 1: of one bin, which share their upper bits; 2: a few values, and zeros of both signs;
 * 3: falling. */
static float number(uint32_t kind, uint32_t i, test_rng *r)
{
    static const float few[] = {0.0f, -0.0f, 1.5f, -1.5f, 1.0e-41f, -3.0e38f};
    const uint32_t bits = test_u32(r);
    if (kind == 0)
        return (bits >> 23 & 255u) == 255u ? 1.0f : rtk_float(bits);
    if (kind == 1)
        return 7.0f + (float)(bits % 4096u) * 1.0e-6f;
    return kind == 2 ? few[bits % 6u] : (float)(MOST / 2) - (float)i;
}

static void test_sort(void **state)
{
    static const uint32_t counts[] = {0, 1, 2, 23, 24, 25, 100, 1023, 1024, 1025, 4097, MOST};
    static float v[MOST], right[MOST], temp[MOST];
    test_rng r = {9};
    (void)state;
    for (uint32_t kind = 0; kind < 4; kind++)
        for (size_t c = 0; c < sizeof counts / sizeof counts[0]; c++) {
            const uint32_t n = counts[c];
            for (uint32_t i = 0; i < n; i++)
                v[i] = right[i] = number(kind, i, &r);
            rti_kd_sort(v, n, temp);
            qsort(right, n, sizeof *right, compare);
            for (uint32_t i = 0; i < n; i++)
                assert_true(v[i] == right[i]);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_sort)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
