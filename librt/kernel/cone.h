/* Capped cylinders and cone frustums: one convex body {0 <= z <= height, |p - axis| <= r0 + k z}, so a ray is inside it for one
 * interval, the one between the caps' planes cut with the one inside the (one-sided) infinite cone. */
#ifndef RTK_CONE_H
#define RTK_CONE_H

#include "shape_local.h"

typedef struct rtk_cone {
    rtk_vec3 axis; /* unit, from end 0 to end 1 */
    float height, r0, k;
} rtk_cone;

/* From one end to the other by `a`, the unit vector of which is the axis. Without a branch, for lanes. */
RTK_FN rtk_cone rtk_cone_along(rtk_vec3 a, rtk_vec3 axis, float r0, float r1)
{
    float m = rtk_maxabs(a), height = m * rtk_len(rtk_v3(a.x / m, a.y / m, a.z / m)), k;
    rtk_cone c;
    c.axis = axis;
    c.height = m > 0.0f ? height : 0.0f;
    c.r0 = r0;
    k = (r1 - r0) / c.height;
    c.k = c.height > 0.0f ? k : 0.0f;
    return c;
}

RTK_FN rtk_cone rtk_cone_of(RT_GLOBAL const rtk_shape *s)
{
    rtk_vec3 a = rtk_sub(rtk_at(s->p + 4), rtk_at(s->p));
    return rtk_cone_along(a, rtk_unit(a), s->p[3], s->type == RTK_SHAPE_CONE ? s->p[7] : s->p[3]);
}

/* The ray as the cone sees it: p + s w across the axis, radius r + s k there. */
typedef struct rtk_cone_ray {
    rtk_vec3 p, w;
    float r, k;
} rtk_cone_ray;

/* One Newton step on |p + s w| - (r + s k), whose float value is better than the quadratic's coefficients. Flat spots keep s. */
RTK_FN float rtk_cone_polish(const rtk_cone_ray *c, float s)
{
    rtk_vec3 q = rtk_madd(c->p, s, c->w);
    float m = rtk_len(q), slope, step;
    if (!(m > 0.0f))
        return s;
    slope = rtk_dot3(q, c->w) / m - c->k;
    step = (m - (c->r + s * c->k)) / slope;
    return rtk_fabs(slope) > 1.0e-4f && rtk_fabs(step) < 0.125f * m ? s - step : s;
}

/* Interval inside the infinite one-sided cone; empty when *s0 > *s1. Of needles, and near tips, p is many radii long, and b^2 - a cc
 * would be what is left of two numbers of the size of p^2: the quadratic is that from where the ray passes the axis, `at`. */
RTK_FN void rtk_cone_side(const rtk_cone_ray *c, float *s0, float *s1)
{
    float ww = rtk_dot3(c->w, c->w), pw = rtk_dot3(c->p, c->w), k = c->k, a = ww - k * k, b = pw - c->r * k, at = 0.0f;
    float m = rtk_len(c->p), cc = (m - c->r) * (m + c->r), disc = b * b - a * cc, q, x, y;
    *s0 = -RTK_INF;
    *s1 = RTK_INF;
    if (4.0f * (k * k) < ww) {
        float back = -pw / ww, l = rtk_len(rtk_madd(c->p, back, c->w)), r = c->r + back * k, kl = k * l;
        if (k == 0.0f) { /* cylinder: radius against the distance of the lines, without b^2 */
            disc = ww * ((r - l) * (r + l));
        } else if (8.0f * rtk_fabs(r) < m) {
            at = back;
            b = -(r * k);
            cc = (l - r) * (l + r);
            disc = ww * ((r - l) * (r + l)) + kl * kl;
        }
    }
    if (a == 0.0f && b == 0.0f) {
        if (cc > 0.0f)
            *s1 = -RTK_INF;
        return;
    }
    if (disc < 0.0f && a >= 0.0f) {
        *s0 = RTK_INF;
        *s1 = -RTK_INF;
        return;
    }
    q = -(b + rtk_copysign(rtk_sqrt(rtk_max(disc, 0.0f)), b));
    x = q / a;
    y = q == 0.0f ? x : cc / q;
    if (a >= 0.0f) {
        *s0 = at + rtk_min(x, y);
        *s1 = at + rtk_max(x, y);
    } else if (k > 0.0f) { /* steeper than the cone: in through the side, and the radius grows on */
        *s0 = rtk_max(x, y);
    } else {
        *s1 = rtk_min(x, y);
    }
    if (rtk_fabs(*s0) < RTK_INF)
        *s0 = rtk_cone_polish(c, *s0);
    if (rtk_fabs(*s1) < RTK_INF)
        *s1 = rtk_cone_polish(c, *s1);
}

/* t along org of the ways in and out; 0 or 2 of them. */
RTK_FN int rtk_cone_roots(const rtk_pray *r, RT_GLOBAL const rtk_shape *s, float *t)
{
    rtk_vec3 e0 = rtk_at(s->p), e1 = rtk_at(s->p + 4);
    rtk_vec3 mid = rtk_v3(0.5f * e0.x + 0.5f * e1.x, 0.5f * e0.y + 0.5f * e1.y, 0.5f * e0.z + 0.5f * e1.z);
    rtk_cone c = rtk_cone_of(s);
    float rmax = rtk_max(c.r0, s->type == RTK_SHAPE_CONE ? s->p[7] : 0.0f), z, dz, inv, s0, s1, a, b;
    rtk_local l;
    rtk_cone_ray q;
    if (!rtk_local_ray(r, e0, mid, 0.5f * c.height + rmax, &l))
        return 0;
    z = rtk_dot3(l.o, c.axis);
    dz = rtk_dot3(l.d, c.axis);
    q.p = rtk_madd(l.o, -z, c.axis);
    q.w = rtk_madd(l.d, -dz, c.axis);
    q.r = c.r0 + c.k * z;
    q.k = c.k * dz;
    rtk_cone_side(&q, &s0, &s1);
    inv = rtk_inverse(dz);
    a = (0.0f - z) * inv;
    b = (c.height - z) * inv;
    s0 = rtk_max(s0, rtk_min(a, b));
    s1 = rtk_min(s1, rtk_max(a, b));
    if (!(s0 <= s1))
        return 0;
    t[0] = l.t0 + s0 / l.len;
    t[1] = l.t0 + s1 / l.len;
    return 2;
}

/* Box of one of the two end discs, as half extents: radius * sqrt(1 - axis_i^2). */
RTK_FN rtk_vec3 rtk_cone_disc(rtk_vec3 n, float radius)
{
    return rtk_v3(radius * rtk_sqrt(n.y * n.y + n.z * n.z), radius * rtk_sqrt(n.x * n.x + n.z * n.z),
                  radius * rtk_sqrt(n.x * n.x + n.y * n.y));
}

#endif
