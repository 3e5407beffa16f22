/* Scenes made by hand for the tests of tracers: what the scene floor makes from a description, without it. */
#ifndef TEST_WORLD_H
#define TEST_WORLD_H

#include "mesh.h"
#include "trace/trace.h"

#define TEST_GROUPS 8
#define TEST_TREES  3
#define TEST_RAYS   10000u

/* The instruction set that RT_ISA asks for; ends the test as skipped where that does not run. */
rti_isa test_isa(void);
/* Brute force by the processor's best instructions: the judge of all others, at every level. */
const rti_tracer *test_judge(void);
/* All builders, the kd-tree's two first. */
#define TEST_BUILDERS 6
extern const uint32_t test_builders[TEST_BUILDERS];

/* Rays a scene: LIBRT_RAYS, or TEST_RAYS, or with LIBRT_FULL=1 two hundred thousand. */
uint64_t test_ray_count(void);
/* Rays of which closest hits alone are asked: LIBRT_CLOSEST, or none, or with LIBRT_FULL=1 ten million. */
uint64_t test_closest_count(void);
/* Whether rays a scene are fewer than TEST_RAYS, without LIBRT_FULL=1: half of what a test combines does then. */
bool test_fewer(void);

typedef struct test_group {
    test_mesh mesh;
    rtk_shape *shapes, *planes;
    rtk_geom *geoms;
    uint32_t shape_count, plane_count, geom_count;
    float (*boxes)[6]; /* of the shapes */
    void *chunks[TEST_TREES]; /* kd-tree, octree, BVH */
    size_t sizes[TEST_TREES];
} test_group;

typedef struct test_world {
    rt_context *ctx;
    test_group parts[TEST_GROUPS];
    rtk_group groups[TEST_GROUPS];
    rtk_instance *instances;
    uint32_t *unbounded;
    rtk_motion *motions;
    uint32_t motion_count;
    void *top_chunks[TEST_TREES];
    size_t top_sizes[TEST_TREES];
    uint32_t bvh_builder; /* RTI_BUILD_BVH*; 0: the default one */
    rtk_scene scene, by_kdtree, by_octree;
    rtk_group kdtree_groups[TEST_GROUPS], octree_groups[TEST_GROUPS];
} test_world;

/* Group 0 is the scene's own. */
void test_world_init(test_world *w, rt_context *ctx);
uint32_t test_world_group(test_world *w);
/* Each add is one geometry. The mesh's triangles are copied. */
void test_world_mesh(test_world *w, uint32_t group, const test_mesh *mesh, uint32_t mask);
void test_world_shapes(test_world *w, uint32_t group, const rtk_shape *shapes, uint32_t count, uint32_t mask);
void test_world_plane(test_world *w, uint32_t group, const float point[3], const float normal[3], uint32_t mask);
/* m: rows of a 3x4 map to the world. */
void test_world_instance(test_world *w, uint32_t group, const float m[12], uint32_t mask);
/* The last instance goes on to these places [count] of 12 floats; false: scene/motion.c refuses the way, and it stands still. */
bool test_world_move(test_world *w, const float (*m)[12], uint32_t count);
/* Bounds and trees (kd by the given settings; the others by their defaults). An exact kd-tree over triangles gets small cells if
 * nothing is said: in those that are usual a scene of a test would be one or two, and no triangle stand in many. */
rt_status test_world_commit(test_world *w, const rti_build_settings *kd);
/* What stands in the world's scene was changed by hand. */
void test_world_changed(test_world *w);
void test_world_free(test_world *w);

#endif
