/* What a render is told by and what it refuses: settings, names, scenes that are not there, sums that would overflow. */
#include "render_stage.h"

static void refused(const rt_render_desc *d, rt_status status, const char *word)
{
    rt_image *image = (rt_image *)8;
    assert_int_equal(rt_render(scene, d, &image), status);
    assert_null(image);
    kit_says(ctx, word);
    assert_int_equal(rt_render_memory(scene, d) == 0, status != RT_ERROR_MEMORY_LIMIT);
}

static void test_refusals(void **state)
{
    rt_render_desc d, good = settings(16, 16, 1, "whitted");
    (void)state;
#define REFUSED(change, status, word)                                                                                            \
    do {                                                                                                                         \
        d = good;                                                                                                                \
        change;                                                                                                                  \
        refused(&d, status, word);                                                                                               \
    } while (0)
    REFUSED(d.width = 0, RT_ERROR_ARGUMENT, "0 x 16");
    REFUSED(d.height = 0, RT_ERROR_ARGUMENT, "16 x 0");
    REFUSED(d.width = d.height = 100000, RT_ERROR_ARGUMENT, "10000000000");
    REFUSED(d.width = 2000000, RT_ERROR_ARGUMENT, "2000000");
    REFUSED(d.samples = 0, RT_ERROR_ARGUMENT, "samples is 0");
    REFUSED(d.samples = 65537, RT_ERROR_ARGUMENT, "65537");
    REFUSED(d.tile = 0, RT_ERROR_ARGUMENT, "tile is 0");
    REFUSED(d.tile = 4097, RT_ERROR_ARGUMENT, "4097");
    REFUSED(d.workers = 1025, RT_ERROR_ARGUMENT, "1025");
    REFUSED(d.max_depth = 65, RT_ERROR_ARGUMENT, "max_depth is 65");
    REFUSED(d.integrator = "witted", RT_ERROR_ARGUMENT, "witted");
    REFUSED(d.integrator = NULL, RT_ERROR_ARGUMENT, "integrator");
    REFUSED(d.tracer = "bsp", RT_ERROR_ARGUMENT, "octree");
    REFUSED(d.filter = (rt_filter)9, RT_ERROR_ARGUMENT, "filter is 9");
    REFUSED(d.schedule = (rt_schedule)9, RT_ERROR_ARGUMENT, "schedule is 9");
    REFUSED(d.filter_width = NAN, RT_ERROR_ARGUMENT, "filter_width");
    REFUSED(d.filter_width = -1, RT_ERROR_ARGUMENT, "-1");
    REFUSED(d.ao_distance = NAN, RT_ERROR_ARGUMENT, "ao_distance");
    REFUSED((d.crop.width = 8, d.crop.x = 9, d.crop.height = 1), RT_ERROR_ARGUMENT, "(9, 0)");
    REFUSED((d.crop.width = 8, d.crop.height = UINT32_MAX), RT_ERROR_ARGUMENT, "4294967295");
    REFUSED(d.struct_size = 0, RT_ERROR_ARGUMENT, "struct_size");
    REFUSED(d.memory_limit = 1000, RT_ERROR_MEMORY_LIMIT, "memory_limit is 1000");
    REFUSED((d.width = 65535, d.height = 65536), RT_ERROR_MEMORY_LIMIT, "bytes");
#undef REFUSED
}

static void test_never_committed(void **state)
{
    rt_scene *empty;
    rt_render_desc d = settings(4, 4, 1, "whitted");
    rt_image *image;
    rt_job *job;
    (void)state;
    OK(rt_scene_create(ctx, &empty));
    assert_int_equal(rt_render(empty, &d, &image), RT_ERROR_STATE);
    assert_int_equal(rt_job_start(empty, &d, &job), RT_ERROR_STATE);
    assert_null(job);
    rt_scene_destroy(empty);
}

/* Glass and mirror at once, 64 deep, many samples: more than the film can add up. With fewer samples the unit grows coarser. */
static void test_overflow_guard(void **state)
{
    rt_scene *s;
    rt_render_desc d = settings(2, 2, 65536, "whitted");
    rt_material both;
    rt_image *image;
    char text[512];
    (void)state;
    OK(rt_scene_create(ctx, &s));
    both = add_material(s, v3(1, 1, 1), 0, 1, 1, 1.5f);
    add_sphere(s, v3(0, 0, 0), 1, both);
    for (int i = 0; i < 3; i++)
        add_light(s, light(RT_LIGHT_POINT, v3(4, 5, 4), v3(1, 1, 1), RT_FALLOFF_NONE));
    set_world(s, v3(1, 1, 1), v3(1, 1, 1));
    OK(rt_scene_commit(s, NULL));
    d.max_depth = 64;
    assert_int_equal(rt_render(s, &d, &image), RT_ERROR_ARGUMENT);
    rt_context_error(ctx, text, sizeof text);
    assert_non_null(strstr(text, "max_depth"));
    d.samples = 4;
    d.max_depth = 14;
    d.crop.width = d.crop.height = 1;
    OK(rt_render(s, &d, &image));
    assert_true(pixel(image, 0, 0)[0] > 0);
    rt_image_destroy(image);
    rt_scene_destroy(s);
}

static void test_tables(void **state)
{
    static const char *const integrators[] = {"whitted", "path", "ao", "normal", "uv", "id", "depth", "cost", "steps"};
    rt_render_desc d = settings(8, 8, 1, "whitted");
    const char *help = NULL;
    (void)state;
    for (uint32_t i = 0; i < 9; i++) {
        assert_string_equal(rt_integrator_at(i, &help), integrators[i]);
        assert_true(strlen(help) > 10);
        d.integrator = integrators[i];
        rt_image_destroy(render(scene, &d));
    }
    assert_null(rt_integrator_at(9, NULL));
    assert_string_equal(rt_tracer_at(0, &help), "auto");
    for (uint32_t i = 0; rt_tracer_at(i, &help); i++) {
        d.tracer = rt_tracer_at(i, NULL);
        rt_image_destroy(render(scene, &d));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_ROOM(test_refusals),
        IN_ROOM(test_never_committed),
        IN_ROOM(test_overflow_guard),
        IN_ROOM(test_tables),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
