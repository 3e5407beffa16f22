/* Which reader an image file goes to, and what they all need. */
#include "image_formats.h"

#include <string.h>

#define LARGE    (16u << 20) /* below this the machine's free memory is not asked for */
#define MAX_SIDE 1048576u

rt_status rti_image_broken(const rti_image_source *src, size_t offset, const char *format, ...)
{
    char reason[512];
    va_list args;
    va_start(args, format);
    vsnprintf(reason, sizeof reason, format, args);
    va_end(args);
    return rti_fail(src->ctx, RT_ERROR_FORMAT, "%s: byte %zu: %s", src->name, offset, reason);
}

rt_status rti_image_cut(const rti_image_source *src, const char *kind, uint64_t needed)
{
    return rti_fail(src->ctx, RT_ERROR_FORMAT,
                    "%s: this %s file is cut: it has %zu bytes and needs at least %llu; copy or save it again", src->name, kind,
                    src->size, (unsigned long long)needed);
}

rt_status rti_image_allow(const rti_image_source *src, uint64_t width, uint64_t height, uint64_t need)
{
    if (width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE)
        return rti_fail(src->ctx, RT_ERROR_FORMAT, "%s: the image has %llu x %llu pixels; each side must be 1 ... %u", src->name,
                        (unsigned long long)width, (unsigned long long)height, MAX_SIDE);
    const uint64_t free_bytes = need > LARGE ? rti_context_spare(src->ctx, need, rt_memory_available) : need;
    if (need > free_bytes)
        return rti_fail(src->ctx, RT_ERROR_MEMORY_LIMIT,
                        "%s: an image of %llu x %llu pixels needs %llu bytes to be read, this machine has %llu free", src->name,
                        (unsigned long long)width, (unsigned long long)height, (unsigned long long)need,
                        (unsigned long long)free_bytes);
    return RT_OK;
}

rt_status rti_image_begin(const rti_image_source *src, uint64_t width, uint64_t height, uint32_t channels, bool is_float,
                          rti_pixels *out)
{
    uint64_t size = width * height * channels * (is_float ? sizeof(float) : 1); /* allowed only up to 2^20 * 2^20 * 16 */
    memset(out, 0, sizeof *out);
    rt_status status = rti_image_allow(src, width, height, size);
    if (status)
        return status;
    void *data = size <= SIZE_MAX ? rti_alloc_zero(src->ctx, (size_t)size) : NULL;
    if (!data)
        return rti_fail_memory(src->ctx, src->name, (size_t)size);
    *out = (rti_pixels){(uint32_t)width, (uint32_t)height, channels, is_float, data, (size_t)size};
    return RT_OK;
}

void rti_pixels_free(rt_context *ctx, rti_pixels *pixels)
{
    rti_free(ctx, pixels->data, pixels->size);
    memset(pixels, 0, sizeof *pixels);
}

static bool starts(const rti_image_source *src, const char *magic, size_t length)
{
    return src->size >= length && memcmp(src->bytes, magic, length) == 0;
}

static rt_status decode(const rti_image_source *src, rti_pixels *out)
{
    rti_image_shape shape;
    rt_status status;
    if (starts(src, "\x89PNG\r\n\x1a\n", 8)) {
        status = rti_png_check(src, &shape);
        return status ? status : rti_stb_decode(src, "PNG", &shape, out);
    }
    if (starts(src, "\xff\xd8\xff", 3)) {
        status = rti_jpeg_check(src, &shape);
        return status ? status : rti_stb_decode(src, "JPEG", &shape, out);
    }
    if (starts(src, "GIF87a", 6) || starts(src, "GIF89a", 6)) {
        status = rti_gif_check(src, &shape);
        return status ? status : rti_stb_decode(src, "GIF", &shape, out);
    }
    if (starts(src, "BM", 2))
        return rti_bmp_decode(src, out);
    if (starts(src, "#?RADIANCE", 10) || starts(src, "#?RGBE", 6))
        return rti_hdr_decode(src, out);
    if (rti_tga_plausible(src))
        return rti_tga_decode(src, out);
    if (src->size == 0)
        return rti_fail(src->ctx, RT_ERROR_FORMAT, "%s: the file is empty; an image was expected", src->name);
    return rti_fail(src->ctx, RT_ERROR_FORMAT,
                    "%s: not a PNG, JPEG, GIF, BMP, TGA or HDR image, or its first bytes are damaged; convert it to PNG",
                    src->name);
}

rt_status rti_image_decode(rt_context *ctx, const char *name, const void *bytes, size_t size, bool linear, rti_pixels *out)
{
    char quoted[300];
    rti_quote(quoted, sizeof quoted, name, strlen(name));
    rti_image_source src = {ctx, quoted, bytes, size, linear};
    memset(out, 0, sizeof *out);
    rt_status status = decode(&src, out);
    if (status)
        rti_pixels_free(ctx, out);
    return status;
}

rt_status rti_image_read(rt_context *ctx, const char *path, rti_pixels *out)
{
    void *bytes;
    size_t size;
    memset(out, 0, sizeof *out);
    rt_status status = rti_file_read(ctx, path, 0, &bytes, &size);
    if (status)
        return status;
    status = rti_image_decode(ctx, path, bytes, size, false, out);
    rti_free(ctx, bytes, size + 1);
    return status;
}
