#include "binding.h"

#include <string.h>

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

static rt_camera_desc camera_fields(lua_State *L, int t)
{
    rt_camera_desc d = rt_camera_desc_default();
    int type = (int)d.type;
    rtl_field_choice(L, t, "projection", PROJECTIONS, &type);
    d.type = (rt_camera_type)type;
    rtl_field_vec3(L, t, "eye", &d.eye);
    rtl_field_vec3(L, t, "look_at", &d.look_at);
    rtl_field_vec3(L, t, "up", &d.up);
    rtl_field_float(L, t, "fov", &d.fov_deg);
    rtl_field_float(L, t, "height", &d.height);
    rtl_field_float(L, t, "aperture", &d.aperture);
    rtl_field_float(L, t, "focus_distance", &d.focus_distance);
    rtl_field_u32(L, t, "blades", &d.blades);
    rtl_field_float(L, t, "blade_rotation", &d.blade_rotation_deg);
    rtl_field_float(L, t, "shutter_open", &d.shutter_open);
    rtl_field_float(L, t, "shutter_close", &d.shutter_close);
    return d;
}

/* set_camera(scene, camera, camera at the end of its way | nil) */
static int set_camera(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_camera_desc d = camera_fields(L, 2);
    rtl_check(L, c, rt_scene_set_camera(scene, &d));
    if (!lua_isnoneornil(L, 3)) {
        d = camera_fields(L, 3);
        rtl_check(L, c, rt_scene_set_camera_motion(scene, &d));
    }
    return 0;
}

static void set_number(lua_State *L, const char *key, float value)
{
    lua_pushnumber(L, (lua_Number)value);
    lua_setfield(L, -2, key);
}

/* What may differ along a camera's way. */
static void push_way(lua_State *L, const rt_camera_desc *d)
{
    lua_createtable(L, 0, 12);
    rtl_push_vec3(L, d->eye);
    lua_setfield(L, -2, "eye");
    rtl_push_vec3(L, d->look_at);
    lua_setfield(L, -2, "look_at");
    rtl_push_vec3(L, d->up);
    lua_setfield(L, -2, "up");
    set_number(L, "fov", d->fov_deg);
    set_number(L, "height", d->height);
    set_number(L, "aperture", d->aperture);
    if (d->focus_distance > 0.0f) {
        set_number(L, "focus_distance", d->focus_distance);
    }
}

static int get_camera(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_camera_desc d = rt_camera_desc_default(), end = d;
    rtl_check(L, c, rt_scene_get_camera(scene, &d));
    rtl_check(L, c, rt_scene_get_camera_motion(scene, &end));
    push_way(L, &d);
    lua_pushstring(L, PROJECTIONS[d.type == RT_CAMERA_ORTHOGRAPHIC]);
    lua_setfield(L, -2, "projection");
    lua_pushinteger(L, d.blades);
    lua_setfield(L, -2, "blades");
    set_number(L, "blade_rotation", d.blade_rotation_deg);
    lua_createtable(L, 2, 0);
    lua_pushnumber(L, (lua_Number)d.shutter_open);
    lua_rawseti(L, -2, 1);
    lua_pushnumber(L, (lua_Number)d.shutter_close);
    lua_rawseti(L, -2, 2);
    lua_setfield(L, -2, "shutter");
    if (memcmp(&d, &end, sizeof d) != 0) {
        push_way(L, &end);
        lua_setfield(L, -2, "motion");
    }
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
