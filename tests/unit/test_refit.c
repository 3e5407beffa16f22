/* Meshes whose vertices move: the hits of refitted trees are brute force's, what is refitted and what is built, and what is
 * refused. */
#include <math.h>

#include "accel/bvh_order.h"
#include "scene_kit.h"

#include "librt/trace.h"
#include "scene/parts.h"
#include "../support/many.h"

enum { N = 40, VERTICES = (N + 1) * (N + 1), TRIANGLES = 2 * N * N, RAYS = 3000 };

/* A sheet of N x N quads over [-1, 1]^2. */
typedef struct sheet {
    float rest[3 * VERTICES], now[3 * VERTICES];
    uint32_t indices[3 * TRIANGLES];
} sheet;

static void sheet_make(sheet *s)
{
    uint32_t *to = s->indices;
    for (uint32_t i = 0; i < VERTICES; i++) {
        float *p = s->rest + 3 * i;
        p[0] = 2.0f * (float)(i % (N + 1)) / N - 1.0f;
        p[1] = 2.0f * (float)(i / (N + 1)) / N - 1.0f;
        p[2] = 0.0f;
    }
    for (uint32_t y = 0; y < N; y++) {
        for (uint32_t x = 0; x < N; x++) {
            uint32_t a = y * (N + 1) + x, quad[6] = {a, a + 1, a + N + 1, a + 1, a + N + 2, a + N + 1};
            memcpy(to, quad, sizeof quad);
            to += 6;
        }
    }
    memcpy(s->now, s->rest, sizeof s->now);
}

enum { REST, WAVE, TWIST, ROLL, SCRAMBLE, POINT, HUGE_ONE, FLAT, WAYS };

static void sheet_move(sheet *s, int way, float by)
{
    uint32_t seed = 7;
    for (uint32_t i = 0; i < VERTICES; i++) {
        const float *p = s->rest + 3 * i;
        float *q = s->now + 3 * i, a = by * p[1];
        memcpy(q, p, 3 * sizeof *q);
        switch (way) {
        case WAVE:
            q[2] = 0.2f * sinf(5.0f * p[0] + by) + 0.1f * cosf(4.0f * p[1] + by);
            break;
        case TWIST:
            q[0] = p[0] * cosf(a);
            q[2] = p[0] * sinf(a);
            break;
        case ROLL:
            q[1] = sinf(a);
            q[2] = cosf(a);
            break;
        case SCRAMBLE: {
            rt_vec3 r = kit_vec(&seed, by);
            q[0] = r.x, q[1] = r.y, q[2] = r.z;
            break;
        }
        case POINT:
            q[0] = q[1] = q[2] = by;
            break;
        case HUGE_ONE:
            q[2] = i == 5 ? by : 0.0f;
            break;
        case FLAT:
            q[0] = 0.0f;
            break;
        default:
            break;
        }
    }
}

static rt_geometry sheet_add(rt_scene *scene, const sheet *s)
{
    rt_mesh_desc d = rt_mesh_desc_default();
    rt_geometry g;
    d.positions = s->rest;
    d.vertex_count = VERTICES;
    d.indices = s->indices;
    d.triangle_count = TRIANGLES;
    kit_ok(rt_scene_context(scene), rt_scene_add_mesh(scene, &d, &g));
    return g;
}

static rt_status set(rt_scene *scene, rt_geometry g, const sheet *s)
{
    return rt_scene_set_mesh_positions(scene, g, s->now, NULL, VERTICES);
}

/* ---- hits ---- */

/* From around at points of the moved sheet, and from its vertices anywhere. */
static void aim(const sheet *s, rt_ray *rays, uint32_t count)
{
    uint32_t seed = 3;
    for (uint32_t i = 0; i < count; i++) {
        const float *v = s->now + 3 * (uint32_t)kit_range(&seed, 0.0f, VERTICES - 1.0f);
        rt_vec3 at = {v[0], v[1], v[2]}, from = kit_vec(&seed, 3.0f), off = kit_vec(&seed, i % 3 ? 0.03f : 0.0f);
        if (i % 4 == 0)
            from = (rt_vec3){at.x + 0.01f * from.x, at.y + 0.01f * from.y, at.z + 0.01f * from.z};
        rays[i] = kit_ray(from.x, from.y, from.z, at.x + off.x - from.x, at.y + off.y - from.y, at.z + off.z - from.z);
        if (i % 16 < 8) /* some side by side, for packets */
            rays[i] = kit_ray(at.x, at.y, 5.0f, off.x, off.y, -1.0f);
    }
}

static void hits_are_those_of_brute_force(rt_scene *scene, const sheet *s, rt_ray *rays, rt_hit *hits, rt_hit *truth,
                                          uint32_t count)
{
    rt_tracer *brute, *bvh;
    rt_context *ctx = rt_scene_context(scene);
    uint8_t *dark = (uint8_t *)hits;
    aim(s, rays, count);
    kit_ok(ctx, rt_tracer_create(scene, "brute", &brute));
    kit_ok(ctx, rt_tracer_create(scene, "bvh", &bvh));
    rt_tracer_intersect(brute, rays, truth, count, 0);
    for (uint32_t hints = 0; hints < 4; hints++) {
        rt_tracer_intersect(bvh, rays, hits, count, hints);
        assert_memory_equal(hits, truth, count * sizeof *hits);
        rt_tracer_occluded(bvh, rays, dark, count, hints);
        for (uint32_t i = 0; i < count; i++)
            assert_int_equal(dark[i], truth[i].prim_id != RT_INVALID_ID);
    }
    rt_tracer_destroy(brute);
    rt_tracer_destroy(bvh);
}

static void slots_are_in_order(const rtk_tree_header *h, const rtk_tree *tree)
{
    rtk_bvhnode *nodes = malloc(h->node_count * sizeof *nodes);
    rti_bvh_below *below = malloc(h->node_count * sizeof *below);
    const rti_bvh_order order = {nodes, tree->blocks, tree->block_count, rti_bvh_unit(h->lo, h->hi), below, NULL};
    assert_true(nodes && below);
    memcpy(nodes, tree->bvh, h->node_count * sizeof *nodes);
    for (uint32_t n = h->node_count; n-- > 0;)
        rti_bvh_order_node(&order, n);
    assert_memory_equal(nodes, tree->bvh, h->node_count * sizeof *nodes);
    free(below);
    free(nodes);
}

/* Every slot's box holds its children's or its triangles', slots stand in the builder's order, and the tree passes the checks of
 * files. */
static void tree_is_sound(const rt_scene *scene)
{
    rti_snapshot *s = rti_scene_snapshot(scene);
    const rtk_group *g = &rti_snapshot_view(s)->groups[0];
    for (uint32_t p = 0; p < g->part_count; p++) {
        const rti_chunk *chunk = s->groups[0].tree[p][RTK_TREE_BVH];
        const rtk_tree_header *h = chunk->data;
        assert_true(rti_tree_valid(chunk->data, chunk->size, g->tri_count + g->shape_count));
        assert_true(rti_tree_copies_valid(chunk->data, g->tris, g->tri_count, g->shapes));
        assert_true(h->sah_cost == rti_tree_sah(h));
        slots_are_in_order(h, &g->parts[p].bvh);
        for (uint32_t n = 0; n < h->node_count; n++) {
            const rtk_bvhnode *node = &g->parts[p].bvh.bvh[n];
            for (uint32_t i = 0; i < RTK_BVH_WIDTH && node->child[i] + node->count[i] > 0; i++) {
                for (int a = 0; a < 3 && node->count[i] == 0; a++) {
                    for (uint32_t k = 0; k < RTK_BVH_WIDTH; k++) {
                        const rtk_bvhnode *child = &g->parts[p].bvh.bvh[node->child[i]];
                        if (child->child[k] + child->count[k] == 0)
                            continue;
                        assert_true(node->box[a][0][i] <= child->box[a][0][k] && node->box[a][1][i] >= child->box[a][1][k]);
                    }
                }
            }
        }
    }
    rti_snapshot_release(s);
}

/* builder: of the BVH. Other things stand beside the sheet: a sphere, a square. */
static void any_shape(rt_context *ctx, const char *builder, bool refits)
{
    sheet *s = malloc(sizeof *s);
    rt_ray *rays = malloc(RAYS * sizeof *rays);
    rt_hit *hits = malloc(RAYS * sizeof *hits), *truth = malloc(RAYS * sizeof *truth);
    rt_scene *scene = kit_scene(ctx);
    rt_commit_desc d = rt_commit_desc_default();
    rt_geometry g;
    static const struct {
        int way;
        float by;
    } moves[] = {{WAVE, 0.3f}, {WAVE, 1.0f},     {TWIST, 2.0f}, {ROLL, 2.5f},      {SCRAMBLE, 1.0f}, {POINT, 0.25f},
                 {WAVE, 2.0f}, {SCRAMBLE, 0.3f}, {POINT, 0.0f}, {HUGE_ONE, 20.0f}, {FLAT, 0.0f},     {TWIST, 9.0f}};
    assert_true(s && rays && hits && truth);
    sheet_make(s);
    g = sheet_add(scene, s);
    kit_sphere(scene, 0.2f, 0.1f, 0.5f, 0.3f);
    kit_square(scene, 1.5f, -1.0f);
    d.builder = builder;
    d.refit = 1.0e6f; /* whatever it costs */
    kit_ok(ctx, rt_scene_commit(scene, &d));
    for (size_t i = 0; i < sizeof moves / sizeof *moves; i++) {
        /* What lies in one point has all triangles in every leaf that a ray through it enters. */
        uint32_t count = moves[i].way == POINT ? 60 : TEST_MANY(RAYS);
        sheet_move(s, moves[i].way, moves[i].by);
        kit_ok(ctx, set(scene, g, s));
        kit_ok(ctx, rt_scene_commit(scene, NULL));
        assert_int_equal(kit_info(scene).refitted_trees, refits);
        assert_int_equal(kit_info(scene).built_trees, !refits);
        hits_are_those_of_brute_force(scene, s, rays, hits, truth, count);
        tree_is_sound(scene);
    }
    rt_scene_destroy(scene);
    free(s);
    free(rays);
    free(hits);
    free(truth);
}

static void test_hits(void **state)
{
    rt_context *ctx = kit_context(NULL, 2);
    (void)state;
    any_shape(ctx, "auto", true);
    any_shape(ctx, "compact", true);
    any_shape(ctx, "spatial", false);
    rt_context_destroy(ctx);
}

/* Any number of workers, the same bytes. */
static void test_workers(void **state)
{
    sheet *s = malloc(sizeof *s);
    void *bytes[2] = {NULL, NULL};
    size_t sizes[2] = {0, 0};
    (void)state;
    sheet_make(s);
    for (uint32_t w = 0; w < 2; w++) {
        rt_context *ctx = kit_context(NULL, w == 0 ? 1 : 3);
        rt_scene *scene = kit_scene(ctx);
        rt_geometry g = sheet_add(scene, s);
        rti_snapshot *snapshot;
        rtk_tree_header *h;
        kit_commit(scene);
        sheet_move(s, WAVE, 0.5f);
        kit_ok(ctx, set(scene, g, s));
        kit_commit(scene);
        assert_int_equal(kit_info(scene).refitted_trees, 1);
        snapshot = rti_scene_snapshot(scene);
        sizes[w] = snapshot->groups[0].tree[0][RTK_TREE_BVH]->size;
        bytes[w] = malloc(sizes[w]);
        memcpy(bytes[w], snapshot->groups[0].tree[0][RTK_TREE_BVH]->data, sizes[w]);
        h = bytes[w];
        h->build_seconds = 0.0f;
        rti_snapshot_release(snapshot);
        rt_scene_destroy(scene);
        rt_context_destroy(ctx);
    }
    assert_int_equal(sizes[0], sizes[1]);
    assert_memory_equal(bytes[0], bytes[1], sizes[0]);
    free(bytes[0]);
    free(bytes[1]);
    free(s);
}

/* ---- what is refitted, and what is built ---- */

typedef struct counts {
    uint32_t built, kept, refitted;
} counts;

static void commit_does(rt_scene *scene, const rt_commit_desc *d, counts want)
{
    rt_scene_info i;
    rt_context *ctx = rt_scene_context(scene);
    rt_context_work_stats before = rt_context_work(ctx), now;
    kit_ok(ctx, rt_scene_commit(scene, d));
    i = kit_info(scene);
    now = rt_context_work(ctx);
    if (i.built_trees != want.built || i.kept_trees != want.kept || i.refitted_trees != want.refitted)
        fail_msg("built %u, kept %u, refitted %u; not %u, %u, %u", i.built_trees, i.kept_trees, i.refitted_trees, want.built,
                 want.kept, want.refitted);
    assert_int_equal(now.trees_refitted - before.trees_refitted, want.refitted);
}

static const counts built = {1, 0, 0}, kept = {0, 1, 0}, refitted = {0, 0, 1};

static void test_choice(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx);
    sheet *s = malloc(sizeof *s);
    rt_commit_desc d = rt_commit_desc_default();
    rt_geometry g, other;
    char rest[33], again[33];
    (void)state;
    sheet_make(s);
    g = sheet_add(scene, s);
    commit_does(scene, &d, built);
    rt_scene_hash(scene, rest);
    sheet_move(s, WAVE, 0.1f);
    kit_ok(ctx, set(scene, g, s));
    commit_does(scene, &d, refitted);
    sheet_move(s, WAVE, 0.2f);
    kit_ok(ctx, set(scene, g, s));
    commit_does(scene, &d, refitted);
    kit_ok(ctx, set(scene, g, s)); /* nothing has moved */
    commit_does(scene, &d, kept);
    commit_does(scene, NULL, kept);
    sheet_move(s, REST, 0.0f);
    kit_ok(ctx, set(scene, g, s));
    commit_does(scene, &d, kept); /* the tree that was built is better than a refitted one */
    rt_scene_hash(scene, again);
    assert_string_equal(rest, again);
    sheet_move(s, SCRAMBLE, 1.0f); /* neighbours are neighbours no more */
    kit_ok(ctx, set(scene, g, s));
    commit_does(scene, &d, built);
    sheet_move(s, POINT, 1.0f);
    kit_ok(ctx, set(scene, g, s));
    commit_does(scene, &d, built);
    sheet_move(s, WAVE, 0.3f); /* a tree of one point knows nothing of the sheet */
    kit_ok(ctx, set(scene, g, s));
    commit_does(scene, &d, built);
    sheet_move(s, WAVE, 0.4f);
    kit_ok(ctx, set(scene, g, s));
    d.refit = 0.0f;
    commit_does(scene, &d, built);
    sheet_move(s, WAVE, 0.5f);
    kit_ok(ctx, set(scene, g, s));
    d = rt_commit_desc_default();
    d.leaf_size = 3; /* other settings, another tree */
    commit_does(scene, &d, built);
    sheet_move(s, WAVE, 0.6f);
    kit_ok(ctx, set(scene, g, s));
    d.accel = "kdtree";
    commit_does(scene, &d, built);
    sheet_move(s, WAVE, 0.7f);
    kit_ok(ctx, set(scene, g, s));
    d.accel = "bvh";
    commit_does(scene, &d, built); /* there was none to refit */
    other = (rt_geometry){kit_square(scene, 1, 2)};
    sheet_move(s, WAVE, 0.8f);
    kit_ok(ctx, set(scene, g, s));
    commit_does(scene, &d, built); /* other triangles */
    kit_ok(ctx, rt_scene_remove_geometry(scene, other));
    kit_square(scene, 1, 3);
    commit_does(scene, &d, built); /* as many of them, but not the same */
    KIT_REFUSED(ctx, set(scene, other, s), "geometry 1 was removed");
    free(s);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

/* A small thing goes into a part of its own where the rest gets ten thousand times its size: other parts, other trees. */
static void test_parts(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx);
    sheet *s = malloc(sizeof *s), *big = malloc(sizeof *s);
    rt_geometry g, b;
    rt_ray *rays = malloc(RAYS * sizeof *rays);
    rt_hit *hits = malloc(RAYS * sizeof *hits), *truth = malloc(RAYS * sizeof *truth);
    (void)state;
    sheet_make(s);
    sheet_make(big);
    g = sheet_add(scene, s);
    b = sheet_add(scene, big);
    commit_does(scene, NULL, built);
    for (uint32_t i = 0; i < 3 * VERTICES; i++)
        big->now[i] = 1.0e5f * big->rest[i] - 100.0f; /* they share no vertex */
    kit_ok(ctx, set(scene, b, big));
    commit_does(scene, NULL, (counts){2, 0, 0});
    for (int i = 0; i < 2; i++) { /* both parts move */
        sheet_move(s, WAVE, 0.4f + 0.1f * (float)i);
        kit_ok(ctx, set(scene, g, s));
        big->now[7] += 100.0f;
        kit_ok(ctx, set(scene, b, big));
        commit_does(scene, NULL, (counts){0, 0, 2});
        hits_are_those_of_brute_force(scene, s, rays, hits, truth, TEST_MANY(RAYS));
        hits_are_those_of_brute_force(scene, big, rays, hits, truth, TEST_MANY(RAYS));
        tree_is_sound(scene);
    }
    free(s);
    free(big);
    free(rays);
    free(hits);
    free(truth);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

/* A child moves its own vertices; its parents see it from their next commit on. */
static void test_instances(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *child = kit_scene(ctx), *scene = kit_scene(ctx);
    rt_instance_desc place = rt_instance_desc_default();
    sheet *s = malloc(sizeof *s);
    rt_geometry g;
    rt_ray down = kit_ray(0.51f, 0.52f, 50, 0, 0, -1), beside = kit_ray(10.51f, 0.52f, 50, 0, 0, -1);
    (void)state;
    sheet_make(s);
    g = sheet_add(child, s);
    kit_commit(child);
    place.child = child;
    kit_ok(ctx, rt_scene_add_instance(scene, &place, NULL));
    place.transform = rt_transform_translate((rt_vec3){10, 0, 0});
    kit_ok(ctx, rt_scene_add_instance(scene, &place, NULL));
    kit_sphere(scene, 5, 0, 0, 1);
    kit_commit(scene);
    assert_true(kit_hit(scene, down).t == 50.0f);
    for (uint32_t i = 0; i < VERTICES; i++)
        s->now[3 * i + 2] = 0.5f;
    kit_ok(ctx, set(child, g, s));
    commit_does(child, NULL, refitted);
    assert_true(kit_hit(scene, down).t == 50.0f);
    commit_does(scene, NULL, (counts){1, 1, 0}); /* the top level; the sphere's tree is kept, the child's comes with it */
    assert_true(kit_hit(scene, down).t == 49.5f && kit_hit(scene, beside).t == 49.5f);
    free(s);
    rt_scene_destroy(scene);
    rt_scene_destroy(child);
    rt_context_destroy(ctx);
}

/* ---- the setter ---- */

static void test_refused(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx);
    sheet *s = malloc(sizeof *s);
    rt_geometry g, round;
    char before[33], after[33];
    rt_commit_desc d = rt_commit_desc_default();
    (void)state;
    sheet_make(s);
    g = sheet_add(scene, s);
    round = (rt_geometry){kit_sphere(scene, 0, 0, 3, 1)};
    kit_commit(scene);
    rt_scene_hash(scene, before);
    s->now[301] = NAN;
    KIT_REFUSED(ctx, set(scene, g, s), "rt_scene_set_mesh_positions: positions[100] (part 1) is nan");
    s->now[301] = -INFINITY;
    KIT_REFUSED(ctx, set(scene, g, s), "positions[100] (part 1) is -inf");
    s->now[301] = 2.0e12f;
    KIT_REFUSED(ctx, set(scene, g, s), "must be a number of size 1e+12 at most");
    s->now[301] = 0.0f;
    KIT_REFUSED(ctx, rt_scene_set_mesh_positions(scene, g, s->now, NULL, VERTICES - 1),
                "vertex_count is 1680, but the mesh has 1681 vertices");
    KIT_REFUSED(ctx, rt_scene_set_mesh_positions(scene, g, NULL, NULL, VERTICES), "positions is NULL");
    s->rest[5] = NAN;
    KIT_REFUSED(ctx, rt_scene_set_mesh_positions(scene, g, s->now, s->rest, VERTICES), "normals[1] (part 2) is nan");
    KIT_REFUSED(ctx, set(scene, round, s), "geometry 1 is no mesh and no polyhedron");
    KIT_REFUSED(ctx, set(scene, (rt_geometry){9}, s), "geometry 9 is not one of the scene");
    commit_does(scene, NULL, kept);
    rt_scene_hash(scene, after);
    assert_string_equal(before, after);
    d.refit = 0.5f;
    KIT_REFUSED(ctx, rt_scene_commit(scene, &d), "refit is 0.5; it must be 0 (trees are always built) or from 1 to 1e6");
    d.refit = NAN;
    KIT_REFUSED(ctx, rt_scene_commit(scene, &d), "refit is nan");
    free(s);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

/* Normals: given, kept, or new on a mesh that had none. Two scenes that share a mesh's arrays do not move each other's. */
static void test_normals(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx);
    float positions[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, normals[] = {1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0};
    uint32_t sizes[] = {4}, indices[] = {0, 1, 2, 3};
    rt_polyhedron_desc d = rt_polyhedron_desc_default();
    rt_ray ray = kit_ray(0.3f, 0.4f, 5, 0, 0, -1);
    rt_geometry g;
    rt_surface at;
    rt_hit hit;
    (void)state;
    d.positions = positions;
    d.vertex_count = 4;
    d.face_sizes = sizes;
    d.face_count = 1;
    d.indices = indices;
    d.index_count = 4;
    kit_ok(ctx, rt_scene_add_polyhedron(scene, &d, &g));
    kit_commit(scene);
    for (int i = 0; i < 4; i++)
        positions[3 * i + 2] = 1.0f;
    kit_ok(ctx, rt_scene_set_mesh_positions(scene, g, positions, normals, 4));
    kit_commit(scene);
    hit = kit_hit(scene, ray);
    rt_scene_surface(scene, &ray, &hit, &at);
    assert_true(hit.t == 4.0f && at.ns.x == 1.0f && at.face_id == 0);
    for (int i = 0; i < 4; i++)
        positions[3 * i + 2] = 2.0f;
    kit_ok(ctx, rt_scene_set_mesh_positions(scene, g, positions, NULL, 4));
    kit_commit(scene);
    hit = kit_hit(scene, ray);
    rt_scene_surface(scene, &ray, &hit, &at);
    assert_true(hit.t == 3.0f && at.ns.x == 1.0f);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

/* Normals from the triangles as they stand; a sum that no float holds becomes the face's; a mesh of nothing has none. */
static void test_smooth(void **state)
{
    rt_context *ctx = kit_context(NULL, 1);
    rt_scene *scene = kit_scene(ctx);
    rt_mesh_desc nothing = rt_mesh_desc_default();
    rt_geometry none, ball = {kit_sphere(scene, 0, 0, 9, 1)}, g;
    sheet *s = malloc(sizeof *s);
    rt_ray down = kit_ray(0.51f, 0.52f, 5, 0, 0, -1);
    rt_hit hit;
    rt_surface at;
    (void)state;
    sheet_make(s);
    g = sheet_add(scene, s);
    kit_ok(ctx, rt_scene_add_mesh(scene, &nothing, &none));
    kit_ok(ctx, rt_scene_smooth_mesh(scene, none));
    for (uint32_t i = 0; i < VERTICES; i++)
        s->now[3 * i + 2] = s->rest[3 * i] * s->rest[3 * i];
    kit_ok(ctx, set(scene, g, s));
    kit_ok(ctx, rt_scene_smooth_mesh(scene, g));
    kit_commit(scene);
    hit = kit_hit(scene, down);
    rt_scene_surface(scene, &down, &hit, &at);
    assert_float_equal(at.ns.x / at.ns.z, -2.0f * 0.51f, 0.002f); /* of z = x^2; that of a face is off by as much as 0.05 */
    for (float large = 1.0f; large < 1.0e12f; large *= 10.0f) {   /* a tilted sheet: components pass the bound one by one */
        rt_ray ray = kit_ray(0.51f * large, 0.52f * large, 5.0f * large, 0, 0, -1);
        for (uint32_t i = 0; i < VERTICES; i++) {
            s->now[3 * i] = large * s->rest[3 * i];
            s->now[3 * i + 1] = large * s->rest[3 * i + 1];
            s->now[3 * i + 2] = 0.01f * large * s->rest[3 * i];
        }
        kit_ok(ctx, set(scene, g, s));
        kit_ok(ctx, rt_scene_smooth_mesh(scene, g));
        kit_commit(scene);
        hit = kit_hit(scene, ray);
        rt_scene_surface(scene, &ray, &hit, &at);
        assert_float_equal(at.ns.x, -0.01f, 1.0e-4f);
        assert_float_equal(at.ns.z, 1.0f, 1.0e-4f);
    }
    KIT_REFUSED(ctx, rt_scene_smooth_mesh(scene, ball), "rt_scene_smooth_mesh: geometry 0 is no mesh and no polyhedron");
    KIT_REFUSED(ctx, rt_scene_smooth_mesh(scene, (rt_geometry){9}), "geometry 9 is not one of the scene");
    free(s);
    rt_scene_destroy(scene);
    rt_context_destroy(ctx);
}

/* Each allocation refused in turn: the call and the commit fail cleanly, and what was committed stays. */
static void test_no_memory(void **state)
{
    int refused = 0;
    sheet *s = malloc(sizeof *s);
    (void)state;
    sheet_make(s);
    for (long at = 1; at < 300; at++) {
        kit_memory memory = {0};
        rt_context *ctx = kit_context(&memory, 1);
        rt_scene *scene = kit_scene(ctx);
        rt_geometry g = sheet_add(scene, s);
        rt_ray down = kit_ray(0.51f, 0.52f, 50, 0, 0, -1);
        rt_status status;
        kit_commit(scene);
        for (uint32_t i = 0; i < VERTICES; i++)
            s->now[3 * i + 2] = 0.5f;
        atomic_store(&memory.fail_at, atomic_load(&memory.requests) + at);
        status = rt_scene_set_mesh_positions(scene, g, s->now, s->rest, VERTICES); /* normals: needs a new block */
        if (status == RT_OK)
            status = rt_scene_commit(scene, NULL);
        atomic_store(&memory.fail_at, 0);
        assert_true(status == RT_OK || status == RT_ERROR_MEMORY);
        assert_true(kit_hit(scene, down).t == (status == RT_OK ? 49.5f : 50.0f));
        rt_scene_destroy(scene);
        rt_context_destroy(ctx);
        assert_int_equal(atomic_load(&memory.blocks), 0);
        if (status == RT_OK)
            break;
        refused++;
    }
    assert_true(refused > 8 && refused < 290);
    free(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_hits),    cmocka_unit_test(test_workers),   cmocka_unit_test(test_choice),
        cmocka_unit_test(test_parts),   cmocka_unit_test(test_instances), cmocka_unit_test(test_refused),
        cmocka_unit_test(test_normals), cmocka_unit_test(test_smooth),    cmocka_unit_test(test_no_memory)};
    kit_level();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
