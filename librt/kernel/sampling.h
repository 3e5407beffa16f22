/* Directions drawn from a distribution, and their densities per solid angle. */
#ifndef RTK_SAMPLING_H
#define RTK_SAMPLING_H

#include "maths.h"
#include "random2.h"
#include "vec.h"

/* About the pole w, whose cosine and sine are given, turned by the angle of sine and cosine sn and c: not yet of length 1. */
RTK_FN rtk_vec3 rtk_polar_sum(rtk_vec3 w, float cosine, float sine, float sn, float c)
{
    rtk_vec3 s, t;
    rtk_basis(w, &s, &t);
    return rtk_madd(rtk_madd(rtk_scale(w, cosine), sine * c, s), sine * sn, t);
}

/* Unit vector with the given cosine and sine to the pole w, turned by v of a whole circle. */
RTK_FN rtk_vec3 rtk_polar_direction(rtk_vec3 w, float cosine, float sine, float v)
{
    float c, sn;
    rtk_sincos(2.0f * RTK_PI * v, &sn, &c);
    return rtk_unit(rtk_polar_sum(w, cosine, sine, sn, c));
}

/* That without a branch, for loops over lanes. Returns 0 where it takes another way. */
RTK_FN int rtk_polar_direction_plain(rtk_vec3 w, float cosine, float sine, float v, rtk_vec3 *dir)
{
    float c, sn;
    int plain = rtk_sincos_plain(2.0f * RTK_PI * v, &sn, &c);
    rtk_vec3 d = rtk_polar_sum(w, cosine, sine, sn, c);
    *dir = rtk_unit_plain(d);
    return plain & rtk_unit_is_plain(rtk_maxabs(d));
}

/* Cosine-weighted direction about unit n. */
RTK_FN rtk_vec3 rtk_cosine_direction(rtk_vec3 n, rtk_uv u)
{
    return rtk_polar_direction(n, rtk_sqrt(1.0f - u.x), rtk_sqrt(u.x), u.y);
}

RTK_FN int rtk_cosine_direction_plain(rtk_vec3 n, rtk_uv u, rtk_vec3 *dir)
{
    return rtk_polar_direction_plain(n, rtk_sqrt(1.0f - u.x), rtk_sqrt(u.x), u.y, dir);
}

RTK_FN float rtk_cosine_pdf(float cosine)
{
    return cosine > 0.0f ? cosine * (1.0f / RTK_PI) : 0.0f;
}

/* 1 - cos of a cone's half angle for sin^2 = s, without cancellation: the cone's solid angle is 2 pi times that. */
RTK_FN float rtk_cone_height(float s)
{
    return s / (1.0f + rtk_sqrt(rtk_max(0.0f, 1.0f - s)));
}

/* Uniform over the cone of this height: x = height * (a number in [0, 1)). The whole sphere has height 2. */
RTK_FN rtk_vec3 rtk_cone_direction(rtk_vec3 w, float x, float v)
{
    return rtk_polar_direction(w, 1.0f - x, rtk_sqrt(rtk_max(0.0f, x * (2.0f - x))), v);
}

RTK_FN int rtk_cone_direction_plain(rtk_vec3 w, float x, float v, rtk_vec3 *dir)
{
    return rtk_polar_direction_plain(w, 1.0f - x, rtk_sqrt(rtk_max(0.0f, x * (2.0f - x))), v, dir);
}

RTK_FN float rtk_cone_pdf(float height)
{
    return 1.0f / (2.0f * RTK_PI * height);
}

#endif
