/* Rays that try a tracer: random ones, and ones aimed where hits are easily lost. */
#ifndef TEST_RAYS_H
#define TEST_RAYS_H

#include "trace/trace.h"
#include "world.h"

/* What rays are aimed at: triangles in world space and the box of everything. */
typedef struct test_targets {
    test_mesh tris;
    float lo[3], hi[3], extent; /* extent: the longest side */
} test_targets;

/* The triangles of the scene and of its instances; boxes of shapes count into the bounds and give two triangles each. */
void test_targets_init(test_targets *t, const test_world *w);
void test_targets_free(test_targets *t);

enum {
    TEST_RAY_RANDOM,
    TEST_RAY_INSIDE, /* at a point of a triangle's inside */
    TEST_RAY_VERTEX,
    TEST_RAY_EDGE,
    TEST_RAY_AXIS,     /* along an axis, through a vertex or an edge's middle; zeros of either sign */
    TEST_RAY_COPLANAR, /* in a triangle's plane */
    TEST_RAY_ALONG,    /* along an edge */
    TEST_RAY_SURFACE,  /* starts on a triangle */
    TEST_RAY_FAR,      /* starts 10^4 extents away */
    TEST_RAY_RANGE,    /* tmin or tmax at or beside a hit */
    TEST_RAY_DENORMAL, /* tiny or unequal direction components */
    TEST_RAY_KINDS
};
/* Working memory for a tracer, this thread's. */
void *test_room(void);

rtk_ray test_ray(const test_targets *t, test_rng *rng, int kind);

#endif
