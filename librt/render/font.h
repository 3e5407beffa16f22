/* The built-in font: strokes on a grid, drawn at any size. Capitals stand from y = 0 to the base line at 12, small letters from 4, tails reach 16. */
#ifndef RTI_FONT_H
#define RTI_FONT_H

#include <stdint.h>

#define RTI_FONT_LINE     18.0f /* from line to line */
#define RTI_FONT_TOP      2.5f  /* from the top of a line to the top of a capital */
#define RTI_FONT_GAP      3.8f  /* between two letters' strokes */
#define RTI_FONT_STROKE   1.6f  /* thickness at weight 1 */
#define RTI_FONT_CURVE    6u    /* segments of a curve */
#define RTI_FONT_SEGMENTS 128u  /* of a glyph at most; a test counts */

typedef struct rti_font_segment {
    float x0, y0, x1, y1;
} rti_font_segment;

typedef struct rti_font_glyph {
    rti_font_segment segments[RTI_FONT_SEGMENTS];
    uint32_t count;
} rti_font_glyph;

/* The character at *at, which is moved on (never beyond the NUL); 0xfffd for a byte that is no UTF-8. */
uint32_t rti_font_next(const unsigned char **at);
/* The strokes of a character (an empty box for one that the font lacks); returns how far the next one stands to the right. */
float rti_font_glyph_of(uint32_t code, rti_font_glyph *glyph);

#endif
