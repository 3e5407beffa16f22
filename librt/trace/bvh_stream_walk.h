/* How rays come into streams, and a stream's way through a tree (bvh_stream.h). */
#ifndef RTI_BVH_STREAM_WALK_H
#define RTI_BVH_STREAM_WALK_H

#include "bvh_approach.h"
#include "bvh_stream_dense.h"
#include "bvh_stream_end.h"
#include "bvh_stream_mix.h"

/* ---- rays ---- */

typedef struct stream_axes {
    vmask first, second;
} stream_axes;

/* Of each lane the component along its dominant axis: x, y or z. */
RTI_VEC vec stream_turned(const stream_axes *a, vec x, vec y, vec z)
{
    return V(select)(a->first, x, V(select)(a->second, y, z));
}

/* Where lanes' records stand in streams: so many words behind the first octant's first record of eight, of four, of two and of
 * one. */
typedef struct stream_places {
    rtk_u32 eight[RTI_SIMD], four[RTI_SIMD], two[RTI_SIMD], one[RTI_SIMD];
} stream_places;

#define STREAM_WORDS (rtk_u32)(sizeof(stream) / sizeof(float))

/* Words as lanes. */
RTI_VEC vec stream_vec(vec_bits a)
{
    vec x;
    memcpy(&x, &a, sizeof x);
    return x;
}

/* `lanes` join the streams `which`, mixed ones one of them, with room for them; the others' places are behind all rays. */
RTI_VEC void stream_places_of(streams *a, vec_whole which, rtk_u32 lanes, stream_places *p)
{
#ifdef RTI_PACK8
    const vmask some = VM(of)(lanes);
    const vec_bits behind = (vec_bits){0u} + STREAM;
    vec_bits first = (vec_bits)which * STREAM_WORDS, to;
    vec_rows rows;
    vec x;
    if (a->mixed) {
        const rtk_u32 of = (rtk_u32)which[0], had = a->next[of];
        rows = VI(ranks)(lanes);
        memcpy(&to, &rows, sizeof to);
        to += had;
        a->next[of] = had + (rtk_u32)__builtin_popcount(lanes);
    } else {
        memcpy(&rows, &which, sizeof rows);
        rows = VI(places)(rows, lanes, a->next);
        memcpy(&to, &rows, sizeof to);
    }
    x = V(select)(some, stream_vec(to), stream_vec(behind));
    memcpy(&to, &x, sizeof to);
    x = V(select)(some, stream_vec(first), V(set)(0.0f));
    memcpy(&first, &x, sizeof first);
    const vec_bits eight = first + to * 8u, four = first + to * 4u, two = first + to * 2u, one = first + to;
    memcpy(p->eight, &eight, sizeof eight);
    memcpy(p->four, &four, sizeof four);
    memcpy(p->two, &two, sizeof two);
    memcpy(p->one, &one, sizeof one);
#else
    for (rtk_u32 i = 0u; i < RTI_SIMD; i++) {
        const rtk_u32 live = lanes >> i & 1u, of = (rtk_u32)which[i];
        const rtk_u32 first = live ? of * STREAM_WORDS : 0u, to = live ? a->next[of]++ : STREAM;
        p->eight[i] = first + to * 8u;
        p->four[i] = first + to * 4u;
        p->two[i] = first + to * 2u;
        p->one[i] = first + to;
    }
#endif
}

#ifdef RTI_PACK8
#define stream_eights V(spread)
#define stream_fours  V(fours)
#define stream_twos   V(twos)
#else
/* Rows of numbers, of RTI_SIMD rays, as their records. */
RTI_VEC void stream_fours(vec a, vec b, vec c, vec d, float *to, const rtk_u32 at[RTI_SIMD])
{
    const rti_f4 rows[4] = {a, b, c, d};
    rti_f4 turned[4];
    rti_f4_turn(rows, turned);
    for (rtk_u32 i = 0u; i < 4u; i++)
        rti_f4_store(to + at[i], turned[i]);
}
RTI_VEC void stream_eights(const vec in[8], float *to, const rtk_u32 at[RTI_SIMD])
{
    stream_fours(in[0], in[1], in[2], in[3], to, at);
    stream_fours(in[4], in[5], in[6], in[7], to + 4, at);
}
RTI_VEC void stream_twos(vec a, vec b, float *to, const rtk_u32 at[RTI_SIMD])
{
    for (rtk_u32 i = 0u; i < 4u; i++) {
        const float both[2] = {a[i], b[i]};
        memcpy(to + at[i], both, sizeof both);
    }
}
#endif

/* RTI_SIMD rays prepared for the part. t: of their best hits; kind, key: as of a packet; shift: STREAM_MOVED. */
typedef struct stream_rays {
    vec org[3], dir[3], inv[3], tmin, tmax, t0, t1, t, kind, key, shift;
} stream_rays;

/* stream_reach of many rays. */
RTI_VEC vec stream_reaches(vec t, vec shift)
{
    return (t - shift) + V(set)(STREAM_REACH) * (V(abs)(t) + V(abs)(shift));
}

/* Of RTI_SIMD rays those that enter a slot of the tree's root. end: no farther than this. */
RTI_VEC rtk_u32 stream_enters(const streams *a, const stream_rays *r, const vec start[3], vec end, rtk_u32 lanes)
{
    const vec size[3] = {V(abs)(r->inv[0]), V(abs)(r->inv[1]), V(abs)(r->inv[2])};
    rtk_u32 some = 0u;
    for (rtk_u32 i = 0u; i < a->roots && some != lanes; i++) {
        vec in = r->t0, out = end;
        for (rtk_u32 k = 0u; k < 3u; k++) {
            const vec m = V(msub)(V(set)(a->middle[k][i]), r->inv[k], start[k]), off = V(set)(a->half[k][i]) * size[k];
            in = V(max)(in, m - off);
            out = V(min)(out, m + off);
        }
        some |= lanes & VM(bits)(V(le)(in, out));
    }
    return some;
}

/* Is it asked whether rays enter a slot of the root, before they are put anywhere? As long as one of four does not. */
RTI_VEC int stream_asks_root(const streams *a)
{
    return a->middles && 4u * (a->missed + 32u) >= a->looked;
}

/* Lanes join streams, each of which has room for them; their numbers begin with that of the first. Returns
 * those that must go another way. */
RTI_VEC rtk_u32 stream_put(streams *a, rtk_u32 mode, const stream_rays *r, rtk_u32 lanes, rtk_u32 number)
{
    rtk_u32 left = 0u;
    vec start[3];
    vec least = V(abs)(r->inv[0]);
    for (rtk_u32 k = 0u; k < 3u; k++) {
        start[k] = r->org[k] * r->inv[k];
        left |= lanes & ~VM(bits)(V(le)(V(abs)(start[k]), V(set)(BVH_START_MOST)));
        least = V(min)(least, V(abs)(r->inv[k]));
    }
    left |= lanes & ~VM(bits)(V(le)(V(set)(BVH_START_LEAST), least * V(set)(a->part->scale)));
    lanes &= ~left;
    const vec end = V(min)(r->t1, mode & STREAM_MOVED ? stream_reaches(r->t, r->shift) : r->t);
    if (stream_asks_root(a)) {
        const rtk_u32 enter = stream_enters(a, r, start, end, lanes);
        a->looked += (rtk_u32)__builtin_popcount(lanes);
        a->missed += (rtk_u32)__builtin_popcount(lanes & ~enter);
        lanes = enter;
    }
    if (lanes == 0u)
        return left;
    const stream_axes axes = {V(eq)(r->kind, V(set)(0.0f)), V(eq)(r->kind, V(set)(1.0f))};
    const vec dx = stream_turned(&axes, r->dir[1], r->dir[2], r->dir[0]),
              dy = stream_turned(&axes, r->dir[2], r->dir[0], r->dir[1]);
    const vec dz = stream_turned(&axes, r->dir[0], r->dir[1], r->dir[2]);
    const vec slabs[8] = {r->inv[0], r->inv[1], r->inv[2], start[0], start[1], start[2], r->t0, end};
    const vec shear[8] = {stream_turned(&axes, r->org[1], r->org[2], r->org[0]),
                          stream_turned(&axes, r->org[2], r->org[0], r->org[1]),
                          stream_turned(&axes, r->org[0], r->org[1], r->org[2]),
                          dx / dz,
                          dy / dz,
                          dz,
                          r->tmin,
                          r->tmax};
    stream_places to;
    vec_bits numbers;
    vec_whole which = __builtin_convertvector(r->key, vec_whole) >> 2 & 7;
    if (a->mixed) {
        const rtk_u32 of = number >> a->shift & 7u;
        which = (vec_whole){0} + (int32_t)of;
#ifdef RTI_PACK8
        if (mode & RTK_MODE_ANY)
            stream_region_more(&a->of[of], r->org, r->dir, r->t0, end, lanes, a->next[of] == 0u);
#endif
    }
    stream_places_of(a, which, lanes, &to);
    memcpy(&numbers, lane_ones, sizeof numbers);
    numbers += number;
    stream_eights(slabs, a->of[0].ray[0].inv, to.eight);
    if (a->tree.block_count != 0u)
        stream_eights(shear, &a->of[0].tri[0].ox, to.eight);
    if (a->tree.ball_count != 0u) {
        const vec ball[8] = {r->org[0], r->org[1], r->org[2], r->dir[0], r->dir[1], r->dir[2], r->tmin, r->tmax};
        stream_eights(ball, &a->of[0].ball[0].ox, to.eight);
    }
    float *const far = a->of[0].far, *const shift = a->of[0].shift; /* octants' stand one behind the other */
    for (rtk_u32 i = 0u; mode & STREAM_MOVED && i < RTI_SIMD; i++) {
        far[to.one[i]] = r->t[i];
        shift[to.one[i]] = r->shift[i];
    }
    if (mode & RTK_MODE_ANY) {
        stream_twos(r->kind, stream_vec(numbers), a->of[0].who, to.two);
    } else {
        stream_fours(r->kind, stream_vec(numbers), dx, dy, a->of[0].who, to.four);
        stream_fours(r->t, V(set)(0.0f), V(set)(0.0f), V(set)(rtk_float(RTK_INVALID)), &a->of[0].hit[0].t, to.four);
    }
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

/* Which parts behind the first some of RTI_SIMD rays may enter: packet_rays_pass asks for a box that holds the part's, wherever a
 * ray starts, so who misses that does not enter the part. */
RTI_VEC void stream_tell(streams *a, const stream_rays *r, rtk_u32 lanes, rtk_u32 number)
{
    const rtk_group *g = a->scene->groups;
    rtk_u32 parts = 0u;
    for (rtk_u32 k = 1u; k < g->part_count; k++) {
        const rtk_part *part = &g->parts[k];
        const float lo[3] = {part->lo.x, part->lo.y, part->lo.z}, hi[3] = {part->hi.x, part->hi.y, part->hi.z};
        parts |= (rtk_u32)((lanes & ~packet_rays_pass(r->org, r->inv, r->tmin, lo, hi, part->scale)) != 0u) << k;
    }
    a->enters[number / RTI_SIMD] = (uint8_t)parts;
    a->told = number + RTI_SIMD;
    a->spared += parts != (2u << (g->part_count - 1u)) - 2u;
}

/* Is that worth it, for the rays from this one on? Bounces in a room enter all that is in it. */
RTI_VEC int stream_tells(const streams *a, rtk_u32 number)
{
    return a->scene->groups->part_count > 1u && number == a->told && number < STREAM_TOLD &&
           a->spared >= number / RTI_SIMD / STREAM_SPARED;
}

/* Of `lanes` of RTI_SIMD rays from ray `number` on those that enter the part, with what the streams know of them there; far:
 * those that start too far away for this. */
RTI_VEC rtk_u32 stream_prepare(const streams *a, rtk_u32 mode, const packet_rays *from, rtk_u32 number, rtk_u32 lanes,
                               stream_rays *r, rtk_u32 *far)
{
    if (!(mode & STREAM_MOVED))
        return packet_rays_enter(from->org, from->inv, from->tmin, from->tmax, lanes, a->part, &r->t0, &r->t1, far);
    if (a->outer) { /* as RTK_NAME(instance) has it: the range is that of sums */
        const vec inf = V(set)(RTK_INF);
        r->shift = V(load)(a->outer + number);
        lanes = packet_rays_enter(from->org, from->inv, -inf, inf, lanes, a->part, &r->t0, &r->t1, far);
        return lanes & ~VM(bits)(V(lt)(r->shift + r->t1, r->tmin)) & ~VM(bits)(V(lt)(r->tmax, r->shift + r->t0));
    }
    lanes = packet_rays_enter(from->org, from->inv, from->tmin, from->tmax, lanes, a->part, &r->t0, &r->t1, far);
    lanes |= rays_move(from, a->part, *far, r->org, &r->shift, &r->t0, &r->t1);
    *far = 0u;
    return lanes;
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
    lanes = from.valid & packet_some(sees);
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
    if (!again && stream_tells(a, number))
        stream_tell(a, &r, lanes, number);
    packet_rays_key(&from, &r.kind, &r.key);
    lanes = stream_prepare(a, mode, &from, number, lanes, &r, &far);
    return far | stream_put(a, mode, &r, lanes, number);
}

/* ---- the way ---- */

/* Asks for what the stream's next step reads. */
RTI_VEC void stream_next(const streams *a, const stream *s)
{
    if (s->top != 0u)
        bvh_expect(&a->tree, s->child[s->top - 1u], s->count[s->top - 1u]);
}

/* Sanitized builds: a list holds rays of its stream alone. What else stood there would be met, too, and be no error that shows. */
RTI_VEC void stream_sound(const stream *s, const uint16_t *ids, rtk_u32 size)
{
#ifdef LIBRT_SANITIZED
    for (rtk_u32 i = 0u; i < size; i++)
        if (ids[i] >= s->n)
            __builtin_trap();
#endif
    (void)s;
    (void)ids;
    (void)size;
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
    stream_sound(s, ids, size);
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
    int turned;
    const rtk_u32 all = stream_open(a, s, mode, octant, n, ids, size, least, &turned);
    if (begin + (1u + (rtk_u32)__builtin_popcount(all)) * size > a->most) {
        memcpy(a->now, ids, size * sizeof *ids);
        return size;
    }
    if (all != 0u)
        stream_push(a, s, mode, n, all, least, turned, ids, size, begin + size); /* its list is read yet */
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
