/* The lowest floor: memory, messages, threads, clock, files, numbers. All operating-system code of the library stands in base/.
 */
#ifndef RTI_BASE_H
#define RTI_BASE_H

#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "fpenv.h"
#include "librt/base.h"

#if defined(__GNUC__)
#define RTI_PRINTF(a, b) __attribute__((format(printf, a, b)))
#define RTI_UNUSED       __attribute__((unused))
#else
#define RTI_PRINTF(a, b)
#define RTI_UNUSED
#endif
#define RTI_COUNT(a)   (sizeof(a) / sizeof((a)[0]))
#define RTI_CACHE_LINE 64u

/* ---- memory (memory.c): every byte goes through the context's hook and is counted against its limit ---- */

/* NULL when the hook says no, the limit is passed or the size overflows; no message is set (the caller knows what it wanted):
 * use rti_fail_memory. Zero-size requests are made 1. Blocks are 64-byte aligned. size in free must be the size asked for. */
void *rti_alloc(rt_context *ctx, size_t size);
void *rti_alloc_zero(rt_context *ctx, size_t size);
void *rti_alloc_array(rt_context *ctx, size_t count, size_t size); /* checks the product */
void *rti_alloc_spare(rt_context *ctx, size_t size); /* for what may be done without: nothing that is kept for later makes way */
void *rti_realloc(rt_context *ctx, void *ptr, size_t old_size, size_t new_size);
/* What is behind new_size, which is not 0, goes back; where the hook can, the rest stays in place. NULL: it refused, and all is as it was. */
void *rti_shrink(rt_context *ctx, void *ptr, size_t old_size, size_t new_size);
void rti_free(rt_context *ctx, void *ptr, size_t size); /* NULL is fine */

/* A block of `size` bytes, the same in all calls, that a thread works in while it is in a query, and gives back before it returns
 * (room.c). The context keeps it for the next; used: it holds what the one before left there. NULL: no memory is left beside what is
 * kept; the query then does without. Any thread. */
void *rti_room_take(rt_context *ctx, size_t size, bool *used);
void rti_room_give(rt_context *ctx, void *room, size_t size); /* NULL is fine */
/* Blocks that renders need again and again: the working memory of workers (as many are kept as the context has workers) and
 * pixels (those of one picture), of RTI_KEPT_LEAST to RTI_KEPT_MOST bytes. take: any content; NULL as rti_alloc; *size becomes
 * that of a larger one that is kept, up to `most` where memory is not limited; used: its pages are there already. Any thread. */
enum { RTI_KEPT_WORK = 0, RTI_KEPT_PICTURE };
#define RTI_KEPT_LEAST ((size_t)1 << 20)
#define RTI_KEPT_MOST  ((size_t)256 << 20)
void *rti_kept_take(rt_context *ctx, uint32_t kind, size_t *size, size_t most, bool *used);
void rti_kept_give(rt_context *ctx, uint32_t kind, void *block, size_t size); /* NULL is fine; size as it was taken */

/* Growing array: used by `rti_array_push`-style code: makes room for `more` further items; doubles. false: no memory. */
bool rti_reserve(rt_context *ctx, void **data, size_t *capacity, size_t count, size_t more, size_t item_size);

bool rti_mul_size(size_t a, size_t b, size_t *out); /* false on overflow */
bool rti_add_size(size_t a, size_t b, size_t *out);

/* Bump arena for things that die together (builders, parsers). Not thread-safe: one a thread. */
typedef struct rti_arena_block rti_arena_block;
typedef struct rti_arena {
    rt_context *ctx;
    rti_arena_block *head;
    size_t block_size;
} rti_arena;
void rti_arena_init(rti_arena *arena, rt_context *ctx, size_t block_size);
void *rti_arena_alloc(rti_arena *arena, size_t size); /* 16-byte aligned, NULL when out of memory */
void rti_arena_fini(rti_arena *arena);

/* ---- messages (error.c) ---- */

/* Sets the calling thread's message and returns status: `return rti_fail(ctx, RT_ERROR_ARGUMENT, "rt_scene_add_sphere: radius is
 * %g; it must be a positive number", r);`. Numbers are printed in the C locale's way: use rti_num for floats. */
rt_status rti_fail(rt_context *ctx, rt_status status, const char *format, ...) RTI_PRINTF(3, 4);
rt_status rti_fail_v(rt_context *ctx, rt_status status, const char *format, va_list args) RTI_PRINTF(3, 0);
/* "WHAT: N bytes could not be had" with MEMORY or, when the limit is the reason, MEMORY_LIMIT with the numbers. */
rt_status rti_fail_memory(rt_context *ctx, const char *what, size_t size);
/* Likewise where there is no context to keep the sentence: rt_context_error(NULL). */
rt_status rti_fail_alone(rt_status status, const char *format, ...) RTI_PRINTF(2, 3);
/* First in a public call that gives a status: a handle that it cannot do without; made: what the call makes becomes NULL then. */
#define RTI_NEED(handle)                                                                                                         \
    do {                                                                                                                         \
        if (!(handle))                                                                                                           \
            return rti_fail_alone(RT_ERROR_ARGUMENT, "%s: %s is NULL", __func__, #handle);                                       \
    } while (0)
#define RTI_NEED_TO_MAKE(made, handle)                                                                                           \
    do {                                                                                                                         \
        if (!(handle) && (made))                                                                                                 \
            *(made) = NULL;                                                                                                      \
        RTI_NEED(handle);                                                                                                        \
    } while (0)
void rti_log(rt_context *ctx, rt_log_level level, const char *format, ...) RTI_PRINTF(3, 4);

/* Checks the first field of a descriptor and copies what the caller's version knows over the defaults in `full` (size full_size).
 * Returns RT_OK or ARGUMENT with a sentence naming `what`. */
rt_status rti_desc_take(rt_context *ctx, const char *what, const void *desc, void *full, uint32_t full_size);

/* ---- threads (pool.c) ---- */

#define RTI_PARALLEL_MOST 0x7fffffffu
/* Runs task(data, i) for every i in [0, count), RTI_PARALLEL_MOST at most, on the context's workers (or the host's tasks) and
 * returns when all are done. The calling thread takes part. Nested calls are allowed and run without deadlock. Tasks get no order;
 * results must not depend on it. */
void rti_parallel(rt_context *ctx, uint32_t count, void (*task)(void *data, uint32_t index), void *data);

/* Cancellation: builders and loops poll it. NULL means never. */
typedef struct rti_cancel {
    atomic_bool asked;
} rti_cancel;
static inline bool rti_cancelled(rti_cancel *c)
{
    return c && atomic_load_explicit(&c->asked, memory_order_relaxed);
}

/* Makes sure that the context's own threads run. RT_ERROR_THREAD when the system gives none at all (fewer than asked is a warning
 * in the log). A context with a task hook or one worker needs none. */
rt_status rti_pool_start(rt_context *ctx);

/* Work that goes on behind the caller's back (render jobs): `count` of the context's threads call run(data, i), i in [0, count).
 * threads receives a handle (errors MEMORY, THREAD); join waits for all and frees it. Threads are new ones, so a job never waits for a
 * build in the pool. */
typedef struct rti_threads rti_threads;
rt_status rti_threads_start(rt_context *ctx, uint32_t count, void (*run)(void *data, uint32_t index), void *data,
                            rti_threads **threads);
void rti_threads_join(rt_context *ctx, rti_threads *threads); /* NULL is fine */

/* Objects of the scene floor that live as long as the context. get returns NULL until one was set. */
enum { RTI_CACHE_CHUNKS = 0, RTI_CACHE_FILES, RTI_CACHE_COUNT };
typedef struct rti_cache_kind {
    void (*end)(rt_context *ctx, void *cache); /* by rt_context_destroy, the last slot first */
    /* An allocation was refused: let go of what nobody uses; false: there is nothing. Any thread, under any lock but the cache's own,
     * which is why nothing may be allocated under that. */
    bool (*drop)(rt_context *ctx, void *cache);
} rti_cache_kind;
void *rti_context_cache(rt_context *ctx, uint32_t slot);
/* Sets it unless one is there already; returns the one that is there now. */
void *rti_context_set_cache(rt_context *ctx, uint32_t slot, void *cache, const rti_cache_kind *kind);

/* Lets go of some of what is only kept for later; false: there was nothing. rti_alloc does it by itself, until there is room. */
bool rti_context_relieve(rt_context *ctx);
/* Bytes that the machine has free, by rt_memory_available: what is kept is given up while they are fewer than wanted. */
uint64_t rti_context_spare(rt_context *ctx, uint64_t bytes, uint64_t (*available)(void));

/* What rt_context_work tells. Times are counted in nanoseconds. */
enum {
    RTI_WORK_FILES_READ = 0,
    RTI_WORK_FILES_KEPT,
    RTI_WORK_TREES_BUILT,
    RTI_WORK_TOPS_BUILT,
    RTI_WORK_TREES_KEPT,
    RTI_WORK_TREES_REFITTED,
    RTI_WORK_READ_NS,
    RTI_WORK_BUILD_NS,
    RTI_WORK_SAVED_NS,
    RTI_WORK_COUNT
};
void rti_context_count(rt_context *ctx, uint32_t what, uint64_t amount);
void rti_context_time(rt_context *ctx, uint32_t what, double seconds);

/* The host's task hook is in use: jobs are then driven by the thread that waits. */
bool rti_context_has_tasks(const rt_context *ctx);
uint64_t rti_context_memory_limit(const rt_context *ctx); /* 0: none */

/* ---- clock, machine (os.c) ---- */
double rti_now(void);        /* seconds, monotonic */
double rti_thread_cpu(void); /* CPU seconds of the calling thread */
uint64_t rti_core_cache(void); /* bytes of the cache that a core has to itself (level 2); 0: not known */
bool rti_context_roomy(const rt_context *ctx); /* is that a MiB or more? as it was told when the context was made */
void rti_sleep(double seconds);
/* malloc; a block of 2 MiB and more lies in huge pages where the system has them. The last of them may hold up to 2 MiB that
 * nobody asked for, a third of the block at most. For free and realloc. */
void *rti_alloc_large(size_t size);
/* Has the system give the huge pages of two such blocks (the first a_size, b_size bytes of them) now, a task each; a byte of each is
 * overwritten. Of what workers will write together: they would come to a page at once, and all clear one for it, of which but one is
 * thrown away. Fewer than four workers seldom do, and nothing is done. */
void rti_touch_large(rt_context *ctx, void *a, size_t a_size, void *b, size_t b_size);
/* What stands in a block will be read for long: its pages that are small, as the memory was somebody's before, become huge ones now,
 * where the system can (Linux 6.1). Nothing else changes, whoever gave the memory. */
void rti_settle_large(const void *block, size_t size);

/* ---- files (file.c); paths are bytes ---- */

/* Whole file into one block (64-aligned, *size + 1 bytes allocated, a NUL behind the last). Refuses directories, devices that
 * never end, and more than `limit` bytes (0: none). The message names the path and the reason. Free with rti_free(ctx, data, size
 * + 1). */
rt_status rti_file_read(rt_context *ctx, const char *path, uint64_t limit, void **data, size_t *size);

/* A file read in pieces, for those that do not fit the memory: regular files alone. */
typedef struct rti_reader rti_reader;
rt_status rti_reader_open(rt_context *ctx, const char *path, rti_reader **reader);
uint64_t rti_reader_size(const rti_reader *reader);
/* Exactly `size` bytes from `offset`; IO when the file has no such bytes (any more). */
rt_status rti_reader_read(rti_reader *reader, uint64_t offset, void *to, size_t size);
void rti_reader_close(rti_reader *reader); /* NULL is fine */

/* What tells one state of a file from another without its bytes. settled: it was so old when it was looked at that any later change shows
 * in it (clocks of file systems tick in steps; a file that was written a moment ago may be written again within the same one). */
typedef struct rti_stamp {
    uint64_t device, inode, size;
    int64_t changed, modified; /* nanoseconds since 1970: of the inode, of the content */
    bool settled;
} rti_stamp;
bool rti_stamp_equal(const rti_stamp *a, const rti_stamp *b); /* settled is not compared */

/* A regular file, open: looked at first, read whole where that does not tell enough. Errors and data as rti_file_read. */
typedef struct rti_input {
    const char *path; /* the caller's */
    int fd;
    bool stamped; /* false: nothing is known, or it changed while it was read */
    rti_stamp stamp;
} rti_input;
rt_status rti_input_open(rt_context *ctx, const char *path, rti_input *in);
rt_status rti_input_read(rt_context *ctx, rti_input *in, void **data, size_t *size);
void rti_input_close(rti_input *in); /* once, after an open that went well */

/* A file that the library makes itself and goes on with, on any thread: the context's open hook is asked once, for its folder. */
typedef struct rti_writer rti_writer;
typedef struct rti_place {
    rt_context *ctx;
    char *path;
    size_t size;
    const char *target; /* path, or its last part in the hook's folder */
    int folder;
    bool given; /* by a hook: links there are not followed */
} rti_place;
rt_status rti_place_open(rt_context *ctx, const char *path, rti_place *place);
void rti_place_close(rti_place *place);        /* one of zeros is fine */
bool rti_place_there(const rti_place *place);  /* something of that name exists, or cannot be looked at */
void rti_place_remove(const rti_place *place); /* nothing is said when it cannot be */
rt_status rti_place_read(const rti_place *place, rti_reader **reader);
/* As rti_writer_open. */
rt_status rti_place_write(const rti_place *place, rti_writer **writer);
/* Makes the file `offset` bytes long (it is made when it is not there) and puts `size` bytes behind them, on disk when it returns. */
rt_status rti_place_append(const rti_place *place, uint64_t offset, const void *data, size_t size);

/* Writes beside the target and renames when all is on disk: a reader sees the old file or the new, never a part. */
rt_status rti_writer_open(rt_context *ctx, const char *path, rti_writer **writer); /* path "-": standard output */
rt_status rti_writer_write(rti_writer *writer, const void *data, size_t size);     /* first error is kept and returned again */
rt_status rti_writer_close(rti_writer *writer, bool keep); /* keep false, or an error before: the target is untouched */

/* ---- compressed bytes (inflate.c) ---- */

/* Unpacks a zlib stream (RFC 1950) of hostile origin into a new block of *capacity bytes, *size of them and a NUL behind used. Returns NULL (and a
 * block), or what is wrong with it; "" when memory is missing. More than `limit` bytes are wrong too. */
const char *rti_inflate(rt_context *ctx, const uint8_t *in, size_t in_size, size_t limit, uint8_t **out, size_t *size,
                        size_t *capacity);

/* ---- numbers and text (text.c); independent of the locale ---- */

/* Parses a float at *s (decimal, exponent, no hex, no inf/nan), correctly rounded to double; advances *s. false: no number there.
 */
bool rti_parse_double(const char **s, const char *end, double *out);
bool rti_parse_int(const char **s, const char *end, int64_t *out); /* false on overflow too */
/* Shortest text that reads back as the same float; buffer of at least 32. Returns buffer. */
const char *rti_num(char *buffer, float x);
const char *rti_num_double(char *buffer, double x);
/* The name in names[count] nearest to `word` (edit distance <= 1 + length / 3), or NULL. */
const char *rti_nearest(const char *word, const char *const *names, size_t count);
/* Length-limited, escaped copy of foreign text for a message (control bytes and invalid UTF-8 become \xNN). Returns buffer. */
const char *rti_quote(char *buffer, size_t size, const char *text, size_t length);

/* ---- hashing (hash.c) ---- */

/* 128-bit content hash, the same on every machine (input bytes little-endian). Streaming. Not cryptographic. */
typedef struct rti_hash {
    uint64_t lo, hi;
} rti_hash;
typedef struct rti_hasher {
    uint64_t a, b, length;
    uint8_t tail[16];
    uint32_t tail_count;
} rti_hasher;
void rti_hasher_init(rti_hasher *h);
void rti_hasher_add(rti_hasher *h, const void *data, size_t size);
rti_hash rti_hasher_end(rti_hasher *h);
rti_hash rti_hash_bytes(const void *data, size_t size);
static inline bool rti_hash_equal(rti_hash a, rti_hash b)
{
    return a.lo == b.lo && a.hi == b.hi;
}
const char *rti_hash_text(char buffer[33], rti_hash hash); /* 32 hex digits */

#endif
