/* The context's threads. A parallel loop is a record on its caller's stack, listed in the pool while it may have indices left;
 * the caller takes indices like everyone else, so a loop inside a loop cannot deadlock: whoever waits has no index of its own
 * left to run. The lock is for coming to a loop and leaving it; indices are taken without.
 *
 * Waking a thread takes longer than many a loop of a builder, which has thirty of them in a row: so who has nothing to do looks
 * out for a while before it sleeps. */
#include <signal.h>
#include <string.h>

#if defined(__x86_64__) || defined(__i386__)
#include <xmmintrin.h>
#endif

#include "context.h"

typedef struct loop {
    struct loop *next, *prev;
    void (*task)(void *data, uint32_t index);
    void *data;
    uint32_t count;
    atomic_uint taken; /* indices; more than count when all are */
    atomic_uint users; /* threads of the pool that are in it; set under the lock */
    bool listed;       /* under the lock */
} loop;

struct rti_pool {
    pthread_mutex_t lock;
    pthread_cond_t work; /* a loop was listed, or the end is near */
    pthread_cond_t done; /* some loop's last user has left it */
    loop *first;
    bool ending;
    atomic_uint listed; /* loops, so far; is added to under the lock */
    uint32_t thread_count, capacity;
    uint32_t patience; /* how often a thread looks before it sleeps */
    pthread_t threads[];
};

/* Signals are for the host's own threads: a handler that is run by a thread that the host does not know races with what it looks
 * at. Left alone are those that a thread sends itself by what it does, and a profiler's. A thread inherits its starter's mask. */
static void hold_signals(sigset_t *before)
{
    static const int left[] = {SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGPIPE, SIGPROF, SIGSEGV, SIGSYS, SIGTRAP, SIGXFSZ};
    sigset_t held;
    sigfillset(&held);
    for (size_t i = 0; i < sizeof left / sizeof left[0]; i++)
        sigdelset(&held, left[i]);
    pthread_sigmask(SIG_BLOCK, &held, before);
}

#define PATIENCE 1000u /* 15 to 50 microseconds */

static inline void breathe(void)
{
#if defined(__x86_64__) || defined(__i386__)
    _mm_pause();
#elif defined(__aarch64__)
    __asm__ volatile("yield");
#endif
}

/* Many threads come at once, and each has the lock for less time than it takes to sleep. */
static void lock_soon(rti_pool *pool)
{
    for (uint32_t i = 0; i < pool->patience / 8; i++) {
        if (pthread_mutex_trylock(&pool->lock) == 0)
            return;
        breathe();
    }
    pthread_mutex_lock(&pool->lock);
}

/* Waits a while, without the lock, which is held before and after, for *number to be `wanted`, or to be another. */
static void look_out(rti_pool *pool, atomic_uint *number, uint32_t wanted, bool other)
{
    pthread_mutex_unlock(&pool->lock);
    for (uint32_t i = 0; i < pool->patience && (atomic_load_explicit(number, memory_order_relaxed) == wanted) == other; i++)
        breathe();
    lock_soon(pool);
}

static void unlist(rti_pool *pool, loop *l)
{
    if (!l->listed)
        return;
    l->listed = false;
    if (l->prev)
        l->prev->next = l->next;
    else
        pool->first = l->next;
    if (l->next)
        l->next->prev = l->prev;
}

/* Runs indices of l while there are any; the lock is held before and after. */
static void run_some(rti_pool *pool, loop *l)
{
    uint32_t index;
    pthread_mutex_unlock(&pool->lock);
    while ((index = atomic_fetch_add_explicit(&l->taken, 1, memory_order_relaxed)) < l->count)
        l->task(l->data, index);
    lock_soon(pool);
    unlist(pool, l);
}

/* Takes part in l as long as it has indices; l may be gone then. */
static void join_in(rti_pool *pool, loop *l)
{
    atomic_fetch_add(&l->users, 1);
    run_some(pool, l);
    if (atomic_fetch_sub(&l->users, 1) == 1)
        pthread_cond_broadcast(&pool->done);
}

static void *pool_thread(void *arg)
{
    rti_pool *pool = arg;
    rti_fp_enter();
    pthread_mutex_lock(&pool->lock);
    while (pool->first || !pool->ending) {
        uint32_t seen = atomic_load(&pool->listed);
        if (pool->first) {
            if (atomic_load_explicit(&pool->first->taken, memory_order_relaxed) < pool->first->count)
                join_in(pool, pool->first);
            else
                unlist(pool, pool->first);
            continue;
        }
        look_out(pool, &pool->listed, seen, true);
        if (atomic_load(&pool->listed) == seen && !pool->ending)
            pthread_cond_wait(&pool->work, &pool->lock);
    }
    pthread_mutex_unlock(&pool->lock);
    return NULL;
}

static rti_pool *pool_create(rt_context *ctx)
{
    uint32_t capacity = ctx->workers - 1;
    rti_pool *pool = rti_alloc_zero(ctx, sizeof *pool + capacity * sizeof(pthread_t));
    if (!pool)
        return NULL;
    pool->capacity = capacity;
    pool->patience =
        ctx->workers <= rt_cpu_count() ? PATIENCE : 0; /* else it would look out on a CPU that another thread wants */
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->work, NULL);
    pthread_cond_init(&pool->done, NULL);
    sigset_t before;
    hold_signals(&before);
    while (pool->thread_count < capacity && pthread_create(&pool->threads[pool->thread_count], NULL, pool_thread, pool) == 0)
        pool->thread_count++;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    if (pool->thread_count < capacity)
        rti_log(ctx, RT_LOG_WARNING, "the system gave %u of %u worker threads; going on with those", pool->thread_count,
                capacity);
    return pool;
}

void rti_pool_destroy(rt_context *ctx, rti_pool *pool)
{
    if (!pool)
        return;
    pthread_mutex_lock(&pool->lock);
    pool->ending = true;
    pthread_cond_broadcast(&pool->work);
    pthread_mutex_unlock(&pool->lock);
    for (uint32_t i = 0; i < pool->thread_count; i++)
        pthread_join(pool->threads[i], NULL);
    pthread_mutex_destroy(&pool->lock);
    pthread_cond_destroy(&pool->work);
    pthread_cond_destroy(&pool->done);
    rti_free(ctx, pool, sizeof *pool + pool->capacity * sizeof(pthread_t));
}

/* NULL when there is no memory for it: loops then run on their caller alone. */
static rti_pool *get_pool(rt_context *ctx)
{
    rti_pool *pool;
    pthread_mutex_lock(&ctx->pool_lock);
    if (!ctx->pool)
        ctx->pool = pool_create(ctx);
    pool = ctx->pool;
    pthread_mutex_unlock(&ctx->pool_lock);
    return pool;
}

typedef struct host_loop {
    void (*task)(void *data, uint32_t index);
    void *data;
} host_loop;

static void host_task(void *data, uint32_t index)
{
    host_loop *h = data;
    rti_fpenv env = rti_fp_enter();
    h->task(h->data, index);
    rti_fp_leave(env);
}

void rti_parallel(rt_context *ctx, uint32_t count, void (*task)(void *data, uint32_t index), void *data)
{
    rti_pool *pool = NULL;
    if (count == 0)
        return;
    if (ctx->parallel && count > 1) {
        host_loop h = {task, data};
        ctx->parallel(ctx->parallel_user, count, host_task, &h);
        return;
    }
    if (!ctx->parallel && ctx->workers > 1 && count > 1)
        pool = get_pool(ctx);
    if (!pool || pool->thread_count == 0) {
        for (uint32_t i = 0; i < count; i++)
            task(data, i);
        return;
    }
    loop l = {.task = task, .data = data, .count = count, .listed = true};
    lock_soon(pool);
    l.next = pool->first; /* the youngest first: inner loops free their waiters */
    if (l.next)
        l.next->prev = &l;
    pool->first = &l;
    atomic_fetch_add(&pool->listed, 1);
    pthread_cond_broadcast(&pool->work);
    run_some(pool, &l);
    if (atomic_load(&l.users) > 0)
        look_out(pool, &l.users, 0, false);
    while (atomic_load(&l.users) > 0)
        pthread_cond_wait(&pool->done, &pool->lock);
    pthread_mutex_unlock(&pool->lock);
}

rt_status rti_pool_start(rt_context *ctx)
{
    rti_pool *pool;
    if (ctx->parallel || ctx->workers <= 1)
        return RT_OK;
    pool = get_pool(ctx);
    if (!pool)
        return rti_fail_memory(ctx, "worker threads", sizeof *pool + ctx->workers * sizeof(pthread_t));
    if (pool->thread_count == 0)
        return rti_fail(ctx, RT_ERROR_THREAD, "the system gave none of %u worker threads", ctx->workers - 1);
    return RT_OK;
}

/* ---- threads of a job ---- */

/* Starting a thread takes some 30 microseconds: each that is started starts FAN more. */
#define FAN 4u
typedef struct job_thread {
    rti_threads *threads;
    pthread_t thread;
    uint32_t index;
    bool there; /* written by the thread that starts it */
} job_thread;

struct rti_threads {
    rt_context *ctx;
    void (*run)(void *data, uint32_t index);
    void *data;
    uint32_t count;
    job_thread each[];
};

static void *job_thread_main(void *arg);

static bool start(rti_threads *t, uint32_t index)
{
    job_thread *j = &t->each[index];
    j->threads = t;
    j->index = index;
    j->there = pthread_create(&j->thread, NULL, job_thread_main, j) == 0;
    return j->there;
}

/* The FAN from `first` on, up to one that the system refuses. */
static void start_some(rti_threads *t, uint32_t first)
{
    for (uint32_t i = first; i < t->count && i < first + FAN; i++) {
        if (start(t, i))
            continue;
        if (i > 0)
            rti_log(t->ctx, RT_LOG_WARNING, "the system gave fewer than the %u threads of a job; going on with those", t->count);
        return;
    }
}

static void *job_thread_main(void *arg)
{
    job_thread *j = arg;
    rti_threads *t = j->threads;
    rti_fp_enter();
    start_some(t, FAN * (j->index + 1));
    t->run(t->data, j->index);
    return NULL;
}

rt_status rti_threads_start(rt_context *ctx, uint32_t count, void (*run)(void *data, uint32_t index), void *data,
                            rti_threads **threads)
{
    size_t size = sizeof(rti_threads) + (size_t)count * sizeof(job_thread);
    rti_threads *t = rti_alloc_zero(ctx, size);
    if (!t)
        return rti_fail_memory(ctx, "threads of a job", size);
    t->ctx = ctx;
    t->run = run;
    t->data = data;
    t->count = count;
    sigset_t before;
    hold_signals(&before);
    start_some(t, 0);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    if (!t->each[0].there) {
        rti_free(ctx, t, size);
        return rti_fail(ctx, RT_ERROR_THREAD, "the system gave none of %u threads for a job; fewer workers may do", count);
    }
    *threads = t;
    return RT_OK;
}

/* A thread is joined after the one that started it, and so knows whether it is there. */
void rti_threads_join(rt_context *ctx, rti_threads *threads)
{
    if (!threads)
        return;
    for (uint32_t i = 0; i < threads->count; i++) {
        if (threads->each[i].there)
            pthread_join(threads->each[i].thread, NULL);
    }
    rti_free(ctx, threads, sizeof *threads + (size_t)threads->count * sizeof(job_thread));
}
