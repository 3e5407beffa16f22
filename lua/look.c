#include "binding.h"

#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* Trees, costs of rays and explained pixels. The library calls back with items; they are kept here and become Lua values when the
 * call has returned, since nothing may be raised through it. */

#define RTL_ITEMS "rt.items"

/* Items of one kind, in memory that the collector frees whatever is raised. */
typedef struct items {
    char *data;
    size_t size, count, capacity;
    int failed;
    atomic_bool stop; /* the call is to end */
} items;

/* What a call is made of. */
typedef struct look {
    const rt_scene *scene;
    rt_tree_query query;
    items *list;
    void *counts;
} look;

static items *new_items(lua_State *L, size_t size)
{
    items *list = lua_newuserdatauv(L, sizeof *list, 0);
    memset(list, 0, sizeof *list);
    list->size = size;
    luaL_setmetatable(L, RTL_ITEMS);
    return list;
}

static int free_items(lua_State *L)
{
    items *list = luaL_checkudata(L, 1, RTL_ITEMS);
    free(list->data);
    list->data = NULL;
    list->count = list->capacity = 0;
    return 0;
}

/* 0, or 1 when there is no memory: the library's call then ends. */
static int keep(items *list, const void *item)
{
    if (atomic_load_explicit(&list->stop, memory_order_relaxed)) {
        return 1;
    }
    if (list->count == list->capacity) {
        size_t capacity = list->capacity ? 2 * list->capacity : 64;
        char *data = capacity > SIZE_MAX / list->size ? NULL : realloc(list->data, capacity * list->size);
        if (!data) {
            list->failed = 1;
            return 1;
        }
        list->data = data;
        list->capacity = capacity;
    }
    memcpy(list->data + list->count++ * list->size, item, list->size);
    return 0;
}

static void stop_items(void *data)
{
    atomic_store(&((look *)data)->list->stop, true);
}

/* Makes a call of the library that keeps items, on a thread of its own. */
static void look_away(lua_State *L, rtl_context *c, rt_status (*call)(void *), look *l)
{
    rtl_away(L, c, call, stop_items, l);
    if (l->list->failed) {
        rtl_raise_text(L, "", RT_ERROR_MEMORY);
    }
}

static void set_integer(lua_State *L, const char *key, uint64_t value)
{
    lua_pushinteger(L, (lua_Integer)value);
    lua_setfield(L, -2, key);
}

static void set_number(lua_State *L, const char *key, double value)
{
    lua_pushnumber(L, value);
    lua_setfield(L, -2, key);
}

static void set_vec3(lua_State *L, const char *key, rt_vec3 value)
{
    rtl_push_vec3(L, value);
    lua_setfield(L, -2, key);
}

static void set_id(lua_State *L, const char *key, uint32_t value)
{
    if (value != RT_INVALID_ID) {
        set_integer(L, key, value);
    }
}

/* ---- trees ---- */

/* { tracer, group (absent: top level, or the whole scene), point, normal, max_depth, min_size, part } */
static rt_tree_query query_fields(lua_State *L, int t)
{
    rt_tree_query q = rt_tree_query_default();
    luaL_checktype(L, t, LUA_TTABLE);
    q.group = RT_INVALID_ID;
    rtl_field_string(L, t, "tracer", &q.tracer);
    rtl_field_u32(L, t, "group", &q.group);
    rtl_field_vec3(L, t, "point", &q.point);
    q.cut = rtl_field_vec3(L, t, "normal", &q.normal);
    rtl_field_u32(L, t, "max_depth", &q.max_depth);
    rtl_field_float(L, t, "min_size", &q.min_size);
    rtl_field_u32(L, t, "part", &q.part);
    return q;
}

static int keep_cell(void *user, const rt_tree_cell *cell)
{
    return keep(user, cell);
}

static rt_status cells_away(void *data)
{
    look *l = data;
    rt_status status = rt_scene_tree_cells(l->scene, &l->query, keep_cell, l->list);
    return l->list->failed ? RT_OK : status; /* of the memory look_away tells */
}

/* An interrupt ends a long list, too. */
static void breathe_at(lua_State *L, size_t i)
{
    if (i % 8192 == 0) {
        rtl_breathe(L);
    }
}

static void push_cell(lua_State *L, const rt_tree_cell *c)
{
    lua_createtable(L, 0, 9);
    set_vec3(L, "low", c->low);
    set_vec3(L, "high", c->high);
    set_integer(L, "depth", c->depth);
    set_integer(L, "leaves", c->leaves);
    set_integer(L, "empty_leaves", c->empty_leaves);
    set_integer(L, "deepest", c->deepest);
    set_integer(L, "largest", c->largest);
    set_integer(L, "references", c->references);
    if (c->corner_count > 0) {
        lua_createtable(L, (int)c->corner_count, 0);
        for (uint32_t i = 0; i < c->corner_count; i++) {
            rtl_push_vec3(L, c->corners[i]);
            lua_rawseti(L, -2, (lua_Integer)i + 1);
        }
        lua_setfield(L, -2, "corners");
    }
}

/* tree_cells(scene, query) -> list */
static int tree_cells(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_tree_query q = query_fields(L, 2);
    items *list = new_items(L, sizeof(rt_tree_cell));
    look l = {scene, q, list, NULL};
    look_away(L, c, cells_away, &l);
    lua_createtable(L, list->count < INT32_MAX ? (int)list->count : 0, 0);
    for (size_t i = 0; i < list->count; i++) {
        breathe_at(L, i);
        push_cell(L, (const rt_tree_cell *)(const void *)list->data + i);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    return 1;
}

enum { DEPTHS = 97, SIZES = 40, EXACT = 8 };
typedef struct counts {
    uint64_t depth_leaves[DEPTHS], depth_references[DEPTHS], size_leaves[SIZES], size_references[SIZES];
} counts;

/* Sizes 0 ... 8 have a place each, then 9-16, 17-32, ... */
static uint32_t place_of(uint64_t references)
{
    uint32_t place = EXACT;
    if (references <= EXACT) {
        return (uint32_t)references;
    }
    for (uint64_t top = EXACT; top < references && place < SIZES - 1; top *= 2) {
        place++;
    }
    return place;
}

static int count_leaf(void *user, const rt_tree_cell *cell)
{
    const look *l = user;
    counts *n = l->counts;
    uint32_t depth = cell->depth < DEPTHS ? cell->depth : DEPTHS - 1, place = place_of(cell->references);
    n->depth_leaves[depth]++;
    n->depth_references[depth] += cell->references;
    n->size_leaves[place]++;
    n->size_references[place] += cell->references;
    return atomic_load_explicit(&l->list->stop, memory_order_relaxed);
}

static rt_status count_away(void *data)
{
    look *l = data;
    return rt_scene_tree_cells(l->scene, &l->query, count_leaf, l);
}

static void push_bar(lua_State *L, uint64_t low, uint64_t high, uint64_t leaves, uint64_t references)
{
    lua_createtable(L, 0, 4);
    set_integer(L, "low", low);
    set_integer(L, "high", high);
    set_integer(L, "leaves", leaves);
    set_integer(L, "references", references);
}

/* Bars of a histogram up to the last one that is not empty. */
static void push_bars(lua_State *L, const uint64_t *leaves, const uint64_t *references, uint32_t count, uint32_t exact)
{
    lua_newtable(L);
    while (count > 0 && leaves[count - 1] == 0) {
        count--;
    }
    for (uint32_t i = 0; i < count; i++) {
        uint64_t high = i <= exact ? i : (uint64_t)exact << (i - exact), low = i <= exact ? i : high / 2 + 1;
        push_bar(L, low, high, leaves[i], references[i]);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
}

/* tree_leaves(scene, query) -> { depths, sizes }, each a list of { low, high, leaves, references } */
static int tree_leaves(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_tree_query q = query_fields(L, 2);
    counts *n = lua_newuserdatauv(L, sizeof *n, 0);
    memset(n, 0, sizeof *n);
    look l = {scene, q, new_items(L, 1), n};
    look_away(L, c, count_away, &l);
    lua_createtable(L, 0, 2);
    push_bars(L, n->depth_leaves, n->depth_references, DEPTHS, DEPTHS);
    lua_setfield(L, -2, "depths");
    push_bars(L, n->size_leaves, n->size_references, SIZES, EXACT);
    lua_setfield(L, -2, "sizes");
    return 1;
}

/* tree_shape(scene, query) -> { low, high, sah_cost, cost_traverse, cost_intersect }, or nothing where no tree stands */
static int tree_shape(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_tree_query q = query_fields(L, 2);
    rt_tree_shape s;
    rtl_check(L, c, rt_scene_tree_shape(scene, &q, &s));
    if (s.low.x > s.high.x) {
        return 0;
    }
    lua_createtable(L, 0, 5);
    set_vec3(L, "low", s.low);
    set_vec3(L, "high", s.high);
    set_number(L, "sah_cost", (double)s.sah_cost);
    set_number(L, "cost_traverse", (double)s.cost_traverse);
    set_number(L, "cost_intersect", (double)s.cost_intersect);
    return 1;
}

static int keep_piece(void *user, const rt_section *piece)
{
    return keep(user, piece);
}

static rt_status cut_away(void *data)
{
    look *l = data;
    rt_status status = rt_scene_cut(l->scene, l->query.group, l->query.point, l->query.normal, keep_piece, l->list);
    return l->list->failed ? RT_OK : status;
}

/* scene_cut(scene, query with point and normal) -> lines (f32, six numbers a piece), ids (u32, prim, geom, inst) */
static int scene_cut(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_tree_query q = query_fields(L, 2);
    items *list = new_items(L, sizeof(rt_section));
    look l = {scene, q, list, NULL};
    look_away(L, c, cut_away, &l);
    rtl_buffer *lines = rtl_buffer_new(L, RTL_F32, 6 * list->count), *ids = rtl_buffer_new(L, RTL_U32, 3 * list->count);
    for (size_t i = 0; i < list->count; i++) {
        const rt_section *p = (const rt_section *)(const void *)list->data + i;
        memcpy(lines->as.f32 + 6 * i, (float[6]){p->from.x, p->from.y, p->from.z, p->to.x, p->to.y, p->to.z}, 6 * sizeof(float));
        memcpy(ids->as.u32 + 3 * i, (uint32_t[3]){p->prim_id, p->geom_id, p->inst_id}, 3 * sizeof(uint32_t));
    }
    return 2;
}

/* ray_costs(scene, query, rays, blind) -> { nodes, leaves, tests } as buffers of u32 */
static int ray_costs(lua_State *L)
{
    enum { NUMBERS = 8, BATCH = 256 };
    static const char *const names[] = {"nodes", "leaves", "tests"};
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_tree_query q = query_fields(L, 2);
    const rtl_buffer *b = luaL_checkudata(L, 3, RTL_BUFFER);
    uint32_t mask = lua_toboolean(L, 4) ? 0 : RT_MASK_ALL;
    size_t count = b->count / NUMBERS;
    rtl_buffer *out[3];
    lua_createtable(L, 0, 3);
    for (int i = 0; i < 3; i++) {
        out[i] = rtl_buffer_new(L, RTL_U32, count);
        lua_setfield(L, -2, names[i]);
    }
    rt_ray rays[BATCH];
    rt_ray_cost costs[BATCH];
    for (size_t first = 0; first < count; first += BATCH) {
        breathe_at(L, first);
        size_t n = count - first < BATCH ? count - first : BATCH;
        for (size_t i = 0; i < n; i++) {
            const float *f = b->as.f32 + (first + i) * NUMBERS;
            rays[i] = (rt_ray){.org = {f[0], f[1], f[2]}, .tmin = f[3], .dir = {f[4], f[5], f[6]}, .tmax = f[7], .mask = mask};
        }
        rtl_check(L, c, rt_scene_ray_costs(scene, &q, rays, costs, n));
        for (size_t i = 0; i < n; i++) {
            out[0]->as.u32[first + i] = costs[i].nodes;
            out[1]->as.u32[first + i] = costs[i].leaves;
            out[2]->as.u32[first + i] = costs[i].tests;
        }
    }
    return 1;
}

/* ---- explained pixels ---- */

/* The state that an explanation breathes in, and whether it raised: what it raised stays on the stack. */
typedef struct breath {
    lua_State *L;
    int raised;
} breath;

static int breathe(lua_State *L)
{
    rtl_breathe(L);
    return 0;
}

static int on_progress(void *user, float done)
{
    breath *b = user;
    (void)done;
    lua_pushcfunction(b->L, breathe);
    b->raised = lua_pcall(b->L, 0, 0, 0) != LUA_OK;
    return b->raised;
}

static int keep_ray(void *user, const rt_explained_ray *ray)
{
    return keep(user, ray);
}

static void set_units(lua_State *L, const char *key, const int64_t units[3])
{
    lua_createtable(L, 3, 0);
    for (int i = 0; i < 3; i++) {
        lua_pushinteger(L, units[i]);
        lua_rawseti(L, -2, i + 1);
    }
    lua_setfield(L, -2, key);
}

static void push_surface(lua_State *L, const rt_explained_ray *r)
{
    const rt_surface *s = &r->surface;
    lua_createtable(L, 0, 16);
    set_number(L, "t", (double)r->hit.t);
    set_number(L, "u", (double)r->hit.u);
    set_number(L, "v", (double)r->hit.v);
    set_id(L, "prim_id", r->hit.prim_id);
    set_id(L, "geom_id", r->hit.geom_id);
    set_id(L, "inst_id", r->hit.inst_id);
    set_vec3(L, "position", s->position);
    set_vec3(L, "ng", s->ng);
    set_vec3(L, "ns", s->ns);
    set_number(L, "texture_u", (double)s->u);
    set_number(L, "texture_v", (double)s->v);
    set_id(L, "material_id", s->material.id);
    set_id(L, "material_group", s->material_scene);
    set_id(L, "face_id", s->face_id);
    set_vec3(L, "color", s->color);
}

static void push_ray(lua_State *L, const rt_explained_ray *r)
{
    static const char *const kinds[] = {"camera", "shadow", "reflect", "refract", "diffuse", "ao"};
    lua_createtable(L, 0, 20);
    lua_pushstring(L, kinds[r->kind]);
    lua_setfield(L, -2, "kind");
    set_integer(L, "index", (uint64_t)r->index + 1); /* of the list of rays, which counts from 1 */
    if (r->parent != RT_INVALID_ID) {
        set_integer(L, "parent", (uint64_t)r->parent + 1);
    }
    set_integer(L, "sample", r->sample);
    set_integer(L, "depth", r->depth);
    set_id(L, "light_id", r->light);
    set_vec3(L, "org", r->ray.org);
    set_vec3(L, "dir", r->ray.dir);
    set_number(L, "tmax", (double)r->ray.tmax);
    set_vec3(L, "throughput", r->throughput);
    set_units(L, "brought", r->brought);
    set_units(L, "unshadowed", r->unshadowed);
    set_integer(L, "nodes", r->cost.nodes);
    set_integer(L, "leaves", r->cost.leaves);
    set_integer(L, "tests", r->cost.tests);
    if (r->kind == RT_RAY_SHADOW || r->kind == RT_RAY_AO) {
        lua_pushboolean(L, r->arrived);
        lua_setfield(L, -2, "arrived");
        set_integer(L, "crossed", r->crossed);
    }
    if (r->hit.prim_id != RT_INVALID_ID) {
        push_surface(L, r);
        lua_setfield(L, -2, "hit");
    }
}

/* explain(scene, render fields, { x, y, first_sample, sample_count }) -> { samples, unit, sum, value, clamped, dropped, rays } */
static int explain(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_render_desc d = rtl_render_fields(L, 2);
    rt_explain_desc e = rt_explain_desc_default();
    rt_explained_pixel p;
    rtl_field_u32(L, 3, "x", &e.x);
    rtl_field_u32(L, 3, "y", &e.y);
    rtl_field_u32(L, 3, "first_sample", &e.first_sample);
    rtl_field_u32(L, 3, "sample_count", &e.sample_count);
    items *list = new_items(L, sizeof(rt_explained_ray));
    breath b = {L, 0};
    e.progress = on_progress;
    e.user = &b;
    luaL_checkstack(L, 8, "out of stack");
    rt_status status = rt_render_explain(scene, &d, &e, keep_ray, list, &p);
    if (b.raised) {
        return lua_error(L);
    } else if (list->failed) {
        return rtl_raise_text(L, "", RT_ERROR_MEMORY);
    }
    rtl_check(L, c, status);
    lua_createtable(L, 0, 7);
    set_integer(L, "samples", p.samples);
    set_number(L, "unit", p.unit);
    set_units(L, "sum", p.sum);
    lua_createtable(L, 4, 0);
    for (int i = 0; i < 4; i++) {
        lua_pushnumber(L, (lua_Number)p.value[i]);
        lua_rawseti(L, -2, i + 1);
    }
    lua_setfield(L, -2, "value");
    set_integer(L, "clamped", p.clamped);
    set_integer(L, "dropped", p.dropped);
    lua_createtable(L, (int)p.rays, 0);
    for (size_t i = 0; i < list->count; i++) {
        breathe_at(L, i);
        push_ray(L, (const rt_explained_ray *)(const void *)list->data + i);
        lua_rawseti(L, -2, (lua_Integer)i + 1);
    }
    lua_setfield(L, -2, "rays");
    return 1;
}

void rtl_open_look(lua_State *L)
{
    static const luaL_Reg functions[] = {{"tree_cells", tree_cells},
                                         {"tree_leaves", tree_leaves},
                                         {"tree_shape", tree_shape},
                                         {"scene_cut", scene_cut},
                                         {"ray_costs", ray_costs},
                                         {"explain", explain},
                                         {NULL, NULL}};
    luaL_newmetatable(L, RTL_ITEMS);
    lua_pushcfunction(L, free_items);
    lua_setfield(L, -2, "__gc");
    lua_pop(L, 1);
    rtl_add_functions(L, functions);
}
