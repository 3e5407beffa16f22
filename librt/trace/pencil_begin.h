/* How a pencil of the rays that were loaded is made ready for its walk, for hot files: the rectangles of their slopes, and the
 * bounds that pencil.h tells of. */
#ifndef RTI_PENCIL_BEGIN_H
#define RTI_PENCIL_BEGIN_H

#include "pencil.h"

#define PENCIL_FEW   32u            /* rays through a point for which a pencil is not worth its while, */
#define PENCIL_BATCH (RTI_SIMD >= 8 ? 129u : 65u) /* and rays of a batch: packets are up to twice as fast for 32 */
#define PENCIL_OFF   6.1035156e-05f /* 2^-14: of the scale; rays whose lines are farther from the apex are no pencil's */
#define PENCIL_LEAST 1e-12f         /* scales that products of two coordinates are far from underflow and overflow with */
#define PENCIL_MOST  1e12f
#define PENCIL_GAP   0.4f /* of a rectangle's longer side, so wide a gap may part a block */
#define PENCIL_LONG  3.0f /* so much longer than the least rectangle of a pencil is one that is looked at for gaps */
#define PENCIL_WORTH 0.6f /* of its sides' sum, so much the parts' are when it does */

/* The bits of a vector. */
RTI_VEC vec_bits pencil_raw(vec a)
{
    vec_bits bits;
    memcpy(&bits, &a, sizeof bits);
    return bits;
}

/* How deep bundle i looks for hits. */
RTI_APART float pencil_end(const pencil *p, rtk_u32 mode, rtk_u32 i)
{
    const rtk_u32 g = p->block[i];
    const rtk_trace_block *b = &p->rays[g];
    const float *const o[3] = {b->ox, b->oy, b->oz}, *const d[3] = {b->dx, b->dy, b->dz};
    vec m = V(set)(-RTK_INF);
    for (rtk_u32 h = 0u; h < PENCIL_HALVES; h++) {
        const rtk_u32 k = h * RTI_SIMD;
        const vec deep = V(set)(p->turn) * (V(load)(o[p->kz] + k) - V(set)(p->apex[2])), way = V(abs)(V(load)(d[p->kz] + k));
        vec end = deep - V(load)(b->tmin + k) * way;
        if (p->away)
            end = deep + V(load)((mode & RTK_MODE_ANY ? b->tmax : p->hits[g].t) + k) * way;
        m = V(max)(m, V(select)(VM(of)(pencil_lanes(p->live[i], h)), end, m));
    }
    const float end = packet_high(m);
    return end + (PENCIL_U * rtk_fabs(end) + p->margin);
}

/* Bundles' rectangles while they are made: low and high slopes, times turn. */
typedef struct pencil_rects {
    _Alignas(64) float low[2][BUNDLES], high[2][BUNDLES];
} pencil_rects;

RTI_VEC void pencil_rect(const pencil *p, pencil_rects *r, rtk_u32 i)
{
    const rtk_u32 g = p->block[i];
    for (rtk_u32 k = 0u; k < 2u; k++) {
        vec lo = V(set)(RTK_INF), hi = -lo;
        for (rtk_u32 h = 0u; h < PENCIL_HALVES; h++) {
            const vec x = V(set)(p->turn) * V(load)(p->slope[k][g] + h * RTI_SIMD);
            const vmask in = VM(of)(pencil_lanes(p->live[i], h));
            lo = V(min)(V(select)(in, x, lo), lo);
            hi = V(max)(V(select)(in, x, hi), hi);
        }
        r->low[k][i] = packet_low(lo);
        r->high[k][i] = packet_high(hi);
    }
}

/* The longer side of a bundle's rectangle. */
RTI_VEC float pencil_side(const pencil_rects *r, rtk_u32 i)
{
    return rtk_max(r->high[0][i] - r->low[0][i], r->high[1][i] - r->low[1][i]);
}

/* Of a block's lanes, which are rays of bundle i, where they are on the longer side of its rectangle, those under the middle of
 * that (returned), less the greatest of these and the least of the others, a lane a ray, infinite without one. */
RTI_VEC rtk_u32 pencil_gap(const pencil *p, const pencil_rects *r, rtk_u32 i, vec *under, vec *over)
{
    const float x = r->high[0][i] - r->low[0][i], y = r->high[1][i] - r->low[1][i];
    const rtk_u32 k = x < y, g = p->block[i];
    const vec middle = V(set)(r->low[k][i] + 0.5f * rtk_max(x, y)), inf = V(set)(RTK_INF);
    rtk_u32 low = 0u;
    *under = *over = inf;
    for (rtk_u32 h = 0u; h < PENCIL_HALVES; h++) {
        const vec s = V(set)(p->turn) * V(load)(p->slope[k][g] + h * RTI_SIMD);
        const rtk_u32 lanes = pencil_lanes(p->live[i], h), some = lanes & VM(bits)(V(lt)(s, middle));
        *under = V(min)(V(select)(VM(of)(some), -s, inf), *under);
        *over = V(min)(V(select)(VM(of)(lanes & ~some), s, inf), *over);
        low |= some << h * RTI_SIMD;
    }
    return low;
}

/* Parts bundle i if its rays lie apart, as seen from the apex, and it is worth it; the other part is bundle n. */
RTI_APART int pencil_cut(pencil *p, rtk_u32 mode, pencil_rects *r, rtk_u32 i, rtk_u32 n)
{
    const float x = r->high[0][i] - r->low[0][i], y = r->high[1][i] - r->low[1][i];
    const rtk_u32 all = p->live[i];
    vec less, more;
    const rtk_u32 under = pencil_gap(p, r, i, &less, &more);
    if (under == 0u || under == all || !(packet_low(more) + packet_low(less) > PENCIL_GAP * pencil_side(r, i)))
        return 0;
    const float was[2][2] = {{r->low[0][i], r->high[0][i]}, {r->low[1][i], r->high[1][i]}};
    p->block[n] = p->block[i];
    p->live[i] = (uint16_t)under;
    p->live[n] = (uint16_t)(all & ~under);
    pencil_rect(p, r, i);
    pencil_rect(p, r, n);
    const float both = (r->high[0][i] - r->low[0][i]) + (r->high[1][i] - r->low[1][i]) + (r->high[0][n] - r->low[0][n]) +
                       (r->high[1][n] - r->low[1][n]);
    if (!(both < PENCIL_WORTH * (x + y))) {
        p->live[i] = (uint16_t)all;
        for (rtk_u32 k = 0u; k < 2u; k++) {
            r->low[k][i] = was[k][0];
            r->high[k][i] = was[k][1];
        }
        return 0;
    }
    p->from[n] = p->from[i];
    p->reach[i] = pencil_end(p, mode, i);
    p->reach[n] = pencil_end(p, mode, n);
    p->bundles |= PENCIL_ONE(n);
    return 1;
}

/* Blocks that may lie apart, a bit each: those whose rectangles are far longer than the least of a block all of whose rays walk,
 * unless that block's rays do; without such a block, all. */
RTI_VEC rtk_u32 pencil_long(const pencil *p, const pencil_rects *r)
{
    rtk_u32 least = PENCIL, some = 0u;
    float from = 0.0f;
    for (rtk_u32 g = 0u; g < PENCIL; g++)
        if (p->live[g] == 0xffffu && (least == PENCIL || pencil_side(r, g) < pencil_side(r, least)))
            least = g;
    if (least < PENCIL) {
        vec under, over;
        const rtk_u32 low = pencil_gap(p, r, least, &under, &over);
        const float side = pencil_side(r, least);
        if (low == 0u || low == 0xffffu || !(packet_low(over) + packet_low(under) > PENCIL_GAP * side))
            from = PENCIL_LONG * side;
    }
    for (rtk_u32 g = 0u; g < PENCIL; g++)
        some |= (rtk_u32)(p->live[g] != 0u && pencil_side(r, g) > from) << g;
    return some;
}

/* Blocks whose rays lie apart, because they start on what does, become two bundles or more. */
RTI_APART void pencil_part(pencil *p, rtk_u32 mode, pencil_rects *r)
{
    const rtk_u32 some = pencil_long(p, r);
    vec under[PENCIL], over[PENCIL];
    _Alignas(64) float less[PENCIL], more[PENCIL];
    rtk_u32 n = PENCIL;
    if (some == 0u)
        return;
    for (rtk_u32 g = 0u; g < PENCIL; g++) {
        under[g] = over[g] = V(set)(RTK_INF);
        if (some >> g & 1u)
            pencil_gap(p, r, g, &under[g], &over[g]);
    }
    pencil_lows(under, less);
    pencil_lows(over, more);
    for (rtk_u32 i = 0u; i < n && n < BUNDLES; i++) {
        if (i < PENCIL && (!(some >> i & 1u) || !(more[i] + less[i] > PENCIL_GAP * pencil_side(r, i))))
            continue;
        while (n < BUNDLES && pencil_cut(p, mode, r, i, n))
            n++;
    }
    p->end = (n + RTI_SIMD - 1u) / RTI_SIMD * RTI_SIMD;
    for (rtk_u32 i = n; i < p->end; i++) {
        p->live[i] = 0u;
        p->block[i] = 0u;
        p->reach[i] = -RTK_INF;
        p->from[i] = 0.0f;
        r->low[0][i] = r->low[1][i] = RTK_INF;
        r->high[0][i] = r->high[1][i] = -RTK_INF;
    }
}

/* What walks ask of the rectangles. */
RTI_VEC void pencil_bounds(pencil *p, const pencil_rects *r)
{
    const vec turn = V(set)(p->turn);
    for (rtk_u32 k = 0u; k < 2u; k++) {
        const float least = pencil_low(r->low[k], p->end), greatest = pencil_high(r->high[k], p->end);
        const float middle = 0.5f * (least + greatest);
        p->middle[k] = p->turn * middle;
        p->most[k] = rtk_max(greatest - middle, middle - least);
        pencil_ways_of(&p->all[k], V(set)(least), V(set)(greatest), 0u);
        for (rtk_u32 h = 0u; h < p->end; h += RTI_SIMD) {
            const vec l = V(load)(r->low[k] + h), u = V(load)(r->high[k] + h), c = V(set)(middle);
            pencil_ways_of(&p->ways[k], l, u, h);
            V(store)(p->corner[k][p->turn < 0.0f] + h, turn * (l - c));
            V(store)(p->corner[k][p->turn > 0.0f] + h, turn * (u - c));
        }
    }
    p->deepest = pencil_high(p->reach, p->end);
}

/* What is found of rays while they are looked at: the least of slopes, and of less the slopes, times turn, of where they begin,
 * and of less where they end, a lane a ray of each block; how far their lines are from the apex, and how far those that do not
 * start there are from 0; how many they are. */
typedef struct pencil_seen {
    vec lo[2][PENCIL], hi[2][PENCIL], from[PENCIL], reach[PENCIL], off, most;
    rtk_u32 count, same, other; /* some start at the apex, some do not */
} pencil_seen;

/* RTI_SIMD rays of block g, from lane k on, of which `lanes` are wanted, all alike: returns those that are of the pencil; others go
 * to *rest. Whether they are valid, rtk_ray_valid, is told here, too: no component of alike ones is greater than |dz|, and the line
 * of an origin that is not finite is not near the apex. (Rays that start at an apex that is not finite end all of it: pencil_begin
 * asks how far they are from 0.) */
RTI_VEC rtk_u32 pencil_look(pencil *p, rtk_u32 mode, rtk_u32 g, rtk_u32 k, rtk_u32 lanes, float round, pencil_seen *s,
                            uint16_t *rest)
{
    const rtk_trace_block *b = &p->rays[g];
    const float *const o[3] = {b->ox, b->oy, b->oz}, *const d[3] = {b->dx, b->dy, b->dz};
    const vec inf = V(set)(RTK_INF), zero = V(set)(0.0f), turn = V(set)(p->turn);
    const vec px = V(set)(p->apex[0]), py = V(set)(p->apex[1]), pz = V(set)(p->apex[2]);
    const vec dz = V(load)(d[p->kz] + k), sx = V(load)(d[p->kx] + k) / dz, sy = V(load)(d[p->ky] + k) / dz;
    const vec ox = V(load)(o[p->kx] + k), oy = V(load)(o[p->ky] + k), oz = V(load)(o[p->kz] + k);
    const vec tmin = V(load)(b->tmin + k), tmax = V(load)((mode & RTK_MODE_ANY ? b->tmax : p->hits[g].t) + k);
    const vec way = V(abs)(dz), x = turn * sx, y = turn * sy, least = tmin * way, most = tmax * way;
    const rtk_u32 other = lanes & packet_some((pencil_raw(ox) ^ pencil_raw(px)) | (pencil_raw(oy) ^ pencil_raw(py)) |
                                              (pencil_raw(oz) ^ pencil_raw(pz)));
    vmask fits = VM(and)(V(lt)(tmin, tmax), VM(and)(V(le)(V(set)(RTK_DIR_MIN), way), V(le)(way, V(set)(RTK_DIR_MAX))));
    vec begin = p->away ? least : -most, end = p->away ? most : -least, off = zero, far = zero;
    if (other != 0u) { /* some do not start at the apex */
        const vec deep = turn * (oz - pz), limit = V(set)(PENCIL_OFF * p->scale);
        const vec rx = V(abs)((ox - px) + sx * (pz - oz)), ry = V(abs)((oy - py) + sy * (pz - oz));
        begin = deep + begin;
        end = deep + end;
        fits = VM(and)(fits, VM(and)(V(le)(rx, limit), V(le)(ry, limit)));
        off = V(max)(rx, ry);
        far = V(max)(V(max)(V(abs)(ox), V(abs)(oy)), V(abs)(oz));
    }
    fits = VM(and)(fits, V(le)(V(set)(-round), begin));
    const rtk_u32 live = lanes & VM(bits)(fits) & pencil_seeing(b, k, p->mask);
    const vmask in = VM(of)(live);
    *rest = (uint16_t)(*rest | (lanes & ~live) << k);
    if (other != 0u) {
        s->off = V(max)(V(select)(in, off, zero), s->off);
        s->most = V(max)(V(select)(in, far, zero), s->most);
    }
    V(store)(p->slope[0][g] + k, sx);
    V(store)(p->slope[1][g] + k, sy);
    V(store)(p->to[g] + k, end);
    s->lo[0][g] = V(min)(V(select)(in, x, inf), s->lo[0][g]);
    s->hi[0][g] = V(min)(V(select)(in, -x, inf), s->hi[0][g]);
    s->lo[1][g] = V(min)(V(select)(in, y, inf), s->lo[1][g]);
    s->hi[1][g] = V(min)(V(select)(in, -y, inf), s->hi[1][g]);
    s->from[g] = V(min)(V(select)(in, begin, inf), s->from[g]);
    s->reach[g] = V(min)(V(select)(in, -end, inf), s->reach[g]);
    s->same |= live & ~other;
    s->other |= other & live;
    return live;
}

/* Looks at all rays of `want` that are like the first of them, and takes them out. */
RTI_VEC void pencil_gather(pencil *p, rtk_u32 mode, int down, float round, pencil_seen *s, uint16_t want[PENCIL],
                           uint16_t rest[PENCIL])
{
    s->off = s->most = V(set)(0.0f);
    s->count = s->same = s->other = 0u;
    p->bundles = 0u;
    p->recorded = 0u;
    const rtk_u32 here = p->first / RTK_BLOCK;
    for (rtk_u32 g = 0u; g < PENCIL; g++) {
        const rtk_trace_block *b = &p->rays[g];
        const float *const d[3] = {b->dx, b->dy, b->dz};
        const int unread = g >= p->unread && g < p->unread_end;
        for (rtk_u32 i = 0u; i < 2u && p->asked < here + g + p->lead; i++)
            pencil_expect(p, mode);
        const rtk_u32 all = unread ? pencil_load_block(p, mode, g) : want[g];
        rtk_u32 live = 0u, left = 0u;
        s->lo[0][g] = s->hi[0][g] = s->lo[1][g] = s->hi[1][g] = s->from[g] = s->reach[g] = V(set)(RTK_INF);
        for (rtk_u32 k = 0u; k < RTK_BLOCK; k += RTI_SIMD) {
            const rtk_u32 lanes = all >> k & LANES_ALL;
            if (lanes == 0u)
                continue;
            const rtk_u32 like =
                lanes & pencil_alike(p, V(load)(d[p->kx] + k), V(load)(d[p->ky] + k), V(load)(d[p->kz] + k), down);
            left |= (lanes & ~like) << k;
            live |= pencil_look(p, mode, g, k, like, round, s, &rest[g]) << k;
        }
        want[g] = (uint16_t)left;
        if (unread && left != 0u)
            pencil_tell_valid(p, g, left, want, rest);
        p->live[g] = (uint16_t)live;
        p->block[g] = (uint8_t)g;
        p->bundles |= (pencil_bits)(live != 0u) << g;
        s->count += (rtk_u32)__builtin_popcount(live);
    }
    p->unread_end = 0u;
}

/* Makes ready the walk through a part of a pencil that was begun. false: it may not go there. What is asked here of the pencil was
 * asked of its rays with the largest part's scale. */
RTI_APART int pencil_enter_part(pencil *p, rtk_u32 which)
{
    const rtk_part *part = &p->scene->groups->parts[which];
    const float scale = part->scale, most = rtk_max(p->far, p->size);
    if (!(p->far <= RTK_FAR * scale) || !(scale >= PENCIL_LEAST) || !(scale <= PENCIL_MOST) || !(p->off <= PENCIL_OFF * scale) ||
        !(p->least >= -(PENCIL_U * (p->size + scale))))
        return 0;
    p->part = part;
    p->which = which;
    p->around = p->off + 4.0f * PENCIL_U * (part->bvh.kind == RTK_TREE_BVH ? most : most + scale);
    p->edge = p->off + 1.5f * PENCIL_U * most;
    for (rtk_u32 i = 0u; i < 3u; i++) {
        p->low[i] = p->apex[i] - p->around;
        p->high[i] = p->apex[i] + p->around;
    }
    return 1;
}

/* Makes ready the walk of those of `want` that are like the first of them, which are taken out; those of them that are no
 * pencil's go to `rest`. Returns how many walk: through each part (pencil_enter_part). */
RTI_APART rtk_u32 pencil_begin(pencil *p, rtk_u32 mode, uint16_t want[PENCIL], uint16_t rest[PENCIL])
{
    const float scale = p->scale;
    const vec inf = V(set)(RTK_INF), zero = V(set)(0.0f);
    pencil_seen s;
    pencil_rects r;
    int down;
    const int apex = pencil_guess(p, mode, want, &down);
    p->size = rtk_max(rtk_max(rtk_fabs(p->apex[0]), rtk_fabs(p->apex[1])), rtk_fabs(p->apex[2]));
    pencil_gather(p, mode, down, PENCIL_U * (p->size + scale), &s, want, rest);
    p->far = rtk_max(packet_high(s.most), s.same != 0u ? p->size : 0.0f);
    p->off = packet_high(s.off);
    const float margin = p->off + 4.0f * PENCIL_U * (rtk_max(p->far, p->size) + scale);
    if (!apex || s.count < PENCIL_FEW || !(p->far <= RTK_FAR * scale)) {
        for (rtk_u32 g = 0u; g < PENCIL; g++)
            rest[g] |= p->live[g];
        return 0u;
    }
    p->one = s.other == 0u;
    p->margin = margin;
    p->end = PENCIL;
    pencil_lows(s.from, p->from);
    p->least = pencil_low(p->from, PENCIL);
    pencil_lows(s.reach, p->reach);
    for (rtk_u32 h = 0u; h < PENCIL; h += RTI_SIMD) {
        const vec begin = V(load)(p->from + h), end = -V(load)(p->reach + h); /* of no rays: infinite, and NaN is made of it */
        V(store)(p->from + h, V(max)(begin - (V(set)(PENCIL_U) * V(abs)(begin) + V(set)(margin)), zero));
        V(store)(p->reach + h, V(max)(end + (V(set)(PENCIL_U) * V(abs)(end) + V(set)(margin)), -inf));
    }
    for (rtk_u32 k = 0u; k < 2u; k++) {
        pencil_lows(s.lo[k], r.low[k]);
        pencil_lows(s.hi[k], r.high[k]);
        for (rtk_u32 h = 0u; h < PENCIL; h += RTI_SIMD)
            V(store)(r.high[k] + h, -V(load)(r.high[k] + h));
    }
    if (!p->one)
        pencil_part(p, mode, &r);
    pencil_bounds(p, &r);
    return s.count;
}

#endif
