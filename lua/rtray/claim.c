/* What processes need that share a folder: files that only one of them can make, signs of life, and who is alive. */
#include "rtray.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static int fail(lua_State *L, int error)
{
    lua_pushnil(L);
    lua_pushstring(L, strerror(error));
    return 2;
}

/* make_file(path, text): true when this call made the file, false when it was there; nil and the reason. */
static int make_file(lua_State *L)
{
    const char *path = luaL_checkstring(L, 1);
    size_t size;
    const char *text = luaL_checklstring(L, 2, &size);
    int fd = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (fd < 0) {
        if (errno != EEXIST)
            return fail(L, errno);
        lua_pushboolean(L, 0);
        return 1;
    }
    ssize_t n = write(fd, text, size); /* a line: in one piece or, on a full disk, not */
    int error = n < 0 ? errno : (size_t)n < size ? ENOSPC : 0;
    close(fd);
    if (error) {
        unlink(path);
        return fail(L, error);
    }
    lua_pushboolean(L, 1);
    return 1;
}

/* touch(path): its time of change becomes now, by the clock of whoever keeps the file. */
static int touch(lua_State *L)
{
    if (utimensat(AT_FDCWD, luaL_checkstring(L, 1), NULL, 0) != 0)
        return fail(L, errno);
    lua_pushboolean(L, 1);
    return 1;
}

/* process_alive(id): is there such a process on this machine? */
static int process_alive(lua_State *L)
{
    lua_Integer id = luaL_checkinteger(L, 1);
    lua_pushboolean(L, id > 0 && id <= 0x7fffffff && (kill((pid_t)id, 0) == 0 || errno == EPERM));
    return 1;
}

/* host_name() */
static int host_name(lua_State *L)
{
    char name[256];
    if (gethostname(name, sizeof name) != 0)
        return fail(L, errno);
    name[sizeof name - 1] = 0;
    lua_pushstring(L, name);
    return 1;
}

/* sync_folder(path): the names in it are on disk. File systems that cannot say so are believed. */
static int sync_folder(lua_State *L)
{
    int fd = open(luaL_checkstring(L, 1), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd >= 0) {
        fsync(fd);
        close(fd);
    }
    return 0;
}

void rtray_open_claim(lua_State *L)
{
    static const luaL_Reg functions[] = {{"make_file", make_file},         {"touch", touch},
                                         {"process_alive", process_alive}, {"host_name", host_name},
                                         {"sync_folder", sync_folder},     {NULL, NULL}};
    luaL_setfuncs(L, functions, 0);
}
