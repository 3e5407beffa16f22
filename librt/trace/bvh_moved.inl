/* One mode of batches that start far away (bvh_moved.h). Included by bvh_packet.inl, whose functions it calls. */

/* A given ray through the group's only part by itself. */
RTI_APART void RTK_NAME(moved_alone)(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits, uint16_t *occluded,
                                     rtk_u32 i, const rti_scratch *scratch)
{
    const rtk_part *part = scene->groups->parts;
    rtk_query q;
    rtk_pray r;
    int end = 0;
    rti_lane_query(&q, scene, rays, i, scratch);
    if (rtk_ray_valid(q.ray) && rtk_ray_prepare(q.ray, part->lo, part->hi, part->scale, &r))
        end = RTK_NAME(group_walk)(&q, part->bvh, part->count, &r, 0.0f);
    if (!(RTK_MODE & RTK_MODE_ANY))
        rti_lane_keep(hits, i, q.best);
    else if (end)
        occluded[i / RTK_BLOCK] |= (uint16_t)(1u << i % RTK_BLOCK);
}

/* The group's planes, as they meet the given rays; hits and occluded are of them. */
static void RTK_NAME(moved_planes)(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits, uint16_t *occluded,
                                   rtk_u32 n, const rti_scratch *scratch)
{
    packet p;
    packet_batch(&p);
    for (rtk_u32 at = 0u; at < n; at += PACKET) {
        const rtk_u32 m = rtk_umin(n - at, PACKET);
        const uint64_t valid = packet_load(&p, scene, rays, at, m, scratch);
        packet_again(&p, RTK_MODE, m, hits, occluded);
        packet_planes(&p, RTK_MODE, valid & ~p.done);
        RTK_NAME(packet_out)(&p, m, hits, occluded, 1);
    }
}

#if !(RTK_MODE & 1) /* any hit comes behind, and is asked for */
static void JOIN(RTI_TRACER_NAME, plain, 1)(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits,
                                            uint16_t *occluded, uint32_t count, rti_scratch *scratch, int coherent);
/* Which of n rays have another hit beside the best one. */
static void RTK_NAME(moved_ties)(moved *a, const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits, rtk_u32 n,
                                 rti_scratch *scratch)
{
    int some = 0;
    for (rtk_u32 i = 0u; i < n; i += RTK_BLOCK)
        some |= moved_found(a, i / RTK_BLOCK, rtk_umin(n - i, RTK_BLOCK), &rays[i / RTK_BLOCK], &hits[i / RTK_BLOCK]);
    if (!some)
        return;
    JOIN(RTI_TRACER_NAME, plain, 1)(scene, a->own, NULL, a->tied, n, scratch, 1);
    for (rtk_u32 i = 0u; i < n; i += RTK_BLOCK)
        a->alone[i / RTK_BLOCK] |= a->tied[i / RTK_BLOCK];
}
#endif

#if !(RTK_MODE & 1)
/* Closest hits among triangles and spheres: in streams that know such sums. outer: as theirs. */
static void RTK_NAME(moved_streams)(const rtk_scene *scene, const rtk_trace_block *rays, const float *outer, rtk_hit_block *hits,
                                    uint32_t count, rti_scratch *scratch, int coherent)
{
    streams *a = scratch->room;
    streams_begin(a, scene, rays, hits, NULL, scratch);
    a->outer = outer;
    streams_part(a, RTK_MODE | STREAM_MOVED, scene->groups->parts, &scene->groups->parts->bvh, rays, count, coherent);
    RTK_NAME(stream_runs) *const run = a->mixed ? RTK_NAME(stream_run_moved_mixed) : RTK_NAME(stream_run_moved);
    for (rtk_u32 first = 0u; first < count; first += PACKET) {
        packet_expect_rays(rays, first + PACKET, count);
        RTK_NAME(stream_loads)(a, first, rtk_umin(count - first, PACKET), 0, RTK_MODE | STREAM_MOVED);
        RTK_NAME(stream_flush_by)(a, PACKET, run);
    }
    RTK_NAME(stream_flush_by)(a, a->length, run);
    if (scene->groups->plane_count != 0u)
        RTK_NAME(moved_planes)(scene, rays, hits, NULL, count, scratch);
}
#endif

/* Rays of one group, of which many start far away. Among triangles and spheres as streams, coherent or not: what is known of the
 * point that a pencil's lines pass through is rounded from where they start, and packets have a large box of origins in common. */
static void RTK_NAME(moved)(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits, uint16_t *occluded,
                            uint32_t count, rti_scratch *scratch, int coherent)
{
    moved *a = (moved *)(void *)((char *)scratch->room + RTI_TRACE_STREAMS);
    const int together = !stream_fits(scene->groups, scene->groups->parts); /* as packets */
    const int planes = (RTK_MODE & RTK_MODE_ANY) && scene->groups->plane_count != 0u; /* at once: whom they hide is done */
    rtk_scene bare = *scene;
    (void)coherent;
#if !(RTK_MODE & 1)
    if (!together) {
        RTK_NAME(moved_streams)(scene, rays, NULL, hits, count, scratch, coherent);
        return;
    }
#endif
    a->group = *scene->groups;
    a->group.plane_count = 0u;
    bare.groups = &a->group;
    for (uint32_t first = 0u; first < count; first += MOVED) {
        const rtk_u32 n = rtk_umin(count - first, MOVED);
        const rtk_trace_block *given = rays + first / RTK_BLOCK;
        rtk_hit_block *h = hits ? hits + first / RTK_BLOCK : NULL;
        uint16_t *any = occluded ? occluded + first / RTK_BLOCK : NULL;
        if (planes) {
            memset(any, 0, (n + RTK_BLOCK - 1u) / RTK_BLOCK * sizeof *any);
            RTK_NAME(moved_planes)(scene, given, h, any, n, scratch);
            memcpy(a->tied, any, (n + RTK_BLOCK - 1u) / RTK_BLOCK * sizeof *any);
        }
        for (rtk_u32 i = 0u; i < n; i += RTK_BLOCK) {
            const rtk_u32 b = i / RTK_BLOCK;
            moved_block(a, b, rtk_umin(n - i, RTK_BLOCK), &given[b], a->group.parts);
            if (planes) {
                moved_away(&a->own[b], a->tied[b]);
                a->alone[b] &= (uint16_t)~a->tied[b];
            }
        }
        RTK_NAME(plain)(&bare, a->own, h, any, n, scratch, together);
        for (rtk_u32 b = 0u; planes && b < (n + RTK_BLOCK - 1u) / RTK_BLOCK; b++)
            any[b] |= a->tied[b];
#if !(RTK_MODE & 1)
        RTK_NAME(moved_ties)(a, &bare, given, h, n, scratch);
#endif
        for (rtk_u32 i = 0u; i < n; i += RTK_BLOCK)
            for (rtk_u32 l = a->alone[i / RTK_BLOCK]; l != 0u; l &= l - 1u)
                RTK_NAME(moved_alone)(&bare, given, h, any, i + (rtk_u32)__builtin_ctz(l), scratch);
        if (scene->groups->plane_count != 0u && !planes)
            RTK_NAME(moved_planes)(scene, given, h, any, n, scratch);
    }
}
