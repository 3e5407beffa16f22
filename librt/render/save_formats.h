/* What a file format has to offer to the row writer. */
#ifndef RTI_SAVE_FORMATS_H
#define RTI_SAVE_FORMATS_H

#include "save.h"

typedef struct rti_save_format rti_save_format;

typedef struct rti_saver {
    rt_context *ctx;
    const rti_save_format *format;
    rti_writer *out;
    char *name; /* of the file, escaped for messages */
    uint32_t width, height;
    uint32_t channels; /* 3, or 4 with alpha */
    uint32_t bits;     /* of a sample: 8, 16 (in machine order); 32: floats */
    uint32_t quality;
    const rti_text *texts;
    size_t text_count;
    void *state; /* the format's own */
} rti_saver;

struct rti_save_format {
    const char *name;
    uint32_t max_side;
    bool alpha;  /* can hold it */
    bool deep;   /* 16 bits too */
    bool linear; /* floats instead of encoded samples */
    /* begin: what stands before the rows. row: uint8_t, uint16_t or float [width * channels]. end: what follows them. dispose:
     * frees the state, called once after begin, whatever it returned. */
    rt_status (*begin)(rti_saver *s);
    rt_status (*row)(rti_saver *s, const void *samples);
    rt_status (*end)(rti_saver *s);
    void (*dispose)(rti_saver *s);
};

extern const rti_save_format rti_save_png, rti_save_png_plain, rti_save_bmp, rti_save_tga, rti_save_hdr, rti_save_jpg;

/* rti_rows_open with the format given: tests write PNG both ways. */
rt_status rti_rows_open_as(rt_context *ctx, const rti_save_format *format, const char *path, uint32_t width, uint32_t height,
                           const rt_save_desc *desc, const rti_text *texts, size_t text_count, rti_row_writer **writer);

static inline void rti_put_le16(uint8_t *p, uint32_t v)
{
    p[0] = (uint8_t)v;
    p[1] = (uint8_t)(v >> 8);
}

static inline void rti_put_le32(uint8_t *p, uint32_t v)
{
    rti_put_le16(p, v);
    rti_put_le16(p + 2, v >> 16);
}

static inline void rti_put_be32(uint8_t *p, uint32_t v)
{
    p[0] = (uint8_t)(v >> 24);
    p[1] = (uint8_t)(v >> 16);
    p[2] = (uint8_t)(v >> 8);
    p[3] = (uint8_t)v;
}

#endif
