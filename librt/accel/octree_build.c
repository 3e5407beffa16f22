/* The octree's builder: cells are halved on all axes at once while they hold more primitives than a leaf may, and halving still
 * parts them. */
#include <math.h>
#include <string.h>

#include "build.h"

#define STACK_MAX (7u * RTK_OCT_DEPTH + 8u)

/* Does triangle `t` touch the cell grown by `grow`? Separating axes after Akenine-Moeller 2001, in double: of the growth nothing
 * is spent here. */
static bool touches(const rtk_tri *t, const rti_cell *cell, double grow)
{
    const float *src[3] = {t->v0, t->v1, t->v2};
    double c[3], h[3], v[3][3], e[3][3], n[3], d = 0.0, r = 0.0;
    for (int a = 0; a < 3; a++) {
        c[a] = 0.5 * ((double)cell->lo[a] + cell->hi[a]);
        h[a] = 0.5 * ((double)cell->hi[a] - cell->lo[a]) + grow;
    }
    for (int i = 0; i < 3; i++)
        for (int a = 0; a < 3; a++)
            v[i][a] = src[i][a] - c[a];
    for (int i = 0; i < 3; i++)
        for (int a = 0; a < 3; a++)
            e[i][a] = v[(i + 1) % 3][a] - v[i][a];
    for (int a = 0; a < 3; a++) {
        int b = (a + 1) % 3, g = (a + 2) % 3;
        n[a] = e[0][b] * e[1][g] - e[0][g] * e[1][b];
        d += n[a] * v[0][a];
        r += fabs(n[a]) * h[a];
    }
    if (fabs(d) > r)
        return false;
    for (int i = 0; i < 3; i++)
        for (int a = 0; a < 3; a++) {
            int b = (a + 1) % 3, g = (a + 2) % 3;
            double p = e[i][b] * v[i][g] - e[i][g] * v[i][b], q = e[i][b] * v[(i + 2) % 3][g] - e[i][g] * v[(i + 2) % 3][b];
            r = fabs(e[i][b]) * h[g] + fabs(e[i][g]) * h[b];
            if ((p > r && q > r) || (p < -r && q < -r))
                return false;
        }
    return true;
}

/* Bit i of the result: the reference belongs to child i. Boxes stay whole: only the cell counts. */
static unsigned children_of(const rti_build *b, const rti_ref *ref, const rti_cell cells[8])
{
    unsigned low = 0, high = 0, mask = 0;
    for (int a = 0; a < 3; a++) {
        low |= (unsigned)(ref->lo[a] < cells[0].hi[a]) << a;
        high |= (unsigned)(ref->hi[a] > cells[7].lo[a]) << a;
    }
    for (unsigned i = 0; i < 8; i++) {
        if ((~low & ~i & 7u) || (~high & i))
            continue;
        mask |= 1u << i;
    }
    if ((mask & (mask - 1)) == 0 || ref->prim >= b->in->tri_count)
        return mask;
    for (unsigned i = 0; i < 8; i++)
        if ((mask >> i & 1u) && !touches(&b->in->tris[ref->prim], &cells[i], b->in->grow))
            mask &= ~(1u << i);
    return mask;
}

static void child_cells(const rti_cell *cell, rti_cell out[8])
{
    for (unsigned i = 0; i < 8; i++) {
        out[i] = *cell;
        for (unsigned a = 0; a < 3; a++)
            ((i >> a) & 1u ? out[i].lo : out[i].hi)[a] = 0.5f * (cell->lo[a] + cell->hi[a]);
    }
}

/* Marks which children every reference goes to and counts them; false: the node is to be a leaf. */
static bool choose(const rti_build *b, const rti_item *it, const rti_ref *refs, const rti_cell cells[8], uint8_t *masks,
                   uint32_t counts[8])
{
    uint64_t sum = 0;
    if (it->count <= b->leaf_size || it->depth >= b->max_depth)
        return false;
    for (int a = 0; a < 3; a++)
        if (!(cells[0].hi[a] - it->cell.lo[a] > 2.0f * b->min_size))
            return false;
    memset(counts, 0, 8 * sizeof *counts);
    for (uint32_t i = 0; i < it->count; i++) {
        unsigned mask = children_of(b, &refs[i], cells);
        masks[i] = (uint8_t)mask;
        for (unsigned c = 0; c < 8; c++)
            counts[c] += mask >> c & 1u;
        if (i % 65536 == 65535 && rti_cancelled(b->cancel))
            return false;
    }
    bool parts = false;
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
    rti_tree_out *out;
    rti_ref *stack;
    size_t stack_capacity, top;
    uint8_t *masks; /* references of the part's root */
} worker;

static bool write_leaf(worker *w, const rti_item *it)
{
    uint32_t first;
    w->top -= it->count;
    if (!rti_out_refs(w->ctx, w->out, w->stack + w->top, it->count, &first))
        return false;
    rtk_octnode *node = (rtk_octnode *)w->out->nodes + it->node;
    node->first = first;
    node->count = it->count;
    return true;
}

/* The item's references go up the stack once for each child, the first child's last; then they move down over their own place. */
static bool partition(worker *w, const rti_item *it, const uint32_t counts[8])
{
    size_t base = w->top - it->count, to = w->top, sum = (size_t)sum_of(counts);
    if (!rti_reserve(w->ctx, (void **)&w->stack, &w->stack_capacity, w->top, sum, sizeof *w->stack))
        return false;
    for (unsigned c = 8; c-- > 0;)
        for (uint32_t i = 0; counts[c] > 0 && i < it->count; i++)
            if (w->masks[i] >> c & 1u)
                w->stack[to++] = w->stack[base + i];
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
        if (!choose(w->b, &it, w->stack + w->top - it.count, cells, w->masks, counts)) {
            if (!write_leaf(w, &it))
                return RT_ERROR_MEMORY;
            continue;
        }
        size_t child = rti_out_nodes(w->ctx, w->out, 8);
        if (child == SIZE_MAX || !partition(w, &it, counts))
            return RT_ERROR_MEMORY;
        ((rtk_octnode *)w->out->nodes)[it.node].child = (uint32_t)child;
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
    worker w = {.ctx = ctx, .b = b, .out = out, .stack = refs, .stack_capacity = capacity, .top = root->count};
    w.masks = rti_alloc(ctx, root->count);
    rt_status status = w.masks ? build_part(&w, root) : RT_ERROR_MEMORY;
    rti_free(ctx, w.masks, root->count);
    rti_free(ctx, w.stack, w.stack_capacity * sizeof *w.stack);
    return status;
}

/* ---- one node of the top -------------------------------------------------------------------------------------------------- */

static rt_status split_open(rt_context *ctx, const rti_build *b, rti_open *o, uint8_t *masks)
{
    rti_cell cells[8];
    uint32_t counts[8];
    child_cells(&o->it.cell, cells);
    o->leaf = !choose(b, &o->it, o->refs, cells, masks, counts);
    for (unsigned c = 0; c < 8 && !o->leaf; c++) {
        rti_ref *to = rti_alloc_array(ctx, counts[c], sizeof *to);
        if (!to)
            return RT_ERROR_MEMORY;
        o->child_refs[c] = to;
        o->child_capacity[c] = counts[c];
        for (uint32_t i = 0; i < o->it.count; i++)
            if (masks[i] >> c & 1u)
                *to++ = o->refs[i];
        make_child(&o->it, &cells[c], counts[c], sum_of(counts), &o->children[c]);
        if (rti_cancelled(b->cancel))
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

rt_status rti_octree_build(rt_context *ctx, const rti_build *b, double start, void **chunk, size_t *size)
{
    static const rti_method method = {RTK_TREE_OCTREE, sizeof(rtk_octnode), 8, octree_split, octree_write, octree_part};
    return rti_top_build(ctx, b, &method, start, chunk, size);
}
