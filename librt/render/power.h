/* Exponential, logarithm and powers of doubles from + - * / alone: the same bits with every C library. */
#ifndef RTI_POWER_H
#define RTI_POWER_H

#include <stdint.h>
#include <string.h>

#define RTI_LN2_HIGH 0x1.62e42fefa38p-1 /* 40 bits: its product with an exponent is exact */
#define RTI_LN2_LOW  0x1.ef35793c7673p-45

/* 2^k for -1022 <= k <= 1023 */
static inline double rti_two_to(int k)
{
    uint64_t bits = (uint64_t)(1023 + k) << 52;
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* e^x to about 1e-15 of it, for -700 <= x <= 700; below it is 0, above it stays. */
static inline double rti_math_exp(double x)
{
    static const double inverse_factorial[15] = {
        1.0,         1.0,          1.0 / 2,       1.0 / 6,        1.0 / 24,        1.0 / 120,        1.0 / 720,        1.0 / 5040,
        1.0 / 40320, 1.0 / 362880, 1.0 / 3628800, 1.0 / 39916800, 1.0 / 479001600, 1.0 / 6227020800, 1.0 / 87178291200};
    int k;
    double r, sum = 0;
    if (!(x >= -700))
        return 0;
    x = x < 700 ? x : 700;
    k = (int)(x / RTI_LN2_HIGH + (x < 0 ? -0.5 : 0.5));
    r = (x - k * RTI_LN2_HIGH) - k * RTI_LN2_LOW;
    for (int i = 14; i >= 0; i--) /* |r| <= 0.35: the next term is below 2^-60 */
        sum = sum * r + inverse_factorial[i];
    return sum * rti_two_to(k);
}

/* ln x for a normal x > 0, to about 1e-15 */
static inline double rti_math_log(double x)
{
    uint64_t bits;
    double s, s2, sum = 0;
    int k;
    memcpy(&bits, &x, sizeof bits);
    k = (int)(bits >> 52) - 1023;
    bits = (bits & 0xfffffffffffffu) | (uint64_t)1023 << 52;
    memcpy(&x, &bits, sizeof x);
    if (x > 1.4142135623730951) {
        x /= 2;
        k++;
    }
    s = (x - 1) / (x + 1); /* ln x = 2 atanh s, |s| <= 0.172 */
    s2 = s * s;
    for (int i = 23; i >= 1; i -= 2)
        sum = sum * s2 + 1.0 / i;
    return k * RTI_LN2_HIGH + (k * RTI_LN2_LOW + 2 * s * sum);
}

/* x^y for a normal or zero x >= 0 and y > 0 */
static inline double rti_math_pow(double x, double y)
{
    return x < 1e-300 ? 0 : rti_math_exp(y * rti_math_log(x));
}

#endif
