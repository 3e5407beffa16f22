/* Drives a fuzz target without libFuzzer: every file of the corpus as it is, cut at many places, and changed by seeded mutations.
 * usage: fuzz_NAME CORPUS_FOLDER [ROUNDS] */
#include <dirent.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
/* A target may tell whether it refused the last input at once: of its corpus at least one file must be taken, or nothing behind
 * the first check is tried. */
__attribute__((weak)) int fuzz_refused(void);

typedef struct input {
    uint8_t *data;
    size_t size;
} input;

static uint32_t state = 0x9e3779b9u;

static uint32_t next_random(uint32_t below)
{
    state ^= state << 13;
    state ^= state >> 17;
    state ^= state << 5;
    return below ? state % below : 0;
}

static void fail(const char *what, const char *name)
{
    fprintf(stderr, "%s %s\n", what, name);
    exit(1);
}

static input read_file(const char *path)
{
    input in = {NULL, 0};
    FILE *f = fopen(path, "rb");
    if (!f || fseek(f, 0, SEEK_END) != 0)
        fail("cannot read", path);
    in.size = (size_t)ftell(f);
    in.data = malloc(in.size + 1);
    rewind(f);
    if (!in.data || fread(in.data, 1, in.size, f) != in.size)
        fail("cannot read", path);
    fclose(f);
    return in;
}

static int by_name(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

/* The names are sorted: a folder's order would make each machine's run another one. */
static size_t read_corpus(const char *folder, input **inputs)
{
    char **names = NULL, path[4096];
    size_t count = 0;
    DIR *dir = opendir(folder);
    if (!dir)
        fail("no corpus", folder);
    for (struct dirent *e = readdir(dir); e; e = readdir(dir)) {
        if (e->d_name[0] == '.')
            continue;
        names = realloc(names, (count + 1) * sizeof *names);
        if (!names || !(names[count] = malloc(strlen(e->d_name) + 1)))
            fail("no memory for", e->d_name);
        strcpy(names[count++], e->d_name);
    }
    closedir(dir);
    if (count == 0)
        fail("empty corpus", folder);
    qsort(names, count, sizeof *names, by_name);
    *inputs = malloc(count * sizeof **inputs);
    for (size_t i = 0; *inputs && i < count; ++i) {
        snprintf(path, sizeof path, "%s/%s", folder, names[i]);
        (*inputs)[i] = read_file(path);
        free(names[i]);
    }
    free(names);
    return count;
}

/* A block of exactly the size, so that a sanitizer sees a read behind it. */
static void run(const uint8_t *data, size_t size)
{
    uint8_t *exact = malloc(size ? size : 1);
    if (!exact)
        fail("no memory", "");
    memcpy(exact, data, size);
    LLVMFuzzerTestOneInput(exact, size);
    free(exact);
}

static size_t mutate_once(uint8_t *data, size_t size, const input *other)
{
    static const uint32_t values[] = {0,      1,          0x7f,        0x80,        0xff,       0x7fff,
                                      0xffff, 0x7fffffff, 0x80000000u, 0xffffffffu, 0x7fc00000, 0x7f800000};
    uint32_t at = next_random((uint32_t)size), length = 1 + next_random(16), value = values[next_random(12)];
    if (length > size - at)
        length = (uint32_t)(size - at);
    switch (next_random(7)) {
    case 0: /* one bit */
        data[at] ^= (uint8_t)(1u << next_random(8));
        return size;
    case 1: /* one byte */
        data[at] = (uint8_t)next_random(256);
        return size;
    case 2: /* a number that counts and floats fear */
        for (uint32_t i = 0; i < 4 && at + i < size; ++i)
            data[at + i] = (uint8_t)(value >> 8 * i);
        return size;
    case 3: /* a digit */
        data[at] = (uint8_t)('0' + next_random(10));
        return size;
    case 4: /* a piece out */
        memmove(data + at, data + at + length, size - at - length);
        return size - length;
    case 5: /* a piece of another file */
        for (uint32_t i = 0; i < length && i < other->size; ++i)
            data[at + i] = other->data[(at + i) % other->size];
        return size;
    default: /* the end off */
        return at;
    }
}

int main(int argc, char **argv)
{
    input *inputs = NULL;
    if (argc < 2)
        fail("usage: fuzz_NAME CORPUS_FOLDER", "[ROUNDS]");
    size_t count = read_corpus(argv[1], &inputs);
    int rounds = argc > 2 ? atoi(argv[2]) : 300, taken = 0;
    for (size_t i = 0; i < count; ++i) {
        const input *in = &inputs[i];
        uint8_t *work = malloc(in->size + 1);
        run(in->data, in->size);
        taken |= !fuzz_refused || !fuzz_refused();
        for (size_t cut = 0; cut < in->size; cut += 1 + in->size / 64)
            run(in->data, cut);
        for (int r = 0; work && r < rounds; ++r) {
            size_t size = in->size;
            memcpy(work, in->data, size);
            for (uint32_t m = 1 + next_random(4); m && size; --m)
                size = mutate_once(work, size, &inputs[next_random((uint32_t)count)]);
            run(work, size);
        }
        free(work);
    }
    if (!taken)
        fail("every file is refused: make anew", argv[1]);
    for (size_t i = 0; i < count; ++i)
        free(inputs[i].data);
    free(inputs);
    printf("%zu files, each cut and changed %d times\n", count, rounds);
    return 0;
}
