/** librt: one pixel explained. The rays that made it, what they met and what each brought to the film, from the very code that renders. */
#ifndef LIBRT_EXPLAIN_H
#define LIBRT_EXPLAIN_H

#include "librt/render.h"
#include "librt/tree.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum rt_ray_kind {
    RT_RAY_CAMERA = 0,
    RT_RAY_SHADOW,  /**< towards a light */
    RT_RAY_REFLECT, /**< mirrored */
    RT_RAY_REFRACT, /**< through a transparent body, in or out */
    RT_RAY_DIFFUSE, /**< "path": scattered */
    RT_RAY_AO       /**< "ao": is something near? */
} rt_ray_kind;

typedef struct rt_explained_ray {
    uint32_t index, parent; /**< number of this call, from 0; that of the ray it started from, RT_INVALID_ID for a camera ray. Parents come before children */
    uint32_t sample, depth; /**< bounces before it; a shadow ray has its parent's */
    rt_ray_kind kind;
    uint32_t light; /**< SHADOW: the light's index, counted without removed ones; else RT_INVALID_ID */
    rt_ray ray;     /**< dir as it was traced */
    rt_hit hit;     /**< SHADOW, AO: what stands in the way (the last of `crossed` when nothing stops it); a miss has prim_id RT_INVALID_ID */
    rt_surface surface; /**< at the hit; material {RT_INVALID_ID} on a miss */
    rt_vec3 throughput; /**< what its light is multiplied by before it reaches the film; SHADOW, AO: the light itself, if nothing were in the way */
    int arrived;        /**< SHADOW, AO: it reached its end, perhaps through transparent bodies */
    uint32_t crossed;   /**< SHADOW: surfaces that let it through */
    int64_t brought[3]; /**< to the film, in units of rt_explained_pixel: by a miss the background, by a body that shines its emission, by another body
                             the ambient light; SHADOW, AO: what arrived */
    int64_t unshadowed[3]; /**< with shadows off: what the lights brought to the hit, without rays of their own */
    rt_ray_cost cost;      /**< of the tracer */
} rt_explained_ray;

typedef struct rt_explained_pixel {
    uint32_t samples; /**< of the pixel */
    uint32_t rays;    /**< of the call, as many as fn was called for */
    double unit;      /**< of the film, a power of two; 0: the integrator shows values, not sums of light, and sum and brought are zero */
    int64_t sum[3];   /**< of all samples: the sum of all rays' brought and unshadowed, exactly */
    float value[4];   /**< the pixel as rt_render gives it, bit for bit: (float)(sum * unit / samples), and the coverage */
    uint64_t clamped, dropped; /**< contributions that were limited, or left out as no numbers */
} rt_explained_pixel;

typedef struct rt_explain_desc {
    uint32_t struct_size;
    uint32_t x, y;                       /**< pixel of the whole image, y from the top */
    uint32_t first_sample, sample_count; /**< rays of these samples are told; count 0: all from the first on. The sums are of all samples */
    int (*progress)(void *user, float done); /**< NULL, or called about every 50 ms on the calling thread while rays are traced, done 0 ... 1 (of a
                                                  pixel: mostly 0); non-zero ends it */
    void *user;
} rt_explain_desc;
RT_API rt_explain_desc rt_explain_desc_default(void);

/** One ray; it lives as long as the call. Non-zero ends it. */
typedef int (*rt_explained_ray_fn)(void *user, const rt_explained_ray *ray);

/** Renders one pixel of the image that `desc` describes and tells how it came about: fn is called for each ray, on the calling thread, when all are traced.
 *  desc     as for rt_render; crop, pixels, pixels_stride, workers, tile and schedule mean nothing here
 *  pixel    may be NULL
 *  Errors   ARGUMENT (the pixel lies outside, no such sample), STATE, MEMORY, MEMORY_LIMIT, CANCELLED (fn or progress ended it)
 *  Threads  any; memory about 250 bytes a ray */
RT_API rt_status rt_render_explain(rt_scene *scene, const rt_render_desc *desc, const rt_explain_desc *what, rt_explained_ray_fn fn, void *user,
                                   rt_explained_pixel *pixel);

#ifdef __cplusplus
}
#endif
#endif
