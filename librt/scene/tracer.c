/* Tracer objects: a snapshot that has the trees of one tracer, asked directly. */
#include "librt/trace.h"

#include <string.h>

#include "../accel/accel.h"
#include "../trace/trace.h"
#include "arrays.h"
#include "look.h"

#define SAME(a, b) (offsetof(rt_ray_block, a) == offsetof(rtk_trace_block, b))
_Static_assert(sizeof(rt_ray_block) == sizeof(rtk_trace_block) && SAME(org_x, ox) && SAME(dir_x, dx) && SAME(tmin, tmin) &&
                   SAME(tmax, tmax) && SAME(mask, mask),
               "a public block of rays is one of the tracers'");
#undef SAME
#define SAME(a, b) (offsetof(rt_hit_block, a) == offsetof(rtk_hit_block, b))
_Static_assert(sizeof(rt_hit_block) == sizeof(rtk_hit_block) && SAME(t, t) && SAME(v, v) && SAME(prim_id, prim) &&
                   SAME(geom_id, geom) && SAME(inst_id, inst),
               "and so is a block of hits");
_Static_assert(RT_RAYS_COHERENT == RTI_TRACE_COHERENT, "a hint is a flag");

struct rt_tracer {
    rti_snapshot *snapshot;
    const rti_tracer *how;
};

rt_status rt_tracer_create(const rt_scene *scene, const char *name, rt_tracer **tracer)
{
    RTI_NEED_TO_MAKE(tracer, scene);
    static const char call[] = "rt_tracer_create";
    rt_tree_query query = rt_tree_query_default();
    rti_look look;
    rt_tracer *t;
    rt_status status;
    if (!tracer)
        return rti_fail(rt_scene_context(scene), RT_ERROR_ARGUMENT, "%s: tracer is NULL; give the place for it", call);
    *tracer = NULL;
    query.tracer = name ? name : "auto";
    status = rti_look_begin(scene, call, &query, &look);
    if (status != RT_OK)
        return status;
    t = rti_alloc(look.snapshot->ctx, sizeof *t);
    if (!t) {
        status = rti_fail_memory(look.snapshot->ctx, call, sizeof *t);
        rti_snapshot_release(look.snapshot);
        return status;
    }
    *t = (rt_tracer){look.snapshot, look.tracer};
    *tracer = t;
    return RT_OK;
}

void rt_tracer_destroy(rt_tracer *tracer)
{
    if (!tracer)
        return;
    rti_snapshot *snapshot = tracer->snapshot;
    rti_free(snapshot->ctx, tracer, sizeof *tracer);
    rti_snapshot_release(snapshot);
}

typedef struct tally {
    rt_tracer_info *info;
    uint32_t kind;
} tally;

static void count_chunk(void *data, const rti_chunk *chunk, uint32_t group)
{
    tally *t = data;
    (void)group;
    if (chunk->kind == RTK_CHUNK_GROUP)
        t->info->geometry_bytes += chunk->size;
    if (chunk->kind != RTK_CHUNK_TREE || ((const rtk_tree_header *)chunk->data)->kind != t->kind)
        return;
    t->info->trees++;
    t->info->tree_bytes += chunk->size;
    t->info->build_seconds += ((const rtk_tree_header *)chunk->data)->build_seconds;
}

void rt_tracer_get_info(const rt_tracer *tracer, rt_tracer_info *info)
{
    tally t = {info, tracer->how->tree};
    memset(info, 0, sizeof *info);
    info->name = tracer->how->name;
    info->tree = t.kind == RTK_TREE_NONE ? NULL : rti_tree_kind_of(t.kind)->name;
    info->width = tracer->how->width;
    rti_snapshot_each(tracer->snapshot, count_chunk, &t);
}

/* Flags for a tracer. That all rays start at one point tells today's nothing that a packet does not see. */
static uint32_t flags_of(uint32_t hints)
{
    return hints & RTI_TRACE_COHERENT;
}

void rt_tracer_intersect(const rt_tracer *tracer, const rt_ray *rays, rt_hit *hits, size_t count, uint32_t hints)
{
    if (count == 1)
        rti_arrays_intersect_one(tracer->snapshot, tracer->how, rays, 0.0f, hits, (hints & RT_RAYS_DEFAULT_FENV) != 0);
    else
        rti_arrays_intersect(tracer->snapshot, tracer->how, rays, NULL, hits, count, flags_of(hints));
}

void rt_tracer_occluded(const rt_tracer *tracer, const rt_ray *rays, uint8_t *occluded, size_t count, uint32_t hints)
{
    if (count == 1)
        rti_arrays_occluded_one(tracer->snapshot, tracer->how, rays, 0.0f, occluded, (hints & RT_RAYS_DEFAULT_FENV) != 0);
    else
        rti_arrays_occluded(tracer->snapshot, tracer->how, rays, NULL, occluded, count, flags_of(hints));
}

/* A tracer takes 2^32 - 1 rays at most; callers may have more. */
#define PIECE 0x40000000u

void rt_tracer_intersect_blocks(const rt_tracer *tracer, const rt_ray_block *rays, rt_hit_block *hits, size_t count,
                                uint32_t hints)
{
    const rtk_trace_block *in = (const rtk_trace_block *)(const void *)rays;
    rtk_hit_block *out = (rtk_hit_block *)(void *)hits;
    const uint32_t flags = flags_of(hints);
    rti_fpenv env = rti_fp_enter();
    rti_scratch scratch = rti_trace_room_take(tracer->snapshot, count, flags);
    for (size_t at = 0; at < count; at += PIECE) {
        uint32_t n = count - at < PIECE ? (uint32_t)(count - at) : PIECE;
        tracer->how->intersect(&tracer->snapshot->view, in + at / RTK_BLOCK, out + at / RTK_BLOCK, n, flags, &scratch);
    }
    rti_fp_leave(env);
    rti_trace_room_give(tracer->snapshot, &scratch);
}

void rt_tracer_occluded_blocks(const rt_tracer *tracer, const rt_ray_block *rays, uint16_t *occluded, size_t count,
                               uint32_t hints)
{
    const rtk_trace_block *in = (const rtk_trace_block *)(const void *)rays;
    const uint32_t flags = flags_of(hints);
    rti_fpenv env = rti_fp_enter();
    rti_scratch scratch = rti_trace_room_take(tracer->snapshot, count, flags);
    for (size_t at = 0; at < count; at += PIECE) {
        uint32_t n = count - at < PIECE ? (uint32_t)(count - at) : PIECE;
        tracer->how->occluded(&tracer->snapshot->view, in + at / RTK_BLOCK, occluded + at / RTK_BLOCK, n, flags, &scratch);
    }
    rti_fp_leave(env);
    rti_trace_room_give(tracer->snapshot, &scratch);
}

uint64_t rt_scene_get_triangles(const rt_scene *scene, uint64_t first, rt_triangle *triangles, size_t capacity)
{
    rti_snapshot *s = rti_scene_snapshot(scene);
    uint64_t count = s ? s->view.groups[0].tri_count : 0;
    for (size_t i = 0; i < capacity && first < count && i < count - first; i++) {
        const rtk_tri *t = &s->view.groups[0].tris[first + i];
        triangles[i] = (rt_triangle){
            {t->v0[0], t->v0[1], t->v0[2]}, {t->v1[0], t->v1[1], t->v1[2]}, {t->v2[0], t->v2[1], t->v2[2]}, t->geom, t->prim};
    }
    rti_snapshot_release(s);
    return count;
}
