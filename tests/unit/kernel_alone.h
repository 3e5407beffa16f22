/* What the library does in lanes, for one ray and with branches: what lanes and their parts are held against. */
#ifndef KERNEL_ALONE_H
#define KERNEL_ALONE_H

#include "kernel/classic.h"
#include "kernel/lights.h"
#include "kernel/surface.h"

/* Mirror direction that stays on its side: the shading normal's, or the geometric normal's where that would go below the
 * surface. n, ng: towards the ray. */
RTK_FN rtk_vec3 rtk_mirror(rtk_vec3 d, rtk_vec3 n, rtk_vec3 ng)
{
    rtk_vec3 r = rtk_reflect(d, n);
    return rtk_dot3(r, ng) > 0.0f ? r : rtk_reflect(d, ng);
}

RTK_FN rtk_vec3 rtk_surface_leave(rtk_surface s, rtk_vec3 dir)
{
    return rtk_leave(s.p, s.ng, s.error, dir);
}

/* From p towards the light; u, v in [0, 1) choose the point of a spherical one. */
RTK_FN rtk_light_sample rtk_light_toward(RT_GLOBAL const rtk_light *l, rtk_vec3 p, float u, float v)
{
    if (l->type == RTK_LIGHT_SPHERE)
        return rtk_light_sphere(l, p, u, v);
    return l->type == RTK_LIGHT_DIRECTIONAL ? rtk_light_directional(l) : rtk_light_point(l, p);
}

RTK_FN int rtk_light_behind(RT_GLOBAL const rtk_light *l, rtk_vec3 p, rtk_vec3 n)
{
    return rtk_light_behind_flat(l, l->type, p, n);
}

RTK_FN float rtk_light_reach(RT_GLOBAL const rtk_light *l, rtk_vec3 p, rtk_light_sample s)
{
    return l->body_radius > 0.0f ? rtk_light_reach_body(l, p, s) : s.distance;
}

RTK_FN float rtk_light_end(RT_GLOBAL const rtk_light *l, rtk_vec3 p, float error, float reach)
{
    return l->type == RTK_LIGHT_DIRECTIONAL ? RTK_INF : rtk_light_end_at(l, p, error, reach);
}

#endif
