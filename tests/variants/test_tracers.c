/* Every tracer of the table against brute force, bit for bit: closest hit, any hit, and stepping from hit to hit.
 *
 * LIBRT_RAYS: rays a scene (10,000); LIBRT_FULL=1: two hundred thousand. Real meshes, where brute force costs 70,000 tests a ray,
 * get a hundredth of that against brute force, and a quarter against the kd-tree; with LIBRT_FULL=1 (ten minutes a mesh)
 * closest hits of ten million random and ten million aimed rays (LIBRT_CLOSEST: how many) against support/judge.h's, and one of
 * 64 against brute force. LIBRT_ONLY: the tests of that name; LIBRT_MESH: that mesh alone, of those of LIBRT_SCENES, or `globe`,
 * or none. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/generate.h"
#include "support/judge.h"
#include "support/rays.h"

#define BATCH 1024u
#define STEPS 6 /* hits a ray steps through */

typedef struct batch {
    rtk_trace_block rays[BATCH / RTK_BLOCK];
    rtk_hit_block hits[BATCH / RTK_BLOCK], other[BATCH / RTK_BLOCK];
    rtk_hit_block from[STEPS][BATCH / RTK_BLOCK], next[STEPS][BATCH / RTK_BLOCK]; /* of each step from hit to hit */
    uint16_t occluded[BATCH / RTK_BLOCK], occluded_other[BATCH / RTK_BLOCK];
    int kinds[BATCH];
    float times[BATCH]; /* of moving instances */
} batch;

/* Rays of `kinds` kinds from `first` on. Those of a kind stand together: denormals slow down the lanes beside them. */
static void fill_kinds(batch *b, const test_targets *t, test_rng *rng, uint32_t first, uint32_t kinds)
{
    for (uint32_t i = 0; i < BATCH; i++) {
        rtk_trace_block *r = &b->rays[i / RTK_BLOCK];
        uint32_t k = i % RTK_BLOCK;
        b->kinds[i] = (int)(first + i * kinds / BATCH);
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

static void fill(batch *b, const test_targets *t, test_rng *rng)
{
    fill_kinds(b, t, rng, 0, TEST_RAY_KINDS);
}

/* Tiles of 64 rays that lie beside their first one, a third of them with one origin, a third very narrow. Two of three see what
 * the first one sees: packets of one mask go another way than those of several. */
static void make_tiles(batch *b, test_rng *rng)
{
    for (uint32_t i = 0; i < BATCH; i++) {
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
static void make_beams(batch *b, test_rng *rng)
{
    for (uint32_t i = 0; i < BATCH; i++) {
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

static void same_hits(const batch *b, const char *what, const char *name, const rtk_hit_block *x, const rtk_hit_block *y)
{
    if (memcmp(x, y, sizeof b->hits) == 0)
        return;
    for (uint32_t i = 0; i < BATCH; i++) {
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
static void ask_judge(batch *b, const rtk_scene *s, const rti_tracer *judge, bool all)
{
    rti_scratch scratch = {.room = test_room(), .times = b->times};
    judge->intersect(s, b->rays, b->hits, BATCH, 0, &scratch);
    if (!all)
        return;
    judge->occluded(s, b->rays, b->occluded, BATCH, 0, &scratch);
    for (int step = 0; step < STEPS; step++) {
        memcpy(b->from[step], step ? b->next[step - 1] : b->hits, sizeof b->hits);
        for (uint32_t i = 0; step && i < BATCH; i++) /* a ray that has run out of hits begins again */
            if (b->from[step][i / RTK_BLOCK].prim[i % RTK_BLOCK] == RTK_INVALID)
                b->from[step][i / RTK_BLOCK].t[i % RTK_BLOCK] = 0.0f;
        memcpy(b->next[step], b->from[step], sizeof b->hits);
        judge->intersect(s, b->rays, b->next[step], BATCH, RTI_TRACE_AFTER, &scratch);
    }
}

/* Closest and any hits of one tracer, asked as a coherent batch, against the judge's; some rays are left out behind the count. */
static void compare_coherent(batch *b, const rtk_scene *s, const rti_tracer *tracer, const char *what)
{
    rti_scratch scratch = {.room = test_room(), .times = b->times};
    memcpy(b->other, b->hits, sizeof b->hits);
    tracer->intersect(s, b->rays, b->other, BATCH - 5, RTI_TRACE_COHERENT, &scratch);
    same_hits(b, what, tracer->name, b->hits, b->other);
    tracer->occluded(s, b->rays, b->occluded_other, BATCH - 5, RTI_TRACE_COHERENT, &scratch);
    for (uint32_t i = 0; i < BATCH - 5; i++)
        if ((b->occluded_other[i / RTK_BLOCK] >> i % RTK_BLOCK & 1u) !=
            (b->hits[i / RTK_BLOCK].prim[i % RTK_BLOCK] != RTK_INVALID))
            fail_msg("%s, %s: ray %u (kind %d) of a coherent batch: any hit and closest hit disagree", what, tracer->name, i,
                     b->kinds[i]);
}

/* Each ray by itself. */
static void compare_alone(batch *b, const rtk_scene *s, const rti_tracer *tracer)
{
    for (uint32_t i = 0; i < BATCH; i++) {
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
static void compare(batch *b, const rtk_scene *s, const rti_tracer *tracer, const char *what)
{
    rti_scratch scratch = {.room = test_room(), .times = b->times},
                turns = {.room = test_room(), .times = b->times, .turns = true};
    const bool wide = tracer->tree == RTK_TREE_BVH || tracer->tree == RTK_TREE_KD;
    for (int way = 0; way <= wide; way++) {
        tracer->intersect(s, b->rays, b->other, BATCH, 0, way ? &turns : &scratch);
        same_hits(b, way ? "by turns" : what, tracer->name, b->hits, b->other);
    }
    if (wide) {
        tracer->occluded(s, b->rays, b->occluded_other, BATCH, 0, &turns);
        assert_memory_equal(b->occluded, b->occluded_other, sizeof b->occluded);
    }
    if (tracer->tree != RTK_TREE_NONE)
        compare_alone(b, s, tracer);
    tracer->occluded(s, b->rays, b->occluded_other, BATCH, 0, &scratch);
    for (uint32_t i = 0; i < BATCH; i++) {
        unsigned hit = b->hits[i / RTK_BLOCK].prim[i % RTK_BLOCK] != RTK_INVALID;
        if ((b->occluded[i / RTK_BLOCK] >> i % RTK_BLOCK & 1u) != hit ||
            (b->occluded_other[i / RTK_BLOCK] >> i % RTK_BLOCK & 1u) != hit)
            fail_msg("%s, %s: ray %u (kind %d): any hit and closest hit disagree", what, tracer->name, i, b->kinds[i]);
    }
    for (int step = 0; step < 2 * STEPS; step++) { /* walks that count are others */
        memcpy(b->other, b->from[step / 2], sizeof b->hits);
        tracer->intersect(s, b->rays, b->other, BATCH, RTI_TRACE_AFTER | (step % 2 ? RTI_TRACE_STEPS : 0), &scratch);
        same_hits(b, what, tracer->name, b->next[step / 2], b->other);
    }
}

/* Every tracer against the judge over `count` rays. */
static void sweep(const test_world *w, const rti_tracer *judge, uint64_t count, const char *what)
{
    static batch b;
    test_targets t;
    test_rng rng = {0x1234567};
    uint64_t hits = 0, done = 0;
    test_targets_init(&t, w);
    for (; done < count; done += BATCH) {
        fill(&b, &t, &rng);
        ask_judge(&b, &w->scene, judge, true);
        for (uint32_t i = 0; i < rti_tracer_count(); i++)
            if (rti_tracer_at(test_isa(), i) != judge && rti_tracer_at(test_isa(), i)->tree != RTK_TREE_NONE)
                compare(&b, &w->scene, rti_tracer_at(test_isa(), i), what);
        for (uint32_t i = 0; i < BATCH; i++)
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

/* The closest hits alone of every tracer against brute force (of many triangles: against test_closest_ask, which leaves out what
 * is far), which is asked once a batch: `count` random rays and as many aimed ones. One batch of aimed rays in a hundred is of
 * denormal ones: they take brute force fifteen times as long as others. */
static void sweep_closest(const test_world *w, uint64_t count, const char *what)
{
    static batch b;
    test_closest judge;
    test_targets t;
    test_rng rng = {0x7654321};
    test_targets_init(&t, w);
    test_closest_open(&judge, &w->scene);
    for (uint64_t done = 0; done < 2 * count; done += BATCH) {
        if (done < count)
            fill_kinds(&b, &t, &rng, TEST_RAY_RANDOM, 1);
        else if (done / BATCH % 100 == 0)
            fill_kinds(&b, &t, &rng, TEST_RAY_DENORMAL, 1);
        else
            fill_kinds(&b, &t, &rng, TEST_RAY_RANDOM + 1, TEST_RAY_DENORMAL - TEST_RAY_RANDOM - 1);
        test_closest_ask(&judge, b.rays, b.hits, BATCH);
        for (uint32_t i = 0; i < rti_tracer_count(); i++) {
            if (rti_tracer_at(test_isa(), i)->tree == RTK_TREE_NONE)
                continue;
            rti_tracer_at(test_isa(), i)->intersect(&w->scene, b.rays, b.other, BATCH, 0, &(rti_scratch){.room = test_room()});
            same_hits(&b, what, rti_tracer_at(test_isa(), i)->name, b.hits, b.other);
        }
    }
    test_closest_close(&judge);
    test_targets_free(&t);
    print_message("%s: closest hits of %llu random and as many aimed rays against brute force, none differs\n", what,
                  (unsigned long long)count);
}

static uint64_t closest_count(void)
{
    const char *full = getenv("LIBRT_FULL"), *closest = getenv("LIBRT_CLOSEST");
    return closest ? strtoull(closest, NULL, 10) : (full && full[0] == '1' ? 10000000u : 0u);
}

static rt_context *context(void)
{
    rt_context_desc d = rt_context_desc_default();
    rt_context *ctx;
    d.workers = 1;
    assert_int_equal(rt_context_create(&d, &ctx), RT_OK);
    return ctx;
}

/* One mesh as the whole scene, by both kd builders, for rays against brute force; closest: for so many by their closest hits
 * alone.
 */
static void sweep_mesh(test_mesh *m, float scale, float move, uint64_t count, uint64_t closest, const char *what)
{
    rt_context *ctx = context();
    test_mesh_place(m, scale, move);
    for (uint32_t builder = RTI_BUILD_KD_EXACT; builder <= RTI_BUILD_KD_BINNED; builder++) {
        test_world w;
        test_world_init(&w, ctx);
        test_world_mesh(&w, 0, m, 0xffffffffu);
        assert_int_equal(test_world_commit(&w, &(rti_build_settings){.builder = builder}), RT_OK);
        sweep(&w, rti_tracer_find(test_isa(), "brute"), count, what);
        if (closest)
            sweep_closest(&w, closest, what);
        test_world_free(&w);
    }
    test_mesh_free(m);
    rt_context_destroy(ctx);
}

static void test_soup(void **state)
{
    test_mesh m = {0};
    (void)state;
    test_mesh_soup(&m, 800, 0.2f, 5);
    test_mesh_soup(&m, 8, 3.0f, 6);
    sweep_mesh(&m, 1.0f, 0.0f, test_ray_count(), closest_count(), "soup");
}

/* The other builders of the BVH: long triangles among small ones, which spatial splits cut often, and shapes beside them. */
static void test_bvh_builders(void **state)
{
    static const uint32_t builders[] = {RTI_BUILD_BVH_COMPACT, RTI_BUILD_BVH_SPATIAL};
    (void)state;
    for (int i = 0; i < 2; i++) {
        rt_context *ctx = context();
        test_mesh m = {0};
        test_world w;
        rtk_shape balls[20] = {{0}};
        test_rng rng = {3};
        test_mesh_soup(&m, 600, 0.1f, 7);
        test_mesh_soup(&m, 60, 4.0f, 8);
        for (int k = 0; k < 20; k++)
            for (int a = 0; a < 4; a++)
                balls[k].p[a] = a < 3 ? test_range(&rng, -1.0f, 1.0f) : 0.1f;
        test_world_init(&w, ctx);
        w.bvh_builder = builders[i];
        test_world_mesh(&w, 0, &m, 0xffffffffu);
        test_world_shapes(&w, 0, balls, 20, 0xffffffffu);
        assert_int_equal(test_world_commit(&w, NULL), RT_OK);
        const rtk_tree_header *h = w.parts[0].chunks[2];
        assert_int_equal(h->kind, RTK_TREE_BVH);
        assert_int_equal(h->block_count == 0, i == 0);
        assert_true((h->ref_count - h->filler_count > m.count + 20) == (i == 1));
        sweep(&w, rti_tracer_find(test_isa(), "brute"), test_ray_count() / 2, i ? "bvh, spatial" : "bvh, compact");
        test_world_free(&w);
        test_mesh_free(&m);
        rt_context_destroy(ctx);
    }
}

static void test_slivers(void **state)
{
    test_mesh m = {0};
    (void)state;
    test_mesh_slivers(&m, 600);
    sweep_mesh(&m, 1.0f, 0.0f, test_ray_count(), 0, "slivers");
}

static void test_lattice(void **state)
{
    test_mesh m = {0};
    (void)state;
    test_mesh_lattice(&m, 10);
    sweep_mesh(&m, 1.0f, 0.0f, test_ray_count(), 0, "lattice");
}

static void test_nested(void **state)
{
    test_mesh m = {0};
    (void)state;
    test_mesh_nested(&m, 40);
    sweep_mesh(&m, 1.0f, 0.0f, test_ray_count(), 0, "nested boxes");
}

/* The promises table's scales and moves; extents are about 2. */
static void test_scaled_and_moved(void **state)
{
    static const float places[][2] = {{1.0e-3f, 0.0f}, {1.0e6f, 0.0f}, {1.0f, 2.0e4f}, {1.0e-3f, 20.0f}, {1.0e6f, -2.0e10f}};
    (void)state;
    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++) {
        test_mesh m = {0};
        test_mesh_soup(&m, 300, 0.2f, 9);
        test_mesh_lattice(&m, 5);
        sweep_mesh(&m, places[i][0], places[i][1], test_ray_count() / 4, 0, "soup and lattice, scaled and moved");
    }
}

/* Bodies of very different sizes, some twice and some inside others: balls, or boxes, of which some are flat and some stand wall
 * to wall. */
static void make_bodies(rtk_shape *bodies, int count, bool boxes)
{
    test_rng rng = {41};
    memset(bodies, 0, (size_t)count * sizeof *bodies);
    for (int i = 0; i < count; i++) {
        float *p = bodies[i].p;
        if (i % 8 == 7) {
            memcpy(p, bodies[i - 1].p, sizeof bodies[i].p);
            p[3] *= i % 16 == 7 || boxes ? 1.0f : 0.99f;
        } else {
            for (int a = 0; a < 3; a++)
                p[a] = test_range(&rng, -1.0f, 1.0f);
            p[3] = powf(10.0f, test_range(&rng, -3.0f, -0.3f));
        }
        if (!boxes)
            continue;
        bodies[i].type = RTK_SHAPE_BOX;
        for (int a = 0; a < 3 && i % 8 != 7; a++)
            p[3 + a] = p[a] + (i % 5 == a ? 1.0e-6f : test_range(&rng, 0.01f, 0.4f));
        if (i % 8 == 6) { /* on the one before */
            p[1] = bodies[i - 1].p[4];
            p[4] = p[1] + 0.2f;
        }
    }
}

/* What packets ask in lanes, and all rays see: bodies, and planes, one of them twice; then planes beside triangles alone. */
static void test_bodies_and_planes(void **state)
{
    static const float planes[3][6] = {{0, -0.7f, 0, 0.1f, 1, 0.2f}, {0, -0.7f, 0, 0.1f, 1, 0.2f}, {3, 0, 0, -1, 0, 0}};
    static const char *const words[] = {"spheres", "spheres, planes", "planes", "boxes", "boxes, planes"};
    (void)state;
    for (int way = 0; way < 5; way++) {
        rt_context *ctx = context();
        test_world w;
        rtk_shape bodies[160];
        test_mesh m = {0};
        make_bodies(bodies, 160, way > 2);
        test_world_init(&w, ctx);
        test_mesh_soup(&m, 60, 0.3f, 42);
        test_world_mesh(&w, 0, &m, 0xffffffffu);
        for (int i = 0; i < 3 && strstr(words[way], "planes"); i++)
            test_world_plane(&w, 0, planes[i], planes[i] + 3, 0xffffffffu);
        if (way != 2)
            test_world_shapes(&w, 0, bodies, 160, 0xffffffffu);
        assert_int_equal(test_world_commit(&w, NULL), RT_OK);
        assert_true(w.scene.groups->flags & RTK_GROUP_PLAIN);
        sweep(&w, rti_tracer_find(test_isa(), "brute"), test_ray_count() / 2, words[way]);
        test_world_free(&w);
        test_mesh_free(&m);
        rt_context_destroy(ctx);
    }
}

static void test_shapes(void **state)
{
    rt_context *ctx = context();
    test_world w;
    rtk_shape shapes[200];
    test_mesh m = {0};
    (void)state;
    test_world_init(&w, ctx);
    test_mesh_soup(&m, 100, 0.3f, 11);
    test_world_mesh(&w, 0, &m, 3);
    test_world_shapes(&w, 0, shapes, test_shapes_of_all_kinds(shapes, 100, 12), 0xfffffffdu);
    test_world_plane(&w, 0, (const float[3]){0, -0.5f, 0}, (const float[3]){0.1f, 1, 0.2f}, 4);
    test_world_shapes(&w, 0, shapes, test_shapes_of_all_kinds(shapes, 100, 13), 5);
    assert_int_equal(test_world_commit(&w, NULL), RT_OK);
    sweep(&w, rti_tracer_find(test_isa(), "brute"), test_ray_count(), "shapes, masks, a plane");
    test_world_free(&w);
    test_mesh_free(&m);
    rt_context_destroy(ctx);
}

/* The map of material 1 takes hits away, and only the map does. */
static void sees_through(test_world *w, rtk_material *materials)
{
    static batch b;
    test_targets t;
    test_rng rng = {34};
    rti_scratch scratch = {.room = test_room()};
    uint32_t farther = 0;
    test_targets_init(&t, w);
    fill(&b, &t, &rng);
    test_targets_free(&t);
    rti_tracer_find(test_isa(), "kdtree")->intersect(&w->scene, b.rays, b.hits, BATCH, 0, &scratch);
    materials[1].alpha_tex = RTK_INVALID;
    rti_tracer_find(test_isa(), "kdtree")->intersect(&w->scene, b.rays, b.other, BATCH, 0, &scratch);
    for (uint32_t i = 0; i < BATCH; i++) {
        assert_true(b.hits[i / RTK_BLOCK].t[i % RTK_BLOCK] >= b.other[i / RTK_BLOCK].t[i % RTK_BLOCK]);
        farther += b.hits[i / RTK_BLOCK].t[i % RTK_BLOCK] > b.other[i / RTK_BLOCK].t[i % RTK_BLOCK];
    }
    assert_in_range(farther, BATCH / 20, BATCH);
}

/* Cut-outs by a checkered alpha map over triangles (their weights are its coordinates), shapes and a plane, in a group and in
 * instances. */
static void test_alpha(void **state)
{
    struct {
        rtk_texture_header head;
        uint8_t texels[64][4];
    } map;
    rt_context *ctx = context();
    test_world w;
    rtk_shape shapes[60];
    test_mesh m = {0};
    rtk_material materials[2];
    rtk_texture texture = {&map.head};
    test_rng r = {31};
    float to_world[12];
    (void)state;
    memset(&map, 0, sizeof map);
    map.head.width = map.head.height = 8;
    map.head.level_count = 1;
    map.head.flags = RTK_TEX_ALPHA;
    map.head.off_level[0] = sizeof map.head;
    for (int i = 0; i < 64; i++)
        map.texels[i][3] = (i / 8 + i) % 2 ? 255 : 0;
    memset(materials, 0, sizeof materials);
    materials[0].alpha_tex = RTK_INVALID;
    materials[1].alpha_tex = 0;
    materials[1].alpha_cut = 0.5f;
    test_world_init(&w, ctx);
    test_mesh_soup(&m, 200, 0.5f, 32);
    uint32_t child = test_world_group(&w);
    for (uint32_t group = 0; group <= child; group++) {
        test_world_mesh(&w, group, &m, 0xffffffffu);
        test_world_shapes(&w, group, shapes, test_shapes_of_all_kinds(shapes, 60, 33 + group), 0xffffffffu);
        for (uint32_t k = 0; k < w.parts[group].geom_count; k++) {
            w.parts[group].geoms[k].flags = RTK_GEOM_ALPHA;
            w.parts[group].geoms[k].material = 1;
        }
    }
    test_world_plane(&w, 0, (const float[3]){0, -0.3f, 0}, (const float[3]){0, 1, 0}, 0xffffffffu);
    w.parts[0].geoms[2].flags = RTK_GEOM_ALPHA;
    w.parts[0].geoms[2].material = 1;
    w.parts[0].geoms[2].t_dir[0] = 1.0f;
    for (int i = 0; i < 6; i++) {
        test_random_map(&r, 2.0f, 0.5f, to_world);
        test_world_instance(&w, child, to_world, 0xffffffffu);
        w.instances[i].material = i == 0 ? 0 : RTK_INVALID; /* the first has the material without a map */
    }
    w.scene.materials = materials;
    w.scene.material_count = 2;
    w.scene.textures = &texture;
    w.scene.texture_count = 1;
    assert_int_equal(test_world_commit(&w, NULL), RT_OK);
    sweep(&w, rti_tracer_find(test_isa(), "brute"), test_ray_count(), "cut-outs");
    sees_through(&w, materials);
    test_world_free(&w);
    test_mesh_free(&m);
    rt_context_destroy(ctx);
}

static void sweep_instances(float spread, float scale, bool moving, const char *what)
{
    rt_context *ctx = context();
    test_world w;
    test_mesh m = {0}, n = {0};
    rtk_shape shapes[20];
    test_rng r = {99};
    float map[12];
    test_world_init(&w, ctx);
    test_mesh_soup(&m, 60, 0.4f, 21);
    test_mesh_lattice(&n, 3);
    test_world_mesh(&w, 0, &n, 0xffffffffu);
    uint32_t a = test_world_group(&w), b = test_world_group(&w), c = test_world_group(&w);
    test_world_mesh(&w, a, &m, 0xffffffffu);
    test_world_shapes(&w, b, shapes, test_shapes_of_all_kinds(shapes, 20, 22), 7);
    test_world_mesh(&w, b, &n, 0xffffffffu);
    test_world_mesh(&w, c, &n, 0xffffffffu);
    test_world_plane(&w, c, (const float[3]){0, 0, 0}, (const float[3]){1, 2, 3}, 2);
    for (int i = 0; i < 24; i++) {
        test_random_map(&r, spread, scale, map);
        test_world_instance(&w, i % 8 == 7 ? c : (i % 2 ? a : b), map, i % 5 == 4 ? 2u : 0xffffffffu);
        for (int try = 0; moving && i % 4 != 3 && try < 20; try++) {
            float way[3][12];
            for (int k = 0; k < 3; k++)
                test_random_map(&r, spread, scale, way[k]);
            if (test_world_move(&w, (const float(*)[12])way, 1 + (uint32_t)i % 3))
                break;
        }
        if (i % 6 == 5) /* the same again: equal t, the instance decides */
            test_world_instance(&w, i % 8 == 7 ? c : (i % 2 ? a : b), map, 0xffffffffu);
    }
    assert_true(!moving || w.motion_count > 15);
    assert_int_equal(test_world_commit(&w, NULL), RT_OK);
    sweep(&w, rti_tracer_find(test_isa(), "brute"), test_ray_count() / 2, what); /* of six */
    test_world_free(&w);
    test_mesh_free(&m);
    test_mesh_free(&n);
    rt_context_destroy(ctx);
}

static void test_instances(void **state)
{
    (void)state;
    sweep_instances(2.0f, 0.5f, false, "instances");
    sweep_instances(100.0f, 3.0f, false, "instances far apart");
    sweep_instances(0.01f, 0.002f, false, "small instances");
    sweep_instances(2.0f, 0.5f, true, "moving instances");
    sweep_instances(100.0f, 3.0f, true, "moving instances far apart");
    sweep_instances(0.01f, 0.002f, true, "small moving instances");
}

static void test_meshes(void **state)
{
    static const char *const all[] = {"bunny", "sponza", "sibenik", "spot"};
    const char *only = getenv("LIBRT_MESH"), *const *names = only ? &only : all;
    (void)state;
    for (size_t i = 0; i < (only ? 1 : sizeof all / sizeof all[0]); i++) {
        rt_context *ctx;
        test_world w;
        test_mesh m = {0};
        if (strcmp(names[i], "globe") == 0) {
            test_mesh_globe(&m, 707); /* a million triangles */
        } else if (!test_mesh_load(&m, names[i])) {
            print_message("%s: not there, left out\n", names[i]);
            continue;
        }
        ctx = context();
        test_world_init(&w, ctx);
        test_world_mesh(&w, 0, &m, 0xffffffffu);
        assert_int_equal(test_world_commit(&w, NULL), RT_OK);
        sweep(&w, rti_tracer_find(test_isa(), "kdtree"), test_ray_count() / 4, names[i]);
        sweep(&w, rti_tracer_find(test_isa(), "brute"), test_ray_count() / 100, names[i]);
        if (closest_count())
            sweep_closest(&w, closest_count(), names[i]);
        test_world_free(&w);
        test_mesh_free(&m);
        rt_context_destroy(ctx);
    }
}

static void test_nothing(void **state)
{
    rt_context *ctx = context();
    test_world w;
    batch *b = calloc(1, sizeof *b);
    test_mesh m = {0};
    test_targets t;
    test_rng rng = {3};
    (void)state;
    test_mesh_soup(&m, 3, 1.0f, 1);
    test_world_init(&w, ctx);
    test_world_mesh(&w, 0, &m, 1);
    assert_int_equal(test_world_commit(&w, NULL), RT_OK);
    test_targets_init(&t, &w);
    fill(b, &t, &rng);
    test_world_free(&w);
    test_world_init(&w, ctx);
    assert_int_equal(test_world_commit(&w, NULL), RT_OK);
    for (uint32_t i = 0; i < rti_tracer_count(); i++) {
        rti_scratch scratch = {.room = test_room()};
        rti_tracer_at(test_isa(), i)->intersect(&w.scene, b->rays, b->hits, BATCH, 0, &scratch);
        rti_tracer_at(test_isa(), i)->occluded(&w.scene, b->rays, b->occluded, BATCH, 0, &scratch);
        for (uint32_t k = 0; k < BATCH; k++) {
            assert_int_equal(b->hits[k / RTK_BLOCK].prim[k % RTK_BLOCK], RTK_INVALID);
            assert_true(b->hits[k / RTK_BLOCK].t[k % RTK_BLOCK] == b->rays[k / RTK_BLOCK].tmax[k % RTK_BLOCK]);
            assert_int_equal(b->occluded[k / RTK_BLOCK], 0);
        }
    }
    test_targets_free(&t);
    test_world_free(&w);
    test_mesh_free(&m);
    free(b);
    rt_context_destroy(ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_nothing),          cmocka_unit_test(test_soup),    cmocka_unit_test(test_bvh_builders),
        cmocka_unit_test(test_slivers),          cmocka_unit_test(test_lattice), cmocka_unit_test(test_nested),
        cmocka_unit_test(test_scaled_and_moved), cmocka_unit_test(test_shapes),  cmocka_unit_test(test_bodies_and_planes),
        cmocka_unit_test(test_instances),        cmocka_unit_test(test_meshes),  cmocka_unit_test(test_alpha),
    };
    if (getenv("LIBRT_ONLY"))
        cmocka_set_test_filter(getenv("LIBRT_ONLY"));
    return cmocka_run_group_tests(tests, NULL, NULL);
}
