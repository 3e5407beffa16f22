/* Checks of what comes from a file: the geometry of a group, its records, attributes and trees. */
#include "blob.h"

#include <math.h>
#include <string.h>

typedef struct group_view {
    const rti_snapshot *snapshot;
    const rti_part_group *part;
    const rtk_group_header *head;
    const rtk_geometry_header *records;
    const rtk_geom *geoms;
    uint32_t materials;
} group_view;

/* Primitive i of a kind is the one that its geometry says it is, so ids in hits lead back to it. */
static bool named(const group_view *g, uint32_t type, uint32_t geom, uint32_t prim, uint32_t i)
{
    return geom < g->records->geom_count && g->geoms[geom].type == type && prim < g->geoms[geom].prim_count &&
           g->geoms[geom].first + (uint64_t)prim == i;
}

/* What the checks of rt_scene_add_* let through. */
static bool sound_shape(const rtk_shape *s)
{
    const float *p = s->p;
    double n = (double)p[4] * p[4] + (double)p[5] * p[5] + (double)p[6] * p[6];
    bool axis = fabs(n - 1.0) < 1.0e-5;
    if (!rti_blob_finite(p, 12, RTI_COORD_MAX))
        return false;
    switch (s->type) {
    case RTK_SHAPE_SPHERE:
        return p[3] > 0.0f;
    case RTK_SHAPE_BOX:
        return p[0] < p[3] && p[1] < p[4] && p[2] < p[5];
    case RTK_SHAPE_CYLINDER:
        return p[3] > 0.0f && (p[0] != p[4] || p[1] != p[5] || p[2] != p[6]);
    case RTK_SHAPE_CONE:
        return p[3] >= 0.0f && p[7] >= 0.0f && p[3] + p[7] > 0.0f && (p[0] != p[4] || p[1] != p[5] || p[2] != p[6]);
    case RTK_SHAPE_TORUS:
        return p[7] > 0.0f && p[7] < p[3] && axis;
    default:
        return s->type == RTK_SHAPE_PLANE && axis;
    }
}

static const char *check_prims(const group_view *g)
{
    const rtk_group_header *head = g->head;
    const rtk_tri *tri = rti_chunk_at(g->part->group, head->off_tris);
    const rtk_shape *shape = rti_chunk_at(g->part->group, head->off_shapes),
                    *plane = rti_chunk_at(g->part->group, head->off_planes);
    for (uint32_t i = 0; i < head->tri_count; i++) {
        if (!named(g, RTK_GEOM_MESH, tri[i].geom, tri[i].prim, i) || !rti_blob_finite(tri[i].v0, 9, RTI_COORD_MAX))
            return "a triangle is not of its mesh, or not finite";
    }
    for (uint32_t i = 0; i < head->shape_count; i++) {
        if (shape[i].type == RTK_SHAPE_PLANE || !named(g, RTK_GEOM_SHAPES, shape[i].geom, shape[i].prim, i) ||
            !sound_shape(&shape[i]) || shape[i].type != shape[g->geoms[shape[i].geom].first].type)
            return "a shape is not of its geometry, or impossible";
    }
    for (uint32_t i = 0; i < head->plane_count; i++) {
        if (plane[i].type != RTK_SHAPE_PLANE || !named(g, RTK_GEOM_PLANE, plane[i].geom, plane[i].prim, i) ||
            !sound_shape(&plane[i]))
            return "a plane is not of its geometry, or impossible";
    }
    return NULL;
}

static const char *check_bounds(const group_view *g)
{
    rtk_group_header again = *g->head;
    rti_group_measure(g->snapshot->ctx, &again, g->part->group->data);
    return memcmp(&again, g->head, sizeof again) == 0 ? NULL : "a group's bounds are not those of its geometry";
}

/* ---- records and attributes ---- */

static bool floats_at(const rti_chunk *chunk, uint64_t offset, uint64_t count, unsigned width)
{
    return !offset || (rti_blob_span(chunk, RTI_ATTRIBUTE_HEADER, offset, count, width * sizeof(float)) &&
                       rti_blob_finite(rti_chunk_at(chunk, offset), count * width, 3.0e38f));
}

static bool ids_below(const rti_chunk *chunk, uint64_t offset, uint64_t count, unsigned width, uint64_t limit)
{
    const uint32_t *id;
    if (!offset)
        return true;
    if (!rti_blob_span(chunk, RTI_ATTRIBUTE_HEADER, offset, count, width * sizeof *id))
        return false;
    id = rti_chunk_at(chunk, offset);
    for (uint64_t i = 0; i < count * width; i++) {
        if (id[i] >= limit)
            return false;
    }
    return true;
}

static const char *check_attributes(const group_view *g, const rtk_geom *geom)
{
    const rti_chunk *chunk = g->part->attribute;
    bool mesh = geom->type == RTK_GEOM_MESH, has_faces = geom->off_materials != 0;
    uint64_t vertices = mesh ? geom->vertex_count : geom->prim_count, triples = geom->prim_count;
    if (has_faces != ((geom->flags & RTK_GEOM_FACE_MATERIALS) != 0))
        return "a geometry is marked wrongly as having materials of its faces";
    if (!(geom->off_indices | geom->off_normals | geom->off_uvs | geom->off_colors | geom->off_materials | geom->off_faces))
        return NULL;
    if (!chunk || geom->prim_count == 0)
        return "a geometry's attributes are not there";
    if (mesh && (geom->off_normals | geom->off_uvs | geom->off_colors) && !geom->off_indices)
        return "a mesh has attributes of vertices and no indices";
    if (!floats_at(chunk, geom->off_normals, vertices, 3) || !floats_at(chunk, geom->off_uvs, vertices, 2) ||
        !floats_at(chunk, geom->off_colors, vertices, 3))
        return "attributes of vertices do not fit their chunk, or are not finite";
    if (!ids_below(chunk, geom->off_indices, triples, 3, vertices))
        return "an index of a mesh is out of its range";
    if (!ids_below(chunk, geom->off_materials, geom->prim_count, 1, g->materials - (uint64_t)geom->material_base))
        return "a face names a material that is not there";
    return ids_below(chunk, geom->off_faces, geom->prim_count, 1, 1ull << 32) ? NULL
                                                                              : "the table of faces does not fit its chunk";
}

static const char *check_records(const group_view *g)
{
    const uint32_t count[] = {g->head->tri_count, g->head->shape_count, g->head->plane_count};
    uint64_t next[] = {0, 0, 0};
    for (uint32_t i = 0; i < g->records->geom_count; i++) {
        const rtk_geom *geom = &g->geoms[i];
        const char *what;
        if (geom->type > RTK_GEOM_PLANE || (geom->flags & ~(RTK_GEOM_ALPHA | RTK_GEOM_FACE_MATERIALS)) ||
            (geom->type == RTK_GEOM_PLANE && geom->prim_count > 1))
            return "a geometry is of no known type";
        if (geom->prim_count > 0 && (uint64_t)geom->first + geom->prim_count > count[geom->type])
            return "a geometry has more primitives than there are";
        if (geom->prim_count > 0 && geom->first != next[geom->type]) /* tracers tell a triangle's mesh by its place */
            return "geometries do not stand side by side";
        next[geom->type] += geom->prim_count;
        if (geom->material >= g->materials || geom->material_base >= g->materials)
            return "a geometry names a material that is not there";
        if (!rti_blob_finite(geom->uv_xfm, 6, 3.0e38f) || !rti_blob_finite(geom->t_dir, 3, 2.0f))
            return "a texture's placement is none";
        if ((what = check_attributes(g, geom)) != NULL)
            return what;
    }
    return NULL;
}

static const char *check_trees(const group_view *g)
{
    for (uint32_t n = 0; n < RTK_PARTS * RTI_TREE_KINDS; n++) {
        uint32_t p = n % RTK_PARTS;
        const rti_chunk *tree = g->part->tree[p][n / RTK_PARTS];
        if (tree &&
            (p >= g->head->part_count || !rti_tree_valid(tree->data, tree->size, g->head->tri_count + g->head->shape_count) ||
             !rti_tree_copies_valid(tree->data, rti_chunk_at(g->part->group, g->head->off_tris), g->head->tri_count,
                                    rti_chunk_at(g->part->group, g->head->off_shapes)) ||
             !rti_tree_is_over(tree->data, g->head->parts[p].lo, g->head->parts[p].hi)))
            return "a tree is not sound";
    }
    return NULL;
}

/* Ascending lists that hold each primitive once. */
static const char *check_list(const group_view *g)
{
    const rtk_group_header *h = g->head;
    uint32_t count = h->tri_count + h->shape_count, at[RTK_PARTS] = {0};
    uint64_t sum = 0;
    if (h->part_count <= 1)
        return h->off_list == 0 && h->part_count == (count > 0) ? NULL : "a group's parts are not there";
    for (uint32_t p = 0; p < h->part_count && p < RTK_PARTS; p++)
        sum += h->parts[p].count;
    if (h->part_count > RTK_PARTS || sum != count ||
        !rti_blob_span(g->part->group, sizeof *h, h->off_list, count, sizeof(uint32_t)))
        return "the list of a group's parts does not fit its chunk";
    for (uint32_t i = 0; i < count; i++) {
        uint32_t p = 0;
        while (p < h->part_count && (at[p] == h->parts[p].count || rti_part_list(g->part->group, p)[at[p]] != i))
            p++;
        if (p == h->part_count)
            return "a primitive is in no part, or a list of parts is not in order";
        at[p]++;
    }
    return NULL;
}

static const char *check_layout(const group_view *g)
{
    const rtk_group_header *h = g->head;
    if ((uint64_t)h->tri_count + h->shape_count > RTI_MAX_PRIMS || h->plane_count > RTI_MAX_PRIMS ||
        !rti_blob_span(g->part->group, sizeof *h, h->off_tris, h->tri_count, sizeof(rtk_tri)) ||
        !rti_blob_span(g->part->group, sizeof *h, h->off_shapes, h->shape_count, sizeof(rtk_shape)) ||
        !rti_blob_span(g->part->group, sizeof *h, h->off_planes, h->plane_count, sizeof(rtk_shape)))
        return "a group's geometry does not fit its chunk";
    if (g->records->geom_count > RTI_MAX_PRIMS ||
        !rti_blob_span(g->part->geometry, sizeof *g->records, g->records->off_geoms, g->records->geom_count, sizeof(rtk_geom)))
        return "a group's table of geometries does not fit its chunk";
    return NULL;
}

const char *rti_blob_check_group(const rti_snapshot *snapshot, uint32_t group)
{
    const rti_part_group *part = &snapshot->groups[group];
    group_view g = {.snapshot = snapshot, .part = part, .head = part->group->data, .records = part->geometry->data};
    const char *what = check_layout(&g);
    if (!what)
        what = check_list(&g);
    if (what)
        return what;
    g.geoms = rti_chunk_at(part->geometry, g.records->off_geoms);
    g.materials = ((const rtk_material_header *)snapshot->materials->data)->material_count;
    if (part->material_base >= g.materials)
        return "a group's materials are not there";
    if (!what)
        what = check_records(&g);
    if (!what)
        what = check_prims(&g);
    if (!what)
        what = check_bounds(&g);
    return what ? what : check_trees(&g);
}
