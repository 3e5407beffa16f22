/* Geometries: the table, what all kinds share, removal. */
#include "scene.h"

#include <string.h>

rt_geometry_common rti_common_default(void)
{
    rt_geometry_common c;
    memset(&c, 0, sizeof c);
    c.mask = RT_MASK_ALL;
    c.uv_transform[0] = 1.0f;
    c.uv_transform[4] = 1.0f;
    return c;
}

rt_status rti_geometry_push(rt_scene *scene, const char *call, const rt_geometry_common *common, uint8_t type, uint32_t count,
                            rti_geometry **geometry)
{
    rti_geometry *g;
    if (scene->geometries.count >= RTI_MAX_PRIMS || scene->tri_count + scene->shape_count + count > RTI_MAX_PRIMS)
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT,
                        "%s: the scene would pass %u primitives or geometries; split it into instanced scenes", call,
                        RTI_MAX_PRIMS);
    g = rti_array_push(scene->ctx, &scene->geometries, sizeof *g);
    if (!g)
        return rti_array_refused(scene->ctx, call, &scene->geometries, 1, sizeof *g);
    g->type = type;
    g->alive = 1;
    g->material = common->material.id;
    g->mask = common->mask;
    g->user_id = common->user_id;
    memcpy(g->uv_xfm, common->uv_transform, sizeof g->uv_xfm);
    g->count = count;
    scene->geometry_changed = scene->primitives_changed = true;
    *geometry = g;
    return RT_OK;
}

/* Offsets of a mesh's arrays in its one block. */
typedef struct mesh_plan {
    size_t header;
    uint64_t positions, indices, normals, uvs, colors, materials, faces;
    rti_layout layout;
} mesh_plan;

static mesh_plan plan_mesh(const rti_mesh_want *want)
{
    mesh_plan p;
    rti_layout_begin(&p.layout, sizeof(rti_mesh));
    p.positions = rti_layout_add(&p.layout, want->vertices, 3 * sizeof(float));
    p.indices = rti_layout_add(&p.layout, want->triangles, 3 * sizeof(uint32_t));
    p.normals = rti_layout_add(&p.layout, want->normals ? want->vertices : 0, 3 * sizeof(float));
    p.uvs = rti_layout_add(&p.layout, want->uvs ? want->vertices : 0, 2 * sizeof(float));
    p.colors = rti_layout_add(&p.layout, want->colors, 3 * sizeof(float));
    p.materials = rti_layout_add(&p.layout, want->materials, sizeof(uint32_t));
    p.faces = rti_layout_add(&p.layout, want->faces, sizeof(uint32_t));
    return p;
}

rt_status rti_mesh_make(rt_context *ctx, const char *call, const rti_mesh_want *want, rti_mesh **out)
{
    mesh_plan p = plan_mesh(want);
    uint8_t *block = p.layout.overflow ? NULL : rti_alloc(ctx, p.layout.size);
    rti_mesh *mesh = (rti_mesh *)(void *)block;
    if (!mesh)
        return rti_fail_memory(ctx, call, p.layout.size);
    memset(mesh, 0, sizeof *mesh);
    atomic_init(&mesh->refs, 1);
    mesh->size = p.layout.size;
    mesh->vertex_count = want->vertices;
    mesh->positions = p.positions ? (float *)(void *)(block + p.positions) : NULL;
    mesh->indices = p.indices ? (uint32_t *)(void *)(block + p.indices) : NULL;
    mesh->normals = p.normals ? (float *)(void *)(block + p.normals) : NULL;
    mesh->uvs = p.uvs ? (float *)(void *)(block + p.uvs) : NULL;
    mesh->colors = p.colors ? (float *)(void *)(block + p.colors) : NULL;
    mesh->materials = p.materials ? (uint32_t *)(void *)(block + p.materials) : NULL;
    mesh->faces = p.faces ? (uint32_t *)(void *)(block + p.faces) : NULL;
    *out = mesh;
    return RT_OK;
}

void rti_mesh_free(rt_context *ctx, rti_mesh *mesh)
{
    if (mesh && atomic_fetch_sub_explicit(&mesh->refs, 1, memory_order_acq_rel) == 1)
        rti_free(ctx, mesh, mesh->size);
}

rt_status rti_geometry_edit(rt_scene *scene, const char *call, rt_geometry geometry, rti_geometry **out)
{
    rt_status status = rti_scene_editable(scene, call);
    if (status == RT_OK && !(*out = rti_geometry_at(scene, call, geometry.id)))
        status = RT_ERROR_ARGUMENT;
    return status;
}

rt_status rt_scene_set_geometry_material(rt_scene *scene, rt_geometry geometry, rt_material material)
{
    static const char call[] = "rt_scene_set_geometry_material";
    rti_geometry *g;
    rt_status status = rti_geometry_edit(scene, call, geometry, &g);
    if (status == RT_OK)
        status = rti_check_material(scene, call, "material", material.id);
    if (status != RT_OK)
        return status;
    g->material = material.id;
    return RT_OK;
}

rt_status rt_scene_set_geometry_mask(rt_scene *scene, rt_geometry geometry, uint32_t mask)
{
    static const char call[] = "rt_scene_set_geometry_mask";
    rti_geometry *g;
    rt_status status = rti_geometry_edit(scene, call, geometry, &g);
    if (status != RT_OK)
        return status;
    g->mask = mask;
    return RT_OK;
}

/* The record stays, empty, so that later handles keep their numbers. */
rt_status rt_scene_remove_geometry(rt_scene *scene, rt_geometry geometry)
{
    static const char call[] = "rt_scene_remove_geometry";
    rti_geometry *g;
    rt_status status = rti_geometry_edit(scene, call, geometry, &g);
    if (status != RT_OK)
        return status;
    if (g->type == RTK_GEOM_MESH)
        scene->tri_count -= g->count;
    else if (g->type == RTK_GEOM_SHAPES)
        scene->shape_count -= g->count;
    rti_mesh_free(scene->ctx, g->mesh);
    g->mesh = NULL;
    g->count = 0;
    g->alive = 0;
    scene->geometry_changed = scene->primitives_changed = true;
    return RT_OK;
}
