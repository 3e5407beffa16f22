/* A pencil's rays against triangles, for hot files: which triangles which of its bundles may hit, and the leaf test of those.
 * What the bounds rest on, pencil.h tells. */
#ifndef RTI_PENCIL_MEET_H
#define RTI_PENCIL_MEET_H

#include "pencil_begin.h"

/* Four triangles as the rays of a pencil see them. side[k]: the edge function's value at the middle slopes, as far beyond it as
 * the leaf test's may be, and what it grows by with each slope, turned so that it is negative outside; sign: where it grows with
 * a slope, a bit a triangle. near: no point is less deep. deep, rough: as rti_tri_bounds has them, infinite where that is not told.
 */
typedef struct pencil_four {
    float side[3][3][RTK_BVH_BLOCK], near[RTK_BVH_BLOCK], deep[RTK_BVH_BLOCK], rough[RTK_BVH_BLOCK];
    rtk_u32 sign[3][2];
} pencil_four;

/* `deep` and `rough` of four triangles. size: no |x| or |y| of a corner is greater at any ray; det: no |det| is less; span: no
 * depths of corners lie farther apart. */
RTI_VEC void pencil_deep(pencil_four *f, rti_f4 size, rti_f4 det, rti_f4 span, float scale)
{
    const rti_f4 inf = rti_f4_set(RTK_INF), ten = rti_f4_set(10.0f);
    const rti_f4 q = size * size / det, off = (ten + rti_f4_set(11.0f) * q) * span;
    const rti_m4 told = rti_m4_and(rti_f4_le(rti_f4_set(CERTAIN_DET), det), rti_f4_le(q, rti_f4_set(CERTAIN_Q)));
    const rti_m4 fits = rti_m4_and(rti_f4_le(off, rti_f4_set(31.0f * scale)),
                                   rti_f4_le((size + size) * (ten * q + rti_f4_set(12.0f)), rti_f4_set(127.0f * scale)));
    rti_f4_store(f->deep, rti_f4_select(rti_m4_and(told, fits), off * rti_f4_set(1.0f / 63.0f), inf));
    rti_f4_store(f->rough, rti_f4_select(told, off * rti_f4_set(2.5e-7f), inf));
}

/* Of a block's triangles those that some ray may hit. */
RTI_APART rtk_u32 pencil_see(const pencil *p, const rtk_bvhblock *b, pencil_four *f)
{
    const rti_f4 zero = rti_f4_set(0.0f), inf = rti_f4_set(RTK_INF), mx = rti_f4_set(p->middle[0]), my = rti_f4_set(p->middle[1]);
    const rti_f4 wx = rti_f4_set(p->most[0]), wy = rti_f4_set(p->most[1]), turn = rti_f4_set(p->turn);
    const float grow = RTK_GROW * p->part->scale + p->around;
    const float(*const from[3])[RTK_BVH_BLOCK] = {b->v0, b->v1, b->v2};
    rti_f4 x[3], y[3], z[3], s = zero, depth = zero, v[3], vx[3], vy[3];
    for (rtk_u32 i = 0u; i < 3u; i++) {
        z[i] = rti_f4_load(from[i][p->kz]) - rti_f4_set(p->apex[2]);
        x[i] = (rti_f4_load(from[i][p->kx]) - rti_f4_set(p->apex[0])) - mx * z[i];
        y[i] = (rti_f4_load(from[i][p->ky]) - rti_f4_set(p->apex[1])) - my * z[i];
        const rti_f4 wide = rti_f4_set(rtk_max(p->most[0], p->most[1])) * rti_f4_abs(z[i]);
        s = rti_f4_max(s, rti_f4_max(rti_f4_abs(x[i]), rti_f4_abs(y[i])) + wide);
        depth = rti_f4_max(depth, rti_f4_abs(z[i]));
    }
    rti_f4 e = rti_f4_max(rti_f4_set(PENCIL_U / 4.0f) * depth, rti_f4_set(1e-9f * p->part->scale));
    if (!p->one) {
        const rti_f4 corners = rti_f4_min(rti_f4_set(p->size) + s + depth, rti_f4_set(p->part->scale));
        e = e + (rti_f4_set(1.5f * PENCIL_U) * corners + rti_f4_set(p->edge));
    }
    const rti_f4 off = (s + e) * (rti_f4_set(4.0f) * e + rti_f4_set(2.0f * PENCIL_U) * s);
    const rti_f4 az = turn * z[0], bz = turn * z[1], cz = turn * z[2];
    const rti_f4 near = rti_f4_min(rti_f4_min(az, bz), cz) - rti_f4_set(grow);
    const rti_f4 far = rti_f4_max(rti_f4_max(az, bz), cz) + rti_f4_set(grow);
    for (rtk_u32 k = 0u; k < 3u; k++) {
        const rtk_u32 i = k == 0u ? 2u : k - 1u, j = k == 0u ? 1u : (k == 1u ? 2u : 0u); /* c b, a c, b a */
        v[k] = x[i] * y[j] - y[i] * x[j];
        vx[k] = y[i] * z[j] - z[i] * y[j];
        vy[k] = z[i] * x[j] - x[i] * z[j];
    }
    const rti_f4 det = v[0] + v[1] + v[2], dx = vx[0] + vx[1] + vx[2], dy = vy[0] + vy[1] + vy[2];
    const rti_f4 spread = rti_f4_abs(dx) * wx + rti_f4_abs(dy) * wy + rti_f4_set(4.0f) * off;
    const rti_m4 told = rti_f4_lt(spread, rti_f4_abs(det));
    const rti_f4 side = rti_f4_select(rti_f4_lt(det, zero), rti_f4_set(-1.0f), rti_f4_set(1.0f));
    rti_m4 keep = rti_m4_and(rti_f4_le(near, rti_f4_set(p->deepest)), rti_f4_le(zero, far));
    for (rtk_u32 k = 0u; k < 3u; k++) {
        const rti_f4 a = rti_f4_select(told, side * vx[k], zero), c = rti_f4_select(told, side * vy[k], zero);
        const rti_f4 most = rti_f4_select(told, side * v[k] + off, inf);
        keep = rti_m4_and(keep, rti_f4_le(zero, rti_f4_abs(a) * wx + rti_f4_abs(c) * wy + most));
        rti_f4_store(f->side[k][0], most);
        rti_f4_store(f->side[k][1], a);
        rti_f4_store(f->side[k][2], c);
        f->sign[k][0] = rti_m4_bits(rti_f4_lt(zero, a));
        f->sign[k][1] = rti_m4_bits(rti_f4_lt(zero, c));
    }
    rti_f4_store(f->near, near);
    const rti_f4 span = rti_f4_max(rti_f4_abs(z[1] - z[0]), rti_f4_abs(z[2] - z[0])) + e;
    pencil_deep(f, s + e, rti_f4_abs(det) - spread, span, p->part->scale);
    return rti_m4_bits(keep);
}

/* The bundles of which some ray may hit triangle j. vectors: those that may, as pencil_vectors has them. */
RTI_APART pencil_bits pencil_meet(const pencil *p, const pencil_four *f, rtk_u32 j, rtk_u32 vectors)
{
    pencil_bits bundles = 0u;
    for (; vectors != 0u; vectors &= vectors - 1u) {
        const rtk_u32 h = (rtk_u32)__builtin_ctz(vectors) * RTI_SIMD;
        vmask ok = V(le)(V(set)(f->near[j]), V(load)(p->reach + h));
        for (rtk_u32 k = 0u; k < 3u; k++) {
            const vec x = V(load)(p->corner[0][f->sign[k][0] >> j & 1u] + h),
                      y = V(load)(p->corner[1][f->sign[k][1] >> j & 1u] + h);
            const vec v = V(madd)(V(set)(f->side[k][1][j]), x, V(madd)(V(set)(f->side[k][2][j]), y, V(set)(f->side[k][0][j])));
            ok = VM(and)(ok, V(le)(V(set)(0.0f), v));
        }
        bundles |= (pencil_bits)VM(bits)(ok) << h;
    }
    return bundles;
}

/* Any hit: rays of a bundle, lanes of its block, have one. */
RTI_VEC void pencil_done(pencil *p, rtk_u32 bundle, rtk_u32 lanes)
{
    const rtk_u32 g = p->block[bundle];
    p->met |= lanes;
    p->occluded[g] = (uint16_t)(p->occluded[g] | lanes);
    p->live[bundle] = (uint16_t)(p->live[bundle] & ~lanes);
    p->bundles &= ~((pencil_bits)(p->live[bundle] == 0u) << bundle);
}

/* The mesh of a triangle becomes the one that was met last. */
RTI_VEC void pencil_know(pencil *p, rtk_u32 ref)
{
    if (ref - p->mesh.first >= p->mesh.count) {
        const rtk_group *group = p->scene->groups;
        p->mesh.geom = group->tris[ref].geom;
        p->mesh.first = group->geoms[p->mesh.geom].first;
        p->mesh.count = group->geoms[p->mesh.geom].prim_count;
    }
}

/* Whether lane i's best hit is of this triangle: leaves of cells and of spatial splits repeat triangles. */
RTI_VEC int pencil_is(pencil *p, const rtk_hit_block *h, rtk_u32 i, rtk_u32 ref)
{
    pencil_know(p, ref);
    return h->prim[i] == ref - p->mesh.first && h->geom[i] == p->mesh.geom;
}

/* A triangle for one ray, by the leaf test itself. */
RTI_APART void pencil_ask(pencil *p, rtk_u32 mode, rtk_u32 bundle, rtk_u32 i, rtk_u32 ref)
{
    const rtk_u32 g = p->block[bundle];
    const rtk_part *part = p->part;
    rtk_query q;
    rtk_pray r;
    rti_lane_query(&q, p->scene, p->batch, p->first + g * RTK_BLOCK + i, p->scratch);
    if (!(mode & RTK_MODE_ANY))
        q.best = rti_lane_best(&p->hits[g], i);
    if (!rtk_ray_prepare(q.ray, part->lo, part->hi, part->scale, &r))
        return;
    if (rtk_query_prim(&q, mode, &r, ref)) {
        pencil_done(p, bundle, 1u << i);
    } else if (!(mode & RTK_MODE_ANY)) {
        rtk_hit_block *h = &p->hits[g];
        h->t[i] = q.best.t;
        h->u[i] = q.best.u;
        h->v[i] = q.best.v;
        h->prim[i] = q.best.prim;
        h->geom[i] = q.best.geom;
        p->changed |= PENCIL_ONE(bundle);
    }
}

/* What a triangle's test says of RTI_SIMD rays of a bundle, from lane k of their block on. */
RTI_VEC void pencil_take(pencil *p, rtk_u32 mode, const tri_ray *r, const float c[3][3], rtk_u32 bundle, rtk_u32 k, rtk_u32 ref,
                         tri_hit *hit)
{
    const rtk_u32 g = p->block[bundle];
    const rtk_trace_block *b = &p->rays[g];
    rtk_u32 ask = 0u;
    vec best = r->tmax;
    if (!(mode & RTK_MODE_ANY))
        best = V(load)(p->hits[g].t + k);
    if (__builtin_expect(hit->doubt != 0u, 0)) {
        const float *const dir[3] = {b->dx, b->dy, b->dz};
        ask = packet_doubt(r, mode, best, dir[p->kx] + k, dir[p->ky] + k, c, hit);
    }
    rtk_u32 take = hit->hit;
    if (mode & RTK_MODE_ANY) {
        pencil_done(p, bundle, take << k);
    } else {
        rtk_hit_block *h = &p->hits[g];
        vec_bits prim, geom;
        const rtk_u32 same = take & VM(bits)(V(eq)(hit->t, best));
        take &= VM(bits)(V(lt)(hit->t, best));
        if ((take | same) == 0u && ask == 0u)
            return;
        pencil_know(p, ref);
        for (rtk_u32 l = same; l != 0u; l &= l - 1u)
            if (!pencil_is(p, h, k + (rtk_u32)__builtin_ctz(l), ref))
                ask |= l & -l;
        const vmask in = VM(of)(take);
        vec id;
        V(store)(h->t + k, V(select)(in, hit->t, best));
        V(store)(h->u + k, V(select)(in, hit->u, V(load)(h->u + k)));
        V(store)(h->v + k, V(select)(in, hit->v, V(load)(h->v + k)));
        id = V(select)(in, V(set)(rtk_float(ref - p->mesh.first)), V(load)((const float *)(const void *)(h->prim + k)));
        memcpy(&prim, &id, sizeof prim);
        memcpy(h->prim + k, &prim, sizeof prim);
        id = V(select)(in, V(set)(rtk_float(p->mesh.geom)), V(load)((const float *)(const void *)(h->geom + k)));
        memcpy(&geom, &id, sizeof geom);
        memcpy(h->geom + k, &geom, sizeof geom);
        p->changed |= (pencil_bits)(take != 0u) << bundle;
    }
    for (; ask != 0u; ask &= ask - 1u)
        pencil_ask(p, mode, bundle, k + (rtk_u32)__builtin_ctz(ask), ref);
}

/* pencil_triangle, of corners in the rays' order of axes; org: of all rays, where `one` says so: what depends on that and on
 * corners alone is then found once. told: what is known of them, or NULL. */
RTI_VEC void pencil_bundles(pencil *p, rtk_u32 mode, const float c[3][3], rtk_u32 ref, pencil_bits bundles, const uint16_t *rays,
                            int one, const vec org[3], const tri_bounds *told)
{
    const rtk_u32 x = p->kx, y = p->ky, z = p->kz;
    const vec v0[3] = {V(set)(c[0][0]), V(set)(c[0][1]), V(set)(c[0][2])};
    const vec v1[3] = {V(set)(c[1][0]), V(set)(c[1][1]), V(set)(c[1][2])};
    const vec v2[3] = {V(set)(c[2][0]), V(set)(c[2][1]), V(set)(c[2][2])};
    for (; bundles != 0u; bundles &= bundles - 1u) {
        const rtk_u32 i = PENCIL_FIRST(bundles), g = p->block[i];
        const rtk_trace_block *from = &p->rays[g];
        const rtk_u32 live = rays ? (rtk_u32)p->live[i] & rays[i] : p->live[i];
        const float *const o[3] = {from->ox, from->oy, from->oz}, *const d[3] = {from->dx, from->dy, from->dz};
        for (rtk_u32 k = 0u; k < RTK_BLOCK; k += RTI_SIMD) {
            const rtk_u32 lanes = live >> k & LANES_ALL;
            if (PENCIL_HALVES > 1u && lanes == 0u)
                continue;
            const tri_ray r = {one ? org[0] : V(load)(o[x] + k),
                               one ? org[1] : V(load)(o[y] + k),
                               one ? org[2] : V(load)(o[z] + k),
                               V(load)(p->slope[0][g] + k),
                               V(load)(p->slope[1][g] + k),
                               V(load)(d[z] + k),
                               V(load)(from->tmin + k),
                               V(load)(from->tmax + k),
                               V(set)(0.0f),
                               V(set)(p->part->scale)};
            tri_hit hit;
            if (tri_told(&r, v0, v1, v2, lanes, told, mode & RTK_MODE_ANY, &hit) != 0u)
                pencil_take(p, mode, &r, c, i, k, ref, &hit);
        }
    }
}

/* Triangle j of a block for the rays of some bundles, or those of them in `rays` (NULL: all). one: as the pencil's; f: NULL where
 * the triangle was not looked at before. */
RTI_APART void pencil_triangle(pencil *p, rtk_u32 mode, const rtk_bvhblock *b, rtk_u32 j, rtk_u32 ref, pencil_bits bundles,
                               const uint16_t *rays, int one, const pencil_four *f)
{
    const rtk_u32 x = p->kx, y = p->ky, z = p->kz;
    const float c[3][3] = {{b->v0[x][j], b->v0[y][j], b->v0[z][j]},
                           {b->v1[x][j], b->v1[y][j], b->v1[z][j]},
                           {b->v2[x][j], b->v2[y][j], b->v2[z][j]}};
    const vec org[3] = {V(set)(p->apex[0]), V(set)(p->apex[1]), V(set)(p->apex[2])};
    /* Of any hits so few bundles meet a triangle that it is not worth it to find once what their rays share. */
    const int shared = one && !(mode & RTK_MODE_ANY);
    if (f && f->rough[j] < RTK_INF) {
        const tri_bounds told = {V(set)(f->deep[j]), V(set)(f->rough[j])};
        if (shared)
            pencil_bundles(p, mode, c, ref, bundles, rays, 1, org, &told);
        else
            pencil_bundles(p, mode, c, ref, bundles, rays, one, org, &told);
    } else if (shared) {
        pencil_bundles(p, mode, c, ref, bundles, rays, 1, org, NULL);
    } else {
        pencil_bundles(p, mode, c, ref, bundles, rays, one, org, NULL);
    }
}

#ifdef RTI_PACK8
/* Triangle j of a block is hit by a bundle's ray. */
RTI_VEC void pencil_hit(pencil *p, rtk_u32 bundle, rtk_u32 i, rtk_u32 ref, float t, float u, float v)
{
    rtk_hit_block *h = &p->hits[p->block[bundle]];
    if (!(t < h->t[i])) {
        if (t == h->t[i] && !pencil_is(p, h, i, ref))
            pencil_ask(p, 0u, bundle, i, ref);
        return;
    }
    pencil_know(p, ref);
    h->t[i] = t;
    h->u[i] = u;
    h->v[i] = v;
    h->prim[i] = ref - p->mesh.first;
    h->geom[i] = p->mesh.geom;
    p->changed |= PENCIL_ONE(bundle);
}

/* Puts the rays of a block side by side. */
RTI_APART void pencil_record(pencil *p, rtk_u32 g)
{
    const rtk_trace_block *b = &p->rays[g];
    const float *const o[3] = {b->ox, b->oy, b->oz}, *const d[3] = {b->dx, b->dy, b->dz};
    for (rtk_u32 k = 0u; k < RTK_BLOCK; k += RTI_SIMD) {
        const vec a[8] = {V(load)(o[p->kx] + k),       V(load)(o[p->ky] + k), V(load)(o[p->kz] + k), V(load)(p->slope[0][g] + k),
                          V(load)(p->slope[1][g] + k), V(load)(d[p->kz] + k), V(load)(b->tmin + k),  V(load)(b->tmax + k)};
        V(spread)(a, p->record[g][k], lane_eights);
    }
    p->recorded |= 1u << g;
}

/* The rays of some bundles, one behind the other: bundle * PENCIL_RAYS and the place among the pencil's rays. Returns how many.
 */
RTI_APART rtk_u32 pencil_list(pencil *p, pencil_bits bundles, const uint16_t rays[BUNDLES],
                              uint16_t list[PENCIL_RAYS + RTK_BLOCK])
{
    rtk_u32 n = 0u;
    for (; bundles != 0u; bundles &= bundles - 1u) {
        const rtk_u32 i = PENCIL_FIRST(bundles), g = p->block[i];
        if (!(p->recorded >> g & 1u))
            pencil_record(p, g);
        n += rti_u16_count(list + n, i * PENCIL_RAYS + g * RTK_BLOCK, rays[i]);
    }
    rti_u16_count(list + n, 0u, 0u); /* lists are read by FOUR_RAYS */
    return n;
}

/* A block's triangles, a bit each, for listed rays, FOUR_RAYS by four. one: as the pencil's. */
RTI_APART void pencil_fours(pencil *p, rtk_u32 mode, const rtk_bvhblock *b, const rtk_u32 *refs, rtk_u32 keep,
                            const uint16_t *list, rtk_u32 count, int one)
{
    enum { RAYS = sizeof(rtk_trace_block) / sizeof(float), HITS = sizeof(rtk_hit_block) / sizeof(float) };
    const rtk_u32 axis[3] = {p->kx, p->ky, p->kz};
    const float *const d[3] = {p->rays->dx, p->rays->dy, p->rays->dz};
    for (rtk_u32 first = 0u; first < count; first += FOUR_RAYS) {
        rtk_u32 record[FOUR_RAYS], at[FOUR_RAYS], best[FOUR_RAYS], lanes = FOUR_FIRST * keep, ask, bits;
        if (count - first < FOUR_RAYS)
            lanes &= (1u << 4u * (count - first)) - 1u;
        for (rtk_u32 i = 0u; i < FOUR_RAYS; i++) {
            const rtk_u32 ray = list[first + i] % PENCIL_RAYS;
            record[i] = ray * 8u;
            at[i] = ray / RTK_BLOCK * RAYS + ray % RTK_BLOCK;
            best[i] = ray / RTK_BLOCK * HITS + ray % RTK_BLOCK;
        }
        vec f[8];
        V(fields)(p->record[0][0], record, f);
        const tri_ray r = {one ? V(set)(p->apex[0]) : f[0],
                           one ? V(set)(p->apex[1]) : f[1],
                           one ? V(set)(p->apex[2]) : f[2],
                           f[3],
                           f[4],
                           f[5],
                           f[6],
                           f[7],
                           V(set)(0.0f),
                           V(set)(p->part->scale)};
        tri_hit hit;
        float t[RTI_SIMD], u[RTI_SIMD], v[RTI_SIMD];
        bits = packet_four_by_four(mode, &r, b, axis, lanes, mode & RTK_MODE_ANY ? NULL : p->hits->t, best, d[axis[0]],
                                   d[axis[1]], at, &hit, &ask);
        if ((bits | ask) == 0u)
            continue;
        if (!(mode & RTK_MODE_ANY)) {
            V(store)(t, hit.t);
            V(store)(u, hit.u);
            V(store)(v, hit.v);
        }
        for (; bits != 0u; bits &= bits - 1u) {
            const rtk_u32 i = (rtk_u32)__builtin_ctz(bits), of = list[first + i / 4u];
            if (mode & RTK_MODE_ANY)
                pencil_done(p, of / PENCIL_RAYS, 1u << of % RTK_BLOCK);
            else
                pencil_hit(p, of / PENCIL_RAYS, of % RTK_BLOCK, refs[i % 4u], t[i], u[i], v[i]);
        }
        for (; ask != 0u; ask &= ask - 1u) {
            const rtk_u32 i = (rtk_u32)__builtin_ctz(ask), of = list[first + i / 4u];
            pencil_ask(p, mode, of / PENCIL_RAYS, of % RTK_BLOCK, refs[i % 4u]);
        }
    }
}
#endif

/* A slot's box as rays of a pencil are asked for it: the depths between which it lies, and what its sides are of the others. */
typedef struct pencil_box {
    vec in, out, low[2], high[2];
} pencil_box;
RTI_VEC pencil_box pencil_box_of(const pencil *p, const rtk_bvhnode *n, rtk_u32 slot)
{
    const float zl = n->box[p->kz][0][slot], zh = n->box[p->kz][1][slot];
    const float in = p->turn > 0.0f ? zl - p->high[2] : p->low[2] - zh, out = p->turn > 0.0f ? zh - p->low[2] : p->high[2] - zl;
    const pencil_box box = {
        V(set)(rtk_max(in, 0.0f)),
        V(set)(out),
        {V(set)(n->box[p->kx][0][slot] - p->high[0]), V(set)(n->box[p->ky][0][slot] - p->high[1])},
        {V(set)(n->box[p->kx][1][slot] - p->low[0]), V(set)(n->box[p->ky][1][slot] - p->low[1])},
    };
    return box;
}

/* The rays of a bundle that meet a box: where rays start on what has corners, as seen from the apex, a rectangle is wider than
 * its rays; where triangles are small, few of a bundle meet a leaf. */
RTI_VEC rtk_u32 pencil_near_rays(const pencil *p, const pencil_box *box, rtk_u32 i)
{
    const rtk_u32 g = p->block[i];
    rtk_u32 met = 0u;
    for (rtk_u32 h = 0u; h < PENCIL_HALVES; h++) {
        const vec to = V(min)(V(set)(1.0f + PENCIL_U) * V(load)(p->to[g] + h * RTI_SIMD) + V(set)(p->margin), box->out);
        rtk_u32 lanes = pencil_lanes(p->live[i], h) & VM(bits)(V(le)(box->in, to));
        for (rtk_u32 k = 0u; k < 2u; k++) {
            const vec s = V(set)(p->turn) * V(load)(p->slope[k][g] + h * RTI_SIMD), a = s * box->in, b = s * to;
            lanes &= VM(bits)(V(le)(box->low[k], V(max)(a, b)));
            lanes &= VM(bits)(V(le)(V(min)(a, b), box->high[k]));
        }
        met |= lanes << h * RTI_SIMD;
    }
    return met;
}

/* Of some bundles those of which rays meet a slot's box, and which rays. */
RTI_APART pencil_bits pencil_near(const pencil *p, const rtk_bvhnode *n, rtk_u32 slot, pencil_bits bundles,
                                  uint16_t rays[BUNDLES])
{
    const pencil_box box = pencil_box_of(p, n, slot);
    pencil_bits some = 0u;
    for (; bundles != 0u; bundles &= bundles - 1u) {
        const rtk_u32 i = PENCIL_FIRST(bundles);
        rays[i] = (uint16_t)pencil_near_rays(p, &box, i);
        some |= (pencil_bits)(rays[i] != 0u) << i;
    }
    return some;
}

#endif
