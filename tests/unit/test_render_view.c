/* What is seen: backgrounds, filters, views of values, masks. */
#include "render_stage.h"

static void test_empty_scene_is_its_background(void **state)
{
    rt_render_desc d = settings(5, 9, 1, "whitted");
    rt_image *image;
    (void)state;
    set_world(scene, v3(0.25f, 0, 0), v3(0.75f, 1, 0));
    look_parallel(scene, v3(0, 0, 0), v3(0, -1, -1), v3(0, 1, 0), 1);
    image = commit_and_render(&d);
    near_to(pixel(image, 2, 3)[0], 0.25 + 0.5 * (0.5 - 0.5 * sqrt(0.5)), 1e-6);
    near_to(pixel(image, 2, 3)[1], 0.5 - 0.5 * sqrt(0.5), 1e-6);
    near_to(pixel(image, 2, 3)[3], 0, 0);
    rt_image_destroy(image);
}

/* A map of 4 x 2 texels, one colour each, seen along the axes: the middle is -z, right of it +x, the upper row is +y. */
static void test_background_map(void **state)
{
    static const float texels[8][3] = {{0.1f, 0, 0}, {0.2f, 0, 0}, {0.3f, 0, 0}, {0.4f, 0, 0},
                                       {0.5f, 0, 0}, {0.6f, 0, 0}, {0.7f, 0, 0}, {0.8f, 0, 0}};
    static const struct {
        rt_vec3 to;
        float want;
    } looks[] = {{{0.1f, 1, -1}, 0.3f},  {{-0.1f, 1, -1}, 0.2f}, {{0.1f, -1, -1}, 0.7f}, {{1, 1, 0.1f}, 0.4f},
                 {{1, -1, -0.1f}, 0.7f}, {{-1, 1, 0.1f}, 0.1f},  {{-0.1f, -1, 1}, 0.5f}, {{0.1f, -1, 1}, 0.8f}};
    rt_render_desc d = settings(1, 1, 1, "whitted");
    rt_texture_desc t = rt_texture_desc_default();
    rt_world_desc w = rt_world_desc_default();
    (void)state;
    t.width = 4;
    t.height = 2;
    t.pixels = texels;
    t.format = RT_PIXEL_RGB32F;
    t.nearest = 1;
    OK(rt_scene_add_texture(scene, &t, &w.background_texture));
    OK(rt_scene_set_world(scene, &w));
    for (size_t i = 0; i < sizeof looks / sizeof *looks; i++) {
        rt_image *image;
        look_parallel(scene, v3(0, 0, 0), looks[i].to, v3(0, 1, 0.01f), 1);
        image = commit_and_render(&d);
        near_to(pixel(image, 0, 0)[0], looks[i].want, 1e-6);
        rt_image_destroy(image);
    }
}

/* A map's upper half is bright, its lower half dark, and so are its left and right end's columns: at the poles its ends do not
 * mix, and towards +z its first and last columns do. */
static void test_background_map_at_its_ends(void **state)
{
    enum { W = 16, H = 8 };
    float texels[W * H][3] = {{0}};
    rt_render_desc d = settings(1, 1, 1, "whitted");
    rt_texture_desc t = rt_texture_desc_default();
    rt_world_desc w = rt_world_desc_default();
    (void)state;
    for (int i = 0; i < W * H; i++) {
        texels[i][0] = i < W * H / 2 ? 1.0f : 0.0f;
        texels[i][1] = i % W < W / 2 ? 1.0f : 0.0f;
    }
    t.width = W;
    t.height = H;
    t.pixels = texels;
    t.format = RT_PIXEL_RGB32F;
    for (int kind = 0; kind < 4; kind++) {
        rt_image *image;
        t.wrap = kind & 1 ? RT_WRAP_CLAMP : RT_WRAP_REPEAT;
        t.nearest = kind >> 1;
        OK(rt_scene_add_texture(scene, &t, &w.background_texture));
        OK(rt_scene_set_world(scene, &w));
        look_parallel(scene, v3(0, 0, 0), v3(0, 1, 0), v3(0, 0, 1), 1);
        image = commit_and_render(&d);
        near_to(pixel(image, 0, 0)[0], 1, 0);
        rt_image_destroy(image);
        look_parallel(scene, v3(0, 0, 0), v3(0, -1, 0), v3(0, 0, 1), 1);
        image = commit_and_render(&d);
        near_to(pixel(image, 0, 0)[0], 0, 0);
        rt_image_destroy(image);
        look_parallel(scene, v3(0, 0, 0), v3(0, 0.2f, 1), v3(0, 1, 0), 1);
        image = commit_and_render(&d);
        near_to(pixel(image, 0, 0)[1], t.nearest ? 0 : 0.5, t.nearest ? 1 : 1e-5);
        rt_image_destroy(image);
    }
}

/* Every mean of the filter is the pixel's middle; the Gaussian reaches into its neighbours. */
static void test_filters(void **state)
{
    rt_render_desc d = settings(9, 1, 1024, "whitted");
    rt_image *image;
    (void)state;
    sky_compass();
    d.filter = RT_FILTER_GAUSSIAN;
    OK(rt_scene_commit(scene, NULL));
    look(scene, v3(0, 0, 0), v3(1, 0, 0), 60);
    image = commit_and_render(&d);
    near_to(pixel(image, 4, 0)[0], 0.5, 2e-3);
    rt_image_destroy(image);
}

static void test_debug_views(void **state)
{
    rt_render_desc d = settings(8, 8, 16, "depth");
    rt_image *image;
    (void)state;
    floor_from_above(add_material(scene, v3(1, 1, 1), 1, 0, 0, 0));
    image = commit_and_render(&d);
    near_to(pixel(image, 3, 3)[0], 5, 1e-5);
    rt_image_destroy(image);
    d.integrator = "normal";
    image = render(scene, &d);
    near_to(pixel(image, 3, 3)[0], 0.5, 0);
    near_to(pixel(image, 3, 3)[1], 1, 0);
    rt_image_destroy(image);
    d.integrator = "id";
    image = render(scene, &d);
    assert_memory_equal(pixel(image, 0, 0), pixel(image, 7, 7), 16);
    assert_true(pixel(image, 0, 0)[0] >= 0.2f);
    rt_image_destroy(image);
    d.integrator = "uv";
    image = render(scene, &d);
    assert_true(memcmp(pixel(image, 0, 0), pixel(image, 7, 0), 16) != 0);
    rt_image_destroy(image);
    d.integrator = "cost";
    d.tracer = "brute";
    image = render(scene, &d);
    assert_true(pixel(image, 0, 0)[2] > 0);
    rt_image_destroy(image);
}

/* Bodies are seen by the kinds of rays that their mask names. */
static float floor_under(uint32_t mask, float *seen)
{
    rt_render_desc d = settings(1, 1, 1, "whitted");
    rt_scene *s;
    rt_sphere_desc ball = rt_sphere_desc_default();
    rt_image *image;
    float lit;
    OK(rt_scene_create(ctx, &s));
    add_plane(s, v3(0, 0, 0), v3(0, 1, 0), add_material(s, v3(1, 1, 1), 0.5f, 0.5f, 0, 0));
    ball.center = v3(0, 3, 0);
    ball.radius = 1;
    ball.common.mask = mask;
    ball.common.material = add_material(s, v3(0, 0, 0), 1, 0, 0, 0); /* black: it shows as nothing of the sky */
    OK(rt_scene_add_sphere(s, &ball, NULL));
    add_light(s, light(RT_LIGHT_DIRECTIONAL, v3(0, -1, 0), v3(1, 1, 1), RT_FALLOFF_NONE));
    set_world(s, v3(0.25f, 0.25f, 0.25f), v3(0.25f, 0.25f, 0.25f));
    look_parallel(s, v3(0, 0.5f, 0), v3(0, 0, 0), v3(0, 0, -1), 0.01f);
    OK(rt_scene_commit(s, NULL));
    image = render(s, &d);
    lit = pixel(image, 0, 0)[0];
    rt_image_destroy(image);
    look_parallel(s, v3(0, 3, 5), v3(0, 3, 0), v3(0, 1, 0), 0.01f);
    OK(rt_scene_commit(s, NULL));
    image = render(s, &d);
    *seen = pixel(image, 0, 0)[3];
    rt_image_destroy(image);
    rt_scene_destroy(s);
    return lit;
}

static void test_masks(void **state)
{
    float seen;
    (void)state;
    near_to(floor_under(RT_MASK_ALL, &seen), 0, 1e-6);
    near_to(seen, 1, 0);
    near_to(floor_under(RT_MASK_ALL & ~(uint32_t)RT_MASK_SHADOW, &seen), 0.5, 1e-6);
    near_to(floor_under(RT_MASK_ALL & ~(uint32_t)RT_MASK_REFLECTION, &seen), 0.125, 1e-6);
    near_to(seen, 1, 0);
    near_to(floor_under(RT_MASK_ALL & ~(uint32_t)RT_MASK_CAMERA, &seen), 0, 1e-6);
    near_to(seen, 0, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_DARK(test_empty_scene_is_its_background),
        IN_DARK(test_debug_views),
        IN_DARK(test_filters),
        IN_DARK(test_background_map),
        IN_DARK(test_background_map_at_its_ends),
        IN_DARK(test_masks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
