/* Tracer objects (librt/trace.h): every way to ask gives the same answers, for every tracer, count and hint; what they hold and
 * refuse. */
#include <math.h>

#include "scene_kit.h"

#include "librt/render.h"
#include "librt/trace.h"
#include "scene/arrays.h"
#include "scene/parts.h"

enum { MOST = 2500 };

/* Squares, spheres and an instance: triangles, shapes and two levels. */
static rt_scene *crowd(rt_context *ctx, rt_scene **child)
{
    rt_scene *scene = kit_scene(ctx);
    rt_instance_desc inst = rt_instance_desc_default();
    *child = kit_scene(ctx);
    for (int i = 0; i < 12; i++) {
        kit_square(scene, 1.0f + 0.1f * (float)i, -0.5f * (float)i);
        kit_sphere(i % 2 ? scene : *child, 0.7f * (float)(i % 4) - 1, 0.5f * (float)(i / 4) - 1, 0.3f, 0.3f);
    }
    kit_ok(ctx, rt_scene_commit(*child, NULL));
    inst.child = *child;
    inst.transform = rt_transform_translate((rt_vec3){0.3f, 0.2f, 1.0f});
    kit_ok(ctx, rt_scene_add_instance(scene, &inst, NULL));
    kit_ok(ctx, rt_scene_commit(scene, NULL));
    return scene;
}

/* From one eye, and from 1200 on from five, through a window a little wider than the scene; every seventh ray is one that misses
 * by its mask or its numbers.
 */
static void fill(rt_ray *rays, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        float x = (float)(i % 50) / 25.0f - 1.0f, y = (float)(i / 50) / 25.0f - 1.0f;
        rays[i] = kit_ray(i < 1200 ? 0.1f : 0.1f + 0.001f * (float)(i % 5), 0.2f, 6.0f, 0.3f * x, 0.3f * y, -1.0f);
        rays[i].tmin = 0.01f * (float)(i % 3);
        if (i % 7 == 3)
            rays[i].mask = i % 2 ? 0 : 1;
        if (i % 49 == 5)
            rays[i].dir.z = NAN;
    }
}

typedef struct many {
    rt_ray rays[MOST];
    rt_hit hits[MOST], truth[MOST];
    uint8_t dark[MOST], true_dark[MOST];
    _Alignas(64) rt_ray_block in[MOST / 16 + 1];
    _Alignas(64) rt_hit_block out[MOST / 16 + 1];
    uint16_t bits[MOST / 16 + 1];
} many;

static void into_blocks(many *m, size_t count)
{
    memset(m->in, 0xff, sizeof m->in); /* lanes behind the last ray: no numbers at all */
    for (size_t i = 0; i < count; i++) {
        rt_ray_block *b = &m->in[i / 16];
        size_t k = i % 16;
        const rt_ray *r = &m->rays[i];
        b->org_x[k] = r->org.x, b->org_y[k] = r->org.y, b->org_z[k] = r->org.z;
        b->dir_x[k] = r->dir.x, b->dir_y[k] = r->dir.y, b->dir_z[k] = r->dir.z;
        b->tmin[k] = r->tmin, b->tmax[k] = r->tmax, b->mask[k] = r->mask;
    }
}

static void ask(const rt_tracer *t, many *m, size_t count, uint32_t hints)
{
    memset(m->hits, 0x55, sizeof m->hits);
    memset(m->dark, 0x55, sizeof m->dark);
    rt_tracer_intersect(t, m->rays, m->hits, count, hints);
    rt_tracer_occluded(t, m->rays, m->dark, count, hints);
    assert_memory_equal(m->hits, m->truth, count * sizeof(rt_hit));
    assert_memory_equal(m->dark, m->true_dark, count);
    if (count < MOST) { /* not one byte behind them */
        assert_int_equal(m->hits[count].prim_id, 0x55555555);
        assert_int_equal(m->dark[count], 0x55);
    }
    into_blocks(m, count);
    rt_tracer_intersect_blocks(t, m->in, m->out, count, hints);
    rt_tracer_occluded_blocks(t, m->in, m->bits, count, hints);
    for (size_t i = 0; i < count; i++) {
        const rt_hit_block *b = &m->out[i / 16];
        size_t k = i % 16;
        rt_hit h = {b->t[k], b->u[k], b->v[k], b->prim_id[k], b->geom_id[k], b->inst_id[k]};
        assert_memory_equal(&h, &m->truth[i], sizeof h);
        assert_int_equal(m->bits[i / 16] >> k & 1, m->true_dark[i]);
    }
}

static void every_way_gives_the_same(void **state)
{
    static const size_t counts[] = {0, 1, 3, 4, 5, 15, 16, 17, 255, 257, 1023, 1024, 1025, MOST};
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *child, *scene = crowd(ctx, &child);
    many *m = aligned_alloc(64, (sizeof *m + 63) / 64 * 64);
    rt_tracer *brute;
    const char *name;
    size_t met = 0, instanced = 0;
    (void)state;
    assert_non_null(m);
    fill(m->rays, MOST);
    kit_ok(ctx, rt_tracer_create(scene, "brute", &brute));
    rt_tracer_intersect(brute, m->rays, m->truth, MOST, 0);
    rt_tracer_occluded(brute, m->rays, m->true_dark, MOST, 0);
    for (size_t i = 0; i < MOST; i++) {
        met += m->truth[i].prim_id != RT_INVALID_ID;
        instanced += m->truth[i].inst_id != RT_INVALID_ID;
        assert_int_equal(m->true_dark[i], m->truth[i].prim_id != RT_INVALID_ID);
    }
    assert_true(met > 500 && met < MOST - 300 && instanced > 10);
    for (uint32_t n = 0; (name = rt_tracer_at(n, NULL)) != NULL; n++) {
        rt_tracer *t;
        kit_ok(ctx, rt_tracer_create(scene, name, &t));
        for (size_t c = 0; c < sizeof counts / sizeof *counts; c++)
            for (uint32_t hints = 0; hints < 4; hints++)
                ask(t, m, counts[c], hints);
        ask(t, m, MOST, 0xffffffffu); /* bits that are no hints count for nothing */
        rt_tracer_destroy(t);
    }
    memset(m->hits, 0x55, sizeof m->hits);
    rt_scene_intersect(scene, m->rays, m->hits, 1025);
    rt_scene_occluded(scene, m->rays, m->dark, 1025);
    assert_memory_equal(m->hits, m->truth, 1025 * sizeof(rt_hit));
    assert_memory_equal(m->dark, m->true_dark, 1025);
    assert_int_equal(m->hits[1025].prim_id, 0x55555555);
    rt_tracer_destroy(brute);
    free(m);
    rt_scene_destroy(scene);
    rt_scene_destroy(child);
    rt_context_destroy(ctx);
}

/* Each ray by a call of its own, looking at the floating-point environment and by the caller's word. */
static void ask_one_by_one(const rt_scene *scene, rt_context *ctx, many *m, size_t count)
{
    rt_tracer *brute;
    const char *name;
    kit_ok(ctx, rt_tracer_create(scene, "brute", &brute));
    rt_tracer_intersect(brute, m->rays, m->truth, count, 0);
    rt_tracer_occluded(brute, m->rays, m->true_dark, count, 0);
    for (uint32_t n = 0; (name = rt_tracer_at(n, NULL)) != NULL; n++) {
        rt_tracer *t;
        kit_ok(ctx, rt_tracer_create(scene, name, &t));
        for (uint32_t hints = 0; hints <= RT_RAYS_DEFAULT_FENV; hints += RT_RAYS_DEFAULT_FENV) {
            memset(m->hits, 0x55, sizeof m->hits);
            memset(m->dark, 0x55, sizeof m->dark);
            for (size_t i = 0; i < count; i++) {
                rt_tracer_intersect(t, &m->rays[i], &m->hits[i], 1, hints);
                rt_tracer_occluded(t, &m->rays[i], &m->dark[i], 1, hints);
            }
            assert_memory_equal(m->hits, m->truth, count * sizeof(rt_hit));
            assert_memory_equal(m->dark, m->true_dark, count);
        }
        rt_tracer_destroy(t);
    }
    rt_tracer_destroy(brute);
}

/* Bodies and an instance; then nothing but triangles, around the least and the greatest scale for which one ray a call is not
 * asked whether its numbers are near the ends of the floats' range (rtk_scale_ordinary), and far beyond. */
static void one_ray_a_call(void **state)
{
    static const float scales[] = {1e-21f, 0.9e-18f, 2e-18f, 3e-18f, 1.0f, 3e5f, 5e5f, 7e5f, 1e9f};
    static const float longest[] = {1.0f, 1.1e-18f, 0.9e18f};
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *child, *scene = crowd(ctx, &child);
    many *m = aligned_alloc(64, (sizeof *m + 63) / 64 * 64);
    uint32_t seed = 5;
    (void)state;
    assert_non_null(m);
    fill(m->rays, MOST);
    ask_one_by_one(scene, ctx, m, 900);
    rt_scene_destroy(scene);
    rt_scene_destroy(child);
    for (size_t k = 0; k < sizeof scales / sizeof *scales; k++) {
        const float s = scales[k];
        size_t met = 0;
        scene = kit_scene(ctx);
        for (int i = 0; i < 12; i++)
            kit_square(scene, s * (1.0f + 0.3f * (float)i), s * -0.5f * (float)i);
        kit_ok(ctx, rt_scene_commit(scene, NULL));
        for (size_t i = 0; i < 900; i++) {
            float r[5];
            for (int j = 0; j < 5; j++) {
                seed = seed * 1664525u + 1013904223u;
                r[j] = (float)(seed >> 8) / 8388608.0f - 1.0f;
            }
            const float d = longest[i % 3], along = i % 2 ? -d : d;
            m->rays[i] = kit_ray(r[0] * s, r[1] * s, (4.0f * r[2] - 1.0f) * s, i % 5 ? 0.4f * r[3] * d : 0.0f,
                                 i % 7 ? 0.4f * r[4] * d : 1e-30f * r[4], along);
            m->rays[i].tmin = i % 4 ? 0.0f : 0.5f * s / d;
            if (i % 11 == 0)
                m->rays[i].tmax = i % 2 ? m->rays[i].tmin : NAN;
        }
        ask_one_by_one(scene, ctx, m, 900);
        for (size_t i = 0; i < 900; i++)
            met += m->truth[i].prim_id != RT_INVALID_ID;
        assert_true(met > 200 && met < 800);
        rt_scene_destroy(scene);
    }
    free(m);
    rt_context_destroy(ctx);
}

static void a_tracer_holds_its_snapshot(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx);
    rt_ray ray = kit_ray(0.1f, 0.2f, 5, 0, 0, -1);
    rt_tracer_info info;
    rt_tracer *t;
    rt_hit hit;
    (void)state;
    uint32_t square = kit_square(scene, 1, 0);
    kit_ok(ctx, rt_scene_commit(scene, NULL));
    kit_ok(ctx, rt_tracer_create(scene, NULL, &t));
    kit_square(scene, 1, 2);
    kit_ok(ctx, rt_scene_remove_geometry(scene, (rt_geometry){square}));
    kit_ok(ctx, rt_scene_commit(scene, NULL));
    assert_true(kit_hit(scene, ray).t == 3.0f);
    rt_tracer_intersect(t, &ray, &hit, 1, 0);
    assert_true(hit.t == 5.0f && hit.geom_id == square);
    rt_scene_destroy(scene); /* the tracer needs it no more */
    rt_tracer_intersect(t, &ray, &hit, 1, RT_RAYS_COHERENT);
    assert_true(hit.t == 5.0f);
    rt_tracer_get_info(t, &info);
    assert_string_not_equal(info.name, "auto");
    assert_non_null(info.tree);
    assert_true(info.trees == 1 && info.tree_bytes > 0 && info.geometry_bytes >= 2 * 36 && info.width >= 1 &&
                info.build_seconds >= 0);
    rt_tracer_destroy(t);
    rt_tracer_destroy(NULL);
    rt_context_destroy(ctx);
}

static void what_is_wrong_is_said(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx);
    rt_tracer *t = (rt_tracer *)scene;
    rt_tracer_info info;
    (void)state;
    assert_int_equal(rt_tracer_create(scene, "brute", &t), RT_ERROR_STATE);
    assert_null(t);
    kit_says(ctx, "rt_tracer_create: the scene was never committed");
    kit_square(scene, 1, 0);
    kit_ok(ctx, rt_scene_commit(scene, NULL));
    assert_int_equal(rt_tracer_create(scene, "krokodil\n", &t), RT_ERROR_ARGUMENT);
    kit_says(ctx, "rt_tracer_create: there is no tracer \"krokodil");
    assert_int_equal(rt_tracer_create(scene, "brute", NULL), RT_ERROR_ARGUMENT);
    kit_says(ctx, "tracer is NULL");
    kit_ok(ctx, rt_tracer_create(scene, "brute", &t));
    rt_tracer_get_info(t, &info);
    assert_string_equal(info.name, "brute");
    assert_null(info.tree);
    assert_true(info.trees == 0 && info.tree_bytes == 0 && info.build_seconds == 0);
    rt_tracer_destroy(t);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

/* Trees are built as for a render, but the sentence is about this call. */
static bool names_a_render(const rt_context *ctx)
{
    char text[1024];
    rt_context_error(ctx, text, sizeof text);
    return strstr(text, "rt_render") != NULL;
}

/* Each allocation fails in turn; nothing is left behind. */
static void memory_may_lack(void **state)
{
    const char *name;
    (void)state;
    for (uint32_t n = 0; (name = rt_tracer_at(n, NULL)) != NULL; n++) {
        rt_status status = RT_ERROR_MEMORY;
        for (long k = 1; status != RT_OK; k++) {
            kit_memory memory = {0};
            rt_context *ctx = kit_context(&memory, 1);
            rt_scene *scene = kit_scene(ctx);
            rt_commit_desc d = rt_commit_desc_default();
            rt_tracer *t;
            d.accel = "brute";
            kit_square(scene, 1, 0);
            kit_sphere(scene, 0, 0, 2, 0.5f);
            kit_ok(ctx, rt_scene_commit(scene, &d));
            atomic_store(&memory.fail_at, atomic_load(&memory.requests) + k);
            status = rt_tracer_create(scene, name, &t);
            atomic_store(&memory.fail_at, 0);
            if (status == RT_OK)
                assert_non_null(t);
            else
                assert_true(t == NULL && (status == RT_ERROR_MEMORY || status == RT_ERROR_MEMORY_LIMIT) && !names_a_render(ctx));
            rt_tracer_destroy(t);
            rt_scene_destroy(scene);
            rt_context_destroy(ctx);
            assert_int_equal(atomic_load(&memory.blocks), 0);
            assert_int_equal(atomic_load(&memory.bytes), 0);
            assert_true(k < 10000);
        }
    }
}

static void triangles_come_out(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx);
    rt_triangle got[8];
    (void)state;
    assert_int_equal(rt_scene_get_triangles(scene, 0, got, 8), 0);
    uint32_t first = kit_square(scene, 1, 0);
    kit_sphere(scene, 0, 0, 0, 1);
    uint32_t third = kit_square(scene, 2, 3);
    assert_int_equal(rt_scene_get_triangles(scene, 0, got, 8), 0);
    kit_ok(ctx, rt_scene_commit(scene, NULL));
    assert_int_equal(rt_scene_get_triangles(scene, 0, NULL, 0), 4);
    memset(got, 0x55, sizeof got);
    assert_int_equal(rt_scene_get_triangles(scene, 1, got, 8), 4);
    assert_true(got[0].geom_id == first && got[0].prim_id == 1 && got[0].v0.x == -1 && got[0].v1.x == 1 && got[0].v2.y == 1);
    assert_true(got[2].geom_id == third && got[2].prim_id == 1 && got[2].v1.y == 2 && got[2].v2.z == 3);
    assert_int_equal(got[3].geom_id, 0x55555555);
    memset(got, 0x55, sizeof got);
    assert_int_equal(rt_scene_get_triangles(scene, UINT64_MAX, got, 8), 4);
    assert_int_equal(got[0].geom_id, 0x55555555);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

/* The guess about rays that come without a word. */
static void coherence_is_seen(void **state)
{
    static _Alignas(64) rtk_trace_block b[16];
    rt_ray rays[256];
    uint32_t seed = 1;
    rt_context *ctx = NULL;
    (void)state;
    assert_int_equal(rt_context_create(NULL, &ctx), RT_OK);
    for (uint32_t i = 0; i < 256; i++)
        rays[i] = kit_ray(1, 2, 3, (float)(i % 16) - 8.5f, (float)(i / 16) - 7.5f, -20);
    rti_rays_gather(ctx, rays, 256, b);
    assert_int_equal(rti_arrays_guess(b, 256), 0); /* rows of sixteen cross the middle */
    for (uint32_t i = 0; i < 256; i++)
        rays[i].dir.x = i / 16 % 6 == 0 ? (float)(i % 4) - 1.5f : 1; /* every other block that is looked at is mixed */
    rti_rays_gather(ctx, rays, 256, b);
    assert_int_equal(rti_arrays_guess(b, 240), 0); /* three of five */
    for (uint32_t i = 0; i < 16; i++)
        rays[i].dir.x = 1;
    rti_rays_gather(ctx, rays, 256, b);
    assert_int_equal(rti_arrays_guess(b, 256), RT_RAYS_COHERENT);
    assert_int_equal(rti_arrays_guess(b, 250), RT_RAYS_COHERENT);
    for (uint32_t i = 0; i < 256; i++) {
        seed = seed * 1664525u + 1013904223u;
        rays[i] =
            kit_ray(0, 0, 0, (float)(seed >> 8 & 255) - 127.5f, (float)(seed >> 16 & 255) - 127.5f, (float)(seed >> 24) - 127.5f);
    }
    rti_rays_gather(ctx, rays, 256, b);
    assert_int_equal(rti_arrays_guess(b, 256), 0);
    assert_int_equal(rti_arrays_guess(b, 1), 0);
    rt_context_destroy(ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_way_gives_the_same),
        cmocka_unit_test(one_ray_a_call),
        cmocka_unit_test(a_tracer_holds_its_snapshot),
        cmocka_unit_test(what_is_wrong_is_said),
        cmocka_unit_test(memory_may_lack),
        cmocka_unit_test(triangles_come_out),
        cmocka_unit_test(coherence_is_seen),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
