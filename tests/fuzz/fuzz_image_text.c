#include "fuzz_model.h"

#include <string.h>

#include "render/image_text.h"

static int take(void *user, const char *key, const char *value)
{
    size_t *sum = user;
    if (key[0] == '\0')
        abort();
    *sum += strlen(key) + strlen(value); /* a sanitizer sees here what was never written, or has no end */
    return *sum > 1u << 20;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    rt_context *ctx = fuzz_context();
    uint8_t *out = NULL;
    size_t sum = 0, length = 0, capacity = 0;
    uint64_t now = 0;
    rti_texts_decode(ctx, "fuzz", data, size, false, take, &sum);
    if (rti_inflate(ctx, data, size, 1u << 20, &out, &length, &capacity) == NULL) {
        if (length > 1u << 20 || length >= capacity || out[length] != 0)
            abort();
        rti_free(ctx, out, capacity);
    }
    rt_context_memory(ctx, &now, NULL);
    if (now != 0)
        abort();
    return 0;
}
