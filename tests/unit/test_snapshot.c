/* Commits: what they make, what they share, what they leave alone. */
#include "scene_kit.h"

#include <math.h>
#include <pthread.h>
#include <time.h>

#include "scene/snapshot.h"

static void test_empty(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx);
    rt_ray ray = kit_ray(0, 0, 5, 0, 0, -1);
    rt_hit hit = kit_hit(scene, ray);
    rt_vec3 low, high;
    (void)state;
    assert_int_equal(hit.prim_id, RT_INVALID_ID); /* before any commit too */
    kit_commit(scene);
    hit = kit_hit(scene, ray);
    assert_int_equal(hit.prim_id, RT_INVALID_ID);
    assert_true(hit.t == ray.tmax);
    assert_int_equal(kit_info(scene).tree_count, 0);
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
        kit_commit(scene);
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
    kit_commit(child);
    d.transform = rt_transform_multiply(rt_transform_translate((rt_vec3){-5, 0, 0}), rt_transform_scale((rt_vec3){2, 2, 2}));
    d.user_id = 77;
    assert_int_equal(rt_scene_add_instance(parent, &d, &b), RT_OK);
    d.transform = rt_transform_translate((rt_vec3){0, 20, 0});
    assert_int_equal(rt_scene_add_instance(parent, &d, &c), RT_OK);
    kit_commit(parent);
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
    kit_commit(parent);
    assert_int_equal(kit_hit(parent, kit_ray(5, 0, 10, 0, 0, -1)).prim_id, RT_INVALID_ID);
    assert_int_equal(kit_hit(parent, kit_ray(0, 20, 10, 0, 0, -1)).inst_id, c.id);
    rt_scene_destroy(child); /* lives on in the parent */
    kit_commit(parent);
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
    kit_commit(scene);
    assert_int_equal(kit_info(scene).built_trees, 1);
    assert_int_equal(rt_scene_hash(scene, before), RT_OK);
    kit_commit(scene);
    assert_int_equal(kit_info(scene).built_trees, 0);
    assert_int_equal(rt_scene_hash(scene, after), RT_OK);
    assert_string_equal(before, after);
    red.color = (rt_vec3){1, 0, 0};
    assert_int_equal(rt_scene_add_material(scene, &red, &m), RT_OK);
    assert_int_equal(rt_scene_set_geometry_material(scene, (rt_geometry){0}, m), RT_OK);
    camera.eye.x = 3;
    assert_int_equal(rt_scene_set_camera(scene, &camera), RT_OK);
    kit_commit(scene);
    assert_int_equal(kit_info(scene).built_trees, 0);
    assert_int_equal(rt_scene_hash(scene, after), RT_OK);
    assert_string_not_equal(before, after);
    kit_commit(other);
    assert_int_equal(kit_info(other).built_trees, 0); /* the tree of the first scene */
    assert_int_equal(rt_scene_hash(other, after), RT_OK);
    assert_string_equal(before, after);
    rt_scene_destroy(scene);
    rt_scene_destroy(other);
    rt_context_destroy(ctx);
}

/* The body of a visible light is a geometry behind the described ones; a point light knows the lamp around it. */
static void test_lamps(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx);
    rt_light_desc d = rt_light_desc_default();
    rt_material_desc glass = rt_material_desc_default();
    rt_material m;
    rt_light id;
    rt_hit hit;
    rti_snapshot *s;
    const rtk_light *lights;
    (void)state;
    glass.transparency = 0.5f;
    assert_int_equal(rt_scene_add_material(scene, &glass, &m), RT_OK);
    kit_sphere(scene, 0, 0, 0, 1);
    kit_sphere(scene, 0.2f, 0, 0, 2);
    assert_int_equal(rt_scene_set_geometry_material(scene, (rt_geometry){kit_sphere(scene, 0, 0, 0, 9)}, m), RT_OK);
    d.at = (rt_vec3){0.5f, 0, 0};
    d.falloff = RT_FALLOFF_INVERSE_SQUARE;
    assert_int_equal(rt_scene_add_light(scene, &d, NULL), RT_OK);
    d.type = RT_LIGHT_SPHERE;
    d.at.x = 50;
    d.radius = 2;
    d.intensity = 3;
    d.visible = 1;
    assert_int_equal(rt_scene_add_light(scene, &d, &id), RT_OK);
    kit_commit(scene);
    s = rti_scene_snapshot(scene);
    lights = rti_snapshot_view(s)->lights;
    assert_true(lights[0].body_radius == 2 && lights[0].body_at[0] == 0.2f); /* the glass one is no lamp */
    assert_true(lights[1].body_radius == 0);
    assert_int_equal(lights[1].geom, 3);
    assert_true(fabsf(lights[0].select_pdf + lights[1].select_pdf - 1) < 1e-6f && lights[1].select_cdf == 1.0f);
    assert_true(fabsf(lights[1].select_pdf / lights[0].select_pdf - 12) < 1e-4f); /* 3 r^2 times as strong */
    hit = kit_hit(scene, kit_ray(50, 0, 10, 0, 0, -1));
    assert_int_equal(hit.geom_id, 3);
    assert_true(fabsf(hit.t - 8) < 1e-4f);
    assert_int_equal(rti_snapshot_view(s)->materials[rti_snapshot_view(s)->groups[0].geoms[3].material].type,
                     RTK_MATERIAL_EMISSIVE);
    rti_snapshot_release(s);
    assert_int_equal(rt_scene_remove_light(scene, id), RT_OK);
    kit_commit(scene);
    assert_int_equal(kit_hit(scene, kit_ray(50, 0, 10, 0, 0, -1)).prim_id, RT_INVALID_ID);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

/* A tree that is asked for later is built once and kept; one that is there is not built again for a new scene after the old is
 * gone. */
static void test_trees_kept(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx);
    rti_snapshot *s, *with, *again;
    (void)state;
    kit_square(scene, 1, 0);
    kit_commit(scene);
    s = rti_scene_snapshot(scene);
    assert_int_equal(rti_snapshot_with_tree(s, "test", RTK_TREE_BVH, NULL, &with), RT_OK);
    assert_ptr_equal(with, s);
    rti_snapshot_release(with);
    assert_int_equal(rti_snapshot_with_tree(s, "test", RTK_TREE_OCTREE, NULL, &with), RT_OK);
    assert_int_equal(rti_snapshot_view(with)->groups[0].parts[0].octree.kind, RTK_TREE_OCTREE);
    assert_ptr_equal(rti_snapshot_view(with)->groups[0].tris, rti_snapshot_view(s)->groups[0].tris);
    assert_int_equal(rti_snapshot_with_tree(s, "test", RTK_TREE_OCTREE, NULL, &again), RT_OK);
    assert_ptr_equal(rti_snapshot_view(again)->groups[0].parts[0].octree.oct,
                     rti_snapshot_view(with)->groups[0].parts[0].octree.oct);
    rti_snapshot_release(with);
    rti_snapshot_release(again);
    rti_snapshot_release(s);
    rt_scene_destroy(scene);
    scene = kit_scene(ctx);
    kit_square(scene, 1, 0);
    kit_commit(scene);
    assert_int_equal(kit_info(scene).built_trees, 0);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

/* ---- threads ---- */

typedef struct reader {
    const rt_scene *scene;
    atomic_bool *stop;
    size_t count; /* rays of a call: few stay with the snapshot, more hold it */
    atomic_uint answers;
    atomic_bool wrong;
} reader;

/* The scene holds a square at height 0, 1, 2, ... : every answer is one of them, never a miss. */
static void *read_on(void *data)
{
    reader *r = data;
    while (!atomic_load(r->stop)) {
        rt_ray rays[40];
        rt_hit hits[40];
        uint8_t occluded[40];
        for (int i = 0; i < 40; i++)
            rays[i] = kit_ray(-0.9f + 0.04f * (float)i, 0.1f, 100, 0, 0, -1);
        rt_scene_intersect(r->scene, rays, hits, r->count);
        rt_scene_occluded(r->scene, rays, occluded, r->count);
        for (size_t i = 0; i < r->count; i++) {
            float z = 100 - hits[i].t;
            if (hits[i].prim_id == RT_INVALID_ID || z != floorf(z) || z < 0 || z > 99 || z != 100 - hits[0].t || !occluded[i])
                atomic_store(&r->wrong, true);
        }
        atomic_fetch_add(&r->answers, 1);
    }
    return NULL;
}

static void test_queries_beside_commits(void **state)
{
    rt_context *ctx = kit_context(NULL, 2);
    rt_scene *scene = kit_scene(ctx);
    atomic_bool stop = false;
    pthread_t thread[3];
    reader r[3] = {{scene, &stop, 40, 0, false}, {scene, &stop, 7, 0, false}, {scene, &stop, 1, 0, false}};
    uint32_t last = kit_square(scene, 1, 0);
    (void)state;
    kit_commit(scene);
    for (int i = 0; i < 3; i++)
        assert_int_equal(pthread_create(&thread[i], NULL, read_on, &r[i]), 0);
    for (int i = 1; i < 60 || !atomic_load(&r[0].answers) || !atomic_load(&r[1].answers) || !atomic_load(&r[2].answers); i++) {
        uint32_t next = kit_square(scene, 1, (float)(i % 100));
        assert_int_equal(rt_scene_remove_geometry(scene, (rt_geometry){last}), RT_OK);
        kit_commit(scene);
        last = next;
    }
    atomic_store(&stop, true);
    for (int i = 0; i < 3; i++) {
        pthread_join(thread[i], NULL);
        assert_false(atomic_load(&r[i].wrong));
    }
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

static void soup(rt_scene *scene, uint32_t count)
{
    float *positions = malloc(9 * sizeof(float) * count);
    uint32_t *indices = malloc(3 * sizeof(uint32_t) * count), seed = 1;
    rt_mesh_desc d = rt_mesh_desc_default();
    for (uint32_t i = 0; i < 9 * count; i++) {
        seed = seed * 1664525u + 1013904223u;
        positions[i] = (float)(seed >> 8) / 16777216.0f + (float)(i / 9 % 97);
    }
    for (uint32_t i = 0; i < 3 * count; i++)
        indices[i] = i;
    d.positions = positions;
    d.vertex_count = 3 * count;
    d.indices = indices;
    d.triangle_count = count;
    assert_int_equal(rt_scene_add_mesh(scene, &d, NULL), RT_OK);
    free(positions);
    free(indices);
}

static void *commit_other(void *data)
{
    return (void *)(intptr_t)rt_scene_commit(data, NULL);
}

/* A cancelled commit says so and the old snapshot stays; the next one succeeds. */
static void test_cancel(void **state)
{
    rt_context *ctx = kit_context(NULL, 2);
    rt_scene *scene = kit_scene(ctx);
    pthread_t thread;
    void *result;
    char before[33], after[33];
    (void)state;
    kit_commit(scene);
    assert_int_equal(rt_scene_hash(scene, before), RT_OK);
    soup(scene, 100000);
    assert_int_equal(pthread_create(&thread, NULL, commit_other, scene), 0);
    for (int i = 0; i < 200; i++) { /* again and again: the commit begins by forgetting earlier cancels */
        struct timespec ms = {0, 1000000};
        nanosleep(&ms, NULL);
        rt_scene_cancel(scene);
    }
    pthread_join(thread, &result);
    assert_int_equal((intptr_t)result, RT_ERROR_CANCELLED);
    assert_int_equal(rt_scene_hash(scene, after), RT_OK);
    assert_string_equal(before, after);
    kit_commit(scene);
    assert_int_equal(kit_info(scene).triangles, 100000);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

static void test_two_contexts(void **state)
{
    rt_context *a = kit_context(NULL, 2), *b = kit_context(NULL, 2);
    rt_scene *x = kit_scene(a), *y = kit_scene(b);
    pthread_t thread[2];
    void *result;
    char hx[33], hy[33];
    (void)state;
    soup(x, 5000);
    soup(y, 5000);
    assert_int_equal(pthread_create(&thread[0], NULL, commit_other, x), 0);
    assert_int_equal(pthread_create(&thread[1], NULL, commit_other, y), 0);
    for (int i = 0; i < 2; i++) {
        pthread_join(thread[i], &result);
        assert_int_equal((intptr_t)result, RT_OK);
    }
    assert_int_equal(kit_info(x).built_trees, 1);
    assert_int_equal(kit_info(y).built_trees, 1); /* contexts share nothing */
    assert_int_equal(rt_scene_hash(x, hx), RT_OK);
    assert_int_equal(rt_scene_hash(y, hy), RT_OK);
    assert_string_equal(hx, hy);
    rt_scene_destroy(x);
    rt_context_destroy(a);
    assert_int_equal(rt_scene_hash(y, hy), RT_OK);
    rt_scene_destroy(y);
    rt_context_destroy(b);
}

/* Two scenes of one context that are committed at the same time share what is equal. */
static void test_two_commits(void **state)
{
    rt_context *ctx = kit_context(NULL, 2);
    rt_scene *scene[2] = {kit_scene(ctx), kit_scene(ctx)};
    pthread_t thread[2];
    (void)state;
    for (int round = 0; round < 10; round++) {
        for (int i = 0; i < 2; i++) {
            kit_sphere(scene[i], (float)round, 0, 0, 1);
            assert_int_equal(pthread_create(&thread[i], NULL, commit_other, scene[i]), 0);
        }
        for (int i = 0; i < 2; i++)
            pthread_join(thread[i], NULL);
        rti_snapshot *a = rti_scene_snapshot(scene[0]), *b = rti_scene_snapshot(scene[1]);
        assert_ptr_equal(rti_snapshot_view(a)->groups[0].shapes, rti_snapshot_view(b)->groups[0].shapes);
        assert_ptr_equal(rti_snapshot_view(a)->groups[0].parts[0].kdtree.kd, rti_snapshot_view(b)->groups[0].parts[0].kdtree.kd);
        rti_snapshot_release(a);
        rti_snapshot_release(b);
    }
    rt_scene_destroy(scene[0]);
    rt_scene_destroy(scene[1]);
    rt_context_destroy(ctx);
}

/* ---- memory ---- */

/* Everything once, stopping at the first failure, as a caller would. */
static rt_status build(rt_context *ctx)
{
    static const uint8_t pixels[12 * 12] = {1, 2, 3};
    static const float centers[] = {0, 0, 0, 3, 0, 0}, colors[] = {1, 0, 0, 0, 1, 0};
    static const float corners[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    static const uint32_t sizes[] = {4}, index[] = {0, 1, 2, 3};
    rt_scene *child = NULL, *scene = NULL;
    rt_texture_desc td = rt_texture_desc_default();
    rt_material_desc md = rt_material_desc_default();
    rt_spheres_desc sd = rt_spheres_desc_default();
    rt_plane_desc pd = rt_plane_desc_default();
    rt_polyhedron_desc hd = rt_polyhedron_desc_default();
    rt_light_desc ld = rt_light_desc_default();
    rt_instance_desc id = rt_instance_desc_default();
    rt_geometry g;
    rt_status status;
    td.width = 12;
    td.height = 4;
    td.pixels = pixels;
    sd.centers = centers;
    sd.colors = colors;
    sd.count = 2;
    hd.positions = corners;
    hd.vertex_count = 4;
    hd.face_sizes = sizes;
    hd.face_count = 1;
    hd.indices = index;
    hd.index_count = 4;
    if ((status = rt_scene_create(ctx, &child)) != RT_OK || (status = rt_scene_create(ctx, &scene)) != RT_OK)
        goto end;
    if ((status = rt_scene_add_texture(scene, &td, &md.color_texture)) != RT_OK ||
        (status = rt_scene_add_material(scene, &md, NULL)) != RT_OK ||
        (status = rt_scene_add_spheres(scene, &sd, NULL)) != RT_OK || (status = rt_scene_add_plane(scene, &pd, NULL)) != RT_OK ||
        (status = rt_scene_add_polyhedron(child, &hd, NULL)) != RT_OK || (status = kit_try_square(child, 1, 0, &g)) != RT_OK ||
        (status = rt_scene_add_light(scene, &ld, NULL)) != RT_OK || (status = rt_scene_commit(child, NULL)) != RT_OK)
        goto end;
    id.child = child;
    id.transform = rt_transform_translate((rt_vec3){9, 0, 0});
    if ((status = rt_scene_add_instance(scene, &id, NULL)) != RT_OK || (status = rt_scene_commit(scene, NULL)) != RT_OK)
        goto end;
    assert_int_equal(kit_hit(scene, kit_ray(9.5f, 0.5f, 9, 0, 0, -1)).inst_id, 0);
end:
    rt_scene_destroy(scene);
    rt_scene_destroy(child);
    return status;
}

static void test_no_memory(void **state)
{
    rt_status status;
    long n = 0;
    (void)state;
    do {
        kit_memory memory = {0};
        rt_context *ctx = kit_context(&memory, 1);
        atomic_store(&memory.requests, 0);
        atomic_store(&memory.fail_at, ++n);
        status = build(ctx);
        if (status != RT_OK) {
            assert_int_equal(status, RT_ERROR_MEMORY);
            kit_says(ctx, "the allocator could not give");
        }
        rt_context_destroy(ctx);
        assert_int_equal(atomic_load(&memory.blocks), 0);
        assert_int_equal(atomic_load(&memory.bytes), 0);
    } while (status != RT_OK);
    assert_true(n > 50);
}

/* A limit is told with its numbers, and leaves the old snapshot; kept trees make way. */
static void test_memory_limit(void **state)
{
    rt_context_desc d = rt_context_desc_default();
    rt_context *ctx;
    rt_scene *scene;
    rt_sphere_desc sphere = rt_sphere_desc_default();
    rt_status status;
    (void)state;
    d.workers = 1;
    d.memory_limit = 4u << 20;
    assert_int_equal(rt_context_create(&d, &ctx), RT_OK);
    scene = kit_scene(ctx);
    kit_sphere(scene, 0, 0, 0, 1);
    kit_commit(scene);
    do
        status = rt_scene_add_sphere(scene, &sphere, NULL);
    while (status == RT_OK);
    assert_int_equal(status, RT_ERROR_MEMORY_LIMIT);
    kit_says(ctx, "would pass the memory limit of 4194304 bytes");
    assert_int_equal(rt_scene_commit(scene, NULL), RT_ERROR_MEMORY_LIMIT);
    assert_int_equal(kit_hit(scene, kit_ray(0, 0, 9, 0, 0, -1)).geom_id, 0);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

static void test_many_contexts(void **state)
{
    (void)state;
    for (int i = 0; i < 1000; i++) {
        kit_memory memory = {0};
        rt_context *ctx = kit_context(&memory, 1 + (uint32_t)(i % 3));
        assert_int_equal(build(ctx), RT_OK);
        rt_context_destroy(ctx);
        assert_int_equal(atomic_load(&memory.blocks), 0);
    }
}

/* ---- queries ---- */

static void test_intersect_all(void **state)
{
    static const char *const tracers[] = {"brute", "kdtree", "octree"};
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx);
    rt_ray down = kit_ray(0.3f, 0.1f, 10, 0, 0, -1);
    rt_hit hits[16];
    (void)state;
    kit_square(scene, 1, 0);
    kit_square(scene, 1, 0); /* coincident */
    kit_sphere(scene, 0, 0, -5, 1);
    for (size_t i = 0; i < 3; i++) {
        assert_int_equal(rt_scene_set_tracer(scene, tracers[i]), RT_OK);
        kit_commit(scene);
        assert_int_equal(rt_scene_intersect_all(scene, &down, hits, 16), 4);
        assert_int_equal(hits[0].geom_id, 0);
        assert_int_equal(hits[1].geom_id, 1);
        assert_true(hits[0].t == hits[1].t);
        assert_int_equal(hits[2].geom_id, 2);
        assert_int_equal(hits[3].geom_id, 2);
        assert_true(hits[2].t < hits[3].t);
        assert_int_equal(rt_scene_intersect_all(scene, &down, hits, 3), 3);
        assert_int_equal(rt_scene_intersect_all(scene, &down, hits, 0), 0);
    }
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

/* Counts that end inside a block and inside a chunk of rays. */
static void test_counts(void **state)
{
    enum { MOST = 600 };
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx);
    rt_ray *rays = malloc(MOST * sizeof *rays);
    rt_hit hits[MOST + 1];
    uint8_t occluded[MOST + 1];
    (void)state;
    kit_square(scene, 1, 0);
    kit_commit(scene);
    for (int i = 0; i < MOST; i++)
        rays[i] = kit_ray(i % 3 ? 0.5f : 5.0f, 0.1f, 1.0f + (float)i, 0, 0, -1);
    for (size_t n = 0; n <= MOST; n = n < 40 ? n + 1 : n + 37) {
        memset(hits, 0x55, sizeof hits);
        memset(occluded, 0x55, sizeof occluded);
        rt_scene_intersect(scene, rays, hits, n);
        rt_scene_occluded(scene, rays, occluded, n);
        for (size_t i = 0; i < n; i++) {
            assert_int_equal(occluded[i], i % 3 != 0);
            assert_true(i % 3 == 0 ? hits[i].prim_id == RT_INVALID_ID : hits[i].t == 1.0f + (float)i);
        }
        assert_int_equal(hits[n].prim_id, 0x55555555);
        assert_int_equal(occluded[n], 0x55);
    }
    free(rays);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_empty),         cmocka_unit_test(test_kinds),        cmocka_unit_test(test_instances),
        cmocka_unit_test(test_sharing),       cmocka_unit_test(test_lamps),        cmocka_unit_test(test_trees_kept),
        cmocka_unit_test(test_intersect_all), cmocka_unit_test(test_counts),       cmocka_unit_test(test_queries_beside_commits),
        cmocka_unit_test(test_cancel),        cmocka_unit_test(test_two_contexts), cmocka_unit_test(test_two_commits),
        cmocka_unit_test(test_no_memory),     cmocka_unit_test(test_memory_limit), cmocka_unit_test(test_many_contexts)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
