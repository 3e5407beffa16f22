/* Light from lanes onto the film. */
#ifndef RTI_LANES_FILM_H
#define RTI_LANES_FILM_H

#include "../base/simd.h"
#include "lanes.h"

/* The nearest integer, ties to even, of |x| < 2^51: what is added leaves a double no place for a fraction. */
static inline uint64_t rti_lane_fixed(float x)
{
    double d = (double)x + 6755399441055744.0; /* 1.5 * 2^52 */
    uint64_t bits;
    memcpy(&bits, &d, sizeof bits);
    return bits - 0x4338000000000000u;
}

/* To each lane of mask's pixel its sums. A load of all four would wait for a store of one. */
static inline void rti_add_sums(const rti_worker *w, const uint32_t *home, uint32_t mask, const rti_sum *add)
{
    if (mask == (1u << RTK_BLOCK) - 1) {
        for (uint32_t k = 0; k < RTK_BLOCK; k++)
            rti_sum_add(w->film + (size_t)home[k] * RTK_FILM_CHANNELS, &add[k]);
        return;
    }
    for (; mask != 0; mask &= mask - 1) {
        const uint32_t k = (uint32_t)__builtin_ctz(mask);
        rti_sum_add(w->film + (size_t)home[k] * RTK_FILM_CHANNELS, &add[k]);
    }
}

/* rti_cover of the first n lanes. */
static inline void rti_cover_lanes(const rti_worker *w, const uint32_t *home, uint32_t n)
{
    const rti_sum one = {0, 0, 0, 1};
    for (uint32_t k = 0; k < n; k++)
        rti_sum_add(w->film + (size_t)home[k] * RTK_FILM_CHANNELS, &one);
}

/* rti_add of the lanes in mask. */
static inline void rti_add_lanes(rti_worker *w, const uint32_t *home, uint32_t mask, const rti_light_lanes *l)
{
    const float scale = w->frame->film_scale;
    uint64_t r[RTK_BLOCK] RTI_ROW, g[RTK_BLOCK] RTI_ROW, b[RTK_BLOCK] RTI_ROW;
    rti_sum add[RTK_BLOCK] RTI_ROW; /* RTK_FILM_CHANNELS of each lane */
    uint32_t fits[RTK_BLOCK] RTI_ROW;
    RTI_EACH_LANE(k)
    fits[k] = rtk_fabs(l->r[k]) + rtk_fabs(l->g[k]) + rtk_fabs(l->b[k]) <= RTK_FILM_LIMIT;
    if (rti_u32_unlike(fits, 1) != 0) {
        for (uint32_t k = 0; k < RTK_BLOCK; k++)
            if (mask >> k & 1u)
                rti_add(w, home[k], rtk_v3(l->r[k], l->g[k], l->b[k]));
        return;
    }
    RTI_EACH_LANE(k)
    {
        r[k] = rti_lane_fixed(l->r[k] * scale);
        g[k] = rti_lane_fixed(l->g[k] * scale);
        b[k] = rti_lane_fixed(l->b[k] * scale);
    }
    rti_sums(r, g, b, add);
    rti_add_sums(w, home, mask, add);
}

#endif
