/* Lit points and one light, in lanes: what comes to each and the ray that asks whether it arrives; and the light of the rays that
 * did. */
#include "../kernel/lights.h"
#include "direct.h"
#include "lanes.h"
#include "lanes_film.h"
#include "lanes_shadow.h"
#include "lanes_table.h"

#define LIT(row) rti_lit_from(w, RTI_LIT_##row, at)

/* `type`, whether the light has a body, and whether it may fall off, are constants of the caller: no lane asks for them. */
static inline void towards(const rti_worker *w, const rtk_light *light, uint32_t type, bool body, bool falls, uint32_t at,
                           rti_shadow_lanes *s)
{
    const float *px = LIT(PX), *py = LIT(PY), *pz = LIT(PZ), *error = LIT(ERROR), *gx = LIT(GX), *gy = LIT(GY), *gz = LIT(GZ);
    rtk_light l = *light;
    if (!falls)
        l.falloff = 0.0f;
    RTI_EACH_LANE(k)
    {
        rtk_vec3 p = rtk_v3(px[k], py[k], pz[k]), g = rtk_v3(gx[k], gy[k], gz[k]), org;
        rtk_light_sample toward = type == RTK_LIGHT_POINT ? rtk_light_point(&l, p) : rtk_light_directional(&l);
        float cosine = rtk_dot3(g, toward.dir);
        float reach = body ? rtk_light_reach_body(&l, p, toward) : toward.distance;
        s->goes[k] = (uint32_t)((!rtk_light_behind_flat(&l, type, p, g)) & (cosine > 0.0f));
        org = rtk_madd(p, 2.0f * error[k], g);
        s->ox[k] = org.x;
        s->oy[k] = org.y;
        s->oz[k] = org.z;
        s->dx[k] = toward.dir.x;
        s->dy[k] = toward.dir.y;
        s->dz[k] = toward.dir.z;
        s->tmax[k] = type == RTK_LIGHT_POINT ? rtk_light_end_at(&l, p, error[k], reach) : RTK_INF;
        s->cosine[k] = cosine;
        s->er[k] = toward.e.x;
        s->eg[k] = toward.e.y;
        s->eb[k] = toward.e.z;
    }
}

/* Shading normals of their own tell the cosines, and must see the light, too. */
RTI_LANES_FN static void by_normals(const rti_worker *w, const rtk_light *light, uint32_t at, rti_shadow_lanes *s)
{
    const float *px = LIT(PX), *py = LIT(PY), *pz = LIT(PZ), *nx = LIT(NX), *ny = LIT(NY), *nz = LIT(NZ);
    const rtk_light l = *light;
    RTI_EACH_LANE(k)
    {
        const rtk_vec3 p = rtk_v3(px[k], py[k], pz[k]), n = rtk_v3(nx[k], ny[k], nz[k]);
        const float cosine = rtk_dot3(n, rtk_v3(s->dx[k], s->dy[k], s->dz[k]));
        s->goes[k] &= (uint32_t)((!rtk_light_behind_flat(&l, l.type, p, n)) & (cosine > 0.0f));
        s->cosine[k] = cosine;
    }
}

RTI_LANES_FN static void towards_point(const rti_worker *w, const rtk_light *light, uint32_t at, rti_shadow_lanes *s)
{
    towards(w, light, RTK_LIGHT_POINT, false, false, at, s);
}

RTI_LANES_FN static void towards_falling(const rti_worker *w, const rtk_light *light, uint32_t at, rti_shadow_lanes *s)
{
    towards(w, light, RTK_LIGHT_POINT, false, true, at, s);
}

RTI_LANES_FN static void towards_lamp(const rti_worker *w, const rtk_light *light, uint32_t at, rti_shadow_lanes *s)
{
    towards(w, light, RTK_LIGHT_POINT, true, true, at, s);
}

RTI_LANES_FN static void towards_sun(const rti_worker *w, const rtk_light *light, uint32_t at, rti_shadow_lanes *s)
{
    towards(w, light, RTK_LIGHT_DIRECTIONAL, false, false, at, s);
}

RTI_LANES_FN static void weigh(const rti_worker *w, uint32_t at, rti_shadow_lanes *s)
{
    rti_weigh_lanes(w, at, false, NULL, NULL, s);
}

void RTI_ISA_FN(rti_lanes_shine)(rti_worker *w, uint32_t index)
{
    const rtk_light *light = &w->frame->scene->lights[index];
    rti_shadow_lanes s;
    if (light->type == RTK_LIGHT_SPHERE) {
        RTI_ISA_FN(rti_lanes_shine_sphere)(w, index);
        return;
    }
    for (uint32_t at = 0; at < w->lit_count && !rti_cancelled(w->frame->cancel); at += RTK_BLOCK) {
        uint32_t n = w->lit_count - at < RTK_BLOCK ? w->lit_count - at : RTK_BLOCK;
        if (light->type == RTK_LIGHT_DIRECTIONAL)
            towards_sun(w, light, at, &s);
        else if (light->body_radius > 0.0f)
            towards_lamp(w, light, at, &s);
        else if (light->falloff > 0.0f)
            towards_falling(w, light, at, &s);
        else
            towards_point(w, light, at, &s);
        if (w->lit_smooth)
            by_normals(w, light, at, &s);
        weigh(w, at, &s);
        if (w->frame->set.desc.shadows)
            rti_queue_lanes(w, index, NULL, at, rti_lanes_of(s.goes, n), &s);
        else
            rti_add_lanes(w, w->lit_home + at, rti_lanes_of(s.goes, n), &s.c);
    }
}

void RTI_ISA_FN(rti_lanes_arrive)(rti_worker *w)
{
    const rti_shadows *q = &w->shadows;
    for (uint32_t i = 0; i < q->count; i += RTK_BLOCK) {
        const rti_pending_block *p = &q->pending[i / RTK_BLOCK];
        uint32_t n = q->count - i < RTK_BLOCK ? q->count - i : RTK_BLOCK;
        uint32_t free = ~(uint32_t)q->occluded[i / RTK_BLOCK] & ((1u << n) - 1);
        rti_light_lanes l;
        if (free == 0)
            continue;
        memcpy(l.r, p->r, sizeof l.r);
        memcpy(l.g, p->g, sizeof l.g);
        memcpy(l.b, p->b, sizeof l.b);
        rti_add_lanes(w, p->home, free, &l);
    }
}
