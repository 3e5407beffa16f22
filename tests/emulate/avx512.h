/* AVX-512 on a machine without it, for tests of its kernels (LIBRT_EMULATE_AVX512 in cmake/isa.cmake): SIMDe (Debian:
 * libsimde-dev) in portable C, and what it lacks, lane by lane after Intel's guide to the intrinsics. It stands before everything
 * else in files of those levels, in <immintrin.h>'s place. Slow.
 */
#ifndef EMULATE_AVX512_H
#define EMULATE_AVX512_H

#define SIMDE_NO_NATIVE
#define SIMDE_ENABLE_NATIVE_ALIASES
#pragma GCC system_header /* SIMDe's and these functions are no matter of this library's warnings */
#include <simde/x86/avx512.h>
#include <simde/x86/fma.h>
#include <stdint.h>
#include <string.h>

typedef uint8_t __mmask8;
typedef uint16_t __mmask16;
typedef uint32_t __mmask32;

#define EMULATED __attribute__((always_inline, unused)) static inline

/* Lanes of a vector in memory and back; N of a type. */
#define LANES(type, n, name, from)                                                                                               \
    type name[n];                                                                                                                \
    memcpy(name, &(from), sizeof name)
#define VECTOR(type, name, from)                                                                                                 \
    type name;                                                                                                                   \
    memcpy(&(name), from, sizeof(name))
#define CHOSEN(k, i) ((k) >> (i)&1u)

/* ---- arithmetic ---- */

#define FUSED(name, vector, n)                                                                                                   \
    EMULATED vector name(vector a, vector b, vector c)                                                                           \
    {                                                                                                                            \
        LANES(float, n, x, a);                                                                                                   \
        LANES(float, n, y, b);                                                                                                   \
        LANES(float, n, z, c);                                                                                                   \
        for (int i = 0; i < n; i++)                                                                                              \
            x[i] = __builtin_fmaf(x[i], y[i], z[i]);                                                                             \
        VECTOR(vector, r, x);                                                                                                    \
        return r;                                                                                                                \
    }
FUSED(emulated_fma4, __m128, 4)
FUSED(emulated_fma8, __m256, 8)
FUSED(emulated_fma16, __m512, 16)
#undef FUSED
/* The masks are those of all lanes wherever these are called. */
#undef _mm512_maskz_fmadd_ps
#define _mm_maskz_fmadd_ps(k, a, b, c)    emulated_fma4(a, b, c)
#define _mm256_maskz_fmadd_ps(k, a, b, c) emulated_fma8(a, b, c)
#define _mm256_maskz_fmsub_ps(k, a, b, c) emulated_fma8(a, b, -(c))
#define _mm512_maskz_fmadd_ps(k, a, b, c) emulated_fma16(a, b, c)
#define _mm512_maskz_fmsub_ps(k, a, b, c) emulated_fma16(a, b, -(c))

EMULATED __m512i _mm512_maskz_sllv_epi32(__mmask16 k, __m512i a, __m512i b)
{
    LANES(uint32_t, 16, x, a);
    LANES(uint32_t, 16, y, b);
    for (int i = 0; i < 16; i++)
        x[i] = CHOSEN(k, i) && y[i] < 32 ? x[i] << y[i] : 0;
    VECTOR(__m512i, r, x);
    return r;
}
/* Of b's lanes and a's behind them, sixteen from lane n on. */
EMULATED __m512i _mm512_alignr_epi32(__m512i a, __m512i b, int n)
{
    uint32_t x[32];
    memcpy(x, &b, sizeof b);
    memcpy(x + 16, &a, sizeof a);
    VECTOR(__m512i, r, x + n);
    return r;
}
EMULATED __m256i _mm256_mask_min_epi32(__m256i s, __mmask8 k, __m256i a, __m256i b)
{
    LANES(int32_t, 8, x, a);
    LANES(int32_t, 8, y, b);
    LANES(int32_t, 8, z, s);
    for (int i = 0; i < 8; i++)
        if (CHOSEN(k, i))
            z[i] = x[i] < y[i] ? x[i] : y[i];
    VECTOR(__m256i, r, z);
    return r;
}

EMULATED float _mm512_reduce_min_ps(__m512 a)
{
    LANES(float, 16, x, a);
    for (int i = 1; i < 16; i++)
        x[0] = x[i] < x[0] ? x[i] : x[0];
    return x[0];
}

#undef _mm512_cmpneq_epi32_mask
EMULATED __mmask16 _mm512_cmpneq_epi32_mask(__m512i a, __m512i b)
{
    return (__mmask16)~_mm512_cmpeq_epi32_mask(a, b);
}

EMULATED __mmask16 _mm512_cmplt_epu32_mask(__m512i a, __m512i b)
{
    LANES(uint32_t, 16, x, a);
    LANES(uint32_t, 16, y, b);
    uint32_t m = 0;
    for (int i = 0; i < 16; i++)
        m |= (uint32_t)(x[i] < y[i]) << i;
    return (__mmask16)m;
}

EMULATED __mmask16 _mm_test_epi8_mask(__m128i a, __m128i b)
{
    LANES(uint8_t, 16, x, a);
    LANES(uint8_t, 16, y, b);
    uint32_t m = 0;
    for (int i = 0; i < 16; i++)
        m |= (uint32_t)((x[i] & y[i]) != 0) << i;
    return (__mmask16)m;
}

EMULATED uint32_t _pdep_u32(uint32_t bits, uint32_t to)
{
    uint32_t r = 0, k = 0;
    for (int i = 0; i < 32; i++)
        if (CHOSEN(to, i))
            r |= (bits >> k++ & 1u) << i;
    return r;
}

/* ---- from one type to another ---- */

#define CONVERT(name, to, to_type, from, from_type, in_range, else_value)                                                        \
    EMULATED to name(from a)                                                                                                     \
    {                                                                                                                            \
        LANES(from_type, 16, x, a);                                                                                              \
        to_type y[16];                                                                                                           \
        for (int i = 0; i < 16; i++)                                                                                             \
            y[i] = (in_range) ? (to_type)x[i] : (else_value);                                                                    \
        VECTOR(to, r, y);                                                                                                        \
        return r;                                                                                                                \
    }
CONVERT(_mm512_cvtepi32_epi16, __m256i, uint16_t, __m512i, uint32_t, 1, 0)
CONVERT(_mm512_cvtepu16_epi32, __m512i, uint32_t, __m256i, uint16_t, 1, 0)
CONVERT(_mm512_cvttps_epi32, __m512i, int32_t, __m512, float, x[i] >= -2147483648.0f && x[i] < 2147483648.0f, INT32_MIN)
#undef CONVERT

/* ---- lanes elsewhere ---- */

#define COMPRESS(name, vector, n, mask)                                                                                          \
    EMULATED vector name(mask k, vector a)                                                                                       \
    {                                                                                                                            \
        LANES(uint16_t, n, x, a);                                                                                                \
        uint16_t y[n] = {0};                                                                                                     \
        uint32_t to = 0;                                                                                                         \
        for (int i = 0; i < n; i++)                                                                                              \
            if (CHOSEN(k, i))                                                                                                    \
                y[to++] = x[i];                                                                                                  \
        VECTOR(vector, r, y);                                                                                                    \
        return r;                                                                                                                \
    }
COMPRESS(_mm256_maskz_compress_epi16, __m256i, 16, __mmask16)
COMPRESS(_mm512_maskz_compress_epi16, __m512i, 32, __mmask32)
#undef COMPRESS

/* Of each four lanes those that two bits of c name for each place, or that `of` says. */
#define IN_FOURS(name, vector, type, control, of)                                                                                \
    EMULATED vector name(vector a, control c)                                                                                    \
    {                                                                                                                            \
        LANES(type, 16, x, a);                                                                                                   \
        type y[16];                                                                                                              \
        for (int i = 0; i < 16; i++)                                                                                             \
            y[i] = x[i / 4 * 4 + (int)((of)&3)];                                                                                 \
        VECTOR(vector, r, y);                                                                                                    \
        return r;                                                                                                                \
    }
IN_FOURS(_mm512_permute_ps, __m512, float, int, c >> 2 * (i % 4))
IN_FOURS(_mm512_shuffle_epi32, __m512i, int32_t, int, c >> 2 * (i % 4))
IN_FOURS(_mm512_permutevar_ps, __m512, float, __m512i, ((const int32_t *)&c)[i])
#undef IN_FOURS

EMULATED __m512 emulated_shuffle_f32x4(__m512 a, __m512 b, int c)
{
    LANES(float, 16, x, a);
    LANES(float, 16, y, b);
    float z[16];
    for (int i = 0; i < 4; i++)
        memcpy(z + 4 * i, (i < 2 ? x : y) + 4 * (c >> 2 * i & 3), 4 * sizeof *z);
    VECTOR(__m512, r, z);
    return r;
}
#undef _mm512_shuffle_f32x4
#define _mm512_shuffle_f32x4(a, b, c) emulated_shuffle_f32x4(a, b, c)

EMULATED __m256 _mm512_extractf32x8_ps(__m512 a, int i)
{
    LANES(float, 16, x, a);
    VECTOR(__m256, r, x + 8 * i);
    return r;
}

/* ---- memory ---- */

EMULATED __m512 _mm512_i32gather_ps(__m512i at, const void *p, int scale)
{
    LANES(int32_t, 16, x, at);
    float y[16];
    for (int i = 0; i < 16; i++)
        memcpy(&y[i], (const char *)p + (ptrdiff_t)x[i] * scale, sizeof *y);
    VECTOR(__m512, r, y);
    return r;
}

EMULATED __m512 _mm512_maskz_loadu_ps(__mmask16 k, const void *p)
{
    float x[16] = {0};
    for (int i = 0; i < 16; i++)
        if (CHOSEN(k, i))
            memcpy(&x[i], (const char *)p + sizeof *x * (size_t)i, sizeof *x);
    VECTOR(__m512, r, x);
    return r;
}

#define MASKED_STORE(name, to, vector, n, lanes, mask)                                                                           \
    EMULATED void name(to *p, mask k, vector a)                                                                                  \
    {                                                                                                                            \
        LANES(float, n, x, a);                                                                                                   \
        for (int i = 0; i < lanes; i++)                                                                                          \
            if (CHOSEN(k, i))                                                                                                    \
                memcpy((char *)p + sizeof *x * (size_t)i, &x[i], sizeof *x);                                                     \
    }
MASKED_STORE(_mm512_mask_storeu_ps, void, __m512, 16, 16, __mmask16)
MASKED_STORE(_mm_mask_storeu_ps, void, __m128, 4, 4, __mmask8)
MASKED_STORE(_mm_mask_store_ss, float, __m128, 4, 1, __mmask8)
#undef MASKED_STORE

#undef LANES
#undef VECTOR
#undef CHOSEN
#undef EMULATED

#endif
