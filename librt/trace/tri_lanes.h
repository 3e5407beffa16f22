/* The leaf test in vectors, for hot files: rti_tri4, and rti_tri8, rti_tri16 where the processor has them (tri_lanes.inl). */
#ifndef RTI_TRI_LANES_H
#define RTI_TRI_LANES_H

#include "../base/simd.h"
#include "../kernel/triangle.h"

#define LANES_JOIN__(a, n, op) a##n##_##op
#define LANES_JOIN_(a, n, op)  LANES_JOIN__(a, n, op)
#define LANES_JOIN(a, n, op)   LANES_JOIN_(a, n, op)
#define LANES_TYPE__(a, n)     a##n
#define LANES_TYPE_(a, n)      LANES_TYPE__(a, n)
#define LANES_TYPE(a, n)       LANES_TYPE_(a, n)

/* What the leaf test's first half can tell of lanes in doubt without the second. Where no edge function is zero each has its true
 * sign, so a ray is inside for certain. The second half's depth is that of the same sheared vertices, of which the first's is off
 * by no more than half of `e` while det is known to a hundredth, or the plane's, no farther than 2^-19 scale (SETTLE_OFF, of scale
 * / |kdz|). */
#define SETTLE_OFF        2.4e-6f
#define CERTAIN_OFF_T     1.5e-6f /* of t: for roundings, also of t - off and t + off */
#define CERTAIN_OFF_LEAST 1e-37f
#define CERTAIN_Q         1.6e4f /* bounds on |x| |y| / |det|, and on |det| */
#define CERTAIN_DET       1e-30f
/* Of a depth, where tmin is 0: what keeps z / kdz, which is compared in its place elsewhere, a normal float. */
#define TRI_BEHIND 1e-19f

#define RTI_LANES_INL "tri_lanes.inl"
#include "lanes_each.inl"

/* What rtk_tri_intersect will say of a pair that the fast test doubts: -1, no hit with tmin < t < tmax; 1, a hit for certain; 0,
 * ask it. In doubles, which is a tenth of its doubled floats: of big triangles beside which a ray starts, or that stand edge-on,
 * nearly all are settled here. Products of two floats are exact in double, so the signs are those of rtk_compare_products. The
 * depth is rtk_tri_exact's of the same sheared vertices but for its roundings, 2^-44 |x| |y| (D + |az|) / |det|, which the bound
 * on |det| keeps below 2^-26 scale; the plane's depth, which may stand for it, is no farther than 2^-19 scale. So t is no farther
 * than `off`. v0, v1, v2: the corners in the ray's order of axes. within (may be NULL): of a hit for certain, what t lies between.
 */
#define SETTLE_DET       6.2e-5 /* bounds on |det|: of |x| |y|, and of all */
#define SETTLE_DET_MOST  1e38
#define SETTLE_OFF_T     1e-6   /* `off`: SETTLE_OFF of scale / |kdz|, and this of t */
#define SETTLE_OFF_LEAST 5e-45 /* more than floats lie apart when they are denormal */
#define SETTLE_ROUND     2e-7 /* of t: what it lies between is rounded to floats */

typedef struct rti_tri_pair {
    float ox, oy, oz, sx, sy, kdz, tshift, scale, tmin, tmax;
} rti_tri_pair;

RTI_VEC int rti_tri_settle(const rti_tri_pair *r, const float v0[3], const float v1[3], const float v2[3], float within[2])
{
    const float az = v0[2] - r->oz, bz = v1[2] - r->oz, cz = v2[2] - r->oz;
    const float ax = (v0[0] - r->ox) - r->sx * az, ay = (v0[1] - r->oy) - r->sy * az;
    const float bx = (v1[0] - r->ox) - r->sx * bz, by = (v1[1] - r->oy) - r->sy * bz;
    const float cx = (v2[0] - r->ox) - r->sx * cz, cy = (v2[1] - r->oy) - r->sy * cz;
    const double u = (double)cx * by - (double)cy * bx, v = (double)ax * cy - (double)ay * cx,
                 w = (double)bx * ay - (double)by * ax;
    const double det = u + v + w, size = det < 0.0 ? -det : det;
    const float mx = rtk_max(rtk_max(rtk_fabs(ax), rtk_fabs(bx)), rtk_fabs(cx));
    const float my = rtk_max(rtk_max(rtk_fabs(ay), rtk_fabs(by)), rtk_fabs(cy));
    double t, off;
    if ((u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0))
        return -1;
    if (!(size > SETTLE_DET * ((double)mx * my)) || !(size < SETTLE_DET_MOST))
        return 0;
    t = ((double)az + (v * ((double)bz - az) + w * ((double)cz - az)) / det) / r->kdz;
    off = (double)SETTLE_OFF * r->scale / rtk_fabs(r->kdz) + SETTLE_OFF_LEAST;
    off += SETTLE_OFF_T * ((t < 0.0 ? -t : t) + rtk_fabs(r->tshift));
    t += r->tshift;
    if (t + off < r->tmin || t - off > r->tmax)
        return -1;
    if (within) {
        const double more = off + SETTLE_ROUND * (t < 0.0 ? -t : t);
        within[0] = (float)(t - more);
        within[1] = (float)(t + more);
    }
    return t - off > r->tmin && t + off < r->tmax;
}

#endif
