/* Ray and torus. In units of the major radius, with x the distance along the ray from its closest approach to the centre,
 *
 *   F(x) = (x^2 + m)^2 + 4 (z(x)^2 - rho^2),   F'(x) / 4 = x^3 + (m + 2 dz^2) x + 2 dz z(0),   m = |o|^2 - 1 - rho^2,
 *
 * so F' is a depressed cubic, its own turning points are a square root away, and bracketing goes up the ladder: turning points
 * of F' bracket its roots, these bracket the roots of F (at most four). The last stage does not evaluate F, which cancels badly
 * for thin rings, but the signed distance sqrt((|p| - 1)^2 + z^2) - rho, which has the same sign.
 */
#ifndef RTK_TORUS_H
#define RTK_TORUS_H

#include "shape_local.h"

typedef struct rtk_torus_ray {
    rtk_vec3 p, w; /* across the axis */
    float z, dz;   /* along it */
    float m, rho;
} rtk_torus_ray;

/* Signed distance at x, and its slope along the ray. */
RTK_FN float rtk_torus_distance(const rtk_torus_ray *q, float x, float *slope)
{
    rtk_vec3 p = rtk_madd(q->p, x, q->w);
    float l = rtk_len(p), a = l - 1.0f, z = q->z + x * q->dz, d = rtk_sqrt(a * a + z * z);
    float dl = l > 0.0f ? rtk_dot3(p, q->w) / l : 0.0f;
    *slope = d > 0.0f ? (a * dl + z * q->dz) / d : 0.0f;
    return d - q->rho;
}

RTK_FN float rtk_torus_cubic(const rtk_torus_ray *q, float x, float *slope)
{
    float k = q->m + 2.0f * q->dz * q->dz;
    *slope = 3.0f * x * x + k;
    return (x * x + k) * x + 2.0f * q->dz * q->z;
}

/* Root between a and b, where the function (cubic or distance) has the signs of fa and the opposite: Newton's method kept in the
 * shrinking bracket, a bisection whenever it would leave it. */
RTK_FN float rtk_torus_solve(const rtk_torus_ray *q, int cubic, float a, float b, float fa)
{
    float x = 0.5f * (a + b), f, slope, next;
    int i;
    for (i = 0; i < 48; i++) {
        f = cubic ? rtk_torus_cubic(q, x, &slope) : rtk_torus_distance(q, x, &slope);
        if (f == 0.0f)
            return x;
        if ((f < 0.0f) == (fa < 0.0f))
            a = x;
        else
            b = x;
        next = x - f / slope;
        if (!(next > rtk_min(a, b) && next < rtk_max(a, b)))
            next = 0.5f * (a + b);
        if (next == x || rtk_fabs(next - x) <= 6.0e-8f * rtk_fabs(x) || next == a || next == b)
            return next;
        x = next;
    }
    return x;
}

/* Points that cut [x0, x1] into pieces where F is monotone: the roots of its derivative, in order. */
RTK_FN int rtk_torus_turns(const rtk_torus_ray *q, float x0, float x1, float *x)
{
    float k = q->m + 2.0f * q->dz * q->dz, turn = k < 0.0f ? rtk_sqrt(k / -3.0f) : 0.0f, slope, a, b, fa, fb;
    float cut[4];
    int i, n = 0;
    cut[0] = x0;
    cut[1] = rtk_clamp(-turn, x0, x1);
    cut[2] = rtk_clamp(turn, x0, x1);
    cut[3] = x1;
    for (i = 0; i < 3; i++) {
        a = cut[i];
        b = cut[i + 1];
        fa = rtk_torus_cubic(q, a, &slope);
        fb = rtk_torus_cubic(q, b, &slope);
        if (a < b && (fa < 0.0f) != (fb < 0.0f))
            x[n++] = rtk_torus_solve(q, 1, a, b, fa);
    }
    return n;
}

/* t along org of the crossings, ascending; at most four. */
RTK_FN int rtk_torus_roots(const rtk_pray *r, RT_GLOBAL const rtk_shape *s, float *t)
{
    rtk_vec3 c = rtk_at(s->p), n = rtk_at(s->p + 4), o;
    float major = s->p[3], e, h, inv, a, b, x0, x1, fa, fb, slope;
    float cut[5];
    int i, cuts, count = 0;
    rtk_local l;
    rtk_torus_ray q;
    if (!rtk_local_ray(r, c, c, major + s->p[7], &l))
        return 0;
    q.rho = s->p[7] / major;
    o = rtk_v3(l.o.x / major, l.o.y / major, l.o.z / major);
    e = rtk_dot3(o, l.d);
    o = rtk_madd(o, -e, l.d);
    h = rtk_dot3(o, o);
    q.z = rtk_dot3(o, n);
    q.dz = rtk_dot3(l.d, n);
    q.p = rtk_madd(o, -q.z, n);
    q.w = rtk_madd(l.d, -q.dz, n);
    q.m = h - 1.0f - q.rho * q.rho;
    /* Inside the ball of the outer rim and between the planes that hold the ring: both ends of the interval are outside. */
    a = (1.0f + q.rho) * (1.0f + q.rho) * 1.000001f - h;
    if (!(a >= 0.0f))
        return 0;
    x1 = rtk_sqrt(a);
    x0 = -x1;
    inv = rtk_inverse(q.dz);
    a = (-1.000001f * q.rho - q.z) * inv;
    b = (1.000001f * q.rho - q.z) * inv;
    x0 = rtk_max(x0, rtk_min(a, b));
    x1 = rtk_min(x1, rtk_max(a, b));
    if (!(x0 <= x1))
        return 0;
    cut[0] = x0;
    cuts = 1 + rtk_torus_turns(&q, x0, x1, cut + 1);
    cut[cuts] = x1;
    fa = rtk_torus_distance(&q, x0, &slope);
    for (i = 0; i < cuts; i++) {
        fb = rtk_torus_distance(&q, cut[i + 1], &slope);
        if ((fa < 0.0f) != (fb < 0.0f))
            t[count++] = l.t0 + (rtk_torus_solve(&q, 0, cut[i], cut[i + 1], fa) - e) * major / l.len;
        fa = fb;
    }
    return count;
}

#endif
