/* The eight-wide BVH, one ray at a time, in plain C: what the vector kernels are held against. */
#include "../kernel/bvh.h"
#define RTI_TRACER_NAME bvh
#define RTK_WALK_INL    "../kernel/bvh_walk.inl"
#define RTK_TREE        bvh
#define RTK_TOP_TREE    top_bvh
#define RTI_MODE_INL    "single.inl"
#include "modes.inl"
