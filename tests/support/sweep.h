/* Every tracer against a judge: rays that try tracers, in batches, asked for in all ways. */
#ifndef TEST_SWEEP_H
#define TEST_SWEEP_H

#include "rays.h"

#define TEST_BATCH 1024u
#define TEST_STEPS 6 /* hits a ray steps through */

typedef struct test_batch {
    rtk_trace_block rays[TEST_BATCH / RTK_BLOCK];
    rtk_hit_block hits[TEST_BATCH / RTK_BLOCK], other[TEST_BATCH / RTK_BLOCK];
    /* of each step from hit to hit */
    rtk_hit_block from[TEST_STEPS][TEST_BATCH / RTK_BLOCK], next[TEST_STEPS][TEST_BATCH / RTK_BLOCK];
    uint16_t occluded[TEST_BATCH / RTK_BLOCK], occluded_other[TEST_BATCH / RTK_BLOCK];
    int kinds[TEST_BATCH];
    float times[TEST_BATCH]; /* of moving instances */
} test_batch;

/* Rays of all kinds. */
void test_batch_fill(test_batch *b, const test_targets *t, test_rng *rng);

/* Every tracer against the judge over `count` rays: closest and any hits and those behind one another, rays alone, in batches, in
 * beams and tiles. */
void test_sweep(const test_world *w, const rti_tracer *judge, uint64_t count, const char *what);
/* The closest hits alone of every tracer against brute force (of many triangles: against test_closest_ask, which leaves out what
 * is far), which is asked once a batch: `count` random rays and as many aimed ones. One batch of aimed rays in a hundred is of
 * denormal ones: they take brute force fifteen times as long as others. */
void test_sweep_closest(const test_world *w, uint64_t count, const char *what);

#endif
