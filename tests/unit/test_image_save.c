/* Images written and read back, in every format; what cannot be written says so and leaves the old file. */
#include "../support/fixture.h"

#include <math.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

#include "librt/image.h"
#include "render/image.h"
#include "render/save_formats.h"
#include "kernel/srgb.h"
#include "scene/import/srgb.h"

static rt_image *picture(uint32_t width, uint32_t height)
{
    rt_image *image;
    assert_int_equal(rt_image_create(test.ctx, width, height, &image), RT_OK);
    float *p = rt_image_pixels(image);
    for (size_t i = 0; i < 4 * (size_t)width * height; i++)
        p[i] = (float)rti_srgb_decode((double)(i * 37 % 256) / 255.0);
    for (size_t i = 3; i < 4 * (size_t)width * height; i += 4)
        p[i] = (float)(i % 256) / 255.0f;
    return image;
}

static rt_status save_as(const rt_image *image, const rti_save_format *format, const char *path, const rt_save_desc *d)
{
    rti_row_writer *w;
    rt_status status =
        rti_rows_open_as(test.ctx, format, path, image->width, image->height, d, image->texts, image->text_count, &w);
    for (uint32_t y = 0; y < image->height && !status; y++)
        status = rti_rows_write(w, rti_image_row(image, y), 1);
    rt_status closed = w ? rti_rows_close(w, !status) : RT_OK;
    return status ? status : closed;
}

/* Largest difference of a channel after the round trip, of colours or of alpha. */
static double round_trip(const rti_save_format *format, uint32_t width, uint32_t height, uint32_t bits, bool alpha)
{
    rt_image *image = picture(width, height), *back;
    rt_save_desc d = rt_save_desc_default();
    double worst = 0;
    d.bits = bits;
    d.alpha = alpha;
    assert_int_equal(save_as(image, format, test_path(&test, "round"), &d), RT_OK);
    if (rt_image_load(test.ctx, test.path, &back) != RT_OK)
        fail_msg("%s %u x %u: %s", format->name, (unsigned)width, (unsigned)height, test_error(&test));
    assert_int_equal(rt_image_width(back), width);
    assert_int_equal(rt_image_height(back), height);
    for (size_t i = 0; i < 4 * (size_t)width * height; i++) {
        double want = i % 4 == 3 && !alpha ? 1.0 : image->pixels[i], difference = fabs(back->pixels[i] - want);
        worst = difference > worst ? difference : worst;
    }
    rt_image_destroy(image);
    rt_image_destroy(back);
    return worst;
}

static void test_round_trips(void **state)
{
    static const uint32_t sizes[][2] = {{1, 1}, {7, 3}, {8, 2}, {129, 5}, {300, 2}};
    (void)state;
    for (size_t i = 0; i < RTI_COUNT(sizes); i++) {
        uint32_t w = sizes[i][0], h = sizes[i][1];
        assert_true(round_trip(&rti_save_bmp, w, h, 8, false) == 0.0);
        assert_true(round_trip(&rti_save_tga, w, h, 8, false) == 0.0);
        assert_true(round_trip(&rti_save_tga, w, h, 8, true) == 0.0);
        assert_true(round_trip(&rti_save_hdr, w, h, 8, false) <= 0.5 / 128);
#ifdef RTI_HAVE_STB
        assert_true(round_trip(&rti_save_png_plain, w, h, 8, false) == 0.0);
        assert_true(round_trip(&rti_save_png_plain, w, h, 8, true) == 0.0);
        assert_true(round_trip(&rti_save_png_plain, w, h, 16, true) < 2e-5);
#ifdef RTI_HAVE_PNG
        assert_true(round_trip(&rti_save_png, w, h, 8, false) == 0.0);
        assert_true(round_trip(&rti_save_png, w, h, 8, true) == 0.0);
        assert_true(round_trip(&rti_save_png, w, h, 16, true) < 2e-5);
#endif
#endif
    }
}

#ifdef RTI_HAVE_STB
static void test_jpeg(void **state)
{
    rt_image *image, *back;
    rt_image_difference difference;
    (void)state;
    assert_int_equal(rt_image_create(test.ctx, 40, 30, &image), RT_OK);
    for (uint32_t y = 0; y < 30; y++)
        for (uint32_t x = 0; x < 40; x++)
            rti_image_row(image, y)[4 * x + 1] = (float)x / 40.0f;
    assert_int_equal(rt_image_save(image, test_path(&test, "a.JPG"), NULL), RT_OK);
    assert_int_equal(rt_image_load(test.ctx, test.path, &back), RT_OK);
    assert_int_equal(rt_image_compare(image, back, &difference, NULL), RT_OK);
    assert_true(difference.psnr > 35);
    rt_image_destroy(image);
    rt_image_destroy(back);
}
#endif

/* HDR holds what is brighter than white, to half a step of the brightest channel. */
static void test_hdr_range(void **state)
{
    static const float values[][3] = {
        {0, 0, 0},     {1, 0.5f, 0.25f}, {1000, 3, 0.1f},     {1e-5f, 2e-5f, 0}, {0.999f, 0.9999f, 1.0001f},
        {1e30f, 1, 1}, {255.6f, 1, 1},   {511.5f, 511.9f, 0}, {-1, 2, NAN},      {INFINITY, 1, 1}};
    rt_image *image, *back;
    (void)state;
    assert_int_equal(rt_image_create(test.ctx, RTI_COUNT(values), 1, &image), RT_OK);
    for (size_t i = 0; i < RTI_COUNT(values); i++)
        memcpy(image->pixels + 4 * i, values[i], sizeof values[i]);
    assert_int_equal(rt_image_save(image, test_path(&test, "a.hdr"), NULL), RT_OK);
    assert_int_equal(rt_image_load(test.ctx, test.path, &back), RT_OK);
    for (size_t i = 0; i + 2 < RTI_COUNT(values); i++) {
        float most = fmaxf(values[i][0], fmaxf(values[i][1], values[i][2]));
        for (size_t c = 0; c < 3; c++)
            assert_true(fabsf(back->pixels[4 * i + c] - values[i][c]) <= most / 256);
    }
    const float *last = back->pixels + 4 * (RTI_COUNT(values) - 2);
    assert_true(last[0] == 0.0f && last[1] == 2.0f && last[2] == 0.0f);
    assert_true(last[4] > 1e38f && isfinite(last[4]));
    rt_image_destroy(image);
    rt_image_destroy(back);
}

/* Every byte code's linear value comes back as the code, the border between two codes lies where the curve says. */
static void test_srgb_exact(void **state)
{
    static rti_srgb_encoder e;
    (void)state;
    rti_srgb_encoder_init(&e);
    for (int i = 0; i < 256; i++) {
        assert_true(rtk_srgb_table[i] == (float)rti_srgb_decode(i / 255.0));
        assert_int_equal(rti_srgb_byte(&e, rtk_srgb_table[i]), i);
    }
    for (int i = 1; i < 256; i++) {
        double v = (i - 0.5) / 255, border = v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
        assert_int_equal(rti_srgb_byte(&e, (float)(border * (1 + 1e-6))), i);
        assert_int_equal(rti_srgb_byte(&e, (float)(border * (1 - 1e-6))), i - 1);
    }
    for (float x = 1e-6f; x < 1; x *= 1.0001f) {
        double want = x <= 0.0031308f ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
        assert_true(fabs(rti_srgb_encode(x) - want) < 1e-14);
        assert_true(fabs(rti_srgb_decode(want) - x) < 1e-9); /* the curve's two pieces meet only nearly */
    }
    assert_int_equal(rti_srgb_byte(&e, NAN), 0);
    assert_int_equal(rti_srgb_byte(&e, -1), 0);
    assert_int_equal(rti_srgb_byte(&e, INFINITY), 255);
    assert_int_equal(rti_srgb_byte(&e, 1e-40f), 0);
}

static uint8_t saved_byte(float value, float exposure, rt_tone tone)
{
    rt_image *image;
    rt_save_desc d = rt_save_desc_default();
    size_t size;
    d.exposure = exposure;
    d.tone = tone;
    assert_int_equal(rt_image_create(test.ctx, 1, 1, &image), RT_OK);
    image->pixels[0] = image->pixels[1] = image->pixels[2] = value;
    assert_int_equal(rt_image_save(image, test_path(&test, "one.tga"), &d), RT_OK);
    rt_image_destroy(image);
    unsigned char *bytes = test_slurp(test.path, &size);
    uint8_t got = bytes[18];
    free(bytes);
    return got;
}

static void test_exposure_and_tone(void **state)
{
    (void)state;
    assert_int_equal(saved_byte(0.25f, 0, RT_TONE_NONE), 137);
    assert_int_equal(saved_byte(0.0625f, 2, RT_TONE_NONE), 137);
    assert_int_equal(saved_byte(0.5f, -1, RT_TONE_NONE), 137);
    assert_int_equal(saved_byte(0.25f * 0.70710678f, 0.5f, RT_TONE_NONE), 137);
    assert_int_equal(saved_byte(7, 0, RT_TONE_NONE), 255);
    assert_int_equal(saved_byte(NAN, 0, RT_TONE_NONE), 0);
    assert_int_equal(saved_byte(0, 0, RT_TONE_FILMIC), 0);
    assert_int_equal(saved_byte(0.18f, 0, RT_TONE_FILMIC), 141); /* 0.2669 */
    assert_int_equal(saved_byte(1, 0, RT_TONE_FILMIC), 232);     /* 0.8038 */
    assert_int_equal(saved_byte(1e30f, 0, RT_TONE_FILMIC), 255);
}

static void test_texts(void **state)
{
    rt_image *image = picture(3, 3);
    size_t size;
    rt_save_desc d = rt_save_desc_default();
    (void)state;
    assert_int_equal(rt_image_set_text(image, "Scene", "paper.lua"), RT_OK);
    assert_int_equal(rt_image_set_text(image, "Author", "M\xc3\xbcller"), RT_OK);
    for (int plain = 0; plain < 2; plain++) {
        for (int none = 0; none < 2; none++) {
            d.no_text = none;
#ifdef RTI_HAVE_PNG
            const rti_save_format *format = plain ? &rti_save_png_plain : &rti_save_png;
#else
            const rti_save_format *format = &rti_save_png_plain;
#endif
            assert_int_equal(save_as(image, format, test_path(&test, "texts.png"), &d), RT_OK);
            unsigned char *bytes = test_slurp(test.path, &size);
            int found = 0;
            for (size_t i = 0; i + 16 < size; i++)
                found += memcmp(bytes + i, "Scene\0", 6) == 0 || memcmp(bytes + i, "M\xc3\xbcller", 7) == 0;
            assert_int_equal(found, none ? 0 : 2);
            free(bytes);
        }
    }
    rt_image_destroy(image);
}

static void test_same_bytes(void **state)
{
    static const char *const names[] = {"a.png", "a.jpg", "a.bmp", "a.tga", "a.hdr"};
    rt_image *image = picture(33, 17);
    (void)state;
    for (size_t i = 0; i < RTI_COUNT(names); i++) {
        size_t size[2];
        rt_status status = rt_image_save(image, test_path(&test, names[i]), NULL);
        if (status == RT_ERROR_UNSUPPORTED)
            continue;
        assert_int_equal(status, RT_OK);
        unsigned char *first = test_slurp(test.path, &size[0]);
        assert_int_equal(rt_image_save(image, test.path, NULL), RT_OK);
        unsigned char *second = test_slurp(test.path, &size[1]);
        assert_int_equal(size[0], size[1]);
        assert_memory_equal(first, second, size[0]);
        free(first);
        free(second);
    }
    rt_image_destroy(image);
}

static void refuse(const rt_image *image, const char *path, rt_save_desc d, rt_status expected, const char *words)
{
    assert_int_equal(rt_image_save(image, path, &d), expected);
    test_says(&test, words);
}

static void test_refused(void **state)
{
    rt_image *image = picture(4, 4);
    rt_save_desc d = rt_save_desc_default(), bad;
    (void)state;
    refuse(image, test_path(&test, "a.pgn"), d, RT_ERROR_UNSUPPORTED, "did you mean 'png'? known are png,");
    refuse(image, test_path(&test, "noending"), d, RT_ERROR_UNSUPPORTED, "no ending");
    refuse(image, "-", d, RT_ERROR_UNSUPPORTED, "no ending");
    refuse(image, "/nowhere at all/a.png", d, RT_ERROR_IO, "no such file or folder");
    bad = d, bad.bits = 12;
    refuse(image, test_path(&test, "a.png"), bad, RT_ERROR_ARGUMENT, "bits is 12");
    bad = d, bad.bits = 16;
    refuse(image, test_path(&test, "a.bmp"), bad, RT_ERROR_UNSUPPORTED, "bmp files have 8 bits");
    bad = d, bad.quality = 0;
    refuse(image, test_path(&test, "a.jpg"), bad, RT_ERROR_ARGUMENT, "quality is 0");
    bad = d, bad.exposure = NAN;
    refuse(image, test_path(&test, "a.png"), bad, RT_ERROR_ARGUMENT, "exposure is nan");
    bad = d, bad.tone = (rt_tone)9;
    refuse(image, test_path(&test, "a.png"), bad, RT_ERROR_ARGUMENT, "tone is 9");
    bad = d, bad.struct_size = 0;
    refuse(image, test_path(&test, "a.png"), bad, RT_ERROR_ARGUMENT, "");
    assert_int_not_equal(access(test_path(&test, "a.png"), F_OK), 0);
    rt_image_destroy(image);
}

/* The disk is full, or the file too large for the process: a sentence, and the old file as it was. */
static void test_full_disk(void **state)
{
    static const char *const formats[] = {"png", "jpg", "bmp", "tga", "hdr"};
    rt_image *image = picture(200, 200);
    rt_save_desc d = rt_save_desc_default();
    (void)state;
    for (size_t i = 0; i < RTI_COUNT(formats); i++) {
        d.format = formats[i];
        rt_status status = rt_image_save(image, "/dev/full", &d);
        if (status == RT_ERROR_UNSUPPORTED)
            continue;
        assert_int_equal(status, RT_ERROR_IO);
        test_says(&test, "the disk is full");
    }
    rt_image_destroy(image);
}

/* A disk that fills up while the file is being written: the old one stays, nothing is left beside it. */
static void test_no_room_half_way(void **state)
{
    static const char *const names[] = {"old.png", "old.jpg", "old.bmp", "old.tga", "old.hdr"};
    struct rlimit before, small;
    rt_image *image = picture(400, 400);
    (void)state;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    signal(SIGXFSZ, SIG_IGN);
    small = before;
    small.rlim_cur = 2000;
    for (size_t i = 0; i < RTI_COUNT(names); i++) {
        size_t size;
        test_file(&test, names[i], "old", 3);
        setrlimit(RLIMIT_FSIZE, &small);
        rt_status status = rt_image_save(image, test.path, NULL);
        setrlimit(RLIMIT_FSIZE, &before);
        assert_true(status == RT_ERROR_IO || status == RT_ERROR_UNSUPPORTED);
        if (status == RT_ERROR_IO)
            test_says(&test, "too large");
        unsigned char *bytes = test_slurp(test.path, &size);
        assert_int_equal(size, 3);
        assert_memory_equal(bytes, "old", 3);
        free(bytes);
        assert_int_equal(unlink(test.path), 0);
    }
    signal(SIGXFSZ, SIG_DFL);
    assert_int_equal(rmdir(test.folder), 0); /* it is empty */
    rt_image_destroy(image);
}

static void test_old_file_stays(void **state)
{
    rti_row_writer *w;
    float row[4 * 5] = {0};
    size_t size;
    (void)state;
    const char *path = test_file(&test, "old.png", "old", 3);
    for (int reason = 0; reason < 3; reason++) {
        assert_int_equal(rti_rows_open(test.ctx, path, 5, 4, NULL, NULL, 0, &w), RT_OK);
        assert_int_equal(rti_rows_write(w, row, 1), RT_OK);
        if (reason == 0) { /* not wanted */
            assert_int_equal(rti_rows_close(w, false), RT_OK);
        } else if (reason == 1) { /* rows missing */
            assert_int_equal(rti_rows_close(w, true), RT_ERROR_STATE);
            test_says(&test, "only 1 of the image's 4 rows");
        } else { /* too many */
            float many[4 * 5 * 4] = {0};
            assert_int_equal(rti_rows_write(w, many, 4), RT_ERROR_STATE);
            assert_int_equal(rti_rows_close(w, true), RT_ERROR_STATE);
        }
        unsigned char *bytes = test_slurp(path, &size);
        assert_int_equal(size, 3);
        free(bytes);
    }
}

static void test_standard_output(void **state)
{
    rt_image *image = picture(3, 2);
    rt_save_desc d = rt_save_desc_default();
    size_t size;
    (void)state;
    d.format = "bmp";
    fflush(stdout);
    FILE *f = fopen(test_path(&test, "out"), "wb");
    assert_non_null(f);
    int kept = dup(1);
    dup2(fileno(f), 1);
    rt_status status = rt_image_save(image, "-", &d);
    dup2(kept, 1);
    close(kept);
    fclose(f);
    assert_int_equal(status, RT_OK);
    unsigned char *bytes = test_slurp(test.path, &size);
    assert_int_equal(size, 54 + 12 * 2);
    free(bytes);
    rt_image_destroy(image);
}

static void test_no_memory(void **state)
{
    static const rti_save_format *const formats[] = {&rti_save_png_plain, &rti_save_bmp, &rti_save_tga, &rti_save_hdr,
#ifdef RTI_HAVE_PNG
                                                     &rti_save_png,
#endif
#ifdef RTI_HAVE_STB
                                                     &rti_save_jpg
#endif
    };
    rt_image *image = picture(9, 9);
    (void)state;
    rt_image_set_text(image, "Title", "x");
    test_path(&test, "a");
    for (size_t k = 0; k < RTI_COUNT(formats); k++) {
        rt_status status;
        size_t n = 0;
        do {
            test.calls = 0;
            test.fail_at = ++n;
            status = save_as(image, formats[k], test.path, NULL);
            if (status && status != RT_ERROR_MEMORY)
                fail_msg("%s, allocation %zu: %s", formats[k]->name, n, test_error(&test));
            assert_true(status == RT_OK || access(test.path, F_OK) != 0);
        } while (status);
        test.fail_at = 0;
        assert_true(n > 3);
        unlink(test.path);
    }
    rt_image_destroy(image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_round_trips, test_setup, test_teardown),
#ifdef RTI_HAVE_STB
        cmocka_unit_test_setup_teardown(test_jpeg, test_setup, test_teardown),
#endif
        cmocka_unit_test_setup_teardown(test_hdr_range, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_srgb_exact, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_exposure_and_tone, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_texts, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_same_bytes, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_refused, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_full_disk, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_no_room_half_way, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_old_file_stays, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_standard_output, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_no_memory, test_setup, test_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
