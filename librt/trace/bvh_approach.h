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

#endif
