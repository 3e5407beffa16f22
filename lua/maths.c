#include "binding.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* ---- random: a hash of its arguments, the same everywhere ---- */

static uint64_t mix(uint64_t x) /* the finalizer of SplitMix64 (Steele, Lea, Flood 2014) */
{
    x ^= x >> 30;
    x *= 0xbf58476d1ce4e5b9u;
    x ^= x >> 27;
    x *= 0x94d049bb133111ebu;
    return x ^ x >> 31;
}

/* Equal numbers hash alike, 1 and 1.0 too, as they are one key of a table. */
static uint64_t bits_of(lua_State *L, int arg)
{
    int ok;
    lua_Integer n = lua_tointegerx(L, arg, &ok);
    if (ok) {
        return (uint64_t)n;
    }
    lua_Number f = lua_tonumber(L, arg);
    uint64_t bits;
    memcpy(&bits, &f, sizeof bits);
    return bits ^ 0x9e3779b97f4a7c15u;
}

static uint64_t bits_of_string(lua_State *L, int arg)
{
    size_t size;
    const char *s = lua_tolstring(L, arg, &size);
    uint64_t h = 0xcbf29ce484222325u; /* FNV-1a */
    for (size_t i = 0; i < size; i++) {
        h = (h ^ (unsigned char)s[i]) * 0x100000001b3u;
    }
    return h;
}

/* random(key, ...) -> number in [0, 1) */
static int random_number(lua_State *L)
{
    int count = lua_gettop(L);
    uint64_t h = 0x6a09e667f3bcc909u;
    for (int i = 1; i <= count; i++) {
        switch (lua_type(L, i)) {
        case LUA_TNUMBER:
            h = mix(h ^ bits_of(L, i));
            break;
        case LUA_TSTRING:
            h = mix(h ^ bits_of_string(L, i));
            break;
        default:
            return rtl_raise(L, "rt.random: key %d must be a number or a string; got a %s", i, luaL_typename(L, i));
        }
        h += 0x9e3779b97f4a7c15u;
    }
    if (count == 0) {
        return rtl_raise(L, "rt.random needs at least one key: the same keys give the same number");
    }
    lua_pushnumber(L, (lua_Number)(mix(h) >> 11) * 0x1p-53);
    return 1;
}

/* ---- vectors: tables of three numbers with the metatable of lua/rt/vec.lua ---- */

static const char VEC_META = 'v'; /* its address is the registry's key */

static int set_vec_meta(lua_State *L)
{
    lua_settop(L, 1);
    lua_rawsetp(L, LUA_REGISTRYINDEX, &VEC_META);
    return 0;
}

/* copy3(value, most) -> a vec of the three numbers | nil when it is no table of three of size `most` at most (default: finite in
 * single precision) */
static int copy3(lua_State *L)
{
    const lua_Number most = luaL_optnumber(L, 2, (lua_Number)FLT_MAX);
    if (lua_type(L, 1) != LUA_TTABLE || lua_rawgeti(L, 1, 4) != LUA_TNIL) {
        return 0;
    }
    lua_createtable(L, 3, 0);
    int copy = lua_gettop(L);
    for (int i = 1; i <= 3; i++) {
        if (lua_rawgeti(L, 1, i) != LUA_TNUMBER || !(fabs(lua_tonumber(L, -1)) <= most)) {
            return 0;
        }
        lua_rawseti(L, copy, i);
    }
    lua_rawgetp(L, LUA_REGISTRYINDEX, &VEC_META);
    lua_setmetatable(L, copy);
    return 1;
}

/* ---- affine maps: tables of 12 numbers, row by row ---- */

static rt_transform check(lua_State *L, int arg)
{
    rt_transform t;
    luaL_checktype(L, arg, LUA_TTABLE);
    for (int i = 0; i < 12; i++) {
        lua_rawgeti(L, arg, i + 1);
        t.m[i] = (float)luaL_checknumber(L, -1);
        lua_pop(L, 1);
    }
    return t;
}

static int push(lua_State *L, rt_transform t)
{
    lua_createtable(L, 12, 0);
    for (int i = 0; i < 12; i++) {
        lua_pushnumber(L, (lua_Number)t.m[i]);
        lua_rawseti(L, -2, i + 1);
    }
    return 1;
}

static int translate(lua_State *L)
{
    return push(L, rt_transform_translate(rtl_check_vec3(L, 1, "translation")));
}
static int scale(lua_State *L)
{
    return push(L, rt_transform_scale(rtl_check_vec3(L, 1, "scale")));
}
static int rotate(lua_State *L)
{
    return push(L, rt_transform_rotate(rtl_check_vec3(L, 1, "axis"), (float)luaL_checknumber(L, 2)));
}
static int multiply(lua_State *L)
{
    return push(L, rt_transform_multiply(check(L, 1), check(L, 2)));
}

void rtl_open_maths(lua_State *L)
{
    static const luaL_Reg functions[] = {
        {"random", random_number}, {"set_vec_meta", set_vec_meta}, {"copy3", copy3}, {"translate", translate}, {"scale", scale},
        {"rotate", rotate},        {"multiply", multiply},         {NULL, NULL}};
    rtl_add_functions(L, functions);
}
