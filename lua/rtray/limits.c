/* Limits of time and memory that hold wherever the program is: in a script (also inside of string.rep and string.find, where no
 * hook of Lua runs), in a build, in a render.
 *
 * Memory: Lua's allocator and the renderer's draw on one account. Time: a thread waits for the end. It first asks: Lua code is
 * interrupted at its next instruction, loops that poll sys.interrupted() stop and keep what is finished. What has not ended a
 * moment later is inside of a long call: the process then says so and ends. */
#include "rtray.h"

#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { STATUS_SCENE = 1 };
static const double GRACE = 0.5; /* seconds between asking and ending */

static atomic_uint_fast64_t used, limit; /* bytes; limit 0: none */
static atomic_int phase;                 /* what goes on */
static atomic_int refused;               /* 1 + the phase in which a request was first refused; 0: none was */

static const char *const PHASES[] = {"in the script", "in the build of the trees", "in the render", NULL};

static struct watch {
    pthread_mutex_t lock;
    pthread_cond_t changed; /* on the monotonic clock */
    pthread_t thread, main;
    bool running, armed, asked;
    struct timespec end; /* when to ask; when asked: when to end the process */
    char words[256];     /* "the time limit of 10s ran out" */
    int phase;           /* in which it ran out */
} watch = {.lock = PTHREAD_MUTEX_INITIALIZER};

/* ---- memory ---- */

static bool charge(uint64_t more)
{
    uint_fast64_t now = atomic_load_explicit(&used, memory_order_relaxed);
    do {
        uint64_t most = atomic_load_explicit(&limit, memory_order_relaxed);
        if (most && (more > most || now > most - more)) {
            int none = 0;
            atomic_compare_exchange_strong(&refused, &none, 1 + atomic_load(&phase));
            return false;
        }
    } while (!atomic_compare_exchange_weak_explicit(&used, &now, now + more, memory_order_relaxed, memory_order_relaxed));
    return true;
}

static void *allocate(void *ptr, size_t old_size, size_t new_size)
{
    if (new_size == 0) {
        rt_allocate(NULL, ptr, old_size, 0);
        atomic_fetch_sub_explicit(&used, old_size, memory_order_relaxed);
        return NULL;
    }
    if (new_size > old_size && !charge(new_size - old_size)) {
        return NULL;
    }
    void *moved = rt_allocate(NULL, ptr, old_size, new_size);
    if (!moved && new_size > old_size) {
        atomic_fetch_sub_explicit(&used, new_size - old_size, memory_order_relaxed);
    } else if (moved && new_size < old_size) {
        atomic_fetch_sub_explicit(&used, old_size - new_size, memory_order_relaxed);
    }
    return moved;
}

void *rtray_allocate(void *user, void *ptr, size_t old_size, size_t new_size)
{
    (void)user;
    return allocate(ptr, ptr ? old_size : 0, new_size); /* Lua names the kind of a new object in old_size */
}

/* limit_memory(bytes | 0): Lua and the renderer together. */
static int limit_memory(lua_State *L)
{
    atomic_store(&limit, (uint_fast64_t)luaL_checkinteger(L, 1));
    atomic_store(&refused, 0);
    return 0;
}

/* memory_refused(): the phase in which a request was refused because of the limit, or nil. It is forgotten by asking. */
static int memory_refused(lua_State *L)
{
    int found = atomic_exchange(&refused, 0);
    lua_pushstring(L, found ? PHASES[found - 1] : NULL);
    return 1;
}

/* ---- time ---- */

static void add_seconds(struct timespec *t, double seconds)
{
    clock_gettime(CLOCK_MONOTONIC, t);
    t->tv_sec += (time_t)seconds;
    t->tv_nsec += (long)((seconds - (double)(time_t)seconds) * 1e9);
    if (t->tv_nsec >= 1000000000) {
        t->tv_sec++;
        t->tv_nsec -= 1000000000;
    }
}

static void end_process(void)
{
    char text[512];
    int n = snprintf(text, sizeof text, "rtray: %s %s\n", watch.words, PHASES[watch.phase]);
    ssize_t written = write(STDERR_FILENO, text, (size_t)n);
    (void)written;
    _exit(STATUS_SCENE);
}

static void *run(void *unused)
{
    (void)unused;
    pthread_mutex_lock(&watch.lock);
    for (;;) {
        if (!watch.armed) {
            pthread_cond_wait(&watch.changed, &watch.lock);
        } else if (pthread_cond_timedwait(&watch.changed, &watch.lock, &watch.end) == ETIMEDOUT && watch.armed) {
            struct timespec now;
            clock_gettime(CLOCK_MONOTONIC, &now);
            if (now.tv_sec < watch.end.tv_sec || (now.tv_sec == watch.end.tv_sec && now.tv_nsec < watch.end.tv_nsec)) {
                continue; /* it was put off meanwhile */
            }
            if (watch.asked) {
                end_process();
            }
            watch.asked = true;
            watch.phase = atomic_load(&phase);
            add_seconds(&watch.end, GRACE);
            pthread_kill(watch.main, SIGALRM); /* signals.c: the Lua state is touched by its own thread alone */
        }
    }
    return NULL;
}

static bool start(void)
{
    pthread_condattr_t monotonic;
    sigset_t all, before;
    if (watch.running) {
        return true;
    }
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_cond_init(&watch.changed, &monotonic);
    pthread_condattr_destroy(&monotonic);
    watch.main = pthread_self();
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before); /* signals are for the main thread */
    watch.running = pthread_create(&watch.thread, NULL, run, NULL) == 0;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return watch.running;
}

/* limit_time(seconds | nil, words): the time that Lua, builds and renders have from now on; nil: all of it. true, or nil when
 * there is no thread. */
static int limit_time(lua_State *L)
{
    double seconds = luaL_optnumber(L, 1, -1.0);
    const char *words = luaL_optstring(L, 2, "");
    if (seconds >= 0 && !start()) {
        return 0;
    }
    if (watch.running) {
        pthread_mutex_lock(&watch.lock);
        watch.armed = seconds >= 0;
        watch.asked = false;
        add_seconds(&watch.end, seconds >= 0 ? seconds : 0);
        snprintf(watch.words, sizeof watch.words, "%s", words);
        pthread_cond_signal(&watch.changed);
        pthread_mutex_unlock(&watch.lock);
        rtray_forget_time();
    }
    lua_pushboolean(L, 1);
    return 1;
}

/* limit_grace(seconds): once asked, the time there is for saving what is finished. */
static int limit_grace(lua_State *L)
{
    pthread_mutex_lock(&watch.lock);
    if (watch.running && watch.asked) {
        add_seconds(&watch.end, luaL_checknumber(L, 1));
        pthread_cond_signal(&watch.changed);
    }
    pthread_mutex_unlock(&watch.lock);
    return 0;
}

/* phase(words | nil): what goes on, one of PHASES; gives what went on before. */
static int set_phase(lua_State *L)
{
    int before = atomic_load(&phase);
    if (!lua_isnoneornil(L, 1)) {
        atomic_store(&phase, luaL_checkoption(L, 1, NULL, PHASES));
    }
    lua_pushstring(L, PHASES[before]);
    return 1;
}

/* limit_words(): "the time limit of 10s ran out in the script". */
static int limit_words(lua_State *L)
{
    char text[sizeof watch.words + 64];
    pthread_mutex_lock(&watch.lock);
    snprintf(text, sizeof text, "%s %s", watch.words, PHASES[watch.phase]);
    pthread_mutex_unlock(&watch.lock);
    lua_pushstring(L, text);
    return 1;
}

void rtray_open_limits(lua_State *L)
{
    static const luaL_Reg functions[] = {{"limit_memory", limit_memory},
                                         {"memory_refused", memory_refused},
                                         {"limit_time", limit_time},
                                         {"limit_grace", limit_grace},
                                         {"limit_words", limit_words},
                                         {"phase", set_phase},
                                         {NULL, NULL}};
    luaL_setfuncs(L, functions, 0);
}
