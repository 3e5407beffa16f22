/* The cache is weak: a chunk leaves it with its last user. Trees are dear, so the last used ones get the cache itself as a user,
 * within a bound: a sweep that makes the same mesh again in a new scene finds its tree. */
#include "chunk.h"

#include <pthread.h>
#include <string.h>

/* Small trees are quickly built, and few of them are held: a thousand frames that each move something leave nothing behind that
 * grows. */
#define BUCKETS    256u
#define KEPT       256u
#define KEPT_SMALL 32u
#define SMALL      (64u << 10)  /* bytes */
#define KEPT_BYTES (1ull << 30) /* at most, and at most a quarter of the context's memory limit */

typedef struct cache {
    pthread_mutex_t lock;
    rti_chunk *kept[KEPT], *small[KEPT_SMALL]; /* the last used first */
    rti_chunk *bucket[BUCKETS];
} cache;

/* Lets go of a list's chunks, without the lock: releasing takes it. */
static bool drop_list(cache *c, rti_chunk **list, unsigned count)
{
    rti_chunk *old[KEPT];
    pthread_mutex_lock(&c->lock);
    for (unsigned i = 0; i < count; i++) {
        old[i] = list[i];
        list[i] = NULL;
    }
    pthread_mutex_unlock(&c->lock);
    for (unsigned i = 0; i < count; i++)
        rti_chunk_release(old[i]);
    return old[0] != NULL;
}

static bool drop_kept(rt_context *ctx, void *data)
{
    cache *c = data;
    bool large = drop_list(c, c->kept, KEPT), small = drop_list(c, c->small, KEPT_SMALL);
    (void)ctx;
    return large || small;
}

static void cache_end(rt_context *ctx, void *data)
{
    cache *c = data;
    drop_kept(ctx, c);
    pthread_mutex_destroy(&c->lock);
    rti_free(ctx, c, sizeof *c);
}

static cache *cache_of(rt_context *ctx)
{
    static const rti_cache_kind kind = {cache_end, drop_kept};
    cache *c = rti_context_cache(ctx, RTI_CACHE_CHUNKS), *there;
    if (c)
        return c;
    c = rti_alloc_zero(ctx, sizeof *c);
    if (!c)
        return NULL;
    pthread_mutex_init(&c->lock, NULL);
    there = rti_context_set_cache(ctx, RTI_CACHE_CHUNKS, c, &kind);
    if (there != c)
        cache_end(ctx, c);
    return there;
}

static rti_chunk **slot_of(cache *c, uint32_t kind, rti_hash hash)
{
    return &c->bucket[(hash.lo ^ hash.hi ^ kind) % BUCKETS];
}

/* Under the lock: every chunk in a bucket has at least one reference. */
static rti_chunk *find_locked(cache *c, uint32_t kind, rti_hash hash)
{
    for (rti_chunk *k = *slot_of(c, kind, hash); k; k = k->next) {
        if (k->kind == kind && rti_hash_equal(k->hash, hash)) {
            atomic_fetch_add_explicit(&k->refs, 1, memory_order_relaxed);
            return k;
        }
    }
    return NULL;
}

rti_chunk *rti_chunk_find(rt_context *ctx, uint32_t kind, rti_hash hash)
{
    cache *c = cache_of(ctx);
    rti_chunk *k;
    if (!c)
        return NULL;
    pthread_mutex_lock(&c->lock);
    k = find_locked(c, kind, hash);
    pthread_mutex_unlock(&c->lock);
    return k;
}

#define PIECE      (4u << 20) /* bytes hashed by one task */
#define MOST_TASKS 256u

typedef struct hash_job {
    const uint8_t *data;
    size_t size, piece;
    rti_hash hash[MOST_TASKS];
} hash_job;

static void hash_task(void *data, uint32_t task)
{
    hash_job *job = data;
    size_t first = task * job->piece, left = job->size - first;
    job->hash[task] = rti_hash_bytes(job->data + first, left < job->piece ? left : job->piece);
}

/* The hash of the hashes of pieces: their size follows from the chunk's, so it is the same for any number of workers. */
static rti_hash content_hash(rt_context *ctx, uint32_t kind, const void *data, size_t size)
{
    hash_job job = {.data = data, .size = size, .piece = PIECE};
    uint32_t tasks;
    rti_hasher h;
    while (job.piece < size / MOST_TASKS + 1)
        job.piece *= 2;
    tasks = (uint32_t)((size + job.piece - 1) / job.piece);
    if (tasks > 1)
        rti_parallel(ctx, tasks, hash_task, &job);
    else
        hash_task(&job, 0);
    rti_hasher_init(&h);
    rti_hasher_add(&h, job.hash, (tasks > 1 ? tasks : 1) * sizeof job.hash[0]);
    rti_hasher_add(&h, &kind, sizeof kind);
    return rti_hasher_end(&h);
}

rti_chunk *rti_chunk_share(rt_context *ctx, uint32_t kind, void *data, size_t size, const rti_hash *key, bool *shared)
{
    cache *c = cache_of(ctx);
    rti_chunk *k = c ? rti_alloc_zero(ctx, sizeof *k) : NULL, *there;
    rti_chunk **slot;
    *shared = false;
    if (!k) {
        rti_free(ctx, data, size);
        return NULL;
    }
    k->ctx = ctx;
    k->data = data;
    k->size = size;
    k->kind = kind;
    k->hash = key ? *key : content_hash(ctx, kind, data, size);
    atomic_init(&k->refs, 1);
    pthread_mutex_lock(&c->lock);
    there = find_locked(c, kind, k->hash);
    if (!there) {
        slot = slot_of(c, kind, k->hash);
        k->next = *slot;
        *slot = k;
    }
    pthread_mutex_unlock(&c->lock);
    if (!there) {
        rti_settle_large(data, size);
        return k;
    }
    /* The hash is no proof against those who make collisions on purpose: equal content is shared, other content stands alone. */
    if (!key && (there->size != size || memcmp(there->data, data, size) != 0)) {
        rti_chunk_release(there);
        k->next = k; /* not in the cache */
        return k;
    }
    rti_free(ctx, data, size);
    rti_free(ctx, k, sizeof *k);
    *shared = true;
    return there;
}

/* Puts the chunk in front; gives back (through out) what no longer fits. Under the lock. */
static unsigned keep_locked(rti_chunk **list, unsigned most, rti_chunk *chunk, uint64_t limit, rti_chunk *out[KEPT + 1])
{
    rti_chunk *old[KEPT];
    uint64_t bytes = 0;
    unsigned n = 0, dropped = 0;
    for (unsigned i = 0; i < most; i++) {
        old[i] = list[i];
        list[i] = NULL;
    }
    for (unsigned i = 0; i <= most; i++) {
        rti_chunk *k = i == 0 ? chunk : old[i - 1];
        if (!k)
            continue;
        if ((i > 0 && k == chunk) || n == most || k->size > limit - bytes) {
            out[dropped++] = k;
            continue;
        }
        bytes += k->size;
        list[n++] = k;
    }
    return dropped;
}

void rti_chunk_keep(rti_chunk *chunk)
{
    cache *c = cache_of(chunk->ctx);
    uint64_t limit = rti_context_memory_limit(chunk->ctx) / 4;
    bool small = chunk->size < SMALL;
    rti_chunk *out[KEPT + 1];
    unsigned dropped;
    if (!c)
        return;
    limit = limit && limit < KEPT_BYTES ? limit : KEPT_BYTES;
    rti_chunk_retain(chunk);
    pthread_mutex_lock(&c->lock);
    dropped = keep_locked(small ? c->small : c->kept, small ? KEPT_SMALL : KEPT, chunk, limit, out);
    pthread_mutex_unlock(&c->lock);
    for (unsigned i = 0; i < dropped; i++)
        rti_chunk_release(out[i]);
}

bool rti_chunk_drop_kept(rt_context *ctx)
{
    cache *c = rti_context_cache(ctx, RTI_CACHE_CHUNKS);
    return c && drop_kept(ctx, c);
}

rti_chunk *rti_chunk_retain(rti_chunk *chunk)
{
    if (chunk)
        atomic_fetch_add_explicit(&chunk->refs, 1, memory_order_relaxed);
    return chunk;
}

static void unlink_chunk(cache *c, rti_chunk *chunk)
{
    rti_chunk **at = slot_of(c, chunk->kind, chunk->hash);
    while (*at != chunk)
        at = &(*at)->next;
    *at = chunk->next;
}

void rti_chunk_release(rti_chunk *chunk)
{
    unsigned refs;
    cache *c;
    bool last;
    if (!chunk)
        return;
    refs = atomic_load_explicit(&chunk->refs, memory_order_relaxed);
    while (refs > 1) {
        if (atomic_compare_exchange_weak_explicit(&chunk->refs, &refs, refs - 1, memory_order_release, memory_order_relaxed))
            return;
    }
    /* Perhaps the last one: only under the lock may a count reach 0, so that a finder never meets a dying chunk. */
    c = cache_of(chunk->ctx);
    pthread_mutex_lock(&c->lock);
    last = atomic_fetch_sub_explicit(&chunk->refs, 1, memory_order_acq_rel) == 1;
    if (last && chunk->next != chunk)
        unlink_chunk(c, chunk);
    pthread_mutex_unlock(&c->lock);
    if (last) {
        rti_free(chunk->ctx, chunk->data, chunk->size);
        rti_free(chunk->ctx, chunk, sizeof *chunk);
    }
}

void rti_layout_begin(rti_layout *layout, size_t header)
{
    layout->size = header;
    layout->overflow = false;
}

uint64_t rti_layout_add(rti_layout *layout, size_t count, size_t item)
{
    size_t bytes, at = (layout->size + 63u) & ~(size_t)63u;
    if (count == 0)
        return 0;
    if (layout->size > SIZE_MAX - 64u || !rti_mul_size(count, item, &bytes) || !rti_add_size(at, bytes, &layout->size))
        layout->overflow = true;
    return at;
}
