#include "binding.h"

#include <math.h>
#include <string.h>

/* The handle of a job. The Lua part (lua/rt/job.lua) waits in steps. User value 1 keeps the scene's handle. */
typedef struct handle {
    rt_job *job;
    rt_image *preview; /* finished tiles are copied here on the calling thread, since workers write into the job's own image */
    rtl_context *context;
} handle;

#define STEP 0.05 /* seconds between two chances for an interrupt */

static const char *const STATES[] = {"running", "done", "cancelled", "failed"};

static handle *check(lua_State *L, int arg)
{
    handle *h = luaL_checkudata(L, arg, RTL_JOB);
    if (!h->job) {
        rtl_raise(L, "the job has been released");
    }
    return h;
}

static int release(lua_State *L)
{
    handle *h = luaL_checkudata(L, 1, RTL_JOB);
    rt_job_destroy(h->job);
    rt_image_destroy(h->preview);
    rtl_context_drop(h->context);
    h->job = NULL;
    h->preview = NULL;
    h->context = NULL;
    return 0;
}

static int to_string(lua_State *L)
{
    handle *h = luaL_checkudata(L, 1, RTL_JOB);
    lua_pushfstring(L, h->job ? "rt.job handle: %p" : "rt.job handle (released)", (void *)h);
    return 1;
}

/* ---- start ---- */

static const char *const FILTERS[] = {"box", "gaussian", NULL};
static const char *const SCHEDULES[] = {"dynamic", "static", NULL};

static void set_count(lua_State *L, const char *key, uint64_t value)
{
    lua_pushinteger(L, (lua_Integer)value);
    lua_setfield(L, -2, key);
}

static void set_number(lua_State *L, const char *key, double value)
{
    lua_pushnumber(L, value);
    lua_setfield(L, -2, key);
}

static void set_text(lua_State *L, const char *key, const char *value)
{
    lua_pushstring(L, value);
    lua_setfield(L, -2, key);
}

rt_render_desc rtl_render_fields(lua_State *L, int t)
{
    rt_render_desc d = rt_render_desc_default();
    int filter = (int)d.filter, schedule = (int)d.schedule;
    rtl_field_u32(L, t, "width", &d.width);
    rtl_field_u32(L, t, "height", &d.height);
    rtl_field_u32(L, t, "samples", &d.samples);
    rtl_field_u32(L, t, "workers", &d.workers);
    rtl_field_u32(L, t, "tile", &d.tile);
    rtl_field_choice(L, t, "schedule", SCHEDULES, &schedule);
    rtl_field_string(L, t, "integrator", &d.integrator);
    rtl_field_string(L, t, "tracer", &d.tracer);
    rtl_field_u64(L, t, "seed", &d.seed);
    rtl_field_u32(L, t, "max_depth", &d.max_depth);
    rtl_field_choice(L, t, "filter", FILTERS, &filter);
    rtl_field_float(L, t, "filter_width", &d.filter_width);
    rtl_field_bool(L, t, "shadows", &d.shadows);
    rtl_field_u32(L, t, "shadow_samples", &d.shadow_samples);
    rtl_field_bool(L, t, "opaque_shadows", &d.opaque_shadows);
    rtl_field_u32(L, t, "ao_samples", &d.ao_samples);
    rtl_field_float(L, t, "ao_distance", &d.ao_distance);
    rtl_field_u64(L, t, "memory_limit", &d.memory_limit);
    rtl_field_string(L, t, "checkpoint", &d.checkpoint);
    rtl_field_number(L, t, "checkpoint_every", &d.checkpoint_every);
    rtl_field_bool(L, t, "checkpoint_keep", &d.checkpoint_keep);
    rtl_field_bool(L, t, "background", &d.background);
    if (lua_getfield(L, t, "crop") == LUA_TTABLE) {
        int crop = lua_gettop(L);
        rtl_field_u32(L, crop, "x", &d.crop.x);
        rtl_field_u32(L, crop, "y", &d.crop.y);
        rtl_field_u32(L, crop, "width", &d.crop.width);
        rtl_field_u32(L, crop, "height", &d.crop.height);
    }
    lua_pop(L, 1);
    d.filter = (rt_filter)filter;
    d.schedule = (rt_schedule)schedule;
    return d;
}

static int copy_tile(void *user, const rt_tile *tile, const rt_image *image)
{
    handle *h = user;
    if (!image) { /* the job has ended and its image was taken */
        return 0;
    }
    uint32_t width = rt_image_width(image);
    const float *from = rt_image_pixels_const(image);
    float *to = rt_image_pixels(h->preview);
    for (uint32_t y = 0; y < tile->height; y++) {
        size_t at = 4 * ((size_t)(tile->y + y) * width + tile->x);
        memcpy(to + at, from + at, (size_t)tile->width * 16);
    }
    return 0;
}

/* job_start(scene, fields) -> job */
static int start(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    luaL_checktype(L, 2, LUA_TTABLE);
    rt_render_desc d = rtl_render_fields(L, 2);
    int preview = 0;
    rtl_field_bool(L, 2, "preview", &preview);
    handle *h = lua_newuserdatauv(L, sizeof *h, 1);
    memset(h, 0, sizeof *h);
    luaL_setmetatable(L, RTL_JOB);
    lua_pushvalue(L, 1);
    lua_setiuservalue(L, -2, 1);
    h->context = rtl_context_keep(c);
    if (preview && d.crop.width == 0) {
        rtl_check(L, c, rt_image_create(rtl_context_rt(c), d.width, d.height, &h->preview));
    }
    rtl_check(L, c, rt_job_start(scene, &d, &h->job));
    if (h->preview) {
        rt_job_on_tile(h->job, copy_tile, h);
    }
    rtl_account(L, rt_render_memory(scene, &d));
    return 1;
}

/* render_memory(scene, fields) -> bytes */
static int render_memory(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_render_desc d = rtl_render_fields(L, 2);
    uint64_t bytes = rt_render_memory(scene, &d);
    if (bytes == 0) {
        rtl_check(L, c, RT_ERROR_ARGUMENT);
    }
    lua_pushinteger(L, (lua_Integer)bytes);
    return 1;
}

/* render_defaults() -> the built-in settings */
static int render_defaults(lua_State *L)
{
    rt_render_desc d = rt_render_desc_default();
    d.width = 800; /* a picture to look at, where the C library's are the least that makes sense */
    d.height = 600;
    d.samples = 16;
    lua_createtable(L, 0, 20);
    set_count(L, "width", d.width);
    set_count(L, "height", d.height);
    set_count(L, "samples", d.samples);
    set_count(L, "workers", d.workers);
    set_count(L, "tile", d.tile);
    set_count(L, "seed", d.seed);
    set_count(L, "max_depth", d.max_depth);
    set_count(L, "shadow_samples", d.shadow_samples);
    set_count(L, "ao_samples", d.ao_samples);
    set_count(L, "memory_limit", d.memory_limit);
    set_number(L, "filter_width", (double)d.filter_width);
    set_number(L, "ao_distance", (double)d.ao_distance);
    set_text(L, "schedule", SCHEDULES[d.schedule]);
    set_text(L, "filter", FILTERS[d.filter]);
    set_text(L, "integrator", d.integrator);
    set_text(L, "tracer", d.tracer);
    lua_pushboolean(L, d.shadows);
    lua_setfield(L, -2, "shadows");
    lua_pushboolean(L, d.opaque_shadows);
    lua_setfield(L, -2, "opaque_shadows");
    return 1;
}

/* ---- a running job ---- */

static int push_state(lua_State *L, handle *h)
{
    float progress = 0.0f;
    rt_job_state state = rt_job_poll(h->job, &progress);
    lua_pushstring(L, STATES[state]);
    lua_pushnumber(L, (lua_Number)progress);
    return 2;
}

/* poll(job) -> state, progress */
static int poll(lua_State *L)
{
    return push_state(L, check(L, 1));
}

/* step(job, seconds) -> state, progress: waits at most STEP seconds, then lets an interrupt in */
static int step(lua_State *L)
{
    handle *h = check(L, 1);
    lua_Number seconds = luaL_optnumber(L, 2, STEP);
    rt_job_wait(h->job, seconds < 0 ? 0.0 : fmin(seconds, STEP));
    rtl_breathe(L);
    return push_state(L, h);
}

static int cancel(lua_State *L)
{
    rt_job_cancel(check(L, 1)->job);
    return 0;
}

static int next_tile(lua_State *L)
{
    rt_tile tile;
    if (!rt_job_next_tile(check(L, 1)->job, &tile)) {
        return 0;
    }
    lua_createtable(L, 0, 4);
    lua_pushinteger(L, tile.x);
    lua_setfield(L, -2, "x");
    lua_pushinteger(L, tile.y);
    lua_setfield(L, -2, "y");
    lua_pushinteger(L, tile.width);
    lua_setfield(L, -2, "width");
    lua_pushinteger(L, tile.height);
    lua_setfield(L, -2, "height");
    return 1;
}

/* take(job) -> image | nil before the end, or when it was taken */
static int take(lua_State *L)
{
    handle *h = check(L, 1);
    void *userdata = rtl_image_new(L, h->context);
    rt_image *image = rt_job_take_image(h->job);
    if (!image) {
        return 0;
    }
    rtl_image_put(L, userdata, image);
    return 1;
}

/* preview(job) -> a copy of what is finished | nil without preview = true */
static int preview(lua_State *L)
{
    handle *h = check(L, 1);
    if (!h->preview) {
        return 0;
    }
    uint32_t width = rt_image_width(h->preview), height = rt_image_height(h->preview);
    void *userdata = rtl_image_new(L, h->context);
    rt_image *copy = NULL;
    rtl_check(L, h->context, rt_image_create(rtl_context_rt(h->context), width, height, &copy));
    memcpy(rt_image_pixels(copy), rt_image_pixels_const(h->preview), (size_t)width * height * 16);
    rtl_image_put(L, userdata, copy);
    return 1;
}

/* raise_failure(job): raises why it failed, when it did */
static int raise_failure(lua_State *L)
{
    handle *h = check(L, 1);
    rtl_check(L, h->context, rt_job_status(h->job));
    return 0;
}

/* ---- statistics ---- */

static void push_workers(lua_State *L, handle *h)
{
    enum { MOST = 1024 };
    uint32_t count = rt_job_worker_stats(h->job, NULL, 0);
    count = count < MOST ? count : MOST;
    rt_worker_stats *w = lua_newuserdatauv(L, (count ? count : 1) * sizeof *w, 0);
    uint32_t now = rt_job_worker_stats(h->job, w, count);
    count = now < count ? now : count;
    lua_createtable(L, (int)count, 0);
    for (uint32_t i = 0; i < count; i++) {
        lua_createtable(L, 0, 4);
        set_number(L, "busy_seconds", w[i].busy_seconds);
        set_number(L, "cpu_seconds", w[i].cpu_seconds);
        set_count(L, "rays", w[i].rays);
        set_count(L, "tiles", w[i].tiles);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    lua_remove(L, -2);
}

/* A list of booleans, one a material, in the order of scene:looks(). */
static void push_touched(lua_State *L, handle *h)
{
    uint32_t count = rt_job_touched_materials(h->job, NULL, 0);
    uint8_t *touched = lua_newuserdatauv(L, count ? count : 1, 0);
    rt_job_touched_materials(h->job, touched, count);
    lua_createtable(L, (int)count, 0);
    for (uint32_t i = 0; i < count; i++) {
        lua_pushboolean(L, touched[i]);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    lua_remove(L, -2);
}

static int stats(lua_State *L)
{
    handle *h = check(L, 1);
    rt_render_stats s;
    rt_job_stats(h->job, &s);
    lua_createtable(L, 0, 18);
    set_number(L, "seconds", s.seconds);
    set_number(L, "build_seconds", s.build_seconds);
    set_count(L, "rays_camera", s.rays_camera);
    set_count(L, "rays_shadow", s.rays_shadow);
    set_count(L, "rays_reflect", s.rays_reflect);
    set_count(L, "rays_refract", s.rays_refract);
    set_count(L, "rays_diffuse", s.rays_diffuse);
    set_count(L, "rays_ao", s.rays_ao);
    set_count(L, "rays", s.rays_camera + s.rays_shadow + s.rays_reflect + s.rays_refract + s.rays_diffuse + s.rays_ao);
    set_count(L, "nodes", s.nodes);
    set_count(L, "tests", s.tests);
    set_count(L, "clamped", s.clamped);
    set_count(L, "dropped", s.dropped);
    set_count(L, "memory", s.memory);
    set_count(L, "workers", s.workers);
    set_count(L, "tiles", s.tiles);
    set_count(L, "tiles_done", s.tiles_done);
    rt_checkpoint_stats c;
    rt_job_checkpoint_stats(h->job, &c);
    set_count(L, "tiles_resumed", c.tiles_resumed);
    set_count(L, "tiles_begun", c.tiles_begun);
    set_count(L, "checkpoints", c.written);
    set_count(L, "checkpoints_failed", c.failed);
    set_number(L, "checkpoint_seconds", c.seconds);
    push_touched(L, h);
    lua_setfield(L, -2, "touched");
    push_workers(L, h);
    lua_setfield(L, -2, "per_worker");
    return 1;
}

/* ---- names ---- */

static int list(lua_State *L, const char *(*at)(uint32_t, const char **))
{
    lua_newtable(L);
    const char *name, *help;
    for (uint32_t i = 0; (name = at(i, &help)) != NULL; i++) {
        lua_createtable(L, 0, 2);
        lua_pushstring(L, name);
        lua_setfield(L, -2, "name");
        lua_pushstring(L, help);
        lua_setfield(L, -2, "help");
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    return 1;
}

static int integrators(lua_State *L)
{
    return list(L, rt_integrator_at);
}
static int tracers(lua_State *L)
{
    return list(L, rt_tracer_at);
}

void rtl_open_job(lua_State *L)
{
    static const luaL_Reg methods[] = {{"poll", poll},           {"step", step},   {"cancel", cancel},
                                       {"next_tile", next_tile}, {"take", take},   {"preview", preview},
                                       {"raise", raise_failure}, {"stats", stats}, {NULL, NULL}};
    static const luaL_Reg functions[] = {{"job_start", start},
                                         {"render_memory", render_memory},
                                         {"render_defaults", render_defaults},
                                         {"integrators", integrators},
                                         {"tracers", tracers},
                                         {NULL, NULL}};
    rtl_class(L, RTL_JOB, methods, release, to_string);
    rtl_add_functions(L, functions);
}
