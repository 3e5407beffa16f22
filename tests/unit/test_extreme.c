/* Geometry down to the least floats: sizes that run over all powers of two in one scene, needles, scenes that are tiny as a
 * whole. Every tracer still gives brute force's hits, bit for bit (kernel/ray.h, theory point 7). */
#include <math.h>

#include "scene_kit.h"

#include "librt/render.h"
#include "librt/trace.h"

enum { RAYS = 512, MOST = 48, KINDS = 5 };

static const float scales[] = {2.5e11f, 1.0f, 5e-3f, 1e-12f, 1e-20f, 1e-26f, 1e-31f, 1e-37f, 1e-41f};

typedef struct world {
    float corners[9 * MOST];
    uint32_t indices[3 * MOST], count;
    float scale;
} world;

/* series: towards the origin by powers of two; patch: all sizes far from it; needles; spheres beside triangles; anything. */
static void make_world(world *w, uint32_t kind, float scale, uint32_t *seed)
{
    w->count = 1 + (uint32_t)(kit_unit(seed) * (MOST - 1));
    w->scale = scale;
    for (uint32_t i = 0; i < w->count; i++) {
        float size = scale * exp2f(-kit_range(seed, 0, kind == 1 ? 100 : 10)), far = scale;
        rt_vec3 at;
        if (kind == 0)
            far = size = scale * exp2f(-kit_range(seed, 0, 120));
        at = kit_vec(seed, far);
        for (uint32_t v = 0; v < 3; v++) {
            rt_vec3 d = kit_vec(seed, kind == 2 && v == 1 ? scale : (kind == 2 ? size * 1e-18f : size));
            memcpy(&w->corners[9 * i + 3 * v], (float[3]){at.x + d.x, at.y + d.y, at.z + d.z}, 12);
            w->indices[3 * i + v] = 3 * i + v;
        }
    }
}

static rt_scene *make_scene(rt_context *ctx, const world *w, uint32_t kind, uint32_t *seed)
{
    rt_scene *scene = kit_scene(ctx);
    rt_mesh_desc mesh = rt_mesh_desc_default();
    rt_commit_desc commit = rt_commit_desc_default();
    mesh.positions = w->corners;
    mesh.vertex_count = 3 * w->count;
    mesh.indices = w->indices;
    mesh.triangle_count = w->count;
    kit_ok(ctx, rt_scene_add_mesh(scene, &mesh, NULL));
    for (uint32_t i = 0; kind == 3 && i < 40; i++) {
        float size = w->scale * exp2f(-kit_range(seed, 0, 100));
        rt_vec3 c = kit_vec(seed, i % 2 ? w->scale : size);
        kit_sphere(scene, c.x, c.y, c.z, size > 0.0f ? size : 1e-44f);
    }
    commit.accel = "kdtree,octree,bvh";
    commit.cost_intersect = w->count % 2 == 0 ? 0.25f : 0.0f; /* else there is one cell alone */
    kit_ok(ctx, rt_scene_commit(scene, &commit));
    return scene;
}

/* From within, near, far and from a triangle itself, at a point of a triangle; some along an axis; short and long directions. */
static void make_rays(const world *w, rt_ray *rays, uint32_t *seed)
{
    static const float reach[] = {0.0f, 1.0f, 2.0f, 100.0f}, length[] = {1.0f, 1e17f, 1e-17f};
    for (uint32_t i = 0; i < RAYS; i++) {
        const float *tri = &w->corners[9 * (uint32_t)(kit_unit(seed) * (float)w->count)];
        float b = kit_unit(seed), c = kit_unit(seed) * (1 - b), o[3], d[3], most = 0.0f;
        for (uint32_t a = 0; a < 3; a++) {
            float to = tri[a] * (1 - b - c) + tri[3 + a] * b + tri[6 + a] * c;
            o[a] = i % 16 == 4 ? kit_range(seed, -1, 1) : w->scale * reach[i % 4] * kit_range(seed, -1, 1);
            o[a] = i % 8 == 0 ? to * kit_range(seed, 0, 2) : o[a];
            d[a] = to - o[a];
            most = fmaxf(most, fabsf(d[a]));
        }
        if (most > 0.0f && i % 5 != 1) /* as it is, a direction of less than 10^-18 misses */
            for (uint32_t a = 0; a < 3; a++)
                d[a] = (float)ldexp(d[a], -ilogbf(most)) * length[i % 12 < 9 ? 0 : i % 3];
        if (i % 7 == 0)
            d[i % 3] = 0.0f;
        rays[i] = kit_ray(o[0], o[1], o[2], d[0], d[1], d[2]);
        rays[i].tmin = i % 3 == 0 ? 0.0f : (i % 3 == 1 ? -INFINITY : w->scale * 1e-9f);
        rays[i].tmax = i % 5 ? INFINITY : w->scale;
    }
}

/* Returns how many rays hit. */
static uint32_t same_for_all(rt_scene *scene, const rt_ray *rays, const char *what, float scale)
{
    static rt_hit truth[RAYS], hits[RAYS];
    static uint8_t dark[RAYS], true_dark[RAYS];
    uint32_t met = 0;
    rt_tracer *t;
    const char *name;
    kit_ok(rt_scene_context(scene), rt_tracer_create(scene, "brute", &t));
    rt_tracer_intersect(t, rays, truth, RAYS, 0);
    rt_tracer_occluded(t, rays, true_dark, RAYS, 0);
    rt_tracer_destroy(t);
    for (uint32_t i = 0; i < RAYS; i++) {
        met += truth[i].prim_id != RT_INVALID_ID;
        assert_int_equal(true_dark[i], truth[i].prim_id != RT_INVALID_ID);
    }
    for (uint32_t n = 0; (name = rt_tracer_at(n, NULL)) != NULL; n++) {
        kit_ok(rt_scene_context(scene), rt_tracer_create(scene, name, &t));
        for (uint32_t hints = 0; hints < 5; hints++) {
            for (uint32_t i = 0; hints == 4 && i < RAYS; i++) { /* one by one */
                rt_tracer_intersect(t, &rays[i], &hits[i], 1, 0);
                rt_tracer_occluded(t, &rays[i], &dark[i], 1, 0);
            }
            if (hints < 4) {
                rt_tracer_intersect(t, rays, hits, RAYS, hints);
                rt_tracer_occluded(t, rays, dark, RAYS, hints);
            }
            for (uint32_t i = 0; i < RAYS; i++)
                if (memcmp(&hits[i], &truth[i], sizeof *hits) != 0 || dark[i] != true_dark[i])
                    fail_msg("%s of scale %g, %s, hints %u, ray %u: brute force t %a prim %u dark %u, here t %a prim %u dark %u",
                             what, (double)scale, name, hints, i, (double)truth[i].t, truth[i].prim_id, true_dark[i],
                             (double)hits[i].t, hits[i].prim_id, dark[i]);
        }
        rt_tracer_destroy(t);
    }
    return met;
}

static void every_scale_is_traced_alike(void **state)
{
    static const char *const kinds[KINDS] = {"series", "patch", "needles", "spheres", "soup"};
    static world w;
    static rt_ray rays[RAYS];
    rt_context *ctx = kit_context(NULL, 1);
    uint32_t seed = 5, met = 0;
    (void)state;
    for (uint32_t kind = 0; kind < KINDS; kind++)
        for (uint32_t i = 0; i < sizeof scales / sizeof *scales; i++) {
            make_world(&w, kind, scales[i], &seed);
            make_rays(&w, rays, &seed);
            rt_scene *scene = make_scene(ctx, &w, kind, &seed);
            met += same_for_all(scene, rays, kinds[kind], scales[i]);
            rt_scene_destroy(scene);
        }
    assert_true(met > 5000);
    rt_context_destroy(ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_scale_is_traced_alike)};
    kit_level();
    return cmocka_run_group_tests_name("extreme", tests, NULL, NULL);
}
