/* Shapes in a pencil's way, for hot files: for RTI_SIMD rays of a bundle at a time, as packets meet them, but tori ray by ray. So
 * a mesh's rays go as pencils though there are shapes beside it; what is of shapes alone goes as packets or streams. */
#ifndef RTI_PENCIL_SHAPE_H
#define RTI_PENCIL_SHAPE_H

#include "packet_shape.h"
#include "pencil_meet.h"

/* Lanes `hit` of a bundle's block from k on meet a shape at t; returns those of equal hits, whose order is to be asked for. */
RTI_VEC rtk_u32 pencil_take_shape(pencil *p, rtk_u32 mode, const rtk_shape *shape, rtk_u32 bundle, rtk_u32 k, rtk_u32 hit, vec t)
{
    if (mode & RTK_MODE_ANY) {
        pencil_done(p, bundle, hit << k);
        return 0u;
    }
    rtk_hit_block *h = &p->hits[p->block[bundle]];
    float each[RTI_SIMD];
    rtk_u32 take = hit & VM(bits)(V(lt)(t, V(load)(h->t + k)));
    hit &= VM(bits)(V(eq)(t, V(load)(h->t + k)));
    V(store)(each, t);
    p->changed |= (pencil_bits)(take != 0u) << bundle;
    for (; take != 0u; take &= take - 1u) {
        const rtk_u32 i = (rtk_u32)__builtin_ctz(take);
        h->t[k + i] = each[i];
        h->u[k + i] = h->v[k + i] = 0.0f;
        h->prim[k + i] = shape->prim;
        h->geom[k + i] = shape->geom;
    }
    return hit;
}

/* Of `lanes` those that enter a slot's box no farther than `most`. */
RTI_VEC rtk_u32 pencil_slab(const packet_rays *r, const rtk_bvhnode *n, rtk_u32 slot, vec most, rtk_u32 lanes)
{
    vec t0 = r->tmin, t1 = most;
    for (rtk_u32 k = 0u; k < 3u; k++) {
        const vec a = (V(set)(n->box[k][0][slot]) - r->org[k]) * r->inv[k],
                  b = (V(set)(n->box[k][1][slot]) - r->org[k]) * r->inv[k];
        t0 = V(max)(t0, V(min)(a, b));
        t1 = V(min)(t1, V(max)(a, b));
    }
    return lanes & VM(bits)(V(le)(t0, t1));
}

/* A leaf without blocks for `lanes` of a bundle from k on. */
RTI_VEC void pencil_refs_for(pencil *p, rtk_u32 mode, const rtk_bvhnode *n, rtk_u32 slot, rtk_u32 bundle, rtk_u32 k,
                             rtk_u32 lanes)
{
    const rtk_group *group = p->scene->groups;
    const rtk_tree *tree = &p->part->bvh;
    const rtk_u32 g = p->block[bundle];
    packet_rays rays;
    packet_rays_load(&rays, &p->rays[g], k);
    const ball_rays r = shape_rays(&rays, p->part->scale);
    for (rtk_u32 at = n->child[slot], end = at + n->count[slot]; at < end; at++) {
        const vec most = mode & RTK_MODE_ANY ? r.tmax : V(load)(p->hits[g].t + k);
        const rtk_u32 ref = tree->refs[at];
        rtk_u32 hit = 0u, ask;
        vec t;
        lanes = pencil_slab(&rays, n, slot, most, lanes) & p->live[bundle] >> k;
        if (lanes == 0u)
            return;
        ask = lanes;
        if (tree->ball_count != 0u)
            hit = shape_hits(&r, rays.inv, bvh_ball(tree, at), tree->ball_size, most, lanes, &t, &ask);
        if (hit != 0u)
            ask |= pencil_take_shape(p, mode, &group->shapes[ref - group->tri_count], bundle, k, hit, t);
        for (; ask != 0u; ask &= ask - 1u)
            pencil_ask(p, mode, bundle, k + (rtk_u32)__builtin_ctz(ask), ref);
    }
}

/* A leaf without blocks for the rays of some bundles. */
RTI_APART void pencil_refs(pencil *p, rtk_u32 mode, const rtk_bvhnode *n, rtk_u32 slot, pencil_bits bundles)
{
    uint16_t rays[BUNDLES];
    p->leaves++;
    for (bundles = pencil_near(p, n, slot, bundles, rays); bundles != 0u; bundles &= bundles - 1u) {
        const rtk_u32 i = PENCIL_FIRST(bundles);
        p->told += (rtk_u32)__builtin_popcount(rays[i]);
        for (rtk_u32 h = 0u; h < PENCIL_HALVES; h++)
            pencil_refs_for(p, mode, n, slot, i, h * RTI_SIMD, pencil_lanes(rays[i] & p->live[i], h));
    }
}

#endif
