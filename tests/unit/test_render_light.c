/* Lights, against closed forms: directional, points, spheres with and without bodies, very many. */
#include "render_stage.h"

/* Centre of pixel (x, y) of an 8 x 8 window of edge 4 on the floor. */
static rt_vec3 floor_point(uint32_t x, uint32_t y)
{
    return v3(-2 + 0.5f * ((float)x + 0.5f), 0, -2 + 0.5f * ((float)y + 0.5f));
}

static void test_directional(void **state)
{
    rt_render_desc d = settings(8, 8, 1, "whitted");
    rt_image *image;
    (void)state;
    floor_from_above(add_material(scene, v3(1, 0.5f, 0.25f), 0.5f, 0, 0, 0));
    add_light(scene, light(RT_LIGHT_DIRECTIONAL, v3(1, -1, 0), v3(2, 2, 2), RT_FALLOFF_NONE));
    image = commit_and_render(&d);
    near_to(pixel(image, 4, 4)[0], sqrt(0.5), 1e-6);
    near_to(pixel(image, 0, 7)[1], 0.5 * sqrt(0.5), 1e-6);
    near_to(pixel(image, 0, 7)[2], 0.25 * sqrt(0.5), 1e-6);
    near_to(pixel(image, 0, 7)[3], 1, 0);
    rt_image_destroy(image);
}

static void point_light(rt_falloff falloff)
{
    rt_render_desc d = settings(8, 8, 1, "whitted");
    rt_image *image;
    floor_from_above(add_material(scene, v3(1, 1, 1), 1, 0, 0, 0));
    add_light(scene, light(RT_LIGHT_POINT, v3(0.5f, 2, 0), v3(3, 3, 3), falloff));
    image = commit_and_render(&d);
    for (uint32_t y = 0; y < 8; y += 7) {
        for (uint32_t x = 0; x < 8; x += 3) {
            rt_vec3 p = floor_point(x, y);
            double dx = 0.5 - p.x, dz = -p.z, d2 = dx * dx + 4 + dz * dz, cosine = 2 / sqrt(d2);
            near_to(pixel(image, x, y)[1], 3 * cosine / (falloff == RT_FALLOFF_NONE ? 1 : d2), 2e-6);
        }
    }
    rt_image_destroy(image);
}

static void test_point_without_falloff(void **state)
{
    (void)state;
    point_light(RT_FALLOFF_NONE);
}

static void test_point_inverse_square(void **state)
{
    (void)state;
    point_light(RT_FALLOFF_INVERSE_SQUARE);
}

/* Irradiance of a sphere of radiance L wholly above the horizon: pi L (r / d)^2 cos; pi cancels against Lambert. */
static void sphere_light(const char *integrator, rt_falloff falloff, int visible)
{
    rt_render_desc d = settings(8, 8, 256, integrator);
    rt_light_desc l = light(RT_LIGHT_SPHERE, v3(0.5f, 2, 0), v3(3, 3, 3), falloff);
    rt_image *image;
    l.radius = 0.8f;
    l.visible = visible;
    d.filter_width = 0.001f; /* a pixel is its middle */
    d.shadow_samples = 4;
    floor_from_above(add_material(scene, v3(1, 1, 1), 1, 0, 0, 0));
    look_parallel(scene, v3(0, 1, 0), v3(0, 0, 0), v3(0, 0, -1), 4);
    add_light(scene, l);
    image = commit_and_render(&d);
    for (uint32_t y = 0; y < 8; y += 7) {
        for (uint32_t x = 0; x < 8; x += 7) {
            rt_vec3 p = floor_point(x, y);
            double dx = 0.5 - p.x, dz = -p.z, d2 = dx * dx + 4 + dz * dz, cosine = 2 / sqrt(d2);
            double want = 3 * cosine * (falloff == RT_FALLOFF_NONE ? 1 : 0.64 / d2);
            near_to(pixel(image, x, y)[1], want, want * (strcmp(integrator, "path") == 0 ? 0.03 : 0.003));
        }
    }
    rt_image_destroy(image);
}

static void test_sphere_light(void **state)
{
    (void)state;
    sphere_light("whitted", RT_FALLOFF_INVERSE_SQUARE, 0);
}

static void test_sphere_light_without_falloff(void **state)
{
    (void)state;
    sphere_light("whitted", RT_FALLOFF_NONE, 1);
}

static void test_sphere_light_path(void **state)
{
    (void)state;
    sphere_light("path", RT_FALLOFF_INVERSE_SQUARE, 0);
}

/* The body is met by diffuse rays as well: counted twice it would show. */
static void test_sphere_light_path_visible(void **state)
{
    (void)state;
    sphere_light("path", RT_FALLOFF_INVERSE_SQUARE, 1);
}

static void test_sphere_light_path_visible_without_falloff(void **state)
{
    (void)state;
    sphere_light("path", RT_FALLOFF_NONE, 1);
}

/* Of a floor under a light whose body is seen, by paths: its middle's mean. blocked: an opaque sphere hides the light. */
static void floor_under_visible(const rt_render_desc *how, rt_material over, int blocked, double want, double bound)
{
    rt_light_desc l = light(RT_LIGHT_SPHERE, v3(0, 4, 0), v3(3, 3, 3), RT_FALLOFF_INVERSE_SQUARE);
    rt_image *image;
    double mean[3];
    l.visible = 1;
    floor_from_above(add_material(scene, v3(1, 1, 1), 1, 0, 0, 0));
    look_parallel(scene, v3(0, 1, 0), v3(0, 0, 0), v3(0, 0, -1), 0.01f);
    if (blocked)
        add_sphere(scene, v3(0, 2, 0), 1, over);
    else
        add_box(scene, v3(-8, 2, -8), v3(8, 2.1f, 8), over);
    add_light(scene, l);
    image = commit_and_render(how);
    mean_of(image, mean);
    near_to(mean[1], want, bound);
    rt_image_destroy(image);
}

/* Shadow rays bring its light straight through a clear pane; diffuse rays that find the way as well bring nothing more. */
static void test_visible_light_through_clear_pane(void **state)
{
    rt_render_desc d = settings(8, 8, 1024, "path");
    (void)state;
    floor_under_visible(&d, add_material(scene, v3(0, 1, 0), 0, 0, 1, 1), 0, 3.0 / 16, 0.003);
}

/* But where shadow rays end at the pane, diffuse rays bring all of it. */
static void test_visible_light_through_pane_of_opaque_shadow(void **state)
{
    rt_render_desc d = settings(8, 8, 4096, "path");
    rt_material_desc m = rt_material_desc_default();
    rt_material pane;
    (void)state;
    m.diffusion = m.ambient = 0;
    m.transparency = 1;
    m.opaque_shadow = 1;
    OK(rt_scene_add_material(scene, &m, &pane));
    add_box(scene, v3(-8, -2, -8), v3(8, -1, 8), add_material(scene, v3(1, 1, 1), 0, 0, 1, 1)); /* shadow rays get through some */
    floor_under_visible(&d, pane, 0, 3.0 / 16, 0.006);
}

/* Without shadows all of it is asked for through what stands before it. */
static void test_visible_light_without_shadows(void **state)
{
    rt_render_desc d = settings(8, 8, 1024, "path");
    (void)state;
    d.shadows = 0;
    d.max_depth = 1;
    floor_under_visible(&d, add_material(scene, v3(0, 0, 0), 0, 0, 0, 0), 1, 3.0 / 16, 0.003);
}

/* A sky that is bright in one row of its map: what a floor below it shows is the row's share of a hemisphere weighed by cosines.
 */
static void sky_row(uint32_t row)
{
    enum { W = 64, H = 32 };
    static float texels[W * H][3];
    const double pi = 3.14159265358979, above = sin(pi * row / H), below = sin(pi * (row + 1) / H);
    rt_render_desc d = settings(16, 16, 1024, "path");
    rt_texture_desc t = rt_texture_desc_default();
    rt_world_desc w = rt_world_desc_default();
    rt_image *image;
    double mean[3];
    memset(texels, 0, sizeof texels);
    for (uint32_t x = 0; x < W; x++)
        texels[row * W + x][1] = 100;
    t.width = W;
    t.height = H;
    t.pixels = texels;
    t.format = RT_PIXEL_RGB32F;
    OK(rt_scene_add_texture(scene, &t, &w.background_texture));
    OK(rt_scene_set_world(scene, &w));
    floor_from_above(add_material(scene, v3(1, 1, 1), 1, 0, 0, 0));
    image = commit_and_render(&d);
    mean_of(image, mean);
    near_to(mean[1], 100 * (below * below - above * above), 0.15);
    rt_image_destroy(image);
}

static void test_sky_low_row(void **state)
{
    (void)state;
    sky_row(15);
}

static void test_sky_high_row(void **state)
{
    (void)state;
    sky_row(3);
}

/* A lamp: the sphere around a point light hides it from nobody; another sphere does. */
static void test_lamp_does_not_shadow_itself(void **state)
{
    rt_render_desc d = settings(1, 1, 1, "whitted");
    rt_material white = add_material(scene, v3(1, 1, 1), 1, 0, 0, 0);
    rt_image *image;
    (void)state;
    floor_from_above(white);
    look_parallel(scene, v3(0.3f, 1, 0), v3(0.3f, 0, 0), v3(0, 0, -1), 1);
    add_sphere(scene, v3(0, 3, 0), 0.5f, white);
    add_light(scene, light(RT_LIGHT_POINT, v3(0, 3, 0), v3(2, 2, 2), RT_FALLOFF_NONE));
    image = commit_and_render(&d);
    near_to(pixel(image, 0, 0)[0], 2 * 3 / sqrt(9.09), 1e-5);
    rt_image_destroy(image);
    add_sphere(scene, v3(0.15f, 1.5f, 0), 0.2f, white);
    image = commit_and_render(&d);
    near_to(pixel(image, 0, 0)[0], 0, 0);
    rt_image_destroy(image);
    d.shadows = 0;
    image = commit_and_render(&d);
    near_to(pixel(image, 0, 0)[0], 2 * 3 / sqrt(9.09), 1e-5);
    rt_image_destroy(image);
}

/* The body of a light is seen as its radiance, directly and in a mirror, and throws no shadow of another light's making. */
static void test_visible_light(void **state)
{
    rt_render_desc d = settings(1, 1, 1, "whitted");
    rt_light_desc l = light(RT_LIGHT_SPHERE, v3(0, 3, 0), v3(7, 6, 5), RT_FALLOFF_INVERSE_SQUARE);
    rt_image *image;
    (void)state;
    l.radius = 1;
    l.visible = 1;
    add_light(scene, l);
    add_plane(scene, v3(0, 0, 0), v3(0, 1, 0), add_material(scene, v3(0, 0, 0), 0, 0.5f, 0, 0));
    look(scene, v3(0, 3, 9), v3(0, 3, 0), 1);
    for (int i = 0; i < 2; i++) {
        d.integrator = i ? "path" : "whitted";
        image = commit_and_render(&d);
        near_to(pixel(image, 0, 0)[0], 7, 0);
        near_to(pixel(image, 0, 0)[2], 5, 0);
        rt_image_destroy(image);
    }
    d.integrator = "whitted";
    look(scene, v3(0, 3, 6), v3(0, 0, 3), 1);
    image = commit_and_render(&d);
    near_to(pixel(image, 0, 0)[1], 3, 1e-6);
    rt_image_destroy(image);
}

static void test_ten_thousand_lights(void **state)
{
    rt_render_desc d = settings(8, 8, 1, "whitted");
    rt_image *image;
    (void)state;
    floor_from_above(add_material(scene, v3(1, 1, 1), 1, 0, 0, 0));
    for (int i = 0; i < 10000; i++)
        add_light(scene, light(RT_LIGHT_DIRECTIONAL, v3(0, -1, 0), v3(1e-4f, 2e-4f, 1e-4f), RT_FALLOFF_NONE));
    image = commit_and_render(&d);
    near_to(pixel(image, 3, 3)[0], 1, 1e-4);
    near_to(pixel(image, 7, 0)[1], 2, 2e-4);
    rt_image_destroy(image);
    d.integrator = "path";
    d.samples = 16;
    image = render(scene, &d);
    near_to(pixel(image, 3, 3)[0], 1, 1e-3);
    rt_image_destroy(image);
}

/* A ball's shadow on the floor, where coordinates are large beside a lamp's distance of ten. */
static void test_far_from_the_middle(void **state)
{
    static const float far[] = {0, 1e4f, 1e5f, 1e6f};
    (void)state;
    for (size_t i = 0; i < sizeof far / sizeof *far; i++) {
        const float o = far[i];
        rt_render_desc d = settings(1, 1, 1, "whitted");
        stage(1);
        set_world(scene, v3(0, 0, 0), v3(0, 0, 0));
        add_plane(scene, v3(o, o, o), v3(0, 1, 0), add_material(scene, v3(1, 1, 1), 1, 0, 0, 0));
        add_sphere(scene, v3(o, o + 2, o), 1, add_material(scene, v3(1, 1, 1), 1, 0, 0, 0));
        add_light(scene, light(RT_LIGHT_POINT, v3(o, o + 10, o), v3(1, 1, 1), RT_FALLOFF_NONE));
        for (int lit = 0; lit < 2; lit++) {
            rt_image *image;
            look(scene, v3(o + 6, o + 1, o), v3(o, o, lit ? o + 4 : o), 2);
            image = commit_and_render(&d);
            if (lit)
                assert_true(pixel(image, 0, 0)[1] > 0.5f);
            else
                near_to(pixel(image, 0, 0)[1], 0, 0);
            rt_image_destroy(image);
        }
        teardown(state);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_DARK(test_directional),
        IN_DARK(test_point_without_falloff),
        IN_DARK(test_point_inverse_square),
        IN_DARK(test_sphere_light),
        IN_DARK(test_sphere_light_without_falloff),
        IN_DARK(test_sphere_light_path),
        IN_DARK(test_sphere_light_path_visible),
        IN_DARK(test_sphere_light_path_visible_without_falloff),
        IN_DARK(test_visible_light_through_clear_pane),
        IN_DARK(test_visible_light_through_pane_of_opaque_shadow),
        IN_DARK(test_visible_light_without_shadows),
        IN_DARK(test_sky_low_row),
        IN_DARK(test_sky_high_row),
        IN_DARK(test_lamp_does_not_shadow_itself),
        IN_DARK(test_ten_thousand_lights),
        IN_DARK(test_visible_light),
        cmocka_unit_test(test_far_from_the_middle),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
