/* Four, eight and sixteen lanes, AVX-512 with VL, DQ and BW, and with VBMI2 where the level has it: masks are bits. Included by
 * simd.h. */
#ifndef LIBRT_EMULATED /* else they are there (tests/emulate/avx512.h) */
#include <immintrin.h>
#endif

#define RTI_SIMD 16

#define ORDER_lt          _CMP_LT_OQ
#define ORDER_le          _CMP_LE_OQ
#define ORDER_eq          _CMP_EQ_OQ
#define COMPARE(op, a, b) MM(cmp_ps_mask)(a, b, ORDER_##op)
#define SELECT(m, a, b)   MM(mask_blend_ps)(m, b, a)

#define RTI_N     4
#define VECTOR    __m128
#define MM(op)    _mm_##op
#define MASK_BITS __mmask8
#include "x86.inl"

#define RTI_N     8
#define VECTOR    __m256
#define MM(op)    _mm256_##op
#define MASK_BITS __mmask8
#include "x86.inl"

#define RTI_N     16
#define VECTOR    __m512
#define MM(op)    _mm512_##op
#define MASK_BITS __mmask16
#include "x86.inl"

#undef ORDER_lt
#undef ORDER_le
#undef ORDER_eq
#undef COMPARE
#undef SELECT

#define RTI_PACK  1
#define RTI_PACK8 1
RTI_VEC void rti_f8_pack(float *p, uint32_t bits, rti_f8 a)
{
    _mm256_storeu_ps(p, _mm256_maskz_compress_ps((__mmask8)bits, a));
}
RTI_VEC void rti_u8_pack(uint32_t *p, uint32_t bits, const uint32_t *a)
{
    _mm256_storeu_si256((__m256i *)(void *)p,
                        _mm256_maskz_compress_epi32((__mmask8)bits, _mm256_loadu_si256((const __m256i *)(const void *)a)));
}
#define RTI_MSUB 1
RTI_VEC rti_f8 rti_f8_msub(rti_f8 a, rti_f8 b, rti_f8 c)
{
    return _mm256_maskz_fmsub_ps((__mmask8)255, a, b, c); /* the plain one is not for who has no -mfma */
}
RTI_VEC rti_f16 rti_f16_msub(rti_f16 a, rti_f16 b, rti_f16 c)
{
    return _mm512_maskz_fmsub_ps((__mmask16)65535, a, b, c);
}
RTI_VEC rti_f4 rti_f4_madd(rti_f4 a, rti_f4 b, rti_f4 c)
{
    return _mm_maskz_fmadd_ps((__mmask8)15, a, b, c);
}
RTI_VEC rti_f8 rti_f8_madd(rti_f8 a, rti_f8 b, rti_f8 c)
{
    return _mm256_maskz_fmadd_ps((__mmask8)255, a, b, c);
}
RTI_VEC rti_f16 rti_f16_madd(rti_f16 a, rti_f16 b, rti_f16 c)
{
    return _mm512_maskz_fmadd_ps((__mmask16)65535, a, b, c);
}
RTI_VEC void rti_f16_put(float *p, uint32_t bits, rti_f16 a)
{
    const __mmask16 some = (__mmask16)((1u << __builtin_popcount(bits & 0xffffu)) - 1u);
    _mm512_mask_storeu_ps(p, some, _mm512_maskz_compress_ps((__mmask16)bits, a));
}
RTI_VEC uint32_t rti_first(uint32_t bits, uint32_t n)
{
    return _pdep_u32((1u << n) - 1u, bits);
}
typedef __m512i rti_i16;
RTI_VEC rti_i16 rti_i16_load(const uint32_t *p)
{
    return _mm512_loadu_si512((const void *)p);
}
RTI_VEC uint32_t rti_u32_unlike(const uint32_t p[16], uint32_t word)
{
    return _mm512_cmpneq_epi32_mask(_mm512_loadu_si512((const void *)p), _mm512_set1_epi32((int)word));
}
RTI_VEC void rti_u8_pairs(uint32_t *p, uint32_t bits, const uint32_t *a, const uint32_t *b)
{
    const __m512i turn = _mm512_setr_epi32(0, 8, 1, 9, 2, 10, 3, 11, 4, 12, 5, 13, 6, 14, 7, 15);
    const __m512i both = _mm512_inserti64x4(_mm512_castsi256_si512(_mm256_loadu_si256((const __m256i *)(const void *)a)),
                                            _mm256_loadu_si256((const __m256i *)(const void *)b), 1);
    _mm512_storeu_si512((void *)p, _mm512_maskz_compress_epi64((__mmask8)bits, _mm512_permutexvar_epi32(turn, both)));
}
RTI_VEC void rti_i16_store(uint32_t *p, rti_i16 a)
{
    _mm512_storeu_si512((void *)p, a);
}
RTI_VEC uint32_t rti_i16_same(rti_i16 a, uint32_t n, uint32_t b)
{
    const __m512i low = _mm512_set1_epi32((int)(b * n));
    return _mm512_cmplt_epu32_mask(_mm512_sub_epi32(a, low), _mm512_set1_epi32((int)n));
}
RTI_VEC rti_f16 rti_f16_mix(rti_f16 a, uint32_t bits, rti_f16 b, rti_i16 from)
{
    return _mm512_mask_permutexvar_ps(a, (__mmask16)bits, from, b);
}
RTI_VEC rti_f16 rti_f16_take(rti_f16 a, rti_i16 from)
{
    return _mm512_permutexvar_ps(from, a);
}
RTI_VEC rti_f16 rti_f16_each(const float *p, const uint32_t at[4])
{
    __m512 a = _mm512_set1_ps(p[at[0]]);
    a = _mm512_mask_broadcastss_ps(a, (__mmask16)0x00f0, _mm_load_ss(p + at[1]));
    a = _mm512_mask_broadcastss_ps(a, (__mmask16)0x0f00, _mm_load_ss(p + at[2]));
    return _mm512_mask_broadcastss_ps(a, (__mmask16)0xf000, _mm_load_ss(p + at[3]));
}
RTI_VEC rti_f16 rti_f16_row(const float *p)
{
    return _mm512_broadcast_f32x4(_mm_loadu_ps(p));
}
RTI_VEC rti_f16 rti_f16_twelve(const float *p)
{
    return _mm512_maskz_loadu_ps((__mmask16)0x0fff, p);
}
RTI_VEC rti_f16 rti_f16_nine(const float *p)
{
    return _mm512_maskz_loadu_ps((__mmask16)0x01ff, p);
}
RTI_VEC void rti_f16_corners(const float *v0, const float *v1, const float *v2, uint32_t z, float *p)
{
#define FIRST(x, y, z)                                                                                                           \
    {                                                                                                                            \
        4 * (x), 4 * (y), 4 * (z), 16 + 4 * (x), 16 + 4 * (y), 16 + 4 * (z)                                                     \
    }
#define LAST(x, y, z)                                                                                                            \
    {                                                                                                                            \
        0, 0, 0, 0, 0, 0, 4 * (x), 4 * (y), 4 * (z)                                                                             \
    }
    static const int32_t first[3][16] = {FIRST(1, 2, 0), FIRST(2, 0, 1), FIRST(0, 1, 2)};
    static const int32_t last[3][16] = {LAST(1, 2, 0), LAST(2, 0, 1), LAST(0, 1, 2)};
#undef FIRST
#undef LAST
    const __m512 a = _mm512_permutex2var_ps(rti_f16_nine(v0), _mm512_loadu_si512(first[z]), rti_f16_nine(v1));
    _mm512_storeu_ps(p, _mm512_mask_permutexvar_ps(a, (__mmask16)0x01c0, _mm512_loadu_si512(last[z]), rti_f16_nine(v2)));
}
RTI_VEC rti_f16 rti_f16_fourths(const float *p)
{
    const __m512i low = _mm512_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28, 0, 4, 8, 12, 16, 20, 24, 28);
    const __m512 a = _mm512_permutex2var_ps(_mm512_loadu_ps(p), low, _mm512_loadu_ps(p + 16));
    const __m512 b = _mm512_permutex2var_ps(_mm512_loadu_ps(p + 32), low, _mm512_loadu_ps(p + 48));
    return _mm512_mask_mov_ps(a, (__mmask16)0xff00, b);
}
RTI_VEC rti_i16 rti_i16_row(rti_f16 a)
{
    const __m512i lane = _mm512_setr_epi32(0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3);
    return _mm512_add_epi32(_mm512_slli_epi32(_mm512_cvttps_epi32(a), 2), lane);
}
RTI_VEC rti_i16 rti_i16_next(rti_i16 a)
{
    const __m512i next = _mm512_add_epi32(a, _mm512_set1_epi32(4));
    return _mm512_mask_sub_epi32(next, _mm512_cmpgt_epi32_mask(next, _mm512_set1_epi32(11)), next, _mm512_set1_epi32(12));
}
RTI_VEC rti_f4 rti_f4_take(const float *p, const int32_t lanes[4])
{
    return _mm_permutevar_ps(_mm_loadu_ps(p), _mm_loadu_si128((const __m128i *)(const void *)lanes));
}
RTI_VEC void rti_u8_take(uint32_t *to, const uint32_t *from, const uint32_t *lane)
{
    _mm256_storeu_si256((__m256i *)(void *)to, _mm256_permutexvar_epi32(_mm256_loadu_si256((const __m256i *)(const void *)lane),
                                                                        _mm256_loadu_si256((const __m256i *)(const void *)from)));
}
RTI_VEC void rti_u16_last(uint16_t to[16], const uint16_t *from, uint32_t n)
{
    const __m256i all = _mm256_loadu_si256((const __m256i *)(const void *)from), last = _mm256_set1_epi16((short)from[n - 1u]);
    _mm256_storeu_si256((__m256i *)(void *)to, _mm256_mask_mov_epi16(last, (__mmask16)((1u << n) - 1u), all));
}
typedef __m128i rti_b16;
RTI_VEC rti_b16 rti_b16_load(const uint8_t *p)
{
    return _mm_loadu_si128((const __m128i *)(const void *)p);
}
#ifdef __AVX512VBMI2__
RTI_VEC __m256i rti_u16_chosen(__m256i a, uint32_t bits)
{
    return _mm256_maskz_compress_epi16((__mmask16)bits, a);
}
RTI_VEC uint32_t rti_u16_put32(uint16_t *to, const uint16_t *from, uint32_t bits)
{
    _mm512_storeu_si512((void *)to, _mm512_maskz_compress_epi16((__mmask32)bits, _mm512_loadu_si512((const void *)from)));
    return (uint32_t)__builtin_popcount(bits);
}
#else
RTI_VEC __m256i rti_u16_chosen(__m256i a, uint32_t bits)
{
    return _mm512_cvtepi32_epi16(_mm512_maskz_compress_epi32((__mmask16)bits, _mm512_cvtepu16_epi32(a)));
}
#endif
RTI_VEC uint32_t rti_u16_put(uint16_t *to, const uint16_t *from, uint32_t bits)
{
    const __m256i all = _mm256_loadu_si256((const __m256i *)(const void *)from);
    _mm256_storeu_si256((__m256i *)(void *)to, rti_u16_chosen(all, bits));
    return (uint32_t)__builtin_popcount(bits);
}
#ifndef __AVX512VBMI2__
RTI_VEC uint32_t rti_u16_put32(uint16_t *to, const uint16_t *from, uint32_t bits)
{
    const uint32_t n = rti_u16_put(to, from, bits & 0xffffu);
    return n + rti_u16_put(to + n, from + 16, bits >> 16);
}
#endif
RTI_VEC uint32_t rti_u16_some(uint16_t *to, uint16_t *bits, const uint16_t *from, const uint16_t *of, uint32_t n)
{
    const __m512i all = _mm512_loadu_si512((const void *)of);
    const uint32_t some = _mm512_test_epi16_mask(all, all) & (n < 32u ? (1u << n) - 1u : 0xffffffffu);
    rti_u16_put32(bits, of, some);
    return rti_u16_put32(to, from, some);
}
RTI_VEC uint32_t rti_u16_count(uint16_t *to, uint32_t first, uint32_t bits)
{
    const __m256i all = _mm256_add_epi16(_mm256_setr_epi16(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15),
                                         _mm256_set1_epi16((short)first));
    _mm256_storeu_si256((__m256i *)(void *)to, rti_u16_chosen(all, bits));
    return (uint32_t)__builtin_popcount(bits);
}
RTI_VEC uint32_t rti_u16_deal(uint16_t *to, const uint16_t *from, rti_b16 bytes, uint32_t bit, uint32_t n)
{
    const uint32_t some = _mm_test_epi8_mask(bytes, _mm_set1_epi8((char)(1u << bit)));
    return rti_u16_put(to, from, n < 16u ? some & ((1u << n) - 1u) : some);
}
RTI_VEC void rti_f16_fields(const float *p, const uint32_t at[4], rti_f16 out[8])
{
    const __m512 a = _mm512_insertf32x8(_mm512_castps256_ps512(_mm256_loadu_ps(p + at[0])), _mm256_loadu_ps(p + at[1]), 1);
    const __m512 b = _mm512_insertf32x8(_mm512_castps256_ps512(_mm256_loadu_ps(p + at[2])), _mm256_loadu_ps(p + at[3]), 1);
    __m512i k = _mm512_setr_epi32(0, 0, 0, 0, 8, 8, 8, 8, 16, 16, 16, 16, 24, 24, 24, 24);
    for (uint32_t i = 0; i < 8; i++, k = _mm512_add_epi32(k, _mm512_set1_epi32(1)))
        out[i] = _mm512_permutex2var_ps(a, k, b);
}
#define PAIR(a, b, how) _mm512_castpd_ps(_mm512_##how##_pd(_mm512_castps_pd(a), _mm512_castps_pd(b)))
RTI_VEC void rti_f16_records(const float *p, const uint16_t at[16], rti_f16 out[8])
{
    __m512 a[8], b[8];
    for (uint32_t i = 0; i < 8; i++) /* rows i and i + 8 */
        a[i] =
            _mm512_insertf32x8(_mm512_castps256_ps512(_mm256_loadu_ps(p + 8u * at[i])), _mm256_loadu_ps(p + 8u * at[i + 8]), 1);
    for (uint32_t i = 0; i < 8; i += 2) {
        b[i] = _mm512_unpacklo_ps(a[i], a[i + 1]);
        b[i + 1] = _mm512_unpackhi_ps(a[i], a[i + 1]);
    }
    for (uint32_t i = 0; i < 8; i += 4)
        for (uint32_t k = 0; k < 2; k++) {
            a[i + 2 * k] = PAIR(b[i + k], b[i + k + 2], unpacklo);
            a[i + 2 * k + 1] = PAIR(b[i + k], b[i + k + 2], unpackhi);
        }
    /* a[k], a[k + 4]: of fields k (low quarters) and k + 4 (high ones), rows 0 to 3 and 4 to 7, of both halves */
    const __m512i low = _mm512_setr_epi32(0, 1, 2, 3, 16, 17, 18, 19, 8, 9, 10, 11, 24, 25, 26, 27);
    const __m512i high = _mm512_add_epi32(low, _mm512_set1_epi32(4));
    for (uint32_t k = 0; k < 4; k++) {
        out[k] = _mm512_permutex2var_ps(a[k], low, a[k + 4]);
        out[k + 4] = _mm512_permutex2var_ps(a[k], high, a[k + 4]);
    }
}
RTI_VEC void rti_f16_spread(const rti_f16 a[8], float *p, const uint32_t at[16])
{
    __m512 b[8], c[8];
    const __m512i low = _mm512_setr_epi32(0, 1, 2, 3, 16, 17, 18, 19, 8, 9, 10, 11, 24, 25, 26, 27);
    const __m512i high = _mm512_add_epi32(low, _mm512_set1_epi32(4));
    for (uint32_t k = 0; k < 4; k++) { /* the way back of rti_f16_records */
        b[k] = _mm512_permutex2var_ps(a[k], low, a[k + 4]);
        b[k + 4] = _mm512_permutex2var_ps(a[k], high, a[k + 4]);
    }
    for (uint32_t i = 0; i < 8; i += 4)
        for (uint32_t k = 0; k < 2; k++) {
            c[i + k] = _mm512_unpacklo_ps(b[i + 2 * k], b[i + 2 * k + 1]);
            c[i + k + 2] = _mm512_unpackhi_ps(b[i + 2 * k], b[i + 2 * k + 1]);
        }
    for (uint32_t i = 0; i < 8; i += 2) {
        const uint32_t from = (i & 4) + (i & 2);
        const __m512 even = PAIR(c[from], c[from + 1], unpacklo), odd = PAIR(c[from], c[from + 1], unpackhi);
        _mm256_storeu_ps(p + at[i], _mm512_castps512_ps256(even));
        _mm256_storeu_ps(p + at[i + 1], _mm512_castps512_ps256(odd));
        _mm256_storeu_ps(p + at[i + 8], _mm512_extractf32x8_ps(even, 1));
        _mm256_storeu_ps(p + at[i + 9], _mm512_extractf32x8_ps(odd, 1));
    }
}
RTI_VEC rti_f16 rti_f16_least4(rti_f16 a)
{
    a = _mm512_min_ps(a, _mm512_permute_ps(a, 0xb1));
    return _mm512_min_ps(a, _mm512_permute_ps(a, 0x4e));
}
RTI_VEC void rti_f16_keep4(float *hit, float *end, const uint32_t hit_at[4], const uint32_t end_at[4], uint32_t take, rti_f16 t,
                           rti_f16 u, rti_f16 v, rti_f16 e, uint32_t place)
{
    const __m512i lane = _mm512_setr_epi32(0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3);
    const __m512 w = _mm512_castsi512_ps(_mm512_add_epi32(lane, _mm512_set1_epi32((int)place)));
    const __m512 tu0 = _mm512_unpacklo_ps(t, u), tu1 = _mm512_unpackhi_ps(t, u), vw0 = _mm512_unpacklo_ps(v, w),
                 vw1 = _mm512_unpackhi_ps(v, w);
    const __m512 r0 = PAIR(tu0, vw0, unpacklo), r1 = PAIR(tu0, vw0, unpackhi), r2 = PAIR(tu1, vw1, unpacklo),
                 r3 = PAIR(tu1, vw1, unpackhi);
    const __m512i of = _mm512_maskz_mov_epi32((__mmask16)take, lane);
    __m512i which = _mm512_or_si512(of, _mm512_shuffle_epi32(of, 0xb1));
    which = _mm512_or_si512(which, _mm512_shuffle_epi32(which, 0x4e));
    __m512 r = r0;
    r = _mm512_mask_mov_ps(r, _mm512_cmpeq_epi32_mask(which, _mm512_set1_epi32(1)), r1);
    r = _mm512_mask_mov_ps(r, _mm512_cmpeq_epi32_mask(which, _mm512_set1_epi32(2)), r2);
    r = _mm512_mask_mov_ps(r, _mm512_cmpeq_epi32_mask(which, _mm512_set1_epi32(3)), r3);
    const __m512 last = _mm512_permutevar_ps(e, which);
#define KEEP(i)                                                                                                                  \
    {                                                                                                                            \
        const __m128 x = _mm512_extractf32x4_ps(r, i);                                                                           \
        const __mmask8 m = take >> 4 * (i) & 15u ? 15 : 0;                                                                       \
        _mm_mask_storeu_ps(hit + hit_at[i], m, x);                                                                               \
        _mm_mask_store_ss(end + end_at[i], m & 1, _mm512_extractf32x4_ps(last, i));                                              \
    }
    KEEP(0) KEEP(1) KEEP(2) KEEP(3)
#undef KEEP
}
RTI_VEC rti_f16 rti_f16_column(const float *p, uint32_t stride, const uint16_t at[16])
{
    const __m512i i = _mm512_cvtepu16_epi32(_mm256_loadu_si256((const __m256i *)(const void *)at));
    return _mm512_i32gather_ps(_mm512_mullo_epi32(i, _mm512_set1_epi32((int)stride)), p, 4);
}
RTI_VEC rti_i16 rti_i16_rows(const float *p, uint32_t stride, const uint16_t at[16])
{
    return _mm512_slli_epi32(_mm512_cvttps_epi32(rti_f16_column(p, stride, at)), 2);
}
RTI_VEC rti_i16 rti_i16_ranks(uint32_t bits)
{
    const __m256i low = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    const __m256i high = _mm256_add_epi32(low, _mm256_set1_epi32(__builtin_popcount(bits & 255u)));
    return _mm512_inserti64x4(_mm512_castsi256_si512(_mm256_maskz_expand_epi32((__mmask8)bits, low)),
                              _mm256_maskz_expand_epi32((__mmask8)(bits >> 8), high), 1);
}
/* Counts of keys are told in four bits each: of the lanes before one there are fifteen at most. */
RTI_VEC rti_i16 rti_i16_places(rti_i16 key, uint32_t of, uint32_t next[8])
{
    const __m512i none = _mm512_setzero_si512(), by = _mm512_slli_epi32(key, 2), most = _mm512_set1_epi32(15);
    const __m512i own = _mm512_maskz_sllv_epi32((__mmask16)of, _mm512_set1_epi32(1), by);
    const __m256i had = _mm256_loadu_si256((const __m256i *)(const void *)next);
    const __m256i shift = _mm256_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28), few = _mm256_set1_epi32(15);
    __m512i before = _mm512_alignr_epi32(own, none, 15);
    before = _mm512_add_epi32(before, _mm512_alignr_epi32(before, none, 15));
    before = _mm512_add_epi32(before, _mm512_alignr_epi32(before, none, 14));
    before = _mm512_add_epi32(before, _mm512_alignr_epi32(before, none, 12));
    before = _mm512_add_epi32(before, _mm512_alignr_epi32(before, none, 8));
    const __m256i all = _mm512_castsi512_si256(_mm512_permutexvar_epi32(most, before)),
                  last = _mm512_castsi512_si256(_mm512_permutexvar_epi32(most, own));
    const __m256i more = _mm256_add_epi32(_mm256_and_si256(_mm256_srlv_epi32(all, shift), few),
                                          _mm256_and_si256(_mm256_srlv_epi32(last, shift), few));
    _mm256_storeu_si256((__m256i *)(void *)next, _mm256_add_epi32(had, more));
    return _mm512_add_epi32(_mm512_permutexvar_epi32(key, _mm512_castsi256_si512(had)),
                            _mm512_and_si512(_mm512_srlv_epi32(before, by), most));
}
RTI_VEC void rti_f16_twos(rti_f16 a, rti_f16 b, float *p, const uint32_t at[16])
{
    const __m512 low = _mm512_unpacklo_ps(a, b), high = _mm512_unpackhi_ps(a, b);
#define TWOS(i)                                                                                                                  \
    {                                                                                                                            \
        const __m128 x = _mm512_extractf32x4_ps(low, i), y = _mm512_extractf32x4_ps(high, i);                                    \
        _mm_storel_pi((__m64 *)(void *)(p + at[4 * (i)]), x);                                                                    \
        _mm_storeh_pi((__m64 *)(void *)(p + at[4 * (i) + 1]), x);                                                                \
        _mm_storel_pi((__m64 *)(void *)(p + at[4 * (i) + 2]), y);                                                                \
        _mm_storeh_pi((__m64 *)(void *)(p + at[4 * (i) + 3]), y);                                                                \
    }
    TWOS(0) TWOS(1) TWOS(2) TWOS(3)
#undef TWOS
}
RTI_VEC void rti_f16_fours(rti_f16 a, rti_f16 b, rti_f16 c, rti_f16 d, float *p, const uint32_t at[16])
{
    const __m512 ab0 = _mm512_unpacklo_ps(a, b), ab1 = _mm512_unpackhi_ps(a, b);
    const __m512 cd0 = _mm512_unpacklo_ps(c, d), cd1 = _mm512_unpackhi_ps(c, d);
    const __m512 r[4] = {PAIR(ab0, cd0, unpacklo), PAIR(ab0, cd0, unpackhi), PAIR(ab1, cd1, unpacklo), PAIR(ab1, cd1, unpackhi)};
    for (uint32_t k = 0; k < 4; k++) {
        _mm_storeu_ps(p + at[k], _mm512_castps512_ps128(r[k]));
        _mm_storeu_ps(p + at[4 + k], _mm512_extractf32x4_ps(r[k], 1));
        _mm_storeu_ps(p + at[8 + k], _mm512_extractf32x4_ps(r[k], 2));
        _mm_storeu_ps(p + at[12 + k], _mm512_extractf32x4_ps(r[k], 3));
    }
}
RTI_VEC void rti_rows4(const float *const from[16], float (*to)[16])
{
    __m512 a[4];
    for (uint32_t i = 0; i < 4; i++) {
        a[i] = _mm512_castps128_ps512(_mm_loadu_ps(from[i]));
        a[i] = _mm512_insertf32x4(a[i], _mm_loadu_ps(from[4 + i]), 1);
        a[i] = _mm512_insertf32x4(a[i], _mm_loadu_ps(from[8 + i]), 2);
        a[i] = _mm512_insertf32x4(a[i], _mm_loadu_ps(from[12 + i]), 3);
    }
    const __m512 ab0 = _mm512_unpacklo_ps(a[0], a[1]), ab1 = _mm512_unpackhi_ps(a[0], a[1]);
    const __m512 cd0 = _mm512_unpacklo_ps(a[2], a[3]), cd1 = _mm512_unpackhi_ps(a[2], a[3]);
    _mm512_storeu_ps(to[0], PAIR(ab0, cd0, unpacklo));
    _mm512_storeu_ps(to[1], PAIR(ab0, cd0, unpackhi));
    _mm512_storeu_ps(to[2], PAIR(ab1, cd1, unpacklo));
    _mm512_storeu_ps(to[3], PAIR(ab1, cd1, unpackhi));
}
/* As at AVX2, records 0 to 7 in the lower lanes, 8 to 15 in the upper ones. */
RTI_VEC void rti_nines(const float *p, float *const to[9])
{
#define TURNED(k)                                                                                                                \
    {                                                                                                                            \
        (k) % 8, (1 + (k)) % 8, (2 + (k)) % 8, (3 + (k)) % 8, (4 + (k)) % 8, (5 + (k)) % 8, (6 + (k)) % 8, (7 + (k)) % 8,        \
            8 + (k) % 8, 8 + (1 + (k)) % 8, 8 + (2 + (k)) % 8, 8 + (3 + (k)) % 8, 8 + (4 + (k)) % 8, 8 + (5 + (k)) % 8,          \
            8 + (6 + (k)) % 8, 8 + (7 + (k)) % 8                                                                                 \
    }
    static const int32_t lane[8][16] = {TURNED(0), TURNED(1), TURNED(2), TURNED(3), TURNED(4), TURNED(5), TURNED(6), TURNED(7)};
#undef TURNED
    __m512 a[9], b[9];
    for (uint32_t i = 0; i < 9; i++)
        a[i] = _mm512_insertf32x8(_mm512_castps256_ps512(_mm256_loadu_ps(p + 8 * i)), _mm256_loadu_ps(p + 72 + 8 * i), 1);
    for (uint32_t i = 0; i < 9; i++)
        b[i] = _mm512_mask_blend_ps(0xaaaa, a[i], a[(i + 1) % 9]);
    for (uint32_t i = 0; i < 9; i++)
        a[i] = _mm512_mask_blend_ps(0xcccc, b[i], b[(i + 2) % 9]);
    for (uint32_t i = 0; i < 9; i++)
        b[i] = _mm512_mask_blend_ps(0xf0f0, a[i], a[(i + 4) % 9]);
    for (uint32_t k = 0; k < 9; k++)
        _mm512_storeu_ps(to[k], _mm512_permutexvar_ps(_mm512_loadu_si512(lane[k % 8]), b[(9 - k) % 9]));
}
/* In pairs of words a record has three, pair 3 i + f in lane (3 i + f) % 8 of a vector: there the pairs of eight records are put,
 * of each f in one vector, and blended. */
RTI_VEC void rti_sixes(const float *const from[6], float *p)
{
    static const int32_t pair[3][16] = {{0, 16, 3, 19, 6, 22, 1, 17, 4, 20, 7, 23, 2, 18, 5, 21},
                                        {5, 21, 0, 16, 3, 19, 6, 22, 1, 17, 4, 20, 7, 23, 2, 18},
                                        {2, 18, 5, 21, 0, 16, 3, 19, 6, 22, 1, 17, 4, 20, 7, 23}};
    for (int32_t h = 0; h < 16; h += 8, p += 48) {
        __m512d f[3];
        for (uint32_t k = 0; k < 3; k++) {
            const __m512i at = _mm512_add_epi32(_mm512_loadu_si512(pair[k]), _mm512_set1_epi32(h));
            f[k] = _mm512_castps_pd(_mm512_permutex2var_ps(_mm512_loadu_ps(from[2 * k]), at, _mm512_loadu_ps(from[2 * k + 1])));
        }
        /* f of lane q of the vector at 16 j is (8 j + q) % 3 */
        _mm512_storeu_pd(p, _mm512_mask_blend_pd(0x24, _mm512_mask_blend_pd(0x92, f[0], f[1]), f[2]));
        _mm512_storeu_pd(p + 16, _mm512_mask_blend_pd(0x24, _mm512_mask_blend_pd(0x92, f[2], f[0]), f[1]));
        _mm512_storeu_pd(p + 32, _mm512_mask_blend_pd(0x24, _mm512_mask_blend_pd(0x92, f[1], f[2]), f[0]));
    }
}
RTI_VEC float rti_f16_low(rti_f16 a)
{
    return _mm512_reduce_min_ps(a);
}
RTI_VEC rti_f16 rti_f16_lows(const rti_f16 a[16])
{
    __m512 b[8], c[4], d[2];
    for (uint32_t i = 0; i < 8; i++) /* of lanes of vectors 2 i and 2 i + 1 by turns, and so on */
        b[i] = _mm512_min_ps(_mm512_unpacklo_ps(a[2 * i], a[2 * i + 1]), _mm512_unpackhi_ps(a[2 * i], a[2 * i + 1]));
    for (uint32_t i = 0; i < 4; i++)
        c[i] = _mm512_min_ps(PAIR(b[2 * i], b[2 * i + 1], unpacklo), PAIR(b[2 * i], b[2 * i + 1], unpackhi));
    for (uint32_t i = 0; i < 2; i++)
        d[i] =
            _mm512_min_ps(_mm512_shuffle_f32x4(c[2 * i], c[2 * i + 1], 0x88), _mm512_shuffle_f32x4(c[2 * i], c[2 * i + 1], 0xdd));
    return _mm512_min_ps(_mm512_shuffle_f32x4(d[0], d[1], 0x88), _mm512_shuffle_f32x4(d[0], d[1], 0xdd));
}
RTI_VEC rti_f8 rti_f16_lows8(const rti_f16 a[8])
{
    __m512 b[4], c[2];
    for (uint32_t i = 0; i < 4; i++)
        b[i] = _mm512_min_ps(_mm512_unpacklo_ps(a[2 * i], a[2 * i + 1]), _mm512_unpackhi_ps(a[2 * i], a[2 * i + 1]));
    for (uint32_t i = 0; i < 2; i++)
        c[i] = _mm512_min_ps(PAIR(b[2 * i], b[2 * i + 1], unpacklo), PAIR(b[2 * i], b[2 * i + 1], unpackhi));
    const __m512 d = _mm512_min_ps(_mm512_shuffle_f32x4(c[0], c[1], 0x44), _mm512_shuffle_f32x4(c[0], c[1], 0xee));
    return _mm512_castps512_ps256(_mm512_min_ps(_mm512_shuffle_f32x4(d, d, 0x08), _mm512_shuffle_f32x4(d, d, 0x0d)));
}
#undef PAIR
/* Numbers in the order of floats. */
RTI_VEC __m256i rti_f8_order(rti_f8 a)
{
    const __m256i bits = _mm256_castps_si256(a); /* a ^ (b & c) */
    return _mm256_ternarylogic_epi32(bits, _mm256_srai_epi32(bits, 31), _mm256_set1_epi32(0x7fffffff), 0x78);
}
RTI_VEC uint32_t rti_f8_least(uint32_t bits, rti_f8 a)
{
    const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    __m256i key = _mm256_or_si256(_mm256_and_si256(rti_f8_order(a), _mm256_set1_epi32(~7)), lane);
    key = _mm256_mask_blend_epi32((__mmask8)bits, _mm256_set1_epi32(0x7fffffff), key);
    __m128i k = _mm_min_epi32(_mm256_castsi256_si128(key), _mm256_extracti128_si256(key, 1));
    k = _mm_min_epi32(k, _mm_shuffle_epi32(k, 0x4e));
    k = _mm_min_epi32(k, _mm_shuffle_epi32(k, 0xb1));
    return (uint32_t)_mm_cvtsi128_si32(k) & 7u;
}
/* Keys of the distances' bits and the lanes through Batcher's network: six layers. */
RTI_VEC void rti_f8_sorted(float *t, uint32_t *lane, uint32_t bits, rti_f8 a)
{
    const __m256i number = _mm256_setr_epi32(7, 6, 5, 4, 3, 2, 1, 0);
    __m256i key = _mm256_or_si256(_mm256_and_si256(rti_f8_order(a), _mm256_set1_epi32(~7)), number), other;
    key = _mm256_mask_blend_epi32((__mmask8)bits, _mm256_or_si256(number, _mm256_set1_epi32((int)0x80000000u)), key);
#define LAYER(partner, less)                                                                                                     \
    other = partner;                                                                                                             \
    key = _mm256_mask_min_epi32(_mm256_max_epi32(key, other), (__mmask8)(less), key, other)
    LAYER(_mm256_shuffle_epi32(key, 0xb1), 0xaa);
    LAYER(_mm256_shuffle_epi32(key, 0x4e), 0xcc);
    LAYER(_mm256_permutexvar_epi32(_mm256_setr_epi32(0, 2, 1, 3, 4, 6, 5, 7), key), 0x44);
    LAYER(_mm256_permute4x64_epi64(key, 0x4e), 0xf0);
    LAYER(_mm256_permutexvar_epi32(_mm256_setr_epi32(0, 1, 4, 5, 2, 3, 6, 7), key), 0x30);
    LAYER(_mm256_permutexvar_epi32(_mm256_setr_epi32(0, 2, 1, 4, 3, 6, 5, 7), key), 0x54);
#undef LAYER
    key = _mm256_andnot_si256(key, _mm256_set1_epi32(7));
    _mm256_storeu_ps(t, _mm256_permutexvar_ps(key, a));
    _mm256_storeu_si256((__m256i *)(void *)lane, key);
}
#define CHOOSE(fill, bits, a) _mm256_mask_compress_epi32(fill, (__mmask8)(bits), a)
#define PERMUTE(a, lanes)     _mm256_permutexvar_epi32(lanes, a)
#include "queue.inl"
