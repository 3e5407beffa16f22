/* Times the entrants on one set of rays, repeats interleaved, and holds their answers against each other. */
#include "rays.h"

#include <math.h>
#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { PASSES_MOST = 100000 };

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

double bench_median(double *values, uint32_t count)
{
    if (count == 0)
        return -1;
    qsort(values, count, sizeof *values, by_value);
    return count % 2 ? values[count / 2] : 0.5 * (values[count / 2 - 1] + values[count / 2]);
}

bench_row *bench_row_add(bench_rows *rows)
{
    if (rows->count == rows->capacity) {
        uint32_t capacity = rows->capacity ? 2 * rows->capacity : 64;
        bench_row *list = realloc(rows->list, capacity * sizeof *list);
        if (!list)
            return NULL;
        rows->list = list;
        rows->capacity = capacity;
    }
    memset(&rows->list[rows->count], 0, sizeof *rows->list);
    return &rows->list[rows->count++];
}

/* ---- one pass over the set ---- */

typedef struct pass {
    bench_entrant *entrant;
    const bench_rays *rays;
    void *scratch;
    size_t grab;
    uint32_t threads;
    atomic_size_t next;
    atomic_uint ready, done;
    atomic_bool go;
} pass;

typedef struct worker {
    pass *pass;
    pthread_t thread;
    double cpu;
} worker;

static double cpu_thread(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* The next rays for a thread; returns how many. Of several threads each takes less towards the end, so that they end together. */
static size_t take(pass *p, size_t *first)
{
    size_t n;
    *first = atomic_load_explicit(&p->next, memory_order_relaxed);
    do {
        const size_t left = p->rays->count > *first ? p->rays->count - *first : 0;
        n = p->grab;
        if (p->threads > 1) {
            const size_t share = left / (2 * p->threads) / 16 * 16;
            n = share >= n ? n : share > 1024 ? share : n < 1024 ? n : 1024;
        }
        n = left < n ? left : n;
    } while (n != 0 &&
             !atomic_compare_exchange_weak_explicit(&p->next, first, *first + n, memory_order_relaxed, memory_order_relaxed));
    return n;
}

static double work(pass *p)
{
    double cpu = cpu_thread();
    size_t first, n;
    while ((n = take(p, &first)) != 0)
        p->entrant->trace(p->entrant, p->rays, p->scratch, first, n);
    cpu = cpu_thread() - cpu;
    atomic_fetch_add(&p->done, 1);
    return cpu;
}

static void *helper(void *data)
{
    worker *w = data;
    atomic_fetch_add(&w->pass->ready, 1);
    while (!atomic_load(&w->pass->go))
        sched_yield();
    w->cpu = work(w->pass);
    return NULL;
}

/* Wall seconds and the threads' CPU seconds of one pass; false: a thread could not be had. */
static bool run_pass(pass *p, uint32_t threads, double *wall, double *cpu)
{
    worker workers[256];
    uint32_t started = 1;
    p->threads = threads;
    p->entrant->prepare(p->entrant, p->rays, p->scratch);
    atomic_store(&p->next, 0);
    atomic_store(&p->ready, 0);
    atomic_store(&p->done, 0);
    atomic_store(&p->go, false);
    for (; started < threads; started++) {
        workers[started] = (worker){.pass = p};
        if (pthread_create(&workers[started].thread, NULL, helper, &workers[started]) != 0)
            break;
    }
    while (atomic_load(&p->ready) < started - 1)
        sched_yield();
    *wall = -bench_wall();
    atomic_store(&p->go, true);
    *cpu = work(p);
    while (atomic_load(&p->done) < started)
        sched_yield();
    *wall += bench_wall();
    for (uint32_t i = 1; i < started; i++) {
        pthread_join(workers[i].thread, NULL);
        *cpu += workers[i].cpu;
    }
    return started == threads;
}

/* ---- the ceiling: as many processes of one thread, at the same time ---- */

typedef struct gate {
    atomic_uint ready;
    atomic_bool go;
    double rate[256];
} gate;

static void process(pass *p, gate *g, uint32_t index, uint32_t passes)
{
    double wall, cpu, sum = 0;
    run_pass(p, 1, &wall, &cpu); /* warm, and the pages are its own */
    atomic_fetch_add(&g->ready, 1);
    while (!atomic_load(&g->go))
        sched_yield();
    for (uint32_t i = 0; i < passes; i++) {
        run_pass(p, 1, &wall, &cpu);
        sum += wall;
    }
    g->rate[index] = (double)p->rays->count * passes / sum / 1e6;
}

static double ceiling(pass *p, uint32_t count, uint32_t passes)
{
    gate *g = mmap(NULL, sizeof *g, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    pid_t children[256];
    double sum = 0;
    uint32_t started = 0;
    if (g == MAP_FAILED)
        return 0;
    fflush(NULL);
    for (; started < count; started++) {
        children[started] = fork();
        if (children[started] < 0)
            break;
        if (children[started] == 0) {
            process(p, g, started, passes);
            _exit(0);
        }
    }
    while (started == count && atomic_load(&g->ready) < count)
        sched_yield();
    atomic_store(&g->go, true);
    for (uint32_t i = 0; i < started; i++) {
        int status;
        if (waitpid(children[i], &status, 0) != children[i] || status != 0)
            started = 0;
    }
    for (uint32_t i = 0; i < count && started == count; i++)
        sum += g->rate[i];
    munmap(g, sizeof *g);
    return sum;
}

/* ---- answers ---- */

typedef struct answers {
    rt_hit *hits;
    uint8_t *occluded;
} answers;

static uint64_t fold(uint64_t hash, const void *data, size_t size)
{
    for (size_t i = 0; i < size; i++)
        hash = (hash ^ ((const uint8_t *)data)[i]) * 0x100000001b3u;
    return hash;
}

static void count_hits(const bench_rays *rays, const answers *a, bench_row *row)
{
    row->checksum = 0xcbf29ce484222325u;
    for (size_t i = 0; i < rays->count; i++) {
        if (rays->any) {
            row->hits += a->occluded[i];
            row->checksum = fold(row->checksum, &a->occluded[i], 1);
        } else {
            row->hits += a->hits[i].prim_id != RT_INVALID_ID;
            row->checksum = fold(row->checksum, &a->hits[i].t, sizeof(float));
            row->checksum = fold(row->checksum, &a->hits[i].prim_id, 2 * sizeof(uint32_t)); /* and geom_id */
        }
    }
}

static void compare(const bench_options *o, const bench_rays *rays, const answers *a, const answers *b, bool exact,
                    bench_row *row)
{
    for (size_t i = 0; i < rays->count; i++) {
        const rt_hit *x = rays->any ? NULL : &a->hits[i], *y = rays->any ? NULL : &b->hits[i];
        if (rays->any)
            row->differ_miss += a->occluded[i] != b->occluded[i];
        else if ((x->prim_id == RT_INVALID_ID) != (y->prim_id == RT_INVALID_ID))
            row->differ_miss++;
        else if (x->prim_id != y->prim_id || x->geom_id != y->geom_id || x->inst_id != y->inst_id)
            row->differ_prim++;
        else if (exact ? memcmp(x, y, sizeof *x) != 0
                       : x->prim_id != RT_INVALID_ID && !(fabs((double)x->t - (double)y->t) <= o->tolerance * fabs((double)y->t)))
            row->differ_t++;
    }
    row->differ = row->differ_miss + row->differ_prim + row->differ_t;
}

/* What brute force says of some of the rays, evenly spread. */
static int check_brute(const bench_options *o, const bench_rays *rays, const rt_tracer *brute, bench_rays *some, answers *truth)
{
    size_t n = o->check < rays->count ? o->check : rays->count;
    *some = *rays;
    some->count = n;
    some->rays = malloc((n + 1) * sizeof(rt_ray));
    truth->hits = calloc(n + 1, sizeof(rt_hit));
    truth->occluded = calloc(n + 1, 1);
    if (!some->rays || !truth->hits || !truth->occluded)
        return bench_fail(BENCH_MACHINE, "no memory for the rays that are checked");
    for (size_t i = 0; i < n; i++)
        some->rays[i] = rays->rays[(size_t)((double)i * (double)rays->count / (double)n)];
    if (rays->any)
        rt_tracer_occluded(brute, some->rays, truth->occluded, n, 0);
    else
        rt_tracer_intersect(brute, some->rays, truth->hits, n, 0);
    return BENCH_OK;
}

static void against_brute(const bench_rays *rays, const answers *a, const bench_rays *some, const answers *truth, bench_row *row)
{
    row->brute_rays = some->count;
    for (size_t i = 0; i < some->count; i++) {
        size_t at = (size_t)((double)i * (double)rays->count / (double)some->count);
        if (rays->any)
            row->brute_differ += a->occluded[at] != truth->occluded[i];
        else
            row->brute_differ += memcmp(&a->hits[at], &truth->hits[i], sizeof(rt_hit)) != 0;
    }
}

/* ---- all of it ---- */

typedef struct lane { /* an entrant's repeats */
    double cpu[1000], wall[1000], ceiling[1000];
    uint32_t passes;
} lane;

typedef struct session {
    const bench_options *o;
    const bench_front *front;
    const bench_world *world;
    const bench_rays *rays;
    bench_entrants *entrants;
    bench_rays some;
    answers reference, truth, got;
    void *scratch;
    lane *lanes;
} session;

static bool stopped(const session *s)
{
    return s->front && s->front->stop && s->front->stop(s->front->user);
}

static bool timed(const session *s, pass *p, lane *l, uint32_t threads, uint32_t repeat)
{
    double wall = 0, cpu = 0, w, c;
    for (uint32_t i = 0; i < l->passes; i++) {
        if (!run_pass(p, threads, &w, &c))
            return false;
        wall += w;
        cpu += c;
    }
    l->wall[repeat] = (double)s->rays->count * l->passes / wall / 1e6;
    l->cpu[repeat] = (double)s->rays->count * l->passes / (cpu / threads) / 1e6;
    if (s->o->ceiling && threads > 1 && strcmp(p->entrant->program, "librt") == 0)
        l->ceiling[repeat] = ceiling(p, threads, l->passes);
    return true;
}

static bool warm(const session *s, pass *p, lane *l, uint32_t threads, bench_row *row)
{
    double wall, cpu;
    bool exact = strcmp(p->entrant->program, "librt") == 0;
    if (!run_pass(p, threads, &wall, &cpu))
        return false;
    l->passes = wall > 0 ? (uint32_t)fmin(ceil(s->o->least / wall), PASSES_MOST) : PASSES_MOST;
    l->passes = l->passes > 0 ? l->passes : 1;
    p->entrant->answers(p->entrant, s->rays, s->scratch, s->got.hits, s->got.occluded);
    count_hits(s->rays, &s->got, row);
    compare(s->o, s->rays, &s->got, &s->reference, exact, row);
    if (exact)
        against_brute(s->rays, &s->got, &s->some, &s->truth, row);
    return true;
}

static void spread(double *values, uint32_t n, double *median, double *low, double *high)
{
    *median = bench_median(values, n);
    *low = values[0];
    *high = values[n - 1];
}

static int measure_threads(session *s, uint32_t index, bench_rows *rows)
{
    uint32_t threads = s->o->threads[index], first = rows->count, low_high = s->o->repeats;
    for (uint32_t i = 0; i < s->entrants->count; i++) {
        bench_entrant *e = &s->entrants->list[i];
        pass p = {.entrant = e, .rays = s->rays, .scratch = s->scratch, .grab = s->o->grab};
        bench_row *row = bench_row_add(rows);
        if (!row)
            return bench_fail(BENCH_MACHINE, "out of memory");
        row->entrant = *e;
        if (stopped(s))
            return BENCH_STOPPED;
        if (!warm(s, &p, &s->lanes[i], threads, row))
            return bench_fail(BENCH_MACHINE, "%u threads could not be started", threads);
    }
    for (uint32_t r = 0; r < s->o->repeats; r++) {
        for (uint32_t i = 0; i < s->entrants->count; i++) {
            pass p = {.entrant = &s->entrants->list[i], .rays = s->rays, .scratch = s->scratch, .grab = s->o->grab};
            if (stopped(s))
                return BENCH_STOPPED;
            if (!timed(s, &p, &s->lanes[i], threads, r))
                return bench_fail(BENCH_MACHINE, "%u threads could not be started", threads);
        }
    }
    for (uint32_t i = 0; i < s->entrants->count; i++) {
        bench_row *row = &rows->list[first + i];
        lane *l = &s->lanes[i];
        snprintf(row->scene, sizeof row->scene, "%s", s->world->name);
        snprintf(row->set, sizeof row->set, "%s", s->rays->set);
        row->triangles = s->world->triangles;
        row->width = s->rays->width;
        row->height = s->rays->height;
        row->rays = s->rays->count;
        row->threads = threads;
        row->thread_index = index;
        row->repeats = s->o->repeats;
        spread(l->cpu, low_high, &row->cpu, &row->cpu_low, &row->cpu_high);
        spread(l->wall, low_high, &row->wall, &row->wall_low, &row->wall_high);
        row->ceiling = s->o->ceiling && threads > 1 ? bench_median(l->ceiling, low_high) : 0;
    }
    return BENCH_OK;
}

static int prepare(session *s, const rt_tracer *reference, const rt_tracer *brute)
{
    size_t n = s->rays->count, room = 64;
    for (uint32_t i = 0; i < s->entrants->count; i++) {
        size_t r = s->entrants->list[i].room(s->rays);
        room = r > room ? r : room;
    }
    s->scratch = aligned_alloc(64, (room + 63) / 64 * 64);
    s->lanes = calloc(s->entrants->count + 1, sizeof *s->lanes);
    s->reference.hits = calloc(n + 1, sizeof(rt_hit));
    s->got.hits = calloc(n + 1, sizeof(rt_hit));
    s->reference.occluded = calloc(n + 1, 1);
    s->got.occluded = calloc(n + 1, 1);
    if (!s->scratch || !s->lanes || !s->reference.hits || !s->got.hits || !s->reference.occluded || !s->got.occluded)
        return bench_fail(BENCH_MACHINE, "no memory for %zu rays and their answers", n);
    if (s->rays->any)
        rt_tracer_occluded(reference, s->rays->rays, s->reference.occluded, n, s->rays->hints);
    else
        rt_tracer_intersect(reference, s->rays->rays, s->reference.hits, n, s->rays->hints);
    return check_brute(s->o, s->rays, brute, &s->some, &s->truth);
}

int bench_measure(const bench_options *o, const bench_front *front, const bench_world *world, const bench_rays *rays,
                  bench_entrants *entrants, const rt_tracer *reference, const rt_tracer *brute, bench_rows *rows)
{
    session s = {.o = o, .front = front, .world = world, .rays = rays, .entrants = entrants};
    int status = prepare(&s, reference, brute);
    for (uint32_t i = 0; i < o->thread_count && status == BENCH_OK; i++) {
        uint32_t whole = rows->count;
        status = measure_threads(&s, i, rows);
        if (status != BENCH_OK)
            rows->count = whole; /* begun, not measured */
    }
    free(s.scratch);
    free(s.lanes);
    free(s.reference.hits);
    free(s.reference.occluded);
    free(s.got.hits);
    free(s.got.occluded);
    free(s.truth.hits);
    free(s.truth.occluded);
    free(s.some.rays);
    return status;
}
