/* What both integrators of the classic material do in lanes: its looks, points that are noted for the lights, rays that leave a
 * sheaf. For lanes_whitted.c and lanes_path.c. */
#ifndef RTI_LANES_CLASSIC_H
#define RTI_LANES_CLASSIC_H

#include "../kernel/classic.h"
#include "../kernel/surface.h"
#include "lanes_rows.h"
#include "shade_limits.h"

/* Fills c->looks, unless those of the last sheaf will do. */
RTI_LANES_FN static inline void rti_load_looks(const rtk_scene *scene, rti_sheaf *c)
{
    rti_looks *l = &c->looks;
    const rtk_material *m = &scene->materials[c->material[0]];
    float ambient = 0.0f, mirror = 0.0f, clear = 0.0f, specular = 0.0f;
    if (c->one_material && l->of_all == c->material[0])
        return;
    if (c->one_material) {
        const float d = m->diffusion, r = m->reflectiveness, t = m->transparency, a = m->ambient, s = m->specular,
                    e = m->shininess, index = rtk_index_of(m);
        RTI_EACH_LANE(k)
        {
            l->diffusion[k] = d;
            l->reflectiveness[k] = r;
            l->transparency[k] = t;
            l->ambient[k] = a;
            l->specular[k] = s;
            l->shininess[k] = e;
            l->index[k] = index;
        }
        ambient = a;
        mirror = r;
        clear = t;
        specular = rtk_fabs(s);
    } else {
        RTI_EACH_LANE(k)
        {
            m = &scene->materials[c->material[k]];
            l->diffusion[k] = m->diffusion;
            l->reflectiveness[k] = m->reflectiveness;
            l->transparency[k] = m->transparency;
            l->ambient[k] = m->ambient;
            l->specular[k] = m->specular;
            l->shininess[k] = m->shininess;
            l->index[k] = rtk_index_of(m);
            ambient = rtk_max(ambient, m->ambient);
            mirror = rtk_max(mirror, m->reflectiveness);
            clear = rtk_max(clear, m->transparency);
            specular = rtk_max(specular, rtk_fabs(m->specular));
        }
    }
    l->of_all = c->one_material ? c->material[0] : RTK_INVALID;
    l->shown = ambient > 0.0f;
    l->mirrors = mirror > 0.0f;
    l->clear = clear > 0.0f;
    l->shiny = specular > 0.0f; /* of whatever sign: files may have any */
}

/* Highlights, and the ways to who sees them, of points that have some, or stand among such. */
RTI_LANES_FN static inline void rti_note_shiny(const rti_worker *w, const rti_sheaf *c, const rti_looks *l)
{
    float *vx = rti_lit_row(w, RTI_LIT_VX), *vy = rti_lit_row(w, RTI_LIT_VY), *vz = rti_lit_row(w, RTI_LIT_VZ);
    float *sr = rti_lit_row(w, RTI_LIT_SR), *sg = rti_lit_row(w, RTI_LIT_SG), *sb = rti_lit_row(w, RTI_LIT_SB);
    memcpy(rti_lit_row(w, RTI_LIT_SHININESS), l->shininess, sizeof l->shininess);
    RTI_EACH_LANE(k)
    {
        rtk_vec3 specular = rtk_scale(rtk_v3(c->tpr[k], c->tpg[k], c->tpb[k]), l->specular[k]);
        vx[k] = -c->dx[k];
        vy[k] = -c->dy[k];
        vz[k] = -c->dz[k];
        sr[k] = specular.x;
        sg[k] = specular.y;
        sb[k] = specular.z;
    }
}

/* Points that may be lit are noted in two halves. First where they are, and from where they are seen and their highlights, where
 * there are some; what is missing then (RTI_LIT_KR to KB, RTI_LIT_DIFFUSE_PDF) goes to their rows (rti_lit_row). */
static inline void rti_note_seen(rti_worker *w, const rti_sheaf *c, const rti_looks *l)
{
    rti_note_points(w, c);
    if (l->shiny && !w->lit_shiny) {
        w->lit_shiny = true; /* those before have none */
        for (uint32_t row = RTI_LIT_SR; row <= RTI_LIT_SB; row++)
            memset(w->lit + row * (size_t)w->lit_stride, 0, w->lit_count * sizeof *w->lit);
    }
    if (w->lit_shiny)
        rti_note_shiny(w, c, l);
}

/* Then only those stay that some light can be seen in. What stands behind the count is overwritten by the next. */
RTI_LANES_FN static inline void rti_note_lit(rti_worker *w, const rti_sheaf *c)
{
    const float *kr = rti_lit_row(w, RTI_LIT_KR), *kg = rti_lit_row(w, RTI_LIT_KG), *kb = rti_lit_row(w, RTI_LIT_KB);
    const float *sr = rti_lit_row(w, RTI_LIT_SR), *sg = rti_lit_row(w, RTI_LIT_SG), *sb = rti_lit_row(w, RTI_LIT_SB);
    float *from = w->lit + w->lit_count;
    uint32_t lit[RTK_BLOCK] RTI_ROW;
    RTI_EACH_LANE(k)
    lit[k] = (uint32_t) !(rtk_maxabs(rtk_v3(kr[k], kg[k], kb[k])) == 0.0f);
    if (w->lit_shiny) {
        RTI_EACH_LANE(k)
        lit[k] |= (uint32_t) !(rtk_maxabs(rtk_v3(sr[k], sg[k], sb[k])) == 0.0f);
    }
    if (rti_u32_unlike(lit, 1) == 0) {
        w->lit_count += c->count;
        return;
    }
    for (uint32_t k = 0; k < c->count; k++) {
        const uint32_t at = w->lit_count;
        if (!lit[k])
            continue;
        for (uint32_t r = 0; r < RTI_LIT_ROWS; r++)
            w->lit[r * (size_t)w->lit_stride + at] = from[r * (size_t)w->lit_stride + k];
        w->lit_ray[at] = c->ray[k];
        w->lit_home[at] = c->home[k];
        w->lit_count++;
    }
}

/* Rays that leave a sheaf, and what they have of those that made them. */
typedef struct rti_leaving {
    float ox[RTK_BLOCK] RTI_ROW, oy[RTK_BLOCK] RTI_ROW, oz[RTK_BLOCK] RTI_ROW;
    float dx[RTK_BLOCK] RTI_ROW, dy[RTK_BLOCK] RTI_ROW, dz[RTK_BLOCK] RTI_ROW;
    float tr[RTK_BLOCK] RTI_ROW, tg[RTK_BLOCK] RTI_ROW, tb[RTK_BLOCK] RTI_ROW;
    uint32_t pixel[RTK_BLOCK] RTI_ROW, sample[RTK_BLOCK] RTI_ROW;
    uint32_t depth_kind[RTK_BLOCK] RTI_ROW; /* here of who made them */
    uint32_t key_lo[RTK_BLOCK] RTI_ROW, key_hi[RTK_BLOCK] RTI_ROW;
    float eta[RTK_BLOCK] RTI_ROW;
    float spread[RTK_BLOCK] RTI_ROW, pdf[RTK_BLOCK] RTI_ROW; /* of the new rays */
} rti_leaving;

/* Fills what they have of those that made them: pixel ... eta. */
static inline void rti_leaving_of(const rti_worker *w, const rti_sheaf *c, rti_leaving *s)
{
    rti_take_rows(c, (const char *)w->batch.path + offsetof(rtk_path_block, pixel), sizeof *w->batch.path, 6,
                  (char *)s + offsetof(rti_leaving, pixel));
}

/* Their keys become those of children of a kind. */
RTI_LANES_FN static inline void rti_leaving_keys(rti_leaving *s, uint32_t kind)
{
    RTI_EACH_LANE(k)
    {
        rtk_key key = {s->key_lo[k], s->key_hi[k]};
        key = rtk_key_child(key, kind);
        s->key_lo[k] = key.lo;
        s->key_hi[k] = key.hi;
    }
}

/* Some lanes onto the stack. All are of one kind and depth. */
static inline void rti_push_lanes(rti_worker *w, const rti_sheaf *c, const rti_leaving *s, uint32_t kind, uint32_t mask,
                                  uint32_t lanes)
{
    const uint32_t depth_kind = (c->depth + 1) | kind << 16;
    w->counts.rays[kind] += (uint32_t)__builtin_popcount(lanes);
    for (uint32_t l = lanes; l != 0; l &= l - 1)
        w->slots[c->home[__builtin_ctz(l)] >> w->frame->slot_shift].live++;
    while (lanes != 0) {
        const rti_places places = rti_places_of(w->stack.count % RTK_BLOCK, &lanes), *to = &places;
        rtk_trace_block *t = &w->stack.trace[w->stack.count / RTK_BLOCK];
        rtk_path_block *p = &w->stack.path[w->stack.count / RTK_BLOCK];
        rti_put_row(t->ox, to, s->ox);
        rti_put_row(t->oy, to, s->oy);
        rti_put_row(t->oz, to, s->oz);
        rti_put_row(t->dx, to, s->dx);
        rti_put_row(t->dy, to, s->dy);
        rti_put_row(t->dz, to, s->dz);
        rti_put_all(t->tmin, to, rtk_bits(0.0f));
        rti_put_all(t->tmax, to, rtk_bits(RTK_INF));
        rti_put_all(t->mask, to, mask);
        rti_put_row(p->tpr, to, s->tr);
        rti_put_row(p->tpg, to, s->tg);
        rti_put_row(p->tpb, to, s->tb);
        rti_put_row(p->pixel, to, s->pixel);
        rti_put_row(p->sample, to, s->sample);
        rti_put_all(p->depth_kind, to, depth_kind);
        rti_put_row(p->key_lo, to, s->key_lo);
        rti_put_row(p->key_hi, to, s->key_hi);
        rti_put_row(p->eta, to, s->eta);
        rti_put_row(p->width, to, c->footprint);
        rti_put_row(p->spread, to, s->spread);
        rti_put_row(p->pdf, to, s->pdf);
        rti_put_row(w->stack.home[w->stack.count / RTK_BLOCK].home, to, c->home);
        w->stack.count += places.count;
    }
}

/* Rays leave the surface on the side that they point to. */
RTI_LANES_FN static inline void rti_leaving_start(const rti_sheaf *c, rti_leaving *s)
{
    RTI_EACH_LANE(k)
    {
        rtk_vec3 org = rtk_leave(rtk_v3(c->px[k], c->py[k], c->pz[k]), rtk_v3(c->gx[k], c->gy[k], c->gz[k]), c->error[k],
                                 rtk_v3(s->dx[k], s->dy[k], s->dz[k]));
        s->ox[k] = org.x;
        s->oy[k] = org.y;
        s->oz[k] = org.z;
    }
}

/* Rays of one direction a lane, of those lanes whose throughputs are worth it: directions, throughputs and pdf are there. */
RTI_LANES_FN static inline void rti_push_single(rti_worker *w, const rti_sheaf *c, rti_leaving *s, uint32_t kind, uint32_t mask,
                                                uint32_t some)
{
    uint32_t goes[RTK_BLOCK] RTI_ROW;
    rti_leaving_start(c, s);
    RTI_EACH_LANE(k)
    {
        goes[k] = rtk_maxabs(rtk_v3(s->tr[k], s->tg[k], s->tb[k])) >= RTI_THROUGHPUT_MIN;
        s->spread[k] = c->spread[k];
    }
    rti_leaving_keys(s, kind);
    rti_push_lanes(w, c, s, kind, mask, rti_lanes_of(goes, RTK_BLOCK) & some);
}

/* Mirror rays of some lanes: their throughputs are there. */
RTI_LANES_FN static inline void rti_push_mirrors(rti_worker *w, const rti_sheaf *c, rti_leaving *s, uint32_t some)
{
    RTI_EACH_LANE(k)
    {
        rtk_vec3 d = rtk_v3(c->dx[k], c->dy[k], c->dz[k]), ng = rtk_v3(c->gx[k], c->gy[k], c->gz[k]);
        rtk_vec3 a = rtk_reflect(d, rtk_v3(c->nx[k], c->ny[k], c->nz[k])), b = rtk_reflect(d, ng);
        int above = rtk_dot3(a, ng) > 0.0f; /* it stays on its side */
        s->dx[k] = above ? a.x : b.x;
        s->dy[k] = above ? a.y : b.y;
        s->dz[k] = above ? a.z : b.z;
        s->pdf[k] = -1.0f;
    }
    rti_push_single(w, c, s, RTK_KIND_REFLECT, RT_MASK_REFLECTION, some);
}

/* Rays that get through a sheaf's surfaces. */
typedef struct rti_bent {
    float dx[RTK_BLOCK] RTI_ROW, dy[RTK_BLOCK] RTI_ROW, dz[RTK_BLOCK] RTI_ROW;
    float cr[RTK_BLOCK] RTI_ROW, cg[RTK_BLOCK] RTI_ROW, cb[RTK_BLOCK] RTI_ROW; /* what they keep; 0 where none does */
    float mirror[RTK_BLOCK] RTI_ROW; /* what mirror rays keep: of lanes that are clear and where none gets through, more */
    uint32_t through[RTK_BLOCK] RTI_ROW;
} rti_bent;

RTI_LANES_FN static inline void rti_bend_lanes(const rti_sheaf *c, const rti_looks *l, rti_bent *b)
{
    uint32_t odd[RTK_BLOCK] RTI_ROW, rare;
    float ratio[RTK_BLOCK] RTI_ROW;
    RTI_EACH_LANE(k)
    {
        rtk_vec3 dir;
        int through, plain;
        ratio[k] = c->outside[k] ? 1.0f / l->index[k] : l->index[k];
        plain = rtk_bend_plain(rtk_v3(c->dx[k], c->dy[k], c->dz[k]), rtk_v3(c->nx[k], c->ny[k], c->nz[k]),
                               rtk_v3(c->gx[k], c->gy[k], c->gz[k]), ratio[k], &dir, &through);
        odd[k] = (uint32_t)((l->transparency[k] > 0.0f) & !plain);
        b->through[k] = (uint32_t)((l->transparency[k] > 0.0f) & through);
        b->dx[k] = dir.x;
        b->dy[k] = dir.y;
        b->dz[k] = dir.z;
    }
    for (rare = rti_u32_unlike(odd, 0); rare != 0; rare &= rare - 1) {
        const uint32_t k = (uint32_t)__builtin_ctz(rare);
        rtk_vec3 dir = {0.0f, 0.0f, 0.0f};
        b->through[k] = (uint32_t)rtk_bend(rtk_v3(c->dx[k], c->dy[k], c->dz[k]), rtk_v3(c->nx[k], c->ny[k], c->nz[k]),
                                           rtk_v3(c->gx[k], c->gy[k], c->gz[k]), ratio[k], &dir);
        b->dx[k] = dir.x;
        b->dy[k] = dir.y;
        b->dz[k] = dir.z;
    }
    RTI_EACH_LANE(k)
    {
        const float kept = b->through[k] ? l->transparency[k] : 0.0f; /* rtk_crossing */
        const float total = l->transparency[k] > 0.0f ? l->reflectiveness[k] + l->transparency[k] : l->reflectiveness[k];
        b->cr[k] = c->cr[k] * kept;
        b->cg[k] = c->cg[k] * kept;
        b->cb[k] = c->cb[k] * kept;
        b->mirror[k] = b->through[k] ? l->reflectiveness[k] : total;
    }
}

/* Refracted rays of some lanes: their throughputs and pdf are there. */
RTI_LANES_FN static inline void rti_push_refracted(rti_worker *w, const rti_sheaf *c, const rti_looks *l, const rti_bent *b,
                                                   rti_leaving *s, uint32_t some)
{
    memcpy(s->dx, b->dx, sizeof s->dx);
    memcpy(s->dy, b->dy, sizeof s->dy);
    memcpy(s->dz, b->dz, sizeof s->dz);
    RTI_EACH_LANE(k)
    s->eta[k] = c->outside[k] ? l->index[k] : 1.0f;
    rti_push_single(w, c, s, RTK_KIND_REFRACT, RT_MASK_REFRACTION, rti_lanes_of(b->through, RTK_BLOCK) & some);
}

#endif
