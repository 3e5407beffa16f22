#include "world.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kernel/shapes.h"
#include "scene/scene.h"
#include "scene/snapshot.h"

const uint32_t test_builders[TEST_BUILDERS] = {RTI_BUILD_KD_EXACT, RTI_BUILD_KD_BINNED,   RTI_BUILD_OCTREE,
                                               RTI_BUILD_BVH,      RTI_BUILD_BVH_COMPACT, RTI_BUILD_BVH_SPATIAL};

static void *grown(void *data, size_t count, size_t item)
{
    void *p = realloc(data, count * item);
    if (!p)
        abort();
    return p;
}

rti_isa test_isa(void)
{
    static bool known;
    static rti_isa isa;
    char why[256];
    if (known)
        return isa;
    isa = rti_isa_choose(getenv("RT_ISA"), why, sizeof why);
    known = true;
    if (why[0]) {
        fprintf(stderr, "skipped: %s\n", why);
        exit(77);
    }
    return isa;
}

const rti_tracer *test_judge(void)
{
    return rti_tracer_find(rti_isa_best(), "brute");
}

static bool all_figures(void)
{
    const char *full = getenv("LIBRT_FULL");
    return full && full[0] == '1';
}

uint64_t test_ray_count(void)
{
    const char *n = getenv("LIBRT_RAYS");
    return n && *n ? strtoull(n, NULL, 10) : (all_figures() ? 20u : 1u) * (uint64_t)TEST_RAYS;
}

uint64_t test_closest_count(void)
{
    const char *n = getenv("LIBRT_CLOSEST");
    return n && *n ? strtoull(n, NULL, 10) : (all_figures() ? 10000000u : 0u);
}

bool test_fewer(void)
{
    return test_ray_count() < TEST_RAYS && !all_figures();
}

void test_world_init(test_world *w, rt_context *ctx)
{
    memset(w, 0, sizeof *w);
    w->ctx = ctx;
    w->scene.group_count = 1;
}

uint32_t test_world_group(test_world *w)
{
    if (w->scene.group_count == TEST_GROUPS)
        abort();
    return w->scene.group_count++;
}

static rtk_geom *add_geom(test_group *p, uint32_t type, uint32_t first, uint32_t count, uint32_t mask)
{
    p->geoms = grown(p->geoms, p->geom_count + 1, sizeof *p->geoms);
    rtk_geom *g = &p->geoms[p->geom_count++];
    memset(g, 0, sizeof *g);
    g->type = type;
    g->first = first;
    g->prim_count = count;
    g->mask = mask;
    g->uv_xfm[0] = g->uv_xfm[4] = 1.0f;
    return g;
}

void test_world_mesh(test_world *w, uint32_t group, const test_mesh *mesh, uint32_t mask)
{
    test_group *p = &w->parts[group];
    uint32_t first = p->mesh.count;
    for (uint32_t i = 0; i < mesh->count; i++) {
        const rtk_tri *t = &mesh->tris[i];
        test_mesh_add(&p->mesh, t->v0, t->v1, t->v2);
        p->mesh.tris[first + i].geom = p->geom_count;
        p->mesh.tris[first + i].prim = i;
    }
    add_geom(p, RTK_GEOM_MESH, first, mesh->count, mask);
}

void test_world_shapes(test_world *w, uint32_t group, const rtk_shape *shapes, uint32_t count, uint32_t mask)
{
    test_group *p = &w->parts[group];
    p->shapes = grown(p->shapes, p->shape_count + count, sizeof *p->shapes);
    p->boxes = grown(p->boxes, p->shape_count + count, sizeof *p->boxes);
    for (uint32_t i = 0; i < count; i++) {
        rtk_shape *s = &p->shapes[p->shape_count + i];
        rtk_vec3 lo, hi;
        *s = shapes[i];
        s->geom = p->geom_count;
        s->prim = i;
        rtk_shape_bounds(s, &lo, &hi);
        float box[6] = {lo.x, lo.y, lo.z, hi.x, hi.y, hi.z};
        memcpy(p->boxes[p->shape_count + i], box, sizeof box);
    }
    add_geom(p, RTK_GEOM_SHAPES, p->shape_count, count, mask);
    p->shape_count += count;
}

void test_world_plane(test_world *w, uint32_t group, const float point[3], const float normal[3], uint32_t mask)
{
    test_group *p = &w->parts[group];
    p->planes = grown(p->planes, p->plane_count + 1, sizeof *p->planes);
    rtk_shape *s = &p->planes[p->plane_count];
    float l = sqrtf(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    memset(s, 0, sizeof *s);
    s->type = RTK_SHAPE_PLANE;
    s->geom = p->geom_count;
    for (int a = 0; a < 3; a++) {
        s->p[a] = point[a];
        s->p[a + 4] = normal[a] / l;
    }
    add_geom(p, RTK_GEOM_PLANE, p->plane_count++, 1, mask);
}

static bool invert(const float m[12], float out[12])
{
    double c[9], det;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            int a = (j + 1) % 3, b = (j + 2) % 3, e = (i + 1) % 3, f = (i + 2) % 3;
            c[3 * i + j] = (double)m[4 * a + e] * m[4 * b + f] - (double)m[4 * a + f] * m[4 * b + e];
        }
    det = m[0] * c[0] + m[1] * c[3] + m[2] * c[6];
    for (int i = 0; i < 3; i++) {
        double t = 0.0;
        for (int j = 0; j < 3; j++) {
            out[4 * i + j] = (float)(c[3 * i + j] / det);
            t -= c[3 * i + j] / det * m[4 * j + 3];
        }
        out[4 * i + 3] = (float)t;
    }
    return det != 0.0;
}

void test_world_instance(test_world *w, uint32_t group, const float m[12], uint32_t mask)
{
    uint32_t n = w->scene.instance_count++;
    w->instances = grown(w->instances, n + 1, sizeof *w->instances);
    rtk_instance *inst = &w->instances[n];
    memset(inst, 0, sizeof *inst);
    memcpy(inst->to_world.m, m, sizeof inst->to_world.m);
    if (!invert(m, inst->to_object.m))
        abort();
    inst->group = group;
    inst->id = n;
    inst->mask = mask;
    inst->material = RTK_INVALID;
    if (w->parts[group].plane_count > 0) {
        inst->flags = RTK_INST_UNBOUNDED;
        w->unbounded = grown(w->unbounded, w->scene.unbounded_count + 1, sizeof *w->unbounded);
        w->unbounded[w->scene.unbounded_count++] = n;
    }
}

bool test_world_move(test_world *w, const float (*m)[12], uint32_t count)
{
    rtk_instance *inst = &w->instances[w->scene.instance_count - 1];
    rtk_xfm *keys = grown(NULL, count + 1, sizeof *keys);
    bool good;
    keys[0] = inst->to_world;
    memcpy(keys + 1, m, count * sizeof *keys);
    w->motions = grown(w->motions, w->motion_count + count, sizeof *w->motions);
    good = rti_motion_make(keys, count, w->motions + w->motion_count) == NULL;
    if (good) {
        inst->flags |= RTK_INST_MOVING;
        inst->motion_first = w->motion_count;
        inst->motion_count = count;
        w->motion_count += count;
    }
    free(keys);
    return good;
}

static rt_status build_all(test_world *w, const rti_build_input *in, const rti_build_settings *kd, void *chunks[TEST_TREES],
                           size_t sizes[TEST_TREES])
{
    rti_build_settings fine = kd ? *kd : (rti_build_settings){0};
    rti_build_settings octree = {.builder = RTI_BUILD_OCTREE, .leaf_size = 8};
    rti_build_settings bvh = {.builder = w->bvh_builder ? w->bvh_builder : RTI_BUILD_BVH};
    const rti_build_settings *settings[TEST_TREES] = {&fine, &octree, &bvh};
    rt_status status = RT_OK;
    if (fine.builder == RTI_BUILD_KD_EXACT && !(fine.cost_intersect > 0.0f) && in->box_count == 0)
        fine.cost_intersect = 0.0625f;
    for (int i = 0; i < TEST_TREES && status == RT_OK; i++)
        status = rti_tree_build(w->ctx, in, settings[i], NULL, &chunks[i], &sizes[i]);
    return status;
}

static rt_status commit_group(test_world *w, uint32_t index, const rti_build_settings *kd)
{
    test_group *p = &w->parts[index];
    rtk_group *g = &w->groups[index];
    rti_build_input in = test_input_boxes(&p->mesh, (const float(*)[6])p->boxes, p->shape_count);
    rt_status status = build_all(w, &in, kd, p->chunks, p->sizes);
    if (status != RT_OK)
        return status;
    g->lo = rtk_v3(in.lo[0], in.lo[1], in.lo[2]);
    g->hi = rtk_v3(in.hi[0], in.hi[1], in.hi[2]);
    g->tri_count = p->mesh.count;
    g->shape_count = p->shape_count;
    g->plane_count = p->plane_count;
    g->tris = p->mesh.tris;
    g->shapes = p->shapes;
    g->planes = p->planes;
    g->geoms = p->geoms;
    g->geom_count = p->geom_count;
    g->flags = rti_group_flags(p->geoms, p->geom_count); /* as a commit has it: the quickest ways are for plain groups */
    memset(g->parts, 0, sizeof g->parts);
    g->part_count = p->mesh.count + p->shape_count > 0;
    g->parts[0].lo = g->lo;
    g->parts[0].hi = g->hi;
    g->parts[0].scale = in.grow / RTK_GROW;
    g->parts[0].count = p->mesh.count + p->shape_count;
    g->parts[0].kdtree = rti_tree_view(p->chunks[0]);
    g->parts[0].octree = rti_tree_view(p->chunks[1]);
    g->parts[0].bvh = rti_tree_view(p->chunks[2]);
    return RT_OK;
}

/* World box of an instance; reach: the largest coordinate of the whole top level (the growth is that of rounding through the
 * maps). */
static void instance_box(const test_world *w, const rtk_instance *inst, double reach, float lo[3], float hi[3])
{
    const rtk_group *g = &w->groups[inst->group];
    const float *m = inst->to_world.m, *v = inst->to_object.m;
    float glo[3] = {g->lo.x, g->lo.y, g->lo.z}, ghi[3] = {g->hi.x, g->hi.y, g->hi.z};
    if (inst->flags & RTK_INST_MOVING) {
        const rtk_motion *way = w->motions + inst->motion_first;
        float by = rti_motion_growth(way, inst->motion_count, glo, ghi, (float)reach);
        rti_motion_bounds(way, inst->motion_count, glo, ghi, lo, hi);
        for (int r = 0; r < 3; r++) {
            lo[r] -= by;
            hi[r] += by;
        }
        return;
    }
    for (int r = 0; r < 3; r++) {
        double low = m[4 * r + 3], high = low, growth = 0.0;
        for (int c = 0; c < 3; c++) {
            double a = (double)m[4 * r + c] * glo[c], b = (double)m[4 * r + c] * ghi[c];
            double row = fabs(v[4 * c]) + fabs(v[4 * c + 1]) + fabs(v[4 * c + 2]);
            low += a < b ? a : b;
            high += a < b ? b : a;
            growth += fabs(m[4 * r + c]) * (40.0 * row * reach + 5.0 * fabs(v[4 * c + 3]));
        }
        growth = (growth * 1.5 + 4.0 * (fabs(low) + fabs(high))) * 0x1p-24;
        lo[r] = (float)(low - growth);
        hi[r] = (float)(high + growth);
    }
}

static rt_status commit_top(test_world *w, const rti_build_settings *kd)
{
    uint32_t n = w->scene.instance_count;
    float(*boxes)[6] = grown(NULL, n + 1, sizeof *boxes);
    double reach = 0.0;
    rti_build_input in;
    rt_status status;
    for (int pass = 0; pass < 2; pass++) {
        double found = 0.0;
        for (uint32_t i = 0; i < n; i++) {
            instance_box(w, &w->instances[i], 2.0 * reach, boxes[i], boxes[i] + 3);
            for (int a = 0; a < 6; a++)
                found = fmax(found, fabs(boxes[i][a]));
            memcpy(w->instances[i].lo, boxes[i], sizeof w->instances[i].lo);
            memcpy(w->instances[i].hi, boxes[i] + 3, sizeof w->instances[i].hi);
        }
        reach = found;
    }
    in = (rti_build_input){.boxes = (const float(*)[6])boxes, .box_count = n};
    for (int a = 0; a < 3; a++) {
        in.lo[a] = 3.0e38f;
        in.hi[a] = -3.0e38f;
    }
    w->scene.top_scale = 1.0e-30f;
    for (uint32_t i = 0; i < n; i++)
        for (int a = 0; a < 3; a++) {
            if (w->instances[i].flags & RTK_INST_UNBOUNDED) {
                boxes[i][a] = 1.0f;
                boxes[i][a + 3] = -1.0e30f; /* left out of the tree */
                continue;
            }
            in.lo[a] = rtk_min(in.lo[a], boxes[i][a]);
            in.hi[a] = rtk_max(in.hi[a], boxes[i][a + 3]);
            w->scene.top_scale = rtk_max(w->scene.top_scale, rtk_max(rtk_fabs(boxes[i][a]), rtk_fabs(boxes[i][a + 3])));
        }
    in.grow = RTK_GROW * w->scene.top_scale;
    for (int a = 0; a < 3; a++) {
        in.lo[a] -= in.grow;
        in.hi[a] += in.grow;
    }
    status = build_all(w, &in, kd, w->top_chunks, w->top_sizes);
    free(boxes);
    if (status != RT_OK)
        return status;
    w->scene.top_lo = rtk_v3(in.lo[0], in.lo[1], in.lo[2]);
    w->scene.top_hi = rtk_v3(in.hi[0], in.hi[1], in.hi[2]);
    w->scene.top_kdtree = rti_tree_view(w->top_chunks[0]);
    w->scene.top_octree = rti_tree_view(w->top_chunks[1]);
    w->scene.top_bvh = rti_tree_view(w->top_chunks[2]);
    return RT_OK;
}

rt_status test_world_commit(test_world *w, const rti_build_settings *kd)
{
    rt_status status = RT_OK;
    for (uint32_t i = 0; i < w->scene.group_count && status == RT_OK; i++)
        status = commit_group(w, i, kd);
    if (status == RT_OK)
        status = commit_top(w, kd);
    w->scene.groups = w->groups;
    w->scene.instances = w->instances;
    w->scene.unbounded = w->unbounded;
    w->scene.motions = w->motions;
    if (status == RT_OK)
        test_world_changed(w);
    return status;
}

void test_world_changed(test_world *w)
{
    w->scene.flags = rti_trace_flags(&w->scene);
    rti_trace_by(RTK_TREE_KD, &w->scene, &w->by_kdtree, w->kdtree_groups);
    rti_trace_by(RTK_TREE_OCTREE, &w->scene, &w->by_octree, w->octree_groups);
    w->scene.by_kdtree = &w->by_kdtree;
    w->scene.by_octree = &w->by_octree;
}

void test_world_free(test_world *w)
{
    for (int i = 0; i < TEST_GROUPS; i++) {
        test_group *p = &w->parts[i];
        test_mesh_free(&p->mesh);
        free(p->shapes);
        free(p->planes);
        free(p->geoms);
        free(p->boxes);
        for (int k = 0; k < TEST_TREES; k++)
            rti_free(w->ctx, p->chunks[k], p->sizes[k]);
    }
    free(w->instances);
    free(w->unbounded);
    free(w->motions);
    for (int k = 0; k < TEST_TREES; k++)
        rti_free(w->ctx, w->top_chunks[k], w->top_sizes[k]);
    memset(w, 0, sizeof *w);
}
