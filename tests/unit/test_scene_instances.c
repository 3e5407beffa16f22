/* Instances under every tracer: their boxes have grown enough that no ray's rounding leaves them (scene/transform.c). */
#include "scene_kit.h"

#include <math.h>
#include <pthread.h>

#include "scene/scene.h"
#include "scene/snapshot.h"

static uint32_t seed = 11;

/* A transform that rounding suffers under: stretched on one axis after and before turning, moved far in comparison with its size.
 */
static rt_transform nasty(int round, float far)
{
    float stretch = powf(10, kit_range(&seed, -3, 3));
    rt_transform t = rt_transform_rotate(kit_vec(&seed, 1), kit_range(&seed, 0, 360));
    t = rt_transform_multiply(rt_transform_scale((rt_vec3){1, round % 2 ? stretch : 1, 1}), t);
    t = rt_transform_multiply(rt_transform_rotate(kit_vec(&seed, 1), kit_range(&seed, 0, 360)), t);
    if (round % 3 == 0)
        t = rt_transform_multiply(rt_transform_scale((rt_vec3){-1, 1, 1}), t); /* mirrored */
    return rt_transform_multiply(rt_transform_translate(kit_vec(&seed, far)), t);
}

static rt_vec3 apply(const rt_transform *t, rt_vec3 p)
{
    const float *m = t->m;
    return (rt_vec3){m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3], m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
                     m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]};
}

/* A child of a few triangles whose corners touch its box, and a sphere that does. off: how far from its own origin. */
static rt_scene *make_child(rt_context *ctx, float off, rt_vec3 corners[12])
{
    rt_scene *child = kit_scene(ctx);
    rt_mesh_desc d = rt_mesh_desc_default();
    uint32_t indices[12];
    for (uint32_t i = 0; i < 12; i++) {
        corners[i] = (rt_vec3){off + (i & 1 ? 1.0f : -1.0f), kit_range(&seed, -1, 1), i & 2 ? 1.0f : -1.0f};
        indices[i] = i;
    }
    d.positions = &corners[0].x;
    d.vertex_count = 12;
    d.indices = indices;
    d.triangle_count = 4;
    assert_int_equal(rt_scene_add_mesh(child, &d, NULL), RT_OK);
    kit_sphere(child, off, 0, 0, 1);
    kit_ok(ctx, rt_scene_commit(child, NULL));
    return child;
}

enum { INSTANCES = 24, RAYS = 1500 };

/* Rays at corners, edges and insides, from near and from 10^4 extents away. */
static rt_ray aim(const rt_transform *t, const rt_vec3 *corners, float far)
{
    uint32_t k = (uint32_t)kit_range(&seed, 0, 3.99f) * 3, i = (uint32_t)kit_range(&seed, 0, INSTANCES - 0.01f);
    float u = kit_range(&seed, 0, 1), v = kit_range(&seed, 0, 1) * (1 - u);
    rt_vec3 a = corners[k], b = corners[k + 1], c = corners[k + 2], p, to, from = kit_vec(&seed, far);
    if (kit_range(&seed, 0, 1) < 0.3f)
        v = 0; /* on an edge */
    if (kit_range(&seed, 0, 1) < 0.2f)
        u = v = 0; /* at a corner */
    p = (rt_vec3){a.x + u * (b.x - a.x) + v * (c.x - a.x), a.y + u * (b.y - a.y) + v * (c.y - a.y),
                  a.z + u * (b.z - a.z) + v * (c.z - a.z)};
    to = apply(&t[i], p);
    return kit_ray(from.x, from.y, from.z, to.x - from.x, to.y - from.y, to.z - from.z);
}

static void compare_tracers(rt_context *ctx, rt_scene *scene, const rt_ray *rays, uint32_t *hit_count)
{
    static const char *const tracers[] = {"brute", "kdtree", "octree", "bvh"};
    rt_hit *hits = malloc(2 * RAYS * sizeof *hits);
    uint8_t occluded[RAYS];
    for (int k = 0; k < 4; k++) {
        assert_int_equal(rt_scene_set_tracer(scene, tracers[k]), RT_OK);
        kit_ok(ctx, rt_scene_commit(scene, NULL));
        rt_scene_intersect(scene, rays, hits + (k ? RAYS : 0), RAYS);
        rt_scene_occluded(scene, rays, occluded, RAYS);
        for (int i = 0; i < RAYS; i++) {
            if (k == 0)
                *hit_count += hits[i].prim_id != RT_INVALID_ID;
            else if (memcmp(&hits[i], &hits[RAYS + i], sizeof *hits) != 0)
                fail_msg("%s, ray %d: t %.9g, not %.9g", tracers[k], i, (double)hits[RAYS + i].t, (double)hits[i].t);
            assert_int_equal(occluded[i], hits[i].prim_id != RT_INVALID_ID);
        }
    }
    free(hits);
}

static void test_bounds_hold(void **state)
{
    static const float offs[] = {0, 0, 1000, 0}, fars[] = {20, 3000, 20, 20}, reach[] = {50, 5000, 3000, 2e6f};
    rt_context *ctx = kit_context(NULL, 1);
    uint32_t hit_count = 0;
    (void)state;
    for (int round = 0; round < 12; round++) {
        rt_vec3 corners[12];
        rt_transform t[INSTANCES];
        rt_scene *child = make_child(ctx, offs[round % 4], corners), *scene = kit_scene(ctx);
        rt_instance_desc d = rt_instance_desc_default();
        rt_ray rays[RAYS];
        d.child = child;
        for (int i = 0; i < INSTANCES; i++) {
            t[i] = nasty(round + i, fars[round % 4]);
            d.transform = t[i];
            kit_ok(ctx, rt_scene_add_instance(scene, &d, NULL));
        }
        for (int i = 0; i < RAYS; i++)
            rays[i] = aim(t, corners, reach[round % 4]);
        compare_tracers(ctx, scene, rays, &hit_count);
        rt_scene_destroy(child);
        rt_scene_destroy(scene);
    }
    assert_true(hit_count > 12 * RAYS / 3);
    rt_context_destroy(ctx);
}

/* The bound itself: a ray mapped into an instance as the tracers map it, and the point at t mapped back without rounding, differ
 * by no more than the growth; and the bound is not far off: some ray uses a good part of it. */
static void test_growth(void **state)
{
    double most = 0.0;
    uint32_t checked = 0;
    (void)state;
    for (int round = 0; round < 3000; round++) {
        float far = powf(10, kit_range(&seed, 0, 4)), reach = 2 * far, by[3];
        rt_transform t = nasty(round, far);
        rtk_xfm m, w;
        memcpy(m.m, t.m, sizeof m.m);
        if (!rti_xfm_invert(&m, &w))
            continue;
        rti_xfm_growth(&m, &w, reach, by);
        for (int i = 0; i < 20; i++) {
            rt_vec3 from = kit_vec(&seed, 4 * reach), to = kit_vec(&seed, reach);
            float scale = powf(10, kit_range(&seed, -3, 3));
            rtk_vec3 o = rtk_v3(from.x, from.y, from.z);
            rtk_vec3 d = rtk_v3((to.x - from.x) * scale, (to.y - from.y) * scale, (to.z - from.z) * scale);
            rtk_vec3 oo = rtk_xfm_point(w, o), od = rtk_xfm_dir(w, d);
            double at = 1.0 / scale, q[3] = {oo.x + at * od.x, oo.y + at * od.y, oo.z + at * od.z};
            double p[3] = {o.x + at * d.x, o.y + at * d.y, o.z + at * d.z};
            if (fabs(p[0]) > reach || fabs(p[1]) > reach || fabs(p[2]) > reach)
                continue;
            for (int k = 0; k < 3; k++) {
                double back = m.m[4 * k] * q[0] + m.m[4 * k + 1] * q[1] + m.m[4 * k + 2] * q[2] + m.m[4 * k + 3];
                double used = fabs(back - p[k]) / by[k];
                assert_true(used <= 1.0);
                most = fmax(most, used);
            }
            checked++;
        }
    }
    assert_true(checked > 30000);
    assert_true(most > 0.05);
}

/* A child with a plane is met by every ray; an empty child and a removed instance by none; materials and masks are the parent's.
 */
static void test_odd_children(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *floor = kit_scene(ctx), *empty = kit_scene(ctx), *ball = kit_scene(ctx), *scene = kit_scene(ctx);
    rt_plane_desc plane = rt_plane_desc_default();
    rt_instance_desc d = rt_instance_desc_default();
    rt_material_desc md = rt_material_desc_default();
    rt_material red;
    rt_instance removed, on_floor;
    rt_ray down = kit_ray(1000, 50, -3000, 0, -1, 0), ray;
    rt_hit hit;
    rt_surface s;
    (void)state;
    md.color = (rt_vec3){1, 0, 0};
    assert_int_equal(rt_scene_add_material(scene, &md, &red), RT_OK);
    assert_int_equal(rt_scene_add_plane(floor, &plane, NULL), RT_OK);
    kit_sphere(floor, 0, 0, 0, 1);
    kit_sphere(ball, 0, 0, 0, 1);
    kit_ok(ctx, rt_scene_commit(floor, NULL));
    kit_ok(ctx, rt_scene_commit(empty, NULL));
    kit_ok(ctx, rt_scene_commit(ball, NULL));
    d.child = empty;
    kit_ok(ctx, rt_scene_add_instance(scene, &d, NULL));
    kit_ok(ctx, rt_scene_commit(scene, NULL)); /* nothing to find, and a place in the table */
    assert_int_equal(kit_hit(scene, kit_ray(0, 0, 9, 0, 0, -1)).prim_id, RT_INVALID_ID);
    d.child = ball;
    kit_ok(ctx, rt_scene_add_instance(scene, &d, &removed));
    d.child = floor;
    d.transform = rt_transform_translate((rt_vec3){0, 10, 0});
    d.material = red;
    kit_ok(ctx, rt_scene_add_instance(scene, &d, &on_floor));
    kit_ok(ctx, rt_scene_remove_instance(scene, removed));
    kit_ok(ctx, rt_scene_commit(scene, NULL));
    hit = kit_hit(scene, down);
    assert_true(hit.inst_id == on_floor.id && hit.geom_id == 0 && hit.t == 40);
    rt_scene_surface(scene, &down, &hit, &s);
    assert_int_equal(s.material.id, red.id);
    assert_int_equal(s.material_scene, 0);
    assert_true(s.color.x == 1 && s.color.y == 0);
    ray = kit_ray(0, 50, 0, 0, -1, 0);
    hit = kit_hit(scene, ray);
    assert_true(hit.inst_id == on_floor.id && hit.geom_id == 1 && fabsf(hit.t - 39) < 1e-4f);
    assert_int_equal(kit_hit(scene, kit_ray(0, 0, 9, 0, 0, -1)).prim_id, RT_INVALID_ID);
    rt_scene_destroy(floor);
    rt_scene_destroy(empty);
    rt_scene_destroy(ball);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

/* Materials and textures of children stand behind the parent's: a surface says whose they are. */
static void test_tables(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *child[2] = {kit_scene(ctx), kit_scene(ctx)}, *scene = kit_scene(ctx);
    (void)state;
    for (int i = 0; i < 2; i++) {
        uint8_t pixel[3] = {255, (uint8_t)(i ? 255 : 0), 0};
        rt_texture_desc td = rt_texture_desc_default();
        rt_material_desc md = rt_material_desc_default();
        rt_instance_desc d = rt_instance_desc_default();
        rt_material m;
        td.width = td.height = 1;
        td.pixels = pixel;
        assert_int_equal(rt_scene_add_texture(child[i], &td, &md.color_texture), RT_OK);
        assert_int_equal(rt_scene_add_material(child[i], &md, &m), RT_OK);
        assert_int_equal(rt_scene_set_geometry_material(child[i], (rt_geometry){kit_square(child[i], 1, 0)}, m), RT_OK);
        kit_ok(ctx, rt_scene_commit(child[i], NULL));
        d.child = child[i];
        d.transform = rt_transform_translate((rt_vec3){10 * (float)i, 0, 0});
        kit_ok(ctx, rt_scene_add_instance(scene, &d, NULL));
    }
    kit_ok(ctx, rt_scene_commit(scene, NULL));
    for (int i = 0; i < 2; i++) {
        rt_ray ray = kit_ray(10 * (float)i, 0.1f, 5, 0, 0, -1);
        rt_hit hit = kit_hit(scene, ray);
        rt_surface s;
        rt_scene_surface(scene, &ray, &hit, &s);
        assert_int_equal(s.material.id, 1);
        assert_int_equal(s.material_scene, 1 + i);
        assert_true(s.color.x == 1 && s.color.y == (float)i && s.color.z == 0);
        rt_scene_destroy(child[i]);
    }
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

static bool same_desc(const rt_instance_desc *a, const rt_instance_desc *b)
{
    return a->child == b->child && memcmp(&a->transform, &b->transform, sizeof a->transform) == 0 &&
           a->material.id == b->material.id && a->mask == b->mask && a->user_id == b->user_id &&
           a->motion_count == b->motion_count && (a->motion == NULL) == (b->motion == NULL) &&
           (!a->motion || memcmp(a->motion, b->motion, a->motion_count * sizeof *a->motion) == 0);
}

/* An instance is told as it was given and set since; what is refused leaves the descriptor alone. */
static void test_told_as_given(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *child = kit_scene(ctx), *scene = kit_scene(ctx);
    rt_transform places[3];
    rt_material_desc md = rt_material_desc_default();
    rt_instance_desc still = rt_instance_desc_default(), moving = still, got = still, untouched;
    rt_instance a, b, c;
    (void)state;
    kit_square(child, 1, 0);
    for (int i = 0; i < 3; i++)
        places[i] = rt_transform_translate((rt_vec3){(float)i + 1, 2, 3});
    still.child = moving.child = child;
    still.transform = nasty(3, 20);
    still.user_id = 7;
    moving.transform = rt_transform_translate((rt_vec3){0, 2, 3});
    moving.mask = RT_MASK_CAMERA | 0x100;
    moving.motion = places;
    moving.motion_count = 3;
    kit_ok(ctx, rt_scene_add_material(scene, &md, &moving.material));
    kit_ok(ctx, rt_scene_add_instance(scene, &still, &a));
    kit_ok(ctx, rt_scene_add_instance(scene, &moving, &b));
    for (int round = 0; round < 2; round++) { /* not committed yet; committed */
        kit_ok(ctx, rt_scene_get_instance(scene, a, &got));
        assert_true(same_desc(&got, &still) && got.struct_size == sizeof got);
        kit_ok(ctx, rt_scene_get_instance(scene, b, &got));
        assert_true(same_desc(&got, &moving) && got.motion != places);
        kit_ok(ctx, rt_scene_commit(child, NULL));
        kit_ok(ctx, rt_scene_commit(scene, NULL));
    }
    kit_ok(ctx, rt_scene_set_instance_motion(scene, b, got.motion + 1, 2)); /* its own places may be given again */
    moving.motion = places + 1;
    moving.motion_count = 2;
    kit_ok(ctx, rt_scene_get_instance(scene, b, &got));
    assert_true(same_desc(&got, &moving));
    kit_ok(ctx, rt_scene_add_instance(scene, &got, &c));
    kit_ok(ctx, rt_scene_get_instance(scene, c, &got));
    assert_true(same_desc(&got, &moving));
    kit_ok(ctx, rt_scene_set_instance_transform(scene, b, &still.transform));
    kit_ok(ctx, rt_scene_get_instance(scene, b, &got));
    assert_true(got.motion == NULL && got.motion_count == 0 &&
                memcmp(&got.transform, &still.transform, sizeof got.transform) == 0);

    /* an earlier client's descriptor ends before the motion, a later one's goes on */
    got = moving;
    got.struct_size = (uint32_t)offsetof(rt_instance_desc, motion);
    kit_ok(ctx, rt_scene_get_instance(scene, a, &got));
    assert_true(got.user_id == 7 && got.motion == moving.motion && got.struct_size == offsetof(rt_instance_desc, motion));
    got.struct_size = sizeof got + 64;
    kit_ok(ctx, rt_scene_get_instance(scene, a, &got));
    assert_true(same_desc(&got, &still) && got.struct_size == sizeof got);

    untouched = got;
    assert_int_equal(rt_scene_get_instance(NULL, a, &got), RT_ERROR_ARGUMENT);
    assert_int_equal(rt_scene_get_instance(scene, a, NULL), RT_ERROR_ARGUMENT);
    kit_says(ctx, "rt_scene_get_instance: the descriptor is NULL");
    assert_int_equal(rt_scene_get_instance(scene, (rt_instance){3}, &got), RT_ERROR_ARGUMENT);
    kit_says(ctx, "rt_scene_get_instance: instance 3 is not one of the scene");
    kit_ok(ctx, rt_scene_remove_instance(scene, a));
    assert_int_equal(rt_scene_get_instance(scene, a, &got), RT_ERROR_ARGUMENT);
    kit_says(ctx, "rt_scene_get_instance: instance 0 was removed");
    assert_memory_equal(&got, &untouched, sizeof got);
    got.struct_size = 0;
    assert_int_equal(rt_scene_get_instance(scene, b, &got), RT_ERROR_ARGUMENT);
    kit_says(ctx, "struct_size is 0; begin with the matching _default() function");
    rt_scene_destroy(scene);
    rt_scene_destroy(child);
    rt_context_destroy(ctx);
}

/* A ball of specks. */
enum { SPECKS = 800 };
static rt_scene *make_ball(rt_context *ctx, rt_vec3 corners[3 * SPECKS], rt_geometry *ball)
{
    rt_scene *child = kit_scene(ctx);
    rt_mesh_desc d = rt_mesh_desc_default();
    uint32_t indices[3 * SPECKS];
    for (uint32_t i = 0; i < SPECKS; i++) {
        const rt_vec3 v = kit_vec(&seed, 1);
        const float by = 1.0f / sqrtf(v.x * v.x + v.y * v.y + v.z * v.z);
        for (uint32_t k = 0; k < 3; k++) {
            corners[3 * i + k] = (rt_vec3){v.x * by + 0.05f * (k == 1), v.y * by + 0.05f * (k == 2), v.z * by};
            indices[3 * i + k] = 3 * i + k;
        }
    }
    d.positions = &corners[0].x;
    d.vertex_count = 3 * SPECKS;
    d.indices = indices;
    d.triangle_count = SPECKS;
    assert_int_equal(rt_scene_add_mesh(child, &d, ball), RT_OK);
    kit_ok(ctx, rt_scene_commit(child, NULL));
    return child;
}

static double volume(const float lo[3], const float hi[3])
{
    return ((double)hi[0] - lo[0]) * ((double)hi[1] - lo[1]) * ((double)hi[2] - lo[2]);
}

enum { TURNED = 90 };

/* All corners of each instance are in its box; returns what boxes are of their turned boxes on an average, of every third none.
 */
static double boxes_hold(const rt_scene *scene, const rt_transform *t, const rt_vec3 *corners)
{
    rti_snapshot *snapshot = rti_scene_snapshot(scene);
    const rtk_scene *v = rti_snapshot_view(snapshot);
    double ratios = 0.0;
    rtk_vec3 all_lo, all_hi;
    rti_snapshot_bounds(snapshot, &all_lo, &all_hi);
    for (int i = 0; i < TURNED; i++) {
        const rtk_instance *inst = &v->instances[i];
        const rtk_group *g = &v->groups[inst->group];
        float lo[3], hi[3];
        for (uint32_t k = 0; k < 3 * SPECKS; k++) {
            for (int r = 0; r < 3; r++) {
                const float *m = t[i].m + 4 * r;
                const double at = (double)m[0] * corners[k].x + (double)m[1] * corners[k].y + (double)m[2] * corners[k].z + m[3];
                assert_true(at > inst->lo[r] && at < inst->hi[r]);
            }
        }
        rti_xfm_bounds(&inst->to_world, (float[3]){g->lo.x, g->lo.y, g->lo.z}, (float[3]){g->hi.x, g->hi.y, g->hi.z}, lo, hi);
        assert_true(lo[0] >= all_lo.x && lo[1] >= all_lo.y && lo[2] >= all_lo.z);
        assert_true(hi[0] <= all_hi.x && hi[1] <= all_hi.y && hi[2] <= all_hi.z);
        if (i % 3 != 0) /* others are so far away, or so long, that what boxes grow by counts */
            ratios += volume(inst->lo, inst->hi) / volume(lo, hi);
    }
    rti_snapshot_release(snapshot);
    return ratios / (TURNED - TURNED / 3);
}

/* What is turned has a box of its own, not that of its turned box, and all of it is in there, also when it was moved, which its
 * cover outlives, or deformed, which it does not; the scene's bounds are those of the turned boxes. */
static void test_turned_boxes(void **state)
{
    static rt_vec3 corners[3 * SPECKS];
    rt_context *ctx = kit_context(NULL, 1);
    rt_geometry ball;
    rt_scene *child = make_ball(ctx, corners, &ball), *scene = kit_scene(ctx);
    rt_transform t[TURNED];
    (void)state;
    for (int i = 0; i < TURNED; i++) {
        rt_instance_desc d = rt_instance_desc_default();
        t[i] = i % 3 == 0 ? nasty(i, 100) : rt_transform_rotate(kit_vec(&seed, 1), kit_range(&seed, 30, 60));
        d.child = child;
        d.transform = t[i];
        kit_ok(ctx, rt_scene_add_instance(scene, &d, NULL));
    }
    kit_ok(ctx, rt_scene_commit(scene, NULL));
    assert_true(boxes_hold(scene, t, corners) < 0.6); /* a ball's would be .3 to .6 */
    for (uint32_t i = 1; i < TURNED; i += 3) {
        t[i] = rt_transform_multiply(rt_transform_translate(kit_vec(&seed, 3)), t[i]);
        kit_ok(ctx, rt_scene_set_instance_transform(scene, (rt_instance){i}, &t[i]));
    }
    kit_ok(ctx, rt_scene_commit(scene, NULL));
    assert_true(boxes_hold(scene, t, corners) < 0.6);
    for (uint32_t k = 0; k < 3 * SPECKS; k++)
        corners[k] = (rt_vec3){1.5f * corners[k].x, corners[k].y, corners[k].z + 0.2f * corners[k].x};
    kit_ok(ctx, rt_scene_set_mesh_positions(child, ball, &corners[0].x, NULL, 3 * SPECKS));
    kit_ok(ctx, rt_scene_commit(child, NULL));
    kit_ok(ctx, rt_scene_commit(scene, NULL));
    assert_true(boxes_hold(scene, t, corners) < 0.7);
    rt_scene_destroy(scene);
    rt_scene_destroy(child);
    rt_context_destroy(ctx);
}

/* A scene whose instances were all removed has none, and is placed as any other. */
static void test_removed_of_a_child(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *ball = kit_scene(ctx), *child = kit_scene(ctx), *scene = kit_scene(ctx);
    rt_instance_desc d = rt_instance_desc_default();
    rt_instance in_child;
    (void)state;
    kit_sphere(ball, 0, 0, 0, 1);
    kit_sphere(child, 0, 0, 0, 2);
    kit_ok(ctx, rt_scene_commit(ball, NULL));
    d.child = child;
    kit_ok(ctx, rt_scene_add_instance(scene, &d, NULL));
    d.child = ball;
    kit_ok(ctx, rt_scene_add_instance(child, &d, &in_child));
    kit_ok(ctx, rt_scene_commit(child, NULL));
    assert_int_equal(rt_scene_commit(scene, NULL), RT_ERROR_STATE);
    kit_ok(ctx, rt_scene_remove_instance(child, in_child));
    kit_ok(ctx, rt_scene_commit(child, NULL));
    kit_ok(ctx, rt_scene_commit(scene, NULL));
    assert_true(kit_hit(scene, kit_ray(0, 0, 9, 0, 0, -1)).t == 7);
    rt_scene_destroy(ball);
    rt_scene_destroy(child);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

/* Each scene is given an instance of the next when it is placed itself: described, if never committed, and taken down within the
 * stack that the library promises. */
static void *take_down(void *scene)
{
    rt_scene_destroy(scene);
    return NULL;
}

static void test_chain(void **state)
{
    enum { LINKS = 20000, STACK = 256 << 10 };
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *first = kit_scene(ctx), *last = first;
    rt_instance_desc d = rt_instance_desc_default();
    pthread_attr_t attributes;
    pthread_t thread;
    uint64_t before, after;
    (void)state;
    rt_context_memory(ctx, &before, NULL);
    for (int i = 0; i < LINKS; i++) {
        d.child = kit_scene(ctx);
        kit_ok(ctx, rt_scene_add_instance(last, &d, NULL));
        if (last != first)
            rt_scene_destroy(last);
        last = d.child;
    }
    rt_scene_destroy(last);
    assert_int_equal(pthread_attr_init(&attributes), 0);
    assert_int_equal(pthread_attr_setstacksize(&attributes, STACK), 0);
    assert_int_equal(pthread_create(&thread, &attributes, take_down, first), 0);
    assert_int_equal(pthread_join(thread, NULL), 0);
    pthread_attr_destroy(&attributes);
    rt_context_memory(ctx, &after, NULL);
    assert_true(after < before);
    rt_context_destroy(ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bounds_hold),        cmocka_unit_test(test_growth), cmocka_unit_test(test_turned_boxes),
        cmocka_unit_test(test_odd_children),       cmocka_unit_test(test_tables), cmocka_unit_test(test_told_as_given),
        cmocka_unit_test(test_removed_of_a_child), cmocka_unit_test(test_chain)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
