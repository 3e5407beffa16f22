/* The floating-point environment that the library computes in: round to nearest, denormals kept, exceptions masked. A public call
 * puts its thread into it and the caller's back when it leaves; here, to be inlined: a call for one ray notices what it takes. */
#ifndef RTI_FPENV_H
#define RTI_FPENV_H

#include <stdint.h>

#if defined(__x86_64__) || defined(__i386__)
#include <xmmintrin.h>
#elif !defined(__aarch64__)
#include <fenv.h>
#endif

typedef struct rti_fpenv {
    uint32_t saved;
} rti_fpenv;

#if defined(__x86_64__) || defined(__i386__)
#define RTI_MXCSR      0x1f80u
#define RTI_MXCSR_KEPT 0xffc0u /* the flags below tell what happened */
static inline rti_fpenv rti_fp_enter(void)
{
    rti_fpenv env;
    env.saved = _mm_getcsr();
    if ((env.saved & RTI_MXCSR_KEPT) != RTI_MXCSR)
        _mm_setcsr(RTI_MXCSR);
    return env;
}
static inline void rti_fp_leave(rti_fpenv env)
{
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
    return env;
}
static inline void rti_fp_leave(rti_fpenv env)
{
    uint64_t before = env.saved;
    if (env.saved != 0)
        __asm__ volatile("msr fpcr, %0" : : "r"(before));
}
#else
static inline rti_fpenv rti_fp_enter(void)
{
    rti_fpenv env;
    env.saved = (uint32_t)fegetround();
    fesetround(FE_TONEAREST);
    return env;
}
static inline void rti_fp_leave(rti_fpenv env)
{
    fesetround((int)env.saved);
}
#endif

#endif
