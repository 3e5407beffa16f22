/* A pixel explained: what its rays brought adds up to the pixel that rt_render gives, in every unit of the film; each ray has its
 * parent, and starts where that one hit. */
#include <stdio.h>

#include "librt/explain.h"
#include "render_scenes.h"

typedef struct told {
    rt_explained_ray *rays;
    size_t count, capacity, stop_at;
} told;

static int keep(void *user, const rt_explained_ray *ray)
{
    told *t = user;
    if (t->count == t->capacity) {
        t->capacity = t->capacity ? 2 * t->capacity : 64;
        t->rays = realloc(t->rays, t->capacity * sizeof *t->rays);
    }
    t->rays[t->count++] = *ray;
    return t->stop_at && t->count == t->stop_at;
}

static rt_explain_desc at(uint32_t x, uint32_t y)
{
    rt_explain_desc e = rt_explain_desc_default();
    e.x = x;
    e.y = y;
    return e;
}

static told explain(rt_scene *s, const rt_render_desc *d, rt_explain_desc e, rt_explained_pixel *pixel)
{
    told t = {0};
    kit_ok(rt_scene_context(s), rt_render_explain(s, d, &e, keep, &t, pixel));
    assert_int_equal(t.count, pixel->rays);
    return t;
}

static void near_vec(rt_vec3 a, rt_vec3 b, float bound)
{
    near_to(a.x, b.x, bound);
    near_to(a.y, b.y, bound);
    near_to(a.z, b.z, bound);
}

/* A ray's place in the tree: behind its parent, of the same sample, from where that one hit. */
static void check_ray(const told *t, size_t i, uint32_t samples)
{
    const rt_explained_ray *r = &t->rays[i], *p;
    assert_int_equal(r->index, i);
    assert_true(r->sample < samples);
    if (r->kind == RT_RAY_CAMERA) {
        assert_int_equal(r->parent, RT_INVALID_ID);
        assert_int_equal(r->depth, 0);
        return;
    }
    assert_true(r->parent < i);
    p = &t->rays[r->parent];
    assert_int_equal(r->sample, p->sample);
    assert_true(p->kind != RT_RAY_SHADOW && p->kind != RT_RAY_AO);
    assert_int_equal(r->depth, p->depth + (r->kind != RT_RAY_SHADOW && r->kind != RT_RAY_AO));
    assert_int_not_equal(p->hit.prim_id, RT_INVALID_ID);
    near_vec(r->ray.org, p->surface.position, 1e-4f * (1 + fabsf(r->ray.org.x) + fabsf(r->ray.org.y) + fabsf(r->ray.org.z)));
    if (r->kind == RT_RAY_SHADOW || r->kind == RT_RAY_AO) {
        assert_int_equal(r->light == RT_INVALID_ID, r->kind == RT_RAY_AO);
        if (!r->arrived)
            assert_true(r->brought[0] == 0 && r->brought[1] == 0 && r->brought[2] == 0);
        assert_int_equal(r->arrived && !r->crossed, r->hit.prim_id == RT_INVALID_ID);
    }
}

static size_t count_kind(const told *t, rt_ray_kind kind)
{
    size_t n = 0;
    for (size_t i = 0; i < t->count; i++)
        n += t->rays[i].kind == kind;
    return n;
}

/* Every pixel of a small image: sums, the tree, and the picture's own bits. */
static void all_pixels(rt_scene *s, const rt_render_desc *d)
{
    rt_image *image = render(s, d);
    uint64_t kinds[6] = {0};
    for (uint32_t i = 0; i < d->width * d->height; i++) {
        uint32_t x = i % d->width, y = i / d->width;
        rt_explained_pixel p;
        told t = explain(s, d, at(x, y), &p);
        int64_t sum[3] = {0};
        assert_memory_equal(p.value, pixel(image, x, y), sizeof p.value);
        for (size_t k = 0; k < t.count; k++) {
            check_ray(&t, k, p.samples);
            for (int c = 0; c < 3; c++)
                sum[c] += t.rays[k].brought[c] + t.rays[k].unshadowed[c];
        }
        assert_int_equal(count_kind(&t, RT_RAY_CAMERA), p.samples);
        for (int c = 0; c < 3 && p.unit > 0; c++) {
            assert_true(sum[c] == p.sum[c]);
            assert_true((float)((double)sum[c] * p.unit / p.samples) == p.value[c]);
        }
        for (uint32_t k = 0; k < 6; k++)
            kinds[k] += count_kind(&t, (rt_ray_kind)k);
        free(t.rays);
    }
    rt_image_destroy(image);
    if (strcmp(d->integrator, "whitted") == 0 && d->max_depth > 0)
        assert_true(kinds[RT_RAY_REFLECT] > 0 && kinds[RT_RAY_REFRACT] > 0 && (kinds[RT_RAY_SHADOW] > 0 || !d->shadows));
    if (strcmp(d->integrator, "path") == 0)
        assert_true(kinds[RT_RAY_DIFFUSE] > 0 && kinds[RT_RAY_SHADOW] > 0);
    if (strcmp(d->integrator, "ao") == 0)
        assert_true(kinds[RT_RAY_AO] > 0 && kinds[RT_RAY_SHADOW] == 0);
}

static void test_every_integrator(void **state)
{
    static const char *const names[] = {"whitted", "path", "ao", "normal", "depth", "cost", "steps"};
    rt_context *ctx = make_context(2);
    rt_scene *s = kit_scene(ctx);
    (void)state;
    add_everything(s);
    kit_ok(ctx, rt_scene_commit(s, NULL));
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        rt_render_desc d = settings(18, 14, 3, names[i]);
        all_pixels(s, &d);
    }
    rt_scene_destroy(s);
    rt_context_destroy(ctx);
}

/* Filters that reach over pixels, hard and tinted shadows, no shadows, instances, textures, other tracers, seeds. */
static void test_settings(void **state)
{
    rt_context *ctx = make_context(1);
    rt_scene *room = kit_scene(ctx), *shapes = kit_scene(ctx), *child = kit_scene(ctx);
    rt_render_desc d = settings(16, 12, 5, "whitted");
    (void)state;
    add_everything(room);
    kit_ok(ctx, rt_scene_commit(room, NULL));
    add_shapes(shapes, child);
    kit_ok(ctx, rt_scene_commit(shapes, NULL));
    d.filter = RT_FILTER_GAUSSIAN;
    d.filter_width = 3;
    d.tracer = "octree";
    all_pixels(room, &d);
    d.shadow_samples = 3;
    d.opaque_shadows = 1;
    d.seed = 99;
    all_pixels(room, &d);
    d.shadows = 0;
    d.tracer = "brute";
    all_pixels(room, &d);
    d = settings(16, 12, 2, "path");
    d.max_depth = 5;
    d.filter_width = 2.5f;
    all_pixels(shapes, &d);
    rt_scene_destroy(shapes);
    rt_scene_destroy(child);
    rt_scene_destroy(room);
    rt_context_destroy(ctx);
}

/* Paths choose a light each: every shadow ray tells its own, also where it stands beside others (check_ray). */
static void test_chosen_lights(void **state)
{
    rt_context *ctx = make_context(1);
    rt_scene *s = kit_scene(ctx);
    rt_render_desc d = settings(18, 14, 100, "path");
    size_t seen[2] = {0};
    (void)state;
    add_everything(s);
    kit_ok(ctx, rt_scene_commit(s, NULL));
    for (uint32_t x = 0; x < 18; x += 3) {
        rt_explained_pixel p;
        told t = explain(s, &d, at(x, 9), &p);
        for (size_t i = 0; i < t.count; i++) {
            check_ray(&t, i, 100);
            if (t.rays[i].kind == RT_RAY_SHADOW) {
                assert_true(t.rays[i].light < 2);
                seen[t.rays[i].light]++;
            }
        }
        free(t.rays);
    }
    assert_true(seen[0] > 100 && seen[1] > 100);
    rt_scene_destroy(s);
    rt_context_destroy(ctx);
}

/* A lens that blurs: every sample has a camera ray of its own. */
static void test_lens(void **state)
{
    rt_context *ctx = make_context(1);
    rt_scene *s = kit_scene(ctx);
    rt_render_desc d = settings(14, 10, 4, "path");
    rt_camera_desc c;
    (void)state;
    add_everything(s);
    OK(rt_scene_get_camera(s, &c));
    c.aperture = 0.3f;
    c.focus_distance = 4;
    OK(rt_scene_set_camera(s, &c));
    kit_ok(ctx, rt_scene_commit(s, NULL));
    all_pixels(s, &d);
    rt_scene_destroy(s);
    rt_context_destroy(ctx);
}

/* Thousands of samples: more rays than a batch holds. */
static void test_many_samples(void **state)
{
    rt_context *ctx = make_context(1);
    rt_scene *s = kit_scene(ctx);
    rt_render_desc d = settings(3, 2, 3000, "whitted");
    (void)state;
    add_everything(s);
    kit_ok(ctx, rt_scene_commit(s, NULL));
    all_pixels(s, &d);
    rt_scene_destroy(s);
    rt_context_destroy(ctx);
}

/* Some samples only: their rays, the same as among all, and the pixel's whole sum. */
static void test_samples(void **state)
{
    rt_context *ctx = make_context(1);
    rt_scene *s = kit_scene(ctx);
    rt_render_desc d = settings(20, 16, 8, "whitted");
    rt_explain_desc e = at(13, 9);
    rt_explained_pixel all, some;
    told a, b;
    size_t n = 0;
    (void)state;
    add_everything(s);
    kit_ok(ctx, rt_scene_commit(s, NULL));
    a = explain(s, &d, e, &all);
    e.first_sample = 3;
    e.sample_count = 2;
    b = explain(s, &d, e, &some);
    assert_memory_equal(all.sum, some.sum, sizeof all.sum);
    assert_memory_equal(all.value, some.value, sizeof all.value);
    for (size_t i = 0; i < a.count; i++) {
        if (a.rays[i].sample != 3 && a.rays[i].sample != 4)
            continue;
        assert_true(n < b.count);
        assert_memory_equal(&a.rays[i].ray, &b.rays[n].ray, sizeof a.rays[i].ray);
        assert_memory_equal(&a.rays[i].brought, &b.rays[n].brought, sizeof a.rays[i].brought);
        n++;
    }
    assert_int_equal(n, b.count);
    assert_true(n > 0 && n < a.count);
    free(a.rays);
    free(b.rays);
    rt_scene_destroy(s);
    rt_context_destroy(ctx);
}

/* A lamp above a floor, one sample: every number is known. */
static void test_known(void **state)
{
    rt_context *ctx = make_context(1);
    rt_scene *s = kit_scene(ctx);
    rt_render_desc d = settings(3, 3, 1, "whitted");
    rt_world_desc w = rt_world_desc_default();
    rt_explained_pixel p;
    rt_material white;
    told t;
    (void)state;
    white = add_material(s, v3(1, 1, 1), 0.5f, 0, 0, 0);
    add_plane(s, v3(0, 0, 0), v3(0, 1, 0), white);
    add_sphere(s, v3(0, 2, 0), 0.25f, white);
    add_light(s, light(RT_LIGHT_POINT, v3(0, 4, 0), v3(1, 1, 1), RT_FALLOFF_NONE));
    add_light(s, light(RT_LIGHT_DIRECTIONAL, v3(0, -1, 0.5f), v3(1, 0.5f, 0), RT_FALLOFF_NONE));
    w.ambient = v3(0, 0, 0);
    w.background = w.background_top = v3(0.25f, 0.5f, 1);
    OK(rt_scene_set_world(s, &w));
    look(s, v3(4, 1, 0), v3(0, 0, 0), 10);
    kit_ok(ctx, rt_scene_commit(s, NULL));
    t = explain(s, &d, at(1, 1), &p);
    assert_int_equal(t.count, 3);
    near_vec(t.rays[0].surface.position, v3(0, 0, 0), 1e-5f);
    near_vec(t.rays[0].surface.ng, v3(0, 1, 0), 1e-6f);
    assert_int_equal(t.rays[0].surface.material.id, white.id);
    assert_int_equal(t.rays[1].light, 0);
    assert_int_equal(t.rays[1].arrived, 0); /* the sphere stands in the way */
    assert_int_equal(t.rays[1].hit.geom_id, 1);
    near_to(t.rays[1].hit.t, 1.75, 1e-4);
    assert_int_equal(t.rays[2].light, 1);
    assert_int_equal(t.rays[2].arrived, 1);
    near_to((double)t.rays[2].brought[0] * p.unit, 0.5 * 2 / sqrt(5), 1e-6);
    near_to((double)t.rays[2].brought[1] * p.unit, 0.25 * 2 / sqrt(5), 1e-6);
    assert_true(t.rays[2].brought[2] == 0);
    assert_true(t.rays[0].cost.tests > 0);
    free(t.rays);
    look(s, v3(4, 1, 0), v3(8, 5, 0), 10);
    kit_ok(ctx, rt_scene_commit(s, NULL));
    t = explain(s, &d, at(0, 2), &p);
    assert_int_equal(t.count, 1);
    assert_int_equal(t.rays[0].hit.prim_id, RT_INVALID_ID);
    assert_int_equal(t.rays[0].surface.material.id, RT_INVALID_ID);
    assert_true((double)t.rays[0].brought[0] * p.unit == 0.25 && p.value[1] == 0.5f && p.value[3] == 0);
    free(t.rays);
    rt_scene_destroy(s);
    rt_context_destroy(ctx);
}

static void test_refused(void **state)
{
    rt_context *ctx = make_context(1);
    rt_scene *s = kit_scene(ctx);
    rt_render_desc d = settings(20, 16, 4, "whitted");
    rt_explain_desc e = at(20, 3);
    told t = {0};
    (void)state;
    assert_int_equal(rt_render_explain(s, &d, &e, keep, &t, NULL), RT_ERROR_STATE);
    add_everything(s);
    kit_ok(ctx, rt_scene_commit(s, NULL));
    assert_int_equal(rt_render_explain(s, &d, &e, keep, &t, NULL), RT_ERROR_ARGUMENT);
    kit_says(ctx, "pixel 20,3 lies outside of the image of 20 x 16; the last one is 19,15");
    e = at(0, 16);
    assert_int_equal(rt_render_explain(s, &d, &e, keep, &t, NULL), RT_ERROR_ARGUMENT);
    e = at(0, 0);
    e.first_sample = 4;
    assert_int_equal(rt_render_explain(s, &d, &e, keep, &t, NULL), RT_ERROR_ARGUMENT);
    kit_says(ctx, "samples 0 ... 3");
    e.struct_size = 0;
    assert_int_equal(rt_render_explain(s, &d, &e, keep, &t, NULL), RT_ERROR_ARGUMENT);
    e = at(0, 0);
    d.integrator = "x";
    assert_int_equal(rt_render_explain(s, &d, &e, keep, &t, NULL), RT_ERROR_ARGUMENT);
    d.integrator = "whitted";
    assert_int_equal(t.count, 0);
    t.stop_at = 2;
    assert_int_equal(rt_render_explain(s, &d, &e, keep, &t, NULL), RT_ERROR_CANCELLED);
    assert_int_equal(t.count, 2);
    kit_ok(ctx, rt_render_explain(s, &d, &e, NULL, NULL, NULL));
    free(t.rays);
    rt_scene_destroy(s);
    rt_context_destroy(ctx);
}

static int count_calls(void *user, float done)
{
    int *calls = user;
    assert_true(done >= 0 && done <= 1);
    return ++*calls == 2;
}

/* 65536 samples with 64 shadow rays a hit: seconds, of which it sees a tenth. */
static void test_ended(void **state)
{
    rt_context *ctx = make_context(1);
    rt_scene *s = kit_scene(ctx);
    rt_render_desc d = settings(20, 16, 65536, "whitted");
    rt_explain_desc e = at(10, 8);
    rt_explained_pixel p;
    told t = {0};
    int calls = 0;
    (void)state;
    add_everything(s);
    kit_ok(ctx, rt_scene_commit(s, NULL));
    d.shadow_samples = 64;
    e.sample_count = 1;
    e.progress = count_calls;
    e.user = &calls;
    assert_int_equal(rt_render_explain(s, &d, &e, keep, &t, &p), RT_ERROR_CANCELLED);
    kit_says(ctx, "the callback ended it");
    assert_int_equal(calls, 2);
    assert_int_equal(t.count, 0);
    d.samples = 4;
    kit_ok(ctx, rt_render_explain(s, &d, &e, keep, &t, &p));
    assert_true(t.count > 0 && p.samples == 4);
    free(t.rays);
    rt_scene_destroy(s);
    rt_context_destroy(ctx);
}

static void test_no_memory(void **state)
{
    kit_memory m = {0};
    rt_context *ctx = kit_context(&m, 1);
    rt_scene *s = kit_scene(ctx);
    rt_render_desc d = settings(8, 8, 40, "whitted");
    rt_explain_desc e = at(4, 5);
    rt_status status = RT_ERROR_MEMORY;
    long failed = 0;
    (void)state;
    add_everything(s);
    kit_ok(ctx, rt_scene_commit(s, NULL));
    long blocks = atomic_load(&m.blocks);
    for (long n = 1; status != RT_OK && n < 1000; n++) {
        told t = {0};
        atomic_store(&m.fail_at, atomic_load(&m.requests) + n);
        status = rt_render_explain(s, &d, &e, keep, &t, NULL);
        atomic_store(&m.fail_at, 0);
        assert_true(status == RT_OK || status == RT_ERROR_MEMORY);
        failed += status != RT_OK;
        rt_context_drop_kept(ctx);
        assert_int_equal(atomic_load(&m.blocks), blocks);
        free(t.rays);
    }
    assert_int_equal(status, RT_OK);
    assert_true(failed > 8);
    rt_scene_destroy(s);
    rt_context_destroy(ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_integrator),
        cmocka_unit_test(test_settings),
        cmocka_unit_test(test_chosen_lights),
        cmocka_unit_test(test_lens),
        cmocka_unit_test(test_many_samples),
        cmocka_unit_test(test_samples),
        cmocka_unit_test(test_known),
        cmocka_unit_test(test_refused),
        cmocka_unit_test(test_ended),
        cmocka_unit_test(test_no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
