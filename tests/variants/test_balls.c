/* Spheres (trace/ball_lanes.inl, bvh_lone_ball.h, bvh_stream_ball.h) and other shapes (shape_lanes.inl, shape_leaf.h), by
 * themselves and with what else there is, in every way that rays come: every tracer against brute force, bit for bit. Some are
 * twins, some spheres share their middle, rays start in them, on them and far away, and begin and end at hits. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <librt/rt.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/many.h"
#include "support/mesh.h"
#include "support/rays.h"

#define RAYS 1536u

/* What stands with spheres; count of those; largest and smallest radius; how far rays start, in sizes. sticks: cylinders and
 * cones from one sphere to another. */
typedef struct kind {
    const char *name;
    uint32_t count;
    float least, most, far;
    uint32_t boxes, triangles, instances, sticks, tori;
} kind;

static rt_ray rays[RAYS];
static rt_ray_block blocks[RAYS / 16];
static rt_hit brute[RAYS], other[RAYS];
static rt_hit_block hit_blocks[RAYS / 16];
static uint8_t brute_occluded[RAYS], other_occluded[RAYS];
static uint16_t occluded_blocks[RAYS / 16];

static rt_vec3 anywhere(test_rng *rng, float size)
{
    const float x = test_range(rng, -size, size), y = test_range(rng, -size, size);
    return (rt_vec3){x, y, test_range(rng, -size, size)};
}

static rt_vec3 plus(rt_vec3 a, rt_vec3 b)
{
    return (rt_vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}

/* ---- scenes ---- */

static void add_spheres(const kind *a, rt_scene *s, float *centers, float *radii, test_rng *rng)
{
    rt_spheres_desc d = rt_spheres_desc_default();
    rt_geometry handle;
    for (uint32_t i = 0; i < a->count; i++) {
        const uint32_t like = i == 0 ? 0 : test_u32(rng) % i;
        const rt_vec3 c = anywhere(rng, 1.0f);
        memcpy(centers + 3 * (size_t)i, i % 16 == 9 ? centers + 3 * (size_t)like : &c.x, 3 * sizeof *centers);
        radii[i] = i % 32 == 9 ? radii[like] : a->least + (a->most - a->least) * test_unit(rng) * test_unit(rng);
    }
    d.centers = centers;
    d.radii = radii;
    d.count = a->count;
    assert_int_equal(rt_scene_add_spheres(s, &d, &handle), RT_OK);
}

static void add_others(const kind *a, rt_scene *s, test_rng *rng)
{
    rt_geometry handle;
    for (uint32_t i = 0; i < a->boxes; i++) {
        rt_box_desc d = rt_box_desc_default();
        d.low = anywhere(rng, 1.0f);
        d.high = plus(d.low, (rt_vec3){0.1f, 0.2f * (test_unit(rng) + 0.01f), 0.1f});
        assert_int_equal(rt_scene_add_box(s, &d, &handle), RT_OK);
    }
    for (uint32_t i = 0; i < a->triangles; i++) {
        const rt_vec3 at = anywhere(rng, 1.0f);
        const rt_vec3 v[3] = {at, plus(at, anywhere(rng, 0.4f)), plus(at, anywhere(rng, 0.4f))};
        const uint32_t index[3] = {0, 1, 2};
        rt_mesh_desc d = rt_mesh_desc_default();
        d.positions = &v[0].x;
        d.vertex_count = 3;
        d.indices = index;
        d.triangle_count = 1;
        assert_int_equal(rt_scene_add_mesh(s, &d, &handle), RT_OK);
    }
}

/* Cylinders and cones between spheres' middles, some twice, flat, or pointed; and tori. */
static void add_sticks(const kind *a, rt_scene *s, const float *centers, test_rng *rng)
{
    rt_cone_desc d = rt_cone_desc_default();
    rt_geometry handle;
    for (uint32_t i = 0; i < a->sticks; i++) {
        const float *from = centers + 3 * (size_t)(test_u32(rng) % a->count),
                    *to = centers + 3 * (size_t)(test_u32(rng) % a->count);
        const float radius = a->least + 0.5f * (a->most - a->least) * test_unit(rng), part = i % 5 ? 0.3f : 0.003f;
        if (i % 16 != 9) { /* else as the one before */
            d.from = (rt_vec3){from[0], from[1], from[2]};
            d.to = plus(d.from, (rt_vec3){part * (to[0] - from[0]), part * (to[1] - from[1]), part * (to[2] - from[2]) + 1e-5f});
            d.radius0 = radius;
            d.radius1 = i % 2 ? 0.0f : 2.0f * radius;
        }
        assert_int_equal(i % 3 == 2 ? rt_scene_add_cone(s, &d, &handle) : rt_scene_add_cylinder(s, &d, &handle), RT_OK);
    }
    for (uint32_t i = 0; i < a->tori; i++) {
        rt_torus_desc torus = rt_torus_desc_default();
        torus.center = anywhere(rng, 1.0f);
        torus.axis = anywhere(rng, 1.0f);
        torus.major_radius = 0.3f;
        torus.minor_radius = 0.1f;
        assert_int_equal(rt_scene_add_torus(s, &torus, &handle), RT_OK);
    }
}

/* The scene itself, or one in which it stands several times. */
static rt_scene *place(const kind *a, rt_context *ctx, rt_scene *s, test_rng *rng)
{
    rt_scene *top;
    assert_int_equal(rt_scene_commit(s, NULL), RT_OK);
    if (a->instances == 0)
        return s;
    assert_int_equal(rt_scene_create(ctx, &top), RT_OK);
    for (uint32_t i = 0; i < a->instances; i++) {
        rt_instance_desc d = rt_instance_desc_default();
        rt_instance handle;
        d.child = s;
        d.transform = rt_transform_multiply(rt_transform_translate(anywhere(rng, 3.0f)),
                                            rt_transform_rotate((rt_vec3){0, 1, 0.3f}, 360.0f * test_unit(rng)));
        assert_int_equal(rt_scene_add_instance(top, &d, &handle), RT_OK);
    }
    assert_int_equal(rt_scene_commit(top, NULL), RT_OK);
    return top;
}

/* ---- rays ---- */

/* To points in and around spheres, or past all: from one eye, from anywhere, from in or on a sphere, or from far away. */
static void fill(const kind *a, const float *centers, const float *radii, test_rng *rng)
{
    const rt_vec3 eye = anywhere(rng, 2.0f);
    for (uint32_t i = 0; i < RAYS; i++) {
        const uint32_t k = test_u32(rng) % a->count;
        const rt_vec3 c = {centers[3 * (size_t)k], centers[3 * (size_t)k + 1], centers[3 * (size_t)k + 2]};
        const rt_vec3 at = plus(c, anywhere(rng, 1.2f * radii[k]));
        rt_vec3 from = i < RAYS / 3 ? eye : anywhere(rng, 2.0f), to;
        if (i % 7 == 6)
            from = plus(c, i % 2 ? (rt_vec3){0, 0, radii[k]} : anywhere(rng, radii[k]));
        to = (rt_vec3){at.x - from.x, at.y - from.y, at.z - from.z};
        if (a->far > 0.0f && i % 11 != 3) {
            const rt_vec3 way = anywhere(rng, 1.0f);
            to = way;
            from = (rt_vec3){at.x - a->far * way.x, at.y - a->far * way.y, at.z - a->far * way.z};
        }
        rays[i] = (rt_ray){from, 0.0f, to, INFINITY, i % 61 ? RT_MASK_ALL : 0u};
        if (i % 9 == 5)
            rays[i].tmax = 2.0f * test_unit(rng);
        if (i % 13 == 5)
            rays[i].tmin = i % 2 ? -INFINITY : -test_unit(rng);
    }
}

/* Some ranges begin and end at hits. */
static void limit(const rt_tracer *tracer, test_rng *rng)
{
    rt_tracer_intersect(tracer, rays, brute, RAYS, 0);
    for (uint32_t i = 0; i < RAYS; i++) {
        if (brute[i].prim_id == RT_INVALID_ID || i % 3)
            continue;
        if (test_u32(rng) % 2)
            rays[i].tmin = brute[i].t;
        else
            rays[i].tmax = i % 2 ? brute[i].t : nextafterf(brute[i].t, INFINITY);
    }
    rt_tracer_intersect(tracer, rays, brute, RAYS, 0);
    rt_tracer_occluded(tracer, rays, brute_occluded, RAYS, 0);
    for (uint32_t i = 0; i < RAYS; i++) {
        rt_ray_block *b = &blocks[i / 16];
        const rt_ray *r = &rays[i];
        b->org_x[i % 16] = r->org.x;
        b->org_y[i % 16] = r->org.y;
        b->org_z[i % 16] = r->org.z;
        b->dir_x[i % 16] = r->dir.x;
        b->dir_y[i % 16] = r->dir.y;
        b->dir_z[i % 16] = r->dir.z;
        b->tmin[i % 16] = r->tmin;
        b->tmax[i % 16] = r->tmax;
        b->mask[i % 16] = r->mask;
    }
}

static void check(const char *scene, const char *tracer, const char *way)
{
    for (uint32_t i = 0; i < RAYS; i++) {
        const rt_hit *a = &brute[i], *b = &other[i];
        if (memcmp(a, b, sizeof *a) != 0 || brute_occluded[i] != other_occluded[i])
            fail_msg("%s, %s, %s, ray %u: t %a u %a v %a prim %u geom %u inst %u occluded %d; brute %a %a %a %u %u %u %d", scene,
                     tracer, way, i, (double)b->t, (double)b->u, (double)b->v, b->prim_id, b->geom_id, b->inst_id,
                     other_occluded[i], (double)a->t, (double)a->u, (double)a->v, a->prim_id, a->geom_id, a->inst_id,
                     brute_occluded[i]);
    }
}

/* Calls of `size` rays. */
static void ask(const rt_tracer *tracer, uint32_t size, uint32_t hints)
{
    for (uint32_t i = 0; i < RAYS; i += size) {
        const uint32_t n = RAYS - i < size ? RAYS - i : size;
        rt_tracer_intersect(tracer, rays + i, other + i, n, hints);
        rt_tracer_occluded(tracer, rays + i, other_occluded + i, n, hints);
    }
}

static void ask_blocks(const rt_tracer *tracer)
{
    rt_tracer_intersect_blocks(tracer, blocks, hit_blocks, RAYS, 0);
    rt_tracer_occluded_blocks(tracer, blocks, occluded_blocks, RAYS, 0);
    for (uint32_t i = 0; i < RAYS; i++) {
        const rt_hit_block *h = &hit_blocks[i / 16];
        const uint32_t k = i % 16;
        other[i] = (rt_hit){h->t[k], h->u[k], h->v[k], h->prim_id[k], h->geom_id[k], h->inst_id[k]};
        other_occluded[i] = occluded_blocks[i / 16] >> k & 1;
    }
}

static void sweep(const kind *a, rt_scene *scene)
{
    static const char *names[] = {"bvh", "kdtree", "octree", "auto"};
    for (uint32_t k = 0; k < 4; k++) {
        rt_tracer *tracer;
        assert_int_equal(rt_tracer_create(scene, names[k], &tracer), RT_OK);
        ask(tracer, RAYS, 0);
        check(a->name, names[k], "all");
        ask(tracer, RAYS, RT_RAYS_COHERENT);
        check(a->name, names[k], "coherent");
        ask(tracer, 80, 0);
        check(a->name, names[k], "eighty a call");
        ask(tracer, 1, 0);
        check(a->name, names[k], "one a call");
        ask_blocks(tracer);
        check(a->name, names[k], "blocks");
        rt_tracer_destroy(tracer);
    }
}

static void test_all(void **state)
{
    const kind kinds[] = {
        {"three", 3, 0.2f, 0.9f, 0, 0, 0, 0, 0, 0},
        {"many", TEST_MANY(3000), 0.005f, 0.06f, 0, 0, 0, 0, 0, 0}, /* any hits among so many go in streams (STREAM_BALLS) */
        {"large ones that overlap", 90, 0.1f, 0.8f, 0, 0, 0, 0, 0, 0},
        {"with boxes", 60, 0.01f, 0.2f, 0, 7, 0, 0, 0, 0},
        {"with more boxes", 20, 0.01f, 0.2f, 0, 40, 0, 0, 0, 0},
        {"with triangles", 60, 0.01f, 0.2f, 0, 3, 60, 0, 0, 0},
        {"of very different sizes", 200, 1e-5f, 3.0f, 0, 0, 0, 0, 0, 0},
        {"far", 300, 0.01f, 0.1f, 40, 0, 0, 0, 0, 0},
        {"very far", 300, 0.01f, 0.1f, 3e5f, 0, 0, 0, 0, 0},
        {"far, with triangles", 90, 0.01f, 0.1f, 200, 2, 60, 0, 0, 0},
        {"placed", 120, 0.01f, 0.2f, 0, 0, 0, 5, 0, 0},
        {"placed, with triangles, far", 60, 0.01f, 0.2f, 60, 2, 30, 5, 0, 0},
        {"with sticks", TEST_MANY(600), 0.005f, 0.06f, 0, 0, 0, 0, TEST_MANY(1800), 0}, /* streams of any hits, as above */
        {"with large sticks", 20, 0.05f, 0.3f, 0, 0, 0, 0, 60, 0},
        {"with needles", 300, 1e-5f, 1e-4f, 0, 0, 0, 0, 900, 0},
        {"with all kinds", 60, 0.01f, 0.2f, 0, 30, 0, 0, 60, 6},
        {"with all kinds, far", 60, 0.01f, 0.2f, 40, 30, 0, 0, 60, 6},
        {"with all kinds, very far", 60, 0.01f, 0.2f, 3e5f, 30, 0, 0, 60, 6},
        {"with all kinds on triangles", 60, 0.01f, 0.2f, 0, 30, 60, 0, 60, 6},
        {"with more tori", 20, 0.01f, 0.2f, 0, 0, 0, 0, 20, 20},
        {"with a few tori", 60, 0.01f, 0.2f, 0, 0, 0, 0, 0, 6}, /* no forms */
        {"placed, all kinds", 60, 0.01f, 0.2f, 0, 10, 0, 5, 60, 3},
    };
    (void)state;
    for (uint32_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        const kind *a = &kinds[i];
        test_rng rng = {1000 + i};
        float *centers = malloc(3 * sizeof *centers * a->count), *radii = malloc(sizeof *radii * a->count);
        rt_context_desc d = rt_context_desc_default();
        rt_context *ctx;
        rt_scene *own, *scene;
        rt_tracer *tracer;
        assert_true(centers && radii);
        d.workers = 1;
        assert_int_equal(rt_context_create(&d, &ctx), RT_OK);
        assert_int_equal(rt_scene_create(ctx, &own), RT_OK);
        add_spheres(a, own, centers, radii, &rng);
        add_others(a, own, &rng);
        add_sticks(a, own, centers, &rng);
        scene = place(a, ctx, own, &rng);
        assert_int_equal(rt_tracer_create(scene, "brute", &tracer), RT_OK);
        fill(a, centers, radii, &rng);
        limit(tracer, &rng);
        rt_tracer_destroy(tracer);
        sweep(a, scene);
        if (scene != own)
            rt_scene_destroy(scene);
        rt_scene_destroy(own);
        rt_context_destroy(ctx);
        free(centers);
        free(radii);
    }
}

static void add_equal_mesh(rt_scene *s)
{
    static const float v[] = {-9, -9, 1, 9, -9, 1, 0, 9, 1};
    static const uint32_t index[] = {0, 1, 2};
    rt_mesh_desc d = rt_mesh_desc_default();
    rt_geometry handle;
    d.positions = v;
    d.vertex_count = 3;
    d.indices = index;
    d.triangle_count = 1;
    assert_int_equal(rt_scene_add_mesh(s, &d, &handle), RT_OK);
}

/* Spheres one like the other, and triangles that touch them, where rays meet all at one t: the order of hits decides. */
static void test_equal(void **state)
{
    static float centers[3 * 24], radii[24];
    (void)state;
    for (uint32_t order = 0; order < 4; order++) { /* triangles before spheres, behind, on both sides; and from far away */
        const kind a = {"equal hits", 24, 0, 0, 0, 0, 0, 0, 0, 0};
        rt_spheres_desc d = rt_spheres_desc_default();
        rt_context_desc c = rt_context_desc_default();
        test_rng rng = {order};
        rt_context *ctx;
        rt_scene *s;
        rt_geometry handle;
        rt_tracer *tracer;
        c.workers = 1;
        assert_int_equal(rt_context_create(&c, &ctx), RT_OK);
        assert_int_equal(rt_scene_create(ctx, &s), RT_OK);
        for (uint32_t i = 0; i < a.count; i++) {
            centers[3 * i] = (float)(i % 3);
            radii[i] = 1.0f;
        }
        d.centers = centers;
        d.radii = radii;
        d.count = a.count;
        if (order != 1)
            add_equal_mesh(s);
        assert_int_equal(rt_scene_add_spheres(s, &d, &handle), RT_OK);
        if (order != 0)
            add_equal_mesh(s);
        assert_int_equal(rt_scene_commit(s, NULL), RT_OK);
        for (uint32_t i = 0; i < RAYS; i++) {
            const float side = i % 5 == 4 ? test_range(&rng, -0.1f, 0.1f) : 0.0f;
            const rt_vec3 from = {(float)(i % 3) + side, side, order < 3 ? 3.0f + (float)(i % 7) : 128.0f};
            rays[i] = (rt_ray){from, 0.0f, {0, 0, -1}, INFINITY, RT_MASK_ALL};
        }
        assert_int_equal(rt_tracer_create(s, "brute", &tracer), RT_OK);
        limit(tracer, &rng);
        rt_tracer_destroy(tracer);
        sweep(&a, s);
        rt_scene_destroy(s);
        rt_context_destroy(ctx);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_all), cmocka_unit_test(test_equal)};
    (void)test_isa();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
