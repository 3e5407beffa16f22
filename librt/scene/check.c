/* Checks of arguments. Every refusal names the call, the field, the value and what it must be. */
#include "scene.h"

#include <math.h>
#include <string.h>

#define NUM 32

rt_status rti_check_range(rt_context *ctx, const char *call, const char *field, float x, float low, float high)
{
    char a[NUM], b[NUM], c[NUM];
    if (x >= low && x <= high)
        return RT_OK;
    return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: %s is %s; it must be from %s to %s", call, field, rti_num(a, x), rti_num(b, low),
                    rti_num(c, high));
}

rt_status rti_check_positive(rt_context *ctx, const char *call, const char *field, float x)
{
    char a[NUM], b[NUM];
    if (x > 0.0f && x <= RTI_COORD_MAX)
        return RT_OK;
    return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: %s is %s; it must be greater than 0 and at most %s", call, field, rti_num(a, x),
                    rti_num(b, RTI_COORD_MAX));
}

static const char *vec_text(char *buffer, size_t size, rt_vec3 p)
{
    char a[NUM], b[NUM], c[NUM];
    snprintf(buffer, size, "(%s, %s, %s)", rti_num(a, p.x), rti_num(b, p.y), rti_num(c, p.z));
    return buffer;
}

static bool within(rt_vec3 p, float high)
{
    return fabsf(p.x) <= high && fabsf(p.y) <= high && fabsf(p.z) <= high;
}

rt_status rti_check_point(rt_context *ctx, const char *call, const char *field, rt_vec3 p)
{
    char text[4 * NUM], high[NUM];
    if (within(p, RTI_COORD_MAX))
        return RT_OK;
    return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: %s is %s; its coordinates must be numbers of size %s at most", call, field,
                    vec_text(text, sizeof text, p), rti_num(high, RTI_COORD_MAX));
}

rt_status rti_check_direction(rt_context *ctx, const char *call, const char *field, rt_vec3 d)
{
    char text[4 * NUM];
    if (within(d, 3.0e38f) && (d.x != 0.0f || d.y != 0.0f || d.z != 0.0f))
        return RT_OK;
    return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: %s is %s; it must be finite and not zero", call, field,
                    vec_text(text, sizeof text, d));
}

rt_status rti_check_color(rt_context *ctx, const char *call, const char *field, rt_vec3 c, float high)
{
    char text[4 * NUM], most[NUM];
    if (c.x >= 0.0f && c.y >= 0.0f && c.z >= 0.0f && within(c, high))
        return RT_OK;
    return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: %s is %s; its parts must be from 0 to %s", call, field,
                    vec_text(text, sizeof text, c), rti_num(most, high));
}

rt_status rti_check_floats(rt_context *ctx, const char *call, const char *field, const float *x, size_t count, unsigned width,
                           float high)
{
    char a[NUM], b[NUM];
    size_t n = count * width;
    for (size_t i = 0; i < n; i++) {
        if (!(fabsf(x[i]) <= high))
            return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: %s[%zu] (part %zu) is %s; it must be a number of size %s at most", call,
                            field, i / width, i % width, rti_num(a, x[i]), rti_num(b, high));
    }
    return RT_OK;
}

rt_status rti_check_material(const rt_scene *scene, const char *call, const char *field, uint32_t id)
{
    if (id < scene->materials.count)
        return RT_OK;
    return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: %s is %u; the scene has the materials 0 to %zu", call, field, id,
                    scene->materials.count - 1);
}

rt_status rti_check_materials(const rt_scene *scene, const char *call, const char *field, const uint32_t *ids, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (ids[i] >= scene->materials.count)
            return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: %s[%zu] is %u; the scene has the materials 0 to %zu", call, field,
                            i, ids[i], scene->materials.count - 1);
    }
    return RT_OK;
}

rt_status rti_check_texture(const rt_scene *scene, const char *call, const char *field, uint32_t id)
{
    if (id == RT_INVALID_ID || id < scene->textures.count)
        return RT_OK;
    if (scene->textures.count == 0)
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: %s is %u; the scene has no textures, so it must be RT_INVALID_ID",
                        call, field, id);
    return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: %s is %u; the scene has the textures 0 to %zu", call, field, id,
                    scene->textures.count - 1);
}

rt_status rti_check_common(const rt_scene *scene, const char *call, const rt_geometry_common *common)
{
    rt_status status = rti_check_material(scene, call, "material", common->material.id);
    if (status == RT_OK)
        status = rti_check_floats(scene->ctx, call, "uv_transform", common->uv_transform, 6, 1, 1.0e9f);
    return status;
}

rti_geometry *rti_geometry_at(rt_scene *scene, const char *call, uint32_t id)
{
    rti_geometry *g = id < scene->geometries.count ? RTI_AT(scene->geometries, rti_geometry, id) : NULL;
    if (g && g->alive)
        return g;
    rti_fail(scene->ctx, RT_ERROR_ARGUMENT, g ? "%s: geometry %u was removed" : "%s: geometry %u is not one of the scene", call,
             id);
    return NULL;
}
