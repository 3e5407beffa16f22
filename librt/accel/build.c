/* Building a tree: settings, growing output, and the parts put together as a chunk. */
#include <string.h>

#include "../kernel/bvh.h"
#include "build.h"
#include "librt/base.h"

static const rti_build_preset presets[] = {
    {"default", "kd-tree by the exact surface area heuristic", {.builder = RTI_BUILD_KD_EXACT}},
    {"fast", "kd-tree by binned heuristic: builds faster, traces as fast or a little slower", {.builder = RTI_BUILD_KD_BINNED}},
    {"paper",
     "exact kd-tree of up to 96 levels, for comparison with published tables",
     {.builder = RTI_BUILD_KD_EXACT, .max_depth = 96, .leaf_size = 2, .cost_intersect = 1.0f, .duplication = 64.0f}},
    {"octree", "octree of large leaves that are cut into pieces", {.builder = RTI_BUILD_OCTREE}},
    {"bvh", "eight-wide BVH by binned heuristic", {.builder = RTI_BUILD_BVH}},
    {"bvh spatial",
     "eight-wide BVH with spatial splits: builds slower, traces rays one by one faster, batches as fast",
     {.builder = RTI_BUILD_BVH_SPATIAL}},
    {"bvh compact", "eight-wide BVH without copies of the vertices: half the memory", {.builder = RTI_BUILD_BVH_COMPACT}},
};

uint32_t rti_build_preset_count(void)
{
    return (uint32_t)RTI_COUNT(presets);
}

const rti_build_preset *rti_build_preset_at(uint32_t index)
{
    return index < RTI_COUNT(presets) ? &presets[index] : NULL;
}

const rti_build_preset *rti_build_preset_find(const char *name)
{
    for (size_t i = 0; i < RTI_COUNT(presets); i++)
        if (strcmp(presets[i].name, name) == 0)
            return &presets[i];
    return NULL;
}

static float settled(float value, float standard)
{
    return value > 0.0f && rtk_finite(value) ? value : standard;
}

static uint32_t kd_depth(uint32_t prim_count)
{
    uint32_t log2 = 0;
    while (log2 < 31 && (prim_count >> log2) > 1)
        log2++;
    return rtk_umin(8 + (13 * log2 + 9) / 10, 64);
}

/* Is it a tree of cells whose leaves are met four triangles at a time (cell_wide.c)? */
static bool by_fours(const rti_build *b)
{
    return !rti_builds_bvh(b->builder) && b->in->tri_count > b->in->box_count;
}

/* What a primitive costs, in steps. A large leaf of triangles is a small tree of blocks itself (cell_leaf.c), of which a ray
 * meets a few: cells that are split further than for this list triangles more often. Of meshes, at a 16th batches are 1.13 times
 * as slow, single rays 1.03, and trees twice as large; below a 256th single rays are slower. */
static float intersect_cost(const rti_build *b)
{
    return by_fours(b) ? 0.0078125f : 1.0f;
}

/* And what it costs where it is told from boxes by nothing but planes: needles that lie across each other have no pieces. Planes
 * that this one asks for are taken, too, where they part about as well as boxes, or better (kd_build.c). */
#define SOUGHT 0.0625f

/* What an octree's cell may list. Triangles become pieces, as a kd-tree's do: by 256 meshes are built in 1.1 to 1.7 times the
 * time and batches are .84 to .97 as fast, for more triangles are listed more often; by 8 it takes six times as long, for half
 * the speed. Balls are met by eights. */
static uint32_t octree_leaf(const rti_build_input *in)
{
    if (in->tri_count > in->box_count)
        return 1024;
    return in->balls != 0 ? 32 : 8;
}

/* Depth and leaves by default; depth at most. */
static void settle_sizes(rti_build *b, const rti_build_settings *s)
{
    uint32_t depth = kd_depth(b->prim_count), most = RTK_KD_DEPTH,
             leaf = by_fours(b) || s->builder == RTI_BUILD_KD_BINNED ? 4 : 2;
    if (s->builder == RTI_BUILD_OCTREE) {
        depth = 16;
        most = RTK_OCT_DEPTH;
        leaf = octree_leaf(b->in);
    } else if (rti_builds_bvh(s->builder)) {
        depth = most = RTK_BVH_DEPTH;
        leaf = b->in->tri_count > 0 ? 16 : (b->in->balls != 0 ? 8 : 4);
    }
    b->max_depth = rtk_umin(s->max_depth ? s->max_depth : depth, most);
    b->leaf_size = s->leaf_size ? s->leaf_size : leaf;
}

/* Of an octree, whose cells are halved on all axes at once, no side of the root is less than this of the longest: cells of a room
 * on a wide floor would be too thin to be halved before they are small. */
#define OCT_SIDE 0.25f

rti_cell rti_root_cell(bool octree, const float lo[3], const float hi[3])
{
    const float longest = rtk_max(rtk_max(hi[0] - lo[0], hi[1] - lo[1]), hi[2] - lo[2]);
    rti_cell root;
    for (int a = 0; a < 3; a++) {
        const float more = octree ? 0.5f * rtk_max(OCT_SIDE * longest - (hi[a] - lo[a]), 0.0f) : 0.0f;
        root.lo[a] = more > 0.0f ? lo[a] - more : lo[a]; /* bit for bit, with zeros' signs */
        root.hi[a] = more > 0.0f ? hi[a] + more : hi[a];
    }
    return root;
}

void rti_build_settle(rti_build *b, const rti_build_input *input, const rti_build_settings *settings, rti_cancel *cancel)
{
    rti_build_settings none = {0};
    const rti_build_settings *s = settings ? settings : &none;
    b->in = input;
    b->builder = s->builder;
    b->prim_count = input->tri_count + input->box_count;
    b->root = rti_root_cell(b->builder == RTI_BUILD_OCTREE, input->lo, input->hi);
    settle_sizes(b, s);
    b->cost_traverse = settled(s->cost_traverse, 1.0f);
    b->cost_intersect = settled(s->cost_intersect, intersect_cost(b));
    b->cost_sought = s->cost_intersect > 0.0f ? b->cost_intersect : rtk_max(b->cost_intersect, SOUGHT);
    b->empty_bonus = rtk_min(settled(s->empty_bonus, 0.2f), 0.95f);
    b->duplication = rtk_max(settled(s->duplication, s->builder == RTI_BUILD_BVH_SPATIAL ? 1.5f : 16.0f), 1.0f);
    if (s->builder == RTI_BUILD_BVH_SPATIAL) /* the room for it is taken before the build */
        b->duplication = rtk_min(b->duplication, 8.0f);
    b->min_size = 0.5f * input->grow;
    b->clip_above = s->builder == RTI_BUILD_KD_BINNED ? 16 : 0;
    b->isa = RTI_ISA_GENERIC;
    b->cancel = cancel;
}

size_t rti_out_nodes(rt_context *ctx, rti_tree_out *out, size_t more)
{
    size_t first = out->node_count;
    if (first > RTI_NODE_MAX - more || !rti_reserve(ctx, &out->nodes, &out->node_capacity, first, more, out->node_size))
        return SIZE_MAX;
    memset((char *)out->nodes + first * out->node_size, 0, more * out->node_size);
    out->node_count += more;
    return first;
}

bool rti_out_refs(rt_context *ctx, rti_tree_out *out, const rti_ref *refs, const uint32_t *which, uint32_t count, uint32_t *first)
{
    if (out->ref_count > RTI_REF_MAX - count ||
        !rti_reserve(ctx, (void **)&out->refs, &out->ref_capacity, out->ref_count, count, sizeof *out->refs))
        return false;
    *first = (uint32_t)out->ref_count;
    for (uint32_t i = 0; i < count; i++)
        out->refs[out->ref_count + i] = refs[which ? which[i] : i].prim;
    out->ref_count += count;
    return true;
}

void rti_out_free(rt_context *ctx, rti_tree_out *out)
{
    rti_free(ctx, out->nodes, out->node_capacity * out->node_size);
    rti_free(ctx, out->refs, out->ref_capacity * sizeof *out->refs);
    memset(out, 0, sizeof *out);
}

rt_status rti_tree_build(rt_context *ctx, const rti_build_input *input, const rti_build_settings *settings, rti_cancel *cancel,
                         void **chunk, size_t *size)
{
    double start = rti_now();
    rti_build b;
    rt_status status;
    *chunk = NULL;
    *size = 0;
    if ((uint64_t)input->tri_count + input->box_count > RTI_REF_MAX)
        return rti_fail(ctx, RT_ERROR_UNSUPPORTED,
                        "a tree over %u triangles and %u other primitives: at most %u together; split the scene into "
                        "instances",
                        input->tri_count, input->box_count, RTI_REF_MAX);
    rti_build_settle(&b, input, settings, cancel);
    b.isa = rti_context_isa(ctx);
    if (rti_cancelled(cancel))
        status = RT_ERROR_CANCELLED;
    else if (b.builder == RTI_BUILD_OCTREE)
        status = rti_octree_build(ctx, &b, start, chunk, size);
    else if (rti_builds_bvh(b.builder))
        status = rti_bvh_build(ctx, &b, start, chunk, size);
    else
        status = rti_kd_build(ctx, &b, start, chunk, size);
    if (status == RT_ERROR_MEMORY)
        return rti_fail_memory(ctx, "building a tree", (size_t)rti_tree_build_memory(input, settings));
    if (status == RT_ERROR_CANCELLED)
        return rti_fail(ctx, status, "the tree's build was cancelled");
    return status;
}

/* Of an octree, by how many references it may have and how few a leaf: empty cells, seven of eight where all that is listed is in
 * one, take as much as others. */
static uint32_t octree_memory(const rti_build *b)
{
    if (b->duplication > 16.0f)
        return b->leaf_size < 8 ? 15000 : 5200;
    if (b->leaf_size < 8)
        return 8500;
    return b->leaf_size < 512 ? 2200 : 1000;
}

/* Measured on the meshes of the benchmarks and on soups, in bytes a primitive at the peak: 100 to 350 for the kd-tree as it
 * comes, up to 1,400 of needles that lie across each other; up to 4,200 for one that splits whenever it can; 110 to 170 for the
 * octree as it comes, up to 900 of triangles as large as the scene; up to 2,100 for one of leaves of eight, and 8,300 where
 * things lie so close in pairs that sixteen levels part them. */
uint64_t rti_tree_build_memory(const rti_build_input *input, const rti_build_settings *settings)
{
    uint64_t n = (uint64_t)input->tri_count + input->box_count;
    rti_build b;
    rti_build_settle(&b, input, settings, NULL);
    if (rti_builds_bvh(b.builder))
        return 16384 + (uint64_t)((double)n * 260.0 * (b.builder == RTI_BUILD_BVH_SPATIAL ? b.duplication : 1.0f));
    if (b.builder == RTI_BUILD_OCTREE)
        return 16384 + n * octree_memory(&b);
    return 16384 + n * (b.duplication > 16.0f || b.leaf_size < 4 || b.cost_intersect > 0.25f * b.cost_traverse ? 4500 : 1400);
}
