/* Structural similarity. Source: Z. Wang, A. C. Bovik, H. R. Sheikh, E. P. Simoncelli, "Image quality assessment: from error
 * visibility to structural similarity", IEEE Transactions on Image Processing 13 (4), 2004. */
#include <math.h>
#include <string.h>

#include "image.h"

#define RADIUS  5u
#define WINDOW  (2 * RADIUS + 1)
#define MOMENTS 5u /* a, b, aa, bb, ab */

/* One image row after another: `luma` are the two rows of values, `rows` the window's last rows, weighed along x. */
typedef struct windows {
    const rt_image *a, *b;
    uint32_t width, height;
    double weight[WINDOW]; /* they sum to 1 */
    double *luma;          /* [2][width] */
    double *rows;          /* [WINDOW][MOMENTS][width] */
} windows;

static double encode(float x)
{
    double c = x > 0.0f ? (x < 1.0f ? (double)x : 1.0) : 0.0; /* NaN counts as black */
    return c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1.0 / 2.4) - 0.055;
}

static void read_luma(const rt_image *image, uint32_t y, double *to)
{
    const float *p = rti_image_row(image, y);
    for (uint32_t x = 0; x < image->width; x++, p += 4)
        to[x] = 0.2126 * encode(p[0]) + 0.7152 * encode(p[1]) + 0.0722 * encode(p[2]);
}

static double *row_of(const windows *w, uint32_t y, uint32_t moment)
{
    return w->rows + ((size_t)(y % WINDOW) * MOMENTS + moment) * w->width;
}

static void weigh_row(windows *w, uint32_t y)
{
    const double *a = w->luma, *b = w->luma + w->width;
    read_luma(w->a, y, w->luma);
    read_luma(w->b, y, w->luma + w->width);
    for (uint32_t x = 0; x < w->width; x++) {
        uint32_t from = x < RADIUS ? 0 : x - RADIUS, to = w->width - x > RADIUS ? x + RADIUS : w->width - 1;
        double sum[MOMENTS] = {0}, total = 0;
        for (uint32_t i = from; i <= to; i++) {
            double g = w->weight[i + RADIUS - x];
            total += g;
            sum[0] += g * a[i];
            sum[1] += g * b[i];
            sum[2] += g * a[i] * a[i];
            sum[3] += g * b[i] * b[i];
            sum[4] += g * a[i] * b[i];
        }
        for (uint32_t m = 0; m < MOMENTS; m++)
            row_of(w, y, m)[x] = sum[m] / total;
    }
}

static double local(const windows *w, uint32_t x, uint32_t y)
{
    const double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
    uint32_t from = y < RADIUS ? 0 : y - RADIUS, to = w->height - y > RADIUS ? y + RADIUS : w->height - 1;
    double m[MOMENTS] = {0}, total = 0;
    for (uint32_t i = from; i <= to; i++) {
        double g = w->weight[i + RADIUS - y];
        total += g;
        for (uint32_t k = 0; k < MOMENTS; k++)
            m[k] += g * row_of(w, i, k)[x];
    }
    for (uint32_t k = 0; k < MOMENTS; k++)
        m[k] /= total;
    double va = m[2] - m[0] * m[0], vb = m[3] - m[1] * m[1], cov = m[4] - m[0] * m[1];
    va = va > 0 ? va : 0;
    vb = vb > 0 ? vb : 0;
    return (2 * m[0] * m[1] + c1) * (2 * cov + c2) / ((m[0] * m[0] + m[1] * m[1] + c1) * (va + vb + c2));
}

static double all_windows(windows *w, rt_image *map)
{
    uint32_t next = 0;
    bool inside = w->width >= WINDOW && w->height >= WINDOW;
    double sum = 0;
    uint64_t count = 0;
    for (uint32_t y = 0; y < w->height; y++) {
        bool in_y = !inside || (y >= RADIUS && y + RADIUS < w->height);
        for (; next < w->height && next <= y + RADIUS; next++)
            weigh_row(w, next);
        for (uint32_t x = 0; x < w->width; x++) {
            bool counts = in_y && (!inside || (x >= RADIUS && x + RADIUS < w->width));
            double s = counts || map ? local(w, x, y) : 0;
            if (map) {
                float *out = rti_image_row(map, y) + 4 * (size_t)x;
                out[0] = out[1] = out[2] = (float)s;
                out[3] = 1.0f;
            }
            sum += counts ? s : 0;
            count += counts;
        }
    }
    return sum / (double)count;
}

rt_status rt_image_ssim(const rt_image *a, const rt_image *b, double *ssim, rt_image **map)
{
    RTI_NEED_TO_MAKE(map, a);
    RTI_NEED_TO_MAKE(map, b);
    static const char what[] = "rt_image_ssim";
    windows w = {.a = a, .b = b, .width = a->width, .height = a->height};
    size_t luma = 2 * (size_t)a->width * sizeof(double), rows = WINDOW * MOMENTS * (size_t)a->width * sizeof(double);
    rt_image *made = NULL;
    rt_status status = RT_OK;
    double total = 0;
    if (map)
        *map = NULL;
    if (a->width != b->width || a->height != b->height)
        return rti_fail(a->ctx, RT_ERROR_ARGUMENT, "%s: the sizes differ: %u x %u and %u x %u", what, a->width, a->height,
                        b->width, b->height);
    for (uint32_t i = 0; i < WINDOW; i++) {
        double d = (double)i - RADIUS;
        w.weight[i] = exp(-d * d / (2 * 1.5 * 1.5));
        total += w.weight[i];
    }
    for (uint32_t i = 0; i < WINDOW; i++)
        w.weight[i] /= total;
    if (map)
        status = rt_image_create(a->ctx, a->width, a->height, &made);
    if (status != RT_OK)
        return status;
    w.luma = rti_alloc(a->ctx, luma);
    w.rows = rti_alloc(a->ctx, rows);
    if (w.luma && w.rows) {
        double s = all_windows(&w, made);
        if (ssim)
            *ssim = s;
    } else {
        status = rti_fail_memory(a->ctx, what, luma + rows);
    }
    rti_free(a->ctx, w.luma, luma);
    rti_free(a->ctx, w.rows, rows);
    if (status != RT_OK)
        rt_image_destroy(made);
    else if (map)
        *map = made;
    return status;
}
