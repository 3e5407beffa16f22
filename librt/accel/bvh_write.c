/* From the binary tree to a chunk of nodes of eight: a node takes the two children of a binary one and opens the slot of the
 * largest area until eight are there. Subtrees that lie in one part are a task each, which goes over its subtree twice: to count,
 * then to write where the sums of the counts say.
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
    bool writing;
    rtk_bvhnode *nodes;
    rtk_bvhblock *blocks;
    uint32_t *refs;
} writer;

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

/* The binary nodes that become the slots of one, the largest first. */
static uint32_t gather(const rti_bvh *t, uint32_t binary, uint32_t slots[RTK_BVH_WIDTH])
{
    float areas[RTK_BVH_WIDTH];
    uint32_t n = 1, open = 0;
    slots[0] = binary;
    areas[0] = node_area(t, binary);
    while (open < n) {
        if (is_leaf(t, slots[open])) {
            open++;
            continue;
        }
        if (n == RTK_BVH_WIDTH)
            break;
        uint32_t child = t->nodes[slots[open]].child;
        n--;
        memmove(slots + open, slots + open + 1, (n - open) * sizeof *slots);
        memmove(areas + open, areas + open + 1, (n - open) * sizeof *areas);
        for (uint32_t c = child; c < child + 2; c++) {
            float area = node_area(t, c);
            uint32_t at = n;
            while (at > 0 && areas[at - 1] < area) {
                areas[at] = areas[at - 1];
                slots[at] = slots[at - 1];
                at--;
            }
            areas[at] = area;
            slots[at] = c;
            n++;
            open = at < open ? at : open;
        }
    }
    return n;
}

/* ---- leaves -------------------------------------------------------------------------------------------------------------------
 */

static void put_blocks(const writer *w, const uint32_t *prims, uint32_t count, uint32_t first)
{
    for (uint32_t i = 0; i < (count + RTK_BVH_BLOCK - 1) / RTK_BVH_BLOCK * RTK_BVH_BLOCK; i++) {
        uint32_t prim = prims[i < count ? i : count - 1], lane = i % RTK_BVH_BLOCK;
        const rtk_tri *tri = &w->t->b->in->tris[prim];
        rtk_bvhblock *block = &w->blocks[first + i / RTK_BVH_BLOCK];
        for (int a = 0; a < 3; a++) {
            block->v0[a][lane] = tri->v0[a];
            block->v1[a][lane] = tri->v1[a];
            block->v2[a][lane] = tri->v2[a];
        }
        w->refs[first * RTK_BVH_BLOCK + i] = prim;
    }
}

/* A leaf's references; at: what stands before them, moved on. first: where they are, once that is known. */
static uint32_t put_leaf(const writer *w, const uint32_t *prims, uint32_t count, bool blocks, totals *at)
{
    uint32_t need = (count + RTK_BVH_BLOCK - 1) / RTK_BVH_BLOCK, first = at->plain;
    if (!blocks) {
        if (w->writing)
            memcpy(w->refs + first, prims, count * sizeof *prims);
        at->plain += count;
        return first;
    }
    first = at->blocks;
    if (w->writing)
        put_blocks(w, prims, count, first);
    at->blocks += need;
    at->filler += need * RTK_BVH_BLOCK - count;
    return first * RTK_BVH_BLOCK;
}

/* All leaves below an inner node that is too deep, as one without blocks. Returns how many references it has. */
static uint32_t put_rest(const writer *w, uint32_t binary, totals *at)
{
    uint32_t stack[RTI_BVH_BINARY + 4], top = 1, count = 0;
    stack[0] = binary;
    while (top > 0) {
        const rti_bvh_node *n = &w->t->nodes[stack[--top]];
        if (n->count > 0) {
            put_leaf(w, w->t->order + n->child, n->count, false, at);
            count += n->count;
        } else {
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
        node->box[a][0][slot] = n->lo[a] - w->t->b->in->grow;
        node->box[a][1][slot] = n->hi[a] + w->t->b->in->grow;
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
    uint32_t slots[RTK_BVH_WIDTH], n = gather(t, it->binary, slots), open = 0;
    for (uint32_t i = 0; i < n; i++) {
        const rti_bvh_node *b = &t->nodes[slots[i]];
        uint32_t child, count = b->count;
        if (count > 0) {
            const uint32_t *prims = t->order + b->child;
            child = put_leaf(w, prims, count, t->blocks && prims[0] < t->b->in->tri_count, at);
        } else if (it->depth + 1 >= t->b->max_depth) {
            child = at->plain;
            count = put_rest(w, slots[i], at);
        } else {
            child = at->nodes++;
            inner[open].binary = slots[i];
            inner[open].wide = child;
            inner[open++].depth = it->depth + 1;
        }
        if (w->writing)
            put_slot(w, it->wide, i, slots[i], child, count);
    }
    if (w->writing)
        put_empty(w, it->wide, n);
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

static void write_header(const rti_bvh *t, const totals *sum, rtk_tree_header *h)
{
    const rti_build *b = t->b;
    memset(h, 0, aligned(sizeof *h));
    h->kind = RTK_TREE_BVH;
    h->node_count = sum->nodes;
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
    h->off_blocks = sum->blocks ? h->off_nodes + sum->nodes * sizeof(rtk_bvhnode) : 0;
    h->off_refs = aligned(h->off_nodes + sum->nodes * sizeof(rtk_bvhnode) + sum->blocks * sizeof(rtk_bvhblock));
}

static char *make_chunk(writer *w, const totals *sum, size_t *size)
{
    size_t end = aligned(sizeof(rtk_tree_header)) + sum->nodes * sizeof(rtk_bvhnode) + sum->blocks * sizeof(rtk_bvhblock);
    uint64_t refs = (uint64_t)sum->blocks * RTK_BVH_BLOCK + sum->plain;
    char *bytes;
    *size = aligned(end) + refs * sizeof(uint32_t);
    bytes = sum->nodes <= RTI_NODE_MAX && refs <= RTI_REF_MAX ? rti_alloc(w->t->ctx, *size) : NULL;
    if (!bytes)
        return NULL;
    write_header(w->t, sum, (rtk_tree_header *)bytes);
    memset(bytes + end, 0, aligned(end) - end);
    w->nodes = (rtk_bvhnode *)(void *)(bytes + aligned(sizeof(rtk_tree_header)));
    w->blocks = (rtk_bvhblock *)(void *)(w->nodes + sum->nodes);
    w->refs = (uint32_t *)(void *)(bytes + aligned(end));
    return bytes;
}

static rt_status fold(writer *w, uint32_t root, todo *list, char **bytes, size_t *size)
{
    rt_context *ctx = w->t->ctx;
    size_t capacity = w->t->top_count + 1;
    totals own = {0}, sum;
    if (root == RTK_INVALID) {
        sum = (totals){.nodes = 1};
    } else {
        if (!fold_top(w, root, &own, list, capacity))
            return RT_ERROR_MEMORY;
        rti_parallel(ctx, (uint32_t)w->task_count, fold_task, w);
        if (rti_cancelled(w->t->b->cancel))
            return RT_ERROR_CANCELLED;
        sum = place(w, own);
    }
    *bytes = make_chunk(w, &sum, size);
    if (!*bytes)
        return RT_ERROR_MEMORY;
    w->writing = true;
    if (root == RTK_INVALID) {
        put_empty(w, 0, 0);
        return RT_OK;
    }
    own = (totals){.plain = sum.blocks * RTK_BVH_BLOCK};
    fold_top(w, root, &own, list, capacity);
    rti_parallel(ctx, (uint32_t)w->task_count, fold_task, w);
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
