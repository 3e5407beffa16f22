/* The wavefront: one worker's rays, from the camera to the film.
 *
 * A step makes a batch (camera rays as far as the waiting ones do not fill it), lets the tracer answer it, and shades: every hit
 * becomes contributions, shadow rays and new rays. New rays wait on a stack that is sorted by depth, deepest on top, because a
 * batch is shaded in the order of its depths and takes everything from the top.
 *
 * Bound of the stack. Let B be the batch, D max_depth, and every ray become at most 2. A batch that takes rays of depth m takes
 * all deeper ones, so right after it at most 2B rays are deeper than m. Before the next one that is not yet worked down, either
 * these are all, or depth m+1 has been touched; then at most B + 15 rays of it are left (had there been r deeper ones, at most 2B
 * - r were of depth m+1, and the batch, full to the last block, took B - 15 - r of them). So with X(m) rays of depth >= m, X(m)
 * <= max(2B, B + 15 + X(m+1)) and X(D) <= 2B: in all at most (B + 16)(D + 1). Camera rays never wait.
 */
#ifndef RTI_WAVEFRONT_H
#define RTI_WAVEFRONT_H

#include "../kernel/blocks.h"
#include "../kernel/film.h"
#include "frame.h"

/* Where a ray's light goes: index in the worker's film, (slot << slot_shift) + pixel of the tile. */
typedef struct rti_home_block {
    uint32_t home[RTK_BLOCK];
} rti_home_block;

typedef struct rti_rays {
    rtk_trace_block *trace;
    rtk_path_block *path;
    rti_home_block *home;
    uint32_t count, capacity;
} rti_rays;

/* Shadow rays with what they bring to the film if nothing is in their way. */
typedef struct rti_pending_block {
    float r[RTK_BLOCK], g[RTK_BLOCK], b[RTK_BLOCK];
    uint32_t home[RTK_BLOCK];
} rti_pending_block;

#define RTI_LIGHT_MIXED 0xfffffffeu
typedef struct rti_shadows {
    rtk_trace_block *trace;
    rti_pending_block *pending;
    rtk_hit_block *hits; /* of tinted shadows */
    uint16_t *occluded;
    float *times; /* in scenes with motion */
    uint32_t count, capacity;
    uint32_t light; /* the light all of them go to, RTK_INVALID (none yet) or RTI_LIGHT_MIXED */
} rti_shadows;

/* Points that lights shine on, in rows of lit_stride: a row may be written sixteen at a time from any place. k: throughput *
 * diffusion * colour, s: throughput * specular. v: towards the viewer; n, g: shading and geometric normal on the viewer's side.
 */
enum {
    RTI_LIT_PX,
    RTI_LIT_PY,
    RTI_LIT_PZ,
    RTI_LIT_ERROR,
    RTI_LIT_GX,
    RTI_LIT_GY,
    RTI_LIT_GZ,
    RTI_LIT_NX,
    RTI_LIT_NY,
    RTI_LIT_NZ,
    RTI_LIT_VX,
    RTI_LIT_VY,
    RTI_LIT_VZ,
    RTI_LIT_KR,
    RTI_LIT_KG,
    RTI_LIT_KB,
    RTI_LIT_SR,
    RTI_LIT_SG,
    RTI_LIT_SB,
    RTI_LIT_SHININESS,
    RTI_LIT_DIFFUSE_PDF, /* path: probability of going on by the diffuse lobe (for multiple importance) */
    RTI_LIT_ROWS
};

typedef struct rti_slot {
    rt_tile tile;
    uint32_t index;
    uint32_t live;   /* rays of it that wait */
    bool used, made; /* made: all its camera rays have been sent */
} rti_slot;

typedef struct rti_worker_counts {
    uint64_t rays[RTK_KIND_COUNT];
    uint64_t clamped, dropped;
    uint32_t tiles;
} rti_worker_counts;

/* Seeds of two neighbouring dimensions at a vertex of each lane (rng.h), for all its samples. */
typedef struct rti_pair_seeds {
    uint32_t order[RTK_BLOCK], first[RTK_BLOCK], second[RTK_BLOCK];
} rti_pair_seeds;

/* Those of where camera rays pass a group's pixels: what its samples share. columns: by which lanes are pixels; 0 where there are
 * none yet. */
typedef struct rti_pixel_seeds {
    uint32_t x, y, columns;
    rti_pair_seeds pair;
} rti_pixel_seeds;

typedef struct rti_worker {
    const rti_frame *frame;
    rti_rays stack, batch;
    rtk_hit_block *hits;
    float *times; /* of the batch's rays, in scenes with motion: made from (pixel, sample) for each batch anew */
    rti_steps *steps;
    rti_shadows shadows;
    float *lit;         /* [RTI_LIT_ROWS * lit_stride] */
    uint32_t *lit_ray;  /* index in the batch: its pixel, sample, key */
    uint32_t *lit_home; /* where its light goes */
    uint32_t lit_count, lit_stride;
    bool lit_shiny;    /* some point has highlights: only then rows SR to SB tell anything, VX to VZ and SHININESS of such points */
    bool lit_smooth;   /* some point has a shading normal of its own: only then rows NX to NZ tell anything */
    uint32_t lit_most; /* where there may not be room for another block below this, lights shine before the end of the step */
    uint8_t *keys;     /* for shading in lanes: kind of each hit of a depth; then their order; and each hit's material */
    uint32_t *order, *materials;
    uint64_t *film;
    uint32_t *touched; /* a bit for each material that shading has looked at */
    rti_slot *slots;
    rti_scratch scratch;
    rti_worker_counts counts;

    uint32_t camera_blocks; /* of the batch, the first: what all camera rays share stands there */

    /* Where the making of camera rays stands. */
    uint32_t slot; /* RTK_INVALID: no tile open */
    uint32_t group_x, group_y, sample;
    rti_pixel_seeds pixels;
    bool no_more_tiles;
    bool hold; /* no camera rays for now: the waiting ones are worked down, until a step finds nothing to do */

    /* Next tile or RTK_INVALID; a tile whose pixels stand in the image. */
    uint32_t (*next_tile)(void *owner);
    void (*tile_done)(void *owner, uint32_t index);
    /* A tile is opened, its film cleared: puts in what an earlier run added, and sets where the camera rays go on. NULL: none. */
    void (*restore)(void *owner, uint32_t index, uint64_t *film);
    void *owner;
} rti_worker;

/* One block of memory holds all of a worker's queues. */
size_t rti_worker_size(const rti_frame *frame);
/* Before its first step, in the thread that takes it: much is cleared there, side by side with other workers. */
void rti_worker_init(rti_worker *worker, const rti_frame *frame, void *memory);
/* One batch. false: nothing is left to do, or the job was cancelled. */
bool rti_worker_step(rti_worker *worker);
/* Are a block's rays within about 25 degrees of the first? */
bool rti_block_alike(const rtk_trace_block *trace);

/* ---- for integrators ---- */

typedef struct rti_ray_state {
    rtk_vec3 tp;
    uint32_t pixel, sample, depth, kind, key_lo, key_hi;
    float eta, width, spread, pdf;
    uint32_t home;
} rti_ray_state;

static inline rtk_ray rti_batch_ray(const rti_worker *w, uint32_t i)
{
    const rtk_trace_block *b = &w->batch.trace[i / RTK_BLOCK];
    uint32_t k = i % RTK_BLOCK;
    rtk_ray r;
    r.org = rtk_v3(b->ox[k], b->oy[k], b->oz[k]);
    r.dir = rtk_v3(b->dx[k], b->dy[k], b->dz[k]);
    r.tmin = b->tmin[k];
    r.tmax = b->tmax[k];
    r.mask = b->mask[k];
    return r;
}

static inline rtk_hit rti_hit_at(const rtk_hit_block *hits, uint32_t i)
{
    const rtk_hit_block *b = &hits[i / RTK_BLOCK];
    uint32_t k = i % RTK_BLOCK;
    rtk_hit h;
    h.t = b->t[k];
    h.u = b->u[k];
    h.v = b->v[k];
    h.prim = b->prim[k];
    h.geom = b->geom[k];
    h.inst = b->inst[k];
    return h;
}

static inline rti_ray_state rti_batch_state(const rti_worker *w, uint32_t i)
{
    const rtk_path_block *b = &w->batch.path[i / RTK_BLOCK];
    uint32_t k = i % RTK_BLOCK;
    rti_ray_state s;
    s.tp = rtk_v3(b->tpr[k], b->tpg[k], b->tpb[k]);
    s.pixel = b->pixel[k];
    s.sample = b->sample[k];
    s.depth = b->depth_kind[k] & 0xffffu;
    s.kind = b->depth_kind[k] >> 16;
    s.key_lo = b->key_lo[k];
    s.key_hi = b->key_hi[k];
    s.eta = b->eta[k];
    s.width = b->width[k];
    s.spread = b->spread[k];
    s.pdf = b->pdf[k];
    s.home = w->batch.home[i / RTK_BLOCK].home[k];
    return s;
}

/* Time of ray i of the batch. */
static inline float rti_batch_time(const rti_worker *w, uint32_t i)
{
    return w->frame->moving ? w->times[i] : 0.0f;
}

static inline void rti_touch(rti_worker *w, uint32_t material)
{
    w->touched[material / 32] |= 1u << material % 32;
}

/* Adds light to the film. */
static inline void rti_add(rti_worker *w, uint32_t home, rtk_vec3 c)
{
    uint32_t what = rtk_film_add(w->film + (size_t)home * RTK_FILM_CHANNELS, c, w->frame->film_scale);
    if (what == RTK_FILM_CLAMPED)
        w->counts.clamped++;
    else if (what == RTK_FILM_DROPPED)
        w->counts.dropped++;
}

static inline void rti_cover(rti_worker *w, uint32_t home)
{
    w->film[(size_t)home * RTK_FILM_CHANNELS + 3]++;
}

/* A value of a RAW integrator: kept as floats. */
void rti_set_raw(rti_worker *worker, uint32_t home, rtk_vec3 value);

/* shadow.c. Queues a ray that brings c to the film unless something is between tmin = 0 and tmax; flushes when full. light:
 * index, to know which rays go to one point. */
void rti_shadow(rti_worker *worker, uint32_t light, rtk_vec3 org, rtk_vec3 dir, float tmax, rtk_vec3 c, uint32_t home,
                float time);
void rti_shadow_flush(rti_worker *worker);

#endif
