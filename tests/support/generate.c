#include "generate.h"

#include <math.h>
#include <string.h>

static void random_vertex(test_rng *r, const float at[3], float size, float out[3])
{
    for (int a = 0; a < 3; a++)
        out[a] = at[a] + test_range(r, -size, size);
}

void test_mesh_soup(test_mesh *m, uint32_t count, float size, uint64_t seed)
{
    test_rng r = {seed};
    for (uint32_t i = 0; i < count; i++) {
        float at[3], v[3][3];
        random_vertex(&r, (const float[3]){0, 0, 0}, 1.0f, at);
        for (int k = 0; k < 3; k++)
            random_vertex(&r, at, size, v[k]);
        test_mesh_add(m, v[0], v[1], v[2]);
    }
}

void test_mesh_globe(test_mesh *m, uint32_t n)
{
    for (uint32_t k = 0; k < n * n; k++) {
        float v[4][3];
        for (uint32_t q = 0; q < 4; q++) {
            float up = 3.14159265f * (float)(k / n + (q >> 1)) / (float)n,
                  round = 6.2831853f * (float)(k % n + (q & 1u)) / (float)n;
            float r = 0.9f + 0.06f * sinf(9.0f * up) * cosf(7.0f * round) + 0.02f * sinf(61.0f * up) * sinf(83.0f * round);
            v[q][0] = r * sinf(up) * cosf(round);
            v[q][1] = r * cosf(up);
            v[q][2] = r * sinf(up) * sinf(round);
        }
        test_mesh_add(m, v[0], v[1], v[3]);
        test_mesh_add(m, v[0], v[3], v[2]);
    }
}

void test_mesh_slivers(test_mesh *m, uint32_t count)
{
    test_rng r = {77};
    for (uint32_t i = 0; i < count; i++) {
        float a[3], b[3], c[3], thin = powf(10.0f, test_range(&r, -8.0f, -2.0f));
        random_vertex(&r, (const float[3]){0, 0, 0}, 1.0f, a);
        random_vertex(&r, (const float[3]){0, 0, 0}, 1.0f, b);
        for (int k = 0; k < 3; k++)
            c[k] = 0.5f * (a[k] + b[k]) + test_range(&r, -thin, thin);
        test_mesh_add(m, a, b, i % 10 == 0 ? a : c);
    }
}

void test_mesh_lattice(test_mesh *m, int n)
{
    for (int axis = 0; axis < 3; axis++)
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++)
                for (int k = 0; k < (j % 3 == 0 ? 2 : 1); k++) {
                    float p[4][3];
                    int b = (axis + 1) % 3, c = (axis + 2) % 3;
                    for (int q = 0; q < 4; q++) {
                        p[q][axis] = 0.1f * (float)((i * 7 + j * 3) % n);
                        p[q][b] = 0.1f * (float)(i + (q & 1));
                        p[q][c] = 0.1f * (float)(j + (q >> 1));
                    }
                    test_mesh_add(m, p[0], p[1], p[3]);
                    test_mesh_add(m, p[0], p[3], p[2]);
                }
}

void test_mesh_nested(test_mesh *m, int n)
{
    float s = 1.0f;
    for (int i = 0; i < n; i++, s *= 0.9f)
        for (int axis = 0; axis < 3; axis++)
            for (int side = -1; side <= 1; side += 2) {
                float p[4][3];
                for (int q = 0; q < 4; q++) {
                    p[q][axis] = s * (float)side;
                    p[q][(axis + 1) % 3] = q & 1 ? s : -s;
                    p[q][(axis + 2) % 3] = q & 2 ? s : -s;
                }
                test_mesh_add(m, p[0], p[1], p[3]);
                test_mesh_add(m, p[0], p[3], p[2]);
            }
}

uint32_t test_shapes_of_all_kinds(rtk_shape *out, uint32_t count, uint64_t seed)
{
    test_rng r = {seed};
    memset(out, 0, count * sizeof *out);
    for (uint32_t i = 0; i < count; i++) {
        float a[3], b[3], s = test_range(&r, 0.05f, 0.3f);
        random_vertex(&r, (const float[3]){0, 0, 0}, 1.0f, a);
        random_vertex(&r, a, s * 2.0f, b);
        out[i].type = i % RTK_SHAPE_PLANE;
        memcpy(out[i].p, a, sizeof a);
        out[i].p[3] = s;
        memcpy(out[i].p + 4, b, sizeof b);
        if (out[i].type == RTK_SHAPE_BOX)
            for (int k = 0; k < 3; k++) {
                out[i].p[k] = fminf(a[k], b[k]);
                out[i].p[k + 3] = fmaxf(a[k], b[k]);
            }
        if (out[i].type == RTK_SHAPE_CONE)
            out[i].p[7] = i % 2 ? 0.0f : 0.5f * s;
        if (out[i].type == RTK_SHAPE_TORUS) {
            rtk_vec3 n = rtk_unit(rtk_v3(b[0] - a[0], b[1] - a[1], b[2] - a[2]));
            out[i].p[4] = n.x;
            out[i].p[5] = n.y;
            out[i].p[6] = n.z;
            out[i].p[7] = 0.3f * s;
        }
    }
    return count;
}

void test_random_map(test_rng *r, float spread, float scale, float m[12])
{
    rtk_vec3 x = rtk_unit(rtk_v3(test_range(r, -1, 1), test_range(r, -1, 1), test_range(r, -1, 1)));
    rtk_vec3 y = rtk_unit(rtk_cross3(x, rtk_v3(test_range(r, -1, 1), test_range(r, -1, 1), test_range(r, -1, 1))));
    rtk_vec3 z = rtk_cross3(x, y);
    float s[3];
    for (int k = 0; k < 3; k++)
        s[k] = scale * powf(10.0f, test_range(r, -0.7f, 0.7f));
    float rows[12] = {x.x * s[0], y.x * s[1], z.x * s[2], test_range(r, -spread, spread),
                      x.y * s[0], y.y * s[1], z.y * s[2], test_range(r, -spread, spread),
                      x.z * s[0], y.z * s[1], z.z * s[2], test_range(r, -spread, spread)};
    memcpy(m, rows, sizeof rows);
}
