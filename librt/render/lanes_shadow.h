/* Sixteen shadow rays, and how they get into the queue (shadow.c), for lanes_light.c, lanes_lamp.c and lanes_around.c. */
#ifndef RTI_LANES_SHADOW_H
#define RTI_LANES_SHADOW_H

#include "../kernel/classic.h"
#include "../kernel/rng.h"
#include "lanes_rows.h"

/* The rays and what they bring. */
typedef struct rti_shadow_lanes {
    float ox[RTK_BLOCK] RTI_ROW, oy[RTK_BLOCK] RTI_ROW, oz[RTK_BLOCK] RTI_ROW;
    float dx[RTK_BLOCK] RTI_ROW, dy[RTK_BLOCK] RTI_ROW, dz[RTK_BLOCK] RTI_ROW;
    float tmax[RTK_BLOCK] RTI_ROW;
    float cosine[RTK_BLOCK] RTI_ROW;
    float er[RTK_BLOCK] RTI_ROW, eg[RTK_BLOCK] RTI_ROW, eb[RTK_BLOCK] RTI_ROW;
    rti_light_lanes c;
    uint32_t goes[RTK_BLOCK] RTI_ROW;
} rti_shadow_lanes;

/* A row of the points that are noted, from point `at` on. */
static inline const float *rti_lit_from(const rti_worker *w, uint32_t row, uint32_t at)
{
    return w->lit + (size_t)row * w->lit_stride + at;
}

/* Coordinate i of their shading normals. */
static inline const float *rti_lit_normal(const rti_worker *w, uint32_t i, uint32_t at)
{
    return rti_lit_from(w, (w->lit_smooth ? RTI_LIT_NX : RTI_LIT_GX) + i, at);
}

/* How much of their highlights points show that light comes to, and false where none has any to show. */
static inline bool rti_highlight_lanes(const rti_worker *w, uint32_t at, const rti_shadow_lanes *s, float *shine)
{
    const float *sr = rti_lit_from(w, RTI_LIT_SR, at), *sg = rti_lit_from(w, RTI_LIT_SG, at),
                *sb = rti_lit_from(w, RTI_LIT_SB, at);
    const float *nx = rti_lit_normal(w, 0, at), *ny = rti_lit_normal(w, 1, at), *nz = rti_lit_normal(w, 2, at);
    const float *vx = rti_lit_from(w, RTI_LIT_VX, at), *vy = rti_lit_from(w, RTI_LIT_VY, at),
                *vz = rti_lit_from(w, RTI_LIT_VZ, at);
    const float *power = rti_lit_from(w, RTI_LIT_SHININESS, at);
    uint32_t glossy[RTK_BLOCK] RTI_ROW, odd[RTK_BLOCK] RTI_ROW, rare;
    RTI_EACH_LANE(k)
    glossy[k] = s->goes[k] & (uint32_t)(rtk_maxabs(rtk_v3(sr[k], sg[k], sb[k])) > 0.0f);
    if (rti_u32_unlike(glossy, 0) == 0)
        return false;
    RTI_EACH_LANE(k)
    {
        float bright;
        const int plain = rtk_highlight_plain(power[k], rtk_v3(nx[k], ny[k], nz[k]), rtk_v3(s->dx[k], s->dy[k], s->dz[k]),
                                              rtk_v3(vx[k], vy[k], vz[k]), &bright);
        shine[k] = bright;
        odd[k] = glossy[k] & (uint32_t)!plain;
    }
    for (rare = rti_u32_unlike(odd, 0); rare != 0; rare &= rare - 1) {
        const uint32_t k = (uint32_t)__builtin_ctz(rare);
        shine[k] = rtk_highlight(power[k], rtk_v3(nx[k], ny[k], nz[k]), rtk_v3(s->dx[k], s->dy[k], s->dz[k]),
                                 rtk_v3(vx[k], vy[k], vz[k]));
    }
    return true;
}

/* As rti_weigh_lanes. Whether shine is NULL (no highlight shows) is a constant of the caller, too. */
static inline void rti_weigh_by(const rti_worker *w, uint32_t at, const float *shine, bool shares, const float *share,
                                const float *scale, rti_shadow_lanes *s)
{
    const float *kr = rti_lit_from(w, RTI_LIT_KR, at), *kg = rti_lit_from(w, RTI_LIT_KG, at),
                *kb = rti_lit_from(w, RTI_LIT_KB, at);
    const float *sr = rti_lit_from(w, RTI_LIT_SR, at), *sg = rti_lit_from(w, RTI_LIT_SG, at),
                *sb = rti_lit_from(w, RTI_LIT_SB, at);
    RTI_EACH_LANE(k)
    {
        rtk_vec3 c = rtk_v3(kr[k], kg[k], kb[k]);
        c = shares ? rtk_scale(c, share[k]) : c;
        if (shine) {
            const rtk_vec3 spec = rtk_v3(sr[k], sg[k], sb[k]), add = rtk_madd(c, shine[k], spec);
            const int glossy = rtk_maxabs(spec) > 0.0f;
            c = rtk_v3(glossy ? add.x : c.x, glossy ? add.y : c.y, glossy ? add.z : c.z);
        }
        c = rtk_mul(c, rtk_scale(rtk_v3(s->er[k], s->eg[k], s->eb[k]), shares ? s->cosine[k] * scale[k] : s->cosine[k]));
        s->c.r[k] = c.x;
        s->c.g[k] = c.y;
        s->c.b[k] = c.z;
        s->goes[k] &= (uint32_t) !(rtk_maxabs(c) == 0.0f);
    }
}

/* What each brings where nothing is between; a lane to which it brings nothing does not go. shares, a constant of the caller:
 * there are weights of the Lambert part, `share`, and of all, `scale`. */
static inline void rti_weigh_lanes(const rti_worker *w, uint32_t at, bool shares, const float *share, const float *scale,
                                   rti_shadow_lanes *s)
{
    float shine[RTK_BLOCK] RTI_ROW;
    if (w->lit_shiny && rti_highlight_lanes(w, at, s, shine))
        rti_weigh_by(w, at, shine, shares, share, scale, s);
    else
        rti_weigh_by(w, at, NULL, shares, share, scale, s);
}

/* All sixteen, into a block of the queue as they are. */
static inline void rti_queue_block(rti_worker *w, uint32_t at, const rti_shadow_lanes *s)
{
    rti_shadows *q = &w->shadows;
    rtk_trace_block *t = &q->trace[q->count / RTK_BLOCK];
    rti_pending_block *p = &q->pending[q->count / RTK_BLOCK];
    memcpy(t->ox, s->ox, sizeof t->ox);
    memcpy(t->oy, s->oy, sizeof t->oy);
    memcpy(t->oz, s->oz, sizeof t->oz);
    memcpy(t->dx, s->dx, sizeof t->dx);
    memcpy(t->dy, s->dy, sizeof t->dy);
    memcpy(t->dz, s->dz, sizeof t->dz);
    memcpy(t->tmax, s->tmax, sizeof t->tmax);
    memcpy(p->r, s->c.r, sizeof p->r);
    memcpy(p->g, s->c.g, sizeof p->g);
    memcpy(p->b, s->c.b, sizeof p->b);
    memcpy(p->home, w->lit_home + at, sizeof p->home);
    RTI_EACH_LANE(k)
    {
        t->tmin[k] = 0.0f;
        t->mask[k] = RT_MASK_SHADOW;
    }
    q->count += RTK_BLOCK;
}

/* Some lanes behind those that are queued, in one block or two. */
static inline void rti_queue_some(rti_worker *w, uint32_t at, uint32_t lanes, const rti_shadow_lanes *s)
{
    rti_shadows *q = &w->shadows;
    while (lanes != 0) {
        const rti_places places = rti_places_of(q->count % RTK_BLOCK, &lanes), *to = &places;
        rtk_trace_block *t = &q->trace[q->count / RTK_BLOCK];
        rti_pending_block *p = &q->pending[q->count / RTK_BLOCK];
        rti_put_row(t->ox, to, s->ox);
        rti_put_row(t->oy, to, s->oy);
        rti_put_row(t->oz, to, s->oz);
        rti_put_row(t->dx, to, s->dx);
        rti_put_row(t->dy, to, s->dy);
        rti_put_row(t->dz, to, s->dz);
        rti_put_all(t->tmin, to, 0);
        rti_put_row(t->tmax, to, s->tmax);
        rti_put_all(t->mask, to, RT_MASK_SHADOW);
        rti_put_row(p->r, to, s->c.r);
        rti_put_row(p->g, to, s->c.g);
        rti_put_row(p->b, to, s->c.b);
        rti_put_row(p->home, to, w->lit_home + at);
        q->count += places.count;
    }
}

/* Lanes of points [at, at + 16) ask whether anything is between. light: that they go to, or RTI_LIGHT_MIXED: then `lights` has
 * each lane's (NULL: none). */
static inline void rti_queue_lanes(rti_worker *w, uint32_t light, const uint32_t *lights, uint32_t at, uint32_t lanes,
                                   const rti_shadow_lanes *s)
{
    rti_shadows *q = &w->shadows;
    if (lanes == 0)
        return;
    if (q->capacity - q->count > RTK_BLOCK && !w->frame->moving) {
        if (lanes == 0xffffu && q->count % RTK_BLOCK == 0)
            rti_queue_block(w, at, s);
        else
            rti_queue_some(w, at, lanes, s);
        q->light = q->light == RTK_INVALID || q->light == light ? light : RTI_LIGHT_MIXED;
        return;
    }
    for (uint32_t k = 0; k < RTK_BLOCK; k++)
        if (lanes >> k & 1u)
            rti_shadow(w, lights ? lights[k] : light, rtk_v3(s->ox[k], s->oy[k], s->oz[k]), rtk_v3(s->dx[k], s->dy[k], s->dz[k]),
                       s->tmax[k], rtk_v3(s->c.r[k], s->c.g[k], s->c.b[k]), w->lit_home[at + k],
                       rti_batch_time(w, w->lit_ray[at + k]));
}

/* What the random numbers of points [at, at + n) share, and their samples; lanes behind n repeat the first. */
RTI_LANES_FN static inline void rti_draw_lit(const rti_worker *w, uint32_t at, uint32_t n, uint32_t *seed, uint32_t *sample)
{
    const uint32_t of_frame = w->frame->seed;
    uint32_t pixel[RTK_BLOCK] RTI_ROW, lo[RTK_BLOCK] RTI_ROW, hi[RTK_BLOCK] RTI_ROW;
    for (uint32_t k = 0; k < RTK_BLOCK; k++) {
        const uint32_t ray = w->lit_ray[k < n ? at + k : at];
        const rtk_path_block *p = &w->batch.path[ray / RTK_BLOCK];
        pixel[k] = p->pixel[ray % RTK_BLOCK];
        lo[k] = p->key_lo[ray % RTK_BLOCK];
        hi[k] = p->key_hi[ray % RTK_BLOCK];
        sample[k] = p->sample[ray % RTK_BLOCK];
    }
    RTI_EACH_LANE(k)
    {
        rtk_key key = {lo[k], hi[k]};
        seed[k] = rtk_vertex_seed(of_frame, pixel[k], key);
    }
}

#endif
