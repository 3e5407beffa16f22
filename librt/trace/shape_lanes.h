/* Boxes, cylinders and cones in vectors, for hot files: rti_box_test4 and rti_cone_test4, and those of 8 and 16 where the
 * processor has them (shape_lanes.inl). */
#ifndef RTI_SHAPE_LANES_H
#define RTI_SHAPE_LANES_H

#include "ball_lanes.h"

#define RTI_N 4
#include "shape_lanes.inl"
#undef RTI_N
#if RTI_SIMD >= 8
#define RTI_N 8
#include "shape_lanes.inl"
#undef RTI_N
#endif
#if RTI_SIMD >= 16
#define RTI_N 16
#include "shape_lanes.inl"
#undef RTI_N
#endif

#endif
