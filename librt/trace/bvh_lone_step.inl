/* One ray against triangles of a leaf, LONE_N at a time. Included by bvh_lone.h. */
#define F(op)     LANES_JOIN(rti_f, LONE_N, op)
#define VEC       LANES_TYPE(rti_f, LONE_N)
#define BITS      LANES_JOIN(rti_m, LONE_N, bits)
#define RAY       LANES_TYPE(rti_tri_ray, LONE_N)
#define RESULT    LANES_TYPE(rti_tri_hit, LONE_N)
#define EDGES     LANES_TYPE(rti_tri_edges, LONE_N)
#define AHEAD     LANES_TYPE(rti_tri_ahead, LONE_N)
#define BEYOND    LANES_TYPE(rti_tri_beyond, LONE_N)
#define LONE_TEST LANES_TYPE(lone_test, LONE_N)
#define LONE_STEP LANES_TYPE(lone_step, LONE_N)

/* The leaf test of `count` triangles from the place `at` on, which lie in as many blocks as there are lanes; lane 0 is the first of
 * the blocks. Returns hit | doubt. */
RTI_VEC rtk_u32 LONE_TEST(const lone *l, rtk_u32 at, rtk_u32 count, RESULT *hit)
{
    const rtk_u32 begin = at % 4u, left = begin + count;
    LONE_AGAIN(l);
    const VEC less[3] = {F(set)(l->less[0]), F(set)(l->less[1]), F(set)(l->less[2])};
    const char *b = (const char *)&l->tree->blocks[at / 4u];
    const char *x = b + l->row[0], *y = b + l->row[1], *z = b + l->row[2];
    const rtk_u32 want = ((1u << left) - 1u) & ~0u << begin;
#define AT(p, corner) ((const float *)(const void *)((p) + (corner) * sizeof(((rtk_bvhblock *)0)->v0)))
#if LONE_N > 4
    const size_t next = left > 4u ? sizeof(rtk_bvhblock) : 0u; /* one block stands for two */
#define ROW(p, corner) rti_f8_two(AT(p, corner), AT((p) + next, corner))
#else
#define ROW(p, corner) rti_f4_load(AT(p, corner))
#endif
    /* Sums with less the origin are the differences from it, and load what they add to. */
    const VEC ahead_x[3] = {ROW(x, 0) + less[0], ROW(x, 1) + less[0], ROW(x, 2) + less[0]};
    const VEC ahead_y[3] = {ROW(y, 0) + less[1], ROW(y, 1) + less[1], ROW(y, 2) + less[1]};
    const VEC ahead_z[3] = {ROW(z, 0) + less[2], ROW(z, 1) + less[2], ROW(z, 2) + less[2]};
#undef ROW
#undef AT
    const EDGES e = AHEAD(ahead_x, ahead_y, ahead_z, F(set)(l->sx), F(set)(l->sy), want);
    if (e.keep == 0u)
        return 0u;
    LONE_AGAIN(l);
    const RAY ray = {.kdz = F(set)(l->dir[2]),
                     .tmin = F(set)(l->less[3]),
                     .tmax = F(set)(l->dir[3]),
                     .tshift = F(set)(l->shift),
                     .scale = F(set)(l->scale)};
    return BEYOND(&ray, &e, NULL, 0, hit);
}

/* Such triangles. Calls are the last thing it does: then it need not save registers. */
RTI_VEC int LONE_STEP(lone *l, rtk_u32 mode, rtk_u32 at, rtk_u32 count)
{
    RESULT hit;
    const rtk_u32 bits = LONE_TEST(l, at, count, &hit);
    at -= at % 4u;
    if (bits == 0u)
        return 0;
    if ((mode & RTK_MODE_ANY) && hit.hit != 0u)
        return 1;
    const float most = rtk_max(l->far, l->t);
    rtk_u32 sure = hit.hit & BITS(F(le)(hit.t, F(set)(most)));
    F(store)(l->met.t, hit.t);
    F(store)(l->met.u, hit.u);
    F(store)(l->met.v, hit.v);
    if (__builtin_expect(hit.doubt != 0u || l->t < l->far, 0)) {
        F(store)(l->met.off, hit.off);
        l->met.certain = hit.certain;
        return lone_meet(l, mode, at, sure, hit.doubt);
    }
    for (; sure != 0u; sure &= sure - 1u) { /* as lone_take, where no hit is put aside */
        const rtk_u32 i = (rtk_u32)__builtin_ctz(sure);
        const float t = l->met.t[i];
        if (t == l->t)
            return lone_meet(l, mode, at, sure, 0u);
        if (t < l->t) {
            l->t = t;
            l->u = l->met.u[i];
            l->v = l->met.v[i];
            l->late = at + i;
            l->far = rtk_min(l->far, t);
            lone_expect(l, at + i);
        }
    }
    return 0;
}

#undef F
#undef VEC
#undef BITS
#undef RAY
#undef RESULT
#undef EDGES
#undef AHEAD
#undef BEYOND
#undef LONE_TEST
#undef LONE_STEP
