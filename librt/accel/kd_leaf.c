/* Large leaves of a kd-tree become small binary trees of pieces, a block of triangles each, the last of what is left: what walks
 * in vectors asks for the pieces' boxes before their triangles. So cells need not be split until they list few, where triangles
 * are listed more and more often (a third less memory, rays 1.05 to 1.25 times as fast). The leaf itself stays as it is.
 *
 * A piece's box is what lies around its triangles' parts in the box of the leaf, as references are made (ref.c). The leaf's box
 * is around the parts in its cell, grown, so what is in the cell is in the box grown; a hit in the cell's part of a ray's way is
 * then in the piece's box, by ray.h, points 3 and 4.
 */
#include <stdlib.h>

#include "bvh_build.h"

#define SWEPT 64u /* references that are tried on all three axes; more are halved along the longest */

_Static_assert((SWEPT & (SWEPT - 1u)) == 0u, "an index takes the lowest bits of a number (rank)");

/* A range of items that is to become node `node`. */
typedef struct span {
    uint32_t begin, count, node;
} span;

typedef struct item {
    rti_bvh_box box;
    uint32_t prim;
} item;

typedef struct cutter {
    const rti_bvh *t;
    item *items, *spare;
    uint64_t *keys;
    span *spans;
    size_t item_capacity, spare_capacity, key_capacity, span_capacity, span_count;
} cutter;

/* Keys are in the order of x, and where that is equal in that of `index`, which is their lower half. */
static uint64_t key_of(float x, uint32_t index)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits ^= bits >> 31 ? 0xffffffffu : 0x80000000u;
    return (uint64_t)bits << 32 | index;
}

static int compare(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

/* The order of few items, by x as good as 17 bits of mantissa tell, then by index: each one's place is how many are below it, so
 * nothing has to be foreseen. */
static void rank(const item *items, uint32_t count, uint32_t axis, uint64_t *keys)
{
    int32_t low[SWEPT];
    for (uint32_t i = 0; i < count; i++) {
        const float x = items[i].box.lo[axis] + items[i].box.hi[axis];
        int32_t bits;
        memcpy(&bits, &x, sizeof bits);
        bits ^= bits >> 31 & INT32_MAX;
        low[i] = (bits & ~(int32_t)(SWEPT - 1u)) | (int32_t)i;
    }
    for (uint32_t i = count; i % 4 != 0; i++)
        low[i] = INT32_MAX; /* no item */
    for (uint32_t i = 0; i < count; i += 4) {
        rti_i4 own, below = {0};
        memcpy(&own, low + i, sizeof own);
        for (uint32_t k = 0; k < count; k++)
            below -= rti_i4_set(low[k]) < own;
        for (uint32_t k = 0; k < 4 && i + k < count; k++)
            keys[below[k]] = i + k;
    }
}

static void sort(const item *items, uint32_t count, uint32_t axis, uint64_t *keys)
{
    if (count <= SWEPT) {
        rank(items, count, axis, keys);
        return;
    }
    for (uint32_t i = 0; i < count; i++)
        keys[i] = key_of(items[i].box.lo[axis] + items[i].box.hi[axis], i);
    qsort(keys, count, sizeof *keys, compare);
}

static rti_bvh_box around(const item *items, uint32_t count)
{
    rti_bvh_box box = rti_bvh_nothing();
    for (uint32_t i = 0; i < count; i++)
        rti_bvh_extend(&box, items[i].box);
    return box;
}

/* The cheapest place to part sorted items at, whole blocks on the left; *cost: what it costs. */
static uint32_t sweep(const rti_bvh *t, const item *items, const uint64_t *keys, uint32_t count, float *cost)
{
    float right[SWEPT / RTK_BVH_BLOCK];
    rti_bvh_box box = rti_bvh_nothing();
    uint32_t best = RTK_BVH_BLOCK;
    for (uint32_t i = count; i-- > RTK_BVH_BLOCK;) {
        rti_bvh_extend(&box, items[(uint32_t)keys[i]].box);
        if (i % RTK_BVH_BLOCK == 0)
            right[i / RTK_BVH_BLOCK] = rti_bvh_area(t, box) * rti_bvh_leaf_cost(t, count - i);
    }
    *cost = RTK_INF;
    box = rti_bvh_nothing();
    for (uint32_t i = 0; i + RTK_BVH_BLOCK < count; i += RTK_BVH_BLOCK) {
        float sum;
        for (uint32_t k = i; k < i + RTK_BVH_BLOCK; k++)
            rti_bvh_extend(&box, items[(uint32_t)keys[k]].box);
        sum = rti_bvh_area(t, box) * rti_bvh_leaf_cost(t, i + RTK_BVH_BLOCK) + right[i / RTK_BVH_BLOCK + 1];
        if (sum < *cost) {
            *cost = sum;
            best = i + RTK_BVH_BLOCK;
        }
    }
    return best;
}

/* Of a range's items the order in which the first of them, as many as is returned, are the left part. Keys have room for two. */
static uint32_t part(const rti_bvh *t, const item *items, uint32_t count, uint64_t *keys)
{
    uint32_t at = 0;
    float least = RTK_INF;
    if (count > SWEPT) {
        const rti_bvh_box box = around(items, count);
        const rti_f4 d = box.hi - box.lo;
        sort(items, count, d[0] >= d[1] && d[0] >= d[2] ? 0 : (d[1] >= d[2] ? 1 : 2), keys);
        return count / 2 / RTK_BVH_BLOCK * RTK_BVH_BLOCK;
    }
    for (uint32_t axis = 0; axis < 3; axis++) {
        uint64_t *to = axis == 0 ? keys : keys + count;
        float cost;
        uint32_t place;
        sort(items, count, axis, to);
        place = sweep(t, items, to, count, &cost);
        if (axis > 0 && !(cost < least))
            continue;
        if (axis > 0)
            memcpy(keys, to, count * sizeof *keys);
        least = cost;
        at = place;
    }
    return at;
}

/* A large leaf, node `node` of the kd-tree: its references are from `first` on, its pieces' nodes from `extra` on. */
typedef struct large {
    uint32_t node, first, count, extra;
} large;

static void take_items(const cutter *c, const large *l)
{
    const rti_build_input *in = c->t->b->in;
    const rti_kd_node *leaf = &c->t->kd[l->node];
    const rti_bvh_box all = {{leaf->lo[0], leaf->lo[1], leaf->lo[2]}, {leaf->hi[0], leaf->hi[1], leaf->hi[2]}};
    const rti_f4 grow = rti_f4_set(in->grow);
    rti_cell cell;
    rti_ref clipped;
    memcpy(cell.lo, leaf->lo, sizeof cell.lo);
    memcpy(cell.hi, leaf->hi, sizeof cell.hi);
    for (uint32_t i = 0; i < l->count; i++) {
        item *it = &c->items[i];
        it->prim = c->t->kd_refs[l->first + i];
        const rtk_tri *tri = &in->tris[it->prim];
        const rti_f4 v[3] = {{tri->v0[0], tri->v0[1], tri->v0[2], 0.0f},
                             {tri->v1[0], tri->v1[1], tri->v1[2], 0.0f},
                             {tri->v2[0], tri->v2[1], tri->v2[2], 0.0f}};
        it->box.lo = rti_f4_min(rti_f4_min(v[0], v[1]), v[2]) - grow;
        it->box.hi = rti_f4_max(rti_f4_max(v[0], v[1]), v[2]) + grow;
        if (rti_f4_below(all.lo, it->box.lo) && rti_f4_below(it->box.hi, all.hi))
            continue;
        if (rti_ref_clip(c->t->b, &cell, it->prim, &clipped)) {
            it->box = rti_bvh_ref_box(&clipped);
        } else { /* the builder cuts boxes alone where references are few */
            it->box.lo = rti_f4_max(it->box.lo, all.lo);
            it->box.hi = rti_f4_min(it->box.hi, all.hi);
        }
    }
}

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
    return rti_reserve(ctx, (void **)&c->items, &c->item_capacity, 0, count, sizeof *c->items) &&
           rti_reserve(ctx, (void **)&c->spare, &c->spare_capacity, 0, count, sizeof *c->spare) &&
           rti_reserve(ctx, (void **)&c->keys, &c->key_capacity, count, count, sizeof *c->keys);
}

/* Puts a range's items in the order of the keys. */
static void put_in_order(cutter *c, item *items, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        c->spare[i] = items[(uint32_t)c->keys[i]];
    memcpy(items, c->spare, count * sizeof *items);
}

static bool cut_leaf(cutter *c, const large *l)
{
    const rti_bvh *t = c->t;
    uint32_t extra = l->extra;
    if (!reserve(c, l->count) || !push(c, (span){0, l->count, l->node}))
        return false;
    take_items(c, l);
    while (c->span_count > 0) {
        const span s = c->spans[--c->span_count];
        item *items = c->items + s.begin;
        const rti_bvh_box box = around(items, s.count);
        rti_bvh_node *n = &t->nodes[s.node];
        for (int a = 0; a < 3; a++) {
            n->lo[a] = box.lo[a];
            n->hi[a] = box.hi[a];
        }
        if (s.count <= RTK_BVH_BLOCK) {
            n->child = l->first + s.begin;
            n->count = s.count;
            for (uint32_t i = 0; i < s.count; i++)
                t->order[n->child + i] = items[i].prim;
            continue;
        }
        const uint32_t left = part(t, items, s.count, c->keys);
        put_in_order(c, items, s.count);
        n->child = extra;
        n->count = 0;
        extra += 2;
        if (!push(c, (span){s.begin + left, s.count - left, n->child + 1}) || !push(c, (span){s.begin, left, n->child}))
            return false;
    }
    return true;
}

/* ---- all leaves ----------------------------------------------------------------------------------------------------------- */

#define CHUNK 4096u /* nodes a task */

typedef struct job {
    rti_bvh *t;
    uint32_t *extra; /* a task: nodes of its pieces, then the first of them */
    rt_status *got;
} job;

static uint32_t pieces(uint32_t count)
{
    return (count + RTK_BVH_BLOCK - 1) / RTK_BVH_BLOCK;
}

/* References of a leaf that has more triangles than a block holds, and nothing else; 0: it is none. */
static uint32_t large_count(const rti_bvh *t, uint32_t node)
{
    const rtk_kdnode *n = &t->kd[node].node;
    const uint32_t count = n->b >> 2;
    if ((n->b & 3u) != RTK_KD_LEAF || count <= RTK_BVH_BLOCK)
        return 0;
    for (uint32_t i = 0; i < count && t->b->in->box_count > 0; i++)
        if (t->kd_refs[n->a + i] >= t->b->in->tri_count)
            return 0;
    return count;
}

static void count_task(void *data, uint32_t index)
{
    const job *j = data;
    const uint32_t begin = index * CHUNK, end = rtk_umin(begin + CHUNK, j->t->kd_count);
    j->extra[index] = 0;
    for (uint32_t i = begin; i < end; i++) {
        const uint32_t count = large_count(j->t, i);
        j->extra[index] += count > 0 ? 2 * (pieces(count) - 1) : 0;
    }
}

static void take_leaf(rti_bvh *t, uint32_t node)
{
    const rti_kd_node *from = &t->kd[node];
    rti_bvh_node *n = &t->nodes[node];
    memcpy(n->lo, from->lo, sizeof n->lo);
    memcpy(n->hi, from->hi, sizeof n->hi);
    n->count = from->node.b >> 2;
    n->child = n->count > 0 ? from->node.a : 0;
    memcpy(t->order + from->node.a, t->kd_refs + from->node.a, n->count * sizeof *t->order);
}

static rt_status take_leaves(rti_bvh *t, cutter *c, uint32_t begin, uint32_t end, uint32_t extra)
{
    for (uint32_t i = begin; i < end; i++) {
        const large l = {i, t->kd[i].node.a, large_count(t, i), extra};
        if (rti_cancelled(t->b->cancel))
            return RT_ERROR_CANCELLED;
        if ((t->kd[i].node.b & 3u) != RTK_KD_LEAF)
            continue;
        if (l.count == 0) {
            take_leaf(t, i);
            continue;
        }
        if (!cut_leaf(c, &l))
            return RT_ERROR_MEMORY;
        extra += 2 * (pieces(l.count) - 1);
    }
    return RT_OK;
}

static void cut_task(void *data, uint32_t index)
{
    const job *j = data;
    const uint32_t begin = index * CHUNK, end = rtk_umin(begin + CHUNK, j->t->kd_count);
    cutter c = {.t = j->t};
    j->got[index] = take_leaves(j->t, &c, begin, end, j->extra[index]);
    rti_free(j->t->ctx, c.items, c.item_capacity * sizeof *c.items);
    rti_free(j->t->ctx, c.spare, c.spare_capacity * sizeof *c.spare);
    rti_free(j->t->ctx, c.keys, c.key_capacity * sizeof *c.keys);
    rti_free(j->t->ctx, c.spans, c.span_capacity * sizeof *c.spans);
}

/* Room for all nodes and references; the counts become where each task's first is. */
static rt_status make_room(job *j, uint32_t tasks)
{
    rti_bvh *t = j->t;
    uint64_t nodes = t->kd_count;
    for (uint32_t i = 0; i < tasks; i++) {
        const uint32_t own = j->extra[i];
        j->extra[i] = (uint32_t)nodes;
        nodes += own;
        if (nodes > RTI_NODE_MAX)
            return RT_ERROR_MEMORY;
    }
    t->node_capacity = (size_t)nodes;
    t->nodes = rti_alloc_array(t->ctx, t->node_capacity, sizeof *t->nodes);
    t->order = rti_alloc_array(t->ctx, t->kd_ref_count, sizeof *t->order);
    return t->nodes && t->order ? RT_OK : RT_ERROR_MEMORY;
}

static rt_status cut_all(job *j, uint32_t tasks)
{
    rt_status status;
    rti_parallel(j->t->ctx, tasks, count_task, j);
    status = make_room(j, tasks);
    if (status == RT_OK)
        rti_parallel(j->t->ctx, tasks, cut_task, j);
    for (uint32_t i = 0; i < tasks && status == RT_OK; i++)
        status = j->got[i];
    return status;
}

rt_status rti_kd_cut_leaves(rti_bvh *t)
{
    const uint32_t tasks = (t->kd_count + CHUNK - 1) / CHUNK;
    job j = {t, rti_alloc_array(t->ctx, tasks, sizeof *j.extra), rti_alloc_array(t->ctx, tasks, sizeof *j.got)};
    const rt_status status = j.extra && j.got ? cut_all(&j, tasks) : RT_ERROR_MEMORY;
    rti_free(t->ctx, j.extra, tasks * sizeof *j.extra);
    rti_free(t->ctx, j.got, tasks * sizeof *j.got);
    return status;
}
