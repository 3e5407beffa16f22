/* Rays that pass through one point, in coherent batches, which go through trees as pencils (trace/pencil.h): every tracer against
 * brute force, bit for bit, closest and any hits. From an eye, to a point light, and from a point behind where they start, as
 * mirrors make them; at triangles' insides, corners and edges and beside them, spread or in narrow tiles; the point anywhere, on
 * a corner, in a triangle's plane, or with zeros of either sign; among them rays that miss the point, that are none, or that see
 * nothing. Triangles small and large, needles, a lattice where many are met at one distance, geometry of two sizes, scenes scaled
 * and moved, by all builders. That such rays did go as pencils is asked, too. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "support/generate.h"
#include "support/judge.h"
#include "support/many.h"
#include "support/parts.h"
#include "support/rays.h"
#include "trace/lane.h"

#define BATCH  1024u
#define MOST   4096u
#define ROUNDS (TEST_SANITIZED || test_fewer() ? 8u : 12u)

static rtk_trace_block rays[MOST / RTK_BLOCK];
static rtk_hit_block want[MOST / RTK_BLOCK], got[MOST / RTK_BLOCK];
static uint16_t hidden[MOST / RTK_BLOCK], seen[MOST / RTK_BLOCK];

enum way { EYE, LIGHT, MIRROR, CAMERA, WAYS };
static const char *const way_names[WAYS] = {"from an eye", "to a light", "from behind", "from a camera"};

typedef struct point {
    double x[3];
} point;

static point of(const float v[3])
{
    return (point){{v[0], v[1], v[2]}};
}

/* A point of a triangle: a corner, on an edge, inside, or a little beside it. */
static point aim(const test_targets *t, test_rng *rng)
{
    const rtk_tri *tri = &t->tris.tris[test_u32(rng) % t->tris.count];
    const float *v[3] = {tri->v0, tri->v1, tri->v2};
    double w[3] = {test_unit(rng), test_unit(rng), test_unit(rng)}, sum;
    point p = {{0.0}};
    switch (test_u32(rng) % 5) {
    case 0:
        return of(v[test_u32(rng) % 3]);
    case 1:
        w[test_u32(rng) % 3] = 0.0;
        break;
    case 2:
        w[0] = -0.01 * w[0];
        break;
    default:
        break;
    }
    sum = w[0] + w[1] + w[2] + 1e-9;
    for (int i = 0; i < 9; i++)
        p.x[i % 3] += w[i / 3] / sum * v[i / 3][i % 3];
    return p;
}

/* Where rays pass through. */
static point apex_of(const test_targets *t, test_rng *rng, uint32_t kind)
{
    point p, q;
    switch (kind % 6) {
    case 0:
        return aim(t, rng);
    case 1: /* on a line through two points of it */
        p = aim(t, rng);
        q = aim(t, rng);
        for (int a = 0; a < 3; a++)
            p.x[a] = (float)(2.0 * p.x[a] - q.x[a]);
        return p;
    default:
        for (int a = 0; a < 3; a++)
            p.x[a] = (float)(0.5 * (t->lo[a] + t->hi[a]) + t->extent * test_range(rng, -1.2f, 1.2f));
        if (kind % 6 == 2)
            p.x[test_u32(rng) % 3] = test_u32(rng) % 2 ? 0.0 : -0.0;
        return p;
    }
}

static void put(uint32_t i, const point *org, const double dir[3], double tmin, double tmax)
{
    rtk_trace_block *b = &rays[i / RTK_BLOCK];
    const uint32_t k = i % RTK_BLOCK;
    b->ox[k] = (float)org->x[0];
    b->oy[k] = (float)org->x[1];
    b->oz[k] = (float)org->x[2];
    b->dx[k] = (float)dir[0];
    b->dy[k] = (float)dir[1];
    b->dz[k] = (float)dir[2];
    b->tmin[k] = (float)tmin;
    b->tmax[k] = (float)tmax;
    b->mask[k] = 0xffffffffu;
}

/* Where ray i of a camera's 64 x 64 passes the middle of the scene, blocks of 4 x 4 by rows, seen from an apex. */
static point pixel(const test_targets *t, const point *apex, uint32_t i)
{
    const uint32_t block = i / RTK_BLOCK, k = i % RTK_BLOCK;
    const uint32_t plane[2] = {block % 16u * 4u + k % 4u, block / 16u * 4u + k / 4u};
    point p;
    int depth = 0;
    for (int a = 0; a < 3; a++) {
        p.x[a] = 0.5 * (t->lo[a] + t->hi[a]);
        if (fabs(apex->x[a] - p.x[a]) > fabs(apex->x[depth] - p.x[depth]))
            depth = a;
    }
    for (int a = 1; a < 3; a++)
        p.x[(depth + a) % 3] += t->extent * ((plane[a - 1] + 0.5) / 64.0 - 0.5);
    return p;
}

/* Makes a ray invalid, in turn by each of what rtk_ray_valid asks for, among rays that are of a pencil. */
static void spoil(rtk_trace_block *b, uint32_t k, uint32_t how)
{
    float *const org[3] = {b->ox, b->oy, b->oz}, *const dir[3] = {b->dx, b->dy, b->dz};
    const uint32_t axis = how % 3u;
    switch (how / 3u % 9u) {
    case 0:
        org[axis][k] = NAN;
        break;
    case 1:
        org[axis][k] = -RTK_INF;
        break;
    case 2:
        dir[axis][k] = RTK_INF;
        break;
    case 3:
        b->tmin[k] = b->tmax[k];
        break;
    case 4:
        b->tmax[k] = NAN;
        break;
    case 5:
        b->tmin[k] = NAN;
        break;
    case 6:
        dir[axis][k] = NAN;
        break;
    default: /* along the line that it was on, but too short, or too long */
        for (uint32_t a = 0; a < 3; a++)
            dir[a][k] *= axis == 0u ? 0.0f : (axis == 1u ? 1e-33f : 1e33f);
    }
}

/* So far behind their eye some rays begin, and end as far before it. */
static double behind_eye;

/* So many times its extent a scene's lights are farther away. */
static double light_away;

/* Rays of a way, 512 or 256 of them through a point, of a camera all. */
static void fill(const test_targets *t, test_rng *rng, enum way way, uint32_t round)
{
    point apex = {{0.0}}, center = {{0.0}};
    const uint32_t tile = way == CAMERA ? MOST : (round % 6 == 5 ? 256 : 512);
    bool narrow = false, zero = false;
    for (uint32_t i = 0; i < MOST; i++) {
        if (i % tile == 0) {
            apex = apex_of(t, rng, round + i / tile);
            for (int a = 0; a < 3; a++) /* a little beside what it lies on */
                apex.x[a] = (float)(apex.x[a] + (behind_eye > 0.0 ? behind_eye * (test_unit(rng) - 0.5) : 0.0));
            apex.x[0] = (float)(apex.x[0] + (way == LIGHT ? light_away * t->extent : 0.0));
            center = aim(t, rng);
            narrow = test_u32(rng) % 2;
            zero = test_u32(rng) % 2;
        }
        point at = way == CAMERA ? pixel(t, &apex, i) : aim(t, rng), org = apex;
        double dir[3], length = 0.0, tmin = 0.0, tmax = (double)RTK_INF;
        for (int a = 0; a < 3; a++) {
            if (narrow && way != CAMERA)
                at.x[a] = center.x[a] + 0.03 * t->extent * (test_unit(rng) - 0.5);
            dir[a] = at.x[a] - apex.x[a];
            length += dir[a] * dir[a];
        }
        length = sqrt(length);
        if (way == LIGHT) {
            org = at;
            tmax = 1.0;
            for (int a = 0; a < 3; a++) {
                org.x[a] = (float)(at.x[a] + (zero ? 0.0 : 1e-4 * t->extent * (test_unit(rng) - 0.5)));
                dir[a] = (float)(apex.x[a] - org.x[a]);
                if (round % 2 && length > 0.0) { /* of length 1, and an end a little before the light */
                    dir[a] /= length;
                    tmax = length * (1.0 - 1e-6);
                }
            }
        } else if (way == MIRROR) {
            const double s = 0.2 + test_unit(rng);
            for (int a = 0; a < 3; a++)
                org.x[a] += s * dir[a];
        }
        if (way == EYE && behind_eye > 0.0 && i % 5 == 4 && length > 0.0) {
            const double s = behind_eye * test_unit(rng) / length;
            for (int a = 0; a < 3; a++)
                org.x[a] -= s * dir[a];
            tmax = 2.0 * s * test_unit(rng);
        }
        if (i % 7 == 0)
            tmax *= test_unit(rng);
        if (i % 11 == 0)
            tmin = length > 0.0 ? (round % 3 - 1.0) * 0.1 : 0.0;
        put(i, &org, dir, tmin, tmax);
        rtk_trace_block *b = &rays[i / RTK_BLOCK];
        const uint32_t k = i % RTK_BLOCK;
        if (i % 67 == 66)
            b->oy[k] += 1e-3f * t->extent;
        if (i % 97 == 96) {
            b->mask[k] = i % 2 ? 0u : 1u;
            if (way == EYE && round % 2) { /* what is not of a pencil says nothing of where its rays begin */
                b->ox[k] -= 100.0f * b->dx[k];
                b->oy[k] -= 100.0f * b->dy[k];
                b->oz[k] -= 100.0f * b->dz[k];
            }
        }
        if (round % 5 == 4 && (i + 16) % tile < 32) /* the first block of a tile, and the last, have no rays to guess by */
            b->dz[k] = NAN;
        if (i % 101 == 100 || i % 103 == 102)
            spoil(b, k, round + i / 101);
    }
}

#define WHOLE_BLOCKS(count) (((count) + RTK_BLOCK - 1) / RTK_BLOCK * RTK_BLOCK)

/* behind: from this ray on no hit may be written. */
static void compare(const char *what, enum way way, const char *name, uint32_t count, uint32_t behind)
{
    for (uint32_t i = 0; i < MOST; i++) {
        const rtk_hit_block *p = &want[i / RTK_BLOCK], *q = &got[i / RTK_BLOCK];
        const rtk_trace_block *r = &rays[i / RTK_BLOCK];
        const uint32_t k = i % RTK_BLOCK;
        if (i >= count) {
            if (i >= behind && (q->prim[k] != 0x55555555u || q->inst[k] != 0x55555555u))
                fail_msg("%s, %s, %s: a hit of ray %u is written, behind the last of %u", what, way_names[way], name, i, count);
            continue;
        }
        if (rtk_bits(p->t[k]) != rtk_bits(q->t[k]) || rtk_bits(p->u[k]) != rtk_bits(q->u[k]) ||
            rtk_bits(p->v[k]) != rtk_bits(q->v[k]) || p->prim[k] != q->prim[k] || p->geom[k] != q->geom[k] ||
            p->inst[k] != q->inst[k])
            fail_msg("%s, %s, %s: ray %u org %a %a %a dir %a %a %a range %a %a: brute t %a prim %u, here t %a prim %u", what,
                     way_names[way], name, i, r->ox[k], r->oy[k], r->oz[k], r->dx[k], r->dy[k], r->dz[k], r->tmin[k], r->tmax[k],
                     p->t[k], p->prim[k], q->t[k], q->prim[k]);
        if ((hidden[i / RTK_BLOCK] >> k & 1u) != (seen[i / RTK_BLOCK] >> k & 1u))
            fail_msg("%s, %s, %s: ray %u org %a %a %a dir %a %a %a range %a %a: any hit is %u", what, way_names[way], name, i,
                     r->ox[k], r->oy[k], r->oz[k], r->dx[k], r->dy[k], r->dz[k], r->tmin[k], r->tmax[k],
                     seen[i / RTK_BLOCK] >> k & 1u);
    }
}

/* The judge's any hits are its closest ones, as variants.tracers asks of it. */
static void any_of_closest(uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        rti_lane_occluded(hidden, i, want[i / RTK_BLOCK].prim[i % RTK_BLOCK] != RTK_INVALID);
}

/* Batches of `size` rays and fewer. least: so much of the rays go as pencils, in a hundred. parts, if not NULL: of those
 * to a light that ask for any hit, and of others that ask for the closest, the part that does. */
static void sweep(const test_world *w, uint32_t rounds, uint32_t size, const char *what, unsigned least, double *parts)
{
    test_closest judge;
    uint64_t asked[WAYS] = {0}, together[WAYS] = {0}, closest[WAYS][2] = {{0}}, hits = 0, all = 0;
    test_targets t;
    test_rng rng = {20};
    test_targets_init(&t, w);
    test_closest_open(&judge, &w->scene);
    for (uint32_t round = 0; round < rounds * WAYS; round++) {
        const enum way way = round < rounds * CAMERA ? (enum way)(round % CAMERA) : CAMERA; /* behind the others */
        fill(&t, &rng, way, way == CAMERA ? round - rounds * CAMERA : round / CAMERA);
        test_closest_ask(&judge, rays, want, size);
        any_of_closest(size);
        for (uint32_t i = 0; i < size; i++)
            hits += want[i / RTK_BLOCK].prim[i % RTK_BLOCK] != RTK_INVALID;
        all += size;
        for (uint32_t i = 0; i < rti_tracer_count(); i++) {
            const rti_tracer *tracer = rti_tracer_at(test_isa(), i);
            const uint32_t count = size - (round % 4) * (size / 12);
            rti_scratch scratch = {.room = round % 5 ? test_room() : NULL};
            if (tracer->tree == RTK_TREE_NONE)
                continue;
            memset(got, 0x55, sizeof got);
            tracer->intersect(&w->scene, rays, got, count, RTI_TRACE_COHERENT, &scratch);
            if (tracer->tree == RTK_TREE_BVH) {
                closest[way][0] += scratch.stats.together;
                closest[way][1] += count;
            }
            if (way == LIGHT) /* closest hits of rays that run to one point are no pencil's */
                scratch.stats.together = 0;
            tracer->occluded(&w->scene, rays, seen, count, RTI_TRACE_COHERENT, &scratch);
            /* What goes on as others do is written by whole blocks; here an octree's does. */
            compare(what, way, tracer->name, count,
                    tracer->tree == RTK_TREE_OCTREE && scratch.learned.apart[0] ? WHOLE_BLOCKS(count) : count);
            if (tracer->tree == RTK_TREE_BVH) {
                asked[way] += (way == LIGHT ? 1u : 2u) * count;
                together[way] += scratch.stats.together;
            }
        }
    }
    test_closest_close(&judge);
    test_targets_free(&t);
    for (int way = 0; way < WAYS; way++)
        if (together[way] * 100 < asked[way] * least)
            fail_msg("%s, %s: of %llu rays only %llu went as pencils", what, way_names[way], (unsigned long long)asked[way],
                     (unsigned long long)together[way]);
    if (hits * 10 < all)
        fail_msg("%s: only %llu of %llu rays hit: the test tests little", what, (unsigned long long)hits,
                 (unsigned long long)all);
    for (int way = 0; parts && way < WAYS; way++)
        parts[way] =
            way == LIGHT ? (double)together[way] / (double)asked[way] : (double)closest[way][0] / (double)closest[way][1];
}

static rt_context *context(void)
{
    rt_context_desc d = rt_context_desc_default();
    rt_context *ctx;
    d.workers = 1;
    assert_int_equal(rt_context_create(&d, &ctx), RT_OK);
    return ctx;
}

/* So many shapes of all kinds stand beside the mesh, less than are worth another way. */
static uint32_t shapes_beside;

/* A mesh by every builder, or by one of them. */
static void with_mesh_by(test_mesh *m, float scale, float move, const char *what, unsigned least, int only)
{
    static const uint32_t bvh[] = {0, RTI_BUILD_BVH_SPATIAL, RTI_BUILD_BVH_COMPACT};
    rtk_shape shapes[100];
    rt_context *ctx = context();
    test_mesh_place(m, scale, move);
    for (uint32_t i = 0; i < 3; i++) {
        test_world w;
        if (only >= 0 && i != (uint32_t)only)
            continue;
        test_world_init(&w, ctx);
        w.bvh_builder = bvh[i];
        test_world_mesh(&w, 0, m, 0xffffffffu);
        if (shapes_beside > 0)
            test_world_shapes(&w, 0, shapes, test_shapes_of_all_kinds(shapes, shapes_beside, 12), 0xffffffffu);
        assert_int_equal(test_world_commit(&w, &(rti_build_settings){.builder = i ? RTI_BUILD_KD_EXACT : RTI_BUILD_KD_BINNED}),
                         RT_OK);
        sweep(&w, ROUNDS, BATCH, what, bvh[i] == RTI_BUILD_BVH_COMPACT ? 0 : least,
              NULL); /* no blocks of triangles, no pencils */
        test_world_free(&w);
    }
    test_mesh_free(m);
    rt_context_destroy(ctx);
}

static void with_mesh(test_mesh *m, float scale, float move, const char *what, unsigned least)
{
    with_mesh_by(m, scale, move, what, least, -1);
}

/* Alone, and among shapes. */
static void test_soup(void **state)
{
    (void)state;
    for (uint32_t beside = 0; beside <= 100; beside += 100) {
        test_mesh m = {0};
        test_mesh_soup(&m, 800, 0.2f, 5);
        test_mesh_soup(&m, 8, 3.0f, 6);
        shapes_beside = beside;
        with_mesh_by(&m, 1.0f, 0.0f, beside ? "soup among shapes" : "soup", 60, beside && test_fewer() ? 0 : -1);
    }
    shapes_beside = 0;
}

static void test_small(void **state)
{
    test_mesh m = {0};
    (void)state;
    test_mesh_globe(&m, 48);
    with_mesh(&m, 1.0f, 0.0f, "globe", 60);
}

/* A light may be farther away than rays may start. */
static void test_far_light(void **state)
{
    test_mesh m = {0};
    (void)state;
    test_mesh_soup(&m, 400, 0.2f, 7);
    light_away = 20.0;
    with_mesh_by(&m, 1.0f, 0.0f, "far light", 60, 0);
    light_away = 0.0;
}

static void dense_globe(test_world *w, test_mesh *m, rt_context *ctx)
{
    test_mesh_globe(m, 200);
    test_world_init(w, ctx);
    test_world_mesh(w, 0, m, 0xffffffffu);
    assert_int_equal(test_world_commit(w, &(rti_build_settings){.builder = RTI_BUILD_KD_BINNED}), RT_OK);
}

/* Where few rays come to a leaf, pencils give way to streams. */
static void test_scattered(void **state)
{
    rt_context *ctx = context();
    test_mesh m = {0};
    test_world w;
    (void)state;
    dense_globe(&w, &m, ctx);
    double parts[WAYS];
    sweep(&w, 2, MOST, "dense globe", 0, parts);
    for (int way = LIGHT; way <= CAMERA; way += CAMERA - LIGHT)
        if (parts[way] < 0.1 || parts[way] > (way == LIGHT ? 0.7 : 0.85)) /* a camera's .88 and .90 if they did not */
            fail_msg("dense globe: %g of the rays %s go as pencils", parts[way], way_names[way]);
    test_world_free(&w);
    test_mesh_free(&m);
    rt_context_destroy(ctx);
}

/* Small things on a wide floor, in one part: what is found near the eye is held against boxes grown for the floor. */
static void test_floor(void **state)
{
    static const float wide[] = {40.0f, 1000.0f};
    (void)state;
    for (int i = 0; i < 2; i++) {
        const float y = -0.55f, far = wide[i];
        test_mesh m = {0};
        test_mesh_soup(&m, 3000, 0.02f, 5);
        test_mesh_add(&m, (float[3]){-far, y, -far}, (float[3]){far, y, -far}, (float[3]){far, y, far});
        test_mesh_add(&m, (float[3]){-far, y, -far}, (float[3]){far, y, far}, (float[3]){-far, y, far});
        behind_eye = 8e-7 * far; /* no farther than a pencil's rays may */
        with_mesh_by(&m, 1.0f, 0.0f, "on a floor", 20, test_fewer() ? i : -1);
        behind_eye = 0.0;
    }
}

static void test_needles(void **state)
{
    test_mesh m = {0};
    (void)state;
    test_mesh_slivers(&m, 400);
    with_mesh(&m, 1.0f, 0.0f, "slivers", 60);
}

static void test_lattice(void **state)
{
    test_mesh m = {0};
    (void)state;
    test_mesh_lattice(&m, 6);
    with_mesh(&m, 1.0f, 0.0f, "lattice", 60);
}

static void test_nested(void **state)
{
    test_mesh m = {0};
    (void)state;
    test_mesh_nested(&m, 30);
    with_mesh(&m, 1.0f, 0.0f, "nested boxes", 60);
}

static void test_one(void **state)
{
    test_mesh m = {0};
    (void)state;
    test_mesh_soup(&m, 1, 1.0f, 3);
    with_mesh(&m, 1.0f, 0.0f, "one triangle", 20);
}

/* Where products of coordinates are too small or too large no ray goes as a pencil; moved far, rays miss their point by much. */
static void test_scaled_and_moved(void **state)
{
    static const struct {
        float scale, move;
        unsigned least;
    } places[] = {{1e-3f, 0.0f, 60}, {1e6f, 0.0f, 60},  {1e-11f, 0.0f, 60}, {1e-15f, 0.0f, 0},
                  {1e15f, 0.0f, 0},  {1.0f, 20.0f, 60}, {1.0f, 1e4f, 20}};
    (void)state;
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        test_mesh m = {0};
        test_mesh_soup(&m, 300, 0.3f, 5);
        test_mesh_lattice(&m, 3);
        with_mesh_by(&m, places[i].scale, places[i].move, "scaled and moved", places[i].least, test_fewer() ? (int)(i % 3) : -1);
    }
}

/* Planes, one of which the triangles lie in, too, are asked for first. */
static void test_planes(void **state)
{
    rt_context *ctx = context();
    test_world w;
    test_mesh m = {0};
    (void)state;
    test_world_init(&w, ctx);
    test_mesh_soup(&m, 300, 0.3f, 5);
    test_mesh_lattice(&m, 3);
    test_world_mesh(&w, 0, &m, 0xffffffffu);
    test_world_plane(&w, 0, (float[3]){0.0f, -0.25f, 0.0f}, (float[3]){0.1f, 1.0f, -0.2f}, 0xffffffffu);
    test_world_plane(&w, 0, m.tris[m.count - 1].v0, (float[3]){0.0f, 1.0f, 0.0f}, 0xffffffffu);
    assert_int_equal(test_world_commit(&w, NULL), RT_OK);
    sweep(&w, ROUNDS, BATCH, "planes", 10, NULL); /* of any hits many are planes' */
    test_world_free(&w);
    test_mesh_free(&m);
    rt_context_destroy(ctx);
}

static void with_parts(uint32_t triangles, float size, uint32_t rounds, uint32_t batch, const char *what, unsigned least)
{
    rt_context *ctx = context();
    test_parts parts;
    test_world w;
    test_world_init(&w, ctx);
    assert_int_equal(test_parts_init(&parts, &w, 2, 0.01f, triangles, size), RT_OK);
    sweep(&w, rounds, batch, what, least, NULL);
    test_parts_free(&parts, &w);
    rt_context_destroy(ctx);
}

static void test_two_parts(void **state)
{
    (void)state;
    with_parts(300, 0.3f, ROUNDS, BATCH, "two parts", 20);
}

/* So few rays in so large trees that pencils come apart, within the first part or the second. */
static void test_apart(void **state)
{
    (void)state;
    with_parts(20000, 0.005f, 8, 48, "two large parts", 0);
}

/* Batches of many lengths, whole blocks or not, each with what those before have learned. */
static void learned(const test_world *w, const char *what)
{
    static const uint32_t counts[] = {1024, 256, 100, 1000, 37, 300, 64, 48, 2048, 130, 999, 4096, 61, 512, 77, 3001};
    test_closest judge;
    rti_learned known[8] = {{0}};
    uint32_t left = 0, odd = 0;
    test_targets t;
    test_rng rng = {23};
    test_targets_init(&t, w);
    test_closest_open(&judge, &w->scene);
    assert_true(rti_tracer_count() <= 8);
    for (uint32_t round = 0; round < (TEST_SANITIZED ? 1 : (test_fewer() ? 2 : 4)) * (sizeof counts / sizeof *counts); round++) {
        const uint32_t count = counts[round % (sizeof counts / sizeof *counts)];
        const enum way way = round % 8 == 3 ? LIGHT : (round % 8 == 5 ? EYE : CAMERA);
        fill(&t, &rng, way, round);
        test_closest_ask(&judge, rays, want, count);
        any_of_closest(count);
        for (uint32_t i = 0; i < rti_tracer_count(); i++) {
            const rti_tracer *tracer = rti_tracer_at(test_isa(), i);
            rti_scratch scratch = {.room = test_room(), .learned = known[i]};
            if (tracer->tree == RTK_TREE_NONE)
                continue;
            memset(got, 0x55, sizeof got);
            tracer->intersect(&w->scene, rays, got, count, RTI_TRACE_COHERENT, &scratch);
            tracer->occluded(&w->scene, rays, seen, count, RTI_TRACE_COHERENT, &scratch);
            compare(what, way, tracer->name, count, WHOLE_BLOCKS(count)); /* as without a hint */
            for (int any = 0; any < 2 && tracer->tree == RTK_TREE_BVH; any++) {
                left += known[i].left[any] != 0;
                odd += known[i].left[any] != 0 && count % RTK_BLOCK != 0;
            }
            known[i] = scratch.learned;
        }
    }
    test_closest_close(&judge);
    test_targets_free(&t);
    if (left < 8 || odd < 2)
        fail_msg("%s: %u batches began as others, %u of them of no whole blocks: the test tests little", what, left, odd);
}

static void test_learned(void **state)
{
    rt_context *ctx = context();
    test_mesh m = {0};
    test_parts parts;
    test_world w;
    (void)state;
    dense_globe(&w, &m, ctx);
    learned(&w, "dense globe, learned");
    test_world_free(&w);
    test_mesh_free(&m);
    test_world_init(&w, ctx);
    assert_int_equal(test_parts_init(&parts, &w, 2, 0.01f, 20000, 0.005f), RT_OK);
    learned(&w, "two large parts, learned");
    test_parts_free(&parts, &w);
    rt_context_destroy(ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_soup),      cmocka_unit_test(test_small),
                                       cmocka_unit_test(test_far_light), cmocka_unit_test(test_scattered),
                                       cmocka_unit_test(test_floor),     cmocka_unit_test(test_needles),
                                       cmocka_unit_test(test_lattice),   cmocka_unit_test(test_nested),
                                       cmocka_unit_test(test_one),       cmocka_unit_test(test_scaled_and_moved),
                                       cmocka_unit_test(test_planes),    cmocka_unit_test(test_two_parts),
                                       cmocka_unit_test(test_apart),     cmocka_unit_test(test_learned)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
