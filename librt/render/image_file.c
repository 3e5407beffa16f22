/* rt_image_load and rt_image_save: between images and files. */
#include <string.h>

#include "../kernel/srgb.h"
#include "../scene/import/image_read.h"

#include "save.h"

/* One row of decoded pixels to linear RGBA; grey becomes three, no alpha becomes 1. */
static void widen(const rti_pixels *p, uint32_t y, float *to)
{
    size_t n = p->channels, first = (size_t)y * p->width * n;
    const uint8_t *bytes = (const uint8_t *)p->data + first;
    const float *floats = (const float *)p->data + first;
    for (uint32_t x = 0; x < p->width; x++, to += 4) {
        for (uint32_t c = 0; c < 3; c++) {
            size_t k = (size_t)x * n + (n == 1 ? 0 : c);
            to[c] = p->is_float ? floats[k] : rtk_srgb_table[bytes[k]];
        }
        size_t k = (size_t)x * n + 3;
        to[3] = n < 4 ? 1.0f : p->is_float ? floats[k] : (float)bytes[k] / 255.0f;
    }
}

/* An image of the pixels, which are freed. */
static rt_status take(rt_context *ctx, rti_pixels *pixels, rt_image **image)
{
    rt_status status = rt_image_create(ctx, pixels->width, pixels->height, image);
    if (!status) {
        (*image)->eight_bit = !pixels->is_float;
        for (uint32_t y = 0; y < pixels->height; y++)
            widen(pixels, y, rti_image_row(*image, y));
    }
    rti_free(ctx, pixels->data, pixels->size);
    return status;
}

rt_status rt_image_load(rt_context *context, const char *path, rt_image **image)
{
    RTI_NEED_TO_MAKE(image, context);
    rti_pixels pixels;
    if (!image)
        return rti_fail(context, RT_ERROR_ARGUMENT, "rt_image_load: image is NULL; it receives the image");
    *image = NULL;
    if (!path)
        return rti_fail(context, RT_ERROR_ARGUMENT, "rt_image_load: path is NULL; give the name of an image file");
    rti_fpenv env = rti_fp_enter();
    rt_status status = rti_image_read(context, path, &pixels);
    if (!status)
        status = take(context, &pixels, image);
    rti_fp_leave(env);
    return status;
}

rt_status rt_image_save(const rt_image *image, const char *path, const rt_save_desc *desc)
{
    RTI_NEED(image);
    rti_row_writer *writer;
    if (!path)
        return rti_fail(image->ctx, RT_ERROR_ARGUMENT,
                        "rt_image_save: path is NULL; give a file's name, or \"-\" for standard output");
    rt_status status =
        rti_rows_open(image->ctx, path, image->width, image->height, desc, image->texts, image->text_count, &writer);
    if (status)
        return status;
    for (uint32_t y = 0; y < image->height && !status; y++)
        status = rti_rows_write(writer, rti_image_row(image, y), 1);
    rt_status closed = rti_rows_close(writer, !status);
    return status ? status : closed;
}
