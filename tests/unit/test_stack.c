/* The stack that tracing and rendering take of the caller's thread: no more than base.h promises. */
#include <math.h>
#include <pthread.h>

#include "scene_kit.h"

#include "librt/render.h"
#include "librt/trace.h"
#include "support/many.h"

#define PROMISED  ((size_t)96 << 10)
#define STACK     ((size_t)1 << 20)
#define UNTOUCHED 0xa5

enum { MOST = 4099 };

static rt_scene *scene;
static rt_tracer *tracer;
static const char *name;
static size_t count;
static uint32_t hints;
static rt_ray rays[MOST];
static rt_hit hits[MOST];
static uint8_t occluded[MOST];

static void *rest(void *none)
{
    return none;
}

static void *intersect(void *none)
{
    rt_tracer_intersect(tracer, rays, hits, count, hints);
    return none;
}

static void *occlude(void *none)
{
    rt_tracer_occluded(tracer, rays, occluded, count, hints);
    return none;
}

static void *ask_scene(void *none)
{
    rt_scene_intersect(scene, rays, hits, count);
    rt_scene_occluded(scene, rays, occluded, count);
    return none;
}

static void *render(void *none)
{
    rt_render_desc d = rt_render_desc_default();
    rt_image *image = NULL;
    d.width = 96;
    d.height = 64;
    kit_ok(rt_scene_context(scene), rt_render(scene, &d, &image));
    rt_image_destroy(image);
    return none;
}

/* Bytes of its stack that a thread touches. */
static size_t touched(void *(*run)(void *))
{
    unsigned char *stack = aligned_alloc(65536, STACK);
    pthread_attr_t attributes;
    pthread_t thread;
    size_t left = 0;
    assert_non_null(stack);
    memset(stack, UNTOUCHED, STACK);
    assert_int_equal(pthread_attr_init(&attributes), 0);
    assert_int_equal(pthread_attr_setstack(&attributes, stack, STACK), 0);
    assert_int_equal(pthread_create(&thread, &attributes, run, NULL), 0);
    assert_int_equal(pthread_join(thread, NULL), 0);
    pthread_attr_destroy(&attributes);
    while (left < STACK && stack[left] == UNTOUCHED)
        left++;
    free(stack);
    return STACK - left;
}

static void within(const char *what, void *(*run)(void *))
{
    const size_t bytes = touched(run) - touched(rest); /* the least that a thread takes is not the library's */
    if (bytes > PROMISED)
        fail_msg("%s, %s, %zu rays, hints %u: %zu bytes of the stack, and no more than %zu are promised", what, name, count,
                 (unsigned)hints, bytes, PROMISED);
}

static void add_triangles(rt_scene *to, uint32_t n)
{
    rt_mesh_desc d = rt_mesh_desc_default();
    float *p = malloc(9 * n * sizeof *p);
    uint32_t *corners = malloc(3 * n * sizeof *corners);
    for (uint32_t i = 0; i < 9 * n; i++)
        p[i] = (float)(i * 7919u % 1000u) / 700.0f;
    for (uint32_t i = 0; i < 3 * n; i++)
        corners[i] = i;
    d.positions = p;
    d.vertex_count = 3 * n;
    d.indices = corners;
    d.triangle_count = n;
    kit_ok(rt_scene_context(to), rt_scene_add_mesh(to, &d, NULL));
    free(p);
    free(corners);
}

static void add_shapes(rt_scene *to)
{
    for (uint32_t i = 0; i < 60; i++) {
        const float x = 0.1f * (float)(i % 10), y = 0.2f * (float)(i / 10);
        kit_sphere(to, x, y, 0.3f, 0.06f);
    }
}

/* What stands in a scene: triangles, shapes, or both; and how many instances of it, 0: it is the scene's own. */
static void fill(rt_context *ctx, uint32_t what, uint32_t instances)
{
    rt_scene *child = kit_scene(ctx);
    rt_light_desc light = rt_light_desc_default();
    scene = instances ? kit_scene(ctx) : child;
    if (what & 1)
        add_triangles(child, 300);
    if (what & 2)
        add_shapes(child);
    if (instances)
        kit_ok(ctx, rt_scene_commit(child, NULL));
    for (uint32_t i = 0; i < instances; i++) {
        rt_instance_desc d = rt_instance_desc_default();
        d.child = child;
        d.transform = rt_transform_multiply(rt_transform_translate((rt_vec3){(float)(i % 3), 0.3f * (float)(i / 3), 0}),
                                            rt_transform_rotate((rt_vec3){0, 0, 1}, 20.0f * (float)i));
        kit_ok(ctx, rt_scene_add_instance(scene, &d, NULL));
    }
    light.at = (rt_vec3){1, 3, 5};
    kit_ok(ctx, rt_scene_add_light(scene, &light, NULL));
    kit_ok(ctx, rt_scene_commit(scene, NULL));
    if (instances)
        rt_scene_destroy(child);
}

/* Most from one eye, every other run of 64 from anywhere. */
static void aim(void)
{
    for (uint32_t i = 0; i < MOST; i++) {
        const float x = (float)(i % 64) / 32.0f - 0.5f, y = (float)(i / 64) / 32.0f - 0.5f;
        const float from = i / 64 % 2 ? 3.0f * sinf((float)i) : 0.5f;
        rays[i] = kit_ray(from, 0.5f, 5.0f, x - from, y - 0.5f, -5.0f);
    }
}

static void each_way(const char *what)
{
    static const char *const names[] = {"bvh", "kdtree", "octree", "brute"};
    static const size_t counts[] = {1, 15, 31, 300, MOST};
    for (size_t n = 0; n < sizeof names / sizeof *names; n++) {
        name = names[n];
        kit_ok(rt_scene_context(scene), rt_tracer_create(scene, name, &tracer));
        for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
            for (hints = 0; hints <= RT_RAYS_COHERENT; hints += RT_RAYS_COHERENT) {
                count = counts[i];
                within(what, intersect);
                within(what, occlude);
            }
        rt_tracer_destroy(tracer);
    }
    name = "auto";
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        count = counts[i];
        within(what, ask_scene);
    }
    within(what, render);
}

static void test_promise(void **state)
{
    static const char *const words[] = {"", "triangles", "shapes", "triangles and shapes"};
    (void)state;
    if (TEST_SANITIZED) {
        print_message("skipped: sanitizers take stack of their own\n");
        skip();
    }
    aim();
    for (uint32_t what = 1; what < 4; what++)
        for (uint32_t instances = 0; instances < 8; instances += instances ? 6 : 1) {
            rt_context *ctx = kit_context(NULL, 1);
            fill(ctx, what, instances);
            each_way(words[what]);
            rt_scene_destroy(scene);
            rt_context_destroy(ctx);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_promise)};
    kit_level();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
