/* Lights as seen from a point.
 *
 * Units. `e` is what a white surface of diffusion 1 shows per unit of cosine: its radiance is diffusion * color * cos * e, and
 * pi * e is irradiance over cosine. With color c of the light (colour times intensity):
 *   no falloff (paper 000)   POINT, DIRECTIONAL e = c. SPHERE: c divided by the square of the sine of the cone's half angle
 *                            takes the place of the radiance, so that a surface facing it shows c at any distance
 *   inverse square           POINT e = c / distance^2 (c = radiant intensity / pi); SPHERE c is the radiance of its surface
 * A spherical light is sampled uniformly over the cone of directions it fills; the mean of e * cos over samples is the integral.
 * Seen from inside, it fills all directions.
 */
#ifndef RTK_LIGHTS_H
#define RTK_LIGHTS_H

#include "maths.h"
#include "sampling.h"
#include "snapshot.h"

typedef struct rtk_light_sample {
    rtk_vec3 dir;   /* unit, towards the light */
    float distance; /* to its surface along dir; infinite for a directional one */
    rtk_vec3 e;
    float pdf; /* of dir, per solid angle; 0 for lights without extent */
} rtk_light_sample;

RTK_FN rtk_vec3 rtk_light_color(RT_GLOBAL const rtk_light *l)
{
    return rtk_v3(l->color[0], l->color[1], l->color[2]);
}

/* Solid angle pdf of the direction sampling of a spherical light from p. */
RTK_FN float rtk_light_pdf(RT_GLOBAL const rtk_light *l, rtk_vec3 p)
{
    rtk_vec3 d = rtk_sub(rtk_v3(l->at[0], l->at[1], l->at[2]), p);
    float d2 = rtk_dot3(d, d), r2 = l->radius * l->radius;
    return rtk_cone_pdf(d2 > r2 ? rtk_cone_height(r2 / d2) : 2.0f);
}

/* A sample of a spherical light but for its direction: that is of the cone about d, at x of it (rtk_cone_direction). */
RTK_FN rtk_light_sample rtk_light_sphere_about(RT_GLOBAL const rtk_light *l, rtk_vec3 p, float u, rtk_vec3 *d, float *x)
{
    rtk_light_sample s;
    float d2, r2 = l->radius * l->radius, dist, sin2, height, chord;
    int outside;
    *d = rtk_sub(rtk_v3(l->at[0], l->at[1], l->at[2]), p);
    d2 = rtk_dot3(*d, *d);
    dist = rtk_sqrt(d2);
    outside = d2 > r2;
    sin2 = outside ? r2 / d2 : 1.0f;
    height = outside ? rtk_cone_height(sin2) : 2.0f;
    *x = u * height;
    /* Half the chord along dir: from the sine that dir was made with, so that a small far sphere keeps its digits. */
    chord = rtk_sqrt(rtk_max(0.0f, r2 - d2 * (*x * (2.0f - *x))));
    s.dir = *d;
    s.distance = outside ? rtk_max(dist * (1.0f - *x) - chord, 0.0f) : dist * (1.0f - *x) + chord;
    s.e = rtk_scale(rtk_light_color(l), 2.0f * height / (l->falloff > 0.0f ? 1.0f : sin2));
    s.pdf = rtk_cone_pdf(height);
    return s;
}

RTK_FN rtk_light_sample rtk_light_sphere(RT_GLOBAL const rtk_light *l, rtk_vec3 p, float u, float v)
{
    rtk_vec3 d;
    float x;
    rtk_light_sample s = rtk_light_sphere_about(l, p, u, &d, &x);
    s.dir = rtk_cone_direction(rtk_unit(d), x, v);
    return s;
}

/* That without a branch, for loops over lanes. Returns 0 where it takes another way. */
RTK_FN int rtk_light_sphere_plain(RT_GLOBAL const rtk_light *l, rtk_vec3 p, float u, float v, rtk_light_sample *s)
{
    rtk_vec3 d, dir;
    float x;
    int plain;
    *s = rtk_light_sphere_about(l, p, u, &d, &x);
    plain = rtk_unit_is_plain(rtk_maxabs(d)) & rtk_cone_direction_plain(rtk_unit_plain(d), x, v, &dir);
    s->dir = dir;
    return plain;
}

RTK_FN rtk_light_sample rtk_light_directional(RT_GLOBAL const rtk_light *l)
{
    rtk_light_sample s;
    s.e = rtk_light_color(l);
    s.pdf = 0.0f;
    s.dir = rtk_v3(-l->at[0], -l->at[1], -l->at[2]);
    s.distance = RTK_INF;
    return s;
}

RTK_FN rtk_light_sample rtk_light_point(RT_GLOBAL const rtk_light *l, rtk_vec3 p)
{
    rtk_light_sample s;
    rtk_vec3 d = rtk_sub(rtk_v3(l->at[0], l->at[1], l->at[2]), p);
    float d2 = rtk_dot3(d, d), inv, fall;
    int apart;
    s.pdf = 0.0f;
    s.distance = rtk_sqrt(d2);
    apart = s.distance > 0.0f;
    inv = 1.0f / s.distance;
    s.dir = rtk_v3(apart ? d.x * inv : 0.0f, apart ? d.y * inv : 0.0f, apart ? d.z * inv : 1.0f);
    fall = l->falloff > 0.0f ? 1.0f / d2 : 1.0f;
    s.e = rtk_scale(rtk_light_color(l), fall);
    return s;
}

/* No part of the light, which is of that type, is above the plane through p with unit normal n. */
RTK_FN int rtk_light_behind_flat(RT_GLOBAL const rtk_light *l, rtk_u32 type, rtk_vec3 p, rtk_vec3 n)
{
    rtk_vec3 at = rtk_v3(l->at[0], l->at[1], l->at[2]);
    if (type == RTK_LIGHT_DIRECTIONAL)
        return !(rtk_dot3(n, at) < 0.0f);
    return !(rtk_dot3(n, rtk_sub(at, p)) > (type == RTK_LIGHT_SPHERE ? -1.0001f * l->radius : 0.0f));
}

/* Distance at which a shadow ray towards a point light may end: the light, or the lamp around it (radius above 0), whose own
 * surface does not shadow it. p outside of the lamp; from inside the light is free anyway. */
RTK_FN float rtk_light_reach_body(RT_GLOBAL const rtk_light *l, rtk_vec3 p, rtk_light_sample s)
{
    rtk_vec3 d = rtk_sub(rtk_v3(l->body_at[0], l->body_at[1], l->body_at[2]), p), off;
    float along = rtk_dot3(d, s.dir), enter;
    off = rtk_madd(d, -along, s.dir);
    enter = along - rtk_sqrt(rtk_max(0.0f, l->body_radius * l->body_radius - rtk_dot3(off, off)));
    return enter > 0.0f ? rtk_min(s.distance, enter) : s.distance;
}

/* Where a shadow ray from p ends that may go as far as `reach`: before the light by the rounding of its place and of the ray's
 * own origin (error: that of p), so that what the light stands on does not hide it; but no more than half of the way, or nothing
 * would throw a shadow where a light's distance is small beside its coordinates. */
RTK_FN float rtk_light_end_at(RT_GLOBAL const rtk_light *l, rtk_vec3 p, float error, float reach)
{
    float size = rtk_maxabs(rtk_v3(l->at[0], l->at[1], l->at[2])) + l->radius + rtk_maxabs(p);
    return reach - rtk_min(4.0f * error + 2.0f * RTK_DELTA * size, 0.5f * reach);
}

/* Can the light be met by chance, too, as a body that diffuse rays hit? Then asking and meeting are weighed (lanes_path.c). */
RTK_FN int rtk_light_is_met(RT_GLOBAL const rtk_light *l)
{
    return (l->geom != RTK_INVALID) & (l->falloff > 0.0f);
}

/* Share of asking a light that is met, too: pdf of the direction by asking, and by going on with probability `diffuse_pdf` at
 * this cosine (balance heuristic; Veach, Guibas 1995). */
RTK_FN float rtk_light_asking(float select_pdf, float pdf, float cosine, float diffuse_pdf)
{
    float ask = select_pdf * pdf;
    return ask / (ask + diffuse_pdf * rtk_cosine_pdf(cosine));
}

/* Share of meeting it: by a diffuse ray of that pdf which started at org. Without falloff it has no radiance of its own. */
RTK_FN float rtk_light_meeting(RT_GLOBAL const rtk_light *l, rtk_vec3 org, float pdf)
{
    return l->falloff > 0.0f ? pdf / (pdf + l->select_pdf * rtk_light_pdf(l, org)) : 0.0f;
}

/* Light chosen by power: the first whose running sum exceeds u. */
RTK_FN rtk_u32 rtk_light_choose(RT_GLOBAL const rtk_light *lights, rtk_u32 count, float u)
{
    rtk_u32 lo = 0u, hi = count - 1u;
    while (lo < hi) {
        rtk_u32 mid = (lo + hi) >> 1;
        if (u < lights[mid].select_cdf)
            hi = mid;
        else
            lo = mid + 1u;
    }
    return lo;
}

#endif
