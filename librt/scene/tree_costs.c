/* What rays cost: a tracer's own counts, ray by ray. */
#include "look.h"

#include <string.h>

#define CHUNK  256u /* rays at a time */
#define BLOCKS (CHUNK / RTK_BLOCK)

typedef struct blocks {
    _Alignas(64) rtk_trace_block rays[BLOCKS];
    _Alignas(64) rtk_hit_block hits[BLOCKS];
    rti_steps steps[CHUNK];
} blocks;

/* A scene of one tree of a group and nothing else. */
static rtk_scene only_group(const rtk_scene *all, uint32_t group, uint32_t part, rtk_group *copy)
{
    rtk_scene one = *all;
    *copy = all->groups[group];
    copy->plane_count = 0;
    if (copy->part_count > 0) {
        copy->parts[0] = all->groups[group].parts[part];
        copy->part_count = 1;
    }
    one.groups = copy;
    one.group_count = 1;
    one.instance_count = one.unbounded_count = 0;
    one.top_lo = rtk_v3(1.0f, 1.0f, 1.0f);
    one.top_hi = rtk_v3(-1.0f, -1.0f, -1.0f);
    return one;
}

rt_status rt_scene_ray_costs(const rt_scene *scene, const rt_tree_query *query, const rt_ray *rays, rt_ray_cost *costs,
                             size_t count)
{
    RTI_NEED(scene);
    static const char call[] = "rt_scene_ray_costs";
    rti_look look;
    rtk_scene view;
    rtk_group group;
    rti_fpenv env;
    blocks b;
    rt_status status;
    if (count > 0 && (!rays || !costs))
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: rays or costs is NULL", call);
    status = rti_look_begin(scene, call, query, &look);
    if (status != RT_OK)
        return status;
    view = look.snapshot->view;
    if (look.query.group != RT_INVALID_ID)
        view = only_group(&look.snapshot->view, look.query.group, look.query.part, &group);
    env = rti_fp_enter();
    for (size_t at = 0; at < count; at += CHUNK) {
        uint32_t n = count - at < CHUNK ? (uint32_t)(count - at) : CHUNK;
        rti_scratch scratch = {.steps = b.steps};
        rti_rays_gather(scene->ctx, rays + at, n, b.rays);
        look.tracer->intersect(&view, b.rays, b.hits, n, RTI_TRACE_STEPS, &scratch);
        for (uint32_t i = 0; i < n; i++)
            costs[at + i] = (rt_ray_cost){b.steps[i].nodes, b.steps[i].leaves, b.steps[i].tests};
    }
    rti_fp_leave(env);
    rti_snapshot_release(look.snapshot);
    return RT_OK;
}
