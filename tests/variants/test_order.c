/* Rays that are not coherent, in batches long enough to be brought in order (trace/bvh_order.h): every tracer against brute
 * force, bit for bit. Rays beside each other that point everywhere, rays that start all over the scene and take their time there,
 * and such rays where hardly anything is. Among them are rays that are none, and ones that see nothing. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <math.h>
#include <string.h>

#include "support/generate.h"
#include "support/rays.h"

#define MOST (4096u + 1024u)

typedef struct answers {
    rtk_hit_block hits[MOST / RTK_BLOCK];
    uint16_t occluded[MOST / RTK_BLOCK];
} answers;

static rtk_trace_block rays[MOST / RTK_BLOCK];
static answers brute, other;

/* near: so far from the middle do runs of 256 start, each run within a thousandth of that; 0: rays start anywhere within `size`.
 */
static void fill(float near, float size, uint64_t seed)
{
    test_rng rng = {seed};
    float middle[3] = {0};
    for (uint32_t i = 0; i < MOST; i++) {
        rtk_trace_block *b = &rays[i / RTK_BLOCK];
        const uint32_t k = i % RTK_BLOCK;
        float *org[3] = {&b->ox[k], &b->oy[k], &b->oz[k]}, *dir[3] = {&b->dx[k], &b->dy[k], &b->dz[k]};
        for (int a = 0; a < 3; a++) {
            if (near > 0.0f && i % 256 == 0)
                middle[a] = test_range(&rng, -near, near);
            *org[a] = near > 0.0f ? middle[a] + 1e-3f * test_range(&rng, -near, near) : test_range(&rng, -size, size);
            *dir[a] = test_range(&rng, -1.0f, 1.0f);
        }
        b->tmin[k] = 0.0f;
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
    }
}

static void ask(const rtk_scene *s, const rti_tracer *tracer, uint32_t count, uint32_t flags, answers *a)
{
    rti_scratch scratch = {0};
    memset(a, 0x55, sizeof *a);
    tracer->intersect(s, rays, a->hits, count, flags, &scratch);
    tracer->occluded(s, rays, a->occluded, count, flags, &scratch);
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

/* All tracers with batches of several lengths; least, most: how many of MOST rays are to hit. */
static void sweep(const rtk_scene *s, const char *what, uint32_t least, uint32_t most)
{
    static const uint32_t counts[] = {MOST, MOST - 5, 4096, 2049, 1024, 300, 70, 64, 15, 8, 1};
    const rti_tracer *judge = rti_tracer_find(test_isa(), "brute");
    uint32_t hits = 0;
    ask(s, judge, MOST, 0, &brute);
    for (uint32_t i = 0; i < MOST; i++)
        hits += brute.hits[i / RTK_BLOCK].prim[i % RTK_BLOCK] != RTK_INVALID;
    assert_in_range(hits, least, most);
    for (uint32_t i = 0; i < rti_tracer_count(); i++)
        for (uint32_t c = 0; c < sizeof counts / sizeof *counts; c++) {
            const rti_tracer *tracer = rti_tracer_at(test_isa(), i);
            if (tracer == judge)
                continue;
            ask(s, tracer, counts[c], 0, &other);
            compare(what, tracer->name, counts[c]);
        }
}

/* mask: of the geometry; one that is not full keeps rays from the quickest ways. */
static void with_mesh(const test_mesh *m, uint32_t mask, float near, float size, const char *what, uint32_t least, uint32_t most)
{
    rt_context_desc d = rt_context_desc_default();
    rt_context *ctx;
    test_world w;
    d.workers = 1;
    assert_int_equal(rt_context_create(&d, &ctx), RT_OK);
    test_world_init(&w, ctx);
    test_world_mesh(&w, 0, m, mask);
    assert_int_equal(test_world_commit(&w, NULL), RT_OK);
    fill(near, size, 11);
    sweep(&w.scene, what, least, most);
    test_world_free(&w);
    rt_context_destroy(ctx);
}

static void test_room(void **state)
{
    test_mesh m = {0};
    (void)state;
    test_mesh_soup(&m, 800, 0.2f, 5);
    test_mesh_soup(&m, 8, 3.0f, 6);
    with_mesh(&m, 0xffffffffu, 0.5f, 0.0f, "rays beside each other", MOST / 2, MOST);
    with_mesh(&m, 0x7fffffffu, 0.5f, 0.0f, "rays beside each other, masks", MOST / 2, MOST);
    with_mesh(&m, 0xffffffffu, 0.0f, 1.5f, "rays all over", MOST / 4, MOST);
    test_mesh_free(&m);
}

/* Six small triangles, and two far away that make the scene large. */
static void test_emptiness(void **state)
{
    test_mesh m = {0};
    (void)state;
    test_mesh_soup(&m, 6, 1.0f, 5);
    for (int i = 0; i < 2; i++) {
        const float x = i ? 20.0f : -20.0f;
        test_mesh_add(&m, (float[3]){x, x, x}, (float[3]){x + 1.0f, x, x}, (float[3]){x, x + 1.0f, x});
    }
    with_mesh(&m, 0xffffffffu, 0.0f, 20.0f, "rays all over nothing", 1, MOST / 4);
    with_mesh(&m, 0xffffffffu, 3.0f, 0.0f, "rays beside each other by nothing", 1, MOST / 2);
    test_mesh_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_room), cmocka_unit_test(test_emptiness)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
