/* Pairs of random numbers at a path vertex. */
#ifndef RTK_RANDOM2_H
#define RTK_RANDOM2_H

#include "rng.h"

typedef struct rtk_uv {
    float x, y; /* [0, 1) */
} rtk_uv;

/* Dimension dim (an even place, the _U or _X of its pair) and the one after it, at a place of its group (rtk_shuffled). */
RTK_FN rtk_uv rtk_random2_at(rtk_u32 vertex_seed, rtk_u32 shuffled, rtk_u32 dim)
{
    rtk_uv u;
    u.x = rtk_unit_float(rtk_scrambled(vertex_seed, shuffled, dim));
    u.y = rtk_unit_float(rtk_scrambled(vertex_seed, shuffled, dim + 1u));
    return u;
}

/* The index-th pair. */
RTK_FN rtk_uv rtk_random2(rtk_u32 vertex_seed, rtk_u32 index, rtk_u32 dim)
{
    return rtk_random2_at(vertex_seed, rtk_shuffled(vertex_seed, index, dim), dim);
}

#endif
