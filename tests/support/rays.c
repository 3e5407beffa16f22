#include "rays.h"

#include <math.h>
#include <string.h>

void *test_room(void)
{
    static _Thread_local _Alignas(64) unsigned char room[RTI_TRACE_ROOM];
    return room;
}

static void place(const test_world *w, uint32_t inst, const float p[3], float out[3])
{
    rtk_vec3 v = rtk_v3(p[0], p[1], p[2]);
    if (inst != RTK_INVALID)
        v = rtk_xfm_point(w->instances[inst].to_world, v);
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
}

static void add_group(test_targets *t, const test_world *w, uint32_t group, uint32_t inst)
{
    const test_group *g = &w->parts[group];
    float a[3], b[3], c[3];
    for (uint32_t i = 0; i < g->mesh.count; i++) {
        place(w, inst, g->mesh.tris[i].v0, a);
        place(w, inst, g->mesh.tris[i].v1, b);
        place(w, inst, g->mesh.tris[i].v2, c);
        test_mesh_add(&t->tris, a, b, c);
    }
    for (uint32_t i = 0; i < g->shape_count; i++) {
        const float *box = g->boxes[i];
        float corner[3] = {box[3], box[1], box[2]};
        place(w, inst, box, a);
        place(w, inst, corner, b);
        place(w, inst, box + 3, c);
        test_mesh_add(&t->tris, a, b, c);
    }
}

void test_targets_init(test_targets *t, const test_world *w)
{
    memset(t, 0, sizeof *t);
    add_group(t, w, 0, RTK_INVALID);
    for (uint32_t i = 0; i < w->scene.instance_count; i++)
        add_group(t, w, w->instances[i].group, i);
    for (int a = 0; a < 3; a++) {
        t->lo[a] = 3.0e38f;
        t->hi[a] = -3.0e38f;
    }
    for (uint32_t i = 0; i < t->tris.count; i++) {
        const float *v[3] = {t->tris.tris[i].v0, t->tris.tris[i].v1, t->tris.tris[i].v2};
        for (int k = 0; k < 9; k++) {
            t->lo[k % 3] = fminf(t->lo[k % 3], v[k / 3][k % 3]);
            t->hi[k % 3] = fmaxf(t->hi[k % 3], v[k / 3][k % 3]);
        }
    }
    for (int a = 0; a < 3; a++)
        t->extent = fmaxf(t->extent, t->hi[a] - t->lo[a]);
}

void test_targets_free(test_targets *t)
{
    test_mesh_free(&t->tris);
}

static rtk_vec3 vec(const float p[3])
{
    return rtk_v3(p[0], p[1], p[2]);
}

static rtk_vec3 random_dir(test_rng *r)
{
    rtk_vec3 d;
    float l;
    do {
        d = rtk_v3(test_range(r, -1.0f, 1.0f), test_range(r, -1.0f, 1.0f), test_range(r, -1.0f, 1.0f));
        l = rtk_dot3(d, d);
    } while (l > 1.0f || l < 1.0e-4f);
    return rtk_scale(d, 1.0f / sqrtf(l));
}

/* A point in the box of everything, `wide` times as large. */
static rtk_vec3 random_point(const test_targets *t, test_rng *r, float wide)
{
    float p[3];
    for (int a = 0; a < 3; a++)
        p[a] = 0.5f * (t->lo[a] + t->hi[a]) + 0.5f * wide * t->extent * test_range(r, -1.0f, 1.0f);
    return vec(p);
}

static rtk_vec3 in_plane(const rtk_tri *tri, float u, float v)
{
    rtk_vec3 a = vec(tri->v0), b = vec(tri->v1), c = vec(tri->v2);
    return rtk_madd(rtk_madd(a, u, rtk_sub(b, a)), v, rtk_sub(c, a));
}

static rtk_vec3 inside(const rtk_tri *tri, test_rng *r)
{
    float u = test_unit(r), v = test_unit(r);
    return u + v > 1.0f ? in_plane(tri, 1.0f - u, 1.0f - v) : in_plane(tri, u, v);
}

/* A vertex, or a point of an edge: its middle or anywhere. */
static rtk_vec3 rim(const rtk_tri *tri, test_rng *r, bool edge)
{
    const float *v[3] = {tri->v0, tri->v1, tri->v2};
    uint32_t k = test_u32(r) % 3;
    rtk_vec3 a = vec(v[k]), b = vec(v[(k + 1) % 3]);
    if (!edge)
        return a;
    return rtk_madd(a, test_u32(r) % 2 ? 0.5f : test_unit(r), rtk_sub(b, a));
}

static void along_axis(const test_targets *t, test_rng *r, const rtk_tri *tri, rtk_ray *ray)
{
    rtk_vec3 p = rim(tri, r, test_u32(r) % 2);
    float o[3] = {p.x, p.y, p.z}, d[3];
    uint32_t axis = test_u32(r) % 3;
    for (uint32_t a = 0; a < 3; a++)
        d[a] = test_u32(r) % 2 ? 0.0f : -0.0f;
    d[axis] = test_u32(r) % 2 ? 1.0f : -1.0f;
    if (test_u32(r) % 4)
        o[axis] -= d[axis] * t->extent * test_range(r, 0.1f, 2.0f);
    ray->org = vec(o);
    ray->dir = vec(d);
}

static void narrow(test_rng *r, rtk_ray *ray)
{
    static const float ends[] = {1.0f, 0.99999994f, 1.0000001f, 0.5f, 2.0f, 0.999f, 1.001f};
    float x = ends[test_u32(r) % 7], y = ends[test_u32(r) % 7];
    switch (test_u32(r) % 3) {
    case 0:
        ray->tmax = x;
        break;
    case 1:
        ray->tmin = x;
        break;
    default:
        ray->tmin = fminf(x, y);
        ray->tmax = fmaxf(x, y);
    }
}

static void aim(const test_targets *t, test_rng *r, int kind, const rtk_tri *tri, rtk_ray *ray)
{
    rtk_vec3 at = kind == TEST_RAY_VERTEX ? rim(tri, r, false) : (kind == TEST_RAY_EDGE ? rim(tri, r, true) : inside(tri, r));
    if (kind == TEST_RAY_FAR) {
        if (test_u32(r) % 2)
            at = rim(tri, r, test_u32(r) % 2);
        ray->org = rtk_madd(at, test_range(r, 0.1f, 1.0f) * 1.0e4f * t->extent, random_dir(r));
    } else {
        ray->org = random_point(t, r, 2.0f);
    }
    ray->dir = rtk_sub(at, ray->org);
    if (kind == TEST_RAY_RANGE)
        narrow(r, ray);
}

static void odd_direction(const test_targets *t, test_rng *r, const rtk_tri *tri, rtk_ray *ray)
{
    float d[3], p[3];
    rtk_vec3 at = rim(tri, r, true);
    for (int a = 0; a < 3; a++)
        d[a] = test_range(r, -1.0f, 1.0f) * powf(10.0f, test_range(r, -45.0f, 3.0f));
    d[test_u32(r) % 3] = test_u32(r) % 2 ? 1.0f : -1.0f;
    for (int a = 0; a < 3; a++)
        p[a] = (a == 0 ? at.x : (a == 1 ? at.y : at.z)) - d[a] * t->extent * 0.7f;
    ray->org = vec(p);
    ray->dir = vec(d);
}

/* Whatever it would hit, now it misses everything. */
static void spoil(test_rng *r, rtk_ray *ray)
{
    const float size = rtk_maxabs(ray->dir);
    switch (test_u32(r) % 7) {
    case 0:
        ray->mask = 0;
        break;
    case 1:
        ray->dir = rtk_scale(ray->dir, 0.9e-18f / size);
        break;
    case 2:
        ray->dir = rtk_scale(ray->dir, 1.1e18f / size);
        break;
    case 3:
        ray->dir.y = NAN;
        break;
    case 4:
        ray->org.x = test_u32(r) % 2 ? NAN : INFINITY;
        break;
    case 5:
        ray->tmax = ray->tmin;
        break;
    default:
        ray->tmin = NAN;
    }
}

rtk_ray test_ray(const test_targets *t, test_rng *r, int kind)
{
    rtk_ray ray;
    const rtk_tri *tri = &t->tris.tris[test_u32(r) % t->tris.count];
    ray.tmin = 0.0f;
    ray.tmax = RTK_INF;
    ray.mask = test_u32(r) % 4 ? 0xffffffffu : 1u << test_u32(r) % 4;
    switch (kind) {
    case TEST_RAY_RANDOM:
        ray.org = random_point(t, r, 1.5f);
        ray.dir = random_dir(r);
        break;
    case TEST_RAY_AXIS:
        along_axis(t, r, tri, &ray);
        break;
    case TEST_RAY_COPLANAR:
        ray.org = in_plane(tri, test_range(r, -4.0f, 4.0f), test_range(r, -4.0f, 4.0f));
        ray.dir = rtk_sub(inside(tri, r), ray.org);
        break;
    case TEST_RAY_ALONG:
        ray.org = rtk_madd(vec(tri->v0), test_range(r, -3.0f, 3.0f), rtk_sub(vec(tri->v1), vec(tri->v0)));
        ray.dir = rtk_sub(vec(tri->v1), vec(tri->v0));
        break;
    case TEST_RAY_SURFACE:
        ray.org = test_u32(r) % 2 ? inside(tri, r) : rim(tri, r, test_u32(r) % 2);
        ray.dir = random_dir(r);
        break;
    case TEST_RAY_DENORMAL:
        odd_direction(t, r, tri, &ray);
        break;
    default:
        aim(t, r, kind, tri, &ray);
    }
    if (kind != TEST_RAY_RANGE && test_u32(r) % 4 == 0)
        ray.dir = rtk_scale(ray.dir, powf(10.0f, test_range(r, -3.0f, 3.0f)));
    if (kind != TEST_RAY_RANGE && test_u32(r) % 8 == 0)
        ray.tmin = -RTK_INF;
    if (test_u32(r) % 64 == 0)
        spoil(r, &ray);
    return ray;
}
