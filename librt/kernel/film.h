/* The film's numbers: contributions are added as 64-bit integers in a power-of-two unit, so a sum does not depend on its order.
 *
 * A contribution is limited to +-RTK_FILM_LIMIT, multiplied by `scale` (1 / unit, a power of two: exact) and rounded to the
 * nearest integer, ties to even. One with a NaN or an infinity is left out as a whole. Sums wrap modulo 2^64: whatever a partial
 * sum does, the final one is right while the true sum fits, and the job's unit is chosen so that it does.
 */
#ifndef RTK_FILM_H
#define RTK_FILM_H

#include "vec.h"

#define RTK_FILM_LIMIT    8192.0f /* 2^13 */
#define RTK_FILM_BITS     28      /* the finest unit is 2^-28 */
#define RTK_FILM_CHANNELS 4u      /* r, g, b, samples that met something */

enum { RTK_FILM_ADDED = 0, RTK_FILM_CLAMPED, RTK_FILM_DROPPED };

#if defined(__OPENCL_VERSION__) || defined(__OPENCL_C_VERSION__)
#define rtk_round_i64(x) convert_long_rte(x)
#else
/* Under the default rounding mode, which every computing thread of the library has (rti_fp_enter). */
#define rtk_round_i64(x) ((rtk_i64)llrintf(x))
#endif

RTK_FN rtk_i64 rtk_film_fixed(float x, float scale)
{
    return rtk_round_i64(rtk_clamp(x, -RTK_FILM_LIMIT, RTK_FILM_LIMIT) * scale);
}

/* Adds c to sum[0..2]; tells what became of it. */
RTK_FN rtk_u32 rtk_film_add(RT_GLOBAL rtk_u64 *sum, rtk_vec3 c, float scale)
{
    float m = rtk_fabs(c.x) + rtk_fabs(c.y) + rtk_fabs(c.z);
    if (!(m <= RTK_FILM_LIMIT)) { /* rare: one component too large, or all of them together, or no number */
        if (!(rtk_fabs(c.x) <= 3.402823466e38f && rtk_fabs(c.y) <= 3.402823466e38f && rtk_fabs(c.z) <= 3.402823466e38f))
            return RTK_FILM_DROPPED;
    }
    sum[0] += (rtk_u64)rtk_film_fixed(c.x, scale);
    sum[1] += (rtk_u64)rtk_film_fixed(c.y, scale);
    sum[2] += (rtk_u64)rtk_film_fixed(c.z, scale);
    return rtk_maxabs(c) > RTK_FILM_LIMIT ? RTK_FILM_CLAMPED : RTK_FILM_ADDED;
}

#endif
