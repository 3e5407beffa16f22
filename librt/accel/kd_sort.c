/* Bounds of references in order, for the choice of a kd split (kd_split.c). */
#include <string.h>

#include "kd_build.h"

#define DIGITS 3u /* of eleven bits */
#define BITS   11u
#define MANY   1024u /* floats for which counting digits is worth it */

static void merge(float *restrict out, const float *a, uint32_t na, const float *b, uint32_t nb)
{
    uint32_t i = 0, j = 0, k = 0;
    while (i < na && j < nb) {
        if (b[j] < a[i])
            out[k++] = b[j++];
        else
            out[k++] = a[i++];
    }
    memcpy(out + k, a + i, (na - i) * sizeof *out);
    k += na - i;
    memcpy(out + k, b + j, (nb - j) * sizeof *out);
}

/* Merge sort over runs sorted by insertion: O(n log n) whatever the input. */
static void sort_few(float *v, uint32_t n, float *temp)
{
    enum { RUN = 24 };
    for (uint32_t base = 0; base < n; base += RUN) {
        uint32_t end = base + RUN < n ? base + RUN : n;
        for (uint32_t i = base + 1; i < end; i++) {
            float x = v[i];
            uint32_t j = i;
            for (; j > base && v[j - 1] > x; j--)
                v[j] = v[j - 1];
            v[j] = x;
        }
    }
    float *from = v, *to = temp;
    for (uint32_t width = RUN; width < n; width *= 2) {
        for (uint32_t base = 0; base < n; base += 2 * width) {
            uint32_t na = width < n - base ? width : n - base;
            uint32_t nb = width < n - base - na ? width : n - base - na;
            merge(to + base, from + base, na, from + base + na, nb);
        }
        float *swap = from;
        from = to;
        to = swap;
    }
    if (from != v)
        memcpy(v, from, n * sizeof *v);
}

/* What orders floats as they are ordered, but -0 before 0. */
static uint32_t key_of(float x)
{
    const uint32_t bits = rtk_bits(x);
    return bits ^ ((uint32_t)((int32_t)bits >> 31) | 0x80000000u);
}

/* Digit by digit, the last first; digits that all have in common, as bounds of one bin mostly do, take no pass. */
static void sort_many(float *v, uint32_t n, float *temp)
{
    uint32_t counts[DIGITS][1u << BITS];
    float *from = v, *to = temp;
    memset(counts, 0, sizeof counts);
    for (uint32_t i = 0; i < n; i++) {
        const uint32_t key = key_of(v[i]);
        for (uint32_t d = 0; d < DIGITS; d++)
            counts[d][key >> (d * BITS) & ((1u << BITS) - 1u)]++;
    }
    for (uint32_t d = 0; d < DIGITS; d++) {
        uint32_t *count = counts[d], sum = 0;
        if (count[key_of(from[0]) >> (d * BITS) & ((1u << BITS) - 1u)] == n)
            continue;
        for (uint32_t k = 0; k < 1u << BITS; k++) {
            const uint32_t here = count[k];
            count[k] = sum;
            sum += here;
        }
        for (uint32_t i = 0; i < n; i++)
            to[count[key_of(from[i]) >> (d * BITS) & ((1u << BITS) - 1u)]++] = from[i];
        float *swap = from;
        from = to;
        to = swap;
    }
    if (from != v)
        memcpy(v, from, n * sizeof *v);
}

void rti_kd_sort(float *v, uint32_t n, float *temp)
{
    if (n < MANY)
        sort_few(v, n, temp);
    else
        sort_many(v, n, temp);
}
