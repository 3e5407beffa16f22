/* Large leaves of cells become small binary trees of pieces, a few triangles each, of which bvh_fold.c makes the leaves of
 * nodes of eight: what walks in vectors asks for those' boxes before their triangles. So cells need not be split until they list
 * few, where triangles are listed more and more often (build.c: intersect_cost, octree_leaf). Hundreds are parted
 * by the bins of a BVH's builder, fewer at any place. Pieces of whole blocks would be half as many, but put a wall's triangle
 * together with what stands before it, and every other row of a surface in two: rays were 1.01 to 1.45 times as slow by them. The
 * leaf itself stays as it is. What else it lists goes into pieces of its own: one sphere would else have all of a cell's
 * triangles met one by one.
 *
 * A piece's box is what lies around its triangles' parts in the box of the leaf (cell_piece.c). The leaf's box
 * is around the parts in its cell, grown, so what is in the cell is in the box grown; a hit in the cell's part of a ray's way is
 * then in the piece's box, by ray.h, points 3 and 4.
 */
#include "cell_build.h"

#define PIECE 2u /* triangles that are never parted; of a few more kernels tell whether it is worth it */

RTI_ISA_TABLES(rti_cell_piece_kernels, rti_cell_piece_kernels_at)

/* A range of items that is to become node `node`, so many ranges below the leaf. */
typedef struct span {
    uint32_t begin, count, node, depth;
} span;

/* own: nodes of the pieces, two at a time, numbered from cell_count on. */
typedef struct cutter {
    const rti_bvh *t;
    const rti_cell_piece_kernels *kernels;
    rti_bvh_node *own;
    uint32_t own_count;
    size_t own_capacity;
    rti_ref *items, *spare;
    uint32_t *prims; /* a leaf's triangles, where there are shapes, too */
    span *spans;
    size_t item_capacity, spare_capacity, prim_capacity, span_capacity, span_count;
} cutter;

/* Of ranges that are binned, at most so many lie in each other: below them halves are taken as they come. */
#define CAREFUL 32u

/* Puts more than are swept in order by the cheapest of a BVH's bins; returns how many of them are the left part. */
static uint32_t part_many(const rti_bvh *t, const rti_ref *items, uint32_t count, uint32_t depth, rti_ref *sorted)
{
    rti_bvh_box mids[2] = {rti_bvh_nothing(), rti_bvh_nothing()};
    rti_bvh_split split = {.axis = 3};
    if (depth < CAREFUL)
        rti_bvh_split_refs(t, items, count, &split);
    if (split.axis == 3) {
        memcpy(sorted, items, count * sizeof *items);
        return count / 2;
    }
    t->kernels->scatter(&split, items, count, sorted, sorted + count, mids);
    return split.left_count;
}

/* A large leaf, node `node` of the cells, and its references, from `first` on. */
typedef struct large {
    uint32_t node, first, count;
} large;

static bool push(cutter *c, span s)
{
    if (!rti_reserve(c->t->ctx, (void **)&c->spans, &c->span_capacity, c->span_count, 1, sizeof *c->spans))
        return false;
    c->spans[c->span_count++] = s;
    return true;
}

static bool reserve(cutter *c, uint32_t count)
{
    rt_context *ctx = c->t->ctx;
    if (c->t->b->in->box_count > 0 && !rti_reserve(ctx, (void **)&c->prims, &c->prim_capacity, 0, count, sizeof *c->prims))
        return false;
    return rti_reserve(ctx, (void **)&c->items, &c->item_capacity, 0, count, sizeof *c->items) &&
           rti_reserve(ctx, (void **)&c->spare, &c->spare_capacity, 0, count, sizeof *c->spare);
}

static rti_bvh_node *node_at(const cutter *c, uint32_t node)
{
    return node < c->t->cell_count ? &c->t->nodes[node] : &c->own[node - c->t->cell_count];
}

/* Gives node `node` two children and returns the first; 0: no memory. */
static uint32_t take_pair(cutter *c, uint32_t node)
{
    const uint32_t pair = c->t->cell_count + c->own_count;
    if (!rti_reserve(c->t->ctx, (void **)&c->own, &c->own_capacity, c->own_count, 2, sizeof *c->own))
        return 0;
    node_at(c, node)->child = pair;
    node_at(c, node)->count = 0;
    c->own_count += 2;
    return pair;
}

/* The part of a shape's box that is in the leaf's. */
static rti_ref shape_item(const rti_bvh *t, const rti_cell_node *leaf, uint32_t prim)
{
    const float *box = t->b->in->boxes[prim - t->b->in->tri_count];
    rti_ref ref = {.prim = prim};
    for (int a = 0; a < 3; a++) {
        ref.lo[a] = rtk_max(box[a] - t->b->in->grow, leaf->lo[a]);
        ref.hi[a] = rtk_min(box[3 + a] + t->b->in->grow, leaf->hi[a]);
    }
    return ref;
}

/* What a leaf lists becomes items, triangles before shapes. Returns how many are triangles. */
static uint32_t take_items(cutter *c, const large *l)
{
    const rti_bvh *t = c->t;
    const rti_cell_node *leaf = &t->cells[l->node];
    const uint32_t *refs = t->own->refs + l->first;
    uint32_t tris = 0, shapes = 0;
    if (t->b->in->box_count == 0) {
        c->kernels->refs(t->b->in, leaf->lo, leaf->hi, refs, l->count, c->items);
        return l->count;
    }
    for (uint32_t i = 0; i < l->count; i++) {
        if (refs[i] < t->b->in->tri_count)
            c->prims[tris++] = refs[i];
        else
            c->items[l->count - ++shapes] = shape_item(t, leaf, refs[i]);
    }
    if (tris > 0)
        c->kernels->refs(t->b->in, leaf->lo, leaf->hi, c->prims, tris, c->items);
    return tris;
}

static rt_status cut_leaf(cutter *c, const large *l)
{
    const rti_bvh *t = c->t;
    uint32_t work = 0;
    if (!reserve(c, l->count) || !push(c, (span){0, l->count, l->node, 0}))
        return RT_ERROR_MEMORY;
    const uint32_t tris = take_items(c, l);
    while (c->span_count > 0) {
        const span s = c->spans[--c->span_count];
        rti_ref *items = c->items + s.begin;
        const rti_bvh_box box = c->kernels->around(items, s.count);
        rti_bvh_node *n = node_at(c, s.node);
        uint32_t left = 0, pair;
        work += s.count + 16;
        if (work > 65536) {
            work = 0;
            if (rti_cancelled(t->b->cancel))
                return RT_ERROR_CANCELLED;
        }
        for (int a = 0; a < 3; a++) {
            n->lo[a] = box.lo[a];
            n->hi[a] = box.hi[a];
        }
        if (s.begin < tris && tris < s.begin + s.count) {
            left = tris - s.begin;
            memcpy(c->spare, items, s.count * sizeof *items);
        } else if (s.count > RTI_CELL_SWEPT)
            left = part_many(t, items, s.count, s.depth, c->spare);
        else if (s.count > PIECE)
            left = c->kernels->part(t, items, s.count, rti_bvh_area(t, box), c->spare);
        if (left == 0) {
            n->child = l->first + s.begin;
            n->count = s.count;
            for (uint32_t i = 0; i < s.count; i++)
                t->order[n->child + i] = items[i].prim;
            continue;
        }
        memcpy(items, c->spare, s.count * sizeof *items);
        pair = take_pair(c, s.node);
        if (pair == 0 || !push(c, (span){s.begin + left, s.count - left, pair + 1, s.depth + 1}) ||
            !push(c, (span){s.begin, left, pair, s.depth + 1}))
            return RT_ERROR_MEMORY;
    }
    return RT_OK;
}

/* ---- all leaves ----------------------------------------------------------------------------------------------------------- */

#define CHUNK 32u /* nodes a task: of five thousand, some for each of many workers */

/* Of a task: what became of it, the nodes of its pieces, and where they will be. */
typedef struct made {
    rt_status got;
    rti_bvh_node *own;
    uint32_t count, first;
    size_t size;
} made;

typedef struct job {
    rti_bvh *t;
    made *made;
} job;

/* References of a leaf that has more of them than a piece holds, or of two kinds; 0: it is none. Where there are shapes alone,
 * cells are small. */
static uint32_t large_count(const rti_bvh *t, uint32_t node)
{
    const rtk_kdnode *n = &t->cells[node].node;
    const uint32_t count = n->b >> 2;
    const bool many = count > PIECE || (count == 2 && t->b->in->box_count > 0);
    return (n->b & 3u) == RTK_KD_LEAF && many && t->b->in->tri_count > 0 ? count : 0;
}

static void take_leaf(rti_bvh *t, uint32_t node)
{
    const rti_cell_node *from = &t->cells[node];
    rti_bvh_node *n = &t->nodes[node];
    memcpy(n->lo, from->lo, sizeof n->lo);
    memcpy(n->hi, from->hi, sizeof n->hi);
    n->count = from->node.b >> 2;
    n->child = n->count > 0 ? from->node.a : 0;
    memcpy(t->order + from->node.a, t->own->refs + from->node.a, n->count * sizeof *t->order);
}

static rt_status take_leaves(rti_bvh *t, cutter *c, uint32_t begin, uint32_t end)
{
    for (uint32_t i = begin; i < end; i++) {
        const large l = {i, t->cells[i].node.a, large_count(t, i)};
        if (rti_cancelled(t->b->cancel))
            return RT_ERROR_CANCELLED;
        if ((t->cells[i].node.b & 3u) != RTK_KD_LEAF)
            continue;
        if (l.count == 0) {
            take_leaf(t, i);
            continue;
        }
        const rt_status status = cut_leaf(c, &l);
        if (status != RT_OK)
            return status;
    }
    return RT_OK;
}

static uint32_t end_of(const job *j, uint32_t index)
{
    return rtk_umin((index + 1) * CHUNK, j->t->cell_count);
}

static void cut_task(void *data, uint32_t index)
{
    const job *j = data;
    rt_context *ctx = j->t->ctx;
    made *m = &j->made[index];
    cutter c = {.t = j->t, .kernels = rti_cell_piece_kernels_at(rti_context_isa(ctx))};
    m->got = take_leaves(j->t, &c, index * CHUNK, end_of(j, index));
    rti_free(ctx, c.items, c.item_capacity * sizeof *c.items);
    rti_free(ctx, c.spare, c.spare_capacity * sizeof *c.spare);
    rti_free(ctx, c.prims, c.prim_capacity * sizeof *c.prims);
    rti_free(ctx, c.spans, c.span_capacity * sizeof *c.spans);
    m->own = c.own;
    m->count = c.own_count;
    m->size = c.own_capacity * sizeof *c.own;
}

/* Nodes of a task's pieces go where all will be. */
static void place_task(void *data, uint32_t index)
{
    const job *j = data;
    const rti_bvh *t = j->t;
    made *m = &j->made[index];
    const uint32_t behind = m->first - t->cell_count;
    for (uint32_t i = 0; i < m->count; i++) {
        rti_bvh_node *n = &t->nodes[m->first + i];
        *n = m->own[i];
        if (n->count == 0)
            n->child += behind;
    }
    for (uint32_t i = index * CHUNK; i < end_of(j, index); i++)
        if (t->nodes[i].count == 0 && large_count(t, i) > 0)
            t->nodes[i].child += behind;
    rti_free(t->ctx, m->own, m->size);
    m->own = NULL;
}

/* Room for the pieces' nodes behind the others. */
static rt_status make_room(job *j, uint32_t tasks)
{
    rti_bvh *t = j->t;
    uint64_t nodes = t->cell_count;
    rti_bvh_node *all;
    for (uint32_t i = 0; i < tasks; i++) {
        j->made[i].first = (uint32_t)nodes;
        nodes += j->made[i].count;
        if (nodes > RTI_NODE_MAX)
            return RT_ERROR_MEMORY;
    }
    all = rti_realloc(t->ctx, t->nodes, t->node_capacity * sizeof *all, (size_t)nodes * sizeof *all);
    if (!all)
        return RT_ERROR_MEMORY;
    t->nodes = all;
    t->node_capacity = (size_t)nodes;
    return RT_OK;
}

static rt_status cut_all(job *j, uint32_t tasks)
{
    rt_status status = RT_OK;
    rti_parallel(j->t->ctx, tasks, cut_task, j);
    for (uint32_t i = 0; i < tasks && status == RT_OK; i++)
        status = j->made[i].got;
    if (status == RT_OK)
        status = make_room(j, tasks);
    if (status == RT_OK)
        rti_parallel(j->t->ctx, tasks, place_task, j);
    return status;
}

rt_status rti_cells_cut(rti_bvh *t)
{
    const uint32_t tasks = (t->cell_count + CHUNK - 1) / CHUNK;
    job j = {t, rti_alloc_array(t->ctx, tasks, sizeof *j.made)};
    rt_status status = RT_ERROR_MEMORY;
    t->node_capacity = t->cell_count;
    t->nodes = rti_alloc_array(t->ctx, t->node_capacity, sizeof *t->nodes);
    t->order = rti_alloc_array(t->ctx, t->own->ref_count, sizeof *t->order);
    if (j.made) {
        memset(j.made, 0, tasks * sizeof *j.made);
        if (t->nodes && t->order)
            status = cut_all(&j, tasks);
        for (uint32_t i = 0; i < tasks; i++)
            rti_free(t->ctx, j.made[i].own, j.made[i].size);
    }
    rti_free(t->ctx, j.made, tasks * sizeof *j.made);
    return status;
}
