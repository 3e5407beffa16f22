/* What tests of readers and writers need: a context whose n-th allocation fails, warnings kept, files in a folder of their own.
 */
#ifndef TEST_FIXTURE_H
#define TEST_FIXTURE_H

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <string.h>
#include <cmocka.h>

#include "base/base.h"

typedef struct test_fixture {
    rt_context *ctx;
    size_t calls;    /* allocations asked for */
    size_t live;     /* blocks not yet freed */
    size_t fail_at;  /* this one and all later ones fail; 0: none */
    char log[16384]; /* warnings, a line each */
    char folder[256];
    char path[600]; /* of the last file named */
} test_fixture;

/* One worker; memory_limit 0: none. The folder is made on the first file. */
void test_begin(test_fixture *t, uint64_t memory_limit);
/* Checks that nothing is left allocated, and removes the folder with its files. */
void test_end(test_fixture *t);

/* For cmocka: begins `test` without a memory limit, ends it. */
extern test_fixture test;
int test_setup(void **state);
int test_teardown(void **state);

/* FOLDER/name, kept in t->path. */
const char *test_path(test_fixture *t, const char *name);
/* Writes a file there; returns its path. */
const char *test_file(test_fixture *t, const char *name, const void *data, size_t size);
/* The file's bytes, from malloc. */
unsigned char *test_slurp(const char *path, size_t *size);

/* The thread's last message. */
const char *test_error(test_fixture *t);
/* Fails unless the last message holds the words. */
void test_says(test_fixture *t, const char *words);

/* Path of a real scene under LIBRT_SCENES in t->path, or NULL when it is not there. */
const char *test_scene(test_fixture *t, const char *name);

#endif
