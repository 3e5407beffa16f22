/* PNG, JPEG and GIF through stb_image: the one file its implementation is compiled in. Callers have walked the file already
 * (image_check.c). stb asks for memory without saying for whom; so the calling thread notes the context for the time of one call,
 * which is the only thing it notes. Memory comes zeroed: whatever stb leaves unwritten is black, not the heap's last content. */
#include "image_formats.h"
#include "srgb.h"

#include <string.h>

#ifdef RTI_HAVE_STB

#include <limits.h>

typedef struct stb_block {
    size_t size;
    uint64_t pad; /* stb's SSE code wants 16-byte alignment */
} stb_block;

typedef struct stb_memory {
    rt_context *ctx;
    size_t refused; /* size of the request that was not met, 0: none */
} stb_memory;

static _Thread_local stb_memory *stb_caller;

static void *stb_resize(void *ptr, size_t new_size)
{
    stb_block *old = ptr ? (stb_block *)ptr - 1 : NULL;
    size_t total = new_size <= SIZE_MAX - sizeof(stb_block) ? new_size + sizeof(stb_block) : 0;
    stb_block *block = total ? rti_alloc_zero(stb_caller->ctx, total) : NULL;
    if (!block) {
        stb_caller->refused = new_size ? new_size : 1;
        return NULL;
    }
    block->size = total;
    if (old) {
        size_t kept = old->size < total ? old->size : total;
        memcpy(block + 1, ptr, kept - sizeof *block);
        rti_free(stb_caller->ctx, old, old->size);
    }
    return block + 1;
}

static void stb_release(void *ptr)
{
    if (ptr)
        rti_free(stb_caller->ctx, (stb_block *)ptr - 1, ((stb_block *)ptr - 1)->size);
}

#define STBI_MALLOC(size)       stb_resize(NULL, size)
#define STBI_REALLOC(ptr, size) stb_resize(ptr, size)
#define STBI_FREE(ptr)          stb_release(ptr)
#define STBI_ASSERT(x)          ((void)(x))
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_ONLY_GIF
#define STBI_NO_STDIO
#define STBI_NO_HDR
#define STBI_NO_LINEAR
#define STBI_MAX_DIMENSIONS 1048576
#define STBIDEF             static RTI_UNUSED
/* declared and never defined there; its neighbour has the same type */
#define stbi_set_unpremultiply_on_load_thread stbi_set_unpremultiply_on_load
#define STB_IMAGE_IMPLEMENTATION
#include <stb_image.h>

static rt_status fail(const rti_image_source *src, const char *kind)
{
    if (stb_caller->refused)
        return rti_fail_memory(src->ctx, src->name, stb_caller->refused);
    return rti_fail(src->ctx, RT_ERROR_FORMAT,
                    "%s: this %s file is damaged or of an unusual sort (%s); save it again, as a plain PNG", src->name, kind,
                    stbi_failure_reason() ? stbi_failure_reason() : "no reason given");
}

/* stb's samples to ours: grey with alpha becomes RGBA, 16 bits become linear floats. */
static rt_status take(const rti_image_source *src, const void *from, bool wide, int channels, rti_pixels *out)
{
    size_t count = (size_t)out->width * out->height;
    uint32_t to_channels = out->channels;
    if (!wide && (uint32_t)channels == to_channels) {
        memcpy(out->data, from, out->size);
        return RT_OK;
    }
    float *linear = NULL;
    if (wide) {
        linear = rti_alloc_array(src->ctx, 65536, sizeof *linear);
        if (!linear)
            return rti_fail_memory(src->ctx, src->name, 65536 * sizeof *linear);
        for (uint32_t v = 0; v < 65536; v++)
            linear[v] = (float)(src->linear ? v / 65535.0 : rti_srgb_decode(v / 65535.0));
    }
    for (size_t i = 0; i < count; i++) {
        for (uint32_t c = 0; c < to_channels; c++) {
            bool alpha = c == 3;
            size_t k = i * (size_t)channels + (channels == 2 ? alpha : c);
            if (!wide)
                ((uint8_t *)out->data)[i * to_channels + c] = ((const uint8_t *)from)[k];
            else
                ((float *)out->data)[i * to_channels + c] =
                    alpha ? (float)(((const uint16_t *)from)[k] / 65535.0) : linear[((const uint16_t *)from)[k]];
        }
    }
    rti_free(src->ctx, linear, linear ? 65536 * sizeof *linear : 0);
    return RT_OK;
}

static rt_status run(const rti_image_source *src, const char *kind, bool wide, rti_pixels *out)
{
    int w = 0, h = 0, channels = 0, length = (int)src->size;
    void *got = wide ? (void *)stbi_load_16_from_memory(src->bytes, length, &w, &h, &channels, 0)
                     : (void *)stbi_load_from_memory(src->bytes, length, &w, &h, &channels, 0);
    if (!got)
        return fail(src, kind);
    rt_status status;
    if (channels < 1 || channels > 4 || w < 1 || h < 1) /* stb says 0 channels for some damaged files it decodes none the less */
        status = rti_fail(src->ctx, RT_ERROR_FORMAT, "%s: this %s file is damaged", src->name, kind);
    else
        status = rti_image_begin(src, (uint64_t)w, (uint64_t)h, channels == 2 ? 4 : (uint32_t)channels, wide, out);
    if (!status)
        status = take(src, got, wide, channels, out);
    stbi_image_free(got);
    return status;
}

rt_status rti_stb_decode(const rti_image_source *src, const char *kind, const rti_image_shape *shape, rti_pixels *out)
{
    /* What decoding holds at once is at most three pictures of four channels (the inflated rows, the picture, its copy as
     * floats). The probe tells at once whether the limit allows it, before minutes are spent. */
    bool wide = shape->bits == 16;
    uint64_t picture = shape->width * shape->height * 4 * (wide ? 2 : 1);
    if (src->size > INT_MAX || shape->width > STBI_MAX_DIMENSIONS || shape->height > STBI_MAX_DIMENSIONS || picture > INT_MAX)
        return rti_fail(
            src->ctx, RT_ERROR_UNSUPPORTED,
            "%s: a %s image of %llu x %llu pixels is larger than 2 GiB, more than its reader takes; cut it into parts", src->name,
            kind, (unsigned long long)shape->width, (unsigned long long)shape->height);
    rt_status status = rti_image_allow(src, shape->width, shape->height, 3 * picture);
    if (status)
        return status;
    void *probe = rti_alloc(src->ctx, (size_t)(3 * picture));
    if (!probe)
        return rti_fail_memory(src->ctx, src->name, (size_t)(3 * picture));
    rti_free(src->ctx, probe, (size_t)(3 * picture));
    stb_memory memory = {src->ctx, 0};
    stb_caller = &memory;
    status = run(src, kind, wide, out);
    stb_caller = NULL;
    return status;
}

#else

rt_status rti_stb_decode(const rti_image_source *src, const char *kind, const rti_image_shape *shape, rti_pixels *out)
{
    (void)shape;
    (void)out;
    return rti_fail(
        src->ctx, RT_ERROR_UNSUPPORTED,
        "%s: this librt was built without stb_image and reads no %s files; use BMP, TGA or HDR, or build with -DLIBRT_STB=ON",
        src->name, kind);
}

#endif
