/* Rays that leave a surface do not meet it again: no scene epsilon, at any size and place (rtk_surface_leave). */
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <setjmp.h>
#include <cmocka.h>

#include "kernel/shapes.h"
#include "kernel/surface.h"
#include "kernel_sdf.h"
#include "kernel_alone.h"

/* A scene of one primitive, perhaps in an instance. */
typedef struct world {
    rtk_tri tri;
    rtk_shape shape;
    rtk_geom geom;
    rtk_group group;
    rtk_instance inst;
    rtk_scene scene;
    rtk_vec3 lo, hi; /* of the group, not grown */
    int placed;
} world;

static void finish_world(world *w, int shapes)
{
    w->geom.type = shapes ? RTK_GEOM_SHAPES : RTK_GEOM_MESH;
    w->geom.prim_count = 1;
    w->geom.uv_xfm[0] = w->geom.uv_xfm[4] = 1.0f;
    w->group.tri_count = !shapes;
    w->group.shape_count = (rtk_u32)shapes;
    w->group.tris = &w->tri;
    w->group.shapes = &w->shape;
    w->group.geoms = &w->geom;
    w->group.geom_count = 1;
    w->scene.groups = &w->group;
    w->scene.group_count = 1;
    w->scene.instances = &w->inst;
    w->scene.instance_count = (rtk_u32)w->placed;
}

static int trace(const world *w, rtk_ray ray, rtk_hit *hit)
{
    rtk_pray r = {0};
    *hit = rtk_hit_none(ray.tmax);
    if (w->placed) {
        ray.org = rtk_xfm_point(w->inst.to_object, ray.org);
        ray.dir = rtk_xfm_dir(w->inst.to_object, ray.dir);
    }
    if (!prepare(ray.org, ray.dir, ray.tmin, ray.tmax, w->lo, w->hi, &r))
        return 0;
    if (w->group.tri_count ? !rtk_tri_intersect(&r, &w->tri, &hit->t, &hit->u, &hit->v)
                           : !rtk_shape_intersect(&r, &w->shape, &hit->t, &hit->u, &hit->v))
        return 0;
    hit->prim = hit->geom = 0;
    hit->inst = w->placed ? 0 : RTK_INVALID;
    return 1;
}

/* Direction about the normal whose cosine is at least `least`, on the given side. */
static rtk_vec3 away(rng *g, rtk_vec3 n, float least, float side)
{
    rtk_vec3 x, y, d = rng_dir(g);
    float c = least + (1 - least) * rng_unit(g) * rng_unit(g), a, b, l;
    rtk_basis(n, &x, &y);
    a = rtk_dot3(d, x);
    b = rtk_dot3(d, y);
    l = sqrtf((1 - c * c) / (a * a + b * b + 1e-20f));
    return rtk_add(rtk_scale(n, side * c), rtk_add(rtk_scale(x, a * l), rtk_scale(y, b * l)));
}

static void place(world *w, rng *g, float size)
{
    rtk_vec3 x, y, z = rng_dir(g), at = rng_vec(g, 3 * size);
    float k = 0.5f + rng_unit(g);
    rtk_basis(z, &x, &y);
    w->placed = 1;
    w->inst.material = RTK_INVALID;
    const float m[12] = {k * x.x, k * y.x, k * z.x, at.x, k * x.y, k * y.y, k * z.y, at.y, k * x.z, k * y.z, k * z.z, at.z};
    const float i[12] = {x.x / k, x.y / k, x.z / k, -rtk_dot3(x, at) / k, y.x / k, y.y / k, y.z / k, -rtk_dot3(y, at) / k,
                         z.x / k, z.y / k, z.z / k, -rtk_dot3(z, at) / k};
    memcpy(w->inst.to_world.m, m, sizeof m);
    memcpy(w->inst.to_object.m, i, sizeof i);
}

static const struct {
    const char *what;
    float size, move;
    int placed;
} places[] = {{"1", 1, 0, 0},        {"10^-3", 1e-3f, 0, 0},        {"10^6", 1e6f, 0, 0},          {"moved 10^4", 1, 1e4f, 0},
              {"instance", 1, 0, 1}, {"10^6 instance", 1e6f, 0, 1}, {"moved instance", 1, 1e2f, 1}};

/* A triangle is never met again by a ray that leaves it to either side: sliver, huge, tiny ones; steep and grazing rays. */
static void triangles_let_go(void **state)
{
    (void)state;
    for (size_t c = 0; c < sizeof places / sizeof *places; c++) {
        rng g = {1000 + c};
        int rays = 0, again = 0;
        for (int i = 0; i < 60000; i++) {
            world w = {0};
            float size = places[c].size, edge = i % 4 == 0 ? 1e-3f : 1.0f;
            rtk_vec3 at = rtk_scale(rtk_v3(1, -1, 0.5f), places[c].move * size), v[3], org, target;
            for (int k = 0; k < 3; k++)
                v[k] = rtk_add(at, rng_vec(&g, size * edge));
            if (i % 4 == 1)
                v[2] = rtk_add(rtk_madd(v[0], rng_unit(&g), rtk_sub(v[1], v[0])), rng_vec(&g, 1e-3f * size));
            memcpy(w.tri.v0, &v[0], sizeof *v);
            memcpy(w.tri.v1, &v[1], sizeof *v);
            memcpy(w.tri.v2, &v[2], sizeof *v);
            w.lo = rtk_sub(at, rtk_v3(size, size, size));
            w.hi = rtk_add(at, rtk_v3(size, size, size));
            if (places[c].placed)
                place(&w, &g, size);
            finish_world(&w, 0);
            float b = rng_unit(&g), d = (1 - b) * rng_unit(&g);
            target = rtk_madd(rtk_madd(v[0], b, rtk_sub(v[1], v[0])), d, rtk_sub(v[2], v[0]));
            org = rtk_madd(target, size * 3 * rng_unit(&g), rng_dir(&g));
            if (w.placed) {
                target = rtk_xfm_point(w.inst.to_world, target);
                org = rtk_xfm_point(w.inst.to_world, org);
            }
            rtk_ray ray = {org, rtk_sub(target, org), 0, RTK_INF, ~0u};
            rtk_hit hit;
            if (!trace(&w, ray, &hit))
                continue;
            rtk_surface s = rtk_surface_at(&w.scene, ray, hit, 0.0f);
            for (int k = 0; k < 4; k++) {
                rtk_vec3 dir = away(&g, s.ng, k < 2 ? 0.05f : 1e-3f, k % 2 ? 1.0f : -1.0f);
                rtk_ray next = {rtk_surface_leave(s, dir), dir, 0, RTK_INF, ~0u};
                rays++;
                again += trace(&w, next, &hit);
            }
        }
        print_message("triangles, %-14s: %d rays, %d met their own triangle again\n", places[c].what, rays, again);
        assert_true(rays > 50000);
        assert_int_equal(again, 0);
    }
}

/* A convex shape is not met again from outside; a ray into it meets its far side, well away. */
static void shapes_let_go(void **state)
{
    (void)state;
    static const char *const names[] = {"sphere", "box", "cylinder", "cone", "torus"};
    for (rtk_u32 type = 0; type < RTK_SHAPE_PLANE; type++)
        for (size_t c = 0; c < sizeof places / sizeof *places; c++) {
            rng g = {2000 + c + 100 * type};
            int rays = 0, again = 0;
            for (int i = 0; i < 20000; i++) {
                world w = {0};
                float size = places[c].size;
                rtk_vec3 at = rtk_scale(rtk_v3(1, -1, 0.5f), places[c].move * size), org, target;
                w.shape = make_shape(&g, type, 0.5f * size, at);
                rtk_shape_bounds(&w.shape, &w.lo, &w.hi);
                if (places[c].placed)
                    place(&w, &g, size);
                finish_world(&w, 1);
                target = rtk_add(at, rng_vec(&g, 0.5f * size));
                org = rtk_madd(target, size * 3 * rng_unit(&g), rng_dir(&g));
                if (w.placed) {
                    target = rtk_xfm_point(w.inst.to_world, target);
                    org = rtk_xfm_point(w.inst.to_world, org);
                }
                rtk_ray ray = {org, rtk_sub(target, org), 0, RTK_INF, ~0u};
                rtk_hit hit;
                if (!trace(&w, ray, &hit))
                    continue;
                rtk_surface s = rtk_surface_at(&w.scene, ray, hit, 0.0f);
                rtk_vec3 dir = away(&g, s.ng, type == RTK_SHAPE_TORUS ? 0.3f : 1e-2f, 1.0f), p = rtk_surface_leave(s, dir);
                rtk_ray next = {p, dir, 0, RTK_INF, ~0u};
                rays++;
                if (trace(&w, next, &hit) && (type != RTK_SHAPE_TORUS || hit.t < 1e-3f * size))
                    again++;
                next.dir = away(&g, s.ng, 0.3f, -1.0f);
                next.org = rtk_surface_leave(s, next.dir);
                /* inwards the next surface is the far one: a good part of the radius away */
                float thick = type == RTK_SHAPE_SPHERE ? w.shape.p[3] : (type == RTK_SHAPE_TORUS ? w.shape.p[7] : 0.0f);
                if (thick > 8 * s.error && trace(&w, next, &hit) && hit.t < 0.1f * thick)
                    again++;
            }
            print_message("%-8s %-14s: %d rays, %d met their own surface again\n", names[type], places[c].what, rays, again);
            assert_true(rays > 2000);
            assert_int_equal(again, 0);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(triangles_let_go),
        cmocka_unit_test(shapes_let_go),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
