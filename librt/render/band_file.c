/* Bands kept on disk. */
#include "band_file.h"

#include <string.h>

#define MAGIC "RTBANDS\n"
#define ORDER 0x01020304u

typedef struct band_head {
    char magic[8];
    uint32_t order, head_size;
    rti_check_key key;
} band_head;

/* In front of rows * width * 4 floats. hash: of first, rows and the floats. */
typedef struct band_record {
    uint32_t first, rows;
    rti_hash hash;
} band_record;

static size_t row_bytes(const rti_band_file *f)
{
    return (size_t)f->width * 4 * sizeof(float);
}

typedef struct reading {
    rti_band_file *f;
    rti_reader *reader;
    rti_row_writer *writer;
    char name[300];
    void *row;
    uint64_t size;
} reading;

static rt_status check_head(reading *r, const rti_check_key *key)
{
    rt_context *ctx = r->f->ctx;
    band_head head;
    if (r->size < sizeof head || rti_reader_read(r->reader, 0, &head, sizeof head) != RT_OK ||
        memcmp(head.magic, MAGIC, sizeof head.magic) != 0)
        return rti_fail(ctx, RT_ERROR_FORMAT, "%s: this file is no checkpoint of a render in bands; name another one", r->name);
    if (head.order != ORDER || head.head_size != sizeof head)
        return rti_fail(ctx, RT_ERROR_STATE,
                        "%s: this checkpoint is of another version of librt or another machine; remove it to begin anew",
                        r->name);
    return rti_check_key_compare(ctx, r->name, &head.key, key);
}

/* The record's rows through the hash, and, when it is right, through the writer. */
static rt_status pass(reading *r, uint64_t at, const band_record *record, bool write, rti_hash *hash)
{
    rti_hasher h;
    rt_status status = RT_OK;
    rti_hasher_init(&h);
    rti_hasher_add(&h, record, 2 * sizeof(uint32_t));
    for (uint32_t y = 0; y < record->rows && status == RT_OK; y++) {
        status = rti_reader_read(r->reader, at + (uint64_t)y * row_bytes(r->f), r->row, row_bytes(r->f));
        if (status == RT_OK && write)
            status = rti_rows_write(r->writer, r->row, 1);
        rti_hasher_add(&h, r->row, row_bytes(r->f));
    }
    *hash = rti_hasher_end(&h);
    return status;
}

/* One record; *more: there may be others behind it. */
static rt_status take_record(reading *r, bool *more)
{
    rti_band_file *f = r->f;
    band_record record;
    rti_hash hash;
    uint64_t left = r->size - f->size, bytes;
    rt_status status;
    *more = false;
    if (left < sizeof record)
        return RT_OK;
    status = rti_reader_read(r->reader, f->size, &record, sizeof record);
    if (status != RT_OK)
        return status;
    bytes = sizeof record + (uint64_t)record.rows * row_bytes(f);
    if (record.first != f->rows || record.rows == 0 || record.rows > f->height - f->rows)
        return left <= bytes
                   ? RT_OK
                   : rti_fail(f->ctx, RT_ERROR_FORMAT,
                              "%s: this checkpoint is damaged (a band of it is not the next one); remove it to begin anew",
                              r->name);
    if (left < bytes)
        return RT_OK; /* it was being written */
    status = pass(r, f->size + sizeof record, &record, false, &hash);
    if (status != RT_OK)
        return status;
    if (!rti_hash_equal(hash, record.hash))
        return left == bytes
                   ? RT_OK
                   : rti_fail(f->ctx, RT_ERROR_FORMAT,
                              "%s: this checkpoint is damaged (the checksum of a band is wrong); remove it to begin anew",
                              r->name);
    status = pass(r, f->size + sizeof record, &record, true, &hash);
    f->size += bytes;
    f->rows += record.rows;
    *more = f->rows < f->height;
    return status;
}

static rt_status take_all(reading *r, const rti_check_key *key)
{
    rt_status status = check_head(r, key);
    bool more = status == RT_OK;
    r->f->size = sizeof(band_head);
    while (more && status == RT_OK)
        status = take_record(r, &more);
    return status;
}

static rt_status read_old(rti_band_file *f, const rti_check_key *key, rti_row_writer *writer)
{
    reading r = {.f = f, .writer = writer};
    rt_status status = rti_place_read(&f->place, &r.reader);
    if (status != RT_OK)
        return status;
    rti_quote(r.name, sizeof r.name, f->place.path, strlen(f->place.path));
    r.size = rti_reader_size(r.reader);
    r.row = rti_alloc(f->ctx, row_bytes(f));
    status = r.row ? take_all(&r, key) : rti_fail_memory(f->ctx, r.name, row_bytes(f));
    rti_free(f->ctx, r.row, row_bytes(f));
    rti_reader_close(r.reader);
    return status;
}

static rt_status begin_new(rti_band_file *f, const rti_check_key *key)
{
    band_head head = {.order = ORDER, .head_size = sizeof head, .key = *key};
    memcpy(head.magic, MAGIC, sizeof head.magic);
    f->size = sizeof head;
    return rti_place_append(&f->place, 0, &head, sizeof head);
}

rt_status rti_bands_open(rt_context *ctx, const char *path, const rti_check_key *key, uint32_t width, uint32_t height,
                         rti_row_writer *writer, rti_band_file *file)
{
    rt_status status;
    size_t length = strlen(path);
    memset(file, 0, sizeof *file);
    file->ctx = ctx;
    file->width = width;
    file->height = height;
    file->inner_size = length + sizeof ".band";
    file->inner = rti_alloc(ctx, file->inner_size);
    if (!file->inner)
        return rti_fail_memory(ctx, "a checkpoint", file->inner_size);
    memcpy(file->inner, path, length);
    memcpy(file->inner + length, ".band", sizeof ".band");
    status = rti_place_open(ctx, path, &file->place);
    if (status == RT_OK)
        status = rti_place_open(ctx, file->inner, &file->inner_place);
    if (status == RT_OK)
        status = rti_place_there(&file->place) ? read_old(file, key, writer) : begin_new(file, key);
    if (status != RT_OK)
        rti_bands_close(file, false);
    return status;
}

rt_status rti_bands_add(rti_band_file *file, const float *rgba, uint32_t rows)
{
    band_record record = {.first = file->rows, .rows = rows};
    uint64_t at = file->size;
    size_t bytes = rows * row_bytes(file);
    rti_hasher h;
    rt_status status;
    rti_hasher_init(&h);
    rti_hasher_add(&h, &record, 2 * sizeof(uint32_t));
    rti_hasher_add(&h, rgba, bytes);
    record.hash = rti_hasher_end(&h);
    status = rti_place_append(&file->place, at, &record, sizeof record);
    if (status == RT_OK)
        status = rti_place_append(&file->place, at + sizeof record, rgba, bytes);
    if (status == RT_OK) {
        file->size = at + sizeof record + bytes;
        file->rows += rows;
    }
    return status;
}

void rti_bands_close(rti_band_file *file, bool whole)
{
    if (whole) {
        rti_place_remove(&file->place);
        rti_place_remove(&file->inner_place);
    }
    rti_place_close(&file->place);
    rti_place_close(&file->inner_place);
    rti_free(file->ctx, file->inner, file->inner_size);
    file->inner = NULL;
}
