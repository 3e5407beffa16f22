/* The kd-tree, its leaves by eights (accel/cell_wide.c). */
#include "../kernel/kd.h"

#define RTI_TRACER_NAME kdtree
#define RTK_WALK_INL    "../kernel/kd_stack.inl"
#define RTK_TREE        kdtree
#define RTK_TOP_TREE    top_kdtree
#define RTI_BY_TREE     by_kdtree
#include "cells.inl"
