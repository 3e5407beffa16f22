/* What the calls of librt/tree.h share: a tree of a committed scene, chosen and present. */
#ifndef RTI_LOOK_H
#define RTI_LOOK_H

#include "../trace/trace.h"
#include "librt/tree.h"
#include "parts.h"

/* A snapshot with the tree that a query names. */
typedef struct rti_look {
    rti_snapshot *snapshot;
    const rti_tracer *tracer;
    const rti_chunk *tree; /* NULL: the tracer walks none, or nothing stands in it */
    rt_tree_query query;
} rti_look;

/* Checks the query and builds what is missing; on RT_OK the snapshot is the caller's to release. */
rt_status rti_look_begin(const rt_scene *scene, const char *call, const rt_tree_query *query, rti_look *look);
/* STATE, or the snapshot with a reference more. */
rt_status rti_look_snapshot(const rt_scene *scene, const char *call, rti_snapshot **snapshot);
rt_status rti_look_group(const rti_snapshot *s, const char *call, uint32_t group);

/* A plane, asked in double: which side is p on? < 0 is the far one, the way against the normal. */
typedef struct rti_cut_plane {
    double point[3], normal[3];
} rti_cut_plane;
rt_status rti_cut_take(rt_context *ctx, const char *call, rt_vec3 point, rt_vec3 normal, rti_cut_plane *plane);
static inline double rti_cut_side(const rti_cut_plane *plane, const double p[3])
{
    return plane->normal[0] * (p[0] - plane->point[0]) + plane->normal[1] * (p[1] - plane->point[1]) +
           plane->normal[2] * (p[2] - plane->point[2]);
}
/* Where the plane crosses from a (side sa) to b (side sb), one of them below zero. */
static inline rt_vec3 rti_cut_cross(const double a[3], double sa, const double b[3], double sb)
{
    double w = sa / (sa - sb), p[3];
    for (int i = 0; i < 3; i++)
        p[i] = a[i] == b[i] ? a[i] : a[i] + w * (b[i] - a[i]);
    return (rt_vec3){(float)p[0], (float)p[1], (float)p[2]};
}
/* The polygon in which the plane meets a box: its number of corners, 0 when it does not. */
uint32_t rti_cut_box(const rti_cut_plane *plane, const float lo[3], const float hi[3], rt_vec3 corners[6]);

#endif
