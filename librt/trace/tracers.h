/* The functions behind trace.def's rows, in the copies of one instruction set: hot files alone include this. */
#ifndef RTI_TRACERS_H
#define RTI_TRACERS_H

#include "../base/isa.h"
#include "trace.h"

#define RTI_TRACER(name, tree, width, help)                                                                                      \
    void RTI_ISA_FN(rti_trace_##name##_intersect)(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits,      \
                                                  uint32_t count, uint32_t flags, rti_scratch *scratch);                         \
    void RTI_ISA_FN(rti_trace_##name##_occluded)(const rtk_scene *scene, const rtk_trace_block *rays, uint16_t *occluded,        \
                                                 uint32_t count, uint32_t flags, rti_scratch *scratch);                         \
    int RTI_ISA_FN(rti_trace_##name##_one)(const rtk_scene *scene, const rti_ray *ray, float time, rti_hit *hit);
#include "trace.def"
#undef RTI_TRACER

extern const rti_tracer RTI_ISA_FN(rti_tracers)[];

/* Names of what is compiled once a mode (modes.inl): RTI_TRACER_NAME's x for the mode RTK_MODE. */
#define JOIN_(a, b, c) a##_##b##_##c
#define JOIN(a, b, c)  JOIN_(a, b, c)
#define RTK_NAME(x)    JOIN(RTI_TRACER_NAME, x, RTK_MODE)

#endif
