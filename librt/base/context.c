#include "context.h"

#include <stdlib.h>
#include <string.h>

rt_context_desc rt_context_desc_default(void)
{
    rt_context_desc d;
    memset(&d, 0, sizeof d);
    d.struct_size = sizeof d;
    return d;
}

void *rt_allocate(void *user, void *ptr, size_t old_size, size_t new_size)
{
    (void)user;
    (void)old_size;
    if (new_size == 0) {
        free(ptr);
        return NULL;
    }
    return ptr ? realloc(ptr, new_size) : rti_alloc_large(new_size);
}

static rt_status take_desc(const rt_context_desc *desc, rt_context_desc *full)
{
    *full = rt_context_desc_default();
    if (!desc)
        return RT_OK;
    if (desc->struct_size < sizeof(uint32_t) * 2 || desc->struct_size > 65536)
        return rti_fail_alone(RT_ERROR_ARGUMENT,
                              "rt_context_create: the descriptor's struct_size is %u; begin with rt_context_desc_default()",
                              (unsigned)desc->struct_size);
    memcpy(full, desc, desc->struct_size < sizeof *full ? desc->struct_size : sizeof *full);
    full->struct_size = sizeof *full;
    if (full->workers > 1024)
        return rti_fail_alone(
            RT_ERROR_ARGUMENT,
            "rt_context_create: workers is %u; it must be from 1 to 1024, or 0: as many as there are processors",
            (unsigned)full->workers);
    return RT_OK;
}

/* There is no caller to blame for a variable of the environment: a wrong one is a warning. */
static void choose_isa(rt_context *ctx)
{
    char why[256];
    ctx->isa = rti_isa_choose(getenv("RT_ISA"), why, sizeof why);
    if (why[0])
        rti_log(ctx, RT_LOG_WARNING, "%s", why);
}

static rt_status no_memory(size_t size)
{
    return rti_fail_alone(RT_ERROR_MEMORY, "rt_context_create: the allocator could not give %zu bytes", size);
}

rt_status rt_context_create(const rt_context_desc *desc, rt_context **context)
{
    rt_context_desc d;
    rt_context *ctx;
    rt_status status;
    RTI_NEED(context);
    *context = NULL;
    status = take_desc(desc, &d);
    if (status != RT_OK)
        return status;
    if (!d.allocate)
        d.allocate = rt_allocate;
    ctx = d.allocate(d.allocate_user, NULL, 0, sizeof *ctx);
    if (!ctx)
        return no_memory(sizeof *ctx);
    memset(ctx, 0, sizeof *ctx);
    ctx->messages = d.allocate(d.allocate_user, NULL, 0, RTI_MESSAGE_SLOTS * sizeof *ctx->messages);
    if (!ctx->messages) {
        d.allocate(d.allocate_user, ctx, sizeof *ctx, 0);
        return no_memory(RTI_MESSAGE_SLOTS * sizeof *ctx->messages);
    }
    memset(ctx->messages, 0, RTI_MESSAGE_SLOTS * sizeof *ctx->messages);
    ctx->allocate = d.allocate;
    ctx->allocate_user = d.allocate_user;
    ctx->log = d.log;
    ctx->log_user = d.log_user;
    ctx->parallel = d.parallel;
    ctx->parallel_user = d.parallel_user;
    ctx->open = d.open;
    ctx->open_user = d.open_user;
    ctx->memory_limit = d.memory_limit;
    ctx->workers = d.workers ? d.workers : rt_cpu_count();
    atomic_init(&ctx->memory_now, 0);
    atomic_init(&ctx->memory_peak, 0);
    atomic_init(&ctx->limit_refused, false);
    for (uint32_t i = 0; i < RTI_WORK_COUNT; i++)
        atomic_init(&ctx->work[i], 0);
    for (uint32_t i = 0; i < RTI_ROOMS; i++)
        atomic_init(&ctx->rooms[i], NULL);
    for (uint32_t i = 0; i < RTI_KEPT; i++)
        atomic_init(&ctx->kept[i], NULL);
    atomic_init(&ctx->room_size, 0);
    pthread_mutex_init(&ctx->message_lock, NULL);
    pthread_mutex_init(&ctx->log_lock, NULL);
    pthread_mutex_init(&ctx->pool_lock, NULL);
    pthread_mutex_init(&ctx->cache_lock, NULL);
    choose_isa(ctx);
    ctx->roomy = rti_core_cache() >= (uint64_t)1 << 20;
    *context = ctx;
    return RT_OK;
}

void rt_context_destroy(rt_context *ctx)
{
    if (!ctx)
        return;
    for (uint32_t i = RTI_CACHE_COUNT; i-- > 0;) {
        if (ctx->caches[i].cache)
            ctx->caches[i].kind->end(ctx, ctx->caches[i].cache);
    }
    rti_rooms_drop(ctx);
    rti_pool_destroy(ctx, ctx->pool);
    pthread_mutex_destroy(&ctx->message_lock);
    pthread_mutex_destroy(&ctx->log_lock);
    pthread_mutex_destroy(&ctx->pool_lock);
    pthread_mutex_destroy(&ctx->cache_lock);
    ctx->allocate(ctx->allocate_user, ctx->messages, RTI_MESSAGE_SLOTS * sizeof *ctx->messages, 0);
    ctx->allocate(ctx->allocate_user, ctx, sizeof *ctx, 0);
}

uint32_t rt_context_workers(const rt_context *context)
{
    return context->workers;
}

rti_isa rti_context_isa(const rt_context *ctx)
{
    return ctx->isa;
}

bool rti_context_roomy(const rt_context *ctx)
{
    return ctx->roomy;
}

const char *rt_isa(void)
{
    char why[256];
    return rti_isa_name(rti_isa_choose(getenv("RT_ISA"), why, sizeof why));
}

const char *rt_context_isa(const rt_context *context)
{
    return rti_isa_name(context->isa);
}

void rt_context_memory(const rt_context *context, uint64_t *now, uint64_t *peak)
{
    if (now)
        *now = atomic_load_explicit(&context->memory_now, memory_order_relaxed);
    if (peak)
        *peak = atomic_load_explicit(&context->memory_peak, memory_order_relaxed);
}

void *rti_context_cache(rt_context *ctx, uint32_t slot)
{
    void *cache;
    pthread_mutex_lock(&ctx->cache_lock);
    cache = ctx->caches[slot].cache;
    pthread_mutex_unlock(&ctx->cache_lock);
    return cache;
}

void *rti_context_set_cache(rt_context *ctx, uint32_t slot, void *cache, const rti_cache_kind *kind)
{
    void *there;
    pthread_mutex_lock(&ctx->cache_lock);
    if (!ctx->caches[slot].cache)
        ctx->caches[slot] = (rti_cache_slot){cache, kind};
    there = ctx->caches[slot].cache;
    pthread_mutex_unlock(&ctx->cache_lock);
    return there;
}

static bool drop_caches(rt_context *ctx)
{
    rti_cache_slot caches[RTI_CACHE_COUNT];
    bool some = false;
    pthread_mutex_lock(&ctx->cache_lock);
    memcpy(caches, ctx->caches, sizeof caches);
    pthread_mutex_unlock(&ctx->cache_lock);
    for (uint32_t i = RTI_CACHE_COUNT; i-- > 0;)
        some |= caches[i].cache && caches[i].kind->drop(ctx, caches[i].cache);
    return some;
}

/* Memory that is only faster to have goes before what would have to be made anew. */
bool rti_context_relieve(rt_context *ctx)
{
    return rti_rooms_drop(ctx) || drop_caches(ctx);
}

uint64_t rti_context_spare(rt_context *ctx, uint64_t bytes, uint64_t (*available)(void))
{
    uint64_t now = available();
    while (now < bytes && rti_context_relieve(ctx))
        now = available();
    return now;
}

void rt_context_drop_kept(rt_context *context)
{
    rti_rooms_drop(context);
    drop_caches(context);
}

void rti_context_count(rt_context *ctx, uint32_t what, uint64_t amount)
{
    atomic_fetch_add_explicit(&ctx->work[what], amount, memory_order_relaxed);
}

void rti_context_time(rt_context *ctx, uint32_t what, double seconds)
{
    rti_context_count(ctx, what, seconds > 0.0 ? (uint64_t)(seconds * 1.0e9) : 0);
}

static uint64_t count_of(const rt_context *ctx, uint32_t what)
{
    return atomic_load_explicit(&ctx->work[what], memory_order_relaxed);
}

rt_context_work_stats rt_context_work(const rt_context *context)
{
    return (rt_context_work_stats){.files_read = count_of(context, RTI_WORK_FILES_READ),
                                   .files_kept = count_of(context, RTI_WORK_FILES_KEPT),
                                   .trees_built = count_of(context, RTI_WORK_TREES_BUILT),
                                   .top_trees_built = count_of(context, RTI_WORK_TOPS_BUILT),
                                   .trees_kept = count_of(context, RTI_WORK_TREES_KEPT),
                                   .trees_refitted = count_of(context, RTI_WORK_TREES_REFITTED),
                                   .read_seconds = (double)count_of(context, RTI_WORK_READ_NS) / 1.0e9,
                                   .build_seconds = (double)count_of(context, RTI_WORK_BUILD_NS) / 1.0e9,
                                   .saved_seconds = (double)count_of(context, RTI_WORK_SAVED_NS) / 1.0e9};
}

bool rti_context_has_tasks(const rt_context *ctx)
{
    return ctx->parallel != NULL;
}

uint64_t rti_context_memory_limit(const rt_context *ctx)
{
    return ctx->memory_limit;
}

const char *rt_status_name(rt_status status)
{
    static const char *const names[] = {
        "RT_OK",       "RT_ERROR_ARGUMENT", "RT_ERROR_STATE",       "RT_ERROR_MEMORY",    "RT_ERROR_MEMORY_LIMIT",
        "RT_ERROR_IO", "RT_ERROR_FORMAT",   "RT_ERROR_UNSUPPORTED", "RT_ERROR_CANCELLED", "RT_ERROR_THREAD"};
    return (unsigned)status < RTI_COUNT(names) ? names[status] : "unknown status";
}

#define RTI_STRING_(x) #x
#define RTI_STRING(x)  RTI_STRING_(x)

const char *rt_version(void)
{
    return RTI_STRING(RT_VERSION_MAJOR) "." RTI_STRING(RT_VERSION_MINOR) "." RTI_STRING(RT_VERSION_PATCH);
}

const char *rt_build_info(void)
{
    return "librt " RTI_STRING(RT_VERSION_MAJOR) "." RTI_STRING(RT_VERSION_MINOR) "." RTI_STRING(RT_VERSION_PATCH)
#if defined(RTI_HAVE_STB)
        " stb=yes"
#else
        " stb=no"
#endif
#if defined(RTI_HAVE_PNG)
        " png=yes"
#else
        " png=no"
#endif
        " mpi=no opencl=no"
#if defined(__clang__)
        " clang=" RTI_STRING(__clang_major__) "." RTI_STRING(__clang_minor__)
#elif defined(__GNUC__)
        " gcc=" RTI_STRING(__GNUC__) "." RTI_STRING(__GNUC_MINOR__)
#endif
            ;
}
