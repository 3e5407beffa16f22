/* The sRGB transfer curve (IEC 61966-2-1), exact to double rounding and the same on every machine: only + - * / and sqrt. */
#ifndef RTI_SRGB_H
#define RTI_SRGB_H

#include <stdint.h>
#include <string.h>

double rti_srgb_encode(double linear); /* 0 ... 1 to 0 ... 1; outside it is clamped, NaN gives 0 */
double rti_srgb_decode(double encoded);

/* Bytes: round(255 * encode(x)) for every float x, by comparison with the smallest float of each code. */
#define RTI_SRGB_LOW 0x39800000u /* bits of 2^-12; below it there are the codes 0 and 1 only */
typedef struct rti_srgb_encoder {
    float least[257];           /* [code]; [256] is never reached */
    uint8_t first[12 * 64 + 1]; /* code of the smallest float of each 64th of a binade from 2^-12 to 1 */
} rti_srgb_encoder;
void rti_srgb_encoder_init(rti_srgb_encoder *e);

static inline uint8_t rti_srgb_byte(const rti_srgb_encoder *e, float x)
{
    uint32_t bits, code = 0;
    if (!(x > 0.0f))
        return 0;
    if (x >= 1.0f)
        return 255;
    memcpy(&bits, &x, sizeof bits);
    if (bits >= RTI_SRGB_LOW)
        code = e->first[(bits - RTI_SRGB_LOW) >> 17];
    while (x >= e->least[code + 1])
        code++;
    return (uint8_t)code;
}

#endif
