/* The command line of the ray benchmark, its help, and the sentences it says. */
#include "rays.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

const bench_option bench_option_table[] = {
    {"--sets", "NAME,...", "ray sets: primary, shadow, diffuse, ao, random; all"},
    {"--size", "WxH", "image that the sets are made for; 640x480"},
    {"--tracers", "NAME,...", "tracers of the library; all but brute above 2000 triangles"},
    {"--builders", "NAME,...", "builders of the trees, as rt_commit_desc has them; auto"},
    {"--inputs", "NAME,...",
     "blocks (of 16 rays), single (blocks without a hint), array (plain), one (plain, a call of rt_tracer_intersect or "
     "rt_tracer_occluded for each ray, with RT_RAYS_DEFAULT_FENV), scene (rt_scene_intersect itself, the tracer auto alone); "
     "blocks"},
    {"--threads", "N,...", "threads that trace and build; 1"},
    {"--grab", "N",
     "rays a thread takes at a time, a multiple of 16 from 16 to 1048576; several threads take fewer towards the end; 16384"},
    {"--repeats", "N", "timed repeats, those of all rows interleaved; 5"},
    {"--least", "SECONDS", "a repeat passes over the set until it has taken so long; 0.03"},
    {"--builds", "N", "timed builds of each tree; 0: none; 3"},
    {"--clock", "NAME", "time that the tables show: cpu (of the threads) or wall; the CSV has both; cpu"},
    {"--ceiling", NULL, "from two threads on also the summed rate of as many processes of one thread"},
    {"--against", "NAME",
     "also measure embree, which must be installed (version 3); it gets triangles alone, the scene's own and those of instances "
     "that stand still"},
    {"--embree-modes", "NAME,...", "its interfaces: single, 8, 16, stream; all"},
    {"--embree-qualities", "NAME,...", "its builds: low, medium, high; medium,high"},
    {"--embree-robust", "NAME,...", "its scene flag ROBUST: off, on; both"},
    {"--tolerance", "E", "relative difference of t up to which a hit of Embree is the same; 0.001"},
    {"--reference", "NAME", "tracer that the others' hits are held against, bit for bit; kdtree"},
    {"--check", "N", "rays of each set, evenly spread, that brute force traces too; all of them: 4294967295; 256"},
    {"--camera", "FILE", "cameras.json: {name: {eye, at, up, vfov}}; else the one beside the mesh"},
    {"--eye", "X,Y,Z", "eye of the view"},
    {"--at", "X,Y,Z", "point it looks at"},
    {"--up", "X,Y,Z", "upwards; 0,1,0"},
    {"--fov", "DEGREES", "vertical angle of the view"},
    {"--light", "X,Y,Z", "point light of the set shadow; else chosen"},
    {"--reach", "D", "length of the rays of the set ao; else chosen"},
    {"--seed", "N", "seed of the sets diffuse, ao and random; 1"},
    {"--scenes", "FOLDER", "where scenes named without an ending lie; else $LIBRT_SCENES, else ../shared/scenes"},
    {"--dump", "FOLDER", "write each ray set to FOLDER/SCENE-SET.rays"},
    {"--rays", "FILE", "trace the rays of a file instead of the sets (repeatable)"},
    {"--machine", "NAME", "what the CSV calls the machine; else its processor"},
    {"--preset", "NAME",
     "embree: the table of the goals, --against embree with its scenes; also NAME-1080 for 1920x1080, NAME-threads"},
    {"--output", "FILE", "write the CSV to FILE (-o)"},
    {"--quiet", NULL, "no word of what is under way"},
    {"--help", NULL, "this text (-h)"},
    {NULL, NULL, NULL},
};

const char *bench_speaker = "rays";

int bench_fail(int status, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    fprintf(stderr, "%s: ", bench_speaker);
    vfprintf(stderr, format, args);
    fputc('\n', stderr);
    va_end(args);
    return status;
}

const char *bench_quote(char *buffer, size_t size, const char *text)
{
    size_t used = 0;
    for (const unsigned char *p = (const unsigned char *)text; *p && used + 5 < size; p++) {
        if (*p < 32 || *p == 127)
            used += (size_t)snprintf(buffer + used, size - used, "\\%03o", *p);
        else
            buffer[used++] = (char)*p;
    }
    buffer[used] = '\0';
    return buffer;
}

bool bench_names_has(const bench_names *names, const char *name)
{
    for (uint32_t i = 0; i < names->count; i++)
        if (strcmp(names->name[i], name) == 0)
            return true;
    return false;
}

/* ---- values ---- */

static int bad(const char *option, const char *text, const char *expected)
{
    char quoted[200];
    return bench_fail(BENCH_USAGE, "%s '%s': %s is expected", option, bench_quote(quoted, sizeof quoted, text), expected);
}

/* Words between commas, each one of `known` (NULL: any). */
static int take_names(const char *option, const char *text, const char *const *known, const char *expected, bench_names *out)
{
    memset(out, 0, sizeof *out);
    for (const char *at = text; at;) {
        const char *comma = strchr(at, ',');
        size_t length = comma ? (size_t)(comma - at) : strlen(at);
        char *name = out->name[out->count];
        bool found = known == NULL;
        if (length == 0 || length >= BENCH_NAME || out->count == BENCH_NAMES)
            return bad(option, text, expected);
        memcpy(name, at, length);
        name[length] = '\0';
        for (const char *const *k = known; k && *k; k++)
            found |= strcmp(*k, name) == 0;
        if (!found)
            return bad(option, text, expected);
        out->count++;
        at = comma ? comma + 1 : NULL;
    }
    return BENCH_OK;
}

static bool read_u64(const char *text, uint64_t low, uint64_t high, uint64_t *out)
{
    uint64_t value = 0;
    if (!*text)
        return false;
    for (; *text; text++) {
        unsigned digit = (unsigned)(*text - '0');
        if (digit > 9 || value > (UINT64_MAX - digit) / 10)
            return false;
        value = value * 10 + digit;
    }
    *out = value;
    return value >= low && value <= high;
}

static int take_u32(const char *option, const char *text, uint32_t low, uint32_t high, uint32_t *out)
{
    uint64_t value;
    char expected[80];
    snprintf(expected, sizeof expected, "a whole number from %u to %u", low, high);
    if (!read_u64(text, low, high, &value))
        return bad(option, text, expected);
    *out = (uint32_t)value;
    return BENCH_OK;
}

static bool read_double(const char *text, char stop, double *out, const char **rest)
{
    char *end;
    *out = strtod(text, &end);
    *rest = end;
    return end != text && isfinite(*out) && fabs(*out) <= 1e12 && *end == stop;
}

static int take_double(const char *option, const char *text, double low, double high, double *out)
{
    const char *rest;
    char expected[80];
    snprintf(expected, sizeof expected, "a number from %g to %g", low, high);
    if (!read_double(text, '\0', out, &rest) || *out < low || *out > high)
        return bad(option, text, expected);
    return BENCH_OK;
}

static int take_point(const char *option, const char *text, double out[3])
{
    const char *at = text;
    for (int i = 0; i < 3; i++) {
        if (!read_double(at, i < 2 ? ',' : '\0', &out[i], &at))
            return bad(option, text, "X,Y,Z with numbers");
        at++;
    }
    return BENCH_OK;
}

static int take_size(const char *text, bench_options *o)
{
    char word[32];
    uint64_t w, h;
    const char *x = strchr(text, 'x');
    if (!x || (size_t)(x - text) >= sizeof word)
        return bad("--size", text, "WIDTHxHEIGHT, as in 640x480,");
    memcpy(word, text, (size_t)(x - text));
    word[x - text] = '\0';
    if (!read_u64(word, 1, 16384, &w) || !read_u64(x + 1, 1, 16384, &h))
        return bad("--size", text, "WIDTHxHEIGHT, each from 1 to 16384,");
    o->width = (uint32_t)w;
    o->height = (uint32_t)h;
    return BENCH_OK;
}

static int take_threads(const char *text, bench_options *o)
{
    bench_names names;
    uint64_t n;
    if (take_names("--threads", text, NULL, "numbers with commas between", &names) != BENCH_OK)
        return BENCH_USAGE;
    for (uint32_t i = 0; i < names.count; i++) {
        if (!read_u64(names.name[i], 1, 256, &n))
            return bad("--threads", text, "numbers from 1 to 256 with commas between");
        o->threads[i] = (uint32_t)n;
    }
    o->thread_count = names.count;
    return BENCH_OK;
}

/* ---- presets ---- */

static const char *const goal_scenes[] = {"sponza", "sibenik", "classroom", "staircase", "breakfast", "bunny", "sphere"};

#define GOALS (sizeof goal_scenes / sizeof *goal_scenes)

static void fill_names(bench_names *out, const char *text)
{
    (void)take_names("preset", text, NULL, "names", out);
}

static int take_preset(const char *text, bench_options *o)
{
    if (strcmp(text, "embree") != 0 && strcmp(text, "embree-1080") != 0 && strcmp(text, "embree-threads") != 0)
        return bad("--preset", text, "embree, embree-1080 or embree-threads");
    o->embree = true;
    fill_names(&o->inputs, "blocks,single,array,one,scene");
    if (strcmp(text, "embree-1080") == 0) {
        o->width = 1920;
        o->height = 1080;
        fill_names(&o->sets, "primary,shadow");
        fill_names(&o->inputs, "blocks");
    } else if (strcmp(text, "embree-threads") == 0) {
        uint32_t n = rt_cpu_count();
        o->thread_count = 0;
        for (uint32_t t = 1; t <= n && o->thread_count < BENCH_NAMES; t *= 2)
            o->threads[o->thread_count++] = t;
        o->ceiling = o->wall = true;
        fill_names(&o->inputs, "blocks");
        fill_names(&o->modes, "16");
        fill_names(&o->qualities, "medium");
        fill_names(&o->robust, "off");
    }
    o->goals = true;
    return BENCH_OK;
}

/* ---- the command line ---- */

static int take_files(const char *option, const char *text, bench_options *o)
{
    if (!*text)
        return bad(option, text, "the name of a file or folder");
    if (strcmp(option, "--camera") == 0)
        o->cameras = text;
    else if (strcmp(option, "--scenes") == 0)
        o->folder = text;
    else if (strcmp(option, "--dump") == 0)
        o->dump = text;
    else if (strcmp(option, "--rays") == 0)
        o->files[o->file_count++] = text;
    else if (strcmp(option, "--machine") == 0)
        o->machine = text;
    else
        o->output = text;
    return BENCH_OK;
}

static int take_list(const char *n, const char *v, bench_options *o)
{
    static const char *const inputs[] = {"blocks", "single", "array", "one", "scene", NULL}, *const modes[] = {"single", "8",
                                                                                                               "16", "stream",
                                                                                                               NULL};
    static const char *const qualities[] = {"low", "medium", "high", NULL}, *const robust[] = {"off", "on", NULL};
    static const char *const sets[] = {"primary", "shadow", "diffuse", "ao", "random", NULL};
    if (strcmp(n, "--sets") == 0)
        return take_names(n, v, sets, "a list of primary, shadow, diffuse, ao, random", &o->sets);
    if (strcmp(n, "--tracers") == 0)
        return take_names(n, v, NULL, "a list of tracers", &o->tracers);
    if (strcmp(n, "--builders") == 0)
        return take_names(n, v, NULL, "a list of builders", &o->builders);
    if (strcmp(n, "--inputs") == 0)
        return take_names(n, v, inputs, "a list of blocks, single, array, one, scene", &o->inputs);
    if (strcmp(n, "--embree-modes") == 0)
        return take_names(n, v, modes, "a list of single, 8, 16, stream", &o->modes);
    if (strcmp(n, "--embree-qualities") == 0)
        return take_names(n, v, qualities, "a list of low, medium, high", &o->qualities);
    if (strcmp(n, "--embree-robust") == 0)
        return take_names(n, v, robust, "a list of off, on", &o->robust);
    return -1;
}

static int take_number(const char *n, const char *v, bench_options *o)
{
    if (strcmp(n, "--grab") == 0) {
        if (take_u32(n, v, 16, 1048576, &o->grab) != BENCH_OK)
            return BENCH_USAGE;
        return o->grab % 16 == 0 ? BENCH_OK : bad(n, v, "a multiple of 16");
    }
    if (strcmp(n, "--repeats") == 0)
        return take_u32(n, v, 1, 1000, &o->repeats);
    if (strcmp(n, "--builds") == 0)
        return take_u32(n, v, 0, 1000, &o->builds);
    if (strcmp(n, "--check") == 0)
        return take_u32(n, v, 0, UINT32_MAX, &o->check);
    if (strcmp(n, "--least") == 0)
        return take_double(n, v, 0, 1000, &o->least);
    if (strcmp(n, "--tolerance") == 0)
        return take_double(n, v, 0, 1, &o->tolerance);
    if (strcmp(n, "--reach") == 0)
        return take_double(n, v, 1e-12, 1e12, &o->reach);
    if (strcmp(n, "--fov") == 0)
        return take_double(n, v, 0.01, 179, &o->view.vfov);
    if (strcmp(n, "--seed") == 0)
        return read_u64(v, 0, UINT64_MAX, &o->seed) ? BENCH_OK : bad(n, v, "a whole number from 0 to 2^64 - 1");
    return -1;
}

static int take_value(const char *n, const char *v, bench_options *o)
{
    int status = take_list(n, v, o);
    if (status < 0)
        status = take_number(n, v, o);
    if (status >= 0)
        return status;
    if (strcmp(n, "--size") == 0)
        return take_size(v, o);
    if (strcmp(n, "--threads") == 0)
        return take_threads(v, o);
    if (strcmp(n, "--preset") == 0)
        return take_preset(v, o);
    if (strcmp(n, "--up") == 0)
        return take_point(n, v, o->view.up);
    if (strcmp(n, "--eye") == 0)
        return take_point(n, v, o->view.eye) == BENCH_OK ? (o->has_eye = true, BENCH_OK) : BENCH_USAGE;
    if (strcmp(n, "--at") == 0)
        return take_point(n, v, o->view.at) == BENCH_OK ? (o->has_at = true, BENCH_OK) : BENCH_USAGE;
    if (strcmp(n, "--light") == 0)
        return take_point(n, v, o->light) == BENCH_OK ? (o->has_light = true, BENCH_OK) : BENCH_USAGE;
    if (strcmp(n, "--clock") == 0) {
        o->wall = strcmp(v, "wall") == 0;
        return o->wall || strcmp(v, "cpu") == 0 ? BENCH_OK : bad(n, v, "cpu or wall");
    }
    if (strcmp(n, "--against") == 0) {
        o->embree = strcmp(v, "embree") == 0;
        return o->embree ? BENCH_OK : bad(n, v, "embree");
    }
    if (strcmp(n, "--reference") == 0) {
        if (!*v || strlen(v) >= sizeof o->reference)
            return bad(n, v, "a tracer's name");
        strcpy(o->reference, v);
        return BENCH_OK;
    }
    return take_files(n, v, o);
}

static void take_switch(const char *n, bench_options *o)
{
    o->ceiling |= strcmp(n, "--ceiling") == 0;
    o->quiet |= strcmp(n, "--quiet") == 0;
    o->help |= strcmp(n, "--help") == 0;
}

static const bench_option *find_option(const char *text, size_t length)
{
    for (const bench_option *row = bench_option_table; row->name; row++)
        if (strlen(row->name) == length && memcmp(row->name, text, length) == 0)
            return row;
    return NULL;
}

static bool defaults(int argc, bench_options *o)
{
    size_t room = (size_t)argc + GOALS;
    memset(o, 0, sizeof *o);
    fill_names(&o->sets, "primary,shadow,diffuse,ao,random");
    fill_names(&o->builders, "auto");
    fill_names(&o->inputs, "blocks");
    fill_names(&o->modes, "single,8,16,stream");
    fill_names(&o->qualities, "medium,high");
    fill_names(&o->robust, "off,on");
    o->width = 640;
    o->height = 480;
    o->threads[0] = o->thread_count = 1;
    o->grab = 16384;
    o->repeats = 5;
    o->builds = 3;
    o->check = 256;
    o->least = 0.03;
    o->tolerance = 1e-3;
    o->seed = 1;
    o->view.up[1] = 1;
    strcpy(o->reference, "kdtree");
    o->scenes = calloc(room, sizeof *o->scenes);
    o->files = calloc(room, sizeof *o->files);
    return o->scenes && o->files;
}

void bench_options_free(bench_options *o)
{
    free(o->scenes);
    free(o->files);
    o->scenes = o->files = NULL;
}

int bench_options_parse(int argc, char **argv, bench_options *o)
{
    bool only_names = false;
    if (!defaults(argc, o))
        return bench_fail(BENCH_MACHINE, "out of memory");
    for (int i = 1; i < argc; i++) {
        const char *arg = argv[i], *value = NULL;
        const char *equals = strchr(arg, '=');
        const bench_option *row;
        char quoted[200];
        if (only_names || arg[0] != '-') {
            o->scenes[o->scene_count++] = arg;
            continue;
        }
        if (strcmp(arg, "--") == 0) {
            only_names = true;
            continue;
        }
        arg = strcmp(arg, "-o") == 0 ? "--output" : strcmp(arg, "-h") == 0 ? "--help" : strcmp(arg, "-q") == 0 ? "--quiet" : arg;
        row = find_option(arg, arg == argv[i] && equals ? (size_t)(equals - arg) : strlen(arg));
        if (!row)
            return bench_fail(BENCH_USAGE, "unknown option '%s'; --help lists them", bench_quote(quoted, sizeof quoted, arg));
        if (arg == argv[i] && equals)
            value = equals + 1;
        if (!row->value && value)
            return bench_fail(BENCH_USAGE, "%s takes no value", row->name);
        if (!row->value) {
            take_switch(row->name, o);
            continue;
        }
        if (!value && i + 1 < argc)
            value = argv[++i];
        if (!value)
            return bench_fail(BENCH_USAGE, "%s needs a value: %s", row->name, row->value);
        if (take_value(row->name, value, o) != BENCH_OK)
            return BENCH_USAGE;
    }
    for (size_t i = 0; o->goals && i < GOALS && o->scene_count == i; i++)
        o->scenes[o->scene_count++] = goal_scenes[i];
    if (!o->help && o->scene_count == 0)
        return bench_fail(BENCH_USAGE, "a scene is missing: a mesh file, or a name as sponza or sphere; --help tells more");
    if (o->has_eye != o->has_at)
        return bench_fail(BENCH_USAGE, "--eye and --at stand together");
    return BENCH_OK;
}
