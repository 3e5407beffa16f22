/* The vector leaf tests of one instruction set, in a form that a test can call. Compiled once a level. */
#include "tri_lanes_probe.h"

#include "trace/tri_lanes.h"

#define PROBE(N)                                                                                                                 \
    static void RTI_ISA_FN(probe##N)(const rtk_pray *rays, const rtk_tri *tris, probe_answer *out)                               \
    {                                                                                                                            \
        float c[9][N], p[10][N];                                                                                                 \
        rti_tri_hit##N hit;                                                                                                      \
        for (int i = 0; i < N; i++) {                                                                                            \
            const rtk_pray *r = &rays[i];                                                                                        \
            const float *v[3] = {tris[i].v0, tris[i].v1, tris[i].v2};                                                            \
            const float of[10] = {r->korg.x, r->korg.y, r->korg.z, r->sx, r->sy, r->kdz, r->tmin, r->tmax, r->tshift, r->scale}; \
            for (int k = 0; k < 3; k++) {                                                                                        \
                c[3 * k][i] = v[k][r->kx];                                                                                       \
                c[3 * k + 1][i] = v[k][r->ky];                                                                                   \
                c[3 * k + 2][i] = v[k][r->kz];                                                                                   \
            }                                                                                                                    \
            for (int k = 0; k < 10; k++)                                                                                         \
                p[k][i] = of[k];                                                                                                 \
        }                                                                                                                        \
        rti_f##N x[9];                                                                                                           \
        for (int k = 0; k < 9; k++)                                                                                              \
            x[k] = rti_f##N##_load(c[k]);                                                                                        \
        rti_tri_ray##N r = {rti_f##N##_load(p[0]), rti_f##N##_load(p[1]), rti_f##N##_load(p[2]), rti_f##N##_load(p[3]),          \
                            rti_f##N##_load(p[4]), rti_f##N##_load(p[5]), rti_f##N##_load(p[6]), rti_f##N##_load(p[7]),          \
                            rti_f##N##_load(p[8]), rti_f##N##_load(p[9])};                                                       \
        uint32_t bits = rti_tri##N(&r, x, x + 3, x + 6, (1u << N) - 1u, &hit);                                                   \
        for (int i = 0; i < N; i++)                                                                                              \
            out[i] = (probe_answer){bits && (hit.hit >> i & 1u), bits && (hit.doubt >> i & 1u), 0, 0, 0};                        \
        if (bits) {                                                                                                              \
            rti_f##N##_store(p[0], hit.t);                                                                                       \
            rti_f##N##_store(p[1], hit.u);                                                                                       \
            rti_f##N##_store(p[2], hit.v);                                                                                       \
        }                                                                                                                        \
        for (int i = 0; bits && i < N; i++) {                                                                                    \
            out[i].t = p[0][i];                                                                                                  \
            out[i].u = p[1][i];                                                                                                  \
            out[i].v = p[2][i];                                                                                                  \
        }                                                                                                                        \
    }
PROBE(4)
#if RTI_SIMD >= 8
PROBE(8)
#endif
#if RTI_SIMD >= 16
PROBE(16)
#endif

uint32_t RTI_ISA_FN(probe_width)(uint32_t at_most)
{
    return at_most < RTI_SIMD ? at_most : RTI_SIMD;
}

void RTI_ISA_FN(probe_triangles)(uint32_t width, const rtk_pray *rays, const rtk_tri *tris, probe_answer *out)
{
#if RTI_SIMD >= 16
    if (width == 16)
        RTI_ISA_FN(probe16)(rays, tris, out);
#endif
#if RTI_SIMD >= 8
    if (width == 8)
        RTI_ISA_FN(probe8)(rays, tris, out);
#endif
    if (width == 4)
        RTI_ISA_FN(probe4)(rays, tris, out);
}
