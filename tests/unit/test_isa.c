/* Which instruction set a context takes, and what the environment may say about it. */
#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "trace/trace.h"

static void test_choose(void **state)
{
    char why[256];
    (void)state;
    assert_int_equal(rti_isa_choose(NULL, why, sizeof why), rti_isa_best());
    assert_string_equal(why, "");
    assert_int_equal(rti_isa_choose("", why, sizeof why), rti_isa_best());
    assert_string_equal(why, "");
    assert_true(rti_isa_runs(RTI_ISA_GENERIC));
    for (int i = 0; i < RTI_ISA_COUNT; i++) {
        rti_isa got = rti_isa_choose(rti_isa_name((rti_isa)i), why, sizeof why);
        if (rti_isa_runs((rti_isa)i)) {
            assert_int_equal(got, i);
            assert_string_equal(why, "");
            assert_true(i <= (int)rti_isa_best());
        } else {
            assert_int_equal(got, rti_isa_best());
            assert_non_null(strstr(why, rti_isa_name((rti_isa)i)));
        }
    }
    assert_int_equal(rti_isa_choose("avx3\n", why, sizeof why), rti_isa_best());
    assert_non_null(strstr(why, "\"avx3\\x0a\"; this build on this processor has generic"));
}

static void keep(void *user, rt_log_level level, const char *message)
{
    if (level == RT_LOG_WARNING)
        snprintf(user, 256, "%s", message);
}

static void test_context(void **state)
{
    char said[256] = "";
    rt_context_desc d = rt_context_desc_default();
    rt_context *ctx;
    (void)state;
    d.log = keep;
    d.log_user = said;
    setenv("RT_ISA", "generic", 1);
    assert_string_equal(rt_isa(), "generic");
    assert_int_equal(rt_context_create(&d, &ctx), RT_OK);
    unsetenv("RT_ISA");
    assert_string_equal(rt_context_isa(ctx), "generic"); /* taken once */
    assert_string_equal(said, "");
    rt_context_destroy(ctx);
    setenv("RT_ISA", "mmx", 1);
    assert_int_equal(rt_context_create(&d, &ctx), RT_OK);
    unsetenv("RT_ISA");
    assert_int_equal(rti_context_isa(ctx), rti_isa_best());
    assert_non_null(strstr(said, "RT_ISA is \"mmx\""));
    rt_context_destroy(ctx);
}

/* Every level has the same rows, with functions of its own. */
static void test_tables(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < rti_tracer_count(); i++) {
        const rti_tracer *generic = rti_tracer_at(RTI_ISA_GENERIC, i);
        assert_ptr_equal(rti_tracer_find(RTI_ISA_GENERIC, generic->name), generic);
        for (int isa = 1; isa < RTI_ISA_COUNT; isa++) {
            const rti_tracer *t = rti_tracer_at((rti_isa)isa, i);
            assert_string_equal(t->name, generic->name);
            assert_int_equal(t->tree, generic->tree);
            if (rti_isa_runs((rti_isa)isa))
                assert_true(t->intersect != generic->intersect && t->occluded != generic->occluded);
        }
    }
    assert_null(rti_tracer_at(RTI_ISA_GENERIC, rti_tracer_count()));
    assert_null(rti_tracer_find(RTI_ISA_GENERIC, "none"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_choose), cmocka_unit_test(test_context),
                                       cmocka_unit_test(test_tables)};
    unsetenv("RT_ISA");
    return cmocka_run_group_tests(tests, NULL, NULL);
}
