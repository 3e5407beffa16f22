/* The test of spheres in vectors of one instruction set, in a form that a test can call. Compiled once a level. */
#include "ball_lanes_probe.h"

#include "probe_widths.h"
#include "trace/packet.h"

#define PROBE(N)                                                                                                                 \
    static void RTI_ISA_FN(balls##N)(const rtk_pray *rays, const rtk_shape *balls, float *t)                                     \
    {                                                                                                                            \
        float p[14][N];                                                                                                          \
        rti_f##N x[14], first = rti_f##N##_set(0.0f);                                                                            \
        for (int i = 0; i < N; i++) {                                                                                            \
            const rtk_pray *r = &rays[i];                                                                                        \
            const float of[14] = {r->org.x,      r->org.y,      r->org.z,      r->dir.x,     r->dir.y,                           \
                                  r->dir.z,      r->tmin,       r->tmax,       r->tshift,    RTK_BALL_MARGIN * r->scale,         \
                                  balls[i].p[0], balls[i].p[1], balls[i].p[2], balls[i].p[3]};                                   \
            for (int k = 0; k < 14; k++)                                                                                         \
                p[k][i] = of[k];                                                                                                 \
        }                                                                                                                        \
        for (int k = 0; k < 14; k++)                                                                                             \
            x[k] = rti_f##N##_load(p[k]);                                                                                        \
        rti_ball_ray##N r = {                                                                                                    \
            {x[0], x[1], x[2]}, {x[3], x[4], x[5]}, .tmin = x[6], .tmax = x[7], .tshift = x[8], .margin = x[9]};                 \
        rti_ball_ready##N(&r);                                                                                                   \
        const uint32_t hit = rti_ball##N(&r, x + 10, x[13], rti_f##N##_set(RTK_INF), (1u << N) - 1u, &first);                    \
        rti_f##N##_store(t, first);                                                                                              \
        for (uint32_t i = 0; i < N; i++)                                                                                         \
            t[i] = hit >> i & 1u ? t[i] : rtk_float(0x7fc00000u);                                                                \
    }
PROBE_WIDTHS(PROBE)
#undef PROBE

uint32_t RTI_ISA_FN(probe_balls)(uint32_t at_most, const rtk_pray *rays, const rtk_shape *balls, float *t)
{
    const uint32_t width = at_most < RTI_SIMD ? at_most : RTI_SIMD;
#define ASK(N)                                                                                                                   \
    if (width == N)                                                                                                              \
        RTI_ISA_FN(balls##N)(rays, balls, t);
    PROBE_WIDTHS(ASK)
#undef ASK
    return width;
}
