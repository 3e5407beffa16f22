/* Radiance HDR (RGBE), flat or run-length coded, with rows in any of the eight orders that keep them horizontal ("-Y h +X w" and
 * its mirrors). Source: G. Ward, "Real Pixels", Graphics Gems II, 1991, and the file format's manual page. */
#include "image_formats.h"

#include <string.h>

typedef struct hdr_head {
    uint32_t width, height;
    bool bottom_up, leftwards;
    size_t data_at;
} hdr_head;

/* The line at *at without its newline; false when the file ends first. */
static bool next_line(const rti_image_source *src, size_t *at, const char **line, size_t *length)
{
    const char *start = (const char *)src->bytes + *at;
    const char *end = *at < src->size ? memchr(start, '\n', src->size - *at) : NULL;
    if (!end)
        return false;
    *line = start;
    *length = (size_t)(end - start);
    *at += *length + 1;
    return true;
}

/* "-Y 512 +X 768": one axis of it. */
static bool read_axis(const char **s, const char *end, char axis, bool *positive, uint32_t *size)
{
    int64_t n;
    while (*s < end && **s == ' ')
        (*s)++;
    if (end - *s < 3 || ((*s)[0] != '-' && (*s)[0] != '+') || (*s)[1] != axis || (*s)[2] != ' ')
        return false;
    *positive = (*s)[0] == '+';
    *s += 3;
    if (!rti_parse_int(s, end, &n) || n < 1 || n > UINT32_MAX)
        return false;
    *size = (uint32_t)n;
    return true;
}

static rt_status read_head(const rti_image_source *src, hdr_head *h)
{
    static const char rgbe[] = "FORMAT=32-bit_rle_rgbe", xyze[] = "FORMAT=32-bit_rle_xyze";
    const char *line = NULL;
    size_t at = 0, length = 0;
    do {
        if (!next_line(src, &at, &line, &length))
            return rti_image_cut(src, "HDR", src->size + 1);
        if (length >= sizeof xyze - 1 && memcmp(line, xyze, sizeof xyze - 1) == 0)
            return rti_fail(src->ctx, RT_ERROR_UNSUPPORTED,
                            "%s: HDR files of XYZE colours are not read; convert it to RGBE (ra_xyze -r)", src->name);
        if (length >= 7 && memcmp(line, "FORMAT=", 7) == 0 &&
            (length < sizeof rgbe - 1 || memcmp(line, rgbe, sizeof rgbe - 1) != 0))
            return rti_image_broken(src, (size_t)(line - (const char *)src->bytes),
                                    "an HDR file of another format than 32-bit_rle_rgbe");
    } while (length > 0);
    size_t line_at = at;
    if (!next_line(src, &at, &line, &length))
        return rti_image_cut(src, "HDR", src->size + 1);
    const char *s = line;
    bool y_up, x_right;
    if (!read_axis(&s, line + length, 'Y', &y_up, &h->height) || !read_axis(&s, line + length, 'X', &x_right, &h->width))
        return rti_image_broken(src, line_at, "expected a line as '-Y HEIGHT +X WIDTH' here");
    h->bottom_up = y_up;
    h->leftwards = !x_right;
    h->data_at = at;
    return RT_OK;
}

static const char cut_row[] = "the file is cut within a row", long_run[] = "a run goes over the end of its row";

/* Flat pixels; one of the mantissas 1 1 1 repeats the pixel before it (the files of before 1991), for real ones have a mantissa
 * of 128 or more. Rows: row[4 * width], NULL: only walk. Returns NULL, or what is wrong. */
static const char *read_flat(const rti_image_source *src, uint32_t width, size_t *at, uint8_t *row)
{
    const uint8_t *p = src->bytes;
    uint32_t shift = 0;
    for (uint32_t x = 0; x < width; *at += 4) {
        if (src->size - *at < 4)
            return cut_row;
        if (x > 0 && p[*at] == 1 && p[*at + 1] == 1 && p[*at + 2] == 1) {
            uint64_t count = shift < 32 ? (uint64_t)p[*at + 3] << shift : UINT64_MAX;
            if (count > width - x)
                return long_run;
            for (uint64_t i = 0; row && i < count; i++)
                memcpy(row + 4 * (x + i), row + 4 * (size_t)(x - 1), 4);
            x += (uint32_t)count;
            shift += 8;
        } else {
            if (row)
                memcpy(row + 4 * (size_t)x, p + *at, 4);
            x++;
            shift = 0;
        }
    }
    return NULL;
}

static const char *read_packed(const rti_image_source *src, uint32_t width, size_t *at, uint8_t *row)
{
    const uint8_t *p = src->bytes;
    if (rti_be16(p + *at + 2) != width)
        return "a row has another width than the image";
    *at += 4;
    for (uint32_t c = 0; c < 4; c++) {
        for (uint32_t x = 0; x < width;) {
            if (src->size - *at < 2)
                return cut_row;
            uint32_t count = p[(*at)++];
            bool run = count > 128;
            count = run ? count - 128 : count;
            if (count == 0 || count > width - x)
                return long_run;
            if (src->size - *at < (run ? 1 : count))
                return cut_row;
            for (uint32_t i = 0; row && i < count; i++)
                row[4 * (size_t)(x + i) + c] = p[*at + (run ? 0 : i)];
            *at += run ? 1 : count;
            x += count;
        }
    }
    return NULL;
}

static const char *read_row(const rti_image_source *src, uint32_t width, size_t *at, uint8_t *row)
{
    const uint8_t *p = src->bytes + *at;
    bool packed = width >= 8 && width < 32768 && src->size - *at >= 4 && p[0] == 2 && p[1] == 2 && p[2] < 128;
    return packed ? read_packed(src, width, at, row) : read_flat(src, width, at, row);
}

/* 2^(e - 136) exactly; below the float range it rounds to 0 by itself. */
static float scale_of(uint8_t e)
{
    double s = 1.0;
    int n = (int)e - 136;
    for (; n < 0; n++)
        s *= 0.5;
    for (; n > 0; n--)
        s *= 2.0;
    return (float)s;
}

static rt_status decode_rows(const rti_image_source *src, const hdr_head *h, uint8_t *row, rti_pixels *out)
{
    float scale[256];
    for (int e = 0; e < 256; e++)
        scale[e] = e ? scale_of((uint8_t)e) : 0.0f;
    size_t at = h->data_at;
    for (uint32_t y = 0; y < h->height; y++) {
        const char *wrong = read_row(src, h->width, &at, row);
        if (wrong)
            return rti_image_broken(src, at, "%s", wrong);
        float *to = (float *)out->data + 3 * (size_t)h->width * (h->bottom_up ? h->height - 1 - y : y);
        for (uint32_t x = 0; x < h->width; x++) {
            const uint8_t *p = row + 4 * (size_t)(h->leftwards ? h->width - 1 - x : x);
            for (int c = 0; c < 3; c++)
                to[3 * (size_t)x + c] = (float)p[c] * scale[p[3]];
        }
    }
    return RT_OK;
}

rt_status rti_hdr_decode(const rti_image_source *src, rti_pixels *out)
{
    hdr_head h = {0};
    rt_status status = read_head(src, &h);
    if (status)
        return status;
    size_t at = h.data_at;
    for (uint32_t y = 0; y < h.height; y++) { /* to the end before memory is taken */
        const char *wrong = read_row(src, h.width, &at, NULL);
        if (wrong)
            return rti_image_broken(src, at, "%s (row %u of %u)", wrong, (unsigned)y + 1, (unsigned)h.height);
    }
    size_t row_size = 4 * (size_t)h.width;
    status = rti_image_begin(src, h.width, h.height, 3, true, out);
    if (status)
        return status;
    uint8_t *row = rti_alloc(src->ctx, row_size);
    if (!row)
        return rti_fail_memory(src->ctx, src->name, row_size);
    status = decode_rows(src, &h, row, out);
    rti_free(src->ctx, row, row_size);
    return status;
}
