/** librt: looking into the trees of a scene, and at what rays cost in them. Cells, references and steps mean the same for every kind of tree,
 *  and nothing here depends on how one is laid out.
 *
 *  A tree is named by the tracer that walks it and by what it stands over: group 0 is the scene's own geometry, then come the scenes that
 *  are instanced, in the order of their first use, each in its own space; RT_INVALID_ID is the top level over the instances. A tree that is
 *  missing is built first. All calls here read the committed snapshot, from any thread, beside edits and renders too. */
#ifndef LIBRT_TREE_H
#define LIBRT_TREE_H

#include "librt/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A part of space in a tree: a leaf, or all leaves below a node where the query says to go no deeper. */
typedef struct rt_tree_cell {
    rt_vec3 low, high;
    uint32_t depth;        /**< levels below the root, which is 0 */
    uint32_t leaves;       /**< in it; 1: the cell is a leaf */
    uint32_t empty_leaves; /**< of them without a reference */
    uint32_t deepest;      /**< depth of the deepest leaf in it */
    uint32_t largest;      /**< references of its fullest leaf */
    uint64_t references;   /**< of all its leaves to primitives (top level: to instances) */
    uint32_t corner_count; /**< with a cut: corners of the polygon in which the plane meets the cell, 3 ... 6, in order around it; else 0 */
    rt_vec3 corners[6];
} rt_tree_cell;

typedef struct rt_tree_query {
    uint32_t struct_size;
    const char *tracer; /**< "auto" or a tracer that walks a tree; rt_tracer_at lists them */
    uint32_t group;     /**< 0: the scene's own geometry; see above */
    int cut;            /**< 1: only cells that the plane meets, each with its polygon */
    rt_vec3 point, normal; /**< the plane; normal of any length, not zero. Where it runs along a face, the cell on the side that the normal comes from has it */
    uint32_t max_depth; /**< a cell at this depth is given whole, as one; RT_INVALID_ID: all leaves */
    float min_size;     /**< so is a cell whose longest edge is below this, in the tree's units; 0: all leaves */
    uint32_t part;      /**< which tree of a group that has several (rt_tree_info.part); 0 */
} rt_tree_query;
RT_API rt_tree_query rt_tree_query_default(void);

/** One cell; it lives as long as the call. Non-zero ends the walk. */
typedef int (*rt_tree_cell_fn)(void *user, const rt_tree_cell *cell);

/** Calls fn for the cells of a tree, in the tree's own order, on the calling thread. Leaves of a kd-tree or an octree tile its
 *  root box; those of a BVH overlap and leave gaps. A group without bounded geometry, or a top level without instances, has no
 *  cells.
 *  Errors   ARGUMENT (the tracer has no tree, there is no such group or part, no plane), STATE (not committed), MEMORY, MEMORY_LIMIT, CANCELLED (fn ended it)
 *  Threads  any */
RT_API rt_status rt_scene_tree_cells(const rt_scene *scene, const rt_tree_query *query, rt_tree_cell_fn fn, void *user);

/** Box of a tree, and the costs of its builder's model: sah_cost (rt_tree_info) is the mean, over lines that cross the box at random, of
 *  cost_traverse * (inner nodes visited) + cost_intersect * (primitives tested) if a ray never ended. */
typedef struct rt_tree_shape {
    rt_vec3 low, high; /**< low > high: there is no tree */
    float sah_cost, cost_traverse, cost_intersect;
} rt_tree_shape;
/** Errors as rt_scene_tree_cells. query: tracer, group and part count. */
RT_API rt_status rt_scene_tree_shape(const rt_scene *scene, const rt_tree_query *query, rt_tree_shape *shape);

/** A piece of the line in which a plane meets a surface. */
typedef struct rt_section {
    rt_vec3 from, to;
    uint32_t prim_id, geom_id, inst_id; /**< as in hits */
} rt_section;
typedef int (*rt_section_fn)(void *user, const rt_section *piece);
/** Calls fn for the outlines of primitives in a plane, in description order, on the calling thread. Triangles give one piece; round shapes are followed by
 *  short ones (a sphere: 96). group: as in rt_tree_query; RT_INVALID_ID: all instances, placed. Infinite planes and the bodies of removed geometries give none.
 *  Errors   ARGUMENT (no such group; the normal is zero or no number), STATE, CANCELLED (fn ended it). Threads any */
RT_API rt_status rt_scene_cut(const rt_scene *scene, uint32_t group, rt_vec3 point, rt_vec3 normal, rt_section_fn fn, void *user);

/** What one ray cost. */
typedef struct rt_ray_cost {
    /** Inner nodes and leaves visited, primitives tested. Of a kd-tree or an octree in its cells: all that a leaf lists counts as
     *  tested; where these are many, the tracer looks at boxes among them first and tests a few. */
    uint32_t nodes, leaves, tests;
} rt_ray_cost;
/** Traces each ray to its closest hit and counts. query: tracer (any) and group: RT_INVALID_ID counts the whole scene, its infinite planes, the top level and the
 *  groups that the ray comes through; another one only that group's tree, the ray in its space. A ray whose mask is 0 sees nothing and runs through all.
 *  Errors   ARGUMENT, STATE, MEMORY, MEMORY_LIMIT. Threads any */
RT_API rt_status rt_scene_ray_costs(const rt_scene *scene, const rt_tree_query *query, const rt_ray *rays, rt_ray_cost *costs, size_t count);

#ifdef __cplusplus
}
#endif
#endif
