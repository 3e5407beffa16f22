#include "polygon.h"

#include <math.h>
#include <stdbool.h>

typedef struct polygon {
    const float *positions;
    const uint32_t *corners;
    uint32_t *next, *prev, *reflex; /* reflex: 1 while the corner may lie in somebody's ear */
    unsigned ax, ay;                /* axes of the projection, in the order that makes the polygon run counterclockwise */
} polygon;

static double coord(const polygon *p, uint32_t i, unsigned axis)
{
    return p->positions[3 * (uint64_t)p->corners[i] + axis];
}

/* Twice the signed area of the corners a, b, c in the projection. */
static double orient(const polygon *p, uint32_t a, uint32_t b, uint32_t c)
{
    double ax = coord(p, a, p->ax), ay = coord(p, a, p->ay);
    return (coord(p, b, p->ax) - ax) * (coord(p, c, p->ay) - ay) - (coord(p, b, p->ay) - ay) * (coord(p, c, p->ax) - ax);
}

static bool same_place(const polygon *p, uint32_t a, uint32_t b)
{
    return coord(p, a, p->ax) == coord(p, b, p->ax) && coord(p, a, p->ay) == coord(p, b, p->ay);
}

/* Newell's normal: right for any planar polygon, and an average for others. */
static void project(polygon *p, uint32_t n)
{
    double normal[3] = {0.0, 0.0, 0.0};
    unsigned k = 0;
    for (uint32_t i = 0; i < n; i++) {
        uint32_t j = i + 1 == n ? 0 : i + 1;
        for (unsigned a = 0; a < 3; a++) {
            unsigned b = (a + 1) % 3, c = (a + 2) % 3;
            normal[a] += (coord(p, i, b) - coord(p, j, b)) * (coord(p, i, c) + coord(p, j, c));
        }
    }
    for (unsigned a = 1; a < 3; a++) {
        if (fabs(normal[a]) > fabs(normal[k]))
            k = a;
    }
    p->ax = (k + 1) % 3;
    p->ay = (k + 2) % 3;
    if (normal[k] < 0.0) {
        unsigned t = p->ax;
        p->ax = p->ay;
        p->ay = t;
    }
}

/* Convex, and no reflex corner of what is left lies in it (borders count; corners at the same place as its own do not: keyholes).
 */
static bool is_ear(const polygon *p, uint32_t b)
{
    uint32_t a = p->prev[b], c = p->next[b];
    if (!(orient(p, a, b, c) > 0.0))
        return false;
    for (uint32_t i = p->next[c]; i != a; i = p->next[i]) {
        if (!p->reflex[i] || same_place(p, i, a) || same_place(p, i, b) || same_place(p, i, c))
            continue;
        if (orient(p, a, b, i) >= 0.0 && orient(p, b, c, i) >= 0.0 && orient(p, c, a, i) >= 0.0)
            return false;
    }
    return true;
}

static uint32_t *emit(const polygon *p, uint32_t b, uint32_t *out)
{
    out[0] = p->corners[p->prev[b]];
    out[1] = p->corners[b];
    out[2] = p->corners[p->next[b]];
    return out + 3;
}

static void cut(polygon *p, uint32_t b)
{
    uint32_t a = p->prev[b], c = p->next[b];
    p->next[a] = c;
    p->prev[c] = a;
    p->reflex[a] = !(orient(p, p->prev[a], a, c) > 0.0);
    p->reflex[c] = !(orient(p, a, c, p->next[c]) > 0.0);
}

void rti_polygon_triangulate(const float *positions, const uint32_t *corners, uint32_t n, uint32_t *scratch, uint32_t *triangles)
{
    polygon p = {
        .positions = positions, .corners = corners, .next = scratch, .prev = scratch + n, .reflex = scratch + 2 * (uint64_t)n};
    uint32_t left = n, at = 0, tried = 0;
    for (uint32_t i = 0; i < n; i++) {
        p.next[i] = i + 1 == n ? 0 : i + 1;
        p.prev[i] = i == 0 ? n - 1 : i - 1;
    }
    project(&p, n);
    for (uint32_t i = 0; i < n; i++)
        p.reflex[i] = !(orient(&p, p.prev[i], i, p.next[i]) > 0.0);
    while (left > 3) {
        /* A round without an ear: the polygon crosses itself or has folded to a line. Any cut ends it. */
        if (tried < left && !is_ear(&p, at)) {
            at = p.next[at];
            tried++;
            continue;
        }
        triangles = emit(&p, at, triangles);
        cut(&p, at);
        at = p.next[p.next[at]];
        left--;
        tried = 0;
    }
    emit(&p, at, triangles);
}
