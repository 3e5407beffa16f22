#include "binding.h"

static rt_commit_desc fields(lua_State *L, int t)
{
    rt_commit_desc d = rt_commit_desc_default();
    rtl_field_string(L, t, "accel", &d.accel);
    rtl_field_string(L, t, "builder", &d.builder);
    rtl_field_u32(L, t, "tree_depth", &d.max_depth);
    rtl_field_u32(L, t, "leaf_size", &d.leaf_size);
    rtl_field_float(L, t, "cost_traverse", &d.cost_traverse);
    rtl_field_float(L, t, "cost_intersect", &d.cost_intersect);
    rtl_field_float(L, t, "empty_bonus", &d.empty_bonus);
    rtl_field_float(L, t, "duplication", &d.duplication);
    rtl_field_float(L, t, "refit", &d.refit);
    return d;
}

static void account(lua_State *L, rt_scene *scene)
{
    rt_scene_info info;
    if (rt_scene_get_info(scene, &info) == RT_OK) {
        rtl_account(L, info.total_bytes);
    }
}

typedef struct committing {
    rt_scene *scene;
    rt_commit_desc desc;
} committing;

static rt_status commit_away(void *data)
{
    const committing *t = data;
    return rt_scene_commit(t->scene, &t->desc);
}

static void cancel(void *data)
{
    rt_scene_cancel(((committing *)data)->scene);
}

/* scene_commit(scene, fields) */
static int commit(lua_State *L)
{
    rtl_context *c;
    committing t = {.scene = rtl_check_scene(L, 1, &c)};
    t.desc = fields(L, 2);
    rtl_away(L, c, commit_away, cancel, &t); /* it builds trees, which may take long */
    account(L, t.scene);
    return 0;
}

void rtl_open_commit(lua_State *L)
{
    static const luaL_Reg functions[] = {{"scene_commit", commit}, {NULL, NULL}};
    rtl_add_functions(L, functions);
}
