/* One ray, one hit, the order of hits, and how a ray is made ready for a group of primitives.
 *
 * The theory every tracer rests on (the promise: any tracer returns brute force's hits, bit for bit):
 *
 *  1. The leaf test is a pure function of (prepared ray, primitive). It knows no cell, no neighbour, no best hit so far.
 *  2. It is accurate: the point org + t dir of an accepted hit lies within RTK_DELTA * scale of the primitive (for shapes: of
 *     the primitive's box; a root outside it is refused by the test itself). scale is the largest absolute coordinate of the
 *     group's bounds; a prepared ray's origin is never farther out than 4 scale, because a farther one is first moved to the
 *     group's box (tshift). Brute force does the same, for the step is part of the group, not of a tracer.
 *  3. Trees bound every primitive by a box grown by RTK_GROW * scale on all sides; a builder that clips clips to the cell grown by
 *     as much. RTK_GROW exceeds RTK_DELTA plus the rounding of (plane - org) * inv, or, where it is far from underflow, of
 *     plane * inv - org * inv. So a hit's point lies well inside every grown box and every cell interval that has to hold it, and
 *     neither a slab test nor a walk can lose it: no epsilon in a tracer.
 *  4. A walk that splits [t0, t1] at t = (plane - org) * inv visits cells whose intervals tile the ray exactly; the leaf
 *     whose interval holds t lists the primitive. It may stop at a cell when best.t < t1, a cull is `enter <= best.t`.
 *  5. Equal t: (t, instance, geometry, primitive) in description order decides.
 *  6. Point 3 makes boxes as coarse as the group is large. A group that also holds far smaller things is cut into parts of about one
 *     scale each, with bounds, scale and trees of their own; above, "group" is then to be read as "part", and brute force too
 *     prepares a ray for each part. Primitives that share a vertex are in one part: neighbours meet the same prepared ray, so no
 *     ray passes between them.
 *  7. All this counts roundings, not what falls out of the floats' range. So no scale is below RTK_LEAST: the margins of points 2
 *     and 3 are then 3.8e-21 or more, far above what products lose that are denormal (2^-150 each, times a direction of 10^18 at
 *     most). Geometry of less than 1e-20 is in every ray's way, which is slow, but no tracer loses any of it.
 */
#ifndef RTK_RAY_H
#define RTK_RAY_H

#include "twofloat.h"
#include "vec.h"

#define RTK_DELTA   3.8146973e-06f /* 2^-18: 64 roundings of a coordinate of size scale; what is proved in triangle.h needs 59 */
#define RTK_GROW    7.6293945e-06f /* 2^-17 */
#define RTK_FAR     4.0f           /* of point 2 */
#define RTK_LEAST   1.0e-15f       /* of point 7 */
#define RTK_INV_MAX 1.0e30f

/* A ray as a caller gives it (world or object space). */
typedef struct rtk_ray {
    rtk_vec3 org, dir;
    float tmin, tmax;
    rtk_u32 mask;
} rtk_ray;

typedef struct rtk_hit {
    float t, u, v;
    rtk_u32 prim, geom, inst;
} rtk_hit;

/* A ray prepared for one part of a group. t of the part's primitives = tshift + (t along org). kx, ky, kz and sx, sy: axes and shear of
 * Woop, Benthin, Wald 2013; korg: org in the order kx, ky, kz; kdz: dir along kz. t0, t1: the part inside the group's grown box
 * and [tmin, tmax], measured from org. */
typedef struct rtk_pray {
    rtk_vec3 org, dir, inv;
    float tmin, tmax; /* as given, in the caller's t */
    float tshift;
    float t0, t1;
    float sx, sy, kdz;
    rtk_vec3 korg;
    float scale;
    rtk_u32 kx, ky, kz;
    rtk_u32 mask;
} rtk_pray;

/* The point at t, each coordinate rounded once. */
RTK_FN rtk_vec3 rtk_ray_at(rtk_ray r, float t)
{
    return rtk_v3(rtk_ff_along(r.org.x, t, r.dir.x), rtk_ff_along(r.org.y, t, r.dir.y), rtk_ff_along(r.org.z, t, r.dir.z));
}

RTK_FN rtk_hit rtk_hit_none(float tmax)
{
    rtk_hit h;
    h.t = tmax;
    h.u = 0.0f;
    h.v = 0.0f;
    h.prim = RTK_INVALID;
    h.geom = RTK_INVALID;
    h.inst = RTK_INVALID;
    return h;
}

/* The order of hits. inst + 1: geometry of the scene itself (RTK_INVALID) comes before instance 0. */
RTK_FN int rtk_hit_less(float ta, rtk_u32 insta, rtk_u32 geoma, rtk_u32 prima, float tb, rtk_u32 instb, rtk_u32 geomb,
                        rtk_u32 primb)
{
    if (ta != tb)
        return ta < tb;
    if (insta != instb)
        return insta + 1u < instb + 1u;
    if (geoma != geomb)
        return geoma < geomb;
    return prima < primb;
}

RTK_FN int rtk_finite(float x)
{
    return rtk_fabs(x) <= 3.402823466e38f;
}

/* A direction's largest component is to lie in this range: below, t would leave the floats' range, and a component that counts as
 * zero in rtk_inverse would still move the ray by more than RTK_DELTA. */
#define RTK_DIR_MIN 1.0e-18f
#define RTK_DIR_MAX 1.0e18f

/* Are a valid ray's inverse, and its origin times that where it starts near a part of such a scale, far from the ends of the
 * floats' range? (RTK_FAR scale RTK_INV_MAX <= BVH_START_MOST, and scale / RTK_DIR_MAX >= BVH_START_LEAST.) */
RTK_FN int rtk_scale_ordinary(float scale) { return scale >= 2.0e-17f && scale <= 2.0e6f; }

/* Zero, denormal, infinite or NaN directions and origins, a NaN range and tmin >= tmax: such a ray misses everything, everywhere.
 */
RTK_FN int rtk_ray_valid(rtk_ray r)
{
    float m = rtk_maxabs(r.dir);
    return rtk_finite(r.org.x) && rtk_finite(r.org.y) && rtk_finite(r.org.z) && rtk_finite(r.dir.x) && rtk_finite(r.dir.y) &&
           rtk_finite(r.dir.z) && m >= RTK_DIR_MIN && m <= RTK_DIR_MAX && r.tmin < r.tmax;
}

/* 1 / d, kept finite: a zero or tiny component counts as +-1e-30, by its sign bit. */
RTK_FN float rtk_inverse(float d)
{
    return rtk_fabs(d) < 1.0e-30f ? rtk_copysign(RTK_INV_MAX, d) : rtk_clamp(1.0f / d, -RTK_INV_MAX, RTK_INV_MAX);
}

/* Interval of the ray in the box [lo, hi], one expression for every tracer: (plane - org) * inv. Empty when *t0 > *t1. */
RTK_FN void rtk_slab(rtk_vec3 org, rtk_vec3 inv, rtk_vec3 lo, rtk_vec3 hi, float *t0, float *t1)
{
    float a, b;
    a = (lo.x - org.x) * inv.x;
    b = (hi.x - org.x) * inv.x;
    *t0 = rtk_max(*t0, rtk_min(a, b));
    *t1 = rtk_min(*t1, rtk_max(a, b));
    a = (lo.y - org.y) * inv.y;
    b = (hi.y - org.y) * inv.y;
    *t0 = rtk_max(*t0, rtk_min(a, b));
    *t1 = rtk_min(*t1, rtk_max(a, b));
    a = (lo.z - org.z) * inv.z;
    b = (hi.z - org.z) * inv.z;
    *t0 = rtk_max(*t0, rtk_min(a, b));
    *t1 = rtk_min(*t1, rtk_max(a, b));
}

/* Moves a far origin along the ray to near the group's middle. A step is exact but for one rounding of the new origin, so the
 * moved ray is the given one; a second step takes up what the first one's rounded length left. 0: the ray stays far away. */
RTK_COLD int rtk_ray_approach(rtk_vec3 dir, rtk_vec3 lo, rtk_vec3 hi, float scale, rtk_vec3 *org, float *shift)
{
    float m = rtk_maxabs(dir);
    rtk_vec3 d = rtk_v3(dir.x / m, dir.y / m, dir.z / m);
    rtk_vec3 mid = rtk_v3(0.5f * (lo.x + hi.x), 0.5f * (lo.y + hi.y), 0.5f * (lo.z + hi.z));
    int k;
    for (k = 0; k < 6 && !(rtk_maxabs(*org) <= RTK_FAR * scale); k++) {
        float step = rtk_dot3(rtk_sub(mid, *org), d) / rtk_dot3(d, d) / m;
        *org = rtk_v3(rtk_ff_along(org->x, step, dir.x), rtk_ff_along(org->y, step, dir.y), rtk_ff_along(org->z, step, dir.z));
        *shift += step;
    }
    return rtk_finite(org->x + org->y + org->z) && rtk_finite(*shift) && rtk_maxabs(*org) <= RTK_FAR * scale;
}

/* Does a ray that starts far away miss a box for certain, whatever moving its origin does to it? The slabs are good to some 2^-22 of
 * the way there, and so is the moved ray; the box is grown by sixteen times that. */
#define RTK_PASSES 3.8146973e-06f
RTK_FN int rtk_ray_passes(rtk_ray r, rtk_vec3 inv, rtk_vec3 lo, rtk_vec3 hi, float scale)
{
    float grow = RTK_PASSES * (rtk_maxabs(r.org) + scale), t0 = -RTK_INF, t1 = RTK_INF;
    rtk_slab(r.org, inv, rtk_v3(lo.x - grow, lo.y - grow, lo.z - grow), rtk_v3(hi.x + grow, hi.y + grow, hi.z + grow), &t0, &t1);
    return t1 < t0 || (t1 < 0.0f && r.tmin >= 0.0f);
}

/* Makes a valid ray ready for a group with grown bounds [lo, hi] and the given scale. Returns 0 when the ray misses the
 * bounds inside (tmin, tmax): then it misses the group, by definition and for every tracer.  */
RTK_INLINE int rtk_ray_prepare_here(rtk_ray r, rtk_vec3 lo, rtk_vec3 hi, float scale, rtk_pray *out)
{
    float t0 = -RTK_INF, t1 = RTK_INF, shift = 0.0f;
    rtk_vec3 org = r.org, inv = rtk_v3(rtk_inverse(r.dir.x), rtk_inverse(r.dir.y), rtk_inverse(r.dir.z));
    rtk_vec3 a = rtk_vabs(r.dir);
    if (rtk_maxabs(org) > RTK_FAR * scale &&
        (rtk_ray_passes(r, inv, lo, hi, scale) || !rtk_ray_approach(r.dir, lo, hi, scale, &org, &shift)))
        return 0;
    rtk_slab(org, inv, lo, hi, &t0, &t1);
    if (!(t0 <= t1) || shift + t1 < r.tmin || shift + t0 > r.tmax)
        return 0;
    out->org = org;
    out->dir = r.dir;
    out->inv = inv;
    out->tmin = r.tmin;
    out->tmax = r.tmax;
    out->tshift = shift;
    out->t0 = t0;
    out->t1 = t1;
    if (shift == 0.0f) {
        out->t0 = rtk_max(t0, r.tmin);
        out->t1 = rtk_min(t1, r.tmax);
    }
    out->scale = scale;
    out->mask = r.mask;
    if (a.x > a.y && a.x > a.z) {
        out->kz = 0u;
        out->kx = 1u;
        out->ky = 2u;
    } else if (a.y > a.z) {
        out->kz = 1u;
        out->kx = 2u;
        out->ky = 0u;
    } else {
        out->kz = 2u;
        out->kx = 0u;
        out->ky = 1u;
    }
    /* The winding does not matter: triangles are double-sided, and the geometric normal is taken from the vertices. */
    out->korg = rtk_v3(rtk_axis(org, out->kx), rtk_axis(org, out->ky), rtk_axis(org, out->kz));
    out->kdz = rtk_axis(r.dir, out->kz);
    out->sx = rtk_axis(r.dir, out->kx) / out->kdz;
    out->sy = rtk_axis(r.dir, out->ky) / out->kdz;
    return 1;
}

RTK_FN int rtk_ray_prepare(rtk_ray r, rtk_vec3 lo, rtk_vec3 hi, float scale, rtk_pray *out)
{
    return rtk_ray_prepare_here(r, lo, hi, scale, out);
}

#endif
