/* The widths of vectors that an instruction set has, for the probes: M(4), M(8), M(16) as far as they go. */
#ifndef PROBE_WIDTHS_H
#define PROBE_WIDTHS_H

#include "base/simd.h"

#if RTI_SIMD >= 16
#define PROBE_WIDTHS(M) M(4) M(8) M(16)
#elif RTI_SIMD >= 8
#define PROBE_WIDTHS(M) M(4) M(8)
#else
#define PROBE_WIDTHS(M) M(4)
#endif

#endif
