/* Every primitive for every ray.
 *
 * Rays of one dominant axis are taken sixty-four at a time against a triangle: the first part of the leaf test, in vectors, sends
 * nearly all away; the rest meet the leaf test itself. What it sends away, the leaf test refuses too: these are its own first
 * operations (rtk_tri_intersect), and a ray that has edge functions of both signs misses. tests/variants/ holds that.
 */
#include "packet.h"

#define WIDTH 64
#define MANY  192u /* rays sorted by axis at a time: some 300 bytes of the stack each */

/* Rays of one dominant axis. */
typedef struct lanes {
    _Alignas(64) float ox[WIDTH], oy[WIDTH], oz[WIDTH], sx[WIDTH], sy[WIDTH]; /* korg, shear */
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

/* Of the rays [at, at + RTI_SIMD), those that may hit, as bits. x, y, z: the triangle's coordinates in the rays' order of axes.
 */
RTI_VEC uint32_t lanes_filter(const lanes *l, uint32_t at, const vec x[3], const vec y[3], const vec z[3])
{
    const vec ox = V(load)(l->ox + at), oy = V(load)(l->oy + at), oz = V(load)(l->oz + at);
    const vec sx = V(load)(l->sx + at), sy = V(load)(l->sy + at), zero = V(set)(0.0f);
    vec az = z[0] - oz, bz = z[1] - oz, cz = z[2] - oz;
    vec ax = (x[0] - ox) - sx * az, ay = (y[0] - oy) - sy * az;
    vec bx = (x[1] - ox) - sx * bz, by = (y[1] - oy) - sy * bz;
    vec cx = (x[2] - ox) - sx * cz, cy = (y[2] - oy) - sy * cz;
    vec u = cx * by - cy * bx, v = ax * cy - ay * cx, w = bx * ay - by * ax;
    vec low = V(min)(V(min)(u, v), w), high = V(max)(V(max)(u, v), w);
    return LANES_ALL & ~VM(bits)(VM(and)(V(lt)(low, zero), V(lt)(zero, high)));
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
RTI_VEC void lanes_flush(lanes *l, const rtk_part *part, uint32_t tris, uint32_t axis, rtk_u32 mode)
{
    const uint32_t kx = (axis + 1) % 3, ky = (axis + 2) % 3, n = l->count, end = (n + RTI_SIMD - 1) / RTI_SIMD * RTI_SIMD;
    if (n == 0)
        return;
    for (uint32_t i = n; i < end; i++) {
        l->ox[i] = l->oy[i] = l->oz[i] = 3.0e37f; /* far off, and nobody looks at what comes out */
        l->sx[i] = l->sy[i] = 0.0f;
    }
    const rtk_group *g = l->queries[0]->group;
    for (uint32_t k = 0; k < tris; k++) {
        const rtk_tri *t = &g->tris[part->all.refs ? part->all.refs[k] : k];
        const vec x[3] = {V(set)(t->v0[kx]), V(set)(t->v1[kx]), V(set)(t->v2[kx])};
        const vec y[3] = {V(set)(t->v0[ky]), V(set)(t->v1[ky]), V(set)(t->v2[ky])};
        const vec z[3] = {V(set)(t->v0[axis]), V(set)(t->v1[axis]), V(set)(t->v2[axis])};
        for (uint32_t at = 0; at < end; at += RTI_SIMD) {
            uint32_t keep = lanes_filter(l, at, x, y, z);
            for (; __builtin_expect(keep != 0, 0); keep &= keep - 1) {
                uint32_t i = at + (uint32_t)__builtin_ctz(keep);
                if (i < n && !*l->done[i])
                    *l->done[i] = rtk_query_tri(l->queries[i], mode, l->rays[i], t);
            }
        }
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
