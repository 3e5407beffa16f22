/* The eight-wide BVH: boxes of a node and triangles of a leaf in vectors; batches that are marked coherent in packets,
 * others in an order of their own, together as far as they go together, or ray by ray, or several by turns. */
#include "bvh_order.h"
#include "bvh_packet_walk.h"
#include "bvh_weave.h"
#define RTI_TRACER_NAME bvh
#define RTK_WALK_INL    "../trace/bvh_lanes.inl"
#define RTK_TREE        bvh
#define RTK_TOP_TREE    top_bvh
#define RTI_MODE_INL    "single.inl"
#define RTI_PACKET_INL  "bvh_packet.inl"
#define RTI_LONE
#include "modes.inl"
