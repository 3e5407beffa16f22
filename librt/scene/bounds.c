/* The box of everything finite, and the camera that it frames. */
#include "scene.h"

#include <math.h>

#include "../kernel/shape_surface.h"

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

/* Bounds of placed scenes, of the last so many: thousands of places have few of them. */
enum { CHILDREN = 16 };
typedef struct child_bounds {
    const rt_scene *child[CHILDREN];
    float lo[CHILDREN][3], hi[CHILDREN][3];
    uint32_t next;
} child_bounds;

/* Where a child's bounds stand. */
static uint32_t bounds_of_child(child_bounds *known, const rt_scene *child)
{
    uint32_t at = 0;
    while (at < CHILDREN && known->child[at] != child)
        at++;
    if (at < CHILDREN)
        return at;
    at = known->next++ % CHILDREN;
    known->child[at] = child;
    for (int k = 0; k < 3; k++) {
        known->lo[at][k] = INFINITY;
        known->hi[at][k] = -INFINITY;
    }
    if (child->loaded)
        loaded_bounds(child, known->lo[at], known->hi[at]);
    else
        own_bounds(child, known->lo[at], known->hi[at]);
    return at;
}

static void scene_bounds(const rt_scene *scene, float lo[3], float hi[3])
{
    child_bounds known = {.next = 0};
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
        float wlo[3], whi[3];
        if (!inst->child)
            continue;
        const uint32_t at = bounds_of_child(&known, inst->child);
        const float *clo = known.lo[at], *chi = known.hi[at];
        if (!(clo[0] <= chi[0]))
            continue;
        rti_xfm_bounds(&inst->to_world, clo, chi, wlo, whi);
        include(lo, hi, wlo);
        include(lo, hi, whi);
        for (uint32_t k = 0; k < inst->motion_count; k++) { /* from place to place */
            rtk_xfm keys[2] = {inst->to_world};
            rtk_motion segment;
            if (k > 0)
                memcpy(keys[0].m, inst->motion[k - 1].m, sizeof keys[0].m);
            memcpy(keys[1].m, inst->motion[k].m, sizeof keys[1].m);
            rti_motion_make(keys, 1, &segment);
            rti_motion_bounds(&segment, 1, clo, chi, wlo, whi);
            include(lo, hi, wlo);
            include(lo, hi, whi);
        }
    }
}

rt_status rt_scene_bounds(const rt_scene *scene, rt_vec3 *low, rt_vec3 *high)
{
    RTI_NEED(scene);
    float lo[3], hi[3];
    if (!low || !high)
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "rt_scene_bounds: low or high is NULL; give places for both corners");
    rti_fpenv env = rti_fp_enter();
    scene_bounds(scene, lo, hi);
    *low = (rt_vec3){lo[0], lo[1], lo[2]};
    *high = (rt_vec3){hi[0], hi[1], hi[2]};
    rti_fp_leave(env);
    return RT_OK;
}

/* The box's ball fits into the narrower of the two angles of view. A box of no size gets a distance that its coordinates can
 * tell. */
static void frame(rt_camera_desc *d, const float lo[3], const float hi[3], float aspect)
{
    const double ahead[3] = {0.45, 0.3, 1.0}, length = sqrt(0.45 * 0.45 + 0.3 * 0.3 + 1.0 * 1.0);
    double middle[3], radius, least = 1.0e-30, sum = 0.0, distance,
                              tangent = tan(0.5 * d->fov_deg * 0.017453292519943295) * fmin(1.0, aspect);
    for (int k = 0; k < 3; k++) {
        middle[k] = 0.5 * ((double)lo[k] + hi[k]);
        least = fmax(least, 1.0e-5 * fabs(middle[k]));
        sum += ((double)hi[k] - lo[k]) * ((double)hi[k] - lo[k]);
    }
    radius = 0.5 * sqrt(sum);
    distance = fmax(radius, least) * sqrt(1.0 + tangent * tangent) / tangent * 1.02;
    d->look_at = (rt_vec3){(float)middle[0], (float)middle[1], (float)middle[2]};
    d->eye = (rt_vec3){(float)(middle[0] + distance * (ahead[0] / length)), (float)(middle[1] + distance * (ahead[1] / length)),
                       (float)(middle[2] + distance * (ahead[2] / length))};
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
    rti_fpenv env = rti_fp_enter();
    RTI_FP_HOLD(aspect);
    scene_bounds(scene, lo, hi);
    if (lo[0] <= hi[0])
        frame(&d, lo, hi, aspect);
    RTI_FP_HOLD(d);
    rti_fp_leave(env);
    return rt_scene_set_camera(scene, &d);
}
