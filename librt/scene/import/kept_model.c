#include "kept_model.h"

#include <string.h>

static size_t names_size(const rti_model *model)
{
    size_t size = 0;
    for (size_t i = 0; i < model->look_count; i++)
        size += strlen(model->looks[i].name) + 1;
    for (size_t i = 0; i < model->library_count; i++)
        size += strlen(model->libraries[i]) + 1;
    return size;
}

static const char *put_name(char **at, const char *name)
{
    char *text = *at;
    size_t n = strlen(name) + 1;
    memcpy(text, name, n);
    *at += n;
    return text;
}

/* The block with names and empty parts; NULL: no memory. */
static rti_kept_model *make_block(const rti_model *model)
{
    rti_layout layout;
    uint64_t parts, looks, libraries, names;
    rti_kept_model *m;
    uint8_t *base;
    char *at;
    rti_layout_begin(&layout, sizeof *m);
    parts = rti_layout_add(&layout, model->part_count, sizeof *m->parts);
    looks = rti_layout_add(&layout, model->look_count, sizeof *m->looks);
    libraries = rti_layout_add(&layout, model->library_count, sizeof *m->libraries);
    names = rti_layout_add(&layout, names_size(model), 1);
    base = layout.overflow ? NULL : rti_alloc_zero(model->ctx, layout.size);
    if (!base)
        return NULL;
    m = (rti_kept_model *)(void *)base;
    atomic_init(&m->refs, 1);
    m->size = layout.size;
    m->warnings = model->warnings;
    m->look_count = (uint32_t)model->look_count;
    m->library_count = (uint32_t)model->library_count;
    m->parts = (rti_kept_part *)(void *)(base + parts);
    m->looks = (const char **)(void *)(base + looks);
    m->libraries = (const char **)(void *)(base + libraries);
    at = (char *)base + names;
    for (uint32_t i = 0; i < m->look_count; i++)
        m->looks[i] = put_name(&at, model->looks[i].name);
    for (uint32_t i = 0; i < m->library_count; i++)
        m->libraries[i] = put_name(&at, model->libraries[i]);
    return m;
}

rt_status rti_kept_model_make(const rti_model *model, rti_kept_model **out, size_t *bytes)
{
    rti_kept_model *m = make_block(model);
    rt_status status = RT_OK;
    *out = NULL;
    if (!m)
        return rti_fail_memory(model->ctx, model->name, sizeof *m);
    *bytes = m->size;
    for (size_t i = 0; i < model->part_count && status == RT_OK; i++) {
        const rti_part *from = &model->parts[i];
        rti_kept_part *to = &m->parts[i];
        rt_mesh_desc d = rt_mesh_desc_default();
        d.positions = from->positions;
        d.vertex_count = from->vertex_count;
        d.indices = from->indices;
        d.triangle_count = from->triangle_count;
        d.normals = from->normals;
        d.uvs = from->uvs;
        d.colors = from->colors;
        status = rti_mesh_of(model->ctx, "rt_scene_import", &d, &to->mesh);
        if (status != RT_OK)
            break;
        to->triangle_count = from->triangle_count;
        to->look = from->look;
        m->part_count++;
        *bytes += to->mesh->size;
    }
    if (status != RT_OK) {
        rti_kept_release(model->ctx, (rti_kept){.model = m});
        return status;
    }
    *out = m;
    return RT_OK;
}

static const char *own_name(rti_model *model, const char *name)
{
    size_t n = strlen(name) + 1;
    char *text = rti_arena_alloc(&model->arena, n);
    if (text)
        memcpy(text, name, n);
    return text;
}

rt_status rti_kept_model_names(const rti_kept_model *kept, rti_model *model)
{
    rt_context *ctx = model->ctx;
    bool good =
        rti_reserve(ctx, (void **)&model->looks, &model->look_capacity, 0, kept->look_count, sizeof *model->looks) &&
        rti_reserve(ctx, (void **)&model->libraries, &model->library_capacity, 0, kept->library_count, sizeof *model->libraries);
    for (uint32_t i = 0; good && i < kept->look_count; i++) {
        model->looks[i] = (rti_look){.name = own_name(model, kept->looks[i])};
        good = model->looks[i].name != NULL;
        model->look_count += good;
    }
    for (uint32_t i = 0; good && i < kept->library_count; i++) {
        model->libraries[i] = own_name(model, kept->libraries[i]);
        good = model->libraries[i] != NULL;
        model->library_count += good;
    }
    if (!good)
        return rti_fail_memory(ctx, model->name, kept->size);
    model->warnings = kept->warnings;
    if (kept->warnings)
        rti_log(ctx, RT_LOG_WARNING, "%s: %u warning%s as when it was read before", model->name, kept->warnings,
                kept->warnings == 1 ? "" : "s");
    return RT_OK;
}
