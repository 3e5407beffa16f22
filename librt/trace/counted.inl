/* What rays of a tracer cost, one at a time: three modes of single.inl. Included by modes.inl, which tells what is defined, and by
 * who leaves all others to another tracer. */
#define RTK_MODE 4 /* steps */
#include RTI_MODE_INL
#undef RTK_MODE
#define RTK_MODE 5 /* any, steps */
#include RTI_MODE_INL
#undef RTK_MODE
#define RTK_MODE 6 /* after, steps */
#include RTI_MODE_INL
#undef RTK_MODE
