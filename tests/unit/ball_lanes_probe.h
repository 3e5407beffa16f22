/* Pairs of a ray and a sphere, asked by the vectors of one instruction set. */
#ifndef BALL_LANES_PROBE_H
#define BALL_LANES_PROBE_H

#include "base/isa.h"
#include "kernel/shapes.h"

/* As many pairs as the widest of 4, 8, 16 up to at_most, which is returned; of each where it is hit first, or NaN. */
#define PROBE(name, level) uint32_t probe_balls_##name(uint32_t at_most, const rtk_pray *rays, const rtk_shape *balls, float *t);
RTI_ISA_EACH(PROBE)
#undef PROBE

#endif
