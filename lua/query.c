#include "binding.h"

#include <math.h>

/* Rays asked from Lua: one with a table's fields, or many in a buffer of eight numbers a ray: org x y z, tmin, dir x y z, tmax.
 */

enum { RAY_NUMBERS = 8, BATCH = 256 };

static rt_ray ray_fields(lua_State *L, int t)
{
    rt_ray r = {.tmin = 0.0f, .tmax = INFINITY, .mask = RT_MASK_ALL};
    if (!rtl_field_vec3(L, t, "org", &r.org) || !rtl_field_vec3(L, t, "dir", &r.dir)) {
        rtl_raise(L, "a ray needs org and dir, as in { org = {0, 0, 5}, dir = {0, 0, -1} }");
    }
    rtl_field_float(L, t, "tmin", &r.tmin);
    rtl_field_float(L, t, "tmax", &r.tmax);
    rtl_field_u32(L, t, "mask", &r.mask);
    return r;
}

static void set_number(lua_State *L, const char *key, float value)
{
    lua_pushnumber(L, (lua_Number)value);
    lua_setfield(L, -2, key);
}

static void set_id(lua_State *L, const char *key, uint32_t value)
{
    if (value != RT_INVALID_ID) {
        lua_pushinteger(L, value);
        lua_setfield(L, -2, key);
    }
}

static void set_vec3(lua_State *L, const char *key, rt_vec3 value)
{
    rtl_push_vec3(L, value);
    lua_setfield(L, -2, key);
}

static float time_field(lua_State *L, int t)
{
    float time = 0.0f;
    rtl_field_float(L, t, "time", &time);
    return time;
}

static void push_hit(lua_State *L, const rt_scene *scene, const rt_ray *ray, float time, const rt_hit *hit)
{
    rt_surface s;
    rt_scene_surface_at(scene, ray, time, hit, &s);
    lua_createtable(L, 0, 16);
    set_number(L, "t", hit->t);
    set_number(L, "u", hit->u);
    set_number(L, "v", hit->v);
    set_id(L, "prim_id", hit->prim_id);
    set_id(L, "geom_id", hit->geom_id);
    set_id(L, "inst_id", hit->inst_id);
    set_vec3(L, "position", s.position);
    set_vec3(L, "ng", s.ng);
    set_vec3(L, "ns", s.ns);
    set_number(L, "texture_u", s.u);
    set_number(L, "texture_v", s.v);
    set_id(L, "material_id", s.material.id);
    set_id(L, "face_id", s.face_id);
    set_id(L, "user_id", s.user_id);
    set_id(L, "inst_user_id", s.inst_user_id);
    set_vec3(L, "color", s.color);
}

/* intersect(scene, ray) -> hit | nil */
static int intersect(lua_State *L)
{
    rt_scene *scene = rtl_check_scene(L, 1, NULL);
    rt_ray ray = ray_fields(L, 2);
    float time = time_field(L, 2);
    rt_hit hit;
    rt_scene_intersect_at(scene, &ray, &time, &hit, 1);
    if (hit.prim_id == RT_INVALID_ID) {
        return 0;
    }
    push_hit(L, scene, &ray, time, &hit);
    return 1;
}

/* intersect_all(scene, ray, capacity) -> list of hits */
static int intersect_all(lua_State *L)
{
    enum { MOST = 1024 };
    rt_scene *scene = rtl_check_scene(L, 1, NULL);
    rt_ray ray = ray_fields(L, 2);
    lua_Integer capacity = luaL_optinteger(L, 3, MOST);
    if (capacity < 1 || capacity > MOST) {
        return rtl_raise(L, "intersect_all gives 1 to %d hits; %I were asked for", MOST, (LUAI_UACINT)capacity);
    }
    rt_hit hits[MOST];
    float time = time_field(L, 2);
    size_t count = rt_scene_intersect_all_at(scene, &ray, time, hits, (size_t)capacity);
    lua_createtable(L, (int)count, 0);
    for (size_t i = 0; i < count; i++) {
        push_hit(L, scene, &ray, time, &hits[i]);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    return 1;
}

static int occluded(lua_State *L)
{
    rt_scene *scene = rtl_check_scene(L, 1, NULL);
    rt_ray ray = ray_fields(L, 2);
    float time = time_field(L, 2);
    uint8_t answer;
    rt_scene_occluded_at(scene, &ray, &time, &answer, 1);
    lua_pushboolean(L, answer);
    return 1;
}

/* ---- many rays ---- */

static const rtl_buffer *check_rays(lua_State *L, int arg)
{
    const rtl_buffer *b = luaL_testudata(L, arg, RTL_BUFFER);
    if (!b || b->type != RTL_F32 || b->count % RAY_NUMBERS) {
        rtl_raise(L, "rays must be a buffer of type f32 with %d numbers a ray (org, tmin, dir, tmax); got %s", RAY_NUMBERS,
                  luaL_tolstring(L, arg, NULL));
    }
    return b;
}

static size_t read_rays(const rtl_buffer *b, size_t first, rt_ray *rays)
{
    size_t count = b->count / RAY_NUMBERS - first;
    count = count < BATCH ? count : BATCH;
    for (size_t i = 0; i < count; i++) {
        const float *f = b->as.f32 + (first + i) * RAY_NUMBERS;
        rays[i] = (rt_ray){{f[0], f[1], f[2]}, f[3], {f[4], f[5], f[6]}, f[7], RT_MASK_ALL};
    }
    return count;
}

/* Times of the rays, one each; NULL: none were given. */
static const float *check_times(lua_State *L, int arg, size_t count)
{
    const rtl_buffer *b = luaL_testudata(L, arg, RTL_BUFFER);
    if (lua_isnoneornil(L, arg)) {
        return NULL;
    }
    if (!b || b->type != RTL_F32 || b->count != count) {
        rtl_raise(L, "times must be a buffer of type f32 with %I numbers, one a ray; got %s", (LUAI_UACINT)count,
                  luaL_tolstring(L, arg, NULL));
    }
    return b->as.f32;
}

/* intersect_buffer(scene, rays, times | nil) -> {t, u, v (f32), prim_id, geom_id, inst_id (u32; 0xffffffff is a miss)} */
static int intersect_buffer(lua_State *L)
{
    static const char *const names[] = {"t", "u", "v", "prim_id", "geom_id", "inst_id"};
    rt_scene *scene = rtl_check_scene(L, 1, NULL);
    const rtl_buffer *rays = check_rays(L, 2);
    size_t count = rays->count / RAY_NUMBERS;
    const float *times = check_times(L, 3, count);
    rtl_buffer *out[6];
    lua_createtable(L, 0, 6);
    for (int i = 0; i < 6; i++) {
        out[i] = rtl_buffer_new(L, i < 3 ? RTL_F32 : RTL_U32, count);
        lua_setfield(L, -2, names[i]);
    }
    rt_ray batch[BATCH];
    rt_hit hits[BATCH];
    for (size_t first = 0; first < count; first += BATCH) {
        size_t n = read_rays(rays, first, batch);
        rt_scene_intersect_at(scene, batch, times ? times + first : NULL, hits, n);
        for (size_t i = 0; i < n; i++) {
            out[0]->as.f32[first + i] = hits[i].t;
            out[1]->as.f32[first + i] = hits[i].u;
            out[2]->as.f32[first + i] = hits[i].v;
            out[3]->as.u32[first + i] = hits[i].prim_id;
            out[4]->as.u32[first + i] = hits[i].geom_id;
            out[5]->as.u32[first + i] = hits[i].inst_id;
        }
    }
    return 1;
}

/* occluded_buffer(scene, rays, times | nil) -> buffer of u8, 1 or 0 */
static int occluded_buffer(lua_State *L)
{
    rt_scene *scene = rtl_check_scene(L, 1, NULL);
    const rtl_buffer *rays = check_rays(L, 2);
    size_t count = rays->count / RAY_NUMBERS;
    const float *times = check_times(L, 3, count);
    rtl_buffer *out = rtl_buffer_new(L, RTL_U8, count);
    rt_ray batch[BATCH];
    for (size_t first = 0; first < count; first += BATCH) {
        size_t n = read_rays(rays, first, batch);
        rt_scene_occluded_at(scene, batch, times ? times + first : NULL, out->as.u8 + first, n);
    }
    return 1;
}

void rtl_open_query(lua_State *L)
{
    static const luaL_Reg functions[] = {{"intersect", intersect},
                                         {"intersect_all", intersect_all},
                                         {"occluded", occluded},
                                         {"intersect_buffer", intersect_buffer},
                                         {"occluded_buffer", occluded_buffer},
                                         {NULL, NULL}};
    rtl_add_functions(L, functions);
}
