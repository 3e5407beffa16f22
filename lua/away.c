/* Long calls of the library, made on a thread of their own while the calling thread waits in steps: so an interrupt of the Lua
 * state ends a build or a walk over a tree as it ends a render. */
#include "binding.h"

#include <pthread.h>
#include <signal.h>
#include <string.h>
#include <time.h>

typedef struct work {
    rt_context *context;
    rt_status (*call)(void *data);
    void *data;
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    int ended;
    rt_status status;
    char message[1024]; /* the library remembers messages by thread */
} work;

static void *run(void *data)
{
    work *w = data;
    rt_status status = w->call(w->data);
    if (status != RT_OK) {
        rt_context_error(w->context, w->message, sizeof w->message);
    }
    pthread_mutex_lock(&w->mutex);
    w->status = status;
    w->ended = 1;
    pthread_cond_signal(&w->changed);
    pthread_mutex_unlock(&w->mutex);
    return NULL;
}

/* Signals are for the program's own threads. */
static int start(pthread_t *thread, work *w)
{
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    int error = pthread_create(thread, NULL, run, w);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return error;
}

/* Waits 50 ms at most; returns whether the work has ended. */
static int wait_step(work *w)
{
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_nsec += 50000000;
    if (until.tv_nsec >= 1000000000) {
        until.tv_nsec -= 1000000000;
        until.tv_sec++;
    }
    pthread_mutex_lock(&w->mutex);
    if (!w->ended) {
        pthread_cond_timedwait(&w->changed, &w->mutex, &until);
    }
    int ended = w->ended;
    pthread_mutex_unlock(&w->mutex);
    return ended;
}

static int breathe(lua_State *L)
{
    rtl_breathe(L);
    return 0;
}

void rtl_away(lua_State *L, rtl_context *c, rt_status (*call)(void *data), void (*cancel)(void *data), void *data)
{
    work w = {.context = rtl_context_rt(c),
              .call = call,
              .data = data,
              .mutex = PTHREAD_MUTEX_INITIALIZER,
              .changed = PTHREAD_COND_INITIALIZER};
    pthread_t thread;
    luaL_checkstack(L, 8, "out of stack");
    if (start(&thread, &w) != 0) { /* no thread to be had: here */
        rtl_check(L, c, call(data));
        return;
    }
    int interrupted = 0;
    while (!wait_step(&w)) {
        if (!interrupted) {
            lua_pushcfunction(L, breathe);
            interrupted = lua_pcall(L, 0, 0, 0) != LUA_OK; /* what was raised stays on the stack */
        }
        if (interrupted) {
            cancel(data);
        }
    }
    pthread_join(thread, NULL);
    pthread_cond_destroy(&w.changed);
    pthread_mutex_destroy(&w.mutex);
    if (interrupted) {
        lua_error(L);
    }
    if (w.status != RT_OK) {
        rtl_raise_text(L, w.message, w.status);
    }
}
