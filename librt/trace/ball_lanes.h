/* Spheres in vectors, for hot files: rti_ball4, and rti_ball8, rti_ball16 where the processor has them (ball_lanes.inl). */
#ifndef RTI_BALL_LANES_H
#define RTI_BALL_LANES_H

#include "../kernel/shapes.h"
#include "tri_lanes.h"

#define RTI_N 4
#include "ball_lanes.inl"
#undef RTI_N
#if RTI_SIMD >= 8
#define RTI_N 8
#include "ball_lanes.inl"
#undef RTI_N
#endif
#if RTI_SIMD >= 16
#define RTI_N 16
#include "ball_lanes.inl"
#undef RTI_N
#endif

#endif
