#include "sweep.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <math.h>
#include <string.h>

#include "judge.h"

/* Rays of `kinds` kinds from `first` on. Those of a kind stand together: denormals slow down the lanes beside them. */
static void fill_kinds(test_batch *b, const test_targets *t, test_rng *rng, uint32_t first, uint32_t kinds)
{
    for (uint32_t i = 0; i < TEST_BATCH; i++) {
        rtk_trace_block *r = &b->rays[i / RTK_BLOCK];
        uint32_t k = i % RTK_BLOCK;
        b->kinds[i] = (int)(first + i * kinds / TEST_BATCH);
        b->times[i] = (float)(i * 37 % 64) / 63.0f;
        rtk_ray ray = test_ray(t, rng, b->kinds[i]);
        r->ox[k] = ray.org.x;
        r->oy[k] = ray.org.y;
        r->oz[k] = ray.org.z;
        r->dx[k] = ray.dir.x;
        r->dy[k] = ray.dir.y;
        r->dz[k] = ray.dir.z;
        r->tmin[k] = ray.tmin;
        r->tmax[k] = ray.tmax;
        r->mask[k] = ray.mask;
    }
}

void test_batch_fill(test_batch *b, const test_targets *t, test_rng *rng)
{
    fill_kinds(b, t, rng, 0, TEST_RAY_KINDS);
}

/* Tiles of 64 rays that lie beside their first one, a third of them with one origin, a third very narrow. Two of three see what
 * the first one sees: packets of one mask go another way than those of several. */
static void make_tiles(test_batch *b, test_rng *rng)
{
    for (uint32_t i = 0; i < TEST_BATCH; i++) {
        const uint32_t first = i / 64 * 64, way = i / 64 % 3, k = i % RTK_BLOCK;
        const rtk_trace_block *f = &b->rays[first / RTK_BLOCK];
        rtk_trace_block *r = &b->rays[i / RTK_BLOCK];
        float wide = way == 1 ? 1e-4f : 0.05f, size, far = 0.0f;
        if (i == first)
            continue;
        if (i / 64 % 9 < 6)
            r->mask[k] = f->mask[0];
        size = rtk_maxabs(rtk_v3(f->dx[0], f->dy[0], f->dz[0]));
        if (way != 0 && rtk_finite(f->ox[0]) && rtk_finite(f->oy[0]) && rtk_finite(f->oz[0]))
            far = 1e-3f * rtk_maxabs(rtk_v3(f->ox[0], f->oy[0], f->oz[0]));
        r->ox[k] = f->ox[0] + far * test_unit(rng);
        r->oy[k] = f->oy[0] + far * test_unit(rng);
        r->oz[k] = f->oz[0] + far * test_unit(rng);
        r->dx[k] = f->dx[0] + wide * size * (test_unit(rng) - 0.5f);
        r->dy[k] = f->dy[0] + wide * size * (test_unit(rng) - 0.5f);
        r->dz[k] = f->dz[0] + wide * size * (test_unit(rng) - 0.5f);
    }
}

/* The rays of a block become a beam about its first one, which was aimed at something: what packets are made for. */
static void make_beams(test_batch *b, test_rng *rng)
{
    for (uint32_t i = 0; i < TEST_BATCH; i++) {
        rtk_trace_block *r = &b->rays[i / RTK_BLOCK];
        uint32_t k = i % RTK_BLOCK;
        float spread = (i / RTK_BLOCK % 4 == 0 ? 0.3f : 0.003f) * (fabsf(r->dx[0]) + fabsf(r->dy[0]) + fabsf(r->dz[0]));
        if (k == 0 || !(spread < 1.0e18f))
            continue;
        r->ox[k] = r->ox[0];
        r->oy[k] = r->oy[0];
        r->oz[k] = r->oz[0];
        r->dx[k] = r->dx[0] + test_range(rng, -spread, spread);
        r->dy[k] = r->dy[0] + test_range(rng, -spread, spread);
        r->dz[k] = r->dz[0] + test_range(rng, -spread, spread);
        r->tmin[k] = k % 5 ? r->tmin[0] : r->tmin[k];
        r->tmax[k] = k % 7 ? r->tmax[0] : r->tmax[k];
    }
}

static void same_hits(const test_batch *b, const char *what, const char *name, const rtk_hit_block *x, const rtk_hit_block *y)
{
    if (memcmp(x, y, sizeof b->hits) == 0)
        return;
    for (uint32_t i = 0; i < TEST_BATCH; i++) {
        const rtk_hit_block *p = &x[i / RTK_BLOCK], *q = &y[i / RTK_BLOCK];
        const rtk_trace_block *r = &b->rays[i / RTK_BLOCK];
        uint32_t k = i % RTK_BLOCK;
        if (p->t[k] == q->t[k] && p->prim[k] == q->prim[k] && p->geom[k] == q->geom[k] && p->inst[k] == q->inst[k] &&
            p->u[k] == q->u[k] && p->v[k] == q->v[k])
            continue;
        fail_msg("%s, %s: ray %u (kind %d) org %a %a %a dir %a %a %a range %a %a mask %x: brute t %a prim %u geom %u inst %u, "
                 "here t %a prim "
                 "%u geom %u inst %u",
                 what, name, i, b->kinds[i], r->ox[k], r->oy[k], r->oz[k], r->dx[k], r->dy[k], r->dz[k], r->tmin[k], r->tmax[k],
                 r->mask[k], p->t[k], p->prim[k], p->geom[k], p->inst[k], q->t[k], q->prim[k], q->geom[k], q->inst[k]);
    }
    fail_msg("%s, %s: hits differ in bits only (a NaN or a zero's sign)", what, name);
}

/* The judge's answers for the batch's rays: hits, and occluded and the steps from hit to hit when all is asked for. */
static void ask_judge(test_batch *b, const rtk_scene *s, const rti_tracer *judge, bool all)
{
    rti_scratch scratch = {.room = test_room(), .times = b->times};
    judge->intersect(s, b->rays, b->hits, TEST_BATCH, 0, &scratch);
    if (!all)
        return;
    judge->occluded(s, b->rays, b->occluded, TEST_BATCH, 0, &scratch);
    for (int step = 0; step < TEST_STEPS; step++) {
        memcpy(b->from[step], step ? b->next[step - 1] : b->hits, sizeof b->hits);
        for (uint32_t i = 0; step && i < TEST_BATCH; i++) /* a ray that has run out of hits begins again */
            if (b->from[step][i / RTK_BLOCK].prim[i % RTK_BLOCK] == RTK_INVALID)
                b->from[step][i / RTK_BLOCK].t[i % RTK_BLOCK] = 0.0f;
        memcpy(b->next[step], b->from[step], sizeof b->hits);
        judge->intersect(s, b->rays, b->next[step], TEST_BATCH, RTI_TRACE_AFTER, &scratch);
    }
}

/* Closest and any hits of one tracer, asked as a coherent batch, against the judge's; some rays are left out behind the count. */
static void compare_coherent(test_batch *b, const rtk_scene *s, const rti_tracer *tracer, const char *what)
{
    rti_scratch scratch = {.room = test_room(), .times = b->times};
    memcpy(b->other, b->hits, sizeof b->hits);
    tracer->intersect(s, b->rays, b->other, TEST_BATCH - 5, RTI_TRACE_COHERENT, &scratch);
    same_hits(b, what, tracer->name, b->hits, b->other);
    tracer->occluded(s, b->rays, b->occluded_other, TEST_BATCH - 5, RTI_TRACE_COHERENT, &scratch);
    for (uint32_t i = 0; i < TEST_BATCH - 5; i++)
        if ((b->occluded_other[i / RTK_BLOCK] >> i % RTK_BLOCK & 1u) !=
            (b->hits[i / RTK_BLOCK].prim[i % RTK_BLOCK] != RTK_INVALID))
            fail_msg("%s, %s: ray %u (kind %d) of a coherent batch: any hit and closest hit disagree", what, tracer->name, i,
                     b->kinds[i]);
}

/* Each ray by itself. */
static void compare_alone(test_batch *b, const rtk_scene *s, const rti_tracer *tracer)
{
    for (uint32_t i = 0; i < TEST_BATCH; i++) {
        const rtk_trace_block *r = &b->rays[i / RTK_BLOCK];
        rtk_hit_block *to = &b->other[i / RTK_BLOCK];
        const uint32_t k = i % RTK_BLOCK;
        const rti_ray ray = {{r->ox[k], r->oy[k], r->oz[k]}, r->tmin[k], {r->dx[k], r->dy[k], r->dz[k]}, r->tmax[k], r->mask[k]};
        const float time = b->times[i];
        rti_hit h;
        const int hit = tracer->one(s, &ray, time, &h), any = tracer->one(s, &ray, time, NULL);
        to->t[k] = h.t, to->u[k] = h.u, to->v[k] = h.v;
        to->prim[k] = h.prim, to->geom[k] = h.geom, to->inst[k] = h.inst;
        if ((hit != 0) != (h.prim != RTK_INVALID) || (any != 0) != (h.prim != RTK_INVALID))
            fail_msg("%s: ray %u (kind %d) alone: what is returned and the hit disagree", tracer->name, i, b->kinds[i]);
    }
    same_hits(b, "each alone", tracer->name, b->hits, b->other);
}

/* One tracer against all that the judge has answered. */
static void compare(test_batch *b, const rtk_scene *s, const rti_tracer *tracer, const char *what)
{
    rti_scratch scratch = {.room = test_room(), .times = b->times},
                turns = {.room = test_room(), .times = b->times, .turns = true};
    const bool wide = tracer->tree != RTK_TREE_NONE;
    for (int way = 0; way <= wide; way++) {
        tracer->intersect(s, b->rays, b->other, TEST_BATCH, 0, way ? &turns : &scratch);
        same_hits(b, way ? "by turns" : what, tracer->name, b->hits, b->other);
    }
    if (wide) {
        tracer->occluded(s, b->rays, b->occluded_other, TEST_BATCH, 0, &turns);
        assert_memory_equal(b->occluded, b->occluded_other, sizeof b->occluded);
    }
    if (tracer->tree != RTK_TREE_NONE)
        compare_alone(b, s, tracer);
    tracer->occluded(s, b->rays, b->occluded_other, TEST_BATCH, 0, &scratch);
    for (uint32_t i = 0; i < TEST_BATCH; i++) {
        unsigned hit = b->hits[i / RTK_BLOCK].prim[i % RTK_BLOCK] != RTK_INVALID;
        if ((b->occluded[i / RTK_BLOCK] >> i % RTK_BLOCK & 1u) != hit ||
            (b->occluded_other[i / RTK_BLOCK] >> i % RTK_BLOCK & 1u) != hit)
            fail_msg("%s, %s: ray %u (kind %d): any hit and closest hit disagree", what, tracer->name, i, b->kinds[i]);
    }
    for (int step = 0; step < 2 * TEST_STEPS; step++) { /* walks that count are others */
        memcpy(b->other, b->from[step / 2], sizeof b->hits);
        tracer->intersect(s, b->rays, b->other, TEST_BATCH, RTI_TRACE_AFTER | (step % 2 ? RTI_TRACE_STEPS : 0), &scratch);
        same_hits(b, what, tracer->name, b->next[step / 2], b->other);
    }
}

void test_sweep(const test_world *w, const rti_tracer *judge, uint64_t count, const char *what)
{
    static test_batch b;
    test_targets t;
    test_rng rng = {0x1234567};
    uint64_t hits = 0, done = 0;
    test_targets_init(&t, w);
    for (; done < count; done += TEST_BATCH) {
        test_batch_fill(&b, &t, &rng);
        ask_judge(&b, &w->scene, judge, true);
        for (uint32_t i = 0; i < rti_tracer_count(); i++)
            if (rti_tracer_at(test_isa(), i) != judge && rti_tracer_at(test_isa(), i)->tree != RTK_TREE_NONE)
                compare(&b, &w->scene, rti_tracer_at(test_isa(), i), what);
        for (uint32_t i = 0; i < TEST_BATCH; i++)
            hits += b.hits[i / RTK_BLOCK].prim[i % RTK_BLOCK] != RTK_INVALID;
        for (int beams = 0; beams < 3; beams++) {
            if (beams)
                (beams == 1 ? make_beams : make_tiles)(&b, &rng);
            ask_judge(&b, &w->scene, judge, false);
            for (uint32_t i = 0; i < rti_tracer_count(); i++)
                if (rti_tracer_at(test_isa(), i)->tree != RTK_TREE_NONE)
                    compare_coherent(&b, &w->scene, rti_tracer_at(test_isa(), i), what);
        }
    }
    test_targets_free(&t);
    if (hits * 10 < done)
        fail_msg("%s: only %llu of %llu rays hit: the test tests little", what, (unsigned long long)hits,
                 (unsigned long long)done);
}

void test_sweep_closest(const test_world *w, uint64_t count, const char *what)
{
    static test_batch b;
    test_closest judge;
    test_targets t;
    test_rng rng = {0x7654321};
    test_targets_init(&t, w);
    test_closest_open(&judge, &w->scene);
    for (uint64_t done = 0; done < 2 * count; done += TEST_BATCH) {
        if (done < count)
            fill_kinds(&b, &t, &rng, TEST_RAY_RANDOM, 1);
        else if (done / TEST_BATCH % 100 == 0)
            fill_kinds(&b, &t, &rng, TEST_RAY_DENORMAL, 1);
        else
            fill_kinds(&b, &t, &rng, TEST_RAY_RANDOM + 1, TEST_RAY_DENORMAL - TEST_RAY_RANDOM - 1);
        test_closest_ask(&judge, b.rays, b.hits, TEST_BATCH);
        for (uint32_t i = 0; i < rti_tracer_count(); i++) {
            if (rti_tracer_at(test_isa(), i)->tree == RTK_TREE_NONE)
                continue;
            rti_tracer_at(test_isa(), i)
                ->intersect(&w->scene, b.rays, b.other, TEST_BATCH, 0, &(rti_scratch){.room = test_room()});
            same_hits(&b, what, rti_tracer_at(test_isa(), i)->name, b.hits, b.other);
        }
    }
    print_message("%s: closest hits of %llu random and as many aimed rays against brute force%s, none differs\n", what,
                  (unsigned long long)count, judge.far ? " without what is far" : "");
    test_closest_close(&judge);
    test_targets_free(&t);
}
