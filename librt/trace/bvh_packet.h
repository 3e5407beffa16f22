/* Rays of a tile through the eight-wide BVH together, for hot files.
 *
 * Up to PACKET rays that point into one octant, with one dominant axis, go as a packet. Inner nodes are asked once for all of
 * them, by intervals: over the rays, org lies in [lo, hi] and inv in [lo, hi], and because float subtraction and multiplication
 * are monotone, the smallest of the rays' (plane - org) * inv is no less than the one taken from the intervals' ends. So what
 * this leaves out every ray would leave out, with no margin. At a leaf the rays are asked one by one, RTI_SIMD at a time, first
 * its box and then each triangle. (Boulos, Wald, Benthin 2008; Overbeck, Ramamoorthi, Mark 2008. What differs: no ray is looked
 * at above the leaves.) A packet that opens too many nodes for its rays has come apart: they go on as single rays.
 */
#ifndef RTI_BVH_PACKET_H
#define RTI_BVH_PACKET_H

#include "bvh_lanes.h"
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
    uint64_t done;          /* any hit: nothing is asked any more */
    rtk_u32 axis[PACKET];   /* order of axes and octant */
    rtk_u32 common, masked; /* the rays' mask; != 0: they have several */
    /* Of the rays that walk. */
    uint64_t rays;
    float near_org[3], far_org[3], inv_lo[3], inv_hi[3], from, reach;
    rtk_u32 near[3], kx, ky, kz;
    const rtk_scene *scene;
    const rtk_trace_block *blocks;
    rtk_u32 first;
    const rti_scratch *scratch;
} packet;

RTI_VEC rtk_u32 packet_bits(uint64_t mask, rtk_u32 at)
{
    return (rtk_u32)(mask >> at) & LANES_ALL;
}

/* Loads rays [first, first + n); returns those that are valid. Lanes behind are filled with the last ray. */
RTI_VEC uint64_t packet_load(packet *p, const rtk_scene *scene, const rtk_trace_block *rays, rtk_u32 first, rtk_u32 n,
                             const rti_scratch *scratch)
{
    uint64_t valid = 0u;
    p->scene = scene;
    p->blocks = rays;
    p->first = first;
    p->scratch = scratch;
    p->done = 0u;
    p->masked = 0u;
    p->common = rays[first / RTK_BLOCK].mask[0];
    if (n < PACKET)
        memset(p->axis, 0, sizeof p->axis);
    for (rtk_u32 at = 0u; at < PACKET && at < n; at += RTI_SIMD) {
        const rtk_trace_block *b = &rays[(first + at) / RTK_BLOCK];
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
        for (rtk_u32 i = 0u; i < RTI_SIMD; i++) {
            p->axis[at + i] = (r.axes[1] >> i & 1u) | (r.axes[2] >> i & 1u) << 1 | (r.back[0] >> i & 1u) << 2 |
                              (r.back[1] >> i & 1u) << 3 | (r.back[2] >> i & 1u) << 4;
            p->mask[at + i] = b->mask[k + i];
        }
        if (n - at < RTI_SIMD)
            ok &= (1u << (n - at)) - 1u;
        for (rtk_u32 i = 0u; i < RTI_SIMD && p->masked == 0u; i++)
            p->masked |= ok >> i & 1u ? p->mask[at + i] ^ p->common : 0u;
        valid |= (uint64_t)ok << at;
    }
    return valid;
}

/* The rays prepared for a part (rtk_ray_prepare): returns those that meet it; far: those that start too far away for this. */
RTI_VEC uint64_t packet_prepare(packet *p, const rtk_part *part, uint64_t rays, uint64_t *far)
{
    uint64_t meet = 0u;
    *far = 0u;
    for (rtk_u32 at = 0u; at < PACKET; at += RTI_SIMD) {
        rtk_u32 want = packet_bits(rays, at), out;
        vec org[3], inv[3], t0, t1;
        if (want == 0u)
            continue;
        for (rtk_u32 i = 0u; i < 3u; i++) {
            org[i] = V(load)(p->org[i] + at);
            inv[i] = V(load)(p->inv[i] + at);
        }
        meet |= (uint64_t)(want & packet_rays_enter(org, inv, V(load)(p->tmin + at), V(load)(p->tmax + at), part, &t0, &t1, &out))
                << at;
        *far |= (uint64_t)(want & out) << at;
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

/* Makes ready the walk of `rays`, which are of one axis and octant. */
RTI_VEC void packet_begin(packet *p, uint64_t rays)
{
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
    }
    p->from = packet_low(from);
    packet_reach(p);
}

/* The slots of a node that some ray may enter, with a bound of where. */
RTI_VEC rtk_u32 packet_open(const packet *p, const rtk_bvhnode *n, float t[RTK_BVH_WIDTH])
{
    const float *box = &n->box[0][0][0];
    rtk_u32 bits = 0u;
    for (rtk_u32 i = 0u; i < RTK_BVH_WIDTH; i += NODE_N) {
        bvh_vec t0 = NODE(set)(p->from), t1 = NODE(set)(p->reach), zero = NODE(set)(0.0f);
        for (rtk_u32 k = 0u; k < 3u; k++) {
            bvh_vec lo = NODE(set)(p->inv_lo[k]), hi = NODE(set)(p->inv_hi[k]);
            bvh_vec a = NODE(load)(box + p->near[k] + i) - NODE(set)(p->near_org[k]);
            bvh_vec b = NODE(load)(box + (p->near[k] ^ RTK_BVH_WIDTH) + i) - NODE(set)(p->far_org[k]);
            t0 = NODE(max)(a * NODE(select)(NODE(lt)(a, zero), hi, lo), t0);
            t1 = NODE(min)(b * NODE(select)(NODE(lt)(b, zero), lo, hi), t1);
        }
        NODE(store)(t + i, t0);
        bits |= node_bits(NODE(le)(t0, t1)) << i;
    }
    return bits;
}

/* The lanes at `at` that enter a slot's box. */
RTI_VEC rtk_u32 packet_enter(const packet *p, const rtk_bvhnode *n, rtk_u32 slot, rtk_u32 at, rtk_u32 lanes)
{
    const float *box = &n->box[0][0][slot];
    vec t0 = V(load)(p->t0 + at), t1 = V(min)(V(load)(p->t1 + at), V(load)(p->t + at));
    for (rtk_u32 k = 0u; k < 3u; k++) {
        vec o = V(load)(p->org[k] + at), inv = V(load)(p->inv[k] + at);
        t0 = V(max)((V(set)(box[p->near[k]]) - o) * inv, t0);
        t1 = V(min)((V(set)(box[p->near[k] ^ RTK_BVH_WIDTH]) - o) * inv, t1);
    }
    return lanes & VM(bits)(V(le)(t0, t1));
}

/* Has the scene nothing but triangles of its own? */
RTI_VEC int packet_plain(const rtk_scene *scene)
{
    return scene->groups->plane_count == 0u && scene->groups->shape_count == 0u && scene->instance_count == 0u;
}

/* One ray as a query, with its best hit so far. */
RTI_VEC void packet_query(const packet *p, rtk_u32 i, rtk_query *q)
{
    rti_lane_query(q, p->scene, p->blocks, p->first + i, p->scratch);
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

/* A primitive for one ray, by the leaf test itself: what vectors leave open, shapes, cut-outs, rays of several masks. */
static void packet_ask(packet *p, rtk_u32 mode, const rtk_part *part, rtk_u32 i, rtk_u32 ref)
{
    rtk_query q;
    rtk_pray r;
    packet_query(p, i, &q);
    if (!rtk_ray_prepare(q.ray, part->lo, part->hi, part->scale, &r))
        return;
    if (rtk_query_prim(&q, mode, &r, ref))
        p->done |= (uint64_t)1u << i;
    packet_answer(p, i, &q);
}

/* One triangle for the lanes at `at`. */
RTI_VEC void packet_triangle(packet *p, rtk_u32 mode, const rtk_part *part, const tri_ray *r, rtk_u32 at, rtk_u32 lanes,
                             rtk_u32 ref, const rtk_bvhblock *b, rtk_u32 j)
{
    const rtk_u32 x = p->kx, y = p->ky, z = p->kz;
    const float c0[3] = {b->v0[x][j], b->v0[y][j], b->v0[z][j]}, c1[3] = {b->v1[x][j], b->v1[y][j], b->v1[z][j]};
    const float c2[3] = {b->v2[x][j], b->v2[y][j], b->v2[z][j]};
    vec v0[3] = {V(set)(c0[0]), V(set)(c0[1]), V(set)(c0[2])}, v1[3] = {V(set)(c1[0]), V(set)(c1[1]), V(set)(c1[2])};
    vec v2[3] = {V(set)(c2[0]), V(set)(c2[1]), V(set)(c2[2])};
    tri_hit hit;
    rtk_u32 bits = tri_test(r, v0, v1, v2, lanes, &hit), ask, take;
    if (bits == 0u)
        return;
    const rtk_group *g = p->scene->groups;
    const rtk_tri *tri = &g->tris[ref];
    const rtk_geom *geom = &g->geoms[tri->geom];
    if (p->masked || (geom->flags & RTK_GEOM_ALPHA)) {
        ask = hit.hit | packet_settle(r, V(load)(p->t + at), mode, hit.doubt, c0, c1, c2, NULL);
        take = 0u;
    } else {
        vec best = V(load)(p->t + at);
        if (!(geom->mask & p->common))
            return;
        take = hit.hit;
        ask = hit.doubt;
        if ((mode & RTK_MODE_ANY) || __builtin_popcount(ask) < TRI_EXACT_AT_ONCE)
            ask = packet_settle(r, best, mode, ask, c0, c1, c2, &take);
        if (__builtin_popcount(ask) >= TRI_EXACT_LEAST) {
            const vec dx = V(load)(p->dir[x] + at), dy = V(load)(p->dir[y] + at);
            ask = tri_exact(r, &dx, &dy, v0, v1, v2, ask, &hit);
            take |= hit.hit;
        }
        if (!(mode & RTK_MODE_ANY)) {
            ask |= take & VM(bits)(V(eq)(hit.t, best));
            take &= VM(bits)(V(lt)(hit.t, best));
        }
    }
    if (take && (mode & RTK_MODE_ANY)) {
        p->done |= (uint64_t)take << at;
    } else if (take) {
        V(store)(p->t + at, V(select)(VM(of)(take), hit.t, V(load)(p->t + at)));
        V(store)(p->u + at, V(select)(VM(of)(take), hit.u, V(load)(p->u + at)));
        V(store)(p->v + at, V(select)(VM(of)(take), hit.v, V(load)(p->v + at)));
        V(store)(p->prim + at, V(select)(VM(of)(take), V(set)(rtk_float(tri->prim)), V(load)(p->prim + at)));
        V(store)(p->geom + at, V(select)(VM(of)(take), V(set)(rtk_float(tri->geom)), V(load)(p->geom + at)));
    }
    for (; ask != 0u; ask &= ask - 1u)
        packet_ask(p, mode, part, at + (rtk_u32)__builtin_ctz(ask), ref);
}

/* From `at` on, the first lanes of which one enters a slot's box; PACKET: none does. */
RTI_VEC rtk_u32 packet_first(const packet *p, const rtk_bvhnode *n, rtk_u32 slot, rtk_u32 at)
{
    for (; at < PACKET; at += RTI_SIMD) {
        rtk_u32 lanes = packet_bits(p->rays, at);
        if (lanes != 0u && packet_enter(p, n, slot, at, lanes) != 0u)
            break;
    }
    return at;
}

/* A leaf for all rays from lane `at` on that enter its box. */
RTI_VEC void packet_leaf(packet *p, rtk_u32 mode, const rtk_part *part, const rtk_bvhnode *n, rtk_u32 slot, rtk_u32 at)
{
    const rtk_tree *tree = &part->bvh;
    rtk_u32 from = n->child[slot], count = n->count[slot];
    for (; at < PACKET; at += RTI_SIMD) {
        rtk_u32 lanes = packet_bits(p->rays, at);
        if (lanes == 0u || (lanes = packet_enter(p, n, slot, at, lanes)) == 0u)
            continue;
        if (from >= 4u * tree->block_count) {
            for (rtk_u32 k = 0u; k < count; k++)
                for (rtk_u32 l = lanes; l != 0u; l &= l - 1u)
                    packet_ask(p, mode, part, at + (rtk_u32)__builtin_ctz(l), tree->refs[from + k]);
            continue;
        }
        tri_ray r = {V(load)(p->org[p->kx] + at), V(load)(p->org[p->ky] + at), V(load)(p->org[p->kz] + at),
                     V(load)(p->sx + at),         V(load)(p->sy + at),         V(load)(p->dir[p->kz] + at),
                     V(load)(p->tmin + at),       V(load)(p->tmax + at),       V(set)(0.0f),
                     V(set)(part->scale)};
        for (rtk_u32 k = from; k < from + count; k++)
            packet_triangle(p, mode, part, &r, at, lanes, tree->refs[k], &tree->blocks[k / 4u], k % 4u);
    }
}

/* The rays [p->rays] through a part's tree; returns those that it has not finished: the packet came apart. A node is opened when
 * the packet's bounds meet it, which is one test for all rays, and then one of the rays, asked from the first that met its
 * parent. */
RTI_VEC uint64_t packet_walk(packet *p, rtk_u32 mode, const rtk_part *part)
{
    struct {
        float t;
        rtk_u32 node, slot, lane; /* lane: rays before it miss the node */
    } stack[RTK_BVH_STACK];
    const rtk_bvhnode *nodes = part->bvh.bvh;
    rtk_u32 top = 0u, at = 0u, lane = 0u, budget = PACKET_NODES * (rtk_u32)__builtin_popcountll(p->rays) + 8u;
    for (;;) {
        float t[RTK_BVH_WIDTH];
        rtk_u32 first = top;
        if (budget-- == 0u)
            return p->rays;
        for (rtk_u32 bits = packet_open(p, &nodes[at], t); bits != 0u; bits &= bits - 1u) {
            rtk_u32 i = (rtk_u32)__builtin_ctz(bits), to = top++;
            for (; to > first && stack[to - 1u].t < t[i]; to--)
                stack[to] = stack[to - 1u];
            stack[to].t = t[i];
            stack[to].node = at;
            stack[to].slot = i;
            stack[to].lane = lane;
        }
        for (;;) {
            if (top == 0u)
                return 0u;
            top--;
            if (stack[top].t > p->reach)
                continue;
            const rtk_bvhnode *n = &nodes[stack[top].node];
            rtk_u32 slot = stack[top].slot;
            lane = packet_first(p, n, slot, stack[top].lane);
            if (lane == PACKET)
                continue;
            if (n->count[slot] == 0u) {
                at = n->child[slot];
                break;
            }
            packet_leaf(p, mode, part, n, slot, lane);
            if (mode & RTK_MODE_ANY) {
                p->rays &= ~p->done;
                if (p->rays == 0u)
                    return 0u;
            } else {
                packet_reach(p);
            }
        }
    }
}

#endif
