/* Where rays end that bring too little. */
#ifndef RTI_SHADE_LIMITS_H
#define RTI_SHADE_LIMITS_H

/* A ray is not followed when every component of its throughput is below this: 1/1024, a quarter of a step of an 8-bit picture
 * for each unit of light. */
#define RTI_THROUGHPUT_MIN 0.0009765625f

#endif
