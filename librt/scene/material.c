/* Materials: descriptor -> kernel record. */
#include "scene.h"

#include <string.h>

rt_material_desc rt_material_desc_default(void)
{
    rt_material_desc d;
    memset(&d, 0, sizeof d);
    d.struct_size = sizeof d;
    d.color = (rt_vec3){1.0f, 1.0f, 1.0f};
    d.diffusion = 1.0f;
    d.refractiveness = 1.0f;
    d.ambient = 1.0f;
    d.shininess = 50.0f;
    d.color_texture.id = RT_INVALID_ID;
    d.alpha_texture.id = RT_INVALID_ID;
    d.alpha_cut = 0.5f;
    return d;
}

static rt_status check(const rt_scene *scene, const char *call, const rt_material_desc *d)
{
    rt_context *ctx = scene->ctx;
    const struct {
        const char *field;
        float value, low, high;
    } range[] = {{"diffusion", d->diffusion, 0.0f, 1.0f},       {"reflectiveness", d->reflectiveness, 0.0f, 1.0f},
                 {"transparency", d->transparency, 0.0f, 1.0f}, {"refractiveness", d->refractiveness, 0.0f, 1000.0f},
                 {"ambient", d->ambient, 0.0f, 1.0f},           {"specular", d->specular, 0.0f, 1.0e6f},
                 {"shininess", d->shininess, 1.0f, 100000.0f},  {"alpha_cut", d->alpha_cut, 0.0f, 1.0f}};
    rt_status status;
    if ((uint32_t)d->type > RT_MATERIAL_EMISSIVE)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: type is %u; it must be RT_MATERIAL_CLASSIC (0) or RT_MATERIAL_EMISSIVE (1)",
                        call, (unsigned)d->type);
    if ((status = rti_check_color(ctx, call, "color", d->color, 1.0f)) != RT_OK)
        return status;
    for (size_t i = 0; i < RTI_COUNT(range); i++) {
        if ((status = rti_check_range(ctx, call, range[i].field, range[i].value, range[i].low, range[i].high)) != RT_OK)
            return status;
    }
    if ((status = rti_check_color(ctx, call, "emission", d->emission, RTI_COORD_MAX)) != RT_OK)
        return status;
    if ((status = rti_check_texture(scene, call, "color_texture", d->color_texture.id)) != RT_OK)
        return status;
    return rti_check_texture(scene, call, "alpha_texture", d->alpha_texture.id);
}

static rtk_material record(const rt_material_desc *d)
{
    rtk_material m;
    memset(&m, 0, sizeof m);
    m.type = d->type == RT_MATERIAL_EMISSIVE ? RTK_MATERIAL_EMISSIVE : RTK_MATERIAL_CLASSIC;
    if (d->type == RT_MATERIAL_CLASSIC && d->transparency > 0.0f)
        m.flags |= RTK_MAT_TRANSPARENT;
    if (d->opaque_shadow)
        m.flags |= RTK_MAT_OPAQUE_SHADOW;
    memcpy(m.color, &d->color, sizeof m.color);
    m.diffusion = d->diffusion;
    m.reflectiveness = d->reflectiveness;
    m.transparency = d->transparency;
    m.refractiveness = d->refractiveness;
    m.ambient = d->ambient;
    m.specular = d->specular;
    m.shininess = d->shininess;
    memcpy(m.emission, &d->emission, sizeof m.emission);
    m.color_tex = d->color_texture.id;
    m.alpha_tex = d->alpha_texture.id;
    m.alpha_cut = d->alpha_cut;
    return m;
}

static rt_status take(const rt_scene *scene, const char *call, const rt_material_desc *desc, rtk_material *out)
{
    rt_material_desc d = rt_material_desc_default();
    rt_status status = rti_scene_editable(scene, call);
    if (status == RT_OK)
        status = rti_desc_take(scene->ctx, call, desc, &d, sizeof d);
    if (status == RT_OK)
        status = check(scene, call, &d);
    if (status == RT_OK)
        *out = record(&d);
    return status;
}

rt_status rt_scene_add_material(rt_scene *scene, const rt_material_desc *desc, rt_material *material)
{
    static const char call[] = "rt_scene_add_material";
    rtk_material m, *slot;
    rt_status status = take(scene, call, desc, &m);
    if (status != RT_OK)
        return status;
    if (scene->materials.count >= RTI_MAX_PRIMS)
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: the scene has %zu materials, and no more fit", call,
                        scene->materials.count);
    slot = rti_array_push(scene->ctx, &scene->materials, sizeof *slot);
    if (!slot)
        return rti_array_refused(scene->ctx, call, &scene->materials, 1, sizeof *slot);
    *slot = m;
    if (material)
        material->id = (uint32_t)(scene->materials.count - 1);
    return RT_OK;
}

rt_status rt_scene_set_material(rt_scene *scene, rt_material material, const rt_material_desc *desc)
{
    static const char call[] = "rt_scene_set_material";
    rtk_material m;
    rt_status status = take(scene, call, desc, &m);
    if (status == RT_OK)
        status = rti_check_material(scene, call, "material", material.id);
    if (status == RT_OK)
        *RTI_AT(scene->materials, rtk_material, material.id) = m;
    return status;
}
