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

#define SAME(a, b) (offsetof(rt_ray, a) == offsetof(rti_ray, b))
_Static_assert(sizeof(rt_ray) == sizeof(rti_ray) && SAME(org, org) && SAME(tmin, tmin) && SAME(dir, dir) && SAME(tmax, tmax) &&
                   SAME(mask, mask),
               "a public ray is a tracer's");
#undef SAME
#define SAME(a, b) (offsetof(rt_hit, a) == offsetof(rti_hit, b))
_Static_assert(sizeof(rt_hit) == sizeof(rti_hit) && SAME(t, t) && SAME(u, u) && SAME(v, v) && SAME(prim_id, prim) &&
                   SAME(geom_id, geom) && SAME(inst_id, inst),
               "and so is a hit");
#undef SAME

static inline const rti_ray *rti_ray_at(const rt_ray *ray)
{
    return (const rti_ray *)(const void *)ray;
}

static inline rti_hit *rti_hit_at(rt_hit *hit)
{
    return (rti_hit *)(void *)hit;
}

/* One ray, for which no batch is made. vouched: the caller has given RT_RAYS_DEFAULT_FENV. */
static inline void rti_arrays_intersect_one(const rti_snapshot *snapshot, const struct rti_tracer *tracer, const rt_ray *ray,
                                            float time, rt_hit *hit, bool vouched)
{
    if (vouched) {
        tracer->one(&snapshot->view, rti_ray_at(ray), time, rti_hit_at(hit));
        return;
    }
    const rti_fpenv env = rti_fp_enter();
    tracer->one(&snapshot->view, rti_ray_at(ray), time, rti_hit_at(hit));
    rti_fp_leave(env);
}
static inline void rti_arrays_occluded_one(const rti_snapshot *snapshot, const struct rti_tracer *tracer, const rt_ray *ray,
                                           float time, uint8_t *occluded, bool vouched)
{
    if (vouched) {
        *occluded = tracer->one(&snapshot->view, rti_ray_at(ray), time, NULL) != 0;
        return;
    }
    const rti_fpenv env = rti_fp_enter();
    *occluded = tracer->one(&snapshot->view, rti_ray_at(ray), time, NULL) != 0;
    rti_fp_leave(env);
}

/* What rays look like of which nobody has said anything: RTI_TRACE_COHERENT when in half of the whole blocks, looking at every
 * third, all rays point into one octant (a row of pixels that crosses the middle of the picture mixes up to a third of its tiles'
 * blocks), else 0. A wrong guess costs time, never a hit. */
uint32_t rti_arrays_guess(const rtk_trace_block *blocks, uint32_t count);

/* For rays that stand in blocks: what a tracer works with, and what calls before have learned of the scene; without a room when
 * there is none, or a few rays need none. flags: as above. */
rti_scratch rti_trace_room_take(const rti_snapshot *scene, size_t count, uint32_t flags);
void rti_trace_room_give(const rti_snapshot *scene, const rti_scratch *scratch);

#endif
