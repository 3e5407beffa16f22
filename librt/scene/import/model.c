#include "model.h"

#include <math.h>
#include <string.h>

#include "../polygon.h"

#define WARNINGS_LOGGED 50

void rti_model_init(rti_model *model, rt_context *ctx, const char *path)
{
    memset(model, 0, sizeof *model);
    model->ctx = ctx;
    rti_quote(model->name, sizeof model->name, path, strlen(path));
    rti_arena_init(&model->arena, ctx, 0);
}

void rti_model_fini(rti_model *model)
{
    rt_context *ctx = model->ctx;
    for (size_t i = 0; i < model->part_count; i++)
        rti_part_fini(ctx, &model->parts[i]);
    rti_free(ctx, model->parts, model->part_capacity * sizeof *model->parts);
    rti_free(ctx, model->looks, model->look_capacity * sizeof *model->looks);
    rti_free(ctx, model->libraries, model->library_capacity * sizeof *model->libraries);
    rti_arena_fini(&model->arena);
}

void rti_model_warn(rti_model *model, const char *format, ...)
{
    char text[600];
    va_list args;
    model->warnings++;
    if (model->warnings > WARNINGS_LOGGED)
        return;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    rti_log(model->ctx, RT_LOG_WARNING, "%s: %s", model->name, text);
    if (model->warnings == WARNINGS_LOGGED)
        rti_log(model->ctx, RT_LOG_WARNING, "%s: further warnings are counted, not shown", model->name);
}

rti_part *rti_model_add_part(rti_model *model, uint32_t look)
{
    if (!rti_reserve(model->ctx, (void **)&model->parts, &model->part_capacity, model->part_count, 1, sizeof *model->parts))
        return NULL;
    rti_part *part = &model->parts[model->part_count++];
    memset(part, 0, sizeof *part);
    part->look = look;
    return part;
}

void rti_part_fini(rt_context *ctx, rti_part *part)
{
    size_t vertex = part->vertex_capacity * sizeof(float);
    rti_free(ctx, part->positions, 3 * vertex);
    rti_free(ctx, part->normals, 3 * vertex);
    rti_free(ctx, part->uvs, 2 * vertex);
    rti_free(ctx, part->colors, 3 * vertex);
    rti_free(ctx, part->indices, part->index_capacity * sizeof *part->indices);
    memset(part, 0, sizeof *part);
}

/* One array of vertices moved to its new size. */
static bool resize(rt_context *ctx, float **array, size_t width, size_t old_count, size_t new_count)
{
    size_t item = width * sizeof(float), size;
    if (!rti_mul_size(new_count, item, &size))
        return false;
    float *moved = rti_realloc(ctx, *array, *array ? old_count * item : 0, size);
    if (!moved)
        return false;
    *array = moved;
    return true;
}

bool rti_part_reserve(rt_context *ctx, rti_part *part, size_t vertices, bool normals, bool uvs, bool colors)
{
    rti_part grown = {0};
    size_t old = part->vertex_capacity, capacity = old ? old : vertices;
    while (capacity < vertices)
        capacity = capacity > SIZE_MAX / 2 ? vertices : 2 * capacity;
    if (old && capacity == old)
        return true;
    if (capacity == 0)
        capacity = 1;
    grown.vertex_capacity = capacity;
    if (!resize(ctx, &grown.positions, 3, 0, capacity) || (normals && !resize(ctx, &grown.normals, 3, 0, capacity)) ||
        (uvs && !resize(ctx, &grown.uvs, 2, 0, capacity)) || (colors && !resize(ctx, &grown.colors, 3, 0, capacity))) {
        rti_part_fini(ctx, &grown);
        return false;
    }
    size_t n = part->vertex_count * sizeof(float);
    if (part->positions)
        memcpy(grown.positions, part->positions, 3 * n);
    if (part->normals && normals)
        memcpy(grown.normals, part->normals, 3 * n);
    if (part->uvs && uvs)
        memcpy(grown.uvs, part->uvs, 2 * n);
    if (part->colors && colors)
        memcpy(grown.colors, part->colors, 3 * n);
    grown.indices = part->indices;
    grown.index_capacity = part->index_capacity;
    grown.vertex_count = part->vertex_count;
    grown.triangle_count = part->triangle_count;
    grown.look = part->look;
    part->indices = NULL;
    part->index_capacity = 0;
    rti_part_fini(ctx, part);
    *part = grown;
    return true;
}

bool rti_part_reserve_triangles(rt_context *ctx, rti_part *part, size_t more)
{
    if (more > RTI_MODEL_MAX_TRIANGLES - part->triangle_count)
        return false;
    return rti_reserve(ctx, (void **)&part->indices, &part->index_capacity, 3 * (size_t)part->triangle_count, 3 * more,
                       sizeof *part->indices);
}

/* ---- polygons ---- */

static void subtract(const float *a, const float *b, double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = (double)a[k] - b[k];
}

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Every triangle of the fan about the first corner looks the same way as their sum, and no corner turns back. */
static bool fan_is_right(const float *positions, const uint32_t *corners, uint32_t n)
{
    double sum[3] = {0, 0, 0}, e0[3], e1[3], t[3];
    const float *first = positions + 3 * (size_t)corners[0];
    for (uint32_t i = 1; i + 1 < n; i++) {
        subtract(positions + 3 * (size_t)corners[i], first, e0);
        subtract(positions + 3 * (size_t)corners[i + 1], first, e1);
        cross(e0, e1, t);
        for (int k = 0; k < 3; k++)
            sum[k] += t[k];
    }
    for (uint32_t i = 1; i + 1 < n; i++) {
        const float *a = positions + 3 * (size_t)corners[i], *b = positions + 3 * (size_t)corners[i + 1];
        const float *c = positions + 3 * (size_t)corners[i + 2 < n ? i + 2 : 0];
        subtract(a, first, e0);
        subtract(b, first, e1);
        cross(e0, e1, t);
        if (dot(t, sum) < 0)
            return false;
        subtract(b, a, e0);
        subtract(c, b, e1);
        cross(e0, e1, t);
        if (dot(t, sum) < 0)
            return false;
    }
    return true;
}

bool rti_part_polygon(rt_context *ctx, rti_part *part, const uint32_t *corners, uint32_t n)
{
    if (!rti_part_reserve_triangles(ctx, part, n - 2))
        return false;
    if (n == 3 || fan_is_right(part->positions, corners, n)) {
        for (uint32_t i = 1; i + 1 < n; i++)
            rti_part_triangle(part, corners[0], corners[i], corners[i + 1]);
        return true;
    }
    size_t size = RTI_POLYGON_SCRATCH * (size_t)n * sizeof(uint32_t);
    uint32_t *scratch = rti_alloc(ctx, size);
    if (!scratch)
        return false;
    rti_polygon_triangulate(part->positions, corners, n, scratch, part->indices + 3 * (size_t)part->triangle_count);
    part->triangle_count += n - 2;
    rti_free(ctx, scratch, size);
    return true;
}

/* ---- text ---- */

bool rti_parse_any(const char **p, const char *end, double *out)
{
    const char *q = *p;
    char w[3];
    if (rti_parse_double(p, end, out))
        return true;
    bool minus = q < end && *q == '-';
    q += q < end && (*q == '-' || *q == '+');
    if (end - q < 3)
        return false;
    for (int i = 0; i < 3; i++)
        w[i] = (char)(q[i] | 32);
    if (memcmp(w, "nan", 3) != 0 && memcmp(w, "inf", 3) != 0)
        return false;
    *out = w[0] == 'n' ? NAN : minus ? -INFINITY : INFINITY;
    while (q < end && !rti_is_space(*q)) /* infinity, nan(ind) */
        q++;
    *p = q;
    return true;
}

/* ---- kinds ---- */

static bool ends_with(const char *path, const char *ending)
{
    size_t n = strlen(path), m = strlen(ending);
    if (n < m)
        return false;
    for (size_t i = 0; i < m; i++) {
        char c = path[n - m + i];
        if ((c >= 'A' && c <= 'Z' ? (char)(c + 32) : c) != ending[i])
            return false;
    }
    return true;
}

rti_mesh_format rti_mesh_format_of(const char *path, const void *bytes, size_t size)
{
    const unsigned char *p = bytes;
    if (size >= 4 && memcmp(p, "ply", 3) == 0 && (p[3] == '\n' || p[3] == '\r'))
        return RTI_MESH_PLY;
    if (size >= 84 && !ends_with(path, ".obj") && !ends_with(path, ".ply")) { /* binary STL: the count fits the length exactly */
        uint64_t count = (uint32_t)p[80] | (uint32_t)p[81] << 8 | (uint32_t)p[82] << 16 | (uint32_t)p[83] << 24;
        if (84 + 50 * count == size)
            return RTI_MESH_STL;
    }
    if (size >= 6 && memcmp(p, "solid", 5) == 0 && (p[5] == ' ' || p[5] == '\n' || p[5] == '\r' || p[5] == '\t'))
        return RTI_MESH_STL;
    if (ends_with(path, ".ply"))
        return RTI_MESH_PLY;
    if (ends_with(path, ".stl"))
        return RTI_MESH_STL;
    return ends_with(path, ".obj") ? RTI_MESH_OBJ : RTI_MESH_UNKNOWN;
}
