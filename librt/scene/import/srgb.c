#include "srgb.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

/* x^(1/n) for x in (0, 1], n 3 or 5: Newton from a guess made of the exponent bits (within 7%; five steps give all 53 bits). */
static double root(double x, int n)
{
    uint64_t bits, one = UINT64_C(0x3ff0000000000000);
    memcpy(&bits, &x, sizeof bits);
    bits = bits / (uint64_t)n + (one - one / (uint64_t)n);
    double r;
    memcpy(&r, &bits, sizeof r);
    for (int i = 0; i < 5; i++) {
        double power = n == 3 ? r * r : r * r * (r * r);
        r = ((n - 1) * r + x / power) / n;
    }
    return r;
}

double rti_srgb_encode(double linear)
{
    if (!(linear > 0.0))
        return 0.0;
    if (linear >= 1.0)
        return 1.0;
    if (linear <= 0.0031308)
        return 12.92 * linear;
    double c = root(linear, 3); /* x^(1/2.4) = x^(1/3) * x^(1/12) */
    return 1.055 * (c * sqrt(sqrt(c))) - 0.055;
}

double rti_srgb_decode(double encoded)
{
    if (!(encoded > 0.0))
        return 0.0;
    if (encoded >= 1.0)
        return 1.0;
    if (encoded <= 0.04045)
        return encoded / 12.92;
    double u = (encoded + 0.055) / 1.055;
    return u * u * root(u * u, 5); /* u^2.4 = u^2 * (u^2)^(1/5) */
}

static float float_of(uint32_t bits)
{
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static bool reaches(uint32_t bits, int code)
{
    return 255.0 * rti_srgb_encode(float_of(bits)) + 0.5 >= code;
}

/* Bits of positive floats ascend with them: a code's smallest float stands beside the curve's inverse. */
void rti_srgb_encoder_init(rti_srgb_encoder *e)
{
    e->least[0] = 0.0f;
    for (int code = 1; code < 256; code++) {
        float guess = (float)rti_srgb_decode((code - 0.5) / 255.0);
        uint32_t bits;
        memcpy(&bits, &guess, sizeof bits);
        while (reaches(bits - 1, code))
            bits--;
        while (!reaches(bits, code))
            bits++;
        e->least[code] = float_of(bits);
    }
    e->least[256] = 2.0f;
    for (uint32_t i = 0, code = 0; i < sizeof e->first; i++) {
        while (code < 255 && float_of(RTI_SRGB_LOW + (i << 17)) >= e->least[code + 1])
            code++;
        e->first[i] = (uint8_t)code;
    }
}
