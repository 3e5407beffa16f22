/* An entry is found by its file's stamp when that can be trusted, else by the bytes' hash. It is never found by a name: a renamed
 * file is the same file, and a file replaced under its name another. */
#include "kept.h"

#include <pthread.h>
#include <string.h>

#define ENTRIES    256u
#define KEPT_BYTES (1ull << 30) /* at most, and at most a quarter of the context's memory limit */

typedef struct entry {
    rti_hash how, content;
    rti_stamp stamp;
    bool stamped;
    rti_kept kept;
    size_t bytes;
    double seconds; /* it took to make */
} entry;

typedef struct store {
    pthread_mutex_t lock;
    uint32_t count;
    entry entries[ENTRIES]; /* the last used first */
} store;

static rti_kept retain(rti_kept kept)
{
    rti_chunk_retain(kept.texture);
    if (kept.model)
        atomic_fetch_add_explicit(&kept.model->refs, 1, memory_order_relaxed);
    return kept;
}

void rti_kept_release(rt_context *ctx, rti_kept kept)
{
    rti_kept_model *m = kept.model;
    rti_chunk_release(kept.texture);
    if (!m || atomic_fetch_sub_explicit(&m->refs, 1, memory_order_acq_rel) != 1)
        return;
    for (uint32_t i = 0; i < m->part_count; i++)
        rti_mesh_free(ctx, m->parts[i].mesh);
    rti_free(ctx, m, m->size);
}

/* Nothing is freed under the lock: releasing takes the chunks' lock. One at a time: this runs when memory is short, and on small
 * stacks. */
static bool drop(rt_context *ctx, void *data)
{
    store *s = data;
    bool some = false;
    for (;;) {
        rti_kept last = {NULL, NULL};
        pthread_mutex_lock(&s->lock);
        if (s->count > 0)
            last = s->entries[--s->count].kept;
        pthread_mutex_unlock(&s->lock);
        if (!last.texture && !last.model)
            return some;
        rti_kept_release(ctx, last);
        some = true;
    }
}

static void end(rt_context *ctx, void *data)
{
    store *s = data;
    drop(ctx, s);
    pthread_mutex_destroy(&s->lock);
    rti_free(ctx, s, sizeof *s);
}

/* NULL: no memory; then nothing is kept. */
static store *store_of(rt_context *ctx)
{
    static const rti_cache_kind kind = {end, drop};
    store *s = rti_context_cache(ctx, RTI_CACHE_FILES), *there;
    if (s)
        return s;
    s = rti_alloc_zero(ctx, sizeof *s);
    if (!s)
        return NULL;
    pthread_mutex_init(&s->lock, NULL);
    there = rti_context_set_cache(ctx, RTI_CACHE_FILES, s, &kind);
    if (there != s)
        end(ctx, s);
    return there;
}

static bool same_file(const entry *e, const rti_kept_file *file)
{
    return file->stamped && e->stamped && e->stamp.settled && rti_stamp_equal(&e->stamp, &file->stamp);
}

/* With bytes: by content; then the entry learns the file's present stamp. */
static bool find(rti_kept_file *file, rti_kept *kept)
{
    store *s = store_of(file->ctx);
    bool found = false;
    if (!s)
        return false;
    pthread_mutex_lock(&s->lock);
    for (uint32_t i = 0; i < s->count && !found; i++) {
        entry e = s->entries[i];
        if (!rti_hash_equal(e.how, file->how) || !(file->bytes ? rti_hash_equal(e.content, file->content) : same_file(&e, file)))
            continue;
        if (file->bytes) {
            e.stamp = file->stamp;
            e.stamped = file->stamped;
        }
        memmove(s->entries + 1, s->entries, i * sizeof *s->entries);
        s->entries[0] = e;
        *kept = retain(e.kept);
        rti_context_count(file->ctx, RTI_WORK_FILES_KEPT, 1);
        rti_context_time(file->ctx, RTI_WORK_SAVED_NS, e.seconds);
        found = true;
    }
    pthread_mutex_unlock(&s->lock);
    return found;
}

static rti_hash content_hash(const rti_kept_file *file)
{
    uint64_t size = file->size;
    rti_hasher h;
    rti_hasher_init(&h);
    rti_hasher_add(&h, &size, sizeof size);
    rti_hasher_add(&h, file->bytes, file->size);
    return rti_hasher_end(&h);
}

/* The file is open. */
static rt_status begin(rti_kept_file *file, rti_input *in, rti_kept *kept)
{
    rt_status status;
    file->stamp = in->stamp;
    file->stamped = in->stamped;
    if (file->stamped && find(file, kept))
        return RT_OK;
    status = rti_input_read(file->ctx, in, &file->bytes, &file->size);
    if (status != RT_OK)
        return status;
    file->stamped = in->stamped;
    file->content = content_hash(file);
    if (find(file, kept))
        rti_kept_end(file);
    return RT_OK;
}

rt_status rti_kept_begin(rti_kept_file *file, rt_context *ctx, const char *path, rti_hash how, rti_kept *kept)
{
    rti_input in;
    rt_status status;
    memset(file, 0, sizeof *file);
    file->ctx = ctx;
    file->how = how;
    file->began = rti_now();
    *kept = (rti_kept){NULL, NULL};
    status = rti_input_open(ctx, path, &in);
    if (status != RT_OK)
        return status;
    status = begin(file, &in, kept);
    rti_input_close(&in);
    return status;
}

/* The store's limit: makes room at the end for `bytes` more. Returns an entry that has to go, empty when none does. Under the
 * lock. */
static rti_kept make_room(store *s, uint64_t bytes, uint64_t limit)
{
    uint64_t sum = bytes;
    for (uint32_t i = 0; i < s->count; i++)
        sum += s->entries[i].bytes;
    if (s->count > 0 && (sum > limit || s->count == ENTRIES))
        return s->entries[--s->count].kept;
    return (rti_kept){NULL, NULL};
}

void rti_kept_put(rti_kept_file *file, rti_kept kept, size_t kept_bytes)
{
    rt_context *ctx = file->ctx;
    store *s = store_of(ctx);
    uint64_t limit = rti_context_memory_limit(ctx) / 4;
    double seconds = rti_now() - file->began;
    bool done = false;
    rti_context_count(ctx, RTI_WORK_FILES_READ, 1);
    rti_context_time(ctx, RTI_WORK_READ_NS, seconds);
    limit = limit && limit < KEPT_BYTES ? limit : KEPT_BYTES;
    if (!s || kept_bytes > limit)
        return;
    while (!done) {
        rti_kept old;
        pthread_mutex_lock(&s->lock);
        old = make_room(s, kept_bytes, limit);
        done = !old.texture && !old.model;
        if (done) {
            memmove(s->entries + 1, s->entries, s->count++ * sizeof *s->entries);
            s->entries[0] = (entry){.how = file->how,
                                    .content = file->content,
                                    .stamp = file->stamp,
                                    .stamped = file->stamped,
                                    .kept = retain(kept),
                                    .bytes = kept_bytes,
                                    .seconds = seconds};
        }
        pthread_mutex_unlock(&s->lock);
        rti_kept_release(ctx, old);
    }
}

void rti_kept_end(rti_kept_file *file)
{
    rti_free(file->ctx, file->bytes, file->size + 1);
    file->bytes = NULL;
}
