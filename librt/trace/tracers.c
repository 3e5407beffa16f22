/* The tables of tracers, one an instruction set. */
#include <string.h>

#include "trace.h"
#include "turn.h"

RTI_ISA_TABLES(rti_turn, rti_turn_at)

#define EXTERN(name, level) extern const rti_tracer rti_tracers_##name[];
RTI_ISA_EACH(EXTERN)
#undef EXTERN

static const char *const rows[] = {
#define RTI_TRACER(name, tree, width, help) #name,
#include "trace.def"
#undef RTI_TRACER
};

static const rti_tracer *table(rti_isa isa)
{
    switch (isa) {
#define TABLE(name, level)                                                                                                       \
    case level:                                                                                                                  \
        return rti_tracers_##name;
        RTI_ISA_EACH(TABLE)
#undef TABLE
    default:
        return rti_tracers_generic;
    }
}

uint32_t rti_tracer_count(void)
{
    return (uint32_t)RTI_COUNT(rows);
}

const rti_tracer *rti_tracer_at(rti_isa isa, uint32_t index)
{
    return index < RTI_COUNT(rows) ? &table(isa)[index] : NULL;
}

const rti_tracer *rti_tracer_find(rti_isa isa, const char *name)
{
    for (size_t i = 0; i < RTI_COUNT(rows); i++)
        if (strcmp(rows[i], name) == 0)
            return &table(isa)[i];
    return NULL;
}

void rti_trace_by(uint32_t kind, const rtk_scene *scene, rtk_scene *to, rtk_group *groups)
{
    const bool kd = kind == RTK_TREE_KD;
    *to = *scene;
    to->groups = groups;
    to->top_bvh = kd ? scene->top_kdtree : scene->top_octree;
    for (uint32_t i = 0; i < scene->group_count; i++) {
        groups[i] = scene->groups[i];
        for (uint32_t k = 0; k < groups[i].part_count; k++)
            groups[i].parts[k].bvh = kd ? groups[i].parts[k].kdtree : groups[i].parts[k].octree;
    }
}
