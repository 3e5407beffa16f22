/* The reader of old scene definition files (lua/rt/sdf.lua): any bytes give a scene, whose script compiles, or a message with
 * file and line. */
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <lauxlib.h>
#include <lua.h>
#include <lualib.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static const char CHECK[] = "package.path = '" LIBRT_LUA_FOLDER "/?.lua'\n"
                            "local sdf, script = require 'rt.sdf', require 'rt.sdf_script'\n"
                            "local function same(name) return name end\n"
                            "return function(text)\n"
                            "  local parts = {}\n"
                            "  local sink = script.sink('x', same, function(part) parts[#parts + 1] = part end)\n"
                            "  local ok, message = pcall(sdf.read, sdf.over_text(text, 'fuzz.sdf'), sink)\n"
                            "  if not ok then\n"
                            "    assert(type(message) == 'string' and message:find '^fuzz%.sdf:%d+: .', message)\n"
                            "    assert(utf8.len(message) and not message:find '%c', 'control bytes in a message')\n"
                            "  else\n"
                            "    assert(load(table.concat(parts) .. '}', '=script', 't'))\n"
                            "  end\n"
                            "end\n";

static lua_State *state(void)
{
    static lua_State *L;
    if (!L) {
        L = luaL_newstate();
        if (!L) {
            abort();
        }
        luaL_openlibs(L);
        if (luaL_loadstring(L, CHECK) != LUA_OK || lua_pcall(L, 0, 1, 0) != LUA_OK) {
            fprintf(stderr, "%s\n", lua_tostring(L, -1));
            abort();
        }
    }
    return L;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    lua_State *L = state();
    lua_pushvalue(L, 1);
    lua_pushlstring(L, (const char *)data, size);
    if (lua_pcall(L, 1, 0, 0) != LUA_OK) {
        fprintf(stderr, "%s\n", lua_tostring(L, -1));
        abort();
    }
    return 0;
}
