/* A tracer's functions, from one body compiled once a mode.
 *
 * Template. The including file defines RTI_TRACER_NAME; RTI_MODE_INL, the body: it defines RTK_NAME(rays) for the mode RTK_MODE
 * (single.inl is the one for one ray at a time); and what that asks for. RTI_PACKET_INL, if it is defined, gives for closest and
 * any hit RTK_NAME(packets) of coherent batches, RTK_NAME(lone) of others, and RTK_NAME(one); RTK_NAME(rays) is not asked for them
 * then.
 */
#include "lane.h"
#include "tracers.h"

#define RTK_MODE 0
#include RTI_MODE_INL
#ifdef RTI_PACKET_INL
#include RTI_PACKET_INL
#else
#include "one.inl"
#endif
#undef RTK_MODE
#define RTK_MODE 1 /* any */
#include RTI_MODE_INL
#ifdef RTI_PACKET_INL
#include RTI_PACKET_INL
#else
#include "one.inl"
#endif
#undef RTK_MODE
#define RTK_MODE 2 /* after */
#include RTI_MODE_INL
#undef RTK_MODE
#include "counted.inl"

#define RAYS(mode, hits, occluded) JOIN(RTI_TRACER_NAME, rays, mode)(scene, rays, hits, occluded, count, scratch)
#ifdef RTI_PACKET_INL
#define PACKETS(mode, hits, occluded) JOIN(RTI_TRACER_NAME, packets, mode)(scene, rays, hits, occluded, count, scratch)
#define LONE(mode, hits, occluded)    JOIN(RTI_TRACER_NAME, lone, mode)(scene, rays, hits, occluded, count, scratch)
#define ONE(mode, hit)                JOIN(RTI_TRACER_NAME, one, mode)(scene, ray, time, hit)
#else
#define PACKETS        RAYS
#define LONE           RAYS
#define ONE(mode, hit) JOIN(RTI_TRACER_NAME, one_plain, mode)(scene, ray, time, hit)
#endif

void RTI_ISA_FN(JOIN(rti_trace, RTI_TRACER_NAME, intersect))(const rtk_scene *scene, const rtk_trace_block *rays,
                                                             rtk_hit_block *hits, uint32_t count, uint32_t flags,
                                                             rti_scratch *scratch)
{
    scratch->stats.rays += count;
    switch (flags & (RTI_TRACE_AFTER | RTI_TRACE_STEPS)) {
    case 0:
        if (flags & RTI_TRACE_COHERENT)
            PACKETS(0, hits, NULL);
        else
            LONE(0, hits, NULL);
        break;
    case RTI_TRACE_AFTER:
        RAYS(2, hits, NULL);
        break;
    case RTI_TRACE_STEPS:
        RAYS(4, hits, NULL);
        break;
    default:
        RAYS(6, hits, NULL);
    }
}

void RTI_ISA_FN(JOIN(rti_trace, RTI_TRACER_NAME, occluded))(const rtk_scene *scene, const rtk_trace_block *rays,
                                                            uint16_t *occluded, uint32_t count, uint32_t flags,
                                                            rti_scratch *scratch)
{
    scratch->stats.rays += count;
    if (flags & RTI_TRACE_STEPS)
        RAYS(5, NULL, occluded);
    else if (flags & RTI_TRACE_COHERENT)
        PACKETS(1, NULL, occluded);
    else
        LONE(1, NULL, occluded);
}

int RTI_ISA_FN(JOIN(rti_trace, RTI_TRACER_NAME, one))(const rtk_scene *scene, const rti_ray *ray, float time, rti_hit *hit)
{
    return hit ? ONE(0, hit) : ONE(1, NULL);
}
