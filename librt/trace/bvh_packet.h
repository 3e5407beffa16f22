/* Rays of a tile through eight-wide nodes together, for hot files.
 *
 * Up to PACKET rays that point into one octant, with one dominant axis (where triangles in blocks ask for it), go as a packet.
 * Inner nodes are asked once for all of them, by intervals: over the rays, org lies in [lo, hi] and inv in [lo, hi], and because
 * float subtraction and multiplication are monotone, the smallest of the rays' (plane - org) * inv is no less than the one taken
 * from the intervals' ends. So what this leaves out every ray would leave out, with no margin. Of a leaf's triangles those are
 * left out whose boxes miss the intervals; then the rays are asked, first for the leaf's box and then for each triangle, RTI_SIMD
 * at a time, or where few enter it four rays and four triangles at a time. (Boulos, Wald, Benthin 2008; Overbeck, Ramamoorthi,
 * Mark 2008. What differs: no ray is looked at above the leaves.) A packet that opens too many nodes for its rays has come apart:
 * they go on as single rays.
 */
#ifndef RTI_BVH_PACKET_H
#define RTI_BVH_PACKET_H

#include "bvh_lone_one.h"
#include "packet.h"

#define PACKET       64u
#define PACKET_FEW   8u /* rays that go singly */
#define PACKET_NODES 6u /* nodes a ray that a packet may open before it has come apart */

/* What is known of the rays [0, PACKET) of a packet; a lane that is in none of its masks holds anything. */
typedef struct packet {
    _Alignas(64) float org[3][PACKET];
    float inv[3][PACKET], dir[3][PACKET], tmin[PACKET], tmax[PACKET];
    float t0[PACKET], t1[PACKET], sx[PACKET], sy[PACKET]; /* of the part at hand */
    float t[PACKET], u[PACKET], v[PACKET];                /* the best hits; t is tmax without one */
    float prim[PACKET], geom[PACKET];                     /* of those, as bits */
    rtk_u32 mask[PACKET];
    uint64_t done;                   /* any hit: nothing is asked any more */
    rtk_u32 axis[PACKET];            /* dominant axis in the lowest two bits, octant in the next three */
    float kind[PACKET], key[PACKET]; /* dominant axis, and all of axis, as numbers */
    rtk_u32 common, masked;          /* the rays' mask; != 0: they have several */
    /* Where each hit counts (plain), whose the best hit is, is asked when the walk ends: a triangle's reference and record are
     * seldom in the nearer caches. late: of each lane, as bits, the place in refs, or RTK_INVALID: prim and geom tell. */
    rtk_u32 plain;
    struct {
        rtk_u32 geom, first, count;
    } mesh; /* the one that was met last: its triangles are those from `first` on */
    _Alignas(64) float late[PACKET];
    /* Of the rays that walk. */
    uint64_t rays;
    float near_org[3], far_org[3], inv_lo[3], inv_hi[3], from, reach;
    rtk_u32 near[3], kx, ky, kz;
    rtk_u32 one; /* of closest hits: all rays start at one point */
    /* Of a batch: packets that walked, rays of them, and nodes that they opened and leaves that they looked through. */
    rtk_u32 walks, walked, steps;
    const rtk_scene *scene;
    const rtk_trace_block *blocks;
    rtk_u32 first;
    const rti_scratch *scratch;
    /* Of the part at hand: rays that were prepared by themselves, too, as they were asked for one by one. */
    uint64_t ready, missed; /* missed: those of them that miss the part */
    rtk_pray prays[PACKET];
} packet;

/* Before the first of a batch. */
RTI_VEC void packet_batch(packet *p)
{
    p->mesh.first = p->mesh.count = 0u;
    p->walks = p->walked = p->steps = 0u;
}

RTI_VEC rtk_u32 packet_bits(uint64_t mask, rtk_u32 at)
{
    return (rtk_u32)(mask >> at) & LANES_ALL;
}

/* The number of a lane's ray. */
RTI_VEC rtk_u32 packet_number(const packet *p, rtk_u32 lane)
{
    return p->first + lane;
}

/* Of RTI_SIMD rays the order of axes, and that and the octant. */
RTI_VEC void packet_rays_key(const packet_rays *r, vec *kind, vec *key)
{
    const vec zero = V(set)(0.0f), third = V(select)(VM(of)(r->axes[2]), V(set)(2.0f), zero);
    *kind = V(select)(VM(of)(r->axes[1]), V(set)(1.0f), third);
    *key = *kind;
    for (rtk_u32 i = 0u; i < 3u; i++)
        *key = *key + V(select)(VM(of)(r->back[i]), V(set)((float)(4u << i)), zero);
}
RTI_VEC void packet_key(packet *p, const packet_rays *r, rtk_u32 at)
{
    vec kind, key;
    packet_rays_key(r, &kind, &key);
    const vec_whole axis = __builtin_convertvector(key, vec_whole);
    V(store)(p->kind + at, kind);
    V(store)(p->key + at, key);
    memcpy(p->axis + at, &axis, sizeof axis);
}

/* Whether some of the lanes' masks are not `common`. */
RTI_VEC rtk_u32 packet_differ(const rtk_u32 *mask, rtk_u32 lanes, rtk_u32 common)
{
    rtk_u32 differ = 0u;
    if (lanes == LANES_ALL) {
        for (rtk_u32 i = 0u; i < RTI_SIMD; i++)
            differ |= mask[i] ^ common;
        return differ;
    }
    for (rtk_u32 i = 0u; i < RTI_SIMD; i++)
        differ |= lanes >> i & 1u ? mask[i] ^ common : 0u;
    return differ;
}

/* Loads the rays [first, first + n); returns those that are valid. */
RTI_VEC uint64_t packet_load(packet *p, const rtk_scene *scene, const rtk_trace_block *blocks, rtk_u32 first, rtk_u32 n,
                             const rti_scratch *scratch)
{
    const rtk_trace_block *rays = blocks + first / RTK_BLOCK;
    uint64_t valid = 0u;
    p->scene = scene;
    p->blocks = blocks;
    p->first = first;
    p->scratch = scratch;
    p->done = 0u;
    p->masked = 0u;
    p->common = rays[0].mask[0];
    if (n < PACKET) {
        memset(p->axis, 0, sizeof p->axis);
        memset(p->kind, 0, sizeof p->kind);
        memset(p->key, 0, sizeof p->key);
    }
    for (rtk_u32 at = 0u; at < PACKET && at < n; at += RTI_SIMD) {
        const rtk_trace_block *b = &rays[at / RTK_BLOCK];
        rtk_u32 k = at % RTK_BLOCK, ok;
        packet_rays r;
        packet_rays_load(&r, b, k);
        for (rtk_u32 i = 0u; i < 3u; i++) {
            V(store)(p->inv[i] + at, r.inv[i]);
            V(store)(p->dir[i] + at, r.dir[i]);
            V(store)(p->org[i] + at, r.org[i]);
        }
        ok = r.valid;
        V(store)(p->tmin + at, r.tmin);
        V(store)(p->tmax + at, r.tmax);
        V(store)(p->t + at, r.tmax);
        V(store)(p->u + at, V(set)(0.0f));
        V(store)(p->v + at, V(set)(0.0f));
        V(store)(p->prim + at, V(set)(rtk_float(RTK_INVALID)));
        V(store)(p->geom + at, V(set)(rtk_float(RTK_INVALID)));
        packet_key(p, &r, at);
        memcpy(p->mask + at, b->mask + k, RTI_SIMD * sizeof *p->mask);
        if (n - at < RTI_SIMD)
            ok &= (1u << (n - at)) - 1u;
        p->masked |= packet_differ(b->mask + k, ok, p->common);
        valid |= (uint64_t)ok << at;
    }
    return valid;
}

/* Asks for the rays of the packet that begins with ray `first`, of `count`, if there is one. */
RTI_VEC void packet_expect_rays(const rtk_trace_block *rays, rtk_u32 first, rtk_u32 count)
{
    if (first >= count)
        return;
    const rtk_u32 blocks = (rtk_umin(count - first, PACKET) + RTK_BLOCK - 1u) / RTK_BLOCK;
    const char *at = (const char *)(rays + first / RTK_BLOCK);
    for (rtk_u32 i = 0u; i < blocks * sizeof *rays; i += 64u)
        __builtin_prefetch(at + i);
}

/* The rays prepared for a part (rtk_ray_prepare): returns those that meet it; far: those that start too far away for this. */
RTI_VEC uint64_t packet_prepare(packet *p, const rtk_part *part, uint64_t rays, uint64_t *far)
{
    uint64_t meet = 0u;
    *far = 0u;
    p->ready = 0u;
    for (rtk_u32 at = 0u; at < PACKET; at += RTI_SIMD) {
        rtk_u32 want = packet_bits(rays, at), out;
        vec org[3], inv[3], t0, t1;
        if (want == 0u)
            continue;
        for (rtk_u32 i = 0u; i < 3u; i++) {
            org[i] = V(load)(p->org[i] + at);
            inv[i] = V(load)(p->inv[i] + at);
        }
        meet |= (uint64_t)packet_rays_enter(org, inv, V(load)(p->tmin + at), V(load)(p->tmax + at), want, part, &t0, &t1, &out)
                << at;
        *far |= (uint64_t)out << at;
        V(store)(p->t0 + at, t0);
        V(store)(p->t1 + at, t1);
    }
    return meet;
}

RTI_VEC float packet_low(vec a)
{
#if RTI_SIMD >= 16 && defined RTI_PACK
    return rti_f16_low(a);
#else
    float x[RTI_SIMD], m;
    V(store)(x, a);
    m = x[0];
    for (rtk_u32 i = 1u; i < RTI_SIMD; i++)
        m = rtk_min(x[i], m);
    return m;
#endif
}
RTI_VEC float packet_high(vec a)
{
    return -packet_low(-a);
}

/* No ray may enter a box behind this. */
RTI_VEC void packet_reach(packet *p)
{
    vec m = V(set)(-RTK_INF);
    for (rtk_u32 at = 0u; at < PACKET; at += RTI_SIMD) {
        rtk_u32 l = packet_bits(p->rays, at);
        if (l)
            m = V(max)(m, V(select)(VM(of)(l), V(min)(V(load)(p->t1 + at), V(load)(p->t + at)), V(set)(-RTK_INF)));
    }
    p->reach = packet_high(m);
}

/* Every hit counts. */
RTI_VEC rtk_u32 packet_sees_all(const packet *p)
{
    return (p->scene->groups->flags & RTK_GROUP_PLAIN) && !p->masked && p->common != 0u;
}

/* Makes ready the walk of `rays`, which are of one octant, and of one axis where the part has triangles in blocks: nobody else
 * asks for kx to sy. */
RTI_VEC void packet_begin(packet *p, rtk_u32 mode, uint64_t rays)
{
    float width = 0.0f;
    rtk_u32 key = p->axis[__builtin_ctzll(rays)];
    vec olo[3], ohi[3], ilo[3], ihi[3], from = V(set)(RTK_INF), inf = V(set)(RTK_INF), none = V(set)(-RTK_INF);
    p->rays = rays;
    p->kz = key & 3u;
    p->kx = p->kz == 2u ? 0u : p->kz + 1u;
    p->ky = p->kx == 2u ? 0u : p->kx + 1u;
    for (rtk_u32 i = 0u; i < 3u; i++) {
        olo[i] = ilo[i] = inf;
        ohi[i] = ihi[i] = none;
    }
    for (rtk_u32 at = 0u; at < PACKET; at += RTI_SIMD) {
        rtk_u32 l = packet_bits(rays, at);
        if (l == 0u)
            continue;
        for (rtk_u32 i = 0u; i < 3u; i++) {
            vec o = V(load)(p->org[i] + at), inv = V(load)(p->inv[i] + at);
            olo[i] = V(min)(olo[i], V(select)(VM(of)(l), o, inf));
            ohi[i] = V(max)(ohi[i], V(select)(VM(of)(l), o, none));
            ilo[i] = V(min)(ilo[i], V(select)(VM(of)(l), inv, inf));
            ihi[i] = V(max)(ihi[i], V(select)(VM(of)(l), inv, none));
        }
        from = V(min)(from, V(select)(VM(of)(l), V(load)(p->t0 + at), inf));
        vec dz = V(load)(p->dir[p->kz] + at);
        V(store)(p->sx + at, V(load)(p->dir[p->kx] + at) / dz);
        V(store)(p->sy + at, V(load)(p->dir[p->ky] + at) / dz);
    }
    for (rtk_u32 i = 0u; i < 3u; i++) {
        rtk_u32 back = key >> (2u + i) & 1u;
        float l = packet_low(olo[i]), h = packet_high(ohi[i]);
        p->near_org[i] = back ? l : h;
        p->far_org[i] = back ? h : l;
        p->inv_lo[i] = packet_low(ilo[i]);
        p->inv_hi[i] = packet_high(ihi[i]);
        p->near[i] = (2u * i + back) * RTK_BVH_WIDTH;
        width += h - l;
    }
    p->one = !(mode & RTK_MODE_ANY) && width == 0.0f;
    p->from = packet_low(from);
    p->plain = packet_sees_all(p);
    memset(p->late, 0xff, sizeof p->late);
    packet_reach(p);
}

/* One ray as a query, with its best hit so far. */
RTI_VEC void packet_query(const packet *p, rtk_u32 i, rtk_query *q)
{
    rti_lane_query(q, p->scene, p->blocks, packet_number(p, i), p->scratch);
    q->best.t = p->t[i];
    q->best.u = p->u[i];
    q->best.v = p->v[i];
    q->best.prim = rtk_bits(p->prim[i]);
    q->best.geom = rtk_bits(p->geom[i]);
}
RTI_VEC void packet_answer(packet *p, rtk_u32 i, const rtk_query *q)
{
    p->t[i] = q->best.t;
    p->u[i] = q->best.u;
    p->v[i] = q->best.v;
    p->prim[i] = rtk_float(q->best.prim);
    p->geom[i] = rtk_float(q->best.geom);
}

/* The best hits of n lanes from `at` on. */
RTI_VEC void packet_hits(const packet *p, rtk_u32 at, rtk_hit_block *out, rtk_u32 n)
{
    memcpy(out->t, p->t + at, n * sizeof(float));
    memcpy(out->u, p->u + at, n * sizeof(float));
    memcpy(out->v, p->v + at, n * sizeof(float));
    memcpy(out->prim, p->prim + at, n * sizeof(float));
    memcpy(out->geom, p->geom + at, n * sizeof(float));
    memset(out->inst, 0xff, n * sizeof *out->inst); /* RTK_INVALID */
}

/* n rays of which something was asked before: their best hits so far are among the batch's. */
RTI_VEC void packet_again(packet *p, rtk_u32 mode, rtk_u32 n, const rtk_hit_block *hits, const uint16_t *occluded)
{
    for (rtk_u32 at = 0u; at < n; at += RTK_BLOCK) {
        const rtk_u32 b = (p->first + at) / RTK_BLOCK, lanes = rtk_umin(n - at, RTK_BLOCK);
        if (mode & RTK_MODE_ANY) {
            p->done |= (uint64_t)occluded[b] << at;
            continue;
        }
        memcpy(p->t + at, hits[b].t, lanes * sizeof(float));
        memcpy(p->u + at, hits[b].u, lanes * sizeof(float));
        memcpy(p->v + at, hits[b].v, lanes * sizeof(float));
        memcpy(p->prim + at, hits[b].prim, lanes * sizeof(float));
        memcpy(p->geom + at, hits[b].geom, lanes * sizeof(float));
    }
}

/* A primitive for one ray, by the leaf test itself: what vectors leave open, shapes, cut-outs, rays of several masks. */
static void packet_ask(packet *p, rtk_u32 mode, const rtk_part *part, rtk_u32 i, rtk_u32 ref)
{
    const uint64_t bit = (uint64_t)1u << i;
    rtk_query q;
    packet_query(p, i, &q);
    if (!(p->ready & bit)) {
        p->ready |= bit;
        p->missed &= ~bit;
        if (!rtk_ray_prepare(q.ray, part->lo, part->hi, part->scale, &p->prays[i]))
            p->missed |= bit;
    }
    if (p->missed & bit)
        return;
    if (rtk_query_prim(&q, mode, &p->prays[i], ref))
        p->done |= bit;
    packet_answer(p, i, &q);
}

/* A triangle's record, seldom in the nearer caches, will be read. */
RTI_VEC void packet_is_next(const packet *p, rtk_u32 ref)
{
    if (ref - p->mesh.first >= p->mesh.count)
        __builtin_prefetch(&p->scene->groups->tris[ref].geom);
}

/* A ray's best hit is of this triangle. A mesh's stand in their order, side by side: where the last one met holds this one, too,
 * no record is read. */
RTI_VEC void packet_is(packet *p, rtk_u32 i, rtk_u32 ref)
{
    if (ref - p->mesh.first >= p->mesh.count) {
        const rtk_group *g = p->scene->groups;
        p->mesh.geom = g->tris[ref].geom;
        p->mesh.first = g->geoms[p->mesh.geom].first;
        p->mesh.count = g->geoms[p->mesh.geom].prim_count;
    }
    p->prim[i] = rtk_float(ref - p->mesh.first);
    p->geom[i] = rtk_float(p->mesh.geom);
}

/* Whose the best hits are, when the walk has ended: vector by vector where all are of the mesh that was met last, else lane by
 * lane. */
RTI_VEC void packet_know(packet *p, const rtk_part *part)
{
    const rtk_u32 *refs = part->bvh.refs;
    rtk_u32 lane[PACKET], ref[PACKET], n = 0u;
    for (rtk_u32 at = 0u; at < PACKET; at += RTI_SIMD) {
        vec_bits late, of, here, prim, geom;
        rtk_u32 some[RTI_SIMD], others;
        vec left;
        memcpy(&late, p->late + at, sizeof late);
        here = (vec_bits)(late != RTK_INVALID);
        memcpy(&left, &here, sizeof left); /* lanes of all ones are no numbers */
        if ((LANES_ALL & ~VM(bits)(V(eq)(left, left))) == 0u)
            continue; /* nor need there be references then */
        late &= here;
        memcpy(some, &late, sizeof some);
        for (rtk_u32 i = 0u; i < RTI_SIMD; i++)
            some[i] = refs[some[i]];
        memcpy(&of, some, sizeof of);
        of -= p->mesh.first;
        memcpy(&prim, p->prim + at, sizeof prim);
        memcpy(&geom, p->geom + at, sizeof geom);
        const vec_bits known = here & (vec_bits)(of < p->mesh.count);
        prim = (prim & ~known) | (of & known);
        geom = (geom & ~known) | (p->mesh.geom & known);
        memcpy(p->prim + at, &prim, sizeof prim);
        memcpy(p->geom + at, &geom, sizeof geom);
        here &= ~known;
        memcpy(&left, &here, sizeof left);
        for (others = LANES_ALL & ~VM(bits)(V(eq)(left, left)); others != 0u; others &= others - 1u) {
            const rtk_u32 i = (rtk_u32)__builtin_ctz(others);
            lane[n] = at + i;
            ref[n] = some[i];
            packet_is_next(p, ref[n++]);
        }
    }
    for (rtk_u32 i = 0u; i < n; i++)
        packet_is(p, lane[i], ref[i]);
}

#endif
