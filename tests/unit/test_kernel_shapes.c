/* Shapes against signed distances in long double: roots lie on the surface, none is missing, none is outside of the box. */
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <setjmp.h>
#include <cmocka.h>

#include "kernel/shapes.h"
#include "kernel_sdf.h"

static const char *const names[] = {"sphere", "box", "cylinder", "cone", "torus"};
static const real UNIT = 1.0L / 16777216;

typedef struct figures {
    int rays, hits, samples, wrong, passed; /* passed: misses that the leaf's quick test sees */
    real worst, outside;                    /* in u scale; in u of max(distance, size) */
} figures;

/* One ray: every root near the surface, and inside and outside alternate where a sample says so beyond doubt. */
static void judge(const rtk_shape *s, rtk_vec3 org, rtk_vec3 dir, float size, const rtk_vec3 box[2], figures *f)
{
    rtk_pray r = {0};
    float t[4];
    rtk_vec3 lo, hi;
    real3 d = real3_of(dir), o;
    real length = sqrtl(real3_dot(d, d)), unit, far, mid;
    int n;
    f->rays++;
    if (!prepare(org, dir, -RTK_INF, RTK_INF, box[0], box[1], &r))
        return;
    r.tshift = 0.0f;
    n = rtk_shape_roots(&r, s, t);
    f->hits += n > 0;
    if (s->type == RTK_SHAPE_SPHERE) {
        f->passed += rtk_sphere_passed(&r, s, -RTK_INF, RTK_INF);
        for (int i = 0; i < n; i++) { /* it may not pass one by that is hit, however small the interval is */
            assert_false(rtk_sphere_passed(&r, s, t[i], t[i]));
            assert_false(rtk_sphere_passed(&r, s, -RTK_INF, RTK_INF));
        }
    }
    o = real3_of(r.org);
    rtk_shape_bounds(s, &lo, &hi);
    mid = -real3_dot(real3_sub(o, real3_of(rtk_scale(rtk_add(lo, hi), 0.5f))), d) / (length * length);
    far = fabsl(mid) * length + 3 * size;
    unit = UNIT * real_max(far, rtk_maxabs(lo) > rtk_maxabs(hi) ? rtk_maxabs(lo) : rtk_maxabs(hi));
    for (int i = 0; i < n; i++) {
        real3 p = real3_madd(o, t[i], d);
        real e = fabsl(sdf(s, p)) / unit;
        f->worst = real_max(f->worst, e);
        assert_true(i == 0 || t[i] >= t[i - 1]);
        real x = real_max(lo.x - p.x, p.x - hi.x), y = real_max(lo.y - p.y, p.y - hi.y), z = real_max(lo.z - p.z, p.z - hi.z);
        f->outside = real_max(f->outside, real_max(x, real_max(y, z)) / (UNIT * r.scale));
    }
    for (int k = 0; k <= 160; k++) { /* three sizes before the middle to three behind it */
        real ts = mid + (real)(k - 80) / 80 * 3 * size / length, e = sdf(s, real3_madd(o, ts, d));
        int before = 0;
        if (fabsl(e) < 64 * unit)
            continue;
        for (int i = 0; i < n; i++)
            before += t[i] < ts;
        f->samples++;
        f->wrong += (e < 0) != (before & 1);
    }
}

/* distance: of origins, in sizes. */
static figures try_shape(rtk_u32 type, float size, rtk_vec3 at, float distance, float world, int rays, uint64_t seed)
{
    figures f = {0};
    rng g = {seed * 2654435761u + 17};
    const rtk_vec3 box[2] = {rtk_sub(at, rtk_v3(world, world, world)), rtk_add(at, rtk_v3(world, world, world))};
    for (int i = 0; i < rays; i++) {
        rtk_shape s = make_shape(&g, type, size, at);
        rtk_vec3 target = rtk_add(at, rng_vec(&g, size)), org = rtk_madd(at, distance * size, rng_dir(&g)), dir;
        if (distance == 0.0f)
            org = rtk_add(at, rng_vec(&g, 0.3f * size));
        dir = rtk_sub(target, org);
        if (i % 5 == 0) /* axis-parallel */
            dir = i % 2 ? rtk_v3(0, -1, 0) : rtk_v3(0, 0, 1), org = rtk_sub(target, rtk_scale(dir, distance * size));
        if (i % 5 == 1)
            dir = rtk_scale(dir, 1e5f);
        judge(&s, org, dir, size, box, &f);
    }
    return f;
}

static void roots_are_right(void **state)
{
    (void)state;
    static const struct {
        const char *what;
        float size, distance, world, move;
        real bound;
    } cases[] = {
        {"inside", 1, 0, 2, 0, 6},
        {"near", 1, 3, 2, 0, 6},
        {"4 scales", 1, 6.9f, 2, 0, 6},
        {"10^3 sizes", 0.01f, 1e3f, 40, 0, 6},
        {"10^4 sizes", 1e-3f, 1e4f, 40, 0, 6},
        {"far beyond", 1, 1e6f, 2, 0, 6},
        {"10^-3", 1e-3f, 3, 2e-3f, 0, 6},
        {"10^6", 1e6f, 3, 2e6f, 0, 6},
        {"moved 10^4", 1, 3, 2, 1e4f, 6},
        {"10^-12", 1e-12f, 3, 2e-12f, 0, 6},
        {"10^12", 1e12f, 3, 2e12f, 0, 6},
    };
    for (rtk_u32 type = RTK_SHAPE_SPHERE; type <= RTK_SHAPE_TORUS; type++)
        for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
            figures f = try_shape(type, cases[c].size, rtk_v3(cases[c].move, -cases[c].move, 0.5f * cases[c].move),
                                  cases[c].distance, cases[c].world, 4000, type * 100 + c);
            print_message("%-8s %-10s %5d hits of %d, worst %6.1Lf u of distance, %5.1Lf u scale outside of the box, %d of %d "
                          "samples wrong\n",
                          names[type], cases[c].what, f.hits, f.rays, f.worst, f.outside, f.wrong, f.samples);
            assert_true(f.hits > 400);
            if (type == RTK_SHAPE_SPHERE && cases[c].size > 0.1f && cases[c].size < 10 && cases[c].distance < 10 &&
                !cases[c].move)
                assert_true(f.passed > (f.rays - f.hits) * 3 / 4 - 40);
            assert_true(f.worst < cases[c].bound);
            assert_true(f.outside < RTK_DELTA / UNIT);
            assert_int_equal(f.wrong, 0);
        }
}

/* Cylinders and cones as thin as a millionth of their length, some of which end in a tip, and rays that pass them within a few
 * radii. */
static void needles_are_no_thicker(void **state)
{
    static const float distances[] = {0.3f, 3, 1e3f};
    (void)state;
    for (rtk_u32 type = RTK_SHAPE_CYLINDER; type <= RTK_SHAPE_CONE; type++)
        for (int c = 0; c < 3; c++) {
            const float world = 2.0f + (distances[c] > 10 ? distances[c] : 0);
            const rtk_vec3 box[2] = {{-world, -world, -world}, {world, world, world}};
            rng g = {type * 10 + (uint64_t)c};
            figures f = {0};
            for (int i = 0; i < 20000; i++) {
                const float thin = exp2f(-3 - rng_unit(&g) * 17);
                rtk_shape s = {type, 0, 0, 0, {0}};
                rtk_vec3 axis = rng_dir(&g), e0 = rng_vec(&g, 0.3f), e1 = rtk_add(e0, axis), target, org, dir;
                const float at = rng_unit(&g) * 1.1f - 0.05f;
                shape_vec(&s, 0, e0);
                shape_vec(&s, 4, e1);
                s.p[3] = thin * (i % 3 ? rng_unit(&g) : 1.0f);
                s.p[7] = type == RTK_SHAPE_CONE ? (i % 4 ? thin * rng_unit(&g) : 0.0f) : 0.0f;
                target = rtk_madd(rtk_madd(e0, at, axis), 2 * thin * rng_unit(&g), rng_dir(&g));
                dir = i % 5 ? rng_dir(&g) : rtk_madd(axis, 0.01f * rng_unit(&g), rng_dir(&g)); /* also almost along it */
                org = rtk_madd(target, -distances[c], dir);
                judge(&s, org, dir, 1, box, &f);
            }
            print_message("%-8s needle from %-5g %5d hits of %d, worst %6.1Lf u of distance, %d of %d samples wrong\n",
                          names[type], (double)distances[c], f.hits, f.rays, f.worst, f.wrong, f.samples);
            assert_true(f.hits > 4000);
            assert_true(f.worst < 6);
            assert_int_equal(f.wrong, 0);
        }
}

/* How far the shape reaches along +-axis, in closed form. */
static real reach(const rtk_shape *s, int axis, real sign)
{
    real n[3], l = 0;
    if (s->type == RTK_SHAPE_SPHERE)
        return sign * s->p[axis] + s->p[3];
    if (s->type == RTK_SHAPE_BOX)
        return sign > 0 ? s->p[3 + axis] : -s->p[axis];
    for (int i = 0; i < 3; i++) {
        n[i] = s->type == RTK_SHAPE_TORUS ? (real)s->p[4 + i] : (real)s->p[4 + i] - s->p[i];
        l += n[i] * n[i];
    }
    real across = sqrtl(real_max(0, 1 - n[axis] * n[axis] / l)), r1 = s->type == RTK_SHAPE_CONE ? s->p[7] : s->p[3];
    if (s->type == RTK_SHAPE_TORUS)
        return sign * s->p[axis] + s->p[3] * across + s->p[7];
    return real_max(sign * s->p[axis] + s->p[3] * across, sign * s->p[4 + axis] + r1 * across);
}

static void bounds_hold(void **state)
{
    (void)state;
    rng g = {5};
    for (int i = 0; i < 20000; i++) {
        rtk_vec3 at = rng_vec(&g, i % 3 ? 1.0f : 1000.0f), lo, hi;
        rtk_shape s = make_shape(&g, (rtk_u32)i % 5, i % 2 ? 1.0f : 0.01f, at);
        rtk_shape_bounds(&s, &lo, &hi);
        for (int k = 0; k < 3; k++) {
            real up = rtk_axis(hi, (rtk_u32)k) - reach(&s, k, 1), down = -rtk_axis(lo, (rtk_u32)k) - reach(&s, k, -1);
            real slack = 2e-6L * (fabsf(rtk_axis(at, (rtk_u32)k)) + 3);
            assert_true(up >= 0 && down >= 0);
            assert_true(up <= slack && down <= slack);
        }
    }
}

/* What shading asks: on the surface, normal outwards (to first order), parameters in range. */
static void surface_is_right(void **state)
{
    (void)state;
    rng g = {6};
    int tried = 0;
    for (int i = 0; i < 60000; i++) {
        rtk_u32 type = (rtk_u32)i % 5;
        rtk_vec3 at = rng_vec(&g, 3.0f), org = rtk_add(at, rng_vec(&g, 4.0f)), dir = rtk_sub(rtk_add(at, rng_vec(&g, 0.7f)), org);
        rtk_shape s = make_shape(&g, type, 1.0f, at);
        rtk_pray r = {0};
        rtk_shape_point p;
        float t = 0, u = 0, v = 0;
        if (!prepare(org, dir, 0, RTK_INF, rtk_v3(-5, -5, -5), rtk_v3(5, 5, 5), &r) || !rtk_shape_intersect(&r, &s, &t, &u, &v))
            continue;
        rtk_shape_surface(&s, rtk_madd(org, t, dir), &p);
        tried++;
        assert_true(u >= 0 && u <= 1 && v >= 0 && v <= 1 && rtk_finite(u) && rtk_finite(v));
        assert_true(fabsf(rtk_len(p.ng) - 1) < 1e-6f && fabsf(rtk_len(p.dpdu) - 1) < 1e-6f);
        assert_true(fabsf(rtk_dot3(p.ng, p.dpdu)) < 2e-6f);
        assert_true(fabsl(sdf(&s, real3_of(p.p))) <= p.error);
        assert_true(rtk_len(rtk_sub(p.p, rtk_madd(org, t, dir))) < 1e-4f);
        /* a small step out is outside by about its length, a step in is inside */
        real out = sdf(&s, real3_madd(real3_of(p.p), 1e-3L, real3_of(p.ng))),
             in = sdf(&s, real3_madd(real3_of(p.p), -1e-4L, real3_of(p.ng)));
        assert_true(fabsl(out - 1e-3L) < 2e-4L);
        assert_true(in < 0);
    }
    assert_true(tried > 20000);
}

static void planes_are_hit(void **state)
{
    (void)state;
    rng g = {7};
    real worst = 0;
    for (int i = 0; i < 100000; i++) {
        rtk_shape s = {RTK_SHAPE_PLANE, 0, 0, 0, {0}};
        rtk_ray r = {rng_vec(&g, i % 2 ? 1.0f : 1e4f), rng_dir(&g), 0.0f, 1e30f, ~0u};
        float t = 0, u = 0, v = 0;
        shape_vec(&s, 0, rng_vec(&g, 10.0f));
        shape_vec(&s, 4, rng_dir(&g));
        real3 n = {s.p[4], s.p[5], s.p[6]}, o = real3_of(r.org), d = real3_of(r.dir), c = {s.p[0], s.p[1], s.p[2]};
        real den = real3_dot(n, d), want = real3_dot(n, real3_sub(c, o)) / den;
        int hit = rtk_plane_intersect(r, &s, &t, &u, &v);
        if (fabsl(den) < 1e-6L)
            continue;
        assert_int_equal(hit, want > 0);
        if (hit)
            worst = real_max(worst, fabsl(t - want) / want);
    }
    print_message("plane: worst relative error of t %.2Le\n", worst);
    assert_true(worst < 1e-6L);
    rtk_shape floor = {RTK_SHAPE_PLANE, 0, 0, 0, {0, 1, 0, 0, 0, 1, 0}};
    rtk_ray in = {{0, 1, 0}, {1, 0, 0}, 0.0f, RTK_INF, ~0u};
    float t = 0, u = 0, v = 0;
    assert_false(rtk_plane_intersect(in, &floor, &t, &u, &v));
    in.org.y = 2;
    assert_false(rtk_plane_intersect(in, &floor, &t, &u, &v));
}

/* A few answers known by heart, and both roots of a body for the rays that start in it. */
static void known_answers(void **state)
{
    (void)state;
    const rtk_vec3 lo = {-4, -4, -4}, hi = {4, 4, 4};
    rtk_shape sphere = {RTK_SHAPE_SPHERE, 0, 0, 0, {0, 0, 0, 2}};
    rtk_shape torus = {RTK_SHAPE_TORUS, 0, 0, 0, {0, 0, 0, 2, 0, 0, 1, 0.5f}};
    rtk_shape cylinder = {RTK_SHAPE_CYLINDER, 0, 0, 0, {0, 0, -1, 1, 0, 0, 1, 0}};
    rtk_pray r = {0};
    float t[4] = {0}, u = 0, v = 0;
    assert_true(prepare(rtk_v3(-4, 0, 0), rtk_v3(1, 0, 0), 0, RTK_INF, lo, hi, &r));
    assert_int_equal(rtk_shape_roots(&r, &sphere, t), 2);
    assert_true(t[0] == 2.0f && t[1] == 6.0f);
    assert_int_equal(rtk_shape_roots(&r, &torus, t), 4);
    assert_true(fabsf(t[0] - 1.5f) < 1e-6f && fabsf(t[1] - 2.5f) < 1e-6f && fabsf(t[2] - 5.5f) < 1e-6f &&
                fabsf(t[3] - 6.5f) < 1e-6f);
    r.tmin = 2.0f; /* open: the first root of the sphere does not count any more */
    assert_int_equal(rtk_shape_roots(&r, &sphere, t), 1);
    assert_true(t[0] == 6.0f);
    assert_true(prepare(rtk_v3(0, 0, 0), rtk_v3(0, 0, 2), 0, RTK_INF, lo, hi, &r)); /* along the cylinder's axis, from inside */
    assert_true(rtk_shape_intersect(&r, &cylinder, t, &u, &v));
    assert_true(t[0] == 0.5f && v == 0.0f);
    assert_int_equal(rtk_shape_roots(&r, &torus, t), 0); /* through the hole */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(roots_are_right),  cmocka_unit_test(needles_are_no_thicker), cmocka_unit_test(bounds_hold),
        cmocka_unit_test(surface_is_right), cmocka_unit_test(planes_are_hit),         cmocka_unit_test(known_answers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
