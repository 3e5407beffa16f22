/* An image of another size: each output pixel is a weighted mean of input pixels, first along rows, then along columns. */
#include <string.h>

#include "../kernel/maths.h"
#include "image.h"
#include "librt/draw.h"

static const char what[] = "rt_image_resample";

/* ---- filters: weight at distance x, in units of the coarser of the two grids ---- */

static float box(float x)
{
    return x >= -0.5f && x < 0.5f ? 1.0f : 0.0f;
}

static float mitchell(float x)
{
    x = rtk_fabs(x);
    if (x < 1.0f)
        return (7.0f * x * x * x - 12.0f * x * x + 16.0f / 3.0f) / 6.0f;
    if (x < 2.0f)
        return (-7.0f / 3.0f * x * x * x + 12.0f * x * x - 20.0f * x + 32.0f / 3.0f) / 6.0f;
    return 0.0f;
}

static float sinc(float x)
{
    float p = 3.14159265f * x;
    return rtk_fabs(x) < 1e-4f ? 1.0f : rtk_sin(p) / p;
}

static float lanczos(float x)
{
    return rtk_fabs(x) < 3.0f ? sinc(x) * sinc(x / 3.0f) : 0.0f;
}

typedef struct shape {
    float (*weight)(float x);
    float radius;
} shape;

static const shape shapes[] = {{mitchell, 2.0f}, {box, 0.5f}, {mitchell, 2.0f}, {lanczos, 3.0f}};

/* ---- one side: which inputs each output sees, and with what weights ---- */

typedef struct side {
    uint32_t from, to, most; /* input and output pixels, inputs an output at most */
    uint32_t *first, *count; /* [to] */
    float *weights;          /* [to * most] */
} side;

static void side_free(rt_context *ctx, side *s)
{
    rti_free(ctx, s->first, sizeof *s->first * s->to);
    rti_free(ctx, s->count, sizeof *s->count * s->to);
    rti_free(ctx, s->weights, sizeof *s->weights * s->to * s->most);
}

/* What a box covers of pixel i: the exact part, so that a mean over 2.5 pixels is one. */
static double overlap(double low, double high, uint32_t i)
{
    double a = low > i ? low : i, b = high < i + 1.0 ? high : i + 1.0;
    return b > a ? b - a : 0.0;
}

static void side_fill(side *s, rt_resample filter)
{
    double scale = (double)s->from / s->to, wide = scale > 1.0 ? scale : 1.0;
    double reach = (double)shapes[filter].radius * (filter == RT_RESAMPLE_BOX ? scale : wide);
    for (uint32_t i = 0; i < s->to; i++) {
        double center = (i + 0.5) * scale, low = center - reach, high = center + reach;
        uint32_t a = low > 0.0 ? (uint32_t)low : 0, b = high < s->from ? (uint32_t)high + 1u : s->from;
        float *w = s->weights + (size_t)i * s->most;
        b = b > s->from ? s->from : b;
        b = b - a > s->most ? a + s->most : b;
        s->first[i] = a;
        s->count[i] = b - a;
        for (uint32_t k = a; k < b; k++)
            w[k - a] = filter == RT_RESAMPLE_BOX ? (float)overlap(low, high, k)
                                                 : shapes[filter].weight((float)((k + 0.5 - center) / wide));
    }
}

static rt_status side_make(rt_context *ctx, uint32_t from, uint32_t to, rt_resample filter, side *s)
{
    double scale = (double)from / to, reach = (double)shapes[filter].radius * (scale > 1.0 ? scale : 1.0);
    *s = (side){.from = from, .to = to, .most = (uint32_t)(2.0 * reach) + 3u};
    if (s->most > from)
        s->most = from;
    s->first = rti_alloc_array(ctx, to, sizeof *s->first);
    s->count = rti_alloc_array(ctx, to, sizeof *s->count);
    s->weights = rti_alloc_array(ctx, (size_t)to * s->most, sizeof *s->weights);
    if (!s->first || !s->count || !s->weights)
        return rti_fail_memory(ctx, what, (size_t)to * s->most * sizeof *s->weights);
    side_fill(s, filter);
    return RT_OK;
}

/* ---- the means ---- */

/* One output pixel from inputs `step` floats apart. Negative weights may overshoot: the result stays in the range of what it was
 * made of. */
static void mean(const float *in, size_t step, const float *weights, uint32_t count, float *out)
{
    for (int c = 0; c < 4; c++) {
        float sum = 0.0f, total = 0.0f, low = RTK_INF, high = -RTK_INF;
        for (uint32_t k = 0; k < count; k++) {
            float v = in[k * step + (size_t)c];
            if (!(rtk_fabs(v) < RTK_INF) || weights[k] == 0.0f)
                continue;
            sum += v * weights[k];
            total += weights[k];
            low = v < low ? v : low;
            high = v > high ? v : high;
        }
        float v = total > 0.0f ? sum / total : 0.0f;
        out[c] = !(low <= high) ? 0.0f : v < low ? low : v > high ? high : v;
    }
}

/* Rows get their width first: `between` holds as many rows as the image had. */
static rt_status squeeze(const rt_image *image, const side *across, const side *down, rt_image *out)
{
    rt_context *ctx = image->ctx;
    size_t row = (size_t)across->to * 4, size = row * sizeof(float);
    if (!rti_mul_size(size, image->height, &size))
        return rti_fail(ctx, RT_ERROR_MEMORY, "%s: the image is too large for this machine", what);
    float *between = rti_alloc(ctx, size);
    if (!between)
        return rti_fail_memory(ctx, what, size);
    for (uint32_t y = 0; y < image->height; y++) {
        const float *in = rti_image_row(image, y);
        for (uint32_t x = 0; x < across->to; x++)
            mean(in + (size_t)across->first[x] * 4, 4, across->weights + (size_t)x * across->most, across->count[x],
                 between + (size_t)y * row + (size_t)x * 4);
    }
    for (uint32_t y = 0; y < down->to; y++) {
        for (uint32_t x = 0; x < across->to; x++)
            mean(between + (size_t)down->first[y] * row + (size_t)x * 4, row, down->weights + (size_t)y * down->most,
                 down->count[y], rti_image_row(out, y) + (size_t)x * 4);
    }
    rti_free(ctx, between, size);
    return RT_OK;
}

static void copy_rows(const rt_image *image, rt_image *out)
{
    for (uint32_t y = 0; y < image->height; y++)
        memcpy(rti_image_row(out, y), rti_image_row(image, y), (size_t)image->width * 4 * sizeof(float));
}

rt_status rt_image_resample(const rt_image *image, uint32_t width, uint32_t height, rt_resample filter, rt_image **resampled)
{
    RTI_NEED_TO_MAKE(resampled, image);
    rt_context *ctx = image->ctx;
    side across = {0}, down = {0};
    rt_image *out = NULL;
    if (!resampled)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: resampled is NULL; it receives the new image", what);
    *resampled = NULL;
    if ((unsigned)filter >= RTI_COUNT(shapes))
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: filter is %d; it must be one of rt_resample", what, (int)filter);
    rt_status status = rti_image_check_size(ctx, what, width, height);
    if (status == RT_OK)
        status = rt_image_create(ctx, width, height, &out);
    if (status == RT_OK && width == image->width && height == image->height) {
        copy_rows(image, out);
    } else if (status == RT_OK) {
        rti_fpenv env = rti_fp_enter();
        status = side_make(ctx, image->width, width, filter, &across);
        if (status == RT_OK)
            status = side_make(ctx, image->height, height, filter, &down);
        if (status == RT_OK)
            status = squeeze(image, &across, &down, out);
        rti_fp_leave(env);
        side_free(ctx, &across);
        side_free(ctx, &down);
    }
    if (status != RT_OK) {
        rt_image_destroy(out);
        return status;
    }
    *resampled = out;
    return RT_OK;
}
