/* What a committed scene holds. */
#include <string.h>

#include "parts.h"

static rti_snapshot *committed(const rt_scene *scene, const char *call)
{
    rti_snapshot *s = rti_scene_snapshot(scene);
    if (!s)
        rti_fail(scene->ctx, RT_ERROR_STATE, "%s: the scene was never committed; call rt_scene_commit first", call);
    return s;
}

rt_status rt_scene_hash(const rt_scene *scene, char text[33])
{
    RTI_NEED(scene);
    rti_snapshot *s = committed(scene, "rt_scene_hash");
    if (!s)
        return RT_ERROR_STATE;
    rti_hash_text(text, rti_snapshot_hash(s));
    rti_snapshot_release(s);
    return RT_OK;
}

static void add_rest(void *data, const rti_chunk *chunk, uint32_t group)
{
    if (chunk->kind == RTK_CHUNK_TREE || chunk->kind == RTK_CHUNK_MATERIAL || chunk->kind == RTK_CHUNK_TEXTURE ||
        chunk->kind == RTK_CHUNK_WORLD)
        return;
    rti_hasher_add(data, &group, sizeof group);
    rti_hasher_add(data, &chunk->hash, sizeof chunk->hash);
}

/* A texture by its content; where it stands among the others is of no matter. */
static void add_texture(rti_hasher *h, const rti_snapshot *s, uint32_t texture)
{
    rti_hash none = {0, 0};
    rti_hasher_add(h, texture < s->texture_count ? &s->textures[texture]->hash : &none, sizeof none);
}

static rti_hash hash_rest(const rti_snapshot *s)
{
    const rtk_scene *v = &s->view;
    rtk_world world = *v->world;
    float growth = 0.0f; /* of rays, by which the film's unit is chosen */
    rti_hasher h;
    rti_hasher_init(&h);
    rti_snapshot_each(s, add_rest, &h);
    add_texture(&h, s, world.background_tex);
    world.background_tex = 0;
    rti_hasher_add(&h, &world, sizeof world);
    for (uint32_t i = 0; i < v->material_count; i++) {
        const rtk_material *m = &v->materials[i];
        uint32_t kind[2] = {m->type, m->flags};
        rti_hasher_add(&h, kind, sizeof kind);
        add_texture(&h, s, m->alpha_tex);
        rti_hasher_add(&h, &m->alpha_cut, sizeof m->alpha_cut);
        if (m->reflectiveness > 0.0f && m->transparency > 0.0f)
            growth = rtk_max(growth, m->reflectiveness + m->transparency);
    }
    rti_hasher_add(&h, &growth, sizeof growth);
    return rti_hasher_end(&h);
}

static rti_hash hash_look(const rti_snapshot *s, const rtk_material *material)
{
    rtk_material m = *material;
    rti_hasher h;
    rti_hasher_init(&h);
    add_texture(&h, s, m.color_tex);
    add_texture(&h, s, m.alpha_tex);
    m.color_tex = m.alpha_tex = 0;
    rti_hasher_add(&h, &m, sizeof m);
    return rti_hasher_end(&h);
}

rt_status rt_scene_looks_hash(const rt_scene *scene, char rest[33], char (*looks)[33], uint32_t capacity, uint32_t *count)
{
    RTI_NEED(scene);
    rti_snapshot *s = committed(scene, "rt_scene_looks_hash");
    if (!s)
        return RT_ERROR_STATE;
    if (rest)
        rti_hash_text(rest, hash_rest(s));
    for (uint32_t i = 0; looks && i < s->view.material_count && i < capacity; i++)
        rti_hash_text(looks[i], hash_look(s, &s->view.materials[i]));
    if (count)
        *count = s->view.material_count;
    rti_snapshot_release(s);
    return RT_OK;
}

static void count_chunk(void *data, const rti_chunk *chunk, uint32_t group)
{
    rt_scene_info *info = data;
    const rtk_geometry_header *geometry = chunk->data;
    (void)group;
    info->total_bytes += chunk->size;
    if (chunk->kind == RTK_CHUNK_GROUP) {
        const rtk_group_header *head = chunk->data;
        info->triangles += head->tri_count;
        info->shapes += head->shape_count;
        info->planes += head->plane_count;
        info->geometry_bytes += chunk->size;
    } else if (chunk->kind == RTK_CHUNK_GEOMETRY) {
        const rtk_geom *geoms = rti_chunk_at(chunk, geometry->off_geoms);
        for (uint32_t i = 0; i < geometry->geom_count; i++)
            info->geometries += geoms[i].prim_count > 0;
    } else if (chunk->kind == RTK_CHUNK_ATTRIBUTE) {
        info->attribute_bytes += chunk->size;
    } else if (chunk->kind == RTK_CHUNK_TEXTURE) {
        info->texture_bytes += chunk->size;
    } else if (chunk->kind == RTK_CHUNK_TREE) {
        info->tree_bytes += chunk->size;
        info->tree_count++;
    }
}

rt_status rt_scene_get_info(const rt_scene *scene, rt_scene_info *info)
{
    RTI_NEED(scene);
    rti_snapshot *s;
    if (!info)
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "rt_scene_get_info: info is NULL; give the place for it");
    s = committed(scene, "rt_scene_get_info");
    if (!s)
        return RT_ERROR_STATE;
    memset(info, 0, sizeof *info);
    rti_snapshot_each(s, count_chunk, info);
    info->total_bytes += s->size;
    for (uint32_t i = 0; i < s->view.instance_count; i++)
        info->instances +=
            s->view.instances[i].lo[0] <= s->view.instances[i].hi[0] || (s->view.instances[i].flags & RTK_INST_UNBOUNDED);
    info->materials = s->view.material_count;
    info->textures = s->view.texture_count;
    info->lights = s->view.light_count;
    info->reused_chunks = s->reused_chunks;
    info->built_trees = s->built_trees;
    info->built_top_trees = s->built_tops;
    info->kept_trees = s->kept_trees;
    info->refitted_trees = s->refitted_trees;
    rti_snapshot_release(s);
    return RT_OK;
}

rt_status rt_scene_get_motion_info(const rt_scene *scene, rt_motion_info *info)
{
    RTI_NEED(scene);
    static const char call[] = "rt_scene_get_motion_info";
    const rtk_camera *camera;
    rti_snapshot *s;
    if (!info)
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: info is NULL; give the place for it", call);
    s = committed(scene, call);
    if (!s)
        return RT_ERROR_STATE;
    memset(info, 0, sizeof *info);
    for (uint32_t i = 0; i < s->view.instance_count; i++) {
        const rtk_instance *inst = &s->view.instances[i];
        info->moving_instances += (inst->flags & RTK_INST_MOVING) != 0;
        info->places += inst->flags & RTK_INST_MOVING ? inst->motion_count + 1 : 0;
    }
    camera = &s->view.world->camera;
    info->camera_moves = (camera->flags & RTK_CAMERA_MOVING) != 0;
    info->shutter_open = camera->open;
    info->shutter_close = camera->close;
    rti_snapshot_release(s);
    return RT_OK;
}

typedef struct find_tree {
    const rti_chunk *chunk;
    uint32_t left, group;
} find_tree;

static void look(void *data, const rti_chunk *chunk, uint32_t group)
{
    find_tree *f = data;
    if (chunk->kind != RTK_CHUNK_TREE || f->chunk)
        return;
    if (f->left-- == 0) {
        f->chunk = chunk;
        f->group = group;
    }
}

static rt_tree_info describe(const rti_chunk *chunk)
{
    const rtk_tree_header *head = chunk->data;
    rt_tree_info info;
    memset(&info, 0, sizeof info);
    info.name = rti_tree_kind_of(head->kind)->name;
    info.primitives = head->prim_count;
    info.references = head->ref_count - head->filler_count;
    info.nodes = head->node_count;
    info.leaves = head->leaf_count;
    info.empty_leaves = head->empty_leaf_count;
    info.bytes = chunk->size;
    info.depth = head->depth;
    info.largest_leaf = head->largest_leaf;
    info.build_seconds = head->build_seconds;
    info.sah_cost = head->sah_cost;
    return info;
}

rt_status rt_scene_get_tree_info(const rt_scene *scene, uint32_t index, uint32_t *group, rt_tree_info *info)
{
    RTI_NEED(scene);
    static const char call[] = "rt_scene_get_tree_info";
    find_tree f = {NULL, index, 0};
    rti_snapshot *s;
    rt_status status = RT_OK;
    if (!info)
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: info is NULL; give the place for it", call);
    s = committed(scene, call);
    if (!s)
        return RT_ERROR_STATE;
    rti_snapshot_each(s, look, &f);
    if (f.chunk) {
        *info = describe(f.chunk);
        if (f.group != RTK_INVALID)
            info->part = rti_tree_part(&s->groups[f.group], f.chunk);
        if (group)
            *group = f.group;
    } else {
        status = rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: index is %u; the scene has %u trees", call, index, index - f.left);
    }
    rti_snapshot_release(s);
    return status;
}
