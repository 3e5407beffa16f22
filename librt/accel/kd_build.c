/* The kd-tree's builders: a node is split where kd_split.c says, until a leaf, which may be parted into pieces, is cheaper. */
#include <string.h>

#include "kd_build.h"

#define DEAL      128u                /* references dealt out at a time */
#define STACK_MAX (RTK_KD_DEPTH + 2u) /* nodes that wait: one a level below the one at work */

/* Of triangles that can be told by boxes two pieces cost half of what they do together, and a plane's sides, three quarters;
 * needles that lie across each other cost as much either way, and less by the next plane. */
#define PARTS 1.1f

/* Do planes part the references about as well as they are parted as they are, in pieces, or better? both: what a plane's two
 * sides cost, in references of the whole cell. */
static bool planes_part(const rti_build *b, const rti_item *it, const rti_ref *refs, float both)
{
    const rti_bvh t = {
        .b = b, .kernels = rti_bvh_kernels_at(b->isa), .leaf_cost = 1.0f, .unit = rti_bvh_unit(it->cell.lo, it->cell.hi)};
    rti_bvh_split split;
    rti_bvh_split_refs(&t, refs, it->count, &split);
    return both * rti_bvh_area_of(&t, it->cell.lo, it->cell.hi) < PARTS * split.cost;
}

/* Settles how `it` is split; false: it is a leaf. Where planes are sought that cost_intersect alone does not ask for, those are
 * taken that pieces are no match for. ctx, scratch: as rti_kd_find_split has them. */
static bool choose(rt_context *ctx, const rti_build *b, const rti_item *it, const rti_ref *refs, float *scratch,
                   rti_kd_split *split)
{
    if (it->count <= b->leaf_size || it->depth >= b->max_depth)
        return false;
    *split = rti_kd_find_split(ctx, b, &it->cell, refs, it->count, scratch);
    if (split->axis == 3 || (uint64_t)split->left_count + split->right_count > it->budget)
        return false;
    if (b->cost_sought == b->cost_intersect)
        return true;
    const float both = (split->cost - b->cost_traverse) / b->cost_sought;
    return b->cost_traverse + b->cost_intersect * both < b->cost_intersect * (float)it->count || planes_part(b, it, refs, both);
}

static void make_children(const rti_item *it, const rti_kd_split *split, const uint32_t counts[2], rti_item out[2])
{
    uint64_t sum = (uint64_t)counts[0] + counts[1];
    for (int i = 0; i < 2; i++) {
        out[i].cell = it->cell;
        out[i].depth = it->depth + 1;
        out[i].count = counts[i];
        out[i].budget = sum ? (uint32_t)((uint64_t)it->budget * counts[i] / sum) : 0;
    }
    out[0].cell.hi[split->axis] = out[1].cell.lo[split->axis] = split->pos;
}

static void write_split(rti_cell_node *node, const rti_kd_split *split, uint32_t child)
{
    node->node.a = rtk_bits(split->pos);
    node->node.b = child << 2 | split->axis;
}

/* Deals `count` of the item's references out to the two sides, which need room for all of them; right may be refs itself. First
 * those of one side, without a branch; what lies on both is put by and cut. */
static void deal_some(const rti_build *b, const rti_item *it, const rti_kd_split *split, const rti_ref *refs, uint32_t count,
                      rti_ref *left, rti_ref *right, uint32_t counts[2])
{
    rti_ref both[DEAL], l, r;
    uint32_t axis = split->axis, lefts = counts[0], rights = counts[1], boths = 0;
    float pos = split->pos;
    bool clip = it->count > b->clip_above;
    for (uint32_t i = 0; i < count; i++) {
        rti_ref ref = refs[i];
        unsigned in_left = ref.lo[axis]<pos, in_right = ref.hi[axis]> pos;
        left[lefts] = right[rights] = both[boths] = ref;
        lefts += !in_right;
        rights += in_right & !in_left;
        boths += in_right & in_left;
    }
    for (uint32_t i = 0; i < boths && clip; i++)
        if (both[i].prim < b->in->tri_count)
            rti_tri_expect(&b->in->tris[both[i].prim]);
    for (uint32_t i = 0; i < boths; i++) {
        unsigned sides = rti_ref_cut(b, &it->cell, &both[i], axis, pos, clip, &l, &r);
        left[lefts] = l;
        lefts += sides & 1;
        right[rights] = r;
        rights += sides >> 1;
    }
    counts[0] = lefts;
    counts[1] = rights;
}

static void deal(const rti_build *b, const rti_item *it, const rti_kd_split *split, const rti_ref *refs, uint32_t count,
                 rti_ref *left, rti_ref *right, uint32_t counts[2])
{
    for (uint32_t i = 0; i < count; i += DEAL)
        deal_some(b, it, split, refs + i, count - i < DEAL ? count - i : DEAL, left, right, counts);
}

/* ---- one part, depth first ---------------------------------------------------------------------------------------------- */

typedef struct worker {
    rt_context *ctx;
    const rti_build *b;
    rti_tree_out *out;
    rti_ref *stack, *side; /* side: references of the part's root */
    float *scratch;        /* three times as many */
    size_t stack_capacity, top;
} worker;

static bool write_leaf(worker *w, const rti_item *it)
{
    uint32_t first;
    w->top -= it->count;
    if (!rti_out_refs(w->ctx, w->out, w->stack + w->top, NULL, it->count, &first))
        return false;
    rti_cell_node *node = (rti_cell_node *)w->out->nodes + it->node;
    node->node.a = first;
    node->node.b = it->count << 2 | RTK_KD_LEAF;
    for (int a = 0; a < 3; a++) {
        node->lo[a] = RTK_INF;
        node->hi[a] = -RTK_INF;
        for (const rti_ref *r = w->stack + w->top; r < w->stack + w->top + it->count; r++) {
            node->lo[a] = rtk_min(r->lo[a], node->lo[a]);
            node->hi[a] = rtk_max(r->hi[a], node->hi[a]);
        }
    }
    return true;
}

/* Takes the item's references off the stack's top and puts those of its right and, above them, of its left child there. */
static bool partition(worker *w, const rti_item *it, const rti_kd_split *split, rti_item children[2])
{
    size_t base = w->top - it->count;
    uint32_t counts[2] = {0, 0};
    if (!rti_reserve(w->ctx, (void **)&w->stack, &w->stack_capacity, base, 2 * (size_t)it->count, sizeof *w->stack))
        return false;
    deal(w->b, it, split, w->stack + base, it->count, w->side, w->stack + base, counts);
    memcpy(w->stack + base + counts[1], w->side, counts[0] * sizeof *w->side);
    w->top = base + counts[1] + counts[0];
    make_children(it, split, counts, children);
    return true;
}

static rt_status build_part(worker *w, const rti_item *root)
{
    rti_item todo[STACK_MAX];
    uint32_t todo_count = 1, work = 0;
    todo[0] = *root;
    todo[0].node = 0;
    if (rti_out_nodes(w->ctx, w->out, 1) == SIZE_MAX)
        return RT_ERROR_MEMORY;
    while (todo_count > 0) {
        rti_item it = todo[--todo_count], children[2];
        rti_kd_split split;
        work += it.count + 16;
        if (work > 16384) {
            work = 0;
            if (rti_cancelled(w->b->cancel))
                return RT_ERROR_CANCELLED;
        }
        if (!choose(NULL, w->b, &it, w->stack + w->top - it.count, w->scratch, &split)) {
            if (!write_leaf(w, &it))
                return RT_ERROR_MEMORY;
            continue;
        }
        size_t child = rti_out_nodes(w->ctx, w->out, 2);
        if (child == SIZE_MAX || !partition(w, &it, &split, children))
            return RT_ERROR_MEMORY;
        write_split((rti_cell_node *)w->out->nodes + it.node, &split, (uint32_t)child);
        for (uint32_t i = 2; i-- > 0;) {
            children[i].node = (uint32_t)child + i;
            todo[todo_count++] = children[i];
        }
    }
    return RT_OK;
}

static rt_status kd_part(rt_context *ctx, const rti_build *b, const rti_item *root, rti_ref *refs, size_t capacity,
                         rti_tree_out *out)
{
    worker w = {.ctx = ctx, .b = b, .out = out, .stack = refs, .stack_capacity = capacity, .top = root->count};
    size_t n = root->count;
    w.side = rti_alloc_array(ctx, n, sizeof *w.side);
    w.scratch = rti_alloc_array(ctx, 3 * n, sizeof *w.scratch);
    rt_status status = w.side && w.scratch ? build_part(&w, root) : RT_ERROR_MEMORY;
    rti_free(ctx, w.side, n * sizeof *w.side);
    rti_free(ctx, w.scratch, 3 * n * sizeof *w.scratch);
    rti_free(ctx, w.stack, w.stack_capacity * sizeof *w.stack);
    return status;
}

/* ---- one node of the top, by all workers ------------------------------------------------------------------------------ */

_Static_assert(RTI_KD_SHARE % DEAL == 0, "shares are dealt as one worker deals all");

/* Of a share of the node's references: at first how many may go to each side, then how many have gone, and where they begin
 * there. */
typedef struct share {
    uint32_t counts[2];
    size_t first[2];
} share;

typedef struct opening {
    const rti_build *b;
    rti_open *o;
    share *shares;
    uint32_t size; /* of a share */
} opening;

static uint32_t share_count(const opening *j, uint32_t index)
{
    return rtk_umin(j->o->it.count - index * j->size, j->size);
}

static void room_task(void *data, uint32_t index)
{
    const opening *j = data;
    const rti_open *o = j->o;
    const rti_ref *refs = o->refs + (size_t)index * j->size;
    const uint32_t axis = o->split.axis, n = share_count(j, index);
    uint32_t left = 0, right = 0;
    for (uint32_t i = 0; i < n; i++) {
        left += !(refs[i].hi[axis] > o->split.pos) || refs[i].lo[axis] < o->split.pos;
        right += refs[i].hi[axis] > o->split.pos;
    }
    j->shares[index].counts[0] = left;
    j->shares[index].counts[1] = right;
}

static void deal_task(void *data, uint32_t index)
{
    const opening *j = data;
    const rti_open *o = j->o;
    const rti_ref *refs = o->refs + (size_t)index * j->size;
    const uint32_t n = share_count(j, index);
    share *s = &j->shares[index];
    s->counts[0] = s->counts[1] = 0;
    for (uint32_t i = 0; i < n && !rti_cancelled(j->b->cancel); i += RTI_KD_SHARE)
        deal(j->b, &o->it, &o->split, refs + i, rtk_umin(n - i, RTI_KD_SHARE), o->child_refs[0] + s->first[0],
             o->child_refs[1] + s->first[1], s->counts);
}

/* Deals all shares out, each to places of its own, with one more behind them (deal writes one ahead), and closes the gaps. */
static rt_status deal_all(rt_context *ctx, opening *j, uint32_t tasks, uint32_t counts[2])
{
    rti_open *o = j->o;
    rti_parallel(ctx, tasks, room_task, j);
    for (int side = 0; side < 2; side++) {
        for (uint32_t i = 0; i < tasks; i++) {
            j->shares[i].first[side] = o->child_capacity[side];
            o->child_capacity[side] += (size_t)j->shares[i].counts[side] + 1;
        }
        o->child_refs[side] = rti_alloc_array(ctx, o->child_capacity[side], sizeof(rti_ref));
        if (!o->child_refs[side])
            return RT_ERROR_MEMORY;
    }
    rti_parallel(ctx, tasks, deal_task, j);
    for (int side = 0; side < 2; side++)
        for (uint32_t i = 0; i < tasks; i++) {
            rti_ref *refs = o->child_refs[side];
            if (counts[side] != j->shares[i].first[side])
                memmove(refs + counts[side], refs + j->shares[i].first[side], j->shares[i].counts[side] * sizeof *refs);
            counts[side] += j->shares[i].counts[side];
        }
    return rti_cancelled(j->b->cancel) ? RT_ERROR_CANCELLED : RT_OK;
}

static rt_status split_open(rt_context *ctx, bool together, const rti_build *b, rti_open *o, float *scratch)
{
    opening j = {.b = b, .o = o, .size = together ? RTI_KD_SHARE : o->it.count};
    const uint32_t tasks = (o->it.count + j.size - 1) / j.size;
    uint32_t counts[2] = {0, 0};
    rt_status status;
    o->leaf = !choose(together ? ctx : NULL, b, &o->it, o->refs, scratch, &o->split);
    if (o->leaf)
        return RT_OK;
    j.shares = rti_alloc_array(ctx, tasks, sizeof *j.shares);
    if (!j.shares)
        return RT_ERROR_MEMORY;
    status = deal_all(ctx, &j, tasks, counts);
    make_children(&o->it, &o->split, counts, o->children);
    rti_free(ctx, j.shares, tasks * sizeof *j.shares);
    return status;
}

static rt_status kd_split(rt_context *ctx, const rti_build *b, rti_open *o)
{
    const bool together = rt_context_workers(ctx) > 1;
    const size_t floats = (together ? 9 : 3) * (size_t)o->it.count;
    float *scratch = rti_alloc_array(ctx, floats, sizeof *scratch);
    rt_status status = scratch ? split_open(ctx, together, b, o, scratch) : RT_ERROR_MEMORY;
    rti_free(ctx, scratch, floats * sizeof *scratch);
    return status;
}

static void kd_write(void *node, const rti_open *o, uint32_t child)
{
    write_split(node, &o->split, child);
}

static void kd_move(void *node, uint32_t nodes, uint32_t refs)
{
    rtk_kdnode *n = node;
    if ((n->b & 3u) == RTK_KD_LEAF)
        n->a += refs;
    else
        n->b += nodes << 2;
}

rt_status rti_kd_build(rt_context *ctx, const rti_build *b, double start, void **chunk, size_t *size)
{
    static const rti_method method = {.kind = RTK_TREE_KD,
                                      .node_size = sizeof(rti_cell_node),
                                      .kept_size = sizeof(rtk_kdnode),
                                      .child_count = 2,
                                      .split = kd_split,
                                      .write_inner = kd_write,
                                      .part = kd_part,
                                      .move = kd_move};
    return rti_top_build(ctx, b, &method, start, chunk, size);
}
