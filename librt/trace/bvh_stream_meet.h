/* What lists of a stream's rays meet: leaves and nodes (bvh_stream.h). */
#ifndef RTI_BVH_STREAM_MEET_H
#define RTI_BVH_STREAM_MEET_H

#include "bvh_stream.h"

/* ---- leaves ---- */

/* Triangles for one ray, two blocks at a time where vectors hold them. */
RTI_VEC void stream_leaf_one(const streams *a, stream *s, rtk_u32 mode, rtk_u32 l, rtk_u32 at, rtk_u32 count)
{
    const rtk_u32 kz = (rtk_u32)s->kind[l], kx = kz == 2u ? 0u : kz + 1u, ky = kx == 2u ? 0u : kx + 1u;
    const rtk_u32 end = (at + count + 3u) / 4u;
    const stream_tri *o = &s->tri[l];
    const bvh_pairs_ray r = {NODE(set)(o->ox), NODE(set)(o->oy),         NODE(set)(o->oz),   NODE(set)(o->sx),
                             NODE(set)(o->sy), NODE(set)(o->kdz),        NODE(set)(o->tmin), NODE(set)(o->tmax),
                             NODE(set)(0.0f),  NODE(set)(a->part->scale)};
    for (rtk_u32 k = at / 4u; k < end; k += BVH_PAIRS) {
        bvh_pairs_hit hit;
        float t[NODE_N], u[NODE_N], v[NODE_N], off[NODE_N];
        rtk_u32 bits = bvh_pairs(&a->tree, k, at, count, end, kx, ky, kz, &r, &hit);
        if (bits == 0u)
            continue;
        NODE(store)(t, hit.t);
        NODE(store)(u, hit.u);
        NODE(store)(v, hit.v);
        NODE(store)(off, hit.off);
        for (; bits != 0u; bits &= bits - 1u) {
            const rtk_u32 i = (rtk_u32)__builtin_ctz(bits);
            stream_met(a, s, l, mode, 4u * k + i, hit.doubt, hit.certain, t, u, v, off, i);
            if ((mode & RTK_MODE_ANY) && s->ray[l].t1 == -RTK_INF)
                return;
        }
    }
}

#ifdef RTI_PACK
/* What four rays and four triangles give, one by one. */
__attribute__((noinline, unused)) static void stream_fours_each(const streams *a, stream *s, rtk_u32 mode, const tri_hit *hit,
                                                                const rtk_u32 lane[4], rtk_u32 k)
{
    float t[RTI_SIMD], u[RTI_SIMD], v[RTI_SIMD], off[RTI_SIMD];
    V(store)(t, hit->t);
    V(store)(u, hit->u);
    V(store)(v, hit->v);
    V(store)(off, hit->off);
    for (rtk_u32 bits = hit->hit | hit->doubt; bits != 0u; bits &= bits - 1u) {
        const rtk_u32 j = (rtk_u32)__builtin_ctz(bits);
        stream_met(a, s, lane[j / 4u], mode, 4u * k + j % 4u, hit->doubt, hit->certain, t, u, v, off, j);
    }
}

/* What they give in vectors, as stream_take and stream_doubt would: of each ray's hits the nearest is kept, or put aside. false:
 * they must go one by one, as nothing was done, where a hit is not for certain, or lies between a best one's bounds, or two are
 * equally near. tmax: the rays' ends. */
RTI_VEC int stream_fours_keep(stream *s, const tri_hit *hit, vec tmax, const rtk_u32 hit_at[4], const rtk_u32 ray_at[4],
                              rtk_u32 k)
{
    const vec best = rti_f16_each(&s->hit[0].t, hit_at), far = rti_f16_each(&s->ray[0].t1, ray_at);
    const vec off = V(select)(VM(of)(hit->doubt), hit->off, V(set)(0.0f)), lo = hit->t - off, hi = hit->t + off;
    const rtk_u32 out = hit->doubt & VM(bits)(V(lt)(V(min)(tmax, far), lo)), may = (hit->hit | hit->doubt) & ~out;
    const vec least = rti_f16_least4(V(select)(VM(of)(may), lo, V(set)(RTK_INF)));
    const rtk_u32 doubt = hit->doubt & ~out, which = doubt ? may : may & VM(bits)(V(eq)(lo, least));
    const rtk_u32 twice = which & ((which << 1 & 0xeeeeu) | (which << 2 & 0xccccu) | (which << 3 & 0x8888u));
    const rtk_u32 before = which & VM(bits)(V(le)(lo, far));
    rtk_u32 take = which & VM(bits)(V(lt)(hi, best));
    take &= ~(doubt & ~(VM(bits)(V(lt)(lo, hi)) & VM(bits)(V(lt)(lo, far))));
    if (twice | (before ^ take) | (hit->doubt ^ hit->certain))
        return 0;
    rti_f16_keep4(&s->hit[0].t, &s->ray[0].t1, hit_at, ray_at, take, lo, hit->u, hit->v, V(min)(hi, far), 4u * k);
    for (rtk_u32 i = 0u; i < 4u; i++)
        stream_ends(s, hit_at[i] / 4u, s->ray[hit_at[i] / 4u].t1);
    return 1;
}

/* The blocks of a leaf for some rays, four rays by four triangles at a time: lane 4 r + t is ray r and triangle t. */
RTI_VEC void stream_leaf_fours(const streams *a, stream *s, rtk_u32 mode, const uint16_t *ids, rtk_u32 n, rtk_u32 at,
                               rtk_u32 count)
{
    const rtk_u32 end = (at + count + 3u) / 4u;
    for (rtk_u32 i = 0u; i < n; i += 4u) {
        const rtk_u32 some = rtk_umin(n - i, 4u);
        rtk_u32 lane[4], eight[4], four[4];
        vec o[8];
        for (rtk_u32 k = 0u; k < 4u; k++) {
            lane[k] = ids[i + (k < some ? k : 0u)];
            eight[k] = 8u * lane[k];
            four[k] = 4u * lane[k];
        }
        rti_f16_fields(&s->tri[0].ox, eight, o);
        const tri_ray r = {o[0], o[1], o[2], o[3], o[4], o[5], o[6], o[7], V(set)(0.0f), V(set)(a->part->scale)};
        const rti_i16 z = rti_i16_row(rti_f16_each(s->kind, lane)), x = rti_i16_next(z), y = rti_i16_next(x);
        rtk_u32 want = (1u << 4u * some) - 1u;
        for (rtk_u32 k = at / 4u; k < end && want != 0u; k++) {
            const rtk_bvhblock *b = &a->tree.blocks[k];
            const vec a0 = rti_f16_twelve(b->v0[0]), a1 = rti_f16_twelve(b->v1[0]), a2 = rti_f16_twelve(b->v2[0]);
            const vec v0[3] = {rti_f16_take(a0, x), rti_f16_take(a0, y), rti_f16_take(a0, z)};
            const vec v1[3] = {rti_f16_take(a1, x), rti_f16_take(a1, y), rti_f16_take(a1, z)};
            const vec v2[3] = {rti_f16_take(a2, x), rti_f16_take(a2, y), rti_f16_take(a2, z)};
            const rtk_u32 own = bvh_own(k, at, count) * 0x1111u;
            tri_hit hit;
            if (tri_test(&r, v0, v1, v2, want, &hit) == 0u)
                continue;
            hit.hit &= own;
            hit.doubt &= own;
            hit.certain &= own;
            if (!(mode & RTK_MODE_ANY)) {
                if (__builtin_expect(stream_fours_keep(s, &hit, r.tmax, four, eight, k), 1))
                    continue;
            } else if (hit.doubt == hit.certain) {
                for (rtk_u32 m = 0u; m < 4u; m++)
                    if ((hit.hit | hit.doubt) >> (4u * m) & 15u) {
                        stream_done(a, s, lane[m]);
                        want &= ~(15u << 4u * m);
                    }
                continue;
            }
            const tri_hit more = hit; /* of copies: what has its address taken is in no register */
            stream_fours_each(a, s, mode, &more, lane, k);
        }
    }
}

#endif

#if RTI_SIMD == 8 && defined RTI_PACK8
/* The blocks of a leaf for some rays, two rays by four triangles at a time: lane 4 r + t is ray r and triangle t. */
RTI_VEC void stream_leaf_twos(const streams *a, stream *s, rtk_u32 mode, const uint16_t *ids, rtk_u32 n, rtk_u32 at,
                              rtk_u32 count)
{
    const rtk_u32 end = (at + count + 3u) / 4u;
    for (rtk_u32 i = 0u; i < n; i += 2u) {
        const rtk_u32 lane[2] = {ids[i], ids[i + (i + 1u < n)]};
        const rtk_u32 z0 = (rtk_u32)s->kind[lane[0]], x0 = z0 == 2u ? 0u : z0 + 1u, y0 = x0 == 2u ? 0u : x0 + 1u;
        const rtk_u32 z1 = (rtk_u32)s->kind[lane[1]], x1 = z1 == 2u ? 0u : z1 + 1u, y1 = x1 == 2u ? 0u : x1 + 1u;
        rtk_u32 want = i + 1u < n ? 0xffu : 0x0fu;
        vec o[8];
        const rtk_u32 eight[2] = {8u * lane[0], 8u * lane[1]};
        rti_f8_fields(&s->tri[0].ox, eight, o);
        const tri_ray r = {o[0], o[1], o[2], o[3], o[4], o[5], o[6], o[7], V(set)(0.0f), V(set)(a->part->scale)};
        for (rtk_u32 k = at / 4u; k < end && want != 0u; k++) {
            const rtk_bvhblock *b = &a->tree.blocks[k];
#define ROWS(v)                                                                                                                  \
    {                                                                                                                            \
        rti_f8_two(b->v[x0], b->v[x1]), rti_f8_two(b->v[y0], b->v[y1]), rti_f8_two(b->v[z0], b->v[z1])                           \
    }
            const vec v0[3] = ROWS(v0), v1[3] = ROWS(v1), v2[3] = ROWS(v2);
#undef ROWS
            tri_hit hit;
            float t[8], u[8], v[8], off[8];
            rtk_u32 bits = tri_test(&r, v0, v1, v2, want & bvh_own(k, at, count) * 0x11u, &hit);
            if (bits == 0u)
                continue;
            V(store)(t, hit.t);
            V(store)(u, hit.u);
            V(store)(v, hit.v);
            V(store)(off, hit.off);
            for (; bits != 0u; bits &= bits - 1u) {
                const rtk_u32 j = (rtk_u32)__builtin_ctz(bits);
                stream_met(a, s, lane[j / 4u], mode, 4u * k + j % 4u, hit.doubt, hit.certain, t, u, v, off, j);
                if ((mode & RTK_MODE_ANY) && s->ray[lane[j / 4u]].t1 == -RTK_INF) {
                    want &= ~(15u << j / 4u * 4u);
                    bits &= want | (bits & (0u - bits));
                }
            }
        }
    }
}
#endif

#ifdef RTI_PACK8
#define STREAM_SINGLY (RTI_SIMD / 4) /* hits of RTI_SIMD rays with a triangle up to which they are taken one by one */
#define STREAM_SOME   16u            /* triangles that are looked at together */
#if RTI_SIMD >= 16
#define STREAM_MANY 24u /* rays of a leaf from which on RTI_SIMD of them meet a triangle */
#else
#define STREAM_MANY 5u
#endif

/* The corners of a leaf's triangles [first, first + count), STREAM_SOME at most, for rays of different orders of axes. */
typedef struct stream_corners {
#if RTI_SIMD >= 16
    const rtk_bvhblock *blocks;
#else
    rtk_u32 first;
    float at[STREAM_SOME + 4u][3][4]; /* x, y, z, and anything */
#endif
} stream_corners;

RTI_VEC void stream_corners_of(const rtk_tree *tree, rtk_u32 first, rtk_u32 count, stream_corners *c)
{
#if RTI_SIMD >= 16
    (void)first;
    (void)count;
    c->blocks = tree->blocks;
#else
    c->first = first / 4u * 4u;
    for (rtk_u32 k = 0u; c->first + k < first + count; k += 4u) {
        const rtk_bvhblock *b = &tree->blocks[first / 4u + k / 4u];
        const float(*rows[3])[4] = {b->v0, b->v1, b->v2};
        for (rtk_u32 v = 0u; v < 3u; v++) {
            const rti_f4 z = rti_f4_load(rows[v][2]), from[4] = {rti_f4_load(rows[v][0]), rti_f4_load(rows[v][1]), z, z};
            rti_f4 to[4];
            rti_f4_turn(from, to);
            for (rtk_u32 i = 0u; i < 4u; i++)
                rti_f4_store(c->at[k + i][v], to[i]);
        }
    }
#endif
}

/* RTI_SIMD rays, of which those of `want` count, and the triangle at a place: hit, doubt and certain of *hit; without one those
 * whose lines may pass through it. */
RTI_VEC rtk_u32 stream_many_test(const stream_corners *c, const tri_ray *r, const vec_rows rows[3], rtk_u32 place, rtk_u32 want,
                                 tri_hit *hit)
{
#if RTI_SIMD >= 16
    const rtk_bvhblock *b = &c->blocks[place / 4u];
    const rtk_u32 j = place % 4u;
    const vec a[3] = {rti_f16_nine(b->v0[0] + j), rti_f16_nine(b->v1[0] + j), rti_f16_nine(b->v2[0] + j)};
#define CORNER(v, axis) rti_f16_take(a[v], rows[axis])
#else
    const float(*a)[4] = c->at[place - c->first];
#define CORNER(v, axis) rti_f8_corner(a[v], rows[axis])
#endif
    const vec v0[3] = {CORNER(0, 0), CORNER(0, 1), CORNER(0, 2)};
    const vec v1[3] = {CORNER(1, 0), CORNER(1, 1), CORNER(1, 2)};
    const vec v2[3] = {CORNER(2, 0), CORNER(2, 1), CORNER(2, 2)};
#undef CORNER
    return hit ? tri_test(r, v0, v1, v2, want, hit) : tri_inside(r, v0, v1, v2, want);
}

/* What RTI_SIMD rays, which are different ones where they count, and the triangle at a place give in vectors, as stream_take and
 * stream_doubt would. Returns the rays for which nothing was done, as they must go one by one: where a hit is not for certain,
 * lies between the best one's bounds, or is as near. */
RTI_VEC rtk_u32 stream_many_keep(stream *s, const tri_hit *hit, vec tmax, const uint16_t lane[RTI_SIMD], rtk_u32 place)
{
    const rtk_u32 known = hit->hit | hit->certain, doubt = known & hit->doubt;
    const vec best = V(column)(&s->hit[0].t, 4u, lane), far = V(column)(&s->ray[0].t1, 8u, lane);
    const vec off = V(select)(VM(of)(doubt), hit->off, V(set)(0.0f)), lo = hit->t - off, hi = hit->t + off;
    const rtk_u32 may = known & ~(doubt & VM(bits)(V(lt)(V(min)(tmax, far), lo)));
    const rtk_u32 between = VM(bits)(V(lt)(lo, hi)) & VM(bits)(V(lt)(lo, far));
    const rtk_u32 take = may & VM(bits)(V(lt)(hi, best)) & (~doubt | between);
    const rtk_u32 left = may & ~take & (VM(bits)(V(le)(lo, far)) | VM(bits)(V(eq)(lo, best)));
    if (take) {
        float kept[RTI_SIMD][4], end[RTI_SIMD], late;
        memcpy(&late, &place, sizeof late);
        V(fours)(lo, hit->u, hit->v, V(set)(late), kept);
        V(store)(end, V(min)(hi, far));
        for (rtk_u32 bits = take; bits != 0u; bits &= bits - 1u) {
            const rtk_u32 k = (rtk_u32)__builtin_ctz(bits);
            memcpy(&s->hit[lane[k]], kept[k], sizeof kept[k]);
            stream_ends(s, lane[k], end[k]);
        }
    }
    return left | (hit->doubt & ~known);
}

/* RTI_SIMD rays for which the leaf test says what is in *hit of the triangle at a place. Returns those that need no more. */
RTI_VEC rtk_u32 stream_many_met(const streams *a, stream *s, rtk_u32 mode, const tri_hit *hit, vec tmax,
                                const uint16_t lane[RTI_SIMD], rtk_u32 place)
{
    rtk_u32 bits = hit->hit | hit->doubt;
    if ((mode & RTK_MODE_ANY) && hit->doubt == hit->certain) {
        for (rtk_u32 b = bits; b != 0u; b &= b - 1u)
            stream_done(a, s, lane[__builtin_ctz(b)]);
        return bits;
    }
    if (!(mode & RTK_MODE_ANY) && __builtin_popcount(bits) > STREAM_SINGLY) {
        __builtin_prefetch(&a->tree.refs[place]);
        bits = stream_many_keep(s, hit, tmax, lane, place);
    }
    if (__builtin_expect(bits != 0u, 0)) {
        float t[RTI_SIMD], u[RTI_SIMD], v[RTI_SIMD], off[RTI_SIMD];
        V(store)(t, hit->t);
        V(store)(u, hit->u);
        V(store)(v, hit->v);
        V(store)(off, hit->off);
        for (; bits != 0u; bits &= bits - 1u) {
            const rtk_u32 k = (rtk_u32)__builtin_ctz(bits);
            stream_met(a, s, lane[k], mode, place, hit->doubt, hit->certain, t, u, v, off, k);
        }
    }
    return 0u;
}

/* The triangles [first, first + count) of a leaf, STREAM_SOME at most, for many rays, RTI_SIMD rays by one triangle at a time.
 * For any hit first which rays' lines pass through which triangles, without a branch, as that is not to be foreseen, then what
 * comes of those. */
RTI_VEC void stream_leaf_some(const streams *a, stream *s, rtk_u32 mode, const uint16_t *ids, rtk_u32 n, rtk_u32 first,
                              rtk_u32 count)
{
    stream_corners corners;
    stream_corners_of(&a->tree, first, count, &corners);
    for (rtk_u32 i = 0u; i < n; i += RTI_SIMD) {
        rtk_u32 live = n - i < RTI_SIMD ? (1u << (n - i)) - 1u : LANES_ALL;
        const uint16_t *lane = ids + i;
        uint16_t last[RTI_SIMD];
        vec o[8];
        if (n - i < RTI_SIMD) {
            rti_u16_last(last, ids + i, n - i);
            lane = last;
        }
        V(records)(&s->tri[0].ox, lane, o);
        const tri_ray r = {o[0], o[1], o[2], o[3], o[4], o[5], o[6], o[7], V(set)(0.0f), V(set)(a->part->scale)};
        const vec_rows z = VI(rows)(s->kind, lane), x = VI(next)(z), rows[3] = {x, VI(next)(x), z};
        if (!(mode & RTK_MODE_ANY)) {
            for (rtk_u32 place = first; place < first + count; place++) {
                tri_hit hit;
                if (stream_many_test(&corners, &r, rows, place, live, &hit) != 0u)
                    stream_many_met(a, s, mode, &hit, r.tmax, lane, place);
            }
            continue;
        }
        rtk_u32 inside[STREAM_SOME], places[STREAM_SOME], some = 0u;
        for (rtk_u32 place = first; place < first + count; place++) {
            inside[some] = stream_many_test(&corners, &r, rows, place, live, NULL);
            places[some] = place;
            some += inside[some] != 0u;
        }
        for (rtk_u32 m = 0u; m < some; m++) {
            tri_hit hit;
            if (stream_many_test(&corners, &r, rows, places[m], inside[m] & live, &hit) != 0u)
                live &= ~stream_many_met(a, s, mode, &hit, r.tmax, lane, places[m]);
        }
    }
}
#endif

/* Of a list, the rays that have found no hit before `enter` since, to a->now. Returns how many. */
RTI_VEC rtk_u32 stream_still(streams *a, const stream *s, const uint16_t *list, rtk_u32 size, float enter)
{
    rtk_u32 n = 0u;
    for (rtk_u32 i = 0u; i < size; i++) {
        a->now[n] = list[i];
        n += s->ray[list[i]].t1 >= enter;
    }
    return n;
}

/* A leaf for n rays of a->now. */
RTI_VEC void stream_leaf(streams *a, stream *s, rtk_u32 mode, rtk_u32 n, rtk_u32 at, rtk_u32 count)
{
    const uint16_t *ids = a->now;
    if (at >= 4u * a->tree.block_count) {
        for (rtk_u32 i = 0u; i < n; i++)
            for (rtk_u32 k = 0u; k < count && s->ray[ids[i]].t1 != -RTK_INF; k++)
                stream_ask(a, s, ids[i], mode, a->tree.refs[at + k]);
        return;
    }
#ifdef RTI_PACK8
    if (n >= STREAM_MANY) {
        for (rtk_u32 k = 0u; k < count; k += STREAM_SOME)
            stream_leaf_some(a, s, mode, ids, n, at + k, rtk_umin(count - k, STREAM_SOME));
        return;
    }
    if (n > 1u) {
#if RTI_SIMD >= 16
        stream_leaf_fours(a, s, mode, ids, n, at, count);
#else
        stream_leaf_twos(a, s, mode, ids, n, at, count);
#endif
        return;
    }
#endif
    for (rtk_u32 i = 0u; i < n; i++)
        stream_leaf_one(a, s, mode, ids[i], at, count);
}

/* ---- nodes ---- */

#ifdef RTI_PACK
/* The rows of a node's planes that an octant's rays meet first, and last, along each axis. */
typedef struct stream_planes {
    const float *near[3], *far[3];
} stream_planes;

RTI_VEC stream_planes stream_planes_of(const rtk_bvhnode *n, rtk_u32 octant)
{
    const rtk_u32 x = octant & 1u, y = octant >> 1 & 1u, z = octant >> 2 & 1u;
    return (stream_planes){{n->box[0][x], n->box[1][y], n->box[2][z]}, {n->box[0][1u - x], n->box[1][1u - y], n->box[2][1u - z]}};
}

/* Where the first of a list's rays enters each slot, in lanes: before one is looked at; and the least of all lanes at the end.
 * Any hit needs no order. */
RTI_VEC void stream_lows_begin(rtk_u32 mode, vec low[RTK_BVH_WIDTH])
{
    for (rtk_u32 i = 0u; i < RTK_BVH_WIDTH; i++)
        low[i] = V(set)(mode & RTK_MODE_ANY ? STREAM_FRONT : RTK_INF);
}
RTI_VEC void stream_lows_end(rtk_u32 mode, const vec low[RTK_BVH_WIDTH], float least[RTK_BVH_WIDTH])
{
    rti_f8_store(least, mode & RTK_MODE_ANY ? rti_f8_set(STREAM_FRONT) : rti_f16_lows8(low));
}

/* Sixteen rays, fields of stream_ray, against all slots of a node: those of `of` that enter slot i to to[i], and where the first
 * of each lane does to low[i]. */
RTI_VEC void stream_open_sixteen(rtk_u32 mode, const stream_planes *planes, const vec r[8], rtk_u32 of, uint16_t *to,
                                 vec low[RTK_BVH_WIDTH])
{
#pragma GCC unroll 8
    for (rtk_u32 i = 0u; i < RTK_BVH_WIDTH; i++) {
#define PLANE(side, axis) V(msub)(V(set)(planes->side[axis][i]), r[axis], r[3 + axis])
        const vec t0 = V(max)(V(max)(PLANE(near, 0), PLANE(near, 1)), V(max)(PLANE(near, 2), r[6]));
        const vec t1 = V(min)(V(min)(PLANE(far, 0), PLANE(far, 1)), V(min)(PLANE(far, 2), r[7]));
#undef PLANE
        const rtk_u32 bits = VM(bits)(V(le)(t0, t1)) & of;
        to[i * STREAM_SLOTS] = (uint16_t)bits;
        if (!(mode & RTK_MODE_ANY))
            low[i] = V(min)(low[i], V(select)(VM(of)(bits), t0, low[i]));
    }
}

/* The slots of a node that some of its `size` masks each have; rays: how many bits those have. */
RTI_VEC rtk_u32 stream_entered(const streams *a, const rtk_bvhnode *n, rtk_u32 size, rtk_u32 rays[RTK_BVH_WIDTH])
{
    rtk_u32 all = 0u;
    for (rtk_u32 i = 0u; i < RTK_BVH_WIDTH; i++) {
        rays[i] = 0u;
        for (rtk_u32 k = 0u; k < size; k += 4u) {
            uint64_t four;
            memcpy(&four, a->slots[i] + k, sizeof four);
            if (size - k < 4u)
                four &= ((uint64_t)1u << 16u * (size - k)) - 1u;
            rays[i] += (rtk_u32)__builtin_popcountll(four);
        }
        all |= (rtk_u32)(rays[i] != 0u) << i;
    }
    return all & node_bits(NODE(le)(NODE(load)(n->box[0][0]), NODE(load)(n->box[0][1]))); /* empty ones are inside out */
}

/* stream_open for many rays. */
RTI_VEC rtk_u32 stream_open_many(streams *a, const stream *s, rtk_u32 mode, rtk_u32 octant, const rtk_bvhnode *n,
                                 const uint16_t *ids, rtk_u32 size, float least[RTK_BVH_WIDTH])
{
    const stream_planes planes = stream_planes_of(n, octant);
    rtk_u32 rays[RTK_BVH_WIDTH];
    vec low[RTK_BVH_WIDTH];
    stream_lows_begin(mode, low);
    for (rtk_u32 at = 0u; at < size; at += 16u) {
        uint16_t last[16];
        const uint16_t *some = ids + at;
        rtk_u32 of = 0xffffu;
        vec r[8];
        if (size - at < 16u) { /* and one of them again */
            rti_u16_last(last, ids + at, size - at);
            some = last;
            of = (1u << (size - at)) - 1u;
        }
        rti_f16_records(s->ray[0].inv, some, r);
        stream_open_sixteen(mode, &planes, r, of, &a->slots[0][at / 16u], low);
    }
    stream_lows_end(mode, low, least);
    return stream_entered(a, n, (size + 15u) / 16u, rays);
}
#endif

/* Which of a list's rays enter which slots: bits of each; least: where the first of them enters each. Returns all bits. */
RTI_VEC rtk_u32 stream_open(streams *a, const stream *s, rtk_u32 mode, rtk_u32 octant, const rtk_bvhnode *n, const uint16_t *ids,
                            rtk_u32 size, float least[RTK_BVH_WIDTH])
{
#ifdef RTI_PACK
    if (size >= STREAM_TURNED)
        return stream_open_many(a, s, mode, octant, n, ids, size, least);
#endif
    enum { HALVES = RTK_BVH_WIDTH / NODE_N };
    bvh_vec near[3][HALVES], far[3][HALVES], low[HALVES];
    rtk_u32 all = 0u;
    for (rtk_u32 k = 0u; k < 3u; k++) {
        const rtk_u32 back = octant >> k & 1u;
        for (rtk_u32 h = 0u; h < HALVES; h++) {
            near[k][h] = NODE(load)(n->box[k][back] + h * NODE_N);
            far[k][h] = NODE(load)(n->box[k][1u - back] + h * NODE_N);
        }
    }
    for (rtk_u32 h = 0u; h < HALVES; h++)
        low[h] = NODE(set)(mode & RTK_MODE_ANY ? STREAM_FRONT : RTK_INF); /* any hit needs no order */
    for (rtk_u32 i = 0u; i < size; i++) {
        const stream_ray *r = &s->ray[ids[i]];
        rtk_u32 bits = 0u;
        for (rtk_u32 h = 0u; h < HALVES; h++) {
            const bvh_vec ix = NODE(set)(r->inv[0]), iy = NODE(set)(r->inv[1]), iz = NODE(set)(r->inv[2]);
            const bvh_vec sx = NODE(set)(r->start[0]), sy = NODE(set)(r->start[1]), sz = NODE(set)(r->start[2]);
            const bvh_vec t0 = NODE(max)(NODE(max)(NODE(msub)(near[0][h], ix, sx), NODE(msub)(near[1][h], iy, sy)),
                                         NODE(max)(NODE(msub)(near[2][h], iz, sz), NODE(set)(r->t0)));
            const bvh_vec t1 = NODE(min)(NODE(min)(NODE(msub)(far[0][h], ix, sx), NODE(msub)(far[1][h], iy, sy)),
                                         NODE(min)(NODE(msub)(far[2][h], iz, sz), NODE(set)(r->t1)));
            if (!(mode & RTK_MODE_ANY))
                low[h] = NODE(min)(low[h], NODE(select)(NODE(le)(t0, t1), t0, low[h]));
            bits |= node_bits(NODE(le)(t0, t1)) << h * NODE_N;
        }
        a->bits[i] = (uint8_t)bits;
        all |= bits;
    }
    for (rtk_u32 h = 0u; h < HALVES; h++)
        NODE(store)(least + h * NODE_N, low[h]);
    return all;
}

/* The numbers in the list of a slot: of `size` of ids those with its bit. Returns how many. */
RTI_VEC rtk_u32 stream_deal(const streams *a, uint16_t *to, const uint16_t *ids, rtk_u32 size, rtk_u32 slot)
{
    rtk_u32 end = 0u;
#ifdef RTI_PACK
    if (size < STREAM_TURNED)
        return rti_u16_deal(to, ids, rti_b16_load(a->bits), slot, size);
    for (rtk_u32 from = 0u; from < size; from += 32u) {
        rtk_u32 b;
        memcpy(&b, &a->slots[slot][from / 16u], sizeof b);
        end += rti_u16_put32(to + end, ids + from, size - from < 32u ? b & ((1u << (size - from)) - 1u) : b);
    }
#elif defined RTI_PACK8
    for (rtk_u32 from = 0u; from < size; from += 16u)
        end += rti_u16_deal(to + end, ids + from, rti_b16_load(a->bits + from), slot, size - from);
#else
    for (rtk_u32 from = 0u; from < size; from++) {
        to[end] = ids[from];
        end += a->bits[from] >> slot & 1u;
    }
#endif
    return end;
}

/* The slots `all` of a node onto the stack, the nearest on top, without their lists: s->top stays. slots: which they are, in that
 * order. */
RTI_VEC void stream_slots(stream *s, rtk_u32 mode, const rtk_bvhnode *n, rtk_u32 all, const float least[RTK_BVH_WIDTH],
                          rtk_u32 slots[RTK_BVH_WIDTH])
{
#ifdef RTI_PACK8
    static const float in_order[RTK_BVH_WIDTH] = {0.0f, 1.0f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f, 7.0f};
    if (mode & RTK_MODE_ANY) { /* slots in their order, which is fair (kernel/bvh.h) */
        rti_f8_sorted(s->enter + s->top, slots, all, rti_f8_load(in_order));
        rti_f8_store(s->enter + s->top, rti_f8_load(least));
    } else {
        rti_f8_sorted(s->enter + s->top, slots, all, rti_f8_load(least));
    }
    rti_u8_take(s->child + s->top, n->child, slots);
    rti_u8_take(s->count + s->top, n->count, slots);
#else
    rtk_u32 count = 0u;
    for (; all != 0u; all &= all - 1u) {
        const rtk_u32 i = (rtk_u32)__builtin_ctz(all);
        rtk_u32 to = count++;
        for (; to > 0u && (mode & RTK_MODE_ANY || least[slots[to - 1u]] < least[i]); to--)
            slots[to] = slots[to - 1u];
        slots[to] = i;
    }
    for (rtk_u32 k = 0u; k < count; k++) {
        s->child[s->top + k] = n->child[slots[k]];
        s->count[s->top + k] = n->count[slots[k]];
        s->enter[s->top + k] = least[slots[k]];
    }
#endif
}

/* The slots `all` of a node onto the stack, with the lists of those of `size` rays that enter them, from `used` on. */
RTI_VEC void stream_push(const streams *a, stream *s, rtk_u32 mode, const rtk_bvhnode *n, rtk_u32 all,
                         const float least[RTK_BVH_WIDTH], const uint16_t *ids, rtk_u32 size, rtk_u32 used)
{
    rtk_u32 slots[RTK_BVH_WIDTH];
    const rtk_u32 count = (rtk_u32)__builtin_popcount(all);
    stream_slots(s, mode, n, all, least, slots);
    for (rtk_u32 k = 0u; k < count; k++) {
        const rtk_u32 some = stream_deal(a, s->list + used, ids, size, slots[k]);
        s->lists[s->top++] = used | some << 16;
        used += some;
    }
}

/* A ray that is alone in its list, from a node on: it goes into the nearest of its slots at once, the others wait. */
RTI_VEC void stream_one(streams *a, stream *s, rtk_u32 mode, rtk_u32 octant, rtk_u32 list, rtk_u32 at)
{
    const rtk_u32 l = s->list[list & 0xffffu];
    const stream_ray *r = &s->ray[l];
    for (;;) {
        const rtk_bvhnode *n = &a->tree.bvh[at];
        float t[RTK_BVH_WIDTH];
        rtk_u32 bits = 0u, i, count, top = s->top;
        for (rtk_u32 h = 0u; h < RTK_BVH_WIDTH; h += NODE_N) {
            const bvh_vec ix = NODE(set)(r->inv[0]), iy = NODE(set)(r->inv[1]), iz = NODE(set)(r->inv[2]);
            const bvh_vec sx = NODE(set)(r->start[0]), sy = NODE(set)(r->start[1]), sz = NODE(set)(r->start[2]);
            const rtk_u32 x = octant & 1u, y = octant >> 1 & 1u, z = octant >> 2 & 1u;
#define ROW(axis, side) NODE(load)(n->box[axis][side] + h)
            const bvh_vec t0 = NODE(max)(NODE(max)(NODE(msub)(ROW(0, x), ix, sx), NODE(msub)(ROW(1, y), iy, sy)),
                                         NODE(max)(NODE(msub)(ROW(2, z), iz, sz), NODE(set)(r->t0)));
            const bvh_vec t1 = NODE(min)(NODE(min)(NODE(msub)(ROW(0, 1u - x), ix, sx), NODE(msub)(ROW(1, 1u - y), iy, sy)),
                                         NODE(min)(NODE(msub)(ROW(2, 1u - z), iz, sz), NODE(set)(r->t1)));
#undef ROW
            NODE(store)(t + h, t0);
            bits |= node_bits(NODE(le)(t0, t1)) << h;
        }
        if (bits == 0u)
            return;
        i = bvh_choose(n, bits, t, s->enter, s->child, s->count, &s->top);
        for (; top < s->top; top++)
            s->lists[top] = list;
        at = n->child[i];
        count = n->count[i];
        if (a->turns) { /* while others have theirs, what comes next is on its way */
            s->child[s->top] = at;
            s->count[s->top] = count;
            s->enter[s->top] = t[i];
            s->lists[s->top++] = list;
            return;
        }
        if (count != 0u) {
            if (at < 4u * a->tree.block_count)
                stream_leaf_one(a, s, mode, l, at, count);
            else
                stream_leaf(a, s, mode, stream_still(a, s, s->list + (list & 0xffffu), 1u, t[i]), at, count);
            return;
        }
    }
}

#endif
