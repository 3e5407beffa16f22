/* The computing side of a job. */
#include <string.h>

#include "job.h"

#define TELL_SECONDS 0.001 /* of work between two looks at the lock */

/* ---- what a worker asks of the job ---- */

static uint32_t next_tile(void *owner)
{
    rti_job_worker *w = owner;
    rt_job *job = w->job;
    uint32_t index;
    do {
        if (job->frame.set.desc.schedule == RT_SCHEDULE_STATIC) {
            index = w->static_next;
            w->static_next += index < job->frame.tile_count ? job->worker_count : 0;
        } else {
            index = atomic_fetch_add_explicit(&job->next_tile, 1, memory_order_relaxed);
        }
    } while (job->keeper && index < job->frame.tile_count && job->keeper->resumed[index]);
    return index < job->frame.tile_count ? index : RTK_INVALID;
}

/* The lock is held. */
void rti_job_renew_share(rti_job_worker *w)
{
    w->share.counts = w->wave.counts;
    w->share.trace = w->wave.scratch.stats;
    w->share.busy_seconds = w->busy_seconds + (rti_now() - w->slice_start);
    w->share.cpu_seconds = w->cpu_seconds + (rti_thread_cpu() - w->slice_cpu);
}

/* Many workers with small tiles would wait for each other at the lock: tiles are told of a few at a time. */
static void tell_tiles(rti_job_worker *w)
{
    rt_job *job = w->job;
    if (w->untold_count == 0)
        return;
    pthread_mutex_lock(&job->lock);
    for (uint32_t i = 0; i < w->untold_count; i++) {
        rt_tile t = rti_frame_tile(&job->frame, w->untold[i]);
        atomic_fetch_add_explicit(&job->pixels_done, (uint64_t)t.width * t.height, memory_order_relaxed);
        if (job->keeper)
            job->keeper->finished_by[job->finished_count] = w->role;
        job->finished[job->finished_count++] = w->untold[i];
    }
    w->untold_count = 0;
    rti_job_renew_share(w);
    if (job->on_tile)
        pthread_cond_broadcast(&job->news);
    pthread_mutex_unlock(&job->lock);
}

static void tile_done(void *owner, uint32_t index)
{
    rti_job_worker *w = owner;
    w->untold[w->untold_count++] = index;
    if (w->job->keeper || w->untold_count == RTI_UNTOLD) /* a keeper knows of each at once */
        tell_tiles(w);
}

void rti_job_make_worker(rti_job_worker *w)
{
    rti_worker_init(&w->wave, &w->job->frame, w->scratch);
    w->wave.next_tile = next_tile;
    w->wave.tile_done = tile_done;
    w->wave.owner = w;
    w->wave.restore = w->job->keeper ? rti_keeper_restore : NULL;
    w->made = true;
}

/* ---- the tree ---- */

static void fail(rt_job *job, rt_status status)
{
    job->status = status;
    rt_context_error(job->ctx, job->message, sizeof job->message);
    atomic_store_explicit(&job->cancel.asked, true, memory_order_relaxed);
}

/* The tree that the tracer walks; the first worker here builds what is missing, the others wait. */
static bool prepare(rt_job *job)
{
    rti_snapshot *with = NULL;
    rt_status status;
    double start;
    bool ready;
    pthread_mutex_lock(&job->lock);
    while (job->preparing)
        pthread_cond_wait(&job->news, &job->lock);
    ready = job->ready;
    if (ready || rti_cancelled(&job->cancel)) {
        pthread_mutex_unlock(&job->lock);
        return ready;
    }
    job->preparing = true;
    pthread_mutex_unlock(&job->lock);
    start = rti_now();
    status = rti_snapshot_with_tree(job->snapshot, "rt_render", job->frame.set.tracer->tree, &job->cancel, &with);
    pthread_mutex_lock(&job->lock);
    job->preparing = false;
    job->build_seconds = rti_now() - start;
    if (status == RT_OK) {
        rti_snapshot_release(job->snapshot);
        job->snapshot = with;
        job->frame.scene = rti_snapshot_view(with);
        job->ready = true;
    } else if (status != RT_ERROR_CANCELLED) {
        fail(job, status);
    }
    pthread_cond_broadcast(&job->news);
    pthread_mutex_unlock(&job->lock);
    return status == RT_OK;
}

/* ---- the work ---- */

static void end_worker(rti_job_worker *w)
{
    rt_job *job = w->job;
    bool last;
    if (job->keeper)
        rti_keeper_worker_ends(w);
    pthread_mutex_lock(&job->lock);
    rti_job_renew_share(w);
    w->done = true;
    last = --job->running == 0;
    pthread_mutex_unlock(&job->lock);
    if (last && job->keeper && job->status == RT_OK)
        rti_keeper_job_ends(job, job->finished_count == job->frame.tile_count ? RT_JOB_DONE : RT_JOB_CANCELLED);
    pthread_mutex_lock(&job->lock);
    if (last) {
        job->ended = rti_now();
        if (job->status != RT_OK)
            job->state = RT_JOB_FAILED;
        else
            job->state = job->finished_count == job->frame.tile_count ? RT_JOB_DONE : RT_JOB_CANCELLED;
        pthread_cond_broadcast(&job->news);
    }
    pthread_mutex_unlock(&job->lock);
}

/* Returns whether the job still wants its work. */
static bool begin_worker(rti_job_worker *w)
{
    rti_keeper *k = w->job->keeper;
    if (!w->made)
        rti_job_make_worker(w);
    pthread_mutex_lock(&w->job->lock);
    w->begun = true;
    if (k) {
        w->epoch = atomic_load(&k->epoch);
        atomic_store(&k->flying, true);
    }
    pthread_mutex_unlock(&w->job->lock);
    return !k || !atomic_load(&k->stop);
}

void rti_job_work(rt_job *job, uint32_t role, double until)
{
    rti_job_worker *w = &job->workers[role];
    bool more = prepare(job);
    rti_fpenv env = rti_fp_enter();
    w->slice_start = rti_now();
    w->slice_cpu = rti_thread_cpu();
    if (more && !w->begun)
        more = begin_worker(w);
    for (double now, told = w->slice_start; more;) {
        more = rti_worker_step(&w->wave);
        if (job->keeper)
            more = rti_keeper_tend(w, more);
        now = rti_now();
        if (until >= 0 && now >= until)
            break;
        if (now - told >= TELL_SECONDS) {
            tell_tiles(w);
            told = now;
        }
    }
    tell_tiles(w);
    rti_fp_leave(env);
    if (!more) {
        end_worker(w);
        return;
    }
    w->busy_seconds += rti_now() - w->slice_start;
    w->cpu_seconds += rti_thread_cpu() - w->slice_cpu;
}

/* A thread takes the part of one worker after the other: where the system gave fewer threads than asked, all parts are played. */
void rti_job_thread(void *data, uint32_t index)
{
    rt_job *job = data;
    (void)index;
    for (;;) {
        uint32_t role = atomic_fetch_add_explicit(&job->next_role, 1, memory_order_relaxed);
        if (role >= job->worker_count)
            return;
        rti_job_work(job, role, -1);
    }
}

typedef struct slice {
    rt_job *job;
    double until;
} slice;

static void drive_one(void *data, uint32_t index)
{
    slice *s = data;
    if (!s->job->workers[index].done)
        rti_job_work(s->job, index, s->until);
}

void rti_job_drive(rt_job *job, double seconds)
{
    slice s = {job, rti_now() + seconds};
    rti_parallel(job->ctx, job->worker_count, drive_one, &s);
}

/* The tree comes first: its builders are the threads that the workers are. */
bool rti_job_run_here(rt_job *job)
{
    if (job->mode != RTI_JOB_THREADS || job->keeper || job->worker_count > rt_context_workers(job->ctx))
        return false;
    prepare(job);
    rti_parallel(job->ctx, job->worker_count, rti_job_thread, job);
    return true;
}
