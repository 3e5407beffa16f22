/* Cameras, and the box of everything finite, which frames one. */
#include "scene.h"

#include <math.h>
#include <string.h>

#include "../kernel/shapes.h"

rt_camera_desc rt_camera_desc_default(void)
{
    rt_camera_desc d;
    memset(&d, 0, sizeof d);
    d.struct_size = sizeof d;
    d.eye = (rt_vec3){0.0f, 0.0f, 5.0f};
    d.up = (rt_vec3){0.0f, 1.0f, 0.0f};
    d.fov_deg = 50.0f;
    d.height = 2.0f;
    return d;
}

typedef struct dvec {
    double x, y, z;
} dvec;

static dvec minus(rt_vec3 a, rt_vec3 b)
{
    return (dvec){(double)a.x - b.x, (double)a.y - b.y, (double)a.z - b.z};
}

static dvec cross(dvec a, dvec b)
{
    return (dvec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static double length(dvec a)
{
    return sqrt(a.x * a.x + a.y * a.y + a.z * a.z);
}

static dvec unit(dvec a)
{
    double l = length(a);
    return (dvec){a.x / l, a.y / l, a.z / l};
}

static void put(float out[3], dvec a)
{
    out[0] = (float)a.x;
    out[1] = (float)a.y;
    out[2] = (float)a.z;
}

static rtk_camera camera_record(const rt_camera_desc *d)
{
    rtk_camera c;
    rti_fpenv env = rti_fp_enter();
    dvec front = unit(minus(d->look_at, d->eye)), up = {d->up.x, d->up.y, d->up.z}, right;
    memset(&c, 0, sizeof c);
    if (length(up) > 0.0)
        up = unit(up);
    right = cross(front, up);
    if (!(length(right) > 1.0e-6)) { /* up lies along the view: the axis that differs most from it */
        up = fabs(front.y) < 0.9 ? (dvec){0.0, 1.0, 0.0} : (dvec){0.0, 0.0, front.y > 0.0 ? 1.0 : -1.0};
        right = cross(front, up);
    }
    right = unit(right);
    c.type = d->type == RT_CAMERA_ORTHOGRAPHIC ? RTK_CAMERA_ORTHOGRAPHIC : RTK_CAMERA_PINHOLE;
    memcpy(c.eye, &d->eye, sizeof c.eye);
    put(c.front, front);
    put(c.right, right);
    put(c.up, cross(right, front));
    c.half_height = d->type == RT_CAMERA_ORTHOGRAPHIC ? 0.5f * d->height : (float)tan(0.5 * d->fov_deg * 0.017453292519943295);
    rti_fp_leave(env);
    return c;
}

static rt_status check(rt_context *ctx, const char *call, const rt_camera_desc *d)
{
    char text[32];
    rt_status status;
    if ((uint32_t)d->type > RT_CAMERA_ORTHOGRAPHIC)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: type is %u; it must be RT_CAMERA_PINHOLE (0) or RT_CAMERA_ORTHOGRAPHIC (1)",
                        call, (unsigned)d->type);
    if ((status = rti_check_point(ctx, call, "eye", d->eye)) != RT_OK ||
        (status = rti_check_point(ctx, call, "look_at", d->look_at)) != RT_OK ||
        (status = rti_check_point(ctx, call, "up", d->up)) != RT_OK)
        return status;
    if (d->eye.x == d->look_at.x && d->eye.y == d->look_at.y && d->eye.z == d->look_at.z)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: eye and look_at are the same point; the camera needs somewhere to look",
                        call);
    if (d->type == RT_CAMERA_ORTHOGRAPHIC)
        return rti_check_positive(ctx, call, "height", d->height);
    if (!(d->fov_deg > 0.0f && d->fov_deg < 180.0f))
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: fov_deg is %s; it must be greater than 0 and below 180", call,
                        rti_num(text, d->fov_deg));
    return RT_OK;
}

rt_status rt_scene_set_camera(rt_scene *scene, const rt_camera_desc *desc)
{
    static const char call[] = "rt_scene_set_camera";
    rt_camera_desc d = rt_camera_desc_default();
    rt_status status = rti_scene_editable(scene, call);
    if (status == RT_OK)
        status = rti_desc_take(scene->ctx, call, desc, &d, sizeof d);
    if (status == RT_OK)
        status = check(scene->ctx, call, &d);
    if (status != RT_OK)
        return status;
    scene->camera = d;
    scene->world.camera = camera_record(&d);
    return RT_OK;
}

/* The description of a loaded scene's camera, from its record: look_at is one unit ahead. */
static rt_camera_desc describe(const rtk_camera *c)
{
    rt_camera_desc d = rt_camera_desc_default();
    d.type = c->type == RTK_CAMERA_ORTHOGRAPHIC ? RT_CAMERA_ORTHOGRAPHIC : RT_CAMERA_PINHOLE;
    d.eye = (rt_vec3){c->eye[0], c->eye[1], c->eye[2]};
    d.look_at = (rt_vec3){c->eye[0] + c->front[0], c->eye[1] + c->front[1], c->eye[2] + c->front[2]};
    d.up = (rt_vec3){c->up[0], c->up[1], c->up[2]};
    if (c->type == RTK_CAMERA_ORTHOGRAPHIC)
        d.height = 2.0f * c->half_height;
    else
        d.fov_deg = (float)(2.0 * atan((double)c->half_height) / 0.017453292519943295);
    return d;
}

rt_status rt_scene_get_camera(const rt_scene *scene, rt_camera_desc *desc)
{
    rti_snapshot *snapshot;
    if (!desc)
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "rt_scene_get_camera: desc is NULL; give the place for the camera");
    *desc = scene->camera;
    if (scene->loaded) {
        snapshot = rti_scene_snapshot(scene);
        *desc = describe(&rti_snapshot_view(snapshot)->world->camera);
        rti_snapshot_release(snapshot);
    }
    return RT_OK;
}

/* ---- bounds ---- */

static void include(float lo[3], float hi[3], const float *p)
{
    for (int k = 0; k < 3; k++) {
        lo[k] = fminf(lo[k], p[k]);
        hi[k] = fmaxf(hi[k], p[k]);
    }
}

static void shape_box(const rtk_shape *shape, float lo[3], float hi[3])
{
    rtk_vec3 a, b;
    rtk_shape_bounds(shape, &a, &b);
    lo[0] = a.x;
    lo[1] = a.y;
    lo[2] = a.z;
    hi[0] = b.x;
    hi[1] = b.y;
    hi[2] = b.z;
}

static void own_bounds(const rt_scene *scene, float lo[3], float hi[3])
{
    for (size_t i = 0; i < scene->geometries.count; i++) {
        const rti_geometry *g = RTI_AT(scene->geometries, rti_geometry, i);
        for (uint32_t k = 0; g->type == RTK_GEOM_MESH && k < 3 * g->count; k++)
            include(lo, hi, g->mesh->positions + 3 * (size_t)g->mesh->indices[k]);
        for (uint32_t k = 0; g->type == RTK_GEOM_SHAPES && k < g->count; k++) {
            float a[3], b[3];
            shape_box(RTI_AT(scene->shapes, rtk_shape, g->first + k), a, b);
            include(lo, hi, a);
            include(lo, hi, b);
        }
    }
}

static void loaded_bounds(const rt_scene *scene, float lo[3], float hi[3])
{
    rti_snapshot *snapshot = rti_scene_snapshot(scene);
    rtk_vec3 a, b;
    rti_snapshot_bounds(snapshot, &a, &b);
    rti_snapshot_release(snapshot);
    if (a.x <= b.x) {
        include(lo, hi, (float[3]){a.x, a.y, a.z});
        include(lo, hi, (float[3]){b.x, b.y, b.z});
    }
}

static void scene_bounds(const rt_scene *scene, float lo[3], float hi[3])
{
    for (int k = 0; k < 3; k++) {
        lo[k] = INFINITY;
        hi[k] = -INFINITY;
    }
    if (scene->loaded)
        loaded_bounds(scene, lo, hi);
    else
        own_bounds(scene, lo, hi);
    for (size_t i = 0; i < scene->instances.count; i++) {
        const rti_inst *inst = RTI_AT(scene->instances, rti_inst, i);
        float clo[3] = {INFINITY, INFINITY, INFINITY}, chi[3] = {-INFINITY, -INFINITY, -INFINITY}, wlo[3], whi[3];
        if (!inst->child)
            continue;
        if (inst->child->loaded)
            loaded_bounds(inst->child, clo, chi);
        else
            own_bounds(inst->child, clo, chi);
        if (!(clo[0] <= chi[0]))
            continue;
        rti_xfm_bounds(&inst->to_world, clo, chi, wlo, whi);
        include(lo, hi, wlo);
        include(lo, hi, whi);
    }
}

rt_status rt_scene_bounds(const rt_scene *scene, rt_vec3 *low, rt_vec3 *high)
{
    float lo[3], hi[3];
    if (!low || !high)
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "rt_scene_bounds: low or high is NULL; give places for both corners");
    scene_bounds(scene, lo, hi);
    *low = (rt_vec3){lo[0], lo[1], lo[2]};
    *high = (rt_vec3){hi[0], hi[1], hi[2]};
    return RT_OK;
}

/* The box's ball fits into the narrower of the two angles of view. A box of no size gets a distance that its coordinates can
 * tell. */
static void frame(rt_camera_desc *d, const float lo[3], const float hi[3], float aspect)
{
    rti_fpenv env = rti_fp_enter();
    double middle[3], radius, least = 1.0e-30, tangent = tan(0.5 * d->fov_deg * 0.017453292519943295) * fmin(1.0, aspect),
                              distance;
    dvec ahead = unit((dvec){0.45, 0.3, 1.0});
    for (int k = 0; k < 3; k++) {
        middle[k] = 0.5 * ((double)lo[k] + hi[k]);
        least = fmax(least, 1.0e-5 * fabs(middle[k]));
    }
    radius = 0.5 * length((dvec){(double)hi[0] - lo[0], (double)hi[1] - lo[1], (double)hi[2] - lo[2]});
    distance = fmax(radius, least) * sqrt(1.0 + tangent * tangent) / tangent * 1.02;
    d->look_at = (rt_vec3){(float)middle[0], (float)middle[1], (float)middle[2]};
    d->eye = (rt_vec3){(float)(middle[0] + distance * ahead.x), (float)(middle[1] + distance * ahead.y),
                       (float)(middle[2] + distance * ahead.z)};
    rti_fp_leave(env);
}

rt_status rt_scene_frame_camera(rt_scene *scene, float aspect)
{
    static const char call[] = "rt_scene_frame_camera";
    rt_camera_desc d = rt_camera_desc_default();
    float lo[3], hi[3];
    char text[32];
    rt_status status = rti_scene_editable(scene, call);
    if (status != RT_OK)
        return status;
    if (!(aspect >= 1.0e-3f && aspect <= 1.0e3f))
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: aspect is %s; it must be from 0.001 to 1000", call,
                        rti_num(text, aspect));
    scene_bounds(scene, lo, hi);
    if (lo[0] <= hi[0])
        frame(&d, lo, hi, aspect);
    return rt_scene_set_camera(scene, &d);
}
