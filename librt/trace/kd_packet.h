/* A packet of rays on its way through one part's kd-tree: RTI_SIMD rays of a trace block, of which those of one dominant axis
 * and one octant walk together. */
#ifndef RTI_KD_PACKET_H
#define RTI_KD_PACKET_H

#include "packet.h"

#define KD_TRIED 8u

typedef struct kd_packet {
    /* The rays as they came. */
    const rtk_scene *scene;
    const rtk_trace_block *rays;
    const rti_scratch *scratch;
    uint32_t first; /* lane 0 is ray `first` */
    packet_rays r;
    uint32_t masks[RTI_SIMD];
    uint32_t live; /* rays that are valid and, any hit, have met nothing */
    /* The best so far, in the scene's own group; prim and geom as bits. */
    vec t, u, v, prim, geom;
    uint32_t done; /* any hit: has met something */
    /* Of the part. ready: rays prepared one by one as well, for what is not done in lanes; missed: those of them that miss the
     * part. */
    const rtk_part *part;
    vec t0, t1;
    uint32_t ready, missed;
    rtk_pray prays[RTI_SIMD];
    uint32_t tried[KD_TRIED], tried_lanes[KD_TRIED]; /* references that lanes have met by themselves, by their low bits */
    /* Of the rays that walk together. */
    uint32_t kx, ky, kz;
    tri_ray tri;
} kd_packet;

typedef struct kd_waiting {
    vec t0, t1;
    uint32_t node, lanes;
} kd_waiting;

RTI_VEC void kd_packet_load(kd_packet *p, const rtk_scene *scene, const rtk_trace_block *rays, uint32_t first, uint32_t count,
                            const rti_scratch *scratch)
{
    const rtk_trace_block *b = &rays[first / RTK_BLOCK];
    p->scene = scene;
    p->rays = rays;
    p->scratch = scratch;
    p->first = first;
    packet_rays_load(&p->r, b, first % RTK_BLOCK);
    memcpy(p->masks, b->mask + first % RTK_BLOCK, sizeof p->masks);
    p->live = p->r.valid & (count < RTI_SIMD ? (1u << count) - 1u : LANES_ALL);
    for (uint32_t i = 0; i < RTI_SIMD; i++)
        p->live &= ~((p->masks[i] == 0 ? 1u : 0u) << i); /* sees nothing */
    p->done = 0;
    p->t = p->r.tmax;
    p->u = p->v = V(set)(0.0f);
    p->prim = p->geom = V(set)(rtk_float(RTK_INVALID));
}

/* Returns the lanes that enter the part. far: those whose origins would be moved. */
RTI_VEC uint32_t kd_packet_prepare(kd_packet *p, const rtk_part *part, uint32_t *far)
{
    uint32_t in = packet_rays_enter(p->r.org, p->r.inv, p->r.tmin, p->r.tmax, p->live, part, &p->t0, &p->t1, far);
    p->part = part;
    p->ready = p->missed = 0;
    for (uint32_t i = 0; i < KD_TRIED; i++)
        p->tried[i] = RTK_INVALID;
    return in;
}

/* Of `rest`, the lanes that walk with its first one; sets what they share. */
RTI_VEC uint32_t kd_packet_together(kd_packet *p, uint32_t rest)
{
    uint32_t one = rest & (0u - rest), group = rest;
    for (uint32_t a = 0; a < 3; a++) {
        group &= p->r.back[a] & one ? p->r.back[a] : ~p->r.back[a];
        if (p->r.axes[a] & one) {
            group &= p->r.axes[a];
            p->kz = a;
        }
    }
    p->kx = (p->kz + 1) % 3;
    p->ky = (p->kz + 2) % 3;
    p->tri.ox = p->r.org[p->kx];
    p->tri.oy = p->r.org[p->ky];
    p->tri.oz = p->r.org[p->kz];
    p->tri.kdz = p->r.dir[p->kz];
    p->tri.sx = p->r.dir[p->kx] / p->tri.kdz;
    p->tri.sy = p->r.dir[p->ky] / p->tri.kdz;
    p->tri.tmin = p->r.tmin;
    p->tri.tmax = p->r.tmax;
    p->tri.tshift = V(set)(0.0f);
    p->tri.scale = V(set)(p->part->scale);
    return group;
}

/* Lane `lane` prepared by itself; NULL: it misses the part. */
RTI_VEC const rtk_pray *kd_packet_ray(kd_packet *p, uint32_t lane, rtk_ray ray)
{
    if (!(p->ready >> lane & 1u)) {
        p->ready |= 1u << lane;
        if (!rtk_ray_prepare(ray, p->part->lo, p->part->hi, p->part->scale, &p->prays[lane]))
            p->missed |= 1u << lane;
    }
    return p->missed >> lane & 1u ? NULL : &p->prays[lane];
}

/* A lane as a query of its own, and its answer back. */
RTI_VEC void kd_packet_query(const kd_packet *p, uint32_t lane, rtk_query *q)
{
    rti_lane_query(q, p->scene, p->rays, p->first + lane, p->scratch);
    q->best.t = p->t[lane];
    q->best.u = p->u[lane];
    q->best.v = p->v[lane];
    q->best.prim = rtk_bits(p->prim[lane]);
    q->best.geom = rtk_bits(p->geom[lane]);
}

RTI_VEC void kd_packet_answer(kd_packet *p, uint32_t lane, const rtk_query *q, int done)
{
    p->t[lane] = q->best.t;
    p->u[lane] = q->best.u;
    p->v[lane] = q->best.v;
    p->prim[lane] = rtk_float(q->best.prim);
    p->geom[lane] = rtk_float(q->best.geom);
    p->done |= (done ? 1u : 0u) << lane;
}

/* Of `lanes`, those that have not yet met reference `ref` by themselves: leaves repeat triangles, and what is worth another look
 * in one is so in the next, to the same end. */
RTI_VEC uint32_t kd_packet_untried(kd_packet *p, uint32_t ref, uint32_t lanes)
{
    uint32_t at = ref % KD_TRIED;
    if (p->tried[at] != ref) {
        p->tried[at] = ref;
        p->tried_lanes[at] = 0;
    }
    lanes &= ~p->tried_lanes[at];
    p->tried_lanes[at] |= lanes;
    return lanes;
}

/* Triangle `tri` for `lanes`; returns those that hit it or are in doubt. take: packet_settle may add sure ones to the hits. */
RTI_VEC uint32_t kd_packet_tri(const kd_packet *p, rtk_u32 mode, const rtk_tri *tri, uint32_t lanes, bool take, tri_hit *hit)
{
    const float v0[3] = {tri->v0[p->kx], tri->v0[p->ky], tri->v0[p->kz]},
                v1[3] = {tri->v1[p->kx], tri->v1[p->ky], tri->v1[p->kz]};
    const float v2[3] = {tri->v2[p->kx], tri->v2[p->ky], tri->v2[p->kz]};
    vec a[3] = {V(set)(v0[0]), V(set)(v0[1]), V(set)(v0[2])}, b[3] = {V(set)(v1[0]), V(set)(v1[1]), V(set)(v1[2])};
    vec c[3] = {V(set)(v2[0]), V(set)(v2[1]), V(set)(v2[2])};
    if (tri_test(&p->tri, a, b, c, lanes, hit) == 0)
        return 0;
    if ((mode & RTK_MODE_ANY) || __builtin_popcount(hit->doubt) < TRI_EXACT_AT_ONCE)
        hit->doubt = packet_settle(&p->tri, p->t, mode, hit->doubt, v0, v1, v2, take ? &hit->hit : NULL);
    if (__builtin_popcount(hit->doubt) >= TRI_EXACT_LEAST)
        hit->doubt = tri_exact(&p->tri, &p->r.dir[p->kx], &p->r.dir[p->ky], a, b, c, hit->doubt, hit);
    return hit->hit | hit->doubt;
}

#endif
