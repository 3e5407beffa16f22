/* Rays that have nothing in common but the octant they point into, through eight-wide nodes together, for hot files.
 *
 * Up to STREAM rays go as a stream. A node is opened once for all of the stream's rays that enter it: its planes are in
 * registers, and the rays pass one after the other, each against all eight boxes; no ray waits for another, and no branch depends
 * on what one meets. Behind that each slot gets the list of the rays that enter it, and the slots go onto a stack, the nearest on
 * top, with their lists. A leaf meets its list four rays and four triangles at a time. So what a node or leaf costs beside its
 * rays (to wait for it, to foresee where it leads) is shared by all rays that come there: of bounces of a picture's tile some
 * thirty, where packets of sixteen share it by four, or by one. (Fuetterling, Lojewski, Pfreundt, Hamann 2015; Barringer,
 * Akenine-Moeller 2014: what differs is that lists hold numbers, no copies.)
 *
 * Planes are met at plane * inv - org * inv. The product org * inv is rounded, by 2^-24 of |org| <= RTK_FAR scale, which is a
 * sixteenth of what RTK_GROW holds in reserve (ray.h, theory point 3). Rays for which it would leave the floats' range go by
 * bvh_lanes.inl. This is for triangles in blocks of a group each hit of which counts (stream_fits).
 */
#ifndef RTI_BVH_STREAM_H
#define RTI_BVH_STREAM_H

#include "bvh_packet.h"

#ifdef STREAM_NOINLINE
#define STREAM_PART __attribute__((noinline, unused)) static
#else
#define STREAM_PART RTI_VEC
#endif

#define STREAM       1024u
#define STREAM_FEW   1u
#define STREAM_LIST  (16u * STREAM) /* numbers in all lists; rays for which there is no room go by themselves */
#define STREAM_STACK (RTK_BVH_STACK + RTK_BVH_WIDTH)
#define STREAM_BYTES ((size_t)16 << 20) /* of a tree through which streams go by turns */

/* A ray against boxes; t1 is where its best hit is, when that is nearer than where it leaves the part. */
typedef struct stream_ray {
    float inv[3], start[3], t0, t1; /* start: org * inv */
} stream_ray;

/* A ray against triangles, in its own order of axes, as in rti_tri_ray. */
typedef struct stream_tri {
    float ox, oy, oz, sx, sy, kdz, tmin, tmax;
} stream_tri;

/* A ray's best hit: where late is not RTK_INVALID, that of the triangle at this place; else the one that stands among the batch's
 * hits. A hit for certain of which the leaf test's first half doubts where it is, is put aside: t1 is then a bound of it and t
 * the other, smaller one. It is decided with others of its kind at the end, or alone when what comes next lies between its
 * bounds. Whose the best hit is, is not asked before the end either: references and triangles are seldom in the nearer caches,
 * and then all rays' are waited for at once. */
typedef struct stream_hit {
    float t, u, v;
    rtk_u32 late;
} stream_hit;

typedef struct stream {
    _Alignas(64) stream_ray ray[STREAM];
    stream_tri tri[STREAM];
    stream_hit hit[STREAM];
    rtk_u32 number[STREAM]; /* in the batch */
    float kind[STREAM];     /* dominant axis */
    uint16_t list[STREAM_LIST + 16u];
    /* What waits: a node, or a leaf as in rtk_bvhnode; where the first of its rays enters it; its list: where that begins, and in
     * the upper half how long it is. */
    rtk_u32 child[STREAM_STACK], count[STREAM_STACK], lists[STREAM_STACK];
    float enter[STREAM_STACK];
    rtk_u32 n, top;
} stream;

typedef struct streams {
    stream of[8]; /* an octant's each */
    uint16_t now[STREAM];
    uint8_t bits[STREAM + 16u]; /* of a node's rays */
    const rtk_scene *scene;
    const rtk_trace_block *blocks; /* the batch */
    rtk_hit_block *hits;
    uint16_t *occluded;
    const rti_scratch *scratch;
    const rtk_part *part;
    rtk_tree tree;
    rtk_u32 turns; /* all octants' streams go by turns */
} streams;

_Static_assert(sizeof(streams) <= RTI_TRACE_ROOM, "streams fit into a room");

RTI_VEC void streams_begin(streams *a, const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits,
                           uint16_t *occluded, const rti_scratch *scratch)
{
    a->scene = scene;
    a->blocks = rays;
    a->hits = hits;
    a->occluded = occluded;
    a->scratch = scratch;
    for (rtk_u32 i = 0u; i < 8u; i++)
        a->of[i].n = 0u;
}

RTI_VEC void streams_part(streams *a, const rtk_part *part, const rtk_tree *tree)
{
    a->part = part;
    a->tree = *tree;
    a->turns = a->scratch->turns || tree->block_count > STREAM_BYTES / sizeof *tree->blocks;
}

/* May the rays of a group go this way? */
RTI_VEC int stream_fits(const rtk_group *g, const rtk_part *part)
{
    return (g->flags & RTK_GROUP_PLAIN) && g->shape_count == 0u && part->RTK_TREE.block_count != 0u;
}

/* ---- one ray by itself ---- */

/* A ray as a query, with the best hit of the batch's. */
RTI_VEC void stream_query(const streams *a, rtk_u32 number, rtk_query *q)
{
    rti_lane_query(q, a->scene, a->blocks, number, a->scratch);
    if (a->hits) {
        const rtk_hit_block *h = &a->hits[number / RTK_BLOCK];
        const rtk_u32 k = number % RTK_BLOCK;
        q->best = (rtk_hit){h->t[k], h->u[k], h->v[k], h->prim[k], h->geom[k], h->inst[k]};
    }
}

RTI_VEC void stream_keep(const streams *a, rtk_u32 number, rtk_hit hit)
{
    rtk_hit_block *h = &a->hits[number / RTK_BLOCK];
    const rtk_u32 k = number % RTK_BLOCK;
    h->t[k] = hit.t;
    h->u[k] = hit.u;
    h->v[k] = hit.v;
    h->prim[k] = hit.prim;
    h->geom[k] = hit.geom;
    h->inst[k] = hit.inst;
}

/* Any hit: the ray has one. */
RTI_VEC void stream_done(const streams *a, stream *s, rtk_u32 l)
{
    a->occluded[s->number[l] / RTK_BLOCK] |= (uint16_t)(1u << s->number[l] % RTK_BLOCK);
    s->ray[l].t1 = -RTK_INF;
}

/* A reference by the leaf test itself. */
static void stream_ask_plain(const streams *a, stream *s, rtk_u32 l, rtk_u32 mode, rtk_u32 ref)
{
    const rtk_part *part = a->part;
    rtk_query q;
    rtk_pray r;
    stream_query(a, s->number[l], &q);
    if (!rtk_ray_prepare(q.ray, part->lo, part->hi, part->scale, &r))
        return;
    if (rtk_query_prim(&q, mode, &r, ref)) {
        stream_done(a, s, l);
    } else if (!(mode & RTK_MODE_ANY)) {
        stream_keep(a, s->number[l], q.best);
        s->hit[l].t = q.best.t;
        s->ray[l].t1 = rtk_min(s->ray[l].t1, q.best.t);
    }
}

/* A ray's best hit is among the batch's. */
static void stream_settle(const streams *a, stream *s, rtk_u32 l)
{
    const stream_hit h = s->hit[l];
    const rtk_hit_block *known = &a->hits[s->number[l] / RTK_BLOCK];
    const rtk_u32 k = s->number[l] % RTK_BLOCK;
    if (h.late == RTK_INVALID)
        return;
    const rtk_u32 ref = a->tree.refs[h.late];
    s->hit[l].late = RTK_INVALID;
    if (h.t < s->ray[l].t1) { /* put aside; nothing is in front of it */
        stream_ask_plain(a, s, l, 0u, ref);
        s->ray[l].t1 = rtk_min(s->ray[l].t1, s->hit[l].t);
        return;
    }
    const rtk_tri *tri = &a->scene->groups->tris[ref];
    if (rtk_hit_less(h.t, RTK_INVALID, tri->geom, tri->prim, known->t[k], known->inst[k], known->geom[k], known->prim[k]))
        stream_keep(a, s->number[l], (rtk_hit){h.t, h.u, h.v, tri->prim, tri->geom, RTK_INVALID});
}

static void stream_ask(const streams *a, stream *s, rtk_u32 l, rtk_u32 mode, rtk_u32 ref)
{
    if (!(mode & RTK_MODE_ANY))
        stream_settle(a, s, l);
    stream_ask_plain(a, s, l, mode, ref);
}

/* The triangle at a place, which the leaf test's first half doubts. certain: it is a hit, no farther than `off` from t. */
static void stream_doubt(const streams *a, stream *s, rtk_u32 l, rtk_u32 mode, rtk_u32 place, rtk_u32 certain, float t, float off)
{
    const rtk_bvhblock *b = &a->tree.blocks[place / 4u];
    const rtk_u32 j = place % 4u;
    const rtk_u32 kz = (rtk_u32)s->kind[l], kx = kz == 2u ? 0u : kz + 1u, ky = kx == 2u ? 0u : kx + 1u;
    const stream_tri *r = &s->tri[l];
    const float far = s->ray[l].t1;
    const rti_tri_pair pair = {r->ox,  r->oy, r->oz,          r->sx,   r->sy,
                               r->kdz, 0.0f,  a->part->scale, r->tmin, mode & RTK_MODE_ANY ? r->tmax : rtk_min(r->tmax, far)};
    const float c0[3] = {b->v0[kx][j], b->v0[ky][j], b->v0[kz][j]}, c1[3] = {b->v1[kx][j], b->v1[ky][j], b->v1[kz][j]};
    const float c2[3] = {b->v2[kx][j], b->v2[ky][j], b->v2[kz][j]};
    float within[2] = {t - off, t + off};
    const int sure = certain ? 1 : rti_tri_settle(&pair, c0, c1, c2, within);
    if (sure < 0 || (certain && !(mode & RTK_MODE_ANY) && within[0] > pair.tmax))
        return;
    if (sure > 0 && (mode & RTK_MODE_ANY)) {
        stream_done(a, s, l);
        return;
    }
    if (sure == 0 || within[1] >= s->hit[l].t || !(within[0] < within[1]) || !(within[0] < far)) {
        stream_ask(a, s, l, mode, a->tree.refs[place]);
        return;
    }
    s->hit[l].t = within[0];
    s->hit[l].late = place;
    s->ray[l].t1 = rtk_min(far, within[1]);
    __builtin_prefetch(&a->tree.refs[place]);
}

/* A hit for certain of the triangle at a place. */
RTI_VEC void stream_take(const streams *a, stream *s, rtk_u32 l, rtk_u32 mode, rtk_u32 place, float t, float u, float v)
{
    stream_hit *h = &s->hit[l];
    const float far = s->ray[l].t1;
    if (mode & RTK_MODE_ANY) {
        stream_done(a, s, l);
    } else if (t < h->t) {
        *h = (stream_hit){t, u, v, place};
        s->ray[l].t1 = rtk_min(far, t);
        __builtin_prefetch(&a->tree.refs[place]);
    } else if (t == h->t && !(h->t < far) && h->late != RTK_INVALID) { /* triangles stand in the order of hits */
        if (a->tree.refs[place] < a->tree.refs[h->late])
            *h = (stream_hit){t, u, v, place};
    } else if (t <= far || t == h->t) { /* between the bounds, or as near: the order of hits decides */
        stream_ask(a, s, l, mode, a->tree.refs[place]);
    }
}

/* ---- leaves ---- */

/* Triangles for one ray. */
RTI_VEC void stream_leaf_one(const streams *a, stream *s, rtk_u32 mode, rtk_u32 l, rtk_u32 at, rtk_u32 count)
{
    const rtk_u32 kz = (rtk_u32)s->kind[l], kx = kz == 2u ? 0u : kz + 1u, ky = kx == 2u ? 0u : kx + 1u;
    const rtk_u32 end = (at + count + 3u) / 4u;
    const stream_tri *o = &s->tri[l];
    const rti_tri_ray4 r = {rti_f4_set(o->ox), rti_f4_set(o->oy),         rti_f4_set(o->oz),   rti_f4_set(o->sx),
                            rti_f4_set(o->sy), rti_f4_set(o->kdz),        rti_f4_set(o->tmin), rti_f4_set(o->tmax),
                            rti_f4_set(0.0f),  rti_f4_set(a->part->scale)};
    for (rtk_u32 k = at / 4u; k < end; k++) {
        const rtk_bvhblock *b = &a->tree.blocks[k];
        const rti_f4 p0[3] = {rti_f4_load(b->v0[kx]), rti_f4_load(b->v0[ky]), rti_f4_load(b->v0[kz])};
        const rti_f4 p1[3] = {rti_f4_load(b->v1[kx]), rti_f4_load(b->v1[ky]), rti_f4_load(b->v1[kz])};
        const rti_f4 p2[3] = {rti_f4_load(b->v2[kx]), rti_f4_load(b->v2[ky]), rti_f4_load(b->v2[kz])};
        rti_tri_hit4 hit;
        float t[4], u[4], v[4], off[4];
        rtk_u32 bits = rti_tri4(&r, p0, p1, p2, 15u, &hit), last = RTK_INVALID;
        if (bits == 0u)
            continue;
        rti_f4_store(t, hit.t);
        rti_f4_store(u, hit.u);
        rti_f4_store(v, hit.v);
        for (; bits != 0u; bits &= bits - 1u) {
            const rtk_u32 i = (rtk_u32)__builtin_ctz(bits), place = 4u * k + i;
            if (hit.doubt >> i & 1u) {
                if (a->tree.refs[place] == last) /* a block's last triangle stands in the lanes that are left */
                    continue;
                last = a->tree.refs[place];
                rti_f4_store(off, hit.off);
                stream_doubt(a, s, l, mode, place, hit.certain >> i & 1u, t[i], off[i]);
            } else {
                stream_take(a, s, l, mode, place, t[i], u[i], v[i]);
            }
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
    rtk_u32 last = RTK_INVALID, ray = RTK_INVALID;
    V(store)(t, hit->t);
    V(store)(u, hit->u);
    V(store)(v, hit->v);
    V(store)(off, hit->off);
    for (rtk_u32 bits = hit->hit | hit->doubt; bits != 0u; bits &= bits - 1u) {
        const rtk_u32 j = (rtk_u32)__builtin_ctz(bits), place = 4u * k + j % 4u, l = lane[j / 4u];
        if ((mode & RTK_MODE_ANY) && s->ray[l].t1 == -RTK_INF)
            continue;
        if (hit->doubt >> j & 1u) {
            if (j / 4u == ray && a->tree.refs[place] == last) /* a block's last triangle fills it up */
                continue;
            last = a->tree.refs[place];
            ray = j / 4u;
            stream_doubt(a, s, l, mode, place, hit->certain >> j & 1u, t[j], off[j]);
        } else {
            stream_take(a, s, l, mode, place, t[j], u[j], v[j]);
        }
    }
}

/* The blocks of a leaf for some rays, four rays by four triangles at a time: lane 4 r + t is ray r and triangle t. */
RTI_VEC void stream_leaf_fours(const streams *a, stream *s, rtk_u32 mode, const uint16_t *ids, rtk_u32 n, rtk_u32 at,
                               rtk_u32 count)
{
    const rtk_u32 end = (at + count + 3u) / 4u;
    const vec inf = V(set)(RTK_INF);
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
        const rtk_u32 want = (1u << 4u * some) - 1u;
        for (rtk_u32 k = at / 4u; k < end; k++) {
            const rtk_bvhblock *b = &a->tree.blocks[k];
            const vec a0 = rti_f16_twelve(b->v0[0]), a1 = rti_f16_twelve(b->v1[0]), a2 = rti_f16_twelve(b->v2[0]);
            const vec v0[3] = {rti_f16_take(a0, x), rti_f16_take(a0, y), rti_f16_take(a0, z)};
            const vec v1[3] = {rti_f16_take(a1, x), rti_f16_take(a1, y), rti_f16_take(a1, z)};
            const vec v2[3] = {rti_f16_take(a2, x), rti_f16_take(a2, y), rti_f16_take(a2, z)};
            tri_hit hit;
            if (tri_test(&r, v0, v1, v2, want, &hit) == 0u)
                continue;
            if (!(mode & RTK_MODE_ANY)) {
                const vec best = rti_f16_each(&s->hit[0].t, four), t = V(select)(VM(of)(hit.hit), hit.t, inf),
                          least = rti_f16_least4(t);
                const rtk_u32 near = hit.hit & VM(bits)(V(eq)(t, least)), take = near & VM(bits)(V(lt)(least, best));
                const rtk_u32 twice = near & ((near << 1 & 0xeeeeu) | (near << 2 & 0xccccu) | (near << 3 & 0x8888u));
                const rtk_u32 before = near & VM(bits)(V(le)(least, rti_f16_each(&s->ray[0].t1, eight)));
                if (__builtin_expect((hit.doubt | twice | (before ^ take)) == 0u, 1)) {
                    rti_f16_keep4(&s->hit[0].t, &s->ray[0].t1, four, eight, take, hit.t, hit.u, hit.v, 4u * k);
                    continue;
                }
            } else if (hit.doubt == 0u) {
                for (rtk_u32 m = 0u; m < 4u; m++)
                    if (hit.hit >> (4u * m) & 15u)
                        stream_done(a, s, lane[m]);
                continue;
            }
            const tri_hit more = hit; /* of copies: what has its address taken is in no register */
            stream_fours_each(a, s, mode, &more, lane, k);
        }
    }
}
#endif

/* A leaf for a list, of which rays that have found nearer hits since are left out. */
STREAM_PART void stream_leaf(streams *a, stream *s, rtk_u32 mode, const uint16_t *list, rtk_u32 size, rtk_u32 at, rtk_u32 count,
                             float enter)
{
    const uint16_t *ids = a->now;
    rtk_u32 n = 0u;
    for (rtk_u32 i = 0u; i < size; i++) {
        a->now[n] = list[i];
        n += s->ray[list[i]].t1 >= enter;
    }
    if (at >= 4u * a->tree.block_count) {
        for (rtk_u32 i = 0u; i < n; i++)
            for (rtk_u32 k = 0u; k < count && s->ray[ids[i]].t1 != -RTK_INF; k++)
                stream_ask(a, s, ids[i], mode, a->tree.refs[at + k]);
        return;
    }
#ifdef RTI_PACK
    if (n > 1u) {
        stream_leaf_fours(a, s, mode, ids, n, at, count);
        return;
    }
#endif
    for (rtk_u32 i = 0u; i < n; i++)
        stream_leaf_one(a, s, mode, ids[i], at, count);
}

/* ---- nodes ---- */

/* Which of a list's rays enter which slots: bits of each; least: where the first of them enters each. Returns all bits. */
STREAM_PART rtk_u32 stream_open(streams *a, const stream *s, rtk_u32 mode, rtk_u32 octant, const rtk_bvhnode *n,
                                const uint16_t *ids, rtk_u32 size, float least[RTK_BVH_WIDTH])
{
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
        low[h] = NODE(set)(mode & RTK_MODE_ANY ? -3.0e38f : RTK_INF); /* any hit needs no order */
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

RTI_VEC void stream_expect(const rtk_tree *tree, rtk_u32 child, rtk_u32 count)
{
    const uintptr_t node = (uintptr_t)tree->bvh + child * sizeof *tree->bvh;
    const uintptr_t block = (uintptr_t)tree->blocks + child / 4u * sizeof *tree->blocks;
    const uintptr_t at = count == 0u ? node : block; /* a number: it may be in no object */
    __builtin_prefetch((const void *)at);
    __builtin_prefetch((const void *)(at + 64u));
    __builtin_prefetch((const void *)(at + 128u));
    __builtin_prefetch((const void *)(at + 192u));
}

/* The numbers in the list of a slot: of `size` of ids those with its bit. Returns how many. */
RTI_VEC rtk_u32 stream_deal(const streams *a, uint16_t *to, const uint16_t *ids, rtk_u32 size, rtk_u32 slot)
{
    rtk_u32 end = 0u;
#ifdef RTI_PACK
    if (size <= 16u)
        return rti_u16_deal(to, ids, rti_b16_load(a->bits), slot, size);
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

/* The slots `all` of a node onto the stack, with the lists of those of `size` rays that enter them, from `used` on. */
STREAM_PART void stream_push(const streams *a, stream *s, rtk_u32 mode, const rtk_bvhnode *n, rtk_u32 all,
                             const float least[RTK_BVH_WIDTH], const uint16_t *ids, rtk_u32 size, rtk_u32 used)
{
    rtk_u32 slots[RTK_BVH_WIDTH], count = (rtk_u32)__builtin_popcount(all);
#ifdef RTI_PACK
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
    count = 0u;
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
    for (rtk_u32 k = 0u; k < count; k++) {
        const rtk_u32 some = stream_deal(a, s->list + used, ids, size, slots[k]);
        s->lists[s->top++] = used | some << 16;
        used += some;
    }
}

/* A ray that is alone in its list, from a node on: it goes into the nearest of its slots at once, the others wait. */
STREAM_PART void stream_one(streams *a, stream *s, rtk_u32 mode, rtk_u32 octant, rtk_u32 list, rtk_u32 at)
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
                stream_leaf(a, s, mode, s->list + (list & 0xffffu), 1u, at, count, t[i]);
            return;
        }
    }
}

/* ---- streams ---- */

typedef struct stream_axes {
    vmask first, second;
} stream_axes;

/* Of each lane the component along its dominant axis: x, y or z. */
RTI_VEC vec stream_turned(const stream_axes *a, vec x, vec y, vec z)
{
    return V(select)(a->first, x, V(select)(a->second, y, z));
}

/* Rows of eight numbers, of RTI_SIMD rays, as their records. */
RTI_VEC void stream_records(const vec in[8], float out[8u * RTI_SIMD])
{
    float rows[8][RTI_SIMD];
    for (rtk_u32 k = 0u; k < 8u; k++)
        V(store)(rows[k], in[k]);
    for (rtk_u32 i = 0u; i < RTI_SIMD; i += 4u) {
        for (rtk_u32 h = 0u; h < 8u; h += 4u) {
            const rti_f4 from[4] = {rti_f4_load(rows[h] + i), rti_f4_load(rows[h + 1u] + i), rti_f4_load(rows[h + 2u] + i),
                                    rti_f4_load(rows[h + 3u] + i)};
            rti_f4 to[4];
            rti_f4_turn(from, to);
            for (rtk_u32 k = 0u; k < 4u; k++)
                rti_f4_store(out + 8u * (i + k) + h, to[k]);
        }
    }
}

/* `rays` of a packet, prepared for the part, join the streams of their octants, each of which has room for a packet. Returns
 * those that must go another way. */
STREAM_PART uint64_t stream_join(streams *a, const packet *p, uint64_t rays)
{
    uint64_t left = 0u;
    for (uint64_t l = p->masked || p->common == 0u ? rays : 0u; l != 0u; l &= l - 1u) /* those that see nothing */
        rays &= p->mask[__builtin_ctzll(l)] == 0u ? ~(l & (0u - l)) : ~(uint64_t)0u;
    for (rtk_u32 at = 0u; at < PACKET; at += RTI_SIMD) {
        rtk_u32 lanes = packet_bits(rays, at), other = 0u;
        _Alignas(64) float ray[8u * RTI_SIMD], tri[8u * RTI_SIMD];
        vec org[3], dir[3], inv[3], start[3];
        if (lanes == 0u)
            continue;
        for (rtk_u32 k = 0u; k < 3u; k++) {
            org[k] = V(load)(p->org[k] + at);
            dir[k] = V(load)(p->dir[k] + at);
            inv[k] = V(load)(p->inv[k] + at);
            start[k] = org[k] * inv[k];
            other |= lanes & ~VM(bits)(V(le)(V(abs)(start[k]), V(set)(1.0e37f)));
        }
        const vec kind = V(load)(p->kind + at);
        const stream_axes axes = {V(eq)(kind, V(set)(0.0f)), V(eq)(kind, V(set)(1.0f))};
        const vec dz = stream_turned(&axes, dir[0], dir[1], dir[2]);
        const vec slabs[8] = {inv[0],
                              inv[1],
                              inv[2],
                              start[0],
                              start[1],
                              start[2],
                              V(load)(p->t0 + at),
                              V(min)(V(load)(p->t1 + at), V(load)(p->t + at))};
        const vec shear[8] = {stream_turned(&axes, org[1], org[2], org[0]),
                              stream_turned(&axes, org[2], org[0], org[1]),
                              stream_turned(&axes, org[0], org[1], org[2]),
                              stream_turned(&axes, dir[1], dir[2], dir[0]) / dz,
                              stream_turned(&axes, dir[2], dir[0], dir[1]) / dz,
                              dz,
                              V(load)(p->tmin + at),
                              V(load)(p->tmax + at)};
        left |= (uint64_t)other << at;
        stream_records(slabs, ray);
        stream_records(shear, tri);
        for (lanes &= ~other; lanes != 0u; lanes &= lanes - 1u) {
            const rtk_u32 i = (rtk_u32)__builtin_ctz(lanes);
            stream *s = &a->of[p->axis[at + i] >> 2 & 7u];
            const rtk_u32 to = s->n++;
            memcpy(&s->ray[to], ray + 8u * i, sizeof *s->ray);
            memcpy(&s->tri[to], tri + 8u * i, sizeof *s->tri);
            s->hit[to] = (stream_hit){p->t[at + i], 0.0f, 0.0f, RTK_INVALID};
            s->kind[to] = p->kind[at + i];
            s->number[to] = packet_number(p, at + i);
        }
    }
    return left;
}

/* Of n rays, no more than vectors hold, the hits that were put aside. */
static void stream_decide(const streams *a, stream *s, const rtk_u32 *lane, rtk_u32 n)
{
    float x[19][RTI_SIMD] = {{0.0f}};
    vec r[19];
    tri_hit hit;
    for (rtk_u32 i = 0u; i < n; i++) {
        const rtk_u32 l = lane[i], place = s->hit[l].late, j = place % 4u, k = s->number[l] % RTK_BLOCK;
        const rtk_u32 kz = (rtk_u32)s->kind[l], kx = kz == 2u ? 0u : kz + 1u, ky = kx == 2u ? 0u : kx + 1u;
        const rtk_bvhblock *b = &a->tree.blocks[place / 4u];
        const stream_tri *o = &s->tri[l];
        const rtk_trace_block *from = &a->blocks[s->number[l] / RTK_BLOCK];
        const float dir[3] = {from->dx[k], from->dy[k], from->dz[k]};
        const float of[19] = {o->ox,        o->oy,        o->oz,        o->sx,        o->sy,        o->kdz,       o->tmin,
                              o->tmax,      dir[kx],      dir[ky],      b->v0[kx][j], b->v0[ky][j], b->v0[kz][j], b->v1[kx][j],
                              b->v1[ky][j], b->v1[kz][j], b->v2[kx][j], b->v2[ky][j], b->v2[kz][j]};
        for (rtk_u32 m = 0u; m < 19u; m++)
            x[m][i] = of[m];
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
            s->hit[l].t = s->ray[l].t1 = x[0][i];
            s->hit[l].u = x[1][i];
            s->hit[l].v = x[2][i];
        } else { /* the ray starts or ends on an edge */
            stream_settle(a, s, l);
        }
    }
}

/* The hits of a stream go to their places. */
STREAM_PART void stream_end(const streams *a, stream *s)
{
    const rtk_group *g = a->scene->groups;
    rtk_u32 lane[RTI_SIMD], n = 0u, first = 0u, count = 0u, geom = 0u;
    for (rtk_u32 i = 0u; i < s->n; i++) {
        lane[n] = i;
        n += s->hit[i].late != RTK_INVALID && s->hit[i].t < s->ray[i].t1;
        if (n == RTI_SIMD) {
            stream_decide(a, s, lane, n);
            n = 0u;
        }
    }
    if (n != 0u)
        stream_decide(a, s, lane, n);
    for (rtk_u32 i = 0u; i < s->n; i++) {
        const stream_hit h = s->hit[i];
        rtk_hit_block *known = &a->hits[s->number[i] / RTK_BLOCK];
        const rtk_u32 k = s->number[i] % RTK_BLOCK;
        if (h.late == RTK_INVALID)
            continue;
        const rtk_u32 ref = a->tree.refs[h.late];
        if (ref - first >= count) { /* a mesh's triangles stand in their order, side by side */
            geom = g->tris[ref].geom;
            first = g->geoms[geom].first;
            count = g->geoms[geom].prim_count;
        }
        if (h.t == known->t[k] &&
            !rtk_hit_less(h.t, RTK_INVALID, geom, ref - first, known->t[k], known->inst[k], known->geom[k], known->prim[k]))
            continue;
        known->t[k] = h.t;
        known->u[k] = h.u;
        known->v[k] = h.v;
        known->prim[k] = ref - first;
        known->geom[k] = geom;
        known->inst[k] = RTK_INVALID;
    }
}

/* Asks for what the stream's next step reads. */
RTI_VEC void stream_next(const streams *a, const stream *s)
{
    if (s->top != 0u)
        stream_expect(&a->tree, s->child[s->top - 1u], s->count[s->top - 1u]);
}

/* A step of a stream's way: one list to what it waits for. Returns how many rays stand in a->now that found no room in lists. */
RTI_VEC rtk_u32 stream_step(streams *a, rtk_u32 octant, rtk_u32 mode)
{
    stream *s = &a->of[octant];
    const rtk_u32 top = --s->top, list = s->lists[top], begin = list & 0xffffu, size = list >> 16, at = s->child[top],
                  count = s->count[top];
    const float enter = s->enter[top];
    const uint16_t *ids = s->list + begin;
    if (size == 1u && s->ray[ids[0]].t1 < enter)
        return 0u;
    if (count != 0u) {
        stream_next(a, s);
        stream_leaf(a, s, mode, ids, size, at, count, enter);
        return 0u;
    }
    if (size <= STREAM_FEW) {
        stream_one(a, s, mode, octant, list, at);
        stream_next(a, s);
        return 0u;
    }
    const rtk_bvhnode *n = &a->tree.bvh[at];
    float least[RTK_BVH_WIDTH];
    const rtk_u32 all = stream_open(a, s, mode, octant, n, ids, size, least);
    if (begin + (1u + (rtk_u32)__builtin_popcount(all)) * size > STREAM_LIST) {
        memcpy(a->now, ids, size * sizeof *ids);
        return size;
    }
    if (all != 0u)
        stream_push(a, s, mode, n, all, least, ids, size, begin + size); /* its list is read yet */
    stream_next(a, s);
    return 0u;
}

/* All of a stream's rays are at the root. */
RTI_VEC void stream_start(stream *s)
{
    for (rtk_u32 i = 0u; i < s->n; i++)
        s->list[i] = (uint16_t)i;
    s->child[0] = s->count[0] = 0u;
    s->enter[0] = -RTK_INF;
    s->lists[0] = s->n << 16;
    s->top = s->n != 0u;
}

#endif
