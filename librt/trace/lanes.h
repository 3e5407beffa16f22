/* Lanes of a packet: as many as the instruction set that the file is compiled for has in a register; four for others.
 *
 * Vectors are the types that GCC and Clang share, so that + - * / work on them; what differs between instruction sets is how
 * lanes are compared and picked. Masks are combined by & | ~. Every operation rounds as the plain one does: the bits are those of
 * one ray at a time.
 */
#ifndef RTI_LANES_H
#define RTI_LANES_H

#include <string.h>

#include "../kernel/types.h"

#if defined(__AVX512F__) && defined(__AVX512DQ__)
#include <immintrin.h>
#define RTI_LANES 16u
#elif defined(__AVX2__)
#include <immintrin.h>
#define RTI_LANES 8u
#else
#define RTI_LANES 4u
#endif
#define RTI_ALL_LANES ((1u << RTI_LANES) - 1u)

typedef float rti_vf __attribute__((vector_size(4 * RTI_LANES)));
typedef int32_t rti_vi __attribute__((vector_size(4 * RTI_LANES)));

static inline rti_vf rti_vf_all(float x)
{
    return (rti_vf){0} + x;
}

static inline rti_vf rti_vf_load(const float *from)
{
    rti_vf v;
    memcpy(&v, from, sizeof v);
    return v;
}

static inline rti_vi rti_vi_load(const rtk_u32 *from)
{
    rti_vi v;
    memcpy(&v, from, sizeof v);
    return v;
}

#if defined(__AVX512F__) && defined(__AVX512DQ__)
typedef __mmask16 rti_vm;
static inline rti_vm rti_lt(rti_vf a, rti_vf b)
{
    return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_LT_OQ);
}
static inline rti_vm rti_le(rti_vf a, rti_vf b)
{
    return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_LE_OQ);
}
static inline rti_vm rti_eq(rti_vf a, rti_vf b)
{
    return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_EQ_OQ);
}
static inline rti_vm rti_same(rti_vi a, rti_vi b)
{
    return _mm512_cmpeq_epi32_mask((__m512i)a, (__m512i)b);
}
static inline rti_vf rti_pick(rti_vm m, rti_vf yes, rti_vf no)
{
    return (rti_vf)_mm512_mask_mov_ps((__m512)no, m, (__m512)yes);
}
static inline rti_vi rti_pick_int(rti_vm m, rti_vi yes, rti_vi no)
{
    return (rti_vi)_mm512_mask_mov_epi32((__m512i)no, m, (__m512i)yes);
}
static inline uint32_t rti_bits(rti_vm m)
{
    return m;
}
static inline rti_vm rti_mask(uint32_t bits)
{
    return (rti_vm)bits;
}
#else
typedef rti_vi rti_vm;
static inline rti_vm rti_lt(rti_vf a, rti_vf b)
{
    return a < b;
}
static inline rti_vm rti_le(rti_vf a, rti_vf b)
{
    return a <= b;
}
static inline rti_vm rti_eq(rti_vf a, rti_vf b)
{
    return a == b;
}
static inline rti_vm rti_same(rti_vi a, rti_vi b)
{
    return a == b;
}
static inline rti_vi rti_pick_int(rti_vm m, rti_vi yes, rti_vi no)
{
    return (m & yes) | (~m & no);
}
static inline rti_vf rti_pick(rti_vm m, rti_vf yes, rti_vf no)
{
    return (rti_vf)rti_pick_int(m, (rti_vi)yes, (rti_vi)no);
}
static inline uint32_t rti_bits(rti_vm m)
{
#if defined(__AVX2__)
    return (uint32_t)_mm256_movemask_ps((__m256)m);
#else
    return (m[0] & 1u) | (m[1] & 2u) | (m[2] & 4u) | (m[3] & 8u);
#endif
}
static inline rti_vm rti_mask(uint32_t bits)
{
    rti_vi each = {1, 2, 4, 8};
#if defined(__AVX2__)
    each = (rti_vi){1, 2, 4, 8, 16, 32, 64, 128};
#endif
    return (((rti_vi){0} + (int32_t)bits) & each) == each;
}
#endif

static inline rti_vf rti_vf_min(rti_vf a, rti_vf b)
{
    return rti_pick(rti_lt(a, b), a, b);
}

static inline rti_vf rti_vf_max(rti_vf a, rti_vf b)
{
    return rti_pick(rti_lt(b, a), a, b);
}

static inline rti_vf rti_vf_abs(rti_vf x)
{
    return (rti_vf)((rti_vi)x & 0x7fffffff);
}

#endif
