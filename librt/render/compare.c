/* Two images against each other, and one image as a hash. */
#include <math.h>
#include <string.h>

#include "image.h"

void rt_image_hash(const rt_image *image, char text[33])
{
    rti_hasher h;
    uint32_t size[2] = {image->width, image->height};
    rti_hasher_init(&h);
    rti_hasher_add(&h, size, sizeof size);
    for (uint32_t y = 0; y < image->height; y++)
        rti_hasher_add(&h, rti_image_row(image, y), (size_t)image->width * 4 * sizeof(float));
    rti_hash_text(text, rti_hasher_end(&h));
}

static double srgb_encode(float x)
{
    double c = x > 0.0f ? (x < 1.0f ? (double)x : 1.0) : 0.0; /* NaN counts as black */
    return c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1.0 / 2.4) - 0.055;
}

typedef struct totals {
    double max_abs, sum;
} totals;

/* One pixel; returns whether it differs. */
static bool compare_pixel(const float *a, const float *b, bool eight_bit, totals *t)
{
    bool differs = !eight_bit && memcmp(a, b, 4 * sizeof(float)) != 0;
    if (memcmp(a, b, 4 * sizeof(float)) == 0)
        return false;
    for (int c = 0; c < 3; c++) {
        double ea = srgb_encode(a[c]), eb = srgb_encode(b[c]), d = fabs(ea - eb);
        if (eight_bit && floor(ea * 255.0 + 0.5) != floor(eb * 255.0 + 0.5))
            differs = true;
        if (d > t->max_abs)
            t->max_abs = d;
        t->sum += d * d;
    }
    if (eight_bit && floor((double)a[3] * 255.0 + 0.5) != floor((double)b[3] * 255.0 + 0.5))
        differs = true;
    return differs;
}

static void write_map(float *out, const float *a, const float *b)
{
    for (int c = 0; c < 3; c++)
        out[c] = fabsf(a[c] - b[c]);
    out[3] = 1.0f;
}

rt_status rt_image_compare(const rt_image *a, const rt_image *b, rt_image_difference *difference, rt_image **difference_map)
{
    RTI_NEED_TO_MAKE(difference_map, a);
    RTI_NEED_TO_MAKE(difference_map, b);
    static const char what[] = "rt_image_compare";
    rt_image_difference d = {0};
    rt_image *map = NULL;
    totals t = {0};
    bool eight_bit = a->eight_bit && b->eight_bit;
    double mean;
    if (difference_map)
        *difference_map = NULL;
    if (a->width != b->width || a->height != b->height)
        return rti_fail(a->ctx, RT_ERROR_ARGUMENT, "%s: the sizes differ: %u x %u and %u x %u", what, a->width, a->height,
                        b->width, b->height);
    if (difference_map) {
        rt_status status = rt_image_create(a->ctx, a->width, a->height, &map);
        if (status != RT_OK)
            return status;
    }
    for (uint32_t y = 0; y < a->height; y++) {
        const float *ra = rti_image_row(a, y), *rb = rti_image_row(b, y);
        for (uint32_t x = 0; x < a->width; x++) {
            if (map)
                write_map(rti_image_row(map, y) + 4 * x, ra + 4 * x, rb + 4 * x);
            if (!compare_pixel(ra + 4 * x, rb + 4 * x, eight_bit, &t))
                continue;
            if (d.differing_pixels++ == 0) {
                d.first_x = x;
                d.first_y = y;
            }
        }
    }
    mean = t.sum / (3.0 * a->width * a->height);
    d.max_abs = t.max_abs;
    d.mse = mean;
    d.psnr = mean > 0.0 ? -10.0 * log10(mean) : INFINITY;
    if (difference)
        *difference = d;
    if (difference_map)
        *difference_map = map;
    return RT_OK;
}
