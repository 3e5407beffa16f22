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

/* Nodes of the binary tree that rti_bvh_write takes, and the kd-tree's own. Children stand behind their parents. false:
 * cancelled. */
static bool take_nodes(const rti_kd_node *from, uint32_t count, rti_cancel *cancel, rti_bvh_node *nodes, rtk_kdnode *kd)
{
    for (uint32_t i = count; i-- > 0;) {
        if (i % 65536 == 0 && rti_cancelled(cancel))
            return false;
        rti_bvh_node *n = &nodes[i];
        kd[i] = from[i].node;
        *n = (rti_bvh_node){{RTK_INF, RTK_INF, RTK_INF}, 0, {-RTK_INF, -RTK_INF, -RTK_INF}, 0};
        if ((kd[i].b & 3u) == RTK_KD_LEAF) {
            memcpy(n->lo, from[i].lo, sizeof n->lo);
            memcpy(n->hi, from[i].hi, sizeof n->hi);
            n->count = kd[i].b >> 2;
            n->child = n->count > 0 ? kd[i].a : 0;
            continue;
        }
        for (uint32_t k = 0; k < 2; k++) {
            const rti_bvh_node *c = &nodes[(kd[i].b >> 2) + k];
            if (lists_nothing(c))
                continue;
            n->child = kd[i].b >> 2;
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
    const uint32_t count = h->node_count;
    rti_bvh t = {.ctx = ctx, .b = b, .kd_count = count};
    void *wide = NULL;
    size_t wide_size = 0;
    rt_status status = RT_ERROR_MEMORY;
    rtk_kdnode *kd = rti_alloc_array(ctx, count, sizeof *kd);
    t.kd = kd;
    t.nodes = rti_alloc_array(ctx, count, sizeof *t.nodes);
    t.order = (uint32_t *)(void *)((char *)*chunk + h->off_refs);
    t.blocks = b->in->tri_count > 0;
    t.depth = RTK_BVH_DEPTH;
    t.top_count = count < TOP ? count : TOP;
    t.unit = rti_bvh_unit(b->in);
    t.grow2 = rti_f4_set(0.0f);
    if (kd && t.nodes) {
        const rti_kd_node *from = (const rti_kd_node *)(const void *)((const char *)h + h->off_nodes);
        status = RT_ERROR_CANCELLED;
        if (take_nodes(from, count, b->cancel, t.nodes, kd))
            status = rti_bvh_write(&t, lists_nothing(&t.nodes[0]) ? RTK_INVALID : 0, start, &wide, &wide_size);
    }
    rti_free(ctx, t.nodes, count * sizeof *t.nodes);
    rti_free(ctx, kd, count * sizeof *kd);
    rti_free(ctx, *chunk, *size);
    *chunk = wide;
    *size = wide_size;
    return status;
}
