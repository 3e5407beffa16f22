/* Shading in lanes against the scalar functions it is made of, at every instruction set that this machine runs: surfaces of every
 * kind, the rare ones among them, lights, sums and rows of the image, bit for bit. */
#include "scene_kit.h"

#include <math.h>
#include <stdio.h>

#include "render/job.h"
#include "render/lanes.h"
#include "render/shade.h"
#include "scene/scene.h"
#include "trace/trace.h"

static uint32_t seed;

/* Triangles of all kinds, every second of slivers, some tiny, with or without normals (some zero), coordinates, colours. */
static void add_mesh(rt_scene *scene, uint32_t kind, const uint32_t materials[3])
{
    enum { N = 150 };
    static float positions[9 * N], normals[9 * N], uvs[6 * N], colors[9 * N];
    static uint32_t indices[3 * N], faces[N];
    rt_mesh_desc d = rt_mesh_desc_default();
    for (uint32_t t = 0; t < N; t++) {
        float size = t % 7 == 0 ? 1e-9f : 1.0f,
              c[3] = {kit_range(&seed, -4, 4), kit_range(&seed, -4, 4), kit_range(&seed, -4, 4)}, e[3];
        for (int i = 0; i < 3; i++)
            e[i] = kit_range(&seed, -size, size);
        for (int k = 0; k < 9; k++) {
            float sliver = t % 2 == 0 ? 1.0f : 1e-5f;
            positions[9 * t + k] = c[k % 3] + (float)(k / 3) * e[k % 3] + (k > 5 ? sliver : 0.3f) * kit_range(&seed, -size, size);
            normals[9 * t + k] = t % 5 == 0 ? 0.0f : t % 11 == 0 ? kit_range(&seed, -1e-20f, 1e-20f) : kit_range(&seed, -1, 1);
            colors[9 * t + k] = kit_range(&seed, 0, 1);
        }
        for (int k = 0; k < 6; k++)
            uvs[6 * t + k] = kit_range(&seed, -3, 3);
        for (uint32_t k = 0; k < 3; k++)
            indices[3 * t + k] = 3 * t + k;
        faces[t] = materials[t % 3];
    }
    d.positions = positions;
    d.vertex_count = 3 * N;
    d.indices = indices;
    d.triangle_count = N;
    d.normals = kind & 1 ? normals : NULL;
    d.uvs = kind & 2 ? uvs : NULL;
    d.colors = kind & 4 ? colors : NULL;
    d.face_materials = kind & 8 ? faces : NULL;
    d.common.material.id = materials[kind % 3];
    d.common.uv_transform[0] = 0.7f;
    d.common.uv_transform[1] = 0.2f;
    kit_ok(rt_scene_context(scene), rt_scene_add_mesh(scene, &d, NULL));
}

static void add_shapes(rt_scene *scene, const uint32_t materials[3])
{
    enum { N = 40 };
    float centers[3 * N], colors[3 * N];
    rt_spheres_desc balls = rt_spheres_desc_default();
    rt_plane_desc plane = rt_plane_desc_default();
    rt_box_desc box = rt_box_desc_default();
    for (uint32_t m = 0; m < 3; m++) {
        for (int k = 0; k < 3 * N; k++) {
            centers[k] = kit_range(&seed, -5, 5);
            colors[k] = kit_range(&seed, 0, 1);
        }
        balls.centers = centers;
        balls.colors = m == 1 ? colors : NULL;
        balls.count = N;
        balls.radius = 0.4f;
        balls.common.material.id = materials[m];
        kit_ok(rt_scene_context(scene), rt_scene_add_spheres(scene, &balls, NULL));
        plane.point = (rt_vec3){0, -6 - (float)m, 0};
        plane.normal = (rt_vec3){kit_range(&seed, -0.1f, 0.1f), 1, kit_range(&seed, -0.1f, 0.1f)};
        plane.common.material.id = materials[m];
        kit_ok(rt_scene_context(scene), rt_scene_add_plane(scene, &plane, NULL));
        box.low = (rt_vec3){kit_range(&seed, -4, 3), kit_range(&seed, -4, 3), kit_range(&seed, -4, 3)};
        box.high = (rt_vec3){box.low.x + 0.8f, box.low.y + 0.5f, box.low.z + 0.7f};
        box.common.material.id = materials[m];
        kit_ok(rt_scene_context(scene), rt_scene_add_box(scene, &box, NULL));
    }
}

static void add_materials(rt_scene *scene, uint32_t ids[3])
{
    static const uint8_t texels[12] = {255, 0, 40, 10, 200, 90, 4, 60, 250, 128, 128, 7};
    rt_texture_desc td = rt_texture_desc_default();
    for (uint32_t i = 0; i < 3; i++) {
        rt_material_desc d = rt_material_desc_default();
        rt_material made;
        d.color = (rt_vec3){kit_range(&seed, 0, 1), kit_range(&seed, 0, 1), kit_range(&seed, 0, 1)};
        if (i == 1) {
            td.width = td.height = 2;
            td.pixels = texels;
            kit_ok(rt_scene_context(scene), rt_scene_add_texture(scene, &td, &d.color_texture));
        }
        kit_ok(rt_scene_context(scene), rt_scene_add_material(scene, &d, &made));
        ids[i] = made.id;
    }
}

static rt_scene *mixed_scene(rt_context *ctx)
{
    rt_scene *scene = kit_scene(ctx), *child = kit_scene(ctx);
    uint32_t materials[3];
    seed = 5;
    add_materials(child, materials);
    add_mesh(child, 7, materials);
    add_shapes(child, materials);
    kit_ok(ctx, rt_scene_commit(child, NULL));
    add_materials(scene, materials);
    for (uint32_t kind = 0; kind < 16; kind++)
        add_mesh(scene, kind, materials);
    add_shapes(scene, materials);
    for (int i = 0; i < 2; i++) {
        rt_instance_desc place = rt_instance_desc_default();
        place.child = child;
        place.transform = rt_transform_multiply(rt_transform_translate((rt_vec3){0.5f, (float)i, -0.7f}),
                                                rt_transform_rotate((rt_vec3){1, 2, 3}, 40));
        kit_ok(ctx, rt_scene_add_instance(scene, &place, NULL));
    }
    kit_ok(ctx, rt_scene_commit(scene, NULL));
    rt_scene_destroy(child);
    return scene;
}

/* ---- a job whose worker is fed by hand ---- */

static rt_job *make_job(rt_scene *scene, rti_isa isa)
{
    rt_render_desc d = rt_render_desc_default();
    rti_snapshot *snapshot;
    rt_job *job;
    d.width = d.height = 64;
    d.samples = 1;
    d.workers = 1;
    d.tracer = "brute";
    kit_ok(rt_scene_context(scene), rti_job_snapshot(scene, "test", &snapshot));
    kit_ok(rt_scene_context(scene), rti_job_create(rt_scene_context(scene), snapshot, "test", &d, NULL, &job));
    rti_snapshot_release(snapshot);
    job->frame.lanes = rti_lanes_find(isa);
    return job;
}

/* Half of the rays aim at triangles' middles, so that tiny and thin ones are met too. */
static void fill_batch(rti_worker *w, uint32_t count)
{
    const rtk_scene *scene = w->frame->scene;
    const rtk_group *g = &scene->groups[0];
    for (uint32_t i = 0; i < count; i++) {
        rtk_trace_block *t = &w->batch.trace[i / RTK_BLOCK];
        rtk_path_block *p = &w->batch.path[i / RTK_BLOCK];
        uint32_t k = i % RTK_BLOCK;
        rtk_vec3 org = rtk_v3(kit_range(&seed, -6, 6), kit_range(&seed, -6, 6), kit_range(&seed, -6, 6)), aim, dir;
        const rtk_tri *tri = &g->tris[(uint32_t)kit_range(&seed, 0, (float)g->tri_count - 1)];
        aim = rtk_v3(kit_range(&seed, -4, 4), kit_range(&seed, -4, 4), kit_range(&seed, -4, 4));
        if (i & 1)
            aim = rtk_v3((tri->v0[0] + tri->v1[0] + tri->v2[0]) / 3, (tri->v0[1] + tri->v1[1] + tri->v2[1]) / 3,
                         (tri->v0[2] + tri->v1[2] + tri->v2[2]) / 3);
        if (i % 3 == 0) /* from near by: nothing is between */
            org = rtk_madd(aim, 0.001f, rtk_sub(org, aim));
        dir = rtk_unit(rtk_sub(aim, org));
        memset(&t->ox[k], 0, sizeof t->ox[k]);
        t->ox[k] = org.x;
        t->oy[k] = org.y;
        t->oz[k] = org.z;
        t->dx[k] = dir.x;
        t->dy[k] = dir.y;
        t->dz[k] = dir.z;
        t->tmin[k] = 0.0f;
        t->tmax[k] = RTK_INF;
        t->mask[k] = 0xffffffffu;
        p->tpr[k] = kit_range(&seed, 0, 1);
        p->tpg[k] = kit_range(&seed, 0, 1);
        p->tpb[k] = kit_range(&seed, 0, 1);
        p->depth_kind[k] = 0;
        p->width[k] = kit_range(&seed, 0, 0.1f);
        p->spread[k] = kit_range(&seed, 0, 0.01f);
        w->batch.home[i / RTK_BLOCK].home[k] = i % 4096;
    }
    rti_tracer_find(RTI_ISA_GENERIC, "brute")->intersect(scene, w->batch.trace, w->hits, count, 0, &w->scratch);
}

static uint8_t seen[2048];
static uint32_t by_kind[RTI_SURFACE_COUNT], rare, by_look[2];

static void same(float a, float b, const char *what, uint32_t ray)
{
    if (rtk_bits(a) != rtk_bits(b))
        fail_msg("ray %u: %s is %.9g in lanes, %.9g alone", (unsigned)ray, what, a, b);
}

static void same3(float x, float y, float z, rtk_vec3 v, const char *what, uint32_t ray)
{
    same(x, v.x, what, ray);
    same(y, v.y, what, ray);
    same(z, v.z, what, ray);
}

static void check_sheaf(rti_worker *w, rti_sheaf *c)
{
    const rtk_scene *scene = w->frame->scene;
    for (uint32_t k = 0; k < c->count; k++) {
        uint32_t i = c->ray[k];
        rtk_ray ray = rti_batch_ray(w, i);
        rtk_hit hit = rti_hit_at(w->hits, i);
        rtk_surface s = rtk_surface_at(scene, ray, hit, 0.0f);
        int outside = rtk_face(&s, ray.dir);
        rti_ray_state state = rti_batch_state(w, i);
        const rtk_material *m = &scene->materials[s.material];
        assert_int_not_equal(hit.prim, RTK_INVALID);
        assert_int_equal(seen[i]++, 0);
        same3(c->px[k], c->py[k], c->pz[k], s.p, "p", i);
        same3(c->gx[k], c->gy[k], c->gz[k], s.ng, "ng", i);
        same3(c->nx[k], c->ny[k], c->nz[k], s.ns, "ns", i);
        same(c->error[k], s.error, "error", i);
        same(c->footprint[k], state.width + state.spread * hit.t, "footprint", i);
        assert_int_equal(c->outside[k], outside);
        assert_int_equal(c->material[k], s.material);
        same3(c->cr[k], c->cg[k], c->cb[k], rtk_base_color(scene, m, s, c->footprint[k]), "colour", i);
        by_kind[c->surface_kind]++;
        by_look[m->color_tex != RTK_INVALID]++;
        rare += c->surface_kind != RTI_SURFACE_OTHER && !c->plain[k];
    }
}

static void each_isa(void (*test)(rt_scene *scene, rti_isa isa))
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = mixed_scene(ctx);
    for (int isa = 0; isa < RTI_ISA_COUNT; isa++)
        if (rti_isa_runs((rti_isa)isa))
            test(scene, (rti_isa)isa);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

static void surfaces(rt_scene *scene, rti_isa isa)
{
    rt_job *job = make_job(scene, isa);
    rti_worker *w = &job->workers[0].wave;
    memset(by_kind, 0, sizeof by_kind);
    by_look[0] = by_look[1] = rare = 0;
    seed = 77;
    for (uint32_t round = 0; round < 4; round++) {
        uint32_t count = 2048 - 37 * round, hits = 0, met = 0;
        fill_batch(w, count);
        memset(seen, 0, sizeof seen);
        rti_sheaves(w, 0, count, check_sheaf);
        for (uint32_t i = 0; i < count; i++) {
            hits += w->hits[i / RTK_BLOCK].prim[i % RTK_BLOCK] != RTK_INVALID;
            met += seen[i];
        }
        assert_int_equal(met, hits);
    }
    for (uint32_t kind = RTI_SURFACE_MESH; kind < RTI_SURFACE_COUNT; kind++)
        assert_true(by_kind[kind] > 20); /* else the scene has lost what this test is for */
    assert_true(by_look[0] > 100 && by_look[1] > 100 && rare > 50);
    rt_job_destroy(job);
}

static void test_surfaces(void **state)
{
    (void)state;
    each_isa(surfaces);
}

/* ---- sums ---- */

static float nasty(void)
{
    static const float some[] = {0,        -0.0f,     8192, -8192,  8193,           1e30f,
                                 INFINITY, -INFINITY, NAN,  1e-44f, 1.8626451e-09f, 5.5879354e-09f};
    uint32_t i = (uint32_t)kit_range(&seed, 0, 40);
    return i < sizeof some / sizeof *some ? some[i] : kit_range(&seed, -2, 2) * (i & 1 ? 1.0f : 1e-7f);
}

static void sums(rt_scene *scene, rti_isa isa)
{
    enum { N = 500, CELLS = 40 };
    rt_job *job = make_job(scene, isa);
    rti_worker *w = &job->workers[0].wave;
    uint64_t film[CELLS * RTK_FILM_CHANNELS] = {0}, clamped = 0, dropped = 0;
    seed = 9;
    memset(w->film, 0, sizeof film);
    w->shadows.count = N;
    for (uint32_t i = 0; i < N; i++) {
        rti_pending_block *p = &w->shadows.pending[i / RTK_BLOCK];
        uint32_t k = i % RTK_BLOCK, hidden = kit_range(&seed, 0, 1) < 0.3f;
        bool calm = i / RTK_BLOCK % 2; /* blocks of ordinary numbers go the quick way */
        p->r[k] = calm ? kit_range(&seed, 0, 2) : nasty();
        p->g[k] = calm ? kit_range(&seed, -1e-6f, 1e-6f) : nasty();
        p->b[k] = calm ? (float)(1 + 2 * (i % 9)) * 1.8626451e-09f : nasty(); /* halves of the unit */
        p->home[k] = (uint32_t)kit_range(&seed, 0, CELLS - 1);
        if (k == 0)
            w->shadows.occluded[i / RTK_BLOCK] = 0;
        w->shadows.occluded[i / RTK_BLOCK] |= (uint16_t)(hidden << k);
        if (hidden)
            continue;
        switch (rtk_film_add(film + p->home[k] * RTK_FILM_CHANNELS, rtk_v3(p->r[k], p->g[k], p->b[k]), job->frame.film_scale)) {
        case RTK_FILM_CLAMPED:
            clamped++;
            break;
        case RTK_FILM_DROPPED:
            dropped++;
            break;
        default:
            break;
        }
    }
    job->frame.lanes->arrive(w);
    assert_memory_equal(film, w->film, sizeof film);
    assert_int_equal(clamped, w->counts.clamped);
    assert_int_equal(dropped, w->counts.dropped);
    assert_true(clamped > 0 && dropped > 0);
    w->shadows.count = 0;
    rt_job_destroy(job);
}

static void test_sums(void **state)
{
    (void)state;
    each_isa(sums);
}

static void rows(rt_scene *scene, rti_isa isa)
{
    static const double samples[] = {1, 2, 3, 7, 64, 1000, 65536};
    uint64_t sum[4 * 37];
    float out[4 * 37];
    (void)scene;
    seed = 12;
    for (size_t s = 0; s < sizeof samples / sizeof *samples; s++) {
        double unit = s & 1 ? ldexp(1, -28) : ldexp(1, -20);
        for (uint32_t i = 0; i < 4 * 37; i++)
            sum[i] = (uint64_t)(int64_t)(kit_range(&seed, -1, 1) * (i % 9 == 0 ? 9e18f : 1e9f));
        for (uint32_t i = 3; i < 4 * 37; i += 4)
            sum[i] = (uint64_t)kit_range(&seed, 0, (float)samples[s]);
        rti_lanes_find(isa)->resolve(sum, out, 37, unit, samples[s]);
        for (uint32_t i = 0; i < 4 * 37; i++) {
            double value = i % 4 == 3 ? (double)sum[i] : (double)(int64_t)sum[i] * unit;
            assert_true((float)(value / samples[s]) == out[i]);
        }
    }
}

static void test_rows(void **state)
{
    (void)state;
    each_isa(rows);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_surfaces), cmocka_unit_test(test_sums), cmocka_unit_test(test_rows)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
