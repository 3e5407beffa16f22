/* The last message of each thread: a fixed table in the context, so that failing needs no memory and no thread's state is left
 * behind but for what fails without a context. */
#include <string.h>

#include "context.h"

static rti_message *find(rt_context *ctx, pthread_t self)
{
    for (unsigned i = 0; i < RTI_MESSAGE_SLOTS; i++) {
        if (ctx->messages[i].order && pthread_equal(ctx->messages[i].thread, self))
            return &ctx->messages[i];
    }
    return NULL;
}

static rti_message *oldest(rt_context *ctx)
{
    rti_message *m = &ctx->messages[0];
    for (unsigned i = 1; i < RTI_MESSAGE_SLOTS; i++) {
        if (ctx->messages[i].order < m->order)
            m = &ctx->messages[i];
    }
    return m;
}

rt_status rti_fail_v(rt_context *ctx, rt_status status, const char *format, va_list args)
{
    char text[RTI_MESSAGE_SIZE];
    rti_message *m;
    pthread_t self = pthread_self();
    vsnprintf(text, sizeof text, format, args);
    pthread_mutex_lock(&ctx->message_lock);
    m = find(ctx, self);
    if (!m)
        m = oldest(ctx);
    m->thread = self;
    m->order = ++ctx->message_order;
    memcpy(m->text, text, sizeof text);
    pthread_mutex_unlock(&ctx->message_lock);
    return status;
}

rt_status rti_fail(rt_context *ctx, rt_status status, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    rti_fail_v(ctx, status, format, args);
    va_end(args);
    return status;
}

rt_status rti_fail_memory(rt_context *ctx, const char *what, size_t size)
{
    uint64_t now = atomic_load_explicit(&ctx->memory_now, memory_order_relaxed);
    const bool refused = atomic_load_explicit(&ctx->limit_refused, memory_order_relaxed);
    size = size > SIZE_MAX - RTI_BLOCK_HEADER ? size : size + RTI_BLOCK_HEADER; /* what the block takes */
    if (ctx->memory_limit && (refused || size > ctx->memory_limit))             /* the latter: too much to be asked for at all */
        return rti_fail(ctx, RT_ERROR_MEMORY_LIMIT,
                        "%s: %llu bytes more would pass the memory limit of %llu bytes (%llu are in use)", what,
                        (unsigned long long)size, (unsigned long long)ctx->memory_limit, (unsigned long long)now);
    return rti_fail(ctx, RT_ERROR_MEMORY, "%s: the allocator could not give %llu bytes", what, (unsigned long long)size);
}

#define ALONE_SIZE 256 /* these sentences are short, and each thread of the host has room for one */
static _Thread_local char alone[ALONE_SIZE];

rt_status rti_fail_alone(rt_status status, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vsnprintf(alone, sizeof alone, format, args);
    va_end(args);
    return status;
}

static size_t copy_message(const char *text, char *buffer, size_t size)
{
    const size_t length = strlen(text);
    if (size > 0 && buffer) {
        const size_t n = length < size - 1 ? length : size - 1;
        memcpy(buffer, text, n);
        buffer[n] = '\0';
    }
    return length;
}

size_t rt_context_error(const rt_context *context, char *buffer, size_t size)
{
    rt_context *ctx = (rt_context *)(uintptr_t)context; /* the lock is not part of what const promises */
    const rti_message *m;
    size_t length;
    if (!ctx)
        return copy_message(alone, buffer, size);
    pthread_mutex_lock(&ctx->message_lock);
    m = find(ctx, pthread_self());
    length = copy_message(m ? m->text : "", buffer, size);
    pthread_mutex_unlock(&ctx->message_lock);
    return length;
}

void rti_log(rt_context *ctx, rt_log_level level, const char *format, ...)
{
    char text[RTI_MESSAGE_SIZE];
    va_list args;
    if (!ctx->log)
        return;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    pthread_mutex_lock(&ctx->log_lock);
    ctx->log(ctx->log_user, level, text);
    pthread_mutex_unlock(&ctx->log_lock);
}

rt_status rti_desc_take(rt_context *ctx, const char *what, const void *desc, void *full, uint32_t full_size)
{
    uint32_t size;
    if (!desc)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: the descriptor is NULL", what);
    memcpy(&size, desc, sizeof size);
    if (size < 2 * sizeof size || size > 65536)
        return rti_fail(ctx, RT_ERROR_ARGUMENT,
                        "%s: the descriptor's struct_size is %u; begin with the matching _default() function", what, size);
    memcpy(full, desc, size < full_size ? size : full_size);
    memcpy(full, &full_size, sizeof full_size);
    return RT_OK;
}
