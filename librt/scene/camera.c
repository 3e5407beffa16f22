/* Cameras. */
#include "scene.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

rt_camera_desc rt_camera_desc_default(void)
{
    rt_camera_desc d;
    memset(&d, 0, sizeof d);
    d.struct_size = sizeof d;
    d.eye = (rt_vec3){0.0f, 0.0f, 5.0f};
    d.up = (rt_vec3){0.0f, 1.0f, 0.0f};
    d.fov_deg = 50.0f;
    d.height = 2.0f;
    d.shutter_close = 1.0f;
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

static float half_height(const rt_camera_desc *d)
{
    return d->type == RT_CAMERA_ORTHOGRAPHIC ? 0.5f * d->height : (float)tan(0.5 * d->fov_deg * 0.017453292519943295);
}

static rtk_camera camera_record(const rt_camera_desc *d)
{
    rtk_camera c;
    dvec aim = minus(d->look_at, d->eye), front = unit(aim), up = {d->up.x, d->up.y, d->up.z}, right;
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
    c.half_height = half_height(d);
    c.aperture = d->aperture;
    c.focus = d->focus_distance > 0.0f ? d->focus_distance : (float)length(aim);
    c.blades = d->blades;
    c.blade_turn = (float)(d->blade_rotation_deg * 0.017453292519943295);
    c.open = d->shutter_open;
    c.close = d->shutter_close;
    return c;
}

/* One end of the way of a camera that has this record. An up that lies along the view gives way to the record's. */
static rtk_camera_key key_of(const rt_camera_desc *d, const rtk_camera *c)
{
    dvec up = {d->up.x, d->up.y, d->up.z};
    bool stands = length(cross(unit(minus(d->look_at, d->eye)), up)) > 1.0e-6 * length(up);
    rtk_camera_key k;
    memcpy(k.eye, c->eye, sizeof k.eye);
    put(k.aim, minus(d->look_at, d->eye));
    memcpy(k.up, stands ? &d->up.x : c->up, sizeof k.up);
    k.half_height = c->half_height;
    k.aperture = c->aperture;
    k.focus = c->focus;
    return k;
}

/* Puts the way from a to b into the record of a. */
static void put_motion(rtk_camera *record, const rt_camera_desc *a, const rt_camera_desc *b)
{
    rtk_camera end = camera_record(b);
    record->flags |= RTK_CAMERA_MOVING;
    record->key[0] = key_of(a, record);
    record->key[1] = key_of(b, &end);
    if (!(a->focus_distance > 0.0f) && !(b->focus_distance > 0.0f))
        record->key[0].focus = record->key[1].focus = 0.0f;
}

static rt_status check_lens(rt_context *ctx, const char *call, const rt_camera_desc *d)
{
    char a[32], b[32];
    rt_status status;
    if ((status = rti_check_range(ctx, call, "aperture", d->aperture, 0.0f, RTI_COORD_MAX)) != RT_OK ||
        (status = rti_check_range(ctx, call, "focus_distance", d->focus_distance, 0.0f, RTI_COORD_MAX)) != RT_OK ||
        (status = rti_check_range(ctx, call, "blade_rotation_deg", d->blade_rotation_deg, -1.0e6f, 1.0e6f)) != RT_OK)
        return status;
    if (d->blades != 0 && (d->blades < 3 || d->blades > RTI_BLADES_MAX))
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: blades is %u; it must be from 3 to %u, or 0 for a round lens", call,
                        d->blades, RTI_BLADES_MAX);
    if (!(d->shutter_open >= 0.0f && d->shutter_open <= d->shutter_close && d->shutter_close <= 1.0f))
        return rti_fail(ctx, RT_ERROR_ARGUMENT,
                        "%s: the shutter opens at %s and closes at %s; they must be times from 0 to 1, in this order", call,
                        rti_num(a, d->shutter_open), rti_num(b, d->shutter_close));
    return RT_OK;
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
    if ((status = check_lens(ctx, call, d)) != RT_OK)
        return status;
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
    rti_fpenv env;
    rt_status status = rti_scene_editable(scene, call);
    if (status == RT_OK)
        status = rti_desc_take(scene->ctx, call, desc, &d, sizeof d);
    if (status == RT_OK)
        status = check(scene->ctx, call, &d);
    if (status != RT_OK)
        return status;
    env = rti_fp_enter();
    scene->camera[0] = scene->camera[1] = d;
    scene->world.camera = camera_record(&d);
    rti_fp_leave(env);
    return RT_OK;
}

/* Between its ends a camera might come to look nowhere, or along its up: neither has a picture. */
static const char *bad_way(const rtk_camera *c)
{
    const rtk_camera_key *a = &c->key[0], *b = &c->key[1];
    double wide = fmax(length((dvec){a->up[0], a->up[1], a->up[2]}), length((dvec){b->up[0], b->up[1], b->up[2]}));
    for (int i = 0; i <= 256; i++) {
        double t = i / 256.0, large = 0.0;
        dvec aim = {a->aim[0] + t * ((double)b->aim[0] - a->aim[0]), a->aim[1] + t * ((double)b->aim[1] - a->aim[1]),
                    a->aim[2] + t * ((double)b->aim[2] - a->aim[2])};
        dvec up = {a->up[0] + t * ((double)b->up[0] - a->up[0]), a->up[1] + t * ((double)b->up[1] - a->up[1]),
                   a->up[2] + t * ((double)b->up[2] - a->up[2])};
        for (int k = 0; k < 3; k++)
            large = fmax(large, fmax(fabs((double)a->aim[k]), fabs((double)b->aim[k])));
        if (!(length(aim) > 0.01 * large))
            return "eye and look_at meet";
        if (!(length(cross(unit(aim), up)) > 0.01 * wide))
            return "it looks along its up";
    }
    return NULL;
}

rt_status rt_scene_set_camera_motion(rt_scene *scene, const rt_camera_desc *desc)
{
    static const char call[] = "rt_scene_set_camera_motion";
    rt_camera_desc d = rt_camera_desc_default();
    rtk_camera record;
    const char *fault;
    rti_fpenv env;
    rt_status status = rti_scene_editable(scene, call);
    if (status == RT_OK && !desc)
        return rt_scene_set_camera(scene, &scene->camera[0]);
    if (status == RT_OK)
        status = rti_desc_take(scene->ctx, call, desc, &d, sizeof d);
    if (status != RT_OK)
        return status;
    d.blades = scene->camera[0].blades;
    d.blade_rotation_deg = scene->camera[0].blade_rotation_deg;
    d.shutter_open = scene->camera[0].shutter_open;
    d.shutter_close = scene->camera[0].shutter_close;
    if ((status = check(scene->ctx, call, &d)) != RT_OK)
        return status;
    if (d.type != scene->camera[0].type)
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT,
                        "%s: type is not the camera's; a pinhole camera does not become an orthographic one", call);
    env = rti_fp_enter();
    record = camera_record(&scene->camera[0]);
    put_motion(&record, &scene->camera[0], &d);
    fault = bad_way(&record);
    RTI_FP_HOLD(record);
    rti_fp_leave(env);
    if (fault)
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT,
                        "%s: on the camera's way there is a time when %s; move it less, or give up and look_at that stay apart",
                        call, fault);
    scene->camera[1] = d;
    scene->world.camera = record;
    return RT_OK;
}

/* The description of a loaded scene's camera at one end of its way, from its record: look_at is one unit ahead, or as many as the
 * eye's largest coordinate has, where floats one unit apart would tell another direction; or where it is for a camera that moves.
 */
static rt_camera_desc describe(const rtk_camera *c, int end)
{
    rt_camera_desc d = rt_camera_desc_default();
    const rtk_camera_key *k = &c->key[end];
    float half = c->half_height, ahead = fmaxf(1.0f, fmaxf(fabsf(c->eye[0]), fmaxf(fabsf(c->eye[1]), fabsf(c->eye[2]))));
    d.type = c->type == RTK_CAMERA_ORTHOGRAPHIC ? RT_CAMERA_ORTHOGRAPHIC : RT_CAMERA_PINHOLE;
    d.eye = (rt_vec3){c->eye[0], c->eye[1], c->eye[2]};
    d.look_at = (rt_vec3){c->eye[0] + ahead * c->front[0], c->eye[1] + ahead * c->front[1], c->eye[2] + ahead * c->front[2]};
    d.up = (rt_vec3){c->up[0], c->up[1], c->up[2]};
    d.aperture = c->aperture;
    d.focus_distance = c->focus;
    d.blades = c->blades;
    d.blade_rotation_deg = (float)(c->blade_turn / 0.017453292519943295);
    d.shutter_open = c->open;
    d.shutter_close = c->close;
    if (c->flags & RTK_CAMERA_MOVING) {
        d.eye = (rt_vec3){k->eye[0], k->eye[1], k->eye[2]};
        d.look_at = (rt_vec3){k->eye[0] + k->aim[0], k->eye[1] + k->aim[1], k->eye[2] + k->aim[2]};
        d.up = (rt_vec3){k->up[0], k->up[1], k->up[2]};
        d.aperture = k->aperture;
        d.focus_distance = k->focus;
        half = k->half_height;
    }
    if (c->type == RTK_CAMERA_ORTHOGRAPHIC)
        d.height = 2.0f * half;
    else
        d.fov_deg = (float)(2.0 * atan((double)half) / 0.017453292519943295);
    return d;
}

static rt_status get_camera(const rt_scene *scene, const char *call, rt_camera_desc *desc, int end)
{
    rti_snapshot *snapshot;
    rt_camera_desc d = scene->camera[end];
    uint32_t size = (uint32_t)offsetof(rt_camera_desc, aperture);
    if (!desc)
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: desc is NULL; give the place for the camera", call);
    if (scene->loaded) {
        snapshot = rti_scene_snapshot(scene);
        d = describe(&rti_snapshot_view(snapshot)->world->camera, end);
        rti_snapshot_release(snapshot);
    }
    if (desc->struct_size == sizeof d)
        size = sizeof d;
    d.struct_size = size;
    memcpy(desc, &d, size);
    return RT_OK;
}

rt_status rt_scene_get_camera(const rt_scene *scene, rt_camera_desc *desc)
{
    RTI_NEED(scene);
    return get_camera(scene, "rt_scene_get_camera", desc, 0);
}

rt_status rt_scene_get_camera_motion(const rt_scene *scene, rt_camera_desc *desc)
{
    RTI_NEED(scene);
    return get_camera(scene, "rt_scene_get_camera_motion", desc, 1);
}
