/* The generated scenes of spheres: so many, evenly strewn over the box from -1 to 1, the same bits on every machine. */
#include "rays.h"

#include <stdlib.h>
#include <string.h>

static const struct {
    const char *name;
    uint32_t count;
    double radius; /* of the middle one */
} sizes[] = {{"spheres1k", 1000, 0.05}, {"spheres100k", 100000, 0.01}, {"spheres1m", 1000000, 0.004}};

/* splitmix64, in [0, 1). */
static double next(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

bool bench_spheres_named(const char *name)
{
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++)
        if (strcmp(name, sizes[i].name) == 0)
            return true;
    return false;
}

int bench_spheres_add(const char *name, rt_scene *scene, float **balls, uint32_t *count)
{
    size_t i = 0;
    uint64_t state = 0;
    rt_spheres_desc d = rt_spheres_desc_default();
    rt_geometry handle;
    rt_status status = RT_ERROR_MEMORY;
    while (strcmp(name, sizes[i].name) != 0)
        i++;
    *count = sizes[i].count;
    *balls = malloc(4 * sizeof **balls * (size_t)*count);
    float *apart = malloc(4 * sizeof *apart * (size_t)*count);
    for (uint32_t k = 0; *balls && apart && k < *count; k++) {
        float *ball = *balls + 4 * (size_t)k;
        for (int a = 0; a < 3; a++)
            apart[3 * (size_t)k + (size_t)a] = ball[a] = (float)(2 * next(&state) - 1);
        apart[3 * (size_t)*count + k] = ball[3] = (float)(sizes[i].radius * (0.5 + next(&state)));
    }
    if (*balls && apart) {
        d.centers = apart;
        d.radii = apart + 3 * (size_t)*count;
        d.count = *count;
        status = rt_scene_add_spheres(scene, &d, &handle);
    }
    free(apart);
    return status == RT_OK ? BENCH_OK : bench_fail(BENCH_MACHINE, "no memory for the spheres");
}
