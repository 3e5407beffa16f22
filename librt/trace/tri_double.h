/* The leaf test's second half in doubles, for pairs of a ray and a triangle, many or one. Included by packet.h.
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

/* Of a triangle's plane: a corner, the normal, and of each of its components the sizes of what it is the difference of. */
typedef struct double_plane {
    double at[3], n[3], s[3];
} double_plane;

RTI_VEC double_plane double_plane_of(const float c[3][3])
{
    double_plane p;
    for (rtk_u32 k = 0u; k < 3u; k++) {
        const rtk_u32 y = k == 2u ? 0u : k + 1u, z = y == 2u ? 0u : y + 1u;
        const double ey = (double)c[1][y] - c[0][y], ez = (double)c[1][z] - c[0][z];
        const double fy = (double)c[2][y] - c[0][y], fz = (double)c[2][z] - c[0][z], yz = ey * fz, zy = ez * fy;
        p.at[k] = c[0][k];
        p.n[k] = yz - zy;
        p.s[k] = __builtin_fabs(yz) + __builtin_fabs(zy);
    }
    return p;
}

/* Of `lanes`, which tri_test doubts, decides those that it can: adds what hits to *hit, and returns the others. edges: those of
 * them that start or end on an edge. dx, dy: the directions in the rays' order of axes; v0, v1, v2: the corners in it; c: the same
 * of all lanes, whose plane is then found once (of what this takes a fifth), or NULL. */
RTI_VEC rtk_u32 tri_double(const tri_ray *r, const vec *dx, const vec *dy, const vec v0[3], const vec v1[3], const vec v2[3],
                           const float c[3][3], rtk_u32 lanes, tri_hit *hit, rtk_u32 *edges)
{
    enum { AX, AY, AZ, BX, BY, BZ, CX, CY, CZ, MX, MY, SCALE, OX, OY, OZ, PX, PY, PZ, QX, QY, QZ, RX, RY, RZ, DX, DY, DZ, COUNT };
    enum { B_LOW, B_HIGH, C_LOW, C_HIGH, Z_LOW, Z_HIGH, P_LOW, P_HIGH, KNOWN, RESULTS };
    const vec zero = V(set)(0.0f), one = V(set)(1.0f), slope = V(abs)(r->kdz);
    const vec az = v0[2] - r->oz, bz = v1[2] - r->oz, cz = v2[2] - r->oz;
    const vec ax = (v0[0] - r->ox) - r->sx * az, ay = (v0[1] - r->oy) - r->sy * az;
    const vec bx = (v1[0] - r->ox) - r->sx * bz, by = (v1[1] - r->oy) - r->sy * bz;
    const vec cx = (v2[0] - r->ox) - r->sx * cz, cy = (v2[1] - r->oy) - r->sy * cz;
    const rtk_u32 edge = VM(bits)(V(eq)(cx * by - cy * bx, zero)) | VM(bits)(V(eq)(ax * cy - ay * cx, zero)) |
                         VM(bits)(V(eq)(bx * ay - by * ax, zero));
    const vec mx = V(max)(V(max)(V(abs)(ax), V(abs)(bx)), V(abs)(cx)), my = V(max)(V(max)(V(abs)(ay), V(abs)(by)), V(abs)(cy));
    const rtk_u32 fit = lanes & ~edge & VM(bits)(V(le)(r->scale, V(set)(DOUBLE_SCALE))) &
                        VM(bits)(V(le)(V(set)(DOUBLE_DIR), slope)) & VM(bits)(V(le)(slope, V(set)(1.0f / DOUBLE_DIR)));
    float from[COUNT][RTI_SIMD], to[RESULTS][RTI_SIMD];
    *edges = lanes & edge;
    if (fit == 0u)
        return lanes;
#define IN(k, of) V(store)(from[k], of) /* a loop over an array of them becomes a copy of the array */
    IN(AX, ax), IN(AY, ay), IN(AZ, az), IN(BX, bx), IN(BY, by), IN(BZ, bz), IN(CX, cx), IN(CY, cy), IN(CZ, cz);
    IN(MX, mx), IN(MY, my), IN(SCALE, r->scale), IN(OX, r->ox), IN(OY, r->oy), IN(OZ, r->oz);
    IN(DX, *dx), IN(DY, *dy), IN(DZ, r->kdz);
    double_plane of_all = {{0.0}, {0.0}, {0.0}};
    if (c) {
        of_all = double_plane_of(c);
    } else {
        IN(PX, v0[0]), IN(PY, v0[1]), IN(PZ, v0[2]), IN(QX, v1[0]), IN(QY, v1[1]), IN(QZ, v1[2]);
        IN(RX, v2[0]), IN(RY, v2[1]), IN(RZ, v2[2]);
    }
#undef IN
    for (rtk_u32 at = 0u; at < RTI_SIMD && fit >> at != 0u; at += DOUBLE_N) { /* lanes behind the last hold anything */
        double_half half;
#define X(to, k)                                                                                                                 \
    memcpy(&half, from[k] + at, sizeof half);                                                                                    \
    const double_vec to = __builtin_convertvector(half, double_vec)
#define OUT(k, of)                                                                                                               \
    half = __builtin_convertvector(of, double_half);                                                                             \
    memcpy(to[k] + at, &half, sizeof half)
        X(xa, AX);
        X(ya, AY);
        X(xb, BX);
        X(yb, BY);
        X(xc, CX);
        X(yc, CY);
        X(xm, MX);
        X(ym, MY);
        const double_vec u = xc * yb - yc * xb, v = xa * yc - ya * xc, w = xb * ya - yb * xa, size = xm * ym;
        const double_vec det = u + v + w, inv = 1.0 / det, weight_b = v * inv, weight_c = w * inv;
        double_mask known = (DOUBLE_ABS(det) > DOUBLE_LEAST_DET * size) & (DOUBLE_ABS(v) > DOUBLE_LEAST_WEIGHT * size) &
                            (DOUBLE_ABS(w) > DOUBLE_LEAST_WEIGHT * size);
        OUT(B_LOW, weight_b * (1.0 - DOUBLE_OFF_B));
        OUT(B_HIGH, weight_b * (1.0 + DOUBLE_OFF_B));
        OUT(C_LOW, weight_c * (1.0 - DOUBLE_OFF_B));
        OUT(C_HIGH, weight_c * (1.0 + DOUBLE_OFF_B));
        X(za, AZ);
        X(zb, BZ);
        X(zc, CZ);
        const double_vec along_b = weight_b * (zb - za), along_c = weight_c * (zc - za), z = za + (along_b + along_c);
        const double_vec depth = DOUBLE_ABS(za) + (DOUBLE_ABS(along_b) + DOUBLE_ABS(along_c)), off_z = DOUBLE_OFF_Z * depth;
        known &= depth > DOUBLE_LEAST_DEPTH;
        OUT(Z_LOW, z - off_z);
        OUT(Z_HIGH, z + off_z);
        double_vec px, py, pz, nx, ny, nz, sx, sy, sz;
        if (c) {
#define ALL(of) ((of) - (double_vec){0.0})
            px = ALL(of_all.at[0]), py = ALL(of_all.at[1]), pz = ALL(of_all.at[2]);
            nx = ALL(of_all.n[0]), ny = ALL(of_all.n[1]), nz = ALL(of_all.n[2]);
            sx = ALL(of_all.s[0]), sy = ALL(of_all.s[1]), sz = ALL(of_all.s[2]);
#undef ALL
        } else {
            X(p0, PX);
            X(p1, PY);
            X(p2, PZ);
            X(qx, QX);
            X(qy, QY);
            X(qz, QZ);
            X(rx, RX);
            X(ry, RY);
            X(rz, RZ);
            const double_vec ex = qx - p0, ey = qy - p1, ez = qz - p2, fx = rx - p0, fy = ry - p1, fz = rz - p2;
            const double_vec yz = ey * fz, zy = ez * fy, zx = ez * fx, xz = ex * fz, xy = ex * fy, yx = ey * fx;
            px = p0, py = p1, pz = p2;
            nx = yz - zy, ny = zx - xz, nz = xy - yx;
            sx = DOUBLE_ABS(yz) + DOUBLE_ABS(zy), sy = DOUBLE_ABS(zx) + DOUBLE_ABS(xz), sz = DOUBLE_ABS(xy) + DOUBLE_ABS(yx);
        }
        X(ox, OX);
        X(oy, OY);
        X(oz, OZ);
        const double_vec hx = px - ox, hy = py - oy, hz = pz - oz;
        const double_vec num = nx * hx + ny * hy + nz * hz;
        const double_vec nums = sx * DOUBLE_ABS(hx) + sy * DOUBLE_ABS(hy) + sz * DOUBLE_ABS(hz);
        X(scale, SCALE);
        X(xd, DX);
        X(yd, DY);
        X(zd, DZ);
        const double_vec den = nx * xd + ny * yd + nz * zd;
        const double_vec dens = sx * DOUBLE_ABS(xd) + sy * DOUBLE_ABS(yd) + sz * DOUBLE_ABS(zd);
        const double_vec least = DOUBLE_LEAST_PLANE * scale + DOUBLE_LEAST;
        const double_vec turn = 1.0 / den, p = num * turn, far = DOUBLE_ABS(p);
        const double_vec off_p = DOUBLE_OFF_PLANE * (nums + far * dens) * DOUBLE_ABS(turn) + DOUBLE_OFF_QUOTIENT * far;
        known &= (nums > least) & (dens > DOUBLE_LEAST_PLANE * DOUBLE_ABS(zd) + DOUBLE_LEAST);
        known &= (DOUBLE_ABS(den) > DOUBLE_GRAZES * dens) & (far > DOUBLE_LEAST_QUOTIENT);
        OUT(P_LOW, p - off_p);
        OUT(P_HIGH, p + off_p);
        OUT(KNOWN, (double_vec)((double_mask)(0.0 * size + 1.0) & known));
#undef X
#undef OUT
    }
    const vec wb = V(load)(to[B_LOW]), wc = V(load)(to[C_LOW]), z = V(load)(to[Z_LOW]), p = V(load)(to[P_LOW]), plane = p * r->kdz;
    const vec close = V(set)(RTK_TRI_PLANE) * r->scale; /* as rtk_tri_exact has it */
    const rtk_u32 at_low = VM(bits)(V(le)(V(abs)(plane - z), close));
    const rtk_u32 at_high = VM(bits)(V(le)(V(abs)(plane - V(load)(to[Z_HIGH])), close));
    const rtk_u32 by_plane = at_low & at_high, by_z = ~(at_low | at_high) & VM(bits)(V(eq)(z, V(load)(to[Z_HIGH])));
    const rtk_u32 known = fit & (by_plane | by_z) & VM(bits)(V(lt)(zero, V(load)(to[KNOWN]))) &
                          VM(bits)(V(eq)(wb, V(load)(to[B_HIGH]))) & VM(bits)(V(eq)(wc, V(load)(to[C_HIGH]))) &
                          VM(bits)(V(eq)(p, V(load)(to[P_HIGH])));
    const vec t = r->tshift + V(select)(VM(of)(by_plane), plane, z) / r->kdz;
    const rtk_u32 good = known & VM(bits)(V(lt)(r->tmin, t)) & VM(bits)(V(lt)(t, r->tmax));
    hit->t = V(select)(VM(of)(good), t, hit->t);
    hit->u = V(select)(VM(of)(good), V(min)(wb, one), hit->u);
    hit->v = V(select)(VM(of)(good), V(min)(wc, one), hit->v);
    hit->hit |= good;
    return lanes & ~known;
}

/* The same for a pair by itself, whose numbers had better not go through memory: hit becomes t, u and v. 0: it is to be asked.
 * dx, dy: the direction's components in the ray's order of axes. */
RTI_VEC int tri_double_one(const rti_tri_pair *r, float dx, float dy, const float v0[3], const float v1[3], const float v2[3],
                           float hit[3])
{
    const float slope = rtk_fabs(r->kdz), az = v0[2] - r->oz, bz = v1[2] - r->oz, cz = v2[2] - r->oz;
    const float ax = (v0[0] - r->ox) - r->sx * az, ay = (v0[1] - r->oy) - r->sy * az;
    const float bx = (v1[0] - r->ox) - r->sx * bz, by = (v1[1] - r->oy) - r->sy * bz;
    const float cx = (v2[0] - r->ox) - r->sx * cz, cy = (v2[1] - r->oy) - r->sy * cz;
    const int edge = (cx * by - cy * bx == 0.0f) | (ax * cy - ay * cx == 0.0f) | (bx * ay - by * ax == 0.0f);
    const double size = (double)rtk_max(rtk_max(rtk_fabs(ax), rtk_fabs(bx)), rtk_fabs(cx)) *
                        rtk_max(rtk_max(rtk_fabs(ay), rtk_fabs(by)), rtk_fabs(cy));
    const double u = (double)cx * by - (double)cy * bx, v = (double)ax * cy - (double)ay * cx,
                 w = (double)bx * ay - (double)by * ax;
    const double det = u + v + w, inv = 1.0 / det, b = v * inv, c = w * inv;
    const double along_b = b * ((double)bz - az), along_c = c * ((double)cz - az), z = az + (along_b + along_c);
    const double depth = __builtin_fabs((double)az) + (__builtin_fabs(along_b) + __builtin_fabs(along_c)),
                 off_z = DOUBLE_OFF_Z * depth;
    const double px = v0[0], py = v0[1], pz = v0[2], hx = px - r->ox, hy = py - r->oy, hz = pz - r->oz;
    const double ex = v1[0] - px, ey = v1[1] - py, ez = v1[2] - pz, fx = v2[0] - px, fy = v2[1] - py, fz = v2[2] - pz;
    const double yz = ey * fz, zy = ez * fy, zx = ez * fx, xz = ex * fz, xy = ex * fy, yx = ey * fx;
    const double nx = yz - zy, ny = zx - xz, nz = xy - yx;
    const double sx = __builtin_fabs(yz) + __builtin_fabs(zy), sy = __builtin_fabs(zx) + __builtin_fabs(xz),
                 sz = __builtin_fabs(xy) + __builtin_fabs(yx);
    const double num = nx * hx + ny * hy + nz * hz,
                 nums = sx * __builtin_fabs(hx) + sy * __builtin_fabs(hy) + sz * __builtin_fabs(hz);
    const double den = nx * dx + ny * dy + nz * r->kdz, dens = sx * rtk_fabs(dx) + sy * rtk_fabs(dy) + sz * slope;
    const double turn = 1.0 / den, p = num * turn, far = __builtin_fabs(p);
    const double off_p = DOUBLE_OFF_PLANE * (nums + far * dens) * __builtin_fabs(turn) + DOUBLE_OFF_QUOTIENT * far;
    const float u0 = (float)(b * (1.0 - DOUBLE_OFF_B)), u1 = (float)(b * (1.0 + DOUBLE_OFF_B));
    const float w0 = (float)(c * (1.0 - DOUBLE_OFF_B)), w1 = (float)(c * (1.0 + DOUBLE_OFF_B));
    const float z0 = (float)(z - off_z), z1 = (float)(z + off_z), p0 = (float)(p - off_p), p1 = (float)(p + off_p);
    const float plane = p0 * r->kdz, close = RTK_TRI_PLANE * r->scale; /* as rtk_tri_exact has it */
    const int low = rtk_fabs(plane - z0) <= close, high = rtk_fabs(plane - z1) <= close;
    int known = !edge & (r->scale <= DOUBLE_SCALE) & (DOUBLE_DIR <= slope) & (slope <= 1.0f / DOUBLE_DIR);
    known &= (__builtin_fabs(det) > DOUBLE_LEAST_DET * size) & (__builtin_fabs(v) > DOUBLE_LEAST_WEIGHT * size) &
             (__builtin_fabs(w) > DOUBLE_LEAST_WEIGHT * size) & (depth > DOUBLE_LEAST_DEPTH);
    known &= (nums > DOUBLE_LEAST_PLANE * r->scale + DOUBLE_LEAST) & (dens > DOUBLE_LEAST_PLANE * slope + DOUBLE_LEAST);
    known &= (__builtin_fabs(den) > DOUBLE_GRAZES * dens) & (far > DOUBLE_LEAST_QUOTIENT);
    known &= (u0 == u1) & (w0 == w1) & (p0 == p1) & ((low & high) | (!low & !high & (z0 == z1)));
    hit[0] = r->tshift + (low ? plane : z0) / r->kdz;
    hit[1] = rtk_min(u0, 1.0f);
    hit[2] = rtk_min(w0, 1.0f);
    return known & (r->tmin < hit[0]) & (hit[0] < r->tmax);
}

#endif
