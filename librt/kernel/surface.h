/* What is at a hit: the one place that turns (snapshot, ray, hit) into a point, normals, texture coordinates and a material. */
#ifndef RTK_SURFACE_H
#define RTK_SURFACE_H

#include "snapshot.h"

typedef struct rtk_surface {
    rtk_vec3 p;       /* world space, on the primitive (not org + t dir) */
    rtk_vec3 ng, ns;  /* unit, outwards as described; ns == ng where there are no vertex normals */
    float u, v;       /* texture coordinates after placement */
    rtk_vec3 tint;    /* vertex colour, or 1 1 1 */
    float uv_scale;   /* texture-space length per world length around the hit, for mip levels; 0: no mip-mapping */
    float error;      /* bound of the distance between p and the true hit, world space */
    rtk_u32 material; /* index in scene.materials */
    rtk_u32 face;     /* face_id of the public rt_surface */
    rtk_u32 user_id, inst_user_id;
} rtk_surface;

#endif
