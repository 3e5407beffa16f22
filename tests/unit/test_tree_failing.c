/* Tree builders whose allocations fail, or that are cancelled at one of them: an error, nothing left behind. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <pthread.h>
#include <stdlib.h>

#include "support/generate.h"
#include "support/rays.h"
#include "support/world.h"

/* Of the later allocations of a build every third fails, of each builder others, where fewer will do. */
#define SOME 64
#define STEP (test_fewer() ? 3 : 1)

typedef struct failing {
    long left; /* allocations until one fails; -1: none fails */
    long count;
    rti_cancel *cancel; /* asked for at the allocation where none is left; it does not fail then */
    bool once, refused; /* once: no other fails then */
} failing;

static pthread_mutex_t many = PTHREAD_MUTEX_INITIALIZER; /* workers may allocate at a time */

static bool fails(failing *f)
{
    bool now;
    pthread_mutex_lock(&many);
    f->count++;
    now = f->left == 0;
    f->left -= f->left > 0 || (now && f->once);
    f->refused |= now;
    pthread_mutex_unlock(&many);
    if (now && f->cancel)
        atomic_store(&f->cancel->asked, true);
    return now && !f->cancel;
}

static void *failing_allocate(void *user, void *ptr, size_t old_size, size_t new_size)
{
    failing *f = user;
    (void)old_size;
    if (new_size == 0) {
        free(ptr);
        return NULL;
    }
    return fails(f) ? NULL : realloc(ptr, new_size);
}

/* A context that allocates so, and what trees are built over. */
static rt_context *open_failing(failing *f, uint32_t workers, int count, test_mesh *m)
{
    rt_context_desc d = rt_context_desc_default();
    rt_context *ctx;
    test_mesh_soup(m, count, 0.1f, 42);
    d.workers = workers;
    d.allocate = failing_allocate;
    d.allocate_user = f;
    assert_int_equal(rt_context_create(&d, &ctx), RT_OK);
    return ctx;
}

/* Behind a build that went well, or else gave `wanted`: nothing of it is left. */
static void clear(rt_context *ctx, rt_status status, rt_status wanted, void *chunk, size_t size, uint64_t before)
{
    uint64_t after;
    if (status != RT_OK) {
        assert_int_equal(status, wanted);
        assert_null(chunk);
    }
    rti_free(ctx, chunk, status == RT_OK ? size : 0);
    rt_context_memory(ctx, &after, NULL);
    assert_int_equal(before, after);
}

static void test_allocation_failure(void **state)
{
    test_mesh m = {0};
    failing f = {.left = -1};
    rt_context *ctx = open_failing(&f, 1, 3000, &m);
    rti_build_input in = test_input(&m);
    (void)state;
    for (int b = 0; b < TEST_BUILDERS; b++) {
        rti_build_settings s = {.builder = test_builders[b]};
        for (long n = 0;; n += n < SOME + b ? 1 : STEP) {
            uint64_t before;
            void *chunk;
            size_t size;
            rt_context_memory(ctx, &before, NULL);
            f.left = n;
            rt_status status = rti_tree_build(ctx, &in, &s, NULL, &chunk, &size);
            f.left = -1;
            clear(ctx, status, RT_ERROR_MEMORY, chunk, size, before);
            if (status == RT_OK) {
                assert_true(n > 10);
                break;
            }
        }
    }
    rt_context_destroy(ctx);
    test_mesh_free(&m);
}

/* Some workers split large nodes together: where one is refused memory there is an error, or the tree that there is otherwise,
 * for a few things go without. By turns one allocation fails, or all from one on. */
static void test_many_workers(void **state)
{
    test_mesh m = {0};
    failing f = {.left = -1};
    rt_context *ctx = open_failing(&f, 4, 17000, &m); /* three shares */
    rti_build_input in = test_input(&m);
    (void)state;
    for (int b = 0; b < TEST_BUILDERS; b++) {
        rti_build_settings s = {.builder = test_builders[b]};
        void *whole, *chunk;
        size_t whole_size, size;
        long refused = 0;
        assert_int_equal(rti_tree_build(ctx, &in, &s, NULL, &whole, &whole_size), RT_OK);
        ((rtk_tree_header *)whole)->build_seconds = 0.0f;
        for (long n = 0;; n += 1 + n / (test_fewer() ? 2 : 8)) {
            uint64_t before;
            rt_context_memory(ctx, &before, NULL);
            f.left = n;
            f.once = n % 2 == 0;
            f.refused = false;
            rt_status status = rti_tree_build(ctx, &in, &s, NULL, &chunk, &size);
            if (status == RT_OK) {
                ((rtk_tree_header *)chunk)->build_seconds = 0.0f;
                assert_int_equal(size, whole_size);
                assert_memory_equal(chunk, whole, size);
            }
            clear(ctx, status, RT_ERROR_MEMORY, chunk, size, before);
            refused += status != RT_OK;
            f.left = -1;
            if (!f.refused)
                break;
        }
        assert_true(refused > 5);
        rti_free(ctx, whole, whole_size);
    }
    rt_context_destroy(ctx);
    test_mesh_free(&m);
}

/* Cancelled before the build, and at every allocation of it. */
static void test_cancel(void **state)
{
    test_mesh m = {0};
    rti_cancel cancel;
    failing f = {.left = -1, .cancel = &cancel};
    rt_context *ctx = open_failing(&f, 1, 3000, &m);
    rti_build_input in = test_input(&m);
    (void)state;
    for (int b = 0; b < TEST_BUILDERS; b++) {
        rti_build_settings s = {.builder = test_builders[b]};
        long cancelled = 0;
        for (long n = 0;; n += n < SOME + b ? 1 : STEP) {
            uint64_t before;
            void *chunk;
            size_t size;
            atomic_init(&cancel.asked, n == 0);
            rt_context_memory(ctx, &before, NULL);
            f.left = n;
            rt_status status = rti_tree_build(ctx, &in, &s, &cancel, &chunk, &size);
            bool asked = atomic_load(&cancel.asked);
            f.left = -1;
            if (status == RT_OK)
                assert_true(rti_tree_valid(chunk, size, m.count));
            clear(ctx, status, RT_ERROR_CANCELLED, chunk, size, before);
            cancelled += status != RT_OK;
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
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_allocation_failure), cmocka_unit_test(test_many_workers),
                                       cmocka_unit_test(test_cancel)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
