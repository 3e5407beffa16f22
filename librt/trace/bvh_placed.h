/* Many rays through the top level together, for hot files: which of them come to which instance, so that these can go through its
 * group as a batch of their own (bvh_placed.inl).
 *
 * Lists of rays go through the top level's nodes as they go through a stream's: a node is opened once for all rays that come to
 * it, the slots wait with the lists of those that enter them, the nearest on top; where there is no room for lists, half of the
 * rays go on while the others wait. A node's slots are met by as many rays at a time as vectors have lanes, and a list is put
 * together by bits; a ray stands in two records of eight words. An instance gets the list of its leaf. Its rays are moved into
 * the group's space as one ray is (rtk_instance_ray), so whatever the group's tracer finds of them is what it would find of each
 * by itself. They end at their best hits so far, or just behind: equal hits are decided by the order of hits. Where they are many
 * of the rays of their blocks, they go in these blocks, as many at a time as vectors have lanes, the others among them as rays
 * that are none; where they are few of them, side by side. A few rays go through it one by one (bvh_one.inl). A scene's only
 * instance is its top level, and what enters that goes through it in its blocks, without lists and records (placed_approach):
 * closest hits of rays that start far away, too, whose streams then know what the top level moved them by (rtk_query.outer).
 */
#ifndef RTI_BVH_PLACED_H
#define RTI_BVH_PLACED_H

#include "bvh_moved.h"

#define PLACED       16384u /* rays at a time */
#define PLACED_LEAST 256u   /* rays that are worth it: fewer touch no memory for it */
#define PLACED_FEW   32u    /* rays that go through an instance singly */
#define PLACED_NEAR  2048u  /* coherent rays that go through one as coherent: fewer have hardly a leaf in common */
#define PLACED_STEP  2048u  /* coherent rays at a time where there is one instance: what is made of them stays in the caches */
#define PLACED_PIECE 256u   /* rays for whose lists there is no room: so many or fewer go on by themselves, more by halves */
#define PLACED_LOOKS 32u    /* neighbours that are looked at */
#define PLACED_LISTS (3u * PLACED)

/* A ray as it meets the top level's boxes: inv as rtk_inverse has it, and from where to where it goes: t1 is its best hit at the
 * most, and of any hits less than t0 when it has one. */
typedef struct placed_ray {
    float org[3], inv[3], t0, t1;
} placed_ray;

/* What else an instance's group is asked with; tmax: its best hit, or just behind. */
typedef struct placed_rest {
    float dir[3], tmin, tmax;
    rtk_u32 mask, pad[2];
} placed_rest;

/* A slot of a node that waits, or the node itself (PLACED_NODE), and its rays. behind: where room begins when it has its turn;
 * hits: how many were found before. */
typedef struct placed_wait {
    rtk_u32 node, slot, begin, size, behind, hits;
} placed_wait;
#define PLACED_NODE RTK_BVH_WIDTH

typedef struct placed {
    _Alignas(64) rtk_trace_block own[PLACED / RTK_BLOCK]; /* an instance's rays, */
    rtk_hit_block found[PLACED / RTK_BLOCK];              /* and their hits */
    placed_ray ray[PLACED];
    placed_rest rest[PLACED];
    uint16_t list[PLACED_LISTS + RTK_BLOCK]; /* as many more may be read and written */
    uint16_t bits[RTK_BVH_WIDTH][PLACED / RTK_BLOCK];
    uint16_t block[PLACED / RTK_BLOCK], lanes[PLACED / RTK_BLOCK]; /* an instance's rays that go in the batch's blocks: which */
    uint16_t behind[PLACED / RTK_BLOCK]; /* the only instance's that go by themselves */
    placed_wait wait[2u * (RTK_BVH_STACK + RTK_BVH_WIDTH)];
    rtk_u32 top, hit_count, count;
    const rtk_scene *scene;
    const rtk_trace_block *rays; /* of the batch those that are under way, PLACED at most */
    rtk_hit_block *hits;
    uint16_t *occluded;
    rti_scratch *scratch;
    int coherent;
} placed;

_Static_assert(sizeof(placed) <= RTI_TRACE_PLACED, "they fit into a room");
_Static_assert(PLACED <= 0x10000u && PLACED % RTK_BLOCK == 0u, "lists hold sixteen bits");
_Static_assert(sizeof(placed_ray) == 8u * sizeof(float) && sizeof(placed_rest) == sizeof(placed_ray), "eight fields in a row");

/* Instances with planes are in the way of every ray. */
RTI_VEC int placed_fits(const rtk_scene *scene, const rti_scratch *scratch, uint32_t count)
{
    return scene->instance_count != 0u && scene->unbounded_count == 0u && scratch->room && count >= PLACED_LEAST;
}

/* The slots of a node that a ray enters, and where. */
RTI_VEC rtk_u32 placed_open(const placed_ray *r, const rtk_bvhnode *n, float reach, float t[RTK_BVH_WIDTH])
{
    bvh_ray v;
    v.ox = NODE(set)(r->org[0]);
    v.oy = NODE(set)(r->org[1]);
    v.oz = NODE(set)(r->org[2]);
    v.ix = NODE(set)(r->inv[0]);
    v.iy = NODE(set)(r->inv[1]);
    v.iz = NODE(set)(r->inv[2]);
    v.t0 = NODE(set)(r->t0);
    for (rtk_u32 k = 0u; k < 3u; k++)
        v.near[k] = (2u * k + (rtk_bits(r->inv[k]) >> 31)) * RTK_BVH_WIDTH;
    return bvh_open(n, &v, reach, t);
}

/* Fields of the records of the first of n rays of a list, one in each lane. Returns the lanes that count. */
RTI_VEC rtk_u32 placed_fields(const float *records, const uint16_t *list, rtk_u32 n, vec f[8])
{
#ifdef RTI_PACK8
    uint16_t some[RTK_BLOCK];
    if (n >= RTI_SIMD) {
        V(records)(records, list, f);
        return LANES_ALL;
    }
    rti_u16_last(some, list, n);
    V(records)(records, some, f);
#else
    float rows[8][RTI_SIMD];
    for (rtk_u32 l = 0u; l < RTI_SIMD; l++)
        for (rtk_u32 k = 0u; k < 8u; k++)
            rows[k][l] = records[8u * list[l < n ? l : 0u] + k];
    for (rtk_u32 k = 0u; k < 8u; k++)
        f[k] = V(load)(rows[k]);
    if (n >= RTI_SIMD)
        return LANES_ALL;
#endif
    return (1u << n) - 1u;
}

/* Fields of records of RTI_SIMD rays in a row. */
RTI_VEC void placed_keep(float *records, const vec f[8])
{
#ifdef RTI_PACK8
    V(spread)(f, records, lane_eights);
#else
    float rows[8][RTI_SIMD];
    for (rtk_u32 k = 0u; k < 8u; k++)
        V(store)(rows[k], f[k]);
    for (rtk_u32 l = 0u; l < RTI_SIMD; l++)
        for (rtk_u32 k = 0u; k < 8u; k++)
            records[8u * l + k] = rows[k][l];
#endif
}

/* Of from[0] to from[15] those chosen by bits, side by side; sixteen places behind `to` may be written. Returns how many. */
RTI_VEC rtk_u32 placed_put(uint16_t *to, const uint16_t *from, rtk_u32 bits)
{
#ifdef RTI_PACK8
    return rti_u16_put(to, from, bits);
#else
    rtk_u32 n = 0u;
    for (; bits != 0u; bits &= bits - 1u)
        to[n++] = from[__builtin_ctz(bits)];
    return n;
#endif
}

/* Rays, as placed_fields has them, that enter a slot's box, and where. */
RTI_VEC rtk_u32 placed_enter(const vec f[8], const rtk_bvhnode *n, rtk_u32 slot, vec *in)
{
    vec out = f[7];
    *in = f[6];
    for (rtk_u32 k = 0u; k < 3u; k++) {
        const vec x = (V(set)(n->box[k][0][slot]) - f[k]) * f[3u + k], y = (V(set)(n->box[k][1][slot]) - f[k]) * f[3u + k];
        *in = V(max)(*in, V(min)(x, y));
        out = V(min)(out, V(max)(x, y));
    }
    return VM(bits)(V(le)(*in, out));
}

/* Of the rays that waited for a slot those that still want it, side by side. Returns how many. What stands behind the list of a
 * slot that has its turn is of slots that had theirs. */
RTI_VEC rtk_u32 placed_still(placed *a, const placed_wait *w, const rtk_bvhnode *n)
{
    uint16_t *list = a->list + w->begin;
    rtk_u32 count = 0u;
    if (w->hits == a->hit_count)
        return w->size;
    for (rtk_u32 k = 0u; k < w->size; k += RTK_BLOCK) {
        rtk_u32 bits = 0u;
        for (rtk_u32 h = 0u; h < RTK_BLOCK && k + h < w->size; h += RTI_SIMD) {
            vec f[8], in;
            const rtk_u32 lanes = placed_fields(a->ray[0].org, list + k + h, w->size - k - h, f);
            bits |= (lanes & placed_enter(f, n, w->slot, &in)) << h;
        }
        count += placed_put(list + count, list + k, bits);
    }
    return count;
}

/* Behind this a ray that goes by itself looks for no hit. */
RTI_VEC float placed_reach_of(rtk_u32 mode, const placed_ray *r, const rtk_hit *best)
{
    return mode & RTK_MODE_ANY ? r->t1 : rtk_min(r->t1, best->t);
}

/* Which of the rays of w enter which of `some` slots of a node; counts them, and finds where each slot is entered first. Returns
 * how many there are in all. */
RTI_VEC rtk_u32 placed_meet(placed *a, const rtk_bvhnode *n, const placed_wait *w, const rtk_u32 *slots, rtk_u32 some,
                            rtk_u32 count[RTK_BVH_WIDTH], float least[RTK_BVH_WIDTH])
{
    const uint16_t *list = a->list + w->begin;
    vec first[RTK_BVH_WIDTH];
    rtk_u32 all = 0u;
    for (rtk_u32 i = 0u; i < some; i++) {
        first[i] = V(set)(RTK_INF);
        count[i] = 0u;
    }
    for (rtk_u32 k = 0u; k < w->size; k += RTK_BLOCK) {
        for (rtk_u32 i = 0u; i < some; i++)
            a->bits[i][k / RTK_BLOCK] = 0u;
        for (rtk_u32 h = 0u; h < RTK_BLOCK && k + h < w->size; h += RTI_SIMD) {
            vec f[8];
            const rtk_u32 lanes = placed_fields(a->ray[0].org, list + k + h, w->size - k - h, f);
            for (rtk_u32 i = 0u; i < some; i++) {
                vec in;
                const rtk_u32 enter = lanes & placed_enter(f, n, slots[i], &in);
                first[i] = V(min)(first[i], V(select)(VM(of)(enter), in, V(set)(RTK_INF)));
                a->bits[i][k / RTK_BLOCK] |= (uint16_t)(enter << h);
                count[i] += (rtk_u32)__builtin_popcount(enter);
            }
        }
    }
    for (rtk_u32 i = 0u; i < some; i++) {
        float t[RTI_SIMD];
        V(store)(t, first[i]);
        least[i] = t[0];
        for (rtk_u32 l = 1u; l < RTI_SIMD; l++)
            least[i] = rtk_min(least[i], t[l]);
        all += count[i];
    }
    return all;
}

/* Opens the node w for its rays: its slots wait, the nearest on top. 0: there is no room for their lists. */
RTI_VEC int placed_node(placed *a, const rtk_bvhnode *nodes, const placed_wait *w)
{
    const rtk_bvhnode *n = &nodes[w->node];
    const uint16_t *list = a->list + w->begin;
    rtk_u32 count[RTK_BVH_WIDTH], slots[RTK_BVH_WIDTH], order[RTK_BVH_WIDTH], some = 0u, used = w->behind, waits = 0u;
    float least[RTK_BVH_WIDTH];
    for (rtk_u32 s = 0u; s < RTK_BVH_WIDTH; s++)
        if (n->box[0][0][s] <= n->box[0][1][s]) /* others are empty */
            slots[some++] = s;
    if (placed_meet(a, n, w, slots, some, count, least) > PLACED_LISTS - used)
        return 0;
    for (rtk_u32 i = 0u; i < some; i++) {
        rtk_u32 to = waits;
        if (count[i] == 0u)
            continue;
        for (; to > 0u && least[order[to - 1u]] < least[i]; to--)
            order[to] = order[to - 1u];
        order[to] = i;
        waits++;
    }
    for (rtk_u32 j = 0u; j < waits; j++) {
        const rtk_u32 i = order[j];
        a->wait[a->top++] = (placed_wait){w->node, slots[i], used, count[i], used + count[i], a->hit_count};
        for (rtk_u32 k = 0u; k < w->size; k += RTK_BLOCK)
            used += placed_put(a->list + used, list + k, a->bits[i][k / RTK_BLOCK]);
    }
    return 1;
}

/* Where ray k of a block ends: at its best hit, or just behind. */
RTI_VEC float placed_end(const rtk_hit_block *hits, rtk_u32 k, float tmax)
{
    return hits && hits->prim[k] != RTK_INVALID ? moved_above(hits->t[k]) : tmax;
}

/* Of RTI_SIMD lanes from k on those that have a hit. */
RTI_VEC rtk_u32 placed_found(const rtk_hit_block *hits, rtk_u32 k)
{
    vec_bits prim;
    memcpy(&prim, hits->prim + k, sizeof prim);
    return packet_some(prim ^ RTK_INVALID);
}

/* placed_end of RTI_SIMD lanes from k on. */
RTI_VEC vec placed_ends(const rtk_hit_block *hits, rtk_u32 k, vec tmax)
{
    const vec t = V(load)(hits->t + k);
    vec above;
    vec_bits b;
    memcpy(&b, &t, sizeof b);
    b += 1u - (b >> 31 << 1); /* moved_above */
    memcpy(&above, &b, sizeof above);
    above = V(select)(V(eq)(t, V(set)(0.0f)), V(set)(rtk_float(1u)), above);
    return V(select)(VM(of)(placed_found(hits, k)), above, tmax);
}

/* RTI_SIMD rays become those that go through an instance that stands still (rtk_instance_ray). */
RTI_VEC void placed_turn(const rtk_instance *inst, vec org[3], vec dir[3])
{
    const vec o[3] = {org[0], org[1], org[2]}, d[3] = {dir[0], dir[1], dir[2]};
    for (rtk_u32 i = 0u; i < 3u; i++) {
        const float *row = inst->to_object.m + 4u * i;
        org[i] = V(set)(row[0]) * o[0] + V(set)(row[1]) * o[1] + V(set)(row[2]) * o[2] + V(set)(row[3]);
        dir[i] = V(set)(row[0]) * d[0] + V(set)(row[1]) * d[1] + V(set)(row[2]) * d[2];
    }
}

/* Ray i of the batch, which stands in lane k of b, becomes one through an instance that moves. */
RTI_VEC void placed_follow(const placed *a, const rtk_instance *inst, rtk_trace_block *b, rtk_u32 k, rtk_u32 i)
{
    const float *times = a->scratch->times; /* NULL: all are at 0 */
    rtk_vec3 org = rtk_v3(b->ox[k], b->oy[k], b->oz[k]), dir = rtk_v3(b->dx[k], b->dy[k], b->dz[k]);
    rtk_motion_ray(a->scene->motions, inst, times ? times[i] : 0.0f, &org, &dir);
    b->ox[k] = org.x;
    b->oy[k] = org.y;
    b->oz[k] = org.z;
    b->dx[k] = dir.x;
    b->dy[k] = dir.y;
    b->dz[k] = dir.z;
}

/* RTI_SIMD rays into lanes of a block, but for their masks. */
RTI_VEC void placed_store(rtk_trace_block *b, rtk_u32 k, const vec org[3], const vec dir[3], vec tmin, vec tmax)
{
    V(store)(b->ox + k, org[0]);
    V(store)(b->oy + k, org[1]);
    V(store)(b->oz + k, org[2]);
    V(store)(b->dx + k, dir[0]);
    V(store)(b->dy + k, dir[1]);
    V(store)(b->dz + k, dir[2]);
    V(store)(b->tmin + k, tmin);
    V(store)(b->tmax + k, tmax);
}

/* An instance's rays side by side. What is in lanes behind them is a ray, too. */
RTI_VEC void placed_move(placed *a, const rtk_instance *inst, const uint16_t *list, rtk_u32 n)
{
    const int moving = (inst->flags & RTK_INST_MOVING) != 0u;
    for (rtk_u32 at = 0u; at < n; at += RTI_SIMD) {
        rtk_trace_block *b = &a->own[at / RTK_BLOCK];
        const rtk_u32 k = at % RTK_BLOCK;
        vec r[8], s[8];
        placed_fields(a->ray[0].org, list + at, n - at, r);
        placed_fields(a->rest[0].dir, list + at, n - at, s);
        if (!moving)
            placed_turn(inst, r, s);
        placed_store(b, k, r, s, s[3], s[4]);
        V(store)((float *)(void *)(b->mask + k), s[5]);
        for (rtk_u32 l = 0u; l < RTI_SIMD; l++)
            b->mask[k + l] &= inst->mask;
        for (rtk_u32 l = 0u; moving && l < RTI_SIMD && at + l < n; l++)
            placed_follow(a, inst, b, k + l, list[at + l]);
    }
}

/* The blocks that an instance's rays are of, if they are much of what stands there: a quarter where the rays go together, for those
 * of a point are then as they were looked at, three quarters where they do not. Returns how many; 0: they go side by side. A list
 * has the order of the batch. */
RTI_VEC rtk_u32 placed_blocks(placed *a, const uint16_t *list, rtk_u32 n, int together)
{
    const rtk_u32 most = (together ? 4u * n : 4u * n / 3u) / RTK_BLOCK;
    rtk_u32 count = 0u;
    for (rtk_u32 i = 0u; i < n; count++) {
        const rtk_u32 b = list[i] / RTK_BLOCK;
        rtk_u32 lanes = 0u;
        if (count == most)
            return 0u;
        if (n - i >= RTK_BLOCK && list[i] % RTK_BLOCK == 0u && list[i + RTK_BLOCK - 1u] == list[i] + RTK_BLOCK - 1u) {
            lanes = (1u << RTK_BLOCK) - 1u;
            i += RTK_BLOCK;
        }
        for (; i < n && list[i] / RTK_BLOCK == b; i++)
            lanes |= 1u << list[i] % RTK_BLOCK;
        a->block[count] = (uint16_t)b;
        a->lanes[count] = (uint16_t)lanes;
    }
    return count;
}

/* As placed_move, in so many blocks of the batch (placed_blocks). */
RTI_VEC void placed_move_blocks(placed *a, rtk_u32 mode, const rtk_instance *inst, rtk_u32 count)
{
    const int moving = (inst->flags & RTK_INST_MOVING) != 0u;
    for (rtk_u32 j = 0u; j < count; j++) {
        const rtk_trace_block *from = &a->rays[a->block[j]];
        rtk_trace_block *b = &a->own[j];
        for (rtk_u32 k = 0u; k < RTK_BLOCK; k += RTI_SIMD) {
            vec org[3] = {V(load)(from->ox + k), V(load)(from->oy + k), V(load)(from->oz + k)};
            vec dir[3] = {V(load)(from->dx + k), V(load)(from->dy + k), V(load)(from->dz + k)}, end = V(load)(from->tmax + k);
            if (!(mode & RTK_MODE_ANY))
                end = placed_ends(&a->hits[a->block[j]], k, end);
            if (!moving)
                placed_turn(inst, org, dir);
            placed_store(b, k, org, dir, V(load)(from->tmin + k),
                         V(select)(VM(of)(a->lanes[j] >> k & LANES_ALL), end, V(set)(-RTK_INF)));
            for (rtk_u32 l = k; l < k + RTI_SIMD; l++)
                b->mask[l] = from->mask[l] & inst->mask;
        }
        for (rtk_u32 lanes = moving ? a->lanes[j] : 0u; lanes != 0u; lanes &= lanes - 1u) {
            const rtk_u32 k = (rtk_u32)__builtin_ctz(lanes);
            placed_follow(a, inst, b, k, a->block[j] * RTK_BLOCK + k);
        }
    }
}

/* Ray i has a hit, where any will do. */
RTI_VEC void placed_stop(placed *a, rtk_u32 i)
{
    a->occluded[i / RTK_BLOCK] |= (uint16_t)(1u << i % RTK_BLOCK);
    a->ray[i].t1 = -RTK_INF;
    a->hit_count++;
}

/* A hit of ray i is taken if it comes before its best one. */
RTI_VEC void placed_take(placed *a, rtk_u32 i, rtk_hit hit)
{
    const rtk_hit best = rti_lane_best(a->hits, i);
    if (hit.prim == RTK_INVALID || !rtk_hit_less(hit.t, hit.inst, hit.geom, hit.prim, best.t, best.inst, best.geom, best.prim))
        return;
    rti_lane_keep(a->hits, i, hit);
    a->ray[i].t1 = rtk_min(a->ray[i].t1, hit.t);
    a->rest[i].tmax = moved_above(hit.t);
    a->hit_count++;
}

/* What the group's tracer has found of an instance's rays, which stand side by side. */
RTI_VEC void placed_merge(placed *a, rtk_u32 mode, const rtk_instance *inst, const uint16_t *list, rtk_u32 n)
{
    const uint16_t *any = (const uint16_t *)(const void *)a->found;
    for (rtk_u32 first = 0u; first < n; first += RTK_BLOCK) {
        const rtk_hit_block *h = &a->found[first / RTK_BLOCK];
        rtk_u32 bits = 0u;
        if (mode & RTK_MODE_ANY)
            bits = any[first / RTK_BLOCK];
        else
            for (rtk_u32 k = 0u; k < RTK_BLOCK; k++)
                bits |= (rtk_u32)(h->prim[k] != RTK_INVALID) << k;
        if (n - first < RTK_BLOCK)
            bits &= (1u << (n - first)) - 1u;
        for (; bits != 0u; bits &= bits - 1u) {
            const rtk_u32 k = (rtk_u32)__builtin_ctz(bits), i = list[first + k];
            if (mode & RTK_MODE_ANY)
                placed_stop(a, i);
            else
                placed_take(a, i, (rtk_hit){h->t[k], h->u[k], h->v[k], h->prim[k], h->geom[k], inst->id});
        }
    }
}

/* As placed_merge, in blocks (placed_blocks). */
RTI_VEC void placed_merge_blocks(placed *a, rtk_u32 mode, const rtk_instance *inst, rtk_u32 count)
{
    const uint16_t *any = (const uint16_t *)(const void *)a->found;
    for (rtk_u32 j = 0u; j < count; j++) {
        const rtk_hit_block *h = &a->found[j];
        const rtk_u32 first = a->block[j] * RTK_BLOCK;
        if ((mode & RTK_MODE_ANY) && a->scene->instance_count == 1u) {
            a->occluded[a->block[j]] |= any[j] & a->lanes[j];
            continue;
        }
        if (mode & RTK_MODE_ANY) {
            for (rtk_u32 bits = any[j] & a->lanes[j]; bits != 0u; bits &= bits - 1u)
                placed_stop(a, first + (rtk_u32)__builtin_ctz(bits));
            continue;
        }
        rtk_hit_block *best = &a->hits[a->block[j]];
        for (rtk_u32 k = 0u; k < RTK_BLOCK; k += RTI_SIMD) {
            const vec t = V(load)(h->t + k), before = V(load)(best->t + k);
            const rtk_u32 found = a->lanes[j] >> k & placed_found(h, k);
            rtk_u32 better = found & VM(bits)(V(lt)(t, before)), even = found & VM(bits)(V(eq)(t, before));
            const vmask m = VM(of)(better);
            if (better == 0u && even == 0u)
                continue;
#define KEEP(field)                                                                                                              \
    V(store)                                                                                                                     \
    ((float *)(void *)(best->field + k), V(select)(m, V(load)((const float *)(const void *)(h->field + k)),                      \
                                                   V(load)((const float *)(const void *)(best->field + k))))
            KEEP(t);
            KEEP(u);
            KEEP(v);
            KEEP(prim);
            KEEP(geom);
#undef KEEP
            V(store)
            ((float *)(void *)(best->inst + k),
             V(select)(m, V(set)(rtk_float(inst->id)), V(load)((const float *)(const void *)(best->inst + k))));
            if (a->scene->instance_count == 1u) /* nobody comes behind */
                better = 0u;
            a->hit_count += (rtk_u32)__builtin_popcount(better);
            for (; better != 0u; better &= better - 1u) {
                const rtk_u32 l = k + (rtk_u32)__builtin_ctz(better), i = first + l;
                a->ray[i].t1 = rtk_min(a->ray[i].t1, best->t[l]);
                a->rest[i].tmax = moved_above(best->t[l]);
            }
            for (; even != 0u; even &= even - 1u) {
                const rtk_u32 l = k + (rtk_u32)__builtin_ctz(even);
                placed_take(a, first + l, (rtk_hit){h->t[l], h->u[l], h->v[l], h->prim[l], h->geom[l], inst->id});
            }
        }
    }
}

/* Rays of block b, n of which count, less those that are done, become those that go through the scene's only instance, in block
 * j, if any enters the top level. outer: what those that start far away from it are moved by; NULL: they are not, and stay
 * behind. Returns the lanes that are in block j, of the others of which nothing is asked; far: those that stay behind. */
RTI_VEC rtk_u32 placed_approach(placed *a, rtk_u32 mode, rtk_u32 b, rtk_u32 n, rtk_u32 j, float *outer, rtk_u32 *far)
{
    const rtk_scene *s = a->scene;
    const rtk_part top = {.lo = s->top_lo, .hi = s->top_hi, .scale = s->top_scale};
    const rtk_instance *inst = s->instances;
    const int moving = (inst->flags & RTK_INST_MOVING) != 0u;
    const rtk_trace_block *from = &a->rays[b];
    rtk_trace_block *to = &a->own[j];
    rtk_u32 some = 0u, asked = n < RTK_BLOCK ? (1u << n) - 1u : 0xffffu;
    *far = 0u;
    if (mode & RTK_MODE_ANY)
        asked &= ~(rtk_u32)a->occluded[b];
    for (rtk_u32 k = 0u; k < RTK_BLOCK; k += RTI_SIMD) {
        packet_rays r;
        vec shift, t0, t1, end;
        rtk_u32 lanes, away;
        packet_rays_load(&r, from, k);
        lanes = packet_rays_enter(r.org, r.inv, r.tmin, r.tmax, r.valid & asked >> k, &top, &t0, &t1, &away);
        if (outer) {
            lanes |= rays_move(&r, &top, away, r.org, &shift, &t0, &t1);
            V(store)(outer + k, shift);
        } else {
            *far |= away << k;
        }
        end = r.tmax;
        if (!(mode & RTK_MODE_ANY))
            end = placed_ends(&a->hits[b], k, end);
        if (!moving)
            placed_turn(inst, r.org, r.dir);
        placed_store(to, k, r.org, r.dir, r.tmin, V(select)(VM(of)(lanes), end, V(set)(-RTK_INF)));
        for (rtk_u32 l = k; l < k + RTI_SIMD; l++)
            to->mask[l] = from->mask[l] & inst->mask;
        some |= lanes << k;
    }
    for (rtk_u32 l = moving ? some : 0u; l != 0u; l &= l - 1u)
        placed_follow(a, inst, to, (rtk_u32)__builtin_ctz(l), b * RTK_BLOCK + (rtk_u32)__builtin_ctz(l));
    a->block[j] = (uint16_t)b;
    a->lanes[j] = (uint16_t)some;
    return some;
}

/* RTI_SIMD rays from ray `first` on, those of `count` that are not done, made ready for the top level. Returns those that enter
 * it; far: those that start far away from it. */
RTI_VEC rtk_u32 placed_load(placed *a, rtk_u32 mode, rtk_u32 first, rtk_u32 count, rtk_u32 *far)
{
    const rtk_scene *s = a->scene;
    const rtk_part top = {.lo = s->top_lo, .hi = s->top_hi, .scale = s->top_scale};
    const rtk_u32 k = first % RTK_BLOCK;
    packet_rays r;
    vec t0, t1;
    rtk_u32 lanes;
    packet_rays_load(&r, &a->rays[first / RTK_BLOCK], k);
    lanes = r.valid;
    if (count - first < RTI_SIMD)
        lanes &= (1u << (count - first)) - 1u;
    if (mode & RTK_MODE_ANY)
        lanes &= ~((rtk_u32)a->occluded[first / RTK_BLOCK] >> k);
    lanes = packet_rays_enter(r.org, r.inv, r.tmin, r.tmax, lanes, &top, &t0, &t1, far);
    vec end = r.tmax;
    if (!(mode & RTK_MODE_ANY)) {
        const rtk_hit_block *h = &a->hits[first / RTK_BLOCK];
        end = placed_ends(h, k, end);
        t1 = V(min)(t1, V(load)(h->t + k));
    }
    placed_keep(a->ray[first].org, (vec[8]){r.org[0], r.org[1], r.org[2], r.inv[0], r.inv[1], r.inv[2], t0, t1});
    placed_keep(a->rest[first].dir, (vec[8]){r.dir[0], r.dir[1], r.dir[2], r.tmin, end,
                                             V(load)((const float *)(const void *)(a->rays[first / RTK_BLOCK].mask + k)), t0, t1});
    return lanes;
}

/* Do rays that stand beside each other in a list go the same way, so that packets of them are worth it? Some tell. */
RTI_VEC int placed_alike(const placed *a, const uint16_t *list, rtk_u32 n)
{
    const rtk_u32 step = rtk_umax(n / PLACED_LOOKS, 1u);
    rtk_u32 alike = 0u, all = 0u;
    for (rtk_u32 k = 0u; k + 1u < n; k += step, all++) {
        const float *p = a->rest[list[k]].dir, *q = a->rest[list[k + 1u]].dir;
        const rtk_vec3 v = rtk_v3(p[0], p[1], p[2]), w = rtk_v3(q[0], q[1], q[2]);
        const float both = rtk_dot3(v, w);
        alike += both > 0.0f && 4.0f * both * both > rtk_dot3(v, v) * rtk_dot3(w, w);
    }
    return 2u * alike > all;
}

/* A scene of one group and nothing else. */
RTI_VEC rtk_scene placed_scene(const rtk_scene *scene, rtk_u32 group)
{
    rtk_scene s = *scene;
    s.groups = &scene->groups[group];
    s.group_count = 1u;
    s.instance_count = 0u;
    s.top_lo.x = RTK_INF;
    s.top_hi.x = -RTK_INF;
    return s;
}

#endif
