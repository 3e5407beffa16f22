/* Commit: materials and textures (the scene's own, then its children's), and the world. */
#include "parts.h"

#include <string.h>

/* A chunk of records behind its header. All such headers are a count and the records' offset. */
rt_status rti_commit_table(rti_commit *c, size_t count, size_t record, void **block, size_t *size, void **records)
{
    rtk_material_header *head;
    rti_layout layout;
    uint64_t offset;
    rti_layout_begin(&layout, sizeof *head);
    offset = rti_layout_add(&layout, count, record);
    head = layout.overflow ? NULL : rti_alloc_zero(c->scene->ctx, layout.size);
    if (!head)
        return rti_fail_memory(c->scene->ctx, c->call, layout.size);
    head->material_count = (uint32_t)count;
    head->off_materials = offset;
    *block = head;
    *size = layout.size;
    *records = (uint8_t *)head + offset;
    return RT_OK;
}

static uint32_t shifted(uint32_t texture, uint32_t base)
{
    return texture == RTK_INVALID ? RTK_INVALID : texture + base;
}

static void put_lamps(const rt_scene *scene, rtk_material *out)
{
    for (size_t i = 0; i < scene->lights.count; i++) {
        const rti_light *l = RTI_AT(scene->lights, rti_light, i);
        if (!l->visible)
            continue;
        out->type = RTK_MATERIAL_EMISSIVE;
        out->refractiveness = 1.0f;
        out->shininess = 1.0f;
        memcpy(out->emission, l->light.color, sizeof out->emission);
        out->color_tex = RTK_INVALID;
        out->alpha_tex = RTK_INVALID;
        out++;
    }
}

static void take_textures(rti_commit *c)
{
    rti_chunk **to = c->next->textures;
    for (size_t i = 0; i < c->scene->textures.count; i++)
        *to++ = rti_chunk_retain(RTI_AT(c->scene->textures, rti_texture, i)->chunk);
    for (uint32_t k = 0; k < c->child_count; k++) {
        for (uint32_t i = 0; i < c->children[k]->texture_count; i++)
            *to++ = rti_chunk_retain(c->children[k]->textures[i]);
    }
}

rt_status rti_commit_materials(rti_commit *c)
{
    const rt_scene *scene = c->scene;
    size_t own = scene->materials.count + c->lamp_count, count = own, size = 0;
    uint32_t texture_base = (uint32_t)scene->textures.count;
    rtk_material *to;
    void *block = NULL, *records = NULL;
    rt_status status;
    for (uint32_t k = 0; k < c->child_count; k++)
        count += c->children[k]->view.material_count;
    if (count >= RTI_MAX_PRIMS)
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT,
                        "%s: with those of its instances the scene has %zu materials; at most %u fit", c->call, count,
                        RTI_MAX_PRIMS);
    status = rti_commit_table(c, count, sizeof *to, &block, &size, &records);
    if (!records)
        return status;
    take_textures(c);
    to = records;
    memcpy(to, scene->materials.data, scene->materials.count * sizeof *to);
    put_lamps(scene, to + scene->materials.count);
    to += own;
    for (uint32_t k = 0; k < c->child_count; k++) {
        const rtk_scene *view = &c->children[k]->view;
        c->next->groups[k + 1].material_base = (uint32_t)(to - (rtk_material *)records);
        for (uint32_t i = 0; i < view->material_count; i++, to++) {
            *to = view->materials[i];
            to->color_tex = shifted(to->color_tex, texture_base);
            to->alpha_tex = shifted(to->alpha_tex, texture_base);
        }
        texture_base += view->texture_count;
    }
    return rti_commit_chunk(c, RTK_CHUNK_MATERIAL, block, size, &c->next->materials);
}

rt_status rti_commit_world(rti_commit *c)
{
    rtk_world *world = rti_alloc(c->scene->ctx, sizeof *world);
    if (!world)
        return rti_fail_memory(c->scene->ctx, c->call, sizeof *world);
    *world = c->scene->world;
    return rti_commit_chunk(c, RTK_CHUNK_WORLD, world, sizeof *world, &c->next->world);
}
