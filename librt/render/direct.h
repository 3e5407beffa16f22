/* Light that comes straight from the lights, and points that look for it. */
#ifndef RTI_DIRECT_H
#define RTI_DIRECT_H

#include "wavefront.h"

/* The second halves of a step (rti_integrator.light). All lit points from all lights, each with its number of shadow rays; from
 * one light, chosen by power; from all around. Afterwards none is lit. */
void rti_light_all(rti_worker *worker);
void rti_light_one(rti_worker *worker);
void rti_light_around(rti_worker *worker);

#define RTI_INTEGRATOR(name, help, flags, branching, light)                                                                      \
    void rti_shade_##name(rti_worker *worker, uint32_t first, uint32_t count);
#include "integrate.def"
#undef RTI_INTEGRATOR

#endif
