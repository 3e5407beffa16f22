/* Camera rays: groups of 4 x 4 pixels, all samples of a group in a row, so that the rays of a block are neighbours. */
#include <string.h>

#include "camera_rays.h"
#include "lanes.h"

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

static rti_pixel_group group_at(const rti_worker *w)
{
    const rt_tile *t = &w->slots[w->slot].tile;
    const uint32_t right = t->width - w->group_x, below = t->height - w->group_y;
    rti_pixel_group g;
    g.x = t->x + w->group_x;
    g.y = t->y + w->group_y;
    g.columns = right < RTI_GROUP ? right : RTI_GROUP;
    g.rows = below < RTI_GROUP ? below : RTI_GROUP;
    g.sample = w->sample;
    g.home = (w->slot << w->frame->slot_shift) + w->group_y * t->width + w->group_x;
    g.pitch = t->width;
    return g;
}

/* Next sample of the group, next group, end of the tile. */
static void advance(rti_worker *w)
{
    rti_slot *s = &w->slots[w->slot];
    if (++w->sample < w->frame->set.samples)
        return;
    w->sample = 0;
    w->group_x += RTI_GROUP;
    if (w->group_x < s->tile.width)
        return;
    w->group_x = 0;
    w->group_y += RTI_GROUP;
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

/* A group's pixels become rays of the batch from `at` on; returns how many. A whole group in a whole block is made in its place.
 */
static uint32_t emit(rti_worker *w, const rti_pixel_group *g, uint32_t at)
{
    const rti_frame *f = w->frame;
    const uint32_t b = at / RTK_BLOCK, count = g->columns * g->rows;
    uint32_t head = RTK_BLOCK - at % RTK_BLOCK;
    const bool whole = count == RTK_BLOCK && head == RTK_BLOCK;
    rtk_trace_block trace, *t = whole ? &w->batch.trace[b] : &trace;
    rtk_path_block path, *p = whole ? &w->batch.path[b] : &path;
    rti_home_block home, *h = whole ? &w->batch.home[b] : &home;
    float px[RTK_BLOCK] RTI_ROW, py[RTK_BLOCK] RTI_ROW;
    f->lanes->camera(f, g, whole && b < w->camera_blocks, &w->pixels, t, p, h, px, py);
    if (f->lens_varies)
        emit_varying(f, t, p, px, py);
    if (whole) {
        w->camera_blocks += w->camera_blocks == b;
        return count;
    }
    w->camera_blocks = w->camera_blocks < b ? w->camera_blocks : b;
    head = head < count ? head : count;
    copy_rays(&w->batch, at, t, p, h->home, 0, head);
    if (head < count)
        copy_rays(&w->batch, at + head, t, p, h->home, head, count - head);
    return count;
}

uint32_t rti_make_camera_rays(rti_worker *worker, uint32_t room)
{
    uint32_t count = 0;
    while (count + RTK_BLOCK <= room) {
        rti_pixel_group group;
        uint32_t made;
        if (worker->slot == RTK_INVALID && !open_tile(worker))
            break;
        group = group_at(worker);
        made = emit(worker, &group, count);
        worker->slots[worker->slot].live += made;
        worker->counts.rays[RTK_KIND_CAMERA] += made;
        count += made;
        advance(worker);
    }
    return count;
}
