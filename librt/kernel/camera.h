/* Camera rays and where in a pixel they start. */
#ifndef RTK_CAMERA_H
#define RTK_CAMERA_H

#include "snapshot.h"

/* A camera made ready for an image size: a ray of the image point (px, py), in pixels from the top left corner, is
 * corner + px * step_x + py * step_y, as a direction (PINHOLE) or an origin (ORTHOGRAPHIC). */
typedef struct rtk_lens {
    rtk_u32 type;
    rtk_vec3 eye, front;
    rtk_vec3 corner, step_x, step_y;
    float width, spread; /* ray cone of one pixel: at the origin, and per unit of distance */
} rtk_lens;

RTK_FN rtk_lens rtk_lens_make(RT_GLOBAL const rtk_camera *c, rtk_u32 width, rtk_u32 height)
{
    rtk_lens l;
    float pixel = 2.0f * c->half_height / (float)height; /* edge of a pixel at distance 1; pixels are square */
    rtk_vec3 right = rtk_v3(c->right[0], c->right[1], c->right[2]), up = rtk_v3(c->up[0], c->up[1], c->up[2]);
    rtk_vec3 base;
    l.type = c->type;
    l.eye = rtk_v3(c->eye[0], c->eye[1], c->eye[2]);
    l.front = rtk_v3(c->front[0], c->front[1], c->front[2]);
    base = c->type == RTK_CAMERA_ORTHOGRAPHIC ? l.eye : l.front;
    l.step_x = rtk_scale(right, pixel);
    l.step_y = rtk_scale(up, -pixel);
    l.corner = rtk_madd(rtk_madd(base, -0.5f * (float)width, l.step_x), -0.5f * (float)height, l.step_y);
    l.width = c->type == RTK_CAMERA_ORTHOGRAPHIC ? pixel : 0.0f;
    l.spread = c->type == RTK_CAMERA_ORTHOGRAPHIC ? 0.0f : pixel;
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

#endif
