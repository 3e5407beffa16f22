/* A committed scene in this process: reference-counted chunks and the view that kernels use. */
#ifndef RTI_SNAPSHOT_H
#define RTI_SNAPSHOT_H

#include "../base/base.h"
#include "../kernel/snapshot.h"
#include "librt/scene.h"

struct rti_tracer;

typedef struct rti_snapshot rti_snapshot;

/* The scene's snapshot with one reference more; NULL when it was never committed. Any thread, beside a commit too. */
rti_snapshot *rti_scene_snapshot(const rt_scene *scene);
void rti_snapshot_retain(rti_snapshot *snapshot);
void rti_snapshot_release(rti_snapshot *snapshot); /* NULL is fine */

const rtk_scene *rti_snapshot_view(const rti_snapshot *snapshot);
/* The tracer that queries use (rt_scene_set_tracer). */
const struct rti_tracer *rti_snapshot_tracer(const rti_snapshot *snapshot);
/* Of all that can change an image, trees left out. */
rti_hash rti_snapshot_hash(const rti_snapshot *snapshot);
uint64_t rti_snapshot_bytes(const rti_snapshot *snapshot);
/* RTK_GROUP_* of a group with these geometries. */
uint32_t rti_group_flags(const rtk_geom *geoms, uint32_t count);
/* Those of RTK_SCENE_MESH and RTK_SCENE_BODIES that a scene has, which tracers ask for. */
uint32_t rti_trace_flags(const rtk_scene *scene);
/* Box of everything finite, world space; lo > hi when there is nothing. */
void rti_snapshot_bounds(const rti_snapshot *snapshot, rtk_vec3 *lo, rtk_vec3 *hi);

/* rt_scene_surface, of this snapshot. */
void rti_snapshot_surface(const rti_snapshot *snapshot, const rt_ray *ray, float time, const rt_hit *hit, rt_surface *out);

/* A snapshot of the same content that has trees of this kind (RTK_TREE_*) for every group and the top level: this one again
 * (retained) when it has them, else one that shares all chunks and builds what is missing (kept by the scene's chunk cache). */
rt_status rti_snapshot_with_tree(rti_snapshot *snapshot, const char *call, uint32_t tree_kind, rti_cancel *cancel,
                                 rti_snapshot **out);

#endif
