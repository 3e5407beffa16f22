/* The sRGB transfer curve (IEC 61966-2-1), exact to double rounding and the same on every machine: only + - * / and sqrt. */
#ifndef RTI_SRGB_H
#define RTI_SRGB_H

double rti_srgb_encode(double linear); /* 0 ... 1 to 0 ... 1; outside it is clamped, NaN gives 0 */
double rti_srgb_decode(double encoded);

/* The 256 linear values of the byte codes. */
void rti_srgb_decode_table(float table[256]);

#endif
