/* OBJ, MTL and STL files, read without a scene. */
#include "../support/fixture.h"

#include <stdlib.h>

#include "librt/scene.h"
#include "scene/import/looks.h"

static rt_status read_obj(rti_model *m, const char *text)
{
    rti_model_init(m, test.ctx, "mesh.obj");
    return rti_obj_read(m, text, strlen(text));
}

static rt_status read_stl(rti_model *m, const void *bytes, size_t size)
{
    rti_model_init(m, test.ctx, "mesh.stl");
    return rti_stl_read(m, bytes, size);
}

static void refuse_obj(const char *text, const char *words)
{
    rti_model m;
    assert_int_equal(read_obj(&m, text), RT_ERROR_FORMAT);
    test_says(&test, words);
    rti_model_fini(&m);
}

static void refuse_stl(const char *text, const char *words)
{
    rti_model m;
    assert_int_equal(read_stl(&m, text, strlen(text)), RT_ERROR_FORMAT);
    test_says(&test, words);
    rti_model_fini(&m);
}

#define SQUARE "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"

static void test_forms(void **state)
{
    static const char *const faces[] = {"f 1 2 3 4\n",
                                        "f 1/1 2/2 3/3 4/4\n",
                                        "f 1//1 2//1 3//1 4//1\n",
                                        "f 1/1/1 2/2/1 3/3/1 4/4/1\n",
                                        "f -4/-4 -3/-3 -2/-2 -1/-1\n",
                                        "f 1 2 \\\n3 \\\r\n4\n",
                                        "  f\t1 2 3 4 # a face\r\n"};
    (void)state;
    for (size_t i = 0; i < RTI_COUNT(faces); i++) {
        char text[400];
        rti_model m;
        snprintf(text, sizeof text, SQUARE "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1 0\nvn 0 0 2\n%s", faces[i]);
        assert_int_equal(read_obj(&m, text), RT_OK);
        assert_int_equal(m.part_count, 1);
        assert_int_equal(m.parts[0].vertex_count, 4);
        assert_int_equal(m.parts[0].triangle_count, 2);
        assert_int_equal(m.parts[0].uvs != NULL, i == 1 || i == 3 || i == 4);
        assert_int_equal(m.parts[0].normals != NULL, i == 2 || i == 3);
        assert_int_equal(m.warnings, 0);
        if (m.parts[0].uvs)
            assert_true(m.parts[0].uvs[4] == 1.0f && m.parts[0].uvs[5] == 1.0f);
        rti_model_fini(&m);
    }
}

/* One position with two texture corners is two vertices; a part a material in the order of use; names with spaces. */
static void test_parts(void **state)
{
    rti_model m;
    (void)state;
    assert_int_equal(read_obj(&m, "mtllib my file.mtl\n" SQUARE
                                  "vt 0 0\nvt 1 1\nusemtl never used\nusemtl red paint  \nf 1/1 2/1 3/1\nusemtl blue\n"
                                  "f 1/1 3/1 4/1\no thing\ng a b\ns off\nusemtl red paint\nf 1/2 2/1 3/1\nvp 0 0\n"),
                     RT_OK);
    assert_int_equal(m.part_count, 2);
    assert_int_equal(m.look_count, 3);
    assert_string_equal(m.looks[m.parts[0].look].name, "red paint");
    assert_string_equal(m.looks[m.parts[1].look].name, "blue");
    assert_int_equal(m.parts[0].triangle_count, 2);
    assert_int_equal(m.parts[0].vertex_count, 4);
    assert_int_equal(m.parts[1].vertex_count, 3);
    assert_int_equal(m.library_count, 1);
    assert_string_equal(m.libraries[0], "my file.mtl");
    assert_int_equal(m.warnings, 1);
    assert_non_null(strstr(test.log, "line 18: 'vp' is not read"));
    rti_model_fini(&m);
}

static void test_vertex_colours(void **state)
{
    rti_model m;
    (void)state;
    assert_int_equal(read_obj(&m, "v 0 0 0\nv 1 0 0 0.5 0.25 0\nv 0 1 0 1\nf 1 2 3\n"), RT_OK);
    static const float want[9] = {1, 1, 1, 0.5f, 0.25f, 0, 1, 1, 1};
    assert_non_null(m.parts[0].colors);
    assert_memory_equal(m.parts[0].colors, want, sizeof want);
    rti_model_fini(&m);
}

/* A face may name vertices that come later in the file. */
static void test_later_vertices(void **state)
{
    rti_model m;
    (void)state;
    assert_int_equal(read_obj(&m, "f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0"), RT_OK);
    assert_int_equal(m.parts[0].triangle_count, 1);
    rti_model_fini(&m);
}

static void test_obj_refused(void **state)
{
    (void)state;
    refuse_obj("", "no faces");
    refuse_obj(SQUARE, "no faces ('f' lines) in 4 lines");
    refuse_obj(SQUARE "f 1 2 0\n", "line 5: vertex index 0; OBJ files count from 1");
    refuse_obj(SQUARE "f 1 2 5\n", "face 1: vertex 5 does not exist; the file has 4");
    refuse_obj(SQUARE "f 1 2 -5\n", "line 5: vertex index '-5' points before the first; there are 4");
    refuse_obj(SQUARE "f 1/1 2/1 3/1\n", "texture vertex 1 does not exist; the file has 0");
    refuse_obj(SQUARE "f 1//1 2//1 3//1\n", "normal 1 does not exist");
    refuse_obj(SQUARE "f 1 2 x\n", "'x' is no vertex index");
    refuse_obj(SQUARE "f 1 2 3/1/1/1\n", "is no corner of a face");
    refuse_obj(SQUARE "f 1 2 99999999999999999999\n", "is no vertex index");
    refuse_obj(SQUARE "f 1 2 4294967296\n", "points before the first");
    refuse_obj("v 0 0\nf 1 1 1\n", "line 1: a vertex 'v x y z' needs more numbers");
    refuse_obj("v 0 0 a\nf 1 1 1\n", "'a' in a vertex");
    refuse_obj("v 0 0 nan\nf 1 1 1\n", "vertex 1: z is nan");
    refuse_obj("v 0 0 1e40\nf 1 1 1\n", "z is 1e+40");
    refuse_obj("v 0 0 0\nvn 0 0\nf 1 1 1\n", "line 2: a normal");
}

static void test_mtl(void **state)
{
    static const char mtl[] = "# all\nnewmtl red paint\nKd 1 0.5 0\nKs 0.2 0.2 0.2\nNs 30\nd 0.75\nTr 0.75\nNi 1.5\nillum 2\n"
                              "map_Kd -s 1 1 1 -o 0.5 -clamp on dir\\my texture.png\r\nmap_d mask.png\nmap_Bump b.png\n"
                              "newmtl blue\nKd 0.5\nillum 7\nTr 0.9\nNi 1.3\nKs 0.05\nnewmtl lamp\nKe 3 2 1\nnewmtl blue\nKd 1 1 "
                              "1\nnewmtl other\nKd x\n";
    rti_model m;
    (void)state;
    assert_int_equal(
        read_obj(&m, "v 0 0 0\nusemtl red paint\nf 1 1 1\nusemtl blue\nf 1 1 1\nusemtl lamp\nf 1 1 1\nusemtl none\nf 1 1 1\n"),
        RT_OK);
    assert_int_equal(rti_mtl_read(&m, "a.mtl", mtl, sizeof mtl - 1), RT_OK);
    assert_true(m.looks[0].defined && m.looks[1].defined && m.looks[2].defined && !m.looks[3].defined);
    assert_string_equal(m.looks[0].diffuse_map, "dir/my texture.png");
    assert_string_equal(m.looks[0].opacity_map, "mask.png");
    assert_int_equal(m.warnings, 1); /* blue is defined twice */
    rt_material_desc d = rti_look_material(&m.looks[0]);
    assert_true(d.color.x == 1 && d.color.y == 0.5f && d.color.z == 0);
    assert_true(d.transparency == 0.25f && d.diffusion == 0.75f && d.reflectiveness == 0 && d.refractiveness == 1);
    assert_true(d.shininess == 30 && d.specular > 0.19f && d.specular < 0.21f);
    d = rti_look_material(&m.looks[1]);
    assert_true(d.color.y == 0.5f && d.refractiveness > 1.29f && d.transparency > 0.89f && d.reflectiveness > 0.04f &&
                d.diffusion < 0.06f);
    d = rti_look_material(&m.looks[2]);
    assert_true(d.type == RT_MATERIAL_EMISSIVE && d.emission.x == 3);
    rti_model_fini(&m);
}

/* What is dissolved or mirrors is so much less lit from everywhere; a black body that is dissolved tints nothing black. */
static void test_mtl_dissolved(void **state)
{
    static const char mtl[] = "newmtl pane\nKd 0 0 0\nd 0.125\nillum 7\nnewmtl steel\nKd 1 1 1\nKs 0.75 0.75 0.75\nillum 3\n"
                              "newmtl wall\nKd 0 0 0\n";
    rti_model m;
    (void)state;
    assert_int_equal(read_obj(&m, "v 0 0 0\nusemtl pane\nf 1 1 1\nusemtl steel\nf 1 1 1\nusemtl wall\nf 1 1 1\n"), RT_OK);
    assert_int_equal(rti_mtl_read(&m, "a.mtl", mtl, sizeof mtl - 1), RT_OK);
    rt_material_desc d = rti_look_material(&m.looks[0]);
    assert_true(d.color.x == 1 && d.color.y == 1 && d.color.z == 1 && d.transparency == 0.875f);
    assert_true(d.diffusion == 0 && d.ambient == 0);
    d = rti_look_material(&m.looks[1]);
    assert_true(d.reflectiveness == 0.75f && d.diffusion == 0.25f && d.ambient == 0.25f);
    d = rti_look_material(&m.looks[2]);
    assert_true(d.color.x == 0 && d.diffusion == 1 && d.ambient == 1);
    rti_model_fini(&m);
}

static void refuse_mtl(const char *mtl, const char *words)
{
    rti_model m;
    assert_int_equal(read_obj(&m, "v 0 0 0\nusemtl a\nf 1 1 1\n"), RT_OK);
    assert_int_equal(rti_mtl_read(&m, "a.mtl", mtl, strlen(mtl)), RT_ERROR_FORMAT);
    test_says(&test, words);
    rti_model_fini(&m);
}

static void test_mtl_refused(void **state)
{
    (void)state;
    refuse_mtl("newmtl a\nKd 1 x 1\n", "a.mtl: line 2: 'Kd'");
    refuse_mtl("newmtl a\nNs\n", "'Ns' needs a number");
    refuse_mtl("newmtl a\nd nan\n", "'d' is nan");
}

static size_t binary_stl(unsigned char *out, const char *head, uint32_t count)
{
    static const float v[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    memset(out, ' ', 80);
    memcpy(out, head, strlen(head));
    for (int k = 0; k < 4; k++)
        out[80 + k] = (unsigned char)(count >> 8 * k);
    for (uint32_t i = 0; i < count; i++) {
        unsigned char *p = out + 84 + 50 * i;
        memset(p, 0, 50);
        memcpy(p + 12, v, sizeof v);
        memcpy(p + 20, &(float){(float)i}, sizeof(float)); /* z of the first */
    }
    return 84 + 50 * count;
}

static void test_stl(void **state)
{
    static const char text[] =
        "solid two words\nfacet normal 0 0 1\n outer loop\n vertex 0 0 0\n vertex 1 0 0\n vertex 0 1 0\n endloop\nendfacet\n"
        "FACET NORMAL nan 0 0\nOUTER LOOP\nVERTEX 1 0 -0\nVERTEX 1 1 0\nVERTEX 0 1 0\nENDLOOP\nENDFACET\nendsolid two words\n"
        "solid\nendsolid\n";
    unsigned char bytes[400];
    rti_model m;
    (void)state;
    assert_int_equal(read_stl(&m, text, sizeof text - 1), RT_OK);
    assert_int_equal(m.parts[0].triangle_count, 2);
    assert_int_equal(m.parts[0].vertex_count, 4); /* -0 and 0 are one place */
    rti_model_fini(&m);
    /* binary files may begin as text ones do */
    for (int trap = 0; trap < 2; trap++) {
        size_t size = binary_stl(bytes, trap ? "solid\nfacet normal" : "exported", 3);
        assert_int_equal(rti_mesh_format_of("a.bin", bytes, size), RTI_MESH_STL);
        assert_int_equal(read_stl(&m, bytes, size), RT_OK);
        assert_int_equal(m.parts[0].triangle_count, 3);
        assert_int_equal(m.parts[0].vertex_count, 5);
        rti_model_fini(&m);
        for (size_t n = 0; n < size; n++) {
            assert_int_equal(read_stl(&m, bytes, n), RT_ERROR_FORMAT);
            rti_model_fini(&m);
        }
        assert_int_equal(read_stl(&m, bytes, binary_stl(bytes, "x", 3) + 7), RT_OK);
        assert_int_equal(m.warnings, 1);
        rti_model_fini(&m);
    }
    for (size_t n = 0; n + 18 < sizeof text; n++) { /* to before the last letter of the first endsolid's word */
        const char *end = strstr(text, "endsolid two");
        if (text + n >= end + 8)
            break;
        assert_int_equal(read_stl(&m, text, n), RT_ERROR_FORMAT);
        rti_model_fini(&m);
    }
}

static void test_stl_refused(void **state)
{
    unsigned char bytes[400];
    rti_model m;
    (void)state;
    size_t size = binary_stl(bytes, "x", 1);
    memset(bytes + 96, 0xff, 4);
    assert_int_equal(read_stl(&m, bytes, size), RT_ERROR_FORMAT);
    test_says(&test, "byte 96: facet 0: a coordinate is not a finite number");
    rti_model_fini(&m);
    memset(bytes + 80, 0xff, 4);
    assert_int_equal(read_stl(&m, bytes, size), RT_ERROR_FORMAT);
    test_says(&test, "needs 214748364834 for its 4294967295 facets");
    rti_model_fini(&m);
    refuse_stl("solid a\nendsolid a\n", "no facets");
    refuse_stl("solid a\nfacet normal 0 0 1\nouter lop\n", "line 3: 'lop' stands where 'outer loop' should");
    refuse_stl("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 inf\n", "line 4: 'inf' stands where a finite number should");
    refuse_stl("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nvertex 1 1 "
               "0\nendloop\nendfacet\nendsolid\n",
               "'endloop'");
}

/* A cube of 8 vertices: at 60 degrees each face keeps its own normals, at 100 all share. */
static void test_smooth(void **state)
{
    static const char cube[] =
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nf 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\n"
        "f 3 4 8 7\nf 4 1 5 8\n";
    rti_model m;
    (void)state;
    for (int all = 0; all < 2; all++) {
        assert_int_equal(read_obj(&m, cube), RT_OK);
        rti_part *p = &m.parts[0];
        assert_true(rti_part_smooth(test.ctx, p, all ? 100 : 60));
        assert_int_equal(p->vertex_count, all ? 8 : 24);
        assert_int_equal(p->triangle_count, 12);
        for (uint32_t v = 0; v < p->vertex_count; v++) {
            const float *n = p->normals + 3 * v, *x = p->positions + 3 * v;
            float length = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
            assert_true(length > 0.999f && length < 1.001f);
            for (int k = 0; k < 3; k++) { /* by angle, the cut of the squares does not count */
                float want = x[k] > 0.5f ? 0.577350269f : -0.577350269f;
                assert_true(all ? n[k] - want < 1e-5f && want - n[k] < 1e-5f : n[k] == 0 || n[k] * want > 0.577f);
            }
        }
        rti_model_fini(&m);
    }
}

static void test_every_allocation_fails(void **state)
{
    static const char obj[] = SQUARE
        "v 0 0 1 1 0 0\nvt 0 0\nvn 0 0 1\nmtllib a b\nusemtl red\nf 1/1/1 2/1/1 3/1/1 4/1/1\nusemtl blue\nf 1 2 5\nf 1 3 4 2\n";
    static const char mtl[] = "newmtl red\nmap_Kd a b c\nnewmtl blue\nKd 1\n";
    unsigned char stl[400];
    size_t size = binary_stl(stl, "x", 3);
    (void)state;
    for (int kind = 0; kind < 2; kind++) {
        rt_status status;
        size_t n = 0;
        do {
            rti_model m;
            test.calls = 0;
            test.fail_at = ++n;
            status = kind ? read_stl(&m, stl, size) : read_obj(&m, obj);
            if (!status && !kind)
                status = rti_mtl_read(&m, "a.mtl", mtl, sizeof mtl - 1);
            for (size_t i = 0; i < m.part_count && !status; i++)
                status = rti_part_smooth(test.ctx, &m.parts[i], 60) ? RT_OK : RT_ERROR_MEMORY;
            rti_model_fini(&m);
            assert_true(status == RT_OK || status == RT_ERROR_MEMORY);
        } while (status);
        assert_true(n > 5);
        test.fail_at = 0;
    }
}

static void test_real_scenes(void **state)
{
    static const struct {
        const char *name;
        uint32_t parts, triangles;
    } scenes[] = {{"textured/sponza/sponza.obj", 19, 66445}, {"textured/spot/spot.obj", 1, 5856}};
    (void)state;
    for (size_t i = 0; i < RTI_COUNT(scenes); i++) {
        rti_model m;
        size_t size;
        uint64_t triangles = 0;
        if (!test_scene(&test, scenes[i].name)) {
            print_message("%s is not there: left out\n", test.path);
            continue;
        }
        unsigned char *bytes = test_slurp(test.path, &size);
        rti_model_init(&m, test.ctx, test.path);
        assert_int_equal(rti_obj_read(&m, bytes, size), RT_OK);
        assert_int_equal(rti_looks_read(&m, test.path), RT_OK);
        assert_int_equal(m.part_count, scenes[i].parts);
        assert_int_equal(m.warnings, 0);
        for (size_t k = 0; k < m.part_count; k++)
            triangles += m.parts[k].triangle_count;
        assert_int_equal(triangles, scenes[i].triangles);
        rti_model_fini(&m);
        free(bytes);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_forms, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_parts, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_vertex_colours, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_later_vertices, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_obj_refused, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_mtl, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_mtl_dissolved, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_mtl_refused, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_stl, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_stl_refused, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_smooth, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_every_allocation_fails, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_real_scenes, test_setup, test_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
