/* The leaves of a kd-tree or an octree by eights, and their triangles side by side: what walks in vectors go through. The tree
 * itself stays as it is but for where its leaves' references stand. An octree's cells are halved by one axis after the other for
 * it: which of them share a node is the cheapest there is (bvh_fold.c), whatever they were split by.
 *
 * A box is what lies around all that the leaves below list in their cells, so it is inside the cell and usually much smaller. A
 * ray that has a hit in a cell's part of its way has it in the box, too: there the reference was cut with as much to spare as the
 * cell (ray.h, theory points 3 and 4). Folding saves two of three steps and the branch at each, the boxes most of the leaves.
 * (Woop, Marmitt, Slusallek 2006 keep bounds in kd-trees, of two children.)
 */
#include "bvh_build.h"

/* A threshold like this keeps what is done before the tasks small, and has no other consequence. */
#define TOP 1024u

static bool lists_nothing(const rti_bvh_node *n)
{
    return n->count == 0 && n->child == 0;
}

/* Inner nodes, behind which their children stand. false: cancelled. */
static bool take_inner(const rti_bvh *t)
{
    for (uint32_t i = t->cell_count; i-- > 0;) {
        const rtk_kdnode *cell = &t->cells[i].node;
        rti_bvh_node *n = &t->nodes[i];
        if (i % 65536 == 0 && rti_cancelled(t->b->cancel))
            return false;
        if ((cell->b & 3u) == RTK_KD_LEAF)
            continue;
        *n = (rti_bvh_node){{RTK_INF, RTK_INF, RTK_INF}, 0, {-RTK_INF, -RTK_INF, -RTK_INF}, 0};
        for (uint32_t k = 0; k < 2; k++) {
            const rti_bvh_node *c = &t->nodes[(cell->b >> 2) + k];
            if (lists_nothing(c))
                continue;
            n->child = cell->b >> 2;
            for (int a = 0; a < 3; a++) {
                n->lo[a] = rtk_min(c->lo[a], n->lo[a]);
                n->hi[a] = rtk_max(c->hi[a], n->hi[a]);
            }
        }
    }
    return true;
}

/* t: with cells. */
static rt_status widen(rti_bvh *t, double start, void **chunk, size_t *size)
{
    const rti_build *b = t->b;
    rt_status status;
    t->blocks = b->in->tri_count > 0;
    t->depth = RTK_BVH_DEPTH;
    t->together = t->blocks ? 2 : 0;
    t->leaf_cost = b->cost_traverse; /* as of a BVH; what a triangle costs where cells are split says nothing of a block */
    t->most = RTI_BVH_MERGED;
    t->top_count = rtk_umin(t->cell_count, TOP);
    t->grow2 = rti_f4_set(0.0f);
    rti_bvh_set_areas(t);
    status = rti_cells_cut(t);
    if (status == RT_OK && !take_inner(t))
        status = RT_ERROR_CANCELLED;
    if (status == RT_OK)
        status = rti_bvh_write(t, lists_nothing(&t->nodes[0]) ? RTK_INVALID : 0, start, chunk, size);
    rti_free(t->ctx, t->nodes, t->node_capacity * sizeof *t->nodes);
    rti_free(t->ctx, t->order, t->own->ref_count * sizeof *t->order);
    return status;
}

rt_status rti_cell_widen(rt_context *ctx, const rti_build *b, const rti_method *method, const rti_tree_out *tree, double start,
                         void **chunk, size_t *size)
{
    rti_bvh t = {.ctx = ctx, .kernels = rti_bvh_kernels_at(rti_context_isa(ctx)), .b = b, .own = tree, .method = method};
    const uint64_t count = method->write_cells ? method->cell_count(tree->node_count) : tree->node_count;
    rti_cell_node *cells = NULL;
    rt_status status = RT_OK;
    if (count > RTI_NODE_MAX)
        return RT_ERROR_MEMORY;
    t.cell_count = (uint32_t)count;
    t.cells = tree->nodes;
    if (method->write_cells) {
        t.cells = cells = rti_alloc_array(ctx, t.cell_count, sizeof *cells);
        if (!cells)
            return RT_ERROR_MEMORY;
        if (!method->write_cells(b, tree, cells))
            status = RT_ERROR_CANCELLED;
    }
    if (status == RT_OK)
        status = widen(&t, start, chunk, size);
    rti_free(ctx, cells, t.cell_count * sizeof *cells);
    return status;
}
