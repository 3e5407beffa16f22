/* Every tracer of the table against brute force, bit for bit: closest hit, any hit, and stepping from hit to hit.
 *
 * LIBRT_RAYS: rays a scene (10,000); LIBRT_FULL=1: two hundred thousand. Real meshes, where brute force costs 70,000 tests a ray,
 * get a hundredth of that against brute force, and a quarter against the kd-tree; with LIBRT_FULL=1 (minutes a mesh, or an hour)
 * closest hits of ten million random and ten million aimed rays (LIBRT_CLOSEST: how many) against support/judge.h's, and one of
 * 64 against brute force. LIBRT_ONLY: the tests of that name; LIBRT_MESH: that mesh alone, of those of LIBRT_SCENES, or `globe`,
 * or none. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/generate.h"
#include "support/sweep.h"

static rt_context *context(void)
{
    rt_context_desc d = rt_context_desc_default();
    rt_context *ctx;
    d.workers = 1;
    assert_int_equal(rt_context_create(&d, &ctx), RT_OK);
    return ctx;
}

/* One mesh as the whole scene, by both kd builders, for rays against brute force; closest: for so many by their closest hits
 * alone.
 */
static void sweep_mesh(test_mesh *m, float scale, float move, uint64_t count, uint64_t closest, const char *what)
{
    rt_context *ctx = context();
    test_mesh_place(m, scale, move);
    for (uint32_t builder = RTI_BUILD_KD_EXACT; builder <= RTI_BUILD_KD_BINNED; builder++) {
        test_world w;
        test_world_init(&w, ctx);
        test_world_mesh(&w, 0, m, 0xffffffffu);
        assert_int_equal(test_world_commit(&w, &(rti_build_settings){.builder = builder}), RT_OK);
        test_sweep(&w, rti_tracer_find(test_isa(), "brute"), count, what);
        if (closest)
            test_sweep_closest(&w, closest, what);
        test_world_free(&w);
    }
    test_mesh_free(m);
    rt_context_destroy(ctx);
}

static void test_soup(void **state)
{
    test_mesh m = {0};
    (void)state;
    test_mesh_soup(&m, 800, 0.2f, 5);
    test_mesh_soup(&m, 8, 3.0f, 6);
    sweep_mesh(&m, 1.0f, 0.0f, test_ray_count(), test_closest_count(), "soup");
}

/* The other builders of the BVH: long triangles among small ones, which spatial splits cut often, and shapes beside them. */
static void test_bvh_builders(void **state)
{
    static const uint32_t builders[] = {RTI_BUILD_BVH_COMPACT, RTI_BUILD_BVH_SPATIAL};
    (void)state;
    for (int i = 0; i < 2; i++) {
        rt_context *ctx = context();
        test_mesh m = {0};
        test_world w;
        rtk_shape balls[20] = {{0}};
        test_rng rng = {3};
        test_mesh_soup(&m, 600, 0.1f, 7);
        test_mesh_soup(&m, 60, 4.0f, 8);
        for (int k = 0; k < 20; k++)
            for (int a = 0; a < 4; a++)
                balls[k].p[a] = a < 3 ? test_range(&rng, -1.0f, 1.0f) : 0.1f;
        test_world_init(&w, ctx);
        w.bvh_builder = builders[i];
        test_world_mesh(&w, 0, &m, 0xffffffffu);
        test_world_shapes(&w, 0, balls, 20, 0xffffffffu);
        assert_int_equal(test_world_commit(&w, NULL), RT_OK);
        const rtk_tree_header *h = w.parts[0].chunks[2];
        assert_int_equal(h->kind, RTK_TREE_BVH);
        assert_int_equal(h->block_count == 0, i == 0);
        assert_true((h->ref_count - h->filler_count > m.count + 20) == (i == 1));
        test_sweep(&w, rti_tracer_find(test_isa(), "brute"), test_ray_count() / 2, i ? "bvh, spatial" : "bvh, compact");
        test_world_free(&w);
        test_mesh_free(&m);
        rt_context_destroy(ctx);
    }
}

static void test_slivers(void **state)
{
    test_mesh m = {0};
    (void)state;
    test_mesh_slivers(&m, 600);
    sweep_mesh(&m, 1.0f, 0.0f, test_ray_count(), 0, "slivers");
}

static void test_lattice(void **state)
{
    test_mesh m = {0};
    (void)state;
    test_mesh_lattice(&m, 10);
    sweep_mesh(&m, 1.0f, 0.0f, test_ray_count(), 0, "lattice");
}

static void test_nested(void **state)
{
    test_mesh m = {0};
    (void)state;
    test_mesh_nested(&m, 40);
    sweep_mesh(&m, 1.0f, 0.0f, test_ray_count(), 0, "nested boxes");
}

/* The promises table's scales and moves; extents are about 2. */
static void test_scaled_and_moved(void **state)
{
    static const float places[][2] = {{1.0e-3f, 0.0f}, {1.0e6f, 0.0f}, {1.0f, 2.0e4f}, {1.0e-3f, 20.0f}, {1.0e6f, -2.0e10f}};
    (void)state;
    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++) {
        test_mesh m = {0};
        test_mesh_soup(&m, 300, 0.2f, 9);
        test_mesh_lattice(&m, 5);
        sweep_mesh(&m, places[i][0], places[i][1], test_ray_count() / 4, 0, "soup and lattice, scaled and moved");
    }
}

/* Bodies of very different sizes, some twice and some inside others: balls, or boxes, of which some are flat and some stand wall
 * to wall. */
static void make_bodies(rtk_shape *bodies, int count, bool boxes)
{
    test_rng rng = {41};
    memset(bodies, 0, (size_t)count * sizeof *bodies);
    for (int i = 0; i < count; i++) {
        float *p = bodies[i].p;
        if (i % 8 == 7) {
            memcpy(p, bodies[i - 1].p, sizeof bodies[i].p);
            p[3] *= i % 16 == 7 || boxes ? 1.0f : 0.99f;
        } else {
            for (int a = 0; a < 3; a++)
                p[a] = test_range(&rng, -1.0f, 1.0f);
            p[3] = powf(10.0f, test_range(&rng, -3.0f, -0.3f));
        }
        if (!boxes)
            continue;
        bodies[i].type = RTK_SHAPE_BOX;
        for (int a = 0; a < 3 && i % 8 != 7; a++)
            p[3 + a] = p[a] + (i % 5 == a ? 1.0e-6f : test_range(&rng, 0.01f, 0.4f));
        if (i % 8 == 6) { /* on the one before */
            p[1] = bodies[i - 1].p[4];
            p[4] = p[1] + 0.2f;
        }
    }
}

/* What packets ask in lanes, and all rays see: bodies, and planes, one of them twice; then planes beside triangles alone. */
static void test_bodies_and_planes(void **state)
{
    static const float planes[3][6] = {{0, -0.7f, 0, 0.1f, 1, 0.2f}, {0, -0.7f, 0, 0.1f, 1, 0.2f}, {3, 0, 0, -1, 0, 0}};
    static const char *const words[] = {"spheres", "spheres, planes", "planes", "boxes", "boxes, planes"};
    (void)state;
    for (int way = 0; way < 5; way++) {
        rt_context *ctx = context();
        test_world w;
        rtk_shape bodies[160];
        test_mesh m = {0};
        make_bodies(bodies, 160, way > 2);
        test_world_init(&w, ctx);
        test_mesh_soup(&m, 60, 0.3f, 42);
        test_world_mesh(&w, 0, &m, 0xffffffffu);
        for (int i = 0; i < 3 && strstr(words[way], "planes"); i++)
            test_world_plane(&w, 0, planes[i], planes[i] + 3, 0xffffffffu);
        if (way != 2)
            test_world_shapes(&w, 0, bodies, 160, 0xffffffffu);
        assert_int_equal(test_world_commit(&w, NULL), RT_OK);
        assert_true(w.scene.groups->flags & RTK_GROUP_PLAIN);
        test_sweep(&w, rti_tracer_find(test_isa(), "brute"), test_ray_count() / 2, words[way]);
        test_world_free(&w);
        test_mesh_free(&m);
        rt_context_destroy(ctx);
    }
}

static void test_shapes(void **state)
{
    rt_context *ctx = context();
    test_world w;
    rtk_shape shapes[200];
    test_mesh m = {0};
    (void)state;
    test_world_init(&w, ctx);
    test_mesh_soup(&m, 100, 0.3f, 11);
    test_world_mesh(&w, 0, &m, 3);
    test_world_shapes(&w, 0, shapes, test_shapes_of_all_kinds(shapes, 100, 12), 0xfffffffdu);
    test_world_plane(&w, 0, (const float[3]){0, -0.5f, 0}, (const float[3]){0.1f, 1, 0.2f}, 4);
    test_world_shapes(&w, 0, shapes, test_shapes_of_all_kinds(shapes, 100, 13), 5);
    assert_int_equal(test_world_commit(&w, NULL), RT_OK);
    test_sweep(&w, rti_tracer_find(test_isa(), "brute"), test_ray_count(), "shapes, masks, a plane");
    test_world_free(&w);
    test_mesh_free(&m);
    rt_context_destroy(ctx);
}

/* The map of material 1 takes hits away, and only the map does. */
static void sees_through(test_world *w, rtk_material *materials)
{
    static test_batch b;
    test_targets t;
    test_rng rng = {34};
    rti_scratch scratch = {.room = test_room()};
    uint32_t farther = 0;
    test_targets_init(&t, w);
    test_batch_fill(&b, &t, &rng);
    test_targets_free(&t);
    rti_tracer_find(test_isa(), "kdtree")->intersect(&w->scene, b.rays, b.hits, TEST_BATCH, 0, &scratch);
    materials[1].alpha_tex = RTK_INVALID;
    rti_tracer_find(test_isa(), "kdtree")->intersect(&w->scene, b.rays, b.other, TEST_BATCH, 0, &scratch);
    for (uint32_t i = 0; i < TEST_BATCH; i++) {
        assert_true(b.hits[i / RTK_BLOCK].t[i % RTK_BLOCK] >= b.other[i / RTK_BLOCK].t[i % RTK_BLOCK]);
        farther += b.hits[i / RTK_BLOCK].t[i % RTK_BLOCK] > b.other[i / RTK_BLOCK].t[i % RTK_BLOCK];
    }
    assert_in_range(farther, TEST_BATCH / 20, TEST_BATCH);
}

/* Cut-outs by a checkered alpha map over triangles (their weights are its coordinates), shapes and a plane, in a group and in
 * instances. */
static void test_alpha(void **state)
{
    struct {
        rtk_texture_header head;
        uint8_t texels[64][4];
    } map;
    rt_context *ctx = context();
    test_world w;
    rtk_shape shapes[60];
    test_mesh m = {0};
    rtk_material materials[2];
    rtk_texture texture = {&map.head};
    test_rng r = {31};
    float to_world[12];
    (void)state;
    memset(&map, 0, sizeof map);
    map.head.width = map.head.height = 8;
    map.head.level_count = 1;
    map.head.flags = RTK_TEX_ALPHA;
    map.head.off_level[0] = sizeof map.head;
    for (int i = 0; i < 64; i++)
        map.texels[i][3] = (i / 8 + i) % 2 ? 255 : 0;
    memset(materials, 0, sizeof materials);
    materials[0].alpha_tex = RTK_INVALID;
    materials[1].alpha_tex = 0;
    materials[1].alpha_cut = 0.5f;
    test_world_init(&w, ctx);
    test_mesh_soup(&m, 200, 0.5f, 32);
    uint32_t child = test_world_group(&w);
    for (uint32_t group = 0; group <= child; group++) {
        test_world_mesh(&w, group, &m, 0xffffffffu);
        test_world_shapes(&w, group, shapes, test_shapes_of_all_kinds(shapes, 60, 33 + group), 0xffffffffu);
        for (uint32_t k = 0; k < w.parts[group].geom_count; k++) {
            w.parts[group].geoms[k].flags = RTK_GEOM_ALPHA;
            w.parts[group].geoms[k].material = 1;
        }
    }
    test_world_plane(&w, 0, (const float[3]){0, -0.3f, 0}, (const float[3]){0, 1, 0}, 0xffffffffu);
    w.parts[0].geoms[2].flags = RTK_GEOM_ALPHA;
    w.parts[0].geoms[2].material = 1;
    w.parts[0].geoms[2].t_dir[0] = 1.0f;
    for (int i = 0; i < 6; i++) {
        test_random_map(&r, 2.0f, 0.5f, to_world);
        test_world_instance(&w, child, to_world, 0xffffffffu);
        w.instances[i].material = i == 0 ? 0 : RTK_INVALID; /* the first has the material without a map */
    }
    w.scene.materials = materials;
    w.scene.material_count = 2;
    w.scene.textures = &texture;
    w.scene.texture_count = 1;
    assert_int_equal(test_world_commit(&w, NULL), RT_OK);
    test_sweep(&w, rti_tracer_find(test_isa(), "brute"), test_ray_count(), "cut-outs");
    sees_through(&w, materials);
    test_world_free(&w);
    test_mesh_free(&m);
    rt_context_destroy(ctx);
}

static void sweep_instances(float spread, float scale, bool moving, const char *what)
{
    rt_context *ctx = context();
    test_world w;
    test_mesh m = {0}, n = {0};
    rtk_shape shapes[20];
    test_rng r = {99};
    float map[12];
    test_world_init(&w, ctx);
    test_mesh_soup(&m, 60, 0.4f, 21);
    test_mesh_lattice(&n, 3);
    test_world_mesh(&w, 0, &n, 0xffffffffu);
    uint32_t a = test_world_group(&w), b = test_world_group(&w), c = test_world_group(&w);
    test_world_mesh(&w, a, &m, 0xffffffffu);
    test_world_shapes(&w, b, shapes, test_shapes_of_all_kinds(shapes, 20, 22), 7);
    test_world_mesh(&w, b, &n, 0xffffffffu);
    test_world_mesh(&w, c, &n, 0xffffffffu);
    test_world_plane(&w, c, (const float[3]){0, 0, 0}, (const float[3]){1, 2, 3}, 2);
    for (int i = 0; i < 24; i++) {
        test_random_map(&r, spread, scale, map);
        test_world_instance(&w, i % 8 == 7 ? c : (i % 2 ? a : b), map, i % 5 == 4 ? 2u : 0xffffffffu);
        for (int try = 0; moving && i % 4 != 3 && try < 20; try++) {
            float way[3][12];
            for (int k = 0; k < 3; k++)
                test_random_map(&r, spread, scale, way[k]);
            if (test_world_move(&w, (const float(*)[12])way, 1 + (uint32_t)i % 3))
                break;
        }
        if (i % 6 == 5) /* the same again: equal t, the instance decides */
            test_world_instance(&w, i % 8 == 7 ? c : (i % 2 ? a : b), map, 0xffffffffu);
    }
    assert_true(!moving || w.motion_count > 15);
    assert_int_equal(test_world_commit(&w, NULL), RT_OK);
    test_sweep(&w, rti_tracer_find(test_isa(), "brute"), test_ray_count() / 2, what); /* of six */
    test_world_free(&w);
    test_mesh_free(&m);
    test_mesh_free(&n);
    rt_context_destroy(ctx);
}

static void test_instances(void **state)
{
    (void)state;
    sweep_instances(2.0f, 0.5f, false, "instances");
    sweep_instances(100.0f, 3.0f, false, "instances far apart");
    sweep_instances(0.01f, 0.002f, false, "small instances");
    sweep_instances(2.0f, 0.5f, true, "moving instances");
    sweep_instances(100.0f, 3.0f, true, "moving instances far apart");
    sweep_instances(0.01f, 0.002f, true, "small moving instances");
}

static void test_meshes(void **state)
{
    static const char *const all[] = {"bunny", "sponza", "sibenik", "spot"};
    const char *only = getenv("LIBRT_MESH"), *const *names = only ? &only : all;
    (void)state;
    for (size_t i = 0; i < (only ? 1 : sizeof all / sizeof all[0]); i++) {
        rt_context *ctx;
        test_world w;
        test_mesh m = {0};
        if (strcmp(names[i], "globe") == 0) {
            test_mesh_globe(&m, 707); /* a million triangles */
        } else if (!test_mesh_load(&m, names[i])) {
            print_message("%s: not there, left out\n", names[i]);
            continue;
        }
        ctx = context();
        test_world_init(&w, ctx);
        test_world_mesh(&w, 0, &m, 0xffffffffu);
        assert_int_equal(test_world_commit(&w, NULL), RT_OK);
        test_sweep(&w, rti_tracer_find(test_isa(), "kdtree"), test_ray_count() / 4, names[i]);
        test_sweep(&w, rti_tracer_find(test_isa(), "brute"), test_ray_count() / 100, names[i]);
        if (test_closest_count())
            test_sweep_closest(&w, test_closest_count(), names[i]);
        test_world_free(&w);
        test_mesh_free(&m);
        rt_context_destroy(ctx);
    }
}

static void test_nothing(void **state)
{
    rt_context *ctx = context();
    test_world w;
    test_batch *b = calloc(1, sizeof *b);
    test_mesh m = {0};
    test_targets t;
    test_rng rng = {3};
    (void)state;
    test_mesh_soup(&m, 3, 1.0f, 1);
    test_world_init(&w, ctx);
    test_world_mesh(&w, 0, &m, 1);
    assert_int_equal(test_world_commit(&w, NULL), RT_OK);
    test_targets_init(&t, &w);
    test_batch_fill(b, &t, &rng);
    test_world_free(&w);
    test_world_init(&w, ctx);
    assert_int_equal(test_world_commit(&w, NULL), RT_OK);
    for (uint32_t i = 0; i < rti_tracer_count(); i++) {
        rti_scratch scratch = {.room = test_room()};
        rti_tracer_at(test_isa(), i)->intersect(&w.scene, b->rays, b->hits, TEST_BATCH, 0, &scratch);
        rti_tracer_at(test_isa(), i)->occluded(&w.scene, b->rays, b->occluded, TEST_BATCH, 0, &scratch);
        for (uint32_t k = 0; k < TEST_BATCH; k++) {
            assert_int_equal(b->hits[k / RTK_BLOCK].prim[k % RTK_BLOCK], RTK_INVALID);
            assert_true(b->hits[k / RTK_BLOCK].t[k % RTK_BLOCK] == b->rays[k / RTK_BLOCK].tmax[k % RTK_BLOCK]);
            assert_int_equal(b->occluded[k / RTK_BLOCK], 0);
        }
    }
    test_targets_free(&t);
    test_world_free(&w);
    test_mesh_free(&m);
    free(b);
    rt_context_destroy(ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_nothing),          cmocka_unit_test(test_soup),    cmocka_unit_test(test_bvh_builders),
        cmocka_unit_test(test_slivers),          cmocka_unit_test(test_lattice), cmocka_unit_test(test_nested),
        cmocka_unit_test(test_scaled_and_moved), cmocka_unit_test(test_shapes),  cmocka_unit_test(test_bodies_and_planes),
        cmocka_unit_test(test_instances),        cmocka_unit_test(test_meshes),  cmocka_unit_test(test_alpha),
    };
    if (getenv("LIBRT_ONLY"))
        cmocka_set_test_filter(getenv("LIBRT_ONLY"));
    return cmocka_run_group_tests(tests, NULL, NULL);
}
