/* Camera rays: where in a pixel, on the lens and between the shutter's times they start. */
#ifndef RTK_CAMERA_H
#define RTK_CAMERA_H

#include "maths.h"
#include "random2.h"
#include "snapshot.h"

/* A camera made ready for an image size: a ray of the image point (px, py), in pixels from the top left corner, is
 * corner + px * step_x + py * step_y, as a direction (PINHOLE) or an origin (ORTHOGRAPHIC). */
typedef struct rtk_lens {
    rtk_u32 type;
    rtk_vec3 eye, front;
    rtk_vec3 corner, step_x, step_y;
    float width, spread; /* ray cone of one pixel: at the origin, and per unit of distance */
    rtk_vec3 right, up;
    float radius, focus; /* of a thin lens; radius 0: none */
    rtk_u32 blades;
    float blade_turn;
} rtk_lens;

/* From a frame of unit vectors. */
RTK_FN rtk_lens rtk_lens_framed(rtk_u32 type, rtk_vec3 eye, rtk_vec3 front, rtk_vec3 right, rtk_vec3 up, float half_height,
                                rtk_u32 width, rtk_u32 height)
{
    rtk_lens l;
    float pixel = 2.0f * half_height / (float)height; /* edge of a pixel at distance 1; pixels are square */
    rtk_vec3 base;
    l.type = type;
    l.eye = eye;
    l.front = front;
    base = type == RTK_CAMERA_ORTHOGRAPHIC ? l.eye : l.front;
    l.step_x = rtk_scale(right, pixel);
    l.step_y = rtk_scale(up, -pixel);
    l.corner = rtk_madd(rtk_madd(base, -0.5f * (float)width, l.step_x), -0.5f * (float)height, l.step_y);
    l.width = type == RTK_CAMERA_ORTHOGRAPHIC ? pixel : 0.0f;
    l.spread = type == RTK_CAMERA_ORTHOGRAPHIC ? 0.0f : pixel;
    l.right = right;
    l.up = up;
    l.radius = 0.0f;
    l.focus = 1.0f;
    l.blades = 0u;
    l.blade_turn = 0.0f;
    return l;
}

/* The camera as it stands at time 0. */
RTK_FN rtk_lens rtk_lens_make(RT_GLOBAL const rtk_camera *c, rtk_u32 width, rtk_u32 height)
{
    rtk_lens l = rtk_lens_framed(c->type, rtk_v3(c->eye[0], c->eye[1], c->eye[2]), rtk_v3(c->front[0], c->front[1], c->front[2]),
                                 rtk_v3(c->right[0], c->right[1], c->right[2]), rtk_v3(c->up[0], c->up[1], c->up[2]),
                                 c->half_height, width, height);
    l.radius = c->aperture;
    l.focus = c->focus;
    l.blades = c->blades;
    l.blade_turn = c->blade_turn;
    return l;
}

/* a (1 - t) + b t: exactly a and b at the ends, and at every t where both are equal. */
RTK_FN float rtk_between(float a, float b, float t)
{
    return a + t * (b - a);
}

RTK_FN rtk_vec3 rtk_between3(RT_GLOBAL const float *a, RT_GLOBAL const float *b, float t)
{
    return rtk_v3(rtk_between(a[0], b[0], t), rtk_between(a[1], b[1], t), rtk_between(a[2], b[2], t));
}

/* A MOVING camera at time t: eye, look_at, up, the window's height and the lens go in straight lines, so what look_at follows
 * stays in the middle; the frame is made of them. */
RTK_FN rtk_lens rtk_lens_at(RT_GLOBAL const rtk_camera *c, rtk_u32 width, rtk_u32 height, float t)
{
    RT_GLOBAL const rtk_camera_key *a = &c->key[0], *b = &c->key[1];
    rtk_vec3 aim = rtk_between3(a->aim, b->aim, t), front = rtk_unit(aim);
    rtk_vec3 right = rtk_unit(rtk_cross3(front, rtk_between3(a->up, b->up, t)));
    rtk_lens l = rtk_lens_framed(c->type, rtk_between3(a->eye, b->eye, t), front, right, rtk_cross3(right, front),
                                 rtk_between(a->half_height, b->half_height, t), width, height);
    l.radius = rtk_between(a->aperture, b->aperture, t);
    l.focus = a->focus > 0.0f ? rtk_between(a->focus, b->focus, t) : rtk_len(aim);
    l.blades = c->blades;
    l.blade_turn = c->blade_turn;
    return l;
}

/* Unit direction: t of camera rays is a distance. */
RTK_FN void rtk_lens_ray(rtk_lens l, float px, float py, rtk_vec3 *org, rtk_vec3 *dir)
{
    rtk_vec3 p = rtk_madd(rtk_madd(l.corner, px, l.step_x), py, l.step_y);
    int ortho = l.type == RTK_CAMERA_ORTHOGRAPHIC;
    float inv = 1.0f / rtk_len(p);
    org->x = ortho ? p.x : l.eye.x;
    org->y = ortho ? p.y : l.eye.y;
    org->z = ortho ? p.z : l.eye.z;
    dir->x = ortho ? l.front.x : p.x * inv;
    dir->y = ortho ? l.front.y : p.y * inv;
    dir->z = ortho ? l.front.z : p.z * inv;
}

/* The unit square to the unit disc, areas kept, neighbours kept: Shirley, Chiu 1997. */
RTK_FN rtk_uv rtk_concentric(rtk_uv u)
{
    float a = 2.0f * u.x - 1.0f, b = 2.0f * u.y - 1.0f, r, s, c;
    rtk_uv p;
    if (a == 0.0f && b == 0.0f) {
        p.x = p.y = 0.0f;
        return p;
    }
    if (rtk_fabs(a) > rtk_fabs(b)) {
        r = a;
        rtk_sincos(0.785398163f * (b / a), &s, &c);
    } else {
        r = b;
        rtk_sincos(0.785398163f * (a / b), &c, &s);
    }
    p.x = r * c;
    p.y = r * s;
    return p;
}

/* The unit square to a regular polygon in the unit circle, areas kept; with turn 0 a corner points up. Each of the triangles
 * around the middle takes its strip of u.x. */
RTK_FN rtk_uv rtk_polygon(rtk_uv u, rtk_u32 corners, float turn)
{
    float n = (float)corners, at = u.x * n, k = rtk_min(rtk_floor(at), n - 1.0f), half_s, half_c, s, c, x, y, r = rtk_sqrt(u.y);
    rtk_uv p;
    rtk_sincos(RTK_PI / n, &half_s, &half_c);
    rtk_sincos(turn + RTK_HALF_PI + (2.0f * k + 1.0f) * (RTK_PI / n), &s, &c);
    x = r * half_c;
    y = r * half_s * (2.0f * (at - k) - 1.0f);
    p.x = x * c - y * s;
    p.y = x * s + y * c;
    return p;
}

/* As rtk_lens_ray, from the lens's point that u in [0, 1)^2 names to where the ray through its middle meets what is sharp: a
 * plane across the view. Parallel rays (ORTHOGRAPHIC) have a lens in front of each. */
RTK_FN void rtk_lens_thin_ray(rtk_lens l, float px, float py, rtk_uv u, rtk_vec3 *org, rtk_vec3 *dir)
{
    rtk_vec3 p = rtk_madd(rtk_madd(l.corner, px, l.step_x), py, l.step_y), off;
    rtk_uv at = l.blades >= 3u ? rtk_polygon(u, l.blades, l.blade_turn) : rtk_concentric(u);
    off = rtk_madd(rtk_scale(l.right, l.radius * at.x), l.radius * at.y, l.up);
    if (l.type == RTK_CAMERA_ORTHOGRAPHIC) {
        *org = rtk_add(p, off);
        *dir = rtk_unit(rtk_sub(rtk_scale(l.front, l.focus), off));
    } else {
        *org = rtk_add(l.eye, off);
        *dir = rtk_unit(rtk_sub(rtk_scale(p, l.focus), off));
    }
}

/* The time that u in [0, 1) names between the shutter's. */
RTK_FN float rtk_shutter_time(RT_GLOBAL const rtk_camera *c, float u)
{
    return rtk_between(c->open, c->close, u);
}

#endif
