/* Embree 3 as an entrant. The library is loaded when it is asked for (of the package its headers alone are needed to compile
 * this); its scenes are made in embree_scenes.c. */
#include "embree.h"

#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>

static bool monitor(void *user, ssize_t bytes, bool post)
{
    (void)post;
    atomic_fetch_add(&((bench_embree *)user)->bytes, bytes);
    return true;
}

static bool load(bench_embree *e)
{
    e->library = dlopen("libembree3.so.3", RTLD_NOW | RTLD_LOCAL);
    if (!e->library) {
        bench_fail(BENCH_MACHINE, "--against embree: libembree3.so.3 cannot be loaded (Debian: libembree3-3): %s", dlerror());
        return false;
    }
#define LOAD(name)                                                                                                               \
    *(void **)(void *)&e->name = dlsym(e->library, #name);                                                                       \
    if (!e->name) {                                                                                                              \
        bench_fail(BENCH_MACHINE, "--against embree: libembree3.so.3 has no " #name);                                            \
        return false;                                                                                                            \
    }
    EMBREE_CALLS(LOAD)
#undef LOAD
    return true;
}

static bool new_device(bench_embree *e, uint32_t threads)
{
    char config[64];
    snprintf(config, sizeof config, "threads=%u", threads);
    e->device = e->rtcNewDevice(config);
    if (e->device)
        e->rtcSetDeviceMemoryMonitorFunction(e->device, monitor, e);
    return e->device != NULL;
}

int bench_embree_open(bench_embree **out)
{
    bench_embree *e = calloc(1, sizeof *e);
    *out = e;
    if (!e)
        return bench_fail(BENCH_MACHINE, "out of memory");
    if (!load(e))
        return BENCH_MACHINE;
    if (!new_device(e, 1))
        return bench_fail(BENCH_MACHINE, "--against embree: it gives no device");
    long version = (long)e->rtcGetDeviceProperty(e->device, RTC_DEVICE_PROPERTY_VERSION);
    snprintf(e->version, sizeof e->version, "%ld.%ld.%ld", version / 10000, version / 100 % 100, version % 100);
    return BENCH_OK;
}

void bench_embree_drop(bench_embree *e)
{
    for (uint32_t i = 0; i < e->scene_count; i++)
        e->rtcReleaseScene(e->scenes[i]);
    e->scene_count = 0;
    bench_embree_geometry_free(&e->geometry);
}

void bench_embree_close(bench_embree *e)
{
    if (!e)
        return;
    if (e->device) {
        bench_embree_drop(e);
        e->rtcReleaseDevice(e->device);
    }
    free(e); /* the library stays loaded: its threads may be at their end still */
}

const char *bench_embree_version(const bench_embree *e)
{
    return e->version;
}

static void time_build(bench_embree *e, const bench_options *o, const char *quality, bool robust, bench_build *build)
{
    double seconds[1000], cpu[1000];
    for (uint32_t i = 0; i < o->builds; i++)
        e->rtcReleaseScene(bench_embree_scene(e, quality, robust, &seconds[i], &cpu[i]));
    build->seconds = bench_median(seconds, o->builds);
    build->cpu = bench_median(cpu, o->builds);
}

/* ---- entrants ---- */

static bool add_mode(const bench_embree *e, const char *mode, const char *quality, bool robust, RTCScene scene, uint64_t bytes,
                     const bench_build *builds, bench_entrants *all)
{
    embree_entrant *data = calloc(1, sizeof *data);
    bench_entrant *x = data ? bench_entrant_add(all) : NULL;
    if (!x) {
        free(data);
        return false;
    }
    *data = (embree_entrant){e, scene};
    x->program = "embree";
    x->data = data;
    snprintf(x->tracer, sizeof x->tracer, "%s", mode);
    snprintf(x->input, sizeof x->input, "%s", mode);
    snprintf(x->quality, sizeof x->quality, "%s", quality);
    snprintf(x->tree, sizeof x->tree, "bvh");
    x->robust = robust;
    x->bytes = bytes;
    memcpy(x->build, builds, BENCH_NAMES * sizeof *builds);
    bench_embree_set_mode(x, mode);
    return true;
}

int bench_embree_add(bench_embree *e, const bench_options *o, const bench_world *w, bench_entrants *all)
{
    bench_build builds[EMBREE_SCENES_MOST][BENCH_NAMES];
    uint32_t n = 0;
    int status = bench_embree_geometry_take(&e->geometry, w);
    if (status != BENCH_OK)
        return status;
    memset(builds, 0, sizeof builds);
    for (uint32_t k = 0; k < o->thread_count; k++) { /* a device's threads are fixed when it is made */
        n = 0;
        e->rtcReleaseDevice(e->device);
        if (!new_device(e, o->threads[k]))
            return bench_fail(BENCH_MACHINE, "--against embree: it gives no device with %u threads", o->threads[k]);
        for (uint32_t q = 0; q < o->qualities.count; q++) {
            for (uint32_t r = 0; r < o->robust.count && n < EMBREE_SCENES_MOST; r++) {
                builds[n][k] = (bench_build){-1, -1, o->threads[k]};
                if (o->builds > 0)
                    time_build(e, o, o->qualities.name[q], strcmp(o->robust.name[r], "on") == 0, &builds[n][k]);
                n++;
            }
        }
    }
    n = 0;
    for (uint32_t q = 0; q < o->qualities.count; q++) {
        for (uint32_t r = 0; r < o->robust.count && n < EMBREE_SCENES_MOST; r++, n++) {
            double seconds, cpu;
            bool robust = strcmp(o->robust.name[r], "on") == 0;
            long long before = atomic_load(&e->bytes);
            RTCScene scene = bench_embree_scene(e, o->qualities.name[q], robust, &seconds, &cpu);
            e->scenes[e->scene_count++] = scene;
            for (uint32_t m = 0; m < o->modes.count; m++)
                if (!add_mode(e, o->modes.name[m], o->qualities.name[q], robust, scene,
                              (uint64_t)(atomic_load(&e->bytes) - before), builds[n], all))
                    return bench_fail(BENCH_MACHINE, "out of memory");
        }
    }
    return e->rtcGetDeviceError(e->device) == RTC_ERROR_NONE ? BENCH_OK
                                                             : bench_fail(BENCH_MACHINE, "--against embree: it reports an error");
}
