/* A worker's memory, its stack of waiting rays, and one step of the wavefront. */
#include <string.h>

#include "camera_rays.h"
#include "image.h"
#include "lanes.h"
#include "wavefront.h"

/* Points that are still in the nearest cache when their light shines. Where there are several lights all of a step gather, for
 * the rays to one of them are alike. */
#define LIT_FEW 64u

/* ---- memory: one walk over the arrays measures or places them ---- */

typedef struct layout {
    unsigned char *base; /* NULL: only measuring */
    size_t size;
} layout;

static void *take(layout *l, size_t count, size_t size)
{
    void *p = l->base ? l->base + l->size : NULL;
    l->size += (count * size + RTI_CACHE_LINE - 1) / RTI_CACHE_LINE * RTI_CACHE_LINE;
    return p;
}

static void place_rays(layout *l, rti_rays *rays, uint32_t capacity)
{
    uint32_t blocks = (capacity + RTK_BLOCK - 1) / RTK_BLOCK;
    rays->trace = take(l, blocks, sizeof *rays->trace);
    rays->path = take(l, blocks, sizeof *rays->path);
    rays->home = take(l, blocks, sizeof *rays->home);
    rays->capacity = blocks * RTK_BLOCK;
}

/* First what every step uses, last what few do: pages that nobody touches cost nothing. Counts are bounded by rti_frame_plan, so
 * that no product here overflows. */
static size_t place(rti_worker *w, const rti_frame *f, unsigned char *memory)
{
    layout l = {memory, 0};
    uint32_t shadow_blocks = f->shadow_rays / RTK_BLOCK;
    place_rays(&l, &w->batch, f->batch);
    w->hits = take(&l, f->batch / RTK_BLOCK, sizeof *w->hits);
    w->lit_stride = f->batch + RTK_BLOCK;
    w->lit = take(&l, (size_t)RTI_LIT_ROWS * w->lit_stride, sizeof *w->lit);
    w->lit_ray = take(&l, w->lit_stride, sizeof *w->lit_ray);
    w->lit_home = take(&l, w->lit_stride, sizeof *w->lit_home);
    w->keys = take(&l, f->batch, sizeof *w->keys);
    w->order = take(&l, f->batch, sizeof *w->order);
    w->materials = take(&l, f->batch, sizeof *w->materials);
    w->shadows.trace = take(&l, shadow_blocks, sizeof *w->shadows.trace);
    w->shadows.pending = take(&l, shadow_blocks, sizeof *w->shadows.pending);
    w->shadows.hits = take(&l, shadow_blocks, sizeof *w->shadows.hits);
    w->shadows.occluded = take(&l, shadow_blocks, sizeof *w->shadows.occluded);
    w->shadows.times = take(&l, f->moving ? f->shadow_rays : 0, sizeof *w->shadows.times);
    w->shadows.capacity = f->shadow_rays;
    w->times = take(&l, f->moving ? f->batch : 0, sizeof *w->times);
    w->steps = take(&l, f->set.integrator->flags & RTI_INTEGRATOR_STEPS ? f->batch : 0, sizeof *w->steps);
    w->touched = take(&l, f->scene->material_count / 32 + 1, sizeof *w->touched);
    w->slots = take(&l, f->slot_count, sizeof *w->slots);
    w->film = take(&l, (size_t)f->slot_count << f->slot_shift, RTK_FILM_CHANNELS * sizeof *w->film);
    place_rays(&l, &w->stack, f->stack_rays);
    w->scratch.room = take(&l, 1, f->scene->instance_count != 0 ? RTI_TRACE_ROOM : RTI_TRACE_PLAIN);
    return l.size;
}

size_t rti_worker_size(const rti_frame *frame)
{
    rti_worker unused;
    return place(&unused, frame, NULL);
}

void rti_worker_init(rti_worker *worker, const rti_frame *frame, void *memory)
{
    memset(worker, 0, sizeof *worker);
    worker->frame = frame;
    place(worker, frame, memory);
    worker->scratch.bare = true; /* shading makes its own of the point */
    worker->scratch.roomy = frame->roomy;
    worker->slot = RTK_INVALID;
    worker->shadows.light = RTK_INVALID;
    worker->lit_most = frame->scene->light_count > 1 ? frame->batch + RTK_BLOCK : LIT_FEW;
    memset(worker->touched, 0, (frame->scene->material_count / 32 + 1) * sizeof *worker->touched);
    memset(worker->slots, 0, frame->slot_count * sizeof *worker->slots);
    memset(worker->lit, 0, (size_t)RTI_LIT_ROWS * worker->lit_stride * sizeof *worker->lit); /* lanes behind the last are read */
}

/* ---- the stack ---- */

/* Moves the top of the stack, whole blocks of it and at most `room` rays, behind the batch's first `first` rays. */
static uint32_t take_from_stack(rti_worker *w, uint32_t first, uint32_t room)
{
    rti_rays *from = &w->stack, *to = &w->batch;
    uint32_t blocks = (from->count + RTK_BLOCK - 1) / RTK_BLOCK, n = blocks < room / RTK_BLOCK ? blocks : room / RTK_BLOCK;
    uint32_t at = blocks - n, taken = from->count - at * RTK_BLOCK, to_block = first / RTK_BLOCK;
    if (n == 0)
        return 0;
    memcpy(to->trace + to_block, from->trace + at, n * sizeof *to->trace);
    memcpy(to->path + to_block, from->path + at, n * sizeof *to->path);
    memcpy(to->home + to_block, from->home + at, n * sizeof *to->home);
    from->count = at * RTK_BLOCK;
    w->camera_blocks = w->camera_blocks < to_block ? w->camera_blocks : to_block;
    return taken;
}

/* ---- tiles ---- */

void rti_set_raw(rti_worker *worker, uint32_t home, rtk_vec3 value)
{
    uint64_t *sum = worker->film + (size_t)home * RTK_FILM_CHANNELS;
    sum[0] = rtk_bits(value.x);
    sum[1] = rtk_bits(value.y);
    sum[2] = rtk_bits(value.z);
}

static void resolve_raw(const rti_frame *f, const uint64_t *sum, float *out, uint32_t pixels)
{
    for (uint32_t x = 0; x < pixels; x++, sum += RTK_FILM_CHANNELS, out += 4) {
        for (int c = 0; c < 3; c++)
            out[c] = rtk_float((uint32_t)sum[c]);
        out[3] = (float)((double)sum[3] / (double)f->set.samples);
    }
}

static void finish_tile(rti_worker *w, uint32_t slot)
{
    const rti_frame *f = w->frame;
    rti_slot *s = &w->slots[slot];
    const uint64_t *sum = w->film + ((size_t)slot << f->slot_shift) * RTK_FILM_CHANNELS;
    for (uint32_t y = 0; y < s->tile.height; y++, sum += (size_t)s->tile.width * RTK_FILM_CHANNELS) {
        float *row = rti_image_row(f->image, s->tile.y - f->set.desc.crop.y + y) + (size_t)(s->tile.x - f->set.desc.crop.x) * 4;
        if (f->set.integrator->flags & RTI_INTEGRATOR_RAW)
            resolve_raw(f, sum, row, s->tile.width);
        else
            f->lanes->resolve(sum, row, s->tile.width, f->film_unit, (double)f->set.samples);
    }
    s->used = false;
    w->counts.tiles++;
    w->tile_done(w->owner, s->index);
}

/* A block's rays are of one tile, as a rule. */
static void settle(rti_worker *w, uint32_t first, uint32_t count)
{
    const uint32_t shift = w->frame->slot_shift;
    for (uint32_t i = first; i < first + count; i += RTK_BLOCK) { /* first is a block's */
        const uint32_t *home = w->batch.home[i / RTK_BLOCK].home, n = first + count - i;
        uint32_t differ = 0;
        for (uint32_t k = 0; k < RTK_BLOCK; k++)
            differ |= home[k] ^ home[0];
        if (n >= RTK_BLOCK && differ >> shift == 0) {
            w->slots[home[0] >> shift].live -= RTK_BLOCK;
            continue;
        }
        for (uint32_t k = 0; k < RTK_BLOCK && k < n; k++)
            w->slots[home[k] >> shift].live--;
    }
}

static void finish_tiles(rti_worker *w)
{
    for (uint32_t i = 0; i < w->frame->slot_count; i++) {
        if (w->slots[i].used && w->slots[i].made && w->slots[i].live == 0)
            finish_tile(w, i);
    }
}

/* ---- a step ---- */

static void trace(rti_worker *w, uint32_t first, uint32_t count, uint32_t flags)
{
    const rti_frame *f = w->frame;
    if (count == 0)
        return;
    w->scratch.steps = NULL;
    w->scratch.times = f->moving ? w->times + first : NULL;
    for (uint32_t i = first; f->moving && i < first + count; i++) {
        const rtk_path_block *p = &w->batch.path[i / RTK_BLOCK];
        w->times[i] = rti_frame_time(f, p->pixel[i % RTK_BLOCK], p->sample[i % RTK_BLOCK]);
    }
    if (f->set.integrator->flags & RTI_INTEGRATOR_STEPS) {
        flags |= RTI_TRACE_STEPS;
        w->scratch.steps = w->steps + first;
    }
    f->set.tracer->intersect(f->scene, w->batch.trace + first / RTK_BLOCK, w->hits + first / RTK_BLOCK, count, flags,
                             &w->scratch);
}

bool rti_block_alike(const rtk_trace_block *t)
{
    const float x = t->dx[0], y = t->dy[0], z = t->dz[0], least = 0.81f * (x * x + y * y + z * z);
    uint32_t apart = 0;
    for (uint32_t k = 0; k < RTK_BLOCK; k++) {
        const float dx = t->dx[k], dy = t->dy[k], dz = t->dz[k], along = dx * x + dy * y + dz * z;
        apart |= (uint32_t) !(along > 0.0f) | (uint32_t) !(along * along > least * (dx * dx + dy * dy + dz * dz));
    }
    return apart == 0;
}

/* Are three of four blocks alike? So are those of flat mirrors and panes, and packets pay. */
static bool coherent(const rtk_trace_block *trace, uint32_t blocks)
{
    uint32_t alike = 0;
    for (uint32_t b = 0; b < blocks; b++)
        alike += rti_block_alike(&trace[b]);
    return blocks > 0 && 4 * alike >= 3 * blocks;
}

bool rti_worker_step(rti_worker *worker)
{
    const rti_frame *f = worker->frame;
    uint32_t waiting = (worker->stack.count + RTK_BLOCK - 1) / RTK_BLOCK * RTK_BLOCK, camera = 0, first, taken;
    if (rti_cancelled(f->cancel))
        return false;
    if (waiting < f->batch && !worker->hold)
        camera = rti_make_camera_rays(worker, f->batch - waiting);
    first = (camera + RTK_BLOCK - 1) / RTK_BLOCK * RTK_BLOCK;
    taken = take_from_stack(worker, first, f->batch - first);
    if (camera + taken == 0)
        return false;
    trace(worker, 0, camera, RTI_TRACE_COHERENT);
    trace(worker, first, taken, coherent(worker->batch.trace + first / RTK_BLOCK, taken / RTK_BLOCK) ? RTI_TRACE_COHERENT : 0);
    f->set.integrator->shade(worker, 0, camera);
    f->set.integrator->shade(worker, first, taken);
    if (f->set.integrator->light)
        f->set.integrator->light(worker);
    rti_shadow_flush(worker);
    if (rti_cancelled(f->cancel))
        return false; /* shadows may have been left out: no tile of this batch is whole */
    settle(worker, 0, camera);
    settle(worker, first, taken);
    finish_tiles(worker);
    return true;
}
