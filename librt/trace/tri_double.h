/* The leaf test's second half in doubles, for many pairs of a ray and a triangle. Included by packet.h.
 *
 * rtk_tri_exact ends in quotients of doubled floats, each rounded to a float once: RN(x + e), x the true value for the sheared
 * corners or for the plane, e bounded. Doubles find x far better than that. So where x less a bound of e and x plus it round to
 * one float, that is what rtk_tri_exact gives, for a third of its operations; of the others, one in ten thousand, it is asked.
 *
 * Bounds, u = 2^-24, by twofloat.h. A quotient adds 24 u^2 of itself to what its terms have; doubles add less than u^2 to each.
 *   v, w    16 u^2 of themselves; det, the sum of three of one sign, 24 u^2
 *   b, c    64 u^2 of themselves                                                                                  taken as 256 u^2
 *   z       84 u^2 T, T = |az| + b |bz - az| + c |cz - az|: each product 36 u^2 of itself, det and the quotient   taken as 512 u^2
 *   plane   36 u^2 of T = sum S |o|, and of sum S |d|, S = |ey fz| + |ez fy| and so on                            taken as 256 u^2
 * They hold while nothing over- or underflows. Coordinates are no more than DOUBLE_SCALE, where nothing overflows. Products below
 * 2^-101 lose bits, in all of an expression no more than 2^-144, and as many times |o| <= 5 scale, or |d|, when a normal is
 * multiplied by those; what is below the DOUBLE_LEAST_* is not decided here, and so that is less than a fortieth of each bound.
 * (The sheared corners are scaled there so that products keep more than that.) A quotient of the plane below 2^-100 is rounded
 * there by more than its terms are off.
 */
#ifndef RTI_TRI_DOUBLE_H
#define RTI_TRI_DOUBLE_H

/* Vectors of doubles as wide as compilers make them, and their lanes' floats. */
#define DOUBLE_N (RTI_SIMD >= 16 ? 8 : 4)
typedef double double_vec __attribute__((vector_size(DOUBLE_N * sizeof(double))));
typedef int64_t double_mask __attribute__((vector_size(DOUBLE_N * sizeof(double))));
typedef float double_half __attribute__((vector_size(DOUBLE_N * sizeof(float))));

#define DOUBLE_ABS(a) ((double_vec)((double_mask)(a)&INT64_MAX)) /* no function: such vectors are no arguments everywhere */

#define DOUBLE_SCALE        2.7487791e11f /* 2^38; rays start within RTK_FAR of it */
#define DOUBLE_DIR          9.3132257e-10f /* 2^-30: |kdz| is from this to 1 / this */
#define DOUBLE_LEAST_DET    9.0949470e-13 /* 2^-40 of |x| |y| */
#define DOUBLE_LEAST_WEIGHT 8.0779357e-28 /* 2^-90 of |x| |y| */
#define DOUBLE_LEAST_DEPTH  8.8817842e-16 /* 2^-50 */
#define DOUBLE_LEAST_PLANE  1.2621775e-29 /* 2^-96 of scale, or of |kdz|, and */
#define DOUBLE_LEAST        3.1554436e-30 /* 2^-98 more */
#define DOUBLE_LEAST_QUOTIENT 7.8886091e-31 /* 2^-100, of the plane's: its correction by the remainder is rounded at 2^-150 */
#define DOUBLE_OFF_B        9.0949470e-13 /* 2^-40 */
#define DOUBLE_OFF_Z        1.8189894e-12 /* 2^-39 */
#define DOUBLE_OFF_PLANE    9.0949470e-13 /* 2^-40 */
#define DOUBLE_OFF_QUOTIENT 4.5474735e-13 /* 2^-41 */
#define DOUBLE_GRAZES       9.3132257e-10 /* 2^-30: of the plane's denominator, below which a bound of it is no bound */

#define tri_double   LANES_TYPE(tri_pairs, RTI_SIMD)
#define DOUBLE_WIDTH DOUBLE_N
#define RTI_N        RTI_SIMD
#include "tri_double.inl"
#undef RTI_N
#undef DOUBLE_WIDTH
#if RTI_SIMD > 4 /* for a pair by itself */
#define DOUBLE_WIDTH 2
#define RTI_N        4
#include "tri_double.inl"
#undef RTI_N
#undef DOUBLE_WIDTH
#endif

#endif
