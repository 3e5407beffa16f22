/* A scene of everything that shading meets, the rare cases among them, and a job whose worker is fed by hand: for tests of
 * shading in lanes. */
#ifndef LANES_STAGE_H
#define LANES_STAGE_H

#include "scene_kit.h"

#include <math.h>
#include <stdio.h>

#include "render/job.h"
#include "render/lanes.h"
#include "render/shade.h"
#include "scene/scene.h"
#include "trace/trace.h"

static uint32_t seed;
static bool stage_clear, stage_lights; /* one material lets light through; lights of all kinds stand in the scene */

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
    rt_cone_desc rod = rt_cone_desc_default();
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
        box.common.material.id = materials[m];
        for (uint32_t i = 0; i < 5; i++) {
            box.low = (rt_vec3){kit_range(&seed, -4, 3), kit_range(&seed, -4, 3), kit_range(&seed, -4, 3)};
            box.high = (rt_vec3){box.low.x + 0.8f, box.low.y + 0.5f, box.low.z + 0.7f};
            kit_ok(rt_scene_context(scene), rt_scene_add_box(scene, &box, NULL));
        }
        rod.from = box.high;
        rod.to = (rt_vec3){kit_range(&seed, -4, 3), kit_range(&seed, -4, 3), kit_range(&seed, -4, 3)};
        rod.radius0 = 0.3f;
        rod.common.material.id = materials[m];
        kit_ok(rt_scene_context(scene), rt_scene_add_cylinder(scene, &rod, NULL));
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
        d.diffusion = i == 2 && !stage_clear ? 0.0f : 0.7f; /* a mirror alone, where nothing is clear */
        d.reflectiveness = 0.2f * (float)i;
        d.specular = i == 0 ? 0.3f : 0.0f;
        d.transparency = i == 2 && stage_clear ? 0.5f : 0.0f;
        d.refractiveness = 1.4f;
        if (i == 1) {
            td.width = td.height = 2;
            td.pixels = texels;
            kit_ok(rt_scene_context(scene), rt_scene_add_texture(scene, &td, &d.color_texture));
        }
        kit_ok(rt_scene_context(scene), rt_scene_add_material(scene, &d, &made));
        ids[i] = made.id;
    }
}

static void add_lights(rt_scene *scene)
{
    rt_spheres_desc lamp = rt_spheres_desc_default();
    const float lamp_at[3] = {1, 5.5f, -1};
    lamp.centers = lamp_at;
    lamp.count = 1;
    lamp.radius = 0.3f;
    kit_ok(rt_scene_context(scene), rt_scene_add_spheres(scene, &lamp, NULL));
    for (uint32_t i = 0; i < 6; i++) {
        static const rt_light_type types[6] = {RT_LIGHT_POINT,  RT_LIGHT_POINT,  RT_LIGHT_DIRECTIONAL,
                                               RT_LIGHT_SPHERE, RT_LIGHT_SPHERE, RT_LIGHT_SPHERE};
        rt_light_desc d = rt_light_desc_default();
        d.type = types[i];
        d.at = i == 1 ? (rt_vec3){lamp_at[0], lamp_at[1], lamp_at[2]}
                      : (rt_vec3){kit_range(&seed, -5, 5), kit_range(&seed, -5, 5), kit_range(&seed, -5, 5)};
        d.direction = (rt_vec3){0.3f, -1, 0.2f};
        d.radius = 0.7f;
        d.color = (rt_vec3){kit_range(&seed, 0.1f, 1), kit_range(&seed, 0.1f, 1), kit_range(&seed, 0.1f, 1)};
        d.intensity = kit_range(&seed, 1, 9);
        d.falloff = i % 2 ? RT_FALLOFF_INVERSE_SQUARE : RT_FALLOFF_NONE;
        d.visible = i != 4;
        d.samples = 3;
        kit_ok(rt_scene_context(scene), rt_scene_add_light(scene, &d, NULL));
    }
}

/* Placed in the scene: turned, stretched, mirrored, nearly flat, of other materials than their own. */
static void add_instances(rt_scene *scene, const rt_scene *child, uint32_t first, const uint32_t materials[3])
{
    static const rt_vec3 sizes[] = {{1, 1, 1}, {1, 1, 1}, {0.7f, 1.3f, 1}, {-1, 1, 1}, {1, 5e-16f, 1}, {5e-16f, 1, 1}};
    for (uint32_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        rt_instance_desc place = rt_instance_desc_default();
        place.child = (rt_scene *)child;
        place.transform = rt_transform_multiply(
            rt_transform_translate((rt_vec3){0.5f, (float)i - 2 * (float)first, -0.7f}),
            rt_transform_multiply(rt_transform_rotate((rt_vec3){1, 2, 3}, 40 * (float)(i + first + 1)), rt_transform_scale(sizes[i])));
        if (i == 2 || i == 3)
            place.material.id = materials[i - 1];
        kit_ok(rt_scene_context(scene), rt_scene_add_instance(scene, &place, NULL));
    }
}

static rt_scene *mixed_scene(rt_context *ctx)
{
    rt_scene *scene = kit_scene(ctx), *children[2];
    uint32_t materials[3];
    seed = 5;
    for (uint32_t i = 0; i < 2; i++) {
        children[i] = kit_scene(ctx);
        add_materials(children[i], materials);
        add_mesh(children[i], i == 0 ? 7 : 0, materials);
        if (i == 1)
            add_mesh(children[i], 10, materials);
        add_shapes(children[i], materials);
        kit_ok(ctx, rt_scene_commit(children[i], NULL));
    }
    add_materials(scene, materials);
    for (uint32_t kind = 0; kind < 16; kind++)
        add_mesh(scene, kind, materials);
    add_shapes(scene, materials);
    if (stage_lights)
        add_lights(scene);
    for (uint32_t i = 0; i < 2; i++)
        add_instances(scene, children[i], i, materials);
    kit_ok(ctx, rt_scene_commit(scene, NULL));
    rt_scene_destroy(children[0]);
    rt_scene_destroy(children[1]);
    return scene;
}

/* ---- a job whose worker is fed by hand ---- */

static rt_job *make_job(rt_scene *scene, rti_isa isa, const char *integrator)
{
    rt_render_desc d = rt_render_desc_default();
    rti_snapshot *snapshot;
    rt_job *job;
    d.width = d.height = 64;
    d.samples = 1;
    d.workers = 1;
    d.tracer = "brute";
    d.integrator = integrator;
    kit_ok(rt_scene_context(scene), rti_job_snapshot(scene, "test", &snapshot));
    kit_ok(rt_scene_context(scene), rti_job_create(rt_scene_context(scene), snapshot, "test", &d, NULL, &job));
    rti_snapshot_release(snapshot);
    job->frame.lanes = rti_lanes_find(isa);
    return job;
}

/* Half of the rays aim at triangles' middles, so that tiny and thin ones are met too. */
static void fill_batch(rti_worker *w, uint32_t count, uint32_t depth)
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
        const float most = i % 13 == 0 ? 0.002f : 1.0f; /* some bring too little for a mirror ray */
        p->tpr[k] = kit_range(&seed, 0, most);
        p->tpg[k] = kit_range(&seed, 0, most);
        p->tpb[k] = kit_range(&seed, 0, most);
        p->depth_kind[k] = depth | RTK_KIND_DIFFUSE << 16;
        p->pixel[k] = i;
        p->sample[k] = i % 5;
        p->key_lo[k] = rtk_mix(seed);
        p->key_hi[k] = rtk_mix(seed + 1);
        p->eta[k] = 1.0f;
        p->pdf[k] = i % 4 ? kit_range(&seed, 0, 1) : -1.0f;
        p->width[k] = kit_range(&seed, 0, 0.1f);
        p->spread[k] = kit_range(&seed, 0, 0.01f);
        w->batch.home[i / RTK_BLOCK].home[k] = i % 4096;
    }
    rti_tracer_find(RTI_ISA_GENERIC, "brute")->intersect(scene, w->batch.trace, w->hits, count, 0, &w->scratch);
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

#endif
