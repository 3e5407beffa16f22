/* The vectors of one instruction set, for test_simd.c. Compiled once a level. */
#include "simd_probe.h"

#include "render/lanes_rows.h"
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

void RTI_ISA_FN(simd_rows4)(const float *const from[16], float to[4][16])
{
    rti_rows4(from, to);
}

void RTI_ISA_FN(simd_nines)(const float *p, float *const to[9])
{
    rti_nines(p, to);
}

void RTI_ISA_FN(simd_sixes)(const float *const from[6], float *p)
{
    rti_sixes(from, p);
}

uint32_t RTI_ISA_FN(simd_unlike)(const uint32_t p[16], uint32_t word)
{
    return rti_u32_unlike(p, word);
}

void RTI_ISA_FN(simd_take4)(const float p[4], const int32_t lanes[4], float to[4])
{
    rti_f4_store(to, rti_f4_take(p, lanes));
}

void RTI_ISA_FN(simd_take_rows)(const uint32_t ray[16], const uint32_t *blocks, uint32_t *to)
{
    rti_sheaf c;
    memcpy(c.ray, ray, sizeof c.ray);
    rti_find_blocks(&c);
    rti_take_rows(&c, blocks, SIMD_ROWS * RTI_ROW_SIZE, SIMD_ROWS, to);
}

uint32_t RTI_ISA_FN(simd_put_rows)(uint32_t lanes, uint32_t count, const uint32_t row[16], uint32_t word, uint32_t *blocks)
{
    while (lanes != 0) {
        const rti_places places = rti_places_of(count % RTK_BLOCK, &lanes);
        uint32_t *block = blocks + count / RTK_BLOCK * SIMD_ROWS * RTK_BLOCK;
        rti_put_row(block, &places, row);
        rti_put_all(block + RTK_BLOCK, &places, word);
        count += places.count;
    }
    return count;
}

#ifdef RTI_PACK
static void put_many(uint32_t bits, uint32_t from, simd_packed *out)
{
    uint16_t many[64] = {0}, beside[64] = {0}, out32[64];
    out->wide = (bits & 0xffffu) ^ bits << 9 ^ bits << 16;
    for (int i = 0; i < 64; i++)
        many[i] = (uint16_t)i;
    out->chosen32_count = rti_u16_put32(out32, many, out->wide);
    memcpy(out->chosen32, out32, sizeof out->chosen32);
    for (int i = 0; i < 32; i++) {
        many[i] = (uint16_t)(100 + i);
        beside[i] = (uint16_t)(out->wide >> i & 1u ? 7 * i : 0);
    }
    out->some_count = rti_u16_some(out->some, out->some_bits, many, beside, 3u * from);
}
#endif

#ifdef RTI_PACK8
/* What levels of eight and of sixteen lanes both have. */
static void eight(const float a[16], uint32_t bits, const uint32_t numbers[8], const uint32_t at[4], uint32_t from,
                  simd_packed *out)
{
    const rti_f8 all8 = rti_f8_load(a);
    const uint32_t low_at[4] = {at[0] % 8u, at[1] % 8u, at[2] % 8u, at[3] % 8u};
    const uint32_t lanes[8] = {low_at[0], low_at[1], low_at[2], low_at[3], low_at[0], low_at[1], low_at[2], low_at[3]};
    uint16_t count[16];
    uint8_t bytes[16];
    const uint32_t in_order[8] = {0, 1, 2, 3, 4, 5, 6, 7};
    const rti_f8 turns = {1.0f, -1.0f, 1.0f, -1.0f, 1.0f, -1.0f, 1.0f, -1.0f};
    if ((bits & 255u) != 0u)
        out->least = rti_f8_least(bits & 255u, all8 * turns);
    rti_f8_sorted(out->sorted, out->lane, bits & 255u, all8 * turns);
    if ((bits & 255u) != 0u)
        out->queued_last =
            (uint32_t)rti_f8_queue(out->queued, out->queued_u, out->queued_v, bits & 255u, all8 * turns, numbers, in_order);
    rti_f8_pack(out->pack8, bits & 255u, all8);
    rti_u8_pack(out->packed_u8, bits & 255u, numbers);
    rti_u8_take(out->taken, numbers, lanes);
    const rti_f8 four[4] = {all8, -all8, all8 * rti_f8_set(2.0f), all8 * rti_f8_set(3.0f)};
    rti_f8 turned[4];
    rti_f8_store(out->lows_of, rti_f8_lows(four[0], four[1]));
    rti_f8_store(out->highs_of, rti_f8_highs(four[0], four[1]));
    rti_f8_store(out->both, rti_f8_both(rti_f8_high(all8), rti_f8_low(all8)));
    rti_f8_turn(four, turned);
    for (int i = 0; i < 4; i++)
        rti_f8_store(out->turned8[i], turned[i]);
    for (int i = 0; i < 16; i++) {
        count[i] = (uint16_t)i;
        bytes[i] = (uint8_t)numbers[i % 8];
    }
    out->dealt_count = rti_u16_deal(out->dealt, count, rti_b16_load(bytes), from % 8u, from + 4u);
    out->chosen_count = rti_u16_put(out->chosen, count, bits & 0xffffu);
    rti_u16_last(out->last, count, 1u + (bits & 15u) % RTI_SIMD);
    out->counted_count = rti_u16_count(out->counted, from, bits & 0xffffu);
}

/* And what they have in vectors of theirs. */
static void records(const float a[16], uint32_t bits, const uint32_t at[4], simd_packed *out)
{
    (void)at;
    const vec x = V(load)(a);
    float all[16][8], turn[16];
    uint32_t eights[16], fours[16], twos[16];
    uint16_t reverse[16];
    vec fields[8];
    for (uint32_t i = 0; i < RTI_SIMD; i++) {
        reverse[i] = (uint16_t)(RTI_SIMD - 1u - i);
        eights[i] = 8u * reverse[i];
        fours[i] = 4u * reverse[i];
        twos[i] = 2u * reverse[i];
        for (uint32_t k = 0; k < 8; k++)
            all[i][k] = (float)(8u * i + k);
    }
    V(records)(all[0], reverse, fields);
    for (int k = 0; k < 8; k++)
        V(store)(out->records[k], fields[k]);
    V(spread)(fields, out->spread[0], eights);
    V(store)(out->column, V(column)(all[0], 8u, reverse));
    V(fours)(x, -x, x * V(set)(2.0f), x * V(set)(3.0f), out->fours[0], fours);
    V(twos)(x, -x, out->twos[0], twos);
    VI(store)(out->places, VI(places)(VI(load)(out->keys), bits, out->next));
    VI(store)(out->ranks, VI(ranks)(bits & ((1u << RTI_SIMD) - 1u)));
    V(store)(out->unless, V(unless)(VM(of)(bits), V(load)(a)));
    for (uint32_t i = 0; i < 16; i++)
        turn[i] = a[(i + 1) % 16];
    V(store)(out->madd, V(madd)(x, V(set)(2.0f), V(load)(turn)));
    V(store)(out->msub, V(msub)(x, V(set)(2.0f), V(load)(turn)));
#if RTI_SIMD == 8
    const uint32_t low_at[2] = {at[0] % 8u, at[1] % 8u};
    float row_of[8];
    const uint32_t lanes[8] = {low_at[0], low_at[1], at[2] % 8u, at[3] % 8u, low_at[0], low_at[1], at[2] % 8u, at[3] % 8u};
    rti_f8_store(out->take, rti_f8_take(a, lanes));
    rti_f8_store(out->row, rti_f8_row(a));
    rti_f8_store(out->each, rti_f8_each(a, at));
    for (int i = 0; i < 8; i++)
        row_of[i] = (float)(i % 3);
    const vec_rows rows = VI(rows)(row_of, 1u, reverse), next = VI(next)(rows);
    V(store)(out->corners[0], rti_f8_corner(a, rows));
    V(store)(out->corners[1], rti_f8_corner(a, next));
    V(store)(out->corners[2], rti_f8_corner(a, VI(next)(next)));
    rti_f8_fields(a, low_at, fields);
    for (int k = 0; k < 8; k++)
        V(store)(out->fields[k], fields[k]);
#endif
}
#endif

int RTI_ISA_FN(simd_packed)(const float a[16], uint32_t bits, const uint32_t numbers[8], const uint32_t at[4], uint32_t from,
                            simd_packed *out)
{
#ifdef RTI_PACK8
    eight(a, bits, numbers, at, from, out);
    records(a, bits, at, out);
#endif
#ifdef RTI_PACK
    const rti_f16 sixteen = rti_f16_load(a);
    rti_f16_put(out->put, bits, sixteen);
    out->low = rti_f16_low(sixteen);
    rti_f16_store(out->row, rti_f16_row(a));
    rti_f16_store(out->each, rti_f16_each(a, at));
    const uint32_t low_at[4] = {at[0] % 8u, at[1] % 8u, at[2] % 8u, at[3] % 8u}, place[4] = {0u, 4u, 8u, 12u},
                   end[4] = {0u, 1u, 2u, 3u};
    float row_of[16];
    uint32_t one = 0u;
    rti_f16 fields[8];
    rti_f16_fields(a, low_at, fields);
    for (int k = 0; k < 8; k++)
        rti_f16_store(out->fields[k], fields[k]);
    rti_f16_store(out->twelve, rti_f16_twelve(a));
    rti_f16_store(out->nine, rti_f16_nine(a));
    for (int i = 0; i < 16; i++) {
        row_of[i] = (float)(at[i / 4] % 3u);
        one |= (bits >> i & 1u) && !(one >> i / 4 * 4 & 15u) ? 1u << i : 0u;
    }
    const rti_i16 first = rti_i16_row(rti_f16_load(row_of)), second = rti_i16_next(first);
    rti_f16_store(out->rows[0], rti_f16_take(sixteen, first));
    rti_f16_store(out->rows[1], rti_f16_take(sixteen, second));
    rti_f16_store(out->rows[2], rti_f16_take(sixteen, rti_i16_next(second)));
    rti_f16_store(out->least4, rti_f16_least4(sixteen));
    rti_f16_keep4(out->kept[0], out->ends, place, end, one, sixteen, sixteen, sixteen, -sixteen, 1000u);
    uint16_t reverse[16];
    for (int i = 0; i < 16; i++) {
        reverse[i] = (uint16_t)(15 - i);
        row_of[i] = (float)(i % 3);
    }
    const rti_i16 rows = rti_i16_rows(row_of, 1u, reverse);
    float each[64];
    for (int i = 0; i < 64; i++)
        each[i] = (float)i;
    const uint32_t count[8] = {1, 2, 3, 4, 5, 6, 7, 8};
    rti_u8_pairs(out->pairs, bits & 255u, numbers, count);
    rti_f16_store(out->fourths, rti_f16_fourths(each));
    for (uint32_t z = 0; z < 3; z++)
        rti_f16_corners(a, a + 1, a + 2, z, out->three[z]);
    rti_f16_store(out->firsts[0], rti_f16_take(sixteen, rows));
    rti_f16_store(out->firsts[1], rti_f16_take(sixteen, rti_i16_next(rows)));
    put_many(bits, from, out);
    rti_f16 turned[16];
    float turn[16];
    for (int k = 0; k < 16; k++) {
        for (int i = 0; i < 16; i++)
            turn[i] = a[(i + k) % 16] + (float)(i * k);
        turned[k] = rti_f16_load(turn);
    }
    rti_f16_store(out->lows, rti_f16_lows(turned));
    rti_f8_store(out->lows8, rti_f16_lows8(turned));
    uint32_t lanes_of[16];
    for (int i = 0; i < 16; i++)
        lanes_of[i] = 16u * from + 5u * (uint32_t)i + at[0];
    const rti_i16 scattered = rti_i16_load(lanes_of);
    rti_f16_store(out->mixed, rti_f16_mix(-sixteen, bits, sixteen, scattered));
    out->same = rti_i16_same(scattered, 16u, from + 2u);
    out->first = rti_first(bits & 0xffffu, from);
    return 16;
#elif defined RTI_PACK8
    return 8;
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
