/* Where rays end that bring too little. */
#ifndef RTI_SHADE_LIMITS_H
#define RTI_SHADE_LIMITS_H

/* A ray is not followed when every component of its throughput is below this: 1/1024, a quarter of a step of an 8-bit picture
 * for each unit of light. */
#define RTI_THROUGHPUT_MIN 0.0009765625f

/* Path: the probability with which a path goes on where Russian roulette may end it. */
#define RTI_SURVIVE_MIN 0.05f
#define RTI_SURVIVE_MAX 0.95f

#endif
