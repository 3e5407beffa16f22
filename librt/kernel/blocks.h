/* Rays travel in batches: arrays of 16-ray blocks in structure-of-arrays, 64-byte rows (architecture.md, idea 2).
 *
 * A tracer sees trace blocks and hit blocks only. The path block is the rest of a ray's state: with it, shading is a pure
 * function of (snapshot, hit, state), and a ray can go on in another thread, process or lane.
 */
#ifndef RTK_BLOCKS_H
#define RTK_BLOCKS_H

#include "types.h"

#define RTK_BLOCK 16u

/* Rays as the tracers take them. t is in units of dir, which may have any length; a hit counts when tmin < t < tmax.
 * mask: a primitive is seen when (geometry mask & ray mask) != 0. */
typedef struct rtk_trace_block {
    float ox[RTK_BLOCK], oy[RTK_BLOCK], oz[RTK_BLOCK];
    float dx[RTK_BLOCK], dy[RTK_BLOCK], dz[RTK_BLOCK];
    float tmin[RTK_BLOCK], tmax[RTK_BLOCK];
    rtk_u32 mask[RTK_BLOCK];
} rtk_trace_block;

/* Hits as the tracers give them. Miss: t = tmax, prim = geom = inst = RTK_INVALID. inst is RTK_INVALID too for geometry that
 * stands in the scene itself. u, v: weights of the second and third vertex for triangles, surface parameters in [0, 1] for
 * the other shapes (shapes.h). */
typedef struct rtk_hit_block {
    float t[RTK_BLOCK], u[RTK_BLOCK], v[RTK_BLOCK];
    rtk_u32 prim[RTK_BLOCK], geom[RTK_BLOCK], inst[RTK_BLOCK];
} rtk_hit_block;

/* The state that shading carries. pixel: index in the image, row-major; sample: index in the pixel. depth_kind: depth in the
 * low 16 bits, kind (RTK_KIND_*) above. key: hash of the path (parent's key and branch), the address of its random numbers.
 * tp*: throughput; for a shadow ray the pending contribution. eta: refractive index of the medium the ray is in. width, spread:
 * ray cone at the origin and per unit of distance, for mip-maps. pdf: of the last sampled direction (solid angle), < 0 after
 * a specular bounce or from the camera, 0 where what it meets of lights has been asked for. */
typedef struct rtk_path_block {
    float tpr[RTK_BLOCK], tpg[RTK_BLOCK], tpb[RTK_BLOCK];
    rtk_u32 pixel[RTK_BLOCK], sample[RTK_BLOCK], depth_kind[RTK_BLOCK];
    rtk_u32 key_lo[RTK_BLOCK], key_hi[RTK_BLOCK];
    float eta[RTK_BLOCK], width[RTK_BLOCK], spread[RTK_BLOCK], pdf[RTK_BLOCK];
} rtk_path_block;

#define RTK_KIND_CAMERA 0u
#define RTK_KIND_SHADOW 1u
#define RTK_KIND_REFLECT 2u
#define RTK_KIND_REFRACT 3u
#define RTK_KIND_DIFFUSE 4u
#define RTK_KIND_AO 5u
#define RTK_KIND_COUNT 6u

#endif
