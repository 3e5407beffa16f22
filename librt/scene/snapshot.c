/* Snapshots: counted sets of chunks and the view that kernels use. */
#include "../trace/trace.h"
#include "parts.h"

#include <float.h>
#include <string.h>

rti_snapshot *rti_snapshot_new(rt_context *ctx, uint32_t group_count, uint32_t texture_count)
{
    rti_layout layout;
    uint64_t groups, textures, view_groups, view_textures;
    uint8_t *base;
    rti_snapshot *s;
    rti_layout_begin(&layout, sizeof *s);
    groups = rti_layout_add(&layout, group_count, sizeof(rti_part_group));
    textures = rti_layout_add(&layout, texture_count, sizeof(rti_chunk *));
    view_groups = rti_layout_add(&layout, group_count, sizeof(rtk_group));
    view_textures = rti_layout_add(&layout, texture_count, sizeof(rtk_texture));
    base = layout.overflow ? NULL : rti_alloc_zero(ctx, layout.size);
    if (!base)
        return NULL;
    s = (rti_snapshot *)(void *)base;
    s->ctx = ctx;
    s->size = layout.size;
    atomic_init(&s->refs, 1);
    s->group_count = group_count;
    s->texture_count = texture_count;
    s->groups = (rti_part_group *)(void *)(base + groups);
    s->textures = (rti_chunk **)(void *)(base + textures);
    s->view_groups = (rtk_group *)(void *)(base + view_groups);
    s->view_textures = (rtk_texture *)(void *)(base + view_textures);
    return s;
}

static size_t view_size(const rti_snapshot *s, const struct rti_cell_view *view)
{
    return view->groups ? s->group_count * sizeof *view->groups : 0;
}

void rti_snapshot_retain(rti_snapshot *snapshot)
{
    atomic_fetch_add_explicit(&snapshot->refs, 1, memory_order_relaxed);
}

void rti_snapshot_release(rti_snapshot *s)
{
    if (!s || atomic_fetch_sub_explicit(&s->refs, 1, memory_order_acq_rel) != 1)
        return;
    for (uint32_t i = 0; i < s->group_count; i++) {
        rti_chunk_release(s->groups[i].group);
        rti_chunk_release(s->groups[i].attribute);
        rti_chunk_release(s->groups[i].geometry);
        for (uint32_t p = 0; p < RTK_PARTS; p++) {
            for (uint32_t k = 0; k < RTI_TREE_KINDS; k++)
                rti_chunk_release(s->groups[i].tree[p][k]);
        }
    }
    for (uint32_t i = 0; i < s->texture_count; i++)
        rti_chunk_release(s->textures[i]);
    for (uint32_t k = 0; k < RTI_TREE_KINDS; k++)
        rti_chunk_release(s->top_tree[k]);
    rti_chunk_release(s->top);
    rti_chunk_release(s->materials);
    rti_chunk_release(s->lights);
    rti_chunk_release(s->world);
    rti_free(s->ctx, s->kdtree_view.groups, view_size(s, &s->kdtree_view));
    rti_free(s->ctx, s->octree_view.groups, view_size(s, &s->octree_view));
    rti_free(s->ctx, s, s->size);
}

uint32_t rti_tree_part(const rti_part_group *group, const rti_chunk *tree)
{
    uint32_t kind = ((const rtk_tree_header *)tree->data)->kind, part = 0;
    while (part + 1 < RTK_PARTS && group->tree[part][kind] != tree)
        part++;
    return part;
}

void rti_trees_retain(rti_part_group *to, const rti_part_group *from)
{
    for (uint32_t p = 0; p < RTK_PARTS; p++) {
        for (uint32_t k = 0; k < RTI_TREE_KINDS; k++)
            to->tree[p][k] = rti_chunk_retain(from->tree[p][k]);
    }
}

void rti_snapshot_each(const rti_snapshot *s, rti_chunk_visit visit, void *data)
{
    for (uint32_t i = 0; i < s->group_count; i++) {
        const rti_part_group *g = &s->groups[i];
        visit(data, g->group, i);
        if (g->attribute)
            visit(data, g->attribute, i);
        visit(data, g->geometry, i);
        for (uint32_t n = 0; n < RTK_PARTS * RTI_TREE_KINDS; n++) {
            const rti_chunk *tree = g->tree[n % RTK_PARTS][n / RTK_PARTS];
            if (tree)
                visit(data, tree, i);
        }
    }
    visit(data, s->top, RTK_INVALID);
    for (uint32_t k = 1; k < RTI_TREE_KINDS; k++) {
        if (s->top_tree[k])
            visit(data, s->top_tree[k], RTK_INVALID);
    }
    visit(data, s->materials, RTK_INVALID);
    for (uint32_t i = 0; i < s->texture_count; i++)
        visit(data, s->textures[i], RTK_INVALID);
    visit(data, s->lights, RTK_INVALID);
    visit(data, s->world, RTK_INVALID);
}

/* ---- the view ---- */

static rtk_tree tree_view(const rti_chunk *chunk)
{
    rtk_tree none;
    if (chunk)
        return rti_tree_view(chunk->data);
    memset(&none, 0, sizeof none);
    return none;
}

static rtk_vec3 vec(const float p[3])
{
    return rtk_v3(p[0], p[1], p[2]);
}

static rtk_part part_view(const rti_part_group *group, uint32_t index)
{
    const rtk_part_header *head = &((const rtk_group_header *)group->group->data)->parts[index];
    rtk_part p;
    memset(&p, 0, sizeof p);
    p.lo = vec(head->lo);
    p.hi = vec(head->hi);
    p.scale = head->scale;
    p.count = head->count;
    p.all.refs = rti_part_list(group->group, index);
    p.kdtree = tree_view(group->tree[index][RTK_TREE_KD]);
    p.octree = tree_view(group->tree[index][RTK_TREE_OCTREE]);
    p.bvh = tree_view(group->tree[index][RTK_TREE_BVH]);
    return p;
}

uint32_t rti_group_flags(const rtk_geom *geoms, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        if (geoms[i].mask != 0xffffffffu || (geoms[i].flags & RTK_GEOM_ALPHA))
            return 0;
    return RTK_GROUP_PLAIN;
}

static rtk_group group_view(const rti_part_group *part)
{
    const rtk_group_header *head = part->group->data;
    const rtk_geometry_header *geometry = part->geometry->data;
    rtk_group g;
    memset(&g, 0, sizeof g);
    g.lo = vec(head->lo);
    g.hi = vec(head->hi);
    g.tri_count = head->tri_count;
    g.shape_count = head->shape_count;
    g.plane_count = head->plane_count;
    g.tris = rti_chunk_at(part->group, head->off_tris);
    g.shapes = rti_chunk_at(part->group, head->off_shapes);
    g.planes = rti_chunk_at(part->group, head->off_planes);
    g.geoms = rti_chunk_at(part->geometry, geometry->off_geoms);
    g.geom_count = geometry->geom_count;
    g.flags = rti_group_flags(g.geoms, g.geom_count);
    g.attributes = part->attribute ? part->attribute->data : NULL;
    g.part_count = head->part_count;
    for (uint32_t i = 0; i < head->part_count; i++)
        g.parts[i] = part_view(part, i);
    return g;
}

static void view_top(rti_snapshot *s)
{
    const rtk_top_header *top = s->top->data;
    rtk_scene *v = &s->view;
    v->instance_count = top->instance_count;
    v->unbounded_count = top->unbounded_count;
    v->instances = rti_chunk_at(s->top, top->off_instances);
    v->unbounded = rti_chunk_at(s->top, top->off_unbounded);
    v->motions = rti_chunk_at(s->top, top->off_motions);
    v->top_lo = vec(top->lo);
    v->top_hi = vec(top->hi);
    v->top_scale = top->scale;
    v->top_kdtree = tree_view(s->top_tree[RTK_TREE_KD]);
    v->top_octree = tree_view(s->top_tree[RTK_TREE_OCTREE]);
    v->top_bvh = tree_view(s->top_tree[RTK_TREE_BVH]);
}

uint32_t rti_trace_flags(const rtk_scene *scene)
{
    const rtk_group *g = scene->groups;
    const bool alone = scene->instance_count == 0 && g->shape_count == 0 && g->plane_count == 0;
    const bool mesh = alone && g->part_count == 1 && (g->flags & RTK_GROUP_PLAIN) && rtk_scale_ordinary(g->parts[0].scale);
    uint32_t flags = mesh ? RTK_SCENE_MESH : 0u;
    for (uint32_t k = 1; k < scene->group_count; k++)
        flags |= scene->groups[k].shape_count != 0 ? RTK_SCENE_BODIES : 0u;
    return flags;
}

static uint32_t scene_flags(const rtk_scene *v)
{
    uint32_t flags = rti_trace_flags(v);
    for (uint32_t i = 0; i < v->material_count; i++) {
        uint32_t m = v->materials[i].flags;
        flags |= (m & RTK_MAT_TRANSPARENT) && !(m & RTK_MAT_OPAQUE_SHADOW) ? RTK_SCENE_TRANSPARENT : 0u;
    }
    for (uint32_t i = 0; i < v->instance_count; i++)
        flags |= v->instances[i].flags & RTK_INST_MOVING ? RTK_SCENE_MOVING : 0u;
    for (uint32_t k = 0; k < v->group_count; k++) {
        for (uint32_t i = 0; i < v->groups[k].geom_count; i++)
            flags |= v->groups[k].geoms[i].flags & RTK_GEOM_ALPHA ? RTK_SCENE_ALPHA : 0u;
    }
    return flags;
}

/* The scene by trees of a kind, if it has all of them: to *by. */
static rt_status view_by(rti_snapshot *s, const char *call, uint32_t kind, struct rti_cell_view *view, const rtk_scene **by)
{
    if (!rti_snapshot_complete(s, kind))
        return RT_OK;
    view->groups = rti_alloc(s->ctx, s->group_count * sizeof *view->groups);
    if (!view->groups)
        return rti_fail_memory(s->ctx, call, s->group_count * sizeof *view->groups);
    rti_trace_by(kind, &s->view, &view->scene, view->groups);
    *by = &view->scene;
    return RT_OK;
}

rt_status rti_snapshot_finish(rti_snapshot *s, const char *call)
{
    const rtk_material_header *materials = s->materials->data;
    const rtk_light_header *lights = s->lights->data;
    rtk_scene *v = &s->view;
    memset(v, 0, sizeof *v);
    for (uint32_t i = 0; i < s->group_count; i++)
        s->view_groups[i] = group_view(&s->groups[i]);
    for (uint32_t i = 0; i < s->texture_count; i++)
        s->view_textures[i].head = s->textures[i]->data;
    v->groups = s->view_groups;
    v->group_count = s->group_count;
    view_top(s);
    v->materials = rti_chunk_at(s->materials, materials->off_materials);
    v->material_count = materials->material_count;
    v->textures = s->view_textures;
    v->texture_count = s->texture_count;
    v->lights = rti_chunk_at(s->lights, lights->off_lights);
    v->light_count = lights->light_count;
    v->world = s->world->data;
    v->flags = scene_flags(v);
    const rt_status status = view_by(s, call, RTK_TREE_KD, &s->kdtree_view, &v->by_kdtree);
    return status == RT_OK ? view_by(s, call, RTK_TREE_OCTREE, &s->octree_view, &v->by_octree) : status;
}

const rtk_scene *rti_snapshot_view(const rti_snapshot *snapshot)
{
    return &snapshot->view;
}

const struct rti_tracer *rti_snapshot_tracer(const rti_snapshot *snapshot)
{
    return snapshot->tracer;
}

static void add_bytes(void *data, const rti_chunk *chunk, uint32_t group)
{
    (void)group;
    *(uint64_t *)data += chunk->size;
}

uint64_t rti_snapshot_bytes(const rti_snapshot *snapshot)
{
    uint64_t bytes = snapshot->size + view_size(snapshot, &snapshot->kdtree_view) + view_size(snapshot, &snapshot->octree_view);
    rti_snapshot_each(snapshot, add_bytes, &bytes);
    return bytes;
}

void rti_snapshot_bounds(const rti_snapshot *snapshot, rtk_vec3 *lo, rtk_vec3 *hi)
{
    const rtk_group *own = snapshot->view.groups;
    const rtk_top_header *top = snapshot->top->data;
    const float *a = top->all_lo, *b = top->all_hi;
    *lo = rtk_v3(rtk_min(own->lo.x, a[0]), rtk_min(own->lo.y, a[1]), rtk_min(own->lo.z, a[2]));
    *hi = rtk_v3(rtk_max(own->hi.x, b[0]), rtk_max(own->hi.y, b[1]), rtk_max(own->hi.z, b[2]));
}

static void add_hash(void *data, const rti_chunk *chunk, uint32_t group)
{
    if (chunk->kind == RTK_CHUNK_TREE)
        return;
    rti_hasher_add(data, &group, sizeof group);
    rti_hasher_add(data, &chunk->hash, sizeof chunk->hash);
}

rti_hash rti_snapshot_hash(const rti_snapshot *snapshot)
{
    rti_hasher h;
    rti_hasher_init(&h);
    rti_snapshot_each(snapshot, add_hash, &h);
    return rti_hasher_end(&h);
}
