/* What the tests of scenes share: contexts that count and can fail, a small scene, one-line adds. */
#ifndef SCENE_KIT_H
#define SCENE_KIT_H

#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "librt/scene.h"

/* Ends the test as skipped where RT_ISA (librt_at_levels) names what does not run here. */
static inline void kit_level(void)
{
    const char *wanted = getenv("RT_ISA");
    if (wanted && strcmp(wanted, rt_isa()) != 0) {
        printf("skipped: RT_ISA is %s, which does not run here\n", wanted);
        exit(77);
    }
}

/* An allocator that counts bytes and can refuse the n-th request. */
typedef struct kit_memory {
    atomic_long blocks, bytes, requests;
    atomic_long fail_at; /* this request fails and all behind it; 0: none */
} kit_memory;

static inline void *kit_allocate(void *user, void *ptr, size_t old_size, size_t new_size)
{
    kit_memory *m = user;
    if (new_size == 0) {
        if (ptr) {
            atomic_fetch_sub(&m->blocks, 1);
            atomic_fetch_sub(&m->bytes, (long)old_size);
        }
        free(ptr);
        return NULL;
    }
    long n = atomic_fetch_add(&m->requests, 1) + 1, at = atomic_load(&m->fail_at);
    if (at && n >= at)
        return NULL;
    void *p = realloc(ptr, new_size);
    if (p) {
        atomic_fetch_add(&m->blocks, ptr ? 0 : 1);
        atomic_fetch_add(&m->bytes, (long)new_size - (long)old_size);
    }
    return p;
}

static inline rt_context *kit_context(kit_memory *memory, uint32_t workers)
{
    rt_context_desc d = rt_context_desc_default();
    rt_context *ctx = NULL;
    d.workers = workers;
    if (memory) {
        d.allocate = kit_allocate;
        d.allocate_user = memory;
    }
    assert_int_equal(rt_context_create(&d, &ctx), RT_OK);
    return ctx;
}

/* The call went well; its sentence otherwise. */
static inline void kit_ok(const rt_context *ctx, rt_status status)
{
    char text[1024];
    if (status == RT_OK)
        return;
    rt_context_error(ctx, text, sizeof text);
    fail_msg("%s: %s", rt_status_name(status), text);
}

static inline void kit_commit(rt_scene *scene)
{
    kit_ok(rt_scene_context(scene), rt_scene_commit(scene, NULL));
}

static inline rt_scene_info kit_info(const rt_scene *scene)
{
    rt_scene_info info;
    assert_int_equal(rt_scene_get_info(scene, &info), RT_OK);
    return info;
}

static inline rt_scene *kit_scene(rt_context *ctx)
{
    rt_scene *scene = NULL;
    assert_int_equal(rt_scene_create(ctx, &scene), RT_OK);
    return scene;
}

/* The calling thread's last sentence holds `part`. */
static inline void kit_says(const rt_context *ctx, const char *part)
{
    char text[1024];
    rt_context_error(ctx, text, sizeof text);
    if (!strstr(text, part))
        fail_msg("expected a sentence with \"%s\", got \"%s\"", part, text);
}

/* The call is refused as an argument, with the sentence. */
#define KIT_REFUSED(ctx, call, sentence)                                                                                         \
    do {                                                                                                                         \
        assert_int_equal(call, RT_ERROR_ARGUMENT);                                                                               \
        kit_says(ctx, sentence);                                                                                                 \
    } while (0)

/* Random numbers, the same everywhere. seed: where the test begins; it is moved on. */
static inline float kit_range(uint32_t *seed, float low, float high)
{
    *seed = *seed * 1664525u + 1013904223u;
    return low + (high - low) * (float)(*seed >> 8) / 16777216.0f;
}

static inline float kit_unit(uint32_t *seed)
{
    return kit_range(seed, 0.0f, 1.0f);
}

/* In a cube from -size to size. */
static inline rt_vec3 kit_vec(uint32_t *seed, float size)
{
    float x = kit_range(seed, -size, size), y = kit_range(seed, -size, size), z = kit_range(seed, -size, size);
    return (rt_vec3){x, y, z};
}

static inline uint32_t kit_sphere(rt_scene *scene, float x, float y, float z, float radius)
{
    rt_sphere_desc d = rt_sphere_desc_default();
    rt_geometry g;
    d.center = (rt_vec3){x, y, z};
    d.radius = radius;
    assert_int_equal(rt_scene_add_sphere(scene, &d, &g), RT_OK);
    return g.id;
}

/* A square of two triangles at height z, from (-size, -size) to (size, size), uvs from 0 to 1. */
static inline rt_status kit_try_square(rt_scene *scene, float size, float z, rt_geometry *g)
{
    float positions[] = {-size, -size, z, size, -size, z, size, size, z, -size, size, z}, uvs[] = {0, 0, 1, 0, 1, 1, 0, 1};
    uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    rt_mesh_desc d = rt_mesh_desc_default();
    d.positions = positions;
    d.vertex_count = 4;
    d.indices = indices;
    d.triangle_count = 2;
    d.uvs = uvs;
    return rt_scene_add_mesh(scene, &d, g);
}

static inline uint32_t kit_square(rt_scene *scene, float size, float z)
{
    rt_geometry g;
    assert_int_equal(kit_try_square(scene, size, z, &g), RT_OK);
    return g.id;
}

static inline rt_ray kit_ray(float ox, float oy, float oz, float dx, float dy, float dz)
{
    return (rt_ray){{ox, oy, oz}, 0.0f, {dx, dy, dz}, 1.0e30f, RT_MASK_ALL};
}

static inline rt_hit kit_hit(const rt_scene *scene, rt_ray ray)
{
    rt_hit hit;
    rt_scene_intersect(scene, &ray, &hit, 1);
    return hit;
}

#endif
