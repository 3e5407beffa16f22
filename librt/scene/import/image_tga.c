/* TGA: palette, true colour and grey, raw or run-length; 8 ... 32 bits; any of the four origins. */
#include "image_formats.h"

#include <string.h>

typedef struct tga_head {
    uint32_t type; /* 1 palette, 2 true colour, 3 grey */
    bool packed;
    uint32_t palette_first, palette_count, palette_bits;
    uint32_t width, height, bits, flags;
    size_t palette_at, data_at;
    uint32_t channels;
} tga_head;

/* Channels of a pixel of so many bits, 0: not known. 15 and 16 bits hold 5 a colour; their top bit is no alpha in most files. */
static uint32_t channels_of(uint32_t bits, bool grey)
{
    if (grey)
        return bits == 8 ? 1 : bits == 16 ? 4 : 0;
    return bits == 15 || bits == 16 || bits == 24 ? 3 : bits == 32 ? 4 : 0;
}

static bool read_head(const rti_image_source *src, tga_head *h)
{
    const uint8_t *p = src->bytes;
    if (src->size < 18)
        return false;
    memset(h, 0, sizeof *h);
    h->type = p[2] & 7;
    h->packed = p[2] & 8;
    h->palette_first = rti_le16(p + 3);
    h->palette_count = rti_le16(p + 5);
    h->palette_bits = p[7];
    h->width = rti_le16(p + 12);
    h->height = rti_le16(p + 14);
    h->bits = p[16];
    h->flags = p[17];
    h->palette_at = 18u + p[0];
    h->data_at = h->palette_at + (p[1] ? (size_t)h->palette_count * ((h->palette_bits + 7) / 8) : 0);
    if (p[1] > 1 || (p[2] & ~11u) || h->type < 1 || h->type > 3 || (h->flags & 0xc0))
        return false;
    if (h->type == 1)
        h->channels = p[1] && (h->bits == 8 || h->bits == 16) ? channels_of(h->palette_bits, false) : 0;
    else
        h->channels = channels_of(h->bits, h->type == 3);
    return h->channels != 0;
}

bool rti_tga_plausible(const rti_image_source *src)
{
    tga_head h;
    return read_head(src, &h);
}

static void colour(const uint8_t *p, uint32_t bits, bool grey, uint8_t *to)
{
    if (grey) {
        to[0] = p[0];
        if (bits == 16)
            to[1] = to[2] = p[0], to[3] = p[1];
    } else if (bits <= 16) {
        uint32_t v = rti_le16(p);
        for (int c = 0; c < 3; c++) {
            uint32_t five = v >> (10 - 5 * c) & 31;
            to[c] = (uint8_t)(five << 3 | five >> 2);
        }
    } else {
        to[0] = p[2], to[1] = p[1], to[2] = p[0];
        if (bits == 32)
            to[3] = p[3];
    }
}

static void pixel(const rti_image_source *src, const tga_head *h, const uint8_t *p, uint8_t *to)
{
    if (h->type != 1) {
        colour(p, h->bits, h->type == 3, to);
        return;
    }
    uint32_t i = h->bits == 8 ? p[0] : rti_le16(p);
    i = i >= h->palette_first ? i - h->palette_first : h->palette_count;
    if (i < h->palette_count) /* others stay black */
        colour(src->bytes + h->palette_at + (size_t)i * ((h->palette_bits + 7) / 8), h->palette_bits, false, to);
}

/* Where the n-th pixel of the file goes: bit 5 of the flags is set when rows come from the top, bit 4 when they run leftwards. */
static uint8_t *place(const tga_head *h, const rti_pixels *out, size_t n)
{
    size_t x = n % h->width, y = n / h->width;
    if (h->flags & 16)
        x = h->width - 1 - x;
    if (!(h->flags & 32))
        y = h->height - 1 - y;
    return (uint8_t *)out->data + (y * h->width + x) * out->channels;
}

/* Walks the packets; out NULL only measures. Returns the bytes used, or more than there are when the file ends early. */
static size_t unpack(const rti_image_source *src, const tga_head *h, const rti_pixels *out)
{
    size_t at = h->data_at, step = (h->bits + 7) / 8, count = (size_t)h->width * h->height;
    for (size_t n = 0; n < count;) {
        if (at >= src->size)
            return at + 1 + step;
        size_t run = 1u + (src->bytes[at] & 127);
        bool repeat = src->bytes[at++] & 128;
        size_t bytes = repeat ? step : step * run;
        if (at > src->size || src->size - at < bytes)
            return at + bytes;
        for (size_t i = 0; out && i < run && n + i < count; i++)
            pixel(src, h, src->bytes + at + (repeat ? 0 : step * i), place(h, out, n + i));
        at += bytes;
        n += run;
    }
    return at;
}

rt_status rti_tga_decode(const rti_image_source *src, rti_pixels *out)
{
    tga_head h;
    if (!read_head(src, &h))
        return rti_image_broken(src, 0, "not a TGA header");
    size_t count = (size_t)h.width * h.height, step = (h.bits + 7) / 8; /* at most 2^32, 4 */
    uint64_t needed = h.data_at + (h.packed ? 0 : (uint64_t)count * step);
    if (needed <= src->size && h.packed)
        needed = unpack(src, &h, NULL);
    if (needed > src->size)
        return rti_image_cut(src, "TGA", needed);
    rt_status status = rti_image_begin(src, h.width, h.height, h.channels, false, out);
    if (status)
        return status;
    if (h.packed)
        unpack(src, &h, out);
    else
        for (size_t n = 0; n < count; n++)
            pixel(src, &h, src->bytes + h.data_at + n * step, place(&h, out, n));
    return RT_OK;
}
