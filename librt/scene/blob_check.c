/* Checks of what comes from a file: materials, textures, lights, world, instances. Whatever kernels use as an index, an offset or
 * a count is held against what is there; floats they compute with are finite. */
#include "blob.h"

#include <math.h>
#include <string.h>

#define FLOAT_MOST 3.0e38f

bool rti_blob_span(const rti_chunk *chunk, size_t header, uint64_t offset, uint64_t count, size_t item)
{
    if (count == 0)
        return offset <= chunk->size;
    return offset >= header && offset % 64 == 0 && offset <= chunk->size && count <= (chunk->size - offset) / item;
}

bool rti_blob_finite(const float *x, size_t count, float most)
{
    for (size_t i = 0; i < count; i++) {
        if (!(fabsf(x[i]) <= most))
            return false;
    }
    return true;
}

static bool texture_or_none(const rti_snapshot *s, uint32_t id)
{
    return id == RTK_INVALID || id < s->texture_count;
}

static const char *check_materials(const rti_snapshot *s)
{
    const rtk_material_header *head = s->materials->data;
    const rtk_material *m;
    if (head->material_count == 0 || head->material_count > RTI_MAX_PRIMS ||
        !rti_blob_span(s->materials, sizeof *head, head->off_materials, head->material_count, sizeof *m))
        return "the table of materials does not fit its chunk";
    m = rti_chunk_at(s->materials, head->off_materials);
    for (uint32_t i = 0; i < head->material_count; i++, m++) {
        if (m->type >= RTK_MATERIAL_COUNT || (m->flags & ~(RTK_MAT_TRANSPARENT | RTK_MAT_OPAQUE_SHADOW)))
            return "a material is of no known type";
        if (!texture_or_none(s, m->color_tex) || !texture_or_none(s, m->alpha_tex))
            return "a material names a texture that is not there";
        if (!rti_blob_finite(m->color, 3, FLOAT_MOST) || !rti_blob_finite(&m->diffusion, 7, FLOAT_MOST) ||
            !rti_blob_finite(m->emission, 3, FLOAT_MOST) || !rti_blob_finite(&m->alpha_cut, 1, FLOAT_MOST))
            return "a material holds a number that is none";
    }
    return NULL;
}

static const char *check_texture(const rti_chunk *chunk)
{
    static const uint32_t known = RTK_TEX_SRGB | RTK_TEX_FLOAT | RTK_TEX_ALPHA | RTK_TEX_NEAREST | RTK_TEX_CLAMP;
    const rtk_texture_header *head = chunk->data;
    if (head->width < 1 || head->width > 65536 || head->height < 1 || head->height > 65536 || head->level_count < 1 ||
        head->level_count > RTK_TEX_LEVELS || (head->flags & ~known))
        return "a texture has an impossible size";
    for (uint32_t i = 0; i < head->level_count; i++) {
        uint64_t w = rtk_umax(1, head->width >> i), h = rtk_umax(1, head->height >> i);
        if (!rti_blob_span(chunk, sizeof *head, head->off_level[i], ((w + 7) / 8) * ((h + 7) / 8),
                           head->flags & RTK_TEX_FLOAT ? 1024 : 256))
            return "a texture's level does not fit its chunk";
    }
    return NULL;
}

static const char *check_lights(const rti_snapshot *s)
{
    const rtk_light_header *head = s->lights->data;
    const rtk_light *l;
    const rtk_geometry_header *geometry = s->groups[0].geometry->data;
    float before = 0.0f;
    if (head->light_count > RTI_MAX_PRIMS ||
        !rti_blob_span(s->lights, sizeof *head, head->off_lights, head->light_count, sizeof *l))
        return "the table of lights does not fit its chunk";
    l = rti_chunk_at(s->lights, head->off_lights);
    for (uint32_t i = 0; i < head->light_count; i++, l++) {
        if (l->type > RTK_LIGHT_DIRECTIONAL || (l->geom != RTK_INVALID && l->geom >= geometry->geom_count))
            return "a light is of no known type, or its body is not there";
        if (!rti_blob_finite(l->at, 3, FLOAT_MOST) || !rti_blob_finite(&l->radius, 1, FLOAT_MOST) ||
            !rti_blob_finite(l->color, 3, FLOAT_MOST) || !rti_blob_finite(&l->falloff, 1, FLOAT_MOST) ||
            !rti_blob_finite(l->body_at, 3, FLOAT_MOST) || !rti_blob_finite(&l->body_radius, 1, FLOAT_MOST))
            return "a light holds a number that is none";
        if (!(l->select_pdf >= 0.0f && l->select_pdf <= 1.0f && l->select_cdf >= before && l->select_cdf <= 1.0f))
            return "the probabilities of the lights are none";
        before = l->select_cdf;
    }
    return head->light_count > 0 && before != 1.0f ? "the probabilities of the lights do not add up" : NULL;
}

static const char *check_camera(const rtk_camera *c)
{
    if (c->type > RTK_CAMERA_ORTHOGRAPHIC || (c->flags & ~RTK_CAMERA_MOVING) || !rti_blob_finite(c->eye, 3, FLOAT_MOST) ||
        !rti_blob_finite(c->front, 3, FLOAT_MOST) || !rti_blob_finite(c->up, 3, FLOAT_MOST) ||
        !rti_blob_finite(c->right, 3, FLOAT_MOST) || !rti_blob_finite(&c->half_height, 1, FLOAT_MOST))
        return "the camera holds a number that is none";
    if (!(c->aperture >= 0.0f && c->aperture <= RTI_COORD_MAX) || !(c->focus >= 0.0f && c->focus <= FLOAT_MOST) ||
        c->blades > RTI_BLADES_MAX || c->blades == 1 || c->blades == 2 || !rti_blob_finite(&c->blade_turn, 1, 1.0e6f) ||
        !(c->open >= 0.0f && c->open <= c->close && c->close <= 1.0f))
        return "the camera has an impossible lens or shutter";
    for (int i = 0; i < 2; i++) {
        const rtk_camera_key *k = &c->key[i];
        if (!rti_blob_finite(k->eye, 3, RTI_COORD_MAX) || !rti_blob_finite(k->aim, 3, 3.0f * RTI_COORD_MAX) ||
            !rti_blob_finite(k->up, 3, RTI_COORD_MAX) || !rti_blob_finite(&k->half_height, 1, FLOAT_MOST) ||
            !(k->aperture >= 0.0f && k->aperture <= RTI_COORD_MAX) || !(k->focus >= 0.0f && k->focus <= FLOAT_MOST))
            return "the camera's way holds a number that is none";
    }
    return NULL;
}

static const char *check_world(const rti_snapshot *s)
{
    const rtk_world *w = s->world->data;
    const char *what = check_camera(&w->camera);
    if (what)
        return what;
    if (!rti_blob_finite(w->ambient, 3, FLOAT_MOST) || !rti_blob_finite(w->background, 3, FLOAT_MOST) ||
        !rti_blob_finite(w->background_top, 3, FLOAT_MOST) || !texture_or_none(s, w->background_tex))
        return "the background holds a number or a texture that is none";
    return NULL;
}

/* ---- instances ---- */

static bool empty_place(const rtk_instance *inst)
{
    return inst->mask == 0 && inst->group == 0 && inst->flags == 0 && inst->motion_count == 0 && !(inst->lo[0] <= inst->hi[0]);
}

static bool sound_box(const rtk_instance *inst, const rtk_top_header *head)
{
    for (int k = 0; k < 3; k++) {
        if (!(inst->lo[k] <= inst->hi[k]) || !rti_blob_finite(&inst->lo[k], 1, FLOAT_MOST) ||
            !rti_blob_finite(&inst->hi[k], 1, FLOAT_MOST))
            return false;
        if (inst->lo[k] < head->all_lo[k] || inst->hi[k] > head->all_hi[k])
            return false;
        if (!(inst->flags & RTK_INST_UNBOUNDED) && (inst->lo[k] < head->lo[k] || inst->hi[k] > head->hi[k]))
            return false;
    }
    return true;
}

static const char *check_instance(const rti_snapshot *s, const rtk_top_header *head, const rtk_instance *inst, uint32_t materials)
{
    const rtk_group_header *group;
    rtk_xfm inverse;
    if (empty_place(inst) && rti_blob_finite(inst->to_world.m, 12, RTI_COORD_MAX) &&
        rti_blob_finite(inst->to_object.m, 12, RTI_COORD_MAX) && inst->material == RTK_INVALID)
        return NULL;
    if (!rti_blob_finite(inst->to_world.m, 12, RTI_COORD_MAX) || !rti_xfm_invert(&inst->to_world, &inverse) ||
        memcmp(inverse.m, inst->to_object.m, sizeof inverse.m) != 0)
        return "an instance's transform and its inverse do not belong together";
    if (inst->material != RTK_INVALID && inst->material >= materials)
        return "an instance names a material that is not there";
    if (inst->group == 0 || inst->group >= s->group_count || (inst->flags & ~(RTK_INST_UNBOUNDED | RTK_INST_MOVING)))
        return "an instance names a group that is not there";
    if (((inst->flags & RTK_INST_MOVING) != 0) != (inst->motion_count > 0) || inst->motion_count > RTI_MOTION_MAX ||
        inst->motion_first > head->motion_count || inst->motion_count > head->motion_count - inst->motion_first ||
        !rti_motion_sound((const rtk_motion *)rti_chunk_at(s->top, head->off_motions) + inst->motion_first, inst->motion_count))
        return "an instance's way is none";
    group = s->groups[inst->group].group->data;
    if ((group->plane_count > 0) != ((inst->flags & RTK_INST_UNBOUNDED) != 0))
        return "an instance is marked wrongly as bounded or not";
    if (group->tri_count + group->shape_count > 0 && !sound_box(inst, head))
        return "an instance's box is none";
    return NULL;
}

/* Is there a box of all if some instance has one (which check_instance finds in it), and only then? */
static const char *check_all_box(const rtk_top_header *head, const rtk_instance *inst)
{
    uint32_t boxes = 0;
    for (uint32_t i = 0; i < head->instance_count; i++)
        boxes += inst[i].lo[0] <= inst[i].hi[0];
    for (int k = 0; k < 3; k++)
        if ((head->all_lo[k] <= head->all_hi[k]) != (boxes > 0))
            return "the box of the instances is none";
    return NULL;
}

static const char *check_unbounded(const rti_snapshot *s, const rtk_top_header *head)
{
    const rtk_instance *instances = rti_chunk_at(s->top, head->off_instances);
    const uint32_t *list = rti_chunk_at(s->top, head->off_unbounded);
    uint32_t marked = 0;
    for (uint32_t i = 0; i < head->unbounded_count; i++) {
        if (list[i] >= head->instance_count || (i > 0 && list[i] <= list[i - 1]) ||
            !(instances[list[i]].flags & RTK_INST_UNBOUNDED))
            return "the list of unbounded instances is wrong";
    }
    for (uint32_t i = 0; i < head->instance_count; i++)
        marked += (instances[i].flags & RTK_INST_UNBOUNDED) != 0;
    return marked == head->unbounded_count ? NULL : "the list of unbounded instances is wrong";
}

static const char *check_top(const rti_snapshot *s)
{
    const rtk_top_header *head = s->top->data;
    const rtk_instance *inst;
    uint32_t materials = ((const rtk_material_header *)s->materials->data)->material_count, bounded = 0;
    const char *what;
    if (head->instance_count > RTI_MAX_PRIMS || head->unbounded_count > head->instance_count ||
        !rti_blob_span(s->top, sizeof *head, head->off_instances, head->instance_count, sizeof *inst) ||
        !rti_blob_span(s->top, sizeof *head, head->off_unbounded, head->unbounded_count, sizeof(uint32_t)) ||
        !rti_blob_span(s->top, sizeof *head, head->off_motions, head->motion_count, sizeof(rtk_motion)))
        return "the table of instances does not fit its chunk";
    inst = rti_chunk_at(s->top, head->off_instances);
    if (!rti_blob_finite(head->lo, 6, 3.4028235e38f) || !rti_blob_finite(head->all_lo, 6, 3.4028235e38f) ||
        !(head->scale >= RTK_LEAST && head->scale <= FLOAT_MOST))
        return "the box of the instances is none";
    for (uint32_t i = 0; i < head->instance_count; i++) {
        if (inst[i].id != i)
            return "an instance has a wrong id";
        if ((what = check_instance(s, head, &inst[i], materials)) != NULL)
            return what;
        bounded += inst[i].lo[0] <= inst[i].hi[0] && !(inst[i].flags & RTK_INST_UNBOUNDED);
    }
    if ((what = check_all_box(head, inst)) != NULL)
        return what;
    /* A ray that enters the box walks a tree, and there is one only over something. */
    if ((bounded > 0) != (head->lo[0] <= head->hi[0]))
        return "the box of the instances is none";
    if ((what = check_unbounded(s, head)) != NULL)
        return what;
    for (uint32_t kind = 1; kind < RTI_TREE_KINDS; kind++) {
        const rti_chunk *tree = s->top_tree[kind];
        if (tree && (!rti_tree_valid(tree->data, tree->size, head->instance_count) ||
                     !rti_tree_copies_valid(tree->data, NULL, 0, NULL) || !rti_tree_is_over(tree->data, head->lo, head->hi)))
            return "a tree over the instances is not sound";
    }
    return NULL;
}

const char *rti_blob_check(const rti_snapshot *s)
{
    const char *what = check_materials(s);
    for (uint32_t i = 0; !what && i < s->texture_count; i++)
        what = check_texture(s->textures[i]);
    if (!what)
        what = check_lights(s);
    if (!what)
        what = check_world(s);
    return what ? what : check_top(s);
}
