/* A snapshot in one file: little-endian, versioned, hashed. All offsets are from the file's start; chunks stand at multiples
 * of 64.
 *
 *   rti_blob_header | rti_blob_entry[chunk_count] | chunks, in the order of the entries
 *
 * Chunks are the bytes of kernel/snapshot.h, a tree's with build_seconds zeroed: the same scene gives the same file. Entries come
 * in the order of rti_snapshot_each. Each entry holds its chunk's hash; the header holds the hash of itself (with zeros there)
 * and the entries.
 */
#ifndef RTI_BLOB_H
#define RTI_BLOB_H

#include "parts.h"

#define RTI_BLOB_MAGIC   "librtsnp"
#define RTI_BLOB_VERSION 10u
#define RTI_BLOB_ORDER   0x01020304u /* reads otherwise on a machine of the other byte order */

typedef struct rti_blob_header {
    char magic[8];
    uint32_t version, order;
    uint64_t file_size;
    uint32_t chunk_count, group_count, texture_count;
    uint32_t tracer_tree; /* RTK_TREE_* that queries walked */
    rti_hash hash;
    uint32_t pad[2];
} rti_blob_header;

typedef struct rti_blob_entry {
    uint32_t kind, group;   /* RTK_CHUNK_*; RTK_INVALID: of no group */
    uint32_t material_base; /* of GEOMETRY chunks: where the group's materials start */
    uint32_t part;          /* of TREE chunks of a group: which part of it they are over */
    uint64_t offset, size;
    rti_hash hash;
} rti_blob_entry;

_Static_assert(sizeof(rti_blob_header) == 64 && sizeof(rti_blob_entry) == 48, "the file's layout");

rti_hash rti_blob_hash(const rti_blob_header *header, const rti_blob_entry *entries);

/* A snapshot from a file's bytes, which are not trusted. name: for messages. check_hashes false is for fuzzing alone: everything
 * else is still checked. Errors FORMAT, UNSUPPORTED (version, byte order), MEMORY. */
rt_status rti_blob_decode(rt_context *ctx, const char *name, const void *bytes, size_t size, bool check_hashes,
                          rti_snapshot **out);

/* ---- checks of chunks (blob_check*.c): NULL when all is well, else what is wrong, as the end of a sentence ---- */
const char *rti_blob_check(const rti_snapshot *snapshot); /* all but attributes, geometry and trees */
const char *rti_blob_check_group(const rti_snapshot *snapshot, uint32_t group);
/* Is the array of count items at offset inside the chunk, behind its header, aligned? count 0: any offset. */
bool rti_blob_span(const rti_chunk *chunk, size_t header, uint64_t offset, uint64_t count, size_t item);
bool rti_blob_finite(const float *x, size_t count, float most); /* all numbers, none larger */

#endif
