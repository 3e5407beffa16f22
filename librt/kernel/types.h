/* The ground every per-ray header stands on: the types and qualifiers that C11 and OpenCL C 1.2 share.
 *
 * Rules of this folder (design: kernels.md, Exactness): IEEE single only, no FMA contraction, no libm but sqrt, fabs,
 * floor and copysign, no function pointers, no recursion, no anonymous unions, no file-scope table without RT_CONSTANT,
 * no system include outside the C11 branch below. Everything is prefixed rtk_ (functions, structs) or RTK_ (macros).
 */
#ifndef RTK_TYPES_H
#define RTK_TYPES_H

#if defined(__OPENCL_VERSION__) || defined(__OPENCL_C_VERSION__)

#pragma OPENCL FP_CONTRACT OFF
typedef uint rtk_u32;
typedef int rtk_i32;
typedef ulong rtk_u64;
typedef long rtk_i64;
typedef ushort rtk_u16;
typedef uchar rtk_u8;
#define RT_GLOBAL          __global
#define RT_CONSTANT        __constant
#define RTK_FN             static inline
#define RTK_COLD           static inline
#define RTK_INLINE         static inline
#define rtk_sqrt(x)        sqrt(x)
#define rtk_fabs(x)        fabs(x)
#define rtk_floor(x)       floor(x)
#define rtk_copysign(x, y) copysign(x, y)
#define rtk_bits(f)        as_uint(f)
#define rtk_float(u)       as_float(u)

#else /* C11 */

#include <math.h>
#include <stdint.h>
#include <string.h>

typedef uint32_t rtk_u32;
typedef int32_t rtk_i32;
typedef uint64_t rtk_u64;
typedef int64_t rtk_i64;
typedef uint16_t rtk_u16;
typedef uint8_t rtk_u8;
#define RT_GLOBAL
#define RT_CONSTANT static const
#define RTK_FN      static inline
#if defined(__GNUC__)
#define RTK_COLD __attribute__((noinline, unused)) static /* rare branches, kept out of the hot loops */
#ifdef LIBRT_SANITIZED
#define RTK_INLINE static inline /* checks in every copy of every step: compilers would take minutes, and the calls cost less than the checks */
#else
#define RTK_INLINE __attribute__((always_inline)) static inline /* small steps of long chains: a call costs more than the step */
#endif
#else
#define RTK_COLD static inline
#define RTK_INLINE static inline
#endif
#define rtk_sqrt(x)        sqrtf(x)
#define rtk_fabs(x)        fabsf(x)
#define rtk_floor(x)       floorf(x)
#define rtk_copysign(x, y) copysignf(x, y)

RTK_FN rtk_u32 rtk_bits(float f)
{
    rtk_u32 u;
    memcpy(&u, &f, sizeof u);
    return u;
}

RTK_FN float rtk_float(rtk_u32 u)
{
    float f;
    memcpy(&f, &u, sizeof f);
    return f;
}

#endif

#define RTK_INVALID 0xffffffffu /* no primitive, no geometry, no instance */
#define RTK_INF     rtk_float(0x7f800000u)
#define RTK_PI      3.14159265358979f

/* The C library's fmin, fmax are not used: these have one defined answer for NaN (the second operand). */
RTK_FN float rtk_min(float a, float b)
{
    return a < b ? a : b;
}
RTK_FN float rtk_max(float a, float b)
{
    return a > b ? a : b;
}
RTK_FN float rtk_clamp(float x, float lo, float hi)
{
    return rtk_min(rtk_max(x, lo), hi);
}
RTK_FN rtk_u32 rtk_umin(rtk_u32 a, rtk_u32 b)
{
    return a < b ? a : b;
}
RTK_FN rtk_u32 rtk_umax(rtk_u32 a, rtk_u32 b)
{
    return a > b ? a : b;
}

#endif
