/* Ray and shape: sphere, box, capped cylinder and cone, torus, infinite plane. Layout of the parameters: rtk_shape.
 *
 * All are closed bodies but the plane; rays that start inside find the way out. Measured in the tests: a hit's point lies within
 * 3 u (|point| + |point - org|) of the surface, u = 2^-24, from inside, from 10^4 radii and from 10^6. Theory point 2 of ray.h
 * holds by construction for spheres (roots are that good) and boxes (a slab), by rtk_roots_in_box for the rest.
 */
#ifndef RTK_SHAPES_H
#define RTK_SHAPES_H

#include "cone.h"
#include "shape_surface.h"
#include "torus.h"

RTK_FN int rtk_sphere_roots(const rtk_pray *r, RT_GLOBAL const rtk_shape *s, float *t)
{
    rtk_vec3 c = rtk_at(s->p);
    float radius = s->p[3], b, m, disc, h;
    rtk_local l;
    if (!rtk_local_ray(r, c, c, radius, &l))
        return 0;
    b = -rtk_dot3(l.o, l.d);
    m = rtk_len(rtk_madd(l.o, b, l.d));
    disc = (radius - m) * (radius + m);
    if (!(disc >= 0.0f))
        return 0;
    h = rtk_sqrt(disc);
    t[0] = l.t0 + (b - h) / l.len;
    t[1] = l.t0 + (b + h) / l.len;
    return 2;
}

/* 1 when rtk_sphere_roots surely gives nothing in [t0, t1], measured from the prepared origin: the ray passes by, or the sphere lies behind
 * t0 or beyond t1. No division, no root. The margins are far above what both tests round: 32 u of the distance squared for the way
 * past (the tests themselves lose 8), half a percent of the radius and 10^-5 of t for the way along; products that leave
 * the floats' comfortable range are left to the test itself, and so is a NaN. */
RTK_FN int rtk_sphere_passed(const rtk_pray *r, RT_GLOBAL const rtk_shape *s, float t0, float t1)
{
    rtk_vec3 f = rtk_sub(r->org, rtk_at(s->p));
    float dd = rtk_dot3(r->dir, r->dir), b = rtk_dot3(f, r->dir), ff = rtk_dot3(f, f);
    float reach = s->p[3] + RTK_BALL_MARGIN * r->scale, wide = dd * (1.00001f * reach * reach + 1.9e-6f * ff);
    float size = ff * dd, beyond = -b - t1 * dd, behind = b + t0 * dd;
    if (!(size > 1.0e-24f && size < 1.0e30f && wide < 1.0e30f))
        return 0;
    if (size - b * b > wide)
        return 1;
    wide *= 1.01f;
    return (beyond > 1.0e-5f * (rtk_fabs(b) + rtk_fabs(t1) * dd) && beyond * beyond > wide) ||
           (behind > 1.0e-5f * (rtk_fabs(b) + rtk_fabs(t0) * dd) && behind * behind > wide);
}

RTK_FN int rtk_box_roots(const rtk_pray *r, RT_GLOBAL const rtk_shape *s, float *t)
{
    t[0] = -RTK_INF;
    t[1] = RTK_INF;
    rtk_slab(r->org, r->inv, rtk_at(s->p), rtk_at(s->p + 3), &t[0], &t[1]);
    return t[0] <= t[1] ? 2 : 0;
}

/* All t with tmin < t < tmax at which the ray crosses the shape's surface, ascending, at most four; returns how many. */
RTK_FN int rtk_shape_roots(const rtk_pray *r, RT_GLOBAL const rtk_shape *s, float *t)
{
    rtk_vec3 lo, hi;
    int i, n, kept = 0;
    if (s->type == RTK_SHAPE_SPHERE) {
        n = rtk_sphere_roots(r, s, t);
    } else if (s->type == RTK_SHAPE_BOX) {
        n = rtk_box_roots(r, s, t);
    } else {
        n = s->type == RTK_SHAPE_TORUS ? rtk_torus_roots(r, s, t) : rtk_cone_roots(r, s, t);
        if (n == 0)
            return 0;
        rtk_shape_bounds(s, &lo, &hi);
        n = rtk_roots_in_box(r, lo, hi, t, n);
    }
    for (i = 0; i < n; i++) {
        float th = r->tshift + t[i];
        if (th > r->tmin && th < r->tmax)
            t[kept++] = th;
    }
    return kept;
}

/* Surface parameters at a point of the surface. */
RTK_FN void rtk_shape_uv(RT_GLOBAL const rtk_shape *s, rtk_vec3 point, float *u, float *v)
{
    rtk_shape_point p;
    if (s->type == RTK_SHAPE_SPHERE) {
        rtk_sphere_uv(rtk_sub(point, rtk_at(s->p)), u, v);
        return;
    }
    rtk_shape_surface(s, point, &p);
    *u = p.u;
    *v = p.v;
}

/* Nearest crossing with tmin < t < tmax. A pure function of ray and shape. */
RTK_FN int rtk_shape_intersect(const rtk_pray *r, RT_GLOBAL const rtk_shape *s, float *t, float *u, float *v)
{
    float roots[4];
    if (rtk_shape_roots(r, s, roots) == 0)
        return 0;
    *t = roots[0];
    rtk_shape_uv(s, rtk_madd(r->org, *t - r->tshift, r->dir), u, v);
    return 1;
}

/* Infinite plane and a ray as given, not prepared. A ray in the plane misses. u = v = 0: texture coordinates of a plane come from
 * the point. The distance is exact to its last digits however far the plane's point is: differences and products are doubled. */
RTK_FN int rtk_plane_intersect(rtk_ray r, RT_GLOBAL const rtk_shape *s, float *t, float *u, float *v)
{
    rtk_vec3 n = rtk_at(s->p + 4);
    float den = rtk_ff_dot3(n.x, n.y, n.z, r.dir.x, r.dir.y, r.dir.z).hi, th;
    rtk_ff a = rtk_ff_mul(rtk_two_diff(s->p[0], r.org.x), rtk_ff_make(n.x, 0.0f));
    rtk_ff b = rtk_ff_mul(rtk_two_diff(s->p[1], r.org.y), rtk_ff_make(n.y, 0.0f));
    rtk_ff c = rtk_ff_mul(rtk_two_diff(s->p[2], r.org.z), rtk_ff_make(n.z, 0.0f));
    th = rtk_ff_add(rtk_ff_add(a, b), c).hi / den;
    if (!(th > r.tmin && th < r.tmax))
        return 0;
    *t = th;
    *u = 0.0f;
    *v = 0.0f;
    return 1;
}

#endif
