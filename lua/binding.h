/** The Lua binding's own header: what its files share. The binding uses the public C API alone.
 *
 *  Effects are noted as in Lua's manual: [-pops, +pushes], and "raises" where an error may leave the function.
 *  Descriptions (spheres, materials, cameras) are checked tables made by the Lua part of the module (lua/rt); C reads their fields and hands
 *  them to librt. Userdata are what owns memory of librt: context, scene, image, job, and buffers. */
#ifndef RT_LUA_BINDING_H
#define RT_LUA_BINDING_H

#include <librt/rt.h>

#include <lauxlib.h>
#include <lua.h>

#define RTL_SCENE "rt.scene handle"
#define RTL_IMAGE "rt.image"
#define RTL_JOB "rt.job handle"
#define RTL_BUFFER "rt.buffer"

/** The module rt. Preload it, or load rt.so by require. [-0, +1], raises. */
RT_API int luaopen_rt(lua_State *L);

/* ---- context.c: one context a Lua state, shared by its objects ---- */

/** Counted, so that it outlives the last object made from it in whatever order the collector ends them. */
typedef struct rtl_context rtl_context;

/** The state's context, made at the first call. [-0, +0], raises. */
rtl_context *rtl_context_get(lua_State *L);
/** What contexts made from now on begin with: a host's allocator, open hook and limit; rt.configure can lower the limit, not raise it. [-0, +0], raises. */
void rtl_context_defaults(lua_State *L, const rt_context_desc *desc);
rt_context *rtl_context_rt(const rtl_context *c);
rtl_context *rtl_context_keep(rtl_context *c);
void rtl_context_drop(rtl_context *c);
void rtl_open_context(lua_State *L);

/* ---- common.c: errors, fields, memory ---- */

/** Raises `message` (printf-like, as lua_pushfstring) with the position of the nearest function that is not part of the module. */
int rtl_raise(lua_State *L, const char *format, ...);
/** Its address is the registry's key of the function that knows the place a tail call has lost (lua/rt/run.lua). */
extern const char rtl_lost_place;
/** Pushes "file:line: " of the nearest function outside the module and returns 1, or nothing and 0. [-0, +(0|1)] */
int rtl_place(lua_State *L);
/** Pushes "file:line: " of the nearest function outside the module, or "". [-0, +1] */
void rtl_where(lua_State *L);
/** Raises a message of the library, or the status's name when it is empty. */
int rtl_raise_text(lua_State *L, const char *text, rt_status status);
/** Raises the calling thread's last message when status is not RT_OK. */
void rtl_check(lua_State *L, rtl_context *c, rt_status status);
/** Tells the collector of memory that Lua does not see; it may run a step. [-0, +0], raises in a finalizer. */
void rtl_account(lua_State *L, uint64_t bytes);
/** Calls an empty function in the main state, where stock lua5.4 hangs its interrupt. [-0, +0], raises what the hook raised. */
void rtl_breathe(lua_State *L);
/** Runs call(data) on another thread, which must not touch L, and waits, breathing every 50 ms. When an interrupt is raised, cancel(data) is called until
 *  the call has ended, and it is raised again; so are errors of the call. [-0, +0], raises. */
void rtl_away(lua_State *L, rtl_context *c, rt_status (*call)(void *data), void (*cancel)(void *data), void *data);
/** A class: its methods in __index, __gc and __close = release. [-0, +0] */
void rtl_class(lua_State *L, const char *name, const luaL_Reg *methods, lua_CFunction release, lua_CFunction to_string);
/** Functions of the module's C part. The table stands on the top of the stack. */
void rtl_add_functions(lua_State *L, const luaL_Reg *functions);

/* Readers of fields of the table at `index`: a missing field leaves *value. A field of a wrong type raises. [-0, +0] */
int rtl_field_number(lua_State *L, int index, const char *key, double *value);
int rtl_field_float(lua_State *L, int index, const char *key, float *value);
int rtl_field_u32(lua_State *L, int index, const char *key, uint32_t *value);
int rtl_field_u64(lua_State *L, int index, const char *key, uint64_t *value);
int rtl_field_bool(lua_State *L, int index, const char *key, int *value);
int rtl_field_vec3(lua_State *L, int index, const char *key, rt_vec3 *value);
int rtl_field_floats(lua_State *L, int index, const char *key, float *values, int count);
/** The string is pinned by the table; the field must not change while it is used. */
int rtl_field_string(lua_State *L, int index, const char *key, const char **value);
/** Index of the field's text in `names` (NULL at the end). */
int rtl_field_choice(lua_State *L, int index, const char *key, const char *const *names, int *value);
/** Pushes {x, y, z}. [-0, +1] */
void rtl_push_vec3(lua_State *L, rt_vec3 v);
rt_vec3 rtl_check_vec3(lua_State *L, int index, const char *what);
uint32_t rtl_check_u32(lua_State *L, int index, const char *what);
/** A file name without NUL bytes inside. */
const char *rtl_check_path(lua_State *L, int index);

/* ---- one file a type ---- */

typedef enum rtl_type { RTL_F32 = 0, RTL_U32, RTL_U8 } rtl_type;
typedef struct rtl_buffer {
    rtl_type type;
    size_t count;
    union {
        float *f32;
        uint32_t *u32;
        uint8_t *u8;
        void *data;
    } as;
} rtl_buffer;

/** A zeroed buffer. [-0, +1], raises. */
rtl_buffer *rtl_buffer_new(lua_State *L, rtl_type type, size_t count);
/** The buffer in field `key` of the table at `index`, or NULL; raises when it has another type. */
const rtl_buffer *rtl_field_buffer(lua_State *L, int index, const char *key, rtl_type type);

/** The scene of argument `arg`; raises when it is released. */
rt_scene *rtl_check_scene(lua_State *L, int arg, rtl_context **context);
/** The scene in field `key`. */
rt_scene *rtl_field_scene(lua_State *L, int index, const char *key);

rt_image *rtl_check_image(lua_State *L, int arg, rtl_context **context);
/** An empty image userdata; the image is put in by rtl_image_put. [-0, +1] */
void *rtl_image_new(lua_State *L, rtl_context *c);
void rtl_image_put(lua_State *L, void *userdata, rt_image *image);

/** Descriptors from the checked fields of the table at `t`. Their strings are pinned by the table. [-0, +0], raises. */
rt_render_desc rtl_render_fields(lua_State *L, int t);
rt_save_desc rtl_save_fields(lua_State *L, int t);

void rtl_open_common(lua_State *L);
void rtl_open_buffer(lua_State *L);
void rtl_open_scene(lua_State *L);
void rtl_open_commit(lua_State *L);
void rtl_open_material(lua_State *L);
void rtl_open_geometry(lua_State *L);
void rtl_open_world(lua_State *L);
void rtl_open_query(lua_State *L);
void rtl_open_image(lua_State *L);
void rtl_open_draw(lua_State *L);
void rtl_open_job(lua_State *L);
void rtl_open_look(lua_State *L);
void rtl_open_render_file(lua_State *L);
void rtl_open_maths(lua_State *L);
void rtl_open_folder(lua_State *L);
void rtl_open_image_bytes(lua_State *L);
void rtl_open_image_compare(lua_State *L);
void rtl_open_process(lua_State *L);

/* ---- embedded Lua files, made at build time by embed.cmake ---- */

typedef struct rtl_file {
    const char *name; /**< as for require: "rt.check" */
    const unsigned char *text;
    size_t size;
} rtl_file;
extern const rtl_file rtl_files[]; /* ends with a NULL name */

#endif
