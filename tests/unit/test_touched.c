/* Which materials a render looked at: the same set however it is made, and a change of any other leaves every bit. */
#include <stdio.h>

#include "render_scenes.h"

#include "base/base.h"

#define BALLS 12u

static rt_context *ctx;
static uint32_t seed;

static float chance(void)
{
    seed = seed * 1103515245u + 12345u;
    return (float)(seed >> 8 & 0xffffu) / 65536.0f;
}

/* Another look of the same kind: transparent stays so. */
static rt_material_desc look_of(bool transparent)
{
    rt_material_desc d = rt_material_desc_default();
    d.color = v3(chance(), chance(), chance());
    d.diffusion = chance();
    d.reflectiveness = chance() < 0.5f ? 0.0f : 0.4f * chance();
    d.transparency = transparent ? 0.5f : 0.0f;
    d.reflectiveness = transparent ? 0.25f : d.reflectiveness;
    d.refractiveness = 1.0f + chance();
    d.ambient = chance();
    d.specular = chance();
    return d;
}

/* Twelve balls around the camera, of which it sees some, some in mirrors and shadows alone. */
static rt_scene *make_scene(rt_material *m)
{
    rt_scene *s;
    OK(rt_scene_create(ctx, &s));
    for (uint32_t i = 0; i < BALLS; i++) {
        rt_material_desc d = look_of(i % 4 == 0);
        OK(rt_scene_add_material(s, &d, &m[i]));
        add_sphere(s, v3(8 * chance() - 4, 8 * chance() - 4, 8 * chance() - 4), 0.2f + chance(), m[i]);
    }
    add_light(s, light(RT_LIGHT_POINT, v3(5, 6, 4), v3(1, 1, 1), RT_FALLOFF_NONE));
    look(s, v3(0, 0, 6), v3(0, 0, 0), 30);
    OK(rt_scene_commit(s, NULL));
    return s;
}

typedef struct seen {
    char hash[33], rest[33];
    uint8_t touched[BALLS + 1];
} seen;

static seen render_seen(rt_scene *s, rt_render_desc d)
{
    seen out;
    rt_job *job;
    uint32_t count;
    OK(rt_job_start(s, &d, &job));
    assert_int_equal(rt_job_wait(job, -1), RT_JOB_DONE);
    rt_image_hash(rt_job_image(job), out.hash);
    assert_int_equal(rt_job_touched_materials(job, out.touched, BALLS + 1), BALLS + 1); /* the default one, too */
    rt_job_destroy(job);
    OK(rt_scene_looks_hash(s, out.rest, NULL, 0, &count));
    assert_int_equal(count, BALLS + 1);
    return out;
}

static void try_scene(uint32_t number, const char *integrator, uint32_t totals[2])
{
    rt_material m[BALLS];
    seed = number * 7919u + 1;
    rt_scene *s = make_scene(m);
    rt_render_desc d = settings(40, 30, 2, integrator);
    seen first, other;
    char before[BALLS + 1][33], after[BALLS + 1][33];
    d.workers = 1;
    first = render_seen(s, d);
    d.workers = 3;
    d.tile = 8;
    d.tracer = "octree";
    other = render_seen(s, d);
    assert_memory_equal(first.touched, other.touched, sizeof first.touched);
    OK(rt_scene_looks_hash(s, NULL, before, BALLS + 1, NULL));
    for (uint32_t i = 0; i < BALLS; i++) {
        bool used = first.touched[m[i].id];
        rt_material_desc look = look_of(i % 4 == 0);
        totals[used]++;
        if (used)
            continue;
        OK(rt_scene_set_material(s, m[i], &look));
        OK(rt_scene_commit(s, NULL));
        OK(rt_scene_looks_hash(s, NULL, after, BALLS + 1, NULL));
        assert_string_not_equal(before[m[i].id], after[m[i].id]);
        other = render_seen(s, d);
        assert_string_equal(first.rest, other.rest);
        assert_string_equal(first.hash, other.hash);
        assert_memory_equal(first.touched, other.touched, sizeof first.touched);
    }
    for (uint32_t i = 0; i < BALLS; i++) { /* one that was looked at matters */
        rt_material_desc look = rt_material_desc_default();
        if (!first.touched[m[i].id] || i % 4 == 0)
            continue;
        look.color = v3(0.1f, 0.9f, 0.3f);
        look.ambient = 1.0f;
        OK(rt_scene_set_material(s, m[i], &look));
        OK(rt_scene_commit(s, NULL));
        other = render_seen(s, d);
        assert_string_equal(first.rest, other.rest);
        break;
    }
    rt_scene_destroy(s);
}

static void test_untouched_changes_nothing(void **state)
{
    static const char *const integrators[] = {"whitted", "path", "ao", "normal"};
    uint32_t totals[2] = {0, 0};
    (void)state;
    ctx = make_context(2);
    for (uint32_t number = 0; number < 24; number++)
        try_scene(number, integrators[number % 4], totals);
    assert_true(totals[0] > 20 && totals[1] > 20);
    rt_context_destroy(ctx);
}

/* What decides more than a look stands in the rest: letting shadow rays through, and the kind. */
static void test_rest(void **state)
{
    rt_material m[BALLS];
    rt_scene *s;
    rt_material_desc d;
    char a[33], b[33];
    (void)state;
    ctx = make_context(1);
    seed = 5;
    s = make_scene(m);
    OK(rt_scene_looks_hash(s, a, NULL, 0, NULL));
    d = look_of(true);
    OK(rt_scene_set_material(s, m[1], &d));
    OK(rt_scene_commit(s, NULL));
    OK(rt_scene_looks_hash(s, b, NULL, 0, NULL));
    assert_string_not_equal(a, b);
    rt_scene_destroy(s);
    OK(rt_scene_create(ctx, &s));
    assert_int_equal(rt_scene_looks_hash(s, b, NULL, 0, NULL), RT_ERROR_STATE);
    rt_scene_destroy(s);
    rt_context_destroy(ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_untouched_changes_nothing), cmocka_unit_test(test_rest)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
