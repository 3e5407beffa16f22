/* Rows between blocks and sheaves, for lanes_*.c: of rays that lie here and there, and of chosen lanes that go side by side. Rows
 * are words, whatever their type. With AVX-512 they move whole, elsewhere word by word. */
#ifndef RTI_LANES_ROWS_H
#define RTI_LANES_ROWS_H

#include <stddef.h>

#include "../base/simd.h"
#include "lanes.h"

/* As many rows as `rows`, one behind the other, of a sheaf's rays. from: those of the batch's block 0; size: bytes from there to
 * those of block 1. */
static inline void rti_take_rows(const rti_sheaf *c, const void *from, size_t size, uint32_t rows, void *to)
{
    for (uint32_t r = 0; r < rows; r++) {
        const char *row = (const char *)from + r * RTK_BLOCK * sizeof(uint32_t);
        char *all = (char *)to + r * RTK_BLOCK * sizeof(uint32_t);
#ifdef RTI_PACK
        rti_f16 words = rti_f16_set(0.0f);
        for (uint32_t i = 0; i < c->block_count; i++)
            words = rti_f16_mix(words, c->lanes[i], rti_f16_load((const float *)(const void *)(row + c->block[i] * size)),
                                rti_i16_load(c->ray));
        rti_f16_store((float *)(void *)all, words);
#else
        for (uint32_t k = 0; k < RTK_BLOCK; k++)
            memcpy(all + k * sizeof(uint32_t), row + c->ray[k] / RTK_BLOCK * size + c->ray[k] % RTK_BLOCK * sizeof(uint32_t),
                   sizeof(uint32_t));
#endif
    }
}

/* Of a row of 0 and 1 the first n as bits. */
static inline uint32_t rti_lanes_of(const uint32_t *some, uint32_t n)
{
    uint32_t lanes = 0;
    RTI_EACH_LANE(k)
    lanes |= some[k] << k;
    return lanes & ((1u << n) - 1);
}

/* Where a sheaf's points are, behind those that are noted: their rows up to the geometric normal, their rays and homes. */
static inline void rti_note_points(rti_worker *w, const rti_sheaf *c)
{
    const float *const rows[] = {c->px, c->py, c->pz, c->error, c->nx, c->ny, c->nz, c->gx, c->gy, c->gz};
    for (uint32_t r = 0; r <= RTI_LIT_GZ; r++)
        memcpy(w->lit + r * w->lit_stride + w->lit_count, rows[r], RTK_BLOCK * sizeof *rows[r]);
    memcpy(w->lit_ray + w->lit_count, c->ray, sizeof c->ray);
    memcpy(w->lit_home + w->lit_count, c->home, sizeof c->home);
}
_Static_assert(RTI_LIT_PX == 0 && RTI_LIT_ERROR == 3 && RTI_LIT_NX == 4 && RTI_LIT_GX == 7 && RTI_LIT_GZ == 9, "their order");

#ifdef RTI_PACK
/* Chosen lanes of a row, side by side, from place k of another on. */
static inline void rti_put_row(void *to, uint32_t k, uint32_t lanes, const void *row)
{
    rti_f16_put((float *)to + k, lanes, rti_f16_load(row));
}

/* As many times `word`. */
static inline void rti_put_all(void *to, uint32_t k, uint32_t lanes, uint32_t word)
{
    rti_f16_put((float *)to + k, lanes, rti_f16_set(rtk_float(word)));
}
#endif

#endif
