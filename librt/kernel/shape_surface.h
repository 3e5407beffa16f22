/* Shapes seen by shading and by builders: boxes, and what is at a point of the surface. */
#ifndef RTK_SHAPE_SURFACE_H
#define RTK_SHAPE_SURFACE_H

#include "cone.h"
#include "maths.h"

/* A point of a shape's surface: p projected onto it, ng unit and outwards, u and v in [0, 1], dpdu unit along growing u
 * (orthogonal to ng), error: bound of p's distance from the surface in any direction.
 *   SPHERE   u longitude around +y from +x towards -z, v latitude from the bottom (0) to the top (1)
 *   BOX      each face its own [0, 1]^2, seen from outside with +y up (top and bottom: +x to the right)
 *   CYLINDER, CONE  side: u around the axis, v from end 0 to end 1; a cap: u around the axis, v from the axis (0) to the rim (1)
 *   TORUS    u around the axis, v around the tube from its outermost circle
 */
typedef struct rtk_shape_point {
    rtk_vec3 p, ng, dpdu;
    float u, v, error;
} rtk_shape_point;

/* One coordinate of a sphere's box. */
RTK_FN float rtk_sphere_low(float c, float radius)
{
    return rtk_below(c - radius, rtk_fabs(c) + 4.0f * radius);
}
RTK_FN float rtk_sphere_high(float c, float radius)
{
    return rtk_above(c + radius, rtk_fabs(c) + 4.0f * radius);
}

/* Bound of a point's distance from the surface of a shape with bounds of this size: one rounding of p's coordinates, 2 u |p| in
 * length, and a dozen of numbers of the shape's own size; 3 and 16 u cover them. */
RTK_FN float rtk_shape_error(rtk_vec3 p, rtk_vec3 size)
{
    return 1.8e-7f * rtk_maxabs(p) + 1.0e-6f * rtk_maxabs(size);
}

/* Conservative box, rounded outwards; of a PLANE: everything. */
RTK_FN void rtk_shape_bounds(RT_GLOBAL const rtk_shape *s, rtk_vec3 *lo, rtk_vec3 *hi)
{
    rtk_vec3 a = rtk_at(s->p), b = a, ea, eb;
    if (s->type == RTK_SHAPE_PLANE) {
        *lo = rtk_v3(-RTK_INF, -RTK_INF, -RTK_INF);
        *hi = rtk_v3(RTK_INF, RTK_INF, RTK_INF);
        return;
    }
    if (s->type == RTK_SHAPE_BOX) {
        *lo = a;
        *hi = rtk_at(s->p + 3);
        return;
    }
    if (s->type == RTK_SHAPE_SPHERE) {
        *lo = rtk_v3(rtk_sphere_low(a.x, s->p[3]), rtk_sphere_low(a.y, s->p[3]), rtk_sphere_low(a.z, s->p[3]));
        *hi = rtk_v3(rtk_sphere_high(a.x, s->p[3]), rtk_sphere_high(a.y, s->p[3]), rtk_sphere_high(a.z, s->p[3]));
        return;
    }
    if (s->type == RTK_SHAPE_TORUS) {
        ea = rtk_cone_disc(rtk_at(s->p + 4), s->p[3]);
        ea = eb = rtk_v3(ea.x + s->p[7], ea.y + s->p[7], ea.z + s->p[7]);
    } else {
        rtk_cone c = rtk_cone_of(s);
        b = rtk_at(s->p + 4);
        ea = rtk_cone_disc(c.axis, c.r0);
        eb = rtk_cone_disc(c.axis, s->type == RTK_SHAPE_CONE ? s->p[7] : c.r0);
    }
    *lo = rtk_v3(rtk_min(rtk_below(a.x - ea.x, rtk_fabs(a.x) + 4.0f * ea.x), rtk_below(b.x - eb.x, rtk_fabs(b.x) + 4.0f * eb.x)),
                 rtk_min(rtk_below(a.y - ea.y, rtk_fabs(a.y) + 4.0f * ea.y), rtk_below(b.y - eb.y, rtk_fabs(b.y) + 4.0f * eb.y)),
                 rtk_min(rtk_below(a.z - ea.z, rtk_fabs(a.z) + 4.0f * ea.z), rtk_below(b.z - eb.z, rtk_fabs(b.z) + 4.0f * eb.z)));
    *hi = rtk_v3(rtk_max(rtk_above(a.x + ea.x, rtk_fabs(a.x) + 4.0f * ea.x), rtk_above(b.x + eb.x, rtk_fabs(b.x) + 4.0f * eb.x)),
                 rtk_max(rtk_above(a.y + ea.y, rtk_fabs(a.y) + 4.0f * ea.y), rtk_above(b.y + eb.y, rtk_fabs(b.y) + 4.0f * eb.y)),
                 rtk_max(rtk_above(a.z + ea.z, rtk_fabs(a.z) + 4.0f * ea.z), rtk_above(b.z + eb.z, rtk_fabs(b.z) + 4.0f * eb.z)));
}

/* Angle of (x, y) as a part of the full turn, in [0, 1). */
RTK_FN float rtk_turn(float y, float x)
{
    float a = rtk_atan2(y, x) * 0.159154943f;
    a = a < 0.0f ? a + 1.0f : a;
    return a < 1.0f ? a : 0.0f;
}

/* The point of a sphere that its unit normal n names. */
RTK_FN rtk_vec3 rtk_sphere_point(rtk_vec3 c, float radius, rtk_vec3 n)
{
    return rtk_madd(c, radius, n);
}

/* Longitude and latitude of q, a vector from the centre. */
RTK_FN void rtk_sphere_uv(rtk_vec3 q, float *u, float *v)
{
    *u = rtk_turn(-q.z, q.x);
    *v = rtk_clamp(0.5f + rtk_asin(q.y / rtk_len(q)) * (1.0f / RTK_PI), 0.0f, 1.0f);
}

RTK_FN void rtk_sphere_surface(RT_GLOBAL const rtk_shape *s, rtk_vec3 point, rtk_shape_point *out)
{
    rtk_vec3 c = rtk_at(s->p), n = rtk_unit(rtk_sub(point, c));
    out->ng = n;
    out->p = rtk_sphere_point(c, s->p[3], n);
    rtk_sphere_uv(n, &out->u, &out->v);
    out->dpdu = n.x == 0.0f && n.z == 0.0f ? rtk_v3(1.0f, 0.0f, 0.0f) : rtk_unit(rtk_v3(n.z, 0.0f, -n.x));
}

RTK_FN void rtk_box_surface(RT_GLOBAL const rtk_shape *s, rtk_vec3 point, rtk_shape_point *out)
{
    float lo[3], hi[3], p[3], q[3], best = RTK_INF;
    int i, axis = 0, high = 0;
    p[0] = point.x;
    p[1] = point.y;
    p[2] = point.z;
    for (i = 0; i < 3; i++) {
        lo[i] = s->p[i];
        hi[i] = s->p[3 + i];
        p[i] = rtk_clamp(p[i], lo[i], hi[i]);
        q[i] = rtk_clamp((p[i] - lo[i]) / (hi[i] - lo[i]), 0.0f, 1.0f);
        if (p[i] - lo[i] < best) {
            best = p[i] - lo[i];
            axis = i;
            high = 0;
        }
        if (hi[i] - p[i] < best) {
            best = hi[i] - p[i];
            axis = i;
            high = 1;
        }
    }
    p[axis] = high ? hi[axis] : lo[axis];
    q[axis] = high ? 1.0f : 0.0f;
    out->p = rtk_v3(p[0], p[1], p[2]);
    out->ng = rtk_v3(axis == 0 ? 2.0f * q[0] - 1.0f : 0.0f, axis == 1 ? 2.0f * q[1] - 1.0f : 0.0f,
                     axis == 2 ? 2.0f * q[2] - 1.0f : 0.0f);
    if (axis == 0) {
        out->u = high ? 1.0f - q[2] : q[2];
        out->v = q[1];
        out->dpdu = rtk_v3(0.0f, 0.0f, high ? -1.0f : 1.0f);
    } else if (axis == 1) {
        out->u = q[0];
        out->v = high ? 1.0f - q[2] : q[2];
        out->dpdu = rtk_v3(1.0f, 0.0f, 0.0f);
    } else {
        out->u = high ? q[0] : 1.0f - q[0];
        out->v = q[1];
        out->dpdu = rtk_v3(high ? 1.0f : -1.0f, 0.0f, 0.0f);
    }
}

/* Unit vector from the axis to p (any one orthogonal to the axis for a point on it), and the part of a turn it stands at. */
RTK_FN rtk_vec3 rtk_around(rtk_vec3 axis, rtk_vec3 p, float *turn)
{
    rtk_vec3 x, y;
    float a, b;
    rtk_basis(axis, &x, &y);
    a = rtk_dot3(p, x);
    b = rtk_dot3(p, y);
    *turn = rtk_turn(b, a);
    if (a == 0.0f && b == 0.0f)
        return x;
    return rtk_unit(rtk_add(rtk_scale(x, a), rtk_scale(y, b)));
}

RTK_FN void rtk_cone_surface(RT_GLOBAL const rtk_shape *s, rtk_vec3 point, rtk_shape_point *out)
{
    rtk_cone c = rtk_cone_of(s);
    rtk_vec3 e0 = rtk_at(s->p), q = rtk_sub(point, e0), round;
    float r1 = s->type == RTK_SHAPE_CONE ? s->p[7] : c.r0, z = rtk_dot3(q, c.axis), m, r, side, cap;
    q = rtk_madd(q, -z, c.axis);
    m = rtk_len(q);
    round = rtk_around(c.axis, q, &out->u);
    out->dpdu = rtk_cross3(c.axis, round);
    z = rtk_clamp(z, 0.0f, c.height);
    r = c.r0 + c.k * z;
    side = rtk_fabs(m - r) / rtk_sqrt(1.0f + c.k * c.k);
    cap = rtk_min(z, c.height - z);
    if (cap < side) { /* nearer to an end disc than to the side */
        int top = c.height - z < z;
        float rim = top ? r1 : c.r0;
        m = rtk_min(m, rim);
        out->ng = top ? c.axis : rtk_neg(c.axis);
        out->p = rtk_madd(top ? rtk_at(s->p + 4) : e0, m, round);
        out->v = rim > 0.0f ? rtk_clamp(m / rim, 0.0f, 1.0f) : 0.0f;
        return;
    }
    out->ng = rtk_unit(rtk_madd(round, -c.k, c.axis));
    out->p = rtk_add(e0, rtk_add(rtk_scale(c.axis, z), rtk_scale(round, r)));
    out->v = rtk_clamp(z / c.height, 0.0f, 1.0f);
}

RTK_FN void rtk_torus_surface(RT_GLOBAL const rtk_shape *s, rtk_vec3 point, rtk_shape_point *out)
{
    rtk_vec3 c = rtk_at(s->p), n = rtk_at(s->p + 4), q = rtk_sub(point, c), round, tube;
    float z = rtk_dot3(q, n), a;
    q = rtk_madd(q, -z, n);
    round = rtk_around(n, q, &out->u);
    a = rtk_len(q) - s->p[3];
    tube = rtk_add(rtk_scale(round, a), rtk_scale(n, z));
    out->ng = a == 0.0f && z == 0.0f ? round : rtk_unit(tube);
    out->v = rtk_turn(z, a);
    out->dpdu = rtk_cross3(n, round);
    out->p = rtk_add(c, rtk_add(rtk_scale(round, s->p[3]), rtk_scale(out->ng, s->p[7])));
}

/* What is at a point on or very near the surface. Not for planes. */
RTK_FN void rtk_shape_surface(RT_GLOBAL const rtk_shape *s, rtk_vec3 point, rtk_shape_point *out)
{
    rtk_vec3 lo, hi;
    if (s->type == RTK_SHAPE_SPHERE)
        rtk_sphere_surface(s, point, out);
    else if (s->type == RTK_SHAPE_BOX)
        rtk_box_surface(s, point, out);
    else if (s->type == RTK_SHAPE_TORUS)
        rtk_torus_surface(s, point, out);
    else
        rtk_cone_surface(s, point, out);
    rtk_shape_bounds(s, &lo, &hi);
    out->error = rtk_shape_error(out->p, rtk_sub(hi, lo));
}

#endif
