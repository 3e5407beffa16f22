/* Which instruction sets this build holds and this machine runs. */
#include "isa.h"

#include <string.h>

static const char *const NAMES[RTI_ISA_COUNT] = {"generic", "sse42", "avx2", "avx512", "avx512_vbmi2", "neon"};

const char *rti_isa_name(rti_isa isa)
{
    return NAMES[isa];
}

#if defined(__x86_64__) || defined(__i386__)
#include <cpuid.h>

/* The state that the system saves for a program (XCR0); 0 when it does not tell. */
static uint32_t saved_state(void)
{
    uint32_t a, b, c, d, low, high;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & bit_OSXSAVE))
        return 0;
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    return low;
}

#ifndef bit_LZCNT
#define bit_LZCNT (1u << 5) /* the name that GCC gives it: Clang has another */
#endif
#ifndef bit_AVX512VBMI2
#define bit_AVX512VBMI2 (1u << 6)
#endif
#define STATE_AVX    0x06u /* SSE and AVX registers */
#define STATE_AVX512 0xe6u /* those, mask registers, upper halves, registers 16-31 */

/* Everything that cmake/isa.cmake lets the compiler use. */
static bool machine_runs(rti_isa isa)
{
    const uint32_t sse = bit_SSE4_2 | bit_POPCNT, avx2 = bit_AVX2 | bit_BMI | bit_BMI2;
    const uint32_t avx512 = avx2 | bit_AVX512F | bit_AVX512VL | bit_AVX512BW | bit_AVX512DQ;
    uint32_t a, b, c, d, one, seven = 0, beside = 0, more = 0;
#ifdef RTI_EMULATED_AVX512 /* by AVX2, for tests (cmake/isa.cmake) */
    isa = isa > RTI_ISA_AVX2 ? RTI_ISA_AVX2 : isa;
#endif
    if (!__get_cpuid(1, &a, &b, &one, &d) || (one & sse) != sse)
        return false;
    if (isa == RTI_ISA_SSE42)
        return true;
    if (__get_cpuid_count(7, 0, &a, &b, &c, &d)) {
        seven = b;
        beside = c;
    }
    if (__get_cpuid(0x80000001u, &a, &b, &c, &d))
        more = c;
    if (!(one & bit_AVX) || !(one & bit_FMA) || !(more & bit_LZCNT))
        return false;
    if (isa == RTI_ISA_AVX2)
        return (seven & avx2) == avx2 && (saved_state() & STATE_AVX) == STATE_AVX;
    if ((seven & avx512) != avx512 || (saved_state() & STATE_AVX512) != STATE_AVX512)
        return false;
    return isa == RTI_ISA_AVX512 || (isa == RTI_ISA_AVX512_VBMI2 && (beside & bit_AVX512VBMI2));
}
#elif defined(__aarch64__)
static bool machine_runs(rti_isa isa)
{
    return isa == RTI_ISA_NEON; /* every 64-bit ARM has it */
}
#else
static bool machine_runs(rti_isa isa)
{
    (void)isa;
    return false;
}
#endif

bool rti_isa_runs(rti_isa isa)
{
    switch (isa) {
#define COMPILED(name, level)                                                                                                    \
    case level:                                                                                                                  \
        return (level) == RTI_ISA_GENERIC || machine_runs(isa);
        RTI_ISA_EACH(COMPILED)
#undef COMPILED
    default:
        return false;
    }
}

rti_isa rti_isa_best(void)
{
    for (int i = RTI_ISA_COUNT - 1; i > 0; i--)
        if (rti_isa_runs((rti_isa)i))
            return (rti_isa)i;
    return RTI_ISA_GENERIC;
}

rti_isa rti_isa_choose(const char *wanted, char *why, size_t size)
{
    char quoted[64], names[64];
    size_t length = 0;
    why[0] = '\0';
    if (!wanted || !wanted[0])
        return rti_isa_best();
    for (int i = 0; i < RTI_ISA_COUNT; i++)
        if (rti_isa_runs((rti_isa)i)) {
            if (strcmp(wanted, NAMES[i]) == 0)
                return (rti_isa)i;
            length += (size_t)snprintf(names + length, sizeof names - length, "%s%s", length ? ", " : "", NAMES[i]);
        }
    snprintf(why, size, "the environment variable RT_ISA is \"%s\"; this build on this processor has %s, and %s is taken",
             rti_quote(quoted, sizeof quoted, wanted, strlen(wanted)), names, NAMES[rti_isa_best()]);
    return rti_isa_best();
}
