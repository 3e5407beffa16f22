/* Checkpoints: what a job has done so far, as a file from which it goes on to the same bits.
 *
 * The film's sums are integers and do not depend on their order, so a tile's state is exact wherever none of its rays is under
 * way: a worker sends no camera rays until its waiting ones are gone (some steps), and then every tile it holds is finished but
 * one, whose sums and next camera ray it deposits. Workers do this each for itself, without a barrier; the last writes the file.
 * The file holds finished tiles as pixels, unfinished ones as sums, statistics, and the key of what is rendered. */
#ifndef RTI_CHECKPOINT_H
#define RTI_CHECKPOINT_H

#include "frame.h"

enum {
    RTI_KEY_SCENE_LO = 0,
    RTI_KEY_SCENE_HI,
    RTI_KEY_WIDTH,
    RTI_KEY_HEIGHT,
    RTI_KEY_SAMPLES,
    RTI_KEY_SEED,
    RTI_KEY_DEPTH,
    RTI_KEY_FILTER,
    RTI_KEY_FILTER_WIDTH,
    RTI_KEY_SHADOWS,
    RTI_KEY_SHADOW_SAMPLES,
    RTI_KEY_OPAQUE_SHADOWS,
    RTI_KEY_AO_SAMPLES,
    RTI_KEY_AO_DISTANCE,
    RTI_KEY_CROP_X,
    RTI_KEY_CROP_Y,
    RTI_KEY_CROP_WIDTH,
    RTI_KEY_CROP_HEIGHT,
    RTI_KEY_ROULETTE,
    RTI_KEY_COUNT
};

/* All that decides the picture's bits. Every setting of rt_render_desc that does belongs here. */
typedef struct rti_check_key {
    char version[32];
    char integrator[16];
    char tracer[16]; /* of views that show the tracer's work; else empty */
    uint64_t value[RTI_KEY_COUNT];
} rti_check_key;

typedef struct rti_check_counts {
    double seconds;
    uint64_t rays[RTK_KIND_COUNT];
    uint64_t nodes, tests, clamped, dropped;
} rti_check_counts;

typedef struct rti_check_head {
    char magic[8];
    uint32_t order, head_size;
    rti_check_key key;
    rti_check_counts counts;
    uint64_t file_size;
    uint32_t tile; /* edge */
    uint32_t done_count, partial_count, pad;
} rti_check_head;

/* An unfinished tile: where its camera rays go on, and film[width * height * RTK_FILM_CHANNELS]. */
typedef struct rti_check_partial {
    uint32_t tile, group_x, group_y, sample;
    uint64_t *film;
} rti_check_partial;

void rti_check_key_of(rti_check_key *key, const rti_snapshot *snapshot, const rti_settings *set);
/* OK, or STATE with a sentence that says what differs; name: of the file, escaped. */
rt_status rti_check_key_compare(rt_context *ctx, const char *name, const rti_check_key *file, const rti_check_key *job);

/* Writes the file aside and renames it, on disk when it returns. head's sizes and counts are filled in here; done: tiles whose
 * pixels stand in the frame's image. */
rt_status rti_check_write(const rti_place *place, const rti_frame *frame, rti_check_head *head, const uint32_t *done,
                          const rti_check_partial *partials);

/* An open file that was found whole: sizes, checksum and key are right. Contents are read after the frame was planned with its
 * edge of tiles. */
typedef struct rti_check_file {
    rt_context *ctx;
    rti_reader *reader;
    char name[300];
    rti_check_head head;
} rti_check_file;
/* Errors: IO, FORMAT (no checkpoint, damaged), STATE (of something else). */
rt_status rti_check_open(const rti_place *place, const rti_check_key *key, rti_check_file *file);
/* The head alone, unchecked but for its mark: false when there is none. */
bool rti_check_peek(const rti_place *place, rti_check_head *head);
/* The finished tiles: indices to done[head.done_count], pixels into the frame's image; and the unfinished ones, whose films are
 * allocated (free each with rti_check_free_partials). */
rt_status rti_check_load(rti_check_file *file, const rti_frame *frame, uint32_t *done, rti_check_partial *partials);
void rti_check_free_partials(rt_context *ctx, const rti_frame *frame, rti_check_partial *partials, uint32_t count);
void rti_check_close(rti_check_file *file);
size_t rti_check_film_bytes(const rti_frame *frame, uint32_t tile);

#endif
