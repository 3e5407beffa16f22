/* One mode of batches where there are instances (bvh_placed.h). Included by bvh_packet.inl, whose functions it calls. */

/* Rays through one group and nothing else. Shapes' parameters are asked for at the end. */
static void RTK_NAME(placed_group)(placed *a, rtk_u32 group, const rtk_trace_block *rays, rtk_hit_block *hits, uint16_t *occluded,
                                   uint32_t count, int coherent)
{
    const rtk_scene scene = placed_scene(a->scene, group);
    rti_scratch scratch = {
        .room = a->scratch->room, .narrow = a->scratch->narrow, .turns = a->scratch->turns, .bare = true};
    if (coherent)
        RTK_NAME(packets)(&scene, rays, hits, occluded, count, &scratch);
    else
        RTK_NAME(lone)(&scene, rays, hits, occluded, count, &scratch);
    a->scratch->stats.crowded += scratch.stats.crowded;
    a->scratch->stats.together += scratch.stats.together;
}

/* A ray as a query, with its best hit so far. */
RTI_VEC void RTK_NAME(placed_query)(const placed *a, rtk_u32 i, rtk_query *q)
{
    rti_lane_query(q, a->scene, a->rays, i, a->scratch);
    if (!(RTK_MODE & RTK_MODE_ANY)) {
        const rtk_hit_block *h = &a->hits[i / RTK_BLOCK];
        const rtk_u32 k = i % RTK_BLOCK;
        q->best = (rtk_hit){h->t[k], h->u[k], h->v[k], h->prim[k], h->geom[k], h->inst[k]};
    }
}

/* What a ray that went by itself has found. */
RTI_VEC void RTK_NAME(placed_answer)(placed *a, rtk_u32 i, const rtk_query *q, int end)
{
    if (RTK_MODE & RTK_MODE_ANY)
        a->occluded[i / RTK_BLOCK] |= (uint16_t)((end ? 1u : 0u) << i % RTK_BLOCK);
    else
        placed_take(a, i, q->best);
}

/* A ray through all of the top level by itself. */
RTI_APART void RTK_NAME(placed_alone)(placed *a, rtk_u32 i)
{
    rtk_query q;
    RTK_NAME(placed_query)(a, i, &q);
    RTK_NAME(placed_answer)(a, i, &q, RTK_NAME(instances)(&q));
}

/* Rays through an instance. */
static void RTK_NAME(placed_instance)(placed *a, rtk_u32 ref, const uint16_t *list, rtk_u32 n)
{
    const rtk_instance *inst = &a->scene->instances[ref];
    const rtk_group *g = &a->scene->groups[inst->group];
    if (inst->mask == 0u)
        return;
    /* an alpha map may be of the instance's material, of which the group knows nothing */
    if (n < PLACED_FEW || (!(g->flags & RTK_GROUP_PLAIN) && inst->material != RTK_INVALID)) {
        for (rtk_u32 k = 0u; k < n; k++) {
            rtk_query q;
            RTK_NAME(placed_query)(a, list[k], &q);
            RTK_NAME(placed_answer)(a, list[k], &q, RTK_NAME(instance)(&q, ref, q.ray.org, 0.0f));
        }
        return;
    }
    for (rtk_u32 k = 0u; k < n; k++)
        placed_move(a, RTK_MODE, inst, list[k], k);
    RTK_NAME(placed_group)(a, inst->group, a->own, RTK_MODE & RTK_MODE_ANY ? NULL : a->found,
                           RTK_MODE & RTK_MODE_ANY ? (uint16_t *)(void *)a->found : NULL, n, a->coherent && n >= PLACED_NEAR);
    placed_merge(a, RTK_MODE, inst, list, n);
}

/* Rays list[0, size) through the top level. */
static void RTK_NAME(placed_top)(placed *a, rtk_u32 size)
{
    const rtk_tree tree = a->scene->RTK_TOP_TREE;
    rtk_u32 begin = 0u, at = 0u;
    a->top = 0u;
    for (;;) {
        if (!placed_node(a, RTK_MODE, tree.bvh, at, begin, size))
            for (rtk_u32 k = 0u; k < size; k++)
                RTK_NAME(placed_alone)(a, a->list[begin + k]);
        for (;;) {
            if (a->top == 0u)
                return;
            const placed_wait w = a->wait[--a->top];
            const rtk_bvhnode *n = &tree.bvh[w.node];
            size = placed_still(a, RTK_MODE, &w, n);
            begin = w.begin;
            if (size == 0u)
                continue;
            if (n->count[w.slot] == 0u) {
                at = n->child[w.slot];
                break;
            }
            for (rtk_u32 k = 0u; k < n->count[w.slot]; k++) {
                const placed_wait same = {w.node, w.slot, begin, size};
                if (k != 0u)
                    size = placed_still(a, RTK_MODE, &same, n);
                RTK_NAME(placed_instance)(a, tree.refs[n->child[w.slot] + k], a->list + begin, size);
            }
        }
    }
}

/* Makes the rays ready for the top level; those that start far away go by themselves. Returns how many stand in the list. */
static rtk_u32 RTK_NAME(placed_ready)(placed *a, rtk_u32 count)
{
    const rtk_scene *s = a->scene;
    rtk_u32 n = 0u;
    if (!(s->top_lo.x <= s->top_hi.x))
        return 0u;
    for (rtk_u32 i = 0u; i < count; i++) {
        const rtk_ray r = placed_given(a, i);
        rtk_pray p;
        if (((RTK_MODE & RTK_MODE_ANY) && placed_done(a, i)) || !rtk_ray_valid(r) ||
            !rtk_ray_prepare(r, s->top_lo, s->top_hi, s->top_scale, &p))
            continue;
        if (p.tshift != 0.0f) {
            RTK_NAME(placed_alone)(a, i);
            continue;
        }
        a->ray[i] = (placed_ray){{p.org.x, p.org.y, p.org.z}, {p.inv.x, p.inv.y, p.inv.z}, p.t0, p.t1};
        a->list[n++] = (uint16_t)i;
    }
    return n;
}

/* What finishes a hit of a shape. */
static void RTK_NAME(placed_finish)(placed *a, rtk_u32 count)
{
    for (rtk_u32 i = 0u; i < count; i++) {
        rtk_query q;
        RTK_NAME(placed_query)(a, i, &q);
        rti_lane_hit(&q, a->hits, i);
    }
}

/* Batches where there are instances. */
static void RTK_NAME(placed)(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits, uint16_t *occluded,
                             uint32_t count, rti_scratch *scratch, int coherent)
{
    placed *a = (placed *)(void *)((char *)scratch->room + RTI_TRACE_STREAMS);
    const float *times = scratch->times;
    a->scene = scene;
    a->scratch = scratch;
    a->coherent = coherent;
    for (uint32_t first = 0u; first < count; first += PLACED) {
        const uint32_t n = rtk_umin(count - first, PLACED);
        rtk_u32 size;
        a->rays = rays + first / RTK_BLOCK;
        a->hits = hits ? hits + first / RTK_BLOCK : NULL;
        a->occluded = occluded ? occluded + first / RTK_BLOCK : NULL;
        scratch->times = times ? times + first : NULL;
        RTK_NAME(placed_group)(a, 0u, a->rays, a->hits, a->occluded, n, coherent);
        size = RTK_NAME(placed_ready)(a, n);
        if (size != 0u)
            RTK_NAME(placed_top)(a, size);
        if (!(RTK_MODE & RTK_MODE_ANY) && !scratch->bare)
            RTK_NAME(placed_finish)(a, n);
    }
    scratch->times = times;
}
