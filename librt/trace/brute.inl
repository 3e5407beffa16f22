/* One mode of brute force. Included by modes.inl. */
#include "../kernel/scene_trace.inl"

/* A part of the scene's own group: its triangles many rays at a time, its shapes. */
static void RTK_NAME(part)(rtk_query *q, int *done, uint32_t count, const rtk_part *part)
{
    rtk_pray prepared[MANY];
    lanes axes[3];
    uint32_t tris = tri_refs(q[0].group, part);
    axes[0].count = axes[1].count = axes[2].count = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (done[i] || !rtk_ray_prepare(q[i].ray, part->lo, part->hi, part->scale, &prepared[i]))
            continue;
        lanes *l = &axes[prepared[i].kz];
        lanes_add(l, &q[i], &prepared[i], &done[i]);
        for (uint32_t k = tris; k < part->count && !done[i]; k++)
            done[i] = rtk_query_prim(&q[i], RTK_MODE, &prepared[i], part->all.refs ? part->all.refs[k] : k);
        if (l->count == WIDTH)
            lanes_flush(l, part, tris, prepared[i].kz, RTK_MODE);
    }
    for (uint32_t a = 0; a < 3; a++)
        lanes_flush(&axes[a], part, tris, a, RTK_MODE);
}

/* At most MANY rays: the scene's planes, its triangles and shapes, instances. */
static void RTK_NAME(many)(rtk_query *q, int *done, uint32_t count)
{
    const rtk_group *g = q[0].group;
    for (uint32_t i = 0; i < count; i++)
        done[i] = rtk_ray_valid(q[i].ray) ? rtk_query_planes(&q[i], RTK_MODE, q[i].ray) : -1;
    for (uint32_t k = 0; k < g->part_count; k++)
        RTK_NAME(part)(q, done, count, &g->parts[k]);
    for (uint32_t i = 0; i < count; i++)
        if (!done[i])
            done[i] = RTK_NAME(instances)(&q[i]);
}

/* Apart: Clang's stack had room for two modes' rays at once. */
RTI_APART void RTK_NAME(rays)(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits, uint16_t *occluded,
                              uint32_t count, rti_scratch *scratch)
{
    rtk_query q[MANY];
    int done[MANY];
    for (uint32_t base = 0; base < count; base += MANY) {
        uint32_t n = count - base < MANY ? count - base : MANY;
        for (uint32_t i = 0; i < n; i++) {
            rti_lane_query(&q[i], scene, rays, base + i, scratch);
            if (RTK_MODE & RTK_MODE_AFTER)
                rti_lane_after(&q[i], hits, base + i);
        }
        RTK_NAME(many)(q, done, n);
        for (uint32_t i = 0; i < n; i++) {
            if (RTK_MODE & RTK_MODE_ANY)
                rti_lane_occluded(occluded, base + i, done[i] > 0);
            else
                rti_lane_hit(&q[i], hits, base + i);
            if (RTK_MODE & RTK_MODE_STEPS)
                rti_lane_count(&q[i], base + i, scratch);
        }
    }
}
