#include "fixture.h"

#include <dirent.h>
#include <stdlib.h>
#include <unistd.h>

static void *allocate(void *user, void *ptr, size_t old_size, size_t new_size)
{
    test_fixture *t = user;
    (void)old_size;
    if (new_size == 0) {
        t->live -= ptr != NULL;
        free(ptr);
        return NULL;
    }
    t->calls++;
    if (t->fail_at && t->calls >= t->fail_at)
        return NULL;
    t->live += ptr == NULL;
    return realloc(ptr, new_size);
}

static void keep_log(void *user, rt_log_level level, const char *message)
{
    test_fixture *t = user;
    size_t used = strlen(t->log);
    if (level <= RT_LOG_WARNING)
        snprintf(t->log + used, sizeof t->log - used, "%s\n", message);
}

void test_begin(test_fixture *t, uint64_t memory_limit)
{
    rt_context_desc d = rt_context_desc_default();
    memset(t, 0, sizeof *t);
    d.workers = 1;
    d.allocate = allocate;
    d.allocate_user = t;
    d.log = keep_log;
    d.log_user = t;
    d.memory_limit = memory_limit;
    assert_int_equal(rt_context_create(&d, &t->ctx), RT_OK);
    t->calls = 0;
}

static void empty_folder(const char *folder)
{
    DIR *dir = opendir(folder);
    char path[1024];
    for (struct dirent *e = dir ? readdir(dir) : NULL; e; e = readdir(dir)) {
        snprintf(path, sizeof path, "%s/%s", folder, e->d_name);
        if (strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0 && unlink(path) != 0)
            rmdir(path);
    }
    if (dir)
        closedir(dir);
    rmdir(folder);
}

void test_end(test_fixture *t)
{
    rt_context_destroy(t->ctx);
    if (t->folder[0])
        empty_folder(t->folder);
    assert_int_equal(t->live, 0);
}

test_fixture test;

int test_setup(void **state)
{
    (void)state;
    test_begin(&test, 0);
    return 0;
}

int test_teardown(void **state)
{
    (void)state;
    test_end(&test);
    return 0;
}

const char *test_path(test_fixture *t, const char *name)
{
    if (!t->folder[0]) {
        const char *tmp = getenv("TMPDIR");
        snprintf(t->folder, sizeof t->folder, "%s/librt-test-XXXXXX", tmp ? tmp : "/tmp");
        assert_non_null(mkdtemp(t->folder));
    }
    snprintf(t->path, sizeof t->path, "%s/%s", t->folder, name);
    return t->path;
}

const char *test_file(test_fixture *t, const char *name, const void *data, size_t size)
{
    FILE *f = fopen(test_path(t, name), "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(data, 1, size, f), size);
    assert_int_equal(fclose(f), 0);
    return t->path;
}

unsigned char *test_slurp(const char *path, size_t *size)
{
    FILE *f = fopen(path, "rb");
    assert_non_null(f);
    assert_int_equal(fseek(f, 0, SEEK_END), 0);
    *size = (size_t)ftell(f);
    rewind(f);
    unsigned char *data = malloc(*size + 1);
    assert_non_null(data);
    assert_int_equal(fread(data, 1, *size, f), *size);
    fclose(f);
    return data;
}

const char *test_error(test_fixture *t)
{
    static char text[2048];
    text[0] = '\0';
    rt_context_error(t->ctx, text, sizeof text);
    return text;
}

void test_says(test_fixture *t, const char *words)
{
    if (!strstr(test_error(t), words))
        fail_msg("expected '%s' in: %s", words, test_error(t));
}

const char *test_scene(test_fixture *t, const char *name)
{
    const char *root = getenv("LIBRT_SCENES");
    snprintf(t->path, sizeof t->path, "%s/%s", root ? root : "../shared/scenes", name);
    return access(t->path, R_OK) == 0 ? t->path : NULL;
}
