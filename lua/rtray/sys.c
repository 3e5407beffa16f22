/* rtray.sys: what the program needs of the system and Lua's library lacks. Failures return nil and the system's reason. */
#include "rtray.h"

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

static int fail(lua_State *L, int error)
{
    lua_pushnil(L);
    lua_pushstring(L, strerror(error));
    return 2;
}

/* ---- terminal and clock ---- */

/* columns(fd): width of the terminal, nil when unknown. */
static int columns(lua_State *L)
{
    struct winsize size;
    if (ioctl((int)luaL_checkinteger(L, 1), TIOCGWINSZ, &size) != 0 || size.ws_col == 0) {
        return 0;
    }
    lua_pushinteger(L, size.ws_col);
    return 1;
}

static int now(lua_State *L)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    lua_pushnumber(L, (lua_Number)t.tv_sec + (lua_Number)t.tv_nsec * 1e-9);
    return 1;
}

/* ---- files ---- */

static int real_path(lua_State *L)
{
    char *path = realpath(luaL_checkstring(L, 1), NULL);
    if (!path) {
        return fail(L, errno);
    }
    lua_pushstring(L, path);
    free(path);
    return 1;
}

static int write_all(int fd, const char *data, size_t size)
{
    while (size > 0) {
        ssize_t n = write(fd, data, size);
        if (n < 0) {
            if (errno == EINTR) {
                continue;
            }
            return errno;
        }
        data += n;
        size -= (size_t)n;
    }
    return 0;
}

/* write(fd, text) */
static int write_text(lua_State *L)
{
    size_t size;
    const char *text = luaL_checklstring(L, 2, &size);
    int error = write_all((int)luaL_checkinteger(L, 1), text, size);
    if (error) {
        return fail(L, error);
    }
    lua_pushboolean(L, 1);
    return 1;
}

/* failures(): { number, text } of the reasons that are the machine's fault. */
static int failures(lua_State *L)
{
    static const int errors[] = {ENOSPC, EDQUOT, EIO, EFBIG, EROFS, ENOMEM};
    lua_createtable(L, (int)(sizeof errors / sizeof errors[0]), 0);
    for (size_t i = 0; i < sizeof errors / sizeof errors[0]; i++) {
        lua_createtable(L, 0, 2);
        lua_pushinteger(L, errors[i]);
        lua_setfield(L, -2, "number");
        lua_pushstring(L, strerror(errors[i]));
        lua_setfield(L, -2, "text");
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    return 1;
}

/* What the module has of the same kind (lua/folder.c, lua/process.c, lua/rt/process.lua) is known here by the program's names. */
static void take_from_module(lua_State *L)
{
    static const char *const names[][3] = {{"rt.core", "sleep", "sleep"},
                                           {"rt.core", "program", "program"},
                                           {"rt.core", "file_stat", "stat"},
                                           {"rt.core", "can_create", "can_create"},
                                           {"rt.core", "put_in_place", "put_in_place"},
                                           {"rt.core", "make_folder", "make_folder"},
                                           {"rt.core", "list_folder", "list_folder"},
                                           {"rt.core", "lock_file", "lock_file"},
                                           {"rt.core", "process_id", "process_id"},
                                           {"rt.core", "is_terminal", "is_terminal"},
                                           {"rt.process", "spawn", "spawn"},
                                           {"rt.process", "run", "run"}};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        lua_getglobal(L, "require");
        lua_pushstring(L, names[i][0]);
        lua_call(L, 1, 1);
        lua_getfield(L, -1, names[i][1]);
        lua_setfield(L, -3, names[i][2]);
        lua_pop(L, 1);
    }
}

int rtray_open_sys(lua_State *L)
{
    static const luaL_Reg functions[] = {{"columns", columns},  {"now", now},           {"real_path", real_path},
                                         {"write", write_text}, {"failures", failures}, {NULL, NULL}};
    luaL_newlib(L, functions);
    take_from_module(L);
    rtray_open_signals(L);
    rtray_open_sha256(L);
    rtray_open_claim(L);
    rtray_open_guard(L);
    rtray_open_limits(L);
    rtray_open_bench_rays(L);
    return 1;
}
