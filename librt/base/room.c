/* Memory that is kept for the next call: of queries that take none from their caller, a room for each thread that is in one; and
 * of renders, whose pages the system would clear each time: with many workers that takes longer than the rays. */
#include "context.h"

void *rti_room_take(rt_context *ctx, size_t size, bool *used)
{
    *used = true;
    for (uint32_t i = 0; i < RTI_ROOMS; i++) {
        void *room = atomic_load_explicit(&ctx->rooms[i], memory_order_relaxed) ? atomic_exchange(&ctx->rooms[i], NULL) : NULL;
        if (room)
            return room;
    }
    *used = false;
    return rti_alloc_spare(ctx, size);
}

void rti_room_give(rt_context *ctx, void *room, size_t size)
{
    for (uint32_t i = 0; room && i < RTI_ROOMS; i++) {
        void *none = NULL;
        atomic_store_explicit(&ctx->room_size, size, memory_order_relaxed);
        if (atomic_compare_exchange_strong(&ctx->rooms[i], &none, room))
            return;
    }
    rti_free(ctx, room, size);
}

/* ---- blocks of renders ---- */

/* The places of a kind. */
static uint32_t places(const rt_context *ctx, uint32_t kind, uint32_t *first)
{
    *first = kind == RTI_KEPT_WORK ? 1 : 0;
    return kind == RTI_KEPT_PICTURE ? 1 : ctx->workers < RTI_KEPT - 1 ? ctx->workers : RTI_KEPT - 1;
}

/* A block starts with its size while it is kept. */
static bool drop(rt_context *ctx, size_t *block)
{
    if (block)
        rti_free(ctx, block, *block);
    return block != NULL;
}

void *rti_kept_take(rt_context *ctx, uint32_t kind, size_t *size, size_t most, bool *used)
{
    uint32_t first, count = places(ctx, kind, &first);
    if (ctx->memory_limit != 0)
        most = *size;
    *used = false;
    for (uint32_t i = first; i < first + count; i++) {
        size_t *block = atomic_load_explicit(&ctx->kept[i], memory_order_relaxed) ? atomic_exchange(&ctx->kept[i], NULL) : NULL;
        *used = block && *block >= *size && *block <= most;
        if (*used) {
            *size = *block;
            return block;
        }
        drop(ctx, block);
    }
    return rti_alloc(ctx, *size);
}

void rti_kept_give(rt_context *ctx, uint32_t kind, void *block, size_t size)
{
    uint32_t first, count = places(ctx, kind, &first);
    if (!block)
        return;
    if (size >= RTI_KEPT_LEAST && size <= RTI_KEPT_MOST) {
        *(size_t *)block = size;
        for (uint32_t i = first; i < first + count; i++) {
            void *none = NULL;
            if (atomic_compare_exchange_strong(&ctx->kept[i], &none, block))
                return;
        }
    }
    rti_free(ctx, block, size);
}

bool rti_rooms_drop(rt_context *ctx)
{
    bool some = false;
    for (uint32_t i = 0; i < RTI_KEPT; i++)
        some |= drop(ctx, atomic_exchange(&ctx->kept[i], NULL));
    for (uint32_t i = 0; i < RTI_ROOMS; i++) {
        void *room = atomic_exchange(&ctx->rooms[i], NULL);
        if (room) /* whoever gave it has stored its size before */
            rti_free(ctx, room, atomic_load_explicit(&ctx->room_size, memory_order_relaxed));
        some |= room != NULL;
    }
    return some;
}
