/* One pixel, told ray by ray. The job of a single pixel runs as every job does; between it and its tracer and integrator stand
 * functions that look on, so the code that renders knows nothing of it and cannot do otherwise.
 *
 * What a ray brings is read from the film: for the time of a batch every ray has a cell of its own (its home), which is then
 * added to the pixel's, cell 0. Shadow rays are answered one by one (their queue holds one), so that each one's share is the
 * difference that it makes to its parent's cell. Sums of integers do not mind.
 */
#include <stddef.h>
#include <string.h>

#include "../kernel/film.h"
#include "job.h"
#include "librt/explain.h"

#define CELL_SHIFT 16u /* more cells than a batch has rays */
#define NOBODY     0xffffffffu

typedef struct recorder {
    rti_integrator watch; /* the integrator with functions of ours; see recorder_of */
    const rti_integrator *integrator;
    rti_tracer tracer_watch;
    const rti_tracer *tracer;
    rt_job *job;
    uint32_t first_sample, end_sample;

    rt_explained_ray *rays; /* surfaces are filled in when they are told */
    size_t count, capacity;
    uint32_t *stack_parent; /* of every waiting ray */
    uint32_t *cell_ray;     /* of every cell; NOBODY: not told */
    uint64_t *film;
    rti_steps *steps;
    uint32_t cells; /* in use by this batch, cell 0 included */
    uint32_t shadow, shadow_cell;
    uint64_t shadow_before[3];
    bool failed;
} recorder;

static recorder *recorder_of(const rti_worker *w)
{
    return (recorder *)(void *)((char *)(uintptr_t)w->frame->set.integrator - offsetof(recorder, watch));
}

static rti_worker *worker_of(rti_scratch *scratch)
{
    return (rti_worker *)(void *)((char *)scratch - offsetof(rti_worker, scratch));
}

static uint64_t *cell_at(const recorder *r, uint32_t cell)
{
    return r->film + (size_t)cell * RTK_FILM_CHANNELS;
}

/* ---- records ---- */

static uint32_t add_record(recorder *r)
{
    rt_explained_ray *made;
    if (r->failed || !rti_reserve(r->job->ctx, (void **)&r->rays, &r->capacity, r->count, 1, sizeof *r->rays)) {
        r->failed = true;
        atomic_store_explicit(&r->job->cancel.asked, true, memory_order_relaxed);
        return NOBODY;
    }
    made = &r->rays[r->count];
    memset(made, 0, sizeof *made);
    made->index = (uint32_t)r->count;
    made->parent = made->light = RT_INVALID_ID;
    return (uint32_t)r->count++;
}

static rt_vec3 public_vec(rtk_vec3 v)
{
    return (rt_vec3){v.x, v.y, v.z};
}

static rt_hit public_hit(rtk_hit h)
{
    return (rt_hit){h.t, h.u, h.v, h.prim, h.geom, h.inst};
}

static rt_ray ray_in(const rtk_trace_block *blocks, uint32_t i)
{
    const rtk_trace_block *b = &blocks[i / RTK_BLOCK];
    uint32_t k = i % RTK_BLOCK;
    return (rt_ray){{b->ox[k], b->oy[k], b->oz[k]}, b->tmin[k], {b->dx[k], b->dy[k], b->dz[k]}, b->tmax[k], b->mask[k]};
}

static rt_ray_cost cost_of(const rti_steps *s)
{
    return (rt_ray_cost){s->nodes, s->leaves, s->tests};
}

/* ---- shadow rays: the queue holds one ---- */

/* What the last shadow ray has brought by now is final when the next one comes, and at the end of a step. */
static void end_shadow(recorder *r)
{
    const uint64_t *cell = cell_at(r, r->shadow_cell);
    if (r->shadow == NOBODY)
        return;
    for (int c = 0; c < 3; c++)
        r->rays[r->shadow].brought[c] = (int64_t)(cell[c] - r->shadow_before[c]);
    r->shadow = NOBODY;
}

static void begin_shadow(recorder *r, const rti_worker *w, rt_ray_kind kind)
{
    const rti_shadows *q = &w->shadows;
    uint32_t cell = q->pending[0].home[0], parent = r->cell_ray[cell];
    rt_explained_ray *ray;
    end_shadow(r);
    if (parent == NOBODY || (r->shadow = add_record(r)) == NOBODY)
        return;
    r->shadow_cell = cell;
    memcpy(r->shadow_before, cell_at(r, cell), sizeof r->shadow_before);
    ray = &r->rays[r->shadow];
    ray->parent = parent;
    ray->sample = r->rays[parent].sample;
    ray->depth = r->rays[parent].depth;
    ray->kind = kind;
    ray->light = q->light < w->frame->scene->light_count ? q->light : RT_INVALID_ID;
    ray->ray = ray_in(q->trace, 0);
    ray->throughput = (rt_vec3){q->pending[0].r[0], q->pending[0].g[0], q->pending[0].b[0]};
    ray->hit = public_hit(rtk_hit_none(ray->ray.tmax));
}

static void add_cost(rt_explained_ray *ray, const rti_steps *s)
{
    ray->cost.nodes += s->nodes;
    ray->cost.leaves += s->leaves;
    ray->cost.tests += s->tests;
}

/* The renderer asks whether; the tale wants to know what, and asks once more. */
static void watch_occluded(const rtk_scene *scene, const rtk_trace_block *rays, uint16_t *occluded, uint32_t count,
                           uint32_t flags, rti_scratch *scratch)
{
    rti_worker *w = worker_of(scratch);
    recorder *r = recorder_of(w);
    bool ao = r->integrator->flags & RTI_INTEGRATOR_AO;
    rtk_hit_block hit;
    begin_shadow(r, w, ao ? RT_RAY_AO : RT_RAY_SHADOW);
    scratch->steps = r->steps;
    r->tracer->occluded(scene, rays, occluded, count, flags | RTI_TRACE_STEPS, scratch);
    if (r->shadow == NOBODY)
        return;
    add_cost(&r->rays[r->shadow], &r->steps[0]);
    r->rays[r->shadow].arrived = !(occluded[0] & 1u);
    if (occluded[0] & 1u) {
        r->tracer->intersect(scene, rays, &hit, 1, 0, scratch);
        r->rays[r->shadow].hit = public_hit(rti_hit_at(&hit, 0));
    }
}

/* A tinted shadow ray goes from hit to hit: a call each. */
static void watch_tinted(recorder *r, rti_worker *w, const rtk_scene *scene, uint32_t flags)
{
    rti_shadows *q = &w->shadows;
    rt_explained_ray *ray;
    rtk_hit hit;
    if (!(flags & RTI_TRACE_AFTER))
        begin_shadow(r, w, RT_RAY_SHADOW);
    else if (r->shadow != NOBODY)
        r->rays[r->shadow].crossed++; /* the last hit let it through, or it would not be here again */
    r->tracer->intersect(scene, q->trace, q->hits, q->count, flags | RTI_TRACE_STEPS, &w->scratch);
    if (r->shadow == NOBODY)
        return;
    ray = &r->rays[r->shadow];
    hit = rti_hit_at(q->hits, 0);
    add_cost(ray, &r->steps[0]);
    ray->arrived = hit.prim == RTK_INVALID;
    if (!ray->arrived)
        ray->hit = public_hit(hit);
}

/* ---- rays of the batch ---- */

static bool is_told(const recorder *r, uint32_t sample)
{
    return sample >= r->first_sample && sample < r->end_sample;
}

/* Gives ray i its cell, and its record when it is one to be told. parent: NOBODY for camera rays. */
static void begin_ray(recorder *r, rti_worker *w, uint32_t i, uint32_t parent, const rti_steps *steps)
{
    rti_ray_state state = rti_batch_state(w, i);
    rt_explained_ray *ray;
    uint32_t cell = i + 1, index = is_told(r, state.sample) ? add_record(r) : NOBODY;
    w->batch.home[i / RTK_BLOCK].home[i % RTK_BLOCK] = cell;
    r->cell_ray[cell] = index;
    r->cells = cell + 1 > r->cells ? cell + 1 : r->cells;
    if (index == NOBODY)
        return;
    ray = &r->rays[index];
    ray->parent = parent;
    ray->sample = state.sample;
    ray->depth = state.depth;
    ray->kind = (rt_ray_kind)state.kind;
    ray->ray = ray_in(w->batch.trace, i);
    ray->hit = public_hit(rti_hit_at(w->hits, i));
    ray->throughput = public_vec(state.tp);
    ray->cost = cost_of(steps);
}

static void watch_intersect(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits, uint32_t count,
                            uint32_t flags, rti_scratch *scratch)
{
    rti_worker *w = worker_of(scratch);
    recorder *r = recorder_of(w);
    rti_steps *steps = scratch->steps;
    uint32_t first;
    if (rays == w->shadows.trace) {
        scratch->steps = r->steps;
        watch_tinted(r, w, scene, flags);
        return;
    }
    first = (uint32_t)(rays - w->batch.trace) * RTK_BLOCK;
    if (!steps)
        steps = scratch->steps = r->steps;
    r->tracer->intersect(scene, rays, hits, count, flags | RTI_TRACE_STEPS, scratch);
    if (first == 0)
        r->cells = 1;
    for (uint32_t i = 0; i < count; i++) {
        bool camera = w->batch.path[(first + i) / RTK_BLOCK].depth_kind[(first + i) % RTK_BLOCK] == RTK_KIND_CAMERA << 16;
        begin_ray(r, w, first + i, camera ? NOBODY : r->stack_parent[w->stack.count + i], &steps[i]);
    }
}

/* Whose are the rays that were put on the stack: their home is their parent's cell. */
static void watch_shade(rti_worker *w, uint32_t first, uint32_t count)
{
    recorder *r = recorder_of(w);
    uint32_t before = w->stack.count;
    r->integrator->shade(w, first, count);
    for (uint32_t i = before; i < w->stack.count; i++)
        r->stack_parent[i] = r->cell_ray[w->stack.home[i / RTK_BLOCK].home[i % RTK_BLOCK]];
}

static void take_shares(recorder *r, bool lights)
{
    for (uint32_t cell = 1; cell < r->cells; cell++) {
        const uint64_t *sum = cell_at(r, cell);
        rt_explained_ray *ray = r->cell_ray[cell] == NOBODY ? NULL : &r->rays[r->cell_ray[cell]];
        for (int c = 0; ray && c < 3; c++)
            (lights ? ray->unshadowed : ray->brought)[c] += (int64_t)sum[c];
    }
}

/* What stands in the cells goes to the pixel; they are empty then, those too that a batch leaves between its two kinds of rays.
 */
static void pour(recorder *r)
{
    uint64_t *pixel = cell_at(r, 0);
    for (uint32_t cell = 1; cell < r->cells; cell++) {
        for (uint32_t c = 0; c < RTK_FILM_CHANNELS; c++) {
            pixel[c] += cell_at(r, cell)[c];
            cell_at(r, cell)[c] = 0;
        }
    }
}

/* The second half of a step, and its end. */
static void watch_light(rti_worker *w)
{
    recorder *r = recorder_of(w);
    bool sums = !(r->integrator->flags & RTI_INTEGRATOR_RAW);
    if (sums)
        take_shares(r, false);
    pour(r);
    if (r->integrator->light)
        r->integrator->light(w);
    rti_shadow_flush(w);
    end_shadow(r);
    if (!w->frame->set.desc.shadows && sums &&
        !(r->integrator->flags & RTI_INTEGRATOR_AO)) /* whose rays are asked all the same */
        take_shares(r, true);
    pour(r);
    r->cells = 1;
}

/* ---- the job of one pixel ---- */

rt_explain_desc rt_explain_desc_default(void)
{
    rt_explain_desc d;
    memset(&d, 0, sizeof d);
    d.struct_size = sizeof d;
    return d;
}

static const char what[] = "rt_render_explain";

static rt_status check(rt_context *ctx, const rti_settings *set, const rt_explain_desc *e)
{
    if (e->x >= set->desc.width || e->y >= set->desc.height)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: pixel %u,%u lies outside of the image of %u x %u; the last one is %u,%u",
                        what, e->x, e->y, set->desc.width, set->desc.height, set->desc.width - 1, set->desc.height - 1);
    if (e->first_sample >= set->samples)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: there is no sample %u; the pixel has samples 0 ... %u", what,
                        e->first_sample, set->samples - 1);
    return RT_OK;
}

static rt_status make_arrays(recorder *r, uint32_t stack, uint32_t batch)
{
    rt_context *ctx = r->job->ctx;
    r->stack_parent = rti_alloc_array(ctx, stack, sizeof *r->stack_parent);
    r->cell_ray = rti_alloc_array(ctx, batch + 1, sizeof *r->cell_ray);
    r->film = rti_alloc_array(ctx, batch + 1, RTK_FILM_CHANNELS * sizeof *r->film);
    r->steps = rti_alloc_array(ctx, batch, sizeof *r->steps);
    if (!r->stack_parent || !r->cell_ray || !r->film || !r->steps)
        return rti_fail_memory(ctx, what, (size_t)batch * 64);
    memset(r->film, 0, (batch + 1) * RTK_FILM_CHANNELS * sizeof *r->film);
    memset(r->cell_ray, 0xff, (batch + 1) * sizeof *r->cell_ray);
    return RT_OK;
}

static void free_arrays(recorder *r, rt_context *ctx, uint32_t stack, uint32_t batch)
{
    rti_free(ctx, r->stack_parent, stack * sizeof *r->stack_parent);
    rti_free(ctx, r->cell_ray, (batch + 1) * sizeof *r->cell_ray);
    rti_free(ctx, r->film, (batch + 1) * RTK_FILM_CHANNELS * sizeof *r->film);
    rti_free(ctx, r->steps, batch * sizeof *r->steps);
    rti_free(ctx, r->rays, r->capacity * sizeof *r->rays);
}

/* Our functions between the job and its tracer and integrator; a film of cells; a shadow queue of one. */
static void look_on(recorder *r)
{
    rti_frame *f = &r->job->frame;
    rti_worker *w = &r->job->workers[0].wave;
    r->integrator = f->set.integrator;
    r->watch = *f->set.integrator;
    r->watch.shade = watch_shade;
    r->watch.light = watch_light;
    r->tracer = f->set.tracer;
    r->tracer_watch = *f->set.tracer;
    r->tracer_watch.intersect = watch_intersect;
    r->tracer_watch.occluded = watch_occluded;
    r->cells = 1;
    r->shadow = NOBODY;
    f->set.integrator = &r->watch;
    f->set.tracer = &r->tracer_watch;
    f->slot_shift = CELL_SHIFT;
    w->film = r->film;
    w->shadows.capacity = 1;
    w->lit_most = 0xffffffffu; /* lights shine at the end of a step, once */
    w->scratch.bare = false;   /* hits are told whole */
}

static void tell_pixel(const recorder *r, rt_explained_pixel *pixel)
{
    const rti_frame *f = &r->job->frame;
    const rti_worker_counts *counts = &r->job->workers[0].wave.counts;
    bool raw = r->integrator->flags & RTI_INTEGRATOR_RAW;
    memset(pixel, 0, sizeof *pixel);
    pixel->samples = f->set.samples;
    pixel->rays = (uint32_t)r->count;
    pixel->unit = raw ? 0.0 : f->film_unit;
    for (int c = 0; !raw && c < 3; c++)
        pixel->sum[c] = (int64_t)r->film[c];
    memcpy(pixel->value, rt_image_pixels_const(rt_job_image(r->job)), sizeof pixel->value);
    pixel->clamped = counts->clamped;
    pixel->dropped = counts->dropped;
}

static rt_status tell(recorder *r, rt_explained_ray_fn fn, void *user, rt_explained_pixel *pixel)
{
    const rti_frame *f = &r->job->frame;
    uint32_t index = f->set.desc.crop.y * f->set.desc.width + f->set.desc.crop.x;
    for (size_t i = 0; fn && i < r->count; i++) {
        rt_explained_ray *ray = &r->rays[i];
        rti_snapshot_surface(r->job->snapshot, &ray->ray, rti_frame_time(f, index, ray->sample), &ray->hit, &ray->surface);
        if (fn(user, ray) != 0)
            return rti_fail(r->job->ctx, RT_ERROR_CANCELLED, "%s: the callback ended it", what);
    }
    if (pixel)
        tell_pixel(r, pixel);
    return RT_OK;
}

static rt_status run(recorder *r, const rt_explain_desc *e)
{
    rt_status status = rti_job_run(r->job);
    float done;
    while (status == RT_OK && e->progress && rt_job_wait(r->job, 0.05) == RT_JOB_RUNNING) {
        rt_job_poll(r->job, &done);
        if (e->progress(e->user, done) == 0)
            continue;
        rt_job_cancel(r->job);
        rt_job_wait(r->job, -1);
        return rti_fail(r->job->ctx, RT_ERROR_CANCELLED, "%s: the callback ended it", what);
    }
    if (status == RT_OK && rt_job_wait(r->job, -1) != RT_JOB_DONE)
        status = r->failed ? rti_fail_memory(r->job->ctx, what, r->count * sizeof *r->rays) : rt_job_status(r->job);
    return status;
}

/* The desc of the pixel's own job, and what the caller asks, checked against his. */
static rt_status take_descs(rt_context *ctx, rti_snapshot *snapshot, const rt_render_desc *desc, const rt_explain_desc *asked,
                            rt_render_desc *d, rt_explain_desc *e)
{
    rti_settings set;
    rt_status status;
    *d = rt_render_desc_default();
    *e = rt_explain_desc_default();
    status = rti_desc_take(ctx, what, desc, d, sizeof *d);
    if (status == RT_OK)
        status = rti_desc_take(ctx, what, asked, e, sizeof *e);
    if (status != RT_OK)
        return status;
    memset(&d->crop, 0, sizeof d->crop);
    d->pixels = NULL;
    d->pixels_stride = 0;
    d->workers = 1;
    d->tile = 1;
    d->schedule = RT_SCHEDULE_DYNAMIC;
    status = rti_settings_take(ctx, what, snapshot, d, &set);
    if (status == RT_OK)
        status = check(ctx, &set, e);
    d->crop = (rt_tile){e->x, e->y, 1, 1};
    return status;
}

static rt_status explain(rt_context *ctx, rti_snapshot *snapshot, const rt_render_desc *d, const rt_explain_desc *e,
                         rt_explained_ray_fn fn, void *user, rt_explained_pixel *pixel)
{
    recorder r;
    uint32_t stack, batch;
    rt_status status;
    memset(&r, 0, sizeof r);
    status = rti_job_create(ctx, snapshot, what, d, NULL, &r.job);
    if (status != RT_OK)
        return status;
    stack = r.job->workers[0].wave.stack.capacity;
    batch = r.job->frame.batch;
    r.first_sample = e->first_sample;
    r.end_sample =
        e->sample_count && e->sample_count < UINT32_MAX - e->first_sample ? e->first_sample + e->sample_count : UINT32_MAX;
    status = make_arrays(&r, stack, batch);
    if (status == RT_OK) {
        look_on(&r);
        status = run(&r, e);
    }
    if (status == RT_OK)
        status = tell(&r, fn, user, pixel);
    rt_job_destroy(r.job);
    free_arrays(&r, ctx, stack, batch);
    return status;
}

rt_status rt_render_explain(rt_scene *scene, const rt_render_desc *desc, const rt_explain_desc *asked, rt_explained_ray_fn fn,
                            void *user, rt_explained_pixel *pixel)
{
    RTI_NEED(scene);
    rt_context *ctx = rt_scene_context(scene);
    rti_snapshot *snapshot;
    rt_render_desc d;
    rt_explain_desc e;
    rt_status status = rti_job_snapshot(scene, what, &snapshot);
    if (status != RT_OK)
        return status;
    status = take_descs(ctx, snapshot, desc, asked, &d, &e);
    if (status == RT_OK)
        status = explain(ctx, snapshot, &d, &e, fn, user, pixel);
    rti_snapshot_release(snapshot);
    return status;
}
