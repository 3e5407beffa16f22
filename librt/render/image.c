/* Images: memory, pixels and text entries. */
#include <string.h>

#include "image_text.h"

/* Asking the system what is free reads files: not for every thumbnail. */
#define ROOM_CHECK_FROM ((uint64_t)64 << 20)

rt_status rti_image_check_size(rt_context *ctx, const char *what, uint32_t width, uint32_t height)
{
    if (width == 0 || height == 0 || width > RTI_IMAGE_MAX_EDGE || height > RTI_IMAGE_MAX_EDGE)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: the size is %u x %u; width and height must be 1 ... %u", what, width, height,
                        RTI_IMAGE_MAX_EDGE);
    return RT_OK;
}

rt_status rti_image_check_room(rt_context *ctx, const char *what, uint32_t width, uint32_t height, uint64_t bytes)
{
    uint64_t limit = rti_context_memory_limit(ctx), now = 0, available;
    rt_context_memory(ctx, &now, NULL);
    while (limit && bytes <= limit && now > limit - bytes && rti_context_relieve(ctx))
        rt_context_memory(ctx, &now, NULL);
    if (limit && (bytes > limit || now > limit - bytes))
        return rti_fail(ctx, RT_ERROR_MEMORY_LIMIT,
                        "%s: %u x %u pixels need %llu bytes; the context's limit is %llu bytes, of which %llu are in use", what,
                        width, height, (unsigned long long)bytes, (unsigned long long)limit, (unsigned long long)now);
    if (bytes < ROOM_CHECK_FROM)
        return RT_OK;
    available = rti_context_spare(ctx, bytes, rt_memory_available);
    if (bytes > available)
        return rti_fail(ctx, RT_ERROR_MEMORY_LIMIT, "%s: %u x %u pixels need %llu bytes; the machine has %llu bytes free", what,
                        width, height, (unsigned long long)bytes, (unsigned long long)available);
    return RT_OK;
}

static rt_image *image_new(rt_context *ctx, uint32_t width, uint32_t height)
{
    rt_image *image = rti_alloc_zero(ctx, sizeof *image);
    if (!image)
        return NULL;
    image->ctx = ctx;
    image->width = width;
    image->height = height;
    image->row_bytes = (size_t)width * 4 * sizeof(float);
    return image;
}

/* A task clears rows. Memory that the system gives is cleared by it first, when it is touched: most of the time goes there. */
#define CLEAR_TASK ((size_t)2 << 20) /* bytes, at least */
typedef struct clearing {
    const rt_image *image;
    uint32_t tasks;
} clearing;

static void clear_rows(void *data, uint32_t index)
{
    const clearing *c = data;
    const uint64_t height = c->image->height;
    const uint32_t end = (uint32_t)(height * (index + 1) / c->tasks);
    for (uint32_t y = (uint32_t)(height * index / c->tasks); y < end; y++)
        memset(rti_image_row(c->image, y), 0, (size_t)c->image->width * 4 * sizeof(float));
}

static void clear(const rt_image *image, uint32_t threads)
{
    const size_t most = (size_t)image->height * image->row_bytes / CLEAR_TASK;
    clearing c = {image, threads};
    c.tasks = most < c.tasks ? (uint32_t)most : c.tasks;
    c.tasks = c.tasks > 1 ? c.tasks : 1;
    rti_parallel(image->ctx, c.tasks, clear_rows, &c);
}

rt_status rti_image_make(rt_context *ctx, uint32_t width, uint32_t height, uint32_t threads, bool unseen, rt_image **image)
{
    static const char what[] = "rt_image_create";
    rt_image *made;
    bool used;
    uint64_t bytes = (uint64_t)width * height * 4 * sizeof(float); /* at most 2^44 once the size is checked */
    rt_status status;
    if (image)
        *image = NULL;
    status = rti_image_check_size(ctx, what, width, height);
    if (status == RT_OK && !image)
        status = rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: image is NULL; it receives the new image", what);
    if (status == RT_OK)
        status = rti_image_check_room(ctx, what, width, height, bytes);
    if (status != RT_OK)
        return status;
    if (bytes > SIZE_MAX)
        return rti_fail(ctx, RT_ERROR_MEMORY, "%s: %u x %u pixels are more than this machine can address", what, width, height);
    made = image_new(ctx, width, height);
    if (!made)
        return rti_fail_memory(ctx, what, sizeof *made);
    made->size = (size_t)bytes;
    made->pixels = rti_kept_take(ctx, RTI_KEPT_PICTURE, &made->size, made->size, &used);
    if (!made->pixels) {
        rti_free(ctx, made, sizeof *made);
        return rti_fail_memory(ctx, what, (size_t)bytes);
    }
    if (!unseen || (!used && threads > 1)) /* new pages: threads would meet at each in their first tiles */
        clear(made, threads);
    *image = made;
    return RT_OK;
}

rt_status rt_image_create(rt_context *context, uint32_t width, uint32_t height, rt_image **image)
{
    RTI_NEED_TO_MAKE(image, context);
    return rti_image_make(context, width, height, rt_context_workers(context), false, image);
}

rt_status rti_image_wrap(rt_context *ctx, uint32_t width, uint32_t height, float *pixels, size_t row_bytes, uint32_t threads,
                         rt_image **image)
{
    rt_image *made = image_new(ctx, width, height);
    *image = NULL;
    if (!made)
        return rti_fail_memory(ctx, "image", sizeof *made);
    made->pixels = pixels;
    made->row_bytes = row_bytes;
    clear(made, threads);
    *image = made;
    return RT_OK;
}

static void text_free(rt_context *ctx, rti_text *text)
{
    rti_free(ctx, text->key, text->key_size);
    rti_free(ctx, text->value, text->value_size);
}

void rt_image_destroy(rt_image *image)
{
    if (!image)
        return;
    for (size_t i = 0; i < image->text_count; i++)
        text_free(image->ctx, &image->texts[i]);
    rti_free(image->ctx, image->texts, image->text_capacity * sizeof *image->texts);
    if (image->size)
        rti_kept_give(image->ctx, RTI_KEPT_PICTURE, image->pixels, image->size);
    rti_free(image->ctx, image, sizeof *image);
}

uint32_t rt_image_width(const rt_image *image)
{
    return image->width;
}

uint32_t rt_image_height(const rt_image *image)
{
    return image->height;
}

float *rt_image_pixels(rt_image *image)
{
    return image->pixels;
}

const float *rt_image_pixels_const(const rt_image *image)
{
    return image->pixels;
}

static char *copy_text(rt_context *ctx, const char *text, size_t size)
{
    char *copy = rti_alloc(ctx, size);
    if (copy)
        memcpy(copy, text, size);
    return copy;
}

static rti_text *find_text(const rt_image *image, const char *key)
{
    for (size_t i = 0; i < image->text_count; i++) {
        if (strcmp(image->texts[i].key, key) == 0)
            return &image->texts[i];
    }
    return NULL;
}

rt_status rt_image_set_text(rt_image *image, const char *key, const char *value)
{
    RTI_NEED(image);
    static const char what[] = "rt_image_set_text";
    rt_context *ctx = image->ctx;
    rti_text fresh, *old;
    if (!key || !value)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: the %s is NULL", what, key ? "value" : "key");
    rt_status status = rti_text_check_key(ctx, what, key);
    if (status != RT_OK)
        return status;
    fresh.key_size = strlen(key) + 1;
    fresh.value_size = strlen(value) + 1;
    if (!rti_reserve(ctx, (void **)&image->texts, &image->text_capacity, image->text_count, 1, sizeof *image->texts))
        return rti_fail_memory(ctx, what, (image->text_count + 1) * sizeof *image->texts);
    fresh.key = copy_text(ctx, key, fresh.key_size);
    fresh.value = copy_text(ctx, value, fresh.value_size);
    if (!fresh.key || !fresh.value) {
        text_free(ctx, &fresh);
        return rti_fail_memory(ctx, what, fresh.key_size + fresh.value_size);
    }
    old = find_text(image, key);
    if (old)
        text_free(ctx, old);
    else
        old = &image->texts[image->text_count++];
    *old = fresh;
    return RT_OK;
}

const char *rt_image_get_text(const rt_image *image, const char *key)
{
    const rti_text *text = key ? find_text(image, key) : NULL;
    return text ? text->value : NULL;
}
