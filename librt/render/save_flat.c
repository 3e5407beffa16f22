/* BMP and TGA: a header and the rows as they are, from the top. */
#include "save_formats.h"

#include <string.h>

/* One row in the file's own order: blue first, padded. */
static rt_status begin_row(rti_saver *s, uint32_t align)
{
    size_t pitch = ((size_t)s->width * s->channels + align - 1) / align * align;
    s->state = rti_alloc_zero(s->ctx, pitch);
    return s->state ? RT_OK : rti_fail_memory(s->ctx, s->name, pitch);
}

static rt_status put_row(rti_saver *s, const uint8_t *from, uint32_t align)
{
    size_t used = (size_t)s->width * s->channels;
    uint8_t *to = s->state;
    for (uint32_t x = 0; x < s->width; x++, from += s->channels, to += s->channels) {
        to[0] = from[2], to[1] = from[1], to[2] = from[0];
        if (s->channels == 4)
            to[3] = from[3];
    }
    return rti_writer_write(s->out, s->state, (used + align - 1) / align * align);
}

static rt_status nothing_more(rti_saver *s)
{
    (void)s;
    return RT_OK;
}

static rt_status bmp_begin(rti_saver *s)
{
    uint8_t head[54] = {'B', 'M'};
    uint64_t size = ((uint64_t)s->width * 3 + 3) / 4 * 4 * s->height;
    if (size > UINT32_MAX - sizeof head)
        return rti_fail(s->ctx, RT_ERROR_UNSUPPORTED, "%s: a BMP file holds at most 4 GiB, this image needs %llu bytes; use png",
                        s->name, (unsigned long long)size);
    rti_put_le32(head + 2, (uint32_t)(size + sizeof head));
    rti_put_le32(head + 10, sizeof head);
    rti_put_le32(head + 14, 40);
    rti_put_le32(head + 18, s->width);
    rti_put_le32(head + 22, ~s->height + 1); /* negative: rows from the top */
    rti_put_le16(head + 26, 1);
    rti_put_le16(head + 28, 24);
    rti_put_le32(head + 34, (uint32_t)size);
    rti_put_le32(head + 38, 2835); /* 72 dots an inch */
    rti_put_le32(head + 42, 2835);
    rt_status status = begin_row(s, 4);
    return status ? status : rti_writer_write(s->out, head, sizeof head);
}

static rt_status bmp_row(rti_saver *s, const void *samples)
{
    return put_row(s, samples, 4);
}

static void bmp_dispose(rti_saver *s)
{
    rti_free(s->ctx, s->state, ((size_t)s->width * 3 + 3) / 4 * 4);
}

static rt_status tga_begin(rti_saver *s)
{
    uint8_t head[18] = {0, 0, 2};
    rti_put_le16(head + 12, s->width);
    rti_put_le16(head + 14, s->height);
    head[16] = (uint8_t)(8 * s->channels);
    head[17] = (uint8_t)(0x20 | (s->channels == 4 ? 8 : 0)); /* rows from the top; bits of alpha */
    rt_status status = begin_row(s, 1);
    return status ? status : rti_writer_write(s->out, head, sizeof head);
}

static rt_status tga_row(rti_saver *s, const void *samples)
{
    return put_row(s, samples, 1);
}

static void tga_dispose(rti_saver *s)
{
    rti_free(s->ctx, s->state, (size_t)s->width * s->channels);
}

const rti_save_format rti_save_bmp = {"bmp", 1048576, false, false, false, bmp_begin, bmp_row, nothing_more, bmp_dispose};
const rti_save_format rti_save_tga = {"tga", 65535, true, false, false, tga_begin, tga_row, nothing_more, tga_dispose};
