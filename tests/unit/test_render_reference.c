/* The pictures are right: small renders against those in tests/reference, with a bound for each pixel and a narrower one for what
 * an eye sees from afar (means of 4 x 4 pixels). A failure leaves what it got and the difference beside the test, as NAME.got.png
 * and NAME.diff.png. LIBRT_REFERENCE_WRITE=1 writes the references anew: look at them before they are committed. */
#include <stdio.h>

#include "render_stage.h"

#define WIDTH  160u
#define HEIGHT 120u

static int setup(void **state)
{
    (void)state;
    stage(2);
    OK(rt_scene_create(ctx, &child));
    return 0;
}

static float encoded(float x)
{
    float c = x > 0 ? (x < 1 ? x : 1) : 0;
    return c <= 0.0031308f ? 12.92f * c : 1.055f * powf(c, 1 / 2.4f) - 0.055f;
}

/* Largest difference of the encoded means of edge x edge pixels. */
static double worst(const rt_image *a, const rt_image *b, uint32_t edge)
{
    double most = 0;
    for (uint32_t y = 0; y + edge <= HEIGHT; y += edge) {
        for (uint32_t x = 0; x + edge <= WIDTH; x += edge) {
            for (int c = 0; c < 3; c++) {
                double sum = 0;
                for (uint32_t i = 0; i < edge * edge; i++)
                    sum += encoded(pixel(a, x + i % edge, y + i / edge)[c]) - encoded(pixel(b, x + i % edge, y + i / edge)[c]);
                sum = fabs(sum) / (edge * edge);
                most = sum > most ? sum : most;
            }
        }
    }
    return most;
}

static void leave(const rt_image *got, const rt_image *map, const char *name)
{
    char path[256];
    snprintf(path, sizeof path, "%s.got.png", name);
    rt_image_save(got, path, NULL);
    snprintf(path, sizeof path, "%s.diff.png", name);
    rt_image_save(map, path, NULL);
}

static void against_reference(const char *name, const char *integrator, uint32_t samples, double pixel_bound, double far_bound)
{
    rt_render_desc d = settings(WIDTH, HEIGHT, samples, integrator);
    const char *folder = getenv("LIBRT_REFERENCES");
    char path[512];
    rt_image *got, *want = NULL, *map = NULL;
    double near_by, far_off;
    rt_status status;
    OK(rt_scene_commit(scene, NULL));
    d.workers = 2;
    got = render(scene, &d);
    snprintf(path, sizeof path, "%s/%s.png", folder ? folder : "tests/reference", name);
    if (getenv("LIBRT_REFERENCE_WRITE"))
        OK(rt_image_save(got, path, NULL));
    status = rt_image_load(ctx, path, &want);
    if (status == RT_ERROR_UNSUPPORTED) {
        rt_image_destroy(got);
        print_message("skipped: this build reads no %s\n", path);
        skip();
    }
    OK(status);
    near_by = worst(got, want, 1);
    far_off = worst(got, want, 4);
    if (near_by > pixel_bound || far_off > far_bound) {
        OK(rt_image_compare(got, want, NULL, &map));
        leave(got, map, name);
        fail_msg("%s: a pixel is off by %.4f (bound %.4f), a patch by %.4f (bound %.4f); see %s.got.png, %s.diff.png", name,
                 near_by, pixel_bound, far_off, far_bound, name, name);
    }
    rt_image_destroy(got);
    rt_image_destroy(want);
    rt_image_destroy(map);
}

/* One step of 8 bits is 0.0039. Edges and noise may move by a sample; patches may not. */
static void test_everything_whitted(void **state)
{
    (void)state;
    add_everything(scene);
    against_reference("everything-whitted", "whitted", 16, 0.08, 0.008);
}

static void test_everything_path(void **state)
{
    (void)state;
    add_everything(scene);
    against_reference("everything-path", "path", 16, 0.25, 0.03);
}

static void test_shapes_whitted(void **state)
{
    (void)state;
    add_shapes(scene, child);
    against_reference("shapes-whitted", "whitted", 16, 0.08, 0.008);
}

static void test_shapes_normal(void **state)
{
    (void)state;
    add_shapes(scene, child);
    against_reference("shapes-normal", "normal", 1, 0.9, 0.06);
}

static void test_shapes_uv(void **state)
{
    (void)state;
    add_shapes(scene, child);
    against_reference("shapes-uv", "uv", 1, 1.0, 0.2);
}

static void test_shapes_ao(void **state)
{
    (void)state;
    add_shapes(scene, child);
    against_reference("shapes-ao", "ao", 16, 0.2, 0.02);
}

#define T(name) cmocka_unit_test_setup_teardown(name, setup, teardown)
int main(void)
{
    const struct CMUnitTest tests[] = {
        T(test_everything_whitted), T(test_everything_path), T(test_shapes_whitted),
        T(test_shapes_normal),      T(test_shapes_uv),       T(test_shapes_ao),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
