/* Adding meshes and polyhedra. */
#include "scene.h"

#include <string.h>

#include "polygon.h"

#define NORMAL_MAX 1.0e18f /* of a component: its square is a float */

rt_mesh_desc rt_mesh_desc_default(void)
{
    rt_mesh_desc d;
    memset(&d, 0, sizeof d);
    d.struct_size = sizeof d;
    d.common = rti_common_default();
    return d;
}

rt_polyhedron_desc rt_polyhedron_desc_default(void)
{
    rt_polyhedron_desc d;
    memset(&d, 0, sizeof d);
    d.struct_size = sizeof d;
    d.common = rti_common_default();
    return d;
}

static rt_status check_null(rt_context *ctx, const char *call, const char *field, const void *pointer, const char *count_field,
                            size_t count)
{
    if (pointer || count == 0)
        return RT_OK;
    return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: %s is NULL, but %s is %zu", call, field, count_field, count);
}

static rt_status check_indices(rt_context *ctx, const char *call, const uint32_t *indices, size_t count, uint32_t vertex_count)
{
    for (size_t i = 0; i < count; i++) {
        if (indices[i] >= vertex_count)
            return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: indices[%zu] is %u; it must be below vertex_count, which is %u", call, i,
                            indices[i], vertex_count);
    }
    return RT_OK;
}

static rt_status check_mesh(rt_context *ctx, const char *call, const rt_mesh_desc *d)
{
    rt_status status = check_null(ctx, call, "positions", d->positions, "vertex_count", d->vertex_count);
    if (status == RT_OK)
        status = check_null(ctx, call, "indices", d->indices, "triangle_count", d->triangle_count);
    if (status == RT_OK && d->triangle_count > RTI_MAX_PRIMS)
        status = rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: triangle_count is %u; it must be at most %u", call, d->triangle_count,
                          RTI_MAX_PRIMS);
    if (status == RT_OK)
        status = rti_check_floats(ctx, call, "positions", d->positions, d->vertex_count, 3, RTI_COORD_MAX);
    if (status == RT_OK)
        status = check_indices(ctx, call, d->indices, 3 * (size_t)d->triangle_count, d->vertex_count);
    if (status == RT_OK && d->normals)
        status = rti_check_floats(ctx, call, "normals", d->normals, d->vertex_count, 3, NORMAL_MAX);
    if (status == RT_OK && d->uvs)
        status = rti_check_floats(ctx, call, "uvs", d->uvs, d->vertex_count, 2, 1.0e9f);
    if (status == RT_OK && d->colors)
        status = rti_check_floats(ctx, call, "colors", d->colors, d->vertex_count, 3, 1.0e6f);
    return status;
}

rt_status rti_mesh_add(rt_scene *scene, const char *call, const rt_geometry_common *common, rti_mesh *mesh,
                       uint32_t triangle_count, rt_geometry *geometry)
{
    rti_geometry *g;
    rt_status status = rti_geometry_push(scene, call, common, RTK_GEOM_MESH, triangle_count, &g);
    if (status != RT_OK) {
        rti_mesh_free(scene->ctx, mesh);
        return status;
    }
    g->mesh = mesh;
    scene->tri_count += triangle_count;
    if (geometry)
        geometry->id = (uint32_t)(scene->geometries.count - 1);
    return RT_OK;
}

static void copy(void *to, const void *from, size_t count, size_t item)
{
    if (to && from)
        memcpy(to, from, count * item);
}

rt_status rti_mesh_of(rt_context *ctx, const char *call, const rt_mesh_desc *d, rti_mesh **out)
{
    rti_mesh *mesh;
    rti_mesh_want want = {.vertices = d->vertex_count,
                          .triangles = d->triangle_count,
                          .normals = d->normals != NULL,
                          .uvs = d->uvs != NULL,
                          .colors = d->colors ? d->vertex_count : 0,
                          .materials = d->face_materials ? d->triangle_count : 0};
    rt_status status = check_mesh(ctx, call, d);
    if (status == RT_OK)
        status = rti_mesh_make(ctx, call, &want, &mesh);
    if (status != RT_OK)
        return status;
    copy(mesh->positions, d->positions, d->vertex_count, 3 * sizeof(float));
    copy(mesh->indices, d->indices, d->triangle_count, 3 * sizeof(uint32_t));
    copy(mesh->normals, d->normals, d->vertex_count, 3 * sizeof(float));
    copy(mesh->uvs, d->uvs, d->vertex_count, 2 * sizeof(float));
    copy(mesh->colors, d->colors, d->vertex_count, 3 * sizeof(float));
    copy(mesh->materials, d->face_materials, d->triangle_count, sizeof(uint32_t));
    *out = mesh;
    return RT_OK;
}

rt_status rt_scene_add_mesh(rt_scene *scene, const rt_mesh_desc *desc, rt_geometry *geometry)
{
    static const char call[] = "rt_scene_add_mesh";
    rt_mesh_desc d = rt_mesh_desc_default();
    rti_mesh *mesh;
    rt_status status = rti_add_begin(scene, call, desc, &d, sizeof d, &d.common);
    if (status == RT_OK && d.face_materials)
        status = rti_check_materials(scene, call, "face_materials", d.face_materials, d.triangle_count);
    if (status == RT_OK)
        status = rti_mesh_of(scene->ctx, call, &d, &mesh);
    return status == RT_OK ? rti_mesh_add(scene, call, &d.common, mesh, d.triangle_count, geometry) : status;
}

/* ---- a mesh's vertices anew ---- */

/* The geometry, which must be a mesh of a scene that can be edited. */
static rt_status edit_mesh(rt_scene *scene, const char *call, rt_geometry geometry, rti_geometry **out)
{
    rt_status status = rti_geometry_edit(scene, call, geometry, out);
    if (status == RT_OK && (*out)->type != RTK_GEOM_MESH)
        status = rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: geometry %u is no mesh and no polyhedron; only these have vertices",
                          call, geometry.id);
    return status;
}

static rt_status check_moved(rt_context *ctx, const char *call, const rti_mesh *mesh, const float *positions,
                             const float *normals, uint32_t count)
{
    rt_status status;
    if (count != mesh->vertex_count)
        return rti_fail(ctx, RT_ERROR_ARGUMENT,
                        "%s: vertex_count is %u, but the mesh has %u vertices; a mesh with other triangles is added anew", call,
                        count, mesh->vertex_count);
    status = check_null(ctx, call, "positions", positions, "vertex_count", count);
    if (status == RT_OK)
        status = rti_check_floats(ctx, call, "positions", positions, count, 3, RTI_COORD_MAX);
    if (status == RT_OK && normals)
        status = rti_check_floats(ctx, call, "normals", normals, count, 3, NORMAL_MAX);
    return status;
}

/* The mesh again, with room for normals or without, for a geometry that must not share it. */
static rt_status copy_mesh(rt_context *ctx, const char *call, const rti_mesh *m, uint32_t triangles, bool normals, rti_mesh **out)
{
    rti_mesh_want want = {.vertices = m->vertex_count,
                          .triangles = triangles,
                          .normals = normals,
                          .uvs = m->uvs != NULL,
                          .colors = m->colors ? m->vertex_count : 0,
                          .materials = m->materials ? triangles : 0,
                          .faces = m->faces ? triangles : 0};
    rt_status status = rti_mesh_make(ctx, call, &want, out);
    if (status != RT_OK)
        return status;
    copy((*out)->positions, m->positions, m->vertex_count, 3 * sizeof(float));
    copy((*out)->normals, m->normals, m->vertex_count, 3 * sizeof(float));
    copy((*out)->uvs, m->uvs, m->vertex_count, 2 * sizeof(float));
    copy((*out)->colors, m->colors, m->vertex_count, 3 * sizeof(float));
    copy((*out)->indices, m->indices, triangles, 3 * sizeof(uint32_t));
    copy((*out)->materials, m->materials, triangles, sizeof(uint32_t));
    copy((*out)->faces, m->faces, triangles, sizeof(uint32_t));
    return RT_OK;
}

/* Makes the geometry's mesh its own, with normals where they are wanted: what several share is never changed. */
static rt_status own_mesh(rt_scene *scene, const char *call, rti_geometry *g, bool normals)
{
    rti_mesh *mesh;
    rt_status status;
    if (atomic_load_explicit(&g->mesh->refs, memory_order_acquire) == 1 && (g->mesh->normals || !normals))
        return RT_OK;
    status = copy_mesh(scene->ctx, call, g->mesh, g->count, normals || g->mesh->normals, &mesh);
    if (status != RT_OK)
        return status;
    rti_mesh_free(scene->ctx, g->mesh);
    g->mesh = mesh;
    return RT_OK;
}

rt_status rt_scene_set_mesh_positions(rt_scene *scene, rt_geometry geometry, const float *positions, const float *normals,
                                      uint32_t vertex_count)
{
    static const char call[] = "rt_scene_set_mesh_positions";
    rti_geometry *g;
    rt_status status = edit_mesh(scene, call, geometry, &g);
    if (status == RT_OK)
        status = check_moved(scene->ctx, call, g->mesh, positions, normals, vertex_count);
    if (status == RT_OK)
        status = own_mesh(scene, call, g, normals != NULL);
    if (status != RT_OK)
        return status;
    copy(g->mesh->positions, positions, vertex_count, 3 * sizeof(float));
    copy(g->mesh->normals, normals, vertex_count, 3 * sizeof(float));
    scene->geometry_changed = true;
    return RT_OK;
}

/* The sum of the normals of a vertex's triangles, each as long as twice the triangle's area. One that floats do not hold becomes
 * zero, which means the face's. */
static void sum_normals(rti_mesh *m, uint32_t triangles)
{
    const size_t count = 3 * (size_t)m->vertex_count;
    for (size_t i = 0; i < count; i++)
        m->normals[i] = 0.0f;
    for (size_t f = 0; f < triangles; f++) {
        const uint32_t *i = m->indices + 3 * f;
        const float *p = m->positions + 3 * (size_t)i[0], *q = m->positions + 3 * (size_t)i[1],
                    *r = m->positions + 3 * (size_t)i[2];
        const rtk_vec3 a = {q[0] - p[0], q[1] - p[1], q[2] - p[2]}, b = {r[0] - p[0], r[1] - p[1], r[2] - p[2]};
        const rtk_vec3 n = rtk_cross3(a, b);
        for (int k = 0; k < 3; k++) {
            float *to = m->normals + 3 * (size_t)i[k];
            to[0] += n.x;
            to[1] += n.y;
            to[2] += n.z;
        }
    }
    for (size_t i = 0; i < count; i += 3) {
        float *n = m->normals + i;
        if (!(rtk_fabs(n[0]) + rtk_fabs(n[1]) + rtk_fabs(n[2]) <= NORMAL_MAX))
            n[0] = n[1] = n[2] = 0.0f;
    }
}

rt_status rt_scene_smooth_mesh(rt_scene *scene, rt_geometry geometry)
{
    static const char call[] = "rt_scene_smooth_mesh";
    rti_geometry *g;
    rti_fpenv env;
    rt_status status = edit_mesh(scene, call, geometry, &g);
    if (status == RT_OK)
        status = own_mesh(scene, call, g, true);
    if (status != RT_OK)
        return status;
    env = rti_fp_enter();
    sum_normals(g->mesh, g->count);
    rti_fp_leave(env);
    scene->geometry_changed = true;
    return RT_OK;
}

/* ---- polyhedra ---- */

/* Also counts the triangles and finds the largest face. */
static rt_status check_polyhedron(const rt_scene *scene, const char *call, const rt_polyhedron_desc *d, uint32_t *triangles,
                                  uint32_t *largest)
{
    rt_context *ctx = scene->ctx;
    uint64_t corners = 0;
    rt_status status = check_null(ctx, call, "positions", d->positions, "vertex_count", d->vertex_count);
    if (status == RT_OK)
        status = check_null(ctx, call, "face_sizes", d->face_sizes, "face_count", d->face_count);
    if (status == RT_OK)
        status = check_null(ctx, call, "indices", d->indices, "index_count", d->index_count);
    if (status != RT_OK)
        return status;
    *largest = 0;
    for (uint32_t f = 0; f < d->face_count; f++) {
        uint32_t n = d->face_sizes[f];
        if (n < 3 || n > 65535)
            return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: face_sizes[%u] is %u; a face has from 3 to 65535 corners", call, f, n);
        corners += n;
        *largest = n > *largest ? n : *largest;
    }
    if (corners != d->index_count)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: index_count is %zu, but the face_sizes add up to %llu", call, d->index_count,
                        (unsigned long long)corners);
    if (corners - 2ull * d->face_count > RTI_MAX_PRIMS)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: the faces make more than %u triangles", call, RTI_MAX_PRIMS);
    *triangles = (uint32_t)(corners - 2ull * d->face_count);
    status = rti_check_floats(ctx, call, "positions", d->positions, d->vertex_count, 3, RTI_COORD_MAX);
    return status == RT_OK ? check_indices(ctx, call, d->indices, d->index_count, d->vertex_count) : status;
}

static void cut_faces(const rt_polyhedron_desc *d, uint32_t *scratch, rti_mesh *mesh)
{
    const uint32_t *corners = d->indices;
    uint32_t *indices = mesh->indices, *faces = mesh->faces;
    for (uint32_t f = 0; f < d->face_count; f++) {
        uint32_t n = d->face_sizes[f];
        rti_polygon_triangulate(d->positions, corners, n, scratch, indices);
        for (uint32_t i = 0; i + 2 < n; i++)
            *faces++ = f;
        corners += n;
        indices += 3 * (size_t)(n - 2);
    }
}

rt_status rt_scene_add_polyhedron(rt_scene *scene, const rt_polyhedron_desc *desc, rt_geometry *geometry)
{
    static const char call[] = "rt_scene_add_polyhedron";
    rt_polyhedron_desc d = rt_polyhedron_desc_default();
    rti_mesh *mesh;
    rti_mesh_want want;
    uint32_t triangles = 0, largest = 0, *scratch;
    rti_fpenv env;
    rt_status status = rti_add_begin(scene, call, desc, &d, sizeof d, &d.common);
    if (status == RT_OK)
        status = check_polyhedron(scene, call, &d, &triangles, &largest);
    if (status != RT_OK)
        return status;
    want = (rti_mesh_want){.vertices = d.vertex_count, .triangles = triangles, .faces = triangles};
    status = rti_mesh_make(scene->ctx, call, &want, &mesh);
    if (status != RT_OK)
        return status;
    scratch = rti_alloc_array(scene->ctx, largest, RTI_POLYGON_SCRATCH * sizeof *scratch);
    if (!scratch) {
        rti_mesh_free(scene->ctx, mesh);
        return rti_fail_memory(scene->ctx, call, RTI_POLYGON_SCRATCH * sizeof *scratch * largest);
    }
    copy(mesh->positions, d.positions, d.vertex_count, 3 * sizeof(float));
    env = rti_fp_enter();
    cut_faces(&d, scratch, mesh);
    rti_fp_leave(env);
    rti_free(scene->ctx, scratch, RTI_POLYGON_SCRATCH * sizeof *scratch * largest);
    return rti_mesh_add(scene, call, &d.common, mesh, triangles, geometry);
}
