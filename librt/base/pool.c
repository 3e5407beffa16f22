/* The context's threads. A parallel loop is one of the pool's records while it runs; the caller takes indices like everyone else,
 * so a loop inside a loop cannot deadlock: whoever waits has no index of its own left to run. Threads come, take indices and
 * leave by atomic operations alone; the lock is for sleep.
 *
 * Waking a thread takes longer than many a loop of a builder, which has thirty of them in a row: so who has nothing to do looks
 * out for a while before it sleeps. */
#include <signal.h>
#include <string.h>

#if defined(__x86_64__) || defined(__i386__)
#include <xmmintrin.h>
#endif

#include "context.h"

/* A record is never freed before its pool, and may be joined by a thread that comes too late: that finds it not OPEN and leaves.
 */
#define OPEN 0x80000000u
typedef struct loop {
    _Alignas(RTI_CACHE_LINE) atomic_uint users; /* threads of the pool that are in it, and OPEN while it may be joined */
    void (*task)(void *data, uint32_t index);
    void *data;
    uint32_t share_count; /* 1, or one a thread */
    struct share *shares;
} loop;

/* Indices that go to one thread as long as it has any, [next, end), and to others then. So in loops over the same things, one
 * after the other, most of them stay in one processor's caches. */
typedef struct share {
    _Alignas(RTI_CACHE_LINE) atomic_uint next; /* end or more when all are taken */
    uint32_t end;
} share;

#define LOOPS  64u /* at a time; more run on their callers alone */
#define SHARED 4u  /* indices a share, at least */

struct rti_pool {
    loop loops[LOOPS];
    _Alignas(RTI_CACHE_LINE) atomic_uint listed; /* loops, so far */
    atomic_uint_fast64_t open;                   /* which may have indices left */
    atomic_uint_fast64_t owned;                  /* which have a caller */
    atomic_uint sleepers, waiters;               /* threads without work, and callers, that are at the lock */
    pthread_mutex_t lock;
    pthread_cond_t work; /* a loop was listed, or the end is near */
    pthread_cond_t done; /* some loop's last user has left it */
    atomic_bool ending;
    uint32_t thread_count, capacity;
    uint32_t patience; /* how often a thread looks before it sleeps */
    share *shares;     /* capacity + 1 of each loop */
    struct pool_start {
        struct rti_pool *pool;
        uint32_t self;
        pthread_t thread;
    } threads[];
};

static _Thread_local uint32_t self; /* whose share comes first: 0 is a host's thread, others are of a pool */

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

/* Runs indices of l while there are any. */
static void run_some(rti_pool *pool, loop *l)
{
    const uint_fast64_t own = (uint_fast64_t)1 << (l - pool->loops);
    const uint32_t first = self % l->share_count;
    for (uint32_t k = 0; k < l->share_count; k++) {
        share *s = &l->shares[first + k < l->share_count ? first + k : first + k - l->share_count];
        uint32_t index;
        if (atomic_load_explicit(&s->next, memory_order_relaxed) >= s->end)
            continue;
        while ((index = atomic_fetch_add_explicit(&s->next, 1, memory_order_relaxed)) < s->end)
            l->task(l->data, index);
    }
    if (atomic_load_explicit(&pool->open, memory_order_relaxed) & own)
        atomic_fetch_and(&pool->open, ~own);
}

/* The last to leave wakes the caller: who counts himself as a waiter has looked for users after that, or is woken here. */
static void leave(rti_pool *pool, loop *l)
{
    if (atomic_fetch_sub(&l->users, 1) != 1 || atomic_load(&pool->waiters) == 0)
        return;
    pthread_mutex_lock(&pool->lock);
    pthread_cond_broadcast(&pool->done);
    pthread_mutex_unlock(&pool->lock);
}

/* Takes part in a loop, of several in what is the youngest, as a rule: inner loops free their waiters. false: there is none. */
static bool join_in(rti_pool *pool)
{
    uint64_t open = atomic_load(&pool->open);
    loop *l;
    if (open == 0)
        return false;
    l = &pool->loops[63 - __builtin_clzll(open)];
    if (atomic_fetch_add(&l->users, 1) & OPEN)
        run_some(pool, l);
    leave(pool, l);
    return true;
}

static void *pool_thread(void *arg)
{
    const struct pool_start *start = arg;
    rti_pool *pool = start->pool;
    self = start->self;
    rti_fp_enter();
    for (;;) {
        const uint32_t seen = atomic_load(&pool->listed);
        if (join_in(pool))
            continue;
        if (atomic_load(&pool->ending))
            return NULL;
        for (uint32_t i = 0; i < pool->patience && atomic_load_explicit(&pool->listed, memory_order_relaxed) == seen; i++)
            breathe();
        if (atomic_load_explicit(&pool->listed, memory_order_relaxed) != seen)
            continue;
        pthread_mutex_lock(&pool->lock);
        atomic_fetch_add(&pool->sleepers, 1); /* who lists a loop looks for sleepers after that */
        while (atomic_load(&pool->listed) == seen && !atomic_load(&pool->ending))
            pthread_cond_wait(&pool->work, &pool->lock);
        atomic_fetch_sub(&pool->sleepers, 1);
        pthread_mutex_unlock(&pool->lock);
    }
}

static size_t pool_size(uint32_t capacity)
{
    return sizeof(rti_pool) + capacity * sizeof(struct pool_start);
}

static rti_pool *pool_create(rt_context *ctx)
{
    const uint32_t capacity = ctx->workers - 1;
    rti_pool *pool = rti_alloc_zero(ctx, pool_size(capacity));
    if (!pool)
        return NULL;
    pool->capacity = capacity;
    pool->shares = rti_alloc_array(ctx, LOOPS * (size_t)ctx->workers, sizeof *pool->shares);
    if (!pool->shares) {
        rti_free(ctx, pool, pool_size(capacity));
        return NULL;
    }
    pool->patience =
        ctx->workers <= rt_cpu_count() ? PATIENCE : 0; /* else it would look out on a CPU that another thread wants */
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->work, NULL);
    pthread_cond_init(&pool->done, NULL);
    sigset_t before;
    hold_signals(&before);
    for (; pool->thread_count < capacity; pool->thread_count++) {
        struct pool_start *start = &pool->threads[pool->thread_count];
        start->pool = pool;
        start->self = pool->thread_count + 1;
        if (pthread_create(&start->thread, NULL, pool_thread, start) != 0)
            break;
    }
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
    atomic_store(&pool->ending, true);
    pthread_cond_broadcast(&pool->work);
    pthread_mutex_unlock(&pool->lock);
    for (uint32_t i = 0; i < pool->thread_count; i++)
        pthread_join(pool->threads[i].thread, NULL);
    pthread_mutex_destroy(&pool->lock);
    pthread_cond_destroy(&pool->work);
    pthread_cond_destroy(&pool->done);
    rti_free(ctx, pool->shares, LOOPS * (pool->capacity + (size_t)1) * sizeof *pool->shares);
    rti_free(ctx, pool, pool_size(pool->capacity));
}

/* NULL when there is no memory for it: loops then run on their caller alone. */
static rti_pool *get_pool(rt_context *ctx)
{
    rti_pool *pool = atomic_load(&ctx->pool);
    if (pool)
        return pool;
    pthread_mutex_lock(&ctx->pool_lock);
    pool = atomic_load(&ctx->pool);
    if (!pool) {
        pool = pool_create(ctx);
        atomic_store(&ctx->pool, pool);
    }
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

/* A free record, above those in use where there is one; NULL: there is none. */
static loop *take_loop(rti_pool *pool)
{
    uint_fast64_t owned = atomic_load(&pool->owned), bit;
    do {
        const uint64_t above = owned ? ~(uint64_t)0 << (63 - __builtin_clzll(owned)) & ~owned : 1;
        const uint64_t free = above ? above : ~(uint64_t)owned;
        if (free == 0)
            return NULL;
        bit = free & (~free + 1);
    } while (!atomic_compare_exchange_weak(&pool->owned, &owned, owned | bit));
    return &pool->loops[__builtin_ctzll(bit)];
}

/* Until all have left who are in a loop that nobody may join any more. */
static void wait_for(rti_pool *pool, loop *l)
{
    for (uint32_t i = 0; i < pool->patience && atomic_load(&l->users) != 0; i++)
        breathe();
    if (atomic_load(&l->users) == 0)
        return;
    pthread_mutex_lock(&pool->lock);
    atomic_fetch_add(&pool->waiters, 1);
    while (atomic_load(&l->users) != 0)
        pthread_cond_wait(&pool->done, &pool->lock);
    atomic_fetch_sub(&pool->waiters, 1);
    pthread_mutex_unlock(&pool->lock);
}

static void run_loop(rti_pool *pool, loop *l, uint32_t count, void (*task)(void *data, uint32_t index), void *data)
{
    const uint_fast64_t own = (uint_fast64_t)1 << (l - pool->loops);
    const uint32_t each = pool->capacity + 1;
    l->task = task;
    l->data = data;
    l->shares = pool->shares + (size_t)(l - pool->loops) * each;
    l->share_count = count >= SHARED * each ? each : 1;
    for (uint32_t k = 0; k < l->share_count; k++) {
        atomic_store_explicit(&l->shares[k].next, (uint32_t)((uint64_t)count * k / l->share_count), memory_order_relaxed);
        l->shares[k].end = (uint32_t)((uint64_t)count * (k + 1) / l->share_count);
    }
    atomic_fetch_add(&l->users, OPEN);
    atomic_fetch_or(&pool->open, own);
    atomic_fetch_add(&pool->listed, 1);
    if (atomic_load(&pool->sleepers) > 0) {
        pthread_mutex_lock(&pool->lock);
        pthread_cond_broadcast(&pool->work);
        pthread_mutex_unlock(&pool->lock);
    }
    run_some(pool, l);
    atomic_fetch_sub(&l->users, OPEN);
    wait_for(pool, l);
    atomic_fetch_and(&pool->owned, ~own);
}

void rti_parallel(rt_context *ctx, uint32_t count, void (*task)(void *data, uint32_t index), void *data)
{
    rti_pool *pool = NULL;
    loop *l = NULL;
    if (count == 0)
        return;
    if (ctx->parallel && count > 1) {
        host_loop h = {task, data};
        ctx->parallel(ctx->parallel_user, count, host_task, &h);
        return;
    }
    if (!ctx->parallel && ctx->workers > 1 && count > 1)
        pool = get_pool(ctx);
    if (pool && pool->thread_count > 0)
        l = take_loop(pool);
    if (l) {
        run_loop(pool, l, count, task, data);
        return;
    }
    for (uint32_t i = 0; i < count; i++)
        task(data, i);
}

rt_status rti_pool_start(rt_context *ctx)
{
    rti_pool *pool;
    if (ctx->parallel || ctx->workers <= 1)
        return RT_OK;
    pool = get_pool(ctx);
    if (!pool)
        return rti_fail_memory(ctx, "worker threads", pool_size(ctx->workers));
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
