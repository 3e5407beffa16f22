/* The built-in font. A glyph is "WIDTH:STROKES": strokes are parted by spaces; a stroke is a row of points, each two digits (x,
 * y) of base 36; `~` before a point makes it the control point of a quadratic curve to the next one. A point alone is a dot. */
#include "font.h"

#include <stdbool.h>
#include <stddef.h>

static const char *const ascii[] = {
    /*   */ "4:",
    /* ! */ "0:0008 0C",
    /* " */ "3:0003 3033",
    /* # */ "8:301C 705C 0484 0888",
    /* $ */ "7:72~6040~0003~0646~7679~7C3C~1C0A 4E40",
    /* % */ "A:20~0002~0424~4442~4020 88~686A~6C8C~ACAA~A888 901C",
    /* & */ "8:8C14~0030~605317~0809~0C3C~6C87",
    /* ' */ "0:0003",
    /* ( */ "3:30~0307~0B3E",
    /* ) */ "3:00~3337~3B0E",
    /* * */ "6:3137 0266 6206",
    /* + */ "8:434B 0787",
    /* , */ "1:1C0F",
    /* - */ "5:0858",
    /* . */ "0:0C",
    /* / */ "6:600D",
    /* 0 */ "6:30~000408~0C3C~6C6864~6030",
    /* 1 */ "6:12303C 1C5C",
    /* 2 */ "6:03~0030~6063~660C6C",
    /* 3 */ "6:02~1030~6063~663626 36~6669~6C3C~1C0A",
    /* 4 */ "6:4C400868",
    /* 5 */ "6:601006~1434~6468~6C3C~1C0A",
    /* 6 */ "6:62~5030~000608~0C3C~6C68~6535~0508",
    /* 7 */ "6:00602C",
    /* 8 */ "6:30~0003~0636~6663~6030 36~0609~0C3C~6C69~6636",
    /* 9 */ "6:0A~1C3C~6C6664~6030~0004~0737~6764",
    /* : */ "0:05 0C",
    /* ; */ "1:15 1C0F",
    /* < */ "7:72077C",
    /* = */ "8:0585 0989",
    /* > */ "7:02770C",
    /* ? */ "6:02~1030~6063~653738 3C",
    /* @ */ "C:AD~8E6E~0E07~0060~C0C6~CAAA~8A8884 64~3437~3A6A~8A87~8464",
    /* A */ "8:0C408C 1878",
    /* B */ "7:000C 0040~7073~764606 46~7679~7C4C0C",
    /* C */ "8:82~7040~0006~0C4C~7C8A",
    /* D */ "8:0C003020~8086~8C2C0C",
    /* E */ "7:70000C7C 0666",
    /* F */ "7:70000C 0666",
    /* G */ "8:82~7040~0006~0C4C~8C8757",
    /* H */ "8:000C 808C 0686",
    /* I */ "0:000C",
    /* J */ "5:5059~5C3C~0C0A",
    /* K */ "7:000C 7007 257C",
    /* L */ "6:000C6C",
    /* M */ "A:0C0058A0AC",
    /* N */ "8:0C008C80",
    /* O */ "8:40~0006~0C4C~8C86~8040",
    /* P */ "7:0C0040~7073~774707",
    /* Q */ "8:40~0006~0C4C~8C86~8040 598D",
    /* R */ "7:0C0040~7073~774707 477C",
    /* S */ "7:72~6040~0003~0646~7679~7C3C~1C0A",
    /* T */ "8:0080 404C",
    /* U */ "8:0008~0C4C~8C8880",
    /* V */ "8:004C80",
    /* W */ "C:003C629CC0",
    /* X */ "8:008C 800C",
    /* Y */ "8:004680 464C",
    /* Z */ "8:00800C8C",
    /* [ */ "3:30000E3E",
    /* \ */ "6:006D",
    /* ] */ "3:00303E0E",
    /* ^ */ "6:043064",
    /* _ */ "7:0E7E",
    /* ` */ "2:0022",
    /* a */ "6:15~1434~64676C 6838~080A~0C3C~6C69",
    /* b */ "6:000C 07~0434~6468~6C3C~0C09",
    /* c */ "6:65~5434~0408~0C3C~5C6B",
    /* d */ "6:606C 67~6434~0408~0C3C~6C69",
    /* e */ "6:0868~6434~0408~0C3C~5C6B",
    /* f */ "4:40~10131C 0444",
    /* g */ "6:646D~6G3G~1G0F 67~6434~0408~0C3C~6C69",
    /* h */ "6:000C 07~0434~64676C",
    /* i */ "0:040C 01",
    /* j */ "2:242E~2G0G 21",
    /* k */ "6:000C 5409 276C",
    /* l */ "2:000A~0C2C",
    /* m */ "A:040C 07~0434~54575C 57~5484~A4A7AC",
    /* n */ "6:040C 07~0434~64676C",
    /* o */ "6:34~0408~0C3C~6C68~6434",
    /* p */ "6:040G 07~0434~6468~6C3C~0C09",
    /* q */ "6:646G 67~6434~0408~0C3C~6C69",
    /* r */ "4:040C 07~0444",
    /* s */ "6:65~5434~0406~0838~686A~6C3C~1C0B",
    /* t */ "4:111A~1C4C 0444",
    /* u */ "6:0409~0C3C~6C69 646C",
    /* v */ "6:043C64",
    /* w */ "8:042C456C84",
    /* x */ "6:046C 640C",
    /* y */ "6:043C 642E~1G0G",
    /* z */ "6:04640C6C",
    /* { */ "4:40~202225~2707~27292C~2E4E",
    /* | */ "0:000F",
    /* } */ "4:00~202225~2747~27292C~2E0E",
    /* ~ */ "8:08~2547~6986",
};

static const char missing[] = "6:00606C0C00";

typedef struct sign {
    uint32_t code;
    const char *strokes;
} sign;

static const sign signs[] = {
    {0x00b0, "4:20~0002~0424~4442~4020"},        /* degree */
    {0x00b1, "8:424A 0686 0C8C"},                /* plus-minus */
    {0x00b2, "4:01~0020~4042~430646"},           /* squared */
    {0x00b5, "6:040G 0409~0C3C~6C69 646C"},      /* micro */
    {0x00b7, "0:07"},                            /* middle dot */
    {0x00d7, "6:046A 640A"},                     /* times */
    {0x00df, "6:0C03~0030~5033~3646~6669~6C2C"}, /* sharp s */
    {0x03bc, "6:040G 0409~0C3C~6C69 646C"},      /* mu */
    {0x2013, "7:0878"},                          /* en dash */
    {0x2014, "C:08C8"},                          /* em dash */
    {0x2018, "1:1003"},
    {0x2019, "1:1003"}, /* quotes */
    {0x201c, "4:1003 4033"},
    {0x201d, "4:1003 4033"},
    {0x2026, "8:0C 4C 8C"},    /* ellipsis */
    {0x2190, "A:07A7 34073A"}, /* arrows */
    {0x2192, "A:07A7 74A77A"},
    {0x2212, "8:0787"}, /* minus */
    {0x2264, "7:71057A 0C7C"},
    {0x2265, "7:01750A 0C7C"},
};

/* U+00C0 ... U+00FF: a letter and its accent; "  " has none of both. */
static const char latin[] = "A`A'A^A~A\"Ao  C,E`E'E^E\"I`I'I^I\"  N~O`O'O^O~O\"  O/U`U'U^U\"Y'    "
                            "a`a'a^a~a\"ao  c,e`e'e^e\"i`i'i^i\"  n~o`o'o^o~o\"  o/u`u'u^u\"y'  y\"";

/* Accents stand around x = 3, above small letters. */
static const char *accent_of(char accent)
{
    switch (accent) {
    case '`':
        return "6:1042";
    case '\'':
        return "6:5022";
    case '^':
        return "6:123052";
    case '~':
        return "6:12~2032~4150";
    case '"':
        return "6:11 51";
    case 'o':
        return "6:30~2021~2232~4241~4030";
    case ',':
        return "6:3C2F";
    default:
        return "6:630D"; /* the slash of O */
    }
}

/* ---- reading the table ---- */

static int digit(char c)
{
    return c >= '0' && c <= '9' ? c - '0' : c >= 'A' && c <= 'Z' ? c - 'A' + 10 : -1;
}

static void line(rti_font_glyph *g, float x0, float y0, float x1, float y1)
{
    if (g->count < RTI_FONT_SEGMENTS)
        g->segments[g->count++] = (rti_font_segment){x0, y0, x1, y1};
}

static void curve(rti_font_glyph *g, const float p[6])
{
    float x = p[0], y = p[1];
    for (uint32_t i = 1; i <= RTI_FONT_CURVE; i++) {
        float t = (float)i / (float)RTI_FONT_CURVE, a = (1.0f - t) * (1.0f - t), b = 2.0f * t * (1.0f - t), c = t * t;
        float nx = a * p[0] + b * p[2] + c * p[4], ny = a * p[1] + b * p[3] + c * p[5];
        line(g, x, y, nx, ny);
        x = nx;
        y = ny;
    }
}

/* One stroke up to a space or the end; returns what follows it. */
static const char *stroke(const char *s, float dx, float dy, rti_font_glyph *g)
{
    float p[6] = {(float)digit(s[0]) + dx, (float)digit(s[1]) + dy, 0, 0, 0, 0};
    s += 2;
    if (*s == 0 || *s == ' ')
        line(g, p[0], p[1], p[0], p[1]);
    while (*s && *s != ' ') {
        bool bent = *s == '~';
        if (bent) {
            p[2] = (float)digit(s[1]) + dx;
            p[3] = (float)digit(s[2]) + dy;
            s += 3;
        }
        p[4] = (float)digit(s[0]) + dx;
        p[5] = (float)digit(s[1]) + dy;
        s += 2;
        if (bent)
            curve(g, p);
        else
            line(g, p[0], p[1], p[4], p[5]);
        p[0] = p[4];
        p[1] = p[5];
    }
    return *s ? s + 1 : s;
}

static float add(const char *strokes, float dx, float dy, rti_font_glyph *g)
{
    float width = (float)digit(strokes[0]);
    for (const char *s = strokes + 2; *s;)
        s = stroke(s, dx, dy, g);
    return width;
}

static const char *strokes_of(uint32_t code)
{
    if (code == 0xa0)
        code = ' ';
    if (code >= 0x20 && code < 0x20 + sizeof ascii / sizeof ascii[0])
        return ascii[code - 0x20];
    for (size_t i = 0; i < sizeof signs / sizeof signs[0]; i++) {
        if (signs[i].code == code)
            return signs[i].strokes;
    }
    return NULL;
}

float rti_font_glyph_of(uint32_t code, rti_font_glyph *glyph)
{
    const char *strokes = strokes_of(code);
    float width;
    glyph->count = 0;
    if (!strokes && code >= 0xc0 && code <= 0xff && latin[2 * (code - 0xc0)] != ' ') {
        char letter = latin[2 * (code - 0xc0)], accent = latin[2 * (code - 0xc0) + 1];
        width = add(letter == 'i' ? "0:040C" : ascii[letter - 0x20], 0.0f, 0.0f, glyph);
        add(accent_of(accent), 0.5f * (width - 6.0f), letter < 'a' && accent != ',' && accent != '/' ? -4.0f : 0.0f, glyph);
    } else {
        width = add(strokes ? strokes : missing, 0.0f, 0.0f, glyph);
    }
    return width + RTI_FONT_GAP;
}

/* ---- UTF-8 ---- */

uint32_t rti_font_next(const unsigned char **at)
{
    static const uint32_t least[] = {0, 0x80, 0x800, 0x10000};
    const unsigned char *s = *at;
    uint32_t more = s[0] >= 0xf0 && s[0] < 0xf8 ? 3 : s[0] >= 0xe0 && s[0] < 0xf0 ? 2 : s[0] >= 0xc0 && s[0] < 0xe0 ? 1 : 0, code;
    *at = s + 1;
    if (s[0] < 0x80)
        return s[0];
    if (more == 0)
        return 0xfffd;
    code = s[0] & (0x3fu >> more);
    for (uint32_t i = 1; i <= more; i++) {
        if ((s[i] & 0xc0) != 0x80) /* a NUL too */
            return 0xfffd;
        code = code << 6 | (s[i] & 0x3fu);
    }
    if (code < least[more] || code > 0x10ffff || (code >= 0xd800 && code < 0xe000))
        return 0xfffd;
    *at = s + 1 + more;
    return code;
}
