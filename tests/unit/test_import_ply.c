/* PLY files: both codings and byte orders, odd ones that are right, wrong ones that are refused with their place. */
#include "../support/fixture.h"

#include <math.h>
#include <stdlib.h>

#include "scene/import/model.h"

static rt_status read_bytes(rti_model *m, const void *bytes, size_t size)
{
    rti_model_init(m, test.ctx, "mesh.ply");
    return rti_ply_read(m, bytes, size);
}

static rt_status read_text(rti_model *m, const char *text)
{
    return read_bytes(m, text, strlen(text));
}

static void refuse(const char *text, const char *words)
{
    rti_model m;
    assert_int_equal(read_text(&m, text), RT_ERROR_FORMAT);
    test_says(&test, words);
    rti_model_fini(&m);
}

#define HEAD "ply\nformat ascii 1.0\n"
#define XYZ  "property float x\nproperty float y\nproperty float z\n"
#define LIST "property list uchar int vertex_indices\n"
static const char triangle[] = HEAD "element vertex 3\n" XYZ "element face 1\n" LIST "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

static void test_triangle(void **state)
{
    rti_model m;
    (void)state;
    assert_int_equal(read_text(&m, triangle), RT_OK);
    assert_int_equal(m.part_count, 1);
    assert_int_equal(m.parts[0].vertex_count, 3);
    assert_int_equal(m.parts[0].triangle_count, 1);
    assert_true(m.parts[0].positions[3] == 1.0f && m.parts[0].positions[7] == 1.0f);
    assert_null(m.parts[0].normals);
    assert_null(m.parts[0].colors);
    assert_int_equal(m.warnings, 0);
    rti_model_fini(&m);
}

/* Every property that is known, in an unusual order and types, unknown ones and elements between, faces before vertices, CRLF. */
static void test_everything(void **state)
{
    static const char text[] =
        "ply\r\nformat ascii 1.0\r\ncomment made by hand\r\nobj_info x\r\nelement face 2\r\nproperty int flags\r\n"
        "property list uint8 uint vertex_index\r\nproperty list int float texcoord\r\nelement camera 1\r\n"
        "property double view\r\nelement vertex 4\r\nproperty uchar red\r\nproperty uchar green\r\nproperty uchar blue\r\n"
        "property uchar alpha\r\nproperty double z\r\nproperty short y\r\nproperty float x\r\n"
        "property float nx\r\nproperty float ny\r\nproperty float nz\r\nproperty float s\r\nproperty float t\r\nend_header\r\n"
        "7 3 0 1 2 0\r\n8 4 0 1 2 3 6 1 2 3 4 5 6\r\n1e3\r\n"
        "255 0 188 255 0.5 -2 1.25 0 0 1 0.25 0.75\r\n0 0 0 0 0 0 1 0 0 1 0 0\r\n0 0 0 0 0 1 1 0 0 1 0 0\r\n"
        "0 0 0 0 0 1 0 nan 0 1 1 1";
    rti_model m;
    (void)state;
    assert_int_equal(read_text(&m, text), RT_OK);
    const rti_part *p = &m.parts[0];
    assert_int_equal(p->vertex_count, 4);
    assert_int_equal(p->triangle_count, 3);
    assert_true(p->positions[0] == 1.25f && p->positions[1] == -2.0f && p->positions[2] == 0.5f);
    assert_true(p->colors[0] == 1.0f && p->colors[1] == 0.0f && p->colors[2] > 0.502f && p->colors[2] < 0.503f); /* sRGB 188 */
    assert_true(p->uvs[0] == 0.25f && p->uvs[1] == 0.75f && p->normals[2] == 1.0f);
    assert_true(p->normals[9] == 0.0f && p->normals[11] == 0.0f); /* not finite: the face's normal is used */
    assert_int_equal(m.warnings, 1);
    assert_non_null(strstr(test.log, "1 normals or texture coordinates are not finite"));
    rti_model_fini(&m);
}

static void put(unsigned char **to, const void *value, size_t size, bool big)
{
    for (size_t i = 0; i < size; i++)
        *(*to)++ = ((const unsigned char *)value)[big ? size - 1 - i : i];
}

/* Two triangles and a pentagon in the given byte order (this machine's is little-endian, as all we know are). */
static size_t binary(unsigned char *out, bool big)
{
    static const float v[6][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {-0.5f, 0.5f, 0}, {0, 0, 1}};
    static const uint16_t faces[3][6] = {{3, 0, 1, 5}, {3, 1, 2, 5}, {5, 0, 1, 2, 3, 4}};
    unsigned char *to = out;
    to += sprintf((char *)to,
                  "ply\nformat binary_%s_endian 1.0\nelement vertex 6\nproperty double w\n" XYZ
                  "element face 3\nproperty list ushort "
                  "ushort vertex_indices\nproperty uchar extra\nend_header\n",
                  big ? "big" : "little");
    for (int i = 0; i < 6; i++) {
        double w = 1e300;
        put(&to, &w, 8, big);
        for (int k = 0; k < 3; k++)
            put(&to, &v[i][k], 4, big);
    }
    for (int f = 0; f < 3; f++) {
        for (int k = 0; k <= faces[f][0]; k++)
            put(&to, &faces[f][k], 2, big);
        *to++ = 9;
    }
    return (size_t)(to - out);
}

static void test_byte_orders(void **state)
{
    unsigned char bytes[2][2048];
    rti_model m[2];
    (void)state;
    for (int big = 0; big < 2; big++)
        assert_int_equal(read_bytes(&m[big], bytes[big], binary(bytes[big], big)), RT_OK);
    assert_int_equal(m[0].parts[0].triangle_count, 5);
    assert_int_equal(m[1].parts[0].triangle_count, 5);
    assert_memory_equal(m[0].parts[0].positions, m[1].parts[0].positions, 18 * sizeof(float));
    assert_memory_equal(m[0].parts[0].indices, m[1].parts[0].indices, 15 * sizeof(uint32_t));
    rti_model_fini(&m[0]);
    rti_model_fini(&m[1]);
}

/* Whatever is missing at the end, the file is refused (or is whole without it: a last newline) and nothing leaks. */
static void test_cut_everywhere(void **state)
{
    unsigned char bytes[2048];
    rti_model m;
    (void)state;
    size_t size = binary(bytes, true);
    for (size_t n = 0; n < size; n++) {
        assert_int_equal(read_bytes(&m, bytes, n), RT_ERROR_FORMAT);
        rti_model_fini(&m);
    }
    for (size_t n = 0; n + 2 < sizeof triangle; n++) {
        assert_int_equal(read_bytes(&m, triangle, n), RT_ERROR_FORMAT);
        rti_model_fini(&m);
    }
    assert_int_equal(read_bytes(&m, triangle, sizeof triangle - 2), RT_OK);
    rti_model_fini(&m);
}

static void test_refused(void **state)
{
    (void)state;
    refuse(HEAD "element vertex 99999999999\n" XYZ "end_header\n0 0 0\n", "promises 99999999999 elements");
    refuse(HEAD "element vertex 3\n" XYZ "element face 1\n" LIST "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
           "line 13: face 0: corner 3");
    refuse(HEAD "element vertex 3\n" XYZ "element face 1\n" LIST "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", "count from 0");
    refuse(HEAD "element vertex 3\n" XYZ "element face 1\n" LIST "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 1.5\n", "corner 1.5");
    refuse(HEAD "element vertex 3\n" XYZ "element face 1\n" LIST "end_header\n0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n",
           "vertex 1: y is nan");
    refuse(HEAD "element vertex 3\n" XYZ "element face 1\n" LIST "end_header\n0 0 0\n1 1e99 0\n0 1 0\n3 0 1 2\n", "y is 1e+99");
    refuse(HEAD "element vertex 3\n" XYZ "element face 1\n" LIST "end_header\n0 0 0\n1 0x 0\n0 1 0\n3 0 1 2\n",
           "line 11: '0x' is not a number");
    refuse(HEAD "element vertex 3\n" XYZ "element face 1\n" LIST "end_header\n0 0 0\n1 0 0\n0 1 0\n-3 0 1 2\n",
           "a list cannot have -3");
    refuse(HEAD "element vertex 3\n" XYZ "end_header\n0 0 0\n1 0 0\n0 1 0\n", "3 vertices but no faces");
    refuse(HEAD "element face 1\n" LIST "end_header\n3 0 1 2\n", "no element 'vertex'");
    refuse(HEAD "element vertex 1\nproperty float x\nend_header\n0\n", "no x, y and z");
    refuse(HEAD "element vertex 1\nproperty flaot x\nend_header\n0\n", "'flaot' is no type");
    refuse(HEAD "element vertex\nproperty float x\nend_header\n0\n", "needs a name and a count");
    refuse(HEAD "element vertex 1\nelement vertex 1\nend_header\n0\n", "declared twice");
    refuse(HEAD "propery float x\nend_header\n", "unknown word 'propery'");
    refuse("ply\nformat binary 1.0\nend_header\n", "format 'binary' is not known");
    refuse("ply\nformat ascii 2.0\nend_header\n", "version '2.0'");
    refuse("ply\nend_header\n", "no 'format'");
    refuse("ply\nformat ascii 1.0\nelement vertex 0\n", "'end_header' is missing");
    refuse("", "end_header");
    refuse("plx\n", "begins with a line 'ply'");
}

static void test_strips_and_flat_faces(void **state)
{
    rti_model m;
    (void)state;
    assert_int_equal(read_text(&m, HEAD "element vertex 4\n" XYZ
                                        "element tristrips 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n"
                                        "1 0 0\n0 1 0\n1 1 0\n8 0 1 2 3 -1 3 2 0\n"),
                     RT_OK);
    static const uint32_t want[9] = {0, 1, 2, 2, 1, 3, 3, 2, 0};
    assert_int_equal(m.parts[0].triangle_count, 3);
    assert_memory_equal(m.parts[0].indices, want, sizeof want);
    rti_model_fini(&m);
    assert_int_equal(read_text(&m, HEAD "element vertex 3\n" XYZ "element face 3\n" LIST
                                        "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n2 0 1\n0\n"),
                     RT_OK);
    assert_int_equal(m.parts[0].triangle_count, 1);
    assert_int_equal(m.warnings, 1);
    rti_model_fini(&m);
}

/* An arrow's head: a fan from its first corner would cover what is outside. */
static void test_concave_polygon(void **state)
{
    rti_model m;
    double area = 0;
    (void)state;
    assert_int_equal(read_text(&m, HEAD "element vertex 4\n" XYZ "element face 1\n" LIST
                                        "end_header\n0 2 0\n-1 0 0\n0 1 0\n1 0 0\n4 1 2 3 0\n"),
                     RT_OK);
    const rti_part *p = &m.parts[0];
    assert_int_equal(p->triangle_count, 2);
    for (int i = 0; i < 2; i++) {
        const float *a = p->positions + 3 * p->indices[3 * i], *b = p->positions + 3 * p->indices[3 * i + 1];
        const float *c = p->positions + 3 * p->indices[3 * i + 2];
        double twice = (double)(b[0] - a[0]) * (c[1] - a[1]) - (double)(b[1] - a[1]) * (c[0] - a[0]);
        assert_true(twice > 0);
        area += twice / 2;
    }
    assert_true(area == 1.0);
    rti_model_fini(&m);
}

/* The largest polygon allowed is cut, one corner more is not; neither takes long. */
static void test_large_polygon(void **state)
{
    static char text[2000000];
    rti_model m;
    (void)state;
    for (int n = 65535; n <= 65536; n++) {
        size_t at = (size_t)sprintf(text,
                                    HEAD "element vertex 4\n" XYZ
                                         "element face 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n"
                                         "1 1 0\n0 1 0\n%d",
                                    n);
        for (int i = 0; i < n; i++)
            at += (size_t)sprintf(text + at, " %d", i * 4 / n);
        if (n > 65535) {
            refuse(text, "65536 corners; at most 65535");
        } else {
            assert_int_equal(read_text(&m, text), RT_OK);
            assert_int_equal(m.parts[0].triangle_count, 65533);
            rti_model_fini(&m);
        }
    }
}

static double twice_area(const float *p, uint32_t a, uint32_t b, uint32_t c)
{
    return ((double)p[3 * b] - p[3 * a]) * ((double)p[3 * c + 1] - p[3 * a + 1]) -
           ((double)p[3 * b + 1] - p[3 * a + 1]) * ((double)p[3 * c] - p[3 * a]);
}

/* Stars, a wound band, teeth on one line, and corners strewn at random: the first three are covered exactly, the last ends in
 * good time. */
static void test_large_concave_polygons(void **state)
{
    enum { N = 20001 };
    float *p = malloc(3 * N * sizeof *p);
    uint32_t *corners = malloc(N * sizeof *corners);
    (void)state;
    for (int kind = 0; kind < 4; kind++) {
        rti_part part = {.positions = p};
        double whole = 0, sum = 0;
        uint32_t random = 1;
        for (uint32_t i = 0; i < N; i++) {
            uint32_t half = N / 2, j = i < half ? i : N - 1 - i;
            double angle = kind == 0 ? 6.283185307 * i / N : j * 0.01,
                   radius = kind == 0 ? (i % 2 ? 1 : 0.5) : 1 + angle * 0.1 + (i < half ? 0 : 0.3);
            random = random * 1664525u + 1013904223u;
            corners[i] = i;
            p[3 * i] = kind < 2    ? (float)(radius * cos(angle))
                       : kind == 2 ? (float)(i == N - 1 ? half : i)
                                   : (float)(random >> 8);
            random = random * 1664525u + 1013904223u;
            p[3 * i + 1] = kind < 2    ? (float)(radius * sin(angle))
                           : kind == 2 ? (float)(i == N - 1 ? N : i % 2)
                                       : (float)(random >> 8);
            p[3 * i + 2] = 0;
        }
        assert_true(rti_part_polygon(test.ctx, &part, corners, N));
        assert_int_equal(part.triangle_count, N - 2);
        for (uint32_t i = 0; i < N; i++)
            whole += twice_area(p, 0, i, (i + 1) % N);
        for (uint32_t i = 0; i < N - 2; i++) {
            double area = twice_area(p, part.indices[3 * i], part.indices[3 * i + 1], part.indices[3 * i + 2]);
            assert_true(kind == 3 || area * whole >= 0);
            sum += area;
        }
        assert_true(kind == 3 || fabs(sum - whole) <= 1e-6 * fabs(whole));
        part.positions = NULL;
        rti_part_fini(test.ctx, &part);
    }
    free(p);
    free(corners);
}

static void test_every_allocation_fails(void **state)
{
    unsigned char bytes[2048];
    rti_model m;
    size_t n = 0, size = binary(bytes, false);
    rt_status status;
    (void)state;
    do {
        test.calls = 0;
        test.fail_at = ++n;
        status = read_bytes(&m, bytes, size);
        rti_model_fini(&m);
        assert_true(status == RT_OK || status == RT_ERROR_MEMORY);
    } while (status);
    test.fail_at = 0;
    assert_true(n > 4);
}

static void test_real_scenes(void **state)
{
    static const struct {
        const char *name;
        uint32_t triangles, vertices;
    } scenes[] = {{"cbox.ply", 38, 32},
                  {"teapot.ply", 6320, 3241},
                  {"sponza.ply", 66445, 34781},
                  {"bunny.ply", 69451, 34834},
                  {"sibenik.ply", 80479, 40835},
                  {"classroom.ply", 103832, 54128},
                  {"greyroom.ply", 143163, 74575},
                  {"staircase.ply", 262663, 135221},
                  {"breakfast.ply", 269538, 135752}};
    (void)state;
    for (size_t i = 0; i < RTI_COUNT(scenes); i++) {
        rti_model m;
        size_t size;
        if (!test_scene(&test, scenes[i].name)) {
            print_message("%s is not there: left out\n", test.path);
            continue;
        }
        unsigned char *bytes = test_slurp(test.path, &size);
        assert_int_equal(read_bytes(&m, bytes, size), RT_OK);
        assert_int_equal(m.parts[0].triangle_count, scenes[i].triangles);
        assert_int_equal(m.parts[0].vertex_count, scenes[i].vertices);
        assert_int_equal(m.warnings, 0);
        rti_model_fini(&m);
        free(bytes);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_triangle, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_everything, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_byte_orders, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_cut_everywhere, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_refused, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_strips_and_flat_faces, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_concave_polygon, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_large_polygon, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_large_concave_polygons, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_every_allocation_fails, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_real_scenes, test_setup, test_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
