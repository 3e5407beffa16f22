/* Where a moving instance stands at a time.
 *
 * Between two keys a point x of the child is at T(u) + R(u) S(u) x: T and the symmetric S go in straight lines, R turns evenly about
 * one axis, the shorter way (Shoemake 1985, as a circle between two orthogonal quaternions; the parts of a key by polar
 * decomposition, Shoemake and Duff 1992, in scene/motion.c). S stays definite between keys whose S are, so no time is singular. A body
 * turns about its own origin, which goes in a straight line.
 *
 * Both maps are functions of (instance, time) alone, rounded in one way; scene/motion.c bounds what they are off.
 */
#ifndef RTK_MOTION_H
#define RTK_MOTION_H

#include "maths.h"
#include "snapshot.h"

/* The parts at a time. s: xx xy xz yy yz zz, as all symmetric matrices here. */
typedef struct rtk_pose {
    rtk_vec3 t;
    float r[9], s[6];
    RT_GLOBAL const rtk_motion *segment;
} rtk_pose;

/* Rotation by a quaternion (x, y, z, w) near to unit length: its own length is divided out. */
RTK_FN void rtk_rotation(float x, float y, float z, float w, float r[9])
{
    float k = 2.0f / (x * x + y * y + z * z + w * w), kx = k * x, ky = k * y, kz = k * z;
    r[0] = 1.0f - (ky * y + kz * z);
    r[1] = kx * y - kz * w;
    r[2] = kx * z + ky * w;
    r[3] = kx * y + kz * w;
    r[4] = 1.0f - (kx * x + kz * z);
    r[5] = ky * z - kx * w;
    r[6] = kx * z - ky * w;
    r[7] = ky * z + kx * w;
    r[8] = 1.0f - (kx * x + ky * y);
}

RTK_FN rtk_pose rtk_pose_at(RT_GLOBAL const rtk_motion *motions, RT_GLOBAL const rtk_instance *inst, float time)
{
    float n = (float)inst->motion_count, x = rtk_clamp(time, 0.0f, 1.0f) * n, k = rtk_min(rtk_floor(x), n - 1.0f), u = x - k, c, s;
    RT_GLOBAL const rtk_motion *m = &motions[inst->motion_first + (rtk_u32)k];
    rtk_pose p;
    int i;
    rtk_sincos(u * m->angle, &s, &c);
    rtk_rotation(c * m->q0[0] + s * m->q1[0], c * m->q0[1] + s * m->q1[1], c * m->q0[2] + s * m->q1[2],
                 c * m->q0[3] + s * m->q1[3], p.r);
    p.t = rtk_v3(m->t0[0] + u * m->dt[0], m->t0[1] + u * m->dt[1], m->t0[2] + u * m->dt[2]);
    for (i = 0; i < 6; i++)
        p.s[i] = m->s0[i] + u * m->ds[i];
    p.segment = m;
    return p;
}

/* Inverse of a definite symmetric matrix, every entry rounded from doubled arithmetic. */
RTK_FN void rtk_symmetric_inverse(const float s[6], float inv[6])
{
    rtk_ff a = rtk_ff_diff_products(s[3], s[5], s[4], s[4]), b = rtk_ff_diff_products(s[2], s[4], s[1], s[5]);
    rtk_ff c = rtk_ff_diff_products(s[1], s[4], s[2], s[3]), d = rtk_ff_diff_products(s[0], s[5], s[2], s[2]);
    rtk_ff e = rtk_ff_diff_products(s[1], s[2], s[0], s[4]), f = rtk_ff_diff_products(s[0], s[3], s[1], s[1]);
    rtk_ff det = rtk_ff_add(rtk_ff_add(rtk_ff_scale(a, s[0]), rtk_ff_scale(b, s[1])), rtk_ff_scale(c, s[2]));
    inv[0] = rtk_ff_quotient(a, det);
    inv[1] = rtk_ff_quotient(b, det);
    inv[2] = rtk_ff_quotient(c, det);
    inv[3] = rtk_ff_quotient(d, det);
    inv[4] = rtk_ff_quotient(e, det);
    inv[5] = rtk_ff_quotient(f, det);
}

/* Row i of a symmetric matrix times column j of b. */
RTK_FN float rtk_symmetric_dot(const float s[6], int i, float x, float y, float z)
{
    if (i == 0)
        return s[0] * x + s[1] * y + s[2] * z;
    if (i == 1)
        return s[1] * x + s[3] * y + s[4] * z;
    return s[2] * x + s[4] * y + s[5] * z;
}

/* R S and T. */
RTK_FN rtk_xfm rtk_pose_to_world(rtk_pose p)
{
    rtk_xfm m;
    int i, j;
    for (i = 0; i < 3; i++) {
        for (j = 0; j < 3; j++)
            m.m[4 * i + j] = rtk_symmetric_dot(p.s, j, p.r[3 * i], p.r[3 * i + 1], p.r[3 * i + 2]);
        m.m[4 * i + 3] = rtk_axis(p.t, (rtk_u32)i);
    }
    return m;
}

/* S^-1 R^T, and of the origin what that makes of -T. */
RTK_FN rtk_xfm rtk_pose_to_object(rtk_pose p)
{
    float inv[6];
    rtk_xfm w;
    int i, j;
    if (p.segment->flags & RTK_MOTION_RIGID)
        for (i = 0; i < 6; i++)
            inv[i] = p.segment->inv[i];
    else
        rtk_symmetric_inverse(p.s, inv);
    for (i = 0; i < 3; i++) {
        for (j = 0; j < 3; j++)
            w.m[4 * i + j] = rtk_symmetric_dot(inv, i, p.r[3 * j], p.r[3 * j + 1], p.r[3 * j + 2]);
        w.m[4 * i + 3] = -(w.m[4 * i] * p.t.x + w.m[4 * i + 1] * p.t.y + w.m[4 * i + 2] * p.t.z);
    }
    return w;
}

/* Origin and direction in the space of a MOVING instance. */
RTK_COLD void rtk_motion_ray(RT_GLOBAL const rtk_motion *motions, RT_GLOBAL const rtk_instance *inst, float time, rtk_vec3 *org,
                             rtk_vec3 *dir)
{
    rtk_xfm w = rtk_pose_to_object(rtk_pose_at(motions, inst, time));
    *org = rtk_xfm_point(w, *org);
    *dir = rtk_xfm_dir(w, *dir);
}

/* Origin and direction in the space of an instance. */
RTK_FN void rtk_instance_ray(RT_GLOBAL const rtk_motion *motions, RT_GLOBAL const rtk_instance *inst, float time, rtk_vec3 *org,
                             rtk_vec3 *dir)
{
    if (inst->flags & RTK_INST_MOVING) {
        rtk_vec3 o = *org, d = *dir; /* copies: the ray of the other case stays in registers */
        rtk_motion_ray(motions, inst, time, &o, &d);
        *org = o;
        *dir = d;
        return;
    }
    *org = rtk_xfm_point(inst->to_object, *org);
    *dir = rtk_xfm_dir(inst->to_object, *dir);
}

#endif
