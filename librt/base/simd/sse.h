/* Four lanes: SSE4.2, or SSE2, which every 64-bit x86 has. Included by simd.h. */
#include <immintrin.h>

#define RTI_SIMD 4

#define COMPARE(op, a, b) _mm_cmp##op##_ps(a, b)
#if defined(__SSE4_1__)
#define SELECT(m, a, b) _mm_blendv_ps(b, a, m)
#else
#define SELECT(m, a, b) _mm_or_ps(_mm_and_ps(m, a), _mm_andnot_ps(m, b))
#endif

#define RTI_N  4
#define VECTOR __m128
#define MM(op) _mm_##op
#include "x86.inl"

#undef COMPARE
#undef SELECT
