/* One context for all inputs of a target, with a limit that an input cannot pass. */
#ifndef FUZZ_MODEL_H
#define FUZZ_MODEL_H

#include <stdlib.h>

#include "scene/import/model.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static inline rt_context *fuzz_context(void)
{
    static rt_context *ctx;
    if (!ctx) {
        rt_context_desc d = rt_context_desc_default();
        d.workers = 1;
        d.memory_limit = (uint64_t)256 << 20;
        if (rt_context_create(&d, &ctx) != RT_OK)
            abort();
    }
    return ctx;
}

/* What a reader lets through must hold, and nothing may stay allocated. */
static inline void fuzz_end(rti_model *model, rt_status status)
{
    uint64_t now = 0;
    rt_context *ctx = model->ctx;
    for (size_t i = 0; i < model->part_count && status == RT_OK; i++) {
        const rti_part *part = &model->parts[i];
        for (size_t k = 0; k < 3 * (size_t)part->triangle_count; k++)
            if (part->indices[k] >= part->vertex_count)
                abort();
        for (size_t k = 0; k < 3 * (size_t)part->vertex_count; k++)
            if (!(part->positions[k] - part->positions[k] == 0.0f))
                abort();
    }
    for (size_t i = 0; i < model->part_count && status == RT_OK; i++)
        rti_part_smooth(ctx, &model->parts[i], 60.0f);
    rti_model_fini(model);
    rt_context_memory(ctx, &now, NULL);
    if (now != 0)
        abort();
}

#endif
