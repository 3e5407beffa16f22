/* A packet of rays on its way through one part's kd-tree: RTI_LANES rays of a trace block, of which those of one dominant axis
 * and one octant walk together. */
#ifndef RTI_KD_PACKET_H
#define RTI_KD_PACKET_H

#include "lane.h"
#include "lanes.h"

#define KD_TRIED 8u

typedef struct kd_packet {
    /* The rays as they came. */
    const rtk_scene *scene;
    const rtk_trace_block *rays;
    const rti_scratch *scratch;
    uint32_t first; /* lane 0 is ray `first` */
    rti_vf org[3], dir[3], inv[3], tmin, tmax;
    rti_vi mask;
    uint32_t live; /* rays that are valid and, any hit, have met nothing */
    /* The best so far, in the scene's own group. */
    rti_vf t, u, v;
    rti_vi prim, geom;
    uint32_t done; /* any hit: has met something */
    /* Of the part. ready: rays prepared one by one as well, for what is not done in lanes; missed: those of them that miss the
     * part. */
    const rtk_part *part;
    rti_vf t0, t1;
    uint32_t ready, missed;
    rtk_pray prays[RTI_LANES];
    uint32_t tried[KD_TRIED], tried_lanes[KD_TRIED]; /* references that lanes have met by themselves, by their low bits */
    /* Of the rays that walk together. */
    uint32_t kx, ky, kz;
    rti_vf kox, koy, koz, sx, sy, kdz;
} kd_packet;

typedef struct kd_waiting {
    rti_vf t0, t1;
    uint32_t node, lanes;
} kd_waiting;

/* Loads `count` rays; live: those that are valid (rtk_ray_valid). */
static inline void kd_packet_load(kd_packet *p, const rtk_scene *scene, const rtk_trace_block *rays, uint32_t first,
                                  uint32_t count, const rti_scratch *scratch)
{
    const rtk_trace_block *b = &rays[first / RTK_BLOCK];
    uint32_t lane = first % RTK_BLOCK;
    const float *org[3] = {b->ox + lane, b->oy + lane, b->oz + lane}, *dir[3] = {b->dx + lane, b->dy + lane, b->dz + lane};
    rti_vf most = rti_vf_all(3.402823466e38f), longest = rti_vf_all(0.0f), none = rti_vf_all(0.0f);
    rti_vm valid;
    p->scene = scene;
    p->rays = rays;
    p->scratch = scratch;
    p->first = first;
    p->tmin = rti_vf_load(b->tmin + lane);
    p->tmax = rti_vf_load(b->tmax + lane);
    p->mask = rti_vi_load(b->mask + lane);
    valid = rti_lt(p->tmin, p->tmax);
    for (int a = 0; a < 3; a++) {
        rti_vf d = rti_vf_load(dir[a]), size = rti_vf_abs(d), inv = 1.0f / d, top = rti_vf_all(RTK_INV_MAX);
        rti_vf flat = (rti_vf)(((rti_vi)d & (int32_t)0x80000000) | (rti_vi)top);
        p->dir[a] = d;
        p->org[a] = rti_vf_load(org[a]);
        inv = rti_vf_min(rti_vf_max(inv, -top), top);
        p->inv[a] = rti_pick(rti_lt(size, rti_vf_all(1.0e-30f)), flat, inv);
        valid = (rti_vm)(valid & rti_le(rti_vf_abs(p->org[a]), most) & rti_le(size, most));
        longest = rti_vf_max(longest, size);
    }
    valid = (rti_vm)(valid & rti_le(rti_vf_all(RTK_DIR_MIN), longest) & rti_le(longest, rti_vf_all(RTK_DIR_MAX)));
    p->live = rti_bits(valid) & (count < RTI_LANES ? (1u << count) - 1u : RTI_ALL_LANES);
    p->done = 0;
    p->t = p->tmax;
    p->u = p->v = none;
    p->prim = p->geom = (rti_vi){0} - 1;
}

/* What rtk_ray_prepare settles, for all lanes: returns those that enter the part. far: those whose origins would be moved. */
static inline uint32_t kd_packet_prepare(kd_packet *p, const rtk_part *part, uint32_t *far)
{
    float lo[3] = {part->lo.x, part->lo.y, part->lo.z}, hi[3] = {part->hi.x, part->hi.y, part->hi.z};
    rti_vf t0 = rti_vf_all(-RTK_INF), t1 = rti_vf_all(RTK_INF), out = rti_vf_all(0.0f);
    rti_vm in;
    for (int a = 0; a < 3; a++) {
        rti_vf x = (lo[a] - p->org[a]) * p->inv[a], y = (hi[a] - p->org[a]) * p->inv[a];
        t0 = rti_vf_max(t0, rti_vf_min(x, y));
        t1 = rti_vf_min(t1, rti_vf_max(x, y));
        out = rti_vf_max(out, rti_vf_abs(p->org[a]));
    }
    in = (rti_vm)(rti_le(t0, t1) & ~rti_lt(t1, p->tmin) & ~rti_lt(p->tmax, t0));
    p->part = part;
    p->ready = p->missed = 0;
    for (uint32_t i = 0; i < KD_TRIED; i++)
        p->tried[i] = RTK_INVALID;
    p->t0 = rti_vf_max(t0, p->tmin);
    p->t1 = rti_vf_min(t1, p->tmax);
    *far = rti_bits(rti_lt(rti_vf_all(RTK_FAR * part->scale), out)) & p->live;
    return rti_bits(in) & p->live & ~*far;
}

/* Dominant axes of all lanes, as rtk_ray_prepare chooses them: bits by axis. */
static inline void kd_packet_axes(const kd_packet *p, uint32_t axes[3])
{
    rti_vf x = rti_vf_abs(p->dir[0]), y = rti_vf_abs(p->dir[1]), z = rti_vf_abs(p->dir[2]);
    axes[0] = rti_bits((rti_vm)(rti_lt(y, x) & rti_lt(z, x)));
    axes[1] = rti_bits(rti_lt(z, y)) & ~axes[0];
    axes[2] = ~(axes[0] | axes[1]);
}

/* Of `rest`, the lanes that walk with its first one; sets what they share. */
static inline uint32_t kd_packet_together(kd_packet *p, const uint32_t axes[3], const uint32_t back[3], uint32_t rest)
{
    uint32_t one = rest & (0u - rest), group = rest;
    for (uint32_t a = 0; a < 3; a++) {
        group &= back[a] & one ? back[a] : ~back[a];
        if (axes[a] & one) {
            group &= axes[a];
            p->kz = a;
        }
    }
    p->kx = (p->kz + 1) % 3;
    p->ky = (p->kz + 2) % 3;
    p->kox = p->org[p->kx];
    p->koy = p->org[p->ky];
    p->koz = p->org[p->kz];
    p->kdz = p->dir[p->kz];
    p->sx = p->dir[p->kx] / p->kdz;
    p->sy = p->dir[p->ky] / p->kdz;
    return group;
}

/* Lane `lane` prepared by itself; NULL: it misses the part. */
static inline const rtk_pray *kd_packet_ray(kd_packet *p, uint32_t lane, rtk_ray ray)
{
    if (!(p->ready >> lane & 1u)) {
        p->ready |= 1u << lane;
        if (!rtk_ray_prepare(ray, p->part->lo, p->part->hi, p->part->scale, &p->prays[lane]))
            p->missed |= 1u << lane;
    }
    return p->missed >> lane & 1u ? NULL : &p->prays[lane];
}

/* A lane as a query of its own, and its answer back. */
static inline void kd_packet_query(const kd_packet *p, uint32_t lane, rtk_query *q)
{
    rti_lane_query(q, p->scene, p->rays, p->first + lane, p->scratch);
    q->best.t = p->t[lane];
    q->best.u = p->u[lane];
    q->best.v = p->v[lane];
    q->best.prim = (rtk_u32)p->prim[lane];
    q->best.geom = (rtk_u32)p->geom[lane];
}

static inline void kd_packet_answer(kd_packet *p, uint32_t lane, const rtk_query *q, int done)
{
    p->t[lane] = q->best.t;
    p->u[lane] = q->best.u;
    p->v[lane] = q->best.v;
    p->prim[lane] = (int32_t)q->best.prim;
    p->geom[lane] = (int32_t)q->best.geom;
    p->done |= (done ? 1u : 0u) << lane;
}

/* Of `lanes`, those that have not yet met reference `ref` by themselves: leaves repeat triangles, and what is worth another look
 * in one is so in the next, to the same end. */
static inline uint32_t kd_packet_untried(kd_packet *p, uint32_t ref, uint32_t lanes)
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

/* Triangle `tri` for `lanes`: rtk_tri_intersect's operations, one for one. Returns the lanes that it certainly hits in (tmin,
 * tmax), with t, u, v; rough: those whose numbers have to be looked at again (rtk_tri_exact). */
static inline uint32_t kd_packet_tri(const kd_packet *p, const rtk_tri *tri, uint32_t lanes, rti_vf *t, rti_vf *u, rti_vf *v,
                                     uint32_t *rough)
{
    uint32_t kx = p->kx, ky = p->ky, kz = p->kz;
    rti_vf zero = rti_vf_all(0.0f), one = rti_vf_all(1.0f), scale = rti_vf_all(p->part->scale);
    rti_vf az = tri->v0[kz] - p->koz, bz = tri->v1[kz] - p->koz, cz = tri->v2[kz] - p->koz;
    rti_vf ax = (tri->v0[kx] - p->kox) - p->sx * az, ay = (tri->v0[ky] - p->koy) - p->sy * az;
    rti_vf bx = (tri->v1[kx] - p->kox) - p->sx * bz, by = (tri->v1[ky] - p->koy) - p->sy * bz;
    rti_vf cx = (tri->v2[kx] - p->kox) - p->sx * cz, cy = (tri->v2[ky] - p->koy) - p->sy * cz;
    rti_vf uu = cx * by - cy * bx, vv = ax * cy - ay * cx, ww = bx * ay - by * ax;
    rti_vf lo = rti_vf_min(rti_vf_min(uu, vv), ww), hi = rti_vf_max(rti_vf_max(uu, vv), ww);
    rti_vm m = (rti_vm) ~(rti_lt(lo, zero) & rti_lt(zero, hi)), doubt, out;
    rti_vf det, inv, db, dc, b, c, z, mx, my, d, q, e, th, room, depth;
    *rough = 0;
    if (!(rti_bits(m) & lanes))
        return 0;
    det = uu + vv + ww;
    m = (rti_vm)(m & rti_lt(rti_vf_abs(det), rti_vf_all(RTK_INF)));
    inv = one / det;
    db = bz - az;
    dc = cz - az;
    b = vv * inv;
    c = ww * inv;
    z = az + (b * db + c * dc);
    mx = rti_vf_max(rti_vf_max(rti_vf_abs(ax), rti_vf_abs(bx)), rti_vf_abs(cx));
    my = rti_vf_max(rti_vf_max(rti_vf_abs(ay), rti_vf_abs(by)), rti_vf_abs(cy));
    d = rti_vf_max(rti_vf_abs(db), rti_vf_abs(dc));
    q = mx * my * rti_vf_abs(inv);
    e = b * rti_vf_abs(db) + c * rti_vf_abs(dc);
    e = 10.0f * e + (7.0f * e + 4.0f * d) * q;
    room = rti_vf_min(32.0f * scale, 64.0f * rti_vf_abs(z));
    doubt = (rti_vm)(rti_eq(uu, zero) | rti_eq(vv, zero) | rti_eq(ww, zero) | ~rti_le(e, room) |
                     ~rti_le((mx + my) * (10.0f * q + 12.0f), 128.0f * scale));
    th = zero + z / p->kdz; /* tshift is zero */
    depth = 1.2e-7f * e / rti_vf_abs(p->kdz);
    out = (rti_vm)(rti_lt(th + depth, p->tmin) | rti_lt(p->tmax, th - depth));
    *rough = rti_bits((rti_vm)(m & doubt & ~out)) & lanes;
    *t = th;
    *u = rti_vf_min(b, one);
    *v = rti_vf_min(c, one);
    return rti_bits((rti_vm)(m & ~doubt & rti_lt(p->tmin, th) & rti_lt(th, p->tmax))) & lanes;
}

#endif
