/* Points that ask all around them how open it is there, in lanes. */
#include "../kernel/sampling.h"
#include "lanes.h"
#include "lanes_random.h"
#include "lanes_shadow.h"
#include "lanes_table.h"

#define LIT(row)  rti_lit_from(w, RTI_LIT_##row, at)
#define NORMAL(i) rti_lit_normal(w, i, at)

/* Points of camera rays, behind those that are noted: each shows its throughput where it is open. */
void RTI_ISA_FN(rti_lanes_ao)(rti_worker *w, rti_sheaf *c)
{
    memcpy(rti_lit_row(w, RTI_LIT_KR), c->tpr, sizeof c->tpr);
    memcpy(rti_lit_row(w, RTI_LIT_KG), c->tpg, sizeof c->tpg);
    memcpy(rti_lit_row(w, RTI_LIT_KB), c->tpb, sizeof c->tpb);
    rti_note_points(w, c);
    w->lit_count += c->count;
}

/* Where the rays start, how far they look and what each brings. */
RTI_LANES_FN static void leave(const rti_worker *w, uint32_t at, float share, rti_shadow_lanes *s)
{
    const float *px = LIT(PX), *py = LIT(PY), *pz = LIT(PZ), *error = LIT(ERROR), *gx = LIT(GX), *gy = LIT(GY), *gz = LIT(GZ);
    const float *kr = LIT(KR), *kg = LIT(KG), *kb = LIT(KB), far = w->frame->ao_distance;
    RTI_EACH_LANE(k)
    {
        rtk_vec3 org = rtk_madd(rtk_v3(px[k], py[k], pz[k]), 2.0f * error[k], rtk_v3(gx[k], gy[k], gz[k]));
        s->ox[k] = org.x;
        s->oy[k] = org.y;
        s->oz[k] = org.z;
        s->tmax[k] = far;
        s->c.r[k] = kr[k] * share;
        s->c.g[k] = kg[k] * share;
        s->c.b[k] = kb[k] * share;
    }
}

RTI_LANES_FN static void seed_pairs(const uint32_t *seed, rti_pair_seeds *pairs)
{
    rti_seed_pairs(seed, RTK_DIM_AO_U, pairs);
}

/* Their directions: those of numbers first[k] + j. */
RTI_LANES_FN static void spread(const rti_worker *w, uint32_t at, const rti_pair_seeds *pairs, const uint32_t *first, uint32_t j,
                                rti_shadow_lanes *s)
{
    const float *nx = NORMAL(0), *ny = NORMAL(1), *nz = NORMAL(2), *gx = LIT(GX), *gy = LIT(GY), *gz = LIT(GZ);
    float x[RTK_BLOCK] RTI_ROW, y[RTK_BLOCK] RTI_ROW;
    uint32_t plain[RTK_BLOCK] RTI_ROW, rare;
    rti_draw_pairs(pairs, RTK_DIM_AO_U, first, j, x, y);
    RTI_EACH_LANE(k)
    {
        rtk_vec3 dir;
        rtk_uv u = {x[k], y[k]};
        plain[k] = (uint32_t)rtk_cosine_direction_plain(rtk_v3(nx[k], ny[k], nz[k]), u, &dir);
        s->dx[k] = dir.x;
        s->dy[k] = dir.y;
        s->dz[k] = dir.z;
    }
    for (rare = rti_u32_unlike(plain, 1); rare != 0; rare &= rare - 1) {
        const uint32_t k = (uint32_t)__builtin_ctz(rare);
        rtk_uv u = {x[k], y[k]};
        rtk_vec3 dir = rtk_cosine_direction(rtk_v3(nx[k], ny[k], nz[k]), u);
        s->dx[k] = dir.x;
        s->dy[k] = dir.y;
        s->dz[k] = dir.z;
    }
    RTI_EACH_LANE(k)
    s->goes[k] = rtk_dot3(rtk_v3(s->dx[k], s->dy[k], s->dz[k]), rtk_v3(gx[k], gy[k], gz[k])) > 0.0f;
}

void RTI_ISA_FN(rti_lanes_around)(rti_worker *w)
{
    const uint32_t each = w->frame->set.desc.ao_samples;
    uint32_t seed[RTK_BLOCK] RTI_ROW, first[RTK_BLOCK] RTI_ROW;
    rti_pair_seeds pairs;
    rti_shadow_lanes s;
    for (uint32_t at = 0; at < w->lit_count && !rti_cancelled(w->frame->cancel); at += RTK_BLOCK) {
        const uint32_t n = w->lit_count - at < RTK_BLOCK ? w->lit_count - at : RTK_BLOCK;
        rti_draw_lit(w, at, n, seed, first);
        RTI_EACH_LANE_INNER(k)
        first[k] *= each;
        seed_pairs(seed, &pairs);
        leave(w, at, 1.0f / (float)each, &s);
        for (uint32_t j = 0; j < each; j++) {
            spread(w, at, &pairs, first, j, &s);
            rti_queue_lanes(w, RTI_LIGHT_MIXED, NULL, at, rti_lanes_of(s.goes, n), &s);
        }
    }
}
