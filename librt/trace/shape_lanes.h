/* Shapes in vectors, for hot files: spheres (rti_ball4, ball_lanes.inl), boxes, cylinders and cones (rti_box_test4, rti_cone_test4,
 * shape_lanes.inl), and those of 8 and 16 where the processor has them. */
#ifndef RTI_SHAPE_LANES_H
#define RTI_SHAPE_LANES_H

#include "../kernel/shapes.h"
#include "tri_lanes.h"

#define RTI_LANES_INL "ball_lanes.inl"
#include "lanes_each.inl"
#define RTI_LANES_INL "shape_lanes.inl"
#include "lanes_each.inl"

#endif
