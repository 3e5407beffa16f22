/* Four floats at once for the BVH's builder: SSE2 where the compiler has it, plain C elsewhere, the same results. min and max
 * give the second operand when neither is less, as rtk_min and rtk_max do. Private to accel/. */
#ifndef RTI_F4_H
#define RTI_F4_H

#include "../kernel/types.h"

#if defined(__SSE2__)
#include <emmintrin.h>

typedef __m128 rti_f4;

static inline rti_f4 rti_f4_load(const float *p)
{
    return _mm_loadu_ps(p);
}
static inline void rti_f4_store(float *p, rti_f4 a)
{
    _mm_storeu_ps(p, a);
}
static inline rti_f4 rti_f4_set(float x, float y, float z, float w)
{
    return _mm_setr_ps(x, y, z, w);
}
static inline rti_f4 rti_f4_min(rti_f4 a, rti_f4 b)
{
    return _mm_min_ps(a, b);
}
static inline rti_f4 rti_f4_max(rti_f4 a, rti_f4 b)
{
    return _mm_max_ps(a, b);
}
static inline rti_f4 rti_f4_add(rti_f4 a, rti_f4 b)
{
    return _mm_add_ps(a, b);
}
static inline rti_f4 rti_f4_sub(rti_f4 a, rti_f4 b)
{
    return _mm_sub_ps(a, b);
}
static inline rti_f4 rti_f4_mul(rti_f4 a, rti_f4 b)
{
    return _mm_mul_ps(a, b);
}
/* The first three; the fourth is 0. */
static inline rti_f4 rti_f4_xyz(rti_f4 a)
{
    return _mm_and_ps(a, _mm_castsi128_ps(_mm_setr_epi32(-1, -1, -1, 0)));
}
/* yes ? a : b, in all four. */
static inline rti_f4 rti_f4_pick(int yes, rti_f4 a, rti_f4 b)
{
    __m128 m = _mm_castsi128_ps(_mm_set1_epi32(-yes));
    return _mm_or_ps(_mm_and_ps(m, a), _mm_andnot_ps(m, b));
}
/* Cut off behind the point; values must be in the range of int32_t. */
static inline void rti_f4_int(rti_f4 a, int32_t out[4])
{
    _mm_storeu_si128((__m128i *)(void *)out, _mm_cvttps_epi32(a));
}
/* a <= b in each of the first three */
static inline int rti_f4_below(rti_f4 a, rti_f4 b)
{
    return (_mm_movemask_ps(_mm_cmple_ps(a, b)) & 7) == 7;
}
/* x y + y z + z x */
static inline float rti_f4_area(rti_f4 a)
{
    __m128 p = _mm_mul_ps(a, _mm_shuffle_ps(a, a, _MM_SHUFFLE(3, 0, 2, 1)));
    return (_mm_cvtss_f32(p) + _mm_cvtss_f32(_mm_shuffle_ps(p, p, _MM_SHUFFLE(1, 1, 1, 1)))) +
           _mm_cvtss_f32(_mm_shuffle_ps(p, p, _MM_SHUFFLE(2, 2, 2, 2)));
}

#else

typedef struct rti_f4 {
    float v[4];
} rti_f4;

#define RTI_F4_EACH(expression)                                                                                                  \
    rti_f4 r;                                                                                                                    \
    for (int i = 0; i < 4; i++)                                                                                                  \
        r.v[i] = (expression);                                                                                                   \
    return r

static inline rti_f4 rti_f4_load(const float *p)
{
    RTI_F4_EACH(p[i]);
}
static inline void rti_f4_store(float *p, rti_f4 a)
{
    memcpy(p, a.v, sizeof a.v);
}
static inline rti_f4 rti_f4_set(float x, float y, float z, float w)
{
    return (rti_f4){{x, y, z, w}};
}
static inline rti_f4 rti_f4_min(rti_f4 a, rti_f4 b)
{
    RTI_F4_EACH(rtk_min(a.v[i], b.v[i]));
}
static inline rti_f4 rti_f4_max(rti_f4 a, rti_f4 b)
{
    RTI_F4_EACH(rtk_max(a.v[i], b.v[i]));
}
static inline rti_f4 rti_f4_add(rti_f4 a, rti_f4 b)
{
    RTI_F4_EACH(a.v[i] + b.v[i]);
}
static inline rti_f4 rti_f4_sub(rti_f4 a, rti_f4 b)
{
    RTI_F4_EACH(a.v[i] - b.v[i]);
}
static inline rti_f4 rti_f4_mul(rti_f4 a, rti_f4 b)
{
    RTI_F4_EACH(a.v[i] * b.v[i]);
}
static inline rti_f4 rti_f4_xyz(rti_f4 a)
{
    a.v[3] = 0.0f;
    return a;
}
static inline rti_f4 rti_f4_pick(int yes, rti_f4 a, rti_f4 b)
{
    return yes ? a : b;
}
static inline void rti_f4_int(rti_f4 a, int32_t out[4])
{
    for (int i = 0; i < 4; i++)
        out[i] = (int32_t)a.v[i];
}
static inline int rti_f4_below(rti_f4 a, rti_f4 b)
{
    return a.v[0] <= b.v[0] && a.v[1] <= b.v[1] && a.v[2] <= b.v[2];
}
static inline float rti_f4_area(rti_f4 a)
{
    return (a.v[0] * a.v[1] + a.v[1] * a.v[2]) + a.v[2] * a.v[0];
}

#endif

#endif
