/* Planes through a scene: polygons in boxes, outlines of primitives. */
#include "look.h"

#include <math.h>
#include <string.h>

#define CIRCLE 96u /* pieces of a circle */
#define TUBE   48u /* pieces of a torus's tube */

static bool finite3(rt_vec3 v)
{
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

rt_status rti_cut_take(rt_context *ctx, const char *call, rt_vec3 point, rt_vec3 normal, rti_cut_plane *plane)
{
    double n[3] = {normal.x, normal.y, normal.z}, most = fmax(fabs(n[0]), fmax(fabs(n[1]), fabs(n[2])));
    if (!finite3(point) || !finite3(normal))
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: the plane's point and normal must be finite", call);
    if (!(most > 0.0))
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: the plane's normal is zero", call);
    plane->point[0] = point.x;
    plane->point[1] = point.y;
    plane->point[2] = point.z;
    for (int a = 0; a < 3; a++)
        plane->normal[a] = n[a] / most;
    return RT_OK;
}

/* ---- boxes ---- */

static bool same(rt_vec3 a, rt_vec3 b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

/* The box's face, 0 ... 5, that both ends of an edge and so both neighbours of a polygon's side lie on. */
static uint32_t faces_of_edge(uint32_t a, uint32_t b)
{
    uint32_t faces = 0;
    for (uint32_t axis = 0; axis < 3; axis++) {
        if ((a >> axis & 1u) == (b >> axis & 1u))
            faces |= 1u << (2 * axis + (a >> axis & 1u));
    }
    return faces;
}

/* The polygon goes from crossed edge to crossed edge over a face that both have. */
uint32_t rti_cut_box(const rti_cut_plane *plane, const float lo[3], const float hi[3], rt_vec3 corners[6])
{
    double at[8][3], side[8];
    rt_vec3 crossing[6];
    uint32_t faces[6], found = 0, count = 0, from = 0, left;
    for (uint32_t i = 0; i < 8; i++) {
        for (uint32_t a = 0; a < 3; a++)
            at[i][a] = i >> a & 1u ? hi[a] : lo[a];
        side[i] = rti_cut_side(plane, at[i]);
    }
    for (uint32_t i = 0; i < 8; i++) {
        for (uint32_t a = 0; a < 3; a++) {
            uint32_t j = i | 1u << a;
            if (j == i || (side[i] < 0.0) == (side[j] < 0.0) || found == 6)
                continue;
            crossing[found] = rti_cut_cross(at[i], side[i], at[j], side[j]);
            faces[found++] = faces_of_edge(i, j);
        }
    }
    left = found < 3 ? 0 : (1u << found) - 1u;
    while (left) {
        uint32_t next = found;
        left &= ~(1u << from);
        if (count == 0 || !same(corners[count - 1], crossing[from]))
            corners[count++] = crossing[from];
        for (uint32_t i = 0; i < found && next == found; i++) {
            if ((left >> i & 1u) && (faces[i] & faces[from]))
                next = i;
        }
        if (next == found)
            break;
        from = next;
    }
    while (count > 1 && same(corners[count - 1], corners[0]))
        count--;
    return count < 3 ? 0 : count;
}

/* ---- primitives ---- */

/* One group being cut; pieces of an instance are put into the world. */
typedef struct cutter {
    rti_cut_plane plane;
    const rtk_xfm *to_world; /* NULL: the group's own space */
    rt_section piece;
    rt_section_fn fn;
    void *user;
    bool ended;
} cutter;

static rt_vec3 placed(const cutter *c, rt_vec3 p)
{
    rtk_vec3 v;
    if (!c->to_world)
        return p;
    v = rtk_xfm_point(*c->to_world, rtk_v3(p.x, p.y, p.z));
    return (rt_vec3){v.x, v.y, v.z};
}

static void give(cutter *c, rt_vec3 from, rt_vec3 to)
{
    if (c->ended)
        return;
    c->piece.from = placed(c, from);
    c->piece.to = placed(c, to);
    c->ended = c->fn(c->user, &c->piece) != 0;
}

static void cut_triangle(cutter *c, const double a[3], const double b[3], const double d[3])
{
    const double *v[3] = {a, b, d};
    double side[3] = {rti_cut_side(&c->plane, a), rti_cut_side(&c->plane, b), rti_cut_side(&c->plane, d)};
    rt_vec3 ends[3];
    uint32_t n = 0;
    for (uint32_t i = 0; i < 3; i++) {
        uint32_t j = (i + 1) % 3;
        if ((side[i] < 0.0) == (side[j] < 0.0))
            continue;
        /* From the lower corner to the upper one, so that neighbours find the same point of their edge. */
        ends[n++] = side[i] < 0.0 ? rti_cut_cross(v[i], side[i], v[j], side[j]) : rti_cut_cross(v[j], side[j], v[i], side[i]);
    }
    if (n == 2)
        give(c, ends[0], ends[1]);
}

static void cut_quad(cutter *c, const double a[3], const double b[3], const double d[3], const double e[3])
{
    cut_triangle(c, a, b, d);
    cut_triangle(c, b, e, d);
}

/* ---- shapes ---- */

static void turn(uint32_t i, uint32_t of, double *cosine, double *sine)
{
    double angle = 6.283185307179586 * (i % of) / of;
    *cosine = cos(angle);
    *sine = sin(angle);
}

/* Two unit vectors orthogonal to n (any length) and to each other. */
static void across(const double n[3], double u[3], double v[3])
{
    double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]), z[3] = {n[0] / length, n[1] / length, n[2] / length}, l;
    int thin = fabs(z[0]) < fabs(z[1]) ? (fabs(z[0]) < fabs(z[2]) ? 0 : 2) : (fabs(z[1]) < fabs(z[2]) ? 1 : 2);
    double e[3] = {thin == 0, thin == 1, thin == 2};
    u[0] = z[1] * e[2] - z[2] * e[1];
    u[1] = z[2] * e[0] - z[0] * e[2];
    u[2] = z[0] * e[1] - z[1] * e[0];
    l = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
    for (int a = 0; a < 3; a++)
        u[a] /= l;
    v[0] = z[1] * u[2] - z[2] * u[1];
    v[1] = z[2] * u[0] - z[0] * u[2];
    v[2] = z[0] * u[1] - z[1] * u[0];
}

static void on_circle(const double at[3], const double u[3], const double v[3], double radius, uint32_t i, double out[3])
{
    double cosine, sine;
    turn(i, CIRCLE, &cosine, &sine);
    for (int a = 0; a < 3; a++)
        out[a] = at[a] + radius * (cosine * u[a] + sine * v[a]);
}

/* The circle itself: no corner of it is off the plane. */
static void cut_sphere(cutter *c, const float p[4])
{
    double centre[3] = {p[0], p[1], p[2]}, *n = c->plane.normal, nn = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    double distance = rti_cut_side(&c->plane, centre) / sqrt(nn), radius = (double)p[3] * p[3] - distance * distance;
    double u[3], v[3], last[3], next[3];
    if (!(radius > 0.0))
        return;
    radius = sqrt(radius);
    for (int a = 0; a < 3; a++)
        centre[a] -= distance * n[a] / sqrt(nn);
    across(n, u, v);
    on_circle(centre, u, v, radius, 0, last);
    for (uint32_t i = 1; i <= CIRCLE; i++) {
        on_circle(centre, u, v, radius, i, next);
        give(c, (rt_vec3){(float)last[0], (float)last[1], (float)last[2]},
             (rt_vec3){(float)next[0], (float)next[1], (float)next[2]});
        memcpy(last, next, sizeof last);
    }
}

static void cut_box(cutter *c, const float *p)
{
    rt_vec3 corners[6];
    uint32_t n = rti_cut_box(&c->plane, p, p + 3, corners);
    for (uint32_t i = 0; i < n; i++)
        give(c, corners[i], corners[(i + 1) % n]);
}

static void cut_cone(cutter *c, const float *p, float radius1)
{
    double from[3] = {p[0], p[1], p[2]}, to[3] = {p[4], p[5], p[6]}, axis[3], u[3], v[3], a0[3], a1[3], b0[3], b1[3];
    for (int a = 0; a < 3; a++)
        axis[a] = to[a] - from[a];
    across(axis, u, v);
    for (uint32_t i = 0; i < CIRCLE; i++) {
        on_circle(from, u, v, p[3], i, a0);
        on_circle(from, u, v, p[3], i + 1, a1);
        on_circle(to, u, v, radius1, i, b0);
        on_circle(to, u, v, radius1, i + 1, b1);
        cut_quad(c, a0, a1, b0, b1);
        cut_triangle(c, from, a0, a1);
        cut_triangle(c, to, b0, b1);
    }
}

static void on_torus(const float *p, const double u[3], const double v[3], uint32_t i, uint32_t j, double out[3])
{
    double centre[3] = {p[0], p[1], p[2]}, rim[3], cosine, sine;
    turn(j, TUBE, &cosine, &sine);
    on_circle(centre, u, v, p[3] + p[7] * cosine, i, rim);
    for (int a = 0; a < 3; a++)
        out[a] = rim[a] + p[7] * sine * p[4 + a];
}

static void cut_torus(cutter *c, const float *p)
{
    double axis[3] = {p[4], p[5], p[6]}, u[3], v[3], q[4][3];
    across(axis, u, v);
    for (uint32_t i = 0; i < CIRCLE; i++) {
        for (uint32_t j = 0; j < TUBE; j++) {
            for (uint32_t k = 0; k < 4; k++)
                on_torus(p, u, v, i + (k & 1u), j + (k >> 1), q[k]);
            cut_quad(c, q[0], q[1], q[2], q[3]);
        }
    }
}

static void cut_shape(cutter *c, const rtk_shape *s)
{
    switch (s->type) {
    case RTK_SHAPE_SPHERE:
        cut_sphere(c, s->p);
        break;
    case RTK_SHAPE_BOX:
        cut_box(c, s->p);
        break;
    case RTK_SHAPE_TORUS:
        cut_torus(c, s->p);
        break;
    default:
        cut_cone(c, s->p, s->type == RTK_SHAPE_CONE ? s->p[7] : s->p[3]);
    }
}

/* ---- groups ---- */

static void cut_group(cutter *c, const rtk_group *g)
{
    for (uint32_t i = 0; i < g->tri_count && !c->ended; i++) {
        const rtk_tri *t = &g->tris[i];
        double a[3] = {t->v0[0], t->v0[1], t->v0[2]}, b[3] = {t->v1[0], t->v1[1], t->v1[2]},
               d[3] = {t->v2[0], t->v2[1], t->v2[2]};
        c->piece.geom_id = t->geom;
        c->piece.prim_id = t->prim;
        cut_triangle(c, a, b, d);
    }
    for (uint32_t i = 0; i < g->shape_count && !c->ended; i++) {
        c->piece.geom_id = g->shapes[i].geom;
        c->piece.prim_id = g->shapes[i].prim;
        cut_shape(c, &g->shapes[i]);
    }
}

/* The plane in an instance's space: a point goes with the inverse, a normal with the transposed map. */
static rti_cut_plane plane_in(const rti_cut_plane *plane, const rtk_instance *inst)
{
    rti_cut_plane p;
    const float *w = inst->to_world.m, *o = inst->to_object.m;
    for (int a = 0; a < 3; a++) {
        p.point[a] = o[4 * a] * plane->point[0] + o[4 * a + 1] * plane->point[1] + o[4 * a + 2] * plane->point[2] + o[4 * a + 3];
        p.normal[a] = w[a] * plane->normal[0] + w[4 + a] * plane->normal[1] + w[8 + a] * plane->normal[2];
    }
    return p;
}

static void cut_instances(cutter *c, const rtk_scene *v)
{
    rti_cut_plane world = c->plane;
    for (uint32_t i = 0; i < v->instance_count && !c->ended; i++) {
        const rtk_instance *inst = &v->instances[i];
        if (!(inst->lo[0] <= inst->hi[0]) && !(inst->flags & RTK_INST_UNBOUNDED))
            continue;
        c->plane = plane_in(&world, inst);
        c->to_world = &inst->to_world;
        c->piece.inst_id = inst->id;
        cut_group(c, &v->groups[inst->group]);
    }
}

rt_status rt_scene_cut(const rt_scene *scene, uint32_t group, rt_vec3 point, rt_vec3 normal, rt_section_fn fn, void *user)
{
    RTI_NEED(scene);
    static const char call[] = "rt_scene_cut";
    cutter c = {.fn = fn, .user = user, .piece.inst_id = RT_INVALID_ID};
    rti_snapshot *s;
    rt_status status;
    if (!fn)
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: fn is NULL; it is called for each piece", call);
    status = rti_cut_take(scene->ctx, call, point, normal, &c.plane);
    if (status == RT_OK)
        status = rti_look_snapshot(scene, call, &s);
    if (status != RT_OK)
        return status;
    status = rti_look_group(s, call, group);
    if (status == RT_OK && group == RT_INVALID_ID)
        cut_instances(&c, &s->view);
    else if (status == RT_OK)
        cut_group(&c, &s->view.groups[group]);
    if (c.ended)
        status = rti_fail(scene->ctx, RT_ERROR_CANCELLED, "%s: the callback ended it", call);
    rti_snapshot_release(s);
    return status;
}
