/* The leaf test in vectors, for hot files: rti_tri4, and rti_tri8, rti_tri16 where the processor has them (tri_lanes.inl). */
#ifndef RTI_TRI_LANES_H
#define RTI_TRI_LANES_H

#include "../base/simd.h"
#include "../kernel/triangle.h"

#define LANES_JOIN__(a, n, op) a##n##_##op
#define LANES_JOIN_(a, n, op)  LANES_JOIN__(a, n, op)
#define LANES_JOIN(a, n, op)   LANES_JOIN_(a, n, op)
#define LANES_TYPE__(a, n)     a##n
#define LANES_TYPE_(a, n)      LANES_TYPE__(a, n)
#define LANES_TYPE(a, n)       LANES_TYPE_(a, n)

#define RTI_N 4
#include "tri_lanes.inl"
#undef RTI_N
#if RTI_SIMD >= 8
#define RTI_N 8
#include "tri_lanes.inl"
#undef RTI_N
#endif
#if RTI_SIMD >= 16
#define RTI_N 16
#include "tri_lanes.inl"
#undef RTI_N
#endif

#endif
