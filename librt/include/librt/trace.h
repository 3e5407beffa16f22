/** librt: rays for programs that ask many. A tracer object answers rays from plain arrays or from blocks of sixteen, and is told what is known of them.
 *
 *  rt_scene_intersect and rt_scene_occluded (scene.h) need no object and no thought. A tracer object adds: the choice of the structure and its tree without
 *  another commit; one snapshot for all its calls, whatever is committed meanwhile; hints; rays that stand in blocks already. */
#ifndef LIBRT_TRACE_H
#define LIBRT_TRACE_H

#include "librt/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct rt_tracer rt_tracer;

/** Makes a tracer over the committed snapshot. A tree that it needs and the snapshot lacks is found in the context or built, with the builder's settings of
 *  the last commit.
 *  name     in   "auto", or one that rt_tracer_at lists; NULL: "auto"
 *  tracer   out  set to NULL on error
 *  Errors   ARGUMENT (no such tracer), STATE (not committed), MEMORY, MEMORY_LIMIT
 *  Threads  any, beside edits, commits and queries too
 *  Owner    the caller: rt_tracer_destroy, before the context's end. It holds the snapshot: later commits change nothing here */
RT_API rt_status rt_tracer_create(const rt_scene *scene, const char *name, rt_tracer **tracer);
/** NULL is fine. */
RT_API void rt_tracer_destroy(rt_tracer *tracer);

typedef struct rt_tracer_info {
    const char *name;        /**< of the tracer that answers; "auto" comes out as what it stands for */
    const char *tree;        /**< kind of its trees, as in rt_tree_info; NULL: it needs none */
    uint32_t width;          /**< rays handled together without a hint; 1: one at a time */
    uint32_t trees;          /**< of all groups, their parts and the top level */
    uint64_t tree_bytes;     /**< of these trees: nodes, leaves and what leaves hold */
    uint64_t geometry_bytes; /**< triangles and shapes as every tracer reads them, beside the trees */
    double build_seconds;    /**< wall time that the trees took when they were built, which may have been earlier */
} rt_tracer_info;
/** Errors none. Threads any. */
RT_API void rt_tracer_get_info(const rt_tracer *tracer, rt_tracer_info *info);

/** What is known of the rays of one call. A hint never changes an answer; a wrong one costs time. Without a hint nothing is known; rt_scene_intersect and
 *  rt_scene_occluded, which take none, look at the rays themselves. */
enum {
    RT_RAYS_COHERENT = 1,      /**< neighbours in the array start near each other and run nearly alike: of a camera, or towards one point */
    RT_RAYS_COMMON_ORIGIN = 2, /**< all rays start at exactly the same point; no tracer of today is faster for knowing it */
    RT_RAYS_DEFAULT_FENV = 4   /**< no hint but the caller's word: this thread computes in the floating-point environment that C programs begin in (FE_DFL_ENV:
                                *   to nearest, denormals kept, exceptions masked). A call for one ray then does not look, 3 to 6 ns, at what it would
                                *   otherwise put right for its time. Where the word is not kept, hits may be others, or a trap ends the program */
};

/** Closest hits, as rt_scene_intersect. hints: RT_RAYS_* or 0. Errors none. Threads any number. Owner keeps no pointer; memory as there, but from 16 rays on
 *  without RT_RAYS_COHERENT. A call may be for one ray,
 *  which then costs some 12 ns beside its way through the tree, and 7 with RT_RAYS_DEFAULT_FENV; but rays that come together share that way: a thousand in a call
 *  go 2 to 10 times as fast (examples/many_rays.c measures it). rt_scene_intersect asks for the snapshot at each call, for some 15 ns. */
RT_API void rt_tracer_intersect(const rt_tracer *tracer, const rt_ray *rays, rt_hit *hits, size_t count, uint32_t hints);
/** Any hit, as rt_scene_occluded. */
RT_API void rt_tracer_occluded(const rt_tracer *tracer, const rt_ray *rays, uint8_t *occluded, size_t count, uint32_t hints);

/** Sixteen rays in structure-of-arrays, as tracers take them; meanings as in rt_ray. */
typedef struct rt_ray_block {
    float org_x[16], org_y[16], org_z[16];
    float dir_x[16], dir_y[16], dir_z[16];
    float tmin[16], tmax[16];
    uint32_t mask[16];
} rt_ray_block;
/** Their hits, as in rt_hit. */
typedef struct rt_hit_block {
    float t[16], u[16], v[16];
    uint32_t prim_id[16], geom_id[16], inst_id[16];
} rt_hit_block;

/** The same without a copy. count: rays, in (count + 15) / 16 blocks, ray i in lane i % 16 of block i / 16; lanes behind count are not read as rays, and what
 *  stands in their hits is unspecified. Blocks must be aligned to 64 bytes. occluded: bit i % 16 of word i / 16, (count + 15) / 16 words. */
RT_API void rt_tracer_intersect_blocks(const rt_tracer *tracer, const rt_ray_block *rays, rt_hit_block *hits, size_t count, uint32_t hints);
RT_API void rt_tracer_occluded_blocks(const rt_tracer *tracer, const rt_ray_block *rays, uint16_t *occluded, size_t count, uint32_t hints);

/** A triangle of the committed scene itself (instances have their own). */
typedef struct rt_triangle {
    rt_vec3 v0, v1, v2;
    uint32_t geom_id, prim_id; /**< as in hits */
} rt_triangle;
/** Copies out the triangles first ... first + capacity - 1, in description order, for programs that hand a scene on. Writes at most capacity entries; returns
 *  how many triangles there are in all: 0 also for a scene that was never committed. triangles may be NULL when capacity is 0. Threads any. */
RT_API uint64_t rt_scene_get_triangles(const rt_scene *scene, uint64_t first, rt_triangle *triangles, size_t capacity);

#ifdef __cplusplus
}
#endif
#endif
