/* What all workers of a job read: the checked settings, the scene and the numbers made from them. Nothing here changes while rays
 * fly. */
#ifndef RTI_FRAME_H
#define RTI_FRAME_H

#include "../base/base.h"
#include "../kernel/camera.h"
#include "../kernel/rng.h"
#include "../scene/snapshot.h"
#include "../trace/trace.h"
#include "librt/render.h"

struct rti_worker;
typedef struct rti_lanes rti_lanes;

/* An integrator is one file and one row of integrate.def. shade gets the hits of batch rays [first, first + count), first a
 * multiple of RTK_BLOCK, in the order of their depth, and must push new rays in the order of their parents (wavefront.h). */
#define RTI_INTEGRATOR_SHADOWS  1u /* casts shadow rays to the scene's lights */
#define RTI_INTEGRATOR_STEPS    2u /* wants the tracer's steps */
#define RTI_INTEGRATOR_RAW      4u /* shows values, not light: one sample, and the film keeps the floats as they are */
#define RTI_INTEGRATOR_AO       8u
#define RTI_INTEGRATOR_SCATTERS 16u /* most rays are of bounces that have little in common */
typedef struct rti_integrator {
    const char *name, *help;
    uint32_t flags;
    uint32_t branching; /* rays that one ray may become: 0, 1 or 2 */
    void (*shade)(struct rti_worker *worker, uint32_t first, uint32_t count);
    void (*light)(struct rti_worker *worker); /* what the lit points of a step do then (direct.h); NULL: there are none */
} rti_integrator;
const rti_integrator *rti_integrator_find(const char *name);

/* The descriptor after all checks, with its defaults resolved. */
typedef struct rti_settings {
    rt_render_desc desc; /* workers, crop and shadow samples are final; names are not kept */
    const rti_integrator *integrator;
    const rti_tracer *tracer;
    uint32_t samples;       /* 1 for RAW integrators */
    bool unseen;            /* nobody looks at the image before it is whole */
    uint32_t roulette_from; /* path: depth of the first ray that Russian roulette may end */
} rti_settings;
/* what: the public function, for messages. */
rt_status rti_settings_take(rt_context *ctx, const char *what, const rti_snapshot *snapshot, const rt_render_desc *desc,
                            rti_settings *out);

typedef struct rti_frame {
    rti_settings set;
    const rtk_scene *scene;
    const rti_lanes *lanes; /* of the context's instruction set */
    rtk_lens lens;          /* at time 0 */
    bool lens_varies;       /* rays start on a lens, or the camera moves */
    bool moving;            /* instances move: every ray has a time */
    bool asks_through;      /* shadow rays go through bodies which other rays are bent by or end at (lanes_path.c) */
    uint32_t tile_columns, tile_count;
    bool roomy;          /* rti_context_roomy */
    bool thrifty;        /* queues as short as may be, where memory is limited */
    uint32_t batch;      /* rays a worker traces at once, a multiple of RTK_BLOCK */
    uint32_t stack_rays; /* room for waiting rays: the bound proved in wavefront.h */
    uint32_t shadow_rays;
    uint32_t slot_shift; /* a slot's film has 1 << slot_shift pixels */
    uint32_t slot_count;
    uint32_t seed;    /* of all random numbers: the descriptor's, folded */
    float film_scale; /* 1 / unit of the film */
    double film_unit;
    float ao_distance;
    const uint32_t
        *light_of_geom; /* the spherical light whose body a geometry of group 0 is, or RTK_INVALID; NULL: no such light */
    rt_image *image;
    rti_cancel *cancel;
} rti_frame;

/* The numbers that follow from settings and scene. Fails when sums could pass the film's range in any allowed unit. */
rt_status rti_frame_plan(rt_context *ctx, const char *what, rti_frame *frame, const rtk_scene *scene);
/* Time of all rays of a sample: it is derived, never stored in a ray's state. A RAW integrator's one sample takes the middle of
 * the shutter's time, and of the lens. */
float rti_frame_time(const rti_frame *frame, uint32_t pixel, uint32_t sample);
/* Pixels of tile `index`, in the whole image. */
rt_tile rti_frame_tile(const rti_frame *frame, uint32_t index);
/* Shadow rays that one point sends to light `light`. */
uint32_t rti_frame_light_samples(const rti_frame *frame, const rtk_light *light);

#endif
