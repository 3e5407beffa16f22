/* The ray benchmark: what its files share. A C program (main.c) and `rtray bench rays` are thin fronts of bench_rays(). It uses the public API alone, so that
 * what it measures is what a caller gets. Embree is loaded at run time when it is asked for; nothing links it. */
#ifndef BENCH_RAYS_H
#define BENCH_RAYS_H

#include <librt/rt.h>

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

enum { BENCH_OK = 0, BENCH_FILE = 1, BENCH_USAGE = 2, BENCH_MACHINE = 3, BENCH_NO = 4, BENCH_STOPPED = 130 };

/* ---- messages (options.c) ---- */

extern const char *bench_speaker; /* what it begins with; set once, by bench_rays_main */
/* Says one sentence on standard error and returns status. */
int bench_fail(int status, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Text of a stranger for a message: control characters are shown, it is cut to fit. */
const char *bench_quote(char *buffer, size_t size, const char *text);

/* ---- options (options.c) ---- */

enum { BENCH_NAMES = 16, BENCH_NAME = 32 };
typedef struct bench_names {
    uint32_t count;
    char name[BENCH_NAMES][BENCH_NAME];
} bench_names;
bool bench_names_has(const bench_names *names, const char *name);

typedef struct bench_view {
    double eye[3], at[3], up[3], vfov; /* degrees */
} bench_view;

enum { BENCH_PRIMARY, BENCH_SHADOW, BENCH_DIFFUSE, BENCH_AO, BENCH_RANDOM, BENCH_SETS };
extern const char *const bench_set_names[BENCH_SETS];

typedef struct bench_options {
    bench_names sets, tracers, builders, inputs, modes, qualities, robust; /* tracers.count 0: chosen */
    uint32_t width, height, thread_count, threads[BENCH_NAMES];
    uint32_t grab, repeats, builds, check;
    double least, tolerance;
    char reference[BENCH_NAME];
    bool embree, ceiling, wall, quiet, help, goals; /* goals: the scenes of the goals, unless others are named */
    bool has_light, has_eye, has_at;
    double light[3], reach; /* reach 0: chosen */
    bench_view view;        /* vfov 0: not given */
    uint64_t seed;
    const char *cameras, *folder, *dump, *output, *machine;
    const char **scenes, **files; /* point into argv */
    uint32_t scene_count, file_count;
} bench_options;

/* A row of the option table, for help; name NULL ends it. value NULL: a switch. */
typedef struct bench_option {
    const char *name, *value, *help;
} bench_option;
extern const bench_option bench_option_table[];
/* How the ray sets are made, to the last detail; paragraphs are separated by empty lines. */
extern const char bench_definitions[];
/* What the CSV's columns mean. */
extern const char bench_columns[];

/* argv[0] is not looked at. BENCH_OK, or BENCH_USAGE after a sentence. options->scenes and files are to be freed with bench_options_free. */
int bench_options_parse(int argc, char **argv, bench_options *options);
void bench_options_free(bench_options *options);

/* ---- scenes (world.c, camera.c, sphere.c, spheres.c) ---- */

typedef struct bench_world {
    char name[64];
    rt_context *ctx;
    rt_scene *scene;
    bool lent; /* context and scene are the caller's */
    uint32_t workers;
    bench_view view;
    rt_vec3 low, high; /* of everything finite */
    uint64_t triangles;
    bool plain; /* nothing but triangles of the scene itself */
    float *balls; /* [4 ball_count] x, y, z, radius: all that a generated scene of spheres holds; NULL: another scene */
    uint32_t ball_count;
} bench_world;

/* What a front lends: a scene that it made itself, for names that the benchmark does not read. */
typedef struct bench_front {
    const char *name; /* what messages begin with, "rtray bench rays" */
    void *user;
    /* BENCH_OK with *scene filled or NULL (the benchmark reads the file itself); else a status, after a sentence. */
    int (*open)(void *user, const char *name, rt_scene **scene);
    bool (*stop)(void *user); /* asked between two timed passes; NULL: never */
} bench_front;

/* Opens the named scene, mesh or snapshot with a context of so many workers and commits it. */
int bench_world_open(const bench_options *o, const bench_front *front, const char *name, uint32_t workers, bench_world *world);
void bench_world_close(bench_world *world);
/* The view called name in a file of cameras ({name: {eye, at, up, vfov}}). 1: found, 0: not in it, -1: no such file or broken, after a sentence (an absent file
 * says nothing when `quiet`). */
int bench_camera_find(const char *path, const char *name, bool quiet, bench_view *view);
/* The same of text in memory; why: what is wrong. */
int bench_camera_parse(const char *text, size_t size, const char *name, bench_view *view, char *why, size_t why_size);
/* A sphere of 2 * 1000 * 499 triangles with bumps, added to the scene. */
int bench_sphere_add(rt_scene *scene);
double bench_sin(double x); /* the same bits everywhere */
/* Is it a generated scene of spheres? They are added to a scene, and told: *balls from malloc. */
bool bench_spheres_named(const char *name);
int bench_spheres_add(const char *name, rt_scene *scene, float **balls, uint32_t *count);

/* ---- ray sets (sets.c, rayfile.c) ---- */

typedef struct bench_rays {
    char set[16], scene[64];
    rt_ray *rays;
    size_t count;
    uint32_t width, height; /* 0: not of an image */
    bool any;               /* is there any hit? else: which is the closest? */
    uint32_t hints;         /* RT_RAYS_* */
} bench_rays;

/* Everything that sets are made from. */
typedef struct bench_source {
    const bench_options *o;
    const bench_world *world;
    const rt_tracer *tracer; /* who finds the primary hits */
    rt_vec3 light;
    float reach;
    bench_rays primary;
    rt_hit *hits; /* of the primary rays */
} bench_source;
int bench_source_open(bench_source *s, const bench_options *o, const bench_world *world, const rt_tracer *tracer);
void bench_source_close(bench_source *s);
int bench_set_make(const bench_source *s, int set, bench_rays *out);
void bench_rays_free(bench_rays *rays);

/* Ray files; the format is in rayfile.c. Reading checks everything; why receives a sentence. */
uint64_t bench_rays_hash(const void *data, size_t size); /* of what stands behind a file's first 128 bytes */
bool bench_rays_parse(const void *data, size_t size, bench_rays *out, char *why, size_t why_size);
int bench_rays_read(const char *path, bench_rays *out);
int bench_rays_write(const char *path, const bench_rays *rays);

/* ---- who answers (ours.c, embree.c, embree_none.c) ---- */

typedef struct bench_build {
    double seconds, cpu; /* medians; < 0: not measured */
    uint32_t threads;
} bench_build;

typedef struct bench_entrant bench_entrant;
struct bench_entrant {
    const char *program;      /* "librt", "embree" */
    char tracer[BENCH_NAME];  /* the tracer; Embree: single, 8, 16, stream */
    char quality[BENCH_NAME]; /* the builder; Embree: medium, high */
    char input[BENCH_NAME];   /* blocks, array; Embree: as its mode */
    char tree[BENCH_NAME];    /* kind of tree, "" without */
    uint32_t width;           /* rays handled together */
    bool robust;
    uint64_t bytes, geometry_bytes;
    bench_build build[BENCH_NAMES]; /* at each thread count of the options */
    void *data;
    size_t (*room)(const bench_rays *rays);                                            /* bytes of scratch */
    void (*prepare)(bench_entrant *e, const bench_rays *rays, void *scratch);          /* not timed */
    void (*trace)(bench_entrant *e, const bench_rays *rays, void *scratch, size_t first, size_t count); /* first: multiple of 16 */
    void (*answers)(bench_entrant *e, const bench_rays *rays, const void *scratch, rt_hit *hits, uint8_t *occluded);
};
/* Room for the rows of our own tracers and of Embree. */
typedef struct bench_entrants {
    bench_entrant *list;
    uint32_t count, capacity;
} bench_entrants;
bench_entrant *bench_entrant_add(bench_entrants *entrants);

int bench_ours_open(const bench_options *o, const bench_front *front, const char *name, bench_world *world, bench_entrants *entrants,
                    rt_tracer **reference, rt_tracer **brute);
void bench_ours_close(bench_entrants *entrants);

typedef struct bench_embree bench_embree;
/* A sentence on standard error and BENCH_MACHINE when it is not there. */
int bench_embree_open(bench_embree **embree);
void bench_embree_close(bench_embree *embree);
const char *bench_embree_version(const bench_embree *embree);
int bench_embree_add(bench_embree *embree, const bench_options *o, const bench_world *world, bench_entrants *entrants);
void bench_embree_drop(bench_embree *embree); /* the scenes of one world */

/* ---- measuring (measure.c), rows (table.c) ---- */

typedef struct bench_row {
    bench_entrant entrant; /* as it was when the row was measured; its data may be gone */
    char scene[64], set[16];
    uint64_t triangles;
    uint32_t width, height, thread_index, threads, repeats;
    size_t rays;
    double cpu, cpu_low, cpu_high; /* million rays a second, by the threads' CPU time: median and spread of the repeats */
    double wall, wall_low, wall_high;
    double ceiling;                /* the summed rate of as many processes; 0: not measured */
    uint64_t hits, checksum;
    uint64_t differ;               /* from the reference, bit for bit; Embree: the sum of the three below */
    uint64_t differ_miss, differ_prim, differ_t;
    uint64_t brute_rays, brute_differ;
} bench_row;
typedef struct bench_rows {
    bench_row *list;
    uint32_t count, capacity;
} bench_rows;
bench_row *bench_row_add(bench_rows *rows);

int bench_measure(const bench_options *o, const bench_front *front, const bench_world *world, const bench_rays *rays,
                  bench_entrants *entrants, const rt_tracer *reference, const rt_tracer *brute, bench_rows *rows);
double bench_median(double *values, uint32_t count); /* sorts */
double bench_wall(void);
double bench_cpu_process(void);

void bench_table_scene(FILE *out, const bench_options *o, const bench_world *world, const bench_source *source, const bench_entrants *entrants,
                       const bench_row *rows, uint32_t count);
void bench_table_ratios(FILE *out, const bench_options *o, const bench_row *rows, uint32_t count);
/* One row for the CSV file. */
void bench_csv_head(FILE *out);
void bench_csv_row(FILE *out, const bench_options *o, const bench_row *row);
/* "xeon-2cores": the processor and its count, as a file's name. */
const char *bench_machine(const bench_options *o);

/* ---- all of it (bench.c) ---- */
int bench_rays_run(const bench_options *o, const bench_front *front);
int bench_rays_main(int argc, char **argv, const bench_front *front); /* parses, helps, runs */

#endif
