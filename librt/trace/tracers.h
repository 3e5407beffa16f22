/* The functions behind trace.def's rows. */
#ifndef RTI_TRACERS_H
#define RTI_TRACERS_H

#include "trace.h"

#define RTI_TRACER(name, tree, width, help)                                                                                      \
    void rti_trace_##name##_intersect(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits, uint32_t count,  \
                                      uint32_t flags, rti_scratch *scratch);                                                     \
    void rti_trace_##name##_occluded(const rtk_scene *scene, const rtk_trace_block *rays, uint16_t *occluded, uint32_t count,    \
                                     uint32_t flags, rti_scratch *scratch);
#include "trace.def"
#undef RTI_TRACER

#endif
