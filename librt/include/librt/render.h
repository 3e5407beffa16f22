/** librt: rendering. The same snapshot and descriptor give the same image, bit for bit, for any number of workers, tile size, schedule and tracer. */
#ifndef LIBRT_RENDER_H
#define LIBRT_RENDER_H

#include "librt/image.h"
#include "librt/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum rt_filter { RT_FILTER_BOX = 0, RT_FILTER_GAUSSIAN } rt_filter;
typedef enum rt_schedule {
    RT_SCHEDULE_DYNAMIC = 0, /**< tiles are taken on demand */
    RT_SCHEDULE_STATIC       /**< tile i belongs to worker i modulo workers (for comparison) */
} rt_schedule;

typedef struct rt_tile {
    uint32_t x, y, width, height; /**< in pixels of the whole image, y from the top */
} rt_tile;

typedef struct rt_render_desc {
    uint32_t struct_size;
    uint32_t width, height; /**< 1 ... 1048576; default 640 and 480 */
    uint32_t samples;       /**< a pixel, 1 ... 65536; default 1 */
    uint32_t workers;       /**< 0: the context's */
    uint32_t tile;          /**< edge in pixels, 1 ... 4096; default 32 */
    rt_schedule schedule;
    const char *integrator; /**< "whitted" (default), "path", "ao", "normal", "uv", "id", "depth", "cost", "steps"; rt_integrator_at lists them */
    const char *tracer;     /**< "auto" (default), "kdtree", "octree", "bvh", "brute"; rt_tracer_at lists them. A missing tree is built first */
    uint64_t seed;
    uint32_t max_depth; /**< bounces, 0 ... 64; default 8 */
    rt_filter filter;
    float filter_width; /**< in pixels; 0: the filter's own (box 1, Gaussian 2) */
    int shadows;        /**< 0: lights are never shadowed; default 1 */
    uint32_t shadow_samples; /**< rays to a spherical light a hit; 0: 1 from 16 samples a pixel up, else 16 */
    int opaque_shadows; /**< transparent bodies cast full shadows */
    uint32_t ao_samples; /**< "ao": rays a hit; 0: 1 from 16 samples up, else 16 */
    float ao_distance;   /**< "ao": reach, <= 0: a tenth of the scene's diagonal */
    rt_tile crop;        /**< only this part is rendered and returned; width 0: all */
    float *pixels;       /**< caller's buffer, float[4] a pixel of the crop, or NULL: the image has its own. Must live until the job is destroyed */
    size_t pixels_stride; /**< bytes from row to row of that buffer; 0: dense */
    uint64_t memory_limit; /**< bytes this render may take beside the scene; 0: what is free. More ends with MEMORY_LIMIT and the numbers;
                                rt_render_to_file takes a band at a time */
    const char *checkpoint; /**< file that keeps what is done (NULL: none), see below; the string is copied */
    double checkpoint_every; /**< seconds between two writings, > 0; 0: 60 */
    int checkpoint_keep;     /**< the file stays, with the whole picture, when the render is done; else it is removed then */
    int background;          /**< a job of one worker has a thread of its own too, so that several such jobs run side by side */
} rt_render_desc;
RT_API rt_render_desc rt_render_desc_default(void);

/* Checkpoints. With `checkpoint` a render writes its state into that file every checkpoint_every seconds and when it is cancelled: finished tiles, and the
 * sums of unfinished ones, so that even a tile of hours loses no more than that time. A render that finds the file goes on from there, to the same bits and
 * the same statistics as one that was never interrupted; workers, tracer, schedule and memory may be others, tiles stay those of the file. A file of
 * another scene, setting, seed or version of librt, or a damaged one, is refused with a sentence that says what differs (STATE, FORMAT).
 * The file is written aside, brought to disk and renamed; it takes 16 bytes a finished pixel, 32 an unfinished one. A render never
 * spends more than about one percent of its time on it: where writing takes long, it is done less often. That it cannot be written is an error at the start, later a warning
 * in the log. A cancelled render with a checkpoint first works down the rays under way, up to 250 ms more (rays given up after that are counted twice in the statistics). rt_render_to_file keeps finished bands in the
 * file (growing with each), and the state within a band in FILE.band. */

/** Names and one-line descriptions of what this build has. NULL past the end. */
RT_API const char *rt_integrator_at(uint32_t index, const char **help);
RT_API const char *rt_tracer_at(uint32_t index, const char **help);

/** Renders and returns the image. Same as start, wait, take. A cancelled or failed render returns no image. Errors as rt_job_start. */
RT_API rt_status rt_render(rt_scene *scene, const rt_render_desc *desc, rt_image **image);

/** Renders band by band straight into a file (png, bmp, tga, hdr), so that images larger than the memory can be made.
 *  band_memory: bytes for the film, 0: 256 MiB. progress(user, done, total pixels) may be NULL. It is called on the calling thread for each finished tile,
 *  with more done than before and at last with total; and about every 50 ms beside that, as a tile may take minutes, with the same done again. Non-zero
 *  cancels; tiles that are finished by then may still be told, and a band that the workers had finished is kept. The render ends as CANCELLED unless
 *  the picture was whole by then. save: NULL: defaults. */
RT_API rt_status rt_render_to_file(rt_scene *scene, const rt_render_desc *desc, const char *path, const rt_save_desc *save, uint64_t band_memory,
                                   int (*progress)(void *user, uint64_t done, uint64_t total), void *user);

/** Bytes a render would take beside the scene: film, image and workers' scratch. 0: the descriptor is wrong (see rt_context_error). */
RT_API uint64_t rt_render_memory(rt_scene *scene, const rt_render_desc *desc);

/* ---- jobs ---- */

typedef enum rt_job_state { RT_JOB_RUNNING = 0, RT_JOB_DONE, RT_JOB_CANCELLED, RT_JOB_FAILED } rt_job_state;

/** Starts a render of the scene's committed snapshot. With one worker and no `background`, the work is done inside rt_job_poll and rt_job_wait on the
 *  caller's thread; otherwise by threads of the job. A context with the host's tasks has no threads: there poll and wait drive them, in the background too.
 *  Errors   STATE (not committed), ARGUMENT, MEMORY, MEMORY_LIMIT, THREAD (the system gives none)
 *  Threads  a job is used by one thread at a time; rt_job_cancel from any
 *  Owner    the caller: rt_job_destroy (which cancels and waits) */
RT_API rt_status rt_job_start(rt_scene *scene, const rt_render_desc *desc, rt_job **job);
/** Called on the thread inside rt_job_wait, for each tile that is done; its pixels stand in the image. Non-zero cancels. */
typedef int (*rt_tile_fn)(void *user, const rt_tile *tile, const rt_image *image);
RT_API void rt_job_on_tile(rt_job *job, rt_tile_fn fn, void *user);
/** State now, without waiting (one worker: after at most about 20 ms of work). progress 0 ... 1 may be NULL; it never falls, and stands still between tiles. */
RT_API rt_job_state rt_job_poll(rt_job *job, float *progress);
/** Waits up to `seconds` (< 0: to the end) and returns the state. */
RT_API rt_job_state rt_job_wait(rt_job *job, double seconds);
/** The job ends within 100 ms; what was finished stays in the image. Any thread. */
RT_API void rt_job_cancel(rt_job *job);
/** The next finished tile, in the order of finishing; 0 when there is none now. */
RT_API int rt_job_next_tile(rt_job *job, rt_tile *tile);
/** The image: unfinished tiles are transparent black. Belongs to the job until rt_job_take_image. */
RT_API const rt_image *rt_job_image(rt_job *job);
/** Gives the image to the caller (NULL before the end or if taken). */
RT_API rt_image *rt_job_take_image(rt_job *job);
/** Why a job failed: its status (OK while it runs or when done). */
RT_API rt_status rt_job_status(const rt_job *job);
RT_API void rt_job_destroy(rt_job *job);

typedef struct rt_render_stats {
    double seconds, build_seconds;
    uint64_t rays_camera, rays_shadow, rays_reflect, rays_refract, rays_diffuse, rays_ao;
    uint64_t nodes, tests;                  /**< visited nodes, tested primitives; counted by the integrators "cost" and "steps" alone */
    uint64_t clamped, dropped;              /**< film contributions limited, and NaN or infinite ones left out */
    uint64_t memory;                        /**< bytes the render took */
    uint32_t workers, tiles, tiles_done;
} rt_render_stats;
RT_API void rt_job_stats(rt_job *job, rt_render_stats *stats);

typedef struct rt_checkpoint_stats {
    uint32_t tiles_resumed;  /**< finished, and begun, tiles that came from the file */
    uint32_t tiles_begun;
    uint32_t written, failed; /**< times the file was written, and could not be */
    double seconds;           /**< spent on writing by a worker */
} rt_checkpoint_stats;
/** What a job had to do with its checkpoint; zeros without one. */
RT_API void rt_job_checkpoint_stats(rt_job *job, rt_checkpoint_stats *stats);

/** Which materials the job's rays looked at: touched[i] is 1 when material i of the committed scene (in rt_scene_looks_hash's order) was, for what a ray of
 *  the picture or a shadow ray through a transparent body met, else 0. The same for any workers, tiles and tracer. Cut-out materials (alpha maps)
 *  always count; so do all while the job runs, and in one that went on from a checkpoint. If the picture is whole, and another scene has the same
 *  `rest` and differs only in looks of materials that are 0 here, its picture has the same bits.
 *  Writes at most capacity entries; returns the number of materials. */
RT_API uint32_t rt_job_touched_materials(rt_job *job, uint8_t *touched, uint32_t capacity);

typedef struct rt_worker_stats {
    double busy_seconds, cpu_seconds; /**< inside tiles; wall and the thread's CPU time */
    uint64_t rays;
    uint32_t tiles;
} rt_worker_stats;
/** Writes at most capacity entries; returns the number of workers. */
RT_API uint32_t rt_job_worker_stats(rt_job *job, rt_worker_stats *stats, uint32_t capacity);

#ifdef __cplusplus
}
#endif
#endif
