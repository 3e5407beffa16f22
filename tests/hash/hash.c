/* usage: test_hash FILE [SAME]. Renders the fixed scenes with every integrator and every arrangement of the work; each must give
 * one hash. Writes "SCENE INTEGRATOR HASH" lines, in a fixed order, to FILE, which must then equal SAME. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../support/many.h"
#include "scenes.h"

typedef struct arrangement {
    const char *tracer;
    uint32_t workers, tile;
    rt_schedule schedule;
} arrangement;

/* The first is the reference, and of costs the first of each tracer, whose are side by side. */
static const arrangement arrangements[] = {
    {"brute", 1, 64, RT_SCHEDULE_DYNAMIC},  {"kdtree", 2, 8, RT_SCHEDULE_DYNAMIC},
#if !TEST_SANITIZED /* which are here for races and accesses, which the others would have, too */
    {"kdtree", 1, 16, RT_SCHEDULE_DYNAMIC}, {"kdtree", 3, 64, RT_SCHEDULE_STATIC}, {"octree", 3, 16, RT_SCHEDULE_DYNAMIC},
#endif
    {"octree", 8, 8, RT_SCHEDULE_STATIC},   {"bvh", 2, 32, RT_SCHEDULE_DYNAMIC},
};

static void fail(const rt_context *context, const char *what)
{
    char sentence[512] = "";
    if (context)
        rt_context_error(context, sentence, sizeof sentence);
    fprintf(stderr, "%s: %s\n", what, sentence);
    exit(1);
}

static void render_hash(rt_scene *scene, const char *integrator, const arrangement *a, char hash[33])
{
    rt_render_desc d = rt_render_desc_default();
    rt_image *image = NULL;
    d.width = 52; /* no multiple of any tile */
    d.height = 37;
    d.samples = 2;
    d.shadow_samples = 2;
    d.ao_samples = 2;
    d.integrator = integrator;
    d.tracer = a->tracer;
    d.workers = a->workers;
    d.tile = a->tile;
    d.schedule = a->schedule;
    if (rt_render(scene, &d, &image) != RT_OK)
        fail(rt_scene_context(scene), integrator);
    rt_image_hash(image, hash);
    rt_image_destroy(image);
}

static int shows_costs(const char *integrator)
{
    return strcmp(integrator, "cost") == 0 || strcmp(integrator, "steps") == 0;
}

/* The integrators "cost" and "steps" show the tracer's own work: it may differ between tracers, never between workers or tiles.
 * Under a sanitizer brute force, by far the slowest, renders these alone: what the others should be, the release's list tells. */
static int one_integrator(rt_scene *scene, const char *name, const char *integrator, FILE *out)
{
    int differing = 0;
    char first[33] = "", hash[33];
    const char *tracer = "";
    for (size_t i = 0; i < sizeof arrangements / sizeof arrangements[0]; ++i) {
        const arrangement *a = &arrangements[i];
        int own = shows_costs(integrator) && strcmp(tracer, a->tracer) != 0;
        if (TEST_SANITIZED && i == 0 && !shows_costs(integrator))
            continue;
        render_hash(scene, integrator, a, hash);
        if (first[0] == '\0' || own) {
            strcpy(first, hash);
            tracer = a->tracer;
            fprintf(out, "%s %s%s%s %s\n", name, integrator, own ? "/" : "", own ? tracer : "", hash);
        } else if (strcmp(first, hash) != 0) {
            fprintf(stderr, "%s, %s: %s with %u workers and tiles of %u gives %s, the reference %s\n", name, integrator,
                    a->tracer, (unsigned)a->workers, (unsigned)a->tile, hash, first);
            ++differing;
        }
    }
    return differing;
}

static int same(const char *one, const char *other)
{
    FILE *a = fopen(one, "r"), *b = fopen(other, "r");
    int x = 0, y = 0;
    while (a && b && x == y && x != EOF) {
        x = fgetc(a);
        y = fgetc(b);
    }
    if (!a || !b || x != y)
        fprintf(stderr, "%s and %s differ\n", one, other);
    if (a)
        fclose(a);
    if (b)
        fclose(b);
    return a && b && x == y;
}

int main(int argc, char **argv)
{
    rt_context_desc cd = rt_context_desc_default();
    rt_context *context = NULL;
    int differing = 0;
    const char *isa = getenv("RT_ISA");
    FILE *out = argc == 2 || argc == 3 ? fopen(argv[1], "w") : NULL;
    if (isa && strcmp(isa, rt_isa()) != 0)
        return fprintf(stderr, "skipped: RT_ISA is %s, which does not run here\n", isa), 77;
    if (!out)
        return fprintf(stderr, "usage: test_hash FILE [SAME] (a file that can be written)\n"), 2;
    cd.workers = 8;
    if (rt_context_create(&cd, &context) != RT_OK)
        fail(NULL, "rt_context_create");
    for (unsigned s = 0; s < hash_scene_count; ++s) {
        rt_scene *scene = NULL, *child = NULL;
        if (rt_scene_create(context, &scene) != RT_OK || rt_scene_create(context, &child) != RT_OK ||
            hash_scenes[s].fill(scene, child) != RT_OK)
            fail(context, hash_scenes[s].name);
        for (uint32_t i = 0; rt_integrator_at(i, NULL); ++i)
            differing += one_integrator(scene, hash_scenes[s].name, rt_integrator_at(i, NULL), out);
        rt_scene_destroy(scene);
        rt_scene_destroy(child);
    }
    rt_context_destroy(context);
    if (fclose(out) != 0)
        fail(NULL, "the list could not be written");
    return differing != 0 || (argc == 3 && !same(argv[1], argv[2]));
}
