/* The vectors of one instruction set, for test_simd.c. Compiled once a level. */
#include "simd_probe.h"

#include "trace/packet.h"

uint32_t RTI_ISA_FN(simd_compare)(const float a[16], const float b[16], float min[16], float max[16], uint32_t bits[3])
{
    const vec x = V(load)(a), y = V(load)(b);
    V(store)(min, V(min)(x, y));
    V(store)(max, V(max)(x, y));
    bits[0] = VM(bits)(V(lt)(x, y));
    bits[1] = VM(bits)(V(le)(x, y));
    bits[2] = VM(bits)(V(eq)(x, y));
    return RTI_SIMD;
}

int RTI_ISA_FN(simd_packed)(const float a[16], uint32_t bits, const uint32_t numbers[8], const uint32_t at[4], uint32_t from,
                            simd_packed *out)
{
#ifdef RTI_PACK
    const rti_f8 eight = rti_f8_load(a);
    const rti_f16 sixteen = rti_f16_load(a);
    if ((bits & 255u) != 0u)
        out->least = rti_f8_least(bits & 255u, eight);
    rti_f8_sorted(out->sorted, out->lane, bits & 255u, eight);
    rti_f8_pack(out->pack8, bits & 255u, eight);
    rti_u8_pack(out->packed_u8, bits & 255u, numbers);
    rti_f16_put(out->put, bits, sixteen);
    out->low = rti_f16_low(sixteen);
    rti_f16_store(out->row, rti_f16_row(a));
    rti_f16_store(out->each, rti_f16_each(a, at));
    rti_f16_store(out->fours, rti_f16_take(sixteen, rti_i16_fours(bits, from)));
    return 1;
#else
    (void)a;
    (void)bits;
    (void)numbers;
    (void)at;
    (void)from;
    (void)out;
    return 0;
#endif
}
