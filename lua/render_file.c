#include "binding.h"

/* Renders that go band by band into a file. Progress arrives on the calling thread, for each tile and about every 50 ms. */
typedef struct report {
    lua_State *L;
    int function; /* stack index, 0: none */
    int failed;   /* the error stands on the top of the stack */
} report;

static int on_progress(void *user, uint64_t done, uint64_t total)
{
    report *r = user;
    lua_State *L = r->L;
    if (r->failed || !r->function) {
        return r->failed;
    }
    lua_pushvalue(L, r->function);
    lua_pushnumber(L, (lua_Number)done / (lua_Number)total);
    if (lua_pcall(L, 1, 1, 0) != LUA_OK) {
        r->failed = 1;
        return 1;
    }
    int stop = lua_toboolean(L, -1);
    lua_pop(L, 1);
    return stop;
}

/* render_to_file(scene, fields, path, save fields, bytes of a band, f(done) | nil) -> true; false when f returned true */
static int render_to_file(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_render_desc d = rtl_render_fields(L, 2);
    const char *path = rtl_check_path(L, 3);
    rt_save_desc save = rtl_save_fields(L, 4);
    uint64_t band = (uint64_t)luaL_checkinteger(L, 5);
    report r = {L, lua_isnoneornil(L, 6) ? 0 : 6, 0};
    luaL_checkstack(L, 8, "out of stack");
    rt_status status = rt_render_to_file(scene, &d, path, &save, band, on_progress, &r);
    if (r.failed) {
        return lua_error(L);
    }
    if (status != RT_ERROR_CANCELLED) {
        rtl_check(L, c, status);
    }
    lua_pushboolean(L, status == RT_OK);
    return 1;
}

void rtl_open_render_file(lua_State *L)
{
    static const luaL_Reg functions[] = {{"render_to_file", render_to_file}, {NULL, NULL}};
    rtl_add_functions(L, functions);
}
