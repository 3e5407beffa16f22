/* Eight-wide nodes, the BVH's and in views that have them there a kd-tree's or octree's (cells.inl): boxes of a node and
 * triangles of a leaf in vectors; batches that are marked coherent in pencils and packets, others in streams of an octant. */
#include "bvh_packet_walk.h"
#include "bvh_moved.h"
#include "bvh_placed.h"
#include "bvh_learn.h"
#include "pencil_walk.h"
#include "bvh_stream_walk.h"
#define RTI_TRACER_NAME bvh
#define RTK_TREE        bvh
#define RTK_TOP_TREE    top_bvh
#define RTK_WALK_INL    "../trace/bvh_lanes.inl"
#define RTI_MODE_INL    "single.inl"
#define RTI_PACKET_INL  "bvh_packet.inl"
#include "modes.inl"
