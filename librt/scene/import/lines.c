#include "lines.h"

#include <string.h>

bool rti_lines_next(rti_lines *l)
{
    if (l->p >= l->end)
        return false;
    l->line = l->next;
    l->at = l->p;
    for (;;) {
        const char *newline = memchr(l->p, '\n', (size_t)(l->end - l->p));
        if (!newline) {
            l->p = l->stop = l->end;
            return true;
        }
        const char *last = newline > l->at && newline[-1] == '\r' ? newline - 1 : newline;
        l->p = newline + 1;
        l->next++;
        if (last == l->at || last[-1] != '\\') {
            l->stop = last;
            return true;
        }
        if (l->p >= l->end) {
            l->stop = l->end;
            return true;
        }
    }
}

static void skip_space(rti_lines *l)
{
    while (l->at < l->stop) {
        if (*l->at == '\\' && l->at + 1 < l->stop && (l->at[1] == '\n' || l->at[1] == '\r'))
            l->at += 2;
        else if (rti_is_space(*l->at))
            l->at++;
        else
            return;
    }
}

static bool ends_word(const rti_lines *l)
{
    return rti_is_space(*l->at) || (*l->at == '\\' && l->at + 1 < l->stop && (l->at[1] == '\n' || l->at[1] == '\r'));
}

rti_word rti_lines_word(rti_lines *l)
{
    skip_space(l);
    rti_word w = {l->at, 0};
    while (l->at < l->stop && !ends_word(l))
        l->at++;
    w.n = (size_t)(l->at - w.p);
    return w;
}

rti_word rti_lines_rest(rti_lines *l)
{
    skip_space(l);
    rti_word w = {l->at, (size_t)(l->stop - l->at)};
    while (w.n && rti_is_space(w.p[w.n - 1]))
        w.n--;
    l->at = l->stop;
    return w;
}

bool rti_lines_number(rti_lines *l, double *out)
{
    skip_space(l);
    const char *from = l->at;
    if (rti_parse_any(&l->at, l->stop, out) && (l->at == l->stop || ends_word(l)))
        return true;
    l->at = from;
    return false;
}

bool rti_word_is(rti_word w, const char *s)
{
    return w.n == strlen(s) && memcmp(w.p, s, w.n) == 0;
}
