/* Rows between blocks and sheaves, for lanes_*.c: of rays that lie here and there, and of chosen lanes that go side by side. Rows
 * are words, whatever their type. With AVX-512 they move whole, elsewhere by fours; chosen lanes with AVX2 by eights. */
#ifndef RTI_LANES_ROWS_H
#define RTI_LANES_ROWS_H

#include <stddef.h>

#include "../base/simd.h"
#include "lanes.h"

#define RTI_ROW_SIZE (RTK_BLOCK * sizeof(uint32_t))

/* Which blocks of the batch a sheaf's rays are in, for rti_take_rows. */
static inline void rti_find_blocks(rti_sheaf *c)
{
    c->block_count = 0;
#ifdef RTI_PACK
    for (uint32_t left = (1u << RTK_BLOCK) - 1; left != 0;) {
        const uint32_t block = c->ray[__builtin_ctz(left)] / RTK_BLOCK,
                       lanes = rti_i16_same(rti_i16_load(c->ray), RTK_BLOCK, block);
        c->block[c->block_count] = block;
        c->lanes[c->block_count++] = lanes;
        left &= ~lanes;
    }
#endif
}

/* As many rows as `rows`, one behind the other, of a sheaf's rays. from: those of the batch's block 0; size: bytes from there to
 * those of block 1. */
static inline void rti_take_rows(const rti_sheaf *c, const void *from, size_t size, uint32_t rows, void *to)
{
#ifdef RTI_PACK
    for (uint32_t r = 0; r < rows; r++) {
        const char *row = (const char *)from + r * RTI_ROW_SIZE;
        rti_f16 words = rti_f16_set(0.0f);
        for (uint32_t i = 0; i < c->block_count; i++)
            words = rti_f16_mix(words, c->lanes[i], rti_f16_load((const float *)(const void *)(row + c->block[i] * size)),
                                rti_i16_load(c->ray));
        rti_f16_store((float *)(void *)((char *)to + r * RTI_ROW_SIZE), words);
    }
#else
    for (uint32_t k = 0; k < RTK_BLOCK; k += 4) {
        const char *p[4];
        for (uint32_t i = 0; i < 4; i++)
            p[i] = (const char *)from + c->ray[k + i] / RTK_BLOCK * size + c->ray[k + i] % RTK_BLOCK * sizeof(uint32_t);
        for (uint32_t at = 0; at < rows * RTI_ROW_SIZE; at += RTI_ROW_SIZE)
            rti_f4_store((float *)(void *)((char *)to + at) + k, rti_f4_words(p[0] + at, p[1] + at, p[2] + at, p[3] + at));
    }
#endif
}

/* Of a row of 0 and 1 the first n as bits. */
static inline uint32_t rti_lanes_of(const uint32_t *some, uint32_t n)
{
    return rti_u32_unlike(some, 0) & ((1u << n) - 1);
}

/* The numbers of chosen lanes, the first of which is `first`, side by side. */
static inline void rti_put_numbers(uint32_t *to, uint32_t first, uint32_t lanes)
{
    if (lanes == (1u << RTK_BLOCK) - 1) {
        RTI_EACH_LANE_INNER(k)
        to[k] = first + k;
        return;
    }
#ifdef RTI_PACK
    uint32_t numbers[RTK_BLOCK] RTI_ROW;
    RTI_EACH_LANE_INNER(k)
    numbers[k] = first + k;
    rti_f16_put((float *)(void *)to, lanes, rti_f16_load((const float *)(const void *)numbers));
#else
    for (; lanes != 0; lanes &= lanes - 1)
        *to++ = first + (uint32_t)__builtin_ctz(lanes);
#endif
}

/* A row of points that may be lit, behind those that are noted. */
static inline float *rti_lit_row(const rti_worker *w, uint32_t row)
{
    return w->lit + (size_t)row * w->lit_stride + w->lit_count;
}

/* Where a sheaf's points are, behind those that are noted: their rows up to the geometric normal, or where some point has another
 * for shading up to that, their rays and homes. */
static inline void rti_note_points(rti_worker *w, const rti_sheaf *c)
{
    const float *const rows[] = {c->px, c->py, c->pz, c->error, c->gx, c->gy, c->gz, c->nx, c->ny, c->nz};
    if (c->smooth && !w->lit_smooth) {
        w->lit_smooth = true; /* those before have the geometric one for both */
        for (size_t r = 0; r < 3; r++)
            memcpy(w->lit + (RTI_LIT_NX + r) * w->lit_stride, w->lit + (RTI_LIT_GX + r) * w->lit_stride,
                   w->lit_count * sizeof *w->lit);
    }
    for (uint32_t r = 0; r <= (w->lit_smooth ? RTI_LIT_NZ : RTI_LIT_GZ); r++)
        memcpy(rti_lit_row(w, r), rows[r], RTK_BLOCK * sizeof *w->lit);
    memcpy(w->lit_ray + w->lit_count, c->ray, sizeof c->ray);
    memcpy(w->lit_home + w->lit_count, c->home, sizeof c->home);
}
_Static_assert(RTI_LIT_PX == 0 && RTI_LIT_ERROR == 3 && RTI_LIT_GX == 4 && RTI_LIT_NX == 7 && RTI_LIT_NZ == 9, "their order");

/* Where chosen lanes of rows go: from place k of a block's rows on, side by side. */
typedef struct rti_places {
    uint32_t count; /* how many they are */
#if defined RTI_PACK
    uint32_t k, lanes;
#elif defined RTI_PACK8
    uint32_t low, high; /* of the first eight lanes those that go to place k and on, and of the others to place `second` and on */
    uint32_t k, second;
#else
    uint32_t lane[RTK_BLOCK]; /* that goes to each place of [first, end); they begin and end with fours */
    uint32_t first, end;
    rti_m4 kept; /* of the first four those before k */
#endif
} rti_places;

/* Of `lanes` the lowest that a block has room for. There is at least one. */
static inline rti_places rti_places_of(uint32_t k, uint32_t *lanes)
{
    rti_places p;
#if defined RTI_PACK
    p.k = k;
    p.lanes = rti_first(*lanes, RTK_BLOCK - k);
    p.count = (uint32_t)__builtin_popcount(p.lanes);
    *lanes &= ~p.lanes;
#elif defined RTI_PACK8
    const uint32_t all = (uint32_t)__builtin_popcount(*lanes), room = RTK_BLOCK - k;
    p.low = *lanes & 255u;
    p.high = *lanes >> 8;
    p.k = k;
    p.second = k + (uint32_t)__builtin_popcount(p.low);
    p.second = p.second < RTK_BLOCK ? p.second : RTK_BLOCK;
    p.count = all < room ? all : room;
    for (uint32_t i = 0; all > room && i < room; i++)
        *lanes &= *lanes - 1;
    if (all <= room)
        *lanes = 0;
#else
    const uint32_t begin = k;
    p.first = k & ~3u;
    p.kept = rti_m4_of((1u << (k & 3u)) - 1);
    for (uint32_t i = p.first; i < k; i++)
        p.lane[i] = 0;
    for (; *lanes != 0 && k < RTK_BLOCK; *lanes &= *lanes - 1)
        p.lane[k++] = (uint32_t)__builtin_ctz(*lanes);
    p.count = k - begin;
    for (p.end = k; p.end & 3u; p.end++)
        p.lane[p.end] = p.lane[k - 1];
#endif
    return p;
}

#if !defined RTI_PACK && !defined RTI_PACK8
/* Four words to places i to i + 3 of a row, but for those that stand before k. */
static inline void rti_put_four(float *to, const rti_places *p, uint32_t i, rti_f4 words)
{
    rti_f4_store(to + i, i == p->first ? rti_f4_select(p->kept, rti_f4_load(to + i), words) : words);
}
#endif

/* The chosen lanes of a row. Other rows are as they were, but by eights not meanwhile: as many words behind this one must be the
 * worker's own. */
static inline void rti_put_row(void *to, const rti_places *p, const void *row)
{
#if defined RTI_PACK
    rti_f16_put((float *)to + p->k, p->lanes, rti_f16_load(row));
#elif defined RTI_PACK8
    float *at = to;
    const rti_f8 behind = rti_f8_load(at + RTK_BLOCK);
    rti_f8_pack(at + p->k, p->low, rti_f8_load(row));
    rti_f8_pack(at + p->second, p->high, rti_f8_load((const float *)row + 8));
    rti_f8_store(at + RTK_BLOCK, behind);
#else
    for (uint32_t i = p->first; i < p->end; i += 4) {
        const uint32_t *from = row, *lane = p->lane + i;
        rti_put_four(to, p, i, rti_f4_words(from + lane[0], from + lane[1], from + lane[2], from + lane[3]));
    }
#endif
}

/* As many times `word`. */
static inline void rti_put_all(void *to, const rti_places *p, uint32_t word)
{
#if defined RTI_PACK
    rti_f16_put((float *)to + p->k, p->lanes, rti_f16_set(rtk_float(word)));
#elif defined RTI_PACK8
    float *at = to;
    const rti_f8 behind = rti_f8_load(at + RTK_BLOCK), words = rti_f8_set(rtk_float(word));
    rti_f8_store(at + p->k, words);
    rti_f8_store(at + p->second, words);
    rti_f8_store(at + RTK_BLOCK, behind);
#else
    for (uint32_t i = p->first; i < p->end; i += 4)
        rti_put_four(to, p, i, rti_f4_set(rtk_float(word)));
#endif
}

#endif
