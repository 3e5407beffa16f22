/* Colour maps: from a value to a colour whose lightness rises evenly. Viridis and magma are those of S. van der Walt and N. Smith
 * (2015, CC0), here as ten of their colours and a curve through them that stays within 1/64 of theirs. */
#include <math.h>

#include "../scene/import/srgb.h"
#include "image.h"
#include "librt/draw.h"

#define KNOTS 10

static const uint8_t knots[][KNOTS][3] = {
    [RT_COLOR_MAP_VIRIDIS] = {{68, 1, 84},
                              {72, 40, 120},
                              {62, 74, 137},
                              {49, 104, 142},
                              {38, 130, 142},
                              {31, 158, 137},
                              {53, 183, 121},
                              {109, 205, 89},
                              {180, 222, 44},
                              {253, 231, 37}},
    [RT_COLOR_MAP_MAGMA] = {{0, 0, 4},
                            {24, 15, 62},
                            {69, 16, 119},
                            {114, 31, 129},
                            {159, 47, 127},
                            {205, 64, 113},
                            {241, 96, 93},
                            {253, 149, 103},
                            {254, 201, 141},
                            {252, 253, 191}},
};

/* Catmull and Rom's curve; at the ends the last step is repeated. */
static double curve(const uint8_t (*k)[3], int i, int c, double t)
{
    double p1 = k[i][c], p2 = k[i + 1][c];
    double p0 = i > 0 ? k[i - 1][c] : 2 * p1 - p2, p3 = i + 2 < KNOTS ? k[i + 2][c] : 2 * p2 - p1;
    return p1 + 0.5 * t * (p2 - p0 + t * (2 * p0 - 5 * p1 + 4 * p2 - p3 + t * (3 * (p1 - p2) + p3 - p0)));
}

rt_vec3 rt_color_map_at(rt_color_map map, float x)
{
    double at = x > 0 ? (x < 1 ? (double)x : 1.0) : 0.0;
    double c[3];
    int i;
    if (map != RT_COLOR_MAP_VIRIDIS && map != RT_COLOR_MAP_MAGMA)
        return (rt_vec3){(float)rti_srgb_decode(at), (float)rti_srgb_decode(at), (float)rti_srgb_decode(at)};
    at *= KNOTS - 1;
    i = at < KNOTS - 2 ? (int)at : KNOTS - 2;
    for (int k = 0; k < 3; k++)
        c[k] = rti_srgb_decode(curve(knots[map], i, k, at - i) / 255);
    return (rt_vec3){(float)c[0], (float)c[1], (float)c[2]};
}

rt_status rt_image_color_map(const rt_image *image, rt_color_map map, float low, float high, rt_image **colored)
{
    RTI_NEED_TO_MAKE(colored, image);
    char a[32], b[32];
    rt_status status;
    *colored = NULL;
    if (!isfinite(low) || !isfinite(high) || !(low < high))
        return rti_fail(image->ctx, RT_ERROR_ARGUMENT, "rt_image_color_map: low is %s and high is %s; low must be below high",
                        rti_num(a, low), rti_num(b, high));
    status = rt_image_create(image->ctx, image->width, image->height, colored);
    if (status != RT_OK)
        return status;
    for (uint32_t y = 0; y < image->height; y++) {
        const float *p = rti_image_row(image, y);
        float *to = rti_image_row(*colored, y);
        for (uint32_t x = 0; x < image->width; x++, p += 4, to += 4) {
            float v = p[0] > p[1] ? p[0] : p[1];
            rt_vec3 c = rt_color_map_at(map, ((v > p[2] ? v : p[2]) - low) / (high - low));
            to[0] = c.x;
            to[1] = c.y;
            to[2] = c.z;
            to[3] = p[3];
        }
    }
    return RT_OK;
}
