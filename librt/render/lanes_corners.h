/* What stands at the corners of sixteen hits' triangles, in rows, for lanes_surface.c. Neighbours mostly hit one triangle, or a few
 * (sponza at 1000x700: one in 64 of 100 sheaves, four or fewer in 94), whose numbers are then loaded once and spread. */
#ifndef RTI_LANES_CORNERS_H
#define RTI_LANES_CORNERS_H

#include <stddef.h>

#include "../base/simd.h"
#include "lanes.h"

#define RTI_FACES_FEW 4u

/* Each lane's triangle, by its place in the group's; and where they are few the first lane of each, else count is 0. */
typedef struct rti_faces {
    uint32_t at[RTK_BLOCK] RTI_ROW;
    uint32_t count, lane[RTI_FACES_FEW];
} rti_faces;

/* Rows of three floats at each corner: the first corner's, the second's, the third's; and room. */
typedef struct rti_corners {
    float row[12][RTK_BLOCK] RTI_ROW;
} rti_corners;

/* at: filled in. */
static inline void rti_find_faces(rti_faces *f)
{
    uint32_t left = (1u << RTK_BLOCK) - 1;
    for (f->count = 0; left != 0; f->count++) {
        const uint32_t lane = (uint32_t)__builtin_ctz(left);
        if (f->count == RTI_FACES_FEW) {
            f->count = 0;
            return;
        }
        f->lane[f->count] = lane;
        left &= rti_u32_unlike(f->at, f->at[lane]);
    }
}

/* Numbers of face j into rows of its lanes; of the first one into all. */
static inline void rti_spread_face(const rti_faces *f, uint32_t j, const float *from, uint32_t n, float (*row)[RTK_BLOCK])
{
    const uint32_t at = f->at[f->lane[j]];
    for (uint32_t i = 0; i < n; i++) {
        const float x = from[i];
        if (j == 0) {
            RTI_EACH_LANE_INNER(k)
            row[i][k] = x;
        } else {
            RTI_EACH_LANE_INNER(k)
            row[i][k] = f->at[k] == at ? x : row[i][k];
        }
    }
}

static inline void rti_load_vertices(const rtk_group *g, const rti_faces *f, rti_corners *v)
{
    for (uint32_t j = 0; j < f->count; j++) {
        const float *from = (const float *)(const void *)&g->tris[f->at[f->lane[j]]]; /* the nine of its corners stand in a row */
        rti_spread_face(f, j, from, 9, v->row);
    }
    if (f->count != 0)
        return;
    for (uint32_t i = 0; i < 12; i += 4) { /* the last three are no corner's */
        const float *from[RTK_BLOCK];
        for (uint32_t k = 0; k < RTK_BLOCK; k++)
            from[k] = (const float *)(const void *)&g->tris[f->at[k]] + i;
        rti_rows4(from, v->row + i);
    }
}

/* An attribute of meshes: where rtk_geom has its offset; floats at a corner; and at all three of a geometry without it. */
typedef struct rti_attribute {
    size_t offset_at;
    uint32_t width;
    const float *none;
} rti_attribute;

static inline rtk_u64 rti_attribute_offset(const rtk_geom *geom, const rti_attribute *a)
{
    return *(const rtk_u64 *)(const void *)((const char *)geom + a->offset_at);
}

/* That of lane k's corners. */
static inline void rti_attribute_at(const rtk_group *g, const rti_sheaf *c, uint32_t k, const rti_attribute *a, float *to)
{
    const rtk_geom *geom = &g->geoms[c->geom[k]];
    const rtk_u64 offset = rti_attribute_offset(geom, a);
    for (uint32_t i = 0; i < 3; i++) {
        const float *from = a->none + a->width * i;
        if (offset != 0) { /* else there may be no attributes at all */
            const uint32_t *corners_of = (const uint32_t *)(const void *)(g->attributes + geom->off_indices);
            const float *all = (const float *)(const void *)(g->attributes + offset);
            from = all + a->width * (size_t)corners_of[3 * (size_t)c->prim[k] + i];
        }
        for (uint32_t j = 0; j < a->width; j++)
            to[a->width * i + j] = from[j];
    }
}

static inline void rti_load_attribute(const rtk_group *g, const rti_sheaf *c, const rti_faces *f, rti_attribute a,
                                      float (*row)[RTK_BLOCK])
{
    float some[9];
    for (uint32_t j = 0; j < f->count; j++) {
        rti_attribute_at(g, c, f->lane[j], &a, some);
        rti_spread_face(f, j, some, 3 * a.width, row);
    }
    if (f->count != 0)
        return;
    for (uint32_t k = 0; k < RTK_BLOCK; k++) {
        rti_attribute_at(g, c, k, &a, some);
        for (uint32_t i = 0; i < 3 * a.width; i++)
            row[i][k] = some[i];
    }
}

#endif
