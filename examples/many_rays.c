/* Asks the library many rays in five ways and says how fast each was: rt_scene_intersect from a plain array, which needs no
 * thought; a tracer object that is told that the rays run alike; the same from blocks of sixteen rays, without a copy;
 * rt_scene_occluded; and the tracer object once for each ray, which is several times slower, as rays share nothing then. All give
 * the same hits. Plain arrays are meant to stay within a tenth of blocks. usage: many_rays [WIDTHxHEIGHT], one ray a pixel */
#include "arguments.h"

#include <math.h>
#include <time.h>

enum { RINGS = 200, ROUND = 400 }; /* a vase of 160,000 triangles */

static void describe(rt_scene *scene)
{
    static float positions[3 * (RINGS + 1) * ROUND];
    static uint32_t indices[6 * RINGS * ROUND];
    rt_mesh_desc mesh = rt_mesh_desc_default();
    uint32_t n = 0;
    for (uint32_t i = 0; i <= RINGS; ++i) {
        float y = (float)i / RINGS, r = 0.4f + 0.2f * sinf(7 * y);
        for (uint32_t k = 0; k < ROUND; ++k) {
            float angle = 6.2831853f * (float)k / ROUND, wave = r * (1 + 0.05f * cosf(24 * angle));
            float *p = positions + 3 * (size_t)(i * ROUND + k);
            p[0] = wave * cosf(angle);
            p[1] = 2 * y - 1;
            p[2] = wave * sinf(angle);
        }
    }
    for (uint32_t i = 0; i < RINGS; ++i) {
        for (uint32_t k = 0; k < ROUND; ++k) {
            uint32_t a = i * ROUND + k, b = i * ROUND + (k + 1) % ROUND, six[6] = {a, b, a + ROUND, b, b + ROUND, a + ROUND};
            memcpy(indices + n, six, sizeof six);
            n += 6;
        }
    }
    mesh.positions = positions;
    mesh.vertex_count = (RINGS + 1) * ROUND;
    mesh.indices = indices;
    mesh.triangle_count = n / 3;
    must(rt_scene_context(scene), rt_scene_add_mesh(scene, &mesh, NULL));
    must(rt_scene_context(scene), rt_scene_commit(scene, NULL));
}

/* One ray a pixel in 4 x 4 tiles, so that sixteen in a row run nearly alike. Sizes are rounded up to whole tiles. */
static size_t fill(rt_ray *rays, uint32_t width, uint32_t height)
{
    size_t n = 0;
    for (uint32_t tile_y = 0; tile_y < height; tile_y += 4) {
        for (uint32_t tile_x = 0; tile_x < width; tile_x += 4) {
            for (uint32_t i = 0; i < 16; ++i) {
                uint32_t column = tile_x + i % 4, row = tile_y + i / 4;
                float x = (float)column + 0.5f, y = (float)row + 0.5f;
                rt_vec3 dir = {(2 * x - (float)width) / (float)height, 1 - 2 * y / (float)height, -2};
                rays[n++] = (rt_ray){{0, 0.1f, 2.4f}, 0, dir, INFINITY, RT_MASK_ALL};
            }
        }
    }
    return n;
}

static double cpu_seconds(void)
{
    return (double)clock() / CLOCKS_PER_SEC;
}

/* Repeats until a fifth of a second has passed; million rays a second. */
#define MEASURE(rate, rays, call)                                                                                                \
    do {                                                                                                                         \
        double from = cpu_seconds(), took = 0;                                                                                   \
        unsigned times = 0;                                                                                                      \
        while (took < 0.2) {                                                                                                     \
            call;                                                                                                                \
            ++times;                                                                                                             \
            took = cpu_seconds() - from;                                                                                         \
        }                                                                                                                        \
        (rate) = (double)(rays)*times / took / 1e6;                                                                              \
    } while (0)

typedef struct memory {
    rt_ray *rays;
    rt_hit *hits, *again, *alone;
    rt_ray_block *in;
    rt_hit_block *out;
    uint8_t *dark;
} memory;

static void *room(size_t size)
{
    void *p = aligned_alloc(64, (size + 63) / 64 * 64); /* blocks are aligned to 64 bytes */
    if (!p)
        must(NULL, RT_ERROR_MEMORY);
    return p;
}

static void into_blocks(const memory *m, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        rt_ray_block *b = &m->in[i / 16];
        const rt_ray *r = &m->rays[i];
        b->org_x[i % 16] = r->org.x, b->org_y[i % 16] = r->org.y, b->org_z[i % 16] = r->org.z;
        b->dir_x[i % 16] = r->dir.x, b->dir_y[i % 16] = r->dir.y, b->dir_z[i % 16] = r->dir.z;
        b->tmin[i % 16] = r->tmin, b->tmax[i % 16] = r->tmax, b->mask[i % 16] = r->mask;
    }
}

/* Nothing here has touched the floating-point environment: the library need not look at it for each ray. */
static void one_by_one(const rt_tracer *tracer, const rt_ray *rays, rt_hit *hits, size_t count)
{
    for (size_t i = 0; i < count; ++i)
        rt_tracer_intersect(tracer, &rays[i], &hits[i], 1, RT_RAYS_DEFAULT_FENV);
}

int main(int argc, char **argv)
{
    arguments a = arguments_take(argc, argv, (arguments){640, 480, NULL});
    size_t most = (size_t)(a.width + 3) * (a.height + 3), blocks = most / 16 + 1, met = 0, differ = 0;
    memory m = {room(most * sizeof *m.rays),
                room(most * sizeof *m.hits),
                room(most * sizeof *m.again),
                room(most * sizeof *m.alone),
                room(blocks * sizeof *m.in),
                room(blocks * sizeof *m.out),
                room(most)};
    rt_context *context = NULL;
    rt_scene *scene = NULL;
    rt_tracer *tracer = NULL;
    double plain, told, block, any, one;
    must(NULL, rt_context_create(NULL, &context));
    must(context, rt_scene_create(context, &scene));
    describe(scene);
    must(context, rt_tracer_create(scene, "auto", &tracer));

    size_t count = fill(m.rays, a.width, a.height);
    uint32_t hints = RT_RAYS_COHERENT | RT_RAYS_COMMON_ORIGIN;
    into_blocks(&m, count);
    MEASURE(plain, count, rt_scene_intersect(scene, m.rays, m.hits, count));
    MEASURE(told, count, rt_tracer_intersect(tracer, m.rays, m.again, count, hints));
    MEASURE(block, count, rt_tracer_intersect_blocks(tracer, m.in, m.out, count, hints));
    MEASURE(any, count, rt_scene_occluded(scene, m.rays, m.dark, count));
    MEASURE(one, count, one_by_one(tracer, m.rays, m.alone, count));
    for (size_t i = 0; i < count; ++i) {
        const rt_hit_block *b = &m.out[i / 16];
        int hit = m.hits[i].prim_id != RT_INVALID_ID;
        met += (size_t)hit;
        differ += memcmp(&m.hits[i], &m.again[i], sizeof(rt_hit)) != 0 || memcmp(&m.hits[i], &m.alone[i], sizeof(rt_hit)) != 0 ||
                  b->t[i % 16] != m.hits[i].t || b->prim_id[i % 16] != m.hits[i].prim_id || m.dark[i] != hit;
    }
    printf("%zu rays, %zu hits, %zu differ\n", count, met, differ);
    printf("million rays a second: scene %.2f, tracer %.2f, blocks %.2f (array / blocks %.2f), any hit %.2f, one by one %.2f\n",
           plain, told, block, told / block, any, one);

    void *all[] = {m.rays, m.hits, m.again, m.alone, m.in, m.out, m.dark};
    for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
        free(all[i]);
    rt_tracer_destroy(tracer);
    rt_scene_destroy(scene);
    rt_context_destroy(context);
    return differ == 0 && met > 0 ? 0 : 1;
}
