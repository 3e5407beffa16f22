/* The kd-tree, its leaves by eights (accel/kd_wide.c): these nodes are walked by the BVH's tracer, in a view of the scene that
 * has them where that looks for its own (rti_trace_by_kdtree). What a ray costs is counted on the tree of two children itself. */
#include "../kernel/kd.h"
#include "lane.h"
#include "tracers.h"

#define RTK_WALK_INL    "../kernel/kd_stack.inl"
#define RTK_TREE        kdtree
#define RTK_TOP_TREE    top_kdtree
#define RTI_MODE_INL    "single.inl"
#define RTI_TRACER_NAME kdtree
#include "counted.inl"

void RTI_ISA_FN(rti_trace_kdtree_intersect)(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits,
                                            uint32_t count, uint32_t flags, rti_scratch *scratch)
{
    if (!(flags & RTI_TRACE_STEPS)) {
        RTI_ISA_FN(rti_trace_bvh_intersect)(scene->by_kdtree, rays, hits, count, flags, scratch);
        return;
    }
    scratch->stats.rays += count;
    if (flags & RTI_TRACE_AFTER)
        kdtree_rays_6(scene, rays, hits, NULL, count, scratch);
    else
        kdtree_rays_4(scene, rays, hits, NULL, count, scratch);
}

void RTI_ISA_FN(rti_trace_kdtree_occluded)(const rtk_scene *scene, const rtk_trace_block *rays, uint16_t *occluded,
                                           uint32_t count, uint32_t flags, rti_scratch *scratch)
{
    if (!(flags & RTI_TRACE_STEPS)) {
        RTI_ISA_FN(rti_trace_bvh_occluded)(scene->by_kdtree, rays, occluded, count, flags, scratch);
        return;
    }
    scratch->stats.rays += count;
    kdtree_rays_5(scene, rays, NULL, occluded, count, scratch);
}

int RTI_ISA_FN(rti_trace_kdtree_one)(const rtk_scene *scene, const rti_ray *ray, float time, rti_hit *hit)
{
    return RTI_ISA_FN(rti_trace_bvh_one)(scene->by_kdtree, ray, time, hit);
}
