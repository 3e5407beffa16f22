/* A tracer that takes one ray at a time: the six instances of kernel/scene_trace.inl and the loops over blocks around them.
 *
 * Template. The including file defines RTI_TRACER_NAME and what scene_trace.inl asks for: RTK_WALK_INL, RTK_TREE, RTK_TOP_TREE.
 */
#include "../kernel/query.h"
#include "tracers.h"

#define JOIN_(a, b, c) a##_##b##_##c
#define JOIN(a, b, c)  JOIN_(a, b, c)
#define RTK_NAME(x)    JOIN(RTI_TRACER_NAME, x, RTK_MODE)

#define RTK_MODE 0
#include "single_mode.inl"
#undef RTK_MODE
#define RTK_MODE 1 /* any */
#include "single_mode.inl"
#undef RTK_MODE
#define RTK_MODE 2 /* after */
#include "single_mode.inl"
#undef RTK_MODE
#define RTK_MODE 4 /* steps */
#include "single_mode.inl"
#undef RTK_MODE
#define RTK_MODE 5 /* any, steps */
#include "single_mode.inl"
#undef RTK_MODE
#define RTK_MODE 6 /* after, steps */
#include "single_mode.inl"
#undef RTK_MODE

void JOIN(rti_trace, RTI_TRACER_NAME, intersect)(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits,
                                                 uint32_t count, uint32_t flags, rti_scratch *scratch)
{
    if (flags & RTI_TRACE_AFTER) {
        if (flags & RTI_TRACE_STEPS)
            JOIN(RTI_TRACER_NAME, closest, 6)(scene, rays, hits, count, scratch);
        else
            JOIN(RTI_TRACER_NAME, closest, 2)(scene, rays, hits, count, scratch);
    } else {
        if (flags & RTI_TRACE_STEPS)
            JOIN(RTI_TRACER_NAME, closest, 4)(scene, rays, hits, count, scratch);
        else
            JOIN(RTI_TRACER_NAME, closest, 0)(scene, rays, hits, count, scratch);
    }
}

void JOIN(rti_trace, RTI_TRACER_NAME, occluded)(const rtk_scene *scene, const rtk_trace_block *rays, uint16_t *occluded,
                                                uint32_t count, uint32_t flags, rti_scratch *scratch)
{
    if (flags & RTI_TRACE_STEPS)
        JOIN(RTI_TRACER_NAME, any, 5)(scene, rays, occluded, count, scratch);
    else
        JOIN(RTI_TRACER_NAME, any, 1)(scene, rays, occluded, count, scratch);
}
