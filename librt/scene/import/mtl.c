/* Reading MTL libraries: what there is a place for in rt_material_desc (see looks.c); the rest is passed over.
 * Source: Wavefront's "Material Library File (.mtl)" specification, version 4.2. */
#include <math.h>
#include <string.h>

#include "lines.h"

typedef struct mtl_reader {
    rti_model *model;
    char name[300];
    rti_lines lines;
    rti_look *look; /* NULL: none named yet, or one defined before */
    bool dissolve_given;
    uint32_t *table; /* looks by name, open addressing; it does not grow: looks are named by the OBJ file alone */
    size_t table_size;
} mtl_reader;

static rt_status fail(const mtl_reader *r, const char *format, ...) RTI_PRINTF(2, 3);
static rt_status fail(const mtl_reader *r, const char *format, ...)
{
    char text[512];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    return rti_fail(r->model->ctx, RT_ERROR_FORMAT, "%s: line %llu: %s", r->name, (unsigned long long)r->lines.line, text);
}

static size_t slot(const mtl_reader *r, const char *p, size_t n)
{
    size_t at = (size_t)rti_hash_bytes(p, n).lo & (r->table_size - 1);
    while (r->table[at] != UINT32_MAX && !rti_word_is((rti_word){p, n}, r->model->looks[r->table[at]].name))
        at = (at + 1) & (r->table_size - 1);
    return at;
}

static void begin_look(mtl_reader *r)
{
    rti_word w = rti_lines_rest(&r->lines);
    char text[64];
    uint32_t i = r->table[slot(r, w.p, w.n)];
    r->look = NULL;
    r->dissolve_given = false;
    if (i == UINT32_MAX) /* no face uses it */
        return;
    if (r->model->looks[i].defined) {
        rti_model_warn(r->model, "%s: line %llu: material '%s' is defined again; the first one counts", r->name,
                       (unsigned long long)r->lines.line, rti_quote(text, sizeof text, w.p, w.n));
        return;
    }
    r->look = &r->model->looks[i];
    const char *name = r->look->name;
    *r->look = (rti_look){
        .name = name, .defined = true, .diffuse = {1, 1, 1}, .shininess = 1, .opacity = 1, .refraction = 1, .illum = -1};
}

static rt_status number(mtl_reader *r, const char *key, float low, float high, float *out)
{
    char text[40];
    double x;
    if (!rti_lines_number(&r->lines, &x)) {
        rti_word w = rti_lines_word(&r->lines);
        return fail(r, "'%s' needs a number; it has '%s'", key, rti_quote(text, sizeof text, w.p, w.n));
    }
    if (!isfinite((float)x))
        return fail(r, "'%s' is %s, not a finite number", key, rti_num_double((char[32]){0}, x));
    float kept = x < low ? low : x > high ? high : (float)x;
    if (kept != (float)x)
        rti_model_warn(r->model, "%s: line %llu: '%s' is %s; %s was taken", r->name, (unsigned long long)r->lines.line, key,
                       rti_num((char[32]){0}, (float)x), rti_num((char[32]){0}, kept));
    *out = kept;
    return RT_OK;
}

/* "Kd r g b", or one number for all three. Spectral curves and CIE colours keep what was. */
static rt_status colour(mtl_reader *r, const char *key, float high, float out[3])
{
    rti_lines before = r->lines;
    rti_word w = rti_lines_word(&r->lines);
    if (rti_word_is(w, "spectral") || rti_word_is(w, "xyz")) {
        rti_model_warn(r->model, "%s: line %llu: '%s %.8s' is not read; give red, green and blue", r->name,
                       (unsigned long long)r->lines.line, key, w.n == 3 ? "xyz" : "spectral");
        return RT_OK;
    }
    r->lines = before;
    rt_status status = number(r, key, 0, high, &out[0]);
    before = r->lines;
    w = rti_lines_word(&r->lines);
    if (status || w.n == 0 || *w.p == '#') {
        out[1] = out[2] = out[0];
        return status;
    }
    r->lines = before;
    status = number(r, key, 0, high, &out[1]);
    return status ? status : number(r, key, 0, high, &out[2]);
}

/* How many words follow a texture option; -1: none is known of that name. */
static int option_words(rti_word w, bool *numbers)
{
    static const struct {
        const char *name;
        int words; /* 4: one to three numbers */
    } options[] = {{"-blendu", 1}, {"-blendv", 1}, {"-cc", 1},      {"-clamp", 1},     {"-boost", 1},
                   {"-mm", 2},     {"-o", 4},      {"-s", 4},       {"-t", 4},         {"-bm", 1},
                   {"-texres", 1}, {"-type", 1},   {"-imfchan", 1}, {"-colorspace", 1}};
    for (size_t i = 0; i < RTI_COUNT(options); i++) {
        if (rti_word_is(w, options[i].name)) {
            *numbers = options[i].words == 4;
            return *numbers ? 3 : options[i].words;
        }
    }
    return -1;
}

/* The name behind the options; backslashes of other systems become slashes. */
static rt_status texture(mtl_reader *r, const char **out)
{
    rti_word w;
    for (;;) {
        rti_lines before = r->lines;
        bool numbers = false;
        double ignored;
        w = rti_lines_word(&r->lines);
        int words = option_words(w, &numbers);
        if (words < 0) {
            r->lines = before;
            break;
        }
        for (int i = 0; i < words; i++)
            if (!numbers)
                rti_lines_word(&r->lines);
            else if (!rti_lines_number(&r->lines, &ignored))
                break;
    }
    w = rti_lines_rest(&r->lines);
    if (w.n == 0)
        return RT_OK;
    if (memchr(w.p, 0, w.n))
        return fail(r, "a file name with a zero byte");
    char *text = rti_arena_alloc(&r->model->arena, w.n + 1);
    if (!text)
        return rti_fail_memory(r->model->ctx, r->name, w.n + 1);
    for (size_t i = 0; i < w.n; i++)
        text[i] = w.p[i] == '\\' ? '/' : w.p[i];
    text[w.n] = '\0';
    *out = text;
    return RT_OK;
}

static rt_status transparency(mtl_reader *r, bool is_d)
{
    float x = 0;
    rti_lines before = r->lines;
    if (!rti_word_is(rti_lines_word(&r->lines), "-halo"))
        r->lines = before;
    rt_status status = number(r, is_d ? "d" : "Tr", 0, 1, &x);
    if (status)
        return status;
    if (is_d)
        r->look->opacity = x;
    else if (!r->dissolve_given) /* Tr is written both ways round; d is not */
        r->look->opacity = 1 - x;
    r->dissolve_given |= is_d;
    return RT_OK;
}

static rt_status look_line(mtl_reader *r, rti_word key)
{
    rti_look *k = r->look;
    if (rti_word_is(key, "Kd"))
        return colour(r, "Kd", 1, k->diffuse);
    if (rti_word_is(key, "Ks"))
        return colour(r, "Ks", 1, k->specular);
    if (rti_word_is(key, "Ke"))
        return colour(r, "Ke", 1e6f, k->emission);
    if (rti_word_is(key, "Ns"))
        return number(r, "Ns", 0, 100000, &k->shininess);
    if (rti_word_is(key, "Ni"))
        return number(r, "Ni", 0.01f, 100, &k->refraction);
    if (rti_word_is(key, "d") || rti_word_is(key, "Tr"))
        return transparency(r, key.n == 1);
    if (rti_word_is(key, "map_Kd"))
        return texture(r, &k->diffuse_map);
    if (rti_word_is(key, "map_d"))
        return texture(r, &k->opacity_map);
    if (rti_word_is(key, "illum")) {
        float n = 0;
        rt_status status = number(r, "illum", 0, 10, &n);
        if (!status)
            k->illum = (int)n;
        return status;
    }
    return RT_OK; /* Ka, bump and the many extensions */
}

static rt_status fill_table(mtl_reader *r)
{
    rti_model *m = r->model;
    r->table_size = 16;
    while (r->table_size < 2 * m->look_count)
        r->table_size *= 2;
    r->table = rti_alloc_array(m->ctx, r->table_size, sizeof *r->table);
    if (!r->table)
        return rti_fail_memory(m->ctx, r->name, r->table_size * sizeof *r->table);
    memset(r->table, 0xff, r->table_size * sizeof *r->table);
    for (uint32_t i = 0; i < m->look_count; i++)
        r->table[slot(r, m->looks[i].name, strlen(m->looks[i].name))] = i;
    return RT_OK;
}

rt_status rti_mtl_read(rti_model *model, const char *path, const void *bytes, size_t size)
{
    mtl_reader r = {.model = model};
    rti_quote(r.name, sizeof r.name, path, strlen(path));
    rt_status status = fill_table(&r);
    rti_lines_init(&r.lines, bytes, size);
    while (!status && rti_lines_next(&r.lines)) {
        rti_word key = rti_lines_word(&r.lines);
        if (rti_word_is(key, "newmtl"))
            begin_look(&r);
        else if (key.n && *key.p != '#' && r.look)
            status = look_line(&r, key);
    }
    rti_free(model->ctx, r.table, r.table ? r.table_size * sizeof *r.table : 0);
    return status;
}
