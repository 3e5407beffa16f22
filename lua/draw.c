/* Drawing into images: other sizes, rectangles, pictures, labels. The fields come checked from lua/rt/draw.lua. */
#include "binding.h"

/* image_resample(image, width, height, filter) -> image */
static int resample(lua_State *L)
{
    static const char *const names[] = {"auto", "box", "mitchell", "lanczos", NULL};
    rtl_context *c;
    const rt_image *image = rtl_check_image(L, 1, &c);
    uint32_t width = rtl_check_u32(L, 2, "width"), height = rtl_check_u32(L, 3, "height");
    int filter = luaL_checkoption(L, 4, "auto", names);
    void *userdata = rtl_image_new(L, c);
    rt_image *made = NULL;
    rtl_check(L, c, rt_image_resample(image, width, height, (rt_resample)filter, &made));
    rtl_image_put(L, userdata, made);
    return 1;
}

/* image_fill(image, x, y, width, height, color, coverage) */
static int fill(lua_State *L)
{
    rt_image *image = rtl_check_image(L, 1, NULL);
    rt_vec3 color = rtl_check_vec3(L, 6, "color");
    const float rgba[4] = {color.x, color.y, color.z, (float)luaL_checknumber(L, 7)};
    rt_image_fill(image, (int32_t)luaL_checkinteger(L, 2), (int32_t)luaL_checkinteger(L, 3), rtl_check_u32(L, 4, "width"),
                  rtl_check_u32(L, 5, "height"), rgba);
    return 0;
}

/* image_place(image, other, x, y) */
static int place(lua_State *L)
{
    rtl_context *c;
    rt_image *image = rtl_check_image(L, 1, &c);
    const rt_image *other = rtl_check_image(L, 2, NULL);
    rtl_check(L, c, rt_image_place(image, other, (int32_t)luaL_checkinteger(L, 3), (int32_t)luaL_checkinteger(L, 4)));
    return 0;
}

static rt_label_desc label_fields(lua_State *L, int t)
{
    rt_label_desc d = rt_label_desc_default();
    rtl_field_float(L, t, "x", &d.x);
    rtl_field_float(L, t, "y", &d.y);
    rtl_field_float(L, t, "size", &d.size);
    rtl_field_float(L, t, "weight", &d.weight);
    rtl_field_vec3(L, t, "color", &d.color);
    rtl_field_float(L, t, "opacity", &d.opacity);
    return d;
}

/* image_label(image, text, fields) */
static int label(lua_State *L)
{
    rtl_context *c;
    rt_image *image = rtl_check_image(L, 1, &c);
    rt_label_desc d = label_fields(L, 3);
    rtl_check(L, c, rt_image_label(image, luaL_checkstring(L, 2), &d));
    return 0;
}

/* label_size(text, fields) -> width, height */
static int label_size(lua_State *L)
{
    rt_label_desc d = label_fields(L, 2);
    float width, height;
    rt_label_size(luaL_checkstring(L, 1), &d, &width, &height);
    lua_pushnumber(L, (lua_Number)width);
    lua_pushnumber(L, (lua_Number)height);
    return 2;
}

void rtl_open_draw(lua_State *L)
{
    static const luaL_Reg functions[] = {{"image_resample", resample}, {"image_fill", fill},       {"image_place", place},
                                         {"image_label", label},       {"label_size", label_size}, {NULL, NULL}};
    rtl_add_functions(L, functions);
}
