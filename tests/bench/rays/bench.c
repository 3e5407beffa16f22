/* The ray benchmark from its options to its tables. */
#include "rays.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

static void note(const bench_options *o, const char *what, const char *scene, const char *set)
{
    char quoted[200];
    if (!o->quiet)
        fprintf(stderr, "%s: %s%s%s %s\n", bench_speaker, bench_quote(quoted, sizeof quoted, scene), set[0] ? " " : "", set,
                what);
}

static int dump(const bench_options *o, const bench_rays *rays)
{
    char path[4096];
    if (!o->dump)
        return BENCH_OK;
    if ((size_t)snprintf(path, sizeof path, "%s/%s-%s.rays", o->dump, rays->scene, rays->set) >= sizeof path)
        return bench_fail(BENCH_USAGE, "--dump: the folder's name is too long");
    return bench_rays_write(path, rays);
}

typedef struct run {
    const bench_options *o;
    const bench_front *front;
    bench_embree *embree;
    bench_rows rows;
} run;

static int measure(run *r, const bench_world *w, bench_rays *rays, bench_entrants *entrants, const rt_tracer *reference,
                   const rt_tracer *brute)
{
    if (rays->count == 0) {
        note(r->o, "has no ray", w->name, rays->set);
        return BENCH_OK;
    }
    note(r->o, "is measured", w->name, rays->set);
    return bench_measure(r->o, r->front, w, rays, entrants, reference, brute, &r->rows);
}

static int sets_of(run *r, const bench_world *w, const bench_source *source, bench_entrants *entrants, const rt_tracer *reference,
                   const rt_tracer *brute)
{
    int status = BENCH_OK;
    for (uint32_t i = 0; i < r->o->file_count && status == BENCH_OK; i++) {
        bench_rays rays;
        status = bench_rays_read(r->o->files[i], &rays);
        if (status == BENCH_OK)
            status = measure(r, w, &rays, entrants, reference, brute);
        bench_rays_free(&rays);
    }
    for (int set = 0; set < BENCH_SETS && r->o->file_count == 0 && status == BENCH_OK; set++) {
        bench_rays rays = {.count = 0};
        if (!bench_names_has(&r->o->sets, bench_set_names[set]))
            continue;
        status = bench_set_make(source, set, &rays);
        if (status == BENCH_OK && rays.count > 0)
            status = dump(r->o, &rays);
        if (status == BENCH_OK)
            status = measure(r, w, &rays, entrants, reference, brute);
        bench_rays_free(&rays);
    }
    return status;
}

static int scene(run *r, const char *name)
{
    bench_world w = {.lent = false};
    bench_source source = {.hits = NULL};
    bench_entrants entrants = {NULL, 0, 0};
    rt_tracer *reference = NULL, *brute = NULL;
    uint32_t first = r->rows.count;
    note(r->o, "is opened", name, "");
    int status = bench_ours_open(r->o, r->front, name, &w, &entrants, &reference, &brute);
    if (status == BENCH_OK && r->embree)
        status = bench_embree_add(r->embree, r->o, &w, &entrants);
    if (status == BENCH_OK)
        status = bench_source_open(&source, r->o, &w, reference);
    if (status == BENCH_OK)
        status = sets_of(r, &w, &source, &entrants, reference, brute);
    if (status == BENCH_OK || r->rows.count > first) /* also the sets that were measured before it was interrupted */
        bench_table_scene(stdout, r->o, &w, &source, &entrants, r->rows.list + first, r->rows.count - first);
    bench_source_close(&source);
    rt_tracer_destroy(reference);
    rt_tracer_destroy(brute);
    if (r->embree)
        bench_embree_drop(r->embree);
    bench_ours_close(&entrants);
    bench_world_close(&w);
    return status;
}

static int write_csv(const bench_options *o, const bench_rows *rows)
{
    char quoted[400];
    FILE *f = fopen(o->output, "w");
    bool ok = f != NULL;
    if (f)
        bench_csv_head(f);
    for (uint32_t i = 0; f && i < rows->count; i++)
        bench_csv_row(f, o, &rows->list[i]);
    if (f && (ferror(f) != 0 || fclose(f) != 0))
        ok = false;
    return ok ? BENCH_OK
              : bench_fail(f ? BENCH_MACHINE : BENCH_FILE, "%s cannot be written: %s",
                           bench_quote(quoted, sizeof quoted, o->output), strerror(errno));
}

int bench_rays_run(const bench_options *o, const bench_front *front)
{
    run r = {o, front, NULL, {NULL, 0, 0}};
    int status = BENCH_OK;
    if (o->embree)
        status = bench_embree_open(&r.embree);
    for (uint32_t i = 0; i < o->scene_count && status == BENCH_OK; i++)
        status = scene(&r, o->scenes[i]);
    if (status == BENCH_OK && (o->embree || o->inputs.count > 1))
        bench_table_ratios(stdout, o, r.rows.list, r.rows.count);
    if (o->output && (status == BENCH_OK || r.rows.count > 0)) { /* what was measured before a failure is not lost */
        const int written = write_csv(o, &r.rows);
        status = status == BENCH_OK ? written : status;
    }
    for (uint32_t i = 0; i < r.rows.count && status == BENCH_OK; i++) {
        const bench_row *row = &r.rows.list[i];
        if (strcmp(row->entrant.program, "librt") == 0 && row->differ + row->brute_differ > 0)
            status = bench_fail(BENCH_NO, "%s %s: hits of %s differ: %llu from the reference, %llu of %llu from brute force",
                                row->scene, row->set, row->entrant.tracer, (unsigned long long)row->differ,
                                (unsigned long long)row->brute_differ, (unsigned long long)row->brute_rays);
    }
    if (fflush(stdout) != 0 && status == BENCH_OK)
        status = bench_fail(BENCH_MACHINE, "standard output cannot be written: %s", strerror(errno));
    bench_embree_close(r.embree);
    free(r.rows.list);
    return status;
}

/* ---- help ---- */

static void wrapped(const char *text, int indent, int width)
{
    int column = indent;
    while (*text) {
        size_t length = strcspn(text, " \n");
        if (column > indent && column + 1 + (int)length > width) {
            printf("\n%*s", indent, "");
            column = indent;
        }
        column += printf("%s%.*s", column > indent ? " " : "", (int)length, text);
        text += length;
        for (; *text == ' ' || *text == '\n'; text++) {
            if (text[0] == '\n' && column > indent) {
                printf(text[1] == '\n' ? "\n\n%*s" : "\n%*s", indent, "");
                column = indent;
            }
        }
    }
    putchar('\n');
}

static void help(void)
{
    puts("usage: rays SCENE... [OPTIONS]\n");
    wrapped("Measures how fast rays are answered: by each tracer of librt and, with --against embree, by Embree, on the same "
            "rays in the same run. A SCENE "
            "is a mesh file (PLY, OBJ, STL), a saved snapshot, or a name: sphere is generated (998,000 triangles), and so are "
            "spheres1k, spheres100k and spheres1m (so many spheres in a box); others are NAME.ply in the folder of scenes.",
            0, 100);
    puts("\nOptions:");
    for (const bench_option *row = bench_option_table; row->name; row++) {
        int n = printf("  %s%s%s", row->name, row->value ? " " : "", row->value ? row->value : "");
        printf("%*s", n < 31 ? 32 - n : 1, "");
        wrapped(row->help, 32, 100);
    }
    putchar('\n');
    wrapped(bench_definitions, 0, 100);
    putchar('\n');
    wrapped(bench_columns, 0, 100);
    puts("\nExit status: 0 done; 1 a scene or file is at fault; 2 the command line; 3 the machine; 4 hits of librt differ from "
         "the reference or from brute force.");
}

int bench_rays_main(int argc, char **argv, const bench_front *front)
{
    bench_options o;
    int status;
    if (front && front->name)
        bench_speaker = front->name;
    status = bench_options_parse(argc, argv, &o);
    if (status == BENCH_OK && o.help)
        help();
    else if (status == BENCH_OK)
        status = bench_rays_run(&o, front);
    bench_options_free(&o);
    return status;
}
