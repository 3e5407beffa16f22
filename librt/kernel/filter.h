/* Pixel filters by importance sampling: a sample's place in the pixel is drawn from the filter, and all samples weigh the same.
 */
#ifndef RTK_FILTER_H
#define RTK_FILTER_H

#include "maths.h"
#include "random2.h"

/* Offset from the pixel's middle, box of the given width. */
RTK_FN rtk_uv rtk_filter_box(rtk_uv u, float width)
{
    rtk_uv o;
    o.x = (u.x - 0.5f) * width;
    o.y = (u.y - 0.5f) * width;
    return o;
}

/* Round Gaussian with standard deviation width / 4, cut at radius width: Box and Muller's transform over the kept part. */
RTK_FN rtk_uv rtk_filter_gaussian(rtk_uv u, float width)
{
    rtk_uv o;
    float s, c, r = 0.25f * width * rtk_sqrt(-2.0f * rtk_log(1.0f - u.x * 0.99966454f)); /* 1 - exp(-8) */
    rtk_sincos(2.0f * RTK_PI * u.y, &s, &c);
    o.x = r * c;
    o.y = r * s;
    return o;
}

#endif
