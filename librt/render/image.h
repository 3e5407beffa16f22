/* What an image is made of. Pixels are reached by row: an image that stands in a caller's buffer may have padded rows. */
#ifndef RTI_IMAGE_H
#define RTI_IMAGE_H

#include "../base/base.h"
#include "librt/image.h"

#define RTI_IMAGE_MAX_EDGE 1048576u
#define RTI_TEXT_KEY_MAX   79u /* bytes: what a PNG keyword may have */

typedef struct rti_text {
    char *key, *value;
    size_t key_size, value_size; /* with their NULs */
} rti_text;

struct rt_image {
    rt_context *ctx;
    uint32_t width, height;
    float *pixels;
    size_t row_bytes; /* from row to row; width * 16 unless the buffer is the caller's */
    size_t size;      /* bytes of our own block; 0: the buffer is the caller's */
    bool eight_bit;   /* decoded from a file of 8-bit values: compared as such */
    rti_text *texts;
    size_t text_count, text_capacity;
};

static inline float *rti_image_row(const rt_image *image, uint32_t y)
{
    return (float *)(void *)((unsigned char *)image->pixels + (size_t)y * image->row_bytes);
}

/* Checks 1 <= width, height <= RTI_IMAGE_MAX_EDGE and that the machine has room for `bytes` of pixels (what names the call). */
rt_status rti_image_check_size(rt_context *ctx, const char *what, uint32_t width, uint32_t height);
rt_status rti_image_check_room(rt_context *ctx, const char *what, uint32_t width, uint32_t height, uint64_t bytes);

/* An image that at most `threads` threads clear; rt_image_create lets all of the context's. unseen: nobody looks before all
 * pixels are set, so that it need not be clear. */
rt_status rti_image_make(rt_context *ctx, uint32_t width, uint32_t height, uint32_t threads, bool unseen, rt_image **image);
/* The same over the caller's buffer; row_bytes >= 16 width, a multiple of 4. */
rt_status rti_image_wrap(rt_context *ctx, uint32_t width, uint32_t height, float *pixels, size_t row_bytes, uint32_t threads,
                         rt_image **image);

#endif
