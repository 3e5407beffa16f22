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
    if (!(RTK_MODE & RTK_MODE_ANY))
        q->best = rti_lane_best(a->hits, i);
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

/* A ray through what is below a node, by itself. */
RTI_APART void RTK_NAME(placed_below)(placed *a, rtk_u32 i, rtk_u32 at)
{
    const rtk_tree tree = a->scene->RTK_TOP_TREE;
    const placed_ray *r = &a->ray[i];
    float enter[RTK_BVH_STACK + RTK_BVH_WIDTH]; /* what waits: slots, and where the ray enters them */
    rtk_u32 child[RTK_BVH_STACK + RTK_BVH_WIDTH], count[RTK_BVH_STACK + RTK_BVH_WIDTH], top = 0u;
    rtk_query q;
    RTK_NAME(placed_query)(a, i, &q);
    for (;;) {
        float t[RTK_BVH_WIDTH];
        const rtk_bvhnode *n = &tree.bvh[at];
        const rtk_u32 below = top;
        for (rtk_u32 bits = placed_open(r, n, placed_reach_of(RTK_MODE, r, &q), t); bits != 0u; bits &= bits - 1u) {
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
                RTK_NAME(placed_answer)(a, i, &q, 0);
                return;
            }
            top--;
            if (enter[top] > placed_reach_of(RTK_MODE, r, &q))
                continue;
            at = child[top];
            if (count[top] == 0u)
                break;
            for (rtk_u32 k = 0u; k < count[top]; k++) {
                if (RTK_NAME(instance)(&q, tree.refs[at + k], q.ray.org, 0.0f)) {
                    RTK_NAME(placed_answer)(a, i, &q, 1);
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
    if (n < PLACED_FEW || (!(g->flags & RTK_GROUP_PLAIN) && inst->material != RTK_INVALID)) {
        for (rtk_u32 k = 0u; k < n; k++) {
            rtk_query q;
            RTK_NAME(placed_query)(a, list[k], &q);
            RTK_NAME(placed_answer)(a, list[k], &q, RTK_NAME(instance)(&q, ref, q.ray.org, 0.0f));
        }
        return;
    }
    placed_move(a, RTK_MODE, inst, list, n);
    RTK_NAME(placed_group)(a, inst->group, a->own, RTK_MODE & RTK_MODE_ANY ? NULL : a->found,
                           RTK_MODE & RTK_MODE_ANY ? (uint16_t *)(void *)a->found : NULL, n, a->coherent && n >= PLACED_NEAR);
    placed_merge(a, RTK_MODE, inst, list, n);
}

/* Rays through a leaf's instances. */
static void RTK_NAME(placed_leaf)(placed *a, placed_wait w)
{
    const rtk_tree tree = a->scene->RTK_TOP_TREE;
    const rtk_bvhnode *n = &tree.bvh[w.node];
    for (rtk_u32 k = 0u; k < n->count[w.slot]; k++) {
        if (k != 0u)
            w.size = placed_still(a, RTK_MODE, &w, n);
        RTK_NAME(placed_instance)(a, tree.refs[n->child[w.slot] + k], a->list + w.begin, w.size);
    }
}

/* Rays list[0, size) through the top level. */
static void RTK_NAME(placed_top)(placed *a, rtk_u32 size)
{
    const rtk_tree tree = a->scene->RTK_TOP_TREE;
    a->wait[0] = (placed_wait){0u, PLACED_NODE, 0u, size, size};
    a->top = 1u;
    while (a->top != 0u) {
        placed_wait w = a->wait[--a->top];
        const rtk_bvhnode *n = &tree.bvh[w.node];
        if (w.slot != PLACED_NODE) {
            w.size = placed_still(a, RTK_MODE, &w, n);
            if (w.size == 0u)
                continue;
            if (n->count[w.slot] != 0u) {
                RTK_NAME(placed_leaf)(a, w);
                continue;
            }
            w.node = n->child[w.slot];
            w.slot = PLACED_NODE;
        }
        while (!placed_node(a, RTK_MODE, tree.bvh, &w)) {
            if (w.size <= PLACED_PIECE || a->top + RTK_BVH_WIDTH >= sizeof a->wait / sizeof *a->wait) {
                for (rtk_u32 k = 0u; k < w.size; k++)
                    RTK_NAME(placed_below)(a, a->list[w.begin + k], w.node);
                break;
            }
            const rtk_u32 half = w.size / 2u;
            a->wait[a->top++] = (placed_wait){w.node, PLACED_NODE, w.begin + half, w.size - half, w.behind};
            w.size = half;
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
    for (rtk_u32 first = 0u; first < count; first += RTI_SIMD) {
        rtk_u32 far, lanes = placed_load(a, RTK_MODE, first, count, &far);
        for (; lanes != 0u; lanes &= lanes - 1u)
            a->list[n++] = (uint16_t)(first + (rtk_u32)__builtin_ctz(lanes));
        for (; far != 0u; far &= far - 1u)
            RTK_NAME(placed_alone)(a, first + (rtk_u32)__builtin_ctz(far));
    }
    return n;
}

/* What finishes a hit of a shape. */
static void RTK_NAME(placed_finish)(placed *a, rtk_u32 count)
{
    for (rtk_u32 i = 0u; i < count; i++) {
        const rtk_hit_block *h = &a->hits[i / RTK_BLOCK];
        const rtk_u32 k = i % RTK_BLOCK, inst = h->inst[k];
        rtk_query q;
        if (h->prim[k] == RTK_INVALID ||
            a->scene->groups[inst == RTK_INVALID ? 0u : a->scene->instances[inst].group].geoms[h->geom[k]].type != RTK_GEOM_SHAPES)
            continue;
        RTK_NAME(placed_query)(a, i, &q);
        rti_lane_hit(&q, a->hits, i);
    }
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
        rtk_u32 size;
        a->rays = rays + first / RTK_BLOCK;
        a->hits = hits ? hits + first / RTK_BLOCK : NULL;
        a->occluded = occluded ? occluded + first / RTK_BLOCK : NULL;
        scratch->times = times ? times + first : NULL;
        RTK_NAME(placed_own)(a, n);
        size = RTK_NAME(placed_ready)(a, n);
        if (size != 0u)
            RTK_NAME(placed_top)(a, size);
        if (!(RTK_MODE & RTK_MODE_ANY) && !scratch->bare)
            RTK_NAME(placed_finish)(a, n);
    }
    scratch->times = times;
}
