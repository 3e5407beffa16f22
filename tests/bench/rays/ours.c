/* The library's own tracers as entrants, and the time that their trees take. */
#include "rays.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { BRUTE_MOST = 2000 }; /* triangles up to which brute force runs without being named */

typedef struct ours {
    rt_tracer *tracer;
    const rt_scene *scene; /* for the input "scene" */
} ours;

double bench_wall(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

double bench_cpu_process(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

bench_entrant *bench_entrant_add(bench_entrants *all)
{
    if (all->count == all->capacity) {
        uint32_t capacity = all->capacity ? 2 * all->capacity : 32;
        bench_entrant *list = realloc(all->list, capacity * sizeof *list);
        if (!list)
            return NULL;
        all->list = list;
        all->capacity = capacity;
    }
    memset(&all->list[all->count], 0, sizeof *all->list);
    return &all->list[all->count++];
}

static int library(rt_context *ctx, rt_status status)
{
    char sentence[512] = "";
    if (status == RT_OK)
        return BENCH_OK;
    rt_context_error(ctx, sentence, sizeof sentence);
    return bench_fail(status == RT_ERROR_MEMORY || status == RT_ERROR_MEMORY_LIMIT ? BENCH_MACHINE : BENCH_USAGE, "%s", sentence);
}

/* ---- blocks ---- */

static size_t blocks(const bench_rays *rays)
{
    return (rays->count + 15) / 16;
}

static size_t blocks_room(const bench_rays *rays)
{
    return blocks(rays) * (sizeof(rt_ray_block) + (rays->any ? sizeof(uint16_t) : sizeof(rt_hit_block)));
}

static void *behind(void *scratch, const bench_rays *rays)
{
    return (rt_ray_block *)scratch + blocks(rays);
}

static void blocks_prepare(bench_entrant *e, const bench_rays *rays, void *scratch)
{
    rt_ray_block *out = scratch;
    (void)e;
    memset(scratch, 0, blocks_room(rays));
    for (size_t i = 0; i < rays->count; i++) {
        rt_ray_block *b = &out[i / 16];
        const rt_ray *r = &rays->rays[i];
        size_t k = i % 16;
        b->org_x[k] = r->org.x;
        b->org_y[k] = r->org.y;
        b->org_z[k] = r->org.z;
        b->dir_x[k] = r->dir.x;
        b->dir_y[k] = r->dir.y;
        b->dir_z[k] = r->dir.z;
        b->tmin[k] = r->tmin;
        b->tmax[k] = r->tmax;
        b->mask[k] = r->mask;
    }
}

static void blocks_trace(bench_entrant *e, const bench_rays *rays, void *scratch, size_t first, size_t count)
{
    const rt_tracer *t = ((ours *)e->data)->tracer;
    const rt_ray_block *in = (const rt_ray_block *)scratch + first / 16;
    uint32_t hints = strcmp(e->input, "single") == 0 ? 0 : rays->hints;
    if (rays->any)
        rt_tracer_occluded_blocks(t, in, (uint16_t *)behind(scratch, rays) + first / 16, count, hints);
    else
        rt_tracer_intersect_blocks(t, in, (rt_hit_block *)behind(scratch, rays) + first / 16, count, hints);
}

static void blocks_answers(bench_entrant *e, const bench_rays *rays, const void *scratch, rt_hit *hits, uint8_t *occluded)
{
    const void *out = (const rt_ray_block *)scratch + blocks(rays);
    (void)e;
    for (size_t i = 0; i < rays->count; i++) {
        size_t k = i % 16;
        if (rays->any) {
            occluded[i] = (uint8_t)(((const uint16_t *)out)[i / 16] >> k & 1u);
        } else {
            const rt_hit_block *b = (const rt_hit_block *)out + i / 16;
            hits[i] = (rt_hit){b->t[k], b->u[k], b->v[k], b->prim_id[k], b->geom_id[k], b->inst_id[k]};
        }
    }
}

/* ---- plain arrays ---- */

static size_t array_room(const bench_rays *rays)
{
    return rays->count * (sizeof(rt_ray) + (rays->any ? 1 : sizeof(rt_hit)));
}

static void array_prepare(bench_entrant *e, const bench_rays *rays, void *scratch)
{
    (void)e;
    memset(scratch, 0, array_room(rays));
    memcpy(scratch, rays->rays, rays->count * sizeof(rt_ray));
}

static void array_trace(bench_entrant *e, const bench_rays *rays, void *scratch, size_t first, size_t count)
{
    const ours *o = e->data;
    const rt_ray *in = (const rt_ray *)scratch + first;
    void *out = (rt_ray *)scratch + rays->count;
    if (rays->any && o->scene)
        rt_scene_occluded(o->scene, in, (uint8_t *)out + first, count);
    else if (rays->any)
        rt_tracer_occluded(o->tracer, in, (uint8_t *)out + first, count, rays->hints);
    else if (o->scene)
        rt_scene_intersect(o->scene, in, (rt_hit *)out + first, count);
    else
        rt_tracer_intersect(o->tracer, in, (rt_hit *)out + first, count, rays->hints);
}

/* A program computes as C begins, and Embree does not look either. */
static void one_trace(bench_entrant *e, const bench_rays *rays, void *scratch, size_t first, size_t count)
{
    const rt_tracer *t = ((ours *)e->data)->tracer;
    const rt_ray *in = scratch;
    void *out = (rt_ray *)scratch + rays->count;
    if (rays->any)
        for (size_t i = first; i < first + count; i++)
            rt_tracer_occluded(t, in + i, (uint8_t *)out + i, 1, RT_RAYS_DEFAULT_FENV);
    else
        for (size_t i = first; i < first + count; i++)
            rt_tracer_intersect(t, in + i, (rt_hit *)out + i, 1, RT_RAYS_DEFAULT_FENV);
}

static void array_answers(bench_entrant *e, const bench_rays *rays, const void *scratch, rt_hit *hits, uint8_t *occluded)
{
    const void *out = (const rt_ray *)scratch + rays->count;
    (void)e;
    if (rays->any)
        memcpy(occluded, out, rays->count);
    else
        memcpy(hits, out, rays->count * sizeof *hits);
}

/* ---- trees, timed ---- */

typedef struct tree_time {
    char builder[BENCH_NAME], tree[BENCH_NAME];
    bench_build build[BENCH_NAMES];
} tree_time;
typedef struct tree_times {
    tree_time list[4 * BENCH_NAMES];
    uint32_t count;
} tree_times;

static tree_time *time_of(tree_times *all, const char *builder, const char *tree)
{
    tree_time *t;
    for (uint32_t i = 0; i < all->count; i++)
        if (strcmp(all->list[i].builder, builder) == 0 && strcmp(all->list[i].tree, tree) == 0)
            return &all->list[i];
    if (all->count == 4 * BENCH_NAMES)
        return NULL;
    t = &all->list[all->count++];
    memset(t, 0, sizeof *t);
    snprintf(t->builder, sizeof t->builder, "%s", builder);
    snprintf(t->tree, sizeof t->tree, "%s", tree);
    for (uint32_t i = 0; i < BENCH_NAMES; i++)
        t->build[i].seconds = t->build[i].cpu = -1;
    return t;
}

static rt_status commit(const bench_world *w, const char *builder, const char *accel)
{
    rt_commit_desc d = rt_commit_desc_default();
    rt_status status;
    d.builder = builder;
    d.accel = accel;
    status = rt_scene_commit(w->scene, &d);
    return status == RT_ERROR_STATE ? RT_OK : status; /* a loaded snapshot stays as it is */
}

static bool wanted(const bench_options *o, const bench_world *w, const char *name)
{
    if (o->tracers.count > 0)
        return bench_names_has(&o->tracers, name);
    return strcmp(name, "brute") != 0 || w->triangles <= BRUTE_MOST;
}

/* One tree built anew, timed. false: it could not be made, or was not built now. */
static bool time_once(const bench_world *w, const char *builder, const char *tracer, double *seconds, double *cpu, char *tree)
{
    uint64_t before;
    rt_tracer *t = NULL;
    rt_tracer_info info;
    bool built = false;
    if (commit(w, builder, "brute") != RT_OK)
        return false;
    rt_context_drop_kept(w->ctx);
    before = rt_context_work(w->ctx).trees_built;
    *cpu = -bench_cpu_process();
    *seconds = -bench_wall();
    if (rt_tracer_create(w->scene, tracer, &t) == RT_OK) {
        *seconds += bench_wall();
        *cpu += bench_cpu_process();
        rt_tracer_get_info(t, &info);
        snprintf(tree, BENCH_NAME, "%s", info.tree ? info.tree : "");
        built = rt_context_work(w->ctx).trees_built > before;
    }
    rt_tracer_destroy(t);
    return built;
}

static void time_builds(const bench_options *o, const bench_world *w, uint32_t index, tree_times *times)
{
    double seconds[1000], cpu[1000];
    const char *name;
    for (uint32_t b = 0; b < o->builders.count; b++) {
        for (uint32_t i = 0; (name = rt_tracer_at(i, NULL)) != NULL; i++) {
            char tree[BENCH_NAME] = "";
            uint32_t n = 0;
            tree_time *t;
            if (strcmp(name, "auto") == 0 || !wanted(o, w, name))
                continue;
            if (!time_once(w, o->builders.name[b], name, &seconds[0], &cpu[0], tree) || !tree[0])
                continue;
            t = time_of(times, o->builders.name[b], tree);
            if (!t || t->build[index].seconds >= 0) /* another tracer of this tree was first */
                continue;
            while (++n < o->builds)
                if (!time_once(w, o->builders.name[b], name, &seconds[n], &cpu[n], tree))
                    break;
            t->build[index] = (bench_build){bench_median(seconds, n), bench_median(cpu, n), w->workers};
        }
    }
}

static int time_all(const bench_options *o, const bench_front *front, const char *name, const bench_world *world,
                    tree_times *times)
{
    for (uint32_t i = 0; i < o->thread_count && o->builds > 0; i++) {
        if (o->threads[i] == world->workers) {
            time_builds(o, world, i, times);
        } else if (!world->lent) {
            bench_world other;
            int status = bench_world_open(o, front, name, o->threads[i], &other);
            if (status == BENCH_OK)
                time_builds(o, &other, i, times);
            bench_world_close(&other);
            if (status != BENCH_OK)
                return status;
        }
    }
    return BENCH_OK;
}

/* ---- entrants ---- */

static bool same_as_earlier(const bench_entrants *all, const char *tracer, const char *input, const char *tree, uint64_t bytes)
{
    for (uint32_t i = 0; i < all->count; i++) {
        const bench_entrant *e = &all->list[i];
        if (strcmp(e->tracer, tracer) == 0 && strcmp(e->input, input) == 0 && strcmp(e->tree, tree) == 0 && e->bytes == bytes)
            return true;
    }
    return false;
}

static int add_entrant(const bench_options *o, const bench_world *w, uint32_t builder, const char *name, const char *input,
                       tree_times *times, bench_entrants *all)
{
    bool blocks_in = strcmp(input, "blocks") == 0 || strcmp(input, "single") == 0;
    rt_tracer_info info;
    rt_tracer *tracer;
    ours *data;
    bench_entrant *e;
    tree_time *t;
    int status = library(w->ctx, rt_tracer_create(w->scene, name, &tracer));
    if (status != BENCH_OK)
        return status;
    rt_tracer_get_info(tracer, &info);
    if (builder > 0 && same_as_earlier(all, name, input, info.tree ? info.tree : "", info.tree_bytes)) {
        rt_tracer_destroy(tracer); /* this builder makes no other tree for it */
        return BENCH_OK;
    }
    data = calloc(1, sizeof *data);
    e = data ? bench_entrant_add(all) : NULL;
    if (!e) {
        rt_tracer_destroy(tracer);
        free(data);
        return bench_fail(BENCH_MACHINE, "out of memory");
    }
    data->tracer = tracer;
    data->scene = strcmp(input, "scene") == 0 ? w->scene : NULL;
    e->program = "librt";
    snprintf(e->tracer, sizeof e->tracer, "%s", name);
    snprintf(e->quality, sizeof e->quality, "%s", o->builders.name[builder]);
    snprintf(e->input, sizeof e->input, "%s", input);
    snprintf(e->tree, sizeof e->tree, "%s", info.tree ? info.tree : "");
    e->width = info.width;
    e->robust = true;
    e->bytes = info.tree_bytes;
    e->geometry_bytes = info.geometry_bytes;
    e->data = data;
    t = time_of(times, e->quality, e->tree);
    for (uint32_t i = 0; i < BENCH_NAMES; i++)
        e->build[i] = t ? t->build[i] : (bench_build){-1, -1, 0};
    e->room = blocks_in ? blocks_room : array_room;
    e->prepare = blocks_in ? blocks_prepare : array_prepare;
    e->trace = blocks_in ? blocks_trace : (strcmp(input, "one") == 0 ? one_trace : array_trace);
    e->answers = blocks_in ? blocks_answers : array_answers;
    return BENCH_OK;
}

static int add_all(const bench_options *o, const bench_world *w, tree_times *times, bench_entrants *all)
{
    const char *name;
    int status = BENCH_OK;
    for (uint32_t b = o->builders.count; b-- > 0 && status == BENCH_OK;) { /* the first stays committed */
        status = library(w->ctx, commit(w, o->builders.name[b], "auto"));
        for (uint32_t i = 0; status == BENCH_OK && (name = rt_tracer_at(i, NULL)) != NULL; i++) {
            for (uint32_t k = 0; k < o->inputs.count && status == BENCH_OK; k++) {
                bool scene = strcmp(o->inputs.name[k], "scene") == 0;
                if (wanted(o, w, name) && (!scene || (b == 0 && strcmp(name, "auto") == 0)))
                    status = add_entrant(o, w, b, name, o->inputs.name[k], times, all);
            }
        }
    }
    return status;
}

static int check_tracers(const bench_options *o)
{
    for (uint32_t i = 0; i < o->tracers.count; i++) {
        const char *name = NULL;
        char names[512] = "";
        size_t used = 0;
        for (uint32_t k = 0; (name = rt_tracer_at(k, NULL)) != NULL && strcmp(name, o->tracers.name[i]) != 0; k++)
            if (used < sizeof names)
                used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", k ? ", " : "", name);
        if (!name)
            return bench_fail(BENCH_USAGE, "there is no tracer \"%s\"; there are %s", o->tracers.name[i], names);
    }
    return BENCH_OK;
}

int bench_ours_open(const bench_options *o, const bench_front *front, const char *name, bench_world *world, bench_entrants *all,
                    rt_tracer **reference, rt_tracer **brute)
{
    tree_times *times = calloc(1, sizeof *times);
    int status = times ? check_tracers(o) : bench_fail(BENCH_MACHINE, "out of memory");
    if (status == BENCH_OK)
        status = bench_world_open(o, front, name, o->threads[0], world);
    if (status == BENCH_OK && rt_scene_set_tracer(world->scene, "auto") != RT_OK)
        rt_context_drop_kept(world->ctx); /* a loaded snapshot keeps its tracer */
    if (status == BENCH_OK)
        status = time_all(o, front, name, world, times);
    if (status == BENCH_OK)
        status = add_all(o, world, times, all);
    if (status == BENCH_OK)
        status = library(world->ctx, rt_tracer_create(world->scene, o->reference, reference));
    if (status == BENCH_OK)
        status = library(world->ctx, rt_tracer_create(world->scene, "brute", brute));
    free(times);
    return status;
}

void bench_ours_close(bench_entrants *all)
{
    for (uint32_t i = 0; i < all->count; i++) {
        if (strcmp(all->list[i].program, "librt") == 0)
            rt_tracer_destroy(((ours *)all->list[i].data)->tracer);
        free(all->list[i].data);
    }
    free(all->list);
    memset(all, 0, sizeof *all);
}
