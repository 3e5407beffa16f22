/* How a stream ends (bvh_stream.h): hits that were put aside are decided, as many at a time as vectors have lanes, and all hits
 * go to their places in the batch. */
#ifndef RTI_BVH_STREAM_END_H
#define RTI_BVH_STREAM_END_H

#include "bvh_stream.h"

/* Fields of stream_tri of n rays, no more than vectors hold; lanes behind them hold anything. */
RTI_VEC void stream_shears(const stream *s, const uint16_t *ids, rtk_u32 n, vec out[8])
{
#ifdef RTI_PACK8
    uint16_t all[RTI_SIMD];
    rti_u16_last(all, ids, n);
    V(records)(&s->tri[0].ox, all, out);
#else
    float x[8][RTI_SIMD] = {{0.0f}};
    for (rtk_u32 i = 0u; i < n; i++) {
        const stream_tri *o = &s->tri[ids[i]];
        const float of[8] = {o->ox, o->oy, o->oz, o->sx, o->sy, o->kdz, o->tmin, o->tmax};
        for (rtk_u32 m = 0u; m < 8u; m++)
            x[m][i] = of[m];
    }
    for (rtk_u32 k = 0u; k < 8u; k++)
        out[k] = V(load)(x[k]);
#endif
}

/* Asks for the triangles of n hits that were put aside. */
RTI_VEC void stream_expect(const streams *a, const stream *s, const uint16_t *ids, rtk_u32 n)
{
    for (rtk_u32 i = 0u; i < n; i++) {
        const char *b = (const char *)&a->tree.blocks[s->hit[ids[i]].late / 4u];
        __builtin_prefetch(b);
        __builtin_prefetch(b + 64);
        __builtin_prefetch(b + sizeof(rtk_bvhblock) - 1u);
    }
}

/* Directions along the two axes that are not dominant, and corners of the triangles that were hit, in the rays' order of axes, of
 * n rays, no more than vectors hold. */
RTI_VEC void stream_asides(const streams *a, const stream *s, const uint16_t *ids, rtk_u32 n, vec out[11])
{
#ifdef RTI_PACK
    static const uint16_t rows[16] = {0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30};
    _Alignas(64) float corners[16][16] = {{0.0f}};
    uint16_t all[16];
    rti_u16_last(all, ids, n);
    for (rtk_u32 i = 0u; i < n; i++) {
        const rtk_u32 place = s->hit[ids[i]].late, j = place % 4u;
        const rtk_bvhblock *b = &a->tree.blocks[place / 4u];
        rti_f16_corners(b->v0[0] + j, b->v1[0] + j, b->v2[0] + j, (rtk_u32)s->who[STREAM_WHO(0u) * ids[i]], corners[i]);
    }
    out[0] = V(column)(s->who + 2, STREAM_WHO(0u), all);
    out[1] = V(column)(s->who + 3, STREAM_WHO(0u), all);
    rti_f16_records(corners[0], rows, out + 2);
    out[10] = V(column)(&corners[0][8], 8u, rows);
#else
    rti_f4 of[3][RTI_SIMD]; /* of each ray, as `out` has them */
    vec rows[12];
    for (rtk_u32 i = 0u; i < RTI_SIMD; i++) {
        const rtk_u32 l = ids[i < n ? i : 0u], place = s->hit[l].late, j = place % 4u;
        const float *who = &s->who[STREAM_WHO(0u) * l];
        const rtk_u32 kz = (rtk_u32)who[0], kx = kz == 2u ? 0u : kz + 1u, ky = kx == 2u ? 0u : kx + 1u;
        const rtk_bvhblock *b = &a->tree.blocks[place / 4u];
        of[0][i] = (rti_f4){who[2], who[3], b->v0[kx][j], b->v0[ky][j]};
        of[1][i] = (rti_f4){b->v0[kz][j], b->v1[kx][j], b->v1[ky][j], b->v1[kz][j]};
        of[2][i] = (rti_f4){b->v2[kx][j], b->v2[ky][j], b->v2[kz][j], 0.0f};
    }
    for (rtk_u32 k = 0u; k < 3u; k++) {
#ifdef RTI_PACK8
        const vec four[4] = {rti_f8_both(of[k][0], of[k][4]), rti_f8_both(of[k][1], of[k][5]), rti_f8_both(of[k][2], of[k][6]),
                             rti_f8_both(of[k][3], of[k][7])};
        rti_f8_turn(four, rows + 4u * k);
#else
        rti_f4_turn(of[k], rows + 4u * k);
#endif
    }
    memcpy(out, rows, 11u * sizeof *out);
#endif
}

/* Of n rays, no more than vectors hold, the hits that were put aside. */
static void stream_decide(const streams *a, stream *s, rtk_u32 mode, const uint16_t *ids, rtk_u32 n)
{
    float t[RTI_SIMD], u[RTI_SIMD], v[RTI_SIMD];
    vec r[8], of[11];
    tri_hit hit;
    stream_shears(s, ids, n, r);
    stream_asides(a, s, ids, n, of);
    vec shift = V(set)(0.0f);
    if (mode & STREAM_MOVED) {
        float each[RTI_SIMD] = {0.0f};
        for (rtk_u32 i = 0u; i < n; i++)
            each[i] = s->shift[ids[i]];
        shift = V(load)(each);
    }
    const tri_ray ray = {r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], shift, V(set)(a->part->scale)};
    hit.hit = 0u;
    hit.t = hit.u = hit.v = V(set)(0.0f);
    tri_exact(&ray, &of[0], &of[1], of + 2, of + 5, of + 8, (2u << (n - 1u)) - 1u, &hit);
    V(store)(t, hit.t);
    V(store)(u, hit.u);
    V(store)(v, hit.v);
    for (rtk_u32 i = 0u; i < n; i++) {
        const rtk_u32 l = ids[i];
        if (hit.hit >> i & 1u) {
            s->hit[l].t = t[i];
            stream_ends(s, mode, l, t[i]);
            s->hit[l].u = u[i];
            s->hit[l].v = v[i];
        } else { /* the ray starts or ends on an edge */
            stream_settle(a, s, mode, l);
        }
    }
}

/* Of a stream's rays those that have a hit of their own, aside: that was put aside, to a->now. Returns how many. Which are is not
 * to be foreseen, so there is no branch. */
RTI_VEC rtk_u32 stream_late(streams *a, const stream *s, rtk_u32 mode, int aside)
{
    rtk_u32 n = 0u;
#ifdef RTI_PACK
    for (rtk_u32 i = 0u; i < s->n; i += 16u) {
        const vec late = rti_f16_fourths((const float *)(const void *)&s->hit[i].late), t = rti_f16_fourths(&s->hit[i].t);
        vec_bits place;
        memcpy(&place, &late, sizeof place);
        rtk_u32 bits = packet_some(place ^ RTK_INVALID);
        if (aside)
            bits &= VM(bits)(V(lt)(t, V(load)(mode & STREAM_MOVED ? s->far + i : s->wide[i / 16u][7])));
        if (s->n - i < 16u)
            bits &= (1u << (s->n - i)) - 1u;
        n += rti_u16_count(a->now + n, i, bits);
    }
#else
    for (rtk_u32 i = 0u; i < s->n; i++) {
        a->now[n] = (uint16_t)i;
        n += (rtk_u32)(s->hit[i].late != RTK_INVALID) & (rtk_u32)(!aside || s->hit[i].t < stream_far(s, mode, i));
    }
#endif
    return n;
}

/* The hits of a stream go to their places: each is nearer than what stands there. */
RTI_VEC void stream_end(streams *a, stream *s, rtk_u32 mode)
{
    const rtk_group *g = a->scene->groups;
    rtk_u32 n = stream_late(a, s, mode, 1), first = 0u, count = 0u, geom = 0u;
    stream_expect(a, s, a->now, rtk_umin(n, RTI_SIMD));
    for (rtk_u32 i = 0u; i < n; i += RTI_SIMD) {
        if (n - i > RTI_SIMD)
            stream_expect(a, s, a->now + i + RTI_SIMD, rtk_umin(n - i - RTI_SIMD, RTI_SIMD));
        stream_decide(a, s, mode, a->now + i, rtk_umin(n - i, RTI_SIMD));
    }
    n = stream_late(a, s, mode, 0);
    for (rtk_u32 i = 0u; i < n; i++) {
        const stream_hit *h = &s->hit[a->now[i]];
        const rtk_u32 number = stream_number(s, 0u, a->now[i]), k = number % RTK_BLOCK, ref = a->tree.refs[h->late];
        rtk_hit_block *to = &a->hits[number / RTK_BLOCK];
        if (ref - first >= count) { /* a mesh's triangles stand in their order, side by side */
            const rtk_u32 shapes = ref < g->tri_count ? 0u : g->tri_count; /* before which theirs begin */
            geom = shapes != 0u || g->tri_count == 0u ? g->shapes[ref - g->tri_count].geom : g->tris[ref].geom;
            first = g->geoms[geom].first + shapes;
            count = g->geoms[geom].prim_count;
        }
        to->t[k] = h->t;
        to->u[k] = h->u;
        to->v[k] = h->v;
        to->prim[k] = ref - first;
        to->geom[k] = geom; /* no instance's ray comes here: inst stands as it is */
    }
}

#endif
