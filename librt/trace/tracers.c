/* The table of tracers. */
#include <string.h>

#include "tracers.h"

static const rti_tracer tracers[] = {
#define RTI_TRACER(name, tree, width, help) {#name, help, tree, width, rti_trace_##name##_intersect, rti_trace_##name##_occluded},
#include "trace.def"
#undef RTI_TRACER
};

uint32_t rti_tracer_count(void)
{
    return (uint32_t)RTI_COUNT(tracers);
}

const rti_tracer *rti_tracer_at(uint32_t index)
{
    return index < RTI_COUNT(tracers) ? &tracers[index] : NULL;
}

const rti_tracer *rti_tracer_find(const char *name)
{
    for (size_t i = 0; i < RTI_COUNT(tracers); i++)
        if (strcmp(tracers[i].name, name) == 0)
            return &tracers[i];
    return NULL;
}
