/* A tracer that goes through eight-wide nodes, the whole of it. The including file defines RTI_TRACER_NAME; RTK_TREE, RTK_TOP_TREE,
 * members of part and scene that hold its trees; RTI_STEPS_INL, the walk that counts what a ray costs. */
#include "../kernel/kd.h"
#include "bvh_packet_walk.h"
#include "bvh_moved.h"
#include "bvh_placed.h"
#include "bvh_learn.h"
#include "pencil_walk.h"
#include "bvh_stream_walk.h"
#define RTK_WALK_INL   "../trace/bvh_lanes.inl"
#define RTI_MODE_INL   "single.inl"
#define RTI_PACKET_INL "bvh_packet.inl"
#include "modes.inl"
