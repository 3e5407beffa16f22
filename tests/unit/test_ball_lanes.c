/* Spheres in vectors against the function of one ray, bit for bit, at every instruction set that runs here; most rays start about
 * a sphere's surface, where rounding decides whether they meet it again. LIBRT_PAIRS: how many pairs (a million each width). */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "ball_lanes_probe.h"
#include "kernel_random.h"

/* 2^-below to 1. */
static float shrunk(rng *g, uint32_t below)
{
    return ldexpf(1.0f, -(int)(rng_u32(g) % (below + 1)));
}

/* A sphere of a part of the size `scale`, mostly no smaller than a thousandth of that. */
static void make_ball(rng *g, float scale, rtk_shape *s)
{
    const float radius = scale * (0.25f + 0.75f * rng_unit(g)) * shrunk(g, rng_u32(g) % 8 ? 10 : 70);
    memset(s, 0, sizeof *s);
    s->type = RTK_SHAPE_SPHERE;
    for (int k = 0; k < 3; k++)
        s->p[k] = rng_u32(g) % 4 ? scale * rng_pm(g) : 0.0f;
    s->p[3] = radius;
}

/* A ray from about the surface (a few or some hundred roundings away), from within, or from anywhere. */
static void make_ray(rng *g, float scale, const rtk_shape *s, rtk_pray *r)
{
    const rtk_vec3 middle = rtk_v3(s->p[0], s->p[1], s->p[2]), out = rng_dir(g);
    const uint32_t kind = rng_u32(g) % 8, way = rng_u32(g) % 8;
    const float ulps = 1.1920929e-07f * ldexpf(rng_pm(g), (int)(rng_u32(g) % 12));
    rtk_vec3 dir = rng_dir(g);
    memset(r, 0, sizeof *r);
    r->scale = scale;
    r->org = rtk_madd(middle, kind == 0 ? s->p[3] * rng_unit(g) : s->p[3] * (1.0f + ulps) + scale * ulps * (kind & 1), out);
    if (kind == 1)
        r->org = rng_vec(g, 2.0f * scale);
    if (way == 0) /* along the surface */
        dir = rtk_madd(dir, -rtk_dot3(dir, out) * (1.0f + rng_pm(g) * shrunk(g, 30)), out);
    if (way == 1) /* to the middle or away from it */
        dir = rng_u32(g) % 2 ? out : rtk_v3(-out.x, -out.y, -out.z);
    if (way == 2)
        dir = rtk_v3(rng_u32(g) % 2 ? 1.0f : -1.0f, 0.0f, 0.0f);
    if (rng_u32(g) % 4 == 0)
        dir = rtk_scale(dir, ldexpf(1.0f, (int)(rng_u32(g) % 80) - 40));
    r->dir = dir;
    r->tmin = rng_u32(g) % 8 ? 0.0f : scale * rng_pm(g) * shrunk(g, 20);
    r->tmax = rng_u32(g) % 8 ? RTK_INF : scale * 2.0f * rng_unit(g);
    r->tshift = rng_u32(g) % 4 ? 0.0f : scale * 16.0f * rng_pm(g) * shrunk(g, 20);
}

static void balls(const char *isa, uint32_t width, uint32_t (*probe)(uint32_t, const rtk_pray *, const rtk_shape *, float *))
{
    const char *pairs_text = getenv("LIBRT_PAIRS");
    const uint64_t pairs = pairs_text ? strtoull(pairs_text, NULL, 10) : 1000000;
    uint64_t met = 0, left = 0;
    rng g = {3 + width};
    for (uint64_t done = 0; done < pairs; done += width) {
        const float scale = ldexpf(1.0f, rng_u32(&g) % 4 ? 0 : (int)(rng_u32(&g) % 100) - 50);
        rtk_pray rays[16];
        rtk_shape spheres[16];
        float t[16];
        for (uint32_t i = 0; i < width; i++) {
            make_ball(&g, scale, &spheres[i]);
            make_ray(&g, scale, &spheres[i], &rays[i]);
        }
        assert_int_equal(probe(width, rays, spheres, t), width);
        for (uint32_t i = 0; i < width; i++) {
            float roots[4];
            const int hit = rtk_shape_roots(&rays[i], &spheres[i], roots) > 0;
            met += (uint64_t)hit;
            left += (uint64_t)!hit;
            if (hit ? rtk_bits(t[i]) != rtk_bits(roots[0]) : t[i] == t[i])
                fail_msg(
                    "%s, %u lanes: org %a %a %a dir %a %a %a tmin %a tmax %a shift %a scale %a, sphere %a %a %a %a: %a for %a",
                    isa, width, rays[i].org.x, rays[i].org.y, rays[i].org.z, rays[i].dir.x, rays[i].dir.y, rays[i].dir.z,
                    rays[i].tmin, rays[i].tmax, rays[i].tshift, scale, spheres[i].p[0], spheres[i].p[1], spheres[i].p[2],
                    spheres[i].p[3], t[i], hit ? roots[0] : NAN);
        }
    }
    assert_true(met * 4 > pairs);
    assert_true(left * 4 > pairs);
}

static void test_levels(void **state)
{
    (void)state;
#define LEVEL(name, isa)                                                                                                         \
    for (uint32_t width = 4; rti_isa_runs(isa) && width <= 16; width *= 2) {                                                     \
        rtk_pray rays[16] = {0};                                                                                                 \
        rtk_shape spheres[16] = {0};                                                                                             \
        float t[16];                                                                                                             \
        if (probe_balls_##name(width, rays, spheres, t) == width)                                                                \
            balls(#name, width, probe_balls_##name);                                                                             \
    }
    RTI_ISA_EACH(LEVEL)
#undef LEVEL
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_levels)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
