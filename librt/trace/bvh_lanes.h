/* What walks of eight-wide nodes in vectors share: those of a BVH, and those that the leaves of a kd-tree or octree are in. */
#ifndef RTI_BVH_LANES_H
#define RTI_BVH_LANES_H

#include "../kernel/bvh.h"
#include "../kernel/query.h"
#include "tri_lanes.h"

#if RTI_SIMD >= 8
#define NODE(op) rti_f8_##op
#define NODE_N   8
typedef rti_f8 bvh_vec;
typedef rti_m8 bvh_mask;
typedef rti_tri_ray8 bvh_pairs_ray;
typedef rti_tri_hit8 bvh_pairs_hit;
#define node_bits  rti_m8_bits
#define node_of    rti_m8_of
#define pairs_test rti_tri8
#else
#define NODE(op)   rti_f4_##op
#define NODE_N     4
typedef rti_f4 bvh_vec;
typedef rti_m4 bvh_mask;
typedef rti_tri_ray4 bvh_pairs_ray;
typedef rti_tri_hit4 bvh_pairs_hit;
#define node_bits  rti_m4_bits
#define node_of    rti_m4_of
#define pairs_test rti_tri4
#endif

#define BVH_WALK_OTHER_(walk) walk##_other
#define BVH_WALK_OTHER(walk)  BVH_WALK_OTHER_(walk)

/* Where a ray may be met by plane * inv - org * inv (bvh_stream.h). */
#define BVH_START_MOST  1.0e37f  /* of |org * inv| */
#define BVH_START_LEAST 1.0e-35f /* of scale |inv| */

/* A ray against boxes; near: rows of box with the planes that it enters by. */
typedef struct bvh_ray {
    bvh_vec ox, oy, oz, ix, iy, iz, t0;
    rtk_u32 near[3];
} bvh_ray;

RTI_VEC bvh_ray bvh_ray_of(const rtk_pray *r)
{
    bvh_ray v;
    v.ox = NODE(set)(r->org.x);
    v.oy = NODE(set)(r->org.y);
    v.oz = NODE(set)(r->org.z);
    v.ix = NODE(set)(r->inv.x);
    v.iy = NODE(set)(r->inv.y);
    v.iz = NODE(set)(r->inv.z);
    v.t0 = NODE(set)(r->t0);
    v.near[0] = (rtk_bits(r->inv.x) >> 31) * RTK_BVH_WIDTH;
    v.near[1] = (2u + (rtk_bits(r->inv.y) >> 31)) * RTK_BVH_WIDTH;
    v.near[2] = (4u + (rtk_bits(r->inv.z) >> 31)) * RTK_BVH_WIDTH;
    return v;
}

/* The slots that the ray enters at or before `reach`, as bits; t: where it enters each. */
RTI_VEC rtk_u32 bvh_open(const rtk_bvhnode *n, const bvh_ray *v, float reach, float t[RTK_BVH_WIDTH])
{
    const float *box = &n->box[0][0][0];
    const float *x = box + v->near[0], *y = box + v->near[1], *z = box + v->near[2];
    const float *fx = box + (v->near[0] ^ RTK_BVH_WIDTH), *fy = box + (v->near[1] ^ RTK_BVH_WIDTH),
                *fz = box + (v->near[2] ^ RTK_BVH_WIDTH);
    bvh_vec end = NODE(set)(reach);
    rtk_u32 bits = 0u;
    for (rtk_u32 i = 0u; i < RTK_BVH_WIDTH; i += NODE_N) {
        bvh_vec t0 = NODE(max)(NODE(max)((NODE(load)(x + i) - v->ox) * v->ix, (NODE(load)(y + i) - v->oy) * v->iy),
                               NODE(max)((NODE(load)(z + i) - v->oz) * v->iz, v->t0));
        bvh_vec t1 = NODE(min)(NODE(min)((NODE(load)(fx + i) - v->ox) * v->ix, (NODE(load)(fy + i) - v->oy) * v->iy),
                               NODE(min)((NODE(load)(fz + i) - v->oz) * v->iz, end));
        NODE(store)(t + i, t0);
        bits |= node_bits(NODE(le)(t0, t1)) << i;
    }
    return bits;
}

/* Is a tree too large for the nearer caches, so that what comes next is worth asking for ahead? By its blocks; spheres count for
 * more bytes than they have, for nodes are most of it. */
#define BVH_LARGE      ((size_t)8 << 20)
#define BVH_BALL_BYTES 64u
RTI_VEC int bvh_larger(const rtk_tree *tree, size_t bytes)
{
    return tree->block_count > bytes / sizeof *tree->blocks || tree->ball_count > bytes / BVH_BALL_BYTES;
}

/* Has a group so many more triangles than shapes that its rays go as a mesh's do? (As packets, rays in sponza among 50 spheres were
 * half as fast; among 1000 spheres on 4000 triangles they are 1.2 times as fast.) */
RTI_VEC int bvh_mostly_mesh(const rtk_group *g)
{
    return g->shape_count <= g->tri_count / RTK_BVH_MESH;
}

RTI_VEC int bvh_large(const rtk_tree *tree)
{
    return bvh_larger(tree, BVH_LARGE);
}

/* The ball of the reference at a place. */
RTI_VEC const float *bvh_ball(const rtk_tree *tree, rtk_u32 place)
{
    return tree->balls + (size_t)(place - RTK_BVH_BLOCK * tree->block_count) * tree->ball_size;
}

/* Asks for what a slot holds, a node, a leaf's first two blocks or its balls, or of a leaf without any whatever stands there: it
 * will be looked at after what is nearer. */
RTI_VEC void bvh_expect(const rtk_tree *tree, rtk_u32 child, rtk_u32 count)
{
    const uintptr_t node = (uintptr_t)tree->bvh + child * sizeof *tree->bvh;
    const uintptr_t block = (uintptr_t)tree->blocks + child / 4u * sizeof *tree->blocks;
    const size_t floats = (size_t)(child - RTK_BVH_BLOCK * tree->block_count) * tree->ball_size;
    const uintptr_t ball = (uintptr_t)tree->balls + floats * sizeof *tree->balls;
    const int blocked = child < RTK_BVH_BLOCK * tree->block_count || tree->ball_count == 0u;
    const uintptr_t at = count == 0u ? node : (blocked ? block : ball); /* a number: it may be in no object */
    for (rtk_u32 i = 0u; i < 5u; i++)
        __builtin_prefetch((const void *)(at + i * 64u));
}

/* Of the slots in bits the one that the ray enters first; the others go onto the stack. With RTI_PACK bits may be 0: then any,
 * and none goes there. */
RTI_VEC rtk_u32 bvh_choose(const rtk_bvhnode *n, rtk_u32 bits, const float t[RTK_BVH_WIDTH], float *stack_t, rtk_u32 *stack_child,
                           rtk_u32 *stack_count, rtk_u32 *top)
{
#ifdef RTI_PACK
    const rti_f8 enter = rti_f8_load(t);
    const rtk_u32 i = rti_f8_least(bits, enter);
    bits &= ~(1u << i);
    rti_f8_pack(stack_t + *top, bits, enter);
    rti_u8_pack(stack_child + *top, bits, n->child);
    rti_u8_pack(stack_count + *top, bits, n->count);
    *top += (rtk_u32)__builtin_popcount(bits);
    return i;
#else
    rtk_u32 near = (rtk_u32)__builtin_ctz(bits);
    bits &= bits - 1u;
    for (; bits != 0u; bits &= bits - 1u) {
        rtk_u32 far = (rtk_u32)__builtin_ctz(bits);
        if (t[far] < t[near]) {
            rtk_u32 x = near;
            near = far;
            far = x;
        }
        stack_t[*top] = t[far];
        stack_child[*top] = n->child[far];
        stack_count[(*top)++] = n->count[far];
    }
    return near;
#endif
}

/* A distance that no box may be entered behind, in the prepared ray's t: the end of the ray, and the best hit (rtk_query_done).
 * That one's t is outer + (tshift + x): where those are not zero, as much is added as three roundings can be off. */
RTI_VEC float bvh_reach(const rtk_query *q, rtk_u32 mode, const rtk_pray *r, float outer)
{
    float best = q->best.t, x = best;
    if (mode & RTK_MODE_ANY)
        return r->t1;
    if (outer != 0.0f || r->tshift != 0.0f)
        x = ((best - outer) - r->tshift) + 9.5367432e-07f * (rtk_fabs(best) + rtk_fabs(outer) + rtk_fabs(r->tshift));
    return rtk_min(x, r->t1);
}

RTI_VEC void bvh_tri_ray(const rtk_pray *r, rti_tri_ray4 *v)
{
    v->ox = rti_f4_set(r->korg.x);
    v->oy = rti_f4_set(r->korg.y);
    v->oz = rti_f4_set(r->korg.z);
    v->sx = rti_f4_set(r->sx);
    v->sy = rti_f4_set(r->sy);
    v->kdz = rti_f4_set(r->kdz);
    v->tmin = rti_f4_set(r->tmin);
    v->tmax = rti_f4_set(r->tmax);
    v->tshift = rti_f4_set(r->tshift);
    v->scale = rti_f4_set(r->scale);
}

/* rtk_query_tri behind a test that has accepted. */
RTI_VEC int bvh_take(rtk_query *q, rtk_u32 mode, const rtk_pray *r, const rtk_tri *tri, float t, float u, float v, float outer)
{
    if (outer != 0.0f) {
        t = outer + t;
        if (!(t > q->ray.tmin && t < q->ray.tmax))
            return 0;
    }
    if (!rtk_query_wants(q, mode, t, tri->geom, tri->prim) || !rtk_query_sees(q, tri->geom, tri->prim, r->org, u, v))
        return 0;
    rtk_query_take(q, t, u, v, tri->geom, tri->prim);
    return (mode & RTK_MODE_ANY) != 0u;
}

/* The best hit of a walk while its identity is not needed: a reference of the group. Triangles stand in the order of hits, so of
 * two at one t the lower reference wins, and neither their records nor their geometries', which seldom are in the cache, are
 * read. */
typedef struct bvh_late {
    rtk_u32 plain; /* the group is, and the ray has a mask: every hit counts */
    rtk_u32 ref;   /* RTK_INVALID: the query holds the best */
} bvh_late;

RTI_VEC void bvh_settle(rtk_query *q, bvh_late *late)
{
    const rtk_tri *tri;
    if (late->ref == RTK_INVALID)
        return;
    tri = &q->group->tris[late->ref];
    q->best.geom = tri->geom;
    q->best.prim = tri->prim;
    q->best.inst = q->inst;
    late->ref = RTK_INVALID;
}

/* Of block k the lanes of the leaf's own triangles. The others are of a leaf beside it, or repeat one. */
RTI_VEC rtk_u32 bvh_own(rtk_u32 k, rtk_u32 at, rtk_u32 count)
{
    const rtk_u32 first = rtk_umax(at, 4u * k) - 4u * k, end = rtk_umin(at + count, 4u * k + 4u) - 4u * k;
    return (1u << end) - (1u << first);
}

#define BVH_PAIRS (NODE_N / 4u) /* blocks that one ray meets at a time */

/* One ray and the triangles of block k of a leaf, and where vectors hold them of the next one; lanes that are not the leaf's do
 * not count. x, y, z: the ray's order of axes; end: behind the leaf's blocks. Returns as rti_tri8. */
RTI_VEC rtk_u32 bvh_pairs(const rtk_tree *tree, rtk_u32 k, rtk_u32 at, rtk_u32 count, rtk_u32 end, rtk_u32 x, rtk_u32 y,
                          rtk_u32 z, const bvh_pairs_ray *ray, bvh_pairs_hit *hit)
{
    const rtk_bvhblock *b = &tree->blocks[k];
    rtk_u32 want = bvh_own(k, at, count);
#if NODE_N > 4
    const rtk_bvhblock *c = k + 1u < end ? b + 1 : b;
    want |= k + 1u < end ? bvh_own(k + 1u, at, count) << 4 : 0u;
#define ROW(v, axis) rti_f8_two(b->v[axis], c->v[axis])
#else
    (void)end;
#define ROW(v, axis) rti_f4_load(b->v[axis])
#endif
    const bvh_vec p0[3] = {ROW(v0, x), ROW(v0, y), ROW(v0, z)};
    const bvh_vec p1[3] = {ROW(v1, x), ROW(v1, y), ROW(v1, z)};
    const bvh_vec p2[3] = {ROW(v2, x), ROW(v2, y), ROW(v2, z)};
#undef ROW
    return pairs_test(ray, p0, p1, p2, want, hit);
}

/* The blocks of a leaf. */
RTI_VEC int bvh_blocks(rtk_query *q, rtk_u32 mode, const rtk_pray *r, const rti_tri_ray4 *lanes, const rtk_tree *tree, rtk_u32 at,
                       rtk_u32 count, float outer, bvh_late *late)
{
    rtk_u32 k, end = (at + count + 3u) / 4u;
    for (k = at / 4u; k < end; k++) {
        const rtk_bvhblock *b = &tree->blocks[k];
        rti_f4 p0[3] = {rti_f4_load(b->v0[r->kx]), rti_f4_load(b->v0[r->ky]), rti_f4_load(b->v0[r->kz])};
        rti_f4 p1[3] = {rti_f4_load(b->v1[r->kx]), rti_f4_load(b->v1[r->ky]), rti_f4_load(b->v1[r->kz])};
        rti_f4 p2[3] = {rti_f4_load(b->v2[r->kx]), rti_f4_load(b->v2[r->ky]), rti_f4_load(b->v2[r->kz])};
        rti_tri_hit4 hit;
        float t[4], u[4], v[4], off[4];
        rtk_u32 bits = rti_tri4(lanes, p0, p1, p2, 15u, &hit), last = RTK_INVALID;
        if (bits == 0u)
            continue;
        rti_f4_store(t, hit.t);
        rti_f4_store(u, hit.u);
        rti_f4_store(v, hit.v);
        for (; bits != 0u; bits &= bits - 1u) {
            rtk_u32 i = (rtk_u32)__builtin_ctz(bits);
            const rtk_tri *tri;
            if (!(hit.doubt >> i & 1u) && outer == 0.0f) {
                if ((mode & RTK_MODE_ANY) && late->plain)
                    return 1;
                if (!(mode & RTK_MODE_ANY) && t[i] > q->best.t)
                    continue;
                if (mode == 0u && late->plain && (t[i] < q->best.t || late->ref != RTK_INVALID)) {
                    rtk_u32 ref = tree->refs[4u * k + i];
                    if (t[i] < q->best.t || ref < late->ref) {
                        q->best.t = t[i];
                        q->best.u = u[i];
                        q->best.v = v[i];
                        late->ref = ref;
                    }
                    continue;
                }
            }
            if (hit.doubt >> i & 1u) {
                if (tree->refs[4u * k + i] == last) /* a block's last triangle stands in the lanes that are left */
                    continue;
                last = tree->refs[4u * k + i];
                if ((hit.certain >> i & 1u) && outer == 0.0f) {
                    if ((mode & RTK_MODE_ANY) && late->plain)
                        return 1;
                    rti_f4_store(off, hit.off);
                    if (mode == 0u && t[i] - off[i] > q->best.t)
                        continue;
                }
                const float reach = outer == 0.0f && mode == 0u ? rtk_min(r->tmax, q->best.t) : r->tmax;
                const rti_tri_pair pair = {r->korg.x, r->korg.y, r->korg.z, r->sx,   r->sy,
                                           r->kdz,    r->tshift, r->scale,  r->tmin, reach};
                const float c0[3] = {b->v0[r->kx][i], b->v0[r->ky][i], b->v0[r->kz][i]};
                const float c1[3] = {b->v1[r->kx][i], b->v1[r->ky][i], b->v1[r->kz][i]};
                const float c2[3] = {b->v2[r->kx][i], b->v2[r->ky][i], b->v2[r->kz][i]};
                const int sure = rti_tri_settle(&pair, c0, c1, c2, NULL);
                if (sure < 0)
                    continue;
                if (sure > 0 && (mode & RTK_MODE_ANY) && late->plain && outer == 0.0f)
                    return 1;
            }
            bvh_settle(q, late);
            tri = &q->group->tris[tree->refs[4u * k + i]];
            if (hit.doubt >> i & 1u ? rtk_query_tri(q, mode, r, tri) : bvh_take(q, mode, r, tri, t[i], u[i], v[i], outer))
                return 1;
        }
    }
    return 0;
}

#endif
