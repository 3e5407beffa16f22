/* Lit points and one light, in lanes: what the light brings to each and the ray that asks whether it arrives; and the light of
 * the rays that did. */
#include "../kernel/classic.h"
#include "../kernel/lights.h"
#include "direct.h"
#include "lanes.h"
#include "lanes_rows.h"
#include "lanes_table.h"

/* Sixteen shadow rays and what they bring. */
typedef struct rays {
    float ox[RTK_BLOCK] RTI_ROW, oy[RTK_BLOCK] RTI_ROW, oz[RTK_BLOCK] RTI_ROW;
    float dx[RTK_BLOCK] RTI_ROW, dy[RTK_BLOCK] RTI_ROW, dz[RTK_BLOCK] RTI_ROW;
    float tmax[RTK_BLOCK] RTI_ROW;
    float cosine[RTK_BLOCK] RTI_ROW;
    float er[RTK_BLOCK] RTI_ROW, eg[RTK_BLOCK] RTI_ROW, eb[RTK_BLOCK] RTI_ROW;
    rti_light_lanes c;
    uint32_t goes[RTK_BLOCK] RTI_ROW;
} rays;

#define LIT(row) (w->lit + (size_t)RTI_LIT_##row * w->lit_stride + at)

/* `type` is a constant of the caller: no lane asks for it. */
static inline void towards(const rti_worker *w, const rtk_light *light, uint32_t type, uint32_t at, rays *s)
{
    const rtk_light l = *light;
    const float *px = LIT(PX), *py = LIT(PY), *pz = LIT(PZ), *error = LIT(ERROR);
    const float *nx = LIT(NX), *ny = LIT(NY), *nz = LIT(NZ), *gx = LIT(GX), *gy = LIT(GY), *gz = LIT(GZ);
    RTI_EACH_LANE(k)
    {
        rtk_vec3 p = rtk_v3(px[k], py[k], pz[k]), n = rtk_v3(nx[k], ny[k], nz[k]), g = rtk_v3(gx[k], gy[k], gz[k]), org;
        rtk_light_sample toward = type == RTK_LIGHT_POINT ? rtk_light_point(&l, p) : rtk_light_directional(&l);
        float cosine = rtk_dot3(n, toward.dir);
        float reach = l.body_radius > 0.0f ? rtk_light_reach_body(&l, p, toward) : toward.distance;
        int seen = !rtk_light_behind_flat(&l, type, p, n), above = !rtk_light_behind_flat(&l, type, p, g);
        int front = cosine > 0.0f, over = rtk_dot3(g, toward.dir) > 0.0f;
        s->goes[k] = (uint32_t)(seen & above & front & over);
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

RTI_LANES_FN static void towards_point(const rti_worker *w, const rtk_light *light, uint32_t at, rays *s)
{
    towards(w, light, RTK_LIGHT_POINT, at, s);
}

RTI_LANES_FN static void towards_sun(const rti_worker *w, const rtk_light *light, uint32_t at, rays *s)
{
    towards(w, light, RTK_LIGHT_DIRECTIONAL, at, s);
}

/* What it brings where nothing is between; a lane to which it brings nothing does not go. */
RTI_LANES_FN static void weigh(const rti_worker *w, uint32_t at, rays *s)
{
    const float *kr = LIT(KR), *kg = LIT(KG), *kb = LIT(KB), *sr = LIT(SR), *sg = LIT(SG), *sb = LIT(SB);
    float shine[RTK_BLOCK] RTI_ROW;
    uint32_t any = 0;
    RTI_EACH_LANE(k)
    {
        uint32_t glossy = (uint32_t)(rtk_maxabs(rtk_v3(sr[k], sg[k], sb[k])) > 0.0f);
        shine[k] = 0.0f;
        any |= glossy & s->goes[k];
    }
    if (any) {
        const float *nx = LIT(NX), *ny = LIT(NY), *nz = LIT(NZ), *vx = LIT(VX), *vy = LIT(VY), *vz = LIT(VZ),
                    *power = LIT(SHININESS);
        for (uint32_t k = 0; k < RTK_BLOCK; k++)
            if (s->goes[k] && rtk_maxabs(rtk_v3(sr[k], sg[k], sb[k])) > 0.0f)
                shine[k] = rtk_highlight(power[k], rtk_v3(nx[k], ny[k], nz[k]), rtk_v3(s->dx[k], s->dy[k], s->dz[k]),
                                         rtk_v3(vx[k], vy[k], vz[k]));
    }
    RTI_EACH_LANE(k)
    {
        rtk_vec3 c = rtk_v3(kr[k], kg[k], kb[k]), spec = rtk_v3(sr[k], sg[k], sb[k]), add = rtk_madd(c, shine[k], spec);
        int glossy = rtk_maxabs(spec) > 0.0f;
        c = rtk_v3(glossy ? add.x : c.x, glossy ? add.y : c.y, glossy ? add.z : c.z);
        c = rtk_mul(c, rtk_scale(rtk_v3(s->er[k], s->eg[k], s->eb[k]), s->cosine[k]));
        s->c.r[k] = c.x;
        s->c.g[k] = c.y;
        s->c.b[k] = c.z;
        s->goes[k] &= (uint32_t) !(rtk_maxabs(c) == 0.0f);
    }
}

/* All sixteen, into a block of the queue as they are. */
static void queue_block(rti_worker *w, uint32_t at, const rays *s)
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

#ifdef RTI_PACK
/* Some lanes behind those that are queued, in one block or two. */
static void queue_some(rti_worker *w, uint32_t at, uint32_t lanes, const rays *s)
{
    rti_shadows *q = &w->shadows;
    while (lanes != 0) {
        const uint32_t k = q->count % RTK_BLOCK, some = rti_first(lanes, RTK_BLOCK - k);
        rtk_trace_block *t = &q->trace[q->count / RTK_BLOCK];
        rti_pending_block *p = &q->pending[q->count / RTK_BLOCK];
        rti_put_row(t->ox, k, some, s->ox);
        rti_put_row(t->oy, k, some, s->oy);
        rti_put_row(t->oz, k, some, s->oz);
        rti_put_row(t->dx, k, some, s->dx);
        rti_put_row(t->dy, k, some, s->dy);
        rti_put_row(t->dz, k, some, s->dz);
        rti_put_all(t->tmin, k, some, 0);
        rti_put_row(t->tmax, k, some, s->tmax);
        rti_put_all(t->mask, k, some, RT_MASK_SHADOW);
        rti_put_row(p->r, k, some, s->c.r);
        rti_put_row(p->g, k, some, s->c.g);
        rti_put_row(p->b, k, some, s->c.b);
        rti_put_row(p->home, k, some, w->lit_home + at);
        q->count += (uint32_t)__builtin_popcount(some);
        lanes &= ~some;
    }
}
#endif

/* Together, where there is a way; the queue has room. */
static bool queue_lanes(rti_worker *w, uint32_t at, uint32_t lanes, const rays *s)
{
    if (lanes == 0xffffu && w->shadows.count % RTK_BLOCK == 0) {
        queue_block(w, at, s);
        return true;
    }
#ifdef RTI_PACK
    queue_some(w, at, lanes, s);
    return true;
#else
    return false;
#endif
}

static void queue(rti_worker *w, uint32_t light, uint32_t at, uint32_t n, const rays *s)
{
    rti_shadows *q = &w->shadows;
    uint32_t lanes = 0;
    RTI_EACH_LANE(k)
    lanes |= s->goes[k] << k;
    lanes &= (1u << n) - 1;
    if (!w->frame->set.desc.shadows) {
        rti_add_lanes(w, w->lit_home + at, lanes, &s->c);
        return;
    }
    if (q->capacity - q->count > RTK_BLOCK && !w->frame->moving && queue_lanes(w, at, lanes, s)) {
        if (lanes != 0)
            q->light = q->light == RTK_INVALID || q->light == light ? light : RTI_LIGHT_MIXED;
        return;
    }
    for (uint32_t k = 0; k < n; k++)
        if (lanes >> k & 1u)
            rti_shadow(w, light, rtk_v3(s->ox[k], s->oy[k], s->oz[k]), rtk_v3(s->dx[k], s->dy[k], s->dz[k]), s->tmax[k],
                       rtk_v3(s->c.r[k], s->c.g[k], s->c.b[k]), w->lit_home[at + k], rti_batch_time(w, w->lit_ray[at + k]));
}

void RTI_ISA_FN(rti_lanes_shine)(rti_worker *w, uint32_t index)
{
    const rtk_light *light = &w->frame->scene->lights[index];
    rays s;
    for (uint32_t at = 0; at < w->lit_count && !rti_cancelled(w->frame->cancel); at += RTK_BLOCK) {
        uint32_t n = w->lit_count - at < RTK_BLOCK ? w->lit_count - at : RTK_BLOCK;
        if (light->type == RTK_LIGHT_POINT)
            towards_point(w, light, at, &s);
        else
            towards_sun(w, light, at, &s);
        weigh(w, at, &s);
        queue(w, index, at, n, &s);
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
