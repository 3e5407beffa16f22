/* SIGINT and SIGTERM. The handler notes the signal and, unless the program asked to look for itself, hangs a hook into the Lua
 * state that raises at the next instruction (as the stock interpreter does). The note is a global because a handler has no other
 * way to reach it. */
#include "rtray.h"

#include <signal.h>
#include <string.h>
#include <time.h>

static volatile sig_atomic_t caught;    /* the first signal, 0: none */
static volatile sig_atomic_t timed_out; /* the limit of time ran out (limits.c) */
static volatile sig_atomic_t deferred;  /* the program polls sys.interrupted */
static struct timespec caught_at;       /* written by the handler alone, which no other signal of ours interrupts */
static lua_State *volatile state;

static void raise_interrupted(lua_State *L, lua_Debug *ar)
{
    (void)ar;
    lua_sethook(L, NULL, 0, 0);
    luaL_error(L, "interrupted");
}

static void set_default(int signo)
{
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = SIG_DFL;
    sigemptyset(&action.sa_mask);
    sigaction(signo, &action, NULL);
}

/* Starters that hand on a terminal's Ctrl-C make two signals of one: the second counts when it comes later. */
#define SAME_NANOSECONDS 100000000

static void on_signal(int signo)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    if (caught) {
        if ((now.tv_sec - caught_at.tv_sec) * 1000000000LL + now.tv_nsec - caught_at.tv_nsec > SAME_NANOSECONDS) {
            set_default(signo);
            raise(signo);
        }
        return;
    }
    caught_at = now;
    caught = signo;
    if (!deferred && state) {
        lua_sethook(state, raise_interrupted, LUA_MASKCALL | LUA_MASKRET | LUA_MASKLINE | LUA_MASKCOUNT, 1);
    }
}

/* The watch of limits.c asks. Its signal is sent to the main thread alone. */
static void on_time_out(int signo)
{
    (void)signo;
    timed_out = 1;
    if (!deferred && state) {
        lua_sethook(state, raise_interrupted, LUA_MASKCALL | LUA_MASKRET | LUA_MASKLINE | LUA_MASKCOUNT, 1);
    }
}

void rtray_forget_time(void)
{
    if (timed_out && !caught && state) {
        lua_sethook(state, NULL, 0, 0);
    }
    timed_out = 0;
}

void rtray_catch_signals(lua_State *L)
{
    static const int signals[] = {SIGINT, SIGTERM};
    state = L;
    for (size_t i = 0; i < sizeof signals / sizeof signals[0]; i++) {
        struct sigaction action;
        if (sigaction(signals[i], NULL, &action) == 0 && action.sa_handler == SIG_IGN) {
            continue; /* started by nohup or in the background of a shell script: stay so */
        }
        memset(&action, 0, sizeof action);
        action.sa_handler = on_signal;
        sigemptyset(&action.sa_mask);
        sigaddset(&action.sa_mask, SIGINT);
        sigaddset(&action.sa_mask, SIGTERM);
        sigaction(signals[i], &action, NULL);
    }
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = on_time_out;
    sigemptyset(&action.sa_mask);
    sigaction(SIGALRM, &action, NULL);
}

void rtray_end_by_signal(void)
{
    if (caught) {
        int signo = caught;
        sigset_t set;
        set_default(signo);
        sigemptyset(&set);
        sigaddset(&set, signo);
        sigprocmask(SIG_UNBLOCK, &set, NULL);
        raise(signo);
    }
}

/* interrupted(): "SIGINT" or "SIGTERM" once one was caught, "time" once the limit of time ran out, else nil. */
static int interrupted(lua_State *L)
{
    if (!caught && timed_out) {
        lua_pushliteral(L, "time");
        return 1;
    }
    if (!caught) {
        return 0;
    }
    lua_pushstring(L, caught == SIGINT ? "SIGINT" : "SIGTERM");
    return 1;
}

/* defer(on): while on, signals are only noted. */
static int defer(lua_State *L)
{
    deferred = lua_toboolean(L, 1);
    return 0;
}

/* forgive(): forgets a SIGINT (the reader of lines goes on after it). */
static int forgive(lua_State *L)
{
    caught = 0;
    lua_sethook(L, NULL, 0, 0);
    return 0;
}

void rtray_open_signals(lua_State *L)
{
    static const luaL_Reg functions[] = {{"interrupted", interrupted}, {"defer", defer}, {"forgive", forgive}, {NULL, NULL}};
    luaL_setfuncs(L, functions, 0);
}
