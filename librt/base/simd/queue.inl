/* Chosen lanes in the order of their values, eight lanes of an x86 processor (rti_f8_queue in simd.h). Included by the file of a
 * level, with
 *   CHOOSE(fill, bits, a)   the chosen lanes of a side by side, fill's behind them
 *   PERMUTE(a, lanes)       a[lanes[i]] in lane i, the lanes modulo 8
 * and undefined at the end. Keys are bits of the values, and lanes; they go through Batcher's network.
 */

/* The constants stand behind a pointer of which compilers know nothing: they would fetch them before the loop that this is in,
 * for each of its ways, of which few come here. */
typedef struct rti_queue_keys {
    _Alignas(32) uint32_t rest[8];
    uint32_t number[8], fill[8], lane[8], last[8];
} rti_queue_keys;
#define EIGHT(n)                                                                                                                 \
    {                                                                                                                            \
        n, n, n, n, n, n, n, n                                                                                                   \
    }
static const rti_queue_keys rti_queue_of = {
    EIGHT(0x7ffffff8u), {7u, 6u, 5u, 4u, 3u, 2u, 1u, 0u}, EIGHT(0x80000000u), EIGHT(7u), {0u, 2u, 1u, 4u, 3u, 6u, 5u, 7u}};
#undef EIGHT

RTI_VEC __m256i rti_queue_load(const uint32_t *p)
{
    return _mm256_load_si256((const __m256i *)(const void *)p);
}

RTI_VEC size_t rti_f8_queue(float *to, uint32_t *u_to, uint32_t *v_to, uint32_t bits, rti_f8 a, const uint32_t u[8],
                            const uint32_t v[8])
{
    const rti_queue_keys *c = &rti_queue_of;
    __asm__ volatile("" : "+r"(c));
    const __m256i all =
        _mm256_or_si256(_mm256_and_si256(_mm256_castps_si256(a), rti_queue_load(c->rest)), rti_queue_load(c->number));
    const __m256i some = CHOOSE(rti_queue_load(c->fill), bits, all);
    const __m256i of_u = _mm256_loadu_si256((const __m256i *)(const void *)u);
    const __m256i of_v = _mm256_loadu_si256((const __m256i *)(const void *)v);
    __m128i least = _mm256_castsi256_si128(some);
    __m256i lanes;
#define LAYER(N, partner, less)                                                                                                  \
    other = partner;                                                                                                             \
    key = N##_blend_epi32(N##_max_epi32(key, other), N##_min_epi32(key, other), less)
    if (__builtin_popcount(bits) <= 4) {
        __m128i key = least, other;
        LAYER(_mm, _mm_shuffle_epi32(key, 0xb1), 0xa);
        LAYER(_mm, _mm_shuffle_epi32(key, 0x4e), 0xc);
        LAYER(_mm, _mm_shuffle_epi32(key, 0xd8), 0x4);
        lanes = _mm256_castsi128_si256(_mm_andnot_si128(key, _mm256_castsi256_si128(rti_queue_load(c->lane))));
        _mm_storeu_ps(to, _mm256_castps256_ps128(_mm256_castsi256_ps(PERMUTE(_mm256_castps_si256(a), lanes))));
        _mm_storeu_si128((__m128i *)(void *)u_to, _mm256_castsi256_si128(PERMUTE(of_u, lanes)));
        _mm_storeu_si128((__m128i *)(void *)v_to, _mm256_castsi256_si128(PERMUTE(of_v, lanes)));
    } else {
        __m256i key = some, other;
        LAYER(_mm256, _mm256_shuffle_epi32(key, 0xb1), 0xaa);
        LAYER(_mm256, _mm256_shuffle_epi32(key, 0x4e), 0xcc);
        LAYER(_mm256, _mm256_shuffle_epi32(key, 0xd8), 0x44);
        LAYER(_mm256, _mm256_permute4x64_epi64(key, 0x4e), 0xf0);
        LAYER(_mm256, _mm256_permute4x64_epi64(key, 0xd8), 0x30);
        LAYER(_mm256, PERMUTE(key, rti_queue_load(c->last)), 0x54);
        lanes = _mm256_andnot_si256(key, rti_queue_load(c->lane));
        least = _mm_min_epu32(least, _mm256_extracti128_si256(some, 1)); /* what fills up counts as the greatest here */
        _mm256_storeu_si256((__m256i *)(void *)to, PERMUTE(_mm256_castps_si256(a), lanes));
        _mm256_storeu_si256((__m256i *)(void *)u_to, PERMUTE(of_u, lanes));
        _mm256_storeu_si256((__m256i *)(void *)v_to, PERMUTE(of_v, lanes));
    }
#undef LAYER
    least = _mm_min_epu32(least, _mm_shuffle_epi32(least, 0x4e));
    least = _mm_min_epu32(least, _mm_shuffle_epi32(least, 0xb1));
    return ~(uint32_t)_mm_cvtsi128_si32(least) & 7u;
}

#undef CHOOSE
#undef PERMUTE
