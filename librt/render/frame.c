/* The numbers of a frame: sizes of queues, tiles, the film's unit. */
#include <math.h>

#include "frame.h"
#include "lanes.h"
#include "shade_limits.h"

#define BATCH_MAX   2048u
#define SHADOW_MAX  2048u
#define SCATTERED   16384u  /* of both, where rays have little in common: their streams are the better the more there are */
#define STEP_RAYS   131072u /* shadow rays a step may cast: about 20 ms of work, so that a job can be polled and cancelled */
#define SLOT_PIXELS 131072u /* pixels of film a worker keeps for tiles in work, unless one tile is larger */
#define SLOT_MAX    256u
#define COARSEST    16 /* the unit is never coarser than 2^-28 times 2^this */

rt_tile rti_frame_tile(const rti_frame *frame, uint32_t index)
{
    const rt_tile *crop = &frame->set.desc.crop;
    uint32_t edge = frame->set.desc.tile, x = index % frame->tile_columns * edge, y = index / frame->tile_columns * edge;
    rt_tile t = {crop->x + x, crop->y + y, edge, edge};
    if (t.width > crop->width - x)
        t.width = crop->width - x;
    if (t.height > crop->height - y)
        t.height = crop->height - y;
    return t;
}

float rti_frame_time(const rti_frame *frame, uint32_t pixel, uint32_t sample)
{
    float u = 0.5f;
    if (!(frame->set.integrator->flags & RTI_INTEGRATOR_RAW))
        u = rtk_random(rtk_vertex_seed(frame->seed, pixel, rtk_key_root()), sample, RTK_DIM_TIME);
    return rtk_shutter_time(&frame->scene->world->camera, u);
}

uint32_t rti_frame_light_samples(const rti_frame *frame, const rtk_light *light)
{
    if (light->type != RTK_LIGHT_SPHERE)
        return 1;
    return light->samples ? light->samples : frame->set.desc.shadow_samples;
}

/* Shadow rays of one hit. */
static double shadow_rays(const rti_frame *f)
{
    double n = 0;
    if (f->set.integrator->flags & RTI_INTEGRATOR_AO)
        return f->set.desc.ao_samples;
    if (!(f->set.integrator->flags & RTI_INTEGRATOR_SHADOWS) || f->scene->light_count == 0)
        return 0;
    if (f->set.integrator->branching < 2)
        return 1; /* path: one light a hit */
    for (uint32_t i = 0; i < f->scene->light_count; i++)
        n += rti_frame_light_samples(f, &f->scene->lights[i]);
    return n;
}

/* At most so many rays come of one camera ray. A material that both mirrors and refracts doubles them, but what a ray keeps
 * shrinks by its weights, and a ray below RTI_THROUGHPUT_MIN is not followed. */
static double rays_of_one(const rti_frame *f)
{
    double rays = 1, splits = 1, kept = 1, growth = 0;
    if (f->set.integrator->branching == 0)
        return 1;
    for (uint32_t i = 0; f->set.integrator->branching == 2 && i < f->scene->material_count; i++) {
        const rtk_material *m = &f->scene->materials[i];
        if (m->reflectiveness > 0.0f && m->transparency > 0.0f)
            growth = fmax(growth, (double)m->reflectiveness + m->transparency);
    }
    for (uint32_t d = 1; d <= f->set.desc.max_depth; d++) {
        splits *= growth > 0 ? 2 : 1;
        kept *= growth;
        rays += growth > 0 ? fmin(splits, fmax(1, kept / RTI_THROUGHPUT_MIN)) : 1;
    }
    return rays;
}

/* Chooses the film's unit so that no sum can leave 63 bits: contributions times 2^13 in units of 2^-28, or of a coarser power. */
static rt_status choose_unit(rt_context *ctx, const char *what, rti_frame *f)
{
    double contributions = (double)f->set.samples * rays_of_one(f) * (2 + shadow_rays(f));
    int excess = (int)ceil(log2(contributions)) + 13 + 28 - 62;
    if (excess > COARSEST)
        return rti_fail(
            ctx, RT_ERROR_ARGUMENT,
            "%s: %u samples with max_depth %u and %u lights could make %.3g contributions to one pixel, more than the "
            "film can add up; lower max_depth or samples",
            what, f->set.samples, f->set.desc.max_depth, f->scene->light_count, contributions);
    excess = excess > 0 ? excess : 0;
    f->film_scale = (float)ldexp(1.0, 28 - excess);
    f->film_unit = ldexp(1.0, excess - 28);
    return RT_OK;
}

static void choose_tiles(rti_frame *f)
{
    const rt_tile *crop = &f->set.desc.crop;
    uint32_t edge = f->set.desc.tile, w = edge < crop->width ? edge : crop->width, h = edge < crop->height ? edge : crop->height;
    f->tile_columns = (crop->width + edge - 1) / edge;
    f->tile_count = f->tile_columns * ((crop->height + edge - 1) / edge);
    f->slot_shift = 0;
    while (((uint64_t)1 << f->slot_shift) < (uint64_t)w * h)
        f->slot_shift++;
    f->slot_count = SLOT_PIXELS >> f->slot_shift;
    if (f->slot_count < 1)
        f->slot_count = 1;
    if (f->slot_count > SLOT_MAX)
        f->slot_count = SLOT_MAX;
    if (f->slot_count > f->tile_count)
        f->slot_count = f->tile_count;
}

static bool scatters(const rti_frame *f)
{
    return f->set.integrator->flags & RTI_INTEGRATOR_SCATTERS && !f->thrifty;
}

/* Rays that scatter share more the more they are, but each worker is to have some batches. */
static uint32_t batch_of(const rti_frame *f, double cameras)
{
    const double share = cameras / (4.0 * f->set.desc.workers);
    if (!scatters(f) || !(share > BATCH_MAX))
        return BATCH_MAX;
    return share < SCATTERED ? (uint32_t)share / RTK_BLOCK * RTK_BLOCK : SCATTERED;
}

rt_status rti_frame_plan(rt_context *ctx, const char *what, rti_frame *frame, const rtk_scene *scene)
{
    double per_hit, cameras;
    frame->scene = scene;
    frame->lanes = rti_lanes_find(rti_context_isa(ctx));
    frame->roomy = rti_context_roomy(ctx);
    frame->seed = rtk_hash2((uint32_t)frame->set.desc.seed, (uint32_t)(frame->set.desc.seed >> 32));
    per_hit = shadow_rays(frame);
    frame->lens = rtk_lens_make(&scene->world->camera, frame->set.desc.width, frame->set.desc.height);
    frame->lens_varies = frame->lens.radius > 0.0f || scene->world->camera.flags & RTK_CAMERA_MOVING;
    frame->moving = scene->flags & RTK_SCENE_MOVING;
    frame->asks_through = !frame->set.desc.shadows || (scene->flags & RTK_SCENE_TRANSPARENT && !frame->set.desc.opaque_shadows);
    cameras = (double)frame->set.desc.crop.width * frame->set.desc.crop.height * frame->set.samples;
    frame->batch = batch_of(frame, cameras);
    if (per_hit * BATCH_MAX > STEP_RAYS)
        frame->batch = (uint32_t)(STEP_RAYS / per_hit) / RTK_BLOCK * RTK_BLOCK;
    if (cameras < frame->batch) /* a small picture takes little memory: clearing pages may cost more than its rays */
        frame->batch = ((uint32_t)cameras + RTK_BLOCK - 1) / RTK_BLOCK * RTK_BLOCK;
    if (frame->batch < RTK_BLOCK)
        frame->batch = RTK_BLOCK;
    frame->shadow_rays = scatters(frame) ? SCATTERED : SHADOW_MAX;
    frame->stack_rays = (frame->batch + RTK_BLOCK) *
                        (frame->set.integrator->branching < 2 ? frame->set.integrator->branching : frame->set.desc.max_depth + 1);
    choose_tiles(frame);
    return choose_unit(ctx, what, frame);
}
