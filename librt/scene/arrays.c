/* Rays of plain arrays are gathered into blocks, traced, and their hits scattered: MANY at a time in a room of the context, which
 * a tracer can do most with (coherent ones NEAR at a time); some, or where no memory is to be had, on the stack. A few go one by
 * one, without blocks. */
#include "arrays.h"

#include "gather.h"

#define MANY    16384u
#define NEAR    1024u /* coherent rays, for which blocks had better stay in the nearer caches */
#define FEW     256u  /* 15 KiB of blocks */
#define ROOMY   32u   /* rays for which a room is taken */
#define HITS_AT (MANY / RTK_BLOCK * sizeof(rtk_trace_block))
#define ROOM_AT (HITS_AT + MANY / RTK_BLOCK * sizeof(rtk_hit_block))
#define ROOM    (ROOM_AT + RTI_TRACE_ROOM)

_Static_assert(HITS_AT % 64 == 0 && ROOM_AT % 64 == 0, "the parts of a room are aligned");

void *rti_trace_room_take(rt_context *ctx, size_t count)
{
    unsigned char *room = count >= ROOMY ? rti_room_take(ctx, ROOM) : NULL;
    return room ? room + ROOM_AT : NULL;
}

void rti_trace_room_give(rt_context *ctx, void *room)
{
    if (room)
        rti_room_give(ctx, (unsigned char *)room - ROOM_AT, ROOM);
}

/* Where a call's blocks stand. */
typedef struct desk {
    _Alignas(64) rtk_trace_block few_rays[FEW / RTK_BLOCK];
    _Alignas(64) rtk_hit_block few_hits[FEW / RTK_BLOCK];
    rtk_trace_block *rays;
    rtk_hit_block *hits; /* or the words of any hits */
    uint32_t most;
    rti_scratch scratch;
    rti_fpenv env;
} desk;

static void desk_open(desk *d, const rti_snapshot *s, size_t count)
{
    unsigned char *room = rti_trace_room_take(s->ctx, count);
    d->scratch = (rti_scratch){.room = room};
    d->rays = room ? (rtk_trace_block *)(void *)(room - ROOM_AT) : d->few_rays;
    d->hits = room ? (rtk_hit_block *)(void *)(room - ROOM_AT + HITS_AT) : d->few_hits;
    d->most = room ? MANY : FEW;
    d->env = rti_fp_enter();
}

static void desk_close(desk *d, const rti_snapshot *s)
{
    rti_fp_leave(d->env);
    rti_trace_room_give(s->ctx, d->scratch.room);
}

/* The next rays stand in their blocks; returns how many. */
static uint32_t desk_take(desk *d, const rt_ray *rays, const float *times, size_t left, uint32_t *flags)
{
    const uint32_t most = left < d->most ? (uint32_t)left : d->most, near = most < NEAR ? most : NEAR;
    rti_gather(rays, near, d->rays);
    d->scratch.times = times;
    if (*flags == RTI_ARRAYS_GUESS)
        *flags = rti_guess(d->rays, near);
    if (*flags & RTI_TRACE_COHERENT)
        return near;
    rti_gather(rays + near, most - near, d->rays + near / RTK_BLOCK);
    return most;
}

#define SAME(a, b) (offsetof(rt_ray, a) == offsetof(rti_ray, b))
_Static_assert(sizeof(rt_ray) == sizeof(rti_ray) && SAME(org, org) && SAME(tmin, tmin) && SAME(dir, dir) && SAME(tmax, tmax) &&
                   SAME(mask, mask),
               "a public ray is a tracer's");
#undef SAME
#define SAME(a, b) (offsetof(rt_hit, a) == offsetof(rti_hit, b))
_Static_assert(sizeof(rt_hit) == sizeof(rti_hit) && SAME(t, t) && SAME(u, u) && SAME(v, v) && SAME(prim_id, prim) &&
                   SAME(geom_id, geom) && SAME(inst_id, inst),
               "and so is a hit");
#undef SAME

static void intersect_alone(const rti_snapshot *s, const rti_tracer *tracer, const rt_ray *rays, const float *times, rt_hit *hits,
                            size_t count)
{
    const rti_fpenv env = rti_fp_enter();
    for (size_t i = 0; i < count; i++)
        tracer->one(&s->view, (const rti_ray *)(const void *)&rays[i], times ? times[i] : 0.0f, (rti_hit *)(void *)&hits[i]);
    rti_fp_leave(env);
}

static void occluded_alone(const rti_snapshot *s, const rti_tracer *tracer, const rt_ray *rays, const float *times,
                           uint8_t *occluded, size_t count)
{
    const rti_fpenv env = rti_fp_enter();
    for (size_t i = 0; i < count; i++)
        occluded[i] = tracer->one(&s->view, (const rti_ray *)(const void *)&rays[i], times ? times[i] : 0.0f, NULL) != 0;
    rti_fp_leave(env);
}

void rti_arrays_intersect(const rti_snapshot *snapshot, const rti_tracer *tracer, const rt_ray *rays, const float *times,
                          rt_hit *hits, size_t count, uint32_t flags)
{
    desk d;
    if (count < RTI_ARRAYS_ALONE) {
        intersect_alone(snapshot, tracer, rays, times, hits, count);
        return;
    }
    desk_open(&d, snapshot, count);
    for (size_t at = 0; at < count;) {
        uint32_t as = flags, n = desk_take(&d, rays + at, times ? times + at : NULL, count - at, &as);
        tracer->intersect(&snapshot->view, d.rays, d.hits, n, as, &d.scratch);
        rti_scatter(d.hits, n, hits + at);
        at += n;
    }
    desk_close(&d, snapshot);
}

void rti_arrays_occluded(const rti_snapshot *snapshot, const rti_tracer *tracer, const rt_ray *rays, const float *times,
                         uint8_t *occluded, size_t count, uint32_t flags)
{
    desk d;
    if (count < RTI_ARRAYS_ALONE) {
        occluded_alone(snapshot, tracer, rays, times, occluded, count);
        return;
    }
    desk_open(&d, snapshot, count);
    for (size_t at = 0; at < count;) {
        uint16_t *bits = (uint16_t *)(void *)d.hits;
        uint32_t as = flags, n = desk_take(&d, rays + at, times ? times + at : NULL, count - at, &as);
        tracer->occluded(&snapshot->view, d.rays, bits, n, as, &d.scratch);
        for (uint32_t i = 0; i < n; i++)
            occluded[at + i] = (uint8_t)(bits[i / RTK_BLOCK] >> i % RTK_BLOCK & 1u);
        at += n;
    }
    desk_close(&d, snapshot);
}
