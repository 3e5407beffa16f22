/* What every integrator asks: a material's colour at a surface, and the world behind everything. */
#ifndef RTK_INTEGRATE_H
#define RTK_INTEGRATE_H

#include "maths.h"
#include "surface.h"
#include "texture.h"

/* footprint: width of the ray's cone at the hit. */
RTK_FN rtk_vec3 rtk_base_color(RT_GLOBAL const rtk_scene *scene, RT_GLOBAL const rtk_material *m, rtk_surface s, float footprint)
{
    rtk_vec3 c = rtk_mul(rtk_v3(m->color[0], m->color[1], m->color[2]), s.tint);
    float rgba[4];
    if (m->color_tex == RTK_INVALID)
        return c;
    rtk_texture_sample(scene->textures[m->color_tex], s.u, s.v, footprint * s.uv_scale, rgba);
    return rtk_mul(c, rtk_v3(rgba[0], rgba[1], rgba[2]));
}

RTK_FN rtk_vec3 rtk_gradient(rtk_vec3 low, rtk_vec3 top, rtk_vec3 d)
{
    return rtk_madd(low, 0.5f + 0.5f * d.y, rtk_sub(top, low));
}

/* Where unit direction d is on the equirectangular map: its middle column towards -z, its upper edge +y. */
RTK_FN float rtk_sky_u(rtk_vec3 d) { return rtk_atan2(d.x, -d.z) / (2.0f * RTK_PI) + 0.5f; }
RTK_FN float rtk_sky_v(rtk_vec3 d) { return 1.0f - rtk_acos(rtk_clamp(d.y, -1.0f, 1.0f)) / RTK_PI; }

/* The map goes around the sky in its rows, and ends at the poles, whatever its texture does on other things: else each pole
 * would be mixed with the other, or the map would show its ends towards +z. */
RTK_FN rtk_texture_wraps rtk_sky_wraps(void)
{
    rtk_texture_wraps wraps;
    wraps.u = 0u;
    wraps.v = RTK_TEX_CLAMP;
    return wraps;
}

/* A diffuse ray stands for a cone at least this wide, which is what textures' levels of detail go by. */
#define RTK_DIFFUSE_SPREAD 0.2f

/* Footprint on the map of a cone of that spread. The sky is a light, too: diffuse rays look it up as it is, since a cone's mean
 * would lend what is bright in it other cosines and solid angles, below the horizon even, and so more or less light. */
RTK_FN float rtk_sky_footprint(float spread)
{
    return spread < RTK_DIFFUSE_SPREAD ? spread / RTK_PI : 0.0f;
}

/* Radiance of the world in unit direction d: gradient by height, or the equirectangular map. spread: angle of the cone. */
RTK_FN rtk_vec3 rtk_background(RT_GLOBAL const rtk_scene *scene, rtk_vec3 d, float spread)
{
    RT_GLOBAL const rtk_world *w = scene->world;
    rtk_vec3 low = rtk_v3(w->background[0], w->background[1], w->background[2]);
    rtk_vec3 top = rtk_v3(w->background_top[0], w->background_top[1], w->background_top[2]);
    float rgba[4];
    if (w->background_tex == RTK_INVALID)
        return rtk_gradient(low, top, d);
    rtk_texture_sample_wrapped(scene->textures[w->background_tex], rtk_sky_u(d), rtk_sky_v(d), rtk_sky_footprint(spread),
                               rtk_sky_wraps(), rgba);
    return rtk_v3(rgba[0], rgba[1], rgba[2]);
}

/* Normals turned against the ray, and whether it comes from outside. A shading normal that would face away from the ray is
 * replaced by the geometric one: the point is seen, so it has a front. */
RTK_FN int rtk_face_normals(rtk_vec3 d, rtk_vec3 *ng, rtk_vec3 *ns)
{
    int outside = rtk_dot3(d, *ng) < 0.0f, behind;
    rtk_vec3 g = *ng, s = *ns;
    g = rtk_v3(outside ? g.x : -g.x, outside ? g.y : -g.y, outside ? g.z : -g.z);
    s = rtk_v3(outside ? s.x : -s.x, outside ? s.y : -s.y, outside ? s.z : -s.z);
    behind = !(rtk_dot3(d, s) < 0.0f);
    *ng = g;
    *ns = rtk_v3(behind ? g.x : s.x, behind ? g.y : s.y, behind ? g.z : s.z);
    return outside;
}

RTK_FN int rtk_face(rtk_surface *s, rtk_vec3 d)
{
    return rtk_face_normals(d, &s->ng, &s->ns);
}

#endif
