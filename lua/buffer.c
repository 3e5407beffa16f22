#include "binding.h"

#include <math.h>
#include <string.h>

/* rt.buffer: a fixed number of values of one type in one block of Lua's own memory, so the collector knows its size.
 * Elements count from 1, as Lua's lists do. */

static const char *const TYPES[] = {"f32", "u32", "u8", NULL};
static const size_t SIZES[] = {4, 4, 1};

static rtl_buffer *check(lua_State *L, int arg)
{
    return luaL_checkudata(L, arg, RTL_BUFFER);
}

rtl_buffer *rtl_buffer_new(lua_State *L, rtl_type type, size_t count)
{
    if (count > ((size_t)1 << 40) / SIZES[type]) {
        rtl_raise(L, "a buffer of %I values is too large", (LUAI_UACINT)count);
    }
    rtl_buffer *b = lua_newuserdatauv(L, sizeof *b + count * SIZES[type], 0);
    b->type = type;
    b->count = count;
    b->as.data = b + 1;
    memset(b + 1, 0, count * SIZES[type]);
    luaL_setmetatable(L, RTL_BUFFER);
    return b;
}

const rtl_buffer *rtl_field_buffer(lua_State *L, int index, const char *key, rtl_type type)
{
    if (lua_getfield(L, index, key) == LUA_TNIL) {
        lua_pop(L, 1);
        return NULL;
    }
    const rtl_buffer *b = luaL_testudata(L, -1, RTL_BUFFER);
    if (!b || b->type != type) {
        rtl_raise(L, "%s must be a buffer of type %s; got %s", key, TYPES[type], luaL_tolstring(L, -1, NULL));
    }
    lua_pop(L, 1);
    return b;
}

static void put(lua_State *L, rtl_buffer *b, size_t i, int value)
{
    if (lua_type(L, value) != LUA_TNUMBER) {
        rtl_raise(L, "element %I must be a number; got a %s", (LUAI_UACINT)i + 1, luaL_typename(L, value));
    }
    if (b->type == RTL_F32) {
        b->as.f32[i] = (float)lua_tonumber(L, value);
        return;
    }
    int ok;
    lua_Integer n = lua_tointegerx(L, value, &ok), high = b->type == RTL_U32 ? UINT32_MAX : UINT8_MAX;
    if (!ok || n < 0 || n > high) {
        rtl_raise(L, "element %I must be a whole number from 0 to %I; got %s", (LUAI_UACINT)i + 1, (LUAI_UACINT)high,
                  luaL_tolstring(L, value, NULL));
    }
    if (b->type == RTL_U32) {
        b->as.u32[i] = (uint32_t)n;
    } else {
        b->as.u8[i] = (uint8_t)n;
    }
}

static void push(lua_State *L, const rtl_buffer *b, size_t i)
{
    if (b->type == RTL_F32) {
        lua_pushnumber(L, (lua_Number)b->as.f32[i]);
    } else {
        lua_pushinteger(L, b->type == RTL_U32 ? (lua_Integer)b->as.u32[i] : (lua_Integer)b->as.u8[i]);
    }
}

static size_t position(lua_State *L, const rtl_buffer *b, int arg, size_t span)
{
    int ok;
    lua_Integer i = lua_tointegerx(L, arg, &ok);
    if (!ok || i < 1 || (uint64_t)i > b->count || span > b->count - (size_t)(i - 1)) {
        rtl_raise(L, "element %s is outside of the buffer's 1 ... %I", luaL_tolstring(L, arg, NULL), (LUAI_UACINT)b->count);
    }
    return (size_t)(i - 1);
}

/* buffer(type, count | list | string of raw bytes) */
static int create(lua_State *L)
{
    int type = luaL_checkoption(L, 1, NULL, TYPES);
    if (lua_type(L, 2) == LUA_TSTRING) {
        size_t size;
        const char *bytes = lua_tolstring(L, 2, &size);
        if (size % SIZES[type]) {
            return rtl_raise(L, "a buffer of type %s needs a multiple of %d bytes; the string has %I", TYPES[type],
                             (int)SIZES[type], (LUAI_UACINT)size);
        }
        rtl_buffer *b = rtl_buffer_new(L, (rtl_type)type, size / SIZES[type]);
        memcpy(b->as.data, bytes, size);
        return 1;
    }
    if (lua_type(L, 2) == LUA_TTABLE) {
        size_t count = lua_rawlen(L, 2);
        rtl_buffer *b = rtl_buffer_new(L, (rtl_type)type, count);
        for (size_t i = 0; i < count; i++) {
            lua_rawgeti(L, 2, (lua_Integer)i + 1);
            put(L, b, i, -1);
            lua_pop(L, 1);
        }
        return 1;
    }
    int ok;
    lua_Integer count = lua_tointegerx(L, 2, &ok);
    if (!ok || count < 0) {
        return rtl_raise(L, "a buffer needs a count, a list of numbers or a string of bytes; got %s", luaL_tolstring(L, 2, NULL));
    }
    rtl_buffer_new(L, (rtl_type)type, (size_t)count);
    return 1;
}

/* same_item(a, b, width): the first item, from 1, of `width` floats that is the same in both buffers of one length, or nil */
static int same_item(lua_State *L)
{
    const rtl_buffer *a = check(L, 1), *b = check(L, 2);
    const size_t width = (size_t)luaL_checkinteger(L, 3);
    if (a->type != RTL_F32 || b->type != RTL_F32 || a->count != b->count || width == 0) {
        return rtl_raise(L, "same_item needs two buffers of as many floats");
    }
    for (size_t i = 0; i + width <= a->count; i += width) {
        size_t k = 0;
        while (k < width && a->as.f32[i + k] == b->as.f32[i + k]) {
            k++;
        }
        if (k == width) {
            lua_pushinteger(L, (lua_Integer)(i / width) + 1);
            return 1;
        }
    }
    return 0;
}

static int index_of(lua_State *L)
{
    rtl_buffer *b = check(L, 1);
    if (lua_type(L, 2) == LUA_TNUMBER) {
        push(L, b, position(L, b, 2, 1));
        return 1;
    }
    lua_pushvalue(L, 2);
    lua_rawget(L, lua_upvalueindex(1));
    if (lua_isnil(L, -1)) {
        return rtl_raise(L, "a buffer has no field '%s'", luaL_tolstring(L, 2, NULL));
    }
    return 1;
}

static int newindex(lua_State *L)
{
    rtl_buffer *b = check(L, 1);
    put(L, b, position(L, b, 2, 1), 3);
    return 0;
}

static int length(lua_State *L)
{
    lua_pushinteger(L, (lua_Integer)check(L, 1)->count);
    return 1;
}

/* set(first, value, ...): several values in a row; returns the buffer */
static int set(lua_State *L)
{
    rtl_buffer *b = check(L, 1);
    int count = lua_gettop(L) - 2;
    size_t first = position(L, b, 2, count > 0 ? (size_t)count : 0);
    for (int i = 0; i < count; i++) {
        put(L, b, first + (size_t)i, 3 + i);
    }
    lua_settop(L, 1);
    return 1;
}

/* get(first, count): several values in a row */
static int get(lua_State *L)
{
    rtl_buffer *b = check(L, 1);
    lua_Integer count = luaL_optinteger(L, 3, 1);
    if (count < 0 || count > 250) {
        return rtl_raise(L, "get gives 0 to 250 values at once; got %I", (LUAI_UACINT)count);
    }
    size_t first = position(L, b, 2, (size_t)count);
    luaL_checkstack(L, (int)count, "values of a buffer");
    for (size_t i = 0; i < (size_t)count; i++) {
        push(L, b, first + i);
    }
    return (int)count;
}

static int fill(lua_State *L)
{
    rtl_buffer *b = check(L, 1);
    for (size_t i = 0; i < b->count; i++) {
        put(L, b, i, 2);
    }
    lua_settop(L, 1);
    return 1;
}

static int bytes(lua_State *L)
{
    rtl_buffer *b = check(L, 1);
    lua_pushlstring(L, b->as.data, b->count * SIZES[b->type]);
    return 1;
}

static int type(lua_State *L)
{
    lua_pushstring(L, TYPES[check(L, 1)->type]);
    return 1;
}

static int to_string(lua_State *L)
{
    rtl_buffer *b = check(L, 1);
    lua_pushfstring(L, "rt.buffer(%s, %I)", TYPES[b->type], (LUAI_UACINT)b->count);
    return 1;
}

void rtl_open_buffer(lua_State *L)
{
    static const luaL_Reg methods[] = {{"set", set},     {"get", get},   {"fill", fill},
                                       {"bytes", bytes}, {"type", type}, {NULL, NULL}};
    static const luaL_Reg meta[] = {{"__newindex", newindex}, {"__len", length}, {NULL, NULL}};
    static const luaL_Reg functions[] = {{"buffer", create}, {"same_item", same_item}, {NULL, NULL}};
    rtl_class(L, RTL_BUFFER, methods, NULL, to_string);
    luaL_getmetatable(L, RTL_BUFFER);
    luaL_setfuncs(L, meta, 0);
    lua_getfield(L, -1, "__index");
    lua_pushcclosure(L, index_of, 1);
    lua_setfield(L, -2, "__index");
    lua_pop(L, 1);
    rtl_add_functions(L, functions);
}
