/* How frames scale with workers: renders of one scene by 1, 2, 4 ... workers, runs interleaved, beside the machine's ceiling, the
 * summed rate of as many processes of one worker each. A run is one frame that is not timed, for processors and their caches were
 * another's before, and then frames for a tenth of a second, two at least; so are the processes', for longer. CSV on standard
 * output: scene, width, height, samples, workers, runs; seconds, low, high: a frame's wall time, median, least and most of the
 * runs; speedup: of one worker's median; ceiling: the same of the processes; share: speedup / ceiling. SNAPSHOT is a scene that
 * was saved (rt_scene_save, scene:save in Lua). Exit status: 0 done; 1 the scene is at fault; 2 the command line; 3 the machine.
 */
#include <librt/rt.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#define USAGE        "usage: frames SNAPSHOT [WIDTHxHEIGHT [SAMPLES [WORKERS,... [RUNS]]]]\n"
#define WORKERS_MOST 256u
#define COUNTS_MOST  16u
#define RUNS_MOST    999u
#define CEILING_RUNS 3u
#define LEAST        0.25 /* seconds that a process of the ceiling renders at least */
#define RUN_LEAST    0.1  /* and a run */

typedef struct bench {
    rt_context *context;
    rt_scene *scene;
    rt_render_desc desc;
} bench;

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int refuse(const char *what, const char *text, unsigned long low, unsigned long high)
{
    fprintf(stderr, "frames: %s \"%s\": a number from %lu to %lu\n" USAGE, what, text, low, high);
    return 2;
}

/* A number that ends at one of `ends` (which holds '\0' by itself); *text goes behind it. false: there is none in range. */
static bool number(const char **text, const char *ends, unsigned long low, unsigned long high, uint32_t *out)
{
    char *end;
    unsigned long x = **text >= '0' && **text <= '9' ? strtoul(*text, &end, 10) : 0;
    if (x < low || x > high || !strchr(ends, *end))
        return false;
    *out = (uint32_t)x;
    *text = end;
    return true;
}

static void check(const bench *b, rt_status status)
{
    char text[1024];
    if (status == RT_OK)
        return;
    if (b->context)
        rt_context_error(b->context, text, sizeof text);
    fprintf(stderr, "frames: %s\n", b->context ? text : "no memory for a context");
    exit(status == RT_ERROR_MEMORY || status == RT_ERROR_THREAD || status == RT_ERROR_MEMORY_LIMIT ? 3 : 1);
}

static void frame(bench *b, uint32_t workers)
{
    rt_image *image = NULL;
    b->desc.workers = workers;
    check(b, rt_render(b->scene, &b->desc, &image));
    rt_image_destroy(image);
}

/* Seconds a frame of a run. */
static double frames(bench *b, uint32_t workers)
{
    double start, end;
    uint32_t count = 0;
    frame(b, workers);
    start = now();
    do {
        frame(b, workers);
        count++;
        end = now();
    } while (count < 2 || end - start < RUN_LEAST);
    return (end - start) / count;
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

typedef struct gate {
    atomic_uint ready;
    atomic_bool go;
    double rate[WORKERS_MOST];
} gate;

/* In a process of its own. A context's threads do not live there: it renders with one worker, on its own thread. */
static void process(bench *b, gate *g, uint32_t index, uint32_t frames)
{
    double start;
    frame(b, 1); /* its pages are its own then */
    atomic_fetch_add(&g->ready, 1);
    while (!atomic_load(&g->go))
        sched_yield();
    start = now();
    for (uint32_t i = 0; i < frames; i++)
        frame(b, 1);
    g->rate[index] = frames / (now() - start);
}

/* Frames a second of `count` processes together; 0: the system gave fewer. */
static double together(bench *b, uint32_t count, uint32_t frames)
{
    gate *g = mmap(NULL, sizeof *g, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    pid_t children[WORKERS_MOST];
    uint32_t started = 0;
    double sum = 0;
    if (g == MAP_FAILED)
        return 0;
    fflush(NULL);
    for (; started < count; started++) {
        children[started] = fork();
        if (children[started] < 0)
            break;
        if (children[started] == 0) {
            process(b, g, started, frames);
            _exit(0);
        }
    }
    while (started == count && atomic_load(&g->ready) < count)
        sched_yield();
    atomic_store(&g->go, true);
    for (uint32_t i = 0; i < started; i++) {
        int status;
        sum += waitpid(children[i], &status, 0) == children[i] && status == 0 ? g->rate[i] : 0;
    }
    munmap(g, sizeof *g);
    return started == count ? sum : 0;
}

static double ceiling(bench *b, uint32_t workers, double one)
{
    double rates[CEILING_RUNS];
    for (uint32_t i = 0; i < CEILING_RUNS; i++)
        rates[i] = together(b, workers, (uint32_t)(LEAST / one) + 1);
    qsort(rates, CEILING_RUNS, sizeof *rates, compare);
    return rates[CEILING_RUNS / 2] * one;
}

static void measure(bench *b, const char *name, const uint32_t *workers, uint32_t counts, uint32_t runs)
{
    static double seconds[COUNTS_MOST][RUNS_MOST];
    double one = 0;
    for (uint32_t run = 0; run < runs; run++) {
        for (uint32_t k = 0; k < counts; k++)
            seconds[k][run] = frames(b, workers[k]);
    }
    puts("scene,width,height,samples,workers,runs,seconds,low,high,speedup,ceiling,share");
    for (uint32_t k = 0; k < counts; k++) {
        double *s = seconds[k], median, high;
        qsort(s, runs, sizeof *s, compare);
        median = s[runs / 2];
        one = k == 0 ? median : one;
        printf("%s,%u,%u,%u,%u,%u,%.6g,%.6g,%.6g,%.4g,", name, (unsigned)b->desc.width, (unsigned)b->desc.height,
               (unsigned)b->desc.samples, (unsigned)workers[k], (unsigned)runs, median, s[0], s[runs - 1], one / median);
        high = workers[k] == 1 ? 1 : ceiling(b, workers[k], one);
        if (high > 0)
            printf("%.4g,%.4g\n", high, one / median / high);
        else
            puts(",");
        fflush(stdout);
    }
}

int main(int argc, char **argv)
{
    bench b = {NULL, NULL, rt_render_desc_default()};
    rt_context_desc c = rt_context_desc_default();
    uint32_t workers[COUNTS_MOST] = {1}, counts = 1, runs = 5;
    const char *text = argc > 1 ? argv[1] : "", *name;
    if (argc < 2 || argc > 6 || strcmp(text, "--help") == 0 || strcmp(text, "-h") == 0) {
        fputs(USAGE, argc == 2 ? stdout : stderr);
        return argc == 2 ? 0 : 2;
    }
    b.desc.width = 1920;
    b.desc.height = 1080;
    b.desc.samples = 1;
    text = argc > 2 ? argv[2] : "";
    if (argc > 2 &&
        (!number(&text, "x", 1, 16384, &b.desc.width) || *text++ != 'x' || !number(&text, "", 1, 16384, &b.desc.height)))
        return refuse("size", argv[2], 1, 16384);
    text = argc > 3 ? argv[3] : "";
    if (argc > 3 && !number(&text, "", 1, 65536, &b.desc.samples))
        return refuse("samples", argv[3], 1, 65536);
    if (argc > 4) {
        text = argv[4];
        do {
            if (counts == COUNTS_MOST || !number(&text, ",", 2, WORKERS_MOST, &workers[counts++]))
                return refuse("workers (beside 1)", argv[4], 2, WORKERS_MOST);
        } while (*text++ == ',');
    } else {
        for (uint32_t n = 2; n <= rt_cpu_count() && n <= WORKERS_MOST; n *= 2)
            workers[counts++] = n;
    }
    text = argc > 5 ? argv[5] : "";
    if (argc > 5 && !number(&text, "", 1, RUNS_MOST, &runs))
        return refuse("runs", argv[5], 1, RUNS_MOST);
    for (uint32_t k = 0; k < counts; k++)
        c.workers = workers[k] > c.workers ? workers[k] : c.workers;
    check(&b, rt_context_create(&c, &b.context));
    check(&b, rt_scene_load(b.context, argv[1], &b.scene));
    name = strrchr(argv[1], '/') ? strrchr(argv[1], '/') + 1 : argv[1];
    measure(&b, name, workers, counts, runs);
    rt_scene_destroy(b.scene);
    rt_context_destroy(b.context);
    return 0;
}
