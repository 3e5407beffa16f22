/* The render descriptor: defaults, checks with a sentence each. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "frame.h"
#include "image.h"

#define SHADOW_SAMPLES_MAX 4096u
#define FILTER_WIDTH_MAX   16.0f
#define MANY_SAMPLES       16u /* from so many samples a pixel on, one shadow ray a hit is enough */

rt_render_desc rt_render_desc_default(void)
{
    rt_render_desc d;
    memset(&d, 0, sizeof d);
    d.struct_size = sizeof d;
    d.width = 640;
    d.height = 480;
    d.samples = 1;
    d.tile = 32;
    d.schedule = RT_SCHEDULE_DYNAMIC;
    d.integrator = "whitted";
    d.tracer = "auto";
    d.max_depth = 8;
    d.filter = RT_FILTER_BOX;
    d.shadows = 1;
    return d;
}

static rt_status out_of_range(rt_context *ctx, const char *what, const char *field, uint32_t value, uint32_t low, uint32_t high)
{
    return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: %s is %u; it must be %u ... %u", what, field, value, low, high);
}

static rt_status check_counts(rt_context *ctx, const char *what, const rt_render_desc *d)
{
    if ((uint64_t)d->width * d->height > UINT32_MAX)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: %u x %u is %llu pixels; an image has at most %lu", what, d->width, d->height,
                        (unsigned long long)d->width * d->height, (unsigned long)UINT32_MAX);
    if (d->samples < 1 || d->samples > 65536)
        return out_of_range(ctx, what, "samples", d->samples, 1, 65536);
    if (d->workers > 1024)
        return out_of_range(ctx, what, "workers", d->workers, 0, 1024);
    if (d->tile < 1 || d->tile > 4096)
        return out_of_range(ctx, what, "tile", d->tile, 1, 4096);
    if (d->max_depth > 64)
        return out_of_range(ctx, what, "max_depth", d->max_depth, 0, 64);
    if (d->shadow_samples > SHADOW_SAMPLES_MAX)
        return out_of_range(ctx, what, "shadow_samples", d->shadow_samples, 0, SHADOW_SAMPLES_MAX);
    if (d->ao_samples > SHADOW_SAMPLES_MAX)
        return out_of_range(ctx, what, "ao_samples", d->ao_samples, 0, SHADOW_SAMPLES_MAX);
    return RT_OK;
}

static rt_status check_choices(rt_context *ctx, const char *what, const rt_render_desc *d)
{
    char number[32];
    if (d->schedule != RT_SCHEDULE_DYNAMIC && d->schedule != RT_SCHEDULE_STATIC)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: schedule is %d; it must be RT_SCHEDULE_DYNAMIC or RT_SCHEDULE_STATIC", what,
                        (int)d->schedule);
    if (d->filter != RT_FILTER_BOX && d->filter != RT_FILTER_GAUSSIAN)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: filter is %d; it must be RT_FILTER_BOX or RT_FILTER_GAUSSIAN", what,
                        (int)d->filter);
    if (!(d->filter_width >= 0.0f && d->filter_width <= FILTER_WIDTH_MAX))
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: filter_width is %s; it must be 0 ... 16 pixels", what,
                        rti_num(number, d->filter_width));
    if (!(d->checkpoint_every >= 0 && d->checkpoint_every <= 1e9))
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: checkpoint_every is %s; it must be 0 ... 1e9 seconds", what,
                        rti_num(number, (float)d->checkpoint_every));
    if (d->checkpoint && (!*d->checkpoint || strcmp(d->checkpoint, "-") == 0))
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: checkpoint is \"%s\"; it must be the name of a file", what, d->checkpoint);
    if (isnan(d->ao_distance))
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: ao_distance is not a number", what);
    return RT_OK;
}

static rt_status check_crop(rt_context *ctx, const char *what, rt_render_desc *d)
{
    rt_tile *c = &d->crop;
    size_t row;
    if (c->width == 0) {
        rt_tile all = {0, 0, d->width, d->height};
        *c = all;
    }
    if (c->height == 0 || c->x >= d->width || c->y >= d->height || c->width > d->width - c->x || c->height > d->height - c->y)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: the crop of %u x %u pixels at (%u, %u) does not lie in the image of %u x %u",
                        what, c->width, c->height, c->x, c->y, d->width, d->height);
    row = (size_t)c->width * 4 * sizeof(float);
    if (d->pixels_stride == 0)
        d->pixels_stride = row;
    if (d->pixels && (d->pixels_stride < row || d->pixels_stride % sizeof(float) != 0))
        return rti_fail(ctx, RT_ERROR_ARGUMENT,
                        "%s: pixels_stride is %zu bytes; a row of %u pixels needs at least %zu, and a multiple of 4", what,
                        d->pixels_stride, c->width, row);
    return RT_OK;
}

/* Names of a table, for a message: "a, b, c". */
static void list_names(char *text, size_t size, const char *(*name_at)(uint32_t index, const char **help))
{
    size_t used = 0;
    text[0] = '\0';
    for (uint32_t i = 0; name_at(i, NULL) && used < size; i++)
        used += (size_t)snprintf(text + used, size - used, "%s%s", i ? ", " : "", name_at(i, NULL));
}

static rt_status unknown_name(rt_context *ctx, const char *what, const char *field, const char *name,
                              const char *(*name_at)(uint32_t index, const char **help))
{
    char names[256], quoted[96];
    if (!name)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: %s is NULL", what, field);
    list_names(names, sizeof names, name_at);
    return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: there is no %s \"%s\"; there are %s", what, field,
                    rti_quote(quoted, sizeof quoted, name, strlen(name)), names);
}

static void fill_defaults(rt_context *ctx, rti_settings *s)
{
    rt_render_desc *d = &s->desc;
    uint32_t few = s->samples >= MANY_SAMPLES ? 1 : MANY_SAMPLES;
    if (d->workers == 0)
        d->workers = rt_context_workers(ctx);
    if (d->filter_width == 0.0f)
        d->filter_width = d->filter == RT_FILTER_GAUSSIAN ? 2.0f : 1.0f;
    if (d->shadow_samples == 0)
        d->shadow_samples = few;
    if (d->ao_samples == 0)
        d->ao_samples = few;
}

rt_status rti_settings_take(rt_context *ctx, const char *what, const rti_snapshot *snapshot, const rt_render_desc *desc,
                            rti_settings *out)
{
    rt_render_desc *d = &out->desc;
    rt_status status;
    *d = rt_render_desc_default();
    status = rti_desc_take(ctx, what, desc, d, sizeof *d);
    if (status == RT_OK)
        status = rti_image_check_size(ctx, what, d->width, d->height);
    if (status == RT_OK)
        status = check_counts(ctx, what, d);
    if (status == RT_OK)
        status = check_choices(ctx, what, d);
    if (status == RT_OK)
        status = check_crop(ctx, what, d);
    if (status != RT_OK)
        return status;
    out->integrator = d->integrator ? rti_integrator_find(d->integrator) : NULL;
    if (!out->integrator)
        return unknown_name(ctx, what, "integrator", d->integrator, rt_integrator_at);
    if (d->tracer && strcmp(d->tracer, "auto") == 0)
        out->tracer = rti_snapshot_tracer(snapshot);
    else
        out->tracer = d->tracer ? rti_tracer_find(rti_context_isa(ctx), d->tracer) : NULL;
    if (!out->tracer)
        return unknown_name(ctx, what, "tracer", d->tracer, rt_tracer_at);
    out->samples = out->integrator->flags & RTI_INTEGRATOR_RAW ? 1 : d->samples;
    out->roulette_from = 3;
    fill_defaults(ctx, out);
    d->integrator = NULL; /* the caller's strings are not kept */
    d->tracer = NULL;
    return RT_OK;
}
