/* Cylinders and cones in vectors against the function of one ray, bit for bit, at every instruction set that runs here; most rays
 * start about the surface, or along it, where rounding decides whether they meet it again. LIBRT_PAIRS: how many pairs (a million
 * each width). */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "shape_lanes_probe.h"
#include "kernel_random.h"

/* 2^-below to 1. */
static float shrunk(rng *g, uint32_t below)
{
    return ldexpf(1.0f, -(int)(rng_u32(g) % (below + 1)));
}

static rtk_vec3 one_axis(rng *g)
{
    const float way = rng_u32(g) % 2 ? 1.0f : -1.0f;
    const uint32_t k = rng_u32(g) % 3;
    return rtk_v3(k == 0 ? way : 0.0f, k == 1 ? way : 0.0f, k == 2 ? way : 0.0f);
}

/* A cylinder or a cone of a part of the size `scale`, mostly no smaller than a thousandth of that; thin as a needle, flat as
 * paper, pointed, along an axis. */
static void make_cone(rng *g, float scale, rtk_shape *s)
{
    const float length = scale * (0.1f + rng_unit(g)) * shrunk(g, rng_u32(g) % 8 ? 8 : 70);
    const float thin = shrunk(g, rng_u32(g) % 2 ? 10 : 22), flat = rng_u32(g) % 8 ? 1.0f : 1.0f / shrunk(g, 24);
    const float radius = rtk_min(length * (0.1f + 2.0f * rng_unit(g)) * thin * flat, scale);
    const rtk_vec3 way = rng_u32(g) % 4 ? rng_dir(g) : one_axis(g);
    rtk_vec3 from = rng_u32(g) % 4 ? rng_vec(g, scale) : rtk_v3(0.0f, 0.0f, 0.0f), to = rtk_madd(from, length, way);
    memset(s, 0, sizeof *s);
    s->type = rng_u32(g) % 2 ? RTK_SHAPE_CYLINDER : RTK_SHAPE_CONE;
    memcpy(s->p, &from, sizeof from);
    memcpy(s->p + 4, &to, sizeof to);
    s->p[3] = radius;
    s->p[7] = s->type == RTK_SHAPE_CYLINDER ? 0.0f : radius * (rng_u32(g) % 4 ? 2.0f * rng_unit(g) : (float)(rng_u32(g) % 2));
}

/* A point about the surface: on the side, or on a cap; and outwards there. */
static rtk_vec3 surface(rng *g, const rtk_shape *s, float off, rtk_vec3 *out)
{
    const rtk_cone c = rtk_cone_of(s);
    const float z = rng_unit(g), turn = 6.2831853f * rng_unit(g);
    const uint32_t cap = rng_u32(g) % 4;
    const float along = cap == 0 ? 0.0f : (cap == 1 ? 1.0f : z),
                radius = (c.r0 + c.k * c.height * along) * (cap < 2 ? rng_unit(g) : 1.0f);
    rtk_vec3 x, y, around;
    rtk_basis(c.axis, &x, &y);
    around = rtk_madd(rtk_scale(x, cosf(turn)), sinf(turn), y);
    *out = cap < 2 ? rtk_scale(c.axis, cap == 0 ? -1.0f : 1.0f) : rtk_unit(rtk_madd(around, -c.k, c.axis));
    return rtk_madd(rtk_madd(rtk_madd(rtk_at(s->p), along * c.height, c.axis), radius, around), off, *out);
}

/* A ray from about the surface (a few or some hundred roundings away), from within, or from anywhere. */
static void make_ray(rng *g, float scale, const rtk_shape *s, rtk_pray *r)
{
    const rtk_cone c = rtk_cone_of(s);
    const uint32_t kind = rng_u32(g) % 8, way = rng_u32(g) % 16;
    const float ulps = 1.1920929e-07f * ldexpf(rng_pm(g), (int)(rng_u32(g) % 12));
    rtk_vec3 out, at = surface(g, s, scale * ulps, &out), dir = rng_dir(g), there, unused;
    memset(r, 0, sizeof *r);
    r->scale = scale;
    r->org = at;
    if (kind == 0)
        r->org = rtk_madd(rtk_at(s->p), c.height * rng_unit(g), c.axis);
    if (kind == 1 || kind == 2)
        r->org = rng_vec(g, 2.0f * scale);
    /* To another point of it, or past that; of needles, by up to three times the radius. */
    there = surface(g, s, way < 4 ? scale * ulps : 3.0f * rtk_max(s->p[3], s->p[7]) * rng_unit(g), &unused);
    if (way < 4 || way >= 12)
        dir = rtk_sub(there, r->org);
    if (way == 4) /* along the surface */
        dir = rtk_madd(dir, -rtk_dot3(dir, out) * (1.0f + rng_pm(g) * shrunk(g, 30)), out);
    if (way == 5) /* along the axis, or nearly */
        dir = rtk_madd(c.axis, rng_u32(g) % 2 ? 0.0f : shrunk(g, 30), dir);
    if (way == 6) /* across it */
        dir = rtk_madd(dir, -rtk_dot3(dir, c.axis), c.axis);
    if (way == 7)
        dir = one_axis(g);
    if (!(rtk_maxabs(dir) >= 1.0e-12f))
        dir = c.axis;
    if (rng_u32(g) % 4 == 0)
        dir = rtk_scale(dir, ldexpf(1.0f, (int)(rng_u32(g) % 40) - 20));
    r->dir = dir;
    r->inv = rtk_v3(rtk_inverse(dir.x), rtk_inverse(dir.y), rtk_inverse(dir.z));
    r->tmin = rng_u32(g) % 8 ? 0.0f : scale * rng_pm(g) * shrunk(g, 20);
    r->tmax = rng_u32(g) % 8 ? RTK_INF : scale * 2.0f * rng_unit(g);
    r->tshift = rng_u32(g) % 4 ? 0.0f : scale * 16.0f * rng_pm(g) * shrunk(g, 20);
}

static void cones(const char *isa, uint32_t width,
                  uint32_t (*probe)(uint32_t, const rtk_pray *, const rtk_shape *, float *, uint32_t *, uint32_t *))
{
    const char *pairs_text = getenv("LIBRT_PAIRS");
    const uint64_t pairs = pairs_text ? strtoull(pairs_text, NULL, 10) : 1000000;
    uint64_t met = 0, left = 0, asked = 0;
    rng g = {5 + width};
    for (uint64_t done = 0; done < pairs; done += width) {
        const float scale = ldexpf(1.0f, rng_u32(&g) % 4 ? 0 : (int)(rng_u32(&g) % 80) - 40);
        rtk_pray rays[16];
        rtk_shape shapes[16];
        float t[16];
        uint32_t ask = 0, near = 0;
        for (uint32_t i = 0; i < width; i++) {
            make_cone(&g, scale, &shapes[i]);
            make_ray(&g, scale, &shapes[i], &rays[i]);
        }
        assert_int_equal(probe(width, rays, shapes, t, &ask, &near), width);
        for (uint32_t i = 0; i < width; i++) {
            const rtk_pray *r = &rays[i];
            const rtk_shape *s = &shapes[i];
            float roots[4];
            const int hit = rtk_shape_roots(r, s, roots) > 0;
            met += (uint64_t)hit;
            left += (uint64_t)!hit;
            asked += ask >> i & 1u;
            if ((hit && !(near >> i & 1u)) || (!(ask >> i & 1u) && (hit ? rtk_bits(t[i]) != rtk_bits(roots[0]) : t[i] == t[i])))
                fail_msg("%s, %u lanes: org %a %a %a dir %a %a %a tmin %a tmax %a shift %a scale %a, type %u from %a %a %a %a to "
                         "%a %a %a %a: "
                         "%a for %a",
                         isa, width, r->org.x, r->org.y, r->org.z, r->dir.x, r->dir.y, r->dir.z, r->tmin, r->tmax, r->tshift,
                         scale, s->type, s->p[0], s->p[1], s->p[2], s->p[3], s->p[4], s->p[5], s->p[6], s->p[7], t[i],
                         hit ? roots[0] : NAN);
        }
    }
    assert_true(met * 4 > pairs);
    assert_true(left * 4 > pairs);
    assert_true(asked * 8 < pairs);
}

static void test_levels(void **state)
{
    (void)state;
#define LEVEL(name, isa)                                                                                                         \
    for (uint32_t width = 4; rti_isa_runs(isa) && width <= 16; width *= 2) {                                                     \
        rtk_pray rays[16] = {0};                                                                                                 \
        rtk_shape shapes[16] = {0};                                                                                              \
        float t[16];                                                                                                             \
        uint32_t ask, near;                                                                                                      \
        if (probe_cones_##name(width, rays, shapes, t, &ask, &near) == width)                                                    \
            cones(#name, width, probe_cones_##name);                                                                             \
    }
    RTI_ISA_EACH(LEVEL)
#undef LEVEL
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_levels)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
