/* Text entries of image files: written, read back, and files that lie. */
#include "../support/fixture.h"

#include <stdlib.h>
#include <unistd.h>

#include "librt/image.h"
#include "render/image_text.h"

typedef struct entries {
    uint32_t count, stop_after;
    char keys[16][80];
    char *values[16];
} entries;

static int keep(void *user, const char *key, const char *value)
{
    entries *e = user;
    assert_true(e->count < 16);
    snprintf(e->keys[e->count], sizeof e->keys[0], "%s", key);
    e->values[e->count] = malloc(strlen(value) + 1);
    strcpy(e->values[e->count++], value);
    return e->stop_after && e->count == e->stop_after;
}

static void drop(entries *e)
{
    for (uint32_t i = 0; i < e->count; i++)
        free(e->values[i]);
    e->count = 0;
}

static const char *value_of(const entries *e, const char *key)
{
    for (uint32_t i = 0; i < e->count; i++) {
        if (strcmp(e->keys[i], key) == 0)
            return e->values[i];
    }
    return NULL;
}

static rt_image *black(uint32_t width, uint32_t height)
{
    rt_image *image;
    assert_int_equal(rt_image_create(test.ctx, width, height, &image), RT_OK);
    return image;
}

/* Whatever the bytes of a value are, they come back; long ones too; in PNG and HDR. */
static void test_round_trip(void **state)
{
    static const char *const odd[] = {"",
                                      "plain",
                                      "M\xc3\xbcller",
                                      "not \xff\xfe UTF-8",
                                      "two\nlines\r\n\n\nand a \\ and \\n",
                                      "\n",
                                      "<script>$(x)%s\"'\t\x01",
                                      "a=b=c #+ # FORMAT=x\n#+\n# k=v\n-Y 1 +X 1\n\n"};
    static const char *const names[] = {"a.png", "a.hdr"};
    rt_image *image = black(9, 2), *back;
    char *large = malloc(100001), key[16];
    entries e = {0};
    (void)state;
    for (size_t i = 0; i < 100000; i++)
        large[i] = "abc\n\\\xc3\xa4 ="[i * i % 9];
    large[100000] = 0;
    for (uint32_t i = 0; i < RTI_COUNT(odd); i++) {
        snprintf(key, sizeof key, "odd =\\%u", i);
        assert_int_equal(rt_image_set_text(image, key, odd[i]), RT_OK);
    }
    assert_int_equal(rt_image_set_text(image, "Script", large), RT_OK);
    for (uint32_t f = 0; f < 2; f++) {
        assert_int_equal(rt_image_save(image, test_path(&test, names[f]), NULL), RT_OK);
        if (rt_image_read_texts(test.ctx, test.path, keep, &e) != RT_OK)
            fail_msg("%s", test_error(&test));
        assert_int_equal(e.count, RTI_COUNT(odd) + 1);
        for (uint32_t i = 0; i < RTI_COUNT(odd); i++) {
            snprintf(key, sizeof key, "odd =\\%u", i);
            assert_string_equal(e.keys[i], key);
            assert_string_equal(e.values[i], odd[i]);
        }
        assert_string_equal(value_of(&e, "Script"), large);
        drop(&e);
        e.stop_after = 3;
        assert_int_equal(rt_image_read_texts(test.ctx, test.path, keep, &e), RT_OK);
        assert_int_equal(e.count, 3);
        drop(&e);
        e.stop_after = 0;
        rt_status status = rt_image_load(test.ctx, test.path, &back); /* the pixels are found behind the texts */
        assert_true(status == RT_OK || (f == 0 && status == RT_ERROR_UNSUPPORTED));
        rt_image_destroy(back);
    }
    free(large);
    rt_image_destroy(image);
}

/* No line of an HDR head is longer than old readers take, and none of a value's lines ends the head. */
static void test_hdr_lines(void **state)
{
    rt_image *image = black(1, 1);
    size_t size, longest = 0, line = 0;
    char value[2001];
    (void)state;
    memset(value, '\n', 2000);
    value[2000] = 0;
    assert_int_equal(rt_image_set_text(image, "k", value), RT_OK);
    assert_int_equal(rt_image_save(image, test_path(&test, "a.hdr"), NULL), RT_OK);
    unsigned char *bytes = test_slurp(test.path, &size);
    for (size_t i = 0; i < size && !(i && bytes[i] == '\n' && bytes[i - 1] == '\n'); i++) {
        line = bytes[i] == '\n' ? 0 : line + 1;
        longest = line > longest ? line : longest;
    }
    assert_true(longest > 150 && longest < 400);
    free(bytes);
    rt_image_destroy(image);
}

/* Entries of the descriptor come behind the image's own and replace equal keys. */
static void test_of_descriptor(void **state)
{
    static const rt_text more[] = {{"Title", "new"}, {"Hash", "00ff"}};
    rt_text bad[] = {{"two  spaces", "x"}};
    rt_save_desc d = rt_save_desc_default();
    rt_image *image = black(2, 2);
    entries e = {0};
    (void)state;
    assert_int_equal(rt_image_set_text(image, "Title", "old"), RT_OK);
    assert_int_equal(rt_image_set_text(image, "Author", "me"), RT_OK);
    d.texts = more;
    d.text_count = 2;
    assert_int_equal(rt_image_save(image, test_path(&test, "a.png"), &d), RT_OK);
    assert_int_equal(rt_image_read_texts(test.ctx, test.path, keep, &e), RT_OK);
    assert_int_equal(e.count, 3);
    assert_string_equal(e.values[0], "new");
    assert_string_equal(e.values[1], "me");
    assert_string_equal(e.values[2], "00ff");
    assert_string_equal(rt_image_get_text(image, "Title"), "old");
    drop(&e);
    d.no_text = 1;
    assert_int_equal(rt_image_save(image, test.path, &d), RT_OK);
    assert_int_equal(rt_image_read_texts(test.ctx, test.path, keep, &e), RT_OK);
    assert_int_equal(e.count, 0);
    d.no_text = 0;
    d.texts = bad;
    d.text_count = 1;
    assert_int_equal(rt_image_save(image, test.path, &d), RT_ERROR_ARGUMENT);
    test_says(&test, "two  spaces");
    d.texts = NULL;
    assert_int_equal(rt_image_save(image, test.path, &d), RT_ERROR_ARGUMENT);
    assert_int_equal(rt_image_set_text(image, " k", ""), RT_ERROR_ARGUMENT);
    assert_int_equal(rt_image_set_text(image, "k\xc3\xa4", ""), RT_ERROR_ARGUMENT);
    assert_int_equal(rt_image_set_text(image, "k\n", ""), RT_ERROR_ARGUMENT);
    rt_image_destroy(image);
}

static const char *foreign(void)
{
    const char *references = getenv("LIBRT_REFERENCES");
    snprintf(test.path, sizeof test.path, "%s/../fuzz/corpus/image_text/kinds.png", references ? references : "tests/reference");
    return test.path;
}

/* A file of zlib's making: every kind of chunk and of compressed block, before and behind the pixels. */
static void test_foreign(void **state)
{
    char text[3001];
    uint32_t x = 1;
    entries e = {0};
    (void)state;
    for (uint32_t i = 0; i < 3000; i++) { /* as the file's maker did */
        x = (x * 1103515245u + 12345u) & 0x7fffffffu;
        text[i] = "abcdefgh \n"[(x >> 16) % 10];
    }
    text[3000] = 0;
    if (rt_image_read_texts(test.ctx, foreign(), keep, &e) != RT_OK)
        fail_msg("%s", test_error(&test));
    assert_int_equal(e.count, 6);
    assert_string_equal(value_of(&e, "Title"), "caf\xc3\xa9");
    assert_string_equal(value_of(&e, "Author"), "M\xc3\xbcller");
    assert_string_equal(value_of(&e, "Dynamic"), text);
    assert_string_equal(value_of(&e, "Fixed"), text);
    assert_string_equal(value_of(&e, "Stored"), text);
    assert_string_equal(e.values[5], "again");
    drop(&e);
}

/* Every cut of it is an error or tells less; every changed byte of a text chunk is seen. */
static void test_damaged(void **state)
{
    size_t size;
    entries e = {0};
    (void)state;
    unsigned char *bytes = test_slurp(foreign(), &size);
    for (size_t cut = 0; cut < size; cut++) {
        unsigned char *copy = malloc(cut ? cut : 1); /* of its size: a sanitizer sees a byte too far */
        memcpy(copy, bytes, cut);
        assert_int_equal(rti_texts_decode(test.ctx, "cut.png", copy, cut, true, keep, &e), RT_ERROR_FORMAT);
        test_says(&test, "cut.png");
        drop(&e);
        free(copy);
    }
    for (size_t i = 41; i < 51; i++) { /* the first text chunk's data and checksum, behind the header's 33 bytes */
        bytes[i] ^= 4;
        assert_int_equal(rti_texts_decode(test.ctx, "x.png", bytes, size, true, keep, &e), RT_ERROR_FORMAT);
        test_says(&test, "checksum");
        bytes[i] ^= 4;
    }
    assert_int_equal(e.count, 0);
    free(bytes);
}

/* 200 bytes that unpack to more than is allowed, and to a wrong sum. */
static void test_inflate(void **state)
{
    static const uint8_t zeros[] = {0x78, 0xda, 0x4b, 0x4c, 0x4a, 0x06, 0x00, 0x02, 0x4d, 0x01, 0x27}; /* "abc" */
    uint8_t *out, wrong[sizeof zeros];
    size_t size, capacity;
    (void)state;
    assert_null(rti_inflate(test.ctx, zeros, sizeof zeros, 3, &out, &size, &capacity));
    assert_int_equal(size, 3);
    assert_memory_equal(out, "abc", 4);
    rti_free(test.ctx, out, capacity);
    assert_non_null(strstr(rti_inflate(test.ctx, zeros, sizeof zeros, 2, &out, &size, &capacity), "more than is allowed"));
    assert_null(out);
    for (size_t n = 0; n < sizeof zeros; n++)
        assert_non_null(rti_inflate(test.ctx, zeros, n, 100, &out, &size, &capacity));
    memcpy(wrong, zeros, sizeof zeros);
    wrong[10] ^= 1;
    assert_non_null(strstr(rti_inflate(test.ctx, wrong, sizeof wrong, 100, &out, &size, &capacity), "checksum"));
}

static void test_refused(void **state)
{
    entries e = {0};
    (void)state;
    assert_int_equal(rt_image_read_texts(test.ctx, test_path(&test, "none.png"), keep, &e), RT_ERROR_IO);
    test_says(&test, "none.png");
    assert_int_equal(rt_image_read_texts(test.ctx, test_file(&test, "x.png", "hello", 5), keep, &e), RT_ERROR_FORMAT);
    test_says(&test, "not a PNG");
    assert_int_equal(rt_image_read_texts(test.ctx, test_file(&test, "e.png", "", 0), keep, &e), RT_ERROR_FORMAT);
    assert_int_equal(rt_image_read_texts(test.ctx, test.folder, keep, &e), RT_ERROR_IO);
    assert_int_equal(rt_image_read_texts(test.ctx, NULL, keep, &e), RT_ERROR_ARGUMENT);
    assert_int_equal(rt_image_read_texts(test.ctx, test.path, NULL, &e), RT_ERROR_ARGUMENT);
    assert_int_equal(rt_image_read_texts(test.ctx, test_file(&test, "h.hdr", "#?RADIANCE\n# a=b\n", 17), keep, &e),
                     RT_ERROR_FORMAT);
    test_says(&test, "no end");
    assert_int_equal(rt_image_read_texts(test.ctx, test_file(&test, "b.bmp", "BM..................", 20), keep, &e), RT_OK);
    assert_int_equal(e.count, 0);
}

static void test_no_memory(void **state)
{
    static const rt_text more[] = {{"Title", "a \\ value"}};
    static const char *const names[] = {"a.png", "a.hdr"};
    rt_save_desc d = rt_save_desc_default();
    rt_image *image = black(2, 2);
    (void)state;
    d.texts = more;
    d.text_count = 1;
    for (int kind = 0; kind < 3; kind++) {
        rt_status status;
        size_t n = 0;
        entries e = {0};
        if (kind < 2)
            assert_int_equal(rt_image_save(image, test_path(&test, names[kind]), &d), RT_OK);
        else
            foreign();
        do {
            test.calls = 0;
            test.fail_at = ++n;
            status = rt_image_read_texts(test.ctx, test.path, keep, &e);
            assert_true(status == RT_OK || status == RT_ERROR_MEMORY);
            drop(&e);
        } while (status != RT_OK);
        test.fail_at = 0;
        assert_true(n > 2);
    }
    rt_image_destroy(image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_round_trip, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_hdr_lines, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_of_descriptor, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_foreign, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_damaged, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_inflate, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_refused, test_setup, test_teardown),
        cmocka_unit_test_setup_teardown(test_no_memory, test_setup, test_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
