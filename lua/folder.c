/* Files and folders as the module's long works need them: made, listed, locked, put in place when whole. Failures return nil, the
 * system's reason and its number. */
#include "binding.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#define RTL_LOCK    "rt.lock"
#define RTL_JOURNAL "rt.journal"

static int fail(lua_State *L, int error)
{
    lua_pushnil(L);
    lua_pushstring(L, strerror(error));
    lua_pushinteger(L, error);
    return 3;
}

static int done(lua_State *L)
{
    lua_pushboolean(L, 1);
    return 1;
}

/* An empty name is left to the system, which knows no such file. */
static const char *path_of(lua_State *L, int index)
{
    size_t size;
    const char *path = luaL_checklstring(L, index, &size);
    luaL_argcheck(L, strlen(path) == size, index, "the file name has a NUL byte inside");
    return path;
}

/* file_stat(path): kind ("file", "folder", "other"), bytes, time of the last change in nanoseconds, inode, device. */
static int file_stat(lua_State *L)
{
    struct stat st;
    if (stat(path_of(L, 1), &st) != 0) {
        return fail(L, errno);
    }
    lua_pushstring(L, S_ISREG(st.st_mode) ? "file" : S_ISDIR(st.st_mode) ? "folder" : "other");
    lua_pushinteger(L, (lua_Integer)st.st_size);
    lua_pushinteger(L, (lua_Integer)st.st_mtim.tv_sec * 1000000000 + st.st_mtim.tv_nsec);
    lua_pushinteger(L, (lua_Integer)st.st_ino);
    lua_pushinteger(L, (lua_Integer)st.st_dev);
    return 5;
}

/* can_create(folder): may files be made in it? */
static int can_create(lua_State *L)
{
    return access(path_of(L, 1), W_OK | X_OK) != 0 ? fail(L, errno) : done(L);
}

/* make_folder(path): true when it was made, false when it was there. */
static int make_folder(lua_State *L)
{
    const char *path = path_of(L, 1);
    struct stat st;
    if (mkdir(path, 0777) == 0) {
        return done(L);
    }
    int error = errno;
    if (stat(path, &st) == 0 && S_ISDIR(st.st_mode)) {
        lua_pushboolean(L, 0);
        return 1;
    }
    return fail(L, error);
}

static int by_name(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

/* list_folder(path): the names in it, in the order of their bytes. */
static int list_folder(lua_State *L)
{
    DIR *folder = opendir(path_of(L, 1));
    if (!folder) {
        return fail(L, errno);
    }
    char **names = NULL;
    size_t count = 0, room = 0;
    int error = 0;
    for (;;) {
        errno = 0;
        const struct dirent *entry = readdir(folder);
        if (!entry) {
            error = errno;
            break;
        }
        if (strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0) {
            continue;
        }
        if (count == room) {
            room = room ? room * 2 : 64;
            char **more = realloc(names, room * sizeof *names);
            if (!more) {
                error = ENOMEM;
                break;
            }
            names = more;
        }
        names[count] = strdup(entry->d_name);
        if (!names[count]) {
            error = ENOMEM;
            break;
        }
        count++;
    }
    closedir(folder);
    if (count > 0) {
        qsort(names, count, sizeof *names, by_name);
    }
    lua_createtable(L, (int)count, 0); /* a lack of Lua's memory here would lose the names: the program ends then anyway */
    for (size_t i = 0; i < count; i++) {
        lua_pushstring(L, names[i]);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
        free(names[i]);
    }
    free(names);
    return error ? fail(L, error) : 1;
}

/* put_in_place(part, path): the finished file `part` becomes `path` when it is on disk. */
static int put_in_place(lua_State *L)
{
    const char *part = path_of(L, 1), *path = path_of(L, 2);
    int fd = open(part, O_RDONLY | O_CLOEXEC);
    if (fd < 0) {
        return fail(L, errno);
    }
    int error = fsync(fd) != 0 ? errno : 0;
    close(fd);
    if (!error && rename(part, path) != 0) {
        error = errno;
    }
    return error ? fail(L, error) : done(L);
}

/* ---- locks: held by one process at a time, gone with it however it ends ---- */

static int unlock(lua_State *L)
{
    int *fd = luaL_checkudata(L, 1, RTL_LOCK);
    if (*fd >= 0) {
        close(*fd);
        *fd = -1;
    }
    return 0;
}

static int lock_to_string(lua_State *L)
{
    lua_pushstring(L, *(int *)luaL_checkudata(L, 1, RTL_LOCK) < 0 ? "rt.lock (released)" : "rt.lock");
    return 1;
}

/* lock_file(path, shared): a lock on a file, which is made when it is missing and stays; false when another process has it
 * (shared: has it alone). Everybody may take a lock in a folder that all share, so a file of another user is opened for reading
 * only. */
static int lock_file(lua_State *L)
{
    const char *path = path_of(L, 1);
    int shared = lua_toboolean(L, 2);
    int *fd = lua_newuserdatauv(L, sizeof *fd, 0);
    *fd = -1;
    luaL_setmetatable(L, RTL_LOCK);
    *fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (*fd < 0 && (errno == EACCES || errno == EPERM || errno == EROFS)) {
        *fd = open(path, O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
    }
    if (*fd < 0) {
        return fail(L, errno);
    }
    int n;
    while ((n = flock(*fd, (shared ? LOCK_SH : LOCK_EX) | LOCK_NB)) != 0 && errno == EINTR) {
    }
    if (n != 0) {
        int error = errno;
        close(*fd);
        *fd = -1;
        if (error == EWOULDBLOCK) {
            lua_pushboolean(L, 0);
            return 1;
        }
        return fail(L, error);
    }
    return 1;
}

/* ---- journals: lines that are on disk when the call returns ---- */

static int journal_to_string(lua_State *L)
{
    lua_pushstring(L, *(int *)luaL_checkudata(L, 1, RTL_JOURNAL) < 0 ? "rt.journal (closed)" : "rt.journal");
    return 1;
}

static int journal_close(lua_State *L)
{
    int *fd = luaL_checkudata(L, 1, RTL_JOURNAL);
    if (*fd >= 0) {
        close(*fd);
        *fd = -1;
    }
    return 0;
}

/* journal:add(text, keep): appended by one write; on disk before it returns unless keep is false. A part that could not be
 * written is cut off. */
static int journal_add(lua_State *L)
{
    int fd = *(int *)luaL_checkudata(L, 1, RTL_JOURNAL);
    size_t size, at = 0;
    const char *data = luaL_checklstring(L, 2, &size);
    int sync = lua_isnone(L, 3) || lua_toboolean(L, 3);
    if (fd < 0) {
        return fail(L, EBADF);
    }
    off_t before = lseek(fd, 0, SEEK_END);
    while (at < size) {
        ssize_t n = write(fd, data + at, size - at);
        if (n < 0 && errno != EINTR) {
            int error = errno;
            int ignored = before >= 0 ? ftruncate(fd, before) : 0;
            (void)ignored;
            return fail(L, error);
        }
        at += n > 0 ? (size_t)n : 0;
    }
    if (sync && fdatasync(fd) != 0 && errno != EINVAL && errno != EROFS) {
        return fail(L, errno);
    }
    return done(L);
}

/* journal_open(path, bytes): for appending behind its first `bytes` bytes; what stands behind them (a line that a kill has cut)
 * is dropped. */
static int journal_open(lua_State *L)
{
    const char *path = path_of(L, 1);
    lua_Integer size = luaL_checkinteger(L, 2);
    int *fd = lua_newuserdatauv(L, sizeof *fd, 0);
    *fd = -1;
    luaL_setmetatable(L, RTL_JOURNAL);
    *fd = open(path, O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
    if (*fd < 0 || ftruncate(*fd, (off_t)size) != 0) {
        return fail(L, errno);
    }
    return 1;
}

/* ---- this process ---- */

/* usage(): { user_seconds, system_seconds, max_rss } of this process. The peak is of this program alone where the system tells
 * (VmHWM of Linux); getrusage also counts what the process that started it held at the fork. */
static int usage(lua_State *L)
{
    struct rusage u;
    memset(&u, 0, sizeof u);
    getrusage(RUSAGE_SELF, &u);
    lua_Integer peak = (lua_Integer)u.ru_maxrss * 1024;
    int fd = open("/proc/self/status", O_RDONLY | O_CLOEXEC);
    if (fd >= 0) {
        char text[4096];
        ssize_t n = read(fd, text, sizeof text - 1);
        close(fd);
        text[n > 0 ? n : 0] = 0;
        const char *row = strstr(text, "VmHWM:");
        if (row) {
            peak = strtoll(row + 6, NULL, 10) * 1024;
        }
    }
    lua_createtable(L, 0, 3);
    lua_pushnumber(L, (lua_Number)u.ru_utime.tv_sec + (lua_Number)u.ru_utime.tv_usec * 1e-6);
    lua_setfield(L, -2, "user_seconds");
    lua_pushnumber(L, (lua_Number)u.ru_stime.tv_sec + (lua_Number)u.ru_stime.tv_usec * 1e-6);
    lua_setfield(L, -2, "system_seconds");
    lua_pushinteger(L, peak);
    lua_setfield(L, -2, "max_rss");
    return 1;
}

static int current_process(lua_State *L)
{
    lua_pushinteger(L, (lua_Integer)getpid());
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

/* program(): path of the running program; nothing where the system does not tell. */
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

static uint64_t mixed(uint64_t x) /* splitmix64's last steps */
{
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

/* text_hash(text): 32 hexadecimal digits that name a text (no cryptography): two FNV-1a sums from different starts, mixed. */
static int text_hash(lua_State *L)
{
    size_t size;
    const char *text = luaL_checklstring(L, 1, &size);
    uint64_t a = 0xcbf29ce484222325u, b = 0x9e3779b97f4a7c15u;
    for (size_t i = 0; i < size; i++) {
        a = (a ^ (unsigned char)text[i]) * 0x100000001b3u;
        b = mixed(b ^ (unsigned char)text[i]) + 0x9e3779b97f4a7c15u;
    }
    char digits[33];
    snprintf(digits, sizeof digits, "%016llx%016llx", (unsigned long long)mixed(a ^ size), (unsigned long long)mixed(b + size));
    lua_pushstring(L, digits);
    return 1;
}

/* build_details(): { compiler, flags, isa (of all but the hot loops) } that this binary was made by and for. */
static int build_details(lua_State *L)
{
#if defined __x86_64__
#define RTL_ARCH "x86_64"
#elif defined __aarch64__
#define RTL_ARCH "aarch64"
#else
#define RTL_ARCH "other"
#endif
#if defined __AVX512F__
#define RTL_VECTORS " avx512f"
#elif defined __AVX2__
#define RTL_VECTORS " avx2"
#elif defined __SSE4_2__
#define RTL_VECTORS " sse4.2"
#else
#define RTL_VECTORS ""
#endif
    lua_createtable(L, 0, 3);
    lua_pushliteral(L, RTL_COMPILER);
    lua_setfield(L, -2, "compiler");
    lua_pushliteral(L, RTL_FLAGS);
    lua_setfield(L, -2, "flags");
    lua_pushliteral(L, RTL_ARCH RTL_VECTORS);
    lua_setfield(L, -2, "isa");
    return 1;
}

static int is_terminal(lua_State *L)
{
    lua_pushboolean(L, isatty((int)luaL_checkinteger(L, 1)));
    return 1;
}

void rtl_open_folder(lua_State *L)
{
    static const luaL_Reg lock_methods[] = {{NULL, NULL}};
    static const luaL_Reg journal_methods[] = {{"add", journal_add}, {NULL, NULL}};
    static const luaL_Reg functions[] = {{"file_stat", file_stat},
                                         {"can_create", can_create},
                                         {"make_folder", make_folder},
                                         {"list_folder", list_folder},
                                         {"lock_file", lock_file},
                                         {"put_in_place", put_in_place},
                                         {"journal_open", journal_open},
                                         {"usage", usage},
                                         {"process_id", current_process},
                                         {"text_hash", text_hash},
                                         {"sleep", sleep_for},
                                         {"program", program},
                                         {"is_terminal", is_terminal},
                                         {"build_details", build_details},
                                         {NULL, NULL}};
    rtl_class(L, RTL_LOCK, lock_methods, unlock, lock_to_string);
    rtl_class(L, RTL_JOURNAL, journal_methods, journal_close, journal_to_string);
    rtl_add_functions(L, functions);
}
