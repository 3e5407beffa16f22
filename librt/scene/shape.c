/* Adding shapes one at a time: spheres, boxes, cylinders, cones, tori, planes. Many as one geometry: shape_many.c. */
#include "scene.h"

#include <math.h>
#include <string.h>

static void put(float *at, rt_vec3 p)
{
    at[0] = p.x;
    at[1] = p.y;
    at[2] = p.z;
}

static rt_vec3 unit(rt_vec3 d)
{
    rti_fpenv env = rti_fp_enter();
    RTI_FP_HOLD(d);
    double m = fmax(fmax(fabs((double)d.x), fabs((double)d.y)), fabs((double)d.z));
    double x = d.x / m, y = d.y / m, z = d.z / m, l = sqrt(x * x + y * y + z * z);
    rt_vec3 result = {(float)(x / l), (float)(y / l), (float)(z / l)};
    RTI_FP_HOLD(result);
    rti_fp_leave(env);
    return result;
}

rt_status rti_add_begin(rt_scene *scene, const char *call, const void *desc, void *full, uint32_t size,
                        const rt_geometry_common *common)
{
    rt_status status = rti_scene_editable(scene, call);
    if (status == RT_OK)
        status = rti_desc_take(scene->ctx, call, desc, full, size);
    if (status == RT_OK)
        status = rti_check_common(scene, call, common);
    return status;
}

rt_status rti_shapes_push(rt_scene *scene, const char *call, const rt_geometry_common *common, uint32_t count,
                          rti_geometry **geometry, rtk_shape **shapes)
{
    rt_status status;
    if (!rti_reserve(scene->ctx, &scene->shapes.data, &scene->shapes.capacity, scene->shapes.count, (size_t)count + 1,
                     sizeof **shapes))
        return rti_array_refused(scene->ctx, call, &scene->shapes, count, sizeof **shapes);
    status = rti_geometry_push(scene, call, common, RTK_GEOM_SHAPES, count, geometry);
    if (status != RT_OK)
        return status;
    (*geometry)->first = (uint32_t)scene->shapes.count;
    *shapes = RTI_AT(scene->shapes, rtk_shape, scene->shapes.count);
    if (count > 0) /* else there may be no array yet */
        memset(*shapes, 0, count * sizeof **shapes);
    scene->shapes.count += count;
    scene->shape_count += count;
    return RT_OK;
}

void rti_geometry_give(const rt_scene *scene, rt_geometry *geometry)
{
    if (geometry)
        geometry->id = (uint32_t)(scene->geometries.count - 1);
}

static rt_status push_one(rt_scene *scene, const char *call, const rt_geometry_common *common, const rtk_shape *shape,
                          rt_geometry *geometry)
{
    rti_geometry *g = NULL;
    rtk_shape *slot = NULL;
    rt_status status = rti_shapes_push(scene, call, common, 1, &g, &slot);
    if (status != RT_OK)
        return status;
    *slot = *shape;
    rti_geometry_give(scene, geometry);
    return RT_OK;
}

rt_sphere_desc rt_sphere_desc_default(void)
{
    rt_sphere_desc d;
    memset(&d, 0, sizeof d);
    d.struct_size = sizeof d;
    d.common = rti_common_default();
    d.radius = 1.0f;
    return d;
}

rt_status rt_scene_add_sphere(rt_scene *scene, const rt_sphere_desc *desc, rt_geometry *geometry)
{
    static const char call[] = "rt_scene_add_sphere";
    rt_sphere_desc d = rt_sphere_desc_default();
    rtk_shape shape = {.type = RTK_SHAPE_SPHERE};
    rt_status status = rti_add_begin(scene, call, desc, &d, sizeof d, &d.common);
    if (status == RT_OK)
        status = rti_check_point(scene->ctx, call, "center", d.center);
    if (status == RT_OK)
        status = rti_check_positive(scene->ctx, call, "radius", d.radius);
    if (status != RT_OK)
        return status;
    put(shape.p, d.center);
    shape.p[3] = d.radius;
    return push_one(scene, call, &d.common, &shape, geometry);
}

rt_box_desc rt_box_desc_default(void)
{
    rt_box_desc d;
    memset(&d, 0, sizeof d);
    d.struct_size = sizeof d;
    d.common = rti_common_default();
    d.low = (rt_vec3){-1.0f, -1.0f, -1.0f};
    d.high = (rt_vec3){1.0f, 1.0f, 1.0f};
    return d;
}

rt_status rt_scene_add_box(rt_scene *scene, const rt_box_desc *desc, rt_geometry *geometry)
{
    static const char call[] = "rt_scene_add_box";
    rt_box_desc d = rt_box_desc_default();
    rtk_shape shape = {.type = RTK_SHAPE_BOX};
    rt_status status = rti_add_begin(scene, call, desc, &d, sizeof d, &d.common);
    if (status == RT_OK)
        status = rti_check_point(scene->ctx, call, "low", d.low);
    if (status == RT_OK)
        status = rti_check_point(scene->ctx, call, "high", d.high);
    if (status != RT_OK)
        return status;
    put(shape.p, d.low);
    put(shape.p + 3, d.high);
    for (int k = 0; k < 3; k++) {
        char low[32], high[32];
        if (!(shape.p[k] < shape.p[3 + k]))
            return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: on the %c axis low is %s and high is %s; low must be below high",
                            call, 'x' + k, rti_num(low, shape.p[k]), rti_num(high, shape.p[3 + k]));
    }
    return push_one(scene, call, &d.common, &shape, geometry);
}

rt_cone_desc rt_cone_desc_default(void)
{
    rt_cone_desc d;
    memset(&d, 0, sizeof d);
    d.struct_size = sizeof d;
    d.common = rti_common_default();
    d.to = (rt_vec3){0.0f, 1.0f, 0.0f};
    d.radius0 = 1.0f;
    return d;
}

static rt_status begin_cone(rt_scene *scene, const char *call, const rt_cone_desc *desc, rt_cone_desc *d)
{
    rt_status status = rti_add_begin(scene, call, desc, d, sizeof *d, &d->common);
    if (status == RT_OK)
        status = rti_check_point(scene->ctx, call, "from", d->from);
    if (status == RT_OK)
        status = rti_check_point(scene->ctx, call, "to", d->to);
    if (status == RT_OK && d->from.x == d->to.x && d->from.y == d->to.y && d->from.z == d->to.z)
        status = rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: from and to are the same point; they must differ", call);
    return status;
}

rt_status rt_scene_add_cylinder(rt_scene *scene, const rt_cone_desc *desc, rt_geometry *geometry)
{
    static const char call[] = "rt_scene_add_cylinder";
    rt_cone_desc d = rt_cone_desc_default();
    rtk_shape shape = {.type = RTK_SHAPE_CYLINDER};
    rt_status status = begin_cone(scene, call, desc, &d);
    if (status == RT_OK)
        status = rti_check_positive(scene->ctx, call, "radius0", d.radius0);
    if (status != RT_OK)
        return status;
    put(shape.p, d.from);
    shape.p[3] = d.radius0;
    put(shape.p + 4, d.to);
    return push_one(scene, call, &d.common, &shape, geometry);
}

rt_status rt_scene_add_cone(rt_scene *scene, const rt_cone_desc *desc, rt_geometry *geometry)
{
    static const char call[] = "rt_scene_add_cone";
    rt_cone_desc d = rt_cone_desc_default();
    rtk_shape shape = {.type = RTK_SHAPE_CONE};
    rt_status status = begin_cone(scene, call, desc, &d);
    if (status == RT_OK)
        status = rti_check_range(scene->ctx, call, "radius0", d.radius0, 0.0f, RTI_COORD_MAX);
    if (status == RT_OK)
        status = rti_check_range(scene->ctx, call, "radius1", d.radius1, 0.0f, RTI_COORD_MAX);
    if (status == RT_OK && d.radius0 == 0.0f && d.radius1 == 0.0f)
        status = rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: radius0 and radius1 are both 0; one of them must be greater", call);
    if (status != RT_OK)
        return status;
    put(shape.p, d.from);
    shape.p[3] = d.radius0;
    put(shape.p + 4, d.to);
    shape.p[7] = d.radius1;
    return push_one(scene, call, &d.common, &shape, geometry);
}

rt_torus_desc rt_torus_desc_default(void)
{
    rt_torus_desc d;
    memset(&d, 0, sizeof d);
    d.struct_size = sizeof d;
    d.common = rti_common_default();
    d.axis = (rt_vec3){0.0f, 1.0f, 0.0f};
    d.major_radius = 1.0f;
    d.minor_radius = 0.25f;
    return d;
}

rt_status rt_scene_add_torus(rt_scene *scene, const rt_torus_desc *desc, rt_geometry *geometry)
{
    static const char call[] = "rt_scene_add_torus";
    rt_torus_desc d = rt_torus_desc_default();
    rtk_shape shape = {.type = RTK_SHAPE_TORUS};
    rt_status status = rti_add_begin(scene, call, desc, &d, sizeof d, &d.common);
    char minor[32], major[32];
    if (status == RT_OK)
        status = rti_check_point(scene->ctx, call, "center", d.center);
    if (status == RT_OK)
        status = rti_check_direction(scene->ctx, call, "axis", d.axis);
    if (status == RT_OK)
        status = rti_check_positive(scene->ctx, call, "major_radius", d.major_radius);
    if (status == RT_OK)
        status = rti_check_positive(scene->ctx, call, "minor_radius", d.minor_radius);
    if (status == RT_OK && !(d.minor_radius < d.major_radius))
        status = rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: minor_radius is %s; it must be below major_radius, which is %s",
                          call, rti_num(minor, d.minor_radius), rti_num(major, d.major_radius));
    if (status != RT_OK)
        return status;
    put(shape.p, d.center);
    shape.p[3] = d.major_radius;
    put(shape.p + 4, unit(d.axis));
    shape.p[7] = d.minor_radius;
    return push_one(scene, call, &d.common, &shape, geometry);
}

rt_plane_desc rt_plane_desc_default(void)
{
    rt_plane_desc d;
    memset(&d, 0, sizeof d);
    d.struct_size = sizeof d;
    d.common = rti_common_default();
    d.normal = (rt_vec3){0.0f, 1.0f, 0.0f};
    d.texture_size = 1.0f;
    return d;
}

/* The part of a that is perpendicular to the unit n, made unit; false when nearly nothing is left. */
static bool across(rt_vec3 a, rt_vec3 n, rt_vec3 *out)
{
    double d = (double)a.x * n.x + (double)a.y * n.y + (double)a.z * n.z;
    double x = a.x - d * n.x, y = a.y - d * n.y, z = a.z - d * n.z, l = sqrt(x * x + y * y + z * z);
    if (!(l > 1.0e-6))
        return false;
    *out = (rt_vec3){(float)(x / l), (float)(y / l), (float)(z / l)};
    return true;
}

static rt_vec3 plane_u_axis(rt_vec3 wish, rt_vec3 n)
{
    rt_vec3 horizontal = {n.z, 0.0f, -n.x}, result = {1.0f, 0.0f, 0.0f}; /* up x normal */
    if ((wish.x != 0.0f || wish.y != 0.0f || wish.z != 0.0f) && across(unit(wish), n, &result))
        return result;
    if (fabsf(horizontal.x) + fabsf(horizontal.z) > 1.0e-6f && across(unit(horizontal), n, &result))
        return result;
    across((rt_vec3){1.0f, 0.0f, 0.0f}, n, &result);
    return result;
}

#define TEXTURE_LEAST 1.0e-12f /* its inverse times a placement is still a number */

static rt_status check_plane(rt_context *ctx, const char *call, const rt_plane_desc *d)
{
    rt_status status = rti_check_point(ctx, call, "point", d->point);
    if (status == RT_OK)
        status = rti_check_direction(ctx, call, "normal", d->normal);
    if (status == RT_OK)
        status = rti_check_point(ctx, call, "u_axis", d->u_axis);
    if (status == RT_OK)
        status = rti_check_range(ctx, call, "texture_size", d->texture_size, TEXTURE_LEAST, RTI_COORD_MAX);
    if (status == RT_OK && d->texture_height != 0.0f)
        status = rti_check_range(ctx, call, "texture_height", d->texture_height, TEXTURE_LEAST, RTI_COORD_MAX);
    return status;
}

rt_status rt_scene_add_plane(rt_scene *scene, const rt_plane_desc *desc, rt_geometry *geometry)
{
    static const char call[] = "rt_scene_add_plane";
    rt_plane_desc d = rt_plane_desc_default();
    rti_geometry *g = NULL;
    rti_plane *plane;
    rti_fpenv env;
    rt_vec3 n;
    rt_status status = rti_add_begin(scene, call, desc, &d, sizeof d, &d.common);
    if (status == RT_OK)
        status = check_plane(scene->ctx, call, &d);
    if (status != RT_OK)
        return status;
    plane = rti_array_push(scene->ctx, &scene->planes, sizeof *plane);
    if (!plane)
        return rti_array_refused(scene->ctx, call, &scene->planes, 1, sizeof *plane);
    status = rti_geometry_push(scene, call, &d.common, RTK_GEOM_PLANE, 1, &g);
    if (status != RT_OK) {
        scene->planes.count--;
        return status;
    }
    g->first = (uint32_t)(scene->planes.count - 1);
    n = unit(d.normal);
    plane->shape.type = RTK_SHAPE_PLANE;
    put(plane->shape.p, d.point);
    put(plane->shape.p + 4, n);
    env = rti_fp_enter();
    put(plane->t_dir, plane_u_axis(d.u_axis, n));
    rti_fp_leave(env);
    plane->width = d.texture_size;
    plane->height = d.texture_height;
    rti_geometry_give(scene, geometry);
    return RT_OK;
}
