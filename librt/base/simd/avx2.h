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

RTI_VEC uint32_t rti_u32_unlike(const uint32_t p[16], uint32_t word)
{
    const __m256i all = _mm256_set1_epi32((int)word);
    const __m256i low = _mm256_cmpeq_epi32(_mm256_loadu_si256((const __m256i *)(const void *)p), all);
    const __m256i high = _mm256_cmpeq_epi32(_mm256_loadu_si256((const __m256i *)(const void *)(p + 8)), all);
    const uint32_t alike = (uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(low)) |
                           (uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(high)) << 8;
    return ~alike & 0xffffu;
}

/* ---- lanes chosen by bits ---- */

#define RTI_PACK8 1

/* Of each byte the numbers of the bits that are set, the lowest first, a byte each. */
#define NEXT(v, m, i) ((v) * (1u + 255u * ((m) >> (i)&1u)) + (i) * ((m) >> (i)&1u))
#define CHOSEN(m)                                                                                                                \
    NEXT(NEXT(NEXT(NEXT(NEXT(NEXT(NEXT(NEXT(UINT64_C(0), m, 7u), m, 6u), m, 5u), m, 4u), m, 3u), m, 2u), m, 1u), m, 0u)
#define CHOSEN4(m)  CHOSEN(m), CHOSEN((m) + 1u), CHOSEN((m) + 2u), CHOSEN((m) + 3u)
#define CHOSEN16(m) CHOSEN4(m), CHOSEN4((m) + 4u), CHOSEN4((m) + 8u), CHOSEN4((m) + 12u)
#define CHOSEN64(m) CHOSEN16(m), CHOSEN16((m) + 16u), CHOSEN16((m) + 32u), CHOSEN16((m) + 48u)
static const uint64_t rti_chosen[256] = {CHOSEN64(0u), CHOSEN64(64u), CHOSEN64(128u), CHOSEN64(192u)};
#undef CHOSEN64
#undef CHOSEN16
#undef CHOSEN4
#undef CHOSEN
#undef NEXT

RTI_VEC __m256i rti_u8_chosen(uint32_t bits)
{
    return _mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i *)(const void *)&rti_chosen[bits]));
}
RTI_VEC void rti_f8_pack(float *p, uint32_t bits, rti_f8 a)
{
    _mm256_storeu_ps(p, _mm256_permutevar8x32_ps(a, rti_u8_chosen(bits)));
}
RTI_VEC __m256i rti_u8_load(const uint32_t *p)
{
    return _mm256_loadu_si256((const __m256i *)(const void *)p);
}
RTI_VEC void rti_u8_pack(uint32_t *p, uint32_t bits, const uint32_t *a)
{
    _mm256_storeu_si256((__m256i *)(void *)p, _mm256_permutevar8x32_epi32(rti_u8_load(a), rti_u8_chosen(bits)));
}
RTI_VEC rti_f4 rti_f4_take(const float *p, const int32_t lanes[4])
{
    return _mm_permutevar_ps(_mm_loadu_ps(p), _mm_loadu_si128((const __m128i *)(const void *)lanes));
}
RTI_VEC rti_f8 rti_f8_take(const float p[8], const uint32_t lanes[8])
{
    return _mm256_permutevar8x32_ps(_mm256_loadu_ps(p), _mm256_loadu_si256((const __m256i *)(const void *)lanes));
}
RTI_VEC void rti_u8_take(uint32_t *to, const uint32_t *from, const uint32_t *lane)
{
    _mm256_storeu_si256((__m256i *)(void *)to, _mm256_permutevar8x32_epi32(rti_u8_load(from), rti_u8_load(lane)));
}
/* Numbers in the order of floats. */
RTI_VEC __m256i rti_f8_order(rti_f8 a)
{
    const __m256i bits = _mm256_castps_si256(a);
    return _mm256_xor_si256(bits, _mm256_srli_epi32(_mm256_srai_epi32(bits, 31), 1));
}
RTI_VEC uint32_t rti_f8_least(uint32_t bits, rti_f8 a)
{
    const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    __m256i key = _mm256_or_si256(_mm256_and_si256(rti_f8_order(a), _mm256_set1_epi32(~7)), lane);
    key = _mm256_blendv_epi8(_mm256_set1_epi32(0x7fffffff), key, _mm256_castps_si256(rti_m8_of(bits)));
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
    key = _mm256_blendv_epi8(_mm256_or_si256(number, _mm256_set1_epi32((int)0x80000000u)), key,
                             _mm256_castps_si256(rti_m8_of(bits)));
#define LAYER(partner, less)                                                                                                     \
    other = partner;                                                                                                             \
    key = _mm256_blend_epi32(_mm256_max_epi32(key, other), _mm256_min_epi32(key, other), less)
    LAYER(_mm256_shuffle_epi32(key, 0xb1), 0xaa);
    LAYER(_mm256_shuffle_epi32(key, 0x4e), 0xcc);
    LAYER(_mm256_shuffle_epi32(key, 0xd8), 0x44);
    LAYER(_mm256_permute4x64_epi64(key, 0x4e), 0xf0);
    LAYER(_mm256_permute4x64_epi64(key, 0xd8), 0x30);
    LAYER(_mm256_permutevar8x32_epi32(key, _mm256_setr_epi32(0, 2, 1, 4, 3, 6, 5, 7)), 0x54);
#undef LAYER
    key = _mm256_andnot_si256(key, _mm256_set1_epi32(7));
    _mm256_storeu_ps(t, _mm256_permutevar8x32_ps(a, key));
    _mm256_storeu_si256((__m256i *)(void *)lane, key);
}

RTI_VEC __m256i rti_u8_chosen_or(__m256i fill, uint32_t bits, __m256i a)
{
    const __m256i is = _mm256_cmpgt_epi32(_mm256_set1_epi32(__builtin_popcount(bits)), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
    return _mm256_blendv_epi8(fill, _mm256_permutevar8x32_epi32(a, rti_u8_chosen(bits)), is);
}
#define CHOOSE(fill, bits, a) rti_u8_chosen_or(fill, bits, a)
#define PERMUTE(a, lanes)     _mm256_permutevar8x32_epi32(a, lanes)
#include "queue.inl"

/* ---- lists of sixteen-bit numbers ---- */

typedef __m128i rti_b16;
RTI_VEC rti_b16 rti_b16_load(const uint8_t *p)
{
    return _mm_loadu_si128((const __m128i *)(const void *)p);
}
/* Eight of them, those chosen to the front. */
RTI_VEC __m128i rti_u16_chosen(__m128i a, uint32_t bits)
{
    const __m128i n = _mm_loadl_epi64((const __m128i *)(const void *)&rti_chosen[bits]), twice = _mm_add_epi8(n, n);
    return _mm_shuffle_epi8(a, _mm_add_epi8(_mm_unpacklo_epi8(twice, twice), _mm_set1_epi16(0x0100)));
}
RTI_VEC uint32_t rti_u16_put(uint16_t *to, const uint16_t *from, uint32_t bits)
{
    const __m128i low = _mm_loadu_si128((const __m128i *)(const void *)from);
    const __m128i high = _mm_loadu_si128((const __m128i *)(const void *)(from + 8));
    const uint32_t n = (uint32_t)__builtin_popcount(bits & 255u);
    _mm_storeu_si128((__m128i *)(void *)to, rti_u16_chosen(low, bits & 255u));
    _mm_storeu_si128((__m128i *)(void *)(to + n), rti_u16_chosen(high, bits >> 8));
    return (uint32_t)__builtin_popcount(bits);
}
RTI_VEC uint32_t rti_u16_deal(uint16_t *to, const uint16_t *from, rti_b16 bytes, uint32_t bit, uint32_t n)
{
    const uint32_t some = (uint32_t)_mm_movemask_epi8(_mm_sll_epi16(bytes, _mm_cvtsi32_si128((int)(7u - bit))));
    return rti_u16_put(to, from, n < 16u ? some & ((1u << n) - 1u) : some);
}

RTI_VEC uint32_t rti_u16_count(uint16_t *to, uint32_t first, uint32_t bits)
{
    const __m128i low = _mm_add_epi16(_mm_setr_epi16(0, 1, 2, 3, 4, 5, 6, 7), _mm_set1_epi16((short)first));
    const uint32_t n = (uint32_t)__builtin_popcount(bits & 255u);
    _mm_storeu_si128((__m128i *)(void *)to, rti_u16_chosen(low, bits & 255u));
    _mm_storeu_si128((__m128i *)(void *)(to + n), rti_u16_chosen(_mm_add_epi16(low, _mm_set1_epi16(8)), bits >> 8));
    return (uint32_t)__builtin_popcount(bits);
}
RTI_VEC void rti_u16_last(uint16_t to[8], const uint16_t *from, uint32_t n)
{
    const __m128i all = _mm_loadu_si128((const __m128i *)(const void *)from), last = _mm_set1_epi16((short)from[n - 1u]);
    const __m128i lane = _mm_setr_epi16(0, 1, 2, 3, 4, 5, 6, 7);
    _mm_storeu_si128((__m128i *)(void *)to, _mm_blendv_epi8(last, all, _mm_cmpgt_epi16(_mm_set1_epi16((short)n), lane)));
}

/* ---- rays in records ---- */

RTI_VEC void rti_f8_records(const float *p, const uint16_t at[8], rti_f8 out[8])
{
    for (uint32_t h = 0; h < 8; h += 4) {
        __m256 a[4];
        for (uint32_t i = 0; i < 4; i++)
            a[i] = rti_f8_two(p + 8u * at[i] + h, p + 8u * at[4 + i] + h);
        rti_f8_turn(a, out + h);
    }
}
RTI_VEC void rti_f8_fours(rti_f8 a, rti_f8 b, rti_f8 c, rti_f8 d, float *p, const uint32_t at[8])
{
    const __m256 in[4] = {a, b, c, d};
    __m256 out[4];
    rti_f8_turn(in, out);
    for (uint32_t i = 0; i < 4; i++) {
        rti_f4_store(p + at[i], rti_f8_low(out[i]));
        rti_f4_store(p + at[4 + i], rti_f8_high(out[i]));
    }
}
RTI_VEC void rti_f8_twos(rti_f8 a, rti_f8 b, float *p, const uint32_t at[8])
{
    const __m256 low = _mm256_unpacklo_ps(a, b), high = _mm256_unpackhi_ps(a, b);
    for (uint32_t h = 0; h < 2; h++) {
        const __m128 x = h == 0 ? _mm256_castps256_ps128(low) : _mm256_extractf128_ps(low, 1);
        const __m128 y = h == 0 ? _mm256_castps256_ps128(high) : _mm256_extractf128_ps(high, 1);
        _mm_storel_pi((__m64 *)(void *)(p + at[4 * h]), x);
        _mm_storeh_pi((__m64 *)(void *)(p + at[4 * h + 1]), x);
        _mm_storel_pi((__m64 *)(void *)(p + at[4 * h + 2]), y);
        _mm_storeh_pi((__m64 *)(void *)(p + at[4 * h + 3]), y);
    }
}
RTI_VEC void rti_f8_spread(const rti_f8 a[8], float *p, const uint32_t at[8])
{
    __m256 low[4], high[4];
    rti_f8_turn(a, low);
    rti_f8_turn(a + 4, high);
    for (uint32_t i = 0; i < 4; i++)
        _mm256_storeu_ps(p + at[i], rti_f8_lows(low[i], high[i]));
    for (uint32_t i = 0; i < 4; i++)
        _mm256_storeu_ps(p + at[4 + i], rti_f8_highs(low[i], high[i]));
}
RTI_VEC void rti_f8_fields(const float *p, const uint32_t at[2], rti_f8 out[8])
{
    const __m256 a = rti_f8_two(p + at[0], p + at[1]), b = rti_f8_two(p + at[0] + 4, p + at[1] + 4);
    out[0] = _mm256_permute_ps(a, 0x00);
    out[1] = _mm256_permute_ps(a, 0x55);
    out[2] = _mm256_permute_ps(a, 0xaa);
    out[3] = _mm256_permute_ps(a, 0xff);
    out[4] = _mm256_permute_ps(b, 0x00);
    out[5] = _mm256_permute_ps(b, 0x55);
    out[6] = _mm256_permute_ps(b, 0xaa);
    out[7] = _mm256_permute_ps(b, 0xff);
}
RTI_VEC rti_f8 rti_f8_each(const float *p, const uint32_t at[2])
{
    return _mm256_insertf128_ps(_mm256_broadcast_ss(p + at[0]), _mm_broadcast_ss(p + at[1]), 1);
}
RTI_VEC rti_f8 rti_f8_row(const float *p)
{
    return _mm256_broadcast_ps((const __m128 *)(const void *)p);
}
RTI_VEC rti_f8 rti_f8_column(const float *p, uint32_t stride, const uint16_t at[8])
{
    return _mm256_setr_ps(p[stride * at[0]], p[stride * at[1]], p[stride * at[2]], p[stride * at[3]], p[stride * at[4]],
                          p[stride * at[5]], p[stride * at[6]], p[stride * at[7]]);
}
typedef __m256i rti_i8;
RTI_VEC rti_i8 rti_i8_load(const uint32_t *p)
{
    return _mm256_loadu_si256((const __m256i *)(const void *)p);
}
RTI_VEC void rti_i8_store(uint32_t *p, rti_i8 a)
{
    _mm256_storeu_si256((__m256i *)(void *)p, a);
}
/* A row as the bytes of its lane among four: vectors of AVX2 whose halves go one after the other (Zen 1) choose bytes four times as
 * fast as floats. */
RTI_VEC rti_i8 rti_i8_rows(const float *p, uint32_t stride, const uint16_t at[8])
{
    const __m256i rows = _mm256_cvttps_epi32(rti_f8_column(p, stride, at));
    return _mm256_add_epi32(_mm256_mullo_epi32(rows, _mm256_set1_epi32(0x04040404)), _mm256_set1_epi32(0x03020100));
}
/* Bits as bytes of 0 and 1, and their sums. */
RTI_VEC rti_i8 rti_i8_ranks(uint32_t bits)
{
    const uint64_t one = UINT64_C(0x0101010101010101), apart = one * bits & UINT64_C(0x8040201008040201);
    const uint64_t each = (apart + UINT64_C(0x00406070787c7e7f)) >> 7 & one;
    return _mm256_cvtepu8_epi32(_mm_cvtsi64_si128((int64_t)(each * (one << 8))));
}
/* As at AVX-512. */
RTI_VEC rti_i8 rti_i8_places(rti_i8 key, uint32_t of, uint32_t next[8])
{
    const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7), none = _mm256_setzero_si256(), one = _mm256_set1_epi32(1);
    const __m256i by = _mm256_slli_epi32(key, 2), most = _mm256_set1_epi32(15), shift = _mm256_slli_epi32(lane, 2);
    const __m256i own = _mm256_sllv_epi32(_mm256_and_si256(_mm256_srlv_epi32(_mm256_set1_epi32((int)of), lane), one), by);
    const __m256i had = _mm256_loadu_si256((const __m256i *)(const void *)next);
#define BEHIND(x, k, kept)                                                                                                       \
    _mm256_blend_epi32(none, _mm256_permutevar8x32_epi32(x, _mm256_sub_epi32(lane, _mm256_set1_epi32(k))), kept)
    __m256i before = BEHIND(own, 1, 0xfe);
    before = _mm256_add_epi32(before, BEHIND(before, 1, 0xfe));
    before = _mm256_add_epi32(before, BEHIND(before, 2, 0xfc));
    before = _mm256_add_epi32(before, BEHIND(before, 4, 0xf0));
#undef BEHIND
    const __m256i all = _mm256_permutevar8x32_epi32(_mm256_add_epi32(before, own), _mm256_set1_epi32(7));
    _mm256_storeu_si256((__m256i *)(void *)next, _mm256_add_epi32(had, _mm256_and_si256(_mm256_srlv_epi32(all, shift), most)));
    return _mm256_add_epi32(_mm256_permutevar8x32_epi32(had, key), _mm256_and_si256(_mm256_srlv_epi32(before, by), most));
}
RTI_VEC rti_i8 rti_i8_next(rti_i8 a)
{
    const __m256i next = _mm256_add_epi32(a, _mm256_set1_epi32(0x04040404)), first = _mm256_set1_epi32(0x03020100);
    return _mm256_blendv_epi8(first, next, _mm256_cmpgt_epi32(_mm256_set1_epi32(0x0c0c0c0c), next));
}
RTI_VEC rti_f8 rti_f8_corner(const float p[4], rti_i8 rows)
{
    return _mm256_castsi256_ps(_mm256_shuffle_epi8(_mm256_castps_si256(rti_f8_row(p)), rows));
}
RTI_VEC void rti_rows4(const float *const from[16], float (*to)[16])
{
    for (uint32_t h = 0; h < 16; h += 8) {
        __m256 a[4], b[4];
        for (uint32_t i = 0; i < 4; i++)
            a[i] = rti_f8_two(from[h + i], from[h + 4 + i]);
        rti_f8_turn(a, b);
        for (uint32_t i = 0; i < 4; i++)
            _mm256_storeu_ps(to[i] + h, b[i]);
    }
}
/* Record i, k: word 9 i + k is lane l = (i + k) % 8 of vector (l - k) modulo 9. So blends by one, two and four bring a column
 * into one vector, turned by k lanes. */
RTI_VEC void rti_nines(const float *p, float *const to[9])
{
    static const int32_t lane[16] = {0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5, 6, 7};
    for (uint32_t h = 0; h < 16; h += 8, p += 72) {
        __m256 a[9], b[9];
        for (uint32_t i = 0; i < 9; i++)
            a[i] = _mm256_loadu_ps(p + 8 * i);
        for (uint32_t i = 0; i < 9; i++)
            b[i] = _mm256_blend_ps(a[i], a[(i + 1) % 9], 0xaa);
        for (uint32_t i = 0; i < 9; i++)
            a[i] = _mm256_blend_ps(b[i], b[(i + 2) % 9], 0xcc);
        for (uint32_t i = 0; i < 9; i++)
            b[i] = _mm256_blend_ps(a[i], a[(i + 4) % 9], 0xf0);
        for (uint32_t k = 0; k < 9; k++)
            _mm256_storeu_ps(to[k] + h, _mm256_permutevar8x32_ps(
                                            b[(9 - k) % 9], _mm256_loadu_si256((const __m256i *)(const void *)(lane + k % 8))));
    }
}
RTI_VEC void rti_sixes(const float *const from[6], float *p)
{
    for (uint32_t h = 0; h < 16; h += 8, p += 48) {
        const __m256 a[4] = {_mm256_loadu_ps(from[0] + h), _mm256_loadu_ps(from[1] + h), _mm256_loadu_ps(from[2] + h),
                             _mm256_loadu_ps(from[3] + h)};
        const __m256 e = _mm256_loadu_ps(from[4] + h), f = _mm256_loadu_ps(from[5] + h);
        const __m256 pairs[2] = {_mm256_unpacklo_ps(e, f), _mm256_unpackhi_ps(e, f)};
        __m256 b[4];
        rti_f8_turn(a, b);
        for (uint32_t i = 0; i < 8; i++) {
            const __m128 four = i < 4 ? _mm256_castps256_ps128(b[i % 4]) : _mm256_extractf128_ps(b[i % 4], 1);
            const __m256 both = pairs[i % 4 / 2];
            const __m128 two = i < 4 ? _mm256_castps256_ps128(both) : _mm256_extractf128_ps(both, 1);
            _mm_storeu_ps(p + 6 * i, four);
            if (i % 2 == 0)
                _mm_storel_pi((__m64 *)(void *)(p + 6 * i + 4), two);
            else
                _mm_storeh_pi((__m64 *)(void *)(p + 6 * i + 4), two);
        }
    }
}
