/* Commit: the records of geometries, for the scene itself and for the groups it instances. */
#include "parts.h"

#include <string.h>

/* Placement of a plane's texture: from lengths in the plane to (u, v), then the description's own map. Without a height the
 * image's shape gives it. */
static void place_plane(const rti_commit *c, const rti_plane *plane, uint32_t material, rtk_geom *out)
{
    const rtk_material *m = RTI_AT(c->scene->materials, rtk_material, material);
    float height = plane->height, a = 1.0f / plane->width, e;
    if (!(height > 0.0f) && m->color_tex != RTK_INVALID) {
        const rtk_texture_header *head = RTI_AT(c->scene->textures, rti_texture, m->color_tex)->chunk->data;
        height = plane->width * (float)head->height / (float)head->width;
    }
    e = 1.0f / (height > 0.0f ? height : plane->width);
    out->uv_xfm[0] *= a;
    out->uv_xfm[1] *= e;
    out->uv_xfm[3] *= a;
    out->uv_xfm[4] *= e;
    memcpy(out->t_dir, plane->t_dir, sizeof out->t_dir);
}

static bool has_alpha(const rti_geometry *g, const rtk_material *materials)
{
    if (!g->mesh || !g->mesh->materials)
        return materials[g->material].alpha_tex != RTK_INVALID;
    for (uint32_t i = 0; i < g->count; i++) {
        if (materials[g->mesh->materials[i]].alpha_tex != RTK_INVALID)
            return true;
    }
    return false;
}

static bool any_alpha(const rtk_material *materials, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (materials[i].alpha_tex != RTK_INVALID)
            return true;
    }
    return false;
}

typedef struct counters {
    rti_layout attributes; /* walks as the attribute chunk was laid out */
    uint32_t tris, shapes, planes;
} counters;

static void fill_own(const rti_commit *c, const rti_geometry *g, bool alpha, counters *at, rtk_geom *out)
{
    out->type = g->type;
    out->mask = g->mask;
    out->material = g->material;
    out->user_id = g->user_id;
    memcpy(out->uv_xfm, g->uv_xfm, sizeof out->uv_xfm);
    if (!g->alive)
        return;
    out->prim_count = g->count;
    if (g->mesh)
        rti_plan_attributes(&at->attributes, g, out);
    if (out->off_materials)
        out->flags |= RTK_GEOM_FACE_MATERIALS;
    if (alpha && has_alpha(g, c->scene->materials.data))
        out->flags |= RTK_GEOM_ALPHA;
    if (g->type == RTK_GEOM_MESH) {
        out->first = at->tris;
        at->tris += g->count;
    } else if (g->type == RTK_GEOM_SHAPES) {
        out->first = at->shapes;
        at->shapes += g->count;
    } else {
        out->first = at->planes++;
        place_plane(c, RTI_AT(c->scene->planes, rti_plane, g->first), g->material, out);
    }
}

static void fill_lamps(const rti_commit *c, counters *at, rtk_geom *out)
{
    for (uint32_t i = 0; i < c->lamp_count; i++, out++) {
        out->type = RTK_GEOM_SHAPES;
        out->prim_count = 1;
        out->first = at->shapes++;
        out->mask = RT_MASK_ALL;
        out->material = (uint32_t)c->scene->materials.count + i;
        out->user_id = RTK_INVALID;
        out->uv_xfm[0] = 1.0f;
        out->uv_xfm[4] = 1.0f;
    }
}

static rtk_geometry_header *make_block(rti_commit *c, size_t count, size_t *size, rt_status *status)
{
    rtk_geometry_header *head;
    rti_layout layout;
    uint64_t offset;
    rti_layout_begin(&layout, sizeof *head);
    offset = rti_layout_add(&layout, count, sizeof(rtk_geom));
    *size = layout.size;
    head = layout.overflow ? NULL : rti_alloc_zero(c->scene->ctx, layout.size);
    *status = head ? RT_OK : rti_fail_memory(c->scene->ctx, c->call, layout.size);
    if (head) {
        head->geom_count = (uint32_t)count;
        head->off_geoms = offset;
    }
    return head;
}

static rtk_geom *geoms_of(rtk_geometry_header *head)
{
    return (rtk_geom *)(void *)((uint8_t *)head + head->off_geoms);
}

static rt_status make_own(rti_commit *c)
{
    const rt_scene *scene = c->scene;
    counters at = {.tris = 0};
    bool alpha = any_alpha(scene->materials.data, scene->materials.count);
    size_t size;
    rt_status status;
    rtk_geometry_header *head = make_block(c, scene->geometries.count + c->lamp_count, &size, &status);
    if (!head)
        return status;
    rti_layout_begin(&at.attributes, RTI_ATTRIBUTE_HEADER);
    for (size_t i = 0; i < scene->geometries.count; i++)
        fill_own(c, RTI_AT(scene->geometries, rti_geometry, i), alpha, &at, &geoms_of(head)[i]);
    fill_lamps(c, &at, geoms_of(head) + scene->geometries.count);
    return rti_commit_chunk(c, RTK_CHUNK_GEOMETRY, head, size, &c->next->groups[0].geometry);
}

/* Some instance of the child lays a material with an alpha map over it: then all its leaf tests have to ask. */
static bool covered_by_alpha(const rti_commit *c, uint32_t child)
{
    const rtk_material *materials = c->scene->materials.data;
    for (size_t i = 0; i < c->scene->instances.count; i++) {
        const rti_inst *inst = RTI_AT(c->scene->instances, rti_inst, i);
        if (inst->child == c->child_scenes[child] && inst->material != RT_INVALID_ID &&
            materials[inst->material].alpha_tex != RTK_INVALID)
            return true;
    }
    return false;
}

static rt_status make_child(rti_commit *c, uint32_t child)
{
    const rti_chunk *from = c->children[child]->groups[0].geometry;
    rti_part_group *group = &c->next->groups[child + 1];
    rtk_geometry_header *head = rti_alloc(c->scene->ctx, from->size);
    bool alpha = covered_by_alpha(c, child);
    if (!head)
        return rti_fail_memory(c->scene->ctx, c->call, from->size);
    memcpy(head, from->data, from->size);
    for (uint32_t i = 0; i < head->geom_count; i++) {
        rtk_geom *g = &geoms_of(head)[i];
        g->material += group->material_base;
        g->material_base += group->material_base;
        g->flags |= alpha ? RTK_GEOM_ALPHA : 0u;
    }
    return rti_commit_chunk(c, RTK_CHUNK_GEOMETRY, head, from->size, &group->geometry);
}

rt_status rti_commit_geometry(rti_commit *c)
{
    rt_status status = make_own(c);
    for (uint32_t i = 0; status == RT_OK && i < c->child_count; i++) {
        c->next->groups[i + 1].group = rti_chunk_retain(c->children[i]->groups[0].group);
        c->next->groups[i + 1].attribute = rti_chunk_retain(c->children[i]->groups[0].attribute);
        rti_trees_retain(&c->next->groups[i + 1], &c->children[i]->groups[0]);
        status = make_child(c, i);
    }
    return status;
}
