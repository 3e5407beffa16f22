/* Every primitive for every ray.
 *
 * Rays of one dominant axis are taken sixteen at a time against a triangle: the first part of the leaf test, in vectors the
 * compiler makes, sends nearly all away; the rest meet the leaf test itself. What it sends away, the leaf test refuses too: these
 * are its own first operations (rtk_tri_intersect), and a ray that has edge functions of both signs misses. tests/variants/ holds
 * that.
 */
#include "lane.h"

#define WIDTH 16
#define MANY  256u /* rays sorted by axis at a time */

/* Rays of one dominant axis. */
typedef struct lanes {
    float ox[WIDTH], oy[WIDTH], oz[WIDTH], sx[WIDTH], sy[WIDTH]; /* korg, shear */
    uint32_t count;
    rtk_pray *rays[WIDTH];
    rtk_query *queries[WIDTH];
    int *done[WIDTH]; /* any hit: nothing is asked any more */
} lanes;

static void lanes_add(lanes *l, rtk_query *q, rtk_pray *r, int *done)
{
    uint32_t i = l->count++;
    l->ox[i] = r->korg.x;
    l->oy[i] = r->korg.y;
    l->oz[i] = r->korg.z;
    l->sx[i] = r->sx;
    l->sy[i] = r->sy;
    l->rays[i] = r;
    l->queries[i] = q;
    l->done[i] = done;
}

/* keep[i] != 0 where lane i may hit; returns whether any may. x, y, z: the triangle's coordinates in the lanes' order of axes. */
static int lanes_filter(const lanes *l, const float x[3], const float y[3], const float z[3], int keep[WIDTH])
{
    int any = 0;
    for (int i = 0; i < WIDTH; i++) {
        float az = z[0] - l->oz[i], bz = z[1] - l->oz[i], cz = z[2] - l->oz[i];
        float ax = (x[0] - l->ox[i]) - l->sx[i] * az, ay = (y[0] - l->oy[i]) - l->sy[i] * az;
        float bx = (x[1] - l->ox[i]) - l->sx[i] * bz, by = (y[1] - l->oy[i]) - l->sy[i] * bz;
        float cx = (x[2] - l->ox[i]) - l->sx[i] * cz, cy = (y[2] - l->oy[i]) - l->sy[i] * cz;
        float u = cx * by - cy * bx, v = ax * cy - ay * cx, w = bx * ay - by * ax;
        float low = u < v ? u : v, high = u > v ? u : v;
        low = low < w ? low : w;
        high = high > w ? high : w;
        keep[i] = low < 0.0f ? !(high > 0.0f) : 1; /* written so that GCC 12 makes vectors of it: 16 lanes cost what one did */
    }
    for (int i = 0; i < WIDTH; i++)
        any |= keep[i];
    return any;
}

/* How many of a part's primitives are triangles: they come first in its list. */
static uint32_t tri_refs(const rtk_group *g, const rtk_part *part)
{
    uint32_t n = part->count;
    if (!part->all.refs)
        return g->tri_count;
    while (n > 0 && part->all.refs[n - 1] >= g->tri_count)
        n--;
    return n;
}

/* The rays collected for one axis against all triangles (tri_refs) of a part of the scene's own group. */
static inline void lanes_flush(lanes *l, const rtk_part *part, uint32_t tris, uint32_t axis, rtk_u32 mode)
{
    uint32_t kx = (axis + 1) % 3, ky = (axis + 2) % 3, n = l->count;
    if (n == 0)
        return;
    for (uint32_t i = n; i < WIDTH; i++) {
        l->ox[i] = l->oy[i] = l->oz[i] = 3.0e37f; /* far off, and nobody looks at what comes out */
        l->sx[i] = l->sy[i] = 0.0f;
    }
    const rtk_group *g = l->queries[0]->group;
    for (uint32_t k = 0; k < tris; k++) {
        const rtk_tri *t = &g->tris[part->all.refs ? part->all.refs[k] : k];
        float x[3] = {t->v0[kx], t->v1[kx], t->v2[kx]}, y[3] = {t->v0[ky], t->v1[ky], t->v2[ky]};
        float z[3] = {t->v0[axis], t->v1[axis], t->v2[axis]};
        int keep[WIDTH];
        if (!lanes_filter(l, x, y, z, keep))
            continue;
        for (uint32_t i = 0; i < n; i++)
            if (keep[i] && !*l->done[i])
                *l->done[i] = rtk_query_tri(l->queries[i], mode, l->rays[i], t);
    }
    for (uint32_t i = 0; i < n && (mode & RTK_MODE_STEPS); i++)
        l->queries[i]->tests += tris;
    l->count = 0;
}

#define RTI_TRACER_NAME brute
#define RTK_WALK_INL    "../kernel/brute.inl"
#define RTK_TREE        all
#define RTK_TOP_TREE    top_all
#define RTI_MODE_INL    "brute.inl"
#include "modes.inl"
