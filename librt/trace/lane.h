/* A ray out of its block and its answer back into one. */
#ifndef RTI_LANE_H
#define RTI_LANE_H

#include "../kernel/query.h"
#include "trace.h"

static inline void rti_lane_query(rtk_query *q, const rtk_scene *scene, const rtk_trace_block *rays, uint32_t i,
                                  const rti_scratch *scratch)
{
    const rtk_trace_block *b = &rays[i / RTK_BLOCK];
    uint32_t lane = i % RTK_BLOCK;
    rtk_ray ray;
    ray.org = rtk_v3(b->ox[lane], b->oy[lane], b->oz[lane]);
    ray.dir = rtk_v3(b->dx[lane], b->dy[lane], b->dz[lane]);
    ray.tmin = b->tmin[lane];
    ray.tmax = b->tmax[lane];
    ray.mask = b->mask[lane];
    rtk_query_init(q, scene, ray);
    q->bare = scratch->bare;
    if (scratch->times)
        q->time = scratch->times[i];
}

/* The hit that stands in ray i's lane, and another in its place. */
static inline rtk_hit rti_lane_best(const rtk_hit_block *hits, uint32_t i)
{
    const rtk_hit_block *h = &hits[i / RTK_BLOCK];
    const uint32_t lane = i % RTK_BLOCK;
    return (rtk_hit){h->t[lane], h->u[lane], h->v[lane], h->prim[lane], h->geom[lane], h->inst[lane]};
}

static inline void rti_lane_keep(rtk_hit_block *hits, uint32_t i, rtk_hit hit)
{
    rtk_hit_block *h = &hits[i / RTK_BLOCK];
    const uint32_t lane = i % RTK_BLOCK;
    h->t[lane] = hit.t;
    h->u[lane] = hit.u;
    h->v[lane] = hit.v;
    h->prim[lane] = hit.prim;
    h->geom[lane] = hit.geom;
    h->inst[lane] = hit.inst;
}

/* The last hit, for RTI_TRACE_AFTER. */
static inline void rti_lane_after(rtk_query *q, const rtk_hit_block *hits, uint32_t i)
{
    const rtk_hit_block *h = &hits[i / RTK_BLOCK];
    uint32_t lane = i % RTK_BLOCK;
    if (h->prim[lane] == RTK_INVALID)
        return;
    q->after.t = h->t[lane];
    q->after.inst = h->inst[lane];
    q->after.geom = h->geom[lane];
    q->after.prim = h->prim[lane];
}

static inline void rti_lane_hit(rtk_query *q, rtk_hit_block *hits, uint32_t i)
{
    rtk_query_finish(q);
    rti_lane_keep(hits, i, q->best);
}

static inline void rti_lane_occluded(uint16_t *occluded, uint32_t i, int hit)
{
    uint32_t before = i % RTK_BLOCK == 0 ? 0 : occluded[i / RTK_BLOCK];
    occluded[i / RTK_BLOCK] = (uint16_t)(before | (hit ? 1u << i % RTK_BLOCK : 0u));
}

static inline void rti_lane_count(const rtk_query *q, uint32_t i, rti_scratch *scratch)
{
    scratch->stats.nodes += q->nodes;
    scratch->stats.leaves += q->leaves;
    scratch->stats.tests += q->tests;
    if (scratch->steps)
        scratch->steps[i] = (rti_steps){q->nodes, q->leaves, q->tests};
}

#endif
