/* References: primitives' boxes at the root, and what is left of them in the two halves of a cell.
 *
 * A triangle belongs to a cell when it touches the cell grown by `grow`: then a leaf test that errs by RTK_DELTA * scale, and a
 * plane distance that is rounded, still find it there (kernel/ray.h). So triangles are clipped to the grown cell, in double: the
 * clip itself must not use up what growth is left.
 */
#include <math.h>
#include <string.h>

#include "build.h"

#define MAX_VERTS 10 /* a triangle cut by six planes, and one to spare */

typedef double polygon[MAX_VERTS][3];

/* Sutherland and Hodgman 1974: the part with sign * (x - at) >= 0. A polygon that has shrunk to a segment or a point is kept. */
static int clip_plane(const polygon in, int n, int axis, double at, double sign, polygon out)
{
    int m = 0;
    for (int i = 0; i < n; i++) {
        const double *p = in[i], *q = in[i + 1 == n ? 0 : i + 1];
        double dp = sign * (p[axis] - at), dq = sign * (q[axis] - at);
        if (dp >= 0.0 && m < MAX_VERTS)
            memcpy(out[m++], p, sizeof(double[3]));
        if (((dp < 0.0 && dq > 0.0) || (dp > 0.0 && dq < 0.0)) && m < MAX_VERTS) {
            double t = dp / (dp - dq);
            for (int k = 0; k < 3; k++)
                out[m][k] = p[k] + t * (q[k] - p[k]);
            out[m++][axis] = at;
        }
    }
    return m;
}

/* Clips to [lo, hi] where the polygon's own box says that it can matter. Returns which buffer holds the result. */
static int clip_cell(polygon bufs[2], int *n, const double lo[3], const double hi[3])
{
    int now = 0;
    for (int a = 0; a < 3; a++) {
        double mn = HUGE_VAL, mx = -HUGE_VAL;
        for (int i = 0; i < *n; i++) {
            mn = bufs[now][i][a] < mn ? bufs[now][i][a] : mn;
            mx = bufs[now][i][a] > mx ? bufs[now][i][a] : mx;
        }
        if (mn < lo[a]) {
            *n = clip_plane((const double(*)[3])bufs[now], *n, a, lo[a], 1.0, bufs[1 - now]);
            now = 1 - now;
        }
        if (mx > hi[a]) {
            *n = clip_plane((const double(*)[3])bufs[now], *n, a, hi[a], -1.0, bufs[1 - now]);
            now = 1 - now;
        }
    }
    return now;
}

/* A triangle clipped to a cell, grown. Returns which buffer holds the result, of *n vertices. */
static int clip_triangle(const rti_build *b, const rti_cell *cell, uint32_t prim, polygon bufs[2], int *n)
{
    const rtk_tri *tri = &b->in->tris[prim];
    const double grow = b->in->grow;
    double lo[3], hi[3];
    for (int a = 0; a < 3; a++) {
        bufs[0][0][a] = tri->v0[a];
        bufs[0][1][a] = tri->v1[a];
        bufs[0][2][a] = tri->v2[a];
        lo[a] = cell->lo[a] - grow;
        hi[a] = cell->hi[a] + grow;
    }
    *n = 3;
    return clip_cell(bufs, n, lo, hi);
}

/* The polygon's box, grown and cut to the cell. */
static bool polygon_box(const polygon p, int n, float grow, const float cell_lo[3], const float cell_hi[3], rti_ref *out)
{
    if (n == 0)
        return false;
    for (int a = 0; a < 3; a++) {
        double mn = p[0][a], mx = p[0][a];
        for (int i = 1; i < n; i++) {
            mn = p[i][a] < mn ? p[i][a] : mn;
            mx = p[i][a] > mx ? p[i][a] : mx;
        }
        float lo = (float)(mn - grow), hi = (float)(mx + grow);
        out->lo[a] = lo > cell_lo[a] ? lo : cell_lo[a];
        out->hi[a] = hi < cell_hi[a] ? hi : cell_hi[a];
        if (!(out->lo[a] < out->hi[a]))
            return false;
    }
    return true;
}

static bool own_box(const rti_build_input *in, uint32_t prim, float lo[3], float hi[3])
{
    bool finite = true;
    for (int a = 0; a < 3; a++) {
        if (prim < in->tri_count) {
            const rtk_tri *t = &in->tris[prim];
            lo[a] = rtk_min(rtk_min(t->v0[a], t->v1[a]), t->v2[a]);
            hi[a] = rtk_max(rtk_max(t->v0[a], t->v1[a]), t->v2[a]);
            finite = finite && rtk_finite(t->v0[a]) && rtk_finite(t->v1[a]) && rtk_finite(t->v2[a]);
        } else {
            lo[a] = in->boxes[prim - in->tri_count][a];
            hi[a] = in->boxes[prim - in->tri_count][a + 3];
            finite = finite && rtk_finite(lo[a]) && rtk_finite(hi[a]);
        }
    }
    return finite;
}

bool rti_ref_root(const rti_build *b, uint32_t prim, rti_ref *out)
{
    const rti_build_input *in = b->in;
    float lo[3], hi[3];
    bool ok = own_box(in, prim, lo, hi);
    for (int a = 0; a < 3; a++) {
        out->lo[a] = rtk_max(lo[a] - in->grow, in->lo[a]);
        out->hi[a] = rtk_min(hi[a] + in->grow, in->hi[a]);
        ok = ok && out->lo[a] < out->hi[a];
    }
    out->prim = prim;
    out->pad = 0;
    return ok;
}

/* Boxes of the triangle's parts on the two sides of the plane, each cut to what its reference was: a clip to the whole cell parts
 * more, but this is quick and lists too much at worst. Only the bounds across the other two axes change. */
static unsigned cut_plane(const rti_build *b, const rti_ref *ref, unsigned axis, float pos, rti_ref *left, rti_ref *right)
{
    const rtk_tri *tri = &b->in->tris[ref->prim];
    const float *verts[3] = {tri->v0, tri->v1, tri->v2};
    unsigned across[2] = {(axis + 1) % 3, (axis + 2) % 3}, sides = 0;
    double grow = b->in->grow, x[3], w[3][2];
    for (int i = 0; i < 3; i++) {
        x[i] = verts[i][axis];
        w[i][0] = verts[i][across[0]];
        w[i][1] = verts[i][across[1]];
    }
    for (unsigned side = 0; side < 2; side++) {
        double at = side == 0 ? pos + grow : pos - grow, lo[2] = {HUGE_VAL, HUGE_VAL}, hi[2] = {-HUGE_VAL, -HUGE_VAL};
        rti_ref *out = side == 0 ? left : right;
        bool in[3], empty = false;
        for (int i = 0; i < 3; i++) {
            in[i] = side == 0 ? x[i] <= at : x[i] >= at;
            for (int k = 0; k < 2 && in[i]; k++) {
                lo[k] = w[i][k] < lo[k] ? w[i][k] : lo[k];
                hi[k] = w[i][k] > hi[k] ? w[i][k] : hi[k];
            }
        }
        for (int i = 0; i < 3; i++) {
            int j = i == 2 ? 0 : i + 1;
            if (in[i] == in[j])
                continue;
            double t = (at - x[i]) / (x[j] - x[i]);
            for (int k = 0; k < 2; k++) {
                double p = w[i][k] + t * (w[j][k] - w[i][k]);
                lo[k] = p < lo[k] ? p : lo[k];
                hi[k] = p > hi[k] ? p : hi[k];
            }
        }
        *out = *ref;
        (side == 0 ? out->hi : out->lo)[axis] = pos;
        for (int k = 0; k < 2; k++) {
            float low = (float)(lo[k] - grow), high = (float)(hi[k] + grow);
            out->lo[across[k]] = rtk_max(low, ref->lo[across[k]]);
            out->hi[across[k]] = rtk_min(high, ref->hi[across[k]]);
            empty |= !(out->lo[across[k]] < out->hi[across[k]]);
        }
        sides |= (unsigned)!empty << side;
    }
    return sides;
}

unsigned rti_ref_cut(const rti_build *b, const rti_cell *cell, const rti_ref *ref, unsigned axis, float pos, bool clip,
                     rti_ref *left, rti_ref *right)
{
    left->prim = right->prim = ref->prim;
    left->pad = right->pad = 0;
    if (!clip || ref->prim >= b->in->tri_count) {
        *left = *right = *ref;
        left->hi[axis] = pos;
        right->lo[axis] = pos;
        return 3;
    }
    if (b->builder == RTI_BUILD_KD_BINNED)
        return cut_plane(b, ref, axis, pos, left, right);
    const double grow = b->in->grow;
    polygon bufs[2], half;
    float mid_lo[3], mid_hi[3];
    int n;
    const int at = clip_triangle(b, cell, ref->prim, bufs, &n);
    memcpy(mid_lo, cell->lo, sizeof mid_lo);
    memcpy(mid_hi, cell->hi, sizeof mid_hi);
    mid_lo[axis] = pos;
    mid_hi[axis] = pos;
    unsigned sides = 0;
    int m = clip_plane((const double(*)[3])bufs[at], n, (int)axis, pos + grow, -1.0, half);
    if (polygon_box((const double(*)[3])half, m, b->in->grow, cell->lo, mid_hi, left))
        sides |= 1;
    m = clip_plane((const double(*)[3])bufs[at], n, (int)axis, pos - grow, 1.0, half);
    if (polygon_box((const double(*)[3])half, m, b->in->grow, mid_lo, cell->hi, right))
        sides |= 2;
    return sides;
}

bool rti_ref_clip(const rti_build *b, const rti_cell *cell, uint32_t prim, rti_ref *out)
{
    polygon bufs[2];
    int n;
    const int at = clip_triangle(b, cell, prim, bufs, &n);
    out->prim = prim;
    out->pad = 0;
    return polygon_box((const double(*)[3])bufs[at], n, b->in->grow, cell->lo, cell->hi, out);
}

#define ROOT_CHUNK 16384u

typedef struct root_job {
    const rti_build *b;
    rti_ref *refs;
    uint32_t *kept; /* a chunk */
} root_job;

static void root_task(void *data, uint32_t index)
{
    root_job *job = data;
    uint32_t begin = index * ROOT_CHUNK, end = begin + ROOT_CHUNK, kept = 0;
    end = end < job->b->prim_count ? end : job->b->prim_count;
    for (uint32_t i = begin; i < end && !rti_cancelled(job->b->cancel); i++)
        if (rti_ref_root(job->b, i, &job->refs[begin + kept]))
            kept++;
    job->kept[index] = kept;
}

rti_ref *rti_refs_root(rt_context *ctx, const rti_build *b, uint32_t *count)
{
    uint32_t chunks = (uint32_t)(((uint64_t)b->prim_count + ROOT_CHUNK - 1) / ROOT_CHUNK), n = 0;
    rti_ref *refs = rti_alloc_array(ctx, b->prim_count, sizeof *refs);
    uint32_t *kept = rti_alloc_array(ctx, chunks, sizeof *kept);
    root_job job = {b, refs, kept};
    if (refs && kept) {
        rti_parallel(ctx, chunks, root_task, &job);
        for (uint32_t c = 0; c < chunks; c++) {
            memmove(refs + n, refs + (size_t)c * ROOT_CHUNK, kept[c] * sizeof *refs);
            n += kept[c];
        }
    } else {
        rti_free(ctx, refs, b->prim_count * sizeof *refs);
        refs = NULL;
    }
    rti_free(ctx, kept, chunks * sizeof *kept);
    *count = n;
    return refs;
}
