#include "binding.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

/* Log lines come from any thread, but Lua is entered by the calling thread only: they wait here until it asks. */
enum { LOG_LINES = 256, LOG_BYTES = 512 };
typedef struct log_line {
    rt_log_level level;
    char text[LOG_BYTES];
} log_line;

struct rtl_context {
    rt_context *rt;
    unsigned references; /* touched by the Lua state's thread alone */
    pthread_mutex_t mutex;
    unsigned count, lost;
    log_line lines[LOG_LINES];
};

static const char KEY = 'c';      /* its address is the registry's key */
static const char DEFAULTS = 'd'; /* and its: a userdata with the host's descriptor */
static const char *const LEVELS[] = {"error", "warning", "info", "debug"};

static void on_log(void *user, rt_log_level level, const char *message)
{
    rtl_context *c = user;
    if (level > RT_LOG_INFO) {
        return;
    }
    pthread_mutex_lock(&c->mutex);
    if (c->count == LOG_LINES) {
        c->lost++;
    } else {
        log_line *line = &c->lines[c->count++];
        line->level = level;
        size_t size = strlen(message);
        size = size < LOG_BYTES ? size : LOG_BYTES - 1;
        memcpy(line->text, message, size);
        line->text[size] = 0;
    }
    pthread_mutex_unlock(&c->mutex);
}

rt_context *rtl_context_rt(const rtl_context *c)
{
    return c->rt;
}

rtl_context *rtl_context_keep(rtl_context *c)
{
    c->references++;
    return c;
}

void rtl_context_drop(rtl_context *c)
{
    if (c && --c->references == 0) {
        rt_context_destroy(c->rt);
        pthread_mutex_destroy(&c->mutex);
        free(c);
    }
}

static int release(lua_State *L)
{
    rtl_context **slot = lua_touserdata(L, 1);
    rtl_context_drop(*slot);
    *slot = NULL;
    return 0;
}

/* The userdata that holds the state's own reference, or nil. */
static rtl_context **slot_of(lua_State *L)
{
    lua_rawgetp(L, LUA_REGISTRYINDEX, &KEY);
    rtl_context **slot = lua_touserdata(L, -1);
    lua_pop(L, 1);
    return slot;
}

static rtl_context *make(lua_State *L, rtl_context **slot, const rt_context_desc *desc)
{
    rtl_context *c = calloc(1, sizeof *c);
    if (!c) {
        rtl_raise(L, "out of memory");
    }
    c->references = 1;
    pthread_mutex_init(&c->mutex, NULL);
    *slot = c;
    rt_context_desc d = *desc;
    d.log = on_log;
    d.log_user = c;
    rt_status status = rt_context_create(&d, &c->rt);
    if (status != RT_OK) {
        *slot = NULL;
        pthread_mutex_destroy(&c->mutex);
        free(c);
        rtl_raise(L, "the renderer could not be started: %s", rt_status_name(status));
        return NULL;
    }
    return c;
}

void rtl_context_defaults(lua_State *L, const rt_context_desc *desc)
{
    rt_context_desc *kept = lua_newuserdatauv(L, sizeof *kept, 0);
    *kept = *desc;
    lua_rawsetp(L, LUA_REGISTRYINDEX, &DEFAULTS);
}

static rt_context_desc defaults(lua_State *L)
{
    rt_context_desc desc = rt_context_desc_default();
    if (lua_rawgetp(L, LUA_REGISTRYINDEX, &DEFAULTS) == LUA_TUSERDATA) {
        desc = *(const rt_context_desc *)lua_touserdata(L, -1);
    }
    lua_pop(L, 1);
    return desc;
}

rtl_context *rtl_context_get(lua_State *L)
{
    rtl_context **slot = slot_of(L);
    if (*slot) {
        return *slot;
    }
    rt_context_desc desc = defaults(L);
    return make(L, slot, &desc);
}

/* configure{workers, memory_limit}: true when the context was made by this call, false when one exists. */
static int configure(lua_State *L)
{
    rtl_context **slot = slot_of(L);
    if (*slot) {
        lua_pushboolean(L, 0);
        return 1;
    }
    rt_context_desc desc = defaults(L);
    rtl_field_u32(L, 1, "workers", &desc.workers);
    uint64_t limit = desc.memory_limit;
    rtl_field_u64(L, 1, "memory_limit", &desc.memory_limit);
    if (limit && (desc.memory_limit == 0 || desc.memory_limit > limit)) { /* the host's limit is not raised */
        desc.memory_limit = limit;
    }
    make(L, slot, &desc);
    lua_pushboolean(L, 1);
    return 1;
}

/* The waiting log lines as {{level, text}, ...}; nil when there are none. */
static int take_log(lua_State *L)
{
    rtl_context **slot = slot_of(L);
    if (!*slot || (*slot)->count == 0) {
        return 0;
    }
    rtl_context *c = *slot;
    pthread_mutex_lock(&c->mutex);
    unsigned count = c->count, lost = c->lost;
    pthread_mutex_unlock(&c->mutex);
    lua_createtable(L, (int)count + 1, 0);
    for (unsigned i = 0; i < count; i++) { /* written lines do not change, and only this thread takes them away */
        lua_createtable(L, 2, 0);
        lua_pushstring(L, LEVELS[c->lines[i].level]);
        lua_rawseti(L, -2, 1);
        lua_pushstring(L, c->lines[i].text);
        lua_rawseti(L, -2, 2);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    if (lost) {
        lua_createtable(L, 2, 0);
        lua_pushstring(L, LEVELS[RT_LOG_WARNING]);
        lua_rawseti(L, -2, 1);
        lua_pushfstring(L, "%d more messages were dropped", (int)lost);
        lua_rawseti(L, -2, 2);
        lua_rawseti(L, -2, (lua_Integer)count + 1);
    }
    pthread_mutex_lock(&c->mutex);
    memmove(c->lines, c->lines + count, (c->count - count) * sizeof c->lines[0]);
    c->count -= count;
    c->lost = 0;
    pthread_mutex_unlock(&c->mutex);
    return 1;
}

static int workers(lua_State *L)
{
    lua_pushinteger(L, rt_context_workers(rtl_context_get(L)->rt));
    return 1;
}

static int memory(lua_State *L)
{
    uint64_t now, peak;
    rt_context_memory(rtl_context_get(L)->rt, &now, &peak);
    lua_pushinteger(L, (lua_Integer)now);
    lua_pushinteger(L, (lua_Integer)peak);
    return 2;
}

static void set_count(lua_State *L, const char *key, uint64_t value)
{
    lua_pushinteger(L, (lua_Integer)value);
    lua_setfield(L, -2, key);
}

static void set_seconds(lua_State *L, const char *key, double value)
{
    lua_pushnumber(L, (lua_Number)value);
    lua_setfield(L, -2, key);
}

static int counts(lua_State *L)
{
    rt_context_work_stats w = rt_context_work(rtl_context_get(L)->rt);
    lua_createtable(L, 0, 9);
    set_count(L, "files_read", w.files_read);
    set_count(L, "files_kept", w.files_kept);
    set_count(L, "trees_built", w.trees_built);
    set_count(L, "top_trees_built", w.top_trees_built);
    set_count(L, "trees_kept", w.trees_kept);
    set_count(L, "trees_refitted", w.trees_refitted);
    set_seconds(L, "read_seconds", w.read_seconds);
    set_seconds(L, "build_seconds", w.build_seconds);
    set_seconds(L, "saved_seconds", w.saved_seconds);
    return 1;
}

static int drop_kept(lua_State *L)
{
    rt_context_drop_kept(rtl_context_get(L)->rt);
    return 0;
}

static int version(lua_State *L)
{
    lua_pushstring(L, rt_version());
    lua_pushstring(L, rt_build_info());
    return 2;
}

static int machine(lua_State *L)
{
    lua_pushinteger(L, rt_cpu_count());
    lua_pushinteger(L, (lua_Integer)rt_memory_available());
    lua_pushstring(L, rt_isa());
    return 3;
}

void rtl_open_context(lua_State *L)
{
    static const luaL_Reg functions[] = {{"configure", configure}, {"take_log", take_log},   {"workers", workers},
                                         {"memory", memory},       {"version", version},     {"machine", machine},
                                         {"counts", counts},       {"drop_kept", drop_kept}, {NULL, NULL}};
    rtl_context **slot = lua_newuserdatauv(L, sizeof(rtl_context *), 0);
    *slot = NULL;
    lua_createtable(L, 0, 1);
    lua_pushcfunction(L, release);
    lua_setfield(L, -2, "__gc");
    lua_setmetatable(L, -2);
    lua_rawsetp(L, LUA_REGISTRYINDEX, &KEY);
    rtl_add_functions(L, functions);
}
