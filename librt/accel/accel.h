/* Tree builders. A builder gets boxes (and, for clipping, triangles) and gives a TREE chunk's bytes. */
#ifndef RTI_ACCEL_H
#define RTI_ACCEL_H

#include "../base/base.h"
#include "../kernel/snapshot.h"

enum { RTI_BUILD_KD_EXACT = 0, RTI_BUILD_KD_BINNED, RTI_BUILD_OCTREE, RTI_BUILD_BVH, RTI_BUILD_BVH_COMPACT, RTI_BUILD_BVH_SPATIAL };

/* Of the BVH builders: binned heuristic, with copies of the vertices in the leaves or without; with copies and spatial splits. */
static inline bool rti_builds_bvh(uint32_t builder)
{
    return builder >= RTI_BUILD_BVH && builder <= RTI_BUILD_BVH_SPATIAL;
}

typedef struct rti_build_settings {
    uint32_t builder;   /* RTI_BUILD_* */
    uint32_t max_depth; /* 0: 8 + 1.3 log2(n) for kd (at most 64), 16 for the octree, 48 for the BVH; at most 96 */
    /* octree: split above it (1024 where most are triangles, 32 shapes, 8 instances); kd: cost decides, this only stops
     * at <= it; BVH: no leaf has more. 0: default */
    uint32_t leaf_size;
    float cost_traverse, cost_intersect, empty_bonus; /* <= 0 / NaN: defaults */
    float duplication; /* refs may grow to this times the primitives; 0: default. A subtree over its share becomes a leaf */
} rti_build_settings;

/* Settings with a name, for people: "default", "fast", "paper", "octree", "bvh", ... */
typedef struct rti_build_preset {
    const char *name, *help;
    rti_build_settings settings;
} rti_build_preset;
uint32_t rti_build_preset_count(void);
const rti_build_preset *rti_build_preset_at(uint32_t index);
const rti_build_preset *rti_build_preset_find(const char *name); /* NULL when there is none */

/* What is built over: a group (tris then shapes, as tree references count) or instances' boxes (tris = NULL). Boxes are the
 * primitives' own, not grown. grow: RTK_GROW * scale: every builder lists a primitive where its (clipped) box grown by this
 * overlaps the cell. */
typedef struct rti_build_input {
    const rtk_tri *tris;
    uint32_t tri_count;
    const float (*boxes)[6]; /* lo xyz, hi xyz of the remaining primitives: shapes or instances, box_count of them */
    uint32_t box_count;
    float lo[3], hi[3]; /* root box, already grown */
    float grow;
    uint32_t balls; /* floats of each (rtk_tree_header.ball_size), which rti_tree_balls is to write; 0: there are to be none */
} rti_build_input;

/* Builds with the context's workers; the same bytes for any number of them. The chunk (header rtk_tree_header, arrays 64-byte
 * aligned) is one block of *size bytes from rti_alloc. Errors: MEMORY, MEMORY_LIMIT, CANCELLED (polled at least every few ms of
 * work). */
rt_status rti_tree_build(rt_context *ctx, const rti_build_input *input, const rti_build_settings *settings, rti_cancel *cancel,
                         void **chunk, size_t *size);

/* Where the primitives of a group now are; bounds and growth as of a build. */
typedef struct rti_refit_input {
    const rtk_tri *tris;
    const rtk_shape *shapes;
    uint32_t tri_count;
    float lo[3], hi[3];
    float grow;
} rti_refit_input;

/* Can it be refitted: is it a BVH whose primitives stand in one leaf each? */
bool rti_bvh_refits(const void *chunk);
/* A copy of such a tree (size bytes) fitted to primitives that have moved: the same nodes, references and size. *chunk is NULL, without an error,
 * where its cost would be off by more than `limit` times from that of the tree that was built (bvh_refit.c says how costs are held against each other).
 * The same bytes for any number of workers. Errors: MEMORY, MEMORY_LIMIT, CANCELLED. */
rt_status rti_bvh_refit(rt_context *ctx, const void *old, size_t size, const rti_refit_input *input, float limit, rti_cancel *cancel,
                        void **chunk);

/* Bytes a build may need at its peak, for estimates before a render. */
uint64_t rti_tree_build_memory(const rti_build_input *input, const rti_build_settings *settings);

/* Checks a TREE chunk that came from outside: offsets, child and reference indices, leaf bounds, depth <= 96, no cycle.
 * prim_limit: references must be below. */
bool rti_tree_valid(const void *chunk, size_t size, uint32_t prim_limit);
/* Of a valid chunk: its blocks, if it has any, hold the vertices of the triangles that their references name, and its balls and
 * forms the shapes. tris, then shapes, as in references. */
bool rti_tree_copies_valid(const void *chunk, const rtk_tri *tris, uint32_t tri_count, const rtk_shape *shapes);
/* Of a valid chunk: it is of a tree over this box, by its root (rti_root_cell). */
bool rti_tree_is_over(const void *chunk, const float lo[3], const float hi[3]);

/* Writes the balls (rtk_tree_header.ball_count) of a tree over a group's primitives, which it was built with room for or has had
 * before. shapes: the group's, of which references from tri_count on are. The same bytes for any number of workers. */
void rti_tree_balls(rt_context *ctx, void *chunk, const rtk_shape *shapes, uint32_t tri_count);

/* View of a chunk (offsets resolved). */
rtk_tree rti_tree_view(const void *chunk);

/* SAH cost of a tree with its own constants, from its nodes (the number in the header is this). */
float rti_tree_sah(const rtk_tree_header *tree);

/* ---- any kind of tree, seen from outside ---- */

#define RTI_TREE_CHILDREN 8u /* a node has at most so many */
/* What waits while a tree is walked depth first: seven a level, kd one. */
#define RTI_TREE_WALK (RTI_TREE_CHILDREN * 96u)

typedef struct rti_tree_spot {
    float lo[3], hi[3]; /* its cell */
    uint32_t node, depth;
    uint32_t leaf; /* BVH: references of a slot that is a leaf (there is no node for it) */
} rti_tree_spot;

/* A kind of tree is one row of the table in tree.c: what RT_API calls its trees, and how a node opens. open writes the children
 * of the spot in the tree's order and returns how many; a leaf has none, and its references are counted in *refs. */
typedef struct rti_tree_kind {
    const char *name;
    uint32_t kind; /* RTK_TREE_* */
    uint32_t (*open)(const rtk_tree *tree, const rti_tree_spot *spot, rti_tree_spot *children, uint32_t *refs);
} rti_tree_kind;
const rti_tree_kind *rti_tree_kind_of(uint32_t kind);
rti_tree_spot rti_tree_root(const rtk_tree *tree);

#endif
