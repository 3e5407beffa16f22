/* Commit: the instances, with world bounds that no ray's rounding leaves. */
#include "parts.h"

#include <float.h>
#include <math.h>
#include <string.h>

static const rtk_group_header *group_head(const rti_commit *c, uint32_t group)
{
    return c->next->groups[group].group->data;
}

static bool bounded(const rtk_group_header *head)
{
    return head->tri_count + head->shape_count > 0;
}

/* A removed or empty instance keeps its place, for ids are positions; no ray sees it. */
static void put_nothing(rtk_instance *out)
{
    out->to_world = out->to_object = (rtk_xfm){{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    for (int k = 0; k < 3; k++) {
        out->lo[k] = FLT_MAX;
        out->hi[k] = -FLT_MAX;
    }
    out->material = RTK_INVALID;
}

/* Everything but the growth of the box. */
static void put_instance(const rti_commit *c, const rti_inst *inst, rtk_instance *out)
{
    const rtk_group_header *head;
    put_nothing(out);
    if (!inst->child)
        return;
    head = group_head(c, inst->group);
    if (!bounded(head) && head->plane_count == 0)
        return;
    out->group = inst->group;
    out->to_world = inst->to_world;
    rti_xfm_invert(&inst->to_world, &out->to_object);
    if (bounded(head))
        rti_xfm_bounds(&inst->to_world, head->lo, head->hi, out->lo, out->hi);
    out->flags = head->plane_count > 0 ? RTK_INST_UNBOUNDED : 0u;
    out->mask = inst->mask;
    out->material = inst->material;
    out->user_id = inst->user_id;
}

static bool in_tree(const rtk_instance *inst)
{
    return inst->lo[0] <= inst->hi[0] && !(inst->flags & RTK_INST_UNBOUNDED);
}

static float largest(const rtk_instance *inst)
{
    float x = 0.0f;
    for (int k = 0; k < 3; k++)
        x = fmaxf(x, fmaxf(fabsf(inst->lo[k]), fabsf(inst->hi[k])));
    return x;
}

static void grow_one(rtk_instance *inst, float reach, float more)
{
    float by[3];
    rti_xfm_growth(&inst->to_world, &inst->to_object, reach, by);
    for (int k = 0; k < 3; k++) {
        inst->lo[k] -= by[k] + more;
        inst->hi[k] += by[k] + more;
    }
}

/* transform.c says why this reach suffices: growth(reach) with the part in reach below reach / 2. */
static void grow_all(rtk_instance *instances, uint32_t count, rtk_top_header *head)
{
    float plain = 1.0e-30f, constant = 0.0f, reach;
    for (uint32_t i = 0; i < count; i++) {
        float by[3];
        if (!in_tree(&instances[i]))
            continue;
        plain = fmaxf(plain, largest(&instances[i]));
        rti_xfm_growth(&instances[i].to_world, &instances[i].to_object, 0.0f, by);
        constant = fmaxf(constant, fmaxf(by[0], fmaxf(by[1], by[2])));
    }
    reach = 2.0f * (plain + constant);
    for (int k = 0; k < 3; k++) {
        head->lo[k] = FLT_MAX;
        head->hi[k] = -FLT_MAX;
    }
    head->scale = 1.0e-30f;
    for (uint32_t i = 0; i < count; i++) {
        if (!(instances[i].lo[0] <= instances[i].hi[0]))
            continue;
        grow_one(&instances[i], reach, 2.0f * RTK_GROW * reach);
        if (!in_tree(&instances[i]))
            continue;
        head->scale = fmaxf(head->scale, largest(&instances[i]));
        for (int k = 0; k < 3; k++) {
            head->lo[k] = fminf(head->lo[k], instances[i].lo[k]);
            head->hi[k] = fmaxf(head->hi[k], instances[i].hi[k]);
        }
    }
    if (!(head->lo[0] <= head->hi[0]))
        return;
    for (int k = 0; k < 3; k++) {
        head->lo[k] -= RTK_GROW * head->scale;
        head->hi[k] += RTK_GROW * head->scale;
    }
}

rt_status rti_commit_top(rti_commit *c)
{
    const rt_scene *scene = c->scene;
    uint32_t count = (uint32_t)scene->instances.count, unbounded = 0, *list;
    rtk_instance *instances;
    rtk_top_header *head, want = {.instance_count = count};
    rti_layout layout;
    for (uint32_t i = 0; i < count; i++) {
        const rti_inst *inst = RTI_AT(scene->instances, rti_inst, i);
        want.unbounded_count += inst->child && group_head(c, inst->group)->plane_count > 0;
    }
    rti_layout_begin(&layout, sizeof *head);
    want.off_instances = rti_layout_add(&layout, count, sizeof *instances);
    want.off_unbounded = rti_layout_add(&layout, want.unbounded_count, sizeof *list);
    head = layout.overflow ? NULL : rti_alloc_zero(scene->ctx, layout.size);
    if (!head)
        return rti_fail_memory(scene->ctx, c->call, layout.size);
    *head = want;
    instances = (rtk_instance *)(void *)((uint8_t *)head + head->off_instances);
    list = (uint32_t *)(void *)((uint8_t *)head + head->off_unbounded);
    for (uint32_t i = 0; i < count; i++) {
        put_instance(c, RTI_AT(scene->instances, rti_inst, i), &instances[i]);
        instances[i].id = i;
        if (instances[i].flags & RTK_INST_UNBOUNDED)
            list[unbounded++] = i;
    }
    grow_all(instances, count, head);
    return rti_commit_chunk(c, RTK_CHUNK_TOP, head, layout.size, &c->next->top);
}
