/* The kd-tree, its leaves by eights (accel/kd_wide.c): walked as the BVH. What a ray costs is counted
 * on the tree of two children itself. */
#define RTI_TRACER_NAME kdtree
#define RTK_TREE        kdtree
#define RTK_REPEATS     1 /* leaves repeat triangles */
#define RTK_TOP_TREE    top_kdtree
#define RTI_STEPS_INL   "../kernel/kd_stack.inl"
#include "wide.h"
