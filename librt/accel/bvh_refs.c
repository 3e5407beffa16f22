/* References of a BVH's builder and their boxes, at the root. */
#include <string.h>

#include "bvh_build.h"

typedef struct root_piece {
    uint32_t kept;
    rti_bvh_box box, mid;
} root_piece;

typedef struct root_job {
    const rti_bvh *t;
    root_piece *pieces;
    uint32_t size;
} root_job;

static bool finite_box(rti_bvh_box b, rti_f4 zero)
{
    return rti_f4_below(zero, zero) && rti_f4_below(b.lo, b.hi); /* of a NaN it is not true */
}

/* The box of a primitive; false: it is left out (not finite, or low above high). */
static bool prim_box(const rti_build_input *in, uint32_t prim, rti_bvh_box *out)
{
    rti_f4 nought = rti_f4_set(0.0f), zero;
    if (prim < in->tri_count) {
        const rtk_tri *t = &in->tris[prim];
        rti_f4 a = rti_f4_load(t->v0), b = rti_f4_load(t->v1), c = rti_f4_load(t->v2);
        out->lo = rti_f4_min(rti_f4_min(a, b), c);
        out->hi = rti_f4_max(rti_f4_max(a, b), c);
        zero = a * nought + b * nought + c * nought;
    } else {
        const float *p = in->boxes[prim - in->tri_count];
        out->lo = (rti_f4){p[0], p[1], p[2], 0.0f};
        out->hi = (rti_f4){p[3], p[4], p[5], 0.0f};
        zero = out->lo * nought + out->hi * nought;
    }
    return finite_box(*out, zero);
}

static void root_task(void *data, uint32_t index)
{
    root_job *job = data;
    const rti_build *b = job->t->b;
    root_piece *p = &job->pieces[index];
    const uint32_t begin = index * job->size, end = begin + rtk_umin(job->size, b->prim_count - begin);
    rti_ref *to = job->t->refs[0] + begin;
    p->kept = 0;
    p->box = p->mid = rti_bvh_nothing();
    for (uint32_t i = begin; i < end && !rti_cancelled(b->cancel); i++) {
        rti_bvh_box box, mid;
        if (!prim_box(b->in, i, &box))
            continue;
        rti_f4_store(to->lo, box.lo);
        rti_f4_store(to->hi, box.hi);
        to->prim = i;
        to->pad = 0;
        to++;
        mid.lo = mid.hi = rti_bvh_mid(box);
        rti_bvh_extend(&p->box, box);
        rti_bvh_extend(&p->mid, mid);
        p->kept++;
    }
}

rt_status rti_bvh_make_refs(rti_bvh *t, uint32_t size, rti_bvh_range *root)
{
    const uint32_t count = (t->b->prim_count + size - 1) / size;
    root_job job = {t, rti_alloc_array(t->ctx, count, sizeof *job.pieces), size};
    if (!job.pieces)
        return RT_ERROR_MEMORY;
    rti_parallel(t->ctx, count, root_task, &job);
    memset(root, 0, sizeof *root);
    root->box = root->mid = rti_bvh_nothing();
    for (uint32_t i = 0; i < count; i++) {
        if (root->count != i * size)
            memmove(t->refs[0] + root->count, t->refs[0] + (size_t)i * size, job.pieces[i].kept * sizeof(rti_ref));
        root->count += job.pieces[i].kept;
        rti_bvh_extend(&root->box, job.pieces[i].box);
        rti_bvh_extend(&root->mid, job.pieces[i].mid);
    }
    root->room_end = (uint32_t)t->room;
    rti_free(t->ctx, job.pieces, count * sizeof *job.pieces);
    return rti_cancelled(t->b->cancel) ? RT_ERROR_CANCELLED : RT_OK;
}
