/* What the examples share: reading "WIDTHxHEIGHT FILE" and ending with the library's sentence. */
#ifndef EXAMPLES_ARGUMENTS_H
#define EXAMPLES_ARGUMENTS_H

#include <librt/rt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct arguments {
    uint32_t width, height;
    const char *path;
} arguments;

/* Takes [WIDTHxHEIGHT [FILE]] over the defaults in `a`; anything else ends the program with a sentence and status 2. */
static inline arguments arguments_take(int argc, char **argv, arguments a)
{
    if (argc > 1) {
        char *end = argv[1];
        unsigned long width = strtoul(argv[1], &end, 10), height = 0;
        if (*end == 'x')
            height = strtoul(end + 1, &end, 10);
        if (*end != '\0' || width < 1 || height < 1 || width > 16384 || height > 16384) {
            fprintf(stderr, "%s: \"%s\" is no size; write it as %ux%u\n", argv[0], argv[1], (unsigned)a.width,
                    (unsigned)a.height);
            exit(2);
        }
        a.width = (uint32_t)width;
        a.height = (uint32_t)height;
    }
    if (argc > 2)
        a.path = argv[2];
    if (argc > 3) {
        fprintf(stderr, "usage: %s [WIDTHxHEIGHT [FILE]]\n", argv[0]);
        exit(2);
    }
    return a;
}

/* Ends the program with the library's own sentence unless status is RT_OK. */
static inline void must(const rt_context *context, rt_status status)
{
    char sentence[512] = "";
    if (status == RT_OK)
        return;
    if (context)
        rt_context_error(context, sentence, sizeof sentence);
    fprintf(stderr, "%s: %s\n", rt_status_name(status), sentence);
    exit(1);
}

#endif
