/* Random numbers: uniform, stratified as promised, independent across pixels, keys, dimensions and seeds. */
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <setjmp.h>
#include <cmocka.h>

#include "kernel/rng.h"

static const rtk_u32 dims[] = {RTK_DIM_FILTER_X,     RTK_DIM_FILTER_Y, RTK_DIM_LENS_U,  RTK_DIM_LENS_V,
                               RTK_DIM_TIME,         RTK_DIM_LIGHT_U,  RTK_DIM_LIGHT_V, RTK_DIM_BSDF_U,
                               RTK_DIM_LIGHT_CHOICE, RTK_DIM_BSDF_V,   RTK_DIM_LOBE,    RTK_DIM_ROULETTE};
enum { DIMS = sizeof dims / sizeof *dims };

/* How many standard deviations a chi-square sum is away from its mean. */
static double chi_sigma(const int *count, int bins, double expected)
{
    double chi = 0;
    for (int i = 0; i < bins; i++)
        chi += (count[i] - expected) * (count[i] - expected) / expected;
    return (chi - (bins - 1)) / sqrt(2.0 * (bins - 1));
}

static void numbers_are_uniform(void **state)
{
    (void)state;
    enum { BINS = 1024, N = 1 << 19 };
    static int count[BINS];
    for (int d = 0; d < DIMS; d++) { /* one sample from each of many pixels */
        memset(count, 0, sizeof count);
        for (rtk_u32 p = 0; p < N; p++) {
            float x = rtk_random(rtk_vertex_seed(7, p, rtk_key_root()), 5, dims[d]);
            assert_true(x >= 0.0f && x < 1.0f);
            count[(int)(x * BINS)]++;
        }
        assert_true(fabs(chi_sigma(count, BINS, (double)N / BINS)) < 5);
    }
    memset(count, 0, sizeof count); /* plain hash, low bits */
    for (rtk_u32 p = 0; p < N; p++)
        count[rtk_hash3(1, p, 2) % BINS]++;
    assert_true(fabs(chi_sigma(count, BINS, (double)N / BINS)) < 5);
}

static void samples_of_a_pixel_are_stratified(void **state)
{
    (void)state;
    static unsigned char seen[1 << 12];
    for (rtk_u32 pixel = 0; pixel < 40; pixel++) {
        rtk_u32 seed = rtk_vertex_seed(3, pixel, rtk_key_child(rtk_key_root(), pixel));
        for (int k = 0; k <= 12; k += 3)
            for (int d = 0; d < DIMS; d++) {
                memset(seen, 0, sizeof seen);
                for (rtk_u32 i = 0; i < 1u << k; i++) {
                    rtk_u32 at = k ? rtk_random_bits(seed, i, dims[d]) >> (32 - k) : 0;
                    assert_int_equal(seen[at]++, 0); /* each of 2^k strata exactly once */
                }
            }
        for (int pair = 0; pair < 3; pair++) { /* every elementary interval of 2^k points in two dimensions */
            rtk_u32 u = dims[pair == 0 ? 0 : (pair == 1 ? 5 : 7)], v = u + 1;
            for (int a = 1; a < 8; a++) {
                memset(seen, 0, sizeof seen);
                for (rtk_u32 i = 0; i < 256; i++) {
                    rtk_u32 x = rtk_random_bits(seed, i, u) >> (32 - a), y = rtk_random_bits(seed, i, v) >> (24 + a);
                    assert_int_equal(seen[(x << (8 - a)) | y]++, 0);
                }
            }
        }
    }
}

/* Correlation of two series of N numbers, in standard deviations. */
static double correlation(const float *a, const float *b, int n)
{
    double s = 0;
    for (int i = 0; i < n; i++)
        s += ((double)a[i] - 0.5) * ((double)b[i] - 0.5);
    return s * 12.0 / sqrt(n);
}

static void pixels_keys_and_dimensions_are_independent(void **state)
{
    (void)state;
    enum { N = 1 << 16, BINS = 256 };
    static float base[N], other[N];
    static int count[BINS];
    rtk_key root = rtk_key_root(), child = rtk_key_child(root, 3);
    double worst = 0;
    for (rtk_u32 how = 0; how < 12; how++) {
        memset(count, 0, sizeof count);
        for (rtk_u32 p = 0; p < N; p++) {
            base[p] = rtk_random(rtk_vertex_seed(1, p, root), 0, 0);
            other[p] = how == 0   ? rtk_random(rtk_vertex_seed(1, p + 1, root), 0, 0)    /* next pixel */
                       : how == 1 ? rtk_random(rtk_vertex_seed(1, p + 1024, root), 0, 0) /* the row below */
                       : how == 2 ? rtk_random(rtk_vertex_seed(2, p, root), 0, 0)        /* seed */
                       : how == 3 ? rtk_random(rtk_vertex_seed(1, p, child), 0, 0)       /* bounce */
                       : how == 4 ? rtk_random(rtk_vertex_seed(1, p, rtk_key_child(child, 3)), 0, 0)
                                  : rtk_random(rtk_vertex_seed(1, p, root), 0, dims[how - 4]); /* dimension */
            count[(int)(base[p] * 16) * 16 + (int)(other[p] * 16)]++;
        }
        double c = fabs(correlation(base, other, N)), x = fabs(chi_sigma(count, BINS, (double)N / BINS));
        worst = c > worst ? c : (x > worst ? x : worst);
        assert_true(c < 4.5);
        assert_true(x < 4.5);
    }
    print_message("worst correlation or 2-d chi-square: %.2f sigma\n", worst);
    /* pixel means over 4 samples: their variance is that of independent pixels, 1 / (12 N) at most (less by stratification) */
    double mean = 0;
    for (rtk_u32 p = 0; p < N; p++)
        for (rtk_u32 i = 0; i < 4; i++)
            mean += rtk_random(rtk_vertex_seed(9, p, root), i, 0);
    assert_true(fabs(mean / (4.0 * N) - 0.5) < 5 / sqrt(12.0 * N));
}

static void keys_differ(void **state)
{
    (void)state;
    enum { N = 4096 };
    static uint64_t keys[N + 1];
    int n = 0;
    keys[n++] = 0;
    for (rtk_u32 a = 0; a < 16; a++)
        for (rtk_u32 b = 0; b < 16; b++)
            for (rtk_u32 c = 0; c < 16; c++) {
                rtk_key k = rtk_key_child(rtk_key_child(rtk_key_child(rtk_key_root(), a), b), c);
                keys[n++] = ((uint64_t)k.hi << 32) | k.lo;
            }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < i; j++)
            assert_true(keys[i] != keys[j]);
}

/* Each input bit flips each output bit about half of the time. */
static void the_hash_avalanches(void **state)
{
    (void)state;
    double worst = 0;
    for (int word = 0; word < 3; word++)
        for (int in = 0; in < 32; in++) {
            int flips[32] = {0};
            for (rtk_u32 i = 0; i < 2000; i++) {
                rtk_u32 w[3] = {i, i * 7919u, 12345u + i}, a = rtk_hash3(w[0], w[1], w[2]), b;
                w[word] ^= 1u << in;
                b = rtk_hash3(w[0], w[1], w[2]);
                for (int o = 0; o < 32; o++)
                    flips[o] += (int)(((a ^ b) >> o) & 1u);
            }
            for (int o = 0; o < 32; o++) {
                double bias = fabs(flips[o] / 2000.0 - 0.5);
                worst = bias > worst ? bias : worst;
            }
        }
    print_message("avalanche: worst bias %.3f\n", worst);
    assert_true(worst < 0.06); /* 5 sigma of 2000 throws */
}

/* The point of it all: 256 stratified points integrate a smooth function far better than independent ones. */
static void integration_converges(void **state)
{
    (void)state;
    double error2 = 0;
    for (rtk_u32 p = 0; p < 200; p++) {
        rtk_u32 seed = rtk_vertex_seed(0, p, rtk_key_root());
        double sum = 0;
        for (rtk_u32 i = 0; i < 256; i++) {
            double x = rtk_random(seed, i, RTK_DIM_BSDF_U), y = rtk_random(seed, i, RTK_DIM_BSDF_V);
            sum += x * x * y;
        }
        error2 += pow(sum / 256 - 1.0 / 6, 2);
    }
    double rms = sqrt(error2 / 200), independent = sqrt((1.0 / 15 - 1.0 / 36) / 256);
    print_message("256 points: rms error %.2e, independent ones %.2e\n", rms, independent);
    assert_true(rms < independent / 15);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_are_uniform),
        cmocka_unit_test(samples_of_a_pixel_are_stratified),
        cmocka_unit_test(pixels_keys_and_dimensions_are_independent),
        cmocka_unit_test(keys_differ),
        cmocka_unit_test(the_hash_avalanches),
        cmocka_unit_test(integration_converges),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
