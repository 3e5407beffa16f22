/* Vectors against what base/simd.h says of them, at every instruction set that runs here: minima, maxima and comparisons beside
 * NaN, and the functions of packed lanes, which walks through trees trust. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "kernel_random.h"
#include "simd_probe.h"

enum { ROUNDS = 200000 };

static float some_number(rng *g)
{
    switch ((int)(rng_unit(g) * 8.0f)) {
    case 0:
        return INFINITY;
    case 1:
        return 0.0f;
    case 2:
        return 0.25f * (float)(int)(8.0f * rng_unit(g)); /* equal ones */
    case 3:
        return 1e-40f * rng_unit(g);
    default:
        return 100.0f * rng_unit(g);
    }
}

static bool same(float a, float b)
{
    return rtk_bits(a) == rtk_bits(b);
}

static void compare(const char *isa,
                    uint32_t (*probe)(const float a[16], const float b[16], float min[16], float max[16], uint32_t bits[3]))
{
    rng g = {3};
    for (int round = 0; round < ROUNDS; round++) {
        float a[16], b[16], min[16], max[16];
        uint32_t bits[3], n;
        for (int i = 0; i < 16; i++) {
            a[i] = rng_unit(&g) < 0.1f ? NAN : some_number(&g);
            b[i] = rng_unit(&g) < 0.1f ? NAN : rng_unit(&g) < 0.2f ? a[i] : -some_number(&g);
        }
        n = probe(a, b, min, max, bits);
        assert_true(n >= 4 && n <= 16);
        for (uint32_t i = 0; i < n; i++)
            if (!same(min[i], a[i] < b[i] ? a[i] : b[i]) || !same(max[i], a[i] > b[i] ? a[i] : b[i]) ||
                (bits[0] >> i & 1u) != (a[i] < b[i]) || (bits[1] >> i & 1u) != (a[i] <= b[i]) ||
                (bits[2] >> i & 1u) != (a[i] == b[i]))
                fail_msg("%s: %a and %a: min %a, max %a, < %u, <= %u, == %u", isa, a[i], b[i], min[i], max[i], bits[0] >> i & 1u,
                         bits[1] >> i & 1u, bits[2] >> i & 1u);
    }
}

/* Alike in as many bits as sorting looks at. */
static uint32_t key(float a)
{
    return rtk_bits(a > 0.0f ? a : 0.0f) & ~7u;
}

/* As such, of numbers of either sign. */
static int32_t order(float a)
{
    const int32_t bits = (int32_t)rtk_bits(a);
    return (bits < 0 ? bits ^ INT32_MAX : bits) & ~7;
}

static void check_eight(const float a[16], uint32_t bits, const uint32_t numbers[8], const simd_packed *p)
{
    uint32_t n = 0, seen = 0;
    float turned[8]; /* every other sign */
    for (uint32_t i = 0; i < 8; i++) {
        turned[i] = i % 2 ? -a[i] : a[i];
        if (!(bits >> i & 1u))
            continue;
        assert_true(same(p->pack8[n], a[i]));
        assert_int_equal(p->packed_u8[n], numbers[i]);
        n++;
    }
    for (uint32_t i = 0; i < n; i++) {
        const uint32_t lane = p->lane[i];
        assert_true(lane < 8 && (bits >> lane & 1u) && !(seen >> lane & 1u));
        seen |= 1u << lane;
        assert_true(same(p->sorted[i], turned[lane]));
        if (i > 0) /* the greatest first, of equal ones the first lane */
            assert_true(order(turned[p->lane[i - 1]]) > order(turned[lane]) ||
                        (order(turned[p->lane[i - 1]]) == order(turned[lane]) && p->lane[i - 1] < lane));
    }
    seen = 0;
    for (uint32_t i = 0; i < n; i++) { /* by size, and of what are alike in that the first */
        const uint32_t lane = p->queued_v[i];
        assert_true(lane < 8 && (bits >> lane & 1u) && !(seen >> lane & 1u));
        seen |= 1u << lane;
        assert_true(same(p->queued[i], turned[lane]));
        assert_int_equal(p->queued_u[i], numbers[lane]);
        if (i > 0)
            assert_true(key(a[p->queued_v[i - 1]]) > key(a[lane]) ||
                        (key(a[p->queued_v[i - 1]]) == key(a[lane]) && p->queued_v[i - 1] < lane));
    }
    if (n > 0)
        assert_int_equal(p->queued_last, p->queued_v[n - 1]);
    if (n > 0)
        for (uint32_t i = 0; i < 8; i++)
            if (bits >> i & 1u)
                assert_true(order(turned[p->least]) < order(turned[i]) ||
                            (order(turned[p->least]) == order(turned[i]) && p->least <= i));
}

static void check_sixteen(const float a[16], uint32_t bits, const simd_packed *p)
{
    uint32_t n = 0, lanes[16] = {0};
    float low = a[0];
    for (uint32_t i = 0; i < 16; i++) {
        low = a[i] < low ? a[i] : low;
        if (bits >> i & 1u)
            lanes[n++] = i;
    }
    assert_true(p->low == low);
    for (uint32_t i = 0; i < 16; i++)
        assert_true(same(p->put[i], i < n ? a[lanes[i]] : -1.0f)); /* nothing behind them */
}

static void check_fours(const float a[16], uint32_t bits, const uint32_t at[4], const simd_packed *p)
{
    for (uint32_t i = 0; i < 16; i++) {
        const float *four = a + i / 4 * 4;
        float least = four[0];
        for (uint32_t k = 0; k < 8; k++)
            assert_true(same(p->fields[k][i], a[at[i / 4] % 8 + k]));
        for (uint32_t k = 0; k < 3; k++) {
            assert_true(same(p->rows[k][i], a[(at[i / 4] + k) % 3 * 4 + i % 4]));
            least = four[k + 1] < least ? four[k + 1] : least;
        }
        assert_true(p->least4[i] == least);
        if (i < 12)
            assert_true(same(p->twelve[i], a[i]));
        if (i < 9)
            assert_true(same(p->nine[i], a[i]));
        assert_true(p->fourths[i] == (float)(4 * i));
        for (uint32_t z = 0; z < 3 && i < 9; z++)
            assert_true(same(p->three[z][i], a[i / 3 + (z + i % 3 + 1) % 3 * 4]));
        for (uint32_t k = 0; k < 2; k++)
            assert_true(same(p->firsts[k][i], a[((15 - i) % 3 + k) % 3 * 4]));
    }
    for (uint32_t r = 0; r < 4; r++) {
        const uint32_t some = bits >> 4 * r & 15u, k = some ? (uint32_t)__builtin_ctz(some) : 0;
        const float want = some ? a[4 * r + k] : -1.0f;
        for (uint32_t i = 0; i < 3; i++)
            assert_true(same(p->kept[r][i], want));
        assert_true(some ? rtk_bits(p->kept[r][3]) == 1000u + k : same(p->kept[r][3], -1.0f));
        assert_true(same(p->ends[r], some ? -want : -1.0f));
    }
}

static void check_lanes(const float a[16], uint32_t bits, uint32_t at, uint32_t from, const simd_packed *p)
{
    uint32_t left = from;
    for (uint32_t i = 0; i < 16; i++) {
        const uint32_t lane = 16u * from + 5u * i + at;
        assert_true(same(p->mixed[i], bits >> i & 1u ? a[lane % 16u] : -a[i]));
        assert_int_equal(p->same >> i & 1u, lane / 16u == from + 2u);
        assert_int_equal(p->first >> i & 1u, (bits >> i & 1u) && left > 0);
        left -= (bits >> i & 1u) && left > 0;
    }
    assert_int_equal((p->same | p->first) >> 16, 0);
}

static void check_bounds(const float a[16], const simd_packed *p)
{
    for (uint32_t k = 0; k < 16; k++) {
        float low = a[k];
        for (uint32_t i = 0; i < 16; i++)
            low = fminf(low, a[(i + k) % 16] + (float)(i * k));
        assert_true(p->lows[k] == low);
        assert_true(k >= 8 || p->lows8[k] == low);
    }
}

static void check_lists(uint32_t bits, const uint32_t numbers[8], const uint32_t at[4], uint32_t from, const simd_packed *p)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < 8; i++)
        assert_int_equal(p->taken[i], numbers[at[i % 4] % 8]);
    for (uint32_t i = 0; i < 16 && i < from + 4; i++)
        if (numbers[i % 8] >> from % 8 & 1u)
            assert_int_equal(p->dealt[n++], i);
    assert_int_equal(p->dealt_count, n);
    n = 0;
    for (uint32_t i = 0; i < 16; i++)
        if (bits >> i & 1)
            assert_int_equal(p->chosen[n++], i);
    assert_int_equal(p->chosen_count, n);
    n = 0;
    for (uint32_t i = 0; i < 16; i++)
        if (bits >> i & 1)
            assert_int_equal(p->counted[n++], from + i);
    assert_int_equal(p->counted_count, n);
}

static void check_many(uint32_t from, const simd_packed *p)
{
    uint32_t n = 0u;
    for (uint32_t i = 0u; i < 32u; i++)
        if (p->wide >> i & 1u)
            assert_int_equal(p->chosen32[n++], i);
    assert_int_equal(p->chosen32_count, n);
    n = 0u;
    for (uint32_t i = 0u; i < 32u && i < 3u * from; i++)
        if ((p->wide >> i & 1u) && i != 0u) { /* seven times nothing is nothing */
            assert_int_equal(p->some[n], 100u + i);
            assert_int_equal(p->some_bits[n++], 7u * i);
        }
    assert_int_equal(p->some_count, n);
}

/* Halves of eight lanes. */
static void check_halves(const float a[16], const uint32_t at[4], uint32_t lanes, const simd_packed *p)
{
    for (uint32_t i = 0u; i < 8u; i++) {
        const float sign = i < 4u ? 1.0f : -1.0f;
        assert_true(same(p->lows_of[i], sign * a[i % 4u]) && same(p->highs_of[i], sign * a[4u + i % 4u]));
        assert_true(same(p->both[i], a[(i + 4u) % 8u]));
        for (uint32_t k = 0u; k < 4u; k++) {
            const float of = a[i / 4u * 4u + k], four[4] = {of, -of, 2.0f * of, 3.0f * of};
            assert_true(same(p->turned8[k][i], four[i % 4u]));
        }
        assert_true(lanes != 8u || same(p->take[i], a[at[i % 4u] % 8u]));
    }
}

/* How many chosen lanes are before each chosen one; no number in chosen lanes. */
static void check_ranks(const float a[16], uint32_t bits, uint32_t lanes, const simd_packed *p)
{
    for (uint32_t i = 0u; i < lanes; i++) {
        if (bits >> i & 1u)
            assert_int_equal(p->ranks[i], (uint32_t)__builtin_popcount(bits & ((1u << i) - 1u)));
        assert_true(bits >> i & 1u ? p->unless[i] != p->unless[i] : same(p->unless[i], a[i]));
    }
}

/* Chosen lanes dealt to eight rows. */
static void check_places(uint32_t bits, const uint32_t numbers[8], uint32_t lanes, const simd_packed *p)
{
    uint32_t next[8];
    memcpy(next, numbers, sizeof next);
    for (uint32_t i = 0u; i < lanes; i++)
        if (bits >> i & 1u)
            assert_int_equal(p->places[i], next[p->keys[i]]++);
    assert_memory_equal(p->next, next, sizeof next);
}

/* What is in vectors of as many lanes as the level has. */
static void check_records(const float a[16], uint32_t bits, const uint32_t at[4], uint32_t lanes, const simd_packed *p)
{
    for (uint32_t i = 0u; i < lanes; i++) {
        const float next = a[(i + 1u) % 16u]; /* doubled exactly: once rounded or twice is the same */
        const uint32_t last = lanes - 1u - i;
        for (uint32_t k = 0u; k < 8u; k++) {
            assert_true(p->records[k][i] == (float)(8u * last + k));
            assert_true(p->spread[last][k] == (float)(8u * last + k));
        }
        assert_true(p->column[i] == (float)(8u * last));
        assert_int_equal(p->last[i], rtk_umin(i, bits % lanes));
        assert_true(same(p->madd[i], 2.0f * a[i] + next) && same(p->msub[i], 2.0f * a[i] - next));
        for (uint32_t k = 0u; k < 4u; k++)
            assert_true(same(p->fours[last][k], (const float[4]){a[i], -a[i], 2.0f * a[i], 3.0f * a[i]}[k]));
        assert_true(same(p->twos[last][0], a[i]) && same(p->twos[last][1], -a[i]));
        for (uint32_t k = 0u; k < 3u && lanes == 8u; k++)
            assert_true(same(p->corners[k][i], a[(last + k) % 3u]));
        for (uint32_t k = 0u; k < 8u && lanes == 8u; k++)
            assert_true(same(p->fields[k][i], a[at[i / 4u] % 8u + k]));
        assert_true(same(p->row[i], a[i % 4u]) && same(p->each[i], a[at[i / 4u]]));
    }
}

static void check_pairs(uint32_t bits, const uint32_t numbers[8], const simd_packed *p)
{
    uint32_t n = 0u;
    for (uint32_t i = 0u; i < 8u; i++)
        if (bits >> i & 1u) {
            assert_int_equal(p->pairs[n++], numbers[i]);
            assert_int_equal(p->pairs[n++], i + 1u);
        }
}

static void packed(int (*probe)(const float a[16], uint32_t bits, const uint32_t numbers[8], const uint32_t at[4], uint32_t from,
                                simd_packed *out))
{
    rng g = {5};
    for (int round = 0; round < ROUNDS; round++) {
        const uint32_t some = (uint32_t)(rng_unit(&g) * 65536.0f) & 65535u, from = (uint32_t)(rng_unit(&g) * 12.0f);
        const uint32_t bits = round % 16 == 0 ? 65535u : some; /* all, of one key */
        uint32_t numbers[8], at[4];
        simd_packed p = {0};
        float a[16];
        for (int i = 0; i < 16; i++) {
            a[i] = some_number(&g);
            p.put[i] = p.kept[i / 4][i % 4] = p.ends[i % 4] = -1.0f;
            numbers[i % 8] = (uint32_t)(rng_unit(&g) * 1e6f);
            at[i % 4] = (uint32_t)(rng_unit(&g) * 16.0f) & 15u;
            p.keys[i] = (uint32_t)(rng_unit(&g) * (round % 16 == 0 ? 1.0f : 8.0f)) & 7u;
        }
        memcpy(p.next, numbers, sizeof p.next);
        const int lanes = probe(a, bits, numbers, at, from, &p);
        if (lanes == 0)
            return;
        check_eight(a, bits, numbers, &p);
        check_lists(bits, numbers, at, from, &p);
        check_records(a, bits, at, (uint32_t)lanes, &p);
        check_halves(a, at, (uint32_t)lanes, &p);
        check_places(bits, numbers, (uint32_t)lanes, &p);
        check_ranks(a, bits, (uint32_t)lanes, &p);
        if (lanes < 16)
            continue;
        check_sixteen(a, bits, &p);
        check_fours(a, bits, at, &p);
        check_lanes(a, bits, at[0], from, &p);
        check_many(from, &p);
        check_bounds(a, &p);
        check_pairs(bits, numbers, &p);
    }
}

static void test_compare(void **state)
{
    (void)state;
#define LEVEL(name, isa)                                                                                                         \
    if (rti_isa_runs(isa))                                                                                                       \
        compare(#name, simd_compare_##name);
    RTI_ISA_EACH(LEVEL)
#undef LEVEL
}

static void rows4(void (*probe)(const float *const from[16], float to[4][16]))
{
    float numbers[100], to[4][16];
    const float *from[16];
    rng g = {7};
    for (int i = 0; i < 100; i++)
        numbers[i] = (float)i;
    for (int round = 0; round < 1000; round++) {
        for (int i = 0; i < 16; i++)
            from[i] = numbers + (int)(rng_unit(&g) * 96.0f);
        probe(from, to);
        for (int i = 0; i < 64; i++)
            assert_true(to[i / 16][i % 16] == from[i % 16][i / 16]);
    }
}

static void test_rows4(void **state)
{
    (void)state;
#define LEVEL(name, isa)                                                                                                         \
    if (rti_isa_runs(isa))                                                                                                       \
        rows4(simd_rows4_##name);
    RTI_ISA_EACH(LEVEL)
#undef LEVEL
}

/* Words of any bits, of records that end where the array does. */
static void records(void (*nines)(const float *p, float *const to[9]), void (*sixes)(const float *const from[6], float *p))
{
    static uint32_t nine[9 * 16], column[9][16], six[6 * 16 + 1];
    float *to[9];
    const float *from[6];
    for (uint32_t i = 0; i < 9 * 16; i++)
        nine[i] = 0x7f800000u + 0x01000193u * i; /* no numbers among them */
    for (uint32_t k = 0; k < 9; k++)
        to[k] = (float *)(void *)column[8 - k];
    nines((const float *)(const void *)nine, to);
    for (uint32_t i = 0; i < 16; i++)
        for (uint32_t k = 0; k < 9; k++)
            assert_int_equal(column[8 - k][i], nine[9 * i + k]);
    for (uint32_t k = 0; k < 6; k++)
        from[k] = (const float *)(const void *)column[k];
    six[6 * 16] = 17;
    sixes(from, (float *)(void *)six);
    for (uint32_t i = 0; i < 16; i++)
        for (uint32_t k = 0; k < 6; k++)
            assert_int_equal(six[6 * i + k], column[k][i]);
    assert_int_equal(six[6 * 16], 17);
}

static void test_records(void **state)
{
    (void)state;
#define LEVEL(name, isa)                                                                                                         \
    if (rti_isa_runs(isa))                                                                                                       \
        records(simd_nines_##name, simd_sixes_##name);
    RTI_ISA_EACH(LEVEL)
#undef LEVEL
}

/* Rays of a batch in their order, and the last again, as a sheaf has them. */
static void take_rows(void (*take)(const uint32_t ray[16], const uint32_t *blocks, uint32_t *to))
{
    enum { BLOCKS = 12 };
    static uint32_t blocks[BLOCKS][SIMD_ROWS][16];
    rng g = {5};
    for (uint32_t i = 0; i < BLOCKS * SIMD_ROWS * 16; i++)
        blocks[i / (SIMD_ROWS * 16)][i / 16 % SIMD_ROWS][i % 16] = 0x7f800000u + 0x01000193u * i; /* no numbers among them */
    for (int round = 0; round < 2000; round++) {
        const uint32_t gap = 1 + (uint32_t)(rng_unit(&g) * 11.0f), n = 1 + (uint32_t)(rng_unit(&g) * 16.0f);
        uint32_t ray[16], to[SIMD_ROWS][16], at = (uint32_t)(rng_unit(&g) * 15.0f);
        for (uint32_t k = 0; k < 16; k++) {
            ray[k] = at;
            at += k + 1 < n ? 1 + (uint32_t)(rng_unit(&g) * (float)gap) : 0;
        }
        if (at >= BLOCKS * 16)
            continue;
        take(ray, blocks[0][0], to[0]);
        for (uint32_t i = 0; i < SIMD_ROWS * 16; i++)
            assert_int_equal(to[i / 16][i % 16], blocks[ray[i % 16] / 16][i / 16][ray[i % 16] % 16]);
    }
}

/* Every choice of lanes, of words that are numbers and of others. */
static void unlike(uint32_t (*of)(const uint32_t p[16], uint32_t word))
{
    static const uint32_t words[] = {0, 1, 0x80000000u, 0x7fc00000u, 0xffffffffu};
    uint32_t row[17];
    for (uint32_t i = 0; i < sizeof words / sizeof words[0]; i++) {
        for (uint32_t lanes = 0; lanes < 65536; lanes++) {
            for (uint32_t k = 0; k < 16; k++)
                row[1 + k] = lanes >> k & 1u ? words[i] ^ 1u << (lanes + k) % 32 : words[i];
            assert_int_equal(of(row + 1, words[i]), lanes);
        }
    }
}

/* All lanes and places: those before stay, and so does what stands in other rows. */
static void put_rows(uint32_t (*put)(uint32_t lanes, uint32_t count, const uint32_t row[16], uint32_t word, uint32_t *blocks))
{
    uint32_t row[16];
    for (uint32_t k = 0; k < 16; k++)
        row[k] = 0x7f800001u + k;
    for (uint32_t lanes = 0; lanes < 65536; lanes += lanes < 512 ? 1 : 37) {
        for (uint32_t count = 0; count < 16; count++) {
            uint32_t blocks[2][SIMD_ROWS][16], n = count;
            for (uint32_t i = 0; i < 2 * SIMD_ROWS * 16; i++)
                blocks[i / (SIMD_ROWS * 16)][i / 16 % SIMD_ROWS][i % 16] = i;
            assert_int_equal(put(lanes, count, row, 77, blocks[0][0]), count + (uint32_t)__builtin_popcount(lanes));
            for (uint32_t k = 0; k < 16; k++) {
                if (lanes >> k & 1u) {
                    assert_int_equal(blocks[n / 16][0][n % 16], row[k]);
                    assert_int_equal(blocks[n / 16][1][n % 16], 77);
                    n++;
                }
                assert_int_equal(blocks[0][2][k], 32 + k);
                assert_int_equal(blocks[1][2][k], SIMD_ROWS * 16 + 32 + k);
            }
            for (uint32_t k = 0; k < count; k++)
                assert_true(blocks[0][0][k] == k && blocks[0][1][k] == 16 + k);
        }
    }
}

static void test_rows(void **state)
{
    (void)state;
#define LEVEL(name, isa)                                                                                                         \
    if (rti_isa_runs(isa)) {                                                                                                     \
        take_rows(simd_take_rows_##name);                                                                                        \
        unlike(simd_unlike_##name);                                                                                              \
        put_rows(simd_put_rows_##name);                                                                                          \
    }
    RTI_ISA_EACH(LEVEL)
#undef LEVEL
}

static void take4(void (*take)(const float p[4], const int32_t lanes[4], float to[4]))
{
    const float p[4] = {1.0f, 2.0f, 3.0f, 4.0f};
    for (int32_t n = 0; n < 256; n++) {
        const int32_t lanes[4] = {n & 3, n >> 2 & 3, n >> 4 & 3, n >> 6};
        float to[4];
        take(p, lanes, to);
        for (int i = 0; i < 4; i++)
            assert_true(to[i] == p[lanes[i]]);
    }
}

static void test_take4(void **state)
{
    (void)state;
#define LEVEL(name, isa)                                                                                                         \
    if (rti_isa_runs(isa))                                                                                                       \
        take4(simd_take4_##name);
    RTI_ISA_EACH(LEVEL)
#undef LEVEL
}

static void test_packed(void **state)
{
    (void)state;
#define LEVEL(name, isa)                                                                                                         \
    if (rti_isa_runs(isa))                                                                                                       \
        packed(simd_packed_##name);
    RTI_ISA_EACH(LEVEL)
#undef LEVEL
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_compare), cmocka_unit_test(test_rows4),
                                       cmocka_unit_test(test_records), cmocka_unit_test(test_rows),
                                       cmocka_unit_test(test_take4),   cmocka_unit_test(test_packed)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
