#include <stdlib.h>
#include <string.h>

#include "mesh.h"

uint32_t test_u32(test_rng *r)
{
    r->state = r->state * 6364136223846793005u + 1442695040888963407u;
    uint64_t x = r->state ^ (r->state >> 29);
    return (uint32_t)((x * 0x9e3779b97f4a7c15u) >> 32);
}

float test_unit(test_rng *r)
{
    return (float)(test_u32(r) >> 8) * 0x1p-24f;
}

float test_range(test_rng *r, float lo, float hi)
{
    return lo + (hi - lo) * test_unit(r);
}

void test_mesh_add(test_mesh *m, const float a[3], const float b[3], const float c[3])
{
    if (m->count == m->capacity) {
        m->capacity = m->capacity ? 2 * m->capacity : 256;
        m->tris = realloc(m->tris, m->capacity * sizeof *m->tris);
        if (!m->tris)
            abort();
    }
    rtk_tri *t = &m->tris[m->count];
    memset(t, 0, sizeof *t);
    memcpy(t->v0, a, sizeof t->v0);
    memcpy(t->v1, b, sizeof t->v1);
    memcpy(t->v2, c, sizeof t->v2);
    t->prim = m->count++;
}

void test_mesh_free(test_mesh *m)
{
    free(m->tris);
    memset(m, 0, sizeof *m);
}

/* The triangles of an OBJ file of `v x y z` and `f a/.. b/.. c/..` lines, as the shared ones are. */
static bool load_obj(test_mesh *m, FILE *f)
{
    char line[256];
    float(*v)[3] = NULL;
    unsigned count = 0, room = 0;
    bool ok = true;
    while (ok && fgets(line, sizeof line, f)) {
        unsigned k[3];
        if (count == room) {
            room = room ? 2 * room : 4096;
            v = realloc(v, room * sizeof *v);
        }
        if (sscanf(line, "v %f %f %f", &v[count][0], &v[count][1], &v[count][2]) == 3)
            count++;
        else if (sscanf(line, "f %u%*s %u%*s %u", &k[0], &k[1], &k[2]) == 3) {
            ok = k[0] - 1 < count && k[1] - 1 < count && k[2] - 1 < count;
            if (ok)
                test_mesh_add(m, v[k[0] - 1], v[k[1] - 1], v[k[2] - 1]);
        }
    }
    free(v);
    fclose(f);
    if (!ok)
        test_mesh_free(m);
    return ok && count > 0;
}

bool test_mesh_load(test_mesh *m, const char *name)
{
    const char *dir = getenv("LIBRT_SCENES");
    char path[4096], line[256];
    unsigned vertices = 0, faces = 0;
    memset(m, 0, sizeof *m);
    snprintf(path, sizeof path, "%s/textured/%s/%s.obj", dir ? dir : "../shared/scenes", name, name);
    FILE *f = strcmp(name, "spot") == 0 ? fopen(path, "rb") : NULL;
    if (f)
        return load_obj(m, f);
    snprintf(path, sizeof path, "%s/%s.ply", dir ? dir : "../shared/scenes", name);
    f = fopen(path, "rb");
    if (!f)
        return false;
    while (fgets(line, sizeof line, f) && strcmp(line, "end_header\n") != 0) {
        sscanf(line, "element vertex %u", &vertices);
        sscanf(line, "element face %u", &faces);
    }
    float(*v)[3] = malloc(vertices * sizeof *v);
    bool ok = v && fread(v, sizeof *v, vertices, f) == vertices;
    for (unsigned i = 0; i < faces && ok; i++) {
        unsigned char n;
        int32_t k[3];
        ok = fread(&n, 1, 1, f) == 1 && n == 3 && fread(k, sizeof k, 1, f) == 1;
        for (int j = 0; j < 3; j++)
            ok = ok && k[j] >= 0 && (unsigned)k[j] < vertices;
        if (ok)
            test_mesh_add(m, v[k[0]], v[k[1]], v[k[2]]);
    }
    free(v);
    fclose(f);
    if (!ok)
        test_mesh_free(m);
    return ok;
}

void test_mesh_place(test_mesh *m, float scale, float move)
{
    for (uint32_t i = 0; i < m->count; i++) {
        float *v[3] = {m->tris[i].v0, m->tris[i].v1, m->tris[i].v2};
        for (int j = 0; j < 9; j++)
            v[j / 3][j % 3] = v[j / 3][j % 3] * scale + move;
    }
}

static void extend(float lo[3], float hi[3], const float p[3])
{
    for (int a = 0; a < 3; a++) {
        lo[a] = rtk_min(lo[a], p[a]);
        hi[a] = rtk_max(hi[a], p[a]);
    }
}

rti_build_input test_input_boxes(const test_mesh *m, const float (*boxes)[6], uint32_t box_count)
{
    rti_build_input in = {.tris = m->tris, .tri_count = m->count, .boxes = boxes, .box_count = box_count};
    float scale = 1.0e-30f;
    for (int a = 0; a < 3; a++) {
        in.lo[a] = 3.0e38f;
        in.hi[a] = -3.0e38f;
    }
    for (uint32_t i = 0; i < m->count; i++) {
        extend(in.lo, in.hi, m->tris[i].v0);
        extend(in.lo, in.hi, m->tris[i].v1);
        extend(in.lo, in.hi, m->tris[i].v2);
    }
    for (uint32_t i = 0; i < box_count; i++) {
        extend(in.lo, in.hi, boxes[i]);
        extend(in.lo, in.hi, boxes[i] + 3);
    }
    if (!(in.lo[0] <= in.hi[0]))
        return in;
    for (int a = 0; a < 3; a++)
        scale = rtk_max(scale, rtk_max(rtk_fabs(in.lo[a]), rtk_fabs(in.hi[a])));
    in.grow = RTK_GROW * scale;
    for (int a = 0; a < 3; a++) {
        in.lo[a] -= in.grow;
        in.hi[a] += in.grow;
    }
    return in;
}

rti_build_input test_input(const test_mesh *m)
{
    return test_input_boxes(m, NULL, 0);
}
