/* What the tree builders share: references with clipped boxes, settled settings, growing output, the chunk. Private to accel/. */
#ifndef RTI_BUILD_H
#define RTI_BUILD_H

#include "../base/isa.h"
#include "../kernel/kd.h"
#include "../kernel/octree.h"
#include "accel.h"

#define RTI_NODE_MAX 0x3fffffffu /* node indices and leaf counts have 30 bits */
#define RTI_REF_MAX  0x3fffffffu

/* A primitive's part of a cell: its clipped box, grown and cut to the cell. */
typedef struct rti_ref {
    float lo[3];
    uint32_t prim;
    float hi[3];
    uint32_t pad;
} rti_ref;

typedef struct rti_cell {
    float lo[3], hi[3];
} rti_cell;

/* The cell that a tree begins with, of a box: that, or where it is flat, of an octree a wider one. */
rti_cell rti_root_cell(bool octree, const float lo[3], const float hi[3]);

/* Input and settings with every default settled. root: the root's cell, which holds the input's box; min_size: no cell gets thinner
 * on an axis that is split. */
typedef struct rti_build {
    const rti_build_input *in;
    rti_cell root;
    uint32_t builder, max_depth, leaf_size, prim_count;
    float cost_traverse, cost_intersect, empty_bonus, duplication;
    float cost_sought; /* of a kd-tree: planes are looked for as if a primitive cost this, cost_intersect or more */
    float min_size;
    uint32_t clip_above; /* triangles are clipped in nodes of more references */
    rti_isa isa;
    rti_cancel *cancel;
} rti_build;

/* isa becomes generic; who has a context sets it then. */
void rti_build_settle(rti_build *b, const rti_build_input *input, const rti_build_settings *settings, rti_cancel *cancel);

/* Bytes of so many balls of a tree, and of what fills up: eight are read from any place on. */
static inline size_t rti_balls_room(uint32_t count, uint32_t size)
{
    return count == 0 ? 0 : ((size_t)count + 14) / 8 * 8 * size * sizeof(float);
}

/* Asks for a triangle ahead, which may lie across two lines of a cache. */
static inline void rti_tri_expect(const rtk_tri *tri)
{
    __builtin_prefetch(tri);
    __builtin_prefetch(&tri->v2[2]);
}

/* The reference of primitive `prim` at the root; false when it does not touch the root box (or is not finite). */
bool rti_ref_root(const rti_build *b, uint32_t prim, rti_ref *out);
/* All of them in one new block of *count (rti_alloc of prim_count references); NULL: no memory. */
rti_ref *rti_refs_root(rt_context *ctx, const rti_build *b, uint32_t *count);

/* Cuts a reference of `cell` that lies on both sides of `pos`. Bit 0: there is a left part, bit 1: a right one (a triangle whose
 * box was there may not be). clip: triangles are clipped to their side; else only boxes are cut, which is quicker and lists a
 * triangle where it is not. */
unsigned rti_ref_cut(const rti_build *b, const rti_cell *cell, const rti_ref *ref, unsigned axis, float pos, bool clip,
                     rti_ref *left, rti_ref *right);

/* The reference of a triangle in a cell, clipped; false: no part of it is there. */
bool rti_ref_clip(const rti_build *b, const rti_cell *cell, uint32_t prim, rti_ref *out);

/* Nodes and references as they are written, in growing arrays. One a task. */
typedef struct rti_tree_out {
    void *nodes;
    uint32_t *refs;
    size_t node_size, node_count, node_capacity, ref_count, ref_capacity;
} rti_tree_out;
/* Room for `more` nodes at the end, zeroed; SIZE_MAX: no memory. */
size_t rti_out_nodes(rt_context *ctx, rti_tree_out *out, size_t more);
/* which: places in `refs`; NULL: 0, 1 and so on. */
bool rti_out_refs(rt_context *ctx, rti_tree_out *out, const rti_ref *refs, const uint32_t *which, uint32_t count,
                  uint32_t *first);
void rti_out_free(rt_context *ctx, rti_tree_out *out);

/* Fills in the statistics of a header whose nodes are in place (tree_measure.c), by tasks of the context. */
void rti_tree_measure(rt_context *ctx, rtk_tree_header *header);

/* ---- the choice of a kd split (kd_split.c) ---- */

typedef struct rti_kd_split {
    float cost, pos;
    uint32_t axis;                    /* 3: none */
    uint32_t left_count, right_count; /* of references on each side; the binned builder's are close to it */
} rti_kd_split;

/* The cheapest plane for `count` references in `cell`, if it is cheaper than a leaf where a primitive costs b->cost_sought. ctx:
 * its workers look for it together; NULL: the caller alone, who finds the same. scratch: 3 * count floats, 9 * count with ctx. */
rti_kd_split rti_kd_find_split(rt_context *ctx, const rti_build *b, const rti_cell *cell, const rti_ref *refs, uint32_t count,
                               float *scratch);

/* ---- the frame of the builders of cells (top.c) ---- */

/* A node of a tree of cells that have two children each: a kd-tree while it is built, or what an octree is read as. lo, hi: of a
 * leaf, around what it lists, as references have it: grown and cut to the cell. */
typedef struct rti_cell_node {
    rtk_kdnode node;
    float lo[3], hi[3];
} rti_cell_node;

/* A node to be built. budget: references its subtree may come to; a split that needs more is not made. */
typedef struct rti_item {
    rti_cell cell;
    uint32_t node, count, depth, budget;
} rti_item;

/* A node of the top and what its split gave. */
typedef struct rti_open {
    rti_item it;
    rti_ref *refs;
    size_t capacity; /* of refs, for its release */
    bool leaf;
    rti_kd_split split; /* kd only */
    rti_item children[8];
    rti_ref *child_refs[8];
    size_t child_capacity[8];
    rt_status status;
} rti_open;

/* Nodes while they are built begin with what the chunk has of them. */
typedef struct rti_method {
    uint32_t kind;               /* RTK_TREE_* */
    size_t node_size, kept_size; /* of a node while it is built, and in the chunk */
    uint32_t child_count;
    /* Splits a large node: leaf, or children and their references. On an error what was allocated is left in the node. */
    rt_status (*split)(rt_context *ctx, const rti_build *b, rti_open *o);
    void (*write_inner)(void *node, const rti_open *o, uint32_t child);
    /* Builds a part whose references are `refs` (of `capacity`), which it frees. */
    rt_status (*part)(rt_context *ctx, const rti_build *b, const rti_item *root, rti_ref *refs, size_t capacity,
                      rti_tree_out *out);
    /* Moves where a leaf's references, or an inner node's children, are. */
    void (*move)(void *node, uint32_t nodes, uint32_t refs);
    /* The tree as cells of two children, cell_count(nodes) of them; false: cancelled. NULL: its nodes are such cells. */
    uint64_t (*cell_count)(size_t nodes);
    bool (*write_cells)(const rti_build *b, const rti_tree_out *tree, rti_cell_node *cells);
} rti_method;

/* A tree by a method, with nodes of eight. */
rt_status rti_top_build(rt_context *ctx, const rti_build *b, const rti_method *method, double start, void **chunk, size_t *size);
/* The chunk of a tree whose nodes and references all stand in `tree`: those, and its leaves in blocks and boxes by eights
 * (cell_wide.c). start: rti_now() when the build began. */
rt_status rti_cell_widen(rt_context *ctx, const rti_build *b, const rti_method *method, const rti_tree_out *tree, double start,
                         void **chunk, size_t *size);
rt_status rti_kd_build(rt_context *ctx, const rti_build *b, double start, void **chunk, size_t *size);
rt_status rti_octree_build(rt_context *ctx, const rti_build *b, double start, void **chunk, size_t *size);
rt_status rti_bvh_build(rt_context *ctx, const rti_build *b, double start, void **chunk, size_t *size);

#endif
