/* The values of a PLY file, ASCII or binary. */
#include "ply.h"

#include <math.h>
#include <string.h>

#include "../../kernel/srgb.h"
#include "srgb.h"

#define MAX_CORNERS 65535
#define MAX_UV      1e9 /* texture coordinates beyond it have no fraction left */

/* ---- values ---- */

static double binary_value(const unsigned char *p, uint8_t type, bool big)
{
    uint64_t bits = 0;
    size_t size = rti_ply_size(type);
    for (size_t i = 0; i < size; i++)
        bits |= (uint64_t)p[big ? size - 1 - i : i] << (8 * i);
    switch (type) {
    case PLY_I8:
        return (int8_t)bits;
    case PLY_I16:
        return (int16_t)bits;
    case PLY_I32:
        return (int32_t)bits;
    case PLY_F32: {
        uint32_t word = (uint32_t)bits;
        float x;
        memcpy(&x, &word, sizeof x);
        return x;
    }
    case PLY_F64: {
        double x;
        memcpy(&x, &bits, sizeof x);
        return x;
    }
    default:
        return (double)bits;
    }
}

static rt_status ascii_value(ply *f, double *out)
{
    while (f->p < f->end && rti_is_space(*f->p))
        f->line += *f->p++ == '\n';
    if (f->p >= f->end)
        return rti_ply_fail(f, "the file is cut: a number should follow");
    const char *from = f->p;
    bool good = rti_parse_any(&f->p, f->end, out);
    if (good && (f->p == f->end || rti_is_space(*f->p)))
        return RT_OK;
    char text[40];
    size_t n = 0;
    while (from + n < f->end && n < 24 && !rti_is_space(from[n]))
        n++;
    return rti_ply_fail(f, "'%s' is not a number", rti_quote(text, sizeof text, from, n));
}

static rt_status value(ply *f, uint8_t type, double *out)
{
    if (f->coding == PLY_ASCII)
        return ascii_value(f, out);
    size_t size = rti_ply_size(type);
    if ((size_t)(f->end - f->p) < size)
        return rti_ply_fail(f, "the file is cut: a value of %zu bytes should follow", size);
    *out = binary_value((const unsigned char *)f->p, type, f->coding == PLY_BIG);
    f->p += size;
    return RT_OK;
}

/* A list's count, held against the bytes left. */
static rt_status list_count(ply *f, const ply_property *q, uint64_t *count)
{
    double n = 0;
    rt_status status = value(f, q->count_type, &n);
    if (status)
        return status;
    uint64_t left = (uint64_t)(f->end - f->p), item = f->coding == PLY_ASCII ? 1 : rti_ply_size(q->type);
    if (!(n >= 0) || n != floor(n))
        return rti_ply_fail(f, "a list cannot have %s items", rti_num_double((char[32]){0}, n));
    left /= item;
    if (n > (double)left)
        return rti_ply_fail(f, "a list of %s items, but no more than %llu fit into the rest: the file is cut or damaged",
                            rti_num_double((char[32]){0}, n), (unsigned long long)left);
    *count = (uint64_t)n;
    return RT_OK;
}

static rt_status skip(ply *f, const ply_property *q)
{
    uint64_t count = 1;
    double ignored;
    rt_status status = q->count_type == PLY_NO_TYPE ? RT_OK : list_count(f, q, &count);
    if (!status && f->coding != PLY_ASCII) {
        if (count > (size_t)(f->end - f->p) / rti_ply_size(q->type))
            return rti_ply_fail(f, "the file is cut: %llu values should follow", (unsigned long long)count);
        f->p += count * rti_ply_size(q->type);
        return RT_OK;
    }
    for (uint64_t i = 0; i < count && !status; i++)
        status = ascii_value(f, &ignored);
    return status;
}

static rt_status skip_element(ply *f, const ply_element *e)
{
    rt_status status = RT_OK;
    for (uint64_t i = 0; e->property_count && i < e->count && !status; i++)
        for (size_t k = 0; k < e->property_count && !status; k++)
            status = skip(f, &f->properties[e->first + k]);
    return status;
}

/* ---- vertices ---- */

typedef struct vertex_shape {
    bool normals, colors, uvs;
    uint8_t type[PLY_SCALARS]; /* of the property of each use, PLY_NO_TYPE: not there */
} vertex_shape;

static rt_status vertex_head(ply *f, const ply_element *e, vertex_shape *s)
{
    const uint8_t *t = s->type;
    memset(s->type, PLY_NO_TYPE, sizeof s->type);
    for (size_t k = 0; k < e->property_count; k++) {
        const ply_property *q = &f->properties[e->first + k];
        if (q->use < PLY_SCALARS)
            s->type[q->use] = q->type;
    }
    if (t[PLY_X] == PLY_NO_TYPE || t[PLY_Y] == PLY_NO_TYPE || t[PLY_Z] == PLY_NO_TYPE)
        return rti_ply_fail(f, "the vertices of this file have no x, y and z");
    s->normals = t[PLY_NX] != PLY_NO_TYPE && t[PLY_NY] != PLY_NO_TYPE && t[PLY_NZ] != PLY_NO_TYPE;
    s->uvs = t[PLY_U] != PLY_NO_TYPE && t[PLY_V] != PLY_NO_TYPE;
    s->colors = t[PLY_R] != PLY_NO_TYPE && t[PLY_G] != PLY_NO_TYPE && t[PLY_B] != PLY_NO_TYPE;
    return RT_OK;
}

/* Integer colours are sRGB codes of their type's range, floats are linear. */
static float colour(uint8_t type, double x)
{
    if (type == PLY_U8)
        return rtk_srgb_table[x >= 0 && x <= 255 ? (int)x : x < 0 ? 0 : 255];
    if (type == PLY_F32 || type == PLY_F64)
        return x > 0 ? x < 1e6 ? (float)x : 1e6f : 0.0f;
    return (float)rti_srgb_decode(x / (type == PLY_U16 ? 65535.0 : 255.0));
}

static bool is_float(double x)
{
    return isfinite((float)x);
}

static rt_status store_vertex(ply *f, const vertex_shape *s, rti_part *part, const double v[PLY_SCALARS], uint32_t *strange)
{
    size_t i = part->vertex_count;
    for (int k = 0; k < 3; k++) {
        if (!is_float(v[PLY_X + k]))
            return rti_ply_fail(f, "vertex %zu: %c is %s, not a finite number", i, "xyz"[k],
                                rti_num_double((char[32]){0}, v[PLY_X + k]));
        part->positions[3 * i + (size_t)k] = (float)v[PLY_X + k];
    }
    if (s->normals) {
        bool good = is_float(v[PLY_NX]) && is_float(v[PLY_NY]) && is_float(v[PLY_NZ]);
        for (int k = 0; k < 3; k++)
            part->normals[3 * i + (size_t)k] = good ? (float)v[PLY_NX + k] : 0.0f;
        *strange += !good;
    }
    if (s->uvs) {
        bool good = fabs(v[PLY_U]) <= MAX_UV && fabs(v[PLY_V]) <= MAX_UV;
        part->uvs[2 * i] = good ? (float)v[PLY_U] : 0.0f;
        part->uvs[2 * i + 1] = good ? (float)v[PLY_V] : 0.0f;
        *strange += !good;
    }
    if (s->colors)
        for (int k = 0; k < 3; k++)
            part->colors[3 * i + (size_t)k] = colour(s->type[PLY_R + k], v[PLY_R + k]);
    part->vertex_count++;
    return RT_OK;
}

static rt_status read_vertices(ply *f, const ply_element *e, rti_part *part)
{
    vertex_shape s = {0};
    uint32_t strange = 0;
    double v[PLY_SCALARS] = {0};
    rt_status status = vertex_head(f, e, &s);
    if (status)
        return status;
    if (e->count >= RT_INVALID_ID)
        return rti_ply_fail(f, "%llu vertices; at most 4294967294 can be read", (unsigned long long)e->count);
    if (!rti_part_reserve(f->model->ctx, part, e->count, s.normals, s.uvs, s.colors))
        return rti_fail_memory(f->model->ctx, f->model->name, 3 * sizeof(float) * e->count);
    for (uint64_t i = 0; i < e->count && !status; i++) {
        for (size_t k = 0; k < e->property_count && !status; k++) {
            const ply_property *q = &f->properties[e->first + k];
            status = q->use < PLY_SCALARS ? value(f, q->type, &v[q->use]) : skip(f, q);
        }
        if (!status)
            status = store_vertex(f, &s, part, v, &strange);
    }
    if (!status && strange)
        rti_model_warn(f->model, "%u normals or texture coordinates are not finite; they were set to 0", (unsigned)strange);
    return status;
}

/* ---- faces ---- */

typedef struct corner_list {
    uint32_t *items;
    size_t count, capacity;
} corner_list;

static rt_status read_corner(ply *f, const ply_property *q, uint64_t vertex_count, uint64_t face, int64_t *out)
{
    double x;
    rt_status status = value(f, q->type, &x);
    if (status)
        return status;
    if (x != floor(x) || !(x >= -1) || !(x < (double)vertex_count))
        return rti_ply_fail(f, "face %llu: corner %s is not one of the %llu vertices (0 ... %lld)", (unsigned long long)face,
                            rti_num_double((char[32]){0}, x), (unsigned long long)vertex_count, (long long)vertex_count - 1);
    *out = (int64_t)x;
    return RT_OK;
}

static rt_status read_corners(ply *f, const ply_element *e, const ply_property *q, const rti_part *part, uint64_t face,
                              corner_list *c)
{
    uint64_t n = 0;
    rt_status status = list_count(f, q, &n);
    if (status)
        return status;
    if (e->kind == PLY_FACE && n > MAX_CORNERS)
        return rti_ply_fail(f, "face %llu has %llu corners; at most %d are allowed", (unsigned long long)face,
                            (unsigned long long)n, MAX_CORNERS);
    if (!rti_reserve(f->model->ctx, (void **)&c->items, &c->capacity, 0, n, sizeof *c->items))
        return rti_fail_memory(f->model->ctx, f->model->name, n * sizeof *c->items);
    c->count = n;
    for (uint64_t i = 0; i < n; i++) {
        int64_t v = 0;
        status = read_corner(f, q, part->vertex_count, face, &v);
        if (!status && v < 0 && e->kind == PLY_FACE)
            status = rti_ply_fail(f, "face %llu: a corner is -1; vertices count from 0", (unsigned long long)face);
        if (status)
            return status;
        c->items[i] = v < 0 ? RT_INVALID_ID : (uint32_t)v;
    }
    return RT_OK;
}

/* Triangles of a strip; -1 begins a new one. */
static bool add_strip(rt_context *ctx, rti_part *part, const corner_list *c)
{
    size_t from = 0;
    if (!rti_part_reserve_triangles(ctx, part, c->count))
        return false;
    for (size_t i = 0; i < c->count; i++) {
        if (c->items[i] == RT_INVALID_ID) {
            from = i + 1;
        } else if (i >= from + 2) {
            bool odd = (i - from) & 1;
            rti_part_triangle(part, c->items[odd ? i - 1 : i - 2], c->items[odd ? i - 2 : i - 1], c->items[i]);
        }
    }
    return true;
}

static rt_status read_faces(ply *f, const ply_element *e, rti_part *part)
{
    rt_context *ctx = f->model->ctx;
    corner_list c = {0};
    uint64_t flat = 0;
    bool corners = false, room = true;
    rt_status status = RT_OK;
    for (size_t k = 0; k < e->property_count; k++)
        corners |= f->properties[e->first + k].use == PLY_CORNERS;
    if (!corners && e->count)
        return rti_ply_fail(f, "the faces of this file have no list 'vertex_indices'");
    if (e->kind == PLY_FACE && !rti_part_reserve_triangles(ctx, part, e->count))
        return rti_fail_memory(ctx, f->model->name, 3 * sizeof(uint32_t) * e->count);
    for (uint64_t i = 0; i < e->count && !status && room; i++) {
        for (size_t k = 0; k < e->property_count && !status; k++) {
            const ply_property *q = &f->properties[e->first + k];
            status = q->use == PLY_CORNERS ? read_corners(f, e, q, part, i, &c) : skip(f, q);
        }
        if (status)
            break;
        if (e->kind == PLY_STRIP)
            room = add_strip(ctx, part, &c);
        else if (c.count >= 3)
            room = rti_part_polygon(ctx, part, c.items, (uint32_t)c.count);
        else
            flat++;
    }
    rti_free(ctx, c.items, c.capacity * sizeof *c.items);
    if (!status && !room)
        status = rti_fail_memory(ctx, f->model->name, 3 * sizeof(uint32_t) * (size_t)part->triangle_count);
    if (!status && flat)
        rti_model_warn(f->model, "%llu faces have fewer than three corners; they were left out", (unsigned long long)flat);
    return status;
}

/* ---- the file ---- */

static rt_status read_elements(ply *f, rti_part *part)
{
    bool vertices = false;
    struct {
        const ply_element *element;
        const char *p;
        uint64_t line;
    } later[2] = {{0}};
    size_t later_count = 0;
    rt_status status = RT_OK;
    for (size_t i = 0; i < f->element_count && !status; i++) {
        const ply_element *e = &f->elements[i];
        if (e->kind == PLY_VERTEX) {
            status = read_vertices(f, e, part);
            vertices = true;
        } else if (e->kind == PLY_OTHER) {
            status = skip_element(f, e);
        } else if (vertices) {
            status = read_faces(f, e, part);
        } else { /* faces before vertices: come back; each of the two kinds is there once at most */
            later[later_count].element = e;
            later[later_count].p = f->p;
            later[later_count++].line = f->line;
            status = skip_element(f, e);
        }
    }
    if (!status && !vertices)
        return rti_ply_fail(f, "this PLY file has no element 'vertex'");
    for (size_t i = 0; i < later_count && !status; i++) {
        f->p = later[i].p;
        f->line = later[i].line;
        status = read_faces(f, later[i].element, part);
    }
    return status;
}

rt_status rti_ply_read(rti_model *model, const void *bytes, size_t size)
{
    ply f = {.model = model, .start = bytes, .p = bytes, .end = (const char *)bytes + size, .line = 1};
    rt_context *ctx = model->ctx;
    rt_status status = rti_ply_head(&f);
    if (!status) {
        rti_part *part = rti_model_add_part(model, RT_INVALID_ID);
        status = part ? read_elements(&f, part) : rti_fail_memory(ctx, model->name, sizeof *part);
        if (!status && part->triangle_count == 0)
            status = rti_fail(ctx, RT_ERROR_FORMAT,
                              "%s: this PLY file has %u vertices but no faces; a mesh needs them (a cloud of points can be "
                              "added as spheres)",
                              model->name, (unsigned)part->vertex_count);
    }
    rti_free(ctx, f.elements, f.element_capacity * sizeof *f.elements);
    rti_free(ctx, f.properties, f.property_capacity * sizeof *f.properties);
    return status;
}
