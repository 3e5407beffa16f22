/* Three-component vectors by value. Evaluation order is fixed as written: it is part of the exactness promise. */
#ifndef RTK_VEC_H
#define RTK_VEC_H

#include "types.h"

typedef struct rtk_vec3 {
    float x, y, z;
} rtk_vec3;

RTK_FN rtk_vec3 rtk_v3(float x, float y, float z)
{
    rtk_vec3 r;
    r.x = x;
    r.y = y;
    r.z = z;
    return r;
}

RTK_FN rtk_vec3 rtk_add(rtk_vec3 a, rtk_vec3 b) { return rtk_v3(a.x + b.x, a.y + b.y, a.z + b.z); }
RTK_FN rtk_vec3 rtk_sub(rtk_vec3 a, rtk_vec3 b) { return rtk_v3(a.x - b.x, a.y - b.y, a.z - b.z); }
RTK_FN rtk_vec3 rtk_mul(rtk_vec3 a, rtk_vec3 b) { return rtk_v3(a.x * b.x, a.y * b.y, a.z * b.z); }
RTK_FN rtk_vec3 rtk_scale(rtk_vec3 a, float s) { return rtk_v3(a.x * s, a.y * s, a.z * s); }
RTK_FN rtk_vec3 rtk_neg(rtk_vec3 a) { return rtk_v3(-a.x, -a.y, -a.z); }
RTK_FN float rtk_dot3(rtk_vec3 a, rtk_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
RTK_FN rtk_vec3 rtk_cross3(rtk_vec3 a, rtk_vec3 b)
{
    return rtk_v3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
RTK_FN rtk_vec3 rtk_madd(rtk_vec3 a, float t, rtk_vec3 d) { return rtk_v3(a.x + t * d.x, a.y + t * d.y, a.z + t * d.z); }
RTK_FN float rtk_len(rtk_vec3 a) { return rtk_sqrt(rtk_dot3(a, a)); }
RTK_FN rtk_vec3 rtk_vabs(rtk_vec3 a) { return rtk_v3(rtk_fabs(a.x), rtk_fabs(a.y), rtk_fabs(a.z)); }
RTK_FN float rtk_maxabs(rtk_vec3 a) { return rtk_max(rtk_max(rtk_fabs(a.x), rtk_fabs(a.y)), rtk_fabs(a.z)); }
RTK_FN float rtk_axis(rtk_vec3 a, rtk_u32 k) { return k == 0u ? a.x : (k == 1u ? a.y : a.z); }

/* What rtk_unit does nearly always: when the largest component m lies where no square leaves the range. */
RTK_FN int rtk_unit_is_plain(float m) { return (m >= 1.0e-15f) & (m <= 1.0e15f); }
RTK_FN rtk_vec3 rtk_unit_plain(rtk_vec3 a)
{
    float l = rtk_len(a);
    return rtk_v3(a.x / l, a.y / l, a.z / l);
}

/* Unit vector; a zero, infinite or NaN input gives (0, 0, 1), so that no NaN is born here. Scaled first by the largest
 * component: the square of a component neither overflows nor underflows. */
RTK_FN rtk_vec3 rtk_unit(rtk_vec3 a)
{
    float m = rtk_maxabs(a);
    rtk_vec3 s;
    float l;
    if (rtk_unit_is_plain(m))
        return rtk_unit_plain(a);
    if (!(m > 0.0f) || !(m <= 3.0e38f))
        return rtk_v3(0.0f, 0.0f, 1.0f);
    s = m < 1.0e-30f ? rtk_scale(a, 1.0e30f) : a;
    m = rtk_maxabs(s);
    s = rtk_v3(s.x / m, s.y / m, s.z / m);
    l = rtk_len(s);
    return rtk_v3(s.x / l, s.y / l, s.z / l);
}

/* Two unit vectors that make a right-handed frame with a unit n: Duff et al. 2017, "Building an Orthonormal Basis, Revisited". */
RTK_FN void rtk_basis(rtk_vec3 n, rtk_vec3 *x, rtk_vec3 *y)
{
    float s = rtk_copysign(1.0f, n.z), a = -1.0f / (s + n.z), b = n.x * n.y * a;
    *x = rtk_v3(1.0f + s * n.x * n.x * a, s * b, -s * n.x);
    *y = rtk_v3(b, s + n.y * n.y * a, -n.y);
}

/* Affine map, rows of a 3x4 matrix: y = m x + translation in the fourth column. */
typedef struct rtk_xfm {
    float m[12];
} rtk_xfm;

RTK_FN rtk_vec3 rtk_xfm_point(rtk_xfm a, rtk_vec3 p)
{
    return rtk_v3(a.m[0] * p.x + a.m[1] * p.y + a.m[2] * p.z + a.m[3], a.m[4] * p.x + a.m[5] * p.y + a.m[6] * p.z + a.m[7],
                  a.m[8] * p.x + a.m[9] * p.y + a.m[10] * p.z + a.m[11]);
}

RTK_FN rtk_vec3 rtk_xfm_dir(rtk_xfm a, rtk_vec3 d)
{
    return rtk_v3(a.m[0] * d.x + a.m[1] * d.y + a.m[2] * d.z, a.m[4] * d.x + a.m[5] * d.y + a.m[6] * d.z,
                  a.m[8] * d.x + a.m[9] * d.y + a.m[10] * d.z);
}

/* Transposed 3x3 part: maps normals when a is the inverse of the object-to-world map. */
RTK_FN rtk_vec3 rtk_xfm_normal(rtk_xfm inverse, rtk_vec3 n)
{
    return rtk_v3(inverse.m[0] * n.x + inverse.m[4] * n.y + inverse.m[8] * n.z,
                  inverse.m[1] * n.x + inverse.m[5] * n.y + inverse.m[9] * n.z,
                  inverse.m[2] * n.x + inverse.m[6] * n.y + inverse.m[10] * n.z);
}

#endif
