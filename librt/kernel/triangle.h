/* Ray and triangle: Woop, Benthin, Wald 2013 ("Watertight Ray/Triangle Intersection"), double-sided, in floats only.
 *
 * What differs: an edge function that comes out zero is decided exactly with integers and floats (the paper uses double), and a
 * hit whose float weights are too rough is computed again in doubled floats, so that theory point 2 of ray.h holds.
 *
 * Watertight. Shared vertices shear to the same (x, y) in every triangle. An edge function is fl(fl(a b) - fl(c d)); rounding
 * is monotone, so it never has the wrong sign; it can only be zero wrongly, and then rtk_compare_products gives the true sign.
 * So every sign is that of the exact edge function of the sheared vertices, neighbours agree on their edge, and what they cover
 * is the exact image of the mesh. Zero counts as inside.
 *
 * Accurate. u = 2^-24, S = scale, |vertex| <= S, |org| <= 4 S, so |vertex - org| <= R = 5 S. Let b be the weights (exact for the
 * sheared vertices) and Q = sum b v, a point of the triangle. Along kx, what separates the ray's line at Q's depth from Q:
 * rounding of v - org (5 uS), of the shear's slope (5), of the product (5) and of the difference (2): 17 uS. In depth, doubled:
 * rounding of z and of z / dz, 10 uS; the depths' own rounding, 5, moves Q along kz only. In depth, fast: E more, with
 * E <= u (9 B + (6 B + 4 D) q), D the depth span, B = b |bz - az| + c |cz - az|, q = max|x| max|y| / |det|: 4 D q comes from V
 * and W (2 u max|x| max|y| each, at depths of at most D), 6 B q from det, 9 B from the roundings of det, 1 / det, weights, depths
 * and sums (one more of each is allowed for below). The fast result stands only when E <= 32 uS. Slopes are at most 1, so the sum
 * is 17 + 10 + 32 = 59 uS < RTK_DELTA * S = 64 uS. The weights are as good: a point put together with them strays inside the
 * triangle by at most 128 uS.
 *
 * Products that underflow add 6 2^-150 to det, V and W: where |det| is less than RTK_TRI_LEAST the fast result is not looked at.
 *
 * Near a huge triangle all that still leaves t with an error of some uS, many times t itself. So E <= 64 u |z| is asked too, and
 * the doubled path takes the depth of the true plane, good to about 1e-6 of itself, where it is within 32 uS of the first one
 * (again 59): where it is not, the ray grazes, and the plane is met outside of the triangle.
 */
#ifndef RTK_TRIANGLE_H
#define RTK_TRIANGLE_H

#include "snapshot.h"

#define RTK_TRI_LEAST 7.5231638e-37f /* 2^-120: |det| from which on what underflows in it is 2^-27 of it */
#define RTK_TRI_MORE  1.073741824e9f /* 2^30 */
#define RTK_TRI_PLANE 1.9073486e-06f /* 2^-19, of scale: how far from the sheared depth the plane's may be that stands for it */

/* The three sheared vertices, relative to the origin, and what comes of them: depth along kz, weights of vertices 1 and 2. */
typedef struct rtk_sheared {
    float ax, ay, az, bx, by, bz, cx, cy, cz;
    float z, b, c;
} rtk_sheared;

/* v - org exactly, in the order kx, ky, kz. */
typedef struct rtk_ff3 {
    rtk_ff x, y, z;
} rtk_ff3;

RTK_FN rtk_ff3 rtk_ff3_sub(RT_GLOBAL const float *v, rtk_u32 kx, rtk_u32 ky, rtk_u32 kz, float ox, float oy, float oz)
{
    rtk_ff3 r;
    r.x = rtk_two_diff(v[kx], ox);
    r.y = rtk_two_diff(v[ky], oy);
    r.z = rtk_two_diff(v[kz], oz);
    return r;
}

/* Depth at which the ray meets the triangle's plane, all in doubled floats; NaN when parallel. */
RTK_COLD float rtk_tri_plane_depth(const rtk_pray *r, RT_GLOBAL const rtk_tri *tri)
{
    float ax = tri->v0[r->kx], ay = tri->v0[r->ky], az = tri->v0[r->kz];
    rtk_ff3 o = rtk_ff3_sub(tri->v0, r->kx, r->ky, r->kz, r->korg.x, r->korg.y, r->korg.z);
    rtk_ff3 e = rtk_ff3_sub(tri->v1, r->kx, r->ky, r->kz, ax, ay, az);
    rtk_ff3 f = rtk_ff3_sub(tri->v2, r->kx, r->ky, r->kz, ax, ay, az);
    rtk_ff nx = rtk_ff_cross(e.y, f.z, e.z, f.y), ny = rtk_ff_cross(e.z, f.x, e.x, f.z), nz = rtk_ff_cross(e.x, f.y, e.y, f.x);
    rtk_ff num = rtk_ff_add(rtk_ff_add(rtk_ff_mul(nx, o.x), rtk_ff_mul(ny, o.y)), rtk_ff_mul(nz, o.z));
    rtk_ff den = rtk_ff_add(rtk_ff_add(rtk_ff_scale(nx, rtk_axis(r->dir, r->kx)), rtk_ff_scale(ny, rtk_axis(r->dir, r->ky))),
                            rtk_ff_scale(nz, r->kdz));
    return rtk_ff_quotient(num, den) * r->kdz;
}

/* The whole test again in doubled floats, x and y scaled to about 1, and by RTK_TRI_MORE, so that products keep what counts:
 * where a corner is denormal beside others, |det| may be 2^-173 of the greatest |x| |y|. */
RTK_COLD int rtk_tri_exact(const rtk_pray *r, RT_GLOBAL const rtk_tri *tri, rtk_sheared *s)
{
    float kx = rtk_normaliser(rtk_max(rtk_max(rtk_fabs(s->ax), rtk_fabs(s->bx)), rtk_fabs(s->cx)));
    float ky = rtk_normaliser(rtk_max(rtk_max(rtk_fabs(s->ay), rtk_fabs(s->by)), rtk_fabs(s->cy)));
    int su = rtk_compare_products(s->cx, s->by, s->cy, s->bx);
    int sv = rtk_compare_products(s->ax, s->cy, s->ay, s->cx);
    int sw = rtk_compare_products(s->bx, s->ay, s->by, s->ax);
    rtk_ff u, v, w, det, num, depth;
    float ax, ay, bx, by, cx, cy, z;
    if ((su < 0 || sv < 0 || sw < 0) && (su > 0 || sv > 0 || sw > 0))
        return 0;
    ax = s->ax * RTK_TRI_MORE * kx;
    bx = s->bx * RTK_TRI_MORE * kx;
    cx = s->cx * RTK_TRI_MORE * kx;
    ay = s->ay * RTK_TRI_MORE * ky;
    by = s->by * RTK_TRI_MORE * ky;
    cy = s->cy * RTK_TRI_MORE * ky;
    u = rtk_ff_diff_products(cx, by, cy, bx);
    v = rtk_ff_diff_products(ax, cy, ay, cx);
    w = rtk_ff_diff_products(bx, ay, by, ax);
    det = rtk_ff_add(rtk_ff_add(u, v), w);
    if (!(rtk_fabs(det.hi) > 0.0f))
        return 0;
    num = rtk_ff_add(rtk_ff_mul(v, rtk_two_diff(s->bz, s->az)), rtk_ff_mul(w, rtk_two_diff(s->cz, s->az)));
    depth = rtk_ff_add(rtk_ff_scale(det, s->az), num);
    s->z = rtk_ff_quotient(depth, det);
    s->b = rtk_ff_quotient(v, det);
    s->c = rtk_ff_quotient(w, det);
    z = rtk_tri_plane_depth(r, tri);
    if (rtk_fabs(z - s->z) <= RTK_TRI_PLANE * r->scale)
        s->z = z;
    return 1;
}

/* Hit of a prepared ray with a triangle: t in the caller's units, u and v the weights of vertices 1 and 2. A pure function of ray
 * and triangle. Degenerate triangles, also those seen edge-on, are never hit; coordinates above 1e18 may miss. */
RTK_FN int rtk_tri_intersect(const rtk_pray *r, RT_GLOBAL const rtk_tri *tri, float *t, float *u, float *v)
{
    rtk_sheared s;
    float uu, vv, ww, lo, hi, det, inv, mx, my, q, db, dc, d, e, off, th;
    s.az = tri->v0[r->kz] - r->korg.z;
    s.bz = tri->v1[r->kz] - r->korg.z;
    s.cz = tri->v2[r->kz] - r->korg.z;
    s.ax = (tri->v0[r->kx] - r->korg.x) - r->sx * s.az;
    s.ay = (tri->v0[r->ky] - r->korg.y) - r->sy * s.az;
    s.bx = (tri->v1[r->kx] - r->korg.x) - r->sx * s.bz;
    s.by = (tri->v1[r->ky] - r->korg.y) - r->sy * s.bz;
    s.cx = (tri->v2[r->kx] - r->korg.x) - r->sx * s.cz;
    s.cy = (tri->v2[r->ky] - r->korg.y) - r->sy * s.cz;
    uu = s.cx * s.by - s.cy * s.bx;
    vv = s.ax * s.cy - s.ay * s.cx;
    ww = s.bx * s.ay - s.by * s.ax;
    lo = rtk_min(rtk_min(uu, vv), ww);
    hi = rtk_max(rtk_max(uu, vv), ww);
    if (lo < 0.0f && hi > 0.0f)
        return 0;
    det = uu + vv + ww;
    if (!(rtk_fabs(det) < RTK_INF)) /* NaN or overflow */
        return 0;
    /* Weights and depth, and whether they are good enough. */
    inv = 1.0f / det;
    db = s.bz - s.az;
    dc = s.cz - s.az;
    s.b = vv * inv;
    s.c = ww * inv;
    s.z = s.az + (s.b * db + s.c * dc);
    mx = rtk_max(rtk_max(rtk_fabs(s.ax), rtk_fabs(s.bx)), rtk_fabs(s.cx));
    my = rtk_max(rtk_max(rtk_fabs(s.ay), rtk_fabs(s.by)), rtk_fabs(s.cy));
    d = rtk_max(rtk_fabs(db), rtk_fabs(dc));
    q = mx * my * rtk_fabs(inv);
    e = s.b * rtk_fabs(db) + s.c * rtk_fabs(dc);
    e = 10.0f * e + (7.0f * e + 4.0f * d) * q;
    if (uu == 0.0f || vv == 0.0f || ww == 0.0f || !(rtk_fabs(det) >= RTK_TRI_LEAST) ||
        !(e <= rtk_min(32.0f * r->scale, 64.0f * rtk_fabs(s.z)) && (mx + my) * (10.0f * q + 12.0f) <= 128.0f * r->scale)) {
        /* Beyond doubt out of reach, whatever the exact depth is: above all the triangle that a spawned ray starts beside. That
         * one stands before tmin = 0, where the plane's share of the doubt is left out: it would let none go. */
        th = r->tshift + s.z / r->kdz;
        e = 1.2e-7f * e / rtk_fabs(r->kdz);
        off = e + (RTK_TRI_PLANE * r->scale / rtk_fabs(r->kdz) + 2.4e-7f * (rtk_fabs(th) + rtk_fabs(r->tshift)));
        if (rtk_fabs(det) >= RTK_TRI_LEAST && (th + (r->tmin == 0.0f ? e : off) < r->tmin || th - off > r->tmax))
            return 0;
        if (!rtk_tri_exact(r, tri, &s))
            return 0;
    }
    th = r->tshift + s.z / r->kdz;
    if (!(th > r->tmin && th < r->tmax))
        return 0;
    *t = th;
    *u = rtk_min(s.b, 1.0f);
    *v = rtk_min(s.c, 1.0f);
    return 1;
}

/* Cross product of two edges, and whether it may stand: little of it has cancelled (the direction's error is below 2^-17). */
RTK_FN int rtk_edges_normal(rtk_vec3 e, rtk_vec3 f, rtk_vec3 *n)
{
    *n = rtk_cross3(e, f);
    return rtk_maxabs(*n) > 0.03125f * (rtk_maxabs(e) * rtk_maxabs(f));
}

/* That of edges of which it may not: error below 2^-23 in each component. */
RTK_FN rtk_vec3 rtk_edges_normal_exact(rtk_vec3 e, rtk_vec3 f)
{
    return rtk_v3(rtk_diff_products(e.y, f.z, e.z, f.y), rtk_diff_products(e.z, f.x, e.x, f.z),
                  rtk_diff_products(e.x, f.y, e.y, f.x));
}

/* Geometric normal by the right-hand rule over the vertices' order, not normalised; zero when degenerate. Where little cancels,
 * plain products do; slivers take doubled floats. */
RTK_FN rtk_vec3 rtk_tri_normal(RT_GLOBAL const rtk_tri *tri)
{
    rtk_vec3 a = rtk_v3(tri->v0[0], tri->v0[1], tri->v0[2]), b = rtk_v3(tri->v1[0], tri->v1[1], tri->v1[2]);
    rtk_vec3 c = rtk_v3(tri->v2[0], tri->v2[1], tri->v2[2]), e = rtk_sub(b, a), f = rtk_sub(c, a), n;
    return rtk_edges_normal(e, f, &n) ? n : rtk_edges_normal_exact(e, f);
}

#endif
