/* Working memory of calls that take none from their caller: each thread that is in such a call has a room of its own, and rooms
 * are kept for the next ones. */
#include "context.h"

void *rti_room_take(rt_context *ctx, size_t size)
{
    for (uint32_t i = 0; i < RTI_ROOMS; i++) {
        void *room = atomic_load_explicit(&ctx->rooms[i], memory_order_relaxed) ? atomic_exchange(&ctx->rooms[i], NULL) : NULL;
        if (room)
            return room;
    }
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

bool rti_rooms_drop(rt_context *ctx)
{
    bool some = false;
    for (uint32_t i = 0; i < RTI_ROOMS; i++) {
        void *room = atomic_exchange(&ctx->rooms[i], NULL);
        if (room) /* whoever gave it has stored its size before */
            rti_free(ctx, room, atomic_load_explicit(&ctx->room_size, memory_order_relaxed));
        some |= room != NULL;
    }
    return some;
}
