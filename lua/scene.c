#include "binding.h"

#include <string.h>

/* The handle of a scene; the Lua part wraps it with the objects' bookkeeping (lua/rt/scene.lua). */
typedef struct handle {
    rt_scene *scene;
    rtl_context *context;
} handle;

static rt_scene *use(lua_State *L, const handle *h)
{
    if (!h->scene) {
        rtl_raise(L, "the scene has been released");
    }
    return h->scene;
}

rt_scene *rtl_check_scene(lua_State *L, int arg, rtl_context **context)
{
    handle *h = luaL_checkudata(L, arg, RTL_SCENE);
    rt_scene *scene = use(L, h);
    if (context) {
        *context = h->context;
    }
    return scene;
}

rt_scene *rtl_field_scene(lua_State *L, int index, const char *key)
{
    lua_getfield(L, index, key);
    rt_scene *scene = use(L, luaL_checkudata(L, -1, RTL_SCENE));
    lua_pop(L, 1);
    return scene;
}

static handle *new_handle(lua_State *L)
{
    rtl_context *c = rtl_context_get(L);
    handle *h = lua_newuserdatauv(L, sizeof *h, 0);
    h->scene = NULL;
    h->context = NULL;
    luaL_setmetatable(L, RTL_SCENE);
    h->context = rtl_context_keep(c);
    return h;
}

static int create(lua_State *L)
{
    handle *h = new_handle(L);
    rtl_check(L, h->context, rt_scene_create(rtl_context_rt(h->context), &h->scene));
    return 1;
}

static int load(lua_State *L)
{
    const char *path = rtl_check_path(L, 1);
    handle *h = new_handle(L);
    rtl_check(L, h->context, rt_scene_load(rtl_context_rt(h->context), path, &h->scene));
    rt_scene_info info;
    if (rt_scene_get_info(h->scene, &info) == RT_OK) {
        rtl_account(L, info.total_bytes);
    }
    return 1;
}

static int release(lua_State *L)
{
    handle *h = luaL_checkudata(L, 1, RTL_SCENE);
    rt_scene_destroy(h->scene);
    rtl_context_drop(h->context);
    h->scene = NULL;
    h->context = NULL;
    return 0;
}

static int to_string(lua_State *L)
{
    handle *h = luaL_checkudata(L, 1, RTL_SCENE);
    lua_pushfstring(L, h->scene ? "rt.scene handle: %p" : "rt.scene handle (released)", (void *)h);
    return 1;
}

static int hash(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    char text[33];
    rtl_check(L, c, rt_scene_hash(scene, text));
    lua_pushstring(L, text);
    return 1;
}

/* scene_looks(scene) -> { rest = hash, hash of the look of material 0, 1, ... } */
static int looks(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    char rest[33];
    uint32_t count = 0;
    rtl_check(L, c, rt_scene_looks_hash(scene, rest, NULL, 0, &count));
    char(*text)[33] = lua_newuserdatauv(L, (size_t)(count ? count : 1) * sizeof *text, 0);
    rtl_check(L, c, rt_scene_looks_hash(scene, NULL, text, count, NULL));
    lua_createtable(L, (int)count, 1);
    for (uint32_t i = 0; i < count; i++) {
        lua_pushstring(L, text[i]);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    lua_pushstring(L, rest);
    lua_setfield(L, -2, "rest");
    return 1;
}

static int save(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rtl_check(L, c, rt_scene_save(scene, rtl_check_path(L, 2)));
    return 0;
}

static int set_tracer(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rtl_check(L, c, rt_scene_set_tracer(scene, luaL_checkstring(L, 2)));
    return 0;
}

static int bounds(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_vec3 low, high;
    rtl_check(L, c, rt_scene_bounds(scene, &low, &high));
    if (low.x > high.x) {
        return 0; /* nothing finite is in it */
    }
    rtl_push_vec3(L, low);
    rtl_push_vec3(L, high);
    return 2;
}

/* ---- numbers about a scene ---- */

static void set_integer(lua_State *L, const char *key, uint64_t value)
{
    lua_pushinteger(L, (lua_Integer)value);
    lua_setfield(L, -2, key);
}

static void push_tree(lua_State *L, uint32_t group, const rt_tree_info *t)
{
    lua_createtable(L, 0, 13);
    lua_pushstring(L, t->name);
    lua_setfield(L, -2, "name");
    if (group == RT_INVALID_ID) {
        lua_pushliteral(L, "top");
        lua_setfield(L, -2, "group");
    } else {
        set_integer(L, "group", group);
    }
    set_integer(L, "primitives", t->primitives);
    set_integer(L, "references", t->references);
    set_integer(L, "nodes", t->nodes);
    set_integer(L, "leaves", t->leaves);
    set_integer(L, "empty_leaves", t->empty_leaves);
    set_integer(L, "bytes", t->bytes);
    set_integer(L, "depth", t->depth);
    set_integer(L, "part", t->part);
    set_integer(L, "largest_leaf", t->largest_leaf);
    lua_pushnumber(L, t->build_seconds);
    lua_setfield(L, -2, "build_seconds");
    lua_pushnumber(L, (lua_Number)t->sah_cost);
    lua_setfield(L, -2, "sah_cost");
}

static int info(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_scene_info i;
    rtl_check(L, c, rt_scene_get_info(scene, &i));
    lua_createtable(L, 0, 24);
    set_integer(L, "triangles", i.triangles);
    set_integer(L, "shapes", i.shapes);
    set_integer(L, "planes", i.planes);
    set_integer(L, "geometries", i.geometries);
    set_integer(L, "instances", i.instances);
    set_integer(L, "materials", i.materials);
    set_integer(L, "textures", i.textures);
    set_integer(L, "lights", i.lights);
    set_integer(L, "geometry_bytes", i.geometry_bytes);
    set_integer(L, "attribute_bytes", i.attribute_bytes);
    set_integer(L, "texture_bytes", i.texture_bytes);
    set_integer(L, "tree_bytes", i.tree_bytes);
    set_integer(L, "total_bytes", i.total_bytes);
    set_integer(L, "reused_chunks", i.reused_chunks);
    set_integer(L, "built_trees", i.built_trees);
    set_integer(L, "built_top_trees", i.built_top_trees);
    set_integer(L, "kept_trees", i.kept_trees);
    set_integer(L, "refitted_trees", i.refitted_trees);
    rt_motion_info m;
    rtl_check(L, c, rt_scene_get_motion_info(scene, &m));
    set_integer(L, "moving_instances", m.moving_instances);
    set_integer(L, "motion_places", m.places);
    lua_pushboolean(L, m.camera_moves);
    lua_setfield(L, -2, "camera_moves");
    lua_pushnumber(L, (lua_Number)m.shutter_open);
    lua_setfield(L, -2, "shutter_open");
    lua_pushnumber(L, (lua_Number)m.shutter_close);
    lua_setfield(L, -2, "shutter_close");
    lua_createtable(L, (int)i.tree_count, 0);
    for (uint32_t k = 0; k < i.tree_count; k++) {
        uint32_t group;
        rt_tree_info tree;
        rtl_check(L, c, rt_scene_get_tree_info(scene, k, &group, &tree));
        push_tree(L, group, &tree);
        lua_rawseti(L, -2, (lua_Integer)k + 1);
    }
    lua_setfield(L, -2, "trees");
    return 1;
}

void rtl_open_scene(lua_State *L)
{
    static const luaL_Reg methods[] = {{NULL, NULL}};
    static const luaL_Reg functions[] = {{"scene", create},    {"scene_load", load},     {"scene_release", release},
                                         {"scene_hash", hash}, {"scene_looks", looks},   {"scene_save", save},
                                         {"scene_info", info}, {"scene_bounds", bounds}, {"scene_tracer", set_tracer},
                                         {NULL, NULL}};
    rtl_class(L, RTL_SCENE, methods, release, to_string);
    rtl_add_functions(L, functions);
}
