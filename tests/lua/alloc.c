/* The binding under a Lua allocator that fails: each state is refused its n-th allocation and all later ones, for n in steps,
 * while the module is loaded and while a script uses it. Nothing may crash; a sanitizer sees what leaks. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "binding.h"

#include <lualib.h>

static const char *const SCRIPT =
    "local rt = ...\n"
    "local scene = rt.scene { settings = { width = 8, height = 6, samples = 1, workers = 1 }, name = 'x',\n"
    "  camera = rt.camera { eye = {0, 0, 5}, look_at = {0, 0, 0} }, background = {0, 0, 1},\n"
    "  { rt.sphere { center = rt.vec(0, 0, 0) + 1, radius = 1, material = rt.classic { texture = rt.image { width = 2, height = "
    "2 } } } },\n"
    "  rt.instance { rt.group { rt.box { low = {0, 0, 0}, high = {1, 1, 1} } }, transform = rt.translate(1, 2, 3) },\n"
    "  rt.mesh { vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, faces = {{1, 2, 3}}, smooth = true },\n"
    "  rt.point_light { at = {1, 2, 3} } }\n"
    "local p = rt.params { a = { 1, min = 0 }, sets = { s = { a = 2, samples = 4 } } }\n"
    "local image = scene:render { progress = function() end }\n"
    "image:compare(scene:render(), { map = true })\n"
    "local job <close> = scene:start { preview = true }\n"
    "for tile in job:tiles() do local i = job:image() end\n"
    "scene:intersect { org = {0, 0, 5}, dir = {0, 0, -1} }\n"
    "scene:intersect(rt.buffer('f32', 16))\n"
    "local info, hash = scene:info(), scene:hash()\n"
    "assert(not pcall(rt.sphere, { radius = p.a }))\n"
    "assert(not pcall(rt.image, '/nowhere'))\n";

typedef struct budget {
    long count, fail_at; /* from this allocation on all fail (Lua tries once more after a collection); 0: none */
} budget;

static void *allocate(void *user, void *block, size_t old_size, size_t size)
{
    budget *b = user;
    if (size == 0) {
        free(block);
        return NULL;
    }
    if (block && size <= old_size) { /* Lua relies on shrinking */
        void *shrunk = realloc(block, size);
        return shrunk ? shrunk : block;
    }
    if (++b->count >= b->fail_at && b->fail_at > 0) {
        return NULL;
    }
    return realloc(block, size);
}

static int run(lua_State *L)
{
    budget *b = lua_touserdata(L, 1);
    int fail_in_script = lua_toboolean(L, 2);
    long fail_at = b->fail_at;
    b->fail_at = fail_in_script ? 0 : fail_at;
    luaL_openlibs(L);
    luaL_requiref(L, "rt", luaopen_rt, 0);
    if (luaL_loadstring(L, SCRIPT) != LUA_OK) {
        return lua_error(L);
    }
    lua_insert(L, -2);
    if (fail_in_script) {
        b->count = 0;
        b->fail_at = fail_at;
    }
    lua_call(L, 1, 0);
    return 0;
}

/* Runs with the n-th allocation failing; returns whether it was reached. */
static int attempt(long n, int in_script)
{
    budget b = {0, 0};
    lua_State *L = lua_newstate(allocate, &b);
    if (!L) {
        fprintf(stderr, "no state\n");
        exit(1);
    }
    b.count = 0;
    b.fail_at = n;
    lua_pushcfunction(L, run);
    lua_pushlightuserdata(L, &b);
    lua_pushboolean(L, in_script);
    int status = lua_pcall(L, 2, 0, 0);
    int reached = b.count >= n;
    if (status != LUA_OK && !reached) {
        fprintf(stderr, "without a failing allocation: %s\n", lua_tostring(L, -1));
        exit(1);
    }
    b.fail_at = 0;
    lua_close(L);
    return reached;
}

int main(int argc, char **argv)
{
    long step = argc > 1 ? strtol(argv[1], NULL, 10) : 1;
    for (int in_script = 0; in_script < 2; in_script++) {
        long stride = in_script ? step : 40 * step, runs = 0;
        for (long n = 1; attempt(n, in_script); n += stride) {
            runs++;
        }
        printf("%s: %ld runs\n", in_script ? "script" : "module", runs);
        if (runs < 10) {
            return 1;
        }
    }
    return 0;
}
