/* The frame that builders of cells stand in. Large nodes are split level by level (the top), one task a node; what is small
 * enough becomes a part, which one task builds depth first. Where that happens depends on the number of references alone, so the
 * tree is the same for any number of workers.
 */
#include <string.h>

#include "build.h"

/* A part: its root stands in the top's node root.node, the rest is appended. */
typedef struct part_job {
    rti_tree_out out;
    rti_item root;
    rti_ref *refs; /* the task frees them */
    size_t refs_capacity;
    rt_status status;
} part_job;

typedef struct top {
    rt_context *ctx;
    const rti_build *b;
    const rti_method *method;
    rti_tree_out out;
    rti_open *open, *next;
    size_t open_count, open_capacity, next_count, next_capacity;
    part_job *parts;
    size_t part_count, part_capacity;
    uint32_t part_limit; /* a node of at most this many references is a part */
} top;

static void part_task(void *data, uint32_t index)
{
    top *t = data;
    part_job *job = &t->parts[index];
    job->out.node_size = t->method->node_size;
    if (rti_cancelled(t->b->cancel)) {
        job->status = RT_ERROR_CANCELLED;
        return;
    }
    job->status = t->method->part(t->ctx, t->b, &job->root, job->refs, job->refs_capacity, &job->out);
    job->refs = NULL;
}

static void open_task(void *data, uint32_t index)
{
    top *t = data;
    t->open[index].status = t->method->split(t->ctx, t->b, &t->open[index]);
}

/* Hands the references over to a part or to the next level. */
static bool add_node(top *t, const rti_item *it, rti_ref **refs, size_t capacity, bool leaf)
{
    if (leaf || it->count <= t->part_limit) {
        if (!rti_reserve(t->ctx, (void **)&t->parts, &t->part_capacity, t->part_count, 1, sizeof *t->parts))
            return false;
        part_job *job = &t->parts[t->part_count++];
        memset(job, 0, sizeof *job);
        job->root = *it;
        job->root.depth = leaf ? t->b->max_depth : it->depth;
        job->refs = *refs;
        job->refs_capacity = capacity;
    } else {
        if (!rti_reserve(t->ctx, (void **)&t->next, &t->next_capacity, t->next_count, 1, sizeof *t->next))
            return false;
        rti_open *o = &t->next[t->next_count++];
        memset(o, 0, sizeof *o);
        o->it = *it;
        o->refs = *refs;
        o->capacity = capacity;
    }
    *refs = NULL;
    return true;
}

static void free_open(rt_context *ctx, rti_open *o)
{
    rti_free(ctx, o->refs, o->capacity * sizeof *o->refs);
    for (int i = 0; i < 8; i++)
        rti_free(ctx, o->child_refs[i], o->child_capacity[i] * sizeof(rti_ref));
}

/* Puts the outcome of one open node into the top. */
static rt_status close_open(top *t, rti_open *o)
{
    if (o->status != RT_OK)
        return o->status;
    if (o->leaf)
        return add_node(t, &o->it, &o->refs, o->capacity, true) ? RT_OK : RT_ERROR_MEMORY;
    size_t child = rti_out_nodes(t->ctx, &t->out, t->method->child_count);
    if (child == SIZE_MAX)
        return RT_ERROR_MEMORY;
    t->method->write_inner((char *)t->out.nodes + o->it.node * t->method->node_size, o, (uint32_t)child);
    for (uint32_t i = 0; i < t->method->child_count; i++) {
        o->children[i].node = (uint32_t)child + i;
        if (!add_node(t, &o->children[i], &o->child_refs[i], o->child_capacity[i], false))
            return RT_ERROR_MEMORY;
    }
    return RT_OK;
}

static rt_status build_level(top *t)
{
    rt_status status = RT_OK;
    rti_open *swap = t->open;
    size_t swap_capacity = t->open_capacity;
    t->open = t->next;
    t->open_capacity = t->next_capacity;
    t->open_count = t->next_count;
    t->next = swap;
    t->next_capacity = swap_capacity;
    t->next_count = 0;
    rti_parallel(t->ctx, (uint32_t)t->open_count, open_task, t);
    for (size_t i = 0; i < t->open_count; i++) {
        if (status == RT_OK)
            status = close_open(t, &t->open[i]);
        free_open(t->ctx, &t->open[i]);
    }
    t->open_count = 0;
    return status == RT_OK && rti_cancelled(t->b->cancel) ? RT_ERROR_CANCELLED : status;
}

static rt_status build_top(top *t, rti_ref **refs, uint32_t count)
{
    const rti_build *b = t->b;
    double budget = (double)b->duplication * count + 64.0;
    rti_item root = {
        .cell = b->root, .node = 0, .count = count, .depth = 0, .budget = budget < RTI_REF_MAX ? (uint32_t)budget : RTI_REF_MAX};
    rt_status status = RT_OK;
    if (rti_out_nodes(t->ctx, &t->out, 1) == SIZE_MAX || !add_node(t, &root, refs, b->prim_count, false))
        return RT_ERROR_MEMORY;
    while (status == RT_OK && t->next_count > 0)
        status = build_level(t);
    return status;
}

static void free_top(top *t)
{
    for (size_t i = 0; i < t->next_count; i++)
        free_open(t->ctx, &t->next[i]);
    for (size_t i = 0; i < t->part_count; i++) {
        rti_free(t->ctx, t->parts[i].refs, t->parts[i].refs_capacity * sizeof(rti_ref));
        rti_out_free(t->ctx, &t->parts[i].out);
    }
    rti_out_free(t->ctx, &t->out);
    rti_free(t->ctx, t->open, t->open_capacity * sizeof *t->open);
    rti_free(t->ctx, t->next, t->next_capacity * sizeof *t->next);
    rti_free(t->ctx, t->parts, t->part_capacity * sizeof *t->parts);
}

/* Node indices of a part count from its own root, which goes to the top's node; its other nodes move up by `nodes`. */
static void place_part(const top *t, const part_job *job, rti_tree_out *all)
{
    const rti_tree_out *out = &job->out;
    const size_t size = out->node_size;
    const uint32_t nodes = (uint32_t)all->node_count - 1, refs = (uint32_t)all->ref_count;
    char *to = all->nodes, *slot = to + job->root.node * size, *rest = to + all->node_count * size;
    memcpy(slot, out->nodes, size);
    memcpy(rest, (const char *)out->nodes + size, (out->node_count - 1) * size);
    if (out->ref_count > 0)
        memcpy(all->refs + refs, out->refs, out->ref_count * sizeof *out->refs);
    t->method->move(slot, nodes, refs);
    for (size_t i = 1; i < out->node_count; i++)
        t->method->move(rest + (i - 1) * size, nodes, refs);
    all->node_count += out->node_count - 1;
    all->ref_count += out->ref_count;
}

/* The top and its parts behind each other; the caller frees them. */
static rt_status stitch(const top *t, rti_tree_out *all)
{
    size_t nodes = t->out.node_count, refs = 0;
    for (size_t i = 0; i < t->part_count; i++) {
        if (t->parts[i].status != RT_OK)
            return t->parts[i].status;
        nodes += t->parts[i].out.node_count - 1;
        refs += t->parts[i].out.ref_count;
    }
    if (nodes > RTI_NODE_MAX || refs > RTI_REF_MAX)
        return RT_ERROR_MEMORY;
    all->node_capacity = nodes;
    all->ref_capacity = refs;
    all->nodes = rti_alloc_array(t->ctx, nodes, all->node_size);
    all->refs = rti_alloc_array(t->ctx, refs, sizeof *all->refs);
    if (!all->nodes || !all->refs)
        return RT_ERROR_MEMORY;
    memcpy(all->nodes, t->out.nodes, t->out.node_count * all->node_size);
    all->node_count = t->out.node_count;
    for (size_t i = 0; i < t->part_count; i++)
        place_part(t, &t->parts[i], all);
    return RT_OK;
}

rt_status rti_top_build(rt_context *ctx, const rti_build *b, const rti_method *method, double start, void **chunk, size_t *size)
{
    top t = {.ctx = ctx, .b = b, .method = method};
    rti_tree_out all = {.node_size = method->node_size};
    uint32_t count;
    rti_ref *refs = rti_refs_root(ctx, b, &count);
    rt_status status;
    t.out.node_size = method->node_size;
    t.part_limit = count / 64 > 1024 ? count / 64 : 1024;
    status = refs ? build_top(&t, &refs, count) : RT_ERROR_MEMORY;
    rti_free(ctx, refs, b->prim_count * sizeof *refs);
    if (status == RT_OK) {
        rti_parallel(ctx, (uint32_t)t.part_count, part_task, &t);
        /* Whoever sees the wish to cancel stops where he stands, and what there is is no tree. */
        status = rti_cancelled(b->cancel) ? RT_ERROR_CANCELLED : stitch(&t, &all);
    }
    free_top(&t);
    if (status == RT_OK)
        status = rti_cell_widen(ctx, b, method, &all, start, chunk, size);
    rti_out_free(ctx, &all);
    return status;
}
