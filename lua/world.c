#include "binding.h"

/* Lights, surroundings, camera. */

static int light(lua_State *L)
{
    static const char *const types[] = {"point", "sphere", "directional", NULL};
    static const char *const falloffs[] = {"none", "inverse_square", NULL};
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_light_desc d = rt_light_desc_default();
    int type = (int)d.type, falloff = (int)d.falloff;
    rtl_field_choice(L, 2, "light", types, &type);
    rtl_field_choice(L, 2, "falloff", falloffs, &falloff);
    d.type = (rt_light_type)type;
    d.falloff = (rt_falloff)falloff;
    rtl_field_vec3(L, 2, "at", &d.at);
    rtl_field_vec3(L, 2, "direction", &d.direction);
    rtl_field_float(L, 2, "radius", &d.radius);
    rtl_field_vec3(L, 2, "color", &d.color);
    rtl_field_float(L, 2, "intensity", &d.intensity);
    rtl_field_bool(L, 2, "visible", &d.visible);
    rtl_field_u32(L, 2, "samples", &d.samples);
    rt_light id;
    rtl_check(L, c, rt_scene_add_light(scene, &d, &id));
    lua_pushinteger(L, id.id);
    return 1;
}

/* set_world(scene, {ambient, background, background_top}, texture id | nil) */
static int set_world(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_world_desc d = rt_world_desc_default();
    rtl_field_vec3(L, 2, "ambient", &d.ambient);
    if (rtl_field_vec3(L, 2, "background", &d.background)) {
        d.background_top = d.background;
    }
    rtl_field_vec3(L, 2, "background_top", &d.background_top);
    if (!lua_isnoneornil(L, 3)) {
        d.background_texture.id = rtl_check_u32(L, 3, "texture");
    }
    rtl_check(L, c, rt_scene_set_world(scene, &d));
    return 0;
}

static const char *const PROJECTIONS[] = {"pinhole", "orthographic", NULL};

static int set_camera(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_camera_desc d = rt_camera_desc_default();
    int type = (int)d.type;
    rtl_field_choice(L, 2, "projection", PROJECTIONS, &type);
    d.type = (rt_camera_type)type;
    rtl_field_vec3(L, 2, "eye", &d.eye);
    rtl_field_vec3(L, 2, "look_at", &d.look_at);
    rtl_field_vec3(L, 2, "up", &d.up);
    rtl_field_float(L, 2, "fov", &d.fov_deg);
    rtl_field_float(L, 2, "height", &d.height);
    rtl_check(L, c, rt_scene_set_camera(scene, &d));
    return 0;
}

static int get_camera(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_camera_desc d;
    rtl_check(L, c, rt_scene_get_camera(scene, &d));
    lua_createtable(L, 0, 6);
    lua_pushstring(L, PROJECTIONS[d.type == RT_CAMERA_ORTHOGRAPHIC]);
    lua_setfield(L, -2, "projection");
    rtl_push_vec3(L, d.eye);
    lua_setfield(L, -2, "eye");
    rtl_push_vec3(L, d.look_at);
    lua_setfield(L, -2, "look_at");
    rtl_push_vec3(L, d.up);
    lua_setfield(L, -2, "up");
    lua_pushnumber(L, (lua_Number)d.fov_deg);
    lua_setfield(L, -2, "fov");
    lua_pushnumber(L, (lua_Number)d.height);
    lua_setfield(L, -2, "height");
    return 1;
}

static int frame_camera(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rtl_check(L, c, rt_scene_frame_camera(scene, (float)luaL_checknumber(L, 2)));
    return 0;
}

void rtl_open_world(lua_State *L)
{
    static const luaL_Reg functions[] = {{"add_light", light},       {"set_world", set_world},       {"set_camera", set_camera},
                                         {"get_camera", get_camera}, {"frame_camera", frame_camera}, {NULL, NULL}};
    rtl_add_functions(L, functions);
}
