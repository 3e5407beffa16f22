/* Rays of a tile that pass through one point, for hot files: how a pencil is made. pencil_walk.h has its way through a tree.
 *
 * Up to PENCIL blocks of sixteen rays go together when their lines pass through one point, the apex: the eye, a point light that
 * they end at, or the eye's image in a mirror. Seen from there a ray is two numbers, its slopes along the axis that all rays
 * mainly follow, and a block of rays is a rectangle of slopes. A node's boxes are asked for all blocks by the rectangle around
 * theirs; of those that it meets, each for as many rectangles at once as vectors have lanes, a lane a block. Of a triangle the
 * edge functions of the leaf test are linear in the slopes, so what they are at a rectangle's worst corner is told in a few
 * operations, again a lane a block. Rays are looked at one by one only by the leaf test itself, of the blocks that are left. So
 * what does not depend on the number of rays is shared by hundreds of them, and hardly a triangle is tested for sixteen rays that
 * all miss it.
 * (Reshetov, Soupikov, Hurley 2005; Dmitriev, Havran, Seidel 2004; Benthin, Wald 2009. What differs: lanes are rectangles of
 * rays; all bounds are proved to keep every hit of the leaf test.)
 *
 * What is found of a pencil's rays is the same for each part of a group. So it goes through all of them, one after the other; that
 * its rays are near enough to one point, and to the part, is asked of the rays with the largest part's scale, and of the pencil
 * with each part's own (pencil_enter_part).
 *
 * Depth is measured from the apex along that axis, the way that rays run from it, or, where they run to it, against their way:
 * it is positive where rays are looked at. What bounds allow for: u = 2^-24, S = scale of the part, P = greatest coordinate of
 * apex and origins, P <= RTK_FAR S where an origin is concerned.
 *   off     how far a ray's line is from the apex, measured at the apex' depth along both other axes, and 16 u (P + S) for that
 *           measurement's own roundings, which are 12 u P
 *   boxes   of a ray, a slope is off by u of itself, of a way of at most P + S; a coordinate less the apex' by u (P + S);
 *           quotients are made wider by 16 u of themselves, which holds what their terms are rounded by; and where a ray starts
 *           less deep than the apex, by 16 u (P + S) at most, it is looked at from there on, as far to a side of where it is.
 *           With off's own roundings that is less than off + 32 u P + 20 u S. Boxes are grown by 2^-17 S where hits lie within
 *           2^-18 S (ray.h, points 2 and 3): of the 64 u S between, spatial splits round by 8 and builders by 1. So they are
 *           widened by off + 64 u P alone. Those of cells (of kd-trees and octrees) are cut to them, beyond which nothing
 *           is held in reserve: these by off + 64 u (P + S). (A room on a floor 36 times as wide: shadow rays 1.11 times as fast.)
 *           (Rays are not asked whether they meet the part, as rtk_ray_prepare asks: by points 2 and 3 those that hit do. Nor is
 *           the apex held to a bound: where products overflow, a triangle is not told from one that is met.)
 *   depths  of origins and ends are rounded by 4 u of P and of the way; 16 u of each, and 48 u (P + S), are allowed for
 *   edges   the leaf test's sheared corners are those of a ray through the apex, but for what was measured as off, 6 u P for
 *           that, and 6 u (P + S); those here, of the middle slopes, for 6 u (P + S) more: e is what was measured and 24 u (P + S).
 *           For S the corners' own greatest coordinate does, which is no more than the apex' and what they are away from there;
 *           with what stands next, which keeps e beside small ones above what denormal products lose.
 *           Where all rays start at the apex, both are made of the same differences X and Z: x = X - slope Z is rounded by
 *           u (|Z| + |x|) there and here, and the slopes' difference by u of itself: e = 4 u of the greatest |Z|, twice what is
 *           needed, and at least 10^-9 S, beside which the 2^-150 that denormal products lose are nothing. (So triangles smaller
 *           than a pixel are told, too: breakfast's primary rays 1.12 times as fast as with the other e, others 1.00 to 1.02.)
 *           With H the greatest difference of a slope from the middle, and of each corner s = max(|x|, |y|) + H |z|, its x and y
 *           at any ray of the pencil are no more than s, so of the greatest s of the three corners an edge function there differs
 *           from what is told here by less than (s + e) (4 e + 32 u s): four products, each with one factor wrong by e and 3 u s,
 *           and roundings of products that add up to less than 2 s s, six each here at most and two there. The leaf test's signs
 *           are those of its corners exactly, so below minus that an edge function is negative there, too. det differs by less
 *           than four times as much: three edge functions, and roundings of their sums and of what they grow by.
 *   told    where det has one sign for all rays, no |x| or |y| is more than s + e + 2 u s, no |det| less than the middle's less
 *           what it changes by, and depths of corners differ by no more than here and e: so much bounds what the leaf test asks of
 *           a hit, for its weights are not negative and add up to less than 1 + 4 u: q <= (s + e)^2 / |det|, its e <= (10 + 11 q)
 *           times the depths' difference. Where that would do at the hit's depth it is not found ray by ray; a sixtieth is left
 *           for roundings. (Primary rays of rooms 1.03 to 1.07 times as fast.)
 */
#ifndef RTI_PENCIL_H
#define RTI_PENCIL_H

#include "bvh_packet_walk.h"

#if RTI_SIMD >= 16
#define PENCIL  32u /* blocks */
#define BUNDLES 64u /* that these may become */
typedef uint64_t pencil_bits; /* a bit a bundle */
#define PENCIL_FIRST(bits) ((rtk_u32)__builtin_ctzll(bits))
#define PENCIL_COUNT(bits) ((rtk_u32)__builtin_popcountll(bits))
#else
#define PENCIL  16u
#define BUNDLES 32u
typedef rtk_u32 pencil_bits;
#define PENCIL_FIRST(bits) ((rtk_u32)__builtin_ctz(bits))
#define PENCIL_COUNT(bits) ((rtk_u32)__builtin_popcount(bits))
#endif
#define PENCIL_ONE(bundle) ((pencil_bits)1u << (bundle))
#define PENCIL_RAYS        (PENCIL * RTK_BLOCK)
#define PENCIL_LOST        4u             /* times that rays are no pencil before the rest of a batch is not tried */
#define PENCIL_MAIL        64u
#define PENCIL_LEAD        8u             /* blocks that are asked for before they are looked at */
#define PENCIL_U           9.5367432e-07f /* 16 u */
#define PENCIL_HALVES      (RTK_BLOCK / RTI_SIMD)

/* Between which depths x is from a to b, for slopes from lo to hi of a rectangle a lane: from max(a in[0], b in[1]) on, and up to
 * min(a out[0] + more[0], b out[1] + more[1]). */
typedef struct pencil_ways {
    _Alignas(64) float in[2][BUNDLES], out[2][BUNDLES], more[2][BUNDLES];
} pencil_ways;

typedef struct pencil {
    _Alignas(64) float slope[2][PENCIL][RTK_BLOCK]; /* along kx and ky */
    float to[PENCIL][RTK_BLOCK];                    /* the depth that a ray reaches to */
#ifdef RTI_PACK8
    /* Rays side by side, of the blocks in `recorded`: origin, slopes and direction along kx, ky, kz, tmin, tmax. */
    _Alignas(64) float record[PENCIL][RTK_BLOCK][8];
#endif
    rtk_u32 recorded;
    /* Of each bundle, rays of one block that walk: corner[k][0] the least, corner[k][1] the greatest of slope k less the middle
     * one; the depths between which hits are looked for. */
    _Alignas(64) float corner[2][2][BUNDLES];
    float from[BUNDLES], reach[BUNDLES];
    pencil_ways ways[2];
    uint16_t live[BUNDLES];
    uint8_t block[BUNDLES];
    rtk_u32 end;     /* bundles that are looked at: whole vectors from PENCIL to BUNDLES of them */
    pencil_bits bundles; /* those with rays, a bit each */
    /* Of all of them. */
    rtk_u32 kx, ky, kz;
    float turn;                     /* 1 or -1: depth is turn * (z - apex z) */
    float apex[3], low[3], high[3]; /* the apex, in the order kx, ky, kz, and less and more a box' margin */
    float around, edge; /* a box' margin; of edges e, unless `one`, less what corners add */
    float most[2], middle[2]; /* H, and the middle slopes */
    float deepest;                  /* no bundle looks farther */
    pencil_ways all[2];             /* of the rectangle around all, in the first lanes */
    rtk_u32 away;                   /* rays run from the apex, not to it */
    rtk_u32 one;                    /* all rays start at the apex exactly */
    pencil_bits changed;            /* closest hits: bundles whose reach is to be found anew */
    float far, size;      /* greatest coordinates of origins, and of the apex */
    float off, least;     /* greatest distance of a line from the apex; least depth of an origin */
    float scale;          /* of the largest part */
    float margin;         /* off + 64 u (P + S) with it: of depths, which one part finds and the next one keeps to */
    const rtk_scene *scene;
    const rtk_part *part; /* that is walked */
    rtk_u32 which;        /* its number */
    const rtk_trace_block *batch;
    rtk_hit_block *all_hits;
    uint16_t *all_occluded;
    rti_scratch *scratch;
    /* Any hit: of each part the leaf where rays were met last (NULL: none yet), which is looked through before all others: what
     * stands in the light for a pencil mostly does for the next one. met: of the leaf that is looked through, some were. */
    struct {
        const rtk_bvhnode *node;
        rtk_u32 slot;
    } blocker[RTK_PARTS];
    rtk_u32 met;
    rtk_u32 lost;         /* so many times one after the other rays were no pencil */
    rtk_u32 apart;        /* one has come apart */
    rtk_u32 leaves, told; /* of one: leaves it looked through, and how many rays meet their boxes */
    /* Where leaves repeat triangles, of some the bundles that have met them; PENCIL_MAIL of them, by their numbers. */
    struct {
        pencil_bits bundles;
        rtk_u32 ref;
    } mail[PENCIL_MAIL];
    rtk_u32 repeats; /* they do */
    rtk_u32 first; /* the pencil's first ray, a number in the batch; from it on: */
    const rtk_trace_block *rays;
    rtk_hit_block *hits;
    uint16_t *occluded;
    rtk_u32 count;              /* its rays */
    rtk_u32 again;              /* something was asked for them before, and their hits so far stand in the batch */
    rtk_u32 unread, unread_end; /* the blocks that are not loaded yet */
    rtk_u32 mask;               /* that of all its rays */
    /* Blocks of the batch, those of them that were asked for from farther caches or memory, how many to ask for before they are
     * looked at, and up to which walks ask for them. */
    rtk_u32 blocks, asked, lead, walks_ask;
    struct {
        rtk_u32 geom, first, count;
    } mesh; /* as a packet's */
} pencil;

/* Which of the vectors of bundles have some of these, a bit each. */
RTI_VEC rtk_u32 pencil_vectors(pencil_bits bundles)
{
    rtk_u32 some = 0u;
    for (rtk_u32 i = 0u; i < BUNDLES / RTI_SIMD; i++)
        some |= (rtk_u32)((bundles >> (i * RTI_SIMD) & LANES_ALL) != 0u) << i;
    return some;
}

RTI_VEC void pencil_open_batch(pencil *p, const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits,
                               uint16_t *occluded, rti_scratch *scratch)
{
    p->scene = scene;
    p->batch = rays;
    p->all_hits = hits;
    p->all_occluded = occluded;
    p->scratch = scratch;
    p->mesh.first = p->mesh.count = 0u;
    p->leaves = p->told = 0u;
    p->scale = 0.0f;
    for (rtk_u32 k = 0u; k < scene->groups->part_count; k++) {
        p->scale = rtk_max(p->scale, scene->groups->parts[k].scale);
        p->blocker[k].node = NULL;
    }
}

/* May a group's rays go in pencils? There they meet triangles for the most part, and every hit counts. */
RTI_VEC int pencil_fits(const rtk_group *g)
{
    if (!(g->flags & RTK_GROUP_PLAIN) || !bvh_mostly_mesh(g) || g->part_count == 0u)
        return 0;
    for (rtk_u32 k = 0u; k < g->part_count; k++)
        if (g->parts[k].bvh.block_count == 0u)
            return 0;
    return 1;
}

RTI_VEC rtk_u32 pencil_lanes(rtk_u32 mask, rtk_u32 h)
{
    return mask >> h * RTI_SIMD & LANES_ALL;
}

/* Of each of the vectors the least lane, none of which is NaN. */
RTI_VEC void pencil_lows(const vec a[PENCIL], float out[PENCIL])
{
#ifdef RTI_PACK
    for (rtk_u32 i = 0u; i < PENCIL; i += RTI_SIMD)
        rti_f16_store(out + i, rti_f16_lows(a + i));
#else
    for (rtk_u32 i = 0u; i < PENCIL; i++)
        out[i] = packet_low(a[i]);
#endif
}
RTI_VEC float pencil_low(const float *a, rtk_u32 n)
{
    vec m = V(load)(a);
    for (rtk_u32 h = RTI_SIMD; h < n; h += RTI_SIMD)
        m = V(min)(m, V(load)(a + h));
    return packet_low(m);
}
RTI_VEC float pencil_high(const float *a, rtk_u32 n)
{
    vec m = V(load)(a);
    for (rtk_u32 h = RTI_SIMD; h < n; h += RTI_SIMD)
        m = V(max)(m, V(load)(a + h));
    return packet_high(m);
}

/* Of RTI_SIMD rays from lane k on those that have a mask. */
RTI_VEC rtk_u32 pencil_seeing(const rtk_trace_block *b, rtk_u32 k, rtk_u32 mask)
{
    vec_bits sees;
    memcpy(&sees, b->mask + k, sizeof sees);
    return LANES_ALL & ~packet_some(sees ^ mask);
}

/* Of RTI_SIMD rays from lane k on those that are valid, rtk_ray_valid, and have a mask. */
RTI_VEC rtk_u32 pencil_valid(const rtk_trace_block *b, rtk_u32 k, rtk_u32 mask)
{
    const vec most = V(set)(3.402823466e38f);
    const vec dx = V(abs)(V(load)(b->dx + k)), dy = V(abs)(V(load)(b->dy + k)), dz = V(abs)(V(load)(b->dz + k));
    const vec longest = V(max)(V(max)(dx, dy), dz);
    vmask ok = V(lt)(V(load)(b->tmin + k), V(load)(b->tmax + k));
    ok = VM(and)(ok, VM(and)(V(le)(V(abs)(V(load)(b->ox + k)), most), V(le)(dx, most)));
    ok = VM(and)(ok, VM(and)(V(le)(V(abs)(V(load)(b->oy + k)), most), V(le)(dy, most)));
    ok = VM(and)(ok, VM(and)(V(le)(V(abs)(V(load)(b->oz + k)), most), V(le)(dz, most)));
    ok = VM(and)(ok, VM(and)(V(le)(V(set)(RTK_DIR_MIN), longest), V(le)(longest, V(set)(RTK_DIR_MAX))));
    return VM(bits)(ok) & pencil_seeing(b, k, mask);
}

/* Of the caller's next batch, what stands where a block stands in this one. */
RTI_VEC void pencil_expect_soon(const rti_soon *soon, rtk_u32 block)
{
    if (soon->blocks <= block)
        return;
    const char *rays = (const char *)(soon->rays + (size_t)block * RTK_BLOCK);
    for (rtk_u32 i = 0u; i < RTK_BLOCK * sizeof *soon->rays; i += 64u)
        __builtin_prefetch(rays + i);
    if (!soon->hits)
        return;
    const char *hits = (const char *)(soon->hits + (size_t)block * RTK_BLOCK);
    for (rtk_u32 i = 0u; i < RTK_BLOCK * sizeof *soon->hits; i += 64u)
        __builtin_prefetch(hits + i, 1);
}

/* Asks for a block of the batch and, of closest hits, for where its hits are to be. */
RTI_VEC void pencil_expect_block(const pencil *p, rtk_u32 mode, rtk_u32 g)
{
    if (g >= p->blocks)
        return;
    const char *rays = (const char *)(p->batch + g);
    for (rtk_u32 i = 0u; i < sizeof *p->batch; i += 64u)
        __builtin_prefetch(rays + i);
    if (mode & RTK_MODE_ANY)
        return;
    const char *hits = (const char *)(p->all_hits + g);
    for (rtk_u32 i = 0u; i < sizeof *p->all_hits; i += 64u)
        __builtin_prefetch(hits + i, 1);
}

/* Asks for the next block, or for what stands there in the caller's next batch where this one was copied just now. */
RTI_VEC void pencil_expect(pencil *p, rtk_u32 mode)
{
    const rtk_u32 g = p->asked++;
    if (p->scratch->soon.blocks != 0u)
        pencil_expect_soon(&p->scratch->soon, g);
    else
        pencil_expect_block(p, mode, g);
}

/* Before a pencil of a batch of so many blocks. Blocks are asked for PENCIL_LEAD before they are looked at, but the last one of
 * the next pencil, which is looked at first, now. Walks ask for more at each node, for they wait for no memory, and rays that are
 * gathered for little else. (All of the next pencil asked for while one is gathered: camera rays of 1920x1080 pixels take 1.03 to
 * 1.07 times as long.) */
RTI_VEC void pencil_expect_open(pencil *p, rtk_u32 mode, rtk_u32 blocks)
{
    const rtk_u32 here = p->first / RTK_BLOCK, next = here + PENCIL;
    const int copied = p->scratch->soon.blocks != 0u;
    p->blocks = blocks;
    p->asked = rtk_umax(p->asked, here);
    p->lead = copied ? 1u : PENCIL_LEAD;
    p->walks_ask = copied ? 0u : next + PENCIL;
    if (!copied && next < blocks)
        pencil_expect_block(p, mode, rtk_umin(next + PENCIL, blocks) - 1u);
}

/* The first n rays of a block have no hits. */
RTI_VEC void pencil_none(const rtk_trace_block *b, rtk_hit_block *hit, rtk_u32 n)
{
    memcpy(hit->t, b->tmax, n * sizeof *hit->t);
    memset(hit->u, 0, n * sizeof *hit->u);
    memset(hit->v, 0, n * sizeof *hit->v);
    memset(hit->prim, 0xff, n * sizeof *hit->prim); /* RTK_INVALID */
    memset(hit->geom, 0xff, n * sizeof *hit->geom);
    memset(hit->inst, 0xff, n * sizeof *hit->inst);
}

/* Block g becomes ready: hits are none unless something was asked before. Returns the rays that are asked for. */
RTI_VEC rtk_u32 pencil_load_block(pencil *p, rtk_u32 mode, rtk_u32 g)
{
    const rtk_trace_block *b = &p->rays[g];
    const rtk_u32 count = p->count - g * RTK_BLOCK, all = rtk_umin(count, RTK_BLOCK);
    if (!(mode & RTK_MODE_ANY) && !p->again) {
        if (all == RTK_BLOCK)
            pencil_none(b, &p->hits[g], RTK_BLOCK); /* a number, so no calls */
        else
            pencil_none(b, &p->hits[g], all);
    }
    const rtk_u32 asked = (2u << (all - 1u)) - 1u;
    if (!(mode & RTK_MODE_ANY))
        return asked;
    if (!p->again)
        p->occluded[g] = 0u;
    return asked & ~(rtk_u32)p->occluded[g];
}

/* Of rays of block g: want[g] has those that may go, rest[g] the others. */
RTI_VEC void pencil_tell_valid(pencil *p, rtk_u32 g, rtk_u32 lanes, uint16_t want[PENCIL], uint16_t rest[PENCIL])
{
    rtk_u32 valid = 0u;
    for (rtk_u32 k = 0u; k < RTK_BLOCK; k += RTI_SIMD)
        valid |= pencil_valid(&p->rays[g], k, p->mask) << k;
    want[g] = (uint16_t)(p->mask != 0u ? lanes & valid : 0u); /* where it is none, no hit counts, and rays are not looked for */
    rest[g] = (uint16_t)(rest[g] | (lanes & ~(rtk_u32)want[g]));
}

/* The first block and the last; the others are loaded when they are looked at first (pencil_gather), for the nearest cache does
 * not hold all of them. Not so where one of the two has no ray to guess by. */
RTI_VEC void pencil_load(pencil *p, rtk_u32 mode, uint16_t want[PENCIL], uint16_t rest[PENCIL])
{
    const rtk_u32 last = (p->count - 1u) / RTK_BLOCK;
    memset(want, 0, PENCIL * sizeof *want);
    memset(rest, 0, PENCIL * sizeof *rest);
    p->mask = p->rays[0].mask[0];
    pencil_tell_valid(p, 0u, pencil_load_block(p, mode, 0u), want, rest);
    if (last != 0u)
        pencil_tell_valid(p, last, pencil_load_block(p, mode, last), want, rest);
    p->unread = 1u;
    p->unread_end = last;
    if (want[0] == 0u || want[last] == 0u) {
        for (rtk_u32 g = 1u; g < last; g++)
            pencil_tell_valid(p, g, pencil_load_block(p, mode, g), want, rest);
        p->unread_end = 0u;
    }
}

/* A ray of a block, its numbers in the order kx, ky, kz. */
typedef struct pencil_ray {
    double org[3], dir[3], tmax;
} pencil_ray;
RTI_VEC pencil_ray pencil_one(const pencil *p, rtk_u32 g, rtk_u32 i)
{
    const rtk_trace_block *b = &p->rays[g];
    const float org[3] = {b->ox[i], b->oy[i], b->oz[i]}, dir[3] = {b->dx[i], b->dy[i], b->dz[i]};
    return (pencil_ray){{org[p->kx], org[p->ky], org[p->kz]}, {dir[p->kx], dir[p->ky], dir[p->kz]}, b->tmax[i]};
}

/* Guesses where the lines of two rays meet. Rays run from there, unless they ask for any hit and run to it. */
RTI_VEC int pencil_apex(pencil *p, rtk_u32 mode, const pencil_ray *a, const pencil_ray *b)
{
    p->away = 1u;
    p->turn = 1.0f;
    for (rtk_u32 i = 0u; i < 3u; i++)
        p->apex[i] = (float)a->org[i];
    if (a->org[0] == b->org[0] && a->org[1] == b->org[1] && a->org[2] == b->org[2]) {
        p->turn = a->dir[2] > 0.0 ? 1.0f : -1.0f;
        return 1;
    }
    const double x = b->org[0] - a->org[0], y = b->org[1] - a->org[1], z = b->org[2] - a->org[2];
    const double sx = a->dir[0] / a->dir[2], sy = a->dir[1] / a->dir[2];
    const double rx = b->dir[0] / b->dir[2] - sx, ry = b->dir[1] / b->dir[2] - sy, rr = rx * rx + ry * ry;
    if (!(rr > 0.0))
        return 0;
    /* at depth w behind a's origin the lines are (x - sx z) + (w - z) r apart */
    double t = (z - (rx * (x - sx * z) + ry * (y - sy * z)) / rr) / a->dir[2];
    if (t > 0.0) {
        if (!(mode & RTK_MODE_ANY))
            return 0;
        p->away = 0u;
        if (a->tmax < 1.001 * t && a->tmax > 0.999 * t) /* a light's rays end there */
            t = a->tmax;
    }
    p->apex[0] = (float)(a->org[0] + t * a->dir[0]);
    p->apex[1] = (float)(a->org[1] + t * a->dir[1]);
    p->apex[2] = (float)(a->org[2] + t * a->dir[2]);
    p->turn = (a->dir[2] > 0.0) == (p->away != 0u) ? 1.0f : -1.0f;
    return 1;
}

/* Of RTI_SIMD rays those whose dominant axis is kz, as rtk_ray_prepare chooses it, and that run up or down it. */
RTI_VEC rtk_u32 pencil_alike(const pencil *p, vec x, vec y, vec z, int down)
{
    const vec ax = V(abs)(x), ay = V(abs)(y), az = V(abs)(z);
    rtk_u32 ok;
    if (p->kz == 0u) /* kx is y, ky is z */
        ok = VM(bits)(VM(and)(V(lt)(ax, az), V(lt)(ay, az)));
    else if (p->kz == 1u) /* kx is z, ky is x */
        ok = VM(bits)(VM(and)(V(lt)(ax, az), V(le)(ay, az)));
    else
        ok = VM(bits)(VM(and)(V(le)(ax, az), V(le)(ay, az)));
    const rtk_u32 neg = VM(bits)(V(lt)(z, V(set)(0.0f)));
    return ok & (down ? neg : ~neg);
}

RTI_VEC void pencil_ways_of(pencil_ways *w, vec lo, vec hi, rtk_u32 at)
{
    const vec zero = V(set)(0.0f), inf = V(set)(RTK_INF), a = V(set)(1.0f) / lo, b = V(set)(1.0f) / hi;
    const vec less = V(set)(1.0f - PENCIL_U), more = V(set)(1.0f + PENCIL_U);
    const vmask under = V(lt)(lo, zero), over = V(lt)(zero, lo), low = V(lt)(hi, zero), high = V(lt)(zero, hi);
    V(store)(w->in[0] + at, V(select)(high, less * b, zero));
    V(store)(w->in[1] + at, V(select)(under, less * a, zero));
    V(store)(w->out[0] + at, V(select)(low, more * b, zero));
    V(store)(w->out[1] + at, V(select)(over, more * a, zero));
    V(store)(w->more[0] + at, V(select)(low, zero, inf));
    V(store)(w->more[1] + at, V(select)(over, zero, inf));
}

/* Whether the first and the last of `want` may be of one pencil; *down: it runs down its axis. */
RTI_VEC int pencil_guess(pencil *p, rtk_u32 mode, const uint16_t want[PENCIL], int *down)
{
    rtk_u32 first = 0u, last = PENCIL - 1u;
    while (want[first] == 0u)
        first++;
    while (want[last] == 0u)
        last--;
    const rtk_u32 i = (rtk_u32)__builtin_ctz(want[first]), k = 31u - (rtk_u32)__builtin_clz(want[last]);
    const rtk_trace_block *b = &p->rays[first];
    const float x = rtk_fabs(b->dx[i]), y = rtk_fabs(b->dy[i]), z = rtk_fabs(b->dz[i]);
    p->kz = x > y && x > z ? 0u : (y > z ? 1u : 2u);
    p->kx = p->kz == 2u ? 0u : p->kz + 1u;
    p->ky = p->kx == 2u ? 0u : p->kx + 1u;
    const pencil_ray head = pencil_one(p, first, i);
    pencil_ray tail = pencil_one(p, last, k);
    *down = head.dir[2] < 0.0;
    if ((tail.dir[2] < 0.0) != *down || tail.dir[2] == 0.0)
        tail = head;
    return pencil_apex(p, mode, &head, &tail);
}

#endif
