/* Views for looking into a scene: one camera ray a pixel, its hit as a value. */
#include "../kernel/integrate.h"
#include "../kernel/maths.h"
#include "../kernel/rng.h"
#include "direct.h"

typedef rtk_vec3 (*view_fn)(const rti_worker *worker, uint32_t i, rtk_hit hit);

static void view(rti_worker *w, uint32_t first, uint32_t count, view_fn value)
{
    for (uint32_t i = first; i < first + count; i++) {
        uint32_t home = w->batch.home[i / RTK_BLOCK].home[i % RTK_BLOCK];
        rtk_hit hit = rti_hit_at(w->hits, i);
        if (hit.prim == RTK_INVALID)
            continue;
        rti_cover(w, home);
        rti_set_raw(w, home, value(w, i, hit));
    }
}

static rtk_vec3 normal_of(const rti_worker *worker, uint32_t i, rtk_hit hit)
{
    rtk_surface s = rtk_surface_at(worker->frame->scene, rti_batch_ray(worker, i), hit, rti_batch_time(worker, i));
    return rtk_v3(0.5f + 0.5f * s.ns.x, 0.5f + 0.5f * s.ns.y, 0.5f + 0.5f * s.ns.z);
}

static rtk_vec3 uv_of(const rti_worker *worker, uint32_t i, rtk_hit hit)
{
    rtk_surface s = rtk_surface_at(worker->frame->scene, rti_batch_ray(worker, i), hit, rti_batch_time(worker, i));
    return rtk_v3(s.u - rtk_floor(s.u), s.v - rtk_floor(s.v), 0.0f);
}

/* Neighbouring numbers get unlike colours, none of them dark. */
static rtk_vec3 id_of(const rti_worker *worker, uint32_t i, rtk_hit hit)
{
    uint32_t h = rtk_hash3(hit.prim, hit.geom, hit.inst);
    (void)worker;
    (void)i;
    return rtk_v3(0.2f + (float)(h & 255u) / 320.0f, 0.2f + (float)(h >> 8 & 255u) / 320.0f,
                  0.2f + (float)(h >> 16 & 255u) / 320.0f);
}

static rtk_vec3 depth_of(const rti_worker *worker, uint32_t i, rtk_hit hit)
{
    (void)worker;
    (void)i;
    return rtk_v3(hit.t, hit.t, hit.t);
}

void rti_shade_normal(struct rti_worker *worker, uint32_t first, uint32_t count)
{
    view(worker, first, count, normal_of);
}

void rti_shade_uv(struct rti_worker *worker, uint32_t first, uint32_t count)
{
    view(worker, first, count, uv_of);
}

void rti_shade_id(struct rti_worker *worker, uint32_t first, uint32_t count)
{
    view(worker, first, count, id_of);
}

void rti_shade_depth(struct rti_worker *worker, uint32_t first, uint32_t count)
{
    view(worker, first, count, depth_of);
}

/* Black at none, then blue, cyan, green, yellow, red, and white at 1024 steps or more, by the logarithm. */
static rtk_vec3 heat(uint32_t steps)
{
    static const float ramp[7][3] = {{0, 0, 0}, {0, 0, 1}, {0, 1, 1}, {0, 1, 0}, {1, 1, 0}, {1, 0, 0}, {1, 1, 1}};
    float x = rtk_min(rtk_log2((float)steps + 1.0f) / 10.0f, 1.0f) * 6.0f;
    uint32_t i = (uint32_t)x < 5u ? (uint32_t)x : 5u;
    float w = x - (float)i;
    return rtk_v3(ramp[i][0] + w * (ramp[i + 1][0] - ramp[i][0]), ramp[i][1] + w * (ramp[i + 1][1] - ramp[i][1]),
                  ramp[i][2] + w * (ramp[i + 1][2] - ramp[i][2]));
}

void rti_shade_cost(struct rti_worker *worker, uint32_t first, uint32_t count)
{
    for (uint32_t i = first; i < first + count; i++) {
        uint32_t home = worker->batch.home[i / RTK_BLOCK].home[i % RTK_BLOCK];
        rti_cover(worker, home);
        rti_set_raw(worker, home, heat(worker->steps[i].nodes + worker->steps[i].tests));
    }
}

void rti_shade_steps(struct rti_worker *worker, uint32_t first, uint32_t count)
{
    for (uint32_t i = first; i < first + count; i++) {
        const rti_steps *s = &worker->steps[i];
        uint32_t home = worker->batch.home[i / RTK_BLOCK].home[i % RTK_BLOCK];
        rti_cover(worker, home);
        rti_set_raw(worker, home, rtk_v3((float)s->nodes, (float)s->leaves, (float)s->tests));
    }
}
