/* Trees from outside: cells tile their box, counts are the statistics', a plane's polygons tile its rectangle, outlines lie in
 * the plane and close, costs are the tracer's and the model's. */
#include <stdio.h>

#include "librt/tree.h"
#include "render_scenes.h"

/* Everything: triangles, shapes of each kind, instances of a child. */
static rt_scene *make(rt_context *ctx, rt_scene **child)
{
    rt_scene *s = kit_scene(ctx);
    rt_commit_desc c = rt_commit_desc_default();
    *child = kit_scene(ctx);
    add_shapes(s, *child);
    for (int i = 0; i < 60; i++)
        kit_sphere(s, 3.0f * sinf((float)i), 0.1f * (float)(i % 17), 3.0f * cosf(1.7f * (float)i), 0.1f + 0.01f * (float)(i % 7));
    c.accel = "kdtree,octree"; /* whose cells do not overlap */
    c.leaf_size = 4;
    c.cost_intersect = 0.25f;
    kit_ok(ctx, rt_scene_commit(*child, &c));
    kit_ok(ctx, rt_scene_commit(s, &c));
    return s;
}

typedef struct sums {
    rt_tree_cell all; /* counts added up */
    double volume, area;
    uint32_t cells, stop_at;
    const rt_tree_query *query;
    double area_normal[3];
} sums;

static double triangle_area(const double n[3], rt_vec3 a, rt_vec3 b, rt_vec3 c)
{
    double u[3] = {(double)b.x - a.x, (double)b.y - a.y, (double)b.z - a.z},
           v[3] = {(double)c.x - a.x, (double)c.y - a.y, (double)c.z - a.z};
    return 0.5 * (n[0] * (u[1] * v[2] - u[2] * v[1]) + n[1] * (u[2] * v[0] - u[0] * v[2]) + n[2] * (u[0] * v[1] - u[1] * v[0]));
}

static int add_cell(void *user, const rt_tree_cell *c)
{
    sums *s = user;
    double area = 0;
    s->volume += ((double)c->high.x - c->low.x) * ((double)c->high.y - c->low.y) * ((double)c->high.z - c->low.z);
    s->all.leaves += c->leaves;
    s->all.empty_leaves += c->empty_leaves;
    s->all.references += c->references;
    s->all.deepest = c->deepest > s->all.deepest ? c->deepest : s->all.deepest;
    s->all.largest = c->largest > s->all.largest ? c->largest : s->all.largest;
    assert_true(c->leaves >= 1 && c->depth <= c->deepest && c->depth <= s->query->max_depth);
    assert_true(c->leaves > 1 || (c->depth == c->deepest && c->references == c->largest));
    if (s->query->cut) {
        assert_true(c->corner_count >= 3 && c->corner_count <= 6);
        for (uint32_t i = 2; i < c->corner_count; i++)
            area += triangle_area(s->area_normal, c->corners[0], c->corners[i - 1], c->corners[i]);
        for (uint32_t i = 0; i < c->corner_count; i++) {
            rt_vec3 p = c->corners[i];
            assert_true(p.x >= c->low.x && p.x <= c->high.x && p.y >= c->low.y && p.y <= c->high.y && p.z >= c->low.z &&
                        p.z <= c->high.z);
        }
    } else {
        assert_int_equal(c->corner_count, 0);
    }
    s->area += fabs(area);
    s->cells++;
    return s->cells == s->stop_at;
}

static sums walk(rt_scene *s, const rt_tree_query *q)
{
    sums r = {.query = q};
    double l = sqrt((double)q->normal.x * q->normal.x + (double)q->normal.y * q->normal.y + (double)q->normal.z * q->normal.z);
    r.area_normal[0] = q->normal.x / l;
    r.area_normal[1] = q->normal.y / l;
    r.area_normal[2] = q->normal.z / l;
    kit_ok(rt_scene_context(s), rt_scene_tree_cells(s, q, add_cell, &r));
    return r;
}

static rt_tree_shape shape_of(rt_scene *s, const rt_tree_query *q)
{
    rt_tree_shape b;
    kit_ok(rt_scene_context(s), rt_scene_tree_shape(s, q, &b));
    return b;
}

/* What a builder's name stands for, and what is said beside it. */
static void test_builders_costs(void **state)
{
    rt_context *ctx = make_context(1);
    rt_scene *s = kit_scene(ctx);
    rt_tree_query q = rt_tree_query_default();
    rt_commit_desc d = rt_commit_desc_default();
    (void)state;
    kit_square(s, 1.0f, 0.0f);
    q.tracer = "kdtree";
    d.builder = "exact";
    kit_ok(ctx, rt_scene_commit(s, &d));
    assert_true(shape_of(s, &q).cost_intersect == 0.0078125f);
    for (int i = 0; i < 2; i++) { /* as many shapes are met one by one */
        kit_sphere(s, 3.0f, 2.0f * (float)i, 0.0f, 0.5f);
        kit_ok(ctx, rt_scene_commit(s, &d));
        assert_true(i > 0 || shape_of(s, &q).cost_intersect == 0.0078125f);
    }
    assert_true(shape_of(s, &q).cost_intersect == 1.0f);
    d.builder = "paper"; /* as published: a triangle costs a step */
    kit_ok(ctx, rt_scene_commit(s, &d));
    assert_true(shape_of(s, &q).cost_intersect == 1.0f && shape_of(s, &q).cost_traverse == 1.0f);
    d.cost_intersect = 3.0f;
    kit_ok(ctx, rt_scene_commit(s, &d));
    assert_true(shape_of(s, &q).cost_intersect == 3.0f);
    rt_scene_destroy(s);
    rt_context_destroy(ctx);
}

/* ---- cells ---- */

static void test_leaves_are_the_statistics(void **state)
{
    rt_context *ctx = make_context(1);
    rt_scene *child, *s = make(ctx, &child);
    rt_scene_info info;
    (void)state;
    kit_ok(ctx, rt_scene_get_info(s, &info));
    assert_int_equal(info.tree_count, 6); /* two groups and the top, two kinds each */
    for (uint32_t i = 0; i < info.tree_count; i++) {
        rt_tree_query q = rt_tree_query_default();
        rt_tree_info t;
        rt_tree_shape b;
        sums r;
        kit_ok(ctx, rt_scene_get_tree_info(s, i, &q.group, &t));
        q.tracer = t.name;
        r = walk(s, &q);
        b = shape_of(s, &q);
        assert_int_equal(r.cells, t.leaves);
        assert_int_equal(r.all.leaves, t.leaves);
        assert_int_equal(r.all.empty_leaves, t.empty_leaves);
        assert_int_equal(r.all.references, t.references);
        assert_int_equal(r.all.deepest, t.depth);
        assert_int_equal(r.all.largest, t.largest_leaf);
        near_to(r.volume / (((double)b.high.x - b.low.x) * ((double)b.high.y - b.low.y) * ((double)b.high.z - b.low.z)), 1, 1e-6);
        assert_true(b.sah_cost == t.sah_cost && b.cost_traverse > 0 && b.cost_intersect > 0);
    }
    rt_scene_destroy(s);
    rt_scene_destroy(child);
    rt_context_destroy(ctx);
}

/* However little of the tree is shown, what is shown stands for all of it. */
static void test_whole_cells(void **state)
{
    rt_context *ctx = make_context(1);
    rt_scene *child, *s = make(ctx, &child);
    (void)state;
    for (int k = 0; k < 2; k++) {
        rt_tree_query q = rt_tree_query_default();
        sums full, part;
        q.tracer = k ? "octree" : "kdtree";
        full = walk(s, &q);
        for (uint32_t depth = 0; depth < 12; depth++) {
            q.max_depth = depth;
            part = walk(s, &q);
            assert_true(part.cells <= full.cells && part.cells >= 1 && (depth > 0 || part.cells == 1));
            assert_int_equal(part.all.leaves, full.all.leaves);
            assert_int_equal(part.all.references, full.all.references);
            assert_int_equal(part.all.deepest, full.all.deepest);
            near_to(part.volume / full.volume, 1, 1e-6);
        }
        q.max_depth = RT_INVALID_ID;
        q.min_size = 0.8f;
        part = walk(s, &q);
        assert_true(part.cells < full.cells);
        assert_int_equal(part.all.leaves, full.all.leaves);
        near_to(part.volume / full.volume, 1, 1e-6);
    }
    rt_scene_destroy(s);
    rt_scene_destroy(child);
    rt_context_destroy(ctx);
}

/* The polygon of the root box alone has the area of all the leaves' polygons, for planes along the axes (through faces of cells
 * too) and across. */
static void test_cut_tiles(void **state)
{
    rt_context *ctx = make_context(1);
    rt_scene *child, *s = make(ctx, &child);
    static const rt_vec3 normals[] = {{1, 0, 0},     {0, -3, 0},    {0, 0, 1e-6f},   {1, 1, 1},
                                      {1, -2, 0.3f}, {0, 1, 1e-3f}, {-4, 0.5f, 0.5f}};
    (void)state;
    uint32_t cells = 0;
    for (uint32_t i = 0; i < 2 * 7 * 5; i++) {
        rt_tree_query q = rt_tree_query_default();
        rt_tree_shape b;
        sums whole, leaves;
        float w = 0.1f + 0.2f * (float)(i / 14);
        q.tracer = i % 2 ? "octree" : "kdtree";
        b = shape_of(s, &q);
        q.cut = 1;
        q.normal = normals[i / 2 % 7];
        q.point = v3(b.low.x + w * (b.high.x - b.low.x), b.low.y + w * (b.high.y - b.low.y), b.low.z + w * (b.high.z - b.low.z));
        leaves = walk(s, &q);
        q.max_depth = 0;
        whole = walk(s, &q);
        assert_int_equal(whole.cells, 1);
        cells += leaves.cells;
        near_to(leaves.area / whole.area, 1, 1e-5);
    }
    assert_true(cells > 700);
    rt_scene_destroy(s);
    rt_scene_destroy(child);
    rt_context_destroy(ctx);
}

/* Through a face of the octree's cells: one side has it, the other not. */
static void test_cut_on_a_face(void **state)
{
    rt_context *ctx = make_context(1);
    rt_scene *child, *s = make(ctx, &child);
    rt_tree_query q = rt_tree_query_default();
    rt_tree_shape b;
    sums r;
    (void)state;
    q.tracer = "octree";
    b = shape_of(s, &q);
    q.cut = 1;
    q.normal = v3(1, 0, 0);
    q.point = v3(0.5f * (b.low.x + b.high.x), 0, 0);
    r = walk(s, &q);
    near_to(r.area / (((double)b.high.y - b.low.y) * ((double)b.high.z - b.low.z)), 1, 1e-6);
    q.point.x = b.high.x;
    near_to(walk(s, &q).area / r.area, 1, 1e-6);
    q.point.x = b.low.x; /* nothing lies below */
    assert_int_equal(walk(s, &q).cells, 0);
    q.normal.x = -1;
    near_to(walk(s, &q).area / r.area, 1, 1e-6);
    q.point.x = b.high.x * 2;
    assert_int_equal(walk(s, &q).cells, 0);
    rt_scene_destroy(s);
    rt_scene_destroy(child);
    rt_context_destroy(ctx);
}

/* ---- outlines ---- */

typedef struct outline {
    rt_vec3 point, normal;
    double length;
    uint32_t pieces, insts, stop_at;
    double gap; /* sum of from - to: zero around closed curves */
    double low, high;
} outline;

static int add_piece(void *user, const rt_section *p)
{
    outline *o = user;
    rt_vec3 ends[2] = {p->from, p->to};
    for (int k = 0; k < 2; k++) {
        double d = ((double)ends[k].x - o->point.x) * o->normal.x + ((double)ends[k].y - o->point.y) * o->normal.y +
                   ((double)ends[k].z - o->point.z) * o->normal.z;
        near_to(d, 0, 1e-4);
    }
    o->length +=
        sqrt(pow((double)p->from.x - p->to.x, 2) + pow((double)p->from.y - p->to.y, 2) + pow((double)p->from.z - p->to.z, 2));
    o->insts += p->inst_id != RT_INVALID_ID;
    o->pieces++;
    return o->pieces == o->stop_at;
}

static outline cut(rt_scene *s, uint32_t group, rt_vec3 point, rt_vec3 normal)
{
    outline o = {.point = point, .normal = normal};
    kit_ok(rt_scene_context(s), rt_scene_cut(s, group, point, normal, add_piece, &o));
    return o;
}

static rt_scene *one_shape(rt_context *ctx, int kind)
{
    rt_scene *s = kit_scene(ctx);
    rt_cone_desc c = rt_cone_desc_default();
    rt_torus_desc t = rt_torus_desc_default();
    c.from = v3(0, -1, 0);
    c.to = v3(0, 1, 0);
    c.radius0 = 1;
    t.axis = v3(0, 1, 0);
    t.major_radius = 2;
    t.minor_radius = 0.5f;
    switch (kind) {
    case 0:
        add_sphere(s, v3(0, 0, 0), 1, (rt_material){0});
        break;
    case 1:
        add_box(s, v3(-1, -1, -1), v3(1, 1, 1), (rt_material){0});
        break;
    case 2:
        OK(rt_scene_add_cylinder(s, &c, NULL));
        break;
    case 3:
        OK(rt_scene_add_cone(s, &c, NULL));
        break;
    case 4:
        OK(rt_scene_add_torus(s, &t, NULL));
        break;
    default:
        kit_square(s, 1, 0);
    }
    kit_ok(ctx, rt_scene_commit(s, NULL));
    return s;
}

static void test_outlines(void **state)
{
    /* Lengths in the planes y = 0.5 and z = 0 (x = 0.25 for the square), by hand. */
    static const double pi = 3.14159265358979;
    const double level[] = {2 * pi * sqrt(0.75), 8, 2 * pi, 2 * pi * 0.25, 2 * pi * 4, 2};
    const double across[] = {2 * pi, 8, 8, 2 + 2 * sqrt(5), 2 * pi, 2};
    rt_context *ctx = make_context(1);
    (void)state;
    for (int kind = 0; kind < 6; kind++) {
        rt_scene *s = one_shape(ctx, kind);
        outline a = cut(s, 0, v3(0, 0.5f, 0), v3(0, 1, 0)), b = cut(s, 0, v3(0, 0, 0), v3(0, 0, 1));
        if (kind == 4)
            a = cut(s, 0, v3(0, 0, 0), v3(0, 1, 0)); /* two circles, 1.5 and 2.5 */
        if (kind == 5)
            b = cut(s, 0, v3(0.25f, 0, 0), v3(1, 0, 0));
        if (fabs(a.length - level[kind]) > 2e-3 * level[kind] || fabs(b.length - across[kind]) > 2e-3 * across[kind])
            fail_msg("shape %d: %g, %g; want %g, %g", kind, a.length, b.length, level[kind], across[kind]);
        assert_int_equal(cut(s, 0, v3(0, 30, 0), v3(0, 1, 0)).pieces, 0);
        rt_scene_destroy(s);
    }
    rt_context_destroy(ctx);
}

/* Instances are cut where they stand: scaled by two, moved, turned. */
static void test_outlines_of_instances(void **state)
{
    rt_context *ctx = make_context(1);
    rt_scene *s = kit_scene(ctx), *child = one_shape(ctx, 0);
    rt_instance_desc in = rt_instance_desc_default();
    outline o;
    (void)state;
    in.child = child;
    in.transform =
        rt_transform_multiply(rt_transform_translate(v3(5, 0, 0)),
                              rt_transform_multiply(rt_transform_rotate(v3(1, 1, 0), 40), rt_transform_scale(v3(2, 2, 2))));
    OK(rt_scene_add_instance(s, &in, NULL));
    kit_ok(ctx, rt_scene_commit(s, NULL));
    o = cut(s, RT_INVALID_ID, v3(5, 0, 0), v3(0, 1, 0));
    near_to(o.length, 4 * 3.14159265, 1e-2);
    assert_int_equal(o.insts, o.pieces);
    assert_int_equal(cut(s, 0, v3(5, 0, 0), v3(0, 1, 0)).pieces, 0);
    near_to(cut(s, 1, v3(0, 0, 0), v3(1, 1, 1)).length, 2 * 3.14159265, 1e-2);
    rt_scene_destroy(s);
    rt_scene_destroy(child);
    rt_context_destroy(ctx);
}

/* ---- costs ---- */

/* A line whose chance to cross a convex body is as its surface: through a random point of a disc on a sphere around the box. */
static rt_ray random_line(const rt_tree_shape *b, uint32_t *seed)
{
    rt_vec3 c = v3(0.5f * (b->low.x + b->high.x), 0.5f * (b->low.y + b->high.y), 0.5f * (b->low.z + b->high.z));
    float r = 0.5f * sqrtf(powf(b->high.x - b->low.x, 2) + powf(b->high.y - b->low.y, 2) + powf(b->high.z - b->low.z, 2));
    float z = 2 * kit_unit(seed) - 1, phi = 6.2831853f * kit_unit(seed), q = sqrtf(1 - z * z), rho = r * sqrtf(kit_unit(seed)),
          psi = 6.2831853f * kit_unit(seed);
    rt_vec3 d = v3(q * cosf(phi), q * sinf(phi), z), u = v3(-sinf(phi), cosf(phi), 0), v = v3(-z * cosf(phi), -z * sinf(phi), q);
    float x = rho * cosf(psi), y = rho * sinf(psi);
    rt_ray ray = kit_ray(c.x + x * u.x + y * v.x - 2 * r * d.x, c.y + x * u.y + y * v.y - 2 * r * d.y,
                         c.z + x * u.z + y * v.z - 2 * r * d.z, d.x, d.y, d.z);
    ray.mask = 0; /* sees nothing: never ends */
    return ray;
}

/* What the model predicts is what random lines that never end cost, for every tree of a group. */
static void test_model_is_right(void **state)
{
    enum { N = 200000 };
    rt_context *ctx = make_context(1);
    rt_scene *child, *s = make(ctx, &child);
    rt_ray *rays = malloc(N * sizeof *rays);
    rt_ray_cost *costs = malloc(N * sizeof *costs);
    (void)state;
    for (uint32_t k = 0; k < 4; k++) {
        rt_tree_query q = rt_tree_query_default();
        rt_tree_shape b;
        uint32_t seed = 7, crossed = 0;
        double sum = 0;
        q.tracer = k % 2 ? "octree" : "kdtree";
        q.group = k / 2;
        b = shape_of(s, &q);
        for (uint32_t i = 0; i < N; i++)
            rays[i] = random_line(&b, &seed);
        kit_ok(ctx, rt_scene_ray_costs(s, &q, rays, costs, N));
        for (uint32_t i = 0; i < N; i++) {
            sum += (double)b.cost_traverse * costs[i].nodes + (double)b.cost_intersect * costs[i].tests;
            crossed += costs[i].nodes + costs[i].leaves > 0;
        }
        assert_true(crossed > N / 10);
        near_to(sum / crossed / b.sah_cost, 1, 0.02);
    }
    free(rays);
    free(costs);
    rt_scene_destroy(s);
    rt_scene_destroy(child);
    rt_context_destroy(ctx);
}

/* Counts are those of the view "steps", which come through a render. */
static void test_costs_are_the_renders(void **state)
{
    static const char *const names[] = {"kdtree", "octree", "brute"};
    rt_context *ctx = make_context(1);
    rt_scene *child, *s = make(ctx, &child);
    rt_render_desc d = settings(9, 7, 1, "steps");
    (void)state;
    for (int k = 0; k < 3; k++) {
        rt_tree_query q = rt_tree_query_default();
        rt_image *image;
        double most = 0;
        d.tracer = q.tracer = names[k];
        q.group = RT_INVALID_ID;
        image = render(s, &d);
        for (uint32_t y = 0; y < 7; y++) {
            for (uint32_t x = 0; x < 9; x++) {
                /* The camera of add_shapes: eye (0.5, 2.8, 7) to (0, 0.8, 0), 40 degrees. */
                const float *p = pixel(image, x, y);
                assert_true(p[0] == floorf(p[0]) && p[2] > 0);
                most += p[0] + p[1] + p[2];
            }
        }
        assert_true(k == 2 ? pixel(image, 0, 0)[0] == 0 : most > 100);
        rt_image_destroy(image);
        rt_ray ray = kit_ray(0.5f, 2.8f, 7, -0.5f, -2, -7);
        rt_ray_cost c, none;
        kit_ok(ctx, rt_scene_ray_costs(s, &q, &ray, &c, 1));
        d.width = d.height = 1; /* one pixel: its middle is the camera's axis */
        image = render(s, &d);
        near_to(c.nodes, pixel(image, 0, 0)[0], 0);
        near_to(c.leaves, pixel(image, 0, 0)[1], 0);
        near_to(c.tests, pixel(image, 0, 0)[2], 0);
        rt_image_destroy(image);
        d = settings(9, 7, 1, "steps");
        ray.mask = 0;
        kit_ok(ctx, rt_scene_ray_costs(s, &q, &ray, &none, 1));
        q.group = 0;
        kit_ok(ctx, rt_scene_ray_costs(s, &q, &ray, &none, 1));
        assert_true(none.tests > 0);
    }
    rt_scene_destroy(s);
    rt_scene_destroy(child);
    rt_context_destroy(ctx);
}

/* ---- refusals ---- */

static void test_refused(void **state)
{
    rt_context *ctx = make_context(1);
    rt_scene *child, *bare = kit_scene(ctx), *s = make(ctx, &child);
    rt_tree_query q = rt_tree_query_default();
    rt_tree_shape b;
    rt_ray ray = kit_ray(0, 0, 0, 0, 0, 1);
    rt_ray_cost cost;
    sums r = {.query = &q};
    outline o = {.normal = {0, 1, 0}, .stop_at = 3};
    (void)state;
    assert_int_equal(rt_scene_tree_cells(bare, &q, add_cell, &r), RT_ERROR_STATE);
    assert_int_equal(rt_scene_cut(bare, 0, v3(0, 0, 0), v3(0, 1, 0), add_piece, &o), RT_ERROR_STATE);
    kit_ok(ctx, rt_scene_commit(bare, NULL));
    kit_ok(ctx, rt_scene_tree_cells(bare, &q, add_cell, &r));
    assert_int_equal(r.cells, 0);
    kit_ok(ctx, rt_scene_tree_shape(bare, &q, &b));
    assert_true(b.low.x > b.high.x);
    q.group = 2;
    assert_int_equal(rt_scene_tree_cells(s, &q, add_cell, &r), RT_ERROR_ARGUMENT);
    kit_says(ctx, "groups 0 ... 1");
    assert_int_equal(rt_scene_ray_costs(s, &q, &ray, &cost, 1), RT_ERROR_ARGUMENT);
    assert_int_equal(rt_scene_cut(s, 2, v3(0, 0, 0), v3(0, 1, 0), add_piece, &o), RT_ERROR_ARGUMENT);
    q.group = 0;
    q.tracer = "brute";
    assert_int_equal(rt_scene_tree_cells(s, &q, add_cell, &r), RT_ERROR_ARGUMENT);
    kit_says(ctx, "walks no tree");
    kit_ok(ctx, rt_scene_ray_costs(s, &q, &ray, &cost, 1));
    q.tracer = "grid";
    assert_int_equal(rt_scene_tree_cells(s, &q, add_cell, &r), RT_ERROR_ARGUMENT);
    kit_says(ctx, "\"grid\"");
    q.tracer = "kdtree";
    q.cut = 1;
    q.normal = v3(0, 0, 0);
    assert_int_equal(rt_scene_tree_cells(s, &q, add_cell, &r), RT_ERROR_ARGUMENT);
    q.normal = v3(0, NAN, 1);
    assert_int_equal(rt_scene_tree_cells(s, &q, add_cell, &r), RT_ERROR_ARGUMENT);
    q.cut = 0;
    q.min_size = NAN;
    assert_int_equal(rt_scene_tree_cells(s, &q, add_cell, &r), RT_ERROR_ARGUMENT);
    q.min_size = 0;
    assert_int_equal(rt_scene_tree_cells(s, &q, NULL, &r), RT_ERROR_ARGUMENT);
    assert_int_equal(rt_scene_tree_shape(s, &q, NULL), RT_ERROR_ARGUMENT);
    assert_int_equal(rt_scene_cut(s, 0, v3(0, 0, 0), v3(0, 0, 0), add_piece, &o), RT_ERROR_ARGUMENT);
    assert_int_equal(rt_scene_ray_costs(s, &q, NULL, &cost, 1), RT_ERROR_ARGUMENT);
    r.stop_at = 2;
    r.cells = 0;
    assert_int_equal(rt_scene_tree_cells(s, &q, add_cell, &r), RT_ERROR_CANCELLED);
    assert_int_equal(r.cells, 2);
    o.point = v3(0, 0.5f, 0);
    assert_int_equal(rt_scene_cut(s, 0, o.point, o.normal, add_piece, &o), RT_ERROR_CANCELLED);
    assert_int_equal(o.pieces, 3);
    rt_scene_destroy(bare);
    rt_scene_destroy(s);
    rt_scene_destroy(child);
    rt_context_destroy(ctx);
}

/* A tree that the commit did not make is made when it is asked for. */
static void test_missing_tree_is_built(void **state)
{
    rt_context *ctx = make_context(1);
    rt_scene *s = kit_scene(ctx);
    rt_commit_desc c = rt_commit_desc_default();
    rt_tree_query q = rt_tree_query_default();
    (void)state;
    add_everything(s);
    c.accel = "brute";
    kit_ok(ctx, rt_scene_commit(s, &c));
    q.tracer = "octree";
    assert_true(walk(s, &q).cells >= 1);
    rt_scene_destroy(s);
    rt_context_destroy(ctx);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_leaves_are_the_statistics),
        cmocka_unit_test(test_whole_cells),
        cmocka_unit_test(test_cut_tiles),
        cmocka_unit_test(test_cut_on_a_face),
        cmocka_unit_test(test_outlines),
        cmocka_unit_test(test_outlines_of_instances),
        cmocka_unit_test(test_model_is_right),
        cmocka_unit_test(test_builders_costs),
        cmocka_unit_test(test_costs_are_the_renders),
        cmocka_unit_test(test_refused),
        cmocka_unit_test(test_missing_tree_is_built),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
