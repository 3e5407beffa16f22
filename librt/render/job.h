/* A render on its way. Only job*.c look inside. */
#ifndef RTI_JOB_H
#define RTI_JOB_H

#include <pthread.h>

#include "checkpoint.h"
#include "image.h"
#include "wavefront.h"

/* How a job gets its work done. THREADS: own threads run it to the end. DRIVEN: poll and wait run slices of it, on the caller's
 * thread (one worker, not in the background) or on the host's tasks. */
enum { RTI_JOB_THREADS = 0, RTI_JOB_DRIVEN };

#define RTI_UNTOLD 64u /* tiles at most */

/* What a worker has done so far, as others may read it. */
typedef struct rti_job_share {
    rti_worker_counts counts;
    rti_trace_stats trace;
    double busy_seconds, cpu_seconds;
} rti_job_share;

typedef struct rti_job_worker {
    rti_worker wave;
    struct rt_job *job;
    void *scratch;                             /* of rti_kept_take, */
    size_t held;                               /* so many bytes */
    uint32_t role;                             /* index of this worker */
    uint32_t static_next;                      /* RT_SCHEDULE_STATIC: its next tile */
    uint32_t untold[RTI_UNTOLD], untold_count; /* finished tiles that the job has not heard of */
    bool made, begun, done;                    /* made: wave is, by rti_job_make_worker */
    uint32_t epoch;                   /* of checkpoints: the last it gave its part to */
    double stop_since;                /* when it saw that the job is to stop; 0: not yet */
    double busy_seconds, cpu_seconds; /* of the slices before this one */
    double slice_start, slice_cpu;
    rti_job_share share; /* under the job's lock; renewed with every tile */
} rti_job_worker;

/* What a job with a checkpoint keeps beside its work (job_checkpoint.c). */
typedef struct rti_keeper {
    rti_place place;
    double every;
    bool keep;
    rti_check_key key;
    rti_check_counts base; /* of the runs before this one */
    uint32_t base_tiles;
    rti_check_partial *begun; /* tiles that came unfinished: read-only while rays fly */
    uint32_t begun_count, tile_count, worker_count;
    uint8_t *resumed; /* [tile_count] came finished; read-only while rays fly */

    atomic_uint epoch;            /* grows when the time has come: each worker then gives its part */
    atomic_uint_fast64_t next_ms; /* that time, since the job's start */
    atomic_bool flying, stop;     /* rays are traced; the job is to end with its rays worked down */

    /* under the job's lock */
    uint8_t *settled;            /* [tile_count] its owner has given part since */
    uint32_t *finished_by;       /* [tile_count] worker of finished[i] */
    rti_check_partial *deposits; /* [worker_count] what a worker had begun when it gave its part; film NULL: nothing */
    rti_job_share *shares;       /* [worker_count] its counts then */
    uint64_t **films;            /* [worker_count] where its deposit stands */
    size_t film_size;
    uint32_t waiting; /* workers of this epoch still to come */
    bool writing;
    uint32_t *list; /* [tile_count] the writer's */
    rti_check_partial *partials;
    rt_checkpoint_stats stats;
} rti_keeper;

struct rt_job {
    rt_context *ctx;
    rti_snapshot *snapshot;
    rti_frame frame;
    rti_cancel cancel;
    rt_image *image; /* NULL once taken */
    uint32_t mode;
    rti_threads *threads;
    uint32_t *light_of_geom;
    uint32_t geom_count;

    rti_job_worker *workers;
    uint32_t worker_count;
    uint32_t *finished; /* [tile_count] in the order of finishing */

    atomic_uint next_tile, next_role;
    atomic_uint_fast64_t pixels_done;

    pthread_mutex_t lock; /* for what stands below */
    pthread_cond_t news;  /* a tile was finished, the job ended, or it was made ready */
    uint32_t finished_count, running, told,
        taken; /* running: workers not yet at their end; told, taken: tiles given to on_tile, next_tile */
    bool preparing, ready;
    rt_job_state state;
    rt_status status;
    char message[256];
    rt_tile_fn on_tile;
    void *on_tile_user;

    rti_keeper *keeper; /* NULL: no checkpoint is wanted */
    double started, ended, build_seconds;
    uint64_t memory;
};

/* The scene's snapshot (retained), or STATE with a sentence. */
rt_status rti_job_snapshot(const rt_scene *scene, const char *what, rti_snapshot **snapshot);
/* Makes the job without starting it; it retains the snapshot. what: the public function, for messages; tune (may be NULL) changes
 * checked settings. */
rt_status rti_job_create(rt_context *ctx, rti_snapshot *snapshot, const char *what, const rt_render_desc *desc,
                         void (*tune)(rti_settings *settings), rt_job **job);
/* Starts its threads, if it has any. */
rt_status rti_job_run(rt_job *job);
/* Runs it to its end on this thread and the context's, which are there already, where those are enough for a job of threads.
 * false: it did not. */
bool rti_job_run_here(rt_job *job);

/* job_work.c. make_worker: so that it can begin; of one worker it is done with the job, of many each does it itself, for its memory
 * may be another processor's. work: the tree that the tracer needs, once; then worker `role` until its end, a cancel, or `until`
 * (by rti_now; < 0: never). */
void rti_job_make_worker(rti_job_worker *w);
void rti_job_work(rt_job *job, uint32_t role, double until);
void rti_job_renew_share(rti_job_worker *w); /* the lock is held */

/* job_checkpoint.c. make: checks the path and takes over what the file holds about the tiles' edge, before the frame is planned
 * (*file then waits for load). load: the file's content, when image and workers are there; and a first file, so that a place that
 * cannot be written to is known at once. */
rt_status rti_keeper_make(rt_job *job, const char *what, const rt_render_desc *desc, rti_check_file *file);
rt_status rti_keeper_load(rt_job *job, rti_check_file *file);
uint64_t rti_keeper_bytes(const rti_frame *frame);
void rti_keeper_free(rt_job *job);
/* After a step of the worker; more: the step found work. Returns whether to go on. */
bool rti_keeper_tend(rti_job_worker *w, bool more);
/* The worker has come to its end; and so has the last, whose state is to be. */
void rti_keeper_worker_ends(rti_job_worker *w);
void rti_keeper_job_ends(rt_job *job, rt_job_state state);
void rti_keeper_restore(void *owner, uint32_t index, uint64_t *film);

/* The thread of a THREADS job. */
void rti_job_thread(void *data, uint32_t index);
/* A slice of `seconds` on the caller's thread and the host's tasks. */
void rti_job_drive(rt_job *job, double seconds);

#endif
