/* rt_scene_import: files into a scene, textures and all, or not at all. */
#include "../support/fixture.h"

#include <locale.h>
#include <math.h>
#include <sys/stat.h>

#include "librt/import.h"
#include "scene/scene.h"

static rt_scene *scene;

static int setup(void **state)
{
    test_setup(state);
    assert_int_equal(rt_scene_create(test.ctx, &scene), RT_OK);
    return 0;
}

static int teardown(void **state)
{
    rt_scene_destroy(scene);
    return test_teardown(state);
}

static const char *text_file(const char *name, const char *text)
{
    return test_file(&test, name, text, strlen(text));
}

static const char two_looks[] =
    "mtllib my looks.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl red\nf 1/1 2/2 3/3\nusemtl blue\n"
    "f 1/1 3/3 2/2\n";
static const unsigned char dot_tga[] = {0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0, 24, 0, 10, 20, 30};

static void test_materials_and_textures(void **state)
{
    rt_import_result r;
    (void)state;
    test_file(&test, "a dot.tga", dot_tga, sizeof dot_tga);
    text_file("my looks.mtl", "newmtl red\nKd 1 0 0\nmap_Kd a dot.tga\nnewmtl blue\nKd 0 0 1\nmap_d missing.png\n");
    assert_int_equal(rt_scene_import(scene, text_file("two looks.obj", two_looks), NULL, &r), RT_OK);
    assert_int_equal(r.geometry_count, 2);
    assert_int_equal(r.first.id, 0);
    assert_int_equal(r.triangles, 2);
    assert_int_equal(r.vertices, 6);
    assert_int_equal(r.warnings, 1);
    assert_non_null(strstr(test.log, "missing.png"));
    assert_int_equal(scene->materials.count, 3);
    assert_int_equal(scene->textures.count, 1);
    const rtk_material *red = RTI_AT(scene->materials, rtk_material, 1);
    assert_true(red->color[0] == 1 && red->color[1] == 0);
    assert_int_equal(RTI_AT(scene->geometries, rti_geometry, 0)->material, 1);
    assert_int_equal(RTI_AT(scene->geometries, rti_geometry, 1)->material, 2);
    assert_int_equal(rt_scene_commit(scene, NULL), RT_OK);
}

static void test_missing_library(void **state)
{
    rt_import_desc d = rt_import_desc_default();
    rt_import_result r;
    (void)state;
    assert_int_equal(rt_scene_import(scene, text_file("m.obj", two_looks), &d, &r), RT_OK);
    assert_int_equal(r.geometry_count, 2);
    assert_true(r.warnings >= 2);
    assert_int_equal(scene->materials.count, 1);
    d.ignore_materials = 1;
    test.log[0] = '\0';
    assert_int_equal(rt_scene_import(scene, test.path, &d, &r), RT_OK);
    assert_int_equal(r.first.id, 2);
    assert_int_equal(r.warnings, 0);
    assert_string_equal(test.log, "");
}

static void test_transform(void **state)
{
    rt_import_desc d = rt_import_desc_default();
    rt_vec3 lo, hi;
    (void)state;
    d.transform = rt_transform_multiply(rt_transform_translate((rt_vec3){10, 0, 0}), rt_transform_scale((rt_vec3){2, 3, 1}));
    assert_int_equal(
        rt_scene_import(scene, text_file("n.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 1 1 0\nf 1//1 2//1 3//1\n"), &d, NULL), RT_OK);
    assert_int_equal(rt_scene_bounds(scene, &lo, &hi), RT_OK);
    assert_true(lo.x == 10 && hi.x == 12 && hi.y == 3);
    const float *n = RTI_AT(scene->geometries, rti_geometry, 0)->mesh->normals; /* towards (1/2, 1/3, 0) */
    assert_true(n[0] > 0 && fabsf(n[0] / n[1] - 1.5f) < 1e-6f && n[2] == 0);
    d.transform = rt_transform_scale((rt_vec3){1e30f, 1, 1});
    assert_int_equal(rt_scene_import(scene, test.path, &d, NULL), RT_ERROR_FORMAT);
    test_says(&test, "vertex 1: x is 1e+30 after the transform");
    d.transform.m[5] = NAN;
    assert_int_equal(rt_scene_import(scene, test.path, &d, NULL), RT_ERROR_ARGUMENT);
    test_says(&test, "transform.m[5] is nan");
    assert_int_equal(scene->geometries.count, 1);
}

/* Kinds by content, whatever the name. */
static void test_kinds(void **state)
{
    static const char ply[] =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
        "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    static const char stl[] =
        "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";
    rt_import_result r;
    (void)state;
    assert_int_equal(rt_scene_import(scene, text_file("wrong.obj", ply), NULL, &r), RT_OK);
    assert_int_equal(rt_scene_import(scene, text_file("noending", stl), NULL, &r), RT_OK);
    assert_int_equal(r.first.id, 1);
    assert_int_equal(rt_scene_import(scene, text_file("bad\xff name.OBJ", "v 0 0 0\nf 1 1 1\n"), NULL, &r), RT_OK);
    assert_int_equal(rt_scene_import(scene, text_file("a.txt", "hello"), NULL, &r), RT_ERROR_FORMAT);
    test_says(&test, "a.txt: not a mesh");
    assert_int_equal(rt_scene_import(scene, text_file("empty.ply", ""), NULL, &r), RT_ERROR_FORMAT);
    assert_int_equal(rt_scene_import(scene, text_file("empty.stl", ""), NULL, &r), RT_ERROR_FORMAT);
    assert_int_equal(rt_scene_import(scene, text_file("empty.obj", ""), NULL, &r), RT_ERROR_FORMAT);
    assert_int_equal(rt_scene_import(scene, test_path(&test, "none.ply"), NULL, &r), RT_ERROR_IO);
    assert_int_equal(mkdir(test_path(&test, "folder.ply"), 0777), 0);
    assert_int_equal(rt_scene_import(scene, test.path, NULL, &r), RT_ERROR_IO);
    assert_int_equal(rt_scene_import(scene, NULL, NULL, &r), RT_ERROR_ARGUMENT);
    assert_int_equal(rt_scene_import(scene, "a.ply", &(rt_import_desc){0}, &r), RT_ERROR_ARGUMENT);
}

static void test_german_locale(void **state)
{
    rt_vec3 lo, hi;
    (void)state;
    if (!setlocale(LC_ALL, "de_DE.UTF-8") && !setlocale(LC_ALL, "de_DE")) {
        print_message("no German locale here: left out\n");
        return;
    }
    rt_status status = rt_scene_import(scene, text_file("n.obj", "v 0.5 0 0\nv 1.25 0 0\nv 0 1.5e0 0\nf 1 2 3\n"), NULL, NULL);
    setlocale(LC_ALL, "C");
    assert_int_equal(status, RT_OK);
    assert_int_equal(rt_scene_bounds(scene, &lo, &hi), RT_OK);
    assert_true(hi.x == 1.25f && hi.y == 1.5f);
}

/* Whatever allocation fails, the scene is as it was. */
static void test_every_allocation_fails(void **state)
{
    rt_import_desc d = rt_import_desc_default();
    rt_import_result r;
    rt_status status;
    size_t n = 0;
    (void)state;
    test_file(&test, "a dot.tga", dot_tga, sizeof dot_tga);
    text_file("my looks.mtl", "newmtl red\nKd 1 0 0\nmap_Kd a dot.tga\nnewmtl blue\nKd 0 0 1\n");
    text_file("two.obj", two_looks);
    d.smooth = 1;
    d.transform = rt_transform_translate((rt_vec3){1, 2, 3});
    do {
        test.calls = 0;
        test.fail_at = ++n;
        status = rt_scene_import(scene, test.path, &d, &r);
        if (status) {
            assert_int_equal(status, RT_ERROR_MEMORY);
            assert_int_equal(scene->materials.count, 1);
            assert_int_equal(scene->textures.count, 0);
            assert_int_equal(scene->geometries.count, 0);
            assert_int_equal(scene->tri_count, 0);
        }
    } while (status);
    test.fail_at = 0;
    assert_true(n > 20);
    assert_int_equal(r.geometry_count, 2);
    assert_int_equal(r.warnings, 0);
    assert_int_equal(rt_scene_commit(scene, NULL), RT_OK);
}

static void test_real_scenes(void **state)
{
    static const struct {
        const char *name;
        uint32_t geometries, materials, textures;
        uint64_t triangles;
    } scenes[] = {
        {"textured/sponza/sponza.obj", 19, 19, 10, 66445}, {"textured/spot/spot.obj", 1, 1, 1, 5856}, {"cbox.ply", 1, 0, 0, 38}};
    (void)state;
    for (size_t i = 0; i < RTI_COUNT(scenes); i++) {
        rt_import_result r;
        if (!test_scene(&test, scenes[i].name)) {
            print_message("%s is not there: left out\n", test.path);
            continue;
        }
        size_t materials = scene->materials.count, textures = scene->textures.count;
        double start = rti_now();
        rt_status status = rt_scene_import(scene, test.path, NULL, &r);
#ifndef RTI_HAVE_STB
        if (scenes[i].textures)
            continue;
#endif
        print_message("%s: %.1f ms\n", scenes[i].name, 1e3 * (rti_now() - start));
        assert_int_equal(status, RT_OK);
        assert_int_equal(r.geometry_count, scenes[i].geometries);
        assert_int_equal(r.triangles, scenes[i].triangles);
        assert_int_equal(r.warnings, 0);
        assert_int_equal(scene->materials.count - materials, scenes[i].materials);
        assert_int_equal(scene->textures.count - textures, scenes[i].textures);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_materials_and_textures, setup, teardown),
        cmocka_unit_test_setup_teardown(test_missing_library, setup, teardown),
        cmocka_unit_test_setup_teardown(test_transform, setup, teardown),
        cmocka_unit_test_setup_teardown(test_kinds, setup, teardown),
        cmocka_unit_test_setup_teardown(test_german_locale, setup, teardown),
        cmocka_unit_test_setup_teardown(test_every_allocation_fails, setup, teardown),
        cmocka_unit_test_setup_teardown(test_real_scenes, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
