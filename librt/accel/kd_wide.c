/* A kd-tree's leaves by eights, and their triangles side by side: what walks in vectors go through. The tree itself stays as it
 * is but for where its leaves' references stand.
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
    for (uint32_t i = t->kd_count; i-- > 0;) {
        const rtk_kdnode *kd = &t->kd[i].node;
        rti_bvh_node *n = &t->nodes[i];
        if (i % 65536 == 0 && rti_cancelled(t->b->cancel))
            return false;
        if ((kd->b & 3u) == RTK_KD_LEAF)
            continue;
        *n = (rti_bvh_node){{RTK_INF, RTK_INF, RTK_INF}, 0, {-RTK_INF, -RTK_INF, -RTK_INF}, 0};
        for (uint32_t k = 0; k < 2; k++) {
            const rti_bvh_node *c = &t->nodes[(kd->b >> 2) + k];
            if (lists_nothing(c))
                continue;
            n->child = kd->b >> 2;
            for (int a = 0; a < 3; a++) {
                n->lo[a] = rtk_min(c->lo[a], n->lo[a]);
                n->hi[a] = rtk_max(c->hi[a], n->hi[a]);
            }
        }
    }
    return true;
}

rt_status rti_kd_widen(rt_context *ctx, const rti_build *b, double start, void **chunk, size_t *size)
{
    const rtk_tree_header *h = *chunk;
    const char *bytes = *chunk;
    rti_bvh t = {.ctx = ctx, .kernels = rti_bvh_kernels_at(rti_context_isa(ctx)), .b = b};
    void *wide = NULL;
    size_t wide_size = 0;
    rt_status status;
    t.kd = (const rti_kd_node *)(const void *)(bytes + h->off_nodes);
    t.kd_count = h->node_count;
    t.kd_refs = (const uint32_t *)(const void *)(bytes + h->off_refs);
    t.kd_ref_count = h->ref_count;
    t.blocks = b->in->tri_count > 0;
    t.depth = RTK_BVH_DEPTH;
    t.together = t.blocks ? 2 : 0;
    t.leaf_cost = b->cost_traverse; /* as of a BVH; what a triangle costs where cells are split says nothing of a block */
    t.most = RTI_BVH_MERGED;
    t.top_count = rtk_umin(t.kd_count, TOP);
    t.grow2 = rti_f4_set(0.0f);
    rti_bvh_set_areas(&t);
    status = rti_kd_cut_leaves(&t);
    if (status == RT_OK && !take_inner(&t))
        status = RT_ERROR_CANCELLED;
    if (status == RT_OK)
        status = rti_bvh_write(&t, lists_nothing(&t.nodes[0]) ? RTK_INVALID : 0, start, &wide, &wide_size);
    rti_free(ctx, t.nodes, t.node_capacity * sizeof *t.nodes);
    rti_free(ctx, t.order, t.kd_ref_count * sizeof *t.order);
    rti_free(ctx, *chunk, *size);
    *chunk = wide;
    *size = wide_size;
    return status;
}
