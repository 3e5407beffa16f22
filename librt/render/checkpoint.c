/* Checkpoint files: the key and writing. */
#include <string.h>

#include "checkpoint.h"
#include "checkpoint_file.h"
#include "image.h"

static uint64_t float_bits(float x)
{
    return rtk_bits(x);
}

void rti_check_key_of(rti_check_key *key, const rti_snapshot *snapshot, const rti_settings *set)
{
    const rt_render_desc *d = &set->desc;
    rti_hash scene = rti_snapshot_hash(snapshot);
    uint64_t *v = key->value;
    memset(key, 0, sizeof *key);
    snprintf(key->version, sizeof key->version, "%s", rt_version());
    snprintf(key->integrator, sizeof key->integrator, "%s", set->integrator->name);
    if (set->integrator->flags & RTI_INTEGRATOR_STEPS)
        snprintf(key->tracer, sizeof key->tracer, "%s", set->tracer->name);
    v[RTI_KEY_SCENE_LO] = scene.lo;
    v[RTI_KEY_SCENE_HI] = scene.hi;
    v[RTI_KEY_WIDTH] = d->width;
    v[RTI_KEY_HEIGHT] = d->height;
    v[RTI_KEY_SAMPLES] = set->samples;
    v[RTI_KEY_SEED] = d->seed;
    v[RTI_KEY_DEPTH] = d->max_depth;
    v[RTI_KEY_FILTER] = (uint64_t)d->filter;
    v[RTI_KEY_FILTER_WIDTH] = float_bits(d->filter_width);
    v[RTI_KEY_SHADOWS] = d->shadows != 0;
    v[RTI_KEY_SHADOW_SAMPLES] = d->shadow_samples;
    v[RTI_KEY_OPAQUE_SHADOWS] = d->opaque_shadows != 0;
    v[RTI_KEY_AO_SAMPLES] = d->ao_samples;
    v[RTI_KEY_AO_DISTANCE] = float_bits(d->ao_distance);
    v[RTI_KEY_CROP_X] = d->crop.x;
    v[RTI_KEY_CROP_Y] = d->crop.y;
    v[RTI_KEY_CROP_WIDTH] = d->crop.width;
    v[RTI_KEY_CROP_HEIGHT] = d->crop.height;
    v[RTI_KEY_ROULETTE] = set->roulette_from;
}

static const char *const names[RTI_KEY_COUNT] = {"scene",          "scene",          "width",       "height",       "samples",
                                                 "seed",           "max_depth",      "filter",      "filter_width", "shadows",
                                                 "shadow_samples", "opaque_shadows", "ao_samples",  "ao_distance",  "crop.x",
                                                 "crop.y",         "crop.width",     "crop.height", "roulette_from"};

static rt_status other_word(rt_context *ctx, const char *name, const char *what, const char *file, const char *job, size_t size)
{
    char there[80];
    return rti_fail(ctx, RT_ERROR_STATE, "%s: this checkpoint is of %s '%s', this render of '%s'; remove it or name another file",
                    name, what, rti_quote(there, sizeof there, file, strnlen(file, size)), job);
}

rt_status rti_check_key_compare(rt_context *ctx, const char *name, const rti_check_key *file, const rti_check_key *job)
{
    if (memcmp(file->version, job->version, sizeof job->version) != 0)
        return other_word(ctx, name, "librt", file->version, job->version, sizeof file->version);
    if (file->value[RTI_KEY_SCENE_LO] != job->value[RTI_KEY_SCENE_LO] ||
        file->value[RTI_KEY_SCENE_HI] != job->value[RTI_KEY_SCENE_HI])
        return rti_fail(ctx, RT_ERROR_STATE,
                        "%s: this checkpoint is of another scene (its content differs); remove it or name another file", name);
    if (memcmp(file->integrator, job->integrator, sizeof job->integrator) != 0)
        return other_word(ctx, name, "integrator", file->integrator, job->integrator, sizeof file->integrator);
    if (memcmp(file->tracer, job->tracer, sizeof job->tracer) != 0)
        return other_word(ctx, name, "tracer", file->tracer, job->tracer, sizeof file->tracer);
    for (uint32_t i = RTI_KEY_WIDTH; i < RTI_KEY_COUNT; i++) {
        char a[32], b[32];
        bool number = i == RTI_KEY_FILTER_WIDTH || i == RTI_KEY_AO_DISTANCE;
        if (file->value[i] == job->value[i])
            continue;
        snprintf(a, sizeof a, "%llu", (unsigned long long)file->value[i]);
        snprintf(b, sizeof b, "%llu", (unsigned long long)job->value[i]);
        return rti_fail(ctx, RT_ERROR_STATE,
                        "%s: this checkpoint is of another render: %s is %s there and %s here; remove it or name another file",
                        name, names[i], number ? rti_num(a, rtk_float((uint32_t)file->value[i])) : a,
                        number ? rti_num(b, rtk_float((uint32_t)job->value[i])) : b);
    }
    return RT_OK;
}

/* ---- sizes ---- */

static uint64_t pixels_of(const rti_frame *frame, uint32_t tile)
{
    rt_tile t = rti_frame_tile(frame, tile);
    return (uint64_t)t.width * t.height;
}

size_t rti_check_film_bytes(const rti_frame *frame, uint32_t tile)
{
    return (size_t)(pixels_of(frame, tile) * RTK_FILM_CHANNELS * sizeof(uint64_t)); /* the worker's own film is as large */
}

uint64_t rti_check_tile_bytes(const rti_frame *frame, uint32_t tile)
{
    return pixels_of(frame, tile) * 4 * sizeof(float);
}

/* ---- writing ---- */

typedef struct sink {
    rti_writer *out;
    rti_hasher hasher;
} sink;

static void put(sink *s, const void *data, size_t size)
{
    rti_hasher_add(&s->hasher, data, size);
    rti_writer_write(s->out, data, size);
}

static void put_tile(sink *s, const rti_frame *frame, uint32_t index)
{
    rt_tile t = rti_frame_tile(frame, index);
    const rt_tile *crop = &frame->set.desc.crop;
    for (uint32_t y = 0; y < t.height; y++)
        put(s, rti_image_row(frame->image, t.y - crop->y + y) + (size_t)(t.x - crop->x) * 4, (size_t)t.width * 4 * sizeof(float));
}

rt_status rti_check_write(const rti_place *place, const rti_frame *frame, rti_check_head *head, const uint32_t *done,
                          const rti_check_partial *partials)
{
    sink s;
    rti_hash hash;
    rt_status status = rti_place_write(place, &s.out);
    if (status != RT_OK)
        return status;
    memcpy(head->magic, RTI_CHECK_MAGIC, sizeof head->magic);
    head->order = RTI_CHECK_ORDER;
    head->head_size = sizeof *head;
    head->tile = frame->set.desc.tile;
    head->pad = 0;
    head->file_size = sizeof *head + (uint64_t)head->done_count * sizeof *done + sizeof hash;
    for (uint32_t i = 0; i < head->done_count; i++)
        head->file_size += rti_check_tile_bytes(frame, done[i]);
    for (uint32_t i = 0; i < head->partial_count; i++)
        head->file_size += RTI_CHECK_PARTIAL_HEAD + rti_check_film_bytes(frame, partials[i].tile);
    rti_hasher_init(&s.hasher);
    put(&s, head, sizeof *head);
    put(&s, done, head->done_count * sizeof *done);
    for (uint32_t i = 0; i < head->done_count; i++)
        put_tile(&s, frame, done[i]);
    for (uint32_t i = 0; i < head->partial_count; i++) {
        put(&s, &partials[i], RTI_CHECK_PARTIAL_HEAD);
        put(&s, partials[i].film, rti_check_film_bytes(frame, partials[i].tile));
    }
    hash = rti_hasher_end(&s.hasher);
    status = rti_writer_write(s.out, &hash, sizeof hash);
    rt_status closed = rti_writer_close(s.out, status == RT_OK);
    return status != RT_OK ? status : closed;
}
