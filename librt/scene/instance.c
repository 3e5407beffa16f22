/* Instances: a whole scene placed in another. */
#include "scene.h"

#include <math.h>
#include <string.h>

rt_instance_desc rt_instance_desc_default(void)
{
    rt_instance_desc d;
    memset(&d, 0, sizeof d);
    d.struct_size = sizeof d;
    d.transform = rt_transform_identity();
    d.material.id = RT_INVALID_ID;
    d.mask = RT_MASK_ALL;
    return d;
}

static size_t alive_instances(const rt_scene *scene)
{
    size_t n = 0;
    for (size_t i = 0; i < scene->instances.count; i++)
        n += RTI_AT(scene->instances, rti_inst, i)->child != NULL;
    return n;
}

static rt_status check_transform(rt_context *ctx, const char *call, const char *field, const rt_transform *t)
{
    rtk_xfm m, w;
    rt_status status = rti_check_floats(ctx, call, field, t->m, 12, 1, RTI_COORD_MAX);
    if (status != RT_OK)
        return status;
    memcpy(m.m, t->m, sizeof m.m);
    rti_fpenv env = rti_fp_enter();
    RTI_FP_HOLD(m);
    bool fine = rti_xfm_invert(&m, &w);
    rti_fp_leave(env);
    if (!fine)
        return rti_fail(
            ctx, RT_ERROR_ARGUMENT,
            "%s: %s has no inverse (or one that floats cannot hold): it flattens space; scale every axis by more than "
            "nothing",
            call, field);
    return RT_OK;
}

/* The places behind `first`, checked and copied; *out NULL when all of them are where the first is. */
static rt_status take_motion(rt_context *ctx, const char *call, const rtk_xfm *first, const rt_transform *motion, uint32_t count,
                             rt_transform **out)
{
    bool moves = false;
    rtk_xfm *keys;
    rtk_motion *segments;
    const char *fault;
    rt_status status = RT_OK;
    *out = NULL;
    if (count > RTI_MOTION_MAX)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: motion_count is %u; it must be at most %u", call, count, RTI_MOTION_MAX);
    if (count > 0 && !motion)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: motion is NULL, motion_count %u; give as many places", call, count);
    for (uint32_t i = 0; i < count && status == RT_OK; i++) {
        status = check_transform(ctx, call, "motion", &motion[i]);
        moves = moves || memcmp(motion[i].m, first->m, sizeof first->m) != 0;
    }
    if (status != RT_OK || !moves)
        return status;
    keys = rti_alloc_array(ctx, count + 1, sizeof *keys);
    segments = rti_alloc_array(ctx, count, sizeof *segments);
    *out = rti_alloc_array(ctx, count, sizeof **out);
    if (keys && segments && *out) {
        keys[0] = *first;
        memcpy(keys + 1, motion, count * sizeof *keys);
        memcpy(*out, motion, count * sizeof **out);
        rti_fpenv env = rti_fp_enter();
        fault = rti_motion_make(keys, count, segments);
        rti_fp_leave(env);
        if (fault)
            status = rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: the places of motion %s; no time may flatten the body", call, fault);
    } else {
        status = rti_fail_memory(ctx, call, (count + 1) * sizeof *keys);
    }
    rti_free(ctx, keys, (count + 1) * sizeof *keys);
    rti_free(ctx, segments, count * sizeof *segments);
    if (status != RT_OK) {
        rti_free(ctx, *out, count * sizeof **out);
        *out = NULL;
    }
    return status;
}

static void put_motion(rt_context *ctx, rti_inst *inst, rt_transform *motion, uint32_t count)
{
    rti_free(ctx, inst->motion, inst->motion_count * sizeof *inst->motion);
    inst->motion = motion;
    inst->motion_count = motion ? count : 0;
}

static rt_status check(const rt_scene *scene, const char *call, const rt_instance_desc *d)
{
    rt_context *ctx = scene->ctx;
    if (!d->child)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: child is NULL; give the scene to place", call);
    if (d->child == scene)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: child is the scene itself; a scene cannot contain itself", call);
    if (d->child->ctx != ctx)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: child belongs to another context; make both scenes from one", call);
    if (alive_instances(d->child) > 0)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: child has instances of its own; only two levels are possible", call);
    if (scene->instances.count >= RTI_MAX_PRIMS)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: the scene has %zu instances, and no more fit", call, scene->instances.count);
    if (d->material.id != RT_INVALID_ID) {
        rt_status status = rti_check_material(scene, call, "material", d->material.id);
        if (status != RT_OK)
            return status;
    }
    return check_transform(ctx, call, "transform", &d->transform);
}

rt_status rt_scene_add_instance(rt_scene *scene, const rt_instance_desc *desc, rt_instance *instance)
{
    static const char call[] = "rt_scene_add_instance";
    rt_instance_desc d = rt_instance_desc_default();
    rti_inst *slot = NULL;
    rtk_xfm first;
    rt_transform *motion = NULL;
    rt_status status = rti_scene_editable(scene, call);
    if (status == RT_OK)
        status = rti_desc_take(scene->ctx, call, desc, &d, sizeof d);
    if (status == RT_OK)
        status = check(scene, call, &d);
    if (status != RT_OK)
        return status;
    memcpy(first.m, d.transform.m, sizeof first.m);
    status = take_motion(scene->ctx, call, &first, d.motion, d.motion_count, &motion);
    if (status != RT_OK)
        return status;
    slot = rti_array_push(scene->ctx, &scene->instances, sizeof *slot);
    if (!slot) {
        rti_free(scene->ctx, motion, d.motion_count * sizeof *motion);
        return rti_array_refused(scene->ctx, call, &scene->instances, 1, sizeof *slot);
    }
    rti_scene_retain(d.child);
    slot->child = d.child;
    slot->to_world = first;
    put_motion(scene->ctx, slot, motion, d.motion_count);
    slot->material = d.material.id;
    slot->mask = d.mask;
    slot->user_id = d.user_id;
    if (instance)
        instance->id = (uint32_t)(scene->instances.count - 1);
    return RT_OK;
}

static rt_status look_up(const rt_scene *scene, const char *call, rt_instance instance, rti_inst **out)
{
    if (instance.id >= scene->instances.count)
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: instance %u is not one of the scene", call, instance.id);
    *out = RTI_AT(scene->instances, rti_inst, instance.id);
    if (!(*out)->child)
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: instance %u was removed", call, instance.id);
    return RT_OK;
}

static rt_status find(rt_scene *scene, const char *call, rt_instance instance, rti_inst **out)
{
    rt_status status = rti_scene_editable(scene, call);
    return status == RT_OK ? look_up(scene, call, instance, out) : status;
}

rt_status rt_scene_get_instance(const rt_scene *scene, rt_instance instance, rt_instance_desc *desc)
{
    RTI_NEED(scene);
    static const char call[] = "rt_scene_get_instance";
    rt_instance_desc d = rt_instance_desc_default();
    rti_inst *slot = NULL;
    rt_status status;
    if (scene->loaded)
        return rti_fail(scene->ctx, RT_ERROR_STATE,
                        "%s: this scene was loaded from a snapshot file, which does not tell how its instances were described",
                        call);
    status = rti_desc_take(scene->ctx, call, desc, &d, sizeof d);
    if (status == RT_OK)
        status = look_up(scene, call, instance, &slot);
    if (status != RT_OK)
        return status;
    /* a caller of another version has a shorter descriptor, or a longer one */
    d.struct_size = desc->struct_size < sizeof d ? desc->struct_size : (uint32_t)sizeof d;
    d.child = slot->child;
    memcpy(d.transform.m, slot->to_world.m, sizeof d.transform.m);
    d.material.id = slot->material;
    d.mask = slot->mask;
    d.user_id = slot->user_id;
    d.motion = slot->motion;
    d.motion_count = slot->motion_count;
    memcpy(desc, &d, d.struct_size);
    return RT_OK;
}

rt_status rt_scene_set_instance_transform(rt_scene *scene, rt_instance instance, const rt_transform *transform)
{
    static const char call[] = "rt_scene_set_instance_transform";
    rti_inst *slot = NULL;
    rt_status status = find(scene, call, instance, &slot);
    if (!slot)
        return status;
    if (!transform)
        return status == RT_OK ? rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: transform is NULL", call) : status;
    if (status == RT_OK)
        status = check_transform(scene->ctx, call, "transform", transform);
    if (status == RT_OK) {
        memcpy(slot->to_world.m, transform->m, sizeof slot->to_world.m);
        put_motion(scene->ctx, slot, NULL, 0);
    }
    return status;
}

rt_status rt_scene_set_instance_motion(rt_scene *scene, rt_instance instance, const rt_transform *motion, uint32_t count)
{
    static const char call[] = "rt_scene_set_instance_motion";
    rti_inst *slot = NULL;
    rt_transform *places = NULL;
    rt_status status = find(scene, call, instance, &slot);
    if (status == RT_OK)
        status = take_motion(scene->ctx, call, &slot->to_world, motion, count, &places);
    if (status == RT_OK)
        put_motion(scene->ctx, slot, places, count);
    return status;
}

rt_status rt_scene_remove_instance(rt_scene *scene, rt_instance instance)
{
    rti_inst *slot = NULL;
    rt_status status = find(scene, "rt_scene_remove_instance", instance, &slot);
    if (status != RT_OK)
        return status;
    rt_scene_destroy(slot->child);
    slot->child = NULL;
    put_motion(scene->ctx, slot, NULL, 0);
    return RT_OK;
}
