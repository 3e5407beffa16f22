/* The octree, its leaves by eights (accel/cell_wide.c). */
#include "../kernel/octree.h"

#define RTI_TRACER_NAME octree
#define RTK_WALK_INL    "../kernel/octree_walk.inl"
#define RTK_TREE        octree
#define RTK_TOP_TREE    top_octree
#define RTI_BY_TREE     by_octree
#include "cells.inl"
