/* The hook gives malloc's alignment; blocks here are cache-line aligned: the distance to the hook's pointer stands in the bytes
 * before. */
#include <string.h>

#include "context.h"

bool rti_mul_size(size_t a, size_t b, size_t *out)
{
    if (b != 0 && a > SIZE_MAX / b)
        return false;
    *out = a * b;
    return true;
}

bool rti_add_size(size_t a, size_t b, size_t *out)
{
    if (a > SIZE_MAX - b)
        return false;
    *out = a + b;
    return true;
}

static bool charge(rt_context *ctx, uint64_t size)
{
    uint_fast64_t now = atomic_load_explicit(&ctx->memory_now, memory_order_relaxed), peak;
    do {
        if (ctx->memory_limit && (size > ctx->memory_limit || now > ctx->memory_limit - size))
            return false;
    } while (
        !atomic_compare_exchange_weak_explicit(&ctx->memory_now, &now, now + size, memory_order_relaxed, memory_order_relaxed));
    now += size;
    peak = atomic_load_explicit(&ctx->memory_peak, memory_order_relaxed);
    while (now > peak &&
           !atomic_compare_exchange_weak_explicit(&ctx->memory_peak, &peak, now, memory_order_relaxed, memory_order_relaxed)) {
    }
    return true;
}

static void discharge(rt_context *ctx, uint64_t size)
{
    atomic_fetch_sub_explicit(&ctx->memory_now, size, memory_order_relaxed);
}

static size_t whole_size(size_t size)
{
    return size + RTI_BLOCK_HEADER;
}

static unsigned char *take(rt_context *ctx, size_t size)
{
    unsigned char *raw = NULL;
    const bool charged = charge(ctx, size);
    if (charged)
        raw = ctx->allocate(ctx->allocate_user, NULL, 0, size);
    if (!raw)
        atomic_store_explicit(&ctx->limit_refused, !charged, memory_order_relaxed);
    if (!raw && charged)
        discharge(ctx, size);
    return raw;
}

static void *block(rt_context *ctx, size_t size, bool relieve)
{
    unsigned char *raw, *ptr;
    if (size == 0)
        size = 1;
    if (size > SIZE_MAX / 2)
        return NULL;
    raw = take(ctx, whole_size(size));
    while (!raw && relieve && rti_context_relieve(ctx)) /* what is only kept for later may be what stands in the way */
        raw = take(ctx, whole_size(size));
    if (!raw)
        return NULL;
    ptr = raw + RTI_BLOCK_HEADER - (uintptr_t)raw % RTI_BLOCK_HEADER;
    ptr[-1] =
        (unsigned char)(ptr - raw); /* 16 ... 64: malloc's alignment is at least 16 on the systems we know, and 1 suffices */
    return ptr;
}

void *rti_alloc(rt_context *ctx, size_t size)
{
    return block(ctx, size, true);
}

void *rti_alloc_spare(rt_context *ctx, size_t size)
{
    return block(ctx, size, false);
}

void *rti_alloc_zero(rt_context *ctx, size_t size)
{
    void *ptr = rti_alloc(ctx, size);
    if (ptr)
        memset(ptr, 0, size);
    return ptr;
}

void *rti_alloc_array(rt_context *ctx, size_t count, size_t size)
{
    size_t total;
    return rti_mul_size(count, size, &total) ? rti_alloc(ctx, total) : NULL;
}

void rti_free(rt_context *ctx, void *ptr, size_t size)
{
    unsigned char *p = ptr;
    if (!p)
        return;
    if (size == 0)
        size = 1;
    ctx->allocate(ctx->allocate_user, p - p[-1], whole_size(size), 0);
    discharge(ctx, whole_size(size));
}

void *rti_shrink(rt_context *ctx, void *ptr, size_t old_size, size_t new_size)
{
    unsigned char *p = ptr, *raw, *to;
    const size_t offset = p[-1];
    raw = ctx->allocate(ctx->allocate_user, p - offset, whole_size(old_size), whole_size(new_size));
    if (!raw)
        return NULL;
    discharge(ctx, old_size - new_size);
    to = raw + RTI_BLOCK_HEADER - (uintptr_t)raw % RTI_BLOCK_HEADER;
    if (to != raw + offset) /* the hook has moved it to another offset from the cache line */
        memmove(to, raw + offset, new_size);
    to[-1] = (unsigned char)(to - raw);
    return to;
}

/* Not the hook's resize: it could move the block to another offset from the cache line. */
void *rti_realloc(rt_context *ctx, void *ptr, size_t old_size, size_t new_size)
{
    void *moved = rti_alloc(ctx, new_size);
    if (!moved)
        return NULL;
    if (ptr)
        memcpy(moved, ptr, old_size < new_size ? old_size : new_size);
    rti_free(ctx, ptr, old_size);
    return moved;
}

bool rti_reserve(rt_context *ctx, void **data, size_t *capacity, size_t count, size_t more, size_t item_size)
{
    size_t need, grown, bytes;
    void *moved;
    if (!rti_add_size(count, more, &need))
        return false;
    if (need <= *capacity)
        return true;
    grown = *capacity < 8 ? 16 : *capacity;
    while (grown < need) {
        if (grown > SIZE_MAX / 2)
            return false;
        grown *= 2;
    }
    if (!rti_mul_size(grown, item_size, &bytes))
        return false;
    moved = rti_realloc(ctx, *data, *capacity * item_size, bytes);
    if (!moved)
        return false;
    *data = moved;
    *capacity = grown;
    return true;
}

struct rti_arena_block {
    rti_arena_block *next;
    size_t size, used;
    size_t pad;
};

void rti_arena_init(rti_arena *arena, rt_context *ctx, size_t block_size)
{
    arena->ctx = ctx;
    arena->head = NULL;
    arena->block_size = block_size < 4096 ? 4096 : block_size;
}

void *rti_arena_alloc(rti_arena *arena, size_t size)
{
    rti_arena_block *block = arena->head;
    void *result;
    if (size > SIZE_MAX / 4)
        return NULL;
    size = (size + 15) & ~(size_t)15;
    if (!block || block->size - block->used < size) {
        size_t bytes = sizeof *block + size;
        if (bytes < arena->block_size)
            bytes = arena->block_size;
        block = rti_alloc(arena->ctx, bytes);
        if (!block)
            return NULL;
        block->next = arena->head;
        block->size = bytes;
        block->used = sizeof *block;
        arena->head = block;
    }
    result = (unsigned char *)block + block->used;
    block->used += size;
    return result;
}

void rti_arena_fini(rti_arena *arena)
{
    rti_arena_block *block = arena->head;
    while (block) {
        rti_arena_block *next = block->next;
        rti_free(arena->ctx, block, block->size);
        block = next;
    }
    arena->head = NULL;
}
