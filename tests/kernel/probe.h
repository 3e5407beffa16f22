/* One item of work through the kernel headers, written once: compiled into the test and, as text, by an OpenCL driver. */
#ifndef LIBRT_TEST_PROBE_H
#define LIBRT_TEST_PROBE_H

#include "rng.h"
#include "shapes.h"
#include "triangle.h"

#define PROBE_WORDS 32

RTK_FN void probe_put(RT_GLOBAL rtk_u32 *out, int at, float f)
{
    /* every NaN is the same answer: IEEE leaves its bits open */
    out[at] = f == f ? rtk_bits(f) : 0x7fc00000u;
}

RTK_FN void probe_maths(rtk_u32 seed, RT_GLOBAL rtk_u32 *out)
{
    float any = rtk_float(rtk_mix(seed)), x = 20.0f * rtk_unit_float(rtk_mix(seed + 1u)) - 10.0f;
    float y = 2.0f * rtk_unit_float(rtk_mix(seed + 2u)) - 1.0f;
    probe_put(out, 0, rtk_sin(any));
    probe_put(out, 1, rtk_cos(x));
    probe_put(out, 2, rtk_tan(x));
    probe_put(out, 3, rtk_asin(y));
    probe_put(out, 4, rtk_acos(y));
    probe_put(out, 5, rtk_atan2(y, any));
    probe_put(out, 6, rtk_exp(x));
    probe_put(out, 7, rtk_exp2(12.0f * x));
    probe_put(out, 8, rtk_log(rtk_fabs(any)));
    probe_put(out, 9, rtk_log2(rtk_fabs(x)));
    probe_put(out, 10, rtk_pow(rtk_fabs(x), 20.0f * y));
    out[11] = rtk_random_bits(rtk_vertex_seed(1u, seed, rtk_key_child(rtk_key_root(), seed & 7u)), seed >> 4, seed % 20u);
}

RTK_FN void probe_item(rtk_u32 i, RT_GLOBAL const rtk_ray *rays, RT_GLOBAL const rtk_tri *tris, RT_GLOBAL const rtk_shape *shapes,
                       RT_GLOBAL rtk_u32 *out)
{
    rtk_vec3 one = rtk_v3(2.0f, 2.0f, 2.0f);
    rtk_pray r;
    rtk_shape_point p;
    float t, u, v, roots[4];
    int k, n;
    for (k = 0; k < PROBE_WORDS; k++)
        out[k] = 0u;
    probe_maths(i, out);
    if (!rtk_ray_valid(rays[i]) || !rtk_ray_prepare(rays[i], rtk_neg(one), one, 2.0f, &r))
        return;
    out[12] = 1u;
    if (rtk_tri_intersect(&r, &tris[i], &t, &u, &v)) {
        probe_put(out, 13, t);
        probe_put(out, 14, u);
        probe_put(out, 15, v);
    }
    n = rtk_shape_roots(&r, &shapes[i], roots);
    out[16] = (rtk_u32)n;
    for (k = 0; k < n; k++)
        probe_put(out, 17 + k, roots[k]);
    if (n == 0)
        return;
    rtk_shape_surface(&shapes[i], rtk_madd(r.org, roots[0] - r.tshift, r.dir), &p);
    probe_put(out, 21, p.p.x);
    probe_put(out, 22, p.p.y);
    probe_put(out, 23, p.p.z);
    probe_put(out, 24, p.ng.x);
    probe_put(out, 25, p.ng.y);
    probe_put(out, 26, p.ng.z);
    probe_put(out, 27, p.dpdu.x);
    probe_put(out, 28, p.u);
    probe_put(out, 29, p.v);
    probe_put(out, 30, p.error);
}

#endif
