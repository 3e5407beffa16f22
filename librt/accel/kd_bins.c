/* Bounds of references counted into bins, for the choice of a kd split (kd_split.c). A hot file (base/isa.h): the same counts at
 * each level. */
#include "kd_build.h"

/* References of which every other goes to bins of its own: neighbours fall into one, and would wait for each other. */
#define SETS_ABOVE 128u

/* The bins of a reference's bounds, low ones first; the fourth of each is no axis. */
static inline void bins_of(const rti_kd_bins *n, const rti_ref *ref, int32_t k[8])
{
#if RTI_SIMD >= 8
    typedef int32_t i8 __attribute__((vector_size(32)));
    const rti_f8 base = rti_f8_both(n->base, n->base), scale = rti_f8_both(n->scale, n->scale);
    const rti_f8 box = (rti_f8)((i8)rti_f8_load(ref->lo) & (i8){-1, -1, -1, 0, -1, -1, -1, 0}); /* the others are no numbers */
    const i8 at = __builtin_convertvector(rti_f8_min((box - base) * scale, rti_f8_set(n->last)), i8);
    memcpy(k, &at, sizeof at);
#else
    for (uint32_t i = 0; i < 2; i++) {
        const rti_f4 bound = rti_f4_xyz(rti_f4_load(i == 0 ? ref->lo : ref->hi));
        const rti_i4 at = rti_f4_ints(rti_f4_min((bound - n->base) * n->scale, rti_f4_set(n->last)));
        memcpy(k + 4 * i, &at, sizeof at);
    }
#endif
}

static inline void put(const int32_t k[8], uint32_t (*restrict lo)[4], uint32_t (*restrict hi)[4])
{
    for (uint32_t a = 0; a < 3; a++) {
        lo[k[a]][a]++;
        hi[k[4 + a]][a]++;
    }
}

static void add(rti_kd_bins *bins, const rti_ref *refs, size_t count, size_t stride)
{
    const rti_kd_bins n = {.base = bins->base, .scale = bins->scale, .last = bins->last};
    uint32_t lo[RTI_KD_BINS][4], hi[RTI_KD_BINS][4];
    int32_t k[8], other[8];
    const bool sets = count > SETS_ABOVE;
    if (!sets) {
        for (size_t i = 0; i < count; i++) {
            bins_of(&n, &refs[i * stride], k);
            put(k, bins->lo, bins->hi);
        }
        return;
    }
    memset(lo, 0, bins->count * sizeof *lo);
    memset(hi, 0, bins->count * sizeof *hi);
    for (size_t i = 0; i < count; i += 2) {
        bins_of(&n, &refs[i * stride], k);
        put(k, bins->lo, bins->hi);
        if (i + 1 == count)
            break;
        bins_of(&n, &refs[(i + 1) * stride], other);
        put(other, lo, hi);
    }
    for (uint32_t i = 0; i < bins->count; i++)
        for (uint32_t a = 0; a < 4; a++) {
            bins->lo[i][a] += lo[i][a];
            bins->hi[i][a] += hi[i][a];
        }
}

const rti_kd_bin_kernels RTI_ISA_FN(rti_kd_bin_kernels) = {add};
