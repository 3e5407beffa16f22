/* Commit: the geometry of the scene itself, and the records of all groups. */
#include "parts.h"

#include <string.h>

rt_status rti_commit_chunk(rti_commit *c, uint32_t kind, void *data, size_t size, rti_chunk **chunk)
{
    bool shared;
    if (rti_cancelled(&c->scene->cancel)) {
        rti_free(c->scene->ctx, data, size);
        return rti_fail(c->scene->ctx, RT_ERROR_CANCELLED, "%s: cancelled", c->call);
    }
    *chunk = rti_chunk_share(c->scene->ctx, kind, data, size, NULL, &shared);
    if (!*chunk)
        return rti_fail_memory(c->scene->ctx, c->call, size);
    c->next->reused_chunks += shared;
    return RT_OK;
}

static void *chunk_block(rti_commit *c, const rti_layout *layout, rt_status *status)
{
    void *data = layout->overflow ? NULL : rti_alloc_zero(c->scene->ctx, layout->size);
    *status = data ? RT_OK : rti_fail_memory(c->scene->ctx, c->call, layout->size);
    return data;
}

static const rti_geometry *geometry_at(const rt_scene *scene, size_t i)
{
    return RTI_AT(scene->geometries, rti_geometry, i);
}

/* ---- GROUP ---- */

#define TRIS_A_TASK 65536u

typedef struct mesh_job {
    const rti_geometry *geometry;
    uint32_t geom;
    rtk_tri *tris;
} mesh_job;

static void mesh_task(void *data, uint32_t task)
{
    const mesh_job *job = data;
    const float *p = job->geometry->mesh->positions;
    uint32_t first = task * TRIS_A_TASK, left = job->geometry->count - first;
    const uint32_t *index = job->geometry->mesh->indices + 3 * (size_t)first;
    rtk_tri *tri = job->tris + first;
    for (uint32_t i = 0; i < left && i < TRIS_A_TASK; i++, index += 3, tri++) {
        memcpy(tri->v0, p + 3 * (size_t)index[0], sizeof tri->v0);
        memcpy(tri->v1, p + 3 * (size_t)index[1], sizeof tri->v1);
        memcpy(tri->v2, p + 3 * (size_t)index[2], sizeof tri->v2);
        tri->geom = job->geom;
        tri->prim = first + i;
    }
}

/* Returns where the next mesh's triangles go. */
static rtk_tri *put_mesh(rt_context *ctx, const rti_geometry *g, uint32_t geom, rtk_tri *tris)
{
    mesh_job job = {g, geom, tris};
    if (g->count > TRIS_A_TASK)
        rti_parallel(ctx, (g->count + TRIS_A_TASK - 1) / TRIS_A_TASK, mesh_task, &job);
    else if (g->count > 0)
        mesh_task(&job, 0);
    return tris + g->count;
}

static void put_lamps(const rt_scene *scene, rtk_shape *to)
{
    uint32_t geom = (uint32_t)scene->geometries.count;
    for (size_t i = 0; i < scene->lights.count; i++) {
        const rti_light *l = RTI_AT(scene->lights, rti_light, i);
        if (!l->visible)
            continue;
        to->type = RTK_SHAPE_SPHERE;
        to->geom = geom++;
        memcpy(to->p, l->light.at, 3 * sizeof(float));
        to++->p[3] = l->light.radius;
    }
}

static uint32_t plane_count(const rt_scene *scene)
{
    uint32_t n = 0;
    for (size_t i = 0; i < scene->geometries.count; i++)
        n += geometry_at(scene, i)->type == RTK_GEOM_PLANE && geometry_at(scene, i)->alive;
    return n;
}

static void fill_group(const rt_scene *scene, rtk_group_header *head)
{
    uint8_t *base = (uint8_t *)head;
    rtk_tri *tri = (rtk_tri *)(void *)(base + head->off_tris);
    rtk_shape *shape = (rtk_shape *)(void *)(base + head->off_shapes), *plane = (rtk_shape *)(void *)(base + head->off_planes);
    for (size_t i = 0; i < scene->geometries.count; i++) {
        const rti_geometry *g = geometry_at(scene, i);
        if (!g->alive)
            continue;
        if (g->type == RTK_GEOM_MESH) {
            tri = put_mesh(scene->ctx, g, (uint32_t)i, tri);
        } else if (g->type == RTK_GEOM_PLANE) {
            *plane = RTI_AT(scene->planes, rti_plane, g->first)->shape;
            plane++->geom = (uint32_t)i;
        } else {
            if (g->count > 0) /* else the scene may have no array of shapes */
                memcpy(shape, RTI_AT(scene->shapes, rtk_shape, g->first), g->count * sizeof *shape);
            for (uint32_t k = 0; k < g->count; k++)
                shape++->geom = (uint32_t)i;
        }
    }
    put_lamps(scene, shape);
    head->part_count = head->tri_count + head->shape_count > 0;
    rti_group_measure(scene->ctx, head, head);
}

static rt_status make_group(rti_commit *c)
{
    const rt_scene *scene = c->scene;
    rtk_group_header *head, want = {.tri_count = (uint32_t)scene->tri_count,
                                    .shape_count = (uint32_t)(scene->shape_count + c->lamp_count),
                                    .plane_count = plane_count(scene)};
    rti_layout layout;
    rt_status status;
    if (scene->tri_count + scene->shape_count + c->lamp_count > RTI_MAX_PRIMS)
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: with the bodies of visible lights the scene passes %u primitives",
                        c->call, RTI_MAX_PRIMS);
    rti_layout_begin(&layout, sizeof *head);
    want.off_tris = rti_layout_add(&layout, want.tri_count, sizeof(rtk_tri));
    want.off_shapes = rti_layout_add(&layout, want.shape_count, sizeof(rtk_shape));
    want.off_planes = rti_layout_add(&layout, want.plane_count, sizeof(rtk_shape));
    head = chunk_block(c, &layout, &status);
    if (!head)
        return status;
    *head = want;
    fill_group(scene, head);
    status = rti_group_cut(c, &head, &layout);
    if (status != RT_OK) {
        rti_free(scene->ctx, head, layout.size);
        return status;
    }
    return rti_commit_chunk(c, RTK_CHUNK_GROUP, head, layout.size, &c->next->groups[0].group);
}

/* ---- ATTRIBUTE: both the offsets in the records and the copying walk the arrays in this order ---- */

void rti_plan_attributes(rti_layout *layout, const rti_geometry *g, rtk_geom *out)
{
    const rti_mesh *m = g->mesh;
    size_t vertices = g->type == RTK_GEOM_MESH && g->count > 0 ? m->vertex_count : g->count; /* no triangle, no corner */
    bool corners = m->normals || m->uvs || (m->colors && g->type == RTK_GEOM_MESH);
    out->off_indices = rti_layout_add(layout, corners ? g->count : 0, 3 * sizeof(uint32_t));
    out->off_normals = rti_layout_add(layout, m->normals ? vertices : 0, 3 * sizeof(float));
    out->off_uvs = rti_layout_add(layout, m->uvs ? vertices : 0, 2 * sizeof(float));
    out->off_colors = rti_layout_add(layout, m->colors ? vertices : 0, 3 * sizeof(float));
    out->off_materials = rti_layout_add(layout, m->materials ? g->count : 0, sizeof(uint32_t));
    out->off_faces = rti_layout_add(layout, m->faces ? g->count : 0, sizeof(uint32_t));
    out->vertex_count = (uint32_t)vertices;
}

static void copy(uint8_t *base, uint64_t offset, const void *from, size_t size)
{
    if (offset)
        memcpy(base + offset, from, size);
}

static void copy_attributes(uint8_t *base, const rti_geometry *g, const rtk_geom *at)
{
    const rti_mesh *m = g->mesh;
    copy(base, at->off_indices, m->indices, 3 * sizeof(uint32_t) * (size_t)g->count);
    copy(base, at->off_normals, m->normals, 3 * sizeof(float) * (size_t)at->vertex_count);
    copy(base, at->off_uvs, m->uvs, 2 * sizeof(float) * (size_t)at->vertex_count);
    copy(base, at->off_colors, m->colors, 3 * sizeof(float) * (size_t)at->vertex_count);
    copy(base, at->off_materials, m->materials, sizeof(uint32_t) * (size_t)g->count);
    copy(base, at->off_faces, m->faces, sizeof(uint32_t) * (size_t)g->count);
}

static rt_status make_attributes(rti_commit *c)
{
    const rt_scene *scene = c->scene;
    rti_layout layout, again;
    rtk_geom at;
    uint8_t *base;
    rt_status status;
    rti_layout_begin(&layout, RTI_ATTRIBUTE_HEADER);
    for (size_t i = 0; i < scene->geometries.count; i++) {
        if (geometry_at(scene, i)->mesh)
            rti_plan_attributes(&layout, geometry_at(scene, i), &at);
    }
    if (layout.size == RTI_ATTRIBUTE_HEADER)
        return RT_OK;
    base = chunk_block(c, &layout, &status);
    if (!base)
        return status;
    rti_layout_begin(&again, RTI_ATTRIBUTE_HEADER);
    for (size_t i = 0; i < scene->geometries.count; i++) {
        const rti_geometry *g = geometry_at(scene, i);
        if (!g->mesh)
            continue;
        rti_plan_attributes(&again, g, &at);
        copy_attributes(base, g, &at);
    }
    return rti_commit_chunk(c, RTK_CHUNK_ATTRIBUTE, base, layout.size, &c->next->groups[0].attribute);
}

rt_status rti_commit_group(rti_commit *c)
{
    rt_status status;
    if (c->last && !c->scene->geometry_changed) {
        c->next->groups[0].group = rti_chunk_retain(c->last->groups[0].group);
        c->next->groups[0].attribute = rti_chunk_retain(c->last->groups[0].attribute);
        c->next->reused_chunks += 1 + (c->next->groups[0].attribute != NULL);
        return RT_OK;
    }
    status = make_group(c);
    return status == RT_OK ? make_attributes(c) : status;
}
