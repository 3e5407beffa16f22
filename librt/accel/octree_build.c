/* The octree's builder: cells are halved on all axes at once while they hold more primitives than a leaf may, and halving still
 * parts them. */
#include <string.h>

#include "octree_build.h"
#include "vectors.h"

#define STACK_MAX (7u * RTK_OCT_DEPTH + 8u)

/* lo, hi: of a leaf, as of an rti_cell_node. */
typedef struct oct_node {
    rtk_octnode node;
    float lo[3], hi[3];
} oct_node;

#define AT_ONCE 65536u /* references between two looks at whether the build is cancelled */

RTI_ISA_TABLES(rti_octree_kernels, rti_octree_kernels_at)

static rti_octree_middle middle_of(const rti_cell *cell, float grow)
{
    rti_octree_middle m = {.mid = {0}};
    for (int a = 0; a < 3; a++) {
        m.mid[a] = 0.5f * (cell->lo[a] + cell->hi[a]);
        m.half[a] = 0.25f * (cell->hi[a] - cell->lo[a]);
        m.room[a] = m.half[a] + grow * 1.5f;
    }
    return m;
}

static void child_cells(const rti_cell *cell, rti_cell out[8])
{
    for (unsigned i = 0; i < 8; i++) {
        out[i] = *cell;
        for (unsigned a = 0; a < 3; a++)
            ((i >> a) & 1u ? out[i].lo : out[i].hi)[a] = 0.5f * (cell->lo[a] + cell->hi[a]);
    }
}

/* Marks which children every reference goes to and counts them; false: the node is to be a leaf. which: as in the kernel. */
static bool choose(const rti_build *b, const rti_octree_kernels *kernels, const rti_item *it, const rti_ref *refs,
                   const uint32_t *which, uint8_t *masks, uint32_t counts[8])
{
    uint64_t sum = 0;
    bool parts = false;
    if (it->count <= b->leaf_size || it->depth >= b->max_depth)
        return false;
    const rti_octree_middle m = middle_of(&it->cell, b->in->grow);
    for (int a = 0; a < 3; a++)
        if (!(m.mid[a] - it->cell.lo[a] > 2.0f * b->min_size))
            return false;
    memset(counts, 0, 8 * sizeof *counts);
    for (uint32_t i = 0; i < it->count; i += AT_ONCE) {
        const uint32_t n = rtk_umin(it->count - i, AT_ONCE);
        if (i > 0 && rti_cancelled(b->cancel))
            return false;
        kernels->touched(&m, b->in, which ? refs : refs + i, which ? which + i : NULL, n, masks + i, counts);
    }
    for (int c = 0; c < 8; c++) {
        sum += counts[c];
        parts |= counts[c] < it->count && counts[c] > 0;
    }
    /* Either something is parted from something, or all of it lies in one child. */
    return sum <= it->budget && (parts || sum == it->count);
}

static void make_child(const rti_item *it, const rti_cell *cell, uint32_t count, uint64_t sum, rti_item *out)
{
    out->cell = *cell;
    out->depth = it->depth + 1;
    out->count = count;
    out->budget = sum ? (uint32_t)((uint64_t)it->budget * count / sum) : 0;
}

static uint64_t sum_of(const uint32_t counts[8])
{
    uint64_t sum = 0;
    for (int c = 0; c < 8; c++)
        sum += counts[c];
    return sum;
}

/* ---- one part, depth first ---------------------------------------------------------------------------------------------- */

typedef struct worker {
    rt_context *ctx;
    const rti_build *b;
    const rti_octree_kernels *kernels;
    rti_tree_out *out;
    const rti_ref *refs; /* of the part's root; boxes stay whole, so their places speak for them */
    uint32_t *stack;
    size_t stack_capacity, top;
    uint8_t *masks; /* room for the part's root */
} worker;

/* References on the stack from a place on; NULL: there are none at all, nor a stack. */
static const uint32_t *stacked(const worker *w, size_t place)
{
    return w->stack ? w->stack + place : NULL;
}

/* The box around what a leaf lists, whose references are at the top of the stack, just taken off. */
static void around(const worker *w, const rti_item *it, oct_node *n)
{
    const uint32_t *which = stacked(w, w->top);
    rti_f4 lo = rti_f4_set(RTK_INF), hi = rti_f4_set(-RTK_INF);
    for (uint32_t i = 0; i < it->count; i++) {
        const rti_ref *ref = &w->refs[which ? which[i] : i];
        lo = rti_f4_min(rti_f4_load(ref->lo), lo);
        hi = rti_f4_max(rti_f4_load(ref->hi), hi);
    }
    for (int a = 0; a < 3; a++) {
        n->lo[a] = rtk_max(lo[a], it->cell.lo[a]);
        n->hi[a] = rtk_min(hi[a], it->cell.hi[a]);
    }
}

static bool write_leaf(worker *w, const rti_item *it)
{
    uint32_t first;
    w->top -= it->count;
    if (!rti_out_refs(w->ctx, w->out, w->refs, stacked(w, w->top), it->count, &first))
        return false;
    oct_node *n = (oct_node *)w->out->nodes + it->node;
    n->node.first = first;
    n->node.count = it->count;
    around(w, it, n);
    return true;
}

/* The item's references go up the stack once for each child, the first child's last; then they move down over their own place. */
static bool partition(worker *w, const rti_item *it, const uint32_t counts[8])
{
    const size_t base = w->top - it->count, sum = (size_t)sum_of(counts);
    if (!rti_reserve(w->ctx, (void **)&w->stack, &w->stack_capacity, w->top, sum + RTI_OCTREE_AHEAD, sizeof *w->stack))
        return false;
    w->kernels->deal(w->stack + base, w->masks, it->count, w->stack + w->top);
    memmove(w->stack + base, w->stack + w->top, sum * sizeof *w->stack);
    w->top = base + sum;
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
        rti_item it = todo[--todo_count];
        rti_cell cells[8];
        uint32_t counts[8];
        work += it.count + 16;
        if (work > 16384) {
            work = 0;
            if (rti_cancelled(w->b->cancel))
                return RT_ERROR_CANCELLED;
        }
        child_cells(&it.cell, cells);
        if (!choose(w->b, w->kernels, &it, w->refs, stacked(w, w->top - it.count), w->masks, counts)) {
            if (!write_leaf(w, &it))
                return RT_ERROR_MEMORY;
            continue;
        }
        size_t child = rti_out_nodes(w->ctx, w->out, 8);
        if (child == SIZE_MAX || !partition(w, &it, counts))
            return RT_ERROR_MEMORY;
        ((oct_node *)w->out->nodes)[it.node].node.child = (uint32_t)child;
        for (uint32_t c = 8; c-- > 0; todo_count++) {
            make_child(&it, &cells[c], counts[c], sum_of(counts), &todo[todo_count]);
            todo[todo_count].node = (uint32_t)child + c;
        }
    }
    return RT_OK;
}

static rt_status octree_part(rt_context *ctx, const rti_build *b, const rti_item *root, rti_ref *refs, size_t capacity,
                             rti_tree_out *out)
{
    worker w = {.ctx = ctx, .b = b, .kernels = rti_octree_kernels_at(rti_context_isa(ctx)), .out = out, .refs = refs};
    const size_t n = (size_t)root->count + RTI_OCTREE_AHEAD;
    rt_status status = RT_ERROR_MEMORY;
    w.masks = rti_alloc(ctx, n);
    if (w.masks && rti_reserve(ctx, (void **)&w.stack, &w.stack_capacity, 0, root->count, sizeof *w.stack)) {
        for (w.top = 0; w.top < root->count; w.top++)
            w.stack[w.top] = (uint32_t)w.top;
        status = build_part(&w, root);
    }
    rti_free(ctx, w.masks, n);
    rti_free(ctx, w.stack, w.stack_capacity * sizeof *w.stack);
    rti_free(ctx, refs, capacity * sizeof *refs);
    return status;
}

/* ---- one node of the top -------------------------------------------------------------------------------------------------- */

static rt_status split_open(rt_context *ctx, const rti_build *b, rti_open *o, uint8_t *masks)
{
    rti_cell cells[8];
    uint32_t counts[8];
    rti_ref *to[8];
    child_cells(&o->it.cell, cells);
    o->leaf = !choose(b, rti_octree_kernels_at(rti_context_isa(ctx)), &o->it, o->refs, NULL, masks, counts);
    for (unsigned c = 0; c < 8 && !o->leaf; c++) {
        to[c] = o->child_refs[c] = rti_alloc_array(ctx, counts[c], sizeof **to);
        if (!to[c])
            return RT_ERROR_MEMORY;
        o->child_capacity[c] = counts[c];
        make_child(&o->it, &cells[c], counts[c], sum_of(counts), &o->children[c]);
    }
    for (uint32_t i = 0; i < o->it.count && !o->leaf; i++) {
        for (unsigned mask = masks[i]; mask != 0; mask &= mask - 1)
            *to[__builtin_ctz(mask)]++ = o->refs[i];
        if (i % 65536 == 65535 && rti_cancelled(b->cancel))
            return RT_ERROR_CANCELLED;
    }
    return RT_OK;
}

static rt_status octree_split(rt_context *ctx, const rti_build *b, rti_open *o)
{
    uint8_t *masks = rti_alloc(ctx, o->it.count);
    rt_status status = masks ? split_open(ctx, b, o, masks) : RT_ERROR_MEMORY;
    rti_free(ctx, masks, o->it.count);
    return status;
}

static void octree_write(void *node, const rti_open *o, uint32_t child)
{
    (void)o;
    ((rtk_octnode *)node)->child = child;
}

static void octree_move(void *node, uint32_t nodes, uint32_t refs)
{
    rtk_octnode *n = node;
    if (n->child == 0)
        n->first += refs;
    else
        n->child += nodes;
}

/* ---- as cells of two children ----------------------------------------------------------------------------------------------
 *
 * An inner node's children stand side by side, from 1 + 8 k on: they become two cells by z, four by y and eight by x, from
 * 1 + CELLS k on in this order.
 */

#define CELLS 14u

static uint64_t octree_cell_count(size_t nodes)
{
    return 1 + (uint64_t)(nodes - 1) / 8 * CELLS;
}

static void write_inner(rti_cell_node *cell, uint32_t child, uint32_t axis)
{
    cell->node.a = 0; /* where it is split is of no matter */
    cell->node.b = child << 2 | axis;
}

static void write_cell(const oct_node *n, rti_cell_node *cell)
{
    memcpy(cell->lo, n->lo, sizeof cell->lo);
    memcpy(cell->hi, n->hi, sizeof cell->hi);
    if (n->node.child != 0) {
        write_inner(cell, 1 + (n->node.child - 1) / 8 * CELLS, 2);
        return;
    }
    cell->node.a = n->node.first;
    cell->node.b = n->node.count << 2 | RTK_KD_LEAF;
}

static bool octree_write_cells(const rti_build *b, const rti_tree_out *tree, rti_cell_node *cells)
{
    const oct_node *nodes = tree->nodes;
    write_cell(nodes, cells);
    for (uint32_t k = 0; k < (tree->node_count - 1) / 8; k++) {
        const uint32_t first = 1 + CELLS * k;
        if (k % 4096 == 4095 && rti_cancelled(b->cancel))
            return false;
        for (uint32_t z = 0; z < 2; z++)
            write_inner(&cells[first + z], first + 2 + 2 * z, 1);
        for (uint32_t y = 0; y < 4; y++)
            write_inner(&cells[first + 2 + y], first + 6 + 2 * y, 0);
        for (uint32_t x = 0; x < 8; x++)
            write_cell(&nodes[1 + 8 * k + x], &cells[first + 6 + x]);
    }
    return true;
}

rt_status rti_octree_build(rt_context *ctx, const rti_build *b, double start, void **chunk, size_t *size)
{
    static const rti_method method = {.kind = RTK_TREE_OCTREE,
                                      .node_size = sizeof(oct_node),
                                      .kept_size = sizeof(rtk_octnode),
                                      .child_count = 8,
                                      .split = octree_split,
                                      .write_inner = octree_write,
                                      .part = octree_part,
                                      .move = octree_move,
                                      .cell_count = octree_cell_count,
                                      .write_cells = octree_write_cells};
    return rti_top_build(ctx, b, &method, start, chunk, size);
}
