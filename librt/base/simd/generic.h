/* Four lanes, any processor: vector types of GCC and Clang, which make of them what the processor has. Included by simd.h. */
#define RTI_SIMD 4
typedef float rti_f4 __attribute__((vector_size(16)));
typedef int32_t rti_m4 __attribute__((vector_size(16)));

RTI_VEC rti_f4 rti_f4_set(float x)
{
    return (rti_f4){x, x, x, x};
}
RTI_VEC rti_f4 rti_f4_load(const float *p)
{
    rti_f4 a;
    memcpy(&a, p, sizeof a);
    return a;
}
RTI_VEC void rti_f4_store(float *p, rti_f4 a)
{
    memcpy(p, &a, sizeof a);
}
RTI_VEC rti_f4 rti_f4_select(rti_m4 m, rti_f4 a, rti_f4 b)
{
    return (rti_f4)(((rti_m4)a & m) | ((rti_m4)b & ~m));
}
RTI_VEC rti_f4 rti_f4_unless(rti_m4 m, rti_f4 a)
{
    return (rti_f4)((rti_m4)a | m);
}
RTI_VEC rti_f4 rti_f4_sqrt(rti_f4 a)
{
    return (rti_f4){__builtin_sqrtf(a[0]), __builtin_sqrtf(a[1]), __builtin_sqrtf(a[2]), __builtin_sqrtf(a[3])};
}
RTI_VEC rti_f4 rti_f4_min(rti_f4 a, rti_f4 b)
{
    return rti_f4_select(a < b, a, b);
}
RTI_VEC rti_f4 rti_f4_max(rti_f4 a, rti_f4 b)
{
    return rti_f4_select(a > b, a, b);
}
RTI_VEC rti_f4 rti_f4_abs(rti_f4 a)
{
    const rti_m4 rest = {0x7fffffff, 0x7fffffff, 0x7fffffff, 0x7fffffff};
    return (rti_f4)((rti_m4)a & rest);
}
RTI_VEC rti_m4 rti_f4_lt(rti_f4 a, rti_f4 b)
{
    return a < b;
}
RTI_VEC rti_m4 rti_f4_le(rti_f4 a, rti_f4 b)
{
    return a <= b;
}
RTI_VEC rti_m4 rti_f4_eq(rti_f4 a, rti_f4 b)
{
    return a == b;
}
RTI_VEC rti_m4 rti_m4_and(rti_m4 a, rti_m4 b)
{
    return a & b;
}
RTI_VEC rti_m4 rti_m4_or(rti_m4 a, rti_m4 b)
{
    return a | b;
}
RTI_VEC rti_m4 rti_m4_andnot(rti_m4 a, rti_m4 b)
{
    return a & ~b;
}
RTI_VEC uint32_t rti_m4_bits(rti_m4 m)
{
    return (uint32_t)((m[0] & 1) | (m[1] & 2) | (m[2] & 4) | (m[3] & 8));
}
RTI_VEC rti_m4 rti_m4_of(uint32_t bits)
{
    const rti_m4 bit = {1, 2, 4, 8};
    const int32_t b = (int32_t)bits;
    return ((rti_m4){b, b, b, b} & bit) == bit;
}
