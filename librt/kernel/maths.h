/* Elementary functions in floats, the same bits on every machine: polynomials of our own and exact argument reduction, because
 * no two C libraries or OpenCL drivers agree on theirs.
 *
 * Errors in ulp of the result, measured against long double by tests/unit/test_kernel_maths.c (every stated bound is a test):
 *   sin cos 1.5 everywhere     tan 4 everywhere      asin acos 2.5      atan 2, atan2 3
 *   exp2 exp 1.5               log2 log 1            pow 2 where the result is normal (denormal results: 1 unit in the last
 * place) NaN in gives NaN out. Outside the domain: log(0) = -inf, log(x < 0) = NaN; asin, acos take x beyond +-1 as +-1, for dot
 * products of unit vectors; sin, cos, tan of an infinity are NaN; pow(x < 0, y) is NaN (no integer powers of negatives) but
 * pow(x, 0) = 1 always; atan2(0, 0) = 0 and keeps y's sign elsewhere on the axes.
 */
#ifndef RTK_MATHS_H
#define RTK_MATHS_H

#include "twofloat.h"

#define RTK_NAN        rtk_float(0x7fc00000u)
#define RTK_HALF_PI    1.57079637f
#define RTK_HALF_PI_LO (-4.37113883e-08f)

/* ---- sine, cosine, tangent ------------------------------------------------------------------------------------------ */

/* Bits of 2 / pi after the binary point, 32 a word; two words of zeros before them. */
RT_CONSTANT rtk_u32 rtk_two_over_pi[9] = {0u,          0u,          0xa2f9836eu, 0x4e441529u, 0xfc2757d1u,
                                          0xf534ddc0u, 0xdb629599u, 0x3c439041u, 0xfe5163abu};

/* x - quadrant * pi / 2 for any finite x: the 24-bit significand times 96 bits of 2 / pi, those that matter modulo 4 (Payne,
 * Hanek 1983). */
RTK_COLD float rtk_reduce_far(float x, rtk_u32 *quadrant)
{
    rtk_i32 e;
    rtk_u64 m = rtk_significand(x, &e), hi, product;
    rtk_u32 at, word, shift, low;
    rtk_i64 fraction;
    float r, top;
    /* x = m 2^(e - 150). The window's first bit has weight 2^1 after the multiplication: bit e - 152 after the point (from 0). */
    at = (rtk_u32)(e - 152 + 64);
    word = rtk_umin(at >> 5, 5u); /* 1 ... 5 for the |x| > 0.7 that come here */
    shift = at & 31u;
    hi = ((rtk_u64)rtk_two_over_pi[word] << 32) | rtk_two_over_pi[word + 1u];
    low = rtk_two_over_pi[word + 2u];
    if (shift != 0u) {
        hi = (hi << shift) | (low >> (32u - shift));
        low = (low << shift) | (rtk_two_over_pi[word + 3u] >> (32u - shift));
    }
    product = m * hi + ((m * low) >> 32);
    *quadrant = (rtk_u32)((product + ((rtk_u64)1 << 61)) >> 62) & 3u;
    fraction = (rtk_i64)(product - ((rtk_u64)*quadrant << 62));
    top = (float)fraction;
    r = rtk_ff_mul(rtk_ff_make(top, (float)(fraction - (rtk_i64)top)), rtk_ff_make(RTK_HALF_PI, RTK_HALF_PI_LO)).hi *
        2.16840434e-19f;
    if (x < 0.0f) {
        r = -r;
        *quadrant = (4u - *quadrant) & 3u;
    }
    return r;
}

/* x less k pi / 2, which is taken off in parts of 12, 11 and 24 bits: exact for the first two. */
RTK_FN float rtk_less_quarters(float x, float k)
{
    return ((x - k * 1.5703125f) - k * 0.0004837512969970703f) - k * 7.549790126404332e-08f;
}
#define RTK_QUARTER_HALF  0.785398185f /* up to here nothing is taken off */
#define RTK_QUARTER_LEAST 1.0e-3f      /* of a remainder, less of which is not exact enough */

/* The remainder in about [-pi/4, pi/4] and the quadrant of a finite x. Small remainders and large arguments go the long way. */
RTK_FN float rtk_reduce(float x, rtk_u32 *quadrant)
{
    float k, r;
    if (rtk_fabs(x) <= RTK_QUARTER_HALF) {
        *quadrant = 0u;
        return x;
    }
    if (rtk_fabs(x) <= 4096.0f) {
        k = rtk_floor(x * 0.636619772f + 0.5f);
        r = rtk_less_quarters(x, k);
        if (rtk_fabs(r) >= RTK_QUARTER_LEAST) {
            *quadrant = (rtk_u32)(rtk_i32)k & 3u;
            return r;
        }
    }
    return rtk_reduce_far(x, quadrant);
}

/* Sine and cosine of |r| <= 0.79. */
RTK_FN float rtk_sin_part(float r)
{
    float z = r * r;
    return r + r * z * (-0.166666667f + z * (0.00833333187f + z * (-0.000198400867f + z * 2.72499258e-06f)));
}
RTK_FN float rtk_cos_part(float r)
{
    float z = r * r;
    return 1.0f - (0.5f * z - z * z * (0.0416666667f + z * (-0.00138888877f + z * (2.48006004e-05f + z * -2.73009592e-07f))));
}

/* Sine and cosine of r and q quadrants more. */
RTK_FN void rtk_sincos_in(float r, rtk_u32 q, float *sine, float *cosine)
{
    float s = rtk_sin_part(r), c = rtk_cos_part(r), a = (q & 1u) ? c : s, b = (q & 1u) ? s : c;
    *sine = rtk_float(rtk_bits(a) ^ (q & 2u) << 30);
    *cosine = rtk_float(rtk_bits(b) ^ ((q + 1u) & 2u) << 30);
}

/* rtk_sincos of 0 <= x <= 4096 without a branch, for loops over lanes. Returns 0 where that takes another way. */
RTK_FN int rtk_sincos_plain(float x, float *sine, float *cosine)
{
    int near = x <= RTK_QUARTER_HALF;
    rtk_i32 k = (rtk_i32)(x * 0.636619772f + 0.5f);
    float r = rtk_less_quarters(x, (float)k);
    rtk_sincos_in(near ? x : r, near ? 0u : (rtk_u32)k & 3u, sine, cosine);
    return near | (rtk_fabs(r) >= RTK_QUARTER_LEAST);
}

RTK_FN void rtk_sincos(float x, float *sine, float *cosine)
{
    rtk_u32 q;
    float r;
    if (!(rtk_fabs(x) < RTK_INF)) {
        *sine = *cosine = RTK_NAN;
        return;
    }
    r = rtk_reduce(x, &q);
    rtk_sincos_in(r, q, sine, cosine);
}

RTK_FN float rtk_sin(float x)
{
    float s, c;
    rtk_sincos(x, &s, &c);
    return s;
}

RTK_FN float rtk_cos(float x)
{
    float s, c;
    rtk_sincos(x, &s, &c);
    return c;
}

RTK_FN float rtk_tan(float x)
{
    float s, c;
    rtk_sincos(x, &s, &c);
    return s / c;
}

/* ---- inverse functions ----------------------------------------------------------------------------------------------- */

/* atan(a / b) for 0 <= a <= b, b > 0. */
RTK_FN float rtk_atan_part(float a, float b)
{
    /* there atan(q) = pi/4 + atan((q - 1) / (q + 1)); large ones halved, their sum must not overflow */
    int far = a > 0.414213562f * b;
    float k = b > 1.0f ? 0.5f : 1.0f, q = (far ? k * a - k * b : a) / (far ? k * a + k * b : b), z = q * q;
    float base = far ? 0.785398185f : 0.0f, base_lo = far ? -2.18556941e-08f : 0.0f;
    return base +
           (q + (q * z * (-0.333333318f + z * (0.199995405f + z * (-0.142639556f + z * (0.107437315f + z * -0.0645192821f)))) +
                 base_lo));
}

/* Angle of (x, y) in [-pi, pi]. */
RTK_FN float rtk_atan2(float y, float x)
{
    float ay = rtk_fabs(y), ax = rtk_fabs(x), r;
    int valid = (ay >= 0.0f) & (ax >= 0.0f), none = (ay == 0.0f) & (ax == 0.0f), below;
    int high = ay == RTK_INF, wide = ax == RTK_INF, endless = high | wide; /* the corners count as diagonals */
    ay = endless ? (high ? 1.0f : 0.0f) : ay;
    ax = endless ? (wide ? 1.0f : 0.0f) : ax;
    below = ay <= ax;
    r = rtk_atan_part(below ? ay : ax, below ? ax : ay);
    r = below ? r : RTK_HALF_PI - (r - RTK_HALF_PI_LO);
    r = x < 0.0f ? 2.0f * RTK_HALF_PI - (r - 2.0f * RTK_HALF_PI_LO) : r;
    r = none ? 0.0f : rtk_copysign(r, y);
    return valid ? r : RTK_NAN;
}

RTK_FN float rtk_atan(float x)
{
    return x == 0.0f ? x : rtk_atan2(x, 1.0f);
}

/* (asin(x) - x) / x for 0 <= x <= 0.5, by z = x^2. */
RTK_FN float rtk_asin_part(float z)
{
    return z * (0.166666663f +
                z * (0.0750009454f + z * (0.0445994015f + z * (0.0311006627f + z * (0.0171492384f + z * 0.0336908472f)))));
}

RTK_FN float rtk_asin(float x)
{
    float a = rtk_fabs(x), z = a <= 0.5f ? x * x : 0.5f * (1.0f - rtk_min(a, 1.0f)), p = rtk_asin_part(z);
    float s = rtk_sqrt(z), near = x + x * p;
    s = rtk_copysign(RTK_HALF_PI - (2.0f * (s + s * p) - RTK_HALF_PI_LO), x);
    s = a <= 0.5f ? near : s;
    return a >= 0.0f ? s : RTK_NAN;
}

RTK_FN float rtk_acos(float x)
{
    float a = rtk_fabs(x), z = a <= 0.5f ? x * x : 0.5f * (1.0f - rtk_min(a, 1.0f)), p = rtk_asin_part(z);
    float s = rtk_sqrt(z), near = RTK_HALF_PI - (x + (x * p - RTK_HALF_PI_LO));
    s = 2.0f * (s + s * p);
    s = x > 0.0f ? s : 2.0f * RTK_HALF_PI - (s - 2.0f * RTK_HALF_PI_LO);
    s = a <= 0.5f ? near : s;
    return a >= 0.0f ? s : RTK_NAN;
}

/* ---- powers ------------------------------------------------------------------------------------------------------------ */

/* 2^(hi + lo), |lo| < 2^-10, for -151 <= hi < 128.5. */
RTK_FN float rtk_exp2_within(float hi, float lo)
{
    float k = rtk_floor(hi + 0.5f), f = (hi - k) + lo;
    float p = 1.0f + f * (0.693147181f +
                          f * (0.240226509f +
                               f * (0.0555041088f +
                                    f * (0.00961805668f + f * (0.00133335024f + f * (0.000154614447f + f * 1.52973238e-05f))))));
    /* Two powers of two: neither k = 128 nor a denormal result breaks the exponent field. */
    rtk_i32 e = (rtk_i32)k, low = e / 2;
    return p * rtk_float((rtk_u32)(low + 127) << 23) * rtk_float((rtk_u32)(e - low + 127) << 23);
}

/* For every hi. */
RTK_FN float rtk_exp2_sum(float hi, float lo)
{
    if (!(hi < 128.5f))
        return hi > 0.0f ? RTK_INF : RTK_NAN;
    return hi < -151.0f ? 0.0f : rtk_exp2_within(hi, lo);
}

RTK_FN float rtk_exp2(float x)
{
    return rtk_exp2_sum(x, 0.0f);
}

/* log2 of m 2^e, m in [1, 2), as a sum, error about 2^-32 of it: 2 atanh((m - 1) / (m + 1)) with the quotient's remainder kept.
 */
RTK_FN rtk_ff rtk_log2_of(float m, rtk_i32 e)
{
    float s, z;
    rtk_ff q, l;
    int more = m > 1.41421354f;
    m = more ? m * 0.5f : m;
    e += more;
    q = rtk_two_sum(m, 1.0f);
    s = (m - 1.0f) / q.hi;
    l = rtk_two_prod(s, q.hi);
    z = (((m - 1.0f) - l.hi) - l.lo - s * q.lo) / q.hi; /* what s lacks */
    l = rtk_ff_mul(rtk_ff_make(s, z), rtk_ff_make(2.88539004f, 3.85192607e-08f));
    z = s * s;
    l.lo += s * z * (0.961796692f + z * (0.577079774f + z * (0.411901276f + z * 0.336587494f)));
    l = rtk_quick_two_sum(l.hi, l.lo);
    return rtk_ff_add(rtk_ff_make((float)e, 0.0f), l);
}

/* log2 of a finite x > 0. */
RTK_FN rtk_ff rtk_log2_sum(float x)
{
    rtk_i32 e;
    float m = (float)rtk_significand(x, &e) * 1.1920929e-07f;
    return rtk_log2_of(m, e - 127);
}

/* 1 and *out set when x has no ordinary logarithm. */
RTK_FN int rtk_log_special(float x, float *out)
{
    if (x > 0.0f && x < RTK_INF)
        return 0;
    *out = x > 0.0f ? RTK_INF : (x == 0.0f ? -RTK_INF : RTK_NAN);
    return 1;
}

RTK_FN float rtk_log2(float x)
{
    float r;
    return rtk_log_special(x, &r) ? r : rtk_log2_sum(x).hi;
}

RTK_FN float rtk_log(float x)
{
    float r;
    return rtk_log_special(x, &r) ? r : rtk_ff_mul(rtk_log2_sum(x), rtk_ff_make(0.693147182f, -1.90465421e-09f)).hi;
}

RTK_FN float rtk_exp(float x)
{
    rtk_ff l;
    if (!(rtk_fabs(x) < 200.0f))
        return x > 0.0f ? RTK_INF : (x < 0.0f ? 0.0f : RTK_NAN);
    l = rtk_ff_scale(rtk_ff_make(1.44269502f, 1.92596303e-08f), x);
    return rtk_exp2_sum(l.hi, l.lo);
}

RTK_FN float rtk_pow(float x, float y)
{
    rtk_ff l;
    if (y == 0.0f || x == 1.0f)
        return 1.0f;
    if (!(x >= 0.0f) || !(rtk_fabs(y) >= 0.0f))
        return RTK_NAN;
    if (x == 0.0f || x == RTK_INF)
        return (x == 0.0f) == (y > 0.0f) ? 0.0f : RTK_INF;
    l = rtk_log2_sum(x);
    if (rtk_fabs(y) > 1.0e10f) /* even the logarithm of 1's neighbour gives more than 2^128 */
        return (l.hi > 0.0f) == (y > 0.0f) ? RTK_INF : 0.0f;
    l = rtk_ff_scale(l, y);
    if (rtk_fabs(l.hi) > 200.0f)
        return l.hi > 0.0f ? RTK_INF : 0.0f;
    return rtk_exp2_sum(l.hi, l.lo);
}

/* That for 0 <= y <= 1e10 without a branch, for loops over lanes. Returns 0 where it takes another way: beside a normal x > 0,
 * and where the power is beyond the floats. */
RTK_FN int rtk_pow_plain(float x, float y, float *out)
{
    rtk_u32 bits = rtk_bits(x);
    rtk_ff l = rtk_log2_of(rtk_float((bits & 0x7fffffu) | 0x3f800000u), (rtk_i32)(bits >> 23 & 0xffu) - 127);
    float p;
    l = rtk_ff_scale(l, y);
    p = rtk_exp2_within(rtk_clamp(l.hi, -151.0f, 128.0f), l.lo);
    *out = l.hi < -151.0f ? 0.0f : p;
    return (x >= 1.17549435e-38f) & (x < RTK_INF) & (y >= 0.0f) & (y <= 1.0e10f) & (l.hi <= 128.0f);
}

#endif
