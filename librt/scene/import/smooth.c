/* Vertex normals for meshes that have none. Source: Thuermer & Wuethrich 1998 (weights by angle); creases split along edges. */
#include "model.h"

#include <math.h>
#include <string.h>

#define NONE UINT32_MAX

typedef struct smoother {
    rt_context *ctx;
    rti_part *part;
    uint32_t *weld;    /* [vertex]: the first vertex at the same place */
    uint32_t *group;   /* [corner]: union-find parent; corners of one group share a normal */
    double *face;      /* [3 triangle]: unit normals, zero for those without area */
    double *sum;       /* [3 corner]: at the group's root */
    uint32_t *table;   /* open addressing, of vertices, edges, or output vertices */
    size_t table_size; /* a power of two */
    double cos_crease;
} smoother;

/* acos within 2e-8 (Abramowitz & Stegun 4.4.46): weights need no more, and no libm means the same bits everywhere. */
static double arc_cosine(double x)
{
    static const double a[8] = {1.5707963050, -0.2145988016, 0.0889789874, -0.0501743046,
                                0.0308918810, -0.0170881256, 0.0066700901, -0.0012624911};
    double y = fabs(x), p = a[7];
    if (!(y < 1.0))
        return x > 0 ? 0.0 : 3.14159265358979323846;
    for (int i = 6; i >= 0; i--)
        p = p * y + a[i];
    p *= sqrt(1.0 - y);
    return x < 0 ? 3.14159265358979323846 - p : p;
}

/* cos of 0 ... 180 degrees by its series about the nearest of 0 and 180. */
static double cosine_deg(double degrees)
{
    bool far = degrees > 90;
    double x = (far ? 180 - degrees : degrees) * (3.14159265358979323846 / 180), term = 1, sum = 1;
    for (int i = 1; i < 16; i++) {
        term = -term * x * x / ((2 * i - 1) * (2 * i));
        sum += term;
    }
    return far ? -sum : sum;
}

static uint64_t mix(uint64_t x)
{
    x = (x ^ x >> 32) * UINT64_C(0xd6e8feb86659fd93);
    x = (x ^ x >> 32) * UINT64_C(0xd6e8feb86659fd93);
    return x ^ x >> 32;
}

static const float *position(const smoother *s, uint32_t v)
{
    return s->part->positions + 3 * (size_t)v;
}

static bool same_place(const float *a, const float *b)
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

static uint64_t place_hash(const float *p)
{
    uint32_t bits[3];
    for (int k = 0; k < 3; k++) {
        float x = p[k] + 0.0f; /* -0 and 0 are one place */
        memcpy(&bits[k], &x, sizeof x);
    }
    return mix(mix(bits[0] | (uint64_t)bits[1] << 32) ^ bits[2]);
}

static void clear_table(smoother *s)
{
    memset(s->table, 0xff, s->table_size * sizeof *s->table);
}

static void weld_vertices(smoother *s)
{
    clear_table(s);
    for (uint32_t v = 0; v < s->part->vertex_count; v++) {
        size_t at = place_hash(position(s, v)) & (s->table_size - 1);
        while (s->table[at] != NONE && !same_place(position(s, s->table[at]), position(s, v)))
            at = (at + 1) & (s->table_size - 1);
        if (s->table[at] == NONE)
            s->table[at] = v;
        s->weld[v] = s->table[at];
    }
}

static void subtract(const float *a, const float *b, double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = (double)a[k] - b[k];
}

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void normalize(double *a)
{
    double n = sqrt(dot(a, a));
    for (int k = 0; k < 3; k++)
        a[k] = n > 0 ? a[k] / n : 0.0;
}

static void face_normals(smoother *s)
{
    for (uint32_t t = 0; t < s->part->triangle_count; t++) {
        const uint32_t *c = s->part->indices + 3 * (size_t)t;
        double a[3], b[3], *n = s->face + 3 * (size_t)t;
        subtract(position(s, c[1]), position(s, c[0]), a);
        subtract(position(s, c[2]), position(s, c[0]), b);
        normalize(a);
        normalize(b);
        n[0] = a[1] * b[2] - a[2] * b[1];
        n[1] = a[2] * b[0] - a[0] * b[2];
        n[2] = a[0] * b[1] - a[1] * b[0];
        normalize(n);
    }
}

static uint32_t root(uint32_t *group, uint32_t c)
{
    while (group[c] != c) {
        group[c] = group[group[c]];
        c = group[c];
    }
    return c;
}

/* The lower corner becomes the root: the outcome does not depend on the order of joining. */
static void join(uint32_t *group, uint32_t a, uint32_t b)
{
    a = root(group, a);
    b = root(group, b);
    if (a < b)
        group[b] = a;
    else
        group[a] = b;
}

/* Welded ends of edge k of triangle t, the lower first; which corners of the triangle they are. */
static void edge_ends(const smoother *s, uint32_t edge, uint32_t ends[2], uint32_t corners[2])
{
    uint32_t t = edge / 3, k = edge % 3;
    corners[0] = 3 * t + k;
    corners[1] = 3 * t + (k + 1) % 3;
    ends[0] = s->weld[s->part->indices[corners[0]]];
    ends[1] = s->weld[s->part->indices[corners[1]]];
    if (ends[0] > ends[1]) {
        uint32_t e = ends[0], c = corners[0];
        ends[0] = ends[1], ends[1] = e;
        corners[0] = corners[1], corners[1] = c;
    }
}

/* Joins the corners of faces that meet along an edge without a crease. Each edge is held against the first face that has it. */
static void join_edges(smoother *s)
{
    clear_table(s);
    for (uint32_t edge = 0; edge < 3 * s->part->triangle_count; edge++) {
        uint32_t ends[2], corners[2], other_ends[2], other[2] = {0};
        edge_ends(s, edge, ends, corners);
        size_t at = mix(ends[0] | (uint64_t)ends[1] << 32) & (s->table_size - 1);
        for (; s->table[at] != NONE; at = (at + 1) & (s->table_size - 1)) {
            edge_ends(s, s->table[at], other_ends, other);
            if (other_ends[0] == ends[0] && other_ends[1] == ends[1])
                break;
        }
        if (s->table[at] == NONE) {
            s->table[at] = edge;
        } else if (dot(s->face + 3 * (size_t)(edge / 3), s->face + 3 * (size_t)(other[0] / 3)) > s->cos_crease) {
            join(s->group, corners[0], other[0]);
            join(s->group, corners[1], other[1]);
        }
    }
}

static void sum_normals(smoother *s)
{
    for (uint32_t c = 0; c < 3 * s->part->triangle_count; c++) {
        uint32_t t = c / 3, k = c % 3;
        const uint32_t *corner = s->part->indices + 3 * (size_t)t;
        double a[3], b[3], *to = s->sum + 3 * (size_t)root(s->group, c);
        subtract(position(s, corner[(k + 1) % 3]), position(s, corner[k]), a);
        subtract(position(s, corner[(k + 2) % 3]), position(s, corner[k]), b);
        normalize(a);
        normalize(b);
        double angle = arc_cosine(dot(a, b));
        for (int i = 0; i < 3; i++)
            to[i] += angle * s->face[3 * (size_t)t + (size_t)i];
    }
}

static void copy_vertex(const rti_part *from, uint32_t v, rti_part *to)
{
    size_t n = to->vertex_count++;
    memcpy(to->positions + 3 * n, from->positions + 3 * (size_t)v, 3 * sizeof(float));
    if (from->uvs)
        memcpy(to->uvs + 2 * n, from->uvs + 2 * (size_t)v, 2 * sizeof(float));
    if (from->colors)
        memcpy(to->colors + 3 * n, from->colors + 3 * (size_t)v, 3 * sizeof(float));
}

/* A vertex of the result for each pair of an old vertex and a group. The table holds corners whose vertex is made; group is then
 * used for the corner's new vertex, behind the roots that are still asked for: hence the order of corners and a copy of the
 * roots. */
static bool rebuild(smoother *s, uint32_t *made)
{
    rti_part *from = s->part, to = {0};
    size_t corner_count = 3 * (size_t)from->triangle_count;
    if (!rti_part_reserve(s->ctx, &to, corner_count < from->vertex_count ? from->vertex_count : corner_count, true,
                          from->uvs != NULL, from->colors != NULL))
        return false;
    clear_table(s);
    for (uint32_t c = 0; c < corner_count; c++) {
        uint32_t v = from->indices[c], g = root(s->group, c);
        size_t at = mix(v | (uint64_t)g << 32) & (s->table_size - 1);
        while (s->table[at] != NONE && (from->indices[s->table[at]] != v || root(s->group, s->table[at]) != g))
            at = (at + 1) & (s->table_size - 1);
        if (s->table[at] == NONE) {
            double n[3];
            s->table[at] = c;
            made[c] = to.vertex_count;
            memcpy(n, s->sum + 3 * (size_t)g, sizeof n);
            normalize(n);
            for (size_t k = 0; k < 3; k++)
                to.normals[3 * (size_t)to.vertex_count + k] = (float)n[k];
            copy_vertex(from, v, &to);
        } else {
            made[c] = made[s->table[at]];
        }
    }
    memcpy(from->indices, made, corner_count * sizeof *made);
    to.indices = from->indices;
    to.index_capacity = from->index_capacity;
    to.triangle_count = from->triangle_count;
    to.look = from->look;
    from->indices = NULL;
    from->index_capacity = 0;
    rti_part_fini(s->ctx, from);
    *from = to;
    return true;
}

bool rti_part_smooth(rt_context *ctx, rti_part *part, float crease_deg)
{
    size_t corners = 3 * (size_t)part->triangle_count, most = corners > part->vertex_count ? corners : part->vertex_count;
    if (part->normals || corners == 0 || corners >= NONE)
        return part->normals || corners == 0;
    smoother s = {.ctx = ctx, .part = part, .table_size = 16, .cos_crease = cosine_deg(crease_deg)};
    while (s.table_size < 2 * most)
        s.table_size *= 2;
    uint32_t *made = rti_alloc_array(ctx, corners, sizeof *made);
    s.weld = rti_alloc_array(ctx, part->vertex_count, sizeof *s.weld);
    s.group = rti_alloc_array(ctx, corners, sizeof *s.group);
    s.face = rti_alloc_array(ctx, corners, sizeof *s.face);
    s.sum = rti_alloc_zero(ctx, 3 * corners * sizeof *s.sum);
    s.table = rti_alloc_array(ctx, s.table_size, sizeof *s.table);
    size_t vertex_count = part->vertex_count;
    bool good = made && s.weld && s.group && s.face && s.sum && s.table;
    if (good) {
        for (uint32_t c = 0; c < corners; c++)
            s.group[c] = c;
        weld_vertices(&s);
        face_normals(&s);
        join_edges(&s);
        sum_normals(&s);
        good = rebuild(&s, made);
    }
    rti_free(ctx, made, corners * sizeof *made);
    rti_free(ctx, s.weld, vertex_count * sizeof *s.weld);
    rti_free(ctx, s.group, corners * sizeof *s.group);
    rti_free(ctx, s.face, corners * sizeof *s.face);
    rti_free(ctx, s.sum, 3 * corners * sizeof *s.sum);
    rti_free(ctx, s.table, s.table_size * sizeof *s.table);
    return good;
}
