/* Rays that go one by one through eight-wide nodes, from the root or from where they part (bvh_mixed.h), for hot files.
 *
 * They are loaded and prepared in vectors as those of a packet (bvh_packet.h) and leave their hits there. This is for triangles
 * in blocks of a group each hit of which counts (lone_fits). The walk is that of bvh_lanes.inl but for this: planes are met at
 * plane * inv - org * inv. The product org * inv is rounded, by 2^-24 of |org| <= RTK_FAR scale, which is a sixteenth of what
 * RTK_GROW holds in reserve (ray.h, theory point 3). Rays for which it would leave the floats' range go by bvh_lanes.inl.
 */
#ifndef RTI_BVH_LONE_H
#define RTI_BVH_LONE_H

#include "bvh_packet.h"

#define LONE_END   0xffffffffu /* count of the entry at the stack's foot */
#define LONE_STACK (RTK_BVH_STACK + RTK_BVH_WIDTH + 1u)

/* A ray on its way. A hit for certain of which the leaf test's first half doubts where it is (`certain`, or rti_tri_settle) is put
 * aside: the packet's t is then a bound of it, late its place, low the other bound. It is decided with others of its kind at the
 * end (lone_decide), or alone when what comes next lies between its bounds. Whose the best hit is, is not asked before the end
 * either: references and triangles are seldom in the nearer caches, and then all rays' are waited for at once. */
typedef struct lone {
    float inv[3], start[3], t0, reach; /* start: org * inv */
    rtk_u32 near[3], lane;             /* near: rows of box with the planes that it enters by */
    rtk_u32 at, count, top;            /* node, or leaf as in rtk_bvhnode; entries of the stack */
    float stack_t[LONE_STACK];
    rtk_u32 stack_child[LONE_STACK], stack_count[LONE_STACK];
} lone;

/* What all rays of a packet share in a part. */
typedef struct lone_all {
    packet *p;
    const rtk_part *part;
    rtk_tree tree;
    float sx[PACKET], sy[PACKET];
} lone_all;

/* May a part's rays go this way? */
RTI_VEC int lone_fits(const rtk_group *g, const rtk_part *part)
{
    return (g->flags & RTK_GROUP_PLAIN) && g->shape_count == 0u && part->RTK_TREE.block_count != 0u;
}

/* A certain hit that nothing is in front of, by the leaf test itself: which takes it, and so sets u and v. */
static void lone_exact(packet *p, const rtk_part *part, rtk_u32 lane, rtk_u32 ref)
{
    p->t[lane] = p->tmax[lane];
    p->prim[lane] = p->geom[lane] = rtk_float(RTK_INVALID);
    packet_ask(p, 0u, part, lane, ref);
}

/* The packet has a lane's best hit so far, all of it. */
RTI_VEC void lone_settle(const lone_all *a, rtk_u32 l)
{
    packet *p = a->p;
    const rtk_u32 late = rtk_bits(p->late[l]);
    if (late == RTK_INVALID)
        return;
    if (p->low[l] < p->t[l])
        lone_exact(p, a->part, l, a->tree.refs[late]);
    else
        packet_is(p, l, a->tree.refs[late]);
    p->late[l] = rtk_float(RTK_INVALID);
    p->low[l] = p->t[l];
}

/* A reference by the leaf test itself: 1, nothing more is asked. */
RTI_VEC int lone_ask(const lone_all *a, rtk_u32 l, rtk_u32 mode, rtk_u32 ref)
{
    packet *p = a->p;
    if (!(mode & RTK_MODE_ANY))
        lone_settle(a, l);
    packet_ask(p, mode, a->part, l, ref);
    p->low[l] = p->t[l];
    return (mode & RTK_MODE_ANY) && (p->done >> l & 1u);
}

/* The triangle at a place, which the leaf test's first half doubts. certain: it is a hit, no farther than `off` from t. */
RTI_VEC int lone_doubt(const lone_all *a, rtk_u32 l, rtk_u32 mode, rtk_u32 place, rtk_u32 certain, float t, float off)
{
    packet *p = a->p;
    const rtk_bvhblock *b = &a->tree.blocks[place / 4u];
    const rtk_u32 j = place % 4u;
    const rtk_u32 kz = p->axis[l] & 3u, kx = kz == 2u ? 0u : kz + 1u, ky = kx == 2u ? 0u : kx + 1u;
    const rti_tri_pair pair = {p->org[kx][l], p->org[ky][l], p->org[kz][l],  a->sx[l],   a->sy[l],
                               p->dir[kz][l], 0.0f,          a->part->scale, p->tmin[l], p->t[l]};
    const float c0[3] = {b->v0[kx][j], b->v0[ky][j], b->v0[kz][j]}, c1[3] = {b->v1[kx][j], b->v1[ky][j], b->v1[kz][j]};
    const float c2[3] = {b->v2[kx][j], b->v2[ky][j], b->v2[kz][j]};
    float within[2] = {t - off, t + off};
    const int sure = certain ? 1 : rti_tri_settle(&pair, c0, c1, c2, within);
    if (sure < 0 || (certain && !(mode & RTK_MODE_ANY) && within[0] > p->t[l]))
        return 0;
    if (sure > 0 && (mode & RTK_MODE_ANY)) {
        p->done |= (uint64_t)1u << l;
        return 1;
    }
    if (sure == 0 || within[1] >= p->low[l] || !(within[0] < within[1]))
        return lone_ask(a, l, mode, a->tree.refs[place]);
    p->low[l] = within[0];
    p->t[l] = within[1];
    p->late[l] = rtk_float(place);
    __builtin_prefetch(&a->tree.refs[place]);
    return 0;
}

/* A hit for certain of the triangle at a place: 1, it will do. */
RTI_VEC int lone_take(const lone_all *a, rtk_u32 l, rtk_u32 mode, rtk_u32 place, float t, float u, float v)
{
    packet *p = a->p;
    const rtk_u32 *refs = a->tree.refs, late = rtk_bits(p->late[l]);
    const float low = p->low[l];
    if (mode & RTK_MODE_ANY) {
        p->done |= (uint64_t)1u << l;
        return 1;
    }
    if (t < low || (t == low && t == p->t[l] && late != RTK_INVALID && refs[place] < refs[late])) {
        p->t[l] = p->low[l] = t;
        p->u[l] = u;
        p->v[l] = v;
        p->late[l] = rtk_float(place);
        __builtin_prefetch(&refs[place]);
    } else if (t <= p->t[l] && (low < p->t[l] || late == RTK_INVALID)) {
        lone_ask(a, l, mode, refs[place]); /* between the bounds; or the best is another part's: the order of hits decides */
    }
    return 0;
}

/* A leaf: 1, a hit will do. */
RTI_VEC int lone_leaf(const lone_all *a, lone *w, rtk_u32 mode)
{
    packet *p = a->p;
    const rtk_tree *tree = &a->tree;
    const rtk_u32 l = w->lane, kz = p->axis[l] & 3u, kx = kz == 2u ? 0u : kz + 1u, ky = kx == 2u ? 0u : kx + 1u;
    const rtk_u32 end = (w->at + w->count + 3u) / 4u;
    rti_tri_ray4 r;
    if (w->at >= 4u * tree->block_count) {
        for (rtk_u32 k = 0u; k < w->count; k++)
            if (lone_ask(a, l, mode, tree->refs[w->at + k]))
                return 1;
        return 0;
    }
    r.ox = rti_f4_set(p->org[kx][l]);
    r.oy = rti_f4_set(p->org[ky][l]);
    r.oz = rti_f4_set(p->org[kz][l]);
    r.sx = rti_f4_set(a->sx[l]);
    r.sy = rti_f4_set(a->sy[l]);
    r.kdz = rti_f4_set(p->dir[kz][l]);
    r.tmin = rti_f4_set(p->tmin[l]);
    r.tmax = rti_f4_set(p->tmax[l]);
    r.tshift = rti_f4_set(0.0f);
    r.scale = rti_f4_set(a->part->scale);
    for (rtk_u32 k = w->at / 4u; k < end; k++) {
        const rtk_bvhblock *b = &tree->blocks[k];
        const rti_f4 p0[3] = {rti_f4_load(b->v0[kx]), rti_f4_load(b->v0[ky]), rti_f4_load(b->v0[kz])};
        const rti_f4 p1[3] = {rti_f4_load(b->v1[kx]), rti_f4_load(b->v1[ky]), rti_f4_load(b->v1[kz])};
        const rti_f4 p2[3] = {rti_f4_load(b->v2[kx]), rti_f4_load(b->v2[ky]), rti_f4_load(b->v2[kz])};
        rti_tri_hit4 hit;
        float t[4], u[4], v[4], off[4];
        rtk_u32 bits = rti_tri4(&r, p0, p1, p2, 15u, &hit), last = RTK_INVALID;
        if (__builtin_expect(bits == 0u, 1))
            continue;
        rti_f4_store(t, hit.t);
        rti_f4_store(u, hit.u);
        rti_f4_store(v, hit.v);
        for (; bits != 0u; bits &= bits - 1u) {
            const rtk_u32 i = (rtk_u32)__builtin_ctz(bits), place = 4u * k + i;
            if (hit.doubt >> i & 1u) {
                if (tree->refs[place] == last) /* a block's last triangle stands in the lanes that are left */
                    continue;
                last = tree->refs[place];
                rti_f4_store(off, hit.off);
                if (lone_doubt(a, l, mode, place, hit.certain >> i & 1u, t[i], off[i]))
                    return 1;
            } else if (lone_take(a, l, mode, place, t[i], u[i], v[i])) {
                return 1;
            }
        }
    }
    return 0;
}

RTI_VEC void lone_start(const lone_all *a, lone *w, rtk_u32 mode, rtk_u32 lane)
{
    const packet *p = a->p;
    for (rtk_u32 k = 0u; k < 3u; k++) {
        w->inv[k] = p->inv[k][lane];
        w->start[k] = p->org[k][lane] * p->inv[k][lane];
        w->near[k] = (2u * k + (p->axis[lane] >> (2u + k) & 1u)) * RTK_BVH_WIDTH;
    }
    w->t0 = p->t0[lane];
    w->reach = mode & RTK_MODE_ANY ? p->t1[lane] : rtk_min(p->t1[lane], p->t[lane]);
    w->lane = lane;
    w->at = w->count = 0u;
    w->stack_t[0] = -RTK_INF;
    w->stack_child[0] = 0u;
    w->stack_count[0] = LONE_END;
    w->top = 1u;
}

/* Lanes whose dominant axis, as a packet's `kind`, is x, y; that of the others is z. */
typedef struct lone_axes {
    vmask first, second;
} lone_axes;

RTI_VEC lone_axes lone_axes_of(vec kind)
{
    return (lone_axes){V(eq)(kind, V(set)(0.0f)), V(eq)(kind, V(set)(1.0f))};
}

/* Of each lane the component along its dominant axis: x, y or z. */
RTI_VEC vec lone_turned(const lone_axes *a, vec x, vec y, vec z)
{
    return V(select)(a->first, x, V(select)(a->second, y, z));
}

/* Shears; returns the rays whose way cannot be told by products. */
RTI_VEC uint64_t lone_prepare(lone_all *a, uint64_t rays)
{
    const packet *p = a->p;
    const vec most = V(set)(1.0e37f);
    uint64_t far = 0u;
    for (rtk_u32 at = 0u; at < PACKET; at += RTI_SIMD) {
        const rtk_u32 lanes = packet_bits(rays, at);
        rtk_u32 fit = LANES_ALL;
        lone_axes axes;
        vec d[3], dz;
        if (lanes == 0u)
            continue;
        for (rtk_u32 k = 0u; k < 3u; k++) {
            const vec o = V(load)(p->org[k] + at);
            d[k] = V(load)(p->dir[k] + at);
            fit &= VM(bits)(V(le)(V(abs)(o * V(load)(p->inv[k] + at)), most));
        }
        axes = lone_axes_of(V(load)(p->kind + at));
        dz = lone_turned(&axes, d[0], d[1], d[2]);
        V(store)(a->sx + at, lone_turned(&axes, d[1], d[2], d[0]) / dz);
        V(store)(a->sy + at, lone_turned(&axes, d[2], d[0], d[1]) / dz);
        far |= (uint64_t)(LANES_ALL & ~fit) << at;
    }
    return far & rays;
}

/* The ray against boxes, in vectors; x, y, z: offsets in a node of the planes that it enters by, in bytes. */
typedef struct lone_slabs {
    bvh_vec ix, iy, iz, ox, oy, oz, begin;
    size_t x, y, z;
} lone_slabs;

RTI_VEC lone_slabs lone_slabs_of(const lone *w)
{
    return (lone_slabs){NODE(set)(w->inv[0]),
                        NODE(set)(w->inv[1]),
                        NODE(set)(w->inv[2]),
                        NODE(set)(w->start[0]),
                        NODE(set)(w->start[1]),
                        NODE(set)(w->start[2]),
                        NODE(set)(w->t0),
                        w->near[0] * sizeof(float),
                        w->near[1] * sizeof(float),
                        w->near[2] * sizeof(float)};
}

/* As bvh_open, at plane * inv - start. */
RTI_VEC rtk_u32 lone_open(const rtk_bvhnode *n, const lone_slabs *v, bvh_vec end, float t[RTK_BVH_WIDTH])
{
    const char *from = (const char *)n;
    const size_t far = RTK_BVH_WIDTH * sizeof(float); /* from a near plane's row to the far one's, either way */
    rtk_u32 bits = 0u;
    for (rtk_u32 i = 0u; i < RTK_BVH_WIDTH; i += NODE_N) {
#define ROW(offset) NODE(load)((const float *)(const void *)(from + (offset)) + i)
        bvh_vec t0 = NODE(max)(NODE(max)(NODE(msub)(ROW(v->x), v->ix, v->ox), NODE(msub)(ROW(v->y), v->iy, v->oy)),
                               NODE(max)(NODE(msub)(ROW(v->z), v->iz, v->oz), v->begin));
        bvh_vec t1 = NODE(min)(NODE(min)(NODE(msub)(ROW(v->x ^ far), v->ix, v->ox), NODE(msub)(ROW(v->y ^ far), v->iy, v->oy)),
                               NODE(min)(NODE(msub)(ROW(v->z ^ far), v->iz, v->oz), end));
#undef ROW
        NODE(store)(t + i, t0);
        bits |= node_bits(NODE(le)(t0, t1)) << i;
    }
    return bits;
}

/* bvh_choose for any hit, which needs no distances: the slots in their order, where vectors are packed. */
RTI_VEC rtk_u32 lone_first(lone *w, const rtk_bvhnode *n, rtk_u32 bits, const float t[RTK_BVH_WIDTH], rtk_u32 *top)
{
#ifdef RTI_PACK
    const rtk_u32 i = (rtk_u32)__builtin_ctz(bits);
    (void)t;
    bits &= bits - 1u;
    rti_u8_pack(w->stack_child + *top, bits, n->child);
    rti_u8_pack(w->stack_count + *top, bits, n->count);
    *top += (rtk_u32)__builtin_popcount(bits);
    return i;
#else
    return bvh_choose(n, bits, t, w->stack_t, w->stack_child, w->stack_count, top);
#endif
}

/* One ray to its end. Any hit takes slots in their order, which is fair and needs no distances (kernel/bvh.h). */
RTI_VEC void lone_walk(const lone_all *a, lone *w, rtk_u32 mode)
{
    const rtk_bvhnode *nodes = a->tree.bvh;
    const lone_slabs v = lone_slabs_of(w);
    bvh_vec end = NODE(set)(w->reach);
    rtk_u32 top = w->top, at = w->at, count = w->count;
    for (;;) {
        while (count == 0u) {
            float t[RTK_BVH_WIDTH];
            const rtk_bvhnode *n = &nodes[at];
            rtk_u32 bits = lone_open(n, &v, end, t), i;
            if (bits == 0u)
                goto next;
            if (mode & RTK_MODE_ANY)
                i = lone_first(w, n, bits, t, &top);
            else
                i = bvh_choose(n, bits, t, w->stack_t, w->stack_child, w->stack_count, &top);
            at = n->child[i];
            count = n->count[i];
        }
        if (count == LONE_END)
            break;
        w->at = at;
        w->count = count;
        if (lone_leaf(a, w, mode))
            break;
        if (!(mode & RTK_MODE_ANY)) {
            w->reach = rtk_min(w->reach, a->p->t[w->lane]);
            end = NODE(set)(w->reach);
        }
    next:
        do
            top--;
        while (!(mode & RTK_MODE_ANY) && w->stack_t[top] > w->reach);
        at = w->stack_child[top];
        count = w->stack_count[top];
    }
}

/* Of n lanes, no more than vectors hold, the hits that were put aside. */
static void lone_decide(const lone_all *a, const rtk_u32 *lane, rtk_u32 n)
{
    packet *p = a->p;
    float x[19][RTI_SIMD] = {{0.0f}};
    vec r[19];
    tri_hit hit;
    for (rtk_u32 i = 0u; i < n; i++) {
        const rtk_u32 l = lane[i], place = rtk_bits(p->late[l]), j = place % 4u;
        const rtk_u32 kz = p->axis[l] & 3u, kx = kz == 2u ? 0u : kz + 1u, ky = kx == 2u ? 0u : kx + 1u;
        const rtk_bvhblock *b = &a->tree.blocks[place / 4u];
        const float of[19] = {p->org[kx][l], p->org[ky][l], p->org[kz][l], a->sx[l],     a->sy[l],     p->dir[kz][l], p->tmin[l],
                              p->tmax[l],    p->dir[kx][l], p->dir[ky][l], b->v0[kx][j], b->v0[ky][j], b->v0[kz][j],  b->v1[kx][j],
                              b->v1[ky][j],  b->v1[kz][j],  b->v2[kx][j],  b->v2[ky][j], b->v2[kz][j]};
        for (rtk_u32 k = 0u; k < 19u; k++)
            x[k][i] = of[k];
    }
    for (rtk_u32 k = 0u; k < 19u; k++)
        r[k] = V(load)(x[k]);
    const tri_ray ray = {r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], V(set)(0.0f), V(set)(a->part->scale)};
    hit.hit = 0u;
    hit.t = hit.u = hit.v = V(set)(0.0f);
    tri_exact(&ray, &r[8], &r[9], r + 10, r + 13, r + 16, (2u << (n - 1u)) - 1u, &hit);
    V(store)(x[0], hit.t);
    V(store)(x[1], hit.u);
    V(store)(x[2], hit.v);
    for (rtk_u32 i = 0u; i < n; i++) {
        const rtk_u32 l = lane[i];
        if (hit.hit >> i & 1u) {
            p->t[l] = x[0][i];
            p->u[l] = x[1][i];
            p->v[l] = x[2][i];
        } else { /* the ray starts or ends on an edge */
            lone_exact(p, a->part, l, a->tree.refs[rtk_bits(p->late[l])]);
            p->late[l] = rtk_float(RTK_INVALID);
        }
    }
}

/* The best hits of a packet's lanes are in the packet, all of them. */
RTI_VEC void lone_end(const lone_all *a, uint64_t rays)
{
    packet *p = a->p;
    rtk_u32 lane[PACKET], n = 0u;
    for (rtk_u32 at = 0u; at < PACKET; at += RTI_SIMD) {
        rtk_u32 l = packet_bits(rays, at);
        if (l != 0u)
            l &= VM(bits)(V(lt)(V(load)(p->low + at), V(load)(p->t + at)));
        for (; l != 0u; l &= l - 1u)
            lane[n++] = at + (rtk_u32)__builtin_ctz(l);
    }
    for (rtk_u32 at = 0u; at < n; at += RTI_SIMD)
        lone_decide(a, lane + at, rtk_umin(n - at, RTI_SIMD));
    packet_know(p, a->part);
}

#endif
