/* Reading OBJ: vertices, faces, materials' names. Curves, surfaces, lines and points are left out with a warning.
 * Source: Wavefront's "Object Files (.obj)" specification, version 3.0. */
#include "obj.h"

#include <math.h>
#include <string.h>

#include "lines.h"

#define MAX_CORNERS 65535
#define MAX_UV      1e9

typedef struct obj_reader {
    rti_obj obj;
    rti_lines lines;
    uint32_t look;        /* of the faces that follow */
    uint32_t *look_table; /* looks by name, open addressing */
    size_t look_table_size;
    uint64_t flat, strange;
    bool other_warned;
} obj_reader;

static rt_status no_memory(const obj_reader *r, size_t size)
{
    return rti_fail_memory(r->obj.model->ctx, r->obj.model->name, size);
}

static rt_status fail(const obj_reader *r, const char *format, ...) RTI_PRINTF(2, 3);
static rt_status fail(const obj_reader *r, const char *format, ...)
{
    char text[512];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    return rti_fail(r->obj.model->ctx, RT_ERROR_FORMAT, "%s: line %llu: %s", r->obj.model->name,
                    (unsigned long long)r->lines.line, text);
}

/* Room for one more item of so many bytes; NULL: no memory. */
static void *push(const obj_reader *r, rti_obj_list *list, size_t size)
{
    if (!rti_reserve(r->obj.model->ctx, &list->data, &list->capacity, list->count, 1, size))
        return NULL;
    return (char *)list->data + size * list->count++;
}

/* ---- vertices ---- */

static rt_status missing_number(obj_reader *r, const char *what)
{
    char text[40];
    rti_word w = rti_lines_word(&r->lines);
    if (w.n == 0)
        return fail(r, "%s needs more numbers", what);
    return fail(r, "'%s' in %s is not a number", rti_quote(text, sizeof text, w.p, w.n), what);
}

/* v x y z [w] or v x y z r g b [a]. Colours begin to count with the first vertex that has some; the others are white. */
static rt_status read_position(obj_reader *r)
{
    double x[7];
    size_t n = 0, index = r->obj.v.count;
    while (n < 7 && rti_lines_number(&r->lines, &x[n]))
        n++;
    if (n < 3)
        return missing_number(r, "a vertex 'v x y z'");
    float *to = push(r, &r->obj.v, 3 * sizeof(float));
    if (!to)
        return no_memory(r, 3 * sizeof(float));
    for (size_t k = 0; k < 3; k++) {
        to[k] = (float)x[k];
        if (!isfinite(to[k]))
            return fail(r, "vertex %zu: %c is %s, not a finite number", index + 1, "xyz"[k], rti_num_double((char[32]){0}, x[k]));
    }
    if (n < 6 && !r->obj.has_colors)
        return RT_OK;
    r->obj.has_colors = true;
    while (r->obj.colors.count <= index) {
        float *c = push(r, &r->obj.colors, 3 * sizeof(float));
        if (!c)
            return no_memory(r, 3 * sizeof(float));
        for (size_t k = 0; k < 3; k++) {
            bool given = n >= 6 && r->obj.colors.count == index + 1;
            c[k] = !given ? 1.0f : x[3 + k] > 0 ? x[3 + k] < 1e6 ? (float)x[3 + k] : 1e6f : 0.0f;
        }
    }
    return RT_OK;
}

static rt_status read_uv(obj_reader *r)
{
    double u, v = 0;
    if (!rti_lines_number(&r->lines, &u))
        return missing_number(r, "a texture vertex 'vt u v'");
    rti_lines_number(&r->lines, &v);
    float *to = push(r, &r->obj.vt, 2 * sizeof(float));
    if (!to)
        return no_memory(r, 2 * sizeof(float));
    bool good = fabs(u) <= MAX_UV && fabs(v) <= MAX_UV;
    to[0] = good ? (float)u : 0.0f;
    to[1] = good ? (float)v : 0.0f;
    r->strange += !good;
    return RT_OK;
}

static rt_status read_normal(obj_reader *r)
{
    double x[3];
    for (int k = 0; k < 3; k++)
        if (!rti_lines_number(&r->lines, &x[k]))
            return missing_number(r, "a normal 'vn x y z'");
    float *to = push(r, &r->obj.vn, 3 * sizeof(float));
    if (!to)
        return no_memory(r, 3 * sizeof(float));
    bool good = fabs(x[0]) < 1e18 && fabs(x[1]) < 1e18 && fabs(x[2]) < 1e18;
    for (int k = 0; k < 3; k++)
        to[k] = good ? (float)x[k] : 0.0f;
    r->strange += !good;
    return RT_OK;
}

/* ---- faces ---- */

/* One index: from 1, or from -1 backwards. Those beyond what has been read are checked again at the end of the file: they may yet
 * come. */
static rt_status read_index(obj_reader *r, const char **p, const char *end, const rti_obj_list *list, const char *what,
                            uint32_t *out)
{
    char text[40];
    const char *from = *p;
    int64_t i;
    if (!rti_parse_int(p, end, &i))
        return fail(r, "'%s' is no %s index; a corner of a face is as 3, 3/1, 3//2 or 3/1/2",
                    rti_quote(text, sizeof text, from, (size_t)(end - from)), what);
    if (i == 0)
        return fail(r, "%s index 0; OBJ files count from 1 (or from -1 backwards)", what);
    if (i < 0)
        i += (int64_t)list->count + 1;
    if (i < 1 || i >= RTI_OBJ_NONE)
        return fail(r, "%s index '%s' points before the first; there are %zu so far", what,
                    rti_quote(text, sizeof text, from, (size_t)(*p - from)), list->count);
    *out = (uint32_t)(i - 1);
    return RT_OK;
}

static rt_status read_corner(obj_reader *r, rti_word w, rti_obj_corner *c)
{
    const char *p = w.p, *end = w.p + w.n;
    char text[40];
    *c = (rti_obj_corner){RTI_OBJ_NONE, RTI_OBJ_NONE, RTI_OBJ_NONE};
    rt_status status = read_index(r, &p, end, &r->obj.v, "vertex", &c->v);
    if (!status && p < end && *p == '/') {
        p++;
        if (p < end && *p != '/')
            status = read_index(r, &p, end, &r->obj.vt, "texture", &c->vt);
        if (!status && p < end && *p == '/') {
            p++;
            if (p < end) /* "3/1/" is seen in the wild */
                status = read_index(r, &p, end, &r->obj.vn, "normal", &c->vn);
        }
    }
    if (!status && p != end)
        status =
            fail(r, "'%s' is no corner of a face; they are as 3, 3/1, 3//2 or 3/1/2", rti_quote(text, sizeof text, w.p, w.n));
    return status;
}

static rt_status read_face(obj_reader *r)
{
    size_t first = r->obj.corners.count;
    for (rti_word w = rti_lines_word(&r->lines); w.n; w = rti_lines_word(&r->lines)) {
        if (*w.p == '#')
            break;
        rti_obj_corner *c = push(r, &r->obj.corners, sizeof *c);
        if (!c)
            return no_memory(r, sizeof *c);
        rt_status status = read_corner(r, w, c);
        if (status)
            return status;
    }
    size_t n = r->obj.corners.count - first;
    if (n > MAX_CORNERS)
        return fail(r, "a face of %zu corners; at most %d are allowed", n, MAX_CORNERS);
    if (n < 3) {
        r->obj.corners.count = first;
        r->flat++;
        return RT_OK;
    }
    rti_obj_face *face = r->obj.faces.count < RTI_MODEL_MAX_TRIANGLES ? push(r, &r->obj.faces, sizeof *face) : NULL;
    if (!face)
        return no_memory(r, sizeof *face);
    *face = (rti_obj_face){(uint32_t)n, r->look, RTI_OBJ_NONE};
    return RT_OK;
}

/* ---- names ---- */

static const char *keep(const obj_reader *r, rti_word w)
{
    char *text = rti_arena_alloc(&r->obj.model->arena, w.n + 1);
    if (text) {
        memcpy(text, w.p, w.n);
        text[w.n] = '\0';
    }
    return text;
}

static size_t name_hash(const char *p, size_t n)
{
    rti_hash h = rti_hash_bytes(p, n);
    return (size_t)h.lo;
}

static bool grow_look_table(obj_reader *r)
{
    rti_model *m = r->obj.model;
    size_t size = r->look_table_size ? 2 * r->look_table_size : 64;
    uint32_t *table = rti_alloc_array(m->ctx, size, sizeof *table);
    if (!table)
        return false;
    memset(table, 0xff, size * sizeof *table);
    rti_free(m->ctx, r->look_table, r->look_table_size * sizeof *r->look_table);
    r->look_table = table;
    r->look_table_size = size;
    for (uint32_t i = 0; i < m->look_count; i++) {
        size_t at = name_hash(m->looks[i].name, strlen(m->looks[i].name)) & (size - 1);
        while (table[at] != UINT32_MAX)
            at = (at + 1) & (size - 1);
        table[at] = i;
    }
    return true;
}

static rt_status use_look(obj_reader *r)
{
    rti_model *m = r->obj.model;
    rti_word w = rti_lines_rest(&r->lines);
    if (memchr(w.p, 0, w.n))
        return fail(r, "a material's name with a zero byte");
    if (2 * m->look_count >= r->look_table_size && !grow_look_table(r))
        return no_memory(r, 2 * m->look_count * sizeof *r->look_table);
    size_t at = name_hash(w.p, w.n) & (r->look_table_size - 1);
    for (; r->look_table[at] != UINT32_MAX; at = (at + 1) & (r->look_table_size - 1)) {
        if (rti_word_is(w, m->looks[r->look_table[at]].name)) {
            r->look = r->look_table[at];
            return RT_OK;
        }
    }
    const char *name = keep(r, w);
    if (!name || !rti_reserve(m->ctx, (void **)&m->looks, &m->look_capacity, m->look_count, 1, sizeof *m->looks))
        return no_memory(r, sizeof *m->looks);
    m->looks[m->look_count] = (rti_look){.name = name};
    r->look_table[at] = r->look = (uint32_t)m->look_count++;
    return RT_OK;
}

static rt_status add_library(obj_reader *r)
{
    rti_model *m = r->obj.model;
    rti_word w = rti_lines_rest(&r->lines);
    if (w.n == 0 || memchr(w.p, 0, w.n))
        return w.n ? fail(r, "a file name with a zero byte") : RT_OK;
    const char *name = keep(r, w);
    if (!name || !rti_reserve(m->ctx, (void **)&m->libraries, &m->library_capacity, m->library_count, 1, sizeof *m->libraries))
        return no_memory(r, w.n + sizeof *m->libraries);
    m->libraries[m->library_count++] = name;
    return RT_OK;
}

/* ---- the file ---- */

static rt_status other_line(obj_reader *r, rti_word key)
{
    static const char *const silent[] = {"o",   "g",      "s",      "mg",    "shadow_obj", "trace_obj",
                                         "lod", "usemap", "maplib", "bevel", "c_interp",   "d_interp"};
    char text[40];
    for (size_t i = 0; i < RTI_COUNT(silent); i++)
        if (rti_word_is(key, silent[i]))
            return RT_OK;
    if (!r->other_warned)
        rti_model_warn(
            r->obj.model,
            "line %llu: '%s' is not read (only vertices, faces and materials are); later ones of its kind are passed over too",
            (unsigned long long)r->lines.line, rti_quote(text, sizeof text, key.p, key.n));
    r->other_warned = true;
    return RT_OK;
}

static rt_status read_line(obj_reader *r)
{
    rti_word key = rti_lines_word(&r->lines);
    if (key.n == 0 || key.p[0] == '#')
        return RT_OK;
    if (rti_word_is(key, "v"))
        return read_position(r);
    if (rti_word_is(key, "f") || rti_word_is(key, "fo"))
        return read_face(r);
    if (rti_word_is(key, "vt"))
        return read_uv(r);
    if (rti_word_is(key, "vn"))
        return read_normal(r);
    if (rti_word_is(key, "usemtl"))
        return use_look(r);
    if (rti_word_is(key, "mtllib"))
        return add_library(r);
    return other_line(r, key);
}

static void free_list(rt_context *ctx, rti_obj_list *list, size_t size)
{
    rti_free(ctx, list->data, list->capacity * size);
}

rt_status rti_obj_read(rti_model *model, const void *bytes, size_t size)
{
    rt_context *ctx = model->ctx;
    obj_reader r = {.obj.model = model, .look = RT_INVALID_ID};
    rt_status status = RT_OK;
    rti_lines_init(&r.lines, bytes, size);
    while (!status && rti_lines_next(&r.lines))
        status = read_line(&r);
    if (!status && r.obj.faces.count == 0)
        status = rti_fail(ctx, RT_ERROR_FORMAT, "%s: no faces ('f' lines) in %llu lines: not an OBJ mesh", model->name,
                          (unsigned long long)r.lines.line);
    if (!status && r.obj.v.count >= RTI_OBJ_NONE)
        status = rti_fail(ctx, RT_ERROR_FORMAT, "%s: %zu vertices; at most 4294967294 can be read", model->name, r.obj.v.count);
    if (!status && r.flat)
        rti_model_warn(model, "%llu faces have fewer than three corners; they were left out", (unsigned long long)r.flat);
    if (!status && r.strange)
        rti_model_warn(model, "%llu normals or texture coordinates are not finite; they were set to 0",
                       (unsigned long long)r.strange);
    if (!status)
        status = rti_obj_parts(&r.obj);
    free_list(ctx, &r.obj.v, 3 * sizeof(float));
    free_list(ctx, &r.obj.colors, 3 * sizeof(float));
    free_list(ctx, &r.obj.vt, 2 * sizeof(float));
    free_list(ctx, &r.obj.vn, 3 * sizeof(float));
    free_list(ctx, &r.obj.corners, sizeof(rti_obj_corner));
    free_list(ctx, &r.obj.faces, sizeof(rti_obj_face));
    rti_free(ctx, r.look_table, r.look_table_size * sizeof *r.look_table);
    return status;
}
