/* Checkpoint files with a right size, checksum and key, whose contents are the fuzzer's. */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "render/checkpoint_file.h"
#include "render/image.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* A frame of 20 x 12 pixels whose image is there. */
static void make_frame(rt_context *ctx, rti_frame *frame, uint32_t tile)
{
    memset(frame, 0, sizeof *frame);
    frame->set.desc.crop = (rt_tile){0, 0, 20, 12};
    frame->set.desc.tile = tile;
    frame->set.samples = 4;
    frame->tile_columns = (20 + tile - 1) / tile;
    frame->tile_count = frame->tile_columns * ((12 + tile - 1) / tile);
    if (rt_image_create(ctx, 20, 12, &frame->image) != RT_OK)
        abort();
}

static void load(rt_context *ctx, const char *path, const rti_check_key *key)
{
    rti_check_file file;
    rti_frame frame;
    rti_place place;
    if (rti_place_open(ctx, path, &place) != RT_OK)
        abort();
    rt_status status = rti_check_open(&place, key, &file);
    rti_place_close(&place);
    if (status != RT_OK)
        return;
    make_frame(ctx, &frame, file.head.tile);
    uint32_t begun = file.head.partial_count <= frame.tile_count ? file.head.partial_count : 0;
    uint32_t *done = calloc(frame.tile_count, sizeof *done);
    rti_check_partial *partials = calloc(begun ? begun : 1, sizeof *partials);
    if (!done || !partials)
        abort();
    if (rti_check_load(&file, &frame, done, partials) == RT_OK) {
        for (uint32_t i = 0; i < file.head.done_count; i++)
            if (done[i] >= frame.tile_count)
                abort();
        for (uint32_t i = 0; i < begun; i++)
            if (partials[i].tile >= frame.tile_count || !partials[i].film || partials[i].sample >= frame.set.samples)
                abort();
    }
    rti_check_free_partials(ctx, &frame, partials, begun);
    rt_image_destroy(frame.image);
    free(done);
    free(partials);
    rti_check_close(&file);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static rt_context *ctx;
    static char path[64];
    rti_check_key key;
    rti_check_head head;
    rti_hash hash;
    uint64_t before = 0, after = 0;
    if (!ctx) {
        rt_context_desc d = rt_context_desc_default();
        d.workers = 1;
        if (rt_context_create(&d, &ctx) != RT_OK)
            abort();
        snprintf(path, sizeof path, "/tmp/librt_fuzz_checkpoint_%ld", (long)getpid());
    }
    if (size < 4 * sizeof(uint32_t))
        return 0;
    memset(&key, 0, sizeof key);
    memset(&head, 0, sizeof head);
    memcpy(head.magic, RTI_CHECK_MAGIC, sizeof head.magic);
    head.order = RTI_CHECK_ORDER;
    head.head_size = sizeof head;
    memcpy(&head.tile, data, 3 * sizeof(uint32_t)); /* the edge and both counts */
    head.tile &= 4095;
    size_t rest = size - 3 * sizeof(uint32_t), total = sizeof head + rest + sizeof hash;
    uint8_t *bytes = malloc(total);
    if (!bytes)
        abort();
    head.file_size = total;
    memcpy(bytes, &head, sizeof head);
    memcpy(bytes + sizeof head, data + 3 * sizeof(uint32_t), rest);
    hash = rti_hash_bytes(bytes, total - sizeof hash);
    memcpy(bytes + total - sizeof hash, &hash, sizeof hash);
    FILE *f = fopen(path, "wb");
    if (!f || fwrite(bytes, 1, total, f) != total || fclose(f) != 0)
        abort();
    free(bytes);
    rt_context_memory(ctx, &before, NULL);
    load(ctx, path, &key);
    rt_context_drop_kept(ctx);
    rt_context_memory(ctx, &after, NULL);
    unlink(path);
    if (before != after)
        abort();
    return 0;
}
