/* Textures: what is stored, and what a lookup gives. */
#include "scene_kit.h"

#include <math.h>

#include "kernel/texture.h"
#include "scene/snapshot.h"

typedef struct fixture {
    rt_context *ctx;
    rt_scene *scene;
    rti_snapshot *snapshot;
} fixture;

/* A committed scene with this one texture; the lookup's view of it. */
static rtk_texture make(fixture *f, uint32_t width, uint32_t height, rt_pixel_format format, const void *pixels, rt_wrap wrap,
                        int linear, int nearest)
{
    rt_texture_desc d = rt_texture_desc_default();
    rt_texture t;
    f->ctx = kit_context(NULL, 1);
    f->scene = kit_scene(f->ctx);
    d.width = width;
    d.height = height;
    d.format = format;
    d.pixels = pixels;
    d.wrap = wrap;
    d.linear = linear;
    d.nearest = nearest;
    kit_ok(f->ctx, rt_scene_add_texture(f->scene, &d, &t));
    kit_ok(f->ctx, rt_scene_commit(f->scene, NULL));
    f->snapshot = rti_scene_snapshot(f->scene);
    return rti_snapshot_view(f->snapshot)->textures[t.id];
}

static void drop(fixture *f)
{
    rti_snapshot_release(f->snapshot);
    rt_scene_destroy(f->scene);
    rt_context_destroy(f->ctx);
}

static void assert_color(rtk_texture t, float u, float v, float footprint, float r, float g, float b, float a)
{
    float c[4];
    rtk_texture_sample(t, u, v, footprint, c);
    if (fabsf(c[0] - r) > 1e-6f || fabsf(c[1] - g) > 1e-6f || fabsf(c[2] - b) > 1e-6f || fabsf(c[3] - a) > 1e-6f)
        fail_msg("at (%g, %g) over %g: %g %g %g %g, not %g %g %g %g", (double)u, (double)v, (double)footprint, (double)c[0],
                 (double)c[1], (double)c[2], (double)c[3], (double)r, (double)g, (double)b, (double)a);
}

/* Middles of texels give the texels; v grows upwards; between them it is linear; beyond them it wraps. */
static void test_lookup(void **state)
{
    static const uint8_t pixels[] = {255, 0, 0,   0,   255, 0, /* top row: red, green */
                                     0,   0, 255, 255, 255, 255};
    fixture f;
    rtk_texture t = make(&f, 2, 2, RT_PIXEL_RGB8, pixels, RT_WRAP_REPEAT, 0, 0);
    (void)state;
    assert_color(t, 0.25f, 0.75f, 0, 1, 0, 0, 1);
    assert_color(t, 0.75f, 0.75f, 0, 0, 1, 0, 1);
    assert_color(t, 0.25f, 0.25f, 0, 0, 0, 1, 1);
    assert_color(t, 0.75f, 0.25f, 0, 1, 1, 1, 1);
    assert_color(t, 0.5f, 0.75f, 0, 0.5f, 0.5f, 0, 1);
    assert_color(t, 0.5f, 0.5f, 0, 0.5f, 0.5f, 0.5f, 1);
    assert_color(t, 0, 0.75f, 0, 0.5f, 0.5f, 0, 1);
    assert_color(t, 5.25f, -3.25f, 0, 1, 0, 0, 1);
    assert_color(t, 0.25f, 0.75f, 9, 0.5028865f, 0.5028865f, 0.5028865f, 1); /* the coarsest level: the code next to the mean */
    assert_color(t, NAN, INFINITY, 0, 0.5f, 0.5f, 0.5f, 1);
    assert_color(t, 0.25f, 0.75f, NAN, 1, 0, 0, 1);
    drop(&f);
    t = make(&f, 2, 2, RT_PIXEL_RGB8, pixels, RT_WRAP_CLAMP, 0, 0);
    assert_color(t, 0, 0.75f, 0, 1, 0, 0, 1);
    assert_color(t, -7, 9, 0, 1, 0, 0, 1);
    assert_color(t, 7, -9, 0, 1, 1, 1, 1);
    drop(&f);
    t = make(&f, 2, 2, RT_PIXEL_RGB8, pixels, RT_WRAP_REPEAT, 0, 1);
    assert_int_equal(t.head->level_count, 1);
    assert_color(t, 0.49f, 0.51f, 9, 1, 0, 0, 1);
    assert_color(t, 0.51f, 0.49f, 9, 1, 1, 1, 1);
    assert_color(t, 1.0f, 1.0f, 0, 0, 0, 1, 1);
    drop(&f);
}

/* Every 8-bit code decodes to the value of the curve, computed here in double. */
static void test_srgb(void **state)
{
    uint8_t pixels[256];
    fixture f;
    rtk_texture t;
    (void)state;
    for (int i = 0; i < 256; i++)
        pixels[i] = (uint8_t)i;
    t = make(&f, 256, 1, RT_PIXEL_GRAY8, pixels, RT_WRAP_REPEAT, 0, 1);
    for (int i = 0; i < 256; i++) {
        double c = i / 255.0, l = c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
        assert_color(t, ((float)i + 0.5f) / 256, 0.5f, 0, (float)l, (float)l, (float)l, 1);
    }
    drop(&f);
    t = make(&f, 256, 1, RT_PIXEL_GRAY8, pixels, RT_WRAP_REPEAT, 1, 1);
    for (int i = 0; i < 256; i++)
        assert_color(t, ((float)i + 0.5f) / 256, 0.5f, 0, (float)i / 255, (float)i / 255, (float)i / 255, 1);
    drop(&f);
}

static uint32_t seed = 5;

/* Every texel of every size comes back from its place, and every level has the mean of the image, odd sizes too. */
static void test_levels(void **state)
{
    static const uint32_t sizes[][2] = {{1, 1}, {7, 3}, {8, 8}, {9, 17}, {33, 1}, {1, 40}, {100, 64}, {255, 5}};
    (void)state;
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        uint32_t w = sizes[s][0], h = sizes[s][1];
        float *pixels = malloc(sizeof(float) * 4 * w * h);
        double mean[4] = {0};
        fixture f;
        rtk_texture t;
        for (uint32_t i = 0; i < 4 * w * h; i++) {
            pixels[i] = i % 4 == 3 ? 1.0f : kit_unit(&seed);
            mean[i % 4] += pixels[i] / (double)(w * h);
        }
        t = make(&f, w, h, RT_PIXEL_RGBA32F, pixels, RT_WRAP_CLAMP, 0, 0);
        for (uint32_t y = 0; y < h; y++) {
            for (uint32_t x = 0; x < w; x++) {
                float c[4];
                rtk_texel(t, 0, x, h - 1 - y, c);
                assert_memory_equal(c, pixels + 4 * (y * w + x), sizeof c);
            }
        }
        assert_int_equal(rtk_level_size(w, t.head->level_count - 1), 1);
        assert_int_equal(rtk_level_size(h, t.head->level_count - 1), 1);
        for (uint32_t level = 0; level < t.head->level_count; level++) {
            uint32_t lw = rtk_level_size(w, level), lh = rtk_level_size(h, level);
            double sum[4] = {0};
            for (uint32_t i = 0; i < lw * lh; i++) {
                float c[4];
                rtk_texel(t, level, i % lw, i / lw, c);
                for (int k = 0; k < 4; k++)
                    sum[k] += c[k] / (double)(lw * lh);
            }
            for (int k = 0; k < 4; k++)
                assert_true(fabs(sum[k] - mean[k]) < 1e-5);
        }
        drop(&f);
        free(pixels);
    }
}

/* What a cut-out hides does not bleed into its rim; alpha itself is averaged. */
static void test_alpha(void **state)
{
    static const uint8_t pixels[] = {0, 255, 0, 255, 255, 0, 255, 0, 0, 255, 0, 255, 255, 0, 255, 0};
    fixture f;
    rtk_texture t = make(&f, 2, 2, RT_PIXEL_RGBA8, pixels, RT_WRAP_REPEAT, 0, 0);
    float c[4];
    (void)state;
    assert_true(t.head->flags & RTK_TEX_ALPHA);
    rtk_texel(t, 1, 0, 0, c);
    assert_true(c[0] == 0 && c[1] == 1 && c[2] == 0 && fabsf(c[3] - 0.5f) < 0.003f);
    drop(&f);
}

/* The level follows the footprint: halves of a checkerboard's contrast, monotone. */
static void test_footprint(void **state)
{
    uint8_t pixels[64 * 64];
    fixture f;
    rtk_texture t;
    float before = 2.0f;
    (void)state;
    for (int i = 0; i < 64 * 64; i++)
        pixels[i] = (i / 64 / 8 + i / 8) % 2 ? 255 : 0;
    t = make(&f, 64, 64, RT_PIXEL_GRAY8, pixels, RT_WRAP_REPEAT, 1, 0);
    assert_true(rtk_texture_level(t, 1.0f / 64) == 0 && rtk_texture_level(t, 1.0f / 32) == 1 && rtk_texture_level(t, 0.25f) == 4);
    for (float footprint = 1.0f / 128; footprint < 4; footprint *= 1.09f) {
        float light[4], dark[4], contrast;
        rtk_texture_sample(t, 12.0f / 64, 4.0f / 64, footprint, light);
        rtk_texture_sample(t, 4.0f / 64, 4.0f / 64, footprint, dark);
        contrast = fabsf(light[0] - dark[0]);
        assert_true(contrast <= before + 1e-6f);
        before = contrast;
    }
    assert_true(before < 0.01f);
    drop(&f);
}

static void test_bad_floats(void **state)
{
    static const float pixels[] = {NAN, 1, 1, 1, INFINITY, 1, 1, 1, -INFINITY, 1, 1, 1};
    fixture f;
    rtk_texture t = make(&f, 2, 2, RT_PIXEL_RGB32F, pixels, RT_WRAP_REPEAT, 0, 0);
    (void)state;
    for (uint32_t level = 0; level < 2; level++) {
        for (uint32_t i = 0; i < 4u >> (2 * level); i++) {
            float c[4];
            rtk_texel(t, level, i % 2, i / 2, c);
            assert_true(isfinite(c[0]) && isfinite(c[1]) && isfinite(c[2]));
        }
    }
    drop(&f);
}

static void test_refusals(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx);
    rt_texture_desc d = rt_texture_desc_default();
    uint8_t pixel[4] = {0};
    (void)state;
    assert_int_equal(rt_scene_add_texture(scene, &d, NULL), RT_ERROR_ARGUMENT);
    kit_says(ctx, "rt_scene_add_texture: the size is 0 x 0; width and height must be from 1 to 65536");
    d.width = d.height = 1;
    assert_int_equal(rt_scene_add_texture(scene, &d, NULL), RT_ERROR_ARGUMENT);
    kit_says(ctx, "pixels is NULL");
    d.pixels = pixel;
    d.format = (rt_pixel_format)9;
    assert_int_equal(rt_scene_add_texture(scene, &d, NULL), RT_ERROR_ARGUMENT);
    kit_says(ctx, "format is 9");
    d.format = RT_PIXEL_RGB8;
    d.wrap = (rt_wrap)2;
    assert_int_equal(rt_scene_add_texture(scene, &d, NULL), RT_ERROR_ARGUMENT);
    kit_says(ctx, "wrap is 2");
    assert_int_equal(rt_scene_load_texture(scene, NULL, NULL, NULL), RT_ERROR_ARGUMENT);
    kit_says(ctx, "path is NULL");
    assert_int_equal(rt_scene_load_texture(scene, "/no/such/picture.png", NULL, NULL), RT_ERROR_IO);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_lookup),    cmocka_unit_test(test_srgb),
                                       cmocka_unit_test(test_levels),    cmocka_unit_test(test_alpha),
                                       cmocka_unit_test(test_footprint), cmocka_unit_test(test_bad_floats),
                                       cmocka_unit_test(test_refusals)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
