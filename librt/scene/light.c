/* Lights and the world around the scene. */
#include "scene.h"

#include <math.h>
#include <string.h>

rt_light_desc rt_light_desc_default(void)
{
    rt_light_desc d;
    memset(&d, 0, sizeof d);
    d.struct_size = sizeof d;
    d.direction = (rt_vec3){0.0f, -1.0f, 0.0f};
    d.radius = 1.0f;
    d.color = (rt_vec3){1.0f, 1.0f, 1.0f};
    d.intensity = 1.0f;
    return d;
}

static rt_status check(rt_context *ctx, const char *call, const rt_light_desc *d)
{
    rt_status status = RT_OK;
    if ((uint32_t)d->type > RT_LIGHT_DIRECTIONAL)
        return rti_fail(ctx, RT_ERROR_ARGUMENT,
                        "%s: type is %u; it must be RT_LIGHT_POINT (0), RT_LIGHT_SPHERE (1) or RT_LIGHT_DIRECTIONAL (2)", call,
                        (unsigned)d->type);
    if ((uint32_t)d->falloff > RT_FALLOFF_INVERSE_SQUARE)
        return rti_fail(ctx, RT_ERROR_ARGUMENT,
                        "%s: falloff is %u; it must be RT_FALLOFF_NONE (0) or RT_FALLOFF_INVERSE_SQUARE (1)", call,
                        (unsigned)d->falloff);
    if (d->type == RT_LIGHT_DIRECTIONAL)
        status = rti_check_direction(ctx, call, "direction", d->direction);
    else
        status = rti_check_point(ctx, call, "at", d->at);
    if (status == RT_OK && d->type == RT_LIGHT_SPHERE)
        status = rti_check_positive(ctx, call, "radius", d->radius);
    if (status == RT_OK)
        status = rti_check_color(ctx, call, "color", d->color, RTI_COORD_MAX);
    if (status == RT_OK)
        status = rti_check_range(ctx, call, "intensity", d->intensity, 0.0f, RTI_COORD_MAX);
    if (status == RT_OK && d->samples > 65536)
        status = rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: samples is %u; it must be at most 65536", call, d->samples);
    return status;
}

static rti_light record(const rt_light_desc *d)
{
    rti_light l;
    rtk_light *k = &l.light;
    rti_fpenv env = rti_fp_enter();
    memset(&l, 0, sizeof l);
    l.alive = true;
    l.visible = d->type == RT_LIGHT_SPHERE && d->visible;
    k->type = (rtk_u32)d->type;
    if (d->type == RT_LIGHT_DIRECTIONAL) {
        double x = d->direction.x, y = d->direction.y, z = d->direction.z, s = sqrt(x * x + y * y + z * z);
        k->at[0] = (float)(x / s);
        k->at[1] = (float)(y / s);
        k->at[2] = (float)(z / s);
    } else {
        memcpy(k->at, &d->at, sizeof k->at);
    }
    k->radius = d->type == RT_LIGHT_SPHERE ? d->radius : 0.0f;
    k->color[0] = d->color.x * d->intensity;
    k->color[1] = d->color.y * d->intensity;
    k->color[2] = d->color.z * d->intensity;
    k->falloff = d->falloff == RT_FALLOFF_INVERSE_SQUARE && d->type != RT_LIGHT_DIRECTIONAL ? 2.0f : 0.0f;
    k->samples = d->samples;
    k->geom = RTK_INVALID;
    RTI_FP_HOLD(l);
    rti_fp_leave(env);
    return l;
}

static rt_status take(const rt_scene *scene, const char *call, const rt_light_desc *desc, rti_light *out)
{
    rt_light_desc d = rt_light_desc_default();
    rt_status status = rti_scene_editable(scene, call);
    if (status == RT_OK)
        status = rti_desc_take(scene->ctx, call, desc, &d, sizeof d);
    if (status == RT_OK)
        status = check(scene->ctx, call, &d);
    if (status == RT_OK)
        *out = record(&d);
    return status;
}

rt_status rt_scene_add_light(rt_scene *scene, const rt_light_desc *desc, rt_light *light)
{
    static const char call[] = "rt_scene_add_light";
    rti_light l, *slot = NULL;
    rt_status status = take(scene, call, desc, &l);
    if (status != RT_OK)
        return status;
    if (scene->lights.count >= RTI_MAX_PRIMS)
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: the scene has %zu lights, and no more fit", call,
                        scene->lights.count);
    slot = rti_array_push(scene->ctx, &scene->lights, sizeof *slot);
    if (!slot)
        return rti_array_refused(scene->ctx, call, &scene->lights, 1, sizeof *slot);
    *slot = l;
    scene->geometry_changed |= l.visible;
    if (light)
        light->id = (uint32_t)(scene->lights.count - 1);
    return RT_OK;
}

static rt_status find(rt_scene *scene, const char *call, rt_light light, rti_light **out)
{
    if (light.id >= scene->lights.count)
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: light %u is not one of the scene", call, light.id);
    *out = RTI_AT(scene->lights, rti_light, light.id);
    if (!(*out)->alive)
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: light %u was removed", call, light.id);
    return RT_OK;
}

rt_status rt_scene_set_light(rt_scene *scene, rt_light light, const rt_light_desc *desc)
{
    static const char call[] = "rt_scene_set_light";
    rti_light l, *slot = NULL;
    rt_status status = take(scene, call, desc, &l);
    if (status == RT_OK)
        status = find(scene, call, light, &slot);
    if (status != RT_OK)
        return status;
    scene->geometry_changed |= l.visible || slot->visible;
    *slot = l;
    return RT_OK;
}

rt_status rt_scene_remove_light(rt_scene *scene, rt_light light)
{
    static const char call[] = "rt_scene_remove_light";
    rti_light *slot = NULL;
    rt_status status = rti_scene_editable(scene, call);
    if (status == RT_OK)
        status = find(scene, call, light, &slot);
    if (status != RT_OK)
        return status;
    scene->geometry_changed |= slot->visible;
    slot->alive = false;
    slot->visible = false;
    return RT_OK;
}

rt_world_desc rt_world_desc_default(void)
{
    rt_world_desc d;
    memset(&d, 0, sizeof d);
    d.struct_size = sizeof d;
    d.background_texture.id = RT_INVALID_ID;
    return d;
}

rt_status rt_scene_set_world(rt_scene *scene, const rt_world_desc *desc)
{
    static const char call[] = "rt_scene_set_world";
    rt_world_desc d = rt_world_desc_default();
    rtk_world *w;
    rt_status status = rti_scene_editable(scene, call);
    if (status == RT_OK)
        status = rti_desc_take(scene->ctx, call, desc, &d, sizeof d);
    if (status == RT_OK)
        status = rti_check_color(scene->ctx, call, "ambient", d.ambient, 1.0e6f);
    if (status == RT_OK)
        status = rti_check_color(scene->ctx, call, "background", d.background, 1.0e6f);
    if (status == RT_OK)
        status = rti_check_color(scene->ctx, call, "background_top", d.background_top, 1.0e6f);
    if (status == RT_OK)
        status = rti_check_texture(scene, call, "background_texture", d.background_texture.id);
    if (status != RT_OK)
        return status;
    w = &scene->world;
    memcpy(w->ambient, &d.ambient, sizeof w->ambient);
    memcpy(w->background, &d.background, sizeof w->background);
    memcpy(w->background_top, &d.background_top, sizeof w->background_top);
    w->background_tex = d.background_texture.id;
    return RT_OK;
}
