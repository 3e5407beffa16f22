#include "looks.h"

#include <string.h>

/* name as seen from the folder of path; absolute ones stay. NULL: no memory. */
static const char *beside(rti_model *model, const char *path, const char *name, size_t n)
{
    const char *slash = strrchr(path, '/');
    size_t folder = slash && name[0] != '/' ? (size_t)(slash - path) + 1 : 0, total;
    char *text = rti_add_size(folder, n + 1, &total) ? rti_arena_alloc(&model->arena, total) : NULL;
    if (!text)
        return NULL;
    memcpy(text, path, folder);
    for (size_t i = 0; i < n; i++)
        text[folder + i] = name[i] == '\\' ? '/' : name[i];
    text[folder + n] = '\0';
    return text;
}

/* *missing: it cannot be read, which is no error yet. */
static rt_status read_library(rti_model *model, const char *path, const char *name, size_t n, bool *missing)
{
    void *bytes;
    size_t size;
    const char *file = beside(model, path, name, n);
    if (!file)
        return rti_fail_memory(model->ctx, model->name, n);
    rt_status status = rti_file_read(model->ctx, file, 0, &bytes, &size);
    *missing = status == RT_ERROR_IO;
    if (status)
        return *missing ? RT_OK : status;
    status = rti_mtl_read(model, file, bytes, size);
    rti_free(model->ctx, bytes, size + 1);
    return status;
}

/* What the thread's last message says, for a warning. */
static const char *reason(rti_model *model, char *text, size_t size)
{
    text[0] = '\0';
    rt_context_error(model->ctx, text, size);
    return text;
}

/* "mtllib a b.mtl" is one file with a space in its name, or else two. */
static rt_status read_libraries(rti_model *model, const char *path, const char *names)
{
    char why[400];
    bool missing = false;
    rt_status status = read_library(model, path, names, strlen(names), &missing);
    if (status || !missing)
        return status;
    reason(model, why, sizeof why);
    if (!strchr(names, ' ')) {
        rti_model_warn(model, "the material library is missing: %s", why);
        return RT_OK;
    }
    while (*names && !status) {
        size_t n = strcspn(names, " ");
        if (n)
            status = read_library(model, path, names, n, &missing);
        if (n && !status && missing)
            rti_model_warn(model, "the material library is missing: %s", reason(model, why, sizeof why));
        names += n + (names[n] == ' ');
    }
    return status;
}

rt_status rti_looks_read(rti_model *model, const char *path)
{
    rt_status status = RT_OK;
    uint32_t undefined = 0;
    const char *first = NULL;
    if (model->look_count == 0)
        return RT_OK;
    for (size_t i = 0; i < model->library_count && !status; i++)
        status = read_libraries(model, path, model->libraries[i]);
    for (size_t i = 0; i < model->look_count && !status; i++) {
        if (!model->looks[i].defined) {
            first = undefined ? first : model->looks[i].name;
            undefined++;
        }
    }
    if (undefined) {
        char text[100];
        rti_model_warn(model, "no material library defines '%s'%s; the default material is used",
                       rti_quote(text, sizeof text, first, strlen(first)), undefined > 1 ? " and others" : "");
    }
    return status;
}

static float mean(const float c[3])
{
    return (c[0] + c[1] + c[2]) / 3.0f;
}

rt_material_desc rti_look_material(const rti_look *k)
{
    rt_material_desc d = rt_material_desc_default();
    bool black = k->diffuse[0] == 0 && k->diffuse[1] == 0 && k->diffuse[2] == 0;
    bool mirror = k->illum >= 3 && k->illum <= 9, bends = k->illum == 4 || k->illum == 6 || k->illum == 7 || k->illum == 9;
    if (mean(k->emission) > 0) {
        d.type = RT_MATERIAL_EMISSIVE;
        d.emission = (rt_vec3){k->emission[0], k->emission[1], k->emission[2]};
        return d;
    }
    d.color = black && k->diffuse_map ? (rt_vec3){1, 1, 1} : (rt_vec3){k->diffuse[0], k->diffuse[1], k->diffuse[2]};
    d.transparency = 1 - k->opacity;
    d.reflectiveness = mirror ? mean(k->specular) : 0.0f;
    if (d.reflectiveness > 1 - d.transparency)
        d.reflectiveness = 1 - d.transparency;
    d.diffusion = 1 - d.transparency - d.reflectiveness;
    if (d.diffusion < 0)
        d.diffusion = 0;
    if (black && !k->diffuse_map && d.transparency > 0) { /* d lets the background through as it is: black would be its tint */
        d.color = (rt_vec3){1, 1, 1};
        d.diffusion = 0;
    }
    d.ambient = d.diffusion; /* it stands for light that surfaces scatter, as glass and mirrors do not */
    d.refractiveness = bends ? k->refraction : 1.0f;
    d.specular = k->illum == 0 || k->illum == 1 ? 0.0f : mean(k->specular);
    d.shininess = k->shininess < 1 ? 1.0f : k->shininess;
    return d;
}

/* A texture that cannot be had is a warning; memory that cannot is not. */
static rt_status add_texture(rt_scene *scene, rti_model *model, const char *path, const char *name, bool linear,
                             rt_texture *texture)
{
    rt_texture_desc d = rt_texture_desc_default();
    char why[400];
    d.linear = linear;
    if (!name)
        return RT_OK;
    const char *file = beside(model, path, name, strlen(name));
    if (!file)
        return rti_fail_memory(model->ctx, model->name, strlen(name));
    rt_texture got;
    rt_status status = rt_scene_load_texture(scene, file, &d, &got);
    if (status == RT_ERROR_IO || status == RT_ERROR_FORMAT || status == RT_ERROR_UNSUPPORTED || status == RT_ERROR_ARGUMENT) {
        rti_model_warn(model, "a texture is left out: %s", reason(model, why, sizeof why));
        return RT_OK;
    }
    if (!status)
        *texture = got;
    return status;
}

rt_status rti_looks_add(rt_scene *scene, rti_model *model, const char *path, rt_material *materials)
{
    rt_status status = RT_OK;
    for (size_t i = 0; i < model->look_count && !status; i++) {
        const rti_look *k = &model->looks[i];
        materials[i] = (rt_material){0};
        if (!k->defined)
            continue;
        rt_material_desc d = rti_look_material(k);
        status = add_texture(scene, model, path, k->diffuse_map, false, &d.color_texture);
        if (!status)
            status = add_texture(scene, model, path, k->opacity_map, true, &d.alpha_texture);
        if (!status)
            status = rt_scene_add_material(scene, &d, &materials[i]);
    }
    return status;
}
