/* What the files of the BVH's builder share. Private to accel/.
 *
 * The builder makes a binary tree first (bvh_refs.c: its references; bvh_build.c: levels of large ranges by all workers together,
 * then the small ones a task each; bvh_bins.c and bvh_spatial.c choose splits), then chooses what of it becomes slots of nodes of
 * eight (bvh_fold.c), writes those (bvh_write.c), and puts their slots in order (bvh_order.c). Everything that is decided depends
 * on the references alone, never on who works on them.
 */
#ifndef RTI_BVH_BUILD_H
#define RTI_BVH_BUILD_H

#include <string.h>

#include "../kernel/bvh.h"
#include "build.h"
#include "bvh_order.h"
#include "vectors.h"

#define RTI_BVH_BINS 16u

/* Below this depth ranges are halved whatever that costs: so no build gets deeper than RTI_BVH_BINARY, nor slower than n log n.
 */
#define RTI_BVH_CAREFUL 64u
#define RTI_BVH_BINARY  (RTI_BVH_CAREFUL + 32u)

typedef struct rti_bvh_box {
    rti_f4 lo, hi; /* the fourth is anything */
} rti_bvh_box;

static inline rti_bvh_box rti_bvh_nothing(void)
{
    rti_bvh_box b = {rti_f4_set(RTK_INF), rti_f4_set(-RTK_INF)};
    return b;
}

static inline void rti_bvh_extend(rti_bvh_box *b, rti_bvh_box by)
{
    b->lo = rti_f4_min(b->lo, by.lo);
    b->hi = rti_f4_max(b->hi, by.hi);
}

/* A node of the binary tree. count > 0: a leaf, `child` its first entry in order[]; else child and child + 1 are its children, or
 * where child is 0 nothing is listed below (of cells). */
typedef struct rti_bvh_node {
    float lo[3];
    uint32_t child;
    float hi[3];
    uint32_t count;
} rti_bvh_node;

/* References that become a subtree: refs[buffer][begin ...]. They may use [room_begin, room_end) in both buffers, order[]
 * likewise. */
typedef struct rti_bvh_range {
    rti_bvh_box box, mid; /* of the references, and of lo + hi of each */
    uint32_t begin, count, room_begin, room_end;
    uint32_t node, depth, buffer;
} rti_bvh_range;

/* How to split: by lo + hi into bins along an axis; those below `bin` go left. */
typedef struct rti_bvh_split {
    rti_f4 base, scale; /* bin = (lo + hi - base) * scale, cut to 0 ... bins - 1 */
    uint32_t axis, bin, bins;
    uint32_t left_count, right_count;
    float cost; /* infinite: there is none */
    rti_bvh_box left, right;
    bool wants_space; /* spatial bins are to be made */
    bool spatial;     /* by a plane in space instead: bin = (x - space_base) * space_scale, references on both sides are cut */
    rti_f4 space_base, space_scale;
    uint32_t space_bins;
    float planes[3][RTI_BVH_BINS]; /* where spatial bins begin */
} rti_bvh_split;

typedef struct rti_bvh_bins {
    _Alignas(32) rti_bvh_box box[3][RTI_BVH_BINS]; /* as bvh_bins.c has them */
    uint32_t count[3][RTI_BVH_BINS];
} rti_bvh_bins;

/* Of spatial splits: boxes of what lies in each bin, and how many references begin and end there. */
typedef struct rti_bvh_space_bins {
    rti_bvh_box box[3][RTI_BVH_BINS];
    uint32_t enter[3][RTI_BVH_BINS], leave[3][RTI_BVH_BINS];
} rti_bvh_space_bins;

typedef struct rti_bvh_kernels rti_bvh_kernels;

/* One build. */
typedef struct rti_bvh {
    rt_context *ctx;
    const rti_bvh_kernels *kernels;
    const rti_build *b;
    bool blocks;             /* leaves of triangles get them */
    bool balls;              /* all there is are shapes, which leaves meet in vectors */
    uint32_t depth;          /* levels of nodes of eight, at most */
    float grow;              /* of the boxes that are written */
    const rti_tree_out *own; /* the nodes and references of a tree of cells, by `method`; NULL: a BVH */
    const rti_method *method;
    const rti_cell_node *cells; /* that tree with two children each: cell_count nodes, the first of `nodes` */
    uint32_t cell_count;
    uint32_t most;             /* references of a leaf */
    uint32_t together;         /* 1 << this: references that cost as much as one, */
    float leaf_cost;           /* namely so much, in areas */
    rti_f4 grow2;              /* what boxes are grown by on both sides together */
    float unit;                /* areas are relative to a cube of side 1 / unit */
    bool spatial;              /* splits may cut references */
    float root_area, thinnest; /* what is thinner is not cut */
    float fine_area;           /* ranges of more are split down to a block: leaves of blocks merge (bvh_fold.c) */
    float finest_area;         /* and of more, down to one: walls that are far from each other are no leaf */
    float many_area;           /* what has more is met by many rays of a stream at a time */
    rti_ref *refs[2];          /* one block of 2 * room */
    size_t room;
    uint32_t *order; /* primitives of leaves */
    rti_bvh_node *nodes;
    size_t node_capacity;
    uint32_t top_count; /* nodes made before the parts; the parts' nodes stand behind them */
} rti_bvh;

/* A box's sides as it is written, in units. */
static inline rti_f4 rti_bvh_sides(const rti_bvh *t, rti_bvh_box b)
{
    rti_f4 unit = {t->unit, t->unit, t->unit, 0.0f};
    return rti_f4_xyz((b.hi - b.lo) + t->grow2) * unit;
}

static inline float rti_bvh_area(const rti_bvh *t, rti_bvh_box b)
{
    return rti_f4_area(rti_bvh_sides(t, b));
}

/* As that, of a box of three floats. */
static inline float rti_bvh_area_of(const rti_bvh *t, const float lo[3], const float hi[3])
{
    return rti_bvh_area(t, (rti_bvh_box){{lo[0], lo[1], lo[2], 0.0f}, {hi[0], hi[1], hi[2], 0.0f}});
}

/* Sets unit, root_area and many_area of what the tree is over; blocks and grow2 are set. */
static inline void rti_bvh_set_areas(rti_bvh *t)
{
    const rti_build_input *in = t->b->in;
    t->unit = rti_bvh_unit(in->lo, in->hi);
    t->root_area = rti_bvh_area_of(t, in->lo, in->hi);
    t->many_area = t->blocks && in->box_count <= in->tri_count / RTK_BVH_MESH ? 0.03f * t->root_area : RTK_INF; /* as streams go */
}

static inline float rti_bvh_node_area(const rti_bvh *t, uint32_t node)
{
    const rti_bvh_node *n = &t->nodes[node];
    const rti_bvh_box b = {rti_f4_load(n->lo), rti_f4_load(n->hi)};
    return rti_bvh_area(t, b);
}

/* Does an inner node, and do its children, stand in the top? What is below any other is one task's. */
static inline bool rti_bvh_in_top(const rti_bvh *t, uint32_t node)
{
    return node < t->top_count && t->nodes[node].child < t->top_count;
}

static inline rti_bvh_box rti_bvh_ref_box(const rti_ref *r)
{
    rti_bvh_box b = {rti_f4_load(r->lo), rti_f4_load(r->hi)};
    return b;
}

static inline rti_f4 rti_bvh_mid(rti_bvh_box b)
{
    return rti_f4_xyz(b.lo + b.hi);
}

/* Which bin, on each axis: `at` cut to 0 ... last. */
static inline void rti_bvh_bins_of(rti_f4 at, float last, int32_t out[4])
{
    rti_i4 bin = rti_f4_ints(rti_f4_min(rti_f4_max(at, rti_f4_set(0.0f)), rti_f4_set(last)));
    memcpy(out, &bin, sizeof bin);
}

/* Writes t->refs[0], of all primitives whose box is one, and the range of them; by tasks of `size` primitives (bvh_refs.c). Errors
 * MEMORY, CANCELLED. */
rt_status rti_bvh_make_refs(rti_bvh *t, uint32_t size, rti_bvh_range *root);

/* What is compiled for each instruction set (bvh_bins.c); of bins that are as they are made and read there. */
struct rti_bvh_kernels {
    void (*bin)(const rti_bvh_split *split, const rti_ref *refs, uint32_t count, rti_bvh_bins *bins);
    void (*add)(const rti_bvh_split *split, rti_bvh_bins *to, const rti_bvh_bins *from);
    /* The cheapest split of the bins; cost in areas times intersections, traversal left out. */
    void (*find)(const rti_bvh *t, const rti_bvh_bins *bins, rti_bvh_split *split);
    /* Left ones go to `left` ascending, right ones to `right` - 1 descending; mids are extended. */
    void (*scatter)(const rti_bvh_split *split, const rti_ref *refs, uint32_t count, rti_ref *left, rti_ref *right,
                    rti_bvh_box mids[2]);
};
const rti_bvh_kernels *rti_bvh_kernels_at(rti_isa isa);
/* Bins for a range whose mids fill `mid`. */
void rti_bvh_split_begin(const rti_bvh_range *range, rti_bvh_split *split);
/* The cheapest split of some references by bins; axis 3: nothing parts them. t: kernels and what areas and leaves cost are set. */
void rti_bvh_split_refs(const rti_bvh *t, const rti_ref *refs, uint32_t count, rti_bvh_split *split);
/* How many of what was binned go left. */
uint32_t rti_bvh_split_left(const rti_bvh_split *split, const rti_bvh_bins *bins);
/* Spatial splits (bvh_spatial.c), after `find`. begin: false when they are not worth a try. find: takes one that is
 * cheaper and needs no more than `room` references. counts: of what was binned. scatter: also the boxes of the two sides. */
bool rti_bvh_spatial_begin(const rti_bvh *t, const rti_bvh_range *range, rti_bvh_split *split);
void rti_bvh_spatial_bin(const rti_bvh *t, const rti_bvh_split *split, const rti_ref *refs, uint32_t count,
                         rti_bvh_space_bins *bins);
void rti_bvh_space_bins_add(rti_bvh_space_bins *to, const rti_bvh_space_bins *from);
void rti_bvh_spatial_find(const rti_bvh *t, const rti_bvh_space_bins *bins, uint32_t room, rti_bvh_split *split);
void rti_bvh_spatial_counts(const rti_bvh_split *split, const rti_bvh_space_bins *bins, uint32_t *left, uint32_t *right);
void rti_bvh_spatial_scatter(const rti_bvh *t, const rti_bvh_split *split, const rti_ref *refs, uint32_t count, rti_ref *left,
                             rti_ref *right, rti_bvh_box boxes[2], rti_bvh_box mids[2]);
/* Cost of a leaf of so many, per area. */
static inline float rti_bvh_leaf_cost(const rti_bvh *t, uint32_t count)
{
    return t->leaf_cost * (float)((count + (1u << t->together) - 1u) >> t->together);
}

/* What a node costs beside its slots, and a leaf of so many, both of an area. What many rays come to together they meet sixteen at
 * a time: boxes in a fraction of the time that one ray takes to open a node, which often waits for it, and triangles one by one,
 * so a block that is not full costs less. (One ray a call is 1.01 to 1.3 times as fast by these, too: there are walls in its
 * way.) */
static inline float rti_bvh_node_total(const rti_bvh *t, float area)
{
    return area * t->b->cost_traverse * (area > t->many_area ? 0.5f : 2.0f);
}
static inline float rti_bvh_leaf_total(const rti_bvh *t, float area, uint32_t count)
{
    if (area > t->many_area)
        return area * t->leaf_cost * (float)count / (float)(1u << t->together);
    return area * rti_bvh_leaf_cost(t, count);
}

/* Which nodes become slots of nodes of eight (bvh_fold.c): a word for each inner node into cuts, which has as many
 * as the tree has nodes. per_node: what a node costs beside its area, in areas. Works by tasks of the context. Errors MEMORY,
 * CANCELLED. */
rt_status rti_bvh_cut(const rti_bvh *t, uint32_t root, float per_node, uint32_t *cuts);
/* What is a leaf then: one of the binary tree, or at most RTI_BVH_MERGED references of several. */
#define RTI_BVH_MERGED 16u
bool rti_bvh_is_leaf(const rti_bvh *t, const uint32_t *cuts, uint32_t node);
/* The slots of the node of eight that is made of a binary one. Returns how many. */
uint32_t rti_bvh_slots(const rti_bvh *t, const uint32_t *cuts, uint32_t node, uint32_t slots[RTK_BVH_WIDTH]);
/* The leaves of the binary tree below a node, one a call, then RTK_INVALID. At first {1, {node}}. The larger child waits, so each
 * that does has at most half of the references of the one before, and there are fewer than 2^32. */
typedef struct rti_bvh_leaves {
    uint32_t count, wait[34];
} rti_bvh_leaves;
uint32_t rti_bvh_next_leaf(const rti_bvh *t, const uint32_t *cuts, rti_bvh_leaves *at);

/* Makes t->nodes and t->order of a tree of cells, which `t` has, its large leaves cut into pieces (cell_leaf.c): their nodes are
 * behind the cell_count, and of the others the boxes of leaves alone are set. The caller frees both, node_capacity and
 * own->ref_count long.
 * Works by tasks of the context. Errors MEMORY, CANCELLED. */
rt_status rti_cells_cut(rti_bvh *t);

/* Folds the binary tree into a chunk. root: its node; RTK_INVALID: there is nothing in it. The references' block is taken for it,
 * or freed. */
rt_status rti_bvh_write(rti_bvh *t, uint32_t root, double start, void **chunk, size_t *size);

#endif
