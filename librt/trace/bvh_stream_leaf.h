/* What lists of a stream's rays meet in leaves (bvh_stream.h). */
#ifndef RTI_BVH_STREAM_LEAF_H
#define RTI_BVH_STREAM_LEAF_H

#include "bvh_stream_ball.h"

/* Triangles for one ray, two blocks at a time where vectors hold them. */
RTI_VEC void stream_leaf_one(const streams *a, stream *s, rtk_u32 mode, rtk_u32 l, rtk_u32 at, rtk_u32 count)
{
    const rtk_u32 kz = stream_kind(s, mode, l), kx = kz == 2u ? 0u : kz + 1u, ky = kx == 2u ? 0u : kx + 1u;
    const rtk_u32 end = (at + count + 3u) / 4u;
    const stream_tri *o = &s->tri[l];
    const bvh_pairs_ray r = {NODE(set)(o->ox), NODE(set)(o->oy),         NODE(set)(o->oz),   NODE(set)(o->sx),
                             NODE(set)(o->sy), NODE(set)(o->kdz),        NODE(set)(o->tmin), NODE(set)(o->tmax),
                             NODE(set)(stream_shift(s, mode, l)), NODE(set)(a->part->scale)};
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
RTI_VEC int stream_fours_keep(stream *s, rtk_u32 mode, const tri_hit *hit, vec tmax, const rtk_u32 hit_at[4],
                              const rtk_u32 lane[4], rtk_u32 k)
{
    float *ends = mode & STREAM_MOVED ? s->far : &s->ray[0].t1;
    const rtk_u32 step = mode & STREAM_MOVED ? 1u : sizeof *s->ray / sizeof *ends;
    const rtk_u32 end_at[4] = {step * lane[0], step * lane[1], step * lane[2], step * lane[3]};
    const vec best = rti_f16_each(&s->hit[0].t, hit_at), far = rti_f16_each(ends, end_at);
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
    rti_f16_keep4(&s->hit[0].t, ends, hit_at, end_at, take, lo, hit->u, hit->v, V(min)(hi, far), 4u * k);
    for (rtk_u32 i = 0u; i < 4u; i++)
        stream_ends(s, mode, lane[i], stream_far(s, mode, lane[i]));
    return 1;
}

/* The blocks of a leaf for some rays, four rays by four triangles at a time: lane 4 r + t is ray r and triangle t. */
RTI_VEC void stream_leaf_fours(const streams *a, stream *s, rtk_u32 mode, const uint16_t *ids, rtk_u32 n, rtk_u32 at,
                               rtk_u32 count)
{
    const rtk_u32 end = (at + count + 3u) / 4u;
    for (rtk_u32 i = 0u; i < n; i += 4u) {
        const rtk_u32 some = rtk_umin(n - i, 4u);
        rtk_u32 lane[4], eight[4], four[4], who[4];
        vec o[8];
        for (rtk_u32 k = 0u; k < 4u; k++) {
            lane[k] = ids[i + (k < some ? k : 0u)];
            eight[k] = 8u * lane[k];
            four[k] = 4u * lane[k];
            who[k] = STREAM_WHO(mode) * lane[k];
        }
        rti_f16_fields(&s->tri[0].ox, eight, o);
        const vec shift = mode & STREAM_MOVED ? rti_f16_each(s->shift, lane) : V(set)(0.0f);
        const tri_ray r = {o[0], o[1], o[2], o[3], o[4], o[5], o[6], o[7], shift, V(set)(a->part->scale)};
        const rti_i16 z = rti_i16_row(rti_f16_each(s->who, who)), x = rti_i16_next(z), y = rti_i16_next(x);
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
                if (__builtin_expect(stream_fours_keep(s, mode, &hit, r.tmax, four, lane, k), 1))
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

#elif defined RTI_PACK8
/* The blocks of a leaf for some rays, two rays by four triangles at a time: lane 4 r + t is ray r and triangle t. */
RTI_VEC void stream_leaf_twos(const streams *a, stream *s, rtk_u32 mode, const uint16_t *ids, rtk_u32 n, rtk_u32 at,
                              rtk_u32 count)
{
    const rtk_u32 end = (at + count + 3u) / 4u;
    for (rtk_u32 i = 0u; i < n; i += 2u) {
        const rtk_u32 lane[2] = {ids[i], ids[i + (i + 1u < n)]};
        const rtk_u32 z0 = stream_kind(s, mode, lane[0]), x0 = z0 == 2u ? 0u : z0 + 1u, y0 = x0 == 2u ? 0u : x0 + 1u;
        const rtk_u32 z1 = stream_kind(s, mode, lane[1]), x1 = z1 == 2u ? 0u : z1 + 1u, y1 = x1 == 2u ? 0u : x1 + 1u;
        rtk_u32 want = i + 1u < n ? 0xffu : 0x0fu;
        vec o[8];
        const rtk_u32 eight[2] = {8u * lane[0], 8u * lane[1]};
        rti_f8_fields(&s->tri[0].ox, eight, o);
        const vec shift = mode & STREAM_MOVED ? rti_f8_each(s->shift, lane) : V(set)(0.0f);
        const tri_ray r = {o[0], o[1], o[2], o[3], o[4], o[5], o[6], o[7], shift, V(set)(a->part->scale)};
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
RTI_VEC rtk_u32 stream_many_keep(stream *s, rtk_u32 mode, const tri_hit *hit, vec tmax, const uint16_t lane[RTI_SIMD],
                                 rtk_u32 place)
{
    const rtk_u32 known = hit->hit | hit->certain, doubt = known & hit->doubt;
    const vec best = V(column)(&s->hit[0].t, 4u, lane), far = stream_fars(s, mode, lane);
    const vec off = V(select)(VM(of)(doubt), hit->off, V(set)(0.0f)), lo = hit->t - off, hi = hit->t + off;
    const rtk_u32 may = known & ~(doubt & VM(bits)(V(lt)(V(min)(tmax, far), lo)));
    const rtk_u32 between = VM(bits)(V(lt)(lo, hi)) & VM(bits)(V(lt)(lo, far));
    const rtk_u32 take = may & VM(bits)(V(lt)(hi, best)) & (~doubt | between);
    const rtk_u32 left = may & ~take & (VM(bits)(V(le)(lo, far)) | VM(bits)(V(eq)(lo, best)));
    if (take) {
        float kept[RTI_SIMD][4], end[RTI_SIMD], late;
        memcpy(&late, &place, sizeof late);
        V(fours)(lo, hit->u, hit->v, V(set)(late), kept[0], lane_fours);
        V(store)(end, V(min)(hi, far));
        for (rtk_u32 bits = take; bits != 0u; bits &= bits - 1u) {
            const rtk_u32 k = (rtk_u32)__builtin_ctz(bits);
            memcpy(&s->hit[lane[k]], kept[k], sizeof kept[k]);
            stream_ends(s, mode, lane[k], end[k]);
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
        bits = stream_many_keep(s, mode, hit, tmax, lane, place);
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
        const vec shift = mode & STREAM_MOVED ? V(column)(s->shift, 1u, lane) : V(set)(0.0f);
        const tri_ray r = {o[0], o[1], o[2], o[3], o[4], o[5], o[6], o[7], shift, V(set)(a->part->scale)};
        const vec_rows z = VI(rows)(s->who, STREAM_WHO(mode), lane), x = VI(next)(z), rows[3] = {x, VI(next)(x), z};
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
    if (at >= 4u * a->tree.block_count && a->tree.ball_count != 0u) {
        stream_balls(a, s, mode, ids, n, at, count);
        return;
    }
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

#endif
