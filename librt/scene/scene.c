/* Scenes: making, ending, the table of everything they hold. */
#include "scene.h"

#include <string.h>

void *rti_array_push(rt_context *ctx, rti_array *array, size_t item_size)
{
    void *item;
    if (!rti_reserve(ctx, &array->data, &array->capacity, array->count, 1, item_size))
        return NULL;
    item = (uint8_t *)array->data + array->count * item_size;
    memset(item, 0, item_size);
    array->count++;
    return item;
}

rt_status rti_array_refused(rt_context *ctx, const char *call, const rti_array *array, size_t more, size_t item_size)
{
    size_t need = array->count + more, grown = 2 * array->capacity;
    return rti_fail_memory(ctx, call, (need > grown ? need : grown) * item_size);
}

void rti_array_free(rt_context *ctx, rti_array *array, size_t item_size)
{
    rti_free(ctx, array->data, array->capacity * item_size);
}

rt_status rti_scene_editable(const rt_scene *scene, const char *call)
{
    if (!scene)
        return rti_fail_alone(RT_ERROR_ARGUMENT, "%s: scene is NULL", call);
    if (!scene->loaded)
        return RT_OK;
    return rti_fail(scene->ctx, RT_ERROR_STATE,
                    "%s: this scene was loaded from a snapshot file and cannot be edited; build a new one", call);
}

static rt_status fill_new(rt_scene *scene)
{
    rt_material material;
    rt_material_desc md = rt_material_desc_default();
    rt_world_desc wd = rt_world_desc_default();
    rt_camera_desc cd = rt_camera_desc_default();
    rt_status status = rt_scene_add_material(scene, &md, &material);
    if (status == RT_OK)
        status = rt_scene_set_world(scene, &wd);
    if (status == RT_OK)
        status = rt_scene_set_camera(scene, &cd);
    return status;
}

rt_status rt_scene_create(rt_context *context, rt_scene **scene)
{
    RTI_NEED_TO_MAKE(scene, context);
    rt_scene *s;
    rt_status status;
    if (!scene)
        return rti_fail(context, RT_ERROR_ARGUMENT, "rt_scene_create: scene is NULL; give the place for the new scene");
    *scene = NULL;
    s = rti_alloc_zero(context, sizeof *s);
    if (!s)
        return rti_fail_memory(context, "rt_scene_create", sizeof *s);
    s->ctx = context;
    atomic_init(&s->refs, 1);
    atomic_init(&s->cancel.asked, false);
    rti_cell_init(&s->cell);
    s->geometry_changed = true;
    s->auto_builder = true;
    s->refit = rt_commit_desc_default().refit;
    s->tree_kinds = 1u << RTK_TREE_BVH;
    status = fill_new(s);
    if (status != RT_OK) {
        rt_scene_destroy(s);
        return status;
    }
    *scene = s;
    return RT_OK;
}

void rti_scene_retain(rt_scene *scene)
{
    atomic_fetch_add(&scene->refs, 1);
}

/* A reference less; a scene without any joins those that go. */
static void let_go(rt_scene *scene, rt_scene **going)
{
    if (!scene || atomic_fetch_sub(&scene->refs, 1) != 1)
        return;
    scene->next_going = *going;
    *going = scene;
}

static void free_scene(rt_scene *scene, rt_scene **going)
{
    rt_context *ctx = scene->ctx;
    rti_cell_replace(&scene->cell, NULL);
    for (size_t i = 0; i < scene->geometries.count; i++)
        rti_mesh_free(ctx, RTI_AT(scene->geometries, rti_geometry, i)->mesh);
    for (size_t i = 0; i < scene->textures.count; i++)
        rti_chunk_release(RTI_AT(scene->textures, rti_texture, i)->chunk);
    for (size_t i = 0; i < scene->instances.count; i++) {
        rti_inst *inst = RTI_AT(scene->instances, rti_inst, i);
        let_go(inst->child, going);
        rti_free(ctx, inst->motion, inst->motion_count * sizeof *inst->motion);
    }
    rti_array_free(ctx, &scene->materials, sizeof(rtk_material));
    rti_array_free(ctx, &scene->textures, sizeof(rti_texture));
    rti_array_free(ctx, &scene->geometries, sizeof(rti_geometry));
    rti_array_free(ctx, &scene->shapes, sizeof(rtk_shape));
    rti_array_free(ctx, &scene->planes, sizeof(rti_plane));
    rti_array_free(ctx, &scene->instances, sizeof(rti_inst));
    rti_array_free(ctx, &scene->lights, sizeof(rti_light));
    rti_array_free(ctx, &scene->covers, sizeof(rti_cover_boxes));
    rti_free(ctx, scene, sizeof *scene);
}

/* A loop: no commit takes more than two levels, but a child that is given instances later makes a description of any depth. */
void rt_scene_destroy(rt_scene *scene)
{
    rt_scene *going = NULL;
    let_go(scene, &going);
    while (going) {
        rt_scene *one = going;
        going = one->next_going;
        free_scene(one, &going);
    }
}

rt_context *rt_scene_context(const rt_scene *scene)
{
    return scene->ctx;
}

rti_snapshot *rti_scene_snapshot(const rt_scene *scene)
{
    return rti_cell_acquire((rti_cell *)(uintptr_t)&scene->cell); /* counting readers is not what const promises against */
}
