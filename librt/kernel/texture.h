/* Texture lookup: bilinear in a level, linear between two levels, all decoded to linear values. v grows upwards: row 0 of a
 * stored level is the bottom row of the image.
 *
 * The level comes from `footprint`, the length in texture space (u, v in [0, 1]) that the lookup has to cover: the width of the
 * ray's cone times rtk_surface.uv_scale. 0 asks for the finest level. Source  Williams 1983, pyramidal parametrics;
 * Akenine-Moeller et al. 2019, texture level of detail with ray cones.
 */
#ifndef RTK_TEXTURE_H
#define RTK_TEXTURE_H

#include "snapshot.h"
#include "srgb.h"

/* Index of a texel in its level: 8x8 tiles, row-major. */
RTK_FN rtk_u32 rtk_texel_index(rtk_u32 width, rtk_u32 x, rtk_u32 y)
{
    return ((y >> 3) * ((width + 7u) >> 3) + (x >> 3)) * 64u + (y & 7u) * 8u + (x & 7u);
}

RTK_FN rtk_u32 rtk_level_size(rtk_u32 size, rtk_u32 level)
{
    return rtk_umax(1u, size >> level);
}

/* One texel, decoded. x, y inside the level. */
RTK_FN void rtk_texel(rtk_texture tex, rtk_u32 level, rtk_u32 x, rtk_u32 y, float rgba[4])
{
    RT_GLOBAL const rtk_u8 *base = (RT_GLOBAL const rtk_u8 *)tex.head + tex.head->off_level[level];
    rtk_u64 index = rtk_texel_index(rtk_level_size(tex.head->width, level), x, y);
    if (tex.head->flags & RTK_TEX_FLOAT) {
        RT_GLOBAL const float *f = (RT_GLOBAL const float *)base + 4u * index;
        rgba[0] = f[0];
        rgba[1] = f[1];
        rgba[2] = f[2];
        rgba[3] = f[3];
        return;
    }
    base += 4u * index;
    rgba[3] = (float)base[3] / 255.0f;
    if (tex.head->flags & RTK_TEX_SRGB) {
        rgba[0] = rtk_srgb_table[base[0]];
        rgba[1] = rtk_srgb_table[base[1]];
        rgba[2] = rtk_srgb_table[base[2]];
    } else {
        rgba[0] = (float)base[0] / 255.0f;
        rgba[1] = (float)base[1] / 255.0f;
        rgba[2] = (float)base[2] / 255.0f;
    }
}

/* Coordinate into [0, 1] by wrapping or clamping; NaN gives 0, and so does infinity that wraps. */
RTK_FN float rtk_texture_wrap(float x, rtk_u32 flags)
{
    float w = flags & RTK_TEX_CLAMP ? (x > 1.0f ? 1.0f : x) : x - rtk_floor(x);
    return w >= 0.0f ? w : 0.0f;
}

/* Texel below or left of x (in texels, half-texel shifted) and its neighbour, with the weight of the neighbour. */
RTK_FN float rtk_texture_pair(float x, rtk_u32 size, rtk_u32 flags, rtk_u32 *i0, rtk_u32 *i1)
{
    float low = rtk_floor(x), weight = x - low;
    rtk_i32 i = (rtk_i32)low, next = i + 1, last = (rtk_i32)size - 1;
    rtk_i32 before = flags & RTK_TEX_CLAMP ? 0 : last, behind = last - before;
    *i0 = (rtk_u32)(i < 0 ? before : (i > last ? last : i));
    *i1 = (rtk_u32)(((next > last) | (next < 0)) ? behind : next);
    return weight;
}

/* Of four texels: a and b in a row, c and d above them. */
RTK_FN float rtk_texture_mix(float a, float b, float c, float d, float fx, float fy)
{
    float lo = a + fx * (b - a), hi = c + fx * (d - c);
    return lo + fy * (hi - lo);
}

/* How u and v go on beyond [0, 1]: RTK_TEX_CLAMP or not, of other flags any. */
typedef struct rtk_texture_wraps {
    rtk_u32 u, v;
} rtk_texture_wraps;

RTK_FN rtk_texture_wraps rtk_texture_wraps_of(rtk_texture tex)
{
    rtk_texture_wraps wraps;
    wraps.u = wraps.v = tex.head->flags;
    return wraps;
}

RTK_FN void rtk_texture_bilinear(rtk_texture tex, rtk_u32 level, float u, float v, rtk_texture_wraps wraps, float rgba[4])
{
    rtk_u32 w = rtk_level_size(tex.head->width, level), h = rtk_level_size(tex.head->height, level);
    rtk_u32 x0, x1, y0, y1, k;
    float fx = rtk_texture_pair(rtk_texture_wrap(u, wraps.u) * (float)w - 0.5f, w, wraps.u, &x0, &x1);
    float fy = rtk_texture_pair(rtk_texture_wrap(v, wraps.v) * (float)h - 0.5f, h, wraps.v, &y0, &y1);
    float a[4], b[4], c[4], d[4];
    rtk_texel(tex, level, x0, y0, a);
    rtk_texel(tex, level, x1, y0, b);
    rtk_texel(tex, level, x0, y1, c);
    rtk_texel(tex, level, x1, y1, d);
    for (k = 0u; k < 4u; k++)
        rgba[k] = rtk_texture_mix(a[k], b[k], c[k], d[k], fx, fy);
}

RTK_FN void rtk_texture_nearest(rtk_texture tex, float u, float v, rtk_texture_wraps wraps, float rgba[4])
{
    rtk_u32 w = tex.head->width, h = tex.head->height;
    rtk_u32 x = rtk_umin((rtk_u32)(rtk_texture_wrap(u, wraps.u) * (float)w), w - 1u);
    rtk_u32 y = rtk_umin((rtk_u32)(rtk_texture_wrap(v, wraps.v) * (float)h), h - 1u);
    rtk_texel(tex, 0u, x, y, rgba);
}

/* Fractional level for a footprint: log2 of the texels it covers, by the exponent and a linear mantissa (no libm; at most 0.09
 * below the logarithm, exact at powers of two, monotone). */
RTK_FN float rtk_texture_level(rtk_texture tex, float footprint)
{
    float texels = footprint * rtk_sqrt((float)tex.head->width * (float)tex.head->height);
    rtk_u32 bits = rtk_bits(rtk_min(texels, 1.0e9f));
    float level = (float)((rtk_i32)(bits >> 23) - 127) + (float)(rtk_i32)(bits & 0x7fffffu) / 8388608.0f;
    return texels > 1.0f ? level : 0.0f;
}

RTK_FN void rtk_texture_sample_wrapped(rtk_texture tex, float u, float v, float footprint, rtk_texture_wraps wraps, float rgba[4])
{
    float level, weight, fine[4], last = (float)(tex.head->level_count - 1u);
    rtk_u32 k, low;
    if (tex.head->flags & RTK_TEX_NEAREST) {
        rtk_texture_nearest(tex, u, v, wraps, rgba);
        return;
    }
    level = rtk_min(rtk_texture_level(tex, footprint), last);
    low = (rtk_u32)level;
    weight = level - (float)low;
    rtk_texture_bilinear(tex, low, u, v, wraps, rgba);
    if (!(weight > 0.0f))
        return;
    for (k = 0u; k < 4u; k++)
        fine[k] = rgba[k];
    rtk_texture_bilinear(tex, low + 1u, u, v, wraps, rgba);
    for (k = 0u; k < 4u; k++)
        rgba[k] = fine[k] + weight * (rgba[k] - fine[k]);
}

/* Colour (linear) and alpha at (u, v). */
RTK_FN void rtk_texture_sample(rtk_texture tex, float u, float v, float footprint, float rgba[4])
{
    rtk_texture_sample_wrapped(tex, u, v, footprint, rtk_texture_wraps_of(tex), rgba);
}

#endif
