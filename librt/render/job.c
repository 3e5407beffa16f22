/* Jobs as their owner sees them: waiting, tiles, the image, statistics. */
#include <time.h>

#include "job.h"

#define POLL_SECONDS  0.02 /* of work inside rt_job_poll */
#define SLICE_SECONDS 0.05 /* of work between two looks at the clock and at finished tiles, inside rt_job_wait */

void rt_job_on_tile(rt_job *job, rt_tile_fn fn, void *user)
{
    pthread_mutex_lock(&job->lock);
    job->on_tile = fn;
    job->on_tile_user = user;
    pthread_mutex_unlock(&job->lock);
}

void rt_job_cancel(rt_job *job)
{
    rti_keeper *k = job->keeper;
    if (k && atomic_load(&k->flying)) /* the workers work their rays down first */
        atomic_store(&k->stop, true);
    else
        atomic_store_explicit(&job->cancel.asked, true, memory_order_relaxed);
}

static rt_job_state state_of(rt_job *job)
{
    rt_job_state state;
    pthread_mutex_lock(&job->lock);
    state = job->state;
    pthread_mutex_unlock(&job->lock);
    return state;
}

/* The state, with the reason of a failure as the calling thread's message. */
static rt_job_state report(rt_job *job)
{
    rt_job_state state = state_of(job);
    if (state == RT_JOB_FAILED)
        rti_fail(job->ctx, job->status, "%s", job->message);
    return state;
}

static float progress_of(rt_job *job)
{
    const rt_tile *crop = &job->frame.set.desc.crop;
    uint64_t done = atomic_load_explicit(&job->pixels_done, memory_order_relaxed);
    return (float)((double)done / ((double)crop->width * crop->height));
}

rt_job_state rt_job_poll(rt_job *job, float *progress)
{
    if (job->mode == RTI_JOB_DRIVEN && state_of(job) == RT_JOB_RUNNING)
        rti_job_drive(job, POLL_SECONDS);
    rt_job_state state = report(job); /* first: tiles that finish meanwhile may count, but DONE never comes with less than all */
    if (progress)
        *progress = progress_of(job);
    return state;
}

/* The tile behind *cursor in the order of finishing, if there is one. */
static bool next_finished(rt_job *job, uint32_t *cursor, rt_tile *tile)
{
    bool found;
    pthread_mutex_lock(&job->lock);
    found = *cursor < job->finished_count;
    if (found)
        *tile = rti_frame_tile(&job->frame, job->finished[(*cursor)++]);
    pthread_mutex_unlock(&job->lock);
    return found;
}

int rt_job_next_tile(rt_job *job, rt_tile *tile)
{
    return next_finished(job, &job->taken, tile);
}

/* Without a callback the tiles stay untold: one that is set later hears of them all. */
static void tell(rt_job *job)
{
    rt_tile tile;
    while (job->on_tile && next_finished(job, &job->told, &tile)) {
        if (job->on_tile(job->on_tile_user, &tile, job->image))
            rt_job_cancel(job);
    }
}

/* Sleeps until there is news or `deadline` (by rti_now; < 0: none). */
static void sleep_for_news(rt_job *job, double deadline)
{
    struct timespec t;
    pthread_mutex_lock(&job->lock);
    while (job->state == RT_JOB_RUNNING && !(job->on_tile && job->told < job->finished_count)) {
        if (deadline < 0) {
            pthread_cond_wait(&job->news, &job->lock);
            continue;
        }
        t.tv_sec = (time_t)deadline;
        t.tv_nsec = (long)((deadline - (double)t.tv_sec) * 1e9);
        if (pthread_cond_timedwait(&job->news, &job->lock, &t) != 0)
            break;
    }
    pthread_mutex_unlock(&job->lock);
}

rt_job_state rt_job_wait(rt_job *job, double seconds)
{
    double now = rti_now(), deadline = seconds < 0 || seconds > 1e9 ? -1 : now + seconds;
    while (state_of(job) == RT_JOB_RUNNING && (deadline < 0 || now < deadline)) {
        tell(job);
        if (job->mode == RTI_JOB_DRIVEN)
            rti_job_drive(job, deadline >= 0 && deadline - now < SLICE_SECONDS ? deadline - now : SLICE_SECONDS);
        else
            sleep_for_news(job, deadline);
        now = rti_now();
    }
    tell(job);
    return report(job);
}

const rt_image *rt_job_image(rt_job *job)
{
    return job->image;
}

rt_image *rt_job_take_image(rt_job *job)
{
    rt_image *image = job->image;
    if (state_of(job) == RT_JOB_RUNNING)
        return NULL;
    job->image = NULL;
    return image;
}

rt_status rt_job_status(const rt_job *job)
{
    RTI_NEED(job);
    rt_job *j = (rt_job *)(uintptr_t)job; /* the lock is not part of what const promises */
    rt_status status = RT_OK;
    pthread_mutex_lock(&j->lock);
    if (j->state == RT_JOB_FAILED)
        status = j->status;
    else if (j->state == RT_JOB_CANCELLED)
        status = RT_ERROR_CANCELLED;
    pthread_mutex_unlock(&j->lock);
    return status;
}

void rt_job_stats(rt_job *job, rt_render_stats *stats)
{
    rt_render_stats s = {0};
    pthread_mutex_lock(&job->lock);
    for (uint32_t i = 0; i < job->worker_count; i++) {
        const rti_job_share *w = &job->workers[i].share;
        s.rays_camera += w->counts.rays[RTK_KIND_CAMERA];
        s.rays_shadow += w->counts.rays[RTK_KIND_SHADOW];
        s.rays_reflect += w->counts.rays[RTK_KIND_REFLECT];
        s.rays_refract += w->counts.rays[RTK_KIND_REFRACT];
        s.rays_diffuse += w->counts.rays[RTK_KIND_DIFFUSE];
        s.rays_ao += w->counts.rays[RTK_KIND_AO];
        s.nodes += w->trace.nodes;
        s.tests += w->trace.tests;
        s.clamped += w->counts.clamped;
        s.dropped += w->counts.dropped;
    }
    if (job->keeper) {
        const rti_check_counts *b = &job->keeper->base;
        s.rays_camera += b->rays[RTK_KIND_CAMERA];
        s.rays_shadow += b->rays[RTK_KIND_SHADOW];
        s.rays_reflect += b->rays[RTK_KIND_REFLECT];
        s.rays_refract += b->rays[RTK_KIND_REFRACT];
        s.rays_diffuse += b->rays[RTK_KIND_DIFFUSE];
        s.rays_ao += b->rays[RTK_KIND_AO];
        s.nodes += b->nodes;
        s.tests += b->tests;
        s.clamped += b->clamped;
        s.dropped += b->dropped;
    }
    s.seconds = (job->state == RT_JOB_RUNNING ? rti_now() : job->ended) - job->started;
    s.seconds += job->keeper ? job->keeper->base.seconds : 0;
    s.build_seconds = job->build_seconds;
    s.memory = job->memory;
    s.workers = job->worker_count;
    s.tiles = job->frame.tile_count;
    s.tiles_done = job->finished_count;
    pthread_mutex_unlock(&job->lock);
    *stats = s;
}

void rt_job_checkpoint_stats(rt_job *job, rt_checkpoint_stats *stats)
{
    rt_checkpoint_stats none = {0};
    pthread_mutex_lock(&job->lock);
    *stats = job->keeper ? job->keeper->stats : none;
    pthread_mutex_unlock(&job->lock);
}

static bool has_touched(const rt_job *job, uint32_t material)
{
    const rtk_material *m = &job->frame.scene->materials[material];
    bool all = job->keeper && (job->keeper->stats.tiles_resumed || job->keeper->stats.tiles_begun);
    bool found = all || job->state == RT_JOB_RUNNING || m->alpha_tex != RTK_INVALID;
    for (uint32_t i = 0; i < job->worker_count && !found; i++)
        found = job->workers[i].begun && job->workers[i].wave.touched[material / 32] >> material % 32 & 1u;
    return found;
}

uint32_t rt_job_touched_materials(rt_job *job, uint8_t *touched, uint32_t capacity)
{
    uint32_t count;
    pthread_mutex_lock(&job->lock);
    count = job->frame.scene->material_count;
    for (uint32_t i = 0; i < count && i < capacity; i++)
        touched[i] = has_touched(job, i);
    pthread_mutex_unlock(&job->lock);
    return count;
}

uint32_t rt_job_worker_stats(rt_job *job, rt_worker_stats *stats, uint32_t capacity)
{
    pthread_mutex_lock(&job->lock);
    for (uint32_t i = 0; i < job->worker_count && i < capacity; i++) {
        const rti_job_share *w = &job->workers[i].share;
        stats[i].busy_seconds = w->busy_seconds;
        stats[i].cpu_seconds = w->cpu_seconds;
        stats[i].rays = 0;
        for (uint32_t k = 0; k < RTK_KIND_COUNT; k++)
            stats[i].rays += w->counts.rays[k];
        stats[i].tiles = w->counts.tiles;
    }
    pthread_mutex_unlock(&job->lock);
    return job->worker_count;
}
