/* Numbers and foreign text, whatever the locale. */
#include <math.h>
#include <string.h>

#include "base.h"

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

bool rti_parse_int(const char **s, const char *end, int64_t *out)
{
    const char *p = *s;
    bool negative = false;
    uint64_t x = 0, most;
    if (p < end && (*p == '-' || *p == '+'))
        negative = *p++ == '-';
    if (p >= end || !is_digit(*p))
        return false;
    most = (uint64_t)INT64_MAX + (negative ? 1u : 0u);
    for (; p < end && is_digit(*p); p++) {
        unsigned d = (unsigned)(*p - '0');
        if (x > (most - d) / 10)
            return false;
        x = x * 10 + d;
    }
    *s = p;
    *out = negative ? (int64_t)(0 - x) : (int64_t)x;
    return true;
}

/* Numbers beyond the exact fast path are rounded by arithmetic on big integers of base 2^32: at most 800 decimal digits count. */
#define LIMBS 128
typedef struct big {
    uint32_t limb[LIMBS];
    uint32_t count;
} big;

static void big_mul_add(big *b, uint32_t m, uint32_t a)
{
    uint64_t carry = a;
    for (uint32_t i = 0; i < b->count; i++) {
        carry += (uint64_t)b->limb[i] * m;
        b->limb[i] = (uint32_t)carry;
        carry >>= 32;
    }
    if (carry && b->count < LIMBS)
        b->limb[b->count++] = (uint32_t)carry;
}

static void big_shift_left(big *b, uint32_t bits)
{
    uint32_t words = bits / 32, rest = bits % 32;
    for (uint32_t i = b->count; i-- > 0;)
        if (i + words < LIMBS)
            b->limb[i + words] = b->limb[i];
    memset(b->limb, 0, words * sizeof b->limb[0]);
    b->count += words;
    if (rest)
        big_mul_add(b, 1u << rest, 0);
}

static int big_compare(const big *a, const big *b)
{
    if (a->count != b->count)
        return a->count < b->count ? -1 : 1;
    for (uint32_t i = a->count; i-- > 0;)
        if (a->limb[i] != b->limb[i])
            return a->limb[i] < b->limb[i] ? -1 : 1;
    return 0;
}

/* Compares digits * 10^exp10 with m * 2^e exactly. */
static int compare_exact(const big *digits, int exp10, uint64_t m, int e)
{
    big a = *digits, b;
    memset(&b, 0, sizeof b);
    b.limb[0] = (uint32_t)m;
    b.limb[1] = (uint32_t)(m >> 32);
    b.count = b.limb[1] ? 2 : b.limb[0] ? 1 : 0;
    for (int i = 0; i < exp10; i++)
        big_mul_add(&a, 10, 0);
    for (int i = 0; i < -exp10; i++)
        big_mul_add(&b, 10, 0);
    if (e > 0)
        big_shift_left(&b, (uint32_t)e);
    else
        big_shift_left(&a, (uint32_t)-e);
    return big_compare(&a, &b);
}

/* The double nearest to digits * 10^exp10, beginning from an estimate that is off by a few ulp at most. */
static double round_exact(const big *digits, int exp10, double x)
{
    for (int step = 0; step < 64; step++) {
        int e;
        uint64_t m;
        double f = frexp(x, &e);
        int order;
        m = (uint64_t)ldexp(f, 53);
        e -= 53;
        if (m == 0) {
            e = -1074;
        } else if (e < -1074) { /* denormal: its unit is 2^-1074 */
            m >>= -1074 - e;
            e = -1074;
        }
        /* The upper neighbour's border is (2m + 1) 2^(e-1); the lower one's is half as far when m is a power of two. */
        order = compare_exact(digits, exp10, 2 * m + 1, e - 1);
        if (order > 0 || (order == 0 && (m & 1))) {
            x = nextafter(x, INFINITY);
            if (isinf(x))
                return x;
            continue;
        }
        if (m == (1ull << 52) && e > -1074)
            order = compare_exact(digits, exp10, 4 * m - 1, e - 2);
        else
            order = m == 0 ? 1 : compare_exact(digits, exp10, 2 * m - 1, e - 1);
        if (order < 0 || (order == 0 && (m & 1) && m != (1ull << 52))) {
            x = nextafter(x, 0);
            continue;
        }
        return x;
    }
    return x;
}

static double scale_pow10(double x, int exp10)
{
    static const double exact[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                   1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    for (; exp10 > 22; exp10 -= 22)
        x *= 1e22;
    for (; exp10 < -22; exp10 += 22)
        x /= 1e22;
    return exp10 < 0 ? x / exact[-exp10] : x * exact[exp10];
}

#define MOST_DIGITS 780 /* more cannot change the rounding of a double, but for a final non-zero one */

bool rti_parse_double(const char **s, const char *end, double *out)
{
    const char *p = *s;
    bool negative = false, point = false, any = false, more = false;
    uint64_t mantissa = 0;
    int kept = 0, exp10 = 0;
    const char *first;
    double x;
    if (p < end && (*p == '-' || *p == '+'))
        negative = *p++ == '-';
    first = p;
    for (; p < end && (is_digit(*p) || (*p == '.' && !point)); p++) {
        if (*p == '.') {
            point = true;
            continue;
        }
        any = true;
        if (kept == 0 && *p == '0') {
            exp10 -= point ? 1 : 0;
            continue;
        }
        if (kept < 19)
            mantissa = mantissa * 10 + (uint64_t)(*p - '0');
        if (kept < MOST_DIGITS) {
            kept++;
            exp10 -= point ? 1 : 0;
        } else {
            more |= *p != '0';
            exp10 += point ? 0 : 1;
        }
    }
    if (!any)
        return false;
    if (p < end && (*p == 'e' || *p == 'E')) {
        const char *q = p + 1;
        int64_t e;
        bool minus = q < end && *q == '-';
        if (rti_parse_int(&q, end, &e)) {
            exp10 += e > 100000 ? 100000 : e < -100000 ? -100000 : (int)e;
            p = q;
        } else if (q < end && (is_digit(*q) || ((*q == '-' || *q == '+') && q + 1 < end && is_digit(q[1])))) {
            for (q += !is_digit(*q); q < end && is_digit(*q); q++) { /* an exponent beyond 64 bits */
            }
            exp10 = minus ? -100000 : 100000;
            p = q;
        }
    }
    *s = p;
    if (kept == 0) {
        *out = negative ? -0.0 : 0.0;
        return true;
    }
    if (exp10 + kept > 310)
        x = INFINITY;
    else if (exp10 + kept < -330)
        x = 0;
    else if (kept <= 19 && mantissa <= (1ull << 53) && exp10 >= -22 && exp10 <= 22)
        x = scale_pow10((double)mantissa, exp10); /* both exact: one rounding */
    else {
        big digits;
        int n = 0, whole = exp10 + (kept > 19 ? kept - 19 : 0);
        memset(&digits, 0, sizeof digits);
        for (const char *q = first; n < kept; q++) {
            if (*q == '.' || (n == 0 && *q == '0'))
                continue;
            big_mul_add(&digits, 10, (uint32_t)(*q - '0'));
            n++;
        }
        if (more)
            big_mul_add(&digits, 10, 1), exp10--;
        /* Two steps keep the estimate from overflowing or vanishing before its time. */
        x = whole < -300 ? scale_pow10(scale_pow10((double)mantissa, -290), whole + 290) : scale_pow10((double)mantissa, whole);
        if (isinf(x))
            x = 1.7976931348623157e308;
        x = round_exact(&digits, exp10, x);
    }
    *out = negative ? -x : x;
    return true;
}

/* snprintf writes the locale's decimal point, perhaps several bytes: whatever is no part of a number becomes '.'. */
static void plain_point(char *buffer)
{
    char *to = buffer;
    bool done = false;
    for (const char *from = buffer; *from; from++) {
        bool part = is_digit(*from) || *from == '-' || *from == '+' || *from == 'e' || *from == 'i' || *from == 'n' ||
                    *from == 'f' || *from == 'a';
        if (part)
            *to++ = *from;
        else if (!done) {
            *to++ = '.';
            done = true;
        }
    }
    *to = '\0';
}

const char *rti_num(char *buffer, float x)
{
    if (isnan(x))
        return strcpy(buffer, "nan");
    for (int digits = 6; digits <= 9; digits++) {
        double back;
        const char *s = buffer;
        snprintf(buffer, 32, "%.*g", digits, (double)x);
        plain_point(buffer);
        if (isinf(x) || (rti_parse_double(&s, buffer + strlen(buffer), &back) && (float)back == x))
            break;
    }
    return buffer;
}

const char *rti_num_double(char *buffer, double x)
{
    if (isnan(x))
        return strcpy(buffer, "nan");
    for (int digits = 15; digits <= 17; digits++) {
        double back;
        const char *s = buffer;
        snprintf(buffer, 32, "%.*g", digits, x);
        plain_point(buffer);
        if (isinf(x) || (rti_parse_double(&s, buffer + strlen(buffer), &back) && back == x))
            break;
    }
    return buffer;
}

static char lower(char c)
{
    return c >= 'A' && c <= 'Z' ? (char)(c + 32) : c;
}

/* Edit distance with neighbours swapped counting one, case ignored; words of at most 31 characters. */
static unsigned distance(const char *a, size_t n, const char *b, size_t m)
{
    unsigned d[33][33];
    for (size_t i = 0; i <= n; i++)
        d[i][0] = (unsigned)i;
    for (size_t j = 0; j <= m; j++)
        d[0][j] = (unsigned)j;
    for (size_t i = 1; i <= n; i++) {
        for (size_t j = 1; j <= m; j++) {
            unsigned best = d[i - 1][j - 1] + (lower(a[i - 1]) != lower(b[j - 1]));
            if (d[i - 1][j] + 1 < best)
                best = d[i - 1][j] + 1;
            if (d[i][j - 1] + 1 < best)
                best = d[i][j - 1] + 1;
            if (i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) && lower(a[i - 2]) == lower(b[j - 1]) &&
                d[i - 2][j - 2] + 1 < best)
                best = d[i - 2][j - 2] + 1;
            d[i][j] = best;
        }
    }
    return d[n][m];
}

const char *rti_nearest(const char *word, const char *const *names, size_t count)
{
    size_t n = strlen(word);
    const char *best = NULL;
    unsigned least = (unsigned)(2 + n / 3);
    if (n > 31)
        return NULL;
    for (size_t i = 0; i < count; i++) {
        size_t m = strlen(names[i]);
        unsigned d;
        if (m > 31)
            continue;
        d = distance(word, n, names[i], m);
        if (d < least) {
            least = d;
            best = names[i];
        }
    }
    return best;
}

/* Length of the valid UTF-8 character at p, 0 when there is none. */
static size_t utf8_length(const unsigned char *p, size_t left)
{
    size_t n = p[0] < 0x80                   ? 1
               : p[0] >= 0xc2 && p[0] < 0xe0 ? 2
               : p[0] >= 0xe0 && p[0] < 0xf0 ? 3
               : p[0] >= 0xf0 && p[0] < 0xf5 ? 4
                                             : 0;
    if (n == 0 || n > left)
        return 0;
    for (size_t i = 1; i < n; i++)
        if ((p[i] & 0xc0) != 0x80)
            return 0;
    if ((p[0] == 0xe0 && p[1] < 0xa0) || (p[0] == 0xed && p[1] > 0x9f) || (p[0] == 0xf0 && p[1] < 0x90) ||
        (p[0] == 0xf4 && p[1] > 0x8f))
        return 0;
    return n;
}

const char *rti_quote(char *buffer, size_t size, const char *text, size_t length)
{
    const unsigned char *p = (const unsigned char *)text;
    size_t used = 0;
    if (size == 0)
        return buffer;
    for (size_t i = 0; i < length;) {
        size_t n = p[i] < 0x20 || p[i] == 0x7f ? 0 : utf8_length(p + i, length - i);
        size_t need = n ? n : 4;
        if (used + need + 4 > size) {
            if (used + 4 <= size)
                memcpy(buffer + used, "...", 3), used += 3;
            break;
        }
        if (n)
            memcpy(buffer + used, p + i, n);
        else
            snprintf(buffer + used, 5, "\\x%02x", p[i]);
        used += need;
        i += n ? n : 1;
    }
    buffer[used < size ? used : size - 1] = '\0';
    return buffer;
}
