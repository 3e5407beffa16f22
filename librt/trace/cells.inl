/* The tracer of a tree of cells: its nodes of eight are walked by the BVH's tracer, in a view of the scene that has them where that
 * looks for its own (rti_trace_by). What a ray costs is counted on the tree's own nodes.
 *
 * Template. The including file defines RTI_TRACER_NAME; RTI_BY_TREE, the view; and for what is counted RTK_WALK_INL, RTK_TREE and
 * RTK_TOP_TREE (single.inl).
 */
#include "lane.h"
#include "tracers.h"

#define RTI_MODE_INL "single.inl"
#include "counted.inl"

#define RAYS(mode, hits, occluded) JOIN(RTI_TRACER_NAME, rays, mode)(scene, rays, hits, occluded, count, scratch)

void RTI_ISA_FN(JOIN(rti_trace, RTI_TRACER_NAME, intersect))(const rtk_scene *scene, const rtk_trace_block *rays,
                                                             rtk_hit_block *hits, uint32_t count, uint32_t flags,
                                                             rti_scratch *scratch)
{
    if (!(flags & RTI_TRACE_STEPS)) {
        RTI_ISA_FN(rti_trace_bvh_intersect)(scene->RTI_BY_TREE, rays, hits, count, flags, scratch);
        return;
    }
    scratch->stats.rays += count;
    if (flags & RTI_TRACE_AFTER)
        RAYS(6, hits, NULL);
    else
        RAYS(4, hits, NULL);
}

void RTI_ISA_FN(JOIN(rti_trace, RTI_TRACER_NAME, occluded))(const rtk_scene *scene, const rtk_trace_block *rays,
                                                            uint16_t *occluded, uint32_t count, uint32_t flags,
                                                            rti_scratch *scratch)
{
    if (!(flags & RTI_TRACE_STEPS)) {
        RTI_ISA_FN(rti_trace_bvh_occluded)(scene->RTI_BY_TREE, rays, occluded, count, flags, scratch);
        return;
    }
    scratch->stats.rays += count;
    RAYS(5, NULL, occluded);
}

int RTI_ISA_FN(JOIN(rti_trace, RTI_TRACER_NAME, one))(const rtk_scene *scene, const rti_ray *ray, float time, rti_hit *hit)
{
    return RTI_ISA_FN(rti_trace_bvh_one)(scene->RTI_BY_TREE, ray, time, hit);
}
