#include "fuzz_model.h"
#include "scene/import/image_read.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    rt_context *ctx = fuzz_context();
    rti_pixels pixels;
    uint64_t now = 0, sum = 0;
    if (rti_image_decode(ctx, "fuzz", data, size, false, &pixels) == RT_OK) {
        size_t expected = (size_t)pixels.width * pixels.height * pixels.channels * (pixels.is_float ? 4 : 1);
        if (!pixels.data || pixels.size != expected || pixels.channels < 1 || pixels.channels > 4 || pixels.channels == 2)
            abort();
        for (size_t i = 0; i < pixels.size; i++) /* a memory sanitizer sees here what was never written */
            sum += ((const uint8_t *)pixels.data)[i];
        if (sum == 1)
            now = 1;
        rti_free(ctx, pixels.data, pixels.size);
    } else if (pixels.data) {
        abort();
    }
    rt_context_memory(ctx, &now, NULL);
    if (now != 0)
        abort();
    return 0;
}
