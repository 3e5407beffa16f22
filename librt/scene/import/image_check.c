/* PNG, JPEG and GIF files walked from the first byte to the end mark, without decoding: stb_image fills up what a cut file lacks,
 * and it takes memory by the header's word alone. Sources: PNG specification (third edition), ITU T.81, GIF89a. */
#include "image_formats.h"

#include <string.h>

/* The header may not promise more pixels than its bytes can hold: such a file is cut, or made to exhaust the memory. */
static rt_status check_ratio(const rti_image_source *src, const char *kind, uint64_t units, uint64_t units_a_byte)
{
    if (units / units_a_byte > src->size)
        return rti_image_cut(src, kind, units / units_a_byte);
    return RT_OK;
}

#ifndef FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION
static uint32_t crc32(const uint8_t *p, size_t size)
{
    static const uint32_t nibble[16] = {0x00000000, 0x1db71064, 0x3b6e20c8, 0x26d930ac, 0x76dc4190, 0x6b6b51f4,
                                        0x4db26158, 0x5005713c, 0xedb88320, 0xf00f9344, 0xd6d6a3e8, 0xcb61b38c,
                                        0x9b64c2b0, 0x86d3d2d4, 0xa00ae278, 0xbdbdf21c};
    uint32_t crc = ~0u;
    for (size_t i = 0; i < size; i++) {
        crc = crc >> 4 ^ nibble[(crc ^ p[i]) & 15];
        crc = crc >> 4 ^ nibble[(crc ^ p[i] >> 4) & 15];
    }
    return ~crc;
}
#else /* a fuzzer cannot guess checksums */
static uint32_t crc32(const uint8_t *p, size_t size)
{
    return rti_be32(p + size);
}
#endif

static rt_status png_header(const rti_image_source *src, size_t at, uint32_t length, rti_image_shape *shape)
{
    static const uint8_t samples[7] = {1, 0, 3, 1, 2, 0, 4};
    const uint8_t *p = src->bytes + at + 8;
    if (at != 8 || length != 13 || memcmp(p - 4, "IHDR", 4) != 0)
        return rti_image_broken(src, at, "a PNG file must begin with an IHDR chunk of 13 bytes");
    *shape = (rti_image_shape){rti_be32(p), rti_be32(p + 4), p[8]};
    if (p[9] > 6 || samples[p[9]] == 0)
        return rti_image_broken(src, at + 17, "PNG colour type %d is not known", p[9]);
    /* deflate gives at most 1032 bytes for one */
    uint64_t row_bits = shape->width * samples[p[9]] * shape->bits;
    return check_ratio(src, "PNG", (row_bits + 7) / 8 * shape->height, 1032);
}

rt_status rti_png_check(const rti_image_source *src, rti_image_shape *shape)
{
    size_t at = 8;
    for (bool first = true;; first = false) {
        if (src->size - at < 12)
            return rti_image_cut(src, "PNG", at + 12);
        const uint8_t *p = src->bytes + at;
        uint32_t length = rti_be32(p);
        if (length > src->size - at - 12)
            return rti_image_cut(src, "PNG", (uint64_t)at + length + 12);
        bool critical = !(p[4] & 32);
        if (critical && crc32(p + 4, length + (size_t)4) != rti_be32(p + 8 + length))
            return rti_image_broken(
                src, at, "the checksum of this PNG chunk is wrong, its %u bytes are damaged; copy or save the file again",
                (unsigned)length);
        rt_status status = first ? png_header(src, at, length, shape) : RT_OK;
        if (status)
            return status;
        at += (size_t)12 + length;
        if (memcmp(p + 4, "IEND", 4) == 0)
            return RT_OK;
    }
}

static bool jpeg_is_frame(uint8_t marker)
{
    return marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
}

/* From the first byte of entropy-coded data to the next marker that is neither a stuffed byte nor a restart. */
static size_t jpeg_skip_scan(const rti_image_source *src, size_t at)
{
    const uint8_t *p = src->bytes;
    for (;;) {
        const uint8_t *ff = at < src->size ? memchr(p + at, 0xff, src->size - at) : NULL;
        if (!ff || (size_t)(ff - p) + 1 >= src->size)
            return src->size;
        at = (size_t)(ff - p);
        uint8_t m = p[at + 1];
        if (m != 0 && m != 0xff && !(m >= 0xd0 && m <= 0xd7))
            return at;
        at += m == 0xff ? 1 : 2;
    }
}

static rt_status jpeg_frame(const rti_image_source *src, size_t at, uint32_t length, rti_image_shape *shape)
{
    const uint8_t *p = src->bytes + at;
    if (shape->width || shape->height)
        return rti_image_broken(src, at, "a second frame in one JPEG file");
    if (length < 8)
        return rti_image_broken(src, at, "a JPEG frame header of %u bytes is too short", (unsigned)length);
    *shape = (rti_image_shape){rti_be16(p + 7), rti_be16(p + 5), p[4]};
    /* an 8 x 8 block takes a bit at the least */
    return check_ratio(src, "JPEG", shape->width * shape->height, 512);
}

/* Huffman tables of more than 256 codes overrun stb_image's arrays (2022). */
static rt_status jpeg_tables(const rti_image_source *src, size_t at, uint32_t length)
{
    const uint8_t *p = src->bytes + at + 4, *end = src->bytes + at + 2 + length;
    while (p < end) {
        uint32_t codes = 0;
        for (int i = 1; i <= 16 && end - p > 16; i++)
            codes += p[i];
        if (end - p < 17 || codes > 256 || codes > (size_t)(end - p) - 17)
            return rti_image_broken(src, at, "a Huffman table of this JPEG file is damaged");
        p += 17 + codes;
    }
    return RT_OK;
}

rt_status rti_jpeg_check(const rti_image_source *src, rti_image_shape *shape)
{
    const uint8_t *p = src->bytes;
    size_t at = 2;
    bool scanned = false;
    *shape = (rti_image_shape){0, 0, 0};
    for (;;) {
        while (src->size - at >= 2 && p[at] == 0xff && p[at + 1] == 0xff) /* fill bytes */
            at++;
        if (src->size - at < 2)
            return rti_image_cut(src, "JPEG", at + 2);
        if (p[at] != 0xff)
            return rti_image_broken(src, at, "a JPEG marker should stand here");
        uint8_t marker = p[at + 1];
        if (marker == 0xd9)
            break;
        if (src->size - at < 4)
            return rti_image_cut(src, "JPEG", at + 4);
        uint32_t length = rti_be16(p + at + 2);
        if (length < 2)
            return rti_image_broken(src, at, "a JPEG segment of %u bytes", (unsigned)length);
        if (src->size - at - 2 < length)
            return rti_image_cut(src, "JPEG", (uint64_t)at + 2 + length + 2);
        rt_status status = jpeg_is_frame(marker) ? jpeg_frame(src, at, length, shape)
                           : marker == 0xc4      ? jpeg_tables(src, at, length)
                                                 : RT_OK;
        if (status)
            return status;
        at += 2 + (size_t)length;
        if (marker == 0xda) {
            scanned = true;
            at = jpeg_skip_scan(src, at);
        }
    }
    if (!scanned || !shape->width)
        return rti_image_broken(src, at, "this JPEG file ends without a picture");
    return RT_OK;
}

/* Over sub-blocks to behind the block of length 0; more than size when they run out of the file. */
static size_t gif_skip_blocks(const rti_image_source *src, size_t at)
{
    while (at < src->size) {
        uint32_t length = src->bytes[at++];
        if (length == 0)
            return at;
        at += length;
    }
    return src->size + 1;
}

rt_status rti_gif_check(const rti_image_source *src, rti_image_shape *shape)
{
    const uint8_t *p = src->bytes;
    bool pictures = false;
    if (src->size < 14)
        return rti_image_cut(src, "GIF", 14);
    *shape = (rti_image_shape){rti_le16(p + 6), rti_le16(p + 8), 8};
    size_t at = 13 + (p[10] & 0x80 ? (size_t)3 << ((p[10] & 7) + 1) : 0);
    for (;;) {
        if (at >= src->size)
            return rti_image_cut(src, "GIF", (uint64_t)at + 1);
        if (p[at] == 0x3b)
            break;
        if (p[at] == 0x21) {
            at = gif_skip_blocks(src, at + 2);
        } else if (p[at] == 0x2c) {
            if (src->size - at < 11)
                return rti_image_cut(src, "GIF", (uint64_t)at + 11);
            size_t palette = p[at + 9] & 0x80 ? (size_t)3 << ((p[at + 9] & 7) + 1) : 0;
            at = gif_skip_blocks(src, at + 11 + palette);
            pictures = true;
        } else {
            return rti_image_broken(src, at, "an unknown block 0x%02x in this GIF file", p[at]);
        }
    }
    if (!pictures)
        return rti_image_broken(src, at, "this GIF file ends without a picture");
    /* a picture may be smaller than its screen, so only absurd screens are refused: a code of 12 bits stands for up to 4096
     * pixels */
    return check_ratio(src, "GIF", shape->width * shape->height / 4, 4096);
}
