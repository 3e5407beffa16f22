/* rtray.sys: what the program needs of the system and Lua's library lacks. Failures return nil and the system's reason. */
#include "rtray.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <spawn.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
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

static int is_terminal(lua_State *L)
{
    lua_pushboolean(L, isatty((int)luaL_checkinteger(L, 1)));
    return 1;
}

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

/* sleep(seconds): shorter when a signal comes. */
static int sleep_for(lua_State *L)
{
    lua_Number s = luaL_checknumber(L, 1);
    struct timespec t = {(time_t)s, (long)((s - (lua_Number)(time_t)s) * 1e9)};
    nanosleep(&t, NULL);
    return 0;
}

/* ---- files ---- */

/* stat(path): kind ("file", "folder", "other"), bytes, time of the last change in nanoseconds, inode. */
static int file_stat(lua_State *L)
{
    struct stat st;
    if (stat(luaL_checkstring(L, 1), &st) != 0) {
        return fail(L, errno);
    }
    lua_pushstring(L, S_ISREG(st.st_mode) ? "file" : S_ISDIR(st.st_mode) ? "folder" : "other");
    lua_pushinteger(L, (lua_Integer)st.st_size);
    lua_pushinteger(L, (lua_Integer)st.st_mtim.tv_sec * 1000000000 + st.st_mtim.tv_nsec);
    lua_pushinteger(L, (lua_Integer)st.st_ino);
    return 4;
}

/* can_create(folder): may files be made in it? */
static int can_create(lua_State *L)
{
    if (access(luaL_checkstring(L, 1), W_OK | X_OK) != 0) {
        return fail(L, errno);
    }
    lua_pushboolean(L, 1);
    return 1;
}

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

/* put_in_place(part, path): the finished file `part` becomes `path` when it is on disk. */
static int put_in_place(lua_State *L)
{
    const char *part = luaL_checkstring(L, 1), *path = luaL_checkstring(L, 2);
    int fd = open(part, O_RDONLY);
    if (fd < 0) {
        return fail(L, errno);
    }
    int error = fsync(fd) != 0 ? errno : 0;
    close(fd);
    if (!error && rename(part, path) != 0) {
        error = errno;
    }
    if (error) {
        return fail(L, error);
    }
    lua_pushboolean(L, 1);
    return 1;
}

/* ---- processes ---- */

static int process_id(lua_State *L)
{
    lua_pushinteger(L, (lua_Integer)getpid());
    return 1;
}

/* Path of the running program. */
static int program(lua_State *L)
{
    char path[PATH_MAX];
    ssize_t n = readlink("/proc/self/exe", path, sizeof path);
    if (n <= 0 || (size_t)n >= sizeof path) {
        return 0;
    }
    lua_pushlstring(L, path, (size_t)n);
    return 1;
}

/* Reads fd to its end into a string on the stack. */
static int read_all(lua_State *L, int fd)
{
    luaL_Buffer b;
    luaL_buffinit(L, &b);
    int error = 0;
    for (;;) {
        char *room = luaL_prepbuffer(&b);
        ssize_t n = read(fd, room, LUAL_BUFFERSIZE);
        if (n < 0 && errno == EINTR) {
            continue;
        }
        if (n <= 0) {
            error = n < 0 ? errno : 0;
            break;
        }
        luaL_addsize(&b, (size_t)n);
    }
    luaL_pushresult(&b);
    return error;
}

extern char **environ;

/* run({program, argument, ...}): its standard output and exit status (128 + n after signal n). */
static int run(lua_State *L)
{
    luaL_checktype(L, 1, LUA_TTABLE);
    int count = (int)luaL_len(L, 1);
    char **argv = lua_newuserdatauv(L, ((size_t)count + 1) * sizeof *argv, 0);
    luaL_checkstack(L, count + 20, "too many arguments");
    for (int i = 0; i < count; i++) {
        lua_rawgeti(L, 1, i + 1);
        argv[i] = (char *)(uintptr_t)luaL_checkstring(L, -1); /* stays on the stack */
    }
    argv[count] = NULL;
    int ends[2];
    if (count == 0 || pipe(ends) != 0) {
        return fail(L, count == 0 ? EINVAL : errno);
    }
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_addclose(&actions, ends[0]);
    posix_spawn_file_actions_addclose(&actions, ends[1]);
    pid_t child;
    int error = posix_spawnp(&child, argv[0], &actions, NULL, argv, environ);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    if (error) {
        close(ends[0]);
        return fail(L, error);
    }
    error = read_all(L, ends[0]);
    close(ends[0]);
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (error) {
        return fail(L, error);
    }
    lua_pushinteger(L, WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status));
    return 2;
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

int rtray_open_sys(lua_State *L)
{
    static const luaL_Reg functions[] = {{"is_terminal", is_terminal}, {"columns", columns},  {"now", now},
                                         {"sleep", sleep_for},         {"stat", file_stat},   {"can_create", can_create},
                                         {"real_path", real_path},     {"write", write_text}, {"put_in_place", put_in_place},
                                         {"process_id", process_id},   {"program", program},  {"run", run},
                                         {"failures", failures},       {NULL, NULL}};
    luaL_newlib(L, functions);
    rtray_open_signals(L);
    return 1;
}
