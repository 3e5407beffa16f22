/* Geometry made up for tests: all of it in about [-1, 1]^3, the same for the same arguments. */
#ifndef TEST_GENERATE_H
#define TEST_GENERATE_H

#include "mesh.h"

/* Triangles anywhere, of about the given size. */
void test_mesh_soup(test_mesh *m, uint32_t count, float size, uint64_t seed);
/* A sphere of n rows of n bent quads, two triangles each, with hills and dales. */
void test_mesh_globe(test_mesh *m, uint32_t n);
/* Long thin triangles, some of no area. */
void test_mesh_slivers(test_mesh *m, uint32_t count);
/* Walls, floors and steps on a lattice of n x n, each of two triangles, some twice: coplanar neighbours, equal t. */
void test_mesh_lattice(test_mesh *m, int n);
/* n boxes around boxes, each 0.9 of the last. */
void test_mesh_nested(test_mesh *m, int n);
/* Spheres, boxes, cylinders, cones and tori by turns. Returns count. */
uint32_t test_shapes_of_all_kinds(rtk_shape *out, uint32_t count, uint64_t seed);
/* A 3x4 map with rotation, unequal scale (up to five times either way) and translation. */
void test_random_map(test_rng *r, float spread, float scale, float m[12]);

#endif
