/* From OBJ's triples of indices to parts with one index a corner: equal triples become one vertex. */
#include "obj.h"

#include <string.h>

/* Faces of one look, in the file's order. */
typedef struct look_faces {
    uint32_t first, last;
    uint64_t corners;
    bool normals, uvs;
} look_faces;

typedef struct part_maker {
    rti_obj *obj;
    rti_part *part;
    size_t *corner_of;    /* [face]: its first corner */
    uint32_t *table;      /* vertices of the part by triple, open addressing */
    rti_obj_corner *made; /* [vertex of the part] */
    size_t table_size, made_size;
    uint32_t *corners; /* of one face, as vertices of the part */
} part_maker;

static rt_status no_memory(const rti_obj *obj, size_t size)
{
    return rti_fail_memory(obj->model->ctx, obj->model->name, size);
}

static rt_status check_corner(const rti_obj *obj, size_t face, const rti_obj_corner *c)
{
    const struct {
        const char *what;
        uint32_t index;
        size_t count;
    } checks[3] = {{"vertex", c->v, obj->v.count}, {"texture vertex", c->vt, obj->vt.count}, {"normal", c->vn, obj->vn.count}};
    for (int i = 0; i < 3; i++)
        if (checks[i].index != RTI_OBJ_NONE && checks[i].index >= checks[i].count)
            return rti_fail(obj->model->ctx, RT_ERROR_FORMAT, "%s: face %zu: %s %llu does not exist; the file has %zu",
                            obj->model->name, face + 1, checks[i].what, (unsigned long long)checks[i].index + 1, checks[i].count);
    return RT_OK;
}

/* Checks every index, chains the faces of each look. looks: [look_count + 1], the last for faces before any usemtl. */
static rt_status chain_faces(rti_obj *obj, look_faces *looks, size_t *corner_of)
{
    const rti_obj_corner *c = obj->corners.data;
    rti_obj_face *faces = obj->faces.data;
    size_t at = 0, plain = obj->model->look_count;
    for (size_t i = 0; i < obj->faces.count; i++) {
        look_faces *l = &looks[faces[i].look == RT_INVALID_ID ? plain : faces[i].look];
        corner_of[i] = at;
        for (uint32_t k = 0; k < faces[i].corner_count; k++, at++) {
            rt_status status = check_corner(obj, i, &c[at]);
            if (status)
                return status;
            l->uvs |= c[at].vt != RTI_OBJ_NONE;
            l->normals |= c[at].vn != RTI_OBJ_NONE;
        }
        if (l->corners == 0)
            l->first = (uint32_t)i;
        else
            faces[l->last].next = (uint32_t)i;
        l->last = (uint32_t)i;
        l->corners += faces[i].corner_count;
    }
    return RT_OK;
}

static uint64_t corner_hash(const rti_obj_corner *c)
{
    uint64_t h = (c->v | (uint64_t)c->vt << 32) * UINT64_C(0xd6e8feb86659fd93) ^ c->vn;
    h = (h ^ h >> 32) * UINT64_C(0xd6e8feb86659fd93);
    return h ^ h >> 32;
}

static void fill_vertex(const rti_obj *obj, const rti_obj_corner *c, rti_part *part)
{
    size_t n = part->vertex_count++;
    memcpy(part->positions + 3 * n, (const float *)obj->v.data + 3 * (size_t)c->v, 3 * sizeof(float));
    for (size_t k = 0; part->colors && k < 3; k++)
        part->colors[3 * n + k] = c->v < obj->colors.count ? ((const float *)obj->colors.data)[3 * (size_t)c->v + k] : 1.0f;
    for (size_t k = 0; part->uvs && k < 2; k++)
        part->uvs[2 * n + k] = c->vt != RTI_OBJ_NONE ? ((const float *)obj->vt.data)[2 * (size_t)c->vt + k] : 0.0f;
    for (size_t k = 0; part->normals && k < 3; k++)
        part->normals[3 * n + k] = c->vn != RTI_OBJ_NONE ? ((const float *)obj->vn.data)[3 * (size_t)c->vn + k] : 0.0f;
}

/* The part's vertex for a triple; false: no memory. */
static bool vertex_of(part_maker *m, const rti_obj_corner *c, const look_faces *l, uint32_t *vertex)
{
    rt_context *ctx = m->obj->model->ctx;
    size_t at = corner_hash(c) & (m->table_size - 1);
    for (; m->table[at] != UINT32_MAX; at = (at + 1) & (m->table_size - 1)) {
        if (memcmp(&m->made[m->table[at]], c, sizeof *c) == 0) {
            *vertex = m->table[at];
            return true;
        }
    }
    if (!rti_part_reserve(ctx, m->part, (size_t)m->part->vertex_count + 1, l->normals, l->uvs, m->obj->has_colors) ||
        !rti_reserve(ctx, (void **)&m->made, &m->made_size, m->part->vertex_count, 1, sizeof *m->made))
        return false;
    m->table[at] = *vertex = m->part->vertex_count;
    m->made[*vertex] = *c;
    fill_vertex(m->obj, c, m->part);
    return true;
}

static bool make_part(part_maker *m, const look_faces *l)
{
    rt_context *ctx = m->obj->model->ctx;
    const rti_obj_face *faces = m->obj->faces.data;
    const rti_obj_corner *corners = m->obj->corners.data;
    size_t size = 16;
    while (size < 2 * l->corners)
        size *= 2;
    m->table = rti_alloc_array(ctx, size, sizeof *m->table);
    m->table_size = m->table ? size : 0;
    bool good = m->table && l->corners < UINT32_MAX;
    if (good)
        memset(m->table, 0xff, size * sizeof *m->table);
    for (uint32_t f = l->first; good && f != RTI_OBJ_NONE; f = faces[f].next) {
        uint32_t n = faces[f].corner_count;
        for (uint32_t k = 0; good && k < n; k++)
            good = vertex_of(m, &corners[m->corner_of[f] + k], l, &m->corners[k]);
        good = good && rti_part_polygon(ctx, m->part, m->corners, n);
    }
    rti_free(ctx, m->table, m->table_size * sizeof *m->table);
    return good;
}

/* Looks in the order in which the file first uses them for a face. */
static rt_status make_parts(rti_obj *obj, look_faces *looks, part_maker *m)
{
    const rti_obj_face *faces = obj->faces.data;
    for (size_t i = 0; i < obj->faces.count; i++) {
        uint32_t look = faces[i].look;
        look_faces *l = &looks[look == RT_INVALID_ID ? obj->model->look_count : look];
        if (l->first != i || l->corners == 0)
            continue;
        m->part = rti_model_add_part(obj->model, look);
        if (!m->part || !make_part(m, l))
            return no_memory(obj, l->corners * sizeof *m->table);
    }
    return RT_OK;
}

rt_status rti_obj_parts(rti_obj *obj)
{
    rt_context *ctx = obj->model->ctx;
    const rti_obj_face *faces = obj->faces.data;
    uint32_t widest = 3;
    for (size_t i = 0; i < obj->faces.count; i++)
        widest = faces[i].corner_count > widest ? faces[i].corner_count : widest;
    size_t look_size = (obj->model->look_count + 1) * sizeof(look_faces);
    look_faces *looks = rti_alloc_zero(ctx, look_size);
    part_maker m = {.obj = obj};
    m.corner_of = rti_alloc_array(ctx, obj->faces.count, sizeof *m.corner_of);
    m.corners = rti_alloc_array(ctx, widest, sizeof *m.corners);
    rt_status status = looks && m.corner_of && m.corners ? RT_OK : no_memory(obj, obj->faces.count * sizeof *m.corner_of);
    if (!status)
        status = chain_faces(obj, looks, m.corner_of);
    if (!status)
        status = make_parts(obj, looks, &m);
    rti_free(ctx, looks, look_size);
    rti_free(ctx, m.corner_of, obj->faces.count * sizeof *m.corner_of);
    rti_free(ctx, m.corners, widest * sizeof *m.corners);
    rti_free(ctx, m.made, m.made_size * sizeof *m.made);
    return status;
}
