/* Other programs: started with an argument vector (never a shell), fed and read through pipes, measured, limited, and never left
 * behind. C moves bytes and waits in one place (step); lua/rt/process.lua makes reading, writing and waiting of it, so that an
 * interrupt comes through between two steps.
 *
 * A child dies with this process, however that ends, where the system can promise it (Linux); else with the handle. */
#include "binding.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>
#include <sys/syscall.h>
#endif

#define RTL_PROCESS "rt.process handle"

enum { IN = 0, OUT = 1, ERR = 2, CHUNK = 65536 };

typedef struct output {
    char *data;
    size_t size, room;
} output;

typedef struct process {
    pid_t pid;   /* 0: not started, or reaped */
    int group;   /* leads a process group of its own: signals go to all of it */
    int ends[3]; /* our ends of the pipes, -1: none or closed */
    int pidfd;   /* readable when the child has ended; -1: the system has none */
    output got[3];
    size_t limit; /* bytes of output that wait here; then the child waits */
    double begun, seconds;
    int done, status;
    struct rusage usage;
} process;

extern char **environ;

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

static int fail(lua_State *L, int error)
{
    lua_pushnil(L);
    lua_pushstring(L, strerror(error));
    lua_pushinteger(L, error);
    return 3;
}

static void close_end(int *fd)
{
    if (*fd >= 0) {
        close(*fd);
        *fd = -1;
    }
}

/* A pipe whose ends are not the standard streams and do not reach other children. */
static int make_pipe(int ends[2])
{
    int raw[2];
    if (pipe(raw) != 0) {
        return errno;
    }
    for (int i = 0; i < 2; i++) {
        ends[i] = fcntl(raw[i], F_DUPFD_CLOEXEC, 3);
    }
    int error = ends[0] < 0 || ends[1] < 0 ? errno : 0;
    close(raw[0]);
    close(raw[1]);
    if (error) {
        close_end(&ends[0]);
        close_end(&ends[1]);
    }
    return error;
}

/* ---- the start ---- */

typedef struct bound {
    int resource;
    rlim_t value;
} bound;

/* All that the child needs between fork and exec, where it may allocate nothing. */
typedef struct spawn_plan {
    char **argv, **env;
    const char *cwd;
    int streams[3]; /* what becomes 0, 1, 2; -1: as ours; -2: /dev/null; -3: as the child's standard output */
    int group, report;
    pid_t parent;
    bound limits[4];
    int limit_count;
} spawn_plan;

enum { AS_OURS = -1, NOTHING = -2, AS_OUTPUT = -3 };

static void become(const spawn_plan *p)
{
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, NULL);
    if (p->group) {
        setpgid(0, 0);
    }
#ifdef __linux__
    if (prctl(PR_SET_PDEATHSIG, SIGKILL) == 0 && getppid() != p->parent) {
        _exit(127); /* it is gone already */
    }
#endif
    int failed = 0;
    for (int i = 0; i < 3 && !failed; i++) {
        int from = p->streams[i];
        if (from == NOTHING) {
            from = open("/dev/null", O_RDWR | O_CLOEXEC);
            failed = from < 0;
        } else if (from == AS_OUTPUT) {
            from = STDOUT_FILENO;
        }
        if (from >= 0 && !failed) {
            failed = dup2(from, i) < 0; /* dup2 onto itself keeps CLOEXEC, but no end of ours is below 3 */
            if (from == i) {
                fcntl(i, F_SETFD, 0); /* /dev/null took the place of a stream that was closed */
            }
        }
    }
    for (int i = 0; i < p->limit_count && !failed; i++) {
        struct rlimit r;
        failed = getrlimit(p->limits[i].resource, &r) != 0;
        r.rlim_cur = p->limits[i].value < r.rlim_max ? p->limits[i].value : r.rlim_max;
        failed = failed || setrlimit(p->limits[i].resource, &r) != 0;
    }
    if (!failed && !(p->cwd && chdir(p->cwd) != 0)) {
        environ = p->env ? p->env : environ;
        execvp(p->argv[0], p->argv);
    }
    int error = errno;
    ssize_t ignored = write(p->report, &error, sizeof error);
    (void)ignored;
    _exit(127);
}

/* Forks, and waits until the child runs its program or has said why not. */
static int start(process *p, spawn_plan *plan)
{
    int report[2] = {-1, -1};
    int error = make_pipe(report);
    if (error) {
        return error;
    }
    plan->report = report[1];
    plan->parent = getpid();
    p->begun = now();
    pid_t pid = fork();
    if (pid == 0) {
        become(plan);
    }
    error = pid < 0 ? errno : 0;
    close(report[1]);
    if (!error) {
        int reason = 0;
        ssize_t n;
        while ((n = read(report[0], &reason, sizeof reason)) < 0 && errno == EINTR) {
        }
        if (n > 0) {
            error = reason;
            while (waitpid(pid, NULL, 0) < 0 && errno == EINTR) {
            }
        } else {
            p->pid = pid;
            p->group = plan->group;
        }
    }
    close(report[0]);
    return error;
}

/* ---- what the caller wants, read from the table at 1 ---- */

static char **strings_of(lua_State *L, int index, char *const *before)
{
    int count = (int)luaL_len(L, index), old = 0;
    while (before && before[old]) {
        old++;
    }
    luaL_checkstack(L, count + 20, "too many arguments");
    char **list = lua_newuserdatauv(L, ((size_t)count + (size_t)old + 1) * sizeof *list, 0);
    int used = 0;
    for (int i = 1; i <= count; i++) { /* names that are set anew come first: the first one of a name counts */
        lua_rawgeti(L, index, i);
        size_t size;
        const char *s = luaL_checklstring(L, -1, &size);
        if (strlen(s) != size) {
            luaL_error(L, "argument %d of a program has a NUL byte inside", i);
        }
        list[used++] = (char *)(uintptr_t)s; /* stays on the stack */
    }
    for (int i = 0; i < old; i++) {
        const char *end = strchr(before[i], '=');
        size_t size = end ? (size_t)(end - before[i]) + 1 : 0;
        int same = 0;
        for (int j = 0; j < count && size; j++) {
            same = same || strncmp(list[j], before[i], size) == 0;
        }
        if (!same) {
            list[used++] = before[i];
        }
    }
    list[used] = NULL;
    return list;
}

static void read_limits(lua_State *L, spawn_plan *plan)
{
    static const struct {
        const char *name;
        int resource;
    } known[] = {{"cpu", RLIMIT_CPU}, {"memory", RLIMIT_AS}, {"file", RLIMIT_FSIZE}, {"files", RLIMIT_NOFILE}};
    if (lua_getfield(L, 1, "limits") == LUA_TTABLE) {
        int t = lua_gettop(L);
        for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
            uint64_t value;
            if (lua_getfield(L, t, known[i].name) != LUA_TNIL) {
                lua_pop(L, 1);
                rtl_field_u64(L, t, known[i].name, &value);
                plan->limits[plan->limit_count++] = (bound){known[i].resource, (rlim_t)value};
            } else {
                lua_pop(L, 1);
            }
        }
    }
    lua_pop(L, 1);
}

static const char *const MODES[] = {"inherit", "null", "pipe", "stdout", NULL};

/* Makes the pipes that are asked for: ours into the handle, the child's into `theirs`. */
static int open_streams(lua_State *L, process *p, spawn_plan *plan, int theirs[3])
{
    static const char *const names[] = {"stdin", "stdout", "stderr"};
    static const int modes[] = {AS_OURS, NOTHING, 0, AS_OUTPUT};
    for (int i = 0; i < 3; i++) {
        int mode = i == IN ? 1 : 0;
        rtl_field_choice(L, 1, names[i], MODES, &mode);
        plan->streams[i] = modes[mode];
        if (mode == 2) {
            int ends[2] = {-1, -1};
            int error = make_pipe(ends);
            if (error) {
                return error;
            }
            p->ends[i] = i == IN ? ends[1] : ends[0];
            theirs[i] = plan->streams[i] = i == IN ? ends[0] : ends[1];
            fcntl(p->ends[i], F_SETFL, fcntl(p->ends[i], F_GETFL) | O_NONBLOCK);
        }
    }
    return 0;
}

/* process_start { program, argument, ..., stdin, stdout, stderr, env = {"NAME=value"}, cwd, group, limits, buffer }: the handle,
 * or nil, why, errno */
static int process_start(lua_State *L)
{
    luaL_checktype(L, 1, LUA_TTABLE);
    lua_settop(L, 1);
    process *p = lua_newuserdatauv(L, sizeof *p, 0);
    memset(p, 0, sizeof *p);
    p->ends[0] = p->ends[1] = p->ends[2] = p->pidfd = -1;
    luaL_setmetatable(L, RTL_PROCESS);
    uint64_t most = 64u << 20;
    rtl_field_u64(L, 1, "buffer", &most);
    p->limit = most < CHUNK ? CHUNK : (size_t)most;
    spawn_plan plan;
    memset(&plan, 0, sizeof plan);
    rtl_field_bool(L, 1, "group", &plan.group);
    rtl_field_string(L, 1, "cwd", &plan.cwd);
    read_limits(L, &plan);
    plan.argv = strings_of(L, 1, NULL);
    if (!plan.argv[0]) {
        return fail(L, EINVAL);
    }
    if (lua_getfield(L, 1, "env") == LUA_TTABLE) {
        plan.env = strings_of(L, lua_gettop(L), environ);
    }
    int theirs[3] = {-1, -1, -1};
    int error = open_streams(L, p, &plan, theirs);
    error = error ? error : start(p, &plan);
    for (int i = 0; i < 3; i++) {
        close_end(&theirs[i]);
    }
    if (error) {
        return fail(L, error);
    }
#if defined __linux__ && defined SYS_pidfd_open
    p->pidfd = (int)syscall(SYS_pidfd_open, p->pid, 0);
#endif
    lua_pushvalue(L, 2);
    return 1;
}

/* ---- while it runs ---- */

static process *check(lua_State *L)
{
    return luaL_checkudata(L, 1, RTL_PROCESS);
}

static void reap(process *p, int flags)
{
    if (p->done || !p->pid) {
        return;
    }
    pid_t n;
    while ((n = wait4(p->pid, &p->status, flags, &p->usage)) < 0 && errno == EINTR) {
    }
    if (n != 0) {
        p->seconds = now() - p->begun;
        p->done = 1;
        p->pid = 0;
        close_end(&p->pidfd);
    }
}

/* Reads what has come; at the end of the stream closes it. Returns 0 when memory is missing. */
static int drain(process *p, int which)
{
    output *t = &p->got[which];
    while (p->ends[which] >= 0 && t->size < p->limit) {
        if (t->room - t->size < CHUNK) {
            size_t room = t->room * 2 > t->size + CHUNK ? t->room * 2 : t->size + CHUNK;
            char *data = realloc(t->data, room);
            if (!data) {
                return 0;
            }
            t->data = data;
            t->room = room;
        }
        ssize_t n = read(p->ends[which], t->data + t->size, CHUNK);
        if (n > 0) {
            t->size += (size_t)n;
        } else if (n == 0 || (errno != EAGAIN && errno != EINTR)) {
            close_end(&p->ends[which]);
        } else {
            break;
        }
    }
    return 1;
}

/* step(seconds, writing): waits for output, room for input (when writing) or the end, at most so long; an arriving signal ends
 * the wait too. True when the child has ended and all of its output is here. */
static int step(lua_State *L)
{
    process *p = check(L);
    double seconds = luaL_checknumber(L, 2);
    int writing = lua_toboolean(L, 3);
    if (p->pidfd < 0 && !p->done && seconds > 0.005) {
        seconds = 0.005; /* nothing tells of its end */
    }
    struct pollfd fds[4];
    nfds_t count = 0;
    for (int i = OUT; i <= ERR; i++) {
        if (p->ends[i] >= 0 && p->got[i].size < p->limit) {
            fds[count++] = (struct pollfd){p->ends[i], POLLIN, 0};
        }
    }
    if (writing && p->ends[IN] >= 0) {
        fds[count++] = (struct pollfd){p->ends[IN], POLLOUT, 0};
    }
    if (p->pidfd >= 0) {
        fds[count++] = (struct pollfd){p->pidfd, POLLIN, 0};
    }
    int milliseconds = seconds > 1e6 ? 1000000000 : (int)(seconds * 1000 + 0.999);
    if (!p->done || count > 0) {
        poll(fds, count, milliseconds < 0 ? 0 : milliseconds);
    }
    reap(p, WNOHANG);
    if (!drain(p, OUT) || !drain(p, ERR)) {
        return rtl_raise(L, "not enough memory for what a program prints");
    }
    if (p->done) { /* a grandchild may hold the pipes: what was written is read, the end is not waited for */
        for (int i = OUT; i <= ERR; i++) {
            if (p->got[i].size < p->limit) {
                close_end(&p->ends[i]);
            }
        }
        close_end(&p->ends[IN]);
    }
    lua_pushboolean(L, p->done && p->ends[OUT] < 0 && p->ends[ERR] < 0);
    return 1;
}

/* write() into a pipe that nobody reads raises SIGPIPE: it is held back and taken away. */
static ssize_t quiet_write(int fd, const char *data, size_t size)
{
    sigset_t pipe_only, before, pending;
    sigemptyset(&pipe_only);
    sigaddset(&pipe_only, SIGPIPE);
    sigpending(&pending);
    int had = sigismember(&pending, SIGPIPE);
    pthread_sigmask(SIG_BLOCK, &pipe_only, &before);
    ssize_t n = write(fd, data, size);
    int error = errno;
    if (n < 0 && error == EPIPE && !had) {
        struct timespec zero = {0, 0};
        while (sigtimedwait(&pipe_only, NULL, &zero) < 0 && errno == EINTR) {
        }
    }
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    errno = error;
    return n;
}

/* feed(text, first): bytes from `first` (counted from 1) that the pipe took now; nil and why when the child reads no more. */
static int feed(lua_State *L)
{
    process *p = check(L);
    size_t size;
    const char *data = luaL_checklstring(L, 2, &size);
    lua_Integer first = luaL_checkinteger(L, 3);
    if (p->ends[IN] < 0 || first < 1) {
        return fail(L, EPIPE);
    }
    size_t from = (size_t)first - 1;
    ssize_t n = from < size ? quiet_write(p->ends[IN], data + from, size - from) : 0;
    if (n < 0 && errno != EAGAIN && errno != EINTR) {
        int error = errno;
        close_end(&p->ends[IN]);
        return fail(L, error);
    }
    lua_pushinteger(L, n < 0 ? 0 : (lua_Integer)n);
    return 1;
}

/* close_input(): the child reads an end of its input. */
static int close_input(lua_State *L)
{
    close_end(&check(L)->ends[IN]);
    return 0;
}

/* take(stream, count): the output that is here (1: standard output, 2: standard error), at most count bytes, and whether it is
 * all there ever is */
static int take(lua_State *L)
{
    process *p = check(L);
    int which = (int)luaL_checkinteger(L, 2);
    luaL_argcheck(L, which == OUT || which == ERR, 2, "1 or 2 is expected");
    output *t = &p->got[which];
    lua_Integer most = luaL_optinteger(L, 3, LUA_MAXINTEGER);
    size_t n = most < 0 ? 0 : (lua_Unsigned)most < t->size ? (size_t)most : t->size;
    lua_pushlstring(L, n ? t->data : "", n);
    t->size -= n;
    if (n && t->size) {
        memmove(t->data, t->data + n, t->size);
    }
    if (!t->size) {
        free(t->data);
        t->data = NULL;
        t->room = 0;
    }
    lua_pushboolean(L, p->ends[which] < 0 && !t->size);
    return 2;
}

/* find_line(): bytes of standard output up to and with the first end of a line, 0: none yet; all that is here when no more comes,
 * and whether so */
static int find_line(lua_State *L)
{
    const process *p = check(L);
    const output *t = &p->got[OUT];
    const char *end = t->size ? memchr(t->data, '\n', t->size) : NULL;
    int closed = p->ends[OUT] < 0;
    lua_pushinteger(L, end ? (lua_Integer)(end - t->data) + 1 : closed ? (lua_Integer)t->size : 0);
    lua_pushboolean(L, closed);
    return 2;
}

static double seconds_of(struct timeval t)
{
    return (double)t.tv_sec + (double)t.tv_usec * 1e-6;
}

/* result(): nil while it runs; { status (128 + n after signal n), signal, seconds, user_seconds, system_seconds, max_rss in bytes
 * }. The system counts what this process held at the fork into max_rss: it is an upper bound. */
static int result(lua_State *L)
{
    process *p = check(L);
    if (!p->done) {
        return 0;
    }
    lua_createtable(L, 0, 6);
    int signalled = WIFSIGNALED(p->status);
    lua_pushinteger(L, signalled ? 128 + WTERMSIG(p->status) : WEXITSTATUS(p->status));
    lua_setfield(L, -2, "status");
    if (signalled) {
        lua_pushinteger(L, WTERMSIG(p->status));
        lua_setfield(L, -2, "signal");
    }
    lua_pushnumber(L, p->seconds);
    lua_setfield(L, -2, "seconds");
    lua_pushnumber(L, seconds_of(p->usage.ru_utime));
    lua_setfield(L, -2, "user_seconds");
    lua_pushnumber(L, seconds_of(p->usage.ru_stime));
    lua_setfield(L, -2, "system_seconds");
    lua_pushinteger(L, (lua_Integer)p->usage.ru_maxrss * 1024);
    lua_setfield(L, -2, "max_rss");
    return 1;
}

static int process_id(lua_State *L)
{
    lua_pushinteger(L, check(L)->pid);
    return 1;
}

static void send(process *p, int signo)
{
    if (p->pid > 0) {
        kill(p->group ? -p->pid : p->pid, signo);
    }
}

/* kill(name): "TERM", "KILL", "INT" or "CONT" to the child, or to its group when it leads one. */
static int send_signal(lua_State *L)
{
    static const char *const names[] = {"TERM", "KILL", "INT", "CONT", NULL};
    static const int numbers[] = {SIGTERM, SIGKILL, SIGINT, SIGCONT};
    process *p = check(L);
    int which = luaL_checkoption(L, 2, "TERM", names);
    reap(p, WNOHANG); /* a number may belong to another process once its own has been waited for; it never is before */
    send(p, numbers[which]);
    return 0;
}

static int release(lua_State *L)
{
    process *p = check(L);
    for (int i = 0; i < 3; i++) {
        close_end(&p->ends[i]);
        free(p->got[i].data);
        memset(&p->got[i], 0, sizeof p->got[i]);
    }
    reap(p, WNOHANG);
    if (p->pid) {
        send(p, SIGKILL);
        reap(p, 0);
    }
    close_end(&p->pidfd);
    return 0;
}

static int to_string(lua_State *L)
{
    process *p = check(L);
    lua_pushfstring(L, p->done ? "rt.process handle (ended)" : "rt.process handle: %d", (int)p->pid);
    return 1;
}

void rtl_open_process(lua_State *L)
{
    static const luaL_Reg methods[] = {{"step", step},     {"feed", feed},           {"close_input", close_input},
                                       {"take", take},     {"find_line", find_line}, {"result", result},
                                       {"id", process_id}, {"kill", send_signal},    {NULL, NULL}};
    static const luaL_Reg functions[] = {{"process_start", process_start}, {NULL, NULL}};
    rtl_class(L, RTL_PROCESS, methods, release, to_string);
    rtl_add_functions(L, functions);
}
