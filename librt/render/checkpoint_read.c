/* Checkpoint files: reading. They are hostile: nothing is taken before the whole file has the right size and hash and is of this
 * render, and then counts and places are checked still, for a hash keeps nobody from writing what he likes. */
#include <string.h>

#include "checkpoint_file.h"
#include "image.h"

#define PIECE (1u << 16)

static rt_status damaged(rti_check_file *f, const char *why)
{
    return rti_fail(f->ctx, RT_ERROR_FORMAT, "%s: this checkpoint is damaged (%s); remove it to begin anew", f->name, why);
}

static rt_status check_hash(rti_check_file *f)
{
    rti_hasher h;
    rti_hash there, here;
    uint64_t end = rti_reader_size(f->reader) - sizeof there;
    uint8_t *piece = rti_alloc(f->ctx, PIECE);
    rt_status status = RT_OK;
    if (!piece)
        return rti_fail_memory(f->ctx, f->name, PIECE);
    rti_hasher_init(&h);
    for (uint64_t at = 0; at < end && status == RT_OK;) {
        size_t n = end - at < PIECE ? (size_t)(end - at) : PIECE;
        status = rti_reader_read(f->reader, at, piece, n);
        if (status == RT_OK)
            rti_hasher_add(&h, piece, n);
        at += n;
    }
    rti_free(f->ctx, piece, PIECE);
    if (status == RT_OK)
        status = rti_reader_read(f->reader, end, &there, sizeof there);
    if (status != RT_OK)
        return status;
    here = rti_hasher_end(&h);
    if (!rti_hash_equal(there, here))
        return damaged(f, "its checksum is wrong");
    return RT_OK;
}

static rt_status check_head(rti_check_file *f, const rti_check_key *key)
{
    uint64_t size = rti_reader_size(f->reader);
    rt_status status;
    if (size < sizeof f->head + sizeof(rti_hash) || rti_reader_read(f->reader, 0, &f->head, sizeof f->head) != RT_OK ||
        memcmp(f->head.magic, RTI_CHECK_MAGIC, sizeof f->head.magic) != 0)
        return rti_fail(f->ctx, RT_ERROR_FORMAT, "%s: this file is no checkpoint of a render; name another one", f->name);
    if (f->head.order != RTI_CHECK_ORDER)
        return rti_fail(f->ctx, RT_ERROR_STATE,
                        "%s: this checkpoint is of a machine with another order of bytes; remove it or name another file",
                        f->name);
    if (f->head.head_size != sizeof f->head)
        return rti_fail(f->ctx, RT_ERROR_STATE, "%s: this checkpoint is of another version of librt; remove it to begin anew",
                        f->name);
    if (f->head.file_size != size)
        return damaged(f, f->head.file_size > size ? "it is cut" : "it is longer than it says");
    status = check_hash(f);
    if (status == RT_OK)
        status = rti_check_key_compare(f->ctx, f->name, &f->head.key, key);
    if (status == RT_OK && (f->head.tile < 1 || f->head.tile > 4096))
        status = damaged(f, "its tiles have an edge that is not 1 ... 4096");
    return status;
}

rt_status rti_check_open(const rti_place *place, const rti_check_key *key, rti_check_file *file)
{
    rt_status status;
    memset(file, 0, sizeof *file);
    file->ctx = place->ctx;
    rti_quote(file->name, sizeof file->name, place->path, strlen(place->path));
    status = rti_place_read(place, &file->reader);
    if (status == RT_OK)
        status = check_head(file, key);
    if (status != RT_OK)
        rti_check_close(file);
    return status;
}

bool rti_check_peek(const rti_place *place, rti_check_head *head)
{
    rti_reader *reader;
    bool found = false;
    if (rti_place_read(place, &reader) == RT_OK)
        found = rti_reader_read(reader, 0, head, sizeof *head) == RT_OK &&
                memcmp(head->magic, RTI_CHECK_MAGIC, sizeof head->magic) == 0;
    else
        return false;
    rti_reader_close(reader);
    return found;
}

void rti_check_close(rti_check_file *file)
{
    rti_reader_close(file->reader);
    file->reader = NULL;
}

void rti_check_free_partials(rt_context *ctx, const rti_frame *frame, rti_check_partial *partials, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        if (partials[i].film)
            rti_free(ctx, partials[i].film, rti_check_film_bytes(frame, partials[i].tile));
        partials[i].film = NULL;
    }
}

/* ---- contents ---- */

/* seen: a byte a tile, zero. */
static rt_status load_list(rti_check_file *f, const rti_frame *frame, uint32_t *done, uint8_t *seen)
{
    rt_status status = f->head.done_count > frame->tile_count || f->head.partial_count > frame->tile_count
                           ? damaged(f, "it has more tiles than the image")
                           : rti_reader_read(f->reader, sizeof f->head, done, f->head.done_count * sizeof *done);
    for (uint32_t i = 0; status == RT_OK && i < f->head.done_count; i++) {
        if (done[i] >= frame->tile_count || seen[done[i]])
            status = damaged(f, "a tile of it does not exist or stands twice");
        else
            seen[done[i]] = 1;
    }
    return status;
}

static rt_status load_tile(rti_check_file *f, const rti_frame *frame, uint32_t index, uint64_t *at)
{
    rt_tile t = rti_frame_tile(frame, index);
    const rt_tile *crop = &frame->set.desc.crop;
    size_t row = (size_t)t.width * 4 * sizeof(float);
    rt_status status = RT_OK;
    for (uint32_t y = 0; y < t.height && status == RT_OK; y++, *at += row)
        status =
            rti_reader_read(f->reader, *at, rti_image_row(frame->image, t.y - crop->y + y) + (size_t)(t.x - crop->x) * 4, row);
    return status;
}

static rt_status load_partial(rti_check_file *f, const rti_frame *frame, rti_check_partial *p, uint8_t *seen, uint64_t *at)
{
    uint64_t end = rti_reader_size(f->reader) - sizeof(rti_hash);
    uint32_t head[4];
    rt_tile t;
    size_t bytes;
    rt_status status;
    if (end - *at < sizeof head)
        return damaged(f, "a tile of it is cut");
    status = rti_reader_read(f->reader, *at, head, sizeof head);
    if (status != RT_OK)
        return status;
    if (head[0] >= frame->tile_count || seen[head[0]])
        return damaged(f, "a tile of it does not exist or stands twice");
    seen[head[0]] = 1;
    t = rti_frame_tile(frame, head[0]);
    if (head[1] >= t.width || head[2] >= t.height || head[1] % 4 || head[2] % 4 || head[3] >= frame->set.samples)
        return damaged(f, "a tile of it goes on at a place that does not exist");
    bytes = rti_check_film_bytes(frame, head[0]);
    if (end - *at - sizeof head < bytes)
        return damaged(f, "a tile of it is cut");
    *p = (rti_check_partial){head[0], head[1], head[2], head[3], rti_alloc(f->ctx, bytes)};
    if (!p->film)
        return rti_fail_memory(f->ctx, f->name, bytes);
    status = rti_reader_read(f->reader, *at + sizeof head, p->film, bytes);
    *at += sizeof head + bytes;
    return status;
}

static rt_status load_all(rti_check_file *f, const rti_frame *frame, uint32_t *done, rti_check_partial *partials, uint8_t *seen)
{
    uint64_t at = sizeof f->head + (uint64_t)f->head.done_count * sizeof *done,
             end = rti_reader_size(f->reader) - sizeof(rti_hash);
    rt_status status = load_list(f, frame, done, seen);
    for (uint32_t i = 0; i < f->head.done_count && status == RT_OK; i++)
        status = end < at || end - at < rti_check_tile_bytes(frame, done[i]) ? damaged(f, "a tile of it is cut")
                                                                             : load_tile(f, frame, done[i], &at);
    for (uint32_t i = 0; i < f->head.partial_count && status == RT_OK; i++)
        status = load_partial(f, frame, &partials[i], seen, &at);
    if (status == RT_OK && at != end)
        status = damaged(f, "it is longer than its tiles");
    return status;
}

rt_status rti_check_load(rti_check_file *file, const rti_frame *frame, uint32_t *done, rti_check_partial *partials)
{
    uint8_t *seen = rti_alloc_zero(file->ctx, frame->tile_count);
    rt_status status;
    if (!seen)
        return rti_fail_memory(file->ctx, file->name, frame->tile_count);
    status = load_all(file, frame, done, partials, seen);
    rti_free(file->ctx, seen, frame->tile_count);
    return status;
}
