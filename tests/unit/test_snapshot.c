/* Commits: what they make, what they share, what they leave alone. */
#include "scene_kit.h"

#include <math.h>
#include <pthread.h>

static void commit(rt_scene *scene)
{
    char text[512];
    rt_status status = rt_scene_commit(scene, NULL);
    if (status != RT_OK) {
        rt_context_error(rt_scene_context(scene), text, sizeof text);
        fail_msg("commit: %s", text);
    }
}

static rt_scene_info info_of(const rt_scene *scene)
{
    rt_scene_info info;
    assert_int_equal(rt_scene_get_info(scene, &info), RT_OK);
    return info;
}

static void test_empty(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx);
    rt_ray ray = kit_ray(0, 0, 5, 0, 0, -1);
    rt_hit hit = kit_hit(scene, ray);
    rt_vec3 low, high;
    (void)state;
    assert_int_equal(hit.prim_id, RT_INVALID_ID); /* before any commit too */
    commit(scene);
    hit = kit_hit(scene, ray);
    assert_int_equal(hit.prim_id, RT_INVALID_ID);
    assert_true(hit.t == ray.tmax);
    assert_int_equal(info_of(scene).tree_count, 0);
    assert_int_equal(rt_scene_bounds(scene, &low, &high), RT_OK);
    assert_true(low.x > high.x);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

/* One of each kind, on a row along x, hit from above. */
static void test_kinds(void **state)
{
    static const char *const tracers[] = {"brute", "kdtree", "octree"};
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx);
    rt_box_desc box = rt_box_desc_default();
    rt_cone_desc cylinder = rt_cone_desc_default(), cone = rt_cone_desc_default();
    rt_torus_desc torus = rt_torus_desc_default();
    rt_plane_desc plane = rt_plane_desc_default();
    (void)state;
    kit_square(scene, 1.0f, 0.5f);
    kit_sphere(scene, 10, 0, 0, 1.0f);
    box.low = (rt_vec3){19, -1, -1};
    box.high = (rt_vec3){21, 1, 1};
    assert_int_equal(rt_scene_add_box(scene, &box, NULL), RT_OK);
    cylinder.from = (rt_vec3){30, 0, -1};
    cylinder.to = (rt_vec3){30, 0, 1};
    assert_int_equal(rt_scene_add_cylinder(scene, &cylinder, NULL), RT_OK);
    cone.from = (rt_vec3){40, 0, -1};
    cone.to = (rt_vec3){40, 0, 1};
    cone.radius1 = 0.5f;
    assert_int_equal(rt_scene_add_cone(scene, &cone, NULL), RT_OK);
    torus.center = (rt_vec3){50, 0, 0};
    torus.axis = (rt_vec3){0, 0, 1};
    assert_int_equal(rt_scene_add_torus(scene, &torus, NULL), RT_OK);
    plane.point = (rt_vec3){0, 0, -7};
    plane.normal = (rt_vec3){0, 0, 2};
    assert_int_equal(rt_scene_add_plane(scene, &plane, NULL), RT_OK);
    for (size_t i = 0; i < 3; i++) {
        assert_int_equal(rt_scene_set_tracer(scene, tracers[i]), RT_OK);
        commit(scene);
        const float top[] = {9.5f, 9.0f, 9.0f, 9.0f, 9.0f, 9.75f, 17.0f};
        for (uint32_t g = 0; g < 7; g++) {
            float y = g == 5 ? 1.0f : 0.0f; /* on the ring */
            rt_hit hit = kit_hit(scene, kit_ray(10.0f * (float)g + 0.0f, y, 10, 0, 0, -1));
            assert_int_equal(hit.geom_id, g);
            assert_true(fabsf(hit.t - top[g]) < 1e-4f);
            assert_int_equal(hit.inst_id, RT_INVALID_ID);
        }
    }
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

static void test_instances(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *child = kit_scene(ctx), *parent = kit_scene(ctx);
    rt_instance_desc d = rt_instance_desc_default();
    rt_instance a, b, c;
    rt_surface at;
    rt_ray ray;
    rt_hit hit;
    (void)state;
    kit_sphere(child, 0, 0, 0, 1.0f);
    d.child = child;
    d.transform = rt_transform_translate((rt_vec3){5, 0, 0});
    assert_int_equal(rt_scene_add_instance(parent, &d, &a), RT_OK);
    assert_int_equal(rt_scene_commit(parent, NULL), RT_ERROR_STATE);
    kit_says(ctx, "instance 0 was never committed");
    commit(child);
    d.transform = rt_transform_multiply(rt_transform_translate((rt_vec3){-5, 0, 0}), rt_transform_scale((rt_vec3){2, 2, 2}));
    d.user_id = 77;
    assert_int_equal(rt_scene_add_instance(parent, &d, &b), RT_OK);
    d.transform = rt_transform_translate((rt_vec3){0, 20, 0});
    assert_int_equal(rt_scene_add_instance(parent, &d, &c), RT_OK);
    commit(parent);
    ray = kit_ray(-5, 0, 10, 0, 0, -1);
    hit = kit_hit(parent, ray);
    assert_int_equal(hit.inst_id, b.id);
    assert_true(fabsf(hit.t - 8.0f) < 1e-5f);
    rt_scene_surface(parent, &ray, &hit, &at);
    assert_true(fabsf(at.position.z - 2.0f) <= at.position_error);
    assert_true(at.ng.z > 0.99999f);
    assert_int_equal(at.inst_user_id, 77);
    assert_int_equal(at.material_scene, 1);
    assert_int_equal(at.material.id, 0);
    assert_int_equal(rt_scene_remove_instance(parent, a), RT_OK);
    commit(parent);
    assert_int_equal(kit_hit(parent, kit_ray(5, 0, 10, 0, 0, -1)).prim_id, RT_INVALID_ID);
    assert_int_equal(kit_hit(parent, kit_ray(0, 20, 10, 0, 0, -1)).inst_id, c.id);
    rt_scene_destroy(child); /* lives on in the parent */
    commit(parent);
    assert_int_equal(kit_hit(parent, ray).inst_id, b.id);
    rt_scene_destroy(parent);
    rt_context_destroy(ctx);
}

static void test_sharing(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx), *other = kit_scene(ctx);
    rt_material_desc red = rt_material_desc_default();
    rt_camera_desc camera = rt_camera_desc_default();
    rt_material m;
    char before[33], after[33];
    (void)state;
    kit_square(scene, 1.0f, 0.0f);
    kit_square(other, 1.0f, 0.0f);
    commit(scene);
    assert_int_equal(info_of(scene).built_trees, 1);
    assert_int_equal(rt_scene_hash(scene, before), RT_OK);
    commit(scene);
    assert_int_equal(info_of(scene).built_trees, 0);
    assert_int_equal(rt_scene_hash(scene, after), RT_OK);
    assert_string_equal(before, after);
    red.color = (rt_vec3){1, 0, 0};
    assert_int_equal(rt_scene_add_material(scene, &red, &m), RT_OK);
    assert_int_equal(rt_scene_set_geometry_material(scene, (rt_geometry){0}, m), RT_OK);
    camera.eye.x = 3;
    assert_int_equal(rt_scene_set_camera(scene, &camera), RT_OK);
    commit(scene);
    assert_int_equal(info_of(scene).built_trees, 0);
    assert_int_equal(rt_scene_hash(scene, after), RT_OK);
    assert_string_not_equal(before, after);
    commit(other);
    assert_int_equal(info_of(other).built_trees, 0); /* the tree of the first scene */
    assert_int_equal(rt_scene_hash(other, after), RT_OK);
    assert_string_equal(before, after);
    rt_scene_destroy(scene);
    rt_scene_destroy(other);
    rt_context_destroy(ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_empty), cmocka_unit_test(test_kinds),
                                       cmocka_unit_test(test_instances), cmocka_unit_test(test_sharing)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
