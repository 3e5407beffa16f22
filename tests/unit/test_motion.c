/* Moving instances: their ways against what they are made of, their boxes against rounding, tracers against each other at every
 * time, images against sums of stills. */
#include <stdio.h>

#include "kernel/surface.h"
#include "scene/scene.h"
#include "scene/snapshot.h"

#include "render_stage.h" /* its scene would be shadowed by the kernels' arguments */

static uint32_t seed = 5;

static rt_transform times(rt_transform a, rt_transform b)
{
    return rt_transform_multiply(a, b);
}

/* Stretched on a turned axis by up to `stretch`, turned and moved. */
static rt_transform place(float stretch, float far, int mirror)
{
    float by = powf(stretch, kit_range(&seed, -1, 1));
    rt_transform axis = rt_transform_rotate(kit_vec(&seed, 1), kit_range(&seed, 0, 360)), back = axis;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            back.m[4 * r + c] = axis.m[4 * c + r];
    rt_transform t = times(times(axis, rt_transform_scale(v3(1, by, mirror ? -1.0f : 1.0f))), back);
    return times(rt_transform_translate(kit_vec(&seed, far)),
                 times(rt_transform_rotate(kit_vec(&seed, 1), kit_range(&seed, 0, 360)), t));
}

enum { PLACES = 4 };

typedef struct way {
    rtk_xfm keys[PLACES + 1];
    rtk_motion motion[PLACES];
    rtk_instance inst;
} way;

/* A way of some places; kind 0: a body of one shape, 1: one whose stretch changes, 2: one that does not turn. false: the library
 * refuses it. */
static bool make_way(way *w, int kind, float stretch, float far)
{
    uint32_t n = 1 + (uint32_t)kit_range(&seed, 0, PLACES - 0.01f);
    int mirror = kit_range(&seed, 0, 1) < 0.3f;
    rt_transform shape = place(stretch, 0, mirror), turn = rt_transform_rotate(kit_vec(&seed, 1), kit_range(&seed, 0, 360));
    memset(w, 0, sizeof *w);
    for (uint32_t i = 0; i <= n; i++) {
        rt_transform t = kind == 1
                             ? place(stretch, far, mirror)
                             : times(times(rt_transform_translate(kit_vec(&seed, far)),
                                           kind == 2 ? turn : rt_transform_rotate(kit_vec(&seed, 1), kit_range(&seed, 0, 360))),
                                     shape);
        memcpy(w->keys[i].m, t.m, sizeof t.m);
    }
    w->inst.flags = RTK_INST_MOVING;
    w->inst.motion_count = n;
    return rti_motion_make(w->keys, n, w->motion) == NULL;
}

static double off(const rtk_xfm *a, const rtk_xfm *b)
{
    double most = 0;
    for (int i = 0; i < 12; i++)
        most = fmax(most, fabs((double)a->m[i] - b->m[i]));
    return most;
}

/* At a key's time the way is at the key; the two maps undo each other. */
static void ways_meet_their_places(void **state)
{
    (void)state;
    int made = 0, rigid = 0;
    for (int round = 0; round < 4000; round++) {
        way w;
        double most = 0;
        if (!make_way(&w, round & 1, round % 4 < 2 ? 3.0f : 30.0f, 10))
            continue;
        made++;
        rigid += (w.motion[0].flags & RTK_MOTION_RIGID) != 0;
        assert_true(rti_motion_sound(w.motion, w.inst.motion_count));
        for (uint32_t k = 0; k <= w.inst.motion_count; k++) {
            rtk_xfm m = rtk_pose_to_world(rtk_pose_at(w.motion, &w.inst, (float)k / (float)w.inst.motion_count));
            assert_true(off(&m, &w.keys[k]) < 3e-6 * (10 + w.motion[0].size));
        }
        for (int i = 0; i < 20; i++) {
            rtk_pose p = rtk_pose_at(w.motion, &w.inst, kit_range(&seed, 0, 1));
            rtk_xfm m = rtk_pose_to_world(p), v = rtk_pose_to_object(p);
            for (int r = 0; r < 3; r++)
                for (int c = 0; c < 4; c++) {
                    double sum = c == 3 ? m.m[4 * r + 3] : 0.0;
                    for (int k = 0; k < 3; k++)
                        sum += (double)m.m[4 * r + k] * v.m[4 * k + c];
                    most = fmax(most, fabs(sum - (r == c)) / (c == 3 ? 10.0 : 1.0));
                }
        }
        assert_true(most < 5.96e-8 * 14 * w.motion[0].condition + 20 * 5.96e-8);
    }
    print_message("%d ways, %d of bodies of one shape\n", made, rigid);
    assert_true(made > 3000 && rigid > 1500);
}

/* A quarter turn about its own origin is half done at half the time, also when it is far away, stretched or mirrored; it moves
 * straight. */
static void turns_are_even(void **state)
{
    rtk_xfm keys[3];
    rtk_motion motion[2];
    rtk_instance inst = {.flags = RTK_INST_MOVING, .motion_count = 2};
    (void)state;
    for (int mirror = 0; mirror < 2; mirror++) {
        rt_transform shape = rt_transform_scale(v3(mirror ? -2.0f : 2.0f, 1, 3));
        for (int k = 0; k < 3; k++) {
            rt_transform t = times(times(rt_transform_translate(v3(100 + 8.0f * (float)k, 0, 5)),
                                         rt_transform_rotate(v3(0, 1, 0), 170.0f * (float)k)),
                                   shape);
            memcpy(keys[k].m, t.m, sizeof t.m);
        }
        assert_null(rti_motion_make(keys, 2, motion));
        for (int i = 0; i <= 16; i++) {
            float u = (float)i / 16;
            rt_transform t =
                times(times(rt_transform_translate(v3(100 + 16 * u, 0, 5)), rt_transform_rotate(v3(0, 1, 0), 340 * u)), shape);
            rtk_xfm m = rtk_pose_to_world(rtk_pose_at(motion, &inst, u)), want;
            memcpy(want.m, t.m, sizeof t.m);
            assert_true(off(&m, &want) < 2e-5);
        }
        assert_true(motion[0].flags & RTK_MOTION_RIGID);
    }
    /* Beyond the ends it stands still, and no time is no number. */
    for (int i = 0; i < 4; i++) {
        static const float at[4] = {-3, 7, NAN, -INFINITY};
        rtk_xfm m = rtk_pose_to_world(rtk_pose_at(motion, &inst, at[i]));
        assert_true(off(&m, &keys[i == 1 ? 2 : 0]) < 2e-5);
    }
}

static bool invert_double(const rtk_xfm *w, double out[12])
{
    double m[9], d;
    const int at[9] = {0, 1, 2, 4, 5, 6, 8, 9, 10};
    for (int i = 0; i < 9; i++)
        m[i] = w->m[at[i]];
    double c[9] = {m[4] * m[8] - m[5] * m[7], m[2] * m[7] - m[1] * m[8], m[1] * m[5] - m[2] * m[4],
                   m[5] * m[6] - m[3] * m[8], m[0] * m[8] - m[2] * m[6], m[2] * m[3] - m[0] * m[5],
                   m[3] * m[7] - m[4] * m[6], m[1] * m[6] - m[0] * m[7], m[0] * m[4] - m[1] * m[3]};
    d = m[0] * c[0] + m[1] * c[3] + m[2] * c[6];
    for (int r = 0; r < 3; r++) {
        for (int k = 0; k < 3; k++)
            out[4 * r + k] = c[3 * r + k] / d;
        out[4 * r + 3] = -(out[4 * r] * w->m[3] + out[4 * r + 1] * w->m[7] + out[4 * r + 2] * w->m[11]);
    }
    return d != 0;
}

/* The map that the tracers use, inverted without rounding, never takes a point of the child out of the box of all times grown by
 * what scene/motion.c derives; and the ungrown box is not far too large. */
static void boxes_hold_all_times(void **state)
{
    double tight = 0, used = 0;
    (void)state;
    for (int round = 0; round < 3000; round++) {
        way w;
        float lo[3], hi[3], out_lo[3], out_hi[3], far = powf(10, kit_range(&seed, 0, 4)), grow,
                                                  origin = round % 5 ? 0 : kit_range(&seed, -50, 50);
        double seen_lo[3] = {1e30, 1e30, 1e30}, seen_hi[3] = {-1e30, -1e30, -1e30};
        if (!make_way(&w, round % 3, round % 4 < 2 ? 3.0f : 30.0f, far))
            continue;
        for (int k = 0; k < 3; k++) {
            lo[k] = origin + kit_range(&seed, -2, 0);
            hi[k] = origin + kit_range(&seed, 0.1f, 2);
        }
        rti_motion_bounds(w.motion, w.inst.motion_count, lo, hi, out_lo, out_hi);
        grow = rti_motion_growth(w.motion, w.inst.motion_count, lo, hi, 0);
        for (int i = 0; i < 400; i++) {
            rtk_xfm v = rtk_pose_to_object(rtk_pose_at(w.motion, &w.inst, i < 3 ? 0.5f * (float)i : kit_range(&seed, 0, 1)));
            double m[12], q[3];
            assert_true(invert_double(&v, m));
            for (int k = 0; k < 3; k++)
                q[k] = i & 1 << k ? hi[k] : lo[k];
            for (int r = 0; r < 3; r++) {
                double p = m[4 * r] * q[0] + m[4 * r + 1] * q[1] + m[4 * r + 2] * q[2] + m[4 * r + 3];
                if (!(p >= (double)out_lo[r] - grow && p <= (double)out_hi[r] + grow))
                    fail_msg("round %d: %.9g is not in %.9g ... %.9g, grown by %g", round, p, (double)out_lo[r],
                             (double)out_hi[r], (double)grow);
                used = fmax(used, fmax((out_lo[r] - p) / grow, (p - out_hi[r]) / grow));
                seen_lo[r] = fmin(seen_lo[r], p);
                seen_hi[r] = fmax(seen_hi[r], p);
            }
        }
        for (int r = 0; r < 3; r++)
            tight = fmax(tight, ((double)out_hi[r] - out_lo[r] + 2.0 * grow) / (seen_hi[r] - seen_lo[r]));
    }
    print_message("boxes are up to %.3g times as wide as what was seen; the growth is used to %.3g\n", tight, used);
    assert_true(tight < 2.5 && used > 0.001);
}

/* ---- through the public API ---- */

/* The child is a body of some shapes. */
static int setup(void **state)
{
    rt_torus_desc t = rt_torus_desc_default();
    rt_material clay;
    (void)state;
    stage(1);
    OK(rt_scene_create(ctx, &child));
    clay = add_material(child, v3(0.9f, 0.4f, 0.2f), 0.9f, 0.1f, 0, 1);
    add_box(child, v3(-1, -0.1f, -0.2f), v3(1, 0.1f, 0.2f), clay);
    add_sphere(child, v3(0.9f, 0.2f, 0), 0.3f, clay);
    t.center = v3(-0.6f, 0.3f, 0);
    t.axis = v3(0, 1, 0.3f);
    t.major_radius = 0.3f;
    t.minor_radius = 0.1f;
    t.common.material = clay;
    OK(rt_scene_add_torus(child, &t, NULL));
    OK(rt_scene_commit(child, NULL));
    return 0;
}

enum { RAYS = 1500, BODIES = 24 };

/* Every tracer gives brute force's hits at every time, for bodies near and far, stretched, mirrored, spinning, some with planes.
 */
static void tracers_agree(void **state)
{
    static const char *const tracers[] = {"brute", "kdtree", "octree"};
    static const float fars[] = {4, 400, 0.05f};
    uint32_t hits_seen = 0, later = 0;
    (void)state;
    for (int round = 0; round < 6; round++) {
        rt_scene *floor, *s;
        rt_ray rays[RAYS];
        float at[RAYS], far = fars[round % 3];
        rt_hit *hits = malloc(3 * RAYS * sizeof *hits);
        OK(rt_scene_create(ctx, &floor));
        add_plane(floor, v3(0, 0, 0), v3(0, 1, 0), (rt_material){0});
        add_sphere(floor, v3(0, 0, 0), 1, (rt_material){0});
        OK(rt_scene_commit(floor, NULL));
        OK(rt_scene_create(ctx, &s));
        for (int i = 0; i < BODIES; i++) {
            rt_instance_desc d = rt_instance_desc_default();
            rt_transform motion[PLACES];
            float scale = 0.3f * far;
            d.child = i % 8 == 7 ? floor : child;
            d.transform = times(place(3, far, i % 5 == 0), rt_transform_scale(v3(scale, scale, scale)));
            d.motion_count = i % 4 == 3 ? 0 : 1 + (uint32_t)i % PLACES;
            for (uint32_t k = 0; k < d.motion_count; k++)
                motion[k] = times(place(3, far, i % 5 == 0), rt_transform_scale(v3(scale, scale, scale)));
            d.motion = motion;
            if (rt_scene_add_instance(s, &d, NULL) != RT_OK) {
                char text[512];
                rt_context_error(ctx, text, sizeof text);
                fail_msg("%s", text);
            }
        }
        for (int i = 0; i < RAYS; i++) {
            rt_vec3 from = kit_vec(&seed, (i & 1 ? 3 : 3000) * far), to = kit_vec(&seed, far);
            rays[i] = (rt_ray){from, 0, {to.x - from.x, to.y - from.y, to.z - from.z}, INFINITY, RT_MASK_ALL};
            at[i] = i % 7 == 0 ? (float)(i % 2) : kit_range(&seed, 0, 1);
        }
        for (int k = 0; k < 3; k++) {
            rt_hit all[3][8];
            uint8_t occluded[RAYS];
            OK(rt_scene_set_tracer(s, tracers[k]));
            OK(rt_scene_commit(s, NULL));
            rt_scene_intersect_at(s, rays, at, hits + k * RAYS, RAYS);
            rt_scene_occluded_at(s, rays, at, occluded, RAYS);
            for (int i = 0; i < RAYS; i++) {
                if (memcmp(&hits[i], &hits[k * RAYS + i], sizeof *hits) != 0)
                    fail_msg("round %d, %s, ray %d: t %.9g, not %.9g", round, tracers[k], i, (double)hits[k * RAYS + i].t,
                             (double)hits[i].t);
                assert_int_equal(occluded[i], hits[i].prim_id != RT_INVALID_ID);
                hits_seen += hits[i].prim_id != RT_INVALID_ID;
            }
            for (int i = 0; i < 60; i++) {
                size_t n = rt_scene_intersect_all_at(s, &rays[i], at[i], all[k], 8);
                if (n > 0)
                    assert_memory_equal(&all[k][0], &hits[i], sizeof *hits);
                later += n > 1;
                for (size_t j = 1; j < n; j++)
                    assert_true(all[k][j].t >= all[k][j - 1].t);
            }
        }
        free(hits);
        rt_scene_destroy(s);
        rt_scene_destroy(floor);
    }
    print_message("%u hits\n", hits_seen);
    assert_true(hits_seen > 18 * RAYS / 4 && later > 100);
}

/* A moving scene asked at a time answers as one that stands still there; points and normals are those of that time, and rays that
 * leave a convex body outwards do not meet it again. */
static void a_time_is_a_still(void **state)
{
    uint32_t compared = 0, left = 0;
    (void)state;
    for (int round = 0; round < 40; round++) {
        rt_scene *ball, *moving, *still;
        rt_instance_desc d = rt_instance_desc_default();
        rt_transform end;
        float time = kit_range(&seed, 0, 1), far = powf(10, kit_range(&seed, -1, 3));
        way w = {.inst = {.flags = RTK_INST_MOVING, .motion_count = 1}};
        rtk_xfm m;
        OK(rt_scene_create(ctx, &ball));
        add_sphere(ball, v3(0, 0, 0), 1, (rt_material){0});
        OK(rt_scene_commit(ball, NULL));
        OK(rt_scene_create(ctx, &moving));
        OK(rt_scene_create(ctx, &still));
        d.child = ball;
        d.transform = place(3, far, round % 3 == 0);
        end = place(3, far, round % 3 == 0);
        d.motion = &end;
        d.motion_count = 1;
        OK(rt_scene_add_instance(moving, &d, NULL));
        memcpy(w.keys[0].m, d.transform.m, sizeof d.transform.m);
        memcpy(w.keys[1].m, end.m, sizeof end.m);
        assert_null(rti_motion_make(w.keys, 1, w.motion));
        m = rtk_pose_to_world(rtk_pose_at(w.motion, &w.inst, time));
        d.motion_count = 0;
        memcpy(d.transform.m, m.m, sizeof m.m);
        OK(rt_scene_add_instance(still, &d, NULL));
        OK(rt_scene_commit(moving, NULL));
        OK(rt_scene_commit(still, NULL));
        for (int i = 0; i < 200; i++) {
            rt_vec3 out = kit_vec(&seed, 1), from = {m.m[3] + 9 * out.x, m.m[7] + 9 * out.y, m.m[11] + 9 * out.z},
                    aim = kit_vec(&seed, 0.7f);
            rt_ray ray = {from, 0, {m.m[3] + aim.x - from.x, m.m[7] + aim.y - from.y, m.m[11] + aim.z - from.z}, INFINITY, ~0u};
            rt_hit a, b;
            rt_surface sa, sb;
            rt_scene_intersect_at(moving, &ray, &time, &a, 1);
            rt_scene_intersect(still, &ray, &b, 1);
            if (a.prim_id == RT_INVALID_ID || b.prim_id == RT_INVALID_ID)
                continue;
            rt_scene_surface_at(moving, &ray, time, &a, &sa);
            rt_scene_surface(still, &ray, &b, &sb);
            double gap = fabs((double)sa.position.x - sb.position.x) + fabs((double)sa.position.y - sb.position.y) +
                         fabs((double)sa.position.z - sb.position.z);
            double turn = fabs((double)sa.ns.x - sb.ns.x) + fabs((double)sa.ns.y - sb.ns.y) + fabs((double)sa.ns.z - sb.ns.z);
            assert_true(gap < 2e-4 * (1 + 0.02 * far) && turn < 2e-3 * (1 + 0.02 * far));
            assert_true(sa.position_error < 3e-4f * (1 + far));
            compared++;
            for (int k = 0; k < 8; k++) { /* outwards, some nearly along the surface */
                rt_vec3 dir = kit_vec(&seed, 1);
                float up = dir.x * sa.ng.x + dir.y * sa.ng.y + dir.z * sa.ng.z, graze = k & 1 ? 1.0f : 1e-3f;
                dir = v3(dir.x + (graze * fabsf(up) - up) * sa.ng.x, dir.y + (graze * fabsf(up) - up) * sa.ng.y,
                         dir.z + (graze * fabsf(up) - up) * sa.ng.z);
                float lift = 2 * sa.position_error;
                rt_ray leave = {
                    v3(sa.position.x + lift * sa.ng.x, sa.position.y + lift * sa.ng.y, sa.position.z + lift * sa.ng.z), 0, dir,
                    INFINITY, ~0u};
                uint8_t again;
                rt_scene_occluded_at(moving, &leave, &time, &again, 1);
                if (again)
                    fail_msg("round %d: a ray that leaves at time %g meets its own body", round, (double)time);
                left++;
            }
        }
        rt_scene_destroy(moving);
        rt_scene_destroy(still);
        rt_scene_destroy(ball);
    }
    print_message("%u hits compared, %u rays left\n", compared, left);
    assert_true(compared > 2000);
}

/* ---- images ---- */

static rt_transform propeller_at(double t)
{
    return times(rt_transform_translate(v3((float)(-0.5 + t), 0.2f, 0)), rt_transform_rotate(v3(0, 0.3f, 1), (float)(200 * t)));
}

static rt_instance add_propeller(void)
{
    rt_instance id;
    rt_instance_desc d = rt_instance_desc_default();
    rt_material glass, white;
    white = add_material(scene, v3(0.8f, 0.8f, 0.8f), 0.9f, 0.1f, 0, 1);
    glass = add_material(scene, v3(0.9f, 1, 0.9f), 0.05f, 0.1f, 0.85f, 1.5f);
    add_plane(scene, v3(0, -1, 0), v3(0, 1, 0), white);
    add_sphere(scene, v3(1, -0.5f, 0.8f), 0.5f, glass);
    set_world(scene, v3(0.3f, 0.4f, 0.5f), v3(0.7f, 0.8f, 0.9f));
    add_light(scene, light(RT_LIGHT_DIRECTIONAL, v3(-1, -2, -1), v3(0.8f, 0.8f, 0.8f), RT_FALLOFF_NONE));
    look(scene, v3(0, 0.6f, 5), v3(0, -0.1f, 0), 38);
    d.child = child;
    OK(rt_scene_add_instance(scene, &d, &id));
    return id;
}

/* Sees the moving body, its shadow on the floor, its mirror image there and its picture in a ball of glass. */
static void blur_is_a_sum_of_stills(void **state)
{
    enum { W = 48, H = 36, STILLS = 64, TURNS = 2 };
    static const char *const integrators[] = {"whitted", "path", "ao"};
    static const float shutter[][2] = {{0, 1}, {0.5f, 0.75f}, {0, 1}};
    rt_instance id = add_propeller();
    (void)state;
    for (int k = 0; k < 3; k++) {
        rt_render_desc rd = settings(W, H, 4, integrators[k]);
        rd.ao_distance = 1;
        rt_camera_desc c = rt_camera_desc_default();
        double square = 0, mean = 0, *sum = calloc(3 * W * H, sizeof *sum);
        rt_transform motion[TURNS], t;
        rt_image *image;
        const float *p;
        for (int i = 0; i < STILLS; i++) {
            t = propeller_at(shutter[k][0] + (i + 0.5) / STILLS * (shutter[k][1] - shutter[k][0]));
            OK(rt_scene_set_instance_transform(scene, id, &t));
            OK(rt_scene_commit(scene, NULL));
            rd.seed = (uint64_t)i;
            image = render(scene, &rd);
            for (int at = 0; at < W * H; at++)
                for (int ch = 0; ch < 3; ch++)
                    sum[3 * at + ch] += (double)rt_image_pixels_const(image)[4 * at + ch] / STILLS;
            rt_image_destroy(image);
        }
        t = propeller_at(0);
        for (int i = 0; i < TURNS; i++)
            motion[i] = propeller_at((i + 1.0) / TURNS);
        OK(rt_scene_set_instance_transform(scene, id, &t));
        OK(rt_scene_set_instance_motion(scene, id, motion, TURNS));
        OK(rt_scene_get_camera(scene, &c));
        c.shutter_open = shutter[k][0];
        c.shutter_close = shutter[k][1];
        OK(rt_scene_set_camera(scene, &c));
        OK(rt_scene_commit(scene, NULL));
        rd.samples = 256;
        image = render(scene, &rd);
        p = rt_image_pixels_const(image);
        for (int at = 0; at < W * H; at++)
            for (int ch = 0; ch < 3; ch++) {
                double d = (double)p[4 * at + ch] - sum[3 * at + ch];
                square += d * d / (3 * W * H);
                mean += d / (3 * W * H);
            }
        print_message("%s: a moving body against 64 stills: root mean square %g, mean %g\n", integrators[k], sqrt(square), mean);
        assert_true(sqrt(square) < 0.02 && fabs(mean) < 0.002);
        free(sum);
        rt_image_destroy(image);
    }
}

/* ---- edits, files, refusals ---- */

static void edits_and_refusals(void **state)
{
    rt_scene *again;
    rt_instance id = add_propeller();
    rt_instance_desc d = rt_instance_desc_default();
    rt_transform one[2] = {propeller_at(0.5), propeller_at(1)}, bad;
    rt_motion_info info;
    rt_vec3 lo, hi, lo2, hi2;
    char still[33], moves[33], back[33];
    rt_ray ray = {v3(0, 0.2f, 9), 0, v3(0, 0, -1), INFINITY, ~0u};
    float late = 0.5f;
    rt_hit a, b;
    (void)state;
    OK(rt_scene_commit(scene, NULL));
    OK(rt_scene_hash(scene, still));
    OK(rt_scene_get_motion_info(scene, &info));
    assert_true(info.moving_instances == 0 && info.places == 0 && !info.camera_moves && info.shutter_open == 0 &&
                info.shutter_close == 1);
    bad = rt_transform_identity(); /* places that are all the same stand still */
    OK(rt_scene_set_instance_motion(scene, id, &bad, 1));
    OK(rt_scene_commit(scene, NULL));
    OK(rt_scene_hash(scene, back));
    assert_string_equal(still, back);
    OK(rt_scene_bounds(scene, &lo, &hi));
    OK(rt_scene_set_instance_motion(scene, id, one, 2));
    OK(rt_scene_commit(scene, NULL));
    OK(rt_scene_hash(scene, moves));
    assert_string_not_equal(still, moves);
    OK(rt_scene_get_motion_info(scene, &info));
    assert_true(info.moving_instances == 1 && info.places == 3);
    OK(rt_scene_bounds(scene, &lo2, &hi2));
    assert_true(hi2.y > hi.y + 0.3f && hi2.y < 1.6f);
    bad = rt_transform_scale(v3(1, 0, 1));
    KIT_REFUSED(ctx, rt_scene_set_instance_motion(scene, id, &bad, 1), "motion has no inverse");
    bad = rt_transform_scale(v3(-1, 1, 1));
    KIT_REFUSED(ctx, rt_scene_set_instance_motion(scene, id, &bad, 1),
                "the places of motion mirror space at one place and not at the next");
    bad = rt_transform_scale(v3(1, 20000, 1));
    KIT_REFUSED(ctx, rt_scene_set_instance_motion(scene, id, &bad, 1), "stretch by more than 1000 to 1");
    bad = rt_transform_scale(v3(1e10f, 1e10f, 1e10f));
    KIT_REFUSED(ctx, rt_scene_set_instance_motion(scene, id, &bad, 1), "1e-9 to 1e9");
    bad = rt_transform_identity();
    bad.m[5] = NAN;
    KIT_REFUSED(ctx, rt_scene_set_instance_motion(scene, id, &bad, 1), "is nan");
    KIT_REFUSED(ctx, rt_scene_set_instance_motion(scene, id, one, 1025), "motion_count is 1025; it must be at most 1024");
    KIT_REFUSED(ctx, rt_scene_set_instance_motion(scene, id, NULL, 1), "motion is NULL");
    KIT_REFUSED(ctx, rt_scene_set_instance_motion(scene, (rt_instance){9}, one, 1), "instance 9 is not one of the scene");
    d.child = child;
    d.motion = &bad;
    d.motion_count = 1;
    KIT_REFUSED(ctx, rt_scene_add_instance(scene, &d, NULL), "is nan");
    OK(rt_scene_commit(scene, NULL));
    OK(rt_scene_hash(scene, back));
    assert_string_equal(moves, back);
    OK(rt_scene_save(scene, "test_motion.rts"));
    OK(rt_scene_load(ctx, "test_motion.rts", &again));
    remove("test_motion.rts");
    OK(rt_scene_hash(again, back));
    assert_string_equal(moves, back);
    rt_scene_intersect_at(scene, &ray, &late, &a, 1);
    rt_scene_intersect_at(again, &ray, &late, &b, 1);
    assert_memory_equal(&a, &b, sizeof a);
    assert_true(a.inst_id == id.id);
    rt_scene_intersect(scene, &ray, &b, 1);
    assert_true(b.t != a.t);
    OK(rt_scene_get_motion_info(again, &info));
    assert_true(info.moving_instances == 1 && info.places == 3);
    rt_scene_destroy(again);
    OK(rt_scene_set_instance_motion(scene, id, NULL, 0));
    OK(rt_scene_commit(scene, NULL));
    OK(rt_scene_hash(scene, back));
    assert_string_equal(still, back);
    OK(rt_scene_set_instance_motion(scene, id, one, 2));
    OK(rt_scene_remove_instance(scene, id));
    OK(rt_scene_commit(scene, NULL));
}

#define T(name) cmocka_unit_test_setup_teardown(name, setup, teardown)
int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ways_meet_their_places),
        cmocka_unit_test(turns_are_even),
        cmocka_unit_test(boxes_hold_all_times),
        T(tracers_agree),
        T(a_time_is_a_still),
        T(blur_is_a_sum_of_stills),
        T(edits_and_refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
