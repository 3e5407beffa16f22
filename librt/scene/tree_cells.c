/* Cells of a tree, whatever its kind. */
#include "look.h"

#include <math.h>
#include <string.h>

#include "../accel/accel.h"

rt_tree_query rt_tree_query_default(void)
{
    rt_tree_query q;
    memset(&q, 0, sizeof q);
    q.struct_size = sizeof q;
    q.tracer = "auto";
    q.normal = (rt_vec3){0, 0, 1};
    q.max_depth = RT_INVALID_ID;
    return q;
}

/* ---- the tree that is asked for ---- */

rt_status rti_look_snapshot(const rt_scene *scene, const char *call, rti_snapshot **snapshot)
{
    *snapshot = rti_scene_snapshot(scene);
    if (!*snapshot)
        return rti_fail(scene->ctx, RT_ERROR_STATE, "%s: the scene was never committed; call rt_scene_commit first", call);
    return RT_OK;
}

rt_status rti_look_group(const rti_snapshot *s, const char *call, uint32_t group)
{
    if (group == RT_INVALID_ID || group < s->group_count)
        return RT_OK;
    if (s->group_count == 1)
        return rti_fail(s->ctx, RT_ERROR_ARGUMENT, "%s: group is %u; the scene has group 0 alone, its own geometry", call, group);
    return rti_fail(s->ctx, RT_ERROR_ARGUMENT, "%s: group is %u; the scene has groups 0 ... %u", call, group, s->group_count - 1);
}

static rt_status find_tracer(rti_look *look, const char *call)
{
    rt_context *ctx = look->snapshot->ctx;
    const char *name = look->query.tracer;
    char quoted[96];
    if (!name)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: tracer is NULL", call);
    look->tracer = strcmp(name, "auto") == 0 ? look->snapshot->tracer : rti_tracer_find(rti_context_isa(ctx), name);
    if (!look->tracer)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: there is no tracer \"%s\"; rt_tracer_at lists them", call,
                        rti_quote(quoted, sizeof quoted, name, strlen(name)));
    return RT_OK;
}

static rt_status check_part(const rti_look *look, const char *call)
{
    uint32_t group = look->query.group, part = look->query.part, count = 1;
    if (group != RT_INVALID_ID)
        count = ((const rtk_group_header *)look->snapshot->groups[group].group->data)->part_count;
    if (part == 0 || part < count)
        return RT_OK;
    return rti_fail(look->snapshot->ctx, RT_ERROR_ARGUMENT, "%s: part is %u; the tree's group has %u", call, part,
                    count > 0 ? count : 1);
}

static rt_status find_tree(rti_look *look, const char *call)
{
    uint32_t kind = look->tracer->tree, group = look->query.group;
    rti_snapshot *with;
    rt_status status = rti_snapshot_with_tree(look->snapshot, call, kind, NULL, &with);
    if (status != RT_OK)
        return status;
    rti_snapshot_release(look->snapshot);
    look->snapshot = with;
    look->tree = group == RT_INVALID_ID ? with->top_tree[kind] : with->groups[group].tree[look->query.part][kind];
    return RT_OK;
}

rt_status rti_look_begin(const rt_scene *scene, const char *call, const rt_tree_query *query, rti_look *look)
{
    rt_status status;
    memset(look, 0, sizeof *look);
    look->query = rt_tree_query_default();
    status = rti_desc_take(scene->ctx, call, query, &look->query, sizeof look->query);
    if (status == RT_OK)
        status = rti_look_snapshot(scene, call, &look->snapshot);
    if (status == RT_OK)
        status = find_tracer(look, call);
    if (status == RT_OK)
        status = rti_look_group(look->snapshot, call, look->query.group);
    if (status == RT_OK)
        status = check_part(look, call);
    if (status == RT_OK)
        status = find_tree(look, call);
    if (status != RT_OK)
        rti_snapshot_release(look->snapshot);
    return status;
}

/* A tree to look at: the tracer must have one. */
static rt_status begin_tree(const rt_scene *scene, const char *call, const rt_tree_query *query, rti_look *look)
{
    rt_status status = rti_look_begin(scene, call, query, look);
    if (status == RT_OK && look->tracer->tree == RTK_TREE_NONE) {
        status = rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: the tracer \"%s\" walks no tree", call, look->tracer->name);
        rti_snapshot_release(look->snapshot);
    }
    return status;
}

rt_status rt_scene_tree_shape(const rt_scene *scene, const rt_tree_query *query, rt_tree_shape *shape)
{
    RTI_NEED(scene);
    static const char call[] = "rt_scene_tree_shape";
    rti_look look;
    rt_status status;
    if (!shape)
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: shape is NULL; give the place for it", call);
    status = begin_tree(scene, call, query, &look);
    if (status != RT_OK)
        return status;
    *shape = (rt_tree_shape){{1, 1, 1}, {-1, -1, -1}, 0, 0, 0};
    if (look.tree) {
        const rtk_tree_header *h = look.tree->data;
        shape->low = (rt_vec3){h->lo[0], h->lo[1], h->lo[2]};
        shape->high = (rt_vec3){h->hi[0], h->hi[1], h->hi[2]};
        shape->sah_cost = h->sah_cost;
        shape->cost_traverse = h->cost_traverse;
        shape->cost_intersect = h->cost_intersect;
    }
    rti_snapshot_release(look.snapshot);
    return RT_OK;
}

/* ---- the walk ---- */

typedef struct walk {
    const rti_tree_kind *kind;
    rtk_tree tree;
    const rt_tree_query *query;
    rti_cut_plane plane;
} walk;

/* All leaves below a spot, as one cell. */
static void gather(const walk *w, const rti_tree_spot *from, rt_tree_cell *cell)
{
    rti_tree_spot stack[RTI_TREE_WALK];
    uint32_t count = 1;
    stack[0] = *from;
    while (count > 0) {
        rti_tree_spot spot = stack[--count];
        uint32_t refs = 0, opened = w->kind->open(&w->tree, &spot, stack + count, &refs);
        count += opened;
        if (opened)
            continue;
        cell->leaves++;
        cell->empty_leaves += refs == 0;
        cell->references += refs;
        cell->deepest = spot.depth > cell->deepest ? spot.depth : cell->deepest;
        cell->largest = refs > cell->largest ? refs : cell->largest;
    }
}

static bool whole(const walk *w, const rti_tree_spot *spot)
{
    if (spot->depth >= w->query->max_depth)
        return true;
    for (int a = 0; a < 3; a++) {
        if (spot->hi[a] - spot->lo[a] >= w->query->min_size)
            return false;
    }
    return true;
}

static rt_status walk_cells(const walk *w, rt_context *ctx, const char *call, rt_tree_cell_fn fn, void *user)
{
    rti_tree_spot stack[RTI_TREE_WALK], children[RTI_TREE_CHILDREN];
    uint32_t count = 1;
    stack[0] = rti_tree_root(&w->tree);
    while (count > 0) {
        rti_tree_spot spot = stack[--count];
        rt_tree_cell cell = {{spot.lo[0], spot.lo[1], spot.lo[2]}, {spot.hi[0], spot.hi[1], spot.hi[2]}, .depth = spot.depth};
        uint32_t refs = 0, opened = 0;
        if (w->query->cut && (cell.corner_count = rti_cut_box(&w->plane, spot.lo, spot.hi, cell.corners)) == 0)
            continue;
        if (!whole(w, &spot))
            opened = w->kind->open(&w->tree, &spot, children, &refs);
        for (uint32_t i = opened; i > 0; i--) /* the first child comes first */
            stack[count++] = children[i - 1];
        if (opened)
            continue;
        gather(w, &spot, &cell);
        if (fn(user, &cell) != 0)
            return rti_fail(ctx, RT_ERROR_CANCELLED, "%s: the callback ended it", call);
    }
    return RT_OK;
}

rt_status rt_scene_tree_cells(const rt_scene *scene, const rt_tree_query *query, rt_tree_cell_fn fn, void *user)
{
    RTI_NEED(scene);
    static const char call[] = "rt_scene_tree_cells";
    rti_look look;
    walk w;
    rt_status status;
    if (!fn)
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: fn is NULL; it is called for each cell", call);
    status = begin_tree(scene, call, query, &look);
    if (status != RT_OK)
        return status;
    memset(&w, 0, sizeof w);
    w.query = &look.query;
    if (look.query.cut)
        status = rti_cut_take(scene->ctx, call, look.query.point, look.query.normal, &w.plane);
    if (status == RT_OK && !(look.query.min_size >= 0.0f))
        status = rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: min_size must be a number >= 0", call);
    if (status == RT_OK && look.tree) {
        w.tree = rti_tree_view(look.tree->data);
        w.kind = rti_tree_kind_of(w.tree.kind);
        status = walk_cells(&w, scene->ctx, call, fn, user);
    }
    rti_snapshot_release(look.snapshot);
    return status;
}
