/* PNG through libpng: 8 and 16 bits, text entries, row by row. */
#include "save_formats.h"

#include <setjmp.h>
#include <string.h>

#ifdef RTI_HAVE_PNG

#include <png.h>

typedef struct png_state {
    png_structp png;
    png_infop info;
    rt_status status; /* of the writer, when it is the reason */
    png_text *texts;
    size_t text_count;
    jmp_buf failed;
} png_state;

static void png_failed(png_structp png, png_const_charp message)
{
    rti_saver *s = png_get_error_ptr(png);
    png_state *p = s->state;
    if (!p->status)
        p->status = rti_fail(s->ctx, RT_ERROR_IO, "%s: libpng cannot write it: %s", s->name, message);
    longjmp(p->failed, 1);
}

static void png_warned(png_structp png, png_const_charp message)
{
    rti_saver *s = png_get_error_ptr(png);
    rti_log(s->ctx, RT_LOG_WARNING, "%s: %s", s->name, message);
}

static void png_put(png_structp png, png_bytep data, size_t size)
{
    rti_saver *s = png_get_io_ptr(png);
    png_state *p = s->state;
    p->status = rti_writer_write(s->out, data, size);
    if (p->status)
        longjmp(p->failed, 1);
}

static void png_sync(png_structp png)
{
    (void)png;
}

/* libpng frees without telling the size, so it stands before the block. */
static png_voidp png_take(png_structp png, png_alloc_size_t size)
{
    rti_saver *s = png_get_mem_ptr(png);
    size_t total;
    if (!rti_add_size(size, 16, &total))
        return NULL;
    unsigned char *block = rti_alloc(s->ctx, total);
    if (!block) {
        rti_fail_memory(s->ctx, s->name, total);
        ((png_state *)s->state)->status = RT_ERROR_MEMORY;
        return NULL;
    }
    memcpy(block, &total, sizeof total);
    return block + 16;
}

static void png_give(png_structp png, png_voidp ptr)
{
    rti_saver *s = png_get_mem_ptr(png);
    size_t total;
    if (!ptr)
        return;
    memcpy(&total, (unsigned char *)ptr - 16, sizeof total);
    rti_free(s->ctx, (unsigned char *)ptr - 16, total);
}

static bool is_ascii(const char *s)
{
    for (; *s; s++)
        if ((unsigned char)*s >= 0x80)
            return false;
    return true;
}

static rt_status make_texts(rti_saver *s, png_state *p)
{
    if (s->text_count == 0)
        return RT_OK;
    size_t size;
    p->texts = rti_mul_size(s->text_count, sizeof *p->texts, &size) ? rti_alloc_zero(s->ctx, size) : NULL;
    if (!p->texts)
        return rti_fail_memory(s->ctx, s->name, s->text_count * sizeof *p->texts);
    p->text_count = s->text_count;
    for (size_t i = 0; i < s->text_count; i++) {
        bool ascii = is_ascii(s->texts[i].value);
        p->texts[i].compression =
            ascii ? PNG_TEXT_COMPRESSION_NONE : PNG_ITXT_COMPRESSION_NONE; /* tEXt is Latin-1, iTXt is UTF-8 */
        p->texts[i].key = (png_charp)(uintptr_t)s->texts[i].key;           /* libpng copies it */
        p->texts[i].text = (png_charp)(uintptr_t)s->texts[i].value;
    }
    return RT_OK;
}

static rt_status png_write_head(rti_saver *s, png_state *p)
{
    int colour = s->channels == 4 ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB;
    if (setjmp(p->failed))
        return p->status;
    p->info = png_create_info_struct(p->png);
    if (!p->info)
        return p->status ? p->status : rti_fail_memory(s->ctx, s->name, sizeof(png_infop));
    png_set_write_fn(p->png, s, png_put, png_sync);
    png_set_user_limits(p->png, 0x7fffffff, 0x7fffffff);
    png_set_IHDR(p->png, p->info, s->width, s->height, (int)s->bits, colour, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_set_filter(p->png, PNG_FILTER_TYPE_BASE, PNG_FAST_FILTERS); /* a quarter less time than by all, no more bytes */
    png_set_compression_level(p->png, 4); /* of zlib's 9: half the time of its default for 5% more bytes */
    png_set_sRGB_gAMA_and_cHRM(p->png, p->info, PNG_sRGB_INTENT_PERCEPTUAL);
    if (p->text_count)
        png_set_text(p->png, p->info, p->texts, (int)p->text_count);
    png_write_info(p->png, p->info);
    if (s->bits == 16 && *(const uint8_t *)&(uint16_t){1})
        png_set_swap(p->png);
    return RT_OK;
}

static rt_status png_begin(rti_saver *s)
{
    png_state *p = rti_alloc_zero(s->ctx, sizeof *p);
    s->state = p;
    if (!p)
        return rti_fail_memory(s->ctx, s->name, sizeof *p);
    rt_status status = make_texts(s, p);
    if (status)
        return status;
    if (setjmp(p->failed) == 0)
        p->png = png_create_write_struct_2(PNG_LIBPNG_VER_STRING, s, png_failed, png_warned, s, png_take, png_give);
    if (!p->png)
        return p->status ? p->status : rti_fail(s->ctx, RT_ERROR_MEMORY, "%s: libpng could not be started", s->name);
    return png_write_head(s, p);
}

static rt_status png_row(rti_saver *s, const void *samples)
{
    png_state *p = s->state;
    if (setjmp(p->failed))
        return p->status;
    png_write_row(p->png, samples);
    return RT_OK;
}

static rt_status png_end(rti_saver *s)
{
    png_state *p = s->state;
    if (setjmp(p->failed))
        return p->status;
    png_write_end(p->png, NULL);
    return RT_OK;
}

static void png_dispose(rti_saver *s)
{
    png_state *p = s->state;
    if (!p)
        return;
    if (p->png)
        png_destroy_write_struct(&p->png, &p->info);
    rti_free(s->ctx, p->texts, p->text_count * sizeof *p->texts);
    rti_free(s->ctx, p, sizeof *p);
}

const rti_save_format rti_save_png = {"png", 1048576, true, true, false, png_begin, png_row, png_end, png_dispose};

#endif
