/* Rays that are not coherent, in batches long enough for streams to fill and run before their end (trace/bvh_stream.h): every
 * tracer against brute force, bit for bit. Rays beside each other that point everywhere, or all into one octant; rays that start
 * all over the scene; such rays where hardly anything is, beside a plane, among geometry of two sizes, where every box holds all
 * others, so that lists find no room, and where hits lie so near that their t are denormal. Among them are rays that are none,
 * and ones that see nothing. Each batch once by the way of small trees, once by that of large ones, and once without a room. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <math.h>
#include <string.h>

#include "support/generate.h"
#include "support/many.h"
#include "support/parts.h"
#include "support/rays.h"

#define MOST (8192u + 2048u)
#define LONG 20480u /* longer than what is told about parts */
#define FEW  2048u  /* for what brute force takes long for */

typedef struct answers {
    rtk_hit_block hits[LONG / RTK_BLOCK];
    uint16_t occluded[LONG / RTK_BLOCK];
} answers;

static rtk_trace_block rays[LONG / RTK_BLOCK];
static answers brute, other;

/* What the rays are. near: so far from the middle do runs of 256 start, each run within a thousandth of that; 0: rays start
 * anywhere within `size`. */
typedef struct kind {
    const char *what;
    float near, size;
    uint32_t octant;             /* all point into octant `octant` - 1; 0: everywhere */
    uint32_t mask;               /* of the geometry; one that is not full keeps rays from the quickest ways */
    bool plane, shapes;          /* there is one, are some, too */
    uint32_t count, least, most; /* how many rays, and of how many there are to be hits */
    bool crowded;                /* lists of the BVH's streams find no room where they are few */
    float shrink, length;        /* unless 0: origins, tmax and directions are so many times as large */
} kind;

enum way {
    ROOM,   /* with a room */
    TURNS,  /* by turns in it */
    NARROW, /* with few lists */
    ROOMY,  /* with long streams; many rays by octants first */
    ALONE,  /* without a room */
    WAYS
};

static void fill(const kind *of, uint64_t seed)
{
    const float near = of->near, size = of->size;
    test_rng rng = {seed};
    float middle[3] = {0};
    for (uint32_t i = 0; i < LONG; i++) {
        rtk_trace_block *b = &rays[i / RTK_BLOCK];
        const uint32_t k = i % RTK_BLOCK;
        float *org[3] = {&b->ox[k], &b->oy[k], &b->oz[k]}, *dir[3] = {&b->dx[k], &b->dy[k], &b->dz[k]};
        for (int a = 0; a < 3; a++) {
            if (near > 0.0f && i % 256 == 0)
                middle[a] = test_range(&rng, -near, near);
            *org[a] = near > 0.0f ? middle[a] + 1e-3f * test_range(&rng, -near, near) : test_range(&rng, -size, size);
            *dir[a] = test_range(&rng, of->octant ? 0.001f : -1.0f, 1.0f);
            if (of->octant && (of->octant - 1) >> a & 1u)
                *dir[a] = -*dir[a];
        }
        b->tmin[k] = i % 7 == 3 ? (i % 2 ? -INFINITY : -size) : 0.0f;
        b->tmax[k] = i % 5 ? RTK_INF : test_range(&rng, 0.0f, 2.0f);
        b->mask[k] = i % 97 ? 0xffffffffu : 0u;
        if (i % 101 == 0)
            *dir[i % 3] = NAN;
        if (i % 103 == 0)
            *org[i % 3] = i % 2 ? INFINITY : NAN;
        if (i % 107 == 0)
            *dir[0] = *dir[1] = *dir[2] = 0.0f;
        if (i % 109 == 0)
            *dir[i % 3] = i % 2 ? 0.0f : -0.0f;
        if (i % 113 == 0)
            b->tmax[k] = -1.0f;
        for (int a = 0; a < 3 && of->length > 0.0f; a++) {
            *org[a] *= of->shrink;
            *dir[a] *= of->length;
        }
        if (of->length > 0.0f)
            b->tmax[k] = b->tmax[k] * of->shrink / of->length;
    }
}

static void ask(const rtk_scene *s, const rti_tracer *tracer, uint32_t count, enum way way, bool crowded, answers *a)
{
    rti_scratch scratch = {.room = way == ALONE ? NULL : test_room(),
                           .turns = way == TURNS,
                           .narrow = way == NARROW,
                           .roomy = way == ROOMY,
                           .learned.octants = way == ROOMY};
    memset(a, 0x55, sizeof *a);
    tracer->intersect(s, rays, a->hits, count, 0, &scratch);
    if (crowded && scratch.stats.crowded == 0)
        fail_msg("%s: no ray for closest hits left its stream", tracer->name);
    scratch.stats.crowded = 0;
    tracer->occluded(s, rays, a->occluded, count, 0, &scratch);
    if (crowded && scratch.stats.crowded == 0)
        fail_msg("%s: no ray for any hits left its stream", tracer->name);
    assert_int_equal(scratch.stats.rays, 2 * count);
}

static void compare(const char *what, const char *name, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        const rtk_hit_block *p = &brute.hits[i / RTK_BLOCK], *q = &other.hits[i / RTK_BLOCK];
        const uint32_t k = i % RTK_BLOCK;
        const bool hidden = brute.occluded[i / RTK_BLOCK] >> k & 1u;
        const bool same = rtk_bits(p->t[k]) == rtk_bits(q->t[k]) && rtk_bits(p->u[k]) == rtk_bits(q->u[k]) &&
                          rtk_bits(p->v[k]) == rtk_bits(q->v[k]) && p->prim[k] == q->prim[k] && p->geom[k] == q->geom[k] &&
                          p->inst[k] == q->inst[k];
        if (!same)
            fail_msg("%s, %s, %u rays: ray %u: brute t %a prim %u, here t %a prim %u", what, name, count, i, p->t[k], p->prim[k],
                     q->t[k], q->prim[k]);
        if (hidden != (other.occluded[i / RTK_BLOCK] >> k & 1u))
            fail_msg("%s, %s, %u rays: ray %u: brute says %d of any hit", what, name, count, i, hidden);
    }
}

/* All tracers with batches of several lengths. */
static void sweep(const rtk_scene *s, const kind *a)
{
    const uint32_t counts[] = {a->count, a->count - 5, 4096, 1024, 300, 70, 64, 15, 8, 1};
    static uint32_t turn; /* where fewer will do, each batch goes every other way, under a sanitizer every fourth */
    const rti_tracer *judge = test_judge();
    uint32_t hits = 0;
    turn++;
    ask(s, judge, a->count, ALONE, false, &brute);
    for (uint32_t i = 0; i < a->count; i++)
        hits += brute.hits[i / RTK_BLOCK].prim[i % RTK_BLOCK] != RTK_INVALID;
    assert_in_range(hits, a->least, a->most);
    for (uint32_t i = 0; i < rti_tracer_count(); i++)
        for (uint32_t c = 0; c < WAYS * (sizeof counts / sizeof *counts); c++) {
            const rti_tracer *tracer = rti_tracer_at(test_isa(), i);
            const uint32_t count = counts[c / WAYS];
            const enum way way = (enum way)(c % WAYS);
            const bool crowds = a->crowded && way == NARROW && count == MOST;
            if (test_fewer() && !crowds && (c / WAYS + c % WAYS + turn) % (TEST_SANITIZED ? 4 : 2) != 0)
                continue;
            if (tracer->tree == RTK_TREE_NONE || count > a->count)
                continue;
            ask(s, tracer, count, way, crowds && tracer->tree == RTK_TREE_BVH, &other);
            compare(a->what, tracer->name, count);
        }
}

static rt_context *context(void)
{
    rt_context_desc d = rt_context_desc_default();
    rt_context *ctx;
    d.workers = 1;
    assert_int_equal(rt_context_create(&d, &ctx), RT_OK);
    return ctx;
}

static void below(test_world *w)
{
    test_world_plane(w, 0, (float[3]){0.0f, -0.25f, 0.0f}, (float[3]){0.1f, 1.0f, -0.2f}, 0xffffffffu);
}

static void with_mesh(const test_mesh *m, const kind *a)
{
    enum { SHAPES = 60 };
    rtk_shape shapes[SHAPES];
    rt_context *ctx = context();
    test_world w;
    test_world_init(&w, ctx);
    test_world_mesh(&w, 0, m, a->mask);
    if (a->plane)
        below(&w);
    if (a->shapes)
        test_world_shapes(&w, 0, shapes, test_shapes_of_all_kinds(shapes, SHAPES, 12), a->mask);
    assert_int_equal(test_world_commit(&w, NULL), RT_OK);
    fill(a, 11);
    sweep(&w.scene, a);
    test_world_free(&w);
    rt_context_destroy(ctx);
}

#define ALL 0xffffffffu

static void test_room_of_triangles(void **state)
{
    const kind kinds[] = {
        {.what = "rays beside each other", .near = 0.5f, .mask = ALL, .count = MOST, .least = MOST / 2, .most = MOST},
        {.what = "into the first octant", .near = 0.5f, .octant = 1, .mask = ALL, .count = MOST, .least = MOST / 2, .most = MOST},
        {.what = "into the last octant", .near = 0.5f, .octant = 8, .mask = ALL, .count = MOST, .least = MOST / 2, .most = MOST},
        {.what = "beside each other, masks", .near = 0.5f, .mask = 0x7fffffffu, .count = FEW, .least = FEW / 2, .most = FEW},
        {.what = "beside a plane", .near = 0.5f, .mask = ALL, .plane = true, .count = FEW, .least = FEW / 2, .most = FEW},
        {.what = "beside shapes", .near = 0.5f, .mask = ALL, .shapes = true, .count = MOST, .least = MOST / 2, .most = MOST},
        {.what = "rays all over", .size = 1.5f, .mask = ALL, .count = MOST, .least = MOST / 4, .most = MOST}};
    test_mesh m = {0};
    (void)state;
    test_mesh_soup(&m, 800, 0.2f, 5);
    test_mesh_soup(&m, 8, 3.0f, 6);
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        with_mesh(&m, &kinds[i]);
    test_mesh_free(&m);
}

/* Six small triangles, and two far away that make the scene large. */
static void test_emptiness(void **state)
{
    const kind kinds[] = {
        {.what = "rays all over nothing", .size = 20.0f, .mask = ALL, .count = MOST, .least = 1, .most = MOST / 4},
        {.what = "rays beside each other by nothing", .near = 3.0f, .mask = ALL, .count = MOST, .least = 1, .most = MOST / 2}};
    test_mesh m = {0};
    (void)state;
    test_mesh_soup(&m, 6, 1.0f, 5);
    for (int i = 0; i < 2; i++) {
        const float x = i ? 20.0f : -20.0f;
        test_mesh_add(&m, (float[3]){x, x, x}, (float[3]){x + 1.0f, x, x}, (float[3]){x, x + 1.0f, x});
    }
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        with_mesh(&m, &kinds[i]);
    test_mesh_free(&m);
}

/* Parts with trees of their own: rays of which few come near the smaller ones, and ones that meet all. */
static void test_sizes(void **state)
{
    const kind kinds[] = {
        {.what = "sizes, far away", .size = 40.0f, .mask = ALL, .count = LONG, .least = 1, .most = LONG / 4},
        {.what = "sizes, beside each other", .near = 0.05f, .mask = ALL, .count = LONG, .least = LONG / 2, .most = LONG},
        {.what = "sizes, all over", .size = 1.5f, .mask = ALL, .count = LONG, .least = LONG / 4, .most = LONG},
        {.what = "sizes, a plane", .near = 0.05f, .mask = ALL, .plane = true, .count = FEW, .least = FEW / 2, .most = FEW}};
    (void)state;
    for (size_t i = 0; i < 2 * sizeof kinds / sizeof *kinds; i++) {
        const kind *of = &kinds[i / 2];
        rt_context *ctx = context();
        test_parts parts;
        test_world w;
        test_world_init(&w, ctx);
        if (of->plane)
            below(&w);
        assert_int_equal(test_parts_init(&parts, &w, i % 2 ? RTK_PARTS : 2, i % 2 ? 0.1f : 0.01f, 300, 0.3f), RT_OK);
        fill(of, 11);
        sweep(&w.scene, of);
        test_parts_free(&parts, &w);
        rt_context_destroy(ctx);
    }
}

/* Triangles as large as all of them together: a ray enters nearly every box, and lists are as long as streams. */
static void test_no_room(void **state)
{
    const kind kinds[] = {{.what = "no room",
                           .near = 0.5f,
                           .octant = 6,
                           .mask = ALL,
                           .count = MOST,
                           .least = MOST / 2,
                           .most = MOST,
                           .crowded = true}};
    test_mesh m = {0};
    (void)state;
    test_mesh_soup(&m, 2000, 3.0f, 9);
    with_mesh(&m, &kinds[0]);
    test_mesh_free(&m);
}

/* Hits at denormal t: a sheet as small and directions as long as may be, where a rounding is no small part of a number. */
static void test_denormal(void **state)
{
    const kind kinds[] = {{.what = "denormal",
                           .size = 2.0f,
                           .mask = ALL,
                           .count = 4096,
                           .least = 128,
                           .most = 2048,
                           .shrink = 1e-26f,
                           .length = 1e18f},
                          {.what = "nearly denormal",
                           .size = 2.0f,
                           .mask = ALL,
                           .count = 4096,
                           .least = 128,
                           .most = 2048,
                           .shrink = 1e-20f,
                           .length = 1e16f}};
    (void)state;
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
        test_rng rng = {3};
        test_mesh m = {0};
        for (int i = 0; i < 64; i++) {
            float v[3][3];
            for (int a = 0; a < 9; a++)
                v[a / 3][a % 3] =
                    kinds[k].shrink * (a % 3 == 2 ? 0.3f + test_range(&rng, -1e-6f, 1e-6f) : test_range(&rng, -1.0f, 1.0f));
            test_mesh_add(&m, v[0], v[1], v[2]);
        }
        with_mesh(&m, &kinds[k]);
        test_mesh_free(&m);
    }
}

/* Coordinates whose products of three fit no float: beyond what scenes take (1e12), within what the kernels promise. */
static void test_huge(void **state)
{
    const float scales[] = {1e12f, 3e12f, 4e12f, 6e12f, 9e12f, 2e13f, 1e15f, 1e17f};
    (void)state;
    for (size_t i = 0; i < sizeof scales / sizeof *scales; i++) {
        const kind of = {.what = "huge",
                         .size = 1.5f,
                         .mask = ALL,
                         .count = FEW,
                         .least = FEW / 4,
                         .most = FEW,
                         .shrink = scales[i],
                         .length = 1.0f};
        test_mesh m = {0};
        test_mesh_soup(&m, 600, 0.02f, 5);
        test_mesh_soup(&m, 40, 2.0f, 6);
        test_mesh_place(&m, scales[i], 0.0f);
        with_mesh(&m, &of);
        test_mesh_free(&m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_room_of_triangles), cmocka_unit_test(test_emptiness), cmocka_unit_test(test_sizes),
        cmocka_unit_test(test_no_room),           cmocka_unit_test(test_denormal),  cmocka_unit_test(test_huge)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
