/* Floor base: memory, messages, threads, files, numbers, hashing. */
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <locale.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "../support/many.h"
#include "base/base.h"

static rt_context *make(uint32_t workers, uint64_t limit)
{
    rt_context_desc d = rt_context_desc_default();
    rt_context *ctx;
    d.workers = workers;
    d.memory_limit = limit;
    assert_int_equal(rt_context_create(&d, &ctx), RT_OK);
    return ctx;
}

static void test_memory(void **state)
{
    (void)state;
    rt_context *ctx = make(1, 100000);
    uint64_t now, peak;
    void *blocks[50];
    for (size_t i = 0; i < 50; i++) {
        blocks[i] = rti_alloc(ctx, i * 7);
        assert_non_null(blocks[i]);
        assert_int_equal((uintptr_t)blocks[i] % 64, 0);
        memset(blocks[i], 0xa5, i * 7);
    }
    assert_null(rti_alloc(ctx, 100000));
    assert_int_equal(rti_fail_memory(ctx, "x", 100000), RT_ERROR_MEMORY_LIMIT);
    assert_null(rti_alloc(ctx, SIZE_MAX));
    assert_null(rti_alloc_array(ctx, SIZE_MAX / 2, 3));
    for (size_t i = 0; i < 50; i++)
        rti_free(ctx, blocks[i], i * 7);
    rt_context_memory(ctx, &now, &peak);
    assert_int_equal(now, 0);
    assert_true(peak > 50 * 49 / 2 * 7 && peak < 100000);
    rt_context_destroy(ctx);
}

static void *refuse(void *user, void *ptr, size_t old_size, size_t new_size)
{
    return *(bool *)user && new_size != 0 ? NULL : rt_allocate(NULL, ptr, old_size, new_size);
}

static void says(const rt_context *ctx, const char *part)
{
    char text[1024];
    rt_context_error(ctx, text, sizeof text);
    assert_non_null(strstr(text, part));
}

/* Who refused a block is told apart, also where the block would fit and what stands before it would not. */
static void test_who_refused(void **state)
{
    bool refuses = false;
    rt_context_desc d = rt_context_desc_default();
    rt_context *ctx;
    (void)state;
    d.workers = 1;
    d.memory_limit = 1000;
    d.allocate = refuse;
    d.allocate_user = &refuses;
    assert_int_equal(rt_context_create(&d, &ctx), RT_OK);
    assert_null(rti_alloc(ctx, 990));
    assert_int_equal(rti_fail_memory(ctx, "x", 990), RT_ERROR_MEMORY_LIMIT);
    says(ctx, "x: 1054 bytes more would pass the memory limit of 1000 bytes (0 are in use)");
    refuses = true;
    assert_null(rti_alloc(ctx, 0));
    assert_int_equal(rti_fail_memory(ctx, "x", 0), RT_ERROR_MEMORY);
    says(ctx, "x: the allocator could not give 64 bytes");
    assert_null(rti_alloc_array(ctx, SIZE_MAX / 2, 3));
    assert_int_equal(rti_fail_memory(ctx, "x", SIZE_MAX), RT_ERROR_MEMORY_LIMIT);
    refuses = false;
    rt_context_destroy(ctx);
}

typedef struct wandering {
    uint32_t turn;
    bool refuses;
} wandering;

/* Blocks stand 16, 32, 48, 64 bytes behind a cache line's begin in turn, so a resized one never where it stood. */
static void *wander(void *user, void *ptr, size_t old_size, size_t new_size)
{
    wandering *w = user;
    char *raw, *at = NULL;
    if (new_size > 0) {
        if (ptr && w->refuses)
            return NULL;
        raw = malloc(new_size + 192);
        assert_non_null(raw);
        at = raw + 64 + (64 - (uintptr_t)raw % 64) + 16 * (w->turn++ % 4);
        memcpy(at - sizeof raw, &raw, sizeof raw);
        if (ptr)
            memcpy(at, ptr, old_size < new_size ? old_size : new_size);
    }
    if (ptr) {
        memcpy(&raw, (char *)ptr - sizeof raw, sizeof raw);
        free(raw);
    }
    return at;
}

/* Whatever becomes of pages, what stands in them stays. */
static void test_settle(void **state)
{
    const size_t all = (size_t)11 << 20,
                 sizes[] = {0, 1, 4096, ((size_t)2 << 20) - 1, (size_t)2 << 20, ((size_t)5 << 20) + 77, all};
    unsigned char *block = malloc(all);
    (void)state;
    assert_non_null(block);
    for (size_t i = 0; i < all; i++)
        block[i] = (unsigned char)(i * 7 + (i >> 12));
    for (size_t k = 0; k < RTI_COUNT(sizes); k++)
        for (size_t from = 0; from + sizes[k] <= all; from += ((size_t)3 << 20) + 64)
            rti_settle_large(block + from, sizes[k]);
    for (size_t i = 0; i < all; i++)
        if (block[i] != (unsigned char)(i * 7 + (i >> 12)))
            fail_msg("byte %zu is another", i);
    free(block);
}

static void test_shrink(void **state)
{
    wandering w = {0};
    rt_context_desc d = rt_context_desc_default();
    rt_context *ctx;
    uint64_t before, now;
    (void)state;
    d.workers = 1;
    d.allocate = wander;
    d.allocate_user = &w;
    assert_int_equal(rt_context_create(&d, &ctx), RT_OK);
    rt_context_memory(ctx, &before, NULL);
    for (size_t size = 1000; size > 0; size -= 37) {
        unsigned char *p = rti_alloc(ctx, 1000), *less;
        for (size_t i = 0; i < 1000; i++)
            p[i] = (unsigned char)(i * 7);
        w.refuses = true;
        assert_null(rti_shrink(ctx, p, 1000, size));
        w.refuses = false;
        less = rti_shrink(ctx, p, 1000, size);
        assert_non_null(less);
        assert_int_equal((uintptr_t)less % 64, 0);
        for (size_t i = 0; i < size; i++)
            assert_int_equal(less[i], (unsigned char)(i * 7));
        rt_context_memory(ctx, &now, NULL);
        assert_true(now >= before + size && now < before + size + 200);
        rti_free(ctx, less, size);
        rt_context_memory(ctx, &now, NULL);
        assert_int_equal(now, before);
        if (size < 37)
            break;
    }
    rt_context_destroy(ctx);
}

static void test_context_desc(void **state)
{
    (void)state;
    rt_context_desc d;
    rt_context *ctx = (rt_context *)&d;
    memset(&d, 0, sizeof d);
    assert_int_equal(rt_context_create(&d, &ctx), RT_ERROR_ARGUMENT);
    assert_null(ctx);
    d = rt_context_desc_default();
    d.workers = 1025;
    assert_int_equal(rt_context_create(&d, &ctx), RT_ERROR_ARGUMENT);
    rt_context_destroy(NULL);
}

typedef struct sums {
    rt_context *ctx;
    atomic_uint total;
    uint32_t inner;
} sums;

static void add_inner(void *data, uint32_t index)
{
    sums *s = data;
    atomic_fetch_add(&s->total, index + 1);
}

static void add_outer(void *data, uint32_t index)
{
    sums *s = data;
    (void)index;
    rti_parallel(s->ctx, s->inner, add_inner, s);
}

static void test_parallel(void **state)
{
    (void)state;
    for (uint32_t workers = 1; workers <= 8; workers++) {
        rt_context *ctx = make(workers, 0);
        for (int round = 0; round < 20; round++) {
            sums s = {ctx, 0, 100};
            rti_parallel(ctx, 37, add_outer, &s);
            assert_int_equal(atomic_load(&s.total), 37 * 5050);
        }
        rt_context_destroy(ctx);
    }
}

#define CALLERS 80 /* more than the pool has records of loops */

/* Every index of every loop once, to the right data, while other callers' loops come and go. */
static void *call_on_thread(void *arg)
{
    uintptr_t wrong = 0;
    for (uint32_t round = 0; round < 60; round++) {
        sums s = {arg, 0, 1 + round % 9};
        const uint32_t n = 1 + round % 5;
        rti_parallel(s.ctx, n, add_outer, &s);
        wrong += atomic_load(&s.total) != n * (s.inner * (s.inner + 1) / 2);
    }
    return (void *)wrong;
}

static void test_many_callers(void **state)
{
    (void)state;
    for (uint32_t workers = 2; workers <= 8; workers += 3) {
        rt_context *ctx = make(workers, 0);
        pthread_t threads[CALLERS];
        uint32_t started = 0;
        while (started < CALLERS && pthread_create(&threads[started], NULL, call_on_thread, ctx) == 0)
            started++;
        assert_true(started > 1);
        while (started > 0) {
            void *wrong;
            pthread_join(threads[--started], &wrong);
            assert_null(wrong);
        }
        rt_context_destroy(ctx);
    }
}

static void *fail_on_thread(void *arg)
{
    rt_context *ctx = arg;
    char text[64];
    rti_fail(ctx, RT_ERROR_IO, "other %d", 2);
    rt_context_error(ctx, text, sizeof text);
    assert_string_equal(text, "other 2");
    return NULL;
}

static void test_messages(void **state)
{
    (void)state;
    rt_context *ctx = make(1, 0);
    char text[8];
    pthread_t t;
    assert_int_equal(rt_context_error(ctx, text, sizeof text), 0);
    assert_string_equal(text, "");
    assert_int_equal(rti_fail(ctx, RT_ERROR_IO, "%s", "0123456789"), RT_ERROR_IO);
    for (int i = 0; i < 200; i++) {
        pthread_create(&t, NULL, fail_on_thread, ctx);
        pthread_join(t, NULL);
        if (i % 10 == 0)
            rti_fail(ctx, RT_ERROR_IO, "%s", "0123456789");
    }
    assert_int_equal(rt_context_error(ctx, text, sizeof text), 10);
    assert_string_equal(text, "0123456");
    assert_int_equal(rt_context_error(ctx, NULL, 0), 10);
    rt_context_destroy(ctx);
}

static double parse(const char *text)
{
    const char *s = text;
    double x = NAN;
    assert_true(rti_parse_double(&s, text + strlen(text), &x));
    assert_int_equal(*s, 0);
    return x;
}

static void test_numbers(void **state)
{
    (void)state;
    static const char *const hard[] = {"0.1",
                                       "1e23",
                                       "8.98846567431158e307",
                                       "2.2250738585072011e-308",
                                       "4.9e-324",
                                       "2.4703282292062328e-324",
                                       "1.7976931348623157e308",
                                       "9007199254740993",
                                       "9007199254740993.0000000000000000000000000000001",
                                       "0.000000000000000000000000000000000000000000001e45",
                                       "123456789012345678901234567890",
                                       "1e-400",
                                       "1e400",
                                       "7.2057594037927933e16",
                                       "6.631236846766476e-316",
                                       "-0.5e+1",
                                       ".5",
                                       "5."};
    for (size_t i = 0; i < RTI_COUNT(hard); i++) {
        double mine = parse(hard[i]), theirs = strtod(hard[i], NULL);
        assert_memory_equal(&mine, &theirs, sizeof mine);
    }
    uint64_t r = 88172645463325252ull;
    for (int i = 0; i < TEST_MANY(200000); i++) {
        char text[64];
        double x, y;
        r ^= r << 13, r ^= r >> 7, r ^= r << 17;
        memcpy(&x, &r, 8);
        if (!isfinite(x))
            continue;
        snprintf(text, sizeof text, "%.*g", 1 + (int)(r % 25), x);
        y = strtod(text, NULL);
        x = parse(text);
        assert_memory_equal(&x, &y, sizeof x);
        x = y;
        assert_true(parse(rti_num_double(text, x)) == x);
    }
    const char *bad[] = {"", "-", ".", "e5", "+.", "x"};
    for (size_t i = 0; i < RTI_COUNT(bad); i++) {
        const char *s = bad[i];
        double x;
        assert_false(rti_parse_double(&s, bad[i] + strlen(bad[i]), &x));
    }
    const char *s = "9223372036854775808";
    int64_t n;
    assert_false(rti_parse_int(&s, s + 19, &n));
    s = "-9223372036854775808";
    assert_true(rti_parse_int(&s, s + 20, &n) && n == INT64_MIN);
}

static void test_locale(void **state)
{
    (void)state;
    char buffer[32];
    if (!setlocale(LC_NUMERIC, "de_DE.UTF-8") && !setlocale(LC_NUMERIC, "de_DE.utf8"))
        skip();
    assert_string_equal(rti_num(buffer, 0.5f), "0.5");
    assert_string_equal(rti_num_double(buffer, 1234.25), "1234.25");
    assert_true(parse("0.25") == 0.25);
    setlocale(LC_NUMERIC, "C");
}

static void test_text(void **state)
{
    (void)state;
    static const char *const names[] = {"radius", "center", "material"};
    char buffer[24];
    assert_string_equal(rti_nearest("raduis", names, 3), "radius");
    assert_string_equal(rti_nearest("CENTRE", names, 3), "center");
    assert_null(rti_nearest("zzzzzzzz", names, 3));
    assert_string_equal(rti_quote(buffer, sizeof buffer, "a\n\xff\xc3\xa4", 5), "a\\x0a\\xff\xc3\xa4");
    assert_true(strlen(rti_quote(buffer, sizeof buffer, "0123456789012345678901234567890", 31)) < sizeof buffer);
}

static void test_hash(void **state)
{
    (void)state;
    unsigned char data[300];
    char text[33];
    for (unsigned i = 0; i < sizeof data; i++)
        data[i] = (unsigned char)(i * 37);
    for (size_t cut = 0; cut <= sizeof data; cut += 7) {
        rti_hasher h;
        rti_hasher_init(&h);
        rti_hasher_add(&h, data, cut);
        rti_hasher_add(&h, data + cut, sizeof data - cut);
        assert_true(rti_hash_equal(rti_hasher_end(&h), rti_hash_bytes(data, sizeof data)));
    }
    for (size_t i = 0; i < 8 * sizeof data; i++) { /* each bit counts */
        rti_hash before = rti_hash_bytes(data, sizeof data), after;
        data[i / 8] ^= (unsigned char)(1u << (i % 8));
        after = rti_hash_bytes(data, sizeof data);
        data[i / 8] ^= (unsigned char)(1u << (i % 8));
        assert_true(__builtin_popcountll(before.lo ^ after.lo) > 12 && __builtin_popcountll(before.hi ^ after.hi) > 12);
    }
    assert_string_equal(rti_hash_text(text, (rti_hash){0x0123456789abcdefull, 0xfedcba9876543210ull}),
                        "fedcba98765432100123456789abcdef");
}

static void test_files(void **state)
{
    (void)state;
    rt_context *ctx = make(1, 0);
    char folder[] = "/tmp/librt-base-XXXXXX", path[64], text[512];
    void *data;
    size_t size;
    rti_writer *w;
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/a \xff b", folder);
    assert_int_equal(rti_writer_open(ctx, path, &w), RT_OK);
    for (int i = 0; i < 30000; i++)
        rti_writer_write(w, "0123456789", 10);
    assert_int_equal(rti_file_read(ctx, path, 0, &data, &size), RT_ERROR_IO); /* not there before it is whole */
    assert_int_equal(rti_writer_close(w, true), RT_OK);
    assert_int_equal(rti_file_read(ctx, path, 0, &data, &size), RT_OK);
    assert_int_equal(size, 300000);
    assert_memory_equal((char *)data + 299990, "0123456789", 11);
    rti_free(ctx, data, size + 1);
    assert_int_equal(rti_file_read(ctx, path, 299999, &data, &size), RT_ERROR_MEMORY_LIMIT);
    assert_int_equal(rti_writer_open(ctx, path, &w), RT_OK);
    rti_writer_write(w, "x", 1);
    assert_int_equal(rti_writer_close(w, false), RT_OK);
    assert_int_equal(rti_file_read(ctx, path, 0, &data, &size), RT_OK);
    assert_int_equal(size, 300000);
    rti_free(ctx, data, size + 1);
    unlink(path);
    assert_int_equal(rti_file_read(ctx, folder, 0, &data, &size), RT_ERROR_IO);
    rt_context_error(ctx, text, sizeof text);
    assert_non_null(strstr(text, "it is a folder"));
    assert_int_equal(rti_writer_open(ctx, folder, &w), RT_ERROR_IO);
    assert_int_equal(rmdir(folder), 0); /* nothing was left beside */
    snprintf(path, sizeof path, "%s/none/x", folder);
    assert_int_equal(rti_writer_open(ctx, path, &w), RT_ERROR_IO);
    if (access("/dev/full", W_OK) == 0) {
        assert_int_equal(rti_writer_open(ctx, "/dev/full", &w), RT_OK);
        rti_writer_write(w, "x", 1);
        assert_int_equal(rti_writer_close(w, true), RT_ERROR_IO);
        rt_context_error(ctx, text, sizeof text);
        assert_non_null(strstr(text, "the disk is full"));
    }
    rt_context_destroy(ctx);
}

/* What a context's open hook was asked, and what it answers. */
typedef struct hook {
    int answer; /* -1: refuse; RT_OPEN_DEFAULT; 0: open it in `folder` */
    const char *folder, *why;
    char path[256];
    rt_open_mode mode;
    unsigned calls;
} hook;

static int on_open(void *user, const char *path, rt_open_mode mode, char *why, size_t why_size)
{
    hook *h = user;
    snprintf(h->path, sizeof h->path, "%s", path);
    h->mode = mode;
    h->calls++;
    if (h->answer) {
        snprintf(why, why_size, "%s", h->why);
        errno = EACCES;
        return h->answer;
    }
    if (mode == RT_OPEN_FOLDER)
        return open(h->folder, O_RDONLY | O_DIRECTORY);
    return open("/dev/null", O_RDONLY);
}

static void test_open_hook(void **state)
{
    (void)state;
    char folder[] = "/tmp/librt_hook_XXXXXX", inside[64], text[512];
    hook h = {.answer = 0, .why = ""};
    rt_context_desc d = rt_context_desc_default();
    rt_context *ctx;
    rti_writer *w;
    void *data;
    size_t size;
    d.open = on_open;
    d.open_user = &h;
    d.workers = 1;
    assert_int_equal(rt_context_create(&d, &ctx), RT_OK);
    h.folder = mkdtemp(folder);
    assert_non_null(h.folder);
    snprintf(inside, sizeof inside, "%s/x.txt", folder);
    /* the folder decides, not the name's; a link that lies there is replaced, not followed */
    assert_int_equal(symlink("/tmp/librt_hook_must_not_be_made", inside), 0);
    assert_int_equal(rti_writer_open(ctx, "/nowhere/else/x.txt", &w), RT_OK);
    assert_int_equal(h.mode, RT_OPEN_FOLDER);
    assert_string_equal(h.path, "/nowhere/else/x.txt");
    rti_writer_write(w, "abc", 3);
    assert_int_equal(rti_writer_close(w, true), RT_OK);
    assert_int_not_equal(access("/tmp/librt_hook_must_not_be_made", F_OK), 0);
    h.answer = RT_OPEN_DEFAULT;
    assert_int_equal(rti_file_read(ctx, inside, 0, &data, &size), RT_OK);
    assert_int_equal(h.mode, RT_OPEN_READ);
    assert_int_equal(size, 3);
    assert_memory_equal(data, "abc", 3);
    rti_free(ctx, data, size + 1);
    h.answer = 0;
    assert_int_equal(rti_file_read(ctx, inside, 0, &data, &size), RT_ERROR_IO); /* the hook gave a device */
    h.answer = -1;
    h.why = "the host says no";
    assert_int_equal(rti_file_read(ctx, inside, 0, &data, &size), RT_ERROR_IO);
    rt_context_error(ctx, text, sizeof text);
    assert_non_null(strstr(text, "x.txt: cannot open it for reading: the host says no"));
    h.why = "";
    assert_int_equal(rti_writer_open(ctx, inside, &w), RT_ERROR_IO);
    rt_context_error(ctx, text, sizeof text);
    assert_non_null(strstr(text, "permission denied"));
    unsigned calls = h.calls;
    assert_int_equal(rti_writer_open(ctx, "-", &w), RT_OK); /* standard output is not asked for */
    assert_int_equal(rti_writer_close(w, false), RT_OK);
    assert_int_equal(h.calls, calls);
    unlink(inside);
    assert_int_equal(rmdir(folder), 0); /* nothing is left aside */
    rt_context_destroy(ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_memory),       cmocka_unit_test(test_context_desc), cmocka_unit_test(test_parallel),
        cmocka_unit_test(test_many_callers), cmocka_unit_test(test_messages),     cmocka_unit_test(test_numbers),
        cmocka_unit_test(test_locale),       cmocka_unit_test(test_text),         cmocka_unit_test(test_hash),
        cmocka_unit_test(test_files),        cmocka_unit_test(test_open_hook),    cmocka_unit_test(test_shrink),
        cmocka_unit_test(test_settle),       cmocka_unit_test(test_who_refused),
    };
#ifdef __SANITIZE_THREAD__
    cmocka_set_skip_filter("test_numbers"); /* long, and of one thread */
#endif
    return cmocka_run_group_tests(tests, NULL, NULL);
}
