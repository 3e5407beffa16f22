/* Many rays through the top level together, for hot files: which of them come to which instance, so that these can go through its
 * group as a batch of their own (bvh_placed.inl).
 *
 * Lists of rays go through the top level's nodes as they go through a stream's: a node is opened once for all rays that come to
 * it, the slots wait with the lists of those that enter them, the nearest on top; where there is no room for lists, half of the
 * rays go on while the others wait. An instance gets the list of its leaf. Its rays are moved into the group's space as one ray
 * is (rtk_instance_ray), so whatever the group's tracer finds of them is what it would find of each by itself. They end at their
 * best hits so far, or just behind: equal hits are decided by the order of hits.
 */
#ifndef RTI_BVH_PLACED_H
#define RTI_BVH_PLACED_H

#include "bvh_moved.h"

#define PLACED       16384u /* rays at a time */
#define PLACED_LEAST 256u   /* rays that are worth it: fewer touch no memory for it */
#define PLACED_FEW   32u    /* rays that go through an instance singly */
#define PLACED_NEAR  2048u  /* coherent rays that go through one as coherent: fewer have hardly a leaf in common */
#define PLACED_PIECE 256u   /* rays for whose lists there is no room: so many or fewer go on by themselves, more by halves */
#define PLACED_LISTS (3u * PLACED)

/* A ray as it meets the top level's boxes. */
typedef struct placed_ray {
    float org[3], inv[3], t0, t1;
} placed_ray;

/* A slot of a node that waits, or the node itself (PLACED_NODE), and its rays. behind: where room begins when it has its turn. */
typedef struct placed_wait {
    rtk_u32 node, slot, begin, size, behind;
} placed_wait;
#define PLACED_NODE RTK_BVH_WIDTH

typedef struct placed {
    _Alignas(64) rtk_trace_block own[PLACED / RTK_BLOCK]; /* an instance's rays, */
    rtk_hit_block found[PLACED / RTK_BLOCK];              /* and their hits */
    placed_ray ray[PLACED];
    uint16_t list[PLACED_LISTS + 1u]; /* a ray is written before it is known to count */
    uint8_t bits[PLACED];
    placed_wait wait[2u * (RTK_BVH_STACK + RTK_BVH_WIDTH)];
    rtk_u32 top;
    const rtk_scene *scene;
    const rtk_trace_block *rays; /* of the batch those that are under way, PLACED at most */
    rtk_hit_block *hits;
    uint16_t *occluded;
    rti_scratch *scratch;
    int coherent;
} placed;

_Static_assert(sizeof(placed) <= RTI_TRACE_PLACED, "they fit into a room");
_Static_assert(PLACED <= 0x10000u && PLACED % RTK_BLOCK == 0u, "lists hold sixteen bits");

/* Instances with planes are in the way of every ray. */
RTI_VEC int placed_fits(const rtk_scene *scene, const rti_scratch *scratch, uint32_t count)
{
    return scene->instance_count != 0u && scene->unbounded_count == 0u && scratch->room && count >= PLACED_LEAST;
}

RTI_VEC int placed_done(const placed *a, rtk_u32 i)
{
    return a->occluded[i / RTK_BLOCK] >> i % RTK_BLOCK & 1;
}

/* Behind this no hit is looked for. */
RTI_VEC float placed_reach(const placed *a, rtk_u32 mode, rtk_u32 i)
{
    const float t1 = a->ray[i].t1;
    return mode & RTK_MODE_ANY ? t1 : rtk_min(t1, a->hits[i / RTK_BLOCK].t[i % RTK_BLOCK]);
}

/* The slots of a node that a ray enters, and where. */
RTI_VEC rtk_u32 placed_open(const placed_ray *r, const rtk_bvhnode *n, float reach, float t[RTK_BVH_WIDTH])
{
    bvh_ray v;
    v.ox = NODE(set)(r->org[0]);
    v.oy = NODE(set)(r->org[1]);
    v.oz = NODE(set)(r->org[2]);
    v.ix = NODE(set)(r->inv[0]);
    v.iy = NODE(set)(r->inv[1]);
    v.iz = NODE(set)(r->inv[2]);
    v.t0 = NODE(set)(r->t0);
    for (rtk_u32 k = 0u; k < 3u; k++)
        v.near[k] = (2u * k + (rtk_bits(r->inv[k]) >> 31)) * RTK_BVH_WIDTH;
    return bvh_open(n, &v, reach, t);
}

/* Where a ray enters a slot. */
RTI_VEC float placed_enter(const placed_ray *r, const rtk_bvhnode *n, rtk_u32 slot)
{
    float t = r->t0;
    for (rtk_u32 k = 0u; k < 3u; k++)
        t = rtk_max(t, (n->box[k][rtk_bits(r->inv[k]) >> 31][slot] - r->org[k]) * r->inv[k]);
    return t;
}

/* Of the rays that waited for a slot those that still want it, side by side. Returns how many. */
RTI_VEC rtk_u32 placed_still(placed *a, rtk_u32 mode, const placed_wait *w, const rtk_bvhnode *n)
{
    uint16_t *list = a->list + w->begin;
    rtk_u32 count = 0u;
    for (rtk_u32 k = 0u; k < w->size; k++) {
        const rtk_u32 i = list[k];
        list[count] = (uint16_t)i;
        if (mode & RTK_MODE_ANY)
            count += !placed_done(a, i);
        else
            count += placed_enter(&a->ray[i], n, w->slot) <= placed_reach(a, mode, i);
    }
    return count;
}

/* Behind this a ray that goes by itself looks for no hit. */
RTI_VEC float placed_reach_of(rtk_u32 mode, const placed_ray *r, const rtk_hit *best)
{
    return mode & RTK_MODE_ANY ? r->t1 : rtk_min(r->t1, best->t);
}

/* Opens the node w for its rays: its slots wait, the nearest on top. 0: there is no room for their lists. */
RTI_VEC int placed_node(placed *a, rtk_u32 mode, const rtk_bvhnode *nodes, const placed_wait *w)
{
    const rtk_bvhnode *n = &nodes[w->node];
    const uint16_t *list = a->list + w->begin;
    const rtk_u32 size = w->size;
    rtk_u32 count[RTK_BVH_WIDTH] = {0u}, slots[RTK_BVH_WIDTH], some = 0u, used = w->behind, all = 0u;
    float least[RTK_BVH_WIDTH];
    for (rtk_u32 s = 0u; s < RTK_BVH_WIDTH; s++)
        least[s] = RTK_INF;
    for (rtk_u32 k = 0u; k < size; k++) {
        float t[RTK_BVH_WIDTH];
        const rtk_u32 bits = (mode & RTK_MODE_ANY) && placed_done(a, list[k])
                                 ? 0u
                                 : placed_open(&a->ray[list[k]], n, placed_reach(a, mode, list[k]), t);
        a->bits[k] = (uint8_t)bits;
        for (rtk_u32 l = bits; l != 0u; l &= l - 1u) {
            const rtk_u32 s = (rtk_u32)__builtin_ctz(l);
            count[s]++;
            all++;
            least[s] = rtk_min(least[s], t[s]);
        }
    }
    if (all > PLACED_LISTS - used)
        return 0;
    for (rtk_u32 s = 0u; s < RTK_BVH_WIDTH; s++) {
        rtk_u32 to = some;
        if (count[s] == 0u)
            continue;
        for (; to > 0u && least[slots[to - 1u]] < least[s]; to--)
            slots[to] = slots[to - 1u];
        slots[to] = s;
        some++;
    }
    for (rtk_u32 i = 0u; i < some; i++) {
        const rtk_u32 s = slots[i];
        a->wait[a->top++] = (placed_wait){w->node, s, used, count[s], used + count[s]};
        for (rtk_u32 k = 0u; k < size; k++) {
            a->list[used] = list[k];
            used += a->bits[k] >> s & 1u;
        }
    }
    return 1;
}

/* Where ray i ends: at its best hit, or just behind. */
RTI_VEC float placed_end(const placed *a, rtk_u32 mode, rtk_u32 i, float tmax)
{
    const rtk_hit_block *h = mode & RTK_MODE_ANY ? NULL : &a->hits[i / RTK_BLOCK];
    return h && h->prim[i % RTK_BLOCK] != RTK_INVALID ? moved_above(h->t[i % RTK_BLOCK]) : tmax;
}

/* Rays of the lanes of a block into an instance's space: rtk_instance_ray. times: of each ray, where it moves (NULL: all are at
 * 0). */
RTI_VEC void placed_turn(rtk_trace_block *b, const rtk_scene *scene, const rtk_instance *inst, const float *times,
                         const uint16_t *list, rtk_u32 n)
{
    const float *m = inst->to_object.m;
    if (inst->flags & RTK_INST_MOVING) {
        for (rtk_u32 k = 0u; k < n; k++) {
            rtk_vec3 org = rtk_v3(b->ox[k], b->oy[k], b->oz[k]), dir = rtk_v3(b->dx[k], b->dy[k], b->dz[k]);
            rtk_instance_ray(scene->motions, inst, times ? times[list[k]] : 0.0f, &org, &dir);
            b->ox[k] = org.x;
            b->oy[k] = org.y;
            b->oz[k] = org.z;
            b->dx[k] = dir.x;
            b->dy[k] = dir.y;
            b->dz[k] = dir.z;
        }
        return;
    }
    for (rtk_u32 k = 0u; k < RTK_BLOCK; k += RTI_SIMD) {
        const vec x = V(load)(b->ox + k), y = V(load)(b->oy + k), z = V(load)(b->oz + k);
        const vec dx = V(load)(b->dx + k), dy = V(load)(b->dy + k), dz = V(load)(b->dz + k);
#define ROW(i) V(set)(m[i]) * x + V(set)(m[(i) + 1]) * y + V(set)(m[(i) + 2]) * z + V(set)(m[(i) + 3])
        V(store)(b->ox + k, ROW(0));
        V(store)(b->oy + k, ROW(4));
        V(store)(b->oz + k, ROW(8));
#undef ROW
#define ROW(i) V(set)(m[i]) * dx + V(set)(m[(i) + 1]) * dy + V(set)(m[(i) + 2]) * dz
        V(store)(b->dx + k, ROW(0));
        V(store)(b->dy + k, ROW(4));
        V(store)(b->dz + k, ROW(8));
#undef ROW
    }
}

/* n rays of a list become those that go through an instance. What is in lanes behind them is a ray, too. */
RTI_VEC void placed_move(placed *a, rtk_u32 mode, const rtk_instance *inst, const uint16_t *list, rtk_u32 n)
{
    for (rtk_u32 first = 0u; first < n; first += RTK_BLOCK) {
        rtk_trace_block *b = &a->own[first / RTK_BLOCK];
        const rtk_u32 some = rtk_umin(n - first, RTK_BLOCK);
        list += first ? RTK_BLOCK : 0u;
        if (some == RTK_BLOCK && list[0] % RTK_BLOCK == 0u && list[RTK_BLOCK - 1u] == list[0] + RTK_BLOCK - 1u) {
            *b = a->rays[list[0] / RTK_BLOCK]; /* lists keep their order */
        } else {
            for (rtk_u32 k = 0u; k < RTK_BLOCK; k++) {
                const rtk_u32 i = list[k < some ? k : 0u];
                const rtk_trace_block *from = &a->rays[i / RTK_BLOCK];
                b->ox[k] = from->ox[i % RTK_BLOCK];
                b->oy[k] = from->oy[i % RTK_BLOCK];
                b->oz[k] = from->oz[i % RTK_BLOCK];
                b->dx[k] = from->dx[i % RTK_BLOCK];
                b->dy[k] = from->dy[i % RTK_BLOCK];
                b->dz[k] = from->dz[i % RTK_BLOCK];
                b->tmin[k] = from->tmin[i % RTK_BLOCK];
                b->tmax[k] = from->tmax[i % RTK_BLOCK];
                b->mask[k] = from->mask[i % RTK_BLOCK];
            }
        }
        for (rtk_u32 k = 0u; k < some; k++) {
            b->tmax[k] = placed_end(a, mode, list[k], b->tmax[k]);
            b->mask[k] &= inst->mask;
        }
        placed_turn(b, a->scene, inst, a->scratch->times, list, some);
    }
}

/* A hit of ray i is taken if it comes before its best one. */
RTI_VEC void placed_take(placed *a, rtk_u32 i, rtk_hit hit)
{
    const rtk_hit best = rti_lane_best(a->hits, i);
    if (hit.prim != RTK_INVALID && rtk_hit_less(hit.t, hit.inst, hit.geom, hit.prim, best.t, best.inst, best.geom, best.prim))
        rti_lane_keep(a->hits, i, hit);
}

/* What the group's tracer has found of an instance's rays. */
RTI_VEC void placed_merge(placed *a, rtk_u32 mode, const rtk_instance *inst, const uint16_t *list, rtk_u32 n)
{
    const uint16_t *any = (const uint16_t *)(const void *)a->found;
    for (rtk_u32 k = 0u; k < n; k++) {
        const rtk_u32 i = list[k];
        if (mode & RTK_MODE_ANY) {
            a->occluded[i / RTK_BLOCK] |= (uint16_t)((any[k / RTK_BLOCK] >> k % RTK_BLOCK & 1u) << i % RTK_BLOCK);
        } else {
            rtk_hit hit = rti_lane_best(a->found, k);
            hit.inst = inst->id;
            placed_take(a, i, hit);
        }
    }
}

/* RTI_SIMD rays from ray `first` on, those of `count` that are not done, made ready for the top level. Returns those that enter
 * it; far: those that start far away from it. */
RTI_VEC rtk_u32 placed_load(placed *a, rtk_u32 mode, rtk_u32 first, rtk_u32 count, rtk_u32 *far)
{
    const rtk_scene *s = a->scene;
    const rtk_part top = {.lo = s->top_lo, .hi = s->top_hi, .scale = s->top_scale};
    const rtk_u32 k = first % RTK_BLOCK;
    packet_rays r;
    vec t0, t1;
    rtk_u32 lanes;
    packet_rays_load(&r, &a->rays[first / RTK_BLOCK], k);
    lanes = r.valid;
    if (count - first < RTI_SIMD)
        lanes &= (1u << (count - first)) - 1u;
    if (mode & RTK_MODE_ANY)
        lanes &= ~((rtk_u32)a->occluded[first / RTK_BLOCK] >> k);
    lanes = packet_rays_enter(r.org, r.inv, r.tmin, r.tmax, lanes, &top, &t0, &t1, far);
    const vec fields[8] = {r.org[0], r.org[1], r.org[2], r.inv[0], r.inv[1], r.inv[2], t0, t1};
#ifdef RTI_PACK8
    V(spread)(fields, a->ray[first].org, lane_eights);
#else
    float rows[8][RTI_SIMD];
    for (rtk_u32 f = 0u; f < 8u; f++)
        V(store)(rows[f], fields[f]);
    for (rtk_u32 l = 0u; l < RTI_SIMD; l++)
        a->ray[first + l] =
            (placed_ray){{rows[0][l], rows[1][l], rows[2][l]}, {rows[3][l], rows[4][l], rows[5][l]}, rows[6][l], rows[7][l]};
#endif
    return lanes;
}
_Static_assert(sizeof(placed_ray) == 8u * sizeof(float), "a ray is eight fields in a row");

/* A scene of one group and nothing else. */
RTI_VEC rtk_scene placed_scene(const rtk_scene *scene, rtk_u32 group)
{
    rtk_scene s = *scene;
    s.groups = &scene->groups[group];
    s.group_count = 1u;
    s.instance_count = 0u;
    s.top_lo.x = RTK_INF;
    s.top_hi.x = -RTK_INF;
    return s;
}

#endif
