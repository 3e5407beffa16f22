/* Many shapes as one geometry: they are hit as the same shapes added one at a time are, by every tracer, saved or not; what is
 * refused leaves the scene as it was. */
#include <math.h>
#include <unistd.h>

#include "scene_kit.h"

#include "librt/render.h"
#include "librt/trace.h"

enum { COUNT = 300, RAYS = 3000 };
enum { SPHERES, CYLINDERS, CONES, KINDS };

/* Shapes of each kind, some far larger than others, some cones pointed at either end. */
typedef struct bodies {
    float from[3 * COUNT], to[3 * COUNT], radii0[COUNT], radii1[COUNT], colors[3 * COUNT];
    uint32_t materials[COUNT];
} bodies;

static void fill(bodies *b, uint32_t seed)
{
    for (uint32_t i = 0; i < COUNT; i++) {
        const float size = i % 50 == 0 ? 1.0f : 0.2f;
        for (uint32_t k = 3 * i; k < 3 * i + 3; k++) {
            b->from[k] = kit_range(&seed, -2, 2);
            b->to[k] = b->from[k] + kit_range(&seed, -size, size);
            b->colors[k] = kit_unit(&seed);
        }
        b->radii0[i] = kit_range(&seed, 0.01f, 0.3f * size);
        b->radii1[i] = i % 3 == 0 ? 0.0f : kit_range(&seed, 0.0f, 0.3f * size);
        if (i % 7 == 1) {
            b->radii1[i] = b->radii0[i];
            b->radii0[i] = i % 14 == 1 ? 0.0f : b->radii1[i];
        }
        b->materials[i] = i % 3;
    }
    for (uint32_t i = 0; i < COUNT; i++) /* who asks for spheres and cylinders: none of 0 */
        b->radii0[i] += i % 14 == 1 ? 0.0f : 0.001f;
}

static rt_scene *scene_of(rt_context *ctx)
{
    rt_scene *scene = kit_scene(ctx);
    for (uint32_t i = 0; i < 3; i++) {
        rt_material_desc d = rt_material_desc_default();
        d.color = (rt_vec3){0.2f + 0.3f * (float)i, 0.5f, 0.9f};
        kit_ok(ctx, rt_scene_add_material(scene, &d, NULL));
    }
    return scene;
}

static float positive(float r)
{
    return r > 0.0f ? r : 0.05f;
}

static void add_one(rt_scene *scene, const bodies *b, uint32_t kind, uint32_t i)
{
    rt_context *ctx = rt_scene_context(scene);
    const float *from = b->from + 3 * i, *to = b->to + 3 * i;
    rt_sphere_desc s = rt_sphere_desc_default();
    rt_cone_desc c = rt_cone_desc_default();
    s.common.material.id = c.common.material.id = b->materials[i];
    s.center = c.from = (rt_vec3){from[0], from[1], from[2]};
    c.to = (rt_vec3){to[0], to[1], to[2]};
    s.radius = positive(b->radii0[i]);
    c.radius0 = kind == CYLINDERS ? positive(b->radii0[i]) : b->radii0[i];
    c.radius1 = b->radii1[i];
    kit_ok(ctx, kind == SPHERES     ? rt_scene_add_sphere(scene, &s, NULL)
                : kind == CYLINDERS ? rt_scene_add_cylinder(scene, &c, NULL)
                                    : rt_scene_add_cone(scene, &c, NULL));
}

static rt_status add_many(rt_scene *scene, const bodies *b, uint32_t kind, bool colors)
{
    static float radii[COUNT];
    rt_spheres_desc s = rt_spheres_desc_default();
    rt_cones_desc c = rt_cones_desc_default();
    for (uint32_t i = 0; i < COUNT; i++)
        radii[i] = positive(b->radii0[i]);
    s.centers = c.from = b->from;
    c.to = b->to;
    s.radii = radii;
    c.radii = kind == CYLINDERS ? radii : b->radii0;
    c.to_radii = b->radii1;
    s.count = c.count = COUNT;
    s.face_materials = c.face_materials = b->materials;
    s.colors = c.colors = colors ? b->colors : NULL;
    return kind == SPHERES     ? rt_scene_add_spheres(scene, &s, NULL)
           : kind == CYLINDERS ? rt_scene_add_cylinders(scene, &c, NULL)
                               : rt_scene_add_cones(scene, &c, NULL);
}

/* A hit of `many`, of whose geometry g the shapes are, is that of `ones`, whose geometries from `first` on they are. */
static void same(const char *tracer, const rt_scene *ones, const rt_scene *many, const rt_ray *ray, rt_hit one, rt_hit hit)
{
    rt_surface a, b;
    if (one.prim_id == RT_INVALID_ID || hit.prim_id == RT_INVALID_ID) {
        assert_int_equal(one.prim_id, hit.prim_id);
        return;
    }
    if (memcmp(&one.t, &hit.t, 3 * sizeof(float)) != 0 || one.geom_id != COUNT * hit.geom_id + hit.prim_id)
        fail_msg("%s: geometry %u at %a, and of many %u, %u at %a", tracer, one.geom_id, (double)one.t, hit.geom_id, hit.prim_id,
                 (double)hit.t);
    rt_scene_surface(ones, ray, &one, &a);
    rt_scene_surface(many, ray, &hit, &b);
    assert_memory_equal(&a.position, &b.position, sizeof a.position);
    assert_memory_equal(&a.ng, &b.ng, sizeof a.ng);
    assert_true(a.u == b.u && a.v == b.v && a.position_error == b.position_error);
    assert_int_equal(a.material.id, b.material.id);
    assert_memory_equal(&a.color, &b.color, sizeof a.color);
    assert_int_equal(b.face_id, hit.prim_id);
}

/* Every tracer, rays together and one by one. */
static void compare(const rt_scene *ones, const rt_scene *many, uint32_t seed)
{
    static rt_ray rays[RAYS];
    static rt_hit truth[RAYS], hits[RAYS];
    uint32_t met = 0;
    const char *name;
    for (uint32_t i = 0; i < RAYS; i++) {
        const rt_vec3 o = kit_vec(&seed, i % 2 ? 3.0f : 0.5f), d = kit_vec(&seed, 1.0f);
        rays[i] = kit_ray(o.x, o.y, o.z, d.x, d.y, d.z);
    }
    rt_scene_intersect(ones, rays, truth, RAYS);
    for (uint32_t i = 0; i < RAYS; i++)
        met += truth[i].prim_id != RT_INVALID_ID;
    assert_in_range(met, RAYS / 4, RAYS - RAYS / 20);
    for (uint32_t t = 0; (name = rt_tracer_at(t, NULL)) != NULL; t++) {
        rt_tracer *tracer;
        if (rt_tracer_create(many, name, &tracer) != RT_OK) /* whose tree was not asked for */
            continue;
        rt_tracer_intersect(tracer, rays, hits, RAYS, 0);
        for (uint32_t i = 0; i < RAYS; i++)
            same(name, ones, many, &rays[i], truth[i], hits[i]);
        for (uint32_t i = 0; i < RAYS; i += 5) {
            rt_tracer_intersect(tracer, &rays[i], &hits[i], 1, 0);
            same(name, ones, many, &rays[i], truth[i], hits[i]);
        }
        rt_tracer_destroy(tracer);
    }
}

static void test_as_single_ones(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *ones = scene_of(ctx), *many = scene_of(ctx), *loaded;
    rt_commit_desc commit = rt_commit_desc_default();
    char path[64];
    static bodies b[KINDS];
    (void)state;
    for (uint32_t kind = 0; kind < KINDS; kind++) {
        fill(&b[kind], 11 + kind);
        for (uint32_t i = 0; i < COUNT; i++)
            add_one(ones, &b[kind], kind, i);
        kit_ok(ctx, add_many(many, &b[kind], kind, false));
    }
    commit.accel = "kdtree,octree,bvh";
    kit_ok(ctx, rt_scene_commit(ones, &commit));
    kit_ok(ctx, rt_scene_commit(many, &commit));
    compare(ones, many, 5);
    snprintf(path, sizeof path, "shape_many_%ld.snapshot", (long)getpid());
    assert_int_equal(rt_scene_save(many, path), RT_OK);
    kit_ok(ctx, rt_scene_load(ctx, path, &loaded));
    remove(path);
    compare(ones, loaded, 6);
    rt_scene_destroy(loaded);
    rt_scene_destroy(ones);
    rt_scene_destroy(many);
    rt_context_destroy(ctx);
}

/* One radius for all, colours, and none at all. */
static void test_defaults(void **state)
{
    static const float from[] = {0, 0, 0, 3, 0, 0}, to[] = {0, 2, 0, 3, 2, 0}, colors[] = {1, 0, 0, 0, 0.5f, 1};
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = scene_of(ctx);
    rt_cones_desc d = rt_cones_desc_default();
    (void)state;
    kit_ok(ctx, rt_scene_add_cylinders(scene, &d, NULL)); /* none */
    kit_ok(ctx, rt_scene_add_cones(scene, &d, NULL));
    d.from = from;
    d.to = to;
    d.count = 2;
    d.colors = colors;
    d.radius = 0.5f;
    d.common.material.id = 1;
    kit_ok(ctx, rt_scene_add_cones(scene, &d, NULL));
    kit_commit(scene);
    for (int i = 0; i < 2; i++) {
        rt_surface at;
        rt_ray ray = kit_ray(3.0f * (float)i, 1, 5, 0, 0, -1);
        rt_hit hit = kit_hit(scene, ray);
        assert_int_equal(hit.geom_id, 2);
        assert_int_equal(hit.prim_id, i);
        assert_true(fabsf(hit.t - 4.75f) < 1e-5f); /* half way to the tip */
        rt_scene_surface(scene, &ray, &hit, &at);
        assert_true(fabsf(at.color.x - 0.2f * colors[3 * i]) < 1e-6f && fabsf(at.color.z - 0.9f * colors[3 * i + 2]) < 1e-6f);
    }
    assert_int_equal(kit_hit(scene, kit_ray(1.5f, 1, 5, 0, 0, -1)).prim_id, RT_INVALID_ID);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

static void test_refusals(void **state)
{
    float from[] = {0, 0, 0, 3, NAN, 0}, to[] = {0, 2, 0, 3, 0, 0}, radii[] = {1, -2};
    uint32_t ids[] = {0, 4};
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = scene_of(ctx);
    rt_cones_desc d = rt_cones_desc_default();
    (void)state;
    d.count = 2;
    KIT_REFUSED(ctx, rt_scene_add_cones(scene, &d, NULL), "rt_scene_add_cones: from is NULL, but count is 2");
    d.from = from;
    KIT_REFUSED(ctx, rt_scene_add_cylinders(scene, &d, NULL), "rt_scene_add_cylinders: from[1] (part 1) is nan");
    from[4] = 0;
    KIT_REFUSED(ctx, rt_scene_add_cylinders(scene, &d, NULL), "to is NULL, but count is 2");
    d.to = to;
    KIT_REFUSED(ctx, rt_scene_add_cylinders(scene, &d, NULL), "from[1] and to[1] are the same point; they must differ");
    to[4] = 2;
    d.radii = radii;
    KIT_REFUSED(ctx, rt_scene_add_cylinders(scene, &d, NULL), "radii[1] is -2; it must be greater than 0");
    KIT_REFUSED(ctx, rt_scene_add_cones(scene, &d, NULL), "radii[1] is -2; it must be from 0 to ");
    radii[1] = 0;
    KIT_REFUSED(ctx, rt_scene_add_cylinders(scene, &d, NULL), "radii[1] is 0; it must be greater than 0");
    KIT_REFUSED(ctx, rt_scene_add_cones(scene, &d, NULL), "cone [1] has radius 0 at both ends; one must be greater");
    d.radii = NULL;
    d.radius = NAN;
    KIT_REFUSED(ctx, rt_scene_add_cones(scene, &d, NULL), "radius is nan");
    d.radius = 1;
    d.to_radius = INFINITY;
    KIT_REFUSED(ctx, rt_scene_add_cones(scene, &d, NULL), "to_radius is inf");
    d.to_radii = (const float *)16; /* cylinders have no such, and do not look */
    kit_ok(ctx, rt_scene_add_cylinders(scene, &d, NULL));
    d.to_radii = NULL;
    d.to_radius = 0;
    d.face_materials = ids;
    KIT_REFUSED(ctx, rt_scene_add_cones(scene, &d, NULL), "face_materials[1] is 4");
    d.face_materials = NULL;
    d.count = 0xffffffffu;
    KIT_REFUSED(ctx, rt_scene_add_cones(scene, &d, NULL), "count is 4294967295; it must be at most ");
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

/* Each allocation of an add fails in its turn. */
static void test_no_memory(void **state)
{
    kit_memory memory = {0};
    rt_context *ctx = kit_context(&memory, 1);
    static bodies b;
    (void)state;
    fill(&b, 3);
    for (uint32_t kind = 0; kind < KINDS; kind++) {
        rt_status status = RT_ERROR_MEMORY;
        uint32_t refused = 0;
        for (long n = 1; status != RT_OK; n++) {
            rt_scene *scene = scene_of(ctx);
            atomic_store(&memory.fail_at, atomic_load(&memory.requests) + n);
            status = add_many(scene, &b, kind, true);
            atomic_store(&memory.fail_at, 0);
            assert_true(status == RT_OK || status == RT_ERROR_MEMORY);
            refused += status != RT_OK;
            kit_commit(scene);
            assert_int_equal(kit_info(scene).shapes, status == RT_OK ? COUNT : 0);
            rt_scene_destroy(scene);
        }
        assert_true(refused >= 2);
    }
    rt_context_destroy(ctx);
    assert_int_equal(atomic_load(&memory.blocks), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_as_single_ones), cmocka_unit_test(test_defaults),
                                       cmocka_unit_test(test_refusals), cmocka_unit_test(test_no_memory)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
