/* Camera rays: groups of 4 x 4 pixels, all samples of a group in a row, so that the rays of a block are neighbours. */
#include <string.h>

#include "camera_rays.h"
#include "lanes.h"

#define GROUP 4u

/* Lanes of one group, one sample. */
typedef struct lanes {
    uint32_t count, sample;
    uint32_t x[RTK_BLOCK], y[RTK_BLOCK]; /* in the whole image */
    uint32_t home[RTK_BLOCK];
} lanes;

static bool open_tile(rti_worker *w)
{
    const rti_frame *f = w->frame;
    rti_slot *s;
    uint32_t slot = 0, index;
    if (w->no_more_tiles)
        return false;
    while (slot < f->slot_count && w->slots[slot].used)
        slot++;
    if (slot == f->slot_count)
        return false; /* all slots wait for rays: these come first */
    index = w->next_tile(w->owner);
    if (index == RTK_INVALID) {
        w->no_more_tiles = true;
        return false;
    }
    s = &w->slots[slot];
    s->tile = rti_frame_tile(f, index);
    s->index = index;
    s->live = 0;
    s->used = true;
    s->made = false;
    memset(w->film + ((size_t)slot << f->slot_shift) * RTK_FILM_CHANNELS, 0,
           (size_t)s->tile.width * s->tile.height * RTK_FILM_CHANNELS * sizeof *w->film);
    w->slot = slot;
    w->group_x = 0;
    w->group_y = 0;
    w->sample = 0;
    if (w->restore)
        w->restore(w->owner, index, w->film + ((size_t)slot << f->slot_shift) * RTK_FILM_CHANNELS);
    return true;
}

static void gather(const rti_worker *w, lanes *l)
{
    const rt_tile *t = &w->slots[w->slot].tile;
    uint32_t base = w->slot << w->frame->slot_shift;
    uint32_t x1 = w->group_x + GROUP < t->width ? w->group_x + GROUP : t->width;
    uint32_t y1 = w->group_y + GROUP < t->height ? w->group_y + GROUP : t->height;
    l->count = 0;
    l->sample = w->sample;
    for (uint32_t y = w->group_y; y < y1; y++) {
        for (uint32_t x = w->group_x; x < x1; x++) {
            l->x[l->count] = t->x + x;
            l->y[l->count] = t->y + y;
            l->home[l->count++] = base + y * t->width + x;
        }
    }
}

/* Next sample of the group, next group, end of the tile. */
static void advance(rti_worker *w)
{
    rti_slot *s = &w->slots[w->slot];
    if (++w->sample < w->frame->set.samples)
        return;
    w->sample = 0;
    w->group_x += GROUP;
    if (w->group_x < s->tile.width)
        return;
    w->group_x = 0;
    w->group_y += GROUP;
    if (w->group_y < s->tile.height)
        return;
    s->made = true;
    w->slot = RTK_INVALID;
}

/* A block's rays again, from a point of the lens at the time of each. */
static void emit_varying(const rti_frame *f, rtk_trace_block *t, rtk_path_block *p, const float *px, const float *py)
{
    const rtk_camera *camera = &f->scene->world->camera;
    bool moves = camera->flags & RTK_CAMERA_MOVING, raw = f->set.integrator->flags & RTI_INTEGRATOR_RAW;
    for (uint32_t k = 0; k < RTK_BLOCK; k++) {
        rtk_lens lens = f->lens;
        rtk_vec3 org, dir;
        if (moves) {
            lens = rtk_lens_at(camera, f->set.desc.width, f->set.desc.height, rti_frame_time(f, p->pixel[k], p->sample[k]));
            p->width[k] = lens.width;
            p->spread[k] = lens.spread;
        }
        if (lens.radius > 0.0f && !raw) {
            uint32_t seed = rtk_vertex_seed(f->seed, p->pixel[k], rtk_key_root());
            rtk_lens_thin_ray(lens, px[k], py[k], rtk_random2(seed, p->sample[k], RTK_DIM_LENS_U), &org, &dir);
        } else {
            rtk_lens_ray(lens, px[k], py[k], &org, &dir);
        }
        t->ox[k] = org.x;
        t->oy[k] = org.y;
        t->oz[k] = org.z;
        t->dx[k] = dir.x;
        t->dy[k] = dir.y;
        t->dz[k] = dir.z;
    }
}

/* Lanes [from, from + n) go to lanes [to, to + n). */
static void copy_lanes(void *to_block, uint32_t to, const void *from_block, uint32_t from, uint32_t n, size_t rows)
{
    uint32_t *d = to_block;
    const uint32_t *s = from_block;
    for (size_t r = 0; r < rows; r++)
        memcpy(d + r * RTK_BLOCK + to, s + r * RTK_BLOCK + from, n * sizeof *d);
}

static void copy_rays(rti_rays *batch, uint32_t at, const rtk_trace_block *t, const rtk_path_block *p, const uint32_t *home,
                      uint32_t from, uint32_t n)
{
    uint32_t b = at / RTK_BLOCK, k = at % RTK_BLOCK;
    copy_lanes(&batch->trace[b], k, t, from, n, sizeof *t / (RTK_BLOCK * sizeof(uint32_t)));
    copy_lanes(&batch->path[b], k, p, from, n, sizeof *p / (RTK_BLOCK * sizeof(uint32_t)));
    memcpy(batch->home[b].home + k, home + from, n * sizeof *home);
}

/* The lanes of l become rays [at, at + count) of the batch. A whole group in a whole block is made in its place. */
static void emit(rti_worker *w, lanes *l, uint32_t at)
{
    const rti_frame *f = w->frame;
    uint32_t head = RTK_BLOCK - at % RTK_BLOCK;
    bool whole = l->count == RTK_BLOCK && head == RTK_BLOCK;
    rtk_trace_block trace, *t = whole ? &w->batch.trace[at / RTK_BLOCK] : &trace;
    rtk_path_block path, *p = whole ? &w->batch.path[at / RTK_BLOCK] : &path;
    float px[RTK_BLOCK], py[RTK_BLOCK];
    if (l->count == 0)
        return;
    for (uint32_t k = l->count; k < RTK_BLOCK; k++) {
        l->x[k] = l->x[0];
        l->y[k] = l->y[0];
    }
    f->lanes->camera(f, l->x, l->y, l->sample, t, p, px, py);
    if (f->lens_varies)
        emit_varying(f, t, p, px, py);
    if (whole) {
        memcpy(w->batch.home[at / RTK_BLOCK].home, l->home, sizeof l->home);
        return;
    }
    head = head < l->count ? head : l->count;
    copy_rays(&w->batch, at, t, p, l->home, 0, head);
    if (head < l->count)
        copy_rays(&w->batch, at + head, t, p, l->home, head, l->count - head);
}

uint32_t rti_make_camera_rays(rti_worker *worker, uint32_t room)
{
    uint32_t count = 0;
    lanes l;
    while (count + RTK_BLOCK <= room) {
        if (worker->slot == RTK_INVALID && !open_tile(worker))
            break;
        gather(worker, &l);
        emit(worker, &l, count);
        worker->slots[worker->slot].live += l.count;
        worker->counts.rays[RTK_KIND_CAMERA] += l.count;
        count += l.count;
        advance(worker);
    }
    return count;
}
