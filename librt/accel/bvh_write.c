/* From the binary tree, a BVH's or a kd-tree's, to a chunk of nodes of eight: a node takes the two children of a binary one and
 * opens slots until eight are there (next_slot). Subtrees that lie in one part are a task each, which goes over its subtree
 * twice: to count, then to write where the sums of the counts say.
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
    bool dense; /* nodes are filled, at the cost of a few more visits */
    bool writing;
    rtk_kdnode *kd;
    rtk_bvhnode *nodes;
    rtk_bvhblock *blocks;
    uint32_t *refs;
} writer;

/* Of a kd-tree. */
static bool is_empty(const rti_bvh *t, uint32_t node)
{
    return t->nodes[node].count == 0 && t->nodes[node].child == 0;
}

static bool is_leaf(const rti_bvh *t, uint32_t node)
{
    return t->nodes[node].count > 0;
}

static float node_area(const rti_bvh *t, uint32_t node)
{
    const rti_bvh_node *n = &t->nodes[node];
    rti_bvh_box b = {rti_f4_load(n->lo), rti_f4_load(n->hi)};
    return rti_bvh_area(t, b);
}

/* Leaves below a node, counted as far as it matters: more than fit into one node of eight are RTK_BVH_WIDTH + 1. */
static uint32_t few_leaves(const rti_bvh *t, uint32_t node)
{
    uint32_t stack[RTK_BVH_WIDTH + 2], top = 1, count = 0;
    stack[0] = node;
    while (top > 0 && count + top <= RTK_BVH_WIDTH) {
        const rti_bvh_node *n = &t->nodes[stack[--top]];
        if (n->count > 0) {
            count++;
        } else {
            stack[top++] = n->child;
            stack[top++] = n->child + 1;
        }
    }
    return count + top;
}

/* Slots of one node, the largest first. leaves: below each (few_leaves), of a dense tree. */
typedef struct slots {
    bool dense;
    uint32_t count, node[RTK_BVH_WIDTH], leaves[RTK_BVH_WIDTH];
    float area[RTK_BVH_WIDTH];
} slots;

static void add_slot(const rti_bvh *t, slots *s, uint32_t node)
{
    float area = node_area(t, node);
    uint32_t at = s->count++;
    for (; at > 0 && s->area[at - 1] < area; at--) {
        s->area[at] = s->area[at - 1];
        s->node[at] = s->node[at - 1];
        s->leaves[at] = s->leaves[at - 1];
    }
    s->area[at] = area;
    s->node[at] = node;
    s->leaves[at] = s->dense ? few_leaves(t, node) : 0;
}

/* In place of a slot, its two children. */
static void open_slot(const rti_bvh *t, slots *s, uint32_t at)
{
    uint32_t child = t->nodes[s->node[at]].child, behind = --s->count - at;
    memmove(s->area + at, s->area + at + 1, behind * sizeof *s->area);
    memmove(s->node + at, s->node + at + 1, behind * sizeof *s->node);
    memmove(s->leaves + at, s->leaves + at + 1, behind * sizeof *s->leaves);
    for (uint32_t i = 0; i < 2; i++)
        if (!is_empty(t, child + i))
            add_slot(t, s, child + i);
}

/* The slot to open next; s->count: none. The largest inner one is the best for rays. It leaves many nodes of two or three leaves,
 * though, and a node takes its 256 bytes whatever it holds. A dense tree opens the largest of those that one node does not hold,
 * and then, where all their leaves have room, those of the fewest: what is left becomes nodes that are nearly full. On sponza
 * that saves a tenth of the bytes and costs 3% of the rays. */
static uint32_t next_slot(const rti_bvh *t, const slots *s)
{
    uint32_t best = s->count, room = RTK_BVH_WIDTH - s->count;
    for (uint32_t i = 0; i < s->count && room > 0; i++)
        if (!is_leaf(t, s->node[i]) && (!s->dense || s->leaves[i] > RTK_BVH_WIDTH))
            return i;
    for (uint32_t i = 0; i < s->count && s->dense; i++)
        if (s->leaves[i] > 1 && s->leaves[i] - 1 <= room && (best == s->count || s->leaves[i] < s->leaves[best]))
            best = i;
    return best;
}

/* The slots that a binary node becomes. */
static void gather(const rti_bvh *t, bool dense, uint32_t binary, slots *s)
{
    uint32_t next;
    s->dense = dense;
    s->count = 0;
    add_slot(t, s, binary);
    while ((next = next_slot(t, s)) < s->count)
        open_slot(t, s, next);
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

/* A leaf of triangles alone; that of a BVH holds one kind of primitives. */
static bool in_blocks(const rti_bvh *t, uint32_t node)
{
    const rti_bvh_node *n = &t->nodes[node];
    const uint32_t look = t->b->in->box_count == 0 ? 0 : (t->kd ? n->count : 1);
    if (!t->blocks || n->count == 0)
        return false;
    for (uint32_t i = 0; i < look; i++)
        if (t->order[n->child + i] >= t->b->in->tri_count)
            return false;
    return true;
}

/* A leaf's references are from `first` on. */
static void leaf_at(const writer *w, uint32_t node, uint32_t first)
{
    if (w->kd)
        w->kd[node].a = first;
}

/* Places of a node's blocks that its leaves have not filled. */
typedef struct holes {
    uint32_t count, first[RTK_BVH_WIDTH], room[RTK_BVH_WIDTH];
} holes;

/* A leaf with blocks; at: what stands before it, moved on. One of less than a block goes into a hole that holds all of it: its
 * test takes as long as in a block of its own. Returns its first place. */
static uint32_t put_blocked(const writer *w, uint32_t node, totals *at, holes *h)
{
    const uint32_t *prims = w->t->order + w->t->nodes[node].child;
    uint32_t count = w->t->nodes[node].count, need = (count + RTK_BVH_BLOCK - 1) / RTK_BVH_BLOCK;
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
    if (w->writing) {
        put_lanes(w, prims, count, first, end);
        leaf_at(w, node, first);
    }
    return first;
}

/* All leaves of a node that have blocks, the fullest first: so the small ones find holes. child: their first places, by slot. */
static void put_all_blocked(const writer *w, const slots *s, totals *at, uint32_t child[RTK_BVH_WIDTH])
{
    holes h = {0};
    for (uint32_t i = 0; i < s->count && w->writing; i++) { /* triangles stand anywhere */
        const rti_bvh_node *n = &w->t->nodes[s->node[i]];
        const uint32_t some = in_blocks(w->t, s->node[i]) ? rtk_umin(n->count, 4 * RTK_BVH_BLOCK) : 0;
        for (uint32_t k = 0; k < some; k++)
            __builtin_prefetch(&w->t->b->in->tris[w->t->order[n->child + k]]);
    }
    for (uint32_t size = RTK_BVH_BLOCK; size > 0; size--)
        for (uint32_t i = 0; i < s->count; i++)
            if (in_blocks(w->t, s->node[i]) && rtk_umin(w->t->nodes[s->node[i]].count, RTK_BVH_BLOCK) == size)
                child[i] = put_blocked(w, s->node[i], at, &h);
}

/* A leaf's references without blocks, likewise. */
static uint32_t put_plain(const writer *w, uint32_t node, totals *at)
{
    const rti_bvh_node *n = &w->t->nodes[node];
    uint32_t first = at->plain;
    if (w->writing) {
        memcpy(w->refs + first, w->t->order + n->child, n->count * sizeof *w->refs);
        leaf_at(w, node, first);
    }
    at->plain += n->count;
    return first;
}

/* All leaves below an inner node that is too deep, as one without blocks. Returns how many references it has. */
static uint32_t put_rest(const writer *w, uint32_t binary, totals *at)
{
    uint32_t stack[RTI_BVH_BINARY + 4], top = 1, count = 0;
    stack[0] = binary;
    while (top > 0) {
        uint32_t node = stack[--top];
        const rti_bvh_node *n = &w->t->nodes[node];
        if (n->count > 0) {
            put_plain(w, node, at);
            count += n->count;
        } else if (n->child > 0) {
            stack[top++] = n->child + 1;
            stack[top++] = n->child;
        }
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
    gather(t, w->dense, it->binary, &s);
    put_all_blocked(w, &s, at, places);
    for (uint32_t i = 0; i < s.count; i++) {
        uint32_t child, count = t->nodes[s.node[i]].count;
        if (count > 0) {
            child = in_blocks(t, s.node[i]) ? places[i] : put_plain(w, s.node[i], at);
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
            const rti_bvh_node *b = &w->t->nodes[inner[i].binary];
            if (inner[i].binary < w->t->top_count && b->child < w->t->top_count) {
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

/* The chunk: header, nodes of a kd-tree, nodes of eight, blocks, references, each from a multiple of 64 on. */
static void write_header(const rti_bvh *t, const totals *sum, rtk_tree_header *h)
{
    const rti_build *b = t->b;
    uint64_t wide;
    memset(h, 0, aligned(sizeof *h));
    h->kind = t->kd ? RTK_TREE_KD : RTK_TREE_BVH;
    h->node_count = t->kd ? t->kd_count : sum->nodes;
    h->wide_count = t->kd ? sum->nodes : 0;
    h->ref_count = sum->blocks * RTK_BVH_BLOCK + sum->plain;
    h->block_count = sum->blocks;
    h->filler_count = sum->filler;
    memcpy(h->lo, b->in->lo, sizeof h->lo);
    memcpy(h->hi, b->in->hi, sizeof h->hi);
    h->prim_count = b->prim_count;
    h->cost_traverse = b->cost_traverse;
    h->cost_intersect = b->cost_intersect;
    h->empty_bonus = b->empty_bonus;
    h->max_depth = b->max_depth;
    h->flags = b->builder;
    h->off_nodes = aligned(sizeof *h);
    wide = h->off_nodes + (t->kd ? aligned(t->kd_count * sizeof *t->kd) : 0);
    h->off_wide = t->kd ? wide : 0;
    h->off_blocks = sum->blocks ? wide + sum->nodes * sizeof(rtk_bvhnode) : 0;
    h->off_refs = aligned(wide + sum->nodes * sizeof(rtk_bvhnode) + sum->blocks * sizeof(rtk_bvhblock));
}

static char *make_chunk(writer *w, const totals *sum, size_t *size)
{
    const rti_bvh *t = w->t;
    size_t wide = aligned(sizeof(rtk_tree_header)) + (t->kd ? aligned(t->kd_count * sizeof *t->kd) : 0);
    size_t end = wide + sum->nodes * sizeof(rtk_bvhnode) + sum->blocks * sizeof(rtk_bvhblock);
    uint64_t refs = (uint64_t)sum->blocks * RTK_BVH_BLOCK + sum->plain;
    char *bytes;
    *size = aligned(end) + refs * sizeof(uint32_t);
    bytes = sum->nodes <= RTI_NODE_MAX && refs <= RTI_REF_MAX ? rti_alloc(t->ctx, *size) : NULL;
    if (!bytes)
        return NULL;
    write_header(t, sum, (rtk_tree_header *)bytes);
    if (t->kd) {
        w->kd = (rtk_kdnode *)(void *)(bytes + aligned(sizeof(rtk_tree_header)));
        memcpy(w->kd, t->kd, t->kd_count * sizeof *t->kd);
        memset(w->kd + t->kd_count, 0, (size_t)(bytes + wide - (char *)(w->kd + t->kd_count)));
    }
    memset(bytes + end, 0, aligned(end) - end);
    w->nodes = (rtk_bvhnode *)(void *)(bytes + wide);
    w->blocks = (rtk_bvhblock *)(void *)(w->nodes + sum->nodes);
    w->refs = (uint32_t *)(void *)(bytes + aligned(end));
    return bytes;
}

/* The first pass: tasks, and what there is of everything. */
static rt_status count_all(writer *w, uint32_t root, todo *list, totals *sum)
{
    totals own = {0};
    w->task_count = 0;
    if (!fold_top(w, root, &own, list, w->t->top_count + 1))
        return RT_ERROR_MEMORY;
    rti_parallel(w->t->ctx, (uint32_t)w->task_count, fold_task, w);
    if (rti_cancelled(w->t->b->cancel))
        return RT_ERROR_CANCELLED;
    *sum = place(w, own);
    return RT_OK;
}

/* A tree with blocks, as `auto` builds it, may take 60 bytes a triangle. Meshes stay below; of triangles far from each other,
 * where leaves go by two into a node, it would be 70. */
static bool too_large(const rti_bvh *t, const totals *sum)
{
    uint64_t bytes = (uint64_t)sum->nodes * sizeof(rtk_bvhnode) + sum->plain * sizeof(uint32_t) +
                     (uint64_t)sum->blocks * (sizeof(rtk_bvhblock) + RTK_BVH_BLOCK * sizeof(uint32_t));
    return t->blocks && !t->spatial && !t->kd && bytes > (uint64_t)60 * t->b->prim_count;
}

static rt_status fold(writer *w, uint32_t root, todo *list, char **bytes, size_t *size)
{
    totals own, sum = {.nodes = 1};
    rt_status status = RT_OK;
    w->dense = w->t->b->builder == RTI_BUILD_BVH_COMPACT;
    if (root != RTK_INVALID)
        status = count_all(w, root, list, &sum);
    if (status == RT_OK && root != RTK_INVALID && !w->dense && too_large(w->t, &sum)) {
        w->dense = true;
        status = count_all(w, root, list, &sum);
    }
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
    own = (totals){.plain = sum.blocks * RTK_BVH_BLOCK};
    fold_top(w, root, &own, list, w->t->top_count + 1);
    rti_parallel(w->t->ctx, (uint32_t)w->task_count, fold_task, w);
    return rti_cancelled(w->t->b->cancel) ? RT_ERROR_CANCELLED : RT_OK;
}

rt_status rti_bvh_write(const rti_bvh *t, uint32_t root, double start, void **chunk, size_t *size)
{
    writer w = {.t = t};
    char *bytes = NULL;
    todo *list = rti_alloc_array(t->ctx, t->top_count + 1, sizeof *list);
    rt_status status = list ? fold(&w, root, list, &bytes, size) : RT_ERROR_MEMORY;
    rti_free(t->ctx, list, (t->top_count + 1) * sizeof *list);
    rti_free(t->ctx, w.tasks, w.task_capacity * sizeof *w.tasks);
    if (status != RT_OK) {
        rti_free(t->ctx, bytes, bytes ? *size : 0);
        *size = 0;
        return status;
    }
    rti_tree_measure((rtk_tree_header *)(void *)bytes);
    ((rtk_tree_header *)(void *)bytes)->build_seconds = (float)(rti_now() - start);
    *chunk = bytes;
    return RT_OK;
}
