/* The text entries of image files, read without their pixels. Sources: PNG specification (third edition) 11.3.3; the Radiance
 * file format's manual page. Nothing in the file is believed: lengths are held against its size, entries against a limit. */
#include "image_text.h"

#include <string.h>

#define ENTRY_MAX ((size_t)64 << 20)
#define HEAD_MAX  ((size_t)64 << 20) /* of an HDR file */

typedef struct source {
    rt_context *ctx;
    const char *name; /* escaped for messages */
    const uint8_t *bytes;
    rti_reader *reader; /* NULL: bytes */
    uint64_t size;
    bool sums;
    rt_text_fn entry;
    void *user;
    bool ended; /* the caller wants no more */
} source;

static rt_status get(source *s, uint64_t at, void *to, size_t size)
{
    if (s->reader)
        return rti_reader_read(s->reader, at, to, size);
    memcpy(to, s->bytes + at, size); /* the caller held at + size against s->size */
    return RT_OK;
}

static rt_status broken(source *s, uint64_t at, const char *what)
{
    return rti_fail(s->ctx, RT_ERROR_FORMAT, "%s: byte %llu: %s", s->name, (unsigned long long)at, what);
}

static void tell(source *s, const char *key, const char *value)
{
    if (s->entry(s->user, key, value))
        s->ended = true;
}

/* ---- PNG ---- */

static uint32_t be32(const uint8_t *p)
{
    return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

static uint32_t crc_of(const uint8_t *p, size_t size)
{
    uint32_t crc = ~0u;
    for (size_t i = 0; i < size; i++) {
        crc ^= p[i];
        for (int k = 0; k < 8; k++)
            crc = crc >> 1 ^ (0xedb88320u & (~(crc & 1) + 1));
    }
    return ~crc;
}

/* Latin-1 to UTF-8 in a new block; NULL without memory. */
static char *widen(rt_context *ctx, const uint8_t *text, size_t size, size_t *capacity)
{
    char *wide, *to;
    *capacity = 2 * size + 1; /* size <= ENTRY_MAX */
    to = wide = rti_alloc(ctx, *capacity);
    if (!wide) {
        rti_fail_memory(ctx, "reading text of an image", *capacity);
        return NULL;
    }
    for (size_t i = 0; i < size; i++) {
        if (text[i] >= 0x80)
            *to++ = (char)(0xc0 | text[i] >> 6);
        *to++ = (char)(text[i] < 0x80 ? text[i] : 0x80 | (text[i] & 0x3f));
    }
    *to = 0;
    return wide;
}

/* One entry whose text is packed or plain, Latin-1 or UTF-8. text[size] is a NUL. */
static rt_status tell_text(source *s, uint64_t at, const char *key, const uint8_t *text, size_t size, bool packed, bool latin)
{
    uint8_t *unpacked = NULL;
    size_t unpacked_capacity = 0, wide_capacity = 0;
    rt_status status = RT_OK;
    if (packed) {
        const char *fault = rti_inflate(s->ctx, text, size, ENTRY_MAX, &unpacked, &size, &unpacked_capacity);
        if (fault)
            return *fault ? broken(s, at, fault) : RT_ERROR_MEMORY;
        text = unpacked;
    }
    char *wide = latin ? widen(s->ctx, text, size, &wide_capacity) : NULL;
    if (latin && !wide)
        status = RT_ERROR_MEMORY;
    else
        tell(s, key, latin ? wide : (const char *)text);
    rti_free(s->ctx, wide, wide_capacity);
    rti_free(s->ctx, unpacked, unpacked_capacity);
    return status;
}

/* The data of a text chunk, a NUL behind it. */
static rt_status png_text(source *s, uint64_t at, const uint8_t *type, const uint8_t *data, size_t size)
{
    const uint8_t *key_end = memchr(data, 0, size), *rest;
    size_t left, capacity;
    rt_status status;
    if (!key_end || key_end == data || key_end - data > (ptrdiff_t)RTI_TEXT_KEY_MAX)
        return broken(s, at, "a PNG text chunk whose keyword does not have 1 ... 79 bytes");
    rest = key_end + 1;
    left = size - (size_t)(rest - data);
    char *key = widen(s->ctx, data, (size_t)(key_end - data), &capacity);
    if (!key)
        return RT_ERROR_MEMORY;
    if (memcmp(type, "tEXt", 4) == 0) {
        status = tell_text(s, at, key, rest, left, false, true);
    } else if (memcmp(type, "zTXt", 4) == 0) {
        status = left < 1 || rest[0] != 0 ? broken(s, at, "a PNG zTXt chunk of an unknown compression")
                                          : tell_text(s, at, key, rest + 1, left - 1, true, true);
    } else { /* iTXt: flag, method, language, translated keyword, text */
        const uint8_t *language = left >= 2 ? memchr(rest + 2, 0, left - 2) : NULL;
        const uint8_t *end = data + size, *word = language ? memchr(language + 1, 0, (size_t)(end - language - 1)) : NULL;
        if (!word || rest[0] > 1 || (rest[0] == 1 && rest[1] != 0))
            status = broken(s, at, "a PNG iTXt chunk that is cut or of an unknown compression");
        else
            status = tell_text(s, at, key, word + 1, (size_t)(end - word - 1), rest[0] == 1, false);
    }
    rti_free(s->ctx, key, capacity);
    return status;
}

static rt_status png_chunk(source *s, uint64_t at, const uint8_t *head, uint32_t length)
{
    uint8_t *block, sum[4];
    rt_status status;
    if (length > ENTRY_MAX)
        return broken(s, at, "a PNG text chunk of more than 64 MiB");
    block = rti_alloc(s->ctx, (size_t)length + 5);
    if (!block)
        return rti_fail_memory(s->ctx, s->name, (size_t)length + 5);
    memcpy(block, head + 4, 4);
    status = get(s, at + 8, block + 4, length);
    block[4 + (size_t)length] = 0;
    if (status == RT_OK)
        status = get(s, at + 8 + length, sum, 4);
    if (status == RT_OK && s->sums && crc_of(block, (size_t)length + 4) != be32(sum))
        status = broken(s, at, "the checksum of this PNG text chunk is wrong, it is damaged; copy or save the file again");
    if (status == RT_OK)
        status = png_text(s, at, head + 4, block + 4, length);
    rti_free(s->ctx, block, (size_t)length + 5);
    return status;
}

static rt_status png_texts(source *s)
{
    uint64_t at = 8;
    for (;;) {
        uint8_t head[8];
        rt_status status;
        if (s->size - at < 12)
            return broken(s, s->size, "this PNG file is cut: its end mark is missing; copy or save it again");
        status = get(s, at, head, 8);
        if (status != RT_OK)
            return status;
        uint32_t length = be32(head);
        if (at == 8 && memcmp(head + 4, "IHDR", 4) != 0)
            return broken(s, at, "a PNG file must begin with an IHDR chunk");
        if (length > s->size - at - 12)
            return broken(s, at, "this PNG file is cut within the chunk that begins here; copy or save it again");
        if (memcmp(head + 4, "IEND", 4) == 0)
            return RT_OK;
        if (memcmp(head + 5, "EXt", 3) == 0 ? head[4] == 't'
                                            : memcmp(head + 5, "TXt", 3) == 0 && (head[4] == 'z' || head[4] == 'i'))
            status = png_chunk(s, at, head, length);
        if (status != RT_OK || s->ended)
            return status;
        at += (uint64_t)12 + length;
    }
}

/* ---- HDR ---- */

/* The head up to its empty line, a NUL behind it; *size: its bytes. */
static rt_status hdr_head(source *s, char **head, size_t *size, size_t *capacity)
{
    *head = NULL;
    *capacity = 0;
    for (size_t want = 4096, seen = 0;; want *= 2) {
        size_t have = want < s->size ? want : (size_t)s->size;
        char *moved = rti_realloc(s->ctx, *head, *capacity, have + 1);
        if (!moved)
            return rti_fail_memory(s->ctx, s->name, have + 1);
        *head = moved;
        *capacity = have + 1;
        rt_status status = get(s, seen, *head + seen, have - seen);
        if (status != RT_OK)
            return status;
        for (size_t i = seen ? seen - 1 : 0; i + 1 < have; i++) {
            if ((*head)[i] == '\n' && (*head)[i + 1] == '\n') {
                *size = i + 1;
                (*head)[*size] = 0;
                return RT_OK;
            }
        }
        if (have == s->size || have >= HEAD_MAX)
            return broken(s, have, "the head of this HDR file has no end; copy or save it again");
        seen = have;
    }
}

/* In place: what '\' stands before; the end of the text (a key's ends at the first '=' without one). */
static char *unescape(char *text, char *end, bool key, char **rest)
{
    char *to = text, *from = text;
    for (; from < end && !(key && *from == '='); from++) {
        if (*from == '\\' && from + 1 < end) {
            from++;
            *to++ = *from == 'n' ? '\n' : *from == 'r' ? '\r' : *from;
        } else {
            *to++ = *from;
        }
    }
    *rest = from < end ? from + 1 : NULL;
    return to;
}

static bool printable(const char *key)
{
    for (; *key; key++) {
        if ((unsigned char)*key < 0x20 || (unsigned char)*key > 0x7e)
            return false;
    }
    return true;
}

/* Takes the lines "#+..." after `end` into the value that ends there; returns the end of the last. */
static char *join(char *end, char **value_end, char *head_end)
{
    while (head_end - end > 2 && end[1] == '#' && end[2] == '+') { /* end is at a newline */
        char *line = end + 3, *stop = memchr(line, '\n', (size_t)(head_end - line));
        stop = stop ? stop : head_end;
        memmove(*value_end, line, (size_t)(stop - line));
        *value_end += stop - line;
        end = stop;
    }
    return end;
}

static void hdr_line(source *s, char *line, char *value_end, bool ours)
{
    char *value, *unused, *end;
    if (ours) {
        end = unescape(line, value_end, true, &value);
    } else {
        value = memchr(line, '=', (size_t)(value_end - line));
        end = value ? value : line;
        value = value ? value + 1 : NULL;
    }
    if (!value || end == line || end - line > (ptrdiff_t)RTI_TEXT_KEY_MAX)
        return; /* a comment of somebody else's */
    *end = 0;
    end = ours ? unescape(value, value_end, false, &unused) : value_end;
    *end = 0;
    if (*line && printable(line) && (ours || strcmp(line, "FORMAT") != 0))
        tell(s, line, value);
}

static rt_status hdr_texts(source *s)
{
    char *head, *head_end, *line;
    size_t size = 0, capacity;
    rt_status status = hdr_head(s, &head, &size, &capacity);
    head_end = status == RT_OK ? head + size : head;
    for (line = head; status == RT_OK && line < head_end && !s->ended;) {
        char *end = memchr(line, '\n', (size_t)(head_end - line)), *value_end;
        bool ours = line[0] == '#' && line[1] == ' ';
        end = end ? end : head_end;
        value_end = end;
        if (ours)
            end = join(end, &value_end, head_end);
        if (ours || line[0] != '#')
            hdr_line(s, line + (ours ? 2 : 0), value_end, ours);
        line = end + 1;
    }
    rti_free(s->ctx, head, capacity);
    return status;
}

/* ---- all formats ---- */

static bool starts(const uint8_t *head, size_t have, const char *magic, size_t length)
{
    return have >= length && memcmp(head, magic, length) == 0;
}

static rt_status read_texts(source *s)
{
    uint8_t head[18];
    size_t have = s->size < sizeof head ? (size_t)s->size : sizeof head;
    rt_status status = get(s, 0, head, have);
    if (status != RT_OK)
        return status;
    if (starts(head, have, "\x89PNG\r\n\x1a\n", 8))
        return png_texts(s);
    if (starts(head, have, "#?RADIANCE", 10) || starts(head, have, "#?RGBE", 6))
        return hdr_texts(s);
    if (starts(head, have, "\xff\xd8\xff", 3) || starts(head, have, "GIF87a", 6) || starts(head, have, "GIF89a", 6) ||
        starts(head, have, "BM", 2))
        return RT_OK;
    /* TGA has no mark: a colour map or none, and one of its six types */
    if (have == 18 && head[1] <= 1 && ((head[2] >= 1 && head[2] <= 3) || (head[2] >= 9 && head[2] <= 11)))
        return RT_OK;
    return rti_fail(s->ctx, RT_ERROR_FORMAT, "%s: not a PNG, JPEG, GIF, BMP, TGA or HDR image, or its first bytes are damaged",
                    s->name);
}

rt_status rti_texts_decode(rt_context *ctx, const char *name, const void *bytes, size_t size, bool sums, rt_text_fn entry,
                           void *user)
{
    char quoted[300];
    source s = {.ctx = ctx, .bytes = bytes, .size = size, .sums = sums, .entry = entry, .user = user};
    s.name = rti_quote(quoted, sizeof quoted, name, strlen(name));
    return read_texts(&s);
}

rt_status rt_image_read_texts(rt_context *context, const char *path, rt_text_fn entry, void *user)
{
    RTI_NEED(context);
    char quoted[300];
    source s = {.ctx = context, .sums = true, .entry = entry, .user = user};
    rt_status status;
    if (!path)
        return rti_fail(context, RT_ERROR_ARGUMENT, "rt_image_read_texts: path is NULL; give the name of an image file");
    if (!entry)
        return rti_fail(context, RT_ERROR_ARGUMENT, "rt_image_read_texts: entry is NULL; it receives the texts");
    status = rti_reader_open(context, path, &s.reader);
    if (status != RT_OK)
        return status;
    s.name = rti_quote(quoted, sizeof quoted, path, strlen(path));
    s.size = rti_reader_size(s.reader);
    status = read_texts(&s);
    rti_reader_close(s.reader);
    return status;
}
