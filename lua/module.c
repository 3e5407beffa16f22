#include "binding.h"

#include <errno.h>
#include <limits.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* luaopen_rt: the module's C part becomes "rt.core", its Lua files stand in package.preload as "rt.NAME". They are part of the
 * binary, so that module and program work from wherever they lie. */

static int load_file(lua_State *L)
{
    const rtl_file *f = lua_touserdata(L, lua_upvalueindex(1));
    char chunk[128] = "=";
    size_t n = 1;
    for (const char *p = f->name; *p && n < sizeof chunk - 5; p++) { /* rt.check is shown as rt/check.lua */
        chunk[n++] = *p;
        if (*p == '.') {
            chunk[n - 1] = '/';
        }
    }
    memcpy(chunk + n, ".lua", 5);
    if (luaL_loadbufferx(L, (const char *)f->text, f->size, chunk, "t") != LUA_OK) {
        return lua_error(L);
    }
    lua_insert(L, 1);
    lua_call(L, lua_gettop(L) - 1, 1);
    return 1;
}

static void preload(lua_State *L)
{
    luaL_getsubtable(L, LUA_REGISTRYINDEX, LUA_PRELOAD_TABLE);
    for (const rtl_file *f = rtl_files; f->name; f++) {
        lua_pushlightuserdata(L, (void *)f);
        lua_pushcclosure(L, load_file, 1);
        lua_setfield(L, -2, f->name);
    }
    lua_pop(L, 1);
}

/* cwd() -> the folder the program runs in */
static int cwd(lua_State *L)
{
    char path[PATH_MAX];
    if (!getcwd(path, sizeof path)) {
        return rtl_raise(L, "the current folder is not known: %s", strerror(errno));
    }
    lua_pushstring(L, path);
    return 1;
}

/* clock() -> seconds since some point in time */
static int clock_seconds(lua_State *L)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    lua_pushnumber(L, (lua_Number)t.tv_sec + (lua_Number)t.tv_nsec * 1e-9);
    return 1;
}

/* where() -> "file:line: " of the script's function that runs, or "" */
static int where(lua_State *L)
{
    rtl_where(L);
    return 1;
}

/* place() -> the same, or nil when a tail call took the script's function from the stack: cheap, for each description keeps its
 * own */
static int place(lua_State *L)
{
    return rtl_place(L);
}

/* on_lost_place(f): f() gives the place when a tail call took the script's function from the stack */
static int on_lost_place(lua_State *L)
{
    lua_settop(L, 1);
    lua_rawsetp(L, LUA_REGISTRYINDEX, &rtl_lost_place);
    return 0;
}

static void open_core(lua_State *L)
{
    static const luaL_Reg functions[] = {{"cwd", cwd},     {"clock", clock_seconds},         {"where", where},
                                         {"place", place}, {"on_lost_place", on_lost_place}, {NULL, NULL}};
    luaL_newlib(L, functions);
    rtl_open_common(L);
    rtl_open_context(L);
    rtl_open_buffer(L);
    rtl_open_scene(L);
    rtl_open_commit(L);
    rtl_open_material(L);
    rtl_open_geometry(L);
    rtl_open_world(L);
    rtl_open_query(L);
    rtl_open_image(L);
    rtl_open_draw(L);
    rtl_open_job(L);
    rtl_open_look(L);
    rtl_open_render_file(L);
    rtl_open_maths(L);
    rtl_open_folder(L);
    rtl_open_image_bytes(L);
    rtl_open_image_compare(L);
    rtl_open_process(L);
    luaL_getsubtable(L, LUA_REGISTRYINDEX, LUA_LOADED_TABLE);
    lua_pushvalue(L, -2);
    lua_setfield(L, -2, "rt.core");
    lua_pop(L, 2);
}

RT_API int luaopen_rt(lua_State *L)
{
    luaL_checkversion(L);
    open_core(L);
    preload(L);
    lua_getglobal(L, "require");
    lua_pushliteral(L, "rt.init");
    lua_call(L, 1, 1);
    return 1;
}
