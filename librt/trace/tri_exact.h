/* The leaf test's second half in doubled floats (rtk_tri_exact, and what rtk_tri_intersect does with it) for many pairs of a ray
 * and a triangle: the same operations in the same order, so the same bits. Included by packet.h, whose vectors it takes.
 *
 * Beside a big triangle, a floor on which the camera stands, every ray of a packet is in doubt: one by one that cost a quarter
 * of the time of sponza's primary rays, and half of that of classroom's random ones.
 */
#ifndef RTI_TRI_EXACT_H
#define RTI_TRI_EXACT_H

typedef struct wide_ff {
    vec hi, lo;
} wide_ff;

/* How a product's error is had: by Veltkamp's split, as rtk_two_prod has it, or, where the processor fuses, by one operation. Both
 * are exact, and so the same, while factors are zero or from WIDE_TINY to WIDE_HUGE; what they have been is noted. */
typedef struct wide_way {
    int fused;
#ifdef RTI_PACK
    rti_i16 least, most;
#endif
} wide_way;
#define WIDE_TINY 8.8817842e-16f /* 2^-50 */
#define WIDE_HUGE 1.1529215e18f  /* 2^60 */

static const wide_way wide_split __attribute__((unused)) = {.fused = 0};

/* Factors: of every product each is noted, in any order. */
RTI_VEC void wide_note(wide_way *way, const vec *factors, rtk_u32 n)
{
#ifdef RTI_PACK
    for (rtk_u32 i = 0u; i < n && way->fused; i++) {
        way->least = rti_i16_least(way->least, factors[i]);
        way->most = rti_i16_most(way->most, factors[i]);
    }
#else
    (void)way;
    (void)factors;
    (void)n;
#endif
}

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

RTI_VEC wide_ff wide_two_prod(const wide_way *way, vec a, vec b)
{
    const vec p = a * b;
#ifdef RTI_PACK
    if (way->fused)
        return (wide_ff){p, V(msub)(a, b, p)};
#endif
    (void)way;
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

RTI_VEC wide_ff wide_mul(const wide_way *way, wide_ff a, wide_ff b)
{
    const wide_ff p = wide_two_prod(way, a.hi, b.hi);
    return wide_quick_two_sum(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}

RTI_VEC wide_ff wide_scale(const wide_way *way, wide_ff a, vec b)
{
    const wide_ff p = wide_two_prod(way, a.hi, b);
    return wide_quick_two_sum(p.hi, p.lo + a.lo * b);
}

RTI_VEC vec wide_quotient(wide_way *way, wide_ff a, wide_ff b)
{
    const vec q = a.hi / b.hi;
    wide_note(way, &q, 1u);
    const wide_ff r = wide_add(a, wide_scale(way, b, -q));
    return q + r.hi / b.hi;
}

RTI_VEC wide_ff wide_diff_products(const wide_way *way, vec a, vec b, vec c, vec d)
{
    const wide_ff p = wide_two_prod(way, a, b), q = wide_two_prod(way, c, d);
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
RTI_VEC wide_ff wide_cross(const wide_way *way, wide_ff a, wide_ff b, wide_ff c, wide_ff d)
{
    const wide_ff q = wide_mul(way, c, d);
    return wide_add(wide_mul(way, a, b), (wide_ff){-q.hi, -q.lo});
}

/* rtk_tri_plane_depth. dx, dy: the directions in the rays' order of axes; v0, v1, v2: the corners in it. */
RTI_VEC vec wide_plane_depth(wide_way *way, const tri_ray *r, vec dx, vec dy, const vec v0[3], const vec v1[3], const vec v2[3])
{
    const wide_ff ex = wide_two_diff(v1[0], v0[0]), ey = wide_two_diff(v1[1], v0[1]), ez = wide_two_diff(v1[2], v0[2]);
    const wide_ff fx = wide_two_diff(v2[0], v0[0]), fy = wide_two_diff(v2[1], v0[1]), fz = wide_two_diff(v2[2], v0[2]);
    const wide_ff nx = wide_cross(way, ey, fz, ez, fy), ny = wide_cross(way, ez, fx, ex, fz), nz = wide_cross(way, ex, fy, ey, fx);
    const wide_ff ox = wide_two_diff(v0[0], r->ox), oy = wide_two_diff(v0[1], r->oy), oz = wide_two_diff(v0[2], r->oz);
    const wide_ff num = wide_add(wide_add(wide_mul(way, nx, ox), wide_mul(way, ny, oy)), wide_mul(way, nz, oz));
    const wide_ff den = wide_add(wide_add(wide_scale(way, nx, dx), wide_scale(way, ny, dy)), wide_scale(way, nz, r->kdz));
    const vec factors[] = {ex.hi, ey.hi, ez.hi, fx.hi, fy.hi, fz.hi, nx.hi,  ny.hi,
                           nz.hi, ox.hi, oy.hi, oz.hi, dx,    dy,    r->kdz, den.hi};
    wide_note(way, factors, 16u);
    return wide_quotient(way, num, den) * r->kdz;
}

/* tri_exact in one way; returns 0 where it was not exact, and *hit is as it was. edges: what tri_exact returns. */
RTI_VEC int tri_exact_way(wide_way way, const tri_ray *r, const vec *dx, const vec *dy, const vec v0[3], const vec v1[3],
                          const vec v2[3], rtk_u32 lanes, tri_hit *hit, rtk_u32 *edges)
{
    const vec zero = V(set)(0.0f), one = V(set)(1.0f);
    const vec az = v0[2] - r->oz, bz = v1[2] - r->oz, cz = v2[2] - r->oz;
    vec ax = (v0[0] - r->ox) - r->sx * az, ay = (v0[1] - r->oy) - r->sy * az;
    vec bx = (v1[0] - r->ox) - r->sx * bz, by = (v1[1] - r->oy) - r->sy * bz;
    vec cx = (v2[0] - r->ox) - r->sx * cz, cy = (v2[1] - r->oy) - r->sy * cz;
    const rtk_u32 edge = VM(bits)(V(eq)(cx * by - cy * bx, zero)) | VM(bits)(V(eq)(ax * cy - ay * cx, zero)) |
                         VM(bits)(V(eq)(bx * ay - by * ax, zero));
    const vec kx = wide_normaliser(V(max)(V(max)(V(abs)(ax), V(abs)(bx)), V(abs)(cx)));
    const vec ky = wide_normaliser(V(max)(V(max)(V(abs)(ay), V(abs)(by)), V(abs)(cy)));
    wide_ff u, v, w, det, depth;
    vec z, plane, t;
    rtk_u32 good;
    ax = ax * kx;
    bx = bx * kx;
    cx = cx * kx;
    ay = ay * ky;
    by = by * ky;
    cy = cy * ky;
    u = wide_diff_products(&way, cx, by, cy, bx);
    v = wide_diff_products(&way, ax, cy, ay, cx);
    w = wide_diff_products(&way, bx, ay, by, ax);
    det = wide_add(wide_add(u, v), w);
    const wide_ff bd = wide_two_diff(bz, az), cd = wide_two_diff(cz, az);
    const vec factors[] = {ax, ay, bx, by, cx, cy, v.hi, w.hi, det.hi, az, bd.hi, cd.hi};
    wide_note(&way, factors, 12u);
    depth = wide_add(wide_mul(&way, v, bd), wide_mul(&way, w, cd));
    depth = wide_add(wide_scale(&way, det, az), depth);
    z = wide_quotient(&way, depth, det);
    plane = wide_plane_depth(&way, r, *dx, *dy, v0, v1, v2);
    z = V(select)(V(le)(V(abs)(plane - z), V(set)(1.9073486e-06f) * r->scale), plane, z);
    t = r->tshift + z / r->kdz;
    good = lanes & ~edge & VM(bits)(V(lt)(zero, V(abs)(det.hi))) & VM(bits)(V(lt)(r->tmin, t)) & VM(bits)(V(lt)(t, r->tmax));
    const vec b = V(min)(wide_quotient(&way, v, det), one), c = V(min)(wide_quotient(&way, w, det), one);
#ifdef RTI_PACK
    if (way.fused && (lanes & ~edge & rti_i16_outside(way.least, way.most, WIDE_TINY, WIDE_HUGE)) != 0u)
        return 0;
#endif
    hit->t = V(select)(VM(of)(good), t, hit->t);
    hit->u = V(select)(VM(of)(good), b, hit->u);
    hit->v = V(select)(VM(of)(good), c, hit->v);
    hit->hit |= good;
    *edges = lanes & edge;
    return 1;
}

/* Of `lanes`, which tri_test doubts: adds those that hit to *hit, with what the leaf test gives. Returns those that start or end
 * on an edge, whose sides are told by integers: they must be asked one by one. */
__attribute__((noinline, unused)) static rtk_u32 tri_exact(const tri_ray *r, const vec *dx, const vec *dy, const vec v0[3],
                                                           const vec v1[3], const vec v2[3], rtk_u32 lanes, tri_hit *hit)
{
    rtk_u32 edges = 0u;
    wide_way way;
#ifdef RTI_PACK
    way.least = rti_i16_none();
    way.most = rti_i16_zero();
    way.fused = 1;
    if (tri_exact_way(way, r, dx, dy, v0, v1, v2, lanes, hit, &edges))
        return edges;
#endif
    way.fused = 0;
    tri_exact_way(way, r, dx, dy, v0, v1, v2, lanes, hit, &edges);
    return edges;
}

#endif
