/* What is at a hit: points, normals, coordinates, materials, error bounds. */
#include "scene_kit.h"

#include <math.h>

#include "kernel/surface.h"
#include "scene/snapshot.h"
#include "kernel_alone.h"

static uint32_t seed = 3;

static double dot(rt_vec3 a, rt_vec3 b)
{
    return (double)a.x * b.x + (double)a.y * b.y + (double)a.z * b.z;
}

static rt_surface surface(const rt_scene *scene, rt_ray ray, rt_hit hit)
{
    rt_surface s;
    rt_scene_surface(scene, &ray, &hit, &s);
    return s;
}

static void test_mesh(void **state)
{
    static const float positions[] = {0, 0, 0, 4, 0, 0, 0, 4, 0}, normals[] = {0, 0, 1, 1, 0, 1, 0, 0, 0},
                       uvs[] = {0, 0, 1, 0, 0, 1}, colors[] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    static const uint32_t indices[] = {0, 1, 2}, materials[] = {1};
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx);
    rt_material_desc md = rt_material_desc_default();
    rt_mesh_desc d = rt_mesh_desc_default();
    rt_ray down = kit_ray(1, 2, 5, 0, 0, -1), up = kit_ray(1, 2, -5, 0, 0, 1);
    rt_surface s;
    (void)state;
    md.color = (rt_vec3){0.5f, 0.5f, 1};
    assert_int_equal(rt_scene_add_material(scene, &md, NULL), RT_OK);
    d.positions = positions;
    d.vertex_count = 3;
    d.indices = indices;
    d.triangle_count = 1;
    d.normals = normals;
    d.uvs = uvs;
    d.colors = colors;
    d.face_materials = materials;
    d.common.user_id = 42;
    d.common.uv_transform[0] = 2;
    d.common.uv_transform[5] = 7;
    assert_int_equal(rt_scene_add_mesh(scene, &d, NULL), RT_OK);
    kit_commit(scene);
    s = surface(scene, down, kit_hit(scene, down));
    assert_true(fabsf(s.position.x - 1) < 1e-6f && fabsf(s.position.y - 2) < 1e-6f && s.position.z == 0);
    assert_true(s.ng.x == 0 && s.ng.y == 0 && s.ng.z == 1);
    assert_true(fabsf(s.ns.x - 0.25f / sqrtf(0.25f * 0.25f + 0.5f * 0.5f)) < 1e-6f && s.ns.y == 0); /* weights 1/4, 1/4, 1/2 */
    assert_true(fabsf(s.u - 0.5f) < 1e-6f && fabsf(s.v - 7.5f) < 1e-6f);
    assert_int_equal(s.material.id, 1);
    assert_int_equal(s.material_scene, 0);
    assert_int_equal(s.user_id, 42);
    assert_int_equal(s.face_id, 0);
    assert_true(fabsf(s.color.x - 0.125f) < 1e-6f && fabsf(s.color.y - 0.125f) < 1e-6f && fabsf(s.color.z - 0.5f) < 1e-6f);
    s = surface(scene, up, kit_hit(scene, up)); /* not turned to the ray */
    assert_true(s.ng.z == 1);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

/* The lower left corner of the picture stands at the plane's point, upright, as wide as texture_size. */
static void test_plane(void **state)
{
    static const uint8_t pixels[4 * 2] = {0};
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx);
    rt_texture_desc td = rt_texture_desc_default();
    rt_material_desc md = rt_material_desc_default();
    rt_plane_desc d = rt_plane_desc_default();
    rt_ray ray;
    rt_surface s;
    (void)state;
    td.width = 4;
    td.height = 2;
    td.pixels = pixels;
    td.format = RT_PIXEL_GRAY8;
    assert_int_equal(rt_scene_add_texture(scene, &td, &md.color_texture), RT_OK);
    assert_int_equal(rt_scene_add_material(scene, &md, &d.common.material), RT_OK);
    d.point = (rt_vec3){10, 20, 30};
    d.normal = (rt_vec3){0, 0, 3};
    d.texture_size = 8;
    assert_int_equal(rt_scene_add_plane(scene, &d, NULL), RT_OK);
    kit_commit(scene);
    ray = kit_ray(12, 23, 90, 0, 0, -1); /* u to the right: +x; v up: +y; 8 x 4 units */
    s = surface(scene, ray, kit_hit(scene, ray));
    assert_true(fabsf(s.u - 0.25f) < 1e-6f && fabsf(s.v - 0.75f) < 1e-6f);
    assert_true(s.ng.z == 1 && s.position.z == 30);
    rt_scene_destroy(scene);
    scene = kit_scene(ctx);
    d = rt_plane_desc_default();
    d.u_axis = (rt_vec3){0, 5, -2};
    d.texture_size = 4;
    d.texture_height = 2;
    assert_int_equal(rt_scene_add_plane(scene, &d, NULL), RT_OK); /* floor: u towards -z */
    kit_commit(scene);
    ray = kit_ray(-1, 3, -2, 0, -1, 0);
    s = surface(scene, ray, kit_hit(scene, ray));
    assert_true(fabsf(s.u - 0.5f) < 1e-6f && fabsf(s.v - 0.5f) < 1e-6f); /* v: normal x u = -x */
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

/* Exact distance of a point from a plane through three points, in double. */
static double plane_distance(const rt_vec3 *t, rt_vec3 p)
{
    double e[3] = {(double)t[1].x - t[0].x, (double)t[1].y - t[0].y, (double)t[1].z - t[0].z};
    double f[3] = {(double)t[2].x - t[0].x, (double)t[2].y - t[0].y, (double)t[2].z - t[0].z};
    double n[3] = {e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]};
    double l = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    return fabs(n[0] * ((double)p.x - t[0].x) + n[1] * ((double)p.y - t[0].y) + n[2] * ((double)p.z - t[0].z)) / l;
}

/* Random triangles near and far from the origin: the point lies within its bound of the plane, a ray that leaves along any
 * direction of the side it leaves to does not meet the triangle again. */
static void test_error_bound(void **state)
{
    static const float moves[] = {0, 10, 1e4f, 1e6f};
    rt_context *ctx = kit_context(NULL, 1);
    uint32_t checked = 0;
    (void)state;
    for (int round = 0; round < 400; round++) {
        rt_scene *scene = kit_scene(ctx);
        float size = powf(10, kit_range(&seed, -2, 3)), move = moves[round % 4];
        rt_vec3 t[3];
        uint32_t indices[] = {0, 1, 2};
        rt_mesh_desc d = rt_mesh_desc_default();
        rti_snapshot *snapshot;
        for (int i = 0; i < 3; i++) {
            t[i] = kit_vec(&seed, size);
            t[i].x += move;
            t[i].z -= move;
        }
        d.positions = &t[0].x;
        d.vertex_count = 3;
        d.indices = indices;
        d.triangle_count = 1;
        assert_int_equal(rt_scene_add_mesh(scene, &d, NULL), RT_OK);
        kit_commit(scene);
        snapshot = rti_scene_snapshot(scene);
        for (int i = 0; i < 40; i++) {
            float u = kit_range(&seed, 0, 0.5f), v = kit_range(&seed, 0, 0.5f);
            rt_vec3 from = kit_vec(&seed, size * 3), p = {t[0].x + u * (t[1].x - t[0].x) + v * (t[2].x - t[0].x),
                                                          t[0].y + u * (t[1].y - t[0].y) + v * (t[2].y - t[0].y),
                                                          t[0].z + u * (t[1].z - t[0].z) + v * (t[2].z - t[0].z)};
            rt_ray ray = kit_ray(from.x + move, from.y, from.z - move, p.x - from.x - move, p.y - from.y, p.z - from.z + move);
            rt_hit hit = kit_hit(scene, ray);
            rt_surface s;
            if (hit.prim_id == RT_INVALID_ID)
                continue;
            s = surface(scene, ray, hit);
            assert_true(plane_distance(t, s.position) <= s.position_error);
            for (int k = 0; k < 8; k++) {
                rt_vec3 dir = kit_vec(&seed, 1);
                rtk_surface at = rtk_surface_at(
                    rti_snapshot_view(snapshot),
                    (rtk_ray){rtk_v3(ray.org.x, ray.org.y, ray.org.z), rtk_v3(ray.dir.x, ray.dir.y, ray.dir.z), 0, 1e30f, ~0u},
                    (rtk_hit){hit.t, hit.u, hit.v, hit.prim_id, hit.geom_id, hit.inst_id}, 0.0f);
                rtk_vec3 org = rtk_surface_leave(at, rtk_v3(dir.x, dir.y, dir.z));
                rt_ray away = kit_ray(org.x, org.y, org.z, dir.x, dir.y, dir.z);
                if (fabs(dot(dir, s.ng)) < 1e-4)
                    continue;
                assert_int_equal(kit_hit(scene, away).prim_id, RT_INVALID_ID);
                checked++;
            }
        }
        rti_snapshot_release(snapshot);
        rt_scene_destroy(scene);
    }
    assert_true(checked > 20000);
    rt_context_destroy(ctx);
}

/* Spheres placed by rotations, uneven scales and far moves: the bound holds in the world, and no ray that leaves outwards comes
 * back. */
static void test_instance_bound(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    uint32_t checked = 0;
    (void)state;
    for (int round = 0; round < 100; round++) {
        rt_scene *child = kit_scene(ctx), *scene = kit_scene(ctx);
        rt_instance_desc d = rt_instance_desc_default();
        float far = round % 3 == 2 ? 1e4f : 5;
        rt_vec3 c = kit_vec(&seed, 10), move = kit_vec(&seed, far);
        rt_vec3 scale = {kit_range(&seed, 0.1f, 4), kit_range(&seed, 0.1f, 4), kit_range(&seed, 0.1f, 4)};
        rti_snapshot *snapshot;
        kit_sphere(child, c.x, c.y, c.z, kit_range(&seed, 0.1f, 3));
        kit_commit(child);
        d.child = child;
        d.transform = rt_transform_multiply(
            rt_transform_translate(move),
            rt_transform_multiply(rt_transform_rotate(kit_vec(&seed, 1), kit_range(&seed, 0, 360)), rt_transform_scale(scale)));
        assert_int_equal(rt_scene_add_instance(scene, &d, NULL), RT_OK);
        kit_commit(scene);
        snapshot = rti_scene_snapshot(scene);
        for (int i = 0; i < 50; i++) {
            const float *m = d.transform.m;
            rt_vec3 to = {m[0] * c.x + m[1] * c.y + m[2] * c.z + m[3], m[4] * c.x + m[5] * c.y + m[6] * c.z + m[7],
                          m[8] * c.x + m[9] * c.y + m[10] * c.z + m[11]};
            rt_vec3 from = {to.x + kit_range(&seed, -50, 50), to.y + kit_range(&seed, -50, 50), to.z + kit_range(&seed, -50, 50)};
            rt_ray ray = kit_ray(from.x, from.y, from.z, to.x - from.x, to.y - from.y, to.z - from.z);
            rt_hit hit = kit_hit(scene, ray);
            rt_surface s;
            rtk_surface at;
            if (hit.prim_id == RT_INVALID_ID)
                continue;
            s = surface(scene, ray, hit);
            assert_true(fabs(dot(s.ng, s.ng) - 1) < 1e-5);
            assert_true(dot(s.ng, ray.dir) < 0); /* outwards, and the ray came from outside */
            at = rtk_surface_at(rti_snapshot_view(snapshot),
                                (rtk_ray){rtk_v3(from.x, from.y, from.z), rtk_v3(ray.dir.x, ray.dir.y, ray.dir.z), 0, 1e30f, ~0u},
                                (rtk_hit){hit.t, hit.u, hit.v, hit.prim_id, hit.geom_id, hit.inst_id}, 0.0f);
            for (int k = 0; k < 8; k++) {
                rt_vec3 dir = kit_vec(&seed, 1);
                rtk_vec3 org = rtk_surface_leave(at, rtk_v3(dir.x, dir.y, dir.z));
                if (dot(dir, s.ng) < 1e-3)
                    continue;
                assert_int_equal(kit_hit(scene, kit_ray(org.x, org.y, org.z, dir.x, dir.y, dir.z)).prim_id, RT_INVALID_ID);
                checked++;
            }
        }
        rti_snapshot_release(snapshot);
        rt_scene_destroy(child);
        rt_scene_destroy(scene);
    }
    assert_true(checked > 10000);
    rt_context_destroy(ctx);
}

/* Length in the texture for a length in the world: right where it is simple to say. */
static void test_uv_scale(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *child = kit_scene(ctx), *scene = kit_scene(ctx);
    rt_instance_desc d = rt_instance_desc_default();
    rti_snapshot *s;
    rtk_ray ray = {{0.3f, 0.2f, 9}, {0, 0, -1}, 0, 1e30f, ~0u};
    rtk_surface at;
    rt_hit hit;
    (void)state;
    kit_square(child, 2, 0); /* 4 units for 1 */
    kit_commit(child);
    d.child = child;
    d.transform = rt_transform_scale((rt_vec3){3, 3, 3});
    assert_int_equal(rt_scene_add_instance(scene, &d, NULL), RT_OK);
    kit_commit(scene);
    s = rti_scene_snapshot(scene);
    hit = kit_hit(scene, kit_ray(0.3f, 0.2f, 9, 0, 0, -1));
    at = rtk_surface_at(rti_snapshot_view(s), ray, (rtk_hit){hit.t, hit.u, hit.v, hit.prim_id, hit.geom_id, hit.inst_id}, 0.0f);
    assert_true(fabsf(at.uv_scale - 1.0f / 12) < 1e-6f);
    rti_snapshot_release(s);
    rt_scene_destroy(child);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

/* Hits that never were give nothing. */
static void test_foreign_hits(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx);
    rt_ray ray = kit_ray(0, 0, 9, 0, 0, -1);
    const rt_hit hits[] = {{1, 0, 0, RT_INVALID_ID, RT_INVALID_ID, RT_INVALID_ID},
                           {1, 0, 0, 5, 0, RT_INVALID_ID},
                           {1, 0, 0, 0, 9, RT_INVALID_ID},
                           {1, 0, 0, 0, 0, 0}};
    (void)state;
    assert_int_equal(surface(scene, ray, hits[3]).material.id, RT_INVALID_ID);
    kit_sphere(scene, 0, 0, 0, 1);
    kit_commit(scene);
    for (size_t i = 0; i < 4; i++)
        assert_int_equal(surface(scene, ray, hits[i]).material.id, RT_INVALID_ID);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_mesh),        cmocka_unit_test(test_plane),
                                       cmocka_unit_test(test_error_bound), cmocka_unit_test(test_instance_bound),
                                       cmocka_unit_test(test_uv_scale),    cmocka_unit_test(test_foreign_hits)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
