/* What rays of a tracer cost, one at a time: three modes of single.inl. Included by modes.inl, which tells what is defined, and by
 * who leaves all others to another tracer. */
#ifndef RTK_NAME
#define JOIN_(a, b, c) a##_##b##_##c
#define JOIN(a, b, c)  JOIN_(a, b, c)
#define RTK_NAME(x)    JOIN(RTI_TRACER_NAME, x, RTK_MODE)
#endif

#define RTK_MODE 4 /* steps */
#include RTI_MODE_INL
#undef RTK_MODE
#define RTK_MODE 5 /* any, steps */
#include RTI_MODE_INL
#undef RTK_MODE
#define RTK_MODE 6 /* after, steps */
#include RTI_MODE_INL
#undef RTK_MODE
