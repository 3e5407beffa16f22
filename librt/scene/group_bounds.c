/* Commit: what holds a group's triangles and shapes, and its parts'. */
#include "parts.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "../kernel/shape_surface.h"

#define BOX_TASKS 64u

typedef struct box_job {
    const rtk_tri *tris;
    const rtk_shape *shapes;
    const uint32_t *list; /* of a part; NULL: all */
    uint64_t tri_count, count;
    float box[BOX_TASKS][6];
} box_job;

#define NOTHING                                                                                                                  \
    {                                                                                                                            \
        FLT_MAX, FLT_MAX, FLT_MAX, -FLT_MAX, -FLT_MAX, -FLT_MAX                                                                  \
    }

static void include(float box[6], const float *lo, const float *hi)
{
    for (int k = 0; k < 3; k++) {
        box[k] = lo[k] < box[k] ? lo[k] : box[k];
        box[3 + k] = hi[k] > box[3 + k] ? hi[k] : box[3 + k];
    }
}

static void include_ref(const box_job *job, float box[6], uint64_t ref)
{
    if (ref < job->tri_count) {
        include(box, job->tris[ref].v0, job->tris[ref].v0);
        include(box, job->tris[ref].v1, job->tris[ref].v1);
        include(box, job->tris[ref].v2, job->tris[ref].v2);
    } else {
        rtk_vec3 lo, hi;
        rtk_shape_bounds(&job->shapes[ref - job->tri_count], &lo, &hi);
        include(box, (float[3]){lo.x, lo.y, lo.z}, (float[3]){hi.x, hi.y, hi.z});
    }
}

static void box_task(void *data, uint32_t task)
{
    box_job *job = data;
    for (uint64_t i = job->count * task / BOX_TASKS; i < job->count * (task + 1) / BOX_TASKS; i++)
        include_ref(job, job->box[task], job->list ? job->list[i] : i);
}

/* list: NULL for all `count` primitives of the group. */
static void measure(rt_context *ctx, const rtk_group_header *head, const uint8_t *base, const uint32_t *list, uint32_t count,
                    rtk_part_header *out)
{
    box_job job = {.tris = (const rtk_tri *)(const void *)(base + head->off_tris),
                   .shapes = (const rtk_shape *)(const void *)(base + head->off_shapes),
                   .list = list,
                   .tri_count = head->tri_count,
                   .count = count};
    float box[6] = NOTHING, grow = 0.0f;
    out->scale = RTK_LEAST;
    out->count = count;
    if (count > 0) {
        for (uint32_t i = 0; i < BOX_TASKS; i++)
            memcpy(job.box[i], box, sizeof box);
        rti_parallel(ctx, BOX_TASKS, box_task, &job);
        for (uint32_t i = 0; i < BOX_TASKS; i++)
            include(box, job.box[i], job.box[i] + 3);
        for (int k = 0; k < 6; k++)
            out->scale = fmaxf(out->scale, fabsf(box[k]));
        grow = RTK_GROW * out->scale;
    }
    for (int k = 0; k < 3; k++) {
        out->lo[k] = box[k] - grow;
        out->hi[k] = box[3 + k] + grow;
    }
}

void rti_group_measure(rt_context *ctx, rtk_group_header *head, const void *chunk)
{
    const uint8_t *base = chunk;
    const uint32_t *list = (const uint32_t *)(const void *)(base + head->off_list);
    rtk_part_header all;
    measure(ctx, head, base, NULL, head->tri_count + head->shape_count, &all);
    memcpy(head->lo, all.lo, sizeof head->lo);
    memcpy(head->hi, all.hi, sizeof head->hi);
    head->scale = all.scale;
    if (head->part_count == 1)
        head->parts[0] = all;
    for (uint32_t i = 0; i < head->part_count && head->part_count > 1; i++) {
        uint32_t count = head->parts[i].count;
        measure(ctx, head, base, list, count, &head->parts[i]);
        list += count;
    }
}

/* ---- the cover: of each cell of a grid the box of what has its middle there ---- */

#define COVER_EDGE  4u /* cells along an axis */
#define COVER_TASKS 16u

typedef struct cover_job {
    box_job all;
    float lo[3], cells[3]; /* cells a unit */
    float box[COVER_TASKS][RTI_COVER][6];
} cover_job;
_Static_assert(COVER_EDGE *COVER_EDGE *COVER_EDGE == RTI_COVER, "a box for each cell");

static void cover_task(void *data, uint32_t task)
{
    cover_job *job = data;
    for (uint32_t i = 0; i < RTI_COVER; i++)
        memcpy(job->box[task][i], (float[6])NOTHING, sizeof job->box[task][i]);
    for (uint64_t i = job->all.count * task / COVER_TASKS; i < job->all.count * (task + 1) / COVER_TASKS; i++) {
        float own[6] = NOTHING;
        uint32_t cell = 0;
        include_ref(&job->all, own, i);
        for (int k = 0; k < 3; k++) {
            const float at = ((0.5f * own[k] + 0.5f * own[3 + k]) - job->lo[k]) * job->cells[k];
            cell = COVER_EDGE * cell + (at > 0.0f ? (uint32_t)fminf(at, COVER_EDGE - 1u) : 0u);
        }
        include(job->box[task][cell], own, own + 3);
    }
}

void rti_group_cover(rt_context *ctx, const rti_chunk *group, rti_cover_boxes *out)
{
    const rtk_group_header *head = group->data;
    cover_job job = {.all = {.tris = rti_chunk_at(group, head->off_tris),
                             .shapes = rti_chunk_at(group, head->off_shapes),
                             .tri_count = head->tri_count,
                             .count = (uint64_t)head->tri_count + head->shape_count}};
    const float grow = RTK_GROW * head->scale;
    for (int k = 0; k < 3; k++) {
        const float cell = (0.5f * head->hi[k] - 0.5f * head->lo[k]) * (2.0f / COVER_EDGE);
        job.lo[k] = head->lo[k];
        job.cells[k] = cell > FLT_MIN ? 1.0f / cell : 0.0f;
    }
    rti_parallel(ctx, COVER_TASKS, cover_task, &job);
    memset(out, 0, sizeof *out);
    out->group = group->hash;
    for (uint32_t i = 0; i < RTI_COVER; i++) {
        float *to = out->box[out->count], box[6] = NOTHING;
        for (uint32_t task = 0; task < COVER_TASKS; task++)
            include(box, job.box[task][i], job.box[task][i] + 3);
        if (!(box[0] <= box[3]))
            continue;
        for (int k = 0; k < 3; k++) {
            to[k] = box[k] - grow;
            to[3 + k] = box[3 + k] + grow;
        }
        out->count++;
    }
}
