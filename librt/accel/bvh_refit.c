/* A BVH over primitives that have moved: the same nodes and references with new boxes, and with new copies of the vertices. What
 * leaves hold is read by all workers; boxes then go up from the last node to the first, for children stand behind their parents.
 *
 * The boxes are as tight as a builder's, so hits are brute force's whatever the primitives did. What suffers is speed: primitives
 * that were neighbours when the tree was built need not be any more. A SAH cost relative to the root, as builders write it into
 * the header, tells little of that where a figure moves on a floor: the floor's few nodes make up nearly all of it. So each
 * subtree's cost is taken relative to its own box, and the mean over the nodes of a level, then over the levels, is held against
 * that of the tree as it was built (Lauterbach et al. 2006, RT-DEFORM, compares nodes with their children likewise).
 */
#include <string.h>

#include "../kernel/shape_surface.h"
#include "bvh_build.h"

#define BLOCKS_A_TASK 2048u
#define NODES_A_TASK  1024u

typedef struct refit {
    const rti_refit_input *in;
    rti_cancel *cancel;
    const rtk_tree_header *head; /* of the new chunk */
    rtk_bvhnode *nodes;
    rtk_bvhblock *blocks;
    const uint32_t *refs;
    rti_bvh_order order;
} refit;

/* ---- leaves ---- */

static void block_task(void *data, uint32_t task)
{
    const refit *r = data;
    uint32_t first = task * BLOCKS_A_TASK, end = rtk_umin(r->head->block_count, first + BLOCKS_A_TASK);
    for (uint32_t b = first; b < end && !rti_cancelled(r->cancel); b++) {
        rtk_bvhblock *block = &r->blocks[b];
        for (uint32_t lane = 0; lane < RTK_BVH_BLOCK; lane++) {
            const rtk_tri *tri = &r->in->tris[r->refs[b * RTK_BVH_BLOCK + lane]];
            for (int a = 0; a < 3; a++) {
                block->v0[a][lane] = tri->v0[a];
                block->v1[a][lane] = tri->v1[a];
                block->v2[a][lane] = tri->v2[a];
            }
        }
    }
}

typedef struct bounds {
    float lo[3], hi[3];
} bounds;

static bounds nothing(void)
{
    return (bounds){{RTK_INF, RTK_INF, RTK_INF}, {-RTK_INF, -RTK_INF, -RTK_INF}};
}

static void extend(bounds *b, const float lo[3], const float hi[3])
{
    for (int a = 0; a < 3; a++) {
        b->lo[a] = rtk_min(b->lo[a], lo[a]);
        b->hi[a] = rtk_max(b->hi[a], hi[a]);
    }
}

/* Of the triangles in places `first` to `end` of the blocks. */
static bounds blocked_box(const refit *r, uint32_t first, uint32_t end)
{
    bounds out = nothing();
    for (uint32_t at = first; at < end; at = (at / RTK_BVH_BLOCK + 1) * RTK_BVH_BLOCK) {
        const rtk_bvhblock *b = &r->blocks[at / RTK_BVH_BLOCK];
        uint32_t lane = at % RTK_BVH_BLOCK, last = rtk_umin(end - at + lane, RTK_BVH_BLOCK);
        for (int a = 0; a < 3; a++) {
            rti_f4 v0 = rti_f4_load(b->v0[a]), v1 = rti_f4_load(b->v1[a]), v2 = rti_f4_load(b->v2[a]);
            rti_f4 lo = rti_f4_min(rti_f4_min(v0, v1), v2), hi = rti_f4_max(rti_f4_max(v0, v1), v2);
            for (uint32_t i = lane; i < last; i++) {
                out.lo[a] = rtk_min(out.lo[a], lo[i]);
                out.hi[a] = rtk_max(out.hi[a], hi[i]);
            }
        }
    }
    return out;
}

static bounds plain_box(const refit *r, uint32_t first, uint32_t count)
{
    bounds out = nothing();
    for (uint32_t i = 0; i < count; i++) {
        uint32_t ref = r->refs[first + i];
        if (ref < r->in->tri_count) {
            const rtk_tri *tri = &r->in->tris[ref];
            extend(&out, tri->v0, tri->v0);
            extend(&out, tri->v1, tri->v1);
            extend(&out, tri->v2, tri->v2);
        } else {
            rtk_vec3 lo, hi;
            rtk_shape_bounds(&r->in->shapes[ref - r->in->tri_count], &lo, &hi);
            extend(&out, (float[3]){lo.x, lo.y, lo.z}, (float[3]){hi.x, hi.y, hi.z});
        }
    }
    return out;
}

static void put_box(rtk_bvhnode *node, uint32_t slot, const bounds *box, float grow)
{
    for (int a = 0; a < 3; a++) {
        node->box[a][0][slot] = box->lo[a] - grow;
        node->box[a][1][slot] = box->hi[a] + grow;
    }
}

static void leaf_task(void *data, uint32_t task)
{
    const refit *r = data;
    uint32_t first = task * NODES_A_TASK, end = rtk_umin(r->head->node_count, first + NODES_A_TASK);
    for (uint32_t n = first; n < end && !rti_cancelled(r->cancel); n++) {
        rtk_bvhnode *node = &r->nodes[n];
        for (uint32_t i = 0; i < RTK_BVH_WIDTH; i++) {
            uint32_t child = node->child[i], count = node->count[i];
            bounds box;
            if (count == 0)
                continue;
            box =
                child < r->head->block_count * RTK_BVH_BLOCK ? blocked_box(r, child, child + count) : plain_box(r, child, count);
            put_box(node, i, &box, r->in->grow);
        }
        rti_bvh_order_leaves(&r->order, n, r->order.leaves[n]);
    }
}

/* ---- nodes ---- */

static bool is_inner(const rtk_bvhnode *node, uint32_t slot)
{
    return node->count[slot] == 0 && node->child[slot] > 0;
}

static bool is_empty(const rtk_bvhnode *node, uint32_t slot)
{
    return node->count[slot] == 0 && node->child[slot] == 0;
}

/* Empty slots, which stand inverted, add nothing. */
static bounds node_box(const rtk_bvhnode *node)
{
    bounds out;
    for (int a = 0; a < 3; a++) {
        rti_f4 lo = rti_f4_min(rti_f4_load(node->box[a][0]), rti_f4_load(node->box[a][0] + 4));
        rti_f4 hi = rti_f4_max(rti_f4_load(node->box[a][1]), rti_f4_load(node->box[a][1] + 4));
        out.lo[a] = rtk_min(rtk_min(lo[0], lo[1]), rtk_min(lo[2], lo[3]));
        out.hi[a] = rtk_max(rtk_max(hi[0], hi[1]), rtk_max(hi[2], hi[3]));
    }
    return out;
}

/* In doubles: no size of a scene makes it 0 or infinite. */
static double area(const float lo[3], const float hi[3])
{
    double x = (double)hi[0] - lo[0], y = (double)hi[1] - lo[1], z = (double)hi[2] - lo[2];
    return x * y + y * z + z * x;
}

static double slot_area(const rtk_bvhnode *node, uint32_t slot)
{
    float lo[3], hi[3];
    for (int a = 0; a < 3; a++) {
        lo[a] = node->box[a][0][slot];
        hi[a] = node->box[a][1][slot];
    }
    return area(lo, hi);
}

static void fit_nodes(const refit *r)
{
    for (uint32_t n = r->head->node_count; n-- > 0;) {
        if (n % 4096 == 0 && rti_cancelled(r->cancel))
            return;
        rtk_bvhnode *node = &r->nodes[n];
        for (uint32_t i = 0; i < RTK_BVH_WIDTH; i++) {
            if (is_inner(node, i)) {
                bounds box = node_box(&r->nodes[node->child[i]]);
                put_box(node, i, &box, 0.0f); /* grown already */
            }
        }
        rti_bvh_order_node(&r->order, n);
    }
}

/* ---- what it costs ---- */

/* Cost of each node's subtree for a ray that enters the node. */
static void subtree_costs(const rtk_tree_header *h, const rtk_bvhnode *nodes, float *costs)
{
    for (uint32_t n = h->node_count; n-- > 0;) {
        const rtk_bvhnode *node = &nodes[n];
        bounds box = node_box(node);
        double sum = 0.0, whole = area(box.lo, box.hi);
        for (uint32_t i = 0; i < RTK_BVH_WIDTH && !is_empty(node, i); i++)
            sum += slot_area(node, i) * (is_inner(node, i) ? costs[node->child[i]] : h->cost_intersect * (float)node->count[i]);
        costs[n] = (float)(whole > 0.0 ? h->cost_traverse + sum / whole : h->cost_traverse);
    }
}

/* The mean over levels; depths: [node_count]. */
static float mean_cost(const rtk_tree_header *h, const rtk_bvhnode *nodes, float *costs, uint8_t *depths)
{
    double sums[RTK_BVH_DEPTH + 1] = {0.0}, mean = 0.0;
    uint32_t counts[RTK_BVH_DEPTH + 1] = {0}, levels = 0;
    subtree_costs(h, nodes, costs);
    depths[0] = 0;
    for (uint32_t n = 0; n < h->node_count; n++) {
        sums[depths[n]] += (double)costs[n];
        counts[depths[n]]++;
        for (uint32_t i = 0; i < RTK_BVH_WIDTH; i++)
            if (is_inner(&nodes[n], i))
                depths[nodes[n].child[i]] = (uint8_t)(depths[n] + 1);
    }
    for (; levels <= RTK_BVH_DEPTH && counts[levels] > 0; levels++)
        mean += sums[levels] / counts[levels];
    return (float)(mean / levels);
}

static const rtk_bvhnode *nodes_of(const rtk_tree_header *h)
{
    return (const rtk_bvhnode *)(const void *)((const char *)h + h->off_nodes);
}

/* Fills in what it cost when it was built; false: what it costs now is off by more than `limit` times. Far less is no good sign
 * either: a tree that was built when all vertices stood in one place, say, knows nothing of how they stand now. */
static bool good_enough(const rtk_tree_header *old, rtk_tree_header *h, float limit, float *costs, uint8_t *depths)
{
    float now = mean_cost(h, nodes_of(h), costs, depths);
    h->built_cost = old->built_cost > 0.0f ? old->built_cost : mean_cost(old, nodes_of(old), costs, depths);
    return now <= limit * h->built_cost && h->built_cost <= limit * now;
}

/* ---- the whole ---- */

bool rti_bvh_refits(const void *chunk)
{
    const rtk_tree_header *h = chunk;
    return h->kind == RTK_TREE_BVH && h->flags != RTI_BUILD_BVH_SPATIAL && h->ref_count - h->filler_count == h->prim_count;
}

/* All but the blocks, which are written anew. */
static void copy_rest(char *to, const char *from, size_t size)
{
    const rtk_tree_header *h = (const rtk_tree_header *)(const void *)from;
    size_t nodes_end = h->off_nodes + h->node_count * sizeof(rtk_bvhnode);
    size_t blocks_end = nodes_end + h->block_count * sizeof(rtk_bvhblock); /* they stand behind the nodes */
    memcpy(to, from, nodes_end);
    memcpy(to + blocks_end, from + blocks_end, size - blocks_end);
}

static void fit(rt_context *ctx, refit *r)
{
    const rtk_tree_header *h = r->head;
    rti_parallel(ctx, (h->block_count + BLOCKS_A_TASK - 1) / BLOCKS_A_TASK, block_task, r);
    rti_parallel(ctx, (h->node_count + NODES_A_TASK - 1) / NODES_A_TASK, leaf_task, r);
    if (!rti_cancelled(r->cancel))
        fit_nodes(r);
}

rt_status rti_bvh_refit(rt_context *ctx, const void *old, size_t size, const rti_refit_input *input, float limit,
                        rti_cancel *cancel, void **chunk)
{
    double start = rti_now();
    const rtk_tree_header *from = old;
    char *bytes = rti_alloc(ctx, size);
    rtk_tree_header *h = (rtk_tree_header *)(void *)bytes;
    float *costs = rti_alloc_array(ctx, from->node_count, sizeof *costs);
    rti_bvh_below *below = rti_alloc_array(ctx, from->node_count, sizeof *below);
    float(*leaves)[RTK_BVH_WIDTH] = rti_alloc_array(ctx, from->node_count, sizeof *leaves);
    uint8_t *depths = rti_alloc(ctx, from->node_count);
    refit r = {.in = input, .cancel = cancel, .head = h};
    rt_status status = RT_OK;
    bool good = false;
    if (bytes && costs && below && leaves && depths) {
        copy_rest(bytes, old, size);
        memcpy(h->lo, input->lo, sizeof h->lo);
        memcpy(h->hi, input->hi, sizeof h->hi);
        r.nodes = (rtk_bvhnode *)(void *)(bytes + h->off_nodes);
        r.blocks = (rtk_bvhblock *)(void *)(bytes + h->off_blocks);
        r.refs = (const uint32_t *)(const void *)(bytes + h->off_refs);
        r.order = (rti_bvh_order){r.nodes, r.blocks, h->block_count, rti_bvh_unit(h->lo, h->hi), below, leaves};
        rti_tree_balls(ctx, bytes, input->shapes, input->tri_count);
        fit(ctx, &r);
        if (rti_cancelled(cancel))
            status = rti_fail(ctx, RT_ERROR_CANCELLED, "the tree's refit was cancelled");
        else if ((good = good_enough(from, h, limit, costs, depths)))
            rti_tree_measure(ctx, h);
    } else {
        status = rti_fail_memory(ctx, "refitting a tree", size);
    }
    rti_free(ctx, costs, from->node_count * sizeof *costs);
    rti_free(ctx, below, from->node_count * sizeof *below);
    rti_free(ctx, leaves, from->node_count * sizeof *leaves);
    rti_free(ctx, depths, from->node_count);
    if (good)
        h->build_seconds = (float)(rti_now() - start);
    else
        rti_free(ctx, bytes, bytes ? size : 0);
    *chunk = good ? bytes : NULL;
    return status;
}
