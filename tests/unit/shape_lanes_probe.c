/* The test of cylinders and cones in vectors of one instruction set, in a form that a test can call. Compiled once a level. */
#include "shape_lanes_probe.h"

#include "probe_widths.h"
#include "trace/packet.h"

enum { ORG, DIR = 3, INV = 6, TMIN = 9, TMAX, SHIFT, MARGIN, ENDS, RADII = ENDS + 6, BALL = RADII + 2, FIELDS = BALL + 4 };

static void RTI_ISA_FN(fields_of)(const rtk_pray *r, const rtk_shape *s, float to[FIELDS])
{
    const rtk_vec3 way[3] = {r->org, r->dir, r->inv};
    memcpy(to + ORG, way, sizeof way);
    to[TMIN] = r->tmin;
    to[TMAX] = r->tmax;
    to[SHIFT] = r->tshift;
    to[MARGIN] = RTK_BALL_MARGIN * r->scale;
    memcpy(to + ENDS, s->p, 3 * sizeof *to);
    memcpy(to + ENDS + 3, s->p + 4, 3 * sizeof *to);
    to[RADII] = s->p[3];
    to[RADII + 1] = s->p[s->type == RTK_SHAPE_CONE ? 7 : 3];
    rtk_shape_ball(s, to + BALL);
}

#define PROBE(N)                                                                                                                 \
    static void RTI_ISA_FN(cones##N)(const rtk_pray *rays, const rtk_shape *shapes, float *t, uint32_t *ask, uint32_t *near)     \
    {                                                                                                                            \
        const uint32_t all = (1u << N) - 1u;                                                                                     \
        float fields[N][FIELDS], p[N];                                                                                           \
        rti_f##N x[FIELDS], first = rti_f##N##_set(0.0f);                                                                        \
        rti_ball_ray##N r;                                                                                                       \
        for (int i = 0; i < N; i++)                                                                                              \
            RTI_ISA_FN(fields_of)(&rays[i], &shapes[i], fields[i]);                                                              \
        for (int k = 0; k < FIELDS; k++) {                                                                                       \
            for (int i = 0; i < N; i++)                                                                                          \
                p[i] = fields[i][k];                                                                                             \
            x[k] = rti_f##N##_load(p);                                                                                           \
        }                                                                                                                        \
        const rti_cone##N cone = {{{x[ENDS], x[ENDS + 1], x[ENDS + 2]}, {x[ENDS + 3], x[ENDS + 4], x[ENDS + 5]}},                \
                                  {x[RADII], x[RADII + 1]}};                                                                     \
        rti_ball_rays##N(&r, x + ORG, x + DIR, x[TMIN], x[TMAX], x[SHIFT], x[MARGIN]);                                           \
        rti_ball_ready##N(&r);                                                                                                   \
        *near = rti_ball_near##N(&r, x + BALL, x[BALL + 3], x[TMAX], all);                                                       \
        const uint32_t hit = rti_cone_test##N(&r, x + INV, &cone, x[TMAX], all, &first, ask);                                    \
        rti_f##N##_store(t, first);                                                                                              \
        for (uint32_t i = 0; i < N; i++)                                                                                         \
            t[i] = hit >> i & 1u ? t[i] : rtk_float(0x7fc00000u);                                                                \
    }
PROBE_WIDTHS(PROBE)
#undef PROBE

uint32_t RTI_ISA_FN(probe_cones)(uint32_t at_most, const rtk_pray *rays, const rtk_shape *cones, float *t, uint32_t *ask,
                                 uint32_t *near)
{
    const uint32_t width = at_most < RTI_SIMD ? at_most : RTI_SIMD;
#define ASK(N)                                                                                                                   \
    if (width == N)                                                                                                              \
        RTI_ISA_FN(cones##N)(rays, cones, t, ask, near);
    PROBE_WIDTHS(ASK)
#undef ASK
    return width;
}
