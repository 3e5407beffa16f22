/* What the image readers share: the bytes they read, their messages, and room for the result. */
#ifndef RTI_IMAGE_FORMATS_H
#define RTI_IMAGE_FORMATS_H

#include "image_read.h"

typedef struct rti_image_source {
    rt_context *ctx;
    const char *name; /* escaped for messages */
    const uint8_t *bytes;
    size_t size;
    bool linear; /* samples of 16 bits are linear already */
} rti_image_source;

/* Fails with "NAME: byte OFFSET: reason" and FORMAT. */
rt_status rti_image_broken(const rti_image_source *src, size_t offset, const char *format, ...) RTI_PRINTF(3, 4);
rt_status rti_image_cut(const rti_image_source *src, const char *kind, uint64_t needed);

/* Each side must be 1 ... 2^20, and the machine must have `need` bytes free. */
rt_status rti_image_allow(const rti_image_source *src, uint64_t width, uint64_t height, uint64_t need);
/* The same for the picture itself; takes its memory, zeroed. */
rt_status rti_image_begin(const rti_image_source *src, uint64_t width, uint64_t height, uint32_t channels, bool is_float,
                          rti_pixels *out);
void rti_pixels_free(rt_context *ctx, rti_pixels *pixels);

rt_status rti_bmp_decode(const rti_image_source *src, rti_pixels *out);
rt_status rti_tga_decode(const rti_image_source *src, rti_pixels *out);
bool rti_tga_plausible(const rti_image_source *src); /* TGA has no signature */
rt_status rti_hdr_decode(const rti_image_source *src, rti_pixels *out);

/* PNG, JPEG and GIF: the file is walked from its first byte to its end mark, then handed to stb_image. */
typedef struct rti_image_shape {
    uint64_t width, height;
    uint32_t bits; /* of a sample */
} rti_image_shape;
rt_status rti_png_check(const rti_image_source *src, rti_image_shape *shape);
rt_status rti_jpeg_check(const rti_image_source *src, rti_image_shape *shape);
rt_status rti_gif_check(const rti_image_source *src, rti_image_shape *shape);
rt_status rti_stb_decode(const rti_image_source *src, const char *kind, const rti_image_shape *shape, rti_pixels *out);

static inline uint32_t rti_le16(const uint8_t *p)
{
    return (uint32_t)p[0] | (uint32_t)p[1] << 8;
}
static inline uint32_t rti_le32(const uint8_t *p)
{
    return rti_le16(p) | rti_le16(p + 2) << 16;
}
static inline uint32_t rti_be16(const uint8_t *p)
{
    return (uint32_t)p[0] << 8 | p[1];
}
static inline uint32_t rti_be32(const uint8_t *p)
{
    return rti_be16(p) << 16 | rti_be16(p + 2);
}

#endif
