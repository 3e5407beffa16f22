/* Batches of rays where there are instances, against brute force, at every instruction set that this machine runs: bodies of all
 * kinds in them, alpha maps, materials and masks of their own, some in one place, some moving, rays from far away and of no use.
 */
#include "scene_kit.h"

#include <math.h>

#include "scene/look.h"
#include "scene/scene.h"
#include "support/many.h"
#include "support/world.h"
#include "trace/lane.h"

#define RAYS 17001u /* more than go through the top level together, and no whole blocks */

static uint32_t seed;

static void soup(rt_scene *scene, uint32_t triangles, uint32_t material)
{
    float positions[9 * 400], uvs[6 * 400];
    uint32_t indices[3 * 400];
    rt_mesh_desc d = rt_mesh_desc_default();
    for (uint32_t t = 0; t < triangles; t++) {
        const float c[3] = {kit_range(&seed, -1, 1), kit_range(&seed, -1, 1), kit_range(&seed, -1, 1)};
        for (uint32_t k = 0; k < 9; k++)
            positions[9 * t + k] = c[k % 3] + kit_range(&seed, -0.4f, 0.4f);
        for (uint32_t k = 0; k < 6; k++)
            uvs[6 * t + k] = kit_range(&seed, 0, 3);
        for (uint32_t k = 0; k < 3; k++)
            indices[3 * t + k] = 3 * t + k;
    }
    d.positions = positions;
    d.vertex_count = 3 * triangles;
    d.indices = indices;
    d.triangle_count = triangles;
    d.uvs = uvs;
    d.common.material.id = material;
    kit_ok(rt_scene_context(scene), rt_scene_add_mesh(scene, &d, NULL));
}

static void balls(rt_scene *scene, uint32_t count)
{
    float centers[3 * 20];
    rt_spheres_desc d = rt_spheres_desc_default();
    for (uint32_t k = 0; k < 3 * count; k++)
        centers[k] = kit_range(&seed, -1, 1);
    d.centers = centers;
    d.count = count;
    d.radius = 0.2f;
    kit_ok(rt_scene_context(scene), rt_scene_add_spheres(scene, &d, NULL));
}

/* A material with holes. */
static uint32_t lace(rt_scene *scene)
{
    static const uint8_t texels[16] = {255, 255, 255, 255, 255, 255, 255, 0, 255, 255, 255, 0, 255, 255, 255, 255};
    rt_texture_desc td = rt_texture_desc_default();
    rt_material_desc d = rt_material_desc_default();
    rt_material made;
    td.width = td.height = 2;
    td.format = RT_PIXEL_RGBA8;
    td.pixels = texels;
    kit_ok(rt_scene_context(scene), rt_scene_add_texture(scene, &td, &d.alpha_texture));
    kit_ok(rt_scene_context(scene), rt_scene_add_material(scene, &d, &made));
    return made.id;
}

static rt_transform place(float reach)
{
    const rt_vec3 axis = {kit_range(&seed, -1, 1), kit_range(&seed, -1, 1), 1}, scale = {kit_range(&seed, 0.3f, 2), 1, -1.2f};
    const rt_vec3 by = {kit_range(&seed, -reach, reach), kit_range(&seed, -reach, reach), kit_range(&seed, -reach, reach)};
    return rt_transform_multiply(
        rt_transform_translate(by),
        rt_transform_multiply(rt_transform_rotate(axis, kit_range(&seed, 0, 360)), rt_transform_scale(scale)));
}

static rt_scene *build(rt_context *ctx, uint32_t instances, float reach, bool planes, bool own)
{
    rt_scene *scene = kit_scene(ctx), *kinds[4];
    const uint32_t holes = lace(scene);
    for (uint32_t k = 0; k < 4; k++) {
        kinds[k] = kit_scene(ctx);
        soup(kinds[k], k == 1 ? 20 : 300, k == 2 ? lace(kinds[k]) : 0);
        if (k == 1)
            balls(kinds[k], 20);
        if (k == 3 && planes) {
            rt_plane_desc plane = rt_plane_desc_default();
            plane.point = (rt_vec3){0, -30, 0};
            kit_ok(ctx, rt_scene_add_plane(kinds[k], &plane, NULL));
        }
        kit_ok(ctx, rt_scene_commit(kinds[k], NULL));
    }
    if (own) {
        soup(scene, 200, 0);
        balls(scene, 6);
    }
    for (uint32_t i = 0; i < instances; i++) {
        rt_instance_desc d = rt_instance_desc_default();
        rt_transform moved[2];
        d.child = kinds[i % 4];
        d.transform = place(reach);
        if (i % 5 == 4)
            d.mask = 2;
        if (i % 7 == 3)
            d.material.id = i % 2 ? holes : 0;
        if (i % 11 == 5) {
            moved[0] = rt_transform_multiply(rt_transform_translate((rt_vec3){0.5f, 0.2f, 0}), d.transform);
            moved[1] = rt_transform_multiply(rt_transform_rotate((rt_vec3){0, 1, 0}, 30), moved[0]);
            d.motion = moved;
            d.motion_count = 2;
        }
        for (uint32_t twice = 0; twice < (i % 6 == 2 ? 2u : 1u); twice++) /* hits that are equally near */
            kit_ok(ctx, rt_scene_add_instance(scene, &d, NULL));
    }
    kit_ok(ctx, rt_scene_commit(scene, NULL));
    for (uint32_t k = 0; k < 4; k++)
        rt_scene_destroy(kinds[k]);
    return scene;
}

static rtk_trace_block rays[RAYS / RTK_BLOCK + 1];
static rtk_hit_block want[RAYS / RTK_BLOCK + 1], got[RAYS / RTK_BLOCK + 1];
static uint16_t want_any[RAYS / RTK_BLOCK + 1], got_any[RAYS / RTK_BLOCK + 1];
static float times[RAYS];

static void aim(bool fan)
{
    const rtk_vec3 eye = rtk_v3(1, 2, 9);
    for (uint32_t i = 0; i < RAYS; i++) {
        rtk_trace_block *b = &rays[i / RTK_BLOCK];
        const uint32_t k = i % RTK_BLOCK;
        rtk_vec3 at = rtk_v3(kit_range(&seed, -5, 5), kit_range(&seed, -5, 5), kit_range(&seed, -5, 5)), org = eye, dir;
        if (fan)
            at = rtk_v3((float)(i % 130) * 0.07f - 4.5f, (float)(i / 130) * 0.07f - 4.5f, 0);
        else
            org = rtk_v3(kit_range(&seed, -7, 7), kit_range(&seed, -7, 7), kit_range(&seed, -7, 7));
        if (i % 97 == 0)
            org = rtk_scale(org, 1e5f);
        dir = rtk_sub(at, org);
        if (i % 3)
            dir = rtk_unit(dir);
        b->ox[k] = org.x;
        b->oy[k] = org.y;
        b->oz[k] = org.z;
        b->dx[k] = i % 89 == 0 ? 0.0f : dir.x;
        b->dy[k] = i % 83 == 0 ? 0.0f : dir.y;
        b->dz[k] = i % 1013 == 0 ? NAN : dir.z;
        b->tmin[k] = i % 13 == 0 ? -5.0f : i % 17 == 0 ? 2.0f : 0.0f;
        b->tmax[k] = i % 19 == 0 ? 6.0f : i % 503 == 0 ? 0.0f : RTK_INF;
        b->mask[k] = i % 23 == 0 ? 0u : i % 7 == 0 ? 1u : 0xffffffffu;
        times[i] = kit_range(&seed, 0, 1);
    }
}

/* Of shapes u and v may be anything where nobody asks. */
static bool is_shape(const rtk_scene *scene, const rtk_hit_block *h, uint32_t k)
{
    const uint32_t group = h->inst[k] == RTK_INVALID ? 0 : scene->instances[h->inst[k]].group;
    return h->prim[k] != RTK_INVALID && scene->groups[group].geoms[h->geom[k]].type == RTK_GEOM_SHAPES;
}

static void same_hits(const rtk_scene *scene, const char *tracer, rti_isa isa, uint32_t flags, uint32_t count, bool bare)
{
    for (uint32_t i = 0; i < count; i++) {
        const rtk_hit_block *a = &want[i / RTK_BLOCK], *b = &got[i / RTK_BLOCK];
        const uint32_t k = i % RTK_BLOCK;
        const bool free_uv = bare && is_shape(scene, a, k);
        if (rtk_bits(a->t[k]) != rtk_bits(b->t[k]) || a->prim[k] != b->prim[k] || a->geom[k] != b->geom[k] ||
            a->inst[k] != b->inst[k] ||
            (!free_uv && (rtk_bits(a->u[k]) != rtk_bits(b->u[k]) || rtk_bits(a->v[k]) != rtk_bits(b->v[k]))))
            fail_msg(
                "%s, level %d, flags %u: ray %u hits %u %u %u at %.9g (%.9g, %.9g), and should %u %u %u at %.9g (%.9g, %.9g)",
                tracer, (int)isa, (unsigned)flags, (unsigned)i, (unsigned)b->inst[k], (unsigned)b->geom[k], (unsigned)b->prim[k],
                b->t[k], b->u[k], b->v[k], (unsigned)a->inst[k], (unsigned)a->geom[k], (unsigned)a->prim[k], a->t[k], a->u[k],
                a->v[k]);
    }
    for (uint32_t i = 0; i < count; i++)
        if ((want_any[i / RTK_BLOCK] ^ got_any[i / RTK_BLOCK]) >> i % RTK_BLOCK & 1)
            fail_msg("%s, level %d, flags %u: any hit of ray %u is %d", tracer, (int)isa, (unsigned)flags, (unsigned)i,
                     got_any[i / RTK_BLOCK] >> i % RTK_BLOCK & 1);
}

/* Each ray by itself. */
static void ask_alone(const rtk_scene *scene, const rti_tracer *tracer, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        const rtk_trace_block *b = &rays[i / RTK_BLOCK];
        const uint32_t k = i % RTK_BLOCK;
        const rti_ray ray = {{b->ox[k], b->oy[k], b->oz[k]}, b->tmin[k], {b->dx[k], b->dy[k], b->dz[k]}, b->tmax[k], b->mask[k]};
        rti_hit hit;
        const int any = tracer->one(scene, &ray, times[i], NULL), met = tracer->one(scene, &ray, times[i], &hit);
        assert_int_equal(met != 0, hit.prim != RTK_INVALID);
        rti_lane_occluded(got_any, i, any);
        rti_lane_keep(got, i, (rtk_hit){hit.t, hit.u, hit.v, hit.prim, hit.geom, hit.inst});
    }
}

/* A tracer at every level, marked as coherent and not, with and without shapes' parameters; and ray by ray. Where fewer will do,
 * two of the four ways, under a sanitizer one, at each other level and in each other turn others. */
static void against_brute(rt_scene *scene, const char *name, void *room, uint32_t count, uint32_t turn)
{
    rt_tree_query query = rt_tree_query_default();
    rti_look look;
    query.tracer = name;
    kit_ok(rt_scene_context(scene), rti_look_begin(scene, "test", &query, &look));
    for (int isa = 0; isa < RTI_ISA_COUNT; isa++) {
        for (uint32_t way = 0; way < 4 && rti_isa_runs((rti_isa)isa); way++) {
            if (test_fewer() && ((way ^ way >> 1 ^ (uint32_t)isa ^ turn) & (TEST_SANITIZED ? 3u : 1u)) != 0)
                continue;
            const uint32_t flags = way & 1 ? RTI_TRACE_COHERENT : 0;
            const rti_tracer *tracer = rti_tracer_find((rti_isa)isa, name);
            rti_scratch scratch = {.times = times, .room = room, .bare = way >> 1};
            memset(got, 0x5a, sizeof got);
            memset(got_any, 0x5a, sizeof got_any);
            tracer->intersect(&look.snapshot->view, rays, got, count, flags, &scratch);
            tracer->occluded(&look.snapshot->view, rays, got_any, count, flags, &scratch);
            assert_ptr_equal(scratch.times, times);
            same_hits(&look.snapshot->view, name, (rti_isa)isa, flags, count, scratch.bare);
        }
        if (rti_isa_runs((rti_isa)isa)) {
            ask_alone(&look.snapshot->view, rti_tracer_find((rti_isa)isa, name), count);
            same_hits(&look.snapshot->view, name, (rti_isa)isa, 99, count, false);
        }
    }
    rti_snapshot_release(look.snapshot);
}

static void brute(rt_scene *scene, uint32_t count, uint32_t least)
{
    const rti_tracer *tracer = rti_tracer_find(RTI_ISA_GENERIC, "brute");
    rti_scratch scratch = {.times = times};
    rt_tree_query query = rt_tree_query_default();
    rti_look look;
    uint32_t placed = 0;
    query.tracer = "bvh";
    kit_ok(rt_scene_context(scene), rti_look_begin(scene, "test", &query, &look));
    tracer->intersect(&look.snapshot->view, rays, want, count, 0, &scratch);
    tracer->occluded(&look.snapshot->view, rays, want_any, count, 0, &scratch);
    rti_snapshot_release(look.snapshot);
    for (uint32_t i = 0; i < count; i++)
        placed += want[i / RTK_BLOCK].inst[i % RTK_BLOCK] != RTK_INVALID;
    assert_true(placed > least); /* else the scene has lost what this test is for */
}

static void each_scene(uint32_t instances, float reach, bool planes, bool own, uint32_t count)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = build(ctx, instances, reach, planes, own);
    void *room = aligned_alloc(64, RTI_TRACE_ROOM);
    static uint32_t turn;
    turn++; /* fans do not always go the same ways */
    for (uint32_t fan = 0; fan < 2; fan++, turn++) {
        aim(fan);
        brute(scene, count, instances == 1 ? 20 : count / 20);
        against_brute(scene, "bvh", room, count, turn);
        against_brute(scene, "kdtree", room, count, turn);
    }
    free(room);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

static void test_few(void **state)
{
    (void)state;
    seed = 3;
    each_scene(3, 5, false, true, 1000);
    each_scene(5, 5, false, false, 1003);
    each_scene(24, 5, false, true, RAYS);
}

static void test_many(void **state)
{
    (void)state;
    seed = 4;
    each_scene(150, 5, false, true, 2005);
}

/* All in one heap: there is no room for the lists of so many rays, and they go by halves; the last ones by themselves. */
static void test_heap(void **state)
{
    (void)state;
    seed = 6;
    each_scene(40, 0.5f, false, true, RAYS);
}

/* Bodies and meshes in no order and in tiles, none but of instances; batches below and above what goes through them together. */
static void test_only(void **state)
{
    (void)state;
    seed = 7;
    each_scene(12, 5, false, false, 200);
    each_scene(12, 5, false, false, 4099);
}

/* One instance, which is the top level: with and without anything beside it. */
static void test_one(void **state)
{
    (void)state;
    seed = 8;
    each_scene(1, 0.5f, false, false, 8500);
    each_scene(1, 0.5f, false, true, 8501);
}

/* Planes in instances are in every ray's way: rays go one by one. */
static void test_planes(void **state)
{
    (void)state;
    seed = 5;
    each_scene(8, 5, true, true, 500);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_few),  cmocka_unit_test(test_many), cmocka_unit_test(test_heap),
                                       cmocka_unit_test(test_only), cmocka_unit_test(test_one),  cmocka_unit_test(test_planes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
