/* A job that keeps what is done in a file: when, by whom, and what then stands in it (checkpoint.h tells why it is exact). */
#include <string.h>

#include "../kernel/film.h"
#include "job.h"

#define EVERY_DEFAULT 60.0
#define COST_SHARE    100.0 /* an interval is at least so many times what the workers' share of writing took */
#define STOP_SECONDS  0.25  /* after which a worker that is to stop leaves its rays */

/* ---- memory ---- */

static size_t film_bytes(const rti_frame *f)
{
    uint32_t edge = f->set.desc.tile;
    uint64_t w = edge < f->set.desc.crop.width ? edge : f->set.desc.crop.width;
    uint64_t h = edge < f->set.desc.crop.height ? edge : f->set.desc.crop.height;
    return (size_t)(w * h * RTK_FILM_CHANNELS * sizeof(uint64_t));
}

uint64_t rti_keeper_bytes(const rti_frame *frame)
{
    uint64_t worker = film_bytes(frame) + sizeof(uint64_t *) + 2 * sizeof(rti_check_partial) + sizeof(rti_job_share);
    return sizeof(rti_keeper) + worker * frame->set.desc.workers + (uint64_t)frame->tile_count * (2 + 2 * sizeof(uint32_t));
}

static void *array(rt_context *ctx, rt_status *status, size_t count, size_t size)
{
    void *block = *status == RT_OK ? rti_alloc_array(ctx, count ? count : 1, size) : NULL;
    if (block)
        memset(block, 0, (count ? count : 1) * size);
    else if (*status == RT_OK)
        *status = rti_fail_memory(ctx, "a checkpoint", count * size);
    return block;
}

static void give_back(rt_context *ctx, void *block, size_t count, size_t size)
{
    rti_free(ctx, block, (count ? count : 1) * size);
}

static rt_status make_arrays(rt_job *job, uint32_t begun)
{
    rti_keeper *k = job->keeper;
    rt_status status = RT_OK;
    k->tile_count = job->frame.tile_count;
    k->worker_count = job->worker_count;
    k->begun_count = begun;
    k->film_size = film_bytes(&job->frame);
    k->begun = array(job->ctx, &status, begun, sizeof *k->begun);
    k->resumed = array(job->ctx, &status, k->tile_count, 1);
    k->settled = array(job->ctx, &status, k->tile_count, 1);
    k->finished_by = array(job->ctx, &status, k->tile_count, sizeof *k->finished_by);
    k->list = array(job->ctx, &status, k->tile_count, sizeof *k->list);
    k->deposits = array(job->ctx, &status, k->worker_count, sizeof *k->deposits);
    k->shares = array(job->ctx, &status, k->worker_count, sizeof *k->shares);
    k->partials = array(job->ctx, &status, (size_t)k->worker_count + begun, sizeof *k->partials);
    k->films = array(job->ctx, &status, k->worker_count, sizeof *k->films);
    for (uint32_t i = 0; i < k->worker_count && status == RT_OK; i++)
        k->films[i] = array(job->ctx, &status, 1, k->film_size);
    return status;
}

void rti_keeper_free(rt_job *job)
{
    rti_keeper *k = job->keeper;
    rt_context *ctx = job->ctx;
    if (!k)
        return;
    for (uint32_t i = 0; k->films && i < k->worker_count; i++)
        give_back(ctx, k->films[i], 1, k->film_size);
    if (k->begun)
        rti_check_free_partials(ctx, &job->frame, k->begun, k->begun_count);
    give_back(ctx, k->films, k->worker_count, sizeof *k->films);
    give_back(ctx, k->partials, (size_t)k->worker_count + k->begun_count, sizeof *k->partials);
    give_back(ctx, k->shares, k->worker_count, sizeof *k->shares);
    give_back(ctx, k->deposits, k->worker_count, sizeof *k->deposits);
    give_back(ctx, k->list, k->tile_count, sizeof *k->list);
    give_back(ctx, k->finished_by, k->tile_count, sizeof *k->finished_by);
    give_back(ctx, k->settled, k->tile_count, 1);
    give_back(ctx, k->resumed, k->tile_count, 1);
    give_back(ctx, k->begun, k->begun_count, sizeof *k->begun);
    rti_place_close(&k->place);
    rti_free(ctx, k, sizeof *k);
    job->keeper = NULL;
}

/* ---- beginning ---- */

rt_status rti_keeper_make(rt_job *job, const char *what, const rt_render_desc *desc, rti_check_file *file)
{
    rti_keeper *k = job->keeper = rti_alloc_zero(job->ctx, sizeof *k);
    rt_status status;
    if (!k)
        return rti_fail_memory(job->ctx, what, sizeof *k);
    status = rti_place_open(job->ctx, desc->checkpoint, &k->place);
    if (status != RT_OK)
        return status;
    k->every = desc->checkpoint_every > 0 ? desc->checkpoint_every : EVERY_DEFAULT;
    k->keep = desc->checkpoint_keep;
    atomic_init(&k->epoch, 0);
    atomic_init(&k->next_ms, (uint_fast64_t)(k->every * 1000));
    atomic_init(&k->flying, false);
    atomic_init(&k->stop, false);
    rti_check_key_of(&k->key, job->snapshot, &job->frame.set);
    if (!rti_place_there(&k->place))
        return RT_OK;
    status = rti_check_open(&k->place, &k->key, file);
    if (status == RT_OK)
        job->frame.set.desc.tile = file->head.tile;
    return status;
}

/* The file's tiles become the job's first finished ones. */
static void take_over(rt_job *job, const rti_check_head *head)
{
    rti_keeper *k = job->keeper;
    uint64_t pixels = 0;
    for (uint32_t i = 0; i < head->done_count; i++) {
        rt_tile t = rti_frame_tile(&job->frame, job->finished[i]);
        pixels += (uint64_t)t.width * t.height;
        k->resumed[job->finished[i]] = 1;
        k->settled[job->finished[i]] = 1;
        k->finished_by[i] = RTK_INVALID;
    }
    job->finished_count = head->done_count;
    atomic_store_explicit(&job->pixels_done, pixels, memory_order_relaxed);
    k->base = head->counts;
    k->stats.tiles_resumed = head->done_count;
    k->stats.tiles_begun = head->partial_count;
}

static rt_status write_now(rt_job *job);

rt_status rti_keeper_load(rt_job *job, rti_check_file *file)
{
    rti_keeper *k = job->keeper;
    uint32_t begun = file->reader && file->head.partial_count <= job->frame.tile_count ? file->head.partial_count : 0;
    rt_status status = make_arrays(job, begun);
    if (status == RT_OK && !file->reader) {
        status = write_now(job);
        atomic_store(&k->next_ms, (uint_fast64_t)(k->every * 1000)); /* what an empty file took says nothing */
    }
    if (status != RT_OK || !file->reader)
        return status;
    status = rti_check_load(file, &job->frame, job->finished, k->begun);
    if (status == RT_OK)
        take_over(job, &file->head);
    return status;
}

void rti_keeper_restore(void *owner, uint32_t index, uint64_t *film)
{
    rti_job_worker *w = owner;
    const rti_keeper *k = w->job->keeper;
    for (uint32_t i = 0; i < k->begun_count; i++) {
        const rti_check_partial *p = &k->begun[i];
        if (p->tile != index)
            continue;
        memcpy(film, p->film, rti_check_film_bytes(&w->job->frame, index));
        w->wave.group_x = p->group_x;
        w->wave.group_y = p->group_y;
        w->wave.sample = p->sample;
    }
}

/* ---- writing ---- */

static bool deposited(const rti_keeper *k, uint32_t tile)
{
    for (uint32_t i = 0; i < k->worker_count; i++) {
        if (k->deposits[i].film && k->deposits[i].tile == tile)
            return true;
    }
    return false;
}

/* What the file is to hold now. The lock is held, or there are no workers yet. */
static void collect(rt_job *job, rti_check_head *head)
{
    rti_keeper *k = job->keeper;
    memset(head, 0, sizeof *head);
    head->key = k->key;
    head->counts = k->base;
    head->counts.seconds += rti_now() - job->started;
    for (uint32_t i = 0; i < job->finished_count; i++) {
        if (k->settled[job->finished[i]])
            k->list[head->done_count++] = job->finished[i];
    }
    for (uint32_t i = 0; i < k->worker_count; i++) {
        const rti_job_share *s = &k->shares[i];
        if (k->deposits[i].film && !k->settled[k->deposits[i].tile])
            k->partials[head->partial_count++] = k->deposits[i];
        for (uint32_t kind = 0; kind < RTK_KIND_COUNT; kind++)
            head->counts.rays[kind] += s->counts.rays[kind];
        head->counts.nodes += s->trace.nodes;
        head->counts.tests += s->trace.tests;
        head->counts.clamped += s->counts.clamped;
        head->counts.dropped += s->counts.dropped;
    }
    for (uint32_t i = 0; i < k->begun_count; i++) { /* not gone on with yet */
        if (!k->settled[k->begun[i].tile] && !deposited(k, k->begun[i].tile))
            k->partials[head->partial_count++] = k->begun[i];
    }
}

/* k->writing is set by the caller: until it is taken back, what the writer reads stays as it is. */
static rt_status write_now(rt_job *job)
{
    rti_keeper *k = job->keeper;
    rti_check_head head;
    double begin = rti_now(), cost;
    rt_status status;
    pthread_mutex_lock(&job->lock);
    collect(job, &head);
    pthread_mutex_unlock(&job->lock);
    status = rti_check_write(&k->place, &job->frame, &head, k->list, k->partials);
    cost = rti_now() - begin;
    pthread_mutex_lock(&job->lock);
    k->stats.seconds += cost;
    k->stats.written += status == RT_OK;
    k->stats.failed += status != RT_OK;
    k->writing = false;
    cost = COST_SHARE * cost / k->worker_count;
    atomic_store(&k->next_ms, (uint_fast64_t)((rti_now() - job->started + (cost > k->every ? cost : k->every)) * 1000));
    pthread_cond_broadcast(&job->news);
    pthread_mutex_unlock(&job->lock);
    return status;
}

/* A render goes on when its checkpoint cannot be written: the next one may. */
static void write_or_warn(rt_job *job)
{
    char why[256];
    if (write_now(job) == RT_OK)
        return;
    rt_context_error(job->ctx, why, sizeof why);
    rti_log(job->ctx, RT_LOG_WARNING, "the checkpoint could not be written, the render goes on: %s", why);
}

/* ---- a worker's part ---- */

/* All tiles it has finished count from now on. The lock is held. */
static void settle(rti_job_worker *w)
{
    rt_job *job = w->job;
    rti_keeper *k = job->keeper;
    for (uint32_t i = 0; i < job->finished_count; i++) {
        if (k->finished_by[i] == w->role)
            k->settled[job->finished[i]] = 1;
    }
    rti_job_renew_share(w);
    k->shares[w->role] = w->share;
}

/* What it has begun; none of its rays is under way. The lock is held. */
static void deposit(rti_job_worker *w)
{
    rti_keeper *k = w->job->keeper;
    const rti_worker *wave = &w->wave;
    rti_check_partial *d = &k->deposits[w->role];
    d->film = NULL;
    if (wave->slot == RTK_INVALID || (wave->sample == 0 && wave->group_x == 0 && wave->group_y == 0))
        return;
    *d = (rti_check_partial){wave->slots[wave->slot].index, wave->group_x, wave->group_y, wave->sample, k->films[w->role]};
    memcpy(d->film, wave->film + ((size_t)wave->slot << w->job->frame.slot_shift) * RTK_FILM_CHANNELS,
           rti_check_film_bytes(&w->job->frame, d->tile));
}

/* Gives the worker's part; the last one of an epoch writes. whole: its rays are worked down. */
static void give_part(rti_job_worker *w, bool whole)
{
    rt_job *job = w->job;
    rti_keeper *k = job->keeper;
    bool last = false;
    pthread_mutex_lock(&job->lock);
    while (k->writing)
        pthread_cond_wait(&job->news, &job->lock);
    settle(w);
    if (whole)
        deposit(w);
    if (w->epoch != atomic_load(&k->epoch)) {
        w->epoch = atomic_load(&k->epoch);
        last = --k->waiting == 0;
        k->writing = last;
    }
    pthread_mutex_unlock(&job->lock);
    if (last)
        write_or_warn(job);
}

/* The first worker that sees the time has come asks all for their parts. */
static void begin_epoch(rt_job *job, uint64_t now_ms)
{
    rti_keeper *k = job->keeper;
    pthread_mutex_lock(&job->lock);
    if (!k->writing && k->waiting == 0 && now_ms >= atomic_load(&k->next_ms)) {
        for (uint32_t i = 0; i < job->worker_count; i++)
            k->waiting += job->workers[i].begun && !job->workers[i].done;
        atomic_store(&k->next_ms, UINT64_MAX);
        atomic_fetch_add(&k->epoch, 1);
    }
    pthread_mutex_unlock(&job->lock);
}

bool rti_keeper_tend(rti_job_worker *w, bool more)
{
    rt_job *job = w->job;
    rti_keeper *k = job->keeper;
    bool stop = atomic_load_explicit(&k->stop, memory_order_relaxed);
    double now = rti_now();
    uint64_t now_ms = (uint64_t)((now - job->started) * 1000);
    if (rti_cancelled(&job->cancel))
        return false;
    if (stop) {
        w->stop_since = w->stop_since > 0 ? w->stop_since : now;
        if (now - w->stop_since > STOP_SECONDS) { /* too many rays wait */
            atomic_store_explicit(&job->cancel.asked, true, memory_order_relaxed);
            return false;
        }
    } else if (now_ms >= atomic_load_explicit(&k->next_ms, memory_order_relaxed)) {
        begin_epoch(job, now_ms);
    }
    if (stop || w->epoch != atomic_load(&k->epoch)) {
        w->wave.hold = true;
        if (!more) {
            give_part(w, true);
            w->wave.hold = false;
            return !stop;
        }
    }
    return more;
}

void rti_keeper_worker_ends(rti_job_worker *w)
{
    if (w->begun)
        give_part(w, !rti_cancelled(&w->job->cancel));
}

void rti_keeper_job_ends(rt_job *job, rt_job_state state)
{
    rti_keeper *k = job->keeper;
    if (state == RT_JOB_DONE && !k->keep) {
        rti_place_remove(&k->place);
        return;
    }
    pthread_mutex_lock(&job->lock);
    k->writing = true;
    pthread_mutex_unlock(&job->lock);
    write_or_warn(job);
}
