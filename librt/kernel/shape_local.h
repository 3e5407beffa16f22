/* What the tests of curved shapes share: the ray brought near the shape, and the last check of a root.
 *
 * A ray that starts 10^4 radii away has lost every digit of a quadratic's discriminant (Haines et al. 2019, "Precision
 * Improvements for Ray/Sphere Intersection"). Here the origin is first moved, exactly but for one rounding of the result, to
 * where the ray passes the shape; what follows then works with numbers of the shape's own size.
 */
#ifndef RTK_SHAPE_LOCAL_H
#define RTK_SHAPE_LOCAL_H

#include "snapshot.h"

/* The ray beside a shape: relative to an anchor point of it, unit direction; t = t0 + s / len. */
typedef struct rtk_local {
    rtk_vec3 o, d;
    float t0, len;
} rtk_local;

/* (org - anchor) + t d, rounded once. */
RTK_FN float rtk_local_at(float org, float anchor, float t, float d)
{
    rtk_ff f = rtk_two_diff(org, anchor), p = rtk_two_prod(t, d), s = rtk_two_sum(f.hi, p.hi);
    return s.hi + (s.lo + (f.lo + p.lo));
}

/* How much a ball grows to be surely met: 64 u scale covers the rounding of a plain closest approach from 4 scale away. */
#define RTK_BALL_MARGIN 3.8146973e-06f

/* 0 when the ray surely passes the ball (middle, radius) by. */
RTK_FN int rtk_local_ray(const rtk_pray *r, rtk_vec3 anchor, rtk_vec3 middle, float radius, rtk_local *out)
{
    rtk_vec3 f = rtk_sub(r->org, middle), p;
    float dd = rtk_dot3(r->dir, r->dir), t = -rtk_dot3(f, r->dir) / dd, reach = radius + RTK_BALL_MARGIN * r->scale;
    p = rtk_madd(f, t, r->dir);
    if (!(rtk_dot3(p, p) <= reach * reach))
        return 0;
    out->o.x = rtk_local_at(r->org.x, anchor.x, t, r->dir.x);
    out->o.y = rtk_local_at(r->org.y, anchor.y, t, r->dir.y);
    out->o.z = rtk_local_at(r->org.z, anchor.z, t, r->dir.z);
    out->t0 = t;
    out->len = rtk_sqrt(dd);
    out->d = rtk_v3(r->dir.x / out->len, r->dir.y / out->len, r->dir.z / out->len);
    return 1;
}

/* Brings the t of n roots into the ray's interval in the shape's box [lo, hi] grown by 32 u scale: with the slab's own 15 that
 * stays below RTK_DELTA. A root that would move by more than rounding explains is dropped. Returns how many stay. */
RTK_FN int rtk_roots_in_box(const rtk_pray *r, rtk_vec3 lo, rtk_vec3 hi, float *t, int n)
{
    float g = 1.9073486e-06f * r->scale, t0 = -RTK_INF, t1 = RTK_INF;
    int i, kept = 0;
    rtk_slab(r->org, r->inv, rtk_v3(lo.x - g, lo.y - g, lo.z - g), rtk_v3(hi.x + g, hi.y + g, hi.z + g), &t0, &t1);
    if (!(t0 <= t1))
        return 0;
    for (i = 0; i < n; i++) {
        float c = rtk_clamp(t[i], t0, t1);
        if (rtk_fabs(c - t[i]) * rtk_maxabs(r->dir) <= 4.0f * g)
            t[kept++] = c;
    }
    return kept;
}

/* Conservative ends of a sum that was rounded once or twice. */
RTK_FN float rtk_below(float x, float size)
{
    return x - 2.4e-7f * size;
}
RTK_FN float rtk_above(float x, float size)
{
    return x + 2.4e-7f * size;
}

RTK_FN rtk_vec3 rtk_at(RT_GLOBAL const float *p)
{
    return rtk_v3(p[0], p[1], p[2]);
}

#endif
