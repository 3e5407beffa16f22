/* The vectors of one instruction set (base/simd.h), in a form that a test can call. */
#ifndef SIMD_PROBE_H
#define SIMD_PROBE_H

#include "base/isa.h"

/* What the functions of packed lanes give; places that they do not write hold what they held. */
typedef struct simd_packed {
    uint32_t least;                 /* rti_f8_least of a with every other sign turned, */
    float sorted[8], pack8[8];      /* rti_f8_sorted of that; rti_f8_pack */
    uint32_t lane[8], packed_u8[8]; /* of rti_f8_sorted; rti_u8_pack */
    float put[16];                  /* rti_f16_put, of bits */
    float low;                      /* rti_f16_low */
    float row[16], each[16];        /* rti_fN_row; rti_fN_each */
    float fields[8][16];            /* rti_f16_fields of a[at] on; rti_f8_fields of the first two */
    float twelve[16], nine[16];     /* rti_f16_twelve, rti_f16_nine */
    float corners[3]
                 [8]; /* rti_f8_corner of a and rti_i8_rows of 0, 1, 2, 0 ... from the last on, and of the rti_i8_next, twice */
    float firsts[2][16];       /* rti_f16_take of rti_i16_rows of 0, 1, 2, 0 ... from the last on, and of the rti_i16_next */
    float rows[3][16];         /* rti_f16_take of rti_i16_row of `at` modulo 3, and of the rti_i16_next of that, twice */
    float least4[16];          /* rti_f16_least4 */
    float kept[4][4], ends[4]; /* rti_f16_keep4 of what bits leave of one a four, a three times, -a */
    uint32_t taken[8];         /* rti_u8_take of numbers, lanes at[0] to at[3] modulo 8, twice */
    uint16_t dealt[16];        /* rti_u16_deal of the numbers 0 to 15 by bytes of a's bits, by bit `from` modulo 8 */
    uint32_t dealt_count;
    float records[8][16], spread[16][8];    /* rti_fN_records of N records of eight numbers, 0 to 8 N - 1, the last first;
                                               rti_fN_spread of that, the last first */
    float twos[16][2];                      /* rti_fN_twos of a and -a, the last first */
    uint32_t keys[16], places[16], next[8]; /* rti_iN_places of those by bits, and what is next to `numbers` */
    uint32_t ranks[16];                     /* rti_iN_ranks of those by bits */
    float unless[16];                       /* rti_fN_unless of those by bits */
    float fourths[16];                      /* rti_f16_fourths of 0 to 63 */
    uint32_t pairs[16];                     /* rti_u8_pairs of numbers and of 1 to 8 */
    float three[3][16];                     /* rti_f16_corners of a, a + 1, a + 2, each z */
    uint16_t chosen[16];                 /* rti_u16_put of the numbers 0 to 15 by bits */
    uint32_t chosen_count;
    float lows[16];       /* rti_f16_lows of a turned by 0 to 15 lanes, lane i of the k-th plus i k: no two alike */
    float lows8[8];       /* rti_f16_lows8 of the first eight of those */
    uint16_t last[16];    /* rti_u16_last of one more than bits modulo N of the numbers 0 to 15 */
    uint16_t counted[16]; /* rti_u16_count from `from` on by bits */
    uint32_t counted_count;
    uint32_t wide;         /* bits, and others of them above */
    uint16_t chosen32[32]; /* rti_u16_put32 of the numbers 0 to 31 by wide */
    uint32_t chosen32_count;
    uint16_t some[32],
        some_bits[32]; /* rti_u16_some of 100 to 131, where beside the i-th is 7 i if wide has bit i, else 0; 3 from */
    uint32_t some_count;
    float column[16];         /* rti_fN_column of those records, the last first */
    float fours[16][4];       /* rti_fN_fours of a, -a, 2 a and of 3 a, the last first */
    float mixed[16];          /* rti_f16_mix of -a and of a's lanes 16 from + 5 i + at[0] by bits */
    uint32_t same, first;     /* rti_i16_same of those lanes, 16 and from + 2; rti_first of bits, `from` of them */
    float madd[16], msub[16]; /* rti_fN_madd and _msub of a, 2 and a turned by one lane */
    float lows_of[8], highs_of[8],
        both[8];                       /* rti_f8_lows and _highs of a and -a; rti_f8_both of the high and the low half of a */
    float turned8[4][8];               /* rti_f8_turn of a, -a, 2 a, 3 a */
    float queued[8];                   /* rti_f8_queue of a with every other sign turned, */
    uint32_t queued_u[8], queued_v[8]; /* of numbers and of lanes */
    uint32_t queued_last;              /* what it returns */
    float take[8];                     /* rti_f8_take of a, lanes at[0] to at[3] modulo 8, twice */
} simd_packed;

#define SIMD_ROWS 3 /* of a block, for take_rows and put_rows */

/* min, max: of a and b, lane by lane, in the widest vectors; lt, le, eq: likewise, a bit a lane. Returns how many lanes. packed:
 * of a, bits (of eight lanes the lower eight), numbers, at and from. Returns 16, or 8 where the level has those of eight lanes
 * alone (RTI_PACK8): what is of lists and in vectors of N lanes; or 0.
 * take_rows: of rays ray[16] their words in rows of blocks, as a sheaf takes them (lanes_rows.h). put_rows: those of a row that
 * `lanes` chooses go behind the `count` that stand in the first rows of some blocks, and `word` as often in the second; returns how
 * many then do. */
#define PROBE(name, level)                                                                                                       \
    uint32_t simd_compare_##name(const float a[16], const float b[16], float min[16], float max[16], uint32_t bits[3]);          \
    void simd_rows4_##name(const float *const from[16], float to[4][16]);                                                        \
    void simd_nines_##name(const float *p, float *const to[9]);                                                                  \
    void simd_sixes_##name(const float *const from[6], float *p);                                                                \
    uint32_t simd_unlike_##name(const uint32_t p[16], uint32_t word);                                                            \
    void simd_take4_##name(const float p[4], const int32_t lanes[4], float to[4]);                                               \
    void simd_take_rows_##name(const uint32_t ray[16], const uint32_t *blocks, uint32_t *to);                                    \
    uint32_t simd_put_rows_##name(uint32_t lanes, uint32_t count, const uint32_t row[16], uint32_t word, uint32_t *blocks);      \
    int simd_packed_##name(const float a[16], uint32_t bits, const uint32_t numbers[8], const uint32_t at[4], uint32_t from,     \
                           simd_packed *out);
RTI_ISA_EACH(PROBE)
#undef PROBE

#endif
