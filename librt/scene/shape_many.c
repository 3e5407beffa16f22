/* Adding many shapes of one kind as one geometry: spheres, cylinders, cones. */
#include "scene.h"

#include <stdio.h>
#include <string.h>

/* What each kind has beside its places and sizes. */
typedef struct many_looks {
    uint32_t count;
    const float *colors;
    const uint32_t *materials;
} many_looks;

/* `what` is an array that must be there: its elements are counted. */
static rt_status check_count(rt_context *ctx, const char *call, const char *what, const float *array, uint32_t count)
{
    if (count > 0 && !array)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: %s is NULL, but count is %u", call, what, count);
    if (count > RTI_MAX_PRIMS)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: count is %u; it must be at most %u", call, count, RTI_MAX_PRIMS);
    return rti_check_floats(ctx, call, what, array, count, 3, RTI_COORD_MAX);
}

/* Radii, one a shape, or NULL: `radius` for all of them. Each above 0, or from 0 on. */
static rt_status check_radii(rt_context *ctx, const char *call, const char *what, const float *radii, uint32_t count,
                             const char *one, float radius, bool positive)
{
    for (uint32_t i = 0; i < (radii ? count : 1u); i++) {
        const float r = radii ? radii[i] : radius;
        char field[32];
        if (r <= RTI_COORD_MAX && (positive ? r > 0.0f : r >= 0.0f))
            continue;
        snprintf(field, sizeof field, radii ? "%s[%u]" : "%s", radii ? what : one, i);
        return positive ? rti_check_positive(ctx, call, field, r) : rti_check_range(ctx, call, field, r, 0.0f, RTI_COORD_MAX);
    }
    return RT_OK;
}

static rt_status check_looks(const rt_scene *scene, const char *call, const many_looks *l)
{
    rt_status status = RT_OK;
    if (l->colors)
        status = rti_check_floats(scene->ctx, call, "colors", l->colors, l->count, 3, 1.0e6f);
    if (status == RT_OK && l->materials)
        status = rti_check_materials(scene, call, "face_materials", l->materials, l->count);
    return status;
}

/* Room for the shapes of a new geometry, which has these looks, all or nothing. */
static rt_status push_many(rt_scene *scene, const char *call, const rt_geometry_common *common, const many_looks *l,
                           rtk_shape **shapes, rt_geometry *geometry)
{
    rti_geometry *g = NULL;
    rti_mesh *mesh = NULL;
    rt_status status = RT_OK;
    if (l->colors || l->materials) {
        rti_mesh_want want = {.colors = l->colors ? l->count : 0, .materials = l->materials ? l->count : 0};
        status = rti_mesh_make(scene->ctx, call, &want, &mesh);
    }
    if (status == RT_OK)
        status = rti_shapes_push(scene, call, common, l->count, &g, shapes);
    if (status != RT_OK) {
        rti_mesh_free(scene->ctx, mesh);
        return status;
    }
    if (mesh && mesh->colors)
        memcpy(mesh->colors, l->colors, 3 * sizeof(float) * l->count);
    if (mesh && mesh->materials)
        memcpy(mesh->materials, l->materials, sizeof(uint32_t) * l->count);
    g->mesh = mesh;
    rti_geometry_give(scene, geometry);
    return RT_OK;
}

rt_spheres_desc rt_spheres_desc_default(void)
{
    rt_spheres_desc d;
    memset(&d, 0, sizeof d);
    d.struct_size = sizeof d;
    d.common = rti_common_default();
    d.radius = 1.0f;
    return d;
}

rt_status rt_scene_add_spheres(rt_scene *scene, const rt_spheres_desc *desc, rt_geometry *geometry)
{
    static const char call[] = "rt_scene_add_spheres";
    rt_spheres_desc d = rt_spheres_desc_default();
    rtk_shape *shapes = NULL;
    many_looks looks;
    rt_status status = rti_add_begin(scene, call, desc, &d, sizeof d, &d.common);
    looks = (many_looks){d.count, d.colors, d.face_materials};
    if (status == RT_OK)
        status = check_count(scene->ctx, call, "centers", d.centers, d.count);
    if (status == RT_OK)
        status = check_radii(scene->ctx, call, "radii", d.radii, d.count, "radius", d.radius, true);
    if (status == RT_OK)
        status = check_looks(scene, call, &looks);
    if (status == RT_OK)
        status = push_many(scene, call, &d.common, &looks, &shapes, geometry);
    for (uint32_t i = 0; status == RT_OK && i < d.count; i++) {
        shapes[i].type = RTK_SHAPE_SPHERE;
        memcpy(shapes[i].p, d.centers + 3 * (size_t)i, 3 * sizeof(float));
        shapes[i].p[3] = d.radii ? d.radii[i] : d.radius;
        shapes[i].prim = i;
    }
    return status;
}

rt_cones_desc rt_cones_desc_default(void)
{
    rt_cones_desc d;
    memset(&d, 0, sizeof d);
    d.struct_size = sizeof d;
    d.common = rti_common_default();
    d.radius = 1.0f;
    return d;
}

/* Cylinders and cones, each between two points that differ; of a cone not both radii are 0. Cylinders have but one. */
static rt_status check_cones(const rt_scene *scene, const char *call, const rt_cones_desc *d, bool pointed)
{
    rt_context *ctx = scene->ctx;
    rt_status status = check_count(ctx, call, "from", d->from, d->count);
    if (status == RT_OK)
        status = check_count(ctx, call, "to", d->to, d->count);
    if (status == RT_OK)
        status = check_radii(ctx, call, "radii", d->radii, d->count, "radius", d->radius, !pointed);
    if (status == RT_OK && pointed)
        status = check_radii(ctx, call, "to_radii", d->to_radii, d->count, "to_radius", d->to_radius, false);
    for (uint32_t i = 0; status == RT_OK && i < d->count; i++) {
        const float *a = d->from + 3 * (size_t)i, *b = d->to + 3 * (size_t)i;
        if (a[0] == b[0] && a[1] == b[1] && a[2] == b[2])
            status = rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: from[%u] and to[%u] are the same point; they must differ", call, i, i);
        else if (pointed && (d->radii ? d->radii[i] : d->radius) == 0.0f && (d->to_radii ? d->to_radii[i] : d->to_radius) == 0.0f)
            status = rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: cone [%u] has radius 0 at both ends; one must be greater", call, i);
    }
    return status;
}

static rt_status add_cones(rt_scene *scene, const char *call, const rt_cones_desc *desc, uint32_t type, rt_geometry *geometry)
{
    const bool pointed = type == RTK_SHAPE_CONE;
    rt_cones_desc d = rt_cones_desc_default();
    rtk_shape *shapes = NULL;
    many_looks looks;
    rt_status status = rti_add_begin(scene, call, desc, &d, sizeof d, &d.common);
    looks = (many_looks){d.count, d.colors, d.face_materials};
    if (status == RT_OK)
        status = check_cones(scene, call, &d, pointed);
    if (status == RT_OK)
        status = check_looks(scene, call, &looks);
    if (status == RT_OK)
        status = push_many(scene, call, &d.common, &looks, &shapes, geometry);
    for (uint32_t i = 0; status == RT_OK && i < d.count; i++) {
        float *p = shapes[i].p;
        shapes[i].type = type;
        shapes[i].prim = i;
        memcpy(p, d.from + 3 * (size_t)i, 3 * sizeof(float));
        p[3] = d.radii ? d.radii[i] : d.radius;
        memcpy(p + 4, d.to + 3 * (size_t)i, 3 * sizeof(float));
        if (pointed)
            p[7] = d.to_radii ? d.to_radii[i] : d.to_radius;
    }
    return status;
}

rt_status rt_scene_add_cylinders(rt_scene *scene, const rt_cones_desc *desc, rt_geometry *geometry)
{
    return add_cones(scene, "rt_scene_add_cylinders", desc, RTK_SHAPE_CYLINDER, geometry);
}

rt_status rt_scene_add_cones(rt_scene *scene, const rt_cones_desc *desc, rt_geometry *geometry)
{
    return add_cones(scene, "rt_scene_add_cones", desc, RTK_SHAPE_CONE, geometry);
}
