/* Vectors by the types that GCC and Clang share: four lanes, and as many as the instruction set that a file is compiled for has.
 * The same bits everywhere. Private to accel/. */
#ifndef RTI_VECTORS_H
#define RTI_VECTORS_H

#include <stdint.h>

#if defined(__AVX512F__)
#define RTI_LANES 16
#elif defined(__AVX2__)
#define RTI_LANES 8
#else
#define RTI_LANES 4
#endif

typedef float rti_v4f __attribute__((vector_size(16)));
typedef int32_t rti_v4i __attribute__((vector_size(16)));
typedef float rti_vf __attribute__((vector_size(4 * RTI_LANES)));
typedef int32_t rti_vi __attribute__((vector_size(4 * RTI_LANES)));

static inline rti_v4f rti_v4f_all(float x)
{
    return (rti_v4f){x, x, x, x};
}

static inline rti_v4i rti_v4i_all(int32_t x)
{
    return (rti_v4i){x, x, x, x};
}

/* 0, 1, 2, ... */
static inline rti_vi rti_vi_steps(void)
{
    rti_vi v;
    for (int i = 0; i < RTI_LANES; i++)
        v[i] = i;
    return v;
}

/* mask: lanes of all ones take `yes`, of zeros `no`. */
static inline rti_v4i rti_v4i_pick(rti_v4i mask, rti_v4i yes, rti_v4i no)
{
    return (mask & yes) | (~mask & no);
}

static inline rti_v4f rti_v4f_pick(rti_v4i mask, rti_v4f yes, rti_v4f no)
{
    return (rti_v4f)rti_v4i_pick(mask, (rti_v4i)yes, (rti_v4i)no);
}

static inline rti_vi rti_vi_pick(rti_vi mask, rti_vi yes, rti_vi no)
{
    return (mask & yes) | (~mask & no);
}

static inline rti_vf rti_vf_pick(rti_vi mask, rti_vf yes, rti_vf no)
{
    return (rti_vf)rti_vi_pick(mask, (rti_vi)yes, (rti_vi)no);
}

#endif
