/* PNG without libpng: everything the other writer does, row by row, with a plain compressor (fixed Huffman codes; rows filtered
 * by "up" or "sub", matches at the distance of one byte only). Files are two to four times as large. Sources: PNG specification;
 * RFC 1950, 1951. */
#include "save_formats.h"

#include <string.h>

typedef struct plain_state {
    uint64_t bits; /* not yet a byte */
    uint32_t bit_count;
    uint32_t adler_a, adler_b;
    size_t row_size, size;
    uint8_t *previous, *line; /* the row before; the filter's byte and the filtered row */
    size_t used;
    uint8_t chunk[65536 + 64]; /* of IDAT data, with room for one code */
} plain_state;

static uint32_t crc_more(uint32_t crc, const uint8_t *p, size_t size)
{
    for (size_t i = 0; i < size; i++) {
        crc ^= p[i];
        for (int k = 0; k < 8; k++)
            crc = crc >> 1 ^ (0xedb88320u & (~(crc & 1) + 1));
    }
    return crc;
}

static rt_status put_chunk(rti_saver *s, const char *type, const void *a, size_t a_size, const void *b, size_t b_size)
{
    uint8_t head[8], tail[4];
    rti_put_be32(head, (uint32_t)(a_size + b_size));
    memcpy(head + 4, type, 4);
    uint32_t crc = crc_more(~0u, head + 4, 4);
    crc = crc_more(crc, a, a_size);
    crc = crc_more(crc, b, b_size);
    rti_put_be32(tail, ~crc);
    rti_writer_write(s->out, head, 8);
    rti_writer_write(s->out, a, a_size);
    rti_writer_write(s->out, b, b_size);
    return rti_writer_write(s->out, tail, 4);
}

static rt_status put_texts(rti_saver *s)
{
    rt_status status = RT_OK;
    for (size_t i = 0; i < s->text_count && !status; i++) {
        uint8_t head[79 + 5];
        size_t key = strlen(s->texts[i].key), value = strlen(s->texts[i].value);
        if (key < 1 || key > 79 || value > 0x7fffff00u)
            continue;
        memcpy(head, s->texts[i].key, key);
        memset(head + key, 0, 5); /* iTXt: end of key, not compressed, no language, no translation */
        status = put_chunk(s, "iTXt", head, key + 5, s->texts[i].value, value);
    }
    return status;
}

static rt_status flush_chunk(rti_saver *s)
{
    plain_state *p = s->state;
    rt_status status = p->used ? put_chunk(s, "IDAT", p->chunk, p->used, NULL, 0) : RT_OK;
    p->used = 0;
    return status;
}

static void put_bits(plain_state *p, uint32_t value, uint32_t count)
{
    p->bits |= (uint64_t)value << p->bit_count;
    for (p->bit_count += count; p->bit_count >= 8; p->bit_count -= 8, p->bits >>= 8)
        p->chunk[p->used++] = (uint8_t)p->bits;
}

/* A Huffman code goes in with its first bit lowest. */
static void put_code(plain_state *p, uint32_t code, uint32_t count)
{
    uint32_t mirrored = 0;
    for (uint32_t i = 0; i < count; i++)
        mirrored |= (code >> i & 1) << (count - 1 - i);
    put_bits(p, mirrored, count);
}

static void put_literal(plain_state *p, uint32_t symbol)
{
    if (symbol < 144)
        put_code(p, 0x30 + symbol, 8);
    else if (symbol < 256)
        put_code(p, 0x190 + symbol - 144, 9);
    else if (symbol < 280)
        put_code(p, symbol - 256, 7);
    else
        put_code(p, 0xc0 + symbol - 280, 8);
}

/* The byte before, again, `length` times: 3 ... 258. */
static void put_run(plain_state *p, uint32_t length)
{
    static const uint16_t base[29] = {3,  4,  5,  6,  7,  8,  9,  10, 11,  13,  15,  17,  19,  23, 27,
                                      31, 35, 43, 51, 59, 67, 83, 99, 115, 131, 163, 195, 227, 258};
    uint32_t i = 28;
    while (base[i] > length)
        i--;
    put_literal(p, 257 + i);
    uint32_t extra = i < 8 || i == 28 ? 0 : (i - 4) / 4;
    put_bits(p, length - base[i], extra);
    put_code(p, 0, 5); /* distance 1 */
}

static rt_status compress(rti_saver *s, const uint8_t *data, size_t size)
{
    plain_state *p = s->state;
    for (size_t i = 0; i < size; i++) {
        p->adler_a = (p->adler_a + data[i]) % 65521;
        p->adler_b = (p->adler_b + p->adler_a) % 65521;
    }
    for (size_t i = 0; i < size;) {
        uint32_t run = 0;
        while (i > 0 && run < 258 && i + run < size && data[i + run] == data[i - 1])
            run++;
        if (run >= 3) {
            put_run(p, run);
            i += run;
        } else {
            put_literal(p, data[i++]);
        }
        rt_status status = p->used >= 65536 ? flush_chunk(s) : RT_OK;
        if (status)
            return status;
    }
    return RT_OK;
}

static rt_status plain_begin(rti_saver *s)
{
    static const uint8_t signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'}, intent = 0;
    uint8_t head[13] = {0};
    size_t row = (size_t)s->width * s->channels * (s->bits / 8), size = sizeof(plain_state) + 2 * row + 1;
    plain_state *p = rti_alloc_zero(s->ctx, size);
    s->state = p;
    if (!p)
        return rti_fail_memory(s->ctx, s->name, size);
    p->size = size;
    p->row_size = row;
    p->previous = (uint8_t *)(p + 1);
    p->line = p->previous + row;
    p->adler_a = 1;
    rti_put_be32(head, s->width);
    rti_put_be32(head + 4, s->height);
    head[8] = (uint8_t)s->bits;
    head[9] = s->channels == 4 ? 6 : 2;
    rti_writer_write(s->out, signature, sizeof signature);
    put_chunk(s, "IHDR", head, sizeof head, NULL, 0);
    rt_status status = put_chunk(s, "sRGB", &intent, 1, NULL, 0);
    if (!status)
        status = put_texts(s);
    put_bits(p, 0x0178, 16); /* zlib's head */
    put_bits(p, 3, 3);       /* one last block of fixed codes */
    return status;
}

static uint64_t weight(const uint8_t *line, size_t size)
{
    uint64_t sum = 0;
    for (size_t i = 0; i < size; i++)
        sum += line[i] < 128 ? line[i] : 256u - line[i];
    return sum;
}

static rt_status plain_row(rti_saver *s, const void *samples)
{
    plain_state *p = s->state;
    const uint8_t *row = samples;
    uint8_t *line = p->line + 1;
    size_t step = s->channels * (s->bits / 8);
    uint64_t up_weight;
    if (s->bits == 16) { /* the file's order is high byte first; the row is ours to change back to front */
        for (size_t i = 0; i < p->row_size; i += 2) {
            uint16_t v;
            memcpy(&v, row + i, 2);
            line[i] = (uint8_t)(v >> 8);
            line[i + 1] = (uint8_t)v;
        }
    } else {
        memcpy(line, row, p->row_size);
    }
    for (size_t i = 0; i < p->row_size; i++) { /* previous becomes the row, line the difference to the one above */
        uint8_t now = line[i];
        line[i] = (uint8_t)(now - p->previous[i]);
        p->previous[i] = now;
    }
    up_weight = weight(line, p->row_size);
    p->line[0] = 2;
    uint64_t sub_weight = 0;
    for (size_t i = 0; i < p->row_size; i++) {
        uint8_t d = (uint8_t)(p->previous[i] - (i >= step ? p->previous[i - step] : 0));
        sub_weight += d < 128 ? d : 256u - d;
    }
    if (sub_weight < up_weight) {
        p->line[0] = 1;
        for (size_t i = 0; i < p->row_size; i++)
            line[i] = (uint8_t)(p->previous[i] - (i >= step ? p->previous[i - step] : 0));
    }
    return compress(s, p->line, p->row_size + 1);
}

static rt_status plain_end(rti_saver *s)
{
    plain_state *p = s->state;
    uint8_t adler[4];
    put_literal(p, 256);
    put_bits(p, 0, (8 - p->bit_count) & 7);
    rti_put_be32(adler, p->adler_b << 16 | p->adler_a);
    memcpy(p->chunk + p->used, adler, 4);
    p->used += 4;
    rt_status status = flush_chunk(s);
    return status ? status : put_chunk(s, "IEND", NULL, 0, NULL, 0);
}

static void plain_dispose(rti_saver *s)
{
    if (s->state)
        rti_free(s->ctx, s->state, ((plain_state *)s->state)->size);
}

const rti_save_format rti_save_png_plain = {"png", 1048576, true, true, false, plain_begin, plain_row, plain_end, plain_dispose};
