/* RTI_LANES_INL once for each width RTI_N of vectors that the processor has. */
#define RTI_N 4
#include RTI_LANES_INL
#undef RTI_N
#if RTI_SIMD >= 8
#define RTI_N 8
#include RTI_LANES_INL
#undef RTI_N
#endif
#if RTI_SIMD >= 16
#define RTI_N 16
#include RTI_LANES_INL
#undef RTI_N
#endif
#undef RTI_LANES_INL
