/* The BVH's builder: the binary tree over references. Large ranges are split level by level, each by all workers together (a
 * task bins or moves one piece of one range); ranges below a size that depends on the count of primitives alone are then one
 * task each.
 *
 * References move between two buffers: a split reads one and writes the other, left ones from the front of the range's room,
 * right ones from its back.
 */
#include <stdlib.h>
#include <string.h>

#include "bvh_build.h"

#define PIECE_LEAST 1024u /* references: of pieces of this size levels take 1.2 times as long by few workers */
#define PIECE_MOST  4096u
#define NODES_ONCE  256u  /* that a part takes at a time: dense, for memory that is touched has its time */
#define TOUCHED     0.375 /* nodes that are written, a primitive: meshes have .45 to .77 */

typedef struct piece {
    uint32_t range, begin, count;
    uint32_t left, right; /* where its first left reference goes, and where its right ones end */
    rti_bvh_box boxes[2], mids[2];
    rti_bvh_bins bins;
} piece;

typedef struct build {
    rti_bvh t;
    rti_bvh_range *open, *next, *parts;
    size_t open_count, open_capacity, next_count, next_capacity, part_count, part_capacity;
    rti_bvh_split *splits; /* of the open ranges */
    piece *pieces;
    rti_bvh_space_bins *space; /* of the pieces, when splits may be spatial */
    uint32_t piece_count, piece_size;
    uint32_t *first_piece; /* of each open range, and one more */
    atomic_uint *undone;   /* pieces of each open range that the loop over them has not done */
    atomic_uint free_node; /* behind those that parts have taken */
    uint32_t part_limit;
} build;

/* ---- children -------------------------------------------------------------------------------------------------------------- */

/* A split was carried out into the other buffer. */
static void split_children(const rti_bvh_range *r, const rti_bvh_split *s, const rti_bvh_box mids[2], rti_bvh_range out[2])
{
    uint32_t spare = r->room_end - r->room_begin - s->left_count - s->right_count;
    uint32_t edge =
        r->room_begin + s->left_count + (uint32_t)((uint64_t)spare * s->left_count / (s->left_count + s->right_count));
    for (int i = 0; i < 2; i++) {
        out[i].box = i == 0 ? s->left : s->right;
        out[i].mid = mids[i];
        out[i].count = i == 0 ? s->left_count : s->right_count;
        out[i].buffer = r->buffer ^ 1u;
        out[i].depth = r->depth + 1;
    }
    out[0].begin = out[0].room_begin = r->room_begin;
    out[0].room_end = out[1].room_begin = edge;
    out[1].room_end = r->room_end;
    out[1].begin = r->room_end - s->right_count;
}

static void measure(const rti_bvh *t, rti_bvh_range *r)
{
    const rti_ref *refs = t->refs[r->buffer] + r->begin;
    r->box = r->mid = rti_bvh_nothing();
    for (uint32_t i = 0; i < r->count; i++) {
        rti_bvh_box box = rti_bvh_ref_box(&refs[i]), mid;
        mid.lo = mid.hi = rti_bvh_mid(box);
        rti_bvh_extend(&r->box, box);
        rti_bvh_extend(&r->mid, mid);
    }
}

/* Nothing parts them, or the tree is deep already: the first half and the second. */
static void halve(const rti_bvh *t, const rti_bvh_range *r, rti_bvh_range out[2])
{
    uint32_t half = r->count / 2;
    out[0] = out[1] = *r;
    out[0].depth = out[1].depth = r->depth + 1;
    out[0].count = half;
    out[1].count = r->count - half;
    out[1].begin = r->begin + half;
    out[0].room_end = out[1].room_begin = out[1].begin;
    measure(t, &out[0]);
    measure(t, &out[1]);
}

static void put_box(rti_bvh_node *node, rti_bvh_box box)
{
    rti_f4_store(node->lo, box.lo);
    rti_f4_store(node->hi, box.hi);
    node->child = node->count = 0;
}

/* ---- one part, depth first ----------------------------------------------------------------------------------------------------
 */

static void put_leaf(const rti_bvh *t, const rti_bvh_range *r, uint32_t first, const rti_ref *refs, uint32_t count)
{
    rti_bvh_node *node = &t->nodes[r->node];
    put_box(node, r->box);
    node->child = first;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t same = 0;
        while (t->spatial && count <= 64 && same < node->count && t->order[first + same] != refs[i].prim)
            same++;
        if (!t->spatial || count > 64 || same == node->count) /* two pieces of one triangle are one */
            t->order[first + node->count++] = refs[i].prim;
    }
}

/* Nodes that a part has taken. */
typedef struct taken {
    uint32_t at, end;
} taken;

/* Two nodes side by side. Their numbers depend on who works; nothing else does on them. */
static uint32_t take_pair(build *job, taken *own)
{
    uint32_t pair;
    if (own->at == own->end) {
        own->at = atomic_fetch_add_explicit(&job->free_node, NODES_ONCE, memory_order_relaxed);
        own->end = own->at + NODES_ONCE;
    }
    pair = own->at;
    own->at += 2;
    return pair;
}

/* Triangles and others do not share a leaf that has blocks. The references of a leaf are few, and no longer needed in place. */
static void write_leaf(build *job, const rti_bvh_range *r, taken *own)
{
    const rti_bvh *t = &job->t;
    rti_ref *refs = t->refs[r->buffer] + r->begin, *others = t->refs[r->buffer ^ 1u] + r->begin;
    uint32_t tris = 0, rest = 0, pair;
    for (uint32_t i = 0; t->blocks && i < r->count; i++) {
        if (refs[i].prim < t->b->in->tri_count)
            refs[tris++] = refs[i];
        else
            others[rest++] = refs[i];
    }
    if (tris == 0 || rest == 0) {
        put_leaf(t, r, r->begin, rest ? others : refs, r->count);
        return;
    }
    rti_bvh_range half[2];
    half[0] = half[1] = *r;
    memcpy(refs + tris, others, rest * sizeof *refs);
    half[0].count = tris;
    half[1].count = rest;
    half[1].begin += tris;
    put_box(&t->nodes[r->node], r->box);
    pair = take_pair(job, own);
    t->nodes[r->node].child = pair;
    for (uint32_t i = 0; i < 2; i++) {
        half[i].node = pair + i;
        measure(t, &half[i]);
        put_leaf(t, &half[i], half[i].begin, t->refs[r->buffer] + half[i].begin, half[i].count);
    }
}

/* Splits by the chosen plane into the other buffer. */
static void carry_out(const rti_bvh *t, const rti_bvh_range *r, rti_bvh_split *s, rti_bvh_range out[2])
{
    const rti_ref *refs = t->refs[r->buffer] + r->begin;
    rti_ref *to = t->refs[r->buffer ^ 1u];
    rti_bvh_box mids[2] = {rti_bvh_nothing(), rti_bvh_nothing()}, boxes[2] = {rti_bvh_nothing(), rti_bvh_nothing()};
    if (s->spatial) {
        rti_bvh_spatial_scatter(t, s, refs, r->count, to + r->room_begin, to + r->room_end, boxes, mids);
        s->left = boxes[0];
        s->right = boxes[1];
    } else {
        t->kernels->scatter(s, refs, r->count, to + r->room_begin, to + r->room_end, mids);
    }
    split_children(r, s, mids, out);
}

/* false: it is to be a leaf. */
static bool split_range(const rti_bvh *t, const rti_bvh_range *r, rti_bvh_range out[2])
{
    rti_bvh_split s;
    rti_bvh_bins bins;
    const rti_ref *refs = t->refs[r->buffer] + r->begin;
    float area = rti_bvh_area(t, r->box);
    if (r->count == 1 ||
        (r->count <= t->most && !(t->blocks && area > t->finest_area) && rti_bvh_leaf_cost(t, r->count) <= t->b->cost_traverse))
        return false; /* no split can be cheaper, or not by much */
    rti_bvh_split_begin(r, &s);
    t->kernels->bin(&s, refs, r->count, &bins);
    t->kernels->find(t, &bins, &s);
    if (t->spatial && rti_bvh_spatial_begin(t, r, &s)) {
        rti_bvh_space_bins space;
        rti_bvh_spatial_bin(t, &s, refs, r->count, &space);
        rti_bvh_spatial_find(t, &space, r->room_end - r->room_begin, &s);
    }
    if (r->count <= t->most && !(t->blocks && area > t->fine_area) &&
        !(t->b->cost_traverse * area + s.cost < rti_bvh_leaf_cost(t, r->count) * area))
        return false;
    if (s.axis == 3 || r->depth >= RTI_BVH_CAREFUL)
        halve(t, r, out);
    else
        carry_out(t, r, &s, out);
    return true;
}

static void part_task(void *data, uint32_t index)
{
    build *job = data;
    const rti_bvh *t = &job->t;
    rti_bvh_range stack[RTI_BVH_BINARY + 2], children[2];
    uint32_t top = 1, pair, work = 0;
    taken own = {0, 0};
    stack[0] = job->parts[index];
    while (top > 0) {
        rti_bvh_range r = stack[--top];
        work += r.count + 8;
        if (work > 16384) {
            work = 0;
            if (rti_cancelled(t->b->cancel))
                return;
        }
        if (!split_range(t, &r, children)) {
            write_leaf(job, &r, &own);
            continue;
        }
        put_box(&t->nodes[r.node], r.box);
        pair = take_pair(job, &own);
        t->nodes[r.node].child = pair;
        children[0].node = pair;
        children[1].node = pair + 1;
        stack[top++] = children[1];
        stack[top++] = children[0];
    }
}

/* ---- large ranges, level by level
 * ----------------------------------------------------------------------------------------------- */

static void choose(build *job, uint32_t index)
{
    rti_bvh_split *s = &job->splits[index];
    uint32_t first = job->first_piece[index];
    rti_bvh_bins bins = job->pieces[first].bins;
    for (uint32_t i = first + 1; i < job->first_piece[index + 1]; i++)
        job->t.kernels->add(s, &bins, &job->pieces[i].bins);
    job->t.kernels->find(&job->t, &bins, s);
    s->wants_space = job->t.spatial && rti_bvh_spatial_begin(&job->t, &job->open[index], s);
}

/* Takes a spatial split where that is cheaper, and says where each piece's references go. */
static void place(build *job, uint32_t index)
{
    rti_bvh_split *s = &job->splits[index];
    const rti_bvh_range *r = &job->open[index];
    uint32_t first = job->first_piece[index], end = job->first_piece[index + 1];
    uint32_t left = r->room_begin, right = r->room_end;
    if (s->wants_space) {
        rti_bvh_space_bins space = job->space[first];
        for (uint32_t i = first + 1; i < end; i++)
            rti_bvh_space_bins_add(&space, &job->space[i]);
        rti_bvh_spatial_find(&job->t, &space, r->room_end - r->room_begin, s);
    }
    if (r->depth >= RTI_BVH_CAREFUL)
        s->axis = 3;
    for (uint32_t i = first; i < end && s->axis < 3; i++) {
        piece *p = &job->pieces[i];
        uint32_t lefts = 0, rights = 0;
        if (s->spatial) {
            rti_bvh_spatial_counts(s, &job->space[i], &lefts, &rights);
        } else {
            lefts = rti_bvh_split_left(s, &p->bins);
            rights = p->count - lefts;
        }
        p->left = left;
        p->right = right;
        p->mids[0] = p->mids[1] = p->boxes[0] = p->boxes[1] = rti_bvh_nothing();
        left += lefts;
        right -= rights;
    }
}

/* Whether this piece of a range is the last to be done: who did it goes on with the range. */
static bool is_last(build *job, uint32_t range)
{
    return atomic_fetch_sub(&job->undone[range], 1) == 1 && !rti_cancelled(job->t.b->cancel);
}

static void bin_task(void *data, uint32_t index)
{
    build *job = data;
    piece *p = &job->pieces[index];
    const rti_bvh_range *r = &job->open[p->range];
    if (rti_cancelled(job->t.b->cancel))
        return;
    job->t.kernels->bin(&job->splits[p->range], job->t.refs[r->buffer] + p->begin, p->count, &p->bins);
    if (!is_last(job, p->range))
        return;
    choose(job, p->range);
    if (job->t.spatial)
        atomic_store(&job->undone[p->range], job->first_piece[p->range + 1] - job->first_piece[p->range]);
    else
        place(job, p->range);
}

static void space_task(void *data, uint32_t index)
{
    build *job = data;
    piece *p = &job->pieces[index];
    const rti_bvh_split *s = &job->splits[p->range];
    if (rti_cancelled(job->t.b->cancel))
        return;
    if (s->wants_space)
        rti_bvh_spatial_bin(&job->t, s, job->t.refs[job->open[p->range].buffer] + p->begin, p->count, &job->space[index]);
    if (is_last(job, p->range))
        place(job, p->range);
}

static void scatter_task(void *data, uint32_t index)
{
    build *job = data;
    piece *p = &job->pieces[index];
    const rti_bvh_range *r = &job->open[p->range];
    const rti_bvh_split *s = &job->splits[p->range];
    const rti_ref *refs = job->t.refs[r->buffer] + p->begin;
    rti_ref *to = job->t.refs[r->buffer ^ 1u];
    if (s->axis == 3 || rti_cancelled(job->t.b->cancel))
        return;
    if (s->spatial)
        rti_bvh_spatial_scatter(&job->t, s, refs, p->count, to + p->left, to + p->right, p->boxes, p->mids);
    else
        job->t.kernels->scatter(s, refs, p->count, to + p->left, to + p->right, p->mids);
}

static bool add_range(build *job, const rti_bvh_range *r)
{
    bool part = r->count <= job->part_limit;
    rti_bvh_range **list = part ? &job->parts : &job->next;
    size_t *count = part ? &job->part_count : &job->next_count, *capacity = part ? &job->part_capacity : &job->next_capacity;
    if (!rti_reserve(job->t.ctx, (void **)list, capacity, *count, 1, sizeof *r))
        return false;
    (*list)[(*count)++] = *r;
    return true;
}

static bool close_range(build *job, uint32_t index)
{
    const rti_bvh_range *r = &job->open[index];
    rti_bvh_split *s = &job->splits[index];
    rti_bvh_range children[2];
    if (!rti_reserve(job->t.ctx, (void **)&job->t.nodes, &job->t.node_capacity, job->t.top_count, 2, sizeof *job->t.nodes))
        return false;
    if (s->axis < 3) {
        rti_bvh_box mids[2] = {rti_bvh_nothing(), rti_bvh_nothing()}, boxes[2] = {rti_bvh_nothing(), rti_bvh_nothing()};
        for (uint32_t i = job->first_piece[index]; i < job->first_piece[index + 1]; i++)
            for (int k = 0; k < 2; k++) {
                rti_bvh_extend(&mids[k], job->pieces[i].mids[k]);
                rti_bvh_extend(&boxes[k], job->pieces[i].boxes[k]);
            }
        s->left = s->spatial ? boxes[0] : s->left;
        s->right = s->spatial ? boxes[1] : s->right;
        split_children(r, s, mids, children);
    } else {
        halve(&job->t, r, children);
    }
    put_box(&job->t.nodes[r->node], r->box);
    job->t.nodes[r->node].child = job->t.top_count;
    for (int i = 0; i < 2; i++) {
        children[i].node = job->t.top_count++;
        if (!add_range(job, &children[i]))
            return false;
    }
    return true;
}

static void cut_pieces(build *job)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < job->open_count; i++) {
        const rti_bvh_range *r = &job->open[i];
        job->first_piece[i] = n;
        rti_bvh_split_begin(r, &job->splits[i]);
        for (uint32_t at = 0; at < r->count; at += job->piece_size) {
            piece *p = &job->pieces[n++];
            p->range = i;
            p->begin = r->begin + at;
            p->count = rtk_umin(r->count - at, job->piece_size);
        }
        atomic_init(&job->undone[i], n - job->first_piece[i]);
    }
    job->first_piece[job->open_count] = n;
}

static rt_status build_level(build *job)
{
    rt_context *ctx = job->t.ctx;
    rti_bvh_range *swap = job->open;
    size_t swap_capacity = job->open_capacity;
    rt_status status = RT_ERROR_MEMORY;
    job->open = job->next;
    job->open_capacity = job->next_capacity;
    job->open_count = job->next_count;
    job->next = swap;
    job->next_capacity = swap_capacity;
    job->next_count = 0;
    job->piece_count = 0;
    for (size_t i = 0; i < job->open_count; i++)
        job->piece_count += (job->open[i].count + job->piece_size - 1) / job->piece_size;
    job->splits = rti_alloc_array(ctx, job->open_count, sizeof *job->splits);
    job->pieces = rti_alloc_array(ctx, job->piece_count, sizeof *job->pieces);
    job->first_piece = rti_alloc_array(ctx, job->open_count + 1, sizeof *job->first_piece);
    job->undone = rti_alloc_array(ctx, job->open_count, sizeof *job->undone);
    job->space = job->t.spatial ? rti_alloc_array(ctx, job->piece_count, sizeof *job->space) : NULL;
    if (job->splits && job->pieces && job->first_piece && job->undone && (job->space || !job->t.spatial)) {
        cut_pieces(job);
        rti_parallel(ctx, job->piece_count, bin_task, job);
        if (job->t.spatial)
            rti_parallel(ctx, job->piece_count, space_task, job);
        rti_parallel(ctx, job->piece_count, scatter_task, job);
        status = rti_cancelled(job->t.b->cancel) ? RT_ERROR_CANCELLED : RT_OK;
    }
    for (uint32_t i = 0; i < job->open_count && status == RT_OK; i++)
        status = close_range(job, i) ? RT_OK : RT_ERROR_MEMORY;
    rti_free(ctx, job->splits, job->open_count * sizeof *job->splits);
    rti_free(ctx, job->pieces, job->piece_count * sizeof *job->pieces);
    rti_free(ctx, job->first_piece, (job->open_count + 1) * sizeof *job->first_piece);
    rti_free(ctx, job->undone, job->open_count * sizeof *job->undone);
    rti_free(ctx, job->space, job->piece_count * sizeof *job->space);
    return status;
}

/* ---- the whole
 * ---------------------------------------------------------------------------------------------------------------------- */

/* Room for the top's nodes and, behind them, for those of so many parts; most of it is never touched. */
static bool reserve_nodes(build *job, size_t parts)
{
    rti_bvh *t = &job->t;
    const size_t count = 2 * t->room + parts * NODES_ONCE;
    rti_bvh_node *nodes;
    if (count <= t->node_capacity)
        return true;
    nodes = rti_alloc_array(t->ctx, count, sizeof *nodes);
    if (!nodes)
        return false;
    if (t->nodes)
        memcpy(nodes, t->nodes, t->top_count * sizeof *nodes);
    rti_free(t->ctx, t->nodes, t->node_capacity * sizeof *nodes);
    t->nodes = nodes;
    t->node_capacity = count;
    return true;
}

static int by_place(const void *a, const void *b)
{
    const uint32_t x = ((const rti_bvh_range *)a)->room_begin, y = ((const rti_bvh_range *)b)->room_begin;
    return (x > y) - (x < y);
}

static rt_status build_binary(build *job, const rti_bvh_range *root)
{
    rti_bvh *t = &job->t;
    rt_status status = RT_OK;
    if (!add_range(job, root))
        return RT_ERROR_MEMORY;
    t->top_count = 1;
    while (status == RT_OK && job->next_count > 0)
        status = build_level(job);
    if (status != RT_OK)
        return status;
    if (!reserve_nodes(job, job->part_count))
        return RT_ERROR_MEMORY;
    qsort(job->parts, job->part_count, sizeof *job->parts, by_place); /* whose references a worker has written, he goes on with */
    atomic_init(&job->free_node, t->top_count);
    rti_parallel(t->ctx, (uint32_t)job->part_count, part_task, job);
    return rti_cancelled(t->b->cancel) ? RT_ERROR_CANCELLED : RT_OK;
}

/* What leaves and their tests cost: settled here, for it depends on what the tree is over. */
static void settle(rti_bvh *t)
{
    const rti_build *b = t->b;
    t->grow2 = rti_f4_xyz(rti_f4_set(2.0f * b->in->grow));
    t->blocks = b->in->tri_count > 0 && b->builder != RTI_BUILD_BVH_COMPACT;
    t->depth = b->max_depth;
    t->grow = b->in->grow;
    t->most = b->leaf_size;
    _Static_assert(RTK_BVH_BLOCK == 1u << 2u, "what a block of triangles holds");
    t->leaf_cost = b->cost_intersect;
    t->together = t->blocks ? 2u : (b->in->tri_count > 0 || b->in->balls != 0 ? 1u : 0u);
    t->balls = b->in->tri_count == 0 && b->in->balls != 0;
    t->spatial = b->builder == RTI_BUILD_BVH_SPATIAL;
    t->thinnest = 4.0f * b->in->grow;
    rti_bvh_set_areas(t);
    t->room = b->prim_count > 0 ? b->prim_count : 1;
    t->fine_area = 4.0f * t->root_area / (float)t->room; /* less is met by few rays, and most ranges are less */
    t->finest_area = 5.0f * t->fine_area;
    if (t->spatial) {
        const uint32_t most = RTI_REF_MAX / 2;
        t->room = (size_t)rtk_min((float)t->room * b->duplication + 16.0f, (float)most);
    }
    t->room = t->room < b->prim_count ? b->prim_count : t->room;
}

/* Some pieces for each worker. The tree is the same whatever they are. */
static uint32_t piece_size(const rt_context *ctx, uint32_t count)
{
    const uint32_t share = count / rt_context_workers(ctx) / 4;
    return share < PIECE_LEAST ? PIECE_LEAST : rtk_umin(share, PIECE_MOST);
}

rt_status rti_bvh_build(rt_context *ctx, const rti_build *b, double start, void **chunk, size_t *size)
{
    build job = {.t = {.ctx = ctx, .b = b, .kernels = rti_bvh_kernels_at(rti_context_isa(ctx))}};
    rti_bvh *t = &job.t;
    rti_bvh_range root;
    rt_status status = RT_ERROR_MEMORY;
    settle(t);
    job.part_limit = b->prim_count / 128 > 1024 ? b->prim_count / 128 : 1024;
    job.piece_size = piece_size(ctx, b->prim_count);
    t->refs[0] = rti_alloc_array(ctx, 2 * t->room, sizeof(rti_ref));
    t->order = rti_alloc_array(ctx, t->room, sizeof *t->order);
    if (t->refs[0] && t->order && reserve_nodes(&job, 1 + 2 * (t->room / job.part_limit))) {
        t->refs[1] = t->refs[0] + t->room;
        rti_touch_large(ctx, t->refs[0], (t->spatial ? b->prim_count : 2 * t->room) * sizeof(rti_ref), t->nodes,
                        (size_t)(TOUCHED * b->prim_count) * sizeof *t->nodes);
        status = rti_bvh_make_refs(t, job.piece_size, &root);
    }
    if (status == RT_OK && root.count > 0)
        status = build_binary(&job, &root);
    if (status == RT_OK)
        status = rti_bvh_write(t, root.count > 0 ? 0 : RTK_INVALID, start, chunk, size);
    rti_free(ctx, t->refs[0], 2 * t->room * sizeof(rti_ref));
    rti_free(ctx, t->order, t->room * sizeof *t->order);
    rti_free(ctx, t->nodes, t->node_capacity * sizeof *t->nodes);
    rti_free(ctx, job.open, job.open_capacity * sizeof *job.open);
    rti_free(ctx, job.next, job.next_capacity * sizeof *job.next);
    rti_free(ctx, job.parts, job.part_capacity * sizeof *job.parts);
    return status;
}
