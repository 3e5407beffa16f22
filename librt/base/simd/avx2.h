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
