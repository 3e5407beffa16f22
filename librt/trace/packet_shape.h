/* Shapes and planes for the rays of a packet, RTI_SIMD at a time, for hot files: what rtk_plane_intersect and the queries that
 * call it do, the same operations in the same order, so the same bits. */
#ifndef RTI_PACKET_SHAPE_H
#define RTI_PACKET_SHAPE_H

#include "bvh_packet.h"
#include "shape_leaf.h"

/* Rays of a block, none of which has its origin moved, as shapes meet them. */
RTI_VEC ball_rays shape_rays(const packet_rays *rays, float scale)
{
    ball_rays r;
    balls_meet(&r, rays->org, rays->dir, rays->tmin, rays->tmax, V(set)(0.0f), V(set)(RTK_BALL_MARGIN * scale));
    ball_ready(&r);
    return r;
}

/* Lanes `hit` of a plain packet from `at` on meet a shape at t; returns those of equal hits, whose order is to be asked for. */
RTI_VEC rtk_u32 packet_take(packet *p, rtk_u32 mode, const rtk_shape *shape, rtk_u32 at, rtk_u32 hit, vec t)
{
    if (mode & RTK_MODE_ANY) {
        p->done |= (uint64_t)hit << at;
        return 0u;
    }
    const vec best = V(load)(p->t + at), zero = V(set)(0.0f);
    const vmask take = VM(of)(hit & VM(bits)(V(lt)(t, best)));
    V(store)(p->t + at, V(select)(take, t, best));
    V(store)(p->u + at, V(select)(take, zero, V(load)(p->u + at)));
    V(store)(p->v + at, V(select)(take, zero, V(load)(p->v + at)));
    V(store)(p->prim + at, V(select)(take, V(set)(rtk_float(shape->prim)), V(load)(p->prim + at)));
    V(store)(p->geom + at, V(select)(take, V(set)(rtk_float(shape->geom)), V(load)(p->geom + at)));
    V(store)(p->late + at, V(select)(take, V(set)(rtk_float(RTK_INVALID)), V(load)(p->late + at)));
    return hit & VM(bits)(V(eq)(t, best));
}

/* Rays of a packet from `at` on, but for what is told of their directions. */
RTI_VEC packet_rays packet_rays_at(const packet *p, rtk_u32 at)
{
    packet_rays r; /* field by field: an initializer would clear the others */
    r.tmin = V(load)(p->tmin + at);
    r.tmax = V(load)(p->tmax + at);
    for (rtk_u32 k = 0u; k < 3u; k++) {
        r.org[k] = V(load)(p->org[k] + at);
        r.dir[k] = V(load)(p->dir[k] + at);
        r.inv[k] = V(load)(p->inv[k] + at);
    }
    return r;
}

/* Lanes whose rays hit a plane, and where. */
RTI_VEC rtk_u32 packet_plane_hits(const packet *p, const rtk_shape *plane, rtk_u32 at, rtk_u32 lanes, vec *out)
{
    wide_ff den, num;
    for (rtk_u32 k = 0u; k < 3u; k++) {
        const vec n = V(set)(plane->p[4u + k]), way = V(load)(p->dir[k] + at), org = V(load)(p->org[k] + at);
        const wide_ff d = wide_two_prod(n, way);
        const wide_ff a = wide_mul(wide_two_diff(V(set)(plane->p[k]), org), (wide_ff){n, V(set)(0.0f)});
        den = k == 0u ? d : wide_add(den, d);
        num = k == 0u ? a : wide_add(num, a);
    }
    *out = num.hi / den.hi;
    return lanes & VM(bits)(V(lt)(V(load)(p->tmin + at), *out)) & VM(bits)(V(lt)(*out, V(load)(p->tmax + at)));
}

/* All planes of the scene, for `rays` of a packet of which nothing else was asked: in lanes where every hit counts. */
RTI_VEC void packet_planes(packet *p, rtk_u32 mode, uint64_t rays)
{
    const rtk_group *g = p->scene->groups;
    for (uint64_t l = packet_sees_all(p) ? 0u : rays; l != 0u; l &= l - 1u) {
        const rtk_u32 i = (rtk_u32)__builtin_ctzll(l);
        rtk_query q;
        packet_query(p, i, &q);
        if (rtk_query_planes(&q, mode, q.ray))
            p->done |= (uint64_t)1u << i;
        packet_answer(p, i, &q);
    }
    if (!packet_sees_all(p))
        return;
    memset(p->late, 0xff, sizeof p->late);
    for (rtk_u32 at = 0u; at < PACKET; at += RTI_SIMD) {
        for (rtk_u32 i = 0u; i < g->plane_count; i++) {
            const rtk_u32 lanes = packet_bits(rays & ~p->done, at);
            vec t;
            rtk_u32 hit = lanes != 0u ? packet_plane_hits(p, &g->planes[i], at, lanes, &t) : 0u, ask;
            if (hit == 0u)
                continue;
            for (ask = packet_take(p, mode, &g->planes[i], at, hit, t); ask != 0u; ask &= ask - 1u) {
                const rtk_u32 l = at + (rtk_u32)__builtin_ctz(ask);
                rtk_query q;
                packet_query(p, l, &q);
                rtk_query_planes(&q, mode, q.ray);
                packet_answer(p, l, &q);
            }
        }
    }
}

#endif
