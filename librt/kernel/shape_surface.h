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

/* Conservative box of two ends, or of one twice: a with what is around it by ea, b by eb. */
RTK_FN void rtk_ends_bounds(rtk_vec3 a, rtk_vec3 ea, rtk_vec3 b, rtk_vec3 eb, rtk_vec3 *lo, rtk_vec3 *hi)
{
    *lo = rtk_v3(rtk_min(rtk_below(a.x - ea.x, rtk_fabs(a.x) + 4.0f * ea.x), rtk_below(b.x - eb.x, rtk_fabs(b.x) + 4.0f * eb.x)),
                 rtk_min(rtk_below(a.y - ea.y, rtk_fabs(a.y) + 4.0f * ea.y), rtk_below(b.y - eb.y, rtk_fabs(b.y) + 4.0f * eb.y)),
                 rtk_min(rtk_below(a.z - ea.z, rtk_fabs(a.z) + 4.0f * ea.z), rtk_below(b.z - eb.z, rtk_fabs(b.z) + 4.0f * eb.z)));
    *hi = rtk_v3(rtk_max(rtk_above(a.x + ea.x, rtk_fabs(a.x) + 4.0f * ea.x), rtk_above(b.x + eb.x, rtk_fabs(b.x) + 4.0f * eb.x)),
                 rtk_max(rtk_above(a.y + ea.y, rtk_fabs(a.y) + 4.0f * ea.y), rtk_above(b.y + eb.y, rtk_fabs(b.y) + 4.0f * eb.y)),
                 rtk_max(rtk_above(a.z + ea.z, rtk_fabs(a.z) + 4.0f * ea.z), rtk_above(b.z + eb.z, rtk_fabs(b.z) + 4.0f * eb.z)));
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
    rtk_ends_bounds(a, ea, b, eb, lo, hi);
}

/* The form of a shape (RTK_FORM, from its fifth float on). */
RTK_FN void rtk_shape_form(RT_GLOBAL const rtk_shape *s, float to[RTK_FORM - RTK_BALL])
{
    rtk_u32 box = s->type == RTK_SHAPE_BOX, cone = s->type == RTK_SHAPE_CYLINDER || s->type == RTK_SHAPE_CONE, k;
    for (k = 0u; k < 3u; k++) {
        to[k] = box || cone ? s->p[k] : 0.0f;
        to[4u + k] = box ? s->p[3u + k] : (cone ? s->p[4u + k] : 0.0f);
    }
    to[3] = cone ? s->p[3] : (box ? RTK_FORM_BOX : RTK_FORM_OTHER);
    to[7] = cone ? s->p[s->type == RTK_SHAPE_CONE ? 7u : 3u] : 0.0f;
}

/* x, y, z and radius of a sphere, or of a ball that holds all roots of the shape (rtk_shape_roots), a little larger than need be;
 * of a plane all of space. A torus' and a cone's hold their boxes, whose half diagonals are no longer than the sums here: the roots
 * of flat cones are no better. Those of cylinders are on their surfaces. */
RTK_FN void rtk_shape_ball(RT_GLOBAL const rtk_shape *s, float to[RTK_BALL])
{
    rtk_vec3 a = rtk_at(s->p), b = a;
    float along, radius;
    if (s->type == RTK_SHAPE_BOX)
        b = rtk_at(s->p + 3);
    if (s->type == RTK_SHAPE_CYLINDER || s->type == RTK_SHAPE_CONE)
        b = rtk_at(s->p + 4);
    along = 0.5f * rtk_len(rtk_sub(b, a));
    if (s->type == RTK_SHAPE_CYLINDER)
        radius = rtk_sqrt(along * along + s->p[3] * s->p[3]);
    else if (s->type == RTK_SHAPE_CONE)
        radius = along + 1.4143f * rtk_max(s->p[3], s->p[7]);
    else if (s->type == RTK_SHAPE_TORUS)
        radius = 1.4143f * s->p[3] + 1.7321f * s->p[7];
    else
        radius = along;
    to[0] = 0.5f * a.x + 0.5f * b.x;
    to[1] = 0.5f * a.y + 0.5f * b.y;
    to[2] = 0.5f * a.z + 0.5f * b.z;
    to[3] = 1.0001f * radius + 1.0e-18f;
    if (s->type == RTK_SHAPE_PLANE)
        to[3] = RTK_INF;
    if (s->type == RTK_SHAPE_SPHERE) { /* exactly: halves of denormal numbers are rounded */
        to[0] = a.x;
        to[1] = a.y;
        to[2] = a.z;
        to[3] = s->p[3];
    }
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

/* ---- boxes: without a branch, for lanes ---- */

RTK_FN rtk_vec3 rtk_box_clamp(rtk_vec3 lo, rtk_vec3 hi, rtk_vec3 p)
{
    return rtk_v3(rtk_clamp(p.x, lo.x, hi.x), rtk_clamp(p.y, lo.y, hi.y), rtk_clamp(p.z, lo.z, hi.z));
}

/* The face that a point of the box is nearest to, of equally near ones the first: one of these is 1. */
typedef struct rtk_box_face {
    int low_x, high_x, low_y, high_y, low_z, high_z;
} rtk_box_face;
RTK_FN rtk_box_face rtk_box_nearest(rtk_vec3 lo, rtk_vec3 hi, rtk_vec3 p)
{
    rtk_vec3 a = rtk_sub(p, lo), b = rtk_sub(hi, p);
    float x = rtk_min(a.x, b.x), y = rtk_min(a.y, b.y), z = rtk_min(a.z, b.z), least = rtk_min(rtk_min(x, y), z);
    rtk_box_face f;
    int first = 1;
    f.low_x = a.x == least;
    first &= !f.low_x;
    f.high_x = first & (b.x == least);
    first &= !f.high_x;
    f.low_y = first & (a.y == least);
    first &= !f.low_y;
    f.high_y = first & (b.y == least);
    first &= !f.high_y;
    f.low_z = first & (a.z == least);
    f.high_z = first & !f.low_z;
    return f;
}

/* A point of the box brought onto a face; and the face's normal. */
RTK_FN rtk_vec3 rtk_box_onto(rtk_vec3 lo, rtk_vec3 hi, rtk_vec3 p, rtk_box_face f)
{
    p.x = f.low_x ? lo.x : p.x;
    p.y = f.low_y ? lo.y : p.y;
    p.z = f.low_z ? lo.z : p.z;
    p.x = f.high_x ? hi.x : p.x;
    p.y = f.high_y ? hi.y : p.y;
    p.z = f.high_z ? hi.z : p.z;
    return p;
}
RTK_FN rtk_vec3 rtk_box_normal(rtk_box_face f)
{
    return rtk_v3((float)(f.high_x - f.low_x), (float)(f.high_y - f.low_y), (float)(f.high_z - f.low_z));
}

/* Where a point of the box is on a face. */
RTK_FN void rtk_box_uv(rtk_vec3 lo, rtk_vec3 hi, rtk_vec3 p, rtk_box_face f, float *u, float *v)
{
    float x = rtk_clamp((p.x - lo.x) / (hi.x - lo.x), 0.0f, 1.0f), y = rtk_clamp((p.y - lo.y) / (hi.y - lo.y), 0.0f, 1.0f);
    float z = rtk_clamp((p.z - lo.z) / (hi.z - lo.z), 0.0f, 1.0f), back_x = 1.0f - x, back_z = 1.0f - z;
    float across = f.low_z ? back_x : x;
    across = f.low_x ? z : across;
    *u = f.high_x ? back_z : across;
    y = f.low_y ? z : y;
    *v = f.high_y ? back_z : y;
}

/* The area of the face with this normal. */
RTK_FN float rtk_box_area(rtk_vec3 lo, rtk_vec3 hi, rtk_vec3 ng)
{
    rtk_vec3 d = rtk_sub(hi, lo);
    float area = d.x * d.y;
    area = rtk_fabs(ng.y) > 0.5f ? d.x * d.z : area;
    return rtk_fabs(ng.x) > 0.5f ? d.y * d.z : area;
}

/* Apart: inside rtk_query_shape it costs other bodies registers. */
RTK_COLD void rtk_box_surface(RT_GLOBAL const rtk_shape *s, rtk_vec3 point, rtk_shape_point *out)
{
    rtk_vec3 lo = rtk_at(s->p), hi = rtk_at(s->p + 3), p = rtk_box_clamp(lo, hi, point);
    rtk_box_face f = rtk_box_nearest(lo, hi, p);
    out->p = rtk_box_onto(lo, hi, p, f);
    out->ng = rtk_box_normal(f);
    rtk_box_uv(lo, hi, p, f, &out->u, &out->v);
    out->dpdu = rtk_v3(f.low_z ? -1.0f : 1.0f, 0.0f, 0.0f);
    if (f.low_x | f.high_x)
        out->dpdu = rtk_v3(0.0f, 0.0f, f.high_x ? -1.0f : 1.0f);
}

/* p across the axis: a along x, which is a unit vector orthogonal to the axis, and b along y, which is that to both. Returns their
 * sum; of a point on the axis x. on: it is such a point. Without a branch, for lanes. */
RTK_FN rtk_vec3 rtk_across(rtk_vec3 axis, rtk_vec3 p, float *a, float *b, int *on)
{
    rtk_vec3 x, y, sum;
    rtk_basis(axis, &x, &y);
    *a = rtk_dot3(p, x);
    *b = rtk_dot3(p, y);
    sum = rtk_add(rtk_scale(x, *a), rtk_scale(y, *b));
    *on = (*a == 0.0f) & (*b == 0.0f);
    return rtk_v3(*on ? x.x : sum.x, *on ? x.y : sum.y, *on ? x.z : sum.z);
}

/* Unit vector from the axis to p (any one orthogonal to the axis for a point on it), and the part of a turn it stands at. */
RTK_FN rtk_vec3 rtk_around(rtk_vec3 axis, rtk_vec3 p, float *turn)
{
    float a, b;
    int on;
    rtk_vec3 round = rtk_across(axis, p, &a, &b, &on);
    *turn = rtk_turn(b, a);
    return on ? round : rtk_unit(round);
}

/* Where the surface of a cone is nearest to a point at z along the axis and m from it, towards `round`, a unit vector: on an end
 * disc, if that is nearer than the side; returns whether it is. n is outwards, of the side not unit. Without a branch, for
 * lanes. */
RTK_FN int rtk_cone_onto(rtk_cone c, rtk_vec3 e0, rtk_vec3 e1, float r1, float z, float m, rtk_vec3 round, rtk_vec3 *p, rtk_vec3 *n,
                         float *v)
{
    float on = rtk_clamp(z, 0.0f, c.height), r = c.r0 + c.k * on, side = rtk_fabs(m - r) / rtk_sqrt(1.0f + c.k * c.k);
    float cap = rtk_min(on, c.height - on), along = rtk_clamp(on / c.height, 0.0f, 1.0f), rim, out, across;
    int end = cap < side, top = c.height - on < on;
    rtk_vec3 from = rtk_v3(top ? e1.x : e0.x, top ? e1.y : e0.y, top ? e1.z : e0.z), disc, slope, body;
    rim = top ? r1 : c.r0;
    out = rtk_min(m, rim);
    across = rtk_clamp(out / rim, 0.0f, 1.0f);
    across = rim > 0.0f ? across : 0.0f;
    disc = rtk_madd(from, out, round);
    body = rtk_add(e0, rtk_add(rtk_scale(c.axis, on), rtk_scale(round, r)));
    slope = rtk_madd(round, -c.k, c.axis);
    *p = rtk_v3(end ? disc.x : body.x, end ? disc.y : body.y, end ? disc.z : body.z);
    *n = rtk_v3(top ? c.axis.x : -c.axis.x, top ? c.axis.y : -c.axis.y, top ? c.axis.z : -c.axis.z);
    *n = rtk_v3(end ? n->x : slope.x, end ? n->y : slope.y, end ? n->z : slope.z);
    *v = end ? across : along;
    return end;
}

RTK_FN void rtk_cone_surface(RT_GLOBAL const rtk_shape *s, rtk_vec3 point, rtk_shape_point *out)
{
    rtk_cone c = rtk_cone_of(s);
    rtk_vec3 e0 = rtk_at(s->p), q = rtk_sub(point, e0), round;
    float r1 = s->type == RTK_SHAPE_CONE ? s->p[7] : c.r0, z = rtk_dot3(q, c.axis), m;
    q = rtk_madd(q, -z, c.axis);
    m = rtk_len(q);
    round = rtk_around(c.axis, q, &out->u);
    out->dpdu = rtk_cross3(c.axis, round);
    if (!rtk_cone_onto(c, e0, rtk_at(s->p + 4), r1, z, m, round, &out->p, &out->ng, &out->v))
        out->ng = rtk_unit(out->ng);
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
