/* Rectangles, pictures and text put into an image. */
#include <math.h>
#include <string.h>

#include "../kernel/vec.h"
#include "font.h"
#include "image.h"
#include "librt/draw.h"

/* The part [*a, *b) of a side of `size` pixels that [at, at + length) covers. */
static void clip(int32_t at, uint32_t length, uint32_t size, uint32_t *a, uint32_t *b)
{
    int64_t low = at, high = (int64_t)at + length;
    low = low < 0 ? 0 : low > size ? size : low;
    high = high < low ? low : high > size ? size : high;
    *a = (uint32_t)low;
    *b = (uint32_t)high;
}

void rt_image_fill(rt_image *image, int32_t x, int32_t y, uint32_t width, uint32_t height, const float rgba[4])
{
    uint32_t x0, x1, y0, y1;
    clip(x, width, image->width, &x0, &x1);
    clip(y, height, image->height, &y0, &y1);
    for (uint32_t row = y0; row < y1; row++) {
        float *p = rti_image_row(image, row);
        for (uint32_t column = x0; column < x1; column++)
            memcpy(p + 4 * (size_t)column, rgba, 4 * sizeof(float));
    }
    image->eight_bit = false;
}

rt_status rt_image_place(rt_image *image, const rt_image *other, int32_t x, int32_t y)
{
    RTI_NEED(image);
    RTI_NEED(other);
    uint32_t x0, x1, y0, y1;
    if (image == other)
        return rti_fail(image->ctx, RT_ERROR_ARGUMENT, "rt_image_place: an image cannot be placed in itself");
    clip(x, other->width, image->width, &x0, &x1);
    clip(y, other->height, image->height, &y0, &y1);
    for (uint32_t row = y0; row < y1; row++) {
        const float *from = rti_image_row(other, (uint32_t)((int64_t)row - y)) + 4 * ((int64_t)x0 - x);
        memcpy(rti_image_row(image, row) + 4 * (size_t)x0, from, (size_t)(x1 - x0) * 4 * sizeof(float));
    }
    image->eight_bit = false;
    return RT_OK;
}

/* ---- text ---- */

rt_label_desc rt_label_desc_default(void)
{
    return (rt_label_desc){
        .struct_size = sizeof(rt_label_desc), .size = 16.0f, .weight = 1.0f, .color = {1, 1, 1}, .opacity = 1.0f};
}

static bool between(float x, float low, float high)
{
    return x >= low && x <= high; /* no NaN */
}

static rt_status check(rt_context *ctx, const char *text, const rt_label_desc *d)
{
    static const char what[] = "rt_image_label";
    char number[32];
    if (!text)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: the text is NULL", what);
    if (!between(d->x, -1e6f, 1e6f) || !between(d->y, -1e6f, 1e6f))
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: the corner is out of -1e6 ... 1e6", what);
    if (!between(d->size, 4.0f, 1000.0f))
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: size is %s; it must be 4 ... 1000", what, rti_num(number, d->size));
    if (!between(d->weight, 0.25f, 4.0f))
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: weight is %s; it must be 0.25 ... 4", what, rti_num(number, d->weight));
    if (!between(d->opacity, 0.0f, 1.0f))
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: opacity is %s; it must be 0 ... 1", what, rti_num(number, d->opacity));
    return RT_OK;
}

/* How far (x, y) is from the segment, squared. */
static float distance_squared(const rti_font_segment *s, float x, float y)
{
    float dx = s->x1 - s->x0, dy = s->y1 - s->y0, px = x - s->x0, py = y - s->y0;
    float length = dx * dx + dy * dy, t = length > 0.0f ? (px * dx + py * dy) / length : 0.0f;
    t = t < 0.0f ? 0.0f : t > 1.0f ? 1.0f : t;
    px -= t * dx;
    py -= t * dy;
    return px * px + py * py;
}

static void blend(float *p, rt_vec3 color, float part)
{
    const float c[3] = {color.x, color.y, color.z};
    for (int i = 0; i < 3; i++)
        p[i] += (c[i] - p[i]) * part;
    p[3] += (1.0f - p[3]) * part;
}

/* Pixels around the glyph get as much of the colour as the strokes cover of them, taken from the distance to the nearest one. */
static void draw_glyph(rt_image *image, const rti_font_glyph *g, float x, float y, float unit, const rt_label_desc *d)
{
    rti_font_segment placed[RTI_FONT_SEGMENTS];
    float radius = 0.5f * RTI_FONT_STROKE * d->weight * unit, low[2] = {1e9f, 1e9f}, high[2] = {-1e9f, -1e9f};
    radius = radius < 0.55f ? 0.55f : radius; /* thinner ones turn grey */
    for (uint32_t i = 0; i < g->count; i++) {
        const rti_font_segment *s = &g->segments[i];
        rti_font_segment p = {x + s->x0 * unit, y + s->y0 * unit, x + s->x1 * unit, y + s->y1 * unit};
        low[0] = rtk_min(low[0], rtk_min(p.x0, p.x1));
        low[1] = rtk_min(low[1], rtk_min(p.y0, p.y1));
        high[0] = rtk_max(high[0], rtk_max(p.x0, p.x1));
        high[1] = rtk_max(high[1], rtk_max(p.y0, p.y1));
        placed[i] = p;
    }
    if (g->count == 0)
        return;
    uint32_t x0, x1, y0, y1;
    int32_t left = (int32_t)floorf(low[0] - radius - 1.0f), top = (int32_t)floorf(low[1] - radius - 1.0f);
    clip(left, (uint32_t)(high[0] - low[0] + 2.0f * radius + 4.0f), image->width, &x0, &x1);
    clip(top, (uint32_t)(high[1] - low[1] + 2.0f * radius + 4.0f), image->height, &y0, &y1);
    for (uint32_t row = y0; row < y1; row++) {
        float *p = rti_image_row(image, row);
        for (uint32_t column = x0; column < x1; column++) {
            float nearest = 1e18f, part;
            for (uint32_t i = 0; i < g->count; i++)
                nearest = rtk_min(nearest, distance_squared(&placed[i], (float)column + 0.5f, (float)row + 0.5f));
            part = radius + 0.5f - sqrtf(nearest);
            if (part > 0.0f)
                blend(p + 4 * (size_t)column, d->color, (part < 1.0f ? part : 1.0f) * d->opacity);
        }
    }
}

/* Walks over the text; draws when there is an image. Sizes are in units of the font. */
static void walk(const char *text, rt_image *image, const rt_label_desc *d, float *width, float *height)
{
    const unsigned char *at = (const unsigned char *)text;
    float unit = d->size / RTI_FONT_LINE, x = 0.0f, y = 0.0f, widest = 0.0f;
    while (*at) {
        rti_font_glyph g;
        uint32_t code = rti_font_next(&at);
        if (code == '\n') {
            x = 0.0f;
            y += RTI_FONT_LINE;
            continue;
        }
        if (code == '\t') {
            x += 4.0f * rti_font_glyph_of(' ', &g);
            continue;
        }
        float advance = rti_font_glyph_of(code, &g);
        if (image)
            draw_glyph(image, &g, d->x + (x + 0.5f * RTI_FONT_GAP) * unit, d->y + (y + RTI_FONT_TOP) * unit, unit, d);
        x += advance;
        widest = x > widest ? x : widest;
    }
    *width = widest * unit;
    *height = (y + RTI_FONT_LINE) * unit;
}

rt_status rt_image_label(rt_image *image, const char *text, const rt_label_desc *desc)
{
    RTI_NEED(image);
    rt_label_desc d = rt_label_desc_default();
    float width, height;
    rt_status status = desc ? rti_desc_take(image->ctx, "rt_label_desc", desc, &d, sizeof d) : RT_OK;
    if (status == RT_OK)
        status = check(image->ctx, text, &d);
    if (status != RT_OK)
        return status;
    rti_fpenv env = rti_fp_enter();
    walk(text, image, &d, &width, &height);
    rti_fp_leave(env);
    image->eight_bit = false;
    return RT_OK;
}

void rt_label_size(const char *text, const rt_label_desc *desc, float *width, float *height)
{
    rt_label_desc d = desc ? *desc : rt_label_desc_default();
    float w = 0.0f, h = 0.0f;
    if (text && between(d.size, 4.0f, 1000.0f)) {
        rti_fpenv env = rti_fp_enter();
        RTI_FP_HOLD(d);
        walk(text, NULL, &d, &w, &h);
        RTI_FP_HOLD(w);
        RTI_FP_HOLD(h);
        rti_fp_leave(env);
    }
    if (width)
        *width = w;
    if (height)
        *height = h;
}
