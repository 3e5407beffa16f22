/* The table of tracers, for one instruction set. */
#include "tracers.h"

const rti_tracer RTI_ISA_FN(rti_tracers)[] = {
#define RTI_TRACER(name, tree, width, help)                                                                                      \
    {#name,                                                                                                                      \
     help,                                                                                                                       \
     tree,                                                                                                                       \
     width,                                                                                                                      \
     RTI_ISA_FN(rti_trace_##name##_intersect),                                                                                   \
     RTI_ISA_FN(rti_trace_##name##_occluded),                                                                                    \
     RTI_ISA_FN(rti_trace_##name##_one)},
#include "trace.def"
#undef RTI_TRACER
};
