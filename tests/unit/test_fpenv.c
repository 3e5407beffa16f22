/* Callers may compute as they like: under any rounding, with denormals flushed and every trap open, calls give the same bits and
 * leave things as they were. Rays, and all that computes while a scene is described. */
#include <math.h>

#include "scene_kit.h"

#include "librt/draw.h"
#include "librt/trace.h"
#include "base/base.h"

#if defined(__x86_64__) || defined(__i386__)
#include <xmmintrin.h>
#define CONTROL 0xffc0u
/* Down, up, towards zero; denormals count as zero; every trap but that for inexact results; upwards with all of it. */
static const uint32_t environments[] = {0x3f80, 0x5f80, 0x7f80, 0x9fc0, 0x1000, 0xc040};
static uint32_t environment(void)
{
    return _mm_getcsr();
}
static void set_environment(uint32_t env)
{
    _mm_setcsr(env);
}
#else
#include <fenv.h>
#define CONTROL 0xffffffffu
static const uint32_t environments[] = {FE_DOWNWARD, FE_UPWARD, FE_TOWARDZERO};
static uint32_t environment(void)
{
    return (uint32_t)fegetround();
}
static void set_environment(uint32_t env)
{
    fesetround((int)env);
}
#endif

/* Around one call of the library. */
#define UNDER(env, call)                                                                                                         \
    do {                                                                                                                         \
        const uint32_t before = environment();                                                                                   \
        set_environment(env);                                                                                                    \
        call;                                                                                                                    \
        const uint32_t after = environment();                                                                                    \
        set_environment(before);                                                                                                 \
        assert_int_equal(after &CONTROL, (env)&CONTROL);                                                                         \
    } while (0)

/* Numbers that calls are handed. */
typedef struct given {
    rt_vec3 a, b;
    float x;
    rt_transform m, n;
} given;

static given given_of(uint32_t seed)
{
    given g;
    float f[31];
    for (uint32_t i = 0; i < RTI_COUNT(f); i++) {
        seed = seed * 1664525u + 1013904223u;
        f[i] = ((float)(seed >> 8) / 8388608.0f - 1.0f) * (i % 3 ? 1.0f : 37.0f);
    }
    memcpy(&g, f, sizeof g);
    return g;
}
_Static_assert(sizeof(given) == 31 * sizeof(float), "a given is floats");

/* What came of a call: a scene's hash, or numbers. */
typedef struct outcome {
    char text[33];
    float numbers[12];
} outcome;

static void commit(rt_scene *scene, outcome *out)
{
    kit_ok(rt_scene_context(scene), rt_scene_commit(scene, NULL));
    kit_ok(rt_scene_context(scene), rt_scene_hash(scene, out->text));
}

static void plane(rt_scene *scene, const given *g, uint32_t env, outcome *out)
{
    rt_plane_desc d = rt_plane_desc_default();
    rt_status status;
    d.normal = g->a;
    d.u_axis = g->b;
    UNDER(env, status = rt_scene_add_plane(scene, &d, NULL));
    kit_ok(rt_scene_context(scene), status);
    commit(scene, out);
}

static void torus(rt_scene *scene, const given *g, uint32_t env, outcome *out)
{
    rt_torus_desc d = rt_torus_desc_default();
    rt_status status;
    d.axis = g->a;
    d.major_radius = 1;
    d.minor_radius = 0.25f;
    UNDER(env, status = rt_scene_add_torus(scene, &d, NULL));
    kit_ok(rt_scene_context(scene), status);
    commit(scene, out);
}

static void cone(rt_scene *scene, const given *g, uint32_t env, outcome *out)
{
    rt_cone_desc d = rt_cone_desc_default();
    rt_status status;
    d.from = g->a;
    d.to = g->b;
    d.radius0 = 0.3f;
    d.radius1 = 0.2f;
    UNDER(env, status = rt_scene_add_cone(scene, &d, NULL));
    kit_ok(rt_scene_context(scene), status);
    commit(scene, out);
}

static void light(rt_scene *scene, const given *g, uint32_t env, outcome *out)
{
    rt_light_desc d = rt_light_desc_default();
    rt_status status;
    d.type = RT_LIGHT_DIRECTIONAL;
    d.direction = g->a;
    d.color = (rt_vec3){0.1f, 0.3f, 0.7f};
    d.intensity = fabsf(g->x);
    UNDER(env, status = rt_scene_add_light(scene, &d, NULL));
    kit_ok(rt_scene_context(scene), status);
    commit(scene, out);
}

static void camera(rt_scene *scene, const given *g, uint32_t env, outcome *out)
{
    rt_camera_desc d = rt_camera_desc_default(), moved;
    rt_status status, then;
    d.eye = g->a;
    d.look_at = g->b;
    moved = d;
    moved.eye.y += 0.03f;
    moved.look_at.y += 0.04f;
    UNDER(env, status = rt_scene_set_camera(scene, &d));
    UNDER(env, then = rt_scene_set_camera_motion(scene, &moved));
    kit_ok(rt_scene_context(scene), status);
    kit_ok(rt_scene_context(scene), then);
    commit(scene, out);
}

static void frame(rt_scene *scene, const given *g, uint32_t env, outcome *out)
{
    rt_camera_desc d;
    rt_vec3 low, high;
    rt_status status, then;
    kit_sphere(scene, g->a.x, g->b.x, g->b.z, fabsf(g->x) + 0.1f);
    UNDER(env, status = rt_scene_bounds(scene, &low, &high));
    UNDER(env, then = rt_scene_frame_camera(scene, 1.7f));
    kit_ok(rt_scene_context(scene), status);
    kit_ok(rt_scene_context(scene), then);
    kit_ok(rt_scene_context(scene), rt_scene_get_camera(scene, &d));
    memcpy(out->numbers, (rt_vec3[4]){low, high, d.eye, d.look_at}, sizeof out->numbers);
}

static void instance(rt_scene *scene, const given *g, uint32_t env, outcome *out)
{
    rt_context *ctx = rt_scene_context(scene);
    rt_scene *child = kit_scene(ctx);
    rt_instance_desc d = rt_instance_desc_default();
    rt_transform turned;
    rt_status status;
    kit_sphere(child, 0, 0, 0, 1);
    kit_ok(ctx, rt_scene_commit(child, NULL));
    UNDER(env, turned = rt_transform_rotate(g->a, g->x));
    UNDER(env, d.transform = rt_transform_multiply(turned, rt_transform_translate(g->b)));
    d.child = child;
    d.motion = &turned;
    d.motion_count = 1;
    UNDER(env, status = rt_scene_add_instance(scene, &d, NULL));
    kit_ok(ctx, status);
    commit(scene, out);
    rt_scene_destroy(child);
}

static void numbers(rt_scene *scene, const given *g, uint32_t env, outcome *out)
{
    (void)scene;
    rt_transform t;
    UNDER(env, t = rt_transform_multiply(g->m, g->n));
    memcpy(out->numbers, t.m, sizeof t.m);
}

/* A denormal component, which is not to be lost. */
static void tilted(rt_scene *scene, const given *g, uint32_t env, outcome *out)
{
    (void)scene;
    rt_transform t;
    UNDER(env, t = rt_transform_rotate((rt_vec3){1.0f, 1e-40f, 0.0f}, g->x));
    memcpy(out->numbers, t.m, sizeof t.m);
}

static void label(rt_scene *scene, const given *g, uint32_t env, outcome *out)
{
    (void)scene;
    rt_label_desc d = rt_label_desc_default();
    d.size = 5.0f + fabsf(g->x) * 1.7f;
    UNDER(env, rt_label_size("wide\nand long", &d, &out->numbers[0], &out->numbers[1]));
}

static void describing(void **state)
{
    static const struct {
        const char *name;
        void (*call)(rt_scene *scene, const given *g, uint32_t env, outcome *out);
    } calls[] = {{"plane", plane}, {"torus", torus},       {"cone", cone},        {"light", light},   {"camera", camera},
                 {"frame", frame}, {"instance", instance}, {"multiply", numbers}, {"rotate", tilted}, {"label", label}};
    rt_context *ctx = kit_context(NULL, 1);
    const uint32_t standard = environment();
    (void)state;
    for (uint32_t i = 0; i < RTI_COUNT(calls); i++) {
        for (uint32_t seed = 0; seed < 20; seed++) {
            const given g = given_of(seed);
            outcome want = {0};
            for (uint32_t e = 0; e <= RTI_COUNT(environments); e++) {
                rt_scene *scene = kit_scene(ctx);
                outcome got = {0};
                calls[i].call(scene, &g, e == 0 ? standard : environments[e - 1], &got);
                rt_scene_destroy(scene);
                if (e == 0)
                    want = got;
                else if (memcmp(&got, &want, sizeof got) != 0)
                    fail_msg("%s, seed %u: environment %#x gives %s %a %a %a, not %s %a %a %a", calls[i].name, seed,
                             environments[e - 1], got.text, got.numbers[0], got.numbers[1], got.numbers[2], want.text,
                             want.numbers[0], want.numbers[1], want.numbers[2]);
            }
        }
    }
    rt_context_destroy(ctx);
}

/* One ray a call, some, and many. */
static void asking(void **state)
{
    enum { MANY = 300 };
    static rt_ray rays[MANY];
    static rt_hit want[MANY], got[MANY];
    static uint8_t any[MANY];
    const uint32_t counts[] = {1, 3, MANY};
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx);
    rt_tracer *t;
    (void)state;
    kit_square(scene, 1, 0);
    kit_ok(ctx, rt_scene_commit(scene, NULL));
    kit_ok(ctx, rt_tracer_create(scene, NULL, &t));
    for (uint32_t i = 0; i < MANY; i++) /* some run along axes, with components of zero */
        rays[i] = kit_ray(0.003f * (float)i, 0.1f, 1.1f, i % 3 ? 0.0f : 0.01f * (float)(i % 7), 0, i % 2 ? -1.0f : -0.3f);
    rt_tracer_intersect(t, rays, want, MANY, 0);
    for (uint32_t i = 0; i < RTI_COUNT(counts) * RTI_COUNT(environments); i++) {
        const uint32_t n = counts[i % RTI_COUNT(counts)], env = environments[i / RTI_COUNT(counts)];
        for (uint32_t by_scene = 0; by_scene < 2; by_scene++) {
            memset(got, 0, sizeof got);
            memset(any, 2, sizeof any);
            if (by_scene) {
                UNDER(env, rt_scene_intersect(scene, rays, got, n));
                UNDER(env, rt_scene_occluded(scene, rays, any, n));
            } else {
                UNDER(env, rt_tracer_intersect(t, rays, got, n, 0));
                UNDER(env, rt_tracer_occluded(t, rays, any, n, 0));
            }
            assert_memory_equal(got, want, n * sizeof *got);
            for (uint32_t k = 0; k < n; k++)
                assert_int_equal(any[k], want[k].prim_id != RT_INVALID_ID);
        }
    }
    rt_tracer_destroy(t);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(asking), cmocka_unit_test(describing)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
