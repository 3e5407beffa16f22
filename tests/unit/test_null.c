/* NULL in an object's place: every call that gives a status answers ARGUMENT, with a sentence that rt_context_error(NULL) has,
 * and what it was to make becomes NULL. */
#include "scene_kit.h"

#include "librt/rt.h"

/* `call` was just made: its sentence begins with its name and says what is NULL. */
static void refused(const char *call, rt_status status)
{
    char sentence[256], name[64];
    const size_t length = strcspn(call, "(");
    assert_true(length < sizeof name);
    memcpy(name, call, length);
    name[length] = '\0';
    if (status != RT_ERROR_ARGUMENT)
        fail_msg("%s gives %s", call, rt_status_name(status));
    assert_true(rt_context_error(NULL, sentence, sizeof sentence) > 0);
    if (strncmp(sentence, name, length) != 0 || !strstr(sentence, "NULL"))
        fail_msg("%s says \"%s\"", call, sentence);
}
#define REFUSED(call) refused(#call, call)

static void test_scenes(void **state)
{
    char text[33];
    rt_vec3 low = {0, 0, 0}, high;
    rt_scene_info info;
    rt_motion_info motion;
    rt_tree_info tree;
    rt_tree_shape shape;
    rt_camera_desc camera = rt_camera_desc_default();
    rt_instance_desc instance = rt_instance_desc_default();
    rt_scene *scene = (rt_scene *)text;
    rt_tracer *tracer = (rt_tracer *)text;
    (void)state;
    REFUSED(rt_scene_create(NULL, &scene));
    assert_null(scene);
    scene = (rt_scene *)text;
    REFUSED(rt_scene_load(NULL, "x.rts", &scene));
    assert_null(scene);
    REFUSED(rt_tracer_create(NULL, NULL, &tracer));
    assert_null(tracer);
    REFUSED(rt_scene_add_texture(NULL, NULL, NULL));
    REFUSED(rt_scene_load_texture(NULL, "x.png", NULL, NULL));
    REFUSED(rt_scene_add_material(NULL, NULL, NULL));
    REFUSED(rt_scene_set_material(NULL, (rt_material){0}, NULL));
    REFUSED(rt_scene_add_mesh(NULL, NULL, NULL));
    REFUSED(rt_scene_add_polyhedron(NULL, NULL, NULL));
    REFUSED(rt_scene_add_sphere(NULL, NULL, NULL));
    REFUSED(rt_scene_add_spheres(NULL, NULL, NULL));
    REFUSED(rt_scene_add_plane(NULL, NULL, NULL));
    REFUSED(rt_scene_add_box(NULL, NULL, NULL));
    REFUSED(rt_scene_add_cylinder(NULL, NULL, NULL));
    REFUSED(rt_scene_add_cone(NULL, NULL, NULL));
    REFUSED(rt_scene_add_cylinders(NULL, NULL, NULL));
    REFUSED(rt_scene_add_cones(NULL, NULL, NULL));
    REFUSED(rt_scene_add_torus(NULL, NULL, NULL));
    REFUSED(rt_scene_set_geometry_material(NULL, (rt_geometry){0}, (rt_material){0}));
    REFUSED(rt_scene_set_geometry_mask(NULL, (rt_geometry){0}, 1));
    REFUSED(rt_scene_set_mesh_positions(NULL, (rt_geometry){0}, NULL, NULL, 0));
    REFUSED(rt_scene_smooth_mesh(NULL, (rt_geometry){0}));
    REFUSED(rt_scene_remove_geometry(NULL, (rt_geometry){0}));
    REFUSED(rt_scene_add_instance(NULL, NULL, NULL));
    REFUSED(rt_scene_set_instance_motion(NULL, (rt_instance){0}, NULL, 0));
    REFUSED(rt_scene_set_instance_transform(NULL, (rt_instance){0}, NULL));
    REFUSED(rt_scene_remove_instance(NULL, (rt_instance){0}));
    REFUSED(rt_scene_get_instance(NULL, (rt_instance){0}, &instance));
    REFUSED(rt_scene_add_light(NULL, NULL, NULL));
    REFUSED(rt_scene_set_light(NULL, (rt_light){0}, NULL));
    REFUSED(rt_scene_remove_light(NULL, (rt_light){0}));
    REFUSED(rt_scene_set_world(NULL, NULL));
    REFUSED(rt_scene_set_camera(NULL, NULL));
    REFUSED(rt_scene_set_camera_motion(NULL, NULL));
    REFUSED(rt_scene_get_camera(NULL, &camera));
    REFUSED(rt_scene_get_camera_motion(NULL, &camera));
    REFUSED(rt_scene_frame_camera(NULL, 1));
    REFUSED(rt_scene_bounds(NULL, &low, &high));
    REFUSED(rt_scene_commit(NULL, NULL));
    REFUSED(rt_scene_hash(NULL, text));
    REFUSED(rt_scene_looks_hash(NULL, text, NULL, 0, NULL));
    REFUSED(rt_scene_get_info(NULL, &info));
    REFUSED(rt_scene_get_motion_info(NULL, &motion));
    REFUSED(rt_scene_get_tree_info(NULL, 0, NULL, &tree));
    REFUSED(rt_scene_save(NULL, "x.rts"));
    REFUSED(rt_scene_import(NULL, "x.ply", NULL, NULL));
    REFUSED(rt_scene_set_tracer(NULL, "bvh"));
    REFUSED(rt_scene_tree_cells(NULL, NULL, NULL, NULL));
    REFUSED(rt_scene_tree_shape(NULL, NULL, &shape));
    REFUSED(rt_scene_cut(NULL, 0, low, low, NULL, NULL));
    REFUSED(rt_scene_ray_costs(NULL, NULL, NULL, NULL, 0));
}

static void test_pictures(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_image *image, *made = NULL;
    rt_job *job = (rt_job *)(void *)&image;
    rt_image_difference difference;
    double mean;
    (void)state;
    kit_ok(ctx, rt_image_create(ctx, 8, 8, &image));
    made = image;
    REFUSED(rt_render(NULL, NULL, &made));
    assert_null(made);
    made = image;
    REFUSED(rt_image_create(NULL, 1, 1, &made));
    assert_null(made);
    made = image;
    REFUSED(rt_image_resample(NULL, 1, 1, RT_RESAMPLE_BOX, &made));
    assert_null(made);
    made = image;
    REFUSED(rt_image_compare(image, NULL, &difference, &made));
    assert_null(made);
    REFUSED(rt_image_compare(NULL, image, &difference, NULL));
    REFUSED(rt_job_start(NULL, NULL, &job));
    assert_null(job);
    REFUSED(rt_job_status(NULL));
    REFUSED(rt_render_to_file(NULL, NULL, "x.png", NULL, 0, NULL, NULL));
    REFUSED(rt_render_explain(NULL, NULL, NULL, NULL, NULL, NULL));
    REFUSED(rt_image_load(NULL, "x.png", &made));
    REFUSED(rt_image_save(NULL, "x.png", NULL));
    REFUSED(rt_image_read_texts(NULL, "x.png", NULL, NULL));
    REFUSED(rt_image_set_text(NULL, "a", "b"));
    REFUSED(rt_image_ssim(image, NULL, &mean, NULL));
    REFUSED(rt_image_flip(NULL, image, 67, &mean, NULL));
    REFUSED(rt_image_color_map(NULL, RT_COLOR_MAP_GREY, 0, 1, &made));
    REFUSED(rt_image_place(image, NULL, 0, 0));
    REFUSED(rt_image_label(NULL, "a", NULL));
    rt_image_destroy(image);
    rt_context_destroy(ctx);
}

static void *refuse(void *user, void *ptr, size_t old_size, size_t new_size)
{
    (void)user;
    (void)ptr;
    (void)old_size;
    (void)new_size;
    return NULL;
}

/* A context that cannot be made leaves a sentence, too. */
static void test_contexts(void **state)
{
    rt_context_desc d = rt_context_desc_default();
    rt_context *ctx = (rt_context *)(void *)&d;
    char sentence[256];
    (void)state;
    REFUSED(rt_context_create(&d, NULL));
    d.workers = 5000;
    assert_int_equal(rt_context_create(&d, &ctx), RT_ERROR_ARGUMENT);
    assert_null(ctx);
    rt_context_error(NULL, sentence, sizeof sentence);
    assert_string_equal(sentence,
                        "rt_context_create: workers is 5000; it must be from 1 to 1024, or 0: as many as there are processors");
    d = rt_context_desc_default();
    d.allocate = refuse;
    assert_int_equal(rt_context_create(&d, &ctx), RT_ERROR_MEMORY);
    rt_context_error(NULL, sentence, sizeof sentence);
    assert_non_null(strstr(sentence, "rt_context_create: the allocator could not give"));
    d.struct_size = 0;
    assert_int_equal(rt_context_create(&d, &ctx), RT_ERROR_ARGUMENT);
    rt_context_error(NULL, sentence, sizeof sentence);
    assert_non_null(strstr(sentence, "struct_size is 0"));
    assert_int_equal(rt_context_error(NULL, sentence, 10),
                     strlen("rt_context_create: the descriptor's struct_size is 0; begin with "
                            "rt_context_desc_default()"));
    assert_string_equal(sentence, "rt_contex");
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_scenes), cmocka_unit_test(test_pictures),
                                       cmocka_unit_test(test_contexts)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
