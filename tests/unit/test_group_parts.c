/* Groups cut into parts of about one scale: when, that hits keep their ids, and that every tracer still equals brute force. */
#include "scene_kit.h"

#include <math.h>
#include <unistd.h>

#include "scene/snapshot.h"

enum { RINGS = 24, SIDES = 32, BALL_TRIANGLES = 2 * SIDES * (RINGS - 1), BALL_VERTICES = SIDES * (RINGS - 1) + 2, RAYS = 3000 };

/* A closed ball of triangles, counted from `vertex`. */
static void make_ball(rt_vec3 at, float radius, float *positions, uint32_t *indices, uint32_t vertex)
{
    float *p = positions;
    uint32_t *f = indices, south = vertex + BALL_VERTICES - 1;
    for (int ring = 0; ring <= RINGS; ring++) {
        double a = 3.14159265358979 * ring / RINGS;
        for (int k = 0; k < (ring % RINGS == 0 ? 1 : SIDES); k++, p += 3) {
            double b = 6.28318530717959 * k / SIDES;
            p[0] = at.x + radius * (float)(sin(a) * cos(b));
            p[1] = at.y + radius * (float)cos(a);
            p[2] = at.z + radius * (float)(sin(a) * sin(b));
        }
    }
    for (uint32_t k = 0; k < SIDES; k++) {
        uint32_t next = (k + 1) % SIDES, last = vertex + 1 + SIDES * (RINGS - 2);
        memcpy(f, (uint32_t[6]){vertex, vertex + 1 + next, vertex + 1 + k, south, last + k, last + next}, 24);
        f += 6;
        for (uint32_t ring = 0; ring + 2 < RINGS; ring++, f += 6) {
            uint32_t a = vertex + 1 + SIDES * ring + k, b = vertex + 1 + SIDES * ring + next;
            memcpy(f, (uint32_t[6]){a, b, b + SIDES, a, b + SIDES, a + SIDES}, 24);
        }
    }
}

static void add_mesh(rt_scene *scene, const float *positions, uint32_t vertices, const uint32_t *indices, uint32_t triangles)
{
    rt_mesh_desc d = rt_mesh_desc_default();
    d.positions = positions;
    d.vertex_count = vertices;
    d.indices = indices;
    d.triangle_count = triangles;
    kit_ok(rt_scene_context(scene), rt_scene_add_mesh(scene, &d, NULL));
}

static void add_ball(rt_scene *scene, rt_vec3 at, float radius)
{
    float positions[3 * BALL_VERTICES];
    uint32_t indices[3 * BALL_TRIANGLES];
    make_ball(at, radius, positions, indices, 0);
    add_mesh(scene, positions, BALL_VERTICES, indices, BALL_TRIANGLES);
}

/* The ball and a floor of two triangles in one mesh, as a file may hold them. */
static void add_both(rt_scene *scene, float floor)
{
    float positions[3 * (BALL_VERTICES + 4)] = {-floor, -0.1f, -floor, floor,  -0.1f, -floor,
                                                floor,  -0.1f, floor,  -floor, -0.1f, floor};
    uint32_t indices[3 * (BALL_TRIANGLES + 2)] = {0, 1, 2, 0, 2, 3};
    make_ball((rt_vec3){0.05f, 0, 0}, 0.1f, positions + 12, indices + 6, 4);
    add_mesh(scene, positions, BALL_VERTICES + 4, indices, BALL_TRIANGLES + 2);
}

static void commit(rt_scene *scene, const char *accel)
{
    rt_commit_desc d = rt_commit_desc_default();
    d.accel = accel;
    if (strcmp(accel, "kdtree") == 0)
        d.cost_intersect = 0.0625f; /* small cells, or a ball's would be a few */
    kit_ok(rt_scene_context(scene), rt_scene_commit(scene, &d));
}

static rtk_group group_of(const rt_scene *scene, uint32_t index)
{
    rti_snapshot *s = rti_scene_snapshot(scene);
    rtk_group g = rti_snapshot_view(s)->groups[index];
    rti_snapshot_release(s); /* the scene holds it on */
    return g;
}

/* Rays at the small thing and at the large one: from near, from far, along the floor, from the surfaces. */
static rt_ray make_ray(uint32_t *rng, uint32_t kind)
{
    static const float reach[] = {0.3f, 3.0f, 200.0f, 3000.0f, 0.1f};
    float r = reach[kind % 5], o[3], t[3];
    for (int k = 0; k < 3; k++) {
        o[k] = r * (2.0f * kit_unit(rng) - 1.0f);
        float wide = kind / 5 % 2 ? 0.02f : 0.5f * r; /* at the ball, or anywhere */
        t[k] = (k == 0 ? 0.05f : 0.0f) + wide * (2.0f * kit_unit(rng) - 1.0f);
    }
    if (kind % 7 == 0)
        o[1] = -0.1f; /* starts on the floor */
    if (kind % 11 == 0)
        t[1] = o[1] = 0.0f;
    return kit_ray(o[0], o[1], o[2], t[0] - o[0], t[1] - o[1], t[2] - o[2]);
}

static void ask(rt_scene *scene, const char *tracer, const rt_ray *rays, rt_hit *hits, uint8_t *occluded)
{
    kit_ok(rt_scene_context(scene), rt_scene_set_tracer(scene, tracer));
    commit(scene, "kdtree,octree,bvh");
    rt_scene_intersect(scene, rays, hits, RAYS);
    rt_scene_occluded(scene, rays, occluded, RAYS);
}

/* Every tracer gives brute force's bits. Returns how many rays hit the prims of `geom`. */
static uint32_t same_for_all(rt_scene *scene, uint32_t geom)
{
    static const char *const tracers[] = {"kdtree", "octree", "bvh"};
    static rt_ray rays[RAYS];
    static rt_hit hits[RAYS], other[RAYS];
    static uint8_t occluded[RAYS], occluded_other[RAYS];
    uint32_t rng = 77;
    uint32_t found = 0;
    for (uint32_t i = 0; i < RAYS; i++)
        rays[i] = make_ray(&rng, i);
    ask(scene, "brute", rays, hits, occluded);
    for (uint32_t k = 0; k < 3; k++) {
        ask(scene, tracers[k], rays, other, occluded_other);
        for (uint32_t i = 0; i < RAYS; i++) {
            if (memcmp(&hits[i], &other[i], sizeof hits[i]) != 0)
                fail_msg("%s: ray %u: brute t %a geom %u prim %u, here t %a geom %u prim %u", tracers[k], i, hits[i].t,
                         hits[i].geom_id, hits[i].prim_id, other[i].t, other[i].geom_id, other[i].prim_id);
        }
        assert_memory_equal(occluded, occluded_other, RAYS);
    }
    for (uint32_t i = 0; i < RAYS; i++) {
        rt_hit all[64];
        size_t n;
        assert_int_equal(occluded[i], hits[i].prim_id != RT_INVALID_ID);
        found += hits[i].prim_id != RT_INVALID_ID && hits[i].geom_id == geom;
        n = rt_scene_intersect_all(scene, &rays[i], all, 64);
        assert_true((n > 0) == (hits[i].prim_id != RT_INVALID_ID));
        if (n > 0)
            assert_memory_equal(&all[0], &hits[i], sizeof all[0]);
        for (size_t k = 1; k < n; k++)
            assert_true(all[k - 1].t <= all[k].t);
    }
    return found;
}

static void test_ball_on_floor(void **state)
{
    static const float floors[] = {100.0f, 1000.0f, 1.0e6f};
    rt_context *ctx = kit_context(NULL, 2);
    (void)state;
    for (uint32_t i = 0; i < 3; i++) {
        rt_scene *scene = kit_scene(ctx);
        rt_tree_info tree;
        rtk_group g;
        kit_square(scene, floors[i], -0.1f);
        add_ball(scene, (rt_vec3){0.05f, 0, 0}, 0.01f);
        commit(scene, "kdtree");
        g = group_of(scene, 0);
        assert_int_equal(g.part_count, 2);
        assert_int_equal(g.parts[0].count, 2);
        assert_int_equal(g.parts[1].count, BALL_TRIANGLES);
        assert_true(g.parts[0].scale == floors[i] && g.parts[1].scale < 0.07f);
        assert_int_equal(rt_scene_get_tree_info(scene, 1, NULL, &tree), RT_OK);
        assert_int_equal(tree.primitives, BALL_TRIANGLES);
        assert_true(tree.references < 6 * BALL_TRIANGLES && tree.largest_leaf < 100);
        assert_true(same_for_all(scene, 1) > RAYS / 100);
        rt_scene_destroy(scene);
    }
    rt_context_destroy(ctx);
}

/* One mesh of both: the same primitive ids as ever. */
static void test_one_mesh(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx);
    rt_hit hit;
    rt_surface at;
    (void)state;
    add_both(scene, 5000.0f);
    assert_true(same_for_all(scene, 0) > RAYS / 10);
    assert_int_equal(group_of(scene, 0).part_count, 2);
    hit = kit_hit(scene, kit_ray(-100.0f, 10.0f, -300.0f, 0, -1, 0));
    assert_int_equal(hit.prim_id, 0); /* the floor's triangles are the first of the mesh */
    hit = kit_hit(scene, kit_ray(0.05f, 10.0f, 0.001f, 0, -1, 0));
    assert_int_equal(hit.geom_id, 0);
    assert_true(hit.prim_id >= 2 && fabsf(hit.t - 9.9f) < 1.0e-4f);
    rt_scene_surface(scene, &(rt_ray){{0.05f, 10.0f, 0.001f}, 0, {0, -1, 0}, 1.0e30f, RT_MASK_ALL}, &hit, &at);
    assert_true(fabsf(at.position.y - 0.1f) < 1.0e-4f && at.face_id == hit.prim_id);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

/* Ten thousand times smaller balls around a large one; and as the child of instances. */
static void test_shapes_and_instances(void **state)
{
    rt_context *ctx = kit_context(NULL, 2);
    rt_scene *child = kit_scene(ctx), *scene = kit_scene(ctx);
    rt_instance_desc place = rt_instance_desc_default();
    uint32_t rng = 5;
    (void)state;
    kit_sphere(child, 0, -2000.1f, 0, 2000.0f);
    for (int i = 0; i < 400; i++)
        kit_sphere(child, 0.2f * kit_unit(&rng) - 0.1f, 0.2f * kit_unit(&rng) - 0.1f, 0.2f * kit_unit(&rng) - 0.1f, 0.004f);
    add_ball(child, (rt_vec3){0, 0, 0.02f}, 0.05f);
    assert_true(same_for_all(child, 401) > RAYS / 100);
    assert_int_equal(group_of(child, 0).part_count, 2);
    assert_int_equal(group_of(child, 0).parts[1].count, 400 + BALL_TRIANGLES);
    place.child = child;
    for (int i = 0; i < 3; i++) {
        place.transform = rt_transform_multiply(rt_transform_translate((rt_vec3){0.1f * (float)i, 0.02f, -0.03f * (float)i}),
                                                rt_transform_rotate((rt_vec3){1, 2, (float)i}, 40.0f * (float)i));
        assert_int_equal(rt_scene_add_instance(scene, &place, NULL), RT_OK);
    }
    kit_square(scene, 1.0f, -0.2f);
    same_for_all(scene, 0);
    assert_int_equal(group_of(scene, 0).part_count, 1);
    assert_int_equal(group_of(scene, 1).part_count, 2);
    rt_scene_destroy(scene);
    rt_scene_destroy(child);
    rt_context_destroy(ctx);
}

/* What hangs together is not cut: its middle is small, but a ray could slip through between the parts. */
static void test_whole_pieces(void **state)
{
    enum { N = 64 };
    static float positions[3 * (N + 1) * (N + 1)];
    static uint32_t indices[6 * N * N];
    rt_context *ctx = kit_context(NULL, 2);
    rt_scene *scene = kit_scene(ctx);
    (void)state;
    for (uint32_t y = 0; y <= N; y++) {
        for (uint32_t x = 0; x <= N; x++) {
            double a = 2.0 * x / N - 1.0, b = 2.0 * y / N - 1.0;
            float *p = &positions[3 * (y * (N + 1) + x)];
            p[0] = (float)(1000.0 * a * pow(fabs(a), 9.0)); /* cells of all sizes down to nothing in the middle */
            p[1] = (float)(1000.0 * b * pow(fabs(b), 9.0));
        }
    }
    for (uint32_t i = 0; i < N * N; i++) {
        uint32_t a = i / N * (N + 1) + i % N;
        memcpy(&indices[6 * i], (uint32_t[6]){a, a + 1, a + N + 2, a, a + N + 2, a + N + 1}, 24);
    }
    add_mesh(scene, positions, (N + 1) * (N + 1), indices, 2 * N * N);
    commit(scene, "kdtree");
    assert_int_equal(group_of(scene, 0).part_count, 1);
    rt_scene_destroy(scene);
    /* The same as two meshes, which share their corners' positions. */
    scene = kit_scene(ctx);
    add_mesh(scene, positions, (N + 1) * (N + 1), indices, N * N);
    add_mesh(scene, positions, (N + 1) * (N + 1), indices + 3 * N * N, N * N);
    commit(scene, "kdtree");
    assert_int_equal(group_of(scene, 0).part_count, 1);
    rt_scene_destroy(scene);
    /* Scenes of one scale are left alone, and so are a few small things. */
    scene = kit_scene(ctx);
    add_ball(scene, (rt_vec3){0, 0, 0}, 1.0f);
    kit_square(scene, 10.0f, -1.0f);
    commit(scene, "kdtree");
    assert_int_equal(group_of(scene, 0).part_count, 1);
    /* Some triangles of the ball would swell by half, their boxes' surface on average by less than as much again. */
    kit_square(scene, 3900.0f, -1.4f);
    commit(scene, "kdtree");
    assert_int_equal(group_of(scene, 0).part_count, 1);
    kit_square(scene, 1.0e5f, -1.5f);
    for (int i = 0; i < 20; i++)
        kit_sphere(scene, 0, 0, 0.01f * (float)i, 0.001f);
    commit(scene, "kdtree");
    assert_int_equal(group_of(scene, 0).part_count, 2); /* the ball's triangles; the tiny ones with it */
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

/* A dense small thing has a part, however many larger ones are around it. */
static void test_crowd(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx);
    (void)state;
    add_ball(scene, (rt_vec3){20, 3, 10}, 0.045f); /* as far from the origin as others */
    for (int i = 0; i < 48; i++)
        add_ball(scene, (rt_vec3){2.5f * (float)(i % 16) - 20.0f, 0, 10.0f + 2.5f * (float)(i / 16)}, 1.0f);
    kit_square(scene, 1000.0f, -1.5f);
    commit(scene, "kdtree");
    assert_int_equal(group_of(scene, 0).part_count, 2);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

/* From its inside every ray hits the closed ball, also when its origin is moved or the ray is aimed at edges and corners. */
static void test_no_leak(void **state)
{
    static float positions[3 * BALL_VERTICES];
    static uint32_t indices[3 * BALL_TRIANGLES];
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx);
    rt_vec3 c = {0.05f, 0.03f, -0.02f};
    (void)state;
    make_ball(c, 0.01f, positions, indices, 0);
    add_ball(scene, c, 0.01f);
    kit_square(scene, 2000.0f, -0.1f);
    commit(scene, "kdtree");
    assert_int_equal(group_of(scene, 0).part_count, 2);
    for (uint32_t i = 0; i < 3 * BALL_TRIANGLES; i++) {
        const float *a = &positions[3 * indices[i]], *b = &positions[3 * indices[i % 3 == 2 ? i - 2 : i + 1]];
        for (int k = 0; k < 3; k++) {
            float f = 0.5f * (float)k, d[3];
            rt_hit hit;
            for (int n = 0; n < 3; n++)
                d[n] = a[n] + f * (b[n] - a[n]) - (&c.x)[n];
            hit = kit_hit(scene, kit_ray(c.x, c.y, c.z, d[0], d[1], d[2]));
            assert_int_equal(hit.geom_id, 0);
            hit = kit_hit(scene, kit_ray(c.x - 5000.0f * d[0], c.y - 5000.0f * d[1], c.z - 5000.0f * d[2], d[0], d[1], d[2]));
            assert_true(hit.prim_id != RT_INVALID_ID);
        }
    }
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

static void test_saved(void **state)
{
    static const char path[] = "group_parts_test.rts";
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx), *loaded = NULL;
    char a[33], b[33];
    uint32_t rng = 9;
    (void)state;
    add_both(scene, 5000.0f);
    commit(scene, "kdtree,octree,bvh");
    kit_ok(ctx, rt_scene_save(scene, path));
    kit_ok(ctx, rt_scene_load(ctx, path, &loaded));
    rt_scene_hash(scene, a);
    rt_scene_hash(loaded, b);
    assert_string_equal(a, b);
    assert_int_equal(group_of(loaded, 0).part_count, 2);
    for (uint32_t i = 0; i < RAYS; i++) {
        rt_ray ray = make_ray(&rng, i);
        rt_hit p = kit_hit(scene, ray), q = kit_hit(loaded, ray);
        assert_memory_equal(&p, &q, sizeof p);
    }
    unlink(path);
    rt_scene_destroy(loaded);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

/* Each allocation refused in turn: an error, or the same scene. */
static void test_no_memory(void **state)
{
    char first[33] = "";
    uint32_t refused = 0;
    (void)state;
    for (long at = 0; at < 400; at++) {
        kit_memory memory = {0};
        rt_context *ctx = kit_context(&memory, 1);
        rt_scene *scene = kit_scene(ctx);
        char hash[33];
        rt_status status;
        add_both(scene, 5000.0f);
        if (at > 0)
            atomic_store(&memory.fail_at, atomic_load(&memory.requests) + at);
        status = rt_scene_commit(scene, NULL);
        atomic_store(&memory.fail_at, 0);
        if (status == RT_OK) {
            rt_scene_hash(scene, hash);
            if (at == 0)
                memcpy(first, hash, sizeof hash);
            assert_string_equal(hash, first);
        } else {
            assert_int_equal(status, RT_ERROR_MEMORY);
            refused++;
        }
        rt_scene_destroy(scene);
        rt_context_destroy(ctx);
        assert_int_equal(atomic_load(&memory.blocks), 0);
        if (status == RT_OK && at > 0)
            break;
    }
    assert_true(refused > 15 && refused < 390);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_ball_on_floor), cmocka_unit_test(test_one_mesh), cmocka_unit_test(test_shapes_and_instances),
        cmocka_unit_test(test_whole_pieces),  cmocka_unit_test(test_crowd),    cmocka_unit_test(test_no_leak),
        cmocka_unit_test(test_saved),         cmocka_unit_test(test_no_memory)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
