/* Four and eight lanes, AVX2. Included by simd.h. */
#include <immintrin.h>

#define RTI_SIMD 8

#define ORDER_lt          _CMP_LT_OQ
#define ORDER_le          _CMP_LE_OQ
#define ORDER_eq          _CMP_EQ_OQ
#define COMPARE(op, a, b) MM(cmp_ps)(a, b, ORDER_##op)
#define SELECT(m, a, b)   MM(blendv_ps)(b, a, m)

#define RTI_N  4
#define VECTOR __m128
#define MM(op) _mm_##op
#include "x86.inl"

#define RTI_N  8
#define VECTOR __m256
#define MM(op) _mm256_##op
#include "x86.inl"

#undef ORDER_lt
#undef ORDER_le
#undef ORDER_eq
#undef COMPARE
#undef SELECT

#define RTI_MSUB 1
RTI_VEC rti_f8 rti_f8_msub(rti_f8 a, rti_f8 b, rti_f8 c)
{
    return _mm256_fmsub_ps(a, b, c);
}
RTI_VEC rti_f4 rti_f4_madd(rti_f4 a, rti_f4 b, rti_f4 c)
{
    return _mm_fmadd_ps(a, b, c);
}
RTI_VEC rti_f8 rti_f8_madd(rti_f8 a, rti_f8 b, rti_f8 c)
{
    return _mm256_fmadd_ps(a, b, c);
}

#define PAIR(a, b, how) _mm256_castpd_ps(_mm256_##how##_pd(_mm256_castps_pd(a), _mm256_castps_pd(b)))
RTI_VEC void rti_rows4(const float *const from[16], float (*to)[16])
{
    for (uint32_t h = 0; h < 16; h += 8) {
        __m256 a[4];
        for (uint32_t i = 0; i < 4; i++)
            a[i] = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(from[h + i])), _mm_loadu_ps(from[h + 4 + i]), 1);
        const __m256 ab0 = _mm256_unpacklo_ps(a[0], a[1]), ab1 = _mm256_unpackhi_ps(a[0], a[1]);
        const __m256 cd0 = _mm256_unpacklo_ps(a[2], a[3]), cd1 = _mm256_unpackhi_ps(a[2], a[3]);
        _mm256_storeu_ps(to[0] + h, PAIR(ab0, cd0, unpacklo));
        _mm256_storeu_ps(to[1] + h, PAIR(ab0, cd0, unpackhi));
        _mm256_storeu_ps(to[2] + h, PAIR(ab1, cd1, unpacklo));
        _mm256_storeu_ps(to[3] + h, PAIR(ab1, cd1, unpackhi));
    }
}
#undef PAIR
