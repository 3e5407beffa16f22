/* What is at a hit: the one place that turns (snapshot, ray, hit) into a point, normals, texture coordinates and a material.
 *
 * The point lies on the primitive, not on the ray: a triangle's from its vertices and the hit's weights, a shape's or plane's by
 * projection. So its distance from the surface is a few roundings of its coordinates, however far the ray has come, and `error`
 * bounds it. With that bound a spawned ray starts clear of the surface (rtk_leave) and no scene epsilon is needed
 * (Waechter and Binder 2019). In an instance the bound also covers the way back: a ray from p goes through to_object before it
 * meets the surface again.
 */
#ifndef RTK_SURFACE_H
#define RTK_SURFACE_H

#include "motion.h"
#include "shape_surface.h"
#include "snapshot.h"
#include "triangle.h"

typedef struct rtk_surface {
    rtk_vec3 p;       /* world space, on the primitive (not org + t dir) */
    rtk_vec3 ng, ns;  /* unit, outwards as described; ns on the side of ng, and equal to it where there are no vertex normals */
    float u, v;       /* texture coordinates after placement */
    rtk_vec3 tint;    /* vertex colour, or 1 1 1 */
    float uv_scale;   /* texture-space length per world length around the hit, for mip levels; 0: no mip-mapping */
    float error;      /* bound of p's distance from the surface as rays meet it, world space */
    rtk_u32 material; /* index in scene.materials */
    rtk_u32 face;     /* face_id of the public rt_surface */
    rtk_u32 user_id, inst_user_id;
} rtk_surface;

RTK_FN rtk_vec3 rtk_attribute3(RT_GLOBAL const rtk_u8 *attributes, rtk_u64 offset, rtk_u32 index)
{
    RT_GLOBAL const float *f = (RT_GLOBAL const float *)(attributes + offset) + 3u * (rtk_u64)index;
    return rtk_v3(f[0], f[1], f[2]);
}

RTK_FN rtk_u32 rtk_attribute_u32(RT_GLOBAL const rtk_u8 *attributes, rtk_u64 offset, rtk_u64 index)
{
    return ((RT_GLOBAL const rtk_u32 *)(attributes + offset))[index];
}

RTK_FN rtk_vec3 rtk_weighted(rtk_vec3 a, rtk_vec3 b, rtk_vec3 c, float u, float v)
{
    return rtk_madd(rtk_madd(a, u, rtk_sub(b, a)), v, rtk_sub(c, a));
}

/* Vertex data of a triangle at weights (u, v). ng is set already. */
RTK_FN void rtk_mesh_attributes(RT_GLOBAL const rtk_group *group, RT_GLOBAL const rtk_geom *geom, rtk_hit hit, float area,
                                rtk_surface *s)
{
    RT_GLOBAL const rtk_u8 *data = group->attributes;
    rtk_u64 corner = geom->off_indices;
    rtk_u32 a, b, c;
    rtk_vec3 n;
    if (!(geom->off_normals | geom->off_uvs | geom->off_colors))
        return;
    a = rtk_attribute_u32(data, corner, 3u * (rtk_u64)hit.prim);
    b = rtk_attribute_u32(data, corner, 3u * (rtk_u64)hit.prim + 1u);
    c = rtk_attribute_u32(data, corner, 3u * (rtk_u64)hit.prim + 2u);
    if (geom->off_normals) {
        n = rtk_weighted(rtk_attribute3(data, geom->off_normals, a), rtk_attribute3(data, geom->off_normals, b),
                         rtk_attribute3(data, geom->off_normals, c), hit.u, hit.v);
        if (rtk_maxabs(n) > 0.0f && rtk_maxabs(n) < RTK_INF) {
            n = rtk_unit(n);
            s->ns = rtk_dot3(n, s->ng) < 0.0f ? rtk_neg(n) : n;
        }
    }
    if (geom->off_colors)
        s->tint = rtk_weighted(rtk_attribute3(data, geom->off_colors, a), rtk_attribute3(data, geom->off_colors, b),
                               rtk_attribute3(data, geom->off_colors, c), hit.u, hit.v);
    if (geom->off_uvs) {
        RT_GLOBAL const float *uv = (RT_GLOBAL const float *)(data + geom->off_uvs);
        RT_GLOBAL const float *ua = uv + 2u * (rtk_u64)a, *ub = uv + 2u * (rtk_u64)b, *uc = uv + 2u * (rtk_u64)c;
        float du1 = ub[0] - ua[0], dv1 = ub[1] - ua[1], du2 = uc[0] - ua[0], dv2 = uc[1] - ua[1];
        s->u = ua[0] + hit.u * du1 + hit.v * du2;
        s->v = ua[1] + hit.u * dv1 + hit.v * dv2;
        s->uv_scale = area > 0.0f ? rtk_sqrt(rtk_fabs(du1 * dv2 - du2 * dv1) / area) : 0.0f;
    }
}

/* Point of a triangle with corner a and edges e1, e2, and the bound of its error.
 * p = v0 + u (v1 - v0) + v (v2 - v0): per coordinate 2 u |p| and 6 u of the longest edge are lost at most; the bound is 4 and 12
 * of them, for the diagonal of the three coordinates. */
RTK_FN float rtk_mesh_point(rtk_vec3 a, rtk_vec3 e1, rtk_vec3 e2, float u, float v, rtk_vec3 *p)
{
    *p = rtk_madd(rtk_madd(a, u, e1), v, e2);
    return 2.3841858e-07f * rtk_maxabs(*p) + 7.1525574e-07f * rtk_max(rtk_maxabs(e1), rtk_maxabs(e2));
}

RTK_FN void rtk_surface_mesh(RT_GLOBAL const rtk_group *group, RT_GLOBAL const rtk_geom *geom, rtk_hit hit, rtk_surface *s)
{
    RT_GLOBAL const rtk_tri *tri = &group->tris[geom->first + hit.prim];
    rtk_vec3 a = rtk_at(tri->v0), b = rtk_at(tri->v1), c = rtk_at(tri->v2), e1 = rtk_sub(b, a), e2 = rtk_sub(c, a);
    rtk_vec3 n = rtk_tri_normal(tri);
    s->error = rtk_mesh_point(a, e1, e2, hit.u, hit.v, &s->p);
    s->ng = rtk_unit(n);
    s->ns = s->ng;
    s->u = hit.u;
    s->v = hit.v;
    rtk_mesh_attributes(group, geom, hit, rtk_len(n), s);
    s->face = geom->off_faces ? rtk_attribute_u32(group->attributes, geom->off_faces, hit.prim) : hit.prim;
}

RTK_FN float rtk_sphere_area(float radius) { return 4.0f * RTK_PI * radius * radius; }

/* Square root of texture area over surface area, where all of a texture is on such an area. */
RTK_FN float rtk_area_density(float area)
{
    float density = 1.0f / rtk_sqrt(area);
    return area > 0.0f ? density : 0.0f;
}

/* That of a shape, its mean (of the face, for boxes). */
RTK_FN float rtk_shape_uv_scale(RT_GLOBAL const rtk_shape *s, rtk_vec3 ng)
{
    RT_GLOBAL const float *p = s->p;
    rtk_vec3 d;
    float area, slope;
    if (s->type == RTK_SHAPE_SPHERE) {
        area = rtk_sphere_area(p[3]);
    } else if (s->type == RTK_SHAPE_BOX) {
        area = rtk_box_area(rtk_at(p), rtk_at(p + 3), ng);
    } else if (s->type == RTK_SHAPE_TORUS) {
        area = 4.0f * RTK_PI * RTK_PI * p[3] * p[7];
    } else {
        float r1 = s->type == RTK_SHAPE_CONE ? p[7] : p[3];
        d = rtk_v3(p[4] - p[0], p[5] - p[1], p[6] - p[2]);
        slope = p[3] - r1;
        area = RTK_PI * (p[3] + r1) * rtk_sqrt(rtk_dot3(d, d) + slope * slope);
    }
    return rtk_area_density(area);
}

RTK_FN void rtk_surface_shape(RT_GLOBAL const rtk_group *group, RT_GLOBAL const rtk_geom *geom, rtk_ray ray, rtk_hit hit,
                              rtk_surface *s)
{
    RT_GLOBAL const rtk_shape *shape = &group->shapes[geom->first + hit.prim];
    rtk_vec3 p = rtk_ray_at(ray, hit.t);
    rtk_shape_point at;
    rtk_shape_surface(shape, p, &at);
    s->p = at.p;
    s->ng = at.ng;
    s->ns = at.ng;
    s->error = at.error;
    s->u = at.u;
    s->v = at.v;
    s->uv_scale = rtk_shape_uv_scale(shape, at.ng);
    s->face = hit.prim;
    if (geom->off_colors)
        s->tint = rtk_attribute3(group->attributes, geom->off_colors, hit.prim);
}

/* Signed distance of q from the plane with its last digits: differences and products are doubled. */
RTK_FN float rtk_plane_distance(rtk_vec3 q, rtk_vec3 point, rtk_vec3 n)
{
    rtk_ff a = rtk_ff_mul(rtk_two_diff(q.x, point.x), rtk_ff_make(n.x, 0.0f));
    rtk_ff b = rtk_ff_mul(rtk_two_diff(q.y, point.y), rtk_ff_make(n.y, 0.0f));
    rtk_ff c = rtk_ff_mul(rtk_two_diff(q.z, point.z), rtk_ff_make(n.z, 0.0f));
    return rtk_ff_add(rtk_ff_add(a, b), c).hi;
}

/* p brought onto the plane. */
RTK_FN rtk_vec3 rtk_plane_point(rtk_vec3 p, rtk_vec3 q, rtk_vec3 n)
{
    return rtk_madd(p, -rtk_plane_distance(p, q, n) / rtk_dot3(n, n), n);
}
RTK_FN float rtk_plane_error(rtk_vec3 p)
{
    return 2.3841858e-07f * rtk_maxabs(p);
}

/* The unit normal itself is rounded, but it is the plane's definition; what p loses is its own rounding and that of the
 * projection. u, v: distance from the plane's point along t_dir and across it; placement (texture size) is in uv_xfm. */
RTK_FN void rtk_surface_plane(RT_GLOBAL const rtk_group *group, RT_GLOBAL const rtk_geom *geom, rtk_ray ray, rtk_hit hit,
                              rtk_surface *s)
{
    RT_GLOBAL const rtk_shape *plane = &group->planes[geom->first];
    rtk_vec3 q = rtk_at(plane->p), n = rtk_at(plane->p + 4), x = rtk_at(geom->t_dir), d;
    rtk_vec3 p = rtk_plane_point(rtk_ray_at(ray, hit.t), q, n);
    d = rtk_sub(p, q);
    s->p = p;
    s->ng = n;
    s->ns = n;
    s->error = rtk_plane_error(p);
    s->u = rtk_dot3(d, x);
    s->v = rtk_dot3(d, rtk_cross3(n, x));
    s->uv_scale = 1.0f;
    s->face = 0u;
}

/* Rows of |m| times |x|, with the translation's size added. */
RTK_FN rtk_vec3 rtk_xfm_size(rtk_xfm a, rtk_vec3 x, float translation)
{
    rtk_vec3 s = rtk_vabs(x);
    return rtk_v3(rtk_fabs(a.m[0]) * s.x + rtk_fabs(a.m[1]) * s.y + rtk_fabs(a.m[2]) * s.z + translation * rtk_fabs(a.m[3]),
                  rtk_fabs(a.m[4]) * s.x + rtk_fabs(a.m[5]) * s.y + rtk_fabs(a.m[6]) * s.z + translation * rtk_fabs(a.m[7]),
                  rtk_fabs(a.m[8]) * s.x + rtk_fabs(a.m[9]) * s.y + rtk_fabs(a.m[10]) * s.z + translation * rtk_fabs(a.m[11]));
}

/* A point from the child's space to the world; returns the bound there. The bound: the object bound mapped; the rounding of M p
 * (4 u of |M| |p| + |m|); and the rounding a ray from p suffers on its way into the object, 5 u (|W| |p| + |w|) there, mapped
 * back. */
RTK_FN float rtk_place_point(rtk_xfm m, rtk_xfm w, float error, rtk_vec3 *p)
{
    rtk_vec3 e = rtk_xfm_size(m, rtk_v3(error, error, error), 0.0f), forth = rtk_xfm_size(m, *p, 1.0f), back;
    *p = rtk_xfm_point(m, *p);
    back = rtk_xfm_size(m, rtk_xfm_size(w, *p, 1.0f), 0.0f);
    return rtk_len(e) + 4.7683716e-07f * (rtk_len(forth) + rtk_len(back));
}

/* Likewise uv_scale, with the child's normal. */
RTK_FN float rtk_place_scale(rtk_xfm m, rtk_vec3 ng, float scale)
{
    rtk_vec3 x, y;
    float area;
    rtk_basis(ng, &x, &y);
    area = rtk_len(rtk_cross3(rtk_xfm_dir(m, x), rtk_xfm_dir(m, y)));
    return area > 0.0f ? scale / rtk_sqrt(area) : 0.0f;
}

RTK_FN void rtk_surface_place(RT_GLOBAL const rtk_instance *inst, rtk_xfm m, rtk_xfm w, rtk_surface *s)
{
    rtk_vec3 ng = s->ng;
    s->uv_scale = rtk_place_scale(m, ng, s->uv_scale);
    s->error = rtk_place_point(m, w, s->error, &s->p);
    s->ng = rtk_unit(rtk_xfm_normal(w, ng));
    s->ns = s->ns.x == ng.x && s->ns.y == ng.y && s->ns.z == ng.z ? s->ng : rtk_unit(rtk_xfm_normal(w, s->ns));
    s->inst_user_id = inst->user_id;
}

/* As a MOVING instance stands at the time. Its two maps are each rounded, so the bound grows by what they miss each other
 * (scene/motion.c). */
RTK_COLD void rtk_surface_place_moving(RT_GLOBAL const rtk_motion *motions, RT_GLOBAL const rtk_instance *inst, float time,
                                       rtk_surface *s)
{
    rtk_pose pose = rtk_pose_at(motions, inst, time);
    float more = 5.9604645e-08f * pose.segment->condition * (24.0f * pose.segment->size * rtk_len(s->p) + 8.0f * rtk_len(pose.t));
    rtk_surface_place(inst, rtk_pose_to_world(pose), rtk_pose_to_object(pose), s);
    s->error += more;
}

/* The material of a primitive: of the instance in which it is (NULL: none), if that has one, else of its face or geometry. */
RTK_FN rtk_u32 rtk_material_of(RT_GLOBAL const rtk_group *group, RT_GLOBAL const rtk_geom *geom, rtk_u32 prim,
                               RT_GLOBAL const rtk_instance *inst)
{
    if (inst && inst->material != RTK_INVALID)
        return inst->material;
    return geom->flags & RTK_GEOM_FACE_MATERIALS
               ? geom->material_base + rtk_attribute_u32(group->attributes, geom->off_materials, prim)
               : geom->material;
}

/* hit: one that a tracer gave for this ray (not a miss), at its time. */
RTK_FN rtk_surface rtk_surface_at(RT_GLOBAL const rtk_scene *scene, rtk_ray ray, rtk_hit hit, float time)
{
    rtk_u32 placed = hit.inst != RTK_INVALID;
    RT_GLOBAL const rtk_instance *inst = placed ? &scene->instances[hit.inst] : scene->instances;
    RT_GLOBAL const rtk_group *group = &scene->groups[placed ? inst->group : 0u];
    RT_GLOBAL const rtk_geom *geom = &group->geoms[hit.geom];
    rtk_surface s;
    float u, v;
    s.tint = rtk_v3(1.0f, 1.0f, 1.0f);
    s.uv_scale = 0.0f;
    s.inst_user_id = 0u;
    s.user_id = geom->user_id;
    s.material = rtk_material_of(group, geom, hit.prim, placed ? inst : NULL);
    if (placed)
        rtk_instance_ray(scene->motions, inst, time, &ray.org, &ray.dir);
    if (geom->type == RTK_GEOM_MESH)
        rtk_surface_mesh(group, geom, hit, &s);
    else if (geom->type == RTK_GEOM_SHAPES)
        rtk_surface_shape(group, geom, ray, hit, &s);
    else
        rtk_surface_plane(group, geom, ray, hit, &s);
    u = s.u;
    v = s.v;
    s.u = geom->uv_xfm[0] * u + geom->uv_xfm[1] * v + geom->uv_xfm[2];
    s.v = geom->uv_xfm[3] * u + geom->uv_xfm[4] * v + geom->uv_xfm[5];
    s.uv_scale *= rtk_sqrt(rtk_fabs(geom->uv_xfm[0] * geom->uv_xfm[4] - geom->uv_xfm[1] * geom->uv_xfm[3]));
    if (placed && inst->flags & RTK_INST_MOVING)
        rtk_surface_place_moving(scene->motions, inst, time, &s);
    else if (placed)
        rtk_surface_place(inst, inst->to_world, inst->to_object, &s);
    return s;
}

/* Where a ray that leaves the surface along dir starts: off it on the side of dir by twice the bound, once for p and once for the
 * leaf test of the new ray. error is at least 4 u |p|, so the sum moves even where p is large. */
RTK_FN rtk_vec3 rtk_leave(rtk_vec3 p, rtk_vec3 ng, float error, rtk_vec3 dir)
{
    float side = rtk_dot3(dir, ng) < 0.0f ? -1.0f : 1.0f;
    return rtk_madd(p, 2.0f * side * error, ng);
}

#endif
