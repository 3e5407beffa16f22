/* Triangles side by side, for hot files: eight where vectors hold them, else four. Private to accel/. */
#ifndef RTI_CORNERS_H
#define RTI_CORNERS_H

#include "build.h"
#include "vectors.h"

#if RTI_SIMD >= 8
#define LANES 8u
typedef rti_f8 lanes;
typedef rti_m8 yes;
#define V(name) rti_f8_##name
#define M(name) rti_m8_##name
#else
#define LANES   4u
typedef rti_f4 lanes;
typedef rti_m4 yes;
#define V(name) rti_f4_##name
#define M(name) rti_m4_##name
#endif

/* The first floats of records of four, by place; a triangle's corner is one, with what follows it. */
RTI_VEC void corners(const float *const from[LANES], lanes out[4])
{
    lanes four[4];
    for (uint32_t i = 0; i < 4; i++)
#if RTI_SIMD >= 8
        four[i] = rti_f8_two(from[i], from[4 + i]);
#else
        four[i] = rti_f4_load(from[i]);
#endif
    V(turn)(four, out);
}

/* All three of each. */
RTI_VEC void corners_of(const rtk_tri *const tris[LANES], lanes v[3][3])
{
    for (uint32_t k = 0; k < 3; k++) {
        const float *from[LANES];
        lanes by[4];
        for (uint32_t i = 0; i < LANES; i++)
            from[i] = k == 0 ? tris[i]->v0 : (k == 1 ? tris[i]->v1 : tris[i]->v2);
        corners(from, by);
        for (uint32_t a = 0; a < 3; a++)
            v[k][a] = by[a];
    }
}

#endif
