/* The test of cylinders and cones in vectors of one instruction set, in a form that a test can call. Compiled once a level. */
#include "shape_lanes_probe.h"

#include "probe_widths.h"
#include "trace/packet.h"

#define FIELDS 21
#define PROBE(N)                                                                                                                 \
    static void RTI_ISA_FN(cones##N)(const rtk_pray *rays, const rtk_shape *shapes, float *t, uint32_t *ask)                     \
    {                                                                                                                            \
        float p[FIELDS][N];                                                                                                      \
        rti_f##N x[FIELDS], first = rti_f##N##_set(0.0f);                                                                        \
        for (int i = 0; i < N; i++) {                                                                                            \
            const rtk_pray *r = &rays[i];                                                                                        \
            const rtk_shape *s = &shapes[i];                                                                                     \
            const float of[FIELDS] = {r->org.x,                                                                                  \
                                      r->org.y,                                                                                  \
                                      r->org.z,                                                                                  \
                                      r->dir.x,                                                                                  \
                                      r->dir.y,                                                                                  \
                                      r->dir.z,                                                                                  \
                                      r->tmin,                                                                                   \
                                      r->tmax,                                                                                   \
                                      r->tshift,                                                                                 \
                                      s->p[0],                                                                                   \
                                      s->p[1],                                                                                   \
                                      s->p[2],                                                                                   \
                                      s->p[4],                                                                                   \
                                      s->p[5],                                                                                   \
                                      s->p[6],                                                                                   \
                                      s->p[3],                                                                                   \
                                      s->p[s->type == RTK_SHAPE_CONE ? 7 : 3],                                                   \
                                      RTK_BALL_MARGIN * r->scale,                                                                \
                                      r->inv.x,                                                                                  \
                                      r->inv.y,                                                                                  \
                                      r->inv.z};                                                                                 \
            for (int k = 0; k < FIELDS; k++)                                                                                     \
                p[k][i] = of[k];                                                                                                 \
        }                                                                                                                        \
        for (int k = 0; k < FIELDS; k++)                                                                                         \
            x[k] = rti_f##N##_load(p[k]);                                                                                        \
        rti_ball_ray##N r = {                                                                                                    \
            {x[0], x[1], x[2]}, {x[3], x[4], x[5]}, .tmin = x[6], .tmax = x[7], .tshift = x[8], .margin = x[17]};                \
        const rti_cone##N cone = {{{x[9], x[10], x[11]}, {x[12], x[13], x[14]}}, {x[15], x[16]}};                                \
        rti_ball_ready##N(&r);                                                                                                   \
        const uint32_t hit = rti_cone_test##N(&r, x + 18, &cone, rti_f##N##_set(RTK_INF), (1u << N) - 1u, &first, ask);          \
        rti_f##N##_store(t, first);                                                                                              \
        for (uint32_t i = 0; i < N; i++)                                                                                         \
            t[i] = hit >> i & 1u ? t[i] : rtk_float(0x7fc00000u);                                                                \
    }
PROBE_WIDTHS(PROBE)
#undef PROBE

uint32_t RTI_ISA_FN(probe_cones)(uint32_t at_most, const rtk_pray *rays, const rtk_shape *cones, float *t, uint32_t *ask)
{
    const uint32_t width = at_most < RTI_SIMD ? at_most : RTI_SIMD;
#define ASK(N)                                                                                                                   \
    if (width == N)                                                                                                              \
        RTI_ISA_FN(cones##N)(rays, cones, t, ask);
    PROBE_WIDTHS(ASK)
#undef ASK
    return width;
}
