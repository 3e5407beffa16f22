/* One mode of brute force. Included by modes.inl. */
#include "../kernel/scene_trace.inl"

/* At most MANY rays: the scene's planes, its triangles sixteen rays at a time, its shapes, instances. */
static void RTK_NAME(many)(rtk_query *q, int *done, uint32_t count)
{
    rtk_pray prepared[MANY];
    lanes axes[3];
    axes[0].count = axes[1].count = axes[2].count = 0;
    for (uint32_t i = 0; i < count; i++) {
        const rtk_group *g = q[i].group;
        done[i] = rtk_ray_valid(q[i].ray) ? rtk_query_planes(&q[i], RTK_MODE, q[i].ray) : -1;
        if (done[i] || g->tri_count + g->shape_count == 0 || !rtk_ray_prepare(q[i].ray, g->lo, g->hi, g->scale, &prepared[i]))
            continue;
        lanes *l = &axes[prepared[i].kz];
        lanes_add(l, &q[i], &prepared[i], &done[i]);
        for (uint32_t k = 0; k < g->shape_count && !done[i]; k++)
            done[i] = rtk_query_prim(&q[i], RTK_MODE, &prepared[i], g->tri_count + k);
        if (l->count == WIDTH)
            lanes_flush(l, prepared[i].kz, RTK_MODE);
    }
    for (uint32_t a = 0; a < 3; a++)
        lanes_flush(&axes[a], a, RTK_MODE);
    for (uint32_t i = 0; i < count; i++)
        if (!done[i])
            done[i] = RTK_NAME(instances)(&q[i]);
}

static void RTK_NAME(rays)(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits, uint16_t *occluded,
                           uint32_t count, rti_scratch *scratch)
{
    rtk_query q[MANY];
    int done[MANY];
    for (uint32_t base = 0; base < count; base += MANY) {
        uint32_t n = count - base < MANY ? count - base : MANY;
        for (uint32_t i = 0; i < n; i++) {
            rti_lane_query(&q[i], scene, rays, base + i);
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
