/* Embree's scenes: they get the triangles that ours has, as indexed vertices, each scene that instances place once, as a scene of
 * its own, and the spheres of a generated scene. */
#include "embree.h"

#include <stdlib.h>
#include <string.h>

enum { INSTANCES_MOST = 1 << 30 }; /* a scene has no more handles */

/* ---- triangles ---- */

static uint32_t hash_of(const float p[3])
{
    uint32_t bits[3], h = 0x811c9dc5u;
    memcpy(bits, p, sizeof bits);
    for (int i = 0; i < 3; i++)
        h = (h ^ bits[i]) * 0x9e3779b1u;
    return h ^ h >> 15;
}

/* The index of a vertex of these bits: one that is there, or a new one. */
static uint32_t vertex_of(embree_mesh *m, uint32_t *table, uint32_t mask, rt_vec3 v)
{
    float p[3] = {v.x, v.y, v.z};
    uint32_t at = hash_of(p) & mask;
    while (table[at] != 0 && memcmp(m->vertices + 3 * (size_t)(table[at] - 1), p, sizeof p) != 0)
        at = (at + 1) & mask;
    if (table[at] == 0) {
        memcpy(m->vertices + 3 * (size_t)m->vertex_count, p, sizeof p);
        table[at] = ++m->vertex_count;
    }
    return table[at] - 1;
}

static bool take_triangles(embree_mesh *m)
{
    uint32_t n = m->triangle_count, room = 1, *table;
    while (room < 6 * (uint64_t)n && room < 1u << 31)
        room *= 2;
    m->triangles = malloc(((size_t)n + 1) * sizeof *m->triangles);
    m->vertices = malloc(((size_t)n * 9 + 4) * sizeof *m->vertices); /* it may read 16 bytes at the last vertex */
    m->indices = malloc(((size_t)n * 3 + 1) * sizeof *m->indices);
    table = calloc(room, sizeof *table);
    bool ok = m->triangles && m->vertices && m->indices && table;
    if (ok) {
        rt_scene_get_triangles(m->scene, 0, m->triangles, n);
        for (uint32_t i = 0; i < n; i++) {
            m->indices[3 * (size_t)i] = vertex_of(m, table, room - 1, m->triangles[i].v0);
            m->indices[3 * (size_t)i + 1] = vertex_of(m, table, room - 1, m->triangles[i].v1);
            m->indices[3 * (size_t)i + 2] = vertex_of(m, table, room - 1, m->triangles[i].v2);
        }
    }
    free(table);
    return ok;
}

/* ---- what is taken of a scene ---- */

static int no_memory(void)
{
    return bench_fail(BENCH_MACHINE, "no memory for Embree's copy of the triangles");
}

static int add_mesh(embree_geometry *g, const bench_world *w, const rt_scene *scene, uint64_t triangles)
{
    if (triangles > UINT32_MAX / 6)
        return bench_fail(BENCH_FILE, "--against embree: %s holds %llu triangles in one scene; Embree gets at most %u", w->name,
                          (unsigned long long)triangles, UINT32_MAX / 6);
    if (g->mesh_count == g->mesh_room) {
        uint32_t room = g->mesh_room ? 2 * g->mesh_room : 8;
        embree_mesh *meshes = realloc(g->meshes, room * sizeof *meshes);
        if (!meshes)
            return no_memory();
        g->meshes = meshes;
        g->mesh_room = room;
    }
    g->meshes[g->mesh_count] = (embree_mesh){.scene = scene, .triangle_count = (uint32_t)triangles};
    return take_triangles(&g->meshes[g->mesh_count++]) ? BENCH_OK : no_memory();
}

/* The mesh of a scene that is placed, the last one first: descriptions place one often, then the next. */
static int mesh_of(embree_geometry *g, const bench_world *w, const rt_scene *child, uint64_t triangles, uint32_t *mesh)
{
    for (*mesh = g->mesh_count - 1; *mesh > 0; --*mesh)
        if (g->meshes[*mesh].scene == child)
            return BENCH_OK;
    *mesh = g->mesh_count;
    return add_mesh(g, w, child, triangles);
}

/* Handles count from 0, removed ones among them; `count` is of the instances that hold something. */
static int take_places(embree_geometry *g, const bench_world *w, uint64_t count)
{
    int status = BENCH_OK;
    uint64_t found = 0;
    g->places = calloc((size_t)count, sizeof *g->places);
    if (!g->places)
        return no_memory();
    for (uint32_t id = 0; found < count && id < INSTANCES_MOST && status == BENCH_OK; id++) {
        rt_instance_desc d = rt_instance_desc_default();
        rt_status told = rt_scene_get_instance(w->scene, (rt_instance){id}, &d);
        if (told == RT_ERROR_STATE)
            return bench_fail(
                BENCH_FILE,
                "--against embree: %s is a snapshot with instances, which does not tell them; give the scene's script", w->name);
        uint64_t triangles = told == RT_OK ? rt_scene_get_triangles(d.child, 0, NULL, 0) : 0;
        if (triangles == 0)
            continue;
        found++;
        if (d.motion_count > 0)
            return bench_fail(BENCH_FILE,
                              "--against embree: %s holds an instance that moves (%u); Embree gets those that stand still",
                              w->name, id);
        if (d.mask == 0) /* no ray meets it */
            continue;
        embree_place *place = &g->places[g->place_count];
        *place = (embree_place){.to_world = d.transform, .inst_id = id};
        status = mesh_of(g, w, d.child, triangles, &place->mesh);
        g->place_count++;
    }
    return status;
}

int bench_embree_geometry_take(embree_geometry *g, const bench_world *w)
{
    rt_scene_info info;
    if (rt_scene_get_info(w->scene, &info) != RT_OK)
        return bench_fail(BENCH_FILE, "--against embree: %s cannot be asked what it holds", w->name);
    g->balls = w->balls;
    g->ball_count = w->ball_count;
    if (info.shapes + info.planes > g->ball_count)
        return bench_fail(BENCH_FILE,
                          "--against embree: %s holds more than triangles (shapes: %llu, planes: %llu); Embree gets "
                          "triangles alone, the scene's own and those of instances",
                          w->name, (unsigned long long)info.shapes, (unsigned long long)info.planes);
    int status = add_mesh(g, w, w->scene, w->triangles);
    if (status == BENCH_OK && info.instances > 0)
        status = take_places(g, w, info.instances);
    if (status != BENCH_OK)
        return status;
    g->children = calloc(g->mesh_count, sizeof *g->children);
    return g->children ? BENCH_OK : no_memory();
}

void bench_embree_geometry_free(embree_geometry *g)
{
    for (uint32_t i = 0; i < g->mesh_count; i++) {
        free(g->meshes[i].vertices);
        free(g->meshes[i].indices);
        free(g->meshes[i].triangles);
    }
    free(g->meshes);
    free(g->children);
    free(g->places);
    memset(g, 0, sizeof *g);
}

/* ---- Embree's scenes ---- */

static void attach(const bench_embree *e, RTCScene scene, RTCGeometry geometry, uint32_t id)
{
    e->rtcCommitGeometry(geometry);
    e->rtcAttachGeometryByID(scene, geometry, id);
    e->rtcReleaseGeometry(geometry);
}

static void attach_mesh(const bench_embree *e, RTCScene scene, const embree_mesh *m)
{
    RTCGeometry mesh = e->rtcNewGeometry(e->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    e->rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, m->vertices, 0, 3 * sizeof(float),
                                  m->vertex_count);
    e->rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, m->indices, 0, 3 * sizeof(uint32_t),
                                  m->triangle_count);
    attach(e, scene, mesh, EMBREE_OWN);
}

static void attach_balls(const bench_embree *e, RTCScene scene, const embree_geometry *g)
{
    RTCGeometry balls = e->rtcNewGeometry(e->device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
    e->rtcSetSharedGeometryBuffer(balls, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, g->balls, 0, 4 * sizeof(float),
                                  g->ball_count);
    attach(e, scene, balls, EMBREE_OWN);
}

static enum RTCBuildQuality quality_of(const char *name)
{
    return strcmp(name, "low") == 0    ? RTC_BUILD_QUALITY_LOW
           : strcmp(name, "high") == 0 ? RTC_BUILD_QUALITY_HIGH
                                       : RTC_BUILD_QUALITY_MEDIUM;
}

/* Adds the time to seconds and cpu. */
static void commit(const bench_embree *e, RTCScene scene, const char *quality, bool robust, double *seconds, double *cpu)
{
    e->rtcSetSceneFlags(scene, robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
    e->rtcSetSceneBuildQuality(scene, quality_of(quality));
    *cpu -= bench_cpu_process();
    *seconds -= bench_wall();
    e->rtcCommitScene(scene);
    *seconds += bench_wall();
    *cpu += bench_cpu_process();
}

RTCScene bench_embree_scene(const bench_embree *e, const char *quality, bool robust, double *seconds, double *cpu)
{
    const embree_geometry *g = &e->geometry;
    RTCScene scene = e->rtcNewScene(e->device);
    *seconds = *cpu = 0;
    if (g->meshes[0].triangle_count > 0)
        attach_mesh(e, scene, &g->meshes[0]);
    if (g->ball_count > 0)
        attach_balls(e, scene, g);
    for (uint32_t i = 1; i < g->mesh_count; i++) {
        g->children[i] = e->rtcNewScene(e->device);
        attach_mesh(e, g->children[i], &g->meshes[i]);
        commit(e, g->children[i], quality, robust, seconds, cpu);
    }
    for (uint32_t i = 0; i < g->place_count; i++) {
        RTCGeometry instance = e->rtcNewGeometry(e->device, RTC_GEOMETRY_TYPE_INSTANCE);
        e->rtcSetGeometryInstancedScene(instance, g->children[g->places[i].mesh]);
        e->rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, g->places[i].to_world.m);
        attach(e, scene, instance, EMBREE_FIRST_PLACE + i);
    }
    commit(e, scene, quality, robust, seconds, cpu);
    for (uint32_t i = 1; i < g->mesh_count; i++)
        e->rtcReleaseScene(g->children[i]); /* the instances hold it */
    return scene;
}
