/* Unpacking of deflate data. Sources: RFC 1950, RFC 1951. Codes are decoded bit by bit by their lengths' counts, which is slow
 * and small: it serves text of a few kilobytes. Nothing is believed: every read is held against the input, every copy against
 * what was written, the output against its limit. */
#include <string.h>

#include "base.h"

typedef struct stream {
    rt_context *ctx;
    const uint8_t *in;
    size_t in_size, at, limit;
    uint32_t bits, bit_count;
    uint8_t *out;
    size_t size, capacity;
    const char *fault; /* the first one; "" for memory */
} stream;

#define MAX_BITS 15

typedef struct codes {
    uint16_t count[MAX_BITS + 1]; /* codes of each length */
    uint16_t symbol[288];         /* in the order of their codes */
} codes;

static int stop(stream *s, const char *fault)
{
    if (!s->fault)
        s->fault = fault;
    return -1;
}

static int take_bits(stream *s, uint32_t n)
{
    while (s->bit_count < n) {
        if (s->at == s->in_size)
            return stop(s, "the compressed data is cut");
        s->bits |= (uint32_t)s->in[s->at++] << s->bit_count;
        s->bit_count += 8;
    }
    uint32_t value = s->bits & ((1u << n) - 1u);
    s->bits >>= n;
    s->bit_count -= n;
    return (int)value;
}

static bool room(stream *s, size_t more)
{
    size_t wanted = s->size + more, grown = s->capacity;
    if (wanted > s->limit) {
        stop(s, "the compressed data unpacks to more than is allowed");
        return false;
    }
    if (wanted < s->capacity) /* one byte stays for the NUL */
        return true;
    while (grown <= wanted)
        grown = grown ? grown * 2 : 4096;
    uint8_t *moved = rti_realloc(s->ctx, s->out, s->capacity, grown);
    if (!moved) {
        rti_fail_memory(s->ctx, "unpacking", grown);
        stop(s, "");
        return false;
    }
    s->out = moved;
    s->capacity = grown;
    return true;
}

/* false: more codes than fit, or (unless it is a single one) fewer than there must be. */
static bool make_codes(codes *c, const uint8_t *lengths, uint32_t n)
{
    uint16_t first[MAX_BITS + 2] = {0};
    int left = 1;
    memset(c->count, 0, sizeof c->count);
    for (uint32_t i = 0; i < n; i++)
        c->count[lengths[i]]++;
    if (c->count[0] == n)
        return true; /* no codes: right where none is used */
    c->count[0] = 0;
    for (uint32_t i = 1; i <= MAX_BITS; i++) {
        left = 2 * left - c->count[i];
        if (left < 0)
            return false;
        first[i + 1] = (uint16_t)(first[i] + c->count[i]);
    }
    for (uint32_t i = 0; i < n; i++) {
        if (lengths[i])
            c->symbol[first[lengths[i]]++] = (uint16_t)i;
    }
    return left == 0 || (c->count[1] == 1 && first[MAX_BITS + 1] == 1);
}

static int take_symbol(stream *s, const codes *c)
{
    int code = 0, first = 0, index = 0;
    for (uint32_t length = 1; length <= MAX_BITS; length++) {
        int bit = take_bits(s, 1), count = c->count[length];
        if (bit < 0)
            return -1;
        code |= bit;
        if (code - count < first)
            return c->symbol[index + (code - first)];
        index += count;
        first = (first + count) << 1;
        code <<= 1;
    }
    return stop(s, "the compressed data has a code that is not in its table");
}

static bool copy_back(stream *s, uint32_t length, uint32_t distance)
{
    if (distance > s->size) {
        stop(s, "the compressed data points before its beginning");
        return false;
    }
    if (!room(s, length))
        return false;
    for (; length > 0; length--, s->size++)
        s->out[s->size] = s->out[s->size - distance];
    return true;
}

static bool take_block(stream *s, const codes *literals, const codes *distances)
{
    static const uint16_t length_base[29] = {3,  4,  5,  6,  7,  8,  9,  10, 11,  13,  15,  17,  19,  23, 27,
                                             31, 35, 43, 51, 59, 67, 83, 99, 115, 131, 163, 195, 227, 258};
    static const uint16_t distance_base[30] = {1,    2,    3,    4,    5,    7,    9,    13,    17,    25,
                                               33,   49,   65,   97,   129,  193,  257,  385,   513,   769,
                                               1025, 1537, 2049, 3073, 4097, 6145, 8193, 12289, 16385, 24577};
    for (;;) {
        int symbol = take_symbol(s, literals);
        if (symbol < 0 || symbol == 256)
            return symbol == 256;
        if (symbol < 256) {
            if (!room(s, 1))
                return false;
            s->out[s->size++] = (uint8_t)symbol;
            continue;
        }
        uint32_t i = (uint32_t)symbol - 257;
        if (i >= 29) {
            stop(s, "the compressed data has a length that does not exist");
            return false;
        }
        int extra = take_bits(s, i < 8 || i == 28 ? 0 : (i - 4) / 4);
        int d = extra < 0 ? -1 : take_symbol(s, distances);
        if (d < 0)
            return false;
        if (d >= 30) {
            stop(s, "the compressed data has a distance that does not exist");
            return false;
        }
        int far = take_bits(s, d < 4 ? 0 : (uint32_t)(d - 2) / 2);
        if (far < 0 || !copy_back(s, length_base[i] + (uint32_t)extra, distance_base[d] + (uint32_t)far))
            return false;
    }
}

static bool take_stored(stream *s)
{
    s->bits = 0;
    s->bit_count = 0;
    if (s->in_size - s->at < 4) {
        stop(s, "the compressed data is cut");
        return false;
    }
    const uint8_t *p = s->in + s->at;
    uint32_t length = p[0] | (uint32_t)p[1] << 8, inverse = p[2] | (uint32_t)p[3] << 8;
    s->at += 4;
    if (length != (inverse ^ 0xffffu)) {
        stop(s, "the compressed data has a block whose two lengths differ");
        return false;
    }
    if (length > s->in_size - s->at) {
        stop(s, "the compressed data is cut");
        return false;
    }
    if (!room(s, length))
        return false;
    memcpy(s->out + s->size, s->in + s->at, length);
    s->size += length;
    s->at += length;
    return true;
}

static bool take_fixed(stream *s)
{
    codes literals, distances;
    uint8_t lengths[288];
    for (uint32_t i = 0; i < 288; i++)
        lengths[i] = i < 144 ? 8 : i < 256 ? 9 : i < 280 ? 7 : 8;
    make_codes(&literals, lengths, 288);
    memset(lengths, 5, 30);
    make_codes(&distances, lengths, 30); /* two of its 32 codes are never used */
    return take_block(s, &literals, &distances);
}

/* The lengths of literals and distances, themselves packed. */
static bool take_lengths(stream *s, const codes *packed, uint8_t *lengths, uint32_t n)
{
    for (uint32_t i = 0; i < n;) {
        int symbol = take_symbol(s, packed), repeat;
        uint8_t value = 0;
        if (symbol < 0)
            return false;
        if (symbol < 16) {
            lengths[i++] = (uint8_t)symbol;
            continue;
        }
        if (symbol == 16) {
            if (i == 0) {
                stop(s, "the compressed data repeats a length before the first");
                return false;
            }
            value = lengths[i - 1];
        }
        repeat = symbol == 16 ? take_bits(s, 2) : take_bits(s, symbol == 17 ? 3 : 7);
        if (repeat < 0)
            return false;
        repeat += symbol == 18 ? 11 : 3;
        if ((uint32_t)repeat > n - i) {
            stop(s, "the compressed data has too many lengths");
            return false;
        }
        memset(lengths + i, value, (size_t)repeat);
        i += (uint32_t)repeat;
    }
    return true;
}

static bool take_dynamic(stream *s)
{
    static const uint8_t order[19] = {16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15};
    codes literals, distances;
    uint8_t lengths[288 + 32] = {0};
    int literal_count = take_bits(s, 5), distance_count = take_bits(s, 5), packed_count = take_bits(s, 4);
    if (s->fault)
        return false;
    for (int i = 0; i < packed_count + 4; i++) {
        int n = take_bits(s, 3);
        if (n < 0)
            return false;
        lengths[order[i]] = (uint8_t)n;
    }
    if (!make_codes(&literals, lengths, 19)) {
        stop(s, "the compressed data has a table that is no code");
        return false;
    }
    uint32_t a = (uint32_t)literal_count + 257, b = (uint32_t)distance_count + 1;
    codes packed = literals;
    memset(lengths, 0, sizeof lengths);
    if (a > 286 || b > 30) {
        stop(s, "the compressed data has too many lengths");
        return false;
    }
    if (!take_lengths(s, &packed, lengths, a + b))
        return false;
    if (lengths[256] == 0 || !make_codes(&literals, lengths, a) || !make_codes(&distances, lengths + a, b)) {
        stop(s, "the compressed data has a table that is no code");
        return false;
    }
    return take_block(s, &literals, &distances);
}

static void check_sum(stream *s)
{
    uint32_t a = 1, b = 0;
    const uint8_t *p = s->in + s->at;
    if (s->in_size - s->at < 4) {
        stop(s, "the compressed data is cut");
        return;
    }
    for (size_t i = 0; i < s->size; i++) {
        a = (a + s->out[i]) % 65521;
        b = (b + a) % 65521;
    }
    if ((b << 16 | a) != ((uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3]))
        stop(s, "the checksum of the compressed data is wrong");
}

const char *rti_inflate(rt_context *ctx, const uint8_t *in, size_t in_size, size_t limit, uint8_t **out, size_t *size,
                        size_t *capacity)
{
    stream s = {.ctx = ctx, .in = in, .in_size = in_size, .limit = limit};
    int last = 0;
    *out = NULL;
    if (in_size < 2 || (in[0] & 15) != 8 || in[0] >> 4 > 7 || (in[0] * 256 + in[1]) % 31 != 0 || in[1] & 32)
        return "the compressed data has no zlib head";
    s.at = 2;
    room(&s, 0);
    while (!s.fault && !last) {
        last = take_bits(&s, 1);
        int kind = take_bits(&s, 2);
        if (kind == 0)
            take_stored(&s);
        else if (kind == 1)
            take_fixed(&s);
        else if (kind == 2)
            take_dynamic(&s);
        else
            stop(&s, "the compressed data has a block of unknown kind");
    }
    if (!s.fault)
        check_sum(&s);
    if (s.fault) {
        rti_free(ctx, s.out, s.capacity);
        return s.fault;
    }
    s.out[s.size] = 0;
    *out = s.out;
    *size = s.size;
    *capacity = s.capacity;
    return NULL;
}
