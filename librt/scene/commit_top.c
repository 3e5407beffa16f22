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
    uint32_t *covers; /* of each group the number of its cover among the scene's, counted from 1, or 0 */
} top;

static void growth(const top *t, const rtk_instance *inst, float reach, float by[3])
{
    const rtk_group_header *head = group_head(t->c, inst->group);
    if (inst->flags & RTK_INST_MOVING)
        by[0] = by[1] = by[2] = rti_motion_growth(t->motions + inst->motion_first, inst->motion_count, head->lo, head->hi, reach);
    else
        rti_xfm_growth(&inst->to_world, &inst->to_object, reach, by);
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
static float reach_of(const top *t)
{
    const rtk_instance *instances = t->instances;
    float plain = RTK_LEAST, constant = 0.0f;
    for (uint32_t i = 0; i < t->head->instance_count; i++) {
        float by[3];
        if (!in_tree(&instances[i]))
            continue;
        plain = fmaxf(plain, largest(instances[i].lo, instances[i].hi));
        growth(t, &instances[i], 0.0f, by);
        constant = fmaxf(constant, fmaxf(by[0], fmaxf(by[1], by[2])));
    }
    return 2.0f * (plain + constant);
}

/* The boxes of all, of which each instance has its turned box yet. */
static void measure_top(const top *t, float reach)
{
    rtk_top_header *head = t->head;
    for (int k = 0; k < 3; k++) {
        head->lo[k] = head->all_lo[k] = FLT_MAX;
        head->hi[k] = head->all_hi[k] = -FLT_MAX;
    }
    head->scale = RTK_LEAST;
    for (uint32_t i = 0; i < head->instance_count; i++) {
        const rtk_instance *inst = &t->instances[i];
        float by[3], lo[3], hi[3];
        if (!(inst->lo[0] <= inst->hi[0]))
            continue;
        memcpy(lo, inst->lo, sizeof lo);
        memcpy(hi, inst->hi, sizeof hi);
        growth(t, inst, reach, by);
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

/* ---- instances' own boxes: of what is turned, smaller than the box of its turned box ---- */

static bool turned(const rtk_instance *inst)
{
    return inst->lo[0] <= inst->hi[0] && !(inst->flags & RTK_INST_MOVING) && rti_xfm_turns(&inst->to_world);
}

/* A cover that the last commit made, about where the one before it stood. */
static const rti_cover_boxes *known_cover(const rti_array *covers, size_t *at, const rti_hash *group)
{
    for (size_t k = 0; k < 64 && *at + k < covers->count; k++) {
        const rti_cover_boxes *cover = RTI_AT(*covers, rti_cover_boxes, *at + k);
        if (memcmp(&cover->group, group, sizeof *group) == 0) {
            *at += k + 1;
            return cover;
        }
    }
    return NULL;
}

/* Those of the groups that some instance turns; what the scene had goes. */
static rt_status find_covers(const top *t)
{
    rt_scene *scene = t->c->scene;
    rti_array covers = {0};
    size_t at = 0;
    for (uint32_t i = 0; i < t->head->instance_count; i++)
        if (turned(&t->instances[i]))
            t->covers[t->instances[i].group] = 1;
    for (uint32_t g = 0; g < t->c->next->group_count; g++) {
        const rti_chunk *group = t->c->next->groups[g].group;
        rti_cover_boxes *cover;
        if (t->covers[g] == 0)
            continue;
        cover = rti_array_push(scene->ctx, &covers, sizeof *cover);
        if (!cover) {
            rt_status status = rti_array_refused(scene->ctx, t->c->call, &covers, 1, sizeof *cover);
            rti_array_free(scene->ctx, &covers, sizeof *cover);
            return status;
        }
        const rti_cover_boxes *known = known_cover(&scene->covers, &at, &group->hash);
        if (known)
            *cover = *known;
        else
            rti_group_cover(scene->ctx, group, cover);
        t->covers[g] = (uint32_t)covers.count;
    }
    rti_array_free(scene->ctx, &scene->covers, sizeof(rti_cover_boxes));
    scene->covers = covers;
    return RT_OK;
}

#define BOXES_A_TASK 512u
typedef struct box_job {
    const top *t;
    float reach;
} box_job;

static void box_task(void *data, uint32_t task)
{
    const box_job *job = data;
    const top *t = job->t;
    for (uint32_t i = task * BOXES_A_TASK; i < (task + 1) * BOXES_A_TASK && i < t->head->instance_count; i++) {
        rtk_instance *inst = &t->instances[i];
        float by[3];
        if (!(inst->lo[0] <= inst->hi[0]))
            continue;
        growth(t, inst, job->reach, by);
        if (turned(inst)) {
            const rti_cover_boxes *cover = RTI_AT(t->c->scene->covers, rti_cover_boxes, t->covers[inst->group] - 1);
            rti_xfm_cover(&inst->to_world, (const float(*)[6])cover->box, cover->count, inst->lo, inst->hi);
        }
        grow_box(by, 2.0f * RTK_GROW * job->reach, inst->lo, inst->hi);
    }
}

static rt_status box_all(top *t)
{
    rt_context *ctx = t->c->scene->ctx;
    const uint32_t groups = t->c->next->group_count, count = t->head->instance_count;
    box_job job = {t, reach_of(t)};
    rt_status status;
    measure_top(t, job.reach);
    t->covers = rti_alloc_zero(ctx, groups * sizeof *t->covers);
    if (!t->covers)
        return rti_fail_memory(ctx, t->c->call, groups * sizeof *t->covers);
    status = find_covers(t);
    if (status == RT_OK && count > 0)
        rti_parallel(ctx, (count - 1) / BOXES_A_TASK + 1, box_task, &job);
    rti_free(ctx, t->covers, groups * sizeof *t->covers);
    return status;
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
    if (status == RT_OK)
        status = box_all(&t);
    if (status != RT_OK) {
        rti_free(scene->ctx, head, layout.size);
        return status;
    }
    return rti_commit_chunk(c, RTK_CHUNK_TOP, head, layout.size, &c->next->top);
}
