/* One ray by itself through eight-wide nodes, where all there is to ask are triangles in blocks of which each hit counts, for hot
 * files. What a tree's walk is, bvh_lanes.inl and kernel/bvh.h tell; here
 *
 * boxes are met at plane * inv - org * inv, as in streams and with their proof (bvh_stream.h), children wait in the order in
 * which they are entered, triangles are met two blocks at a time;
 *
 * a hit for certain of which the leaf test's first half doubts where it is, is put aside: beside large triangles, a floor on
 * which the eye stands, that is so of most rays, and the second half takes as long as six nodes. It is decided at the end, in
 * doubles (tri_double.h), or before, when what comes next lies between its bounds.
 */
#ifndef RTI_BVH_LONE_H
#define RTI_BVH_LONE_H

#include "bvh_lanes.h"
#include "packet.h"

/* A ray on its way, and its best hit: where late is not RTK_INVALID, that of the triangle at this place; else `best`. far: no hit
 * is looked for behind this. Of a hit that was put aside, t is less than that: its least. */
typedef struct lone {
    const rtk_scene *scene;
    const rtk_group *group;
    const rtk_part *part; /* of the scene's own group; NULL: q and r are given */
    const rtk_tree *tree;
    const float *org, *dir; /* as prepared: no origin is moved here */
    float tmin, tmax, scale, kdz, sx, sy;
    rtk_u32 kx, ky, kz;
    float far, t, u, v;
    rtk_u32 late;
    rtk_hit best;
    /* Whom the leaf test itself is asked for; of a part both are made when they are needed, of the ray as it was given. */
    rtk_query *q;
    const rtk_pray *r;
    const rtk_ray *ray;
} lone;

/* A reference, by the leaf test itself; late is RTK_INVALID. */
RTI_APART int lone_ask_plain(lone *l, rtk_u32 mode, rtk_u32 ref)
{
    rtk_query own;
    rtk_pray prepared;
    rtk_query *q = l->q;
    const rtk_pray *r = l->r;
    int end;
    if (l->part) {
        const rtk_part *part = l->part;
        q = &own;
        r = &prepared;
        rtk_query_init(q, l->scene, *l->ray);
        if (!rtk_ray_prepare(*l->ray, part->lo, part->hi, part->scale, &prepared))
            return 0; /* never: lone_part asks the same */
    }
    q->best = l->best;
    end = rtk_query_prim(q, mode, r, ref);
    l->best = q->best;
    l->t = q->best.t;
    l->far = rtk_min(l->far, l->t);
    return end;
}

/* A hit that was put aside, in doubles; 0: it is to be asked. */
RTI_APART int lone_decide(lone *l, rtk_u32 place)
{
    const rtk_bvhblock *b = &l->tree->blocks[place / 4u];
    const rtk_u32 j = place % 4u, x = l->kx, y = l->ky, z = l->kz;
#define ALL(n) rti_f4_set(n)
    const rti_f4 v0[3] = {ALL(b->v0[x][j]), ALL(b->v0[y][j]), ALL(b->v0[z][j])};
    const rti_f4 v1[3] = {ALL(b->v1[x][j]), ALL(b->v1[y][j]), ALL(b->v1[z][j])};
    const rti_f4 v2[3] = {ALL(b->v2[x][j]), ALL(b->v2[y][j]), ALL(b->v2[z][j])};
    const rti_f4 dx = ALL(l->dir[x]), dy = ALL(l->dir[y]);
    const rti_tri_ray4 ray = {ALL(l->org[x]), ALL(l->org[y]), ALL(l->org[z]), ALL(l->sx), ALL(l->sy),
                              ALL(l->kdz),    ALL(l->tmin),   ALL(l->tmax),   ALL(0.0f),  ALL(l->scale)};
#undef ALL
    rtk_u32 edges;
    rti_tri_hit4 hit;
    hit.hit = 0u;
    hit.t = hit.u = hit.v = rti_f4_set(0.0f);
    if (tri_pairs4(&ray, &dx, &dy, v0, v1, v2, 1u, &hit, &edges) != 0u || hit.hit == 0u)
        return 0;
    l->t = hit.t[0];
    l->u = hit.u[0];
    l->v = hit.v[0];
    return 1;
}

/* The best hit is `best`. */
RTI_VEC void lone_settle(lone *l)
{
    const rtk_u32 place = l->late;
    if (place == RTK_INVALID)
        return;
    const rtk_u32 ref = l->tree->refs[place];
    l->late = RTK_INVALID;
    if (l->t < l->far) { /* put aside; nothing is in front of it */
        if (!lone_decide(l, place)) {
            lone_ask_plain(l, 0u, ref);
            return;
        }
        l->far = rtk_min(l->far, l->t);
    }
    l->best.t = l->t;
    l->best.u = l->u;
    l->best.v = l->v;
    if (l->group->geom_count == 1u) { /* a mesh's triangles stand in their order: its record need not be fetched */
        l->best.prim = ref;
        l->best.geom = 0u;
    } else {
        const rtk_tri *tri = &l->group->tris[ref];
        l->best.prim = tri->prim;
        l->best.geom = tri->geom;
    }
    l->best.inst = l->part ? RTK_INVALID : l->q->inst;
}

RTI_APART int lone_ask(lone *l, rtk_u32 mode, rtk_u32 ref)
{
    if (!(mode & RTK_MODE_ANY))
        lone_settle(l);
    return lone_ask_plain(l, mode, ref);
}

/* What lone_settle will read of a place. */
RTI_VEC void lone_expect(const lone *l, rtk_u32 place)
{
    const rtk_u32 *ref = &l->tree->refs[place];
    if (l->group->geom_count == 1u)
        __builtin_prefetch(ref);
    else
        __builtin_prefetch(&l->group->tris[*ref].geom);
}

/* A hit for certain. Returns 1 when the walk may end. */
RTI_VEC int lone_take(lone *l, rtk_u32 mode, rtk_u32 place, float t, float u, float v)
{
    int better = t < l->t;
    if (mode & RTK_MODE_ANY)
        return 1;
    if (t == l->t && !(l->t < l->far) && l->late != RTK_INVALID) /* triangles stand in the order of hits */
        better = l->tree->refs[place] < l->tree->refs[l->late];
    else if (!better && (t <= l->far || t == l->t)) /* between the bounds, or as near: the order of hits decides */
        return lone_ask(l, mode, l->tree->refs[place]);
    if (better) {
        l->t = t;
        l->u = u;
        l->v = v;
        l->late = place;
        l->far = rtk_min(l->far, t);
        lone_expect(l, place);
    }
    return 0;
}

/* The triangle at a place, which the leaf test's first half doubts. certain: it is a hit, no farther than `off` from t. */
RTI_APART int lone_doubt(lone *l, rtk_u32 mode, rtk_u32 place, rtk_u32 certain, float t, float off)
{
    const float end = mode & RTK_MODE_ANY ? l->tmax : rtk_min(l->tmax, l->far);
    float within[2] = {t - off, t + off};
    int sure = 1;
    if (!certain) {
        const rtk_bvhblock *b = &l->tree->blocks[place / 4u];
        const rtk_u32 j = place % 4u, x = l->kx, y = l->ky, z = l->kz;
        const rti_tri_pair pair = {l->org[x], l->org[y], l->org[z], l->sx, l->sy, l->kdz, 0.0f, l->scale, l->tmin, end};
        const float c0[3] = {b->v0[x][j], b->v0[y][j], b->v0[z][j]}, c1[3] = {b->v1[x][j], b->v1[y][j], b->v1[z][j]};
        const float c2[3] = {b->v2[x][j], b->v2[y][j], b->v2[z][j]};
        sure = rti_tri_settle(&pair, c0, c1, c2, within);
    }
    if (sure < 0 || (certain && within[0] > end))
        return 0;
    if (sure > 0 && (mode & RTK_MODE_ANY))
        return 1;
    if (l->late != RTK_INVALID && l->tree->refs[place] == l->tree->refs[l->late]) /* met in another leaf */
        return 0;
    if (sure == 0 || within[1] >= l->t || !(within[0] < within[1]) || !(within[0] < l->far))
        return lone_ask(l, mode, l->tree->refs[place]);
    l->t = within[0];
    l->late = place;
    l->far = rtk_min(l->far, within[1]);
    return 0;
}

/* A leaf's blocks. */
RTI_VEC int lone_leaf(lone *l, rtk_u32 mode, const bvh_pairs_ray *ray, rtk_u32 at, rtk_u32 count)
{
    const rtk_u32 end = (at + count + 3u) / 4u;
    for (rtk_u32 k = at / 4u; k < end; k += BVH_PAIRS) {
        bvh_pairs_hit hit;
        float t[NODE_N], u[NODE_N], v[NODE_N], off[NODE_N];
        rtk_u32 bits = bvh_pairs(l->tree, k, at, count, end, l->kx, l->ky, l->kz, ray, &hit);
        if (bits == 0u)
            continue;
        NODE(store)(t, hit.t);
        NODE(store)(u, hit.u);
        NODE(store)(v, hit.v);
        NODE(store)(off, hit.off);
        for (; bits != 0u; bits &= bits - 1u) {
            const rtk_u32 i = (rtk_u32)__builtin_ctz(bits);
            if (hit.doubt >> i & 1u ? lone_doubt(l, mode, 4u * k + i, hit.certain >> i & 1u, t[i], off[i])
                                    : lone_take(l, mode, 4u * k + i, t[i], u[i], v[i]))
                return 1;
        }
    }
    return 0;
}

/* What waits. */
typedef struct lone_stack {
    float t[RTK_BVH_STACK + RTK_BVH_WIDTH];
    rtk_u32 child[RTK_BVH_STACK + RTK_BVH_WIDTH], count[RTK_BVH_STACK + RTK_BVH_WIDTH];
} lone_stack;

RTI_VEC void lone_push(lone_stack *s, rtk_u32 top, const rtk_bvhnode *n, rtk_u32 slot, float t)
{
    s->t[top] = t;
    s->child[top] = n->child[slot];
    s->count[top] = n->count[slot];
}

/* Of the slots in bits, of which there is one, the one that is entered first; the others wait, the nearest on top. */
RTI_VEC rtk_u32 lone_choose(lone_stack *s, rtk_u32 mode, rtk_u32 *top, const rtk_bvhnode *n, rtk_u32 bits,
                            const float t[RTK_BVH_WIDTH])
{
    const rtk_u32 first = (rtk_u32)__builtin_ctz(bits), rest = bits & (bits - 1u);
    if (rest == 0u)
        return first;
    if (mode & RTK_MODE_ANY) { /* whatever their order, which is fair (kernel/bvh.h) */
#ifdef RTI_PACK8
        rti_f8_store(s->t + *top, rti_f8_set(-RTK_INF));
        rti_u8_pack(s->child + *top, rest, n->child);
        rti_u8_pack(s->count + *top, rest, n->count);
        *top += (rtk_u32)__builtin_popcount(rest);
#else
        for (rtk_u32 l = rest; l != 0u; l &= l - 1u)
            lone_push(s, (*top)++, n, (rtk_u32)__builtin_ctz(l), -RTK_INF);
#endif
        return first;
    }
    const rtk_u32 second = (rtk_u32)__builtin_ctz(rest);
    if ((rest & (rest - 1u)) == 0u) {
        const rtk_u32 far = t[second] < t[first] ? first : second;
        lone_push(s, (*top)++, n, far, t[far]);
        return first ^ second ^ far;
    }
#ifdef RTI_PACK8
    const rtk_u32 i = rti_f8_least(bits, rti_f8_load(t)), to = *top;
    rtk_u32 slots[RTK_BVH_WIDTH];
    rti_f8_sorted(s->t + to, slots, bits & ~(1u << i), rti_f8_load(t));
    rti_u8_take(s->child + to, n->child, slots);
    rti_u8_take(s->count + to, n->count, slots);
    *top = to + (rtk_u32)__builtin_popcount(bits) - 1u;
    return i;
#else
    rtk_u32 slots[RTK_BVH_WIDTH], count = 0u;
    for (; bits != 0u; bits &= bits - 1u) {
        const rtk_u32 i = (rtk_u32)__builtin_ctz(bits);
        rtk_u32 to = count++;
        for (; to > 0u && t[slots[to - 1u]] < t[i]; to--)
            slots[to] = slots[to - 1u];
        slots[to] = i;
    }
    for (rtk_u32 k = 0u; k + 1u < count; k++)
        lone_push(s, (*top)++, n, slots[k], t[slots[k]]);
    return slots[count - 1u];
#endif
}

/* A ray against boxes. */
typedef struct lone_slabs {
    bvh_vec inv[3], start[3], t0;
    rtk_u32 back[3];
} lone_slabs;

/* false: the ray is too near to the ends of the floats' range for this. */
RTI_VEC int lone_slabs_of(const float org[3], const float inv[3], float scale, float t0, lone_slabs *s)
{
    int fits = 1;
    for (rtk_u32 k = 0u; k < 3u; k++) {
        const float start = org[k] * inv[k];
        fits &= rtk_fabs(start) <= BVH_START_MOST && rtk_fabs(inv[k]) * scale >= BVH_START_LEAST;
        s->inv[k] = NODE(set)(inv[k]);
        s->start[k] = NODE(set)(start);
        s->back[k] = rtk_bits(inv[k]) >> 31;
    }
    s->t0 = NODE(set)(t0);
    return fits;
}

RTI_VEC rtk_u32 lone_open(const rtk_bvhnode *n, const lone_slabs *s, float far, float t[RTK_BVH_WIDTH])
{
    rtk_u32 bits = 0u;
    for (rtk_u32 h = 0u; h < RTK_BVH_WIDTH; h += NODE_N) {
#define PLANE(axis, side) NODE(msub)(NODE(load)(n->box[axis][side] + h), s->inv[axis], s->start[axis])
        const bvh_vec t0 =
            NODE(max)(NODE(max)(PLANE(0, s->back[0]), PLANE(1, s->back[1])), NODE(max)(PLANE(2, s->back[2]), s->t0));
        const bvh_vec t1 = NODE(min)(NODE(min)(PLANE(0, 1u - s->back[0]), PLANE(1, 1u - s->back[1])),
                                     NODE(min)(PLANE(2, 1u - s->back[2]), NODE(set)(far)));
#undef PLANE
        NODE(store)(t + h, t0);
        bits |= node_bits(NODE(le)(t0, t1)) << h;
    }
    return bits;
}

RTI_VEC bvh_pairs_ray lone_tri_ray(const lone *l)
{
    return (bvh_pairs_ray){NODE(set)(l->org[l->kx]), NODE(set)(l->org[l->ky]), NODE(set)(l->org[l->kz]), NODE(set)(l->sx),
                           NODE(set)(l->sy),         NODE(set)(l->kdz),        NODE(set)(l->tmin),       NODE(set)(l->tmax),
                           NODE(set)(0.0f),          NODE(set)(l->scale)};
}

/* The walk, from *l on. Returns 1 when any hit was asked for, and there is one. */
RTI_VEC int lone_walk(lone *l, rtk_u32 mode, const lone_slabs *given)
{
    const lone_slabs slabs = *given;
    const rtk_tree *tree = l->tree;
    const rtk_bvhnode *const nodes = tree->bvh;
    const bvh_pairs_ray ray = lone_tri_ray(l);
    lone_stack s;
    float far = l->far; /* outside of memory */
    const int large = bvh_large(tree);
    rtk_u32 at = 0u, count = 0u, top = 0u;
    for (;;) {
        if (count == 0u) {
            float t[RTK_BVH_WIDTH];
            const rtk_bvhnode *n = &nodes[at];
            const rtk_u32 bits = lone_open(n, &slabs, far, t);
            if (bits != 0u) {
                for (rtk_u32 w = large ? bits : 0u; w != 0u; w &= w - 1u)
                    bvh_expect(tree, n->child[__builtin_ctz(w)], n->count[__builtin_ctz(w)]);
                const rtk_u32 i = lone_choose(&s, mode, &top, n, bits, t);
                at = n->child[i];
                count = n->count[i];
                continue;
            }
        } else if (at < 4u * tree->block_count) {
            if (lone_leaf(l, mode, &ray, at, count))
                return 1;
            far = l->far;
        } else {
            for (rtk_u32 k = 0u; k < count; k++) {
                if (lone_ask(l, mode, tree->refs[at + k]))
                    return 1;
                far = l->far;
            }
        }
        do {
            if (top == 0u) {
                lone_settle(l);
                return 0;
            }
            top--;
        } while (s.t[top] > far);
        at = s.child[top];
        count = s.count[top];
    }
}

/* A prepared ray through a tree whose hits all count; 0: this is not for it. end: as lone_walk returns. */
RTI_VEC int lone_group(rtk_query *q, rtk_u32 mode, const rtk_tree *tree, const rtk_pray *r, int *end)
{
    const float org[3] = {r->org.x, r->org.y, r->org.z}, dir[3] = {r->dir.x, r->dir.y, r->dir.z};
    const float inv[3] = {r->inv.x, r->inv.y, r->inv.z};
    lone l = {.scene = q->scene,
              .group = q->group,
              .part = NULL,
              .tree = tree,
              .org = org,
              .dir = dir,
              .tmin = r->tmin,
              .tmax = r->tmax,
              .scale = r->scale,
              .kdz = r->kdz,
              .sx = r->sx,
              .sy = r->sy,
              .kx = r->kx,
              .ky = r->ky,
              .kz = r->kz,
              .far = rtk_min(r->t1, q->best.t),
              .t = q->best.t,
              .late = RTK_INVALID,
              .best = q->best,
              .q = q,
              .r = r};
    lone_slabs slabs;
    if (!lone_slabs_of(org, inv, r->scale, r->t0, &slabs))
        return 0;
    *end = r->t0 <= l.far && lone_walk(&l, mode, &slabs);
    q->best = l.best;
    return 1;
}

/* ---- a ray and nothing but the scene's own triangles ---- */

RTI_VEC int lone_fits(const rtk_scene *scene)
{
    const rtk_group *g = scene->groups;
    return scene->instance_count == 0u && g->plane_count == 0u && g->shape_count == 0u && (g->flags & RTK_GROUP_PLAIN);
}

/* A ray as it comes: of four lanes three count. */
typedef struct lone_given {
    rti_f4 org, dir, inv;
    float most; /* of |org| */
} lone_given;

/* rtk_ray_valid, and rtk_inverse. */
RTI_VEC int lone_given_of(const rti_ray *ray, lone_given *g)
{
    const rti_f4 most = rti_f4_set(3.402823466e38f), zero = rti_f4_set(0.0f), top = rti_f4_set(RTK_INV_MAX);
    g->org = rti_f4_load(ray->org); /* and tmin */
    g->dir = rti_f4_load(ray->dir); /* and tmax */
    const rti_f4 far = rti_f4_abs(g->org), size = rti_f4_abs(g->dir), inv = rti_f4_set(1.0f) / g->dir;
    const rti_f4 flat = rti_f4_select(rti_f4_lt(inv, zero), -top, top);
    const float longest = rtk_max(rtk_max(size[0], size[1]), size[2]);
    g->inv = rti_f4_select(rti_f4_lt(size, rti_f4_set(1.0e-30f)), flat, rti_f4_min(rti_f4_max(inv, -top), top));
    g->most = rtk_max(rtk_max(far[0], far[1]), far[2]);
    return (rti_m4_bits(rti_m4_and(rti_f4_le(far, most), rti_f4_le(size, most))) & 7u) == 7u && longest >= RTK_DIR_MIN &&
           longest <= RTK_DIR_MAX && ray->tmin < ray->tmax;
}

/* Its way through a part: 1 or 0 as lone_walk, or -1: it must go another way. */
RTI_VEC int lone_part(lone *l, rtk_u32 mode, const lone_given *g, const rtk_part *part, const rtk_tree *tree)
{
    const rti_f4 lo = {part->lo.x, part->lo.y, part->lo.z, 0.0f}, hi = {part->hi.x, part->hi.y, part->hi.z, 0.0f};
    const rti_f4 a = (lo - g->org) * g->inv, b = (hi - g->org) * g->inv, in = rti_f4_min(a, b), out = rti_f4_max(a, b);
    const float t0 = rtk_max(rtk_max(in[0], in[1]), in[2]), t1 = rtk_min(rtk_min(out[0], out[1]), out[2]);
    const float inv[3] = {g->inv[0], g->inv[1], g->inv[2]};
    lone_slabs slabs;
    if (tree->block_count == 0u)
        return -1;
    if (g->most > RTK_FAR * part->scale)
        return rtk_ray_passes(*l->ray, rtk_v3(inv[0], inv[1], inv[2]), part->lo, part->hi, part->scale) ? 0 : -1;
    if (!(t0 <= t1) || t1 < l->tmin || t0 > l->tmax)
        return 0;
    if (!lone_slabs_of(l->org, inv, part->scale, rtk_max(t0, l->tmin), &slabs))
        return -1;
    l->part = part;
    l->tree = tree;
    l->scale = part->scale;
    l->t = l->best.t;
    l->far = rtk_min(rtk_min(t1, l->tmax), l->t);
    l->late = RTK_INVALID;
    return rtk_max(t0, l->tmin) <= l->far && lone_walk(l, mode, &slabs);
}

/* A valid ray made ready, but for what a part brings. same: the ray, for who makes a query of it. */
RTI_VEC void lone_begin(lone *l, const rtk_scene *scene, const rti_ray *ray, const rtk_ray *same)
{
    const float x = rtk_fabs(ray->dir[0]), y = rtk_fabs(ray->dir[1]), z = rtk_fabs(ray->dir[2]);
    l->scene = scene;
    l->group = scene->groups;
    l->ray = same;
    l->org = ray->org;
    l->dir = ray->dir;
    l->tmin = ray->tmin;
    l->tmax = ray->tmax;
    l->kz = x > y && x > z ? 0u : (y > z ? 1u : 2u); /* as rtk_ray_prepare */
    l->kx = l->kz == 2u ? 0u : l->kz + 1u;
    l->ky = l->kx == 2u ? 0u : l->kx + 1u;
    l->kdz = ray->dir[l->kz];
    l->sx = ray->dir[l->kx] / l->kdz;
    l->sy = ray->dir[l->ky] / l->kdz;
    l->best = rtk_hit_none(ray->tmax);
    l->q = NULL;
    l->r = NULL;
}

#endif
