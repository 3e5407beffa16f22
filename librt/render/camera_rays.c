/* Camera rays: groups of 4 x 4 pixels, all samples of a group in a row, so that the rays of a block are neighbours. */
#include <string.h>

#include "../kernel/filter.h"
#include "camera_rays.h"

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

/* Offset from the pixel's middle that the filter asks for; the single sample of a pixel is its middle. */
static void filter_offset(const rti_frame *f, uint32_t pixel, uint32_t sample, float *dx, float *dy)
{
    rtk_uv u;
    *dx = 0.0f;
    *dy = 0.0f;
    if (f->set.samples == 1)
        return;
    u = rtk_random2(rtk_vertex_seed(f->seed, pixel, rtk_key_root()), sample, RTK_DIM_FILTER_X);
    if (f->set.desc.filter == RT_FILTER_GAUSSIAN)
        u = rtk_filter_gaussian(u, f->set.desc.filter_width);
    else
        u = rtk_filter_box(u, f->set.desc.filter_width);
    *dx = u.x;
    *dy = u.y;
}

/* Rays [k0, k0 + n) of a block again, from a point of the lens at the time of each. */
static void emit_varying(const rti_frame *f, rtk_trace_block *t, rtk_path_block *p, uint32_t k0, uint32_t n, const float *px,
                         const float *py)
{
    const rtk_camera *camera = &f->scene->world->camera;
    bool moves = camera->flags & RTK_CAMERA_MOVING, raw = f->set.integrator->flags & RTI_INTEGRATOR_RAW;
    for (uint32_t k = k0; k < k0 + n; k++) {
        rtk_lens lens = f->lens;
        rtk_vec3 org, dir;
        if (moves) {
            lens = rtk_lens_at(camera, f->set.desc.width, f->set.desc.height, rti_frame_time(f, p->pixel[k], p->sample[k]));
            p->width[k] = lens.width;
            p->spread[k] = lens.spread;
        }
        if (lens.radius > 0.0f && !raw) {
            uint32_t seed = rtk_vertex_seed(f->seed, p->pixel[k], rtk_key_root());
            rtk_lens_thin_ray(lens, px[k - k0], py[k - k0], rtk_random2(seed, p->sample[k], RTK_DIM_LENS_U), &org, &dir);
        } else {
            rtk_lens_ray(lens, px[k - k0], py[k - k0], &org, &dir);
        }
        t->ox[k] = org.x;
        t->oy[k] = org.y;
        t->oz[k] = org.z;
        t->dx[k] = dir.x;
        t->dy[k] = dir.y;
        t->dz[k] = dir.z;
    }
}

/* Lanes [from, from + n) of l go to rays [at, at + n) of the batch, all in one block. */
static void emit(rti_worker *w, const lanes *l, uint32_t from, uint32_t at, uint32_t n)
{
    const rti_frame *f = w->frame;
    rtk_trace_block *t = &w->batch.trace[at / RTK_BLOCK];
    rtk_path_block *p = &w->batch.path[at / RTK_BLOCK];
    uint32_t *home = w->batch.home[at / RTK_BLOCK].home, k0 = at % RTK_BLOCK;
    float px[RTK_BLOCK], py[RTK_BLOCK];
    rtk_lens lens = f->lens;
    rtk_key root = rtk_key_root();
    for (uint32_t i = 0; i < n; i++) {
        uint32_t pixel = l->y[from + i] * f->set.desc.width + l->x[from + i];
        float dx, dy;
        filter_offset(f, pixel, l->sample, &dx, &dy);
        px[i] = (float)l->x[from + i] + 0.5f + dx;
        py[i] = (float)l->y[from + i] + 0.5f + dy;
        p->pixel[k0 + i] = pixel;
        home[k0 + i] = l->home[from + i];
    }
    for (uint32_t i = 0; i < n; i++) {
        uint32_t k = k0 + i;
        rtk_vec3 org, dir;
        rtk_lens_ray(lens, px[i], py[i], &org, &dir);
        t->ox[k] = org.x;
        t->oy[k] = org.y;
        t->oz[k] = org.z;
        t->dx[k] = dir.x;
        t->dy[k] = dir.y;
        t->dz[k] = dir.z;
        t->tmin[k] = 0.0f;
        t->tmax[k] = RTK_INF;
        t->mask[k] = RT_MASK_CAMERA;
    }
    for (uint32_t k = k0; k < k0 + n; k++) {
        p->tpr[k] = 1.0f;
        p->tpg[k] = 1.0f;
        p->tpb[k] = 1.0f;
        p->sample[k] = l->sample;
        p->depth_kind[k] = RTK_KIND_CAMERA << 16;
        p->key_lo[k] = root.lo;
        p->key_hi[k] = root.hi;
        p->eta[k] = 1.0f;
        p->width[k] = lens.width;
        p->spread[k] = lens.spread;
        p->pdf[k] = -1.0f;
    }
    if (f->lens_varies)
        emit_varying(f, t, p, k0, n, px, py);
}

uint32_t rti_make_camera_rays(rti_worker *worker, uint32_t room)
{
    uint32_t count = 0;
    lanes l;
    while (count + RTK_BLOCK <= room) {
        uint32_t head;
        if (worker->slot == RTK_INVALID && !open_tile(worker))
            break;
        gather(worker, &l);
        head = RTK_BLOCK - count % RTK_BLOCK;
        head = head < l.count ? head : l.count;
        emit(worker, &l, 0, count, head);
        if (head < l.count)
            emit(worker, &l, head, count + head, l.count - head);
        worker->slots[worker->slot].live += l.count;
        worker->counts.rays[RTK_KIND_CAMERA] += l.count;
        count += l.count;
        advance(worker);
    }
    return count;
}
