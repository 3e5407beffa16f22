/* Batches of rays that start far away from what they meet, whose origins are moved (trace/bvh_moved.h): every tracer against
 * brute force, bit for bit. Triangles and bodies stand so near behind each other, or twice, that the sums which are t of their
 * hits are equal, and brute force's next hits say that there are such; rays end and begin at hits and right beside them. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <math.h>
#include <string.h>

#include "support/generate.h"
#include "support/rays.h"
#include "trace/lane.h"

#define MOST 18432u /* more than go at a time */
#define ALL  0xffffffffu

typedef struct answers {
    rtk_hit_block hits[MOST / RTK_BLOCK];
    uint16_t occluded[MOST / RTK_BLOCK];
} answers;

static rtk_trace_block rays[MOST / RTK_BLOCK];
static answers brute, other;

/* far: how far from the middle rays start; together: runs of 256 at one point; length: of directions. */
typedef struct kind {
    float far;
    bool together;
    float length;
    uint32_t count;
} kind;

static void put(uint32_t i, rtk_vec3 org, rtk_vec3 dir)
{
    rtk_trace_block *b = &rays[i / RTK_BLOCK];
    const uint32_t k = i % RTK_BLOCK;
    b->ox[k] = org.x;
    b->oy[k] = org.y;
    b->oz[k] = org.z;
    b->dx[k] = dir.x;
    b->dy[k] = dir.y;
    b->dz[k] = dir.z;
    b->tmin[k] = 0.0f;
    b->tmax[k] = RTK_INF;
    b->mask[k] = i % 97 ? ALL : 0u;
}

static rtk_vec3 anywhere(test_rng *rng, float size)
{
    const float x = test_range(rng, -size, size), y = test_range(rng, -size, size);
    return rtk_v3(x, y, test_range(rng, -size, size));
}

/* Most rays start far away, some near by, some nowhere; they go to points of triangles, their corners and edges, or past all. */
static void fill(const kind *a, const test_targets *t, uint64_t seed)
{
    test_rng rng = {seed};
    rtk_vec3 from = rtk_v3(0, 0, a->far);
    for (uint32_t i = 0; i < MOST; i++) {
        const rtk_tri *tri = &t->tris.tris[test_u32(&rng) % t->tris.count];
        const float u = i % 5 == 1 ? 0.0f : test_range(&rng, 0.0f, 0.5f), v = i % 5 < 3 ? 0.0f : test_range(&rng, 0.0f, 0.5f);
        rtk_vec3 p = rtk_v3(tri->v0[0] + u * (tri->v1[0] - tri->v0[0]) + v * (tri->v2[0] - tri->v0[0]),
                            tri->v0[1] + u * (tri->v1[1] - tri->v0[1]) + v * (tri->v2[1] - tri->v0[1]),
                            tri->v0[2] + u * (tri->v1[2] - tri->v0[2]) + v * (tri->v2[2] - tri->v0[2]));
        if (i % 8 == 7)
            p = anywhere(&rng, 2.0f);
        if (i % (a->together ? 256 : 1) == 0)
            from = rtk_scale(rtk_unit(anywhere(&rng, 1.0f)), a->far * test_range(&rng, 0.8f, 1.2f));
        if (!a->together && i % 9 == 0)
            from = anywhere(&rng, 1.0f);
        put(i, from, rtk_scale(rtk_unit(rtk_sub(p, from)), a->length));
        if (a->far > 1e6f && i % 2 == 0) /* others miss from there */
            put(i, rtk_v3(p.x, p.y, a->far), rtk_v3(0, 0, -a->length));
        if (i % 101 == 0)
            rays[i / RTK_BLOCK].dy[i % RTK_BLOCK] = NAN;
        if (i % 103 == 0)
            rays[i / RTK_BLOCK].ox[i % RTK_BLOCK] = i % 2 ? INFINITY : 1e30f;
    }
}

/* Brute force's hits, which ranges are then made of: ends and beginnings at a hit, right beside it, or somewhere. */
static void limit(const rtk_scene *s, uint32_t count, uint64_t seed)
{
    test_rng rng = {seed};
    rti_scratch scratch = {0};
    test_judge()->intersect(s, rays, brute.hits, count, 0, &scratch);
    for (uint32_t i = 0; i < count; i++) {
        rtk_trace_block *b = &rays[i / RTK_BLOCK];
        const uint32_t k = i % RTK_BLOCK;
        const float t = brute.hits[i / RTK_BLOCK].t[k];
        const float at[] = {t, nextafterf(t, INFINITY), nextafterf(t, 0.0f), t * test_range(&rng, 0.5f, 1.5f)};
        const float some = at[test_u32(&rng) % 4];
        if (brute.hits[i / RTK_BLOCK].prim[k] == RTK_INVALID)
            continue;
        switch (test_u32(&rng) % 8) {
        case 0:
            b->tmin[k] = some;
            break;
        case 1:
            b->tmax[k] = some;
            break;
        case 2:
            b->tmin[k] = nextafterf(t, 0.0f);
            b->tmax[k] = nextafterf(t, INFINITY);
            break;
        case 3:
            b->tmin[k] = i % 2 ? -INFINITY : -t;
            b->tmax[k] = i % 3 ? 2.0f * t : 1e30f;
            break;
        default:
            break;
        }
    }
}

static void ask(const rtk_scene *s, const rti_tracer *tracer, uint32_t count, uint32_t flags, answers *a)
{
    rti_scratch scratch = {.room = test_room(), .bare = true};
    memset(a, 0x55, sizeof *a);
    tracer->intersect(s, rays, a->hits, count, flags, &scratch);
    tracer->occluded(s, rays, a->occluded, count, flags, &scratch);
}

/* Each ray by itself. */
static void ask_alone(const rtk_scene *s, const rti_tracer *tracer, uint32_t count, answers *a)
{
    for (uint32_t i = 0; i < count; i++) {
        const rtk_trace_block *b = &rays[i / RTK_BLOCK];
        const uint32_t k = i % RTK_BLOCK;
        const rti_ray ray = {{b->ox[k], b->oy[k], b->oz[k]}, b->tmin[k], {b->dx[k], b->dy[k], b->dz[k]}, b->tmax[k], b->mask[k]};
        rti_hit hit;
        tracer->one(s, &ray, 0.0f, &hit);
        if (hit.prim != RTK_INVALID && /* brute force was not asked for these of bodies */
            s->groups[hit.inst == RTK_INVALID ? 0u : s->instances[hit.inst].group].geoms[hit.geom].type == RTK_GEOM_SHAPES)
            hit.u = hit.v = 0.0f;
        rti_lane_occluded(a->occluded, i, tracer->one(s, &ray, 0.0f, NULL));
        rti_lane_keep(a->hits, i, (rtk_hit){hit.t, hit.u, hit.v, hit.prim, hit.geom, hit.inst});
    }
}

static void compare(const char *what, const kind *a, const char *name, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        const rtk_hit_block *p = &brute.hits[i / RTK_BLOCK], *q = &other.hits[i / RTK_BLOCK];
        const uint32_t k = i % RTK_BLOCK;
        const bool hidden = brute.occluded[i / RTK_BLOCK] >> k & 1u;
        if (rtk_bits(p->t[k]) != rtk_bits(q->t[k]) || rtk_bits(p->u[k]) != rtk_bits(q->u[k]) ||
            rtk_bits(p->v[k]) != rtk_bits(q->v[k]) || p->prim[k] != q->prim[k] || p->geom[k] != q->geom[k] ||
            p->inst[k] != q->inst[k])
            fail_msg("%s from %g, %s, %u rays: ray %u: brute t %a prim %u geom %u, here t %a prim %u geom %u", what,
                     (double)a->far, name, count, i, (double)p->t[k], p->prim[k], p->geom[k], (double)q->t[k], q->prim[k],
                     q->geom[k]);
        if (hidden != (other.occluded[i / RTK_BLOCK] >> k & 1u))
            fail_msg("%s from %g, %s, %u rays: ray %u: brute says %d of any hit", what, (double)a->far, name, count, i, hidden);
    }
}

/* How many rays have another hit of the same t. */
static uint32_t ties(const rtk_scene *s, uint32_t count)
{
    static rtk_hit_block next[MOST / RTK_BLOCK];
    rti_scratch scratch = {.bare = true};
    uint32_t n = 0;
    memcpy(next, brute.hits, sizeof next);
    test_judge()->intersect(s, rays, next, count, RTI_TRACE_AFTER, &scratch);
    for (uint32_t i = 0; i < count; i++) {
        const rtk_hit_block *h = &next[i / RTK_BLOCK];
        n += h->prim[i % RTK_BLOCK] != RTK_INVALID && h->t[i % RTK_BLOCK] == brute.hits[i / RTK_BLOCK].t[i % RTK_BLOCK];
    }
    return n;
}

static void sweep(const char *what, test_world *w)
{
    static const kind kinds[] = {{9.0f, true, 1.0f, MOST},       {9.0f, false, 1.0f, MOST}, {300.0f, true, 3.0f, 2048},
                                 {300.0f, false, 0.01f, 2048},   {2e4f, true, 1e5f, 5003},  {2e4f, false, 1.0f, 5003},
                                 {5e6f, true, 1e-12f, 256 + 30}, {5e6f, false, 1.0f, MOST}, {1e14f, false, 2e-18f, 2048},
                                 {1e17f, false, 3e-18f, 2048}};
    /* Where fewer will do, a world has every other kind, near and far, together and not, one in three with as many rays. */
    static uint32_t turn;
    const rti_tracer *judge = test_judge();
    test_targets t;
    turn++;
    test_targets_init(&t, w);
    for (size_t n = 0; n < sizeof kinds / sizeof *kinds; n++) {
        const kind *a = &kinds[n];
        const uint32_t count = test_fewer() && turn % 3 ? rtk_umin(a->count, 4099u) : a->count;
        uint32_t hits = 0;
        if (test_fewer() && ((n ^ n >> 1) & 1u) != (turn & 1u))
            continue;
        fill(a, &t, 31 + n);
        limit(&w->scene, count, 77 + n);
        ask(&w->scene, judge, count, 0, &brute);
        for (uint32_t i = 0; i < count; i++)
            hits += brute.hits[i / RTK_BLOCK].prim[i % RTK_BLOCK] != RTK_INVALID;
        assert_in_range(hits, count / (a->far < 1e6f ? 4 : 20), count); /* else the world has lost what this is for */
        assert_in_range(ties(&w->scene, count), count / 50, count);
        for (uint32_t i = 0; i < 2 * rti_tracer_count(); i++) {
            const rti_tracer *tracer = rti_tracer_at(test_isa(), i / 2);
            if (tracer->tree == RTK_TREE_NONE)
                continue;
            ask(&w->scene, tracer, count, i % 2 ? RTI_TRACE_COHERENT : 0, &other);
            compare(what, a, tracer->name, count);
            if (i % 2)
                continue;
            ask_alone(&w->scene, tracer, rtk_umin(count, 3000u), &other);
            compare(what, a, tracer->name, rtk_umin(count, 3000u));
        }
    }
    test_targets_free(&t);
}

/* Triangles four times: as they are, twice, and by a little apart; later ones before them. */
static void make_triangles(test_mesh *m)
{
    test_mesh soup = {0};
    test_rng rng = {3};
    test_mesh_soup(&soup, 150, 0.5f, 5);
    for (int copy = 0; copy < 4; copy++)
        for (uint32_t i = 0; i < soup.count; i++) {
            const rtk_tri *t = &soup.tris[i];
            const float by = copy < 2 ? 0.0f : copy == 2 ? 2e-7f : test_range(&rng, -1e-5f, 1e-5f);
            float v[3][3];
            for (int a = 0; a < 3; a++) {
                v[0][a] = t->v0[a] + by;
                v[1][a] = t->v1[a] + by;
                v[2][a] = t->v2[a] + by;
            }
            test_mesh_add(m, v[0], v[1], v[2]);
        }
    test_mesh_free(&soup);
}

static void make_bodies(rtk_shape *bodies, uint32_t count)
{
    test_rng rng = {4};
    memset(bodies, 0, count * sizeof *bodies);
    for (uint32_t i = 0; i < count; i++) {
        float *p = bodies[i].p;
        bodies[i].type = i % 4 < 2 ? RTK_SHAPE_SPHERE : i % 4 == 2 ? RTK_SHAPE_BOX : RTK_SHAPE_CONE;
        for (int a = 0; a < 3; a++)
            p[a] = test_range(&rng, -1.0f, 1.0f);
        if (i % 4 == 1) /* the one before, or a little smaller */
            memcpy(p, bodies[i - 1].p, sizeof bodies[i].p);
        p[3] = i % 4 == 1 ? p[3] * (i % 8 == 1 ? 1.0f : 0.9999998f) : test_range(&rng, 0.05f, 0.4f);
        for (int a = 0; a < 3 && i % 4 >= 2; a++)
            p[i % 4 == 2 ? 3 + a : 4 + a] = p[a] + test_range(&rng, 0.05f, 0.5f);
        p[7] = 0.1f;
    }
}

/* An empty world, and the triangles for it. */
typedef struct stage {
    rt_context *ctx;
    test_world world;
    test_mesh mesh;
} stage;

static void stage_open(stage *s)
{
    rt_context_desc d = rt_context_desc_default();
    memset(s, 0, sizeof *s);
    d.workers = 1;
    assert_int_equal(rt_context_create(&d, &s->ctx), RT_OK);
    test_world_init(&s->world, s->ctx);
    make_triangles(&s->mesh);
}

/* The world is whole: tries it, and ends. */
static void stage_sweep(const char *what, stage *s)
{
    assert_int_equal(test_world_commit(&s->world, NULL), RT_OK);
    sweep(what, &s->world);
    test_world_free(&s->world);
    test_mesh_free(&s->mesh);
    rt_context_destroy(s->ctx);
}

/* 0: triangles, 1: with planes, 2: bodies, 3: bodies with planes, 4: triangles of which some rays see nothing, 5: triangles and
 * some bodies. */
static void test_groups(void **state)
{
    static const char *const words[] = {"triangles",      "triangles, planes",     "bodies",
                                        "bodies, planes", "triangles under masks", "triangles, bodies"};
    (void)state;
    for (int way = 0; way < 6; way++) {
        rtk_shape bodies[160];
        stage s;
        stage_open(&s);
        make_bodies(bodies, 160);
        if (way < 2 || way > 3)
            test_world_mesh(&s.world, 0, &s.mesh, way == 4 ? 0x7fffffffu : ALL);
        if (way == 2 || way == 3)
            test_world_shapes(&s.world, 0, bodies, 160, ALL);
        if (way == 5)
            test_world_shapes(&s.world, 0, bodies, 40, ALL);
        if (way == 1 || way == 3) {
            test_world_plane(&s.world, 0, (const float[3]){0, -0.3f, 0}, (const float[3]){0.1f, 1, 0.2f}, ALL);
            test_world_plane(&s.world, 0, (const float[3]){0, -0.3f, 0}, (const float[3]){0.1f, 1, 0.2f}, ALL);
        }
        stage_sweep(words[way], &s);
    }
}

/* A group in instances, each far from the others as it is large. */
static void test_placed_groups(void **state)
{
    uint32_t group;
    stage s;
    (void)state;
    stage_open(&s);
    group = test_world_group(&s.world);
    test_world_mesh(&s.world, group, &s.mesh, ALL);
    for (int i = 0; i < 6; i++) {
        float map[12] = {0.05f, 0, 0, (float)(i % 3) - 1.0f, 0, 0.05f, 0, 0.3f * (float)(i / 3), 0, 0, 0.05f, 0.1f * (float)i};
        test_world_instance(&s.world, group, map, ALL);
    }
    stage_sweep("instances", &s);
}

/* The scene's only instance, which is its top level: 0: triangles, turned; 1: as they stand, and as many of the scene's own,
 * which are as near; 2: bodies; 3: triangles and bodies; 4: under a mask, away from the middle; 5: small and far out, so that
 * rays which the top level moves start far away yet. */
static void test_only_instance(void **state)
{
    static const char *const words[] = {"one of triangles",         "one beside its like", "one of bodies",
                                        "one of triangles, bodies", "one under a mask",    "one far out"};
    static const float maps[6][12] = {
        {0.36f, -0.48f, 0.8f, 0.1f, 0.8f, 0.6f, 0, -0.2f, -0.48f, 0.64f, 0.6f, 0.3f},
        {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0},
        {0.5f, 0, 0, 0.2f, 0, -0.7f, 0, 0, 0, 0, 0.6f, 0.1f},
        {-0.6f, 0.1f, 0, 0, 0, 0.5f, 0.2f, 0.3f, 0.1f, 0, 0.7f, 0},
        {0.5f, 0, 0, 0.9f, 0, 0.5f, 0, -0.7f, 0, 0, 0.5f, 0.8f},
        {0.004f, 0, 0, 0.9f, 0, 0.004f, 0, -0.7f, 0, 0, 0.004f, 0.8f},
    };
    (void)state;
    for (int way = 0; way < 6; way++) {
        rtk_shape bodies[160];
        stage s;
        uint32_t group;
        stage_open(&s);
        make_bodies(bodies, 160);
        group = test_world_group(&s.world);
        if (way != 2)
            test_world_mesh(&s.world, group, &s.mesh, ALL);
        if (way == 2 || way == 3)
            test_world_shapes(&s.world, group, bodies, way == 2 ? 160 : 40, ALL);
        if (way == 1)
            test_world_mesh(&s.world, 0, &s.mesh, ALL);
        test_world_instance(&s.world, group, maps[way], way == 4 ? 0x7fffffffu : ALL);
        stage_sweep(words[way], &s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_groups), cmocka_unit_test(test_placed_groups),
                                       cmocka_unit_test(test_only_instance)};
    (void)test_isa();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
