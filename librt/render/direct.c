/* Light that comes straight from the scene's lights to the lit points. */
#include "../kernel/classic.h"
#include "../kernel/lights.h"
#include "direct.h"
#include "lanes.h"

/* Below this the whole queue waits for more rays before it is answered: small batches cost a tracer as much as half-full ones. */
#define FLUSH_PART 2u

typedef struct lit {
    rtk_vec3 p, n, g, v, k, s;
    float error, shininess;
} lit;

static float lit_row(const rti_worker *w, uint32_t row, uint32_t i)
{
    return w->lit[(size_t)row * w->lit_stride + i];
}

static rtk_vec3 lit_row3(const rti_worker *w, uint32_t row, uint32_t i)
{
    return rtk_v3(lit_row(w, row, i), lit_row(w, row + 1, i), lit_row(w, row + 2, i));
}

static lit lit_at(const rti_worker *w, uint32_t i)
{
    lit l;
    l.p = lit_row3(w, RTI_LIT_PX, i);
    l.n = lit_row3(w, RTI_LIT_NX, i);
    l.g = lit_row3(w, RTI_LIT_GX, i);
    l.v = lit_row3(w, RTI_LIT_VX, i);
    l.k = lit_row3(w, RTI_LIT_KR, i);
    l.s = lit_row3(w, RTI_LIT_SR, i);
    l.error = lit_row(w, RTI_LIT_ERROR, i);
    l.shininess = lit_row(w, RTI_LIT_SHININESS, i);
    return l;
}

static void put_row3(rti_worker *w, uint32_t row, uint32_t i, rtk_vec3 x)
{
    float *to = w->lit + (size_t)row * w->lit_stride + i;
    to[0] = x.x;
    to[w->lit_stride] = x.y;
    to[2 * (size_t)w->lit_stride] = x.z;
}

void rti_lit_add(rti_worker *worker, uint32_t ray, const rtk_surface *s, rtk_vec3 view, rtk_vec3 k, rtk_vec3 specular,
                 float shininess, float diffuse_pdf)
{
    uint32_t i = worker->lit_count;
    if (rtk_maxabs(k) == 0.0f && rtk_maxabs(specular) == 0.0f)
        return;
    worker->lit_count = i + 1;
    put_row3(worker, RTI_LIT_PX, i, s->p);
    put_row3(worker, RTI_LIT_NX, i, s->ns);
    put_row3(worker, RTI_LIT_GX, i, s->ng);
    put_row3(worker, RTI_LIT_VX, i, view);
    put_row3(worker, RTI_LIT_KR, i, k);
    put_row3(worker, RTI_LIT_SR, i, specular);
    worker->lit[(size_t)RTI_LIT_ERROR * worker->lit_stride + i] = s->error;
    worker->lit[(size_t)RTI_LIT_SHININESS * worker->lit_stride + i] = shininess;
    worker->lit[(size_t)RTI_LIT_DIFFUSE_PDF * worker->lit_stride + i] = diffuse_pdf;
    worker->lit_ray[i] = ray;
    worker->lit_home[i] = worker->batch.home[ray / RTK_BLOCK].home[ray % RTK_BLOCK];
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

/* Every lit point from one spherical light. */
static void shine_sphere(rti_worker *w, uint32_t index)
{
    const rti_frame *f = w->frame;
    const rtk_light *light = &f->scene->lights[index];
    uint32_t n = rti_frame_light_samples(f, light), seed;
    for (uint32_t i = 0; i < w->lit_count && !rti_cancelled(f->cancel); i++) {
        lit l = lit_at(w, i);
        rti_ray_state state;
        if (rtk_light_behind(light, l.p, l.n) || rtk_light_behind(light, l.p, l.g))
            continue;
        state = rti_batch_state(w, w->lit_ray[i]);
        seed = rtk_hash2(rti_vertex_seed(f, &state), index); /* each light has numbers of its own */
        for (uint32_t j = 0; j < n; j++) {
            rtk_uv u = rtk_random2(seed, state.sample * n + j, RTK_DIM_LIGHT_U);
            send(w, index, &l, rtk_light_toward(light, l.p, u.x, u.y), 1.0f / (float)n, 1.0f, state.home,
                 rti_batch_time(w, w->lit_ray[i]));
        }
    }
}

void rti_light_all(rti_worker *worker)
{
    for (uint32_t i = 0; i < worker->frame->scene->light_count && !rti_cancelled(worker->frame->cancel); i++) {
        if (worker->frame->scene->lights[i].type == RTK_LIGHT_SPHERE)
            shine_sphere(worker, i);
        else
            worker->frame->lanes->shine(worker, i);
        if (worker->frame->scene->light_count > 1 && worker->shadows.count >= worker->shadows.capacity / FLUSH_PART)
            rti_shadow_flush(worker);
    }
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
    const bool several = scene->light_count > 1; /* what is not asked of random numbers is not made */
    for (uint32_t i = 0; i < worker->lit_count && scene->light_count > 0 && !rti_cancelled(f->cancel); i++) {
        lit l = lit_at(worker, i);
        rti_ray_state state = rti_batch_state(worker, worker->lit_ray[i]);
        uint32_t seed = several || scene->lights->type == RTK_LIGHT_SPHERE ? rti_vertex_seed(f, &state) : 0, index = 0;
        rtk_uv u = {0.0f, 0.0f};
        if (several)
            index = rtk_light_choose(scene->lights, scene->light_count, rtk_random(seed, state.sample, RTK_DIM_LIGHT_CHOICE));
        const rtk_light *light = &scene->lights[index];
        if (light->type == RTK_LIGHT_SPHERE)
            u = rtk_random2(seed, state.sample, RTK_DIM_LIGHT_U);
        rtk_light_sample toward = rtk_light_toward(light, l.p, u.x, u.y);
        float weight = asking_weight(light, &toward, rtk_dot3(l.n, toward.dir), lit_row(worker, RTI_LIT_DIFFUSE_PDF, i));
        if (light->select_pdf > 0.0f)
            send(worker, index, &l, toward, 1.0f / light->select_pdf, weight, state.home,
                 rti_batch_time(worker, worker->lit_ray[i]));
    }
    worker->lit_count = 0;
}

void rti_light_around(rti_worker *worker)
{
    worker->frame->lanes->around(worker);
    worker->lit_count = 0;
}
