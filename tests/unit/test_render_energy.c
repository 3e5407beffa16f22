/* Light from all sides: nothing is lost or made, integrators have the same means, skies half hidden. */
#include "render_stage.h"

#include "render/job.h"

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

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_DARK(test_furnace),
        IN_DARK(test_furnace_glass),
        IN_DARK(test_roulette_keeps_the_mean),
        IN_DARK(test_whitted_and_path_agree_on_direct_light),
        IN_DARK(test_ao),
        IN_DARK(test_emissive_mesh),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
