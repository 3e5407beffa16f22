/* From the binary tree, a BVH's or one of cells, to a chunk of nodes of eight, whose slots bvh_fold.c chose. Subtrees that lie in
 * one part are a task each, which goes over its subtree twice: to count, then to write where the sums of the counts say. Of
 * cells the chunk holds the tree's own nodes, too, and behind all other references those of its leaves.
 */
#include <string.h>

#include "bvh_build.h"

typedef struct totals {
    uint32_t nodes, blocks, plain, filler; /* plain: references without blocks */
} totals;

/* A wide node to be made from a binary one. */
typedef struct todo {
    uint32_t binary, wide, depth;
} todo;

typedef struct task {
    todo root;
    totals sum, base; /* base: what stands before its own; the root's node is not among them */
} task;

typedef struct writer {
    const rti_bvh *t;
    task *tasks;
    size_t task_count, task_capacity;
    const uint32_t *cuts; /* rti_bvh_cut */
    bool writing;
    void *spare; /* the builder's references, which are needed no longer: the chunk may take their place */
    size_t spare_size;
    rtk_bvhnode *nodes;
    rtk_bvhblock *blocks;
    uint32_t *refs;
    rti_bvh_order order;
} writer;

/* Slots of one node, the largest first: so what they hold stands in memory, whatever order they are put in then. leaf: what is in
 * it, count 0 where the slot is an inner node. */
typedef struct leaf {
    const uint32_t *prims;
    uint32_t count;
} leaf;

typedef struct slots {
    uint32_t count, node[RTK_BVH_WIDTH];
    leaf leaf[RTK_BVH_WIDTH];
    uint32_t merged[RTK_BVH_WIDTH][RTI_BVH_MERGED]; /* what is in leaves that are several of the binary tree */
} slots;

/* The references of several leaves in `to`; two pieces of one triangle are one. */
static uint32_t merge(const writer *w, uint32_t node, uint32_t to[RTI_BVH_MERGED])
{
    const rti_bvh *t = w->t;
    rti_bvh_leaves at = {1, {node}};
    uint32_t count = 0, part;
    while ((part = rti_bvh_next_leaf(t, w->cuts, &at)) != RTK_INVALID) {
        const rti_bvh_node *n = &t->nodes[part];
        for (uint32_t i = 0; i < n->count; i++) {
            uint32_t same = t->spatial || t->own ? 0 : count;
            while (same < count && to[same] != t->order[n->child + i])
                same++;
            if (same == count)
                to[count++] = t->order[n->child + i];
        }
    }
    return count;
}

/* The slots that a binary node becomes. */
static void gather(const writer *w, uint32_t binary, slots *s)
{
    const rti_bvh *t = w->t;
    uint32_t found[RTK_BVH_WIDTH];
    float area[RTK_BVH_WIDTH];
    s->count = rti_bvh_slots(t, w->cuts, binary, found);
    for (uint32_t i = 0; i < s->count; i++) {
        const float size = rti_bvh_node_area(t, found[i]);
        uint32_t at = i;
        for (; at > 0 && area[at - 1] < size; at--) {
            area[at] = area[at - 1];
            s->node[at] = s->node[at - 1];
        }
        area[at] = size;
        s->node[at] = found[i];
    }
    for (uint32_t i = 0; i < s->count; i++) {
        const rti_bvh_node *n = &t->nodes[s->node[i]];
        s->leaf[i] = (leaf){t->order + n->child, n->count};
        if (n->count == 0 && rti_bvh_is_leaf(t, w->cuts, s->node[i]))
            s->leaf[i] = (leaf){s->merged[i], merge(w, s->node[i], s->merged[i])};
    }
}

/* ---- leaves -------------------------------------------------------------------------------------------------------------------
 */

/* Copies of triangles, and their references, from place `first` on; the last is repeated up to place `end`. */
static void put_lanes(const writer *w, const uint32_t *prims, uint32_t count, uint32_t first, uint32_t end)
{
    for (uint32_t i = 0; i < end - first; i++) {
        uint32_t prim = prims[i < count ? i : count - 1], lane = (first + i) % RTK_BVH_BLOCK;
        const rtk_tri *tri = &w->t->b->in->tris[prim];
        rtk_bvhblock *block = &w->blocks[(first + i) / RTK_BVH_BLOCK];
        for (int a = 0; a < 3; a++) {
            block->v0[a][lane] = tri->v0[a];
            block->v1[a][lane] = tri->v1[a];
            block->v2[a][lane] = tri->v2[a];
        }
        w->refs[first + i] = prim;
    }
}

/* A leaf of triangles; it holds one kind of primitives. */
static bool in_blocks(const rti_bvh *t, leaf l)
{
    return t->blocks && l.count > 0 && l.prims[0] < t->b->in->tri_count;
}

/* Places of a node's blocks that its leaves have not filled. */
typedef struct holes {
    uint32_t count, first[RTK_BVH_WIDTH], room[RTK_BVH_WIDTH];
} holes;

/* A leaf with blocks; at: what stands before it, moved on. One of less than a block goes into a hole that holds all of it: its
 * test takes as long as in a block of its own. Returns its first place. */
static uint32_t put_blocked(const writer *w, leaf l, totals *at, holes *h)
{
    const uint32_t count = l.count, need = (count + RTK_BVH_BLOCK - 1) / RTK_BVH_BLOCK;
    uint32_t first = at->blocks * RTK_BVH_BLOCK, end = first + need * RTK_BVH_BLOCK, i = 0;
    while (i < h->count && h->room[i] < count)
        i++;
    if (i < h->count) {
        first = h->first[i];
        end = first + count;
        h->first[i] = end;
        h->room[i] -= count;
        at->filler -= count;
    } else {
        h->first[h->count] = first + count;
        h->room[h->count++] = end - first - count;
        at->blocks += need;
        at->filler += end - first - count;
    }
    if (w->writing)
        put_lanes(w, l.prims, count, first, end);
    return first;
}

/* All leaves of a node that have blocks, the fullest first: so the small ones find holes. child: their first places, by slot. */
static void put_all_blocked(const writer *w, const slots *s, totals *at, uint32_t child[RTK_BVH_WIDTH])
{
    holes h = {0};
    for (uint32_t i = 0; i < s->count && w->writing; i++) { /* triangles stand anywhere */
        const leaf *l = &s->leaf[i];
        const uint32_t some = in_blocks(w->t, *l) ? rtk_umin(l->count, 4 * RTK_BVH_BLOCK) : 0;
        for (uint32_t k = 0; k < some; k++)
            rti_tri_expect(&w->t->b->in->tris[l->prims[k]]);
    }
    for (uint32_t size = RTK_BVH_BLOCK; size > 0; size--)
        for (uint32_t i = 0; i < s->count; i++)
            if (in_blocks(w->t, s->leaf[i]) && rtk_umin(s->leaf[i].count, RTK_BVH_BLOCK) == size)
                child[i] = put_blocked(w, s->leaf[i], at, &h);
}

/* A leaf's references without blocks, likewise. */
static uint32_t put_plain(const writer *w, leaf l, totals *at)
{
    uint32_t first = at->plain;
    if (w->writing)
        memcpy(w->refs + first, l.prims, l.count * sizeof *w->refs);
    at->plain += l.count;
    return first;
}

/* All leaves below an inner node that is too deep, as one without blocks. Returns how many references it has. */
static uint32_t put_rest(const writer *w, uint32_t binary, totals *at)
{
    rti_bvh_leaves below = {1, {binary}};
    uint32_t count = 0, node;
    while ((node = rti_bvh_next_leaf(w->t, w->cuts, &below)) != RTK_INVALID) {
        const rti_bvh_node *n = &w->t->nodes[node];
        put_plain(w, (leaf){w->t->order + n->child, n->count}, at);
        count += n->count;
    }
    return count;
}

/* ---- nodes --------------------------------------------------------------------------------------------------------------------
 */

static void put_slot(const writer *w, uint32_t wide, uint32_t slot, uint32_t binary, uint32_t child, uint32_t count)
{
    rtk_bvhnode *node = &w->nodes[wide];
    const rti_bvh_node *n = &w->t->nodes[binary];
    for (int a = 0; a < 3; a++) {
        node->box[a][0][slot] = n->lo[a] - w->t->grow;
        node->box[a][1][slot] = n->hi[a] + w->t->grow;
    }
    node->child[slot] = child;
    node->count[slot] = count;
}

static void put_empty(const writer *w, uint32_t wide, uint32_t from)
{
    rtk_bvhnode *node = &w->nodes[wide];
    for (uint32_t slot = from; slot < RTK_BVH_WIDTH; slot++) {
        for (int a = 0; a < 3; a++) {
            node->box[a][0][slot] = RTK_INF;
            node->box[a][1][slot] = -RTK_INF;
        }
        node->child[slot] = node->count[slot] = 0;
    }
}

/* Makes one node; its inner slots go to `inner`, numbered from at->nodes on. Returns how many. */
static uint32_t put_node(const writer *w, const todo *it, totals *at, todo inner[RTK_BVH_WIDTH])
{
    const rti_bvh *t = w->t;
    uint32_t open = 0, places[RTK_BVH_WIDTH];
    slots s;
    gather(w, it->binary, &s);
    put_all_blocked(w, &s, at, places);
    for (uint32_t i = 0; i < s.count; i++) {
        uint32_t child, count = s.leaf[i].count;
        if (count > 0) {
            child = in_blocks(t, s.leaf[i]) ? places[i] : put_plain(w, s.leaf[i], at);
        } else if (it->depth + 1 >= t->depth) {
            child = at->plain;
            count = put_rest(w, s.node[i], at);
        } else {
            child = at->nodes++;
            inner[open].binary = s.node[i];
            inner[open].wide = child;
            inner[open++].depth = it->depth + 1;
        }
        if (w->writing)
            put_slot(w, it->wide, i, s.node[i], child, count);
    }
    if (w->writing)
        put_empty(w, it->wide, s.count);
    return open;
}

/* Slots of the nodes from `first` to `end`, of which children stand behind their parents, or were done before. */
static void order_nodes(const writer *w, uint32_t first, uint32_t end)
{
    for (uint32_t n = end; n-- > first;)
        rti_bvh_order_node(&w->order, n);
}

static void fold_task(void *data, uint32_t index)
{
    writer *w = data;
    task *job = &w->tasks[index];
    todo stack[RTK_BVH_STACK], inner[RTK_BVH_WIDTH];
    uint32_t top = 1;
    totals at = {0};
    if (w->writing)
        at = job->base;
    stack[0] = job->root;
    while (top > 0) {
        todo it = stack[--top];
        uint32_t n = put_node(w, &it, &at, inner);
        while (n > 0)
            stack[top++] = inner[--n];
        if (rti_cancelled(w->t->b->cancel))
            return;
    }
    if (w->writing) /* its root is one of the top's */
        order_nodes(w, job->base.nodes, at.nodes);
    job->sum = at;
}

/* The nodes that are made of the top, by the calling thread; what lies in parts becomes tasks (in the counting pass). */
static bool fold_top(writer *w, uint32_t root, totals *at, todo *list, size_t capacity)
{
    size_t from = 0, count = 1, tasks = 0;
    list[0] = (todo){root, 0, 0};
    at->nodes++;
    while (from < count) {
        todo inner[RTK_BVH_WIDTH], it = list[from++];
        uint32_t n = put_node(w, &it, at, inner);
        for (uint32_t i = 0; i < n; i++) {
            if (rti_bvh_in_top(w->t, inner[i].binary)) {
                if (count == capacity)
                    return false;
                list[count++] = inner[i];
                continue;
            }
            if (!w->writing) {
                if (!rti_reserve(w->t->ctx, (void **)&w->tasks, &w->task_capacity, w->task_count, 1, sizeof *w->tasks))
                    return false;
                memset(&w->tasks[w->task_count++], 0, sizeof *w->tasks);
                w->tasks[w->task_count - 1].root = inner[i];
            }
            tasks++;
        }
    }
    return tasks == w->task_count;
}

/* Where each task's own begin; returns all together. own: of the top. */
static totals place(writer *w, totals own)
{
    for (size_t i = 0; i < w->task_count; i++) {
        totals *sum = &w->tasks[i].sum;
        w->tasks[i].base = own;
        own.nodes += sum->nodes;
        own.blocks += sum->blocks;
        own.plain += sum->plain;
        own.filler += sum->filler;
    }
    /* References without blocks stand behind those that have them. */
    for (size_t i = 0; i < w->task_count; i++)
        w->tasks[i].base.plain += own.blocks * RTK_BVH_BLOCK;
    return own;
}

static size_t aligned(size_t size)
{
    return (size + 63) & ~(size_t)63;
}

static uint32_t own_refs(const rti_bvh *t)
{
    return t->own ? (uint32_t)t->own->ref_count : 0;
}

static size_t own_size(const rti_bvh *t)
{
    return t->own ? aligned(t->own->node_count * t->method->kept_size) : 0;
}

/* The chunk: header, nodes of a tree of cells, nodes of eight, blocks, references, balls, each from a multiple of 64 on. */
static void write_header(const rti_bvh *t, const totals *sum, rtk_tree_header *h)
{
    const rti_build *b = t->b;
    uint64_t wide;
    memset(h, 0, aligned(sizeof *h));
    h->kind = t->own ? t->method->kind : RTK_TREE_BVH;
    h->node_count = t->own ? (uint32_t)t->own->node_count : sum->nodes;
    h->wide_count = t->own ? sum->nodes : 0;
    h->ref_count = sum->blocks * RTK_BVH_BLOCK + sum->plain + own_refs(t);
    h->block_count = sum->blocks;
    h->filler_count = t->own ? h->ref_count - own_refs(t) : sum->filler;
    memcpy(h->lo, b->root.lo, sizeof h->lo);
    memcpy(h->hi, b->root.hi, sizeof h->hi);
    h->prim_count = b->prim_count;
    h->cost_traverse = b->cost_traverse;
    h->cost_intersect = b->cost_intersect;
    h->empty_bonus = b->empty_bonus;
    h->max_depth = b->max_depth;
    h->flags = b->builder;
    h->off_nodes = aligned(sizeof *h);
    wide = h->off_nodes + own_size(t);
    h->off_wide = t->own ? wide : 0;
    h->off_blocks = sum->blocks ? wide + sum->nodes * sizeof(rtk_bvhnode) : 0;
    h->off_refs = aligned(wide + sum->nodes * sizeof(rtk_bvhnode) + sum->blocks * sizeof(rtk_bvhblock));
    if (b->in->balls != 0 && sum->plain > 0) {
        h->ball_count = sum->plain;
        h->ball_size = b->in->balls;
        h->off_balls = aligned(h->off_refs + h->ref_count * sizeof(rtk_u32));
    }
}

/* The own nodes of a tree of cells, before `end`, and its references, at refs + first. */
static void put_own(const rti_bvh *t, char *bytes, char *end, uint32_t *refs, uint32_t first)
{
    const rti_tree_out *own = t->own;
    const size_t size = t->method->kept_size;
    char *to = bytes + aligned(sizeof(rtk_tree_header));
    for (size_t i = 0; i < own->node_count; i++, to += size) {
        memcpy(to, (const char *)own->nodes + i * own->node_size, size);
        t->method->move(to, 0, first);
    }
    memset(to, 0, (size_t)(end - to));
    memcpy(refs + first, own->refs, own->ref_count * sizeof *refs);
}

/* Memory that was not touched yet is cleared by the system first, page by page: so it is spared where it can be. */
static char *chunk_room(writer *w, size_t size)
{
    rt_context *ctx = w->t->ctx;
    char *bytes = size <= w->spare_size ? rti_shrink(ctx, w->spare, w->spare_size, size) : NULL;
    if (!bytes)
        return rti_alloc(ctx, size);
    w->spare = NULL;
    return bytes;
}

static char *make_chunk(writer *w, const totals *sum, size_t *size)
{
    const rti_bvh *t = w->t;
    size_t wide = aligned(sizeof(rtk_tree_header)) + own_size(t);
    size_t end = wide + sum->nodes * sizeof(rtk_bvhnode) + sum->blocks * sizeof(rtk_bvhblock);
    const uint64_t own = (uint64_t)sum->blocks * RTK_BVH_BLOCK + sum->plain, refs = own + own_refs(t);
    char *bytes;
    *size = aligned(end) + refs * sizeof(uint32_t);
    if (t->b->in->balls != 0 && sum->plain > 0)
        *size = aligned(*size) + rti_balls_room(sum->plain, t->b->in->balls);
    bytes = sum->nodes <= RTI_NODE_MAX && refs <= RTI_REF_MAX ? chunk_room(w, *size) : NULL;
    if (!bytes)
        return NULL;
    write_header(t, sum, (rtk_tree_header *)bytes);
    w->nodes = (rtk_bvhnode *)(void *)(bytes + wide);
    w->blocks = (rtk_bvhblock *)(void *)(w->nodes + sum->nodes);
    w->refs = (uint32_t *)(void *)(bytes + aligned(end));
    if (t->own)
        put_own(t, bytes, bytes + wide, w->refs, (uint32_t)own);
    memset(w->refs + refs, 0, (size_t)(bytes + *size - (char *)(w->refs + refs)));
    memset(bytes + end, 0, aligned(end) - end);
    return bytes;
}

/* The first pass: slots, tasks, and what there is of everything. per_node: of rti_bvh_cut. */
static rt_status count_all(writer *w, uint32_t root, float per_node, uint32_t *cuts, todo *list, totals *sum)
{
    totals own = {0};
    rt_status status = rti_bvh_cut(w->t, root, per_node, cuts);
    if (status != RT_OK)
        return status;
    w->cuts = cuts;
    w->task_count = 0;
    if (!fold_top(w, root, &own, list, w->t->top_count + 1))
        return RT_ERROR_MEMORY;
    rti_parallel(w->t->ctx, (uint32_t)w->task_count, fold_task, w);
    if (rti_cancelled(w->t->b->cancel))
        return RT_ERROR_CANCELLED;
    *sum = place(w, own);
    return RT_OK;
}

/* A tree with blocks, as `auto` builds it, may take 60 bytes a triangle, a compact one 35. Meshes stay below; triangles far from
 * each other, where leaves go by two into a node, do not by themselves. */
static bool too_large(const rti_bvh *t, const totals *sum)
{
    uint64_t bytes = (uint64_t)sum->nodes * sizeof(rtk_bvhnode) + sum->plain * sizeof(uint32_t) +
                     (uint64_t)sum->blocks * (sizeof(rtk_bvhblock) + RTK_BVH_BLOCK * sizeof(uint32_t));
    return t->b->in->tri_count > 0 && !t->spatial && !t->own && bytes > (t->blocks ? 60u : 34u) * (uint64_t)t->b->prim_count;
}

/* Where a node costs so many times a primitive's share of the root's area, no other costs count. */
#define DEAREST 1048576.0f

/* A node takes its 256 bytes whatever it holds. Where bytes count, it costs so many times what one with a primitive's share of
 * the root's area does, and nodes are filled. */
static float node_cost(const rti_bvh *t, float times)
{
    return times > 0.0f ? times * t->b->cost_traverse * t->root_area / rtk_max((float)t->b->prim_count, 1.0f) : 0.0f;
}

static rt_status fold(writer *w, uint32_t root, uint32_t *cuts, todo *list, char **bytes, size_t *size)
{
    totals own, sum = {.nodes = 1};
    const bool compact = w->t->b->builder == RTI_BUILD_BVH_COMPACT;
    rt_status status = RT_OK;
    if (root != RTK_INVALID)
        status = count_all(w, root, node_cost(w->t, compact ? 2.0f : 0.0f), cuts, list, &sum);
    for (float times = 16.0f; status == RT_OK && root != RTK_INVALID && too_large(w->t, &sum) && times <= DEAREST; times *= 16.0f)
        status = count_all(w, root, node_cost(w->t, times), cuts, list, &sum);
    if (status != RT_OK)
        return status;
    *bytes = make_chunk(w, &sum, size);
    if (!*bytes)
        return RT_ERROR_MEMORY;
    w->writing = true;
    if (root == RTK_INVALID) {
        put_empty(w, 0, 0);
        return RT_OK;
    }
    w->order = (rti_bvh_order){
        w->nodes, w->blocks, sum.blocks, w->t->unit, rti_alloc_array(w->t->ctx, sum.nodes, sizeof *w->order.below), NULL};
    if (!w->order.below)
        return RT_ERROR_MEMORY;
    own = (totals){.plain = sum.blocks * RTK_BVH_BLOCK};
    fold_top(w, root, &own, list, w->t->top_count + 1);
    rti_parallel(w->t->ctx, (uint32_t)w->task_count, fold_task, w);
    if (!rti_cancelled(w->t->b->cancel))
        order_nodes(w, 0, own.nodes);
    rti_free(w->t->ctx, w->order.below, sum.nodes * sizeof *w->order.below);
    return rti_cancelled(w->t->b->cancel) ? RT_ERROR_CANCELLED : RT_OK;
}

rt_status rti_bvh_write(rti_bvh *t, uint32_t root, double start, void **chunk, size_t *size)
{
    writer w = {.t = t, .spare = t->refs[0], .spare_size = t->refs[0] ? 2 * t->room * sizeof(rti_ref) : 0};
    char *bytes = NULL;
    const size_t count = t->node_capacity;
    todo *list = rti_alloc_array(t->ctx, t->top_count + 1, sizeof *list);
    uint32_t *cuts = rti_alloc_array(t->ctx, count, sizeof *cuts);
    rt_status status = list && cuts ? fold(&w, root, cuts, list, &bytes, size) : RT_ERROR_MEMORY;
    t->refs[0] = t->refs[1] = NULL;
    rti_free(t->ctx, w.spare, w.spare_size);
    rti_free(t->ctx, cuts, count * sizeof *cuts);
    rti_free(t->ctx, list, (t->top_count + 1) * sizeof *list);
    rti_free(t->ctx, w.tasks, w.task_capacity * sizeof *w.tasks);
    if (status != RT_OK) {
        rti_free(t->ctx, bytes, bytes ? *size : 0);
        *size = 0;
        return status;
    }
    rti_tree_measure(t->ctx, (rtk_tree_header *)(void *)bytes);
    ((rtk_tree_header *)(void *)bytes)->build_seconds = (float)(rti_now() - start);
    *chunk = bytes;
    return RT_OK;
}
