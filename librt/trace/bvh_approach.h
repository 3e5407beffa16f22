/* Rays that start far away from a part, as many at a time as vectors have lanes, for hot files: their origins are moved, as
 * rtk_ray_prepare moves each ray's (kernel/ray.h). */
#ifndef RTI_BVH_APPROACH_H
#define RTI_BVH_APPROACH_H

#include "bvh_packet.h"

/* rtk_ray_approach of the lanes `far`, which start far away: moves their origins. Returns those that it could not be done to. */
RTI_VEC rtk_u32 rays_approach(const packet_rays *r, const rtk_part *part, rtk_u32 far, vec org[3], vec *shift)
{
    const vec edge = V(set)(RTK_FAR * part->scale), most = V(set)(3.402823466e38f), zero = V(set)(0.0f);
    const float mid[3] = {0.5f * (part->lo.x + part->hi.x), 0.5f * (part->lo.y + part->hi.y), 0.5f * (part->lo.z + part->hi.z)};
    const vec m = V(max)(V(max)(V(abs)(r->dir[0]), V(abs)(r->dir[1])), V(abs)(r->dir[2]));
    const vec d[3] = {r->dir[0] / m, r->dir[1] / m, r->dir[2] / m};
    const vec dd = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    rtk_u32 left = far;
    *shift = zero;
    for (rtk_u32 a = 0u; a < 3u; a++)
        org[a] = r->org[a];
    for (rtk_u32 k = 0u; k < 6u && left != 0u; k++) {
        const vec f[3] = {V(set)(mid[0]) - org[0], V(set)(mid[1]) - org[1], V(set)(mid[2]) - org[2]};
        const vec step = (f[0] * d[0] + f[1] * d[1] + f[2] * d[2]) / dd / m;
        const vmask go = VM(of)(left);
        for (rtk_u32 a = 0u; a < 3u; a++) { /* rtk_ff_along */
            const wide_ff p = wide_two_prod(step, r->dir[a]), s = wide_two_sum(org[a], p.hi);
            org[a] = V(select)(go, s.hi + (s.lo + p.lo), org[a]);
        }
        *shift = V(select)(go, *shift + step, *shift);
        left &= ~VM(bits)(V(le)(V(max)(V(max)(V(abs)(org[0]), V(abs)(org[1])), V(abs)(org[2])), edge));
    }
    return left | (far & ~(VM(bits)(V(le)(V(abs)(org[0] + org[1] + org[2]), most)) & VM(bits)(V(le)(V(abs)(*shift), most))));
}

/* Of `far`, which start far away, moves the origins; t0, t1: of them, where they are inside the part, from there. Returns those
 * that enter it then (rtk_ray_prepare); the others of them miss it. Of lanes that do not start far away org is theirs, and shift
 * 0. */
RTI_VEC rtk_u32 rays_move(const packet_rays *r, const rtk_part *part, rtk_u32 far, vec org[3], vec *shift, vec *t0, vec *t1)
{
    const float lo[3] = {part->lo.x, part->lo.y, part->lo.z}, hi[3] = {part->hi.x, part->hi.y, part->hi.z};
    const vmask go = VM(of)(far);
    vec to[3], in = V(set)(-RTK_INF), out = V(set)(RTK_INF);
    for (rtk_u32 k = 0u; k < 3u; k++)
        org[k] = r->org[k];
    *shift = V(set)(0.0f);
    if (far == 0u)
        return 0u;
    far &= ~rays_approach(r, part, far, to, shift);
    for (rtk_u32 k = 0u; k < 3u; k++) {
        const vec x = (V(set)(lo[k]) - to[k]) * r->inv[k], y = (V(set)(hi[k]) - to[k]) * r->inv[k];
        in = V(max)(in, V(min)(x, y));
        out = V(min)(out, V(max)(x, y));
        org[k] = V(select)(go, to[k], r->org[k]);
    }
    *shift = V(select)(go, *shift, V(set)(0.0f));
    *t0 = V(select)(go, in, *t0);
    *t1 = V(select)(go, out, *t1);
    far &= VM(bits)(V(le)(in, out)) & ~VM(bits)(V(lt)(*shift + out, r->tmin));
    return far & ~VM(bits)(V(lt)(r->tmax, *shift + in));
}

#endif
