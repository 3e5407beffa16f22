#include "polygon.h"

#include <math.h>
#include <stdbool.h>

#define NONE UINT32_MAX
/* Before the rest becomes a fan: cuts without an ear, looks at all corners anew; and steps a corner. */
#define MOST_FORCED 64
#define MOST_WORK   4096u

enum {
    REFLEX = 1, /* may lie in somebody's ear */
    CUT = 2,
    QUEUED = 4,
    LATE = 8 /* when its turn comes, it goes to the end once */
};

typedef struct polygon {
    const float *positions;
    const uint32_t *corners;
    uint32_t n, left;
    uint32_t *next, *prev, *flags;
    uint32_t *queue, queue_at, queue_count; /* a ring of n */
    uint32_t *head, *chain, side;           /* corners by cell of a grid of side x side */
    double low[2], scale[2];
    uint64_t work;   /* cells and corners looked at */
    unsigned ax, ay; /* axes of the projection, in the order that makes the polygon run counterclockwise */
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
static void project(polygon *p)
{
    double normal[3] = {0.0, 0.0, 0.0};
    unsigned k = 0;
    for (uint32_t i = 0; i < p->n; i++) {
        uint32_t j = i + 1 == p->n ? 0 : i + 1;
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

/* ---- the grid ---- */

static uint32_t cell(const polygon *p, double x, unsigned k)
{
    double c = (x - p->low[k]) * p->scale[k];
    return c < (double)(p->side - 1) ? (uint32_t)c : p->side - 1;
}

static void fill_grid(polygon *p)
{
    const unsigned axes[2] = {p->ax, p->ay};
    p->side = p->n < 64 ? 1 : (uint32_t)sqrt((double)p->n);
    for (unsigned k = 0; k < 2; k++) {
        double lo = coord(p, 0, axes[k]), hi = lo;
        for (uint32_t i = 1; i < p->n; i++) {
            double x = coord(p, i, axes[k]);
            lo = x < lo ? x : lo;
            hi = x > hi ? x : hi;
        }
        p->low[k] = lo;
        p->scale[k] = hi > lo ? p->side / (hi - lo) : 0.0;
    }
    for (uint32_t i = 0; i < p->side * p->side; i++)
        p->head[i] = NONE;
    for (uint32_t i = 0; i < p->n; i++) {
        uint32_t c = cell(p, coord(p, i, p->ay), 1) * p->side + cell(p, coord(p, i, p->ax), 0);
        p->chain[i] = p->head[c];
        p->head[c] = i;
    }
}

/* A reflex corner of the cell lies in the triangle a, b, c (borders count; corners at the same place as its own do not:
 * keyholes). */
static bool cell_blocks(polygon *p, uint32_t at, uint32_t a, uint32_t b, uint32_t c)
{
    p->work++;
    for (uint32_t i = p->head[at]; i != NONE; i = p->chain[i]) {
        p->work++;
        if (!(p->flags[i] & REFLEX) || same_place(p, i, a) || same_place(p, i, b) || same_place(p, i, c))
            continue;
        if (orient(p, a, b, i) >= 0.0 && orient(p, b, c, i) >= 0.0 && orient(p, c, a, i) >= 0.0)
            return true;
    }
    return false;
}

/* Columns of the grid that the triangle t (in cells) reaches within a row, a little more for rounding. */
static void columns(const polygon *p, double t[3][2], uint32_t row, uint32_t *from, uint32_t *to)
{
    double y0 = row - 0.01, y1 = row + 1.01, lo = p->side, hi = 0.0;
    for (unsigned k = 0; k < 3; k++) {
        const double *a = t[k], *b = t[k == 2 ? 0 : k + 1];
        double slope = a[1] == b[1] ? 0.0 : (b[0] - a[0]) / (b[1] - a[1]);
        if ((a[1] < y0 && b[1] < y0) || (a[1] > y1 && b[1] > y1))
            continue;
        double xa = a[1] < y0 ? a[0] + slope * (y0 - a[1]) : a[1] > y1 ? a[0] + slope * (y1 - a[1]) : a[0];
        double xb = b[1] < y0 ? a[0] + slope * (y0 - a[1]) : b[1] > y1 ? a[0] + slope * (y1 - a[1]) : b[0];
        lo = xa < lo ? xa : lo;
        lo = xb < lo ? xb : lo;
        hi = xa > hi ? xa : hi;
        hi = xb > hi ? xb : hi;
    }
    *from = lo > 0.01 ? (uint32_t)(lo - 0.01) : 0;
    *to = hi + 0.01 < p->side ? (uint32_t)(hi + 0.01) : p->side - 1;
}

/* Convex, and no reflex corner of what is left lies in it. */
static bool is_ear(polygon *p, uint32_t b)
{
    const uint32_t corners[3] = {p->prev[b], b, p->next[b]};
    double t[3][2], low, high;
    if (!(orient(p, corners[0], b, corners[2]) > 0.0))
        return false;
    for (unsigned k = 0; k < 3; k++) {
        t[k][0] = (coord(p, corners[k], p->ax) - p->low[0]) * p->scale[0];
        t[k][1] = (coord(p, corners[k], p->ay) - p->low[1]) * p->scale[1];
    }
    low = high = t[0][1];
    for (unsigned k = 1; k < 3; k++) {
        low = t[k][1] < low ? t[k][1] : low;
        high = t[k][1] > high ? t[k][1] : high;
    }
    uint32_t last = high < p->side ? (uint32_t)high : p->side - 1;
    for (uint32_t row = low < p->side ? (uint32_t)low : p->side - 1; row <= last; row++) {
        uint32_t from, to;
        columns(p, t, row, &from, &to);
        for (uint32_t column = from; column <= to; column++)
            if (cell_blocks(p, row * p->side + column, corners[0], b, corners[2]))
                return false;
    }
    return true;
}

/* ---- cutting ---- */

static void enqueue(polygon *p, uint32_t i)
{
    uint32_t at = p->queue_at + p->queue_count;
    if (p->flags[i] & QUEUED)
        return;
    p->flags[i] |= QUEUED;
    p->queue[at < p->n ? at : at - p->n] = i;
    p->queue_count++;
}

static uint32_t dequeue(polygon *p)
{
    uint32_t i = p->queue[p->queue_at];
    p->queue_at = p->queue_at + 1 == p->n ? 0 : p->queue_at + 1;
    p->queue_count--;
    p->flags[i] &= ~(uint32_t)QUEUED;
    return i;
}

static uint32_t *emit(const polygon *p, uint32_t b, uint32_t *out)
{
    out[0] = p->corners[p->prev[b]];
    out[1] = p->corners[b];
    out[2] = p->corners[p->next[b]];
    return out + 3;
}

static void judge(polygon *p, uint32_t i)
{
    bool convex = orient(p, p->prev[i], i, p->next[i]) > 0.0;
    p->flags[i] = (p->flags[i] & ~(uint32_t)REFLEX) | (convex ? 0u : REFLEX);
}

static uint32_t *cut(polygon *p, uint32_t b, uint32_t *triangles)
{
    uint32_t a = p->prev[b], c = p->next[b];
    triangles = emit(p, b, triangles);
    p->next[a] = c;
    p->prev[c] = a;
    p->flags[b] = CUT;
    p->left--;
    judge(p, a);
    judge(p, c);
    enqueue(p, a);
    enqueue(p, c);
    p->flags[c] |= LATE;
    return triangles;
}

static void begin(polygon *p, uint32_t *scratch)
{
    p->next = scratch;
    p->prev = scratch + p->n;
    p->flags = scratch + 2 * (uint64_t)p->n;
    p->queue = scratch + 3 * (uint64_t)p->n;
    p->chain = scratch + 4 * (uint64_t)p->n;
    p->head = scratch + 5 * (uint64_t)p->n;
    for (uint32_t i = 0; i < p->n; i++) {
        p->next[i] = i + 1 == p->n ? 0 : i + 1;
        p->prev[i] = i == 0 ? p->n - 1 : i - 1;
        p->flags[i] = 0;
    }
    project(p);
    fill_grid(p);
    for (uint32_t i = 0; i < p->n; i++) {
        judge(p, i);
        enqueue(p, i);
    }
}

void rti_polygon_triangulate(const float *positions, const uint32_t *corners, uint32_t n, uint32_t *scratch, uint32_t *triangles)
{
    polygon p = {.positions = positions, .corners = corners, .n = n, .left = n};
    uint32_t at = 0, forced = 0;
    bool progress = false;
    begin(&p, scratch);
    while (p.left > 3) {
        if (p.queue_count == 0 && forced++ < MOST_FORCED) {
            /* Corners on one line can hide an ear until they are gone: look again. Nothing new: the polygon crosses itself or has
             * folded to a line, and any cut helps it on. */
            if (!progress)
                triangles = cut(&p, at, triangles);
            for (uint32_t i = 0, k = p.next[at]; i < p.left; i++, k = p.next[k])
                enqueue(&p, k);
            at = p.next[at];
            progress = false;
            continue;
        }
        if (p.queue_count == 0 || p.work > (uint64_t)MOST_WORK * n)
            break;
        uint32_t b = dequeue(&p);
        if (p.flags[b] & CUT)
            continue;
        if (p.flags[b] & LATE) {
            p.flags[b] &= ~(uint32_t)LATE;
            enqueue(&p, b);
        } else if (is_ear(&p, b)) {
            triangles = cut(&p, b, triangles);
            at = p.next[b];
            progress = true;
        }
    }
    for (; p.left > 3; at = p.next[at])
        triangles = cut(&p, at, triangles);
    emit(&p, at, triangles);
}
