/* Whether a group is cut into parts of about one scale (kernel/ray.h, theory point 6), and where: a bunny on a floor ten thousand
 * times its size would else be in boxes that are larger than its triangles.
 *
 * Pieces are triangles held together by shared corners (equal positions, of whatever mesh), and single shapes. A piece's scale is
 * its largest coordinate; pieces are sorted by the scale's power of two. Below a part's scale a new part begins where pieces are
 * at least 8 times smaller, and in that part's boxes their primitives would on average have more than twice the surface, some of
 * them sides half as long again, or so many sides three times as long that a ray among them would meet them all. Scenes of one
 * scale have none: for them all this is one look at each primitive.
 *
 * (A part costs each ray: it is made ready, and finds its way, once more. A classroom whose ground is 36 times the room, and a
 * sixth of its triangles swell by half (168 to three times their size), by .75 on average: in one part camera rays are 1.16 times
 * as fast, 1.24 one a call, bounces and random rays 1.07, shadow rays .95. With a ground four times as large bounces are even.)
 */
#include "parts.h"

#include <math.h>
#include <string.h>

#include "../kernel/shape_surface.h"

#define STEP     4u      /* powers of two between a part and the next */
#define FEWEST   64u     /* small primitives that are worth a part: each costs every ray a look at its box */
#define CROWD    256u    /* ones three times as large: rays among 500 of them took twice as long, among 2,000 up to six times */
#define MOST     1024.0f /* of one primitive's growth counts so much: one that is all but nothing says nothing of others */
#define TASKS    64u
#define NO_ENTRY 0u
#define CLASSES  256u

typedef struct cut_job {
    rt_context *ctx;
    rti_cancel *cancel;
    const rtk_group_header *head;
    const rtk_tri *tris;
    const rtk_shape *shapes;
    uint32_t count; /* triangles and shapes */
    uint32_t small[TASKS];
    uint8_t *classes;           /* [count] exponent of the scale of a primitive's piece */
    uint32_t bounds[RTK_PARTS]; /* classes up to this one belong to part i or one behind it */
    uint32_t part_count;
} cut_job;

static uint32_t class_of(float scale)
{
    return rtk_bits(scale) >> 23;
}

/* Largest coordinate and largest extent of a primitive. */
static float prim_scale(const cut_job *job, uint32_t i, float *size)
{
    float box[6], scale = 0.0f;
    *size = 0.0f;
    if (i < job->head->tri_count) {
        const rtk_tri *t = &job->tris[i];
        for (int k = 0; k < 3; k++) {
            box[k] = rtk_min(rtk_min(t->v0[k], t->v1[k]), t->v2[k]);
            box[3 + k] = rtk_max(rtk_max(t->v0[k], t->v1[k]), t->v2[k]);
        }
    } else {
        rtk_vec3 lo, hi;
        rtk_shape_bounds(&job->shapes[i - job->head->tri_count], &lo, &hi);
        memcpy(box, (float[6]){lo.x, lo.y, lo.z, hi.x, hi.y, hi.z}, sizeof box);
    }
    for (int k = 0; k < 3; k++) {
        scale = rtk_max(scale, rtk_max(rtk_fabs(box[k]), rtk_fabs(box[3 + k])));
        *size = rtk_max(*size, box[3 + k] - box[k]);
    }
    return scale;
}

/* Would boxes grown for this scale be half as large again as the primitive, or more? (What has no size is never hit.) */
static bool swells(float size, float scale)
{
    return size > 0.0f && size <= 4.0f * RTK_GROW * scale;
}

static void look_task(void *data, uint32_t task)
{
    cut_job *job = data;
    uint32_t top = class_of(job->head->scale), found = 0;
    uint64_t end = (uint64_t)job->count * (task + 1) / TASKS;
    for (uint64_t i = (uint64_t)job->count * task / TASKS; i < end; i++) {
        float size, scale = prim_scale(job, (uint32_t)i, &size);
        found += swells(size, job->head->scale) && class_of(scale) + STEP <= top;
    }
    job->small[task] = found;
}

/* Cheap, and enough for nearly all scenes: are there small primitives at all? */
static bool worth_it(cut_job *job)
{
    uint32_t found = 0;
    rti_parallel(job->ctx, TASKS, look_task, job);
    for (uint32_t i = 0; i < TASKS; i++)
        found += job->small[i];
    return found >= FEWEST;
}

/* ---- pieces: union-find over triangles; a table of corners' positions finds who shares one ---- */

typedef struct piece_table {
    uint32_t *parent; /* [tri_count] */
    uint32_t *slots;  /* [mask + 1] triangle + 1 */
    float *scale;     /* [tri_count] of the piece, at its root */
    size_t mask;
} piece_table;

static uint32_t root_of(uint32_t *parent, uint32_t i)
{
    while (parent[i] != i) {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    return i;
}

/* The lowest triangle is the root. */
static void join(uint32_t *parent, uint32_t a, uint32_t b)
{
    a = root_of(parent, a);
    b = root_of(parent, b);
    if (a < b)
        parent[b] = a;
    else
        parent[a] = b;
}

static bool same_point(const float a[3], const float b[3])
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

static size_t point_hash(const float v[3])
{
    uint64_t h = 0x9e3779b97f4a7c15u;
    for (int k = 0; k < 3; k++) {
        h = (h ^ rtk_bits(v[k] + 0.0f)) * 0xff51afd7ed558ccdu; /* -0 is 0 */
        h ^= h >> 32;
    }
    return (size_t)h;
}

static void put_corner(const cut_job *job, piece_table *t, uint32_t tri, const float v[3])
{
    size_t at = point_hash(v) & t->mask;
    for (; t->slots[at] != NO_ENTRY; at = (at + 1) & t->mask) {
        const rtk_tri *other = &job->tris[t->slots[at] - 1];
        if (same_point(v, other->v0) || same_point(v, other->v1) || same_point(v, other->v2)) {
            join(t->parent, tri, t->slots[at] - 1);
            return;
        }
    }
    t->slots[at] = tri + 1;
}

static bool fill_table(const cut_job *job, piece_table *t)
{
    for (uint32_t i = 0; i < job->head->tri_count; i++) {
        if (i % 65536 == 0 && rti_cancelled(job->cancel))
            return false;
        put_corner(job, t, i, job->tris[i].v0);
        put_corner(job, t, i, job->tris[i].v1);
        put_corner(job, t, i, job->tris[i].v2);
    }
    return true;
}

static void classify(cut_job *job, piece_table *t)
{
    uint32_t tris = job->head->tri_count;
    float size;
    for (uint32_t i = 0; i < tris; i++) {
        uint32_t root = root_of(t->parent, i);
        t->scale[root] = rtk_max(t->scale[root], prim_scale(job, i, &size));
    }
    for (uint32_t i = 0; i < job->count; i++)
        job->classes[i] = (uint8_t)class_of(i < tris ? t->scale[root_of(t->parent, i)] : prim_scale(job, i, &size));
}

static rt_status find_pieces(cut_job *job, const char *call)
{
    size_t tris = job->head->tri_count, slots = 64;
    piece_table t;
    rt_status status = RT_OK;
    while (slots < 4 * tris) /* a soup has 3 corners a triangle */
        slots *= 2;
    t.mask = slots - 1;
    t.parent = rti_alloc_array(job->ctx, tris, sizeof *t.parent);
    t.slots = rti_alloc_zero(job->ctx, slots * sizeof *t.slots);
    t.scale = rti_alloc_zero(job->ctx, tris * sizeof *t.scale);
    if (!t.parent || !t.slots || !t.scale) {
        status = rti_fail_memory(job->ctx, call, slots * sizeof *t.slots + tris * (sizeof *t.parent + sizeof *t.scale));
    } else {
        for (uint32_t i = 0; i < tris; i++)
            t.parent[i] = i;
        if (fill_table(job, &t))
            classify(job, &t);
        else
            status = rti_fail(job->ctx, RT_ERROR_CANCELLED, "%s: cancelled", call);
    }
    rti_free(job->ctx, t.parent, tris * sizeof *t.parent);
    rti_free(job->ctx, t.slots, slots * sizeof *t.slots);
    rti_free(job->ctx, t.scale, tris * sizeof *t.scale);
    return status;
}

/* ---- where to cut ---- */

/* What the primitives of a class would be in boxes grown for a scale. */
typedef struct class_sum {
    double growth; /* what is added to a box' surface, in parts of it, summed up */
    uint32_t count, swell, crowd;
} class_sum;

static void sum_classes(const cut_job *job, float scale, class_sum sums[CLASSES])
{
    memset(sums, 0, CLASSES * sizeof *sums);
    for (uint32_t i = 0; i < job->count; i++) {
        class_sum *c = &sums[job->classes[i]];
        float size;
        prim_scale(job, i, &size);
        if (!(size > 0.0f))
            continue;
        const float side = 1.0f + 2.0f * RTK_GROW * scale / size;
        c->growth += rtk_min(side * side - 1.0f, MOST);
        c->swell += swells(size, scale);
        c->crowd += side >= 3.0f;
        c->count++;
    }
}

/* The highest class below `top` with which a part may begin, or 0. */
static uint32_t next_bound(const class_sum sums[CLASSES], uint32_t top)
{
    class_sum below = {0.0, 0, 0, 0};
    uint32_t bound = 0;
    for (uint32_t c = 0; c + STEP <= top; c++) {
        below.growth += sums[c].growth;
        below.count += sums[c].count;
        below.swell += sums[c].swell;
        below.crowd += sums[c].crowd;
        if (sums[c].swell > 0 && (below.crowd >= CROWD || (below.swell >= FEWEST && below.growth > below.count)))
            bound = c;
    }
    return bound;
}

static void choose_bounds(cut_job *job)
{
    uint32_t top = class_of(job->head->scale);
    float scale = job->head->scale;
    for (job->part_count = 1; job->part_count < RTK_PARTS; job->part_count++) {
        class_sum sums[CLASSES];
        sum_classes(job, scale, sums);
        top = next_bound(sums, top);
        if (top == 0)
            return;
        job->bounds[job->part_count] = top;
        scale = rtk_float((top + 1) << 23);
    }
}

static uint32_t part_of(const cut_job *job, uint32_t prim)
{
    uint32_t part = 0;
    while (part + 1 < job->part_count && job->classes[prim] <= job->bounds[part + 1])
        part++;
    return part;
}

/* The list stands in the new block, behind what the old one held. */
static void fill_list(const cut_job *job, rtk_group_header *head)
{
    uint32_t *list = (uint32_t *)(void *)((uint8_t *)head + head->off_list), next[RTK_PARTS] = {0};
    head->part_count = job->part_count;
    head->parts[0].count = 0;
    for (uint32_t i = 0; i < job->count; i++)
        head->parts[part_of(job, i)].count++;
    for (uint32_t p = 1; p < job->part_count; p++)
        next[p] = next[p - 1] + head->parts[p - 1].count;
    for (uint32_t i = 0; i < job->count; i++)
        list[next[part_of(job, i)]++] = i;
}

static rt_status cut(cut_job *job, const char *call, rtk_group_header **head, rti_layout *layout)
{
    size_t old_size = layout->size;
    uint64_t offset = rti_layout_add(layout, job->count, sizeof(uint32_t));
    rtk_group_header *block = layout->overflow ? NULL : rti_alloc_zero(job->ctx, layout->size);
    if (!block) {
        size_t wanted = layout->size;
        layout->size = old_size;
        return rti_fail_memory(job->ctx, call, wanted);
    }
    memcpy(block, *head, old_size);
    rti_free(job->ctx, *head, old_size);
    *head = block;
    block->off_list = offset;
    fill_list(job, block);
    rti_group_measure(job->ctx, block, block);
    return RT_OK;
}

rt_status rti_group_cut(rti_commit *c, rtk_group_header **head, rti_layout *layout)
{
    const uint8_t *base = (const uint8_t *)*head;
    cut_job job = {.ctx = c->scene->ctx, .cancel = &c->scene->cancel, .head = *head};
    rt_status status;
    job.tris = (const rtk_tri *)(const void *)(base + job.head->off_tris);
    job.shapes = (const rtk_shape *)(const void *)(base + job.head->off_shapes);
    job.count = job.head->tri_count + job.head->shape_count;
    if (job.count < FEWEST || !worth_it(&job))
        return RT_OK;
    job.classes = rti_alloc(job.ctx, job.count);
    if (!job.classes)
        return rti_fail_memory(job.ctx, c->call, job.count);
    status = find_pieces(&job, c->call);
    if (status == RT_OK) {
        choose_bounds(&job);
        if (job.part_count > 1)
            status = cut(&job, c->call, head, layout);
    }
    rti_free(job.ctx, job.classes, job.count);
    return status;
}
