/* Shapes in long double: signed distances as the judge of the float kernels. */
#ifndef LIBRT_TEST_KERNEL_SDF_H
#define LIBRT_TEST_KERNEL_SDF_H

#include "kernel/snapshot.h"
#include "kernel_random.h"

typedef long double real;
typedef struct real3 {
    real x, y, z;
} real3;

static inline real3 real3_of(rtk_vec3 v)
{
    return (real3){v.x, v.y, v.z};
}
static inline real3 real3_sub(real3 a, real3 b)
{
    return (real3){a.x - b.x, a.y - b.y, a.z - b.z};
}
static inline real real3_dot(real3 a, real3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline real3 real3_madd(real3 a, real t, real3 d)
{
    return (real3){a.x + t * d.x, a.y + t * d.y, a.z + t * d.z};
}
static inline real real_max(real a, real b)
{
    return a > b ? a : b;
}

static inline real sdf_box2(real x, real y) /* of the corner x <= 0, y <= 0 */
{
    return x > 0 && y > 0 ? sqrtl(x * x + y * y) : real_max(x, y);
}

/* A frustum in the half plane (distance m from the axis, height z): its side is a line, its caps are z = 0 and z = h. Exact
 * inside and beside the faces, a lower bound of the distance elsewhere. */
static inline real sdf_cone(const rtk_shape *s, real3 p)
{
    real3 e0 = {s->p[0], s->p[1], s->p[2]}, e1 = {s->p[4], s->p[5], s->p[6]}, a = real3_sub(e1, e0), q = real3_sub(p, e0);
    real h = sqrtl(real3_dot(a, a)), z = real3_dot(q, a) / h, r1 = s->type == RTK_SHAPE_CONE ? s->p[7] : s->p[3];
    real m = sqrtl(real_max(0, real3_dot(q, q) - z * z)), k = (r1 - s->p[3]) / h;
    real3 axial = real3_madd(q, -z / h, a);
    m = sqrtl(real3_dot(axial, axial));
    return real_max((m - (s->p[3] + k * z)) / sqrtl(1 + k * k), real_max(-z, z - h));
}

static inline real sdf(const rtk_shape *s, real3 p)
{
    real3 c = {s->p[0], s->p[1], s->p[2]}, q = real3_sub(p, c);
    if (s->type == RTK_SHAPE_SPHERE)
        return sqrtl(real3_dot(q, q)) - s->p[3];
    if (s->type == RTK_SHAPE_BOX) {
        real x = real_max(s->p[0] - p.x, p.x - s->p[3]), y = real_max(s->p[1] - p.y, p.y - s->p[4]);
        return real_max(real_max(x, y), real_max(s->p[2] - p.z, p.z - s->p[5]));
    }
    if (s->type == RTK_SHAPE_TORUS) {
        real3 n = {s->p[4], s->p[5], s->p[6]};
        real l = sqrtl(real3_dot(n, n)), z = real3_dot(q, n) / l;
        real3 axial = real3_madd(q, -z / l, n);
        real a = sqrtl(real3_dot(axial, axial)) - s->p[3];
        return sqrtl(a * a + z * z) - s->p[7];
    }
    return sdf_cone(s, p);
}

static inline void shape_vec(rtk_shape *s, int at, rtk_vec3 v)
{
    s->p[at] = v.x;
    s->p[at + 1] = v.y;
    s->p[at + 2] = v.z;
}

/* A shape of about the given size around a centre. Thin ones too. */
static inline rtk_shape make_shape(rng *g, rtk_u32 type, float size, rtk_vec3 at)
{
    rtk_shape s = {type, 0, 0, 0, {0}};
    float thin = rng_u32(g) % 4 == 0 ? 0.02f : 1.0f;
    shape_vec(&s, 0, at);
    if (type == RTK_SHAPE_SPHERE) {
        s.p[3] = size * (0.3f + 0.7f * rng_unit(g));
    } else if (type == RTK_SHAPE_BOX) {
        rtk_vec3 e = rtk_v3(size * (0.1f + rng_unit(g)), size * thin * (0.1f + rng_unit(g)), size * (0.1f + rng_unit(g)));
        shape_vec(&s, 0, rtk_sub(at, e));
        shape_vec(&s, 3, rtk_add(at, e));
    } else if (type == RTK_SHAPE_TORUS) {
        shape_vec(&s, 4, rng_dir(g));
        s.p[3] = size * (0.5f + 0.3f * rng_unit(g));
        s.p[7] = s.p[3] * thin * (0.1f + 0.89f * rng_unit(g));
    } else {
        rtk_vec3 half = rtk_scale(rng_dir(g), size * (0.2f + 0.8f * rng_unit(g)));
        uint32_t how = rng_u32(g) % 4;
        shape_vec(&s, 0, rtk_sub(at, half));
        shape_vec(&s, 4, rtk_add(at, half));
        s.p[3] = size * thin * (0.1f + rng_unit(g));
        s.p[7] = size * thin * (0.1f + rng_unit(g));
        if (type == RTK_SHAPE_CONE && how < 2)
            s.p[how ? 3 : 7] = 0.0f;
    }
    return s;
}

#endif
