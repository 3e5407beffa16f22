/* BMP: 1, 4, 8 bits with a palette, 16, 24 and 32 bits, with channel masks or without; upside down or not. Run-length and
 * embedded JPEG or PNG files are refused by name. */
#include "image_formats.h"

#include <string.h>

typedef struct bmp_head {
    uint32_t offset, header, bits, compression;
    uint32_t width, height;
    bool top_down;
    uint32_t mask[4];    /* red, green, blue, alpha */
    uint32_t palette_at; /* offset of the palette */
    uint32_t entry, entries;
} bmp_head;

static rt_status read_masks(const rti_image_source *src, bmp_head *h)
{
    static const uint32_t masks16[4] = {0x7c00u, 0x3e0u, 0x1fu, 0}, masks32[4] = {0xff0000u, 0xff00u, 0xffu, 0};
    if (h->compression == 0) {
        memcpy(h->mask, h->bits == 16 ? masks16 : masks32, sizeof h->mask);
        if (h->bits == 32)
            h->mask[3] = 0xff000000u;
        return RT_OK;
    }
    if (src->size < 14 + 40 + 12)
        return rti_image_cut(src, "BMP", 14 + 40 + 12);
    for (int c = 0; c < 3; c++)
        h->mask[c] = rti_le32(src->bytes + 14 + 40 + 4 * c);
    h->mask[3] = h->header >= 56 && src->size >= 14 + 56 ? rti_le32(src->bytes + 14 + 52) : 0;
    for (int c = 0; c < 4; c++) {
        uint32_t m = h->mask[c];
        if (c < 3 && m == 0)
            return rti_image_broken(src, 54, "a channel mask of this BMP file is 0");
        uint32_t low = m & (~m + 1); /* a mask is one run of bits: adding its lowest bit leaves a power of two, or 0 */
        uint32_t over = m + low;
        if (m && (over & (over - 1)))
            return rti_image_broken(src, 54, "the channel mask 0x%x of this BMP file is not one run of bits", (unsigned)m);
    }
    if ((h->mask[0] & h->mask[1]) || (h->mask[0] & h->mask[2]) || (h->mask[1] & h->mask[2]))
        return rti_image_broken(src, 54, "the channel masks of this BMP file overlap");
    return RT_OK;
}

static rt_status read_head(const rti_image_source *src, bmp_head *h)
{
    const uint8_t *p = src->bytes;
    memset(h, 0, sizeof *h);
    if (src->size < 26)
        return rti_image_cut(src, "BMP", 26);
    h->offset = rti_le32(p + 10);
    h->header = rti_le32(p + 14);
    bool core = h->header == 12;
    if (!core && h->header != 40 && h->header != 52 && h->header != 56 && h->header != 64 && h->header != 108 && h->header != 124)
        return rti_image_broken(src, 14, "unknown BMP header of %u bytes", (unsigned)h->header);
    if (src->size < 14u + h->header)
        return rti_image_cut(src, "BMP", 14u + h->header);
    if (core) {
        h->width = rti_le16(p + 18);
        h->height = rti_le16(p + 20);
        h->bits = rti_le16(p + 24);
    } else {
        h->width = rti_le32(p + 18);
        h->height = rti_le32(p + 22);
        h->top_down = h->height >> 31;
        if (h->top_down)
            h->height = ~h->height + 1;
        h->bits = rti_le16(p + 28);
        h->compression = rti_le32(p + 30);
    }
    if (h->compression == 1 || h->compression == 2)
        return rti_fail(src->ctx, RT_ERROR_UNSUPPORTED,
                        "%s: run-length BMP files are not read; save it without compression or as PNG", src->name);
    if (h->compression > 3 || (h->compression == 3 && h->bits != 16 && h->bits != 32))
        return rti_image_broken(src, 30, "BMP compression %u with %u bits is not known; save it without compression or as PNG",
                                (unsigned)h->compression, (unsigned)h->bits);
    if (h->bits == 16 || h->bits == 32)
        return read_masks(src, h);
    if (h->bits == 24)
        return RT_OK;
    if (h->bits != 1 && h->bits != 4 && h->bits != 8)
        return rti_image_broken(src, 28, "a BMP file of %u bits a pixel; 1, 4, 8, 16, 24 and 32 are read", (unsigned)h->bits);
    uint32_t used = core ? 0 : rti_le32(p + 46);
    h->palette_at = 14 + h->header;
    h->entry = core ? 3 : 4;
    h->entries = used && used < 1u << h->bits ? used : 1u << h->bits;
    uint64_t end = h->palette_at + (uint64_t)h->entry * h->entries;
    return end > src->size ? rti_image_cut(src, "BMP", end) : RT_OK;
}

/* The bits of v under the mask, spread to 0 ... 255. */
static uint8_t masked(uint32_t v, uint32_t mask)
{
    uint32_t low = mask & (~mask + 1);
    uint64_t top = mask / low;
    return (uint8_t)(((v & mask) / low * (uint64_t)255 + top / 2) / top);
}

static void read_row(const bmp_head *h, const uint8_t *palette, const uint8_t *row, uint8_t *to, uint32_t channels)
{
    for (uint32_t x = 0; x < h->width; x++, to += channels) {
        if (h->bits <= 8) {
            uint32_t bit = x * h->bits; /* at most 8 * 2^20 */
            uint32_t i = row[bit >> 3] >> (8 - h->bits - (bit & 7)) & ((1u << h->bits) - 1);
            static const uint8_t black[3];
            const uint8_t *entry = i < h->entries ? palette + (size_t)i * h->entry : black;
            to[0] = entry[2], to[1] = entry[1], to[2] = entry[0];
        } else if (h->bits == 24) {
            to[0] = row[3 * (size_t)x + 2], to[1] = row[3 * (size_t)x + 1], to[2] = row[3 * (size_t)x];
        } else {
            uint32_t v = h->bits == 16 ? rti_le16(row + 2 * (size_t)x) : rti_le32(row + 4 * (size_t)x);
            for (uint32_t c = 0; c < channels; c++)
                to[c] = masked(v, h->mask[c]);
        }
    }
}

rt_status rti_bmp_decode(const rti_image_source *src, rti_pixels *out)
{
    bmp_head h;
    rt_status status = read_head(src, &h);
    if (status)
        return status;
    uint64_t pitch = ((uint64_t)h.width * h.bits + 31) / 32 * 4;
    uint64_t last = ((uint64_t)h.width * h.bits + 7) / 8; /* the last row need not be padded */
    if (h.width && h.height) {
        uint64_t rows = pitch * (h.height - 1);
        if (pitch && rows / pitch != h.height - 1)
            rows = UINT64_MAX / 2;
        if (rows + last + h.offset > src->size)
            return rti_image_cut(src, "BMP", rows + last + h.offset);
    }
    uint32_t channels = h.mask[3] ? 4 : 3;
    status = rti_image_begin(src, h.width, h.height, channels, false, out);
    if (status)
        return status;
    uint32_t opaque = 0;
    for (uint32_t y = 0; y < h.height; y++) {
        const uint8_t *row = src->bytes + h.offset + pitch * (h.top_down ? y : h.height - 1 - y);
        uint8_t *to = (uint8_t *)out->data + (size_t)y * h.width * channels;
        read_row(&h, src->bytes + h.palette_at, row, to, channels);
        for (uint32_t x = 0; channels == 4 && x < h.width; x++)
            opaque |= to[4 * (size_t)x + 3];
    }
    if (channels == 4 && !opaque) /* many writers leave the fourth byte at 0 and mean no alpha */
        for (size_t i = 3; i < out->size; i += 4)
            ((uint8_t *)out->data)[i] = 255;
    return RT_OK;
}
