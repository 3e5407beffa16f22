/* The leaf test's second half in doubles for RTI_N lanes, DOUBLE_WIDTH doubles at a time. Included by tri_double.h, where its
 * proof stands. */
#define F(op)   LANES_JOIN(rti_f, RTI_N, op)
#define M(op)   LANES_JOIN(rti_m, RTI_N, op)
#define VEC     LANES_TYPE(rti_f, RTI_N)
#define RAY     LANES_TYPE(rti_tri_ray, RTI_N)
#define HIT     LANES_TYPE(rti_tri_hit, RTI_N)
#define TEST    LANES_TYPE(tri_pairs, RTI_N)
#define DVEC    LANES_TYPE(double_vec, RTI_N)
#define DMASK   LANES_TYPE(double_mask, RTI_N)
#define DHALF   LANES_TYPE(double_half, RTI_N)
#define DABS(a) ((DVEC)((DMASK)(a)&INT64_MAX))

typedef double DVEC __attribute__((vector_size(DOUBLE_WIDTH * sizeof(double))));
typedef int64_t DMASK __attribute__((vector_size(DOUBLE_WIDTH * sizeof(double))));
typedef float DHALF __attribute__((vector_size(DOUBLE_WIDTH * sizeof(float))));

/* Of `lanes`, which tri_test doubts, decides those that it can: adds what hits to *hit, and returns the others. edges: those of
 * them that start or end on an edge. dx, dy: the directions in the rays' order of axes; v0, v1, v2: the corners in it. */
RTI_VEC rtk_u32 TEST(const RAY *r, const VEC *dx, const VEC *dy, const VEC v0[3], const VEC v1[3], const VEC v2[3], rtk_u32 lanes,
                     HIT *hit, rtk_u32 *edges)
{
    enum { AX, AY, AZ, BX, BY, BZ, CX, CY, CZ, MX, MY, SCALE, OX, OY, OZ, PX, PY, PZ, QX, QY, QZ, RX, RY, RZ, DX, DY, DZ, COUNT };
    enum { B_LOW, B_HIGH, C_LOW, C_HIGH, Z_LOW, Z_HIGH, P_LOW, P_HIGH, KNOWN, RESULTS };
    const VEC zero = F(set)(0.0f), one = F(set)(1.0f), slope = F(abs)(r->kdz);
    const VEC az = v0[2] - r->oz, bz = v1[2] - r->oz, cz = v2[2] - r->oz;
    const VEC ax = (v0[0] - r->ox) - r->sx * az, ay = (v0[1] - r->oy) - r->sy * az;
    const VEC bx = (v1[0] - r->ox) - r->sx * bz, by = (v1[1] - r->oy) - r->sy * bz;
    const VEC cx = (v2[0] - r->ox) - r->sx * cz, cy = (v2[1] - r->oy) - r->sy * cz;
    const rtk_u32 edge = M(bits)(F(eq)(cx * by - cy * bx, zero)) | M(bits)(F(eq)(ax * cy - ay * cx, zero)) |
                         M(bits)(F(eq)(bx * ay - by * ax, zero));
    const VEC mx = F(max)(F(max)(F(abs)(ax), F(abs)(bx)), F(abs)(cx)), my = F(max)(F(max)(F(abs)(ay), F(abs)(by)), F(abs)(cy));
    const rtk_u32 fit = lanes & ~edge & M(bits)(F(le)(r->scale, F(set)(DOUBLE_SCALE))) &
                        M(bits)(F(le)(F(set)(DOUBLE_DIR), slope)) & M(bits)(F(le)(slope, F(set)(1.0f / DOUBLE_DIR)));
    float from[COUNT][RTI_N], to[RESULTS][RTI_N];
    *edges = lanes & edge;
    if (fit == 0u)
        return lanes;
#define IN(k, of) F(store)(from[k], of) /* a loop over an array of them becomes a copy of the array */
    IN(AX, ax), IN(AY, ay), IN(AZ, az), IN(BX, bx), IN(BY, by), IN(BZ, bz), IN(CX, cx), IN(CY, cy), IN(CZ, cz);
    IN(MX, mx), IN(MY, my), IN(SCALE, r->scale), IN(OX, r->ox), IN(OY, r->oy), IN(OZ, r->oz);
    IN(DX, *dx), IN(DY, *dy), IN(DZ, r->kdz);
    IN(PX, v0[0]), IN(PY, v0[1]), IN(PZ, v0[2]), IN(QX, v1[0]), IN(QY, v1[1]), IN(QZ, v1[2]);
    IN(RX, v2[0]), IN(RY, v2[1]), IN(RZ, v2[2]);
#undef IN
    for (rtk_u32 at = 0u; at < RTI_N && fit >> at != 0u; at += DOUBLE_WIDTH) { /* lanes behind the last hold anything */
        DHALF half;
#define X(to, k)                                                                                                                 \
    memcpy(&half, from[k] + at, sizeof half);                                                                                    \
    const DVEC to = __builtin_convertvector(half, DVEC)
#define OUT(k, of)                                                                                                               \
    half = __builtin_convertvector(of, DHALF);                                                                                   \
    memcpy(to[k] + at, &half, sizeof half)
        X(xa, AX);
        X(ya, AY);
        X(xb, BX);
        X(yb, BY);
        X(xc, CX);
        X(yc, CY);
        X(xm, MX);
        X(ym, MY);
        const DVEC u = xc * yb - yc * xb, v = xa * yc - ya * xc, w = xb * ya - yb * xa, size = xm * ym;
        const DVEC det = u + v + w, inv = 1.0 / det, b = v * inv, c = w * inv;
        DMASK known = (DABS(det) > DOUBLE_LEAST_DET * size) & (DABS(v) > DOUBLE_LEAST_WEIGHT * size) &
                      (DABS(w) > DOUBLE_LEAST_WEIGHT * size);
        OUT(B_LOW, b * (1.0 - DOUBLE_OFF_B));
        OUT(B_HIGH, b * (1.0 + DOUBLE_OFF_B));
        OUT(C_LOW, c * (1.0 - DOUBLE_OFF_B));
        OUT(C_HIGH, c * (1.0 + DOUBLE_OFF_B));
        X(za, AZ);
        X(zb, BZ);
        X(zc, CZ);
        const DVEC along_b = b * (zb - za), along_c = c * (zc - za), z = za + (along_b + along_c);
        const DVEC depth = DABS(za) + (DABS(along_b) + DABS(along_c)), off_z = DOUBLE_OFF_Z * depth;
        known &= depth > DOUBLE_LEAST_DEPTH;
        OUT(Z_LOW, z - off_z);
        OUT(Z_HIGH, z + off_z);
        X(px, PX);
        X(py, PY);
        X(pz, PZ);
        X(qx, QX);
        X(qy, QY);
        X(qz, QZ);
        X(rx, RX);
        X(ry, RY);
        X(rz, RZ);
        const DVEC ex = qx - px, ey = qy - py, ez = qz - pz, fx = rx - px, fy = ry - py, fz = rz - pz;
        const DVEC yz = ey * fz, zy = ez * fy, zx = ez * fx, xz = ex * fz, xy = ex * fy, yx = ey * fx;
        const DVEC nx = yz - zy, ny = zx - xz, nz = xy - yx;
        const DVEC sx = DABS(yz) + DABS(zy), sy = DABS(zx) + DABS(xz);
        const DVEC sz = DABS(xy) + DABS(yx);
        X(ox, OX);
        X(oy, OY);
        X(oz, OZ);
        const DVEC hx = px - ox, hy = py - oy, hz = pz - oz;
        const DVEC num = nx * hx + ny * hy + nz * hz;
        const DVEC nums = sx * DABS(hx) + sy * DABS(hy) + sz * DABS(hz);
        X(scale, SCALE);
        X(xd, DX);
        X(yd, DY);
        X(zd, DZ);
        const DVEC den = nx * xd + ny * yd + nz * zd;
        const DVEC dens = sx * DABS(xd) + sy * DABS(yd) + sz * DABS(zd);
        const DVEC least = DOUBLE_LEAST_PLANE * scale + DOUBLE_LEAST;
        const DVEC turn = 1.0 / den, p = num * turn, far = DABS(p);
        const DVEC off_p = DOUBLE_OFF_PLANE * (nums + far * dens) * DABS(turn) + DOUBLE_OFF_QUOTIENT * far;
        known &= (nums > least) & (dens > DOUBLE_LEAST_PLANE * DABS(zd) + DOUBLE_LEAST);
        known &= (DABS(den) > DOUBLE_GRAZES * dens) & (far > DOUBLE_LEAST_QUOTIENT);
        OUT(P_LOW, p - off_p);
        OUT(P_HIGH, p + off_p);
        OUT(KNOWN, (DVEC)((DMASK)(0.0 * size + 1.0) & known));
#undef X
#undef OUT
    }
    const VEC b = F(load)(to[B_LOW]), c = F(load)(to[C_LOW]), z = F(load)(to[Z_LOW]), p = F(load)(to[P_LOW]), plane = p * r->kdz;
    const VEC close = F(set)(RTK_TRI_PLANE) * r->scale; /* as rtk_tri_exact has it */
    const rtk_u32 at_low = M(bits)(F(le)(F(abs)(plane - z), close));
    const rtk_u32 at_high = M(bits)(F(le)(F(abs)(plane - F(load)(to[Z_HIGH])), close));
    const rtk_u32 by_plane = at_low & at_high, by_z = ~(at_low | at_high) & M(bits)(F(eq)(z, F(load)(to[Z_HIGH])));
    const rtk_u32 known = fit & (by_plane | by_z) & M(bits)(F(lt)(zero, F(load)(to[KNOWN]))) &
                          M(bits)(F(eq)(b, F(load)(to[B_HIGH]))) & M(bits)(F(eq)(c, F(load)(to[C_HIGH]))) &
                          M(bits)(F(eq)(p, F(load)(to[P_HIGH])));
    const VEC t = r->tshift + F(select)(M(of)(by_plane), plane, z) / r->kdz;
    const rtk_u32 good = known & M(bits)(F(lt)(r->tmin, t)) & M(bits)(F(lt)(t, r->tmax));
    hit->t = F(select)(M(of)(good), t, hit->t);
    hit->u = F(select)(M(of)(good), F(min)(b, one), hit->u);
    hit->v = F(select)(M(of)(good), F(min)(c, one), hit->v);
    hit->hit |= good;
    return lanes & ~known;
}

#undef F
#undef M
#undef VEC
#undef RAY
#undef HIT
#undef TEST
#undef DVEC
#undef DMASK
#undef DHALF
#undef DABS
