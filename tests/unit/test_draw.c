/* Drawing into images: resampling against plain sums, clipping, the font's table, UTF-8. */
#include "../support/fixture.h"

#include <math.h>

#include "librt/draw.h"
#include "render/font.h"
#include "render/image.h"

static rt_image *make(uint32_t w, uint32_t h)
{
    rt_image *image = NULL;
    assert_int_equal(rt_image_create(test.ctx, w, h, &image), RT_OK);
    return image;
}

static rt_image *resampled(const rt_image *image, uint32_t w, uint32_t h, rt_resample filter)
{
    rt_image *out = NULL;
    assert_int_equal(rt_image_resample(image, w, h, filter, &out), RT_OK);
    assert_int_equal(rt_image_width(out), w);
    assert_int_equal(rt_image_height(out), h);
    return out;
}

static float *at(rt_image *image, uint32_t x, uint32_t y)
{
    return rt_image_pixels(image) + 4 * (y * (size_t)rt_image_width(image) + x);
}

/* 5 pixels to 2: a box covers two and a half. */
static void test_box_is_the_mean(void **state)
{
    rt_image *image = make(5, 1);
    (void)state;
    for (uint32_t x = 0; x < 5; x++)
        at(image, x, 0)[0] = (float)(x + 1);
    rt_image *half = resampled(image, 2, 1, RT_RESAMPLE_BOX);
    assert_true(fabsf(at(half, 0, 0)[0] - (1.0f + 2.0f + 1.5f) / 2.5f) < 1e-6f);
    assert_true(fabsf(at(half, 1, 0)[0] - (1.5f + 4.0f + 5.0f) / 2.5f) < 1e-6f);
    rt_image *large = resampled(image, 15, 3, RT_RESAMPLE_BOX); /* three times as large: squares */
    for (uint32_t x = 0; x < 15; x++)
        assert_true(fabsf(at(large, x, 2)[0] - (float)(x / 3 + 1)) < 1e-6f);
    rt_image_destroy(large);
    rt_image_destroy(half);
    rt_image_destroy(image);
}

/* Whatever the sizes: a constant stays, and a filter reproduces a ramp inside; rows and columns are treated alike. */
static void test_constants_and_ramps(void **state)
{
    static const uint32_t sizes[] = {1, 2, 7, 16, 33, 100};
    (void)state;
    for (int f = RT_RESAMPLE_AUTO; f <= RT_RESAMPLE_LANCZOS; f++) {
        for (size_t i = 0; i < 6; i++) {
            rt_image *image = make(20, 10);
            for (uint32_t p = 0; p < 200; p++)
                for (int c = 0; c < 4; c++)
                    at(image, p % 20, p / 20)[c] = c == 1 ? (float)(p % 20) : c == 2 ? (float)(p / 20) : 0.7f;
            rt_image *out = resampled(image, sizes[i], sizes[5 - i], (rt_resample)f);
            for (uint32_t y = 0; y < sizes[5 - i]; y++) {
                for (uint32_t x = 0; x < sizes[i]; x++) {
                    const float *p = at(out, x, y);
                    float ramp = ((float)x + 0.5f) * 20.0f / (float)sizes[i] - 0.5f;
                    assert_true(fabsf(p[0] - 0.7f) < 1e-5f && fabsf(p[3] - 0.7f) < 1e-5f);
                    assert_true(p[1] >= 0.0f && p[1] <= 19.0f && p[2] >= 0.0f && p[2] <= 9.0f);
                    if (ramp > 7.0f && ramp < 12.0f && f != RT_RESAMPLE_BOX)
                        assert_true(fabsf(p[1] - ramp) < 0.12f);
                }
            }
            rt_image_destroy(out);
            rt_image_destroy(image);
        }
    }
}

/* Sharp edges neither ring below black nor above white, and numbers that are none do not spread. */
static void test_no_ringing_no_nan(void **state)
{
    rt_image *image = make(32, 4);
    (void)state;
    for (uint32_t x = 16; x < 32; x++)
        for (uint32_t y = 0; y < 4; y++)
            at(image, x, y)[0] = 1000.0f;
    at(image, 3, 1)[0] = NAN;
    at(image, 5, 2)[0] = INFINITY;
    rt_image *out = resampled(image, 50, 7, RT_RESAMPLE_LANCZOS);
    for (uint32_t i = 0; i < 350; i++)
        assert_true(at(out, i % 50, i / 50)[0] >= 0.0f && at(out, i % 50, i / 50)[0] <= 1000.0f);
    rt_image_destroy(out);
    rt_image_destroy(image);
}

/* Whichever allocation fails: a sentence, nothing left. */
static void test_without_memory(void **state)
{
    test_fixture t;
    rt_image *image = NULL, *out = NULL;
    rt_status status = RT_ERROR_MEMORY;
    size_t failed = 0;
    (void)state;
    test_begin(&t, 0);
    assert_int_equal(rt_image_create(t.ctx, 9, 7, &image), RT_OK);
    for (size_t n = 1; status != RT_OK; n++) {
        t.calls = 0;
        t.fail_at = n;
        status = rt_image_resample(image, 4, 11, RT_RESAMPLE_LANCZOS, &out);
        t.fail_at = 0;
        if (status == RT_OK)
            break;
        assert_int_equal(status, RT_ERROR_MEMORY);
        assert_null(out);
        failed++;
    }
    assert_true(failed >= 9); /* the image, its pixels, three tables a side, the rows between */
    rt_image_destroy(out);
    rt_image_destroy(image);
    test_end(&t);
}

static void test_refused(void **state)
{
    rt_image *image = make(2, 2), *out = (rt_image *)8;
    char text[512];
    (void)state;
    assert_int_equal(rt_image_resample(image, 0, 2, RT_RESAMPLE_AUTO, &out), RT_ERROR_ARGUMENT);
    assert_null(out);
    assert_int_equal(rt_image_resample(image, 2, 2, (rt_resample)9, &out), RT_ERROR_ARGUMENT);
    rt_context_error(test.ctx, text, sizeof text);
    assert_non_null(strstr(text, "filter is 9"));
    assert_int_equal(rt_image_resample(image, 1, 2, RT_RESAMPLE_AUTO, NULL), RT_ERROR_ARGUMENT);
    assert_int_equal(rt_image_place(image, image, 0, 0), RT_ERROR_ARGUMENT);
    rt_label_desc d = rt_label_desc_default();
    d.size = 3.0f;
    assert_int_equal(rt_image_label(image, "a", &d), RT_ERROR_ARGUMENT);
    d = rt_label_desc_default();
    d.x = NAN;
    assert_int_equal(rt_image_label(image, "a", &d), RT_ERROR_ARGUMENT);
    memset(&d, 0, sizeof d);
    assert_int_equal(rt_image_label(image, "a", &d), RT_ERROR_ARGUMENT);
    assert_int_equal(rt_image_label(image, NULL, NULL), RT_ERROR_ARGUMENT);
    rt_image_destroy(image);
}

static void test_fill_and_place_are_clipped(void **state)
{
    static const float red[4] = {1, 0, 0, 1};
    rt_image *image = make(4, 3), *other = make(3, 3);
    (void)state;
    rt_image_fill(image, -2147483647 - 1, 1, 0xffffffffu, 5, red);
    assert_true(at(image, 3, 2)[0] == 1.0f && at(image, 3, 0)[0] == 0.0f);
    rt_image_fill(image, 2147483647, 0, 0xffffffffu, 1, red);
    assert_true(at(image, 3, 0)[0] == 0.0f);
    for (uint32_t i = 0; i < 9; i++)
        at(other, i % 3, i / 3)[1] = (float)(i + 1);
    assert_int_equal(rt_image_place(image, other, -1, -1), RT_OK);
    assert_true(at(image, 0, 0)[1] == 5.0f && at(image, 1, 1)[1] == 9.0f && at(image, 2, 2)[0] == 1.0f);
    assert_int_equal(rt_image_place(image, other, 3, 2), RT_OK);
    assert_true(at(image, 3, 2)[1] == 1.0f);
    assert_int_equal(rt_image_place(image, other, 4, 2147483647), RT_OK);
    assert_int_equal(rt_image_place(image, other, -2147483647 - 1, 0), RT_OK);
    rt_image_destroy(other);
    rt_image_destroy(image);
}

static double ink(const char *text, float size, float x)
{
    rt_image *image = make(400, 60);
    rt_label_desc d = rt_label_desc_default();
    double sum = 0.0;
    d.size = size;
    d.x = x;
    assert_int_equal(rt_image_label(image, text, &d), RT_OK);
    for (uint32_t i = 0; i < 400 * 60; i++)
        sum += (double)at(image, i % 400, i / 400)[0];
    rt_image_destroy(image);
    return sum;
}

/* Every character has strokes within the line, its table fits, and no two printable ones are the same. */
static void test_font(void **state)
{
    static rti_font_glyph g[0x180];
    float none = 0.0f;
    (void)state;
    for (uint32_t c = 0x20; c < 0x100; c++) {
        float advance = rti_font_glyph_of(c, &g[c]);
        assert_true(advance >= RTI_FONT_GAP && advance < 20.0f);
        assert_true(g[c].count < RTI_FONT_SEGMENTS);
        assert_true(c == 0x20 || c == 0xa0 || g[c].count > 0);
        for (uint32_t i = 0; i < g[c].count; i++) {
            const rti_font_segment *s = &g[c].segments[i];
            assert_true(fminf(s->x0, s->x1) >= (c < 0xc0 ? -1.0f : -3.0f) && fmaxf(s->x0, s->x1) <= advance);
            assert_true(fminf(s->y0, s->y1) >= -4.0f && fmaxf(s->y0, s->y1) <= 16.0f);
        }
        for (uint32_t k = 0x21; k < c && c < 0x7f; k++)
            assert_true(g[k].count != g[c].count || memcmp(g[k].segments, g[c].segments, g[c].count * sizeof(rti_font_segment)));
    }
    rti_font_glyph_of(0x4e2d, &g[0]);
    assert_int_equal(g[0].count, 4); /* the box */
    rt_label_size("", NULL, &none, NULL);
    assert_true(none == 0.0f);
}

static void test_labels(void **state)
{
    float w1, w2, h1, h2;
    (void)state;
    rt_label_size("ab", NULL, &w1, &h1);
    rt_label_size("abab\nab", NULL, &w2, &h2);
    assert_true(fabsf(w2 - 2.0f * w1) < 1e-3f && h2 == 2.0f * h1 && h1 == 16.0f);
    assert_true(ink("Hello", 20.0f, 5.0f) > 100.0);
    assert_true(fabs(ink("Hello", 20.0f, 5.0f) - ink("Hello", 20.0f, 6.0f)) < 1e-2);
    assert_true(ink(" \t ", 20.0f, 5.0f) == 0.0);
    assert_true(ink("Hello", 20.0f, -1e6f) == 0.0 && ink("Hello", 20.0f, 1e6f) == 0.0);
    assert_true(ink("Hello", 20.0f, -20.0f) < ink("Hello", 20.0f, 0.0f));
}

/* Broken UTF-8 gives a box a byte and never reads beyond the end. */
static void test_utf8(void **state)
{
    static const struct {
        const char *text;
        uint32_t codes[4];
    } rows[] = {{"a\xc3\xa9", {'a', 0xe9}},
                {"\xe4\xb8\xad", {0x4e2d}},
                {"\xf0\x9f\x98\x80", {0x1f600}},
                {"\xc3", {0xfffd}},
                {"\xe4\xb8", {0xfffd, 0xfffd}},
                {"\xc0\xaf", {0xfffd, 0xfffd}},
                {"\xed\xa0\x80", {0xfffd, 0xfffd, 0xfffd}},
                {"\xff\xfe", {0xfffd, 0xfffd}},
                {"\xf8x", {0xfffd, 'x'}}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const unsigned char *p = (const unsigned char *)rows[i].text;
        for (size_t k = 0; k < 4 && rows[i].codes[k]; k++)
            assert_int_equal(rti_font_next(&p), rows[i].codes[k]);
        assert_int_equal(*p, 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_box_is_the_mean),
        cmocka_unit_test(test_constants_and_ramps),
        cmocka_unit_test(test_no_ringing_no_nan),
        cmocka_unit_test(test_without_memory),
        cmocka_unit_test(test_refused),
        cmocka_unit_test(test_fill_and_place_are_clipped),
        cmocka_unit_test(test_font),
        cmocka_unit_test(test_labels),
        cmocka_unit_test(test_utf8),
    };
    return cmocka_run_group_tests(tests, test_setup, test_teardown);
}
