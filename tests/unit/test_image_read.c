/* Image files that are wrong or odd. Good ones of each kind are made by the writers (test_image_save). */
#include "../support/fixture.h"

#include <locale.h>
#include <stdlib.h>
#include <sys/stat.h>

#include "librt/image.h"
#include "render/save_formats.h"
#include "scene/import/image_read.h"
#include "scene/import/srgb.h"

static rt_status decode(const void *bytes, size_t size, rti_pixels *out)
{
    /* at the end of a block of its own, so that a sanitizer sees a read behind it */
    unsigned char *exact = malloc(size ? size : 1);
    assert_non_null(exact);
    memcpy(exact, bytes, size);
    rt_status status = rti_image_decode(test.ctx, "image", exact, size, false, out);
    free(exact);
    assert_true(status == RT_OK ? out->data != NULL : out->data == NULL && out->size == 0);
    return status;
}

static void refuse(const void *bytes, size_t size, rt_status expected, const char *words)
{
    rti_pixels p;
    rt_status status = decode(bytes, size, &p);
    if (status != expected)
        fail_msg("%s, not %s: %s", rt_status_name(status), rt_status_name(expected), test_error(&test));
    test_says(&test, words);
}

static unsigned char *made(const rti_save_format *format, uint32_t width, uint32_t height, uint32_t bits, bool alpha,
                           size_t *size)
{
    rti_row_writer *w;
    float row[4 * 64];
    rt_save_desc d = rt_save_desc_default();
    d.bits = bits;
    d.alpha = alpha;
    const char *path = test_path(&test, "made");
    assert_int_equal(rti_rows_open_as(test.ctx, format, path, width, height, &d, NULL, 0, &w), RT_OK);
    for (uint32_t y = 0; y < height; y++) {
        for (uint32_t i = 0; i < 4 * width; i++)
            row[i] = (float)((i * 7 + y * 13) % 31) / 31.0f;
        assert_int_equal(rti_rows_write(w, row, 1), RT_OK);
    }
    assert_int_equal(rti_rows_close(w, true), RT_OK);
    return test_slurp(path, size);
}

/* A file of each kind, cut at every byte: refused every time, whole: read. */
static void test_cut_everywhere(void **state)
{
    static const struct {
        const rti_save_format *format;
        uint32_t bits;
        bool alpha;
    } kinds[] = {{&rti_save_png_plain, 8, false}, {&rti_save_png_plain, 16, true}, {&rti_save_bmp, 8, false},
                 {&rti_save_tga, 8, true},        {&rti_save_hdr, 8, false},
#ifdef RTI_HAVE_STB
                 {&rti_save_jpg, 8, false}
#endif
    };
    (void)state;
    for (size_t k = 0; k < RTI_COUNT(kinds); k++) {
        rti_pixels p;
        size_t size;
        unsigned char *bytes = made(kinds[k].format, 11, 5, kinds[k].bits, kinds[k].alpha, &size);
        size_t least = kinds[k].format == &rti_save_bmp ? size - 3 : size; /* the last row's padding may be missing */
        for (size_t n = 0; n < least; n++)
            if (decode(bytes, n, &p) == RT_OK)
                fail_msg("a %s file of %zu bytes is read when it has %zu only", kinds[k].format->name, size, n);
        rt_status status = decode(bytes, size, &p);
        assert_true(status == RT_OK || status == RT_ERROR_UNSUPPORTED);
        if (!status) {
            assert_int_equal(p.width, 11);
            assert_int_equal(p.height, 5);
            rti_free(test.ctx, p.data, p.size);
        }
        free(bytes);
    }
}

static const uint8_t gif[] = {'G', 'I', 'F', '8', '9', 'a',  2, 0, 2, 0, 0x80, 0, 0, 255, 0, 0, 0, 0,    255,  0x21, 0xf9, 4,
                              0,   0,   0,   0,   0,   0x2c, 0, 0, 0, 0, 2,    0, 2, 0,   0, 2, 3, 0x44, 0x34, 0x05, 0,    0x3b};

static void test_gif(void **state)
{
    rti_pixels p;
    (void)state;
    rt_status whole = decode(gif, sizeof gif, &p);
    assert_true(whole == RT_OK || whole == RT_ERROR_UNSUPPORTED);
    if (whole == RT_OK) {
        assert_int_equal(p.width, 2);
        assert_int_equal(p.height, 2);
        rti_free(test.ctx, p.data, p.size);
    }
    for (size_t n = 0; n < sizeof gif; n++)
        assert_int_equal(decode(gif, n, &p), RT_ERROR_FORMAT);
}

/* Samples of 16 bits are sRGB encoded unless they are said to be linear; alpha always is. */
static void test_sixteen_bits(void **state)
{
    size_t size;
    unsigned char *bytes = made(&rti_save_png_plain, 7, 3, 16, true, &size);
    rti_pixels seen, raw;
    (void)state;
    rt_status status = rti_image_decode(test.ctx, "seen", bytes, size, false, &seen);
    assert_true(status == RT_OK || status == RT_ERROR_UNSUPPORTED);
    if (!status) {
        assert_int_equal(rti_image_decode(test.ctx, "raw", bytes, size, true, &raw), RT_OK);
        assert_true(seen.is_float && raw.is_float && seen.channels == 4 && raw.channels == 4);
        for (uint32_t i = 0; i < 4 * 7 * 3; i++) {
            const double linear = ((const float *)seen.data)[i], stored = ((const float *)raw.data)[i];
            const double wanted = i % 4 == 3 ? linear : rti_srgb_encode(linear);
            if (stored < wanted - 1e-5 || stored > wanted + 1e-5)
                fail_msg("value %u is %g, not %g", i, stored, wanted);
        }
        rti_free(test.ctx, seen.data, seen.size);
        rti_free(test.ctx, raw.data, raw.size);
    }
    free(bytes);
}

/* ---- headers that promise much ---- */

static void test_huge(void **state)
{
    static const uint8_t png[] =
        "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\1\x86\xa0\0\1\x86\xa0\10\6\0\0\0\xa8\x52\x0b\xc8\0\0\0\0IEND\xae\x42\x60\x82";
    static const uint8_t jpg[] =
        "\xff\xd8\xff\xc0\0\x11\10\xff\xff\xff\xff\3\1\x11\0\2\x11\0\3\x11\0\xff\xda\0\10\1\1\0\0\x3f\0\1\xff\xd9";
    uint8_t bmp[54] = {'B', 'M'}, tga[18] = {0, 0, 2}, rle[18] = {0, 0, 10}, big_gif[sizeof gif];
    char hdr[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 100000 +X 100000\n";
    (void)state;
    rti_put_le32(bmp + 10, 54);
    rti_put_le32(bmp + 14, 40);
    rti_put_le32(bmp + 18, 100000);
    rti_put_le32(bmp + 22, 100000);
    bmp[26] = 1;
    bmp[28] = 24;
    memset(tga + 12, 0xff, 4);
    memset(rle + 12, 0xff, 4);
    tga[16] = rle[16] = 32;
    memcpy(big_gif, gif, sizeof gif);
    memset(big_gif + 6, 0xff, 4);
    refuse(png, sizeof png - 1, RT_ERROR_FORMAT, "is cut");
    refuse(jpg, sizeof jpg - 1, RT_ERROR_FORMAT, "is cut");
    refuse(bmp, sizeof bmp, RT_ERROR_FORMAT, "is cut");
    refuse(tga, sizeof tga, RT_ERROR_FORMAT, "is cut");
    refuse(rle, sizeof rle, RT_ERROR_FORMAT, "is cut");
    refuse(hdr, sizeof hdr - 1, RT_ERROR_FORMAT, "is cut");
    refuse(big_gif, sizeof big_gif, RT_ERROR_FORMAT, "is cut");
}

static void test_no_pixels(void **state)
{
    uint8_t bmp[60] = {'B', 'M'}, tga[20] = {0, 0, 2};
    char hdr[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 0 +X 5\n";
    (void)state;
    rti_put_le32(bmp + 10, 54);
    rti_put_le32(bmp + 14, 40);
    bmp[28] = 24;
    tga[16] = 24;
    refuse(bmp, sizeof bmp, RT_ERROR_FORMAT, "0 x 0 pixels");
    refuse(tga, sizeof tga, RT_ERROR_FORMAT, "0 x 0 pixels");
    refuse(hdr, sizeof hdr - 1, RT_ERROR_FORMAT, "'-Y HEIGHT +X WIDTH'");
}

/* A file whose pixels are there, but more than the context may hold. */
static void test_memory_limit(void **state)
{
    test_fixture small;
    rti_pixels p;
    size_t size = 18 + 3 * 600 * 600;
    uint8_t *tga = calloc(1, size);
    (void)state;
    tga[2] = 2;
    rti_put_le16(tga + 12, 600);
    rti_put_le16(tga + 14, 600);
    tga[16] = 24;
    test_begin(&small, 1000000);
    assert_int_equal(rti_image_decode(small.ctx, "large.tga", tga, size, false, &p), RT_ERROR_MEMORY_LIMIT);
    test_says(&small, "large.tga");
    test_end(&small);
    free(tga);
}

/* ---- kinds of BMP, TGA and HDR ---- */

static void expect(const void *bytes, size_t size, uint32_t channels, const uint8_t *want)
{
    rti_pixels p;
    assert_int_equal(decode(bytes, size, &p), RT_OK);
    assert_int_equal(p.channels, channels);
    assert_memory_equal(p.data, want, p.size);
    rti_free(test.ctx, p.data, p.size);
}

static void test_bmp_kinds(void **state)
{
    uint8_t b[200] = {'B', 'M'};
    static const uint8_t two[] = {10, 20, 30, 40, 50, 60};
    (void)state;
    /* 2 x 1, 8 bits, a palette of two */
    rti_put_le32(b + 10, 62);
    rti_put_le32(b + 14, 40);
    b[18] = 2, b[22] = 1, b[26] = 1, b[28] = 8, b[46] = 2;
    memcpy(b + 54, (uint8_t[]){30, 20, 10, 0, 60, 50, 40, 0, 0, 1}, 10);
    expect(b, 64, 3, two);
    b[63] = 2; /* an index beyond the palette is black */
    expect(b, 64, 3, (const uint8_t[]){10, 20, 30, 0, 0, 0});
    /* 4 bits, 1 bit */
    b[28] = 4, b[62] = 0x01;
    expect(b, 63, 3, two);
    b[28] = 1, b[62] = 0x40;
    expect(b, 63, 3, two);
    /* 16 bits 5-5-5, 5-6-5 by masks */
    b[10] = 54, b[28] = 16, b[46] = 0;
    memcpy(b + 54, (uint8_t[]){0x00, 0x7c, 0x1f, 0x00}, 4);
    expect(b, 58, 3, (const uint8_t[]){255, 0, 0, 0, 0, 255});
    b[10] = 66, b[30] = 3;
    memcpy(b + 54, (uint8_t[]){0, 0xf8, 0, 0, 0xe0, 7, 0, 0, 0x1f, 0, 0, 0, 0x00, 0xf8, 0xe0, 0x07}, 16);
    expect(b, 70, 3, (const uint8_t[]){255, 0, 0, 0, 255, 0});
    b[54] = 1; /* red mask in two pieces */
    refuse(b, 70, RT_ERROR_FORMAT, "not one run of bits");
    b[54] = 0, b[58] = 0, b[59] = 0xff;
    refuse(b, 70, RT_ERROR_FORMAT, "overlap");
    /* 32 bits, upside down, with and without alpha */
    b[10] = 54, b[28] = 32, b[30] = 0, b[18] = 1;
    rti_put_le32(b + 22, ~2u + 1);
    memcpy(b + 54, (uint8_t[]){30, 20, 10, 7, 60, 50, 40, 8}, 8);
    expect(b, 62, 4, (const uint8_t[]){10, 20, 30, 7, 40, 50, 60, 8});
    b[57] = b[61] = 0;
    expect(b, 62, 4, (const uint8_t[]){10, 20, 30, 255, 40, 50, 60, 255});
    b[30] = 1;
    refuse(b, 62, RT_ERROR_UNSUPPORTED, "run-length BMP");
    b[30] = 0, b[28] = 7;
    refuse(b, 62, RT_ERROR_FORMAT, "7 bits a pixel");
    b[14] = 41;
    refuse(b, 62, RT_ERROR_FORMAT, "header of 41 bytes");
}

static void test_tga_kinds(void **state)
{
    uint8_t b[64] = {0, 0, 10};
    (void)state;
    /* run-length, 3 x 1: two of a kind and one; from the bottom right */
    b[12] = 3, b[14] = 1, b[16] = 24, b[17] = 0x10;
    memcpy(b + 18, (uint8_t[]){0x81, 3, 2, 1, 0x00, 6, 5, 4}, 8);
    expect(b, 26, 3, (const uint8_t[]){4, 5, 6, 1, 2, 3, 1, 2, 3});
    /* a packet may reach over the end of the picture, the file not */
    b[18] = 0x80 | 5;
    expect(b, 22, 3, (const uint8_t[]){1, 2, 3, 1, 2, 3, 1, 2, 3});
    /* grey, and grey with alpha */
    b[2] = 3, b[16] = 8, b[17] = 0x20;
    memcpy(b + 18, (uint8_t[]){7, 8, 9, 1, 2, 3}, 6);
    expect(b, 21, 1, (const uint8_t[]){7, 8, 9});
    b[16] = 16;
    expect(b, 24, 4, (const uint8_t[]){7, 7, 7, 8, 9, 9, 9, 1, 2, 2, 2, 3});
    /* a palette that begins at 5; an id of two bytes stands before it */
    memset(b, 0, sizeof b);
    b[0] = 2, b[1] = 1, b[2] = 1, b[3] = 5, b[5] = 2, b[7] = 24, b[12] = 3, b[14] = 1, b[16] = 8, b[17] = 0x20;
    memcpy(b + 20, (uint8_t[]){30, 20, 10, 60, 50, 40, 5, 6, 7}, 9);
    expect(b, 29, 3, (const uint8_t[]){10, 20, 30, 40, 50, 60, 0, 0, 0});
    refuse(b, 28, RT_ERROR_FORMAT, "is cut");
    /* 16 bits */
    memset(b, 0, sizeof b);
    b[2] = 2, b[12] = 2, b[14] = 1, b[16] = 16;
    memcpy(b + 18, (uint8_t[]){0x00, 0x7c, 0xe0, 0x03}, 4);
    expect(b, 22, 3, (const uint8_t[]){255, 0, 0, 0, 255, 0});
}

static void hdr_row(const char *size, const uint8_t *data, size_t n, const float *want, size_t floats)
{
    char text[300];
    rti_pixels p;
    int head = snprintf(text, sizeof text, "#?RADIANCE\nSOFTWARE=hand\nFORMAT=32-bit_rle_rgbe\n\n%s\n", size);
    memcpy(text + head, data, n);
    assert_int_equal(decode(text, (size_t)head + n, &p), RT_OK);
    assert_true(p.is_float && p.channels == 3);
    assert_memory_equal(p.data, want, floats * sizeof(float));
    rti_free(test.ctx, p.data, p.size);
}

static void test_hdr_kinds(void **state)
{
    (void)state;
    hdr_row("-Y 1 +X 2", (const uint8_t[]){128, 64, 0, 129, 128, 0, 0, 128}, 8, (const float[]){1, 0.5f, 0, 0.5f, 0, 0}, 6);
    hdr_row("-Y 1 -X 2", (const uint8_t[]){128, 64, 0, 129, 128, 0, 0, 128}, 8, (const float[]){0.5f, 0, 0, 1, 0.5f, 0}, 6);
    hdr_row("+Y 2 +X 1", (const uint8_t[]){128, 64, 0, 129, 128, 0, 0, 128}, 8, (const float[]){0.5f, 0, 0, 1, 0.5f, 0}, 6);
    /* the old run: 1 1 1 n repeats the pixel before */
    hdr_row("-Y 1 +X 3", (const uint8_t[]){128, 0, 0, 129, 1, 1, 1, 2}, 8, (const float[]){1, 0, 0, 1, 0, 0, 1, 0, 0}, 9);
    refuse("#?RGBE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n1234", 45, RT_ERROR_UNSUPPORTED, "XYZE");
    refuse("#?RGBE\n\n+X 1 -Y 1\n1234", 22, RT_ERROR_FORMAT, "'-Y HEIGHT +X WIDTH'");
    refuse("#?RGBE\n\n-Y 1 +X 8\n\2\2\0\11", 22, RT_ERROR_FORMAT, "another width");
    refuse("#?RGBE\n\n-Y 1 +X 8\n\2\2\0\10\x89\1", 24, RT_ERROR_FORMAT, "over the end");
}

/* ---- damage, names, surroundings ---- */

static void test_damaged_png(void **state)
{
    size_t size;
    unsigned char *bytes = made(&rti_save_png_plain, 11, 5, 8, false, &size);
    (void)state;
    bytes[size / 2] ^= 16; /* in IDAT */
    refuse(bytes, size, RT_ERROR_FORMAT, "checksum");
    free(bytes);
}

static void test_not_an_image(void **state)
{
    (void)state;
    refuse("", 0, RT_ERROR_FORMAT, "empty");
    refuse("hello, world, this is no image", 30, RT_ERROR_FORMAT, "not a PNG");
    refuse("GIF89a", 6, RT_ERROR_FORMAT, "is cut");
    refuse("\xff\xd8\xff\xd9", 4, RT_ERROR_FORMAT, "without a picture");
}

static void test_paths(void **state)
{
    rti_pixels p;
    size_t size;
    unsigned char *bytes = made(&rti_save_tga, 3, 2, 8, false, &size);
    static const char *const names[] = {"with space.tga", "caf\xc3\xa9.tga", "bad\xff\xfeutf8", "new\nline", "-"};
    (void)state;
    for (size_t i = 0; i < RTI_COUNT(names); i++) {
        assert_int_equal(rti_image_read(test.ctx, test_file(&test, names[i], bytes, size), &p), RT_OK);
        rti_free(test.ctx, p.data, p.size);
    }
    assert_int_equal(rti_image_read(test.ctx, test_path(&test, "missing \xff.png"), &p), RT_ERROR_IO);
    test_says(&test, "missing \\xff.png");
    assert_int_equal(mkdir(test_path(&test, "folder.png"), 0777), 0);
    assert_int_equal(rti_image_read(test.ctx, test.path, &p), RT_ERROR_IO);
    test_says(&test, "folder");
    assert_int_equal(rti_image_read(test.ctx, "/dev/zero", &p), RT_ERROR_IO);
    assert_int_equal(rti_image_read(test.ctx, test_file(&test, "empty.png", "", 0), &p), RT_ERROR_FORMAT);
    free(bytes);
}

static void test_german_locale(void **state)
{
    (void)state;
    if (!setlocale(LC_ALL, "de_DE.UTF-8") && !setlocale(LC_ALL, "de_DE")) {
        print_message("no German locale here: left out\n");
        return;
    }
    hdr_row("-Y 1 +X 2", (const uint8_t[]){128, 64, 0, 129, 128, 0, 0, 128}, 8, (const float[]){1, 0.5f, 0, 0.5f, 0, 0}, 6);
    setlocale(LC_ALL, "C");
}

/* Every allocation fails in turn, in every reader. */
static void test_no_memory(void **state)
{
    static const rti_save_format *const formats[] = {&rti_save_png_plain, &rti_save_bmp, &rti_save_tga, &rti_save_hdr,
#ifdef RTI_HAVE_STB
                                                     &rti_save_jpg
#endif
    };
    (void)state;
    for (size_t k = 0; k < RTI_COUNT(formats); k++) {
        rti_pixels p;
        size_t size, n = 0;
        unsigned char *bytes = made(formats[k], 21, 9, 8, false, &size);
        rt_status status;
        do {
            test.calls = 0;
            test.fail_at = ++n;
            status = decode(bytes, size, &p);
            if (!status)
                rti_free(test.ctx, p.data, p.size);
            else if (status != RT_ERROR_MEMORY && status != RT_ERROR_UNSUPPORTED)
                fail_msg("%s, allocation %zu: %s", formats[k]->name, n, test_error(&test));
        } while (status == RT_ERROR_MEMORY);
        test.fail_at = 0;
        free(bytes);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_cut_everywhere, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_gif, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_sixteen_bits, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_huge, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_no_pixels, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_memory_limit, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_bmp_kinds, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_tga_kinds, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_hdr_kinds, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_damaged_png, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_not_an_image, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_paths, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_german_locale, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_no_memory, test_setup, test_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
