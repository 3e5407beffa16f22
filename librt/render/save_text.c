/* Text entries on their way into a file. */
#include <string.h>

#include "image_text.h"

rt_status rti_text_check_key(rt_context *ctx, const char *what, const char *key)
{
    size_t length = strlen(key);
    char shown[4 * RTI_TEXT_KEY_MAX + 16];
    if (length < 1 || length > RTI_TEXT_KEY_MAX)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: the key has %zu bytes; it must have 1 ... %u", what, length,
                        RTI_TEXT_KEY_MAX);
    for (size_t i = 0; i < length; i++) {
        unsigned char c = (unsigned char)key[i];
        bool bad_space = c == ' ' && (i == 0 || i == length - 1 || key[i - 1] == ' ');
        if (c < 0x20 || c > 0x7e || bad_space)
            return rti_fail(ctx, RT_ERROR_ARGUMENT,
                            "%s: the key '%s' must be of printable ASCII characters, without a space at its ends or two in a row",
                            what, rti_quote(shown, sizeof shown, key, length));
    }
    return RT_OK;
}

static rti_text text_of(const rt_text *t)
{
    return (rti_text){(char *)(uintptr_t)t->key, (char *)(uintptr_t)t->value, strlen(t->key) + 1, strlen(t->value) + 1};
}

static size_t place_of(const rti_text *texts, size_t count, const char *key)
{
    size_t i = 0;
    while (i < count && strcmp(texts[i].key, key) != 0)
        i++;
    return i;
}

rt_status rti_texts_merge(rt_context *ctx, const rti_text *texts, size_t text_count, const rt_text *more, uint32_t more_count,
                          rti_text **all, size_t *count, size_t *size)
{
    static const char what[] = "saving an image";
    *all = NULL;
    *count = 0;
    *size = 0;
    if (more_count == 0)
        return RT_OK;
    if (!more)
        return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: texts is NULL, but text_count is %u", what, (unsigned)more_count);
    for (uint32_t i = 0; i < more_count; i++) {
        if (!more[i].key || !more[i].value)
            return rti_fail(ctx, RT_ERROR_ARGUMENT, "%s: the %s of texts[%u] is NULL", what, more[i].key ? "value" : "key",
                            (unsigned)i);
        rt_status status = rti_text_check_key(ctx, what, more[i].key);
        if (status != RT_OK)
            return status;
    }
    if (!rti_mul_size(text_count + more_count, sizeof **all, size))
        return rti_fail_memory(ctx, what, SIZE_MAX);
    *all = rti_alloc(ctx, *size);
    if (!*all)
        return rti_fail_memory(ctx, what, *size);
    if (text_count)
        memcpy(*all, texts, text_count * sizeof **all);
    *count = text_count;
    for (uint32_t i = 0; i < more_count; i++) {
        size_t at = place_of(*all, *count, more[i].key);
        (*all)[at] = text_of(&more[i]);
        *count += at == *count;
    }
    return RT_OK;
}

/* ---- HDR ---- */

#define LINE 200u /* characters of a line's value: readers of this format have buffers of 512 to 2048 bytes a line */

static void put(rti_writer *out, const char *text)
{
    rti_writer_write(out, text, strlen(text));
}

static rt_status put_value(rti_writer *out, const char *value)
{
    size_t in_line = 0;
    for (const char *p = value; *p; p++) {
        if (in_line >= LINE) {
            put(out, "\n#+");
            in_line = 0;
        }
        if (*p == '\\' || *p == '\n' || *p == '\r') {
            put(out, *p == '\\' ? "\\\\" : *p == '\n' ? "\\n" : "\\r");
            in_line += 2;
        } else {
            rti_writer_write(out, p, 1);
            in_line++;
        }
    }
    return rti_writer_write(out, "\n", 1);
}

rt_status rti_texts_write_hdr(rti_writer *out, const rti_text *texts, size_t count)
{
    rt_status status = RT_OK;
    for (size_t i = 0; i < count && status == RT_OK; i++) {
        put(out, "# ");
        for (const char *p = texts[i].key; *p; p++) /* a key's '=' is not the one that ends it */
            put(out, *p == '=' ? "\\=" : *p == '\\' ? "\\\\" : (const char[2]){*p, 0});
        put(out, "=");
        status = put_value(out, texts[i].value);
    }
    return status;
}
