/* Writing a snapshot to one file. */
#include "blob.h"

#include <string.h>

typedef struct write_state {
    rti_blob_entry *entries;
    const rti_chunk **chunks;
    uint32_t count;
    uint64_t offset;
    const rti_snapshot *snapshot;
} write_state;

static void count_chunks(void *data, const rti_chunk *chunk, uint32_t group)
{
    (void)chunk;
    (void)group;
    ++*(uint32_t *)data;
}

/* The head of a tree as it is written: without the time its build took. Other chunks: all of them are written as they are. */
static size_t written_head(const rti_chunk *chunk, rtk_tree_header *head)
{
    if (chunk->kind != RTK_CHUNK_TREE)
        return 0;
    memcpy(head, chunk->data, sizeof *head);
    head->build_seconds = 0.0f;
    return sizeof *head;
}

static rti_hash written_hash(const rti_chunk *chunk)
{
    rtk_tree_header head;
    size_t n = written_head(chunk, &head);
    rti_hasher h;
    rti_hasher_init(&h);
    rti_hasher_add(&h, &head, n);
    rti_hasher_add(&h, rti_chunk_at(chunk, n), chunk->size - n);
    return rti_hasher_end(&h);
}

static void put_entry(void *data, const rti_chunk *chunk, uint32_t group)
{
    write_state *w = data;
    rti_blob_entry *e = &w->entries[w->count];
    e->kind = chunk->kind;
    e->group = group;
    if (chunk->kind == RTK_CHUNK_GEOMETRY)
        e->material_base = w->snapshot->groups[group].material_base;
    if (chunk->kind == RTK_CHUNK_TREE && group != RTK_INVALID)
        e->part = rti_tree_part(&w->snapshot->groups[group], chunk);
    e->offset = w->offset;
    e->size = chunk->size;
    e->hash = written_hash(chunk);
    w->chunks[w->count++] = chunk;
    w->offset = (w->offset + chunk->size + 63u) & ~(uint64_t)63u;
}

rti_hash rti_blob_hash(const rti_blob_header *header, const rti_blob_entry *entries)
{
    rti_blob_header plain = *header;
    rti_hasher h;
    memset(&plain.hash, 0, sizeof plain.hash);
    rti_hasher_init(&h);
    rti_hasher_add(&h, &plain, sizeof plain);
    rti_hasher_add(&h, entries, header->chunk_count * sizeof *entries);
    return rti_hasher_end(&h);
}

static rti_blob_header make_header(const write_state *w)
{
    rti_blob_header head;
    memset(&head, 0, sizeof head);
    memcpy(head.magic, RTI_BLOB_MAGIC, sizeof head.magic);
    head.version = RTI_BLOB_VERSION;
    head.order = RTI_BLOB_ORDER;
    head.file_size = w->offset;
    head.chunk_count = w->count;
    head.group_count = w->snapshot->group_count;
    head.texture_count = w->snapshot->texture_count;
    head.tracer_tree = rti_snapshot_tree(w->snapshot);
    head.hash = rti_blob_hash(&head, w->entries);
    return head;
}

static rt_status write_all(const write_state *w, rti_writer *out)
{
    static const uint8_t zero[64] = {0};
    rti_blob_header head = make_header(w);
    uint64_t at = sizeof head + w->count * sizeof *w->entries;
    rt_status status = rti_writer_write(out, &head, sizeof head);
    if (status == RT_OK)
        status = rti_writer_write(out, w->entries, w->count * sizeof *w->entries);
    for (uint32_t i = 0; status == RT_OK && i <= w->count; i++) {
        uint64_t next = i < w->count ? w->entries[i].offset : w->offset;
        rtk_tree_header tree;
        size_t n;
        status = rti_writer_write(out, zero, (size_t)(next - at));
        if (i == w->count || status != RT_OK)
            break;
        n = written_head(w->chunks[i], &tree);
        status = rti_writer_write(out, &tree, n);
        if (status == RT_OK)
            status = rti_writer_write(out, rti_chunk_at(w->chunks[i], n), w->chunks[i]->size - n);
        at = next + w->chunks[i]->size;
    }
    return status;
}

static rt_status save(rti_snapshot *s, const char *path)
{
    rt_context *ctx = s->ctx;
    uint32_t count = 0;
    write_state w = {.snapshot = s};
    rti_writer *out;
    rt_status status;
    rti_snapshot_each(s, count_chunks, &count);
    w.offset = (sizeof(rti_blob_header) + count * sizeof *w.entries + 63u) & ~(uint64_t)63u;
    w.entries = rti_alloc_zero(ctx, count * sizeof *w.entries);
    w.chunks = rti_alloc_array(ctx, count, sizeof(rti_chunk *));
    if (w.entries && w.chunks) {
        rti_snapshot_each(s, put_entry, &w);
        status = rti_writer_open(ctx, path, &out);
        if (status == RT_OK) {
            rt_status written = write_all(&w, out);
            status = rti_writer_close(out, written == RT_OK);
            status = written != RT_OK ? written : status;
        }
    } else {
        status = rti_fail_memory(ctx, "rt_scene_save", count * sizeof *w.entries);
    }
    rti_free(ctx, w.entries, count * sizeof *w.entries);
    rti_free(ctx, w.chunks, count * sizeof(rti_chunk *));
    return status;
}

rt_status rt_scene_save(const rt_scene *scene, const char *path)
{
    RTI_NEED(scene);
    rti_snapshot *s;
    rt_status status;
    if (!path)
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "rt_scene_save: path is NULL; give the name of the file to write");
    s = rti_scene_snapshot(scene);
    if (!s)
        return rti_fail(scene->ctx, RT_ERROR_STATE, "rt_scene_save: the scene was never committed; call rt_scene_commit first");
    status = save(s, path);
    rti_snapshot_release(s);
    return status;
}
