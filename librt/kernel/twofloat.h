/* Exact and doubled arithmetic in single precision: no double, no FMA (OpenCL devices without fp64 must agree bit for bit).
 *
 * Source: Dekker 1971, Knuth TAOCP 2, Shewchuk 1997. Errors are stated in u = 2^-24. two_prod is exact while the product and
 * its error neither overflow (|a|, |b| < 2^115) nor fall below 2^-149 (|a b| > 2^-101); callers scale by powers of two first.
 */
#ifndef RTK_TWOFLOAT_H
#define RTK_TWOFLOAT_H

#include "types.h"

/* The unevaluated sum hi + lo, |lo| <= u |hi|. */
typedef struct rtk_ff {
    float hi, lo;
} rtk_ff;

RTK_INLINE rtk_ff rtk_ff_make(float hi, float lo)
{
    rtk_ff r;
    r.hi = hi;
    r.lo = lo;
    return r;
}

/* a + b exactly. */
RTK_INLINE rtk_ff rtk_two_sum(float a, float b)
{
    float s = a + b;
    float bb = s - a;
    return rtk_ff_make(s, (a - (s - bb)) + (b - bb));
}

/* a - b exactly. */
RTK_INLINE rtk_ff rtk_two_diff(float a, float b)
{
    float s = a - b;
    float bb = s - a;
    return rtk_ff_make(s, (a - (s - bb)) - (b + bb));
}

/* a + b exactly, given |a| >= |b| or a == 0. */
RTK_INLINE rtk_ff rtk_quick_two_sum(float a, float b)
{
    float s = a + b;
    return rtk_ff_make(s, b - (s - a));
}

/* a * b exactly, by Veltkamp's split into 12 + 12 bits. */
RTK_INLINE rtk_ff rtk_two_prod(float a, float b)
{
    float p = a * b;
    float ca = 4097.0f * a, cb = 4097.0f * b;
    float ah = ca - (ca - a), bh = cb - (cb - b);
    float al = a - ah, bl = b - bh;
    return rtk_ff_make(p, ((ah * bh - p) + ah * bl + al * bh) + al * bl);
}

/* a + b, error <= 4 u^2 (|a| + |b|). */
RTK_INLINE rtk_ff rtk_ff_add(rtk_ff a, rtk_ff b)
{
    rtk_ff s = rtk_two_sum(a.hi, b.hi), t = rtk_two_sum(a.lo, b.lo);
    s = rtk_two_sum(s.hi, s.lo + t.hi);
    return rtk_quick_two_sum(s.hi, s.lo + t.lo);
}

/* a * b, error <= 8 u^2 |a b|. */
RTK_INLINE rtk_ff rtk_ff_mul(rtk_ff a, rtk_ff b)
{
    rtk_ff p = rtk_two_prod(a.hi, b.hi);
    return rtk_quick_two_sum(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}

/* a * b with a plain b. */
RTK_INLINE rtk_ff rtk_ff_scale(rtk_ff a, float b)
{
    rtk_ff p = rtk_two_prod(a.hi, b);
    return rtk_quick_two_sum(p.hi, p.lo + a.lo * b);
}

/* a / b rounded to a float, error <= 1.01 u |a / b|: one float quotient and one correction by its remainder. */
RTK_INLINE float rtk_ff_quotient(rtk_ff a, rtk_ff b)
{
    float q = a.hi / b.hi;
    rtk_ff r = rtk_ff_add(a, rtk_ff_scale(b, -q));
    return q + r.hi / b.hi;
}

/* a b - c d, relative error <= 2^-44 however much cancels: the four terms of the two exact products are summed so that the
 * only rounding falls on a term u^2 below the result. */
RTK_INLINE rtk_ff rtk_ff_diff_products(float a, float b, float c, float d)
{
    rtk_ff p = rtk_two_prod(a, b), q = rtk_two_prod(c, d);
    rtk_ff s = rtk_two_diff(p.hi, q.hi), e = rtk_two_diff(p.lo, q.lo);
    rtk_ff h = rtk_two_sum(s.hi, e.hi);
    return rtk_two_sum(h.hi, h.lo + (s.lo + e.lo));
}

/* a b - c d rounded, relative error <= 2^-23. */
RTK_FN float rtk_diff_products(float a, float b, float c, float d)
{
    return rtk_ff_diff_products(a, b, c, d).hi;
}

/* a b - c d of doubled floats, error <= 20 u^2 (|a b| + |c d|). */
RTK_INLINE rtk_ff rtk_ff_cross(rtk_ff a, rtk_ff b, rtk_ff c, rtk_ff d)
{
    rtk_ff q = rtk_ff_mul(c, d);
    return rtk_ff_add(rtk_ff_mul(a, b), rtk_ff_make(-q.hi, -q.lo));
}

/* a.b of two vectors of floats, error <= 8 u^2 (|ax bx| + |ay by| + |az bz|). */
RTK_INLINE rtk_ff rtk_ff_dot3(float ax, float ay, float az, float bx, float by, float bz)
{
    return rtk_ff_add(rtk_ff_add(rtk_two_prod(ax, bx), rtk_two_prod(ay, by)), rtk_two_prod(az, bz));
}

/* a + t d exactly rounded (one rounding of the true sum but for u^2): how an origin is moved along a ray. */
RTK_FN float rtk_ff_along(float a, float t, float d)
{
    rtk_ff p = rtk_two_prod(t, d);
    rtk_ff s = rtk_two_sum(a, p.hi);
    return s.hi + (s.lo + p.lo);
}

/* Significand (24 bits, leading bit set) and biased exponent of a finite, non-zero float; denormals go on below exponent 1. */
RTK_FN rtk_u64 rtk_significand(float f, rtk_i32 *exponent)
{
    rtk_u32 b = rtk_bits(f), m = b & 0x7fffffu;
    *exponent = (rtk_i32)((b >> 23) & 0xffu);
    if (*exponent != 0)
        return m | 0x800000u;
    *exponent = 1;
    while (!(m & 0x800000u)) {
        m <<= 1;
        *exponent -= 1;
    }
    return m;
}

RTK_FN int rtk_sign(float f)
{
    return (f > 0.0f) - (f < 0.0f);
}

/* Sign of a b - c d, exact for all finite floats (also where the products over- or underflow): the magnitudes are compared as
 * 48-bit integers with exponents. */
RTK_COLD int rtk_compare_products(float a, float b, float c, float d)
{
    int sp = rtk_sign(a) * rtk_sign(b), sq = rtk_sign(c) * rtk_sign(d);
    rtk_i32 ea, eb, ec, ed;
    rtk_u64 p, q;
    if (sp != sq)
        return sp < sq ? -1 : 1;
    if (sp == 0)
        return 0;
    p = rtk_significand(a, &ea) * rtk_significand(b, &eb);
    q = rtk_significand(c, &ec) * rtk_significand(d, &ed);
    ea += eb;
    ec += ed;
    if (!(p >> 47)) {
        p <<= 1;
        ea -= 1;
    }
    if (!(q >> 47)) {
        q <<= 1;
        ec -= 1;
    }
    if (ea != ec)
        return ea < ec ? -sp : sp;
    return p < q ? -sp : (p > q ? sp : 0);
}

/* A power of two s with max |x| s in [0.25, 0.5) (denormals and infinity aside). */
RTK_FN float rtk_normaliser(float max_abs)
{
    rtk_u32 e = rtk_umin(rtk_bits(max_abs) >> 23, 251u);
    return rtk_float((252u - e) << 23);
}

#endif
