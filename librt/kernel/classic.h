/* The classic material (paper 000, extended) at one point.
 *
 *   shown = ambient * color * world ambient                    the light that comes from everywhere
 *         + diffusion * color * sum over lights of cos * e     Lambert; e as in lights.h
 *         + specular * sum over lights of highlight * cos * e  normalised Blinn-Phong, the lights' own colour
 *         + reflectiveness * (what the mirror direction shows)
 *         + transparency * color * (what the refracted direction shows)
 *
 * color is the material's, times its texture and the vertex colour. Crossing a surface tints by transparency * color, on the way
 * in and on the way out, for seen rays and for shadow rays alike. Under total internal reflection nothing is crossed: the
 * transparency joins the mirror ray, untinted. Whether a ray enters or leaves is told by the geometric normal. Outside is
 * index 1.
 */
#ifndef RTK_CLASSIC_H
#define RTK_CLASSIC_H

#include "maths.h"
#include "snapshot.h"

RTK_FN rtk_vec3 rtk_reflect(rtk_vec3 d, rtk_vec3 n)
{
    return rtk_madd(d, -2.0f * rtk_dot3(d, n), n);
}

/* Unit direction d through a surface whose unit normal n looks against it, not yet of length 1; ratio: index before over index
 * behind. 0: total internal reflection. */
RTK_FN int rtk_refract_sum(rtk_vec3 d, rtk_vec3 n, float ratio, rtk_vec3 *out)
{
    float c = -rtk_dot3(d, n), k = 1.0f - ratio * ratio * rtk_max(0.0f, 1.0f - c * c);
    *out = rtk_madd(rtk_scale(d, ratio), ratio * c - rtk_sqrt(k), n);
    return !(k < 0.0f);
}

/* A ray of unit direction d through a surface: bent by the shading normal, or where that would bend it back above the surface, by
 * the geometric one. ns, ng: towards the ray. 0: it does not get through. */
RTK_FN int rtk_bend(rtk_vec3 d, rtk_vec3 ns, rtk_vec3 ng, float ratio, rtk_vec3 *out)
{
    rtk_vec3 a;
    if (!rtk_refract_sum(d, ns, ratio, &a))
        return 0;
    *out = rtk_unit(a);
    if (rtk_dot3(*out, ng) < 0.0f)
        return 1;
    if (!rtk_refract_sum(d, ng, ratio, &a))
        return 0;
    *out = rtk_unit(a);
    return 1;
}

/* That without a branch, for loops over lanes; *through: what it returns. Returns 0 where it takes another way. */
RTK_FN int rtk_bend_plain(rtk_vec3 d, rtk_vec3 ns, rtk_vec3 ng, float ratio, rtk_vec3 *out, int *through)
{
    rtk_vec3 a, b, s, g;
    int by_s = rtk_refract_sum(d, ns, ratio, &a), by_g = rtk_refract_sum(d, ng, ratio, &b), below;
    s = rtk_unit_plain(a);
    g = rtk_unit_plain(b);
    below = rtk_dot3(s, ng) < 0.0f;
    *out = rtk_v3(below ? s.x : g.x, below ? s.y : g.y, below ? s.z : g.z);
    *through = by_s & (below | by_g);
    return (!by_s) | (rtk_unit_is_plain(rtk_maxabs(a)) & (below | (!by_g) | rtk_unit_is_plain(rtk_maxabs(b))));
}

RTK_FN float rtk_index_of(RT_GLOBAL const rtk_material *m)
{
    return m->refractiveness > 0.0f ? m->refractiveness : 1.0f;
}

/* Normalised Blinn-Phong over pi, per unit of cosine: (shininess + 8) / 8 (n h)^shininess. n, l, v unit. */
RTK_FN float rtk_highlight(float shininess, rtk_vec3 n, rtk_vec3 l, rtk_vec3 v)
{
    float c = rtk_dot3(n, rtk_unit(rtk_add(l, v)));
    return c > 0.0f ? (shininess + 8.0f) * 0.125f * rtk_pow(c, shininess) : 0.0f;
}

/* That without a branch, for loops over lanes. Returns 0 where it takes another way. */
RTK_FN int rtk_highlight_plain(float shininess, rtk_vec3 n, rtk_vec3 l, rtk_vec3 v, float *out)
{
    rtk_vec3 middle = rtk_add(l, v);
    float c = rtk_dot3(n, rtk_unit_plain(middle)), power;
    int plain = rtk_pow_plain(c, shininess, &power), front = c > 0.0f;
    power = (shininess + 8.0f) * 0.125f * power;
    *out = front ? power : 0.0f;
    return rtk_unit_is_plain(rtk_maxabs(middle)) & (plain | !front);
}

/* What a ray that crosses the surface keeps. */
RTK_FN rtk_vec3 rtk_crossing(RT_GLOBAL const rtk_material *m, rtk_vec3 color)
{
    return rtk_scale(color, m->transparency);
}

#endif
