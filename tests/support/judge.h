/* Brute force for tests of many triangles: it leaves out those that a ray's line passes far off.
 *
 * The leaf test asks whether the line x = ox + sx (z - oz), y = oy + sy (z - oz) of a prepared ray goes through a triangle; origins
 * lie within 4 scale, slopes are at most 1, so the corners that it sees are off by less than 2e-6 scale. What is left out here
 * lies in boxes that the line misses, in doubles, by 1e-3 scale in x, y or z. Distances along the ray leave nothing out. Trees of
 * the library, their boxes, culling and order have no part in it; the leaf test is the library's, asked one by one. */
#ifndef TEST_JUDGE_H
#define TEST_JUDGE_H

#include "trace/trace.h"
#include "world.h"

typedef struct test_judge_far test_judge_far;

/* Closest hits of a scene's rays. */
typedef struct test_closest {
    const rtk_scene *scene;
    const rti_tracer *brute;
    test_judge_far *far; /* NULL: brute force answers all */
    uint32_t asked;
} test_closest;

/* By that where the scene has many triangles and nothing else, else by brute force. The scene stays as it is. */
void test_closest_open(test_closest *j, const rtk_scene *scene);
void test_closest_close(test_closest *j);
/* [count] rays' hits, as a tracer's. Of each 64 whole blocks, or fewer, one, another in each call, is brute force's to answer, too;
 * fails where it says otherwise. */
void test_closest_ask(test_closest *j, const rtk_trace_block *rays, rtk_hit_block *hits, uint32_t count);

#endif
