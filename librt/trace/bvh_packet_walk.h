/* The walk of a packet through eight-wide nodes, for hot files; what it is, bvh_packet.h tells. */
#ifndef RTI_BVH_PACKET_WALK_H
#define RTI_BVH_PACKET_WALK_H

#include "packet_shape.h"

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

/* packet_ask of a lane of a packet that walks. */
static void packet_ask_late(packet *p, rtk_u32 mode, const rtk_part *part, rtk_u32 i, rtk_u32 ref)
{
    const rtk_u32 late = rtk_bits(p->late[i]);
    if (late != RTK_INVALID)
        packet_is(p, i, part->bvh.refs[late]);
    p->late[i] = rtk_float(RTK_INVALID);
    packet_ask(p, mode, part, i, ref);
}

/* Of `lanes` from `at` on, which have met the triangle of a reference where their best hit is, those whose best hit is not of the
 * same triangle: leaves of cells and of spatial splits repeat triangles. */
RTI_VEC rtk_u32 packet_others(const packet *p, const rtk_part *part, rtk_u32 at, rtk_u32 lanes, rtk_u32 ref)
{
    rtk_u32 others = lanes;
    for (; lanes != 0u; lanes &= lanes - 1u) {
        const rtk_u32 i = (rtk_u32)__builtin_ctz(lanes), late = rtk_bits(p->late[at + i]);
        const rtk_tri *tri = &p->scene->groups->tris[ref];
        if (late != RTK_INVALID ? part->bvh.refs[late] == ref
                                : rtk_bits(p->prim[at + i]) == tri->prim && rtk_bits(p->geom[at + i]) == tri->geom)
            others &= ~(1u << i);
    }
    return others;
}

/* Of the lanes that tri_test doubts, those that hit become hits, with what the leaf test gives; returns those that are to be
 * asked one by one. dx, dy: the rays' directions in their order of axes; c: the triangle's corners in it. */
RTI_VEC rtk_u32 packet_doubt(const tri_ray *r, rtk_u32 mode, vec best, const float *dx, const float *dy, const float c[3][3],
                             tri_hit *hit)
{
    rtk_u32 left = hit->doubt;
    if (mode & RTK_MODE_ANY) {
        hit->hit |= hit->certain;
        left &= ~hit->certain;
    } else {
        left &= ~(hit->certain & VM(bits)(V(lt)(best, hit->t - hit->off)));
    }
    if (left != 0u) { /* of copies: what has its address taken is in no register */
        const tri_ray rays = *r;
        tri_hit more = *hit;
        const rtk_u32 sure = left & hit->certain;
        if (left != sure)
            left = sure | packet_settle(&rays, best, mode, left & ~sure, c[0], c[1], c[2], &more.hit);
        if (left != 0u) {
            const vec x = V(load)(dx), y = V(load)(dy);
            left = tri_exact_one(&rays, &x, &y, c, left, &more);
        }
        *hit = more;
    }
    return left;
}

/* The triangle at a place for the lanes at `at`. */
RTI_VEC void packet_triangle(packet *p, rtk_u32 mode, const rtk_part *part, const tri_ray *r, rtk_u32 at, rtk_u32 lanes,
                             rtk_u32 place)
{
    const rtk_tree *tree = &part->bvh;
    const rtk_bvhblock *b = &tree->blocks[place / 4u];
    const rtk_u32 j = place % 4u, x = p->kx, y = p->ky, z = p->kz;
    const float c[3][3] = {{b->v0[x][j], b->v0[y][j], b->v0[z][j]},
                           {b->v1[x][j], b->v1[y][j], b->v1[z][j]},
                           {b->v2[x][j], b->v2[y][j], b->v2[z][j]}};
    const vec v0[3] = {V(set)(c[0][0]), V(set)(c[0][1]), V(set)(c[0][2])};
    const vec v1[3] = {V(set)(c[1][0]), V(set)(c[1][1]), V(set)(c[1][2])};
    const vec v2[3] = {V(set)(c[2][0]), V(set)(c[2][1]), V(set)(c[2][2])};
    tri_hit hit;
    rtk_u32 ask = 0u, take;
    if (tri_test(r, v0, v1, v2, lanes, &hit) == 0u)
        return;
    const rtk_tri *tri = NULL;
    const rtk_geom *geom = NULL;
    if (!p->plain) {
        tri = &p->scene->groups->tris[tree->refs[place]];
        geom = &p->scene->groups->geoms[tri->geom];
    }
    const int one = geom && (p->masked || (geom->flags & RTK_GEOM_ALPHA)); /* by one */
    if (geom && !one && !(geom->mask & p->common))
        return;
    if (one) {
        const tri_ray rays = *r;
        ask = hit.hit | packet_settle(&rays, V(load)(p->t + at), mode, hit.doubt, c[0], c[1], c[2], NULL);
    } else if (__builtin_expect(hit.doubt != 0u, 0)) {
        ask = packet_doubt(r, mode, V(load)(p->t + at), p->dir[x] + at, p->dir[y] + at, c, &hit);
    }
    take = one ? 0u : hit.hit;
    if (!(mode & RTK_MODE_ANY) && !one) {
        const vec best = V(load)(p->t + at);
        const rtk_u32 same = take & VM(bits)(V(eq)(hit.t, best));
        if (same != 0u)
            ask |= packet_others(p, part, at, same, tree->refs[place]);
        take &= VM(bits)(V(lt)(hit.t, best));
    }
    if (take && (mode & RTK_MODE_ANY)) {
        p->done |= (uint64_t)take << at;
    } else if (take) {
        V(store)(p->t + at, V(select)(VM(of)(take), hit.t, V(load)(p->t + at)));
        V(store)(p->u + at, V(select)(VM(of)(take), hit.u, V(load)(p->u + at)));
        V(store)(p->v + at, V(select)(VM(of)(take), hit.v, V(load)(p->v + at)));
        if (!tri) {
            V(store)(p->late + at, V(select)(VM(of)(take), V(set)(rtk_float(place)), V(load)(p->late + at)));
        } else {
            V(store)(p->prim + at, V(select)(VM(of)(take), V(set)(rtk_float(tri->prim)), V(load)(p->prim + at)));
            V(store)(p->geom + at, V(select)(VM(of)(take), V(set)(rtk_float(tri->geom)), V(load)(p->geom + at)));
        }
    }
    for (; ask != 0u; ask &= ask - 1u)
        packet_ask_late(p, mode, part, at + (rtk_u32)__builtin_ctz(ask), tree->refs[place]);
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

/* Of a block's triangles those whose boxes some ray may enter, told as packet_open tells it of a node's slots. */
RTI_VEC rtk_u32 packet_near(const packet *p, const rtk_bvhblock *b, float grow)
{
    const rti_f4 zero = rti_f4_set(0.0f), more = rti_f4_set(grow);
    rti_f4 t0 = rti_f4_set(p->from), t1 = rti_f4_set(p->reach);
    for (rtk_u32 k = 0u; k < 3u; k++) {
        const rti_f4 x = rti_f4_load(b->v0[k]), y = rti_f4_load(b->v1[k]), z = rti_f4_load(b->v2[k]);
        const rti_f4 box[2] = {rti_f4_min(rti_f4_min(x, y), z) - more, rti_f4_max(rti_f4_max(x, y), z) + more};
        const rti_f4 lo = rti_f4_set(p->inv_lo[k]), hi = rti_f4_set(p->inv_hi[k]);
        const rtk_u32 back = p->near[k] / RTK_BVH_WIDTH & 1u;
        const rti_f4 in = box[back] - rti_f4_set(p->near_org[k]), out = box[1u - back] - rti_f4_set(p->far_org[k]);
        t0 = rti_f4_max(in * rti_f4_select(rti_f4_lt(in, zero), hi, lo), t0);
        t1 = rti_f4_min(out * rti_f4_select(rti_f4_lt(out, zero), lo, hi), t1);
    }
    return rti_m4_bits(rti_f4_le(t0, t1));
}

/* A leaf's shapes for `lanes` from `at` on, of a plain packet. */
RTI_VEC void packet_shapes(packet *p, rtk_u32 mode, const rtk_part *part, rtk_u32 at, rtk_u32 lanes, rtk_u32 place, rtk_u32 count)
{
    const rtk_group *g = p->scene->groups;
    const packet_rays rays = packet_rays_at(p, at);
    const ball_rays r = shape_rays(&rays, part->scale);
    for (rtk_u32 k = place; k < place + count && lanes != 0u; k++) {
        const rtk_u32 ref = part->bvh.refs[k];
        rtk_u32 ask;
        vec t;
        const rtk_u32 hit =
            shape_hits(&r, rays.inv, bvh_ball(&part->bvh, k), part->bvh.ball_size, V(load)(p->t + at), lanes, &t, &ask);
        if (hit != 0u)
            ask |= packet_take(p, mode, &g->shapes[ref - g->tri_count], at, hit, t);
        for (; ask != 0u; ask &= ask - 1u)
            packet_ask_late(p, mode, part, at + (rtk_u32)__builtin_ctz(ask), ref);
        if (mode & RTK_MODE_ANY)
            lanes &= ~packet_bits(p->done, at);
    }
}

/* A leaf without blocks for all rays from lane `at` on that enter its box. */
RTI_VEC void packet_list(packet *p, rtk_u32 mode, const rtk_part *part, const rtk_bvhnode *n, rtk_u32 slot, rtk_u32 at)
{
    const rtk_u32 place = n->child[slot], count = n->count[slot];
    const rtk_u32 balls = p->plain && part->bvh.ball_count != 0u;
    for (; at < PACKET; at += RTI_SIMD) {
        rtk_u32 lanes = packet_bits(p->rays, at);
        lanes = lanes != 0u ? packet_enter(p, n, slot, at, lanes) : 0u;
        if (lanes != 0u && balls) {
            packet_shapes(p, mode, part, at, lanes, place, count);
            continue;
        }
        for (rtk_u32 k = place; k < place + count && lanes != 0u; k++) {
            for (rtk_u32 ask = lanes; ask != 0u; ask &= ask - 1u)
                packet_ask_late(p, mode, part, at + (rtk_u32)__builtin_ctz(ask), part->bvh.refs[k]);
            if (mode & RTK_MODE_ANY)
                lanes &= ~packet_bits(p->done, at);
        }
    }
}

/* Places of blocks, a bit each from a block's first on, for the lanes that enter the leaf's box, RTI_SIMD rays at a time. */
RTI_VEC void packet_blocks(packet *p, rtk_u32 mode, const rtk_part *part, uint64_t rays, rtk_u32 from, uint64_t places)
{
    for (rtk_u32 at = 0u; at < PACKET; at += RTI_SIMD) {
        const rtk_u32 lanes = packet_bits(rays, at);
        if (lanes == 0u)
            continue;
        tri_ray r = {V(load)(p->org[p->kx] + at), V(load)(p->org[p->ky] + at), V(load)(p->org[p->kz] + at),
                     V(load)(p->sx + at),         V(load)(p->sy + at),         V(load)(p->dir[p->kz] + at),
                     V(load)(p->tmin + at),       V(load)(p->tmax + at),       V(set)(0.0f),
                     V(set)(part->scale)};
        for (uint64_t k = places; k != 0u; k &= k - 1u)
            packet_triangle(p, mode, part, &r, at, lanes, from + (rtk_u32)__builtin_ctzll(k));
    }
}

#ifdef RTI_PACK8
/* The triangle at a place is hit by a lane's ray. */
RTI_VEC void packet_hit(packet *p, rtk_u32 mode, const rtk_part *part, rtk_u32 l, rtk_u32 place, float t, float u, float v)
{
    if (mode & RTK_MODE_ANY) {
        p->done |= (uint64_t)1u << l;
    } else if (t < p->t[l]) {
        p->t[l] = t;
        p->u[l] = u;
        p->v[l] = v;
        p->late[l] = rtk_float(place);
    } else if (t == p->t[l] && packet_others(p, part, l, 1u, part->bvh.refs[place]) != 0u) {
        packet_ask_late(p, mode, part, l, part->bvh.refs[place]);
    }
}

#define FOUR_RAYS  (RTI_SIMD / 4u)       /* that meet four triangles at a time */
#define FOUR_FIRST (0x1111u & LANES_ALL) /* the first lane of each four */

/* What FOUR_RAYS rays by four triangles cost, in halves of a triangle for RTI_SIMD rays: closest hits are taken one by one. */
#define PACKET_PRICE(mode) ((mode)&RTK_MODE_ANY ? 2 : 3)

/* Of FOUR_RAYS rays by four triangles those pairs in doubt that are left: what is a hit is added to *hit; returns those that must
 * be asked. best[best_at[i]]: where the best hit of ray i is; dx[at[i]], dy[at[i]]: its direction in the order of axes. */
__attribute__((noinline)) static rtk_u32 packet_fours_doubt(rtk_u32 mode, const tri_ray *r, const float *best,
                                                            const rtk_u32 best_at[FOUR_RAYS], const float *dx, const float *dy,
                                                            const rtk_u32 at[FOUR_RAYS], const vec v0[3], const vec v1[3],
                                                            const vec v2[3], rtk_u32 left, tri_hit *hit)
{
    const vec end = mode & RTK_MODE_ANY ? r->tmax : V(each)(best, best_at);
    rtk_u32 unsure = left & ~hit->certain, sure;
    if (unsure != 0u) {
        unsure = packet_settle_many(r, &end, v0, v1, v2, unsure, &sure);
        if (mode & RTK_MODE_ANY)
            hit->hit |= sure;
        else
            unsure |= sure;
        left = (left & hit->certain) | unsure;
    }
    if (left == 0u)
        return 0u;
    const vec x = V(each)(dx, at), y = V(each)(dy, at);
    return tri_exact(r, &x, &y, v0, v1, v2, left, hit);
}

/* Four triangles side by side for FOUR_RAYS rays: lane 4 r + t is ray r and triangle t, `lanes` those that count. Returns the
 * hits, with what the leaf test gives, as bits; *ask has those that must be asked. best to at: as packet_fours_doubt has them. */
RTI_VEC rtk_u32 packet_four_by_four(rtk_u32 mode, const tri_ray *r, const rtk_bvhblock *b, const rtk_u32 axis[3], rtk_u32 lanes,
                                    const float *best, const rtk_u32 best_at[FOUR_RAYS], const float *dx, const float *dy,
                                    const rtk_u32 at[FOUR_RAYS], tri_hit *hit, rtk_u32 *ask)
{
    const vec v0[3] = {V(row)(b->v0[axis[0]]), V(row)(b->v0[axis[1]]), V(row)(b->v0[axis[2]])};
    const vec v1[3] = {V(row)(b->v1[axis[0]]), V(row)(b->v1[axis[1]]), V(row)(b->v1[axis[2]])};
    const vec v2[3] = {V(row)(b->v2[axis[0]]), V(row)(b->v2[axis[1]]), V(row)(b->v2[axis[2]])};
    *ask = 0u;
    if (tri_test(r, v0, v1, v2, lanes, hit) == 0u)
        return 0u;
    if (__builtin_expect(hit->doubt != 0u, 0)) {
        if (mode & RTK_MODE_ANY) {
            hit->hit |= hit->certain;
            hit->doubt &= ~hit->certain;
        } else {
            hit->doubt &= ~(hit->certain & VM(bits)(V(lt)(V(each)(best, best_at), hit->t - hit->off)));
        }
        if (hit->doubt != 0u) { /* of copies: what has its address taken is in no register */
            const tri_ray four = *r;
            const vec c0[3] = {v0[0], v0[1], v0[2]}, c1[3] = {v1[0], v1[1], v1[2]}, c2[3] = {v2[0], v2[1], v2[2]};
            tri_hit more = *hit;
            *ask = packet_fours_doubt(mode, &four, best, best_at, dx, dy, at, c0, c1, c2, hit->doubt, &more);
            *hit = more;
        }
    }
    return hit->hit;
}

/* As packet_blocks, of a plain packet, FOUR_RAYS rays by four triangles at a time: lane 4 r + t is ray r and triangle t. */
RTI_VEC void packet_fours(packet *p, rtk_u32 mode, const rtk_part *part, uint64_t rays, rtk_u32 from, uint64_t places)
{
    const rtk_u32 x = p->kx, y = p->ky, z = p->kz, axis[3] = {x, y, z};
    while (rays != 0u) {
        rtk_u32 lane[FOUR_RAYS], n = 0u;
        for (; n < FOUR_RAYS && rays != 0u; rays &= rays - 1u)
            lane[n++] = (rtk_u32)__builtin_ctzll(rays);
        rtk_u32 want = (1u << 4u * n) - 1u;
        for (; n < FOUR_RAYS; n++)
            lane[n] = lane[n - 1u];
        const tri_ray r = {V(each)(p->org[x], lane), V(each)(p->org[y], lane), V(each)(p->org[z], lane),
                           V(each)(p->sx, lane),     V(each)(p->sy, lane),     V(each)(p->dir[z], lane),
                           V(each)(p->tmin, lane),   V(each)(p->tmax, lane),   V(set)(0.0f),
                           V(set)(part->scale)};
        rtk_u32 at = from;
        for (uint64_t left = places; left != 0u; left >>= 4u, at += 4u) {
            tri_hit hit;
            float t[RTI_SIMD], u[RTI_SIMD], v[RTI_SIMD];
            rtk_u32 ask, bits = packet_four_by_four(mode, &r, &part->bvh.blocks[at / 4u], axis,
                                                    want & FOUR_FIRST * (rtk_u32)(left & 15u), p->t, lane, p->dir[x], p->dir[y],
                                                    lane, &hit, &ask);
            if ((bits | ask) == 0u)
                continue;
            V(store)(t, hit.t);
            V(store)(u, hit.u);
            V(store)(v, hit.v);
            for (; bits != 0u; bits &= bits - 1u) {
                const rtk_u32 i = (rtk_u32)__builtin_ctz(bits);
                if ((mode & RTK_MODE_ANY) && (p->done >> lane[i / 4u] & 1u))
                    continue;
                packet_hit(p, mode, part, lane[i / 4u], at + i % 4u, t[i], u[i], v[i]);
            }
            for (; ask != 0u; ask &= ask - 1u) {
                const rtk_u32 i = (rtk_u32)__builtin_ctz(ask);
                packet_ask_late(p, mode, part, lane[i / 4u], part->bvh.refs[at + i % 4u]);
            }
            for (rtk_u32 i = 0u; i < FOUR_RAYS && (mode & RTK_MODE_ANY); i++)
                want &= p->done >> lane[i] & 1u ? ~(15u << 4u * i) : LANES_ALL;
        }
    }
}
#endif

/* The lanes from `at` on that enter a slot's box; groups: how many of RTI_SIMD are among them. */
RTI_VEC uint64_t packet_enters(const packet *p, const rtk_bvhnode *n, rtk_u32 slot, rtk_u32 at, rtk_u32 *groups)
{
    uint64_t in = 0u;
    *groups = 0u;
    for (; at < PACKET; at += RTI_SIMD) {
        rtk_u32 lanes = packet_bits(p->rays, at);
        if (lanes != 0u && (lanes = packet_enter(p, n, slot, at, lanes)) != 0u) {
            in |= (uint64_t)lanes << at;
            ++*groups;
        }
    }
    return in;
}

/* A leaf for all rays from lane `at` on that enter its box. */
RTI_VEC void packet_leaf(packet *p, rtk_u32 mode, const rtk_part *part, const rtk_bvhnode *n, rtk_u32 slot, rtk_u32 at)
{
    const rtk_tree *tree = &part->bvh;
    const rtk_u32 begin = n->child[slot], end = begin + n->count[slot];
    const float grow = RTK_GROW * part->scale; /* as a BVH's boxes are */
    if (begin >= 4u * tree->block_count) {
        packet_list(p, mode, part, n, slot, at);
        return;
    }
    for (rtk_u32 from = begin / 4u * 4u; from < end; from += 64u) {
        uint64_t places = 0u, rays;
        rtk_u32 groups;
        for (rtk_u32 k = from; k < end && k < from + 64u; k += 4u)
            places |= (uint64_t)packet_near(p, &tree->blocks[k / 4u], grow) << (k - from);
        if (begin > from)
            places &= ~(uint64_t)0u << (begin - from);
        if (end - from < 64u)
            places &= ((uint64_t)1u << (end - from)) - 1u;
        if (places == 0u)
            continue;
        rays = packet_enters(p, n, slot, at, &groups);
#ifdef RTI_PACK8
        const uint64_t pairs = places | places >> 1, blocks = (pairs | pairs >> 2) & 0x1111111111111111u;
        const int fours = (__builtin_popcountll(rays) + (int)FOUR_RAYS - 1) / (int)FOUR_RAYS * __builtin_popcountll(blocks);
        if (p->plain && fours * PACKET_PRICE(mode) < (int)groups * __builtin_popcountll(places) * 2) {
            packet_fours(p, mode, part, rays, from, places);
            continue;
        }
#endif
        packet_blocks(p, mode, part, rays, from, places);
    }
}

/* Slots that wait: where the packet's bounds meet them, their nodes, and lanes before which all rays miss them. */
#define PACKET_STACK (RTK_BVH_STACK + RTK_BVH_WIDTH)
typedef struct packet_stack {
    float t[PACKET_STACK];
    rtk_u32 slot[PACKET_STACK], node[PACKET_STACK], lane[PACKET_STACK], top;
} packet_stack;

/* The slots of a node in bits, the nearest on top, of equal ones (a packet within them all) the last, what is fine: of
 * sponza's shadow rays that spares a third of the steps. Without a branch for each where vectors are packed: none could be
 * foreseen. */
RTI_VEC void packet_push(packet_stack *s, rtk_u32 node, rtk_u32 bits, const float t[RTK_BVH_WIDTH], rtk_u32 lane)
{
#ifdef RTI_PACK8
    const rtk_u32 top = s->top;
    if ((bits & (bits - 1u)) == 0u) { /* one, or none: no order has to be waited for */
        const rtk_u32 i = (rtk_u32)__builtin_ctz(bits | 128u);
        s->t[top] = t[i];
        s->slot[top] = i;
        s->node[top] = node;
        s->lane[top] = lane;
        s->top = top + (bits != 0u);
        return;
    }
    rti_f8_sorted(s->t + top, s->slot + top, bits, rti_f8_load(t));
    rti_f8_store((float *)(void *)(s->node + top), rti_f8_set(rtk_float(node)));
    rti_f8_store((float *)(void *)(s->lane + top), rti_f8_set(rtk_float(lane)));
    s->top = top + (rtk_u32)__builtin_popcount(bits);
#else
    const rtk_u32 first = s->top;
    for (; bits != 0u; bits &= bits - 1u) {
        const rtk_u32 i = (rtk_u32)__builtin_ctz(bits);
        rtk_u32 to = s->top++;
        for (; to > first && s->t[to - 1u] < t[i]; to--) {
            s->t[to] = s->t[to - 1u];
            s->slot[to] = s->slot[to - 1u];
        }
        s->t[to] = t[i];
        s->slot[to] = i;
    }
    for (rtk_u32 i = first; i < s->top; i++) {
        s->node[i] = node;
        s->lane[i] = lane;
    }
#endif
}

/* The rays [p->rays] through a part's tree; returns those that it has not finished: the packet came apart. A node is opened when
 * the packet's bounds meet it, which is one test for all rays, and then one of the rays, asked from the first that met its
 * parent; where all start at one point the bounds are as good as the rays. */
RTI_VEC uint64_t packet_walk(packet *p, rtk_u32 mode, const rtk_part *part)
{
    packet_stack stack;
    const rtk_bvhnode *nodes = part->bvh.bvh;
    const rtk_u32 rays = (rtk_u32)__builtin_popcountll(p->rays);
    rtk_u32 at = 0u, lane = 0u, budget = PACKET_NODES * rays + 8u;
    stack.top = 0u;
    p->walks++;
    p->walked += rays;
    for (;;) {
        float t[RTK_BVH_WIDTH];
        if (budget-- == 0u)
            return p->rays;
        const rtk_u32 bits = packet_open(p, &nodes[at], t);
        p->steps++;
        packet_push(&stack, at, bits, t, lane);
        for (rtk_u32 l = bits; l != 0u; l &= l - 1u)
            bvh_expect(&part->bvh, nodes[at].child[__builtin_ctz(l)], nodes[at].count[__builtin_ctz(l)]);
        for (;;) {
            if (stack.top == 0u)
                return 0u;
            const rtk_u32 top = --stack.top;
            if (stack.t[top] > p->reach)
                continue;
            const rtk_bvhnode *n = &nodes[stack.node[top]];
            const rtk_u32 slot = stack.slot[top];
            lane = stack.lane[top];
            if (!(mode & RTK_MODE_ANY) && p->one && n->count[slot] == 0u) {
                at = n->child[slot];
                break;
            }
            lane = packet_first(p, n, slot, lane);
            if (lane == PACKET)
                continue;
            if (n->count[slot] == 0u) {
                at = n->child[slot];
                break;
            }
            p->steps++;
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
