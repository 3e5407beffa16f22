/* Rays of plain arrays are gathered into blocks, traced, and their hits scattered: MANY at a time in a room of the context, which
 * a tracer can do most with (coherent ones NEAR at a time); some, or where no memory is to be had, on the stack. A few go one by
 * one, without blocks. */
#include "arrays.h"

#include "../trace/turn.h"

#define MANY           16384u
#define NEAR           512u /* coherent rays, for which blocks had better stay in the nearest cache */
#define FEW            256u /* 15 KiB of blocks */
#define ROOMY          16u  /* rays for which a room is taken */
#define ROOMY_COHERENT 32u  /* and of coherent ones, or who may be */
#define HITS_AT        (MANY / RTK_BLOCK * sizeof(rtk_trace_block))
#define ROOM_AT        (HITS_AT + MANY / RTK_BLOCK * sizeof(rtk_hit_block))
#define MEMORY_AT      (ROOM_AT + RTI_TRACE_ROOM)
#define ROOM           (MEMORY_AT + sizeof(memory))

/* What a room's last call has learned of its scene. Another one that stands where that stood may take it for its own: it costs
 * that one time. */
typedef struct memory {
    const rti_snapshot *scene;
    rti_learned learned;
} memory;

_Static_assert(HITS_AT % 64 == 0 && ROOM_AT % 64 == 0 && MEMORY_AT % 64 == 0, "the parts of a room are aligned");

rti_scratch rti_trace_room_take(const rti_snapshot *scene, size_t count, uint32_t flags)
{
    const bool many = count >= (flags & RTI_TRACE_COHERENT ? ROOMY_COHERENT : ROOMY);
    rti_scratch scratch = {.roomy = rti_context_roomy(scene->ctx)};
    bool used = false;
    unsigned char *room = many ? rti_room_take(scene->ctx, ROOM, &used) : NULL;
    if (room) {
        const memory *m = (const memory *)(const void *)(room + MEMORY_AT);
        scratch.room = room + ROOM_AT;
        if (used && m->scene == scene)
            scratch.learned = m->learned;
    }
    return scratch;
}

void rti_trace_room_give(const rti_snapshot *scene, const rti_scratch *scratch)
{
    if (!scratch->room)
        return;
    unsigned char *room = (unsigned char *)scratch->room - ROOM_AT;
    *(memory *)(void *)(room + MEMORY_AT) = (memory){scene, scratch->learned};
    rti_room_give(scene->ctx, room, ROOM);
}

/* Not for who asks a few rays: a desk is set up at the beginning of a function that may need one. */
#if defined(__GNUC__)
#define APART __attribute__((noinline))
#else
#define APART
#endif

/* Where a call's blocks stand. */
typedef struct desk {
    _Alignas(64) rtk_trace_block few_rays[FEW / RTK_BLOCK];
    _Alignas(64) rtk_hit_block few_hits[FEW / RTK_BLOCK];
    rtk_trace_block *rays;
    rtk_hit_block *hits; /* or the words of any hits */
    uint32_t most;
    rti_scratch scratch;
    const rti_turn *turn;
    rti_fpenv env;
} desk;

static void desk_open(desk *d, const rti_snapshot *s, size_t count, uint32_t flags)
{
    d->scratch = rti_trace_room_take(s, count, flags);
    unsigned char *room = d->scratch.room;
    d->rays = room ? (rtk_trace_block *)(void *)(room - ROOM_AT) : d->few_rays;
    d->hits = room ? (rtk_hit_block *)(void *)(room - ROOM_AT + HITS_AT) : d->few_hits;
    d->most = room ? MANY : FEW;
    d->turn = rti_turn_at(rti_context_isa(s->ctx));
    d->env = rti_fp_enter();
}

static void desk_close(desk *d, const rti_snapshot *s)
{
    rti_fp_leave(d->env);
    rti_trace_room_give(s, &d->scratch);
}

/* Do all sixteen rays point into one octant? Those without order hardly ever do. Written so that compilers make vectors of it. */
static bool one_octant(const rtk_trace_block *b)
{
    uint32_t other = 0, x = rtk_bits(b->dx[0]), y = rtk_bits(b->dy[0]), z = rtk_bits(b->dz[0]);
    for (uint32_t i = 0; i < RTK_BLOCK; i++)
        other |= (rtk_bits(b->dx[i]) ^ x) | (rtk_bits(b->dy[i]) ^ y) | (rtk_bits(b->dz[i]) ^ z);
    return !(other >> 31);
}

uint32_t rti_arrays_guess(const rtk_trace_block *b, uint32_t count)
{
    uint32_t blocks = count / RTK_BLOCK, seen = 0, alike = 0;
    for (uint32_t i = 0; i < blocks; i += 3) {
        alike += one_octant(&b[i]) ? 1u : 0u;
        seen++;
    }
    return blocks == 0 || 2 * alike < seen ? 0 : RTI_TRACE_COHERENT;
}

/* The next rays stand in their blocks; returns how many. Coherent ones of which the tracer has sent some another way, as others
 * do better, go as many at a time as those. */
static uint32_t desk_take(desk *d, const rt_ray *rays, const float *times, size_t left, uint32_t *flags)
{
    const uint32_t most = left < d->most ? (uint32_t)left : d->most;
    const uint32_t near = most < NEAR || (d->scratch.learned.apart[0] | d->scratch.learned.apart[1]) != 0 ? most : NEAR;
    d->turn->rays(rti_ray_at(rays), near, d->rays);
    d->scratch.times = times;
    if (*flags == RTI_ARRAYS_GUESS)
        *flags = rti_arrays_guess(d->rays, near);
    if (*flags & RTI_TRACE_COHERENT)
        return near;
    d->turn->rays(rti_ray_at(rays + near), most - near, d->rays + near / RTK_BLOCK);
    return most;
}

/* What the tracer may ask for beside its batch: the rays behind, of which `left` are left. */
static void desk_soon(desk *d, const rt_ray *rays, rt_hit *hits, size_t left, uint32_t flags)
{
    const uint32_t next = left < NEAR ? (uint32_t)left : NEAR;
    d->scratch.soon =
        (rti_soon){rti_ray_at(rays), hits ? rti_hit_at(hits) : NULL, flags & RTI_TRACE_COHERENT ? next / RTK_BLOCK : 0};
}

static APART void intersect_alone(const rti_snapshot *s, const rti_tracer *tracer, const rt_ray *rays, const float *times,
                                  rt_hit *hits, size_t count)
{
    const rti_fpenv env = rti_fp_enter();
    for (size_t i = 0; i < count; i++)
        tracer->one(&s->view, rti_ray_at(&rays[i]), times ? times[i] : 0.0f, rti_hit_at(&hits[i]));
    rti_fp_leave(env);
}

static APART void occluded_alone(const rti_snapshot *s, const rti_tracer *tracer, const rt_ray *rays, const float *times,
                                 uint8_t *occluded, size_t count)
{
    const rti_fpenv env = rti_fp_enter();
    for (size_t i = 0; i < count; i++)
        occluded[i] = tracer->one(&s->view, rti_ray_at(&rays[i]), times ? times[i] : 0.0f, NULL) != 0;
    rti_fp_leave(env);
}

static APART void intersect_many(const rti_snapshot *snapshot, const rti_tracer *tracer, const rt_ray *rays, const float *times,
                                 rt_hit *hits, size_t count, uint32_t flags)
{
    desk d;
    desk_open(&d, snapshot, count, flags);
    for (size_t at = 0; at < count;) {
        uint32_t as = flags, n = desk_take(&d, rays + at, times ? times + at : NULL, count - at, &as);
        desk_soon(&d, rays + at + n, hits + at + n, count - at - n, as);
        tracer->intersect(&snapshot->view, d.rays, d.hits, n, as, &d.scratch);
        d.turn->hits(d.hits, n, rti_hit_at(hits + at));
        at += n;
    }
    desk_close(&d, snapshot);
}

void rti_arrays_intersect(const rti_snapshot *snapshot, const rti_tracer *tracer, const rt_ray *rays, const float *times,
                          rt_hit *hits, size_t count, uint32_t flags)
{
    if (count == 1)
        rti_arrays_intersect_one(snapshot, tracer, rays, times ? times[0] : 0.0f, hits, false);
    else if (count < RTI_ARRAYS_ALONE)
        intersect_alone(snapshot, tracer, rays, times, hits, count);
    else
        intersect_many(snapshot, tracer, rays, times, hits, count, flags);
}

/* Bits to bytes of 0 and 1. Of eight, each in a byte of its own, what is missing to 0x80 is added to each byte, and the highest
 * bits are taken. */
static void spread(const uint16_t *bits, uint32_t count, uint8_t *out)
{
    uint32_t i = 0;
    for (; i + 8 <= count; i += 8) {
        const uint64_t eight = bits[i / RTK_BLOCK] >> i % RTK_BLOCK & 0xffu;
        const uint64_t apart = eight * 0x0101010101010101u & 0x8040201008040201u, some = (apart + 0x00406070787c7e7fu) >> 7;
        for (uint32_t k = 0; k < 8; k++)
            out[i + k] = (uint8_t)(some >> 8 * k & 1u);
    }
    for (; i < count; i++)
        out[i] = (uint8_t)(bits[i / RTK_BLOCK] >> i % RTK_BLOCK & 1u);
}

static APART void occluded_many(const rti_snapshot *snapshot, const rti_tracer *tracer, const rt_ray *rays, const float *times,
                                uint8_t *occluded, size_t count, uint32_t flags)
{
    desk d;
    desk_open(&d, snapshot, count, flags);
    for (size_t at = 0; at < count;) {
        uint16_t *bits = (uint16_t *)(void *)d.hits;
        uint32_t as = flags, n = desk_take(&d, rays + at, times ? times + at : NULL, count - at, &as);
        desk_soon(&d, rays + at + n, NULL, count - at - n, as);
        tracer->occluded(&snapshot->view, d.rays, bits, n, as, &d.scratch);
        spread(bits, n, occluded + at);
        at += n;
    }
    desk_close(&d, snapshot);
}

void rti_arrays_occluded(const rti_snapshot *snapshot, const rti_tracer *tracer, const rt_ray *rays, const float *times,
                         uint8_t *occluded, size_t count, uint32_t flags)
{
    if (count == 1)
        rti_arrays_occluded_one(snapshot, tracer, rays, times ? times[0] : 0.0f, occluded, false);
    else if (count < RTI_ARRAYS_ALONE)
        occluded_alone(snapshot, tracer, rays, times, occluded, count);
    else
        occluded_many(snapshot, tracer, rays, times, occluded, count, flags);
}
