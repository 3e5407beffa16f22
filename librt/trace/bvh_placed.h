/* Many rays through the top level together, for hot files: which of them come to which instance, so that these can go through its
 * group as a batch of their own (bvh_placed.inl).
 *
 * Lists of rays go through the top level's nodes as they go through a stream's: a node is opened once for all rays that come to
 * it, the slots wait with the lists of those that enter them, the nearest on top. An instance gets the list of its leaf. Its rays
 * are moved into the group's space as one ray is (rtk_instance_ray), so whatever the group's tracer finds of them is what it
 * would find of each by itself. They end at their best hits so far, or just behind: equal hits are decided by the order of hits.
 */
#ifndef RTI_BVH_PLACED_H
#define RTI_BVH_PLACED_H

#include "bvh_packet.h"

#define PLACED       16384u /* rays at a time */
#define PLACED_FEW   16u    /* rays that go through an instance singly */
#define PLACED_NEAR  512u   /* coherent rays that go through one as coherent: fewer have hardly a leaf in common */
#define PLACED_LISTS (3u * PLACED)

/* A ray as it meets the top level's boxes. */
typedef struct placed_ray {
    float org[3], inv[3], t0, t1;
} placed_ray;

/* A slot of a node that waits, and its rays. */
typedef struct placed_wait {
    rtk_u32 node, slot, begin, size;
} placed_wait;

typedef struct placed {
    _Alignas(64) rtk_trace_block own[PLACED / RTK_BLOCK]; /* an instance's rays, */
    rtk_hit_block found[PLACED / RTK_BLOCK];              /* and their hits */
    placed_ray ray[PLACED];
    uint16_t list[PLACED_LISTS];
    uint8_t bits[PLACED];
    placed_wait wait[RTK_BVH_STACK + RTK_BVH_WIDTH];
    rtk_u32 top;
    const rtk_scene *scene;
    const rtk_trace_block *rays; /* of these, from `first` on */
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
    return scene->instance_count != 0u && scene->unbounded_count == 0u && scratch->room && count >= PLACED_FEW;
}

RTI_VEC int placed_done(const placed *a, rtk_u32 i)
{
    return a->occluded[i / RTK_BLOCK] >> i % RTK_BLOCK & 1;
}

RTI_VEC rtk_ray placed_given(const placed *a, rtk_u32 i)
{
    const rtk_trace_block *b = &a->rays[i / RTK_BLOCK];
    const rtk_u32 k = i % RTK_BLOCK;
    rtk_ray r;
    r.org = rtk_v3(b->ox[k], b->oy[k], b->oz[k]);
    r.dir = rtk_v3(b->dx[k], b->dy[k], b->dz[k]);
    r.tmin = b->tmin[k];
    r.tmax = b->tmax[k];
    r.mask = b->mask[k];
    return r;
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

/* Opens a node for the rays list[begin, begin + size): its slots wait, the nearest on top. 0: there is no room for their lists.
 */
RTI_VEC int placed_node(placed *a, rtk_u32 mode, const rtk_bvhnode *nodes, rtk_u32 at, rtk_u32 begin, rtk_u32 size)
{
    const rtk_bvhnode *n = &nodes[at];
    const uint16_t *list = a->list + begin;
    rtk_u32 count[RTK_BVH_WIDTH] = {0u}, slots[RTK_BVH_WIDTH], some = 0u, used = begin + size, all = 0u;
    float least[RTK_BVH_WIDTH];
    for (rtk_u32 s = 0u; s < RTK_BVH_WIDTH; s++)
        least[s] = RTK_INF;
    for (rtk_u32 k = 0u; k < size; k++) {
        float t[RTK_BVH_WIDTH];
        const rtk_u32 bits = placed_open(&a->ray[list[k]], n, placed_reach(a, mode, list[k]), t);
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
        a->wait[a->top++] = (placed_wait){at, s, used, count[s]};
        for (rtk_u32 k = 0u; k < size; k++) {
            a->list[used] = list[k];
            used += a->bits[k] >> s & 1u;
        }
    }
    return 1;
}

/* The float above t. */
RTI_VEC float placed_above(float t)
{
    const rtk_u32 b = rtk_bits(t);
    return t == 0.0f ? rtk_float(1u) : rtk_float(t > 0.0f ? b + 1u : b - 1u);
}

/* Ray i becomes ray k of those that go through an instance. */
RTI_VEC void placed_move(placed *a, rtk_u32 mode, const rtk_instance *inst, rtk_u32 i, rtk_u32 k)
{
    rtk_trace_block *b = &a->own[k / RTK_BLOCK];
    const rtk_ray r = placed_given(a, i);
    rtk_vec3 org = r.org, dir = r.dir;
    float end = r.tmax;
    rtk_instance_ray(a->scene->motions, inst, a->scratch->times ? a->scratch->times[i] : 0.0f, &org, &dir);
    if (!(mode & RTK_MODE_ANY) && a->hits[i / RTK_BLOCK].prim[i % RTK_BLOCK] != RTK_INVALID)
        end = placed_above(a->hits[i / RTK_BLOCK].t[i % RTK_BLOCK]);
    k %= RTK_BLOCK;
    b->ox[k] = org.x;
    b->oy[k] = org.y;
    b->oz[k] = org.z;
    b->dx[k] = dir.x;
    b->dy[k] = dir.y;
    b->dz[k] = dir.z;
    b->tmin[k] = r.tmin;
    b->tmax[k] = end;
    b->mask[k] = r.mask & inst->mask;
}

/* A hit of ray i is taken if it comes before its best one. */
RTI_VEC void placed_take(placed *a, rtk_u32 i, rtk_hit hit)
{
    rtk_hit_block *h = &a->hits[i / RTK_BLOCK];
    const rtk_u32 k = i % RTK_BLOCK;
    if (hit.prim == RTK_INVALID ||
        !rtk_hit_less(hit.t, hit.inst, hit.geom, hit.prim, h->t[k], h->inst[k], h->geom[k], h->prim[k]))
        return;
    h->t[k] = hit.t;
    h->u[k] = hit.u;
    h->v[k] = hit.v;
    h->prim[k] = hit.prim;
    h->geom[k] = hit.geom;
    h->inst[k] = hit.inst;
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
            const rtk_hit_block *f = &a->found[k / RTK_BLOCK];
            const rtk_u32 l = k % RTK_BLOCK;
            placed_take(a, i, (rtk_hit){f->t[l], f->u[l], f->v[l], f->prim[l], f->geom[l], inst->id});
        }
    }
}

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
