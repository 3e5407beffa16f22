/* Every walk of kernel/ instantiated, for kernels.sh: templates cannot be compiled alone. */
#include "../librt/kernel/bvh.h"
#include "../librt/kernel/kd.h"
#include "../librt/kernel/octree.h"
#include "../librt/kernel/query.h"

#define RTK_MODE 6
#define RTK_TREE kdtree
#define RTK_TOP_TREE top_kdtree
#define RTK_NAME(x) kd_##x
#define RTK_WALK_INL "../kernel/kd_stack.inl"
#include "../librt/kernel/scene_trace.inl"
#undef RTK_NAME
#undef RTK_WALK_INL
#define RTK_NAME(x) brute_##x
#define RTK_WALK_INL "../kernel/brute.inl"
#include "../librt/kernel/scene_trace.inl"
#undef RTK_NAME
#undef RTK_WALK_INL
#undef RTK_TREE
#undef RTK_TOP_TREE
#define RTK_TREE octree
#define RTK_TOP_TREE top_octree
#define RTK_NAME(x) oct_##x
#define RTK_WALK_INL "../kernel/octree_walk.inl"
#include "../librt/kernel/scene_trace.inl"
#undef RTK_NAME
#undef RTK_WALK_INL
#undef RTK_TREE
#undef RTK_TOP_TREE
#define RTK_TREE bvh
#define RTK_TOP_TREE top_bvh
#define RTK_NAME(x) bvh_##x
#define RTK_WALK_INL "../kernel/bvh_walk.inl"
#include "../librt/kernel/scene_trace.inl"
