/* Lit points and one light, or what is around them, in lanes: what comes to each and the ray that asks whether it arrives; and
 * the light of the rays that did. */
#include "../kernel/classic.h"
#include "../kernel/lights.h"
#include "../kernel/sampling.h"
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

static uint32_t going(const rays *s, uint32_t n)
{
    uint32_t lanes = 0;
    RTI_EACH_LANE(k)
    lanes |= s->goes[k] << k;
    return lanes & ((1u << n) - 1);
}

/* Lanes of points [at, at + 16) ask whether anything is between. */
static void queue(rti_worker *w, uint32_t light, uint32_t at, uint32_t lanes, const rays *s)
{
    rti_shadows *q = &w->shadows;
    if (q->capacity - q->count > RTK_BLOCK && !w->frame->moving && queue_lanes(w, at, lanes, s)) {
        if (lanes != 0)
            q->light = q->light == RTK_INVALID || q->light == light ? light : RTI_LIGHT_MIXED;
        return;
    }
    for (uint32_t k = 0; k < RTK_BLOCK; k++)
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
        if (w->frame->set.desc.shadows)
            queue(w, index, at, going(&s, n), &s);
        else
            rti_add_lanes(w, w->lit_home + at, going(&s, n), &s.c);
    }
}

/* ---- all around ---- */

/* Points of camera rays, behind those that are noted: each shows its throughput where it is open. */
void RTI_ISA_FN(rti_lanes_ao)(rti_worker *w, rti_sheaf *c)
{
    const size_t stride = w->lit_stride;
    float *to = w->lit + w->lit_count;
#define NOTE(row, from) memcpy(to + RTI_LIT_##row * stride, from, RTK_BLOCK * sizeof *to)
    NOTE(KR, c->tpr);
    NOTE(KG, c->tpg);
    NOTE(KB, c->tpb);
#undef NOTE
    rti_note_points(w, c);
    w->lit_count += c->count;
}

/* What the random numbers of n points share, and the first of their rays' numbers. */
RTI_LANES_FN static void draw(const rti_worker *w, uint32_t at, uint32_t n, uint32_t rays_each, uint32_t *seed, uint32_t *first)
{
    const uint32_t of_frame = w->frame->seed;
    uint32_t pixel[RTK_BLOCK] RTI_ROW, lo[RTK_BLOCK] RTI_ROW, hi[RTK_BLOCK] RTI_ROW;
    for (uint32_t k = 0; k < RTK_BLOCK; k++) {
        const uint32_t ray = w->lit_ray[k < n ? at + k : at];
        const rtk_path_block *p = &w->batch.path[ray / RTK_BLOCK];
        pixel[k] = p->pixel[ray % RTK_BLOCK];
        lo[k] = p->key_lo[ray % RTK_BLOCK];
        hi[k] = p->key_hi[ray % RTK_BLOCK];
        first[k] = p->sample[ray % RTK_BLOCK] * rays_each;
    }
    RTI_EACH_LANE(k)
    {
        rtk_key key = {lo[k], hi[k]};
        seed[k] = rtk_vertex_seed(of_frame, pixel[k], key);
    }
}

/* Where the rays start, how far they look and what each brings. */
RTI_LANES_FN static void leave(const rti_worker *w, uint32_t at, float share, rays *s)
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

/* Their directions: those of numbers first[k] + j. */
RTI_LANES_FN static void spread(const rti_worker *w, uint32_t at, const uint32_t *seed, const uint32_t *first, uint32_t j,
                                rays *s)
{
    const float *nx = LIT(NX), *ny = LIT(NY), *nz = LIT(NZ), *gx = LIT(GX), *gy = LIT(GY), *gz = LIT(GZ);
    float x[RTK_BLOCK] RTI_ROW, y[RTK_BLOCK] RTI_ROW;
    uint32_t plain[RTK_BLOCK] RTI_ROW, rare = 0;
    RTI_EACH_LANE(k)
    { /* rtk_random2 */
        uint32_t place = rtk_shuffled(seed[k], first[k] + j, RTK_DIM_AO_U);
        x[k] = rtk_unit_float(rtk_scrambled(seed[k], place, RTK_DIM_AO_U));
        y[k] = rtk_unit_float(rtk_scrambled(seed[k], place, RTK_DIM_AO_V));
    }
    RTI_EACH_LANE(k)
    {
        rtk_vec3 dir;
        rtk_uv u = {x[k], y[k]};
        plain[k] = (uint32_t)rtk_cosine_direction_plain(rtk_v3(nx[k], ny[k], nz[k]), u, &dir);
        s->dx[k] = dir.x;
        s->dy[k] = dir.y;
        s->dz[k] = dir.z;
    }
    RTI_EACH_LANE(k)
    rare |= !plain[k];
    for (uint32_t k = 0; k < RTK_BLOCK && rare; k++) {
        if (!plain[k]) {
            rtk_uv u = {x[k], y[k]};
            rtk_vec3 dir = rtk_cosine_direction(rtk_v3(nx[k], ny[k], nz[k]), u);
            s->dx[k] = dir.x;
            s->dy[k] = dir.y;
            s->dz[k] = dir.z;
        }
    }
    RTI_EACH_LANE(k)
    s->goes[k] = rtk_dot3(rtk_v3(s->dx[k], s->dy[k], s->dz[k]), rtk_v3(gx[k], gy[k], gz[k])) > 0.0f;
}

void RTI_ISA_FN(rti_lanes_around)(rti_worker *w)
{
    const uint32_t each = w->frame->set.desc.ao_samples;
    uint32_t seed[RTK_BLOCK] RTI_ROW, first[RTK_BLOCK] RTI_ROW;
    rays s;
    for (uint32_t at = 0; at < w->lit_count && !rti_cancelled(w->frame->cancel); at += RTK_BLOCK) {
        const uint32_t n = w->lit_count - at < RTK_BLOCK ? w->lit_count - at : RTK_BLOCK;
        draw(w, at, n, each, seed, first);
        leave(w, at, 1.0f / (float)each, &s);
        for (uint32_t j = 0; j < each; j++) {
            spread(w, at, seed, first, j, &s);
            queue(w, RTI_LIGHT_MIXED, at, going(&s, n), &s);
        }
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
