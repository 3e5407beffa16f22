/* Structural similarity against closed forms and a window summed by hand. */
#include "../support/fixture.h"

#include <math.h>

#include "librt/image.h"
#include "scene/import/srgb.h"

/* Encoded grey of a pixel. */
typedef double (*grey_fn)(uint32_t x, uint32_t y);

static rt_image *make(uint32_t width, uint32_t height, grey_fn grey)
{
    rt_image *image;
    assert_int_equal(rt_image_create(test.ctx, width, height, &image), RT_OK);
    float *p = rt_image_pixels(image);
    for (uint32_t i = 0; i < width * height; i++, p += 4)
        p[0] = p[1] = p[2] = (float)rti_srgb_decode(grey(i % width, i / width));
    return image;
}

static double noise(uint32_t x, uint32_t y)
{
    return (double)((x * 73856093u ^ y * 19349663u) % 251u) / 250.0;
}

static double wave(uint32_t x, uint32_t y)
{
    return 0.5 + 0.4 * sin(0.7 * x) * cos(0.4 * y);
}

static double dark(uint32_t x, uint32_t y)
{
    (void)x;
    (void)y;
    return 0.25;
}

static double bright(uint32_t x, uint32_t y)
{
    return dark(x, y) + 0.5;
}

static double negative(uint32_t x, uint32_t y)
{
    return 1.0 - noise(x, y);
}

static double ssim_of(rt_image *a, rt_image *b)
{
    double s = NAN;
    assert_int_equal(rt_image_ssim(a, b, &s, NULL), RT_OK);
    return s;
}

static void test_closed_forms(void **state)
{
    rt_image *a = make(40, 30, noise), *b = make(40, 30, negative), *c = make(40, 30, dark), *d = make(40, 30, bright);
    double want = (2 * 0.25 * 0.75 + 1e-4) / (0.25 * 0.25 + 0.75 * 0.75 + 1e-4); /* without variance only the means count */
    (void)state;
    assert_true(fabs(ssim_of(a, a) - 1) < 1e-12);
    assert_true(fabs(ssim_of(c, d) - want) < 1e-6);
    assert_true(fabs(ssim_of(c, d) - ssim_of(d, c)) < 1e-15);
    assert_true(ssim_of(a, b) < -0.5); /* opposite structure */
    rt_image_destroy(a);
    rt_image_destroy(b);
    rt_image_destroy(c);
    rt_image_destroy(d);
}

/* The paper's formula at one window, by four loops. */
static double by_hand(grey_fn f, grey_fn g, uint32_t cx, uint32_t cy, uint32_t width, uint32_t height)
{
    double total = 0, ma = 0, mb = 0, va = 0, vb = 0, cov = 0;
    for (int pass = 0; pass < 2; pass++) {
        for (int dy = -5; dy <= 5; dy++) {
            for (int dx = -5; dx <= 5; dx++) {
                int x = (int)cx + dx, y = (int)cy + dy;
                double w = exp(-(dx * dx + dy * dy) / 4.5), a, b;
                if (x < 0 || y < 0 || x >= (int)width || y >= (int)height)
                    continue;
                a = f((uint32_t)x, (uint32_t)y);
                b = g((uint32_t)x, (uint32_t)y);
                if (pass == 0) {
                    total += w;
                    ma += w * a;
                    mb += w * b;
                } else {
                    va += w * (a - ma) * (a - ma);
                    vb += w * (b - mb) * (b - mb);
                    cov += w * (a - ma) * (b - mb);
                }
            }
        }
        if (pass == 0) {
            ma /= total;
            mb /= total;
        }
    }
    va /= total;
    vb /= total;
    cov /= total;
    return (2 * ma * mb + 1e-4) * (2 * cov + 9e-4) / ((ma * ma + mb * mb + 1e-4) * (va + vb + 9e-4));
}

static void against_hand(uint32_t width, uint32_t height)
{
    rt_image *a = make(width, height, noise), *b = make(width, height, wave), *map;
    bool inside = width >= 11 && height >= 11;
    double got = NAN, sum = 0;
    uint32_t count = 0;
    assert_int_equal(rt_image_ssim(a, b, &got, &map), RT_OK);
    for (uint32_t y = 0; y < height; y++) {
        for (uint32_t x = 0; x < width; x++) {
            double want = by_hand(noise, wave, x, y, width, height);
            const float *p = rt_image_pixels(map) + 4 * ((size_t)y * width + x);
            if (fabs((double)p[0] - want) > 1e-5 || p[1] != p[0] || p[3] != 1.0f)
                fail_msg("%u x %u at %u, %u: %g, not %g", width, height, x, y, (double)p[0], want);
            if (!inside || (x >= 5 && y >= 5 && x + 5 < width && y + 5 < height)) {
                sum += want;
                count++;
            }
        }
    }
    assert_true(fabs(got - sum / count) < 1e-6);
    rt_image_destroy(a);
    rt_image_destroy(b);
    rt_image_destroy(map);
}

static void test_against_hand(void **state)
{
    (void)state;
    against_hand(24, 17);
    against_hand(11, 11);
    against_hand(7, 30);
    against_hand(1, 1);
}

static void test_refused(void **state)
{
    rt_image *a = make(3, 2, noise), *b = make(2, 3, noise), *map = a;
    double s;
    (void)state;
    assert_int_equal(rt_image_ssim(a, b, &s, &map), RT_ERROR_ARGUMENT);
    assert_null(map);
    test_says(&test, "3 x 2 and 2 x 3");
    for (test.fail_at = 1; test.fail_at < 5; test.fail_at++) { /* image and its pixels, two buffers */
        test.calls = 0;
        assert_int_equal(rt_image_ssim(a, a, &s, &map), RT_ERROR_MEMORY);
        assert_null(map);
    }
    test.fail_at = 0;
    rt_image_destroy(a);
    rt_image_destroy(b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_closed_forms, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_against_hand, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_refused, test_setup, test_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
