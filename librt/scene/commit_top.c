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

static bool is_there(const rti_commit *c, const rti_inst *inst)
{
    const rtk_group_header *head = inst->child ? group_head(c, inst->group) : NULL;
    return head && (bounded(head) || head->plane_count > 0);
}

/* Everything but the growth of the box, and of what moves the box at time 0. */
static void put_instance(const rti_commit *c, const rti_inst *inst, rtk_instance *out)
{
    const rtk_group_header *head;
    put_nothing(out);
    if (!is_there(c, inst))
        return;
    head = group_head(c, inst->group);
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

/* The way of a moving instance and the box of all its times; keys: room for its places. */
static void put_motion(const rti_commit *c, const rti_inst *inst, rtk_xfm *keys, rtk_motion *motions, uint32_t first,
                       rtk_instance *out)
{
    const rtk_group_header *head = group_head(c, inst->group);
    keys[0] = inst->to_world;
    memcpy(keys + 1, inst->motion, inst->motion_count * sizeof *keys);
    rti_motion_make(keys, inst->motion_count, motions + first); /* no fault: it was made when it was described */
    out->flags |= RTK_INST_MOVING;
    out->motion_first = first;
    out->motion_count = inst->motion_count;
    if (bounded(head))
        rti_motion_bounds(motions + first, inst->motion_count, head->lo, head->hi, out->lo, out->hi);
}

static bool in_tree(const rtk_instance *inst)
{
    return inst->lo[0] <= inst->hi[0] && !(inst->flags & RTK_INST_UNBOUNDED);
}

static float largest(const float lo[3], const float hi[3])
{
    float x = 0.0f;
    for (int k = 0; k < 3; k++)
        x = fmaxf(x, fmaxf(fabsf(lo[k]), fabsf(hi[k])));
    return x;
}

typedef struct top {
    const rti_commit *c;
    rtk_top_header *head;
    rtk_instance *instances;
    rtk_motion *motions;
    uint32_t *unbounded;
} top;

static void growth(const top *t, const rtk_instance *inst, float reach, float by[3])
{
    const rtk_group_header *head = group_head(t->c, inst->group);
    if (inst->flags & RTK_INST_MOVING)
        by[0] = by[1] = by[2] = rti_motion_growth(t->motions + inst->motion_first, inst->motion_count, head->lo, head->hi, reach);
    else
        rti_xfm_growth(&inst->to_world, &inst->to_object, reach, by);
}

/* The box of what an instance places: of what is turned, it is smaller than the box of the turned box. */
static void tighten(const top *t, rtk_instance *inst)
{
    const rtk_group_header *head = group_head(t->c, inst->group);
    if (!(inst->flags & RTK_INST_MOVING) && head->cover_count > 0 && rti_xfm_turns(&inst->to_world))
        rti_xfm_cover(&inst->to_world, head->cover, head->cover_count, inst->lo, inst->hi);
}

static void include(float lo[3], float hi[3], const float more_lo[3], const float more_hi[3])
{
    for (int k = 0; k < 3; k++) {
        lo[k] = fminf(lo[k], more_lo[k]);
        hi[k] = fmaxf(hi[k], more_hi[k]);
    }
}

static void grow_box(const float by[3], float more, float lo[3], float hi[3])
{
    for (int k = 0; k < 3; k++) {
        lo[k] -= by[k] + more;
        hi[k] += by[k] + more;
    }
}

/* transform.c says why this reach suffices: growth(reach) with the part in reach below reach / 2. */
static void grow_all(const top *t, uint32_t count)
{
    rtk_instance *instances = t->instances;
    rtk_top_header *head = t->head;
    float plain = RTK_LEAST, constant = 0.0f, reach;
    for (uint32_t i = 0; i < count; i++) {
        float by[3];
        if (!in_tree(&instances[i]))
            continue;
        plain = fmaxf(plain, largest(instances[i].lo, instances[i].hi));
        growth(t, &instances[i], 0.0f, by);
        constant = fmaxf(constant, fmaxf(by[0], fmaxf(by[1], by[2])));
    }
    reach = 2.0f * (plain + constant);
    for (int k = 0; k < 3; k++) {
        head->lo[k] = head->all_lo[k] = FLT_MAX;
        head->hi[k] = head->all_hi[k] = -FLT_MAX;
    }
    head->scale = RTK_LEAST;
    for (uint32_t i = 0; i < count; i++) {
        rtk_instance *inst = &instances[i];
        float by[3], lo[3], hi[3];
        if (!(inst->lo[0] <= inst->hi[0]))
            continue;
        memcpy(lo, inst->lo, sizeof lo);
        memcpy(hi, inst->hi, sizeof hi);
        growth(t, inst, reach, by);
        tighten(t, inst);
        grow_box(by, 2.0f * RTK_GROW * reach, inst->lo, inst->hi);
        grow_box(by, 2.0f * RTK_GROW * reach, lo, hi);
        include(head->all_lo, head->all_hi, lo, hi);
        if (!in_tree(inst))
            continue;
        include(head->lo, head->hi, lo, hi);
        head->scale = fmaxf(head->scale, largest(lo, hi));
    }
    if (!(head->lo[0] <= head->hi[0]))
        return;
    for (int k = 0; k < 3; k++) {
        head->lo[k] -= RTK_GROW * head->scale;
        head->hi[k] += RTK_GROW * head->scale;
    }
}

/* Instances, their ways, and the list of the unbounded. */
static rt_status put_all(const top *t)
{
    const rt_scene *scene = t->c->scene;
    uint32_t unbounded = 0, motions = 0, most = 0;
    rtk_xfm *keys = NULL;
    for (uint32_t i = 0; i < t->head->instance_count; i++) {
        const rti_inst *inst = RTI_AT(scene->instances, rti_inst, i);
        most = inst->motion_count > most ? inst->motion_count : most;
    }
    if (most > 0 && !(keys = rti_alloc_array(scene->ctx, most + 1, sizeof *keys)))
        return rti_fail_memory(scene->ctx, t->c->call, (most + 1) * sizeof *keys);
    for (uint32_t i = 0; i < t->head->instance_count; i++) {
        const rti_inst *inst = RTI_AT(scene->instances, rti_inst, i);
        put_instance(t->c, inst, &t->instances[i]);
        t->instances[i].id = i;
        if (inst->motion && is_there(t->c, inst)) {
            put_motion(t->c, inst, keys, t->motions, motions, &t->instances[i]);
            motions += inst->motion_count;
        }
        if (t->instances[i].flags & RTK_INST_UNBOUNDED)
            t->unbounded[unbounded++] = i;
    }
    if (keys)
        rti_free(scene->ctx, keys, (most + 1) * sizeof *keys);
    return RT_OK;
}

rt_status rti_commit_top(rti_commit *c)
{
    const rt_scene *scene = c->scene;
    uint32_t count = (uint32_t)scene->instances.count;
    rtk_top_header *head, want = {.instance_count = count};
    rti_layout layout;
    top t = {.c = c};
    uint64_t motions = 0;
    rt_status status;
    for (uint32_t i = 0; i < count; i++) {
        const rti_inst *inst = RTI_AT(scene->instances, rti_inst, i);
        want.unbounded_count += inst->child && group_head(c, inst->group)->plane_count > 0;
        motions += is_there(c, inst) ? inst->motion_count : 0;
    }
    if (motions > RTI_MAX_PRIMS)
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: the instances have more than %u places to go to", c->call,
                        RTI_MAX_PRIMS);
    want.motion_count = (uint32_t)motions;
    rti_layout_begin(&layout, sizeof *head);
    want.off_instances = rti_layout_add(&layout, count, sizeof *t.instances);
    want.off_unbounded = rti_layout_add(&layout, want.unbounded_count, sizeof *t.unbounded);
    want.off_motions = rti_layout_add(&layout, want.motion_count, sizeof *t.motions);
    head = layout.overflow ? NULL : rti_alloc_zero(scene->ctx, layout.size);
    if (!head)
        return rti_fail_memory(scene->ctx, c->call, layout.size);
    *head = want;
    t.head = head;
    t.instances = (rtk_instance *)(void *)((uint8_t *)head + head->off_instances);
    t.unbounded = (uint32_t *)(void *)((uint8_t *)head + head->off_unbounded);
    t.motions = (rtk_motion *)(void *)((uint8_t *)head + head->off_motions);
    status = put_all(&t);
    if (status != RT_OK) {
        rti_free(scene->ctx, head, layout.size);
        return status;
    }
    grow_all(&t, count);
    return rti_commit_chunk(c, RTK_CHUNK_TOP, head, layout.size, &c->next->top);
}
