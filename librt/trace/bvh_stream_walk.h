/* How rays come into streams, and a stream's way through a tree (bvh_stream.h). */
#ifndef RTI_BVH_STREAM_WALK_H
#define RTI_BVH_STREAM_WALK_H

#include "bvh_stream_dense.h"

/* ---- rays ---- */

/* Lanes of numbers that are not 0. */
RTI_VEC rtk_u32 stream_some(vec_bits a)
{
    const vec_bits none = (vec_bits)(a == 0u);
    vec x;
    memcpy(&x, &none, sizeof x); /* lanes of all ones are no numbers */
    return VM(bits)(V(eq)(x, x));
}

typedef struct stream_axes {
    vmask first, second;
} stream_axes;

/* Of each lane the component along its dominant axis: x, y or z. */
RTI_VEC vec stream_turned(const stream_axes *a, vec x, vec y, vec z)
{
    return V(select)(a->first, x, V(select)(a->second, y, z));
}

#ifndef RTI_PACK8
/* Rows of eight numbers, of RTI_SIMD rays, as their records. */
RTI_VEC void stream_records(const vec in[8], float *const to[RTI_SIMD])
{
    float rows[8][RTI_SIMD];
    for (rtk_u32 k = 0u; k < 8u; k++)
        V(store)(rows[k], in[k]);
    for (rtk_u32 i = 0u; i < RTI_SIMD; i += 4u) {
        for (rtk_u32 h = 0u; h < 8u; h += 4u) {
            const rti_f4 from[4] = {rti_f4_load(rows[h] + i), rti_f4_load(rows[h + 1u] + i), rti_f4_load(rows[h + 2u] + i),
                                    rti_f4_load(rows[h + 3u] + i)};
            rti_f4 turned[4];
            rti_f4_turn(from, turned);
            for (rtk_u32 k = 0u; k < 4u; k++)
                rti_f4_store(to[i + k] + h, turned[k]);
        }
    }
}
#else
#define stream_records V(spread)
#endif

/* RTI_SIMD rays prepared for the part. t: of their best hits; kind, key: as of a packet. */
typedef struct stream_rays {
    vec org[3], dir[3], inv[3], tmin, tmax, t0, t1, t, kind, key;
} stream_rays;

/* Lanes join the streams of their octants, each of which has room for them; their numbers begin with that of the first. Returns
 * those that must go another way. */
RTI_VEC rtk_u32 stream_put(streams *a, rtk_u32 mode, const stream_rays *r, rtk_u32 lanes, rtk_u32 number)
{
    float *ray[RTI_SIMD], *tri[RTI_SIMD], none[8];
    rtk_u32 keys[RTI_SIMD], left = 0u;
    float t[RTI_SIMD], kinds[RTI_SIMD];
    vec start[3];
    vec least = V(abs)(r->inv[0]);
    for (rtk_u32 k = 0u; k < 3u; k++) {
        start[k] = r->org[k] * r->inv[k];
        left |= lanes & ~VM(bits)(V(le)(V(abs)(start[k]), V(set)(BVH_START_MOST)));
        least = V(min)(least, V(abs)(r->inv[k]));
    }
    left |= lanes & ~VM(bits)(V(le)(V(set)(BVH_START_LEAST), least * V(set)(a->part->scale)));
    const stream_axes axes = {V(eq)(r->kind, V(set)(0.0f)), V(eq)(r->kind, V(set)(1.0f))};
    const vec dz = stream_turned(&axes, r->dir[0], r->dir[1], r->dir[2]);
    const vec slabs[8] = {r->inv[0], r->inv[1], r->inv[2], start[0], start[1], start[2], r->t0, V(min)(r->t1, r->t)};
    const vec shear[8] = {stream_turned(&axes, r->org[1], r->org[2], r->org[0]),
                          stream_turned(&axes, r->org[2], r->org[0], r->org[1]),
                          stream_turned(&axes, r->org[0], r->org[1], r->org[2]),
                          stream_turned(&axes, r->dir[1], r->dir[2], r->dir[0]) / dz,
                          stream_turned(&axes, r->dir[2], r->dir[0], r->dir[1]) / dz,
                          dz,
                          r->tmin,
                          r->tmax};
    const vec_whole key = __builtin_convertvector(r->key, vec_whole);
    memcpy(keys, &key, sizeof key);
    V(store)(t, r->t);
    V(store)(kinds, r->kind);
    lanes &= ~left;
    for (rtk_u32 i = 0u; i < RTI_SIMD; i++) {
        if (!(lanes >> i & 1u)) {
            ray[i] = tri[i] = none;
            continue;
        }
        stream *s = &a->of[keys[i] >> 2 & 7u];
        const rtk_u32 to = s->n++;
        ray[i] = s->ray[to].inv;
        tri[i] = &s->tri[to].ox;
        if (!(mode & RTK_MODE_ANY))
            s->hit[to] = (stream_hit){t[i], 0.0f, 0.0f, RTK_INVALID};
        s->kind[to] = kinds[i];
        s->number[to] = number + i;
    }
    stream_records(slabs, ray);
    stream_records(shear, tri);
    return left;
}

/* `rays` of a packet, prepared for the part, join streams. Returns those that must go another way. */
RTI_VEC uint64_t stream_join(streams *a, rtk_u32 mode, const packet *p, uint64_t rays)
{
    uint64_t left = 0u;
    for (uint64_t l = p->masked || p->common == 0u ? rays : 0u; l != 0u; l &= l - 1u) /* those that see nothing */
        rays &= p->mask[__builtin_ctzll(l)] == 0u ? ~(l & (0u - l)) : ~(uint64_t)0u;
    for (rtk_u32 at = 0u; at < PACKET; at += RTI_SIMD) {
        const rtk_u32 lanes = packet_bits(rays, at);
        stream_rays r;
        if (lanes == 0u)
            continue;
        for (rtk_u32 k = 0u; k < 3u; k++) {
            r.org[k] = V(load)(p->org[k] + at);
            r.dir[k] = V(load)(p->dir[k] + at);
            r.inv[k] = V(load)(p->inv[k] + at);
        }
        r.tmin = V(load)(p->tmin + at);
        r.tmax = V(load)(p->tmax + at);
        r.t0 = V(load)(p->t0 + at);
        r.t1 = V(load)(p->t1 + at);
        r.t = V(load)(p->t + at);
        r.kind = V(load)(p->kind + at);
        r.key = V(load)(p->key + at);
        left |= (uint64_t)stream_put(a, mode, &r, lanes, packet_number(p, at)) << at;
    }
    return left;
}

/* RTI_SIMD rays of the batch, `count` of them at most, join streams. again: something was asked for them before, and their hits
 * so far stand in the batch. Returns those that must go by themselves. */
RTI_VEC rtk_u32 stream_load(streams *a, rtk_u32 mode, rtk_u32 number, rtk_u32 count, int again)
{
    const rtk_trace_block *b = &a->blocks[number / RTK_BLOCK];
    const rtk_u32 k = number % RTK_BLOCK;
    packet_rays from;
    stream_rays r;
    vec_bits sees;
    rtk_u32 lanes, far;
    packet_rays_load(&from, b, k);
    memcpy(&sees, b->mask + k, sizeof sees);
    lanes = from.valid & stream_some(sees);
    if (count < RTI_SIMD)
        lanes &= (1u << count) - 1u;
    r.t = from.tmax;
    if (mode & RTK_MODE_ANY) {
        uint16_t *known = &a->occluded[number / RTK_BLOCK];
        if (again)
            lanes &= ~((rtk_u32)*known >> k);
        else
            *known = (uint16_t)(*known & ((1u << k) - 1u));
    } else {
        rtk_hit_block *known = &a->hits[number / RTK_BLOCK];
        if (again) {
            r.t = V(load)(known->t + k);
        } else {
            V(store)(known->t + k, from.tmax);
            V(store)(known->u + k, V(set)(0.0f));
            V(store)(known->v + k, V(set)(0.0f));
            memset(known->prim + k, 0xff, RTI_SIMD * sizeof *known->prim); /* RTK_INVALID */
            memset(known->geom + k, 0xff, RTI_SIMD * sizeof *known->geom);
            memset(known->inst + k, 0xff, RTI_SIMD * sizeof *known->inst);
        }
    }
    for (rtk_u32 i = 0u; i < 3u; i++) {
        r.org[i] = from.org[i];
        r.dir[i] = from.dir[i];
        r.inv[i] = from.inv[i];
    }
    r.tmin = from.tmin;
    r.tmax = from.tmax;
    packet_rays_key(&from, &r.kind, &r.key);
    lanes = packet_rays_enter(r.org, r.inv, r.tmin, r.tmax, lanes, a->part, &r.t0, &r.t1, &far);
    return far | stream_put(a, mode, &r, lanes, number);
}

/* ---- the way ---- */

/* Asks for what the stream's next step reads. */
RTI_VEC void stream_next(const streams *a, const stream *s)
{
    if (s->top != 0u)
        bvh_expect(&a->tree, s->child[s->top - 1u], s->count[s->top - 1u]);
}

/* A step of a stream's way: one list to what it waits for. Returns how many rays stand in a->now that found no room in lists. */
RTI_VEC rtk_u32 stream_step(streams *a, rtk_u32 octant, rtk_u32 mode)
{
    stream *s = &a->of[octant];
    const rtk_u32 top = --s->top, list = s->lists[top], begin = list & 0xffffu, size = list >> 16 & 0x7fffu, at = s->child[top],
                  count = s->count[top];
    const float enter = s->enter[top];
    const uint16_t *ids = s->list + begin;
#ifdef RTI_PACK
    if (list & STREAM_DENSE) {
        rtk_u32 left = 0u;
        if (count != 0u) {
            stream_next(a, s);
            stream_leaf(a, s, mode, stream_still_dense(a, s, ids, size, enter), at, count);
        } else {
            left = stream_step_dense(a, s, mode, octant, &a->tree.bvh[at], begin, size);
            stream_next(a, s);
        }
        return left;
    }
#endif
    if (size == 1u && s->ray[ids[0]].t1 < enter)
        return 0u;
    if (count != 0u) {
        stream_next(a, s);
        stream_leaf(a, s, mode, stream_still(a, s, ids, size, enter), at, count);
        return 0u;
    }
    if (size <= STREAM_FEW) {
        stream_one(a, s, mode, octant, list, at);
        stream_next(a, s);
        return 0u;
    }
    const rtk_bvhnode *n = &a->tree.bvh[at];
    float least[RTK_BVH_WIDTH];
    rtk_u32 there;
    const rtk_u32 all = stream_open(a, s, mode, octant, n, ids, size, least, &there);
    if (begin + (1u + (rtk_u32)__builtin_popcount(all)) * size > a->most) {
        memcpy(a->now, ids, size * sizeof *ids);
        return size;
    }
    if (all != 0u)
        stream_push(a, s, mode, n, all, least, there, ids, size, begin + size); /* its list is read yet */
    stream_next(a, s);
    return 0u;
}

/* All of a stream's rays are at the root. */
RTI_VEC void stream_start(const streams *a, stream *s, rtk_u32 mode)
{
    (void)a;
    (void)mode;
    s->child[0] = s->count[0] = 0u;
    s->enter[0] = -RTK_INF;
    s->top = s->n != 0u;
#ifdef RTI_PACK
    stream_start_dense(s);
    if (mode & RTK_MODE_ANY)
        stream_region(a, s);
#else
    for (rtk_u32 i = 0u; i < s->n; i++)
        s->list[i] = (uint16_t)i;
    s->lists[0] = s->n << 16;
#ifdef RTI_PACK8
    if ((mode & RTK_MODE_ANY) && s->n >= STREAM_REGION)
        stream_region(a, s);
#endif
#endif
}

#endif
