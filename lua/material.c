#include "binding.h"

/* Textures and materials: descriptions made by lua/rt/material.lua become ids of a scene. */

static rt_texture_desc texture_fields(lua_State *L, int t)
{
    static const char *const wraps[] = {"repeat", "clamp", NULL};
    rt_texture_desc d = rt_texture_desc_default();
    int wrap = (int)d.wrap;
    rtl_field_choice(L, t, "wrap", wraps, &wrap);
    d.wrap = (rt_wrap)wrap;
    rtl_field_bool(L, t, "linear", &d.linear);
    rtl_field_bool(L, t, "nearest", &d.nearest);
    return d;
}

/* texture_load(scene, path, fields) -> id */
static int texture_load(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    const char *path = rtl_check_path(L, 2);
    rt_texture_desc d = texture_fields(L, 3);
    rt_texture id;
    rtl_check(L, c, rt_scene_load_texture(scene, path, &d, &id));
    lua_pushinteger(L, id.id);
    return 1;
}

/* texture_image(scene, image, fields) -> id */
static int texture_image(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_image *image = rtl_check_image(L, 2, NULL);
    rt_texture_desc d = texture_fields(L, 3);
    d.width = rt_image_width(image);
    d.height = rt_image_height(image);
    d.pixels = rt_image_pixels_const(image);
    d.format = RT_PIXEL_RGBA32F;
    rt_texture id;
    rtl_check(L, c, rt_scene_add_texture(scene, &d, &id));
    lua_pushinteger(L, id.id);
    return 1;
}

/* material(scene, fields, colour texture | nil, alpha texture | nil) -> id */
static int material(lua_State *L)
{
    static const char *const types[] = {"classic", "emissive", NULL};
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_material_desc d = rt_material_desc_default();
    int type = (int)d.type;
    rtl_field_choice(L, 2, "model", types, &type);
    d.type = (rt_material_type)type;
    rtl_field_vec3(L, 2, "color", &d.color);
    rtl_field_float(L, 2, "diffusion", &d.diffusion);
    rtl_field_float(L, 2, "reflectiveness", &d.reflectiveness);
    rtl_field_float(L, 2, "transparency", &d.transparency);
    rtl_field_float(L, 2, "refractiveness", &d.refractiveness);
    rtl_field_float(L, 2, "ambient", &d.ambient);
    rtl_field_float(L, 2, "specular", &d.specular);
    rtl_field_float(L, 2, "shininess", &d.shininess);
    rtl_field_vec3(L, 2, "emission", &d.emission);
    rtl_field_float(L, 2, "alpha_cut", &d.alpha_cut);
    rtl_field_bool(L, 2, "opaque_shadow", &d.opaque_shadow);
    if (!lua_isnoneornil(L, 3)) {
        d.color_texture.id = rtl_check_u32(L, 3, "texture");
    }
    if (!lua_isnoneornil(L, 4)) {
        d.alpha_texture.id = rtl_check_u32(L, 4, "alpha texture");
    }
    rt_material id;
    rtl_check(L, c, rt_scene_add_material(scene, &d, &id));
    lua_pushinteger(L, id.id);
    return 1;
}

void rtl_open_material(lua_State *L)
{
    static const luaL_Reg functions[] = {
        {"texture_load", texture_load}, {"texture_image", texture_image}, {"material", material}, {NULL, NULL}};
    rtl_add_functions(L, functions);
}
