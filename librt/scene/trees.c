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
    else if (kind == RTK_TREE_BVH)
        settings.builder = rti_builds_bvh(settings.builder) ? settings.builder : RTI_BUILD_BVH;
    else if (s->auto_builder || settings.builder == RTI_BUILD_OCTREE || rti_builds_bvh(settings.builder))
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
    const rti_moved *moved; /* NULL: nothing has */
    rti_cancel *cancel;
    bool top; /* now at the top level */
} tree_job;

static void count_kept(const tree_job *job, const rti_chunk *tree)
{
    job->snapshot->reused_chunks++;
    job->snapshot->kept_trees++;
    rti_context_count(job->snapshot->ctx, RTI_WORK_TREES_KEPT, 1);
    rti_context_time(job->snapshot->ctx, RTI_WORK_SAVED_NS, (double)((const rtk_tree_header *)tree->data)->build_seconds);
}

static bool found(const tree_job *job, rti_hash key, rti_chunk **out)
{
    *out = rti_chunk_find(job->snapshot->ctx, RTK_CHUNK_TREE, key);
    if (!*out)
        return false;
    count_kept(job, *out);
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

/* Builds one tree and shares it. ids: NULL, or what to call the boxes in its references. group: whose primitives they are; NULL:
 * they are instances. */
static rt_status build(const tree_job *job, const rti_build_input *input, const rti_build_settings *settings, rti_hash key,
                       const uint32_t *ids, const rti_chunk *group, rti_chunk **out)
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
    if (group)
        rti_tree_balls(ctx, data, rti_chunk_at(group, ((const rtk_group_header *)group->data)->off_shapes),
                       ((const rtk_group_header *)group->data)->tri_count);
    *out = rti_chunk_share(ctx, RTK_CHUNK_TREE, data, size, &key, &shared);
    if (!*out)
        return rti_fail_memory(ctx, job->call, size);
    job->snapshot->built_trees++;
    job->snapshot->built_tops += job->top;
    rti_context_count(ctx, job->top ? RTI_WORK_TOPS_BUILT : RTI_WORK_TREES_BUILT, 1);
    rti_context_time(ctx, RTI_WORK_BUILD_NS, (double)((const rtk_tree_header *)(*out)->data)->build_seconds);
    rti_chunk_keep(*out);
    return RT_OK;
}

/* A group cut into parts: each part's trees follow from the group and the part's number. */
static rti_hash part_key(const rti_chunk *chunk, uint32_t part)
{
    rti_hasher h;
    if (((const rtk_group_header *)chunk->data)->part_count == 1)
        return chunk->hash;
    rti_hasher_init(&h);
    rti_hasher_add(&h, &chunk->hash, sizeof chunk->hash);
    rti_hasher_add(&h, &part, sizeof part);
    return rti_hasher_end(&h);
}

/* What a tree is built over: the group's own triangles, or those of a part brought together; and the boxes of shapes. */
typedef struct part_input {
    const uint32_t *list; /* of the part, NULL: all */
    uint32_t tri_count, shape_count;
    const rtk_tri *tris;
    rtk_tri *own_tris; /* NULL: none brought together */
    float (*boxes)[6];
    uint32_t balls; /* as in rti_build_input */
} part_input;

static void part_input_free(rt_context *ctx, part_input *in)
{
    rti_free(ctx, in->own_tris, in->tri_count * sizeof *in->own_tris);
    rti_free(ctx, in->boxes, in->shape_count * sizeof *in->boxes);
}

/* false: no memory; free it all the same. */
static bool part_input_make(rt_context *ctx, const rti_chunk *chunk, uint32_t part, part_input *in)
{
    const rtk_group_header *head = chunk->data;
    const rtk_shape *shapes = rti_chunk_at(chunk, head->off_shapes);
    uint32_t count = head->parts[part].count;
    in->list = rti_part_list(chunk, part);
    in->tris = head->tri_count ? rti_chunk_at(chunk, head->off_tris) : NULL;
    in->tri_count = head->tri_count;
    if (in->list) { /* triangles come first in it */
        in->tri_count = 0;
        while (in->tri_count < count && in->list[in->tri_count] < head->tri_count)
            in->tri_count++;
    }
    in->shape_count = count - in->tri_count;
    in->boxes = rti_alloc_array(ctx, in->shape_count, sizeof *in->boxes);
    in->balls = 0;
    if (in->list && in->tri_count > 0)
        in->own_tris = rti_alloc_array(ctx, in->tri_count, sizeof *in->own_tris);
    if (!in->boxes || (in->list && in->tri_count > 0 && !in->own_tris))
        return false;
    for (uint32_t i = 0; in->own_tris && i < in->tri_count; i++)
        in->own_tris[i] = in->tris[in->list[i]];
    in->tris = in->own_tris ? in->own_tris : in->tris;
    for (uint32_t i = 0; i < in->shape_count; i++) {
        const rtk_shape *shape = &shapes[in->list ? in->list[in->tri_count + i] - head->tri_count : i];
        rtk_vec3 lo, hi;
        rtk_shape_bounds(shape, &lo, &hi);
        if (in->balls != RTK_FORM)
            in->balls = shape->type == RTK_SHAPE_SPHERE || shape->type == RTK_SHAPE_TORUS ? RTK_BALL : RTK_FORM;
        memcpy(in->boxes[i], (float[6]){lo.x, lo.y, lo.z, hi.x, hi.y, hi.z}, sizeof in->boxes[i]);
    }
    return true;
}

/* ---- refitting: a tree of the snapshot before ---- */

/* Do these groups hold as many primitives, in the same parts? (That they are the same ones matters for speed alone.) */
static bool same_parts(const rti_chunk *a, const rti_chunk *b)
{
    const rtk_group_header *p = a->data, *q = b->data;
    if (p->tri_count != q->tri_count || p->shape_count != q->shape_count || p->part_count != q->part_count)
        return false;
    for (uint32_t i = 0; i < p->part_count; i++) {
        if (p->parts[i].count != q->parts[i].count)
            return false;
    }
    return p->part_count <= 1 ||
           memcmp(rti_part_list(a, 0), rti_part_list(b, 0), ((size_t)p->tri_count + p->shape_count) * sizeof(uint32_t)) == 0;
}

/* The tree to refit for a part of the scene's own group; NULL: there is none. */
static rti_chunk *tree_before(const tree_job *job, uint32_t part)
{
    const rti_snapshot *s = job->snapshot, *before = job->moved ? job->moved->before : NULL;
    rti_chunk *tree;
    if (!before || !(job->moved->limit > 0.0f) || s->auto_builder != before->auto_builder ||
        memcmp(&s->settings, &before->settings, sizeof s->settings) != 0 ||
        !same_parts(s->groups[0].group, before->groups[0].group))
        return NULL;
    tree = before->groups[0].tree[part][RTK_TREE_BVH];
    return tree && rti_bvh_refits(tree->data) ? tree : NULL;
}

/* It has a name of its own: who looks for the tree that is built over the same primitives does not find it. Nor is it kept when
 * nobody has it any more: an animation would fill the cache with what is quickly made. */
static rti_hash refit_key(rti_hash key, const rti_chunk *old)
{
    rti_hasher h;
    rti_hasher_init(&h);
    rti_hasher_add(&h, "refit", 5);
    rti_hasher_add(&h, &key, sizeof key);
    rti_hasher_add(&h, &old->hash, sizeof old->hash);
    return rti_hasher_end(&h);
}

/* *out stays NULL where a tree is to be built. key: of that one. */
static rt_status refit(const tree_job *job, const rti_chunk *chunk, uint32_t part, rti_hash key, rti_chunk **out)
{
    rt_context *ctx = job->snapshot->ctx;
    const rtk_group_header *head = chunk->data;
    rti_chunk *old = tree_before(job, part);
    rti_refit_input in = {.tris = rti_chunk_at(chunk, head->off_tris),
                          .shapes = rti_chunk_at(chunk, head->off_shapes),
                          .tri_count = head->tri_count,
                          .grow = RTK_GROW * head->parts[part].scale};
    void *data;
    bool shared;
    rt_status status;
    if (!old)
        return RT_OK;
    if (job->moved->before->groups[0].group == chunk) { /* nothing has moved since: something else was edited */
        count_kept(job, old);
        *out = rti_chunk_retain(old);
        return RT_OK;
    }
    memcpy(in.lo, head->parts[part].lo, sizeof in.lo);
    memcpy(in.hi, head->parts[part].hi, sizeof in.hi);
    status = rti_bvh_refit(ctx, old->data, old->size, &in, job->moved->limit, job->cancel, &data);
    if (status != RT_OK || !data)
        return status;
    key = refit_key(key, old);
    *out = rti_chunk_share(ctx, RTK_CHUNK_TREE, data, old->size, &key, &shared);
    if (!*out)
        return rti_fail_memory(ctx, job->call, old->size);
    job->snapshot->refitted_trees++;
    rti_context_count(ctx, RTI_WORK_TREES_REFITTED, 1);
    rti_context_time(ctx, RTI_WORK_BUILD_NS, (double)((const rtk_tree_header *)(*out)->data)->build_seconds);
    return RT_OK;
}

static rt_status part_tree(const tree_job *job, const rti_chunk *chunk, uint32_t part, uint32_t kind, rti_chunk **out)
{
    rt_context *ctx = job->snapshot->ctx;
    const rtk_part_header *head = &((const rtk_group_header *)chunk->data)->parts[part];
    rti_build_settings settings = settle(job->snapshot, kind, head->count);
    rti_hash key = tree_key(part_key(chunk, part), &settings);
    rti_build_input input = {.grow = RTK_GROW * head->scale};
    part_input in = {.list = NULL};
    rt_status status;
    if (found(job, key, out))
        return RT_OK;
    if (kind == RTK_TREE_BVH && chunk == job->snapshot->groups[0].group) {
        status = refit(job, chunk, part, key, out);
        if (status != RT_OK || *out)
            return status;
    }
    if (part_input_make(ctx, chunk, part, &in)) {
        input.tris = in.tri_count ? in.tris : NULL;
        input.tri_count = in.tri_count;
        input.boxes = (const float(*)[6])in.boxes;
        input.box_count = in.shape_count;
        memcpy(input.lo, head->lo, sizeof input.lo);
        memcpy(input.hi, head->hi, sizeof input.hi);
        input.balls = in.balls;
        status = build(job, &input, &settings, key, in.list, chunk, out);
    } else {
        status = rti_fail_memory(ctx, job->call, head->count * sizeof(rtk_tri));
    }
    part_input_free(ctx, &in);
    return status;
}

static rt_status group_trees(const tree_job *job, rti_part_group *group, uint32_t kind)
{
    const rtk_group_header *head = group->group->data;
    rt_status status = RT_OK;
    for (uint32_t p = 0; status == RT_OK && p < head->part_count; p++) {
        if (!group->tree[p][kind])
            status = part_tree(job, group->group, p, kind, &group->tree[p][kind]);
    }
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
    status = build(job, &input, &settings, key, ids, NULL, out);
end:
    rti_free(ctx, boxes, head->instance_count * sizeof *boxes);
    rti_free(ctx, ids, head->instance_count * sizeof *ids);
    return status;
}

rt_status rti_snapshot_build(rti_snapshot *s, const char *call, uint32_t kinds, const rti_moved *moved, rti_cancel *cancel)
{
    tree_job job = {s, call, moved, cancel, false};
    rt_status status = RT_OK;
    for (uint32_t kind = 1; kind < RTI_TREE_KINDS; kind++) {
        if (!(kinds & (1u << kind)))
            continue;
        for (uint32_t i = 0; status == RT_OK && i < s->group_count; i++)
            status = group_trees(&job, &s->groups[i], kind);
        job.top = true;
        if (status == RT_OK && !s->top_tree[kind])
            status = top_tree(&job, s->top, kind, &s->top_tree[kind]);
        job.top = false;
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
        for (uint32_t p = 0; p < head->part_count; p++) {
            if (!s->groups[i].tree[p][kind])
                return false;
        }
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
        rti_trees_retain(&to->groups[i], g);
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

rt_status rti_snapshot_with_tree(rti_snapshot *snapshot, const char *call, uint32_t tree_kind, rti_cancel *cancel,
                                 rti_snapshot **out)
{
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
    status = rti_snapshot_build(next, call, 1u << tree_kind, NULL, cancel);
    rti_fp_leave(env);
    if (status == RT_OK)
        status = rti_snapshot_finish(next, call);
    if (status != RT_OK) {
        rti_snapshot_release(next);
        return status;
    }
    *out = next;
    return RT_OK;
}
