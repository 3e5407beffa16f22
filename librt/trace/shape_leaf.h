/* Shapes of leaves that are no spheres, for hot files: one for RTI_SIMD rays, or as many as a node's vectors have lanes for one
 * ray. */
#ifndef RTI_SHAPE_LEAF_H
#define RTI_SHAPE_LEAF_H

#include "bvh_lanes.h"
#include "packet.h"

#if NODE_N > 4
#define ball_test      rti_ball8
#define ball_meets     rti_ball_rays8
#define ball_near      rti_ball_near8
#define ball_one_ready rti_ball_ready8
#define box_test       rti_box_test8
#define cone_test      rti_cone_test8
typedef rti_ball_ray8 ball_ray;
typedef rti_cone8 cone_row;
#else
#define ball_test      rti_ball4
#define ball_meets     rti_ball_rays4
#define ball_near      rti_ball_near4
#define ball_one_ready rti_ball_ready4
#define box_test       rti_box_test4
#define cone_test      rti_cone_test4
typedef rti_ball_ray4 ball_ray;
typedef rti_cone4 cone_row;
#endif

/* ---- one shape, many rays ---- */

RTI_APART rtk_u32 shape_cone_hits(const ball_rays *r, const vec inv[3], const float form[8], vec far, rtk_u32 lanes, vec *out,
                                  rtk_u32 *ask)
{
    const cone_ends cone = {
        {{V(set)(form[0]), V(set)(form[1]), V(set)(form[2])}, {V(set)(form[4]), V(set)(form[5]), V(set)(form[6])}},
        {V(set)(form[3]), V(set)(form[7])}};
    return cone_many(r, inv, &cone, far, lanes, out, ask);
}

/* Of `lanes` those whose rays, which are ready, hit the shape of a ball, and of a form if there is one, and where first, in (tmin,
 * tmax). inv: rtk_inverse of their directions. Hits behind `far` need not be told. ask: lanes that are to be asked one by one. */
RTI_VEC rtk_u32 shape_hits(const ball_rays *r, const vec inv[3], const float *ball, rtk_u32 size, vec far, rtk_u32 lanes, vec *out,
                           rtk_u32 *ask)
{
    const vec middle[3] = {V(set)(ball[0]), V(set)(ball[1]), V(set)(ball[2])};
    const float *form = ball + RTK_BALL;
    *ask = 0u;
    *out = far; /* where nothing hits it is read, too */
    if (ball[3] >= 0.0f)
        return ball_many(r, middle, V(set)(ball[3]), far, lanes, out);
    if (size == RTK_FORM && form[3] == RTK_FORM_BOX) { /* as quickly told as its ball */
        const vec lo[3] = {V(set)(form[0]), V(set)(form[1]), V(set)(form[2])};
        const vec hi[3] = {V(set)(form[4]), V(set)(form[5]), V(set)(form[6])};
        return box_many(r, inv, lo, hi, lanes, out);
    }
    *ask = balls_near(r, middle, V(set)(-ball[3]), far, lanes);
    if (*ask == 0u || size != RTK_FORM || form[3] == RTK_FORM_OTHER)
        return 0u;
    const ball_rays rays = *r; /* of copies: what has its address taken is in no register */
    const vec by[3] = {inv[0], inv[1], inv[2]};
    vec t;
    rtk_u32 other;
    const rtk_u32 hit = shape_cone_hits(&rays, by, form, far, *ask, &t, &other);
    *out = t;
    *ask = other;
    return hit;
}

/* ---- one ray, many shapes ---- */

/* Four fields of NODE_N balls or forms, which begin at p and `step` floats behind each other. */
RTI_VEC void shape_fours(const float *p, rtk_u32 step, bvh_vec to[4])
{
    bvh_vec rows[4];
    for (rtk_u32 i = 0u; i < 4u; i++)
#if NODE_N > 4
        rows[i] = rti_f8_two(p + i * step, p + (4u + i) * step);
#else
        rows[i] = rti_f4_load(p + i * step);
#endif
    NODE(turn)(rows, to);
}

/* As shape_hits, NODE_N forms that begin at p for one ray, which is ready. */
RTI_APART rtk_u32 shape_one(const ball_ray *r, const bvh_vec inv[3], const float *p, rtk_u32 lanes, bvh_vec far, bvh_vec *out,
                            rtk_u32 *ask)
{
    bvh_vec form[8], t;
    shape_fours(p, RTK_FORM, form);
    shape_fours(p + 4, RTK_FORM, form + 4);
    const rtk_u32 boxes = lanes & node_bits(NODE(eq)(form[3], NODE(set)(RTK_FORM_BOX)));
    const rtk_u32 cones = lanes & node_bits(NODE(le)(NODE(set)(0.0f), form[3]));
    rtk_u32 hit = 0u, met = 0u;
    *ask = 0u;
    *out = far;
    if (cones != 0u) {
        const cone_row cone = {{{form[0], form[1], form[2]}, {form[4], form[5], form[6]}}, {form[3], form[7]}};
        hit = cone_test(r, inv, &cone, far, cones, out, ask);
    }
    if (boxes != 0u)
        met = box_test(r, inv, form, form + 4, boxes, &t);
    if (met != 0u)
        *out = NODE(select)(node_of(met), t, *out);
    *ask |= lanes & ~(boxes | cones);
    return hit | met;
}

/* The shapes whose balls begin at p, of `count` the first NODE_N, for one ray, which is ready: hits, a bit each, with where. ask:
 * those that are to be asked one by one. */
RTI_VEC rtk_u32 shape_leaf(const ball_ray *r, const bvh_vec inv[3], const float *p, rtk_u32 size, rtk_u32 count, bvh_vec far,
                           bvh_vec *out, rtk_u32 *ask)
{
    const rtk_u32 want = (1u << rtk_umin(count, NODE_N)) - 1u;
    bvh_vec ball[4];
    shape_fours(p, size, ball);
    const bvh_vec radius = NODE(abs)(ball[3]);
    const rtk_u32 others = want & node_bits(NODE(lt)(ball[3], NODE(set)(0.0f)));
    *out = far; /* where nothing hits it is read, too */
    const rtk_u32 hit = ball_test(r, ball, radius, far, want & ~others, out);
    *ask = others != 0u ? ball_near(r, ball, radius, far, others) : 0u;
    if (*ask == 0u || size != RTK_FORM)
        return hit;
    const ball_ray ray = *r; /* of copies, likewise */
    const bvh_vec by[3] = {inv[0], inv[1], inv[2]};
    bvh_vec t;
    rtk_u32 other;
    const rtk_u32 met = shape_one(&ray, by, p + RTK_BALL, *ask, far, &t, &other);
    *ask = other;
    if (met != 0u)
        *out = NODE(select)(node_of(met), t, *out);
    return hit | met;
}

#endif
