/* What the builders want of four floats beside base/simd.h: whole numbers, choices, and the first three lanes as x, y, z. The
 * same bits everywhere. Private to accel/. */
#ifndef RTI_VECTORS_H
#define RTI_VECTORS_H

#include "../base/simd.h"

/* Also what < > == of vectors give: all ones or zeros in a lane. */
typedef int32_t rti_i4 __attribute__((vector_size(16)));

RTI_VEC rti_i4 rti_i4_set(int32_t x)
{
    return (rti_i4){x, x, x, x};
}

/* mask: lanes of all ones take `yes`, of zeros `no`. */
RTI_VEC rti_i4 rti_i4_pick(rti_i4 mask, rti_i4 yes, rti_i4 no)
{
    return (mask & yes) | (~mask & no);
}

RTI_VEC rti_f4 rti_f4_pick(rti_i4 mask, rti_f4 yes, rti_f4 no)
{
    return (rti_f4)rti_i4_pick(mask, (rti_i4)yes, (rti_i4)no);
}

/* Cut off behind the point; values must be in the range of int32_t. */
RTI_VEC rti_i4 rti_f4_ints(rti_f4 a)
{
    return __builtin_convertvector(a, rti_i4);
}

RTI_VEC rti_f4 rti_i4_floats(rti_i4 a)
{
    return __builtin_convertvector(a, rti_f4);
}

/* The first three; the fourth is 0. */
RTI_VEC rti_f4 rti_f4_xyz(rti_f4 a)
{
    return (rti_f4)((rti_i4)a & (rti_i4){-1, -1, -1, 0});
}

/* a <= b in each of the first three */
RTI_VEC bool rti_f4_below(rti_f4 a, rti_f4 b)
{
    return (rti_m4_bits(rti_f4_le(a, b)) & 7u) == 7u;
}

/* x y + y z + z x */
RTI_VEC float rti_f4_area(rti_f4 a)
{
    rti_f4 p = a * (rti_f4){a[1], a[2], a[0], a[3]};
    return (p[0] + p[1]) + p[2];
}

#endif
