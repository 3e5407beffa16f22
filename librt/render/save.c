/* From linear floats to the samples of a file: exposure, tone curve, sRGB encoding; and the choice of the format. */
#include "save_formats.h"

#include <math.h>
#include <string.h>

#include "../scene/import/srgb.h"
#include "image_text.h"

struct rti_row_writer {
    rti_saver saver;
    rt_status status;
    uint32_t rows_done;
    float scale;
    rt_tone tone;
    void *row; /* samples of one row */
    size_t row_size, name_size;
    rti_text *texts; /* the image's and the caller's together, when there are of the latter */
    size_t texts_size;
    bool begun;
    rti_srgb_encoder encoder;
};

/* ---- samples ---- */

/* 2^x for |x| <= 100: the series of e^(f ln 2) for the fraction, doubled or halved; the same bits everywhere. */
static double power_of_two(double x)
{
    double whole = floor(x), f = (x - whole) * 0.69314718055994530942, term = 1.0, sum = 1.0;
    for (int i = 1; i < 24; i++) {
        term = term * f / i;
        sum += term;
    }
    for (; whole > 0; whole--)
        sum *= 2.0;
    for (; whole < 0; whole++)
        sum *= 0.5;
    return sum;
}

/* RT_TONE_FILMIC: K. Narkowicz's fit of the ACES curve (2015). It maps 0 to 0, 0.18 to about 0.27 and tends to 1.03, cut at 1. */
static float filmic(float x)
{
    if (x > 1e4f)
        return 1.0f;
    float y = x * (2.51f * x + 0.03f) / (x * (2.43f * x + 0.59f) + 0.14f);
    return y < 1.0f ? y : 1.0f;
}

static float toned(const rti_row_writer *w, float x)
{
    x *= w->scale;
    if (!(x > 0.0f)) /* NaN too */
        return 0.0f;
    return w->tone == RT_TONE_FILMIC ? filmic(x) : x;
}

static float unit(float x)
{
    return !(x > 0.0f) ? 0.0f : x < 1.0f ? x : 1.0f;
}

static void fill_row(rti_row_writer *w, const float *rgba)
{
    const rti_saver *s = &w->saver;
    uint8_t *bytes = w->row;
    uint16_t *words = w->row;
    float *floats = w->row;
    for (uint32_t x = 0; x < s->width; x++, rgba += 4) {
        for (uint32_t c = 0; c < s->channels; c++) {
            if (s->bits == 32) {
                float v = rgba[c] * w->scale;
                *floats++ = v > 0.0f ? v : 0.0f;
            } else if (s->bits == 16) {
                double v = c == 3 ? unit(rgba[3]) : rti_srgb_encode(toned(w, rgba[c]));
                *words++ = (uint16_t)(v * 65535.0 + 0.5);
            } else {
                *bytes++ = c == 3 ? (uint8_t)(unit(rgba[3]) * 255.0f + 0.5f) : rti_srgb_byte(&w->encoder, toned(w, rgba[c]));
            }
        }
    }
}

/* ---- formats ---- */

static const char *const format_names[] = {"png", "jpg", "jpeg", "bmp", "tga", "hdr"};
static const rti_save_format *const formats[] = {
#ifdef RTI_HAVE_PNG
    &rti_save_png,
#else
    &rti_save_png_plain,
#endif
    &rti_save_jpg, &rti_save_jpg, &rti_save_bmp, &rti_save_tga, &rti_save_hdr};

static bool same_word(const char *a, const char *b)
{
    for (; *a && *b; a++, b++) {
        char low = *a >= 'A' && *a <= 'Z' ? (char)(*a + 32) : *a;
        if (low != *b)
            return false;
    }
    return *a == *b;
}

static rt_status find_format(rt_context *ctx, const char *path, const char *wanted, const rti_save_format **format)
{
    char name[300];
    const char *slash = strrchr(path, '/');
    const char *dot = strrchr(slash ? slash + 1 : path, '.');
    const char *word = wanted ? wanted : dot ? dot + 1 : "";
    for (size_t i = 0; i < RTI_COUNT(formats); i++) {
        if (same_word(word, format_names[i])) {
            *format = formats[i];
            return RT_OK;
        }
    }
    if (!*word)
        return rti_fail(ctx, RT_ERROR_UNSUPPORTED,
                        "%s: no image format is given and the name has no ending; use one of png, jpg, bmp, tga, hdr",
                        rti_quote(name, sizeof name, path, strlen(path)));
    const char *near = rti_nearest(word, format_names, RTI_COUNT(format_names));
    char shown[64];
    return rti_fail(ctx, RT_ERROR_UNSUPPORTED, "%s: image format '%s' is not known; %s%s%sknown are png, jpg, bmp, tga and hdr",
                    rti_quote(name, sizeof name, path, strlen(path)), rti_quote(shown, sizeof shown, word, strlen(word)),
                    near ? "did you mean '" : "", near ? near : "", near ? "'? " : "");
}

static rt_status check(rt_context *ctx, const rti_save_format *format, uint32_t width, uint32_t height, const rt_save_desc *d)
{
    char number[32];
    if (width == 0 || height == 0)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "saving an image: it has %u x %u pixels", (unsigned)width, (unsigned)height);
    if (width > format->max_side || height > format->max_side)
        return rti_fail(ctx, RT_ERROR_UNSUPPORTED,
                        "saving an image: %s files have at most %u pixels a side, this image has %u x %u; use png", format->name,
                        (unsigned)format->max_side, (unsigned)width, (unsigned)height);
    if (!(d->exposure >= -100.0f && d->exposure <= 100.0f))
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "saving an image: exposure is %s; it must be -100 ... 100 stops",
                        rti_num(number, d->exposure));
    if (d->tone != RT_TONE_NONE && d->tone != RT_TONE_FILMIC)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "saving an image: tone is %d; it must be RT_TONE_NONE or RT_TONE_FILMIC",
                        (int)d->tone);
    if (d->bits != 8 && d->bits != 16)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "saving an image: bits is %u; it must be 8 or 16", (unsigned)d->bits);
    if (d->bits == 16 && !format->deep && !format->linear)
        return rti_fail(ctx, RT_ERROR_UNSUPPORTED, "saving an image: %s files have 8 bits, not 16; use png", format->name);
    if (d->quality < 1 || d->quality > 100)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "saving an image: quality is %u; it must be 1 ... 100", (unsigned)d->quality);
    return RT_OK;
}

rt_save_desc rt_save_desc_default(void)
{
    return (rt_save_desc){.struct_size = sizeof(rt_save_desc), .bits = 8, .quality = 90};
}

/* ---- the writer ---- */

static void free_writer(rti_row_writer *w)
{
    rt_context *ctx = w->saver.ctx;
    if (w->begun)
        w->saver.format->dispose(&w->saver);
    rti_free(ctx, w->texts, w->texts_size);
    rti_free(ctx, w->row, w->row_size);
    rti_free(ctx, w->saver.name, w->name_size);
    rti_free(ctx, w, sizeof *w);
}

static rt_status start(rti_row_writer *w, const char *path)
{
    rti_saver *s = &w->saver;
    size_t length = strlen(path);
    w->name_size = 4 * (length < 250 ? length : 250) + 8;
    s->name = rti_alloc(s->ctx, w->name_size);
    w->row_size = (size_t)s->width * s->channels * (s->bits / 8); /* at most 2^32 * 16 */
    w->row = rti_alloc(s->ctx, w->row_size);
    if (!s->name || !w->row)
        return rti_fail_memory(s->ctx, "saving an image", w->row_size);
    rti_quote(s->name, w->name_size, path, length);
    rt_status status = rti_writer_open(s->ctx, path, &s->out);
    if (status)
        return status;
    w->begun = true;
    return s->format->begin(s);
}

rt_status rti_rows_open_as(rt_context *ctx, const rti_save_format *format, const char *path, uint32_t width, uint32_t height,
                           const rt_save_desc *desc, const rti_text *texts, size_t text_count, rti_row_writer **writer)
{
    rt_save_desc d = rt_save_desc_default();
    *writer = NULL;
    rt_status status = desc ? rti_desc_take(ctx, "rt_save_desc", desc, &d, sizeof d) : RT_OK;
    if (!status)
        status = check(ctx, format, width, height, &d);
    if (status)
        return status;
    rti_row_writer *w = rti_alloc_zero(ctx, sizeof *w);
    if (!w)
        return rti_fail_memory(ctx, "saving an image", sizeof *w);
    w->saver = (rti_saver){.ctx = ctx,
                           .format = format,
                           .width = width,
                           .height = height,
                           .channels = d.alpha && format->alpha ? 4 : 3,
                           .bits = format->linear ? 32 : d.bits,
                           .quality = d.quality,
                           .texts = texts,
                           .text_count = d.no_text ? 0 : text_count};
    rti_fpenv env = rti_fp_enter();
    w->scale = (float)power_of_two(d.exposure);
    w->tone = d.tone;
    if (w->saver.bits == 8)
        rti_srgb_encoder_init(&w->encoder);
    rti_fp_leave(env);
    if (!d.no_text && d.text_count) {
        status = rti_texts_merge(ctx, texts, text_count, d.texts, d.text_count, &w->texts, &w->saver.text_count, &w->texts_size);
        w->saver.texts = w->texts;
    }
    if (!status)
        status = start(w, path);
    if (status) {
        if (w->saver.out)
            rti_writer_close(w->saver.out, false);
        free_writer(w);
        return status;
    }
    *writer = w;
    return RT_OK;
}

rt_status rti_rows_open(rt_context *ctx, const char *path, uint32_t width, uint32_t height, const rt_save_desc *desc,
                        const rti_text *texts, size_t text_count, rti_row_writer **writer)
{
    rt_save_desc d = rt_save_desc_default();
    const rti_save_format *format = NULL;
    *writer = NULL;
    rt_status status = desc ? rti_desc_take(ctx, "rt_save_desc", desc, &d, sizeof d) : RT_OK;
    if (!status)
        status = find_format(ctx, path, d.format, &format);
    return status ? status : rti_rows_open_as(ctx, format, path, width, height, &d, texts, text_count, writer);
}

rt_status rti_rows_write(rti_row_writer *w, const float *rgba, uint32_t row_count)
{
    rti_saver *s = &w->saver;
    if (!w->status && row_count > s->height - w->rows_done)
        w->status = rti_fail(s->ctx, RT_ERROR_STATE, "%s: %u rows more than the image's %u were written", s->name,
                             (unsigned)(row_count - (s->height - w->rows_done)), (unsigned)s->height);
    rti_fpenv env = rti_fp_enter();
    for (uint32_t y = 0; y < row_count && !w->status; y++) {
        fill_row(w, rgba + (size_t)y * s->width * 4);
        w->status = s->format->row(s, w->row);
        w->rows_done++;
    }
    rti_fp_leave(env);
    return w->status;
}

rt_status rti_rows_close(rti_row_writer *w, bool keep)
{
    if (!w)
        return RT_OK;
    rti_saver *s = &w->saver;
    rt_status status = w->status;
    if (!status && keep && w->rows_done < s->height)
        status = rti_fail(s->ctx, RT_ERROR_STATE, "%s: only %u of the image's %u rows were written", s->name,
                          (unsigned)w->rows_done, (unsigned)s->height);
    if (!status && keep)
        status = s->format->end(s);
    rt_status closed = rti_writer_close(s->out, keep && !status);
    free_writer(w);
    return status ? status : closed;
}
