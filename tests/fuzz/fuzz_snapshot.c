/* Snapshot files: whatever the decoder lets through must be safe to trace, to shade, to render and to build other trees for. */
#include <stdlib.h>
#include <string.h>

#include "../support/many.h"
#include "kernel/surface.h"
#include "kernel/texture.h"
#include "render/job.h"
#include "scene/blob.h"
#include "trace/trace.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int fuzz_refused(void);

static int refused;

/* Did the last input get no farther than the decoder? replay.c asks. */
int fuzz_refused(void)
{
    return refused;
}

static rt_context *fuzz_context(void)
{
    static rt_context *ctx;
    if (!ctx) {
        rt_context_desc d = rt_context_desc_default();
        d.workers = 1;
        d.memory_limit = (uint64_t)256 << 20;
        if (rt_context_create(&d, &ctx) != RT_OK)
            abort();
    }
    return ctx;
}

#define TIME(i) ((float)(i) / 15.0f)

static void make_rays(rtk_trace_block *rays, rtk_vec3 lo, rtk_vec3 hi)
{
    rtk_vec3 mid = rtk_scale(rtk_add(lo, hi), 0.5f);
    for (uint32_t i = 0; i < RTK_BLOCK; i++) {
        rays->ox[i] = i & 1u ? lo.x - 1.0f : hi.x + 2.0f;
        rays->oy[i] = i & 2u ? lo.y - 3.0f : hi.y + 1.0f;
        rays->oz[i] = i & 4u ? lo.z : hi.z;
        rays->dx[i] = mid.x - rays->ox[i];
        rays->dy[i] = mid.y - rays->oy[i];
        rays->dz[i] = i & 8u ? 0.0f : mid.z - rays->oz[i];
        rays->tmin[i] = 0.0f;
        rays->tmax[i] = 1.0e30f;
        rays->mask[i] = ~0u;
    }
}

static void shade(const rtk_scene *v, const rtk_trace_block *rays, const rtk_hit_block *hits)
{
    for (uint32_t i = 0; i < RTK_BLOCK; i++) {
        rtk_ray ray = {rtk_v3(rays->ox[i], rays->oy[i], rays->oz[i]), rtk_v3(rays->dx[i], rays->dy[i], rays->dz[i]), 0.0f,
                       1.0e30f, ~0u};
        rtk_hit hit = {hits->t[i], hits->u[i], hits->v[i], hits->prim[i], hits->geom[i], hits->inst[i]};
        float rgba[4];
        if (hit.prim == RTK_INVALID)
            continue;
        rtk_surface s = rtk_surface_at(v, ray, hit, TIME(i));
        if (s.material >= v->material_count)
            abort();
        if (v->materials[s.material].color_tex != RTK_INVALID)
            rtk_texture_sample(v->textures[v->materials[s.material].color_tex], s.u, s.v, s.uv_scale, rgba);
    }
}

/* Each ray by itself, as calls of one ray are answered. */
static void alone(const rtk_scene *v, const rti_tracer *tracer, const rtk_trace_block *rays)
{
    for (uint32_t i = 0; i < RTK_BLOCK; i++) {
        const rti_ray ray = {{rays->ox[i], rays->oy[i], rays->oz[i]},
                             rays->tmin[i],
                             {rays->dx[i], rays->dy[i], rays->dz[i]},
                             rays->tmax[i],
                             rays->mask[i]};
        rti_hit hit;
        tracer->one(v, &ray, TIME(i), &hit);
        tracer->one(v, &ray, TIME(i), NULL);
    }
}

/* Small pictures by the file's own camera and lights, shaded in lanes. */
static void render(rt_context *ctx, rti_snapshot *snapshot)
{
    static const char *const integrators[] = {"whitted", "path"};
    for (size_t i = 0; i < sizeof integrators / sizeof *integrators; i++) {
        rt_render_desc d = rt_render_desc_default();
        rt_job *job = NULL;
        d.width = 20;
        d.height = 12;
        d.samples = 1;
        d.workers = 1;
        d.max_depth = 3;
        d.integrator = integrators[i];
        if (rti_job_create(ctx, snapshot, "fuzz", &d, NULL, &job) != RT_OK)
            continue;
        rt_job_wait(job, -1);
        rt_job_destroy(job);
    }
}

/* As many as go to instances together; one where there are none. */
enum { BLOCKS = 17 };

/* A loaded snapshot traced by every tracer in each way; the hits agree, or the file's own tree was wrong, which is no crash. */
static void use(rt_context *ctx, rti_snapshot *snapshot)
{
    static _Alignas(64) rtk_trace_block rays[BLOCKS];
    static _Alignas(64) rtk_hit_block hits[BLOCKS];
    static float times[BLOCKS * RTK_BLOCK];
    const uint32_t count = rti_snapshot_view(snapshot)->instance_count != 0 ? BLOCKS * RTK_BLOCK : RTK_BLOCK;
    rtk_vec3 lo, hi;
    rti_snapshot_bounds(snapshot, &lo, &hi);
    for (uint32_t b = 0; b < BLOCKS; b++) { /* some beside it */
        const float by = 0.1f * (float)(b % 5) * (hi.x - lo.x);
        make_rays(&rays[b], rtk_v3(lo.x + by, lo.y, lo.z), rtk_v3(hi.x + by, hi.y, hi.z));
    }
    for (uint32_t i = 0; i < BLOCKS * RTK_BLOCK; i++)
        times[i] = TIME(i % RTK_BLOCK);
    for (uint32_t i = 0; i < rti_tracer_count(); i++) {
        const rti_tracer *tracer = rti_tracer_at(rti_isa_best(), i);
        static _Alignas(64) unsigned char room[RTI_TRACE_ROOM];
        rti_scratch scratch = {.room = room, .times = times};
        uint16_t occluded[BLOCKS];
        rti_snapshot *with;
        if (rti_snapshot_with_tree(snapshot, "fuzz", tracer->tree, NULL, &with) != RT_OK)
            continue;
        for (uint32_t way = 0; way < 4; way++) {
            const uint32_t flags = way & 1 ? RTI_TRACE_COHERENT : 0;
            scratch.turns = way == 2;
            scratch.bare = way == 3;
            tracer->occluded(rti_snapshot_view(with), rays, occluded, count, flags, &scratch);
            tracer->intersect(rti_snapshot_view(with), rays, hits, count, flags, &scratch);
        }
        tracer->intersect(rti_snapshot_view(with), rays, hits, RTK_BLOCK, RTI_TRACE_AFTER, &scratch);
        scratch.bare = scratch.turns = false;
        tracer->intersect(rti_snapshot_view(with), rays, hits, RTK_BLOCK, 0, &scratch);
        shade(rti_snapshot_view(with), rays, hits);
        alone(rti_snapshot_view(with), tracer, rays);
        rti_snapshot_release(with);
    }
    if (!TEST_UNWRITTEN)
        render(ctx, snapshot);
}

/* Hashes are not checked, nor the size that the header tells: no mutation would get past them. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    rt_context *ctx = fuzz_context();
    rti_snapshot *snapshot = NULL;
    uint64_t now = 0, length = size;
    uint8_t *copy = rti_alloc(ctx, size);
    if (!copy)
        return 0;
    memcpy(copy, data, size);
    if (size >= sizeof(rti_blob_header))
        memcpy(copy + offsetof(rti_blob_header, file_size), &length, sizeof length);
    refused = rti_blob_decode(ctx, "fuzz.snap", copy, size, false, &snapshot) != RT_OK;
    if (!refused)
        use(ctx, snapshot);
    rti_snapshot_release(snapshot);
    rti_free(ctx, copy, size);
    rt_context_drop_kept(ctx);
    rt_context_memory(ctx, &now, NULL);
    if (now > 65536) /* the empty cache stays */
        abort();
    return 0;
}
