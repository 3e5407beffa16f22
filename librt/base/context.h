/* What a context is made of. Only base/ looks inside. */
#ifndef RTI_CONTEXT_H
#define RTI_CONTEXT_H

#include <pthread.h>

#include "base.h"
#include "isa.h"

#define RTI_MESSAGE_SIZE  1024
#define RTI_MESSAGE_SLOTS 64
#define RTI_KEPT          65 /* blocks of renders */
#define RTI_ROOMS         32 /* that are kept; more threads than that are seldom in queries at once */

typedef struct rti_message {
    pthread_t thread;
    uint64_t order; /* 0: free; else the larger, the younger */
    char text[RTI_MESSAGE_SIZE];
} rti_message;

typedef struct rti_pool rti_pool;

typedef struct rti_cache_slot {
    void *cache;
    const rti_cache_kind *kind;
} rti_cache_slot;

/* Bytes that each block has before it (memory.c). */
#define RTI_BLOCK_HEADER RTI_CACHE_LINE

struct rt_context {
    rt_allocate_fn allocate;
    void *allocate_user;
    rt_log_fn log;
    void *log_user;
    rt_parallel_fn parallel;
    void *parallel_user;
    rt_open_fn open;
    void *open_user;
    uint64_t memory_limit;
    uint32_t workers;
    rti_isa isa;
    bool roomy; /* rti_context_roomy */

    atomic_uint_fast64_t memory_now, memory_peak;
    atomic_bool limit_refused; /* the last block that was refused would have passed the limit; the hook was not asked */

    pthread_mutex_t message_lock;
    uint64_t message_order;
    rti_message *messages; /* [RTI_MESSAGE_SLOTS] */

    pthread_mutex_t log_lock;

    pthread_mutex_t pool_lock;
    _Atomic(rti_pool *) pool; /* made on first need, under the lock */

    /* Room for the scene floor's caches: set and ended by it (rti_context_set_cache). */
    pthread_mutex_t cache_lock;
    rti_cache_slot caches[RTI_CACHE_COUNT];

    atomic_uint_fast64_t work[RTI_WORK_COUNT];

    _Atomic(void *) rooms[RTI_ROOMS]; /* that wait for their next call (room.c) */
    atomic_size_t room_size;
    _Atomic(void *) kept[RTI_KEPT]; /* a picture, then workers' memory */
};

bool rti_rooms_drop(rt_context *ctx); /* false: none was kept */
void rti_pool_destroy(rt_context *ctx, rti_pool *pool);

#endif
