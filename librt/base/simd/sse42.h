/* Four lanes, SSE4.2. Included by simd.h, and by avx2.h. */
#include <immintrin.h>

#ifndef RTI_SIMD
#define RTI_SIMD 4
#endif
typedef __m128 rti_f4, rti_m4;

RTI_VEC rti_f4 rti_f4_set(float x)
{
    return _mm_set1_ps(x);
}
RTI_VEC rti_f4 rti_f4_load(const float *p)
{
    return _mm_loadu_ps(p);
}
RTI_VEC void rti_f4_store(float *p, rti_f4 a)
{
    _mm_storeu_ps(p, a);
}
RTI_VEC rti_f4 rti_f4_min(rti_f4 a, rti_f4 b)
{
    return _mm_min_ps(a, b);
}
RTI_VEC rti_f4 rti_f4_max(rti_f4 a, rti_f4 b)
{
    return _mm_max_ps(a, b);
}
RTI_VEC rti_f4 rti_f4_abs(rti_f4 a)
{
    return _mm_andnot_ps(_mm_set1_ps(-0.0f), a);
}
RTI_VEC rti_m4 rti_f4_lt(rti_f4 a, rti_f4 b)
{
    return _mm_cmplt_ps(a, b);
}
RTI_VEC rti_m4 rti_f4_le(rti_f4 a, rti_f4 b)
{
    return _mm_cmple_ps(a, b);
}
RTI_VEC rti_m4 rti_f4_eq(rti_f4 a, rti_f4 b)
{
    return _mm_cmpeq_ps(a, b);
}
RTI_VEC rti_f4 rti_f4_select(rti_m4 m, rti_f4 a, rti_f4 b)
{
    return _mm_blendv_ps(b, a, m);
}
RTI_VEC rti_m4 rti_m4_and(rti_m4 a, rti_m4 b)
{
    return _mm_and_ps(a, b);
}
RTI_VEC rti_m4 rti_m4_or(rti_m4 a, rti_m4 b)
{
    return _mm_or_ps(a, b);
}
RTI_VEC rti_m4 rti_m4_andnot(rti_m4 a, rti_m4 b)
{
    return _mm_andnot_ps(b, a);
}
RTI_VEC uint32_t rti_m4_bits(rti_m4 m)
{
    return (uint32_t)_mm_movemask_ps(m);
}
RTI_VEC rti_m4 rti_m4_of(uint32_t bits)
{
    __m128i bit = _mm_setr_epi32(1, 2, 4, 8);
    return _mm_castsi128_ps(_mm_cmpeq_epi32(_mm_and_si128(_mm_set1_epi32((int)bits), bit), bit));
}
