/* The header of a PLY file. Source: G. Turk, "The PLY Polygon File Format", 1994. */
#include "ply.h"

#include <string.h>

typedef struct word {
    const char *p;
    size_t n;
} word;

static bool is(word w, const char *s)
{
    return w.n == strlen(s) && memcmp(w.p, s, w.n) == 0;
}

static const char *shown(char *buffer, size_t size, word w)
{
    return rti_quote(buffer, size, w.p, w.n);
}

rt_status rti_ply_fail(const ply *f, const char *format, ...)
{
    char text[512];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    if (f->coding == PLY_ASCII)
        return rti_fail(f->model->ctx, RT_ERROR_FORMAT, "%s: line %llu: %s", f->model->name, (unsigned long long)f->line, text);
    return rti_fail(f->model->ctx, RT_ERROR_FORMAT, "%s: byte %zu: %s", f->model->name, (size_t)(f->p - f->start), text);
}

static word next_word(const char **p, const char *end)
{
    while (*p < end && (**p == ' ' || **p == '\t'))
        (*p)++;
    word w = {*p, 0};
    while (*p < end && **p != ' ' && **p != '\t' && **p != '\r')
        (*p)++;
    w.n = (size_t)(*p - w.p);
    return w;
}

static uint8_t type_of(word w)
{
    static const char *const names[] = {"char", "uchar", "short", "ushort", "int", "uint", "float", "double"};
    static const char *const sized[] = {"int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"};
    for (unsigned i = 0; i < PLY_NO_TYPE; i++)
        if (is(w, names[i]) || is(w, sized[i]))
            return (uint8_t)i;
    return PLY_NO_TYPE;
}

static uint8_t use_of(uint8_t kind, word name, bool list)
{
    static const struct {
        const char *name;
        uint8_t use;
    } vertex[] = {{"x", PLY_X},
                  {"y", PLY_Y},
                  {"z", PLY_Z},
                  {"nx", PLY_NX},
                  {"ny", PLY_NY},
                  {"nz", PLY_NZ},
                  {"red", PLY_R},
                  {"green", PLY_G},
                  {"blue", PLY_B},
                  {"r", PLY_R},
                  {"g", PLY_G},
                  {"b", PLY_B},
                  {"diffuse_red", PLY_R},
                  {"diffuse_green", PLY_G},
                  {"diffuse_blue", PLY_B},
                  {"u", PLY_U},
                  {"v", PLY_V},
                  {"s", PLY_U},
                  {"t", PLY_V},
                  {"texture_u", PLY_U},
                  {"texture_v", PLY_V},
                  {"texture_s", PLY_U},
                  {"texture_t", PLY_V}};
    if (kind == PLY_VERTEX && !list)
        for (size_t i = 0; i < RTI_COUNT(vertex); i++)
            if (is(name, vertex[i].name))
                return vertex[i].use;
    if ((kind == PLY_FACE || kind == PLY_STRIP) && list && (is(name, "vertex_indices") || is(name, "vertex_index")))
        return PLY_CORNERS;
    return PLY_UNUSED;
}

static rt_status no_memory(const ply *f, size_t size)
{
    return rti_fail_memory(f->model->ctx, f->model->name, size);
}

static rt_status add_element(ply *f, const char *p, const char *end)
{
    char text[64];
    word name = next_word(&p, end), count = next_word(&p, end);
    const char *digits = count.p;
    int64_t n;
    if (name.n == 0 || !rti_parse_int(&digits, count.p + count.n, &n) || digits != count.p + count.n || n < 0)
        return rti_ply_fail(f, "'element' needs a name and a count from 0, as 'element vertex 8'; it has '%s'",
                            shown(text, sizeof text, count));
    if (!rti_reserve(f->model->ctx, (void **)&f->elements, &f->element_capacity, f->element_count, 1, sizeof *f->elements))
        return no_memory(f, sizeof *f->elements);
    uint8_t kind = is(name, "vertex") ? PLY_VERTEX : is(name, "face") ? PLY_FACE : is(name, "tristrips") ? PLY_STRIP : PLY_OTHER;
    for (size_t i = 0; i < f->element_count; i++)
        if (kind != PLY_OTHER && f->elements[i].kind == kind)
            return rti_ply_fail(f, "element '%s' is declared twice", shown(text, sizeof text, name));
    f->elements[f->element_count++] = (ply_element){kind, (uint64_t)n, f->property_count, 0};
    return RT_OK;
}

static rt_status add_property(ply *f, const char *p, const char *end)
{
    char text[64];
    uint8_t count_type = PLY_NO_TYPE;
    if (f->element_count == 0)
        return rti_ply_fail(f, "'property' stands before any 'element'");
    word w = next_word(&p, end);
    bool list = is(w, "list");
    if (list) {
        w = next_word(&p, end);
        count_type = type_of(w);
        if (count_type >= PLY_F32)
            return rti_ply_fail(f, "'%s' cannot be the type of a list's count; uchar, ushort or int can",
                                shown(text, sizeof text, w));
        w = next_word(&p, end);
    }
    uint8_t type = type_of(w);
    if (type == PLY_NO_TYPE)
        return rti_ply_fail(f, "'%s' is no type; there are char, uchar, short, ushort, int, uint, float and double",
                            shown(text, sizeof text, w));
    word name = next_word(&p, end);
    if (name.n == 0)
        return rti_ply_fail(f, "a property without a name");
    if (!rti_reserve(f->model->ctx, (void **)&f->properties, &f->property_capacity, f->property_count, 1, sizeof *f->properties))
        return no_memory(f, sizeof *f->properties);
    ply_element *e = &f->elements[f->element_count - 1];
    f->properties[f->property_count++] = (ply_property){type, count_type, use_of(e->kind, name, list)};
    e->property_count++;
    return RT_OK;
}

static rt_status set_format(ply *f, const char *p, const char *end, ply_coding *coding)
{
    char text[64];
    word kind = next_word(&p, end), version = next_word(&p, end);
    if (is(kind, "ascii"))
        *coding = PLY_ASCII;
    else if (is(kind, "binary_little_endian"))
        *coding = PLY_LITTLE;
    else if (is(kind, "binary_big_endian"))
        *coding = PLY_BIG;
    else
        return rti_ply_fail(f, "format '%s' is not known; there are ascii, binary_little_endian and binary_big_endian",
                            shown(text, sizeof text, kind));
    if (!is(version, "1.0"))
        return rti_ply_fail(f, "version '%s' of the format; only 1.0 is known", shown(text, sizeof text, version));
    return RT_OK;
}

/* The elements' counts must fit into the bytes that follow: nobody allocates on the header's word alone. */
static rt_status check_counts(const ply *f)
{
    uint64_t left = (uint64_t)(f->end - f->p) + (f->coding == PLY_ASCII ? 1 : 0); /* the last newline may be missing */
    for (size_t i = 0; i < f->element_count; i++) {
        const ply_element *e = &f->elements[i];
        uint64_t row = 0;
        for (size_t k = 0; k < e->property_count; k++) {
            const ply_property *q = &f->properties[e->first + k];
            row += f->coding == PLY_ASCII ? 2 : rti_ply_size(q->count_type == PLY_NO_TYPE ? q->type : q->count_type);
        }
        if (row && e->count > left / row)
            return rti_ply_fail(
                f, "the header promises %llu elements of at least %llu bytes, but only %llu bytes are left: the file is cut",
                (unsigned long long)e->count, (unsigned long long)row, (unsigned long long)left);
        left -= row * e->count;
    }
    return RT_OK;
}

static rt_status head_line(ply *f, const char *line, const char *stop, ply_coding *coding, bool *format_seen, bool *done)
{
    char text[64];
    const char *p = line;
    word w = next_word(&p, stop);
    if (is(w, "end_header")) {
        *done = true;
        return *format_seen ? RT_OK : rti_ply_fail(f, "the header has no 'format' line");
    }
    if (is(w, "format")) {
        *format_seen = true;
        return set_format(f, p, stop, coding);
    }
    if (is(w, "element"))
        return add_element(f, p, stop);
    if (is(w, "property"))
        return add_property(f, p, stop);
    if (w.n == 0 || is(w, "comment") || is(w, "obj_info"))
        return RT_OK;
    return rti_ply_fail(f, "unknown word '%s' in the PLY header; there are format, comment, element, property, end_header",
                        shown(text, sizeof text, w));
}

rt_status rti_ply_head(ply *f)
{
    ply_coding coding = PLY_ASCII;
    bool format_seen = false, done = false;
    rt_status status = RT_OK;
    f->coding = PLY_ASCII; /* messages about the header count lines */
    while (!status && !done) {
        const char *stop = f->p < f->end ? memchr(f->p, '\n', (size_t)(f->end - f->p)) : NULL;
        if (!stop)
            return rti_ply_fail(f, "the file ends within its PLY header ('end_header' is missing)");
        if (f->line == 1)
            status =
                stop - f->p >= 3 && is((word){f->p, 3}, "ply") ? RT_OK : rti_ply_fail(f, "a PLY file begins with a line 'ply'");
        else
            status = head_line(f, f->p, stop, &coding, &format_seen, &done);
        f->p = stop + 1;
        f->line++;
    }
    if (status)
        return status;
    f->coding = coding;
    return check_counts(f);
}
