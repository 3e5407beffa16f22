/* Four and eight lanes, AVX2. Included by simd.h. */
#define RTI_SIMD 8
#include "sse42.h"

typedef __m256 rti_f8, rti_m8;

RTI_VEC rti_f8 rti_f8_set(float x)
{
    return _mm256_set1_ps(x);
}
RTI_VEC rti_f8 rti_f8_load(const float *p)
{
    return _mm256_loadu_ps(p);
}
RTI_VEC void rti_f8_store(float *p, rti_f8 a)
{
    _mm256_storeu_ps(p, a);
}
RTI_VEC rti_f8 rti_f8_min(rti_f8 a, rti_f8 b)
{
    return _mm256_min_ps(a, b);
}
RTI_VEC rti_f8 rti_f8_max(rti_f8 a, rti_f8 b)
{
    return _mm256_max_ps(a, b);
}
RTI_VEC rti_f8 rti_f8_abs(rti_f8 a)
{
    return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), a);
}
RTI_VEC rti_m8 rti_f8_lt(rti_f8 a, rti_f8 b)
{
    return _mm256_cmp_ps(a, b, _CMP_LT_OQ);
}
RTI_VEC rti_m8 rti_f8_le(rti_f8 a, rti_f8 b)
{
    return _mm256_cmp_ps(a, b, _CMP_LE_OQ);
}
RTI_VEC rti_m8 rti_f8_eq(rti_f8 a, rti_f8 b)
{
    return _mm256_cmp_ps(a, b, _CMP_EQ_OQ);
}
RTI_VEC rti_f8 rti_f8_select(rti_m8 m, rti_f8 a, rti_f8 b)
{
    return _mm256_blendv_ps(b, a, m);
}
RTI_VEC rti_m8 rti_m8_and(rti_m8 a, rti_m8 b)
{
    return _mm256_and_ps(a, b);
}
RTI_VEC rti_m8 rti_m8_or(rti_m8 a, rti_m8 b)
{
    return _mm256_or_ps(a, b);
}
RTI_VEC rti_m8 rti_m8_andnot(rti_m8 a, rti_m8 b)
{
    return _mm256_andnot_ps(b, a);
}
RTI_VEC uint32_t rti_m8_bits(rti_m8 m)
{
    return (uint32_t)_mm256_movemask_ps(m);
}
RTI_VEC rti_m8 rti_m8_of(uint32_t bits)
{
    __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    return _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32((int)bits), bit), bit));
}
