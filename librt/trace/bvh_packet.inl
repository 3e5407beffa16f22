/* One mode of the walk by packets, behind that by single rays (single.inl), whose functions it calls. Included by modes.inl. */

/* The rays of a packet for which more than triangles of the scene itself is to be asked, or that go singly, in a part. */
static void RTK_NAME(packet_single)(packet *p, const rtk_part *part, uint64_t rays)
{
    for (; rays != 0u; rays &= rays - 1u) {
        rtk_u32 i = (rtk_u32)__builtin_ctzll(rays);
        rtk_query q;
        rtk_pray r;
        packet_query(p, i, &q);
        if (!rtk_ray_prepare(q.ray, part->lo, part->hi, part->scale, &r))
            continue;
        if (RTK_NAME(group_walk)(&q, part->RTK_TREE, part->count, &r, 0.0f))
            p->done |= (uint64_t)1u << i;
        packet_answer(p, i, &q);
    }
}

/* Rays that go singly. Apart from the packets' loops, whose registers it would take. */
__attribute__((noinline)) static void RTK_NAME(lone_rays)(packet *p, const rtk_part *part, uint64_t rays)
{
    if (rays != 0u && lone_fits(p->scene->groups, part))
        rays = lone_rays(p, RTK_MODE, part, rays);
    RTK_NAME(packet_single)(p, part, rays);
}

static void RTK_NAME(packet_part)(packet *p, const rtk_part *part, uint64_t rays)
{
    uint64_t far;
    rays = packet_prepare(p, part, rays, &far);
    RTK_NAME(packet_single)(p, part, far);
    while (rays != 0u) {
        const vec key = V(set)(p->key[__builtin_ctzll(rays)]);
        uint64_t same = 0u;
        for (rtk_u32 i = 0u; i < PACKET; i += RTI_SIMD)
            same |= (uint64_t)VM(bits)(V(eq)(V(load)(p->key + i), key)) << i;
        same &= rays;
        rays &= ~same;
        if ((rtk_u32)__builtin_popcountll(same) >= PACKET_FEW) {
            packet_begin(p, RTK_MODE, same);
            same = packet_walk(p, RTK_MODE, part);
            if (!(RTK_MODE & RTK_MODE_ANY))
                packet_know(p, part);
        }
        RTK_NAME(lone_rays)(p, part, same);
    }
}

/* The same for rays that have nothing in common. */
static void RTK_NAME(lone_part)(packet *p, const rtk_part *part, uint64_t rays)
{
    uint64_t far;
    rays = packet_prepare(p, part, rays, &far);
    RTK_NAME(packet_single)(p, part, far);
    RTK_NAME(lone_rays)(p, part, rays);
}

/* Planes, instances, and what finishes a hit, one ray at a time. */
static void RTK_NAME(packet_rest)(packet *p, rtk_u32 n, uint64_t valid, rtk_hit_block *hits)
{
    for (rtk_u32 i = 0u; i < n; i++) {
        rtk_query q;
        packet_query(p, i, &q);
        if (valid >> i & 1u && !(p->done >> i & 1u)) {
            if (rtk_query_planes(&q, RTK_MODE, q.ray) || RTK_NAME(instances)(&q))
                p->done |= (uint64_t)1u << i;
        }
        if (!(RTK_MODE & RTK_MODE_ANY))
            rti_lane_hit(&q, hits, packet_number(p, i));
    }
}

/* What n lanes have found goes to their rays' places. */
RTI_VEC void RTK_NAME(packet_out)(const packet *p, rtk_u32 n, rtk_hit_block *hits, uint16_t *occluded, int plain)
{
    for (rtk_u32 at = 0u; at < n && !p->picks; at += RTK_BLOCK) {
        rtk_u32 b = (p->first + at) / RTK_BLOCK, lanes = n - at < RTK_BLOCK ? n - at : RTK_BLOCK;
        if (RTK_MODE & RTK_MODE_ANY) {
            occluded[b] = (uint16_t)(p->done >> at & ((1u << lanes) - 1u));
        } else if (plain && lanes == RTK_BLOCK) {
            packet_hits(p, at, &hits[b], RTK_BLOCK); /* a number, so no call */
        } else if (plain) {
            packet_hits(p, at, &hits[b], lanes);
        }
    }
    for (rtk_u32 i = 0u; i < n && p->picks && plain && !(RTK_MODE & RTK_MODE_ANY); i++) {
        const rtk_u32 number = packet_number(p, i), k = number % RTK_BLOCK;
        rtk_hit_block *h = &hits[number / RTK_BLOCK];
        h->t[k] = p->t[i];
        h->u[k] = p->u[i];
        h->v[k] = p->v[i];
        h->prim[k] = rtk_bits(p->prim[i]);
        h->geom[k] = rtk_bits(p->geom[i]);
        h->inst[k] = RTK_INVALID;
    }
}

/* n rays from `first` on, or of as many picks those that `picked` holds. */
RTI_VEC void RTK_NAME(packet_all)(packet *p, const rtk_scene *scene, const rtk_trace_block *rays, rtk_u32 first,
                                  const uint16_t *picks, const rtk_trace_block *picked, rtk_u32 n, rtk_hit_block *hits,
                                  uint16_t *occluded, rti_scratch *scratch, int coherent)
{
    const rtk_group *g = scene->groups;
    uint64_t valid = packet_load(p, scene, rays, first, picks, picked, n, scratch);
    const int plain = packet_plain(scene, scratch) && (g->plane_count == 0u || packet_sees_all(p));
    for (rtk_u32 k = 0u; k < g->part_count; k++)
        (coherent ? RTK_NAME(packet_part) : RTK_NAME(lone_part))(p, &g->parts[k], valid & ~p->done);
    if (!plain)
        RTK_NAME(packet_rest)(p, n, valid, hits);
    else if (g->plane_count != 0u)
        packet_planes(p, RTK_MODE, valid);
    RTK_NAME(packet_out)(p, n, hits, occluded, plain);
}

static void RTK_NAME(packets)(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits, uint16_t *occluded,
                              uint32_t count, rti_scratch *scratch)
{
    packet p;
    p.spread = p.steps = p.mesh.first = p.mesh.count = 0u;
    for (rtk_u32 first = 0u; first < count; first += PACKET) {
        packet_expect_rays(rays, first + PACKET, count);
        RTK_NAME(packet_all)(&p, scene, rays, first, NULL, rays + first / RTK_BLOCK, rtk_umin(count - first, PACKET), hits, occluded,
                             scratch, 1);
    }
}

/* n rays from `from` on, no more than ORDER_MOST, that are not coherent, in their order or, where it pays, in another. */
static void RTK_NAME(lone_chunk)(packet *p, const rtk_scene *scene, const rtk_trace_block *rays, rtk_u32 from, rtk_u32 n,
                                 rtk_hit_block *hits, uint16_t *occluded, rti_scratch *scratch)
{
    const rtk_part *part = scene->groups->parts;
    const rtk_trace_block *chunk = rays + from / RTK_BLOCK;
    const int large = weave_large(&part->RTK_TREE), orders = ORDER_PAYS(RTK_MODE) && n >= PACKET && !scratch->turns;
    rtk_trace_block picked[PACKET / RTK_BLOCK];
    order o;
    p->spread = order_is_spread(chunk, n, part);
    const int spread = orders && p->spread && !large; /* else, of those that start near each other, run after run */
    rtk_u32 hit = 0u, base = n; /* base: from there on all are in one order */
    if (spread) {
        p->spread = 0u;
        base = scratch->orders ? 0u : n;
    }
    p->steps = 0u;
    for (rtk_u32 at = 0u; at < n; at += ORDER_RUN) {
        const rtk_u32 end = rtk_umin(at + ORDER_RUN, n);
        if (spread && at == ORDER_RUN && p->steps >= ORDER_STEPS * (ORDER_RUN / 16u)) {
            base = rtk_umin(base, at);
            scratch->orders = true;
        }
        if (at == base)
            order_spread(&o, chunk + base / RTK_BLOCK, n - base, part);
        const int run = orders && !p->spread && !spread && hit >= ORDER_RUN / ORDER_HITS && order_run(&o, chunk, at, end - at);
        hit = 0u;
        for (rtk_u32 k = at; k < end; k += PACKET) {
            const rtk_u32 size = rtk_umin(end - k, PACKET), first = from + (run ? at : at >= base ? base : k);
            const uint16_t *picks = run ? o.ray + k : at >= base ? o.ray + (k - base) : NULL;
            if (picks)
                packet_pick(rays, first, picks, size, picked);
            RTK_NAME(packet_all)(p, scene, rays, first, picks, picks ? picked : chunk + k / RTK_BLOCK, size, hits, occluded, scratch,
                                 0);
            hit += packet_count(p, size);
        }
    }
}

static void RTK_NAME(lone)(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits, uint16_t *occluded,
                           uint32_t count, rti_scratch *scratch)
{
    const rtk_group *g = scene->groups; /* whose parts are of one builder */
    packet p;
    p.mesh.first = p.mesh.count = 0u;
    if (count >= PACKET_FEW && packet_plain(scene, scratch) && g->shape_count != 0u) { /* bounces off a sphere still go together */
        RTK_NAME(packets)(scene, rays, hits, occluded, count, scratch);
        return;
    }
    if (count < PACKET_FEW || !packet_plain(scene, scratch) || g->part_count == 0u || !lone_fits(g, g->parts)) {
        RTK_NAME(rays)(scene, rays, hits, occluded, count, scratch);
        return;
    }
    if (ORDER_PAYS(RTK_MODE)) {
        scratch->orders = scratch->orders && scratch->parts;
        for (rtk_u32 from = 0u; from < count; from += ORDER_MOST)
            RTK_NAME(lone_chunk)(&p, scene, rays, from, rtk_umin(count - from, ORDER_MOST), hits, occluded, scratch);
        return;
    }
    p.steps = 0u;
    p.spread = weave_large(&g->parts->RTK_TREE) && order_is_spread(rays, count, g->parts);
    for (rtk_u32 first = 0u; first < count; first += PACKET)
        RTK_NAME(packet_all)(&p, scene, rays, first, NULL, rays + first / RTK_BLOCK, rtk_umin(count - first, PACKET), hits, occluded,
                             scratch, 0);
}
