/* What scripts in the sandbox may open. The guard answers the open hook of the renderer's context (rt_open_fn) and opens the
 * files of the script's own io.open: reads below some folders and of files named one by one, writes of new data files below one
 * folder.
 *
 * A name is resolved to its real path, the path is judged, and then it is walked from the root folder by descriptors without
 * following a link: what is opened is what was judged, whatever is renamed meanwhile. Judging the name and then opening it would
 * leave a gap between the two.
 *
 * The program's own files are not judged: it names each right before it opens it (sys.guard_own), and what is not named so is
 * a script's wish. Looking at the stack alone would not do: a tail call takes a script's function from it, and a coroutine has
 * another. A name of the program's is judged all the same while a script runs: while sys.guard_depth is above 0, or when one of
 * its functions stands on the stack of the main state. */
#include "rtray.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#ifdef O_PATH
#define FOLDER_FLAGS (O_PATH | O_DIRECTORY | O_CLOEXEC)
#else
#define FOLDER_FLAGS (O_RDONLY | O_DIRECTORY | O_CLOEXEC)
#endif

enum { NAMES_MAX = 4096, OWN_MAX = 256 };

typedef struct names {
    char **list;
    size_t count, room;
} names;

/* One a process, as the program has one Lua state. */
static struct guard {
    bool on;
    unsigned depth; /* of runs of scripts */
    lua_State *L;
    pthread_t thread;
    pthread_mutex_t lock; /* of the lists: files are read on any thread */
    names folders;        /* real paths; scripts read what lies below, but for hidden names */
    names open_folders;   /* the same with hidden names: --allow-read */
    names files;          /* real paths of single files */
    names made;           /* what scripts have made: they may replace it */
    names reads;          /* what was opened for reading, as it was named */
    char *own[OWN_MAX];   /* plain paths that the program is about to open, the newest ones */
    unsigned own_next;
    bool all_own; /* what no script is seen to ask for */
    char *output; /* real path of the folder that scripts write below; NULL: none */
} guard = {.lock = PTHREAD_MUTEX_INITIALIZER};

/* ---- lists of names ---- */

static bool names_have(const names *n, const char *name)
{
    for (size_t i = 0; i < n->count; i++) {
        if (strcmp(n->list[i], name) == 0) {
            return true;
        }
    }
    return false;
}

/* false: no memory, or more than a scene can have use for */
static bool names_add(names *n, const char *name)
{
    if (names_have(n, name)) {
        return true;
    }
    if (n->count == n->room) {
        size_t room = n->room ? 2 * n->room : 16;
        char **list = n->count < NAMES_MAX ? realloc(n->list, room * sizeof *list) : NULL;
        if (!list) {
            return false;
        }
        n->list = list;
        n->room = room;
    }
    char *copy = strdup(name);
    if (!copy) {
        return false;
    }
    n->list[n->count++] = copy;
    return true;
}

static void names_clear(names *n)
{
    for (size_t i = 0; i < n->count; i++) {
        free(n->list[i]);
    }
    free(n->list);
    *n = (names){0};
}

/* ---- judging ---- */

/* What lies behind `folder` in `path`, without a slash at its head; NULL when path is not below it. */
static const char *below(const char *path, const char *folder)
{
    size_t n = strlen(folder);
    if (n == 1) { /* "/" */
        return path[1] ? path + 1 : NULL;
    }
    return strncmp(path, folder, n) == 0 && path[n] == '/' ? path + n + 1 : NULL;
}

static bool has_hidden_part(const char *path)
{
    return path[0] == '.' || strstr(path, "/.") != NULL;
}

static bool is_system(const char *real)
{
    return below(real, "/proc") || below(real, "/sys") || below(real, "/dev");
}

static bool may_read(const char *real)
{
    if (names_have(&guard.files, real)) {
        return true;
    }
    if (is_system(real)) {
        return false;
    }
    for (size_t i = 0; i < guard.open_folders.count; i++) {
        if (below(real, guard.open_folders.list[i])) {
            return true;
        }
    }
    for (size_t i = 0; i < guard.folders.count; i++) {
        const char *rest = below(real, guard.folders.list[i]);
        if (rest && !has_hidden_part(rest)) {
            return true;
        }
    }
    return false;
}

/* Path without ".", ".." and doubled slashes, absolute; for names that do not exist. */
static bool plain_path(const char *path, char *out, size_t size)
{
    size_t n = 0;
    if (path[0] != '/') {
        if (!getcwd(out, size)) {
            return false;
        }
        n = strlen(out);
        n = n == 1 ? 0 : n;
    }
    for (const char *p = path; *p;) {
        size_t part = strcspn(p, "/");
        if (part == 2 && p[0] == '.' && p[1] == '.') {
            while (n > 0 && out[--n] != '/') {
            }
        } else if (part > 0 && !(part == 1 && p[0] == '.')) {
            if (n + part + 2 > size) {
                return false;
            }
            out[n++] = '/';
            memcpy(out + n, p, part);
            n += part;
        }
        p += part + (p[part] == '/');
    }
    if (n == 0) {
        out[n++] = '/';
    }
    out[n] = 0;
    return true;
}

static const char READS[] = "a script in the sandbox reads below its own folder only (no hidden files), and files named by -D; "
                            "--allow-read FOLDER allows more, --trust everything";

static int refuse(char *why, size_t size, const char *text)
{
    snprintf(why, size, "%s", text);
    errno = EACCES;
    return -1;
}

/* ---- opening ---- */

/* The folder of real path `path` (no links in it) by descriptors; -1 and errno. */
static int walk(const char *path)
{
    char part[NAME_MAX + 1];
    int fd = open("/", FOLDER_FLAGS);
    for (const char *p = path + 1; fd >= 0 && *p;) {
        size_t n = strcspn(p, "/");
        if (n > NAME_MAX) {
            close(fd);
            errno = ENAMETOOLONG;
            return -1;
        }
        memcpy(part, p, n);
        part[n] = 0;
        p += n + (p[n] == '/');
        int next = openat(fd, part, FOLDER_FLAGS | O_NOFOLLOW), reason = errno;
        close(fd);
        fd = next;
        errno = reason;
    }
    return fd;
}

/* Opens the regular file of real path `real`; -1, errno and perhaps why. */
static int open_real(const char *real, char *why, size_t size)
{
    char folder[PATH_MAX];
    const char *name = strrchr(real, '/') + 1;
    struct stat st;
    memcpy(folder, real, (size_t)(name - real));
    folder[name - real - (name - real > 1)] = 0;
    int parent = walk(folder), fd = -1;
    if (parent < 0) {
        return -1;
    }
    if (fstatat(parent, name, &st, AT_SYMLINK_NOFOLLOW) == 0) {
        if (!S_ISREG(st.st_mode)) { /* opening a device may already do something */
            refuse(why, size, S_ISDIR(st.st_mode) ? "it is a folder" : "it is a device or a pipe, not a regular file");
        } else {
            fd = openat(parent, name, O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY);
        }
    }
    int reason = errno;
    if (fd >= 0 && (fstat(fd, &st) != 0 || !S_ISREG(st.st_mode))) {
        close(fd);
        fd = refuse(why, size, "it is a device or a pipe, not a regular file");
        reason = errno;
    }
    close(parent);
    errno = reason;
    return fd;
}

/* Opens `path` for a script; -1, errno and perhaps why. */
static int open_read(const char *path, char *why, size_t size)
{
    char real[PATH_MAX];
    if (!realpath(path, real)) {
        int reason = errno; /* whether a file exists elsewhere is none of the script's business */
        bool known = plain_path(path, real, sizeof real) && may_read(real);
        errno = reason;
        return known ? -1 : refuse(why, size, READS);
    }
    return may_read(real) ? open_real(real, why, size) : refuse(why, size, READS);
}

static bool is_data_name(const char *name)
{
    static const char *const endings[] = {".png", ".jpg",  ".jpeg", ".bmp", ".tga", ".hdr", ".rts", ".csv", ".tsv",
                                          ".txt", ".json", ".svg",  ".ppm", ".pgm", ".ply", ".obj", ".mtl", ".stl"};
    const char *dot = strrchr(name, '.');
    for (size_t i = 0; dot && i < sizeof endings / sizeof endings[0]; i++) {
        if (strcmp(dot, endings[i]) == 0) {
            return true;
        }
    }
    return false;
}

/* The folder in which a script makes `path`, with the file's name in it; *is_new: nothing stands there. -1, errno, why. */
static int open_folder(const char *path, const char **name, bool *is_new, char *why, size_t size)
{
    char full[PATH_MAX], real[PATH_MAX];
    struct stat st;
    if (!guard.output) {
        return refuse(why, size,
                      "a script in the sandbox writes below the output folder only, and -o names none; --trust allows more");
    }
    int n = path[0] == '/' ? snprintf(full, sizeof full, "%s", path) : snprintf(full, sizeof full, "%s/%s", guard.output, path);
    if (n < 0 || (size_t)n >= sizeof full) {
        errno = ENAMETOOLONG;
        return -1;
    }
    char *slash = strrchr(full, '/');
    *name = strrchr(path, '/') ? strrchr(path, '/') + 1 : path;
    *slash = 0;
    const char *folder = realpath(full[0] ? full : "/", real);
    const char *rest = folder ? below(real, guard.output) : NULL;
    if (!folder || (strcmp(real, guard.output) != 0 && (!rest || has_hidden_part(rest)))) {
        return refuse(
            why, size,
            "a script in the sandbox writes below the output folder only, into folders that are there; --trust allows more");
    }
    if ((*name)[0] == '.' || !is_data_name(*name)) {
        return refuse(why, size,
                      "a script in the sandbox writes images, .rts, .csv, .tsv, .txt, .json and mesh files only; --trust "
                      "allows more");
    }
    int fd = walk(real);
    if (fd < 0) {
        return -1;
    }
    *is_new = fstatat(fd, *name, &st, AT_SYMLINK_NOFOLLOW) != 0;
    n = snprintf(full, sizeof full, "%s/%s", real, *name);
    if (n < 0 || (size_t)n >= sizeof full || (!*is_new && !names_have(&guard.made, full))) {
        close(fd);
        return refuse(
            why, size,
            "it is there already, and a script in the sandbox replaces only what this run has made; remove it, or --trust");
    }
    if (!names_add(&guard.made, full)) {
        close(fd);
        return refuse(why, size, "a script in the sandbox may not make so many files; --trust allows more");
    }
    return fd;
}

/* ---- whose wish it is ---- */

static bool starts_with(const char *s, const char *head)
{
    return strncmp(s, head, strlen(head)) == 0;
}

static bool script_on_stack(lua_State *L)
{
    lua_Debug ar;
    for (int level = 0; lua_getstack(L, level, &ar); level++) {
        lua_getinfo(L, "S", &ar);
        if (strcmp(ar.what, "C") != 0 && !starts_with(ar.source, "=rt/") && !starts_with(ar.source, "=rtray/") &&
            !starts_with(ar.source, "=line ")) { /* of the repl: the user's own */
            return true;
        }
    }
    return false;
}

static bool in_script(void)
{
    return guard.depth > 0 || !pthread_equal(pthread_self(), guard.thread) || script_on_stack(guard.L);
}

/* Has the program said that it opens `path` itself? */
static bool is_own(const char *path)
{
    char plain[PATH_MAX];
    bool found = false;
    for (unsigned i = 0; plain_path(path, plain, sizeof plain) && i < OWN_MAX && !found; i++) {
        found = guard.own[i] && strcmp(guard.own[i], plain) == 0;
    }
    return found;
}

int rtray_guard_open(void *user, const char *path, rt_open_mode mode, char *why, size_t why_size)
{
    (void)user;
    int fd = RT_OPEN_DEFAULT;
    pthread_mutex_lock(&guard.lock);
    bool scripts = in_script();
    if (scripts && mode == RT_OPEN_READ) {
        names_add(&guard.reads, path);
    }
    if (guard.on && (scripts || !(guard.all_own || is_own(path)))) {
        const char *name;
        bool is_new;
        fd = mode == RT_OPEN_READ ? open_read(path, why, why_size) : open_folder(path, &name, &is_new, why, why_size);
    }
    int reason = errno;
    pthread_mutex_unlock(&guard.lock);
    errno = reason;
    return fd;
}

/* ---- for Lua ---- */

static int close_file(lua_State *L)
{
    luaL_Stream *s = luaL_checkudata(L, 1, LUA_FILEHANDLE);
    int ok = fclose(s->f) == 0;
    return luaL_fileresult(L, ok, NULL);
}

static int fail(lua_State *L, const char *path, const char *why)
{
    lua_pushnil(L);
    lua_pushfstring(L, "%s: %s", path, why[0] ? why : strerror(errno));
    lua_pushinteger(L, errno);
    return 3;
}

/* Opens as fopen's mode says: 'r' below the readable folders, 'w', 'a' and '+' below the output folder. */
static int open_as(const char *path, const char *mode, char *why, size_t size)
{
    if (mode[0] == 'r' && !strchr(mode, '+')) {
        names_add(&guard.reads, path);
        return open_read(path, why, size);
    }
    const char *name;
    bool is_new;
    int folder = open_folder(path, &name, &is_new, why, size);
    if (folder < 0) {
        return -1;
    }
    int flags = (strchr(mode, '+') ? O_RDWR : O_WRONLY) | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK;
    flags |= mode[0] == 'r' ? 0 : is_new ? O_CREAT | O_EXCL : 0;
    flags |= mode[0] == 'a' ? O_APPEND : mode[0] == 'w' && !is_new ? O_TRUNC : 0;
    int fd = openat(folder, name, flags, 0666), reason = errno;
    close(folder);
    errno = reason;
    return fd;
}

/* guard_open(path, mode): a file as io.open gives it, or nil, message, errno. */
static int guard_open(lua_State *L)
{
    size_t length;
    const char *path = luaL_checklstring(L, 1, &length), *mode = luaL_optstring(L, 2, "r");
    char why[512] = "";
    luaL_argcheck(L, length == strlen(path) && length > 0, 1, "a file name is expected");
    luaL_argcheck(L, mode[0] && strchr("rwa", mode[0]) && strspn(mode + 1, "+b") == strlen(mode + 1), 2, "invalid mode");
    luaL_Stream *s = lua_newuserdatauv(L, sizeof *s, 0);
    s->closef = NULL;
    s->f = NULL;
    luaL_setmetatable(L, LUA_FILEHANDLE);
    pthread_mutex_lock(&guard.lock);
    int fd = open_as(path, mode, why, sizeof why);
    pthread_mutex_unlock(&guard.lock);
    if (fd < 0) {
        return fail(L, path, why);
    }
    s->f = fdopen(fd, mode);
    if (!s->f) {
        close(fd);
        return fail(L, path, why);
    }
    s->closef = close_file;
    return 1;
}

static int add_real(lua_State *L, names *list, bool folder)
{
    char real[PATH_MAX];
    struct stat st;
    bool ok = realpath(luaL_checkstring(L, 1), real) && stat(real, &st) == 0;
    if (ok && folder && !S_ISDIR(st.st_mode)) {
        ok = false;
        errno = ENOTDIR;
    }
    if (ok) {
        pthread_mutex_lock(&guard.lock);
        ok = names_add(list, real);
        pthread_mutex_unlock(&guard.lock);
    }
    lua_pushboolean(L, ok);
    if (!ok) {
        lua_pushstring(L, strerror(errno));
    }
    return ok ? 1 : 2;
}

/* guard_folder(path): scripts read what lies below, but for hidden files. */
static int guard_folder(lua_State *L)
{
    return add_real(L, &guard.folders, true);
}

/* guard_open_folder(path): scripts read everything below. */
static int guard_open_folder(lua_State *L)
{
    return add_real(L, &guard.open_folders, true);
}

/* guard_file(path): scripts read this file. */
static int guard_file(lua_State *L)
{
    return add_real(L, &guard.files, false);
}

/* guard_own(path): the program is about to open this file itself. guard_own(): all files are the user's wish, unless a script
 * is seen to ask for them (repl: its lines name files as they please). */
static int guard_own(lua_State *L)
{
    char plain[PATH_MAX];
    if (lua_isnoneornil(L, 1)) {
        guard.all_own = true;
        return 0;
    }
    char *copy = plain_path(luaL_checkstring(L, 1), plain, sizeof plain) ? strdup(plain) : NULL;
    if (copy) {
        pthread_mutex_lock(&guard.lock);
        char **place = &guard.own[guard.own_next++ % OWN_MAX];
        free(*place);
        *place = copy;
        pthread_mutex_unlock(&guard.lock);
    }
    return 0;
}

/* guard_output(path | nil): the folder that scripts write below. */
static int guard_output(lua_State *L)
{
    const char *path = luaL_optstring(L, 1, NULL);
    free(guard.output);
    guard.output = path ? realpath(path, NULL) : NULL;
    lua_pushboolean(L, !path || guard.output);
    return 1;
}

/* guard_on(on): judge what scripts open; guard_on() alone asks. */
static int guard_on(lua_State *L)
{
    if (!lua_isnone(L, 1)) {
        guard.on = lua_toboolean(L, 1);
    }
    lua_pushboolean(L, guard.on);
    return 1;
}

/* guard_depth(change): a script begins (1) or ends (-1). */
static int guard_depth(lua_State *L)
{
    lua_Integer change = luaL_checkinteger(L, 1);
    guard.depth = change > 0 ? guard.depth + 1 : guard.depth ? guard.depth - 1 : 0;
    return 0;
}

/* guard_reads(): what was opened for reading since the last call, as it was named. */
static int guard_reads(lua_State *L)
{
    lua_createtable(L, (int)guard.reads.count, 0);
    for (size_t i = 0; i < guard.reads.count; i++) {
        lua_pushstring(L, guard.reads.list[i]);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    names_clear(&guard.reads);
    return 1;
}

void rtray_open_guard(lua_State *L)
{
    static const luaL_Reg functions[] = {{"guard_open", guard_open},   {"guard_folder", guard_folder},
                                         {"guard_file", guard_file},   {"guard_open_folder", guard_open_folder},
                                         {"guard_own", guard_own},     {"guard_output", guard_output},
                                         {"guard_on", guard_on},       {"guard_depth", guard_depth},
                                         {"guard_reads", guard_reads}, {NULL, NULL}};
    lua_rawgeti(L, LUA_REGISTRYINDEX, LUA_RIDX_MAINTHREAD);
    guard.L = lua_tothread(L, -1);
    guard.thread = pthread_self();
    lua_pop(L, 1);
    luaL_setfuncs(L, functions, 0);
}
