/* Tree builders whose allocations fail, or that are cancelled at one of them: an error, nothing left behind. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <stdlib.h>

#include "support/generate.h"
#include "support/rays.h"
#include "support/world.h"

static const uint32_t builders[] = {RTI_BUILD_KD_EXACT, RTI_BUILD_KD_BINNED,   RTI_BUILD_OCTREE,
                                    RTI_BUILD_BVH,      RTI_BUILD_BVH_COMPACT, RTI_BUILD_BVH_SPATIAL};
#define BUILDERS ((int)RTI_COUNT(builders))

/* Of the later allocations of a build every third fails, of each builder others, where fewer will do. */
#define SOME 64
#define STEP (test_fewer() ? 3 : 1)

typedef struct failing {
    long left; /* allocations until one fails; -1: none fails */
    long count;
    rti_cancel *cancel; /* asked for at the allocation where none is left; it does not fail then */
} failing;

static void *failing_allocate(void *user, void *ptr, size_t old_size, size_t new_size)
{
    failing *f = user;
    (void)old_size;
    if (new_size == 0) {
        free(ptr);
        return NULL;
    }
    f->count++;
    if (f->left == 0 && f->cancel)
        atomic_store(&f->cancel->asked, true);
    else if (f->left == 0)
        return NULL;
    if (f->left > 0)
        f->left--;
    return realloc(ptr, new_size);
}

static void test_allocation_failure(void **state)
{
    test_mesh m = {0};
    failing f = {-1, 0, NULL};
    rt_context_desc d = rt_context_desc_default();
    rt_context *ctx;
    (void)state;
    test_mesh_soup(&m, 3000, 0.1f, 42);
    rti_build_input in = test_input(&m);
    d.workers = 1;
    d.allocate = failing_allocate;
    d.allocate_user = &f;
    assert_int_equal(rt_context_create(&d, &ctx), RT_OK);
    for (int b = 0; b < BUILDERS; b++) {
        rti_build_settings s = {.builder = builders[b]};
        for (long n = 0;; n += n < SOME + b ? 1 : STEP) {
            uint64_t before, after;
            void *chunk;
            size_t size;
            rt_context_memory(ctx, &before, NULL);
            f.left = n;
            rt_status status = rti_tree_build(ctx, &in, &s, NULL, &chunk, &size);
            f.left = -1;
            if (status == RT_OK) {
                rti_free(ctx, chunk, size);
                assert_true(n > 10);
                break;
            }
            assert_int_equal(status, RT_ERROR_MEMORY);
            assert_null(chunk);
            rt_context_memory(ctx, &after, NULL);
            assert_int_equal(before, after);
        }
    }
    rt_context_destroy(ctx);
    test_mesh_free(&m);
}

/* Cancelled before the build, and at every allocation of it. */
static void test_cancel(void **state)
{
    test_mesh m = {0};
    rti_cancel cancel;
    failing f = {-1, 0, &cancel};
    rt_context_desc d = rt_context_desc_default();
    rt_context *ctx;
    (void)state;
    test_mesh_soup(&m, 3000, 0.1f, 42);
    rti_build_input in = test_input(&m);
    d.workers = 1;
    d.allocate = failing_allocate;
    d.allocate_user = &f;
    assert_int_equal(rt_context_create(&d, &ctx), RT_OK);
    for (int b = 0; b < BUILDERS; b++) {
        rti_build_settings s = {.builder = builders[b]};
        long cancelled = 0;
        for (long n = 0;; n += n < SOME + b ? 1 : STEP) {
            uint64_t before, after;
            void *chunk;
            size_t size;
            atomic_init(&cancel.asked, n == 0);
            rt_context_memory(ctx, &before, NULL);
            f.left = n;
            rt_status status = rti_tree_build(ctx, &in, &s, &cancel, &chunk, &size);
            bool asked = atomic_load(&cancel.asked);
            f.left = -1;
            if (status == RT_OK) {
                assert_true(rti_tree_valid(chunk, size, m.count));
                rti_free(ctx, chunk, size);
            } else {
                assert_int_equal(status, RT_ERROR_CANCELLED);
                assert_null(chunk);
                cancelled++;
            }
            rt_context_memory(ctx, &after, NULL);
            assert_int_equal(before, after);
            if (!asked)
                break;
        }
        assert_true(cancelled > 10);
    }
    rt_context_destroy(ctx);
    test_mesh_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_allocation_failure), cmocka_unit_test(test_cancel)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
