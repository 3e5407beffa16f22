/* One mode of the walk by packets, behind that by single rays (single.inl), whose functions it calls. Included by modes.inl. */

#include "bvh_one.inl"

/* The rays of a packet for which more than triangles of the scene itself is to be asked, or that go singly, in a part. */
static void RTK_NAME(packet_single)(packet *p, const rtk_part *part, uint64_t rays)
{
    for (; rays != 0u; rays &= rays - 1u) {
        rtk_u32 i = (rtk_u32)__builtin_ctzll(rays);
        rtk_query q;
        rtk_pray r;
        packet_query(p, i, &q);
        if (!rtk_ray_prepare(q.ray, part->lo, part->hi, part->scale, &r))
            continue;
        if (RTK_NAME(group_walk)(&q, part->bvh, part->count, &r, 0.0f))
            p->done |= (uint64_t)1u << i;
        packet_answer(p, i, &q);
    }
}

/* A ray of the batch by itself. */
static void RTK_NAME(stream_alone)(streams *a, rtk_u32 number)
{
    rtk_query q;
    rtk_pray r;
    if (!stream_ready(a, number, &q, &r))
        return;
    if (RTK_NAME(group_walk)(&q, a->tree, a->part->count, &r, q.outer))
        stream_occluded(a, number);
    else if (!(RTK_MODE & RTK_MODE_ANY))
        stream_keep(a, number, q.best);
}

/* A ray of a stream by itself. mode, here and below: RTK_MODE, with STREAM_MOVED or without. */
RTI_VEC void RTK_NAME(stream_single)(streams *a, stream *s, rtk_u32 l, rtk_u32 mode)
{
    if (s->ray[l].t1 == -RTK_INF)
        return;
    if (!(RTK_MODE & RTK_MODE_ANY))
        stream_settle(a, s, mode, l);
    RTK_NAME(stream_alone)(a, stream_number(s, RTK_MODE, l));
    stream_ends(s, mode, l, -RTK_INF);
    s->hit[l].t = -RTK_INF; /* nothing is nearer */
}

/* The streams of octants first to last to their end, by turns. */
RTI_VEC void RTK_NAME(stream_turns)(streams *a, rtk_u32 first, rtk_u32 last, rtk_u32 mode)
{
    rtk_u32 live = 0u, which[8];
    for (rtk_u32 i = first; i <= last; i++) {
        a->of[i].n = a->next[i];
        a->next[i] = 0u;
        a->ran += a->of[i].n;
        stream_start(a, &a->of[i], RTK_MODE);
        if (a->of[i].n != 0u)
            which[live++] = i;
    }
    while (live != 0u) {
        for (rtk_u32 i = 0u; i < live; i++) {
            stream *s = &a->of[which[i]];
            const rtk_u32 left = stream_step(a, which[i], mode);
            a->scratch->stats.crowded += left;
            for (rtk_u32 k = 0u; k < left; k++)
                RTK_NAME(stream_single)(a, s, a->now[k], mode);
            if (s->top == 0u)
                which[i--] = which[--live];
        }
    }
    for (rtk_u32 i = first; i <= last && !(RTK_MODE & RTK_MODE_ANY); i++)
        stream_end(a, &a->of[i], mode);
}
static void RTK_NAME(stream_run_mixed)(streams *a, rtk_u32 first, rtk_u32 last)
{
    RTK_NAME(stream_turns)(a, first, last, RTK_MODE | STREAM_MIXED);
}
static void RTK_NAME(stream_run)(streams *a, rtk_u32 first, rtk_u32 last)
{
    RTK_NAME(stream_turns)(a, first, last, RTK_MODE);
}
#if !(RTK_MODE & 1)
static void RTK_NAME(stream_run_moved)(streams *a, rtk_u32 first, rtk_u32 last)
{
    RTK_NAME(stream_turns)(a, first, last, RTK_MODE | STREAM_MOVED);
}
static void RTK_NAME(stream_run_moved_mixed)(streams *a, rtk_u32 first, rtk_u32 last)
{
    RTK_NAME(stream_turns)(a, first, last, RTK_MODE | STREAM_MOVED | STREAM_MIXED);
}
#endif

/* Runs the streams that have no room for so many more rays; of a large tree all of them together. */
typedef void RTK_NAME(stream_runs)(streams *a, rtk_u32 first, rtk_u32 last);
RTI_VEC void RTK_NAME(stream_flush_by)(streams *a, rtk_u32 room, RTK_NAME(stream_runs) run)
{
    rtk_u32 most = 0u;
    for (rtk_u32 i = 0u; i < 8u; i++) {
        most = rtk_umax(most, a->next[i]);
        if (!a->turns && a->next[i] + room > a->length)
            run(a, i, i);
    }
    if (a->turns && most + room > a->length)
        run(a, 0u, 7u);
}
static void RTK_NAME(stream_flush)(streams *a, rtk_u32 room)
{
    if (a->mixed)
        RTK_NAME(stream_flush_by)(a, room, RTK_NAME(stream_run_mixed));
    else
        RTK_NAME(stream_flush_by)(a, room, RTK_NAME(stream_run));
}

/* Of a packet's rays those that go on in streams (a; NULL: none may), the others by themselves. */
static void RTK_NAME(packet_others)(packet *p, streams *a, const rtk_part *part, uint64_t rays)
{
    if (a && rays != 0u)
        rays = stream_join(a, RTK_MODE, p, rays);
    RTK_NAME(packet_single)(p, part, rays);
}

/* A packet's rays through a part. */
static void RTK_NAME(packet_part)(packet *p, streams *a, const rtk_part *part, uint64_t rays, int coherent)
{
    uint64_t far;
    rays = packet_prepare(p, part, rays, &far);
    RTK_NAME(packet_single)(p, part, far);
    if (!coherent)
        RTK_NAME(packet_others)(p, a, part, rays);
    const float axes = part->bvh.block_count == 0u ? 1.0f : 0.0f; /* without triangles in blocks, octants will do */
    while (rays != 0u && coherent) {
        const rtk_u32 first = (rtk_u32)__builtin_ctzll(rays);
        const vec any = V(set)(axes), key = V(set)(p->key[first] - axes * p->kind[first]);
        uint64_t same = 0u;
        for (rtk_u32 i = 0u; i < PACKET; i += RTI_SIMD)
            same |= (uint64_t)VM(bits)(V(eq)(V(load)(p->key + i) - any * V(load)(p->kind + i), key)) << i;
        same &= rays;
        rays &= ~same;
        if ((rtk_u32)__builtin_popcountll(same) >= PACKET_FEW) {
            packet_begin(p, RTK_MODE, same);
            same = packet_walk(p, RTK_MODE, part);
            if (!(RTK_MODE & RTK_MODE_ANY))
                packet_know(p, part);
        }
        RTK_NAME(packet_others)(p, a, part, same);
    }
}

/* Planes, instances, and what finishes a hit, one ray at a time. */
static void RTK_NAME(packet_rest)(packet *p, rtk_u32 n, uint64_t valid, rtk_hit_block *hits)
{
    for (rtk_u32 i = 0u; i < n; i++) {
        rtk_query q;
        packet_query(p, i, &q);
        if (valid >> i & 1u && !(p->done >> i & 1u)) {
            if (rtk_query_planes(&q, RTK_MODE, q.ray) || RTK_NAME(one_instances)(&q))
                p->done |= (uint64_t)1u << i;
        }
        if (!(RTK_MODE & RTK_MODE_ANY))
            rti_lane_hit(&q, hits, packet_number(p, i));
    }
}

/* What n lanes have found goes to their rays' places. */
RTI_VEC void RTK_NAME(packet_out)(const packet *p, rtk_u32 n, rtk_hit_block *hits, uint16_t *occluded, int plain)
{
    for (rtk_u32 at = 0u; at < n; at += RTK_BLOCK) {
        rtk_u32 b = (p->first + at) / RTK_BLOCK, lanes = n - at < RTK_BLOCK ? n - at : RTK_BLOCK;
        if (RTK_MODE & RTK_MODE_ANY) {
            occluded[b] = (uint16_t)(p->done >> at & ((1u << lanes) - 1u));
        } else if (plain && lanes == RTK_BLOCK) {
            packet_hits(p, at, &hits[b], RTK_BLOCK); /* a number, so no call */
        } else if (plain) {
            packet_hits(p, at, &hits[b], lanes);
        }
    }
}

/* Rays [first, first + n) into streams, without more ado. */
RTI_VEC void RTK_NAME(stream_loads)(streams *a, rtk_u32 first, rtk_u32 n, int again, rtk_u32 mode)
{
    const rtk_u32 part = (rtk_u32)(a->part - a->scene->groups->parts);
    for (rtk_u32 at = 0u; at < n; at += RTI_SIMD) {
        if (again && first + at < a->told && !(a->enters[(first + at) / RTI_SIMD] >> part & 1u))
            continue;
        for (rtk_u32 left = stream_load(a, mode, first + at, n - at, again); left != 0u; left &= left - 1u)
            RTK_NAME(stream_alone)(a, first + at + (rtk_u32)__builtin_ctz(left));
    }
}
static void RTK_NAME(stream_all)(streams *a, rtk_u32 first, rtk_u32 n, int again)
{
    RTK_NAME(stream_loads)(a, first, n, again, RTK_MODE);
}

/* The scene's planes for rays [first, first + n), as packets, before anything else is asked. */
static void RTK_NAME(planes)(pencil *l, packet *p, rtk_u32 first, rtk_u32 n)
{
    for (rtk_u32 at = 0u; at < n; at += PACKET) {
        const rtk_u32 m = rtk_umin(n - at, PACKET);
        packet_planes(p, RTK_MODE, packet_load(p, l->scene, l->batch, first + at, m, l->scratch));
        RTK_NAME(packet_out)(p, m, l->all_hits, l->all_occluded, 1);
    }
}

/* A pencil through all parts; late[k]: rays that are to go another way through part k. Returns whether it went through one. */
static int RTK_NAME(pencil_parts)(pencil *l, rtk_u32 count, uint16_t late[RTK_PARTS][PENCIL])
{
    const rtk_u32 parts = l->scene->groups->part_count;
    int through = 0;
    for (rtk_u32 k = 0u; k < parts && l->bundles != 0u; k++) {
        const int enters = pencil_enter_part(l, k), apart = enters && pencil_walk(l, RTK_MODE, count);
        if (enters && !apart) {
            through = 1;
            continue;
        }
        for (rtk_u32 to = k; to < (apart ? parts : k + 1u); to++)
            for (rtk_u32 i = 0u; i < l->end; i++)
                late[to][l->block[i]] |= l->live[i];
        if (apart) {
            l->apart = 1u;
            break;
        }
    }
    return through;
}

/* Up to PENCIL_RAYS rays, from `first` on: those that pass through one point go as a pencil, what is left as packets, or, when the
 * pencil came apart, as rays without order. a: streams, where there is one part. */
static void RTK_NAME(pencils)(pencil *l, packet *p, streams *a, rtk_u32 first, rtk_u32 count)
{
    const rtk_group *group = l->scene->groups;
    const rtk_u32 n = rtk_umin(count - first, PENCIL_RAYS);
    uint16_t want[PENCIL], rest[PENCIL], late[RTK_PARTS][PENCIL];
    rtk_u32 some, together = 0u;
    l->first = first;
    l->rays = l->batch + first / RTK_BLOCK;
    if (RTK_MODE & RTK_MODE_ANY)
        l->occluded = l->all_occluded + first / RTK_BLOCK;
    else
        l->hits = l->all_hits + first / RTK_BLOCK;
    pencil_expect_open(l, RTK_MODE, count / RTK_BLOCK);
    if (group->plane_count != 0u)
        RTK_NAME(planes)(l, p, first, n);
    l->count = n;
    l->again = group->plane_count != 0u;
    l->apart = 0u;
    pencil_load(l, RTK_MODE, want, rest);
    memset(late, 0, group->part_count * sizeof *late);
    for (;;) {
        some = 0u;
        for (rtk_u32 g = 0u; g < PENCIL; g++)
            some |= want[g];
        if (some == 0u)
            break;
        some = pencil_begin(l, RTK_MODE, want, rest);
        if (some != 0u && RTK_NAME(pencil_parts)(l, some, late))
            together += some;
    }
    l->scratch->stats.together += together;
    l->lost = together != 0u ? 0u : l->lost + 1u;
    for (rtk_u32 k = 0u; k < group->part_count; k++) {
        for (rtk_u32 at = 0u; at < n; at += PACKET) {
            const rtk_u32 m = rtk_umin(n - at, PACKET);
            uint64_t left = 0u;
            for (rtk_u32 g = 0u; g < PACKET / RTK_BLOCK; g++) {
                const rtk_u32 i = at / RTK_BLOCK + g;
                left |= (uint64_t)(rest[i] | late[k][i]) << g * RTK_BLOCK;
            }
            if (left == 0u)
                continue;
            left &= packet_load(p, l->scene, l->batch, first + at, m, l->scratch);
            packet_again(p, RTK_MODE, m, l->all_hits, l->all_occluded);
            RTK_NAME(packet_part)(p, a, &group->parts[k], left & ~p->done, l->apart == 0u);
            RTK_NAME(packet_out)(p, m, l->all_hits, l->all_occluded, 1);
            if (a)
                RTK_NAME(stream_flush)(a, PACKET);
        }
    }
}

/* Rays where all there is is the scene's own triangles, shapes and planes. */
static void RTK_NAME(plain)(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits, uint16_t *occluded,
                            uint32_t count, rti_scratch *scratch, int coherent)
{
    const rtk_group *g = scene->groups;
    streams *a = scratch->room;
    packet p;
    pencil l;
    if (a)
        streams_begin(a, scene, rays, hits, occluded, scratch);
    packet_batch(&p);
    rtk_u32 gone = 0u; /* rays that need no more */
    pencil_open_batch(&l, scene, rays, hits, occluded, scratch);
    l.lost = coherent && pencil_fits(g) ? 0u : PENCIL_LOST;
    l.asked = 0u;
    if (coherent && learned_ends(&scratch->learned, RTK_MODE, g->part_count, count, 1)) {
        coherent = 0;
        l.lost = PENCIL_LOST;
    }
    for (rtk_u32 k = 0u; k == 0u || k < g->part_count; k++) {
        const rtk_part *part = &g->parts[k];
        streams *on = a && g->part_count != 0u && stream_fits(g, part) ? a : NULL;
        if (on)
            streams_part(a, RTK_MODE, part, &part->bvh, rays, count, coherent);
        while (k == 0u && gone + PENCIL_BATCH <= count && l.lost < PENCIL_LOST) {
            const int one = on && g->part_count == 1u && g->plane_count == 0u;
            const rtk_u32 whole = (count - gone) / RTK_BLOCK * RTK_BLOCK; /* streams write whole blocks of hits */
            const rtk_u32 apart = one ? learned_left(&scratch->learned, RTK_MODE, whole) : 0u;
            if (apart == 0u) {
                const rtk_u32 n = rtk_umin(count - gone, PENCIL_RAYS);
                RTK_NAME(pencils)(&l, &p, g->part_count == 1u ? on : NULL, gone, count);
                gone += n;
                pencil_learn(&l, RTK_MODE, n);
                if (learned_ends(&scratch->learned, RTK_MODE, g->part_count, count - gone, 0)) {
                    coherent = 0;
                    l.lost = PENCIL_LOST;
                    if (on)
                        streams_part(a, RTK_MODE, part, &part->bvh, rays, count, 0);
                }
            }
            for (rtk_u32 end = gone + apart; gone < end; gone += rtk_umin(end - gone, PACKET)) {
                RTK_NAME(stream_all)(a, gone, rtk_umin(end - gone, PACKET), 0);
                RTK_NAME(stream_flush)(a, PACKET);
            }
        }
        for (rtk_u32 first = gone; first < count; first += PACKET) {
            const rtk_u32 n = rtk_umin(count - first, PACKET);
            packet_expect_rays(rays, first + PACKET, count);
            if (on && !coherent && (k != 0u || g->plane_count == 0u)) {
                RTK_NAME(stream_all)(a, first, n, k != 0u);
                RTK_NAME(stream_flush)(a, PACKET);
                continue;
            }
            uint64_t valid = packet_load(&p, scene, rays, first, n, scratch);
            if (k != 0u)
                packet_again(&p, RTK_MODE, n, hits, occluded);
            else if (g->plane_count != 0u)
                packet_planes(&p, RTK_MODE, valid);
            if (g->part_count != 0u)
                RTK_NAME(packet_part)(&p, on, part, valid & ~p.done, coherent);
            RTK_NAME(packet_out)(&p, n, hits, occluded, 1);
            if (on)
                RTK_NAME(stream_flush)(a, PACKET);
        }
        if (on)
            RTK_NAME(stream_flush)(a, a->length);
        if (on && !(RTK_MODE & RTK_MODE_ANY))
            streams_over(a, count);
    }
    if (coherent && gone == 0u)
        packet_learn(&p, scratch, RTK_MODE);
}

#include "bvh_moved.inl"

/* Whether a whole block's rays have hit something that may lack anything: what is of geometries before the scene's own first of
 * shapes, or behind the last, is of triangles. */
RTI_VEC int RTK_NAME(finish_some)(const rtk_hit_block *h, rtk_u32 first, rtk_u32 last)
{
    rtk_u32 some = 0u;
    for (rtk_u32 k = 0u; k < RTK_BLOCK; k++)
        some |= (rtk_u32)(h->geom[k] - first <= last - first) | (rtk_u32)(h->inst[k] != RTK_INVALID);
    return some != 0u;
}

/* Asks for the shapes that a block of rays has hit. */
RTI_VEC void RTK_NAME(finish_expect)(const rtk_scene *scene, const rtk_hit_block *h)
{
    for (rtk_u32 k = 0u; k < RTK_BLOCK; k++) {
        const rtk_group *g = scene->groups;
        if (h->prim[k] != RTK_INVALID && h->inst[k] == RTK_INVALID && g->geoms[h->geom[k]].type == RTK_GEOM_SHAPES)
            __builtin_prefetch(&g->shapes[g->geoms[h->geom[k]].first + h->prim[k]]);
    }
}

/* What hits of shapes lack. */
static void RTK_NAME(finish)(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits, uint32_t count,
                             const rti_scratch *scratch)
{
    const rtk_group *own = scene->groups;
    if ((RTK_MODE & RTK_MODE_ANY) || (own->shape_count == 0u && !(scene->flags & RTK_SCENE_BODIES)))
        return;
    const rtk_u32 first = own->shape_count != 0u ? own->shapes->geom : 0u; /* in this order, too */
    const rtk_u32 last = own->shape_count != 0u ? own->shapes[own->shape_count - 1u].geom : 0u;
    for (uint32_t i = 0u; i < count; i++) {
        const rtk_hit_block *h = &hits[i / RTK_BLOCK];
        const rtk_u32 k = i % RTK_BLOCK, inst = h->inst[k];
        if (k == 0u && count - i >= RTK_BLOCK && !RTK_NAME(finish_some)(h, first, last)) {
            i += RTK_BLOCK - 1u;
            continue;
        }
        if (k == 0u && count - i >= 2u * RTK_BLOCK)
            RTK_NAME(finish_expect)(scene, h + 1);
        const rtk_group *g = inst == RTK_INVALID ? own : &scene->groups[scene->instances[inst].group];
        rtk_query q;
        if (h->prim[k] == RTK_INVALID || g->geoms[h->geom[k]].type != RTK_GEOM_SHAPES)
            continue;
        rti_lane_query(&q, scene, rays, i, scratch);
        q.best = rti_lane_best(hits, i);
        rti_lane_hit(&q, hits, i);
    }
}

static void RTK_NAME(packets)(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits, uint16_t *occluded,
                              uint32_t count, rti_scratch *scratch);
static void RTK_NAME(lone)(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits, uint16_t *occluded,
                           uint32_t count, rti_scratch *scratch);
#include "bvh_placed.inl"

/* Packets that go through instances one ray at a time. Apart, for a packet is 13 KiB of the stack: instances' rays come to where
 * these are called from a second time. */
RTI_APART void RTK_NAME(packets_placed)(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits,
                                        uint16_t *occluded, uint32_t count, rti_scratch *scratch)
{
    packet p;
    packet_batch(&p);
    for (rtk_u32 first = 0u; first < count; first += PACKET) {
        const rtk_group *g = scene->groups;
        const rtk_u32 n = rtk_umin(count - first, PACKET);
        packet_expect_rays(rays, first + PACKET, count);
        uint64_t valid = packet_load(&p, scene, rays, first, n, scratch);
        for (rtk_u32 k = 0u; k < g->part_count; k++)
            RTK_NAME(packet_part)(&p, NULL, &g->parts[k], valid & ~p.done, 1);
        RTK_NAME(packet_rest)(&p, n, valid, hits);
        RTK_NAME(packet_out)(&p, n, hits, occluded, 0);
    }
}

/* Packets of coherent rays where there is more than that. */
static void RTK_NAME(packets)(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits, uint16_t *occluded,
                              uint32_t count, rti_scratch *scratch)
{
    const int together = !stream_balls_apart(scene->groups, RTK_MODE, count, scratch);
    if (count < PACKET_FEW) {
        RTK_NAME(ones)(scene, rays, hits, occluded, count, scratch);
        return;
    }
    if (scene->instance_count == 0u) {
        if (moved_fits(scene, rays, count, scratch, 1))
            RTK_NAME(moved)(scene, rays, hits, occluded, count, scratch, 1);
        else
            RTK_NAME(plain)(scene, rays, hits, occluded, count, scratch, together);
        if (!scratch->bare)
            RTK_NAME(finish)(scene, rays, hits, count, scratch);
        return;
    }
    if (placed_fits(scene, scratch, count)) {
        RTK_NAME(placed)(scene, rays, hits, occluded, count, scratch, 1);
        return;
    }
    RTK_NAME(packets_placed)(scene, rays, hits, occluded, count, scratch);
}

static void RTK_NAME(lone)(const rtk_scene *scene, const rtk_trace_block *rays, rtk_hit_block *hits, uint16_t *occluded,
                           uint32_t count, rti_scratch *scratch)
{
    const rtk_group *g = scene->groups; /* whose parts are of one builder */
    const int plain = count >= PACKET_FEW && scene->instance_count == 0u;
    const int apart = scratch->room && g->part_count != 0u && stream_fits(g, g->parts) && /* in streams */
                      !stream_scattered(rays, count, g->parts);
    if (plain && (apart || g->part_count == 0u || (g->shape_count != 0u && scratch->bare))) {
        if (apart && moved_fits(scene, rays, count, scratch, 0))
            RTK_NAME(moved)(scene, rays, hits, occluded, count, scratch, 0);
        else
            RTK_NAME(plain)(scene, rays, hits, occluded, count, scratch, !apart); /* bounces off what is large go together */
        if (!scratch->bare)
            RTK_NAME(finish)(scene, rays, hits, count, scratch);
    } else if (placed_fits(scene, scratch, count)) {
        RTK_NAME(placed)(scene, rays, hits, occluded, count, scratch, 0);
    } else {
        RTK_NAME(ones)(scene, rays, hits, occluded, count, scratch);
    }
}
