/* Chunks: immutable, reference-counted, content-hashed blocks of a snapshot, shared within a context by their hash. */
#ifndef RTI_CHUNK_H
#define RTI_CHUNK_H

#include "../base/base.h"
#include "../kernel/snapshot.h"

/* hash: of the content; of a tree: of what it was built from (its bytes follow from that, but for the build's time). */
typedef struct rti_chunk {
    rt_context *ctx;
    struct rti_chunk *next; /* in the cache's bucket */
    void *data;
    size_t size;
    rti_hash hash;
    uint32_t kind; /* RTK_CHUNK_* */
    atomic_uint refs;
} rti_chunk;

/* Takes over data (size bytes of rti_alloc, freed on failure too) and gives the chunk of that content: the context's own when
 * there is one already (*shared true). key: NULL, or the hash to know it by (trees). NULL: no memory. */
rti_chunk *rti_chunk_share(rt_context *ctx, uint32_t kind, void *data, size_t size, const rti_hash *key, bool *shared);
/* The context's chunk of that kind and hash with a reference more, or NULL. */
rti_chunk *rti_chunk_find(rt_context *ctx, uint32_t kind, rti_hash hash);
rti_chunk *rti_chunk_retain(rti_chunk *chunk); /* NULL gives NULL */
void rti_chunk_release(rti_chunk *chunk);      /* NULL is fine */

/* The cache holds the chunk on within its bound, as the last used one. */
void rti_chunk_keep(rti_chunk *chunk);
/* Lets go of all it holds; false: it held nothing. For when memory is short. */
bool rti_chunk_drop_kept(rt_context *ctx);

static inline const void *rti_chunk_at(const rti_chunk *chunk, uint64_t offset)
{
    return (const uint8_t *)chunk->data + offset;
}

/* A new chunk's bytes while it is laid out: sizes are summed first, then the block is made (zeroed), then filled. */
typedef struct rti_layout {
    size_t size;
    bool overflow;
} rti_layout;
void rti_layout_begin(rti_layout *layout, size_t header);
/* Offset (64-byte aligned) of the next array of count items; 0 when count is 0 (absent). */
uint64_t rti_layout_add(rti_layout *layout, size_t count, size_t item);

#endif
