/* Shading in lanes against the scalar functions it is made of, at every instruction set that this machine runs: surfaces of every
 * kind, the rare ones among them, lights, sums and rows of the image, bit for bit. */
#include "lanes_stage.h"

static uint8_t seen[2048];
static uint32_t by_kind[RTI_SURFACE_COUNT], rare, by_look[2];

static void same(float a, float b, const char *what, uint32_t ray)
{
    if (rtk_bits(a) != rtk_bits(b))
        fail_msg("ray %u: %s is %.9g in lanes, %.9g alone", (unsigned)ray, what, a, b);
}

static void same3(float x, float y, float z, rtk_vec3 v, const char *what, uint32_t ray)
{
    same(x, v.x, what, ray);
    same(y, v.y, what, ray);
    same(z, v.z, what, ray);
}

static void check_sheaf(rti_worker *w, rti_sheaf *c)
{
    const rtk_scene *scene = w->frame->scene;
    for (uint32_t k = 0; k < c->count; k++) {
        uint32_t i = c->ray[k];
        rtk_ray ray = rti_batch_ray(w, i);
        rtk_hit hit = rti_hit_at(w->hits, i);
        rtk_surface s = rtk_surface_at(scene, ray, hit, 0.0f);
        int outside = rtk_face(&s, ray.dir);
        rti_ray_state state = rti_batch_state(w, i);
        const rtk_material *m = &scene->materials[s.material];
        assert_int_not_equal(hit.prim, RTK_INVALID);
        assert_int_equal(seen[i]++, 0);
        same3(c->px[k], c->py[k], c->pz[k], s.p, "p", i);
        same3(c->gx[k], c->gy[k], c->gz[k], s.ng, "ng", i);
        same3(c->nx[k], c->ny[k], c->nz[k], s.ns, "ns", i);
        same(c->error[k], s.error, "error", i);
        same(c->footprint[k], state.width + state.spread * hit.t, "footprint", i);
        assert_int_equal(c->outside[k], outside);
        assert_int_equal(c->material[k], s.material);
        same3(c->cr[k], c->cg[k], c->cb[k], rtk_base_color(scene, m, s, c->footprint[k]), "colour", i);
        by_kind[c->surface_kind]++;
        by_look[m->color_tex != RTK_INVALID]++;
        rare += c->surface_kind != RTI_SURFACE_OTHER && !c->plain[k];
    }
}

static void surfaces(rt_scene *scene, rti_isa isa)
{
    rt_job *job = make_job(scene, isa, "whitted");
    rti_worker *w = &job->workers[0].wave;
    memset(by_kind, 0, sizeof by_kind);
    by_look[0] = by_look[1] = rare = 0;
    seed = 77;
    for (uint32_t round = 0; round < 4; round++) {
        uint32_t count = 2048 - 37 * round, hits = 0, met = 0;
        fill_batch(w, count, 0);
        memset(seen, 0, sizeof seen);
        rti_sheaves(w, 0, count, check_sheaf);
        for (uint32_t i = 0; i < count; i++) {
            hits += w->hits[i / RTK_BLOCK].prim[i % RTK_BLOCK] != RTK_INVALID;
            met += seen[i];
        }
        assert_int_equal(met, hits);
    }
    for (uint32_t kind = RTI_SURFACE_MESH; kind < RTI_SURFACE_COUNT; kind++)
        if (by_kind[kind] <= 20) /* else the scene has lost what this test is for */
            fail_msg("kind %u is met %u times", (unsigned)kind, (unsigned)by_kind[kind]);
    assert_true(by_look[0] > 100 && by_look[1] > 100 && rare > 50);
    rt_job_destroy(job);
}

static void test_surfaces(void **state)
{
    (void)state;
    each_isa(surfaces);
}

/* ---- sums ---- */

static float nasty(void)
{
    static const float some[] = {0,        -0.0f,     8192, -8192,  8193,           1e30f,
                                 INFINITY, -INFINITY, NAN,  1e-44f, 1.8626451e-09f, 5.5879354e-09f};
    uint32_t i = (uint32_t)kit_range(&seed, 0, 40);
    return i < sizeof some / sizeof *some ? some[i] : kit_range(&seed, -2, 2) * (i & 1 ? 1.0f : 1e-7f);
}

static void sums(rt_scene *scene, rti_isa isa)
{
    enum { N = 500, CELLS = 40 };
    rt_job *job = make_job(scene, isa, "whitted");
    rti_worker *w = &job->workers[0].wave;
    uint64_t film[CELLS * RTK_FILM_CHANNELS] = {0}, clamped = 0, dropped = 0;
    seed = 9;
    memset(w->film, 0, sizeof film);
    w->shadows.count = N;
    for (uint32_t i = 0; i < N; i++) {
        rti_pending_block *p = &w->shadows.pending[i / RTK_BLOCK];
        uint32_t k = i % RTK_BLOCK, hidden = kit_range(&seed, 0, 1) < 0.3f;
        bool calm = i / RTK_BLOCK % 2; /* blocks of ordinary numbers go the quick way */
        p->r[k] = calm ? kit_range(&seed, 0, 2) : nasty();
        p->g[k] = calm ? kit_range(&seed, -1e-6f, 1e-6f) : nasty();
        p->b[k] = calm ? (float)(1 + 2 * (i % 9)) * 1.8626451e-09f : nasty(); /* halves of the unit */
        p->home[k] = (uint32_t)kit_range(&seed, 0, CELLS - 1);
        if (k == 0)
            w->shadows.occluded[i / RTK_BLOCK] = 0;
        w->shadows.occluded[i / RTK_BLOCK] |= (uint16_t)(hidden << k);
        if (hidden)
            continue;
        switch (rtk_film_add(film + p->home[k] * RTK_FILM_CHANNELS, rtk_v3(p->r[k], p->g[k], p->b[k]), job->frame.film_scale)) {
        case RTK_FILM_CLAMPED:
            clamped++;
            break;
        case RTK_FILM_DROPPED:
            dropped++;
            break;
        default:
            break;
        }
    }
    job->frame.lanes->arrive(w);
    assert_memory_equal(film, w->film, sizeof film);
    assert_int_equal(clamped, w->counts.clamped);
    assert_int_equal(dropped, w->counts.dropped);
    assert_true(clamped > 0 && dropped > 0);
    w->shadows.count = 0;
    rt_job_destroy(job);
}

static void test_sums(void **state)
{
    (void)state;
    each_isa(sums);
}

static void rows(rt_scene *scene, rti_isa isa)
{
    static const double samples[] = {1, 2, 3, 7, 64, 1000, 65536};
    uint64_t sum[4 * 37];
    float out[4 * 37];
    (void)scene;
    seed = 12;
    for (size_t s = 0; s < sizeof samples / sizeof *samples; s++) {
        double unit = s & 1 ? ldexp(1, -28) : ldexp(1, -20);
        for (uint32_t i = 0; i < 4 * 37; i++)
            sum[i] = (uint64_t)(int64_t)(kit_range(&seed, -1, 1) * (i % 9 == 0 ? 9e18f : 1e9f));
        for (uint32_t i = 3; i < 4 * 37; i += 4)
            sum[i] = (uint64_t)kit_range(&seed, 0, (float)samples[s]);
        rti_lanes_find(isa)->resolve(sum, out, 37, unit, samples[s]);
        for (uint32_t i = 0; i < 4 * 37; i++) {
            double value = i % 4 == 3 ? (double)sum[i] : (double)(int64_t)sum[i] * unit;
            assert_true((float)(value / samples[s]) == out[i]);
        }
    }
}

static void test_rows(void **state)
{
    (void)state;
    each_isa(rows);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_surfaces), cmocka_unit_test(test_sums), cmocka_unit_test(test_rows)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
