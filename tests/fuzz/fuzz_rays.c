/* Files of rays (tests/bench/rays). The hash is put right first, so that what stands behind it is reached. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rays.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void look(const uint8_t *data, size_t size)
{
    bench_rays rays;
    char why[200] = "";
    if (!bench_rays_parse(data, size, &rays, why, sizeof why)) {
        if (!why[0] || rays.rays)
            abort();
        return;
    }
    if (size != 128 + 32 * rays.count || !rays.set[0] || !rays.scene[0] || strlen(rays.set) >= sizeof rays.set)
        abort();
    for (size_t i = 0; i < rays.count; i++)
        if (!isfinite(rays.rays[i].org.x) || !isfinite(rays.rays[i].dir.z) || isnan(rays.rays[i].tmax))
            abort();
    bench_rays_free(&rays);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    uint8_t *copy = malloc(size + 1);
    if (!copy)
        return 0;
    memcpy(copy, data, size);
    look(copy, size);
    for (int i = 0; i < 8 && size >= 128; i++)
        copy[40 + i] = (uint8_t)(bench_rays_hash(copy + 128, size - 128) >> (8 * i));
    look(copy, size);
    free(copy);
    return 0;
}
