/* Boxes while more and more is put into them, for hot files. Private to accel/. */
#ifndef RTI_HULL_H
#define RTI_HULL_H

#include "bvh_build.h"

/* Around boxes. In eight lanes highs are negated, so both halves are the least there is. Of two equal ones the second stays. */
#if RTI_SIMD >= 8
typedef rti_f8 hull;
typedef int32_t i8 __attribute__((vector_size(32)));

static inline rti_f8 turned(rti_f8 a)
{
    return (rti_f8)((i8)a ^ (i8){0, 0, 0, 0, INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN});
}

static inline hull hull_nothing(void)
{
    return rti_f8_set(RTK_INF);
}

static inline hull hull_ref(const rti_ref *ref)
{
    return turned(rti_f8_load(ref->lo));
}

/* A point; where not all of mask is ones, what changes nothing: no number. */
static inline hull hull_point(rti_f4 p, int32_t mask)
{
    return (rti_f8)((i8)turned(rti_f8_both(p, p)) | ~(i8){mask, mask, mask, mask, mask, mask, mask, mask});
}

static inline hull hull_around(hull a, hull b)
{
    return rti_f8_min(a, b);
}

static inline hull hull_load(const rti_bvh_box *bin)
{
    return rti_f8_load((const float *)&bin->lo);
}

static inline void hull_store(rti_bvh_box *bin, hull a)
{
    rti_f8_store((float *)&bin->lo, a);
}

static inline hull hull_of(rti_bvh_box b)
{
    return turned(rti_f8_both(b.lo, b.hi));
}

static inline rti_bvh_box hull_box(hull a)
{
    const rti_f8 b = turned(a);
    return (rti_bvh_box){rti_f8_low(b), rti_f8_high(b)};
}

/* Products of two are those of its sides. */
static inline rti_f4 hull_negative_sides(hull a)
{
    return rti_f8_low(a) + rti_f8_high(a);
}
#else
typedef rti_bvh_box hull;

static inline hull hull_nothing(void)
{
    return rti_bvh_nothing();
}

static inline hull hull_ref(const rti_ref *ref)
{
    return rti_bvh_ref_box(ref);
}

static inline hull hull_point(rti_f4 p, int32_t mask)
{
    const rti_f4 some = (rti_f4)((rti_i4)p | ~rti_i4_set(mask));
    return (hull){some, some};
}

static inline hull hull_around(hull a, hull b)
{
    return (hull){rti_f4_min(a.lo, b.lo), rti_f4_max(a.hi, b.hi)};
}

static inline hull hull_load(const rti_bvh_box *bin)
{
    return *bin;
}

static inline void hull_store(rti_bvh_box *bin, hull a)
{
    *bin = a;
}

static inline hull hull_of(rti_bvh_box b)
{
    return b;
}

static inline rti_bvh_box hull_box(hull a)
{
    return a;
}

static inline rti_f4 hull_negative_sides(hull a)
{
    return a.lo - a.hi;
}
#endif

#endif
