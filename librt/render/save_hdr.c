/* Radiance HDR: RGBE, rows run-length coded channel by channel where the format allows it (8 ... 32767 pixels a row).
 * Source: G. Ward, "Real Pixels", Graphics Gems II, 1991. Mantissas are rounded to nearest, not cut, but for those above 255. */
#include "image_text.h"
#include "save_formats.h"

#include <string.h>

/* State: the row as RGBE, then the packed row (at worst a byte more for each 128, and 4). */
static size_t rgbe_size(const rti_saver *s)
{
    return 4 * (size_t)s->width;
}
static size_t state_size(const rti_saver *s)
{
    return 2 * rgbe_size(s) + rgbe_size(s) / 64 + 64;
}

static rt_status hdr_begin(rti_saver *s)
{
    char head[128];
    s->state = rti_alloc(s->ctx, state_size(s));
    if (!s->state)
        return rti_fail_memory(s->ctx, s->name, state_size(s));
    rti_writer_write(s->out, "#?RADIANCE\n", 11);
    rti_texts_write_hdr(s->out, s->texts, s->text_count);
    int length = snprintf(head, sizeof head, "FORMAT=32-bit_rle_rgbe\n\n-Y %u +X %u\n", (unsigned)s->height, (unsigned)s->width);
    return rti_writer_write(s->out, head, (size_t)length);
}

static void to_rgbe(const float *rgb, uint8_t *to)
{
    float most = rgb[0] > rgb[1] ? rgb[0] : rgb[1];
    most = most > rgb[2] ? most : rgb[2];
    uint32_t bits;
    memcpy(&bits, &most, sizeof bits);
    int e = (int)(bits >> 23) - 126; /* most is in [2^(e-1), 2^e) */
    memset(to, 0, 4);
    if (e < -100) /* too dark to be told from black */
        return;
    if (e > 127) { /* the largest that readers can hold; infinity too */
        e = 127;
    }
    double scale = 1.0;
    for (int i = e; i < 8; i++)
        scale *= 2.0;
    for (int i = e; i > 8; i--)
        scale *= 0.5;
    for (int c = 0; c < 3; c++) {
        double m = (double)rgb[c] * scale + 0.5;
        to[c] = (uint8_t)(m < 255.0 ? m : 255.0);
    }
    to[3] = (uint8_t)(e + 128);
}

/* Runs of 4 and more are packed, the rest goes in dumps of up to 128. */
static uint8_t *pack(const uint8_t *rgbe, uint32_t width, uint32_t c, uint8_t *to)
{
    for (uint32_t x = 0; x < width;) {
        uint32_t run = 1, dump = 0;
        while (x + dump < width && dump < 128) { /* how far until a run begins */
            run = 1;
            while (run < 127 && x + dump + run < width &&
                   rgbe[4 * (size_t)(x + dump + run) + c] == rgbe[4 * (size_t)(x + dump) + c])
                run++;
            if (run >= 4)
                break;
            dump = dump + run < 128 ? dump + run : 128;
            run = 0;
        }
        if (dump) {
            *to++ = (uint8_t)dump;
            for (uint32_t i = 0; i < dump; i++)
                *to++ = rgbe[4 * (size_t)(x + i) + c];
            x += dump;
        }
        if (run >= 4) {
            *to++ = (uint8_t)(128 + run);
            *to++ = rgbe[4 * (size_t)x + c];
            x += run;
        }
    }
    return to;
}

static rt_status hdr_row(rti_saver *s, const void *samples)
{
    const float *rgb = samples;
    uint8_t *rgbe = s->state, *packed = rgbe + rgbe_size(s);
    for (uint32_t x = 0; x < s->width; x++)
        to_rgbe(rgb + 3 * (size_t)x, rgbe + 4 * (size_t)x);
    if (s->width < 8 || s->width > 32767)
        return rti_writer_write(s->out, rgbe, rgbe_size(s));
    uint8_t *to = packed;
    *to++ = 2;
    *to++ = 2;
    *to++ = (uint8_t)(s->width >> 8);
    *to++ = (uint8_t)s->width;
    for (uint32_t c = 0; c < 4; c++)
        to = pack(rgbe, s->width, c, to);
    return rti_writer_write(s->out, packed, (size_t)(to - packed));
}

static rt_status hdr_end(rti_saver *s)
{
    (void)s;
    return RT_OK;
}

static void hdr_dispose(rti_saver *s)
{
    rti_free(s->ctx, s->state, state_size(s));
}

const rti_save_format rti_save_hdr = {"hdr", 1048576, false, false, true, hdr_begin, hdr_row, hdr_end, hdr_dispose};
