/* Instruction sets. Hot files are compiled once for each (librt_hot_sources in CMake), and a context takes the best that the
 * machine runs, once, when it is made (RT_ISA lowers it): same bits from each, other speed.
 *
 * A hot file sees
 *   RTI_ISA         its level's name as a token: generic, sse42, avx2, avx512, avx512_vbmi2, neon
 *   RTI_ISA_LEVEL   its rti_isa
 *   RTI_ISA_FN(x)   x_avx2, ...: what it exports is named so
 * and base/simd.h gives it vectors. Its floor picks among the copies by rti_context_isa (trace/tracers.c is the pattern).
 */
#ifndef RTI_ISA_H
#define RTI_ISA_H

#include "base.h"

/* Of one kind of processor, the better last. GENERIC is there everywhere. */
typedef enum rti_isa {
    RTI_ISA_GENERIC = 0,
    RTI_ISA_SSE42,
    RTI_ISA_AVX2,
    RTI_ISA_AVX512,       /* F, VL, BW, DQ: of Skylake servers */
    RTI_ISA_AVX512_VBMI2, /* and lanes of sixteen bits side by side: of Ice Lake, Zen 4 */
    RTI_ISA_NEON,
    RTI_ISA_COUNT
} rti_isa;

#define RTI_ISA_JOIN_(x, isa)   x##_##isa
#define RTI_ISA_JOIN(x, isa)    RTI_ISA_JOIN_(x, isa)
#define RTI_ISA_FN(x)           RTI_ISA_JOIN(x, RTI_ISA)
#define RTI_ISA_NAMED_(isa)     RTI_ISA_IS_##isa
#define RTI_ISA_NAMED(isa)      RTI_ISA_NAMED_(isa)
#define RTI_ISA_IS_generic      RTI_ISA_GENERIC
#define RTI_ISA_IS_sse42        RTI_ISA_SSE42
#define RTI_ISA_IS_avx2         RTI_ISA_AVX2
#define RTI_ISA_IS_avx512       RTI_ISA_AVX512
#define RTI_ISA_IS_avx512_vbmi2 RTI_ISA_AVX512_VBMI2
#define RTI_ISA_IS_neon         RTI_ISA_NEON
#define RTI_ISA_LEVEL           RTI_ISA_NAMED(RTI_ISA)

/* The copies that this build holds, for tables: X(name, level), or X(name, level, of). */
#if defined(RTI_HAVE_SSE42)
#define RTI_ISA_X_SSE42(X, of) X(sse42, RTI_ISA_SSE42, of)
#else
#define RTI_ISA_X_SSE42(X, of)
#endif
#if defined(RTI_HAVE_AVX2)
#define RTI_ISA_X_AVX2(X, of) X(avx2, RTI_ISA_AVX2, of)
#else
#define RTI_ISA_X_AVX2(X, of)
#endif
#if defined(RTI_HAVE_AVX512)
#define RTI_ISA_X_AVX512(X, of) X(avx512, RTI_ISA_AVX512, of)
#else
#define RTI_ISA_X_AVX512(X, of)
#endif
#if defined(RTI_HAVE_AVX512_VBMI2)
#define RTI_ISA_X_AVX512_VBMI2(X, of) X(avx512_vbmi2, RTI_ISA_AVX512_VBMI2, of)
#else
#define RTI_ISA_X_AVX512_VBMI2(X, of)
#endif
#if defined(RTI_HAVE_NEON)
#define RTI_ISA_X_NEON(X, of) X(neon, RTI_ISA_NEON, of)
#else
#define RTI_ISA_X_NEON(X, of)
#endif
#define RTI_ISA_EACH_OF(X, of)                                                                                                   \
    X(generic, RTI_ISA_GENERIC, of)                                                                                              \
    RTI_ISA_X_SSE42(X, of) RTI_ISA_X_AVX2(X, of) RTI_ISA_X_AVX512(X, of) RTI_ISA_X_AVX512_VBMI2(X, of) RTI_ISA_X_NEON(X, of)
#define RTI_ISA_PLAIN_(name, level, X) X(name, level)
#define RTI_ISA_EACH(X)                RTI_ISA_EACH_OF(RTI_ISA_PLAIN_, X)

/* Defines `const of *at(rti_isa)`, which picks among the tables of type `of` that a hot file exports by the type's name. */
#define RTI_ISA_TABLES(of, at)                                                                                                   \
    RTI_ISA_EACH_OF(RTI_ISA_TABLE_, of)                                                                                          \
    const of *at(rti_isa isa)                                                                                                    \
    {                                                                                                                            \
        switch (isa) {                                                                                                           \
            RTI_ISA_EACH_OF(RTI_ISA_CASE_, of)                                                                                   \
        default:                                                                                                                 \
            return &of##_generic;                                                                                                \
        }                                                                                                                        \
    }
#define RTI_ISA_TABLE_(name, level, of) extern const of of##_##name;
#define RTI_ISA_CASE_(name, level, of)                                                                                           \
    case level:                                                                                                                  \
        return &of##_##name;

const char *rti_isa_name(rti_isa isa);
bool rti_isa_runs(rti_isa isa); /* this build holds it, and processor and system can do it */
rti_isa rti_isa_best(void);

/* The level that RT_ISA asks for: `wanted`, its value, may be NULL (the best). A name that is none, or is one that does not run
 * here, gives the best too, and in `why` a sentence; else why is empty. */
rti_isa rti_isa_choose(const char *wanted, char *why, size_t size);

/* What the context took. */
rti_isa rti_context_isa(const rt_context *ctx);

#endif
