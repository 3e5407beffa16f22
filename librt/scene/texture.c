/* Adding textures, from memory and from files. */
#include "scene.h"

#include <string.h>

#include "import/image_read.h"
#include "kept.h"

#define LARGEST 65536u

rt_texture_desc rt_texture_desc_default(void)
{
    rt_texture_desc d;
    memset(&d, 0, sizeof d);
    d.struct_size = sizeof d;
    return d;
}

static rt_status check_size(rt_context *ctx, const char *call, uint32_t width, uint32_t height)
{
    if (width >= 1 && width <= LARGEST && height >= 1 && height <= LARGEST)
        return RT_OK;
    return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: the size is %u x %u; width and height must be from 1 to %u", call, width, height,
                    LARGEST);
}

static rt_status check_wrap(rt_context *ctx, const char *call, const rt_texture_desc *d)
{
    if ((uint32_t)d->wrap <= RT_WRAP_CLAMP)
        return RT_OK;
    return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: wrap is %u; it must be RT_WRAP_REPEAT (0) or RT_WRAP_CLAMP (1)", call,
                    (unsigned)d->wrap);
}

static rti_texels texels(const rt_texture_desc *d, const void *pixels, uint32_t width, uint32_t height, uint32_t channels,
                         bool floats)
{
    rti_texels t = {.pixels = pixels, .width = width, .height = height, .channels = channels};
    t.flags = floats ? RTK_TEX_FLOAT : (d->linear ? 0u : RTK_TEX_SRGB);
    t.flags |= (d->nearest ? RTK_TEX_NEAREST : 0u) | (d->wrap == RT_WRAP_CLAMP ? RTK_TEX_CLAMP : 0u);
    return t;
}

static rt_status push(rt_scene *scene, const char *call, rti_chunk *chunk, const rti_hash *source, rt_texture *texture)
{
    rti_texture *slot = rti_array_push(scene->ctx, &scene->textures, sizeof *slot);
    if (!slot) {
        rti_chunk_release(chunk);
        return rti_array_refused(scene->ctx, call, &scene->textures, 1, sizeof *slot);
    }
    slot->chunk = chunk;
    if (source)
        slot->source = *source;
    if (texture)
        texture->id = (uint32_t)(scene->textures.count - 1);
    return RT_OK;
}

rt_status rt_scene_add_texture(rt_scene *scene, const rt_texture_desc *desc, rt_texture *texture)
{
    static const char call[] = "rt_scene_add_texture";
    static const uint32_t channels[] = {3, 4, 1, 3, 4};
    rt_texture_desc d = rt_texture_desc_default();
    rti_texels t;
    rti_chunk *chunk;
    rt_status status = rti_scene_editable(scene, call);
    if (status == RT_OK)
        status = rti_desc_take(scene->ctx, call, desc, &d, sizeof d);
    if (status == RT_OK)
        status = check_size(scene->ctx, call, d.width, d.height);
    if (status == RT_OK)
        status = check_wrap(scene->ctx, call, &d);
    if (status == RT_OK && !d.pixels)
        status = rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: pixels is NULL", call);
    if (status == RT_OK && (uint32_t)d.format > RT_PIXEL_RGBA32F)
        status =
            rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: format is %u; it must be from RT_PIXEL_RGB8 (0) to RT_PIXEL_RGBA32F (4)",
                     call, (unsigned)d.format);
    if (status != RT_OK)
        return status;
    t = texels(&d, d.pixels, d.width, d.height, channels[d.format], d.format >= RT_PIXEL_RGB32F);
    status = rti_texture_chunk(scene->ctx, call, &t, &chunk);
    return status == RT_OK ? push(scene, call, chunk, NULL, texture) : status;
}

/* Of the settings, and of the path unless it is NULL. */
static rti_hash source_hash(const char *path, const rt_texture_desc *d)
{
    uint32_t how[3] = {(uint32_t)d->wrap, d->linear != 0, d->nearest != 0};
    rti_hasher h;
    rti_hasher_init(&h);
    rti_hasher_add(&h, "image", 5);
    rti_hasher_add(&h, how, sizeof how);
    if (path)
        rti_hasher_add(&h, path, strlen(path));
    return rti_hasher_end(&h);
}

/* The texture of an image file: held by the context, or read. */
static rt_status load(rt_context *ctx, const char *call, const char *path, const rt_texture_desc *d, rti_chunk **chunk)
{
    rti_kept_file file;
    rti_kept kept;
    rti_pixels pixels = {.data = NULL};
    rt_status status = rti_kept_begin(&file, ctx, path, source_hash(NULL, d), &kept);
    if (status == RT_OK && !kept.texture) {
        status = rti_image_decode(ctx, path, file.bytes, file.size, d->linear, &pixels);
        if (status == RT_OK)
            status = check_size(ctx, path, pixels.width, pixels.height);
        if (status == RT_OK) {
            rti_texels t = texels(d, pixels.data, pixels.width, pixels.height, pixels.channels, pixels.is_float);
            status = rti_texture_chunk(ctx, call, &t, &kept.texture);
        }
        if (status == RT_OK)
            rti_kept_put(&file, kept, kept.texture->size);
        rti_free(ctx, pixels.data, pixels.size);
    }
    rti_kept_end(&file);
    *chunk = kept.texture;
    return status;
}

static bool find_source(const rt_scene *scene, rti_hash source, rt_texture *texture)
{
    for (size_t i = 0; i < scene->textures.count; i++) {
        if (!rti_hash_equal(RTI_AT(scene->textures, rti_texture, i)->source, source))
            continue;
        if (texture)
            texture->id = (uint32_t)i;
        return true;
    }
    return false;
}

rt_status rt_scene_load_texture(rt_scene *scene, const char *path, const rt_texture_desc *desc, rt_texture *texture)
{
    static const char call[] = "rt_scene_load_texture";
    rt_texture_desc d = rt_texture_desc_default();
    rti_chunk *chunk;
    rti_hash source;
    rt_status status = rti_scene_editable(scene, call);
    if (!path)
        return rti_fail(scene->ctx, RT_ERROR_ARGUMENT, "%s: path is NULL; give the name of an image file", call);
    if (status == RT_OK && desc)
        status = rti_desc_take(scene->ctx, call, desc, &d, sizeof d);
    if (status == RT_OK)
        status = check_wrap(scene->ctx, call, &d);
    if (status != RT_OK)
        return status;
    source = source_hash(path, &d);
    if (find_source(scene, source, texture))
        return RT_OK;
    status = load(scene->ctx, call, path, &d, &chunk);
    return status == RT_OK ? push(scene, call, chunk, &source, texture) : status;
}
