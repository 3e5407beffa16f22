/* The leaf test of triangle.h in RTI_N lanes: the same operations in the same order, so the same bits. Included by tri_lanes.h.
 *
 * A lane is one pair of a ray and a triangle: one ray and many triangles, or many rays (of one order of axes) and one.
 */
#define F(op)  LANES_JOIN(rti_f, RTI_N, op)
#define M(op)  LANES_JOIN(rti_m, RTI_N, op)
#define VEC    LANES_TYPE(rti_f, RTI_N)
#define MASK   LANES_TYPE(rti_m, RTI_N)
#define RAY    LANES_TYPE(rti_tri_ray, RTI_N)
#define RESULT LANES_TYPE(rti_tri_hit, RTI_N)
#define TEST   LANES_TYPE(rti_tri, RTI_N)
#define TOLD   LANES_TYPE(rti_tri_told, RTI_N)
#define BEHIND LANES_TYPE(rti_tri_behind, RTI_N)
#define READY  LANES_TYPE(rti_tri_ready, RTI_N)
#define BOUNDS LANES_TYPE(rti_tri_bounds, RTI_N)
#define INSIDE LANES_TYPE(rti_tri_inside, RTI_N)
#define EDGES  LANES_TYPE(rti_tri_edges, RTI_N)
#define AHEAD  LANES_TYPE(rti_tri_ahead, RTI_N)
#define SHEAR  LANES_TYPE(rti_tri_shear, RTI_N)
#define BEYOND LANES_TYPE(rti_tri_beyond, RTI_N)

/* Of the prepared ray: korg, shear, and what the second half needs. */
typedef struct RAY {
    VEC ox, oy, oz, sx, sy, kdz, tmin, tmax, tshift, scale;
} RAY;

/* hit: lanes that the test accepts, with what it gives; doubt: lanes that must be asked one by one (rtk_tri_intersect). certain:
 * those of them that it will accept, with a t no farther than `off` from this one (without doubt: 0). */
typedef struct RESULT {
    uint32_t hit, doubt, certain;
    VEC t, u, v, off;
} RESULT;

/* The sheared corners, relative to the rays' origins, the edge functions, and of `lanes` those whose rays' lines may pass through
 * the triangle. */
typedef struct EDGES {
    VEC ax, ay, az, bx, by, bz, cx, cy, cz, uu, vv, ww;
    uint32_t keep;
} EDGES;

/* What is known beforehand of a triangle and all rays: det is told and finite; at `deep` or more from a ray's origin the first half
 * stands for certain; `rough` is the most that 2.4e-7 e comes to. */
typedef struct BOUNDS {
    VEC deep, rough;
} BOUNDS;

/* The first half, of corners less the ray's origin. */
RTI_VEC EDGES AHEAD(const VEC x[3], const VEC y[3], const VEC z[3], VEC sx, VEC sy, uint32_t lanes)
{
    const VEC zero = F(set)(0.0f);
    EDGES e;
    e.az = z[0], e.bz = z[1], e.cz = z[2];
    e.ax = x[0] - sx * e.az, e.ay = y[0] - sy * e.az;
    e.bx = x[1] - sx * e.bz, e.by = y[1] - sy * e.bz;
    e.cx = x[2] - sx * e.cz, e.cy = y[2] - sy * e.cz;
    e.uu = e.cx * e.by - e.cy * e.bx, e.vv = e.ax * e.cy - e.ay * e.cx, e.ww = e.bx * e.ay - e.by * e.ax;
    const VEC lo = F(min)(F(min)(e.uu, e.vv), e.ww), hi = F(max)(F(max)(e.uu, e.vv), e.ww);
    e.keep = lanes & ~M(bits)(M(and)(F(lt)(lo, zero), F(lt)(zero, hi)));
    return e;
}

RTI_VEC EDGES SHEAR(const RAY *r, const VEC a[3], const VEC b[3], const VEC c[3], uint32_t lanes)
{
    const VEC x[3] = {a[0] - r->ox, b[0] - r->ox, c[0] - r->ox}, y[3] = {a[1] - r->oy, b[1] - r->oy, c[1] - r->oy};
    const VEC z[3] = {a[2] - r->oz, b[2] - r->oz, c[2] - r->oz};
    return AHEAD(x, y, z, r->sx, r->sy, lanes);
}

/* Of `lanes` those whose rays' lines may pass through the triangle: the others have no hit there. */
RTI_VEC uint32_t INSIDE(const RAY *r, const VEC a[3], const VEC b[3], const VEC c[3], uint32_t lanes)
{
    return SHEAR(r, a, b, c, lanes).keep;
}

/* Rays that meet the triangle behind their origins by twice what the test below asks for, as that beside which a ray starts. ahead:
 * the depth, along the ray; rough: 2.4e-7 e. */
RTI_VEC MASK BEHIND(const RAY *r, VEC ahead, VEC rough)
{
    const VEC zero = F(set)(0.0f);
    const VEC less = F(select)(F(eq)(r->tmin, zero), F(set)(TRI_BEHIND), F(set)(2.0f * RTK_TRI_PLANE) * r->scale);
    const MASK from = M(and)(F(le)(zero, r->tmin), F(eq)(r->tshift, zero));
    return M(and)(F(lt)(ahead + (rough + less), zero), from);
}

/* Whether what is known beforehand decides all of *keep at depth z; lanes without a hit for certain are taken out. */
RTI_VEC int READY(const RAY *r, const BOUNDS *known, int any, VEC z, VEC ahead, MASK edge, uint32_t *keep, RESULT *out)
{
    if (*keep & M(bits)(F(lt)(ahead, F(set)(0.0f))))
        *keep &= ~M(bits)(BEHIND(r, ahead, known->rough));
    out->hit = *keep;
    out->doubt = 0u;
    if (any) { /* `certain`, as below, in depths: there is a hit, whatever the second half makes of its t */
        const VEC slope = F(abs)(r->kdz);
        const VEC off = known->rough + (F(set)(SETTLE_OFF) * r->scale + F(set)(2.0e-6f) * F(abs)(z) + F(set)(1e-18f));
        const MASK in = M(and)(F(lt)(r->tmin * slope, ahead - off), F(lt)(ahead + off, r->tmax * slope));
        return (*keep & ~M(bits)(M(andnot)(in, edge))) == 0u;
    }
    if ((*keep & ~M(bits)(M(andnot)(F(le)(known->deep, F(abs)(z)), edge))) != 0u)
        return 0;
    out->t = r->tshift + z / r->kdz;
    out->hit &= M(bits)(M(and)(F(lt)(r->tmin, out->t), F(lt)(out->t, r->tmax)));
    return 1;
}

/* What TOLD tells of lanes that SHEAR has left, of which there are some. */
RTI_VEC uint32_t BEYOND(const RAY *r, const EDGES *s, const BOUNDS *known, int any, RESULT *out)
{
    const VEC zero = F(set)(0.0f);
    const VEC ax = s->ax, ay = s->ay, az = s->az, bx = s->bx, by = s->by, bz = s->bz, cx = s->cx, cy = s->cy, cz = s->cz;
    const VEC uu = s->uu, vv = s->vv, ww = s->ww;
    uint32_t keep = s->keep;
    VEC det = uu + vv + ww, size = F(abs)(det);
    if (!known)
        keep &= M(bits)(F(lt)(size, F(set)(RTK_INF)));
    VEC inv = F(set)(1.0f) / det, db = bz - az, dc = cz - az;
    VEC wb = vv * inv, wc = ww * inv, z = az + (wb * db + wc * dc);
    const VEC ahead = F(select)(F(lt)(r->kdz, zero), -z, z);
    const MASK edge = M(or)(M(or)(F(eq)(uu, zero), F(eq)(vv, zero)), F(eq)(ww, zero));
    out->certain = 0u;
    out->off = zero;
    out->u = F(min)(wb, F(set)(1.0f));
    out->v = F(min)(wc, F(set)(1.0f));
    if (known && READY(r, known, any, z, ahead, edge, &keep, out))
        return out->hit;
    VEC mx = F(max)(F(max)(F(abs)(ax), F(abs)(bx)), F(abs)(cx));
    VEC my = F(max)(F(max)(F(abs)(ay), F(abs)(by)), F(abs)(cy));
    VEC d = F(max)(F(abs)(db), F(abs)(dc)), q = mx * my * F(abs)(inv);
    VEC e = wb * F(abs)(db) + wc * F(abs)(dc);
    e = F(set)(10.0f) * e + (F(set)(7.0f) * e + F(set)(4.0f) * d) * q;
    MASK told = F(le)(F(set)(RTK_TRI_LEAST), size);
    if (keep & M(bits)(F(lt)(ahead, zero))) {
        keep &= ~M(bits)(M(and)(told, BEHIND(r, ahead, F(set)(2.4e-7f) * e)));
        if (keep == 0u)
            return 0u;
    }
    MASK good = F(le)(e, F(min)(F(set)(32.0f) * r->scale, F(set)(64.0f) * F(abs)(z)));
    good = M(and)(good, F(le)((mx + my) * (F(set)(10.0f) * q + F(set)(12.0f)), F(set)(128.0f) * r->scale));
    uint32_t sure = keep & M(bits)(M(andnot)(M(and)(good, told), edge)), doubt = keep & ~sure;
    const VEC th = r->tshift + z / r->kdz;
    out->t = th;
    if (doubt) {
        VEC slope = F(abs)(r->kdz), off;
        e = F(set)(1.2e-7f) * e / slope;
        off = e + (F(set)(RTK_TRI_PLANE) * r->scale / slope + F(set)(2.4e-7f) * (F(abs)(th) + F(abs)(r->tshift)));
        const VEC low = F(select)(F(eq)(r->tmin, zero), e, off);
        doubt &= ~M(bits)(M(and)(told, M(or)(F(lt)(th + low, r->tmin), F(lt)(r->tmax, th - off))));
        off = e + (F(set)(SETTLE_OFF) * r->scale / slope + F(set)(CERTAIN_OFF_T) * (F(abs)(th) + F(abs)(r->tshift)));
        off = off + F(set)(CERTAIN_OFF_LEAST);
        good = M(and)(F(le)(q, F(set)(CERTAIN_Q)), F(le)(F(set)(CERTAIN_DET), size));
        good = M(andnot)(M(and)(good, M(and)(F(lt)(r->tmin, th - off), F(lt)(th + off, r->tmax))), edge);
        out->certain = doubt & M(bits)(good); /* no NaN: th is compared; who keeps hits by vectors relies on that */
        out->off = off;
    }
    out->hit = sure & M(bits)(M(and)(F(lt)(r->tmin, th), F(lt)(th, r->tmax)));
    out->doubt = doubt;
    return out->hit | doubt;
}

/* a[0] x, a[1] y, a[2] z of vertex 0 in the ray's order of axes, likewise b, c; lanes: those that count. Returns hit | doubt.
 * known: NULL, or what spares most of the bounds; tshift is 0 then. any: with it, of a hit t, u, v are not asked. */
RTI_VEC uint32_t TOLD(const RAY *r, const VEC a[3], const VEC b[3], const VEC c[3], uint32_t lanes, const BOUNDS *known, int any,
                      RESULT *out)
{
    const EDGES s = SHEAR(r, a, b, c, lanes);
    if (__builtin_expect(s.keep == 0u, 1))
        return 0u;
    return BEYOND(r, &s, known, any, out);
}

RTI_VEC uint32_t TEST(const RAY *r, const VEC a[3], const VEC b[3], const VEC c[3], uint32_t lanes, RESULT *out)
{
    return TOLD(r, a, b, c, lanes, NULL, 0, out);
}

#undef F
#undef M
#undef VEC
#undef MASK
#undef RAY
#undef RESULT
#undef TEST
#undef TOLD
#undef BEHIND
#undef READY
#undef BOUNDS
#undef INSIDE
#undef EDGES
#undef AHEAD
#undef SHEAR
#undef BEYOND
