#include "binding.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>

#define RTL_FAILURE "rt.failure" /* key of the registry */

/* ---- errors ---- */

const char rtl_lost_place = 0;

static int starts_with(const char *s, const char *head)
{
    return strncmp(s, head, strlen(head)) == 0;
}

int rtl_place(lua_State *L)
{
    lua_Debug ar;
    for (int level = 0; lua_getstack(L, level, &ar); level++) {
        lua_getinfo(L, "Sl", &ar);
        if (strcmp(ar.source, "=rt/run.lua") == 0) { /* what called the script; above it nothing is the script's */
            break;
        }
        if (ar.currentline > 0 && !starts_with(ar.source, "=rt/") && !starts_with(ar.source, "=rtray/")) {
            lua_pushfstring(L, "%s:%d: ", ar.short_src, ar.currentline);
            return 1;
        }
    }
    return 0;
}

void rtl_where(lua_State *L)
{
    if (rtl_place(L)) {
        return;
    }
    if (lua_rawgetp(L, LUA_REGISTRYINDEX, &rtl_lost_place) != LUA_TFUNCTION || lua_pcall(L, 0, 1, 0) != LUA_OK) {
        lua_pop(L, 1);
        lua_pushliteral(L, "");
    }
}

int rtl_raise(lua_State *L, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    rtl_where(L);
    lua_pushvfstring(L, format, args);
    va_end(args);
    lua_concat(L, 2);
    return lua_error(L);
}

/* The library begins its sentences with the C function's name, which means nothing to a script. */
static const char *without_function(const char *text)
{
    size_t n = strspn(text, "abcdefghijklmnopqrstuvwxyz0123456789_");
    return starts_with(text, "rt_") && starts_with(text + n, ": ") ? text + n + 2 : text;
}

int rtl_raise_text(lua_State *L, const char *text, rt_status status)
{
    text = text[0] ? without_function(text) : rt_status_name(status);
    lua_createtable(L, 0, 2); /* messages are strings; who needs the status of one asks last_failure */
    lua_pushstring(L, rt_status_name(status));
    lua_setfield(L, -2, "status");
    lua_pushstring(L, text);
    lua_setfield(L, -2, "text");
    lua_setfield(L, LUA_REGISTRYINDEX, RTL_FAILURE);
    return rtl_raise(L, "%s", text);
}

void rtl_check(lua_State *L, rtl_context *c, rt_status status)
{
    if (status == RT_OK) {
        return;
    }
    char text[1024] = "";
    rt_context_error(rtl_context_rt(c), text, sizeof text);
    rtl_raise_text(L, text, status);
}

/* last_failure() -> { status = "RT_ERROR_IO", text = ... } of the last call that librt refused | nil */
static int last_failure(lua_State *L)
{
    lua_getfield(L, LUA_REGISTRYINDEX, RTL_FAILURE);
    return 1;
}

void rtl_open_common(lua_State *L)
{
    static const luaL_Reg functions[] = {{"last_failure", last_failure}, {NULL, NULL}};
    rtl_add_functions(L, functions);
}

/* ---- the state ---- */

void rtl_account(lua_State *L, uint64_t bytes)
{
    /* A step by hand would also run in a collector that the user has stopped. */
    if (bytes >= 1024 && lua_gc(L, LUA_GCISRUNNING)) {
        uint64_t kib = bytes / 1024;
        lua_gc(L, LUA_GCSTEP, (int)(kib < (1u << 20) ? kib : (1u << 20)));
    }
}

static int empty(lua_State *L)
{
    (void)L;
    return 0;
}

void rtl_breathe(lua_State *L)
{
    lua_rawgeti(L, LUA_REGISTRYINDEX, LUA_RIDX_MAINTHREAD);
    lua_State *main = lua_tothread(L, -1);
    lua_pop(L, 1);
    if (main == L) {
        lua_pushcfunction(L, empty);
        lua_call(L, 0, 0);
        return;
    }
    if (!lua_checkstack(main, 2)) {
        return;
    }
    lua_pushcfunction(main, empty);
    if (lua_pcall(main, 0, 0, 0) != LUA_OK) {
        lua_xmove(main, L, 1);
        lua_error(L);
    }
}

void rtl_class(lua_State *L, const char *name, const luaL_Reg *methods, lua_CFunction release, lua_CFunction to_string)
{
    luaL_newmetatable(L, name);
    lua_newtable(L);
    luaL_setfuncs(L, methods, 0);
    if (release) {
        lua_pushcfunction(L, release);
        lua_pushvalue(L, -1);
        lua_setfield(L, -3, "release");
        lua_pushvalue(L, -1);
        lua_setfield(L, -4, "__gc");
        lua_setfield(L, -3, "__close");
    }
    lua_setfield(L, -2, "__index");
    lua_pushcfunction(L, to_string);
    lua_setfield(L, -2, "__tostring");
    lua_pop(L, 1);
}

void rtl_add_functions(lua_State *L, const luaL_Reg *functions)
{
    luaL_setfuncs(L, functions, 0);
}

/* ---- fields ---- */

static int get(lua_State *L, int index, const char *key)
{
    if (lua_getfield(L, index, key) == LUA_TNIL) {
        lua_pop(L, 1);
        return 0;
    }
    return 1;
}

static double number_on_top(lua_State *L, const char *key)
{
    if (lua_type(L, -1) != LUA_TNUMBER) {
        rtl_raise(L, "%s must be a number; got a %s", key, luaL_typename(L, -1));
    }
    return lua_tonumber(L, -1);
}

int rtl_field_number(lua_State *L, int index, const char *key, double *value)
{
    if (!get(L, index, key)) {
        return 0;
    }
    *value = number_on_top(L, key);
    lua_pop(L, 1);
    return 1;
}

int rtl_field_float(lua_State *L, int index, const char *key, float *value)
{
    double number;
    if (!rtl_field_number(L, index, key, &number)) {
        return 0;
    }
    *value = (float)number;
    return 1;
}

static uint64_t whole(lua_State *L, const char *key, uint64_t high)
{
    int ok;
    lua_Integer n = lua_tointegerx(L, -1, &ok);
    if (lua_type(L, -1) != LUA_TNUMBER || !ok || n < 0 || (uint64_t)n > high) {
        lua_Integer shown = (lua_Integer)(high > LUA_MAXINTEGER ? LUA_MAXINTEGER : high);
        rtl_raise(L, "%s must be a whole number from 0 to %I; got %s", key, (LUAI_UACINT)shown, luaL_tolstring(L, -1, NULL));
    }
    return (uint64_t)n;
}

int rtl_field_u32(lua_State *L, int index, const char *key, uint32_t *value)
{
    if (!get(L, index, key)) {
        return 0;
    }
    *value = (uint32_t)whole(L, key, UINT32_MAX);
    lua_pop(L, 1);
    return 1;
}

int rtl_field_u64(lua_State *L, int index, const char *key, uint64_t *value)
{
    if (!get(L, index, key)) {
        return 0;
    }
    *value = whole(L, key, UINT64_MAX);
    lua_pop(L, 1);
    return 1;
}

int rtl_field_bool(lua_State *L, int index, const char *key, int *value)
{
    if (!get(L, index, key)) {
        return 0;
    }
    *value = lua_toboolean(L, -1);
    lua_pop(L, 1);
    return 1;
}

static void floats_on_top(lua_State *L, const char *key, float *values, int count)
{
    if (lua_type(L, -1) != LUA_TTABLE) {
        rtl_raise(L, "%s must be a table of %d numbers; got a %s", key, count, luaL_typename(L, -1));
    }
    for (int i = 0; i < count; i++) {
        if (lua_rawgeti(L, -1, i + 1) != LUA_TNUMBER) {
            rtl_raise(L, "%s must be a table of %d numbers; number %d is a %s", key, count, i + 1, luaL_typename(L, -1));
        }
        values[i] = (float)lua_tonumber(L, -1);
        lua_pop(L, 1);
    }
}

int rtl_field_floats(lua_State *L, int index, const char *key, float *values, int count)
{
    if (!get(L, index, key)) {
        return 0;
    }
    floats_on_top(L, key, values, count);
    lua_pop(L, 1);
    return 1;
}

int rtl_field_vec3(lua_State *L, int index, const char *key, rt_vec3 *value)
{
    float v[3];
    if (!rtl_field_floats(L, index, key, v, 3)) {
        return 0;
    }
    *value = (rt_vec3){v[0], v[1], v[2]};
    return 1;
}

int rtl_field_string(lua_State *L, int index, const char *key, const char **value)
{
    if (!get(L, index, key)) {
        return 0;
    }
    if (lua_type(L, -1) != LUA_TSTRING) {
        rtl_raise(L, "%s must be a string; got a %s", key, luaL_typename(L, -1));
    }
    *value = lua_tostring(L, -1);
    lua_pop(L, 1);
    return 1;
}

int rtl_field_choice(lua_State *L, int index, const char *key, const char *const *names, int *value)
{
    const char *text;
    if (!rtl_field_string(L, index, key, &text)) {
        return 0;
    }
    for (int i = 0; names[i]; i++) {
        if (strcmp(names[i], text) == 0) {
            *value = i;
            return 1;
        }
    }
    luaL_Buffer b;
    luaL_buffinit(L, &b);
    for (int i = 0; names[i]; i++) {
        luaL_addstring(&b, i ? ", " : "");
        luaL_addstring(&b, names[i]);
    }
    luaL_pushresult(&b);
    return rtl_raise(L, "%s '%s' is not known; known are %s", key, text, lua_tostring(L, -1));
}

/* ---- values ---- */

void rtl_push_vec3(lua_State *L, rt_vec3 v)
{
    const float xyz[3] = {v.x, v.y, v.z};
    lua_createtable(L, 3, 0);
    for (int i = 0; i < 3; i++) {
        lua_pushnumber(L, (lua_Number)xyz[i]);
        lua_rawseti(L, -2, i + 1);
    }
}

rt_vec3 rtl_check_vec3(lua_State *L, int index, const char *what)
{
    float v[3];
    lua_pushvalue(L, index);
    floats_on_top(L, what, v, 3);
    lua_pop(L, 1);
    return (rt_vec3){v[0], v[1], v[2]};
}

uint32_t rtl_check_u32(lua_State *L, int index, const char *what)
{
    lua_pushvalue(L, index);
    uint32_t n = (uint32_t)whole(L, what, UINT32_MAX);
    lua_pop(L, 1);
    return n;
}

const char *rtl_check_path(lua_State *L, int index)
{
    if (lua_type(L, index) != LUA_TSTRING) {
        rtl_raise(L, "a file name must be a string; got a %s", luaL_typename(L, index));
    }
    size_t size;
    const char *path = lua_tolstring(L, index, &size);
    if (size == 0 || strlen(path) != size) {
        rtl_raise(L, size == 0 ? "the file name is empty" : "the file name has a NUL byte inside");
    }
    return path;
}
