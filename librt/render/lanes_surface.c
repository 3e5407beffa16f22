/* What is at sixteen hits of one kind. Each function here is the like-named one of kernel/surface.h over rows; where that one
 * takes a rare branch, the lane is marked and told by rtk_surface_at itself. */
#include <stddef.h>

#include "../base/simd.h"
#include "lanes.h"
#include "lanes_corners.h"
#include "lanes_table.h"
#include "shade.h"

static rtk_vec3 row3(const float *x, const float *y, const float *z, uint32_t k)
{
    return rtk_v3(x[k], y[k], z[k]);
}

/* Do all lanes hit one geometry? */
static bool one_geom(const rti_sheaf *c)
{
    return rti_u32_unlike(c->geom, c->geom[0]) == 0;
}

/* Where in its group's triangles or shapes each lane's primitive is. */
static void places_of(const rtk_group *g, const rti_sheaf *c, uint32_t *at)
{
    if (one_geom(c)) {
        const uint32_t first = g->geoms[c->geom[0]].first;
        RTI_EACH_LANE(k)
        at[k] = first + c->prim[k];
        return;
    }
    for (uint32_t k = 0; k < RTK_BLOCK; k++)
        at[k] = g->geoms[c->geom[k]].first + c->prim[k];
}

/* ---- triangles ---- */

static rtk_vec3 corner3(const rti_corners *v, uint32_t i, uint32_t k)
{
    return row3(v->row[3 * i], v->row[3 * i + 1], v->row[3 * i + 2], k);
}

RTI_LANES_FN static void flat(const rti_corners *v, rti_sheaf *c, float *area)
{
    RTI_EACH_LANE(k)
    {
        rtk_vec3 a = corner3(v, 0, k), p, n;
        rtk_vec3 e1 = rtk_sub(corner3(v, 1, k), a), e2 = rtk_sub(corner3(v, 2, k), a);
        int plain = rtk_edges_normal(e1, e2, &n);
        c->error[k] = rtk_mesh_point(a, e1, e2, c->u[k], c->v[k], &p);
        c->px[k] = p.x;
        c->py[k] = p.y;
        c->pz[k] = p.z;
        c->plain[k] = plain & rtk_unit_is_plain(rtk_maxabs(n));
        area[k] = rtk_len(n);
        n = rtk_unit_plain(n);
        c->gx[k] = n.x;
        c->gy[k] = n.y;
        c->gz[k] = n.z;
    }
}

/* Normals of slivers, in doubled floats, for the lanes that are some. */
RTI_LANES_FN static void flat_slivers(const rti_corners *v, rti_sheaf *c, float *area)
{
    RTI_EACH_LANE(k)
    {
        const rtk_vec3 a = corner3(v, 0, k), e1 = rtk_sub(corner3(v, 1, k), a), e2 = rtk_sub(corner3(v, 2, k), a);
        const rtk_vec3 n = rtk_edges_normal_exact(e1, e2), unit = rtk_unit_plain(n);
        const float length = rtk_len(n);
        rtk_vec3 other;
        const int sliver = (!rtk_edges_normal(e1, e2, &other)) & rtk_unit_is_plain(rtk_maxabs(n));
        area[k] = sliver ? length : area[k];
        c->gx[k] = sliver ? unit.x : c->gx[k];
        c->gy[k] = sliver ? unit.y : c->gy[k];
        c->gz[k] = sliver ? unit.z : c->gz[k];
        c->plain[k] |= (uint32_t)sliver;
    }
}

/* Lanes that are not plain, which is 0 or 1. */
static bool some_rare(const rti_sheaf *c)
{
    return rti_u32_unlike(c->plain, 1) != 0;
}

static void mesh(const rtk_group *g, const rti_faces *f, rti_sheaf *c, float *area)
{
    rti_corners v;
    rti_load_vertices(g, f, &v);
    flat(&v, c, area);
    if (some_rare(c))
        flat_slivers(&v, c, area);
}

/* A geometry without normals has zeros, which give the geometric one. */
RTI_LANES_FN static void smooth_normals(const rtk_group *g, const rti_faces *f, rti_sheaf *c)
{
    static const float none[9] = {0.0f};
    rti_corners v;
    rti_load_attribute(g, c, f, (rti_attribute){offsetof(rtk_geom, off_normals), 3, none}, v.row);
    RTI_EACH_LANE(k)
    {
        rtk_vec3 ng = row3(c->gx, c->gy, c->gz, k);
        rtk_vec3 n = rtk_weighted(corner3(&v, 0, k), corner3(&v, 1, k), corner3(&v, 2, k), c->u[k], c->v[k]);
        float m = rtk_maxabs(n);
        int usable = (m > 0.0f) & (m < RTK_INF), back;
        c->plain[k] &= (uint32_t)((!usable) | rtk_unit_is_plain(m));
        n = rtk_unit_plain(n);
        back = rtk_dot3(n, ng) < 0.0f;
        c->nx[k] = usable ? (back ? -n.x : n.x) : ng.x;
        c->ny[k] = usable ? (back ? -n.y : n.y) : ng.y;
        c->nz[k] = usable ? (back ? -n.z : n.z) : ng.z;
    }
}

/* Tints, which are 1 where there are none. */
RTI_LANES_FN static void colors(const rtk_group *g, const rti_faces *f, rti_sheaf *c)
{
    static const float white[9] = {1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f, 1.0f};
    rti_corners v;
    if (g->geoms[c->geom[0]].off_colors == 0 && one_geom(c))
        return;
    rti_load_attribute(g, c, f, (rti_attribute){offsetof(rtk_geom, off_colors), 3, white}, v.row);
    RTI_EACH_LANE(k)
    {
        rtk_vec3 t = rtk_weighted(corner3(&v, 0, k), corner3(&v, 1, k), corner3(&v, 2, k), c->u[k], c->v[k]);
        c->tr[k] = t.x;
        c->tg[k] = t.y;
        c->tb[k] = t.z;
    }
}

/* Texture coordinates and their density. A geometry without any is measured by the hit's weights. */
RTI_LANES_FN static void coordinates(const rtk_group *g, const rti_faces *f, rti_sheaf *c, const float *area)
{
    static const float weights[6] = {0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 1.0f};
    float a[6][RTK_BLOCK] RTI_ROW, there[RTK_BLOCK] RTI_ROW;
    rti_load_attribute(g, c, f, (rti_attribute){offsetof(rtk_geom, off_uvs), 2, weights}, a);
    RTI_EACH_LANE(k)
    there[k] = g->geoms[c->geom[k]].off_uvs != 0 ? 1.0f : 0.0f;
    RTI_EACH_LANE(k)
    {
        float du1 = a[2][k] - a[0][k], dv1 = a[3][k] - a[1][k], du2 = a[4][k] - a[0][k], dv2 = a[5][k] - a[1][k];
        float density = rtk_sqrt(rtk_fabs(du1 * dv2 - du2 * dv1) / area[k]);
        c->tu[k] = a[0][k] + c->u[k] * du1 + c->v[k] * du2;
        c->tv[k] = a[1][k] + c->u[k] * dv1 + c->v[k] * dv2;
        density = area[k] > 0.0f ? density : 0.0f;
        c->uv_scale[k] = there[k] > 0.0f ? density : 0.0f;
    }
}

/* ---- shapes and planes ---- */

RTI_LANES_FN static void spheres(const rtk_group *g, rti_sheaf *c)
{
    float sphere[4][RTK_BLOCK] RTI_ROW;
    const float *from[RTK_BLOCK], *radius = sphere[3];
    uint32_t place[RTK_BLOCK] RTI_ROW;
    places_of(g, c, place);
    RTI_EACH_LANE(k)
    from[k] = g->shapes[place[k]].p;
    rti_rows4(from, sphere);
    RTI_EACH_LANE(k)
    {
        rtk_vec3 at = row3(sphere[0], sphere[1], sphere[2], k), n, p, lo, hi;
        rtk_ray ray;
        ray.org = row3(c->ox, c->oy, c->oz, k);
        ray.dir = row3(c->dx, c->dy, c->dz, k);
        n = rtk_sub(rtk_ray_at(ray, c->t[k]), at);
        c->plain[k] = (uint32_t)rtk_unit_is_plain(rtk_maxabs(n));
        n = rtk_unit_plain(n);
        p = rtk_sphere_point(at, radius[k], n);
        lo = rtk_v3(rtk_sphere_low(at.x, radius[k]), rtk_sphere_low(at.y, radius[k]), rtk_sphere_low(at.z, radius[k]));
        hi = rtk_v3(rtk_sphere_high(at.x, radius[k]), rtk_sphere_high(at.y, radius[k]), rtk_sphere_high(at.z, radius[k]));
        c->error[k] = rtk_shape_error(p, rtk_sub(hi, lo));
        c->px[k] = p.x;
        c->py[k] = p.y;
        c->pz[k] = p.z;
        c->gx[k] = n.x;
        c->gy[k] = n.y;
        c->gz[k] = n.z;
    }
}

static void shape_tints(const rtk_group *g, rti_sheaf *c)
{
    if (g->geoms[c->geom[0]].off_colors == 0 && one_geom(c))
        return;
    for (uint32_t k = 0; k < RTK_BLOCK; k++) {
        const rtk_geom *geom = &g->geoms[c->geom[k]];
        if (geom->off_colors) {
            rtk_vec3 t = rtk_attribute3(g->attributes, geom->off_colors, c->prim[k]);
            c->tr[k] = t.x;
            c->tg[k] = t.y;
            c->tb[k] = t.z;
        }
    }
}

/* Longitude and latitude. */
RTI_LANES_FN static void sphere_coordinates(const rtk_group *g, rti_sheaf *c)
{
    float radius[RTK_BLOCK] RTI_ROW;
    for (uint32_t k = 0; k < RTK_BLOCK; k++)
        radius[k] = g->shapes[g->geoms[c->geom[k]].first + c->prim[k]].p[3];
    RTI_EACH_LANE(k)
    {
        rtk_sphere_uv(row3(c->gx, c->gy, c->gz, k), &c->tu[k], &c->tv[k]);
        c->uv_scale[k] = rtk_area_density(rtk_sphere_area(radius[k]));
    }
}

RTI_LANES_FN static void boxes(const rtk_group *g, rti_sheaf *c)
{
    float box[8][RTK_BLOCK] RTI_ROW;
    const float *from[RTK_BLOCK];
    uint32_t place[RTK_BLOCK] RTI_ROW;
    places_of(g, c, place);
    RTI_EACH_LANE(k)
    from[k] = g->shapes[place[k]].p;
    rti_rows4(from, box);
    for (uint32_t k = 0; k < RTK_BLOCK; k++)
        from[k] += 4;
    rti_rows4(from, box + 4);
    RTI_EACH_LANE(k)
    {
        rtk_vec3 lo = row3(box[0], box[1], box[2], k), hi = row3(box[3], box[4], box[5], k), p, n;
        rtk_ray ray;
        rtk_box_face f;
        ray.org = row3(c->ox, c->oy, c->oz, k);
        ray.dir = row3(c->dx, c->dy, c->dz, k);
        p = rtk_box_clamp(lo, hi, rtk_ray_at(ray, c->t[k]));
        f = rtk_box_nearest(lo, hi, p);
        n = rtk_box_normal(f);
        rtk_box_uv(lo, hi, p, f, &c->tu[k], &c->tv[k]);
        c->uv_scale[k] = rtk_box_area(lo, hi, n); /* until it is asked for */
        p = rtk_box_onto(lo, hi, p, f);
        c->plain[k] = 1;
        c->error[k] = rtk_shape_error(p, rtk_sub(hi, lo));
        c->px[k] = p.x;
        c->py[k] = p.y;
        c->pz[k] = p.z;
        c->gx[k] = n.x;
        c->gy[k] = n.y;
        c->gz[k] = n.z;
    }
}

static void box_densities(rti_sheaf *c)
{
    RTI_EACH_LANE(k)
    {
        c->uv_scale[k] = rtk_area_density(c->uv_scale[k]);
    }
}

/* Of a cylinder or cone: without its texture's coordinates. */
RTI_LANES_FN static void cones(const rtk_group *g, rti_sheaf *c)
{
    float ends[8][RTK_BLOCK] RTI_ROW;
    const float *from[RTK_BLOCK];
    uint32_t place[RTK_BLOCK] RTI_ROW, pointed[RTK_BLOCK] RTI_ROW;
    places_of(g, c, place);
    RTI_EACH_LANE(k)
    {
        from[k] = g->shapes[place[k]].p;
        pointed[k] = g->shapes[place[k]].type == RTK_SHAPE_CONE;
    }
    rti_rows4(from, ends);
    for (uint32_t k = 0; k < RTK_BLOCK; k++)
        from[k] += 4;
    rti_rows4(from, ends + 4);
    RTI_EACH_LANE(k)
    {
        const rtk_vec3 e0 = row3(ends[0], ends[1], ends[2], k), e1 = row3(ends[4], ends[5], ends[6], k), a = rtk_sub(e1, e0);
        const float r0 = ends[3][k], r1 = pointed[k] ? ends[7][k] : r0;
        const rtk_cone cone = rtk_cone_along(a, rtk_unit_plain(a), r0, r1);
        rtk_vec3 q, round, unit, p, n, lo, hi;
        float z, far, x, y, v;
        rtk_ray ray;
        int middle, end, plain = rtk_unit_is_plain(rtk_maxabs(a));
        ray.org = row3(c->ox, c->oy, c->oz, k);
        ray.dir = row3(c->dx, c->dy, c->dz, k);
        q = rtk_sub(rtk_ray_at(ray, c->t[k]), e0);
        z = rtk_dot3(q, cone.axis);
        q = rtk_madd(q, -z, cone.axis);
        far = rtk_len(q);
        round = rtk_across(cone.axis, q, &x, &y, &middle); /* as rtk_around */
        plain &= middle | rtk_unit_is_plain(rtk_maxabs(round));
        unit = rtk_unit_plain(round);
        round = rtk_v3(middle ? round.x : unit.x, middle ? round.y : unit.y, middle ? round.z : unit.z);
        end = rtk_cone_onto(cone, e0, e1, r1, z, far, round, &p, &n, &v);
        plain &= end | rtk_unit_is_plain(rtk_maxabs(n));
        unit = rtk_unit_plain(n);
        rtk_ends_bounds(e0, rtk_cone_disc(cone.axis, r0), e1, rtk_cone_disc(cone.axis, r1), &lo, &hi);
        c->plain[k] = (uint32_t)plain;
        c->error[k] = rtk_shape_error(p, rtk_sub(hi, lo));
        c->px[k] = p.x;
        c->py[k] = p.y;
        c->pz[k] = p.z;
        c->gx[k] = end ? n.x : unit.x;
        c->gy[k] = end ? n.y : unit.y;
        c->gz[k] = end ? n.z : unit.z;
    }
}

RTI_LANES_FN static void planes(const rtk_group *g, rti_sheaf *c)
{
    float q[9][RTK_BLOCK] RTI_ROW;
    RTI_EACH_LANE(k)
    {
        const rtk_geom *geom = &g->geoms[c->geom[k]];
        const rtk_shape *s = &g->planes[geom->first];
        for (uint32_t i = 0; i < 3; i++) {
            q[i][k] = s->p[i];
            q[3 + i][k] = s->p[4 + i];
            q[6 + i][k] = geom->t_dir[i];
        }
    }
    RTI_EACH_LANE(k)
    {
        rtk_vec3 at = row3(q[0], q[1], q[2], k), n = row3(q[3], q[4], q[5], k), x = row3(q[6], q[7], q[8], k), p, d;
        rtk_ray ray;
        ray.org = row3(c->ox, c->oy, c->oz, k);
        ray.dir = row3(c->dx, c->dy, c->dz, k);
        p = rtk_plane_point(rtk_ray_at(ray, c->t[k]), at, n);
        d = rtk_sub(p, at);
        c->plain[k] = 1;
        c->error[k] = rtk_plane_error(p);
        c->px[k] = p.x;
        c->py[k] = p.y;
        c->pz[k] = p.z;
        c->gx[k] = n.x;
        c->gy[k] = n.y;
        c->gz[k] = n.z;
        c->tu[k] = rtk_dot3(d, x);
        c->tv[k] = rtk_dot3(d, rtk_cross3(n, x));
        c->uv_scale[k] = 1.0f;
    }
}

/* ---- all ---- */

/* Placement of texture coordinates. */
RTI_LANES_FN static void place_coordinates(const rtk_group *g, rti_sheaf *c)
{
    float m[6][RTK_BLOCK] RTI_ROW;
    RTI_EACH_LANE(k)
    for (uint32_t i = 0; i < 6; i++)
        m[i][k] = g->geoms[c->geom[k]].uv_xfm[i];
    RTI_EACH_LANE(k)
    {
        float u = c->tu[k], v = c->tv[k];
        c->tu[k] = m[0][k] * u + m[1][k] * v + m[2][k];
        c->tv[k] = m[3][k] * u + m[4][k] * v + m[5][k];
        c->uv_scale[k] *= rtk_sqrt(rtk_fabs(m[0][k] * m[4][k] - m[1][k] * m[3][k]));
    }
}

static void no_tints(rti_sheaf *c)
{
    RTI_EACH_LANE(k)
    c->tr[k] = c->tg[k] = c->tb[k] = 1.0f;
}

/* Lanes that are not plain, by the scalar function. */
static void tell(const rti_worker *w, rti_sheaf *c)
{
    if (!some_rare(c))
        return;
    for (uint32_t k = 0; k < c->count; k++) {
        rtk_surface s;
        if (c->plain[k])
            continue;
        s = rtk_surface_at(w->frame->scene, rti_batch_ray(w, c->ray[k]), rti_hit_at(w->hits, c->ray[k]),
                           rti_batch_time(w, c->ray[k]));
        c->px[k] = s.p.x;
        c->py[k] = s.p.y;
        c->pz[k] = s.p.z;
        c->error[k] = s.error;
        c->nx[k] = s.ns.x;
        c->ny[k] = s.ns.y;
        c->nz[k] = s.ns.z;
        c->gx[k] = s.ng.x;
        c->gy[k] = s.ng.y;
        c->gz[k] = s.ng.z;
        c->tr[k] = s.tint.x;
        c->tg[k] = s.tint.y;
        c->tb[k] = s.tint.z;
        c->tu[k] = s.u;
        c->tv[k] = s.v;
        c->uv_scale[k] = s.uv_scale;
        c->material[k] = s.material;
    }
}

/* Without normals of their own: those are the geometric ones. */
RTI_LANES_FN static void face_flat(rti_sheaf *c)
{
    RTI_EACH_LANE(k)
    {
        rtk_vec3 ng = row3(c->gx, c->gy, c->gz, k), ns = ng;
        c->outside[k] = (uint32_t)rtk_face_normals(row3(c->dx, c->dy, c->dz, k), &ng, &ns);
        c->gx[k] = c->nx[k] = ng.x;
        c->gy[k] = c->ny[k] = ng.y;
        c->gz[k] = c->nz[k] = ng.z;
        c->footprint[k] = c->width[k] + c->spread[k] * c->t[k];
    }
}

RTI_LANES_FN static void face(rti_sheaf *c)
{
    RTI_EACH_LANE(k)
    {
        rtk_vec3 ng = row3(c->gx, c->gy, c->gz, k), ns = row3(c->nx, c->ny, c->nz, k);
        c->outside[k] = (uint32_t)rtk_face_normals(row3(c->dx, c->dy, c->dz, k), &ng, &ns);
        c->gx[k] = ng.x;
        c->gy[k] = ng.y;
        c->gz[k] = ng.z;
        c->nx[k] = ns.x;
        c->ny[k] = ns.y;
        c->nz[k] = ns.z;
        c->footprint[k] = c->width[k] + c->spread[k] * c->t[k];
    }
}

/* Sixteen hits of a kind from MESH to PLANE in one group, in its space, but for what is the same: without normals of vertices ns
 * is ng to the last bit, and without tints they are 1. */
void RTI_ISA_FN(rti_lanes_body)(const rtk_group *g, uint32_t kind, rti_sheaf *c)
{
    const bool textured = c->material_kind >= RTI_LOOK_TEXTURED;
    float area[RTK_BLOCK] RTI_ROW;
    rti_faces f;
    if (c->tinted)
        no_tints(c);
    if (kind == RTI_SURFACE_MESH || kind == RTI_SURFACE_SMOOTH) {
        places_of(g, c, f.at);
        rti_find_faces(&f);
        mesh(g, &f, c, area);
    } else if (kind == RTI_SURFACE_SPHERE) {
        spheres(g, c);
        shape_tints(g, c);
        if (textured)
            sphere_coordinates(g, c);
    } else if (kind == RTI_SURFACE_BOX) {
        boxes(g, c);
        shape_tints(g, c);
        if (textured)
            box_densities(c);
    } else if (kind == RTI_SURFACE_CONE) {
        cones(g, c);
        shape_tints(g, c);
        if (textured) /* angles take inverse functions: lane after lane */
            memset(c->plain, 0, sizeof c->plain);
    } else {
        planes(g, c);
    }
    if (kind == RTI_SURFACE_SMOOTH) {
        smooth_normals(g, &f, c);
        colors(g, &f, c);
    }
    if (textured && (kind == RTI_SURFACE_MESH || kind == RTI_SURFACE_SMOOTH))
        coordinates(g, &f, c, area);
    if (textured)
        place_coordinates(g, c);
}

void RTI_ISA_FN(rti_lanes_surface)(const rti_worker *w, rti_sheaf *c)
{
    const rtk_scene *scene = w->frame->scene;
    if (c->surface_kind >= RTI_SURFACE_PLACED)
        RTI_ISA_FN(rti_lanes_placed)(scene, c);
    else if (c->surface_kind == RTI_SURFACE_OTHER)
        memset(c->plain, 0, sizeof c->plain);
    else
        RTI_ISA_FN(rti_lanes_body)(scene->groups, c->surface_kind, c);
    tell(w, c);
    if (c->smooth)
        face(c);
    else
        face_flat(c);
}
