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

/* The rest of the walk for one lane: the subtree at `at` from t0 to t1. */
static void RTK_NAME(lane_walk)(kd_packet *p, uint32_t lane, uint32_t at, float t0, float t1)
{
    rtk_query q;
    kd_packet_query(p, lane, &q);
    const rtk_pray *r = kd_packet_ray(p, lane, q.ray);
    if (r)
        kd_packet_answer(p, lane, &q, RTK_NAME(group_walk_from)(&q, p->part->kdtree, r, 0.0f, at, t0, t1));
}

/* The whole part for one lane, whose origin is moved. */
static void RTK_NAME(lane_part)(kd_packet *p, uint32_t lane)
{
    rtk_query q;
    kd_packet_query(p, lane, &q);
    const rtk_pray *r = kd_packet_ray(p, lane, q.ray);
    if (r)
        kd_packet_answer(p, lane, &q, RTK_NAME(group_walk)(&q, p->part->kdtree, p->part->count, r, 0.0f));
}

/* A triangle of a leaf for `lanes`. */
static inline void RTK_NAME(packet_tri)(kd_packet *p, uint32_t ref, uint32_t lanes)
{
    const rtk_group *g = p->scene->groups;
    const rtk_tri *tri = &g->tris[ref];
    const rtk_geom *geom = &g->geoms[tri->geom];
    tri_hit h;
    if (kd_packet_tri(p, RTK_MODE, tri, lanes, !(geom->flags & RTK_GEOM_ALPHA), &h) == 0)
        return;
    uint32_t hit = h.hit, rough = h.doubt;
    if (geom->flags & RTK_GEOM_ALPHA) {
        rough |= hit;
    } else {
        for (uint32_t i = 0; i < RTI_SIMD && geom->mask != 0xffffffffu; i++)
            hit &= ~((p->masks[i] & geom->mask ? 0u : 1u) << i);
        if (RTK_MODE & RTK_MODE_ANY) {
            p->done |= hit;
        } else {
            uint32_t same = hit & VM(bits)(V(eq)(h.t, p->t));
            for (; same; same &= same - 1) { /* met in another leaf, or the order of hits decides */
                uint32_t i = (uint32_t)__builtin_ctz(same);
                if (rtk_bits(p->prim[i]) != tri->prim || rtk_bits(p->geom[i]) != tri->geom)
                    rough |= 1u << i;
            }
            const vmask take = VM(of)(hit & VM(bits)(V(lt)(h.t, p->t)));
            p->t = V(select)(take, h.t, p->t);
            p->u = V(select)(take, h.u, p->u);
            p->v = V(select)(take, h.v, p->v);
            p->prim = V(select)(take, V(set)(rtk_float(tri->prim)), p->prim);
            p->geom = V(select)(take, V(set)(rtk_float(tri->geom)), p->geom);
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
static void RTK_NAME(packet_walk)(kd_packet *p, uint32_t lanes)
{
    kd_waiting stack[RTK_KD_STACK];
    const rtk_kdnode *kd = p->part->kdtree.kd;
    vec t0 = p->t0, t1 = p->t1;
    uint32_t at = 0, top = 0, first = (uint32_t)__builtin_ctz(lanes);
    uint32_t high[3] = {p->r.back[0] >> first & 1u, p->r.back[1] >> first & 1u, p->r.back[2] >> first & 1u};
    for (;;) {
        if (!(RTK_MODE & RTK_MODE_ANY))
            lanes &= ~VM(bits)(V(lt)(p->t, t0));
        else
            lanes &= ~p->done;
        if (lanes && (lanes & (lanes - 1)) == 0) { /* come apart */
            uint32_t lane = (uint32_t)__builtin_ctz(lanes);
            RTK_NAME(lane_walk)(p, lane, at, t0[lane], t1[lane]);
            lanes = 0;
        }
        if (lanes) {
            rtk_kdnode n = kd[at];
            while ((n.b & 3u) != RTK_KD_LEAF) {
                uint32_t axis = n.b & 3u, near = (n.b >> 2) + high[axis], far = (n.b >> 2) + (1u - high[axis]);
                vec t = (V(set)(rtk_float(n.a)) - p->r.org[axis]) * p->r.inv[axis];
                vmask beyond = V(lt)(t, t1), before = V(le)(t, t0);
                uint32_t to_far = VM(bits)(beyond) & lanes, to_near = lanes & ~(to_far & VM(bits)(before));
                at = to_near ? near : far;
                if (to_far && to_near) {
                    kd_waiting *w = &stack[top++];
                    w->t0 = V(select)(before, t0, t);
                    w->t1 = t1;
                    w->node = far;
                    w->lanes = to_far;
                    t1 = V(select)(beyond, t, t1);
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
    uint32_t far, rest = kd_packet_prepare(p, part, &far);
    while (rest) {
        uint32_t group = kd_packet_together(p, rest);
        RTK_NAME(packet_walk)(p, group);
        rest &= ~group;
    }
    for (; far; far &= far - 1)
        RTK_NAME(lane_part)(p, (uint32_t)__builtin_ctz(far));
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
            h->prim[lane] = rtk_bits(p->prim[i]);
            h->geom[lane] = rtk_bits(p->geom[i]);
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
    for (uint32_t first = 0; first < count; first += RTI_SIMD) {
        uint32_t n = count - first < RTI_SIMD ? count - first : RTI_SIMD;
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
