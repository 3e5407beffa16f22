/* Comparing images, and showing values as colours. */
#include "binding.h"

/* The local values of a similarity as those of a difference. */
static void turn(rt_image *map)
{
    float *p = rt_image_pixels(map);
    size_t count = (size_t)rt_image_width(map) * rt_image_height(map);
    for (size_t i = 0; i < count; i++, p += 4)
        p[0] = p[1] = p[2] = 1.0f - p[0];
}

static void set_number(lua_State *L, const char *key, double value)
{
    lua_pushnumber(L, value);
    lua_setfield(L, -2, key);
}

/* The table of a difference, on the top. */
static void push_difference(lua_State *L, const rt_image_difference *d)
{
    lua_createtable(L, 0, 8);
    lua_pushinteger(L, (lua_Integer)d->differing_pixels);
    lua_setfield(L, -2, "differing");
    if (d->differing_pixels > 0) {
        lua_createtable(L, 2, 0);
        lua_pushinteger(L, d->first_x);
        lua_rawseti(L, -2, 1);
        lua_pushinteger(L, d->first_y);
        lua_rawseti(L, -2, 2);
        lua_setfield(L, -2, "first");
    }
    set_number(L, "max", d->max_abs);
    set_number(L, "mse", d->mse);
    set_number(L, "psnr", d->psnr);
}

/* image_compare(a, b, map | nil, flip, pixels per degree) -> {differing, first = {x, y}, max, mse, psnr, ssim, flip | nil, map |
 * nil}; map says whose: "difference", "ssim" (1 - its local value), "flip" */
static int compare(lua_State *L)
{
    static const char *const kinds[] = {"none", "difference", "ssim", "flip", NULL};
    enum { NONE, DIFFERENCE, SSIM, FLIP };
    rtl_context *c;
    const rt_image *a = rtl_check_image(L, 1, &c), *b = rtl_check_image(L, 2, NULL);
    int kind = luaL_checkoption(L, 3, "none", kinds), with_flip = lua_toboolean(L, 4) || kind == FLIP;
    double ppd = luaL_optnumber(L, 5, 0), ssim = 1, flip = 0;
    rt_image_difference d;
    rt_image *map = NULL;
    lua_settop(L, 5);
    void *userdata = rtl_image_new(L, c);
    rtl_check(L, c, rt_image_compare(a, b, &d, kind == DIFFERENCE ? &map : NULL));
    rtl_image_put(L, userdata, map);
    rtl_check(L, c, rt_image_ssim(a, b, &ssim, kind == SSIM ? &map : NULL));
    if (kind == SSIM) {
        turn(map);
        rtl_image_put(L, userdata, map);
    }
    if (with_flip) {
        rtl_check(L, c, rt_image_flip(a, b, ppd, &flip, kind == FLIP ? &map : NULL));
    }
    if (kind == FLIP) {
        rtl_image_put(L, userdata, map);
    }
    push_difference(L, &d);
    set_number(L, "ssim", ssim);
    if (with_flip) {
        set_number(L, "flip", flip);
    }
    if (kind != NONE) {
        lua_pushvalue(L, -2);
        lua_setfield(L, -2, "map");
    }
    return 1;
}

static const char *const color_maps[] = {"grey", "viridis", "magma", NULL};

/* color_map_at(name, x) -> r, g, b */
static int color_map_at(lua_State *L)
{
    rt_vec3 v = rt_color_map_at((rt_color_map)luaL_checkoption(L, 1, NULL, color_maps), (float)luaL_checknumber(L, 2));
    lua_pushnumber(L, (lua_Number)v.x);
    lua_pushnumber(L, (lua_Number)v.y);
    lua_pushnumber(L, (lua_Number)v.z);
    return 3;
}

/* image_color_map(image, name, low, high) -> image */
static int color_map(lua_State *L)
{
    rtl_context *c;
    const rt_image *image = rtl_check_image(L, 1, &c);
    int map = luaL_checkoption(L, 2, NULL, color_maps);
    float low = (float)luaL_checknumber(L, 3), high = (float)luaL_checknumber(L, 4);
    rt_image *made = NULL;
    void *userdata = rtl_image_new(L, c);
    rtl_check(L, c, rt_image_color_map(image, (rt_color_map)map, low, high, &made));
    rtl_image_put(L, userdata, made);
    return 1;
}

void rtl_open_image_compare(lua_State *L)
{
    static const luaL_Reg functions[] = {
        {"image_compare", compare}, {"image_color_map", color_map}, {"color_map_at", color_map_at}, {NULL, NULL}};
    rtl_add_functions(L, functions);
}
