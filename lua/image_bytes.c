/* Pixels of images as strings, exact to the bit: what one process tells another. */
#include "binding.h"

#include <string.h>

/* image_bytes(image): width * height * 4 floats (red, green, blue, coverage) in this machine's byte order */
static int image_bytes(lua_State *L)
{
    const rt_image *image = rtl_check_image(L, 1, NULL);
    lua_pushlstring(L, (const char *)rt_image_pixels_const(image),
                    (size_t)rt_image_width(image) * rt_image_height(image) * 4 * sizeof(float));
    return 1;
}

/* image_from(width, height, bytes): the image again; nil when there are not as many bytes */
static int image_from(lua_State *L)
{
    uint32_t width = rtl_check_u32(L, 1, "width"), height = rtl_check_u32(L, 2, "height");
    size_t size;
    const char *bytes = luaL_checklstring(L, 3, &size);
    if (size / 16 != (uint64_t)width * height || size % 16 != 0) {
        return 0;
    }
    rtl_context *c = rtl_context_get(L);
    void *userdata = rtl_image_new(L, c);
    rt_image *image = NULL;
    rtl_check(L, c, rt_image_create(rtl_context_rt(c), width, height, &image));
    rtl_image_put(L, userdata, image);
    memcpy(rt_image_pixels(image), bytes, size);
    return 1;
}

void rtl_open_image_bytes(lua_State *L)
{
    static const luaL_Reg functions[] = {{"image_bytes", image_bytes}, {"image_from", image_from}, {NULL, NULL}};
    rtl_add_functions(L, functions);
}
