/* Snapshot files: what is saved comes back bit for bit, and what is broken is refused. */
#include "scene_kit.h"

#include <stdio.h>
#include <unistd.h>

#include "scene/blob.h"
#include "trace/trace.h"

static char path[64];

static int setup(void **state)
{
    (void)state;
    snprintf(path, sizeof path, "/tmp/librt_scene_file_%ld.snap", (long)getpid());
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    unlink(path);
    return 0;
}

/* A little of everything: mesh with all attributes, polyhedron, shapes, plane, texture, lights, instances (one with planes, one
 * removed). */
static rt_scene *rich_scene(rt_context *ctx, rt_scene **child_out)
{
    static const float positions[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0},
                       normals[] = {0, 0, 1, 0, 0.1f, 1, 0, 0, 1, 0.1f, 0, 1}, uvs[] = {0, 0, 1, 0, 1, 1, 0, 1},
                       colors[] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3}, faces[] = {0, 1}, sizes[] = {4}, corners[] = {0, 1, 2, 3};
    static const uint8_t pixels[] = {255, 0, 0, 255, 0, 255, 0, 10, 0, 0, 255, 255, 255, 255, 255, 0, 9, 9, 9, 9, 8, 7, 6, 5};
    rt_scene *child = kit_scene(ctx), *scene = kit_scene(ctx);
    rt_texture_desc td = rt_texture_desc_default();
    rt_material_desc md = rt_material_desc_default();
    rt_mesh_desc mesh = rt_mesh_desc_default();
    rt_polyhedron_desc poly = rt_polyhedron_desc_default();
    rt_plane_desc plane = rt_plane_desc_default();
    rt_torus_desc torus = rt_torus_desc_default();
    rt_cone_desc cone = rt_cone_desc_default();
    rt_box_desc box = rt_box_desc_default();
    rt_light_desc light = rt_light_desc_default();
    rt_instance_desc inst = rt_instance_desc_default();
    rt_world_desc world = rt_world_desc_default();
    rt_instance gone;
    td.width = 3;
    td.height = 2;
    td.pixels = pixels;
    td.format = RT_PIXEL_RGBA8;
    assert_int_equal(rt_scene_add_texture(scene, &td, &md.color_texture), RT_OK);
    md.alpha_texture = md.color_texture;
    assert_int_equal(rt_scene_add_material(scene, &md, NULL), RT_OK);
    mesh.positions = positions;
    mesh.vertex_count = 4;
    mesh.indices = indices;
    mesh.triangle_count = 2;
    mesh.normals = normals;
    mesh.uvs = uvs;
    mesh.colors = colors;
    mesh.face_materials = faces;
    assert_int_equal(rt_scene_add_mesh(scene, &mesh, NULL), RT_OK);
    poly.positions = positions;
    poly.vertex_count = 4;
    poly.face_sizes = sizes;
    poly.face_count = 1;
    poly.indices = corners;
    poly.index_count = 4;
    assert_int_equal(rt_scene_add_polyhedron(child, &poly, NULL), RT_OK);
    kit_sphere(scene, 3, 0, 0, 1);
    box.low.x = -5;
    box.high.x = -4;
    assert_int_equal(rt_scene_add_box(scene, &box, NULL), RT_OK);
    torus.center.y = 4;
    assert_int_equal(rt_scene_add_torus(scene, &torus, NULL), RT_OK);
    cone.from.y = -4;
    assert_int_equal(rt_scene_add_cone(scene, &cone, NULL), RT_OK);
    cone.to.x = 2;
    assert_int_equal(rt_scene_add_cylinder(scene, &cone, NULL), RT_OK);
    plane.point.y = -9;
    assert_int_equal(rt_scene_add_plane(scene, &plane, NULL), RT_OK);
    light.type = RT_LIGHT_SPHERE;
    light.at = (rt_vec3){0, 8, 3};
    light.visible = 1;
    assert_int_equal(rt_scene_add_light(scene, &light, NULL), RT_OK);
    light = rt_light_desc_default();
    light.at = (rt_vec3){3, 0, 0.5f};
    assert_int_equal(rt_scene_add_light(scene, &light, NULL), RT_OK);
    world.ambient = (rt_vec3){0.1f, 0.2f, 0.3f};
    assert_int_equal(rt_scene_set_world(scene, &world), RT_OK);
    kit_sphere(child, 0, 0, 2, 0.5f);
    assert_int_equal(rt_scene_commit(child, NULL), RT_OK);
    inst.child = child;
    inst.transform = rt_transform_rotate((rt_vec3){1, 1, 0}, 30);
    inst.transform.m[3] = 9;
    assert_int_equal(rt_scene_add_instance(scene, &inst, NULL), RT_OK);
    assert_int_equal(rt_scene_add_instance(scene, &inst, &gone), RT_OK);
    inst.transform.m[3] = -9;
    inst.material.id = 0;
    assert_int_equal(rt_scene_add_instance(scene, &inst, NULL), RT_OK);
    assert_int_equal(rt_scene_remove_instance(scene, gone), RT_OK);
    *child_out = child;
    return scene;
}

static rt_scene *committed(rt_context *ctx, const char *accel)
{
    rt_commit_desc d = rt_commit_desc_default();
    rt_scene *child, *scene = rich_scene(ctx, &child);
    d.accel = accel;
    assert_int_equal(rt_scene_commit(scene, &d), RT_OK);
    rt_scene_destroy(child);
    return scene;
}

static uint32_t next_random(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

static rt_ray random_ray(uint32_t *state)
{
    float f[6];
    for (int i = 0; i < 6; i++)
        f[i] = (float)next_random(state) / 8388608.0f - 1.0f;
    rt_vec3 to = {12 * f[3], 9 * f[4], 3 * f[5]}, from = {20 * f[0], 20 * f[1], 20 * f[2]};
    return kit_ray(from.x, from.y, from.z, to.x - from.x, to.y - from.y, to.z - from.z);
}

#define RAYS 3000

static void compare(const rt_scene *a, const rt_scene *b)
{
    uint32_t state = 7, hits = 0;
    char ha[33], hb[33];
    rt_camera_desc ca, cb;
    assert_int_equal(rt_scene_hash(a, ha), RT_OK);
    assert_int_equal(rt_scene_hash(b, hb), RT_OK);
    assert_string_equal(ha, hb);
    for (int i = 0; i < RAYS; i++) {
        rt_ray ray = random_ray(&state);
        rt_hit x = kit_hit(a, ray), y = kit_hit(b, ray);
        rt_surface s, t;
        assert_memory_equal(&x, &y, sizeof x);
        rt_scene_surface(a, &ray, &x, &s);
        rt_scene_surface(b, &ray, &y, &t);
        assert_memory_equal(&s, &t, sizeof s);
        hits += x.prim_id != RT_INVALID_ID;
    }
    assert_true(hits > RAYS / 3);
    assert_int_equal(rt_scene_get_camera(a, &ca), RT_OK);
    assert_int_equal(rt_scene_get_camera(b, &cb), RT_OK);
    assert_memory_equal(&ca.eye, &cb.eye, sizeof ca.eye);
}

static void test_round(void **state)
{
    static const char *const accels[] = {"kdtree", "octree", "bvh", "brute", "kdtree,octree,bvh"};
    rt_context *ctx = kit_context(NULL, 1);
    (void)state;
    for (size_t i = 0; i < 5; i++) {
        rt_scene *scene = committed(ctx, accels[i]), *loaded;
        rt_scene_info a, b;
        assert_int_equal(rt_scene_save(scene, path), RT_OK);
        kit_ok(ctx, rt_scene_load(ctx, path, &loaded));
        compare(scene, loaded);
        assert_int_equal(rt_scene_get_info(scene, &a), RT_OK);
        assert_int_equal(rt_scene_get_info(loaded, &b), RT_OK);
        assert_int_equal(a.tree_count, b.tree_count);
        assert_int_equal(a.triangles, b.triangles);
        assert_int_equal(b.built_trees, 0);
        rt_scene_destroy(scene);
        rt_scene_destroy(loaded);
    }
    rt_context_destroy(ctx);
}

static void *slurp(const char *name, size_t *size)
{
    FILE *f = fopen(name, "rb");
    void *data;
    assert_non_null(f);
    fseek(f, 0, SEEK_END);
    *size = (size_t)ftell(f);
    rewind(f);
    data = aligned_alloc(64, (*size + 63) / 64 * 64);
    assert_int_equal(fread(data, 1, *size, f), *size);
    fclose(f);
    return data;
}

/* The same scene in two contexts gives the same bytes. */
static void test_same_file(void **state)
{
    void *data[2];
    size_t size[2];
    (void)state;
    for (int i = 0; i < 2; i++) {
        rt_context *ctx = kit_context(NULL, (uint32_t)(1 + i));
        rt_scene *scene = committed(ctx, "kdtree,octree,bvh");
        assert_int_equal(rt_scene_save(scene, path), RT_OK);
        data[i] = slurp(path, &size[i]);
        rt_scene_destroy(scene);
        rt_context_destroy(ctx);
    }
    assert_int_equal(size[0], size[1]);
    assert_memory_equal(data[0], data[1], size[0]);
    free(data[0]);
    free(data[1]);
}

static void test_loaded_is_closed(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = committed(ctx, "auto"), *loaded, *parent = kit_scene(ctx);
    rt_sphere_desc sphere = rt_sphere_desc_default();
    rt_instance_desc inst = rt_instance_desc_default();
    rt_camera_desc camera = rt_camera_desc_default();
    (void)state;
    assert_int_equal(rt_scene_save(scene, path), RT_OK);
    kit_ok(ctx, rt_scene_load(ctx, path, &loaded));
    assert_int_equal(rt_scene_add_sphere(loaded, &sphere, NULL), RT_ERROR_STATE);
    kit_says(ctx, "rt_scene_add_sphere: this scene was loaded");
    assert_int_equal(rt_scene_set_camera(loaded, &camera), RT_ERROR_STATE);
    assert_int_equal(rt_scene_commit(loaded, NULL), RT_ERROR_STATE);
    assert_int_equal(rt_scene_set_tracer(loaded, "brute"), RT_ERROR_STATE);
    inst.child = loaded;
    assert_int_equal(rt_scene_add_instance(parent, &inst, NULL), RT_OK);
    assert_int_equal(rt_scene_get_instance(loaded, (rt_instance){0}, &inst), RT_ERROR_STATE);
    kit_says(ctx, "rt_scene_get_instance: this scene was loaded");
    assert_int_equal(rt_scene_commit(parent, NULL), RT_ERROR_STATE); /* it has instances */
    kit_says(ctx, "instances of its own");
    rt_scene_destroy(parent);
    rt_scene_destroy(scene);
    rt_scene_destroy(loaded);

    scene = kit_scene(ctx);
    kit_sphere(scene, 0, 0, 0, 1);
    assert_int_equal(rt_scene_commit(scene, NULL), RT_OK);
    assert_int_equal(rt_scene_save(scene, path), RT_OK);
    kit_ok(ctx, rt_scene_load(ctx, path, &loaded));
    parent = kit_scene(ctx);
    inst.child = loaded;
    inst.transform = rt_transform_translate((rt_vec3){5, 0, 0});
    assert_int_equal(rt_scene_add_instance(parent, &inst, NULL), RT_OK);
    assert_int_equal(rt_scene_frame_camera(parent, 1), RT_OK);
    assert_int_equal(rt_scene_commit(parent, NULL), RT_OK);
    assert_int_equal(kit_hit(parent, kit_ray(5, 0, 9, 0, 0, -1)).inst_id, 0);
    rt_scene_destroy(parent);
    rt_scene_destroy(scene);
    rt_scene_destroy(loaded);
    rt_context_destroy(ctx);
}

static void test_refusals(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx), *loaded = scene;
    FILE *f;
    (void)state;
    assert_int_equal(rt_scene_save(scene, path), RT_ERROR_STATE);
    kit_says(ctx, "never committed");
    assert_int_equal(rt_scene_save(scene, NULL), RT_ERROR_ARGUMENT);
    assert_int_equal(rt_scene_commit(scene, NULL), RT_OK);
    assert_int_equal(rt_scene_save(scene, "/no/such/folder/x.snap"), RT_ERROR_IO);
    assert_int_equal(rt_scene_load(ctx, "/no/such/file.snap", &loaded), RT_ERROR_IO);
    assert_null(loaded);
    assert_int_equal(rt_scene_load(ctx, "/tmp", &loaded), RT_ERROR_IO);
    f = fopen(path, "wb");
    fputs("ply\n", f);
    fclose(f);
    assert_int_equal(rt_scene_load(ctx, path, &loaded), RT_ERROR_FORMAT);
    kit_says(ctx, "no snapshot file");
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

/* Uses whatever a decoder let through, as a renderer would. */
static void use_snapshot(const rti_snapshot *s)
{
    _Alignas(64) rtk_trace_block rays;
    _Alignas(64) rtk_hit_block hits;
    rti_scratch scratch = {.steps = NULL};
    uint32_t state = 99;
    for (uint32_t i = 0; i < RTK_BLOCK; i++) {
        rt_ray r = random_ray(&state);
        rays.ox[i] = r.org.x;
        rays.oy[i] = r.org.y;
        rays.oz[i] = r.org.z;
        rays.dx[i] = r.dir.x;
        rays.dy[i] = r.dir.y;
        rays.dz[i] = r.dir.z;
        rays.tmin[i] = r.tmin;
        rays.tmax[i] = r.tmax;
        rays.mask[i] = r.mask;
    }
    s->tracer->intersect(rti_snapshot_view(s), &rays, &hits, RTK_BLOCK, 0, &scratch);
}

/* Every byte of a file changed, and the file cut everywhere: with hashes always refused; without them refused or safe to use. */
static void test_corruption(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = committed(ctx, "kdtree,octree,bvh");
    uint8_t *data;
    size_t size, let_through = 0;
    rti_snapshot *s;
    (void)state;
    assert_int_equal(rt_scene_save(scene, path), RT_OK);
    data = slurp(path, &size);
    for (size_t i = 0; i < size; i++) {
        uint8_t was = data[i];
        data[i] ^= (uint8_t)(1u << (i % 8));
        s = NULL;
        /* only padding between chunks is not covered by a hash */
        if (rti_blob_decode(ctx, "x", data, size, true, &s) == RT_OK)
            assert_int_equal(was, 0);
        rti_snapshot_release(s);
        s = NULL;
        if (rti_blob_decode(ctx, "x", data, size, false, &s) == RT_OK) {
            use_snapshot(s);
            let_through++;
        }
        rti_snapshot_release(s);
        data[i] = was;
    }
    assert_true(let_through > 0 && let_through < size);
    for (size_t n = 0; n < size; n += 1 + n / 64) {
        s = NULL;
        assert_int_not_equal(rti_blob_decode(ctx, "x", data, n, false, &s), RT_OK);
    }
    free(data);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

/* Two meshes of which the first claims a triangle of the second: each triangle is still of its mesh, and no number is out of
 * range. */
static void test_overlap(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx);
    rti_snapshot *s = NULL;
    uint8_t *data;
    size_t size, found = 0;
    (void)state;
    kit_square(scene, 1, 0);
    kit_square(scene, 1, 1);
    kit_commit(scene);
    assert_int_equal(rt_scene_save(scene, path), RT_OK);
    data = slurp(path, &size);
    kit_ok(ctx, rti_blob_decode(ctx, "x", data, size, false, &s));
    rti_snapshot_release(s);
    for (size_t i = 0; i + 2 * sizeof(rtk_geom) <= size; i += 8) {
        rtk_geom geom[2];
        memcpy(geom, data + i, sizeof geom);
        if (geom[0].type == RTK_GEOM_MESH && geom[0].prim_count == 2 && geom[0].first == 0 && geom[0].mask == RT_MASK_ALL &&
            geom[1].type == RTK_GEOM_MESH && geom[1].prim_count == 2 && geom[1].first == 2 && geom[1].mask == RT_MASK_ALL) {
            geom[0].prim_count = 3;
            memcpy(data + i, geom, sizeof geom);
            found++;
        }
    }
    assert_int_equal(found, 1);
    assert_int_equal(rti_blob_decode(ctx, "x", data, size, false, &s), RT_ERROR_FORMAT);
    kit_says(ctx, "side by side");
    free(data);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

/* A sphere's geometry that claims the box, too: renders tell what hits are of one geometry by one of them. */
static void test_two_types(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx);
    rt_box_desc box = rt_box_desc_default();
    rti_snapshot *s = NULL;
    uint8_t *data;
    size_t size;
    (void)state;
    kit_sphere(scene, 0, 0, 0, 1);
    box.low = (rt_vec3){2, 2, 2};
    box.high = (rt_vec3){3, 3, 3};
    kit_ok(ctx, rt_scene_add_box(scene, &box, NULL));
    kit_commit(scene);
    assert_int_equal(rt_scene_save(scene, path), RT_OK);
    data = slurp(path, &size);
    const rti_blob_header *header = (const rti_blob_header *)(const void *)data;
    const rti_blob_entry *entry = (const rti_blob_entry *)(const void *)(header + 1);
    for (uint32_t i = 0; i < header->chunk_count; i++) {
        uint8_t *chunk = data + entry[i].offset;
        if (entry[i].kind == RTK_CHUNK_GROUP) {
            const rtk_group_header *group = (const rtk_group_header *)(const void *)chunk;
            rtk_shape *shape = (rtk_shape *)(void *)(chunk + group->off_shapes);
            assert_int_equal(group->shape_count, 2);
            shape[1].geom = 0;
            shape[1].prim = 1;
        } else if (entry[i].kind == RTK_CHUNK_GEOMETRY) {
            const rtk_geometry_header *records = (const rtk_geometry_header *)(const void *)chunk;
            rtk_geom *geom = (rtk_geom *)(void *)(chunk + records->off_geoms);
            geom[0].prim_count = 2;
            geom[1].prim_count = 0;
            geom[1].first = 2;
        }
    }
    assert_int_equal(rti_blob_decode(ctx, "x", data, size, false, &s), RT_ERROR_FORMAT);
    kit_says(ctx, "a shape is not of its geometry");
    free(data);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

/* Each allocation of a load made to fail in turn. */
static void test_no_memory(void **state)
{
    kit_memory memory = {0};
    rt_context *ctx = kit_context(&memory, 1);
    rt_scene *scene = committed(ctx, "auto"), *loaded = NULL;
    long n = 0;
    rt_status status;
    (void)state;
    assert_int_equal(rt_scene_save(scene, path), RT_OK);
    rt_scene_destroy(scene);
    do {
        atomic_store(&memory.requests, 0);
        atomic_store(&memory.fail_at, ++n);
        status = rt_scene_load(ctx, path, &loaded);
        atomic_store(&memory.fail_at, 0);
        if (status != RT_OK) {
            assert_int_equal(status, RT_ERROR_MEMORY);
            assert_null(loaded);
        }
    } while (status != RT_OK);
    assert_true(n > 10);
    rt_scene_destroy(loaded);
    rt_context_destroy(ctx);
    assert_int_equal(atomic_load(&memory.blocks), 0);
    assert_int_equal(atomic_load(&memory.bytes), 0);
}

/* A mesh of vertices alone, spheres without a sphere, instances of a scene that holds nothing, and a removed instance. */
static rt_scene *hollow(rt_context *ctx, rt_scene *child, const char *accel)
{
    const float point[3] = {0, 0, 0}, normal[3] = {0, 0, 1};
    const uint32_t none[3] = {0, 0, 0};
    rt_scene *scene = kit_scene(ctx);
    rt_spheres_desc spheres = rt_spheres_desc_default();
    rt_mesh_desc mesh = rt_mesh_desc_default();
    rt_instance_desc inst = rt_instance_desc_default();
    rt_commit_desc how = rt_commit_desc_default();
    rt_geometry first = {RT_INVALID_ID};
    rt_instance gone;
    how.accel = accel;
    mesh.positions = point;
    mesh.normals = normal;
    mesh.vertex_count = 1;
    mesh.indices = none;
    inst.child = child;
    spheres.centers = point;
    assert_int_equal(rt_scene_commit(child, &how), RT_OK);
    spheres.colors = point;
    kit_ok(ctx, rt_scene_add_spheres(scene, &spheres, &first));
    assert_int_equal(first.id, 0);
    kit_ok(ctx, rt_scene_add_mesh(scene, &mesh, &first));
    assert_int_equal(first.id, 1);
    kit_ok(ctx, rt_scene_add_instance(scene, &inst, NULL));
    kit_ok(ctx, rt_scene_add_instance(scene, &inst, &gone));
    kit_ok(ctx, rt_scene_remove_instance(scene, gone));
    kit_ok(ctx, rt_scene_commit(scene, &how));
    return scene;
}

static void test_hollow(void **state)
{
    static const char *const accels[] = {"kdtree", "octree", "bvh", "brute"};
    rt_context *ctx = kit_context(NULL, 1);
    (void)state;
    for (size_t i = 0; i < 4; i++) {
        rt_scene *child = kit_scene(ctx), *scene = hollow(ctx, child, accels[i]), *loaded;
        for (int axis = 0; axis < 6; axis++) {
            float dir[3] = {0, 0, 0};
            dir[axis / 2] = axis % 2 ? 1.0f : -1.0f;
            assert_int_equal(kit_hit(scene, kit_ray(0, 0, 5, dir[0], dir[1], dir[2])).prim_id, RT_INVALID_ID);
        }
        assert_int_equal(rt_scene_save(scene, path), RT_OK);
        kit_ok(ctx, rt_scene_load(ctx, path, &loaded));
        assert_int_equal(kit_hit(loaded, kit_ray(0, 0, 5, 0, 0, -1)).prim_id, RT_INVALID_ID);
        rt_scene_destroy(loaded);
        rt_scene_destroy(scene);
        rt_scene_destroy(child);
    }
    rt_context_destroy(ctx);
}

/* What an add takes, a load takes. */
static void test_texture_sizes(void **state)
{
    const float far[6] = {1.0e9f, 0, 0, 0, 1.0e9f, 0};
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx), *loaded;
    rt_plane_desc plane = rt_plane_desc_default();
    (void)state;
    memcpy(plane.common.uv_transform, far, sizeof far);
    plane.texture_size = 1.0e-45f;
    assert_int_equal(rt_scene_add_plane(scene, &plane, NULL), RT_ERROR_ARGUMENT);
    kit_says(ctx, "texture_size");
    plane.texture_size = 1.0e-12f;
    plane.texture_height = 1.0e-40f;
    assert_int_equal(rt_scene_add_plane(scene, &plane, NULL), RT_ERROR_ARGUMENT);
    kit_says(ctx, "texture_height");
    plane.texture_height = 1.0e-12f;
    kit_ok(ctx, rt_scene_add_plane(scene, &plane, NULL));
    kit_ok(ctx, rt_scene_commit(scene, NULL));
    assert_int_equal(rt_scene_save(scene, path), RT_OK);
    kit_ok(ctx, rt_scene_load(ctx, path, &loaded));
    rt_scene_destroy(loaded);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round),        cmocka_unit_test(test_same_file),  cmocka_unit_test(test_loaded_is_closed),
        cmocka_unit_test(test_refusals),     cmocka_unit_test(test_corruption), cmocka_unit_test(test_overlap),
        cmocka_unit_test(test_two_types),    cmocka_unit_test(test_no_memory),  cmocka_unit_test(test_hollow),
        cmocka_unit_test(test_texture_sizes)};
    return cmocka_run_group_tests(tests, setup, teardown);
}
