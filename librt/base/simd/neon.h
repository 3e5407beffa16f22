/* Four lanes, NEON of 64-bit ARM. Included by simd.h. */
#include <arm_neon.h>

#define RTI_SIMD 4
typedef float32x4_t rti_f4;
typedef uint32x4_t rti_m4;

RTI_VEC rti_f4 rti_f4_set(float x)
{
    return vdupq_n_f32(x);
}
RTI_VEC rti_f4 rti_f4_load(const float *p)
{
    return vld1q_f32(p);
}
RTI_VEC void rti_f4_store(float *p, rti_f4 a)
{
    vst1q_f32(p, a);
}
RTI_VEC rti_f4 rti_f4_min(rti_f4 a, rti_f4 b)
{
    return vbslq_f32(vcltq_f32(a, b), a, b); /* vminq gives NaN for NaN */
}
RTI_VEC rti_f4 rti_f4_max(rti_f4 a, rti_f4 b)
{
    return vbslq_f32(vcgtq_f32(a, b), a, b);
}
RTI_VEC rti_f4 rti_f4_sqrt(rti_f4 a)
{
    return vsqrtq_f32(a);
}
RTI_VEC rti_f4 rti_f4_abs(rti_f4 a)
{
    return vabsq_f32(a);
}
RTI_VEC rti_m4 rti_f4_lt(rti_f4 a, rti_f4 b)
{
    return vcltq_f32(a, b);
}
RTI_VEC rti_m4 rti_f4_le(rti_f4 a, rti_f4 b)
{
    return vcleq_f32(a, b);
}
RTI_VEC rti_m4 rti_f4_eq(rti_f4 a, rti_f4 b)
{
    return vceqq_f32(a, b);
}
RTI_VEC rti_f4 rti_f4_select(rti_m4 m, rti_f4 a, rti_f4 b)
{
    return vbslq_f32(m, a, b);
}
RTI_VEC rti_f4 rti_f4_unless(rti_m4 m, rti_f4 a)
{
    return vreinterpretq_f32_u32(vorrq_u32(m, vreinterpretq_u32_f32(a)));
}
RTI_VEC rti_m4 rti_m4_and(rti_m4 a, rti_m4 b)
{
    return vandq_u32(a, b);
}
RTI_VEC rti_m4 rti_m4_or(rti_m4 a, rti_m4 b)
{
    return vorrq_u32(a, b);
}
RTI_VEC rti_m4 rti_m4_andnot(rti_m4 a, rti_m4 b)
{
    return vbicq_u32(a, b);
}
RTI_VEC uint32_t rti_m4_bits(rti_m4 m)
{
    const uint32_t bit[4] = {1, 2, 4, 8};
    return vaddvq_u32(vandq_u32(m, vld1q_u32(bit)));
}
RTI_VEC rti_m4 rti_m4_of(uint32_t bits)
{
    const uint32_t bit[4] = {1, 2, 4, 8};
    return vtstq_u32(vdupq_n_u32(bits), vld1q_u32(bit));
}
