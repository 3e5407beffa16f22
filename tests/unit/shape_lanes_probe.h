/* Pairs of a ray and a cylinder or cone, asked by the vectors of one instruction set. */
#ifndef SHAPE_LANES_PROBE_H
#define SHAPE_LANES_PROBE_H

#include "base/isa.h"
#include "kernel/shapes.h"

/* As many pairs as the widest of 4, 8, 16 up to at_most, which is returned; of each where it is hit first, or NaN. Bits of *ask:
 * pairs that are to be asked one by one; of *near: those whose ray may meet the shape's ball. */
#define PROBE(name, level)                                                                                                       \
    uint32_t probe_cones_##name(uint32_t at_most, const rtk_pray *rays, const rtk_shape *cones, float *t, uint32_t *ask,         \
                                uint32_t *near);
RTI_ISA_EACH(PROBE)
#undef PROBE

#endif
