/* Rays and boxes, capped cylinders or cones in RTI_N lanes: what rtk_box_roots, rtk_cone_roots, rtk_shape_bounds, rtk_roots_in_box
 * and rtk_shape_roots do, the same operations in the same order, so the same bits. Included by shape_lanes.h.
 *
 * A lane is one pair of a ray and a shape: one ray and many shapes, or many rays and one. All of a cone is found here from its two
 * ends: the first steps, which let most lanes go, ask for its length alone.
 */
#define F(op)   LANES_JOIN(rti_f, RTI_N, op)
#define M(op)   LANES_JOIN(rti_m, RTI_N, op)
#define VEC     LANES_TYPE(rti_f, RTI_N)
#define RAY     LANES_TYPE(rti_ball_ray, RTI_N)
#define LOCAL   LANES_TYPE(rti_ball_local, RTI_N)
#define BITS    LANES_TYPE(rti_shape_bits, RTI_N)
#define DOT     LANES_TYPE(rti_shape_dot, RTI_N)
#define SIGNED  LANES_TYPE(rti_shape_signed, RTI_N)
#define SEEN    LANES_TYPE(rti_cone_seen, RTI_N)
#define POLISH  LANES_TYPE(rti_cone_polish, RTI_N)
#define SIDE    LANES_TYPE(rti_cone_side, RTI_N)
#define IN_BOX  LANES_TYPE(rti_cone_in_box, RTI_N)
#define CONE    LANES_TYPE(rti_cone, RTI_N)
#define TEST    LANES_TYPE(rti_cone_test, RTI_N)
#define FIRST   LANES_TYPE(rti_shape_first, RTI_N)
#define BOX     LANES_TYPE(rti_box_test, RTI_N)

typedef uint32_t BITS __attribute__((vector_size(RTI_N * sizeof(uint32_t))));

/* Ends and their radii; of a cylinder the same. */
typedef struct CONE {
    VEC end[2][3], radius[2];
} CONE;

/* Lanes of which the first of two roots is in the range, or else the second, bits each; where. */
RTI_VEC uint32_t FIRST(const RAY *r, VEC first, VEC second, uint32_t of_first, uint32_t of_second, VEC *out)
{
    first = r->tshift + first;
    second = r->tshift + second;
    of_first &= M(bits)(F(lt)(r->tmin, first)) & M(bits)(F(lt)(first, r->tmax));
    of_second &= M(bits)(F(lt)(r->tmin, second)) & M(bits)(F(lt)(second, r->tmax));
    *out = F(select)(M(of)(of_first), first, second);
    return of_first | of_second;
}

/* Of `lanes` those that hit a box, and where first. inv: rtk_inverse of the direction. The ray need not be ready. */
RTI_VEC uint32_t BOX(const RAY *r, const VEC inv[3], const VEC lo[3], const VEC hi[3], uint32_t lanes, VEC *out)
{
    VEC t0 = F(set)(-RTK_INF), t1 = F(set)(RTK_INF);
    for (uint32_t k = 0; k < 3; k++) {
        const VEC a = (lo[k] - r->org[k]) * inv[k], b = (hi[k] - r->org[k]) * inv[k];
        t0 = F(max)(t0, F(min)(a, b));
        t1 = F(min)(t1, F(max)(a, b));
    }
    lanes &= M(bits)(F(le)(t0, t1));
    return FIRST(r, t0, t1, lanes, lanes, out);
}

/* ---- cones ---- */

RTI_VEC VEC DOT(const VEC a[3], const VEC b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* rtk_copysign */
RTI_VEC VEC SIGNED(VEC size, VEC sign)
{
    BITS a, b;
    memcpy(&a, &size, sizeof a);
    memcpy(&b, &sign, sizeof b);
    a = (a & 0x7fffffffu) | (b & 0x80000000u);
    memcpy(&size, &a, sizeof a);
    return size;
}

/* rtk_cone_ray */
typedef struct SEEN {
    VEC p[3], w[3], r, k;
} SEEN;

/* rtk_cone_polish, of what is finite. */
RTI_VEC VEC POLISH(const SEEN *c, VEC s)
{
    const VEC q[3] = {c->p[0] + s * c->w[0], c->p[1] + s * c->w[1], c->p[2] + s * c->w[2]};
    const VEC m = F(sqrt)(DOT(q, q)), slope = DOT(q, c->w) / m - c->k, step = (m - (c->r + s * c->k)) / slope;
    const uint32_t better = M(bits)(F(lt)(F(set)(0.0f), m)) & M(bits)(F(lt)(F(set)(1.0e-4f), F(abs)(slope))) &
                            M(bits)(F(lt)(F(abs)(step), F(set)(0.125f) * m)) & M(bits)(F(lt)(F(abs)(s), F(set)(RTK_INF)));
    return F(select)(M(of)(better), s - step, s);
}

/* rtk_cone_side; returns the lanes that it leaves empty. */
RTI_VEC uint32_t SIDE(const SEEN *c, VEC *s0, VEC *s1)
{
    const VEC zero = F(set)(0.0f), inf = F(set)(RTK_INF), k = c->k;
    const VEC ww = DOT(c->w, c->w), pw = DOT(c->p, c->w), a = ww - k * k, m = F(sqrt)(DOT(c->p, c->p)), back = -pw / ww;
    const VEC near[3] = {c->p[0] + back * c->w[0], c->p[1] + back * c->w[1], c->p[2] + back * c->w[2]};
    const VEC l = F(sqrt)(DOT(near, near)), r = c->r + back * k, kl = k * l, round = ww * ((r - l) * (r + l));
    const uint32_t up = M(bits)(F(le)(zero, a)), wide = M(bits)(F(lt)(F(set)(4.0f) * (k * k), ww));
    const uint32_t level = wide & M(bits)(F(eq)(k, zero));
    const uint32_t thin = wide & ~level & M(bits)(F(lt)(F(set)(8.0f) * F(abs)(r), m));
    VEC b = pw - c->r * k, cc = (m - c->r) * (m + c->r), disc = b * b - a * cc;
    disc = F(select)(M(of)(level), round, F(select)(M(of)(thin), round + kl * kl, disc));
    b = F(select)(M(of)(thin), -(r * k), b);
    cc = F(select)(M(of)(thin), (l - r) * (l + r), cc);
    const VEC at = F(select)(M(of)(thin), back, zero);
    const uint32_t flat = M(bits)(F(eq)(a, zero)) & M(bits)(F(eq)(b, zero));
    const uint32_t none = (flat & M(bits)(F(lt)(zero, cc))) | (~flat & up & M(bits)(F(lt)(disc, zero)));
    const VEC q = -(b + SIGNED(F(sqrt)(F(max)(disc, zero)), b)), x = q / a, y = F(select)(F(eq)(q, zero), x, cc / q);
    const VEC low = F(min)(x, y), high = F(max)(x, y);
    const uint32_t grows = M(bits)(F(lt)(zero, k)) & ~up;
    *s0 = F(select)(M(of)(up), at + low, F(select)(M(of)(grows), high, -inf));
    *s1 = F(select)(M(of)(up), at + high, F(select)(M(of)(grows), inf, low));
    *s0 = F(select)(M(of)(flat), -inf, POLISH(c, *s0));
    *s1 = F(select)(M(of)(flat), inf, POLISH(c, *s1));
    return none;
}

/* rtk_roots_in_box, in the box of a cone (rtk_shape_bounds): where each root is brought. stay: of `lanes` those where it does. */
RTI_VEC void IN_BOX(const RAY *r, const VEC inv[3], const CONE *cone, const VEC axis[3], uint32_t lanes, VEC t[2], uint32_t stay[2])
{
    const VEC grow = F(set)(0.5f) * r->margin, little = F(set)(2.4e-7f), four = F(set)(4.0f);
    VEC t0 = F(set)(-RTK_INF), t1 = F(set)(RTK_INF);
    for (uint32_t k = 0; k < 3; k++) {
        const VEC n = axis[k == 0 ? 1 : 0], o = axis[k == 2 ? 1 : 2], disc = F(sqrt)(n * n + o * o);
        const VEC ea = cone->radius[0] * disc, eb = cone->radius[1] * disc, a = cone->end[0][k], b = cone->end[1][k];
        const VEC sa = little * (F(abs)(a) + four * ea), sb = little * (F(abs)(b) + four * eb);
        const VEC lo = F(min)((a - ea) - sa, (b - eb) - sb) - grow, hi = F(max)((a + ea) + sa, (b + eb) + sb) + grow;
        const VEC x = (lo - r->org[k]) * inv[k], y = (hi - r->org[k]) * inv[k];
        t0 = F(max)(t0, F(min)(x, y));
        t1 = F(min)(t1, F(max)(x, y));
    }
    const VEC longest = F(max)(F(max)(F(abs)(r->dir[0]), F(abs)(r->dir[1])), F(abs)(r->dir[2]));
    lanes &= M(bits)(F(le)(t0, t1));
    for (uint32_t k = 0; k < 2; k++) {
        const VEC c = F(min)(F(max)(t[k], t0), t1);
        stay[k] = lanes & M(bits)(F(le)(F(abs)(c - t[k]) * longest, four * grow));
        t[k] = c;
    }
}

/* As BOX, a cone, of a ray that is ready. Hits behind `far` need not be told. ask: of `lanes` those that are to be asked one by
 * one. */
RTI_VEC uint32_t TEST(const RAY *r, const VEC inv[3], const CONE *cone, VEC far, uint32_t lanes, VEC *out, uint32_t *ask)
{
    const VEC zero = F(set)(0.0f), half = F(set)(0.5f);
    VEC a[3], f[3], p[3], scaled[3], axis[3];
    for (uint32_t k = 0; k < 3; k++) {
        a[k] = cone->end[1][k] - cone->end[0][k];
        f[k] = r->org[k] - (half * cone->end[0][k] + half * cone->end[1][k]);
    }
    const VEC m = F(max)(F(max)(F(abs)(a[0]), F(abs)(a[1])), F(abs)(a[2]));
    for (uint32_t k = 0; k < 3; k++)
        scaled[k] = a[k] / m;
    const VEC height = m * F(sqrt)(DOT(scaled, scaled)), widest = F(max)(cone->radius[0], cone->radius[1]);
    const VEC reach = (half * height + widest) + r->margin, t = -DOT(f, r->dir) / r->dd;
    for (uint32_t k = 0; k < 3; k++)
        p[k] = f[k] + t * r->dir[k];
    /* Of no length, or too long: rtk_unit has other ways. */
    *ask = lanes & ~(M(bits)(F(le)(F(set)(1.0e-15f), m)) & M(bits)(F(le)(m, F(set)(1.0e15f))));
    lanes &= ~*ask & M(bits)(F(le)(DOT(p, p), reach * reach));
    /* Behind the range, or in front of it, by margins as rtk_sphere_passed has them: of a ball around the box where roots stay. */
    const VEC ahead = r->tshift + t, whole = reach + F(set)(0.4143f) * widest + F(set)(2.0f) * r->margin;
    const VEC around = F(set)(1.01f) * whole / r->len + F(set)(1.0e-5f) * (F(abs)(t) + F(abs)(ahead));
    lanes &= ~M(bits)(F(lt)(ahead + around, r->tmin)) & ~M(bits)(F(lt)(far, ahead - around));
    if (lanes == 0u)
        return 0u;
    /* Of cylinders: farther from the axis, which is taken to go on, than the radius: |p n| / |n|, with n across both. Roundings
     * move n by 8 u, so p n by some 16 u of reach, and p by less than the margin; a root's own error is less than that, too. (Of
     * cones that are flat, or go along the ray, a root is not so good before it is brought into the box.) */
    const VEC n[3] = {r->unit[1] * scaled[2] - r->unit[2] * scaled[1], r->unit[2] * scaled[0] - r->unit[0] * scaled[2],
                      r->unit[0] * scaled[1] - r->unit[1] * scaled[0]};
    const VEC apart = F(abs)(DOT(p, n)) - F(set)(4.0e-6f) * reach, wide = widest + r->margin;
    lanes &= ~(M(bits)(F(lt)(F(set)(1.0001f) * (wide * wide) * DOT(n, n), apart * apart)) & M(bits)(F(lt)(zero, apart)) &
               M(bits)(F(lt)(reach, F(set)(1.0e18f))) & M(bits)(F(eq)(cone->radius[0], cone->radius[1])));
    if (lanes == 0u)
        return 0u;
    const VEC length = F(sqrt)(DOT(a, a));
    for (uint32_t k = 0; k < 3; k++)
        axis[k] = a[k] / length;
    const VEC o[3] = {LOCAL(r->org[0], cone->end[0][0], t, r->dir[0]), LOCAL(r->org[1], cone->end[0][1], t, r->dir[1]),
                      LOCAL(r->org[2], cone->end[0][2], t, r->dir[2])};
    const VEC k = (cone->radius[1] - cone->radius[0]) / height, z = DOT(o, axis), dz = DOT(r->unit, axis);
    const SEEN seen = {{o[0] - z * axis[0], o[1] - z * axis[1], o[2] - z * axis[2]},
                       {r->unit[0] - dz * axis[0], r->unit[1] - dz * axis[1], r->unit[2] - dz * axis[2]},
                       cone->radius[0] + k * z,
                       k * dz};
    VEC s[2];
    uint32_t stay[2];
    lanes &= ~SIDE(&seen, &s[0], &s[1]);
    const VEC most = F(set)(RTK_INV_MAX), by = F(min)(F(max)(F(set)(1.0f) / dz, -most), most); /* rtk_inverse */
    const VEC along = F(select)(F(lt)(F(abs)(dz), F(set)(1.0e-30f)), SIGNED(most, dz), by);
    const VEC low = (zero - z) * along, high = (height - z) * along;
    s[0] = F(max)(s[0], F(min)(low, high));
    s[1] = F(min)(s[1], F(max)(low, high));
    lanes &= M(bits)(F(le)(s[0], s[1]));
    if (lanes == 0u)
        return 0u;
    for (uint32_t i = 0; i < 2; i++)
        s[i] = t + s[i] / r->len;
    IN_BOX(r, inv, cone, axis, lanes, s, stay);
    return FIRST(r, s[0], s[1], stay[0], stay[1], out);
}

#undef F
#undef M
#undef VEC
#undef RAY
#undef LOCAL
#undef BITS
#undef DOT
#undef SIGNED
#undef SEEN
#undef POLISH
#undef SIDE
#undef IN_BOX
#undef CONE
#undef TEST
#undef FIRST
#undef BOX
