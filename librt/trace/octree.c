/* The octree, one ray at a time. */
#include "../kernel/octree.h"
#define RTI_TRACER_NAME octree
#define RTK_WALK_INL    "../kernel/octree_walk.inl"
#define RTK_TREE        octree
#define RTK_TOP_TREE    top_octree
#define RTI_MODE_INL    "single.inl"
#include "modes.inl"
