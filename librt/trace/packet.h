/* What packets of every tree share, for hot files: the widest vectors under one name, rays loaded and prepared in them, and
 * what the leaf test in them leaves in doubt. */
#ifndef RTI_PACKET_H
#define RTI_PACKET_H

#include "shape_lanes.h"
#include "lane.h"
#include "tri_lanes.h"

#if RTI_SIMD >= 16
#define V(op)      rti_f16_##op
#define VM(op)     rti_m16_##op
#define VI(op)     rti_i16_##op
#define vec        rti_f16
#define vec_rows   rti_i16
#define vmask      rti_m16
#define tri_test   rti_tri16
#define tri_told   rti_tri_told16
#define tri_bounds rti_tri_bounds16
#define tri_inside rti_tri_inside16
#define tri_ray    rti_tri_ray16
#define tri_hit    rti_tri_hit16
#define ball_many  rti_ball16
#define ball_rays  rti_ball_ray16
#define balls_meet rti_ball_rays16
#define balls_near rti_ball_near16
#define ball_ready rti_ball_ready16
#define box_many   rti_box_test16
#define cone_many  rti_cone_test16
#define cone_ends  rti_cone16
#elif RTI_SIMD >= 8
#define V(op)      rti_f8_##op
#define VM(op)     rti_m8_##op
#define VI(op)     rti_i8_##op
#define vec        rti_f8
#define vec_rows   rti_i8
#define vmask      rti_m8
#define tri_test   rti_tri8
#define tri_told   rti_tri_told8
#define tri_bounds rti_tri_bounds8
#define tri_inside rti_tri_inside8
#define tri_ray    rti_tri_ray8
#define tri_hit    rti_tri_hit8
#define ball_many  rti_ball8
#define ball_rays  rti_ball_ray8
#define balls_meet rti_ball_rays8
#define balls_near rti_ball_near8
#define ball_ready rti_ball_ready8
#define box_many   rti_box_test8
#define cone_many  rti_cone_test8
#define cone_ends  rti_cone8
#else
#define V(op)      rti_f4_##op
#define VM(op)     rti_m4_##op
#define vec        rti_f4
#define vmask      rti_m4
#define tri_test   rti_tri4
#define tri_told   rti_tri_told4
#define tri_bounds rti_tri_bounds4
#define tri_inside rti_tri_inside4
#define tri_ray    rti_tri_ray4
#define tri_hit    rti_tri_hit4
#define ball_many  rti_ball4
#define ball_rays  rti_ball_ray4
#define balls_meet rti_ball_rays4
#define balls_near rti_ball_near4
#define ball_ready rti_ball_ready4
#define box_many   rti_box_test4
#define cone_many  rti_cone_test4
#define cone_ends  rti_cone4
#endif
#define LANES_ALL ((1u << RTI_SIMD) - 1u)

/* Whole numbers of lanes. */
typedef int32_t vec_whole __attribute__((vector_size(RTI_SIMD * sizeof(int32_t))));
typedef uint32_t vec_bits __attribute__((vector_size(RTI_SIMD * sizeof(uint32_t))));
typedef uint16_t vec_short __attribute__((vector_size(RTI_SIMD * sizeof(uint16_t))));

/* Lanes of numbers that are not 0. */
RTI_VEC rtk_u32 packet_some(vec_bits a)
{
    const vec_bits none = (vec_bits)(a == 0u);
    vec x;
    memcpy(&x, &none, sizeof x); /* lanes of all ones are no numbers */
    return VM(bits)(V(eq)(x, x));
}

/* Numbers of lanes, and the words at which their records begin. */
#define LANES_BY(n)                                                                                                             \
    {                                                                                                                           \
        0u, (n), 2u * (n), 3u * (n), 4u * (n), 5u * (n), 6u * (n), 7u * (n), 8u * (n), 9u * (n), 10u * (n), 11u * (n), 12u * (n),\
            13u * (n), 14u * (n), 15u * (n)                                                                                     \
    }
static const rtk_u32 lane_ones[16] = LANES_BY(1u);
static const rtk_u32 lane_fours[16] __attribute__((unused)) = LANES_BY(4u);
static const rtk_u32 lane_eights[16] __attribute__((unused)) = LANES_BY(8u);
#undef LANES_BY

#include "tri_double.h"
#include "tri_exact.h"

/* RTI_SIMD rays of a block. valid: rtk_ray_valid; axes, back: the dominant axis and the negative directions, a bit a lane. */
typedef struct packet_rays {
    vec org[3], dir[3], inv[3], tmin, tmax;
    rtk_u32 valid, axes[3], back[3];
} packet_rays;

RTI_VEC void packet_rays_load(packet_rays *r, const rtk_trace_block *b, rtk_u32 lane)
{
    const float *org[3] = {b->ox + lane, b->oy + lane, b->oz + lane}, *dir[3] = {b->dx + lane, b->dy + lane, b->dz + lane};
    const vec most = V(set)(3.402823466e38f), zero = V(set)(0.0f), top = V(set)(RTK_INV_MAX);
    vec size[3], longest;
    r->tmin = V(load)(b->tmin + lane);
    r->tmax = V(load)(b->tmax + lane);
    r->valid = VM(bits)(V(lt)(r->tmin, r->tmax));
    for (rtk_u32 a = 0u; a < 3u; a++) {
        vec d = V(load)(dir[a]), inv = V(set)(1.0f) / d, flat = V(select)(V(lt)(inv, zero), -top, top); /* rtk_inverse */
        r->org[a] = V(load)(org[a]);
        r->dir[a] = d;
        size[a] = V(abs)(d);
        r->inv[a] = V(select)(V(lt)(size[a], V(set)(1.0e-30f)), flat, V(min)(V(max)(inv, -top), top));
        r->back[a] = VM(bits)(V(lt)(r->inv[a], zero));
        r->valid &= VM(bits)(V(le)(V(abs)(r->org[a]), most)) & VM(bits)(V(le)(size[a], most));
    }
    longest = V(max)(V(max)(size[0], size[1]), size[2]);
    r->valid &= VM(bits)(V(le)(V(set)(RTK_DIR_MIN), longest)) & VM(bits)(V(le)(longest, V(set)(RTK_DIR_MAX)));
    r->axes[0] = VM(bits)(V(lt)(size[1], size[0])) & VM(bits)(V(lt)(size[2], size[0]));
    r->axes[1] = VM(bits)(V(lt)(size[2], size[1])) & ~r->axes[0];
    r->axes[2] = LANES_ALL & ~(r->axes[0] | r->axes[1]);
}

/* Of rays that start far away, those that miss a part whatever moving their origins does to them: rtk_ray_passes. */
RTI_VEC rtk_u32 packet_rays_pass(const vec org[3], const vec inv[3], vec tmin, const float lo[3], const float hi[3], float scale)
{
    const vec zero = V(set)(0.0f);
    const vec grow = V(set)(3.8146973e-06f) * (V(max)(V(max)(V(abs)(org[0]), V(abs)(org[1])), V(abs)(org[2])) + V(set)(scale));
    vec in = V(set)(-RTK_INF), out = V(set)(RTK_INF);
    for (rtk_u32 a = 0u; a < 3u; a++) {
        const vec x = ((V(set)(lo[a]) - grow) - org[a]) * inv[a], y = ((V(set)(hi[a]) + grow) - org[a]) * inv[a];
        in = V(max)(in, V(min)(x, y));
        out = V(min)(out, V(max)(x, y));
    }
    return VM(bits)(V(lt)(out, in)) | (VM(bits)(V(lt)(out, zero)) & VM(bits)(V(le)(zero, tmin)));
}

/* What rtk_ray_prepare settles: returns those of `lanes` that enter the part, and where. far: those that may, whose origins would
 * be moved. */
RTI_VEC rtk_u32 packet_rays_enter(const vec org[3], const vec inv[3], vec tmin, vec tmax, rtk_u32 lanes, const rtk_part *part,
                                  vec *t0, vec *t1, rtk_u32 *far)
{
    const float lo[3] = {part->lo.x, part->lo.y, part->lo.z}, hi[3] = {part->hi.x, part->hi.y, part->hi.z};
    const vec edge = V(set)(RTK_FAR * part->scale);
    vec in = V(set)(-RTK_INF), out = V(set)(RTK_INF);
    rtk_u32 meet;
    *far = 0u;
    for (rtk_u32 a = 0u; a < 3u; a++) {
        vec x = (V(set)(lo[a]) - org[a]) * inv[a], y = (V(set)(hi[a]) - org[a]) * inv[a];
        in = V(max)(in, V(min)(x, y));
        out = V(min)(out, V(max)(x, y));
        *far |= VM(bits)(V(lt)(edge, V(abs)(org[a])));
    }
    *far &= lanes;
    meet = lanes & VM(bits)(V(le)(in, out)) & ~VM(bits)(V(lt)(out, tmin)) & ~VM(bits)(V(lt)(tmax, in));
    *t0 = V(max)(in, tmin);
    *t1 = V(min)(out, tmax);
    meet &= ~*far;
    if (*far)
        *far &= ~packet_rays_pass(org, inv, tmin, lo, hi, part->scale);
    return meet;
}

/* rti_tri_settle for many rays and triangles: what it says in doubles of each lane. end: tmax or less. Returns the lanes that are
 * to be asked; sure: hits for certain. */
__attribute__((noinline, unused)) static rtk_u32 packet_settle_many(const tri_ray *r, const vec *end, const vec v0[3],
                                                                    const vec v1[3], const vec v2[3], rtk_u32 lanes,
                                                                    rtk_u32 *sure)
{
    enum { AX, AY, AZ, BX, BY, BZ, CX, CY, CZ, MX, MY, KDZ, TSHIFT, SCALE, TMIN, TMAX, COUNT };
    const vec az = v0[2] - r->oz, bz = v1[2] - r->oz, cz = v2[2] - r->oz;
    const vec ax = (v0[0] - r->ox) - r->sx * az, ay = (v0[1] - r->oy) - r->sy * az;
    const vec bx = (v1[0] - r->ox) - r->sx * bz, by = (v1[1] - r->oy) - r->sy * bz;
    const vec cx = (v2[0] - r->ox) - r->sx * cz, cy = (v2[1] - r->oy) - r->sy * cz;
    const vec mx = V(max)(V(max)(V(abs)(ax), V(abs)(bx)), V(abs)(cx)), my = V(max)(V(max)(V(abs)(ay), V(abs)(by)), V(abs)(cy));
    const vec in[COUNT] = {ax, ay, az, bx, by, bz, cx, cy, cz, mx, my, r->kdz, r->tshift, r->scale, r->tmin, *end};
    float from[COUNT][RTI_SIMD], says[RTI_SIMD];
    for (rtk_u32 k = 0u; k < COUNT; k++)
        V(store)(from[k], in[k]);
    for (rtk_u32 at = 0u; at < RTI_SIMD; at += DOUBLE_N) {
        const double_vec nought = {0.0};
        double_vec x[COUNT];
        double_half half;
        for (rtk_u32 k = 0u; k < COUNT; k++) {
            memcpy(&half, from[k] + at, sizeof half);
            x[k] = __builtin_convertvector(half, double_vec);
        }
        const double_vec u = x[CX] * x[BY] - x[CY] * x[BX], v = x[AX] * x[CY] - x[AY] * x[CX], w = x[BX] * x[AY] - x[BY] * x[AX];
        const double_vec det = u + v + w, size = DOUBLE_ABS(det);
        const double_vec near = (x[AZ] + (v * (x[BZ] - x[AZ]) + w * (x[CZ] - x[AZ])) / det) / x[KDZ];
        const double_vec wide = (double)SETTLE_OFF * x[SCALE] / DOUBLE_ABS(x[KDZ]) + SETTLE_OFF_LEAST;
        const double_vec off = wide + SETTLE_OFF_T * (DOUBLE_ABS(near) + DOUBLE_ABS(x[TSHIFT]));
        const double_vec t = near + x[TSHIFT];
        const double_mask out = ((u < 0.0) | (v < 0.0) | (w < 0.0)) & ((u > 0.0) | (v > 0.0) | (w > 0.0));
        const double_mask good = ~out & (size > SETTLE_DET * (x[MX] * x[MY])) & (size < SETTLE_DET_MOST);
        const double_mask none = out | (good & ((t + off < x[TMIN]) | (t - off > x[TMAX])));
        const double_mask some = good & ~none & (t - off > x[TMIN]) & (t + off < x[TMAX]);
        const double_vec word = (double_vec)(((double_mask)(nought + 1.0) & some) | ((double_mask)(nought - 1.0) & none));
        half = __builtin_convertvector(word, double_half);
        memcpy(says + at, &half, sizeof half);
    }
    const vec zero = V(set)(0.0f), word = V(load)(says);
    *sure = lanes & VM(bits)(V(lt)(zero, word));
    return lanes & VM(bits)(V(eq)(word, zero));
}

#define SETTLE_MANY 4 /* doubted lanes that are settled together */

/* Of a triangle's doubted lanes, those that rti_tri_settle leaves to be asked. best: where each lane's best hit is, behind which
 * a closest hit is none. Any hit: sure ones are added to `take` (NULL: none may be). v0, v1, v2: the corners in the rays' order
 * of axes. */
RTI_VEC rtk_u32 packet_settle(const tri_ray *rays, vec best, rtk_u32 mode, rtk_u32 doubt, const float v0[3], const float v1[3],
                              const float v2[3], rtk_u32 *take)
{
    rtk_u32 ask = 0u;
    if (__builtin_popcount(doubt) >= SETTLE_MANY) {
        const vec end = mode & RTK_MODE_ANY ? rays->tmax : best;
        const vec c0[3] = {V(set)(v0[0]), V(set)(v0[1]), V(set)(v0[2])}, c1[3] = {V(set)(v1[0]), V(set)(v1[1]), V(set)(v1[2])};
        const vec c2[3] = {V(set)(v2[0]), V(set)(v2[1]), V(set)(v2[2])};
        rtk_u32 sure;
        ask = packet_settle_many(rays, &end, c0, c1, c2, doubt, &sure);
        if (!take || !(mode & RTK_MODE_ANY))
            return ask | sure;
        *take |= sure;
        return ask;
    }
    for (; doubt != 0u; doubt &= doubt - 1u) {
        const rtk_u32 i = (rtk_u32)__builtin_ctz(doubt);
        const rti_tri_pair r = {
            rays->ox[i],  rays->oy[i],     rays->oz[i],    rays->sx[i],   rays->sy[i],
            rays->kdz[i], rays->tshift[i], rays->scale[i], rays->tmin[i], mode & RTK_MODE_ANY ? rays->tmax[i] : best[i]};
        const int sure = rti_tri_settle(&r, v0, v1, v2, NULL);
        if (sure > 0 && take && (mode & RTK_MODE_ANY))
            *take |= 1u << i;
        else if (sure >= 0)
            ask |= 1u << i;
    }
    return ask;
}

#endif
