/* Rays and spheres in RTI_N lanes: what rtk_sphere_roots does and who calls it, the same operations in the same order, so the same
 * bits. Included by shape_lanes.h.
 *
 * A lane is one pair of a ray and a sphere: one ray and many spheres, or many rays and one.
 */
#define F(op)   LANES_JOIN(rti_f, RTI_N, op)
#define M(op)   LANES_JOIN(rti_m, RTI_N, op)
#define VEC     LANES_TYPE(rti_f, RTI_N)
#define RAY     LANES_TYPE(rti_ball_ray, RTI_N)
#define RAYS    LANES_TYPE(rti_ball_rays, RTI_N)
#define READY   LANES_TYPE(rti_ball_ready, RTI_N)
#define TEST    LANES_TYPE(rti_ball, RTI_N)
#define LOCAL   LANES_TYPE(rti_ball_local, RTI_N)
#define NEAR    LANES_TYPE(rti_ball_near, RTI_N)

/* Of the prepared ray; unit, dd, len: rti_ball_ready. margin: RTK_BALL_MARGIN * scale. */
typedef struct RAY {
    VEC org[3], dir[3], tmin, tmax, tshift, margin, unit[3], dd, len;
} RAY;

/* Rays that are not ready: field by field, for an initializer would clear the others, too, which takes as long as a sphere. */
RTI_VEC void RAYS(RAY *r, const VEC org[3], const VEC dir[3], VEC tmin, VEC tmax, VEC tshift, VEC margin)
{
    for (uint32_t k = 0; k < 3; k++) {
        r->org[k] = org[k];
        r->dir[k] = dir[k];
    }
    r->tmin = tmin;
    r->tmax = tmax;
    r->tshift = tshift;
    r->margin = margin;
}

RTI_VEC void READY(RAY *r)
{
    r->dd = r->dir[0] * r->dir[0] + r->dir[1] * r->dir[1] + r->dir[2] * r->dir[2];
    r->len = F(sqrt)(r->dd);
    for (uint32_t k = 0; k < 3; k++)
        r->unit[k] = r->dir[k] / r->len;
}

/* rtk_local_at */
RTI_VEC VEC LOCAL(VEC org, VEC anchor, VEC t, VEC d)
{
    const VEC f = org - anchor, fb = f - org, fe = (org - (f - fb)) - (anchor + fb);
    const VEC p = t * d, ct = F(set)(4097.0f) * t, cd = F(set)(4097.0f) * d;
    const VEC th = ct - (ct - t), dh = cd - (cd - d), tl = t - th, dl = d - dh;
    const VEC pe = ((th * dh - p) + th * dl + tl * dh) + tl * dl;
    const VEC s = f + p, sb = s - f, se = (f - (s - sb)) + (p - sb);
    return s + (se + (fe + pe));
}

/* Of `lanes` those whose rays may meet what is in a ball, between tmin and `far`: by margins as rtk_sphere_passed has them. Roots
 * lie in their shape's box grown by 67 u scale, a margin and a bit, along each axis: they are brought there (rtk_roots_in_box). */
RTI_VEC uint32_t NEAR(const RAY *r, const VEC middle[3], VEC radius, VEC far, uint32_t lanes)
{
    const VEC reach = radius + F(set)(3.0f) * r->margin;
    const VEC f[3] = {r->org[0] - middle[0], r->org[1] - middle[1], r->org[2] - middle[2]};
    const VEC t = -(f[0] * r->dir[0] + f[1] * r->dir[1] + f[2] * r->dir[2]) / r->dd;
    const VEC p[3] = {f[0] + t * r->dir[0], f[1] + t * r->dir[1], f[2] + t * r->dir[2]};
    lanes &= M(bits)(F(le)(p[0] * p[0] + p[1] * p[1] + p[2] * p[2], reach * reach));
    if (lanes == 0u)
        return 0u;
    const VEC ahead = r->tshift + t;
    const VEC around = F(set)(1.01f) * reach / r->len + F(set)(1.0e-5f) * (F(abs)(t) + F(abs)(ahead));
    return lanes & ~M(bits)(F(lt)(ahead + around, r->tmin)) & ~M(bits)(F(lt)(far, ahead - around));
}

/* Of `lanes` those that hit, and where first, in (tmin, tmax). Hits behind `far` need not be told. */
RTI_VEC uint32_t TEST(const RAY *r, const VEC middle[3], VEC radius, VEC far, uint32_t lanes, VEC *out)
{
    const VEC zero = F(set)(0.0f), reach = radius + r->margin;
    const VEC f[3] = {r->org[0] - middle[0], r->org[1] - middle[1], r->org[2] - middle[2]};
    const VEC t = -(f[0] * r->dir[0] + f[1] * r->dir[1] + f[2] * r->dir[2]) / r->dd;
    const VEC p[3] = {f[0] + t * r->dir[0], f[1] + t * r->dir[1], f[2] + t * r->dir[2]};
    lanes &= M(bits)(F(le)(p[0] * p[0] + p[1] * p[1] + p[2] * p[2], reach * reach));
    if (lanes == 0u)
        return 0u;
    /* Rays that start outside, by more than rounding can hide, and go away from the middle: as those that start on the sphere and
     * leave it. With u = 2^-24, and R for reach, |f|^2 - radius^2 is more than 112 u R^2; by that the half chord's square falls
     * short of the square of the way back to the middle. Roundings change the former by 36 u R^2 and either's way by 37 u R, so
     * both roots found are at most tshift. The last summand stands for squares that underflow; dd does not (RTK_DIR_MIN). */
    const VEC least = radius * radius + (F(set)(7.6293945e-06f) * (reach * reach) + F(set)(1.0e-36f));
    lanes &= ~(M(bits)(F(le)(t, zero)) & M(bits)(F(lt)(least, f[0] * f[0] + f[1] * f[1] + f[2] * f[2])) &
               M(bits)(F(le)(r->tshift, r->tmin)));
    if (lanes == 0u)
        return 0u;
    /* Behind the range, or in front of it, by margins as rtk_sphere_passed has them. */
    const VEC ahead = r->tshift + t;
    const VEC around = F(set)(1.01f) * reach / r->len + F(set)(1.0e-5f) * (F(abs)(t) + F(abs)(ahead));
    lanes &= ~M(bits)(F(lt)(ahead + around, r->tmin)) & ~M(bits)(F(lt)(far, ahead - around));
    if (lanes == 0u)
        return 0u;
    const VEC o[3] = {LOCAL(r->org[0], middle[0], t, r->dir[0]), LOCAL(r->org[1], middle[1], t, r->dir[1]),
                      LOCAL(r->org[2], middle[2], t, r->dir[2])};
    const VEC b = -(o[0] * r->unit[0] + o[1] * r->unit[1] + o[2] * r->unit[2]);
    const VEC foot[3] = {o[0] + b * r->unit[0], o[1] + b * r->unit[1], o[2] + b * r->unit[2]};
    const VEC m = F(sqrt)(foot[0] * foot[0] + foot[1] * foot[1] + foot[2] * foot[2]);
    const VEC disc = (radius - m) * (radius + m), h = F(sqrt)(disc);
    const VEC first = r->tshift + (t + (b - h) / r->len), second = r->tshift + (t + (b + h) / r->len);
    const uint32_t one = M(bits)(F(lt)(r->tmin, first)) & M(bits)(F(lt)(first, r->tmax));
    const uint32_t two = M(bits)(F(lt)(r->tmin, second)) & M(bits)(F(lt)(second, r->tmax));
    *out = F(select)(M(of)(one), first, second);
    return lanes & M(bits)(F(le)(zero, disc)) & (one | two);
}

#undef F
#undef M
#undef VEC
#undef RAY
#undef RAYS
#undef READY
#undef TEST
#undef LOCAL
#undef NEAR
