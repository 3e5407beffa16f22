/* Worlds of several parts, as a commit cuts geometry of several sizes (scene/group_parts.c), which test_world_commit does not. */
#ifndef TEST_PARTS_H
#define TEST_PARTS_H

#include "world.h"

typedef struct test_parts {
    test_mesh mesh[RTK_PARTS];
    rtk_u32 *list;
    void *chunks[RTK_PARTS][TEST_TREES];
    size_t sizes[RTK_PARTS][TEST_TREES];
} test_parts;

/* Soups to group 0 of a world that has no triangles, each `by` times the size of the one before and a part with trees of its own;
 * commits the world. size: as of test_mesh_soup. test_parts_free is due whatever it returns. */
rt_status test_parts_init(test_parts *p, test_world *w, uint32_t parts, float by, uint32_t triangles, float size);
void test_parts_free(test_parts *p, test_world *w); /* and the world */

#endif
