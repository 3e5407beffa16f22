/* Triangles for tests: generated, or read from the benchmark meshes (binary little-endian PLY of triangles, nothing else). */
#ifndef TEST_MESH_H
#define TEST_MESH_H

#include "accel/accel.h"

typedef struct test_mesh {
    rtk_tri *tris;
    uint32_t count, capacity;
} test_mesh;

/* A small reproducible stream of numbers. */
typedef struct test_rng {
    uint64_t state;
} test_rng;
uint32_t test_u32(test_rng *r);
float test_unit(test_rng *r); /* [0, 1) */
float test_range(test_rng *r, float lo, float hi);

void test_mesh_add(test_mesh *m, const float a[3], const float b[3], const float c[3]);
void test_mesh_free(test_mesh *m);
/* Reads $LIBRT_SCENES/name.ply; false when it is not there. */
bool test_mesh_load(test_mesh *m, const char *name);
/* Every vertex times scale, plus move on each axis. */
void test_mesh_place(test_mesh *m, float scale, float move);

/* Input for a builder over a mesh: bounds, growth. */
rti_build_input test_input(const test_mesh *m);
/* The same with boxes behind the triangles (lo xyz, hi xyz). */
rti_build_input test_input_boxes(const test_mesh *m, const float (*boxes)[6], uint32_t box_count);

#endif
