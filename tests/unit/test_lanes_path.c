/* Both integrators of the classic material in lanes against the same hits told one by one, and what lights bring to lit points in
 * lanes against the functions of kernel_alone.h, at every instruction set that this machine runs, bit for bit. */
#include "lanes_stage.h"

#include "render/direct.h"
#include "shade_alone.h"

#define BATCH 1024u

/* What a step leaves: lit points, rays and light, in an order of their own. */
typedef struct noted {
    uint32_t ray, home;
    uint32_t row[RTI_LIT_ROWS];
} noted;
typedef struct sent {
    uint32_t word[24];
} sent;
typedef struct outcome {
    noted lit[BATCH];
    sent rays[2 * BATCH];
    uint64_t film[4096 * RTK_FILM_CHANNELS];
    uint32_t lit_count, ray_count;
    rti_worker_counts counts;
} outcome;

static int by_words(const void *a, const void *b)
{
    return memcmp(a, b, sizeof(sent));
}
static int by_ray(const void *a, const void *b)
{
    const uint32_t x = ((const noted *)a)->ray, y = ((const noted *)b)->ray;
    return x < y ? -1 : x > y;
}

static void take_outcome(const rti_worker *w, outcome *o)
{
    memset(o, 0, sizeof *o);
    for (uint32_t i = 0; i < w->lit_count; i++) {
        noted *n = &o->lit[o->lit_count++];
        n->ray = w->lit_ray[i];
        n->home = w->lit_home[i];
        for (uint32_t r = 0; r < RTI_LIT_ROWS; r++)
            n->row[r] = rtk_bits(w->lit[(size_t)r * w->lit_stride + i]);
    }
    for (uint32_t i = 0; i < w->stack.count; i++) {
        const rtk_trace_block *t = &w->stack.trace[i / RTK_BLOCK];
        const rtk_path_block *p = &w->stack.path[i / RTK_BLOCK];
        const uint32_t k = i % RTK_BLOCK;
        const float f[] = {t->ox[k],  t->oy[k],  t->oz[k],  t->dx[k],  t->dy[k],    t->dz[k],     t->tmin[k], t->tmax[k],
                           p->tpr[k], p->tpg[k], p->tpb[k], p->eta[k], p->width[k], p->spread[k], p->pdf[k]};
        const uint32_t u[] = {p->key_lo[k],
                              p->key_hi[k],
                              p->pixel[k],
                              p->sample[k],
                              p->depth_kind[k],
                              t->mask[k],
                              w->stack.home[i / RTK_BLOCK].home[k]};
        sent *s = &o->rays[o->ray_count++];
        memcpy(s->word, f, sizeof f);
        memcpy(s->word + sizeof f / sizeof *f, u, sizeof u);
    }
    qsort(o->lit, o->lit_count, sizeof *o->lit, by_ray);
    qsort(o->rays, o->ray_count, sizeof *o->rays, by_words);
    memcpy(o->film, w->film, sizeof o->film);
    o->counts = w->counts;
}

static void shade_batch(rti_worker *w, uint32_t count, rti_sheaf_fn how, outcome *o)
{
    w->stack.count = w->lit_count = 0;
    memset(&w->counts, 0, sizeof w->counts);
    memset(w->film, 0, sizeof o->film);
    rti_sheaves(w, 0, count, how);
    take_outcome(w, o);
}

/* Batches of some depths, whose hits are told in lanes and alone. Adds up the rays. */
static void same_outcomes(rti_worker *w, const uint32_t depths[4], rti_sheaf_fn how, rti_sheaf_fn told, rti_worker_counts *sum)
{
    static outcome alone, lanes;
    memset(sum, 0, sizeof *sum);
    lamps_met = 0;
    seed = 31;
    for (uint32_t round = 0; round < 4; round++) {
        const uint32_t count = BATCH - 5 * round;
        fill_batch(w, count, depths[round]);
        shade_batch(w, count, told, &alone);
        shade_batch(w, count, how, &lanes);
        assert_int_equal(alone.lit_count, lanes.lit_count);
        assert_memory_equal(alone.lit, lanes.lit, sizeof alone.lit);
        assert_int_equal(alone.ray_count, lanes.ray_count);
        assert_memory_equal(alone.rays, lanes.rays, sizeof alone.rays);
        assert_memory_equal(alone.film, lanes.film, sizeof alone.film);
        assert_memory_equal(&alone.counts, &lanes.counts, sizeof alone.counts);
        assert_true(alone.lit_count > count / 4);
        assert_true(round == 3 ? alone.ray_count == 0 : alone.ray_count > count / 8);
        for (uint32_t kind = 0; kind < RTK_KIND_COUNT; kind++)
            sum->rays[kind] += alone.counts.rays[kind];
    }
    w->stack.count = w->lit_count = 0;
    assert_true(lamps_met > 4 && sum->rays[RTK_KIND_REFLECT] > 100); /* else the scene has lost what this test is for */
    assert_true(stage_clear ? sum->rays[RTK_KIND_REFRACT] > 100 : sum->rays[RTK_KIND_REFRACT] == 0);
}

static void paths(rt_scene *scene, rti_isa isa)
{
    rt_job *job = make_job(scene, isa, "path");
    const uint32_t most = job->frame.set.desc.max_depth, roulette = job->frame.set.roulette_from;
    const uint32_t depths[] = {0, roulette, most - 1, most};
    rti_worker_counts sum;
    assert_true(roulette > 0 && roulette < most);
    same_outcomes(&job->workers[0].wave, depths, job->frame.lanes->path, paths_alone, &sum);
    assert_true(sum.rays[RTK_KIND_DIFFUSE] > 100);
    rt_job_destroy(job);
}

static void whitted(rt_scene *scene, rti_isa isa)
{
    rt_job *job = make_job(scene, isa, "whitted");
    const uint32_t most = job->frame.set.desc.max_depth, depths[] = {0, 1, most - 1, most};
    rti_worker_counts sum;
    same_outcomes(&job->workers[0].wave, depths, job->frame.lanes->whitted, whitted_alone, &sum);
    rt_job_destroy(job);
}

static void test_shading(void **state)
{
    (void)state;
    stage_lights = true;
    for (int clear = 0; clear < 2; clear++) {
        stage_clear = clear;
        each_isa(paths);
        each_isa(whitted);
    }
    stage_clear = stage_lights = false;
}

/* ---- what lights bring ---- */

typedef struct shadow_ray {
    uint32_t home;
    float ray[7], light[3]; /* origin, direction, tmax */
} shadow_ray;
typedef struct shadow_rays {
    shadow_ray list[4 * BATCH];
    uint32_t count;
} shadow_rays;

static int by_home(const void *a, const void *b)
{
    const shadow_ray *x = a, *y = b;
    return x->home != y->home ? (x->home < y->home ? -1 : 1) : memcmp(x->ray, y->ray, sizeof x->ray);
}

static rtk_vec3 lit3(const rti_worker *w, uint32_t row, uint32_t i)
{
    const float *x = w->lit + (size_t)row * w->lit_stride + i;
    return rtk_v3(x[0], x[w->lit_stride], x[2 * (size_t)w->lit_stride]);
}

static float lit1(const rti_worker *w, uint32_t row, uint32_t i)
{
    return w->lit[(size_t)row * w->lit_stride + i];
}

/* The shadow ray of point i along `toward`; weight: of the Lambert part, scale: of all. */
static void expect(const rti_worker *w, const rtk_light *l, uint32_t i, rtk_light_sample toward, float weight, float scale,
                   shadow_rays *to)
{
    const rtk_vec3 p = lit3(w, RTI_LIT_PX, i), n = lit3(w, RTI_LIT_NX, i), g = lit3(w, RTI_LIT_GX, i), s = lit3(w, RTI_LIT_SR, i);
    const float error = lit1(w, RTI_LIT_ERROR, i), cosine = rtk_dot3(n, toward.dir);
    const rtk_vec3 org = rtk_madd(p, 2.0f * error, g);
    const float tmax = rtk_light_end(l, p, error, rtk_light_reach(l, p, toward));
    rtk_vec3 c = rtk_scale(lit3(w, RTI_LIT_KR, i), weight);
    if (!(cosine > 0.0f) || !(rtk_dot3(g, toward.dir) > 0.0f))
        return;
    if (rtk_maxabs(s) > 0.0f)
        c = rtk_madd(c, rtk_highlight(lit1(w, RTI_LIT_SHININESS, i), n, toward.dir, lit3(w, RTI_LIT_VX, i)), s);
    c = rtk_mul(c, rtk_scale(toward.e, cosine * scale));
    if (rtk_maxabs(c) == 0.0f)
        return;
    assert_true(to->count < 4 * BATCH);
    to->list[to->count++] =
        (shadow_ray){w->lit_home[i], {org.x, org.y, org.z, toward.dir.x, toward.dir.y, toward.dir.z, tmax}, {c.x, c.y, c.z}};
}

static void same_shadows(rti_worker *w, shadow_rays *want, const char *what)
{
    static shadow_rays got;
    got.count = w->shadows.count;
    assert_int_equal(got.count, want->count);
    for (uint32_t i = 0; i < got.count; i++) {
        const rtk_trace_block *t = &w->shadows.trace[i / RTK_BLOCK];
        const rti_pending_block *p = &w->shadows.pending[i / RTK_BLOCK];
        const uint32_t k = i % RTK_BLOCK;
        got.list[i] = (shadow_ray){
            p->home[k], {t->ox[k], t->oy[k], t->oz[k], t->dx[k], t->dy[k], t->dz[k], t->tmax[k]}, {p->r[k], p->g[k], p->b[k]}};
        assert_true(t->tmin[k] == 0.0f && t->mask[k] == RT_MASK_SHADOW);
    }
    qsort(got.list, got.count, sizeof *got.list, by_home);
    qsort(want->list, want->count, sizeof *want->list, by_home);
    for (uint32_t i = 0; i < got.count; i++)
        if (memcmp(&got.list[i], &want->list[i], sizeof *got.list) != 0)
            fail_msg("%s: the shadow ray of home %u differs", what, (unsigned)want->list[i].home);
    w->shadows.count = 0;
    want->count = 0;
}

/* Lit points of a batch; every seventh is moved onto or into a light, for the rare ways. */
static void light_up(rti_worker *w, uint32_t count)
{
    const rtk_scene *scene = w->frame->scene;
    fill_batch(w, count, 0);
    w->stack.count = w->lit_count = 0;
    rti_sheaves(w, 0, count, w->frame->lanes->path);
    for (uint32_t i = 0; i < w->lit_count; i += 7) {
        const rtk_light *l = &scene->lights[i / 7 % scene->light_count];
        const float off = i % 3 == 0 ? 0.0f : i % 3 == 1 ? 1e-18f : 0.2f;
        for (uint32_t k = 0; k < 3; k++)
            w->lit[(RTI_LIT_PX + k) * (size_t)w->lit_stride + i] = (l->type == RTK_LIGHT_DIRECTIONAL ? 0.0f : l->at[k]) + off;
    }
}

static uint32_t seed_of(const rti_worker *w, uint32_t i, uint32_t *sample)
{
    const rti_ray_state state = rti_batch_state(w, w->lit_ray[i]);
    *sample = state.sample;
    return vertex_seed(w->frame, &state);
}

static void chosen(rti_worker *w, shadow_rays *want)
{
    const rtk_scene *scene = w->frame->scene;
    for (uint32_t i = 0; i < w->lit_count; i++) {
        uint32_t sample, s = seed_of(w, i, &sample), index = 0;
        const rtk_vec3 p = lit3(w, RTI_LIT_PX, i), n = lit3(w, RTI_LIT_NX, i);
        if (scene->light_count > 1)
            index = rtk_light_choose(scene->lights, scene->light_count, rtk_random(s, sample, RTK_DIM_LIGHT_CHOICE));
        const rtk_light *l = &scene->lights[index];
        const rtk_uv u = rtk_random2(s, sample, RTK_DIM_LIGHT_U);
        const rtk_light_sample toward = rtk_light_toward(l, p, u.x, u.y);
        const float asking =
            rtk_light_asking(l->select_pdf, toward.pdf, rtk_dot3(n, toward.dir), lit1(w, RTI_LIT_DIFFUSE_PDF, i));
        if (l->select_pdf > 0.0f)
            expect(w, l, i, toward, rtk_light_is_met(l) ? asking : 1.0f, 1.0f / l->select_pdf, want);
    }
}

static void asked_by_all(rti_worker *w, uint32_t index, shadow_rays *want)
{
    const rtk_light *l = &w->frame->scene->lights[index];
    const uint32_t each = l->type == RTK_LIGHT_SPHERE ? rti_frame_light_samples(w->frame, l) : 1;
    for (uint32_t i = 0; i < w->lit_count; i++) {
        uint32_t sample, s = rtk_hash2(seed_of(w, i, &sample), index);
        const rtk_vec3 p = lit3(w, RTI_LIT_PX, i);
        if (rtk_light_behind(l, p, lit3(w, RTI_LIT_NX, i)) || rtk_light_behind(l, p, lit3(w, RTI_LIT_GX, i)))
            continue;
        for (uint32_t j = 0; j < each; j++) {
            const rtk_uv u = rtk_random2(s, sample * each + j, RTK_DIM_LIGHT_U);
            expect(w, l, i, rtk_light_toward(l, p, u.x, u.y), 1.0f, 1.0f / (float)each, want);
        }
    }
}

static void lights(rt_scene *scene, rti_isa isa)
{
    static shadow_rays want;
    rt_job *job = make_job(scene, isa, "path");
    rti_worker *w = &job->workers[0].wave;
    rtk_scene only = *job->frame.scene;
    const rtk_scene *all = job->frame.scene;
    seed = 43;
    light_up(w, BATCH - 3);
    assert_true(w->lit_count > BATCH / 4 && w->lit_count % RTK_BLOCK != 0);
    chosen(w, &want);
    assert_true(want.count > w->lit_count / 8);
    job->frame.lanes->one(w);
    same_shadows(w, &want, "of several lights");
    for (uint32_t i = 0; i < all->light_count; i++) {
        asked_by_all(w, i, &want);
        assert_true(want.count > w->lit_count / 16);
        job->frame.lanes->shine(w, i);
        same_shadows(w, &want, "of a light that all ask");
        only.lights = all->lights + i;
        only.light_count = 1;
        job->frame.scene = &only;
        chosen(w, &want);
        job->frame.lanes->one(w);
        same_shadows(w, &want, "of the only light");
        job->frame.scene = all;
    }
    w->stack.count = w->lit_count = 0;
    rt_job_destroy(job);
}

static void test_lights(void **state)
{
    (void)state;
    stage_lights = true;
    each_isa(lights);
    stage_lights = false;
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_shading), cmocka_unit_test(test_lights)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
