/* JPEG through stb_image_write, which takes the whole picture at once (and no memory of its own). */
#include "save_formats.h"

#include <limits.h>
#include <string.h>

#ifdef RTI_HAVE_STB

#define STBI_WRITE_NO_STDIO
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb_image_write.h>

typedef struct jpg_state {
    size_t size, used;
    rt_status status;
    uint8_t *pixels;
} jpg_state;

static rt_status jpg_begin(rti_saver *s)
{
    uint64_t size = (uint64_t)s->width * s->height * 3;
    if (size > INT_MAX)
        return rti_fail(s->ctx, RT_ERROR_UNSUPPORTED,
                        "%s: this image is too large for the JPEG writer (%llu bytes, 2 GiB at most); use png", s->name,
                        (unsigned long long)size);
    jpg_state *j = rti_alloc_zero(s->ctx, sizeof *j);
    s->state = j;
    if (!j)
        return rti_fail_memory(s->ctx, s->name, sizeof *j);
    j->pixels = rti_alloc(s->ctx, (size_t)size);
    if (!j->pixels)
        return rti_fail_memory(s->ctx, s->name, (size_t)size);
    j->size = (size_t)size;
    return RT_OK;
}

static rt_status jpg_row(rti_saver *s, const void *samples)
{
    jpg_state *j = s->state;
    memcpy(j->pixels + j->used, samples, 3 * (size_t)s->width);
    j->used += 3 * (size_t)s->width;
    return RT_OK;
}

static void put(void *user, void *data, int size)
{
    rti_saver *s = user;
    jpg_state *j = s->state;
    if (!j->status)
        j->status = rti_writer_write(s->out, data, (size_t)size);
}

static rt_status jpg_end(rti_saver *s)
{
    jpg_state *j = s->state;
    int done = stbi_write_jpg_to_func(put, s, (int)s->width, (int)s->height, 3, j->pixels, (int)s->quality);
    if (!done && !j->status)
        j->status = rti_fail(s->ctx, RT_ERROR_UNSUPPORTED, "%s: the JPEG writer refused an image of %u x %u pixels; use png",
                             s->name, (unsigned)s->width, (unsigned)s->height);
    return j->status;
}

static void jpg_dispose(rti_saver *s)
{
    jpg_state *j = s->state;
    if (j)
        rti_free(s->ctx, j->pixels, j->size);
    rti_free(s->ctx, j, sizeof *j);
}

#else

static rt_status jpg_begin(rti_saver *s)
{
    return rti_fail(s->ctx, RT_ERROR_UNSUPPORTED,
                    "%s: this librt was built without stb_image_write and writes no JPEG; use png, bmp, tga or hdr, or build "
                    "with -DLIBRT_STB=ON",
                    s->name);
}

static rt_status jpg_row(rti_saver *s, const void *samples)
{
    (void)samples;
    return jpg_begin(s);
}

static rt_status jpg_end(rti_saver *s)
{
    return jpg_begin(s);
}

static void jpg_dispose(rti_saver *s)
{
    (void)s;
}

#endif

const rti_save_format rti_save_jpg = {"jpg", 65535, false, false, false, jpg_begin, jpg_row, jpg_end, jpg_dispose};
