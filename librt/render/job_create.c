/* Making a job: everything that can fail fails here, before the first ray; and ending it. */
#include <string.h>
#include <time.h>

#include "job.h"

static uint64_t image_bytes(const rti_frame *f)
{
    return f->set.desc.pixels ? 0 : (uint64_t)f->set.desc.crop.width * f->set.desc.crop.height * 4 * sizeof(float);
}

/* Bytes beside the scene: what rti_job_create takes. */
static uint64_t memory_of(const rti_frame *frame, uint32_t geom_count)
{
    uint64_t worker = rti_worker_size(frame) + sizeof(rti_job_worker);
    return sizeof(rt_job) + sizeof(rt_image) + image_bytes(frame) + worker * frame->set.desc.workers +
           (uint64_t)frame->tile_count * sizeof(uint32_t) + (uint64_t)geom_count * sizeof(uint32_t) +
           (frame->set.desc.checkpoint ? rti_keeper_bytes(frame) : 0);
}

static rt_status check_memory(rt_context *ctx, const char *what, const rti_frame *frame, uint64_t bytes)
{
    const rt_render_desc *d = &frame->set.desc;
    if (d->memory_limit && bytes > d->memory_limit)
        return rti_fail(ctx, RT_ERROR_MEMORY_LIMIT, "%s: %u x %u pixels with %u workers need %llu bytes; memory_limit is %llu%s",
                        what, d->crop.width, d->crop.height, d->workers, (unsigned long long)bytes,
                        (unsigned long long)d->memory_limit, d->workers > 1 ? "; fewer workers take less" : "");
    return rti_image_check_room(ctx, what, d->crop.width, d->crop.height, bytes);
}

/* Would it be taken as it is? */
static bool within_limits(rt_context *ctx, const rti_frame *frame, uint64_t bytes)
{
    const uint64_t limit = rti_context_memory_limit(ctx), own = frame->set.desc.memory_limit;
    uint64_t now;
    rt_context_memory(ctx, &now, NULL);
    return (limit == 0 || (now <= limit && bytes <= limit - now)) && (own == 0 || bytes <= own);
}

/* Geometries of the scene that are bodies of spherical lights. */
static bool has_bodies(const rtk_scene *scene)
{
    for (uint32_t i = 0; i < scene->light_count; i++) {
        if (scene->lights[i].geom != RTK_INVALID)
            return true;
    }
    return false;
}

static rt_status map_bodies(rt_job *job, const rtk_scene *scene)
{
    uint32_t n = has_bodies(scene) ? scene->groups[0].geom_count : 0;
    if (n == 0)
        return RT_OK;
    job->light_of_geom = rti_alloc_array(job->ctx, n, sizeof *job->light_of_geom);
    if (!job->light_of_geom)
        return rti_fail_memory(job->ctx, "a map of the lights' bodies", n * sizeof *job->light_of_geom);
    job->geom_count = n;
    memset(job->light_of_geom, 0xff, n * sizeof *job->light_of_geom);
    for (uint32_t i = 0; i < scene->light_count; i++) {
        if (scene->lights[i].geom < n)
            job->light_of_geom[scene->lights[i].geom] = i;
    }
    job->frame.light_of_geom = job->light_of_geom;
    return RT_OK;
}

static rt_status make_image(rt_job *job)
{
    const rt_render_desc *d = &job->frame.set.desc;
    rt_status status;
    if (d->pixels)
        status = rti_image_wrap(job->ctx, d->crop.width, d->crop.height, d->pixels, d->pixels_stride, d->workers, &job->image);
    else
        status = rti_image_make(job->ctx, d->crop.width, d->crop.height, d->workers, job->frame.set.unseen, &job->image);
    job->frame.image = job->image;
    return status;
}

static rt_status make_workers(rt_job *job)
{
    const uint32_t n = job->frame.set.desc.workers;
    const size_t size = rti_worker_size(&job->frame);
    /* Tiles' and integrators' differ by some: renders that alternate would have all of it cleared each time. */
    const size_t most = job->frame.set.desc.memory_limit != 0 ? size : size + size / 2;
    job->workers = rti_alloc_zero(job->ctx, n * sizeof *job->workers);
    if (!job->workers)
        return rti_fail_memory(job->ctx, "the workers of a render", n * sizeof *job->workers);
    job->worker_count = n;
    for (uint32_t i = 0; i < n; i++) {
        bool used;
        job->workers[i].job = job;
        job->workers[i].role = job->workers[i].static_next = i;
        job->workers[i].held = size;
        job->workers[i].scratch = rti_kept_take(job->ctx, RTI_KEPT_WORK, &job->workers[i].held, most, &used);
        if (!job->workers[i].scratch)
            return rti_fail_memory(job->ctx, "the workers' rays", n * size);
    }
    job->finished = rti_alloc_array(job->ctx, job->frame.tile_count, sizeof *job->finished);
    if (!job->finished)
        return rti_fail_memory(job->ctx, "the list of tiles", job->frame.tile_count * sizeof *job->finished);
    job->running = n;
    return RT_OK;
}

static float default_ao_distance(const rti_snapshot *snapshot)
{
    rtk_vec3 lo, hi, d;
    rti_snapshot_bounds(snapshot, &lo, &hi);
    if (!(lo.x <= hi.x))
        return RTK_INF;
    d = rtk_sub(hi, lo);
    return 0.1f * rtk_len(d);
}

/* file: where a checkpoint that is gone on from is kept open; NULL: only planning. */
static rt_status plan(rt_job *job, const char *what, const rt_render_desc *desc, void (*tune)(rti_settings *settings),
                      rti_check_file *file)
{
    rti_frame *f = &job->frame;
    const rtk_scene *scene = rti_snapshot_view(job->snapshot);
    uint32_t geoms = has_bodies(scene) ? scene->groups[0].geom_count : 0;
    rt_status status = rti_settings_take(job->ctx, what, job->snapshot, desc, &f->set);
    if (status != RT_OK)
        return status;
    if (tune)
        tune(&f->set);
    if (file && f->set.desc.checkpoint)
        status = rti_keeper_make(job, what, &f->set.desc, file);
    if (status != RT_OK)
        return status;
    f->cancel = &job->cancel;
    f->ao_distance = f->set.desc.ao_distance > 0.0f ? f->set.desc.ao_distance : default_ao_distance(job->snapshot);
    do {
        f->thrifty = job->memory != 0; /* and does not fit */
        status = rti_frame_plan(job->ctx, what, f, scene);
        if (status != RT_OK)
            return status;
        job->memory = memory_of(f, geoms);
    } while (!f->thrifty && !within_limits(job->ctx, f, job->memory));
    f->set.desc.checkpoint = NULL; /* the caller's string is not kept */
    job->mode = (f->set.desc.workers == 1 && !f->set.desc.background) || rti_context_has_tasks(job->ctx) ? RTI_JOB_DRIVEN
                                                                                                         : RTI_JOB_THREADS;
    return RT_OK;
}

static void init_sync(rt_job *job)
{
    pthread_condattr_t attr;
    pthread_condattr_init(&attr);
    pthread_condattr_setclock(&attr, CLOCK_MONOTONIC);
    pthread_mutex_init(&job->lock, NULL);
    pthread_cond_init(&job->news, &attr);
    pthread_condattr_destroy(&attr);
}

rt_status rti_job_snapshot(const rt_scene *scene, const char *what, rti_snapshot **snapshot)
{
    *snapshot = rti_scene_snapshot(scene);
    if (!*snapshot)
        return rti_fail(rt_scene_context(scene), RT_ERROR_STATE, "%s: the scene was never committed; call rt_scene_commit first",
                        what);
    return RT_OK;
}

rt_status rti_job_create(rt_context *ctx, rti_snapshot *snapshot, const char *what, const rt_render_desc *desc,
                         void (*tune)(rti_settings *settings), rt_job **job)
{
    rt_job *made = rti_alloc_zero(ctx, sizeof *made);
    rti_check_file file = {0};
    rti_fpenv env;
    rt_status status;
    *job = NULL;
    if (!made)
        return rti_fail_memory(ctx, what, sizeof *made);
    env = rti_fp_enter();
    rti_snapshot_retain(snapshot);
    made->ctx = ctx;
    made->snapshot = snapshot;
    made->started = rti_now();
    init_sync(made);
    status = plan(made, what, desc, tune, &file);
    if (status == RT_OK)
        status = check_memory(ctx, what, &made->frame, made->memory);
    if (status == RT_OK)
        status = map_bodies(made, made->frame.scene);
    if (status == RT_OK)
        status = make_image(made);
    if (status == RT_OK)
        status = make_workers(made);
    if (status == RT_OK && made->worker_count == 1)
        rti_job_make_worker(&made->workers[0]);
    if (status == RT_OK && made->keeper)
        status = rti_keeper_load(made, &file);
    rti_check_close(&file);
    rti_fp_leave(env);
    if (status != RT_OK) {
        rt_job_destroy(made);
        return status;
    }
    *job = made;
    return RT_OK;
}

rt_status rti_job_run(rt_job *job)
{
    if (job->mode == RTI_JOB_DRIVEN)
        return RT_OK;
    return rti_threads_start(job->ctx, job->worker_count, rti_job_thread, job, &job->threads);
}

rt_status rt_job_start(rt_scene *scene, const rt_render_desc *desc, rt_job **job)
{
    RTI_NEED_TO_MAKE(job, scene);
    static const char what[] = "rt_job_start";
    rt_context *ctx = rt_scene_context(scene);
    rti_snapshot *snapshot;
    rt_status status;
    if (!job)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: job is NULL; it receives the new job", what);
    *job = NULL;
    status = rti_job_snapshot(scene, what, &snapshot);
    if (status != RT_OK)
        return status;
    status = rti_job_create(ctx, snapshot, what, desc, NULL, job);
    rti_snapshot_release(snapshot);
    if (status == RT_OK && (status = rti_job_run(*job)) != RT_OK) {
        rt_job_destroy(*job);
        *job = NULL;
    }
    return status;
}

uint64_t rt_render_memory(rt_scene *scene, const rt_render_desc *desc)
{
    static const char what[] = "rt_render_memory";
    rt_job planned = {0};
    rt_status status = rti_job_snapshot(scene, what, &planned.snapshot);
    if (status != RT_OK)
        return 0;
    planned.ctx = rt_scene_context(scene);
    status = plan(&planned, what, desc, NULL, NULL);
    rti_snapshot_release(planned.snapshot);
    return status == RT_OK ? planned.memory : 0;
}

void rt_job_destroy(rt_job *job)
{
    if (!job)
        return;
    rt_job_cancel(job);
    rti_threads_join(job->ctx, job->threads);
    rt_image_destroy(job->image);
    rti_keeper_free(job);
    rti_free(job->ctx, job->finished, job->frame.tile_count * sizeof *job->finished);
    for (uint32_t i = 0; i < job->worker_count; i++)
        rti_kept_give(job->ctx, RTI_KEPT_WORK, job->workers[i].scratch, job->workers[i].held);
    rti_free(job->ctx, job->workers, job->worker_count * sizeof *job->workers);
    rti_free(job->ctx, job->light_of_geom, job->geom_count * sizeof *job->light_of_geom);
    rti_snapshot_release(job->snapshot);
    pthread_mutex_destroy(&job->lock);
    pthread_cond_destroy(&job->news);
    rti_free(job->ctx, job, sizeof *job);
}
