/* Four, eight and sixteen lanes, AVX-512 with VL and DQ: masks are bits. Included by simd.h. */
#include <immintrin.h>

#define RTI_SIMD 16

typedef __m128 rti_f4;
typedef __mmask8 rti_m4;

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
    return _mm_cmp_ps_mask(a, b, _CMP_LT_OQ);
}
RTI_VEC rti_m4 rti_f4_le(rti_f4 a, rti_f4 b)
{
    return _mm_cmp_ps_mask(a, b, _CMP_LE_OQ);
}
RTI_VEC rti_m4 rti_f4_eq(rti_f4 a, rti_f4 b)
{
    return _mm_cmp_ps_mask(a, b, _CMP_EQ_OQ);
}
RTI_VEC rti_f4 rti_f4_select(rti_m4 m, rti_f4 a, rti_f4 b)
{
    return _mm_mask_blend_ps(m, b, a);
}
RTI_VEC rti_m4 rti_m4_and(rti_m4 a, rti_m4 b)
{
    return (rti_m4)(a & b);
}
RTI_VEC rti_m4 rti_m4_or(rti_m4 a, rti_m4 b)
{
    return (rti_m4)(a | b);
}
RTI_VEC rti_m4 rti_m4_andnot(rti_m4 a, rti_m4 b)
{
    return (rti_m4)(a & ~b);
}
RTI_VEC uint32_t rti_m4_bits(rti_m4 m)
{
    return m;
}
RTI_VEC rti_m4 rti_m4_of(uint32_t bits)
{
    return (rti_m4)(bits & 0xfu);
}

typedef __m256 rti_f8;
typedef __mmask8 rti_m8;

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
    return _mm256_cmp_ps_mask(a, b, _CMP_LT_OQ);
}
RTI_VEC rti_m8 rti_f8_le(rti_f8 a, rti_f8 b)
{
    return _mm256_cmp_ps_mask(a, b, _CMP_LE_OQ);
}
RTI_VEC rti_m8 rti_f8_eq(rti_f8 a, rti_f8 b)
{
    return _mm256_cmp_ps_mask(a, b, _CMP_EQ_OQ);
}
RTI_VEC rti_f8 rti_f8_select(rti_m8 m, rti_f8 a, rti_f8 b)
{
    return _mm256_mask_blend_ps(m, b, a);
}
RTI_VEC rti_m8 rti_m8_and(rti_m8 a, rti_m8 b)
{
    return (rti_m8)(a & b);
}
RTI_VEC rti_m8 rti_m8_or(rti_m8 a, rti_m8 b)
{
    return (rti_m8)(a | b);
}
RTI_VEC rti_m8 rti_m8_andnot(rti_m8 a, rti_m8 b)
{
    return (rti_m8)(a & ~b);
}
RTI_VEC uint32_t rti_m8_bits(rti_m8 m)
{
    return m;
}
RTI_VEC rti_m8 rti_m8_of(uint32_t bits)
{
    return (rti_m8)(bits & 0xffu);
}

/* Eight lanes of two fours. */
RTI_VEC rti_f8 rti_f8_join(rti_f4 low, rti_f4 high)
{
    return _mm256_insertf128_ps(_mm256_castps128_ps256(low), high, 1);
}

/* Lanes chosen by bits, packed from the first on; all eight places behind p are written. */
#define RTI_PACK 1
RTI_VEC void rti_f8_pack(float *p, uint32_t bits, rti_f8 a)
{
    _mm256_storeu_ps(p, _mm256_maskz_compress_ps((__mmask8)bits, a));
}
RTI_VEC void rti_u8_pack(uint32_t *p, uint32_t bits, const uint32_t *a)
{
    _mm256_storeu_si256((__m256i *)(void *)p,
                        _mm256_maskz_compress_epi32((__mmask8)bits, _mm256_loadu_si256((const __m256i *)(const void *)a)));
}

/* The chosen lane that holds the least value, as good as 21 bits of mantissa tell; of negative ones, any. */
RTI_VEC uint32_t rti_f8_least(uint32_t bits, rti_f8 a)
{
    const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    __m256i key = _mm256_or_si256(_mm256_and_si256(_mm256_castps_si256(a), _mm256_set1_epi32(~7)), lane);
    key = _mm256_mask_blend_epi32((__mmask8)bits, _mm256_set1_epi32(-1), key);
    __m128i k = _mm_min_epu32(_mm256_castsi256_si128(key), _mm256_extracti128_si256(key, 1));
    k = _mm_min_epu32(k, _mm_shuffle_epi32(k, 0x4e));
    k = _mm_min_epu32(k, _mm_shuffle_epi32(k, 0xb1));
    return (uint32_t)_mm_cvtsi128_si32(k) & 7u;
}

typedef __m512 rti_f16;
typedef __mmask16 rti_m16;

RTI_VEC rti_f16 rti_f16_set(float x)
{
    return _mm512_set1_ps(x);
}
RTI_VEC rti_f16 rti_f16_load(const float *p)
{
    return _mm512_loadu_ps(p);
}
RTI_VEC void rti_f16_store(float *p, rti_f16 a)
{
    _mm512_storeu_ps(p, a);
}
RTI_VEC rti_f16 rti_f16_min(rti_f16 a, rti_f16 b)
{
    return _mm512_min_ps(a, b);
}
RTI_VEC rti_f16 rti_f16_max(rti_f16 a, rti_f16 b)
{
    return _mm512_max_ps(a, b);
}
RTI_VEC rti_f16 rti_f16_abs(rti_f16 a)
{
    return _mm512_andnot_ps(_mm512_set1_ps(-0.0f), a);
}
RTI_VEC rti_m16 rti_f16_lt(rti_f16 a, rti_f16 b)
{
    return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ);
}
RTI_VEC rti_m16 rti_f16_le(rti_f16 a, rti_f16 b)
{
    return _mm512_cmp_ps_mask(a, b, _CMP_LE_OQ);
}
RTI_VEC rti_m16 rti_f16_eq(rti_f16 a, rti_f16 b)
{
    return _mm512_cmp_ps_mask(a, b, _CMP_EQ_OQ);
}
RTI_VEC rti_f16 rti_f16_select(rti_m16 m, rti_f16 a, rti_f16 b)
{
    return _mm512_mask_blend_ps(m, b, a);
}
RTI_VEC rti_m16 rti_m16_and(rti_m16 a, rti_m16 b)
{
    return (rti_m16)(a & b);
}
RTI_VEC rti_m16 rti_m16_or(rti_m16 a, rti_m16 b)
{
    return (rti_m16)(a | b);
}
RTI_VEC rti_m16 rti_m16_andnot(rti_m16 a, rti_m16 b)
{
    return (rti_m16)(a & ~b);
}
RTI_VEC uint32_t rti_m16_bits(rti_m16 m)
{
    return m;
}
RTI_VEC rti_m16 rti_m16_of(uint32_t bits)
{
    return (rti_m16)(bits & 0xffffu);
}
