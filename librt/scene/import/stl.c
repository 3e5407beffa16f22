/* STL, binary and ASCII. Vertices at one place become one. A binary file may begin with "solid" too: the length decides. */
#include "model.h"

#include <math.h>
#include <string.h>

typedef struct stl {
    rti_model *model;
    rti_part *part;
    const char *p, *end;
    uint64_t line;
    uint32_t *table; /* vertices by place, open addressing */
    size_t table_size;
} stl;

static uint64_t place_hash(const float *p)
{
    uint32_t b[3];
    memcpy(b, p, sizeof b);
    uint64_t h = (b[0] | (uint64_t)b[1] << 32) * UINT64_C(0xd6e8feb86659fd93) ^ b[2];
    h = (h ^ h >> 32) * UINT64_C(0xd6e8feb86659fd93);
    return h ^ h >> 32;
}

static void enter(stl *f, uint32_t vertex)
{
    size_t at = place_hash(f->part->positions + 3 * (size_t)vertex) & (f->table_size - 1);
    while (f->table[at] != UINT32_MAX)
        at = (at + 1) & (f->table_size - 1);
    f->table[at] = vertex;
}

static bool grow_table(stl *f)
{
    size_t size = f->table_size ? 2 * f->table_size : 1024;
    uint32_t *table = rti_alloc_array(f->model->ctx, size, sizeof *table);
    if (!table)
        return false;
    memset(table, 0xff, size * sizeof *table);
    rti_free(f->model->ctx, f->table, f->table_size * sizeof *f->table);
    f->table = table;
    f->table_size = size;
    for (uint32_t v = 0; v < f->part->vertex_count; v++)
        enter(f, v);
    return true;
}

static bool add_vertex(stl *f, const float at[3], uint32_t *vertex)
{
    rti_part *part = f->part;
    float p[3] = {at[0] + 0.0f, at[1] + 0.0f, at[2] + 0.0f}; /* -0 becomes 0 */
    if (2 * (size_t)part->vertex_count >= f->table_size && !grow_table(f))
        return false;
    size_t k = place_hash(p) & (f->table_size - 1);
    for (; f->table[k] != UINT32_MAX; k = (k + 1) & (f->table_size - 1)) {
        if (memcmp(part->positions + 3 * (size_t)f->table[k], p, sizeof p) == 0) {
            *vertex = f->table[k];
            return true;
        }
    }
    if (!rti_part_reserve(f->model->ctx, part, (size_t)part->vertex_count + 1, false, false, false))
        return false;
    f->table[k] = *vertex = part->vertex_count++;
    memcpy(part->positions + 3 * (size_t)*vertex, p, sizeof p);
    return true;
}

static rt_status add_facet(stl *f, const float corners[9])
{
    uint32_t v[3];
    if (!rti_part_reserve_triangles(f->model->ctx, f->part, 1) || !add_vertex(f, corners, &v[0]) ||
        !add_vertex(f, corners + 3, &v[1]) || !add_vertex(f, corners + 6, &v[2]))
        return rti_fail_memory(f->model->ctx, f->model->name, f->table_size * sizeof *f->table);
    rti_part_triangle(f->part, v[0], v[1], v[2]);
    return RT_OK;
}

/* ---- binary ---- */

static rt_status read_binary(stl *f, const char *bytes, size_t size)
{
    rt_context *ctx = f->model->ctx;
    const unsigned char *p = (const unsigned char *)bytes + 84;
    uint32_t count = size < 84 ? 0 : (uint32_t)p[-4] | (uint32_t)p[-3] << 8 | (uint32_t)p[-2] << 16 | (uint32_t)p[-1] << 24;
    if (size < 84 || count > (size - 84) / 50)
        return rti_fail(ctx, RT_ERROR_FORMAT,
                        "%s: this binary STL file is cut: it has %zu bytes and needs %llu for its %llu facets", f->model->name,
                        size, 84 + 50ull * count, (unsigned long long)count);
    rt_status status = RT_OK;
    if (!rti_part_reserve_triangles(ctx, f->part, count) || !rti_part_reserve(ctx, f->part, count / 2 + 3, false, false, false))
        return rti_fail_memory(ctx, f->model->name, 12 * (size_t)count);
    for (uint64_t i = 0; i < count && !status; i++, p += 50) {
        float corners[9] = {0};
        for (int k = 0; k < 9; k++) {
            const unsigned char *q = p + 12 + 4 * k;
            uint32_t bits = (uint32_t)q[0] | (uint32_t)q[1] << 8 | (uint32_t)q[2] << 16 | (uint32_t)q[3] << 24;
            memcpy(&corners[k], &bits, sizeof bits);
            if (!isfinite(corners[k]))
                return rti_fail(ctx, RT_ERROR_FORMAT, "%s: byte %zu: facet %llu: a coordinate is not a finite number",
                                f->model->name, (size_t)((const char *)q - bytes), (unsigned long long)i);
        }
        status = add_facet(f, corners);
    }
    if (!status && 84 + 50ull * count < size)
        rti_model_warn(f->model, "%llu bytes behind the last facet were left out", (unsigned long long)size - 84 - 50ull * count);
    return status;
}

/* ---- ASCII ---- */

static rt_status fail_line(const stl *f, const char *expected)
{
    char text[40];
    size_t n = 0;
    while (f->p + n < f->end && n < 24 && !rti_is_space(f->p[n]))
        n++;
    if (f->p >= f->end)
        return rti_fail(f->model->ctx, RT_ERROR_FORMAT, "%s: line %llu: the STL file is cut: %s should follow", f->model->name,
                        (unsigned long long)f->line, expected);
    return rti_fail(f->model->ctx, RT_ERROR_FORMAT, "%s: line %llu: '%s' stands where %s should", f->model->name,
                    (unsigned long long)f->line, rti_quote(text, sizeof text, f->p, n), expected);
}

static void skip_space(stl *f)
{
    while (f->p < f->end && rti_is_space(*f->p))
        f->line += *f->p++ == '\n';
}

/* Takes the word if it stands next; letters of any case. */
static bool take(stl *f, const char *word)
{
    skip_space(f);
    const char *q = f->p;
    for (; *word; word++, q++)
        if (q >= f->end || (*q | 32) != *word)
            return false;
    if (q < f->end && !rti_is_space(*q))
        return false;
    f->p = q;
    return true;
}

static void skip_line(stl *f)
{
    while (f->p < f->end && *f->p != '\n')
        f->p++;
}

static rt_status take_numbers(stl *f, float *out, bool must_be_finite)
{
    for (int k = 0; k < 3; k++) {
        double x;
        skip_space(f);
        const char *from = f->p;
        if (!rti_parse_any(&f->p, f->end, &x) || (must_be_finite && !isfinite((float)x)) ||
            (f->p < f->end && !rti_is_space(*f->p))) {
            f->p = from;
            return fail_line(f, "a finite number");
        }
        out[k] = (float)x;
    }
    return RT_OK;
}

static rt_status take_facet(stl *f)
{
    float normal[3], corners[9] = {0};
    if (!take(f, "normal"))
        return fail_line(f, "'normal'");
    rt_status status = take_numbers(f, normal, false); /* not used: the corners tell it better */
    if (status)
        return status;
    if (!take(f, "outer") || !take(f, "loop"))
        return fail_line(f, "'outer loop'");
    for (int k = 0; k < 3; k++) {
        if (!take(f, "vertex"))
            return fail_line(f, "'vertex'");
        status = take_numbers(f, corners + 3 * k, true);
        if (status)
            return status;
    }
    if (!take(f, "endloop"))
        return fail_line(f, "'endloop' (STL facets are triangles)");
    return take(f, "endfacet") ? add_facet(f, corners) : fail_line(f, "'endfacet'");
}

static rt_status read_ascii(stl *f)
{
    rt_status status = RT_OK;
    do {
        if (!take(f, "solid"))
            return fail_line(f, "'solid'");
        skip_line(f); /* its name */
        while (!status && take(f, "facet"))
            status = take_facet(f);
        if (!status && !take(f, "endsolid"))
            status = fail_line(f, "'facet' or 'endsolid'");
        if (!status) {
            skip_line(f);
            skip_space(f);
        }
    } while (!status && f->p < f->end);
    return status;
}

/* Text when it begins with "solid", its length fits no binary file, and no zero byte stands in its first 1,000. */
static bool is_ascii(const char *bytes, size_t size)
{
    const unsigned char *p = (const unsigned char *)bytes;
    while (size && rti_is_space(*bytes))
        bytes++, size--;
    if (size < 5 || memcmp(bytes, "solid", 5) != 0)
        return false;
    if (size >= 84 &&
        84 + 50 * (uint64_t)((uint32_t)p[80] | (uint32_t)p[81] << 8 | (uint32_t)p[82] << 16 | (uint32_t)p[83] << 24) == size)
        return false;
    return memchr(bytes, 0, size < 1000 ? size : 1000) == NULL;
}

rt_status rti_stl_read(rti_model *model, const void *bytes, size_t size)
{
    rti_part *part = rti_model_add_part(model, RT_INVALID_ID);
    stl f = {.model = model, .part = part, .p = bytes, .end = (const char *)bytes + size, .line = 1};
    if (!part)
        return rti_fail_memory(model->ctx, model->name, sizeof *part);
    rt_status status = is_ascii(bytes, size) ? read_ascii(&f) : read_binary(&f, bytes, size);
    rti_free(model->ctx, f.table, f.table_size * sizeof *f.table);
    if (!status && part->triangle_count == 0)
        status = rti_fail(model->ctx, RT_ERROR_FORMAT, "%s: this STL file has no facets", model->name);
    return status;
}
