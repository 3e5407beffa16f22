/* Materials, against closed forms: mirrors, Snell's law, shadows of panes, highlights. */
#include "render_stage.h"

static void test_mirror(void **state)
{
    rt_render_desc d = settings(1, 1, 1, "whitted");
    rt_image *image;
    (void)state;
    sky_compass();
    add_plane(scene, v3(0, 0, 0), v3(0, 1, 0), add_material(scene, v3(0, 0, 0), 0, 0.5f, 0, 0));
    look_parallel(scene, v3(-3, 1, 0), v3(0, 0, 0), v3(0, 1, 0), 1);
    image = commit_and_render(&d);
    near_to(pixel(image, 0, 0)[0], 0.5 * (0.5 + 0.5 / sqrt(10)), 1e-6);
    rt_image_destroy(image);
}

/* From above into glass: Snell; the tint is paid once. */
static void test_refraction(void **state)
{
    rt_render_desc d = settings(1, 1, 1, "whitted");
    rt_image *image;
    double sine = 3 / sqrt(10) / 1.5, down = -sqrt(1 - sine * sine);
    (void)state;
    sky_compass();
    add_plane(scene, v3(0, 0, 0), v3(0, 1, 0), add_material(scene, v3(1, 0.5f, 0), 0, 0, 0.8f, 1.5f));
    look_parallel(scene, v3(-3, 1, 0), v3(0, 0, 0), v3(0, 1, 0), 1);
    image = commit_and_render(&d);
    near_to(pixel(image, 0, 0)[0], 0.8 * (0.5 + 0.5 * down), 1e-6);
    near_to(pixel(image, 0, 0)[1], 0.4 * (0.5 + 0.5 * down), 1e-6);
    near_to(pixel(image, 0, 0)[2], 0, 0);
    rt_image_destroy(image);
}

/* From below, out of the glass: flat rays are all reflected, untinted; steep ones bend away. */
static void test_total_internal_reflection(void **state)
{
    rt_render_desc d = settings(1, 1, 1, "whitted");
    rt_image *image;
    double sine = 1 / sqrt(10) * 1.5, up = sqrt(1 - sine * sine);
    (void)state;
    sky_compass();
    add_plane(scene, v3(0, 0, 0), v3(0, 1, 0), add_material(scene, v3(0.5f, 0.5f, 0.5f), 0, 0.1f, 0.8f, 1.5f));
    look_parallel(scene, v3(-3, -1, 0), v3(0, 0, 0), v3(0, 1, 0), 1);
    image = commit_and_render(&d);
    near_to(pixel(image, 0, 0)[0], 0.9 * (0.5 - 0.5 / sqrt(10)), 1e-6);
    rt_image_destroy(image);
    look_parallel(scene, v3(-1, -3, 0), v3(0, 0, 0), v3(0, 1, 0), 1);
    image = commit_and_render(&d);
    near_to(pixel(image, 0, 0)[0], 0.4 * (0.5 + 0.5 * up) + 0.1 * (0.5 - 0.5 * 3 / sqrt(10)), 1e-6);
    rt_image_destroy(image);
}

/* A pane of index 1 (two surfaces) over the floor. */
static float under_pane(int opaque_scene, int opaque_material)
{
    rt_render_desc d = settings(1, 1, 1, "whitted");
    rt_material_desc m = rt_material_desc_default();
    rt_material pane;
    rt_image *image;
    float green;
    m.color = v3(1, 0.5f, 0);
    m.diffusion = 0;
    m.ambient = 0;
    m.transparency = 0.8f;
    m.refractiveness = 1;
    m.opaque_shadow = opaque_material;
    OK(rt_scene_add_material(scene, &m, &pane));
    floor_from_above(add_material(scene, v3(1, 1, 1), 1, 0, 0, 0));
    look_parallel(scene, v3(0, 1, 0), v3(0, 0, 0), v3(0, 0, -1), 1);
    add_box(scene, v3(-1, 2, -1), v3(1, 2.25f, 1), pane);
    add_light(scene, light(RT_LIGHT_POINT, v3(0, 4, 0), v3(2, 2, 2), RT_FALLOFF_NONE));
    d.opaque_shadows = opaque_scene;
    image = commit_and_render(&d);
    green = pixel(image, 0, 0)[1];
    near_to(pixel(image, 0, 0)[0], green * 4, 1e-6);
    near_to(pixel(image, 0, 0)[2], 0, 0);
    rt_image_destroy(image);
    return green;
}

static void test_tinted_shadow(void **state)
{
    (void)state;
    near_to(under_pane(0, 0), 2 * 0.4 * 0.4, 1e-6);
}

static void test_opaque_shadows(void **state)
{
    (void)state;
    near_to(under_pane(1, 0), 0, 0);
}

static void test_opaque_shadow_material(void **state)
{
    (void)state;
    near_to(under_pane(0, 1), 0, 0);
}

/* Highlight at the mirror angle: specular * (shininess + 8) / 8 * cos, plus ambient and Lambert. */
static void test_highlight_and_ambient(void **state)
{
    rt_render_desc d = settings(1, 1, 1, "whitted");
    rt_material_desc m = rt_material_desc_default();
    rt_world_desc w = rt_world_desc_default();
    rt_material shiny;
    rt_image *image;
    (void)state;
    m.color = v3(0.5f, 0, 0);
    m.diffusion = 1;
    m.specular = 0.25f;
    m.shininess = 24;
    m.ambient = 0.5f;
    OK(rt_scene_add_material(scene, &m, &shiny));
    w.ambient = v3(0.2f, 0.2f, 0.2f);
    OK(rt_scene_set_world(scene, &w));
    add_plane(scene, v3(0, 0, 0), v3(0, 1, 0), shiny);
    look_parallel(scene, v3(-3, 3, 0), v3(0, 0, 0), v3(0, 1, 0), 1);
    add_light(scene, light(RT_LIGHT_DIRECTIONAL, v3(-1, -1, 0), v3(1, 1, 1), RT_FALLOFF_NONE));
    image = commit_and_render(&d);
    near_to(pixel(image, 0, 0)[0], 0.5 * 0.5 * 0.2 + sqrt(0.5) * (0.5 + 0.25 * 4), 2e-5);
    near_to(pixel(image, 0, 0)[1], sqrt(0.5) * 0.25 * 4, 2e-5);
    rt_image_destroy(image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_DARK(test_mirror),
        IN_DARK(test_refraction),
        IN_DARK(test_total_internal_reflection),
        IN_DARK(test_tinted_shadow),
        IN_DARK(test_opaque_shadows),
        IN_DARK(test_opaque_shadow_material),
        IN_DARK(test_highlight_and_ambient),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
