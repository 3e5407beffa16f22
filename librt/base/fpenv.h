/* The floating-point environment that the library computes in: round to nearest, denormals kept, exceptions masked. A public call
 * puts its thread into it and the caller's back when it leaves; here, to be inlined: a call for one ray notices what it takes.
 *
 * Compilers know nothing of it and move arithmetic as they like. What both functions hold in place is memory: what is loaded
 * behind rti_fp_enter is computed behind it, and what stands in memory that others see before rti_fp_leave was computed before.
 * Numbers that a function was handed, and results that it keeps in a local variable, are held by RTI_FP_HOLD: of arguments behind
 * the one, of results before the other. (Clang computed half of a plane's axes in the caller's rounding without.)
 */
#ifndef RTI_FPENV_H
#define RTI_FPENV_H

#include <stdint.h>

#if defined(__x86_64__) || defined(__i386__)
#ifndef LIBRT_EMULATED /* SIMDe stands for it there (tests/emulate) */
#include <xmmintrin.h>
#endif
#elif !defined(__aarch64__)
#include <fenv.h>
#endif

typedef struct rti_fpenv {
    uint32_t saved;
} rti_fpenv;

/* What a variable holds is known here and may have changed: nothing that is made of it, or makes it, crosses this. */
#define RTI_FP_HOLD(variable) __asm__ volatile("" : "+m"(variable))
#define RTI_FP_HOLD_MEMORY    __asm__ volatile("" : : : "memory")

#if defined(__x86_64__) || defined(__i386__)
#define RTI_MXCSR      0x1f80u
#define RTI_MXCSR_KEPT 0xffc0u /* the flags below tell what happened */
static inline rti_fpenv rti_fp_enter(void)
{
    rti_fpenv env;
    env.saved = _mm_getcsr();
    if ((env.saved & RTI_MXCSR_KEPT) != RTI_MXCSR)
        _mm_setcsr(RTI_MXCSR);
    RTI_FP_HOLD_MEMORY;
    return env;
}
static inline void rti_fp_leave(rti_fpenv env)
{
    RTI_FP_HOLD_MEMORY;
    if ((env.saved & RTI_MXCSR_KEPT) != RTI_MXCSR)
        _mm_setcsr(env.saved);
}
#elif defined(__aarch64__)
static inline rti_fpenv rti_fp_enter(void)
{
    rti_fpenv env;
    uint64_t now, zero = 0;
    __asm__ volatile("mrs %0, fpcr" : "=r"(now));
    env.saved = (uint32_t)now;
    if (env.saved != 0)
        __asm__ volatile("msr fpcr, %0" : : "r"(zero));
    RTI_FP_HOLD_MEMORY;
    return env;
}
static inline void rti_fp_leave(rti_fpenv env)
{
    uint64_t before = env.saved;
    RTI_FP_HOLD_MEMORY;
    if (env.saved != 0)
        __asm__ volatile("msr fpcr, %0" : : "r"(before));
}
#else
static inline rti_fpenv rti_fp_enter(void)
{
    rti_fpenv env;
    env.saved = (uint32_t)fegetround();
    fesetround(FE_TONEAREST);
    RTI_FP_HOLD_MEMORY;
    return env;
}
static inline void rti_fp_leave(rti_fpenv env)
{
    RTI_FP_HOLD_MEMORY;
    fesetround((int)env.saved);
}
#endif

#endif
