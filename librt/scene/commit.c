/* Commit: the description becomes a snapshot. */
#include "parts.h"

#include <stdlib.h>
#include <string.h>

#include "../trace/trace.h"

static const char call_name[] = "rt_scene_commit";

rt_commit_desc rt_commit_desc_default(void)
{
    rt_commit_desc d;
    memset(&d, 0, sizeof d);
    d.struct_size = sizeof d;
    d.accel = "auto";
    d.builder = "auto";
    d.refit = 1.25f;
    return d;
}

/* ---- the descriptor ---- */

static rt_status unknown_word(rt_context *ctx, const char *field, const char *word, size_t length, const char *const *names,
                              size_t count)
{
    char text[96], copy[64], words[128];
    const char *near;
    size_t used = 0;
    snprintf(copy, sizeof copy, "%.*s", (int)(length < 60 ? length : 60), word);
    near = rti_nearest(copy, names, count);
    rti_quote(text, sizeof text, word, length);
    if (near)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "rt_scene_commit: %s has the word \"%s\"; did you mean \"%s\"?", field, text,
                        near);
    for (size_t i = 0; i < count && used < sizeof words; i++)
        used += (size_t)snprintf(words + used, sizeof words - used, "%s\"%s\"", i == 0 ? "" : (i + 1 == count ? " and " : ", "),
                                 names[i]);
    return rti_fail(ctx, RT_ERROR_ARGUMENT, "rt_scene_commit: %s has the word \"%s\"; the words are %s", field, text, words);
}

static size_t find_word(const char *word, size_t length, const char *const *names, size_t count)
{
    size_t i = 0;
    while (i < count && (strlen(names[i]) != length || memcmp(names[i], word, length) != 0))
        i++;
    return i;
}

/* automatic: what "auto" stands for. */
static rt_status parse_accel(rt_context *ctx, const char *text, uint32_t automatic, uint32_t *kinds)
{
    static const char *const names[] = {"auto", "kdtree", "octree", "bvh", "brute"};
    const uint32_t bits[] = {automatic, 1u << RTK_TREE_KD, 1u << RTK_TREE_OCTREE, 1u << RTK_TREE_BVH, 0};
    *kinds = 0;
    for (;;) {
        size_t length = strcspn(text, ","), i = find_word(text, length, names, RTI_COUNT(names));
        if (i == RTI_COUNT(names))
            return unknown_word(ctx, "accel", text, length, names, RTI_COUNT(names));
        *kinds |= bits[i];
        if (text[length] == '\0')
            return RT_OK;
        text += length + 1;
    }
}

static rt_status parse_builder(rt_context *ctx, const char *text, rti_build_settings *settings, bool *automatic)
{
    static const char *const names[] = {"auto", "exact", "binned", "paper", "compact", "spatial"};
    static const uint32_t builders[] = {RTI_BUILD_KD_EXACT, RTI_BUILD_KD_EXACT,    RTI_BUILD_KD_BINNED,
                                        RTI_BUILD_KD_EXACT, RTI_BUILD_BVH_COMPACT, RTI_BUILD_BVH_SPATIAL};
    size_t i = find_word(text, strlen(text), names, RTI_COUNT(names));
    if (i == RTI_COUNT(names))
        return unknown_word(ctx, "builder", text, strlen(text), names, RTI_COUNT(names));
    *automatic = i == 0;
    settings->builder = builders[i];
    if (i == 3) {
        const rti_build_preset *paper = rti_build_preset_find("paper");
        if (paper)
            *settings = paper->settings;
    }
    return RT_OK;
}

static rt_status check_refit(rt_context *ctx, float refit)
{
    char text[32];
    if (refit == 0.0f || (refit >= 1.0f && refit <= 1.0e6f))
        return RT_OK;
    return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: refit is %s; it must be 0 (trees are always built) or from 1 to 1e6", call_name,
                    rti_num(text, refit));
}

static rt_status check_costs(rt_context *ctx, const rt_commit_desc *d)
{
    rt_status status = rti_check_range(ctx, call_name, "cost_traverse", d->cost_traverse, 0.0f, 1.0e6f);
    if (status == RT_OK)
        status = rti_check_range(ctx, call_name, "cost_intersect", d->cost_intersect, 0.0f, 1.0e6f);
    if (status == RT_OK)
        status = rti_check_range(ctx, call_name, "empty_bonus", d->empty_bonus, 0.0f, 1.0f);
    if (status == RT_OK)
        status = rti_check_range(ctx, call_name, "duplication", d->duplication, 0.0f, 1.0e6f);
    if (status == RT_OK)
        status = check_refit(ctx, d->refit);
    if (status == RT_OK && d->max_depth > 96)
        status = rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: max_depth is %u; it must be at most 96 (0: the builder's own)", call_name,
                          d->max_depth);
    return status;
}

/* Settings of the scene from the descriptor; unchanged when it is wrong. */
static rt_status take_desc(rt_scene *scene, const rt_commit_desc *desc)
{
    rt_commit_desc d = rt_commit_desc_default();
    rti_build_settings settings = {0};
    uint32_t kinds = 0;
    bool automatic = true;
    rt_status status;
    if (!desc)
        return RT_OK;
    status = rti_desc_take(scene->ctx, call_name, desc, &d, sizeof d);
    if (status == RT_OK)
        status = parse_builder(scene->ctx, d.builder ? d.builder : "auto", &settings, &automatic);
    if (status == RT_OK) /* who names a builder of kd-trees wants one */
        status = parse_accel(scene->ctx, d.accel ? d.accel : "auto",
                             1u << (automatic || rti_builds_bvh(settings.builder) ? RTK_TREE_BVH : RTK_TREE_KD), &kinds);
    if (status == RT_OK)
        status = check_costs(scene->ctx, &d);
    if (status != RT_OK)
        return status;
    settings.max_depth = d.max_depth ? d.max_depth : settings.max_depth;
    settings.leaf_size = d.leaf_size ? d.leaf_size : settings.leaf_size;
    settings.cost_traverse = d.cost_traverse > 0.0f ? d.cost_traverse : settings.cost_traverse;
    settings.cost_intersect = d.cost_intersect > 0.0f ? d.cost_intersect : settings.cost_intersect;
    settings.empty_bonus = d.empty_bonus > 0.0f ? d.empty_bonus : settings.empty_bonus;
    settings.duplication = d.duplication > 0.0f ? d.duplication : settings.duplication;
    scene->settings = settings;
    scene->auto_builder = automatic;
    scene->refit = d.refit;
    scene->tree_kinds = kinds;
    return RT_OK;
}

rt_status rt_scene_set_tracer(rt_scene *scene, const char *name)
{
    RTI_NEED(scene);
    char names[256], text[64];
    size_t length = 0;
    rt_status status = rti_scene_editable(scene, "rt_scene_set_tracer");
    if (status != RT_OK)
        return status;
    if (!name || strcmp(name, "auto") == 0) {
        scene->tracer = NULL;
        return RT_OK;
    }
    if (rti_tracer_find(RTI_ISA_GENERIC, name)) {
        scene->tracer = rti_tracer_find(RTI_ISA_GENERIC, name)->name;
        return RT_OK;
    }
    for (uint32_t i = 0; i < rti_tracer_count() && length < sizeof names; i++)
        length += (size_t)snprintf(names + length, sizeof names - length, ", \"%s\"", rti_tracer_at(RTI_ISA_GENERIC, i)->name);
    return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "rt_scene_set_tracer: there is no tracer \"%s\"; this build has \"auto\"%s",
                    rti_quote(text, sizeof text, name, strlen(name)), names);
}

/* The tracer of queries: the one asked for, else the best that the wanted trees allow. */
static const rti_tracer *choose_tracer(const rt_scene *scene)
{
    rti_isa isa = rti_context_isa(scene->ctx);
    if (scene->tracer)
        return rti_tracer_find(isa, scene->tracer);
    if (scene->tree_kinds & (1u << RTK_TREE_BVH))
        return rti_tracer_find(isa, "bvh");
    if (scene->tree_kinds & (1u << RTK_TREE_KD))
        return rti_tracer_find(isa, "kdtree");
    return rti_tracer_find(isa, scene->tree_kinds & (1u << RTK_TREE_OCTREE) ? "octree" : "brute");
}

/* ---- children ---- */

typedef struct use {
    rt_scene *child;
    uint32_t instance;
} use;

static int by_child(const void *a, const void *b)
{
    const use *p = a, *q = b;
    if (p->child != q->child)
        return (uintptr_t)p->child < (uintptr_t)q->child ? -1 : 1;
    return p->instance < q->instance ? -1 : 1;
}

static int by_instance(const void *a, const void *b)
{
    const use *p = a, *q = b;
    return p->instance < q->instance ? -1 : 1;
}

/* uses [count] sorted by child: keeps the first of each child, in the order of instances (addresses only bring equal ones
 * together). */
static uint32_t first_uses(use *uses, uint32_t count)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (i == 0 || uses[i].child != uses[kept - 1].child)
            uses[kept++] = uses[i];
    }
    qsort(uses, kept, sizeof *uses, by_instance);
    return kept;
}

static int find_child(const void *key, const void *item)
{
    const rt_scene *child = key;
    const use *u = item;
    if (child != u->child)
        return (uintptr_t)child < (uintptr_t)u->child ? -1 : 1;
    return 0;
}

/* Numbers the groups: each instance gets that of its child. uses: by child, with the group in `instance`. */
static void number_instances(rt_scene *scene, use *uses, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        uses[i].instance = i + 1;
    qsort(uses, count, sizeof *uses, by_child);
    for (size_t i = 0; i < scene->instances.count; i++) {
        rti_inst *inst = RTI_AT(scene->instances, rti_inst, i);
        if (inst->child)
            inst->group = ((const use *)bsearch(inst->child, uses, count, sizeof *uses, find_child))->instance;
    }
}

static rt_status take_child(rti_commit *c, rt_scene *child, uint32_t instance)
{
    rti_snapshot *s = rti_scene_snapshot(child);
    if (!s)
        return rti_fail(c->scene->ctx, RT_ERROR_STATE,
                        "%s: the child of instance %u was never committed; commit it before its parent", c->call, instance);
    c->children[c->child_count] = s;
    c->child_scenes[c->child_count++] = child;
    if (s->group_count > 1) /* its children's groups; instances that were removed keep their places and have none */
        return rti_fail(c->scene->ctx, RT_ERROR_STATE,
                        "%s: the child of instance %u has instances of its own; only two levels are possible", c->call, instance);
    return RT_OK;
}

static rt_status collect_children(rti_commit *c)
{
    rt_scene *scene = c->scene;
    size_t all = scene->instances.count;
    uint32_t count = 0;
    use *uses = rti_alloc_array(scene->ctx, all, sizeof *uses);
    rt_status status = RT_OK;
    if (!uses)
        return rti_fail_memory(scene->ctx, c->call, all * sizeof *uses);
    for (size_t i = 0; i < all; i++) {
        if (RTI_AT(scene->instances, rti_inst, i)->child)
            uses[count++] = (use){RTI_AT(scene->instances, rti_inst, i)->child, (uint32_t)i};
    }
    qsort(uses, count, sizeof *uses, by_child);
    count = first_uses(uses, count);
    c->child_capacity = count;
    c->children = rti_alloc_array(scene->ctx, count, sizeof(rti_snapshot *));
    c->child_scenes = rti_alloc_array(scene->ctx, count, sizeof(rt_scene *));
    if (!c->children || !c->child_scenes)
        status = rti_fail_memory(scene->ctx, c->call, count * sizeof(rti_snapshot *));
    for (uint32_t i = 0; i < count && status == RT_OK; i++)
        status = take_child(c, uses[i].child, uses[i].instance);
    if (status == RT_OK)
        number_instances(scene, uses, count);
    rti_free(scene->ctx, uses, all * sizeof *uses);
    return status;
}

static void release_children(rti_commit *c)
{
    for (uint32_t i = 0; i < c->child_count; i++)
        rti_snapshot_release(c->children[i]);
    rti_free(c->scene->ctx, c->children, c->child_capacity * sizeof(rti_snapshot *));
    rti_free(c->scene->ctx, c->child_scenes, c->child_capacity * sizeof(rt_scene *));
}

/* ---- the whole ---- */

static rt_status make(rti_commit *c)
{
    const rt_scene *scene = c->scene;
    rti_moved moved = {.before = scene->primitives_changed ? NULL : c->last, .limit = scene->refit};
    size_t textures = scene->textures.count;
    const rti_tracer *tracer = choose_tracer(scene);
    rt_status status;
    for (uint32_t i = 0; i < c->child_count; i++)
        textures += c->children[i]->texture_count;
    for (size_t i = 0; i < scene->lights.count; i++)
        c->lamp_count += RTI_AT(scene->lights, rti_light, i)->visible;
    if (textures >= RTI_MAX_PRIMS)
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT,
                        "%s: with those of its instances the scene has %zu textures; at most %u fit", c->call, textures,
                        RTI_MAX_PRIMS);
    c->next = rti_snapshot_new(scene->ctx, c->child_count + 1, (uint32_t)textures);
    if (!c->next)
        return rti_fail_memory(scene->ctx, c->call, sizeof *c->next);
    c->next->tracer = tracer;
    c->next->settings = scene->settings;
    c->next->auto_builder = scene->auto_builder;
    status = rti_commit_group(c);
    if (status == RT_OK)
        status = rti_commit_materials(c);
    if (status == RT_OK)
        status = rti_commit_geometry(c);
    if (status == RT_OK)
        status = rti_commit_lights(c);
    if (status == RT_OK)
        status = rti_commit_world(c);
    if (status == RT_OK)
        status = rti_commit_top(c);
    if (status == RT_OK)
        status = rti_snapshot_build(c->next, c->call, scene->tree_kinds | 1u << tracer->tree, &moved, &c->scene->cancel);
    return status;
}

static rt_status attempt(rt_scene *scene)
{
    rti_commit c = {.scene = scene, .call = call_name};
    rt_status status;
    c.last = rti_scene_snapshot(scene);
    status = collect_children(&c);
    if (status == RT_OK)
        status = make(&c);
    if (status == RT_OK)
        status = rti_snapshot_finish(c.next, call_name);
    if (status == RT_OK) {
        rti_cell_replace(&scene->cell, c.next);
        scene->geometry_changed = scene->primitives_changed = false;
    } else {
        rti_snapshot_release(c.next);
    }
    release_children(&c);
    rti_snapshot_release(c.last);
    return status;
}

rt_status rt_scene_commit(rt_scene *scene, const rt_commit_desc *desc)
{
    rti_fpenv env;
    rt_status status = rti_scene_editable(scene, call_name);
    if (status == RT_OK)
        status = take_desc(scene, desc);
    if (status != RT_OK)
        return status;
    atomic_store(&scene->cancel.asked, false);
    env = rti_fp_enter();
    status = attempt(scene);
    rti_fp_leave(env);
    return status;
}

void rt_scene_cancel(rt_scene *scene)
{
    atomic_store(&scene->cancel.asked, true);
}
