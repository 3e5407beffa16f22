/* 128-bit content hash: two multiply-rotate lanes over 16-byte blocks, in the manner of MurmurHash3 (Appleby, public domain
 * idea), written anew with its own constants and length folding. Blocks are read as little-endian whatever the machine. */
#include <string.h>

#include "base.h"

#define K1 0x9e3779b97f4a7c15ull
#define K2 0xc2b2ae3d27d4eb4full

static uint64_t rotate(uint64_t x, unsigned n)
{
    return (x << n) | (x >> (64 - n));
}

static uint64_t finish(uint64_t x)
{
    x ^= x >> 32;
    x *= 0xd6e8feb86659fd93ull;
    x ^= x >> 29;
    x *= 0xa0761d6478bd642full;
    return x ^ (x >> 32);
}

static uint64_t load(const uint8_t *p)
{
    uint64_t x = 0;
    for (unsigned i = 0; i < 8; i++)
        x |= (uint64_t)p[i] << (8 * i); /* one load where the machine is little-endian: compilers see it */
    return x;
}

static void block(rti_hasher *h, const uint8_t *p)
{
    uint64_t x = load(p), y = load(p + 8);
    h->a = rotate(h->a ^ rotate(x * K1, 31) * K2, 27) + h->b;
    h->a = h->a * 5 + 0x52dce729u;
    h->b = rotate(h->b ^ rotate(y * K2, 33) * K1, 31) + h->a;
    h->b = h->b * 5 + 0x38495ab5u;
}

void rti_hasher_init(rti_hasher *h)
{
    memset(h, 0, sizeof *h);
    h->a = 0x6c62272e07bb0142ull;
    h->b = 0x62b821756295c58dull;
}

void rti_hasher_add(rti_hasher *h, const void *data, size_t size)
{
    const uint8_t *p = data;
    if (size == 0)
        return;
    h->length += size;
    if (h->tail_count) {
        size_t take = 16 - h->tail_count;
        if (take > size)
            take = size;
        memcpy(h->tail + h->tail_count, p, take);
        h->tail_count += (uint32_t)take;
        p += take;
        size -= take;
        if (h->tail_count < 16)
            return;
        block(h, h->tail);
        h->tail_count = 0;
    }
    for (; size >= 16; p += 16, size -= 16)
        block(h, p);
    if (size) {
        memcpy(h->tail, p, size);
        h->tail_count = (uint32_t)size;
    }
}

rti_hash rti_hasher_end(rti_hasher *h)
{
    rti_hash r;
    memset(h->tail + h->tail_count, 0, 16 - h->tail_count);
    block(h, h->tail);
    h->a ^= h->length;
    h->b ^= h->length * K1;
    h->a += h->b;
    h->b += h->a;
    r.lo = finish(h->a);
    r.hi = finish(h->b);
    r.lo += r.hi;
    r.hi += r.lo;
    return r;
}

rti_hash rti_hash_bytes(const void *data, size_t size)
{
    rti_hasher h;
    rti_hasher_init(&h);
    rti_hasher_add(&h, data, size);
    return rti_hasher_end(&h);
}

const char *rti_hash_text(char buffer[33], rti_hash hash)
{
    for (unsigned i = 0; i < 16; i++) {
        buffer[i] = "0123456789abcdef"[(hash.hi >> (60 - 4 * i)) & 15];
        buffer[16 + i] = "0123456789abcdef"[(hash.lo >> (60 - 4 * i)) & 15];
    }
    buffer[32] = '\0';
    return buffer;
}
