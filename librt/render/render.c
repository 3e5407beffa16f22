/* Rendering in one call: to an image, and band by band to a file. */
#include "band_file.h"
#include "job.h"
#include "save.h"

#define BAND_MEMORY ((uint64_t)256 << 20)

static void unseen(rti_settings *settings)
{
    settings->unseen = true;
}

/* Runs a job to its end; OK when its image is whole. */
static rt_status finish(rt_job *job)
{
    rt_status status = rti_job_run_here(job) ? RT_OK : rti_job_run(job);
    if (status == RT_OK && rt_job_wait(job, -1) != RT_JOB_DONE)
        status = rt_job_status(job);
    return status;
}

rt_status rt_render(rt_scene *scene, const rt_render_desc *desc, rt_image **image)
{
    RTI_NEED_TO_MAKE(image, scene);
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
    status = rti_job_create(ctx, snapshot, what, desc, unseen, &job);
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
    rti_settings checked;
    rti_row_writer *writer;
    rti_band_file kept; /* with a checkpoint; inner is NULL without */
    int (*progress)(void *user, uint64_t done, uint64_t total);
    void *user;
    uint64_t done, total;
    bool stop; /* the progress function has asked for it: a band may be finished before it is heard of */
} banding;

static const char band_what[] = "rt_render_to_file";

static bool asks_to_stop(banding *b)
{
    if (b->progress && b->progress(b->user, b->done, b->total) != 0)
        b->stop = true;
    return b->stop;
}

static int count_tile(void *user, const rt_tile *tile, const rt_image *image)
{
    banding *b = user;
    (void)image;
    b->done += (uint64_t)tile->width * tile->height;
    return asks_to_stop(b);
}

static rt_status say_cancelled(const banding *b)
{
    return rti_fail(b->ctx, RT_ERROR_CANCELLED, "%s: cancelled after %llu of %llu pixels", band_what, (unsigned long long)b->done,
                    (unsigned long long)b->total);
}

/* Asks every 50 ms whether the picture is still wanted: a tile may take minutes. */
static rt_status finish_band(banding *b, rt_job *job)
{
    rt_status status = rti_job_run(job);
    while (status == RT_OK && b->progress && rt_job_wait(job, 0.05) == RT_JOB_RUNNING) {
        if (asks_to_stop(b)) {
            rt_job_cancel(job);
            break;
        }
    }
    if (status == RT_OK && rt_job_wait(job, -1) != RT_JOB_DONE)
        status = rt_job_status(job);
    return status;
}

static rt_status render_band(banding *b, uint32_t y, uint32_t rows)
{
    rt_render_desc d = b->desc;
    rt_job *job;
    rt_status status;
    d.crop.y = y;
    d.crop.height = rows;
    d.checkpoint = b->kept.inner ? b->kept.inner : NULL;
    d.checkpoint_keep = 1; /* until the band stands in the other file */
    status = rti_job_create(b->ctx, b->snapshot, band_what, &d, unseen, &job);
    if (status != RT_OK)
        return status;
    rt_job_on_tile(job, count_tile, b);
    status = finish_band(b, job);
    if (status == RT_OK)
        status = rti_rows_write(b->writer, rt_image_pixels_const(rt_job_image(job)), rows);
    else if (status == RT_ERROR_CANCELLED)
        say_cancelled(b);
    if (status == RT_OK && b->kept.inner)
        status = rti_bands_add(&b->kept, rt_image_pixels_const(rt_job_image(job)), rows);
    if (status == RT_OK && b->kept.inner)
        rti_place_remove(&b->kept.inner_place);
    rt_job_destroy(job);
    return status;
}

/* Goes on behind the bands that the checkpoint holds. */
static rt_status take_kept(banding *b)
{
    rti_check_key key;
    rt_status status;
    if (!b->desc.checkpoint)
        return RT_OK;
    rti_check_key_of(&key, b->snapshot, &b->checked);
    status = rti_bands_open(b->ctx, b->desc.checkpoint, &key, b->desc.crop.width, b->desc.crop.height, b->writer, &b->kept);
    b->done = (uint64_t)b->kept.rows * b->desc.crop.width;
    return status;
}

/* Rows of the band that an earlier run was in, so that its checkpoint fits; 0: there is none. One of another band, which had been
 * added already, is removed. */
static uint32_t begun_rows(banding *b)
{
    const rt_tile *all = &b->desc.crop;
    rti_check_head head;
    uint64_t rows;
    if (!b->kept.inner || !rti_place_there(&b->kept.inner_place))
        return 0;
    if (rti_check_peek(&b->kept.inner_place, &head)) {
        rows = head.key.value[RTI_KEY_CROP_HEIGHT];
        if (head.key.value[RTI_KEY_CROP_Y] == (uint64_t)all->y + b->kept.rows && rows >= 1 && rows <= all->height - b->kept.rows)
            return (uint32_t)rows;
    }
    rti_place_remove(&b->kept.inner_place);
    return 0;
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
    status = take_kept(b);
    for (uint32_t y = b->kept.rows, begun = status == RT_OK ? begun_rows(b) : 0, now; status == RT_OK && y < all.height;
         y += now) {
        now = begun ? begun : rows < all.height - y ? rows : all.height - y;
        status = render_band(b, all.y + y, now);
        if (status == RT_OK && b->stop && now < all.height - y)
            status = say_cancelled(b);
        begun = 0;
    }
    closed = rti_rows_close(b->writer, status == RT_OK);
    status = status == RT_OK ? closed : status;
    if (b->kept.inner)
        rti_bands_close(&b->kept, status == RT_OK && !b->desc.checkpoint_keep);
    return status;
}

rt_status rt_render_to_file(rt_scene *scene, const rt_render_desc *desc, const char *path, const rt_save_desc *save,
                            uint64_t band_memory, int (*progress)(void *user, uint64_t done, uint64_t total), void *user)
{
    RTI_NEED(scene);
    rt_context *ctx = rt_scene_context(scene);
    banding b = {0};
    rt_status status;
    if (!path)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: path is NULL", band_what);
    status = rti_job_snapshot(scene, band_what, &b.snapshot);
    if (status != RT_OK)
        return status;
    status = rti_settings_take(ctx, band_what, b.snapshot, desc, &b.checked);
    if (status == RT_OK && b.checked.desc.pixels)
        status = rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: pixels must be NULL; the picture goes to the file", band_what);
    if (status == RT_OK) {
        b.ctx = ctx;
        b.desc = b.checked.desc;
        b.desc.integrator = b.checked.integrator->name;
        b.desc.tracer = b.checked.tracer->name;
        b.desc.pixels_stride = 0;
        b.progress = progress;
        b.user = user;
        status = render_bands(&b, path, save, band_memory);
    }
    rti_snapshot_release(b.snapshot);
    return status;
}
