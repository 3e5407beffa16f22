/* Rays that have nothing in common, or the octant they point into, through eight-wide nodes together, for hot files.
 *
 * Up to STREAM rays go as a stream. A node is opened once for all of the stream's rays that enter it: the rays pass one after the
 * other, each against all eight boxes, or of long lists, with AVX-512, sixteen at a time, whose numbers are turned so that each
 * of the boxes meets all sixteen, or as the rays lie, where most of them come along (bvh_stream_dense.h). No ray waits for
 * another, and no branch depends on what one meets. Behind that each slot gets the list of the rays that enter it, and the slots
 * go onto a stack, the nearest on top, with their lists. A leaf meets a long list as many rays at a time as vectors have lanes, a
 * triangle after the other, a short one two rays, or four, and four triangles at a time. So what a node or leaf costs beside its
 * rays (to wait for it, to foresee where it leads) is shared by all rays that come there: of bounces of a picture's tile some
 * thirty, where packets of sixteen share it by four, or by one. (Fuetterling, Lojewski, Pfreundt, Hamann 2015; Barringer,
 * Akenine-Moeller 2014: what differs is that lists hold numbers, no copies.) Long lists that are asked for any hit do not meet
 * slots in which none of a stream's rays can be, and those that are left eight or sixteen rays at a time (bvh_stream_region.h).
 *
 * Rays are loaded and dealt to streams as many at a time as vectors have lanes (stream_put), less those that meet none of the
 * root's slots, which where a scene is open are many. There is a stream for each of the eight octants, or rays that point anywhere
 * go together (mode STREAM_MIXED): which is better is another matter (bvh_stream_mix.h). Where a scene has several parts the
 * streams go through one after the other; which of the others a ray may enter is told when it is loaded first.
 *
 * Planes are met at plane * inv - org * inv. The product org * inv is rounded, by 2^-24 of |org| <= RTK_FAR scale, which is a
 * sixteenth of what RTK_GROW holds in reserve (ray.h, theory point 3), as long as it is a normal float, or 2^-150, by which it is
 * rounded below those, is as little beside scale |inv|. Rays that come near either end of the floats' range go by bvh_lanes.inl.
 * This is for triangles in blocks, and shapes (bvh_stream_ball.h), of a group each hit of which counts (stream_fits); what else
 * is among those is asked.
 *
 * Closest hits of rays that start far away (mode STREAM_MOVED): origins are moved as they come (bvh_approach.h), boxes are met from
 * there, and all that the leaf test says, in t as the caller's rays have it, are sums with the shift: so where these are equal, the
 * order of hits decides as it does anyhow. What is not sums, where boxes are entered and where a ray ends for them, is apart.
 */
#ifndef RTI_BVH_STREAM_H
#define RTI_BVH_STREAM_H

#include "bvh_packet.h"

/* Rays of a stream at most, of any hits, and where a core's cache is small, or not known. (Of half a MiB: 1024 with AVX2. In a
 * whole one bounces in rooms are 1.05 to 1.14 times as fast with 4096; occlusion, which is asked where rays are at all, .96 to
 * 1.04, and with 2048 .98 to 1.03.) */
#if RTI_SIMD >= 16
#define STREAM       4096u
#define STREAM_ANY   STREAM
#define STREAM_SHORT STREAM
#elif RTI_SIMD == 8
#define STREAM       4096u
#define STREAM_ANY   2048u
#define STREAM_SHORT 1024u
#else
#define STREAM       2048u
#define STREAM_ANY   STREAM
#define STREAM_SHORT STREAM
#endif
#define STREAM_FRONT  (-3.402823466e38f) /* where rays enter that need no order */
#define STREAM_FEW    1u
#define STREAM_TURNED 16u /* rays of a list from which on they are turned, and each slot of a node meets sixteen */
#define STREAM_LIST   (16u * STREAM - 64u)   /* numbers in all lists; rays for which there is no room go by themselves */
#define STREAM_SLOTS  (STREAM / 16u + 32u)   /* sixteens of a list's rays; what is read and written by vectors goes beyond */
#define STREAM_TOLD   16384u                 /* rays of a batch of which is told which parts they may enter */
#define STREAM_SPARED 8u                     /* as long as of so many times RTI_SIMD rays one misses a part */
#define STREAM_STACK  (RTK_BVH_STACK + RTK_BVH_WIDTH)

/* Beside RTK_MODE_: rays may start far away, closest hits alone; rays point anywhere. */
#define STREAM_MOVED 8u
#define STREAM_MIXED 16u
/* Is it counted how many slots rays enter? (streams_over) */
#define STREAM_TELLS(mode) (((mode) & (RTK_MODE_ANY | STREAM_MIXED)) == STREAM_MIXED)

/* A ray against boxes; t1 is where its best hit is, when that is nearer than where it leaves the part. */
typedef struct stream_ray {
    float inv[3], start[3], t0, t1; /* start: org * inv */
} stream_ray;

/* A ray against triangles, in its own order of axes, as in rti_tri_ray. */
typedef struct stream_tri {
    float ox, oy, oz, sx, sy, kdz, tmin, tmax;
} stream_tri;

/* A ray against spheres, as in rti_ball_ray. */
typedef struct stream_ball {
    float ox, oy, oz, dx, dy, dz, tmin, tmax;
} stream_ball;

/* A ray's best hit: where late is not RTK_INVALID, that of the triangle at this place; else the one that stands among the batch's
 * hits. A hit for certain of which the leaf test's first half doubts where it is, is put aside: t1 is then a bound of it and t
 * the other, smaller one. It is decided with others of its kind at the end, or alone when what comes next lies between its
 * bounds. Whose the best hit is, is not asked before the end either: references and triangles are seldom in the nearer caches,
 * and then all rays' are waited for at once. */
typedef struct stream_hit {
    float t, u, v;
    rtk_u32 late;
} stream_hit;

/* Who a ray is, in words: its dominant axis, its number in the batch, and of closest hits its direction along the other two axes.
 */
#define STREAM_WHO(mode) ((mode)&RTK_MODE_ANY ? 2u : 4u)

#define STREAM_PLACES (STREAM + 8u) /* behind the rays stands what lanes without one write, in octant 0, and vectors read */

typedef struct stream {
    _Alignas(64) stream_ray ray[STREAM_PLACES];
    stream_tri tri[STREAM_PLACES];   /* where a tree has blocks, */
    stream_ball ball[STREAM_PLACES]; /* and where it has balls */
    stream_hit hit[STREAM_PLACES];
    float who[4u * STREAM_PLACES]; /* STREAM_WHO each */
    float far[STREAM_PLACES], shift[STREAM_PLACES]; /* STREAM_MOVED: of sums, what t1 is else; by which the origin was moved */
    uint16_t list[STREAM_LIST + 32u];
#ifdef RTI_PACK
    float wide[STREAM / 16u][8][16]; /* fields of ray[], sixteen rays side by side */
#endif
#ifdef RTI_PACK8
    float low[3], high[3]; /* where its rays are (bvh_stream_region.h), */
    _Alignas(64) float lows[3][RTI_SIMD], highs[3][RTI_SIMD]; /* and of mixed rays each lane's */
#endif
    /* What waits: a node, or a leaf as in rtk_bvhnode; where the first of its rays enters it; its list: where that begins, and in
     * the upper half how long it is. */
    rtk_u32 child[STREAM_STACK], count[STREAM_STACK], lists[STREAM_STACK];
    float enter[STREAM_STACK];
    rtk_u32 n, top;
} stream;

typedef struct streams {
    stream of[8];    /* an octant's each, or mixed */
    rtk_u32 next[8]; /* rays in them that are not on their way yet */
    uint16_t now[STREAM + 32u];
    uint8_t bits[STREAM + 16u];                  /* of a node's rays */
    uint16_t slots[RTK_BVH_WIDTH][STREAM_SLOTS]; /* which enter a slot, sixteen by sixteen */
    const rtk_scene *scene;
    const rtk_trace_block *blocks; /* the batch */
    rtk_hit_block *hits;
    uint16_t *occluded;
    rti_scratch *scratch;
    const float *outer; /* STREAM_MOVED: of each ray of the batch what the top level moved it by (rtk_query.outer), or NULL */
    const rtk_part *part;
    rtk_tree tree;
    uint8_t enters[STREAM_TOLD / RTI_SIMD]; /* which parts behind the first each RTI_SIMD rays may enter, of the batch's first */
    rtk_u32 told, spared;                   /* of how many; how often one is not entered */
    rtk_u32 looked, missed;                 /* rays that were asked for the root's slots, and those that meet none */
    rtk_u32 length, most;                   /* rays of a stream, and numbers in all its lists */
    rtk_u32 turns;                          /* all streams go by turns */
    rtk_u32 mixed, shift;                   /* rays that point anywhere go together: so many bits of a number do not tell where */
    rtk_u32 middles;                        /* boxes may be met by their middles (stream_middles): no product overflows */
    float middle[3][RTK_BVH_WIDTH], half[3][RTK_BVH_WIDTH]; /* those of the root, */
    rtk_u32 roots;                                          /* and how many slots it has */
    rtk_u32 ran, entered;                   /* rays of mixed streams, and slots that they have entered */
} streams;

_Static_assert(sizeof(streams) <= RTI_TRACE_STREAMS, "streams fit into a room");
_Static_assert(STREAM_LIST + 32u <= 0xffffu && STREAM % PACKET == 0, "lists are told in sixteen bits; streams take packets");

RTI_VEC void streams_begin(streams *a, const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits,
                           uint16_t *occluded, rti_scratch *scratch)
{
    a->scene = scene;
    a->blocks = rays;
    a->hits = hits;
    a->occluded = occluded;
    a->scratch = scratch;
    a->outer = NULL;
    a->length = !scratch->roomy ? STREAM_SHORT : (hits ? STREAM : STREAM_ANY);
    a->most = scratch->narrow ? a->length + a->length / 4u : STREAM_LIST; /* then dense ones go a level or two */
    memset(a->next, 0, sizeof a->next);
    a->told = a->spared = 0u;
}

/* May the rays of a group go this way? Of a mesh, or among shapes. */
RTI_VEC int stream_fits(const rtk_group *g, const rtk_part *part)
{
    return (g->flags & RTK_GROUP_PLAIN) && (part->bvh.ball_count != 0u || (part->bvh.block_count != 0u && bvh_mostly_mesh(g)));
}

/* Behind this no box is entered by a ray whose hits' sums with the shift are to be no more than t. */
#define STREAM_REACH 2.3841858e-07f /* 2^-22: the sum is rounded, and what is found here, twice: each 2^-24 of both at most */
RTI_VEC float stream_reach(float t, float shift)
{
    return (t - shift) + STREAM_REACH * (rtk_fabs(t) + rtk_fabs(shift));
}

/* Behind this no hit is looked for. */
RTI_VEC float stream_far(const stream *s, rtk_u32 mode, rtk_u32 l)
{
    return mode & STREAM_MOVED ? s->far[l] : s->ray[l].t1;
}
#ifdef RTI_PACK8
/* stream_far of many rays. */
RTI_VEC vec stream_fars(const stream *s, rtk_u32 mode, const uint16_t lane[RTI_SIMD])
{
    return mode & STREAM_MOVED ? V(column)(s->far, 1u, lane) : V(column)(&s->ray[0].t1, 8u, lane);
}
#endif
RTI_VEC float stream_shift(const stream *s, rtk_u32 mode, rtk_u32 l)
{
    return mode & STREAM_MOVED ? s->shift[l] : 0.0f;
}

/* Behind so many spheres hardly two coherent rays come to the same ones, and packets come apart: a million of them, shadow rays, 10
 * Mrays/s as streams and 2.9 as packets; a thousand, 62 and 64, primary rays 25 and 36. */
#define STREAM_BALLS(mode) ((mode)&RTK_MODE_ANY ? 2048u : 524288u)
#define STREAM_BALLS_LEAST 256u /* rays: of fewer, streams are short */
RTI_VEC int stream_balls_apart(const rtk_group *g, rtk_u32 mode, rtk_u32 count, const rti_scratch *scratch)
{
    return scratch->room && count >= STREAM_BALLS_LEAST && g->shape_count != 0u && g->part_count != 0u &&
           stream_fits(g, g->parts) && g->parts->bvh.ball_count >= STREAM_BALLS(mode);
}

/* Ray l ends at t from now on. */
RTI_VEC void stream_ends(stream *s, rtk_u32 mode, rtk_u32 l, float t)
{
    if (mode & STREAM_MOVED) {
        s->far[l] = t;
        t = t == -RTK_INF ? t : rtk_min(s->ray[l].t1, stream_reach(t, s->shift[l]));
    }
    s->ray[l].t1 = t;
#ifdef RTI_PACK
    s->wide[l / 16u][7][l % 16u] = t;
#endif
}

RTI_VEC rtk_u32 stream_kind(const stream *s, rtk_u32 mode, rtk_u32 l)
{
    return (rtk_u32)s->who[STREAM_WHO(mode) * l];
}
RTI_VEC rtk_u32 stream_number(const stream *s, rtk_u32 mode, rtk_u32 l)
{
    return rtk_bits(s->who[STREAM_WHO(mode) * l + 1u]);
}

/* ---- one ray by itself ---- */

/* A ray as a query, with the best hit of the batch's. */
RTI_VEC void stream_query(const streams *a, rtk_u32 number, rtk_query *q)
{
    rti_lane_query(q, a->scene, a->blocks, number, a->scratch);
    if (a->hits)
        q->best = rti_lane_best(a->hits, number);
}

RTI_VEC void stream_keep(const streams *a, rtk_u32 number, rtk_hit hit)
{
    rti_lane_keep(a->hits, number, hit);
}

/* Any hit: the ray has one. */
RTI_VEC void stream_occluded(const streams *a, rtk_u32 number)
{
    a->occluded[number / RTK_BLOCK] |= (uint16_t)(1u << number % RTK_BLOCK);
}
RTI_VEC void stream_done(const streams *a, stream *s, rtk_u32 l)
{
    stream_occluded(a, stream_number(s, RTK_MODE_ANY, l));
    stream_ends(s, RTK_MODE_ANY, l, -RTK_INF);
}

/* A ray as a query that is ready for the part; 0: it misses that. */
RTI_VEC int stream_ready(const streams *a, rtk_u32 number, rtk_query *q, rtk_pray *r)
{
    rtk_ray ray;
    stream_query(a, number, q);
    ray = q->ray;
    if (a->outer && a->outer[number] != 0.0f) { /* RTK_NAME(instance) */
        q->outer = a->outer[number];
        ray.tmin = -RTK_INF;
        ray.tmax = RTK_INF;
    }
    return rtk_ray_prepare(ray, a->part->lo, a->part->hi, a->part->scale, r);
}

/* A reference by the leaf test itself. */
static void stream_ask_plain(const streams *a, stream *s, rtk_u32 l, rtk_u32 mode, rtk_u32 ref)
{
    rtk_query q;
    rtk_pray r;
    if (!stream_ready(a, stream_number(s, mode, l), &q, &r))
        return;
    if (rtk_query_prim(&q, mode, &r, ref)) {
        stream_done(a, s, l);
    } else if (!(mode & RTK_MODE_ANY)) {
        stream_keep(a, stream_number(s, mode, l), q.best);
        s->hit[l].t = q.best.t;
        stream_ends(s, mode, l, rtk_min(stream_far(s, mode, l), q.best.t));
    }
}

/* A ray's best hit is among the batch's. */
static void stream_settle(const streams *a, stream *s, rtk_u32 mode, rtk_u32 l)
{
    const stream_hit h = s->hit[l];
    if (h.late == RTK_INVALID)
        return;
    const rtk_u32 ref = a->tree.refs[h.late];
    s->hit[l].late = RTK_INVALID;
    if (h.t < stream_far(s, mode, l)) { /* put aside; nothing is in front of it */
        stream_ask_plain(a, s, l, mode, ref);
        stream_ends(s, mode, l, rtk_min(stream_far(s, mode, l), s->hit[l].t));
        return;
    }
    const rtk_group *g = a->scene->groups;
    const rtk_u32 geom = ref < g->tri_count ? g->tris[ref].geom : g->shapes[ref - g->tri_count].geom;
    const rtk_u32 prim = ref < g->tri_count ? g->tris[ref].prim : g->shapes[ref - g->tri_count].prim;
    stream_keep(a, stream_number(s, 0u, l),
                (rtk_hit){h.t, h.u, h.v, prim, geom, RTK_INVALID}); /* nearer than what stands there */
}

static void stream_ask(const streams *a, stream *s, rtk_u32 l, rtk_u32 mode, rtk_u32 ref)
{
    if (!(mode & RTK_MODE_ANY))
        stream_settle(a, s, mode, l);
    stream_ask_plain(a, s, l, mode, ref);
}

/* Whether ray l's best hit is of the triangle at a place: leaves of cells and of spatial splits repeat triangles, and what is
 * put aside need not be asked because it is met again. */
RTI_VEC int stream_is(const streams *a, const stream *s, rtk_u32 l, rtk_u32 place)
{
    const rtk_u32 late = s->hit[l].late;
    return late != RTK_INVALID && a->tree.refs[late] == a->tree.refs[place];
}

/* The triangle at a place, which the leaf test's first half doubts. certain: it is a hit, no farther than `off` from t. */
static void stream_doubt(const streams *a, stream *s, rtk_u32 l, rtk_u32 mode, rtk_u32 place, rtk_u32 certain, float t, float off)
{
    const stream_tri *r = &s->tri[l];
    const float far = stream_far(s, mode, l), shift = stream_shift(s, mode, l);
    float within[2] = {t - off, t + off};
    int sure = 1;
    if (!certain) {
        const rtk_bvhblock *b = &a->tree.blocks[place / 4u];
        const rtk_u32 j = place % 4u;
        const rtk_u32 kz = stream_kind(s, mode, l), kx = kz == 2u ? 0u : kz + 1u, ky = kx == 2u ? 0u : kx + 1u;
        const rti_tri_pair pair = {r->ox,  r->oy, r->oz,          r->sx,   r->sy,
                                   r->kdz, shift, a->part->scale, r->tmin, mode & RTK_MODE_ANY ? r->tmax : rtk_min(r->tmax, far)};
        const float c0[3] = {b->v0[kx][j], b->v0[ky][j], b->v0[kz][j]}, c1[3] = {b->v1[kx][j], b->v1[ky][j], b->v1[kz][j]};
        const float c2[3] = {b->v2[kx][j], b->v2[ky][j], b->v2[kz][j]};
        sure = rti_tri_settle(&pair, c0, c1, c2, within);
    }
    if (sure < 0 || (certain && !(mode & RTK_MODE_ANY) && within[0] > rtk_min(r->tmax, far)))
        return;
    if (sure > 0 && (mode & RTK_MODE_ANY)) {
        stream_done(a, s, l);
        return;
    }
    if (sure == 0 || within[1] >= s->hit[l].t || !(within[0] < within[1]) || !(within[0] < far)) {
        if (mode & RTK_MODE_ANY || !stream_is(a, s, l, place))
            stream_ask(a, s, l, mode, a->tree.refs[place]);
        return;
    }
    s->hit[l].t = within[0];
    s->hit[l].late = place;
    stream_ends(s, mode, l, rtk_min(far, within[1]));
    __builtin_prefetch(&a->tree.refs[place]);
}

RTI_VEC int stream_blocked(const streams *a, rtk_u32 place)
{
    return place < RTK_BVH_BLOCK * a->tree.block_count;
}

/* A hit for certain of the triangle, or of the sphere, at a place. */
RTI_VEC void stream_take(const streams *a, stream *s, rtk_u32 l, rtk_u32 mode, rtk_u32 place, float t, float u, float v)
{
    stream_hit *h = &s->hit[l];
    const float far = stream_far(s, mode, l);
    if (mode & RTK_MODE_ANY) {
        stream_done(a, s, l);
    } else if (t < h->t) {
        *h = (stream_hit){t, u, v, place};
        stream_ends(s, mode, l, rtk_min(far, t));
        __builtin_prefetch(&a->tree.refs[place]);
    } else if (t == h->t && !(h->t < far) && h->late != RTK_INVALID && stream_blocked(a, h->late) == stream_blocked(a, place)) {
        /* triangles stand in the order of hits, and so do spheres */
        if (a->tree.refs[place] < a->tree.refs[h->late])
            *h = (stream_hit){t, u, v, place};
    } else if ((t <= far || t == h->t) && !stream_is(a, s, l, place)) { /* between the bounds, or as near: their order decides */
        stream_ask(a, s, l, mode, a->tree.refs[place]);
    }
}

/* What the leaf test has said in vectors of a ray and the triangle at a place, which are lane i there. */
RTI_VEC void stream_met(const streams *a, stream *s, rtk_u32 l, rtk_u32 mode, rtk_u32 place, rtk_u32 doubt, rtk_u32 certain,
                        const float *t, const float *u, const float *v, const float *off, rtk_u32 i)
{
    if ((mode & RTK_MODE_ANY) && s->ray[l].t1 == -RTK_INF)
        return;
    if (doubt >> i & 1u)
        stream_doubt(a, s, l, mode, place, certain >> i & 1u, t[i], off[i]);
    else
        stream_take(a, s, l, mode, place, t[i], u[i], v[i]);
}

#endif
