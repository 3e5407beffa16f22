/* The leaf test's second half in doubled floats (rtk_tri_exact, and what rtk_tri_intersect does with it) for many pairs of a ray
 * and a triangle: the same operations in the same order, so the same bits. Included by packet.h, whose vectors it takes.
 *
 * Beside a big triangle, a floor on which the camera stands, every ray of a packet is in doubt: one by one that cost a quarter
 * of the time of sponza's primary rays, and half of that of classroom's random ones. Nearly all are decided in doubles
 * (tri_double.h), which took another 2% of those and 6% of these.
 */
#ifndef RTI_TRI_EXACT_H
#define RTI_TRI_EXACT_H

typedef struct wide_ff {
    vec hi, lo;
} wide_ff;

RTI_VEC wide_ff wide_two_sum(vec a, vec b)
{
    const vec s = a + b, bb = s - a;
    return (wide_ff){s, (a - (s - bb)) + (b - bb)};
}

RTI_VEC wide_ff wide_two_diff(vec a, vec b)
{
    const vec s = a - b, bb = s - a;
    return (wide_ff){s, (a - (s - bb)) - (b + bb)};
}

RTI_VEC wide_ff wide_quick_two_sum(vec a, vec b)
{
    const vec s = a + b;
    return (wide_ff){s, b - (s - a)};
}

RTI_VEC wide_ff wide_two_prod(vec a, vec b)
{
    const vec p = a * b;
    const vec ca = V(set)(4097.0f) * a, cb = V(set)(4097.0f) * b;
    const vec ah = ca - (ca - a), bh = cb - (cb - b), al = a - ah, bl = b - bh;
    return (wide_ff){p, ((ah * bh - p) + ah * bl + al * bh) + al * bl};
}

RTI_VEC wide_ff wide_add(wide_ff a, wide_ff b)
{
    wide_ff s = wide_two_sum(a.hi, b.hi), t = wide_two_sum(a.lo, b.lo);
    s = wide_two_sum(s.hi, s.lo + t.hi);
    return wide_quick_two_sum(s.hi, s.lo + t.lo);
}

RTI_VEC wide_ff wide_mul(wide_ff a, wide_ff b)
{
    const wide_ff p = wide_two_prod(a.hi, b.hi);
    return wide_quick_two_sum(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}

RTI_VEC wide_ff wide_scale(wide_ff a, vec b)
{
    const wide_ff p = wide_two_prod(a.hi, b);
    return wide_quick_two_sum(p.hi, p.lo + a.lo * b);
}

RTI_VEC vec wide_quotient(wide_ff a, wide_ff b)
{
    const vec q = a.hi / b.hi;
    const wide_ff r = wide_add(a, wide_scale(b, -q));
    return q + r.hi / b.hi;
}

RTI_VEC wide_ff wide_diff_products(vec a, vec b, vec c, vec d)
{
    const wide_ff p = wide_two_prod(a, b), q = wide_two_prod(c, d);
    const wide_ff s = wide_two_diff(p.hi, q.hi), e = wide_two_diff(p.lo, q.lo), h = wide_two_sum(s.hi, e.hi);
    return wide_two_sum(h.hi, h.lo + (s.lo + e.lo));
}

/* rtk_normaliser, of what is not negative. */
RTI_VEC vec wide_normaliser(vec most)
{
    vec_whole e, cap;
    memcpy(&e, &most, sizeof e);
    e >>= 23;
    cap = e > 251;
    e = (252 - ((e & ~cap) | (251 & cap))) << 23;
    memcpy(&most, &e, sizeof most);
    return most;
}

/* rtk_ff_cross: a b - c d. */
RTI_VEC wide_ff wide_cross(wide_ff a, wide_ff b, wide_ff c, wide_ff d)
{
    const wide_ff q = wide_mul(c, d);
    return wide_add(wide_mul(a, b), (wide_ff){-q.hi, -q.lo});
}

/* rtk_tri_plane_depth. dx, dy: the directions in the rays' order of axes; v0, v1, v2: the corners in it. */
RTI_VEC vec wide_plane_depth(const tri_ray *r, vec dx, vec dy, const vec v0[3], const vec v1[3], const vec v2[3])
{
    const wide_ff ex = wide_two_diff(v1[0], v0[0]), ey = wide_two_diff(v1[1], v0[1]), ez = wide_two_diff(v1[2], v0[2]);
    const wide_ff fx = wide_two_diff(v2[0], v0[0]), fy = wide_two_diff(v2[1], v0[1]), fz = wide_two_diff(v2[2], v0[2]);
    const wide_ff nx = wide_cross(ey, fz, ez, fy), ny = wide_cross(ez, fx, ex, fz), nz = wide_cross(ex, fy, ey, fx);
    const wide_ff ox = wide_two_diff(v0[0], r->ox), oy = wide_two_diff(v0[1], r->oy), oz = wide_two_diff(v0[2], r->oz);
    const wide_ff num = wide_add(wide_add(wide_mul(nx, ox), wide_mul(ny, oy)), wide_mul(nz, oz));
    const wide_ff den = wide_add(wide_add(wide_scale(nx, dx), wide_scale(ny, dy)), wide_scale(nz, r->kdz));
    return wide_quotient(num, den) * r->kdz;
}

/* tri_exact in doubled floats; lanes are on no edge. */
RTI_VEC void tri_wide(const tri_ray *r, const vec *dx, const vec *dy, const vec v0[3], const vec v1[3], const vec v2[3],
                      rtk_u32 lanes, tri_hit *hit)
{
    const vec zero = V(set)(0.0f), one = V(set)(1.0f), more = V(set)(RTK_TRI_MORE);
    const vec az = v0[2] - r->oz, bz = v1[2] - r->oz, cz = v2[2] - r->oz;
    vec ax = (v0[0] - r->ox) - r->sx * az, ay = (v0[1] - r->oy) - r->sy * az;
    vec bx = (v1[0] - r->ox) - r->sx * bz, by = (v1[1] - r->oy) - r->sy * bz;
    vec cx = (v2[0] - r->ox) - r->sx * cz, cy = (v2[1] - r->oy) - r->sy * cz;
    const vec kx = wide_normaliser(V(max)(V(max)(V(abs)(ax), V(abs)(bx)), V(abs)(cx)));
    const vec ky = wide_normaliser(V(max)(V(max)(V(abs)(ay), V(abs)(by)), V(abs)(cy)));
    wide_ff u, v, w, det, depth;
    vec z, plane, t;
    rtk_u32 good;
    ax = ax * more * kx;
    bx = bx * more * kx;
    cx = cx * more * kx;
    ay = ay * more * ky;
    by = by * more * ky;
    cy = cy * more * ky;
    u = wide_diff_products(cx, by, cy, bx);
    v = wide_diff_products(ax, cy, ay, cx);
    w = wide_diff_products(bx, ay, by, ax);
    det = wide_add(wide_add(u, v), w);
    const wide_ff bd = wide_two_diff(bz, az), cd = wide_two_diff(cz, az);
    depth = wide_add(wide_mul(v, bd), wide_mul(w, cd));
    depth = wide_add(wide_scale(det, az), depth);
    z = wide_quotient(depth, det);
    plane = wide_plane_depth(r, *dx, *dy, v0, v1, v2);
    z = V(select)(V(le)(V(abs)(plane - z), V(set)(RTK_TRI_PLANE) * r->scale), plane, z);
    t = r->tshift + z / r->kdz;
    good = lanes & VM(bits)(V(lt)(zero, V(abs)(det.hi))) & VM(bits)(V(lt)(r->tmin, t)) & VM(bits)(V(lt)(t, r->tmax));
    const vec b = V(min)(wide_quotient(v, det), one), c = V(min)(wide_quotient(w, det), one);
    hit->t = V(select)(VM(of)(good), t, hit->t);
    hit->u = V(select)(VM(of)(good), b, hit->u);
    hit->v = V(select)(VM(of)(good), c, hit->v);
    hit->hit |= good;
}

/* Of `lanes`, which tri_test doubts: adds those that hit to *hit, with what the leaf test gives. Returns those that start or end
 * on an edge, whose sides are told by integers: they must be asked one by one. */
__attribute__((noinline, unused)) static rtk_u32 tri_exact(const tri_ray *r, const vec *dx, const vec *dy, const vec v0[3],
                                                           const vec v1[3], const vec v2[3], rtk_u32 lanes, tri_hit *hit)
{
    rtk_u32 edges = 0u;
    lanes = tri_double(r, dx, dy, v0, v1, v2, NULL, lanes, hit, &edges) & ~edges;
    if (__builtin_expect(lanes != 0u, 0))
        tri_wide(r, dx, dy, v0, v1, v2, lanes, hit);
    return edges;
}

/* The same of one triangle. c: its corners in the rays' order of axes. */
__attribute__((noinline, unused)) static rtk_u32 tri_exact_one(const tri_ray *r, const vec *dx, const vec *dy, const float c[3][3],
                                                               rtk_u32 lanes, tri_hit *hit)
{
    const vec v0[3] = {V(set)(c[0][0]), V(set)(c[0][1]), V(set)(c[0][2])};
    const vec v1[3] = {V(set)(c[1][0]), V(set)(c[1][1]), V(set)(c[1][2])};
    const vec v2[3] = {V(set)(c[2][0]), V(set)(c[2][1]), V(set)(c[2][2])};
    rtk_u32 edges = 0u;
    lanes = tri_double(r, dx, dy, v0, v1, v2, c, lanes, hit, &edges) & ~edges;
    if (__builtin_expect(lanes != 0u, 0))
        tri_wide(r, dx, dy, v0, v1, v2, lanes, hit);
    return edges;
}

#endif
