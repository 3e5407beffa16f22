/* Rendering in one call: to an image, and band by band to a file. */
#include "job.h"
#include "save.h"

#define BAND_MEMORY ((uint64_t)256 << 20)

/* Runs a job to its end; OK when its image is whole. */
static rt_status finish(rt_job *job)
{
    rt_status status = rti_job_run(job);
    if (status == RT_OK && rt_job_wait(job, -1) != RT_JOB_DONE)
        status = rt_job_status(job);
    return status;
}

rt_status rt_render(rt_scene *scene, const rt_render_desc *desc, rt_image **image)
{
    static const char what[] = "rt_render";
    rt_context *ctx = rt_scene_context(scene);
    rti_snapshot *snapshot;
    rt_job *job;
    rt_status status;
    if (!image)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: image is NULL; it receives the picture", what);
    *image = NULL;
    status = rti_job_snapshot(scene, what, &snapshot);
    if (status != RT_OK)
        return status;
    status = rti_job_create(ctx, snapshot, what, desc, NULL, &job);
    rti_snapshot_release(snapshot);
    if (status != RT_OK)
        return status;
    status = finish(job);
    if (status == RT_OK)
        *image = rt_job_take_image(job);
    rt_job_destroy(job);
    return status;
}

/* ---- bands ---- */

typedef struct banding {
    rt_context *ctx;
    rti_snapshot *snapshot; /* one for all bands, whatever is committed meanwhile */
    rt_render_desc desc;
    rti_row_writer *writer;
    int (*progress)(void *user, uint64_t done, uint64_t total);
    void *user;
    uint64_t done, total;
} banding;

static const char band_what[] = "rt_render_to_file";

static int count_tile(void *user, const rt_tile *tile, const rt_image *image)
{
    banding *b = user;
    (void)image;
    b->done += (uint64_t)tile->width * tile->height;
    return b->progress ? b->progress(b->user, b->done, b->total) : 0;
}

static rt_status render_band(banding *b, uint32_t y, uint32_t rows)
{
    rt_render_desc d = b->desc;
    rt_job *job;
    rt_status status;
    d.crop.y = y;
    d.crop.height = rows;
    status = rti_job_create(b->ctx, b->snapshot, band_what, &d, NULL, &job);
    if (status != RT_OK)
        return status;
    rt_job_on_tile(job, count_tile, b);
    status = finish(job);
    if (status == RT_OK)
        status = rti_rows_write(b->writer, rt_image_pixels_const(rt_job_image(job)), rows);
    else if (status == RT_ERROR_CANCELLED)
        rti_fail(b->ctx, status, "%s: cancelled after %llu of %llu pixels", band_what, (unsigned long long)b->done,
                 (unsigned long long)b->total);
    rt_job_destroy(job);
    return status;
}

/* Whole rows of tiles, as many as fit; at least one row of pixels. */
static uint32_t band_rows(const rt_render_desc *d, uint64_t memory)
{
    uint64_t rows = (memory ? memory : BAND_MEMORY) / ((uint64_t)d->crop.width * 4 * sizeof(float));
    if (rows > d->tile)
        rows -= rows % d->tile;
    if (rows > d->crop.height)
        rows = d->crop.height;
    return rows ? (uint32_t)rows : 1;
}

static rt_status render_bands(banding *b, const char *path, const rt_save_desc *save, uint64_t band_memory)
{
    const rt_tile all = b->desc.crop;
    uint32_t rows = band_rows(&b->desc, band_memory);
    rt_status status = rti_rows_open(b->ctx, path, all.width, all.height, save, NULL, 0, &b->writer), closed;
    if (status != RT_OK)
        return status;
    b->total = (uint64_t)all.width * all.height;
    for (uint32_t y = 0; status == RT_OK && y < all.height; y += rows)
        status = render_band(b, all.y + y, rows < all.height - y ? rows : all.height - y);
    closed = rti_rows_close(b->writer, status == RT_OK);
    return status == RT_OK ? closed : status;
}

rt_status rt_render_to_file(rt_scene *scene, const rt_render_desc *desc, const char *path, const rt_save_desc *save,
                            uint64_t band_memory, int (*progress)(void *user, uint64_t done, uint64_t total), void *user)
{
    rt_context *ctx = rt_scene_context(scene);
    banding b = {0};
    rti_settings checked;
    rt_status status;
    if (!path)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: path is NULL", band_what);
    status = rti_job_snapshot(scene, band_what, &b.snapshot);
    if (status != RT_OK)
        return status;
    status = rti_settings_take(ctx, band_what, b.snapshot, desc, &checked);
    if (status == RT_OK && checked.desc.pixels)
        status = rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: pixels must be NULL; the picture goes to the file", band_what);
    if (status == RT_OK) {
        b.ctx = ctx;
        b.desc = checked.desc;
        b.desc.integrator = checked.integrator->name;
        b.desc.tracer = checked.tracer->name;
        b.desc.pixels_stride = 0;
        b.progress = progress;
        b.user = user;
        status = render_bands(&b, path, save, band_memory);
    }
    rti_snapshot_release(b.snapshot);
    return status;
}
