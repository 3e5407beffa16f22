/* Rays of plain arrays to a tracer and its answers back, for rt_scene_* and rt_tracer_*. */
#ifndef RTI_ARRAYS_H
#define RTI_ARRAYS_H

#include "../trace/trace.h"
#include "parts.h"

#define RTI_ARRAYS_GUESS 0xffffffffu /* flags: nobody has said what the rays are like, so they are looked at */
#define RTI_ARRAYS_ALONE 8u          /* rays from which on they go together; fewer: each goes by itself, in no memory */

/* times: [count] or NULL. flags: RTI_TRACE_COHERENT, 0, or GUESS. Any thread; the snapshot is held by the caller. */
void rti_arrays_intersect(const rti_snapshot *snapshot, const struct rti_tracer *tracer, const rt_ray *rays, const float *times,
                          rt_hit *hits, size_t count, uint32_t flags);
void rti_arrays_occluded(const rti_snapshot *snapshot, const struct rti_tracer *tracer, const rt_ray *rays, const float *times,
                         uint8_t *occluded, size_t count, uint32_t flags);

/* What rays look like of which nobody has said anything: RTI_TRACE_COHERENT when in half of the whole blocks, looking at every
 * third, all rays point into one octant (a row of pixels that crosses the middle of the picture mixes up to a third of its tiles'
 * blocks), else 0. A wrong guess costs time, never a hit. */
uint32_t rti_arrays_guess(const rtk_trace_block *blocks, uint32_t count);

/* For rays that stand in blocks: what a tracer works with, and what calls before have learned of the scene; without a room when
 * there is none, or a few rays need none. flags: as above. */
rti_scratch rti_trace_room_take(const rti_snapshot *scene, size_t count, uint32_t flags);
void rti_trace_room_give(const rti_snapshot *scene, const rti_scratch *scratch);

#endif
