/* Pairs of random numbers in lanes: what does not depend on the sample is made once. */
#ifndef RTI_LANES_RANDOM_H
#define RTI_LANES_RANDOM_H

#include "../kernel/rng.h"
#include "lanes.h"

/* Of dimension dim, the first of a pair, and the one after it. */
static inline void rti_seed_pairs(const uint32_t *vertex_seed, uint32_t dim, rti_pair_seeds *s)
{
    RTI_EACH_LANE(k)
    {
        s->order[k] = rtk_order_seed(vertex_seed[k], dim);
        s->first[k] = rtk_number_seed(vertex_seed[k], dim);
        s->second[k] = rtk_number_seed(vertex_seed[k], dim + 1u);
    }
}

/* Pair from[k] + more of each lane: rtk_random2. */
static inline void rti_draw_pairs(const rti_pair_seeds *s, uint32_t dim, const uint32_t *from, uint32_t more, float *x, float *y)
{
    RTI_EACH_LANE(k)
    {
        const uint32_t place = rtk_shuffled_by(s->order[k], from[k] + more);
        x[k] = rtk_unit_float(rtk_scrambled_by(s->first[k], place, dim));
        y[k] = rtk_unit_float(rtk_scrambled_by(s->second[k], place, dim + 1u));
    }
}

#endif
