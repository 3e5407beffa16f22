/* The numbers are right: scenes whose radiance is known in closed form. */
#include "render_scenes.h"

#include "kernel/lights.h"
#include "render/job.h"

static rt_context *ctx;
static rt_scene *scene;

static int setup(void **state)
{
    (void)state;
    ctx = make_context(1);
    OK(rt_scene_create(ctx, &scene));
    set_world(scene, v3(0, 0, 0), v3(0, 0, 0));
    return 0;
}

static int teardown(void **state)
{
    uint64_t now = 1;
    (void)state;
    rt_scene_destroy(scene);
    rt_context_memory(ctx, &now, NULL);
    rt_context_destroy(ctx);
    (void)now;
    return 0;
}

static rt_image *commit_and_render(const rt_render_desc *d)
{
    OK(rt_scene_commit(scene, NULL));
    return render(scene, d);
}

static void floor_from_above(rt_material m)
{
    add_plane(scene, v3(0, 0, 0), v3(0, 1, 0), m);
    look_parallel(scene, v3(0, 5, 0), v3(0, 0, 0), v3(0, 0, -1), 4);
}

/* Centre of pixel (x, y) of an 8 x 8 window of edge 4 on the floor. */
static rt_vec3 floor_point(uint32_t x, uint32_t y)
{
    return v3(-2 + 0.5f * ((float)x + 0.5f), 0, -2 + 0.5f * ((float)y + 0.5f));
}

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

/* A furnace: under a sky of radiance 1 a convex body of albedo a shows a, everywhere; inside a white room nothing is lost. */
static void test_furnace(void **state)
{
    rt_render_desc d = settings(16, 16, 256, "path");
    rt_image *image;
    (void)state;
    add_sphere(scene, v3(0, 0, 0), 1, add_material(scene, v3(1, 0.5f, 0.25f), 1, 0, 0, 0));
    set_world(scene, v3(1, 1, 1), v3(1, 1, 1));
    look_parallel(scene, v3(0, 0, 5), v3(0, 0, 0), v3(0, 1, 0), 1);
    image = commit_and_render(&d);
    for (uint32_t i = 0; i < 16; i++) {
        near_to(pixel(image, i, 7)[0], 1, 1e-5);
        near_to(pixel(image, i, 7)[1], 0.5, 1e-5);
        near_to(pixel(image, 7, i)[2], 0.25, 1e-5);
    }
    rt_image_destroy(image);
}

/* Mirror and glass together lose nothing when their weights sum to one, whatever the number of bounces. */
static void test_furnace_glass(void **state)
{
    rt_render_desc d = settings(16, 16, 64, "path");
    rt_image *image;
    double mean[3];
    (void)state;
    add_sphere(scene, v3(0, 0, 0), 1, add_material(scene, v3(1, 1, 1), 0, 0.3f, 0.7f, 1.5f));
    set_world(scene, v3(1, 1, 1), v3(1, 1, 1));
    look(scene, v3(0, 0, 3), v3(0, 0, 0), 50);
    d.max_depth = 64;
    image = commit_and_render(&d);
    mean_of(image, mean);
    near_to(mean[0], 1, 0.01);
    rt_image_destroy(image);
}

static void never(rti_settings *settings)
{
    settings->roulette_from = 1000;
}

static void at_once(rti_settings *settings)
{
    settings->roulette_from = 1;
}

static void mean_with(const rt_render_desc *d, void (*tune)(rti_settings *), double mean[3])
{
    rt_job *job = NULL;
    rt_image *image;
    rti_snapshot *snapshot = rti_scene_snapshot(scene);
    assert_non_null(snapshot);
    OK(rti_job_create(ctx, snapshot, "test", d, tune, &job));
    rti_snapshot_release(snapshot);
    OK(rti_job_run(job));
    assert_int_equal(rt_job_wait(job, -1), RT_JOB_DONE);
    image = rt_job_take_image(job);
    assert_non_null(image);
    mean_of(image, mean);
    rt_image_destroy(image);
    rt_job_destroy(job);
}

static void test_roulette_keeps_the_mean(void **state)
{
    rt_render_desc d = settings(24, 24, 256, "path");
    double with[3], without[3];
    (void)state;
    add_everything(scene);
    d.max_depth = 12;
    OK(rt_scene_commit(scene, NULL));
    mean_with(&d, at_once, with);
    mean_with(&d, never, without);
    assert_true(with[0] != without[0]);
    for (int c = 0; c < 3; c++)
        near_to(with[c], without[c], 0.006 * without[c]);
}

static void test_whitted_and_path_agree_on_direct_light(void **state)
{
    rt_render_desc d = settings(24, 24, 256, "whitted");
    rt_material grey = add_material(scene, v3(0.7f, 0.6f, 0.5f), 0.9f, 0, 0, 0);
    rt_light_desc soft = light(RT_LIGHT_SPHERE, v3(-2, 3, 1), v3(4, 4, 4), RT_FALLOFF_INVERSE_SQUARE);
    rt_image *a, *b;
    double ma[3], mb[3];
    (void)state;
    soft.radius = 0.5f;
    add_plane(scene, v3(0, 0, 0), v3(0, 1, 0), grey);
    add_sphere(scene, v3(0, 1, 0), 1, grey);
    add_light(scene, soft);
    add_light(scene, light(RT_LIGHT_POINT, v3(2, 4, 2), v3(0.5f, 0.4f, 0.3f), RT_FALLOFF_NONE));
    add_light(scene, light(RT_LIGHT_DIRECTIONAL, v3(0.3f, -1, -0.2f), v3(0.2f, 0.2f, 0.3f), RT_FALLOFF_NONE));
    look(scene, v3(0, 3, 6), v3(0, 0.5f, 0), 40);
    d.max_depth = 0;
    a = commit_and_render(&d);
    d.integrator = "path";
    b = render(scene, &d);
    mean_of(a, ma);
    mean_of(b, mb);
    for (int c = 0; c < 3; c++)
        near_to(ma[c], mb[c], 0.005 * ma[c]);
    rt_image_destroy(a);
    rt_image_destroy(b);
}

/* The background's gradient tells the direction: what a ray shows is 0.5 + 0.5 dir.y. */
static void sky_compass(void)
{
    set_world(scene, v3(0, 0, 0), v3(1, 1, 1));
}

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

/* Under a roof of height h and radius R >> h a point sees cos-weighted 1 - R^2 / (R^2 + h^2) of the sky; here a disc of one box.
 */
static void test_ao(void **state)
{
    rt_render_desc d = settings(4, 4, 256, "ao");
    rt_material white = add_material(scene, v3(1, 1, 1), 1, 0, 0, 0);
    rt_cone_desc roof = rt_cone_desc_default();
    rt_image *image;
    double mean[3];
    (void)state;
    add_plane(scene, v3(0, 0, 0), v3(0, 1, 0), white);
    look_parallel(scene, v3(0, 0.5f, 0), v3(0, 0, 0), v3(0, 0, -1), 0.01f);
    roof.from = v3(0, 1, 0);
    roof.to = v3(0, 1.5f, 0);
    roof.radius0 = 1;
    roof.common.material = add_material(scene, v3(1, 1, 1), 0, 0, 1, 1); /* glass hides like stone */
    OK(rt_scene_add_cylinder(scene, &roof, NULL));
    d.ao_distance = 100;
    image = commit_and_render(&d);
    mean_of(image, mean);
    near_to(mean[0], 0.5, 0.005);
    rt_image_destroy(image);
    d.ao_distance = 0.9f;
    image = commit_and_render(&d);
    mean_of(image, mean);
    near_to(mean[0], 1, 1e-6);
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

/* Emissive meshes light others in `path` by being met: under a ceiling of radiance L that fills the sky, a surface of albedo a
 * shows a L. */
static void test_emissive_mesh(void **state)
{
    static const float p[] = {-1e4f, 1, -1e4f, 1e4f, 1, -1e4f, 1e4f, 1, 1e4f, -1e4f, 1, 1e4f};
    static const uint32_t index[] = {0, 1, 2, 0, 2, 3};
    rt_render_desc d = settings(4, 4, 64, "path");
    rt_material_desc m = rt_material_desc_default();
    rt_mesh_desc ceiling = rt_mesh_desc_default();
    rt_image *image;
    (void)state;
    m.type = RT_MATERIAL_EMISSIVE;
    m.emission = v3(2, 3, 4);
    OK(rt_scene_add_material(scene, &m, &ceiling.common.material));
    ceiling.positions = p;
    ceiling.indices = index;
    ceiling.vertex_count = 4;
    ceiling.triangle_count = 2;
    OK(rt_scene_add_mesh(scene, &ceiling, NULL));
    add_plane(scene, v3(0, 0, 0), v3(0, 1, 0), add_material(scene, v3(0.5f, 0.5f, 0.5f), 1, 0, 0, 0));
    look_parallel(scene, v3(0, 0.5f, 0), v3(0, 0, 0), v3(0, 0, -1), 0.01f);
    image = commit_and_render(&d);
    near_to(pixel(image, 1, 1)[0], 1, 1e-3);
    near_to(pixel(image, 2, 1)[2], 2, 2e-3);
    rt_image_destroy(image);
}

#define T(name) cmocka_unit_test_setup_teardown(name, setup, teardown)
int main(void)
{
    const struct CMUnitTest tests[] = {
        T(test_empty_scene_is_its_background),
        T(test_directional),
        T(test_point_without_falloff),
        T(test_point_inverse_square),
        T(test_sphere_light),
        T(test_sphere_light_without_falloff),
        T(test_sphere_light_path),
        T(test_sphere_light_path_visible),
        T(test_sphere_light_path_visible_without_falloff),
        T(test_furnace),
        T(test_furnace_glass),
        T(test_roulette_keeps_the_mean),
        T(test_whitted_and_path_agree_on_direct_light),
        T(test_mirror),
        T(test_refraction),
        T(test_total_internal_reflection),
        T(test_tinted_shadow),
        T(test_opaque_shadows),
        T(test_opaque_shadow_material),
        T(test_lamp_does_not_shadow_itself),
        T(test_highlight_and_ambient),
        T(test_ao),
        T(test_debug_views),
        T(test_ten_thousand_lights),
        T(test_filters),
        T(test_background_map),
        T(test_masks),
        T(test_visible_light),
        T(test_emissive_mesh),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
