/* One mode of a single-ray tracer: its walk and its loop. Included by single.inl once a mode. */
#include "../kernel/scene_trace.inl"

static inline void RTK_NAME(start)(rtk_query *q, const rtk_scene *scene, const rtk_trace_block *b, uint32_t lane)
{
    rtk_ray ray;
    ray.org = rtk_v3(b->ox[lane], b->oy[lane], b->oz[lane]);
    ray.dir = rtk_v3(b->dx[lane], b->dy[lane], b->dz[lane]);
    ray.tmin = b->tmin[lane];
    ray.tmax = b->tmax[lane];
    ray.mask = b->mask[lane];
    rtk_query_init(q, scene, ray);
}

static inline void RTK_NAME(count)(const rtk_query *q, uint32_t i, rti_scratch *scratch)
{
    scratch->stats.nodes += q->nodes;
    scratch->stats.leaves += q->leaves;
    scratch->stats.tests += q->tests;
    if (scratch->steps)
        scratch->steps[i] = q->nodes + q->tests;
}

#if RTK_MODE & 1
static void RTK_NAME(any)(const rtk_scene *scene, const rtk_trace_block *rays, uint16_t *occluded, uint32_t count,
                          rti_scratch *scratch)
{
    scratch->stats.rays += count;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t block = i / RTK_BLOCK, lane = i % RTK_BLOCK;
        rtk_query q;
        RTK_NAME(start)(&q, scene, &rays[block], lane);
        if (lane == 0)
            occluded[block] = 0;
        occluded[block] = (uint16_t)(occluded[block] | RTK_NAME(trace)(&q) << lane);
        if (RTK_MODE & RTK_MODE_STEPS)
            RTK_NAME(count)(&q, i, scratch);
    }
}
#else
static void RTK_NAME(closest)(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits, uint32_t count,
                              rti_scratch *scratch)
{
    scratch->stats.rays += count;
    for (uint32_t i = 0; i < count; i++) {
        rtk_hit_block *h = &hits[i / RTK_BLOCK];
        uint32_t lane = i % RTK_BLOCK;
        rtk_query q;
        RTK_NAME(start)(&q, scene, &rays[i / RTK_BLOCK], lane);
        if ((RTK_MODE & RTK_MODE_AFTER) && h->prim[lane] != RTK_INVALID) {
            q.after.t = h->t[lane];
            q.after.inst = h->inst[lane];
            q.after.geom = h->geom[lane];
            q.after.prim = h->prim[lane];
        }
        RTK_NAME(trace)(&q);
        h->t[lane] = q.best.t;
        h->u[lane] = q.best.u;
        h->v[lane] = q.best.v;
        h->prim[lane] = q.best.prim;
        h->geom[lane] = q.best.geom;
        h->inst[lane] = q.best.inst;
        if (RTK_MODE & RTK_MODE_STEPS)
            RTK_NAME(count)(&q, i, scratch);
    }
}
#endif
