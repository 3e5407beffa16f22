/* Random numbers and rays for the kernel tests: xorshift, the same on every machine. */
#ifndef LIBRT_TEST_KERNEL_RANDOM_H
#define LIBRT_TEST_KERNEL_RANDOM_H

#include "kernel/ray.h"

typedef struct rng {
    uint64_t s;
} rng;

static inline uint32_t rng_u32(rng *r)
{
    r->s ^= r->s << 13;
    r->s ^= r->s >> 7;
    r->s ^= r->s << 17;
    return (uint32_t)(r->s >> 32);
}

/* [0, 1) and [-1, 1) */
static inline float rng_unit(rng *r)
{
    return (float)(rng_u32(r) >> 8) * 5.9604645e-08f;
}
static inline float rng_pm(rng *r)
{
    return 2.0f * rng_unit(r) - 1.0f;
}
static inline rtk_vec3 rng_vec(rng *r, float size)
{
    float x = size * rng_pm(r), y = size * rng_pm(r), z = size * rng_pm(r);
    return rtk_v3(x, y, z);
}
static inline rtk_vec3 rng_dir(rng *r)
{
    for (;;) {
        rtk_vec3 v = rng_vec(r, 1.0f);
        float l = rtk_len(v);
        if (l > 0.05f && l <= 1.0f)
            return rtk_scale(v, 1.0f / l);
    }
}

/* A ray made ready for a group with these bounds (not grown yet). */
static inline int prepare(rtk_vec3 org, rtk_vec3 dir, float tmin, float tmax, rtk_vec3 lo, rtk_vec3 hi, rtk_pray *out)
{
    rtk_ray ray;
    float scale = rtk_max(rtk_max(rtk_maxabs(lo), rtk_maxabs(hi)), 1.0e-30f), g = RTK_GROW * scale;
    ray.org = org;
    ray.dir = dir;
    ray.tmin = tmin;
    ray.tmax = tmax;
    ray.mask = ~0u;
    if (!rtk_ray_valid(ray))
        return 0;
    return rtk_ray_prepare(ray, rtk_v3(lo.x - g, lo.y - g, lo.z - g), rtk_v3(hi.x + g, hi.y + g, hi.z + g), scale, out);
}

#endif
