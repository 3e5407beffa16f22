/* Reads cameras.json: {"NAME": {"eye": [x, y, z], "at": [...], "up": [...], "vfov": degrees}, ...}. A reader of JSON that keeps
 * one entry and steps over the rest; the file is a stranger's, so nothing recurses and every number is checked. */
#include "rays.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct reader {
    const char *at, *end;
    const char *wrong; /* what was expected; NULL: nothing is wrong */
} reader;

static void space(reader *r)
{
    while (r->at < r->end && isspace((unsigned char)*r->at))
        r->at++;
}

static bool take(reader *r, char c)
{
    space(r);
    if (r->at >= r->end || *r->at != c)
        return false;
    r->at++;
    return true;
}

static bool expect(reader *r, char c, const char *what)
{
    if (r->wrong)
        return false;
    if (!take(r, c))
        r->wrong = what;
    return !r->wrong;
}

/* A string without its quotes; escapes stay as they are, so a name with one is not found. */
static bool string(reader *r, const char **text, size_t *length)
{
    if (!expect(r, '"', "a string"))
        return false;
    *text = r->at;
    while (r->at < r->end && *r->at != '"')
        r->at += *r->at == '\\' && r->at + 1 < r->end ? 2 : 1;
    *length = (size_t)(r->at - *text);
    return expect(r, '"', "the end of a string");
}

static bool number(reader *r, double *out)
{
    char word[64];
    size_t n = 0;
    char *end;
    space(r);
    while (r->at < r->end && n + 1 < sizeof word && strchr("+-.0123456789eE", *r->at) && *r->at)
        word[n++] = *r->at++;
    word[n] = '\0';
    *out = strtod(word, &end);
    if (n == 0 || *end || !isfinite(*out) || fabs(*out) > 1e12)
        r->wrong = "a number up to 1e12";
    return !r->wrong;
}

static bool numbers(reader *r, double out[3])
{
    expect(r, '[', "a list of three numbers");
    for (int i = 0; i < 3 && !r->wrong; i++) {
        number(r, &out[i]);
        if (i < 2)
            expect(r, ',', "three numbers");
    }
    return expect(r, ']', "the end of a list of three numbers");
}

/* Any value is stepped over: brackets are counted, strings read. */
static void step_over(reader *r)
{
    unsigned long open = 0;
    do {
        const char *text;
        size_t length;
        space(r);
        if (r->at >= r->end) {
            r->wrong = "a value";
        } else if (*r->at == '"') {
            string(r, &text, &length);
        } else if (*r->at == '{' || *r->at == '[') {
            open++;
            r->at++;
        } else if ((*r->at == '}' || *r->at == ']') && open > 0) {
            open--;
            r->at++;
        } else if ((*r->at == ',' || *r->at == ':') && open > 0) {
            r->at++;
        } else {
            const char *from = r->at;
            while (r->at < r->end && !strchr(",:{}[]\" \t\r\n", *r->at))
                r->at++;
            if (r->at == from)
                r->wrong = "a value";
        }
    } while (open > 0 && !r->wrong);
}

static bool is(const char *text, size_t length, const char *word)
{
    return strlen(word) == length && memcmp(text, word, length) == 0;
}

static void view_of(reader *r, bench_view *view)
{
    unsigned seen = 0;
    *view = (bench_view){.up = {0, 1, 0}};
    expect(r, '{', "a camera in braces");
    do {
        const char *key;
        size_t length;
        if (!string(r, &key, &length) || !expect(r, ':', "a colon behind a key"))
            return;
        if (is(key, length, "eye"))
            seen |= numbers(r, view->eye) ? 1u : 0u;
        else if (is(key, length, "at"))
            seen |= numbers(r, view->at) ? 2u : 0u;
        else if (is(key, length, "up"))
            numbers(r, view->up);
        else if (is(key, length, "vfov"))
            seen |= number(r, &view->vfov) ? 4u : 0u;
        else
            step_over(r);
    } while (!r->wrong && take(r, ','));
    expect(r, '}', "the end of a camera");
    if (!r->wrong && (seen != 7 || !(view->vfov > 0 && view->vfov < 180)))
        r->wrong = "eye, at and vfov (between 0 and 180)";
}

int bench_camera_parse(const char *text, size_t size, const char *name, bench_view *view, char *why, size_t why_size)
{
    reader r = {text, text + size, NULL};
    int found = 0;
    expect(&r, '{', "cameras in braces");
    while (!r.wrong && !take(&r, '}')) {
        const char *key;
        size_t length;
        if (!string(&r, &key, &length) || !expect(&r, ':', "a colon behind a name"))
            break;
        if (is(key, length, name)) {
            view_of(&r, view);
            found = 1;
        } else {
            step_over(&r);
        }
        if (!r.wrong && !take(&r, ',')) {
            expect(&r, '}', "a comma or the end of the cameras");
            break;
        }
    }
    if (!r.wrong)
        return found;
    unsigned line = 1;
    for (const char *p = text; p < r.at && p < r.end; p++)
        line += *p == '\n';
    snprintf(why, why_size, "line %u: %s is expected", line, r.wrong);
    return -1;
}

int bench_camera_find(const char *path, const char *name, bool quiet, bench_view *view)
{
    enum { MOST = 1 << 20 };
    char why[160], quoted[400];
    FILE *f = fopen(path, "rb");
    char *text = f ? malloc(MOST) : NULL;
    int result = -1;
    bench_quote(quoted, sizeof quoted, path);
    if (text) {
        size_t size = fread(text, 1, MOST, f);
        if (ferror(f) || size == MOST)
            bench_fail(BENCH_FILE, "%s: %s", quoted,
                       size == MOST ? "a file of cameras has less than a megabyte" : "it cannot be read");
        else if ((result = bench_camera_parse(text, size, name, view, why, sizeof why)) < 0)
            bench_fail(BENCH_FILE, "%s: %s", quoted, why);
    } else if (f || !quiet) {
        bench_fail(BENCH_FILE, "%s cannot be read", quoted);
    } else {
        result = 0;
    }
    free(text);
    if (f)
        fclose(f);
    return result;
}
