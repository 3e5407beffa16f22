#include "binding.h"

#include <pthread.h>
#include <signal.h>
#include <string.h>
#include <time.h>

/* Committing builds trees, which may take long. It runs on a thread of its own while the calling thread waits in steps, so that
 * an interrupt of the Lua state ends a build as it ends a render. */
typedef struct work {
    rt_scene *scene;
    const rt_commit_desc *desc;
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    int ended;
    rt_status status;
    char message[1024]; /* the library remembers messages by thread */
} work;

static void *run(void *data)
{
    work *w = data;
    rt_status status = rt_scene_commit(w->scene, w->desc);
    if (status != RT_OK) {
        rt_context_error(rt_scene_context(w->scene), w->message, sizeof w->message);
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

static rt_commit_desc fields(lua_State *L, int t)
{
    rt_commit_desc d = rt_commit_desc_default();
    rtl_field_string(L, t, "accel", &d.accel);
    rtl_field_string(L, t, "builder", &d.builder);
    rtl_field_u32(L, t, "tree_depth", &d.max_depth);
    rtl_field_u32(L, t, "leaf_size", &d.leaf_size);
    rtl_field_float(L, t, "cost_traverse", &d.cost_traverse);
    rtl_field_float(L, t, "cost_intersect", &d.cost_intersect);
    rtl_field_float(L, t, "empty_bonus", &d.empty_bonus);
    rtl_field_float(L, t, "duplication", &d.duplication);
    return d;
}

static void account(lua_State *L, rt_scene *scene)
{
    rt_scene_info info;
    if (rt_scene_get_info(scene, &info) == RT_OK) {
        rtl_account(L, info.total_bytes);
    }
}

/* scene_commit(scene, fields) */
static int commit(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_commit_desc d = fields(L, 2);
    work w = {.scene = scene, .desc = &d, .mutex = PTHREAD_MUTEX_INITIALIZER, .changed = PTHREAD_COND_INITIALIZER};
    pthread_t thread;
    if (start(&thread, &w) != 0) { /* no thread to be had: build here */
        rtl_check(L, c, rt_scene_commit(scene, &d));
        account(L, scene);
        return 0;
    }
    int interrupted = 0;
    while (!wait_step(&w)) {
        if (!interrupted) {
            lua_pushcfunction(L, breathe);
            interrupted = lua_pcall(L, 0, 0, 0) != LUA_OK; /* what was raised stays on the stack */
        }
        if (interrupted) {
            rt_scene_cancel(scene);
        }
    }
    pthread_join(thread, NULL);
    pthread_cond_destroy(&w.changed);
    pthread_mutex_destroy(&w.mutex);
    if (interrupted) {
        return lua_error(L);
    }
    if (w.status != RT_OK) {
        return rtl_raise_text(L, w.message, w.status);
    }
    account(L, scene);
    return 0;
}

void rtl_open_commit(lua_State *L)
{
    static const luaL_Reg functions[] = {{"scene_commit", commit}, {NULL, NULL}};
    rtl_add_functions(L, functions);
}
