/* One mode of the kd-tree's packets: closest and any hit of coherent rays. Included by modes.inl, behind single.inl.
 *
 * Source: Wald, Slusallek, Benthin, Wagner 2001 (packets over a kd-tree); Wald 2004. What differs: rays are parted by octant and
 * dominant axis first, so that near and far are those of all; each lane keeps its own interval; and the rays of a packet that has
 * come apart go on one by one.
 */

/* Reference `ref` for one lane. */
static void RTK_NAME(lane_prim)(kd_packet *p, uint32_t lane, uint32_t ref)
{
    rtk_query q;
    kd_packet_query(p, lane, &q);
    const rtk_pray *r = kd_packet_ray(p, lane, q.ray);
    if (r)
        kd_packet_answer(p, lane, &q, rtk_query_prim(&q, RTK_MODE, r, ref));
}

/* The subtree at `at` from t0 to t1 for one lane, as kd_stack.inl walks it; far_off: the whole tree, for a ray whose origin is
 * moved. */
static void RTK_NAME(lane_walk)(kd_packet *p, uint32_t lane, uint32_t at, float t0, float t1, bool far_off)
{
    rtk_u32 stack_node[RTK_KD_STACK], back[3], top = 0;
    float stack_t1[RTK_KD_STACK];
    const rtk_tree *tree = &p->part->kdtree;
    rtk_query q;
    kd_packet_query(p, lane, &q);
    const rtk_pray *r = kd_packet_ray(p, lane, q.ray);
    int hit = 0;
    if (!r)
        return;
    const float org[3] = {r->org.x, r->org.y, r->org.z}, inv[3] = {r->inv.x, r->inv.y, r->inv.z};
    if (far_off) {
        t0 = r->t0;
        t1 = r->t1;
    }
    for (uint32_t a = 0; a < 3; a++)
        back[a] = rtk_bits(inv[a]) >> 31;
    while (!rtk_query_done(&q, RTK_MODE, r, 0.0f, t0)) {
        rtk_kdnode n = tree->kd[at];
        while ((n.b & 3u) != RTK_KD_LEAF) {
            rtk_u32 axis = n.b & 3u, child = n.b >> 2;
            float t = (rtk_float(n.a) - org[axis]) * inv[axis];
            at = child + back[axis];
            if (t < t1) {
                rtk_u32 far = child + (1u - back[axis]);
                if (t <= t0) {
                    at = far;
                } else {
                    stack_node[top] = far;
                    stack_t1[top++] = t1;
                    t1 = t;
                }
            }
            n = tree->kd[at];
        }
        for (uint32_t i = 0; i < n.b >> 2 && !hit; i++)
            hit = rtk_query_prim(&q, RTK_MODE, r, tree->refs[n.a + i]);
        if (hit || top == 0)
            break;
        top--;
        t0 = t1;
        t1 = stack_t1[top];
        at = stack_node[top];
    }
    kd_packet_answer(p, lane, &q, hit);
}

/* A triangle of a leaf for `lanes`. */
static inline void RTK_NAME(packet_tri)(kd_packet *p, uint32_t ref, uint32_t lanes)
{
    const rtk_group *g = p->scene->groups;
    const rtk_tri *tri = &g->tris[ref];
    const rtk_geom *geom = &g->geoms[tri->geom];
    rti_vf t, u, v;
    uint32_t rough, hit = kd_packet_tri(p, tri, lanes, &t, &u, &v, &rough);
    if (!(hit | rough))
        return;
    if (geom->flags & RTK_GEOM_ALPHA) {
        rough |= hit;
    } else {
        hit &= ~rti_bits(rti_same(p->mask & (int32_t)geom->mask, (rti_vi){0}));
        if (RTK_MODE & RTK_MODE_ANY) {
            p->done |= hit;
        } else {
            rti_vi prim = (rti_vi){0} + (int32_t)tri->prim, at = (rti_vi){0} + (int32_t)tri->geom;
            uint32_t met = rti_bits((rti_vm)(rti_same(p->prim, prim) & rti_same(p->geom, at))); /* in another leaf */
            rti_vm take = rti_mask(hit & rti_bits(rti_lt(t, p->t)));
            rough |= hit & rti_bits(rti_eq(t, p->t)) & ~met;
            p->t = rti_pick(take, t, p->t);
            p->u = rti_pick(take, u, p->u);
            p->v = rti_pick(take, v, p->v);
            p->prim = rti_pick_int(take, prim, p->prim);
            p->geom = rti_pick_int(take, at, p->geom);
        }
    }
    if (RTK_MODE & RTK_MODE_ANY)
        rough &= ~p->done;
    if (rough)
        rough = kd_packet_untried(p, ref, rough);
    for (; rough; rough &= rough - 1)
        RTK_NAME(lane_prim)(p, (uint32_t)__builtin_ctz(rough), ref);
}

static inline void RTK_NAME(packet_leaf)(kd_packet *p, rtk_kdnode leaf, uint32_t lanes)
{
    const rtk_u32 *refs = p->part->kdtree.refs + leaf.a;
    uint32_t tris = p->scene->groups->tri_count;
    for (uint32_t i = 0; i < leaf.b >> 2 && lanes; i++) {
        if (refs[i] < tris)
            RTK_NAME(packet_tri)(p, refs[i], lanes);
        else
            for (uint32_t rest = lanes; rest; rest &= rest - 1)
                RTK_NAME(lane_prim)(p, (uint32_t)__builtin_ctz(rest), refs[i]);
        if (RTK_MODE & RTK_MODE_ANY)
            lanes &= ~p->done;
    }
}

/* Rays of one octant through the part. */
static void RTK_NAME(packet_walk)(kd_packet *p, const uint32_t back[3], uint32_t lanes)
{
    kd_waiting stack[RTK_KD_STACK];
    const rtk_kdnode *kd = p->part->kdtree.kd;
    rti_vf t0 = p->t0, t1 = p->t1;
    uint32_t at = 0, top = 0, first = (uint32_t)__builtin_ctz(lanes);
    uint32_t high[3] = {back[0] >> first & 1u, back[1] >> first & 1u, back[2] >> first & 1u};
    for (;;) {
        if (!(RTK_MODE & RTK_MODE_ANY))
            lanes &= ~rti_bits(rti_lt(p->t, t0));
        else
            lanes &= ~p->done;
        if (lanes && (lanes & (lanes - 1)) == 0) { /* come apart */
            uint32_t lane = (uint32_t)__builtin_ctz(lanes);
            RTK_NAME(lane_walk)(p, lane, at, t0[lane], t1[lane], false);
            lanes = 0;
        }
        if (lanes) {
            rtk_kdnode n = kd[at];
            while ((n.b & 3u) != RTK_KD_LEAF) {
                uint32_t axis = n.b & 3u, near = (n.b >> 2) + high[axis], far = (n.b >> 2) + (1u - high[axis]);
                rti_vf t = (rtk_float(n.a) - p->org[axis]) * p->inv[axis];
                rti_vm beyond = rti_lt(t, t1), before = rti_le(t, t0);
                uint32_t to_far = rti_bits(beyond) & lanes, to_near = lanes & ~(to_far & rti_bits(before));
                at = to_near ? near : far;
                if (to_far && to_near) {
                    kd_waiting *w = &stack[top++];
                    w->t0 = rti_pick(before, t0, t);
                    w->t1 = t1;
                    w->node = far;
                    w->lanes = to_far;
                    t1 = rti_pick(beyond, t, t1);
                    lanes = to_near;
                }
                n = kd[at];
            }
            RTK_NAME(packet_leaf)(p, n, lanes);
        }
        if (top == 0)
            break;
        top--;
        t0 = stack[top].t0;
        t1 = stack[top].t1;
        at = stack[top].node;
        lanes = stack[top].lanes;
    }
}

static void RTK_NAME(packet_part)(kd_packet *p, const rtk_part *part)
{
    uint32_t far, rest = kd_packet_prepare(p, part, &far), axes[3], back[3];
    for (int a = 0; a < 3; a++)
        back[a] = rti_bits((rti_vm)rti_lt(p->inv[a], rti_vf_all(0.0f)));
    kd_packet_axes(p, axes);
    while (rest) {
        uint32_t group = kd_packet_together(p, axes, back, rest);
        RTK_NAME(packet_walk)(p, back, group);
        rest &= ~group;
    }
    for (; far; far &= far - 1)
        RTK_NAME(lane_walk)(p, (uint32_t)__builtin_ctz(far), 0, 0.0f, 0.0f, true);
}

/* Planes before everything else, instances behind it: a ray at a time. */
static void RTK_NAME(packet_planes)(kd_packet *p)
{
    for (uint32_t rest = p->live; rest; rest &= rest - 1) {
        uint32_t lane = (uint32_t)__builtin_ctz(rest);
        rtk_query q;
        kd_packet_query(p, lane, &q);
        kd_packet_answer(p, lane, &q, rtk_query_planes(&q, RTK_MODE, q.ray));
    }
}

static void RTK_NAME(packet_finish)(kd_packet *p, rtk_hit_block *hits, uint32_t count)
{
    rtk_hit_block *h = hits ? &hits[p->first / RTK_BLOCK] : NULL;
    const rtk_scene *s = p->scene;
    bool instances = s->instance_count + s->unbounded_count > 0;
    if (!instances && s->groups->shape_count + s->groups->plane_count == 0) {
        for (uint32_t i = 0; i < count && h; i++) {
            uint32_t lane = (p->first + i) % RTK_BLOCK;
            h->t[lane] = p->t[i];
            h->u[lane] = p->u[i];
            h->v[lane] = p->v[i];
            h->prim[lane] = (rtk_u32)p->prim[i];
            h->geom[lane] = (rtk_u32)p->geom[i];
            h->inst[lane] = RTK_INVALID;
        }
        return;
    }
    for (uint32_t i = 0; i < count; i++) {
        rtk_query q;
        kd_packet_query(p, i, &q);
        if (instances && (p->live & ~p->done) >> i & 1u)
            p->done |= (RTK_NAME(instances)(&q) ? 1u : 0u) << i;
        if (h)
            rti_lane_hit(&q, hits, p->first + i);
    }
}

static void RTK_NAME(packets)(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits, uint16_t *occluded,
                              uint32_t count, rti_scratch *scratch)
{
    const rtk_group *g = scene->groups;
    for (uint32_t first = 0; first < count; first += RTI_LANES) {
        uint32_t n = count - first < RTI_LANES ? count - first : RTI_LANES;
        kd_packet p;
        kd_packet_load(&p, scene, rays, first, n, scratch);
        if (g->plane_count > 0)
            RTK_NAME(packet_planes)(&p);
        for (uint32_t i = 0; i < g->part_count; i++) {
            p.live &= ~p.done;
            RTK_NAME(packet_part)(&p, &g->parts[i]);
        }
        RTK_NAME(packet_finish)(&p, hits, n);
        for (uint32_t i = 0; i < n && (RTK_MODE & RTK_MODE_ANY); i++)
            rti_lane_occluded(occluded, first + i, (int)(p.done >> i & 1u));
    }
}
