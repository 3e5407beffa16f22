/* rtray: a Lua state with the module rt and the program's own Lua files; rtray.main does the rest. */
#include "binding.h"
#include "rtray.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <lualib.h>

enum { STATUS_MACHINE = 3 };

/* A loader of package.preload: compiles the embedded file in its upvalue. */
static int load_file(lua_State *L)
{
    const rtray_file *file = lua_touserdata(L, lua_upvalueindex(1));
    const char *tail = strchr(file->name, '.');
    lua_pushfstring(L, "=rtray/%s.lua", tail ? tail + 1 : file->name);
    if (luaL_loadbufferx(L, (const char *)file->text, file->size, lua_tostring(L, -1), "t") != LUA_OK) {
        return lua_error(L);
    }
    lua_pushstring(L, file->name);
    lua_call(L, 1, 1);
    return 1;
}

static void preload(lua_State *L)
{
    luaL_getsubtable(L, LUA_REGISTRYINDEX, LUA_PRELOAD_TABLE);
    lua_pushcfunction(L, luaopen_rt);
    lua_setfield(L, -2, "rt");
    lua_pushcfunction(L, rtray_open_sys);
    lua_setfield(L, -2, "rtray.sys");
    for (const rtray_file *file = rtray_files; file->name; file++) {
        lua_pushlightuserdata(L, (void *)(uintptr_t)file);
        lua_pushcclosure(L, load_file, 1);
        lua_setfield(L, -2, file->name);
    }
    lua_pop(L, 1);
}

static void require(lua_State *L, const char *name)
{
    lua_getglobal(L, "require");
    lua_pushstring(L, name);
    lua_call(L, 1, 1);
}

/* As luaL_newstate sets it: a fault of the program itself, outside of every protected call. */
static int panic(lua_State *L)
{
    const char *message = lua_tostring(L, -1);
    fprintf(stderr, "rtray: %s\n", message ? message : "an error that is no text");
    return 0;
}

/* Warnings of Lua are off until a script says warn "@on", as in luaL_newstate. */
static void on_warning(void *user, const char *message, int more)
{
    static int on, inside;
    (void)user;
    if (!inside && !more && message[0] == '@') {
        on = strcmp(message, "@on") == 0 ? 1 : strcmp(message, "@off") == 0 ? 0 : on;
    } else if (on) {
        fprintf(stderr, "%s%s%s", inside ? "" : "Lua warning: ", message, more ? "" : "\n");
    }
    inside = more;
}

/* main(argc, argv): leaves the exit status on the stack. */
static int run(lua_State *L)
{
    int argc = (int)lua_tointeger(L, 1);
    char **argv = lua_touserdata(L, 2);
    rt_context_desc desc = rt_context_desc_default();
    desc.allocate = rtray_allocate;
    desc.open = rtray_guard_open;
    rtl_context_defaults(L, &desc);
    luaL_openlibs(L);
    preload(L);
    rtray_catch_signals(L);
    require(L, "rt"); /* makes its parts known, which the program uses too */
    lua_pop(L, 1);
    require(L, "rtray.main");
    lua_createtable(L, argc, 0);
    for (int i = 0; i < argc; i++) {
        lua_pushstring(L, argv[i]);
        lua_rawseti(L, -2, i);
    }
    lua_call(L, 1, 1);
    return 1;
}

int main(int argc, char **argv)
{
    lua_State *L = lua_newstate(rtray_allocate, NULL);
    if (!L) {
        fputs("rtray: out of memory\n", stderr);
        return STATUS_MACHINE;
    }
    lua_atpanic(L, panic);
    lua_setwarnf(L, on_warning, NULL);
    lua_pushcfunction(L, run);
    lua_pushinteger(L, argc);
    lua_pushlightuserdata(L, argv);
    int status;
    if (lua_pcall(L, 2, 1, 0) == LUA_OK) {
        status = (int)lua_tointeger(L, -1);
    } else { /* rtray.main catches what commands raise; what comes here is a lack of memory or a fault of the program */
        const char *message = lua_tostring(L, -1);
        fprintf(stderr, "rtray: %s\n", message ? message : "an error that is no text");
        status = STATUS_MACHINE;
    }
    lua_close(L);
    rtray_end_by_signal();
    return status;
}
