/* Reading a snapshot file, which may come from anyone. */
#include "blob.h"

#include <string.h>

#include "../trace/trace.h"

typedef struct read_state {
    rt_context *ctx;
    const char *name;
    const uint8_t *bytes;
    size_t size;
    bool check_hashes;
    rti_blob_header head;
    const rti_blob_entry *entries;
    rti_snapshot *snapshot;
} read_state;

static rt_status broken(const read_state *r, const char *what)
{
    char name[512];
    return rti_fail(r->ctx, RT_ERROR_FORMAT, "%s: the snapshot is broken: %s",
                    rti_quote(name, sizeof name, r->name, strlen(r->name)), what);
}

static rt_status read_header(read_state *r)
{
    char name[512];
    const rti_blob_header *h = &r->head;
    rti_quote(name, sizeof name, r->name, strlen(r->name));
    if (r->size < sizeof *h || memcmp(r->bytes, RTI_BLOB_MAGIC, 8) != 0)
        return rti_fail(r->ctx, RT_ERROR_FORMAT, "%s: this is no snapshot file of librt (rt_scene_save writes them)", name);
    memcpy(&r->head, r->bytes, sizeof r->head);
    if (h->order != RTI_BLOB_ORDER)
        return rti_fail(r->ctx, RT_ERROR_UNSUPPORTED,
                        "%s: the snapshot was written for the other byte order; save it again on this machine", name);
    if (h->version != RTI_BLOB_VERSION)
        return rti_fail(r->ctx, RT_ERROR_UNSUPPORTED,
                        "%s: the snapshot has version %u, this library reads version %u; save it again", name, h->version,
                        RTI_BLOB_VERSION);
    if (h->file_size != r->size)
        return rti_fail(r->ctx, RT_ERROR_FORMAT,
                        "%s: the file has %llu bytes, its header says %llu; it is cut or was appended to", name,
                        (unsigned long long)r->size, (unsigned long long)h->file_size);
    if (h->chunk_count > (r->size - sizeof *h) / sizeof *r->entries || h->group_count == 0 || h->group_count > h->chunk_count ||
        h->texture_count > h->chunk_count)
        return broken(r, "a count is larger than the file");
    r->entries = (const rti_blob_entry *)(const void *)(r->bytes + sizeof *h);
    if (r->check_hashes && !rti_hash_equal(rti_blob_hash(h, r->entries), h->hash))
        return broken(r, "the hash of its table is wrong");
    return RT_OK;
}

static size_t header_size(uint32_t kind)
{
    static const size_t size[] = {0,
                                  sizeof(rtk_group_header),
                                  sizeof(rtk_tree_header),
                                  RTI_ATTRIBUTE_HEADER,
                                  sizeof(rtk_geometry_header),
                                  sizeof(rtk_top_header),
                                  sizeof(rtk_material_header),
                                  sizeof(rtk_texture_header),
                                  sizeof(rtk_light_header),
                                  sizeof(rtk_world)};
    return kind < RTI_COUNT(size) ? size[kind] : 0;
}

/* Where a chunk belongs, or NULL. Its header is known to be there. textures: how many have come. */
static rti_chunk **place_of(const read_state *r, const rti_blob_entry *e, uint32_t *textures)
{
    rti_snapshot *s = r->snapshot;
    const rtk_tree_header *tree = (const rtk_tree_header *)(const void *)(r->bytes + e->offset);
    rti_part_group *g = e->group < s->group_count ? &s->groups[e->group] : NULL;
    if (e->kind == RTK_CHUNK_TREE) {
        if (tree->kind == RTK_TREE_NONE || tree->kind >= RTI_TREE_KINDS)
            return NULL;
        if (g)
            return e->part < RTK_PARTS ? &g->tree[e->part][tree->kind] : NULL;
        return e->group == RTK_INVALID ? &s->top_tree[tree->kind] : NULL;
    }
    if (g)
        return e->kind == RTK_CHUNK_GROUP
                   ? &g->group
                   : (e->kind == RTK_CHUNK_ATTRIBUTE ? &g->attribute : (e->kind == RTK_CHUNK_GEOMETRY ? &g->geometry : NULL));
    if (e->group != RTK_INVALID)
        return NULL;
    if (e->kind == RTK_CHUNK_TEXTURE)
        return *textures < s->texture_count ? &s->textures[(*textures)++] : NULL;
    return e->kind == RTK_CHUNK_TOP
               ? &s->top
               : (e->kind == RTK_CHUNK_MATERIAL
                      ? &s->materials
                      : (e->kind == RTK_CHUNK_LIGHT ? &s->lights : (e->kind == RTK_CHUNK_WORLD ? &s->world : NULL)));
}

static rt_status read_chunk(read_state *r, const rti_blob_entry *e, rti_chunk **place)
{
    void *data;
    bool shared;
    if (r->check_hashes && !rti_hash_equal(rti_hash_bytes(r->bytes + e->offset, e->size), e->hash))
        return broken(r, "the hash of a chunk is wrong");
    data = rti_alloc(r->ctx, e->size);
    if (!data)
        return rti_fail_memory(r->ctx, "rt_scene_load", e->size);
    memcpy(data, r->bytes + e->offset, e->size);
    *place = rti_chunk_share(r->ctx, e->kind, data, e->size, NULL, &shared);
    return *place ? RT_OK : rti_fail_memory(r->ctx, "rt_scene_load", sizeof **place);
}

static rt_status read_chunks(read_state *r)
{
    uint64_t end = sizeof r->head + r->head.chunk_count * sizeof *r->entries;
    uint32_t textures = 0;
    rt_status status = RT_OK;
    for (uint32_t i = 0; i < r->head.chunk_count && status == RT_OK; i++) {
        const rti_blob_entry *e = &r->entries[i];
        size_t least = header_size(e->kind);
        rti_chunk **place;
        if (e->offset < end || e->offset % 64 != 0 || e->offset > r->size || e->size > r->size - e->offset)
            return broken(r, "a chunk lies outside the file or over another");
        if (least == 0 || e->size < least)
            return broken(r, "a chunk is of no known kind or shorter than its header");
        end = e->offset + e->size;
        place = place_of(r, e, &textures);
        if (!place || *place)
            return broken(r, "a chunk belongs nowhere or comes twice");
        status = read_chunk(r, e, place);
        if (e->kind == RTK_CHUNK_GEOMETRY)
            r->snapshot->groups[e->group].material_base = e->material_base;
    }
    return status;
}

static const char *missing(const rti_snapshot *s)
{
    for (uint32_t i = 0; i < s->group_count; i++) {
        if (!s->groups[i].group || !s->groups[i].geometry)
            return "a group has no geometry";
    }
    for (uint32_t i = 0; i < s->texture_count; i++) {
        if (!s->textures[i])
            return "a texture is missing";
    }
    return s->top && s->materials && s->lights && s->world ? NULL : "the materials, lights, camera or instances are missing";
}

static const char *check(const rti_snapshot *s)
{
    const char *what = missing(s);
    if (!what)
        what = rti_blob_check(s);
    for (uint32_t i = 0; !what && i < s->group_count; i++)
        what = rti_blob_check_group(s, i);
    return what;
}

rt_status rti_blob_decode(rt_context *ctx, const char *name, const void *bytes, size_t size, bool check_hashes,
                          rti_snapshot **out)
{
    static const char *const tracers[] = {"brute", "kdtree", "octree", "bvh"}; /* by RTK_TREE_* */
    read_state r = {.ctx = ctx, .name = name, .bytes = bytes, .size = size, .check_hashes = check_hashes};
    const char *what;
    uint32_t tree;
    rt_status status = read_header(&r);
    if (status != RT_OK)
        return status;
    r.snapshot = rti_snapshot_new(ctx, r.head.group_count, r.head.texture_count);
    if (!r.snapshot)
        return rti_fail_memory(ctx, "rt_scene_load", r.head.group_count * sizeof(rti_part_group));
    r.snapshot->auto_builder = true;
    status = read_chunks(&r);
    if (status == RT_OK && (what = check(r.snapshot)) != NULL)
        status = broken(&r, what);
    tree = r.head.tracer_tree;
    if (status == RT_OK && (tree >= RTI_TREE_KINDS || !rti_snapshot_complete(r.snapshot, tree)))
        status = broken(&r, "the trees that its tracer walks are missing");
    if (status == RT_OK)
        status = rti_snapshot_finish(r.snapshot, "rt_scene_load");
    if (status != RT_OK) {
        rti_snapshot_release(r.snapshot);
        return status;
    }
    r.snapshot->tracer = rti_tracer_find(rti_context_isa(ctx), tracers[tree]);
    *out = r.snapshot;
    return RT_OK;
}

rt_status rt_scene_load(rt_context *context, const char *path, rt_scene **scene)
{
    RTI_NEED_TO_MAKE(scene, context);
    rti_snapshot *snapshot = NULL;
    rti_fpenv env;
    void *bytes;
    size_t size;
    rt_status status;
    if (!scene)
        return rti_fail(context, RT_ERROR_ARGUMENT, "rt_scene_load: scene is NULL; give the place for the new scene");
    *scene = NULL;
    if (!path)
        return rti_fail(context, RT_ERROR_ARGUMENT, "rt_scene_load: path is NULL; give the name of a snapshot file");
    status = rti_file_read(context, path, 0, &bytes, &size);
    if (status != RT_OK)
        return status;
    env = rti_fp_enter();
    status = rti_blob_decode(context, path, bytes, size, true, &snapshot);
    rti_fp_leave(env);
    rti_free(context, bytes, size + 1);
    if (status != RT_OK)
        return status;
    status = rt_scene_create(context, scene);
    if (status != RT_OK) {
        rti_snapshot_release(snapshot);
        return status;
    }
    (*scene)->loaded = true;
    rti_cell_replace(&(*scene)->cell, snapshot);
    return RT_OK;
}
