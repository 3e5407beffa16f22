/* The eight-wide BVH: boxes of a node and triangles of a leaf in vectors; batches that are marked coherent in pencils and
 * packets, others in streams of an octant. */
#define RTI_TRACER_NAME bvh
#define RTK_TREE        bvh
#define RTK_TOP_TREE    top_bvh
#define RTI_STEPS_INL   "../kernel/bvh_walk.inl"
#include "wide.h"
