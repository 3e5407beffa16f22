/* One mode of a tracer that takes one ray at a time. Included by modes.inl. */
#include "../kernel/scene_trace.inl"

#if RTK_MODE > 1 || !defined RTI_PACKET_INL
static void RTK_NAME(rays)(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits, uint16_t *occluded,
                           uint32_t count, rti_scratch *scratch)
{
    for (uint32_t i = 0; i < count; i++) {
        rtk_query q;
        rti_lane_query(&q, scene, rays, i, scratch);
        if (RTK_MODE & RTK_MODE_AFTER)
            rti_lane_after(&q, hits, i);
        int hit = RTK_NAME(trace)(&q);
        if (RTK_MODE & RTK_MODE_ANY)
            rti_lane_occluded(occluded, i, hit);
        else
            rti_lane_hit(&q, hits, i);
        if (RTK_MODE & RTK_MODE_STEPS)
            rti_lane_count(&q, i, scratch);
    }
}
#endif
