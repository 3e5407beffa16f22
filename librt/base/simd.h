/* Vectors for hot files (isa.h): rti_f4, and where the processor has them rti_f8 and rti_f16; RTI_SIMD is the widest. Files that
 * are compiled once have those of the compiler's baseline.
 *
 * They are the compiler's own vector types: + - * / and unary minus stand for themselves, are correctly rounded and are never
 * contracted. The rest, for N = 4, 8, 16 and masks rti_mN (whose form differs: only these functions may look inside):
 *   rti_fN_set(x)  _load(p)  _store(p, a)             any alignment
 *   rti_fN_min(a, b)  _max(a, b)                      a < b ? a : b and a > b ? a : b, so b when one is NaN, as rtk_min, rtk_max
 *   rti_fN_abs(a)  _sqrt(a)                           the root correctly rounded
 *   rti_fN_msub(a, b, c)  _madd(a, b, c)              a * b - c and a * b + c, rounded once or twice: for bounds, not for hits
 *   rti_fN_lt(a, b)  _le(a, b)  _eq(a, b)             masks; false where one is NaN
 *   rti_fN_select(m, a, b)                            m ? a : b
 *   rti_fN_unless(m, a)                               m ? NaN : a
 *   rti_mN_and(a, b)  _or(a, b)  _andnot(a, b)        a and not b
 *   rti_mN_bits(m)  _of(bits)                         lane i is bit i
 *   rti_f4_take(p, lanes)                             p[lanes[i]] in lane i, numbers below 4
 *   rti_f4_words(p, q, r, s)                          the words there, of whatever type
 *   rti_f8_two(p, q)                                  p[0] to p[3] and q[0] to q[3], where there is rti_f8; likewise
 *   rti_f8_both(p, q)  _low(a)  _high(a)              p and q; the first four lanes of a, and the others
 *   rti_f8_lows(a, b)  _highs(a, b)                   the first four of a and of b, and the others
 *   rti_f8_turn(a, b)                                 as rti_f4_turn, of each four
 *   rti_f4_turn(a, b)                                 b[i] has lane i of a[0] to a[3]
 *   rti_rows4(from, to)                               to[k][i] = from[i][k], for k below 4 and i below 16
 *   rti_nines(p, to)                                  to[k][i] = p[9 i + k], for k below 9 and i below 16
 *   rti_sixes(from, p)                                p[6 i + k] = from[k][i], for k below 6 and i below 16
 *   rti_sums(a, b, c, to)                             to[i] = a[i], b[i], c[i] and 0, for i below 16; a, b, c: of 16 uint64_t
 *   rti_u32_unlike(p, word)                           of p[0] to p[15] those that are not `word`, as bits
 *   rti_sum_add(p, a)                                 p[0] to p[3] grow by an rti_sum
 *
 * Where RTI_PACK8 is defined (AVX2, AVX-512), of lanes chosen by bits, too; N: the widest, RTI_SIMD:
 *   rti_f8_pack(p, bits, a)  rti_u8_pack(p, bits, a)  the chosen lanes of a vector, or of a[8], side by side from p on; all eight
 *                                                     places behind p are written
 *   rti_f8_sorted(t, lane, bits, a)
 *                             the chosen lanes of a and their numbers, the greatest first, as good as 21 bits of mantissa tell; of
 *                             equal ones the first; all eight places behind t and lane are written
 *   rti_f8_queue(p, u_p, v_p, bits, a, u, v)
 *                             the chosen lanes of a to p, the greatest in size first, as good as 21 bits of mantissa tell, of equal
 *                             ones the first, and those of u[8] and v[8] likewise; returns the last one's lane. bits is not 0; all
 *                             eight places may be written
 *   rti_f8_least(bits, a)     the lane that holds the least of the chosen, as good as 21 bits of mantissa tell, of equal ones the
 *                             first; bits is not 0
 *   rti_u8_take(p, a, lanes)  a[lanes[0]] to a[lanes[7]] to p; those of other lanes than 0 to 7: anything in a
 *   rti_fN_records(p, at, a)  a[k] has p[8 at[i] + k] in lane i, for k below 8; at: N of sixteen bits
 *   rti_fN_spread(a, p, at)   p[at[i] + k] is lane i of a[k], for k below 8; where places are the same, of one of the lanes
 *   rti_fN_column(p, n, at)   p[n at[i]] in lane i; at: N of sixteen bits
 *   rti_fN_fours(a, b, c, d, p, at)
 *                             from p[at[i]] on lane i of a, b, c and d; rti_fN_twos(a, b, p, at) of a and b; likewise
 *   rti_iN_ranks(bits)        in the chosen lanes how many chosen ones are before them, in others anything; no bits from N on
 *   rti_iN_places(key, bits, n)
 *                             in the chosen lanes n[key[i]], keys below 8, and how many chosen lanes before lane i have that key, in
 *                             others anything; then n[8] goes on by the chosen lanes. rti_iN_load(p)  _store(p, a)
 *   rti_iN_rows(p, n, at)     a row of three for each lane: p[n at[i]], which is 0, 1 or 2; at: N of sixteen bits
 *   rti_iN_next(rows)         the rows behind those, the first behind the last
 *   rti_u16_put(p, a, bits)   of a[0] to a[15] those chosen by bits, side by side; returns how many. All sixteen places behind p are
 *                             written, those behind a read
 *   rti_fN_row(p)             p[0] to p[3], again and again
 *   rti_fN_each(p, at)        p[at[0]] four times, p[at[1]] four times and so on
 *   rti_fN_fields(p, at, a)   a[k] is p[at[0] + k] four times, p[at[1] + k] four times and so on, for k below 8
 *   rti_u16_count(p, n, bits) as rti_u16_put, of n, n + 1 to n + 15
 *   rti_u16_deal(p, a, bytes, i, n)
 *                             of a[0] to a[n - 1], at most 16, those whose byte has bit i, as rti_u16_put; rti_b16_load(p) loads
 *                             sixteen bytes
 *   rti_u16_last(p, a, n)     a[0] to a[n - 1], 1 to N of them, to p[0] on, and the last again up to p[N - 1]; reads as rti_u16_put
 * where N is 8:
 *   rti_f8_corner(p, rows)    p[rows[i]] in lane i; p[3] is read
 *   rti_f8_take(p, lanes)     p[lanes[i]] in lane i, numbers below 8
 * and where RTI_PACK is (AVX-512; N is 16):
 *   rti_f16_put(p, bits, a)   the chosen lanes of a side by side from p on, and nothing behind them
 *   rti_u8_pairs(p, bits, a, b)
 *                             the chosen lanes of a[8] and of b[8], in pairs, side by side from p on; all sixteen places are written
 *   rti_first(bits, n)        the lowest n of the bits, n less than 32
 *   rti_f16_mix(a, bits, b, lanes)
 *                             b's lanes lanes[i] modulo 16 where bits chooses lane i, else a's; rti_i16_load(p) loads such lanes
 *   rti_i16_same(a, n, b)     the lanes of a that are b n and less than b n + n, as bits
 *   rti_f16_low(a)            the least lane of a, none of which is NaN
 *   rti_f16_lows(a)           of each of a[0] to a[15] the least lane; rti_f16_lows8(a), an rti_f8, of a[0] to a[7]
 *   rti_f16_twelve(p)         p[0] to p[11]; rti_f16_nine(p) p[0] to p[8]
 *   rti_f16_fourths(p)        p[4 i] in lane i
 *   rti_f16_corners(v0, v1, v2, z, p)
 *                             to p[0] on v0[4 k], v0[4 l], v0[4 z], and so of v1 and v2; k, l, z: 1 2 0, 2 0 1 or 0 1 2; all sixteen
 *                             places are written, up to v[8] are read
 *   rti_f16_take(a, lanes)    those lanes of a, for
 *   rti_i16_row(a)            of each number in a, 0, 1 or 2, that row of three rows of four lanes, for
 *   rti_i16_rows, _next       as above: the rows' first lanes
 *   rti_f16_least4(a)         of each four lanes the least, four times
 *   rti_f16_keep4(p, end, at, end_at, bits, t, u, v, e, place)
 *                             of each four lanes i to i + 3 the one that is in bits, if there is one, k: t, u, v and place + k - i go to
 *                             p[at[i / 4]] and behind it, e to end[end_at[i / 4]]
 *   rti_u16_put32(p, a, bits) as rti_u16_put, of a[0] to a[31]
 *   rti_u16_some(p, q, a, b, n)
 *                             of a[0] to a[n - 1], at most 32, those side by side beside which b[] is not 0, and to q those of b[].
 *                             Reads and writes as that; returns how many
 */
#ifndef RTI_SIMD_H
#define RTI_SIMD_H

#include <string.h>

#include "isa.h"

#ifdef LIBRT_SANITIZED /* as RTK_INLINE */
#define RTI_VEC __attribute__((unused)) static inline
#else
#define RTI_VEC __attribute__((always_inline, unused)) static inline
#endif

/* Of hot files, too: a function that is called, where its registers are better its own. */
#define RTI_APART __attribute__((noinline, unused)) static

#if (defined(__AVX512F__) && defined(__AVX512VL__) && defined(__AVX512DQ__)) || defined(LIBRT_EMULATED)
#include "simd/avx512.h"
#elif defined(__AVX2__) && defined(__FMA__)
#include "simd/avx2.h"
#elif defined(__SSE4_2__) || (defined(__SSE2__) && !defined(RTI_ISA))
#include "simd/sse.h"
#elif defined(__ARM_NEON) && defined(__aarch64__)
#include "simd/neon.h"
#else
#include "simd/generic.h"
#endif

#ifdef __clang__
#define RTI_MIX(a, b, i, j, k, l)  __builtin_shufflevector(a, b, i, j, k, l)
#define RTI_MIX8(a, b, i, j, k, l) __builtin_shufflevector(a, b, i, j, k, l)
#else
typedef int32_t rti_mix __attribute__((vector_size(16)));
typedef int64_t rti_mix8 __attribute__((vector_size(32)));
#define RTI_MIX(a, b, i, j, k, l)  __builtin_shuffle(a, b, (rti_mix){i, j, k, l})
#define RTI_MIX8(a, b, i, j, k, l) __builtin_shuffle(a, b, (rti_mix8){i, j, k, l})
#endif
RTI_VEC rti_f4 rti_f4_words(const void *p, const void *q, const void *r, const void *s)
{
    float a, b, c, d;
    memcpy(&a, p, sizeof a);
    memcpy(&b, q, sizeof b);
    memcpy(&c, r, sizeof c);
    memcpy(&d, s, sizeof d);
    return (rti_f4){a, b, c, d};
}
typedef uint64_t rti_sum __attribute__((vector_size(32), aligned(8), may_alias));
RTI_VEC void rti_sum_add(uint64_t *p, const rti_sum *a)
{
    *(rti_sum *)p += *a;
}
RTI_VEC void rti_sums(const uint64_t *a, const uint64_t *b, const uint64_t *c, rti_sum to[16])
{
    const rti_sum none = {0, 0, 0, 0};
    for (uint32_t i = 0; i < 16; i += 4) {
        const rti_sum r = *(const rti_sum *)(a + i), g = *(const rti_sum *)(b + i), d = *(const rti_sum *)(c + i);
        const rti_sum even = RTI_MIX8(r, g, 0, 4, 2, 6), odd = RTI_MIX8(r, g, 1, 5, 3, 7);
        const rti_sum even_d = RTI_MIX8(d, none, 0, 4, 2, 6), odd_d = RTI_MIX8(d, none, 1, 5, 3, 7);
        to[i] = RTI_MIX8(even, even_d, 0, 1, 4, 5);
        to[i + 1] = RTI_MIX8(odd, odd_d, 0, 1, 4, 5);
        to[i + 2] = RTI_MIX8(even, even_d, 2, 3, 6, 7);
        to[i + 3] = RTI_MIX8(odd, odd_d, 2, 3, 6, 7);
    }
}
RTI_VEC void rti_f4_turn(const rti_f4 a[4], rti_f4 b[4])
{
    const rti_f4 x = RTI_MIX(a[0], a[1], 0, 4, 1, 5), y = RTI_MIX(a[2], a[3], 0, 4, 1, 5);
    const rti_f4 z = RTI_MIX(a[0], a[1], 2, 6, 3, 7), w = RTI_MIX(a[2], a[3], 2, 6, 3, 7);
    b[0] = RTI_MIX(x, y, 0, 1, 4, 5);
    b[1] = RTI_MIX(x, y, 2, 3, 6, 7);
    b[2] = RTI_MIX(z, w, 0, 1, 4, 5);
    b[3] = RTI_MIX(z, w, 2, 3, 6, 7);
}

#if RTI_SIMD == 4
RTI_VEC uint32_t rti_u32_unlike(const uint32_t p[16], uint32_t word)
{
    typedef uint32_t words __attribute__((vector_size(16), aligned(4), may_alias));
    const words all = {word, word, word, word};
    uint32_t bits = 0;
    for (uint32_t i = 0; i < 16; i += 4)
        bits |= rti_m4_bits((rti_m4)(*(const words *)(const void *)(p + i) != all)) << i;
    return bits;
}
RTI_VEC rti_f4 rti_f4_take(const float *p, const int32_t lanes[4])
{
    const float a[4] = {p[lanes[0]], p[lanes[1]], p[lanes[2]], p[lanes[3]]};
    return rti_f4_load(a);
}
RTI_VEC void rti_rows4(const float *const from[16], float (*to)[16])
{
    for (uint32_t i = 0; i < 16; i += 4) {
        const rti_f4 a[4] = {rti_f4_load(from[i]), rti_f4_load(from[i + 1]), rti_f4_load(from[i + 2]), rti_f4_load(from[i + 3])};
        rti_f4 b[4];
        rti_f4_turn(a, b);
        for (uint32_t k = 0; k < 4; k++)
            rti_f4_store(to[k] + i, b[k]);
    }
}
RTI_VEC void rti_nines(const float *p, float *const to[9])
{
    for (uint32_t i = 0; i < 16; i += 4, p += 36) {
        for (uint32_t k = 0; k < 8; k += 4) {
            const rti_f4 a[4] = {rti_f4_load(p + k), rti_f4_load(p + 9 + k), rti_f4_load(p + 18 + k), rti_f4_load(p + 27 + k)};
            rti_f4 b[4];
            rti_f4_turn(a, b);
            for (uint32_t j = 0; j < 4; j++)
                rti_f4_store(to[k + j] + i, b[j]);
        }
        for (uint32_t j = 0; j < 4; j++)
            memcpy(to[8] + i + j, p + 9 * j + 8, sizeof *p); /* bits: what is no number stays what it is */
    }
}
RTI_VEC void rti_sixes(const float *const from[6], float *p)
{
    for (uint32_t i = 0; i < 16; i += 4, p += 24) {
        const rti_f4 a[4] = {rti_f4_load(from[0] + i), rti_f4_load(from[1] + i), rti_f4_load(from[2] + i), rti_f4_load(from[3] + i)};
        const rti_f4 e = rti_f4_load(from[4] + i), f = rti_f4_load(from[5] + i);
        const rti_f4 pairs[2] = {RTI_MIX(e, f, 0, 4, 1, 5), RTI_MIX(e, f, 2, 6, 3, 7)};
        rti_f4 b[4];
        rti_f4_turn(a, b);
        for (uint32_t j = 0; j < 4; j++) {
            rti_f4_store(p + 6 * j, b[j]);
            memcpy(p + 6 * j + 4, (const float *)&pairs[j / 2] + j % 2 * 2, 2 * sizeof *p);
        }
    }
}
#endif
#undef RTI_MIX
#undef RTI_MIX8

#ifndef RTI_MSUB
#define rti_f4_msub(a, b, c) ((a) * (b) - (c))
#define rti_f8_msub(a, b, c) ((a) * (b) - (c))
#define rti_f16_msub(a, b, c) ((a) * (b) - (c))
#define rti_f4_madd(a, b, c)  ((a) * (b) + (c))
#define rti_f8_madd(a, b, c)  ((a) * (b) + (c))
#define rti_f16_madd(a, b, c) ((a) * (b) + (c))
#endif

#endif
