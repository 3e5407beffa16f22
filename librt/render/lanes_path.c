/* Path tracing in lanes. Each hit asks one light, chosen by power, and goes on by one lobe of the classic material: diffuse,
 * mirror or refraction, chosen by the largest component of what each would keep. Against `whitted`: the ambient term is left out,
 * for the light between surfaces that it stands for is computed; the highlight is light from the lights alone, as there.
 *
 * A spherical light whose body is visible can be met by a diffuse ray too. With inverse-square falloff both ways are weighed by
 * the balance heuristic (Veach, Guibas 1995); without falloff such a light has no radiance of its own, and only asking counts.
 * So it does for all lights where shadow rays get through bodies (rti_frame.asks_through): what came through them straight would
 * come bent a second time.
 *
 * Russian roulette draws from the path's own key, so a path's end does not depend on when it is looked at. */
#include "../kernel/integrate.h"
#include "../kernel/lights.h"
#include "../kernel/sampling.h"
#include "lanes.h"
#include "lanes_classic.h"
#include "lanes_table.h"
#include "shade.h"

/* Shares of a sheaf's lobes, each lane's random numbers, and which way it goes on. */
typedef struct lobes {
    float dr[RTK_BLOCK] RTI_ROW, dg[RTK_BLOCK] RTI_ROW, db[RTK_BLOCK] RTI_ROW; /* the diffuse lobe's weight */
    float diffuse[RTK_BLOCK] RTI_ROW, crossing[RTK_BLOCK] RTI_ROW;             /* shares: the mirror's is its weight */
    float total[RTK_BLOCK] RTI_ROW;
    float survive[RTK_BLOCK] RTI_ROW, pick[RTK_BLOCK] RTI_ROW;
    uint32_t seed[RTK_BLOCK] RTI_ROW, place[RTK_BLOCK] RTI_ROW;
    uint32_t goes[RTK_BLOCK] RTI_ROW;
    uint32_t ends; /* no ray goes on: they are as deep as rays go */
} lobes;

RTI_LANES_FN static void find_lobes(const rti_sheaf *c, const rti_looks *l, const rti_bent *b, lobes *s)
{
    RTI_EACH_LANE(k)
    {
        rtk_vec3 d = rtk_scale(rtk_v3(c->cr[k], c->cg[k], c->cb[k]), l->diffusion[k]);
        s->dr[k] = d.x;
        s->dg[k] = d.y;
        s->db[k] = d.z;
        s->diffuse[k] = rtk_maxabs(d);
        s->crossing[k] = rtk_maxabs(rtk_v3(b->cr[k], b->cg[k], b->cb[k]));
        s->total[k] = s->diffuse[k] + b->mirror[k] + s->crossing[k];
        s->goes[k] = s->total[k] > 0.0f;
    }
}

/* Where nothing is transparent. */
static void bend_none(const rti_looks *l, rti_bent *b)
{
    memset(b->cr, 0, sizeof b->cr);
    memset(b->cg, 0, sizeof b->cg);
    memset(b->cb, 0, sizeof b->cb);
    memset(b->through, 0, sizeof b->through);
    memcpy(b->mirror, l->reflectiveness, sizeof b->mirror);
}

RTI_LANES_FN static void note_lit(rti_worker *w, const rti_sheaf *c, const rti_looks *l, const lobes *s)
{
    float *kr = rti_lit_row(w, RTI_LIT_KR), *kg = rti_lit_row(w, RTI_LIT_KG), *kb = rti_lit_row(w, RTI_LIT_KB);
    float *pdf = rti_lit_row(w, RTI_LIT_DIFFUSE_PDF);
    const uint32_t ends = s->ends;
    rti_note_seen(w, c, l);
    RTI_EACH_LANE(k)
    {
        const uint32_t goes = s->goes[k] & (ends ^ 1u);
        const float share = s->diffuse[k] / s->total[k];
        kr[k] = c->tpr[k] * s->dr[k];
        kg[k] = c->tpg[k] * s->dg[k];
        kb[k] = c->tpb[k] * s->db[k];
        pdf[k] = goes ? share : 0.0f;
    }
    if (w->frame->asks_through)
        memset(pdf, 0, RTK_BLOCK * sizeof *pdf);
    rti_note_lit(w, c);
}

/* Which rays go on, and by which number they choose how. */
RTI_LANES_FN static void draw(const rti_worker *w, const rti_sheaf *c, const rti_leaving *from, lobes *s)
{
    const uint32_t of_frame = w->frame->seed;
    uint32_t several = 0;
    RTI_EACH_LANE(k)
    {
        rtk_key key = {from->key_lo[k], from->key_hi[k]};
        s->seed[k] = rtk_vertex_seed(of_frame, from->pixel[k], key);
        s->place[k] = rtk_shuffled(s->seed[k], from->sample[k], RTK_DIM_LOBE);
        s->survive[k] = 1.0f;
        s->pick[k] = 0.0f;
        several |= s->diffuse[k] < s->total[k];
    }
    if (c->depth + 1 >= w->frame->set.roulette_from) {
        RTI_EACH_LANE(k)
        {
            const float least = rtk_maxabs(rtk_v3(c->tpr[k], c->tpg[k], c->tpb[k])) * s->total[k];
            s->survive[k] = rtk_clamp(least, RTI_SURVIVE_MIN, RTI_SURVIVE_MAX);
            s->goes[k] &= rtk_unit_float(rtk_scrambled(s->seed[k], s->place[k], RTK_DIM_ROULETTE)) < s->survive[k];
        }
    }
    if (several) {
        RTI_EACH_LANE(k)
        {
            const float pick = rtk_unit_float(rtk_scrambled(s->seed[k], s->place[k], RTK_DIM_LOBE));
            s->pick[k] = s->diffuse[k] < s->total[k] ? pick : 0.0f;
        }
    }
}

/* Directions of the diffuse lobe. */
RTI_LANES_FN static void scatter(const rti_sheaf *c, const lobes *s, rti_leaving *to)
{
    float x[RTK_BLOCK] RTI_ROW, y[RTK_BLOCK] RTI_ROW;
    uint32_t plain[RTK_BLOCK] RTI_ROW, rare;
    RTI_EACH_LANE(k)
    { /* rtk_random2_at */
        x[k] = rtk_unit_float(rtk_scrambled(s->seed[k], s->place[k], RTK_DIM_BSDF_U));
        y[k] = rtk_unit_float(rtk_scrambled(s->seed[k], s->place[k], RTK_DIM_BSDF_V));
    }
    RTI_EACH_LANE(k)
    {
        rtk_vec3 dir;
        rtk_uv u = {x[k], y[k]};
        plain[k] = (uint32_t)rtk_cosine_direction_plain(rtk_v3(c->nx[k], c->ny[k], c->nz[k]), u, &dir);
        to->dx[k] = dir.x;
        to->dy[k] = dir.y;
        to->dz[k] = dir.z;
    }
    for (rare = rti_u32_unlike(plain, 1); rare != 0; rare &= rare - 1) {
        const uint32_t k = (uint32_t)__builtin_ctz(rare);
        rtk_uv u = {x[k], y[k]};
        rtk_vec3 dir = rtk_cosine_direction(rtk_v3(c->nx[k], c->ny[k], c->nz[k]), u);
        to->dx[k] = dir.x;
        to->dy[k] = dir.y;
        to->dz[k] = dir.z;
    }
}

RTI_LANES_FN static void send_diffuse(rti_worker *w, const rti_sheaf *c, const lobes *s, const uint32_t *goes, rti_leaving *to)
{
    const bool asks_through = w->frame->asks_through;
    uint32_t up[RTK_BLOCK] RTI_ROW;
    scatter(c, s, to);
    rti_leaving_start(c, to);
    RTI_EACH_LANE(k)
    {
        rtk_vec3 dir = rtk_v3(to->dx[k], to->dy[k], to->dz[k]), ng = rtk_v3(c->gx[k], c->gy[k], c->gz[k]);
        const float probability = s->diffuse[k] / s->total[k];
        const float cosine = rtk_dot3(dir, rtk_v3(c->nx[k], c->ny[k], c->nz[k]));
        rtk_vec3 tp = rtk_scale(rtk_v3(c->tpr[k], c->tpg[k], c->tpb[k]), 1.0f / s->survive[k]);
        tp = rtk_mul(tp, rtk_scale(rtk_v3(s->dr[k], s->dg[k], s->db[k]), 1.0f / probability));
        up[k] = goes[k] & (uint32_t)((cosine > 0.0f) & (rtk_dot3(dir, ng) > 0.0f));
        to->tr[k] = tp.x;
        to->tg[k] = tp.y;
        to->tb[k] = tp.z;
        to->spread[k] = rtk_max(c->spread[k], RTK_DIFFUSE_SPREAD);
        to->pdf[k] = asks_through ? 0.0f : probability * rtk_cosine_pdf(cosine);
    }
    rti_leaving_keys(to, RTK_KIND_DIFFUSE);
    rti_push_lanes(w, c, to, RTK_KIND_DIFFUSE, RT_MASK_DIFFUSE, rti_lanes_of(up, c->count));
}

/* The pdf of refracted rays: 0, so that they meet no light, where a diffuse ray's light has come straight through, too. */
static void bent_pdf(const rti_worker *w, const rti_sheaf *c, float *pdf)
{
    const bool shadows = w->frame->set.desc.shadows;
    for (uint32_t k = 0; k < RTK_BLOCK; k++)
        pdf[k] = -1.0f;
    for (uint32_t k = 0; w->frame->asks_through && k < c->count; k++) {
        const float before = w->batch.path[c->ray[k] / RTK_BLOCK].pdf[c->ray[k] % RTK_BLOCK];
        const bool stops = shadows && w->frame->scene->materials[c->material[k]].flags & RTK_MAT_OPAQUE_SHADOW;
        pdf[k] = before < 0.0f || stops ? -1.0f : 0.0f;
    }
}

/* Rays of the mirror, or of refraction where b says so: what they keep is (r, g, b)[k] * total / share. */
RTI_LANES_FN static void send_other(rti_worker *w, const rti_sheaf *c, const rti_looks *l, const rti_bent *b, const lobes *s,
                                    const uint32_t *goes, rti_leaving *to, bool through)
{
    RTI_EACH_LANE(k)
    {
        rtk_vec3 tp = rtk_scale(rtk_v3(c->tpr[k], c->tpg[k], c->tpb[k]), 1.0f / s->survive[k]);
        rtk_vec3 mirrored = rtk_scale(tp, b->mirror[k] * s->total[k] / b->mirror[k]);
        rtk_vec3 crossed = rtk_mul(tp, rtk_scale(rtk_v3(b->cr[k], b->cg[k], b->cb[k]), s->total[k] / s->crossing[k]));
        to->tr[k] = through ? crossed.x : mirrored.x;
        to->tg[k] = through ? crossed.y : mirrored.y;
        to->tb[k] = through ? crossed.z : mirrored.z;
    }
    if (through) {
        bent_pdf(w, c, to->pdf);
        rti_push_refracted(w, c, l, b, to, rti_lanes_of(goes, c->count));
    } else {
        rti_push_mirrors(w, c, to, rti_lanes_of(goes, c->count));
    }
}

/* One ray at most leaves each lane: the lobe that its number falls into. */
RTI_LANES_FN static void go_on(rti_worker *w, const rti_sheaf *c, const rti_looks *l, const rti_bent *b, lobes *s)
{
    uint32_t diffuse[RTK_BLOCK] RTI_ROW, mirror[RTK_BLOCK] RTI_ROW, crossing[RTK_BLOCK] RTI_ROW;
    rti_leaving from, to;
    rti_leaving_of(w, c, &from);
    draw(w, c, &from, s);
    RTI_EACH_LANE(k)
    {
        const float at = s->pick[k] * s->total[k];
        const uint32_t first = at < s->diffuse[k], second = at < s->diffuse[k] + b->mirror[k];
        diffuse[k] = s->goes[k] & first;
        mirror[k] = s->goes[k] & (first ^ 1u) & second;
        crossing[k] = s->goes[k] & (first ^ 1u) & (second ^ 1u);
    }
    if (rti_u32_unlike(diffuse, 0) != 0) {
        to = from;
        send_diffuse(w, c, s, diffuse, &to);
    }
    if (rti_u32_unlike(mirror, 0) != 0) {
        to = from;
        send_other(w, c, l, b, s, mirror, &to, false);
    }
    if (rti_u32_unlike(crossing, 0) != 0)
        send_other(w, c, l, b, s, crossing, &from, true);
}

/* Weight of meeting a light's body by chance: as a diffuse ray of that pdf which started at org (0: asking alone counts);
 * pdf < 0: as another. */
static float meeting_weight(const rti_frame *f, uint32_t geom, uint32_t inst, rtk_vec3 org, float pdf)
{
    const uint32_t light = f->light_of_geom && inst == RTK_INVALID ? f->light_of_geom[geom] : RTK_INVALID;
    if (light == RTK_INVALID || pdf < 0.0f)
        return 1.0f;
    return pdf > 0.0f ? rtk_light_meeting(&f->scene->lights[light], org, pdf) : 0.0f;
}

/* What shines is met: few rays do. */
static void meet(rti_worker *w, const rti_sheaf *c)
{
    for (uint32_t k = 0; k < c->count; k++) {
        const float pdf = w->batch.path[c->ray[k] / RTK_BLOCK].pdf[c->ray[k] % RTK_BLOCK];
        const float weight = meeting_weight(w->frame, c->geom[k], c->inst[k], rti_batch_ray(w, c->ray[k]).org, pdf);
        const rtk_vec3 e = rti_emission(&w->frame->scene->materials[c->material[k]]);
        rti_add(w, c->home[k], rtk_mul(rtk_v3(c->tpr[k], c->tpg[k], c->tpb[k]), rtk_scale(e, weight)));
    }
}

void RTI_ISA_FN(rti_lanes_path)(rti_worker *w, rti_sheaf *c)
{
    const rti_looks *l = &c->looks;
    rti_bent b;
    lobes s;
    if (c->material_kind == RTI_LOOK_EMISSIVE) {
        meet(w, c);
        return;
    }
    rti_load_looks(w->frame->scene, c);
    if (l->clear)
        rti_bend_lanes(c, l, &b);
    else
        bend_none(l, &b);
    find_lobes(c, l, &b, &s);
    s.ends = c->depth >= w->frame->set.desc.max_depth;
    note_lit(w, c, l, &s);
    if (!s.ends)
        go_on(w, c, l, &b, &s);
}
