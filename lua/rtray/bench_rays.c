/* The ray benchmark (tests/bench/rays) for the program: its options for the table of commands, and its run. */
#include "binding.h"
#include "rtray.h"

#include "rays.h"

#include <stdlib.h>

/* bench_rays_options() -> { { name, value | nil, help }, ... }, definitions, columns */
static int options(lua_State *L)
{
    lua_newtable(L);
    for (const bench_option *row = bench_option_table; row->name; row++) {
        lua_createtable(L, 0, 3);
        lua_pushstring(L, row->name);
        lua_setfield(L, -2, "name");
        lua_pushstring(L, row->value);
        lua_setfield(L, -2, "value");
        lua_pushstring(L, row->help);
        lua_setfield(L, -2, "help");
        lua_rawseti(L, -2, (lua_Integer)(row - bench_option_table) + 1);
    }
    lua_pushstring(L, bench_definitions);
    lua_pushstring(L, bench_columns);
    return 3;
}

/* What the benchmark asks back. Lua's errors must not run through it: they are kept at `failure` and raised when it has ended. */
typedef struct asked {
    lua_State *L;
    int open, stop, failure; /* indices on the stack */
    bool failed;
} asked;

static bool call(asked *a, int function, int arguments)
{
    lua_State *L = a->L;
    lua_pushvalue(L, function);
    lua_insert(L, -1 - arguments);
    if (lua_pcall(L, arguments, 1, 0) == LUA_OK) {
        return true;
    }
    lua_replace(L, a->failure);
    a->failed = true;
    return false;
}

static int scene_of(lua_State *L)
{
    lua_pushlightuserdata(L, rtl_check_scene(L, 1, NULL));
    return 1;
}

static int open_scene(void *user, const char *name, rt_scene **scene)
{
    asked *a = user;
    lua_State *L = a->L;
    *scene = NULL;
    lua_pushstring(L, name);
    if (!call(a, a->open, 1)) {
        return BENCH_FILE;
    }
    if (lua_isnil(L, -1)) {
        lua_pop(L, 1);
        return BENCH_OK;
    }
    lua_pushcfunction(L, scene_of); /* the scene itself is kept by the caller's `open` */
    lua_insert(L, -2);
    if (lua_pcall(L, 1, 1, 0) != LUA_OK) {
        lua_replace(L, a->failure);
        a->failed = true;
        return BENCH_FILE;
    }
    *scene = lua_touserdata(L, -1);
    lua_pop(L, 1);
    return BENCH_OK;
}

static bool stop(void *user)
{
    asked *a = user;
    bool yes = !call(a, a->stop, 0) || lua_toboolean(a->L, -1);
    if (!a->failed) {
        lua_pop(a->L, 1);
    }
    return yes;
}

/* bench_rays(arguments, open(name) -> scene | nil, stop() -> boolean) -> status. [1] of the arguments is the first behind the
 * program's name. */
static int run(lua_State *L)
{
    luaL_checktype(L, 1, LUA_TTABLE);
    luaL_checktype(L, 2, LUA_TFUNCTION);
    luaL_checktype(L, 3, LUA_TFUNCTION);
    lua_settop(L, 3);
    int count = (int)luaL_len(L, 1) + 1;
    char **argv = lua_newuserdatauv(L, ((size_t)count + 1) * sizeof *argv, 0);
    argv[0] = NULL;
    argv[count] = NULL;
    luaL_checkstack(L, count + 20, NULL);
    for (int i = 1; i < count; i++) { /* the strings stay on the stack: the benchmark only reads them */
        if (lua_rawgeti(L, 1, i) != LUA_TSTRING) {
            return luaL_error(L, "argument %d of bench_rays is no string", i);
        }
        argv[i] = (char *)(uintptr_t)lua_tostring(L, -1);
    }
    lua_pushnil(L);
    asked a = {L, 2, 3, lua_gettop(L), false};
    bench_front front = {"rtray bench rays", &a, open_scene, stop};
    int status = bench_rays_main(count, argv, &front);
    if (a.failed) {
        lua_pushvalue(L, a.failure);
        return lua_error(L);
    }
    lua_pushinteger(L, status);
    return 1;
}

void rtray_open_bench_rays(lua_State *L)
{
    static const luaL_Reg functions[] = {{"bench_rays_options", options}, {"bench_rays", run}, {NULL, NULL}};
    luaL_setfuncs(L, functions, 0);
}
