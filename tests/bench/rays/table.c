/* What was measured, as aligned tables and as CSV. */
#include "rays.h"

#include <stdlib.h>
#include <string.h>

const char bench_columns[] =
    "The CSV has a row for each set, entrant and number of threads. machine, cpus; scene, triangles: its own, not those that "
    "instances place; set, width, height, "
    "rays: the size that the set was made for and the number of rays; program: librt or embree; tracer: librt's by name, "
    "Embree's interface; input: blocks, single (blocks without a hint), array, one (a call a ray) or scene, Embree's as its "
    "tracer; builder: of "
    "rt_commit_desc, Embree's quality; robust: 1, Embree's flag; tree, width: kind of tree and rays handled together; "
    "threads, repeats; mrays, mrays_low, mrays_high: million rays a second, rays / (CPU time of the threads / threads), "
    "median, least and most of the repeats; wall_mrays, wall_low, wall_high: the same by wall time; cpu_ns: CPU nanoseconds "
    "a ray; ceiling_mrays: summed wall rate of as many processes, empty without; build_seconds, build_cpu: medians of "
    "building the tree with so many threads, wall and CPU of the process; tree_bytes, bytes_per_triangle (empty without "
    "triangles of the scene's own): of the trees "
    "(librt: beside them geometry_bytes, the triangles as all its tracers read them; Embree: all that its device took for "
    "the scene); hits; checksum: FNV-1a of the answers; differ: answers that are not the reference's, bit for bit (Embree: "
    "the sum of differ_miss, differ_prim and differ_t: hit or miss, another primitive, t beyond the tolerance); brute_rays, "
    "brute_differ: rays that brute force traced too, and other answers than its.";

/* ---- aligned columns ---- */

enum { COLUMNS = 13, WORD = 80 };
typedef struct grid {
    char (*cell)[COLUMNS][WORD];
    uint32_t rows, room;
} grid;

static char (*grid_row(grid *g))[WORD]
{
    if (g->rows == g->room) {
        uint32_t room = g->room ? 2 * g->room : 64;
        void *cell = realloc(g->cell, room * sizeof *g->cell);
        if (!cell)
            return NULL;
        g->cell = cell;
        g->room = room;
    }
    memset(g->cell[g->rows], 0, sizeof *g->cell);
    return g->cell[g->rows++];
}

/* The first `words` columns are words, the others numbers. */
static void grid_print(FILE *out, grid *g, int words)
{
    size_t width[COLUMNS] = {0};
    for (uint32_t i = 0; i < g->rows; i++)
        for (int k = 0; k < COLUMNS; k++)
            width[k] = strlen(g->cell[i][k]) > width[k] ? strlen(g->cell[i][k]) : width[k];
    for (uint32_t i = 0; i < g->rows; i++) {
        int last = COLUMNS - 1;
        while (last > 0 && !g->cell[i][last][0])
            last--;
        for (int k = 0; k <= last; k++)
            fprintf(out, "%*s%s", k < words ? -(int)width[k] : (int)width[k], g->cell[i][k],
                    k < last && width[k] > 0 ? "  " : "");
        fputc('\n', out);
    }
    free(g->cell);
    *g = (grid){NULL, 0, 0};
}

#define PUT(k, ...) (void)snprintf(cells[k], WORD, __VA_ARGS__)

static void heads(char (*cells)[WORD], const char *const *names)
{
    for (int k = 0; names[k] && cells; k++)
        PUT(k, "%s", names[k]);
}

/* ---- a scene ---- */

static void builds(FILE *out, const bench_options *o, const bench_world *w, const bench_entrants *all)
{
    static const char *const names[] = {"program",  "tree",   "builder",   "robust", "threads",
                                        "build ms", "cpu ms", "bytes/tri", NULL};
    grid g = {NULL, 0, 0};
    heads(grid_row(&g), names);
    for (uint32_t i = 0; i < all->count; i++) {
        const bench_entrant *e = &all->list[i];
        bool seen = e->tree[0] == '\0';
        for (uint32_t k = 0; k < i; k++) {
            const bench_entrant *x = &all->list[k];
            seen |= strcmp(x->program, e->program) == 0 && strcmp(x->tree, e->tree) == 0 && strcmp(x->quality, e->quality) == 0 &&
                    x->robust == e->robust;
        }
        for (uint32_t k = 0; k < o->thread_count && !seen; k++) {
            char(*cells)[WORD] = grid_row(&g);
            if (!cells)
                break;
            PUT(0, "%s", e->program);
            PUT(1, "%s", e->tree);
            PUT(2, "%s", e->quality);
            PUT(3, "%s", e->robust ? "yes" : "no");
            PUT(4, "%u", o->threads[k]);
            PUT(7, "%.1f", w->triangles ? (double)e->bytes / (double)w->triangles : 0.0);
            if (e->build[k].threads > 0 && e->build[k].seconds >= 0) {
                PUT(5, "%.1f", 1e3 * e->build[k].seconds);
                PUT(6, "%.1f", 1e3 * e->build[k].cpu);
            }
        }
    }
    grid_print(out, &g, 4);
}

static double rate(const bench_options *o, const bench_row *r)
{
    return o->wall ? r->wall : r->cpu;
}

/* By wall time, over the same entrant's row of the first number of threads. */
static double speed_up(const bench_row *rows, uint32_t count, const bench_row *row)
{
    for (uint32_t i = 0; i < count; i++) {
        const bench_entrant *e = &rows[i].entrant, *x = &row->entrant;
        if (rows[i].thread_index == 0 && strcmp(e->program, x->program) == 0 && strcmp(e->tracer, x->tracer) == 0 &&
            strcmp(e->input, x->input) == 0 && strcmp(e->quality, x->quality) == 0 && e->robust == x->robust && rows[i].wall > 0)
            return row->wall / rows[i].wall;
    }
    return 0;
}

static void set_table(FILE *out, const bench_options *o, const bench_row *rows, uint32_t count)
{
    static const char *const names[] = {"program",    "tracer",     "input", "builder", "robust", "threads", "Mrays/s",
                                        "low - high", "cpu ns/ray", "hits",  "differ",  "brute",  NULL};
    grid g = {NULL, 0, 0};
    heads(grid_row(&g), names);
    for (uint32_t i = 0; i < count; i++) {
        const bench_row *r = &rows[i];
        char(*cells)[WORD] = grid_row(&g);
        if (!cells)
            break;
        PUT(0, "%s", r->entrant.program);
        PUT(1, "%s", r->entrant.tracer);
        PUT(2, "%s", r->entrant.input);
        PUT(3, "%s", r->entrant.quality);
        PUT(4, "%s", r->entrant.robust ? "yes" : "no");
        PUT(5, "%u", r->threads);
        PUT(6, "%.2f", rate(o, r));
        PUT(7, "%.2f - %.2f", o->wall ? r->wall_low : r->cpu_low, o->wall ? r->wall_high : r->cpu_high);
        PUT(8, "%.1f", 1e3 * r->threads / r->cpu);
        PUT(9, "%llu", (unsigned long long)r->hits);
        PUT(10, "%llu", (unsigned long long)r->differ);
        if (r->brute_rays > 0)
            PUT(11, "%llu of %llu", (unsigned long long)r->brute_differ, (unsigned long long)r->brute_rays);
        if (r->ceiling > 0)
            snprintf(cells[5], WORD, "%u (x%.2f, %.3f of %.1f)", r->threads, speed_up(rows, count, r), r->wall / r->ceiling,
                     r->ceiling);
        else if (r->threads > 1)
            snprintf(cells[5], WORD, "%u (x%.2f)", r->threads, speed_up(rows, count, r));
    }
    grid_print(out, &g, 5);
}

void bench_table_scene(FILE *out, const bench_options *o, const bench_world *w, const bench_source *s, const bench_entrants *all,
                       const bench_row *rows, uint32_t count)
{
    fprintf(out, "%s: %llu triangles; light %.9g,%.9g,%.9g; reach %.9g; %s\n\n", w->name, (unsigned long long)w->triangles,
            (double)s->light.x, (double)s->light.y, (double)s->light.z, (double)s->reach, bench_machine(o));
    builds(out, o, w, all);
    for (uint32_t i = 0; i < count;) {
        uint32_t n = 1;
        while (i + n < count && strcmp(rows[i + n].set, rows[i].set) == 0)
            n++;
        fprintf(out, "\n%s %s, %zu rays, million rays a second by %s time, medians of %u\n", w->name, rows[i].set, rows[i].rays,
                o->wall ? "wall" : "CPU", rows[i].repeats);
        set_table(out, o, rows + i, n);
        i += n;
    }
    fputc('\n', out);
}

/* ---- ratios ---- */

/* Which rows a column of the ratio table takes; NULL and 0: any. */
typedef struct pick {
    const char *program, *quality, *not_quality, *tree, *input;
    int robust; /* 1 on, -1 off */
    uint32_t width;
} pick;

static bool picked(const pick *p, const bench_row *r)
{
    const bench_entrant *e = &r->entrant;
    return (!p->program || strcmp(p->program, e->program) == 0) && (!p->quality || strcmp(p->quality, e->quality) == 0) &&
           (!p->not_quality || strcmp(p->not_quality, e->quality) != 0) && (!p->tree || strcmp(p->tree, e->tree) == 0) &&
           (!p->input || strcmp(p->input, e->input) == 0) && (p->robust == 0 || (p->robust > 0) == e->robust) &&
           (!p->width || p->width == e->width);
}

static const bench_row *best(const bench_options *o, const bench_row *rows, uint32_t count, uint32_t thread_index, pick p)
{
    const bench_row *found = NULL;
    for (uint32_t i = 0; i < count; i++)
        if (rows[i].thread_index == thread_index && picked(&p, &rows[i]) && (!found || rate(o, &rows[i]) > rate(o, found)))
            found = &rows[i];
    return found;
}

static void put_rate(char (*cells)[WORD], int k, const bench_options *o, const bench_row *r)
{
    if (r)
        PUT(k, "%.2f %s", rate(o, r), r->entrant.tracer);
}

static void put_ratio(char (*cells)[WORD], int k, const bench_options *o, const bench_row *a, const bench_row *b)
{
    if (a && b && rate(o, b) > 0)
        PUT(k, "%.2f", rate(o, a) / rate(o, b));
}

static void ratio_row(grid *g, const bench_options *o, const bench_row *rows, uint32_t count, uint32_t index)
{
    const char *first = o->builders.name[0];
    const bench_row *ours = best(o, rows, count, index, (pick){.program = "librt", .quality = first});
    const bench_row *high =
        best(o, rows, count, index, (pick){.program = "librt", .not_quality = o->builders.count > 1 ? first : NULL});
    const bench_row *medium = best(o, rows, count, index, (pick){.program = "embree", .quality = "medium", .robust = -1});
    const bench_row *watertight = best(o, rows, count, index, (pick){.program = "embree", .quality = "medium", .robust = 1});
    const bench_row *theirs_high = best(o, rows, count, index, (pick){.program = "embree", .quality = "high", .robust = -1});
    const bench_row *kd = best(o, rows, count, index, (pick){.program = "librt", .tree = "kdtree"});
    const bench_row *kd_single = best(o, rows, count, index, (pick){.program = "librt", .tree = "kdtree", .input = "one"});
    const bench_row *one = best(o, rows, count, index, (pick){.program = "librt", .quality = first, .input = "one"});
    const bench_row *single =
        best(o, rows, count, index, (pick){.program = "embree", .quality = "medium", .robust = -1, .width = 1});
    char(*cells)[WORD] = grid_row(g);
    if (!cells)
        return;
    PUT(0, "%s", rows->scene);
    PUT(1, "%s", rows->set);
    PUT(2, "%u", o->threads[index]);
    put_rate(cells, 3, o, ours);
    put_rate(cells, 4, o, medium);
    put_ratio(cells, 5, o, ours, medium);
    put_ratio(cells, 6, o, high, theirs_high);
    put_ratio(cells, 7, o, ours, watertight);
    put_ratio(cells, 8, o, kd, medium);
    put_ratio(cells, 9, o, kd_single, single);
    put_ratio(cells, 12, o, one, single);
    if (ours) {
        pick same = {.program = "librt", .quality = first, .tree = ours->entrant.tree, .width = ours->entrant.width};
        same.input = "blocks";
        const bench_row *blocks = best(o, rows, count, index, same);
        same.input = "array";
        put_ratio(cells, 10, o, best(o, rows, count, index, same), blocks);
        put_ratio(cells, 11, o, best(o, rows, count, index, (pick){.program = "librt", .input = "scene"}), blocks);
    }
}

void bench_table_ratios(FILE *out, const bench_options *o, const bench_row *rows, uint32_t count)
{
    static const char *const names[] = {"scene",        "set",          "threads",    "librt",     "embree",
                                        "ratio",        "high/HIGH",    "/ROBUST",    "kd/embree", "kd/single",
                                        "array/blocks", "scene/blocks", "one/single", NULL};
    grid g = {NULL, 0, 0};
    if (count == 0)
        return;
    fprintf(out,
            "Best of librt and of Embree (million rays a second by %s time), and ratios: librt's %s / Embree MEDIUM; high / "
            "HIGH; librt's / MEDIUM ROBUST; kd-tree /\n"
            "MEDIUM; the kd-tree, a call for each ray / Embree single; plain arrays / blocks; rt_scene_intersect / blocks; the "
            "best tracer, a "
            "call for each ray / Embree single.\n\n",
            o->wall ? "wall" : "CPU", o->builders.name[0]);
    heads(grid_row(&g), names);
    for (uint32_t i = 0; i < count;) {
        uint32_t n = 1;
        while (i + n < count && strcmp(rows[i + n].set, rows[i].set) == 0 && strcmp(rows[i + n].scene, rows[i].scene) == 0)
            n++;
        for (uint32_t k = 0; k < o->thread_count; k++)
            ratio_row(&g, o, rows + i, n, k);
        i += n;
    }
    grid_print(out, &g, 2);
}

/* ---- CSV ---- */

const char *bench_machine(const bench_options *o)
{
    static char name[128]; /* one thread prints */
    char line[512];
    FILE *f = o->machine ? NULL : fopen("/proc/cpuinfo", "r");
    snprintf(name, sizeof name, "%s", o->machine ? o->machine : "unknown");
    while (f && fgets(line, sizeof line, f)) {
        const char *colon = strncmp(line, "model name", 10) == 0 ? strchr(line, ':') : NULL;
        if (colon) {
            snprintf(name, sizeof name, "%.*s", (int)strcspn(colon + 2, "\n"), colon + 2);
            break;
        }
    }
    if (f)
        fclose(f);
    return name;
}

void bench_csv_head(FILE *out)
{
    fputs("machine,cpus,scene,triangles,set,width,height,rays,program,tracer,input,builder,robust,tree,ray_width,threads,repeats,"
          "mrays,mrays_low,mrays_high,"
          "wall_mrays,wall_low,wall_high,cpu_ns,ceiling_mrays,build_seconds,build_cpu,tree_bytes,bytes_per_triangle,geometry_"
          "bytes,hits,checksum,differ,"
          "differ_miss,differ_prim,differ_t,brute_rays,brute_differ\r\n",
          out);
}

/* RFC 4180: quotes where a comma, a quote or a control character asks for them. */
static void word(FILE *out, const char *text)
{
    bool quote = strpbrk(text, ",\"\r\n") != NULL;
    if (quote)
        fputc('"', out);
    for (; *text; text++) {
        if (*text == '"')
            fputc('"', out);
        fputc(*text, out);
    }
    fputs(quote ? "\"," : ",", out);
}

static void number(FILE *out, double x, bool there)
{
    if (there)
        fprintf(out, "%.6g", x);
    fputc(',', out);
}

void bench_csv_row(FILE *out, const bench_options *o, const bench_row *r)
{
    const bench_entrant *e = &r->entrant;
    const bench_build *b = &e->build[r->thread_index];
    bool built = b->threads > 0 && b->seconds >= 0;
    word(out, bench_machine(o));
    fprintf(out, "%u,", rt_cpu_count());
    word(out, r->scene);
    fprintf(out, "%llu,", (unsigned long long)r->triangles);
    word(out, r->set);
    fprintf(out, "%u,%u,%zu,%s,", r->width, r->height, r->rays, e->program);
    word(out, e->tracer);
    word(out, e->input);
    word(out, e->quality);
    fprintf(out, "%d,%s,%u,%u,%u,", e->robust, e->tree, e->width, r->threads, r->repeats);
    number(out, r->cpu, true);
    number(out, r->cpu_low, true);
    number(out, r->cpu_high, true);
    number(out, r->wall, true);
    number(out, r->wall_low, true);
    number(out, r->wall_high, true);
    number(out, 1e3 * r->threads / r->cpu, true);
    number(out, r->ceiling, r->ceiling > 0);
    number(out, b->seconds, built);
    number(out, b->cpu, built);
    fprintf(out, "%llu,", (unsigned long long)e->bytes);
    number(out, (double)e->bytes / (double)(r->triangles ? r->triangles : 1), r->triangles > 0);
    fprintf(out, "%llu,%llu,%016llx,%llu,%llu,%llu,%llu,%llu,%llu\r\n", (unsigned long long)e->geometry_bytes,
            (unsigned long long)r->hits, (unsigned long long)r->checksum, (unsigned long long)r->differ,
            (unsigned long long)r->differ_miss, (unsigned long long)r->differ_prim, (unsigned long long)r->differ_t,
            (unsigned long long)r->brute_rays, (unsigned long long)r->brute_differ);
}
