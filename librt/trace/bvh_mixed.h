/* Rays that start near each other and point anywhere through eight-wide nodes together, for hot files.
 *
 * RTI_SIMD rays, of all octants and axes, walk as one while enough of them are left at a node; then each goes on by itself from
 * there (bvh_lone.h). The slots of a node are asked first for the box around all of the rays' ways, which is one test for eight
 * slots, then one after the other for all rays. Of those that some ray enters the nearest comes next; the others wait in no order,
 * for a branch that none can foresee costs more than a node. A leaf is met by all rays at once, a triangle at a time, or by four
 * rays and four triangles at a time, or by one ray after the other and four triangles: whichever is less. (Packets that fall apart
 * into single rays: Benthin, Wald, Woop, Ernst, Mark 2012; the box around all ways: Boulos, Wald, Benthin 2008.) Short rays, as
 * those of ambient occlusion, gain most.
 */
#ifndef RTI_BVH_MIXED_H
#define RTI_BVH_MIXED_H

#include "bvh_lone.h"

#define MIXED_FEW 2 /* so many rays go on by themselves */

typedef struct mixed {
    vec inv[3], start[3], t0, t1;
    tri_ray tri;            /* each ray's in its own order of axes */
    lone_axes axes;
    vec axis;               /* the dominant one */
    bvh_vec lo[3], hi[3];   /* around all ways */
    rtk_u32 from;           /* lane 0 is this one of the packet's */
} mixed;

/* Whether it pays at all: a closest hit comes late when others choose the order, too late for eight rays at a time. */
#define MIXED_PAYS(mode) (RTI_SIMD >= ((mode) & RTK_MODE_ANY ? 8 : 16))

/* Whether rays are to go this way. Closest hits are not to when they start all over the scene. */
RTI_VEC int mixes(const lone_all *a, rtk_u32 mode)
{
    return MIXED_PAYS(mode) && ((mode & RTK_MODE_ANY) || !a->p->spread);
}

RTI_VEC void mixed_start(const lone_all *a, mixed *m, rtk_u32 from, rtk_u32 lanes)
{
    const packet *p = a->p;
    const vec inf = V(set)(RTK_INF);
    const float edge = RTK_DELTA * a->part->scale; /* more than the roundings of a ray's ends */
    vec org[3], dir[3];
    m->from = from;
    m->t0 = V(load)(p->t0 + from);
    m->t1 = V(load)(p->t1 + from);
    m->axis = V(load)(p->kind + from);
    m->axes = lone_axes_of(m->axis);
    for (rtk_u32 k = 0u; k < 3u; k++) {
        vec x, y;
        org[k] = V(load)(p->org[k] + from);
        dir[k] = V(load)(p->dir[k] + from);
        m->inv[k] = V(load)(p->inv[k] + from);
        m->start[k] = org[k] * m->inv[k];
        x = org[k] + m->t0 * dir[k];
        y = org[k] + m->t1 * dir[k];
        m->lo[k] = NODE(set)(packet_low(V(select)(VM(of)(lanes), V(min)(x, y), inf)) - edge);
        m->hi[k] = NODE(set)(packet_high(V(select)(VM(of)(lanes), V(max)(x, y), -inf)) + edge);
    }
    m->tri = (tri_ray){lone_turned(&m->axes, org[1], org[2], org[0]),
                       lone_turned(&m->axes, org[2], org[0], org[1]),
                       lone_turned(&m->axes, org[0], org[1], org[2]),
                       V(load)(a->sx + from),
                       V(load)(a->sy + from),
                       lone_turned(&m->axes, dir[0], dir[1], dir[2]),
                       V(load)(p->tmin + from),
                       V(load)(p->tmax + from),
                       V(set)(0.0f),
                       V(set)(a->part->scale)};
}

/* The slots that the box around all ways meets. */
RTI_VEC rtk_u32 mixed_near(const mixed *m, const rtk_bvhnode *n)
{
    rtk_u32 bits = 0u;
    for (rtk_u32 i = 0u; i < RTK_BVH_WIDTH; i += NODE_N) {
        rtk_u32 in = (1u << NODE_N) - 1u;
        for (rtk_u32 k = 0u; k < 3u; k++)
            in &= node_bits(NODE(le)(NODE(load)(n->box[k][0] + i), m->hi[k])) &
                  node_bits(NODE(le)(m->lo[k], NODE(load)(n->box[k][1] + i)));
        bits |= in << i;
    }
    return bits;
}

/* The lanes that enter a slot's box, with where. */
RTI_VEC rtk_u32 mixed_enter(const mixed *m, const rtk_bvhnode *n, rtk_u32 slot, vec *enter)
{
    vec t0 = m->t0, t1 = m->t1;
    for (rtk_u32 k = 0u; k < 3u; k++) {
        const vec x = V(msub)(V(set)(n->box[k][0][slot]), m->inv[k], m->start[k]);
        const vec y = V(msub)(V(set)(n->box[k][1][slot]), m->inv[k], m->start[k]);
        t0 = V(max)(V(min)(x, y), t0);
        t1 = V(min)(V(max)(x, y), t1);
    }
    *enter = t0;
    return VM(bits)(V(le)(t0, t1));
}

/* Some rays, each for itself, on from a node or leaf. */
RTI_VEC void mixed_lone(const lone_all *a, const mixed *m, rtk_u32 mode, rtk_u32 at, rtk_u32 count, rtk_u32 lanes)
{
    for (; lanes != 0u; lanes &= lanes - 1u) {
        const rtk_u32 i = (rtk_u32)__builtin_ctz(lanes);
        lone w;
        lone_start(a, &w, mode, m->from + i);
        w.at = at;
        w.count = count;
        lone_walk(a, &w, mode);
    }
}

/* A corner of a block's triangle in the rays' orders of axes. */
RTI_VEC void mixed_corner(const mixed *m, const float v[3][4], rtk_u32 j, vec out[3])
{
    const vec x = V(set)(v[0][j]), y = V(set)(v[1][j]), z = V(set)(v[2][j]);
    out[0] = lone_turned(&m->axes, y, z, x);
    out[1] = lone_turned(&m->axes, z, x, y);
    out[2] = lone_turned(&m->axes, x, y, z);
}

/* What the leaf test has found of the triangle at a place. */
RTI_VEC void mixed_take(const lone_all *a, const mixed *m, rtk_u32 mode, const tri_hit *hit, const vec v0[3], const vec v1[3],
                        const vec v2[3], rtk_u32 place)
{
    packet *p = a->p;
    rtk_u32 ask = 0u, doubt = hit->doubt;
    if (mode & RTK_MODE_ANY) {
        rtk_u32 sure = hit->certain, more = 0u;
        doubt &= ~sure;
        if (__builtin_popcount(doubt) >= SETTLE_MANY) {
            ask = packet_settle_many(&m->tri, &m->tri.tmax, v0, v1, v2, doubt, &more);
            doubt = 0u;
        }
        p->done |= (uint64_t)(hit->hit | sure | more) << m->from;
    } else {
        vec best = V(load)(p->t + m->from), low = V(load)(p->low + m->from);
        rtk_u32 take = hit->hit & VM(bits)(V(lt)(hit->t, low));
        ask = hit->hit & ~take & VM(bits)(V(le)(hit->t, best)); /* the order of hits decides, or one that was put aside */
        for (rtk_u32 l = ask; l != 0u; l &= l - 1u) { /* or the same triangle in another leaf */
            const rtk_u32 i = (rtk_u32)__builtin_ctz(l), late = rtk_bits(p->late[m->from + i]);
            if (late != RTK_INVALID && a->tree.refs[late] == a->tree.refs[place] && !(low[i] < best[i]))
                ask &= ~(1u << i);
        }
        best = V(select)(VM(of)(take), hit->t, best);
        low = V(select)(VM(of)(take), hit->t, low);
        V(store)(p->u + m->from, V(select)(VM(of)(take), hit->u, V(load)(p->u + m->from)));
        V(store)(p->v + m->from, V(select)(VM(of)(take), hit->v, V(load)(p->v + m->from)));
        if (hit->certain != 0u) { /* as lone_doubt */
            const vec near = hit->t - hit->off, far = hit->t + hit->off;
            const rtk_u32 sure = hit->certain & VM(bits)(V(le)(near, best)), aside = sure & VM(bits)(V(lt)(far, low));
            ask |= sure & ~aside;
            best = V(select)(VM(of)(aside), far, best);
            low = V(select)(VM(of)(aside), near, low);
            take |= aside;
            doubt &= ~hit->certain;
        }
        V(store)(p->t + m->from, best);
        V(store)(p->low + m->from, low);
        V(store)(p->late + m->from, V(select)(VM(of)(take), V(set)(rtk_float(place)), V(load)(p->late + m->from)));
        if (take)
            __builtin_prefetch(&a->tree.refs[place]);
    }
    for (rtk_u32 l = ask | doubt; l != 0u; l &= l - 1u) {
        const rtk_u32 i = (rtk_u32)__builtin_ctz(l);
        if (ask >> i & 1u)
            lone_ask(a, m->from + i, mode, a->tree.refs[place]);
        else
            lone_doubt(a, m->from + i, mode, place, 0u, 0.0f, 0.0f);
    }
}

#ifdef RTI_PACK
/* A corner of a block's four triangles, four times, in the rays' orders of axes. */
RTI_VEC void mixed_rows(const lone_axes *axes, const float v[3][4], vec out[3])
{
    const vec x = rti_f16_row(v[0]), y = rti_f16_row(v[1]), z = rti_f16_row(v[2]);
    out[0] = lone_turned(axes, y, z, x);
    out[1] = lone_turned(axes, z, x, y);
    out[2] = lone_turned(axes, x, y, z);
}

/* The blocks of a leaf for `lanes`, four rays and four triangles at a time: lane 4 r + t is ray r and triangle t. */
RTI_VEC void mixed_fours(const lone_all *a, const mixed *m, rtk_u32 mode, rtk_u32 at, rtk_u32 count, rtk_u32 lanes)
{
    const rtk_u32 end = (at + count + 3u) / 4u, n = (rtk_u32)__builtin_popcount(lanes);
    for (rtk_u32 from = 0u, left = lanes; from < n; from += 4u) {
        const rti_i16 which = rti_i16_fours(lanes, from);
        const rtk_u32 want = n - from < 4u ? (1u << 4u * (n - from)) - 1u : LANES_ALL;
        const lone_axes axes = lone_axes_of(rti_f16_take(m->axis, which));
        const tri_ray r = {rti_f16_take(m->tri.ox, which),   rti_f16_take(m->tri.oy, which),   rti_f16_take(m->tri.oz, which),
                           rti_f16_take(m->tri.sx, which),   rti_f16_take(m->tri.sy, which),   rti_f16_take(m->tri.kdz, which),
                           rti_f16_take(m->tri.tmin, which), rti_f16_take(m->tri.tmax, which), V(set)(0.0f),
                           V(set)(a->part->scale)};
        rtk_u32 lane[4] = {0u}, done = 0u;
        for (rtk_u32 i = 0u; i < 4u && left != 0u; i++, left &= left - 1u)
            lane[i] = (rtk_u32)__builtin_ctz(left);
        for (rtk_u32 k = at / 4u; k < end; k++) {
            const rtk_bvhblock *b = &a->tree.blocks[k];
            vec v0[3], v1[3], v2[3];
            mixed_rows(&axes, b->v0, v0);
            mixed_rows(&axes, b->v1, v1);
            mixed_rows(&axes, b->v2, v2);
            tri_hit hit;
            float t[RTI_SIMD], u[RTI_SIMD], v[RTI_SIMD];
            rtk_u32 bits = tri_test(&r, v0, v1, v2, want & ~done, &hit), last = RTK_INVALID, ray = RTK_INVALID;
            if (__builtin_expect(bits == 0u, 1))
                continue;
            V(store)(t, hit.t);
            V(store)(u, hit.u);
            V(store)(v, hit.v);
            for (; bits != 0u; bits &= bits - 1u) {
                const rtk_u32 i = (rtk_u32)__builtin_ctz(bits), place = 4u * k + i % 4u;
                const rtk_u32 l = m->from + lane[i / 4u];
                int enough;
                if (done >> i & 1u)
                    continue;
                if (hit.doubt >> i & 1u) {
                    float off[RTI_SIMD];
                    if (i / 4u == ray && a->tree.refs[place] == last) /* a block's last triangle fills it up */
                        continue;
                    last = a->tree.refs[place];
                    ray = i / 4u;
                    V(store)(off, hit.off);
                    enough = lone_doubt(a, l, mode, place, hit.certain >> i & 1u, t[i], off[i]);
                } else {
                    enough = lone_take(a, l, mode, place, t[i], u[i], v[i]);
                }
                if (enough)
                    done |= 15u << i / 4u * 4u;
            }
        }
    }
}
#endif

RTI_VEC void mixed_leaf(const lone_all *a, const mixed *m, rtk_u32 mode, rtk_u32 at, rtk_u32 count, rtk_u32 lanes)
{
    const rtk_u32 some = (rtk_u32)__builtin_popcount(lanes);
#ifdef RTI_PACK
    if (some >= 2u && at < 4u * a->tree.block_count && (some + 3u) / 4u * ((count + 3u) / 4u) * 3u < count * 2u) {
        mixed_fours(a, m, mode, at, count, lanes);
        return;
    }
#endif
    if (some <= count || at >= 4u * a->tree.block_count) {
        for (; lanes != 0u; lanes &= lanes - 1u) {
            lone w;
            w.lane = m->from + (rtk_u32)__builtin_ctz(lanes);
            w.at = at;
            w.count = count;
            if (lone_leaf(a, &w, mode))
                a->p->done |= (uint64_t)1u << w.lane;
        }
        return;
    }
    for (rtk_u32 k = at; k < at + count && lanes != 0u; k++) {
        const rtk_bvhblock *b = &a->tree.blocks[k / 4u];
        vec v0[3], v1[3], v2[3];
        tri_hit hit;
        mixed_corner(m, b->v0, k % 4u, v0);
        mixed_corner(m, b->v1, k % 4u, v1);
        mixed_corner(m, b->v2, k % 4u, v2);
        if (tri_test(&m->tri, v0, v1, v2, lanes, &hit) == 0u)
            continue;
        mixed_take(a, m, mode, &hit, v0, v1, v2, k);
        if (mode & RTK_MODE_ANY)
            lanes &= ~packet_bits(a->p->done, m->from);
    }
}

/* The lanes at `from` to their end. */
RTI_VEC void mixed_walk(const lone_all *a, rtk_u32 mode, rtk_u32 from, rtk_u32 lanes)
{
    struct {
        rtk_u32 at, count, lanes;
    } stack[RTK_BVH_STACK + RTK_BVH_WIDTH];
    vec enter[RTK_BVH_STACK + RTK_BVH_WIDTH];
    mixed m;
    rtk_u32 top = 0u, at = 0u, count = 0u, here = lanes, steps = 0u;
    mixed_start(a, &m, from, lanes);
    m.t1 = mode & RTK_MODE_ANY ? m.t1 : V(min)(m.t1, V(load)(a->p->t + from));
    for (;;) {
        if (count != 0u || __builtin_popcount(here) <= MIXED_FEW) {
            if (count != 0u) {
                mixed_leaf(a, &m, mode, at, count, here);
            } else {
                mixed_lone(a, &m, mode, at, count, here);
                steps += (rtk_u32)__builtin_popcount(here);
            }
            if (!(mode & RTK_MODE_ANY))
                m.t1 = V(min)(m.t1, V(load)(a->p->t + from));
        } else {
            const rtk_bvhnode *n = &a->tree.bvh[at];
            const rtk_u32 first = top;
            steps++;
            rtk_u32 next = top;
            float least = RTK_INF;
            for (rtk_u32 bits = mixed_near(&m, n); bits != 0u;) { /* any hit takes the slots in their order (kernel/bvh.h) */
                const rtk_u32 i = 31u - (rtk_u32)__builtin_clz(bits);
                vec t;
                const rtk_u32 in = here & mixed_enter(&m, n, i, &t);
                bits ^= 1u << i;
                if (!(mode & RTK_MODE_ANY)) {
                    const float low = packet_low(V(select)(VM(of)(in), t, V(set)(RTK_INF)));
                    next = low < least ? top : next;
                    least = low < least ? low : least;
                    enter[top] = t;
                }
                stack[top].at = n->child[i];
                stack[top].count = n->count[i];
                stack[top].lanes = in;
                top += in != 0u;
            }
            if (top != first) {
                top--;
                if (mode & RTK_MODE_ANY)
                    next = top;
                at = stack[next].at;
                count = stack[next].count;
                here = stack[next].lanes;
                if (!(mode & RTK_MODE_ANY)) {
                    stack[next] = stack[top];
                    enter[next] = enter[top];
                }
                continue;
            }
        }
        do {
            if (top == 0u)
                goto end;
            top--;
            here = stack[top].lanes;
            if (mode & RTK_MODE_ANY)
                here &= ~packet_bits(a->p->done, from);
            else
                here &= VM(bits)(V(le)(enter[top], m.t1));
        } while (here == 0u);
        at = stack[top].at;
        count = stack[top].count;
    }
end:
    a->p->steps += steps;
}

#endif
