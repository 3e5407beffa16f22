/* The leaf test in vectors against the leaf test, bit for bit, at every instruction set that runs here: what a vector accepts or
 * refuses, the scalar function accepts or refuses; lanes in doubt are few enough to be worth it. Also what packets do for
 * many rays at once: doubted ones in doubled floats, those that start far away. LIBRT_PAIRS: how many pairs (a million each
 * width). */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "kernel_random.h"
#include "tri_lanes_probe.h"

static rtk_vec3 point(rng *g, float size)
{
    return rtk_v3(size * (2.0f * rng_unit(g) - 1.0f), size * (2.0f * rng_unit(g) - 1.0f), size * (2.0f * rng_unit(g) - 1.0f));
}

static void set(float v[3], rtk_vec3 p)
{
    v[0] = p.x;
    v[1] = p.y;
    v[2] = p.z;
}

/* A weighted point of the triangle; kind picks corners, edges, the inside, or near misses. */
static rtk_vec3 target(rng *g, const rtk_tri *t, int kind)
{
    float a = rng_unit(g), b = rng_unit(g) * (1.0f - a);
    if (kind == 1)
        a = b = 0.0f;
    else if (kind == 2)
        b = 0.0f;
    else if (kind == 3)
        a = 1.0f + 1e-6f * (rng_unit(g) - 0.5f);
    rtk_vec3 p;
    p.x = t->v0[0] + a * (t->v1[0] - t->v0[0]) + b * (t->v2[0] - t->v0[0]);
    p.y = t->v0[1] + a * (t->v1[1] - t->v0[1]) + b * (t->v2[1] - t->v0[1]);
    p.z = t->v0[2] + a * (t->v1[2] - t->v0[2]) + b * (t->v2[2] - t->v0[2]);
    return p;
}

#define SLIGHT 6 /* a triangle's shape: some of its coordinates are tiny beside others */

/* A number of any size, down to the smallest there are. */
static float slight(rng *g)
{
    const float x = rng_pm(g);
    const uint32_t kind = rng_u32(g) % 4u;
    return kind == 0u ? 0.0f : kind == 1u ? x : ldexpf(x, -(int)(rng_u32(g) % 150u));
}

/* Returns its shape. */
static int make_triangle(rng *g, rtk_tri *t)
{
    int shape = (int)(rng_unit(g) * 7.0f);
    float size = shape == 0 ? 1e-3f : 1.0f;
    rtk_vec3 a = point(g, 1.0f), b = point(g, size), c = point(g, size);
    if (shape == 0) { /* small */
        b = rtk_add(a, b);
        c = rtk_add(a, c);
    } else if (shape == 1) { /* sliver */
        c = rtk_madd(a, rng_unit(g), rtk_sub(b, a));
        c.x += 1e-6f * (rng_unit(g) - 0.5f);
    } else if (shape == 2) { /* in a plane of the axes, corners on a lattice */
        a = rtk_v3(-0.5f, 0.25f, -0.5f);
        b = rtk_v3(0.5f, 0.25f, -0.5f);
        c = rtk_v3(-0.5f, 0.25f, 0.5f);
    } else if (shape == 3 && rng_unit(g) < 0.1f) { /* a point */
        b = c = a;
    } else if (shape == SLIGHT) {
        a = rtk_v3(slight(g), slight(g), a.z);
        b = rtk_v3(slight(g), slight(g), rng_u32(g) % 2u ? a.z : slight(g));
        c = rtk_v3(slight(g), slight(g), rng_u32(g) % 2u ? b.z : slight(g));
    }
    memset(t, 0, sizeof *t);
    set(t->v0, a);
    set(t->v1, b);
    set(t->v2, c);
    return shape;
}

/* Sizes of a world and of directions, as powers of two: a pair is made at size 1. Every other batch has other sizes, up to those
 * where products of factors leave the range of floats. */
typedef struct sizes {
    float world, dir;
} sizes;

static sizes make_sizes(rng *g)
{
    static const int world[] = {-60, -46, -38, -33, -26, -16, 16, 28, 30, 36, 40, 56}, dir[] = {0, -50, -33, -28, 28, 33, 57};
    if (rng_unit(g) < 0.5f)
        return (sizes){1.0f, 1.0f};
    return (sizes){ldexpf(1.0f, world[(int)(rng_unit(g) * 12.0f) % 12]), ldexpf(1.0f, dir[(int)(rng_unit(g) * 7.0f) % 7])};
}

static void resize(rtk_tri *t, float by)
{
    for (int k = 0; k < 3; k++) {
        t->v0[k] *= by;
        t->v1[k] *= by;
        t->v2[k] *= by;
    }
}

/* A ray for it, at the sizes; false: it misses the bounds, and there is nothing to ask. */
static int make_ray(rng *g, int shape, const rtk_tri *t, sizes size, rtk_pray *r)
{
    int aim = (int)(rng_unit(g) * 5.0f), start = (int)(rng_unit(g) * 6.0f);
    rtk_vec3 lo = rtk_v3(-1.01f, -1.01f, -1.01f), hi = rtk_v3(1.01f, 1.01f, 1.01f);
    rtk_ray ray;
    ray.org = point(g, start == 0 ? 100.0f : 1.0f);
    if (start == 1) /* on the triangle, as rays that were spawned there */
        ray.org = target(g, t, 0);
    if (start == 2 && shape == 2)
        ray.org = rtk_v3(0.5f * (float)(int)(3.0f * rng_unit(g)) - 0.5f, 1.0f, 0.5f * (float)(int)(3.0f * rng_unit(g)) - 0.5f);
    ray.dir = rtk_sub(target(g, t, aim), ray.org);
    if (start == 1 || aim == 4)
        ray.dir = point(g, 1.0f);
    if (start == 2 && shape == 2)
        ray.dir = rtk_v3(0.0f, -1.0f, 0.0f);
    if (shape == SLIGHT && start > 1) { /* through a corner, along an axis */
        const float *at = start == 2 ? t->v0 : start == 3 ? t->v1 : t->v2;
        ray.org = rtk_v3(aim == 0 ? 0.0f : at[0], aim == 1 ? 0.0f : at[1], ray.org.z);
        ray.dir = rtk_v3(0.0f, 0.0f, at[2] < ray.org.z ? -1.0f : 1.0f);
    }
    ray.tmin = rng_unit(g) < 0.8f ? 0.0f : rng_unit(g);
    ray.tmax = rng_unit(g) < 0.5f ? RTK_INF : 2.0f * rng_unit(g);
    ray.mask = 1u;
    ray.org = rtk_scale(ray.org, size.world);
    ray.dir = rtk_scale(ray.dir, size.dir);
    ray.tmin *= size.world / size.dir;
    ray.tmax *= size.world / size.dir;
    return rtk_ray_valid(ray) &&
           rtk_ray_prepare(ray, rtk_scale(lo, size.world), rtk_scale(hi, size.world), 1.01f * size.world, r);
}

typedef struct tally {
    uint64_t hits, doubts, certain;
} tally;

static void compare(const rtk_pray *rays, const rtk_tri *tris, const probe_answer *got, uint32_t n, tally *sum, const char *isa)
{
    for (uint32_t i = 0; i < n; i++) {
        float t = 0, u = 0, v = 0;
        int hit = rtk_tri_intersect(&rays[i], &tris[i], &t, &u, &v);
        sum->hits += (uint64_t)hit;
        sum->doubts += (uint64_t)got[i].doubt;
        sum->certain += (uint64_t)got[i].certain;
        if (got[i].certain && (!got[i].doubt || !hit || !(fabsf(got[i].t - t) <= got[i].off)))
            fail_msg("%s, %u lanes: org %a %a %a dir %a %a %a: scalar %d t %a, here for certain t %a within %a", isa, n,
                     rays[i].org.x, rays[i].org.y, rays[i].org.z, rays[i].dir.x, rays[i].dir.y, rays[i].dir.z, hit, t, got[i].t,
                     got[i].off);
        if (got[i].doubt)
            assert_false(got[i].hit);
        else if (got[i].hit != hit || (hit && (rtk_bits(got[i].t) != rtk_bits(t) || rtk_bits(got[i].u) != rtk_bits(u) ||
                                               rtk_bits(got[i].v) != rtk_bits(v))))
            fail_msg("%s, %u lanes: org %a %a %a dir %a %a %a: scalar %d t %a u %a v %a, here %d t %a u %a v %a", isa, n,
                     rays[i].org.x, rays[i].org.y, rays[i].org.z, rays[i].dir.x, rays[i].dir.y, rays[i].dir.z, hit, t, u, v,
                     got[i].hit, got[i].t, got[i].u, got[i].v);
    }
}

typedef void (*probe_fn)(uint32_t width, const rtk_pray *rays, const rtk_tri *tris, probe_answer *out);

static void level(const char *isa, uint32_t width, probe_fn probe)
{
    const char *asked = getenv("LIBRT_PAIRS");
    uint64_t pairs = asked ? strtoull(asked, NULL, 10) : 1000000u;
    rng g = {42 + width};
    tally sum = {0, 0, 0};
    rtk_pray rays[16];
    rtk_tri tris[16];
    probe_answer got[16];
    int shape;
    for (uint64_t done = 0; done < pairs; done += width) {
        const sizes size = make_sizes(&g);
        for (uint32_t i = 0; i < width; i++) {
            do
                shape = make_triangle(&g, &tris[i]);
            while (!make_ray(&g, shape, &tris[i], size, &rays[i]));
            resize(&tris[i], size.world);
        }
        probe(width, rays, tris, got);
        compare(rays, tris, got, width, &sum, isa);
    }
    assert_true(sum.hits * 20 > pairs);    /* the test tests something */
    assert_true(sum.doubts * 2 < pairs);   /* adversarial pairs: a quarter */
    assert_true(sum.doubts * 100 > pairs); /* and the path of doubt is walked */
    assert_true(sum.certain * 100 > pairs);
}

/* Of pairs that the fast test doubts, only those whose ray is on an edge are left to be asked. Every other batch is of one
 * triangle, as packets of rays have it. */
typedef uint32_t probe_pairs(const rtk_pray *rays, const rtk_tri *tris, probe_answer *out);

static void exact(const char *isa, uint32_t width, probe_pairs *probe, probe_pairs *doubles, probe_pairs *settle)
{
    const char *asked = getenv("LIBRT_PAIRS");
    uint64_t pairs = asked ? strtoull(asked, NULL, 10) : 1000000u, doubted = 0, inside = 0, left = 0, settled[3] = {0};
    rng g = {7 + width};
    tally sum = {0, 0, 0};
    rtk_pray rays[16];
    rtk_tri tris[16];
    probe_answer got[16];
    for (uint64_t done = 0; done < pairs; done += width) {
        const bool one = done / width % 2 == 0;
        const sizes size = make_sizes(&g);
        uint32_t tries = 0, i = 0;
        int shape = make_triangle(&g, &tris[0]);
        while (i < width && tries++ < 1000u) { /* a triangle off the bounds is met by none */
            if (i > 0 && one)
                tris[i] = tris[0];
            else if (i > 0 || tries > 100u)
                shape = make_triangle(&g, &tris[i]);
            if (make_ray(&g, shape, &tris[i], size, &rays[i]) && rays[i].tshift == 0.0f)
                i++;
        }
        if (i < width)
            continue;
        for (i = 0; i < width; i++)
            resize(&tris[i], size.world);
        doubted += probe(rays, tris, got);
        compare(rays, tris, got, width, &sum, isa);
        const uint32_t asks = doubles(rays, tris, got);
        for (i = 0; i < width; i++) {
            if (got[i].hit)
                fail_msg("%s: a pair by itself is decided one way in doubles and another way in vectors of doubles", isa);
            left += size.world == 1.0f && size.dir == 1.0f && got[i].doubt; /* others may leave the range in which doubles tell */
        }
        inside += size.world == 1.0f && size.dir == 1.0f ? asks : 0;
        if (settle(rays, tris, got) != 0)
            fail_msg("%s: pairs are settled one way in doubles and another way in vectors of doubles", isa);
        for (i = 0; i < width; i++)
            settled[got[i].hit ? 2 : got[i].doubt]++;
    }
    assert_true(settled[0] * 20 > pairs && settled[1] * 1000 > pairs && settled[2] * 20 > pairs);
    assert_true(sum.hits * 20 > pairs);
    assert_true(doubted * 20 > pairs);
    assert_true(inside * 40 > pairs && left > 0 && (inside - left) * 20 > inside); /* most of these start on the triangle */
    assert_true(sum.doubts * 10 < doubted * 6); /* half of these rays aim at corners and edges */
}

/* A plane met at 2^-125: a quotient so small is rounded more than its terms tell, and no bound of theirs holds for it. */
static void smallest(const char *isa, uint32_t width, probe_pairs *probe)
{
    const float scale = 0x1.00068ep+25f;
    const rtk_ray ray = {.org = {0x1.05cp-112f, -0x1.844054p+24f, 0x1.e91ebcp+23f},
                         .dir = {-0x1.8p-1f, 0x1p+0f, -0x1p+0f},
                         .tmax = RTK_INF,
                         .mask = 1u};
    const rtk_tri tri = {
        .v0 = {0x1p-112f, -0x1p+24f, 0x1p+24f}, .v1 = {0x1p-111f, 0x1p+25f, -0x1p+24f}, .v2 = {0x1p-112f, -0x1p+25f, 0x1p+24f}};
    tally sum = {0, 0, 0};
    rtk_pray rays[16];
    rtk_tri tris[16];
    probe_answer got[16];
    for (uint32_t i = 0; i < width; i++) {
        tris[i] = tri;
        assert_true(rtk_ray_prepare(ray, rtk_v3(-scale, -scale, -scale), rtk_v3(scale, scale, scale), scale, &rays[i]));
    }
    assert_int_equal(probe(rays, tris, got), width);
    compare(rays, tris, got, width, &sum, isa);
    assert_int_equal(sum.hits, width);
}

static void test_levels(void **state)
{
    (void)state;
#define LEVEL(name, isa)                                                                                                         \
    for (uint32_t width = 4; width <= 16 && rti_isa_runs(isa); width *= 2)                                                       \
        if (probe_width_##name(width) == width)                                                                                  \
            level(#name, width, probe_triangles_##name);
    RTI_ISA_EACH(LEVEL)
#undef LEVEL
}

/* Rays from near and far at the corners and edges of a part, some a few 1e-6 beside them, and away from it: those that packets
 * leave out are those that miss it when they are prepared. */
static void part(const char *isa, uint32_t width, uint32_t (*probe)(const rtk_ray *rays, const rtk_part *part))
{
    const char *asked = getenv("LIBRT_PAIRS");
    uint64_t rays = asked ? strtoull(asked, NULL, 10) : 1000000u, far_out = 0, in = 0;
    rng g = {11 + width};
    rtk_part p;
    memset(&p, 0, sizeof p);
    p.lo = rtk_v3(-1.0f, -0.5f, 0.25f);
    p.hi = rtk_v3(0.75f, 0.5f, 1.0f);
    p.scale = 1.0f;
    for (uint64_t done = 0; done < rays; done += width) {
        rtk_ray some[16];
        for (uint32_t i = 0; i < width; i++) {
            const int at = (int)(rng_unit(&g) * 4.0f);
            const float off = rng_unit(&g) < 0.5f ? 0.0f : rng_unit(&g) * (rng_unit(&g) < 0.5f ? 4e-6f : 0.5f);
            rtk_vec3 to = rtk_v3(at & 1 ? p.hi.x : p.lo.x, at & 2 ? p.hi.y : p.lo.y, p.lo.z + rng_unit(&g) * 0.75f);
            rtk_vec3 dir = rtk_v3(rng_unit(&g) - 0.5f, rng_unit(&g) - 0.5f, rng_unit(&g) - 0.5f);
            const float away = 8.0f * rtk_float(rtk_bits(1.0f) + ((rtk_u32)(rng_unit(&g) * 24.0f) << 23)) / rtk_maxabs(dir);
            to.x += at & 1 ? off : -off;
            if (rng_unit(&g) < 0.1f)
                dir.y = 0.0f;
            some[i].org = rtk_madd(to, -away, dir);
            some[i].dir = rng_unit(&g) < 0.1f ? rtk_v3(-dir.x, -dir.y, -dir.z) : dir;
            some[i].tmin = 0.0f;
            some[i].tmax = RTK_INF;
            some[i].mask = 1u;
        }
        const uint32_t out = probe(some, &p);
        for (uint32_t i = 0; i < width; i++) {
            rtk_pray r;
            const int meets = rtk_ray_valid(some[i]) && rtk_ray_prepare(some[i], p.lo, p.hi, p.scale, &r);
            in += (uint64_t)meets;
            far_out += (out >> i & 1u) && rtk_maxabs(some[i].org) > RTK_FAR;
            if (meets && (out >> i & 1u))
                fail_msg("%s: org %a %a %a dir %a %a %a meets the part", isa, some[i].org.x, some[i].org.y, some[i].org.z,
                         some[i].dir.x, some[i].dir.y, some[i].dir.z);
        }
    }
    assert_true(in * 5 > rays);
    assert_true(far_out * 10 > rays);
}

static void test_packets(void **state)
{
    (void)state;
#define LEVEL(name, isa)                                                                                                         \
    if (rti_isa_runs(isa)) {                                                                                                     \
        exact(#name, probe_width_##name(16), probe_exact_##name, probe_double_##name, probe_settle_##name);                      \
        smallest(#name, probe_width_##name(16), probe_exact_##name);                                                             \
        part(#name, probe_width_##name(16), probe_part_##name);                                                                  \
    }
    RTI_ISA_EACH(LEVEL)
#undef LEVEL
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_levels), cmocka_unit_test(test_packets)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
