/* Every walk of a tree as the CPU's tracers instantiate it, one kernel each: the templates must stay in the common subset. */
#include "kd.h"
#include "octree.h"
#include "query.h"

#define RTK_MODE 0u
#define RTK_NAME(x) brute_##x
#define RTK_WALK_INL "brute.inl"
#define RTK_TREE kdtree
#define RTK_TOP_TREE top_kdtree
#include "scene_trace.inl"
#undef RTK_NAME
#undef RTK_WALK_INL

#define RTK_NAME(x) kd_##x
#define RTK_WALK_INL "kd_stack.inl"
#include "scene_trace.inl"
#undef RTK_NAME
#undef RTK_WALK_INL
#undef RTK_TREE
#undef RTK_TOP_TREE

#define RTK_NAME(x) oct_##x
#define RTK_WALK_INL "octree_walk.inl"
#define RTK_TREE octree
#define RTK_TOP_TREE top_octree
#include "scene_trace.inl"

#define WALK(name)                                                                                                               \
    __kernel void walk_##name(__global const rtk_scene *scene, __global const rtk_ray *rays, __global rtk_hit *hits)             \
    {                                                                                                                            \
        uint i = (uint)get_global_id(0);                                                                                         \
        rtk_scene s = *scene;                                                                                                    \
        rtk_query q;                                                                                                             \
        rtk_query_init(&q, &s, rays[i]);                                                                                         \
        name##_trace(&q);                                                                                                        \
        hits[i] = q.best;                                                                                                        \
    }
WALK(brute)
WALK(kd)
WALK(oct)
