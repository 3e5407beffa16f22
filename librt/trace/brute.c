/* Every primitive for every ray. */
#define RTI_TRACER_NAME brute
#define RTK_WALK_INL    "../kernel/brute.inl"
#define RTK_TREE        kdtree /* passed on and not looked at */
#define RTK_TOP_TREE    top_kdtree
#include "single.inl"
