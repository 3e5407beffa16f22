/* The description: what every call refuses and how it says so, handles, removal, bounds, cameras, polygons. */
#include "scene_kit.h"

#include <math.h>

#include "scene/polygon.h"

typedef struct fixture {
    rt_context *ctx;
    rt_scene *scene;
} fixture;

static int setup(void **state)
{
    static fixture f;
    f.ctx = kit_context(NULL, 1);
    f.scene = kit_scene(f.ctx);
    *state = &f;
    return 0;
}

static int teardown(void **state)
{
    fixture *f = *state;
    rt_scene_destroy(f->scene);
    rt_context_destroy(f->ctx);
    return 0;
}

#define REFUSED(call, sentence) KIT_REFUSED(f->ctx, call, sentence)

static void test_create(void **state)
{
    fixture *f = *state;
    assert_int_equal(rt_scene_create(NULL, NULL), RT_ERROR_ARGUMENT);
    REFUSED(rt_scene_create(f->ctx, NULL), "rt_scene_create: scene is NULL");
    assert_ptr_equal(rt_scene_context(f->scene), f->ctx);
    rt_scene_destroy(NULL);
}

static void test_material_refusals(void **state)
{
    fixture *f = *state;
    rt_material_desc d = {0};
    rt_material m = {0};
    REFUSED(rt_scene_add_material(f->scene, &d, NULL), "struct_size is 0; begin with the matching _default() function");
    REFUSED(rt_scene_add_material(f->scene, NULL, NULL), "the descriptor is NULL");
    d = rt_material_desc_default();
    d.type = (rt_material_type)7;
    REFUSED(rt_scene_add_material(f->scene, &d, NULL),
            "type is 7; it must be RT_MATERIAL_CLASSIC (0) or RT_MATERIAL_EMISSIVE (1)");
    d = rt_material_desc_default();
    d.color.y = 1.5f;
    REFUSED(rt_scene_add_material(f->scene, &d, NULL),
            "rt_scene_add_material: color is (1, 1.5, 1); its parts must be from 0 to 1");
    d = rt_material_desc_default();
    d.diffusion = NAN;
    REFUSED(rt_scene_add_material(f->scene, &d, NULL), "diffusion is nan; it must be from 0 to 1");
    d = rt_material_desc_default();
    d.shininess = 0;
    REFUSED(rt_scene_add_material(f->scene, &d, NULL), "shininess is 0; it must be from 1 to 100000");
    d = rt_material_desc_default();
    d.emission.z = -1;
    REFUSED(rt_scene_add_material(f->scene, &d, NULL), "emission is (0, 0, -1)");
    d = rt_material_desc_default();
    d.color_texture.id = 4;
    REFUSED(rt_scene_add_material(f->scene, &d, NULL),
            "color_texture is 4; the scene has no textures, so it must be RT_INVALID_ID");
    d = rt_material_desc_default();
    assert_int_equal(rt_scene_add_material(f->scene, &d, &m), RT_OK);
    assert_int_equal(m.id, 1);
    REFUSED(rt_scene_set_material(f->scene, (rt_material){9}, &d),
            "rt_scene_set_material: material is 9; the scene has the materials 0 to 1");
}

static void test_shape_refusals(void **state)
{
    fixture *f = *state;
    rt_sphere_desc s = rt_sphere_desc_default();
    rt_spheres_desc many = rt_spheres_desc_default();
    rt_box_desc b = rt_box_desc_default();
    rt_cone_desc c = rt_cone_desc_default();
    rt_torus_desc t = rt_torus_desc_default();
    rt_plane_desc p = rt_plane_desc_default();
    float centers[] = {0, 0, 0, 1, INFINITY, 0}, radii[] = {1, -2};
    uint32_t ids[] = {0, 3};
    s.radius = -1;
    REFUSED(rt_scene_add_sphere(f->scene, &s, NULL), "rt_scene_add_sphere: radius is -1; it must be greater than 0");
    s.radius = 1;
    s.center.y = 2e12f;
    REFUSED(rt_scene_add_sphere(f->scene, &s, NULL), "center is (0, ");
    s.center.y = 0;
    s.common.material.id = 12;
    REFUSED(rt_scene_add_sphere(f->scene, &s, NULL), "material is 12; the scene has the materials 0 to 0");
    s = rt_sphere_desc_default();
    s.common.uv_transform[3] = INFINITY;
    REFUSED(rt_scene_add_sphere(f->scene, &s, NULL), "uv_transform[3] (part 0) is inf");
    many.count = 2;
    REFUSED(rt_scene_add_spheres(f->scene, &many, NULL), "centers is NULL, but count is 2");
    many.centers = centers;
    REFUSED(rt_scene_add_spheres(f->scene, &many, NULL), "centers[1] (part 1) is inf");
    centers[4] = 0;
    many.radii = radii;
    REFUSED(rt_scene_add_spheres(f->scene, &many, NULL), "radii[1] is -2; it must be greater than 0");
    many.radii = NULL;
    many.radius = 0;
    REFUSED(rt_scene_add_spheres(f->scene, &many, NULL), "radius is 0");
    many.radius = 1;
    many.face_materials = ids;
    REFUSED(rt_scene_add_spheres(f->scene, &many, NULL), "face_materials[1] is 3");
    b.low.z = 1;
    REFUSED(rt_scene_add_box(f->scene, &b, NULL), "on the z axis low is 1 and high is 1; low must be below high");
    c.to = c.from;
    REFUSED(rt_scene_add_cone(f->scene, &c, NULL), "rt_scene_add_cone: from and to are the same point");
    REFUSED(rt_scene_add_cylinder(f->scene, &c, NULL), "rt_scene_add_cylinder: from and to are the same point");
    c = rt_cone_desc_default();
    c.radius0 = 0;
    REFUSED(rt_scene_add_cone(f->scene, &c, NULL), "radius0 and radius1 are both 0");
    REFUSED(rt_scene_add_cylinder(f->scene, &c, NULL), "radius0 is 0; it must be greater than 0");
    t.minor_radius = 1;
    REFUSED(rt_scene_add_torus(f->scene, &t, NULL), "minor_radius is 1; it must be below major_radius, which is 1");
    t = rt_torus_desc_default();
    t.axis = (rt_vec3){0, 0, 0};
    REFUSED(rt_scene_add_torus(f->scene, &t, NULL), "axis is (0, 0, 0); it must be finite and not zero");
    p.normal.y = 0;
    REFUSED(rt_scene_add_plane(f->scene, &p, NULL), "normal is (0, 0, 0)");
    p = rt_plane_desc_default();
    p.texture_size = 0;
    REFUSED(rt_scene_add_plane(f->scene, &p, NULL), "texture_size is 0");
}

static void test_mesh_refusals(void **state)
{
    fixture *f = *state;
    float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    uint32_t indices[] = {0, 1, 3}, sizes[] = {3, 2}, corners[] = {0, 1, 2};
    rt_mesh_desc m = rt_mesh_desc_default();
    rt_polyhedron_desc p = rt_polyhedron_desc_default();
    m.vertex_count = 3;
    REFUSED(rt_scene_add_mesh(f->scene, &m, NULL), "rt_scene_add_mesh: positions is NULL, but vertex_count is 3");
    m.positions = positions;
    m.triangle_count = 1;
    REFUSED(rt_scene_add_mesh(f->scene, &m, NULL), "indices is NULL, but triangle_count is 1");
    m.indices = indices;
    REFUSED(rt_scene_add_mesh(f->scene, &m, NULL), "indices[2] is 3; it must be below vertex_count, which is 3");
    positions[4] = NAN;
    REFUSED(rt_scene_add_mesh(f->scene, &m, NULL), "positions[1] (part 1) is nan");
    positions[4] = 0;
    p.positions = positions;
    p.vertex_count = 3;
    p.face_sizes = sizes;
    p.face_count = 2;
    p.indices = corners;
    p.index_count = 3;
    REFUSED(rt_scene_add_polyhedron(f->scene, &p, NULL), "face_sizes[1] is 2; a face has from 3 to 65535 corners");
    p.face_count = 1;
    p.index_count = 4;
    REFUSED(rt_scene_add_polyhedron(f->scene, &p, NULL), "index_count is 4, but the face_sizes add up to 3");
}

static void test_light_camera_refusals(void **state)
{
    fixture *f = *state;
    rt_light_desc l = rt_light_desc_default();
    rt_camera_desc c = rt_camera_desc_default();
    rt_world_desc w = rt_world_desc_default();
    rt_light id;
    l.type = (rt_light_type)5;
    REFUSED(rt_scene_add_light(f->scene, &l, NULL), "type is 5");
    l = rt_light_desc_default();
    l.intensity = -1;
    REFUSED(rt_scene_add_light(f->scene, &l, NULL), "intensity is -1");
    l = rt_light_desc_default();
    l.type = RT_LIGHT_SPHERE;
    l.radius = 0;
    REFUSED(rt_scene_add_light(f->scene, &l, NULL), "radius is 0");
    l = rt_light_desc_default();
    l.type = RT_LIGHT_DIRECTIONAL;
    l.direction.y = 0;
    REFUSED(rt_scene_add_light(f->scene, &l, NULL), "direction is (0, 0, 0)");
    l = rt_light_desc_default();
    assert_int_equal(rt_scene_add_light(f->scene, &l, &id), RT_OK);
    assert_int_equal(rt_scene_remove_light(f->scene, id), RT_OK);
    REFUSED(rt_scene_remove_light(f->scene, id), "light 0 was removed");
    REFUSED(rt_scene_set_light(f->scene, (rt_light){3}, &l), "light 3 is not one of the scene");
    c.fov_deg = 180;
    REFUSED(rt_scene_set_camera(f->scene, &c), "fov_deg is 180; it must be greater than 0 and below 180");
    c = rt_camera_desc_default();
    c.eye = c.look_at;
    REFUSED(rt_scene_set_camera(f->scene, &c), "eye and look_at are the same point");
    c = rt_camera_desc_default();
    c.type = RT_CAMERA_ORTHOGRAPHIC;
    c.height = 0;
    REFUSED(rt_scene_set_camera(f->scene, &c), "height is 0");
    REFUSED(rt_scene_frame_camera(f->scene, 0), "aspect is 0");
    REFUSED(rt_scene_get_camera(f->scene, NULL), "desc is NULL");
    w.ambient.x = -1;
    REFUSED(rt_scene_set_world(f->scene, &w), "ambient is (-1, 0, 0)");
    w = rt_world_desc_default();
    w.background_texture.id = 0;
    REFUSED(rt_scene_set_world(f->scene, &w), "background_texture is 0");
}

static void test_instance_refusals(void **state)
{
    fixture *f = *state;
    rt_instance_desc d = rt_instance_desc_default();
    rt_context *other = kit_context(NULL, 1);
    rt_scene *child = kit_scene(f->ctx), *foreign = kit_scene(other), *third = kit_scene(f->ctx);
    rt_instance id;
    REFUSED(rt_scene_add_instance(f->scene, &d, NULL), "child is NULL");
    d.child = f->scene;
    REFUSED(rt_scene_add_instance(f->scene, &d, NULL), "child is the scene itself");
    d.child = foreign;
    REFUSED(rt_scene_add_instance(f->scene, &d, NULL), "child belongs to another context");
    d.child = child;
    d.transform.m[5] = 0;
    REFUSED(rt_scene_add_instance(f->scene, &d, NULL), "transform has no inverse");
    d.transform.m[5] = NAN;
    REFUSED(rt_scene_add_instance(f->scene, &d, NULL), "transform[5] (part 0) is nan");
    d.transform = rt_transform_identity();
    d.material.id = 3;
    REFUSED(rt_scene_add_instance(f->scene, &d, NULL), "material is 3");
    d.material.id = RT_INVALID_ID;
    assert_int_equal(rt_scene_add_instance(f->scene, &d, &id), RT_OK);
    d.child = f->scene;
    REFUSED(rt_scene_add_instance(third, &d, NULL), "child has instances of its own; only two levels are possible");
    d.transform.m[0] = 0;
    REFUSED(rt_scene_set_instance_transform(f->scene, id, &d.transform), "transform has no inverse");
    REFUSED(rt_scene_set_instance_transform(f->scene, (rt_instance){4}, &d.transform), "instance 4 is not one of the scene");
    assert_int_equal(rt_scene_remove_instance(f->scene, id), RT_OK);
    REFUSED(rt_scene_remove_instance(f->scene, id), "instance 0 was removed");
    rt_scene_destroy(child);
    rt_scene_destroy(third);
    rt_scene_destroy(foreign);
    rt_context_destroy(other);
}

static void test_commit_refusals(void **state)
{
    fixture *f = *state;
    rt_commit_desc d = rt_commit_desc_default();
    rt_tree_info tree;
    rt_scene_info info;
    char text[33];
    assert_int_equal(rt_scene_hash(f->scene, text), RT_ERROR_STATE);
    assert_int_equal(rt_scene_get_info(f->scene, &info), RT_ERROR_STATE);
    kit_says(f->ctx, "the scene was never committed; call rt_scene_commit first");
    d.accel = "kdtree,octre";
    REFUSED(rt_scene_commit(f->scene, &d), "accel has the word \"octre\"; did you mean \"octree\"?");
    d.accel = "";
    REFUSED(rt_scene_commit(f->scene, &d), "the words are \"auto\", \"kdtree\", \"octree\", \"bvh\" and \"brute\"");
    d.accel = "auto";
    d.builder = "exakt";
    REFUSED(rt_scene_commit(f->scene, &d), "did you mean \"exact\"?");
    d = rt_commit_desc_default();
    d.max_depth = 97;
    REFUSED(rt_scene_commit(f->scene, &d), "max_depth is 97; it must be at most 96");
    d = rt_commit_desc_default();
    d.cost_traverse = NAN;
    REFUSED(rt_scene_commit(f->scene, &d), "cost_traverse is nan");
    REFUSED(rt_scene_set_tracer(f->scene, "gpu"),
            "there is no tracer \"gpu\"; this build has \"auto\", \"brute\", \"kdtree\", \"octree\", \"bvh\"");
    kit_sphere(f->scene, 0, 0, 0, 1);
    assert_int_equal(rt_scene_commit(f->scene, NULL), RT_OK);
    REFUSED(rt_scene_get_tree_info(f->scene, 1, NULL, &tree), "index is 1; the scene has 1 trees");
    assert_int_equal(rt_scene_get_tree_info(f->scene, 0, NULL, &tree), RT_OK);
    assert_string_equal(tree.name, "bvh");
    assert_int_equal(tree.primitives, 1);
}

/* Handles are positions; a removed one is not given again and is told by name. */
static void test_handles(void **state)
{
    fixture *f = *state;
    uint32_t a = kit_sphere(f->scene, 0, 0, 0, 1), b = kit_square(f->scene, 5, -3), c = kit_sphere(f->scene, 0, 0, 4, 1);
    rt_ray down = kit_ray(0, 0, 10, 0, 0, -1);
    rt_scene_info info;
    assert_int_equal(a, 0);
    assert_int_equal(b, 1);
    assert_int_equal(c, 2);
    assert_int_equal(rt_scene_commit(f->scene, NULL), RT_OK);
    assert_int_equal(kit_hit(f->scene, down).geom_id, c);
    assert_int_equal(rt_scene_remove_geometry(f->scene, (rt_geometry){c}), RT_OK);
    REFUSED(rt_scene_remove_geometry(f->scene, (rt_geometry){c}), "rt_scene_remove_geometry: geometry 2 was removed");
    REFUSED(rt_scene_set_geometry_mask(f->scene, (rt_geometry){8}, 1), "geometry 8 is not one of the scene");
    assert_int_equal(kit_sphere(f->scene, 0, 0, 6, 1), 3);
    assert_int_equal(rt_scene_commit(f->scene, NULL), RT_OK);
    assert_int_equal(kit_hit(f->scene, down).geom_id, 3);
    assert_int_equal(rt_scene_set_geometry_mask(f->scene, (rt_geometry){3}, 2), RT_OK);
    assert_int_equal(rt_scene_commit(f->scene, NULL), RT_OK);
    down.mask = 1;
    assert_int_equal(kit_hit(f->scene, down).geom_id, a);
    assert_int_equal(rt_scene_get_info(f->scene, &info), RT_OK);
    assert_int_equal(info.triangles, 2);
    assert_int_equal(info.shapes, 2);
    assert_int_equal(info.geometries, 3);
    assert_int_equal(info.built_trees, 0);
}

static void test_bounds(void **state)
{
    fixture *f = *state;
    rt_plane_desc plane = rt_plane_desc_default();
    rt_instance_desc inst = rt_instance_desc_default();
    rt_scene *child = kit_scene(f->ctx);
    rt_camera_desc camera;
    rt_vec3 lo, hi;
    assert_int_equal(rt_scene_add_plane(f->scene, &plane, NULL), RT_OK);
    REFUSED(rt_scene_bounds(f->scene, NULL, &hi), "low or high is NULL");
    kit_sphere(f->scene, 1, 2, 3, 0.5f);
    kit_sphere(child, 0, 0, 0, 1);
    inst.child = child;
    inst.transform =
        rt_transform_multiply(rt_transform_translate((rt_vec3){-10, 0, 0}), rt_transform_rotate((rt_vec3){0, 1, 0}, 90));
    assert_int_equal(rt_scene_add_instance(f->scene, &inst, NULL), RT_OK);
    assert_int_equal(rt_scene_bounds(f->scene, &lo, &hi), RT_OK);
    assert_true(lo.x <= -11 && lo.x > -11.001f);
    assert_true(hi.x >= 1.5f && hi.x < 1.501f);
    assert_true(hi.y >= 2.5f && hi.y < 2.501f);
    assert_int_equal(rt_scene_frame_camera(f->scene, 0.5f), RT_OK);
    assert_int_equal(rt_scene_get_camera(f->scene, &camera), RT_OK);
    assert_true(fabsf(camera.look_at.x - 0.5f * (lo.x + hi.x)) < 1e-4f);
    /* every corner lies inside the narrower angle of view */
    for (int i = 0; i < 8; i++) {
        rt_vec3 p = {i & 1 ? hi.x : lo.x, i & 2 ? hi.y : lo.y, i & 4 ? hi.z : lo.z};
        double a[3] = {camera.look_at.x - camera.eye.x, camera.look_at.y - camera.eye.y, camera.look_at.z - camera.eye.z};
        double b[3] = {p.x - camera.eye.x, p.y - camera.eye.y, p.z - camera.eye.z};
        double ab = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        double la = sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]), lb = sqrt(b[0] * b[0] + b[1] * b[1] + b[2] * b[2]);
        assert_true(ab / la / lb > cos(atan(0.5 * tan(25.0 * 3.14159265 / 180.0))));
    }
    rt_scene_destroy(child);
}

static void test_transforms(void **state)
{
    rt_transform r = rt_transform_rotate((rt_vec3){0, 0, 2}, 90), s;
    (void)state;
    assert_true(r.m[0] == 0 && r.m[1] == -1 && r.m[4] == 1 && r.m[5] == 0); /* exact at quarters */
    s = rt_transform_multiply(rt_transform_translate((rt_vec3){1, 2, 3}), r);
    assert_true(s.m[3] == 1 && s.m[7] == 2 && s.m[11] == 3 && s.m[4] == 1);
    s = rt_transform_multiply(r, rt_transform_translate((rt_vec3){1, 2, 3}));
    assert_true(s.m[3] == -2 && s.m[7] == 1 && s.m[11] == 3);
}

/* ---- polygons ---- */

static double area2(const float *p, uint32_t a, uint32_t b, uint32_t c)
{
    return ((double)p[3 * b] - p[3 * a]) * ((double)p[3 * c + 1] - p[3 * a + 1]) -
           ((double)p[3 * b + 1] - p[3 * a + 1]) * ((double)p[3 * c] - p[3 * a]);
}

/* The triangles cover the polygon: areas of one sign, and their sum is the polygon's. */
static void check_cut(const float *p, uint32_t n)
{
    uint32_t corners[64] = {0}, scratch[RTI_POLYGON_SCRATCH * 64], tri[186];
    double whole = 0, sum = 0;
    for (uint32_t i = 0; i < n; i++) {
        corners[i] = i;
        whole += area2(p, 0, i, (i + 1) % n);
    }
    rti_polygon_triangulate(p, corners, n, scratch, tri);
    for (uint32_t i = 0; i + 2 < n; i++) {
        double a = area2(p, tri[3 * i], tri[3 * i + 1], tri[3 * i + 2]);
        assert_true(a * whole >= 0);
        sum += a;
    }
    assert_true(fabs(sum - whole) <= 1e-6 * fabs(whole));
}

static void test_polygons(void **state)
{
    static const float arrow[] = {0, 0, 0, 4, -3, 0, 2, 0, 0, 4, 3, 0};
    static const float spiral[] = {0, 0, 1, 10, 0, 1, 10, 10, 1, 2, 10, 1, 2, 4, 1, 6, 4, 1,
                                   6, 6, 1, 4,  6, 1, 4,  8,  1, 8, 8,  1, 8, 2, 1, 0, 2, 1};
    /* a square with a square hole, joined by a bridge that is walked twice */
    static const float hole[] = {0, 0, 0, 10, 0, 0, 10, 10, 0, 0, 10, 0, 0, 0, 0, 3, 3, 0, 3, 7, 0, 7, 7, 0, 7, 3, 0, 3, 3, 0};
    float star[3 * 40], backward[3 * 40], folded[] = {0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0, 1.5f, 0, 0};
    uint32_t corners[] = {0, 1, 2, 3, 4}, scratch[RTI_POLYGON_SCRATCH * 5], tri[9];
    (void)state;
    check_cut(arrow, 4);
    check_cut(spiral, 12);
    check_cut(hole, 10);
    for (int i = 0; i < 40; i++) {
        double a = 6.283185307 * i / 40, r = i % 2 ? 1 : 5;
        star[3 * i] = (float)(r * cos(a));
        star[3 * i + 1] = (float)(r * sin(a));
        star[3 * i + 2] = star[3 * i] * 0.25f;
    }
    check_cut(star, 40);
    for (int i = 0; i < 40; i++)
        memcpy(backward + 3 * i, star + 3 * (39 - i), 3 * sizeof(float));
    check_cut(backward, 40);
    rti_polygon_triangulate(folded, corners, 5, scratch, tri); /* all on a line: still three triangles of its corners */
    for (int i = 0; i < 9; i++)
        assert_true(tri[i] < 5);
}

static void test_faces(void **state)
{
    fixture *f = *state;
    static const float positions[] = {0, 0, 0, 2, 0, 0, 2, 2, 0, 0, 2, 0, 4, 0, 0, 4, 2, 0};
    static const uint32_t sizes[] = {4, 4}, indices[] = {0, 1, 2, 3, 1, 4, 5, 2};
    rt_polyhedron_desc d = rt_polyhedron_desc_default();
    rt_surface at;
    d.positions = positions;
    d.vertex_count = 6;
    d.face_sizes = sizes;
    d.face_count = 2;
    d.indices = indices;
    d.index_count = 8;
    assert_int_equal(rt_scene_add_polyhedron(f->scene, &d, NULL), RT_OK);
    assert_int_equal(rt_scene_commit(f->scene, NULL), RT_OK);
    for (int i = 0; i < 4; i++) {
        rt_ray ray = kit_ray(0.5f + (float)i, 0.7f, 5, 0, 0, -1);
        rt_hit hit = kit_hit(f->scene, ray);
        rt_scene_surface(f->scene, &ray, &hit, &at);
        assert_int_equal(at.face_id, i / 2);
        assert_true(at.ng.z == 1.0f);
    }
}

/* No spheres, no triangles, no faces: geometries all the same, which nothing hits. */
static void test_nothing(void **state)
{
    fixture *f = *state;
    rt_spheres_desc s = rt_spheres_desc_default();
    rt_mesh_desc m = rt_mesh_desc_default();
    rt_polyhedron_desc p = rt_polyhedron_desc_default();
    rt_geometry g;
    kit_ok(f->ctx, rt_scene_add_spheres(f->scene, &s, NULL));
    kit_ok(f->ctx, rt_scene_add_mesh(f->scene, &m, NULL));
    kit_ok(f->ctx, rt_scene_add_polyhedron(f->scene, &p, &g));
    assert_int_equal(g.id, 2);
    kit_ok(f->ctx, rt_scene_commit(f->scene, NULL));
    assert_int_equal(kit_hit(f->scene, kit_ray(0, 0, 9, 0, 0, -1)).prim_id, RT_INVALID_ID);
}

static void test_many_adds(void **state)
{
    fixture *f = *state;
    for (int i = 0; i < 20000; i++)
        kit_sphere(f->scene, (float)(i % 100), (float)(i / 100 % 100), (float)(i / 10000), 0.4f);
    assert_int_equal(rt_scene_commit(f->scene, NULL), RT_OK);
    for (int i = 0; i < 100; i++)
        assert_int_equal(kit_hit(f->scene, kit_ray((float)i, 7, 10, 0, 0, -1)).geom_id, 10700 + i);
}

int main(void)
{
#define T(name) cmocka_unit_test_setup_teardown(name, setup, teardown)
    const struct CMUnitTest tests[] = {T(test_create),
                                       T(test_material_refusals),
                                       T(test_shape_refusals),
                                       T(test_mesh_refusals),
                                       T(test_light_camera_refusals),
                                       T(test_instance_refusals),
                                       T(test_commit_refusals),
                                       T(test_handles),
                                       T(test_bounds),
                                       T(test_transforms),
                                       T(test_polygons),
                                       T(test_faces),
                                       T(test_nothing),
                                       T(test_many_adds)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
