/* Loads and unloads the library again and again, working in between: nothing of it may stay (threads, maps, memory, signal
 * handlers). */
#include <dirent.h>
#include <dlfcn.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "librt/rt.h"

enum { ROUNDS = 200, WARM = 50 };

static void *need(void *p, const char *what)
{
    if (!p) {
        fprintf(stderr, "missing: %s\n", what);
        exit(1);
    }
    return p;
}

static int thread_count(void)
{
    DIR *dir = need(opendir("/proc/self/task"), "/proc/self/task");
    int count = 0;
    for (struct dirent *e = readdir(dir); e; e = readdir(dir))
        count += e->d_name[0] != '.';
    closedir(dir);
    return count;
}

/* The kernel's entry of a joined thread may outlive the join by a moment. */
static int threads_gone(void)
{
    const struct timespec millisecond = {0, 1000000};
    for (int i = 0; i < 1000 && thread_count() > 1; ++i)
        nanosleep(&millisecond, NULL);
    return thread_count() == 1;
}

static long resident_kib(void)
{
    FILE *f = need(fopen("/proc/self/status", "r"), "/proc/self/status");
    char line[256];
    long kib = -1;
    while (fgets(line, sizeof line, f))
        if (sscanf(line, "VmRSS: %ld", &kib) == 1)
            break;
    fclose(f);
    return kib;
}

typedef struct api {
    rt_context_desc (*context_desc_default)(void);
    rt_status (*context_create)(const rt_context_desc *, rt_context **);
    void (*context_destroy)(rt_context *);
    rt_status (*scene_create)(rt_context *, rt_scene **);
    void (*scene_destroy)(rt_scene *);
    rt_sphere_desc (*sphere_desc_default)(void);
    rt_status (*scene_add_sphere)(rt_scene *, const rt_sphere_desc *, rt_geometry *);
    rt_status (*scene_commit)(rt_scene *, const rt_commit_desc *);
    void (*scene_intersect)(const rt_scene *, const rt_ray *, rt_hit *, size_t);
    rt_render_desc (*render_desc_default)(void);
    rt_status (*render)(rt_scene *, const rt_render_desc *, rt_image **);
    void (*image_destroy)(rt_image *);
} api;

/* A function pointer out of dlsym's object pointer, the way POSIX shows. */
#define LOAD(name) (*(void **)&a->name = need(dlsym(library, "rt_" #name), "rt_" #name))

static void load(void *library, api *a)
{
    LOAD(context_desc_default);
    LOAD(context_create);
    LOAD(context_destroy);
    LOAD(scene_create);
    LOAD(scene_destroy);
    LOAD(sphere_desc_default);
    LOAD(scene_add_sphere);
    LOAD(scene_commit);
    LOAD(scene_intersect);
    LOAD(render_desc_default);
    LOAD(render);
    LOAD(image_destroy);
}

/* A context with threads, a scene, a ray, a picture, all ended. */
static int one_life(const api *a)
{
    rt_context *context = NULL;
    rt_scene *scene = NULL;
    rt_image *image = NULL;
    rt_ray ray = {{0, 0, -3}, 0, {0, 0, 1}, 100, RT_MASK_ALL};
    rt_hit hit = {0};
    rt_context_desc cd = a->context_desc_default();
    rt_sphere_desc sphere = a->sphere_desc_default();
    rt_render_desc render = a->render_desc_default();
    cd.workers = 4;
    sphere.radius = 1.0f;
    render.width = render.height = 32;
    render.tile = 8;
    render.samples = 1;
    int ok = a->context_create(&cd, &context) == RT_OK && a->scene_create(context, &scene) == RT_OK &&
             a->scene_add_sphere(scene, &sphere, NULL) == RT_OK && a->scene_commit(scene, NULL) == RT_OK;
    if (ok) {
        a->scene_intersect(scene, &ray, &hit, 1);
        ok = hit.t == 2.0f && hit.geom_id == 0 && a->render(scene, &render, &image) == RT_OK;
    }
    a->image_destroy(image);
    a->scene_destroy(scene);
    a->context_destroy(context);
    return ok;
}

static int one_round(const char *path)
{
    api a;
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library)
        return fprintf(stderr, "%s\n", dlerror()), 0;
    load(library, &a);
    if (!one_life(&a) || !one_life(&a))
        return fprintf(stderr, "the library did not work\n"), 0;
    dlclose(library);
    if (dlopen(path, RTLD_NOW | RTLD_NOLOAD))
        return fprintf(stderr, "the library stayed loaded\n"), 0;
    if (!threads_gone())
        return fprintf(stderr, "%d threads are left\n", thread_count()), 0;
    return 1;
}

int main(int argc, char **argv)
{
    static struct sigaction before[65];
    struct sigaction after;
    long warm = 0;
    if (argc != 2)
        return 2;
    for (int s = 1; s <= 64; ++s)
        sigaction(s, NULL, &before[s]);
    for (int round = 0; round < ROUNDS; ++round) {
        if (!one_round(argv[1]))
            return fprintf(stderr, "in round %d of %d\n", round + 1, ROUNDS), 1;
        if (round == WARM)
            warm = resident_kib();
    }
    if (resident_kib() > warm + 1024)
        return fprintf(stderr, "memory grew from %ld to %ld KiB in %d rounds\n", warm, resident_kib(), ROUNDS - WARM), 1;
    for (int s = 1; s <= 64; ++s)
        if (sigaction(s, NULL, &after) == 0 && after.sa_handler != before[s].sa_handler)
            return fprintf(stderr, "the handler of signal %d was changed\n", s), 1;
    return 0;
}
