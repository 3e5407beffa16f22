/* Image files to pixels: PNG, JPEG, GIF (through stb_image), BMP, TGA and Radiance HDR (own readers, also in builds without stb).
 * The kind is found by content. Files are hostile: sizes are checked against the file's length and the memory that is left before
 * anything is decoded, and a file that is cut anywhere is refused, never filled up. */
#ifndef RTI_IMAGE_READ_H
#define RTI_IMAGE_READ_H

#include "../../base/base.h"

typedef struct rti_pixels {
    uint32_t width, height;
    uint32_t channels; /* 1 grey, 3 RGB, 4 RGBA (grey with alpha comes as RGBA) */
    bool is_float;     /* float, linear; otherwise bytes with sRGB-encoded colours and linear alpha */
    void *data;        /* rows from the top, no padding */
    size_t size;       /* bytes: free with rti_free(ctx, data, size) */
} rti_pixels;

/* HDR files and PNG files of 16 bits come as floats, all others as bytes. A GIF gives its first picture.
 * Errors IO, FORMAT, MEMORY, MEMORY_LIMIT, UNSUPPORTED (a PNG, JPEG or GIF in a build without stb_image); *out is then empty. */
rt_status rti_image_read(rt_context *ctx, const char *path, rti_pixels *out);

/* The same for a file that is in memory; name is for the messages. linear: samples of 16 bits are linear already. */
rt_status rti_image_decode(rt_context *ctx, const char *name, const void *bytes, size_t size, bool linear, rti_pixels *out);

#endif
