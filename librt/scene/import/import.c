/* rt_scene_import: from a mesh file to geometries, materials and textures of a scene. */
#include <math.h>
#include <string.h>

#include "librt/import.h"
#include "kept_model.h"
#include "looks.h"

rt_import_desc rt_import_desc_default(void)
{
    return (rt_import_desc){.struct_size = sizeof(rt_import_desc),
                            .common = rti_common_default(),
                            .transform = rt_transform_identity(),
                            .smooth_angle_deg = 60.0f};
}

/* ---- transform ---- */

static bool is_identity(const rt_transform *t)
{
    const rt_transform one = rt_transform_identity();
    return memcmp(t, &one, sizeof one) == 0;
}

static float row(const float m[4], const float p[3], float w)
{
    return (float)((double)m[0] * p[0] + (double)m[1] * p[1] + (double)m[2] * p[2] + (double)m[3] * w);
}

/* Normals go by the cofactors of the linear part: its inverse transposed, times the determinant (a mirror turns them about as it
 * turns the faces). */
static void cofactors(const rt_transform *t, float out[12])
{
    const float *m = t->m;
    memset(out, 0, 12 * sizeof *out);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            out[4 * i + j] = (float)((double)m[4 * i1 + j1] * m[4 * i2 + j2] - (double)m[4 * i1 + j2] * m[4 * i2 + j1]);
        }
}

static rt_status place(rti_model *model, const rt_transform *t)
{
    float normal_map[12];
    cofactors(t, normal_map);
    for (size_t k = 0; k < model->part_count; k++) {
        rti_part *part = &model->parts[k];
        for (size_t i = 0; i < part->vertex_count; i++) {
            float *p = part->positions + 3 * i, *n = part->normals ? part->normals + 3 * i : NULL;
            float moved[3] = {row(t->m, p, 1), row(t->m + 4, p, 1), row(t->m + 8, p, 1)};
            for (int c = 0; c < 3; c++)
                if (!(fabsf(moved[c]) <= RTI_COORD_MAX))
                    return rti_fail(model->ctx, RT_ERROR_FORMAT,
                                    "%s: vertex %zu: %c is %s after the transform; %s at most can be traced", model->name, i,
                                    "xyz"[c], rti_num((char[32]){0}, moved[c]), rti_num((char[32]){0}, RTI_COORD_MAX));
            memcpy(p, moved, sizeof moved);
            if (n) {
                float turned[3] = {row(normal_map, n, 0), row(normal_map + 4, n, 0), row(normal_map + 8, n, 0)};
                bool finite = isfinite(turned[0]) && isfinite(turned[1]) && isfinite(turned[2]);
                for (int c = 0; c < 3; c++)
                    n[c] = finite ? turned[c] : 0.0f;
            }
        }
    }
    return RT_OK;
}

/* ---- reading ---- */

static rt_status read_mesh(rti_model *model, const char *path, const void *bytes, size_t size)
{
    switch (rti_mesh_format_of(path, bytes, size)) {
    case RTI_MESH_PLY:
        return rti_ply_read(model, bytes, size);
    case RTI_MESH_STL:
        return rti_stl_read(model, bytes, size);
    case RTI_MESH_OBJ:
        return rti_obj_read(model, bytes, size);
    default:
        return rti_fail(model->ctx, RT_ERROR_FORMAT,
                        "%s: not a mesh by its content (PLY and STL begin with 'ply' and 'solid') nor by its ending; "
                        "use .ply, .obj or .stl",
                        model->name);
    }
}

static rt_status prepare(rti_model *model, const char *path, const rti_kept_file *file, const rt_import_desc *d)
{
    rt_status status = read_mesh(model, path, file->bytes, file->size);
    for (size_t i = 0; i < model->part_count && !status && d->smooth; i++)
        if (!rti_part_smooth(model->ctx, &model->parts[i], d->smooth_angle_deg))
            status = rti_fail_memory(model->ctx, model->name, 9 * sizeof(double) * model->parts[i].triangle_count);
    if (!status && !is_identity(&d->transform))
        status = place(model, &d->transform);
    return status;
}

/* What decides, with the bytes, what geometry a file gives. */
static rti_hash how_of(const char *path, const rt_import_desc *d)
{
    uint32_t words[2] = {(uint32_t)rti_mesh_format_of(path, "", 0), d->smooth != 0};
    float angle = d->smooth ? d->smooth_angle_deg : 0.0f;
    rti_hasher h;
    rti_hasher_init(&h);
    rti_hasher_add(&h, "mesh", 4);
    rti_hasher_add(&h, words, sizeof words);
    rti_hasher_add(&h, &angle, sizeof angle);
    rti_hasher_add(&h, d->transform.m, sizeof d->transform.m);
    return rti_hasher_end(&h);
}

/* The file's geometry, read or held, as a reference; the model gets the names of its looks and libraries either way. */
static rt_status get_model(rti_model *model, const char *path, const rt_import_desc *d, rti_kept *kept)
{
    rti_kept_file file;
    rt_status status = rti_kept_begin(&file, model->ctx, path, how_of(path, d), kept);
    if (!status && kept->model) {
        status = rti_kept_model_names(kept->model, model);
    } else if (!status) {
        size_t bytes;
        status = prepare(model, path, &file, d);
        if (!status)
            status = rti_kept_model_make(model, &kept->model, &bytes);
        if (!status)
            rti_kept_put(&file, *kept, bytes);
    }
    rti_kept_end(&file);
    return status;
}

/* ---- into the scene ---- */

/* How far the scene's tables went: an import that fails half-way takes back what it has added. */
typedef struct mark {
    size_t materials, textures, geometries;
    uint64_t tri_count;
} mark;

static mark mark_of(const rt_scene *scene)
{
    return (mark){scene->materials.count, scene->textures.count, scene->geometries.count, scene->tri_count};
}

static void back_to(rt_scene *scene, mark m)
{
    for (size_t i = m.geometries; i < scene->geometries.count; i++)
        rti_mesh_free(scene->ctx, RTI_AT(scene->geometries, rti_geometry, i)->mesh);
    for (size_t i = m.textures; i < scene->textures.count; i++)
        rti_chunk_release(RTI_AT(scene->textures, rti_texture, i)->chunk);
    scene->materials.count = m.materials;
    scene->textures.count = m.textures;
    scene->geometries.count = m.geometries;
    scene->tri_count = m.tri_count;
}

static rt_status add_part(rt_scene *scene, const rti_model *model, const rti_kept_part *part, const rt_import_desc *d,
                          const rt_material *materials, rt_geometry *geometry)
{
    static const char call[] = "rt_scene_import";
    rt_geometry_common common = d->common;
    rt_status status;
    if (materials && part->look != RT_INVALID_ID && model->looks[part->look].defined)
        common.material = materials[part->look];
    status = rti_check_common(scene, call, &common);
    if (status)
        return status;
    atomic_fetch_add_explicit(&part->mesh->refs, 1, memory_order_relaxed);
    return rti_mesh_add(scene, call, &common, part->mesh, part->triangle_count, geometry);
}

static rt_status add_all(rt_scene *scene, rti_model *model, const rti_kept_model *kept, const rt_import_desc *d, const char *path,
                         rt_import_result *result)
{
    rt_context *ctx = model->ctx;
    rt_material *materials = NULL;
    rt_status status = RT_OK;
    if (model->look_count && !d->ignore_materials) {
        materials = rti_alloc_array(ctx, model->look_count, sizeof *materials);
        status = materials ? rti_looks_add(scene, model, path, materials)
                           : rti_fail_memory(ctx, model->name, model->look_count * sizeof *materials);
    }
    for (uint32_t i = 0; i < kept->part_count && !status; i++) {
        rt_geometry geometry;
        status = add_part(scene, model, &kept->parts[i], d, materials, &geometry);
        if (status)
            break;
        if (i == 0)
            result->first = geometry;
        result->geometry_count++;
        result->triangles += kept->parts[i].triangle_count;
        result->vertices += kept->parts[i].mesh->vertex_count;
    }
    rti_free(ctx, materials, model->look_count * sizeof *materials);
    return status;
}

static rt_status check(rt_context *ctx, const rt_import_desc *d)
{
    char number[32];
    for (int i = 0; i < 12; i++)
        if (!isfinite(d->transform.m[i]))
            return rti_fail(ctx, RT_ERROR_ARGUMENT, "rt_scene_import: transform.m[%d] is %s; it must be finite", i,
                            rti_num(number, d->transform.m[i]));
    if (d->smooth && !(d->smooth_angle_deg >= 0 && d->smooth_angle_deg <= 180))
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "rt_scene_import: smooth_angle_deg is %s; it must be 0 ... 180",
                        rti_num(number, d->smooth_angle_deg));
    return RT_OK;
}

rt_status rt_scene_import(rt_scene *scene, const char *path, const rt_import_desc *desc, rt_import_result *result)
{
    RTI_NEED(scene);
    rt_context *ctx = rt_scene_context(scene);
    rt_import_desc d = rt_import_desc_default();
    rt_import_result got = {.first = {RT_INVALID_ID}};
    rti_model model;
    rti_kept kept = {NULL, NULL};
    rt_status status = rti_scene_editable(scene, "rt_scene_import");
    if (!status && desc)
        status = rti_desc_take(ctx, "rt_scene_import", desc, &d, sizeof d);
    if (!status && !path)
        status = rti_fail(ctx, RT_ERROR_ARGUMENT, "rt_scene_import: path is NULL; give the name of a PLY, OBJ or STL file");
    if (!status)
        status = check(ctx, &d);
    if (status)
        return status;
    rti_fpenv env = rti_fp_enter();
    rti_model_init(&model, ctx, path);
    status = get_model(&model, path, &d, &kept);
    if (!status && !d.ignore_materials)
        status = rti_looks_read(&model, path);
    if (!status) {
        mark before = mark_of(scene);
        status = add_all(scene, &model, kept.model, &d, path, &got);
        if (status)
            back_to(scene, before);
    }
    got.warnings = model.warnings;
    rti_kept_release(ctx, kept);
    rti_model_fini(&model);
    rti_fp_leave(env);
    if (!status && result)
        *result = got;
    return status;
}
