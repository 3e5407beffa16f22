/* A kd-tree's cells, eight to a node, and the triangles of its leaves side by side: what walks in vectors go through. The tree
 * itself stays as it is but for where its leaves' references stand.
 *
 * A ray meets a cell between the planes around it, as it meets a box; that all of them come from splits makes the cells tile its
 * way (ray.h, theory point 4). What folding saves is two of three steps, and the branch at each.
 */
#include "bvh_build.h"

/* A threshold like this keeps what is done before the tasks small, and has no other consequence. */
#define TOP 1024u

/* Nodes of the binary tree that rti_bvh_write takes: those of the kd-tree, with their cells. */
static void take_cells(const rtk_kdnode *kd, uint32_t count, const rtk_tree_header *h, rti_bvh_node *nodes)
{
    memcpy(nodes[0].lo, h->lo, sizeof nodes[0].lo);
    memcpy(nodes[0].hi, h->hi, sizeof nodes[0].hi);
    for (uint32_t i = 0; i < count; i++) {
        rti_bvh_node *n = &nodes[i];
        const uint32_t axis = kd[i].b & 3u;
        if (axis == RTK_KD_LEAF) {
            n->count = kd[i].b >> 2;
            n->child = n->count > 0 ? kd[i].a : 0;
            continue;
        }
        n->count = 0;
        n->child = kd[i].b >> 2; /* behind its parent */
        nodes[n->child] = nodes[n->child + 1] = *n;
        nodes[n->child].hi[axis] = nodes[n->child + 1].lo[axis] = rtk_float(kd[i].a);
    }
}

rt_status rti_kd_widen(rt_context *ctx, const rti_build *b, double start, void **chunk, size_t *size)
{
    rtk_tree_header *h = *chunk;
    const uint32_t count = h->node_count;
    rti_bvh t = {.ctx = ctx, .b = b, .kd = rti_tree_view(h).kd, .kd_count = count};
    void *wide = NULL;
    size_t wide_size = 0;
    rt_status status = RT_ERROR_MEMORY;
    t.nodes = rti_alloc_array(ctx, count, sizeof *t.nodes);
    t.order = (uint32_t *)(void *)((char *)h + h->off_refs);
    t.blocks = b->in->tri_count > 0;
    t.depth = RTK_BVH_DEPTH;
    t.top_count = count < TOP ? count : TOP;
    t.unit = rti_bvh_unit(b->in);
    t.grow2 = rti_f4_set(0.0f);
    if (t.nodes) {
        take_cells(t.kd, count, h, t.nodes);
        status = rti_bvh_write(&t, h->ref_count > 0 ? 0 : RTK_INVALID, start, &wide, &wide_size);
    }
    rti_free(ctx, t.nodes, count * sizeof *t.nodes);
    rti_free(ctx, *chunk, *size);
    *chunk = wide;
    *size = wide_size;
    return status;
}
