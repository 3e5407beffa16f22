/* The table of integrators. */
#include <string.h>

#include "direct.h"

static const rti_integrator table[] = {
#define RTI_INTEGRATOR(name, help, flags, branching, light) {#name, help, flags, branching, rti_shade_##name, light},
#include "integrate.def"
#undef RTI_INTEGRATOR
};

const rti_integrator *rti_integrator_find(const char *name)
{
    for (size_t i = 0; i < RTI_COUNT(table); i++) {
        if (strcmp(table[i].name, name) == 0)
            return &table[i];
    }
    return NULL;
}

const char *rt_integrator_at(uint32_t index, const char **help)
{
    if (index >= RTI_COUNT(table))
        return NULL;
    if (help)
        *help = table[index].help;
    return table[index].name;
}

const char *rt_tracer_at(uint32_t index, const char **help)
{
    const rti_tracer *t;
    if (index == 0) {
        if (help)
            *help = "the one the scene's queries use";
        return "auto";
    }
    if (index - 1 >= rti_tracer_count())
        return NULL;
    t = rti_tracer_at(RTI_ISA_GENERIC, index - 1);
    if (help)
        *help = t->help;
    return t->name;
}
