/* Trees of a snapshot: found in the context or built. */
#include "parts.h"

#include <string.h>

#include "../kernel/shape_surface.h"

/* Above this many primitives "auto" bins: the exact builder takes more than half a second a core there. */
#define EXACT_LIMIT 131072u

static rti_build_settings settle(const rti_snapshot *s, uint32_t kind, uint32_t prim_count)
{
    rti_build_settings settings = s->settings;
    if (kind == RTK_TREE_OCTREE)
        settings.builder = RTI_BUILD_OCTREE;
    else if (s->auto_builder || settings.builder == RTI_BUILD_OCTREE)
        settings.builder = prim_count > EXACT_LIMIT ? RTI_BUILD_KD_BINNED : RTI_BUILD_KD_EXACT;
    return settings;
}

static rti_hash tree_key(rti_hash content, const rti_build_settings *s)
{
    uint32_t counts[3] = {s->builder, s->max_depth, s->leaf_size};
    float costs[4] = {s->cost_traverse, s->cost_intersect, s->empty_bonus, s->duplication};
    rti_hasher h;
    rti_hasher_init(&h);
    rti_hasher_add(&h, &content, sizeof content);
    rti_hasher_add(&h, counts, sizeof counts);
    rti_hasher_add(&h, costs, sizeof costs);
    return rti_hasher_end(&h);
}

typedef struct tree_job {
    rti_snapshot *snapshot;
    const char *call;
    rti_cancel *cancel;
} tree_job;

static bool found(const tree_job *job, rti_hash key, rti_chunk **out)
{
    *out = rti_chunk_find(job->snapshot->ctx, RTK_CHUNK_TREE, key);
    if (!*out)
        return false;
    job->snapshot->reused_chunks++;
    rti_chunk_keep(*out);
    return true;
}

static void rename_references(void *tree, const uint32_t *ids)
{
    rtk_tree_header *head = tree;
    uint32_t *refs = (uint32_t *)(void *)((uint8_t *)tree + head->off_refs);
    for (uint32_t i = 0; i < head->ref_count; i++)
        refs[i] = ids[refs[i]];
}

/* Builds one tree and shares it. ids: NULL, or what to call the boxes in its references. */
static rt_status build(const tree_job *job, const rti_build_input *input, const rti_build_settings *settings, rti_hash key,
                       const uint32_t *ids, rti_chunk **out)
{
    rt_context *ctx = job->snapshot->ctx;
    void *data;
    size_t size;
    bool shared;
    rt_status status = rti_tree_build(ctx, input, settings, job->cancel, &data, &size);
    if (status != RT_OK)
        return status;
    if (ids)
        rename_references(data, ids);
    *out = rti_chunk_share(ctx, RTK_CHUNK_TREE, data, size, &key, &shared);
    if (!*out)
        return rti_fail_memory(ctx, job->call, size);
    job->snapshot->built_trees++;
    rti_chunk_keep(*out);
    return RT_OK;
}

static rt_status group_tree(const tree_job *job, const rti_chunk *chunk, uint32_t kind, rti_chunk **out)
{
    rt_context *ctx = job->snapshot->ctx;
    const rtk_group_header *head = chunk->data;
    const rtk_shape *shapes = rti_chunk_at(chunk, head->off_shapes);
    rti_build_settings settings = settle(job->snapshot, kind, head->tri_count + head->shape_count);
    rti_hash key = tree_key(chunk->hash, &settings);
    rti_build_input input = {.tri_count = head->tri_count, .box_count = head->shape_count, .grow = RTK_GROW * head->scale};
    float(*boxes)[6];
    rt_status status;
    if (found(job, key, out))
        return RT_OK;
    boxes = rti_alloc_array(ctx, head->shape_count, sizeof *boxes);
    if (!boxes)
        return rti_fail_memory(ctx, job->call, head->shape_count * sizeof *boxes);
    for (uint32_t i = 0; i < head->shape_count; i++) {
        rtk_vec3 lo, hi;
        rtk_shape_bounds(&shapes[i], &lo, &hi);
        memcpy(boxes[i], (float[6]){lo.x, lo.y, lo.z, hi.x, hi.y, hi.z}, sizeof boxes[i]);
    }
    input.tris = head->tri_count ? rti_chunk_at(chunk, head->off_tris) : NULL;
    input.boxes = (const float(*)[6])boxes;
    memcpy(input.lo, head->lo, sizeof input.lo);
    memcpy(input.hi, head->hi, sizeof input.hi);
    status = build(job, &input, &settings, key, NULL, out);
    rti_free(ctx, boxes, head->shape_count * sizeof *boxes);
    return status;
}

/* ---- top level: built over the bounded instances, references turned back into instance ids ---- */

static bool in_tree(const rtk_instance *inst)
{
    return inst->lo[0] <= inst->hi[0] && !(inst->flags & RTK_INST_UNBOUNDED);
}

static rti_hash boxes_hash(const float (*boxes)[6], const uint32_t *ids, uint32_t count, const rtk_top_header *head)
{
    rti_hasher h;
    rti_hasher_init(&h);
    rti_hasher_add(&h, "top", 3);
    rti_hasher_add(&h, head->lo, sizeof head->lo);
    rti_hasher_add(&h, head->hi, sizeof head->hi);
    rti_hasher_add(&h, &head->scale, sizeof head->scale);
    rti_hasher_add(&h, boxes, count * sizeof *boxes);
    rti_hasher_add(&h, ids, count * sizeof *ids);
    return rti_hasher_end(&h);
}

static rt_status top_tree(const tree_job *job, const rti_chunk *chunk, uint32_t kind, rti_chunk **out)
{
    rt_context *ctx = job->snapshot->ctx;
    const rtk_top_header *head = chunk->data;
    const rtk_instance *instances = rti_chunk_at(chunk, head->off_instances);
    rti_build_settings settings;
    rti_build_input input = {.grow = RTK_GROW * head->scale};
    float(*boxes)[6] = rti_alloc_array(ctx, head->instance_count, sizeof *boxes);
    uint32_t *ids = rti_alloc_array(ctx, head->instance_count, sizeof *ids), count = 0;
    rti_hash key;
    rt_status status = RT_OK;
    if (!boxes || !ids) {
        status = rti_fail_memory(ctx, job->call, head->instance_count * (sizeof *boxes + sizeof *ids));
        goto end;
    }
    for (uint32_t i = 0; i < head->instance_count; i++) {
        if (!in_tree(&instances[i]))
            continue;
        memcpy(boxes[count], instances[i].lo, sizeof instances[i].lo);
        memcpy(boxes[count] + 3, instances[i].hi, sizeof instances[i].hi);
        ids[count++] = i;
    }
    settings = settle(job->snapshot, kind, count);
    key = tree_key(boxes_hash((const float(*)[6])boxes, ids, count, head), &settings);
    if (count == 0 || found(job, key, out))
        goto end;
    input.boxes = (const float(*)[6])boxes;
    input.box_count = count;
    memcpy(input.lo, head->lo, sizeof input.lo);
    memcpy(input.hi, head->hi, sizeof input.hi);
    status = build(job, &input, &settings, key, ids, out);
end:
    rti_free(ctx, boxes, head->instance_count * sizeof *boxes);
    rti_free(ctx, ids, head->instance_count * sizeof *ids);
    return status;
}

rt_status rti_snapshot_build(rti_snapshot *s, const char *call, uint32_t kinds, rti_cancel *cancel)
{
    tree_job job = {s, call, cancel};
    rt_status status = RT_OK;
    for (uint32_t kind = 1; kind < RTI_TREE_KINDS; kind++) {
        if (!(kinds & (1u << kind)))
            continue;
        for (uint32_t i = 0; status == RT_OK && i < s->group_count; i++) {
            const rtk_group_header *head = s->groups[i].group->data;
            if (!s->groups[i].tree[kind] && head->tri_count + head->shape_count > 0)
                status = group_tree(&job, s->groups[i].group, kind, &s->groups[i].tree[kind]);
        }
        if (status == RT_OK && !s->top_tree[kind])
            status = top_tree(&job, s->top, kind, &s->top_tree[kind]);
    }
    return status;
}

/* ---- the same content with other trees ---- */

bool rti_snapshot_complete(const rti_snapshot *s, uint32_t kind)
{
    const rtk_top_header *top = s->top->data;
    if (kind == RTK_TREE_NONE)
        return true;
    for (uint32_t i = 0; i < s->group_count; i++) {
        const rtk_group_header *head = s->groups[i].group->data;
        if (!s->groups[i].tree[kind] && head->tri_count + head->shape_count > 0)
            return false;
    }
    return s->top_tree[kind] || !(top->lo[0] <= top->hi[0]);
}

static rti_snapshot *copy(const rti_snapshot *from)
{
    rti_snapshot *to = rti_snapshot_new(from->ctx, from->group_count, from->texture_count);
    if (!to)
        return NULL;
    to->tracer = from->tracer;
    to->settings = from->settings;
    to->auto_builder = from->auto_builder;
    for (uint32_t i = 0; i < from->group_count; i++) {
        const rti_part_group *g = &from->groups[i];
        to->groups[i].group = rti_chunk_retain(g->group);
        to->groups[i].attribute = rti_chunk_retain(g->attribute);
        to->groups[i].geometry = rti_chunk_retain(g->geometry);
        to->groups[i].material_base = g->material_base;
        for (uint32_t k = 0; k < RTI_TREE_KINDS; k++)
            to->groups[i].tree[k] = rti_chunk_retain(g->tree[k]);
    }
    for (uint32_t i = 0; i < from->texture_count; i++)
        to->textures[i] = rti_chunk_retain(from->textures[i]);
    for (uint32_t k = 0; k < RTI_TREE_KINDS; k++)
        to->top_tree[k] = rti_chunk_retain(from->top_tree[k]);
    to->top = rti_chunk_retain(from->top);
    to->materials = rti_chunk_retain(from->materials);
    to->lights = rti_chunk_retain(from->lights);
    to->world = rti_chunk_retain(from->world);
    return to;
}

rt_status rti_snapshot_with_tree(rti_snapshot *snapshot, uint32_t tree_kind, rti_cancel *cancel, rti_snapshot **out)
{
    static const char call[] = "rt_render";
    rti_snapshot *next;
    rti_fpenv env;
    rt_status status;
    *out = NULL;
    if (tree_kind >= RTI_TREE_KINDS || rti_snapshot_complete(snapshot, tree_kind)) {
        rti_snapshot_retain(snapshot);
        *out = snapshot;
        return RT_OK;
    }
    next = copy(snapshot);
    if (!next)
        return rti_fail_memory(snapshot->ctx, call, snapshot->size);
    env = rti_fp_enter();
    status = rti_snapshot_build(next, call, 1u << tree_kind, cancel);
    rti_fp_leave(env);
    if (status != RT_OK) {
        rti_snapshot_release(next);
        return status;
    }
    rti_snapshot_finish(next);
    *out = next;
    return RT_OK;
}
