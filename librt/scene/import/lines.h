/* Logical lines of OBJ and MTL files and the words in them: a backslash at the end joins the next line, '#' begins a comment
 * line. */
#ifndef RTI_LINES_H
#define RTI_LINES_H

#include "model.h"

typedef struct rti_lines {
    const char *p, *end; /* what is left of the file */
    uint64_t line;       /* number of the current line's first, from 1 */
    uint64_t next;
    const char *at, *stop; /* what is left of the current line */
} rti_lines;

typedef struct rti_word {
    const char *p;
    size_t n;
} rti_word;

static inline void rti_lines_init(rti_lines *l, const void *bytes, size_t size)
{
    *l = (rti_lines){.p = bytes, .end = (const char *)bytes + size, .next = 1};
}

/* Goes to the next line. false: there is none. */
bool rti_lines_next(rti_lines *l);
/* The next word of the line; n == 0: none. */
rti_word rti_lines_word(rti_lines *l);
/* The rest of the line without the spaces around it: names may hold some. */
rti_word rti_lines_rest(rti_lines *l);
/* A number as the next word. false: none there (the place stays). */
bool rti_lines_number(rti_lines *l, double *out);
bool rti_word_is(rti_word w, const char *s);

#endif
