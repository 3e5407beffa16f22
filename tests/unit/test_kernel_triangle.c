/* The triangle test against long double: every accepted hit's point within RTK_DELTA * scale of the triangle, and no leaks. */
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <setjmp.h>
#include <cmocka.h>

#include "../support/many.h"
#include "kernel/triangle.h"
#include "kernel_random.h"

typedef long double real;
typedef struct real3 {
    real x, y, z;
} real3;

static real3 r3(rtk_vec3 v)
{
    return (real3){v.x, v.y, v.z};
}
static real3 sub(real3 a, real3 b)
{
    return (real3){a.x - b.x, a.y - b.y, a.z - b.z};
}
static real dot(real3 a, real3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static real3 madd(real3 a, real t, real3 d)
{
    return (real3){a.x + t * d.x, a.y + t * d.y, a.z + t * d.z};
}
static real3 cross(real3 a, real3 b)
{
    return (real3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static real3 nearest_on_segment(real3 p, real3 a, real3 b)
{
    real3 e = sub(b, a);
    real l = dot(e, e), t = l > 0 ? dot(sub(p, a), e) / l : 0;
    return madd(a, t < 0 ? 0 : (t > 1 ? 1 : t), e);
}

/* Nearest point of the triangle: of the inside when p projects there, else of an edge. */
static real3 nearest_on_triangle(real3 p, const real3 v[3])
{
    real3 n = cross(sub(v[1], v[0]), sub(v[2], v[0])), best = v[0];
    real nn = dot(n, n), d2 = -1;
    int inside = nn > 0;
    for (int i = 0; i < 3; i++) {
        real3 a = v[i], b = v[(i + 1) % 3], q = nearest_on_segment(p, a, b), d = sub(p, q);
        if (d2 < 0 || dot(d, d) < d2) {
            d2 = dot(d, d);
            best = q;
        }
        if (inside && dot(cross(sub(b, a), sub(p, a)), n) < 0)
            inside = 0;
    }
    return inside ? madd(p, -dot(sub(p, v[0]), n) / nn, n) : best;
}

static real max_norm(real3 d)
{
    real m = fabsl(d.x);
    m = fabsl(d.y) > m ? fabsl(d.y) : m;
    return fabsl(d.z) > m ? fabsl(d.z) : m;
}

static rtk_tri tri_of(rtk_vec3 a, rtk_vec3 b, rtk_vec3 c)
{
    rtk_tri t = {{a.x, a.y, a.z}, {b.x, b.y, b.z}, {c.x, c.y, c.z}, 0, 0, 0};
    return t;
}

/* The hit's point and the scale; false: a miss. */
static bool hit_point(const rtk_vec3 v[3], rtk_vec3 org, rtk_vec3 dir, const rtk_vec3 box[2], real3 *p, real *scale)
{
    rtk_pray r = {0};
    rtk_tri tri = tri_of(v[0], v[1], v[2]);
    float t, b, c;
    if (!prepare(org, dir, -1e30f, 1e30f, box[0], box[1], &r))
        return false;
    r.tshift = 0.0f; /* t along the prepared origin: what trees walk by, before it is rounded into the caller's t */
    if (!rtk_tri_intersect(&r, &tri, &t, &b, &c))
        return false;
    assert_true(b >= 0.0f && c >= 0.0f && b <= 1.0f && c <= 1.0f);
    *p = madd(r3(r.org), t, r3(dir));
    *scale = r.scale;
    return true;
}

/* Distance of the hit's point from the triangle as a part of scale, -1 for a miss. */
static real hit_distance(const rtk_vec3 v[3], rtk_vec3 org, rtk_vec3 dir, const rtk_vec3 box[2])
{
    const real3 w[3] = {r3(v[0]), r3(v[1]), r3(v[2])};
    real3 p;
    real scale;
    return hit_point(v, org, dir, box, &p, &scale) ? max_norm(sub(p, nearest_on_triangle(p, w))) / scale : -1;
}

static real outside(real x, float a, float b, float c)
{
    const real low = fminf(fminf(a, b), c), high = fmaxf(fmaxf(a, b), c);
    return x < low ? low - x : x > high ? x - high : 0;
}

/* The same from the triangle's box: where not even long doubles tell a thin triangle's nearest point. */
static real box_distance(const rtk_vec3 v[3], rtk_vec3 org, rtk_vec3 dir, const rtk_vec3 box[2])
{
    real3 p;
    real scale;
    if (!hit_point(v, org, dir, box, &p, &scale))
        return -1;
    p = (real3){outside(p.x, v[0].x, v[1].x, v[2].x), outside(p.y, v[0].y, v[1].y, v[2].y), outside(p.z, v[0].z, v[1].z, v[2].z)};
    return max_norm(p) / scale;
}

typedef enum shape_kind { RANDOM, SLIVER, HUGE_FLOOR, GRAZING, TINY, KINDS } shape_kind;
static const char *const kind_names[KINDS] = {"random", "sliver", "huge", "grazing", "tiny"};

static void make_triangle(rng *g, shape_kind kind, rtk_vec3 v[3])
{
    rtk_vec3 a = rng_vec(g, 1.0f), b = rng_vec(g, 1.0f), c = rng_vec(g, 1.0f);
    if (kind == SLIVER)
        c = rtk_add(rtk_madd(a, rng_unit(g), rtk_sub(b, a)), rng_vec(g, 1e-6f));
    if (kind == HUGE_FLOOR)
        a.y = b.y = c.y = 0.25f;
    if (kind == TINY) {
        b = rtk_add(a, rng_vec(g, 1e-4f));
        c = rtk_add(a, rng_vec(g, 1e-4f));
    }
    v[0] = a;
    v[1] = b;
    v[2] = c;
}

/* A point to aim at: inside, on an edge, on a vertex. */
static rtk_vec3 aim(rng *g, const rtk_vec3 v[3])
{
    float b = rng_unit(g), c = rng_unit(g) * (1.0f - b);
    uint32_t how = rng_u32(g) % 4;
    if (how == 1)
        c = 0.0f;
    if (how == 2)
        b = c = 0.0f;
    return rtk_madd(rtk_madd(v[0], b, rtk_sub(v[1], v[0])), c, rtk_sub(v[2], v[0]));
}

static void hits_are_on_the_triangle(void **state)
{
    (void)state;
    static const struct {
        float size, move;
    } worlds[] = {{1.0f, 0.0f}, {1e-3f, 0.0f}, {1e6f, 0.0f}, {1.0f, 1e4f}, {1e-14f, 0.0f}, {1e14f, 0.0f}};
    for (int w = 0; w < 6; w++) {
        for (int kind = 0; kind < KINDS; kind++) {
            rng g = {0x9e3779b97f4a7c15u + (uint64_t)(w * 8 + kind)};
            real worst = 0;
            int hits = 0;
            for (int i = 0; i < TEST_MANY(60000); i++) {
                rtk_vec3 v[3], box[2], org, target, dir, at = rtk_v3(worlds[w].move, -worlds[w].move, 0.5f * worlds[w].move);
                make_triangle(&g, (shape_kind)kind, v);
                for (int k = 0; k < 3; k++)
                    v[k] = rtk_scale(rtk_add(v[k], at), worlds[w].size);
                box[0] = rtk_scale(rtk_add(rtk_v3(-1, -1, -1), at), worlds[w].size);
                box[1] = rtk_scale(rtk_add(rtk_v3(1, 1, 1), at), worlds[w].size);
                target = aim(&g, v);
                /* from within, from about four scales (the farthest that is not moved), from very far */
                org = rtk_scale(rtk_add(rng_vec(&g, i % 3 == 0 ? 1.0f : (i % 3 == 1 ? 3.999f : 1e5f)), at), worlds[w].size);
                if (kind == GRAZING) /* nearly in the triangle's plane */
                    org = rtk_add(rtk_madd(target, 3.0f, rtk_sub(v[i % 3], v[(i + 1) % 3])), rng_vec(&g, 1e-5f * worlds[w].size));
                dir = rtk_scale(rtk_sub(target, org), i % 5 ? 1.0f : 1.0f / worlds[w].size);
                real d = hit_distance(v, org, dir, box);
                if (d >= 0)
                    hits++;
                if (d > worst)
                    worst = d;
            }
            print_message("size %-7g moved %-6g %-8s %6d hits, worst distance %5.1Lf u scale\n", (double)worlds[w].size,
                          (double)worlds[w].move, kind_names[kind], hits, worst * 16777216.0L);
            assert_true(hits > TEST_MANY(500));
            assert_true(worst < RTK_DELTA);
        }
    }
}

/* A number of any size down to the smallest there are, for a world of that size. */
static float slight(rng *g, float size)
{
    const float x = rng_pm(g);
    const uint32_t kind = rng_u32(g) % 4;
    float y = kind == 0 ? 0.0f : size * x;
    if (kind == 1)
        y = size * ldexpf(x, -(int)(rng_u32(g) % 140));
    if (kind == 2)
        y = ldexpf(x, -(int)(rng_u32(g) % 150));
    return rtk_fabs(y) <= size ? y : size * x;
}

/* Corners of which single coordinates are denormal: products of two of them underflow, and the triangle may have an area all the
 * same. Rays go through them along an axis, where nothing rounds what is that small away. */
static void slight_corners_are_met_where_they_are(void **state)
{
    static const float sizes[] = {1.0f, 1e-3f, 1e-7f, 1e-10f, 1e-15f, 1e6f, 1e12f};
    (void)state;
    for (int w = 0; w < 7; w++) {
        const float size = sizes[w];
        rng g = {77u + (uint64_t)w};
        real worst = 0;
        int hits = 0;
        for (int i = 0; i < TEST_MANY(600000); i++) {
            rtk_vec3 v[3], box[2] = {rtk_v3(-size, -size, -size), rtk_v3(size, size, size)}, at, org;
            const float z = size * rng_pm(&g);
            for (int k = 0; k < 3; k++)
                v[k] = rtk_v3(slight(&g, size), slight(&g, size), i % 2 ? z : slight(&g, size));
            at = v[rng_u32(&g) % 3];
            org = rtk_v3(rng_u32(&g) % 2 ? at.x : 0.0f, rng_u32(&g) % 2 ? at.y : 0.0f, 2.0f * size * rng_pm(&g));
            const real d = box_distance(v, org, rtk_v3(0.0f, 0.0f, at.z < org.z ? -1.0f : 1.0f), box);
            hits += d >= 0;
            worst = d > worst ? d : worst;
        }
        print_message("size %-7g %6d hits, worst distance %5.1Lf u scale\n", (double)size, hits, worst * 16777216.0L);
        assert_true(hits > TEST_MANY(20000));
        assert_true(worst < RTK_DELTA);
    }
}

/* A far origin is moved along the ray itself: it ends within a few roundings of scale of the true line, and t counts from the
 * given origin. */
static void far_origins_stay_on_the_ray(void **state)
{
    (void)state;
    rng g = {123};
    real worst_off = 0, worst_t = 0;
    int moved = 0;
    for (int i = 0; i < TEST_MANY(100000); i++) {
        float far = powf(10.0f, 1.0f + 5.0f * rng_unit(&g));
        rtk_vec3 org = rtk_scale(rng_dir(&g), far), dir = rtk_scale(rtk_sub(rng_vec(&g, 1.0f), org), rng_unit(&g) + 0.01f);
        rtk_pray r = {0};
        if (!prepare(org, dir, 0, RTK_INF, rtk_v3(-1, -1, -1), rtk_v3(1, 1, 1), &r))
            continue;
        moved++;
        assert_true(rtk_maxabs(r.org) <= RTK_FAR * r.scale);
        real3 d = r3(dir), w = sub(r3(r.org), r3(org)), c = cross(d, w);
        real off = sqrtl(dot(c, c) / dot(d, d)), t = dot(w, d) / dot(d, d);
        worst_off = off > worst_off ? off : worst_off;
        t = fabsl(t - r.tshift) / t;
        worst_t = t > worst_t ? t : worst_t;
    }
    print_message("far origins: %d, worst %.2Lf u scale off the ray, shift's relative error %.2Lf u\n", moved,
                  worst_off * 16777216.0L, worst_t * 16777216.0L);
    assert_true(moved > TEST_MANY(50000));
    assert_true(worst_off < 4.0L / 16777216);
    assert_true(worst_t < 4.0L / 16777216);
}

/* t near a huge triangle: relative to the exact plane, which for a floor y = const is not blurred by grazing. */
static void t_is_good_near_a_floor(void **state)
{
    (void)state;
    rng g = {77};
    const rtk_vec3 v[3] = {{-1000, 0.25f, -1000}, {1000, 0.25f, -900}, {0, 0.25f, 1000}};
    rtk_tri tri = tri_of(v[0], v[1], v[2]);
    real worst = 0;
    int hits = 0;
    for (int i = 0; i < TEST_MANY(200000); i++) {
        float h = 1e-3f + rng_unit(&g);
        rtk_vec3 org = rtk_v3(100 * rng_pm(&g), 0.25f + h, 100 * rng_pm(&g)), dir = rng_dir(&g);
        rtk_pray r = {0};
        float t = 0, b, c;
        if (dir.y > -0.5f || !prepare(org, dir, 0.0f, 1e30f, rtk_v3(-1000, 0, -1000), rtk_v3(1000, 1, 1000), &r))
            continue;
        assert_true(rtk_tri_intersect(&r, &tri, &t, &b, &c));
        real want = ((real)0.25f - org.y) / dir.y, e = fabsl(t - want) / want;
        hits++;
        worst = e > worst ? e : worst;
    }
    print_message("floor: %d hits, worst relative error of t %.2Le\n", hits, worst);
    assert_true(hits > TEST_MANY(10000));
    assert_true(worst < 1e-5);
}

/* ---- watertightness: closed meshes, rays aimed at what triangles share ---- */

enum { RINGS = 12, SECTORS = 16, VERTS = RINGS * SECTORS + 2, TRIS = 2 * RINGS * SECTORS };
typedef struct mesh {
    rtk_vec3 v[VERTS];
    int index[TRIS][3];
    rtk_tri tri[TRIS];
    rtk_vec3 lo, hi;
} mesh;

/* A closed, bumpy ball; squash < 1 makes slivers. */
static void make_mesh(mesh *m, rng *g, float size, rtk_vec3 at, float squash)
{
    int n = 0;
    for (int i = 0; i < RINGS; i++)
        for (int j = 0; j < SECTORS; j++) {
            float z = cosf(3.14159f * (float)(i + 1) / (RINGS + 1)), s = sqrtf(1 - z * z);
            float a = 6.2831853f * (float)j / SECTORS, r = 1.0f + 0.1f * rng_pm(g);
            m->v[i * SECTORS + j] = rtk_add(rtk_scale(rtk_v3(r * s * cosf(a), squash * r * s * sinf(a), r * z), size), at);
        }
    m->v[VERTS - 2] = rtk_add(rtk_v3(0, 0, 1.1f * size), at);
    m->v[VERTS - 1] = rtk_add(rtk_v3(0, 0, -1.1f * size), at);
    for (int j = 0; j < SECTORS; j++) {
        int k = (j + 1) % SECTORS, last = (RINGS - 1) * SECTORS;
        int top[3] = {VERTS - 2, j, k}, bottom[3] = {VERTS - 1, last + k, last + j};
        memcpy(m->index[n++], top, sizeof top);
        memcpy(m->index[n++], bottom, sizeof bottom);
        for (int i = 0; i + 1 < RINGS; i++) {
            int a[3] = {i * SECTORS + j, (i + 1) * SECTORS + j, i * SECTORS + k};
            int b[3] = {i * SECTORS + k, (i + 1) * SECTORS + j, (i + 1) * SECTORS + k};
            memcpy(m->index[n++], a, sizeof a);
            memcpy(m->index[n++], b, sizeof b);
        }
    }
    assert_int_equal(n, TRIS);
    m->lo = m->hi = m->v[0];
    for (int i = 0; i < VERTS; i++) {
        m->lo = rtk_v3(rtk_min(m->lo.x, m->v[i].x), rtk_min(m->lo.y, m->v[i].y), rtk_min(m->lo.z, m->v[i].z));
        m->hi = rtk_v3(rtk_max(m->hi.x, m->v[i].x), rtk_max(m->hi.y, m->v[i].y), rtk_max(m->hi.z, m->v[i].z));
    }
    for (int i = 0; i < TRIS; i++)
        m->tri[i] = tri_of(m->v[m->index[i][0]], m->v[m->index[i][1]], m->v[m->index[i][2]]);
}

static int count_hits(const mesh *m, const rtk_pray *r)
{
    int hits = 0;
    float t, u, v;
    for (int i = 0; i < TRIS; i++)
        hits += rtk_tri_intersect(r, &m->tri[i], &t, &u, &v);
    return hits;
}

/* Rays from inside the ball at vertices and edges: each must hit. Axis-parallel ones too: there products cancel exactly. */
static void closed_meshes_do_not_leak(void **state)
{
    (void)state;
    static mesh m;
    static const struct {
        float size, squash;
        rtk_vec3 at;
        int rays;
    } worlds[] = {{1.0f, 1.0f, {0, 0, 0}, TEST_MANY(400000)},
                  {1.0f, 1e-3f, {0, 0, 0}, TEST_MANY(150000)},
                  {1e-3f, 1.0f, {0, 0, 0}, TEST_MANY(150000)},
                  {1e6f, 1.0f, {0, 0, 0}, TEST_MANY(150000)},
                  {1.0f, 1.0f, {1e4f, -1e4f, 5e3f}, TEST_MANY(150000)}};
    long total = 0, leaks = 0;
    for (int w = 0; w < 5; w++) {
        rng g = {4711 + (uint64_t)w};
        make_mesh(&m, &g, worlds[w].size, worlds[w].at, worlds[w].squash);
        for (int i = 0; i < worlds[w].rays; i++) {
            const int *tri = m.index[rng_u32(&g) % TRIS];
            rtk_vec3 a = m.v[tri[0]], b = m.v[tri[1]], target = i % 2 ? a : rtk_madd(a, rng_unit(&g), rtk_sub(b, a)), dir;
            rtk_vec3 in = rng_vec(&g, 0.2f * worlds[w].size),
                     org = rtk_add(worlds[w].at, rtk_v3(in.x, in.y * worlds[w].squash, in.z));
            rtk_pray r = {0};
            dir = rtk_sub(target, org);
            if (i % 7 == 0) { /* straight at it along an axis */
                org = rtk_v3(target.x, target.y, worlds[w].at.z);
                dir = rtk_v3(0, 0, i % 2 ? 1.0f : -1.0f);
                float dx = org.x - worlds[w].at.x, dy = (org.y - worlds[w].at.y) / worlds[w].squash;
                if (dx * dx + dy * dy > 0.7f * worlds[w].size * worlds[w].size)
                    continue;
            }
            if (rtk_maxabs(dir) == 0.0f)
                continue;
            total++;
            if (!prepare(org, dir, 0.0f, 1e30f, m.lo, m.hi, &r) || count_hits(&m, &r) == 0)
                leaks++;
        }
    }
    print_message("watertight: %ld rays, %ld leaks\n", total, leaks);
    assert_true(total > TEST_MANY(900000));
    assert_int_equal(leaks, 0);
}

/* The diagonal shared by two coplanar triangles, hit from everywhere, with coordinates that cancel: never missed. */
static void shared_edges_belong_to_someone(void **state)
{
    (void)state;
    rng g = {99};
    int rays = 0;
    for (int i = 0; i < TEST_MANY(200000); i++) {
        rtk_vec3 a = rng_vec(&g, 1.0f), b = rng_vec(&g, 1.0f), c = rng_vec(&g, 1.0f), d, org, p;
        rtk_pray r = {0};
        float t = 0, u = 0, v = 0;
        d = rtk_add(rtk_scale(rtk_add(a, b), 0.5f), rtk_sub(rtk_scale(rtk_add(a, b), 0.5f), c)); /* across a b */
        p = rtk_madd(a, 0.1f + 0.8f * rng_unit(&g), rtk_sub(b, a));
        org = rng_vec(&g, 2.0f);
        rtk_tri one = tri_of(a, b, c), two = tri_of(b, a, d);
        rtk_vec3 n = rtk_unit(rtk_tri_normal(&one)), dir = rtk_unit(rtk_sub(p, org));
        if (rtk_len(rtk_cross3(rtk_sub(b, a), rtk_sub(c, a))) < 0.01f || rtk_fabs(rtk_dot3(n, dir)) < 0.01f)
            continue;
        rays++;
        assert_true(prepare(org, dir, 0.0f, 1e30f, rtk_v3(-3, -3, -3), rtk_v3(3, 3, 3), &r));
        assert_true(rtk_tri_intersect(&r, &one, &t, &u, &v) || rtk_tri_intersect(&r, &two, &t, &u, &v));
    }
    assert_true(rays > TEST_MANY(100000));
}

/* ---- defined answers at the odd places ---- */

static void odd_triangles_miss(void **state)
{
    (void)state;
    rtk_pray r = {0};
    float t = 0, u = 0, v = 0, nan = RTK_INF - RTK_INF, inf = RTK_INF;
    assert_true(prepare(rtk_v3(0.25f, 0.25f, -1), rtk_v3(0, 0, 1), 0, 10, rtk_v3(-1, -1, -1), rtk_v3(1, 1, 1), &r));
    rtk_tri good = tri_of(rtk_v3(0, 0, 0), rtk_v3(1, 0, 0), rtk_v3(0, 1, 0));
    rtk_tri line = tri_of(rtk_v3(0, 0, 0), rtk_v3(0.5f, 0.5f, 0), rtk_v3(1, 1, 0));
    rtk_tri point = tri_of(rtk_v3(0.25f, 0.25f, 0), rtk_v3(0.25f, 0.25f, 0), rtk_v3(0.25f, 0.25f, 0));
    rtk_tri edge_on = tri_of(rtk_v3(0.25f, 0, 0), rtk_v3(0.25f, 1, 0), rtk_v3(0.25f, 0, 1));
    assert_true(rtk_tri_intersect(&r, &good, &t, &u, &v));
    assert_true(t == 1.0f && u == 0.25f && v == 0.25f);
    assert_false(rtk_tri_intersect(&r, &line, &t, &u, &v));
    assert_false(rtk_tri_intersect(&r, &point, &t, &u, &v));
    assert_false(rtk_tri_intersect(&r, &edge_on, &t, &u, &v));
    for (int i = 0; i < 9; i++) {
        rtk_tri bad = good;
        float *p = i < 3 ? &bad.v0[i] : (i < 6 ? &bad.v1[i - 3] : &bad.v2[i - 6]);
        *p = nan;
        assert_false(rtk_tri_intersect(&r, &bad, &t, &u, &v));
        *p = inf;
        assert_false(rtk_tri_intersect(&r, &bad, &t, &u, &v));
    }
    /* the interval is open at both ends */
    r.tmin = 1.0f;
    assert_false(rtk_tri_intersect(&r, &good, &t, &u, &v));
    r.tmin = 0.0f;
    r.tmax = 1.0f;
    assert_false(rtk_tri_intersect(&r, &good, &t, &u, &v));
}

static void odd_rays_miss(void **state)
{
    (void)state;
    const rtk_vec3 lo = {-1, -1, -1}, hi = {1, 1, 1};
    float nan = RTK_INF - RTK_INF;
    rtk_pray r = {0};
    assert_false(prepare(rtk_v3(0, 0, -2), rtk_v3(0, 0, 0), 0, 10, lo, hi, &r));
    assert_false(prepare(rtk_v3(0, 0, -2), rtk_v3(0, nan, 1), 0, 10, lo, hi, &r));
    assert_false(prepare(rtk_v3(0, 0, -2), rtk_v3(0, 0, RTK_INF), 0, 10, lo, hi, &r));
    assert_false(prepare(rtk_v3(0, 0, -2), rtk_v3(0, 0, 1e-40f), 0, 1e38f, lo, hi, &r));
    assert_false(prepare(rtk_v3(0, nan, -2), rtk_v3(0, 0, 1), 0, 10, lo, hi, &r));
    assert_false(prepare(rtk_v3(0, 0, -2), rtk_v3(0, 0, 1), 5, 5, lo, hi, &r));
    assert_false(prepare(rtk_v3(0, 0, -2), rtk_v3(0, 0, 1), nan, 5, lo, hi, &r));
    assert_false(prepare(rtk_v3(0, 0, -2), rtk_v3(0, 0, 1), 4, 5, lo, hi, &r)); /* behind the box */
    assert_true(prepare(rtk_v3(0, 0, -2), rtk_v3(0, 0, 1), 0, 10, lo, hi, &r));
    /* from 10^8 and 3 10^30 away: found, the origin brought near */
    assert_true(prepare(rtk_v3(0, 0, -1e8f), rtk_v3(0, 0, 1), 0, 1e30f, lo, hi, &r));
    assert_true(rtk_maxabs(r.org) <= 4.0f);
    assert_true(prepare(rtk_v3(0, 0, -3e30f), rtk_v3(0, 0, 1), 0, RTK_INF, lo, hi, &r));
    assert_true(rtk_maxabs(r.org) <= 4.0f);
    assert_false(prepare(rtk_v3(0, 3e8f, -1e8f), rtk_v3(0, 0, 1), 0, 1e30f, lo, hi, &r));
}

/* A hit stays what it is in any range that holds it: thin triangles, edges, rays in planes, from near and far. Ranges that begin
 * at 0 are left out, where the test is a little quicker to let go. */
static void ranges_do_not_move_hits(void **state)
{
    const rtk_vec3 lo = {-2, -2, -2}, hi = {2, 2, 2};
    rng r = {7};
    uint32_t hits = 0;
    (void)state;
    for (uint32_t i = 0; i < 300000; i++) {
        const float size = powf(10.0f, -6.0f * rng_unit(&r)), thin = i % 5 ? powf(10.0f, -8.0f * rng_unit(&r)) : 1.0f;
        const rtk_vec3 a = rng_vec(&r, 1.0f), e = rng_vec(&r, size), f = rng_vec(&r, size * thin);
        const float along = 0.2f + 0.6f * rng_unit(&r), u = i % 3 ? rng_unit(&r) : 0.0f,
                    v = i % 4 ? (1 - u) * rng_unit(&r) : 0.0f;
        const float far = i % 2 ? 3.0f * rng_unit(&r) : powf(10.0f, 0.5f + 5.5f * rng_unit(&r));
        const rtk_vec3 b = rtk_add(a, e), c = rtk_add(rtk_madd(a, along, e), f);
        const rtk_vec3 p = rtk_madd(rtk_madd(a, u, rtk_sub(b, a)), v, rtk_sub(c, a));
        rtk_vec3 d = rng_dir(&r);
        rtk_tri tri = {{a.x, a.y, a.z}, {b.x, b.y, b.z}, {c.x, c.y, c.z}, 0, 0, 0};
        rtk_pray wide;
        float t, x, y, low, high;
        if (i % 7 == 0) /* nearly along an edge */
            d = rtk_unit(rtk_madd(rtk_unit(e), powf(10.0f, -6.0f * rng_unit(&r)), d));
        if (!prepare(rtk_madd(p, -far, d), d, -RTK_INF, RTK_INF, lo, hi, &wide) || !rtk_tri_intersect(&wide, &tri, &t, &x, &y))
            continue;
        hits++;
        low = high = t;
        for (uint32_t k = 0; k < 6; k++) {
            rtk_pray narrow = wide;
            float again;
            low = k < 3 ? nextafterf(low, -RTK_INF) : t - rtk_fabs(t) * powf(10.0f, -3.0f - 4.0f * rng_unit(&r));
            high = k < 3 ? nextafterf(high, RTK_INF) : t + rtk_fabs(t) * powf(10.0f, -3.0f - 4.0f * rng_unit(&r));
            narrow.tmin = low;
            narrow.tmax = high;
            if (low == 0.0f || !(low < t && t < high))
                continue;
            assert_true(rtk_tri_intersect(&narrow, &tri, &again, &x, &y));
            assert_true(again == t);
        }
    }
    assert_true(hits > 50000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hits_are_on_the_triangle),    cmocka_unit_test(slight_corners_are_met_where_they_are),
        cmocka_unit_test(far_origins_stay_on_the_ray), cmocka_unit_test(t_is_good_near_a_floor),
        cmocka_unit_test(closed_meshes_do_not_leak),   cmocka_unit_test(shared_edges_belong_to_someone),
        cmocka_unit_test(odd_triangles_miss),          cmocka_unit_test(odd_rays_miss),
        cmocka_unit_test(ranges_do_not_move_hits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
