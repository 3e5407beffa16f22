/* The kd-tree with a full stack: one ray at a time, coherent batches in packets. */
#include "../kernel/kd.h"
#include "kd_packet.h"
#define RTI_TRACER_NAME kdtree
#define RTK_WALK_INL    "../kernel/kd_stack.inl"
#define RTK_TREE        kdtree
#define RTK_TOP_TREE    top_kdtree
#define RTI_MODE_INL    "single.inl"
#define RTI_PACKET_INL  "kd_packet.inl"
#include "modes.inl"
