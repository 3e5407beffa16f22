/* Images: sizes, text entries, hash, comparison. */
#include "../support/fixture.h"

#include <math.h>

#include "librt/image.h"
#include "render/image.h"

static rt_image *make(uint32_t w, uint32_t h)
{
    rt_image *image = NULL;
    assert_int_equal(rt_image_create(test.ctx, w, h, &image), RT_OK);
    assert_non_null(image);
    return image;
}

static void test_create_is_transparent_black(void **state)
{
    rt_image *image = make(3, 2);
    (void)state;
    assert_int_equal(rt_image_width(image), 3);
    assert_int_equal(rt_image_height(image), 2);
    for (int i = 0; i < 24; i++)
        assert_true(rt_image_pixels_const(image)[i] == 0.0f);
    rt_image_destroy(image);
    rt_image_destroy(NULL);
}

static void refuse(uint32_t w, uint32_t h, rt_status status, const char *word)
{
    rt_image *image = (rt_image *)8;
    char text[512];
    assert_int_equal(rt_image_create(test.ctx, w, h, &image), status);
    assert_null(image);
    assert_true(rt_context_error(test.ctx, text, sizeof text) > 0);
    assert_non_null(strstr(text, word));
}

static void test_sizes_refused(void **state)
{
    (void)state;
    refuse(0, 5, RT_ERROR_ARGUMENT, "0 x 5");
    refuse(5, 0, RT_ERROR_ARGUMENT, "5 x 0");
    refuse(1048577, 1, RT_ERROR_ARGUMENT, "1048577");
    refuse(1048576, 1048576, RT_ERROR_MEMORY_LIMIT, "17592186044416");
}

static void test_text(void **state)
{
    rt_image *image = make(1, 1);
    char key[81];
    (void)state;
    memset(key, 'k', sizeof key);
    key[80] = '\0';
    assert_null(rt_image_get_text(image, "Title"));
    assert_int_equal(rt_image_set_text(image, "Title", "one"), RT_OK);
    assert_int_equal(rt_image_set_text(image, "Author", "x"), RT_OK);
    assert_int_equal(rt_image_set_text(image, "Title", "another"), RT_OK);
    assert_string_equal(rt_image_get_text(image, "Title"), "another");
    assert_int_equal(image->text_count, 2);
    assert_string_equal(image->texts[0].key, "Title");
    assert_int_equal(rt_image_set_text(image, "", "x"), RT_ERROR_ARGUMENT);
    assert_int_equal(rt_image_set_text(image, key, "x"), RT_ERROR_ARGUMENT);
    key[79] = '\0';
    assert_int_equal(rt_image_set_text(image, key, "x"), RT_OK);
    assert_int_equal(rt_image_set_text(image, "a", NULL), RT_ERROR_ARGUMENT);
    rt_image_destroy(image);
}

static void test_hash_sees_bits_and_shape(void **state)
{
    rt_image *a = make(4, 2), *b = make(2, 4);
    char ha[33], hb[33];
    (void)state;
    rt_image_hash(a, ha);
    rt_image_hash(b, hb);
    assert_int_equal(strlen(ha), 32);
    assert_string_not_equal(ha, hb);
    rt_image_pixels(a)[31] = -0.0f;
    rt_image_hash(a, hb);
    assert_string_not_equal(ha, hb);
    rt_image_destroy(a);
    rt_image_destroy(b);
}

/* The hash of an image in a padded buffer is that of the same pixels packed, whatever stands in the padding. */
static void test_hash_ignores_padding(void **state)
{
    float buffer[2 * 16];
    rt_image *wrapped = NULL, *packed = make(3, 2);
    char ha[33], hb[33];
    (void)state;
    for (int i = 0; i < 32; i++)
        buffer[i] = 7.0f;
    assert_int_equal(rti_image_wrap(test.ctx, 3, 2, buffer, 16 * sizeof(float), 1, &wrapped), RT_OK);
    assert_true(buffer[0] == 0.0f && buffer[27] == 0.0f && buffer[12] == 7.0f && buffer[28] == 7.0f);
    for (int i = 0; i < 12; i++) {
        rti_image_row(wrapped, 1)[i] = (float)i;
        rti_image_row(packed, 1)[i] = (float)i;
    }
    rt_image_hash(wrapped, ha);
    rt_image_hash(packed, hb);
    assert_string_equal(ha, hb);
    rt_image_destroy(wrapped);
    rt_image_destroy(packed);
}

static void test_compare(void **state)
{
    rt_image *a = make(8, 4), *b = make(8, 4), *c = make(4, 8), *map = NULL;
    rt_image_difference d;
    char text[256];
    (void)state;
    assert_int_equal(rt_image_compare(a, b, &d, NULL), RT_OK);
    assert_int_equal(d.differing_pixels, 0);
    assert_true(isinf(d.psnr) && d.mse == 0.0);
    rt_image_pixels(b)[4 * (8 * 2 + 5)] = 1.0f;
    rt_image_pixels(b)[4 * (8 * 3 + 1) + 3] = 1.0f;
    assert_int_equal(rt_image_compare(a, b, &d, &map), RT_OK);
    assert_int_equal(d.differing_pixels, 2);
    assert_int_equal(d.first_x, 5);
    assert_int_equal(d.first_y, 2);
    assert_true(fabs(d.max_abs - 1.0) < 1e-12);
    assert_true(fabs(d.mse - 1.0 / 96.0) < 1e-12);
    assert_true(fabs(d.psnr - 10.0 * log10(96.0)) < 1e-9);
    assert_true(rt_image_pixels(map)[4 * (8 * 2 + 5)] == 1.0f);
    rt_image_destroy(map);
    assert_int_equal(rt_image_compare(a, c, &d, &map), RT_ERROR_ARGUMENT);
    assert_null(map);
    rt_context_error(test.ctx, text, sizeof text);
    assert_non_null(strstr(text, "8 x 4"));
    rt_image_destroy(a);
    rt_image_destroy(b);
    rt_image_destroy(c);
}

/* Values that an 8-bit file cannot tell apart are no difference between two such files. */
static void test_compare_eight_bit(void **state)
{
    rt_image *a = make(1, 1), *b = make(1, 1);
    rt_image_difference d;
    (void)state;
    rt_image_pixels(a)[0] = 0.5f;
    rt_image_pixels(b)[0] = 0.5001f;
    rt_image_compare(a, b, &d, NULL);
    assert_int_equal(d.differing_pixels, 1);
    a->eight_bit = true;
    b->eight_bit = true;
    rt_image_compare(a, b, &d, NULL);
    assert_int_equal(d.differing_pixels, 0);
    rt_image_destroy(a);
    rt_image_destroy(b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_create_is_transparent_black),
        cmocka_unit_test(test_sizes_refused),
        cmocka_unit_test(test_text),
        cmocka_unit_test(test_hash_sees_bits_and_shape),
        cmocka_unit_test(test_hash_ignores_padding),
        cmocka_unit_test(test_compare),
        cmocka_unit_test(test_compare_eight_bit),
    };
    return cmocka_run_group_tests(tests, test_setup, test_teardown);
}
