#include "binding.h"

#include <math.h>
#include <string.h>

typedef struct handle {
    rt_image *image;
    rtl_context *context;
} handle;

static handle *check(lua_State *L, int arg)
{
    handle *h = luaL_checkudata(L, arg, RTL_IMAGE);
    if (!h->image) {
        rtl_raise(L, "the image has been released");
    }
    return h;
}

rt_image *rtl_check_image(lua_State *L, int arg, rtl_context **context)
{
    handle *h = check(L, arg);
    if (context) {
        *context = h->context;
    }
    return h->image;
}

void *rtl_image_new(lua_State *L, rtl_context *c)
{
    handle *h = lua_newuserdatauv(L, sizeof *h, 0);
    h->image = NULL;
    h->context = NULL;
    luaL_setmetatable(L, RTL_IMAGE);
    h->context = rtl_context_keep(c);
    return h;
}

void rtl_image_put(lua_State *L, void *userdata, rt_image *image)
{
    handle *h = userdata;
    h->image = image;
    if (image) {
        rtl_account(L, (uint64_t)rt_image_width(image) * rt_image_height(image) * 16);
    }
}

static int release(lua_State *L)
{
    handle *h = luaL_checkudata(L, 1, RTL_IMAGE);
    rt_image_destroy(h->image);
    rtl_context_drop(h->context);
    h->image = NULL;
    h->context = NULL;
    return 0;
}

static int to_string(lua_State *L)
{
    handle *h = luaL_checkudata(L, 1, RTL_IMAGE);
    if (!h->image) {
        lua_pushliteral(L, "rt.image (released)");
    } else {
        lua_pushfstring(L, "rt.image(%d x %d)", (int)rt_image_width(h->image), (int)rt_image_height(h->image));
    }
    return 1;
}

/* image_new(width, height) */
static int create(lua_State *L)
{
    rtl_context *c = rtl_context_get(L);
    uint32_t width = rtl_check_u32(L, 1, "width"), height = rtl_check_u32(L, 2, "height");
    void *userdata = rtl_image_new(L, c);
    rt_image *image = NULL;
    rtl_check(L, c, rt_image_create(rtl_context_rt(c), width, height, &image));
    rtl_image_put(L, userdata, image);
    return 1;
}

/* image_load(path) */
static int load(lua_State *L)
{
    rtl_context *c = rtl_context_get(L);
    const char *path = rtl_check_path(L, 1);
    void *userdata = rtl_image_new(L, c);
    rt_image *image = NULL;
    rtl_check(L, c, rt_image_load(rtl_context_rt(c), path, &image));
    rtl_image_put(L, userdata, image);
    return 1;
}

/* The field texts, a list key, value, key, value, ...; the descriptor's array is a userdata that the table keeps. */
static void text_fields(lua_State *L, int t, rt_save_desc *d)
{
    t = lua_absindex(L, t);
    if (lua_getfield(L, t, "texts") == LUA_TTABLE) {
        lua_Integer count = (lua_Integer)lua_rawlen(L, -1) / 2;
        rt_text *texts = lua_newuserdatauv(L, (size_t)(count ? count : 1) * sizeof *texts, 0);
        for (lua_Integer i = 0; i < count; i++) {
            lua_rawgeti(L, -2, 2 * i + 1);
            lua_rawgeti(L, -3, 2 * i + 2);
            texts[i].key = lua_tostring(L, -2);
            texts[i].value = lua_tostring(L, -1);
            lua_pop(L, 2);
        }
        lua_setfield(L, t, "texts_array");
        d->texts = texts;
        d->text_count = (uint32_t)count;
    }
    lua_pop(L, 1);
}

rt_save_desc rtl_save_fields(lua_State *L, int t)
{
    static const char *const tones[] = {"none", "filmic", NULL};
    rt_save_desc d = rt_save_desc_default();
    int tone = (int)d.tone, text = 1;
    rtl_field_string(L, t, "format", &d.format);
    rtl_field_float(L, t, "exposure", &d.exposure);
    rtl_field_choice(L, t, "tone", tones, &tone);
    rtl_field_u32(L, t, "bits", &d.bits);
    rtl_field_u32(L, t, "quality", &d.quality);
    rtl_field_bool(L, t, "alpha", &d.alpha);
    rtl_field_bool(L, t, "text", &text);
    d.tone = (rt_tone)tone;
    d.no_text = !text;
    text_fields(L, t, &d);
    return d;
}

/* image_save(image, path, fields) */
static int save(lua_State *L)
{
    handle *h = check(L, 1);
    const char *path = rtl_check_path(L, 2);
    rt_save_desc d = rtl_save_fields(L, 3);
    rtl_check(L, h->context, rt_image_save(h->image, path, &d));
    return 0;
}

/* ---- pixels: x and y count from 0 ---- */

static float *pixel_at(lua_State *L, handle *h)
{
    uint32_t width = rt_image_width(h->image), height = rt_image_height(h->image);
    int ok_x, ok_y;
    lua_Integer x = lua_tointegerx(L, 2, &ok_x), y = lua_tointegerx(L, 3, &ok_y);
    if (!ok_x || !ok_y || x < 0 || y < 0 || x >= width || y >= height) {
        const char *sx = luaL_tolstring(L, 2, NULL), *sy = luaL_tolstring(L, 3, NULL);
        rtl_raise(L, "pixel %s, %s is outside of the image's 0 ... %d, 0 ... %d", sx, sy, (int)width - 1, (int)height - 1);
    }
    return rt_image_pixels(h->image) + 4 * ((size_t)y * width + (size_t)x);
}

/* pixel(x, y) -> r, g, b, coverage */
static int pixel(lua_State *L)
{
    const float *p = pixel_at(L, check(L, 1));
    for (int i = 0; i < 4; i++) {
        lua_pushnumber(L, (lua_Number)p[i]);
    }
    return 4;
}

/* set_pixel(x, y, r, g, b [, coverage]) */
static int set_pixel(lua_State *L)
{
    float *p = pixel_at(L, check(L, 1));
    lua_Number v[4] = {luaL_checknumber(L, 4), luaL_checknumber(L, 5), luaL_checknumber(L, 6), luaL_optnumber(L, 7, 1.0)};
    for (int i = 0; i < 4; i++) {
        p[i] = (float)v[i];
    }
    return 0;
}

static int size(lua_State *L)
{
    handle *h = check(L, 1);
    lua_pushinteger(L, rt_image_width(h->image));
    lua_pushinteger(L, rt_image_height(h->image));
    return 2;
}

/* stats() -> {width, height, min, max, mean = {r, g, b}, coverage, not_finite} of the linear values */
static int stats(lua_State *L)
{
    handle *h = check(L, 1);
    const float *p = rt_image_pixels_const(h->image);
    size_t count = (size_t)rt_image_width(h->image) * rt_image_height(h->image), odd = 0;
    float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    double sum[4] = {0};
    for (size_t i = 0; i < count; i++, p += 4) {
        if (!isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2])) {
            odd++;
            continue;
        }
        for (int k = 0; k < 3; k++) {
            low[k] = p[k] < low[k] ? p[k] : low[k];
            high[k] = p[k] > high[k] ? p[k] : high[k];
            sum[k] += (double)p[k];
        }
        sum[3] += (double)p[3];
    }
    size_t good = count - odd ? count - odd : 1;
    lua_createtable(L, 0, 7);
    lua_pushinteger(L, rt_image_width(h->image));
    lua_setfield(L, -2, "width");
    lua_pushinteger(L, rt_image_height(h->image));
    lua_setfield(L, -2, "height");
    rtl_push_vec3(L, (rt_vec3){low[0], low[1], low[2]});
    lua_setfield(L, -2, "min");
    rtl_push_vec3(L, (rt_vec3){high[0], high[1], high[2]});
    lua_setfield(L, -2, "max");
    lua_createtable(L, 3, 0);
    for (int k = 0; k < 3; k++) {
        lua_pushnumber(L, sum[k] / (double)good);
        lua_rawseti(L, -2, k + 1);
    }
    lua_setfield(L, -2, "mean");
    lua_pushnumber(L, sum[3] / (double)good);
    lua_setfield(L, -2, "coverage");
    lua_pushinteger(L, (lua_Integer)odd);
    lua_setfield(L, -2, "not_finite");
    return 1;
}

static int hash(lua_State *L)
{
    char text[33];
    rt_image_hash(check(L, 1)->image, text);
    lua_pushstring(L, text);
    return 1;
}

/* ---- text entries ---- */

static int text(lua_State *L)
{
    lua_pushstring(L, rt_image_get_text(check(L, 1)->image, luaL_checkstring(L, 2)));
    return 1;
}

static int set_text(lua_State *L)
{
    handle *h = check(L, 1);
    size_t key, value;
    luaL_checklstring(L, 2, &key);
    luaL_checklstring(L, 3, &value);
    if (strlen(lua_tostring(L, 2)) != key || strlen(lua_tostring(L, 3)) != value) {
        rtl_raise(L, "set_text: the %s has a NUL byte inside", strlen(lua_tostring(L, 2)) != key ? "key" : "value");
    }
    rtl_check(L, h->context, rt_image_set_text(h->image, lua_tostring(L, 2), lua_tostring(L, 3)));
    return 0;
}

typedef struct texts {
    lua_State *L;
    const char *key, *value;
} texts;

/* [key, value] -> sets the table below unless it has the key: of equal ones the first is told. */
static int add_text(lua_State *L)
{
    texts *r = lua_touserdata(L, 2);
    lua_settop(L, 1);
    if (lua_getfield(L, 1, r->key) == LUA_TNIL) {
        lua_pushstring(L, r->value);
        lua_setfield(L, 1, r->key);
    }
    return 0;
}

/* The error of a full memory must not jump over the library's frames. */
static int on_text(void *user, const char *key, const char *value)
{
    texts *r = user;
    r->key = key;
    r->value = value;
    lua_pushcfunction(r->L, add_text);
    lua_pushvalue(r->L, 2);
    lua_pushlightuserdata(r->L, r);
    return lua_pcall(r->L, 2, 0, 0) != LUA_OK;
}

/* image_text(path) -> {[key] = value} */
static int image_text(lua_State *L)
{
    rtl_context *c = rtl_context_get(L);
    const char *path = rtl_check_path(L, 1);
    texts r = {L, NULL, NULL};
    lua_settop(L, 1);
    lua_newtable(L);
    luaL_checkstack(L, 8, "out of stack");
    rt_status status = rt_image_read_texts(rtl_context_rt(c), path, on_text, &r);
    if (lua_gettop(L) > 2) { /* what add_text raised */
        return lua_error(L);
    }
    rtl_check(L, c, status);
    return 1;
}

void rtl_open_image(lua_State *L)
{
    static const luaL_Reg methods[] = {{"pixel", pixel}, {"set_pixel", set_pixel}, {"size", size},         {"stats", stats},
                                       {"hash", hash},   {"text", text},           {"set_text", set_text}, {NULL, NULL}};
    static const luaL_Reg functions[] = {
        {"image_new", create}, {"image_load", load}, {"image_save", save}, {"image_text", image_text}, {NULL, NULL}};
    rtl_class(L, RTL_IMAGE, methods, release, to_string);
    luaL_getmetatable(L, RTL_IMAGE);
    lua_getfield(L, -1, "__index");
    lua_setfield(L, -3, "image_methods"); /* lua/rt/image.lua adds save and compare */
    lua_pop(L, 1);
    rtl_add_functions(L, functions);
}
