/* Lit points and the light of each, in lanes: one that its number chooses by power (path), or a spherical one that all ask, at
 * several points of it (whitted). What they bring goes by the kinds of the lanes' lights, one after the other. */
#include "../kernel/lights.h"
#include "direct.h"
#include "lanes.h"
#include "lanes_film.h"
#include "lanes_random.h"
#include "lanes_shadow.h"
#include "lanes_table.h"

#define LIT(row)  rti_lit_from(w, RTI_LIT_##row, at)
#define NORMAL(i) rti_lit_normal(w, i, at)

/* Each lane's light, and where on it. */
typedef struct lamps {
    float at[3][RTK_BLOCK] RTI_ROW, radius[RTK_BLOCK] RTI_ROW;
    float color[3][RTK_BLOCK] RTI_ROW, falloff[RTK_BLOCK] RTI_ROW;
    float body_at[3][RTK_BLOCK] RTI_ROW, body_radius[RTK_BLOCK] RTI_ROW;
    float select_pdf[RTK_BLOCK] RTI_ROW;
    uint32_t is_met[RTK_BLOCK] RTI_ROW, index[RTK_BLOCK] RTI_ROW;
    float u[RTK_BLOCK] RTI_ROW, v[RTK_BLOCK] RTI_ROW;
    uint32_t kinds[3]; /* lanes of each RTK_LIGHT_* */
    uint32_t common;   /* the light of all, or RTI_LIGHT_MIXED */
} lamps;

/* What comes from there: rtk_light_sample. */
typedef struct samples {
    float dx[RTK_BLOCK] RTI_ROW, dy[RTK_BLOCK] RTI_ROW, dz[RTK_BLOCK] RTI_ROW, distance[RTK_BLOCK] RTI_ROW;
    float er[RTK_BLOCK] RTI_ROW, eg[RTK_BLOCK] RTI_ROW, eb[RTK_BLOCK] RTI_ROW, pdf[RTK_BLOCK] RTI_ROW;
} samples;

/* The lamps index[] names: records that lie here and there, lane after lane. */
static void load_lamps(const rtk_light *lights, lamps *a)
{
    memset(a->kinds, 0, sizeof a->kinds);
    for (uint32_t k = 0; k < RTK_BLOCK; k++) {
        const rtk_light *l = &lights[a->index[k]];
        for (uint32_t i = 0; i < 3; i++) {
            a->at[i][k] = l->at[i];
            a->color[i][k] = l->color[i];
            a->body_at[i][k] = l->body_at[i];
        }
        a->radius[k] = l->radius;
        a->falloff[k] = l->falloff;
        a->body_radius[k] = l->body_radius;
        a->select_pdf[k] = l->select_pdf;
        a->is_met[k] = (uint32_t)rtk_light_is_met(l);
        a->kinds[l->type] |= 1u << k;
    }
    a->common = rti_u32_unlike(a->index, a->index[0]) == 0 ? a->index[0] : RTI_LIGHT_MIXED;
}

/* Lane k's light as far as it is asked for where it is and how bright. */
static inline rtk_light lamp_at(const lamps *a, uint32_t k)
{
    rtk_light l;
    for (uint32_t i = 0; i < 3; i++) {
        l.at[i] = a->at[i][k];
        l.color[i] = a->color[i][k];
        l.body_at[i] = a->body_at[i][k];
    }
    l.radius = a->radius[k];
    l.falloff = a->falloff[k];
    l.body_radius = a->body_radius[k];
    return l;
}

static inline void keep_sample(samples *s, uint32_t k, rtk_light_sample from)
{
    s->dx[k] = from.dir.x;
    s->dy[k] = from.dir.y;
    s->dz[k] = from.dir.z;
    s->distance[k] = from.distance;
    s->er[k] = from.e.x;
    s->eg[k] = from.e.y;
    s->eb[k] = from.e.z;
    s->pdf[k] = from.pdf;
}

RTI_LANES_FN static void towards_points(const rti_worker *w, uint32_t at, const lamps *a, samples *s)
{
    const float *px = LIT(PX), *py = LIT(PY), *pz = LIT(PZ);
    RTI_EACH_LANE(k)
    {
        const rtk_light l = lamp_at(a, k);
        keep_sample(s, k, rtk_light_point(&l, rtk_v3(px[k], py[k], pz[k])));
    }
}

RTI_LANES_FN static void towards_suns(const lamps *a, samples *s)
{
    RTI_EACH_LANE(k)
    {
        const rtk_light l = lamp_at(a, k);
        keep_sample(s, k, rtk_light_directional(&l));
    }
}

RTI_LANES_FN static void towards_spheres(const rti_worker *w, uint32_t at, const lamps *a, samples *s)
{
    const float *px = LIT(PX), *py = LIT(PY), *pz = LIT(PZ);
    uint32_t plain[RTK_BLOCK] RTI_ROW, rare;
    RTI_EACH_LANE(k)
    {
        const rtk_light l = lamp_at(a, k);
        rtk_light_sample from;
        plain[k] = (uint32_t)rtk_light_sphere_plain(&l, rtk_v3(px[k], py[k], pz[k]), a->u[k], a->v[k], &from);
        keep_sample(s, k, from);
    }
    for (rare = rti_u32_unlike(plain, 1); rare != 0; rare &= rare - 1) {
        const uint32_t k = (uint32_t)__builtin_ctz(rare);
        const rtk_light l = lamp_at(a, k);
        keep_sample(s, k, rtk_light_sphere(&l, rtk_v3(px[k], py[k], pz[k]), a->u[k], a->v[k]));
    }
}

/* Their shadow rays, and which go. `type` is a constant of the caller. */
static inline void aim(const rti_worker *w, uint32_t at, uint32_t type, const lamps *a, const samples *from, rti_shadow_lanes *s)
{
    const float *px = LIT(PX), *py = LIT(PY), *pz = LIT(PZ), *error = LIT(ERROR);
    const float *nx = NORMAL(0), *ny = NORMAL(1), *nz = NORMAL(2), *gx = LIT(GX), *gy = LIT(GY), *gz = LIT(GZ);
    RTI_EACH_LANE(k)
    {
        const rtk_light l = lamp_at(a, k);
        rtk_vec3 p = rtk_v3(px[k], py[k], pz[k]), g = rtk_v3(gx[k], gy[k], gz[k]),
                 dir = rtk_v3(from->dx[k], from->dy[k], from->dz[k]);
        rtk_vec3 org = rtk_madd(p, 2.0f * error[k], g);
        rtk_light_sample toward = {.dir = dir, .distance = from->distance[k]};
        float cosine = rtk_dot3(rtk_v3(nx[k], ny[k], nz[k]), dir), reach = rtk_light_reach_body(&l, p, toward);
        reach = l.body_radius > 0.0f ? reach : from->distance[k];
        s->goes[k] = (uint32_t)((cosine > 0.0f) & (rtk_dot3(g, dir) > 0.0f));
        s->ox[k] = org.x;
        s->oy[k] = org.y;
        s->oz[k] = org.z;
        s->dx[k] = dir.x;
        s->dy[k] = dir.y;
        s->dz[k] = dir.z;
        s->tmax[k] = type == RTK_LIGHT_DIRECTIONAL ? RTK_INF : rtk_light_end_at(&l, p, error[k], reach);
        s->cosine[k] = cosine;
        s->er[k] = from->er[k];
        s->eg[k] = from->eg[k];
        s->eb[k] = from->eb[k];
    }
}

RTI_LANES_FN static void aim_near(const rti_worker *w, uint32_t at, const lamps *a, const samples *from, rti_shadow_lanes *s)
{
    aim(w, at, RTK_LIGHT_POINT, a, from, s);
}

RTI_LANES_FN static void aim_far(const rti_worker *w, uint32_t at, const lamps *a, const samples *from, rti_shadow_lanes *s)
{
    aim(w, at, RTK_LIGHT_DIRECTIONAL, a, from, s);
}

RTI_LANES_FN static void weigh(const rti_worker *w, uint32_t at, const float *share, const float *scale, rti_shadow_lanes *s)
{
    rti_weigh_lanes(w, at, true, share, scale, s);
}

/* Rays of the lanes whose lights are of a type go. share, scale: weights of the Lambert part, and of all. */
static void send_type(rti_worker *w, uint32_t at, uint32_t type, uint32_t lanes, const lamps *a, const samples *from,
                      const float *share, const float *scale)
{
    rti_shadow_lanes s;
    if (type == RTK_LIGHT_DIRECTIONAL)
        aim_far(w, at, a, from, &s);
    else
        aim_near(w, at, a, from, &s);
    weigh(w, at, share, scale, &s);
    lanes &= rti_lanes_of(s.goes, RTK_BLOCK);
    if (w->frame->set.desc.shadows)
        rti_queue_lanes(w, a->common, a->index, at, lanes, &s);
    else
        rti_add_lanes(w, w->lit_home + at, lanes, &s.c);
}

/* ---- one light a point ---- */

/* Numbers of a light's choice, and of places on it. */
RTI_LANES_FN static void pick_lights(const uint32_t *seed, const uint32_t *sample, float *pick)
{
    RTI_EACH_LANE(k)
    {
        uint32_t place = rtk_shuffled(seed[k], sample[k], RTK_DIM_LIGHT_CHOICE);
        pick[k] = rtk_unit_float(rtk_scrambled(seed[k], place, RTK_DIM_LIGHT_CHOICE));
    }
}

RTI_LANES_FN static void seed_places(const uint32_t *seed, rti_pair_seeds *pairs)
{
    rti_seed_pairs(seed, RTK_DIM_LIGHT_U, pairs);
}

/* Number `from` + j of each lane. */
RTI_LANES_FN static void pick_places(const rti_pair_seeds *pairs, const uint32_t *from, uint32_t j, lamps *a)
{
    rti_draw_pairs(pairs, RTK_DIM_LIGHT_U, from, j, a->u, a->v);
}

/* Chooses each lane's light, where there are several, and where on it. What is not asked of random numbers is not made. */
static void choose(const rti_worker *w, uint32_t at, uint32_t n, lamps *a)
{
    const rtk_scene *scene = w->frame->scene;
    const bool several = scene->light_count > 1;
    uint32_t seed[RTK_BLOCK] RTI_ROW, sample[RTK_BLOCK] RTI_ROW;
    float pick[RTK_BLOCK] RTI_ROW;
    rti_pair_seeds pairs;
    if (!several && a->kinds[RTK_LIGHT_SPHERE] == 0)
        return;
    rti_draw_lit(w, at, n, seed, sample);
    if (several) {
        pick_lights(seed, sample, pick);
        for (uint32_t k = 0; k < RTK_BLOCK; k++)
            a->index[k] = rtk_light_choose(scene->lights, scene->light_count, pick[k]);
        load_lamps(scene->lights, a);
    }
    if (a->kinds[RTK_LIGHT_SPHERE] != 0) {
        seed_places(seed, &pairs);
        pick_places(&pairs, sample, 0, a);
    }
}

/* share, scale: as send_type says. Returns the lanes whose lights can be chosen at all. */
RTI_LANES_FN static uint32_t weigh_choice(const rti_worker *w, uint32_t at, const lamps *a, const samples *s, float *share,
                                          float *scale)
{
    const float *nx = NORMAL(0), *ny = NORMAL(1), *nz = NORMAL(2), *pdf = LIT(DIFFUSE_PDF);
    uint32_t some[RTK_BLOCK] RTI_ROW;
    RTI_EACH_LANE(k)
    {
        const float cosine = rtk_dot3(rtk_v3(nx[k], ny[k], nz[k]), rtk_v3(s->dx[k], s->dy[k], s->dz[k]));
        const float asking = rtk_light_asking(a->select_pdf[k], s->pdf[k], cosine, pdf[k]);
        share[k] = a->is_met[k] ? asking : 1.0f;
        scale[k] = 1.0f / a->select_pdf[k];
        some[k] = a->select_pdf[k] > 0.0f;
    }
    return rti_lanes_of(some, RTK_BLOCK);
}

void RTI_ISA_FN(rti_lanes_one)(rti_worker *w)
{
    const rtk_scene *scene = w->frame->scene;
    float share[RTK_BLOCK] RTI_ROW, scale[RTK_BLOCK] RTI_ROW;
    lamps a;
    samples s;
    if (scene->light_count == 0)
        return;
    memset(a.index, 0, sizeof a.index);
    load_lamps(scene->lights, &a);
    for (uint32_t at = 0; at < w->lit_count && !rti_cancelled(w->frame->cancel); at += RTK_BLOCK) {
        const uint32_t n = w->lit_count - at < RTK_BLOCK ? w->lit_count - at : RTK_BLOCK, there = (1u << n) - 1;
        choose(w, at, n, &a);
        for (uint32_t type = RTK_LIGHT_POINT; type <= RTK_LIGHT_DIRECTIONAL; type++) {
            uint32_t lanes = a.kinds[type] & there;
            if (lanes == 0)
                continue;
            if (type == RTK_LIGHT_POINT)
                towards_points(w, at, &a, &s);
            else if (type == RTK_LIGHT_SPHERE)
                towards_spheres(w, at, &a, &s);
            else
                towards_suns(&a, &s);
            lanes &= weigh_choice(w, at, &a, &s, share, scale);
            send_type(w, at, type, lanes, &a, &s, share, scale);
        }
    }
}

/* ---- a spherical light ---- */

/* Points in which some of the light is above the surface. */
RTI_LANES_FN static uint32_t in_front(const rti_worker *w, uint32_t at, const lamps *a)
{
    const float *px = LIT(PX), *py = LIT(PY), *pz = LIT(PZ);
    const float *nx = NORMAL(0), *ny = NORMAL(1), *nz = NORMAL(2), *gx = LIT(GX), *gy = LIT(GY), *gz = LIT(GZ);
    uint32_t some[RTK_BLOCK] RTI_ROW;
    RTI_EACH_LANE(k)
    {
        const rtk_light l = lamp_at(a, k);
        rtk_vec3 p = rtk_v3(px[k], py[k], pz[k]);
        int seen = !rtk_light_behind_flat(&l, RTK_LIGHT_SPHERE, p, rtk_v3(nx[k], ny[k], nz[k]));
        int above = !rtk_light_behind_flat(&l, RTK_LIGHT_SPHERE, p, rtk_v3(gx[k], gy[k], gz[k]));
        some[k] = (uint32_t)(seen & above);
    }
    return rti_lanes_of(some, RTK_BLOCK);
}

/* The same light for all lanes, and weights. */
RTI_LANES_FN static void same_lamp(uint32_t index, float weight, lamps *a, float *share, float *scale)
{
    RTI_EACH_LANE(k)
    {
        a->index[k] = index;
        share[k] = 1.0f;
        scale[k] = weight;
    }
}

/* Each light has numbers of its own. */
RTI_LANES_FN static void own_numbers(uint32_t index, uint32_t each, uint32_t *seed, uint32_t *sample)
{
    RTI_EACH_LANE(k)
    {
        seed[k] = rtk_hash2(seed[k], index);
        sample[k] *= each;
    }
}

void RTI_ISA_FN(rti_lanes_shine_sphere)(rti_worker *w, uint32_t index)
{
    const rtk_light *light = &w->frame->scene->lights[index];
    const uint32_t each = rti_frame_light_samples(w->frame, light);
    uint32_t seed[RTK_BLOCK] RTI_ROW, sample[RTK_BLOCK] RTI_ROW;
    float share[RTK_BLOCK] RTI_ROW, scale[RTK_BLOCK] RTI_ROW;
    rti_pair_seeds pairs;
    lamps a;
    samples s;
    same_lamp(index, 1.0f / (float)each, &a, share, scale);
    load_lamps(w->frame->scene->lights, &a);
    for (uint32_t at = 0; at < w->lit_count && !rti_cancelled(w->frame->cancel); at += RTK_BLOCK) {
        const uint32_t n = w->lit_count - at < RTK_BLOCK ? w->lit_count - at : RTK_BLOCK;
        const uint32_t lanes = in_front(w, at, &a) & ((1u << n) - 1);
        if (lanes == 0)
            continue;
        rti_draw_lit(w, at, n, seed, sample);
        own_numbers(index, each, seed, sample);
        seed_places(seed, &pairs);
        for (uint32_t j = 0; j < each; j++) {
            pick_places(&pairs, sample, j, &a);
            towards_spheres(w, at, &a, &s);
            send_type(w, at, RTK_LIGHT_SPHERE, lanes, &a, &s, share, scale);
        }
    }
}
