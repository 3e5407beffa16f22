/* Light that comes straight from the scene's lights to the lit points. */
#include "../kernel/classic.h"
#include "../kernel/lights.h"
#include "direct.h"

/* Below this the whole queue waits for more rays before it is answered: small batches cost a tracer as much as half-full ones. */
#define FLUSH_PART 2u

typedef struct lit {
    rtk_vec3 p, n, g, v, k, s;
    float error, shininess;
} lit;

static lit lit_at(const rti_lit_block *b, uint32_t i)
{
    lit l;
    l.p = rtk_v3(b->px[i], b->py[i], b->pz[i]);
    l.n = rtk_v3(b->nx[i], b->ny[i], b->nz[i]);
    l.g = rtk_v3(b->gx[i], b->gy[i], b->gz[i]);
    l.v = rtk_v3(b->vx[i], b->vy[i], b->vz[i]);
    l.k = rtk_v3(b->kr[i], b->kg[i], b->kb[i]);
    l.s = rtk_v3(b->sr[i], b->sg[i], b->sb[i]);
    l.error = b->error[i];
    l.shininess = b->shininess[i];
    return l;
}

void rti_lit_add(rti_worker *worker, uint32_t ray, const rtk_surface *s, rtk_vec3 view, rtk_vec3 k, rtk_vec3 specular,
                 float shininess, float diffuse_pdf)
{
    uint32_t at = worker->lit_count, i = at % RTK_BLOCK;
    rti_lit_block *b = &worker->lit[at / RTK_BLOCK];
    if (rtk_maxabs(k) == 0.0f && rtk_maxabs(specular) == 0.0f)
        return;
    worker->lit_count = at + 1;
    b->px[i] = s->p.x;
    b->py[i] = s->p.y;
    b->pz[i] = s->p.z;
    b->error[i] = s->error;
    b->nx[i] = s->ns.x;
    b->ny[i] = s->ns.y;
    b->nz[i] = s->ns.z;
    b->gx[i] = s->ng.x;
    b->gy[i] = s->ng.y;
    b->gz[i] = s->ng.z;
    b->vx[i] = view.x;
    b->vy[i] = view.y;
    b->vz[i] = view.z;
    b->kr[i] = k.x;
    b->kg[i] = k.y;
    b->kb[i] = k.z;
    b->sr[i] = specular.x;
    b->sg[i] = specular.y;
    b->sb[i] = specular.z;
    b->shininess[i] = shininess;
    b->ray[i] = ray;
    b->diffuse_pdf[i] = diffuse_pdf;
}

/* Sends what light `index` brings to l along `toward`; scale: 1 / (samples * probability), diffuse: weight of the Lambert part.
 */
static void send(rti_worker *w, uint32_t index, const lit *l, rtk_light_sample toward, float scale, float diffuse, uint32_t home,
                 float time)
{
    const rti_frame *f = w->frame;
    const rtk_light *light = &f->scene->lights[index];
    float cosine = rtk_dot3(l->n, toward.dir);
    rtk_vec3 c;
    if (!(cosine > 0.0f) || !(rtk_dot3(l->g, toward.dir) > 0.0f))
        return;
    c = rtk_scale(l->k, diffuse);
    if (rtk_maxabs(l->s) > 0.0f)
        c = rtk_madd(c, rtk_highlight(l->shininess, l->n, toward.dir, l->v), l->s);
    c = rtk_mul(c, rtk_scale(toward.e, cosine * scale));
    if (rtk_maxabs(c) == 0.0f)
        return;
    if (!f->set.desc.shadows)
        rti_add(w, home, c);
    else
        rti_shadow(w, index, rtk_madd(l->p, 2.0f * l->error, l->g), toward.dir,
                   rtk_light_end(light, l->p, l->error, rtk_light_reach(light, l->p, toward)), c, home, time);
}

/* Every lit point from one light. */
static void shine(rti_worker *w, uint32_t index)
{
    const rti_frame *f = w->frame;
    const rtk_light *light = &f->scene->lights[index];
    uint32_t n = rti_frame_light_samples(f, light), seed = 0;
    for (uint32_t i = 0; i < w->lit_count && !rti_cancelled(f->cancel); i++) {
        const rti_lit_block *b = &w->lit[i / RTK_BLOCK];
        lit l = lit_at(b, i % RTK_BLOCK);
        rti_ray_state state;
        if (rtk_light_behind(light, l.p, l.n) || rtk_light_behind(light, l.p, l.g))
            continue;
        state = rti_batch_state(w, b->ray[i % RTK_BLOCK]);
        if (light->type == RTK_LIGHT_SPHERE)
            seed = rtk_hash2(rti_vertex_seed(f, &state), index); /* each light has numbers of its own */
        for (uint32_t j = 0; j < n; j++) {
            rtk_uv u = {0.0f, 0.0f};
            if (light->type == RTK_LIGHT_SPHERE)
                u = rtk_random2(seed, state.sample * n + j, RTK_DIM_LIGHT_U);
            send(w, index, &l, rtk_light_toward(light, l.p, u.x, u.y), 1.0f / (float)n, 1.0f, state.home,
                 rti_batch_time(w, b->ray[i % RTK_BLOCK]));
        }
    }
    if (w->shadows.count >= w->shadows.capacity / FLUSH_PART)
        rti_shadow_flush(w);
}

void rti_light_all(rti_worker *worker)
{
    for (uint32_t i = 0; i < worker->frame->scene->light_count && !rti_cancelled(worker->frame->cancel); i++)
        shine(worker, i);
    worker->lit_count = 0;
}

/* Share of asking a spherical light, against meeting its body by going on with `diffuse_pdf`. */
static float asking_weight(const rtk_light *light, const rtk_light_sample *toward, float cosine, float diffuse_pdf)
{
    float ask = light->select_pdf * toward->pdf;
    if (light->geom == RTK_INVALID || !(light->falloff > 0.0f))
        return 1.0f;
    return ask / (ask + diffuse_pdf * rtk_cosine_pdf(cosine));
}

void rti_light_one(rti_worker *worker)
{
    const rti_frame *f = worker->frame;
    const rtk_scene *scene = f->scene;
    for (uint32_t i = 0; i < worker->lit_count && scene->light_count > 0 && !rti_cancelled(f->cancel); i++) {
        const rti_lit_block *b = &worker->lit[i / RTK_BLOCK];
        lit l = lit_at(b, i % RTK_BLOCK);
        rti_ray_state state = rti_batch_state(worker, b->ray[i % RTK_BLOCK]);
        uint32_t seed = rti_vertex_seed(f, &state);
        uint32_t index =
            rtk_light_choose(scene->lights, scene->light_count, rtk_random(seed, state.sample, RTK_DIM_LIGHT_CHOICE));
        const rtk_light *light = &scene->lights[index];
        rtk_uv u = rtk_random2(seed, state.sample, RTK_DIM_LIGHT_U);
        rtk_light_sample toward = rtk_light_toward(light, l.p, u.x, u.y);
        float weight = asking_weight(light, &toward, rtk_dot3(l.n, toward.dir), b->diffuse_pdf[i % RTK_BLOCK]);
        if (light->select_pdf > 0.0f)
            send(worker, index, &l, toward, 1.0f / light->select_pdf, weight, state.home,
                 rti_batch_time(worker, b->ray[i % RTK_BLOCK]));
    }
    worker->lit_count = 0;
}

void rti_light_around(rti_worker *worker)
{
    const rti_frame *f = worker->frame;
    uint32_t n = f->set.desc.ao_samples;
    for (uint32_t i = 0; i < worker->lit_count && !rti_cancelled(f->cancel); i++) {
        const rti_lit_block *b = &worker->lit[i / RTK_BLOCK];
        lit l = lit_at(b, i % RTK_BLOCK);
        rti_ray_state state = rti_batch_state(worker, b->ray[i % RTK_BLOCK]);
        uint32_t seed = rti_vertex_seed(f, &state);
        for (uint32_t j = 0; j < n; j++) {
            rtk_vec3 dir = rtk_cosine_direction(l.n, rtk_random2(seed, state.sample * n + j, RTK_DIM_AO_U));
            if (rtk_dot3(dir, l.g) > 0.0f)
                rti_shadow(worker, RTI_LIGHT_MIXED, rtk_madd(l.p, 2.0f * l.error, l.g), dir, f->ao_distance,
                           rtk_scale(l.k, 1.0f / (float)n), state.home, rti_batch_time(worker, b->ray[i % RTK_BLOCK]));
        }
    }
    worker->lit_count = 0;
}
