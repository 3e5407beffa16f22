/* One mode of batches where there are instances (bvh_placed.h). Included by bvh_packet.inl, whose functions it calls. */

/* What the tracer of a group works with. Shapes' parameters are asked for at the end. */
RTI_VEC rti_scratch RTK_NAME(placed_scratch)(const placed *a)
{
    return (rti_scratch){
        .room = a->scratch->room,
        .narrow = a->scratch->narrow,
        .roomy = a->scratch->roomy,
        .turns = a->scratch->turns,
        .bare = true};
}

/* Rays through one group and nothing else. */
static void RTK_NAME(placed_group)(placed *a, rtk_u32 group, const rtk_trace_block *rays, rtk_hit_block *hits, uint16_t *occluded,
                                   uint32_t count, int coherent)
{
    const rtk_scene scene = placed_scene(a->scene, group);
    rti_scratch scratch = RTK_NAME(placed_scratch)(a);
    if (coherent)
        RTK_NAME(packets)(&scene, rays, hits, occluded, count, &scratch);
    else
        RTK_NAME(lone)(&scene, rays, hits, occluded, count, &scratch);
    a->scratch->stats.crowded += scratch.stats.crowded;
    a->scratch->stats.together += scratch.stats.together;
}

#if !(RTK_MODE & 1)
/* Closest hits of rays that the top level has moved, through one group in streams which know by how much. */
static void RTK_NAME(placed_sums)(placed *a, rtk_u32 group, const float *outer, rtk_u32 count)
{
    const rtk_scene scene = placed_scene(a->scene, group);
    rti_scratch scratch = RTK_NAME(placed_scratch)(a);
    RTK_NAME(moved_streams)(&scene, a->own, outer, a->found, count, &scratch, a->coherent);
    a->scratch->stats.crowded += scratch.stats.crowded;
}
#endif

/* A ray as a query, with its best hit so far. */
RTI_VEC void RTK_NAME(placed_query)(const placed *a, rtk_u32 i, rtk_query *q)
{
    rti_lane_query(q, a->scene, a->rays, i, a->scratch);
    if (!(RTK_MODE & RTK_MODE_ANY))
        q->best = rti_lane_best(a->hits, i);
}

/* A ray that goes by itself, and its best hit so far. */
RTI_VEC rti_ray RTK_NAME(placed_one)(const placed *a, rtk_u32 i, rtk_hit *best)
{
    const placed_ray *r = &a->ray[i];
    const placed_rest *s = &a->rest[i];
    *best = RTK_MODE & RTK_MODE_ANY ? rtk_hit_none(s->tmax) : rti_lane_best(a->hits, i);
    return (rti_ray){{r->org[0], r->org[1], r->org[2]}, s->tmin, {s->dir[0], s->dir[1], s->dir[2]}, s->tmax, s->mask};
}

/* What such a ray has found. */
RTI_VEC void RTK_NAME(placed_answer)(placed *a, rtk_u32 i, const rtk_hit *best, int end)
{
    if (!(RTK_MODE & RTK_MODE_ANY))
        placed_take(a, i, *best);
    else if (end)
        placed_stop(a, i);
}

/* A ray through all of the top level by itself. */
RTI_APART void RTK_NAME(placed_alone)(placed *a, rtk_u32 i)
{
    rtk_query q;
    RTK_NAME(placed_query)(a, i, &q);
    const int end = RTK_NAME(one_instances)(&q);
    RTK_NAME(placed_answer)(a, i, &q.best, end);
}

/* A ray through what is below a node, by itself. */
RTI_APART void RTK_NAME(placed_below)(placed *a, rtk_u32 i, rtk_u32 at)
{
    const rtk_tree tree = a->scene->top_bvh;
    const placed_ray *r = &a->ray[i];
    float enter[RTK_BVH_STACK + RTK_BVH_WIDTH]; /* what waits: slots, and where the ray enters them */
    rtk_u32 child[RTK_BVH_STACK + RTK_BVH_WIDTH], count[RTK_BVH_STACK + RTK_BVH_WIDTH], top = 0u;
    rtk_hit best;
    const rti_ray ray = RTK_NAME(placed_one)(a, i, &best);
    const float time = a->scratch->times ? a->scratch->times[i] : 0.0f;
    for (;;) {
        float t[RTK_BVH_WIDTH];
        const rtk_bvhnode *n = &tree.bvh[at];
        const rtk_u32 below = top;
        for (rtk_u32 bits = placed_open(r, n, placed_reach_of(RTK_MODE, r, &best), t); bits != 0u; bits &= bits - 1u) {
            const rtk_u32 s = (rtk_u32)__builtin_ctz(bits);
            rtk_u32 to = top++;
            for (; to > below && enter[to - 1u] < t[s]; to--) {
                enter[to] = enter[to - 1u];
                child[to] = child[to - 1u];
                count[to] = count[to - 1u];
            }
            enter[to] = t[s];
            child[to] = n->child[s];
            count[to] = n->count[s];
        }
        for (;;) {
            if (top == 0u) {
                RTK_NAME(placed_answer)(a, i, &best, 0);
                return;
            }
            top--;
            if (enter[top] > placed_reach_of(RTK_MODE, r, &best))
                continue;
            at = child[top];
            if (count[top] == 0u)
                break;
            for (rtk_u32 k = 0u; k < count[top]; k++) {
                if (RTK_NAME(one_instance)(a->scene, &ray, time, tree.refs[at + k], 0.0f, &best)) {
                    RTK_NAME(placed_answer)(a, i, &best, 1);
                    return;
                }
            }
        }
    }
}

/* Rays through an instance. */
static void RTK_NAME(placed_instance)(placed *a, rtk_u32 ref, const uint16_t *list, rtk_u32 n)
{
    const rtk_instance *inst = &a->scene->instances[ref];
    const rtk_group *g = &a->scene->groups[inst->group];
    if (inst->mask == 0u)
        return;
    /* an alpha map may be of the instance's material, of which the group knows nothing */
    if (n < PLACED_FEW || (!(g->flags & RTK_GROUP_PLAIN) && inst->material != RTK_INVALID) ||
        (g->shape_count != 0u && !a->coherent && !placed_alike(a, list, n))) {
        for (rtk_u32 k = 0u; k < n; k++) {
            rtk_hit best;
            const rti_ray ray = RTK_NAME(placed_one)(a, list[k], &best);
            const float time = a->scratch->times ? a->scratch->times[list[k]] : 0.0f;
            const int end = RTK_NAME(one_instance)(a->scene, &ray, time, ref, 0.0f, &best);
            RTK_NAME(placed_answer)(a, list[k], &best, end);
        }
        return;
    }
    const int together = a->coherent && (n >= PLACED_NEAR || 2u * n >= a->count);
    const rtk_u32 blocks = placed_blocks(a, list, n, together);
    if (blocks != 0u)
        placed_move_blocks(a, RTK_MODE, inst, blocks);
    else
        placed_move(a, inst, list, n);
    RTK_NAME(placed_group)(a, inst->group, a->own, RTK_MODE & RTK_MODE_ANY ? NULL : a->found,
                           RTK_MODE & RTK_MODE_ANY ? (uint16_t *)(void *)a->found : NULL,
                           blocks != 0u ? RTK_BLOCK * blocks : n, together);
    if (blocks != 0u)
        placed_merge_blocks(a, RTK_MODE, inst, blocks);
    else
        placed_merge(a, RTK_MODE, inst, list, n);
}

/* Rays through a leaf's instances. */
static void RTK_NAME(placed_leaf)(placed *a, placed_wait w)
{
    const rtk_tree tree = a->scene->top_bvh;
    const rtk_bvhnode *n = &tree.bvh[w.node];
    for (rtk_u32 k = 0u; k < n->count[w.slot]; k++) {
        if (k != 0u)
            w.size = placed_still(a, &w, n);
        w.hits = a->hit_count;
        if (w.size == 0u)
            return;
        RTK_NAME(placed_instance)(a, tree.refs[n->child[w.slot] + k], a->list + w.begin, w.size);
    }
}

/* Rays list[0, size) through the top level. */
static void RTK_NAME(placed_top)(placed *a, rtk_u32 size)
{
    const rtk_tree tree = a->scene->top_bvh;
    a->wait[0] = (placed_wait){0u, PLACED_NODE, 0u, size, size, 0u};
    a->top = 1u;
    while (a->top != 0u) {
        placed_wait w = a->wait[--a->top];
        const rtk_bvhnode *n = &tree.bvh[w.node];
        if (w.slot != PLACED_NODE) {
            w.size = placed_still(a, &w, n);
            if (w.size == 0u)
                continue;
            if (n->count[w.slot] != 0u) {
                RTK_NAME(placed_leaf)(a, w);
                continue;
            }
            w.node = n->child[w.slot];
            w.slot = PLACED_NODE;
        }
        while (!placed_node(a, tree.bvh, &w)) {
            if (w.size <= PLACED_PIECE || a->top + RTK_BVH_WIDTH >= sizeof a->wait / sizeof *a->wait) {
                for (rtk_u32 k = 0u; k < w.size; k++)
                    RTK_NAME(placed_below)(a, a->list[w.begin + k], w.node);
                break;
            }
            const rtk_u32 half = w.size / 2u;
            a->wait[a->top++] = (placed_wait){w.node, PLACED_NODE, w.begin + half, w.size - half, w.behind, w.hits};
            w.size = half;
        }
    }
}

/* Makes the rays ready for the top level; those that start far away go by themselves. Returns how many stand in the list. */
static rtk_u32 RTK_NAME(placed_ready)(placed *a, rtk_u32 count)
{
    rtk_u32 n = 0u;
    for (rtk_u32 first = 0u; first < count; first += RTI_SIMD) {
        rtk_u32 far, lanes = placed_load(a, RTK_MODE, first, count, &far);
        for (; lanes != 0u; lanes &= lanes - 1u)
            a->list[n++] = (uint16_t)(first + (rtk_u32)__builtin_ctz(lanes));
        for (; far != 0u; far &= far - 1u)
            RTK_NAME(placed_alone)(a, first + (rtk_u32)__builtin_ctz(far));
    }
    return n;
}

/* The scene's own group, which often is empty. */
static void RTK_NAME(placed_own)(placed *a, rtk_u32 count)
{
    const rtk_group *g = a->scene->groups;
    if (g->part_count != 0u || g->plane_count != 0u || g->shape_count != 0u) {
        RTK_NAME(placed_group)(a, 0u, a->rays, a->hits, a->occluded, count, a->coherent);
        return;
    }
    for (rtk_u32 b = 0u; b < (count + RTK_BLOCK - 1u) / RTK_BLOCK; b++) {
        if (RTK_MODE & RTK_MODE_ANY)
            a->occluded[b] = 0u;
        else
            pencil_none(&a->rays[b], &a->hits[b], RTK_BLOCK);
    }
}

/* May rays go through the scene's only instance in their blocks, and with sums (bvh_moved.h), if it is one? As placed_instance. */
RTI_VEC int RTK_NAME(placed_is_one)(const placed *a, int sums)
{
    const rtk_instance *inst = a->scene->instances;
    const rtk_group *g = &a->scene->groups[inst->group];
    if (a->scene->instance_count != 1u || (!(g->flags & RTK_GROUP_PLAIN) && inst->material != RTK_INVALID))
        return 0;
    if (sums)
        return !(RTK_MODE & RTK_MODE_ANY) && g->part_count == 1u && g->plane_count == 0u && stream_fits(g, g->parts);
    return g->shape_count == 0u || a->coherent;
}

/* Rays [first, first + count), whole blocks before, through the scene's only instance, which is its top level. outer: room for
 * what the top level moves them by, if many start far away. */
static void RTK_NAME(placed_only)(placed *a, rtk_u32 first, rtk_u32 count, float *outer)
{
    const rtk_instance *inst = a->scene->instances;
    uint16_t *any = RTK_MODE & RTK_MODE_ANY ? (uint16_t *)(void *)a->found : NULL;
    rtk_u32 blocks = 0u, far = 0u;
    if (inst->mask == 0u)
        return;
    for (rtk_u32 i = first; i < first + count; i += RTK_BLOCK) {
        rtk_u32 away;
        const rtk_u32 b = i / RTK_BLOCK, lanes = placed_approach(a, RTK_MODE, b, rtk_umin(first + count - i, RTK_BLOCK), blocks,
                                                                 outer ? outer + RTK_BLOCK * blocks : NULL, &away);
        a->behind[b] = (uint16_t)away;
        far |= away;
        blocks += lanes != 0u;
    }
    if (blocks != 0u) {
#if !(RTK_MODE & 1)
        if (outer)
            RTK_NAME(placed_sums)(a, inst->group, outer, RTK_BLOCK * blocks);
        else
#endif
            RTK_NAME(placed_group)(a, inst->group, a->own, any ? NULL : a->found, any, RTK_BLOCK * blocks, a->coherent);
        placed_merge_blocks(a, RTK_MODE, inst, blocks);
    }
    for (rtk_u32 i = first; far != 0u && i < first + count; i += RTK_BLOCK)
        for (rtk_u32 l = a->behind[i / RTK_BLOCK]; l != 0u; l &= l - 1u)
            RTK_NAME(placed_alone)(a, i + (rtk_u32)__builtin_ctz(l));
}

/* All rays into the instances. */
static void RTK_NAME(placed_all)(placed *a, rtk_u32 count)
{
    if (!(a->scene->top_lo.x <= a->scene->top_hi.x))
        return;
    if (RTK_NAME(placed_is_one)(a, 0)) {
        const rtk_u32 step = a->coherent ? PLACED_STEP : count;
        for (rtk_u32 i = 0u; i < count; i += step)
            RTK_NAME(placed_only)(a, i, rtk_umin(count - i, step), NULL);
        return;
    }
    const rtk_u32 size = RTK_NAME(placed_ready)(a, count);
    if (size != 0u)
        RTK_NAME(placed_top)(a, size);
}

#if !(RTK_MODE & 1)
static void JOIN(RTI_TRACER_NAME, placed_all, 1)(placed *a, rtk_u32 count);
/* What was found of rays that start far away from the top level, as the given rays have it; those that have another hit of the same
 * t are to go alone. */
static void RTK_NAME(placed_ties)(placed *a, moved_top *m, const rtk_trace_block *given, rtk_u32 count)
{
    int some = 0;
    for (rtk_u32 i = 0u; i < count; i += RTK_BLOCK)
        some |= moved_found(&m->moved, i / RTK_BLOCK, rtk_umin(count - i, RTK_BLOCK), &given[i / RTK_BLOCK],
                            &m->found[i / RTK_BLOCK]);
    if (!some)
        return;
    memset(m->moved.tied, 0, sizeof m->moved.tied);
    a->occluded = m->moved.tied;
    JOIN(RTI_TRACER_NAME, placed_all, 1)(a, count);
    for (rtk_u32 i = 0u; i < count; i += RTK_BLOCK)
        m->moved.alone[i / RTK_BLOCK] |= m->moved.tied[i / RTK_BLOCK];
}
#endif

/* Rays of which many start far away from the top level, into the instances: as bvh_moved.inl has it of a group. */
static void RTK_NAME(placed_moved)(placed *a, rtk_u32 count)
{
    moved_top *m = (moved_top *)(void *)((char *)a->scratch->room + RTI_TRACE_PLAIN + RTI_TRACE_PLACED);
    const rtk_part top = {.lo = a->scene->top_lo, .hi = a->scene->top_hi, .scale = a->scene->top_scale};
    const rtk_trace_block *given = a->rays;
    rtk_hit_block *hits = a->hits;
    uint16_t *occluded = a->occluded, *any = m->moved.tied;
    const int coherent = a->coherent;
    if (RTK_NAME(placed_is_one)(a, 1)) {
        RTK_NAME(placed_only)(a, 0u, count, m->moved.shift[0]);
        return;
    }
    for (rtk_u32 i = 0u; i < count; i += RTK_BLOCK) {
        const rtk_u32 b = i / RTK_BLOCK;
        rtk_trace_block own = given[b];
        for (rtk_u32 k = 0u; k < RTK_BLOCK && hits; k++) /* what is behind a hit of the scene's own need not be found */
            own.tmax[k] = placed_end(&hits[b], k, own.tmax[k]);
        moved_block(&m->moved, b, rtk_umin(count - i, RTK_BLOCK), &own, &top);
        if (!(RTK_MODE & RTK_MODE_ANY)) {
            pencil_none(&m->moved.own[b], &m->found[b], RTK_BLOCK);
            continue;
        }
        moved_away(&m->moved.own[b], occluded[b]);
        m->moved.alone[b] &= (uint16_t)~occluded[b];
        any[b] = 0u;
    }
    a->rays = m->moved.own;
    a->hits = m->found;
    a->occluded = any;
    a->coherent = 0; /* as in bvh_moved.inl */
    RTK_NAME(placed_all)(a, count);
#if !(RTK_MODE & 1)
    RTK_NAME(placed_ties)(a, m, given, count);
#endif
    a->rays = given;
    a->hits = hits;
    a->occluded = occluded;
    a->coherent = coherent;
    for (rtk_u32 b = 0u; RTK_MODE & RTK_MODE_ANY && b < (count + RTK_BLOCK - 1u) / RTK_BLOCK; b++)
        occluded[b] |= any[b];
    for (rtk_u32 i = 0u; i < count; i++) {
        if (m->moved.alone[i / RTK_BLOCK] >> i % RTK_BLOCK & 1u)
            RTK_NAME(placed_alone)(a, i);
        else if (!(RTK_MODE & RTK_MODE_ANY))
            placed_take(a, i, rti_lane_best(m->found, i));
    }
}

/* Batches where there are instances. */
static void RTK_NAME(placed)(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits, uint16_t *occluded,
                             uint32_t count, rti_scratch *scratch, int coherent)
{
    placed *a = (placed *)(void *)((char *)scratch->room + RTI_TRACE_PLAIN);
    const float *times = scratch->times;
    a->scene = scene;
    a->scratch = scratch;
    a->coherent = coherent;
    for (uint32_t first = 0u; first < count; first += PLACED) {
        const uint32_t n = rtk_umin(count - first, PLACED);
        a->rays = rays + first / RTK_BLOCK;
        a->hits = hits ? hits + first / RTK_BLOCK : NULL;
        a->occluded = occluded ? occluded + first / RTK_BLOCK : NULL;
        scratch->times = times ? times + first : NULL;
        a->count = n;
        a->hit_count = 0u;
        RTK_NAME(placed_own)(a, n);
        if (scene->top_lo.x <= scene->top_hi.x &&
            moved_many(a->rays, n, scene->top_lo, scene->top_hi, scene->top_scale, coherent))
            RTK_NAME(placed_moved)(a, n);
        else
            RTK_NAME(placed_all)(a, n);
        if (!(RTK_MODE & RTK_MODE_ANY) && !scratch->bare)
            RTK_NAME(finish)(scene, a->rays, a->hits, n, scratch);
    }
    scratch->times = times;
}
