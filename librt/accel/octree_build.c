/* The octree's builder: cells are halved on all axes at once while they hold more primitives than a leaf may, and halving still
 * parts them. */
#include <string.h>

#include "build.h"
#include "vectors.h"

#define STACK_MAX (7u * RTK_OCT_DEPTH + 8u)

/* What products lose that are denormal or zero: an edge and a coordinate (or two edges) each less than 2^-148, here with room for
 * all of a sum; LOST_NORMAL is multiplied as the normal's own roundings are. */
#define LOST        1e-42f
#define LOST_NORMAL 1e-38f

/* What is asked of a cell's children, by axis. room: half and what it is grown by, half as much again. The fourth lanes are
 * nobody's. */
typedef struct middle {
    rti_f4 mid, half, room; /* half: of a child's sides */
} middle;

static middle middle_of(const rti_cell *cell, float grow)
{
    const rti_f4 lo = {cell->lo[0], cell->lo[1], cell->lo[2], 0.0f}, hi = {cell->hi[0], cell->hi[1], cell->hi[2], 0.0f};
    const rti_f4 half = rti_f4_set(0.25f) * (hi - lo);
    return (middle){rti_f4_set(0.5f) * (lo + hi), half, half + rti_f4_set(grow * 1.5f)};
}

/* Of each axis the one after it, and the one after that. */
static inline rti_f4 next(rti_f4 a)
{
    return (rti_f4){a[1], a[2], a[0], a[3]};
}

static inline rti_f4 last(rti_f4 a)
{
    return (rti_f4){a[2], a[0], a[1], a[3]};
}

/* Bit i: the triangle's plane passes child i. e, f: two edges; v: a vertex. */
static inline unsigned by_plane(const middle *m, rti_f4 e, rti_f4 f, rti_f4 v)
{
    rti_f4 x = next(e) * last(f), y = last(e) * next(f), n = x - y;
    rti_f4 d = n * v, lost = rti_f4_abs(x) + rti_f4_abs(y) + rti_f4_set(LOST_NORMAL);
    rti_f4 reach = rti_f4_abs(n) * m->room + lost * (rti_f4_abs(v) + m->half) * 2.0e-6f, h = n * m->half;
    float most = (reach[0] + reach[1] + reach[2]) + LOST, mid = d[0] + d[1] + d[2];
    rti_f4 s = mid + h[0] * (rti_f4){1, -1, 1, -1} + h[1] * (rti_f4){1, 1, -1, -1};
    rti_i4 low = (rti_i4){1, 2, 4, 8} & ~(rti_f4_abs(s + h[2]) > most),
           high = (rti_i4){16, 32, 64, 128} & ~(rti_f4_abs(s - h[2]) > most);
    low |= high;
    return (unsigned)(low[0] | low[1] | low[2] | low[3]);
}

/* Bit i: child i is not beyond an axis across an edge and an axis of the cell. Lanes are axes of the cell; with b and g the two
 * after it, a child's place along the axis across it depends on its halves of b and g alone, so four answers serve all eight. */
static inline unsigned by_edges(const middle *m, const rti_f4 v[3], const rti_f4 e[3])
{
    /* Children by the cell's axis, and by halves low low, high low, low high, high high of b and g. */
    static const rti_i4 children[4] = {
        {0x03, 0x05, 0x11, 0}, {0x0c, 0x50, 0x22, 0}, {0x30, 0x0a, 0x44, 0}, {0xc0, 0xa0, 0x88, 0}};
    rti_i4 out[4] = {{0}, {0}, {0}, {0}}, all = {0};
    for (int i = 0; i < 3; i++) {
        const rti_f4 o = v[i == 0 ? 2 : i - 1], eb = next(e[i]), eg = last(e[i]);
        rti_f4 x = eb * last(v[i]) - eg * next(v[i]), y = eb * last(o) - eg * next(o);
        rti_f4 by_b = eg * next(m->half), by_g = eb * last(m->half), sum = by_g + by_b, less = by_g - by_b;
        rti_f4 reach = rti_f4_abs(eb) * last(m->room) + rti_f4_abs(eg) * next(m->room) + rti_f4_set(LOST);
        rti_f4 low = rti_f4_min(y, x) - reach, high = rti_f4_max(x, y) + reach;
        out[0] |= (low > -less) | (high < -less);
        out[1] |= (low > -sum) | (high < -sum);
        out[2] |= (low > sum) | (high < sum);
        out[3] |= (low > less) | (high < less);
    }
    for (int k = 0; k < 4; k++)
        all |= out[k] & children[k];
    return ~(unsigned)(all[0] | all[1] | all[2]);
}

/* Which of a cell's children, grown, does triangle `t` touch? Separating axes after Akenine-Moeller 2001, for all eight at once.
 * In floats: coordinates err by less than 2^-22 of the scale each, the growth is 2^-17 of it, so half as much again
 * covers every rounding (what cancels in the plane's normal has a term of its own), and what is listed too much does no harm. */
static unsigned touched(const rtk_tri *t, const middle *m, unsigned mask)
{
    const rti_f4 v[3] = {rti_f4_xyz(rti_f4_load(t->v0)) - m->mid, rti_f4_xyz(rti_f4_load(t->v1)) - m->mid,
                         rti_f4_xyz(rti_f4_load(t->v2)) - m->mid}; /* what follows a corner is in the record, too */
    const rti_f4 e[3] = {v[1] - v[0], v[2] - v[1], v[0] - v[2]};
    mask &= by_plane(m, e[0], e[1], v[0]);
    return (mask & (mask - 1)) != 0 ? mask & by_edges(m, v, e) : mask;
}

/* Bit i of the result: the reference belongs to child i. Boxes stay whole: only the cell counts. cells: the children. */
static inline unsigned children_of(const rti_build *b, const rti_ref *ref, const middle *m, const rti_cell cells[8])
{
    static const uint8_t high_of[8] = {0xff, 0xaa, 0xcc, 0x88, 0xf0, 0xa0, 0xc0, 0x80}; /* children in all these high halves */
    static const uint8_t low_of[8] = {0xff, 0x55, 0x33, 0x11, 0x0f, 0x05, 0x03, 0x01};
    unsigned not_low = 0, not_high = 0, mask;
    for (int a = 0; a < 3; a++) {
        not_low |= (unsigned)!(ref->lo[a] < cells[0].hi[a]) << a;
        not_high |= (unsigned)!(ref->hi[a] > cells[7].lo[a]) << a;
    }
    mask = high_of[not_low] & low_of[not_high];
    if ((mask & (mask - 1)) == 0 || ref->prim >= b->in->tri_count)
        return mask;
    return touched(&b->in->tris[ref->prim], m, mask);
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
    const middle m = middle_of(&it->cell, b->in->grow);
    for (uint32_t i = 0; i < it->count;) {
        uint32_t end = it->count - i < 255 ? it->count : i + 255;
        uint64_t few = 0; /* eight counts, a byte each */
        for (; i < end; i++) {
            unsigned mask = children_of(b, &refs[i], &m, cells);
            masks[i] = (uint8_t)mask;
            few += ((mask * 0x0101010101010101u & 0x8040201008040201u) + 0x7f7f7f7f7f7f7f7fu) >> 7 & 0x0101010101010101u;
        }
        for (unsigned c = 0; c < 8; c++)
            counts[c] += few >> 8 * c & 0xffu;
        if (i % (255 * 256) == 0 && rti_cancelled(b->cancel))
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
    size_t base = w->top - it->count, to = w->top, sum = (size_t)sum_of(counts), next[8];
    if (!rti_reserve(w->ctx, (void **)&w->stack, &w->stack_capacity, w->top, sum, sizeof *w->stack))
        return false;
    for (unsigned c = 8; c-- > 0; to += counts[c])
        next[c] = to;
    for (uint32_t i = 0; i < it->count; i++)
        for (unsigned mask = w->masks[i]; mask != 0; mask &= mask - 1)
            w->stack[next[__builtin_ctz(mask)]++] = w->stack[base + i];
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
    rti_ref *to[8];
    child_cells(&o->it.cell, cells);
    o->leaf = !choose(b, &o->it, o->refs, cells, masks, counts);
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

rt_status rti_octree_build(rt_context *ctx, const rti_build *b, double start, void **chunk, size_t *size)
{
    static const rti_method method = {RTK_TREE_OCTREE, sizeof(rtk_octnode), 8, octree_split, octree_write, octree_part};
    return rti_top_build(ctx, b, &method, start, chunk, size);
}
