/* RTI_N lanes of an x86 processor: what simd.h lists. Included by the file of a level once a width, with
 *   VECTOR          the register's type
 *   MM(op)          the intrinsic `op` of this width
 *   COMPARE(op, a, b)   op: lt, le, eq
 *   SELECT(m, a, b)
 *   MASK_BITS       where a mask is bits, their type; else a mask is a vector, its lanes all ones or zeros
 * and undefined at the end.
 */
#define JOIN_(a, n, op) a##n##op
#define JOIN(a, n, op)  JOIN_(a, n, op)
#define F(op)           JOIN(rti_f, RTI_N, _##op)
#define M(op)           JOIN(rti_m, RTI_N, _##op)
#define VEC             JOIN(rti_f, RTI_N, )
#define MASK            JOIN(rti_m, RTI_N, )

typedef VECTOR VEC;

RTI_VEC VEC F(set)(float x)
{
    return MM(set1_ps)(x);
}
RTI_VEC VEC F(load)(const float *p)
{
    return MM(loadu_ps)(p);
}
RTI_VEC void F(store)(float *p, VEC a)
{
    MM(storeu_ps)(p, a);
}
RTI_VEC VEC F(min)(VEC a, VEC b)
{
    return MM(min_ps)(a, b);
}
RTI_VEC VEC F(max)(VEC a, VEC b)
{
    return MM(max_ps)(a, b);
}
RTI_VEC VEC F(sqrt)(VEC a)
{
    return MM(sqrt_ps)(a);
}
RTI_VEC VEC F(abs)(VEC a)
{
    return MM(andnot_ps)(MM(set1_ps)(-0.0f), a);
}

#ifdef MASK_BITS
typedef MASK_BITS MASK;

RTI_VEC MASK M (and)(MASK a, MASK b)
{
    return (MASK)(a & b);
}
RTI_VEC MASK M(or)(MASK a, MASK b)
{
    return (MASK)(a | b);
}
RTI_VEC MASK M(andnot)(MASK a, MASK b)
{
    return (MASK)(a & ~b);
}
RTI_VEC uint32_t M(bits)(MASK m)
{
    return m;
}
RTI_VEC MASK M(of)(uint32_t bits)
{
    return (MASK)(bits & ((1u << RTI_N) - 1u));
}
RTI_VEC VEC F(unless)(MASK m, VEC a)
{
    return SELECT(m, MM(set1_ps)(__builtin_nanf("")), a);
}
#else
typedef VECTOR MASK;

RTI_VEC MASK M (and)(MASK a, MASK b)
{
    return MM(and_ps)(a, b);
}
RTI_VEC MASK M(or)(MASK a, MASK b)
{
    return MM(or_ps)(a, b);
}
RTI_VEC MASK M(andnot)(MASK a, MASK b)
{
    return MM(andnot_ps)(b, a);
}
RTI_VEC uint32_t M(bits)(MASK m)
{
    return (uint32_t)MM(movemask_ps)(m);
}
RTI_VEC MASK M(of)(uint32_t bits)
{
    static const int32_t of_lane[] = {1, 2, 4, 8, 16, 32, 64, 128};
    int32_t bit __attribute__((vector_size(4 * RTI_N)));
    memcpy(&bit, of_lane, sizeof bit);
    return (MASK)((bit & (int32_t)bits) == bit);
}
RTI_VEC VEC F(unless)(MASK m, VEC a)
{
    return MM(or_ps)(m, a);
}
#endif

RTI_VEC MASK F(lt)(VEC a, VEC b)
{
    return COMPARE(lt, a, b);
}
RTI_VEC MASK F(le)(VEC a, VEC b)
{
    return COMPARE(le, a, b);
}
RTI_VEC MASK F(eq)(VEC a, VEC b)
{
    return COMPARE(eq, a, b);
}
RTI_VEC VEC F(select)(MASK m, VEC a, VEC b)
{
    return SELECT(m, a, b);
}

#undef JOIN_
#undef JOIN
#undef F
#undef M
#undef VEC
#if RTI_N == 8
RTI_VEC rti_f8 rti_f8_two(const float *p, const float *q)
{
    return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(p)), _mm_loadu_ps(q), 1);
}
RTI_VEC rti_f4 rti_f8_low(rti_f8 a)
{
    return _mm256_castps256_ps128(a);
}
RTI_VEC rti_f4 rti_f8_high(rti_f8 a)
{
    return _mm256_extractf128_ps(a, 1);
}
RTI_VEC rti_f8 rti_f8_both(rti_f4 p, rti_f4 q)
{
    return _mm256_insertf128_ps(_mm256_castps128_ps256(p), q, 1);
}
RTI_VEC rti_f8 rti_f8_lows(rti_f8 a, rti_f8 b)
{
    return _mm256_permute2f128_ps(a, b, 0x20);
}
RTI_VEC rti_f8 rti_f8_highs(rti_f8 a, rti_f8 b)
{
    return _mm256_permute2f128_ps(a, b, 0x31);
}
#define PAIR(a, b, how) _mm256_castpd_ps(_mm256_##how##_pd(_mm256_castps_pd(a), _mm256_castps_pd(b)))
RTI_VEC void rti_f8_turn(const rti_f8 a[4], rti_f8 b[4])
{
    const rti_f8 ab0 = _mm256_unpacklo_ps(a[0], a[1]), ab1 = _mm256_unpackhi_ps(a[0], a[1]);
    const rti_f8 cd0 = _mm256_unpacklo_ps(a[2], a[3]), cd1 = _mm256_unpackhi_ps(a[2], a[3]);
    b[0] = PAIR(ab0, cd0, unpacklo);
    b[1] = PAIR(ab0, cd0, unpackhi);
    b[2] = PAIR(ab1, cd1, unpacklo);
    b[3] = PAIR(ab1, cd1, unpackhi);
}
#undef PAIR
#endif
#undef MASK
#undef RTI_N
#undef VECTOR
#undef MM
#undef MASK_BITS
