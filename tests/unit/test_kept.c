/* What a context keeps: files by their bytes, trees by what they stand over; what makes it read and build again; its bounds. */
#include "scene_kit.h"

#include <fcntl.h>
#include <pthread.h>
#include <stdio.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "librt/import.h"

/* A strip of n triangles at height z; the same length for any z in 0 ... 9. */
static void write_ply(const char *path, int n, int z)
{
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    fprintf(f, "ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\nproperty float y\nproperty float z\n", n + 2);
    fprintf(f, "element face %d\nproperty list uchar int vertex_indices\nend_header\n", n);
    for (int i = 0; i < n + 2; i++)
        fprintf(f, "%d %d %d\n", i / 2, i % 2, z);
    for (int i = 0; i < n; i++)
        fprintf(f, "3 %d %d %d\n", i, i + 1, i + 2);
    fclose(f);
}

static void write_text(const char *path, const char *text)
{
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    fputs(text, f);
    fclose(f);
}

static rt_scene *import(rt_context *ctx, const char *path, const rt_import_desc *d)
{
    rt_scene *scene = kit_scene(ctx);
    kit_ok(ctx, rt_scene_import(scene, path, d, NULL));
    return scene;
}

/* Imports once more in a scene of its own; where the first triangle lies. */
static float height(rt_context *ctx, const char *path)
{
    rt_scene *scene = import(ctx, path, NULL);
    rt_hit hit;
    kit_commit(scene);
    hit = kit_hit(scene, kit_ray(0.3f, 0.3f, 100, 0, 0, -1));
    rt_scene_destroy(scene);
    return 100 - hit.t;
}

static void files_are(const rt_context *ctx, uint64_t read, uint64_t kept)
{
    rt_context_work_stats w = rt_context_work(ctx);
    if (w.files_read != read || w.files_kept != kept)
        fail_msg("%d files read and %d kept, not %d and %d", (int)w.files_read, (int)w.files_kept, (int)read, (int)kept);
}

static void test_meshes(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_import_desc d = rt_import_desc_default();
    rt_scene *a, *b;
    char first[33], second[33];
    (void)state;
    write_ply("kept_a.ply", 50, 1);
    a = import(ctx, "kept_a.ply", NULL);
    kit_commit(a);
    rt_scene_hash(a, first);
    files_are(ctx, 1, 0);
    b = import(ctx, "kept_a.ply", NULL);
    kit_commit(b);
    rt_scene_hash(b, second);
    files_are(ctx, 1, 1);
    assert_string_equal(first, second);
    assert_int_equal(kit_info(b).built_trees, 0);
    assert_int_equal(kit_info(b).kept_trees, 1);
    rt_scene_destroy(a); /* shared arrays live on */
    assert_true(kit_hit(b, kit_ray(0.3f, 0.3f, 5, 0, 0, -1)).t == 4);
    kit_ok(ctx, rt_scene_remove_geometry(b, (rt_geometry){0}));
    rt_scene_destroy(b);
    assert_true(height(ctx, "kept_a.ply") == 1);
    files_are(ctx, 1, 2);
    /* Another name is no other file; other settings make another mesh of it, once. */
    write_ply("kept_b.ply", 50, 1);
    assert_true(height(ctx, "kept_b.ply") == 1);
    files_are(ctx, 1, 3);
    for (int i = 0; i < 2; i++) {
        d.transform = rt_transform_translate((rt_vec3){0, 0, 2});
        a = import(ctx, "kept_a.ply", &d);
        kit_commit(a);
        assert_true(kit_hit(a, kit_ray(0.3f, 0.3f, 5, 0, 0, -1)).t == 2);
        rt_scene_destroy(a);
    }
    files_are(ctx, 2, 4);
    d = rt_import_desc_default();
    d.smooth = 1;
    rt_scene_destroy(import(ctx, "kept_a.ply", &d));
    d.smooth_angle_deg = 10;
    rt_scene_destroy(import(ctx, "kept_a.ply", &d));
    files_are(ctx, 4, 4);
    rt_context_drop_kept(ctx);
    assert_true(height(ctx, "kept_a.ply") == 1);
    files_are(ctx, 5, 4);
    assert_true(rt_context_work(ctx).read_seconds > 0 && rt_context_work(ctx).saved_seconds > 0);
    unlink("kept_a.ply");
    a = kit_scene(ctx);
    assert_int_equal(rt_scene_import(a, "kept_a.ply", NULL, NULL), RT_ERROR_IO); /* gone is gone */
    rt_scene_destroy(a);
    unlink("kept_b.ply");
    rt_context_destroy(ctx);
}

/* Other bytes of the same length, with the time of change put back, are noticed: at once, and when the file has long settled. */
static void test_changed(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    struct timespec old[2] = {{1000000000, 0}, {1000000000, 0}}, nap = {2, 200000000};
    (void)state;
    for (int settled = 0; settled < 2; settled++) {
        for (int z = 1; z < 5; z++) {
            write_ply("kept_c.ply", 20, z);
            assert_int_equal(utimensat(AT_FDCWD, "kept_c.ply", old, 0), 0);
            if (settled && z == 1) {
                nanosleep(&nap, NULL);
                assert_true(height(ctx, "kept_c.ply") == 1);
                assert_true(height(ctx, "kept_c.ply") == 1);
            }
            assert_true(height(ctx, "kept_c.ply") == (float)z);
        }
    }
    /* Replaced by renaming, as editors do. */
    write_ply("kept_d.ply", 20, 7);
    utimensat(AT_FDCWD, "kept_d.ply", old, 0);
    rename("kept_d.ply", "kept_c.ply");
    assert_true(height(ctx, "kept_c.ply") == 7);
    unlink("kept_c.ply");
    rt_context_destroy(ctx);
}

/* An OBJ's library and images are looked at anew, each by itself. */
static void test_materials(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene;
    char hash[3][33];
    (void)state;
    write_text("kept.obj", "mtllib kept.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl red\nf 1/1 2/2 3/3\n");
    for (int i = 0; i < 3; i++) {
        write_text("kept.mtl", i == 0 ? "newmtl red\nKd 1 0 0\n" : "newmtl red\nKd 0 1 0\n");
        scene = import(ctx, "kept.obj", NULL);
        kit_commit(scene);
        rt_scene_hash(scene, hash[i]);
        assert_int_equal(kit_info(scene).materials, 2);
        rt_scene_destroy(scene);
    }
    files_are(ctx, 1, 2);
    assert_string_not_equal(hash[0], hash[1]);
    assert_string_equal(hash[1], hash[2]);
    unlink("kept.obj");
    unlink("kept.mtl");
    rt_context_destroy(ctx);
}

/* A TGA of 2 x 1 grey pixels. */
static void write_tga(const char *path, int left, int right)
{
    unsigned char t[20] = {0, 0, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 1, 0, 8, 0x20, (unsigned char)left, (unsigned char)right};
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(t, 1, sizeof t, f), sizeof t);
    fclose(f);
}

static void texture_hash(rt_context *ctx, int nearest, char hash[33])
{
    rt_scene *scene = kit_scene(ctx);
    rt_texture_desc d = rt_texture_desc_default();
    rt_material_desc m = rt_material_desc_default();
    d.nearest = nearest;
    kit_ok(ctx, rt_scene_load_texture(scene, "kept.tga", &d, &m.color_texture));
    kit_ok(ctx, rt_scene_add_material(scene, &m, NULL));
    kit_commit(scene);
    rt_scene_hash(scene, hash);
    rt_scene_destroy(scene);
}

static void test_textures(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    char a[33], b[33];
    (void)state;
    write_tga("kept.tga", 10, 200);
    texture_hash(ctx, 0, a);
    texture_hash(ctx, 0, b);
    assert_string_equal(a, b);
    files_are(ctx, 1, 1);
    texture_hash(ctx, 1, b);
    assert_string_not_equal(a, b);
    files_are(ctx, 2, 1);
    write_tga("kept.tga", 11, 200);
    texture_hash(ctx, 0, b);
    assert_string_not_equal(a, b);
    files_are(ctx, 3, 1);
    unlink("kept.tga");
    rt_context_destroy(ctx);
}

/* ---- trees ---- */

static rt_scene *placed(rt_context *ctx, float x, float ior, rt_vec3 eye)
{
    rt_scene *child = import(ctx, "kept_t.ply", NULL), *scene = kit_scene(ctx);
    rt_instance_desc place = rt_instance_desc_default();
    rt_material_desc m = rt_material_desc_default();
    rt_camera_desc camera = rt_camera_desc_default();
    kit_commit(child);
    place.child = child;
    m.refractiveness = ior;
    kit_ok(ctx, rt_scene_add_material(scene, &m, &place.material));
    kit_ok(ctx, rt_scene_add_instance(scene, &place, NULL));
    place.transform = rt_transform_translate((rt_vec3){x, 0, 0});
    kit_ok(ctx, rt_scene_add_instance(scene, &place, NULL));
    kit_sphere(scene, 0, 0, 20, 1);
    camera.eye = eye;
    kit_ok(ctx, rt_scene_set_camera(scene, &camera));
    kit_commit(scene);
    rt_scene_destroy(child);
    return scene;
}

/* What the scene described anew with these built: trees of geometry, and of the top level. */
static void builds(rt_context *ctx, float x, float ior, rt_vec3 eye, uint64_t trees, uint64_t tops)
{
    rt_context_work_stats before = rt_context_work(ctx), now;
    rt_scene_destroy(placed(ctx, x, ior, eye));
    now = rt_context_work(ctx);
    assert_int_equal(now.trees_built - before.trees_built, trees);
    assert_int_equal(now.top_trees_built - before.top_trees_built, tops);
    assert_int_equal(now.trees_kept - before.trees_kept + trees + tops, 3);
}

static void test_frames(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_camera_desc camera = rt_camera_desc_default();
    rt_scene *scene;
    (void)state;
    write_ply("kept_t.ply", 30, 0);
    builds(ctx, 40, 1.5f, (rt_vec3){0, 0, 30}, 2, 1);
    builds(ctx, 40, 1.5f, (rt_vec3){9, 0, 30}, 0, 0); /* the camera moves */
    builds(ctx, 40, 1.7f, (rt_vec3){0, 0, 30}, 0, 0); /* a material changes */
    builds(ctx, 41, 1.5f, (rt_vec3){0, 0, 30}, 0, 1); /* an instance moves */
    builds(ctx, 40, 1.5f, (rt_vec3){0, 0, 30}, 0, 0); /* and comes back */
    files_are(ctx, 1, 4);
    /* The same within one scene. */
    scene = placed(ctx, 40, 1.5f, (rt_vec3){0, 0, 30});
    camera.eye = (rt_vec3){1, 2, 30};
    kit_ok(ctx, rt_scene_set_camera(scene, &camera));
    kit_commit(scene);
    assert_int_equal(kit_info(scene).built_trees, 0);
    assert_int_equal(kit_info(scene).kept_trees, 2);
    rt_scene_destroy(scene);
    unlink("kept_t.ply");
    rt_context_destroy(ctx);
}

/* ---- bounds ---- */

static void test_limit(void **state)
{
    enum { N = 6000, LIMIT = 4 << 20 }; /* a strip: 216 KiB; a quarter of the limit holds four */
    rt_context_desc d = rt_context_desc_default();
    rt_context *ctx = NULL;
    char path[32];
    uint64_t now;
    (void)state;
    d.workers = 1;
    d.memory_limit = LIMIT;
    assert_int_equal(rt_context_create(&d, &ctx), RT_OK);
    for (int i = 0; i < 8; i++) {
        snprintf(path, sizeof path, "kept_%d.ply", i);
        write_ply(path, N, i);
        rt_scene_destroy(import(ctx, path, NULL));
    }
    files_are(ctx, 8, 0);
    rt_context_memory(ctx, &now, NULL);
    assert_true(now > 600 * 1024 && now < LIMIT / 4 + (64 << 10)); /* and the store itself */
    rt_scene_destroy(import(ctx, "kept_7.ply", NULL));
    rt_scene_destroy(import(ctx, "kept_6.ply", NULL));
    files_are(ctx, 8, 2);
    rt_scene_destroy(import(ctx, "kept_0.ply", NULL)); /* went long ago */
    files_are(ctx, 9, 2);
    rt_scene_destroy(import(ctx, "kept_7.ply", NULL)); /* used since: still there */
    files_are(ctx, 9, 3);
    /* What is only kept stands in nobody's way. */
    rt_texture_desc t = rt_texture_desc_default();
    rt_scene *scene = kit_scene(ctx);
    uint8_t *pixels = calloc(800 * 790, 4);
    t.width = 800;
    t.height = 790;
    t.pixels = pixels;
    t.format = RT_PIXEL_RGBA8;
    kit_ok(ctx, rt_scene_add_texture(scene, &t, NULL));
    rt_scene_destroy(scene);
    rt_scene_destroy(import(ctx, "kept_7.ply", NULL));
    files_are(ctx, 10, 3);
    free(pixels);
    for (int i = 0; i < 8; i++) {
        snprintf(path, sizeof path, "kept_%d.ply", i);
        unlink(path);
    }
    rt_context_destroy(ctx);
}

/* Each allocation refused in turn while a held file is taken over. */
static void test_no_memory(void **state)
{
    int refused = 0;
    (void)state;
    write_text("kept.obj", "mtllib kept.mtl other.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\nusemtl blue\nf 3 2 1\n");
    for (long at = 1; at < 300; at++) {
        kit_memory memory = {0};
        rt_context *ctx = kit_context(&memory, 1);
        rt_scene *scene = import(ctx, "kept.obj", NULL), *again = kit_scene(ctx);
        rt_status status;
        atomic_store(&memory.fail_at, atomic_load(&memory.requests) + at);
        status = rt_scene_import(again, "kept.obj", NULL, NULL);
        atomic_store(&memory.fail_at, 0);
        assert_true(status == RT_OK || status == RT_ERROR_MEMORY);
        rt_scene_destroy(scene);
        rt_scene_destroy(again);
        rt_context_destroy(ctx);
        assert_int_equal(atomic_load(&memory.blocks), 0);
        if (status == RT_OK)
            break;
        refused++;
    }
    assert_true(refused > 3 && refused < 290);
    unlink("kept.obj");
}

/* ---- threads ---- */

static void *import_often(void *data)
{
    rt_context *ctx = data;
    for (int i = 0; i < 40; i++) {
        rt_scene *scene = kit_scene(ctx);
        rt_hit hit;
        int z = i % 4;
        char path[32];
        snprintf(path, sizeof path, "kept_%d.ply", z);
        if (rt_scene_import(scene, path, NULL, NULL) != RT_OK || rt_scene_commit(scene, NULL) != RT_OK)
            return data;
        hit = kit_hit(scene, kit_ray(0.3f, 0.3f, 20, 0, 0, -1));
        rt_scene_destroy(scene);
        if (hit.t != (float)(20 - z))
            return data;
        if (i % 8 == 7)
            rt_context_drop_kept(ctx);
    }
    return NULL;
}

static void test_threads(void **state)
{
    enum { THREADS = 4 };
    rt_context *ctx = kit_context(NULL, 1);
    pthread_t threads[THREADS];
    rt_context_work_stats w;
    (void)state;
    for (int z = 0; z < 4; z++) {
        char path[32];
        snprintf(path, sizeof path, "kept_%d.ply", z);
        write_ply(path, 40, z);
    }
    for (int i = 0; i < THREADS; i++)
        assert_int_equal(pthread_create(&threads[i], NULL, import_often, ctx), 0);
    for (int i = 0; i < THREADS; i++) {
        void *wrong;
        pthread_join(threads[i], &wrong);
        assert_null(wrong);
    }
    w = rt_context_work(ctx);
    assert_int_equal(w.files_read + w.files_kept, THREADS * 40);
    assert_true(w.files_kept > 0);
    for (int z = 0; z < 4; z++) {
        char path[32];
        snprintf(path, sizeof path, "kept_%d.ply", z);
        unlink(path);
    }
    rt_context_destroy(ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_meshes),    cmocka_unit_test(test_changed),
                                       cmocka_unit_test(test_materials), cmocka_unit_test(test_textures),
                                       cmocka_unit_test(test_frames),    cmocka_unit_test(test_limit),
                                       cmocka_unit_test(test_no_memory), cmocka_unit_test(test_threads)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
